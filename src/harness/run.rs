//! Starts a decoder, bounds it, and says what it did.
//!
//! Every call has a process group of its own, which is killed as a whole when the call is over; a wall-clock limit; a
//! limit on standard output; an empty standard input; its own working directory; and the caller's environment with
//! `LC_ALL`, `TZ` and `TMPDIR` set. Standard error is read and never changes a verdict.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::{self, Read, Write};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::OpenOptionsExt;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::OFlags;
use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};

use crate::harness::protocol::{Answer, EXIT_MALFORMED, EXIT_UNSUPPORTED, View};
use crate::harness::scratch::Scratch;
use crate::harness::template::{Template, absolute};
use crate::harness::{frames, processes, start};

/// How much of standard error is kept for the report.
const STDERR_KEPT: usize = 2000;

/// A decoder and the limits it runs under.
#[derive(Clone, Debug)]
pub struct Decoder {
    command: Vec<OsString>,
    /// How a call is written where it is not `command… VIEW FILE`.
    template: Option<Template>,
    /// Wall-clock time for one call.
    pub timeout: Duration,
    /// Bytes of memory that a call may hold, all its processes together.
    pub memory: u64,
    /// Set when the user wants the run to end.
    pub stop: Arc<AtomicBool>,
    /// An exit status that means a refusal besides 65.
    pub reject_exit: Option<i32>,
    /// The locale it runs in: `C` unless told.
    pub locale: String,
}

/// One request.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// A name for the file, without its suffix.
    pub name: &'a str,
    /// What is asked for.
    pub view: &'a View,
    /// The file.
    pub file: &'a [u8],
    /// The most bytes a frame of that file can have.
    pub largest_frame: usize,
    /// How many times the ordinary time limit the decoder gets: the first call may have to warm up.
    pub patience: u32,
    /// Whether a process of its own is to answer, even where others are served.
    pub alone: bool,
}

/// What came of a request.
#[derive(Clone, Debug)]
pub struct Reply {
    /// What the decoder did.
    pub answer: Answer,
    /// The beginning of its standard error.
    pub stderr: String,
    /// Its exit status, if it had one.
    pub exit: Option<i32>,
    /// The request that the same process answered before, by its name.
    pub after: Option<String>,
    /// What a serving process did instead of answering; the answer is then that of a process of its own.
    pub served: Option<Answer>,
    /// Its standard output, as far as it was read.
    pub stdout: Vec<u8>,
}

impl From<Answer> for Reply {
    /// A reply of which nothing but the answer is known.
    fn from(answer: Answer) -> Reply {
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

impl Reply {
    /// Whether it refuses by an exit status that also means something else.
    #[must_use]
    pub fn is_weak(&self) -> bool {
        self.answer == Answer::Rejected && self.exit.is_some_and(|exit| exit != EXIT_MALFORMED)
    }
}

/// What a program did that was asked for something else than a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Said {
    /// It exited with 0 after printing this.
    Printed(Vec<u8>),
    /// It did something else, in words.
    Else(String),
}

/// One start of a decoder, whatever it is asked for.
#[derive(Clone, Debug)]
pub struct Invocation<'a> {
    /// The word before the file.
    pub view: &'a str,
    /// What the file is called.
    pub file_name: &'a str,
    /// The file.
    pub file: &'a [u8],
    /// Most bytes of an answer.
    pub most: usize,
    /// How many times the ordinary time limit it gets.
    pub patience: u32,
}

/// What came of an invocation.
#[derive(Clone, Debug)]
pub struct Heard {
    /// Its answer, if the exit status is 0; else what that means.
    pub said: Result<Vec<u8>, Answer>,
    /// The beginning of its standard error.
    pub stderr: String,
    /// Its exit status, if it had one.
    pub exit: Option<i32>,
    /// Its standard output, where that is not the answer.
    pub stdout: Vec<u8>,
}

