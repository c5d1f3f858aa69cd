//! Streams of JPEG and JPEG-LS that a decoder reads wrong: in which step of T.81 or T.87.

pub(super) mod cache;
pub(super) mod evidence;
pub(super) mod file_streams;
pub(super) mod fits;
mod inverse_dcts;
mod jpeg_blocks;
mod jpeg_ls_samples;
mod jpeg_ls_slips;
mod jpeg_slips;
mod segments;
mod separate;
mod slips;
pub(super) mod stream_slips;
pub(super) mod streams;
