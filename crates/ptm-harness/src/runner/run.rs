//! Starts a decoder, enforces its limits, and returns the result.
//!
//! Every call has its own process group, which is killed when the call ends. It has a wall-clock limit, a limit on standard
//! output, an empty standard input, a private working directory, and the caller's environment with `LC_ALL`, `TZ` and `TMPDIR`
//! set. Standard error is recorded and never affects a verdict.
//!
//! If this program cannot do its part of a call (write the input, start a process), the decoder is not to blame, and
//! the call is repeated. If the problem persists, the run stops, and [`Decoder::trouble`] returns the reason.

use std::ffi::{OsStr, OsString};
use std::fmt;
use std::io;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use crate::runner::call::{Call, CallEnd, CallLimits, CallOutput};
use crate::runner::processes;
use crate::runner::scratch::{Scratch, is_unchanged};
use crate::runner::start;
use crate::runner::template::{Template, make_absolute};
use crate::runner::trouble::{Trouble, is_shortage};
use ptm_suite::kit::escape_controls;
use ptm_suite::protocol::capabilities::Capabilities;
use ptm_suite::protocol::forms;
use ptm_suite::protocol::frame::{Answer, EXIT_MALFORMED, EXIT_UNSUPPORTED, ProcessEnd, TimeLimit};
use ptm_suite::protocol::request::{AttemptKind, Reply, Request};
use rustix::process::Signal;

/// Maximum time for repeating a call that fails because of a problem in this program. After that, the run stops.
const MAX_RETRY_TIME: Duration = Duration::from_secs(5);

/// Maximum number of bytes in a list of capabilities.
const MAX_CAPABILITIES_BYTES: usize = 16 * 1024;

/// A decoder and the limits that apply to each call.
#[derive(Clone, Debug)]
pub struct Decoder {
    command: Vec<OsString>,
    /// Template of the command line, if it is not `command… VIEW FILE`.
    pub(crate) template: Option<Template>,
    /// Wall-clock limit for a call.
    pub timeout: Duration,
    /// Memory limit in bytes, summed over all processes of a call.
    pub memory: u64,
    /// Flag that stops the run. It is set when the user stops the run or when trouble persists.
    pub stop: Arc<AtomicBool>,
    /// An exit status other than 65 that also means a refusal.
    pub reject_exit: Option<i32>,
    /// An exit status other than 0 that also means success.
    pub success_exit: Option<i32>,
    /// Locale of the decoder, `C` by default.
    pub locale: String,
    trouble: Arc<OnceLock<String>>,
}

/// Result of a call.
#[derive(Clone, Debug)]
pub struct CallResult {
    /// The output if the exit status means success, or else the failure.
    pub output: Result<Vec<u8>, Answer>,
    /// Start of standard error.
    pub stderr: String,
    /// Exit status, if the process exited.
    pub exit: Option<i32>,
    /// Standard output, if the decoder writes its output to a file.
    pub stdout: Vec<u8>,
}

impl CallResult {
    /// Converts the result to a reply by parsing the output with `read`.
    pub(crate) fn into_reply<T>(
        self,
        read: impl FnOnce(&[u8]) -> std::result::Result<T, String>,
    ) -> Reply<T> {
        let (answer, stdout) = match self.output {
            Ok(bytes) => {
                let read = read(&bytes);
                (
                    read.map_or_else(Answer::ProtocolError, Answer::Decoded),
                    bytes,
                )
            }
            Err(answer) => {
                let failure = "a failure has no decoded output";
                (answer.decoded().expect_err(failure), self.stdout)
            }
        };
        Reply {
            stderr: self.stderr,
            exit: self.exit,
            stdout,
            ..answer.into()
        }
    }
}

impl From<Answer> for CallResult {
    /// Creates a result without output.
    fn from(answer: Answer) -> CallResult {
        CallResult {
            output: Err(answer),
            stderr: String::new(),
            exit: None,
            stdout: Vec::new(),
        }
    }
}

/// The reason why a call has no result.
pub(crate) enum CallFailure {
    /// The program cannot be started, for this reason.
    NotStarted(String),
    /// This program could not do its part of the call.
    Trouble(Trouble),
}

impl From<Trouble> for CallFailure {
    fn from(trouble: Trouble) -> CallFailure {
        CallFailure::Trouble(trouble)
    }
}

impl Decoder {
    /// Creates a decoder with default limits and the command line `program args… VIEW FILE`. Words that name existing
    /// files become absolute paths, because each call runs in a separate directory.
    ///
    /// # Errors
    /// Returns an error if the working directory is unknown.
    pub fn new(command: &[OsString]) -> io::Result<Decoder> {
        let command = command
            .iter()
            .enumerate()
            .map(|(i, word)| make_absolute(word, i == 0).map_err(io::Error::other))
            .collect::<io::Result<_>>()?;
        Ok(Decoder {
            command,
            template: None,
            timeout: Duration::from_secs(10),
            memory: 2 << 30,
            stop: Arc::default(),
            reject_exit: None,
            success_exit: None,
            locale: "C".to_owned(),
            trouble: Arc::default(),
        })
    }