impl Decoder {
    /// A decoder under the ordinary limits, started as `program args… VIEW FILE`; words that name existing files are made absolute, because calls
    /// run in directories of their own.
    ///
    /// # Errors
    /// If the working directory cannot be told.
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
        })
    }

    /// A program that is called as `template` says, under the same limits.
    ///
    /// # Errors
    /// If the working directory cannot be told.
    pub fn with_template(template: Template) -> io::Result<Decoder> {
        Ok(Decoder {
            template: Some(template),
            ..Decoder::new(&[])?
        })
    }

    /// The same decoder under the same limits, called in another way.
    #[must_use]
    pub(crate) fn called_by(&self, template: Template) -> Decoder {
        Decoder {
            template: Some(template),
            ..self.clone()
        }
    }

    /// Its command, with absolute paths.
    pub(crate) fn command(&self) -> &[OsString] {
        &self.command
    }

    /// Asks once. `scratch` has the place where the file is laid down and the decoder runs.
    #[must_use]
    pub fn ask(&self, request: &Request, scratch: &Scratch) -> Reply {
        let heard = self.invoke(
            &Invocation {
                view: &request.view.to_string(),
                file_name: "case.ptm",
                file: request.file,
                most: 4 * request.largest_frame + 65_536,
                patience: request.patience,
            },
            scratch,
        );
        let most = 4 * request.largest_frame + 65_536;
        let (answer, stdout) = match heard.said {
            Ok(bytes) => match frames::read(&bytes, request.view, most) {
                Ok(frame) => (Answer::Decoded(frame), bytes),
                Err(what) => (Answer::ProtocolError(what), bytes),
            },
            Err(answer) => (answer, heard.stdout),
        };
        Reply {
            stderr: heard.stderr,
            exit: heard.exit,
            stdout,
            ..answer.into()
        }
    }

    /// Starts the decoder once and hears what it says, whatever that means.
    #[must_use]
    pub fn invoke(&self, invocation: &Invocation, scratch: &Scratch) -> Heard {
        self.attempt(invocation, scratch)
            .unwrap_or_else(|error| Heard {
                said: Err(Answer::NotStarted(match self.command.first() {
                    Some(program) => start::why_not(program, &error),
                    None => error.to_string(),
                })),
                stderr: String::new(),
                exit: None,
                stdout: Vec::new(),
            })
    }

    fn attempt(&self, invocation: &Invocation, scratch: &Scratch) -> io::Result<Heard> {
        let place = scratch.place()?;
        // Its name says nothing of what is expected.
        let input = place.directory.join(invocation.file_name);
        lay_down(&input, invocation.file)?;
        let output = match &self.template {
            Some(template) => template.output(&place.workplace)?,
            None => None,
        };
        let words = self.words(invocation.view, &input, &place.workplace)?;
        let call = self.start(&words, &place.workplace, Stdio::null())?;
        let ended = call.finish(
            invocation.most,
            self.timeout.saturating_mul(invocation.patience),
            self,
            &place.workplace,
        )?;
        let mut heard = self.judge(ended);
        if let (Ok(stdout), Some(output)) = (&mut heard.said, &output) {
            heard.stdout = std::mem::take(stdout);
            heard.said = output.read(invocation.most);
        }
        // Where the file lay is nothing to report; its name is.
        heard.stderr = heard
            .stderr
            .replace(&format!("{}/", place.directory.display()), "");
        if !is_untouched(&input, invocation.file) {
            heard.said = Err(Answer::Tampered(
                "the file it was given is changed or gone".to_owned(),
            ));
        }
        Ok(heard)
    }

    /// The words of a call, the program's own among them.
    fn words(&self, view: &str, input: &Path, workplace: &Path) -> io::Result<Vec<OsString>> {
        match &self.template {
            Some(template) => {
                let view: View = view.parse().map_err(io::Error::other)?;
                Ok(template.words(&view, input, workplace))
            }
            None => Ok(self.followed_by(&[OsStr::new(view), input.as_os_str()])),
        }
    }

    /// Its command with more words behind.
    pub(super) fn followed_by(&self, words: &[&OsStr]) -> Vec<OsString> {
        let more = words.iter().map(|&word| word.to_owned());
        self.command.iter().cloned().chain(more).collect()
    }

    /// Starts a process of these words.
    pub(super) fn start(
        &self,
        words: &[OsString],
        workplace: &Path,
        stdin: Stdio,
    ) -> io::Result<Call> {
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
        Call::new(processes::start(&mut command)?)
    }

    /// What it prints, at most `most` bytes, if it is called with one word that is no view.
    pub(super) fn say(&self, word: &str, most: usize, scratch: &Scratch) -> Said {
        if self.template.is_some() {
            return Said::Else("the line that calls it has no place for words".to_owned());
        }
        let attempt = || -> io::Result<Ended> {
            let place = scratch.place()?;
            let words = self.followed_by(&[OsStr::new(word)]);
            let call = self.start(&words, &place.workplace, Stdio::null())?;
            call.finish(most, self.timeout, self, &place.workplace)
        };
        match attempt() {
            Err(error) => Said::Else(error.to_string()),
            Ok(ended) => match self.judge(ended).said {
                Ok(stdout) => Said::Printed(stdout),
                Err(answer) => Said::Else(match answer.misconduct() {
                    Some(what) => format!("{}: {what}", answer.name()),
                    None => answer.name().to_owned(),
                }),
            },
        }
    }

    pub(super) fn held_too_much(&self) -> Answer {
        Answer::OutOfMemory(format!(
            "its processes held more than {} MiB",
            self.memory >> 20
        ))
    }

    fn judge(&self, ended: Ended) -> Heard {
        let exit = ended.status.and_then(|status| status.code());
        let stderr = printable(&ended.stderr);
        let said = match ended.status {
            None if ended.cause == Cause::Memory => Err(self.held_too_much()),
            None if ended.cause == Cause::Stopped => {
                Err(Answer::Hung("the run was ended by the user".to_owned()))
            }
            None if ended.cause == Cause::Flood => Err(Answer::Flooded(format!(
                "more than {} bytes on standard output",
                ended.most
            ))),
            None => Err(Answer::Hung(format!(
                "no end within {} s",
                ended.limit.as_secs_f64()
            ))),
            Some(_) if exit == Some(0) => Ok(ended.stdout),
            Some(_)
                if exit == Some(EXIT_MALFORMED) || exit.is_some() && exit == self.reject_exit =>
            {
                Err(Answer::Rejected)
            }
            Some(_) if exit == Some(EXIT_UNSUPPORTED) => Err(Answer::Unsupported),
            Some(status) => Err(Answer::Crashed(describe(status))),
        };
        let stdout = Vec::new();
        Heard {
            said,
            stderr,
            exit,
            stdout,
        }
    }
}

