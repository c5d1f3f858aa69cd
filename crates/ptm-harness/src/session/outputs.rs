//! Answers that were produced elsewhere: by hand in a viewer, in a browser or on another system. [`export`] writes every file
//! that can be requested in one view, and a list of requests. [`Outputs`] reads the results: for each file, an image, a frame or
//! an array named after the case, with any suffix, or a note that the file was refused. `Outputs` answers requests like a
//! decoder, so the verdicts are the same.

use std::collections::{BTreeMap, HashSet};
use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use ptm_suite::cases::{Case, Suite, TableSpelling};
use ptm_suite::corpus::write_file;
use ptm_suite::kit::digest::sha256;
use ptm_suite::kit::yaml::{from_yaml, read_text, to_yaml};
use ptm_suite::protocol::forms;
use ptm_suite::protocol::frame::{Answer, View, ViewKind};
use ptm_suite::protocol::request::{Reply, Request};

/// File name of the request list for programs.
const LIST_NAME: &str = "requests.yaml";
/// File name of the request list for spreadsheets and scripts.
const TABLE_NAME: &str = "requests.tsv";
/// Name of the directory for the answers.
const ANSWERS_DIR: &str = "outputs";

/// A request for the output of one file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ListedRequest {
    /// Id of the case.
    id: String,
    /// Path of the PTM file, relative to the list.
    file: String,
    /// Digest of the PTM file.
    sha256: String,
    /// The view: `raw`, `coef` or `rgb:LU,LV`.
    view: String,
    /// Path of the output, relative to the list. A different suffix is also accepted.
    output: String,
}

impl ListedRequest {
    fn new(case: &Case, view: &View, file: &[u8]) -> ListedRequest {
        let suffix = match view.kind() {
            ViewKind::Rgb => "png",
            _ => "npy",
        };
        ListedRequest {
            id: case.id.clone(),
            file: format!("files/{}.ptm", case.id),
            sha256: sha256(file),
            view: view.to_string(),
            output: format!("{ANSWERS_DIR}/{}.{suffix}", case.id),
        }
    }
}

/// The instructions in the exported directory.
const READ_ME: &str = ptm_spec_cases::OUTPUTS_README;

/// Writes the files that can be requested in `view` and the list of requests to `directory`. Returns the number of requests.
///
/// # Errors
/// Returns an error that names the file that could not be written.
pub fn export(
    suite: &Suite,
    view: &str,
    directory: &Path,
    progress: &impl Fn(usize, usize),
) -> io::Result<usize> {
    let mut list = Vec::new();
    for (done, case) in suite.cases.iter().enumerate() {
        if let Some(view) = case.views.iter().find(|offered| offered.name() == view) {
            let built = case.build(TableSpelling::default());
            let listed = ListedRequest::new(case, view, &built.file);
            write_file(&directory.join(&listed.file), &built.file)?;
            list.push(listed);
        }
        progress(done + 1, suite.cases.len());
    }
    let yaml = to_yaml(&list).map_err(io::Error::other)?;
    let mut table = "case\tfile\tview\toutput\n".to_owned();
    for one in &list {
        let fields = [&*one.id, &one.file, &one.view, &one.output];
        table += &(fields.join("\t") + "\n");
    }
    write_file(&directory.join("README.txt"), READ_ME.as_bytes())?;
    write_file(&directory.join(TABLE_NAME), table.as_bytes())?;
    write_file(&directory.join(LIST_NAME), yaml.as_bytes())?;
    fs::create_dir_all(directory.join(ANSWERS_DIR))?;
    Ok(list.len())
}

/// Answer for a case: a file, or a refusal.
type OfflineAnswer = Result<PathBuf, Answer>;

/// Lists of refused and of unsupported files: name of the list, suffix of a file that marks a single case, and the answer.
const REFUSALS: [(&str, &str, Answer); 2] = [
    ("rejected.txt", "reject", Answer::Rejected),
    ("unsupported.txt", "unsupported", Answer::Unsupported),
];

/// Answers that were produced elsewhere.
#[derive(Clone, Debug)]
pub struct Outputs {
    given: BTreeMap<String, OfflineAnswer>,
    /// The view that all requests have in common.
    pub view: ViewKind,
    /// Names of files that match no request.
    pub unmatched: Vec<String>,
}

impl Outputs {
    /// Reads a directory created by [`export`]. `matches` returns true if a pattern matches an id.
    ///
    /// # Errors
    /// Returns a message that names the file and, if there is one, the offending line.
    pub fn open(
        directory: &Path,
        suite: &Suite,
        matches: impl Fn(&str, &str) -> Result<bool, String>,
    ) -> Result<Outputs, String> {
        let path = directory.join(LIST_NAME);
        let in_file = |error: ptm_suite::Error| error.in_place(path.display());
        let list: Vec<ListedRequest> = from_yaml(&read_text(&path)?).map_err(in_file)?;
        let view = view_of(&list, suite).map_err(|error| in_file(error.into()))?;
        let directory = directory.join(ANSWERS_DIR);
        let failed = |error| format!("{}: {error}", directory.display());
        let (mut given, unmatched) = answers(&directory, &list).map_err(failed)?;
        for (name, _, refusal) in REFUSALS {
            for id in listed_ids(&directory.join(name), &list, &matches)? {
                given.entry(id).or_insert_with(|| Err(refusal.clone()));
            }
        }
        if given.is_empty() {
            let directory = directory.display();
            return Err(format!("{directory} contains no answer to any request"));
        }
        Ok(Outputs {
            given,
            view,
            unmatched,
        })
    }

