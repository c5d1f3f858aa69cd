//! The parts of a file: arguments and results of the functions of [`crate::reading::Reading`], section by section.
//!
//! The types of decoded maps, mainly [`crate::types::Planes`], are in [`crate::types`].

use std::ops::Range;

use crate::types::{Coding, Size};

// 2.5

/// The lookup table, as stored.
#[derive(Clone, Copy, Debug)]
pub struct LookupTable<'a> {
    /// Number of entries.
    pub entries: usize,
    /// Number of bytes per entry, 6 or 9.
    pub entry_size: usize,
    /// Entries, `entries * entry_size` bytes.
    pub bytes: &'a [u8],
}

// 2.7

/// A run of bytes that contains some channels of every texel.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// Index of the first channel.
    pub channel: usize,
    /// Number of adjacent channels.
    pub channels: usize,
    /// Clause that requires the block.
    pub clause: &'static str,
}

// 2.8

/// Indices of all texels, as stored.
#[derive(Clone, Copy, Debug)]
pub struct IndexBlock<'a> {
    /// Indices, `width` bytes per texel.
    pub bytes: &'a [u8],
    /// Number of bytes per index.
    pub width: usize,
}

// 2.9

/// Numbers in the lists (2.9.1–2.9.7), as stored.
#[derive(Clone, Debug)]
pub struct RawLists {
    /// Number of planes in the file.
    pub planes: usize,
    /// Parameter of the encoder (2.9.1).
    pub parameter: Number,
    /// Transform of each plane's reference (2.9.2).
    pub transforms: Vec<Number>,
    /// Displacements of all planes along x, then along y (2.9.3).
    pub motion: Vec<Number>,
    /// Rank of each plane (2.9.4).
    pub order: Vec<Number>,
    /// Reference of each plane (2.9.5).
    pub references: Vec<Number>,
    /// Number of bytes in each plane's stream (2.9.6).
    pub sizes: Vec<Number>,
    /// Number of bytes in each plane's side information (2.9.7).
    pub side_sizes: Vec<Number>,
}

/// A number with its position in the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Number {
    /// Value of the number.
    pub value: i64,
    /// Offset in the file of the number's first character, which is a digit or a sign.
    pub at: usize,
}

/// A decoding plan. In the plans of the reference decoder, every reference plane exists and is decoded before the planes that are
/// predicted from it, and sizes are nonnegative.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Compression parameter.
    pub parameter: i64,
    /// Prediction step of each plane, indexed by plane.
    pub steps: Vec<Step>,
    /// Plane indices in decoding order.
    pub sequence: Vec<usize>,
    /// Byte ranges of each plane, relative to the first byte after the lists, indexed by plane.
    pub extents: Vec<Extent>,
}

/// Prediction step of a plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// Index of the reference, or `None` for an intra plane.
    pub reference: Option<usize>,
    /// True if the reference is inverted.
    pub inverted: bool,
    /// True if the reference is displaced.
    pub displaced: bool,
    /// Displacement along x and y, in half texels.
    pub motion: (i64, i64),
}

/// Byte ranges of a plane.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// Range of the stream.
    pub stream: Range<usize>,
    /// Range of the side information.
    pub side: Range<usize>,
}

/// All planes of a file before decoding, with their decoding plan.
#[derive(Clone, Copy, Debug)]
pub struct Coded<'a> {
    /// Coding standard of the streams: JPEG or JPEG-LS.
    pub coding: Coding,
    /// Size of every plane.
    pub size: Size,
    /// Decoding plan.
    pub plan: &'a Plan,
    /// Offset of `payload` in the file.
    pub at: usize,
    /// All streams and their side information. `plan.extents` refers to these bytes.
    pub payload: &'a [u8],
}

/// Stream of one plane.
#[derive(Clone, Copy, Debug)]
pub struct PlaneStream<'a> {
    /// Coding standard of the stream: JPEG or JPEG-LS.
    pub coding: Coding,
    /// Index of the plane, for errors.
    pub plane: usize,
    /// Offset of the stream in the file, for errors.
    pub at: usize,
    /// Bytes of the stream.
    pub bytes: &'a [u8],
    /// Size that the decoded image must have.
    pub size: Size,
}

/// A record of side information: a position in the stored plane, and the value of the texel at that position.
pub type Record = (u32, u8);
