//! Runs a check, from first contact with a decoder to the final report.
//!
//! [`check`] is the only function that requests the cases of a suite from a decoder or a writer and judges the answers; [`texture`]
//! does the same for texture stages. (`probe`, `check --files` and `minimize` compare single answers with the reference.)
//!
//!
//! 1. First contact: what the decoder offers, faults of its wrapper, and transforms that all images have in common.
//! 2. Requests: a few files of each feature, a case of every clause, and the other files of the features that the decoder has.
//! 3. Repeats, and the verdicts.
//! 4. The report with all verdicts. The observer writes it, because the search for causes may take long or fail.
//! 5. The causes, and the final report.
//!
//! The decoder is a [`Subject`]: a program, a function or a recording. An [`Observer`] learns what happens.

pub mod checkable;
pub mod merge;
pub mod observer;
#[cfg(test)]
mod other_transforms;
pub mod recorder;
pub mod subject;
pub mod texture;
#[cfg(test)]
mod texture_unit;
pub mod times;

use std::any::Any;
use std::collections::BTreeMap;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

pub use checkable::{Checkable, FoundCauses};
pub use observer::{Agenda, FinishedCase, FirstVerdicts, Observer, Stage};
pub use subject::Subject;

use recorder::ShardRecorder;
use times::Stopwatch;

use crate::report::document::Report;
use crate::report::shards::{Circumstances, OtherRemarks};
use crate::session::asking::{DecoderFn, ReplyTo};
use crate::session::contact::{Contact, ContactOf};
use crate::session::lit_scene::LitScene;
use crate::session::plan::RunPlan;
use crate::session::probe::ProbeStep;
use crate::session::remark::Remark;
use crate::session::run::{ObservationsOf, RunOf, Session};
use crate::session::sample::{NotAsked, Sample};
use ptm_suite::cases::{Case, Suite};
use ptm_suite::protocol::request::Request;
use ptm_suite::verdicts::observation::ObservationOf;
use ptm_suite::verdicts::outcome::Outcome;

/// Minimum number of cases of a run that begins with a sample. In a shorter run, all cases are requested in suite order.
const MIN_CASES: usize = 300;

/// What is checked, and how far.
#[allow(
    clippy::struct_excessive_bools,
    reason = "each is an independent option"
)]
pub struct Check<'a, C: Checkable = Case> {
    /// The suite.
    pub suite: &'a Suite<C>,
    /// The selected cases and the options of the run.
    pub plan: &'a RunPlan,
    /// Properties of the run for the report.
    pub circumstances: Circumstances,
    /// True if transforms that the images of the first files have in common are reported once and undone in all later images.
    pub undoes_transforms: bool,
    /// True if the causes of failures are searched for.
    pub finds_causes: bool,
    /// True if all files of a feature are requested, even if the decoder answers the first of them with exit status 69.
    pub asks_all: bool,
    /// True if a scene is requested that illustrates the report.
    pub requests_scene: bool,
    /// Recorder of the answers, if only a part of the suite is run.
    pub recorder: Option<ShardRecorder<C::Output>>,
}

impl<'a, C: Checkable> Check<'a, C> {
    /// Creates a whole check.
    #[must_use]
    pub fn new(suite: &'a Suite<C>, plan: &'a RunPlan) -> Check<'a, C> {
        Check {
            undoes_transforms: true,
            finds_causes: true,
            asks_all: false,
            ..Check::of_answers(suite, plan)
        }
    }

    /// Creates a check that judges all answers as they are, and ends with the verdicts.
    #[must_use]
    pub fn of_answers(suite: &'a Suite<C>, plan: &'a RunPlan) -> Check<'a, C> {
        Check {
            suite,
            plan,
            circumstances: Circumstances::default(),
            undoes_transforms: false,
            finds_causes: false,
            asks_all: true,
            requests_scene: false,
            recorder: None,
        }
    }
}

/// The results of a check.
pub struct Checked<C: Checkable = Case> {
    /// Observations and verdicts.
    pub run: RunOf<C>,
    /// The report.
    pub report: Report,
    /// Faults in the wrapper of the decoder. If there are any, the run ended after first contact.
    pub faults: Vec<ProbeStep>,
    /// The scene, if it was requested and received.
    pub scene: Option<LitScene>,
}