/// How a process ended.
pub(super) fn describe(status: ExitStatus) -> String {
    match status.signal() {
        Some(signal) => format!("killed by signal {signal}"),
        None => format!("exit status {}", status.code().unwrap_or(-1)),
    }
}

/// What may be shown on a terminal: control characters but line feeds and tabs are escaped.
pub(super) fn printable(bytes: &[u8]) -> String {
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

/// Writes the input read-only.
pub(super) fn lay_down(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = fs::OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(0o444)
        .open(path)?;
    file.write_all(bytes)
}

/// Whether the input is still the file it was. It may have become anything, a pipe or a link too, and may still change.
pub(super) fn is_untouched(path: &Path, bytes: &[u8]) -> bool {
    let carefully = OFlags::NOFOLLOW | OFlags::NONBLOCK;
    let open = fs::OpenOptions::new()
        .read(true)
        .custom_flags(carefully.bits().cast_signed())
        .open(path);
    let Ok(file) = open else { return false };
    let same_kind = file
        .metadata()
        .is_ok_and(|file| file.is_file() && file.len() == bytes.len() as u64);
    let mut read = Vec::with_capacity(bytes.len() + 1);
    same_kind
        && file
            .take(bytes.len() as u64 + 1)
            .read_to_end(&mut read)
            .is_ok_and(|_| read == bytes)
}

/// Longer than anybody waits, and short enough to be added to a clock.
pub(super) const A_YEAR: Duration = Duration::from_secs(365 * 24 * 3600);

/// How often memory is measured and the user's wish looked at.
pub(super) const LOOK: Duration = Duration::from_millis(50);

/// Why a process had to be killed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Cause {
    None,
    Time,
    Memory,
    Flood,
    Stopped,
}

