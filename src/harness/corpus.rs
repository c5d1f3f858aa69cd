//! The suite as files: what `generate` writes and `corpus/` holds.

use std::fs;
use std::io;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::harness::cases::{Case, Suite, TableSpelling};
use crate::harness::compare::{Expected, ExpectedValues};
use crate::harness::protocol::{Frame, Samples, View};

/// Files above this size are not part of the committed corpus; the manifest has their digests.
pub const COMMITTED: usize = 4 * 1024;

/// A file of the corpus, as the manifest lists it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entry {
    /// The case.
    pub id: String,
    /// Where it lies, below the corpus.
    pub file: String,
    /// Its size in bytes.
    pub bytes: usize,
    /// Its digest.
    pub sha256: String,
    /// `decode`, `reject`, `refuse`, `lenient`, `robust` or `spelling`.
    pub expect: String,
    /// The accepted file of which it is an edit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twin_of: Option<String>,
    /// What a decoder finds, in the first of the case's views.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected: Option<ExpectedFile>,
}

/// An expected output, as the manifest lists it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExpectedFile {
    /// `raw`, `coef` or `rgb:LU,LV`.
    pub view: String,
    /// Where the frame lies, below the corpus.
    pub file: String,
    /// Its digest.
    pub sha256: String,
}

/// A file to write: where, and what.
pub type Output = (String, Vec<u8>);

/// The entry of a case, and its files.
#[must_use]
pub fn entry(case: &Case) -> (Entry, Vec<Output>) {
    let built = case.build(TableSpelling::default());
    let place = case.format().short_name().to_lowercase();
    let file = format!("{place}/{}.ptm", case.id);
    let mut entry = Entry {
        id: case.id.clone(),
        file: file.clone(),
        bytes: built.file.len(),
        sha256: sha256(&built.file),
        expect: if case.any_picture {
            "robust"
        } else {
            case.expect.name()
        }
        .to_owned(),
        twin_of: case.twin_of.clone(),
        expected: None,
    };
    let mut outputs = Vec::new();
    let view = &case.views[0];
    if let Some(expected) = Expected::of(&built.values, view) {
        let frame = frame(&expected, view);
        let path = format!("{place}/{}.{}", case.id, view.name());
        entry.expected = Some(ExpectedFile {
            view: view.to_string(),
            file: path.clone(),
            sha256: sha256(&frame),
        });
        outputs.push((path, frame));
    }
    outputs.insert(0, (file, built.file.clone()));
    (entry, outputs)
}

/// Writes the corpus of `suite` below `directory`: its files, and `MANIFEST.yaml`. Files above `largest` bytes are only
/// listed. The same bytes come of any number of `jobs`.
///
/// # Errors
/// Those of the file system, with the path.
pub fn write(
    suite: &Suite,
    directory: &Path,
    largest: usize,
    jobs: usize,
    progress: &(impl Fn(usize, usize) + Sync),
) -> io::Result<Vec<Entry>> {
    let entries = in_parallel(suite.cases.len(), jobs, progress, &|place| {
        write_one(&suite.cases[place], directory, largest)
    });
    let entries = entries.into_iter().collect::<io::Result<Vec<_>>>()?;
    let manifest = serde_saphyr::to_string(&entries).map_err(io::Error::other)?;
    put(
        &directory.join("MANIFEST.yaml"),
        format!("# Written by `ptm-conform generate`; see spec-cases/README.md.\n{manifest}")
            .as_bytes(),
    )?;
    Ok(entries)
}

/// What `make` makes of every number below `count`, in order, made by `jobs` at a time.
pub(crate) fn in_parallel<T: Send>(
    count: usize,
    jobs: usize,
    progress: &(impl Fn(usize, usize) + Sync),
    make: &(impl Fn(usize) -> T + Sync),
) -> Vec<T> {
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let slots: Vec<Mutex<Option<T>>> = (0..count).map(|_| Mutex::new(None)).collect();
    std::thread::scope(|scope| {
        for _ in 0..jobs.clamp(1, count.max(1)) {
            scope.spawn(|| {
                loop {
                    let place = next.fetch_add(1, Relaxed);
                    if place >= count {
                        break;
                    }
                    *slots[place].lock().expect("no worker panics") = Some(make(place));
                    progress(done.fetch_add(1, Relaxed) + 1, count);
                }
            });
        }
    });
    let made = slots
        .into_iter()
        .map(|slot| slot.into_inner().expect("no worker panics"));
    made.flatten().collect()
}

fn write_one(case: &Case, directory: &Path, largest: usize) -> io::Result<Entry> {
    let (entry, outputs) = entry(case);
    if outputs.iter().all(|(_, bytes)| bytes.len() <= largest) {
        for (path, bytes) in outputs {
            put(&directory.join(path), &bytes)?;
        }
    }
    Ok(entry)
}

pub(in crate::harness) fn put(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let named =
        |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
    if let Some(parent) = path.parent() {
        fs::create_dir_all(parent).map_err(named)?;
    }
    fs::write(path, bytes).map_err(named)
}

/// The frame of an expected output, as bytes.
fn frame(expected: &Expected, view: &View) -> Vec<u8> {
    let mut bytes = Vec::new();
    picture(expected, view)
        .write(&mut bytes)
        .expect("writing to memory does not fail");
    bytes
}

/// The frame of an expected output; colors rounded to the nearest byte.
pub(super) fn picture(expected: &Expected, view: &View) -> Frame {
    let samples = match &expected.values {
        ExpectedValues::Raw(values) => Samples::U8(values.clone()),
        ExpectedValues::Coef(values) => {
            Samples::F32(values.iter().map(|&value| value as f32).collect())
        }
        ExpectedValues::Rgb(values) => {
            Samples::U8(values.iter().map(|&value| value.round() as u8).collect())
        }
    };
    Frame {
        view: view.name(),
        width: expected.size.width,
        height: expected.size.height,
        channels: expected.channels as u32,
        samples,
    }
}

/// The SHA-256 digest in hexadecimal.
#[must_use]
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}
