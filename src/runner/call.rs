//! A running decoder: its output, its limits and its end.

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::Path;
use std::process::{Child, ExitStatus};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};

use crate::runner::processes;

/// Bytes of standard error that are kept for the report.
const MAX_STDERR_BYTES: usize = 2000;

/// A wait longer than any timeout, yet short enough to be added to a point in time.
pub(crate) const MAX_WAIT: Duration = Duration::from_secs(365 * 24 * 3600);

/// The interval at which memory is measured and the stop flag is read.
pub(crate) const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// The limits of a call.
pub(crate) struct CallLimits<'a> {
    /// Bytes on standard output.
    pub(crate) output: usize,
    pub(crate) time: Duration,
    /// Bytes of memory, all its processes together.
    pub(crate) memory: u64,
    /// Set when the run is to end.
    pub(crate) stop: &'a AtomicBool,
}

/// A running decoder.
pub(crate) struct Call {
    pub(crate) child: Child,
    pub(crate) group: Pid,
    waited_for: bool,
    exit_event: Option<ExitEvent>,
    stdout: Option<OwnedFd>,
    stderr: Option<OwnedFd>,
    /// Standard output that has been read from the decoder and not yet consumed.
    pub(crate) output: Vec<u8>,
    /// The beginning of its standard error.
    pub(crate) errors: Vec<u8>,
}

/// The way a call ended.
pub(crate) enum Ended {
    /// The process exited.
    Exited(ExitStatus),
    /// Killed: timeout.
    OutOfTime,
    /// Killed: too much memory.
    OutOfMemory,
    /// Killed: too much output.
    Flood,
    /// Killed: the user ended the run.
    Stopped,
}

/// The output and the end of a call.
pub(crate) struct Remains {
    pub(crate) ended: Ended,
    pub(crate) stdout: Vec<u8>,
    pub(crate) stderr: Vec<u8>,
}

impl Call {
    /// Takes over a process that was started with both outputs as pipes.
    pub(crate) fn new(mut child: Child) -> io::Result<Call> {
        let pipes = [
            child.stdout.take().map(OwnedFd::from),
            child.stderr.take().map(OwnedFd::from),
        ];
        let [stdout, stderr] = pipes;
        let call = Call {
            group: Pid::from_child(&child),
            exit_event: ExitEvent::new(&child),
            child,
            waited_for: false,
            stdout,
            stderr,
            output: Vec::new(),
            errors: Vec::new(),
        };
        for pipe in [&call.stdout, &call.stderr].into_iter().flatten() {
            rustix::io::ioctl_fionbio(pipe, true)?;
        }
        Ok(call)
    }

    /// Reads until the process has ended or a limit is reached, and then kills all that is left of it.
    pub(crate) fn finish(mut self, limits: &CallLimits, workplace: &Path) -> io::Result<Remains> {
        let killed_for = self.watch(limits, workplace)?;
        let status = self.end(workplace)?;
        let ended = match killed_for {
            Some(ended) => ended,
            None if self.output.len() > limits.output => Ended::Flood,
            None => Ended::Exited(status),
        };
        Ok(Remains {
            ended,
            stdout: std::mem::take(&mut self.output),
            stderr: std::mem::take(&mut self.errors),
        })
    }

    /// Reads until the process has ended, or returns the reason to kill it.
    fn watch(&mut self, limits: &CallLimits, workplace: &Path) -> io::Result<Option<Ended>> {
        let deadline = Instant::now() + limits.time.min(MAX_WAIT);
        let watched = processes::can_be_watched();
        let mut next_look = Instant::now() + POLL_INTERVAL;
        loop {
            let now = Instant::now();
            let left = deadline.saturating_duration_since(now);
            if self.output.len() > limits.output {
                return Ok(Some(Ended::Flood));
            }
            if left.is_zero() {
                return Ok(Some(Ended::OutOfTime));
            }
            if limits.stop.load(Ordering::Relaxed) {
                return Ok(Some(Ended::Stopped));
            }
            if now >= next_look {
                next_look = now + POLL_INTERVAL;
                if watched && processes::memory_of(self.group, workplace) > limits.memory {
                    return Ok(Some(Ended::OutOfMemory));
                }
            }
            self.wait_for_news(None, left.min(POLL_INTERVAL))?;
            self.read_what_is_there(limits.output)?;
            if self.has_ended() {
                self.read_what_is_there(limits.output)?;
                return Ok(None);
            }
        }
    }

