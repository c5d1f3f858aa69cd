//! The GitHub Action, as far as it runs without GitHub: the script of its check.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Output};

use crate::common::{have, repository};
use serde_json::Value;

fn action() -> Value {
    let text = fs::read_to_string(repository("action.yml")).expect("the action");
    ptm_conform::kit::yaml::from_yaml(&text).expect("YAML")
}

/// A step's script, to be run in `directory` as a runner does.
fn step(id: &str, directory: &Path) -> Command {
    let action = action();
    let steps = action["runs"]["steps"].as_array().expect("steps").clone();
    let step = steps
        .iter()
        .find(|step| step["id"] == id)
        .expect("the step");
    let mut bash = Command::new("bash");
    bash.args(["--noprofile", "--norc", "-eo", "pipefail", "-c"])
        .arg(step["run"].as_str().expect("a script"))
        .current_dir(directory)
        .env("RUNNER_TEMP", directory);
    bash
}

/// Runs the check in `directory` with these inputs.
fn check(directory: &Path, decoder: &str, args: &str) -> Output {
    step("check", directory)
        .env("DECODER", decoder)
        .env("CMD", "")
        .env("ARGS", args)
        .env("BASELINE", "")
        .env("DIRECTORY", "made here")
        .env("PROGRAM", env!("CARGO_BIN_EXE_ptm-conform"))
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

/// A tag can be moved to other code; a digest cannot.
#[test]
fn workflows_name_the_actions_of_others_by_digest() {
    let workflows = fs::read_dir(repository(".github/workflows")).expect("a directory");
    let workflows = workflows.map(|entry| entry.expect("an entry").path());
    for path in workflows.chain([repository("action.yml").into()]) {
        let text = fs::read_to_string(&path).expect("a workflow");
        for used in text.lines().filter_map(|line| line.split_once("uses: ")) {
            let action = used.1.split(' ').next().unwrap_or_default();
            let digest = action.split_once('@').map_or("", |(_, digest)| digest);
            let fixed = digest.len() == 40 && digest.bytes().all(|byte| byte.is_ascii_hexdigit());
            assert!(
                fixed || action.starts_with("docker://"),
                "{path:?}: {action}"
            );
        }
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

#[test]
fn words_are_lines_where_there_are_several() {
    if !have("bash") {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let program = scratch.path().join("my decoder");
    symlink(env!("CARGO_BIN_EXE_ptm-conform"), &program).expect("a link");
    let decoder = format!("{}\nreference\n", program.display());
    let passed = check(scratch.path(), &decoder, "--case\nhand-*\n");
    assert_eq!(passed.status.code(), Some(0), "{passed:?}");
    assert_eq!(check(scratch.path(), "", "").status.code(), Some(2));
}

/// The steps as they run where nobody has a compiler: on an archive that `scripts/pack.sh` has made, and with a PATH that
/// has what every runner has.
#[test]
fn the_action_takes_a_release_and_no_compiler() {
    let tools = [
        "bash",
        "cat",
        "chmod",
        "cp",
        "curl",
        "cut",
        "dirname",
        "grep",
        "gzip",
        "mkdir",
        "mktemp",
        "mv",
        "rm",
        "sha256sum",
        "tar",
        "uname",
    ];
    if !tools.iter().all(|tool| have(tool)) {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let place = |name: &str| scratch.path().join(name);
    let path = place("bin");
    fs::create_dir(&path).expect("a directory");
    for tool in tools {
        let found = Command::new("sh")
            .args(["-c", &format!("command -v {tool}")])
            .output();
        let found = String::from_utf8(found.expect("sh starts").stdout).expect("a path");
        symlink(found.trim(), path.join(tool)).expect("a link");
    }
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(action()["inputs"]["version"]["default"], version);
    let target = format!("{}-unknown-linux-musl", std::env::consts::ARCH);
    let releases = place(&format!("releases/v{version}"));
    let packed = Command::new(repository("scripts/pack.sh"))
        .arg(
            Path::new(env!("CARGO_BIN_EXE_ptm-conform"))
                .parent()
                .expect("a directory"),
        )
        .args([&target, &format!("v{version}")])
        .arg(&releases)
        .env("PATH", &path)
        .output()
        .expect("bash starts");
    assert!(packed.status.success(), "{packed:?}");
    let sums = "sha256sum -- * > SHA256SUMS";
    let summed = Command::new("bash")
        .args(["-c", sums])
        .current_dir(&releases)
        .status();
    assert!(summed.expect("bash starts").success());

    let url = format!("file://{}", place("releases").display());
    let release = || {
        let mut release = step("release", scratch.path());
        release
            .env("VERSION", version)
            .env("PTM_CONFORM_RELEASES", &url)
            .env("PATH", &path);
        release.output().expect("bash starts")
    };
    let taken = release();
    assert!(taken.status.success(), "{taken:?}");
    let checked = step("check", scratch.path())
        .env(
            "DECODER",
            format!(
                "{} reference",
                place("ptm-conform/bin/ptm-conform").display()
            ),
        )
        .envs([
            ("CMD", ""),
            ("ARGS", "--smoke"),
            ("BASELINE", ""),
            ("PROGRAM", ""),
            ("DIRECTORY", "report"),
        ])
        .env("GITHUB_OUTPUT", place("output"))
        .env("GITHUB_STEP_SUMMARY", place("summary.md"))
        .env("PATH", &path)
        .output()
        .expect("bash starts");
    assert_eq!(checked.status.code(), Some(0), "{checked:?}");
    assert!(place("report/report.html").exists());

    // An archive that is not the one whose digest was published is not run.
    fs::remove_dir_all(place("ptm-conform")).expect("it was there");
    let archive = releases.join(format!("ptm-conform-v{version}-{target}.tar.gz"));
    let mut bytes = fs::read(&archive).expect("the archive");
    bytes.push(0);
    fs::write(&archive, bytes).expect("the archive");
    assert!(!release().status.success());
    assert!(!place("ptm-conform/bin/ptm-conform").exists());
}
