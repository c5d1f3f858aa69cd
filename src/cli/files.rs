//! Functions for reading maps and writing results.

use std::fmt::Display;
use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use super::CommandError;
use ptm::Ptm;
use ptm::error::Class;
use ptm_files::dissection::Dissection;
use ptm_suite::kit::strip_os_error_code;
use ptm_suite::protocol::frame::{EXIT_MALFORMED, EXIT_UNSUPPORTED};

/// Maximum number of bytes read from a pipe or a device, which may be endless.
const MAX_STREAM_BYTES: u64 = 1 << 28;

/// Returns a function that prefixes an error with the path of the file.
pub fn with_path<E: Display>(path: &Path) -> impl Fn(E) -> String + '_ {
    move |error| format!("{}: {}", path.display(), strip_os_error_code(&error))
}

/// Converts bytes to a path. On Unix systems, a path may contain any bytes. Elsewhere, trailing carriage returns are removed,
/// because a list may have CR LF line ends.
pub fn path_from_bytes(bytes: Vec<u8>) -> PathBuf {
    #[cfg(unix)]
    let path = <std::ffi::OsString as std::os::unix::ffi::OsStringExt>::from_vec(bytes);
    #[cfg(not(unix))]
    let path = String::from_utf8_lossy(&bytes)
        .trim_end_matches('\r')
        .to_owned();
    path.into()
}

/// Reads a file. The error message names the file.
pub fn read(path: &Path) -> Result<Vec<u8>, String> {
    #[cfg(unix)]
    if is_named_pipe(path) {
        return Err(with_path(path)("a named pipe, not a file"));
    }
    let file = fs::File::open(path).map_err(with_path(path))?;
    if file.metadata().map_err(with_path(path))?.is_file() {
        return fs::read(path).map_err(with_path(path));
    }
    let mut bytes = Vec::new();
    let read = file.take(MAX_STREAM_BYTES).read_to_end(&mut bytes);
    if read.map_err(with_path(path))? as u64 == MAX_STREAM_BYTES {
        let size = MAX_STREAM_BYTES >> 20;
        let says = format!("not a regular file, and longer than {size} MiB");
        return Err(with_path(path)(says));
    }
    Ok(bytes)
}

/// Returns an error if a result cannot be written to `path`. Called before any lengthy work begins.
pub fn check_writable(path: &Path) -> Result<(), String> {
    if path.is_dir() {
        return Err(format!("{} is a directory", path.display()));
    }
    if path.exists() {
        return Ok(());
    }
    let path = &follow_links(path).map_err(with_path(path))?;
    let directory = parent_directory(path);
    match directory.is_dir() {
        true => Ok(()),
        false => Err(with_path(path)(format!(
            "there is no directory {}",
            directory.display()
        ))),
    }
}

/// Returns true if the path is a named pipe, which may never have a writer. Returns false for a link to a pipe, as in process
/// substitution.
#[cfg(unix)]
pub fn is_named_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    fs::symlink_metadata(path).is_ok_and(|found| found.file_type().is_fifo())
}

fn parent_directory(path: &Path) -> &Path {
    let parent = path.parent().filter(|parent| *parent != Path::new(""));
    parent.unwrap_or(Path::new("."))
}

/// Returns the decoded map of a file, or an error with suggestions for what to do next.
pub fn map<'a>(path: &Path, dissection: &'a Dissection) -> Result<&'a Ptm, CommandError> {
    dissection.outcome.as_ref().map_err(|error| {
        let name = path.to_string_lossy();
        let path = shlex::try_quote(&name).unwrap_or(std::borrow::Cow::Borrowed(&name));
        let next = format!("`ptm-conform inspect {path}` shows the file up to that byte; `ptm-conform lint {path}` says what to fix");
        CommandError::new(status(error), &format!("{path}: {error}\n  {next}"))
    })
}

/// Reads and decodes the map at `path`.
pub fn read_map(path: &Path) -> Result<Ptm, CommandError> {
    map(path, &Dissection::parse(&read(path)?)).cloned()
}

/// Returns the exit status for a decoding error.
pub fn status(error: &ptm::error::Error) -> u8 {
    let status = match error.class() {
        Class::Malformed => EXIT_MALFORMED,
        Class::Unsupported | Class::Limit => EXIT_UNSUPPORTED,
    };
    status as u8
}

/// Writes a temporary file and renames it to `path`, so that other programs never see an incomplete file. If `path` is a
/// symbolic link, its target is replaced and the link is preserved.
pub fn write_atomically(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), String> {
    check_writable(path)?;
    if path.exists() && !path.is_file() {
        return fs::write(path, bytes).map_err(with_path(path));
    }
    let target_path = follow_links(path).map_err(with_path(path))?;
    #[cfg_attr(not(unix), allow(unused_mut))]
    let mut temporary = tempfile::Builder::new();
    // Use the usual permissions of new files.
    #[cfg(unix)]
    temporary.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    let file = temporary.tempfile_in(parent_directory(&target_path));
    let mut file = file.map_err(with_path(path))?;
    file.write_all(bytes.as_ref()).map_err(with_path(path))?;
    file.persist(&target_path)
        .map_err(|error| with_path(path)(error.error))?;
    Ok(())
}

/// Maximum number of symbolic links in a chain.
const MAX_LINKS: usize = 40;

/// Resolves all links in a chain, even if the final target does not exist yet.
fn follow_links(path: &Path) -> io::Result<PathBuf> {
    let mut target_path = path.to_owned();
    for _ in 0..MAX_LINKS {
        match fs::read_link(&target_path) {
            Ok(target) => target_path = parent_directory(&target_path).join(target),
            // The path is not a link.
            Err(_) => return Ok(target_path),
        }
    }
    Err(io::Error::other("too many symbolic links"))
}
