//! Starts a decoder, limits it, and returns what it did.
//!
//! Every call has its own process group, which is killed as a whole when the call is over; a wall-clock limit; a limit on
//! standard output; an empty standard input; its own working directory; and the caller's environment with `LC_ALL`, `TZ` and
//! `TMPDIR` set. Standard error is read and never changes a verdict.
//!
//! If this program cannot do its part of a call (write the input, start a process), that is not an answer of the decoder: the
//! call is repeated. If the trouble persists, the run is stopped and [`Decoder::trouble`] says why.

use std::ffi::{OsStr, OsString};
use std::io;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use rustix::process::Signal;

use crate::protocol::forms;
use crate::protocol::frame::{Answer, EXIT_MALFORMED, EXIT_UNSUPPORTED, Frame, View};
use crate::runner::call::{Call, CallLimits, Ended, Remains};
use crate::runner::processes;
use crate::runner::scratch::{Scratch, is_untouched};
use crate::runner::start;
use crate::runner::template::{Template, absolute};
use crate::runner::trouble::{Trouble, is_shortage};

/// Maximum time that calls are repeated because of trouble in this program, before the run is stopped.
const MAX_TROUBLE_TIME: Duration = Duration::from_secs(5);

/// A decoder and the limits it runs under.
#[derive(Clone, Debug)]
pub struct Decoder {
    command: Vec<OsString>,
    /// The template of a call, if it is not `command… VIEW FILE`.
    pub(crate) template: Option<Template>,
    /// Wall-clock limit of one call.
    pub timeout: Duration,
    /// Bytes of memory that all processes of a call may hold together.
    pub memory: u64,
    /// Set to end the run: by the user, or because of trouble.
    pub stop: Arc<AtomicBool>,
    /// An exit status that means a refusal, in addition to 65.
    pub reject_exit: Option<i32>,
    /// The locale of the decoder: `C` by default.
    pub locale: String,
    trouble: Arc<OnceLock<String>>,
}

/// One request.
#[derive(Clone, Debug)]
pub struct Request<'a, V = View> {
    /// A name for the file, without its suffix.
    pub name: &'a str,
    /// The requested view.
    pub view: &'a V,
    /// The file.
    pub file: &'a [u8],
    /// Maximum size of a frame of that file, in bytes.
    pub largest_frame: usize,
    /// Factor for the timeout: the first call may have to warm up.
    pub timeout_factor: u32,
    /// True if a new process is to answer, even in serve mode.
    pub alone: bool,
}

impl<V> Request<'_, V> {
    /// Returns the maximum number of bytes that are read of an answer.
    pub(crate) fn most(&self) -> usize {
        4 * self.largest_frame + 65_536
    }
}

/// The response to a request.
#[derive(Clone, Debug)]
pub struct Reply<T = Frame> {
    /// The answer of the decoder.
    pub answer: Answer<T>,
    /// The beginning of its standard error.
    pub stderr: String,
    /// Its exit status, if it had one.
    pub exit: Option<i32>,
    /// The name of the request that the same process answered before.
    pub after: Option<String>,
    /// Answer of a serving process that failed; `answer` is then that of a process started for this request.
    pub served: Option<Answer<T>>,
    /// Its standard output, as far as it was read.
    pub stdout: Vec<u8>,
}

impl<T> From<Answer<T>> for Reply<T> {
    /// Makes a reply with nothing but an answer.
    fn from(answer: Answer<T>) -> Reply<T> {
        Reply {
            answer,
            stderr: String::new(),
            exit: None,
            after: None,
            served: None,
            stdout: Vec::new(),
        }
    }
}

impl<T> Reply<T> {
    /// Returns true if it refuses by an exit status that also has another meaning.
    #[must_use]
    pub fn is_weak(&self) -> bool {
        matches!(self.answer, Answer::Rejected)
            && self.exit.is_some_and(|exit| exit != EXIT_MALFORMED)
    }
}

/// One start of a decoder, for any purpose.
#[derive(Clone, Debug)]
pub struct Invocation<'a> {
    /// The word before the file.
    pub view: &'a str,
    /// The name of the file.
    pub file_name: &'a str,
    /// The file.
    pub file: &'a [u8],
    /// Maximum number of bytes of an answer.
    pub most: usize,
    /// Factor for the timeout.
    pub timeout_factor: u32,
}

/// The result of an invocation.
#[derive(Clone, Debug)]
pub struct CallResult {
    /// Its answer, if the exit status is 0; else what it did instead.
    pub output: Result<Vec<u8>, Answer>,
    /// The beginning of its standard error.
    pub stderr: String,
    /// Its exit status, if it had one.
    pub exit: Option<i32>,
    /// Its standard output, if that is not the answer.
    pub stdout: Vec<u8>,
}

