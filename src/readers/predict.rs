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
    /// The right image under every light.
    Right,
    /// Another image; or an image of a damaged file.
    Wrong,
    /// No image: the reader refuses the file.
    Nothing,
}

impl Shown {
    /// Returns its name.
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
    /// The short name of the reader.
    pub reader: String,
    /// The result.
    pub shows: Shown,
    /// The visible fault of the image, or the reason why there is none; empty if it is right.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub how: String,
    /// The responsible misreadings.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub because: Vec<&'static str>,
    /// The suggested fix for the owner of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fix: Option<String>,
}

/// A file, and its right contents.
pub struct OpenedFile<'a> {
    file: &'a [u8],
    marks: Marks<'a>,
    truth: Result<Ptm, Error>,
}

/// The result of a reader for a file: planes and its further reading, or the reason why it refuses.
type ReaderResult = Result<(Ptm, Reading), Option<Error>>;

impl<'a> OpenedFile<'a> {
    /// Reads the file as the reference does.
    #[must_use]
    pub fn new(file: &'a [u8]) -> OpenedFile<'a> {
        OpenedFile {
            file,
            marks: Marks::new(file),
            truth: decode(file),
        }
    }

    /// Predicts the result of the reader.
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
            let how = format!("it does not read {}", ptm.header.format);
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
        let acting = profile.acting();
        let found = misreadings::read(&acting, Reading::SPEC, self.file);
        let (shows, how) = self.judge(&acting, found, profile);
        let because = match shows {
            Shown::Right => Vec::new(),
            _ => self.causes(&acting, shows, profile),
        };
        match (shows, effects.first()) {
            (Shown::Right, Some(Effect::Wrong(how))) => {
                says(Shown::Wrong, (*how).to_owned(), Vec::new())
            }
            _ => says(shows, how, because),
        }
    }

    /// Returns the result of the reader, and its fault.
    fn judge(
        &self,
        acting: &[&Misreading],
        found: ReaderResult,
        profile: &ReaderProfile,
    ) -> (Shown, String) {
        let (shown, reading) = match found {
            Ok(found) => found,
            Err(None) => return (Shown::Nothing, "it refuses the file".to_owned()),
            Err(Some(error)) => return (Shown::Nothing, format!("it refuses the file: {error}")),
        };
        let Ok(truth) = &self.truth else {
            return match profile.reads(shown.header.format) {
                true => (Shown::Wrong, "an image of a damaged file".to_owned()),
                false => (
                    Shown::Nothing,
                    format!("it does not read {}", shown.header.format),
                ),
            };
        };
        let shown = edited(acting, shown);
        let edits = misreadings::edits_of(acting);
        match ReaderImages::new(truth, &shown, &reading, Edits(&edits)).difference() {
            None => (Shown::Right, String::new()),
            Some(how) => (Shown::Wrong, how),
        }
    }

    /// Returns the misreadings that each alone have the same kind of result; all of them if several are needed.
    fn causes(
        &self,
        acting: &[&'static Misreading],
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
        let causes: Vec<&&'static Misreading> = acting.iter().filter(alone).collect();
        match causes.is_empty() {
            true => slugs(acting.iter().collect()),
            false => slugs(causes),
        }
    }
}

/// Returns the planes after the reader's mistakes with them.
fn edited(acting: &[&Misreading], mut ptm: Ptm) -> Ptm {
    for one in acting {
        if let At::Planes(edit) = one.at {
            edit(&mut ptm);
        }
    }
    ptm
}
