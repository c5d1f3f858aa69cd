//! Serve mode of PTM-CP 1: a single process answers many requests.
//!
//! ```text
//! to the decoder    SEQ VIEW PATH
//! from the decoder  SEQ ok NBYTES, a line feed and a frame of NBYTES bytes, including its first line
//!                   SEQ reject 65
//!                   SEQ unsupported FEATURE
//! ```
//! Each job has a separate process. If a process exits or answers out of order, it is killed, its request is repeated in one-shot
//! mode, and the next request starts a new serving process. A process that exceeds the time limit is killed, too, but its request
//! is not repeated here: the run repeats it later, in a new serving process.
//!
//! A process is sent one request at a time or, if the decoder declares `pipelined`, several at once. If it does not answer all of
//! them in order and in time, it is killed, and the requests without an answer are sent one by one, so that only a request that
//! fails alone is to blame. If none does, pipelining has failed, and all later requests are sent one by one.

use std::ffi::OsStr;
use std::fs;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::ffi::OsStrExt;
use std::path::PathBuf;
use std::process::Stdio;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock};
use std::time::{Duration, Instant};

use crate::runner::call::{Call, MAX_WAIT, POLL_INTERVAL};
use crate::runner::processes;
use crate::runner::run::{
    CallFailure, Decoder, INPUT_CHANGED_MESSAGE, STOPPED_MESSAGE, describe_exit,
};
use crate::runner::scratch::{Scratch, Workspace, is_unchanged};
use crate::runner::trouble::Trouble;
use ptm_suite::kit::escape_controls;
use ptm_suite::protocol::frame::{Answer, EXIT_MALFORMED, Frame, TimeLimit};
use ptm_suite::protocol::request::{AttemptKind, Reply, Request};

/// The reason why the serving process did not answer a request.
enum NotServed {
    /// The serving process violated the protocol in this way.
    Violation(Answer),
    /// The serving process exceeded this time limit. If `was_buffered`, it answered when its input was closed.
    TimedOut {
        limit: TimeLimit,
        was_buffered: bool,
    },
    /// This program could not do its part.
    Trouble,
}

impl From<Answer> for NotServed {
    fn from(answer: Answer) -> NotServed {
        NotServed::Violation(answer)
    }
}

impl From<Trouble> for NotServed {
    /// Discards the trouble. The request is repeated in one-shot mode, where persistent trouble stops the run.
    fn from(_: Trouble) -> NotServed {
        NotServed::Trouble
    }
}

impl From<std::io::Error> for NotServed {
    fn from(_: std::io::Error) -> NotServed {
        NotServed::Trouble
    }
}

/// Maximum length of the first line of an answer, in bytes.
const MAX_LINE_LENGTH: usize = 1000;
/// Maximum number of initial requests that serve mode fails to answer, although one-shot mode does, before it is disabled.
const MAX_UNANSWERED_REQUESTS: usize = 2;
/// Hint for a process that answers only at the end of its input.
const BUFFERED_HINT: &str =
    "; the answer came when standard input was closed, so flush standard output after each answer";
/// Time that a process has to end or to flush its output after its standard input is closed.
const GRACE_PERIOD: Duration = Duration::from_secs(2);

/// A failure to answer several requests that were sent at once, although each request without an answer was answered alone.
#[derive(Debug)]
pub struct PipeliningFailure {
    /// The reason, as a clause.
    pub reason: String,
    /// True if the process exceeded the time limit, which may be the fault of a busy machine.
    pub is_timeout: bool,
}

/// Serving processes of a run, one per job.
pub struct Servers<'a> {
    decoder: &'a Decoder,
    scratch: &'a Scratch,
    jobs: Vec<Mutex<Option<Server<'a>>>>,
    /// Number of answered requests, across all processes.
    answered_count: AtomicUsize,
    /// Number of requests that only one-shot mode answered, counted until the first answer in serve mode.
    unanswered_count: AtomicUsize,
    /// The reason why serve mode is disabled, if it is.
    failure: OnceLock<String>,
    /// The reason why requests are no longer pipelined, if they are not.
    pipelining_failure: OnceLock<PipeliningFailure>,
}

