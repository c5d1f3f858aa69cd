//! Buffered access to the bits of an entropy-coded segment.
//!
//! This is a faster version of [`Bits`]. A 64-bit window is filled with eight bytes at once if none of them is 0xFF.
//! Decoding a Huffman code then takes one table lookup, and counting leading zeros takes one instruction. Rare
//! operations (offsets, the end of the segment) are delegated to [`Bits`].
//!
//! ```text
//! stream   … A1 B2 | C3 D4 FF 00 E5 …     the next byte to load is C3
//! window   0001 1011 0010 0000 …          four bits of A1 were consumed: count = 12
//! ```

use super::bits::{Bits, ReadBits, data_bits, truncated_error};
use super::stream_error::StreamResult;

pub(super) struct BitBuffer<'a, const AFTER_FF: u32> {
    stream: &'a [u8],
    /// Offset of the first byte of the segment.
    start: usize,
    /// Offset of the next byte to load.
    at: usize,
    /// Unread bits, left-aligned and followed by zeros.
    window: u64,
    /// Number of bits in the window.
    count: u32,
}

impl<'a, const AFTER_FF: u32> ReadBits<'a, AFTER_FF> for BitBuffer<'a, AFTER_FF> {
    fn new(stream: &'a [u8], at: usize) -> Self {
        BitBuffer {
            stream,
            start: at,
            at,
            window: 0,
            count: 0,
        }
    }

    #[inline]
    fn receive(&mut self, count: u32) -> StreamResult<u32> {
        self.require(count);
        let number = leading_bits(self.window, count);
        self.skip(count)?;
        Ok(number)
    }

    /// Returns a [`Bits`] at the same position, found by moving back over the bytes in the window.
    #[cold]
    fn plain_bits(&self) -> Bits<'a, AFTER_FF> {
        let (mut at, mut unread) = (self.at, self.count);
        while at > self.start {
            let after_ff = at - 1 > self.start && self.stream[at - 2] == 0xFF;
            let bits = if after_ff { AFTER_FF } else { 8 };
            if bits > unread {
                break;
            }
            unread -= bits;
            at -= 1;
        }
        Bits {
            stream: self.stream,
            at,
            unread,
        }
    }
}

impl<const AFTER_FF: u32> BitBuffer<'_, AFTER_FF> {
    /// Ensures that the window contains at least `count` bits (at most 57), unless the segment ends first.
    #[inline]
    pub fn require(&mut self, count: u32) {
        if self.count < count {
            self.fill();
        }
    }

    /// Returns the next bits, left-aligned, with zeros after the end. Only the bits requested with `require` are guaranteed to be
    /// present.
    #[inline]
    pub fn peek_window(&self) -> u64 {
        self.window
    }

    /// Skips `bits` bits, which must have been requested with `require`. Returns an error if the segment ends earlier.
    #[inline]
    pub fn skip(&mut self, bits: u32) -> StreamResult<()> {
        if bits > self.count {
            return Err(truncated_error(self.at));
        }
        self.window <<= bits;
        self.count -= bits;
        Ok(())
    }

    /// Fills the window with at least 57 bits, unless the segment ends first.
    fn fill(&mut self) {
        // After a 0xFF byte, the first of the eight bytes would contain stuffing.
        if let Some(&[before, ref eight @ ..]) = self.stream[self.at - 1..].first_chunk::<9>()
            && before != 0xFF
            && !contains_ff(*eight)
        {
            let bytes = (64 - self.count) / 8;
            let loaded = u64::from_be_bytes(*eight) >> (64 - 8 * bytes);
            self.window |= loaded << (64 - self.count - 8 * bytes);
            self.count += 8 * bytes;
            self.at += bytes as usize;
            return;
        }
        while self.count <= 56
            && let Some(bits) = data_bits::<AFTER_FF>(self.stream, self.at)
        {
            // Shift in two steps, because a byte without data bits would require a shift by 64.
            let byte = u64::from(self.stream[self.at]) << 56 << (8 - bits);
            self.window |= byte >> self.count;
            self.count += bits;
            self.at += 1;
        }
    }
}

/// Returns the first `bits` bits of a window as a number.
#[inline]
pub(super) fn leading_bits(window: u64, bits: u32) -> u32 {
    // Shift in two steps, because zero bits would require a shift by 64.
    (window >> 1 >> (63 - bits)) as u32
}

/// Returns true if any byte is 0xFF, that is, if its complement is zero. Subtracting one from each byte of the complement borrows
/// into the high bit of every zero byte (and possibly of bytes above it).
#[inline]
fn contains_ff(eight: [u8; 8]) -> bool {
    let complement = !u64::from_be_bytes(eight);
    complement.wrapping_sub(0x0101_0101_0101_0101) & !complement & 0x8080_8080_8080_8080 != 0
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::bits::{Bits, ReadBits, transcript};
    use super::BitBuffer;

    /// Reads numbers with these `sizes`, in bits.
    fn read_numbers<'a, const AFTER_FF: u32, B: ReadBits<'a, AFTER_FF>>(
        stream: &'a [u8],
        sizes: &[u32],
    ) -> Vec<String> {
        let mut sizes = sizes.iter();
        transcript(stream, |bits: &mut B| {
            sizes.next().map(|&size| bits.receive(size))
        })
    }

    proptest! {
        #[test]
        fn bit_buffer_equals_plain_bits(
            data in prop::collection::vec(prop_oneof![Just(0xFF), Just(0), any::<u8>()], 0..60),
            sizes in prop::collection::vec(0_u32..=16, 0..60),
        ) {
            let stream = [vec![0], data].concat();
            prop_assert_eq!(
                read_numbers::<0, BitBuffer<0>>(&stream, &sizes),
                read_numbers::<0, Bits<0>>(&stream, &sizes)
            );
            prop_assert_eq!(
                read_numbers::<7, BitBuffer<7>>(&stream, &sizes),
                read_numbers::<7, Bits<7>>(&stream, &sizes)
            );
        }
    }
}
