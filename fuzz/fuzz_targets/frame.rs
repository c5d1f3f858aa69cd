//! Any output of a decoder is a frame or is told why not.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ptm_conform::fuzz::properties;

fuzz_target!(|bytes: &[u8]| properties::frame(bytes));
