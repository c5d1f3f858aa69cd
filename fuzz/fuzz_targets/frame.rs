//! Any output of a decoder gives a frame or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ptm_harness::fuzz::properties;

fuzz_target!(|bytes: &[u8]| properties::frame(bytes));
