//! Failure modes: kinds of responses without an image.

use std::fmt;

use super::witness::Witness;
use ptm_suite::protocol::frame::{Answer, ProcessEnd, TimeLimit};
use ptm_suite::verdicts::observation::Response;

/// A response without an image. Two files fail in the same way if their failure modes are equal.
#[derive(Clone, Debug)]
pub(super) enum FailureMode {
    Refuses,
    Unsupported,
    /// Crash, with its details.
    Crashes(String),
    /// Exceeded time limit. A file that was requested again has exceeded a higher one, so limits are not compared.
    TimesOut(TimeLimit),
    /// Malformed frame, with its error message. Details of the message are removed.
    MalformedFrame(String),
    /// Another violation of the protocol.
    Other(&'static str),
}

impl PartialEq for FailureMode {
    fn eq(&self, other: &FailureMode) -> bool {
        match (self, other) {
            (FailureMode::Crashes(a), FailureMode::Crashes(b))
            | (FailureMode::MalformedFrame(a), FailureMode::MalformedFrame(b)) => a == b,
            (FailureMode::Other(a), FailureMode::Other(b)) => a == b,
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }
}

impl FailureMode {
    /// Returns the failure mode of a response, or `None` for an image.
    pub fn new(witness: &Witness) -> Option<FailureMode> {
        Some(match &witness.observation.response {
            Response::Image { .. } => return None,
            Response::Rejected => FailureMode::Refuses,
            Response::Unsupported => FailureMode::Unsupported,
            Response::Violation(Answer::Crashed(status)) => FailureMode::Crashes(status.clone()),
            Response::Violation(Answer::TimedOut(limit)) => FailureMode::TimesOut(*limit),
            Response::Violation(Answer::ProtocolError(error)) => {
                FailureMode::MalformedFrame(generalize(error))
            }
            Response::Violation(answer) => FailureMode::Other(answer.name()),
        })
    }

    /// Returns the failure modes of these witnesses, the most frequent first. The time limit is one that all files exceeded.
    pub fn list_by_frequency(witnesses: &[Witness], indices: &[usize]) -> Vec<FailureMode> {
        let mut modes: Vec<(FailureMode, usize)> = Vec::new();
        for mode in indices
            .iter()
            .filter_map(|&w| FailureMode::new(&witnesses[w]))
        {
            match modes.iter_mut().find(|(known, _)| *known == mode) {
                Some((known, count)) => {
                    *count += 1;
                    if let (FailureMode::TimesOut(lowest), FailureMode::TimesOut(limit)) =
                        (known, mode)
                    {
                        *lowest = limit.min(*lowest);
                    }
                }
                None => modes.push((mode, 1)),
            }
        }
        modes.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
        modes.into_iter().map(|(mode, _)| mode).collect()
    }

    /// Returns the exit status by which the decoder may mean a refusal. Rust panics, shells and signals use the excluded statuses.
    pub fn refusal_status(&self) -> Option<i32> {
        let FailureMode::Crashes(details) = self else {
            return None;
        };
        match ProcessEnd::parse(details)? {
            ProcessEnd::Status(101 | 126 | 127 | 134 | 139) | ProcessEnd::Signal(_) => None,
            ProcessEnd::Status(status) => Some(status),
        }
    }

    /// Returns the witnesses with this failure mode.
    pub fn select(&self, witnesses: &[Witness], indices: &[usize]) -> Vec<usize> {
        let has_mode = |w: &usize| FailureMode::new(&witnesses[*w]).as_ref() == Some(self);
        indices.iter().copied().filter(has_mode).collect()
    }
}

/// Replaces quotations and numbers with ellipses, and drops the hint after a semicolon, so that similar errors compare equal.
fn generalize(error: &str) -> String {
    let unquoted = error.split('"').step_by(2).collect::<Vec<_>>().join("…");
    let words = unquoted.split(';').next().unwrap_or_default().split(' ');
    let generalize_word = |word: &str| {
        let value = word.trim_matches(['(', ')', ',', ':']);
        match value.starts_with(|c: char| c.is_ascii_digit()) {
            true => word.replace(value, "…"),
            false => word.to_owned(),
        }
    };
    words.map(generalize_word).collect::<Vec<_>>().join(" ")
}

impl fmt::Display for FailureMode {
    /// Writes a verb phrase that takes the files as its object: "refuses", "crashes (exit status 1) on".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FailureMode::Refuses => f.write_str("refuses"),
            FailureMode::Unsupported => f.write_str("exits with 69 (unsupported) on"),
            FailureMode::Crashes(status) => write!(f, "crashes ({status}) on"),
            FailureMode::TimesOut(limit) => write!(f, "{limit} on"),
            FailureMode::MalformedFrame(error) => {
                write!(f, "gives no valid answer ({error}) for")
            }
            FailureMode::Other(name) => write!(f, "fails ({name}) on"),
        }
    }
}
