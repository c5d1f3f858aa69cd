//! T.81 B.2.4.2, Annex C: Huffman tables
//!
//! A table contains only the number of codes of each length, 1 … 16 bits (BITS), and their symbols, shortest code
//! first (HUFFVAL). The codes follow from these numbers: the first code is all zeros, each following code is larger
//! by one, and a zero is appended whenever the length increases.
//!
//! Worked example: the segment of a table with four codes, and its codes.
//!
//! ```text
//! FF C4  00 17  00     00 03 01 00*13             05 07 06 08
//!        length class  3 codes of 2 bits, 1 of 3   symbols
//!
//! symbol  05  07  06  08
//! code    00  01  10  110
//! ```
//!
//! Format notes
//! - No code consists only of ones (Annex C). A table with two one-bit codes is therefore illegal.
//! - If a symbol occurs twice, both codes have the same meaning.

/// A Huffman table, as stored in a stream.
#[derive(Clone)]
pub(super) struct HuffmanTable {
    /// BITS: the number of codes of each length, 1 … 16 bits.
    pub counts: [u8; 16],
    /// HUFFVAL: the symbols, in the order of their codes.
    pub symbols: Vec<u8>,
}

/// A Huffman code and its symbol.
#[derive(Clone, Copy)]
pub(super) struct HuffmanCode {
    pub symbol: u8,
    /// The code, in the low `length` bits.
    pub code: u32,
    pub length: u32,
}

impl HuffmanTable {
    /// Returns all codes, shortest first (Annex C, Figures C.1 and C.2).
    pub fn codes(&self) -> Vec<HuffmanCode> {
        let mut codes = Vec::new();
        let mut symbols = self.symbols.iter();
        let mut code = 0;
        for (length, &count) in (1..).zip(&self.counts) {
            for &symbol in symbols.by_ref().take(usize::from(count)) {
                codes.push(HuffmanCode {
                    symbol,
                    code,
                    length,
                });
                code += 1;
            }
            code <<= 1;
        }
        codes
    }

    /// Returns the first length that has more codes than fit after the shorter codes. The code of all ones counts as taken.
    pub fn overfull_length(&self) -> Option<usize> {
        let mut next = 0_u32;
        (1..=16).find(|&length| {
            next = (next << 1) + u32::from(self.counts[length - 1]);
            next >= 1 << length
        })
    }
}

#[cfg(test)]
mod tests {
    use super::HuffmanTable;

    /// Checks the worked example of this module.
    #[test]
    fn codes_follow_from_their_lengths() {
        let mut counts = [0; 16];
        counts[1..3].copy_from_slice(&[3, 1]);
        let symbols = vec![5, 7, 6, 8];
        let codes = HuffmanTable { counts, symbols }.codes();
        let codes = codes
            .iter()
            .map(|code| (code.symbol, code.code, code.length));
        let expected = [(5, 0b00, 2), (7, 0b01, 2), (6, 0b10, 2), (8, 0b110, 3)];
        assert_eq!(codes.collect::<Vec<_>>(), expected);
    }
}
