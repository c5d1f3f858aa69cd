//! What a user sees of a check while it runs, and the files that it writes: progress and first causes on standard error, the
//! results so far, and the report.

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::time::Duration;

use super::ending::ReportWriter;
use super::files::with_path;
use super::progress::{self, ProgressLine};
use crate::report::html::Evidence;
use crate::report::text::first_verdicts_to_text;
use ptm_harness::pipeline::times::Times;
use ptm_harness::pipeline::{Agenda, FinishedCase, FirstVerdicts, FoundCauses, Observer, Stage};
use ptm_harness::report::document::Report;
use ptm_harness::session::run::Ending;

/// Minimum estimated duration of a run. Shorter estimates are not announced.
const MIN_ANNOUNCED_TIME: Duration = Duration::from_secs(60);

/// Display of a check.
pub struct Display<'a> {
    writer: ReportWriter<'a>,
    /// File next to the report, with the results so far: a YAML list that is valid after every case.
    partial: (PathBuf, fs::File),
    progress: ProgressLine,
    /// Times of the requests, once they are known.
    times: OnceLock<Times>,
    /// Hint on how to get answers faster.
    speed_hint: Option<&'static str>,
}

impl<'a> Display<'a> {
    /// Starts the display and creates the file for the results so far.
    pub fn new(
        writer: ReportWriter<'a>,
        speed_hint: Option<&'static str>,
    ) -> Result<Display<'a>, String> {
        let mut partial = writer.path.as_os_str().to_owned();
        partial.push(".partial");
        let partial = PathBuf::from(partial);
        let file = fs::File::create(&partial).map_err(with_path(&partial))?;
        Ok(Display {
            writer,
            partial: (partial, file),
            progress: ProgressLine::new("initial checks"),
            times: OnceLock::new(),
            speed_hint,
        })
    }

    /// Ends the display, and writes and prints the report in all requested formats. Returns the exit status.
    pub fn finish(self, ending: Ending, report: Report, evidence: &Evidence) -> Result<u8, String> {
        drop(self.progress);
        let times = self.times.get();
        let status = self.writer.finish(ending, report, evidence, times)?;
        let _ = fs::remove_file(self.partial.0);
        Ok(status)
    }
}

impl Observer for Display<'_> {
    fn stage_began(&self, stage: &Stage) {
        match stage {
            Stage::FirstContact => self.progress.begin("initial checks"),
            Stage::Sample => self.progress.begin("a few files of each feature:"),
            Stage::PrioritizedCases => self.progress.begin("every clause:"),
            Stage::Cases => self.progress.begin("running"),
            Stage::Repeats => self.progress.begin("repeating requests:"),
            Stage::Report => self.progress.begin("writing the report"),
            Stage::Search(work) => self.progress.begin_search("searching for causes", work),
        }
    }

    fn agenda_known(&self, agenda: &Agenda) {
        let (all, first) = (agenda.total, agenda.prioritized);
        let long = agenda.time(all);
        if long >= MIN_ANNOUNCED_TIME {
            let [long, short] = [long, agenda.time(first)].map(progress::format_duration);
            let hint = self.speed_hint.unwrap_or_default();
            self.progress.print_message(&format!(
                "{all} requests will take about {long}; every clause will be tested after {first} requests, in about {short}.{hint}"
            ));
        }
    }

    fn case_finished(&self, case: &FinishedCase, done: usize, total: usize) {
        let FinishedCase {
            id, view, answer, ..
        } = case;
        let line = format!("- {{ id: {id}, view: \"{view}\", answer: {answer} }}\n");
        // Use one write per line. Results that cannot be written here are still in the report.
        let _ = (&self.partial.1).write_all(line.as_bytes());
        if case.is_wrong {
            self.progress.count_wrong_answer();
        }
        self.progress.update(done, total);
    }

    fn first_verdicts(&self, first: &FirstVerdicts) {
        self.progress.print_message(&first_verdicts_to_text(first));
    }

    fn times_measured(&self, times: &Times) {
        let _ = self.times.set(times.clone());
    }

    fn request_repeated(&self, done: usize, total: usize) {
        self.progress.update(done, total);
    }

    fn verdicts_reported(&self, report: &Report) -> Result<(), String> {
        self.writer.write(&mut report.clone())
    }

    fn causes_found(&self, found: &FoundCauses) {
        if let Some(time) = found.cpu_time
            && !found.causes.is_empty()
        {
            let (answers, seconds) = (found.answer_count, time.as_secs_f64());
            self.progress.print_message(&format!(
                "searched for causes: {answers} answers compared in {seconds:.1} s of CPU time"
            ));
        }
    }
}
