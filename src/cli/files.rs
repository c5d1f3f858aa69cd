//! Reading maps and writing results.

use std::fmt::Display;
use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use super::Failed;
use ptm_conform::error::Class;
use ptm_conform::kit::strip_os_error_code;
use ptm_conform::protocol::frame::{EXIT_MALFORMED, EXIT_UNSUPPORTED};
use ptm_conform::ptm::Ptm;
use ptm_conform::tools::dissection::Dissection;

/// Maximum number of bytes read from something other than a regular file, which may be endless: a pipe, a device.
const MAX_STREAM_BYTES: u64 = 1 << 28;

/// Returns a function that names the file of an error.
pub fn with_path<E: Display>(path: &Path) -> impl Fn(E) -> String + '_ {
    move |error| format!("{}: {}", path.display(), strip_os_error_code(&error))
}

/// Converts a path, which may have any bytes on Unix systems.
pub fn path_of(bytes: Vec<u8>) -> PathBuf {
    #[cfg(unix)]
    let path = <std::ffi::OsString as std::os::unix::ffi::OsStringExt>::from_vec(bytes);
    #[cfg(not(unix))]
    let path = String::from_utf8_lossy(&bytes)
        .trim_end_matches('\r')
        .to_owned();
    path.into()
}

/// Reads a file; the error is a sentence.
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

/// Checks before long work whether a result can be written there.
pub fn can_be_written(path: &Path) -> Result<(), String> {
    if path.is_dir() {
        return Err(format!("{} is a directory", path.display()));
    }
    if path.exists() {
        return Ok(());
    }
    let path = &follow_links(path).map_err(with_path(path))?;
    let directory = directory_of(path);
    match directory.is_dir() {
        true => Ok(()),
        false => Err(with_path(path)(format!(
            "there is no directory {}",
            directory.display()
        ))),
    }
}

/// Returns true for a named pipe, which may never have a writer. A shell passes the output of a command as a link to a pipe.
#[cfg(unix)]
pub fn is_named_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    fs::symlink_metadata(path).is_ok_and(|found| found.file_type().is_fifo())
}

/// Returns the directory of a file.
fn directory_of(path: &Path) -> &Path {
    path.parent()
        .filter(|parent| !parent.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

/// Returns the map in a file, or the reason why there is none with a suggestion.
pub fn map<'a>(path: &Path, dissection: &'a Dissection) -> Result<&'a Ptm, Failed> {
    dissection.outcome.as_ref().map_err(|error| {
        let name = path.to_string_lossy();
        let path = shlex::try_quote(&name).unwrap_or(std::borrow::Cow::Borrowed(&name));
        let next = format!("`ptm-conform inspect {path}` shows the file up to that byte; `ptm-conform lint {path}` says what to fix");
        Failed::new(status(error), &format!("{path}: {error}\n  {next}"))
    })
}

/// Returns the map in the file at this path.
pub fn read_map(path: &Path) -> Result<Ptm, Failed> {
    map(path, &Dissection::parse(&read(path)?)).cloned()
}

/// Returns the exit status for the class of an error.
pub fn status(error: &ptm_conform::error::Error) -> u8 {
    let status = match error.class() {
        Class::Malformed => EXIT_MALFORMED,
        Class::Unsupported | Class::Limit => EXIT_UNSUPPORTED,
    };
    status as u8
}

/// Writes a file next to its place and moves it there, so that it is never seen incomplete. If there is a symbolic link, its
/// target is written, and the link stays.
pub fn write_whole(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), String> {
    can_be_written(path)?;
    if path.exists() && !path.is_file() {
        return fs::write(path, bytes).map_err(with_path(path));
    }
    let place = follow_links(path).map_err(with_path(path))?;
    #[cfg_attr(not(unix), allow(unused_mut))]
    let mut temporary = tempfile::Builder::new();
    // The usual permissions of new files.
    #[cfg(unix)]
    temporary.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    let file = temporary.tempfile_in(directory_of(&place));
    let mut file = file.map_err(with_path(path))?;
    file.write_all(bytes.as_ref()).map_err(with_path(path))?;
    file.persist(&place)
        .map_err(|error| with_path(path)(error.error))?;
    Ok(())
}

/// Maximum number of links that are followed in sequence.
const MAX_LINKS: usize = 40;

/// Returns the path after following every link, even if the target does not exist yet.
fn follow_links(path: &Path) -> io::Result<PathBuf> {
    let mut place = path.to_owned();
    for _ in 0..MAX_LINKS {
        match fs::read_link(&place) {
            Ok(target) => place = directory_of(&place).join(target),
            // Not a link.
            Err(_) => return Ok(place),
        }
    }
    Err(io::Error::other("too many symbolic links"))
}