/// The reason why a check has no result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// An assumed misreading is unknown.
    Assumption(String),
    /// The decoder could not be asked. This is not the decoder's fault.
    Trouble(String),
    /// The observer could not write the report.
    Observer(String),
    /// The answers could not be recorded.
    Recorder(String),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Error::Assumption(why)
            | Error::Trouble(why)
            | Error::Observer(why)
            | Error::Recorder(why) => why,
        })
    }
}

impl std::error::Error for Error {}

/// Runs a check.
///
/// # Errors
/// Returns an error if an assumed misreading is unknown, if the subject has trouble, or if the observer or the recorder returns one.
pub fn check<C: Checkable>(
    check: &Check<C>,
    subject: &dyn Subject<C::View, C::Output>,
    observer: &dyn Observer,
) -> Result<Checked<C>, Error> {
    let (suite, plan, circumstances) = (check.suite, check.plan, &check.circumstances);
    let record = |request: &Request<'_, C::View>, reply: &ReplyTo<C>| {
        if let Some(recorder) = &check.recorder {
            recorder.record_answer(request, reply);
        }
    };
    let times = Stopwatch::default();
    let ask = |request: &Request<'_, C::View>, worker: usize| {
        let reply = times.measure(&[request.name], || subject.ask(request, worker));
        record(request, &reply);
        reply
    };
    let ask_pipelined = |requests: &[Request<'_, C::View>], worker: usize| {
        let names: Vec<&str> = requests.iter().map(|request| request.name).collect();
        let replies = times.measure(&names, || subject.ask_pipelined(requests, worker));
        for (request, reply) in requests.iter().zip(&replies) {
            record(request, reply);
        }
        replies
    };

    observer.stage_began(&Stage::FirstContact);
    let start = Instant::now();
    let mut session = Session::new(suite, plan, &ask);
    if subject.is_pipelined() {
        session.ask_pipelined = Some(&ask_pipelined);
    }
    let mut contact = session.first_contact();
    let pace = start
        .elapsed()
        .div_f64(session.requests_sent().max(1) as f64);
    let faults = match subject.program() {
        Some(program) => C::wrapper_faults(program, suite, plan, &contact),
        None => Vec::new(),
    };
    let advice = subject.program().and_then(|program| program.advice);
    add_faults(&mut contact, &faults, advice);
    // Assumed misreadings have already been reported.
    if check.undoes_transforms && circumstances.assumed.is_empty() && contact.is_ready() {
        C::undo_common_transforms(suite, &mut session, &mut contact);
    }
    let undone = session.undone_transforms.iter();
    let undone: Vec<&str> = undone.map(|transform| transform.view).collect();
    observer.contact_made(&contact.offer.views, &undone);

    let (observations, not_asked) = request_cases(check, &session, &contact, pace, observer);

    observer.stage_began(&Stage::Repeats);
    let repeated = |done, total| observer.request_repeated(done, total);
    let mut run = session.verdicts(contact, observations, not_asked, &repeated);
    if check.finds_causes {
        // The first signal ends the requests. The next one ends the search for causes.
        plan.stop.store(false, Ordering::Relaxed);
    }
    if let Some(trouble) = subject.trouble() {
        return Err(Error::Trouble(trouble));
    }
    let is_complete = run.ended_early.is_none();
    let scene = (check.requests_scene && is_complete).then(|| C::request_scene(&run, &ask));
    let mut remarks = subject.remarks();
    if let Some(program) = subject.program()
        && is_complete
        && run.not_a_decoder.is_none()
    {
        let remark = C::locale_remark(program, suite, &run);
        remarks.after.extend(remark);
    }

    observer.times_measured(&times.times());
    observer.stage_began(&Stage::Report);
    let mut report = report_verdicts(check, &mut run, &remarks)?;
    observer
        .verdicts_reported(&report)
        .map_err(Error::Observer)?;
    if let Some(recorder) = &check.recorder {
        let ended_early = run.ended_early.clone();
        let written = recorder.finish(plan, circumstances, &report, remarks, ended_early);
        written.map_err(Error::Recorder)?;
    }

    if check.finds_causes {
        observer.stage_began(&Stage::Search(Arc::clone(&run.work)));
        let found = search(|| C::find_causes(suite, &run, &circumstances.assumed, plan.jobs));
        observer.causes_found(&found);
        report = add_causes(report, found, run.stop.load(Ordering::Relaxed));
    }
    Ok(Checked {
        run,
        report,
        faults,
        scene: scene.flatten(),
    })
}

