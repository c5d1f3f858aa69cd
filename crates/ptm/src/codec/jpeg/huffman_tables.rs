//! T.81 K.2, K.3: the Huffman tables of an encoder
//!
//! An encoder uses either the typical tables of Annex K, which suit most images and occur in nearly all streams, or
//! the shortest codes for the symbols that occur.
//!
//! Worked example: four symbols that occur 5, 3, 1 and 1 times. A placeholder, which never occurs, gets the code of all ones. The
//! two lightest trees are merged until one is left, and each merge makes the codes in both trees one bit longer:
//!
//! ```text
//! merged                    lengths of A B C D, placeholder
//! (none) 1, D 1   → 2       0 0 0 1  1
//! C 1, (D) 2      → 3       0 0 1 2  2
//! (C D) 3, B 3    → 6       0 1 2 3  3
//! A 5, (B C D) 6  → 11      1 2 3 4  4      A 0, B 10, C 110, D 1110
//! ```
//!
//! Format notes
//! - If several symbols are equally rare, the standard chooses the one with the largest value. Other choices give
//!   tables of the same length with different bytes.
//! - No code may exceed 16 bits. Longer codes are shortened at the cost of shorter ones (Figure K.3). The result is
//!   no longer optimal, but every encoder does this.

use super::huffman_table::HuffmanTable;

/// Table classes (B.2.4.2). A symbol has the class of its table.
pub(super) const DC: usize = 0;
pub(super) const AC: usize = 1;

/// An element of the entropy-coded data: a code with additional bits, or a marker.
pub(super) enum Symbol {
    /// A class, a symbol of that class, and additional bits. The low four bits of the symbol are the number of additional bits.
    Code(usize, u8, u32),
    /// A restart marker with this number.
    Restart(u8),
}

/// Symbols of Table K.5, those with the shortest codes first.
#[rustfmt::skip]
const AC_SYMBOLS: [u8; 162] = [
    0x01, 0x02, 0x03, 0x00, 0x04, 0x11, 0x05, 0x12, 0x21, 0x31, 0x41, 0x06, 0x13, 0x51,
    0x61, 0x07, 0x22, 0x71, 0x14, 0x32, 0x81, 0x91, 0xA1, 0x08, 0x23, 0x42, 0xB1, 0xC1,
    0x15, 0x52, 0xD1, 0xF0, 0x24, 0x33, 0x62, 0x72, 0x82, 0x09, 0x0A, 0x16, 0x17, 0x18,
    0x19, 0x1A, 0x25, 0x26, 0x27, 0x28, 0x29, 0x2A, 0x34, 0x35, 0x36, 0x37, 0x38, 0x39,
    0x3A, 0x43, 0x44, 0x45, 0x46, 0x47, 0x48, 0x49, 0x4A, 0x53, 0x54, 0x55, 0x56, 0x57,
    0x58, 0x59, 0x5A, 0x63, 0x64, 0x65, 0x66, 0x67, 0x68, 0x69, 0x6A, 0x73, 0x74, 0x75,
    0x76, 0x77, 0x78, 0x79, 0x7A, 0x83, 0x84, 0x85, 0x86, 0x87, 0x88, 0x89, 0x8A, 0x92,
    0x93, 0x94, 0x95, 0x96, 0x97, 0x98, 0x99, 0x9A, 0xA2, 0xA3, 0xA4, 0xA5, 0xA6, 0xA7,
    0xA8, 0xA9, 0xAA, 0xB2, 0xB3, 0xB4, 0xB5, 0xB6, 0xB7, 0xB8, 0xB9, 0xBA, 0xC2, 0xC3,
    0xC4, 0xC5, 0xC6, 0xC7, 0xC8, 0xC9, 0xCA, 0xD2, 0xD3, 0xD4, 0xD5, 0xD6, 0xD7, 0xD8,
    0xD9, 0xDA, 0xE1, 0xE2, 0xE3, 0xE4, 0xE5, 0xE6, 0xE7, 0xE8, 0xE9, 0xEA, 0xF1, 0xF2,
    0xF3, 0xF4, 0xF5, 0xF6, 0xF7, 0xF8, 0xF9, 0xFA,
];

