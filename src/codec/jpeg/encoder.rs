//! T.81 B.2.1: the order of a stream, written
//!
//! The inverse of `decoder` and its neighbors, in the same way as libjpeg: with the default options every byte equals the
//! output of `cjpeg -baseline -dct int -grayscale -quality Q`:
//!
//! ```text
//! SOI  APP0 (JFIF)  DQT  SOF0 or SOF1  DHT (DC)  DHT (AC)  [DRI]  SOS  data  EOI
//! ```
//!
//! Format notes
//! - The samples that are returned with the stream are those of `inverse_dct`: a plane is predicted
//!   from the samples that the decoder has.
//! - libjpeg writes each Huffman table in a separate segment, and the restart interval after them.
//! - Unused tables are legal. If there are any, their quantization steps are all 1, and their Huffman tables have one
//!   code, the bit 0 for the symbol 0.

use super::huffman_table::HuffmanTable;
use super::huffman_tables::{optimal_tables, typical_tables};
use super::quantization::{quantize_image, scaled_steps};
use super::symbols::{symbols_of, write_symbols};
use super::zigzag::ZIGZAG;
use crate::codec::markers::{APP0, DRI};
use crate::codec::writer::{Encoded, Writer, check_size};

/// Options of the encoder: the spellings of one image that the standard allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct JpegOptions {
    /// 1 … 100, by the Independent JPEG Group's definition.
    pub quality: u8,
    /// No quantization step over 255, so that the frame is baseline (SOF0) at every quality. Otherwise, a quality below 24
    /// needs 16-bit tables and an extended sequential frame (SOF1).
    pub baseline: bool,
    /// Huffman tables optimized for this image instead of those of Annex K.
    pub optimized: bool,
    /// Number of blocks between restart markers; 0 for no restart markers.
    pub restart_interval: u16,
    /// Horizontal and vertical sampling factor of the component, 1 … 4. They have no effect except on their byte.
    pub sampling: (u8, u8),
    /// One quantization step for all coefficients instead of those of the quality; a step over 255 needs 16-bit tables and
    /// SOF1, like qualities below 24.
    pub step: Option<u16>,
    /// The numbers of the quantization, the DC and the AC table, at most 3; Huffman tables over 1 need an extended frame.
    /// Tables from 0 to 1 or to the number are then all defined, although only these are used. By default, all numbers are 0.
    pub table_numbers: Option<[u8; 3]>,
    /// All quantization tables in one segment, and all Huffman tables in one.
    pub tables_together: bool,
}

impl JpegOptions {
    /// Returns the default options for a quality: baseline, the tables of Annex K, no restart markers, factors 1 × 1.
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
    let [quantization, dc, ac] = options.table_numbers.unwrap_or_default();
    let numbered = quantization < 4 && dc < 4 && ac < 4;
    assert!(numbered, "tables {quantization}, {dc} and {ac}");
    let steps = match options.step {
        Some(step) => [step; 64],
        None => scaled_steps(quality, options.baseline),
    };
    let image = quantize_image(samples, width as usize, height as usize, &steps);
    let symbols = symbols_of(&image.blocks, usize::from(options.restart_interval));
    let tables = match options.optimized {
        true => optimal_tables(&symbols),
        false => typical_tables(),
    };

    let mut stream = Writer::new();
    write_jfif(&mut stream);
    write_quantization(&mut stream, &steps, options);
    let extended = needs_16_bits(&steps) || dc > 1 || ac > 1; // Table B.5
    let sof = if extended { 0xC1 } else { 0xC0 };
    stream.frame_header(sof, width, height, [h << 4 | v, quantization]);
    write_huffman(&mut stream, &tables, options);
    if options.restart_interval > 0 {
        stream.segment(DRI, &options.restart_interval.to_be_bytes());
    }
    stream.scan_header(dc << 4 | ac, [0, 63, 0]); // the whole spectrum (Table B.3)
    write_symbols(&mut stream, &symbols, &tables);
    Encoded {
        stream: stream.finish(),
        samples: image.decoded,
    }
}

/// Writes the application segment of JFIF 1.01: no unit, square pixels, no thumbnail.
fn write_jfif(stream: &mut Writer) {
    stream.segment(APP0, b"JFIF\0\x01\x01\x00\x00\x01\x00\x01\x00\x00");
}

/// Returns true if a quantization step does not fit in a byte.
fn needs_16_bits(steps: &[u16; 64]) -> bool {
    steps.iter().any(|&step| step > 255)
}

/// Writes precision and number, then the steps in zigzag order (B.2.4.1).
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
    let tables = used_tables(options, 0).map(|(number, is_used)| table(number, is_used));
    write_tables(stream, 0xDB, &tables.collect::<Vec<_>>(), options);
}

/// Writes class and number, the numbers of codes, the symbols; DC tables first (B.2.4.2).
fn write_huffman(stream: &mut Writer, tables: &[HuffmanTable; 2], options: &JpegOptions) {
    let mut contents = Vec::new();
    for (class, used) in (0..).zip(tables) {
        let mut unused = HuffmanTable {
            counts: [0; 16],
            symbols: vec![0],
        };
        unused.counts[0] = 1;
        for (number, is_used) in used_tables(options, 1 + usize::from(class)) {
            let table = if is_used { used } else { &unused };
            contents.push([&[class << 4 | number], &table.counts[..], &table.symbols].concat());
        }
    }
    write_tables(stream, 0xC4, &contents, options);
}

/// Returns the numbers of the tables of one kind, each with true if it is used.
fn used_tables(options: &JpegOptions, kind: usize) -> impl Iterator<Item = (u8, bool)> {
    let used = options.table_numbers.map(|numbers| numbers[kind]);
    let last = used.map_or(0, |used| used.max(1));
    (0..=last).map(move |number| (number, number == used.unwrap_or(0)))
}

/// Writes tables of one kind, in one segment each or in one for all.
fn write_tables(stream: &mut Writer, code: u8, tables: &[Vec<u8>], options: &JpegOptions) {
    let all = [tables.concat()];
    let contents = if options.tables_together {
        &all
    } else {
        tables
    };
    for content in contents {
        stream.segment(code, content);
    }
}
