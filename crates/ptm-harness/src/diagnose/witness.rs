//! Compares the response to a case with the answer of a decoder that makes certain mistakes.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use super::mistake::Mistake;
use super::stream_cache::decode_stream_cached;
use super::tuning::{MIN_SUPPORT, is_most, is_nearly_all};
use crate::session::run::Run;
use ptm::decode::lookup_table::read_newline_separator;
use ptm::decode::{decode_as, fields_as};
use ptm::reading::Reading;
use ptm::{Field, Limits, Ptm};
use ptm_generate::Model;
use ptm_mistakes::{Anatomy, Change, EditedFile, Misreading, Stage};
use ptm_suite::cases::{Built, Case, Expect, Suite};
use ptm_suite::choices::{CHOICES, relevant_axes};
use ptm_suite::compare::{Expected, is_close};
use ptm_suite::dialect::{Dialect, RightDialects};
use ptm_suite::kit::parallel::map_in_parallel;
use ptm_suite::protocol::frame::{Answer, Frame, Samples, View, ViewKind};
use ptm_suite::values::Values;
use ptm_suite::verdicts::dialect::Certainty;
use ptm_suite::verdicts::judge::readings_text;
use ptm_suite::verdicts::observation::{Observation, Response};
use ptm_suite::verdicts::outcome::Outcome;

/// A judged case: its file, the decoder's response, and the correct answer.
pub(super) struct Witness<'a> {
    /// Index of the case in the suite.
    pub case_index: usize,
    pub case: &'a Case,
    pub observation: &'a Observation,
    pub built: Arc<Built>,
    /// Sections of the specification that do not apply to the file.
    pub unused_sections: Vec<&'static str>,
    pub failed: bool,
    /// Number of legal files of the same format that were asked.
    pub legal_files: usize,
    /// Number of these files whose cases are inconclusive.
    pub inconclusive_files: usize,
    /// Number of these files that failed with inconsistent responses or broken promises, and have no witness.
    pub inconsistent_files: usize,
    /// The dialect in which the decoder was judged. Mistakes are applied to it.
    pub reading: Reading,
    /// The reference's reading, if the case depends on an open question that the dialect answers differently. A mistake may look
    /// like a different answer.
    other_reading: Option<Reading>,
    /// Names the readings of this dialect that affect the answer and are not the reference's, as in "with
    /// motion-border: samples outside a plane are 128".
    pub own_readings: Option<String>,
    /// The reference's answer in this dialect.
    pub expected: Answer,
    /// The correct answer in `other_reading`.
    correct_in_other_reading: OnceLock<Option<Answer>>,
    /// The legal twin of a malformed file, if the decoder accepted the malformed file.
    twin_file: Option<Vec<u8>>,
    /// The image of the legal twin.
    twin_image: Option<Frame>,
    /// Fields of the file, up to the first error.
    fields: OnceLock<Vec<Field>>,
    pub facts: OnceLock<Facts>,
    /// The map decoded from the file under `reading`.
    decoded: OnceLock<ptm::error::Result<Ptm>>,
}

/// A property of a file: its clause and a text that completes "files …", separated by a space, and a flag that is true if the
/// file has the property.
pub(super) type Property = (&'static str, bool);

/// A numeric property of a file: the clause about it, a text in which {} stands for a phrase such as "at least 17", and the
/// value.
pub(super) type Quantity = (&'static str, &'static str, Option<f64>);

pub(super) struct Facts {
    pub properties: Vec<Property>,
    pub quantities: Vec<Quantity>,
}

/// The agreement of the answer of a decoder with certain mistakes with the response of the decoder under test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Agreement {
    /// A failing case: the images are equal.
    Image,
    /// A failing case: the images are equal, but all samples of the received image have the same value. Many mistakes produce such
    /// an image, so it supports none of them.
    BlankImage,
    /// A malformed file was accepted, and the images are equal, but they are also the image of the legal twin, so they do not show
    /// how the fault was read.
    TwinImage,
    /// Both are refusals, although the file may be decoded.
    Refusal,
    /// The answer is a refusal, and the decoder under test crashed, took too long or used too much memory.
    NoImage,
    /// The answer neither reproduces the response nor contradicts it.
    None,
    /// The response is that of a decoder without the mistakes, or an image although the answer is a refusal.
    Contradiction,
}

