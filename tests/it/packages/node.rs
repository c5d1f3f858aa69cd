//! The npm package: built by its script, tried by its own test.

use std::process::Command;

use crate::common::{have, repository};

#[test]
fn the_package_for_node_passes_its_own_test() {
    if !have("node") {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let out = scratch.path().join("package");
    let program = env!("CARGO_BIN_EXE_ptm-conform");
    let built = Command::new("node")
        .arg(repository("packages/npm/build.mjs"))
        .arg(program)
        .arg(&out)
        .output()
        .expect("node starts");
    assert!(built.status.success(), "{built:?}");
    let tried = Command::new("node")
        .arg("test.mjs")
        .current_dir(&out)
        .env("PTM_CONFORM_PROGRAM", program)
        .output()
        .expect("node starts");
    let said = String::from_utf8_lossy(&tried.stdout);
    assert!(tried.status.success(), "{tried:?}");
    assert!(said.contains("all right"), "{said}");
}
