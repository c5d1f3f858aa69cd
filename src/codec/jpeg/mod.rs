//! JPEG: ITU-T T.81 | ISO/IEC 10918-1, the sequential Huffman processes, one component of 8 bits
//!
//! The image is divided into blocks of 8 × 8 samples, left to right and top to bottom. The discrete cosine transform (DCT)
//! turns each block into 64 coefficients; each coefficient is divided by its quantization step and rounded. The quotients are
//! written in zigzag order with Huffman codes: the first (DC) as the difference from that of the previous block, the others
//! (AC) as pairs of a run of zeros and a value.
//!
//! ```text
//! decode  scan → decode_block → (dequantized on the way) → inverse_dct → samples
//! encode  samples → forward_dct → quantization → symbols → huffman_tables → bits
//! ```
//!
//! Worked example: the smallest block, uniform gray, is two codes. With the tables of Annex K the DC difference 0 is 00 and the
//! end of the block 1010, six bits in all, which two ones pad:
//!
//! ```text
//! 00 1010 11 = 2B
//! ```
//!
//! Format notes
//! - Tables must precede the scan header that names them, but not the frame header.
//! - libjpeg writes quantization tables of 16 bits, under SOF1, if the quality is below 24.
//!   B.2.4.1 forbids them with samples of 8 bits in one sentence; they are read nevertheless, under
//!   SOF0 as well.
//! - Decoded samples are exact: see `inverse_dct`.

mod zigzag;

mod huffman_table;

mod dct;

// Reading, in the order of a stream.

mod decoder;

mod processes;

mod tables;

mod scan;

mod decode_block;

mod huffman;

mod lookup;

mod inverse_dct;

mod narrow_dct;

// Writing, in the order of processing.

#[cfg(feature = "generate")]
mod encoder;

#[cfg(feature = "generate")]
mod forward_dct;

#[cfg(feature = "generate")]
mod quantization;

#[cfg(feature = "generate")]
mod symbols;

#[cfg(feature = "generate")]
mod huffman_tables;

pub use decoder::decode;

#[cfg(feature = "generate")]
pub use encoder::{JpegOptions, encode};

#[cfg(feature = "cli")]
pub(crate) use quantization::scaled_steps;