/// Judges all answers of a function as they are, and searches for no causes.
pub fn judge_answers<C: Checkable>(
    suite: &Suite<C>,
    plan: &RunPlan,
    decoder: &DecoderFn<C>,
) -> RunOf<C> {
    let checked = check(&Check::of_answers(suite, plan), &decoder, &());
    checked.expect("a function has no trouble").run
}

/// Adds faults of the decoder's wrapper to the result of first contact. If there are any, no case is requested. `advice` is added
/// if the program is not a decoder.
fn add_faults<V, T, F>(contact: &mut Contact<V, T, F>, faults: &[ProbeStep], advice: Option<&str>) {
    for fault in faults {
        let message = match &fault.next {
            Some(next) => format!("{}\n→ {next}", fault.message),
            None => fault.message.clone(),
        };
        match &mut contact.not_a_decoder {
            Some(why) => *why = format!("{why}\n{message}"),
            None => contact.remarks.push(Remark::failure(message)),
        }
        contact.end_reason = Some(
            "the run ended after the initial checks: fix the wrapper first, because its faults would make most cases fail"
                .to_owned(),
        );
    }
    if let (Some(why), Some(advice)) = (&mut contact.not_a_decoder, advice) {
        *why = format!("{why}\n→ {advice}");
    }
}

/// Requests the cases. In a long run, a few files of each feature come first, and the other files of features that the decoder
/// lacks are not requested. Then come the prioritized cases and a case of every clause. `pace` is the time per request so far.
/// Returns the observations, and the features that the decoder lacks with their cases that were not requested.
fn request_cases<C: Checkable>(
    check: &Check<C>,
    session: &Session<C>,
    contact: &ContactOf<C>,
    pace: Duration,
    observer: &dyn Observer,
) -> (ObservationsOf<C>, NotAsked) {
    let agenda = session.agenda(contact);
    let (total, done) = (AtomicUsize::new(agenda.len()), AtomicUsize::new(0));
    let progress = |case: &C, observation: &ObservationOf<C>, _: usize, _: usize| {
        let (id, view, response) = (case.id(), &observation.view, &observation.response);
        // If transforms are undone before comparison, do not replace the recorded original answer.
        if let (Some(recorder), []) = (&check.recorder, &session.undone_transforms[..]) {
            let is_expected = response.is_expected() && case.expected_output(view).is_some();
            recorder.record_case(id, view, is_expected);
        }
        let finished = FinishedCase {
            id,
            view,
            answer: response.name(),
            is_wrong: !observation.is_open() && response.is_certain_failure(case.expect()),
        };
        if finished.is_wrong {
            check.plan.note_failure();
        }
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        observer.case_finished(&finished, done, total.load(Ordering::Relaxed));
    };
    let mut observations = vec![None; check.suite.cases.len()];
    if agenda.len() < MIN_CASES || check.asks_all {
        observer.stage_began(&Stage::Cases);
        session.request_cases(contact, &agenda, &mut observations, &progress);
        return (observations, Vec::new());
    }
    observer.stage_began(&Stage::Sample);
    let mut sample = Sample::new(check.suite, &contact.offer, &agenda);
    for feature in sample.all_features() {
        let cases = sample.of_feature(&feature);
        session.request_cases(contact, &cases, &mut observations, &progress);
        if session.is_over() {
            return (observations, sample.lacking);
        }
        sample.withhold_if_lacking(&feature, &observations);
        total.store(sample.cases().count(), Ordering::Relaxed);
    }
    let first = sample.of_every_clause(&check.plan.prioritized, &observations);
    observer.agenda_known(&Agenda {
        total: total.load(Ordering::Relaxed) - done.load(Ordering::Relaxed),
        prioritized: first.len(),
        pace,
    });
    observer.stage_began(&Stage::PrioritizedCases);
    session.request_cases(contact, &first, &mut observations, &progress);
    if !session.is_over() {
        observer.first_verdicts(&first_verdicts(
            check.suite,
            session,
            contact,
            &observations,
        ));
    }
    observer.stage_began(&Stage::Cases);
    let others: Vec<usize> = sample
        .cases()
        .filter(|&i| observations[i].is_none())
        .collect();
    session.request_cases(contact, &others, &mut observations, &progress);
    (observations, sample.lacking)
}

