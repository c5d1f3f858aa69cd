//! Partial runs (shards) on several machines: selection of cases and recording of answers.
//!
//! The verdict on a case depends on other cases: on its twin, on cases with the same features, and on the dialect. The
//! reports of the parts therefore cannot be merged directly. Instead, each part records the answers of the decoder in a
//! file next to its report, and all answers are judged together as in a single run (see [`merge`](crate::pipeline::merge)).
//!
//! The file contains one line of JSON per answer, written as the answers arrive, and a last line that identifies the run.

use std::collections::HashMap;
use std::fmt;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize};

use crate::session::{plan::RunPlan, remark::Remark};
use ptm_suite::kit::digest::sha256;
use ptm_suite::kit::shard::Shard;
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::{AttemptKind, Reply, Request};
use ptm_suite::test_case::Output;

/// Properties of a run other than its plan and answers.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Circumstances {
    /// Command line of the decoder.
    pub command: Vec<String>,
    /// Name that the decoder declares.
    pub name: Option<String>,
    /// Version that the decoder declares.
    pub version: Option<String>,
    /// Slugs of the assumed misreadings.
    pub assumed: Vec<String>,
    /// Descriptions of the limits in force.
    pub limits: Vec<String>,
}

/// Remarks on the run as a whole that are not derived from answers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct OtherRemarks {
    /// Remarks to place before those that are derived from answers.
    pub before: Vec<Remark>,
    /// Remarks to place after those that are derived from answers.
    pub after: Vec<Remark>,
}

/// Trailer of an answer file: the last line, which identifies the run. A file without a trailer belongs to an incomplete run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Trailer {
    /// Version of this program.
    pub version: String,
    /// Digest of the suite.
    pub corpus: String,
    /// Part of the suite that was run.
    pub part: Shard,
    /// Circumstances of the run.
    pub circumstances: Circumstances,
    /// Plan of the run, in which only the cases of this part are selected.
    pub plan: RunPlan,
    /// Remarks on the run as a whole that are not derived from answers.
    pub remarks: OtherRemarks,
    /// Reason why the run ended before all cases were requested, if it did.
    pub ended_early: Option<String>,
}

/// Recorded answer of a decoder.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(serialize = "T: Serialize", deserialize = "T: DeserializeOwned"))]
pub struct RecordedAnswer<T> {
    /// Id of the case.
    pub case: String,
    /// Start of the digest of the file that was sent. The file depends on the table spelling.
    pub file: String,
    /// Requested view.
    pub view: String,
    /// The kind of attempt.
    #[serde(
        default,
        alias = "alone",
        deserialize_with = "attempt",
        skip_serializing_if = "is_usual"
    )]
    pub attempt: AttemptKind,
    /// Answer, or `None` if it equals the expected image.
    pub answer: Option<Answer<T>>,
    /// Exit status of the process.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exit: Option<i32>,
    /// Beginning of standard error.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub stderr: String,
    /// Name of the previous request that the same process answered.
    #[serde(default, rename = "after", skip_serializing_if = "Option::is_none")]
    pub previous_request: Option<String>,
    /// Failed answer of the serving process, if a new process answered instead.
    #[serde(default, rename = "served", skip_serializing_if = "Option::is_none")]
    pub serve_mode_answer: Option<Answer<T>>,
}

/// Reads a kind of attempt. Older recordings have a flag instead, which is true for repetitions.
fn attempt<'de, D: Deserializer<'de>>(deserializer: D) -> Result<AttemptKind, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Recorded {
        IsRepetition(bool),
        AttemptKind(AttemptKind),
    }
    Ok(match Recorded::deserialize(deserializer)? {
        Recorded::IsRepetition(true) => AttemptKind::Repetition,
        Recorded::IsRepetition(false) => AttemptKind::Usual,
        Recorded::AttemptKind(attempt) => attempt,
    })
}

fn is_usual(attempt: &AttemptKind) -> bool {
    *attempt == AttemptKind::Usual
}

/// Line of an answer file.
#[derive(Deserialize)]
#[serde(untagged, bound = "T: DeserializeOwned")]
pub(crate) enum AnswerRecord<T> {
    Answer(Box<RecordedAnswer<T>>),
    Trailer(Box<Trailer>),
}

/// Returns the path of the answer file next to a report.
#[must_use]
pub fn answers_path(report: &Path) -> PathBuf {
    let mut path = report.as_os_str().to_owned();
    path.push(".answers");
    path.into()
}

