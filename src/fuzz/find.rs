//! A mistake found by fuzzing, with its cause and the smallest failing file.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use arbitrary::Unstructured;

use super::draft::Draft;
use super::draws::random_bytes;
use super::minimise::minimise;
use crate::diagnose::equal_up_to_rounding;
use crate::misreadings::{self, Misreading};
use crate::protocol::frame::{Answer, Frame, View};
use crate::reading::Reading;
use crate::report::document::LikelyCause;
use crate::runner::run::Request;
use crate::session::asking::Ask;
use crate::session::observation::{Observation, Response};
use crate::session::offer::Offer;
use crate::suite::cases::{Built, Case, Expect, TableSpelling};
use crate::suite::compare::Expected;

/// Maximum number of passing files against which a suspected misreading is tested.
pub(super) const MAX_WITNESSES: usize = 200;
/// Maximum number of files that are generated to distinguish suspects. Fewer are requested.
const MAX_GENERATED_FILES: u64 = 3000;
const MAX_REQUESTED_FILES: usize = 24;

/// A decoder with known properties.
pub struct KnownDecoder<'a> {
    /// Sends a request to the decoder.
    pub ask: &'a Ask<'a>,
    /// Offer of the decoder.
    pub offer: Offer,
    /// Spelling in which tables are sent.
    pub table: TableSpelling,
    /// Readings of open questions.
    pub reading: Reading,
}

/// A request for a generated file.
pub(super) struct DraftRequest {
    /// The case of the draft; for a damaged draft, the damaged case.
    pub case: Case,
    /// File of the case.
    pub built: Arc<Built>,
    /// The requested view.
    pub view: View,
}

impl KnownDecoder<'_> {
    /// Returns the request for a draft, or `None` if the file cannot be written or none of its views is offered.
    pub(super) fn question(&self, draft: &Draft) -> Option<DraftRequest> {
        let case = draft.cases("draft").ok()?.pop()?;
        let view = self.offer.chosen_view(&case)?.clone();
        let built = case.build(self.table);
        Some(DraftRequest { case, built, view })
    }

    /// Returns the decoder's answer.
    pub(super) fn answer(&self, question: &DraftRequest) -> Answer {
        let texels = (question.case.recipe()).map(|recipe| recipe.size.texels());
        let request = Request {
            name: &question.case.id,
            view: &question.view,
            file: &question.built.file,
            max_frame_bytes: 72 * texels.unwrap_or(0) + question.built.file.len(),
            timeout_factor: 1,
            needs_new_process: false,
        };
        (self.ask)(&request, 0).answer
    }

    /// Returns the answer of a decoder with these mistakes and this decoder's readings of open questions.
    fn answer_with(&self, mistakes: &[&Misreading], question: &DraftRequest) -> Answer {
        misreadings::answer(mistakes, self.reading, &question.built.file, &question.view)
    }

    /// Returns true if the answer is right in the dialect of this decoder.
    fn is_right(&self, question: &DraftRequest, answer: &Answer) -> bool {
        match answer {
            Answer::Decoded(_) if question.case.damage().is_some() => false,
            Answer::Decoded(frame) => {
                let (built, view) = (&question.built, &question.view);
                let is_equal = |expected: Expected| expected.compare(frame).is_none();
                Expected::new(&built.values, view).is_some_and(is_equal)
                    || Expected::from_file(&built.file, view, &self.reading).is_some_and(is_equal)
            }
            Answer::Rejected => question.case.damage().is_some(),
            Answer::Unsupported => question.case.expect == Expect::Refuse,
            _ => false,
        }
    }
}

/// Reason why a file fails.
pub enum Explanation {
    /// Any of these misreadings, the most likely first.
    Misreading(Vec<&'static Misreading>),
    /// The decoder accepts a file with this damage.
    Accepts(&'static str),
    /// A failure that no misreading explains: an image, a refusal, or a crash with its message.
    Other(String),
}

impl Explanation {
    pub(super) fn find(
        draft: &Draft,
        observation: &Observation,
        passed: &[&Draft],
        decoder: &KnownDecoder,
    ) -> Explanation {
        if let (Some(damage), Response::Image { .. }) = (draft.damage, &observation.response) {
            return Explanation::Accepts(damage.name);
        }
        let other = Explanation::Other(response_symptom(&observation.response));
        let Some(question) = decoder.question(draft) else {
            return other;
        };
        let mut suspects: Vec<&'static Misreading> = misreadings::all()
            .filter(|suspect| explains(suspect, &question, observation, decoder))
            .collect();
        let passed = passed.iter().take(MAX_WITNESSES);
        for question in passed.filter_map(|draft| decoder.question(draft)) {
            if suspects.is_empty() {
                break;
            }
            let made = |suspect: &_| decoder.answer_with(&[suspect], &question);
            suspects.retain(|suspect| decoder.is_right(&question, &made(suspect)));
        }
        match suspects.is_empty() {
            true => other,
            false => Explanation::Misreading(suspects),
        }
    }

    /// Returns true if another failure has the same cause, and removes the suspects that do not explain that failure.
    pub(super) fn explains_failure(
        &mut self,
        draft: &Draft,
        observation: &Observation,
        decoder: &KnownDecoder,
    ) -> bool {
        match self {
            Explanation::Accepts(damage) => {
                draft.damage.is_some_and(|shown| shown.name == *damage)
                    && matches!(observation.response, Response::Image { .. })
            }
            Explanation::Misreading(suspects) => decoder.question(draft).is_some_and(|question| {
                let explains =
                    |suspect: &&Misreading| explains(suspect, &question, observation, decoder);
                let is_explained = suspects.iter().any(explains);
                suspects.retain(|suspect| !is_explained || explains(suspect));
                is_explained
            }),
            Explanation::Other(known) => *known == response_symptom(&observation.response),
        }
    }

    /// Returns a short description.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Explanation::Misreading(suspects) => suspects[0].slug.to_owned(),
            Explanation::Accepts(damage) => format!("accepts-{damage}"),
            Explanation::Other(symptom) => symptom.clone(),
        }
    }
}

