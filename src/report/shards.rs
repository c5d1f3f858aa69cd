//! Partial runs, for more than one machine: the cases of a part, and the recorded answers.
//!
//! A verdict on one case depends on others: on its twin, on other cases with its features, on the dialect. So parts are not
//! merged report by report. Each part records the answers of its decoder in a file next to its report, and the whole is judged
//! from all answers as in a single run (see [`merge`](super::merge)).
//!
//! The file has a line of JSON for each answer, written as it comes, and a last line that identifies the run.

use std::collections::HashMap;
use std::fmt;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Mutex;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::kit::digest::sha256;
use crate::protocol::frame::Answer;
use crate::runner::run::Request;
use crate::session::asking::ReplyTo;
use crate::session::observation::{Observation, Response};
use crate::session::plan::RunPlan;
use crate::session::remark::Remark;
use crate::suite::dialect::Right;
use crate::suite::test_case::{Allowance, TestCase};

/// One of several parts of the suite: `3/8`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// The number of the part, from 1.
    pub number: u32,
    /// The number of all parts.
    pub of: u32,
}

impl Shard {
    /// Returns true if the case of that id belongs to it. That depends on the id alone, so new cases do not move others.
    #[must_use]
    pub fn holds(self, id: &str) -> bool {
        let digest = Sha256::digest(id.as_bytes());
        let first = u64::from_be_bytes(digest[..8].try_into().expect("eight bytes"));
        first % u64::from(self.of) == u64::from(self.number - 1)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Shard, String> {
        let wrong = || format!("expected a part such as 3/8, found {text:?}");
        let (number, of) = text.split_once('/').ok_or_else(wrong)?;
        match (number.parse(), of.parse()) {
            (Ok(number), Ok(of)) if (1..=of).contains(&number) => Ok(Shard { number, of }),
            _ => Err(wrong()),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

/// Properties of a run other than its plan and its answers.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Circumstances {
    /// The command of the decoder.
    pub command: Vec<String>,
    /// The name that it declares.
    pub name: Option<String>,
    /// The version that it declares.
    pub version: Option<String>,
    /// Assumed misreadings.
    pub assumed: Vec<String>,
    /// The limits in force, in words.
    pub limits: Vec<String>,
}

/// Remarks on the run as a whole that do not follow from answers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct OtherRemarks {
    /// Remarks to put before the others.
    pub before: Vec<Remark>,
    /// Remarks to put after the others.
    pub after: Vec<Remark>,
}

/// The last line, which identifies the run. A file without it belongs to an incomplete run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct End {
    /// The version of this program.
    pub version: String,
    /// The digest of the suite.
    pub corpus: String,
    /// The part.
    pub part: Shard,
    /// The run.
    pub circumstances: Circumstances,
    /// The plan, in which the cases of the part are selected.
    pub plan: RunPlan,
    /// Remarks on the run as a whole that do not follow from answers.
    pub remarks: OtherRemarks,
    /// The reason why the run ended before all cases were requested, if it did.
    pub ended_early: Option<String>,
}

/// A recorded answer.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(serialize = "T: Serialize", deserialize = "T: DeserializeOwned"))]
pub struct Kept<T> {
    /// The case.
    pub case: String,
    /// The beginning of the digest of its file, which depends on the spelling of tables.
    pub file: String,
    /// The view.
    pub view: String,
    /// True if a new process was asked, to see whether its answer differs.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub alone: bool,
    /// The answer; None for the expected image.
    pub answer: Option<Answer<T>>,
    /// The exit status.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exit: Option<i32>,
    /// The beginning of standard error.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub stderr: String,
    /// The name of the request that the same process answered before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub after: Option<String>,
    /// Answer of a serving process that failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub served: Option<Answer<T>>,
}

/// A line of the file.
#[derive(Deserialize)]
#[serde(untagged, bound = "T: DeserializeOwned")]
pub(super) enum AnswerRecord<T> {
    Answer(Box<Kept<T>>),
    End(Box<End>),
}

/// Returns the path of the recorded answers next to a report.
#[must_use]
pub fn answers_path(report: &Path) -> PathBuf {
    let mut path = report.as_os_str().to_owned();
    path.push(".answers");
    path.into()
}

/// Returns the beginning of the digest of a file.
pub(super) fn digest(file: &[u8]) -> String {
    sha256(file)[..16].to_owned()
}

/// Records answers as they come.
pub struct Keeper<C: TestCase>(Mutex<Keeping<C::Output>>);

struct Keeping<T> {
    out: BufWriter<File>,
    /// Answers that may equal the expected image, by case and view.
    waiting: HashMap<(String, String), Kept<T>>,
    /// The error of the first line that could not be written.
    failed: Option<io::Error>,
}

impl<C: TestCase> Keeper<C> {
    /// Creates a file.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn new(path: &Path) -> io::Result<Keeper<C>> {
        Ok(Keeper(Mutex::new(Keeping {
            out: BufWriter::new(File::create(path)?),
            waiting: HashMap::new(),
            failed: None,
        })))
    }

