//! Killed runs lose no results and leave no processes running. Long runs do not use more memory than short runs.

use std::collections::HashSet;
use std::fs;
use std::os::unix::fs::symlink;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant, SystemTime};

use ptm_harness::pipeline::{Check, FinishedCase, Observer, check};
use ptm_harness::report::Report;
use ptm_harness::runner::run::Decoder;
use ptm_harness::runner::{scratch::Scratch, serve::Servers};
use ptm_harness::session::plan::RunPlan;
use ptm_suite::cases::{Case, Suite};
use ptm_suite::kit::yaml::from_yaml;
use ptm_suite::protocol::request::Request;
use serde_json::Value;

use crate::common::{
    PROGRAM, Workspace, assert_conforms, have_proc, processes, stdout, wait_until, zoo,
};

/// Starts a check in the background.
fn start(here: &Workspace, environment: &[(&str, &str)], line: &str) -> Child {
    let temporary = here.path("tmp");
    fs::create_dir_all(&temporary).expect("a directory");
    here.command(&format!("check {line}"))
        .env("TMPDIR", temporary)
        .envs(environment.iter().copied())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts")
}

fn kill(run: &mut Child) {
    run.kill().expect("it can be killed");
    run.wait().expect("it exits");
}

#[test]
fn killed_run_leaves_results_and_no_process() {
    if !have_proc() {
        return;
    }
    // `PTM_KILLS=20` kills twenty runs instead of four.
    let kills = std::env::var("PTM_KILLS").map_or(4, |count| count.parse().expect("a number"));
    for turn in 0..kills {
        let here = Workspace::new();
        let kind = ["right", "leaves-a-grandchild", "serves", "hangs"][turn % 4];
        let nap = format!("1001.{}", std::process::id());
        let line = format!("--report report.yaml -- {}", zoo(kind));
        let mut run = start(&here, &[("ZOO_NAP", &nap)], &line);
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let micros = now.expect("a time after 1970").subsec_micros();
        let after = Duration::from_millis(u64::from(micros % 1500));
        std::thread::sleep(after);
        let finished = run.try_wait().expect("a status").is_some();
        kill(&mut run);
        let killed = Instant::now();
        let mark = format!("TMPDIR={}", here.path("tmp").display());
        let alive = || processes(|_, environment| environment.contains(&mark));
        let is_gone = wait_until(10, || alive().is_empty());
        assert!(is_gone, "{kind} after {after:?}: {:?} survive", alive());
        let gone = killed.elapsed();
        println!("{kind}, killed after {after:?}: its last process ended {gone:?} later");
        let files = || fs::read_dir(here.path("tmp")).expect("a directory").count();
        assert!(wait_until(10, || files() == 0), "{kind} after {after:?}");
        let partial = here.path("report.yaml.partial");
        let text = fs::read_to_string(partial).unwrap_or_default();
        if finished || text.is_empty() {
            continue;
        }
        let found: Vec<Value> = from_yaml(&text)
            .unwrap_or_else(|error| panic!("{kind} after {after:?}: {error}\n{text}"));
        let ids: HashSet<&str> = found
            .iter()
            .filter_map(|case| case["id"].as_str())
            .collect();
        assert_eq!(ids.len(), found.len(), "each case is listed once");
        assert_eq!(found.len(), text.lines().count());
    }
}

#[test]
fn report_link_is_kept() {
    let here = Workspace::new();
    here.write("reports/yesterday.yaml", "");
    // The link leads through another link to a file that does not exist yet; the second run overwrites it.
    symlink("reports/today.yaml", here.path("b")).expect("a link");
    symlink("b", here.path("a")).expect("a link");
    for _ in 0..2 {
        here.succeeds("check --case hand-lum --report a");
        for link in ["a", "b"] {
            let metadata = fs::symlink_metadata(here.path(link)).expect("a link");
            assert!(metadata.is_symlink(), "{link}");
        }
        let report = here.text("reports/today.yaml");
        assert!(report.contains("verdict: pass"), "{report}");
        here.write("reports/today.yaml", "old");
    }
}