impl Agreement {
    /// Returns true if mistakes with this agreement reproduce the response to a failing case.
    pub fn explains(self) -> bool {
        !matches!(self, Agreement::None | Agreement::Contradiction)
    }
}

/// Returns a witness for every case that passed or failed, except cases with inconsistent responses or broken promises.
pub(super) fn witnesses<'a>(suite: &'a Suite, run: &'a Run, threads: usize) -> Vec<Witness<'a>> {
    let reading = dialect_reading(run);
    let mut reference = reading_in_dialect(run, &CHOICES.reference());
    let is_newline_guessed = run.table.newline && !run.shows_table_spelling(suite);
    if is_newline_guessed {
        reference.after_table = Reading::SPEC.after_table;
    }
    // Inconsistent responses and broken promises are no evidence for a misreading.
    let consistent_observation = |case_index: usize| {
        let case = &suite.cases[case_index];
        let observation = run.observations[case_index].as_ref();
        observation
            .filter(|observation| observation.nondeterminism.is_none())
            .filter(|observation| !breaks_promise(run, case, observation))
    };
    let mut legal_files: HashMap<_, [usize; 3]> = HashMap::new();
    for (case_index, case) in suite.cases.iter().enumerate() {
        let judged = run.judgment.cases[case_index].as_ref();
        let is_asked = run.observations[case_index].is_some();
        let Some(judged) = judged.filter(|_| is_asked && case.expect == Expect::Decode) else {
            continue;
        };
        let [all, inconclusive, inconsistent] = legal_files.entry(case.format()).or_default();
        *all += 1;
        *inconclusive += usize::from(judged.outcome == Outcome::Inconclusive);
        let is_consistent = || consistent_observation(case_index).is_some();
        *inconsistent += usize::from(judged.outcome == Outcome::Fail && !is_consistent());
    }
    let witness = |case_index: usize| {
        let case = &suite.cases[case_index];
        let outcome = run.judgment.cases[case_index].as_ref()?.outcome;
        let observation = consistent_observation(case_index)?;
        // Inconclusive and unsupported cases are no evidence either.
        if !matches!(outcome, Outcome::Pass | Outcome::Fail) {
            return None;
        }
        let built = case.build(run.table);
        let counts = legal_files.get(&case.format()).copied();
        let [legal_files, inconclusive_files, inconsistent_files] = counts.unwrap_or_default();
        let expected = ptm_mistakes::answer(&[], reading, &built.file, &observation.view);
        let depends = depends_on_dialect(case, &built, observation, run)
            || is_newline_guessed && case.format().has_table();
        let other_reading = depends.then_some(reference);
        let twin_file = twin_file(suite, run, case, observation);
        Some(Witness {
            case_index,
            case,
            observation,
            unused_sections: unused_sections(&built.file),
            built,
            failed: outcome == Outcome::Fail,
            legal_files,
            inconclusive_files,
            inconsistent_files,
            reading,
            other_reading,
            own_readings: match &observation.response {
                Response::Image { right, .. } => {
                    readings_text(&CHOICES, right.axes(), &inferred_dialect(run))
                }
                _ => None,
            },
            expected,
            correct_in_other_reading: OnceLock::new(),
            twin_image: twin_file
                .as_deref()
                .and_then(|file| twin_image(file, reading, observation)),
            twin_file,
            fields: OnceLock::new(),
            facts: OnceLock::new(),
            decoded: OnceLock::new(),
        })
    };
    let all = map_in_parallel(suite.cases.len(), threads, &|_, _| (), &witness);
    all.into_iter().flatten().collect()
}

