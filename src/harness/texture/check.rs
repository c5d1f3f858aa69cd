//! One run: first cases, then every case once.
//!
//! Whoever answers is a closure from case to finding, so that a misreading inside this program and a program outside it are
//! asked and judged in the same way.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use serde_json::Value;

use crate::harness::protocol::Answer;
use crate::harness::run::{Decoder, Invocation};
use crate::harness::scratch::Scratch;
use crate::harness::tally::Tally;
use crate::harness::texture::cases::{Case, Suite};
use crate::harness::texture::judge::{Finding, Judgement, Outcome, Shown, judge};
use crate::harness::texture::question::Refusal;
use crate::texture::Rules;

/// What of the suite is run, and how.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Which cases are judged, a place for each.
    pub selected: Vec<bool>,
    /// Questions at a time, at least 1.
    pub jobs: usize,
    /// Set when the user wants the run to end.
    pub stop: Arc<AtomicBool>,
}

/// What a run showed.
#[derive(Clone, Debug)]
pub struct Run {
    /// What was found, a place for each case.
    pub findings: Vec<Option<Finding>>,
    /// The verdicts.
    pub judgement: Judgement,
    /// How many questions were put.
    pub asked: usize,
    /// How many of them brought neither an answer nor a refusal.
    pub misconduct: usize,
    /// Why the run ended before all cases were asked, if it did.
    pub ended_early: Option<&'static str>,
    /// Why nobody answers, if nobody does.
    pub not_a_decoder: Option<String>,
}

/// Most bytes of an answer: a JSON object of a few numbers and words.
const LARGEST_ANSWER: usize = 1 << 20;

/// Runs the suite against whoever `ask` asks. `progress` is told of each case as it is done: what was found, and how many of
/// how many are done.
pub fn check(
    suite: &Suite,
    plan: &Plan,
    ask: &(impl Fn(&Case, u32) -> Finding + Sync),
    progress: &(impl Fn(&Case, &Finding, usize, usize) + Sync),
) -> Run {
    let asked = Asked {
        ask,
        tally: Tally::new(&plan.stop),
    };
    let not_a_decoder = nobody_answers(suite, &asked);
    let findings = match not_a_decoder {
        Some(_) => vec![None; suite.cases.len()],
        None => all_cases(suite, plan, &asked, progress),
    };
    let selected = match not_a_decoder {
        Some(_) => vec![false; suite.cases.len()],
        None => plan.selected.clone(),
    };
    let ended_early = asked.tally.why_over();
    let mut judgement = judge(suite, &selected, &findings);
    for judged in judgement.cases.iter_mut().flatten() {
        if judged.outcome == Outcome::NotRun {
            ended_early.unwrap_or_default().clone_into(&mut judged.says);
        }
    }
    let (asked, misconduct) = asked.tally.counts();
    Run {
        findings,
        judgement,
        asked,
        misconduct,
        ended_early,
        not_a_decoder,
    }
}

/// Whoever answers, and a count of what was asked.
struct Asked<'a, F> {
    ask: &'a F,
    tally: Tally<'a>,
}

impl<F: Fn(&Case, u32) -> Finding + Sync> Asked<'_, F> {
    fn find(&self, case: &Case) -> Finding {
        let finding = (self.ask)(case, self.tally.call());
        self.tally.came_to(
            matches!(finding.shown, Shown::Misconduct(_)),
            matches!(finding.shown, Shown::Misconduct(Answer::Hung(_))),
        );
        finding
    }
}

/// Asks the first cases until one is answered with a JSON object; says what came instead if none is.
fn nobody_answers(
    suite: &Suite,
    asked: &Asked<impl Fn(&Case, u32) -> Finding + Sync>,
) -> Option<String> {
    let mut first = None;
    for case in suite.cases.iter().filter(|case| case.first) {
        let finding = asked.find(case);
        if matches!(finding.shown, Shown::Said(_)) {
            return None;
        }
        let hopeless = matches!(&finding.shown, Shown::Misconduct(Answer::NotStarted(_)));
        first.get_or_insert(finding);
        if hopeless || asked.tally.why_over().is_some() {
            break;
        }
    }
    let first = first?;
    let why = match &first.shown {
        Shown::Misconduct(Answer::NotStarted(why)) => format!("it cannot be started: {why}"),
        Shown::Misconduct(answer) => format!(
            "it answers no first question; the first of its answers: {}: {}",
            answer.name(),
            answer.misconduct().unwrap_or_default()
        ),
        other => format!(
            "it answers no first question; the first of its answers: {}",
            other.name()
        ),
    };
    Some(match first.stderr.as_str() {
        "" => why,
        stderr => format!("{why}\nits standard error begins:\n{stderr}"),
    })
}

