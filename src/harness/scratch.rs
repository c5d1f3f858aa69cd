//! Where inputs lie and decoders work: directories that nobody else uses, gone when the run is over.
//!
//! Inputs lie in memory where the system has a place for that; files come and go there without waiting for a disk.
//! Decoders work, and have their `TMPDIR`, where temporary files usually go: programs may be started from there.

use std::fs;
use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use tempfile::TempDir;

/// A place in memory, where there is one.
const MEMORY: &str = "/dev/shm";

/// The directories of a run.
#[derive(Debug)]
pub struct Scratch {
    inputs: TempDir,
    works: TempDir,
    /// Directories that were left as they were found.
    free: Mutex<Vec<PathBuf>>,
    next: AtomicU64,
}

impl Scratch {
    /// Makes the directories.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn new() -> io::Result<Scratch> {
        let mut name = tempfile::Builder::new();
        let name = name.prefix("ptm-conform-");
        // Who says where temporary files go means all of them.
        let chosen = std::env::var_os("TMPDIR").is_some();
        let in_memory = name.tempdir_in(MEMORY).ok().filter(|_| !chosen);
        Ok(Scratch {
            inputs: in_memory.map_or_else(|| name.tempdir(), Ok)?,
            works: name.tempdir()?,
            free: Mutex::default(),
            next: AtomicU64::new(0),
        })
    }

    /// Both directories: that of the inputs, and that in which decoders work.
    #[must_use]
    pub fn directories(&self) -> [&Path; 2] {
        [self.inputs.path(), self.works.path()]
    }

    /// Where decoders work.
    #[must_use]
    pub fn works(&self) -> &Path {
        self.works.path()
    }

    /// A place for one process.
    pub(super) fn place(&self) -> io::Result<Place<'_>> {
        let name = self.next.fetch_add(1, Ordering::Relaxed).to_string();
        let directory = self.inputs.path().join(&name);
        fs::create_dir_all(&directory)?;
        let known = self.free.lock().expect("nothing panics here").pop();
        let workplace = match known {
            Some(workplace) => workplace,
            None => {
                let workplace = self.works.path().join(&name);
                fs::create_dir_all(&workplace)?;
                workplace
            }
        };
        Ok(Place {
            scratch: self,
            directory,
            workplace,
        })
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        for directory in self.directories() {
            remove(directory);
        }
    }
}

/// Directories for one process: what one leaves behind, even if it cannot be removed, meets no other.
pub(super) struct Place<'a> {
    scratch: &'a Scratch,
    /// Where its input lies.
    pub(super) directory: PathBuf,
    /// Where it works.
    pub(super) workplace: PathBuf,
}

impl Drop for Place<'_> {
    fn drop(&mut self) {
        // What cannot be removed stays: it is no fault of the answer.
        remove(&self.directory);
        if is_untouched(&self.workplace) {
            let mut free = self.scratch.free.lock().expect("nothing panics here");
            free.push(std::mem::take(&mut self.workplace));
        } else {
            remove(&self.workplace);
        }
    }
}

/// Whether it is still an empty directory, and ours.
fn is_untouched(directory: &Path) -> bool {
    let ours = |file: fs::Metadata| file.is_dir() && file.permissions().mode() & 0o700 == 0o700;
    fs::symlink_metadata(directory).is_ok_and(ours)
        && fs::read_dir(directory).is_ok_and(|mut entries| entries.next().is_none())
}

/// Removes a directory, and what a decoder has locked in it; what cannot be removed stays.
pub fn remove(directory: &Path) {
    if fs::remove_dir_all(directory).is_err() {
        unlock(directory);
        let _ = fs::remove_dir_all(directory);
    }
}

/// Makes all directories below this one ours again; links are not followed.
fn unlock(directory: &Path) {
    let is_directory = |path: &Path| fs::symlink_metadata(path).is_ok_and(|file| file.is_dir());
    if is_directory(directory) {
        let _ = fs::set_permissions(directory, fs::Permissions::from_mode(0o700));
        for entry in fs::read_dir(directory).into_iter().flatten().flatten() {
            unlock(&entry.path());
        }
    }
}
