//! What a decoder with some mistakes would answer, held against what the decoder under test did answer.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, Mutex, OnceLock};

use super::promises;
use super::traits::{Traits, traits};
use crate::codec;
use crate::decode::{Limits, Ptm, decode_as, examine_as, planes};
use crate::generate::Model;
use crate::harness::cases::{Built, Case, Expect, Suite, Values};
use crate::harness::check::Run;
use crate::harness::choices::{CHOICES, Choice, Dialect};
use crate::harness::compare::{Expected, ExpectedValues, is_close};
use crate::harness::corpus::in_parallel;
use crate::harness::judge::{Finding, Outcome, Right, Shown};
use crate::harness::misreadings::{self, Anatomy, At, Decision, Misreading, Seen};
use crate::harness::protocol::{Answer, Frame, Samples, View};
use crate::ptm::{Field, Format, Size};
use crate::reading::Reading;

/// One case that was asked, and all that is known of it.
pub(super) struct Witness<'a> {
    /// Its place in the suite.
    pub place: usize,
    pub case: &'a Case,
    pub finding: &'a Finding,
    pub built: Arc<Built>,
    pub failed: bool,
    /// How the decoder reads the open questions.
    pub reading: Reading,
    /// What the reference answers, reading the open questions so.
    pub right: Answer,
    /// What the bytes of the file are, as far as they can be read.
    fields: OnceLock<Vec<Field>>,
    traits: OnceLock<Traits>,
    /// What the reference finds in the file.
    decoded: OnceLock<crate::Result<Ptm>>,
}

/// How well an answer agrees with what was shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Agreement {
    /// The same picture.
    Picture,
    /// The same refusal or acceptance.
    Word,
    /// A refusal, where the decoder ended in another way without a picture.
    Crash,
    /// Another picture or another outcome.
    None,
    /// A refusal, where the decoder shows a picture: this mistake cannot be there.
    Against,
}

/// Every case that was asked and judged, and answered in one way.
pub(super) fn witnesses<'a>(
    suite: &'a Suite,
    run: &'a Run,
    reading: Reading,
    threads: usize,
) -> Vec<Witness<'a>> {
    let witness = |place: usize| {
        let case = &suite.cases[place];
        let outcome = run.judgement.cases[place].as_ref()?.outcome;
        // Of two answers neither tells of a mistake, and a broken promise tells of none in reading.
        let finding = run.findings[place]
            .as_ref()
            .filter(|finding| finding.unsteady.is_none())
            .filter(|finding| !promises::is_broken(run, case, finding))?;
        // An answer that proves nothing, or "unsupported", tells nothing of a mistake.
        if !matches!(outcome, Outcome::Pass | Outcome::Fail) {
            return None;
        }
        let built = case.build(run.table);
        let right = answer(&[], reading, &built.file, finding);
        Some(Witness {
            place,
            case,
            finding,
            built,
            failed: outcome == Outcome::Fail,
            reading,
            right,
            fields: OnceLock::new(),
            traits: OnceLock::new(),
            decoded: OnceLock::new(),
        })
    };
    let all = in_parallel(suite.cases.len(), threads, &|_, _| (), &witness);
    all.into_iter().flatten().collect()
}