impl CallResult {
    /// Returns the reply, with `read` applied to the output.
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
                let decoded = "what was decoded is the output";
                (answer.decoded().expect_err(decoded), self.stdout)
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
    /// Makes a result without any output.
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
pub(crate) enum Failure {
    /// The program cannot be started, with the reason.
    NotStarted(String),
    /// This program could not do its part.
    Trouble(Trouble),
}

impl From<Trouble> for Failure {
    fn from(trouble: Trouble) -> Failure {
        Failure::Trouble(trouble)
    }
}

impl Decoder {
    /// Makes a decoder with the default limits, started as `program args… VIEW FILE`. Words that name existing files are made
    /// absolute, because calls run in their own directories.
    ///
    /// # Errors
    /// If the working directory is not known.
    pub fn new(command: &[OsString]) -> io::Result<Decoder> {
        let command = command
            .iter()
            .enumerate()
            .map(|(i, word)| absolute(word, i == 0).map_err(io::Error::other))
            .collect::<io::Result<_>>()?;
        Ok(Decoder {
            command,
            template: None,
            timeout: Duration::from_secs(10),
            memory: 2 << 30,
            stop: Arc::default(),
            reject_exit: None,
            locale: "C".to_owned(),
            trouble: Arc::default(),
        })
    }

    /// Makes a decoder with the default limits that is called by `template`.
    ///
    /// # Errors
    /// If the working directory is not known.
    pub fn with_template(template: Template) -> io::Result<Decoder> {
        Ok(Decoder {
            template: Some(template),
            ..Decoder::new(&[])?
        })
    }

    /// Returns the same decoder with the same limits, called by a template.
    #[must_use]
    pub(crate) fn program_from_template(&self, template: Template) -> Decoder {
        Decoder {
            template: Some(template),
            ..self.clone()
        }
    }

    /// Returns its command, with absolute paths.
    pub(crate) fn command(&self) -> &[OsString] {
        &self.command
    }

    /// Returns why this program could not do its part and stopped the run, which then says nothing about the decoder.
    #[must_use]
    pub fn trouble(&self) -> Option<&str> {
        self.trouble.get().map(String::as_str)
    }

    /// Asks once. `scratch` provides the directories for the file and the decoder.
    #[must_use]
    pub fn ask(&self, request: &Request, scratch: &Scratch) -> Reply {
        let most = request.most();
        let result = self.invoke(
            &Invocation {
                view: &request.view.to_string(),
                file_name: "case.ptm",
                file: request.file,
                most,
                timeout_factor: request.timeout_factor,
            },
            scratch,
        );
        result.into_reply(|bytes| forms::read(bytes, request.view, most))
    }

    /// Starts the decoder once and returns what it did.
    #[must_use]
    pub fn invoke(&self, invocation: &Invocation, scratch: &Scratch) -> CallResult {
        self.retry(|| self.attempt(invocation, scratch))
    }

