//! Requests to a decoder and its replies, whatever carries them: a process, a function or a recording.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::protocol::frame::{Answer, EXIT_MALFORMED, Frame, TimeLimit, View};

/// A request for a view of a file.
#[derive(Clone, Debug)]
pub struct Request<'a, V = View> {
    /// Name of the file, without its extension.
    pub name: &'a str,
    /// Requested view.
    pub view: &'a V,
    /// Contents of the file.
    pub file: &'a [u8],
    /// Maximum size of a frame of the file, in bytes.
    pub max_frame_bytes: usize,
    /// The kind of attempt, which determines the process and the time limit.
    pub attempt: AttemptKind,
}

/// A kind of attempt to get an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AttemptKind {
    /// The usual attempt: in serve mode, in the process that answered the previous request.
    #[default]
    Usual,
    /// A repetition whose answer is compared with the first one: in one-shot mode, even if the decoder serves.
    Repetition,
    /// An attempt with a higher time limit while no other request is in progress: in a new process, also in serve mode.
    Alone,
}

/// Factor by which the time limit of [`AttemptKind::Alone`] is higher.
pub const ALONE_FACTOR: u32 = 3;

impl AttemptKind {
    /// Returns the time limit of this attempt. `timeout` is the usual time limit.
    #[must_use]
    pub const fn time_limit(self, timeout: Duration) -> TimeLimit {
        TimeLimit(match self {
            AttemptKind::Usual | AttemptKind::Repetition => timeout,
            AttemptKind::Alone => timeout.saturating_mul(ALONE_FACTOR),
        })
    }
}

impl<'a, V> Request<'a, V> {
    /// Creates a request that is sent while no other request is in progress, so its time limit is higher than usual.
    #[must_use]
    pub const fn new(name: &'a str, view: &'a V, file: &'a [u8], max_frame_bytes: usize) -> Self {
        Request {
            name,
            view,
            file,
            max_frame_bytes,
            attempt: AttemptKind::Alone,
        }
    }

    /// Returns the maximum number of bytes to read from an answer.
    #[must_use]
    pub fn max_answer_bytes(&self) -> usize {
        4 * self.max_frame_bytes + 65_536
    }
}

/// Response to a request.
#[derive(Clone, Debug)]
pub struct Reply<T = Frame> {
    /// Answer of the decoder.
    pub answer: Answer<T>,
    /// Start of standard error.
    pub stderr: String,
    /// Exit status, if the process exited.
    pub exit: Option<i32>,
    /// Name of the previous request to the same process.
    pub previous_request: Option<String>,
    /// Failed answer of the serving process. If it is present, `answer` is the answer of a new process.
    pub serve_mode_answer: Option<Answer<T>>,
    /// Standard output, up to the read limit.
    pub stdout: Vec<u8>,
}

impl<T> From<Answer<T>> for Reply<T> {
    /// Creates a reply that contains only an answer.
    fn from(answer: Answer<T>) -> Reply<T> {
        Reply {
            answer,
            stderr: String::new(),
            exit: None,
            previous_request: None,
            serve_mode_answer: None,
            stdout: Vec::new(),
        }
    }
}

impl<T> Reply<T> {
    /// Returns true if the request exceeded its time limit.
    #[must_use]
    pub const fn is_timeout(&self) -> bool {
        matches!(self.answer, Answer::TimedOut(_))
    }

    /// Returns true if the call ended in neither an output nor a refusal, or if a serving process did not answer.
    #[must_use]
    pub fn is_violation(&self) -> bool {
        self.answer.violation().is_some() || self.serve_mode_answer.is_some()
    }

    /// Returns true if the reply is a refusal with an exit status that has other meanings as well.
    #[must_use]
    pub fn is_ambiguous_refusal(&self) -> bool {
        matches!(self.answer, Answer::Rejected)
            && self.exit.is_some_and(|exit| exit != EXIT_MALFORMED)
    }
}
