//! Drives a run of any suite: first contact, cases, verdicts, report and causes, in that order.

use std::fs;
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use super::ending::{OutputArgs, ReportWriter};
use super::progress::{self, ProgressLine};
use super::{CommandResult, calls::RunArgs};
use super::{files::with_path, guard::check_for_trouble, output::jobs};
use crate::report::conclude::{add_causes, first_causes, verdicts};
use crate::report::reported::Reportable;
use crate::report::shards::{
    AnswerRecorder, Circumstances, OtherRemarks, Shard, Trailer, answers_path,
};
use crate::report::text::first_causes_to_text;
use crate::runner::run::{Decoder, Request};
use crate::session::plan::{Repeat, RunPlan};
use crate::session::run::{Observations, Run, Session};
use crate::session::{asking::DecoderFn, contact::Contact, observation::Observation};
use ptm_suite::cases::Suite;

/// Minimum number of cases outside the smoke subset for an early report of causes. Shorter runs report causes only at the end.
const MIN_OTHER_CASES: usize = 200;

/// Minimum time limit for the early search for causes. In a long run, the limit is a tenth of the estimated duration of the run.
const MIN_SEARCH_TIME: Duration = Duration::from_secs(2);

/// Minimum estimated duration of a run. Shorter estimates are not announced.
const MIN_ANNOUNCED_TIME: Duration = Duration::from_secs(60);

/// Run of a suite and the destination of its report.
pub struct Check<'a, C: Reportable> {
    suite: &'a Suite<C>,
    plan: &'a RunPlan,
    circumstances: Circumstances,
    writer: ReportWriter<'a>,
    /// File next to the report, with the results so far: a YAML list that is valid after every case.
    partial: (PathBuf, fs::File),
    progress: ProgressLine,
    /// Hint on how to get answers faster; empty if there is no hint.
    pub speed_hint: &'static str,
    /// Part of the suite and the recorder of its answers, if only a part is run.
    recorder: Option<(Shard, AnswerRecorder<C>)>,
}

impl<'a, C: Reportable> Check<'a, C> {
    /// Creates a run and the files that it writes.
    pub fn new(
        suite: &'a Suite<C>,
        plan: &'a RunPlan,
        circumstances: Circumstances,
        writer: ReportWriter<'a>,
        shard: Option<Shard>,
    ) -> Result<Check<'a, C>, String> {
        let path = answers_path(writer.path);
        let recorder = shard.map(|shard| Ok::<_, io::Error>((shard, AnswerRecorder::new(&path)?)));
        let recorder = recorder.transpose().map_err(with_path(&path))?;
        let mut partial = writer.path.as_os_str().to_owned();
        partial.push(".partial");
        let partial = PathBuf::from(partial);
        let file = fs::File::create(&partial).map_err(with_path(&partial))?;
        Ok(Check {
            suite,
            plan,
            circumstances,
            partial: (partial, file),
            writer,
            progress: ProgressLine::new("initial checks"),
            speed_hint: "",
            recorder,
        })
    }

    /// Makes first contact, runs all cases, and returns the judged run. `inspect` may change the result of first contact.
    pub fn run_cases(&self, ask: &DecoderFn<C>, inspect: &dyn Fn(&mut Contact<C>)) -> Run<C> {
        let recording = |request: &Request<'_, C::View>, job: usize| {
            let reply = ask(request, job);
            if let Some((_, recorder)) = &self.recorder {
                recorder.record_answer(request, &reply);
            }
            reply
        };
        let began = Instant::now();
        let mut session = Session::new(self.suite, self.plan, &recording);
        let mut contact = session.first_contact();
        let (time, requests) = (began.elapsed(), session.requests_sent());
        let pace = time.div_f64(requests.max(1) as f64);
        inspect(&mut contact);
        // Assumed misreadings have already been reported.
        if contact.is_ready() && self.circumstances.assumed.is_empty() {
            C::undo_common_transforms(self.suite, &mut session, &mut contact);
        }
        let observations = self.run_smoke_subset_first(&session, &contact, pace);
        self.progress.begin("repeating requests:");
        let again = |done, all| self.progress.update(done, all);
        let run = session.verdicts(contact, observations, &again);
        // The first signal ends the calls. The next one ends the search for causes.
        self.plan.stop.store(false, Ordering::Relaxed);
        run
    }

    /// Runs the smoke subset, reports causes, runs the other cases, and returns all observations. `pace` is the time per request.
    fn run_smoke_subset_first(
        &self,
        session: &Session<C>,
        contact: &Contact<C>,
        pace: Duration,
    ) -> Observations<C> {
        let (soonest, others) = session.agenda(contact);
        let all = soonest.len() + others.len();
        let done = AtomicUsize::new(0);
        let progress = |case: &C, observation: &Observation<C>, _: usize, _: usize| {
            let (id, view, answer) = (case.id(), &observation.view, observation.response.name());
            let line = format!("- {{ id: {id}, view: \"{view}\", answer: {answer} }}\n");
            // Use one write per line. Results that cannot be written here are still in the report.
            let _ = (&self.partial.1).write_all(line.as_bytes());
            // If transforms are undone before comparison, do not replace the recorded original answer.
            if let (Some((_, recorder)), true) =
                (&self.recorder, session.undone_transforms.is_empty())
            {
                recorder.record_observation(case, observation);
            }
            if observation.is_certain_failure(case) {
                self.progress.count_wrong_answer();
            }
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            self.progress.update(done, all);
        };
        let mut observations = vec![None; self.suite.cases.len()];
        // A short run would end before the user has read the first causes.
        if soonest.is_empty() || others.len() < MIN_OTHER_CASES {
            self.progress.begin("running");
            let all = [soonest, others].concat();
            session.request_cases(contact, &all, &mut observations, &progress);
            return observations;
        }
        let times = [all, soonest.len()].map(|count| pace.mul_f64(count as f64));
        if times[0] >= MIN_ANNOUNCED_TIME {
            let ([long, short], faster) = (times.map(progress::format_duration), self.speed_hint);
            let soonest = soonest.len();
            self.progress.print_message(&format!(
                "{all} requests will take about {long}; the first likely causes will be known after {soonest} requests, in about {short}.{faster}"
            ));
        }
        self.progress.begin("running the smoke subset:");
        session.request_cases(contact, &soonest, &mut observations, &progress);
        if !session.is_over() {
            let run = session.partial_run(contact, &soonest, &observations);
            self.report_first_causes(run, (times[0] / 10).max(MIN_SEARCH_TIME));
        }
        self.progress.begin("running");
        session.request_cases(contact, &others, &mut observations, &progress);
        observations
    }

    /// Reports the causes of failures in the smoke subset. Reports nothing if the search does not finish in time, because
    /// an incomplete search may name causes that other cases refute.
    fn report_first_causes(&self, mut run: Run<C>, time_limit: Duration) {
        let (suite, assumed) = (self.suite, &self.circumstances.assumed);
        let stop = Arc::new(AtomicBool::new(false));
        run.stop = Arc::clone(&stop);
        let label = "searching for first causes";
        self.progress.begin_search(label, &run.work);
        let diagnose = |run: &Run<C>| C::diagnose(suite, run, assumed, self.plan.jobs);
        let causes = run_with_time_limit(time_limit, &stop, &self.plan.stop, || {
            first_causes(suite, &run, diagnose)
        });
        if !stop.load(Ordering::Relaxed)
            && let Some(text) = first_causes_to_text(&run, &causes)
        {
            self.progress.print_message(&text);
        }
    }

    /// Writes the report with all verdicts, then searches for causes and writes the report again. Returns the exit status.
    pub fn conclude(self, mut run: Run<C>, others: OtherRemarks) -> Result<u8, String> {
        let (suite, plan) = (self.suite, self.plan);
        let assumed = self.circumstances.assumed.clone();
        self.progress.begin("writing the report");
        let mut report = verdicts(suite, plan, &mut run, &self.circumstances, &others)?;
        // Write the verdicts before the search for causes, which may take long or fail.
        self.writer.write(&mut report)?;
        if let Some((part, recorder)) = self.recorder {
            let end = Trailer {
                version: report.tool.version.clone(),
                corpus: report.tool.corpus.clone(),
                part,
                circumstances: self.circumstances,
                plan: plan.clone(),
                remarks: others,
                ended_early: run.ended_early.clone(),
            };
            let path = answers_path(self.writer.path);
            recorder.finish(&end).map_err(with_path(&path))?;
        }
        let label = "searching for causes";
        self.progress.begin_search(label, &run.work);
        let report = add_causes(suite, &run, report, |run| {
            let found = C::diagnose(suite, run, &assumed, plan.jobs);
            if let Some(time) = found.cpu_time
                && !found.diagnoses.is_empty()
            {
                let (answers, seconds) = (found.answer_count, time.as_secs_f64());
                self.progress.print_message(&format!(
                    "searched for causes: {answers} answers compared in {seconds:.1} s of CPU time"
                ));
            }
            found
        });
        drop(self.progress);
        let status = self.writer.finish(self.suite, &run, report)?;
        let _ = fs::remove_file(self.partial.0);
        Ok(status)
    }
}

