//! Writers that break the contract: each gets its verdict, and nothing of it is left.

use std::fs;

use crate::common::program;

/// A writer in `sh`, whose request is `$2` and whose output is `$3`; what is said of it, and what is left in its TMPDIR.
fn hostile(script: &str) -> (Option<i32>, String, Vec<String>) {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let works = scratch.path().join("works");
    fs::create_dir(&works).expect("a directory");
    let report = scratch.path().join("report.yaml");
    let output = program()
        .env("TMPDIR", &works)
        .args([
            "check-writer",
            "--case",
            "first-*",
            "--timeout",
            "1",
            "--report",
        ])
        .arg(&report)
        .args(["--", "sh", "-c", script, "hostile"])
        .output()
        .expect("the program starts");
    let left = fs::read_dir(&works).expect("still there");
    let left = left.map(|entry| entry.expect("an entry").path().display().to_string());
    let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    (output.status.code(), text, left.collect())
}

#[track_caller]
fn ends_as(script: &str, says: &str) {
    let (status, text, left) = hostile(script);
    assert!(matches!(status, Some(1 | 3)), "{status:?}: {text}");
    assert!(text.contains(says), "{text}");
    assert_eq!(left, Vec::<String>::new(), "{script}");
}

#[test]
fn what_is_no_file_is_said_to_be_none() {
    ends_as(
        "true",
        "its output file is not there, though it exits with 0",
    );
    ends_as(": > \"$3\"", "its output file is empty");
    ends_as("mkdir \"$3\"", "its output file is not a regular file");
    ends_as("mkfifo \"$3\"", "its output file is not a regular file");
    ends_as("ln -s /etc/hostname \"$3\"", "its output file is a link");
    ends_as("ln -s ../../.. \"$3\"", "its output file is a link");
}

#[test]
fn a_directory_in_the_place_of_its_own_is_not_followed() {
    ends_as(
        "d=$(dirname \"$3\"); cd /; rm -r \"$d\" && ln -s /etc \"$d\"",
        "its output file is not there",
    );
}

#[test]
fn half_a_file_is_a_wrong_one() {
    ends_as(
        "printf 'PTM_1.2\\nPTM_FORMAT_RGB\\n3\\n2\\n' > \"$3\"",
        "the reference refuses the file",
    );
}

#[test]
fn a_writer_that_changes_its_request_is_told_so() {
    ends_as("chmod u+w \"$2\"; echo x >> \"$2\"", "tampering");
}

#[test]
fn endless_files_are_cut_off() {
    ends_as(
        "head -c 10000000000 /dev/zero > \"$3\"",
        "in its output file",
    );
    // Ten gigabytes that take no room.
    ends_as("truncate -s 10G \"$3\" || exit 1", "");
    ends_as("truncate -s 60M \"$3\"", "in its output file");
}

#[test]
fn a_writer_that_never_ends_is_ended() {
    ends_as("sleep 1000", "no end within");
    ends_as("yes > \"$3\"", "in its output file");
}

#[test]
fn a_writer_that_changes_the_planes_is_told_so() {
    let planes = "p=$(dirname \"$2\")/planes.npy; chmod u+w \"$p\" && echo x >> \"$p\"";
    ends_as(planes, "tampering");
}
