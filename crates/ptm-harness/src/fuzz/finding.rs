//! Findings of the fuzzer: mistakes with their causes and the smallest failing files.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use arbitrary::Unstructured;

use super::{draft::Draft, generator::random_bytes, minimize::minimize};
use crate::diagnose::equal_up_to_rounding;
use crate::report::document::LikelyCause;
use crate::session::asking::DecoderFn;
use ptm::reading::Reading;
use ptm_mistakes::Misreading;
use ptm_suite::cases::{Built, Case, Expect, TableSpelling};
use ptm_suite::compare::Expected;
use ptm_suite::protocol::frame::{Answer, Frame, TimeLimit, View};
use ptm_suite::protocol::request::{AttemptKind, Request};
use ptm_suite::verdicts::observation::{Observation, Response};
use ptm_suite::verdicts::offer::Offer;

/// Maximum number of passing files against which a suspected misreading is tested.
pub(super) const MAX_WITNESSES: usize = 200;
/// Maximum number of files that are generated to distinguish suspects. Only some of them are sent to the decoder.
const MAX_GENERATED_FILES: u64 = 3000;
const MAX_REQUESTED_FILES: usize = 24;

/// The decoder under test, and what is known about it.
pub struct KnownDecoder<'a> {
    /// Function that sends a request to the decoder.
    pub ask: &'a DecoderFn<'a>,
    /// Views and features that the decoder offers.
    pub offer: Offer,
    /// Spelling of the tables in files that are sent to the decoder.
    pub table: TableSpelling,
    /// The decoder's readings of open questions.
    pub reading: Reading,
}

pub(super) struct DraftRequest {
    /// The case of the draft. For a damaged draft, this is the damaged case.
    pub case: Case,
    /// File of the case.
    pub built: Arc<Built>,
    /// The requested view.
    pub view: View,
}

impl KnownDecoder<'_> {
    /// Returns the request for a draft, or `None` if the file cannot be written or none of its views is offered.
    pub(super) fn request(&self, draft: &Draft) -> Option<DraftRequest> {
        let case = draft.cases("draft").ok()?.pop()?;
        let view = self.offer.chosen_view(&case)?.clone();
        let built = case.build(self.table);
        Some(DraftRequest { case, built, view })
    }

    pub(super) fn answer(&self, request: &DraftRequest) -> Answer {
        self.answer_to(request, AttemptKind::Usual)
    }

    fn answer_to(&self, request: &DraftRequest, attempt: AttemptKind) -> Answer {
        let texels = (request.case.recipe()).map(|recipe| recipe.size.texels());
        let message = Request {
            name: &request.case.id,
            view: &request.view,
            file: &request.built.file,
            max_frame_bytes: 72 * texels.unwrap_or(0) + request.built.file.len(),
            attempt,
        };
        (self.ask)(&message, 0).answer
    }

    /// Predicts the answer of a decoder with these mistakes and this decoder's readings of open questions.
    fn answer_with(&self, mistakes: &[&Misreading], request: &DraftRequest) -> Answer {
        ptm_mistakes::answer(mistakes, self.reading, &request.built.file, &request.view)
    }

    fn is_correct(&self, request: &DraftRequest, answer: &Answer) -> bool {
        match answer {
            Answer::Decoded(_) if request.case.damage().is_some() => false,
            Answer::Decoded(frame) => {
                let (built, view) = (&request.built, &request.view);
                let is_equal = |expected: Expected| expected.compare(frame).is_none();
                Expected::new(&built.values, view).is_some_and(is_equal)
                    || Expected::from_file(&built.file, view, &self.reading).is_some_and(is_equal)
            }
            Answer::Rejected => request.case.damage().is_some(),
            Answer::Unsupported => request.case.expect == Expect::Refuse,
            _ => false,
        }
    }
}

