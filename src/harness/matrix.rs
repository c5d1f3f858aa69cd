//! How strong the suite is: which cases catch which misreadings, and which misreadings it can tell apart.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Mutex;

use crate::harness::cases::Suite;
use crate::harness::check::{Plan, Run, check};
use crate::harness::diagnose::{applies, stream_once};
use crate::harness::judge::Outcome;
use crate::harness::misreadings::{self, Misreading};
use crate::harness::protocol::{Answer, Samples, View};
use crate::harness::run::Request;
use crate::reading::Reading;

/// What the suite makes of a decoder with one mistake.
pub struct Row {
    /// The mistake.
    pub misreading: &'static Misreading,
    /// The cases that fail, by their place in the suite.
    pub killed_by: Vec<usize>,
    /// A digest of its answer to every case.
    pub answers: Vec<u64>,
}

/// Answers, by case and view.
pub type Answers = HashMap<String, Answer>;

/// Runs the suite against every misreading, asked in `views` only, or in all if there are none. `progress` is told how
/// many of how many are done.
#[must_use]
pub fn matrix(
    suite: &Suite,
    views: &[&'static str],
    jobs: usize,
    progress: &dyn Fn(usize, usize),
) -> Vec<Row> {
    let (_, right) = ask_all(suite, &[], views, jobs, &HashMap::new());
    let row = |misreading| {
        let (run, answers) = ask_all(suite, &[misreading], views, jobs, &right);
        let judged = run.judgement.cases.iter().enumerate();
        let failed = judged.filter(|(_, judged)| {
            judged
                .as_ref()
                .is_some_and(|judged| judged.outcome == Outcome::Fail)
        });
        let digests = suite
            .cases
            .iter()
            .zip(&run.findings)
            .map(|(case, finding)| {
                let answer = finding
                    .as_ref()
                    .and_then(|finding| answers.get(&key(&case.id, &finding.view)));
                answer.map(digest).unwrap_or_default()
            });
        Row {
            misreading,
            killed_by: failed.map(|(i, _)| i).collect(),
            answers: digests.collect(),
        }
    };
    let all = misreadings::all().count();
    let done = |(i, row)| {
        progress(i + 1, all);
        row
    };
    misreadings::all().map(row).enumerate().map(done).collect()
}

/// A run of a decoder with these mistakes, and its answers. A file on which none of them can act is answered as in
/// `right`, where that is known.
pub fn ask_all(
    suite: &Suite,
    mistakes: &[&Misreading],
    views: &[&'static str],
    jobs: usize,
    right: &Answers,
) -> (Run, Answers) {
    let reading = Reading {
        stream: stream_once,
        ..Reading::SPEC
    };
    let answers = Mutex::new(HashMap::new());
    let ask = |request: &Request<'_>, _: usize| {
        let key = key(request.name, request.view);
        let concerned = mistakes
            .iter()
            .any(|mistake| applies(mistake, request.file));
        let known = right.get(&key).filter(|_| !concerned);
        let make = || misreadings::answer(mistakes, reading, request.file, request.view);
        let answer = known.cloned().unwrap_or_else(make);
        answers
            .lock()
            .expect("no worker panics")
            .insert(key, answer.clone());
        answer.into()
    };
    let plan = Plan {
        views: views.to_vec(),
        ..Plan::of(suite, jobs)
    };
    let run = check(suite, &plan, &ask, &|_, _, _, _| ());
    (run, answers.into_inner().expect("no worker panics"))
}

fn key(name: &str, view: &View) -> String {
    format!("{name} {view}")
}

fn digest(answer: &Answer) -> u64 {
    let mut hasher = DefaultHasher::new();
    answer.name().hash(&mut hasher);
    if let Answer::Decoded(frame) = answer {
        (frame.width, frame.height, frame.channels).hash(&mut hasher);
        match &frame.samples {
            Samples::U8(bytes) => bytes.hash(&mut hasher),
            Samples::F32(values) => values
                .iter()
                .for_each(|value| value.to_bits().hash(&mut hasher)),
        }
    }
    hasher.finish()
}
