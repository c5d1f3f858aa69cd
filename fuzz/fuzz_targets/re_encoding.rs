//! Uncompressed texels and lossless JPEG-LS of one image decode to the same planes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ptm_harness::fuzz::properties;

fuzz_target!(|bytes: &[u8]| properties::re_encoding(bytes));
