//! Runs the program as its users do.

use std::io::Read;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::JoinHandle;
use std::time::Duration;

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

    /// Returns the misreadings that are named or would look the same, the most telling first.
    pub fn diagnoses(&self) -> Vec<String> {
        let causes = self.report["diagnoses"]
            .as_array()
            .cloned()
            .unwrap_or_default();
        causes
            .iter()
            .flat_map(|cause| {
                let equivalents = cause["or"].as_array().cloned().unwrap_or_default();
                std::iter::once(cause["misreading"].clone()).chain(equivalents)
            })
            .filter_map(|slug| slug.as_str().map(str::to_owned))
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
        .and_then(|text| ptm_conform::kit::yaml::from_yaml(&text).ok());
    Checked {
        status: output.status.code().unwrap_or(-1),
        text: String::from_utf8_lossy(&text).into_owned(),
        report: report.unwrap_or_default(),
    }
}

/// Runs a `check` whose report goes to `report`, and says how much memory it held at most, in KiB (0 where there is no
/// /proc).
pub fn measured(mut command: Command, report: &Path) -> (Checked, u64) {
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let status = format!("/proc/{}/status", child.id());
    let output = [
        child.stdout.take().map(read_aside),
        child.stderr.take().map(read_aside),
    ];
    let mut most = 0;
    let exit = loop {
        let held = std::fs::read_to_string(&status).unwrap_or_default();
        let held = held.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let held = held.and_then(|held| held.trim().strip_suffix(" kB")?.parse().ok());
        most = most.max(held.unwrap_or_default());
        if let Some(exit) = child.try_wait().expect("it can be waited for") {
            break exit;
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let text: Vec<u8> = output
        .into_iter()
        .flatten()
        .flat_map(|reader| reader.join().expect("no reader panics"))
        .collect();
    let report = std::fs::read_to_string(report)
        .ok()
        .and_then(|text| ptm_conform::kit::yaml::from_yaml(&text).ok());
    let checked = Checked {
        status: exit.code().unwrap_or(-1),
        text: String::from_utf8_lossy(&text).into_owned(),
        report: report.unwrap_or_default(),
    };
    (checked, most)
}

fn read_aside(mut pipe: impl Read + Send + 'static) -> JoinHandle<Vec<u8>> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = pipe.read_to_end(&mut bytes);
        bytes
    })
}

/// What keeps a report from conforming to its schema.
pub fn report_errors(report: &serde_json::Value) -> Vec<String> {
    let schema = std::fs::read_to_string(repository("spec-cases/schema/report.schema.json"));
    let schema = serde_json::from_str(&schema.expect("a schema")).expect("a schema is JSON");
    let validator = jsonschema::validator_for(&schema).expect("a schema is a schema");
    let errors = validator.iter_errors(report);
    errors
        .take(5)
        .map(|error| format!("{}: {error}", error.instance_path()))
        .collect()
}

/// Keeps processors busy as long as it lives.
pub struct Load(Vec<Child>);

impl Load {
    /// Keeps so many busy.
    pub fn new(processors: usize) -> Load {
        let busy = |_| {
            let mut shell = Command::new("sh");
            shell.args(["-c", "while :; do :; done"]).spawn()
        };
        Load((0..processors).filter_map(|i| busy(i).ok()).collect())
    }
}

impl Drop for Load {
    fn drop(&mut self) {
        for child in &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Lets a file be executed.
pub fn make_executable(path: &Path) {
    let executable = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(path, executable).expect("permissions");
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
    there || skipped(&format!("{program} is not there"))
}

/// Whether the compiler has the libraries of a target.
pub fn have_target(target: &str) -> bool {
    let libraries = Command::new("rustc")
        .args(["--print", "target-libdir", "--target", target])
        .output();
    libraries.is_ok_and(|output| Path::new(String::from_utf8_lossy(&output.stdout).trim()).exists())
        || skipped(&format!("rustc has no {target}"))
}

/// Whether python3 has these packages; says SKIPPED if not.
pub fn have_python(packages: &[&str]) -> bool {
    let imports = packages.join(", ");
    let imported = Command::new("python3")
        .args(["-c", &format!("import {imports}")])
        .output();
    imported.is_ok_and(|output| output.status.success())
        || skipped(&format!("python3 with {imports} is not there"))
}

/// Says why a test does nothing; false. Where everything that can be installed is (`PTM_CONFORM_SKIP_NOTHING`), a skip is
/// a failure.
fn skipped(why: &str) -> bool {
    println!("SKIPPED: {why}");
    assert!(
        std::env::var_os("PTM_CONFORM_SKIP_NOTHING").is_none(),
        "nothing may be skipped here: {why}"
    );
    false
}
