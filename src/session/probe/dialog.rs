//! A conversation with a process in serve mode, as loose as a person's would be.

use std::fs;
use std::io::{Read, Write};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process_group};

use crate::protocol::frame::View;
use crate::runner::call::A_YEAR;
use crate::runner::processes;

use super::calls::Calls;
use super::message::{Fault, Slots, fault};

/// One answer: its line, and the bytes it announces.
pub(super) struct ServedAnswer {
    pub(super) line: String,
    pub(super) bytes: Vec<u8>,
}

/// What came while an answer was waited for.
pub(super) enum Served {
    Answer(ServedAnswer),
    /// Nothing whole within the time.
    Nothing,
    /// The process has ended; whether with status 0.
    Gone(bool),
    /// Something else: what is wrong, and what to do.
    Wrong(Fault),
}

/// A directory for files to be asked for.
pub(super) struct Desk(PathBuf);

impl Desk {
    pub(super) fn new(scratch: &Path) -> std::io::Result<Desk> {
        let path = scratch.join("serve");
        fs::create_dir_all(path.join("work"))?;
        Ok(Desk(path))
    }

    pub(super) fn lay_down(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.join(name);
        // A file that cannot be written is found missing by the decoder.
        let _ = fs::write(&path, bytes);
        path
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        processes::kill_orphans(&self.0.join("work"));
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A process in serve mode.
pub(super) struct Dialog {
    child: Child,
    input: Option<ChildStdin>,
    output: Receiver<Vec<u8>>,
    unread: Vec<u8>,
    /// How long an answer is waited for.
    timeout: Duration,
}

/// The most bytes that are kept of its output.
const MAX_OUTPUT: usize = 1 << 20;

impl Dialog {
    #[expect(clippy::large_stack_arrays, reason = "a buffer of a pipe's size")]
    pub(super) fn start(calls: &Calls, desk: &Desk) -> std::io::Result<Dialog> {
        let workplace = desk.0.join("work");
        let command = calls.decoder.command();
        let mut serving = Command::new(&command[0]);
        serving
            .args(&command[1..])
            .arg("serve")
            .current_dir(&workplace)
            .env("LC_ALL", "C")
            .env("TZ", "UTC")
            .env("TMPDIR", &workplace)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .process_group(0);
        let mut child = processes::start(&mut serving)?;
        let input = child.stdin.take();
        let (sender, output) = channel();
        if let Some(mut stdout) = child.stdout.take() {
            // It ends with the pipe, or with this dialog.
            std::thread::spawn(move || {
                let mut buffer = [0; 65_536];
                let mut kept = 0;
                while let Ok(count @ 1..) = stdout.read(&mut buffer) {
                    kept += count;
                    if kept > MAX_OUTPUT || sender.send(buffer[..count].to_vec()).is_err() {
                        break;
                    }
                }
            });
        }
        Ok(Dialog {
            child,
            input,
            output,
            unread: Vec::new(),
            timeout: calls.decoder.timeout,
        })
    }

    pub(super) fn ask(&mut self, sequence: u32, view: &View, path: &Path) -> Served {
        let request = format!("{sequence} {view} {}\n", path.display());
        if let Some(input) = &mut self.input {
            // A process that has gone is found gone below.
            let _ = input
                .write_all(request.as_bytes())
                .and_then(|()| input.flush());
        }
        let served = self.wait();
        match served {
            Served::Answer(answer) if !answer.line.starts_with(&format!("{sequence} ")) => {
                let line = format!("{:?}", answer.line);
                let slots: &Slots = &[("sequence", &sequence), ("line", &line)];
                Served::Wrong(fault("serve-sequence", slots))
            }
            served => served,
        }
    }

    /// Closes its input and waits for what it still answers, or for its end.
    pub(super) fn end(&mut self) -> Served {
        self.input = None;
        self.wait()
    }

    fn wait(&mut self) -> Served {
        let deadline = Instant::now() + self.timeout.min(A_YEAR);
        loop {
            if let Some(served) = self.whole_answer() {
                return served;
            }
            match self
                .output
                .recv_timeout(deadline.saturating_duration_since(Instant::now()))
            {
                Ok(bytes) => self.unread.extend(bytes),
                Err(RecvTimeoutError::Timeout) => return Served::Nothing,
                Err(RecvTimeoutError::Disconnected) => {
                    while Instant::now() < deadline {
                        if let Ok(Some(status)) = self.child.try_wait() {
                            return Served::Gone(status.success());
                        }
                        std::thread::sleep(Duration::from_millis(5));
                    }
                    return Served::Nothing;
                }
            }
        }
    }

    /// An answer, if all of it is there.
    fn whole_answer(&mut self) -> Option<Served> {
        let end = self.unread.iter().position(|&byte| byte == b'\n')?;
        let line = String::from_utf8_lossy(&self.unread[..end]).into_owned();
        let words: Vec<&str> = line.split(' ').collect();
        let wrong = |name| {
            Some(Served::Wrong(fault(
                name,
                &[("line", &format!("{line:?}"))],
            )))
        };
        let size = match words[..] {
            [_, "ok", size] => match size.parse::<usize>() {
                Ok(size) if size <= MAX_OUTPUT => size,
                _ => return wrong("serve-size"),
            },
            [_, "reject" | "unsupported", ..] => 0,
            _ => return wrong("serve-words"),
        };
        if self.unread.len() < end + 1 + size {
            return None;
        }
        let bytes = self.unread[end + 1..end + 1 + size].to_vec();
        self.unread.drain(..end + 1 + size);
        Some(Served::Answer(ServedAnswer { line, bytes }))
    }
}

impl Drop for Dialog {
    fn drop(&mut self) {
        // An error means that nobody is left.
        let _ = kill_process_group(Pid::from_child(&self.child), Signal::KILL);
        let _ = self.child.kill();
        let _ = self.child.wait();
        processes::has_been_waited_for(self.child.id());
    }
}