    /// Returns the reasons why cases cannot be requested, one slot per case of `suite`.
    #[must_use]
    pub fn withheld(&self, suite: &Suite) -> Vec<Option<String>> {
        let is_missing = |case: &Case| !self.given.contains_key(&case.id);
        let why = |case| is_missing(case).then(|| "no answer was given".to_owned());
        suite.cases.iter().map(why).collect()
    }

    /// Answers a request like a decoder.
    #[must_use]
    pub fn ask(&self, request: &Request) -> Reply {
        let answer = match self.given.get(request.name) {
            None => Answer::NotStarted("no answer was given".to_owned()),
            Some(Err(refusal)) => refusal.clone(),
            Some(Ok(path)) => {
                let limit = request.max_answer_bytes();
                let bytes = read(path, limit);
                let frame = bytes.and_then(|bytes| Ok(forms::read(&bytes, request.view, limit)?));
                frame.map_or_else(Answer::ProtocolError, Answer::Decoded)
            }
        };
        Reply::from(answer)
    }
}

/// Returns the ids that match a pattern in the list at `path`, or none if there is no list.
fn listed_ids(
    path: &Path,
    list: &[ListedRequest],
    matches: impl Fn(&str, &str) -> Result<bool, String>,
) -> Result<Vec<String>, String> {
    let text = match path.exists() {
        true => read_text(path)?,
        false => String::new(),
    };
    let mut ids = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let fault = |why: &str| format!("{}: line {number}: {why}: {line:?}", path.display());
        let pattern = line.trim();
        if pattern.is_empty() || pattern.starts_with('#') {
            continue;
        }
        let known = ids.len();
        for ListedRequest { id, .. } in list {
            if matches(pattern, id).map_err(|error| fault(&error))? {
                ids.push(id.clone());
            }
        }
        if ids.len() == known {
            return Err(fault("no request matches"));
        }
    }
    Ok(ids)
}

/// Returns the view of all requests. Returns an error if a request is not from `suite` or the views differ.
fn view_of(list: &[ListedRequest], suite: &Suite) -> Result<ViewKind, String> {
    let other = "these requests are from a different version of this program; export them again";
    let mut view = None;
    for listed in list {
        let case = suite.case(&listed.id).ok_or(other)?;
        let mut views = case.views.iter();
        let asked = views.find(|view| view.to_string() == listed.view);
        let asked = asked.ok_or(other)?;
        if *listed != ListedRequest::new(case, asked, &case.build(TableSpelling::default()).file) {
            return Err(other.to_owned());
        }
        if *view.get_or_insert(asked.kind()) != asked.kind() {
            return Err("all requests must have the same view".to_owned());
        }
    }
    view.ok_or_else(|| "there are no requests".to_owned())
}

/// Returns the answers given as separate files, and the names of files that match no request.
fn answers(
    directory: &Path,
    list: &[ListedRequest],
) -> io::Result<(BTreeMap<String, OfflineAnswer>, Vec<String>)> {
    let ids: HashSet<&str> = list.iter().map(|listed| &*listed.id).collect();
    let mut given = BTreeMap::new();
    let mut unmatched = Vec::new();
    for entry in fs::read_dir(directory)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let (id, suffix) = name.split_once('.').unwrap_or((&name, ""));
        if !ids.contains(id) {
            if !REFUSALS.iter().any(|(list, ..)| *list == name) {
                unmatched.push(name.into_owned());
            }
            continue;
        }
        let refusal = REFUSALS.into_iter().find(|(_, of, _)| *of == suffix);
        let answer = refusal.map_or_else(|| Ok(path.clone()), |(.., refusal)| Err(refusal));
        if given.insert(id.to_owned(), answer).is_some() {
            return Err(io::Error::other(format!("two answers for {id}")));
        }
    }
    unmatched.sort();
    Ok((given, unmatched))
}

/// Reads an answer of at most `limit` bytes. Opens only regular files.
fn read(path: &Path, limit: usize) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let read = fs::symlink_metadata(path).and_then(|about| match about.is_file() {
        true => fs::File::open(path)?
            .take(limit as u64 + 1)
            .read_to_end(&mut bytes),
        false => Err(io::Error::other("is not a regular file")),
    });
    let fault = match read {
        Err(error) => error.to_string(),
        Ok(0) => "is empty".to_owned(),
        Ok(length) if length > limit => "is larger than any image of the PTM file".to_owned(),
        Ok(_) => return Ok(bytes),
    };
    Err(format!("its output file {fault}"))
}
