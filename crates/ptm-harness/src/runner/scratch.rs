//! Temporary directories for inputs and decoders. A run removes its directories when it ends.
//!
//! If `TMPDIR` is not set, and there is an in-memory file system with enough space, inputs are written to it to avoid waiting for
//! a disk. Decoders have their working directory and `TMPDIR` in the usual directory for temporary files, because an in-memory
//! file system may forbid execution.

use std::fs;
use std::io::{self, Read, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use rustix::fs::OFlags;
use rustix::io::Errno;
use tempfile::TempDir;

use crate::runner::trouble::{Trouble, is_file_system_error};

/// An in-memory file system, on systems that have one.
const MEMORY_DIRECTORY: &str = "/dev/shm";

/// Minimum free space, in bytes, on the file system that contains a decoder's working directory.
const MIN_FREE_BYTES: u64 = 64 << 20;

/// Directories of a run, each on a different file system.
#[derive(Debug)]
pub struct Scratch {
    /// Directories for inputs, in order of preference. The first one with enough space is used.
    roots: Vec<TempDir>,
    /// Index of the root for working directories.
    work_root: usize,
    /// Working directories that can be reused, because the previous process left them empty.
    free: Mutex<Vec<PathBuf>>,
    next: AtomicU64,
}

impl Scratch {
    /// Creates the directories: in `TMPDIR` if it is set, or else in memory and in `/tmp`. Also creates directories on other file
    /// systems, for files that do not fit.
    ///
    /// # Errors
    /// Returns an error if no directory can be created.
    pub fn new() -> io::Result<Scratch> {
        let usual = std::env::temp_dir();
        let others = ["/var/tmp", "/tmp"].map(PathBuf::from);
        let candidates = match std::env::var_os("TMPDIR") {
            Some(_) => [&[usual][..], &others, &[MEMORY_DIRECTORY.into()]].concat(),
            None => [&[MEMORY_DIRECTORY.into(), usual][..], &others].concat(),
        };
        let mut roots: Vec<TempDir> = Vec::new();
        let mut failure = None;
        for parent in candidates {
            let device = |path: &Path| fs::metadata(path).map(|about| about.dev()).ok();
            let is_new = |root: &TempDir| device(root.path()) != device(&parent);
            if roots.iter().all(is_new) {
                let mut name = tempfile::Builder::new();
                match name.prefix("ptm-conform-").tempdir_in(&parent) {
                    Ok(root) => roots.push(root),
                    Err(error) => failure = failure.or(Some(error)),
                }
            }
        }
        if roots.is_empty() {
            return Err(failure.unwrap_or_else(|| io::ErrorKind::NotFound.into()));
        }
        Ok(Scratch {
            work_root: find_work_root(&roots),
            roots,
            free: Mutex::default(),
            next: AtomicU64::new(0),
        })
    }

    /// Returns all root directories.
    pub fn directories(&self) -> impl Iterator<Item = &Path> {
        self.roots.iter().map(TempDir::path)
    }

    /// Returns the directory that contains the working directories of decoders.
    #[must_use]
    pub fn work_directory(&self) -> &Path {
        self.roots[self.work_root].path()
    }

    /// Creates a workspace for one process.
    pub(crate) fn workspace(&self) -> Result<Workspace<'_>, Trouble> {
        let name = self.next.fetch_add(1, Ordering::Relaxed).to_string();
        let known = self.free.lock().expect("nothing panics here").pop();
        let work_dir = if let Some(work_dir) = known {
            work_dir
        } else {
            let work_dir = self.work_directory().join(format!("work-{name}"));
            fs::create_dir_all(&work_dir).map_err(|error| {
                let task = format!(
                    "create a working directory in {}",
                    self.work_directory().display()
                );
                Trouble::new(&task, &error)
            })?;
            work_dir
        };
        Ok(Workspace {
            scratch: self,
            name,
            directories: Vec::new(),
            work_dir,
        })
    }
}

/// Returns the index of the first root on disk with enough free space. Uses memory only if no root is on disk, because an
/// in-memory file system may forbid execution.
fn find_work_root(roots: &[TempDir]) -> usize {
    let has_room = |root: &TempDir| {
        rustix::fs::statvfs(root.path())
            .is_ok_and(|system| system.f_bavail.saturating_mul(system.f_frsize) >= MIN_FREE_BYTES)
    };
    let on_disk = |&i: &usize| !roots[i].path().starts_with(MEMORY_DIRECTORY);
    (0..roots.len())
        .filter(on_disk)
        .find(|&i| has_room(&roots[i]))
        .or_else(|| (0..roots.len()).find(on_disk))
        .unwrap_or_default()
}

impl Drop for Scratch {
    fn drop(&mut self) {
        for directory in self.directories() {
            remove_directory(directory);
        }
    }
}

