//! T.81 F.2.2.3: decoding a Huffman code
//!
//! Codes of equal length are consecutive numbers, so a decoder needs only three numbers for each length: the first code, the
//! number of codes, and the index of the first symbol. It reads bits until they form one of the codes.
//!
//! Worked example, with the table of `huffman_table` (00 = 05, 01 = 07, 10 = 06, 110 = 08):
//!
//! ```text
//! bits 110…   length  first  count   code
//!             1       0      0       1      no code of this length
//!             2       0      3       11     0 + 3 = 11: past the last code
//!             3       110    1       110    the first code: symbol 08
//! ```

use super::huffman_table::HuffmanTable;
use crate::codec::bits::{Bits, ReadBits};
use crate::codec::stream_error::{StreamResult, malformed};

/// Block-decoding operations on an entropy-coded segment. [`Bits`] follows the standard bit by bit, and
/// [`BitBuffer`](crate::codec::bit_buffer::BitBuffer) is faster.
pub(super) trait ReadSymbols<'a>: ReadBits<'a, 0> {
    /// Representation of a Huffman table for this reader.
    type Table: for<'t> From<&'t HuffmanTable>;

    /// DECODE (F.2.2.3): reads the next code in the table and returns its symbol.
    fn read_symbol(&mut self, table: &Self::Table) -> StreamResult<u8>;
}

impl<'a> ReadSymbols<'a> for Bits<'a, 0> {
    type Table = HuffmanTable;

    fn read_symbol(&mut self, table: &HuffmanTable) -> StreamResult<u8> {
        decode_symbol(self, table)
    }
}

impl From<&HuffmanTable> for HuffmanTable {
    fn from(table: &HuffmanTable) -> HuffmanTable {
        table.clone()
    }
}

/// DECODE: reads bits until they form a code in the table.
pub(super) fn decode_symbol<'a>(
    bits: &mut impl ReadBits<'a, 0>,
    table: &HuffmanTable,
) -> StreamResult<u8> {
    let start = bits.plain_bits();
    let mut code = 0;
    let mut first = 0; // MINCODE: the first code of this length
    let mut index = 0; // VALPTR: the index of its symbol
    for &count in &table.counts {
        let count = usize::from(count);
        code = code << 1 | bits.receive(1)? as usize;
        if code < first + count {
            return Ok(table.symbols[index + code - first]);
        }
        index += count;
        first = (first + count) << 1;
    }
    let what = "the next bits match no code in the Huffman table";
    Err(malformed(start.offset(), what))
}
