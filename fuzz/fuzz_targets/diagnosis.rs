//! The search for causes ends without an internal error for any answers of a decoder.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ptm_harness::fuzz::properties;

fuzz_target!(|bytes: &[u8]| properties::diagnosis(bytes));
