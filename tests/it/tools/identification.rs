//! The signatures of `docs/identify`: they know every legal file of the suite, and nothing that is no PTM.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::repository;
use ptm_conform::suite::cases::{Expect, Suite, TableSpelling};

fn signature(name: &str) -> String {
    let path = repository(&format!("docs/identify/{name}"));
    fs::read_to_string(path).expect("a signature")
}

/// What stands between two marks, each time.
fn between<'a>(text: &'a str, before: &'a str, after: &'a str) -> Vec<&'a str> {
    let parts = text.split(before).skip(1);
    parts
        .filter_map(|part| Some(part.split_once(after)?.0))
        .collect()
}

fn bytes(hex: &str) -> Vec<u8> {
    let digits: Vec<u8> = hex
        .chars()
        .map(|digit| digit.to_digit(16).expect("hex") as u8)
        .collect();
    digits
        .chunks(2)
        .map(|pair| pair[0] << 4 | pair[1])
        .collect()
}

/// The beginnings that each signature knows.
fn beginnings() -> Vec<(&'static str, Vec<Vec<u8>>)> {
    let plain = |text: &str| text.replace("\\n", "\n").replace("\\040", " ").into_bytes();
    let mime = signature("ptm-mime.xml");
    let magic = signature("ptm.magic");
    let of_magic = magic
        .lines()
        .filter_map(|line| line.strip_prefix("0\tstring\t"));
    let pronom = signature("ptm-pronom.xml");
    vec![
        (
            "ptm-mime.xml",
            between(&mime, "value=\"", "\"")
                .into_iter()
                .map(plain)
                .collect(),
        ),
        (
            "ptm.magic",
            of_magic
                .map(|line| plain(line.split('\t').next().expect("a string")))
                .collect(),
        ),
        (
            "ptm-pronom.xml",
            between(&pronom, "<Sequence>", "</Sequence>")
                .into_iter()
                .map(bytes)
                .collect(),
        ),
    ]
}

/// The legal files of the suite.
fn legal(directory: &Path) -> Vec<PathBuf> {
    let suite = Suite::load().expect("the suite loads");
    let cases = suite
        .cases
        .iter()
        .filter(|case| case.expect == Expect::Decode);
    let write = |case: &ptm_conform::suite::cases::Case| {
        let path = directory.join(&case.id);
        let file = &case.build(TableSpelling::default()).file;
        fs::write(&path, &file[..file.len().min(4096)]).expect("a file");
        path
    };
    cases.map(write).collect()
}

#[test]
fn every_signature_knows_every_legal_file_and_no_damaged_beginning() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let files = legal(scratch.path());
    assert!(files.len() > 1000);
    for (name, beginnings) in beginnings() {
        assert_eq!(beginnings.len(), 2, "{name}");
        let knows = |file: &[u8]| {
            beginnings
                .iter()
                .any(|beginning| file.starts_with(beginning))
        };
        for path in &files {
            assert!(
                knows(&fs::read(path).expect("a file")),
                "{name}: {}",
                path.display()
            );
        }
        for other in [
            "PTM_1.1\nPTM_FORMAT_LRGB\n",
            "ptm_1.2\nPTM_FORMAT_LRGB\n",
            "PTM_1.2\r\nPTM_FORMAT_LRGB\r\n",
            "PTM_1.2",
            "",
        ] {
            assert!(!knows(other.as_bytes()), "{name}: {other:?}");
        }
    }
}

/// The media types that `file` finds with our magic alone, of so many files.
fn types(directory: &Path, files: &[PathBuf]) -> Option<Vec<String>> {
    let list = directory.join("list");
    let names: Vec<String> = files
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    fs::write(&list, names.join("\n") + "\n").expect("a list");
    let output = Command::new("file")
        .args([
            "--brief",
            "--mime-type",
            "-m",
            &repository("docs/identify/ptm.magic"),
            "-f",
        ])
        .arg(&list)
        .output();
    let Ok(output) = output else {
        println!("SKIPPED: file is not there");
        return None;
    };
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    Some(text.lines().map(str::to_owned).collect())
}

#[test]
fn file_knows_every_legal_file_and_takes_no_other_for_one() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let files = legal(scratch.path());
    let Some(found) = types(scratch.path(), &files) else {
        return;
    };
    assert_eq!(found.len(), files.len());
    assert!(
        found.iter().all(|found| found == "image/x-ptm"),
        "{found:?}"
    );
    // Every file is asked for by the ignored test below; here some of a system's.
    let others = files_below(Path::new("/usr/lib"), 500);
    let found = types(scratch.path(), &others).expect("it was there before");
    assert!(!found.iter().any(|found| found == "image/x-ptm"));
}

#[test]
#[ignore = "reads the beginning of every file of the system"]
fn no_file_of_the_system_is_taken_for_a_ptm() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let files = files_below(Path::new("/usr"), usize::MAX);
    let found = types(scratch.path(), &files).expect("file is there");
    let taken = found.iter().filter(|found| *found == "image/x-ptm").count();
    println!("{taken} of {} files", files.len());
    assert_eq!(taken, 0);
}

/// At most so many files below a directory, links aside; those whose names a list can hold.
fn files_below(directory: &Path, most: usize) -> Vec<PathBuf> {
    let (mut files, mut directories) = (Vec::new(), vec![directory.to_owned()]);
    while let (Some(directory), true) = (directories.pop(), files.len() < most) {
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
    files.truncate(most);
    files
}