impl Witness<'_> {
    /// What a decoder with these mistakes answers.
    pub fn answer(&self, mistakes: &[&Misreading]) -> Cow<'_, Answer> {
        // Taken apart once; and most edits leave most files as they are.
        let [first, rest @ ..] = mistakes else {
            return Cow::Borrowed(&self.right);
        };
        if mistakes.iter().all(|mistake| is_after_decoding(mistake)) {
            return match self.decoded() {
                Ok(ptm) => {
                    let reading = misreadings::misread(mistakes, self.reading);
                    let view = &self.finding.view;
                    Cow::Owned(misreadings::show(mistakes, &reading, ptm, view))
                }
                Err(_) => Cow::Borrowed(&self.right),
            };
        }
        let At::Bytes(edit) = first.at else {
            return Cow::Owned(answer(
                mistakes,
                self.reading,
                &self.built.file,
                self.finding,
            ));
        };
        let anatomy = Anatomy {
            file: &self.built.file,
            fields: self.fields().to_vec(),
        };
        match edit(&anatomy) {
            Seen::Refused => Cow::Owned(Answer::Rejected),
            Seen::File(bytes) if bytes == self.built.file => self.answer(rest),
            Seen::File(bytes) => Cow::Owned(answer(rest, self.reading, &bytes, self.finding)),
        }
    }

    /// What the bytes of the file are, as far as they can be read.
    pub fn fields(&self) -> &[Field] {
        self.fields
            .get_or_init(|| examine_as(&self.built.file, &self.reading).0)
    }

    /// What the reference finds in the file.
    pub fn decoded(&self) -> &crate::Result<Ptm> {
        self.decoded
            .get_or_init(|| decode_as(&self.built.file, &self.reading, &Limits::default()))
    }

    /// Where the first byte stands that is not header text.
    pub fn payload(&self) -> usize {
        let anatomy = Anatomy {
            file: &self.built.file,
            fields: self.fields().to_vec(),
        };
        anatomy.payload()
    }

    /// What was painted, where the generator wrote the file.
    pub fn model(&self) -> Option<&Model> {
        match &self.built.values {
            Values::Painted(model) => Some(model),
            _ => None,
        }
    }

    /// Whether a mistake could show in the answer at all.
    pub fn concerns(&self, misreading: &Misreading) -> bool {
        let shows = match (&self.finding.view, &misreading.at) {
            (View::Raw, At::Reading(decision, _)) => {
                !of_evaluation(*decision) && !of_finals(*decision)
            }
            (View::Coef, At::Reading(decision, _)) => !of_evaluation(*decision),
            _ => true,
        };
        shows && applies(misreading, &self.built.file)
    }

    /// Whether a mistake could be why the decoder did what it did here: a mistake that only changes values refuses
    /// nothing.
    pub fn could_be(&self, misreading: &Misreading) -> bool {
        let refused = matches!(
            self.finding.shown,
            Shown::Rejected | Shown::Unsupported | Shown::Misconduct(_)
        );
        self.concerns(misreading)
            && match misreading.at {
                At::Bytes(_) => true,
                At::Reading(decision, _) => !refused || may_refuse(decision),
                At::Planes(_) => !refused,
            }
    }

    /// All that can be said of the file.
    pub fn traits(&self) -> &Traits {
        self.traits.get_or_init(|| traits(self))
    }

    /// Where the decoder failed: how well `answer` is what it did.
    pub fn agreement(&self, answer: &Answer) -> Agreement {
        match (&self.finding.shown, answer) {
            // To refuse what the reference refuses is no mistake.
            (_, Answer::Rejected) if self.right == Answer::Rejected => Agreement::None,
            (
                Shown::Picture {
                    frame: Some(shown), ..
                },
                Answer::Decoded(made),
            ) if alike(shown, made) && (shown == made || !self.is_right(made)) => {
                Agreement::Picture
            }
            // Of a file that must be refused no picture is kept: to accept it is the mistake.
            (Shown::Picture { frame: None, .. }, Answer::Decoded(_))
                if matches!(self.case.expect, Expect::Reject | Expect::Refuse) =>
            {
                Agreement::Word
            }
            (Shown::Rejected, Answer::Rejected)
            | (Shown::Unsupported, Answer::Rejected | Answer::Unsupported) => Agreement::Word,
            (Shown::Misconduct(Answer::Crashed(_)), Answer::Rejected)
                if self.case.expect == Expect::Decode =>
            {
                Agreement::Crash
            }
            (Shown::Picture { .. }, Answer::Rejected | Answer::Unsupported)
                if self.case.expect == Expect::Decode =>
            {
                Agreement::Against
            }
            _ => Agreement::None,
        }
    }

    /// The colors of `made` before they were rounded, where it is the reference's own picture.
    pub fn exact(&self, made: &Frame) -> Option<Vec<f64>> {
        if !matches!(&self.right, Answer::Decoded(right) if right == made) {
            return None;
        }
        match Expected::under(&self.built.file, &self.finding.view, &self.reading)?.values {
            ExpectedValues::Rgb(values) => Some(values),
            _ => None,
        }
    }

    /// Whether that is the reference's picture, but for rounding: it explains no other one that is alike, too.
    fn is_right(&self, made: &Frame) -> bool {
        matches!(&self.right, Answer::Decoded(right) if alike(right, made))
    }

    /// Where the decoder did not fail: whether `answer` would have been another outcome than the one it showed.
    pub fn contradicts(&self, answer: &Answer) -> bool {
        if std::ptr::eq(answer, &raw const self.right) {
            return false;
        }
        match (self.case.expect, answer) {
            (Expect::Decode, Answer::Decoded(made)) => {
                !self.is_right(made) && self.would_fail(made)
            }
            (Expect::Decode, _) => true,
            (Expect::Reject | Expect::Refuse, answer) => matches!(answer, Answer::Decoded(_)),
            (Expect::Lenient | Expect::Spelling, _) => false,
        }
    }

    /// On a file beyond the letter both are right, to refuse it and to decode it: whether `answer` is what it did.
    pub fn leans_away(&self, answer: &Answer) -> bool {
        match (&self.finding.shown, answer) {
            (Shown::Rejected, Answer::Decoded(_)) | (Shown::Picture { .. }, Answer::Rejected) => {
                true
            }
            (Shown::Picture { .. }, Answer::Decoded(made)) => self.would_fail(made),
            _ => false,
        }
    }

    /// Whether that picture would be judged wrong.
    fn would_fail(&self, made: &Frame) -> bool {
        let right = match (&self.finding.shown, &self.right) {
            // A choice shows in it: right is what the decoder's own dialect makes of it.
            (
                Shown::Picture {
                    right: Right::In { .. },
                    ..
                },
                Answer::Decoded(right),
            ) => return !alike(right, made),
            _ => Expected::of(&self.built.values, &self.finding.view),
        };
        right.is_some_and(|right| right.compare(made).is_some())
    }
}

