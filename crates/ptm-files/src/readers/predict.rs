//! Predictions of what a reader displays for a file.

use serde::Serialize;

use super::difference::ReaderImages;
use super::limits::{Effect, FileTraits};
use super::profile::ReaderProfile;
use ptm::decode::decode;
use ptm::error::Error;
use ptm::reading::Reading;
use ptm::{Format, Ptm};
use ptm_mistakes::formula::Edits;
pub use ptm_mistakes::{Misreading, formula_edits, plane_edits, read};

/// The result of opening a file with a reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Rendering {
    /// The correct image under every light.
    Right,
    /// A wrong image, or any image of a damaged file.
    Wrong,
    /// No image: the reader refuses the file.
    Nothing,
}

impl Rendering {
    /// Returns the name used in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Rendering::Right => "right",
            Rendering::Wrong => "wrong",
            Rendering::Nothing => "nothing",
        }
    }
}

/// A prediction for a reader and a file, with its reasons.
#[derive(Clone, Debug, Serialize)]
pub struct ReaderPrediction {
    /// Short name of the reader.
    pub reader: String,
    /// The result of opening the file.
    #[serde(rename = "shows")]
    pub result: Rendering,
    /// The visible fault of the image, or the reason why there is no image; empty if the image is correct.
    #[serde(rename = "how", skip_serializing_if = "String::is_empty")]
    pub fault: String,
    /// Slugs of the responsible misreadings.
    #[serde(rename = "because", skip_serializing_if = "Vec::is_empty")]
    pub misreadings: Vec<&'static str>,
    /// The suggested fix for the owner of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fix: Option<String>,
}

/// A file, and the result of decoding it correctly.
pub struct OpenedFile<'a> {
    file: &'a [u8],
    traits: FileTraits<'a>,
    truth: Result<Ptm, Error>,
}

impl<'a> OpenedFile<'a> {
    /// Decodes a file with the reference.
    #[must_use]
    pub fn new(file: &'a [u8]) -> OpenedFile<'a> {
        OpenedFile {
            file,
            traits: FileTraits::new(file),
            truth: decode(file),
        }
    }

    /// Predicts the result of opening this file with a reader.
    #[must_use]
    pub fn predict(&self, profile: &ReaderProfile) -> ReaderPrediction {
        let ((result, fault), misreadings) = self.result(profile);
        ReaderPrediction {
            reader: profile.name.clone(),
            result,
            fault,
            misreadings,
            fix: None,
        }
    }

    /// Returns the result of a reader, a description of the result, and the slugs of the responsible misreadings.
    fn result(&self, profile: &ReaderProfile) -> ((Rendering, String), Vec<&'static str>) {
        if let Ok(ptm) = &self.truth
            && !profile.reads(ptm.header.format)
        {
            return (unsupported(ptm.header.format), Vec::new());
        }
        let mut wrong = None;
        for known in &profile.limits {
            match known.limit.effect(&self.traits) {
                Some(Effect::Refused(why)) => {
                    return ((Rendering::Nothing, why.to_owned()), Vec::new());
                }
                Some(Effect::Wrong(how)) => wrong = wrong.or(Some(how)),
                None => {}
            }
        }
        let misreadings = profile.active_misreadings();
        let (shows, how) = self.judge(&misreadings, profile);
        match (shows, wrong) {
            (Rendering::Right, Some(how)) => ((Rendering::Wrong, how.to_owned()), Vec::new()),
            (Rendering::Right, None) => ((shows, how), Vec::new()),
            (Rendering::Nothing, _) if self.truth.is_err() => ((shows, how), Vec::new()),
            _ => {
                // The causes are the misreadings that alone lead to the same kind of result, or all misreadings if none does.
                let mut causes = misreadings.clone();
                causes.retain(|cause| self.judge(&[cause], profile).0 == shows);
                let causes = if causes.is_empty() {
                    misreadings
                } else {
                    causes
                };
                ((shows, how), causes.iter().map(|m| m.slug).collect())
            }
        }
    }

    /// Compares the result of a reader that has these misreadings with the correct result, and describes the fault.
    fn judge(&self, misreadings: &[&Misreading], profile: &ReaderProfile) -> (Rendering, String) {
        let (mut ptm, reading) = match read(misreadings, Reading::SPEC, self.file) {
            Ok(found) => found,
            // The position in the error may depend on the misreadings.
            Err(Some(error)) if self.truth.is_ok() => {
                let how = format!("the program refuses the file: {error}");
                return (Rendering::Nothing, how);
            }
            Err(_) => {
                let how = "the program refuses the file".to_owned();
                return (Rendering::Nothing, how);
            }
        };
        let Ok(truth) = &self.truth else {
            return match profile.reads(ptm.header.format) {
                true => (Rendering::Wrong, "an image of a damaged file".to_owned()),
                false => unsupported(ptm.header.format),
            };
        };
        for edit in plane_edits(misreadings) {
            edit(&mut ptm);
        }
        let edits = formula_edits(misreadings);
        match ReaderImages::new(truth, &ptm, &reading, Edits(&edits)).difference() {
            None => (Rendering::Right, String::new()),
            Some(how) => (Rendering::Wrong, how),
        }
    }
}

/// Returns the result of a reader for a file in a format that it does not read.
fn unsupported(format: Format) -> (Rendering, String) {
    let how = format!("the program does not read {format}");
    (Rendering::Nothing, how)
}
