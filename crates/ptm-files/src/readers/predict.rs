//! Predictions of what a reader displays for a file.

use serde::Serialize;

use super::difference::{EvaluatedMap, ImageDifference};
use super::limits::{Effect, FileTraits};
use super::profile::{Evidence, ReaderProfile, UnusualBehavior, UnusualResult};
use super::unusual::UnusualKind;
use crate::dissection::Dissection;
use crate::lint::damage::payload_damage;
use ptm::decode::examine;
use ptm::error::Error;
use ptm::reading::Reading;
use ptm::{Format, Ptm};
use ptm_mistakes::Stage;
use ptm_mistakes::formula::Edits;
pub use ptm_mistakes::{Misreading, formula_edits, plane_edits, read};

/// The result of opening a file with a reader, from the best to the unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rendering {
    /// The correct image under every light.
    Same,
    /// An image whose colors differ by at most 2 of 255 under every tested light.
    #[serde(rename = "nearly-the-same")]
    NearlySame,
    /// An image that is visibly wrong, or any image of a damaged file.
    #[serde(rename = "visibly-wrong")]
    Wrong,
    /// No image: the reader refuses the file.
    Nothing,
    /// Unknown: nobody has tried, or read in the source, what the reader does with such a file.
    NotPredicted,
}

impl Rendering {
    /// Returns the name used in machine-readable output.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Rendering::Same => "same",
            Rendering::NearlySame => "nearly-the-same",
            Rendering::Wrong => "visibly-wrong",
            Rendering::Nothing => "nothing",
            Rendering::NotPredicted => "not-predicted",
        }
    }

    /// Returns the name used in text.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Rendering::Same => "same",
            Rendering::NearlySame => "nearly the same",
            Rendering::Wrong => "visibly wrong",
            Rendering::Nothing => "nothing",
            Rendering::NotPredicted => "not predicted",
        }
    }

    /// Returns true if a person sees the correct image.
    #[must_use]
    pub const fn is_right(self) -> bool {
        matches!(self, Rendering::Same | Rendering::NearlySame)
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
    /// The largest difference of a color, of 255, over [`LIGHTS`](super::LIGHTS); `None` if no images were compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub largest_difference: Option<u8>,
    /// Share of the texels that differ visibly (by more than 2 of 255) under any of these lights; `None` if no images were
    /// compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub visible_share: Option<f64>,
    /// The visible fault of the image, or the reason why there is no image or no prediction; empty if the image is correct.
    #[serde(rename = "how", skip_serializing_if = "String::is_empty")]
    pub fault: String,
    /// Slugs of the responsible misreadings.
    #[serde(rename = "because", skip_serializing_if = "Vec::is_empty")]
    pub misreadings: Vec<&'static str>,
    /// Evidence for the behavior of the reader; `None` if nothing is predicted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evidence: Option<Evidence>,
    /// The suggested fix for the owner of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fix: Option<String>,
}

impl ReaderPrediction {
    /// Names of the cells that [`cells`](ReaderPrediction::cells) returns.
    pub const COLUMNS: [&'static str; 6] = [
        "shows",
        "largest difference",
        "visible share",
        "how",
        "evidence",
        "fix",
    ];

    /// Returns the cells of a table for this prediction. The cells of absent values are empty.
    #[must_use]
    pub fn cells(&self) -> [String; 6] {
        let largest = self.largest_difference.map(|largest| largest.to_string());
        let share = self.visible_share.map(|share| format!("{share:.4}"));
        let evidence = self.evidence.map(|evidence| evidence.name().to_owned());
        [
            self.result.name().to_owned(),
            largest.unwrap_or_default(),
            share.unwrap_or_default(),
            self.fault.clone(),
            evidence.unwrap_or_default(),
            self.fix.clone().unwrap_or_default(),
        ]
    }

