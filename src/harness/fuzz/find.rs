//! A mistake that fuzzing found: its cause, and the smallest file that shows it.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use arbitrary::Unstructured;

use super::draft::Draft;
use super::minimise::minimise;
use crate::harness::cases::{Built, Case, Expect, TableSpelling};
use crate::harness::compare::Expected;
use crate::harness::diagnose::alike;
use crate::harness::judge::{Finding, Offer, Shown};
use crate::harness::misreadings::{self, Misreading};
use crate::harness::protocol::{Answer, Frame, View};
use crate::harness::run::{Reply, Request};
use crate::reading::Reading;

/// Passing files that a suspected misreading is held against.
const WITNESSES: usize = 200;
/// Files drawn to tell suspects apart, and how many of those are asked for.
const DRAWN_TO_TELL_APART: u64 = 3000;
const ASKED_TO_TELL_APART: usize = 24;

/// A decoder, and what is known of it.
pub struct Decoder<'a, F> {
    /// Asks it.
    pub ask: &'a F,
    /// The views it offers.
    pub offer: Offer,
    /// How tables are spelled for it.
    pub table: TableSpelling,
    /// How it reads the open questions.
    pub reading: Reading,
}

/// A file, asked for.
pub(super) struct Question {
    /// The case; of a damaged draft the damaged one.
    pub case: Case,
    /// Its file.
    pub built: Arc<Built>,
    /// The view it is asked in.
    pub view: View,
}

impl<F: Fn(&Request, usize) -> Reply + Sync> Decoder<'_, F> {
    /// The question that a draft is; nothing where it cannot be written or no view of it is offered.
    pub(super) fn question(&self, draft: &Draft) -> Option<Question> {
        let case = draft.cases("draft").ok()?.pop()?;
        let view = self.offer.chosen_view(&case)?.clone();
        let built = case.build(self.table);
        Some(Question { case, built, view })
    }

    /// What the decoder makes of it.
    pub(super) fn answer(&self, question: &Question) -> Answer {
        let request = Request {
            name: &question.case.id,
            view: &question.view,
            file: &question.built.file,
            largest_frame: question
                .case
                .recipe()
                .map_or(0, |recipe| recipe.size.texels())
                * 18
                * 4
                + question.built.file.len(),
            patience: 1,
            alone: false,
        };
        (self.ask)(&request, 0).answer
    }

    /// What a decoder makes of it that has these mistakes and reads open questions as this one does.
    fn answer_with(&self, mistakes: &[&Misreading], question: &Question) -> Answer {
        misreadings::answer(mistakes, self.reading, &question.built.file, &question.view)
    }

    /// Whether the answer is right, by the dialect of this decoder.
    fn is_right(&self, question: &Question, answer: &Answer) -> bool {
        match answer {
            Answer::Decoded(_) if question.case.damage().is_some() => false,
            Answer::Decoded(frame) => {
                let right = |expected: Option<Expected>| {
                    expected.is_some_and(|expected| expected.compare(frame).is_none())
                };
                right(Expected::of(&question.built.values, &question.view))
                    || right(Expected::under(
                        &question.built.file,
                        &question.view,
                        &self.reading,
                    ))
            }
            Answer::Rejected => question.case.damage().is_some(),
            Answer::Unsupported => question.case.expect == Expect::Refuse,
            _ => false,
        }
    }
}

