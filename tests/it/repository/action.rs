//! The GitHub Action's scripts that can run without GitHub.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Output};

use crate::common::{
    PROGRAM, Workspace, have_python, have_tool, outcome, repository, repository_text, stdout,
};
use ptm_suite::kit::yaml::from_yaml;
use serde_json::Value;

fn action() -> Value {
    from_yaml(&repository_text("action.yml")).expect("YAML")
}

/// Returns a command that runs the script of a step as a GitHub runner does.
fn step(id: &str, here: &Workspace) -> Command {
    let action = action();
    let steps = action["runs"]["steps"].as_array().expect("steps").clone();
    let step = steps
        .iter()
        .find(|step| step["id"] == id)
        .expect("the step");
    let mut bash = Command::new("bash");
    bash.args(["--noprofile", "--norc", "-eo", "pipefail", "-c"])
        .arg(step["run"].as_str().expect("a script"))
        .current_dir(here.path(""))
        .env("RUNNER_TEMP", here.path(""));
    bash
}

/// Runs the `check` step of the action with these inputs.
fn check(here: &Workspace, decoder: &str, args: &str) -> Output {
    step("check", here)
        .env("DECODER", decoder)
        .env("CMD", "")
        .env("ARGS", args)
        .env("BASELINE", "")
        .env("DIRECTORY", "my report")
        .env("PROGRAM", PROGRAM)
        .env("GITHUB_OUTPUT", here.path("output"))
        .env("GITHUB_STEP_SUMMARY", here.path("summary.md"))
        .output()
        .expect("bash starts")
}

#[test]
fn action_steps_use_declared_inputs() {
    let text = repository_text("action.yml");
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
    // An expression inside a script would let an input inject commands.
    for step in action["runs"]["steps"].as_array().expect("steps") {
        assert!(!step["run"].as_str().unwrap_or_default().contains("${{"));
    }
}

/// A tag can be moved to different code, but a digest cannot.
#[test]
fn workflows_pin_actions_by_digest() {
    let workflows = fs::read_dir(repository(".github/workflows")).expect("a directory");
    let workflows = workflows.map(|entry| entry.expect("an entry").path());
    for path in workflows.chain([repository("action.yml").into()]) {
        let text = fs::read_to_string(&path).expect("a workflow");
        for used in text.lines().filter_map(|line| line.split_once("uses: ")) {
            let action = used.1.split(' ').next().unwrap_or_default();
            let digest = action.split_once('@').map_or("", |(_, digest)| digest);
            let pinned = digest.len() == 40 && digest.bytes().all(|byte| byte.is_ascii_hexdigit());
            assert!(
                pinned || action.starts_with("docker://"),
                "{path:?}: {action}"
            );
        }
    }
}

#[test]
fn action_forwards_the_result() {
    if !have_tool("bash") {
        return;
    }
    let here = Workspace::new();
    let reference = format!("{PROGRAM} reference");
    let passed = check(&here, &reference, "--case hand-* --jobs 2");
    assert_eq!(passed.status.code(), Some(0), "{passed:?}");
    for name in ["report.yaml", "report.html", "junit.xml", "badge.svg"] {
        assert!(here.path("my report").join(name).exists(), "{name}");
    }
    let decoder = "false $(touch owned) ; touch owned";
    let failed = check(&here, decoder, "--case hand-*");
    assert_eq!(failed.status.code(), Some(3));
    assert!(!here.path("owned").exists());
    assert!(String::from_utf8_lossy(&failed.stdout).contains("\n::error title=not a decoder::"));
    assert_eq!(here.text("output"), "status=0\nstatus=3\n");
    let summary = here.text("summary.md");
    assert!(
        summary.contains("✅") && summary.contains("❌"),
        "{summary}"
    );
}

#[test]
fn action_arguments_are_split_into_lines() {
    if !have_tool("bash") {
        return;
    }
    let here = Workspace::new();
    let program = here.path("my decoder");
    symlink(PROGRAM, &program).expect("a link");
    let decoder = format!("{}\nreference\n", program.display());
    let passed = check(&here, &decoder, "--case\nhand-*\n");
    assert_eq!(passed.status.code(), Some(0), "{passed:?}");
    assert_eq!(check(&here, "", "").status.code(), Some(2));
}

