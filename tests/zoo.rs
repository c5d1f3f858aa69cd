//! The harness is tested against programs that answer wrongly, each in one way.
#![cfg(all(unix, feature = "cli"))]

mod common;

use common::{Checked, check_with, zoo};

/// A few small cases of every kind, so that programs that hang take seconds.
const FEW: &[&str] = &[
    "--case",
    "hand-*",
    "--case",
    "version-1-3-*",
    "--case",
    "header-plain-*",
];

#[track_caller]
fn gets(kind: &str, status: i32, says: &str) -> Checked {
    let checked = check_with(&[FEW, &["--timeout", "2"]].concat(), &[&zoo(), kind]);
    assert_eq!(checked.status, status, "{kind}: {}", checked.text);
    assert!(
        checked.text.contains(says),
        "{kind} should be told {says:?}:\n{}",
        checked.text
    );
    checked
}

#[test]
fn a_right_decoder_passes() {
    gets("right", 0, "pass: ");
}

#[test]
fn chatter_and_litter_do_not_matter() {
    gets("chatters", 0, "pass: ");
    gets("floods-errors", 0, "pass: ");
    gets("leaves-files", 0, "pass: ");
}

#[test]
fn programs_that_never_decode_are_no_decoders() {
    gets("refuses-all", 3, "decodes no first file");
    gets("unsupported-all", 3, "69 (unsupported) in every view");
    gets("exits-1", 3, "crash: exit status 1");
    gets("exits-101", 3, "crash: exit status 101");
    gets("aborts", 3, "crash: killed by signal 6");
    gets("segfaults", 3, "crash: killed by signal 11");
    gets(
        "says-nothing",
        3,
        "protocol error: standard output is empty",
    );
    gets("apologises", 3, "begins with");
    gets("text-mode", 3, "CR LF");
    gets("cuts-frame", 3, "announces");
    gets("adds-a-byte", 3, "announces");
    gets("floods", 3, "flood: more than");
}

#[test]
fn programs_that_hang_are_stopped() {
    gets("hangs", 3, "hang: no end within");
    gets("hangs-and-ignores-term", 3, "hang: no end within");
    gets("drips", 3, "hang: no end within");
    gets("closes-stdout-and-runs-on", 3, "hang: no end within");
}

#[test]
fn accepting_everything_is_no_pass() {
    gets("accepts-all", 1, "expected raw");
    gets(
        "accepts-malformed",
        1,
        "accepted a file that must be refused",
    );
}

#[test]
fn a_crash_is_no_refusal() {
    gets("crashes-on-malformed", 1, "crash: exit status 1");
    let declared = check_with(
        &[FEW, &["--reject-exit", "1"]].concat(),
        &[&zoo(), "crashes-on-malformed"],
    );
    assert_eq!(declared.status, 0, "{}", declared.text);
}

#[test]
fn another_size_is_another_picture() {
    gets("wrong-size", 1, "received raw 1x1 with 1 channels");
}

#[test]
fn touching_the_input_is_told() {
    gets(
        "deletes-its-input",
        3,
        "tampering: the file it was given is changed or gone",
    );
    gets("overwrites-its-input", 3, "tampering");
}

#[test]
fn answers_that_differ_each_time_fail() {
    gets("differs-each-time", 1, "samples differ");
}

#[test]
fn unsupported_is_for_whole_features() {
    gets("unsupported-once", 1, "decodes other files of this kind");
}

#[test]
fn no_child_survives_its_call() {
    gets("leaves-a-child", 0, "pass: ");
    gets("closes-stdout-and-runs-on", 3, "hang");
    if !std::path::Path::new("/proc/self/cmdline").exists() {
        println!("SKIPPED: there is no /proc to look for processes in");
        return;
    }
    let processes = std::fs::read_dir("/proc")
        .expect("/proc")
        .filter_map(|entry| {
            let command = std::fs::read(entry.ok()?.path().join("cmdline")).ok()?;
            Some(String::from_utf8_lossy(&command).replace('\0', " "))
        });
    let left: Vec<String> = processes
        .filter(|command| command.contains("sleep 1000."))
        .collect();
    assert!(left.is_empty(), "{left:?} survive");
}
