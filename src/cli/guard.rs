//! The environment of a run: its directories, its signals, and a watcher that cleans up if it is killed.

use std::io;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use signal_hook::consts::{SIGCHLD, SIGINT, SIGTERM, SIGXFSZ};

use ptm_conform::runner::processes::{self, Descendants};
use ptm_conform::runner::run::Decoder;
use ptm_conform::runner::scratch::{Scratch, remove_directory};

/// The directories of a run, and a process that cleans up if this one is killed.
pub struct Guarded {
    /// The directories.
    pub scratch: Scratch,
    watcher: Option<Child>,
}

impl Guarded {
    /// Makes new directories, and starts a watcher over them.
    pub fn new() -> Result<Guarded, String> {
        let scratch = Scratch::new().map_err(|error| format!("no scratch directory: {error}"))?;
        // Without a watcher, a decoder that runs when this process is killed would be orphaned.
        let watcher = std::env::current_exe().and_then(|program| {
            let mut command = Command::new(program);
            command
                .arg("watch")
                .arg(std::process::id().to_string())
                .args(scratch.directories())
                .stdin(Stdio::piped())
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .process_group(0);
            processes::start(&mut command)
        });
        Ok(Guarded {
            scratch,
            watcher: watcher.ok(),
        })
    }
}

impl Drop for Guarded {
    fn drop(&mut self) {
        processes::kill_all(self.scratch.work_directory());
        if let Some(watcher) = &mut self.watcher {
            drop(watcher.stdin.take());
            let _ = watcher.wait();
        }
    }
}

/// The interval at which the watcher looks for orphaned processes.
const POLL_INTERVAL: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 100_000_000,
};

/// Runs the watcher: waits until its standard input ends, when the run is over or dead, and cleans up.
///
/// Processes that work in the directories are found there. A process that hides its directory is known only as a child of the
/// run, which inherits it; so the watcher examines these children until the end.
pub fn watch(run: u32, directories: &[PathBuf]) -> u8 {
    let stdin = io::stdin();
    let mut children = Descendants::default();
    loop {
        let mut input = [PollFd::new(&stdin, PollFlags::IN)];
        match poll(&mut input, Some(&POLL_INTERVAL)) {
            Ok(0) => children = Descendants::new(run),
            Ok(_) => break,
            Err(_) => std::thread::sleep(Duration::from_millis(100)),
        }
    }
    children.kill();
    for directory in directories {
        processes::kill_all(directory);
        remove_directory(directory);
    }
    0
}

/// Checks that this program could do its part of a run. The error says why the run was stopped, without a verdict.
pub fn check_trouble(decoder: &Decoder) -> Result<(), String> {
    match decoder.trouble() {
        None => Ok(()),
        Some(trouble) => Err(format!(
            "{trouble}. This is not the decoder's fault. The run ended without a verdict"
        )),
    }
}

/// Resets two signals that may be inherited. A program that is started with SIGCHLD ignored cannot wait for its children; one
/// that reaches a limit on file sizes is killed silently. Child processes get the default behavior for both.
pub fn take_signals() {
    for signal in [SIGCHLD, SIGXFSZ] {
        // If a signal handler cannot be installed, the signal stays as it was.
        let _ = signal_hook::flag::register(signal, Arc::default());
    }
}

/// Returns a flag that is set when the user ends the run.
pub fn stop_on_signals() -> Result<Arc<AtomicBool>, String> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .map_err(|error| format!("no signals: {error}"))?;
    }
    Ok(stop)
}