/// Run of a suite against a program that is started anew for each request.
pub struct ProgramRun<'a> {
    /// Program under test.
    pub program: &'a Decoder,
    /// Command line for the report.
    pub words: &'a [String],
    /// Descriptions of the limits in force.
    pub limits: Vec<String>,
    /// Path of the report and options for calls.
    pub args: &'a RunArgs,
    /// Other output formats of the report.
    pub output: &'a OutputArgs,
    /// Part of the suite, or `None` for the whole suite.
    pub shard: Option<Shard>,
}

impl ProgramRun<'_> {
    /// Runs the selected cases and returns the exit status.
    pub fn check<C: Reportable>(
        self,
        suite: &Suite<C>,
        selected: Vec<bool>,
        ask: &DecoderFn<C>,
    ) -> CommandResult {
        let plan = RunPlan {
            selected,
            repeat: Repeat::Failures,
            stop: Arc::clone(&self.program.stop),
            ..RunPlan::new(suite, jobs(self.args.calls.jobs)?)
        };
        let writer = ReportWriter::new(suite, &self.args.report, self.output)?;
        let circumstances = Circumstances {
            command: self.words.to_vec(),
            limits: self.limits,
            ..Circumstances::default()
        };
        let check = Check::new(suite, &plan, circumstances, writer, self.shard)?;
        let run = check.run_cases(ask, &|_| ());
        check_for_trouble(self.program)?;
        Ok(check.conclude(run, OtherRemarks::default())?)
    }
}

/// Runs `work`, which should end when `stop` is set. Sets `stop` when the time limit expires or when `end` is set.
fn run_with_time_limit<T>(
    time_limit: Duration,
    stop: &AtomicBool,
    end: &AtomicBool,
    work: impl FnOnce() -> T,
) -> T {
    let (working, ended) = mpsc::channel::<()>();
    let began = Instant::now();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            while ended.recv_timeout(Duration::from_millis(20)) == Err(RecvTimeoutError::Timeout) {
                if began.elapsed() > time_limit || end.load(Ordering::Relaxed) {
                    return stop.store(true, Ordering::Relaxed);
                }
            }
        });
        let result = work();
        drop(working);
        result
    })
}
