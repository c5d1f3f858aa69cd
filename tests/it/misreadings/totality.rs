//! Every misreading returns, whatever it is given and whatever another one left of it: no panic, no room that only a file
//! claims, no endless loop.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use ptm_conform::Reading;
use ptm_conform::decode::fields;
use ptm_conform::fuzz::draws::Draws;
use ptm_conform::misreadings::{self, Misreading, answer};
use ptm_conform::protocol::frame::View;
use ptm_conform::suite::cases::{Suite, TableSpelling};

/// Bytes of a file that is tried: the suite has a kind of everything in smaller ones.
const LARGEST: usize = 8 << 10;
/// Texels that a file may claim, so that the time goes into files and not into planes.
const MOST_TEXELS: u64 = 1 << 16;

/// Numbers without a pattern, the same everywhere.
struct Draw(u64);

impl Draw {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end as u64) as usize
    }

    fn byte(&mut self) -> u8 {
        self.below(256) as u8
    }

    /// One edit of the bytes, most of them near the beginning, where the header is.
    fn edit(&mut self, file: &mut Vec<u8>) {
        let reach = if self.below(4) == 0 {
            file.len()
        } else {
            file.len().min(200)
        };
        let at = self.below(reach + 1);
        let numbers: [&[u8]; 8] = [
            b"0",
            b"-1",
            b"255",
            b"256",
            b"65536",
            b"4294967296",
            b"1e300",
            b"99999999999999999999",
        ];
        match self.below(7) {
            0 => file.truncate(at),
            1 => file.insert(at, self.byte()),
            2 if at < file.len() => file[at] = self.byte(),
            3 if at < file.len() => drop(file.remove(at)),
            4 => file.insert(at, b" \n\t-.9"[self.below(6)]),
            5 => drop(file.splice(at..at, numbers[self.below(8)].iter().copied())),
            _ => {
                let end = (at + self.below(12)).min(file.len());
                let piece = file[at..end].to_vec();
                file.splice(at..at, piece);
            }
        }
    }

    /// The file after one to four edits.
    fn edited(&mut self, file: &[u8]) -> Vec<u8> {
        let mut file = file.to_vec();
        for _ in 0..=self.below(4) {
            self.edit(&mut file);
        }
        file
    }
}

/// Whether a file claims no more texels than are worth the time.
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

/// Each of these files, and beside it a damaged copy.
fn damaged_too(
    files: impl Iterator<Item = (String, Vec<u8>)>,
    draw: &mut Draw,
) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for (name, file) in files {
        let edited = draw.edited(&file);
        all.push((format!("{name}, damaged"), edited));
        all.push((name, file));
    }
    all.retain(|(_, file)| is_small(file));
    all
}

/// The files of the suite, legal and damaged, and bytes of no format.
fn files_of_the_suite(draw: &mut Draw) -> Vec<(String, Vec<u8>)> {
    let suite = Suite::load().expect("the suite loads");
    let files = suite.cases.iter().map(|case| {
        let built = case.build(TableSpelling::default());
        (case.id.clone(), built.file.clone())
    });
    let mut files = damaged_too(files, draw);
    for length in (0..600).step_by(3) {
        files.push((
            format!("{length} bytes"),
            (0..length).map(|_| draw.byte()).collect(),
        ));
    }
    files
}

/// Asks a decoder with two mistakes, and says what came of it if it was no answer.
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
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
    let mut wrong = wrong.into_inner().expect("no holder panics");
    wrong.sort_unstable();
    let some = wrong
        .iter()
        .take(20)
        .cloned()
        .collect::<Vec<_>>()
        .join("\n");
    assert!(wrong.is_empty(), "{} of {count}:\n{some}", wrong.len());
}

fn views() -> [View; 3] {
    ["raw", "coef", View::ORDINARY_LIGHT].map(|view| view.parse().expect("a view"))
}

#[test]
fn any_misreading_after_any_other_returns() {
    let files = files_of_the_suite(&mut Draw(0x9e37_79b9_7f4a_7c15));
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
    let draws = Draws::of(&suite);
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
        let mut draw = Draw(number as u64 * 2 + 1);
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
