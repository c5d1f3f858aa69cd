//! T.81 B.1.1.5, F.1.2.3 and T.87 A.1, C.1.1: the bits of an entropy-coded segment
//!
//! Codes are packed into bytes without gaps, most significant bit first. So that markers can be found without decoding, a 0xFF
//! byte in the data is followed by *stuffing*: a 0x00 byte in T.81, a single zero bit in T.87. In general, the byte after 0xFF
//! contains only `AFTER_FF` bits of data (0 in T.81 and 7 in T.87), and the upper bits are zeros. If the upper bits are not zero,
//! 0xFF is the first byte of a marker, which ends the segment.
//!
//! Worked example, sixteen bits of data in each standard:
//!
//! ```text
//! data     1111 1111 1010 0001
//! T.81     FF 00 A1        1111 1111 (0000 0000) 1010 0001
//! T.87     FF 50 80        1111 1111 (0)101 0000 1xxx xxxx
//! ```
//!
//! Format notes
//! - The last byte is padded. T.81 requires ones (F.1.2.3), but T.87 does not specify the padding. Decoders, including this one,
//!   do not check it.
//! - Less than one byte should be left after the last sample. If more is left, the decoder lost synchronization, or the encoder
//!   wrote too many samples.

use super::stream_error::{StreamError, StreamResult, malformed};

/// Operations on an entropy-coded segment. [`Bits`] follows the standards bit by bit, and
/// [`BitBuffer`](super::bit_buffer::BitBuffer) is faster.
pub(super) trait ReadBits<'a, const AFTER_FF: u32>: Sized {
    /// Creates a reader for the segment at byte `at`, which follows a marker or marker segment. The previous byte must not be
    /// 0xFF.
    fn new(stream: &'a [u8], at: usize) -> Self;

    /// RECEIVE (T.81 F.2.2.4): reads the next `count` bits (at most 16) as a number.
    fn receive(&mut self, count: u32) -> StreamResult<u32>;

    /// Returns a [`Bits`] at the same position, for rare operations: offsets of errors and the end of the segment.
    fn plain_bits(&self) -> Bits<'a, AFTER_FF>;
}

/// Reads bit by bit, as the standards describe.
#[derive(Clone)]
pub(super) struct Bits<'a, const AFTER_FF: u32> {
    pub stream: &'a [u8],
    /// Offset of the next byte to load.
    pub at: usize,
    /// Number of unread bits in the previous byte.
    pub unread: u32,
}

impl<'a, const AFTER_FF: u32> ReadBits<'a, AFTER_FF> for Bits<'a, AFTER_FF> {
    fn new(stream: &'a [u8], at: usize) -> Self {
        let unread = 0;
        Bits { stream, at, unread }
    }

    fn receive(&mut self, count: u32) -> StreamResult<u32> {
        let mut number = 0;
        for _ in 0..count {
            number = number << 1 | self.read_bit()?;
        }
        Ok(number)
    }

    fn plain_bits(&self) -> Bits<'a, AFTER_FF> {
        self.clone()
    }
}

impl<const AFTER_FF: u32> Bits<'_, AFTER_FF> {
    /// NEXTBIT (T.81 F.2.2.5): reads one bit.
    pub fn read_bit(&mut self) -> StreamResult<u32> {
        // This is a loop because the stuffed byte of T.81 has no data bits.
        while self.unread == 0 {
            self.unread = data_bits::<AFTER_FF>(self.stream, self.at)
                .ok_or_else(|| truncated_error(self.at))?;
            self.at += 1;
        }
        self.unread -= 1;
        Ok(u32::from(self.stream[self.at - 1] >> self.unread & 1))
    }

    /// Returns the offset of the byte that contains the next bit.
    pub fn offset(&self) -> usize {
        self.at - usize::from(self.unread > 0)
    }

    /// Skips the padding of the last byte. Returns the offset of the marker that ends the segment.
    pub fn finish(self) -> StreamResult<usize> {
        let (mut at, mut padding) = (self.at, self.unread);
        while let Some(bits) = data_bits::<AFTER_FF>(self.stream, at) {
            padding += bits;
            if padding >= 8 {
                let what = "the entropy-coded segment continues after the last sample";
                return Err(malformed(self.at, what));
            }
            at += 1;
        }
        Ok(at)
    }
}

/// Returns the number of data bits in the byte at `at`. Returns `None` if the segment ends there: at a marker, at the end of the
/// stream, or at a 0xFF that is the last byte of the stream.
#[inline]
pub(super) fn data_bits<const AFTER_FF: u32>(stream: &[u8], at: usize) -> Option<u32> {
    let starts_marker = |next: Option<&u8>| next.is_none_or(|&next| next >> AFTER_FF != 0);
    match stream.get(at)? {
        0xFF if starts_marker(stream.get(at + 1)) => None,
        _ if stream[at - 1] == 0xFF => Some(AFTER_FF),
        _ => Some(8),
    }
}

/// Returns the error for a segment that ends too early.
pub(super) fn truncated_error(at: usize) -> StreamError {
    malformed(at, "the entropy-coded segment ends too early")
}

#[cfg(test)]
pub(super) use tests::transcript;

#[cfg(test)]
mod tests {
    use super::{Bits, ReadBits, StreamResult};

    /// Reads until an error occurs or `read` returns `None`. After `None`, finishes the segment. Returns all results, which must
    /// be the same for every implementation of [`ReadBits`].
    pub fn transcript<'a, const AFTER_FF: u32, B: ReadBits<'a, AFTER_FF>, T: std::fmt::Debug>(
        stream: &'a [u8],
        mut read: impl FnMut(&mut B) -> Option<StreamResult<T>>,
    ) -> Vec<String> {
        let mut bits = B::new(stream, 1);
        let mut results = Vec::new();
        while let Some(result) = read(&mut bits) {
            results.push(format!("{result:?}"));
            if result.is_err() {
                return results;
            }
            results.push(format!("byte {}", bits.plain_bits().offset()));
        }
        results.push(format!("{:?}", bits.plain_bits().finish()));
        results
    }

    /// Checks the worked example of this module.
    #[test]
    fn jpeg_stuffs_a_byte_and_jpeg_ls_a_bit_after_ff() {
        let t_81 = [0, 0xFF, 0x00, 0xA1, 0xFF, 0xD9];
        let mut bits = Bits::<0>::new(&t_81, 1);
        assert_eq!(bits.receive(16), Ok(0xFFA1));
        assert_eq!(bits.finish(), Ok(4));

        let t_87 = [0, 0xFF, 0x50, 0x80, 0xFF, 0xD9];
        let mut bits = Bits::<7>::new(&t_87, 1);
        assert_eq!(bits.receive(16), Ok(0xFFA1));
        assert_eq!(bits.finish(), Ok(4));
    }
}