    /// Creates a decoder with default limits and a template as its command line.
    ///
    /// # Errors
    /// Returns an error if the working directory is unknown.
    pub fn with_template(template: Template) -> io::Result<Decoder> {
        Ok(Decoder {
            template: Some(template),
            ..Decoder::new(&[])?
        })
    }

    /// Returns a decoder with the same limits and a different command line.
    pub(crate) fn with_command_line(&self, template: Template) -> Decoder {
        Decoder {
            template: Some(template),
            ..self.clone()
        }
    }

    /// Returns the command, with absolute paths.
    pub(crate) fn command(&self) -> &[OsString] {
        &self.command
    }

    /// Returns the problem in this program that stopped the run, if any. In that case, the results say nothing about the decoder.
    #[must_use]
    pub fn trouble(&self) -> Option<&str> {
        self.trouble.get().map(String::as_str)
    }

    /// Sends one request. `scratch` provides the directories for the file and the decoder.
    #[must_use]
    pub fn ask(&self, request: &Request, scratch: &Scratch) -> Reply {
        let max_bytes = request.max_answer_bytes();
        let result = self.invoke(request, "case.ptm", max_bytes, scratch);
        result.into_reply(|bytes| Ok(forms::read(bytes, request.view, max_bytes)?))
    }

    /// Runs the decoder in a new process. The input file is called `file_name`, and the output is limited to `max_bytes` bytes.
    pub(crate) fn invoke<V: fmt::Display>(
        &self,
        request: &Request<V>,
        file_name: &str,
        max_bytes: usize,
        scratch: &Scratch,
    ) -> CallResult {
        self.retry(|| self.attempt(request, file_name, max_bytes, scratch))
    }

    /// Repeats a call that failed because of a problem in this program or its environment. Stops the run if the problem persists.
    pub(crate) fn retry(&self, call: impl Fn() -> Result<CallResult, CallFailure>) -> CallResult {
        let begin = Instant::now();
        let mut pause = Duration::from_millis(5);
        loop {
            let trouble = match call() {
                Ok(result) => return result,
                Err(CallFailure::NotStarted(why)) => return Answer::NotStarted(why).into(),
                Err(CallFailure::Trouble(trouble)) => trouble.into_text(),
            };
            if begin.elapsed() > MAX_RETRY_TIME {
                let _ = self.trouble.set(trouble.clone());
                self.stop.store(true, Ordering::Relaxed);
            }
            if self.stop.load(Ordering::Relaxed) {
                return Answer::NotAsked(trouble).into();
            }
            std::thread::sleep(pause);
            pause = (2 * pause).min(Duration::from_millis(320));
        }
    }

    fn attempt<V: fmt::Display>(
        &self,
        request: &Request<V>,
        file_name: &str,
        max_bytes: usize,
        scratch: &Scratch,
    ) -> Result<CallResult, CallFailure> {
        let mut workspace = scratch.workspace()?;
        // The name of the file must not reveal the expected result.
        let input = workspace.write_input(file_name, request.file)?;
        let work_dir = &workspace.work_dir;
        let output_file = match &self.template {
            Some(template) => template.output_file(work_dir)?,
            None => None,
        };
        let view = request.view.to_string();
        let words = match &self.template {
            Some(template) => template.command_words(&view, &input, work_dir),
            None => self.command_with(&[OsStr::new(&view), input.as_os_str()]),
        };
        let time = request.attempt.time_limit(self.timeout);
        let mut result = self.run_command(&words, max_bytes, time, work_dir)?;
        if let (Ok(stdout), Some(file)) = (&mut result.output, &output_file) {
            result.stdout = std::mem::take(stdout);
            result.output = file.read(max_bytes, result.exit)?;
        }
        result.stderr = workspace.strip_directories(&result.stderr);
        if !is_unchanged(&input, request.file)? {
            result.output = Err(Answer::Tampered(INPUT_CHANGED_MESSAGE.to_owned()));
        }
        Ok(result)
    }

    /// Returns the command, followed by additional arguments.
    pub(crate) fn command_with(&self, words: &[&OsStr]) -> Vec<OsString> {
        let more = words.iter().map(|&word| word.to_owned());
        self.command.iter().cloned().chain(more).collect()
    }

    /// Runs a command line until it ends or reaches a limit.
    pub(crate) fn run_command(
        &self,
        words: &[OsString],
        max_bytes: usize,
        time: TimeLimit,
        work_dir: &Path,
    ) -> Result<CallResult, CallFailure> {
        let call = self.start_command(words, work_dir, Stdio::null())?;
        let limits = CallLimits {
            output: max_bytes,
            time,
            memory: self.memory,
            stop: &self.stop,
        };
        let output = call.finish(&limits, work_dir);
        let output = output.map_err(|error| Trouble::new("monitor a call", &error))?;
        Ok(self.call_result(output, &limits)?)
    }

