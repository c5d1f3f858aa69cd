//! Starts a decoder, bounds it, and says what it did.
//!
//! Every call has a process group of its own, which is killed as a whole when the call is over; a wall-clock limit; a
//! limit on standard output; an empty standard input; its own working directory; and the caller's environment with
//! `LC_ALL`, `TZ` and `TMPDIR` set. Standard error is read and never changes a verdict.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, Signal, kill_process_group};

use crate::harness::processes;
use crate::harness::protocol::{Answer, EXIT_MALFORMED, EXIT_UNSUPPORTED, Frame, View};

/// How much of standard error is kept for the report.
const STDERR_KEPT: usize = 2000;

/// A decoder and the limits it runs under.
#[derive(Clone, Debug)]
pub struct Decoder {
    command: Vec<OsString>,
    /// Wall-clock time for one call.
    pub timeout: Duration,
    /// Bytes of memory that a call may hold, all its processes together.
    pub memory: u64,
    /// Set when the user wants the run to end.
    pub stop: Arc<AtomicBool>,
    /// An exit status that means a refusal besides 65.
    pub reject_exit: Option<i32>,
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
}

impl Decoder {
    /// A decoder under the ordinary limits, started as `program args… VIEW FILE`; words that name existing files are made absolute, because calls
    /// run in directories of their own.
    ///
    /// # Errors
    /// If the working directory cannot be told.
    pub fn new(command: &[OsString]) -> io::Result<Decoder> {
        let absolute = |(i, word): (usize, &OsString)| -> io::Result<OsString> {
            let path = Path::new(word);
            // A bare program name is looked up in PATH and nowhere else.
            let names_file = path.exists() && (i > 0 || path.components().count() > 1);
            Ok(if names_file {
                std::path::absolute(path)?.into_os_string()
            } else {
                word.clone()
            })
        };
        let command = command
            .iter()
            .enumerate()
            .map(absolute)
            .collect::<io::Result<_>>()?;
        Ok(Decoder {
            command,
            timeout: Duration::from_secs(10),
            memory: 2 << 30,
            stop: Arc::default(),
            reject_exit: None,
        })
    }

    /// Asks once. `scratch` is the directory in which the file is laid down and the decoder runs.
    #[must_use]
    pub fn ask(&self, request: &Request, scratch: &Path) -> Reply {
        match self.attempt(request, scratch) {
            Ok(reply) => reply,
            Err(error) => Reply {
                answer: Answer::NotStarted(error.to_string()),
                stderr: String::new(),
                exit: None,
            },
        }
    }

    fn attempt(&self, request: &Request, scratch: &Path) -> io::Result<Reply> {
        // A directory of its own for each call: what one leaves behind, even if it cannot be removed, meets no other.
        let place = scratch.join(NEXT_CALL.fetch_add(1, Ordering::Relaxed).to_string());
        let workplace = place.join("work");
        fs::create_dir_all(&workplace)?;
        // Its name says nothing of what is expected.
        let input = place.join("case.ptm");
        lay_down(&input, request.file)?;

        let child = Command::new(&self.command[0])
            .args(&self.command[1..])
            .arg(request.view.to_string())
            .arg(&input)
            .current_dir(&workplace)
            .env("LC_ALL", "C")
            .env("TZ", "UTC")
            .env("TMPDIR", &workplace)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .process_group(0)
            .spawn();
        let reply = child.and_then(|child| {
            let call = Call::new(child, 4 * request.largest_frame + 65_536)?;
            let ended = call.finish(
                self.timeout.saturating_mul(request.patience),
                self.memory,
                &self.stop,
            )?;
            processes::kill_orphans(&workplace);
            let mut reply = self.judge(&ended);
            // Where the file lay is nothing to report; its name is.
            reply.stderr = reply.stderr.replace(&format!("{}/", place.display()), "");
            if !is_untouched(&input, request.file) {
                reply.answer =
                    Answer::Tampered("the file it was given is changed or gone".to_owned());
            }
            Ok(reply)
        });
        // What cannot be removed now is removed with the scratch directory, or stays: it is no fault of the answer.
        let _ = fs::remove_dir_all(&place);
        reply
    }

    fn judge(&self, ended: &Ended) -> Reply {
        let exit = ended.status.and_then(|status| status.code());
        let answer = match ended.status {
            None if ended.cause == Cause::Memory => Answer::OutOfMemory(format!(
                "its processes held more than {} MiB",
                self.memory >> 20
            )),
            None if ended.cause == Cause::Stopped => {
                Answer::Hung("the run was ended by the user".to_owned())
            }
            None if ended.cause == Cause::Flood => Answer::Flooded(format!(
                "more than {} bytes on standard output",
                ended.stdout.len()
            )),
            None => Answer::Hung(format!("no end within {} s", ended.limit.as_secs_f64())),
            Some(_) if exit == Some(0) => match Frame::read(&ended.stdout) {
                Ok(frame) => Answer::Decoded(frame),
                Err(what) => Answer::ProtocolError(what),
            },
            Some(_)
                if exit == Some(EXIT_MALFORMED) || exit.is_some() && exit == self.reject_exit =>
            {
                Answer::Rejected
            }
            Some(_) if exit == Some(EXIT_UNSUPPORTED) => Answer::Unsupported,
            Some(status) => Answer::Crashed(match status.signal() {
                Some(signal) => format!("killed by signal {signal}"),
                None => format!("exit status {}", exit.unwrap_or(-1)),
            }),
        };
        Reply {
            answer,
            stderr: printable(&ended.stderr),
            exit,
        }
    }
}

