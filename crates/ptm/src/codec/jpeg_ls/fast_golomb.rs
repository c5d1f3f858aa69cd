//! Fast decoding of Golomb codes by counting zeros
//!
//! The leading zeros of a code are counted with one instruction, and the whole code is skipped at once. Limited codes are rare
//! and are delegated to the plain version.
//!
//! ```text
//! window   0001 0111 …     k = 2: three zeros, then 01: 3 · 4 + 1 = 13, six bits
//! ```

use super::golomb::{ReadGolomb, decode_golomb};
use crate::codec::bit_buffer::{BitBuffer, leading_bits};
use crate::codec::stream_error::StreamResult;

impl<'a> ReadGolomb<'a> for BitBuffer<'a, 7> {
    #[inline]
    fn read_golomb(&mut self, k: u32, limit: u32, qbpp: u32) -> StreamResult<i32> {
        // An unlimited code (its zeros, a one and k bits) is never longer than this.
        self.require(48);
        let zeros = self.peek_window().leading_zeros();
        if zeros >= limit - qbpp - 1 {
            return limited_golomb(self, k, limit, qbpp);
        }
        let low = leading_bits(self.peek_window() << (zeros + 1), k);
        self.skip(zeros + 1 + k)?;
        Ok((zeros << k | low) as i32)
    }
}

#[cold]
fn limited_golomb(bits: &mut BitBuffer<7>, k: u32, limit: u32, qbpp: u32) -> StreamResult<i32> {
    decode_golomb(bits, k, limit, qbpp)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::golomb::ReadGolomb;
    use crate::codec::bit_buffer::BitBuffer;
    use crate::codec::bits::{Bits, transcript};

    fn numbers<'a, B: ReadGolomb<'a>>(stream: &'a [u8], codes: &[(u32, u32, u32)]) -> Vec<String> {
        let mut codes = codes.iter();
        transcript(stream, |bits: &mut B| {
            let &(k, limit, qbpp) = codes.next()?;
            Some(bits.read_golomb(k, limit, qbpp))
        })
    }

    proptest! {
        #[test]
        fn fast_golomb_equals_plain_golomb(
            data in prop::collection::vec(prop_oneof![Just(0xFF), Just(0), any::<u8>()], 0..40),
            codes in prop::collection::vec((0_u32..=9, 16_u32..=32, 1_u32..=8), 0..40),
        ) {
            let stream = [vec![0], data].concat();
            prop_assert_eq!(
                numbers::<BitBuffer<7>>(&stream, &codes),
                numbers::<Bits<7>>(&stream, &codes)
            );
        }
    }
}
