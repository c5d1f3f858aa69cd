//! Compression of planes: the lists of §2.9 and the samples that are painted into the planes.

#![allow(clippy::cast_possible_wrap, reason = "there are at most 18 planes")]

use std::borrow::Cow;
use std::collections::HashSet;
use std::str::FromStr;

use super::predict::{INVERSION, MOTION};
use crate::error::{Error, Result};
use ptm::codec::{jpeg::JpegOptions, jpeg_ls::PresetParameters};
use ptm::{Coding, Format, Size};

/// Parameters for the compression of planes. Each list has one number per plane.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Compression {
    /// The coding standard of the streams.
    pub coding: Coding,
    /// JPEG quality or maximum error of JPEG-LS (2.9.1).
    pub parameter: u8,
    /// Transforms of the references (2.9.2).
    pub transforms: Vec<u32>,
    /// Horizontal motion in half texels (2.9.3).
    pub motion_x: Vec<i32>,
    /// Vertical motion in half texels (2.9.3).
    pub motion_y: Vec<i32>,
    /// The rank of each plane (2.9.4).
    pub order: Vec<i64>,
    /// The reference of each plane; negative for none (2.9.5).
    pub references: Vec<i64>,
    /// Records of side information in addition to the necessary ones (2.9.8).
    pub records: Vec<Records>,
    /// The kind of painted samples: planes or residuals.
    pub residuals: Residuals,
    /// Encoding options of the streams.
    pub stream: Stream,
    /// True if only planes 0, 2, 4 … use these options. The other planes use [`Stream::DEFAULT`].
    pub even_planes_only: bool,
}

/// Choices that JPEG and JPEG-LS leave to an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stream {
    /// JPEG: the options of the encoder. The plan overrides the quality.
    pub jpeg: JpegOptions,
    /// JPEG: true to write a JFIF segment, which the standard does not require.
    pub jfif: bool,
    /// JPEG-LS: number of bits per sample, 2 … 8.
    pub precision: u8,
    /// JPEG-LS: preset parameters.
    pub presets: Option<PresetParameters>,
    /// The component id in the headers of the stream.
    pub component: u8,
    /// True if the frame header precedes the quantization tables (JPEG) or follows the preset parameters (JPEG-LS).
    pub moves_frame_header: bool,
}

impl Stream {
    /// The default encoding options.
    pub const DEFAULT: Stream = Stream {
        jpeg: JpegOptions::new(75),
        jfif: true,
        precision: 8,
        presets: None,
        component: 1,
        moves_frame_header: false,
    };
}

/// Kinds of painted samples: planes or residuals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Residuals {
    /// The samples of the scene are planes. Residuals are computed by prediction.
    Natural,
    /// Residuals in 8×8 blocks, each with one pseudo-random value that every inverse DCT reconstructs exactly.
    Blocks,
    /// Like `Blocks`, but blocks at the edge are 128.
    Framed,
    /// Like `Blocks`, but the first texel of each block in predicted planes is −1, 0, 255 or 256 before reduction modulo 256.
    Wraps,
    /// Residuals that are 128 everywhere.
    Gray,
}

/// Records of side information in addition to the necessary ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Records {
    planes: PlaneSelection,
    texels: Texels,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PlaneSelection {
    All,
    Predicted,
    Intra,
    One(usize),
}

/// Texels that have a record, counted in stored order, from the bottom row (ruling `side-information`).
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Texels {
    First,
    Last,
    All,
    /// The texels at the edge of the plane.
    Border,
    /// The first texel, twice: a wrong value, then the correct one (ruling `side-twice`).
    Twice,
    /// These texels, in this order.
    List(Vec<usize>),
}

impl FromStr for Records {
    type Err = Error;