    /// Returns true if the process has ended. Its id stays reserved until it is waited for, so no other process can have it.
    pub(crate) fn has_ended(&self) -> bool {
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        let pid = Pid::from_child(&self.child);
        !matches!(waitid(WaitId::Pid(pid), options), Ok(None))
    }

    /// Kills the process if it still runs, its group, and what else works for it in `workplace`; returns its status.
    pub(crate) fn end(&mut self, workplace: &Path) -> io::Result<ExitStatus> {
        let status = self.kill();
        processes::kill_orphans(workplace);
        status
    }

    fn kill(&mut self) -> io::Result<ExitStatus> {
        if !self.waited_for {
            // An error means that no process is left.
            let _ = kill_process_group(self.group, Signal::KILL);
            // The process may have left its group, so it is killed by its id too.
            let _ = self.child.kill();
        }
        let status = self.child.wait();
        if !std::mem::replace(&mut self.waited_for, true) {
            processes::has_been_waited_for(self.child.id());
        }
        status
    }

    /// Sleeps until there is output, room in `writing`, the process has ended, or `left` has passed.
    pub(crate) fn wait_for_news(
        &self,
        writing: Option<BorrowedFd>,
        left: Duration,
    ) -> io::Result<()> {
        let reading = [
            self.stdout.as_ref().map(AsFd::as_fd),
            self.stderr.as_ref().map(AsFd::as_fd),
            self.exit_event.as_ref().map(ExitEvent::as_fd),
        ];
        let mut fds: Vec<PollFd> = reading
            .iter()
            .flatten()
            .map(|fd| PollFd::from_borrowed_fd(*fd, PollFlags::IN))
            .chain(writing.map(|fd| PollFd::from_borrowed_fd(fd, PollFlags::OUT)))
            .collect();
        // Without an event for the end of the process, poll every two milliseconds.
        let nap = if self.exit_event.is_some() {
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

    /// Reads what the pipes hold, until `output` has more than `most` bytes.
    #[expect(clippy::large_stack_arrays, reason = "a buffer of a pipe's size")]
    pub(crate) fn read_what_is_there(&mut self, most: usize) -> io::Result<()> {
        let mut buffer = [0; 65_536];
        while self.output.len() <= most {
            match read_some(&mut self.stdout, &mut buffer)? {
                0 => break,
                count => self.output.extend_from_slice(&buffer[..count]),
            }
        }
        // A bounded number of reads, so that a flood on standard error cannot delay the check of the timeout.
        for _ in 0..16 {
            match read_some(&mut self.stderr, &mut buffer)? {
                0 => break,
                count => {
                    let kept = count.min(MAX_STDERR_BYTES.saturating_sub(self.errors.len()));
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

/// Reads from a non-blocking pipe and drops it at its end. Returns 0 if there is nothing to read.
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

/// A file descriptor that becomes readable when a process ends.
struct ExitEvent(OwnedFd);

impl ExitEvent {
    #[cfg(target_os = "linux")]
    fn new(child: &Child) -> Option<ExitEvent> {
        rustix::process::pidfd_open(Pid::from_child(child), rustix::process::PidfdFlags::empty())
            .ok()
            .map(ExitEvent)
    }

    #[cfg(not(target_os = "linux"))]
    fn new(_: &Child) -> Option<ExitEvent> {
        None
    }

    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}
