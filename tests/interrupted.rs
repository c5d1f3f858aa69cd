//! Runs that are killed, and runs that are long: nothing is lost, nothing stays, nothing grows.
#![cfg(all(unix, feature = "cli"))]

mod common;

use std::collections::HashSet;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant, SystemTime};

use ptm_conform::harness::cases::{Case, Suite};
use ptm_conform::harness::check::{Plan, check};
use ptm_conform::harness::report::Report;
use ptm_conform::harness::run::{Decoder, Request};
use ptm_conform::harness::scratch::Scratch;
use ptm_conform::harness::serve::Servers;

use common::{program, zoo};

/// `PTM_KILLS=20` for more.
fn kills() -> u32 {
    std::env::var("PTM_KILLS")
        .ok()
        .and_then(|kills| kills.parse().ok())
        .unwrap_or(4)
}

/// Some number of milliseconds below 1500.
fn some_time() -> Duration {
    let now = SystemTime::now()
        .duration_since(SystemTime::UNIX_EPOCH)
        .expect("it is later");
    Duration::from_millis(u64::from(now.subsec_micros() % 1500))
}

#[test]
fn a_run_that_is_killed_leaves_what_it_found_and_no_process() {
    if !Path::new("/proc/self/environ").exists() {
        println!("SKIPPED: there is no /proc to look for processes in");
        return;
    }
    for kill in 0..kills() {
        let root = tempfile::tempdir().expect("a scratch directory");
        let temporary = root.path().join("tmp");
        fs::create_dir(&temporary).expect("a directory");
        let report = root.path().join("report.yaml");
        let kind = ["right", "leaves-a-grandchild", "serves", "hangs"][kill as usize % 4];
        let mut run = program()
            .env("TMPDIR", &temporary)
            .env("ZOO_NAP", format!("1001.{}", std::process::id()))
            .args(["check", "--report"])
            .arg(&report)
            .args(["--", &zoo(), kind])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        let after = some_time();
        std::thread::sleep(after);
        let finished = run.try_wait().expect("it can be asked").is_some();
        run.kill().expect("it can be killed");
        run.wait().expect("it is dead");
        let killed = Instant::now();
        let deadline = killed + Duration::from_secs(10);
        while !processes_below(&temporary).is_empty() && Instant::now() < deadline {
            std::thread::sleep(Duration::from_millis(50));
        }
        let alive = processes_below(&temporary);
        assert!(
            alive.is_empty(),
            "{kind} after {after:?}: {alive:?} survive"
        );
        println!(
            "{kind}, killed after {after:?}: its last process is gone {:?} later",
            killed.elapsed()
        );
        while fs::read_dir(&temporary)
            .expect("a directory")
            .next()
            .is_some()
            && Instant::now() < deadline
        {
            std::thread::sleep(Duration::from_millis(50));
        }
        assert_eq!(
            fs::read_dir(&temporary).expect("a directory").count(),
            0,
            "{kind} after {after:?}"
        );
        let partial = root.path().join("report.yaml.partial");
        if finished || !partial.exists() {
            continue;
        }
        let text = fs::read_to_string(&partial).expect("a text");
        if text.is_empty() {
            continue;
        }
        let found: Vec<serde_json::Value> = serde_saphyr::from_str(&text)
            .unwrap_or_else(|error| panic!("{kind} after {after:?}: {error}\n{text}"));
        let ids: HashSet<&str> = found
            .iter()
            .filter_map(|case| case["id"].as_str())
            .collect();
        assert_eq!(ids.len(), found.len(), "each case is there once");
        assert_eq!(found.len(), text.lines().count());
    }
}

fn processes_below(place: &Path) -> Vec<String> {
    let mark = format!("TMPDIR={}", place.display());
    let processes = fs::read_dir("/proc")
        .expect("/proc")
        .flatten()
        .filter_map(|entry| {
            let environment = fs::read(entry.path().join("environ")).ok()?;
            let command = fs::read(entry.path().join("cmdline")).ok()?;
            let is_below = String::from_utf8_lossy(&environment)
                .split('\0')
                .any(|variable| variable.starts_with(&mark));
            is_below.then(|| String::from_utf8_lossy(&command).replace('\0', " "))
        });
    processes.collect()
}

/// The suite over and over under new names, `count` cases in all.
fn long_suite(count: usize) -> Suite {
    let suite = Suite::load().expect("the suite is sound");
    let copy = |i: usize| {
        let mut case: Case = suite.cases[i % suite.cases.len()].clone();
        let round = i / suite.cases.len();
        if round > 0 {
            case.id = format!("{}-copy-{round}", case.id);
            case.twin_of = case.twin_of.map(|id| format!("{id}-copy-{round}"));
            case.first = false;
        }
        case
    };
    Suite {
        cases: (0..count).map(copy).collect(),
    }
}

/// Memory that this process holds, in KiB; 0 where the system does not tell.
fn memory() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let held = status.lines().find_map(|line| {
        line.strip_prefix("VmRSS:")?
            .trim()
            .strip_suffix(" kB")?
            .parse()
            .ok()
    });
    held.unwrap_or_default()
}

#[test]
fn ten_thousand_cases_take_no_more_memory_than_their_findings() {
    const COUNT: usize = 10_000;
    let command = [env!("CARGO_BIN_EXE_ptm-conform").into(), "reference".into()];
    let mut decoder = Decoder::new(&command).expect("a directory");
    decoder.timeout = Duration::from_secs(60);
    let suite = long_suite(COUNT);
    let scratch = Scratch::new().expect("a scratch directory");
    let servers = Servers::new(&decoder, &scratch, 2);
    let ask = |request: &Request<'_>, job: usize| servers.ask(request, job);
    // Largest after every thousandth case; the first thousand warm the allocator up.
    let held: Vec<AtomicU64> = (0..=COUNT / 1000).map(|_| AtomicU64::new(0)).collect();
    let run = check(&suite, &Plan::of(&suite, 2), &ask, &|_, _, done, _| {
        if done % 100 == 0 {
            held[done / 1000].fetch_max(memory(), Relaxed);
        }
    });
    assert_eq!(run.exit_status(), 0, "{:?}", run.remarks);
    let held: Vec<u64> = held.into_iter().map(AtomicU64::into_inner).collect();
    println!("KiB held in every thousand of cases: {held:?}");
    // A finding is some hundred bytes.
    let (early, late) = (held[1], held[COUNT / 1000 - 1]);
    assert!(late < early + (COUNT as u64) + 4096, "{held:?} KiB");
    let report = Report::new(
        &suite,
        &run,
        &[],
        &["reference".to_owned()],
        vec!["none".to_owned()],
    );
    assert_eq!(report.cases.len(), COUNT);
    let text = report.to_yaml().expect("a report");
    let value: serde_json::Value = serde_saphyr::from_str(&text).expect("it is YAML");
    let errors = common::report_errors(&value);
    assert!(errors.is_empty(), "{errors:#?}");
}
