//! The results so far, for a run that does not finish.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// The results so far, next to the report: a list in YAML, valid after every case.
pub struct Partial {
    path: PathBuf,
    file: Mutex<fs::File>,
}

impl Partial {
    /// Begins the list of a run whose report is to be `report`.
    pub fn new(report: &Path) -> Result<Partial, String> {
        let mut path = report.as_os_str().to_owned();
        path.push(".partial");
        let path = PathBuf::from(path);
        let file =
            fs::File::create(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Partial {
            path,
            file: Mutex::new(file),
        })
    }

    /// Adds a case.
    pub fn append(&self, id: &str, view: &str, answer: &str) {
        let line = format!("- {{ id: {id}, view: \"{view}\", answer: {answer} }}\n");
        // One write for a line; what cannot be written is still in the report.
        let _ = self
            .file
            .lock()
            .expect("no worker panics")
            .write_all(line.as_bytes());
    }

    /// Removes the list: the report is written.
    pub fn remove(self) {
        let _ = fs::remove_file(self.path);
    }
}
