//! Predictions of the results of a reader for a file.

use serde::Serialize;

use super::difference::ReaderImages;
use super::limits::{Effect, Marks};
use super::profile::ReaderProfile;
use crate::decode::decode;
use crate::error::Error;
use crate::formula::Edits;
use crate::misreadings::{self, At, Misreading};
use crate::ptm::Ptm;
use crate::reading::Reading;

/// The result of opening a file with a reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Shown {
    /// The correct image under every light.
    Right,
    /// A wrong image, or any image of a damaged file.
    Wrong,
    /// No image: the reader refuses the file.
    Nothing,
}

impl Shown {
    /// Returns the name used in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Shown::Right => "right",
            Shown::Wrong => "wrong",
            Shown::Nothing => "nothing",
        }
    }
}

/// A prediction for a reader and a file, with its reasons.
#[derive(Clone, Debug, Serialize)]
pub struct ReaderPrediction {
    /// Short name of the reader.
    pub reader: String,
    /// The result.
    pub shows: Shown,
    /// The visible fault of the image, or the reason why there is no image; empty if the image is correct.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub how: String,
    /// Slugs of the responsible misreadings.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub because: Vec<&'static str>,
    /// The suggested fix for the owner of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fix: Option<String>,
}

/// A file and its correct contents.
pub struct OpenedFile<'a> {
    file: &'a [u8],
    marks: Marks<'a>,
    truth: Result<Ptm, Error>,
}

/// Result of a reader for a file: planes and the reading of the later stages, or the reason for a refusal.
type ReaderResult = Result<(Ptm, Reading), Option<Error>>;

impl<'a> OpenedFile<'a> {
    /// Decodes a file with the reference.
    #[must_use]
    pub fn new(file: &'a [u8]) -> OpenedFile<'a> {
        OpenedFile {
            file,
            marks: Marks::new(file),
            truth: decode(file),
        }
    }

    /// Predicts the result of a reader for this file.
    #[must_use]
    pub fn predict(&self, profile: &ReaderProfile) -> ReaderPrediction {
        let says = |shows, how: String, because| ReaderPrediction {
            reader: profile.name.clone(),
            shows,
            how,
            because,
            fix: None,
        };
        if let Ok(ptm) = &self.truth
            && !profile.reads(ptm.header.format)
        {
            let how = format!("the program does not read {}", ptm.header.format);
            return says(Shown::Nothing, how, Vec::new());
        }
        let limits = profile.limits.iter();
        let effects: Vec<Effect> = limits
            .filter_map(|known| known.limit.effect(&self.marks))
            .collect();
        if let Some(why) = effects.iter().find_map(|effect| match effect {
            Effect::Refused(why) => Some(*why),
            Effect::Wrong(_) => None,
        }) {
            return says(Shown::Nothing, why.to_owned(), Vec::new());
        }
        let active_misreadings = profile.active_misreadings();
        let found = misreadings::read(&active_misreadings, Reading::SPEC, self.file);
        let (shows, how) = self.judge(&active_misreadings, found, profile);
        let because = match shows {
            Shown::Right => Vec::new(),
            _ => self.causes(&active_misreadings, shows, profile),
        };
        match (shows, effects.first()) {
            (Shown::Right, Some(Effect::Wrong(how))) => {
                says(Shown::Wrong, (*how).to_owned(), Vec::new())
            }
            _ => says(shows, how, because),
        }
    }

    /// Compares the result of the reader with the correct one, and describes the fault.
    fn judge(
        &self,
        active_misreadings: &[&Misreading],
        found: ReaderResult,
        profile: &ReaderProfile,
    ) -> (Shown, String) {
        let (shown, reading) = match found {
            Ok(found) => found,
            Err(None) => return (Shown::Nothing, "the program refuses the file".to_owned()),
            Err(Some(error)) => {
                return (
                    Shown::Nothing,
                    format!("the program refuses the file: {error}"),
                );
            }
        };
        let Ok(truth) = &self.truth else {
            return match profile.reads(shown.header.format) {
                true => (Shown::Wrong, "an image of a damaged file".to_owned()),
                false => (
                    Shown::Nothing,
                    format!("the program does not read {}", shown.header.format),
                ),
            };
        };
        let shown = apply_to_planes(active_misreadings, shown);
        let edits = misreadings::formula_edits(active_misreadings);
        match ReaderImages::new(truth, &shown, &reading, Edits(&edits)).difference() {
            None => (Shown::Right, String::new()),
            Some(how) => (Shown::Wrong, how),
        }
    }

    /// Returns the misreadings that alone give the same kind of result, or all misreadings if none does alone.
    fn causes(
        &self,
        active_misreadings: &[&'static Misreading],
        shows: Shown,
        profile: &ReaderProfile,
    ) -> Vec<&'static str> {
        let alone = |one: &&&'static Misreading| {
            let found = misreadings::read(&[**one], Reading::SPEC, self.file);
            self.judge(&[**one], found, profile).0 == shows
        };
        let slugs =
            |these: Vec<&&'static Misreading>| these.into_iter().map(|one| one.slug).collect();
        if self.truth.is_err() && shows == Shown::Nothing {
            return Vec::new();
        }
        let causes: Vec<&&'static Misreading> = active_misreadings.iter().filter(alone).collect();
        match causes.is_empty() {
            true => slugs(active_misreadings.iter().collect()),
            false => slugs(causes),
        }
    }
}

/// Applies the misreadings that change planes.
fn apply_to_planes(active_misreadings: &[&Misreading], mut ptm: Ptm) -> Ptm {
    for one in active_misreadings {
        if let At::Planes(edit) = one.at {
            edit(&mut ptm);
        }
    }
    ptm
}
