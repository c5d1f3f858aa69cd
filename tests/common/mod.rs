//! Runs the program as its users do.
#![allow(dead_code)] // each test file uses some of this

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What `check` said.
pub struct Checked {
    /// Its exit status.
    pub status: i32,
    /// Standard output, then standard error.
    pub text: String,
    /// The report, or nothing if there is none.
    pub report: serde_json::Value,
}

impl Checked {
    /// The ids of the cases with that outcome.
    pub fn cases(&self, outcome: &str) -> Vec<String> {
        let cases = self.report["cases"].as_array().cloned().unwrap_or_default();
        let with = cases.iter().filter(|case| case["outcome"] == outcome);
        with.filter_map(|case| case["id"].as_str().map(str::to_owned))
            .collect()
    }

    /// The misreadings that are named, most telling first.
    pub fn diagnoses(&self) -> Vec<String> {
        let causes = self.report["diagnoses"]
            .as_array()
            .cloned()
            .unwrap_or_default();
        causes
            .iter()
            .filter_map(|cause| cause["misreading"].as_str().map(str::to_owned))
            .collect()
    }
}

/// The program under test.
pub fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_ptm-conform"))
}

/// `ptm-conform ARGS…`
pub fn run(args: &[&str]) -> Output {
    program().args(args).output().expect("the program starts")
}

/// `ptm-conform check OPTIONS… -- DECODER…`
pub fn check_with(options: &[&str], decoder: &[&str]) -> Checked {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let report = scratch.path().join("report.yaml");
    let mut command = program();
    command
        .arg("check")
        .args(options)
        .arg("--report")
        .arg(&report)
        .arg("--")
        .args(decoder);
    let output = command.output().expect("the program starts");
    let text = [output.stdout, output.stderr].concat();
    let report = std::fs::read_to_string(&report)
        .ok()
        .and_then(|text| serde_saphyr::from_str(&text).ok());
    Checked {
        status: output.status.code().unwrap_or(-1),
        text: String::from_utf8_lossy(&text).into_owned(),
        report: report.unwrap_or_default(),
    }
}

/// The directory of the programs that cargo builds beside the tests.
pub fn examples() -> PathBuf {
    Path::new(env!("CARGO_BIN_EXE_ptm-conform"))
        .parent()
        .expect("a directory")
        .join("examples")
}

/// The zoo of wrong programs.
pub fn zoo() -> String {
    examples().join("zoo").to_string_lossy().into_owned()
}

/// A file of the repository.
pub fn repository(path: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join(path)
        .to_string_lossy()
        .into_owned()
}

/// Whether a program can be started; says SKIPPED if not.
pub fn have(program: &str) -> bool {
    let there = Command::new(program).arg("--version").output().is_ok();
    if !there {
        println!("SKIPPED: {program} is not there");
    }
    there
}
