//! Whatever a decoder answers, the search for causes ends without a fault.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ptm_conform::fuzz::properties;

fuzz_target!(|bytes: &[u8]| properties::diagnosis(bytes));
