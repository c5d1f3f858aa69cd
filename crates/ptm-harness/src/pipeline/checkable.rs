//! The parts of a check that differ between suites: common transforms, assumptions and the search for causes.

use std::time::Duration;

use crate::diagnose::{self, Causes};
use crate::pipeline::subject::Program;
use crate::report::{document::LikelyCause, make::likely_causes};
use crate::session::asking::DecoderFn;
use crate::session::lit_scene::{self, LitScene};
use crate::session::probe::{ProbeStep, wrapper_faults};
use crate::session::run::{Run, RunOf, Session};
use crate::session::{
    contact::{Contact, ContactOf},
    locale,
    plan::RunPlan,
    remark::Remark,
    transform,
};
use ptm_mistakes::Misreading;
use ptm_suite::cases::{Case, Suite};
use ptm_suite::test_case::{Listed, TestCase};

/// The result of a search for causes.
#[derive(Clone, Debug, Default)]
pub struct FoundCauses {
    /// Likely causes, sorted by the number of failures that they explain, in descending order.
    pub causes: Vec<LikelyCause>,
    /// Rulings of open questions whose readings the passing images do not show, because a mistake looks like the reading.
    pub imitated: Vec<&'static str>,
    /// Messages of panics during the search. Each indicates a bug in this program that may hide a cause.
    pub faults: Vec<String>,
    /// Number of answers that were computed for decoders with mistakes.
    pub answer_count: usize,
    /// CPU time of the search, if the system reports it.
    pub cpu_time: Option<Duration>,
}

impl FoundCauses {
    /// Converts diagnoses to the form in which they are reported.
    #[must_use]
    pub fn new<C: Listed, A: 'static>(suite: &Suite<C>, found: &Causes<A>) -> FoundCauses {
        FoundCauses {
            causes: likely_causes(suite, &found.diagnoses),
            imitated: found.imitated.clone(),
            faults: Vec::new(),
            answer_count: found.answer_count,
            cpu_time: found.cpu_time,
        }
    }
}

/// Case type of a suite that the pipeline can check: what differs between suites, with defaults that do nothing.
pub trait Checkable: TestCase {
    /// Returns faults in the wrapper of a program, found with additional requests after first contact.
    #[must_use]
    fn wrapper_faults(
        _: Program,
        _: &Suite<Self>,
        _: &RunPlan,
        _: &ContactOf<Self>,
    ) -> Vec<ProbeStep> {
        Vec::new()
    }

    /// Returns a remark if a program answers differently in a locale with a decimal comma, if the system has one.
    #[must_use]
    fn locale_remark(_: Program, _: &Suite<Self>, _: &RunOf<Self>) -> Option<Remark> {
        None
    }

    /// Finds transforms that the images of the first files have in common, reports them, and undoes them in all later images.
    fn undo_common_transforms(_: &Suite<Self>, _: &mut Session<Self>, _: &mut ContactOf<Self>) {}

    /// Assumes the misreadings with these slugs. Failures explained by one of them no longer count as failures.
    ///
    /// # Errors
    /// Returns a message that names the first unknown misreading.
    fn assume(
        _: &Suite<Self>,
        _: &mut RunOf<Self>,
        slugs: &[String],
        _jobs: usize,
    ) -> Result<(), String> {
        if slugs.is_empty() {
            Ok(())
        } else {
            Err("--assume works only with --suite ptm".to_owned())
        }
    }

    /// Requests a scene that illustrates the report. Returns `None` if the suite has none, or if the decoder does not show it.
    #[must_use]
    fn request_scene(_: &RunOf<Self>, _: &DecoderFn<Self>) -> Option<LitScene> {
        None
    }

    /// Finds the causes of failures, except the assumed misreadings.
    fn find_causes(
        suite: &Suite<Self>,
        run: &RunOf<Self>,
        assumed: &[String],
        jobs: usize,
    ) -> FoundCauses;
}

/// Looks up misreadings by slug.
///
/// # Errors
/// Returns a message that names the first unknown slug.
pub fn find_misreadings(slugs: &[String]) -> Result<Vec<&'static Misreading>, String> {
    slugs
        .iter()
        .map(|slug| {
            ptm_mistakes::find(slug).ok_or_else(|| format!("--assume {slug}: unknown misreading"))
        })
        .collect()
}

impl Checkable for Case {
    fn wrapper_faults(
        program: Program,
        suite: &Suite,
        plan: &RunPlan,
        contact: &Contact,
    ) -> Vec<ProbeStep> {
        let (command, decoder) = (program.command, program.decoder);
        wrapper_faults(command, decoder, program.scratch, suite, plan, contact)
    }

    fn locale_remark(program: Program, suite: &Suite, run: &Run) -> Option<Remark> {
        let locale = locale::comma_locale()?;
        let (decoder, scratch) = (program.decoder, program.scratch);
        locale::difference(suite, run, decoder, &locale, scratch).map(Remark::failure)
    }

    fn undo_common_transforms(suite: &Suite, session: &mut Session<Case>, contact: &mut Contact) {
        let common = transform::common_transforms(suite, contact);
        contact.remarks.splice(0..0, transform::remarks(&common));
        session.undone_transforms = common.into_iter().map(|one| one.undo).collect();
    }

    fn assume(suite: &Suite, run: &mut Run, slugs: &[String], jobs: usize) -> Result<(), String> {
        diagnose::assume(suite, run, &find_misreadings(slugs)?, jobs);
        Ok(())
    }

    fn request_scene(run: &Run, ask: &DecoderFn) -> Option<LitScene> {
        lit_scene::request(&run.offer, &run.judgment.decoded, ask)
    }

    fn find_causes(suite: &Suite, run: &Run, assumed: &[String], jobs: usize) -> FoundCauses {
        // `assume` has already rejected unknown slugs.
        let assumed = find_misreadings(assumed).unwrap_or_default();
        FoundCauses::new(suite, &diagnose::diagnose(suite, run, &assumed, jobs))
    }
}