impl<'a> Servers<'a> {
    /// Creates the job slots. Each process is started when it is needed.
    #[must_use]
    pub fn new(decoder: &'a Decoder, scratch: &'a Scratch, jobs: usize) -> Servers<'a> {
        Servers {
            decoder,
            scratch,
            jobs: (0..jobs).map(|_| Mutex::default()).collect(),
            answered_count: AtomicUsize::new(0),
            unanswered_count: AtomicUsize::new(0),
            failure: OnceLock::new(),
            pipelining_failure: OnceLock::new(),
        }
    }

    /// Sends a request to the process of `job`, or to a new one that is not kept if it is sent alone. Uses one-shot mode for
    /// repetitions, and if serve mode is disabled.
    #[must_use]
    pub fn ask(&self, request: &Request, job: usize) -> Reply {
        if request.attempt == AttemptKind::Repetition || self.failure().is_some() {
            return self.decoder.ask(request, self.scratch);
        }
        let is_alone = request.attempt == AttemptKind::Alone;
        let mut place = self.jobs[job].lock().expect("no request panics");
        let started = match place.take_if(|_| !is_alone) {
            Some(server) => Ok(server),
            None => Server::start(self.decoder, self.scratch),
        };
        // If a server cannot be started, a one-shot process cannot be started either, and reports the reason.
        let Ok(mut server) = started else {
            return self.decoder.ask(request, self.scratch);
        };
        let previous_request = server.last_request.clone();
        let mut replies = Vec::new();
        let (served, reason) =
            match server.ask(std::slice::from_ref(request), self.decoder, &mut replies) {
                Ok(()) => {
                    self.answered_count.fetch_add(1, Ordering::Relaxed);
                    if !is_alone {
                        *place = Some(server);
                    }
                    return replies.remove(0);
                }
                Err(NotServed::Trouble) => {
                    drop(server);
                    return self.decoder.ask(request, self.scratch);
                }
                Err(NotServed::Violation(served)) => {
                    let reason = served.describe();
                    (served, reason)
                }
                Err(NotServed::TimedOut {
                    limit,
                    was_buffered,
                }) => {
                    let hint = if was_buffered { BUFFERED_HINT } else { "" };
                    (Answer::TimedOut(limit), format!("it {limit}{hint}"))
                }
            };
        drop(server);
        Reply {
            previous_request,
            ..self.reply_after_failure(request, served, reason)
        }
    }

    /// Sends several requests to the process of `job` at once. Returns the replies to the first of them, perhaps to none.
    ///
    /// If the process does not answer all of them, the others are sent one by one until one of them fails again.
    #[must_use]
    pub fn ask_pipelined(&self, requests: &[Request], job: usize) -> Vec<Reply> {
        let mut replies = Vec::new();
        if self.failure().is_some() || self.pipelining_failure().is_some() {
            return replies;
        }
        let mut place = self.jobs[job].lock().expect("no request panics");
        let started = match place.take() {
            Some(server) => Ok(server),
            None => Server::start(self.decoder, self.scratch),
        };
        let Ok(mut server) = started else {
            return replies;
        };
        let result = server.ask(requests, self.decoder, &mut replies);
        self.answered_count
            .fetch_add(replies.len(), Ordering::Relaxed);
        let (reason, is_timeout) = match result {
            Ok(()) => {
                *place = Some(server);
                return replies;
            }
            Err(NotServed::Trouble) => return replies,
            Err(NotServed::Violation(served)) => (served.describe(), false),
            Err(NotServed::TimedOut { limit, .. }) => (format!("it {limit}"), true),
        };
        drop(server);
        drop(place);
        let (sent, answered) = (requests.len(), replies.len());
        for request in &requests[replies.len()..] {
            if self.decoder.stop.load(Ordering::Relaxed) {
                return replies;
            }
            let reply = self.ask(request, job);
            let fails = reply.is_violation();
            replies.push(reply);
            if fails {
                return replies;
            }
        }
        let reason = format!(
            "it answered {answered} of {sent} requests that were sent at once, and failed at the next one ({reason})"
        );
        let _ = self
            .pipelining_failure
            .set(PipeliningFailure { reason, is_timeout });
        replies
    }

    /// Returns the reply to a request that serve mode failed to answer: `served`, for this `reason`, or the answer in one-shot mode.
    fn reply_after_failure(&self, request: &Request, served: Answer, reason: String) -> Reply {
        let has_answered = self.answered_count.load(Ordering::Relaxed) > 0;
        let timed_out = matches!(served, Answer::TimedOut(_));
        // A slow answer does not mean that serve mode fails, unless it never answered, even with a higher limit.
        let is_alone = request.attempt == AttemptKind::Alone;
        let is_undecided = timed_out && (!is_alone || has_answered);
        if is_undecided || self.decoder.stop.load(Ordering::Relaxed) {
            return served.into();
        }
        let one_shot = self.decoder.ask(request, self.scratch);
        // If the decoder also fails on this file in one-shot mode, serve mode is not the cause.
        let is_cause = one_shot.answer.violation().is_none();
        if is_cause && !has_answered {
            let before = self.unanswered_count.fetch_add(1, Ordering::Relaxed);
            if timed_out || before + 1 == MAX_UNANSWERED_REQUESTS {
                let _ = self.failure.set(reason);
            }
        }
        Reply {
            serve_mode_answer: (is_cause && !timed_out).then_some(served),
            ..one_shot
        }
    }

    /// Returns the reason why serve mode is disabled, if it never answered.
    #[must_use]
    pub fn failure(&self) -> Option<&str> {
        self.failure.get().map(String::as_str)
    }

    /// Returns the reason why requests are no longer pipelined, if they are not.
    #[must_use]
    pub fn pipelining_failure(&self) -> Option<&PipeliningFailure> {
        self.pipelining_failure.get()
    }
}

