//! A JPEG stream decodes to the values of its encoder, and to similar values in another decoder.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ptm_harness::fuzz::properties;

fuzz_target!(|bytes: &[u8]| {
    let Some((stream, width, _, samples)) = properties::jpeg_round_trip(bytes) else {
        return;
    };
    let theirs = jpeg_decoder::Decoder::new(&stream[..]).decode();
    let theirs = theirs.expect("a legal stream");
    assert!(properties::nearly_equal(&samples, &theirs, width));
});