/// Reason why the decoder fails on a file.
pub enum Explanation {
    /// One of these misreadings, in the order of the catalog.
    Misreading(Vec<&'static Misreading>),
    /// The decoder accepts a file with this damage.
    Accepts(&'static str),
    /// The decoder exceeds this time limit.
    TimedOut(TimeLimit),
    /// A symptom that no misreading explains: a wrong image, a refusal, or a crash with its message.
    Other(String),
}

impl Explanation {
    pub(super) fn find(
        draft: &Draft,
        observation: &Observation,
        passing: &[&Draft],
        decoder: &KnownDecoder,
    ) -> Explanation {
        if let (Some(damage), Response::Image { .. }) = (draft.damage, &observation.response) {
            return Explanation::Accepts(damage.name);
        }
        if let Some(limit) = observation.response.time_limit() {
            return Explanation::TimedOut(limit);
        }
        let other = Explanation::Other(response_symptom(&observation.response));
        let Some(request) = decoder.request(draft) else {
            return other;
        };
        let mut suspects: Vec<&'static Misreading> = ptm_mistakes::all()
            .filter(|suspect| explains(suspect, &request, observation, decoder))
            .collect();
        let passing = passing.iter().take(MAX_WITNESSES);
        for request in passing.filter_map(|draft| decoder.request(draft)) {
            if suspects.is_empty() {
                break;
            }
            let predicted = |suspect: &_| decoder.answer_with(&[suspect], &request);
            suspects.retain(|suspect| decoder.is_correct(&request, &predicted(suspect)));
        }
        match suspects.is_empty() {
            true => other,
            false => Explanation::Misreading(suspects),
        }
    }

    /// Returns true if this explanation also explains another failure. If so, keeps only the suspects that explain both failures.
    pub(super) fn extend_to_failure(
        &mut self,
        draft: &Draft,
        observation: &Observation,
        decoder: &KnownDecoder,
    ) -> bool {
        match self {
            Explanation::Accepts(damage) => {
                draft.damage.is_some_and(|other| other.name == *damage)
                    && matches!(observation.response, Response::Image { .. })
            }
            Explanation::Misreading(suspects) => decoder.request(draft).is_some_and(|request| {
                let explains =
                    |suspect: &&Misreading| explains(suspect, &request, observation, decoder);
                let is_explained = suspects.iter().any(explains);
                suspects.retain(|suspect| !is_explained || explains(suspect));
                is_explained
            }),
            Explanation::TimedOut(_) => observation.response.time_limit().is_some(),
            Explanation::Other(known) => *known == response_symptom(&observation.response),
        }
    }

    /// Returns a short name of the explanation.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Explanation::Misreading(suspects) => suspects[0].slug.to_owned(),
            Explanation::Accepts(damage) => format!("accepts-{damage}"),
            Explanation::TimedOut(limit) => limit.to_string(),
            Explanation::Other(symptom) => symptom.clone(),
        }
    }
}

/// Describes an unexplained answer in words that do not depend on the file.
fn symptom(name: &str, words: Option<&str>) -> String {
    match name {
        "decoded" => "a wrong image".to_owned(),
        "rejected" => "refuses a legal file".to_owned(),
        "unsupported" => "exits with 69 for a file of a kind that it decodes".to_owned(),
        "crash" => format!("crash: {}", words.unwrap_or_default()),
        other => other.to_owned(),
    }
}

fn response_symptom(response: &Response) -> String {
    let words = match response {
        Response::Violation(answer) => answer.violation(),
        _ => None,
    };
    symptom(response.name(), words.as_deref())
}

fn explains(
    suspect: &Misreading,
    request: &DraftRequest,
    observation: &Observation,
    decoder: &KnownDecoder,
) -> bool {
    let predicted = decoder.answer_with(&[suspect], request);
    match (&observation.response, predicted) {
        (Response::Image { frame, .. }, Answer::Decoded(predicted)) => match frame {
            Some(frame) => equal_up_to_rounding(frame, &predicted),
            // The image of a file that must be refused is not stored, because accepting the file is the mistake.
            None => request.case.damage().is_some(),
        },
        (Response::Rejected, Answer::Rejected) => true,
        _ => false,
    }
}

/// A mistake and the smallest file that reveals it.
pub struct Finding {
    /// The cause of the failure.
    pub cause: Explanation,
    /// The cause from the diagnosis, if no misreading or damage explains the failure.
    pub diagnosis: Option<LikelyCause>,
    /// The file on which the failure was first observed.
    pub original: Draft,
    /// The minimized file.
    pub small: Draft,
    /// The view in which the minimized file was requested.
    pub view: Option<View>,
    /// Name of the decoder's answer to the minimized file.
    pub answer: String,
    /// The received frame, if any.
    pub received: Option<Frame>,
    /// Number of generated files with the same failure.
    pub count: usize,
}

