//! Supervises a running decoder process: reads its output, enforces its limits, and ends it.

use std::io;
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::Path;
use std::process::{Child, ExitStatus};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};

use crate::runner::processes;
use ptm_suite::protocol::frame::TimeLimit;

/// Maximum number of bytes of standard error that are kept for the report.
const MAX_STDERR_BYTES: usize = 2000;

/// A duration longer than any timeout, yet short enough to be added to an `Instant`.
pub const MAX_WAIT: Duration = Duration::from_secs(365 * 24 * 3600);

/// Interval at which memory is measured and the stop flag is checked.
pub const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Limits of a call.
pub struct CallLimits<'a> {
    /// Maximum number of bytes on standard output.
    pub(crate) output: usize,
    pub(crate) time: TimeLimit,
    /// Maximum number of bytes of memory, summed over all processes of the call.
    pub(crate) memory: u64,
    /// Flag that stops the run.
    pub(crate) stop: &'a AtomicBool,
}

/// A running decoder process.
pub struct Call {
    pub(crate) child: Child,
    pub(crate) group: Pid,
    reaped: bool,
    exit_event: Option<ExitEvent>,
    stdout: Option<OwnedFd>,
    stderr: Option<OwnedFd>,
    /// Standard output that was read but not yet consumed.
    pub(crate) output: Vec<u8>,
    /// The start of standard error.
    pub(crate) errors: Vec<u8>,
}

/// The way in which a call ended.
pub enum CallEnd {
    /// The process exited on its own.
    Exited(ExitStatus),
    /// The process was killed because it exceeded the time limit.
    OutOfTime,
    /// The process was killed because it used too much memory.
    OutOfMemory,
    /// The process was killed because it wrote too much output.
    Flood,
    /// The process was killed because the user stopped the run.
    Stopped,
}

/// The output of a call and the way in which it ended.
pub struct CallOutput {
    pub(crate) ended: CallEnd,
    pub(crate) stdout: Vec<u8>,
    pub(crate) stderr: Vec<u8>,
}

impl Call {
    /// Creates a call from a process that was started with pipes for standard output and standard error.
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
            reaped: false,
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

    /// Reads until the process ends or reaches a limit, then kills all remaining processes of the call.
    pub fn finish(mut self, limits: &CallLimits, work_dir: &Path) -> io::Result<CallOutput> {
        let kill_reason = self.watch(limits, work_dir)?;
        let status = self.kill_and_reap(work_dir)?;
        let ended = match kill_reason {
            Some(ended) => ended,
            None if self.output.len() > limits.output => CallEnd::Flood,
            None => CallEnd::Exited(status),
        };
        Ok(CallOutput {
            ended,
            stdout: std::mem::take(&mut self.output),
            stderr: std::mem::take(&mut self.errors),
        })
    }

    /// Reads until the process ends. Returns the reason to kill the process if it reaches a limit.
    fn watch(&mut self, limits: &CallLimits, work_dir: &Path) -> io::Result<Option<CallEnd>> {
        let deadline = Instant::now() + limits.time.0.min(MAX_WAIT);
        let can_measure = processes::can_inspect_processes();
        let mut next_look = Instant::now() + POLL_INTERVAL;
        loop {
            let now = Instant::now();
            let left = deadline.saturating_duration_since(now);
            if self.output.len() > limits.output {
                return Ok(Some(CallEnd::Flood));
            }
            if left.is_zero() {
                return Ok(Some(CallEnd::OutOfTime));
            }
            if limits.stop.load(Ordering::Relaxed) {
                return Ok(Some(CallEnd::Stopped));
            }
            if now >= next_look {
                next_look = now + POLL_INTERVAL;
                if can_measure && processes::memory_of_call(self.group, work_dir) > limits.memory {
                    return Ok(Some(CallEnd::OutOfMemory));
                }
            }
            self.wait_for_event(None, left.min(POLL_INTERVAL))?;
            self.read_available(limits.output)?;
            if self.has_ended() {
                self.read_available(limits.output)?;
                return Ok(None);
            }
        }
    }

    /// Returns true if the process has ended. Until the process is reaped, no other process can reuse its id.
    pub(crate) fn has_ended(&self) -> bool {
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        let pid = Pid::from_child(&self.child);
        !matches!(waitid(WaitId::Pid(pid), options), Ok(None))
    }

    /// Kills the process (if it is still running), its process group, and its orphans in `work_dir`. Returns the exit status.
    pub(crate) fn kill_and_reap(&mut self, work_dir: &Path) -> io::Result<ExitStatus> {
        let status = self.kill();
        processes::kill_orphans(work_dir);
        status
    }

    fn kill(&mut self) -> io::Result<ExitStatus> {
        if !self.reaped {
            // Ignore errors, which mean that no process is left.
            let _ = kill_process_group(self.group, Signal::KILL);
            // The process may have left its group, so also kill it by its id.
            let _ = self.child.kill();
        }
        let status = self.child.wait();
        if !std::mem::replace(&mut self.reaped, true) {
            processes::unregister(self.child.id());
        }
        status
    }

    /// Sleeps until there is output, `writing` becomes writable, the process ends, or `left` has passed.
    pub fn wait_for_event(&self, writing: Option<BorrowedFd>, left: Duration) -> io::Result<()> {
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

    /// Reads all available output, until `output` has more than `max_bytes` bytes.
    #[expect(clippy::large_stack_arrays, reason = "a buffer of a pipe's size")]
    pub(crate) fn read_available(&mut self, max_bytes: usize) -> io::Result<()> {
        let mut buffer = [MaybeUninit::uninit(); 65_536];
        while self.output.len() <= max_bytes {
            match read_some(&mut self.stdout, &mut buffer)? {
                [] => break,
                bytes => self.output.extend_from_slice(bytes),
            }
        }
        // Limit the number of reads, so that a flood on standard error cannot delay the timeout check.
        for _ in 0..16 {
            match read_some(&mut self.stderr, &mut buffer)? {
                [] => break,
                bytes => {
                    let room = MAX_STDERR_BYTES.saturating_sub(self.errors.len());
                    self.errors
                        .extend_from_slice(&bytes[..bytes.len().min(room)]);
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

/// Reads from a non-blocking pipe, and drops the pipe at the end of its data. Returns no bytes if no data is available.
fn read_some<'a>(
    pipe: &mut Option<OwnedFd>,
    buffer: &'a mut [MaybeUninit<u8>],
) -> io::Result<&'a [u8]> {
    let Some(fd) = pipe else { return Ok(&[]) };
    match rustix::io::read(&*fd, buffer) {
        Ok(([], _)) => {
            *pipe = None;
            Ok(&[])
        }
        Ok((bytes, _)) => Ok(bytes),
        Err(rustix::io::Errno::AGAIN | rustix::io::Errno::INTR) => Ok(&[]),
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
