//! A drawn file decodes to what was painted.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ptm_conform::fuzz::properties;

fuzz_target!(|bytes: &[u8]| properties::recipe(bytes));
