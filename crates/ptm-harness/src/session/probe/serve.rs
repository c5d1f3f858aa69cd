//! The steps of a probe in serve mode, which is optional but faster: one process for all files.
//!
//! `DECODER serve` reads lines of the form `SEQ VIEW PATH` and answers each at once: with `SEQ ok NBYTES` and a frame, `SEQ
//! reject 65`, or `SEQ unsupported FEATURE`. The answer in one-shot mode is considered correct here, even if its image is wrong.

use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Instant;

use crate::runner::call::{Call, MAX_WAIT, POLL_INTERVAL};
use crate::runner::scratch::Workspace;
use ptm_suite::kit::last_message::quote_last_message;
use ptm_suite::protocol::frame::{Answer, EXIT_MALFORMED, Frame, TimeLimit, View};
use ptm_suite::protocol::request::AttemptKind;

use super::calls::Calls;
use super::checklist::{Checklist, ProbeRequest, Reproduction};
use super::message::{ProbeFault, Slots, fault};
use super::one_shot::FileReplies;

const MALFORMED: &[u8] = b"PTM_1.2\n";

/// Reason to end the steps early: the number of requests that were sent and a fault, or `None` if serve mode is not offered.
type Stop = Option<(usize, ProbeFault)>;

/// Runs the steps of serve mode: requests two frames and a refusal, one after the other, then more of them at once if the decoder
/// declares `pipelined`, and then ends the process.
pub(super) fn probe_serve_mode(calls: &Calls, first: &FileReplies, list: &mut Checklist) {
    match steps(calls, first, list) {
        Ok(()) => list.add_good("serve: the process ends when its input ends"),
        Err(None) if declares_serve_mode(calls) => {
            let message = Dialog::start(calls).map(|mut dialog| {
                let file = dialog.write_input("file.ptm", &first.sample.file);
                dialog.send(1, &first.replies[0].0, &[&file]);
                let _ = dialog.end();
                quote_last_message("; ", &String::from_utf8_lossy(&dialog.call.errors))
            });
            let slots: &Slots = &[("message", &message.unwrap_or_default())];
            let whole = first.sample.reproduction(&first.replies[0].0).requests;
            let reproduction = Reproduction {
                serve: true,
                requests: whole,
            };
            list.add_fault(&"serve", fault("serve-declared", slots), reproduction);
        }
        Err(None) => {
            list.add_absent("serve: not offered (optional); ptm-conform example shows both modes");
        }
        Err(Some((count, fault))) => {
            // Reproduce the dialog up to the fault.
            let whole = first
                .sample
                .reproduction(&first.replies[0].0)
                .requests
                .remove(0);
            let malformed = ProbeRequest {
                file_name: "malformed.ptm".to_owned(),
                file: MALFORMED.to_vec(),
                ..whole.clone()
            };
            let mut requests = vec![whole.clone(), malformed, whole];
            requests.truncate(count);
            let serve = true;
            list.add_fault(&"serve", fault, Reproduction { serve, requests });
        }
    }
}

fn declares_serve_mode(calls: &Calls) -> bool {
    let capabilities = calls.decoder.capabilities(calls.scratch);
    capabilities.is_ok_and(|declared| declared.serves)
}