    /// Records an answer.
    pub fn answered(&self, request: &Request<'_, C::View>, reply: &ReplyTo<C>) {
        let kept = Kept {
            case: request.name.to_owned(),
            file: digest(request.file),
            view: request.view.to_string(),
            alone: request.needs_new_process,
            answer: Some(reply.answer.clone()),
            exit: reply.exit,
            stderr: reply.stderr.clone(),
            after: reply.previous_request.clone(),
            served: reply.served.clone(),
        };
        let mut keeping = self.0.lock().expect("no worker panics");
        if kept.alone {
            keeping.write(&kept);
        } else {
            let key = (kept.case.clone(), kept.view.clone());
            if let Some(before) = keeping.waiting.insert(key, kept) {
                keeping.write(&before);
            }
        }
    }

    /// Drops the image of an answer that was just recorded, if it equals the expected one.
    pub fn observed(&self, case: &C, observation: &Observation<C>) {
        let expected = matches!(
            observation.response,
            Response::Image {
                right: Right::Anyway(true),
                difference: None,
                allowance: Allowance::None,
                ..
            }
        );
        let mut keeping = self.0.lock().expect("no worker panics");
        let key = (case.id().to_owned(), observation.view.to_string());
        if let Some(mut kept) = keeping.waiting.remove(&key) {
            if expected && case.expected_output(&observation.view).is_some() {
                kept.answer = None;
            }
            keeping.write(&kept);
        }
    }

    /// Completes the file.
    ///
    /// # Errors
    /// The first error of the file system.
    pub fn finish(self, end: &End) -> io::Result<()> {
        let mut keeping = self.0.into_inner().expect("no worker panics");
        let mut waiting: Vec<_> = keeping.waiting.drain().collect();
        waiting.sort_by(|(a, _), (b, _)| a.cmp(b));
        for (_, kept) in waiting {
            keeping.write(&kept);
        }
        keeping.write(end);
        match keeping.failed {
            Some(error) => Err(error),
            None => keeping.out.flush(),
        }
    }
}

impl<T> Keeping<T> {
    fn write(&mut self, record: &impl Serialize) {
        let written = serde_json::to_writer(&mut self.out, record)
            .map_err(io::Error::other)
            .and_then(|()| self.out.write_all(b"\n"));
        if let Err(error) = written {
            self.failed.get_or_insert(error);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shard_is_parsed_as_index_and_count() {
        assert_eq!("3/8".parse(), Ok(Shard { number: 3, of: 8 }));
        for wrong in ["", "3", "0/8", "9/8", "1/0", "3/8/1", "a/8", "-1/8"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }

    /// If the assignment changed, old and new reports could not be merged.
    #[test]
    fn every_case_has_one_permanent_shard() {
        let part_of = |id: &str| {
            let parts = (1..=8).filter(|&number| Shard { number, of: 8 }.holds(id));
            parts.collect::<Vec<_>>()
        };
        assert_eq!(part_of("one-texel-rgb"), [7]);
        assert_eq!(part_of("hand-rgb-blocks"), [7]);
        let counts = (1..=8).map(|number| {
            let part = Shard { number, of: 8 };
            (0..8000)
                .filter(|i| part.holds(&format!("case-{i}")))
                .count()
        });
        assert!(counts.into_iter().all(|count| (900..1100).contains(&count)));
    }
}