    /// Creates a prediction without images.
    fn without_images(result: Rendering, fault: String) -> ReaderPrediction {
        ReaderPrediction {
            reader: String::new(),
            result,
            largest_difference: None,
            visible_share: None,
            fault,
            misreadings: Vec::new(),
            evidence: None,
            fix: None,
        }
    }

    /// Creates the prediction for a damaged file that the reader opens.
    fn of_damage() -> ReaderPrediction {
        let how = "an image of a damaged file".to_owned();
        ReaderPrediction::without_images(Rendering::Wrong, how)
    }

    /// Creates the prediction for a file that the evidence does not cover.
    fn unknown(why: impl Into<String>) -> ReaderPrediction {
        ReaderPrediction::without_images(Rendering::NotPredicted, why.into())
    }

    fn with_evidence(self, evidence: Evidence) -> ReaderPrediction {
        let evidence = Some(evidence);
        ReaderPrediction { evidence, ..self }
    }
}

/// A file, and the result of decoding it correctly.
pub struct OpenedFile<'a> {
    file: &'a [u8],
    traits: FileTraits<'a>,
    truth: Result<Ptm, Error>,
    /// The kind of the file, if the reference refuses it.
    kind: Option<UnusualKind>,
    /// True if the reference reads the file, but its values are damaged.
    has_damaged_values: bool,
}