fn steps(calls: &Calls, first: &FileReplies, list: &mut Checklist) -> Result<(), Stop> {
    let (view, reply) = &first.replies[0];
    let Answer::Decoded(right) = &reply.answer else {
        return Err(None);
    };
    let (mut dialog, mut whole, mut malformed) = start(calls, first).ok_or(None)?;
    let limit = AttemptKind::Alone.time_limit(calls.decoder.timeout);
    let too_slow = |file: &str| fault("serve-time-limit", &[("limit", &limit), ("file", &file)]);
    let after = |count: usize, name: &str| Err(Some((count, fault(name, &[]))));
    let mut served = dialog.ask(1, view, &whole);
    dialog.time_limit = limit;
    if let ServeResult::NoAnswer = served {
        // Some programs mistake the word `serve` for a view and wait; others answer when their input ends, or are slow.
        match dialog.end() {
            ServeResult::Answer(line, _) if line.starts_with("1 ") => {}
            _ => return Err(None),
        }
        (dialog, whole, malformed) = start(calls, first).ok_or(None)?;
        dialog.time_limit = limit;
        served = dialog.ask(1, view, &whole);
    }
    match served {
        ServeResult::Answer(line, bytes) => {
            judge(&line, &bytes, right).map_err(|fault| Some((1, fault)))?;
        }
        ServeResult::NoAnswer => return after(1, "serve-buffered"),
        ServeResult::Ended(_) => return Err(None),
        ServeResult::Fault(fault) => return Err(Some((1, fault))),
    }
    list.add_good("serve: the first response comes immediately and equals the one-shot response");
    if let Some(surplus) = dialog.surplus() {
        return Err(Some((1, fault("serve-surplus", &[("surplus", &surplus)]))));
    }
    match dialog.ask(2, view, &malformed) {
        ServeResult::Answer(line, _) => {
            let code = line.trim_end().strip_prefix("2 reject ");
            let code: Option<i32> = code.and_then(|code| code.parse().ok());
            if code.is_none() || code != Some(EXIT_MALFORMED) && code != calls.decoder.reject_exit {
                let slots: &Slots = &[("line", &format!("{line:?}"))];
                return Err(Some((2, fault("serve-wrong-refusal", slots))));
            }
        }
        ServeResult::Ended(_) => return after(2, "serve-gone"),
        ServeResult::NoAnswer => return Err(Some((2, too_slow("a malformed file")))),
        ServeResult::Fault(fault) => return Err(Some((2, fault))),
    }
    list.add_good("serve: a malformed file is refused");
    match dialog.ask(3, view, &whole) {
        ServeResult::Answer(line, bytes) if judge(&line, &bytes, right).is_ok() => {}
        ServeResult::Answer(..) => return after(3, "serve-state"),
        ServeResult::NoAnswer => return Err(Some((3, too_slow("a third file")))),
        _ => return after(3, "serve-third"),
    }
    list.add_good("serve: a refused file does not affect the next response");
    let capabilities = calls.decoder.capabilities(calls.scratch);
    if capabilities.is_ok_and(|declared| declared.pipelined) {
        dialog.send(4, view, &[&whole, &malformed, &whole, &malformed]);
        let is_answered = |sequence: u32| match dialog.answer(sequence) {
            ServeResult::Answer(line, bytes) if sequence.is_multiple_of(2) => {
                judge(&line, &bytes, right).is_ok()
            }
            ServeResult::Answer(line, _) => line.contains(" reject "),
            _ => false,
        };
        let answered = (4..8).map(is_answered).take_while(|&answered| answered);
        let count = answered.count();
        if count < 4 {
            return Err(Some((3, fault("serve-pipelined", &[("count", &count)]))));
        }
        list.add_good("serve: requests that are sent at once are answered in order");
    }
    match dialog.end() {
        ServeResult::Ended(true) => Ok(()),
        _ => after(3, "serve-end"),
    }
}

/// Starts the process, and writes an ordinary file and a malformed one for it.
fn start<'a>(calls: &Calls<'a>, first: &FileReplies) -> Option<(Dialog<'a>, PathBuf, PathBuf)> {
    let mut dialog = Dialog::start(calls)?;
    let whole = dialog.write_input("one file.ptm", &first.sample.file);
    let malformed = dialog.write_input("malformed.ptm", MALFORMED);
    Some((dialog, whole, malformed))
}

/// Checks that an answer is equivalent to the frame returned in one-shot mode.
fn judge(line: &str, bytes: &[u8], expected: &Frame) -> Result<(), ProbeFault> {
    let frame = Frame::read(bytes).map_err(|error| {
        let name = match bytes.contains(&b'\n') {
            true => "serve-count",
            false => "serve-frame",
        };
        fault(name, &[("error", &error), ("line", &format!("{line:?}"))])
    })?;
    match frame.is_equivalent(expected) {
        true => Ok(()),
        false => Err(fault("serve-differs", &[])),
    }
}

/// The result of waiting for an answer from the process.
enum ServeResult {
    /// The first line of an answer, and the bytes that it announces.
    Answer(String, Vec<u8>),
    /// No complete answer within the time limit.
    NoAnswer,
    /// The process ended; true for status 0.
    Ended(bool),
    /// Wrong output.
    Fault(ProbeFault),
}

/// A conversation with a process in serve mode. Protocol errors are tolerated.
struct Dialog<'a> {
    call: Call,
    workspace: Workspace<'a>,
    time_limit: TimeLimit,
}

