//! The harness is tested against programs that answer wrongly, each in one way (`examples/zoo.rs`), and so that nothing
//! of them stays: no process, no file, no memory.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock};
use std::time::Duration;

use crate::common::{Checked, program, zoo};

/// A program of the zoo and what it is to be told.
struct Faulty {
    kind: &'static str,
    /// Besides those of [`FEW`].
    options: &'static [&'static str],
    /// The exit status of `check`.
    status: i32,
    /// Words of what is said.
    says: &'static [&'static str],
    fails: Fails,
}

/// The cases that fail.
enum Fails {
    /// None, and some pass.
    None,
    /// These.
    These(&'static [&'static str]),
    /// At least one.
    Some,
    /// It depends on who is faster: whether a case fails, or the run alone does.
    Any,
    /// So many: those that the fault can show in.
    Count(usize),
    /// Nobody is judged.
    NotJudged,
}

/// A few small cases of every kind, so that programs that hang take seconds.
const FEW: &[&str] = &[
    "--case",
    "hand-[fjpr]*",
    "--case",
    "hand-lrgb*",
    "--case",
    "hand-lum",
    "--case",
    "hand-lum-in-color",
    "--case",
    "version-1-3-lrgb",
    "--case",
    "version-1-3-rgb",
    "--case",
    "header-plain-*",
];

/// No right answer takes so long, however busy the machine is.
const PATIENT: &[&str] = &["--timeout", "60"];
/// For programs that never end.
const HASTY: &[&str] = &["--timeout", "1"];

const LUM: &[&str] = &["header-plain-lum", "hand-lum", "hand-lum-in-color"];