/// Runs the steps without a compiler: with an archive from `scripts/pack.sh` and only the tools that every runner has.
#[test]
fn action_needs_no_compiler() {
    let tools =
        "bash cat chmod cp curl cut dirname grep gzip mkdir mktemp mv rm sha256sum tar uname";
    if !tools.split(' ').all(have_tool) {
        return;
    }
    let here = Workspace::new();
    let path = here.path("bin");
    fs::create_dir(&path).expect("a directory");
    for tool in tools.split(' ') {
        let found = stdout(Command::new("sh").args(["-c", &format!("command -v {tool}")]));
        symlink(found.trim(), path.join(tool)).expect("a link");
    }
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(action()["inputs"]["version"]["default"], version);
    let target = format!("{}-unknown-linux-musl", std::env::consts::ARCH);
    let releases = here.path(&format!("releases/v{version}"));
    let programs = Path::new(PROGRAM).parent().expect("a directory");
    let mut pack = Command::new(repository("scripts/pack.sh"));
    pack.arg(programs)
        .args([&target, &format!("v{version}")])
        .arg(&releases);
    stdout(pack.env("PATH", &path));
    let sums = "sha256sum -- * > SHA256SUMS";
    let mut bash = Command::new("bash");
    stdout(bash.args(["-c", sums]).current_dir(&releases));

    let url = format!("file://{}", here.path("releases").display());
    let release = || {
        let mut release = step("release", &here);
        release
            .env("VERSION", version)
            .env("PTM_CONFORM_RELEASES", &url)
            .env("PATH", &path);
        release.output().expect("bash starts")
    };
    let output = release();
    assert!(output.status.success(), "{output:?}");
    let program = here.path("ptm-conform/bin/ptm-conform");
    let checked = step("check", &here)
        .env("DECODER", format!("{} reference", program.display()))
        .envs([("CMD", ""), ("ARGS", "--smoke"), ("BASELINE", "")])
        .envs([("PROGRAM", ""), ("DIRECTORY", "report")])
        .env("GITHUB_OUTPUT", here.path("output"))
        .env("GITHUB_STEP_SUMMARY", here.path("summary.md"))
        .env("PATH", &path)
        .output()
        .expect("bash starts");
    assert_eq!(checked.status.code(), Some(0), "{checked:?}");
    assert!(here.path("report/report.html").exists());

    // An archive whose digest differs from the published one is not run.
    fs::remove_dir_all(here.path("ptm-conform")).expect("the directory exists");
    let archive = releases.join(format!("ptm-conform-v{version}-{target}.tar.gz"));
    let mut bytes = fs::read(&archive).expect("the archive");
    bytes.push(0);
    fs::write(&archive, bytes).expect("the archive");
    assert!(!release().status.success());
    assert!(!program.exists());
}

/// Runs the steps of the workflow for other projects, with a decoder that has one mistake.
#[test]
fn fuzzing_workflow_finds_and_rechecks_a_mistake() {
    if !have_tool("bash") {
        return;
    }
    let here = Workspace::new();
    here.write(
        "my-decoder",
        format!("#!/bin/sh\ntest \"$1\" = raw || exit 69\n'{PROGRAM}' reference \"$@\" > frame || exit $?\nsed '1!s/a/b/g' frame\n"),
    );
    // The number of calls ends the step, so that a slow machine finds the mistake too.
    here.write_program(
        "ptm-conform",
        format!("#!/bin/sh\ncommand=$1\nshift\ntest $command != fuzz || set -- --executions 300 \"$@\"\nexec '{PROGRAM}' $command \"$@\"\n"),
    );
    let workflow: Value = from_yaml(&repository_text("docs/fuzz-workflow.yml")).expect("YAML");
    let run = |name: &str| {
        let steps = workflow["jobs"]["fuzz"]["steps"].as_array().expect("steps");
        let step = steps.iter().find(|step| step["name"] == name);
        let script = step.expect("the step")["run"].as_str().expect("a script");
        let path = std::env::var("PATH").expect("a path");
        let path = format!("{}:{path}", here.path("").display());
        let mut bash = Command::new("bash");
        let bash = bash.args(["-euo", "pipefail", "-c", script]);
        let bash = bash.current_dir(here.path("")).env("PATH", path);
        let variables = [
            ("DECODER", "sh my-decoder"),
            ("FUZZ_SECONDS", "3600"),
            ("SEED", "7"),
        ];
        outcome(&bash.envs(variables).output().expect("bash starts"))
    };
    let (status, text) = run("Check earlier findings");
    assert_eq!(status, 0, "{text}");
    let (status, text) = run("Fuzz");
    assert_eq!(status, 1, "{text}");
    let (status, text) = run("Check earlier findings");
    assert_eq!(status, 1, "{text}");
}

/// Runs all steps of the action and of the workflow, with their conditions and simulated caches, several times in a row.
#[test]
fn action_and_workflow_keep_findings_and_programs() {
    if !["bash", "curl", "make"].into_iter().all(have_tool) || !have_python(&["yaml"]) {
        return;
    }
    let mut script = Command::new("python3");
    script.arg(repository("scripts/run_workflows.py"));
    let text = stdout(script.arg(PROGRAM));
    assert_eq!(text.matches("ok   ").count(), 11, "{text}");
}
