//! The files of a collection: named files, those of a list, and those in folders.
//!
//! A collection of any size is walked in bounded memory: only a limited number of names of a folder are read at a time, and
//! links inside folders are not followed, so a walk cannot loop.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::fs::{self, FileType, ReadDir};
use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};
use std::sync::{Condvar, Mutex};

#[cfg(unix)]
use super::files::is_named_pipe;
use super::files::path_of;
use ptm_conform::ptm::Format;
use ptm_conform::tools::dissection::Dissection;

/// Number of names of a folder that are read and sorted at a time.
const NAMES_PER_READ: usize = 4096;
/// Maximum length of a line of a list.
const MAX_PATH: u64 = 1 << 16;
/// Number of bytes that always contain the first lines of a PTM, and their number: version, format, width and height.
const FIRST_LINES: usize = 256;
const LINES: usize = 4;

const NO_FILE: &str = "neither a file nor a folder";

/// An item of a walk.
pub enum Met {
    /// A file, or a path that was named as one.
    File(PathBuf),
    /// Something that is skipped, with the reason.
    Skipped(PathBuf, &'static str),
    /// Something that cannot be read, with the error.
    Unreadable(PathBuf, io::Error),
}

/// A named path, and its origin.
pub enum FileSource {
    /// From the command line: read whatever its type, even if it is a pipe.
    Directly(PathBuf),
    /// From a list.
    Listed(PathBuf),
}

/// The entries of a folder.
type Entries = Box<dyn Iterator<Item = io::Result<(OsString, FileType)>> + Send>;

/// A step of a walk; the error is a folder to enter.
type WalkStep = Result<Met, PathBuf>;

/// Returns all named files, and the files of folders; with `recursive` those of the folders inside too.
pub fn walk(
    mut named: impl Iterator<Item = FileSource> + Send,
    recursive: bool,
) -> impl Iterator<Item = Met> + Send {
    let mut folders: Vec<(PathBuf, Entries)> = Vec::new();
    std::iter::from_fn(move || {
        loop {
            let step = match folders.last_mut() {
                None => meet_named(named.next()?),
                Some((path, entries)) => {
                    let Some(entry) = entries.next() else {
                        folders.pop();
                        continue;
                    };
                    meet(path, entry)
                }
            };
            match step {
                Ok(met) => return Some(met),
                Err(_) if !recursive && !folders.is_empty() => {}
                Err(path) => match fs::read_dir(&path) {
                    Ok(folder) => folders.push((path, Box::new(sorted(folder)))),
                    Err(error) => return Some(Met::Unreadable(path, error)),
                },
            }
        }
    })
}

/// Classifies a named path; links are followed.
fn meet_named(named: FileSource) -> WalkStep {
    let is_listed = matches!(named, FileSource::Listed(_));
    let (FileSource::Directly(path) | FileSource::Listed(path)) = named;
    match fs::metadata(&path) {
        Ok(data) if data.is_dir() => Err(path),
        // Opening a named pipe would block until its writer opens it.
        #[cfg(unix)]
        _ if is_named_pipe(&path) => Ok(Met::Skipped(path, NO_FILE)),
        Ok(data) if is_listed && !data.is_file() => Ok(Met::Skipped(path, NO_FILE)),
        _ => Ok(Met::File(path)),
    }
}

/// Classifies an entry of a folder.
fn meet(folder: &Path, entry: io::Result<(OsString, FileType)>) -> WalkStep {
    match entry {
        Ok((name, kind)) if kind.is_symlink() => {
            let why = "a symbolic link, which is not followed";
            Ok(Met::Skipped(folder.join(name), why))
        }
        Ok((name, kind)) if kind.is_file() => Ok(Met::File(folder.join(name))),
        Ok((name, kind)) if kind.is_dir() => Err(folder.join(name)),
        Ok((name, _)) => Ok(Met::Skipped(folder.join(name), NO_FILE)),
        Err(error) => Ok(Met::Unreadable(folder.to_owned(), error)),
    }
}

/// Returns the entries of a folder, sorted by name in chunks. The folder is closed as soon as all names are read, so that a
/// deep walk keeps no folder open.
fn sorted(folder: ReadDir) -> impl Iterator<Item = io::Result<(OsString, FileType)>> + Send {
    let (mut folder, mut chunk) = (
        Some(folder),
        VecDeque::<io::Result<(OsString, FileType)>>::new(),
    );
    std::iter::from_fn(move || {
        if chunk.is_empty()
            && let Some(open) = &mut folder
        {
            let named = |entry: io::Result<fs::DirEntry>| {
                let entry = entry?;
                Ok((entry.file_name(), entry.file_type()?))
            };
            chunk.extend(open.take(NAMES_PER_READ).map(named));
            // Unreadable ones first.
            chunk.make_contiguous().sort_by(|a, b| match (a, b) {
                (Ok((a, _)), Ok((b, _))) => a.cmp(b),
                (a, b) => a.is_ok().cmp(&b.is_ok()),
            });
            if chunk.len() < NAMES_PER_READ {
                folder = None;
            }
        }
        chunk.pop_front()
    })
}

/// Returns the paths of a list, each ended by `end`; a line that is too long for a path ends the list.
pub fn paths(mut list: impl BufRead + Send, end: u8) -> impl Iterator<Item = PathBuf> + Send {
    std::iter::from_fn(move || {
        loop {
            let mut line = Vec::new();
            let read = list.by_ref().take(MAX_PATH).read_until(end, &mut line);
            if !matches!(read, Ok(1..)) {
                return None;
            }
            if line.last() == Some(&end) {
                line.pop();
            }
            if !line.is_empty() {
                return Some(path_of(line));
            }
        }
    })
}

/// Returns the memory that is needed for a PTM of this length and its planes.
pub fn memory_for(beginning: &[u8], length: u64) -> u64 {
    let mut words = beginning.windows(4).take(FIRST_LINES);
    // Only compressed planes are much larger than their file.
    if !words.any(|word| word == b"JPEG") {
        return length.saturating_mul(2);
    }
    let head = &beginning[..beginning.len().min(FIRST_LINES)];
    let mut line_ends = (1..).zip(head).filter(|&(_, &byte)| byte == b'\n');
    let end = line_ends.nth(LINES - 1).map_or(head.len(), |(end, _)| end);
    let head = Dissection::parse(&head[..end]);
    let texels = head.size.map_or(0, |size| size.texels() as u64);
    let planes = texels.saturating_mul(head.format.map_or(0, Format::channels) as u64);
    // The decoded streams, and the texels that are made from them.
    length.saturating_add(planes.saturating_mul(2))
}

/// Memory that all workers share: a worker that needs more than is free waits.
pub struct Room {
    all: u64,
    left: Mutex<u64>,
    freed: Condvar,
}

impl Room {
    /// Makes a pool of `all` bytes.
    pub fn new(all: u64) -> Room {
        Room {
            all,
            left: Mutex::new(all),
            freed: Condvar::new(),
        }
    }

    /// Does `work` as soon as `bytes` are free, or all bytes if it needs more.
    pub fn run_with<T>(&self, bytes: u64, work: impl FnOnce() -> T) -> T {
        const LOCK_NOT_POISONED: &str = "no thread panics while it holds the lock";
        let bytes = bytes.min(self.all);
        let left = self.left.lock().expect(LOCK_NOT_POISONED);
        let left = self.freed.wait_while(left, |left| *left < bytes);
        *left.expect(LOCK_NOT_POISONED) -= bytes;
        let done = work();
        *self.left.lock().expect(LOCK_NOT_POISONED) += bytes;
        self.freed.notify_all();
        done
    }
}
