//! Decoding any bytes as a JPEG stream gives samples or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ptm_harness::fuzz::properties;

fuzz_target!(|bytes: &[u8]| properties::jpeg_stream(bytes));
