//! T.87 C.2: writing a stream

use super::encode_scan::encode_scan;
use super::parameters::{Parameters, PresetParameters};
use crate::codec::writer::{EncodedImage, Writer, check_size};

/// Options of the JPEG-LS encoder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct JpegLsOptions {
    /// Maximum error of a sample, or 0 for lossless coding.
    pub near: u8,
    /// Number of bits per sample, 2 … 8.
    pub precision: u8,
    /// Preset parameters. If absent, no LSE segment is written.
    pub presets: Option<PresetParameters>,
}

/// Encodes `width` × `height` samples, which are in row order from the top.
///
/// # Panics
/// Panics if the number of samples is not `width` × `height`, a side is not within 1 … 65,535, a sample exceeds
/// MAXVAL, or an option is out of range.
#[must_use]
pub fn encode(samples: &[u8], width: u32, height: u32, options: &JpegLsOptions) -> EncodedImage {
    check_size(samples, width, height);
    let parameters = Parameters::new(
        options.precision,
        &options.presets.unwrap_or_default(),
        0,
        options.near,
        0,
    )
    .unwrap_or_else(|error| panic!("{error}"));
    let maxval = parameters.maxval;
    if let Some(sample) = samples.iter().find(|&&sample| i32::from(sample) > maxval) {
        panic!("sample {sample} exceeds MAXVAL {maxval}");
    }

    let mut stream = Writer::new();
    stream.write_frame_header(0xF7, options.precision, width, height, [0x11, 0]);
    if let Some(presets) = options.presets {
        write_presets(&mut stream, presets);
    }
    stream.write_scan_header(0, [options.near, 0, 0]); // not interleaved, no point transform (C.2.3)
    let samples = encode_scan(&mut stream, &parameters, samples, width);
    let stream = stream.finish();
    EncodedImage { stream, samples }
}

/// Writes a segment of type 1 with the five parameters (C.2.4.1.1).
fn write_presets(stream: &mut Writer, presets: PresetParameters) {
    let p = presets;
    let numbers = [p.maxval, p.t1, p.t2, p.t3, p.reset].map(u16::to_be_bytes);
    stream.write_segment(0xF8, &[&[1], &numbers.concat()[..]].concat());
}
