//! The GitHub Action, as far as it runs without GitHub: the script of its check.
#![cfg(all(unix, feature = "cli"))]

mod common;

use std::fs;
use std::process::{Command, Output};

use common::{have, repository};
use serde_json::Value;

fn action() -> Value {
    let text = fs::read_to_string(repository("action.yml")).expect("the action");
    serde_saphyr::from_str(&text).expect("YAML")
}

/// Runs the check's script in `directory` with these inputs, as a runner does.
fn check(directory: &std::path::Path, decoder: &str, args: &str) -> Output {
    let action = action();
    let steps = action["runs"]["steps"].as_array().expect("steps").clone();
    let step = steps
        .iter()
        .find(|step| step["id"] == "check")
        .expect("the check");
    Command::new("bash")
        .args(["--noprofile", "--norc", "-eo", "pipefail", "-c"])
        .arg(step["run"].as_str().expect("a script"))
        .current_dir(directory)
        .env("DECODER", decoder)
        .env("ARGS", args)
        .env("BASELINE", "")
        .env("DIRECTORY", "made here")
        .env("PROGRAM", env!("CARGO_BIN_EXE_ptm-conform"))
        .env("RUNNER_TEMP", directory)
        .env("GITHUB_OUTPUT", directory.join("output"))
        .env("GITHUB_STEP_SUMMARY", directory.join("summary.md"))
        .output()
        .expect("bash starts")
}

#[test]
fn every_input_that_a_step_uses_is_one() {
    let text = fs::read_to_string(repository("action.yml")).expect("the action");
    let action = action();
    let mut used = 0;
    for part in text.split("inputs.").skip(1) {
        let name: String = part
            .chars()
            .take_while(|c| c.is_ascii_alphanumeric() || *c == '-')
            .collect();
        assert!(action["inputs"].get(&name).is_some(), "{name}");
        used += 1;
    }
    assert!(used >= 6, "{used}");
    // An expression inside a script would let an input write commands.
    for step in action["runs"]["steps"].as_array().expect("steps") {
        assert!(!step["run"].as_str().unwrap_or_default().contains("${{"));
    }
}

#[test]
fn the_action_passes_on_what_the_check_says() {
    if !have("bash") {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let place = |name: &str| scratch.path().join(name);
    let reference = format!("{} reference", env!("CARGO_BIN_EXE_ptm-conform"));
    let passed = check(scratch.path(), &reference, "--case hand-* --jobs 2");
    assert_eq!(passed.status.code(), Some(0), "{passed:?}");
    for name in ["report.yaml", "report.html", "junit.xml", "badge.svg"] {
        assert!(place("made here").join(name).exists(), "{name}");
    }
    let failed = check(
        scratch.path(),
        "false $(touch owned) ; touch owned",
        "--case hand-*",
    );
    assert_eq!(failed.status.code(), Some(3));
    assert!(!place("owned").exists());
    assert!(String::from_utf8_lossy(&failed.stdout).contains("\n::error title=not a decoder::"));
    assert_eq!(
        fs::read_to_string(place("output")).expect("outputs"),
        "status=0\nstatus=3\n"
    );
    let summary = fs::read_to_string(place("summary.md")).expect("a summary");
    assert!(
        summary.contains("✅") && summary.contains("❌"),
        "{summary}"
    );
}
