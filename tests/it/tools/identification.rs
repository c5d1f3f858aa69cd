//! Tests of the signatures in `docs/identify`: they match every legal file of the suite, and no other files.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{Workspace, have_tool, repository, repository_text, stdout};
use data_encoding::HEXUPPER_PERMISSIVE;
use ptm_suite::cases::{Case, Expect, Suite, TableSpelling};

/// Returns all parts of `text` that are between the two markers.
fn parts_between<'a>(text: &'a str, before: &'a str, after: &'a str) -> Vec<&'a str> {
    let parts = text.split(before).skip(1);
    parts
        .filter_map(|part| Some(part.split_once(after)?.0))
        .collect()
}

/// Returns the signatures and the file prefixes that each one matches.
fn signature_prefixes() -> Vec<(&'static str, Vec<Vec<u8>>)> {
    let plain = |text: &str| text.replace("\\n", "\n").replace("\\040", " ").into_bytes();
    let mime = repository_text("docs/identify/ptm-mime.xml");
    let mime = parts_between(&mime, "value=\"", "\"")
        .into_iter()
        .map(plain);
    let magic = repository_text("docs/identify/ptm.magic");
    let magic = parts_between(&magic, "\n0\tstring\t", "\t")
        .into_iter()
        .map(plain);
    let pronom = repository_text("docs/identify/ptm-pronom.xml");
    let sequences = parts_between(&pronom, "<Sequence>", "</Sequence>").into_iter();
    let bytes = |hex: &str| HEXUPPER_PERMISSIVE.decode(hex.as_bytes()).expect("hex");
    vec![
        ("ptm-mime.xml", mime.collect()),
        ("ptm.magic", magic.collect()),
        ("ptm-pronom.xml", sequences.map(bytes).collect()),
    ]
}

/// Writes the beginnings of the legal files of the suite and returns their paths.
fn write_legal_files(here: &Workspace) -> Vec<PathBuf> {
    let suite = Suite::load().expect("the suite loads");
    let cases = suite.cases.iter();
    let legal = cases.filter(|case| case.expect == Expect::Decode);
    let write = |case: &Case| {
        let file = &case.build(TableSpelling::default()).file;
        here.write(&case.id, &file[..file.len().min(4096)])
    };
    legal.map(write).collect()
}

#[test]
fn signatures_match_exactly_the_legal_files() {
    let here = Workspace::new();
    let files = write_legal_files(&here);
    assert!(files.len() > 1000);
    for (name, prefixes) in signature_prefixes() {
        assert_eq!(prefixes.len(), 2, "{name}");
        let matches = |file: &[u8]| prefixes.iter().any(|prefix| file.starts_with(prefix));
        for path in &files {
            let is_known = matches(&fs::read(path).expect("a file"));
            assert!(is_known, "{name}: {}", path.display());
        }
        for other in [
            "PTM_1.1\nPTM_FORMAT_LRGB\n",
            "ptm_1.2\nPTM_FORMAT_LRGB\n",
            "PTM_1.2\r\nPTM_FORMAT_LRGB\r\n",
            "PTM_1.2",
            "",
        ] {
            assert!(!matches(other.as_bytes()), "{name}: {other:?}");
        }
    }
}

/// Returns the number of files that the `file` command identifies as PTMs when it uses only our signature.
fn count_ptms(here: &Workspace, files: &[PathBuf]) -> usize {
    let names = files.iter().map(|path| format!("{}\n", path.display()));
    let list = here.write("list", names.collect::<String>());
    let mut file = Command::new("file");
    file.args(["--brief", "--mime-type", "-m"])
        .arg(repository("docs/identify/ptm.magic"))
        .arg("-f")
        .arg(list);
    let text = stdout(&mut file);
    assert_eq!(text.lines().count(), files.len());
    text.lines().filter(|kind| *kind == "image/x-ptm").count()
}

#[test]
fn file_command_identifies_exactly_the_legal_files() {
    if !have_tool("file") {
        return;
    }
    let here = Workspace::new();
    let files = write_legal_files(&here);
    assert_eq!(count_ptms(&here, &files), files.len());
    // The ignored test below identifies every file in /usr.
    let others = files_below(Path::new("/usr/lib"), 500);
    assert_eq!(count_ptms(&here, &others), 0);
}

#[test]
#[ignore = "reads every file in /usr"]
fn no_system_file_is_identified_as_a_ptm() {
    let files = files_below(Path::new("/usr"), usize::MAX);
    assert_eq!(count_ptms(&Workspace::new(), &files), 0);
}

/// Returns at most `max_files` files at any depth in a directory, except links and files with a line feed in their names.
fn files_below(directory: &Path, max_files: usize) -> Vec<PathBuf> {
    let (mut files, mut directories) = (Vec::new(), vec![directory.to_owned()]);
    while let (Some(directory), true) = (directories.pop(), files.len() < max_files) {
        for entry in fs::read_dir(directory).into_iter().flatten().flatten() {
            match entry.file_type() {
                Ok(kind) if kind.is_dir() => directories.push(entry.path()),
                Ok(kind)
                    if kind.is_file() && !entry.path().display().to_string().contains('\n') =>
                {
                    files.push(entry.path());
                }
                _ => {}
            }
        }
    }
    files.truncate(max_files);
    files
}