/// Maximum size of an answer in bytes.
const MAX_ANSWER_BYTES: usize = 1 << 20;

impl<'a> Dialog<'a> {
    fn start(calls: &Calls<'a>) -> Option<Dialog<'a>> {
        let (decoder, workspace) = (calls.decoder, calls.scratch.workspace().ok()?);
        let words = decoder.command_with(&[OsStr::new("serve")]);
        let call = decoder.start_command(&words, &workspace.work_dir, Stdio::piped());
        Some(Dialog {
            call: call.ok()?,
            workspace,
            time_limit: AttemptKind::Usual.time_limit(decoder.timeout),
        })
    }

    /// Writes a file for a request. Write errors are ignored: the decoder then finds no file.
    fn write_input(&mut self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.workspace.write_input(name, bytes);
        path.unwrap_or_else(|_| PathBuf::from(name))
    }

    fn ask(&mut self, sequence: u32, view: &View, path: &Path) -> ServeResult {
        self.send(sequence, view, &[path]);
        self.answer(sequence)
    }

    /// Sends requests for these files at once. `sequence` is the number of the first request.
    fn send(&mut self, sequence: u32, view: &View, paths: &[&Path]) {
        let lines = (sequence..)
            .zip(paths)
            .map(|(sequence, path)| format!("{sequence} {view} {}\n", path.display()));
        if let Some(input) = &mut self.call.child.stdin {
            // A process that has ended is noticed when its answer is awaited.
            let _ = input.write_all(lines.collect::<String>().as_bytes());
        }
    }

    /// Waits for the answer to request `sequence`.
    fn answer(&mut self, sequence: u32) -> ServeResult {
        match self.wait() {
            ServeResult::Answer(line, _) if !line.starts_with(&format!("{sequence} ")) => {
                let slots: &Slots = &[("sequence", &sequence), ("line", &format!("{line:?}"))];
                ServeResult::Fault(fault("serve-sequence", slots))
            }
            served => served,
        }
    }

    /// Returns what was read after the last answer, if anything.
    fn surplus(&self) -> Option<String> {
        let output = &self.call.output;
        (!output.is_empty())
            .then(|| format!("\"{}\"", output[..output.len().min(20)].escape_ascii()))
    }

    /// Closes the input of the process and waits for a last answer, or for the end of the process.
    fn end(&mut self) -> ServeResult {
        self.call.child.stdin = None;
        self.wait()
    }

    fn wait(&mut self) -> ServeResult {
        let deadline = Instant::now() + self.time_limit.0.min(MAX_WAIT);
        loop {
            let has_ended = self.call.has_ended();
            let read = self.call.read_available(MAX_ANSWER_BYTES);
            if let Some(served) = self.take_answer() {
                return served;
            }
            if has_ended {
                let status = self.call.kill_and_reap(&self.workspace.work_dir);
                return ServeResult::Ended(status.is_ok_and(|status| status.success()));
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() || read.is_err() || self.call.output.len() > MAX_ANSWER_BYTES {
                return ServeResult::NoAnswer;
            }
            // If there is an error, the next read returns it, too.
            let _ = self.call.wait_for_event(None, left.min(POLL_INTERVAL));
        }
    }

    /// Removes and returns the first answer in the output, if it is complete.
    fn take_answer(&mut self) -> Option<ServeResult> {
        let output = &mut self.call.output;
        let end = output.iter().position(|&byte| byte == b'\n')?;
        let line = String::from_utf8_lossy(&output[..end]).into_owned();
        let words: Vec<&str> = line.split(' ').collect();
        let shown = format!("{line:?}");
        let wrong = |name| Some(ServeResult::Fault(fault(name, &[("line", &shown)])));
        let size = match words[..] {
            [_, "ok", size] => match size.parse() {
                Ok(size @ 0..=MAX_ANSWER_BYTES) => size,
                _ => return wrong("serve-size"),
            },
            [_, "reject" | "unsupported", ..] => 0,
            _ => return wrong("serve-words"),
        };
        let bytes = output.get(end + 1..end + 1 + size)?.to_vec();
        output.drain(..end + 1 + size);
        Some(ServeResult::Answer(line, bytes))
    }
}

impl Drop for Dialog<'_> {
    fn drop(&mut self) {
        // An error means that no process is left.
        let _ = self.call.kill_and_reap(&self.workspace.work_dir);
    }
}
