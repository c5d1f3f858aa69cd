//! Failure modes: kinds of responses without an image.

use std::fmt;

use super::witness::Witness;
use ptm_suite::kit::last_message::last_message;
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
    /// Malformed frame, with its error message.
    MalformedFrame(String),
    /// Too much output, memory that exceeds the limit, or an input file that was changed.
    Floods,
    RunsOutOfMemory,
    ChangesInput,
    /// The response could not be obtained.
    Other(&'static str),
}

impl PartialEq for FailureMode {
    fn eq(&self, other: &FailureMode) -> bool {
        match (self, other) {
            // The messages of an exception may differ in numbers, but exit statuses are different crashes.
            (FailureMode::Crashes(a), FailureMode::Crashes(b)) => {
                let is_exception = |details: &String| ProcessEnd::parse(details).is_none();
                a == b || is_exception(a) && is_exception(b) && message_form(a) == message_form(b)
            }
            // Similar errors differ in numbers and names.
            (FailureMode::MalformedFrame(a), FailureMode::MalformedFrame(b)) => {
                generalize(a) == generalize(b)
            }
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
                FailureMode::MalformedFrame(error.clone())
            }
            Response::Violation(Answer::Flooded(_)) => FailureMode::Floods,
            Response::Violation(Answer::OutOfMemory(_)) => FailureMode::RunsOutOfMemory,
            Response::Violation(Answer::Tampered(_)) => FailureMode::ChangesInput,
            Response::Violation(answer) => FailureMode::Other(answer.name()),
        })
    }

    /// Changes the mode so that it also describes an equal one.
    fn join(&mut self, other: FailureMode) {
        match (self, other) {
            (FailureMode::TimesOut(lowest), FailureMode::TimesOut(limit)) => {
                *lowest = limit.min(*lowest);
            }
            (FailureMode::MalformedFrame(error), FailureMode::MalformedFrame(other))
            | (FailureMode::Crashes(error), FailureMode::Crashes(other))
                if *error != other && !error.starts_with(FOR_EXAMPLE) =>
            {
                error.insert_str(0, FOR_EXAMPLE);
            }
            _ => {}
        }
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
                    known.join(mode);
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

/// Prefix of the error in one of several malformed frames, or of one of several exceptions.
const FOR_EXAMPLE: &str = "for example, ";

/// Starts of the messages with which glibc ends a program that has corrupted its heap. Which one depends on chance.
const HEAP_MESSAGES: [&str; 11] = [
    "corrupted double-linked list",
    "corrupted size vs. prev_size",
    "corrupted unsorted chunks",
    "double free or corruption",
    "free(): ",
    "malloc(): ",
    "malloc_consolidate(): ",
    "munmap_chunk(): ",
    "realloc(): ",
    "unaligned fastbin chunk",
    "unaligned tcache chunk",
];

/// Returns the form of the last message on standard error, or an empty string if there is none. Messages with the same form differ
/// only in numbers and quotations, or all say that the heap is corrupted.
pub(super) fn message_form(stderr: &str) -> String {
    let message = last_message(stderr).unwrap_or_default();
    if HEAP_MESSAGES.iter().any(|start| message.starts_with(start)) {
        return "the heap is corrupted".to_owned();
    }
    let unquoted = message
        .trim_start_matches(FOR_EXAMPLE)
        .split(['"', '\'', '`'])
        .step_by(2)
        .collect::<Vec<_>>();
    let unquoted = unquoted.join("…");
    let words = unquoted.split_whitespace().map(|word| {
        let is_path = word.contains(['/', '\\']);
        let has_digit = word.contains(|c: char| c.is_ascii_digit());
        let value = word.trim_matches(|c: char| !c.is_ascii_alphabetic());
        let is_special = ["inf", "infinity", "nan"].contains(&&*value.to_ascii_lowercase());
        let is_number = has_digit || is_special;
        if is_path || is_number { "…" } else { word }
    });
    words.collect::<Vec<_>>().join(" ")
}

/// Replaces quotations and numbers in an error with ellipses, and drops the hint after a semicolon, so that similar errors compare equal.
fn generalize(error: &str) -> String {
    let error = error.trim_start_matches(FOR_EXAMPLE);
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
    /// Writes a verb phrase that takes the files as its object: "refuses", "ends with exit status 1 on".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FailureMode::Refuses => f.write_str("refuses"),
            FailureMode::Unsupported => f.write_str("exits with 69 (unsupported) on"),
            FailureMode::Crashes(end) if self.refusal_status().is_some() => {
                write!(f, "ends with {end} on")
            }
            FailureMode::Crashes(status) => write!(f, "crashes ({status}) on"),
            FailureMode::TimesOut(limit) => write!(f, "{limit} on"),
            FailureMode::MalformedFrame(error) => {
                write!(f, "gives no valid answer ({error}) for")
            }
            FailureMode::Floods => f.write_str("writes more output than any frame needs for"),
            FailureMode::RunsOutOfMemory => f.write_str("runs out of memory on"),
            FailureMode::ChangesInput => f.write_str("changes or removes its input file for"),
            FailureMode::Other(name) => write!(f, "gives no answer ({name}) for"),
        }
    }
}
