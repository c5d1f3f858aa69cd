//! Records the answers to a part of a suite, so that the parts can be merged.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

use crate::report::document::Report;
use crate::report::shards::{AnswerRecorder, Circumstances, OtherRemarks, Trailer, answers_path};
use crate::session::plan::RunPlan;
use ptm_suite::kit::shard::Shard;
use ptm_suite::kit::strip_os_error_code;
use ptm_suite::protocol::request::{Reply, Request};
use ptm_suite::test_case::Output;

/// Writes the answers to a part of a suite to a file next to the report.
pub struct ShardRecorder<T> {
    part: Shard,
    path: PathBuf,
    answers: AnswerRecorder<T>,
}

impl<T: Output> ShardRecorder<T> {
    /// Creates the file next to `report`.
    ///
    /// # Errors
    /// Returns a message that names the file.
    pub fn new(part: Shard, report: &Path) -> Result<ShardRecorder<T>, String> {
        let path = answers_path(report);
        let answers = AnswerRecorder::new(&path).map_err(|error| file_error(&path, &error))?;
        Ok(ShardRecorder {
            part,
            path,
            answers,
        })
    }

    pub(super) fn record_answer<V: Display>(&self, request: &Request<'_, V>, reply: &Reply<T>) {
        self.answers.record_answer(request, reply);
    }

    /// Ends the recording of a case. If the answer equals the expected one, it is not stored.
    pub(super) fn record_case(&self, id: &str, view: &dyn Display, is_expected: bool) {
        self.answers.record_case(id, view, is_expected);
    }

    /// Writes the rest of the file. `report` is the report with all verdicts.
    pub(super) fn finish(
        &self,
        plan: &RunPlan,
        circumstances: &Circumstances,
        report: &Report,
        remarks: OtherRemarks,
        ended_early: Option<String>,
    ) -> Result<(), String> {
        let end = Trailer {
            version: report.tool.version.clone(),
            corpus: report.tool.corpus.clone(),
            part: self.part,
            circumstances: circumstances.clone(),
            plan: plan.clone(),
            remarks,
            ended_early,
        };
        let written = self.answers.finish(&end);
        written.map_err(|error| file_error(&self.path, &error))
    }
}

fn file_error(path: &Path, error: &io::Error) -> String {
    format!("{}: {}", path.display(), strip_os_error_code(error))
}