/// Returns true if the decoder exited with 69 for a file in a format that it declares but never reads.
pub(super) fn breaks_promise(run: &Run, case: &Case, observation: &Observation) -> bool {
    run.offer
        .is_broken_by(case, observation, &run.judgment.unsupported)
}

impl Witness<'_> {
    /// Returns the answer of a decoder with these misreadings.
    pub fn answer_of_misreadings(&self, mistakes: &[&Misreading]) -> Cow<'_, Answer> {
        // Parse the file only once. Most edits of bytes do not change most files.
        let [first, rest @ ..] = mistakes else {
            return Cow::Borrowed(&self.expected);
        };
        if mistakes.iter().all(|mistake| is_after_decoding(mistake)) {
            return match self.decoded() {
                Ok(ptm) => {
                    let reading = ptm_mistakes::apply_to_reading(mistakes, self.reading);
                    let view = &self.observation.view;
                    Cow::Owned(ptm_mistakes::render(mistakes, &reading, ptm, view))
                }
                Err(_) => Cow::Borrowed(&self.expected),
            };
        }
        let Change::Bytes(edit) = first.change else {
            return Cow::Owned(self.answer_to_file(mistakes, &self.built.file));
        };
        match edit(&self.anatomy()) {
            EditedFile::Refused => Cow::Owned(Answer::Rejected),
            EditedFile::File(bytes) if bytes == self.built.file => self.answer_of_misreadings(rest),
            EditedFile::File(bytes) => Cow::Owned(self.answer_to_file(rest, &bytes)),
        }
    }

    /// Returns true if the response to a malformed file is the image that a decoder with these mistakes shows of its legal twin.
    pub fn has_image_of_twin(&self, mistakes: &[&Mistake]) -> bool {
        let (Some(file), Some(received)) = (&self.twin_file, self.wrong_image()) else {
            return false;
        };
        let answer = self.answer_in(self.reading, file, mistakes);
        matches!(answer, Answer::Decoded(image) if equal_up_to_rounding(&image, received))
    }

    fn answer_to_file(&self, mistakes: &[&Misreading], file: &[u8]) -> Answer {
        ptm_mistakes::answer(mistakes, self.reading, file, &self.observation.view)
    }

    /// Returns the answer of a decoder with these mistakes that otherwise follows the reference's reading, if it may differ.
    pub fn answer_in_other_reading(&self, mistakes: &[&Mistake]) -> Option<Answer> {
        let reading = self.other_reading?;
        Some(self.answer_in(reading, &self.built.file, mistakes))
    }

    /// Returns false if the mistake changes nothing in the reference's reading, so that it only undoes an answer to an open question.
    pub fn is_mistake_in_other_reading(&self, mistake: &Mistake) -> bool {
        self.other_reading.is_none()
            || self.answer_in_other_reading(&[mistake]) != self.answer_in_other_reading(&[])
    }

    /// Returns the fields of the file, up to the first error.
    pub fn fields(&self) -> &[Field] {
        self.fields
            .get_or_init(|| fields_as(&self.built.file, &self.reading))
    }

    /// Returns the image in the response if it differs from the reference's image.
    pub fn wrong_image(&self) -> Option<&Frame> {
        self.observation.response.wrong_image()
    }

    /// Returns true if the request was for colors.
    pub fn is_rgb(&self) -> bool {
        matches!(self.observation.view, View::Rgb(_))
    }

    /// Returns the map decoded from the file under `reading`.
    pub fn decoded(&self) -> &ptm::error::Result<Ptm> {
        self.decoded
            .get_or_init(|| decode_as(&self.built.file, &self.reading, &Limits::default()))
    }

    /// Returns the offset of the first byte after the header text.
    pub fn payload_offset(&self) -> usize {
        self.anatomy().payload_offset()
    }

    fn anatomy(&self) -> Anatomy<'_> {
        Anatomy {
            file: &self.built.file,
            fields: Cow::Borrowed(self.fields()),
        }
    }

    /// Returns the model from which the file was generated, if any.
    pub fn model(&self) -> Option<&Model> {
        match &self.built.values {
            Values::Painted(model) => Some(model),
            _ => None,
        }
    }

    /// Returns true if the plane is neither predicted nor corrected.
    pub fn is_plain_plane(&self, plane: usize) -> bool {
        let coded = self.model().and_then(|model| model.compressed.as_ref());
        coded.is_some_and(|coded| {
            coded.plan.reference(plane).is_none() && coded.planes[plane].records.is_empty()
        })
    }

    /// Returns true if the file need not be refused and the response is an image.
    pub fn is_permitted_image(&self) -> bool {
        let is_image = matches!(self.observation.response, Response::Image { .. });
        is_image && !self.case.expect.is_refusal()
    }

    /// Returns true if the file is legal and the response is an image.
    pub fn is_image_of_legal_file(&self) -> bool {
        self.is_permitted_image() && self.case.expect == Expect::Decode
    }

    /// Returns true if the response is an image of a legal file, and the image is evidence.
    pub fn is_telling_image(&self) -> bool {
        self.is_image_of_legal_file() && !self.is_blank_by_mistake()
    }

    /// Returns true if all samples of the received image are equal, although those of the correct image are not. Many mistakes
    /// produce such an image.
    pub fn is_blank_by_mistake(&self) -> bool {
        let received = self.wrong_image().and_then(uniform_value);
        let expected = match &self.expected {
            Answer::Decoded(frame) => uniform_value(frame),
            _ => None,
        };
        received.is_some() && expected.is_none()
    }

    /// Returns the agreement of `answer` with the response.
    pub fn agreement(&self, answer: &Answer) -> Agreement {
        if self.failed {
            self.agreement_with_failure(answer)
        } else {
            self.agreement_with_correct_response(answer)
        }
    }

    fn agreement_with_failure(&self, answer: &Answer) -> Agreement {
        let may_be_decoded = !self.case.expect.is_refusal();
        match (&self.observation.response, answer) {
            // A refusal is correct if the reference refuses the file as well.
            (_, Answer::Rejected) if self.expected == Answer::Rejected => Agreement::None,
            (
                Response::Image {
                    frame: Some(actual),
                    ..
                },
                Answer::Decoded(image),
            ) if equal_up_to_rounding(actual, image)
                && (actual == image || self.is_wrong(image))
                && !self.is_correct_in_other_reading(image)
                && (!self.equals_reference(image) || self.is_closer_to_response(image, actual))
                && self.is_significant_match(image, actual) =>
            {
                if self.is_blank_by_mistake() {
                    Agreement::BlankImage
                } else if self.twin_image.as_ref() == Some(actual) {
                    Agreement::TwinImage
                } else {
                    Agreement::Image
                }
            }
            (Response::Rejected, Answer::Rejected)
            | (Response::Unsupported, Answer::Unsupported) => Agreement::Refusal,
            // A decoder that exits with 69 does not take the file for malformed.
            (
                Response::Unsupported
                | Response::Violation(
                    Answer::Crashed(_) | Answer::TimedOut(_) | Answer::OutOfMemory(_),
                ),
                Answer::Rejected,
            ) if may_be_decoded => Agreement::NoImage,
            (Response::Image { .. }, Answer::Rejected | Answer::Unsupported) if may_be_decoded => {
                Agreement::Contradiction
            }
            _ => Agreement::None,
        }
    }

    fn agreement_with_correct_response(&self, answer: &Answer) -> Agreement {
        if *answer == self.expected {
            return Agreement::None;
        }
        let is_right = |image: &Frame| {
            self.equals_reference(image) && !self.is_shifted(image) || !self.would_fail(image)
        };
        match (self.case.expect, &self.observation.response, answer) {
            (Expect::Reject | Expect::Refuse, _, Answer::Decoded(_)) => Agreement::Contradiction,
            (Expect::Reject | Expect::Refuse, ..) => Agreement::None,
            (_, Response::Image { .. }, Answer::Decoded(image)) if is_right(image) => {
                Agreement::None
            }
            (_, Response::Image { .. }, _) => Agreement::Contradiction,
            (_, Response::Rejected, Answer::Rejected) => Agreement::Refusal,
            (_, Response::Rejected, Answer::Decoded(_)) if self.expected == Answer::Rejected => {
                Agreement::Contradiction
            }
            _ => Agreement::None,
        }
    }

    /// Returns false if two similar images may agree only because of the tolerance for colors. This is the case if all wrong
    /// colors are near 0 or 255 and many of these colors differ between the images, or if all wrong colors that are not near 0 or
    /// 255 differ by one in the same direction.
    fn is_significant_match(&self, image: &Frame, actual: &Frame) -> bool {
        let Answer::Decoded(right) = &self.expected else {
            return true;
        };
        let (Samples::U8(right), Samples::U8(image), Samples::U8(actual)) =
            (&right.samples, &image.samples, &actual.samples)
        else {
            return true;
        };
        if right.len() != actual.len() {
            return true;
        }
        let all = right.iter().zip(image.iter().zip(actual));
        let wrong = all.filter(|(right, (_, actual))| right.abs_diff(**actual) > 1);
        let wrong = wrong.map(|(_, (&image, &actual))| (image, actual));
        // Colors near 0 or 255 may be clamped.
        let (limits, others): (Vec<_>, Vec<_>) =
            wrong.partition(|&(_, actual)| actual <= 1 || actual >= 254);
        let equal = limits.iter().filter(|(a, b)| a == b).count();
        let all_differ_by = |offset: i16| {
            let mut offsets = others
                .iter()
                .map(|&(image, actual)| i16::from(actual) - i16::from(image));
            others.len() >= MIN_SUPPORT && offsets.all(|other| other == offset)
        };
        let is_at_limits =
            others.is_empty() && !limits.is_empty() && !is_nearly_all(equal, limits.len());
        !is_at_limits && !all_differ_by(1) && !all_differ_by(-1)
    }

    /// Returns true if `image` equals the response, or differs from it in fewer than half as many samples as the correct image.
    fn is_closer_to_response(&self, image: &Frame, actual: &Frame) -> bool {
        let (Samples::U8(samples), Answer::Decoded(right)) = (&actual.samples, &self.expected)
        else {
            return actual == image;
        };
        let count_differences = |other: &Frame| match &other.samples {
            Samples::U8(other) => other.iter().zip(samples).filter(|(a, b)| a != b).count(),
            Samples::F32(other) => other.len(),
        };
        let (own, reference) = (count_differences(image), count_differences(right));
        actual == image || is_most(reference.saturating_sub(own), reference)
    }

    /// Returns true if `image` equals the reference's image up to rounding, and therefore explains no failure.
    fn equals_reference(&self, image: &Frame) -> bool {
        matches!(&self.expected, Answer::Decoded(right) if equal_up_to_rounding(right, image))
    }

    /// Returns true if nearly all colors of `image` differ from those of the reference by one, in the same direction. Rounding
    /// down or up instead of to the nearest does not do this.
    fn is_shifted(&self, image: &Frame) -> bool {
        let Answer::Decoded(right) = &self.expected else {
            return false;
        };
        let (Samples::U8(right), Samples::U8(image)) = (&right.samples, &image.samples) else {
            return false;
        };
        // Colors near 0 or 255 may be clamped.
        let pairs = right
            .iter()
            .zip(image)
            .filter(|(right, _)| (2..254).contains(*right));
        let offsets: Vec<i16> = pairs.map(|(a, b)| i16::from(*b) - i16::from(*a)).collect();
        let count = |offset: i16| offsets.iter().filter(|&&one| one == offset).count();
        offsets.len() >= MIN_SUPPORT
            && (is_nearly_all(count(1), offsets.len()) || is_nearly_all(count(-1), offsets.len()))
    }

    /// Returns true if `image` is wrong. A correct image explains no failure, even if it equals the response up to rounding.
    fn is_wrong(&self, image: &Frame) -> bool {
        !matches!(self.expected, Answer::Decoded(_)) || self.would_fail(image)
    }

    /// Returns true if `image` is the one of a decoder without mistakes that follows the reference's reading.
    fn is_correct_in_other_reading(&self, image: &Frame) -> bool {
        let other = self
            .correct_in_other_reading
            .get_or_init(|| self.answer_in_other_reading(&[]));
        matches!(other, Some(Answer::Decoded(right)) if right == image)
    }

    /// Returns true if a decoder that outputs `image` would fail the case.
    fn would_fail(&self, image: &Frame) -> bool {
        let right = match (&self.observation.response, &self.expected) {
            // The image depends on an open question, so the decoder's own dialect determines the correct image.
            (
                Response::Image {
                    right: RightDialects::Depends { .. },
                    ..
                },
                Answer::Decoded(right),
            ) => return !equal_up_to_rounding(right, image),
            _ => Expected::new(&self.built.values, &self.observation.view),
        };
        right.is_some_and(|right| right.compare(image).is_some())
    }
}

