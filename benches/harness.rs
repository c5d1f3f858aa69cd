//! The overhead of the harness: ratios of its rates to bare rates, measured in one run.
//!
//! - one-shot `check` of a native decoder, compared with only starting the same processes and reading their output;
//! - serve mode with pipelined requests, compared with a bare exchange of the same requests, one at a time;
//! - serve mode, compared with one-shot mode for the Python decoder.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use ptm_harness::pipeline::{Check, Subject, check, judge_answers};
use ptm_harness::runner::processes;
use ptm_harness::runner::run::Decoder;
use ptm_harness::runner::scratch::Scratch;
use ptm_harness::runner::serve::Servers;
use ptm_harness::session::plan::{Repeat, RunPlan};
use ptm_suite::cases::Suite;
use ptm_suite::protocol::request::{AttemptKind, Reply, Request};

/// Number of measurements of each kind. The best one counts, because the others include more unrelated load.
const ROUNDS: usize = 3;

fn main() {
    processes::prepare();
    let suite = Suite::load()
        .expect("the suite loads")
        .with_prepared_files();
    let native = [env!("CARGO_BIN_EXE_ptm-conform").into(), "reference".into()];
    let native = Decoder::new(&native).expect("a directory");
    let scratch = Scratch::new().expect("a scratch directory");
    let scratch = &scratch;
    let all = vec![true; suite.cases.len()];

    let requests = requests(&suite, &native, scratch);
    println!("{} requests, {} at a time", requests.len(), jobs());
    let bare = rate(requests.len(), || bare_one_shot(&requests));
    let one_shot = rate(requests.len(), || {
        run(&suite, &native, &all, false, scratch);
    });
    println!(
        "one-shot, native: {one_shot:.0} of {bare:.0} calls/s, {:.2} (target 0.93)",
        one_shot / bare
    );

    let bare = rate(requests.len(), || bare_served(&requests));
    let served = rate(requests.len(), || run(&suite, &native, &all, true, scratch));
    println!(
        "serve, native, pipelined: {served:.0} of {bare:.0} calls/s one at a time, {:.2} (target 0.60)",
        served / bare
    );

    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/decoders/ptm_decoder.py");
    let python = Decoder::new(&["python3".into(), script.into()]).expect("a directory");
    let subset: Vec<bool> = (0..suite.cases.len()).map(|i| i % 8 == 0).collect();
    let one_shot = measure(|| run(&suite, &python, &subset, false, scratch));
    let served = measure(|| run(&suite, &python, &all, true, scratch));
    let one_shot = one_shot.as_secs_f64() / count_calls(&suite, &python, &subset, scratch) as f64;
    let served = served.as_secs_f64() / requests.len() as f64;
    println!(
        "python: {:.2} ms one-shot, {:.2} ms served, {:.1} times (target 20)",
        one_shot * 1e3,
        served * 1e3,
        one_shot / served
    );
}

fn jobs() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn measure(work: impl FnOnce()) -> Duration {
    let start = Instant::now();
    work();
    start.elapsed()
}

/// Returns the best rate per second.
fn rate(count: usize, work: impl Fn()) -> f64 {
    let best = (0..ROUNDS)
        .map(|_| measure(&work))
        .min()
        .expect("there is a round");
    count as f64 / best.as_secs_f64()
}

fn plan(selected: &[bool], serves: bool) -> RunPlan {
    RunPlan {
        selected: selected.to_vec(),
        jobs: jobs(),
        repeat: if serves {
            Repeat::FailuresAndSample
        } else {
            Repeat::Failures
        },
        ..RunPlan::default()
    }
}

/// Serving processes that are sent several requests at once.
struct Pipelined<'a>(Servers<'a>);

impl Subject for Pipelined<'_> {
    fn ask(&self, request: &Request, job: usize) -> Reply {
        self.0.ask(request, job)
    }

    fn is_pipelined(&self) -> bool {
        true
    }

    fn ask_pipelined(&self, requests: &[Request], job: usize) -> Vec<Reply> {
        self.0.ask_pipelined(requests, job)
    }
}

