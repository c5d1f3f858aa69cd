//! How strong the suite is: which cases catch which misreadings, and which misreadings it can tell apart.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, Mutex};

use crate::harness::cases::Suite;
use crate::harness::check::{Plan, check};
use crate::harness::judge::Outcome;
use crate::harness::misreadings::{self, Misreading};
use crate::harness::protocol::{Answer, Samples};
use crate::harness::run::{Reply, Request};
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

/// Runs the suite against every misreading, asked in `views` only, or in all if there are none.
#[must_use]
pub fn matrix(suite: &Suite, views: &[&'static str], jobs: usize) -> Vec<Row> {
    misreadings::all()
        .map(|misreading| row(suite, misreading, views, jobs))
        .collect()
}

fn row(suite: &Suite, misreading: &'static Misreading, views: &[&'static str], jobs: usize) -> Row {
    let digests = Mutex::new(HashMap::new());
    let ask = |request: &Request<'_>, _: usize| {
        let answer = misreadings::answer(&[misreading], Reading::SPEC, request.file, request.view);
        digests
            .lock()
            .expect("no worker panics")
            .insert(request.name.to_owned(), digest(&answer));
        Reply {
            answer,
            stderr: String::new(),
            exit: None,
        }
    };
    let plan = Plan {
        selected: vec![true; suite.cases.len()],
        jobs,
        views: views.to_vec(),
        stop: Arc::default(),
    };
    let run = check(suite, &plan, &ask, &|_, _, _, _| ());
    let failed = run.judgement.cases.iter().enumerate();
    let killed_by = failed
        .filter(|(_, judged)| {
            judged
                .as_ref()
                .is_some_and(|judged| judged.outcome == Outcome::Fail)
        })
        .map(|(i, _)| i)
        .collect();
    let digests = digests.into_inner().expect("no worker panics");
    let answers = suite
        .cases
        .iter()
        .map(|case| digests.get(&case.id).copied().unwrap_or_default())
        .collect();
    Row {
        misreading,
        killed_by,
        answers,
    }
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
