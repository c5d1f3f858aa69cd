//! Reading maps and writing results.

use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use super::Failed;
use ptm_conform::error::Class;
use ptm_conform::protocol::frame::{EXIT_MALFORMED, EXIT_UNSUPPORTED};
use ptm_conform::ptm::Ptm;
use ptm_conform::tools::dissection::Dissection;

/// Bytes that are read of what is not a regular file and may never end: a pipe, a device.
const ENDLESS: u64 = 1 << 28;

/// The bytes of a file, or a sentence.
pub fn read(path: &Path) -> Result<Vec<u8>, String> {
    let named = |error: io::Error| format!("{}: {error}", path.display());
    let file = fs::File::open(path).map_err(named)?;
    if file.metadata().map_err(named)?.is_file() {
        return fs::read(path).map_err(named);
    }
    let mut bytes = Vec::new();
    file.take(ENDLESS).read_to_end(&mut bytes).map_err(named)?;
    if bytes.len() as u64 == ENDLESS {
        return Err(format!(
            "{}: not a regular file, and longer than {} MiB",
            path.display(),
            ENDLESS >> 20
        ));
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
    let path = &led_to(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let directory = directory_of(path);
    if !directory.is_dir() {
        return Err(format!(
            "{}: there is no directory {}",
            path.display(),
            directory.display()
        ));
    }
    Ok(())
}

/// Where a file lies.
fn directory_of(path: &Path) -> &Path {
    path.parent()
        .filter(|parent| !parent.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

/// Returns the map in a file, or says why there is none and what to try next.
pub fn map<'a>(path: &Path, dissection: &'a Dissection) -> Result<&'a Ptm, Failed> {
    dissection.outcome.as_ref().map_err(|error| {
        let path = path.display();
        let next = format!("`ptm-conform inspect {path}` shows the file up to there, `ptm-conform lint {path}` what to fix");
        Failed::new(status(error), &format!("{path}: {error}\n  {next}"))
    })
}

/// The exit status that says whose fault it is.
pub fn status(error: &ptm_conform::error::Error) -> u8 {
    let status = match error.class() {
        Class::Malformed => EXIT_MALFORMED,
        Class::Unsupported | Class::Limit => EXIT_UNSUPPORTED,
    };
    status as u8
}

/// Writes a file beside its place and moves it there, so that nobody ever sees half of it. Where a symbolic link stands, the
/// file it leads to is written, and the link stays.
pub fn write_whole(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), String> {
    let named = |error: io::Error| format!("{}: {error}", path.display());
    can_be_written(path)?;
    if path.exists() && !path.is_file() {
        return fs::write(path, bytes).map_err(named);
    }
    let place = led_to(path).map_err(named)?;
    let mut file = beside(directory_of(&place)).map_err(named)?;
    file.write_all(bytes.as_ref()).map_err(named)?;
    file.persist(&place).map_err(|error| named(error.error))?;
    Ok(())
}

/// Most links that are followed one after the other.
const LINKS: usize = 40;

/// Where a path leads if every link is followed, also to a file that is not there yet.
fn led_to(path: &Path) -> io::Result<PathBuf> {
    let mut place = path.to_owned();
    for _ in 0..LINKS {
        match fs::read_link(&place) {
            Ok(target) => place = directory_of(&place).join(target),
            // It is no link.
            Err(_) => return Ok(place),
        }
    }
    Err(io::Error::other("too many symbolic links"))
}

/// A temporary file, as readable as any file that a program writes.
#[cfg(unix)]
fn beside(directory: &Path) -> io::Result<tempfile::NamedTempFile> {
    use std::os::unix::fs::PermissionsExt;
    tempfile::Builder::new()
        .permissions(fs::Permissions::from_mode(0o644))
        .tempfile_in(directory)
}

/// A temporary file.
#[cfg(not(unix))]
fn beside(directory: &Path) -> io::Result<tempfile::NamedTempFile> {
    tempfile::NamedTempFile::new_in(directory)
}