/// What may be shown on a terminal: control characters but line feeds and tabs are escaped.
fn printable(bytes: &[u8]) -> String {
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
fn lay_down(path: &Path, bytes: &[u8]) -> io::Result<()> {
    fs::write(path, bytes)?;
    let mut permissions = fs::metadata(path)?.permissions();
    permissions.set_readonly(true);
    fs::set_permissions(path, permissions)
}

/// Whether the input is still the file it was. It may have become anything, so it is looked at before it is opened.
fn is_untouched(path: &Path, bytes: &[u8]) -> bool {
    let same_kind = |file: fs::Metadata| file.is_file() && file.len() == bytes.len() as u64;
    fs::symlink_metadata(path).is_ok_and(same_kind)
        && fs::read(path).is_ok_and(|read| read == bytes)
}

/// Longer than anybody waits, and short enough to be added to a clock.
const A_YEAR: Duration = Duration::from_secs(365 * 24 * 3600);

/// How often memory is measured and the user's wish looked at.
const LOOK: Duration = Duration::from_millis(50);

/// Numbers calls, for directories that no two share.
static NEXT_CALL: AtomicU64 = AtomicU64::new(0);

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
struct Call {
    child: Child,
    group: Pid,
    stdout: Option<OwnedFd>,
    stderr: Option<OwnedFd>,
    /// Most bytes of standard output that are read.
    most: usize,
    output: Vec<u8>,
    errors: Vec<u8>,
}

/// What a call left.
struct Ended {
    /// Nothing if it had to be killed.
    status: Option<ExitStatus>,
    /// Why it had to be.
    cause: Cause,
    limit: Duration,
    stdout: Vec<u8>,
    stderr: Vec<u8>,
}

impl Call {
    fn new(mut child: Child, most: usize) -> io::Result<Call> {
        let group = Pid::from_child(&child);
        let nonblocking = |fd: OwnedFd| -> io::Result<OwnedFd> {
            rustix::io::ioctl_fionbio(&fd, true)?;
            Ok(fd)
        };
        let stdout = child
            .stdout
            .take()
            .map(OwnedFd::from)
            .map(nonblocking)
            .transpose()?;
        let stderr = child
            .stderr
            .take()
            .map(OwnedFd::from)
            .map(nonblocking)
            .transpose()?;
        Ok(Call {
            child,
            group,
            stdout,
            stderr,
            most,
            output: Vec::new(),
            errors: Vec::new(),
        })
    }

    /// Reads until the process has ended or a limit is reached; then kills what is left of its group.
    fn finish(mut self, limit: Duration, memory: u64, stop: &AtomicBool) -> io::Result<Ended> {
        let deadline = Instant::now() + limit.min(A_YEAR);
        let ending = Ending::of(&self.child);
        let watched = processes::can_be_watched();
        let mut next_look = Instant::now() + LOOK;
        let outcome = loop {
            let now = Instant::now();
            let left = deadline.saturating_duration_since(now);
            if self.output.len() > self.most {
                break Err(Cause::Flood);
            }
            if left.is_zero() {
                break Err(Cause::Time);
            }
            if stop.load(Ordering::Relaxed) {
                break Err(Cause::Stopped);
            }
            if now >= next_look {
                next_look = now + LOOK;
                if watched && processes::memory_of_group(self.group) > memory {
                    break Err(Cause::Memory);
                }
            }
            self.wait_for_news(ending.as_ref(), left.min(LOOK))?;
            self.read_what_is_there()?;
            if let Some(status) = self.child.try_wait()? {
                break Ok(status);
            }
        };
        // The process is gone or must go; nobody of its group outlives the call. An error means that nobody is left.
        let _ = kill_process_group(self.group, Signal::KILL);
        // It may have left its group; itself it cannot leave.
        let _ = self.child.kill();
        let (status, mut cause) = match outcome {
            Ok(status) => {
                self.read_what_is_there()?;
                (Some(status), Cause::None)
            }
            Err(cause) => {
                self.child.wait()?;
                (None, cause)
            }
        };
        if self.output.len() > self.most {
            cause = Cause::Flood;
        }
        let status = status.filter(|_| cause == Cause::None);
        Ok(Ended {
            status,
            cause,
            limit,
            stdout: self.output,
            stderr: self.errors,
        })
    }

    /// Sleeps until there is output, the process has ended, or `left` is over.
    fn wait_for_news(&self, ending: Option<&Ending>, left: Duration) -> io::Result<()> {
        let sources = [
            self.stdout.as_ref().map(AsFd::as_fd),
            self.stderr.as_ref().map(AsFd::as_fd),
            ending.map(Ending::as_fd),
        ];
        let mut fds: Vec<PollFd> = sources
            .iter()
            .flatten()
            .map(|fd| PollFd::from_borrowed_fd(*fd, PollFlags::IN))
            .collect();
        // Where the end of a process cannot be waited for, it is looked for every two milliseconds.
        let nap = if ending.is_some() {
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

    fn read_what_is_there(&mut self) -> io::Result<()> {
        let mut buffer = [0; 65_536];
        while self.output.len() <= self.most {
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

    fn as_fd(&self) -> std::os::fd::BorrowedFd<'_> {
        self.0.as_fd()
    }
}
