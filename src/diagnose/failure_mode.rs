//! What a decoder does instead of showing a picture.

use std::fmt;

use super::witness::Witness;
use crate::protocol::frame::Answer;
use crate::session::observation::Response;

/// One way not to show a picture. Two files fail alike if these are equal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum FailureMode {
    Refuses,
    Unsupported,
    /// With the exit status or the signal.
    Crashes(String),
    Hangs,
    /// With what is wrong with the frame, but for the numbers, which differ from file to file.
    MalformedFrame(String),
    /// Another violation of the protocol.
    Other(&'static str),
}

impl FailureMode {
    /// How `witness` was answered; nothing where a picture was shown.
    pub fn of(witness: &Witness) -> Option<FailureMode> {
        Some(match &witness.observation.response {
            Response::Picture { .. } => return None,
            Response::Rejected => FailureMode::Refuses,
            Response::Unsupported => FailureMode::Unsupported,
            Response::Violation(Answer::Crashed(how)) => FailureMode::Crashes(how.clone()),
            Response::Violation(Answer::Hung(_)) => FailureMode::Hangs,
            Response::Violation(Answer::ProtocolError(what)) => {
                let general: String = what.chars().take_while(|c| *c != '"').collect();
                FailureMode::MalformedFrame(general.trim_end().to_owned())
            }
            Response::Violation(answer) => FailureMode::Other(answer.name()),
        })
    }

    /// The modes among these witnesses, the most frequent first.
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

    /// Those of these witnesses that fail so.
    pub fn select(&self, witnesses: &[Witness], of: &[usize]) -> Vec<usize> {
        let fails_so = |w: &usize| FailureMode::of(&witnesses[*w]).as_ref() == Some(self);
        of.iter().copied().filter(fails_so).collect()
    }
}

impl fmt::Display for FailureMode {
    /// A verb that the files follow: "refuses", "crashes (exit status 1) on".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FailureMode::Refuses => f.write_str("refuses"),
            FailureMode::Unsupported => f.write_str("exits with 69 (unsupported) on"),
            FailureMode::Crashes(how) => write!(f, "crashes ({how}) on"),
            FailureMode::Hangs => f.write_str("does not terminate on"),
            FailureMode::MalformedFrame(what) if what.is_empty() => {
                f.write_str("writes no frame to standard output for")
            }
            FailureMode::MalformedFrame(what) => {
                write!(f, "writes a malformed frame ({what}) for")
            }
            FailureMode::Other(name) => write!(f, "fails ({name}) on"),
        }
    }
}
