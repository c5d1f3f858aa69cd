//! A lenient conversation with a process in serve mode.

use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, Stdio};
use std::time::{Duration, Instant};

use crate::protocol::frame::View;
use crate::runner::call::{Call, MAX_WAIT, POLL_INTERVAL};
use crate::runner::scratch::Workspace;

use super::calls::Calls;
use super::message::{ProbeFault, Slots, fault};

/// One answer: its line, and the bytes that it declares.
pub(super) struct ServedAnswer {
    pub(super) line: String,
    pub(super) bytes: Vec<u8>,
}

/// The behavior of the process while an answer was expected.
pub(super) enum Served {
    Answer(ServedAnswer),
    /// No complete answer within the timeout.
    Nothing,
    /// The process ended; true for status 0.
    Gone(bool),
    /// Wrong output.
    Wrong(ProbeFault),
}

/// A process in serve mode.
pub(super) struct Dialog<'a> {
    call: Call,
    /// `None` once it is closed.
    input: Option<ChildStdin>,
    workspace: Workspace<'a>,
    timeout: Duration,
}

/// The most bytes of an answer.
const MAX_ANSWER: usize = 1 << 20;

impl<'a> Dialog<'a> {
    pub(super) fn start(calls: &Calls<'a>) -> Option<Dialog<'a>> {
        let (decoder, workspace) = (calls.decoder, calls.scratch.workspace().ok()?);
        let words = decoder.followed_by(&[OsStr::new("serve")]);
        let started = decoder.start(&words, &workspace.workplace, Stdio::piped());
        let mut call = started.ok()?;
        Some(Dialog {
            input: call.child.stdin.take(),
            call,
            workspace,
            timeout: decoder.timeout,
        })
    }

    /// Writes a file for a request. If it cannot be written, the decoder does not find it.
    pub(super) fn lay_down(&mut self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.workspace.lay_down(name, bytes);
        path.unwrap_or_else(|_| PathBuf::from(name))
    }

    pub(super) fn ask(&mut self, sequence: u32, view: &View, path: &Path) -> Served {
        let request = format!("{sequence} {view} {}\n", path.display());
        if let Some(input) = &mut self.input {
            // A process that has ended is noticed below.
            let _ = input.write_all(request.as_bytes());
        }
        match self.wait() {
            Served::Answer(answer) if !answer.line.starts_with(&format!("{sequence} ")) => {
                let line = format!("{:?}", answer.line);
                let slots: &Slots = &[("sequence", &sequence), ("line", &line)];
                Served::Wrong(fault("serve-sequence", slots))
            }
            served => served,
        }
    }

    /// Closes its input and waits for a last answer, or for its end.
    pub(super) fn end(&mut self) -> Served {
        self.input = None;
        self.wait()
    }

    fn wait(&mut self) -> Served {
        let deadline = Instant::now() + self.timeout.min(MAX_WAIT);
        loop {
            let has_ended = self.call.has_ended();
            let read = self.call.read_what_is_there(MAX_ANSWER);
            if let Some(served) = self.whole_answer() {
                return served;
            }
            if has_ended {
                let status = self.call.end(&self.workspace.workplace);
                return Served::Gone(status.is_ok_and(|status| status.success()));
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() || read.is_err() || self.call.output.len() > MAX_ANSWER {
                return Served::Nothing;
            }
            // An error will occur again in the next read.
            let _ = self.call.wait_for_news(None, left.min(POLL_INTERVAL));
        }
    }

    /// Takes an answer from the output, if it is complete.
    fn whole_answer(&mut self) -> Option<Served> {
        let output = &mut self.call.output;
        let end = output.iter().position(|&byte| byte == b'\n')?;
        let line = String::from_utf8_lossy(&output[..end]).into_owned();
        let words: Vec<&str> = line.split(' ').collect();
        let wrong = |name| {
            Some(Served::Wrong(fault(
                name,
                &[("line", &format!("{line:?}"))],
            )))
        };
        let size = match words[..] {
            [_, "ok", size] => match size.parse::<usize>() {
                Ok(size) if size <= MAX_ANSWER => size,
                _ => return wrong("serve-size"),
            },
            [_, "reject" | "unsupported", ..] => 0,
            _ => return wrong("serve-words"),
        };
        let bytes = output.get(end + 1..end + 1 + size)?.to_vec();
        output.drain(..end + 1 + size);
        Some(Served::Answer(ServedAnswer { line, bytes }))
    }
}

impl Drop for Dialog<'_> {
    fn drop(&mut self) {
        // An error means that no process is left.
        let _ = self.call.end(&self.workspace.workplace);
    }
}
