//! The npm package: built by its script, tried by its own test, its reference once more in a browser.

use std::path::Path;
use std::process::Command;

use crate::common::{have, have_target, repository};

const PROGRAM: &str = env!("CARGO_BIN_EXE_ptm-conform");
const TARGET: &str = "wasm32-unknown-unknown";

/// What a command says; it must succeed.
#[track_caller]
fn said(command: &mut Command) -> String {
    let output = command.output().expect("it starts");
    assert!(output.status.success(), "{output:?}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Builds the package; its reference is not optimized as it is released, which takes longer than all that is tried here.
fn build(package: &Path) {
    let directory = concat!(env!("CARGO_TARGET_TMPDIR"), "/wasm");
    said(
        Command::new("cargo")
            .args(["build", "--quiet", "--release", "--locked"])
            .args(["--target", TARGET, "--target-dir", directory])
            .env("RUSTFLAGS", "-D warnings")
            .env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "1")
            .env("CARGO_PROFILE_RELEASE_LTO", "off")
            .env("CARGO_PROFILE_RELEASE_CODEGEN_UNITS", "16")
            .arg("--manifest-path")
            .arg(repository("packages/wasm/Cargo.toml")),
    );
    said(
        Command::new("node")
            .arg(repository("packages/npm/build.mjs"))
            .args([Path::new(PROGRAM), package])
            .arg("--module")
            .arg(format!(
                "{directory}/{TARGET}/release/ptm_conform_wasm.wasm"
            )),
    );
}

#[test]
fn the_package_reads_every_file_as_the_program_does_in_node_and_in_a_browser() {
    if !(have("node") && have_target(TARGET)) {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let package = scratch.path().join("package");
    build(&package);
    let own = said(
        Command::new("node")
            .arg("test.mjs")
            .current_dir(&package)
            .env("PTM_CONFORM_PROGRAM", PROGRAM),
    );
    assert!(own.contains("as the program reads them"), "{own}");
    if !(have("chromium") && have("chromedriver")) {
        return;
    }
    let browser = said(
        Command::new("node")
            .arg(repository("tests/it/packages/browser.mjs"))
            .args([&package, Path::new(PROGRAM)]),
    );
    assert!(browser.contains("as the program reads them"), "{browser}");
}
