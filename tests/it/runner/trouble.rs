//! Tests that a lack of resources is never reported as a fault of the decoder. With little disk space, low limits on open files
//! or processes, or an ignored signal, a correct decoder passes, or the run ends with status 2 and names the missing resource.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::common::{PROGRAM, Workspace, have_proc, outcome, skip, starts, zoo};

/// Options that select a few small cases.
const FEW_CASES: &str = "--case hand-* --case header-plain-*";

/// Checks a correct decoder from a shell. The commands in `before` run first, and `wrapper` starts the program.
fn check(before: &str, wrapper: &str, options: &str) -> (i32, String) {
    let here = Workspace::new();
    let open = std::os::unix::fs::PermissionsExt::from_mode(0o777);
    fs::set_permissions(here.path(""), open).expect("permissions");
    let line = format!(
        "check {FEW_CASES} --timeout 60 {options} -- {}",
        zoo("right")
    );
    let script = format!("set -f; {before}; exec {wrapper} '{PROGRAM}' {line}");
    let mut shell = Command::new("sh");
    shell.current_dir(here.path("")).args(["-c", &script]);
    outcome(&shell.output().expect("a shell starts"))
}

#[track_caller]
fn assert_passes((status, text): (i32, String)) {
    assert_eq!(status, 0, "{text}");
    assert!(text.contains("pass: "), "{text}");
}

/// Asserts that a check passed, or that its output names the missing resource.
#[track_caller]
fn assert_passes_or_names((status, text): (i32, String), resource: &str) {
    match status {
        0 => assert!(text.contains("pass: "), "{text}"),
        2 => assert!(
            text.contains(resource) && text.contains("not the decoder's fault"),
            "{text}"
        ),
        other => panic!("exit status {other}: {text}"),
    }
}

/// Returns true if the current user can run a shell command. Prints SKIPPED if not.
fn can_run(command: &str) -> bool {
    starts(command) || skip(&format!("permission to run `{command}`"))
}

fn is_root() -> bool {
    fs::metadata("/proc/self").is_ok_and(|this| this.uid() == 0)
}

#[test]
fn ignored_sigchld_is_handled() {
    assert_passes(check("trap '' CHLD", "", ""));
}

#[test]
fn calls_are_retried_if_file_descriptors_run_out() {
    assert_passes(check("ulimit -n 64", "", "--jobs 32"));
    for limit in [20, 14, 12, 10, 8] {
        let before = format!("ulimit -n {limit}");
        assert_passes_or_names(check(&before, "", "--jobs 2"), "open files");
    }
}

#[test]
fn file_size_limit_is_reported() {
    // Root may exceed the limit.
    let (status, text) = check("ulimit -f 0", "", "");
    match status {
        0 => assert!(is_root(), "{text}"),
        2 => assert!(text.contains("File too large"), "{text}"),
        other => panic!("exit status {other}: {text}"),
    }
}

#[test]
fn process_limit_is_reported() {
    const USER: &str = "setpriv --reuid 54321 --regid 54321 --clear-groups";
    if !is_root() {
        skip("root");
        return;
    }
    if !can_run(&format!("{USER} test -x {}", zoo(""))) {
        return;
    }
    for limit in [40, 8, 6, 5, 4, 3] {
        // The limit applies to the user. Root has no limit.
        let wrapper = format!("{USER} prlimit --nproc={limit}");
        assert_passes_or_names(check("umask 0", &wrapper, "--jobs 2"), "processes");
    }
}

#[test]
fn inputs_are_written_to_directories_with_space() {
    let mount = |places: &str| {
        format!("for place in {places}; do mount -t tmpfs -o size=16k none $place || exit 9; done")
    };
    let unshare = "unshare --mount --map-root-user";
    if !can_run(&format!("{unshare} sh -c '{}'", mount("/mnt"))) {
        return;
    }
    let check = |places: &str| {
        let root = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a directory");
        let line = "check --case table-of-32768-entries-ptm-lut --timeout 60";
        let (mount, right) = (mount(places), zoo("right"));
        let root = root.path().display();
        let script = format!("{mount}; cd '{root}'; '{PROGRAM}' {line} -- {right}");
        let output = Command::new("unshare")
            .args(["--mount", "--map-root-user", "sh", "-c", &script])
            .env_remove("TMPDIR")
            .output();
        outcome(&output.expect("unshare starts"))
    };
    assert_passes(check("/dev/shm"));
    if Path::new(env!("CARGO_TARGET_TMPDIR")).starts_with("/tmp") {
        // The mount would hide the decoder itself.
        return;
    }
    let (status, text) = check("/dev/shm /var/tmp /tmp");
    assert_eq!(status, 2, "{text}");
    assert!(
        text.contains("set TMPDIR to a directory with more space"),
        "{text}"
    );
}

/// The run reaps orphaned processes of a decoder once they have ended.
#[test]
fn ended_orphans_are_reaped() {
    if !have_proc() {
        return;
    }
    let here = Workspace::new();
    let line = format!(
        "check --smoke --jobs 2 --timeout 60 -- {}",
        zoo("leaves-orphans")
    );
    let mut run = here
        .command(&line)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let mut peak = 0;
    let status = loop {
        if let Some(status) = run.try_wait().expect("a status") {
            break status;
        }
        peak = peak.max(count_zombies(run.id()));
        std::thread::sleep(std::time::Duration::from_millis(5));
    };
    assert_eq!(status.code(), Some(0));
    // Each call leaves five orphans. Those of calls in progress may be zombies.
    println!("at most {peak} zombies at a time");
    assert!(peak <= 40, "{peak} at a time");
}

fn count_zombies(parent: u32) -> usize {
    let children = fs::read_to_string(format!("/proc/{parent}/task/{parent}/children"));
    let children = children.unwrap_or_default();
    let has_ended = |pid: &&str| {
        let state = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
        state.contains(") Z ")
    };
    children.split_whitespace().filter(has_ended).count()
}
