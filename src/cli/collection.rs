//! Files of a collection, named on the command line or in a list, or found in folders.
//!
//! Collections of any size are walked in bounded memory: the names in a folder are read in chunks of limited size. Links inside
//! folders are not followed, so a walk cannot loop.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::fs::{self, File, FileType, ReadDir};
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::{Condvar, Mutex};

#[cfg(unix)]
use super::files::is_named_pipe;
use super::files::path_from_bytes;
use ptm::Format;
use ptm_files::dissection::Dissection;
use ptm_files::lint::status::{MAGIC, is_named_ptm};

/// Number of folder entries that are read and sorted at a time.
const NAMES_PER_READ: usize = 4096;
/// Maximum length of a line in a list, in bytes.
const MAX_PATH_BYTES: u64 = 1 << 16;
/// Number of bytes that suffice for the version, format, width and height at the start of a PTM.
const SIZE_HEADER_BYTES: usize = 256;
/// Number of header lines up to and including the height.
const SIZE_HEADER_LINES: usize = 4;

/// Reason for skipping links in folders.
const SYMBOLIC_LINK: &str = "a symbolic link, which is not followed";

/// Reason for skipping devices, sockets and pipes.
const NOT_A_FILE: &str = "neither a file nor a folder";

/// Item yielded by [`walk`].
pub enum WalkItem {
    /// Named path to read.
    File(PathBuf),
    /// Regular file in a folder.
    Found(PathBuf),
    /// Path that is skipped, with the reason.
    Skipped(PathBuf, &'static str),
    /// Path that cannot be read, with the error.
    Unreadable(PathBuf, io::Error),
}

impl WalkItem {
    /// Returns the path.
    pub fn path(&self) -> &Path {
        match self {
            WalkItem::File(path)
            | WalkItem::Found(path)
            | WalkItem::Skipped(path, _)
            | WalkItem::Unreadable(path, _) => path,
        }
    }
}

/// Returns true if a file in a folder is named `.ptm` or begins like a PTM. A file that cannot be read is selected, so that this is
/// reported.
pub fn is_ptm_in_folder(path: &Path) -> bool {
    if is_named_ptm(&path.file_name().unwrap_or_default().to_string_lossy()) {
        return true;
    }
    let mut magic = [0; MAGIC.len()];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut magic));
    match read {
        Ok(()) => magic == *MAGIC,
        Err(error) => error.kind() != io::ErrorKind::UnexpectedEof,
    }
}

/// Returns the path of a file relative to the folder among `named` that contains it, or `None` if there is no such folder.
pub fn relative_to_named<'a>(named: &[PathBuf], path: &'a Path) -> Option<&'a Path> {
    let mut below = named
        .iter()
        .filter_map(|folder| path.strip_prefix(folder).ok());
    below.find(|path| !path.as_os_str().is_empty())
}

/// Returns the files and folders that are named on the command line, and those in the list on standard input, for which `-` stands.
pub fn named_sources(
    files: &[PathBuf],
    is_null_separated: bool,
) -> impl Iterator<Item = NamedPath> + Send {
    let end = if is_null_separated { 0 } else { b'\n' };
    let expand = move |path: &PathBuf| -> Box<dyn Iterator<Item = NamedPath> + Send> {
        match is_list(path) {
            true => Box::new(paths(BufReader::new(io::stdin()), end).map(|path| (path, true))),
            false => Box::new(std::iter::once((path.clone(), false))),
        }
    };
    files.iter().flat_map(expand)
}

