//! Counts the tests that were skipped, and says how to run them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

#[allow(dead_code, reason = "the tests skip, and this target only counts")]
#[path = "it/skip.rs"]
mod skip;

fn main() {
    let path = skip::list();
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
