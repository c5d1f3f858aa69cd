//! Merges partial runs. The merged run replays the recorded answers of the parts in place of a decoder.
//!
//! All results (table spelling, verdicts, dialect and diagnoses) are therefore computed by the same code as in a whole run. For a
//! deterministic decoder, the report equals that of a whole run, byte for byte.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use serde::de::DeserializeOwned;

use crate::pipeline::{Check, Checked, Explain, Observer, Subject, check};
use crate::report::shards::{self, AnswerRecord, OtherRemarks, RecordedAnswer, Shard, Trailer};
use crate::session::{asking::ReplyTo, plan::RunPlan, remark::Remark};
use ptm_suite::kit::strip_os_error_code;
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::{AttemptKind, Reply, Request};
use ptm_suite::{cases::Suite, test_case::TestCase};

/// Recorded answers of all parts of a run.
pub struct RecordedAnswers<C: TestCase> {
    /// Answers, keyed by file digest, view, and kind of attempt.
    known: HashMap<(String, String, AttemptKind), RecordedAnswer<C::Output>>,
    /// Trailer of the first part, with the remarks and the selected cases of all parts.
    trailer: Trailer,
}

impl<C: Explain> RecordedAnswers<C> {
    /// Reads the answer files next to the given reports.
    ///
    /// # Errors
    /// Returns a message if a file is damaged, if a file comes from a different run, suite or version, or if a part is
    /// missing, repeated or incomplete.
    pub fn read(suite: &Suite<C>, reports: &[PathBuf]) -> Result<RecordedAnswers<C>, String> {
        let mut known = HashMap::new();
        let mut ends: Vec<(&Path, Trailer)> = Vec::new();
        for report in reports {
            let (answers, end) = read(&shards::answers_path(report))
                .map_err(|error| format!("{}: {error}", shards::answers_path(report).display()))?;
            for reply in answers {
                let key = (reply.file.clone(), reply.view.clone(), reply.attempt);
                known.insert(key, reply);
            }
            ends.push((report, end));
        }
        check_parts(&ends)?;
        ends.sort_by_key(|(_, end)| end.part.number);
        let (first, mut trailer) = ends.remove(0);
        if trailer.corpus != C::digest(suite) {
            let says = "made with a different version of the suite";
            return Err(format!("{}: {says}", first.display()));
        }
        for (_, part) in &ends {
            add_new(&mut trailer.remarks.before, &part.remarks.before);
            add_new(&mut trailer.remarks.after, &part.remarks.after);
            for (all, selected) in trailer.plan.selected.iter_mut().zip(&part.plan.selected) {
                *all |= selected;
            }
        }
        Ok(RecordedAnswers { known, trailer })
    }

    /// Replays the whole run.
    ///
    /// # Errors
    /// Returns a message if the whole run needs a request that no part sent.
    pub fn merge(
        &self,
        suite: &Suite<C>,
        jobs: usize,
        observer: &dyn Observer,
    ) -> Result<Checked<C>, String> {
        let plan = RunPlan {
            jobs,
            ..self.trailer.plan.clone()
        };
        let replay = Replay {
            answers: self,
            suite,
            missing: OnceLock::new(),
        };
        let whole = Check {
            circumstances: self.trailer.circumstances.clone(),
            ..Check::new(suite, &plan)
        };
        check(&whole, &replay, observer).map_err(|error| error.to_string())
    }

    /// Returns the recorded answer to a request. If no part repeated the request, returns the first answer again, because the
    /// verdict did not require a repetition.
    fn find_reply(&self, suite: &Suite<C>, request: &Request<'_, C::View>) -> Option<ReplyTo<C>> {
        let file = shards::digest(request.file);
        let known = |attempt| (self.known).get(&(file.clone(), request.view.to_string(), attempt));
        let record = known(request.attempt).or_else(|| known(AttemptKind::Usual))?;
        let answer = match &record.answer {
            Some(answer) => answer.clone(),
            None => Answer::Decoded(suite.case(&record.case)?.expected_output(request.view)?),
        };
        Some(Reply {
            stderr: record.stderr.clone(),
            exit: record.exit,
            previous_request: record.previous_request.clone(),
            serve_mode_answer: record.serve_mode_answer.clone(),
            ..answer.into()
        })
    }
}

/// A decoder that gives the recorded answers.
struct Replay<'a, C: TestCase> {
    answers: &'a RecordedAnswers<C>,
    suite: &'a Suite<C>,
    /// The first request without a recorded answer.
    missing: OnceLock<String>,
}

impl<C: Explain> Subject<C::View, C::Output> for Replay<'_, C> {
    fn ask(&self, request: &Request<'_, C::View>, _: usize) -> ReplyTo<C> {
        let reply = self.answers.find_reply(self.suite, request);
        reply.unwrap_or_else(|| {
            self.missing
                .get_or_init(|| format!("{} in {}", request.name, request.view));
            Answer::NotStarted("no part of the run contains this request".to_owned()).into()
        })
    }

    fn trouble(&self) -> Option<String> {
        let request = self.missing.get()?;
        Some(format!(
            "no part of the run contains the request for {request}; are the responses of the decoder nondeterministic?"
        ))
    }

    fn remarks(&self) -> OtherRemarks {
        self.answers.trailer.remarks.clone()
    }
}

fn add_new(remarks: &mut Vec<Remark>, more: &[Remark]) {
    for remark in more {
        if !remarks.contains(remark) {
            remarks.push(remark.clone());
        }
    }
}

/// Reads the answers of one part and the trailer on the last line.
fn read<T: DeserializeOwned>(path: &Path) -> Result<(Vec<RecordedAnswer<T>>, Trailer), String> {
    let file = File::open(path).map_err(|error| {
        let error = strip_os_error_code(&error);
        format!("{error}; check --shard writes this file next to the report")
    })?;
    let mut answers = Vec::new();
    for (number, line) in BufReader::new(file).lines().enumerate() {
        let line = line.map_err(|error| error.to_string())?;
        match serde_json::from_str(&line) {
            Ok(AnswerRecord::Answer(answer)) => answers.push(*answer),
            Ok(AnswerRecord::Trailer(end)) => return Ok((answers, *end)),
            Err(error) => return Err(format!("line {}: {error}", number + 1)),
        }
    }
    Err("the last line is missing; was the run interrupted?".to_owned())
}

fn check_parts(ends: &[(&Path, Trailer)]) -> Result<(), String> {
    let Some((first_path, first)) = ends.first() else {
        return Err("no reports to merge".to_owned());
    };
    for (path, end) in ends {
        let fault = |error: &str| Err(format!("{}: {error}", path.display()));
        if end.version != env!("CARGO_PKG_VERSION") {
            let version = &end.version;
            return fault(&format!("written by version {version} of this program"));
        }
        let run = |end: &Trailer| {
            let mut end = end.clone();
            end.part.number = 0;
            end.plan.selected.clear();
            (end.remarks, end.ended_early) = (OtherRemarks::default(), None);
            serde_json::to_string(&end).expect("a trailer can be written")
        };
        if run(end) != run(first) {
            return fault(&format!("not from the run of {}", first_path.display()));
        }
        if let Some(why) = &end.ended_early {
            let says = format!("part {} did not finish: {why}", end.part);
            return fault(&format!("{says}. Run this part again"));
        }
    }
    for number in 1..=first.part.total {
        let total = first.part.total;
        let part = Shard { number, total };
        match ends.iter().filter(|(_, end)| end.part == part).count() {
            1 => {}
            0 => return Err(format!("part {part} is missing")),
            _ => return Err(format!("duplicate part {part}")),
        }
    }
    Ok(())
}