/// A running decoder.
pub(super) struct Call {
    pub(super) child: Child,
    pub(super) group: Pid,
    waited_for: bool,
    ending: Option<Ending>,
    stdout: Option<OwnedFd>,
    stderr: Option<OwnedFd>,
    /// What it has written to standard output and nobody has taken yet.
    pub(super) output: Vec<u8>,
    /// The beginning of what it has written to standard error.
    pub(super) errors: Vec<u8>,
}

/// What a call left.
struct Ended {
    /// Nothing if it had to be killed.
    status: Option<ExitStatus>,
    /// Why it had to be.
    cause: Cause,
    limit: Duration,
    most: usize,
    stdout: Vec<u8>,
    stderr: Vec<u8>,
}

impl Call {
    fn new(mut child: Child) -> io::Result<Call> {
        let nonblocking = |fd: OwnedFd| -> io::Result<OwnedFd> {
            rustix::io::ioctl_fionbio(&fd, true)?;
            Ok(fd)
        };
        let stdout = child.stdout.take().map(OwnedFd::from).map(nonblocking);
        let stderr = child.stderr.take().map(OwnedFd::from).map(nonblocking);
        Ok(Call {
            group: Pid::from_child(&child),
            ending: Ending::of(&child),
            child,
            waited_for: false,
            stdout: stdout.transpose()?,
            stderr: stderr.transpose()?,
            output: Vec::new(),
            errors: Vec::new(),
        })
    }

    /// Reads until the process has ended or a limit is reached, at most `most` bytes of output; then kills what is left
    /// of it.
    fn finish(
        mut self,
        most: usize,
        limit: Duration,
        decoder: &Decoder,
        workplace: &Path,
    ) -> io::Result<Ended> {
        let deadline = Instant::now() + limit.min(A_YEAR);
        let watched = processes::can_be_watched();
        let mut next_look = Instant::now() + LOOK;
        let outcome = loop {
            let now = Instant::now();
            let left = deadline.saturating_duration_since(now);
            if self.output.len() > most {
                break Err(Cause::Flood);
            }
            if left.is_zero() {
                break Err(Cause::Time);
            }
            if decoder.stop.load(Ordering::Relaxed) {
                break Err(Cause::Stopped);
            }
            if now >= next_look {
                next_look = now + LOOK;
                if watched && processes::memory_of(self.group, workplace) > decoder.memory {
                    break Err(Cause::Memory);
                }
            }
            self.wait_for_news(None, left.min(LOOK))?;
            self.read_what_is_there(most)?;
            if self.has_ended() {
                self.read_what_is_there(most)?;
                break Ok(());
            }
        };
        let status = self.end(workplace);
        let cause = match outcome {
            Err(cause) => cause,
            Ok(()) if self.output.len() > most => Cause::Flood,
            Ok(()) => Cause::None,
        };
        let status = status.ok().filter(|_| cause == Cause::None);
        Ok(Ended {
            status,
            cause,
            limit,
            most,
            stdout: std::mem::take(&mut self.output),
            stderr: std::mem::take(&mut self.errors),
        })
    }