/// Returns the first 16 hexadecimal digits of the digest of a file.
pub(crate) fn digest(file: &[u8]) -> String {
    sha256(file)[..16].to_owned()
}

/// Writes answers to a file as they arrive.
pub struct AnswerRecorder<T>(Mutex<RecorderState<T>>);

struct RecorderState<T> {
    out: BufWriter<File>,
    /// Answers that have not been compared with the expected image yet, by case and view.
    waiting: HashMap<(String, String), RecordedAnswer<T>>,
    /// Error of the first line that could not be written.
    write_error: Option<io::Error>,
}

impl<T: Output> AnswerRecorder<T> {
    /// Creates an answer file.
    ///
    /// # Errors
    /// Returns the I/O error.
    pub fn new(path: &Path) -> io::Result<AnswerRecorder<T>> {
        Ok(AnswerRecorder(Mutex::new(RecorderState {
            out: BufWriter::new(File::create(path)?),
            waiting: HashMap::new(),
            write_error: None,
        })))
    }

    /// Records an answer.
    pub fn record_answer<V: fmt::Display>(&self, request: &Request<'_, V>, reply: &Reply<T>) {
        let record = RecordedAnswer {
            case: request.name.to_owned(),
            file: digest(request.file),
            view: request.view.to_string(),
            attempt: request.attempt,
            answer: Some(reply.answer.clone()),
            exit: reply.exit,
            stderr: reply.stderr.clone(),
            previous_request: reply.previous_request.clone(),
            serve_mode_answer: reply.serve_mode_answer.clone(),
        };
        let mut state = self.0.lock().expect("no worker panics");
        if is_usual(&record.attempt) {
            let key = (record.case.clone(), record.view.clone());
            if let Some(before) = state.waiting.insert(key, record) {
                state.write(&before);
            }
        } else {
            state.write(&record);
        }
    }

    /// Writes the last answer to a case, without the output if it equals the expected one.
    pub fn record_case(&self, id: &str, view: &dyn fmt::Display, is_expected: bool) {
        let mut state = self.0.lock().expect("no worker panics");
        let key = (id.to_owned(), view.to_string());
        if let Some(mut record) = state.waiting.remove(&key) {
            if is_expected {
                record.answer = None;
            }
            state.write(&record);
        }
    }

    /// Writes the remaining answers and the trailer.
    ///
    /// # Errors
    /// Returns the first I/O error.
    pub fn finish(&self, end: &Trailer) -> io::Result<()> {
        let mut state = self.0.lock().expect("no worker panics");
        let mut waiting: Vec<_> = state.waiting.drain().collect();
        waiting.sort_by(|(a, _), (b, _)| a.cmp(b));
        for (_, record) in waiting {
            state.write(&record);
        }
        state.write(end);
        match state.write_error.take() {
            Some(error) => Err(error),
            None => state.out.flush(),
        }
    }
}

impl<T> RecorderState<T> {
    fn write(&mut self, record: &impl Serialize) {
        let written = serde_json::to_writer(&mut self.out, record)
            .map_err(io::Error::other)
            .and_then(|()| self.out.write_all(b"\n"));
        if let Err(error) = written {
            self.write_error.get_or_insert(error);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shard_is_parsed_as_number_and_count() {
        let part: Shard = "3/8".parse().expect("a part");
        assert_eq!((part.number, part.total), (3, 8));
        for wrong in ["", "3", "0/8", "9/8", "1/0", "3/8/1", "a/8", "-1/8"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }

    /// If the assignment of cases to parts changed, old and new reports could not be merged.
    #[test]
    fn every_case_has_one_permanent_shard() {
        let part_of = |id: &str| {
            let parts =
                (1..=8).filter(|&number| Shard { number, total: 8 }.contains(id.as_bytes()));
            parts.collect::<Vec<_>>()
        };
        assert_eq!(part_of("one-texel-rgb"), [7]);
        assert_eq!(part_of("hand-rgb-blocks"), [7]);
        let counts = (1..=8).map(|number| {
            let part = Shard { number, total: 8 };
            (0..8000)
                .filter(|i| part.contains(format!("case-{i}").as_bytes()))
                .count()
        });
        assert!(counts.into_iter().all(|count| (900..1100).contains(&count)));
    }
}