impl<'a> OpenedFile<'a> {
    /// Decodes a file with the reference.
    #[must_use]
    pub fn new(file: &'a [u8]) -> OpenedFile<'a> {
        let (fields, truth) = examine(file);
        let dissection = Dissection::new(file, &fields, truth);
        OpenedFile {
            file,
            kind: UnusualKind::new(&dissection),
            has_damaged_values: payload_damage(&dissection).is_some(),
            traits: FileTraits::new(file, fields, &dissection.outcome),
            truth: dissection.outcome,
        }
    }

    /// Returns the kind of the file, if the reference refuses it and some readers open it.
    #[must_use]
    pub fn kind(&self) -> Option<UnusualKind> {
        self.kind
    }

    /// Predicts the result of opening this file with a reader.
    #[must_use]
    pub fn predict(&self, profile: &ReaderProfile) -> ReaderPrediction {
        let format = self.format_of_any_version();
        let unsupported = format.filter(|&format| !profile.reads(format));
        let prediction = match (&self.truth, unsupported) {
            (_, Some(format)) => {
                let how = format!("the program does not read {format}");
                ReaderPrediction::without_images(Rendering::Nothing, how)
                    .with_evidence(profile.evidence)
            }
            (Ok(truth), None) => self.predict_legal(truth, profile),
            (Err(_), None) => self.predict_refused(profile),
        };
        let reader = profile.name.clone();
        let shows_image = prediction.result.is_right() || prediction.result == Rendering::Wrong;
        let prediction = match prediction.evidence {
            Some(evidence) if self.has_damaged_values && shows_image => {
                ReaderPrediction::of_damage().with_evidence(evidence)
            }
            _ => prediction,
        };
        ReaderPrediction {
            reader,
            ..prediction
        }
    }

    /// Predicts the result for a file that the reference reads.
    fn predict_legal(&self, truth: &Ptm, profile: &ReaderProfile) -> ReaderPrediction {
        if let Some(refusal) = self.refusal(profile) {
            return refusal;
        }
        let misreadings = profile.active_misreadings();
        let mut prediction = self.judge(&misreadings, truth);
        if prediction.result.is_right()
            && let Some((how, evidence)) = self.faults(profile).next()
        {
            return ReaderPrediction::without_images(Rendering::Wrong, how.to_owned())
                .with_evidence(evidence);
        }
        if prediction.result != Rendering::Same {
            prediction.misreadings = self.causes(&misreadings, truth, prediction.result);
        }
        let evidence = profile.evidence_for(&prediction.misreadings);
        prediction.with_evidence(evidence)
    }

    /// Returns the prediction for a file that exceeds a limit of the reader and is refused.
    fn refusal(&self, profile: &ReaderProfile) -> Option<ReaderPrediction> {
        profile.limits.iter().find_map(|known| {
            let Effect::Refused(why) = known.limit.effect(&self.traits)? else {
                return None;
            };
            let prediction = ReaderPrediction::without_images(Rendering::Nothing, why.to_owned());
            Some(prediction.with_evidence(known.evidence))
        })
    }

    /// Returns the faults that are due to limits of the reader, with the evidence.
    fn faults(&self, profile: &ReaderProfile) -> impl Iterator<Item = (&'static str, Evidence)> {
        let limits = profile.limits.iter();
        limits.filter_map(|known| match known.limit.effect(&self.traits)? {
            Effect::Wrong(how) => Some((how, known.evidence)),
            Effect::Refused(_) => None,
        })
    }

    /// Returns the misreadings that alone lead to the same kind of result, or all misreadings if none does.
    fn causes(
        &self,
        misreadings: &[&'static Misreading],
        truth: &Ptm,
        result: Rendering,
    ) -> Vec<&'static str> {
        let slugs =
            |misreadings: &[&'static Misreading]| misreadings.iter().map(|m| m.slug).collect();
        if misreadings.len() == 1 {
            return slugs(misreadings);
        }
        let mut causes = misreadings.to_vec();
        causes.retain(|&cause| self.judge(&[cause], truth).result == result);
        slugs(if causes.is_empty() {
            misreadings
        } else {
            &causes
        })
    }

    /// Compares the result of a reader that has these misreadings with the correct result, and describes the fault.
    fn judge(&self, misreadings: &[&Misreading], truth: &Ptm) -> ReaderPrediction {
        let (mut ptm, reading) = match read(misreadings, Reading::SPEC, self.file) {
            Ok(found) => found,
            Err(error) => {
                // The position in the error may depend on the misreadings.
                let error = error.map_or_else(String::new, |error| format!(": {error}"));
                let how = format!("the program refuses the file{error}");
                return ReaderPrediction::without_images(Rendering::Nothing, how);
            }
        };
        for edit in plane_edits(misreadings) {
            edit(&mut ptm);
        }
        let is_evaluated_alike = misreadings.iter().all(|misreading| {
            misreading.stage() <= Stage::Planes && misreading.formulas().is_empty()
        });
        if is_evaluated_alike && ptm == *truth {
            return ReaderPrediction {
                largest_difference: Some(0),
                visible_share: Some(0.0),
                ..ReaderPrediction::without_images(Rendering::Same, String::new())
            };
        }
        let has_same_header = ptm.header == truth.header && ptm.planes.shape == truth.planes.shape;
        let edits = formula_edits(misreadings);
        let correct = EvaluatedMap {
            ptm: truth,
            reading: &Reading::SPEC,
            edits: Edits(&[]),
        };
        let shown = EvaluatedMap {
            ptm: &ptm,
            reading: &reading,
            edits: Edits(&edits),
        };
        let difference =
            ImageDifference::new(correct, shown, is_evaluated_alike && has_same_header);
        let result = match () {
            () if difference.is_none() => Rendering::Same,
            () if !difference.is_visible() => Rendering::NearlySame,
            () => Rendering::Wrong,
        };
        ReaderPrediction {
            largest_difference: Some(difference.largest()),
            visible_share: Some(difference.visible_share),
            ..ReaderPrediction::without_images(result, difference.describe(correct, shown))
        }
    }

    /// Predicts the result for a file that the reference refuses. Only what is known about files of this kind is predicted.
    fn predict_refused(&self, profile: &ReaderProfile) -> ReaderPrediction {
        if let Some(kind) = self.kind
            && let Some(behavior) = profile.behavior(kind, self.format_of_any_version())
        {
            return self.predict_unusual(kind, behavior, profile);
        }
        let misreadings = profile.active_misreadings();
        match read(&misreadings, Reading::SPEC, self.file) {
            Ok((ptm, _)) if profile.reads(ptm.header.format) => {
                self.predict_damaged(&misreadings, profile)
            }
            _ => ReaderPrediction::unknown(match self.kind {
                Some(kind) => format!("no evidence about files {}", kind.label()),
                None => "no evidence about files with this damage".to_owned(),
            }),
        }
    }

    /// Predicts the result for a file that the reference refuses, but a reader with these misreadings opens.
    fn predict_damaged(
        &self,
        misreadings: &[&'static Misreading],
        profile: &ReaderProfile,
    ) -> ReaderPrediction {
        let mut causes = misreadings.to_vec();
        causes.retain(|&cause| read(&[cause], Reading::SPEC, self.file).is_ok());
        let causes: Vec<&str> = causes.iter().map(|misreading| misreading.slug).collect();
        let evidence = profile.evidence_for(&causes);
        let stand_in = self
            .kind
            .and_then(|kind| kind.stand_in(&Dissection::parse(self.file)));
        let prediction = match stand_in.filter(|made| made.is_exact) {
            Some(made) => {
                let legal = OpenedFile::new(&made.bytes);
                let judge = || match &legal.truth {
                    Ok(truth) if !legal.has_damaged_values => Some(self.judge(misreadings, truth)),
                    _ => None,
                };
                legal.refusal(profile).or_else(judge)
            }
            None => None,
        };
        let prediction = prediction.unwrap_or_else(ReaderPrediction::of_damage);
        ReaderPrediction {
            misreadings: causes,
            ..prediction
        }
        .with_evidence(evidence)
    }

    /// Predicts the result for a file of a kind about which the profile has a row.
    fn predict_unusual(
        &self,
        kind: UnusualKind,
        behavior: &UnusualBehavior,
        profile: &ReaderProfile,
    ) -> ReaderPrediction {
        let evidence = behavior.evidence;
        let fault = match behavior.fault.as_str() {
            "" => format!("a file {}", kind.label()),
            fault => fault.to_owned(),
        };
        let prediction = match behavior.shows {
            UnusualResult::Nothing => ReaderPrediction::without_images(Rendering::Nothing, fault),
            UnusualResult::Wrong => ReaderPrediction::without_images(Rendering::Wrong, fault),
            UnusualResult::Same => self.predict_stand_in(kind, profile),
        };
        let causes = profile.evidence_for(&prediction.misreadings);
        match prediction.result {
            Rendering::NotPredicted => prediction,
            _ if prediction.misreadings.is_empty() => prediction.with_evidence(evidence),
            _ => prediction.with_evidence(evidence.max(causes)),
        }
    }

    /// Predicts the result for the legal file that corresponds to this file.
    fn predict_stand_in(&self, kind: UnusualKind, profile: &ReaderProfile) -> ReaderPrediction {
        let Some(made) = kind.stand_in(&Dissection::parse(self.file)) else {
            return ReaderPrediction::unknown(format!("a file {} with other faults", kind.label()));
        };
        let prediction = OpenedFile::new(&made.bytes).predict(profile);
        if made.is_exact {
            return prediction;
        }
        if !prediction.result.is_right() {
            return ReaderPrediction::unknown(format!(
                "the program opens files {}, but it may show this map wrong",
                kind.label()
            ));
        }
        // The numbers are those of other values.
        ReaderPrediction {
            largest_difference: None,
            visible_share: None,
            fault: String::new(),
            ..prediction
        }
    }

    /// Returns the format that the second line names, also in a version or with a line end that the reference refuses.
    fn format_of_any_version(&self) -> Option<Format> {
        let mut lines = self.file.splitn(3, |&byte| byte == b'\n').skip(1);
        let name = lines.next()?.trim_ascii_end();
        let mut formats = Format::ALL.into_iter();
        formats.find(|format| format.name().as_bytes() == name)
    }
}
