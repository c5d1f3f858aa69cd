//! T.81 F.2.2: decoding a block of coefficients
//!
//! A coefficient is coded in two parts: a Huffman code for its *size* (the number of bits of its magnitude), and *size*
//! additional bits, which select one of the numbers of this size. The code of an AC coefficient also contains the preceding run
//! of zeros: RUN in the high four bits of the symbol, SIZE in the low four.
//!
//! ```text
//! size 1:  −1              |  1             bits 0 | 1
//! size 2:  −3 −2           |  2 3           bits 00 01 | 10 11
//! size 3:  −7 −6 −5 −4     |  4 5 6 7       bits 000 001 010 011 | 100 101 110 111
//! ```
//!
//! Worked example, with the tables of Annex K: DC difference −3, then 5 at k = 3, then zeros.
//!
//! ```text
//! 011 00           size 2, bits 00              −3
//! 1111110111 101   run 2, size 3, bits 101      5 after two zeros
//! 1010             EOB                          zeros to the end of the block
//! 11               padding                      all bytes: 67 EF 6B
//! ```
//!
//! Format notes
//! - A run has at most fifteen zeros. ZRL (RUN 15, SIZE 0) represents sixteen zeros. A run that extends past the end of the block
//!   is malformed, even if it consists only of ZRL.
//! - A block whose last coefficient is nonzero has no EOB.
//! - For 8-bit samples, differences have at most 11 bits (Table F.1), and AC coefficients have at most 10 (Table F.2).

use super::{huffman::ReadSymbols, zigzag::ZIGZAG};
use crate::codec::stream_error::{StreamResult, malformed};

/// Decodes and dequantizes a block (A.3.4). Returns its DCT coefficients in row order.
///
/// `steps` are in zigzag order. `previous_dc`, the quantized DC coefficient of the previous block, is set to that of this block.
#[inline]
pub(super) fn decode_block<'a, B: ReadSymbols<'a>>(
    bits: &mut B,
    dc: &B::Table,
    ac: &B::Table,
    steps: &[u16; 64],
    previous_dc: &mut i32,
) -> StreamResult<[i32; 64]> {
    let mut block = [0; 64];
    // F.2.2.1: the size of the difference, then the difference itself.
    let size = bits.read_symbol(dc)?;
    if size > 11 {
        let what = format!("no DC difference has {size} bits");
        return Err(malformed(bits.plain_bits().offset(), what));
    }
    *previous_dc += extend(bits.receive(u32::from(size))?, size);
    // The sum of 64 samples of magnitude at most 128, divided by 8, needs eleven bits. Quantization only makes it smaller.
    if !(-2048..2048).contains(previous_dc) {
        let what = format!("the DC coefficient {previous_dc} is out of range");
        return Err(malformed(bits.plain_bits().offset(), what));
    }
    block[0] = *previous_dc * i32::from(steps[0]);

    // F.2.2.2, Figure F.13.
    let mut k = 1;
    while k < 64 {
        let symbol = bits.read_symbol(ac)?;
        let (run, size) = (usize::from(symbol >> 4), symbol & 15);
        match (run, size) {
            (0, 0) => break,                   // EOB
            (15, 0) | (_, 1..=10) => k += run, // ZRL is fifteen zeros followed by a zero
            _ => {
                let what = format!("no AC code has run {run} and size {size}");
                return Err(malformed(bits.plain_bits().offset(), what));
            }
        }
        if k > 63 || (k == 63 && size == 0) {
            let what = "a run of zeros extends past the end of the block";
            return Err(malformed(bits.plain_bits().offset(), what));
        }
        let value = extend(bits.receive(u32::from(size))?, size);
        block[usize::from(ZIGZAG[k])] = value * i32::from(steps[k]);
        k += 1;
    }
    Ok(block)
}

/// EXTEND (F.2.2.1, Figure F.12): converts `size` bits to a number, which is negative if the first bit is 0.
#[inline]
fn extend(bits: u32, size: u8) -> i32 {
    let negative = size > 0 && bits >> (size - 1) == 0;
    bits as i32 - if negative { (1 << size) - 1 } else { 0 }
}
