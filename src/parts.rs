//! The parts of a file about which a reader decides something: what a decision of [`crate::reading::Reading`] is given
//! and what it gives back, section by section.
//!
//! The nouns of the result, [`crate::ptm::Planes`] above all, are in [`crate::ptm`].

use std::ops::Range;

use crate::ptm::{Format, Size};

// 2.5

/// The lookup table as it is stored.
#[derive(Clone, Copy, Debug)]
pub struct LookupTable<'a> {
    /// How many entries it has.
    pub entries: usize,
    /// Bytes of an entry: 6 or 9.
    pub entry_size: usize,
    /// `entries * entry_size` bytes.
    pub bytes: &'a [u8],
}

// 2.7

/// A run of bytes that holds some channels of every texel.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// The first of its channels.
    pub channel: usize,
    /// How many channels it has, side by side.
    pub channels: usize,
}

// 2.8

/// The indices of all texels as they are stored.
#[derive(Clone, Copy, Debug)]
pub struct IndexBlock<'a> {
    /// `width` bytes for each texel.
    pub bytes: &'a [u8],
    /// Bytes of an index.
    pub width: usize,
}

// 2.9

/// The numbers of 2.9.1–2.9.7 as they stand in the file.
#[derive(Clone, Debug)]
pub struct RawLists {
    /// JPEG or JPEG-LS, and how many planes there are.
    pub format: Format,
    /// 2.9.1: the parameter that the encoder was given.
    pub parameter: Number,
    /// 2.9.2: for each plane, what is done to its reference.
    pub transforms: Vec<Number>,
    /// 2.9.3: for each plane a displacement along x; then for each plane one along y.
    pub motion: Vec<Number>,
    /// 2.9.4: for each plane, its rank.
    pub order: Vec<Number>,
    /// 2.9.5: for each plane, the plane it is predicted from.
    pub references: Vec<Number>,
    /// 2.9.6: for each plane, the bytes of its stream.
    pub sizes: Vec<Number>,
    /// 2.9.7: for each plane, the bytes of its side information.
    pub side_sizes: Vec<Number>,
}

/// A number and the byte of the file where it stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Number {
    /// The number.
    pub value: i64,
    /// Where it stands.
    pub at: usize,
}

/// What the lists say to do. A plan that exists can be carried out: references exist and come first, sizes count bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The compression parameter.
    pub parameter: i64,
    /// How each plane is predicted; by plane.
    pub steps: Vec<Step>,
    /// The planes in the order in which they are decoded.
    pub sequence: Vec<usize>,
    /// Where each plane lies, counted from the first byte after the lists; by plane.
    pub extents: Vec<Extent>,
}

/// How a plane is predicted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// The plane it is predicted from, or nothing for an intra coded plane.
    pub reference: Option<usize>,
    /// Whether the reference is inverted first.
    pub inverted: bool,
    /// Whether the reference is displaced first.
    pub moved: bool,
    /// By how much, along x and y, in half texels.
    pub motion: (i64, i64),
}

/// Where a plane lies.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// Its stream.
    pub stream: Range<usize>,
    /// Its side information.
    pub side: Range<usize>,
}

/// All planes of a file, still compressed, and what to do with them.
#[derive(Clone, Copy, Debug)]
pub struct Coded<'a> {
    /// JPEG or JPEG-LS.
    pub format: Format,
    /// Texels of every plane.
    pub size: Size,
    /// What to do.
    pub plan: &'a Plan,
    /// Where in the file `payload` starts.
    pub at: usize,
    /// All streams and their side information, as `plan.extents` counts them.
    pub payload: &'a [u8],
}

/// The stream of one plane.
#[derive(Clone, Copy, Debug)]
pub struct PlaneStream<'a> {
    /// JPEG or JPEG-LS.
    pub format: Format,
    /// Which plane, for errors.
    pub plane: usize,
    /// Where in the file the stream starts, for errors.
    pub at: usize,
    /// The stream.
    pub bytes: &'a [u8],
    /// Texels that it must have.
    pub size: Size,
}

/// A record of side information: a position in the stored plane and the value that belongs there.
pub type Record = (u32, u8);
