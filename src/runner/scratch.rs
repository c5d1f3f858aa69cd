//! Directories for inputs and for decoders, used by one run only and removed when it is over.
//!
//! Inputs are written to a file system in memory if there is one and the file fits, because that needs no wait for a disk.
//! Decoders work, and have their `TMPDIR`, in the usual place for temporary files, because programs may be started from there.

use std::fs;
use std::io::{self, Read, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use rustix::fs::OFlags;
use rustix::io::Errno;
use tempfile::TempDir;

use crate::runner::trouble::{Trouble, is_lack_of_room};

/// A file system in memory, on systems that have one.
const MEMORY_DIRECTORY: &str = "/dev/shm";

/// Minimum number of free bytes in the working directory of a decoder.
const MIN_FREE_BYTES: u64 = 64 << 20;

/// The directories of a run, each on a different file system.
#[derive(Debug)]
pub struct Scratch {
    /// Directories for inputs, best first; the first one that has room is used.
    roots: Vec<TempDir>,
    /// Index of the root that decoders work in.
    works: usize,
    /// Workplaces that were left unchanged.
    free: Mutex<Vec<PathBuf>>,
    next: AtomicU64,
}

impl Scratch {
    /// Makes the directories: in `TMPDIR` if it is set, else in memory and in `/tmp`; on other file systems too, for files that
    /// do not fit there.
    ///
    /// # Errors
    /// Errors of the file system, if no directory can be made.
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
            works: place_to_work(&roots),
            roots,
            free: Mutex::default(),
            next: AtomicU64::new(0),
        })
    }

    /// Returns all directories.
    pub fn directories(&self) -> impl Iterator<Item = &Path> {
        self.roots.iter().map(TempDir::path)
    }

    /// Returns the directory in which decoders work.
    #[must_use]
    pub fn works(&self) -> &Path {
        self.roots[self.works].path()
    }

    /// Returns a place for one process.
    pub(crate) fn workspace(&self) -> Result<Workspace<'_>, Trouble> {
        let name = self.next.fetch_add(1, Ordering::Relaxed).to_string();
        let known = self.free.lock().expect("nothing panics here").pop();
        let workplace = if let Some(workplace) = known {
            workplace
        } else {
            let workplace = self.works().join(format!("work-{name}"));
            fs::create_dir_all(&workplace).map_err(|error| {
                let what = format!("make a working directory in {}", self.works().display());
                Trouble::new(&what, &error)
            })?;
            workplace
        };
        Ok(Workspace {
            scratch: self,
            name,
            directories: Vec::new(),
            workplace,
        })
    }
}

/// Returns the first root outside memory with enough free space; memory may not be executable, so it comes last.
fn place_to_work(roots: &[TempDir]) -> usize {
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
            remove(directory);
        }
    }
}

/// Directories for one process, which no other process uses, so that files that it leaves there affect no other.
pub(crate) struct Workspace<'a> {
    scratch: &'a Scratch,
    name: String,
    /// The directories of its inputs, one in each root that was needed.
    directories: Vec<PathBuf>,
    /// Its working directory.
    pub(crate) workplace: PathBuf,
}

impl Workspace<'_> {
    /// Writes an input, read-only, to the first root with room for it.
    pub(crate) fn lay_down(&mut self, file_name: &str, bytes: &[u8]) -> Result<PathBuf, Trouble> {
        let mut failure = None;
        for root in self.scratch.directories() {
            let directory = root.join(&self.name);
            let path = directory.join(file_name);
            if !self.directories.contains(&directory) {
                self.directories.push(directory.clone());
            }
            match fs::create_dir_all(&directory).and_then(|()| write_read_only(&path, bytes)) {
                Ok(()) => return Ok(path),
                Err(error) => {
                    let _ = fs::remove_file(&path);
                    let go_on = is_lack_of_room(&error);
                    failure = failure.or(Some((root, error)));
                    if !go_on {
                        break;
                    }
                }
            }
        }
        let (root, error) = failure.expect("the root directory exists");
        let what = format!(
            "write an input of {} bytes in {}",
            bytes.len(),
            root.display()
        );
        Err(Trouble::new(&what, &error))
    }

    /// Returns `text` without the directories of its inputs: reports have file names, but not temporary directories.
    pub(crate) fn without_directories(&self, text: &str) -> String {
        let directories = self.directories.iter();
        directories.fold(text.to_owned(), |text, directory| {
            text.replace(&format!("{}/", directory.display()), "")
        })
    }
}

impl Drop for Workspace<'_> {
    fn drop(&mut self) {
        // Files that cannot be removed stay; the answer is not affected.
        for directory in &self.directories {
            remove(directory);
        }
        if is_untouched_directory(&self.workplace) {
            let mut free = self.scratch.free.lock().expect("nothing panics here");
            free.push(std::mem::take(&mut self.workplace));
        } else {
            remove(&self.workplace);
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

/// Returns true if an input is unchanged. It may have become a pipe, a link or anything else, and may still change.
pub(crate) fn is_untouched(path: &Path, bytes: &[u8]) -> Result<bool, Trouble> {
    let carefully = OFlags::NOFOLLOW | OFlags::NONBLOCK;
    let open = fs::OpenOptions::new()
        .read(true)
        .custom_flags(carefully.bits().cast_signed())
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

/// Returns true if it is still an empty directory with our owner and mode.
fn is_untouched_directory(directory: &Path) -> bool {
    let ours = |file: fs::Metadata| file.is_dir() && file.permissions().mode() & 0o700 == 0o700;
    fs::symlink_metadata(directory).is_ok_and(ours)
        && fs::read_dir(directory).is_ok_and(|mut entries| entries.next().is_none())
}

/// Removes a directory and its contents, even if a decoder has locked some. What cannot be removed stays.
pub fn remove(directory: &Path) {
    if fs::remove_dir_all(directory).is_err() {
        unlock(directory);
        let _ = fs::remove_dir_all(directory);
    }
}

/// Restores the permissions of all directories below this one; links are not followed.
fn unlock(directory: &Path) {
    let is_directory = |path: &Path| fs::symlink_metadata(path).is_ok_and(|file| file.is_dir());
    if is_directory(directory) {
        let _ = fs::set_permissions(directory, fs::Permissions::from_mode(0o700));
        for entry in fs::read_dir(directory).into_iter().flatten().flatten() {
            unlock(&entry.path());
        }
    }
}
