//! T.81 B.1.1 (T.87 C.1): writing markers, marker segments and entropy-coded bits
//!
//! This is the mirror image of `markers`, `headers` and `bits`, for both encoders. If the standards allow several
//! representations, this module always uses the same one: no fill bytes, component id 1, and the table indices of the encoder.
//!
//! Worked example: eight ones and 1010 0001, then the end, in both standards.
//!
//! ```text
//! T.81   FF     the next byte contains no data: 00
//!        A1     complete
//! T.87   FF     the next byte contains seven bits: 0 and 101 0000
//!        50 80  the last bit, padded with zeros
//! ```

use super::markers::{EOI, SOI, SOS};

/// The output of an encoder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EncodedImage {
    /// The complete stream, from SOI to EOI.
    pub stream: Vec<u8>,
    /// Samples that an exact decoder returns for the stream, in row order.
    ///
    /// The encoder computes them without decoding the stream.
    pub samples: Vec<u8>,
}

/// A stream under construction.
pub(super) struct Writer {
    stream: Vec<u8>,
}

impl Writer {
    /// Creates a stream that starts with SOI (B.2.1).
    pub fn new() -> Writer {
        let stream = vec![0xFF, SOI];
        Writer { stream }
    }

    /// Writes a marker segment. The length includes its own two bytes (B.1.1.4).
    pub fn write_segment(&mut self, code: u8, content: &[u8]) {
        self.write_marker(code);
        self.stream.extend((content.len() as u16 + 2).to_be_bytes());
        self.stream.extend(content);
    }

    pub fn write_marker(&mut self, code: u8) {
        self.stream.extend([0xFF, code]);
    }

    /// Writes a frame header (B.2.2): precision, height before width, and one component with id 1. `component` contains
    /// its sampling factors and the index of its quantization table.
    pub fn write_frame_header(
        &mut self,
        code: u8,
        precision: u8,
        width: u32,
        height: u32,
        component: [u8; 2],
    ) {
        let mut content = vec![precision];
        content.extend((height as u16).to_be_bytes());
        content.extend((width as u16).to_be_bytes());
        content.extend([1, 1]);
        content.extend(component);
        self.write_segment(code, &content);
    }

    /// Writes a scan header (B.2.3): the single component, its tables, and the parameters of the scan.
    pub fn write_scan_header(&mut self, tables: u8, [first, second, third]: [u8; 3]) {
        self.write_segment(SOS, &[1, 1, tables, first, second, third]);
    }

    /// Appends `data`, which is already encoded and ends with EOI, and returns the stream.
    pub fn finish_with(mut self, data: &[u8]) -> Vec<u8> {
        self.stream.extend(data);
        self.stream
    }

    /// Finishes the stream with EOI.
    pub fn finish(mut self) -> Vec<u8> {
        self.write_marker(EOI);
        self.stream
    }
}

/// Writer for the bits of an entropy-coded segment. For `AFTER_FF`, see `bits`.
pub(super) struct BitWriter<'a, const AFTER_FF: u32> {
    stream: &'a mut Vec<u8>,
    /// Bits that do not yet fill a byte, right-aligned.
    window: u64,
    count: u32,
    /// Number of data bits that fit in the next byte.
    byte_bits: u32,
}

impl<'a, const AFTER_FF: u32> BitWriter<'a, AFTER_FF> {
    pub fn new(writer: &'a mut Writer) -> Self {
        BitWriter {
            stream: &mut writer.stream,
            window: 0,
            count: 0,
            byte_bits: 8,
        }
    }

    /// Appends the low `count` bits of `bits`. `count` is at most 32, and all higher bits must be zero.
    pub fn put_bits(&mut self, bits: u32, count: u32) {
        self.window = self.window << count | u64::from(bits);
        self.count += count;
        while self.count >= self.byte_bits {
            self.count -= self.byte_bits;
            let byte = (self.window >> self.count) as u8 & ((1_u32 << self.byte_bits) - 1) as u8;
            self.stream.push(byte);
            self.byte_bits = if byte == 0xFF { AFTER_FF } else { 8 };
        }
    }

    /// Pads the last byte with copies of `padding`, 0 or 1. A final 0xFF is followed by stuffing as well; otherwise, a decoder
    /// would mistake it for the start of a marker.
    pub fn finish(mut self, padding: u32) {
        while self.count > 0 || self.byte_bits < 8 {
            self.put_bits(padding, 1);
        }
    }
}

/// Checks the size of the image passed to an encoder.
///
/// # Panics
/// Panics if the number of samples is not `width` × `height`, or if `width` or `height` is not between 1 and 65,535.
pub(super) fn check_size(samples: &[u8], width: u32, height: u32) {
    assert!(
        (1..=0xFFFF).contains(&width) && (1..=0xFFFF).contains(&height),
        "a stream cannot have {width} x {height} samples"
    );
    assert_eq!(
        samples.len(),
        width as usize * height as usize,
        "expected {width} x {height} samples"
    );
}