/// Judges the cases that have been requested so far.
fn first_verdicts<C: Checkable>(
    suite: &Suite<C>,
    session: &Session<C>,
    contact: &ContactOf<C>,
    observations: &ObservationsOf<C>,
) -> FirstVerdicts {
    let judgment = session.partial_judgment(contact, observations);
    let mut clauses: BTreeMap<String, (usize, usize)> = BTreeMap::new();
    for (case, judged) in suite.cases.iter().zip(&judgment.cases) {
        let Some(judged) = judged else { continue };
        for clause in case.clauses() {
            let (failing, all) = clauses.entry(clause.clone()).or_default();
            *failing += usize::from(judged.outcome == Outcome::Fail);
            *all += 1;
        }
    }
    clauses.retain(|_, (failing, _)| *failing > 0);
    FirstVerdicts {
        judged: judgment.cases.iter().flatten().count(),
        failed: judgment.with_outcome(Outcome::Fail).count(),
        failing_clauses: clauses,
    }
}

/// Returns the report of a run with all verdicts, but without causes.
fn report_verdicts<C: Checkable>(
    check: &Check<C>,
    run: &mut RunOf<C>,
    remarks: &OtherRemarks,
) -> Result<Report, Error> {
    let (suite, plan, circumstances) = (check.suite, check.plan, &check.circumstances);
    run.remarks.splice(0..0, remarks.before.iter().cloned());
    run.remarks.extend(remarks.after.iter().cloned());
    C::assume(suite, run, &circumstances.assumed, plan.jobs).map_err(Error::Assumption)?;
    let limits = circumstances.limits.clone();
    let mut report = Report::new(suite, run, &circumstances.command, limits);
    report.decoder.name.clone_from(&circumstances.name);
    report.decoder.version.clone_from(&circumstances.version);
    plan.mode().clone_into(&mut report.decoder.mode);
    Ok(report)
}

/// Searches for causes. If the search panics, which is a bug of this program, there are no causes, and the verdicts survive.
fn search(find_causes: impl FnOnce() -> FoundCauses) -> FoundCauses {
    catch_unwind(AssertUnwindSafe(find_causes)).unwrap_or_else(|panic| FoundCauses {
        faults: vec![panic_message(&*panic)],
        ..FoundCauses::default()
    })
}

fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
    text.unwrap_or_else(|| "a panic without a message".to_owned())
}

/// Adds causes to a report, and a remark if the search panicked or was interrupted. Readings that a mistake imitates are removed.
fn add_causes(mut report: Report, found: FoundCauses, was_interrupted: bool) -> Report {
    report.remove_readings(&found.imitated);
    report.diagnoses = found.causes;
    if !found.faults.is_empty() {
        report.remarks.push(Remark::note(format!(
            "the search for causes failed because of a bug in ptm-conform: {}; the verdicts are not affected",
            found.faults.join("; ")
        )));
    }
    if was_interrupted {
        let message =
            "the search for causes was interrupted, so failures are listed without causes";
        report.remarks.push(Remark::note(message.to_owned()));
    }
    report
}

#[cfg(test)]
mod tests {
    use super::*;
    use ptm_suite::protocol::frame::Answer;
    use ptm_suite::protocol::request::Reply;

    /// Checks a decoder that refuses every file, with the first files.
    fn verdicts() -> Report {
        let mut suite = Suite::load().expect("the suite loads");
        suite.cases.retain(|case| case.first);
        let plan = RunPlan::new(&suite, 1);
        let refuse = |_: &Request<'_>, _: usize| Reply::from(Answer::Rejected);
        let checked = check(&Check::of_answers(&suite, &plan), &refuse, &());
        checked.expect("a function has no trouble").report
    }

    #[test]
    fn panicking_search_loses_no_verdict() {
        let verdicts = verdicts();
        let found = search(|| panic!("index 3 of 2"));
        let report = add_causes(verdicts.clone(), found, false);
        assert_eq!(report.cases, verdicts.cases);
        assert_eq!(report.verdict, verdicts.verdict);
        assert_eq!(report.diagnoses, []);
        let last = report.remarks.last().expect("a remark");
        assert!(!last.failure && last.message.contains("a bug in ptm-conform"));
        assert!(last.message.contains("index 3 of 2"), "{}", last.message);
    }
}
