//! JPEG: ITU-T T.81 | ISO/IEC 10918-1, the sequential Huffman processes, one component of 8 bits
//!
//! The image is divided into blocks of 8 × 8 samples, from left to right and from top to bottom. The discrete cosine
//! transform (DCT) converts each block to 64 coefficients. Each coefficient is divided by its quantization step and
//! rounded. The quotients are written in zigzag order with Huffman codes: the first (DC) as the difference from the
//! DC of the previous block, and the others (AC) as pairs of a run of zeros and a value.
//!
//! ```text
//! decode  scan → decode_block → (dequantization) → inverse_dct → samples
//! encode  samples → forward_dct → quantization → symbols → huffman_tables → bits
//! ```
//!
//! Worked example: the smallest block, uniform gray, consists of two codes. With the tables of Annex K, the DC
//! difference 0 is 00 and the end of the block is 1010. The six bits are padded with two ones:
//!
//! ```text
//! 00 1010 11 = 2B
//! ```
//!
//! Format notes
//! - Tables must precede the scan header that names them, but may follow the frame header.
//! - libjpeg writes 16-bit quantization tables under SOF1 if the quality is below 24. B.2.4.1 forbids them with
//!   8-bit samples. This decoder nevertheless accepts them, even under SOF0.
//! - Decoded samples are exact: see `inverse_dct`.

mod zigzag;

mod huffman_table;

mod dct;

// Decoder, in the order of a stream.

mod decoder;

mod processes;

mod tables;

mod scan;

mod decode_block;

mod huffman;

mod lookup;

mod inverse_dct;

mod narrow_dct;

// Encoder, in the order of processing.

mod encoder;

mod forward_dct;

mod quantization;

mod symbols;

mod huffman_tables;

pub use decoder::decode;

pub use encoder::{JpegOptions, encode};

pub use quantization::scaled_steps;
