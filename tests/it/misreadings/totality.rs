//! Tests that no misreading panics, hangs or uses excessive memory on any file, even one changed by another misreading.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use ptm::Reading;
use ptm::decode::fields;
use ptm_harness::fuzz::generator;
use ptm_mistakes::{Misreading, answer};
use ptm_suite::cases::{Suite, TableSpelling};
use ptm_suite::protocol::frame::View;

use crate::in_process::jobs;
use crate::random::Rng;

/// Maximum size of a tested file in bytes. Smaller files of the suite cover everything.
const MAX_FILE_BYTES: usize = 8 << 10;
/// Maximum number of texels in a tested file. A few large maps would take most of the time.
const MAX_TEXELS: u64 = 1 << 16;

/// Returns true if a file is small enough to test.
fn is_small(file: &[u8]) -> bool {
    let sizes = fields(file)
        .0
        .into_iter()
        .filter(|field| field.clause == "2.3/1");
    let texels = sizes.fold(1u64, |texels, field| {
        let digits = String::from_utf8_lossy(&file[field.range]).into_owned();
        texels.saturating_mul(digits.parse().unwrap_or(1))
    });
    file.len() <= MAX_FILE_BYTES && texels <= MAX_TEXELS
}

/// Returns the small files, each with a copy that has one to four random edits.
fn with_damaged_copies(
    files: impl Iterator<Item = (String, Vec<u8>)>,
    rng: &mut Rng,
) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for (name, file) in files {
        let mut edited = file.clone();
        rng.damage(&mut edited, 200);
        all.push((format!("{name}, damaged"), edited));
        all.push((name, file));
    }
    all.retain(|(_, file)| is_small(file));
    all
}

/// Returns the files of the suite, legal and damaged, and files with random bytes.
fn suite_files(rng: &mut Rng) -> Vec<(String, Vec<u8>)> {
    let suite = Suite::load().expect("the suite loads");
    let files = suite.cases.iter().map(|case| {
        let built = case.build(TableSpelling::default());
        (case.id.clone(), built.file.clone())
    });
    let mut files = with_damaged_copies(files, rng);
    for length in (0..600).step_by(3) {
        let bytes = (0..length).map(|_| rng.byte()).collect();
        files.push((format!("{length} bytes"), bytes));
    }
    files
}

/// Runs a decoder with two mistakes. Returns a message if it panics.
fn try_pair(pair: [&Misreading; 2], name: &str, file: &[u8], view: &View) -> Option<String> {
    let call = AssertUnwindSafe(|| drop(answer(&pair, Reading::SPEC, file, view)));
    let panic = catch_unwind(call).err()?;
    let message = panic.downcast_ref::<String>().cloned();
    let message = message.or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string));
    let [first, second] = pair.map(|misreading| misreading.slug);
    Some(format!(
        "{first}, then {second}, on {name}: {}",
        message.unwrap_or_default()
    ))
}

/// Runs `count` trials on all processors. Fails with the first messages in alphabetical order.
fn run_trials(count: usize, trial: impl Fn(usize) -> Option<String> + Sync) {
    let (next, wrong) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        while let Some(i) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&i| i < count) {
            if let Some(message) = trial(i) {
                wrong.lock().expect("no holder panics").push(message);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..jobs() {
            scope.spawn(work);
        }
    });
    let mut wrong = wrong.into_inner().expect("no holder panics");
    wrong.sort_unstable();
    let some = wrong[..wrong.len().min(20)].join("\n");
    assert!(wrong.is_empty(), "{} of {count}:\n{some}", wrong.len());
}

fn views() -> [View; 3] {
    ["raw", "coef", View::DEFAULT_RGB].map(|view| view.parse().expect("a view"))
}

#[test]
fn any_two_misreadings_terminate() {
    let files = suite_files(&mut Rng(0x9e37_79b9));
    let all: Vec<&Misreading> = ptm_mistakes::all().collect();
    let views = views();
    // Every ordered pair, each on a different file.
    run_trials(all.len() * all.len(), |i| {
        let pair = [all[i / all.len()], all[i % all.len()]];
        let (name, file) = &files[i * 7919 % files.len()];
        try_pair(pair, name, file, &views[i % 3])
    });
}

#[test]
#[ignore = "takes half an hour"]
fn any_two_misreadings_terminate_on_random_files() {
    let suite = Suite::load().expect("the suite loads");
    let drafts = generator::DraftGenerator::new(&suite);
    let all: Vec<&Misreading> = ptm_mistakes::all().collect();
    let views = views();
    let trials = AtomicUsize::new(0);
    run_trials(10_000, |number| {
        let draft = drafts.file(1, number as u64)?;
        let cases = draft.cases("drawn").ok()?;
        let built = cases.iter().map(|case| {
            let built = case.build(TableSpelling::default());
            (format!("file {number}"), built.file.clone())
        });
        let mut rng = Rng(number as u32 * 2 + 1);
        let files = with_damaged_copies(built.take(1), &mut rng);
        let mut wrong = None;
        for (name, file) in &files {
            for i in 0..200 {
                let pair = [
                    all[rng.next_below(all.len())],
                    all[rng.next_below(all.len())],
                ];
                wrong = wrong.or(try_pair(pair, name, file, &views[i % 3]));
                trials.fetch_add(1, Ordering::Relaxed);
            }
        }
        wrong
    });
}
