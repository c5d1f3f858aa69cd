//! JPEG-LS: ITU-T T.87 | ISO/IEC 14495-1, lossless and near-lossless, one component of at most 8 bits
//!
//! Samples are coded one by one, from left to right and from top to bottom. Each sample is predicted from neighbors that are
//! already known, and the prediction error is written with a limited-length Golomb code. The gradients of the neighborhood select
//! one of 364 *contexts*, which adapt the correction of the prediction and the lengths of the codes to the errors so far. If the
//! neighborhood is flat, the coder counts equal samples instead (*run mode*).
//!
//! ```text
//! c b d     template → gradients ─┬→ prediction → contexts → golomb    regular mode (A.4 – A.6)
//! a x                             └→ run_mode                          run mode (A.7)
//! ```
//!
//! If NEAR is positive, each sample may be off by up to NEAR: the error is divided by 2·NEAR + 1 and rounded, and
//! both encoder and decoder continue with the decoded sample.
//!
//! Decoder and encoder adapt in the same way, so they share the contexts and all code that neither reads nor writes
//! bits. Annex F, the decoder, is the inverse of Annex A.
//!
//! Format notes
//! - A decoder must handle NEAR: the frame header is the same with and without loss.
//! - The standard does not specify the unit of a restart interval, and implementations differ. Streams with a restart
//!   interval are not supported.

mod parameters;

mod template;

mod gradients;

mod prediction;

mod contexts;

mod run_mode;

// Decoder.

mod decoder;

mod decode_scan;

mod golomb;

mod fast_golomb;

// Encoder.

mod encoder;

mod encode_scan;

pub use decoder::decode;

pub use encoder::{JpegLsOptions, encode};

pub use parameters::PresetParameters;