    /// Parses `PLANES:TEXELS`, such as `all:first`, `predicted:border`, `0:all`, `3:7+4+9`.
    fn from_str(text: &str) -> Result<Records> {
        let syntax_error = || Error::syntax("records such as 0:first", text);
        let (planes, texels) = text.split_once(':').ok_or_else(syntax_error)?;
        let planes = match planes {
            "all" => PlaneSelection::All,
            "predicted" => PlaneSelection::Predicted,
            "intra" => PlaneSelection::Intra,
            number => PlaneSelection::One(number.parse().map_err(|_| syntax_error())?),
        };
        let texels = match texels {
            "first" => Texels::First,
            "last" => Texels::Last,
            "all" => Texels::All,
            "border" => Texels::Border,
            "twice" => Texels::Twice,
            list => {
                let texels: Result<_, _> = list.split('+').map(str::parse).collect();
                Texels::List(texels.map_err(|_| syntax_error())?)
            }
        };
        Ok(Records { planes, texels })
    }
}

/// The references of the planes, and the order in which the planes are decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Structure {
    /// No plane has a reference.
    Intra,
    /// Each plane is predicted from the previous one.
    Chain,
    /// All other planes are predicted from plane 0.
    Star,
    /// A chain with steps of 5: plane 5k + 2 is predicted from plane 5k − 3, modulo the number of planes.
    Deep,
    /// Two trees, each with half the planes. Plane k of a tree is predicted from plane (k − 1) / 2 of the same tree.
    TwoTrees,
    /// Every third plane is intra, and the next two planes are predicted from it.
    SharedReference,
    /// Each plane is predicted from the next one. The last plane is intra.
    Upward,
    /// All other planes are predicted from the plane of rank 0. Ranks are rotated by 4, so the order is not its own inverse.
    Rotated,
    /// The structure of the only known real file, which shows a clay tablet.
    Tablet,
    /// Like `Star`, but all dependent planes have the same rank (ruling `ranks`).
    EqualRanks,
    /// Like `Chain`, with ranks 0, 10, 20 … (ruling `ranks`).
    Gaps,
    /// Like `Chain`, with ranks 1, 2, 3 … (ruling `ranks`).
    NoRankZero,
    /// No references, written as −2 (ruling `ranks`).
    BelowMinusOne,
}

impl Structure {
    /// Returns the references and ranks of `count` planes.
    fn lists(self, count: i64) -> (Vec<i64>, Vec<i64>) {
        (0..count).map(|i| self.plane(i, count)).unzip()
    }

    /// Returns the reference and rank of plane `i` of `count`.
    fn plane(self, i: i64, count: i64) -> (i64, i64) {
        let from = |reference: i64, is_root: bool| if is_root { -1 } else { reference };
        match self {
            Structure::Intra => (-1, i),
            Structure::BelowMinusOne => (-2, i),
            Structure::Chain => (i - 1, i),
            Structure::Gaps => (i - 1, 10 * i),
            Structure::NoRankZero => (i - 1, i + 1),
            Structure::Star => (from(0, i == 0), i),
            Structure::EqualRanks => (from(0, i == 0), i64::from(i > 0)),
            Structure::Deep => {
                let rank = (0..count).find(|k| (5 * k + 2) % count == i);
                let rank = rank.expect("5 and the number of planes are coprime");
                (from((i - 5).rem_euclid(count), rank == 0), rank)
            }
            Structure::TwoTrees => {
                let half = count / 2;
                let (root, k) = if i < half { (0, i) } else { (half, i - half) };
                (from(root + (k - 1) / 2, k == 0), i)
            }
            Structure::SharedReference => (from(i / 3 * 3, i % 3 == 0), i),
            Structure::Upward => (from(i + 1, i + 1 == count), count - 1 - i),
            Structure::Rotated => (from(count - 4, i == count - 4), (i + 4) % count),
            Structure::Tablet => {
                // The file has 9 planes. With 18 planes, the second half repeats the first, 9 planes and 9 ranks later.
                const REFERENCES: [i64; 9] = [-1, 5, -1, -1, -1, 0, 7, -1, 7];
                const ORDER: [i64; 9] = [4, 8, 3, 0, 1, 7, 5, 2, 6];
                let (k, half) = ((i % 9) as usize, i / 9 * 9);
                let reference = REFERENCES[k];
                (from(reference + half, reference < 0), ORDER[k] + half)
            }
        }
    }
}