/// Why a file fails.
pub enum Cause {
    /// As a decoder with any of these misreadings would; the most likely first.
    Misreading(Vec<&'static Misreading>),
    /// It decodes a file with this damage.
    Accepts(&'static str),
    /// In a way that no misreading explains: a picture, a refusal, or a crash with its words.
    Other(String),
}

impl Cause {
    pub(super) fn of<F: Fn(&Request, usize) -> Reply + Sync>(
        draft: &Draft,
        finding: &Finding,
        passed: &[&Draft],
        decoder: &Decoder<F>,
    ) -> Cause {
        if let (Some(damage), Shown::Picture { .. }) = (draft.damage, &finding.shown) {
            return Cause::Accepts(damage.name);
        }
        let other = Cause::Other(symptom_shown(&finding.shown));
        let Some(question) = decoder.question(draft) else {
            return other;
        };
        let mut suspects: Vec<&'static Misreading> = misreadings::all()
            .filter(|suspect| explains(suspect, &question, finding, decoder))
            .collect();
        for question in passed
            .iter()
            .take(WITNESSES)
            .filter_map(|draft| decoder.question(draft))
        {
            if suspects.is_empty() {
                break;
            }
            suspects.retain(|suspect| {
                decoder.is_right(&question, &decoder.answer_with(&[suspect], &question))
            });
        }
        if suspects.is_empty() {
            other
        } else {
            Cause::Misreading(suspects)
        }
    }

    /// Whether another failure has this cause too.
    pub(super) fn also_of<F: Fn(&Request, usize) -> Reply + Sync>(
        &self,
        draft: &Draft,
        finding: &Finding,
        decoder: &Decoder<F>,
    ) -> bool {
        match self {
            Cause::Accepts(damage) => {
                draft.damage.is_some_and(|shown| shown.name == *damage)
                    && matches!(finding.shown, Shown::Picture { .. })
            }
            Cause::Misreading(suspects) => decoder.question(draft).is_some_and(|question| {
                suspects
                    .iter()
                    .any(|suspect| explains(suspect, &question, finding, decoder))
            }),
            Cause::Other(known) => *known == symptom_shown(&finding.shown),
        }
    }

    /// Drops the suspects that do not explain this failure too.
    pub(super) fn narrow<F: Fn(&Request, usize) -> Reply + Sync>(
        &mut self,
        draft: &Draft,
        finding: &Finding,
        decoder: &Decoder<F>,
    ) {
        if let (Cause::Misreading(suspects), Some(question)) = (self, decoder.question(draft)) {
            suspects.retain(|suspect| explains(suspect, &question, finding, decoder));
        }
    }

    /// A word or a sentence.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Cause::Misreading(suspects) => suspects[0].slug.to_owned(),
            Cause::Accepts(damage) => format!("accepts-{damage}"),
            Cause::Other(symptom) => symptom.clone(),
        }
    }
}

/// What a decoder does that nothing in the catalogue explains, in words that are the same for every file.
fn symptom(name: &str, words: Option<&str>) -> String {
    match name {
        "decoded" => "a wrong picture".to_owned(),
        "rejected" => "refuses a legal file".to_owned(),
        "unsupported" => "answers 69 to a file of a kind it decodes".to_owned(),
        "crash" => format!("crash: {}", words.unwrap_or_default()),
        other => other.to_owned(),
    }
}

fn symptom_shown(shown: &Shown) -> String {
    let words = match shown {
        Shown::Misconduct(answer) => answer.misconduct(),
        _ => None,
    };
    symptom(shown.name(), words)
}

fn explains<F: Fn(&Request, usize) -> Reply + Sync>(
    suspect: &Misreading,
    question: &Question,
    finding: &Finding,
    decoder: &Decoder<F>,
) -> bool {
    let is_damaged = question.case.damage().is_some();
    match (&finding.shown, decoder.answer_with(&[suspect], question)) {
        (
            Shown::Picture {
                frame: Some(shown), ..
            },
            Answer::Decoded(made),
        ) => alike(shown, &made),
        // Of a file that must be refused no picture is kept: to accept it is the mistake.
        (Shown::Picture { .. }, Answer::Decoded(_)) => is_damaged,
        (Shown::Rejected, Answer::Rejected) => true,
        _ => false,
    }
}

/// A mistake, and the smallest file that shows it.
pub struct Find {
    /// Why it fails.
    pub cause: Cause,
    /// What the verdict on the first file said.
    pub says: String,
    /// The file as it was drawn.
    pub drawn: Draft,
    /// The same made small.
    pub small: Draft,
    /// The view in which the small one was asked for.
    pub view: Option<View>,
    /// What the decoder did with it, in a word or two.
    pub answer: String,
    /// The frame it made of it, if it was one.
    pub received: Option<Frame>,
    /// How many drawn files failed alike.
    pub seen: usize,
}