/// The watcher recognizes a decoder with a hidden working directory as a child of the run.
#[test]
fn killed_run_leaves_no_hidden_process() {
    if !have_proc() {
        return;
    }
    for (round, kind) in ["leaves-a-hidden-child", "leaves-a-daemon"]
        .iter()
        .enumerate()
    {
        let here = Workspace::new();
        let nap = format!("1002.{}{round}", std::process::id());
        let environment = [("ZOO_NAP", &*nap), ("ZOO_LINGERS", "1")];
        let mut run = start(
            &here,
            &environment,
            &format!("--timeout 60 -- {}", zoo(kind)),
        );
        let sleepers = || {
            let sleepers = processes(|command, _| command == format!("sleep {nap} "));
            sleepers.into_iter().map(|(pid, _)| pid).collect::<Vec<_>>()
        };
        assert!(
            wait_until(60, || !sleepers().is_empty()),
            "{kind} leaves processes"
        );
        let early = sleepers();
        // The watcher misses processes started after its last scan. It sleeps before each scan, so wait for three more sleeps.
        let sleeps = watcher_sleeps(run.id());
        wait_until(60, || watcher_sleeps(run.id()) >= sleeps + 3);
        kill(&mut run);
        let is_gone = wait_until(10, || {
            let left = sleepers();
            !early.iter().any(|pid| left.contains(pid))
        });
        let _ = Command::new("kill").args(sleepers()).status();
        assert!(is_gone, "{kind}: some of {early:?} survive");
    }
}

/// Returns the number of times that the watcher of a run has gone to sleep so far.
fn watcher_sleeps(run: u32) -> u64 {
    let words = format!("watch {run} ");
    let watchers = processes(|command, _| command.contains(&words));
    let status = watchers
        .first()
        .map(|(pid, _)| format!("/proc/{pid}/status"));
    status.map_or(0, |status| number_in(&status, "voluntary_ctxt_switches:"))
}

/// Returns the number after `word` at the start of a line of a /proc file, or 0 if there is no such line.
fn number_in(file: &str, word: &str) -> u64 {
    let text = fs::read_to_string(file).unwrap_or_default();
    let rest = text.lines().find_map(|line| line.strip_prefix(word));
    let number = rest.and_then(|rest| rest.split_whitespace().next()?.parse().ok());
    number.unwrap_or_default()
}

/// Returns a suite of `count` cases. The cases of the embedded suite are repeated with new ids as often as necessary.
fn long_suite(count: usize) -> Suite {
    let suite = Suite::load().expect("the suite loads");
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

/// Number of cases of a long run.
const COUNT: usize = 10_000;

/// Least memory in each thousand of cases, in KiB, which excludes most of what is held for one case.
struct HeldMemory([AtomicU64; 1 + COUNT / 1000]);

impl Observer for HeldMemory {
    fn case_finished(&self, _: &FinishedCase, done: usize, _: usize) {
        if done.is_multiple_of(100) {
            let memory = number_in("/proc/self/status", "VmRSS:");
            self.0[done / 1000].fetch_min(memory, Relaxed);
        }
    }
}

#[test]
fn memory_does_not_grow_with_the_number_of_cases() {
    const ALONE: &str = "PTM_TEST_ALONE";
    if std::env::var_os(ALONE).is_none() {
        // The memory of this process depends on the other tests. With the limit, glibc returns more memory to the system.
        let variables = [(ALONE, "1"), ("MALLOC_MMAP_THRESHOLD_", "65536")];
        let mut alone = Command::new(std::env::current_exe().expect("a path"));
        stdout(alone.arg("number_of_cases").envs(variables));
        return;
    }
    let command = [PROGRAM.into(), "reference".into()];
    let mut decoder = Decoder::new(&command).expect("a directory");
    decoder.timeout = Duration::from_secs(60);
    let suite = long_suite(COUNT);
    let scratch = Scratch::new().expect("a scratch directory");
    let servers = Servers::new(&decoder, &scratch, 2);
    let ask = |request: &Request<'_>, job: usize| servers.ask(request, job);
    let held = HeldMemory([const { AtomicU64::new(u64::MAX) }; 1 + COUNT / 1000]);
    let plan = RunPlan::new(&suite, 2);
    let checked = check(&Check::of_answers(&suite, &plan), &ask, &held);
    let run = checked.expect("a verdict").run;
    assert_eq!(run.exit_status(), 0, "{:?}", run.remarks);
    let held = held.0.map(AtomicU64::into_inner);
    println!("least memory in each thousand of cases: {held:?} KiB");
    // An observation has a few hundred bytes.
    let (early, late) = (held[1], held[COUNT / 1000 - 1]);
    assert!(late < early + (COUNT as u64) + 2048, "{held:?} KiB");
    let report = Report::new(&suite, &run, &["reference".into()], vec!["none".into()]);
    assert_eq!(report.cases.len(), COUNT);
    let text = report.to_yaml().expect("a report");
    assert_conforms(&from_yaml(&text).expect("YAML"), "report");
}
