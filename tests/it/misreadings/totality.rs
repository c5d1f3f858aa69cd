//! Every misreading returns for any file, also after another misreading: no panic, no memory that only a file claims, no
//! endless loop.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use ptm_conform::Reading;
use ptm_conform::decode::fields;
use ptm_conform::fuzz::draws;
use ptm_conform::misreadings::{self, Misreading, answer};
use ptm_conform::protocol::frame::View;
use ptm_conform::suite::cases::{Suite, TableSpelling};

use crate::draws::DraftGenerator;
use crate::in_process::jobs;

/// Bytes of a file that is tried: the suite has a kind of everything in smaller ones.
const LARGEST: usize = 8 << 10;
/// Texels that a file may claim, so that the time goes into files and not into planes.
const MOST_TEXELS: u64 = 1 << 16;

/// Returns true if a file claims no more texels than are worth the time.
fn is_small(file: &[u8]) -> bool {
    let sizes = fields(file)
        .0
        .into_iter()
        .filter(|field| field.clause == "2.3/1");
    let texels = sizes.fold(1u64, |texels, field| {
        let digits = String::from_utf8_lossy(&file[field.range]).into_owned();
        texels.saturating_mul(digits.parse().unwrap_or(1))
    });
    file.len() <= LARGEST && texels <= MOST_TEXELS
}

/// Returns small files, each together with a copy after one to four edits.
fn damaged_too(
    files: impl Iterator<Item = (String, Vec<u8>)>,
    draws: &mut DraftGenerator,
) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for (name, file) in files {
        let mut edited = file.clone();
        draws.damage(&mut edited, 200);
        all.push((format!("{name}, damaged"), edited));
        all.push((name, file));
    }
    all.retain(|(_, file)| is_small(file));
    all
}

/// The files of the suite, legal and damaged, and bytes of no format.
fn files_of_the_suite(draws: &mut DraftGenerator) -> Vec<(String, Vec<u8>)> {
    let suite = Suite::load().expect("the suite loads");
    let files = suite.cases.iter().map(|case| {
        let built = case.build(TableSpelling::default());
        (case.id.clone(), built.file.clone())
    });
    let mut files = damaged_too(files, draws);
    for length in (0..600).step_by(3) {
        let bytes = (0..length).map(|_| draws.byte()).collect();
        files.push((format!("{length} bytes"), bytes));
    }
    files
}

/// Asks a decoder with two mistakes; returns a message if it panics.
fn tried(pair: [&Misreading; 2], name: &str, file: &[u8], view: &View) -> Option<String> {
    let asked = AssertUnwindSafe(|| drop(answer(&pair, Reading::SPEC, file, view)));
    let panic = catch_unwind(asked).err()?;
    let words = panic.downcast_ref::<String>().cloned();
    let words = words.or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string));
    let [first, second] = pair.map(|misreading| misreading.slug);
    Some(format!(
        "{first}, then {second}, on {name}: {}",
        words.unwrap_or_default()
    ))
}

/// Runs `count` trials on all processors and fails with what some of them said.
fn run(count: usize, trial: impl Fn(usize) -> Option<String> + Sync) {
    let (next, wrong) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        while let Some(i) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&i| i < count) {
            if let Some(words) = trial(i) {
                wrong.lock().expect("no holder panics").push(words);
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
    ["raw", "coef", View::ORDINARY_LIGHT].map(|view| view.parse().expect("a view"))
}

#[test]
fn any_two_misreadings_terminate() {
    let files = files_of_the_suite(&mut DraftGenerator(0x9e37_79b9));
    let all: Vec<&Misreading> = misreadings::all().collect();
    let views = views();
    // Every ordered pair, each on another file.
    run(all.len() * all.len(), |i| {
        let pair = [all[i / all.len()], all[i % all.len()]];
        let (name, file) = &files[i * 7919 % files.len()];
        tried(pair, name, file, &views[i % 3])
    });
}

#[test]
#[ignore = "runs for half an hour"]
fn any_misreading_after_any_other_returns_on_drawn_files() {
    let suite = Suite::load().expect("the suite loads");
    let draws = draws::DraftGenerator::new(&suite);
    let all: Vec<&Misreading> = misreadings::all().collect();
    let views = views();
    let tries = AtomicUsize::new(0);
    run(10_000, |number| {
        let draft = draws.file(1, number as u64)?;
        let cases = draft.cases("drawn").ok()?;
        let built = cases.iter().map(|case| {
            let built = case.build(TableSpelling::default());
            (format!("file {number}"), built.file.clone())
        });
        let mut draw = DraftGenerator(number as u32 * 2 + 1);
        let files = damaged_too(built.take(1), &mut draw);
        let mut wrong = None;
        for (name, file) in &files {
            for i in 0..200 {
                let pair = [all[draw.below(all.len())], all[draw.below(all.len())]];
                wrong = wrong.or(tried(pair, name, file, &views[i % 3]));
                tries.fetch_add(1, Ordering::Relaxed);
            }
        }
        wrong
    });
    println!("{} tries", tries.into_inner());
}
