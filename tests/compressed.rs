//! The suite of 2.9 loads, and its files are what they are said to be.
#![cfg(feature = "harness")]

use ptm_conform::harness::cases::Suite;

#[test]
fn the_suite_loads() {
    let suite = Suite::load().unwrap_or_else(|why| panic!("{why}"));
    println!("{} cases", suite.cases.len());
}