impl Compression {
    /// Returns the default compression: no predicted planes, and either JPEG at quality 75 with blocks that every decoder
    /// reconstructs exactly, or lossless JPEG-LS.
    #[must_use]
    pub fn default_for(format: Format) -> Compression {
        let coding = format.coding().unwrap_or(Coding::JpegLs);
        let count = format.channels();
        let (references, order) = Structure::Intra.lists(count as i64);
        let (parameter, residuals) = match coding {
            Coding::Jpeg => (75, Residuals::Blocks),
            Coding::JpegLs => (0, Residuals::Natural),
        };
        Compression {
            coding,
            parameter,
            transforms: vec![0; count],
            motion_x: vec![0; count],
            motion_y: vec![0; count],
            order,
            references,
            records: Vec::new(),
            residuals,
            stream: Stream::DEFAULT,
            even_planes_only: false,
        }
    }

    /// Sets the references and ranks to those of a structure.
    pub fn set_structure(&mut self, structure: Structure) {
        (self.references, self.order) = structure.lists(self.order.len() as i64);
    }

    /// Returns one number per plane: `numbers`, repeated cyclically, and 0 for unpredicted planes unless `everywhere` is true.
    #[must_use]
    pub fn cycle<T: Copy + Default>(&self, numbers: &[T], everywhere: bool) -> Vec<T> {
        let number = |plane: usize| match everywhere || self.reference(plane).is_some() {
            true => numbers[plane % numbers.len()],
            false => T::default(),
        };
        (0..self.order.len()).map(number).collect()
    }

    /// Returns the reference of a plane (clauses 2.9.5/1–3).
    #[must_use]
    pub fn reference(&self, plane: usize) -> Option<usize> {
        usize::try_from(self.references[plane]).ok()
    }

    /// Returns the planes in decoding order, sorted by rank (clause 2.9.4/1).
    #[must_use]
    pub fn decoding_order(&self) -> Vec<usize> {
        let mut planes: Vec<usize> = (0..self.order.len()).collect();
        planes.sort_by_key(|&plane| self.order[plane]);
        planes
    }

    pub(super) fn vector(&self, plane: usize) -> (i32, i32) {
        (self.motion_x[plane], self.motion_y[plane])
    }

    pub(super) fn requested_records(&self, plane: usize, size: Size) -> Vec<usize> {
        let (width, texels) = (size.width as usize, size.texels());
        let edge = |texel: &usize| {
            texel.is_multiple_of(width)
                || texel % width == width - 1
                || texel / width == 0
                || texel / width == size.height as usize - 1
        };
        let (mut requested, mut seen) = (Vec::new(), HashSet::new());
        let applies = |records: &&Records| self.includes(records.planes, plane);
        for records in self.records.iter().filter(applies) {
            let more: Vec<usize> = match &records.texels {
                Texels::First | Texels::Twice => vec![0],
                Texels::Last => vec![texels - 1],
                Texels::All => (0..texels).collect(),
                Texels::Border => (0..texels).filter(edge).collect(),
                Texels::List(list) => list.clone(),
            };
            requested.extend(more.into_iter().filter(|&texel| seen.insert(texel)));
        }
        requested
    }

    pub(super) fn has_records(&self, plane: usize, texels: &Texels) -> bool {
        self.records
            .iter()
            .any(|records| self.includes(records.planes, plane) && records.texels == *texels)
    }

    fn includes(&self, planes: PlaneSelection, plane: usize) -> bool {
        match planes {
            PlaneSelection::All => true,
            PlaneSelection::Predicted => self.reference(plane).is_some(),
            PlaneSelection::Intra => self.reference(plane).is_none(),
            PlaneSelection::One(number) => number == plane,
        }
    }

    /// Returns the predicted planes with their transforms and vectors.
    fn predicted(&self) -> impl Iterator<Item = (usize, u32, (i32, i32))> {
        let planes = (0..self.order.len()).filter(|&plane| self.reference(plane).is_some());
        planes.map(|plane| (plane, self.transforms[plane], self.vector(plane)))
    }

