//! The ways in which a decoder fails to show an image.

use std::fmt;

use super::witness::Witness;
use crate::protocol::frame::Answer;
use crate::session::observation::Response;

/// A response without an image. Two files fail in the same way if their modes are equal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum FailureMode {
    Refuses,
    Unsupported,
    /// With the exit status or the signal.
    Crashes(String),
    Hangs,
    /// With the error of the frame, without quotations and numbers.
    MalformedFrame(String),
    /// Another violation of the protocol.
    Other(&'static str),
}

impl FailureMode {
    /// Returns the mode of a response, or `None` for an image.
    pub fn of(witness: &Witness) -> Option<FailureMode> {
        Some(match &witness.observation.response {
            Response::Image { .. } => return None,
            Response::Rejected => FailureMode::Refuses,
            Response::Unsupported => FailureMode::Unsupported,
            Response::Violation(Answer::Crashed(how)) => FailureMode::Crashes(how.clone()),
            Response::Violation(Answer::Hung(_)) => FailureMode::Hangs,
            Response::Violation(Answer::ProtocolError(what)) => {
                // The rule comes last, after the quoted line.
                let unquoted = what.split('"').step_by(2).map(str::trim);
                let general = match what.split_once(" announces ") {
                    Some((_, "an image without texels")) => "an image without texels",
                    Some(_) => "another number of bytes than its first line announces",
                    None if what.starts_with("standard output begins") => "no PTM1 line",
                    None => unquoted.last().unwrap_or_default(),
                };
                FailureMode::MalformedFrame(general.to_owned())
            }
            Response::Violation(answer) => FailureMode::Other(answer.name()),
        })
    }

    /// Returns the modes of these witnesses, the most frequent first.
    pub fn among(witnesses: &[Witness], of: &[usize]) -> Vec<FailureMode> {
        let mut modes: Vec<(FailureMode, usize)> = Vec::new();
        for mode in of.iter().filter_map(|&w| FailureMode::of(&witnesses[w])) {
            match modes.iter_mut().find(|(known, _)| *known == mode) {
                Some((_, count)) => *count += 1,
                None => modes.push((mode, 1)),
            }
        }
        modes.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
        modes.into_iter().map(|(mode, _)| mode).collect()
    }

    /// Returns the witnesses that fail in this way.
    pub fn select(&self, witnesses: &[Witness], of: &[usize]) -> Vec<usize> {
        let fails_so = |w: &usize| FailureMode::of(&witnesses[*w]).as_ref() == Some(self);
        of.iter().copied().filter(fails_so).collect()
    }
}

impl fmt::Display for FailureMode {
    /// Writes a verb whose object is the files: "refuses", "crashes (exit status 1) on".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FailureMode::Refuses => f.write_str("refuses"),
            FailureMode::Unsupported => f.write_str("exits with 69 (unsupported) on"),
            FailureMode::Crashes(how) => write!(f, "crashes ({how}) on"),
            FailureMode::Hangs => f.write_str("does not terminate on"),
            FailureMode::MalformedFrame(what) => {
                write!(f, "writes a malformed frame ({what}) for")
            }
            FailureMode::Other(name) => write!(f, "fails ({name}) on"),
        }
    }
}
