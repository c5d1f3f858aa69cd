//! What a reader will show of a file.

use serde::Serialize;

use super::difference::Pictures;
use super::limits::{Marks, Struck};
use super::profile::ReaderProfile;
use crate::decode::decode;
use crate::error::Error;
use crate::formula::Edits;
use crate::misreadings::{self, At, Misreading};
use crate::ptm::Ptm;
use crate::reading::Reading;

/// What comes of opening a file with a reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Shown {
    /// The right picture under every light.
    Right,
    /// Another one; or a picture of a damaged file.
    Wrong,
    /// None: the reader refuses the file.
    Nothing,
}

impl Shown {
    /// In a word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Shown::Right => "right",
            Shown::Wrong => "wrong",
            Shown::Nothing => "nothing",
        }
    }
}

/// What a reader will show of a file, and why.
#[derive(Clone, Debug, Serialize)]
pub struct ReaderPrediction {
    /// The short name of the reader.
    pub reader: String,
    /// What it shows.
    pub shows: Shown,
    /// In which way the picture is wrong, as one sees it, or why there is none; empty where it is right.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub how: String,
    /// The misreadings that do it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub because: Vec<&'static str>,
    /// What the owner of the file can do about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fix: Option<String>,
}

/// A file, and the truth about it.
pub struct OpenedFile<'a> {
    file: &'a [u8],
    marks: Marks<'a>,
    truth: Result<Ptm, Error>,
}

/// What a reader makes of a file: planes and how it goes on reading, or why it refuses.
type Found = Result<(Ptm, Reading), Option<Error>>;

impl<'a> OpenedFile<'a> {
    /// The file, read as the reference does.
    #[must_use]
    pub fn of(file: &'a [u8]) -> OpenedFile<'a> {
        OpenedFile {
            file,
            marks: Marks::of(file),
            truth: decode(file),
        }
    }

    /// What the reader will show.
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
        let struck = profile.limits.iter();
        let struck: Vec<Struck> = struck
            .filter_map(|known| known.limit.strikes(&self.marks))
            .collect();
        if let Some(why) = struck.iter().find_map(|struck| match struck {
            Struck::Refused(why) => Some(*why),
            Struck::Wrong(_) => None,
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
        match (shows, struck.first()) {
            (Shown::Right, Some(Struck::Wrong(how))) => {
                says(Shown::Wrong, (*how).to_owned(), Vec::new())
            }
            _ => says(shows, how, because),
        }
    }

    /// What the reader shows, and how it is wrong.
    fn judge(
        &self,
        acting: &[&Misreading],
        found: Found,
        profile: &ReaderProfile,
    ) -> (Shown, String) {
        let (shown, reading) = match found {
            Ok(found) => found,
            Err(None) => return (Shown::Nothing, "it refuses the file".to_owned()),
            Err(Some(error)) => return (Shown::Nothing, format!("it refuses the file: {error}")),
        };
        let Ok(truth) = &self.truth else {
            return match profile.reads(shown.header.format) {
                true => (Shown::Wrong, "a picture of a damaged file".to_owned()),
                false => (
                    Shown::Nothing,
                    format!("it does not read {}", shown.header.format),
                ),
            };
        };
        let shown = edited(acting, shown);
        let edits = misreadings::edits_of(acting);
        match Pictures::new(truth, &shown, &reading, Edits(&edits)).difference() {
            None => (Shown::Right, String::new()),
            Some(how) => (Shown::Wrong, how),
        }
    }

    /// The misreadings of which each alone shows the same kind of thing; all, where it takes several.
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

/// The planes after the mistakes that a reader makes with them.
fn edited(acting: &[&Misreading], mut ptm: Ptm) -> Ptm {
    for one in acting {
        if let At::Planes(edit) = one.at {
            edit(&mut ptm);
        }
    }
    ptm
}
