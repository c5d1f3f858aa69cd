//! Status of a file: sound, damaged, not a PTM, or not judged.

use serde::Serialize;

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
    /// The file does not begin with [`MAGIC`].
    NotAPtm,
    /// The file begins with [`MAGIC`] but violates a rule of the format.
    Damaged,
    /// The file was not read, is a PTM of another version, or is not supported by the reference.
    #[default]
    NotJudged,
}

impl Status {
    /// All statuses, in the order in which totals are printed.
    pub const ALL: [Status; 4] = [
        Status::Sound,
        Status::Damaged,
        Status::NotAPtm,
        Status::NotJudged,
    ];

    /// Returns the human-readable name.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Status::Sound => "sound",
            Status::NotAPtm => "not a PTM",
            Status::Damaged => "damaged",
            Status::NotJudged => "not judged",
        }
    }

    /// Returns the machine-readable name, as it is serialized.
    #[must_use]
    pub fn name(self) -> String {
        self.label().to_lowercase().replace(' ', "-")
    }

    /// Determines the status of a dissected file.
    #[must_use]
    pub fn new(dissection: &Dissection) -> Status {
        match &dissection.outcome {
            Ok(_) => Status::Sound,
            Err(_) if !dissection.file.starts_with(MAGIC) => Status::NotAPtm,
            Err(_) if is_another_version(dissection.file) => Status::NotJudged,
            Err(error) if error.class() != Class::Malformed => Status::NotJudged,
            Err(_) => Status::Damaged,
        }
    }
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
            (&b""[..], Status::NotAPtm),
            (b"P6\n1 1\n255\n...", Status::NotAPtm),
            (b"ptm_1.2\nPTM_FORMAT_LRGB\n", Status::NotAPtm),
            (b"PTM_1.1\nPTM_FORMAT_LRGB\n", Status::NotJudged),
            (b"PTM_12.10 \n", Status::NotJudged),
            (b"PTM_1.1", Status::Damaged),
            (b"PTM_1.\n", Status::Damaged),
            (b"PTM_1.2.3\n", Status::Damaged),
            (b"PTM_1.2\n", Status::Damaged),
            (SOUND_FILE, Status::Sound),
        ] {
            assert_eq!(Status::new(&Dissection::parse(file)), status);
        }
    }
}