/// Returns the typical tables for luminance, indexed by class: Tables K.3 and K.5.
pub(super) fn typical_tables() -> [HuffmanTable; 2] {
    let dc = HuffmanTable {
        counts: [0, 1, 5, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0],
        symbols: (0..=11).collect(),
    };
    let ac = HuffmanTable {
        counts: [0, 2, 1, 3, 3, 2, 4, 3, 5, 5, 4, 4, 0, 0, 1, 125],
        symbols: AC_SYMBOLS.to_vec(),
    };
    [dc, ac]
}

/// Returns optimal tables for these symbols, indexed by class (K.2).
pub(super) fn optimal_tables(symbols: &[Symbol]) -> [HuffmanTable; 2] {
    let mut occurrences = [[0; 256]; 2];
    for symbol in symbols {
        if let Symbol::Code(class, symbol, _) = *symbol {
            occurrences[class][usize::from(symbol)] += 1;
        }
    }
    occurrences.map(|occurrences| optimal_table(&occurrences))
}

/// Placeholder symbol for the code of all ones, which Annex C assigns to no symbol.
const PLACEHOLDER: usize = 256;

/// Returns the optimal table for symbols with these frequencies (K.2).
fn optimal_table(occurrences: &[u32; 256]) -> HuffmanTable {
    let lengths = code_lengths(occurrences);
    let mut counts = [0; PLACEHOLDER + 1];
    for &length in &lengths {
        counts[length] += 1;
    }
    limit_to_16_bits(&mut counts);
    // The placeholder has the longest code of all.
    let longest = (1..=16).rev().find(|&length| counts[length] > 0);
    counts[longest.unwrap_or_else(|| unreachable!("an image has symbols"))] -= 1;

    // Figure K.4: the symbols, sorted by their lengths before shortening, then by value.
    let mut symbols: Vec<u8> = (0..=255)
        .filter(|&symbol| occurrences[usize::from(symbol)] > 0)
        .collect();
    symbols.sort_by_key(|&symbol| lengths[usize::from(symbol)]);
    HuffmanTable {
        counts: std::array::from_fn(|i| counts[i + 1] as u8),
        symbols,
    }
}

/// Returns the code length of each symbol. Merges the two lightest trees until one is left (Figure K.1); each merge makes all
/// codes in both trees one bit longer. On ties, the tree with the larger first symbol counts as lighter.
fn code_lengths(occurrences: &[u32; 256]) -> [usize; PLACEHOLDER + 1] {
    let mut weights: Vec<u32> = occurrences.iter().copied().chain([1]).collect();
    let mut trees: Vec<Vec<usize>> = (0..=PLACEHOLDER).map(|symbol| vec![symbol]).collect();
    let mut lengths = [0; PLACEHOLDER + 1];
    loop {
        let lightest = |weights: &[u32], except: Option<usize>| {
            (0..=PLACEHOLDER)
                .rev()
                .filter(|&tree| weights[tree] > 0 && Some(tree) != except)
                .min_by_key(|&tree| weights[tree])
        };
        let first = lightest(&weights, None);
        let (Some(first), Some(second)) = (first, lightest(&weights, first)) else {
            return lengths;
        };
        let merged = std::mem::take(&mut trees[second]);
        trees[first].extend(merged);
        weights[first] += std::mem::take(&mut weights[second]);
        for &symbol in &trees[first] {
            lengths[symbol] += 1;
        }
    }
}

/// Shortens codes of more than 16 bits (Figure K.3). Of two sibling codes that are too long, one replaces their parent. The other
/// becomes the sibling of a shorter code, which grows by one bit.
fn limit_to_16_bits(counts: &mut [usize; PLACEHOLDER + 1]) {
    for length in (17..=PLACEHOLDER).rev() {
        while counts[length] > 0 {
            let shorter = (1..length - 1).rev().find(|&shorter| counts[shorter] > 0);
            let shorter = shorter.unwrap_or_else(|| {
                unreachable!("257 symbols never need codes longer than 16 bits")
            });
            counts[length] -= 2;
            counts[length - 1] += 1;
            counts[shorter + 1] += 2;
            counts[shorter] -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::optimal_table;

    /// Checks the worked example of this module.
    #[test]
    fn frequent_symbols_have_short_codes() {
        let mut occurrences = [0; 256];
        occurrences[..4].copy_from_slice(&[5, 3, 1, 1]);
        let table = optimal_table(&occurrences);
        assert_eq!(table.symbols, [0, 1, 2, 3]);
        assert_eq!(table.counts[..5], [1, 1, 1, 1, 0]);
    }
}