impl Find {
    pub(super) fn new<F: Fn(&Request, usize) -> Reply + Sync>(
        draft: &Draft,
        mut cause: Cause,
        says: String,
        decoder: &Decoder<F>,
        stop: &AtomicBool,
    ) -> Find {
        tell_apart(draft, &mut cause, decoder);
        let small = minimise(draft, decoder.table, stop, &|smaller| {
            fails_alike(smaller, &cause, decoder)
        });
        let question = decoder.question(&small);
        let answer = question.as_ref().map(|question| decoder.answer(question));
        Find {
            cause,
            says,
            drawn: draft.clone(),
            view: question.map(|question| question.view),
            answer: answer.as_ref().map_or("", Answer::name).to_owned(),
            received: answer.and_then(|answer| match answer {
                Answer::Decoded(frame) => Some(frame),
                _ => None,
            }),
            small,
            seen: 1,
        }
    }
}

/// Asks for files that the suspects read differently, until one suspect is left or no such file is found.
fn tell_apart<F: Fn(&Request, usize) -> Reply + Sync>(
    draft: &Draft,
    cause: &mut Cause,
    decoder: &Decoder<F>,
) {
    let Cause::Misreading(suspects) = cause else {
        return;
    };
    let mut asked = 0;
    for number in 0..DRAWN_TO_TELL_APART {
        if suspects.len() == 1 || asked == ASKED_TO_TELL_APART {
            return;
        }
        let bytes = super::random_bytes(0x7e11, number);
        let Ok(mut other) = Draft::draw(&mut Unstructured::new(&bytes)) else {
            continue;
        };
        if other.width * other.height > 4096 {
            continue;
        }
        other.views.clone_from(&draft.views);
        let Some(question) = decoder.question(&other) else {
            continue;
        };
        let answers: Vec<Answer> = suspects
            .iter()
            .map(|suspect| decoder.answer_with(&[suspect], &question))
            .collect();
        if answers.windows(2).all(|pair| same(&pair[0], &pair[1])) {
            continue;
        }
        asked += 1;
        let answer = decoder.answer(&question);
        if answers.iter().any(|made| same(made, &answer)) {
            let mut made = answers.iter();
            suspects.retain(|_| made.next().is_some_and(|made| same(made, &answer)));
        }
    }
}

/// Whether two answers are one.
fn same(a: &Answer, b: &Answer) -> bool {
    match (a, b) {
        (Answer::Decoded(a), Answer::Decoded(b)) => alike(a, b),
        (a, b) => a.name() == b.name(),
    }
}

/// Whether the decoder fails on a draft for the same reason.
pub(super) fn fails_alike<F: Fn(&Request, usize) -> Reply + Sync>(
    draft: &Draft,
    cause: &Cause,
    decoder: &Decoder<F>,
) -> bool {
    let Some(question) = decoder.question(draft) else {
        return false;
    };
    // Most that is smaller shows nothing any more; that is known without asking.
    let made = match cause {
        Cause::Misreading(suspects) => {
            let made = decoder.answer_with(&suspects[..1], &question);
            if decoder.is_right(&question, &made) {
                return false;
            }
            Some(made)
        }
        _ => None,
    };
    let answer = decoder.answer(&question);
    match (cause, &answer) {
        (Cause::Misreading(_), answer) => made.is_some_and(|made| same(&made, answer)),
        (Cause::Accepts(_), Answer::Decoded(_)) => decoder
            .question(&draft.whole())
            .is_some_and(|whole| matches!(decoder.answer(&whole), Answer::Decoded(_))),
        (Cause::Accepts(_), _) => false,
        (Cause::Other(known), answer) => {
            !decoder.is_right(&question, answer)
                && *known == symptom(answer.name(), answer.misconduct())
        }
    }
}