/// Describes an unexplained behavior independently of the file.
fn symptom(name: &str, words: Option<&str>) -> String {
    match name {
        "decoded" => "a wrong image".to_owned(),
        "rejected" => "refuses a legal file".to_owned(),
        "unsupported" => "exits with 69 on a file of a kind it decodes".to_owned(),
        "crash" => format!("crash: {}", words.unwrap_or_default()),
        other => other.to_owned(),
    }
}

fn response_symptom(shown: &Response) -> String {
    let words = match shown {
        Response::Violation(answer) => answer.violation(),
        _ => None,
    };
    symptom(shown.name(), words)
}

fn explains(
    suspect: &Misreading,
    question: &DraftRequest,
    observation: &Observation,
    decoder: &KnownDecoder,
) -> bool {
    let made = decoder.answer_with(&[suspect], question);
    match (&observation.response, made) {
        (Response::Image { frame, .. }, Answer::Decoded(made)) => match frame {
            Some(shown) => equal_up_to_rounding(shown, &made),
            // The image of a file that must be refused is not kept, because accepting the file is the mistake.
            None => question.case.damage().is_some(),
        },
        (Response::Rejected, Answer::Rejected) => true,
        _ => false,
    }
}

/// A mistake and the smallest failing file.
pub struct Find {
    /// The cause of the failure.
    pub cause: Explanation,
    /// The cause that the diagnosis finds, if the failure is not explained otherwise.
    pub diagnosis: Option<LikelyCause>,
    /// The original file.
    pub drawn: Draft,
    /// The minimized file.
    pub small: Draft,
    /// The view in which the minimized file was requested.
    pub view: Option<View>,
    /// Name of the decoder's answer.
    pub answer: String,
    /// The received frame, if any.
    pub received: Option<Frame>,
    /// Number of generated files with the same failure.
    pub seen: usize,
}

impl Find {
    pub(super) fn new(
        draft: &Draft,
        mut cause: Explanation,
        decoder: &KnownDecoder,
        stop: &AtomicBool,
    ) -> Find {
        distinguish_suspects(draft, &mut cause, decoder);
        let small = minimise(draft, decoder.table, stop, &|smaller| {
            fails_for_same_reason(smaller, &cause, decoder)
        });
        let question = decoder.question(&small);
        let answer = question.as_ref().map(|question| decoder.answer(question));
        Find {
            cause,
            diagnosis: None,
            drawn: draft.clone(),
            view: question.map(|question| question.view),
            answer: answer.as_ref().map_or("", Answer::name).to_owned(),
            received: answer.and_then(|answer| answer.decoded::<()>().ok()),
            small,
            seen: 1,
        }
    }
}

/// Requests files for which the suspects differ, until one suspect is left or no such file is found.
fn distinguish_suspects(draft: &Draft, cause: &mut Explanation, decoder: &KnownDecoder) {
    let Explanation::Misreading(suspects) = cause else {
        return;
    };
    let mut asked = 0;
    for number in 0..MAX_GENERATED_FILES {
        if suspects.len() == 1 || asked == MAX_REQUESTED_FILES {
            return;
        }
        let bytes = random_bytes(0x7e11, number);
        let other = Draft::draw(&mut Unstructured::new(&bytes)).ok();
        let other = other.filter(|other| other.width * other.height <= 4096);
        let question = other.and_then(|mut other| {
            other.views.clone_from(&draft.views);
            decoder.question(&other)
        });
        let Some(question) = question else { continue };
        let made = |suspect: &&Misreading| decoder.answer_with(&[suspect], &question);
        let answers: Vec<Answer> = suspects.iter().map(made).collect();
        if answers.windows(2).all(|pair| are_equal(&pair[0], &pair[1])) {
            continue;
        }
        asked += 1;
        let answer = decoder.answer(&question);
        if answers.iter().any(|made| are_equal(made, &answer)) {
            let mut made = answers.iter();
            suspects.retain(|_| made.next().is_some_and(|made| are_equal(made, &answer)));
        }
    }
}

/// Returns true if two answers are equal.
fn are_equal(a: &Answer, b: &Answer) -> bool {
    match (a, b) {
        (Answer::Decoded(a), Answer::Decoded(b)) => equal_up_to_rounding(a, b),
        (a, b) => a.name() == b.name(),
    }
}

/// Returns true if the decoder fails on a draft for the same reason.
pub(super) fn fails_for_same_reason(
    draft: &Draft,
    cause: &Explanation,
    decoder: &KnownDecoder,
) -> bool {
    let Some(question) = decoder.question(draft) else {
        return false;
    };
    match cause {
        Explanation::Misreading(suspects) => {
            // Most smaller files no longer fail, which the suspect predicts without a request.
            let made = decoder.answer_with(&suspects[..1], &question);
            !decoder.is_right(&question, &made) && are_equal(&made, &decoder.answer(&question))
        }
        Explanation::Accepts(_) => {
            let mut whole = draft.clone();
            whole.damage = None;
            let accepts = |asked: &_| matches!(decoder.answer(asked), Answer::Decoded(_));
            accepts(&question) && decoder.question(&whole).as_ref().is_some_and(accepts)
        }
        Explanation::Other(known) => {
            let answer = decoder.answer(&question);
            let is_known = *known == symptom(answer.name(), answer.violation());
            is_known && !decoder.is_right(&question, &answer)
        }
    }
}