/// The private directories of one process. Leftover files in them do not affect other processes.
pub(crate) struct Workspace<'a> {
    scratch: &'a Scratch,
    name: String,
    /// Directories for inputs, one in each root that was needed.
    directories: Vec<PathBuf>,
    /// Working directory of the process.
    pub(crate) work_dir: PathBuf,
}

impl Workspace<'_> {
    /// Writes a read-only input file to the first root with enough space.
    pub fn write_input(&mut self, file_name: &str, bytes: &[u8]) -> Result<PathBuf, Trouble> {
        let mut failure = None;
        for root in self.scratch.directories() {
            let directory = root.join(&self.name);
            let path = directory.join(file_name);
            if !self.directories.contains(&directory) {
                self.directories.push(directory.clone());
            }
            // Usually, the directory exists.
            let written = write_read_only(&path, bytes).or_else(|_| {
                fs::create_dir_all(&directory)?;
                let _ = fs::remove_file(&path);
                write_read_only(&path, bytes)
            });
            match written {
                Ok(()) => return Ok(path),
                Err(error) => {
                    let _ = fs::remove_file(&path);
                    let may_retry = is_file_system_error(&error);
                    failure = failure.or(Some((root, error)));
                    if !may_retry {
                        break;
                    }
                }
            }
        }
        let (root, error) = failure.expect("the root directory exists");
        let task = format!(
            "write an input of {} bytes in {}",
            bytes.len(),
            root.display()
        );
        Err(Trouble::new(&task, &error))
    }

    /// Removes the directories of inputs from `text`, so that reports contain file names but no temporary directories.
    pub(crate) fn strip_directories(&self, text: &str) -> String {
        let directories = self.directories.iter();
        directories.fold(text.to_owned(), |text, directory| {
            text.replace(&format!("{}/", directory.display()), "")
        })
    }
}

impl Drop for Workspace<'_> {
    fn drop(&mut self) {
        // Files that cannot be removed remain. They do not affect the answer.
        for directory in &self.directories {
            remove_directory(directory);
        }
        if is_unchanged_directory(&self.work_dir) {
            let mut free = self.scratch.free.lock().expect("nothing panics here");
            free.push(std::mem::take(&mut self.work_dir));
        } else {
            remove_directory(&self.work_dir);
        }
    }
}

fn write_read_only(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = fs::OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(0o444)
        .open(path)?;
    file.write_all(bytes)
}

/// Returns true if an input is unchanged. A decoder may have replaced it with a pipe or a link, and may still be changing it.
pub(crate) fn is_unchanged(path: &Path, bytes: &[u8]) -> Result<bool, Trouble> {
    let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK;
    let open = fs::OpenOptions::new()
        .read(true)
        .custom_flags(flags.bits().cast_signed())
        .open(path);
    let file = match open {
        Ok(file) => file,
        Err(error) => {
            let ours = [Errno::MFILE, Errno::NFILE, Errno::NOMEM, Errno::IO];
            return match Errno::from_io_error(&error) {
                Some(errno) if ours.contains(&errno) => {
                    Err(Trouble::new("read an input again", &error))
                }
                _ => Ok(false),
            };
        }
    };
    let same_kind = file
        .metadata()
        .is_ok_and(|file| file.is_file() && file.len() == bytes.len() as u64);
    let mut read = Vec::with_capacity(bytes.len() + 1);
    Ok(same_kind
        && file
            .take(bytes.len() as u64 + 1)
            .read_to_end(&mut read)
            .is_ok_and(|_| read == bytes))
}

/// Returns true if `directory` is still an empty directory to which its owner has full access.
fn is_unchanged_directory(directory: &Path) -> bool {
    let ours = |file: fs::Metadata| file.is_dir() && file.permissions().mode() & 0o700 == 0o700;
    fs::symlink_metadata(directory).is_ok_and(ours)
        && fs::read_dir(directory).is_ok_and(|mut entries| entries.next().is_none())
}

/// Removes a directory and its contents, even if a decoder has changed their permissions. Leaves anything that cannot be removed.
pub fn remove_directory(directory: &Path) {
    if fs::remove_dir_all(directory).is_err() {
        restore_permissions(directory);
        let _ = fs::remove_dir_all(directory);
    }
}

/// Restores the permissions of a directory and all directories below it. Does not follow links.
fn restore_permissions(directory: &Path) {
    let is_directory = |path: &Path| fs::symlink_metadata(path).is_ok_and(|file| file.is_dir());
    if is_directory(directory) {
        let _ = fs::set_permissions(directory, fs::Permissions::from_mode(0o700));
        for entry in fs::read_dir(directory).into_iter().flatten().flatten() {
            restore_permissions(&entry.path());
        }
    }
}
