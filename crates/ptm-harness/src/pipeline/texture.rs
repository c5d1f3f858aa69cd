//! The pipeline for texture stages. It has fewer stages than [`check`](super::check): there are no wrappers, transforms, tables,
//! prioritized questions or assumptions.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use serde_json::Value;

use crate::diagnose;
use crate::pipeline::checkable::FoundCauses;
use crate::pipeline::observer::{FinishedCase, Observer, Stage};
use crate::pipeline::recorder::ShardRecorder;
use crate::pipeline::subject::Subject;
use crate::pipeline::times::Stopwatch;
use crate::pipeline::{Error, add_causes, search};
use crate::report::document::Report;
use crate::report::shards::Circumstances;
use crate::session::plan::RunPlan;
use crate::session::texture::{StageFn, TextureObservation, TextureRun, TextureSession};
use ptm_suite::cases::{Expect, Suite};
use ptm_suite::protocol::request::Request;
use ptm_suite::texture::cases::{TextureCase, TextureView};

/// What is checked, and how far.
pub struct TextureCheck<'a> {
    /// The suite.
    pub suite: &'a Suite<TextureCase>,
    /// The selected questions and the options of the run.
    pub plan: &'a RunPlan,
    /// Properties of the run for the report.
    pub circumstances: Circumstances,
    /// True if the causes of failures are searched for.
    pub finds_causes: bool,
    /// Recorder of the answers, if only a part of the suite is run.
    pub recorder: Option<ShardRecorder<Value>>,
}

impl<'a> TextureCheck<'a> {
    /// Creates a whole check.
    #[must_use]
    pub fn new(suite: &'a Suite<TextureCase>, plan: &'a RunPlan) -> TextureCheck<'a> {
        TextureCheck {
            suite,
            plan,
            circumstances: Circumstances::default(),
            finds_causes: true,
            recorder: None,
        }
    }
}

/// Runs a check of a texture stage. Returns the run and the report.
///
/// # Errors
/// Returns an error if the stage has trouble, or if the observer or the recorder returns one.
pub fn check(
    check: &TextureCheck,
    stage: &dyn Subject<TextureView, Value>,
    observer: &dyn Observer,
) -> Result<(TextureRun, Report), Error> {
    let (suite, plan, circumstances) = (check.suite, check.plan, &check.circumstances);
    let times = Stopwatch::default();
    let ask = |request: &Request<'_, TextureView>, worker: usize| {
        let reply = times.measure(&[request.name], || stage.ask(request, worker));
        if let Some(recorder) = &check.recorder {
            recorder.record_answer(request, &reply);
        }
        reply
    };

    observer.stage_began(&Stage::FirstContact);
    let session = TextureSession::new(suite, plan, &ask);
    let contact = session.first_contact();
    observer.contact_made(&contact.offer.views, &[]);

    observer.stage_began(&Stage::Cases);
    let finished = |i: usize, observation: &TextureObservation, done: usize, total: usize| {
        let (case, response) = (&suite.cases[i], &observation.response);
        if let Some(recorder) = &check.recorder {
            // Any answer is expected if it is left to the implementation.
            let is_left_open = case.expectation() == Expect::ImplementationDefined;
            let is_expected = response.is_expected() && !is_left_open;
            recorder.record_case(&case.id, &TextureView, is_expected);
        }
        let finished = FinishedCase {
            id: &case.id,
            view: &TextureView,
            answer: response.name(),
            is_wrong: !observation.is_open() && response.is_certain_failure(case.expectation()),
        };
        if finished.is_wrong {
            plan.note_failure();
        }
        observer.case_finished(&finished, done, total);
    };
    let observations = session.ask_questions(&contact, &finished);

    observer.stage_began(&Stage::Repeats);
    let repeated = |done, total| observer.request_repeated(done, total);
    let mut run = session.verdicts(contact, observations, &repeated);
    if check.finds_causes {
        // The first signal ends the requests. The next one ends the search for causes.
        plan.stop.store(false, Ordering::Relaxed);
    }
    if let Some(trouble) = stage.trouble() {
        return Err(Error::Trouble(trouble));
    }

    observer.times_measured(&times.times());
    observer.stage_began(&Stage::Report);
    let remarks = stage.remarks();
    run.remarks.splice(0..0, remarks.before.iter().cloned());
    run.remarks.extend(remarks.after.iter().cloned());
    let (command, limits) = (&circumstances.command, circumstances.limits.clone());
    let mut report = Report::on_texture_stage(suite, &run, command, limits);
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
        let found = search(|| {
            let causes = diagnose::texture::diagnose(suite, &run);
            FoundCauses::new(suite, &causes.into())
        });
        observer.causes_found(&found);
        report = add_causes(report, found, run.stop.load(Ordering::Relaxed));
    }
    Ok((run, report))
}

/// Judges all answers of a function, and searches for no causes.
pub fn judge_answers(suite: &Suite<TextureCase>, plan: &RunPlan, stage: &StageFn) -> TextureRun {
    let check_of_answers = TextureCheck {
        finds_causes: false,
        ..TextureCheck::new(suite, plan)
    };
    let (run, _) = check(&check_of_answers, &stage, &()).expect("a function has no trouble");
    run
}
