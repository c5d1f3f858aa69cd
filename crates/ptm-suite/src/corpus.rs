//! The suite as files: output of `generate` and contents of `corpus/`.

use std::fs;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::cases::{Case, Expect, Suite, TableSpelling};
use crate::compare::Expected;
use crate::kit::{digest::sha256, parallel::map_in_parallel, yaml::to_yaml};

/// Maximum size in bytes of files in the committed corpus. Cases with larger files are only listed in the manifest.
pub const MAX_COMMITTED_SIZE: usize = 4 * 1024;

/// Manifest entry for a file in the corpus.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ManifestEntry {
    /// Id of the case.
    pub id: String,
    /// Path of the file, relative to the corpus.
    pub file: String,
    /// Size of the file in bytes.
    pub bytes: usize,
    /// Digest of the file.
    pub sha256: String,
    /// Expected result: `decode`, `reject`, `refuse`, `lenient`, `robust` or `spelling`.
    pub expect: Expect,
    /// Id of the case whose valid file was edited to create this file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twin_of: Option<String>,
    /// Expected output in the first view of the case.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected: Option<ExpectedFile>,
}

/// Manifest entry for an expected output.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExpectedFile {
    /// View: `raw`, `coef` or `rgb:LU,LV`.
    pub view: String,
    /// Path of the frame, relative to the corpus.
    pub file: String,
    /// Digest of the frame.
    pub sha256: String,
}

/// A file to write: path and contents.
pub type CorpusFile = (String, Vec<u8>);

/// Returns the manifest entry and the files of a case.
#[must_use]
pub fn entry(case: &Case) -> (ManifestEntry, Vec<CorpusFile>) {
    let built = case.build(TableSpelling::default());
    let place = case.format().short_name().to_lowercase();
    let file = format!("{place}/{}.ptm", case.id);
    let mut entry = ManifestEntry {
        id: case.id.clone(),
        file: file.clone(),
        bytes: built.file.len(),
        sha256: sha256(&built.file),
        expect: case.expect,
        twin_of: case.twin_of.clone(),
        expected: None,
    };
    let mut outputs = vec![(file, built.file.clone())];
    let view = &case.views[0];
    if let Some(expected) = Expected::new(&built.values, view) {
        let frame = expected.frame().to_bytes();
        let path = format!("{place}/{}.{}", case.id, view.name());
        entry.expected = Some(ExpectedFile {
            view: view.to_string(),
            file: path.clone(),
            sha256: sha256(&frame),
        });
        outputs.push((path, frame));
    }
    (entry, outputs)
}

/// Writes the corpus of `suite` to `directory`: its files, and `MANIFEST.yaml`. Cases with a file larger than `largest` bytes are
/// only listed in the manifest. The output does not depend on `jobs`.
///
/// # Errors
/// Returns an error with the path of a file that cannot be written.
pub fn write(
    suite: &Suite,
    directory: &Path,
    largest: usize,
    jobs: usize,
    progress: &(impl Fn(usize, usize) + Sync),
) -> io::Result<Vec<ManifestEntry>> {
    let entries = map_in_parallel(suite.cases.len(), jobs, progress, &|place| {
        let (entry, outputs) = entry(&suite.cases[place]);
        if outputs.iter().all(|(_, bytes)| bytes.len() <= largest) {
            for (path, bytes) in outputs {
                write_file(&directory.join(path), &bytes)?;
            }
        }
        Ok(entry)
    });
    let entries = entries.into_iter().collect::<io::Result<Vec<_>>>()?;
    let manifest = to_yaml(&entries).map_err(io::Error::other)?;
    let manifest =
        format!("# Written by `ptm-conform generate`; see spec-cases/README.md.\n{manifest}");
    write_file(&directory.join("MANIFEST.yaml"), manifest.as_bytes())?;
    Ok(entries)
}

/// Writes a file and creates its directory if necessary.
///
/// # Errors
/// Returns an error if the directory or the file cannot be written.
pub fn write_file(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let with_path =
        |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
    if let Some(parent) = path.parent() {
        fs::create_dir_all(parent).map_err(with_path)?;
    }
    fs::write(path, bytes).map_err(with_path)
}