fn run(suite: &Suite, decoder: &Decoder, selected: &[bool], serves: bool, scratch: &Scratch) {
    let plan = plan(selected, serves);
    let servers = Pipelined(Servers::new(decoder, scratch, plan.jobs));
    let one_shot = |request: &Request<'_>, _: usize| decoder.ask(request, scratch);
    let subject: &dyn Subject = if serves { &servers } else { &one_shot };
    let checked = check(&Check::of_answers(suite, &plan), subject, &());
    if checked.expect("a verdict").run.exit_status() != 0 {
        println!("some cases failed: on a busy machine, requests may exceed the time limit");
    }
}

fn count_calls(suite: &Suite, decoder: &Decoder, selected: &[bool], scratch: &Scratch) -> usize {
    let servers = Servers::new(decoder, scratch, jobs());
    let ask = |request: &Request<'_>, job: usize| servers.ask(request, job);
    judge_answers(suite, &plan(selected, true), &ask).request_count
}

/// Writes the files of all requests of a run. Returns their views and paths.
fn requests(suite: &Suite, decoder: &Decoder, scratch: &Scratch) -> Vec<(String, PathBuf)> {
    let recorded = Mutex::new(Vec::new());
    let servers = Servers::new(decoder, scratch, 1);
    let ask = |request: &Request<'_>, job: usize| {
        let mut recorded = recorded.lock().expect("no worker panics");
        let path = scratch
            .work_directory()
            .join(format!("bare-{}.ptm", recorded.len()));
        if request.attempt == AttemptKind::Usual {
            fs::write(&path, request.file).expect("a file");
            recorded.push((request.view.to_string(), path));
        }
        servers.ask(request, job)
    };
    let plan = RunPlan {
        jobs: 1,
        ..plan(&vec![true; suite.cases.len()], true)
    };
    judge_answers(suite, &plan, &ask);
    recorded.into_inner().expect("no worker panics")
}

fn run_in_parallel(count: usize, worker: impl Fn(&AtomicUsize) + Sync) {
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..jobs() {
            scope.spawn(|| worker(&next));
        }
    });
    assert!(next.into_inner() >= count);
}

fn bare_one_shot(requests: &[(String, PathBuf)]) {
    run_in_parallel(requests.len(), |next| {
        while let Some((view, path)) = requests.get(next.fetch_add(1, Ordering::Relaxed)) {
            let child = Command::new(env!("CARGO_BIN_EXE_ptm-conform"))
                .arg("reference")
                .arg(view)
                .arg(path)
                .stdin(Stdio::null())
                .stdout(Stdio::piped())
                .stderr(Stdio::null())
                .spawn();
            let mut child = child.expect("it starts");
            let mut frame = Vec::new();
            child
                .stdout
                .take()
                .expect("a pipe")
                .read_to_end(&mut frame)
                .expect("it can be read");
            child.wait().expect("it ends");
        }
    });
}

fn bare_served(requests: &[(String, PathBuf)]) {
    run_in_parallel(requests.len(), |next| {
        let child = Command::new(env!("CARGO_BIN_EXE_ptm-conform"))
            .args(["reference", "serve"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn();
        let mut child = child.expect("it starts");
        let mut stdin = child.stdin.take().expect("a pipe");
        let mut stdout = BufReader::new(child.stdout.take().expect("a pipe"));
        while let Some((view, path)) = requests.get(next.fetch_add(1, Ordering::Relaxed)) {
            stdin
                .write_all(format!("1 {view} {}\n", path.display()).as_bytes())
                .expect("it reads requests");
            let mut line = String::new();
            stdout.read_line(&mut line).expect("it answers");
            if let Some(length) = line.trim_end().strip_prefix("1 ok ") {
                let mut frame = vec![0; length.parse().expect("a number")];
                stdout.read_exact(&mut frame).expect("it answers");
            }
        }
        drop(stdin);
        child.wait().expect("it ends");
    });
}