    /// Returns true if any plane is predicted from another.
    #[must_use]
    pub fn predicts(&self) -> bool {
        self.predicted().next().is_some()
    }

    /// Returns true if any reference is inverted.
    #[must_use]
    pub fn inverts(&self) -> bool {
        let mut planes = self.predicted();
        planes.any(|(_, transform, _)| transform & INVERSION != 0)
    }

    /// Returns true if any reference is displaced.
    #[must_use]
    pub fn displaces(&self) -> bool {
        self.predicted()
            .any(|(_, transform, _)| transform & MOTION != 0)
    }

    /// Returns the open choices that may affect a file with these lists, although some may turn out to have no effect.
    #[must_use]
    pub fn axes(&self) -> Vec<&'static str> {
        let is_moved = |&(_, transform, vector): &_| transform & MOTION != 0 && vector != (0, 0);
        let moved: Vec<(usize, u32, (i32, i32))> = self.predicted().filter(is_moved).collect();
        let mut axes = Vec::new();
        let mut add = |axis, applies: bool| axes.extend(applies.then_some(axis));
        let offset = self.coding == Coding::JpegLs && self.predicts();
        let is_half = |&(_, _, (mx, my)): &(_, _, (i32, i32))| mx % 2 != 0 || my % 2 != 0;
        let is_inverted = |&(_, transform, _): &(_, u32, _)| transform & INVERSION != 0;
        add("jpeg-ls-offset", offset);
        add("motion-sign", !moved.is_empty());
        add(
            "motion-vertical",
            moved.iter().any(|(.., (_, my))| *my != 0),
        );
        add("motion-half", moved.iter().any(is_half));
        add("motion-border", !moved.is_empty());
        add("motion-inversion", moved.iter().any(is_inverted));
        add(
            "side-lossless",
            self.parameter == 0 && !self.records.is_empty(),
        );
        axes
    }

    /// Returns an error if no file can be written with these lists.
    pub(super) fn check(&self, size: Size) -> Result<()> {
        fn invalid(reason: impl Into<Cow<'static, str>>) -> Result<()> {
            Err(Error::InvalidRecipe(reason.into()))
        }
        let count = self.order.len();
        let (transforms, references) = (self.transforms.len(), self.references.len());
        let lengths = [
            transforms,
            self.motion_x.len(),
            self.motion_y.len(),
            references,
        ];
        if lengths != [count; 4] {
            return invalid(format!(
                "every list of this format must have {count} numbers"
            ));
        }
        for plane in 0..count {
            match self.reference(plane) {
                Some(reference) if reference >= count => {
                    return invalid(format!("plane {reference} does not exist"));
                }
                Some(reference) if self.order[reference] >= self.order[plane] => {
                    return invalid(format!(
                        "plane {plane} is decoded before its reference {reference}"
                    ));
                }
                _ => {}
            }
            let mut records = self.requested_records(plane, size).into_iter();
            if records.any(|texel| texel >= size.texels()) {
                return invalid("a record refers to a texel that does not exist");
            }
        }
        if size.width > 0xffff || size.height > 0xffff {
            return invalid("a JPEG stream must not be wider or taller than 65,535 samples");
        }
        match self.coding {
            Coding::Jpeg if !(1..=100).contains(&self.parameter) => {
                invalid("expected a quality from 1 to 100")
            }
            Coding::Jpeg if self.stream.jpeg.step == Some(0) => {
                invalid("a quantization step must not be 0")
            }
            Coding::Jpeg
                if (self.stream.jpeg.table_numbers)
                    .is_some_and(|numbers| numbers.iter().any(|&number| number > 3)) =>
            {
                invalid("a table number must be at most 3")
            }
            // The mean of 255 and 0 is far from both, so a different inverse DCT could cause a large deviation.
            Coding::Jpeg if self.residuals == Residuals::Natural && self.displaces() => {
                invalid("motion requires residuals that every inverse DCT reconstructs exactly")
            }
            Coding::JpegLs if self.parameter > 127 => {
                invalid("expected a maximum error from 0 to 127")
            }
            _ => Ok(()),
        }
    }
}