pub(super) fn is_after_decoding(misreading: &Misreading) -> bool {
    misreading.stage() >= Stage::Planes
}

/// Returns the choices that were inferred for the decoder.
pub fn dialect_reading(run: &Run) -> Reading {
    reading_in_dialect(run, &inferred_dialect(run))
}

/// Returns the dialect of the decoder, with the reference's reading of questions that no answer settles.
pub(super) fn inferred_dialect(run: &Run) -> Dialect {
    let judgment = &run.judgment;
    let choices = judgment.dialect.0.iter().zip(&judgment.certainties);
    let inferred = choices.map(|(&reading, certain)| match certain {
        Certainty::Open => 0,
        _ => reading,
    });
    Dialect(inferred.collect())
}

/// Returns true if the correct image depends on an open question that the decoder answers differently from the reference.
fn depends_on_dialect(case: &Case, built: &Built, observation: &Observation, run: &Run) -> bool {
    let axes = relevant_axes(case, &built.values, &observation.view);
    axes.iter().any(|&axis| run.judgment.dialect.0[axis] != 0)
}

/// Returns the legal twin of a malformed file, if the decoder accepted the malformed file.
fn twin_file(suite: &Suite, run: &Run, case: &Case, observation: &Observation) -> Option<Vec<u8>> {
    observation.response.wrong_image()?;
    let twin = case.twin_of.as_ref().filter(|_| case.damage().is_some())?;
    Some(suite.case(twin)?.build(run.table).file.clone())
}