impl Finding {
    pub(super) fn new(
        draft: &Draft,
        mut cause: Explanation,
        decoder: &KnownDecoder,
        stop: &AtomicBool,
    ) -> Finding {
        distinguish_suspects(draft, &mut cause, decoder);
        let mut small = minimize(draft, decoder.table, stop, &|smaller| {
            fails_for_same_reason(smaller, &cause, decoder)
        });
        // The original file exceeded the higher time limit, too.
        let exceeds_higher_limit = |request: &DraftRequest| {
            let answer = decoder.answer_to(request, AttemptKind::Alone);
            matches!(answer, Answer::TimedOut(_))
        };
        if matches!(cause, Explanation::TimedOut(_))
            && !decoder
                .request(&small)
                .as_ref()
                .is_some_and(exceeds_higher_limit)
        {
            small = draft.clone();
        }
        let request = decoder.request(&small);
        let answer = request.as_ref().map(|request| decoder.answer(request));
        Finding {
            cause,
            diagnosis: None,
            original: draft.clone(),
            view: request.map(|request| request.view),
            answer: answer.as_ref().map_or("", Answer::name).to_owned(),
            received: answer.and_then(|answer| answer.decoded::<()>().ok()),
            small,
            count: 1,
        }
    }
}

/// Sends files for which the suspects predict different answers, until one suspect is left or no more such files are found.
fn distinguish_suspects(draft: &Draft, cause: &mut Explanation, decoder: &KnownDecoder) {
    let Explanation::Misreading(suspects) = cause else {
        return;
    };
    let mut request_count = 0;
    for number in 0..MAX_GENERATED_FILES {
        if suspects.len() == 1 || request_count == MAX_REQUESTED_FILES {
            return;
        }
        let bytes = random_bytes(0x7e11, number);
        let other = Draft::draw(&mut Unstructured::new(&bytes)).ok();
        let other = other.filter(|other| other.width * other.height <= 4096);
        let request = other.and_then(|mut other| {
            other.views.clone_from(&draft.views);
            decoder.request(&other)
        });
        let Some(request) = request else { continue };
        let predicted = |suspect: &&Misreading| decoder.answer_with(&[suspect], &request);
        let answers: Vec<Answer> = suspects.iter().map(predicted).collect();
        if answers.windows(2).all(|pair| are_equal(&pair[0], &pair[1])) {
            continue;
        }
        request_count += 1;
        let answer = decoder.answer(&request);
        if answers.iter().any(|a| are_equal(a, &answer)) {
            let mut answers = answers.iter();
            suspects.retain(|_| answers.next().is_some_and(|a| are_equal(a, &answer)));
        }
    }
}

fn are_equal(a: &Answer, b: &Answer) -> bool {
    match (a, b) {
        (Answer::Decoded(a), Answer::Decoded(b)) => equal_up_to_rounding(a, b),
        (a, b) => a.name() == b.name(),
    }
}

/// Returns true if the decoder fails on `draft` because of `cause`.
pub(super) fn fails_for_same_reason(
    draft: &Draft,
    cause: &Explanation,
    decoder: &KnownDecoder,
) -> bool {
    let Some(request) = decoder.request(draft) else {
        return false;
    };
    match cause {
        Explanation::Misreading(suspects) => {
            // Most smaller files no longer fail. The suspect predicts this without a request.
            let wrong = decoder.answer_with(&suspects[..1], &request);
            !decoder.is_correct(&request, &wrong) && are_equal(&wrong, &decoder.answer(&request))
        }
        Explanation::Accepts(_) => {
            let mut legal = draft.clone();
            legal.damage = None;
            let accepts = |request: &_| matches!(decoder.answer(request), Answer::Decoded(_));
            accepts(&request) && decoder.request(&legal).as_ref().is_some_and(accepts)
        }
        Explanation::TimedOut(_) => matches!(decoder.answer(&request), Answer::TimedOut(_)),
        Explanation::Other(known) => {
            let answer = decoder.answer(&request);
            let is_known = *known == symptom(answer.name(), answer.violation().as_deref());
            is_known && !decoder.is_correct(&request, &answer)
        }
    }
}
