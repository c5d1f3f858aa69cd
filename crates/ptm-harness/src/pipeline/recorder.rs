//! Records the answers to a part of a suite, so that the parts can be merged.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::pipeline::observer::Observer;
use crate::report::document::Report;
use crate::report::shards::{
    AnswerRecorder, Circumstances, OtherRemarks, Shard, Trailer, answers_path,
};
use crate::session::asking::{ReplyTo, UndoneTransform};
use crate::session::{contact::Contact, plan::RunPlan, run::Run};
use ptm_suite::kit::strip_os_error_code;
use ptm_suite::protocol::request::Request;
use ptm_suite::verdicts::observation::Observation;
use ptm_suite::{cases::Case, test_case::TestCase};

/// Writes the answers to a part of a suite to a file next to the report.
pub struct ShardRecorder<'a, C: TestCase = Case> {
    part: Shard,
    plan: &'a RunPlan,
    circumstances: &'a Circumstances,
    path: PathBuf,
    answers: AnswerRecorder<C>,
    /// True if transforms are undone, so that images that equal the expected ones were received as other images.
    undoes_transforms: OnceLock<bool>,
}

impl<'a, C: TestCase> ShardRecorder<'a, C> {
    /// Creates the file next to `report`.
    ///
    /// # Errors
    /// Returns a message that names the file.
    pub fn new(
        part: Shard,
        plan: &'a RunPlan,
        circumstances: &'a Circumstances,
        report: &Path,
    ) -> Result<ShardRecorder<'a, C>, String> {
        let path = answers_path(report);
        Ok(ShardRecorder {
            part,
            plan,
            circumstances,
            answers: AnswerRecorder::new(&path).map_err(|error| file_error(&path, &error))?,
            path,
            undoes_transforms: OnceLock::new(),
        })
    }
}

impl<C: TestCase> Observer<C> for ShardRecorder<'_, C> {
    fn request_answered(&self, request: &Request<'_, C::View>, reply: &ReplyTo<C>) {
        self.answers.record_answer(request, reply);
    }

    fn contact_made(&self, _: &Contact<C>, undone: &[UndoneTransform<C>]) {
        let _ = self.undoes_transforms.set(!undone.is_empty());
    }

    fn case_finished(&self, case: &C, observation: &Observation<C>, _: usize, _: usize) {
        if self.undoes_transforms.get() == Some(&false) {
            self.answers.record_observation(case, observation);
        }
    }

    fn verdicts_reported(
        &self,
        run: &Run<C>,
        report: &Report,
        remarks: &OtherRemarks,
    ) -> Result<(), String> {
        let end = Trailer {
            version: report.tool.version.clone(),
            corpus: report.tool.corpus.clone(),
            part: self.part,
            circumstances: self.circumstances.clone(),
            plan: self.plan.clone(),
            remarks: remarks.clone(),
            ended_early: run.ended_early.clone(),
        };
        let written = self.answers.finish(&end);
        written.map_err(|error| file_error(&self.path, &error))
    }
}

fn file_error(path: &Path, error: &io::Error) -> String {
    format!("{}: {}", path.display(), strip_os_error_code(error))
}
