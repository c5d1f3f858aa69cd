//! Runs that are killed, and runs that are long: nothing is lost, nothing stays, nothing grows.

use std::collections::HashSet;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant, SystemTime};

use ptm_conform::report::Report;
use ptm_conform::runner::run::{Decoder, Request};
use ptm_conform::runner::scratch::Scratch;
use ptm_conform::runner::serve::Servers;
use ptm_conform::session::plan::RunPlan;
use ptm_conform::session::run::check;
use ptm_conform::suite::cases::{Case, Suite};

use crate::common::{program, zoo};

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
        let found: Vec<serde_json::Value> = ptm_conform::kit::yaml::from_yaml(&text)
            .unwrap_or_else(|error| panic!("{kind} after {after:?}: {error}\n{text}"));
        let ids: HashSet<&str> = found
            .iter()
            .filter_map(|case| case["id"].as_str())
            .collect();
        assert_eq!(ids.len(), found.len(), "each case is there once");
        assert_eq!(found.len(), text.lines().count());
    }
}

#[test]
fn a_report_that_is_a_link_stays_one() {
    let root = tempfile::tempdir().expect("a scratch directory");
    fs::create_dir(root.path().join("reports")).expect("a directory");
    let check = |name: &str| {
        let output = program()
            .current_dir(root.path())
            .args(["check", "--case", "hand-lum", "--report", name])
            .output()
            .expect("the program starts");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
    };
    // To a file that is not there yet, by way of another link, and then once more.
    std::os::unix::fs::symlink("reports/today.yaml", root.path().join("b")).expect("a link");
    std::os::unix::fs::symlink("b", root.path().join("a")).expect("a link");
    for _ in 0..2 {
        check("a");
        for link in ["a", "b"] {
            let about = fs::symlink_metadata(root.path().join(link)).expect("it is there");
            assert!(about.is_symlink(), "{link}");
        }
        let report = fs::read_to_string(root.path().join("reports/today.yaml"));
        assert!(report.expect("a report").contains("verdict: pass"));
        fs::write(root.path().join("reports/today.yaml"), "old").expect("a file");
    }
}

/// A decoder that hides where it works is known to the watcher as a child of the run.
#[test]
fn a_run_that_is_killed_leaves_no_hidden_process_either() {
    if !Path::new("/proc/self/cmdline").exists() {
        println!("SKIPPED: there is no /proc to look for processes in");
        return;
    }
    let root = tempfile::tempdir().expect("a scratch directory");
    for (round, kind) in ["leaves-a-hidden-child", "leaves-a-daemon"]
        .iter()
        .enumerate()
    {
        let nap = format!("1002.{}{round}", std::process::id());
        let mut run = program()
            .current_dir(root.path())
            .env("ZOO_NAP", &nap)
            .env("ZOO_LINGERS", "1")
            .args(["check", "--timeout", "60", "--", &zoo(), kind])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        let deadline = Instant::now() + Duration::from_secs(60);
        while sleepers(&nap).is_empty() && Instant::now() < deadline {
            std::thread::sleep(Duration::from_millis(10));
        }
        let early = sleepers(&nap);
        assert!(!early.is_empty(), "{kind} leaves processes");
        // What begins after the watcher's last look it has not seen. It sleeps before each look, however busy the machine is.
        let naps = naps_of_watcher(run.id());
        while naps_of_watcher(run.id()) < naps + 3 && Instant::now() < deadline {
            std::thread::sleep(Duration::from_millis(20));
        }
        run.kill().expect("it can be killed");
        run.wait().expect("it is dead");
        let survive = || {
            let left = sleepers(&nap);
            early.iter().any(|pid| left.contains(pid))
        };
        let deadline = Instant::now() + Duration::from_secs(10);
        while survive() && Instant::now() < deadline {
            std::thread::sleep(Duration::from_millis(50));
        }
        let survive = survive();
        let _ = std::process::Command::new("kill")
            .args(sleepers(&nap))
            .status();
        assert!(!survive, "{kind}: some of {early:?} survive");
    }
}

/// How often the watcher of a run has gone to sleep so far.
fn naps_of_watcher(run: u32) -> u64 {
    let words = format!("watch\0{run}\0");
    let processes = fs::read_dir("/proc").expect("/proc").flatten();
    let is_watcher = |path: &Path| {
        let command = fs::read(path.join("cmdline")).unwrap_or_default();
        String::from_utf8_lossy(&command).contains(&words)
    };
    let watcher = processes
        .map(|entry| entry.path())
        .find(|path| is_watcher(path));
    let status = watcher.and_then(|path| fs::read_to_string(path.join("status")).ok());
    let naps = status.unwrap_or_default().lines().find_map(|line| {
        let count = line.strip_prefix("voluntary_ctxt_switches:")?;
        count.trim().parse().ok()
    });
    naps.unwrap_or_default()
}

/// The numbers of the processes that sleep so long.
fn sleepers(nap: &str) -> Vec<String> {
    let sleeps = |path: &Path| {
        let command = fs::read(path.join("cmdline")).unwrap_or_default();
        command == format!("sleep\0{nap}\0").as_bytes()
    };
    let processes = fs::read_dir("/proc").expect("/proc").flatten();
    processes
        .filter(|entry| sleeps(&entry.path()))
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect()
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
    let run = check(&suite, &RunPlan::of(&suite, 2), &ask, &|_, _, done, _| {
        if done % 100 == 0 {
            held[done / 1000].fetch_max(memory(), Relaxed);
        }
    });
    assert_eq!(run.exit_status(), 0, "{:?}", run.remarks);
    let held: Vec<u64> = held.into_iter().map(AtomicU64::into_inner).collect();
    println!("KiB held in every thousand of cases: {held:?}");
    // A observation is some hundred bytes.
    let (early, late) = (held[1], held[COUNT / 1000 - 1]);
    assert!(late < early + (COUNT as u64) + 4096, "{held:?} KiB");
    let report = Report::of(
        &suite,
        &run,
        &["reference".to_owned()],
        vec!["none".to_owned()],
    );
    assert_eq!(report.cases.len(), COUNT);
    let text = report.to_yaml().expect("a report");
    let value: serde_json::Value = ptm_conform::kit::yaml::from_yaml(&text).expect("it is YAML");
    let errors = crate::common::report_errors(&value);
    assert!(errors.is_empty(), "{errors:#?}");
}
