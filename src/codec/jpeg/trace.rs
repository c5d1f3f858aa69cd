//! What the blocks of a stream are made of, for whoever looks for a mistake in another decoder
//!
//! The question is what the blocks have in common that come out wrong there. So a stream is read once more
//! with `decode_block`, over a reader of bits that notes the codes as they pass, and with steps of 1, so
//! that the coefficients stay as they are stored.

use std::ops::Range;

use super::decode_block::decode_block;
use super::decoder::read_headers;
use super::huffman::{ReadSymbols, decode_symbol};
use super::huffman_table::HuffmanTable;
use super::scan::{intervals, read_restart};
use super::tables::Tables;
use super::zigzag::ZIGZAG;
use crate::codec::bits::{Bits, ReadBits};
use crate::codec::markers::Cursor;
use crate::codec::stream_error::Result;

/// A block as it is stored.
pub struct BlockTrace {
    /// Quantized, in zigzag order.
    pub coefficients: [i32; 64],
    /// The DC coefficient as it was coded.
    pub dc_difference: i32,
    /// The Huffman codes, each as its symbol and its length: one for DC, then those for AC.
    pub codes: Vec<(u8, u32)>,
    /// The bytes that hold its bits.
    pub bytes: Range<usize>,
    /// How many restart markers stand before it.
    pub markers: usize,
    /// Whether one of them stands right before it.
    pub is_restarted: bool,
}

/// The blocks of a stream in their order, and the quantization steps in zigzag order.
///
/// # Errors
///
/// As [`decode`](super::decode).
pub fn trace(stream: &[u8], width: u32, height: u32) -> Result<(Vec<BlockTrace>, [u16; 64])> {
    let mut cursor = Cursor::open(stream)?;
    let tables = read_headers(&mut cursor, &mut Tables::default(), width, height)?;
    let (blocks, interval) = intervals(&tables, width, height);
    let mut bits = NotingBits::new(stream, cursor.at);
    let mut dc = 0;
    let mut traced = Vec::with_capacity(blocks);
    for block in 0..blocks {
        let is_restarted = block > 0 && block % interval == 0;
        if is_restarted {
            let number = (block / interval - 1) % 8;
            bits = NotingBits::new(stream, read_restart(&bits, number as u8)?);
            dc = 0;
        }
        let (start, before) = (bits.plain().offset(), dc);
        let stored = decode_block(&mut bits, &tables.dc, &tables.ac, &[1; 64], &mut dc)?;
        traced.push(BlockTrace {
            coefficients: ZIGZAG.map(|place| stored[usize::from(place)]),
            dc_difference: dc - before,
            codes: std::mem::take(&mut bits.codes),
            bytes: start..bits.bits.at,
            markers: block / interval,
            is_restarted,
        });
    }
    Ok((traced, tables.quantization))
}

/// The bits one by one, and the codes that they made.
struct NotingBits<'a> {
    bits: Bits<'a, 0>,
    codes: Vec<(u8, u32)>,
    /// How many bits were taken.
    taken: u32,
}

impl<'a> ReadBits<'a, 0> for NotingBits<'a> {
    fn new(stream: &'a [u8], at: usize) -> Self {
        NotingBits {
            bits: Bits::new(stream, at),
            codes: Vec::new(),
            taken: 0,
        }
    }

    fn receive(&mut self, count: u32) -> Result<u32> {
        self.taken += count;
        self.bits.receive(count)
    }

    fn plain(&self) -> Bits<'a, 0> {
        self.bits.plain()
    }
}

impl<'a> ReadSymbols<'a> for NotingBits<'a> {
    type Table = HuffmanTable;

    fn symbol(&mut self, table: &HuffmanTable) -> Result<u8> {
        let before = self.taken;
        let symbol = decode_symbol(self, table)?;
        self.codes.push((symbol, self.taken - before));
        Ok(symbol)
    }
}

#[cfg(test)]
mod tests {
    use super::super::encoder::{JpegOptions, encode};
    use super::trace;

    #[test]
    fn a_trace_has_the_codes_and_coefficients_of_each_block() {
        let mut samples = [128; 16 * 8];
        samples[0] = 255;
        let options = JpegOptions {
            restart_interval: 1,
            ..JpegOptions::new(100)
        };
        let stream = encode(&samples, 16, 8, &options).stream;
        let (blocks, steps) = trace(&stream, 16, 8).expect("our own stream");
        assert_eq!((blocks.len(), steps), (2, [1; 64]));
        assert_eq!(blocks[0].coefficients[..3], [16, 22, 22]);
        assert_eq!(blocks[0].codes[0], (5, 3), "five bits: 16");
        let gray = &blocks[1];
        assert_eq!((gray.dc_difference, gray.coefficients), (0, [0; 64]));
        assert_eq!(gray.codes, [(0, 2), (0, 4)]);
        assert_eq!((gray.markers, gray.is_restarted), (1, true));
    }
}
