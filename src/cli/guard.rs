//! Somebody else's programs under guard: the directories of a run, and who clears up should it be killed or stopped.

use std::io;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{SIGINT, SIGTERM};

use ptm_conform::harness::processes;
use ptm_conform::harness::scratch::{Scratch, remove};

/// The directories of a run, and a process that clears up should this one be killed.
pub struct Guarded {
    /// The directories.
    pub scratch: Scratch,
    watcher: Option<Child>,
}

impl Guarded {
    /// New directories, and a watcher over them.
    pub fn new() -> Result<Guarded, String> {
        let scratch = Scratch::new().map_err(|error| format!("no scratch directory: {error}"))?;
        // A decoder that is at work when this process is killed would be nobody's; without a watcher it only stays.
        let watcher = std::env::current_exe().and_then(|program| {
            let mut command = Command::new(program);
            command
                .arg("watch")
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
        processes::kill_all(self.scratch.works());
        if let Some(watcher) = &mut self.watcher {
            drop(watcher.stdin.take());
            let _ = watcher.wait();
        }
    }
}

/// The watcher: waits until its standard input ends, which it does when the run is over or dead, and clears up.
pub fn watch(directories: &[PathBuf]) -> u8 {
    let _ = io::copy(&mut io::stdin(), &mut io::sink());
    for directory in directories {
        processes::kill_all(directory);
        remove(directory);
    }
    0
}

/// A flag that is set when the user wants the run to end.
pub fn stop_on_signals() -> Result<Arc<AtomicBool>, String> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .map_err(|error| format!("no signals: {error}"))?;
    }
    Ok(stop)
}
