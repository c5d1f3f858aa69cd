//! Tests that need more than the Rust toolchain say what they need.

use std::fs::OpenOptions;
use std::io::Write;

/// Prints which test is skipped for want of what, also where the output of tests is captured, and returns false. The test target
/// `skipped` counts these tests at the end. Panics if `PTM_CONFORM_SKIP_NOTHING` is set.
pub fn skip(missing: &str) -> bool {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or_default();
    let line = format!("SKIPPED {test}: needs {missing}\n");
    let _ = std::io::stderr().write_all(line.as_bytes());
    let file = OpenOptions::new().create(true).append(true).open(list());
    if let Ok(mut file) = file {
        let _ = file.write_all(format!("{test}\t{missing}\n").as_bytes());
    }
    assert!(
        std::env::var_os("PTM_CONFORM_SKIP_NOTHING").is_none(),
        "no test may be skipped here: {test} needs {missing}"
    );
    false
}

/// Returns the path of the list of skipped tests, which `tests/skipped.rs` reads. All test targets of a `cargo test` have the same
/// parent process.
pub fn list() -> String {
    #[cfg(unix)]
    let parent = std::os::unix::process::parent_id();
    #[cfg(not(unix))]
    let parent = 0;
    format!("{}/skipped-{parent}", env!("CARGO_TARGET_TMPDIR"))
}
