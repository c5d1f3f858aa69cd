//! A JPEG-LS stream decodes to the values of its encoder.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ptm_harness::fuzz::properties;

fuzz_target!(|bytes: &[u8]| properties::jpeg_ls_round_trip(bytes));