/// Returns true if the path stands for the list on standard input.
pub fn is_list(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Path of a file or folder, and a flag that is true if the path comes from a list. Devices are read only if they are named on
/// the command line.
pub type NamedPath = (PathBuf, bool);

/// Step of a walk: an item, or (as the error) a folder to enter.
type WalkStep = Result<WalkItem, PathBuf>;

/// Name and type of a folder entry, or the error that occurred while reading it.
type FolderEntry = io::Result<(OsString, FileType)>;

/// Walks the files and folders in `paths`. Subfolders are included if `recursive` is true.
pub fn walk(
    mut paths: impl Iterator<Item = NamedPath> + Send,
    recursive: bool,
) -> impl Iterator<Item = WalkItem> + Send {
    let mut folders: Vec<(PathBuf, Box<dyn Iterator<Item = FolderEntry> + Send>)> = Vec::new();
    std::iter::from_fn(move || {
        loop {
            let step = match folders.last_mut() {
                None => classify_named_path(paths.next()?),
                Some((path, entries)) => {
                    let Some(entry) = entries.next() else {
                        folders.pop();
                        continue;
                    };
                    classify_entry(path, entry)
                }
            };
            match step {
                Ok(item) => return Some(item),
                Err(_) if !recursive && !folders.is_empty() => {}
                Err(path) => match fs::read_dir(&path) {
                    Ok(folder) => folders.push((path, Box::new(sorted_entries(folder)))),
                    Err(error) => return Some(WalkItem::Unreadable(path, error)),
                },
            }
        }
    })
}

/// Classifies a path from the command line or a list. Links are followed.
fn classify_named_path((path, is_listed): NamedPath) -> WalkStep {
    match fs::metadata(&path) {
        Ok(data) if data.is_dir() => Err(path),
        // Opening a named pipe would block until its writer opens it.
        #[cfg(unix)]
        _ if is_named_pipe(&path) => Ok(WalkItem::Skipped(path, NOT_A_FILE)),
        Ok(data) if is_listed && !data.is_file() => Ok(WalkItem::Skipped(path, NOT_A_FILE)),
        _ => Ok(WalkItem::File(path)),
    }
}

fn classify_entry(folder: &Path, entry: FolderEntry) -> WalkStep {
    let (path, kind) = match entry {
        Ok((name, kind)) => (folder.join(name), kind),
        Err(error) => return Ok(WalkItem::Unreadable(folder.to_owned(), error)),
    };
    match kind {
        kind if kind.is_symlink() => Ok(WalkItem::Skipped(path, SYMBOLIC_LINK)),
        kind if kind.is_file() => Ok(WalkItem::Found(path)),
        kind if kind.is_dir() => Err(path),
        _ => Ok(WalkItem::Skipped(path, NOT_A_FILE)),
    }
}

/// Returns the entries of a folder, sorted by name within chunks. Closes the folder as soon as all names are read.
fn sorted_entries(folder: ReadDir) -> impl Iterator<Item = FolderEntry> + Send {
    let (mut folder, mut chunk) = (Some(folder), VecDeque::<FolderEntry>::new());
    std::iter::from_fn(move || {
        if chunk.is_empty()
            && let Some(open) = &mut folder
        {
            let name_and_type = |entry: io::Result<fs::DirEntry>| {
                let entry = entry?;
                Ok((entry.file_name(), entry.file_type()?))
            };
            chunk.extend(open.take(NAMES_PER_READ).map(name_and_type));
            // Unreadable entries come first.
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

/// Reads paths from a list, each terminated by `end`. Stops at the first read error.
pub fn paths(mut list: impl BufRead + Send, end: u8) -> impl Iterator<Item = PathBuf> + Send {
    std::iter::from_fn(move || {
        loop {
            let mut line = Vec::new();
            let mut limited = list.by_ref().take(MAX_PATH_BYTES);
            let read = limited.read_until(end, &mut line);
            if !matches!(read, Ok(1..)) {
                return None;
            }
            if line.last() == Some(&end) {
                line.pop();
            }
            if !line.is_empty() {
                return Some(path_from_bytes(line));
            }
        }
    })
}

/// Estimates the memory needed for a PTM and its planes, based on the length and the beginning of the file.
pub fn estimate_memory(beginning: &[u8], length: u64) -> u64 {
    let mut words = beginning.windows(4).take(SIZE_HEADER_BYTES);
    // Only compressed planes are much larger than their file.
    if !words.any(|word| word == b"JPEG") {
        return length.saturating_mul(2);
    }
    let head = &beginning[..beginning.len().min(SIZE_HEADER_BYTES)];
    let lines = head.split_inclusive(|&byte| byte == b'\n');
    let end = lines.take(SIZE_HEADER_LINES).map(<[u8]>::len).sum();
    let head = Dissection::parse(&head[..end]);
    let texels = head.size.map_or(0, |size| size.texels() as u64);
    let planes = texels.saturating_mul(head.format.map_or(0, Format::channels) as u64);
    // Memory holds both the decoded streams and the texels computed from them.
    length.saturating_add(planes.saturating_mul(2))
}

/// Memory budget shared by all workers. A worker waits until the amount that it needs is free.
pub struct MemoryPool {
    size: u64,
    left: Mutex<u64>,
    freed: Condvar,
}

impl MemoryPool {
    /// Creates a pool of `size` bytes.
    pub fn new(size: u64) -> MemoryPool {
        let (left, freed) = (Mutex::new(size), Condvar::new());
        MemoryPool { size, left, freed }
    }

    /// Runs `work` as soon as `bytes` are free. A request for more than the pool size waits until the whole pool is free.
    pub fn run_when_free<T>(&self, bytes: u64, work: impl FnOnce() -> T) -> T {
        const LOCK_NOT_POISONED: &str = "no thread panics while it holds the lock";
        let bytes = bytes.min(self.size);
        let left = self.left.lock().expect(LOCK_NOT_POISONED);
        let left = self.freed.wait_while(left, |left| *left < bytes);
        *left.expect(LOCK_NOT_POISONED) -= bytes;
        let done = work();
        *self.left.lock().expect(LOCK_NOT_POISONED) += bytes;
        self.freed.notify_all();
        done
    }
}
