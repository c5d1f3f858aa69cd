//! Environment of a run: scratch directories, signals, and a watcher that cleans up if the run is killed.

use std::io;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use signal_hook::consts::{SIGCHLD, SIGINT, SIGTERM, SIGXFSZ};

use ptm_harness::runner::processes::{self, Children};
use ptm_harness::runner::run::Decoder;
use ptm_harness::runner::scratch::{Scratch, remove_directory};

/// Scratch directories of a run and a watcher process that cleans up if this process is killed.
pub struct ScratchGuard {
    /// Scratch directories.
    pub scratch: Scratch,
    watcher: Option<Child>,
}

impl ScratchGuard {
    /// Creates the directories and starts the watcher.
    pub fn new() -> Result<ScratchGuard, String> {
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
        let watcher = watcher.ok();
        Ok(ScratchGuard { scratch, watcher })
    }
}

impl Drop for ScratchGuard {
    fn drop(&mut self) {
        processes::kill_all(self.scratch.work_directory());
        if let Some(watcher) = &mut self.watcher {
            drop(watcher.stdin.take());
            let _ = watcher.wait();
        }
    }
}

/// Interval at which the watcher lists the descendants of the run.
const POLL_INTERVAL: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 100_000_000,
};

/// Runs the watcher. Waits for the end of standard input, which means that the run has ended, and then cleans up.
///
/// Processes are found by their working directories. A process with a hidden working directory is known only as a
/// descendant of the run, so the watcher tracks these descendants until the run ends.
pub fn watch(run: u32, directories: &[PathBuf]) -> u8 {
    let stdin = io::stdin();
    let mut children = Children::default();
    loop {
        let mut input = [PollFd::new(&stdin, PollFlags::IN)];
        match poll(&mut input, Some(&POLL_INTERVAL)) {
            Ok(0) => children = Children::new(run),
            Ok(_) => break,
            Err(_) => std::thread::sleep(Duration::from_millis(100)),
        }
    }
    children.kill();
    for directory in directories {
        processes::kill_all(directory);
        remove_directory(directory);
        // A process that was just being started has already entered the directory, so that it is found now, or cannot enter it any
        // more, and ends.
        processes::kill_all(directory);
    }
    0
}

/// Returns an error if the run ended without a verdict because of a problem with this program, not with the decoder.
pub fn check_for_trouble(decoder: &Decoder) -> Result<(), String> {
    match decoder.trouble() {
        None => Ok(()),
        Some(trouble) => Err(trouble_message(trouble)),
    }
}

/// Returns the message for a problem with this program that ended a run.
pub fn trouble_message(trouble: &str) -> String {
    format!("{trouble}. This is not the decoder's fault. The run ended without a verdict")
}

/// Installs handlers for two signals whose inherited dispositions cause problems. A process that ignores SIGCHLD cannot wait for
/// its children, and a process that exceeds a file size limit is killed silently by SIGXFSZ. Child processes get the default
/// disposition for both.
pub fn override_signal_dispositions() {
    for signal in [SIGCHLD, SIGXFSZ] {
        // If a signal handler cannot be installed, the disposition stays unchanged.
        let _ = signal_hook::flag::register(signal, Arc::default());
    }
}

/// Returns a flag that is set when the user interrupts the run.
pub fn stop_on_signals() -> Result<Arc<AtomicBool>, String> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        let registered = signal_hook::flag::register(signal, Arc::clone(&stop));
        registered.map_err(|error| format!("cannot install signal handlers: {error}"))?;
    }
    Ok(stop)
}