const fn passes(kind: &'static str, says: &'static [&'static str]) -> Faulty {
    Faulty {
        kind,
        options: PATIENT,
        status: 0,
        says,
        fails: Fails::None,
    }
}

const fn fails(kind: &'static str, says: &'static [&'static str], fails: Fails) -> Faulty {
    Faulty {
        kind,
        options: PATIENT,
        status: 1,
        says,
        fails,
    }
}

const fn is_no_decoder(kind: &'static str, says: &'static [&'static str]) -> Faulty {
    Faulty {
        kind,
        options: PATIENT,
        status: 3,
        says,
        fails: Fails::NotJudged,
    }
}

const fn hangs(kind: &'static str) -> Faulty {
    Faulty {
        kind,
        options: HASTY,
        status: 3,
        says: &["hang: no end within 3 s"],
        fails: Fails::NotJudged,
    }
}

/// Serves: nobody answers, so that all is asked one-shot and right.
const fn serves_not(kind: &'static str, says: &'static [&'static str]) -> Faulty {
    Faulty {
        kind,
        options: &["--timeout", "60", "--serve"],
        status: 1,
        says,
        fails: Fails::None,
    }
}

const fn serves(
    kind: &'static str,
    status: i32,
    says: &'static [&'static str],
    fails: Fails,
) -> Faulty {
    Faulty {
        kind,
        options: &["--timeout", "60", "--serve", "--jobs", "1"],
        status,
        says,
        fails,
    }
}

/// Those that answer.
const QUIET: &[Faulty] = &[
    passes("right", &["pass: 17 pass"]),
    passes("chatters", &["pass: 17 pass"]),
    passes("floods-errors", &["pass: 17 pass"]),
    passes("gigabytes-of-errors", &["pass: 17 pass"]),
    passes("a-million-writes", &["pass: 17 pass"]),
    passes("byte-by-byte", &["pass: 17 pass"]),
    passes("leaves-files", &["pass: 17 pass"]),
    passes("leaves-a-locked-directory", &["pass: 17 pass"]),
    passes("leaves-a-child", &["pass: 17 pass"]),
    passes("leaves-a-grandchild", &["pass: 17 pass"]),
    passes("leaves-a-hidden-child", &["pass: 17 pass"]),
    passes("leaves-a-link", &["pass: 17 pass"]),
    passes("moves-its-directory", &["pass: 17 pass"]),
    passes("leaves-a-daemon", &["pass: 17 pass"]),
    passes("leaves-orphans", &["pass: 17 pass"]),
    passes("keeps-zombies", &["pass: 17 pass"]),
    passes("fills-its-scratch", &["pass: 17 pass"]),
    passes("exhausts-descriptors", &["pass: 17 pass"]),
    passes("prints-before-reading", &["pass: 17 pass"]),
    is_no_decoder("refuses-all", &["decodes no first file"]),
    is_no_decoder("unsupported-all", &["69 (unsupported) in every view"]),
    is_no_decoder("exits-1", &["crash: exit status 1"]),
    is_no_decoder("exits-101", &["crash: exit status 101"]),
    is_no_decoder("aborts", &["crash: killed by signal 6"]),
    is_no_decoder("segfaults", &["crash: killed by signal 11"]),
    is_no_decoder(
        "says-nothing",
        &["protocol error: standard output is empty"],
    ),
    is_no_decoder("apologises", &["begins with"]),
    is_no_decoder("shows-nothing", &["an image without texels"]),
    is_no_decoder(
        "text-mode",
        &["CR LF", "set standard output to binary mode"],
    ),
    is_no_decoder("cuts-frame", &["announces"]),
    is_no_decoder("adds-a-byte", &["announces"]),
    is_no_decoder("announces-too-much", &["more bytes than can be counted"]),
    is_no_decoder("number-out-of-range", &["is not a number"]),
    is_no_decoder("floods", &["flood: more than"]),
    is_no_decoder(
        "deletes-its-input",
        &["tampering: the file it was given is changed or gone"],
    ),
    is_no_decoder("overwrites-its-input", &["tampering"]),
    is_no_decoder("links-its-input", &["tampering"]),
    is_no_decoder("input-becomes-a-pipe", &["tampering"]),
    fails("accepts-all", &["received raw 1x1"], Fails::Count(17)),
    fails(
        "accepts-malformed",
        &["accepted a file that must be refused"],
        Fails::Count(2),
    ),
    fails(
        "wrong-size",
        &["received raw 1x1 with 1 channels"],
        Fails::Count(15),
    ),
    fails(
        "crashes-on-malformed",
        &[
            "an empty file, and other malformed ones: exit status 1 counts as a crash",
            "use check --reject-exit 1",
            "see it again:\n  $ ",
        ],
        Fails::NotJudged,
    ),
    Faulty {
        options: &["--timeout", "60", "--reject-exit", "1"],
        ..passes("crashes-on-malformed", &["pass: 17 pass"])
    },
    fails(
        "crashes-on-lum",
        &["crashes (exit status 1) on 3 legal files"],
        Fails::These(LUM),
    ),
    fails(
        "differs-each-time",
        &["two calls returned different responses: a wrong image"],
        Fails::Count(15),
    ),
    fails(
        "upside-down",
        &["raw, coef, rgb: its rows are upside down, in all first files"],
        Fails::None,
    ),
    fails(
        "blue-first",
        &["rgb: red and blue are exchanged (BGR), in all first files"],
        Fails::None,
    ),
    fails(
        "halves",
        &[
            "raw: all values are divided by about 2.",
            "coef: all values are divided by about 2.000",
        ],
        Fails::None,
    ),
    fails(
        "brightens",
        &["rgb: the sRGB curve is applied to all values, in all first files"],
        Fails::None,
    ),
    fails(
        "high-byte-first",
        &[
            "coef: its f32 have the high byte first",
            "see it again:\n  $ ",
        ],
        Fails::NotJudged,
    ),
    fails(
        "cuts-large-frames",
        &["it ends before all is written", "see it again:\n  $ "],
        Fails::NotJudged,
    ),
    fails(
        "unsupported-once",
        &["decodes other files of this kind"],
        Fails::Count(1),
    ),
    passes("no-lum", &["unsupported (exit status 69): LUM, rgb of LUM"]),
    passes(
        "no-raw-of-rgb",
        &["unsupported (exit status 69): raw of RGB"],
    ),
    passes(
        "is-silent-about-lum",
        &["unsupported (exit status 69): LUM"],
    ),
    fails(
        "declares-lum-and-lacks-it",
        &["declare LUM, and it exits with 69"],
        Fails::These(LUM),
    ),
    passes("declares-rgb-only", &["pass: 17 pass"]),
    fails(
        "declares-coef-and-lacks-it",
        &["declare the view coef, and it exits with 69"],
        Fails::None,
    ),
    passes("declares-coef-only", &["pass: "]),
    passes("declares-exit-1", &["pass: 17 pass"]),
    passes(
        "declares-exit-0",
        &["note: capabilities: no exit status 0 can mean a refusal"],
    ),
    passes("declares-everything-and-fails", &["pass: 17 pass"]),
    passes("floods-when-asked-what-it-is", &["pass: 17 pass"]),
    passes("bombs-when-asked-what-it-is", &["pass: 17 pass"]),
    passes("babbles-when-asked-what-it-is", &["pass: 17 pass"]),
];

/// Those that are stopped by a limit.
const STOPPED: &[Faulty] = &[
    hangs("hangs"),
    hangs("hangs-and-ignores-term"),
    hangs("stops-itself"),
    hangs("drips"),
    hangs("closes-stdout-and-runs-on"),
    hangs("closes-everything-and-runs-on"),
    Faulty {
        options: &["--timeout", "60", "--memory", "150M"],
        ..is_no_decoder(
            "hoards",
            &["out of memory: its processes held more than 150 MiB"],
        )
    },
    Faulty {
        options: &["--timeout", "60", "--memory", "150M"],
        ..is_no_decoder(
            "hoards-by-a-child",
            &["out of memory: its processes held more than 150 MiB"],
        )
    },
    Faulty {
        options: &["--timeout", "8"],
        ..passes("hangs-when-asked-what-it-is", &["pass: 17 pass"])
    },
];

/// Those that serve.
const SERVING: &[Faulty] = &[
    passes("serves", &["pass: 17 pass"]),
    serves("serves", 0, &["pass: 17 pass"], Fails::None),
    serves(
        "serves-and-deletes-later",
        0,
        &["pass: 17 pass"],
        Fails::None,
    ),
    serves_not(
        "serves-not",
        &[
            "serve mode does not work",
            "ended (exit status 64) without an answer",
        ],
    ),
    fails(
        "declares-serve-and-lacks-it",
        &[
            "serve mode does not work",
            "ended (exit status 64) without an answer",
        ],
        Fails::None,
    ),
    serves_not(
        "serves-the-number-before",
        &[
            "serve mode does not work",
            "answers request 1 with the number 0",
        ],
    ),
    serves_not(
        "serves-the-wrong-number",
        &[
            "serve mode does not work",
            "answers request 1 with the number 4711",
        ],
    ),
    serves_not(
        "serves-interleaved",
        &["serve mode does not work", "protocol error"],
    ),
    serves_not(
        "serves-huge-numbers",
        &[
            "serve mode does not work",
            "announces 18446744073709551615 bytes, and no frame",
        ],
    ),
    serves_not(
        "serves-impossible-numbers",
        &["serve mode does not work", "expected \"1 ok NBYTES\""],
    ),
    serves_not(
        "serves-without-the-line",
        &["serve mode does not work", "the line of the frame included"],
    ),
    serves_not(
        "serves-bare-frames",
        &[
            "serve mode does not work",
            "a frame follows a separate line",
        ],
    ),
    serves_not(
        "serves-logs",
        &["serve mode does not work", "found \"decoding\""],
    ),
    serves_not(
        "serves-text-mode",
        &["serve mode does not work", "text mode"],
    ),
    Faulty {
        options: &["--timeout", "2", "--serve"],
        ..serves_not(
            "serves-without-flush",
            &[
                "serve mode does not work",
                "flush standard output after each answer",
            ],
        )
    },
    serves_not("serves-extra", &["in serve mode", "protocol error"]),
    serves(
        "serves-before-asked",
        1,
        &["in serve mode", "protocol error"],
        Fails::Any,
    ),
    serves(
        "serves-exit-codes",
        1,
        &["the code of a refusal is 65"],
        Fails::Count(2),
    ),
    serves(
        "serves-five-times",
        1,
        &["ended (exit status 0) without an answer; it had answered 5 requests"],
        Fails::Count(3),
    ),
    Faulty {
        options: &["--timeout", "2", "--serve", "--jobs", "1"],
        ..serves(
            "serves-five-times-and-ignores-the-rest",
            1,
            &["hang: no answer within 2 s"],
            Fails::Count(3),
        )
    },
    serves(
        "serves-until-lum",
        1,
        &["in serve mode, after first-rgb: crash: the serving process ended (killed by signal 6)"],
        Fails::These(LUM),
    ),
    Faulty {
        options: &["--timeout", "2", "--serve", "--jobs", "1"],
        ..serves(
            "serves-and-hangs-at-lum",
            1,
            &["hang: no answer within 2 s"],
            Fails::These(LUM),
        )
    },
    Faulty {
        options: &[
            "--timeout",
            "60",
            "--serve",
            "--jobs",
            "1",
            "--memory",
            "250M",
        ],
        ..serves(
            "serves-and-hoards",
            1,
            &["out of memory: its processes held more than 250 MiB"],
            Fails::Some,
        )
    },
    serves_not(
        "serves-and-deletes",
        &["serve mode does not work", "tampering"],
    ),
    serves(
        "serves-with-leaks",
        1,
        &["state leaks between files", "alone, with an image"],
        Fails::Count(11),
    ),
    serves(
        "serves-other-answers",
        1,
        &[
            "state leaks between files",
            "it answers with \"unsupported\"; alone, with an image",
        ],
        Fails::Some,
    ),
];

/// Numbers the runs, so that what one leaves is not mistaken for another's.
static RUNS: AtomicUsize = AtomicUsize::new(0);

/// Shows a faulty decoder to the harness: the verdict is exact, and nothing of it stays. Returns the most memory that the
/// harness held, in KiB.
#[track_caller]
fn show(faulty: &Faulty) -> u64 {
    let root = tempfile::tempdir().expect("a scratch directory");
    let nap = format!(
        "1000.{}{:06}",
        std::process::id(),
        RUNS.fetch_add(1, Ordering::Relaxed)
    );
    let temporary = root.path().join("a place");
    let precious = root.path().join("precious");
    for directory in [&temporary, &precious] {
        fs::create_dir(directory).expect("a directory");
    }
    fs::write(precious.join("file"), "precious").expect("a file");
    let report = root.path().join("report.yaml");
    let mut command = program();
    command
        .env("TMPDIR", &temporary)
        .env("ZOO_NAP", &nap)
        .env("ZOO_PRECIOUS", &precious)
        .arg("check")
        .args(FEW)
        .args(faulty.options)
        .arg("--report")
        .arg(&report)
        .args(["--", &zoo(), faulty.kind]);
    let (checked, memory) = crate::common::measured(command, &report);
    judge(faulty, &checked);
    assert_eq!(
        fs::read_to_string(precious.join("file")).ok().as_deref(),
        Some("precious"),
        "{}",
        faulty.kind
    );
    let left: Vec<_> = fs::read_dir(&temporary)
        .expect("a directory")
        .flatten()
        .map(|entry| entry.path())
        .collect();
    assert!(left.is_empty(), "{}: {left:?} stay", faulty.kind);
    let alive = processes_of(&nap, root.path());
    assert!(alive.is_empty(), "{}: {alive:?} survive", faulty.kind);
    memory
}

#[track_caller]
fn judge(faulty: &Faulty, checked: &Checked) {
    let Faulty {
        kind, status, says, ..
    } = faulty;
    assert_eq!(checked.status, *status, "{kind}: {}", checked.text);
    for says in *says {
        assert!(
            checked.text.contains(says),
            "{kind} should be told {says:?}:\n{}",
            checked.text
        );
    }
    let failing = checked.cases("fail");
    let passing = checked.cases("pass").len();
    match faulty.fails {
        Fails::None => assert!(failing.is_empty() && passing > 0, "{kind}: {failing:?}"),
        Fails::These(cases) => {
            let mut cases = cases.to_vec();
            let mut failing = failing.clone();
            cases.sort_unstable();
            failing.sort_unstable();
            assert_eq!(failing, cases, "{kind}");
        }
        Fails::Count(count) => assert_eq!(
            failing.len(),
            count,
            "{kind}: {failing:#?}\n{}",
            checked.text
        ),
        Fails::Some => assert!(!failing.is_empty(), "{kind}: {}", checked.text),
        Fails::Any => assert!(failing.len() + passing > 0, "{kind}: {}", checked.text),
        Fails::NotJudged => assert_eq!((failing.len(), passing), (0, 0), "{kind}"),
    }
}

/// Processes that sleep so long, or work below `root`, a moment after the run.
fn processes_of(nap: &str, root: &Path) -> Vec<String> {
    if !Path::new("/proc/self/cmdline").exists() {
        println!("SKIPPED: there is no /proc to look for processes in");
        return Vec::new();
    }
    let mark = format!("TMPDIR={}", root.display());
    let look = || -> Vec<String> {
        let processes = fs::read_dir("/proc").expect("/proc").filter_map(|entry| {
            let process = entry.ok()?.path();
            let command = fs::read(process.join("cmdline")).ok()?;
            let command = String::from_utf8_lossy(&command).replace('\0', " ");
            let environment = fs::read(process.join("environ")).unwrap_or_default();
            let works_here = String::from_utf8_lossy(&environment).contains(&mark);
            (command.contains(nap) || works_here).then_some(command)
        });
        processes.collect()
    };
    // The watcher may take a moment to go.
    for _ in 0..50 {
        if look().is_empty() {
            return Vec::new();
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    look()
}

/// The harness holds the suite and little else, whatever a decoder does.
const MOST_MEMORY: u64 = 100 << 10;

/// The memory that the harness held, or what went wrong.
fn shown(faulty: &Faulty) -> Result<u64, String> {
    std::panic::catch_unwind(|| show(faulty)).map_err(|panic| {
        let words = panic.downcast_ref::<String>().cloned();
        words.unwrap_or_else(|| faulty.kind.to_owned())
    })
}

/// All are shown before any failure is told, a few at a time: most of them wait.
#[track_caller]
fn show_all(all: &[Faulty]) {
    const AT_A_TIME: usize = 3;
    let next = AtomicUsize::new(0);
    let wrong = Mutex::new(Vec::new());
    let shower = || {
        while let Some(faulty) = all.get(next.fetch_add(1, Ordering::Relaxed)) {
            let kind = faulty.kind;
            let problem = match shown(faulty) {
                Ok(memory) if memory <= MOST_MEMORY => continue,
                Ok(memory) => format!("{kind}: the harness held {memory} KiB"),
                Err(problem) => problem,
            };
            wrong.lock().expect("no panic is kept").push(problem);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..AT_A_TIME {
            scope.spawn(shower);
        }
    });
    let wrong = wrong.into_inner().expect("no panic is kept");
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn each_that_answers_gets_its_verdict() {
    show_all(QUIET);
}

#[test]
fn each_that_does_not_end_is_stopped() {
    show_all(STOPPED);
}

#[test]
fn each_that_serves_gets_its_verdict() {
    show_all(SERVING);
}

/// All of them again and again while every processor is busy, a few at a time: `PTM_ZOO_RUNS=20 cargo test --release \
/// --test zoo -- --ignored --nocapture`.
#[test]
#[ignore = "takes half an hour"]
fn verdicts_are_the_same_under_load() {
    const AT_A_TIME: usize = 4;
    let runs = std::env::var("PTM_ZOO_RUNS")
        .ok()
        .and_then(|runs| runs.parse().ok())
        .unwrap_or(20);
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let _load = crate::common::Load::new(processors);
    let all: Vec<&Faulty> = [QUIET, STOPPED, SERVING].into_iter().flatten().collect();
    // What the harness held when it was shown a faulty decoder first, in KiB.
    let first: Vec<OnceLock<u64>> = all.iter().map(|_| OnceLock::new()).collect();
    let next = AtomicUsize::new(0);
    let wrong = Mutex::new(Vec::new());
    let shower = || {
        loop {
            let turn = next.fetch_add(1, Ordering::Relaxed);
            let (run, i) = (turn / all.len(), turn % all.len());
            if run == runs {
                break;
            }
            if i == 0 {
                println!("run {} of {runs}", run + 1);
            }
            let kind = all[i].kind;
            let problem = match shown(all[i]) {
                Ok(memory) => {
                    let first = *first[i].get_or_init(|| memory);
                    (memory > first + 8 * 1024)
                        .then(|| format!("the harness held {memory} KiB, and {first} at first"))
                }
                Err(problem) => Some(problem),
            };
            if let Some(problem) = problem {
                let problem = format!("run {}, {kind}: {problem}", run + 1);
                wrong.lock().expect("no panic is kept").push(problem);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..AT_A_TIME {
            scope.spawn(shower);
        }
    });
    let wrong = wrong.into_inner().expect("no panic is kept");
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
    println!(
        "{runs} runs of {} faulty decoders: all verdicts are right",
        all.len()
    );
}

#[test]
fn a_decimal_comma_is_found_where_a_locale_writes_one() {
    // A machine without such a locale gets a program that lists one; the decoder looks at LC_ALL alone.
    let root = tempfile::tempdir().expect("a scratch directory");
    let locale = root.path().join("locale");
    fs::write(&locale, "#!/bin/sh\necho C\necho de_DE.utf8\n").expect("a script");
    crate::common::make_executable(&locale);
    let path = format!(
        "{}:{}",
        root.path().display(),
        std::env::var("PATH").unwrap_or_default()
    );
    let check = |kind: &str| {
        let report = root.path().join("report.yaml");
        let mut command = program();
        command
            .env("PATH", &path)
            .arg("check")
            .args(FEW)
            .args(PATIENT)
            .arg("--report")
            .arg(&report)
            .args(["--", &zoo(), kind]);
        crate::common::measured(command, &report).0
    };
    let checked = check("reads-commas");
    assert_eq!(checked.status, 1, "{}", checked.text);
    assert!(checked.text.contains("FAIL: in the locale de_DE.utf8, which writes numbers with a comma, first-rgb in coef gives another image"), "{}", checked.text);
    assert!(checked.cases("fail").is_empty());
    assert_eq!(check("right").status, 0);
}