/// A serving process.
struct Server<'a> {
    call: Call,
    /// Standard input, or `None` after it is closed.
    stdin: Option<OwnedFd>,
    workspace: Workspace<'a>,
    /// File of the last request.
    input: Option<PathBuf>,
    /// Sequence number of the oldest unanswered request or, if there is none, of the last request.
    sequence: u64,
    /// Name of the last answered request.
    last_request: Option<String>,
    /// Time of the last memory measurement.
    last_measured: Instant,
}

impl<'a> Server<'a> {
    fn start(decoder: &Decoder, scratch: &'a Scratch) -> Result<Server<'a>, CallFailure> {
        let workspace = scratch.workspace()?;
        let words = decoder.command_with(&[OsStr::new("serve")]);
        let mut call = decoder.start_command(&words, &workspace.work_dir, Stdio::piped())?;
        let stdin = call.child.stdin.take().map(OwnedFd::from);
        if let Some(stdin) = &stdin {
            rustix::io::ioctl_fionbio(stdin, true)
                .map_err(|error| Trouble::new("monitor a process", &error.into()))?;
        }
        Ok(Server {
            call,
            stdin,
            workspace,
            input: None,
            sequence: 0,
            last_request: None,
            last_measured: Instant::now(),
        })
    }

    /// Sends all requests at once, and adds their replies in order. After an error, the process must not be used again.
    fn ask(
        &mut self,
        requests: &[Request],
        decoder: &Decoder,
        replies: &mut Vec<Reply>,
    ) -> Result<(), NotServed> {
        self.call.errors.clear();
        self.call.read_available(MAX_LINE_LENGTH)?;
        self.expect_silence("it wrote", "before the request")?;
        let (mut inputs, mut lines) = (Vec::new(), Vec::new());
        for (sequence, request) in (self.sequence + 1..).zip(requests) {
            let name = format!("{sequence}.ptm");
            let input = self.workspace.write_input(&name, request.file)?;
            lines.extend_from_slice(format!("{sequence} {} ", request.view).as_bytes());
            lines.extend_from_slice(input.as_os_str().as_bytes());
            lines.push(b'\n');
            inputs.push(input);
        }
        let mut unsent = &lines[..];
        for (i, (request, input)) in requests.iter().zip(inputs).enumerate() {
            self.sequence += 1;
            let outcome = self.exchange(&mut unsent, request, decoder);
            let untouched = is_unchanged(&input, request.file);
            // The decoder may answer before it has read the file. The last file is removed with its directory.
            if let Some(last) = self.input.replace(input) {
                let _ = fs::remove_file(last);
            }
            let answer = outcome?;
            if !untouched? {
                return Err(Answer::Tampered(INPUT_CHANGED_MESSAGE.to_owned()).into());
            }
            if i + 1 == requests.len() {
                self.expect_silence("the answer is followed by", "")?;
            }
            replies.push(Reply {
                previous_request: self.last_request.replace(request.name.to_owned()),
                ..answer.into()
            });
        }
        // Of several requests, it is not known which one caused a message.
        if let ([_], [reply]) = (requests, &mut replies[..]) {
            let stderr = escape_controls(String::from_utf8_lossy(&self.call.errors).trim_end());
            reply.stderr = self.workspace.strip_directories(&stderr);
        }
        Ok(())
    }

    /// Returns an error if the process wrote anything that is not an answer.
    fn expect_silence(&self, before: &str, after: &str) -> Result<(), Answer> {
        if self.call.output.is_empty() {
            Ok(())
        } else {
            let says = format!("{before} {} {after}", quote_start(&self.call.output));
            Err(Answer::ProtocolError(says.trim_end().to_owned()))
        }
    }

    /// Waits for the answer to the oldest unanswered request, and sends the `unsent` lines meanwhile.
    fn exchange(
        &mut self,
        unsent: &mut &[u8],
        request: &Request,
        decoder: &Decoder,
    ) -> Result<Answer, NotServed> {
        let max_bytes = request.max_answer_bytes();
        let limit = request.attempt.time_limit(decoder.timeout);
        let deadline = Instant::now() + limit.0.min(MAX_WAIT);
        loop {
            self.send_requests(unsent)?;
            if let Some(answer) = self.take_answer(max_bytes, decoder)? {
                return Ok(answer);
            }
            if self.call.has_ended() {
                // The process may have written its final output in the meantime.
                return match self.read_answer(max_bytes, decoder)? {
                    Some(answer) => Ok(answer),
                    None => Err(self.exit_answer().into()),
                };
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                let is_alone = request.attempt == AttemptKind::Alone;
                return Err(NotServed::TimedOut {
                    limit,
                    was_buffered: is_alone && self.answers_at_end_of_input(max_bytes, decoder),
                });
            }
            if decoder.stop.load(Ordering::Relaxed) {
                return Err(Answer::NotAsked(STOPPED_MESSAGE.to_owned()).into());
            }
            self.check_memory(decoder)?;
            let writing = self.stdin.as_ref().filter(|_| !unsent.is_empty());
            self.call
                .wait_for_event(writing.map(AsFd::as_fd), left.min(POLL_INTERVAL))?;
            self.call.read_available(max_bytes + MAX_LINE_LENGTH)?;
        }
    }

    /// Sends as much as possible without blocking. The time limit also applies to a process that does not read its input.
    fn send_requests(&self, unsent: &mut &[u8]) -> std::io::Result<()> {
        while let (false, Some(stdin)) = (unsent.is_empty(), &self.stdin) {
            match rustix::io::write(stdin, unsent) {
                Ok(count) => *unsent = &unsent[count..],
                Err(rustix::io::Errno::INTR) => {}
                Err(rustix::io::Errno::AGAIN) => break,
                Err(rustix::io::Errno::PIPE) => *unsent = &[],
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }

    fn read_answer(
        &mut self,
        max_bytes: usize,
        decoder: &Decoder,
    ) -> Result<Option<Answer>, NotServed> {
        self.call.read_available(max_bytes + MAX_LINE_LENGTH)?;
        Ok(self.take_answer(max_bytes, decoder)?)
    }

    /// Consumes the answer from the output if it is complete.
    fn take_answer(&mut self, limit: usize, decoder: &Decoder) -> Result<Option<Answer>, Answer> {
        let read = parse_answer(&self.call.output, self.sequence, limit, decoder.reject_exit);
        let taken = read.map_err(Answer::ProtocolError)?;
        Ok(taken.map(|(answer, length)| {
            self.call.output.drain(..length);
            answer
        }))
    }

    /// Returns an error if the process uses too much memory, which is measured at intervals.
    fn check_memory(&mut self, decoder: &Decoder) -> Result<(), Answer> {
        if self.last_measured.elapsed() < POLL_INTERVAL || !processes::can_inspect_processes() {
            return Ok(());
        }
        self.last_measured = Instant::now();
        if processes::memory_of_call(self.call.group, &self.workspace.work_dir) > decoder.memory {
            return Err(decoder.out_of_memory_answer());
        }
        Ok(())
    }

    /// Returns the answer for a process that ended before it answered.
    fn exit_answer(&mut self) -> Answer {
        let answered = self.sequence - 1;
        let status = self
            .call
            .kill_and_reap(&self.workspace.work_dir)
            .map(describe_exit);
        Answer::Crashed(format!(
            "the serving process ended ({}) without an answer; it had answered {answered} requests",
            status.unwrap_or_else(|error| error.to_string())
        ))
    }

    /// Closes the input of the process. Returns true if the process answers then, so it was buffering its output.
    fn answers_at_end_of_input(&mut self, max_bytes: usize, decoder: &Decoder) -> bool {
        drop(self.stdin.take());
        let deadline = Instant::now() + GRACE_PERIOD;
        while Instant::now() < deadline {
            let ended = self.call.has_ended();
            if matches!(self.read_answer(max_bytes, decoder), Ok(Some(_))) {
                return true;
            }
            if ended || self.call.wait_for_event(None, POLL_INTERVAL).is_err() {
                break;
            }
        }
        false
    }
}

impl Drop for Server<'_> {
    fn drop(&mut self) {
        // A server should exit at the end of its input. Kill it if it does not.
        drop(self.stdin.take());
        let deadline = Instant::now() + GRACE_PERIOD / 4;
        while !self.call.has_ended() && Instant::now() < deadline {
            let _ = self.call.wait_for_event(None, POLL_INTERVAL);
            let _ = self.call.read_available(MAX_LINE_LENGTH);
            if self.call.output.len() > MAX_LINE_LENGTH {
                break;
            }
        }
        let _ = self.call.kill_and_reap(&self.workspace.work_dir);
    }
}

/// Parses the answer to request `sequence` at the start of `bytes`. Returns the answer and its length, or `None` while it is
/// incomplete. An error describes a malformed answer.
fn parse_answer(
    bytes: &[u8],
    sequence: u64,
    max_bytes: usize,
    reject_exit: Option<i32>,
) -> Result<Option<(Answer, usize)>, String> {
    let mut beginning = bytes.iter().take(MAX_LINE_LENGTH);
    let Some(end) = beginning.position(|&byte| byte == b'\n') else {
        return match bytes.len() >= MAX_LINE_LENGTH {
            true => Err(format!(
                "the answer begins with {} and is not terminated by a line feed",
                quote_start(bytes)
            )),
            false => Ok(None),
        };
    };
    let line = &bytes[..end];
    let mut words = line.splitn(3, |&byte| byte == b' ');
    let number = words.next().and_then(parse_digits);
    let number = number.ok_or_else(|| unexpected_line_message(line, sequence))?;
    if number != sequence {
        return Err(format!(
            "the answer to request {sequence} has the number {number}: {}",
            quote_start(line)
        ));
    }
    let (kind, rest) = (words.next(), words.next().unwrap_or_default());
    match kind {
        Some(b"ok") => {
            let length =
                parse_digits(rest).ok_or_else(|| unexpected_line_message(line, sequence))?;
            read_frame(&bytes[end + 1..], length, max_bytes)
                .map(|frame| frame.map(|frame| (frame, end + 1 + length as usize)))
        }
        Some(b"reject") => match parse_digits(rest).and_then(|code| i32::try_from(code).ok()) {
            Some(code) if code == EXIT_MALFORMED || Some(code) == reject_exit => {
                Ok(Some((Answer::Rejected, end + 1)))
            }
            _ => Err(format!(
                "expected the refusal code {EXIT_MALFORMED}, found {}",
                quote_start(line)
            )),
        },
        Some(b"unsupported") => Ok(Some((Answer::Unsupported, end + 1))),
        _ => Err(unexpected_line_message(line, sequence)),
    }
}

/// Parses a frame of `length` bytes at the start of `bytes`. Returns `None` while it is incomplete.
fn read_frame(bytes: &[u8], length: u64, max_bytes: usize) -> Result<Option<Answer>, String> {
    if length > max_bytes as u64 {
        return Err(format!(
            "the answer announces {length} bytes, but no frame of the PTM file has more than {max_bytes}"
        ));
    }
    let Some(frame) = bytes.get(..length as usize) else {
        return Ok(None);
    };
    let frame = Frame::read(frame).map_err(|error| {
        format!(
            "the answer announces {length} bytes, including the first line of the frame: {error}"
        )
    })?;
    Ok(Some(Answer::Decoded(frame)))
}

/// Returns the message for a line that is not an answer.
fn unexpected_line_message(line: &[u8], sequence: u64) -> String {
    let hint = match line {
        [.., b'\r'] => "; is standard output in text mode?",
        [b'P', b'T', b'M', b'1', ..] => "; write a separate answer line before the frame",
        _ => "",
    };
    format!(
        "expected \"{sequence} ok NBYTES\", \"{sequence} reject CODE\" or \"{sequence} unsupported FEATURE\", found {}{hint}",
        quote_start(line)
    )
}

fn parse_digits(word: &[u8]) -> Option<u64> {
    let number = std::str::from_utf8(word).ok()?;
    let plain = number.bytes().all(|byte| byte.is_ascii_digit());
    number.parse().ok().filter(|_| plain)
}

/// Quotes the start of `bytes` for a message.
fn quote_start(bytes: &[u8]) -> String {
    let shown = &bytes[..bytes.len().min(40)];
    let more = if bytes.len() > shown.len() { "…" } else { "" };
    format!("\"{}{more}\"", shown.escape_ascii())
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: &[u8] = b"PTM1 raw 1 1 1 u8\nx";

    #[test]
    fn incomplete_answers_are_awaited() {
        let whole = [&b"7 ok 19\n"[..], FRAME, b"8 ok"].concat();
        for length in 0..8 + FRAME.len() {
            let part = parse_answer(&whole[..length], 7, 1000, None);
            assert_eq!(part, Ok(None), "{length}");
        }
        let taken = parse_answer(&whole, 7, 1000, None).expect("a complete answer");
        assert!(matches!(taken, Some((Answer::Decoded(_), 27))), "{taken:?}");
    }

    #[test]
    fn refusals_need_a_code_or_a_feature() {
        for (line, reject_exit, answer) in [
            ("7 reject 65\n", None, Answer::Rejected),
            ("7 reject 1\n", Some(1), Answer::Rejected),
            ("7 unsupported a b\n", None, Answer::Unsupported),
            ("7 unsupported\n", None, Answer::Unsupported),
        ] {
            let read = parse_answer(line.as_bytes(), 7, 1000, reject_exit);
            assert_eq!(read, Ok(Some((answer, line.len()))), "{line}");
        }
    }

    #[test]
    fn unterminated_line_is_not_an_answer() {
        let error = parse_answer(&[b'x'; 2000], 7, 1000, None).expect_err("not an answer");
        assert!(error.contains("not terminated by a line feed"), "{error}");
    }
}
