//! Growth with the number of cases, for 100 to 100,000 generated cases that are checked in one run in this process.

use std::fmt::Write;
use std::fs;
use std::sync::Mutex;

use ptm::Format;
use ptm::Reading;
use ptm_harness::pipeline::{Check, FinishedCase, Observer, check};
use ptm_harness::session::{plan::RunPlan, run::Run};
use ptm_mistakes::answer;
use ptm_suite::cases::Suite;
use ptm_suite::protocol::request::{Reply, Request};

use crate::measure::{own_time, slope};

pub fn growth() {
    println!(
        "| cases | time per case, µs | suite, bytes per case | results, bytes per case | growth after the first tenth of the cases, bytes per case |"
    );
    println!("|---|---|---|---|---|");
    let mut times = Vec::new();
    for count in [100, 1000, 10_000, 100_000] {
        let before = memory();
        let suite = suite(count);
        let with_suite = memory();
        let mut run = None;
        let recorded = Mutex::new([0.0; 2]);
        let record_memory = |done: usize| match done {
            _ if done == count / 10 => recorded.lock().expect("no worker panics")[0] = memory(),
            _ if done == count => recorded.lock().expect("no worker panics")[1] = memory(),
            _ => {}
        };
        let spent = own_time(|| run = Some(run_all(&suite, record_memory))).processor;
        let with_results = memory();
        let [first_tenth, end] = recorded.into_inner().expect("no worker panics");
        println!(
            "| {count} | {:.0} | {:.0} | {:.0} | {:.0} |",
            spent / count as f64 * 1e6,
            (with_suite - before) / count as f64,
            (with_results - with_suite) / count as f64,
            (end - first_tenth) / (count as f64 * 0.9),
        );
        times.push((count as f64, spent));
    }
    println!("\nslope of time: {:.2}", slope(&times));
}

/// Returns the resident memory of this process in bytes.
fn memory() -> f64 {
    let status = fs::read_to_string("/proc/self/status").expect("Linux");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<f64>().ok());
    kilobytes.expect("a number of kilobytes") * 1024.0
}

/// Returns a suite with `count` cases of all formats, with different seeds.
fn suite(count: usize) -> Suite {
    let mut text = String::new();
    for (i, format) in Format::ALL.into_iter().enumerate() {
        let seeds = (count + 8 - i) / 9;
        let seeds: Vec<String> = (1..=seeds).map(|seed| format!("\"{seed}\"")).collect();
        let name = format.short_name();
        writeln!(
            text,
            "- id: generated-{}-{{seed}}\n  clauses: [\"1.0/1\"]\n  because: one of many\n  expect: decode\n  for_each: {{ seed: [{}] }}\n  make: {{ format: {name}, size: 9x7, seed: \"{{seed}}\" }}\n  first: false",
            name.to_lowercase().replace('_', "-"),
            seeds.join(", "),
        )
        .expect("memory");
    }
    // Without a first file, the program under test does not count as a decoder.
    text.push_str("- { id: first, clauses: [\"1.0/1\"], because: first, expect: decode, first: true, make: { format: RGB, size: 2x2 } }\n");
    Suite::from_files(&[("generated.yaml", &text)]).expect("legal cases")
}

/// Checks all cases with the reference. Calls `progress` after each case, with the number of finished cases.
fn run_all(suite: &Suite, progress: impl Fn(usize) + Sync) -> Run {
    let plan = RunPlan::new(suite, 1);
    let ask = |request: &Request<'_>, _: usize| {
        Reply::from(answer(&[], Reading::SPEC, request.file, request.view))
    };
    let check_of_answers = Check::of_answers(suite, &plan);
    let checked = check(&check_of_answers, &ask, &Progress(progress));
    let run = checked.expect("a function has no trouble").run;
    assert_eq!(run.exit_status(), 0, "the reference passes");
    run
}

/// Calls a function after each case, with the number of finished cases.
struct Progress<F>(F);

impl<F: Fn(usize) + Sync> Observer for Progress<F> {
    fn case_finished(&self, _: &FinishedCase, done: usize, _: usize) {
        (self.0)(done);
    }
}