/// Decisions that show under a light only.
const fn of_evaluation(decision: Decision) -> bool {
    matches!(
        decision,
        Decision::Light
            | Decision::Polynomial
            | Decision::LumVector
            | Decision::LumMatrix
            | Decision::LumTranslation
            | Decision::Modulate
            | Decision::Clamp
    )
}

/// Decisions that show in final values, but not in stored ones.
const fn of_finals(decision: Decision) -> bool {
    matches!(decision, Decision::FinalCoefficient | Decision::FinalOther)
}

/// Mistakes that find the right values in the file.
pub(super) const fn is_after_decoding(misreading: &Misreading) -> bool {
    match misreading.at {
        At::Reading(decision, _) => of_evaluation(decision) || of_finals(decision),
        At::Planes(_) => true,
        At::Bytes(_) => false,
    }
}

/// Decisions that may end in a refusal; the others only make values.
const fn may_refuse(decision: Decision) -> bool {
    !of_evaluation(decision)
        && !of_finals(decision)
        && !matches!(
            decision,
            Decision::StoredRow
                | Decision::Invert
                | Decision::MotionHalf
                | Decision::Predict
                | Decision::SideCounts
                | Decision::Mend
                | Decision::Predictor
        )
}

/// How the decoder reads the open questions.
pub(crate) fn spoken(run: &Run) -> Reading {
    let taken = |(choice, (_, said)): (&Choice, &(&str, Option<&str>))| {
        choice
            .readings
            .iter()
            .position(|&(name, _)| Some(name) == *said)
            .unwrap_or_default()
    };
    let dialect = Dialect(
        CHOICES
            .iter()
            .zip(&run.judgement.dialect)
            .map(taken)
            .collect(),
    );
    let reading = match run.table.newline {
        true => dialect.reading().with_newline_after_table(),
        false => dialect.reading(),
    };
    Reading {
        stream: stream_once,
        ..reading
    }
}