fn all_cases(
    suite: &Suite,
    plan: &Plan,
    asked: &Asked<impl Fn(&Case, u32) -> Finding + Sync>,
    progress: &(impl Fn(&Case, &Finding, usize, usize) + Sync),
) -> Vec<Option<Finding>> {
    let work = with_others_of_their_kind(suite, &plan.selected);
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let findings = Mutex::new(vec![None; suite.cases.len()]);
    std::thread::scope(|scope| {
        for _ in 0..plan.jobs.max(1) {
            scope.spawn(|| {
                while let Some(&i) = work.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let case = &suite.cases[i];
                    let finding = asked.find(case);
                    if plan.stop.load(Ordering::Relaxed) {
                        break;
                    }
                    let done = done.fetch_add(1, Ordering::Relaxed) + 1;
                    progress(case, &finding, done, work.len());
                    findings.lock().expect("no worker panics")[i] = Some(finding);
                    if asked.tally.why_over().is_some() {
                        break;
                    }
                }
            });
        }
    });
    findings.into_inner().expect("no worker panics")
}

/// The selected cases, and for each that must be refused one of its kind that must not: a refusal alone proves nothing.
fn with_others_of_their_kind(suite: &Suite, selected: &[bool]) -> Vec<usize> {
    let mut wanted = selected.to_vec();
    for (case, _) in suite.cases.iter().zip(selected).filter(|pair| *pair.1) {
        let twin = suite
            .cases
            .iter()
            .position(|other| other.op == case.op && other.expect.get("error").is_none());
        if let (Some(_), Some(twin)) = (case.expect.get("error"), twin) {
            wanted[twin] = true;
        }
    }
    (0..wanted.len()).filter(|&i| wanted[i]).collect()
}

/// Puts the question of a case to a program.
#[must_use]
pub fn ask_program(decoder: &Decoder, case: &Case, patience: u32, scratch: &Scratch) -> Finding {
    let heard = decoder.invoke(
        &Invocation {
            view: "texture",
            file_name: "case.json",
            file: format!("{}\n", case.question()).as_bytes(),
            most: LARGEST_ANSWER,
            patience,
        },
        scratch,
    );
    let shown = match heard.said {
        Ok(bytes) => match serde_json::from_slice::<Value>(&bytes) {
            Ok(value) if value.is_object() => Shown::Said(value),
            Ok(other) => Shown::Misconduct(Answer::ProtocolError(format!(
                "expected a JSON object, found {other}"
            ))),
            Err(error) => Shown::Misconduct(Answer::ProtocolError(format!(
                "expected a JSON object: {error}"
            ))),
        },
        Err(Answer::Rejected) => Shown::Rejected,
        Err(Answer::Unsupported) => Shown::Unsupported,
        Err(misconduct) => Shown::Misconduct(misconduct),
    };
    Finding {
        shown,
        stderr: heard.stderr,
    }
}

/// What one who reads the chapter as `rules` do answers.
#[must_use]
pub fn ask_rules(rules: &Rules, case: &Case) -> Finding {
    let answer = case.read().and_then(|question| question.answer(rules));
    Finding {
        shown: match answer {
            Ok(value) => Shown::Said(value),
            Err(Refusal::Malformed(_)) => Shown::Rejected,
            Err(Refusal::Unsupported(_)) => Shown::Unsupported,
        },
        stderr: String::new(),
    }
}

impl Run {
    /// The exit status of `check`: 0, 1 or 3.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        let mut judged = self.judgement.cases.iter().flatten();
        let failed = judged.any(|judged| judged.outcome == Outcome::Fail);
        match self.not_a_decoder {
            Some(_) => 3,
            None => u8::from(failed || self.ended_early.is_some()),
        }
    }
}
