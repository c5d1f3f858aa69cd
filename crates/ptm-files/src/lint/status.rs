//! Status of a file: sound, damaged, foreign, not judged, or unreadable.

use serde::Serialize;

use super::damage::SECTOR_BYTES;
use crate::dissection::Dissection;
use ptm::error::Class;

/// First bytes of every PTM, regardless of version.
pub const MAGIC: &[u8] = b"PTM_";

/// Status of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// The reference can read the file.
    Sound,
    /// The file is something else than a PTM.
    Foreign,
    /// The file begins like a PTM, perhaps after a damaged first line, but violates a rule of the format; or it is named `.ptm` and
    /// is empty or begins with a sector of zeros.
    Damaged,
    /// The file was not read, is a PTM of another version, or is not supported by the reference.
    #[default]
    NotJudged,
    /// Reading the file failed.
    Unreadable,
}

impl Status {
    /// All statuses, in the order in which totals are printed.
    pub const ALL: [Status; 5] = [
        Status::Sound,
        Status::Damaged,
        Status::Foreign,
        Status::NotJudged,
        Status::Unreadable,
    ];

    /// Returns the human-readable name.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Status::Sound => "sound",
            Status::Foreign => "foreign",
            Status::Damaged => "damaged",
            Status::NotJudged => "not judged",
            Status::Unreadable => "unreadable",
        }
    }

    /// Returns the machine-readable name, as it is serialized.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Status::NotJudged => "not-judged",
            status => status.label(),
        }
    }

    /// Returns the status with this machine-readable name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Status> {
        let mut all = Status::ALL.into_iter();
        all.find(|status| status.name() == name)
    }

    /// Determines the status of a dissected file with this name.
    #[must_use]
    pub fn new(name: &str, dissection: &Dissection) -> Status {
        let file = dissection.file;
        match &dissection.outcome {
            Ok(_) => Status::Sound,
            Err(_) if has_lost_header(file) && is_named_ptm(name) => Status::Damaged,
            Err(_) if !begins_like_a_ptm(file) => Status::Foreign,
            Err(_) if is_another_version(file) => Status::NotJudged,
            Err(error) if error.class() != Class::Malformed => Status::NotJudged,
            Err(_) => Status::Damaged,
        }
    }
}

/// Returns true if the name ends in `.ptm`, in upper or lower case.
#[must_use]
pub fn is_named_ptm(name: &str) -> bool {
    let start = name.len().saturating_sub(4);
    let end = name.as_bytes().get(start..).unwrap_or_default();
    end.eq_ignore_ascii_case(b".ptm")
}

/// Returns true if the file is empty, or its first sector (or the whole of a shorter file) consists of zeros.
#[must_use]
pub fn has_lost_header(file: &[u8]) -> bool {
    let mut sector = file.iter().take(SECTOR_BYTES);
    sector.all(|&byte| byte == 0)
}

/// Returns true if the file begins with [`MAGIC`], perhaps after a byte order mark, spaces or line ends.
#[must_use]
pub fn begins_like_a_ptm(file: &[u8]) -> bool {
    without_damaged_start(file).starts_with(MAGIC)
}

/// Returns the file without a byte order mark, spaces and line ends at its beginning.
#[must_use]
pub fn without_damaged_start(file: &[u8]) -> &[u8] {
    let file = file.strip_prefix(b"\xef\xbb\xbf").unwrap_or(file);
    file.trim_ascii_start()
}

/// Returns true if the first line names a version other than 1.2, such as `PTM_1.1`.
fn is_another_version(file: &[u8]) -> bool {
    let line = file.strip_prefix(MAGIC).unwrap_or_default();
    let Some(end) = line.iter().position(|byte| matches!(byte, b' ' | b'\n')) else {
        return false;
    };
    let numbers: Vec<&[u8]> = line[..end].split(|&byte| byte == b'.').collect();
    let is_number = |part: &&[u8]| !part.is_empty() && part.iter().all(u8::is_ascii_digit);
    numbers.len() == 2 && numbers.iter().all(is_number) && line[..end] != *b"1.2"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_line_distinguishes_other_files_versions_and_damage() {
        const SOUND_FILE: &[u8] =
            b"PTM_1.2\nPTM_FORMAT_LRGB\n1\n1\n1 1 1 1 1 1\n0 0 0 0 0 0\nabcdefrgb";
        for (file, status) in [
            (&b""[..], Status::Damaged),
            (&[0; 512], Status::Damaged),
            (&[0; 20], Status::Damaged),
            // A module of ProTracker may begin with an empty title.
            (
                b"\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0song",
                Status::Foreign,
            ),
            (b"P6\n1 1\n255\n...", Status::Foreign),
            (b"ptm_1.2\nPTM_FORMAT_LRGB\n", Status::Foreign),
            (b"\nPTM_1.2\nPTM_FORMAT_LRGB\n", Status::Damaged),
            (b"\xef\xbb\xbfPTM_1.2\n", Status::Damaged),
            (b"PTM_1.1\nPTM_FORMAT_LRGB\n", Status::NotJudged),
            (b"PTM_12.10 \n", Status::NotJudged),
            (b"PTM_1.1", Status::Damaged),
            (b"PTM_1.\n", Status::Damaged),
            (b"PTM_1.2.3\n", Status::Damaged),
            (b"PTM_1.2\n", Status::Damaged),
            (SOUND_FILE, Status::Sound),
        ] {
            assert_eq!(Status::new("a.PTM", &Dissection::parse(file)), status);
        }
    }
}
