//! Fast decoding of Huffman codes by table lookup
//!
//! Nearly all codes in a stream are short. The next `SHORT_BITS` bits of the segment are the index of an entry, which
//! contains the symbol and the length of the code at the start of these bits. Longer codes are delegated to the plain
//! version, where decoding one bit costs as much as a lookup here.
//!
//! Worked example: the 1,024 entries for the table of `huffman_table`.
//!
//! ```text
//! bits 00 0000 0000 … 00 1111 1111   256 entries   2 bits, symbol 05
//! bits 01…                           256 entries   2 bits, symbol 07
//! bits 10…                           256 entries   2 bits, symbol 06
//! bits 110…                          128 entries   3 bits, symbol 08
//! bits 111…                          128 entries   0: no code of at most ten bits
//! ```

use super::huffman::{ReadSymbols, decode_symbol};
use super::huffman_table::HuffmanTable;
use crate::codec::bit_buffer::{BitBuffer, leading_bits};
use crate::codec::stream_error::StreamResult;

/// Number of bits in an index. Longer codes are rare, and two tables with ten-bit indices still fit in the L1 cache.
const SHORT_BITS: u32 = 10;

/// A Huffman table, with a lookup table that maps the next bits of a segment to the short codes.
pub(super) struct CodeTable {
    table: HuffmanTable,
    /// Length (high byte) and symbol (low byte) of the code at the start of the index, or 0 if the code is longer than the index
    /// or invalid.
    short_codes: [u16; 1 << SHORT_BITS],
}

impl From<&HuffmanTable> for CodeTable {
    fn from(table: &HuffmanTable) -> CodeTable {
        let mut short_codes = [0; 1 << SHORT_BITS];
        for code in table.codes() {
            if code.length <= SHORT_BITS {
                // All continuations of the code map to this entry.
                let free = SHORT_BITS - code.length;
                let first = (code.code << free) as usize;
                let entry = (code.length as u16) << 8 | u16::from(code.symbol);
                short_codes[first..first + (1 << free)].fill(entry);
            }
        }
        let table = table.clone();
        CodeTable { table, short_codes }
    }
}

impl<'a> ReadSymbols<'a> for BitBuffer<'a, 0> {
    type Table = CodeTable;

    #[inline]
    fn read_symbol(&mut self, table: &CodeTable) -> StreamResult<u8> {
        // This suffices for the longest code and for the number after it.
        self.require(16 + 16);
        let entry = table.short_codes[leading_bits(self.peek_window(), SHORT_BITS) as usize];
        if entry == 0 {
            return long_symbol(self, &table.table);
        }
        self.skip(u32::from(entry >> 8))?;
        Ok(entry as u8)
    }
}

#[cold]
fn long_symbol(bits: &mut BitBuffer<0>, table: &HuffmanTable) -> StreamResult<u8> {
    decode_symbol(bits, table)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::huffman::ReadSymbols;
    use super::super::huffman_table::HuffmanTable;
    use crate::codec::bit_buffer::BitBuffer;
    use crate::codec::bits::{Bits, transcript};

    /// Reads symbols until an error occurs. The low four bits of a symbol are the number of additional bits that follow it.
    fn symbols<'a, B: ReadSymbols<'a>>(stream: &'a [u8], table: &HuffmanTable) -> Vec<String> {
        let table = B::Table::from(table);
        transcript(stream, |bits: &mut B| {
            let symbol = bits.read_symbol(&table);
            Some(symbol.and_then(|symbol| Ok((symbol, bits.receive(u32::from(symbol & 15))?))))
        })
    }

    /// Creates a legal table. Limits the `wanted` counts so that the code of all ones stays unassigned.
    fn table(wanted: &[u8], symbols: Vec<u8>) -> HuffmanTable {
        let mut counts = [0; 16];
        let (mut free, mut left) = (1_usize, symbols.len());
        for (count, &wanted) in counts.iter_mut().zip(wanted) {
            free *= 2;
            *count = usize::from(wanted).min(free - 1).min(left) as u8;
            free -= usize::from(*count);
            left -= usize::from(*count);
        }
        HuffmanTable { counts, symbols }
    }

    proptest! {
        #[test]
        fn lookup_table_equals_plain_decoding(
            wanted in prop::collection::vec(0_u8..6, 16),
            symbol_list in prop::collection::vec(any::<u8>(), 1..60),
            data in prop::collection::vec(prop_oneof![Just(0xFF), Just(0), any::<u8>()], 0..40),
        ) {
            let (stream, table) = ([vec![0], data].concat(), table(&wanted, symbol_list));
            prop_assert_eq!(
                symbols::<BitBuffer<0>>(&stream, &table),
                symbols::<Bits<0>>(&stream, &table)
            );
        }
    }
}