    /// Whether the process has ended. It keeps its number until it is waited for, so that no other can be mistaken for it.
    pub(super) fn has_ended(&self) -> bool {
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        let pid = Pid::from_child(&self.child);
        !matches!(waitid(WaitId::Pid(pid), options), Ok(None))
    }

    /// Kills the process if it still runs, its group, and whoever else works for it in `workplace`; says how it ended.
    pub(super) fn end(&mut self, workplace: &Path) -> io::Result<ExitStatus> {
        let status = self.kill();
        processes::kill_orphans(workplace);
        status
    }

    fn kill(&mut self) -> io::Result<ExitStatus> {
        if !self.waited_for {
            // An error means that nobody is left.
            let _ = kill_process_group(self.group, Signal::KILL);
            // It may have left its group; itself it cannot leave.
            let _ = self.child.kill();
            processes::has_been_waited_for(self.child.id());
            self.waited_for = true;
        }
        self.child.wait()
    }

    /// Sleeps until there is output, room in `writing`, the process has ended, or `left` is over.
    pub(super) fn wait_for_news(
        &self,
        writing: Option<BorrowedFd>,
        left: Duration,
    ) -> io::Result<()> {
        let reading = [
            self.stdout.as_ref().map(AsFd::as_fd),
            self.stderr.as_ref().map(AsFd::as_fd),
            self.ending.as_ref().map(Ending::as_fd),
        ];
        let mut fds: Vec<PollFd> = reading
            .iter()
            .flatten()
            .map(|fd| PollFd::from_borrowed_fd(*fd, PollFlags::IN))
            .chain(writing.map(|fd| PollFd::from_borrowed_fd(fd, PollFlags::OUT)))
            .collect();
        // Where the end of a process cannot be waited for, it is looked for every two milliseconds.
        let nap = if self.ending.is_some() {
            left
        } else {
            left.min(Duration::from_millis(2))
        };
        let nap = Timespec {
            tv_sec: nap.as_secs().min(1 << 30).cast_signed(),
            tv_nsec: i64::from(nap.subsec_nanos()),
        };
        match poll(&mut fds, Some(&nap)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// Takes what lies in the pipes, until there are more than `most` bytes of output.
    pub(super) fn read_what_is_there(&mut self, most: usize) -> io::Result<()> {
        let mut buffer = [0; 65_536];
        while self.output.len() <= most {
            match read_some(&mut self.stdout, &mut buffer)? {
                0 => break,
                count => self.output.extend_from_slice(&buffer[..count]),
            }
        }
        // A bounded share each time, so that a stream of errors cannot keep the clock from being read.
        for _ in 0..16 {
            match read_some(&mut self.stderr, &mut buffer)? {
                0 => break,
                count => {
                    let kept = count.min(STDERR_KEPT.saturating_sub(self.errors.len()));
                    self.errors.extend_from_slice(&buffer[..kept]);
                }
            }
        }
        Ok(())
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        let _ = self.kill();
    }
}

/// Reads from a pipe that does not block; forgets it at its end. 0 means that nothing is there.
fn read_some(pipe: &mut Option<OwnedFd>, buffer: &mut [u8]) -> io::Result<usize> {
    let Some(fd) = pipe else { return Ok(0) };
    match rustix::io::read(&*fd, buffer) {
        Ok(0) => {
            *pipe = None;
            Ok(0)
        }
        Ok(count) => Ok(count),
        Err(rustix::io::Errno::AGAIN | rustix::io::Errno::INTR) => Ok(0),
        Err(error) => Err(error.into()),
    }
}

/// Something that becomes readable when a process ends.
struct Ending(OwnedFd);

impl Ending {
    #[cfg(target_os = "linux")]
    fn of(child: &Child) -> Option<Ending> {
        rustix::process::pidfd_open(Pid::from_child(child), rustix::process::PidfdFlags::empty())
            .ok()
            .map(Ending)
    }

    #[cfg(not(target_os = "linux"))]
    fn of(_: &Child) -> Option<Ending> {
        None
    }

    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}