pub(super) fn answer(
    mistakes: &[&Misreading],
    reading: Reading,
    file: &[u8],
    finding: &Finding,
) -> Answer {
    misreadings::answer(mistakes, reading, file, &finding.view)
}

/// Whether a mistake could act on a file: those of tables, matrices and compressed planes act where there are any.
#[must_use]
pub fn applies(misreading: &Misreading, file: &[u8]) -> bool {
    let format = &file[..file.len().min(64)];
    let has = |word: &[u8]| format.windows(word.len()).any(|bytes| bytes == word);
    let section = |name: &str| misreading.clause.starts_with(name);
    if !has(b"PTM_FORMAT_") || matches!(misreading.at, At::Bytes(_)) {
        true
    } else if section("2.9") {
        has(b"RMAT_JPEG")
    } else if section("2.5") || section("2.8") {
        has(b"LUT")
    } else if section("2.6") {
        has(b"RMAT_LUM")
    } else {
        true
    }
}

/// Whether two mistakes can be made at once: they act in different places or on different decisions.
#[must_use]
pub fn composable(a: &Misreading, b: &Misreading) -> bool {
    match (&a.at, &b.at) {
        (At::Reading(a, _), At::Reading(b, _)) => a != b,
        (At::Bytes(_), At::Bytes(_)) | (At::Planes(_), At::Planes(_)) => false,
        _ => true,
    }
}

/// Whether two pictures are one, but for rounding.
#[must_use]
pub fn alike(a: &Frame, b: &Frame) -> bool {
    if (a.view, a.width, a.height, a.channels) != (b.view, b.width, b.height, b.channels) {
        return false;
    }
    match (&a.samples, &b.samples) {
        (Samples::U8(x), Samples::U8(y)) if a.view == "rgb" => {
            x.iter().zip(y).all(|(x, y)| x.abs_diff(*y) <= 1)
        }
        (Samples::U8(x), Samples::U8(y)) => x == y,
        (Samples::F32(x), Samples::F32(y)) => x
            .iter()
            .zip(y)
            .all(|(x, y)| is_close(f64::from(*x), f64::from(*y), 0.0) || x.is_nan() && y.is_nan()),
        _ => false,
    }
}

/// Bytes of decoded streams that are remembered.
const REMEMBERED: usize = 128 << 20;

/// What has been decoded, by digest of the stream, and how many bytes that is.
static STREAMS: Mutex<(usize, BTreeMap<u64, Arc<Vec<u8>>>)> = Mutex::new((0, BTreeMap::new()));

/// As the reference decodes a stream, but each only once: hundreds of mistakes act later, on the same planes.
pub(crate) fn stream_once(
    format: Format,
    plane: usize,
    stream: &[u8],
    size: Size,
) -> Result<Vec<u8>, codec::Error> {
    let mut hasher = DefaultHasher::new();
    (format, size, stream).hash(&mut hasher);
    let key = hasher.finish();
    let known = STREAMS
        .lock()
        .expect("no worker panics")
        .1
        .get(&key)
        .cloned();
    if let Some(samples) = known {
        return Ok(samples.to_vec());
    }
    let samples = planes::stream(format, plane, stream, size)?;
    let mut remembered = STREAMS.lock().expect("no worker panics");
    if remembered.0 > REMEMBERED {
        *remembered = (0, BTreeMap::new());
    }
    remembered.0 += samples.len();
    remembered.1.insert(key, Arc::new(samples.clone()));
    Ok(samples)
}
