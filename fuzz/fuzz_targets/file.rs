//! Decoding any bytes gives planes or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ptm_harness::fuzz::properties;

fuzz_target!(|bytes: &[u8]| properties::file(bytes));