    /// Starts a process with a command line.
    pub(crate) fn start_command(
        &self,
        words: &[OsString],
        work_dir: &Path,
        stdin: Stdio,
    ) -> Result<Call, CallFailure> {
        let mut command = Command::new(&words[0]);
        command
            .args(&words[1..])
            .current_dir(work_dir)
            .env("LC_ALL", &self.locale)
            .env("TZ", "UTC")
            .env("TMPDIR", work_dir)
            .stdin(stdin)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .process_group(0);
        let child = processes::start(&mut command).map_err(|error| {
            // Another decoder may have removed the directory.
            if is_shortage(&error) || !work_dir.is_dir() {
                Trouble::new("start a process", &error).into()
            } else {
                CallFailure::NotStarted(start::describe_start_failure(&words[0], &error))
            }
        })?;
        Ok(Call::new(child).map_err(|error| Trouble::new("monitor a call", &error))?)
    }

    /// Queries the capabilities of the decoder with `DECODER capabilities`. An error is not a failure of the decoder, because
    /// the command is optional.
    ///
    /// # Errors
    /// Returns a message that describes the response if it is not a list of capabilities.
    pub fn capabilities(&self, scratch: &Scratch) -> Result<Capabilities, String> {
        if self.template.is_some() {
            return Err(
                "the command line has no placeholder for the argument capabilities".to_owned(),
            );
        }
        let result = self.retry(|| {
            let workspace = scratch.workspace()?;
            let words = self.command_with(&[OsStr::new("capabilities")]);
            let max_bytes = MAX_CAPABILITIES_BYTES;
            // This is the first call of a run, and the decoder may have to warm up.
            let time = AttemptKind::Alone.time_limit(self.timeout);
            self.run_command(&words, max_bytes, time, &workspace.work_dir)
        });
        Ok(Capabilities::read(
            &result.output.map_err(|answer| answer.describe())?,
        )?)
    }

    pub(crate) fn out_of_memory_answer(&self) -> Answer {
        Answer::OutOfMemory(format!(
            "the processes of the program used more than {} MiB",
            self.memory >> 20
        ))
    }

    /// Converts the output of a call to a `CallResult`.
    fn call_result(&self, result: CallOutput, limits: &CallLimits) -> Result<CallResult, Trouble> {
        let mut exit = None;
        let output = match result.ended {
            CallEnd::OutOfMemory => Err(self.out_of_memory_answer()),
            CallEnd::Stopped => Err(Answer::NotAsked(STOPPED_MESSAGE.to_owned())),
            CallEnd::Flood => Err(Answer::Flooded(format!(
                "more than {} bytes on standard output",
                limits.output
            ))),
            CallEnd::OutOfTime => Err(Answer::TimedOut(limits.time)),
            CallEnd::Exited(status) => {
                exit = status.code();
                match self.failure_answer(status)? {
                    None => Ok(result.stdout),
                    Some(answer) => Err(answer),
                }
            }
        };
        Ok(CallResult {
            output,
            stderr: escape_controls(String::from_utf8_lossy(&result.stderr).trim_end()),
            exit,
            stdout: Vec::new(),
        })
    }

    /// Returns the answer that an exit status represents, or `None` for success.
    fn failure_answer(&self, status: ExitStatus) -> Result<Option<Answer>, Trouble> {
        let too_large = status.signal() == Some(Signal::XFSZ.as_raw());
        if too_large && processes::is_file_size_limited_by_environment() {
            let error = rustix::io::Errno::FBIG.into();
            return Err(Trouble::new("let the decoder write a file", &error));
        }
        Ok(match status.code() {
            Some(0) => None,
            Some(code) if Some(code) == self.success_exit => None,
            Some(EXIT_UNSUPPORTED) => Some(Answer::Unsupported),
            Some(EXIT_MALFORMED) => Some(Answer::Rejected),
            Some(code) if Some(code) == self.reject_exit => Some(Answer::Rejected),
            _ => Some(Answer::Crashed(describe_exit(status))),
        })
    }
}

/// Message for a decoder that changed or removed its input.
pub(crate) const INPUT_CHANGED_MESSAGE: &str = "the input file was changed or removed";

/// Message for a call that the user interrupted.
pub(crate) const STOPPED_MESSAGE: &str = "the user ended the run";

/// Describes how a process ended.
pub(crate) fn describe_exit(status: ExitStatus) -> String {
    let signal = status.signal().map(ProcessEnd::Signal);
    let end = signal.unwrap_or(ProcessEnd::Status(status.code().unwrap_or(-1)));
    end.to_string()
}
