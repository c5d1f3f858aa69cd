//! The program as its users run it: the reference as a writer, and the writer in Python.

use std::fs;
use std::process::Output;

use crate::common::{have, program, repository, run};

/// `check-writer OPTIONS… -- WRITER…`, the report as text with it.
pub fn check_writer(options: &[&str], writer: &[&str]) -> (i32, String, String) {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let report = scratch.path().join("report.yaml");
    let mut command = program();
    command
        .arg("check-writer")
        .args(options)
        .arg("--report")
        .arg(&report);
    if !writer.is_empty() {
        command.arg("--").args(writer);
    }
    let Output {
        status,
        stdout,
        stderr,
    } = command.output().expect("the program starts");
    let text = String::from_utf8_lossy(&[stdout, stderr].concat()).into_owned();
    let report = fs::read_to_string(&report).unwrap_or_default();
    (status.code().unwrap_or(-1), text, report)
}

#[test]
fn the_reference_passes_as_a_process() {
    let (status, text, report) = check_writer(&["--smoke"], &[]);
    assert_eq!(status, 0, "{text}");
    assert!(report.contains("suite: writers"), "{report}");
}

#[test]
fn the_writer_in_python_passes_for_what_it_claims() {
    if !have("python3") {
        return;
    }
    let writer = repository("examples/writers/ptm_writer.py");
    let (status, text, _) = check_writer(&["--smoke"], &["python3", &writer]);
    assert_eq!(status, 0, "{text}");
    assert!(
        text.contains("unsupported (exit status 69): JPEG_RGB, JPEG_LRGB, JPEGLS_RGB, JPEGLS_LRGB"),
        "{text}"
    );
}

#[test]
fn a_template_calls_a_program_that_knows_only_its_own_options() {
    let template = "cp {planes} {out}";
    let (status, text, _) = check_writer(&["--format", "LRGB", "--cmd", template], &[]);
    assert_eq!(status, 1, "{text}");
    assert!(text.contains("the bytes there: \"\\x93NUMPY"), "{text}");
    let (status, text, _) = check_writer(&["--cmd", "cp {planes} x"], &[]);
    assert_eq!(status, 2, "{text}");
    assert!(text.contains("{out}"), "{text}");
}

#[test]
fn exit_statuses_are_those_of_check() {
    let (status, text, _) = check_writer(&[], &["true"]);
    assert_eq!(status, 3, "{text}");
    assert!(text.contains("true is not a writer"), "{text}");
    let (status, ..) = check_writer(&["--case", "nothing-is-called-so"], &[]);
    assert_eq!(status, 5);
    let refused = run(&["reference", "write", "no-such-request.json"]);
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn a_probe_walks_a_writer_through_the_contract() {
    let probed = |writer: &[&str]| {
        let output = run(&[&["probe", "--writer", "--"], writer].concat());
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        (output.status.code(), text)
    };
    let reference = crate::common::program();
    let reference = reference.get_program().to_string_lossy().into_owned();
    let (status, text) = probed(&[&reference, "reference"]);
    assert_eq!(status, Some(0), "{text}");
    assert!(
        text.contains("JPEGLS_LRGB: the file has the values"),
        "{text}"
    );
    let (status, text) = probed(&["sh", "-c", "printf 'PTM_1.2\\n'"]);
    assert_eq!(status, Some(3), "{text}");
    assert!(text.contains("not to standard output"), "{text}");
    let (status, text) = probed(&["sh", "-c", "exit 69"]);
    assert_eq!(status, Some(3), "{text}");
    assert!(text.contains("write at least one format"), "{text}");
    // A writer of the catalog.
    let swapped =
        format!("{reference} reference write \"$2\" x && sed '3{{h;d}};4{{G}}' x > \"$3\"");
    let (status, text) = probed(&["sh", "-c", &swapped, "swapped"]);
    assert_eq!(status, Some(1), "{text}");
    assert!(
        text.contains("such a file comes of a writer that"),
        "{text}"
    );
}