fn twin_image(file: &[u8], reading: Reading, observation: &Observation) -> Option<Frame> {
    match ptm_mistakes::answer(&[], reading, file, &observation.view) {
        Answer::Decoded(image) => Some(image),
        _ => None,
    }
}

pub(super) fn reading_in_dialect(run: &Run, dialect: &Dialect) -> Reading {
    let mut reading = CHOICES.apply(dialect, Reading::SPEC);
    reading.stream = decode_stream_cached;
    if run.table.newline {
        reading.after_table = read_newline_separator;
    }
    reading
}

/// Returns true if the misreading can affect the file. The clause of the misreading may apply only to files with a table, a
/// matrix or compressed planes.
#[must_use]
pub fn can_affect_file(misreading: &Misreading, file: &[u8]) -> bool {
    applies_to_file(misreading, &unused_sections(file))
}

/// Like [`can_affect_file`], for a file to which these sections of the specification do not apply.
pub(super) fn applies_to_file(misreading: &Misreading, unused_sections: &[&str]) -> bool {
    let mut unused = unused_sections.iter();
    matches!(misreading.change, Change::Bytes(_))
        || !unused.any(|section| misreading.clause.starts_with(section))
}

/// Returns the sections of the specification that do not apply to the file because of the name of its format.
fn unused_sections(file: &[u8]) -> Vec<&'static str> {
    let start = &file[..file.len().min(64)];
    let has = |word: &str| {
        let mut parts = start.windows(word.len());
        parts.any(|part| part == word.as_bytes())
    };
    if !has("PTM_FORMAT_") {
        return Vec::new();
    }
    let needed = [
        ("2.5", "LUT"),
        ("2.6", "RMAT_LUM"),
        ("2.8", "LUT"),
        ("2.9", "RMAT_JPEG"),
    ];
    let unused = needed.into_iter().filter(|(_, word)| !has(word));
    unused.map(|(section, _)| section).collect()
}

