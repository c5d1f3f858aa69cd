//! Final steps of a run: building a report with all verdicts, and then adding the causes of failures.
//!
//! The verdicts do not depend on the search for causes and are not affected if the search fails.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::Ordering;

use crate::diagnose::Causes;
use crate::report::document::{LikelyCause, Report};
use crate::report::shards::{Circumstances, OtherRemarks};
use crate::report::{make::likely_causes, reported::Reportable};
use crate::session::{plan::RunPlan, remark::Remark, run::Run};
use ptm_suite::{cases::Suite, test_case::TestCase};

/// Builds the complete report of a run, with verdicts and causes.
///
/// # Errors
/// Returns the errors of [`verdicts`].
pub fn conclude<C: Reportable>(
    suite: &Suite<C>,
    plan: &RunPlan,
    run: &mut Run<C>,
    circumstances: &Circumstances,
    others: &OtherRemarks,
) -> Result<Report, String> {
    let report = verdicts(suite, plan, run, circumstances, others)?;
    Ok(add_causes(suite, run, report, |run| {
        C::diagnose(suite, run, &circumstances.assumed, plan.jobs)
    }))
}

/// Builds the report of a run, without causes. The report includes the declared capabilities and the remarks in `others`, which
/// are not derived from answers.
///
/// # Errors
/// Returns a message that names the first unknown misreading in `circumstances.assumed`.
pub fn verdicts<C: Reportable>(
    suite: &Suite<C>,
    plan: &RunPlan,
    run: &mut Run<C>,
    circumstances: &Circumstances,
    others: &OtherRemarks,
) -> Result<Report, String> {
    run.remarks.splice(0..0, others.before.iter().cloned());
    run.remarks.extend(others.after.iter().cloned());
    C::assume(suite, run, &circumstances.assumed, plan.jobs)?;
    let limits = circumstances.limits.clone();
    let mut report = Report::new(suite, run, &circumstances.command, limits);
    report.decoder.name.clone_from(&circumstances.name);
    report.decoder.version.clone_from(&circumstances.version);
    plan.mode().clone_into(&mut report.decoder.mode);
    Ok(report)
}

/// Returns the likely causes of the failures so far, sorted by the number of cases explained, or no cause if the search panics.
pub fn first_causes<C: TestCase, A: 'static>(
    suite: &Suite<C>,
    run: &Run<C>,
    search: impl FnOnce(&Run<C>) -> Causes<A>,
) -> Vec<LikelyCause> {
    let found = catch_unwind(AssertUnwindSafe(|| search(run)));
    let causes = found.map(|causes| likely_causes(suite, &causes.diagnoses));
    causes.unwrap_or_default()
}

/// Adds the causes that `search` finds to a report, and a remark if the search panicked or was interrupted.
pub(crate) fn add_causes<C: TestCase, A: 'static>(
    suite: &Suite<C>,
    run: &Run<C>,
    report: Report,
    search: impl FnOnce(&Run<C>) -> Causes<A>,
) -> Report {
    let found = catch_unwind(AssertUnwindSafe(|| search(run)));
    let causes = found.unwrap_or_else(|panic| Causes {
        faults: vec![panic_message(&*panic)],
        ..Causes::from(Vec::new())
    });
    let mut report = report.with_diagnoses(suite, &causes.diagnoses);
    if !causes.faults.is_empty() {
        report.remarks.push(Remark::note(format!(
            "the search for causes failed because of a bug in ptm-conform: {}; the verdicts are not affected",
            causes.faults.join("; ")
        )));
    }
    if run.stop.load(Ordering::Relaxed) {
        let says = "the search for causes was interrupted, so failures are listed without causes";
        report.remarks.push(Remark::note(says.to_owned()));
    }
    report
}

fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
    text.unwrap_or_else(|| "a panic without a message".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runner::run::{Reply, Request};
    use crate::session::run::check;
    use ptm_mistakes::Change;
    use ptm_suite::protocol::frame::Answer;

    #[test]
    fn panicking_search_loses_no_verdict() {
        let mut suite = Suite::load().expect("the suite loads");
        suite.cases.retain(|case| case.first);
        let ask = |_: &Request<'_>, _: usize| Reply::from(Answer::Rejected);
        let plan = RunPlan::new(&suite, 1);
        let run = check(&suite, &plan, &ask, &|_, _, _, _| ());
        let report = Report::new(&suite, &run, &["decoder".to_owned()], Vec::new());
        let verdicts = report.clone();
        let report = add_causes::<_, Change>(&suite, &run, report, |_| panic!("index 3 of 2"));
        assert_eq!(report.cases, verdicts.cases);
        assert_eq!(report.verdict, verdicts.verdict);
        assert_eq!(report.diagnoses, []);
        let last = report.remarks.last().expect("a remark");
        assert!(!last.failure && last.message.contains("a bug in ptm-conform"));
        assert!(last.message.contains("index 3 of 2"), "{}", last.message);
    }
}
