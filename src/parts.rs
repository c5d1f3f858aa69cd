//! The parts of a file about which a reader makes decisions: arguments and results of the decisions of
//! [`crate::reading::Reading`], section by section.
//!
//! The types of the result, mainly [`crate::ptm::Planes`], are in [`crate::ptm`].

use std::ops::Range;

use crate::ptm::{Coding, Size};

// 2.5

/// The lookup table as it is stored.
#[derive(Clone, Copy, Debug)]
pub struct LookupTable<'a> {
    /// Number of entries.
    pub entries: usize,
    /// Bytes per entry: 6 or 9.
    pub entry_size: usize,
    /// `entries * entry_size` bytes.
    pub bytes: &'a [u8],
}

// 2.7

/// A run of bytes that holds some channels of every texel.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// Its first channel.
    pub channel: usize,
    /// Number of adjacent channels.
    pub channels: usize,
    /// The clause that requires it.
    #[cfg_attr(
        not(feature = "harness"),
        expect(
            dead_code,
            reason = "a decoder cites the clause that all formats share"
        )
    )]
    pub clause: &'static str,
}

// 2.8

/// The indices of all texels as they are stored.
#[derive(Clone, Copy, Debug)]
pub struct IndexBlock<'a> {
    /// `width` bytes for each texel.
    pub bytes: &'a [u8],
    /// Bytes per index.
    pub width: usize,
}

// 2.9

/// The numbers of 2.9.1–2.9.7 as stored in the file.
#[derive(Clone, Debug)]
pub struct RawLists {
    /// The number of planes.
    pub planes: usize,
    /// 2.9.1: the parameter of the encoder.
    pub parameter: Number,
    /// 2.9.2: for each plane, the transform of its reference.
    pub transforms: Vec<Number>,
    /// 2.9.3: for each plane a displacement along x; then for each plane one along y.
    pub motion: Vec<Number>,
    /// 2.9.4: for each plane, its rank.
    pub order: Vec<Number>,
    /// 2.9.5: for each plane, its reference.
    pub references: Vec<Number>,
    /// 2.9.6: for each plane, the bytes of its stream.
    pub sizes: Vec<Number>,
    /// 2.9.7: for each plane, the bytes of its side information.
    pub side_sizes: Vec<Number>,
}

/// A number and its position in the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Number {
    /// The number.
    pub value: i64,
    /// The byte of the file at which it begins.
    pub at: usize,
}

/// The decoding plan of the lists. Every plan can be carried out: references exist and come first, sizes count bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The compression parameter.
    pub parameter: i64,
    /// The prediction of each plane, by plane.
    pub steps: Vec<Step>,
    /// The planes in the order in which they are decoded.
    pub sequence: Vec<usize>,
    /// The place of each plane, counted from the first byte after the lists, by plane.
    pub extents: Vec<Extent>,
}

/// The prediction of a plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// The reference, or None for an intra coded plane.
    pub reference: Option<usize>,
    /// True if the reference is inverted first.
    pub inverted: bool,
    /// True if the reference is displaced before it is used as the predictor.
    pub moved: bool,
    /// The displacement along x and y, in half texels.
    pub motion: (i64, i64),
}

/// The place of a plane.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// Its stream.
    pub stream: Range<usize>,
    /// Its side information.
    pub side: Range<usize>,
}

/// All planes of a file, still compressed, and their decoding plan.
#[derive(Clone, Copy, Debug)]
pub struct Coded<'a> {
    /// The standard of the streams.
    pub coding: Coding,
    /// The size of every plane.
    pub size: Size,
    /// The decoding plan.
    pub plan: &'a Plan,
    /// The position of `payload` in the file.
    pub at: usize,
    /// All streams and their side information, to which `plan.extents` refers.
    pub payload: &'a [u8],
}

/// The stream of one plane.
#[derive(Clone, Copy, Debug)]
pub struct PlaneStream<'a> {
    /// Its standard.
    pub coding: Coding,
    /// The plane, for errors.
    pub plane: usize,
    /// The position of the stream in the file, for errors.
    pub at: usize,
    /// The stream.
    pub bytes: &'a [u8],
    /// The required size of the image.
    pub size: Size,
}

/// A record of side information: a position in the stored plane and the value of that texel.
pub type Record = (u32, u8);
