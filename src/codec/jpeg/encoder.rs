//! T.81 B.2.1: the order of a stream, written
//!
//! The way of `decoder` and its neighbors backwards, as libjpeg goes it: with the default options
//! every byte equals what `cjpeg -baseline -dct int -grayscale -quality Q` writes:
//!
//! ```text
//! SOI  APP0 (JFIF)  DQT  SOF0 or SOF1  DHT (DC)  DHT (AC)  [DRI]  SOS  data  EOI
//! ```
//!
//! Format notes
//! - The samples that come back beside the stream are those of `inverse_dct`: whoever predicts the
//!   next plane from this one must know what the decoder will have.
//! - libjpeg writes each Huffman table in a segment of its own, and the restart interval after them.

use super::huffman_tables::{optimal_tables, typical_tables, write_tables};
use super::quantization::{quantize_image, scaled_steps};
use super::symbols::{symbols_of, write_symbols};
use super::zigzag::ZIGZAG;
use crate::codec::markers::{APP0, DRI};
use crate::codec::writer::{Encoded, Writer, check_size};

/// How to encode; the spellings of one image that the standard allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct JpegOptions {
    /// 1 … 100, as the Independent JPEG Group counts it.
    pub quality: u8,
    /// No quantization step over 255, so that the frame is baseline (SOF0) at every quality.
    /// Without, a quality below 24 needs 16-bit tables and an extended sequential frame (SOF1).
    pub baseline: bool,
    /// Huffman tables made for this image instead of those of Annex K.
    pub optimized: bool,
    /// Blocks from one restart marker to the next; 0 for no restart markers.
    pub restart_interval: u16,
    /// Horizontal and vertical sampling factor of the component, 1 … 4. They change nothing but
    /// their byte.
    pub sampling: (u8, u8),
}

impl JpegOptions {
    /// The ordinary file of a quality: baseline, the tables of Annex K, no restart markers, factors
    /// 1 × 1.
    #[must_use]
    pub fn new(quality: u8) -> JpegOptions {
        JpegOptions {
            quality,
            baseline: true,
            optimized: false,
            restart_interval: 0,
            sampling: (1, 1),
        }
    }
}

/// Encodes `width` × `height` samples, given in row order from the top.
///
/// # Panics
///
/// If there are not `width` × `height` samples, a side is not within 1 … 65,535, or an option is
/// out of its range.
#[must_use]
pub fn encode(samples: &[u8], width: u32, height: u32, options: &JpegOptions) -> Encoded {
    check_size(samples, width, height);
    let (quality, (h, v)) = (options.quality, options.sampling);
    assert!((1..=100).contains(&quality), "quality {quality}");
    let legal = (1..=4).contains(&h) && (1..=4).contains(&v);
    assert!(legal, "sampling factors {h} x {v}");
    let steps = scaled_steps(quality, options.baseline);
    let image = quantize_image(samples, width as usize, height as usize, &steps);
    let symbols = symbols_of(&image.blocks, usize::from(options.restart_interval));
    let tables = match options.optimized {
        true => optimal_tables(&symbols),
        false => typical_tables(),
    };

    let mut stream = Writer::new();
    write_jfif(&mut stream);
    write_quantization(&mut stream, &steps);
    let sof = if wide(&steps) { 0xC1 } else { 0xC0 };
    stream.frame_header(sof, width, height, options.sampling);
    write_tables(&mut stream, &tables);
    if options.restart_interval > 0 {
        stream.segment(DRI, &options.restart_interval.to_be_bytes());
    }
    stream.scan_header([0, 63, 0]); // the whole spectrum (Table B.3)
    write_symbols(&mut stream, &symbols, &tables);
    Encoded {
        stream: stream.finish(),
        samples: image.decoded,
    }
}

/// The application segment of JFIF 1.01: no unit, pixels as wide as high, no thumbnail.
fn write_jfif(stream: &mut Writer) {
    stream.segment(APP0, b"JFIF\0\x01\x01\x00\x00\x01\x00\x01\x00\x00");
}

/// Whether a quantization step does not fit in a byte.
fn wide(steps: &[u16; 64]) -> bool {
    steps.iter().any(|&step| step > 255)
}

/// B.2.4.1: precision and number 0, then the steps in zigzag order.
fn write_quantization(stream: &mut Writer, steps: &[u16; 64]) {
    let wide = wide(steps);
    let mut content = vec![u8::from(wide) << 4];
    for i in ZIGZAG {
        let [high, low] = steps[usize::from(i)].to_be_bytes();
        if wide {
            content.push(high);
        }
        content.push(low);
    }
    stream.segment(0xDB, &content);
}
