//! T.81 B.2.1: writing a stream
//!
//! This is the inverse of `decoder` and its neighbors. It works like libjpeg: with the default options, the stream is identical
//! to that of `cjpeg -baseline -dct int -grayscale -quality Q`.
//!
//! ```text
//! SOI  APP0 (JFIF)  DQT  SOF0 or SOF1  DHT (DC)  DHT (AC)  [DRI]  SOS  data  EOI
//! ```
//!
//! Format notes
//! - The samples returned with the stream are computed by `inverse_dct`, because other planes are predicted from decoded samples.
//! - libjpeg writes each Huffman table in a separate segment, and the restart interval after the last table.
//! - Unused tables are legal. Here, the quantization steps of unused tables are all 1, and each unused Huffman table contains
//!   only the one-bit code 0, for symbol 0.

use super::huffman_table::HuffmanTable;
use super::huffman_tables::{optimal_tables, typical_tables};
use super::quantization::{quantize_image, scaled_steps};
use super::symbols::{image_symbols, write_symbols};
use super::zigzag::ZIGZAG;
use crate::codec::markers::{APP0, DRI};
use crate::codec::writer::{EncodedImage, Writer, check_size};

/// Options of the encoder: the choices that the standard leaves to encoders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct JpegOptions {
    /// Quality, 1 … 100, as defined by the Independent JPEG Group.
    pub quality: u8,
    /// Limits quantization steps to 255, so that the frame is baseline (SOF0) at every quality. Without this limit, a quality
    /// below 24 requires 16-bit tables and an extended sequential frame (SOF1).
    pub baseline: bool,
    /// Optimizes the Huffman tables for the image instead of using the tables of Annex K.
    pub optimized: bool,
    /// Number of blocks between restart markers, or 0 for no restart markers.
    pub restart_interval: u16,
    /// Horizontal and vertical sampling factors of the component, 1 … 4. They only affect the byte that stores them.
    pub sampling: (u8, u8),
    /// A single quantization step for all coefficients, instead of the steps for the quality. A step over 255
    /// requires 16-bit tables and SOF1, like a quality below 24.
    pub step: Option<u16>,
    /// Indices of the quantization, DC and AC tables, each at most 3 (default 0). Huffman table indices over 1 require an
    /// extended frame. If set, the stream contains tables 0 and 1 of each kind, and all other tables up to the index, although
    /// only one is used.
    pub table_numbers: Option<[u8; 3]>,
    /// Writes all quantization tables in one segment, and all Huffman tables in another.
    pub tables_together: bool,
}

impl JpegOptions {
    /// Returns the default options for a quality: baseline, tables of Annex K, no restart markers, sampling factors 1 × 1.
    #[must_use]
    pub const fn new(quality: u8) -> JpegOptions {
        JpegOptions {
            quality,
            baseline: true,
            optimized: false,
            restart_interval: 0,
            sampling: (1, 1),
            step: None,
            table_numbers: None,
            tables_together: false,
        }
    }
}

/// Encodes `width` × `height` samples, which are in row order from the top.
///
/// # Panics
/// Panics if the number of samples is not `width` × `height`, a side is not within 1 … 65,535, or an option is out of range.
#[must_use]
pub fn encode(samples: &[u8], width: u32, height: u32, options: &JpegOptions) -> EncodedImage {
    check_size(samples, width, height);
    let (quality, (h, v)) = (options.quality, options.sampling);
    assert!((1..=100).contains(&quality), "quality {quality}");
    let legal = (1..=4).contains(&h) && (1..=4).contains(&v);
    assert!(legal, "sampling factors {h} x {v}");
    let [quantization, dc, ac] = options.table_numbers.unwrap_or_default();
    let valid_indices = quantization < 4 && dc < 4 && ac < 4;
    assert!(valid_indices, "tables {quantization}, {dc} and {ac}");
    let steps = match options.step {
        Some(step) => [step; 64],
        None => scaled_steps(quality, options.baseline),
    };
    let (blocks, samples) = quantize_image(samples, width as usize, height as usize, &steps);
    let symbols = image_symbols(&blocks, usize::from(options.restart_interval));
    let tables = match options.optimized {
        true => optimal_tables(&symbols),
        false => typical_tables(),
    };

    let mut stream = Writer::new();
    // JFIF 1.01: no unit, square pixels, no thumbnail.
    stream.write_segment(APP0, b"JFIF\0\x01\x01\x00\x00\x01\x00\x01\x00\x00");
    write_quantization(&mut stream, &steps, options);
    let extended = needs_16_bits(&steps) || dc > 1 || ac > 1; // Table B.5
    let sof = if extended { 0xC1 } else { 0xC0 };
    stream.write_frame_header(sof, 8, width, height, [h << 4 | v, quantization]);
    write_huffman(&mut stream, &tables, options);
    if options.restart_interval > 0 {
        stream.write_segment(DRI, &options.restart_interval.to_be_bytes());
    }
    stream.write_scan_header(dc << 4 | ac, [0, 63, 0]); // the whole spectrum (Table B.3)
    write_symbols(&mut stream, &symbols, &tables);
    let stream = stream.finish();
    EncodedImage { stream, samples }
}

/// Returns true if some quantization step does not fit in a byte.
fn needs_16_bits(steps: &[u16; 64]) -> bool {
    steps.iter().any(|&step| step > 255)
}

/// Writes quantization tables: precision and index, then the steps in zigzag order (B.2.4.1).
fn write_quantization(stream: &mut Writer, steps: &[u16; 64], options: &JpegOptions) {
    let wide = needs_16_bits(steps);
    let table = |number: u8, is_used: bool| {
        let mut content = vec![u8::from(wide) << 4 | number];
        for i in ZIGZAG {
            let step = if is_used { steps[usize::from(i)] } else { 1 };
            let bytes = step.to_be_bytes();
            content.extend(&bytes[usize::from(!wide)..]);
        }
        content
    };
    let tables = tables_to_write(options, 0).map(|(number, is_used)| table(number, is_used));
    write_tables(stream, 0xDB, &tables.collect::<Vec<_>>(), options);
}

/// Writes Huffman tables, DC tables first: class and index, the code counts, then the symbols (B.2.4.2).
fn write_huffman(stream: &mut Writer, tables: &[HuffmanTable; 2], options: &JpegOptions) {
    let mut contents = Vec::new();
    for (class, used) in (0..).zip(tables) {
        let mut unused = HuffmanTable {
            counts: [0; 16],
            symbols: vec![0],
        };
        unused.counts[0] = 1;
        for (number, is_used) in tables_to_write(options, 1 + usize::from(class)) {
            let table = if is_used { used } else { &unused };
            contents.push([&[class << 4 | number], &table.counts[..], &table.symbols].concat());
        }
    }
    write_tables(stream, 0xC4, &contents, options);
}

/// Returns the indices of the tables to write, each with a flag that is true if the table is used.
fn tables_to_write(options: &JpegOptions, kind: usize) -> impl Iterator<Item = (u8, bool)> {
    let used = options.table_numbers.map(|numbers| numbers[kind]);
    let last = used.map_or(0, |used| used.max(1));
    (0..=last).map(move |number| (number, number == used.unwrap_or(0)))
}

/// Writes tables of one kind, in separate segments or in a single one.
fn write_tables(stream: &mut Writer, code: u8, tables: &[Vec<u8>], options: &JpegOptions) {
    let all = [tables.concat()];
    let contents = match options.tables_together {
        true => &all,
        false => tables,
    };
    for content in contents {
        stream.write_segment(code, content);
    }
}