/// Returns true if a decoder can make both mistakes, that is, if they affect different steps or different decisions.
#[must_use]
pub fn can_combine(a: &Misreading, b: &Misreading) -> bool {
    !a.changes_same_step(b)
}

/// Returns true if two images are equal up to rounding.
#[must_use]
pub fn equal_up_to_rounding(a: &Frame, b: &Frame) -> bool {
    let tolerance = tolerance(a.view);
    a.shape() == b.shape()
        && match (&a.samples, &b.samples) {
            (Samples::U8(x), Samples::U8(y)) => {
                x.iter().zip(y).all(|(x, y)| x.abs_diff(*y) <= tolerance)
            }
            (Samples::F32(x), Samples::F32(y)) => {
                x.iter().zip(y).all(|(x, y)| are_equal_floats(*x, *y))
            }
            _ => false,
        }
}

/// Counts the samples in which two images are equal up to rounding. Returns 0 if their shapes differ.
pub(super) fn count_equal_samples(a: &Frame, b: &Frame) -> usize {
    if a.shape() != b.shape() {
        return 0;
    }
    match (&a.samples, &b.samples) {
        (Samples::U8(x), Samples::U8(y)) => {
            let tolerance = tolerance(a.view);
            let pairs = x.iter().zip(y);
            pairs.filter(|(x, y)| x.abs_diff(**y) <= tolerance).count()
        }
        (Samples::F32(x), Samples::F32(y)) => {
            let pairs = x.iter().zip(y);
            pairs.filter(|(x, y)| are_equal_floats(**x, **y)).count()
        }
        _ => 0,
    }
}

