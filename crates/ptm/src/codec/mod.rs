//! The two standards that PTM uses for its planes.
//!
//! A compressed PTM stores each plane as a complete stream of another standard: JPEG (ITU-T T.81) or JPEG-LS (ITU-T
//! T.87). This module implements decoders and encoders for planes, which have one component of 8 bits:
//!
//! ```text
//! &[u8] → markers and segments → parameters and tables → entropy-coded segment → samples
//!         markers                headers, jpeg, jpeg_ls   bits, jpeg, jpeg_ls
//! ```
//!
//! T.87 adopted the syntax of T.81: markers, the frame header, the scan header and, except for one number, the
//! stuffing of the entropy-coded bits. The modules in this folder serve both standards. `jpeg` and `jpeg_ls` implement
//! the difference: the coding of samples.
//!
//! # Plain and fast
//!
//! Every procedure is implemented as the standard describes it, bit by bit. Faster versions are in separate files: `bit_buffer`
//! for the bits, `jpeg::lookup` for the Huffman codes, `jpeg::narrow_dct` for the inverse DCT and `jpeg_ls::fast_golomb` for the
//! Golomb codes. Each is selected in one place, and a property test compares it with the plain version, including errors.

#![forbid(unsafe_code)]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    clippy::cast_lossless,
    reason = "both standards use small numbers, and every narrowing cast follows a range check"
)]

mod stream_error;

pub mod markers;

mod headers;

mod bits;

mod bit_buffer;

mod writer;

pub mod segments;

pub mod jpeg;

pub mod jpeg_ls;

pub use stream_error::{StreamError, StreamFault};

pub use writer::EncodedImage;

/// The compression standard of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Coding {
    /// JPEG (ITU-T T.81).
    Jpeg,
    /// JPEG-LS (ITU-T T.87).
    JpegLs,
}

impl Coding {
    /// Decodes a stream with one component of the given size.
    ///
    /// # Errors
    /// Returns the reason and the offset if the stream is malformed, unsupported or of a different size.
    pub fn decode(self, stream: &[u8], width: u32, height: u32) -> Result<Vec<u8>, StreamError> {
        match self {
            Coding::Jpeg => jpeg::decode(stream, width, height),
            Coding::JpegLs => jpeg_ls::decode(stream, width, height),
        }
    }

    /// Encodes samples with default options. `level` is the JPEG quality or the maximum error of JPEG-LS.
    #[must_use]
    pub fn encode(self, samples: &[u8], (width, height): (u32, u32), level: u8) -> Vec<u8> {
        let encoded = match self {
            Coding::Jpeg => {
                let options = jpeg::JpegOptions::new(level.clamp(1, 100));
                jpeg::encode(samples, width, height, &options)
            }
            Coding::JpegLs => {
                let options = jpeg_ls::JpegLsOptions {
                    near: level.min(127),
                    precision: 8,
                    presets: None,
                };
                jpeg_ls::encode(samples, width, height, &options)
            }
        };
        encoded.stream
    }
}
