//! Merges partial runs. The merged run replays the recorded answers of the parts in place of a decoder.
//!
//! All results (table spelling, verdicts, dialect and diagnoses) are therefore computed by the same code as in a whole run. For a
//! deterministic decoder, the report equals that of a whole run, byte for byte.

use std::collections::HashMap;
use std::fmt::Display;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::pipeline::texture::{self, TextureCheck};
use crate::pipeline::{Check, Checkable, Checked, Observer, Subject, check};
use crate::report::document::Report;
use crate::report::shards::{self, AnswerRecord, OtherRemarks, RecordedAnswer, Trailer};
use crate::session::texture::TextureRun;
use crate::session::{plan::RunPlan, remark::Remark};
use ptm_suite::cases::Suite;
use ptm_suite::kit::shard::Shard;
use ptm_suite::kit::strip_os_error_code;
use ptm_suite::protocol::frame::{Answer, Frame};
use ptm_suite::protocol::request::{AttemptKind, Reply, Request};
use ptm_suite::test_case::{Listed, Output};
use ptm_suite::texture::cases::{TextureCase, TextureView};

/// Recorded answers of all parts of a run.
pub struct RecordedAnswers<T = Frame> {
    /// Answers, keyed by file digest, view, and kind of attempt.
    known: HashMap<(String, String, AttemptKind), RecordedAnswer<T>>,
    /// Trailer of the first part, with the remarks and the selected cases of all parts.
    trailer: Trailer,
}

impl<T: Output> RecordedAnswers<T> {
    /// Reads the answer files next to the given reports.
    ///
    /// # Errors
    /// Returns a message if a file is damaged, if a file comes from a different run, suite or version, or if a part is
    /// missing, repeated or incomplete.
    pub fn read<C: Listed>(
        suite: &Suite<C>,
        reports: &[PathBuf],
    ) -> Result<RecordedAnswers<T>, String> {
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
    pub fn merge<C: Checkable<Output = T>>(
        &self,
        suite: &Suite<C>,
        jobs: usize,
        observer: &dyn Observer,
    ) -> Result<Checked<C>, String> {
        let plan = self.plan(jobs);
        let whole = Check {
            circumstances: self.trailer.circumstances.clone(),
            asks_all: true,
            ..Check::new(suite, &plan)
        };
        let expected = |id: &str, view: &C::View| suite.case(id)?.expected_output(view);
        check(&whole, &Replay::new(self, &expected), observer).map_err(|error| error.to_string())
    }

    fn plan(&self, jobs: usize) -> RunPlan {
        RunPlan {
            jobs,
            ..self.trailer.plan.clone()
        }
    }
}

impl RecordedAnswers<Value> {
    /// Replays the whole run of a texture stage.
    ///
    /// # Errors
    /// Returns a message if the whole run needs a request that no part sent.
    pub fn merge_texture(
        &self,
        suite: &Suite<TextureCase>,
        jobs: usize,
        observer: &dyn Observer,
    ) -> Result<(TextureRun, Report), String> {
        let plan = self.plan(jobs);
        let whole = TextureCheck {
            circumstances: self.trailer.circumstances.clone(),
            ..TextureCheck::new(suite, &plan)
        };
        let expected = |id: &str, _: &TextureView| Some(suite.case(id)?.expect.clone());
        let replay = Replay::new(self, &expected);
        texture::check(&whole, &replay, observer).map_err(|error| error.to_string())
    }
}

/// A decoder that gives the recorded answers.
struct Replay<'a, V, T> {
    answers: &'a RecordedAnswers<T>,
    /// Returns the output of the reference for a case in a view.
    expected: &'a (dyn Fn(&str, &V) -> Option<T> + Sync),
    /// The first request without a recorded answer.
    missing: OnceLock<String>,
}

impl<'a, V: Display, T: Output> Replay<'a, V, T> {
    fn new(
        answers: &'a RecordedAnswers<T>,
        expected: &'a (dyn Fn(&str, &V) -> Option<T> + Sync),
    ) -> Replay<'a, V, T> {
        Replay {
            answers,
            expected,
            missing: OnceLock::new(),
        }
    }

    /// Returns the recorded answer to a request. If no part repeated the request, returns the first answer again, because the
    /// verdict did not require a repetition.
    fn find_reply(&self, request: &Request<'_, V>) -> Option<Reply<T>> {
        let (file, view) = (shards::digest(request.file), request.view.to_string());
        let known = |attempt| {
            let key = (file.clone(), view.clone(), attempt);
            self.answers.known.get(&key)
        };
        let record = known(request.attempt).or_else(|| known(AttemptKind::Usual))?;
        let answer = match &record.answer {
            Some(answer) => answer.clone(),
            None => Answer::Decoded((self.expected)(&record.case, request.view)?),
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

impl<V: Display, T: Output> Subject<V, T> for Replay<'_, V, T> {
    fn ask(&self, request: &Request<'_, V>, _: usize) -> Reply<T> {
        self.find_reply(request).unwrap_or_else(|| {
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