    /// Repeats a call while this program cannot do its part; stops the run if that persists.
    pub(crate) fn retry(&self, attempt: impl Fn() -> Result<CallResult, Failure>) -> CallResult {
        let begin = Instant::now();
        let mut pause = Duration::from_millis(5);
        loop {
            let trouble = match attempt() {
                Ok(result) => return result,
                Err(Failure::NotStarted(why)) => return Answer::NotStarted(why).into(),
                Err(Failure::Trouble(trouble)) => trouble.into_text(),
            };
            if begin.elapsed() > MAX_TROUBLE_TIME {
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

    fn attempt(&self, invocation: &Invocation, scratch: &Scratch) -> Result<CallResult, Failure> {
        let mut workspace = scratch.workspace()?;
        // The name of the file does not reveal what is expected.
        let input = workspace.lay_down(invocation.file_name, invocation.file)?;
        let workplace = &workspace.workplace;
        let output_file = match &self.template {
            Some(template) => template.output_file(workplace)?,
            None => None,
        };
        let words = self.words(invocation.view, &input, workplace);
        let time = self.timeout.saturating_mul(invocation.timeout_factor);
        let mut result = self.call(&words, invocation.most, time, workplace)?;
        if let (Ok(stdout), Some(file)) = (&mut result.output, &output_file) {
            result.stdout = std::mem::take(stdout);
            result.output = file.read(invocation.most)?;
        }
        result.stderr = workspace.without_directories(&result.stderr);
        if !is_untouched(&input, invocation.file)? {
            result.output = Err(Answer::Tampered(INPUT_CHANGED_MESSAGE.to_owned()));
        }
        Ok(result)
    }

    /// Returns the words of a call, including the program.
    fn words(&self, view: &str, input: &Path, workplace: &Path) -> Vec<OsString> {
        match &self.template {
            Some(template) => template.words(view, input, workplace),
            None => self.followed_by(&[OsStr::new(view), input.as_os_str()]),
        }
    }

    /// Returns its command, followed by more words.
    pub(crate) fn followed_by(&self, words: &[&OsStr]) -> Vec<OsString> {
        let more = words.iter().map(|&word| word.to_owned());
        self.command.iter().cloned().chain(more).collect()
    }

    /// Runs a process with these words to its end.
    pub(crate) fn call(
        &self,
        words: &[OsString],
        most: usize,
        time: Duration,
        workplace: &Path,
    ) -> Result<CallResult, Failure> {
        let call = self.start(words, workplace, Stdio::null())?;
        let limits = CallLimits {
            output: most,
            time,
            memory: self.memory,
            stop: &self.stop,
        };
        let remains = call.finish(&limits, workplace);
        let remains = remains.map_err(|error| Trouble::new("follow a call", &error))?;
        Ok(self.result(remains, &limits)?)
    }

    /// Starts a process with these words.
    pub(crate) fn start(
        &self,
        words: &[OsString],
        workplace: &Path,
        stdin: Stdio,
    ) -> Result<Call, Failure> {
        let mut command = Command::new(&words[0]);
        command
            .args(&words[1..])
            .current_dir(workplace)
            .env("LC_ALL", &self.locale)
            .env("TZ", "UTC")
            .env("TMPDIR", workplace)
            .stdin(stdin)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .process_group(0);
        let child = processes::start(&mut command).map_err(|error| {
            // Another decoder may have removed the directory.
            if is_shortage(&error) || !workplace.is_dir() {
                Trouble::new("start a process", &error).into()
            } else {
                Failure::NotStarted(start::start_failure(&words[0], &error))
            }
        })?;
        Ok(Call::new(child).map_err(|error| Trouble::new("follow a call", &error))?)
    }

    /// Calls it with one word that is not a view, and returns what it prints, at most `most` bytes.
    ///
    /// # Errors
    /// A sentence that says what it did instead of printing and exiting with 0.
    pub(crate) fn print_out(
        &self,
        word: &str,
        most: usize,
        scratch: &Scratch,
    ) -> Result<Vec<u8>, String> {
        if self.template.is_some() {
            return Err("its command line has no placeholder for such a word".to_owned());
        }
        let result = self.retry(|| {
            let workspace = scratch.workspace()?;
            let words = self.followed_by(&[OsStr::new(word)]);
            self.call(&words, most, self.timeout, &workspace.workplace)
        });
        result.output.map_err(|answer| match answer.violation() {
            Some(what) => format!("{}: {what}", answer.name()),
            None => answer.name().to_owned(),
        })
    }

    pub(crate) fn out_of_memory(&self) -> Answer {
        Answer::OutOfMemory(format!(
            "its processes held more than {} MiB",
            self.memory >> 20
        ))
    }

    /// Interprets the end of a call.
    fn result(&self, remains: Remains, limits: &CallLimits) -> Result<CallResult, Trouble> {
        let mut exit = None;
        let output = match remains.ended {
            Ended::OutOfMemory => Err(self.out_of_memory()),
            Ended::Stopped => Err(Answer::Hung(STOPPED_MESSAGE.to_owned())),
            Ended::Flood => Err(Answer::Flooded(format!(
                "more than {} bytes on standard output",
                limits.output
            ))),
            Ended::OutOfTime => Err(Answer::Hung(format!(
                "no end within {} s",
                limits.time.as_secs_f64()
            ))),
            Ended::Exited(status) => {
                exit = status.code();
                match self.refusal(status)? {
                    None => Ok(remains.stdout),
                    Some(answer) => Err(answer),
                }
            }
        };
        Ok(CallResult {
            output,
            stderr: printable(&remains.stderr),
            exit,
            stdout: Vec::new(),
        })
    }

    /// Interprets an exit status other than 0.
    fn refusal(&self, status: ExitStatus) -> Result<Option<Answer>, Trouble> {
        let too_large = status.signal() == Some(Signal::XFSZ.as_raw());
        if too_large && processes::files_are_limited_from_outside() {
            let error = rustix::io::Errno::FBIG.into();
            return Err(Trouble::new("let the decoder write a file", &error));
        }
        Ok(match status.code() {
            Some(0) => None,
            Some(EXIT_UNSUPPORTED) => Some(Answer::Unsupported),
            Some(EXIT_MALFORMED) => Some(Answer::Rejected),
            Some(code) if Some(code) == self.reject_exit => Some(Answer::Rejected),
            _ => Some(Answer::Crashed(describe(status))),
        })
    }
}

/// Message for a decoder that changed or removed its input.
pub(crate) const INPUT_CHANGED_MESSAGE: &str = "its input file was changed or removed";

/// Message for a call that was cut short.
pub(crate) const STOPPED_MESSAGE: &str = "the run was ended by the user";

/// Describes the end of a process.
pub(crate) fn describe(status: ExitStatus) -> String {
    match status.signal() {
        Some(signal) => format!("killed by signal {signal}"),
        None => format!("exit status {}", status.code().unwrap_or(-1)),
    }
}

/// Returns text that is safe on a terminal: control characters other than line feeds and tabs are escaped.
pub(crate) fn printable(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    let shown = |c: char| {
        if c.is_control() && c != '\n' && c != '\t' {
            c.escape_default().to_string()
        } else {
            c.to_string()
        }
    };
    text.trim_end().chars().map(shown).collect()
}
