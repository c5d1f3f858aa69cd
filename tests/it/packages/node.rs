//! The npm package: its build script, its test, and its reference decoder in a browser.

use std::path::Path;
use std::process::Command;

use crate::common::{PROGRAM, Workspace, have_target, have_tool, repository, stdout};

const TARGET: &str = "wasm32-unknown-unknown";

const DIRECTORY: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/wasm");

/// Returns the path of the built module.
fn module() -> String {
    format!("{DIRECTORY}/{TARGET}/release/ptm_conform_wasm.wasm")
}

/// Builds the package with little optimization, because a release build would take too long.
fn build(package: &Path) {
    stdout(
        Command::new("cargo")
            .args(["build", "--quiet", "--release", "--locked"])
            .args(["--target", TARGET, "--target-dir", DIRECTORY])
            .arg("--config=profile.release.package.'*'.opt-level=0")
            .arg("--config=profile.release.package.ptm-conform.opt-level=1")
            .env("RUSTFLAGS", "-D warnings")
            .env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "1")
            .env("CARGO_PROFILE_RELEASE_LTO", "off")
            .env("CARGO_PROFILE_RELEASE_CODEGEN_UNITS", "4")
            .arg("--manifest-path")
            .arg(repository("packages/wasm/Cargo.toml")),
    );
    stdout(
        Command::new("node")
            .arg(repository("packages/npm/build.mjs"))
            .args([Path::new(PROGRAM), package])
            .arg("--module")
            .arg(module()),
    );
}

#[test]
fn npm_package_reads_files_like_the_program_in_node_and_in_a_browser() {
    if !(have_tool("node") && have_target(TARGET)) {
        return;
    }
    let here = Workspace::new();
    let package = here.path("package");
    build(&package);
    let tested = stdout(
        Command::new("node")
            .arg("test.mjs")
            .current_dir(&package)
            .env("PTM_CONFORM_PROGRAM", PROGRAM),
    );
    assert!(tested.contains("equal to the program"), "{tested}");
    if !(have_tool("chromium") && have_tool("chromedriver")) {
        return;
    }
    let browser = stdout(
        Command::new("node")
            .arg(repository("tests/it/packages/browser.mjs"))
            .args([&package, Path::new(PROGRAM)]),
    );
    assert!(browser.contains("equal to the program"), "{browser}");
    stdout(here.command("site --out site --module").arg(module()));
    let dropped = stdout(
        Command::new("node")
            .arg(repository("tests/it/packages/drop.mjs"))
            .arg(here.path("site/drop.html")),
    );
    assert!(dropped.contains("the light moved"), "{dropped}");
}
