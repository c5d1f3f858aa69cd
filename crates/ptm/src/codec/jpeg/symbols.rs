//! T.81 F.1.2: conversion of quantized blocks to symbols, and of symbols to bits
//!
//! This is the inverse of `decode_block` and `scan`, in two steps, because optimized Huffman tables depend on all symbols.
//!
//! Worked example: the block of `decode_block`: DC −3, then 0 0 5 and sixty zeros.
//!
//! ```text
//! DC  size 2, bits 00          −3 is the first two-bit number
//! AC  run 2, size 3, bits 101
//! AC  EOB
//! ```
//!
//! Format notes
//! - A restart marker ends its interval at a byte boundary. The next interval starts with the full DC coefficient
//!   instead of a difference.
//! - Zeros at the end of a block are never written as ZRL, because EOB covers them all.

use super::huffman_table::HuffmanTable;
use super::huffman_tables::{AC, DC, Symbol};
use crate::codec::markers::RST0;
use crate::codec::writer::{BitWriter, Writer};

/// Returns all symbols of the scan, in order.
///
/// `blocks` are in zigzag order. If `restart_interval` is not 0, a marker follows every `restart_interval` blocks.
pub(super) fn image_symbols(blocks: &[[i16; 64]], restart_interval: usize) -> Vec<Symbol> {
    let mut symbols = Vec::new();
    let mut previous_dc = 0;
    for (index, block) in blocks.iter().enumerate() {
        if restart_interval > 0 && index > 0 && index % restart_interval == 0 {
            let number = ((index / restart_interval - 1) % 8) as u8;
            symbols.push(Symbol::Restart(number));
            previous_dc = 0;
        }
        let dc = i32::from(block[0]);
        let (size, bits) = size_and_bits(dc - previous_dc);
        symbols.push(Symbol::Code(DC, size, bits));
        previous_dc = dc;
        push_ac(&mut symbols, &block[1..]);
    }
    symbols
}

/// Appends the AC symbols of a block: runs of zeros, each with the following coefficient (F.1.2.2).
fn push_ac(symbols: &mut Vec<Symbol>, coefficients: &[i16]) {
    let mut run = 0;
    for &coefficient in coefficients {
        if coefficient == 0 {
            run += 1;
            continue;
        }
        while run > 15 {
            symbols.push(Symbol::Code(AC, 0xF0, 0)); // ZRL
            run -= 16;
        }
        let (size, bits) = size_and_bits(i32::from(coefficient));
        symbols.push(Symbol::Code(AC, run << 4 | size, bits));
        run = 0;
    }
    if run > 0 {
        symbols.push(Symbol::Code(AC, 0x00, 0)); // EOB
    }
}

/// Returns the size and the additional bits of a number (F.1.2.1). The additional bits of a negative number are the low bits of
/// the number minus one, so that the first bit is zero.
fn size_and_bits(value: i32) -> (u8, u32) {
    let size = 32 - value.unsigned_abs().leading_zeros();
    let bits = if value < 0 { value - 1 } else { value };
    (size as u8, bits as u32 & ((1 << size) - 1))
}

/// Writes the entropy-coded data. Each interval is padded with ones (F.1.2.3).
pub(super) fn write_symbols(stream: &mut Writer, symbols: &[Symbol], tables: &[HuffmanTable; 2]) {
    let codes = [codes_by_symbol(&tables[DC]), codes_by_symbol(&tables[AC])];
    let mut out = BitWriter::<0>::new(stream);
    for symbol in symbols {
        match *symbol {
            Symbol::Code(class, symbol, bits) => {
                let (code, length) = codes[class][usize::from(symbol)];
                out.put_bits(code, length);
                out.put_bits(bits, u32::from(symbol & 15));
            }
            Symbol::Restart(number) => {
                out.finish(1);
                stream.write_marker(RST0 + number);
                out = BitWriter::new(stream);
            }
        }
    }
    out.finish(1);
}

/// Returns the code and its length for each symbol. Symbols without a code have length 0.
fn codes_by_symbol(table: &HuffmanTable) -> [(u32, u32); 256] {
    let mut codes = [(0, 0); 256];
    for code in table.codes() {
        codes[usize::from(code.symbol)] = (code.code, code.length);
    }
    codes
}

#[cfg(test)]
mod tests {
    use super::super::huffman_tables::typical_tables;
    use super::{image_symbols, write_symbols};
    use crate::codec::writer::Writer;

    /// Checks the worked example of `decode_block`.
    #[test]
    fn block_is_coded_as_symbols_and_extra_bits() {
        let mut block = [0; 64];
        (block[0], block[3]) = (-3, 5);
        let mut stream = Writer::new();
        let symbols = image_symbols(&[block], 0);
        write_symbols(&mut stream, &symbols, &typical_tables());
        assert_eq!(stream.finish()[2..], [0x67, 0xEF, 0x6B, 0xFF, 0xD9]);
    }
}
