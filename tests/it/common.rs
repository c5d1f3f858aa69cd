//! Helpers that run the program from the command line.

use std::fs;
use std::io::Read;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ptm_suite::kit::yaml::from_yaml;
use serde_json::Value;
use tempfile::TempDir;

pub use crate::skip::skip;
pub use crate::table::rows;

/// Temporary working directory of the program. Command lines can therefore use file names without a path.
///
/// Command lines are split into words as in a shell. They do not include the program itself.
pub struct Workspace(TempDir);

impl Workspace {
    pub fn new() -> Workspace {
        Workspace(tempfile::tempdir().expect("a temporary directory"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Returns a command that runs the program in this directory with the words of a command line.
    pub fn command(&self, line: &str) -> Command {
        let mut command = program();
        command.current_dir(&self.0).args(words(line));
        command
    }

    /// Runs the program. Returns the exit status, and standard output followed by standard error.
    pub fn run(&self, line: &str) -> (i32, String) {
        outcome(&self.command(line).output().expect("the program starts"))
    }

    /// Runs the program, asserts its exit status, and returns its output.
    #[track_caller]
    pub fn exits(&self, status: i32, line: &str) -> String {
        let (found, text) = self.run(line);
        assert_eq!(found, status, "{line}: {text}");
        text
    }

    /// Runs the program, asserts that it exits with 0, and returns its output.
    #[track_caller]
    pub fn succeeds(&self, line: &str) -> String {
        self.exits(0, line)
    }

    /// Runs the command lines of a table. Each row contains the expected exit status, the command line, and parts of the output.
    #[track_caller]
    pub fn assert_lines(&self, table: &str) {
        for [status, line, says] in rows(table) {
            let (found, text) = self.run(&line);
            assert_eq!(found.to_string(), status, "{line}: {text}");
            assert_contains(&text, &says);
        }
    }

    /// Runs `check --report report.yaml` with the rest of a command line.
    pub fn check(&self, line: &str) -> CheckRun {
        let (status, text) = self.run(&format!("check --report report.yaml {line}"));
        CheckRun::new(status, text, &self.path("report.yaml"))
    }

    /// Runs `check-writer --report report.yaml` with the rest of a command line.
    pub fn check_writer(&self, line: &str) -> CheckRun {
        let (status, text) = self.run(&format!("check-writer --report report.yaml {line}"));
        CheckRun::new(status, text, &self.path("report.yaml"))
    }

    /// Writes a file, and creates its directory if necessary.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a directory")).expect("a directory");
        fs::write(&path, bytes).expect("a file is written");
        path
    }

    /// Writes an executable file.
    pub fn write_program(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.write(name, text);
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("permissions");
        path
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).expect("UTF-8")
    }

    /// Copies a file from the corpus, such as `lrgb/first-lrgb.ptm`, to this directory.
    pub fn copy_from_corpus(&self, file: &str) {
        let name = file.rsplit('/').next().expect("a file name");
        fs::copy(repository(&format!("corpus/{file}")), self.path(name)).expect("a copy");
    }
}

/// Splits a command line as a shell does.
pub fn words(line: &str) -> Vec<String> {
    shlex::split(line).unwrap_or_else(|| panic!("unbalanced quotation marks in {line}"))
}

/// Returns the exit status of a program, and standard output followed by standard error.
pub fn outcome(output: &Output) -> (i32, String) {
    let text = [&output.stdout[..], &output.stderr].concat();
    let text = String::from_utf8_lossy(&text).into_owned();
    (output.status.code().unwrap_or(-1), text)
}

/// Runs another program, asserts that it succeeds, and returns its standard output.
#[track_caller]
pub fn stdout(command: &mut Command) -> String {
    let output = command.output().expect("the program starts");
    assert!(output.status.success(), "{}", outcome(&output).1);
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Asserts that `text` contains all given parts, which are separated by ` && `.
#[track_caller]
pub fn assert_contains(text: &str, parts: &str) {
    for part in parts.split(" && ") {
        assert!(text.contains(part), "{part:?} is not in:\n{text}");
    }
}

/// Replaces `find`, which must occur exactly once in `text`.
#[track_caller]
pub fn edit(text: &str, find: &str, replace: &str) -> String {
    assert_eq!(text.matches(find).count(), 1, "{find}");
    text.replace(find, replace)
}

/// Waits until a condition is true. Returns false if it is still false after the given number of seconds.
pub fn wait_until(seconds: u64, condition: impl Fn() -> bool) -> bool {
    let deadline = Instant::now() + Duration::from_secs(seconds);
    while !condition() {
        if Instant::now() > deadline {
            return false;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    true
}

/// Returns the ids and command lines of the processes for which `matches` is true, given the command line and the environment.
pub fn processes(matches: impl Fn(&str, &str) -> bool) -> Vec<(String, String)> {
    let read = |path: PathBuf| {
        let text = fs::read(path).unwrap_or_default();
        String::from_utf8_lossy(&text).replace('\0', " ")
    };
    let process = |entry: fs::DirEntry| {
        let command = read(entry.path().join("cmdline"));
        let is_wanted = matches(&command, &read(entry.path().join("environ")));
        is_wanted.then(|| (entry.file_name().to_string_lossy().into_owned(), command))
    };
    let entries = fs::read_dir("/proc").expect("/proc").flatten();
    entries.filter_map(process).collect()
}

/// Returns true if /proc lists processes. Prints SKIPPED if not.
pub fn have_proc() -> bool {
    Path::new("/proc/self/environ").exists() || skip("/proc")
}

/// Result of running `check` or `check-writer`.
pub struct CheckRun {
    /// Exit status.
    pub status: i32,
    /// Standard output, followed by standard error.
    pub text: String,
    /// Report, or null if there is none.
    pub report: Value,
}

impl CheckRun {
    pub fn new(status: i32, text: String, report: &Path) -> CheckRun {
        let report = fs::read_to_string(report).ok();
        let report = report.and_then(|text| from_yaml(&text).ok());
        CheckRun {
            status,
            text,
            report: report.unwrap_or_default(),
        }
    }

    /// Asserts the exit status, and that the output contains all parts, which are separated by ` && `.
    #[track_caller]
    pub fn assert_exit(&self, status: i32, parts: &str) {
        assert_eq!(self.status, status, "{}", self.text);
        assert_contains(&self.text, parts);
    }

    /// Returns the entry for a case in the report, or null if there is none.
    pub fn case(&self, id: &str) -> &Value {
        let mut cases = self.report["cases"].as_array().into_iter().flatten();
        cases.find(|case| case["id"] == id).unwrap_or(&Value::Null)
    }

    /// Returns the ids of the cases with the given outcome.
    pub fn cases(&self, outcome: &str) -> Vec<String> {
        let cases = self.report["cases"].as_array().into_iter().flatten();
        let matching = cases.filter(|case| case["outcome"] == outcome);
        matching
            .filter_map(|case| case["id"].as_str().map(str::to_owned))
            .collect()
    }

    /// Returns the diagnosed misreadings and their equivalents, most important first.
    pub fn diagnoses(&self) -> Vec<String> {
        let causes = self.report["diagnoses"].as_array().into_iter().flatten();
        let slugs = causes.flat_map(|cause| {
            let equivalents = cause["or"].as_array().into_iter().flatten();
            std::iter::once(&cause["misreading"]).chain(equivalents)
        });
        slugs
            .filter_map(|slug| slug.as_str().map(str::to_owned))
            .collect()
    }
}

/// Returns a command for the program under test.
pub fn program() -> Command {
    Command::new(PROGRAM)
}

/// Path of the program under test.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_ptm-conform");

/// Runs `check` with the rest of a command line in a new workspace.
pub fn check(line: &str) -> CheckRun {
    Workspace::new().check(line)
}

/// Runs `check-writer` with the rest of a command line in a new workspace.
pub fn check_writer(line: &str) -> CheckRun {
    Workspace::new().check_writer(line)
}

/// Runs a `check` command that writes its report to `report`. Returns the result and the peak memory in KiB. The peak memory is 0
/// if /proc is not available.
pub fn run_measured(mut command: Command, report: &Path) -> (CheckRun, u64) {
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let status = format!("/proc/{}/status", child.id());
    // For a moment, a new process has the memory of its parent. It gets its name after its own memory.
    let program = Path::new(command.get_program()).file_name();
    let name: String = program
        .unwrap_or_default()
        .to_string_lossy()
        .chars()
        .take(15)
        .collect();
    let name = format!("Name:\t{name}\n");
    let output = [
        child.stdout.take().map(read_in_background),
        child.stderr.take().map(read_in_background),
    ];
    let mut peak = 0;
    let exit = loop {
        let memory = fs::read_to_string(&status).unwrap_or_default();
        let memory = memory.strip_prefix(&name).unwrap_or_default();
        let memory = memory.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let memory = memory.and_then(|text| text.trim().strip_suffix(" kB")?.parse().ok());
        peak = peak.max(memory.unwrap_or_default());
        if let Some(exit) = child.try_wait().expect("a status") {
            break exit;
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let readers = output.into_iter().flatten();
    let text: Vec<u8> = readers
        .flat_map(|reader| reader.join().expect("no reader panics"))
        .collect();
    let text = String::from_utf8_lossy(&text).into_owned();
    (CheckRun::new(exit.code().unwrap_or(-1), text, report), peak)
}

fn read_in_background(mut pipe: impl Read + Send + 'static) -> JoinHandle<Vec<u8>> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = pipe.read_to_end(&mut bytes);
        bytes
    })
}

/// Asserts that a value conforms to a schema in `spec-cases/schema`.
#[track_caller]
pub fn assert_conforms(value: &Value, schema: &str) {
    let text = repository_text(&format!("spec-cases/schema/{schema}.schema.json"));
    let schema = serde_json::from_str(&text).expect("the schema is JSON");
    let validator = jsonschema::validator_for(&schema).expect("the schema is valid");
    let errors = validator.iter_errors(value).take(5);
    let errors: Vec<String> = errors
        .map(|error| format!("{}: {error}", error.instance_path()))
        .collect();
    assert!(errors.is_empty(), "{errors:#?}");
}

/// Returns the command line of a decoder from the zoo of faulty decoders.
pub fn zoo(kind: &str) -> String {
    let directory = Path::new(PROGRAM).parent().expect("a directory");
    format!("{}/examples/zoo {kind}", directory.display())
}

/// Returns the command line of a Python example, such as `decoders/ptm_decoder.py`.
pub fn python_example(name: &str) -> String {
    format!("python3 {}", repository(&format!("examples/{name}")))
}

/// Returns the absolute path of a file in the repository.
pub fn repository(path: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    root.join(path).to_string_lossy().into_owned()
}

/// Reads a text file in the repository.
pub fn repository_text(path: &str) -> String {
    fs::read_to_string(repository(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Returns true if a program is installed and runs a trivial program of the kind that the tests run. A compiler without headers, a
/// Java without its compiler, or a version that is too old counts as missing. If the program is missing, prints SKIPPED.
pub fn have_tool(program: &str) -> bool {
    let (trial, what) = match program {
        "python3" => (
            "python3 -c 'import sys; sys.exit(sys.version_info < (3, 9))'",
            "python3, version 3.9 or later",
        ),
        "node" => (
            "node -e 'process.exit(Number(parseInt(process.versions.node) < 18))'",
            "node, version 18 or later",
        ),
        "java" => (
            "java --list-modules | grep -q '^jdk[.]compiler@'",
            "java with its compiler (a JDK), version 11 or later",
        ),
        "cc" => (
            "printf '#include <math.h>\\n#include <stdio.h>\\nint main(void) { return 0; }' | cc -x c -o /dev/null - -lm",
            "cc with the headers of the C library",
        ),
        "chromium" | "chromedriver" => {
            return starts(&format!("{program} --version")) || skip(program);
        }
        _ => return starts(&format!("command -v {program}")) || skip(program),
    };
    starts(trial) || skip(what)
}

/// Returns true if the standard library is installed for a compiler target. Prints SKIPPED if not.
pub fn have_target(target: &str) -> bool {
    let libraries = Command::new("rustc")
        .args(["--print", "target-libdir", "--target", target])
        .output();
    libraries.is_ok_and(|output| Path::new(String::from_utf8_lossy(&output.stdout).trim()).exists())
        || skip(&format!("rustc with the target {target}"))
}

/// Returns true if these modules or packages can be imported in python3. Prints SKIPPED if not.
pub fn have_python(packages: &[&str]) -> bool {
    let imports = packages.join(", ");
    have_tool("python3")
        && (starts(&format!("python3 -c 'import {imports}'"))
            || skip(&format!("{imports} for python3")))
}

/// Returns true if a shell command succeeds.
pub fn starts(command: &str) -> bool {
    let output = Command::new("sh").args(["-c", command]).output();
    output.is_ok_and(|output| output.status.success())
}
