//! Tests that need more than the Rust toolchain say what they need.

use std::io::Write;

/// Prints which test is skipped for want of what, also where the output of tests is captured, and returns false. Panics if
/// `PTM_CONFORM_SKIP_NOTHING` is set.
pub fn skip(missing: &str) -> bool {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or_default();
    let line = format!("SKIPPED {test}: needs {missing}\n");
    let _ = std::io::stderr().write_all(line.as_bytes());
    assert!(
        std::env::var_os("PTM_CONFORM_SKIP_NOTHING").is_none(),
        "no test may be skipped here: {test} needs {missing}"
    );
    false
}
