//! Counts the tests that were skipped, and says how to run them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

fn main() {
    #[cfg(unix)]
    let parent = std::os::unix::process::parent_id();
    #[cfg(not(unix))]
    let parent = 0;
    // The tests of this `cargo test` have written it (tests/it/skip.rs).
    let path = format!("{}/skipped-{parent}", env!("CARGO_TARGET_TMPDIR"));
    let list = fs::read_to_string(&path).unwrap_or_default();
    let _ = fs::remove_file(&path);
    let mut needs: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (test, missing) in list.lines().filter_map(|line| line.split_once('\t')) {
        needs.entry(missing).or_default().insert(test);
    }
    let tests: BTreeSet<&str> = needs.values().flatten().copied().collect();
    if tests.is_empty() {
        return println!("\nno test was skipped for want of another program");
    }
    println!("\n{} tests were skipped, because they need", tests.len());
    for (missing, tests) in needs {
        println!("  {missing}: {}", tests.len());
    }
    println!("To install all of it (Debian or Ubuntu) and run them:");
    println!("  .ci/install && PATH=\"$PWD/target/python/bin:$PATH\" cargo test");
}
