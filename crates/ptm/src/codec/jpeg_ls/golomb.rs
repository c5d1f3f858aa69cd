//! T.87 A.5.3: decoding of limited-length Golomb codes
//!
//! A number is coded in two parts: number >> k in unary, as that many zeros and a one, then the low k bits. The codes of large
//! numbers are limited: LIMIT − qbpp − 1 zeros and a one are followed by number − 1 in qbpp bits.
//!
//! Worked example, with k = 2, LIMIT 32 and qbpp 8:
//!
//! ```text
//! 3     1 11                   no zeros, low bits 11
//! 13    0001 01                13 = 3 · 4 + 1
//! 200   (23 zeros) 1 11000111  200 >> 2 exceeds 22, so 199 in 8 bits
//! ```

use crate::codec::bits::{Bits, ReadBits};
use crate::codec::stream_error::{StreamResult, malformed};

/// Scan-decoding operations on an entropy-coded segment. [`Bits`] follows the standard bit by bit, and
/// [`BitBuffer`](crate::codec::bit_buffer::BitBuffer) is faster.
pub(super) trait ReadGolomb<'a>: ReadBits<'a, 7> {
    /// Reads the next Golomb code and returns the number that it represents.
    fn read_golomb(&mut self, k: u32, limit: u32, qbpp: u32) -> StreamResult<i32>;
}

impl<'a> ReadGolomb<'a> for Bits<'a, 7> {
    fn read_golomb(&mut self, k: u32, limit: u32, qbpp: u32) -> StreamResult<i32> {
        decode_golomb(self, k, limit, qbpp)
    }
}

/// Reads a Golomb code bit by bit (A.5.3).
pub(super) fn decode_golomb<'a>(
    bits: &mut impl ReadBits<'a, 7>,
    k: u32,
    limit: u32,
    qbpp: u32,
) -> StreamResult<i32> {
    let start = bits.plain_bits();
    let max_zeros = limit - qbpp - 1;
    let mut zeros = 0;
    while bits.receive(1)? == 0 {
        zeros += 1;
        if zeros > max_zeros {
            let what = format!("a code begins with more than {max_zeros} zeros");
            return Err(malformed(start.offset(), what));
        }
    }
    let number = if zeros < max_zeros {
        zeros << k | bits.receive(k)?
    } else {
        bits.receive(qbpp)? + 1
    };
    Ok(number as i32)
}

#[cfg(test)]
mod tests {
    use super::ReadGolomb;
    use crate::codec::bits::{Bits, ReadBits};

    /// Checks the worked example of this module.
    #[test]
    fn long_codes_are_limited() {
        let stream = [0, 0b1110_0010, 0b1000_0000, 0, 0, 0b1110_0011, 0b1000_0000];
        let mut bits = Bits::new(&stream, 1);
        let numbers = [(); 3].map(|()| bits.read_golomb(2, 32, 8));
        assert_eq!(numbers, [Ok(3), Ok(13), Ok(200)]);
    }
}