/// Returns the difference between bytes that are equal up to rounding.
fn tolerance(view: ViewKind) -> u8 {
    u8::from(view == ViewKind::Rgb)
}

/// Returns true if two floats are equal up to rounding, or both are NaN.
fn are_equal_floats(x: f32, y: f32) -> bool {
    // Floats with wrong bytes may be subnormal. They are not close to each other, or to 0.
    x == y
        || is_close(f64::from(x), f64::from(y), 0.0) && !x.is_subnormal() && !y.is_subnormal()
        || x.is_nan() && y.is_nan()
}

/// Returns true if two values are equal, or both are NaN.
pub(super) fn is_same_value(a: f64, b: f64) -> bool {
    a == b || a.is_nan() && b.is_nan()
}

/// Returns the value that all samples in an image share, if any.
pub(super) fn uniform_value(frame: &Frame) -> Option<f32> {
    fn uniform<T: Copy + Into<f32>>(samples: &[T]) -> Option<f32> {
        let first = (*samples.first()?).into();
        let mut values = samples.iter().map(|&sample| sample.into());
        values
            .all(|value| is_same_value(value.into(), first.into()))
            .then_some(first)
    }
    match &frame.samples {
        Samples::U8(samples) => uniform(samples),
        Samples::F32(samples) => uniform(samples),
    }
}
