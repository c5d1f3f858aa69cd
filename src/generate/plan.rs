//! Compression of planes: the lists of §2.9 and the samples that are painted into the planes.

#![allow(clippy::cast_possible_wrap, reason = "planes are at most 18")]

use std::str::FromStr;

use super::predict::{INVERSION, MOTION};
use crate::codec::jpeg::JpegOptions;
use crate::codec::jpeg_ls::PresetParameters;
use crate::ptm::{Coding, Format, Size};

/// Parameters for the compression of planes. All lists have a number for each plane.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Compression {
    /// The standard of the streams.
    pub coding: Coding,
    /// Quality of JPEG, maximum error of JPEG-LS (2.9.1).
    pub parameter: u8,
    /// Transforms of the references (2.9.2).
    pub transforms: Vec<u32>,
    /// Motion along rows, in half texels (2.9.3).
    pub motion_x: Vec<i32>,
    /// Motion across rows, in half texels.
    pub motion_y: Vec<i32>,
    /// The rank of each plane (2.9.4).
    pub order: Vec<i64>,
    /// The reference of each plane; negative for none (2.9.5).
    pub references: Vec<i64>,
    /// Side information in addition to what is needed (2.9.8).
    pub records: Vec<Records>,
    /// The painted samples: the planes, or their residuals.
    pub residuals: Residuals,
    /// The spelling of the streams.
    pub stream: Stream,
    /// True if only the streams of planes 0, 2, 4 … have this spelling; the others are plain.
    pub alternates: bool,
}

/// Choices that JPEG and JPEG-LS leave to an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stream {
    /// JPEG: the options of the encoder; the quality is that of the plan.
    pub jpeg: JpegOptions,
    /// JPEG: a JFIF segment, which the standards of 2.9.8 do not require.
    pub jfif: bool,
    /// JPEG-LS: preset parameters.
    pub presets: Option<PresetParameters>,
    /// The component id.
    pub component: u8,
    /// The frame header precedes the quantization tables of JPEG, and follows the preset parameters of JPEG-LS.
    pub frame_moved: bool,
}

impl Stream {
    /// The defaults.
    pub const PLAIN: Stream = Stream {
        jpeg: JpegOptions::new(75),
        jfif: true,
        presets: None,
        component: 1,
        frame_moved: false,
    };
}

/// The painted samples of planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "harness", derive(serde::Deserialize))]
#[cfg_attr(feature = "harness", serde(rename_all = "kebab-case"))]
pub enum Residuals {
    /// The samples of the scene, as planes; the residuals follow by prediction.
    Natural,
    /// Residuals, in 8×8 blocks of one pseudo-random value that every inverse DCT restores.
    Blocks,
    /// Like `Blocks`, but 128 in blocks at the edge.
    Framed,
    /// Like `Blocks`, but in predicted planes the first texel of each block becomes −1, 0, 255 or 256 before the modulus.
    Wraps,
    /// 128 everywhere.
    Gray,
}

/// Additional records of side information that no texel needs.
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

/// Texels that have a record, counted in the stored raster, from the bottom row (ruling `side-information`).
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Texels {
    First,
    Last,
    All,
    /// The texels at the edge.
    Border,
    /// The first texel, twice: a wrong value, then the right one (ruling `side-twice`).
    Twice,
    /// These texels, in this order.
    These(Vec<usize>),
}

impl FromStr for Records {
    type Err = String;

    /// Parses `PLANES:TEXELS`, such as `all:first`, `predicted:border`, `0:all`, `3:7+4+9`.
    fn from_str(text: &str) -> Result<Records, String> {
        let wrong = || format!("expected records such as 0:first, found {text:?}");
        let (planes, texels) = text.split_once(':').ok_or_else(wrong)?;
        let planes = match planes {
            "all" => PlaneSelection::All,
            "predicted" => PlaneSelection::Predicted,
            "intra" => PlaneSelection::Intra,
            number => PlaneSelection::One(number.parse().map_err(|_| wrong())?),
        };
        let texels = match texels {
            "first" => Texels::First,
            "last" => Texels::Last,
            "all" => Texels::All,
            "border" => Texels::Border,
            "twice" => Texels::Twice,
            list => {
                let texels: Result<_, _> = list.split('+').map(str::parse).collect();
                Texels::These(texels.map_err(|_| wrong())?)
            }
        };
        Ok(Records { planes, texels })
    }
}

/// The references of planes and their order of decoding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "harness", derive(serde::Deserialize))]
#[cfg_attr(feature = "harness", serde(rename_all = "kebab-case"))]
pub enum Structure {
    /// No references.
    Intra,
    /// Each plane from the one before it.
    Chain,
    /// All planes from plane 0.
    Star,
    /// A chain in steps: plane 5k + 2 from plane 5k − 3, modulo the number of planes.
    Deep,
    /// Two trees of half the planes; plane k of a tree from plane (k − 1) / 2 of it.
    TwoTrees,
    /// Every third plane intra, the two after it from that plane.
    SharedReference,
    /// Each plane from the one after it; the last is intra.
    Upward,
    /// All planes from the plane of rank 0; ranks begin in the middle, so that the order differs from its inverse.
    Rotated,
    /// The structure of the one real file, of a clay tablet.
    Tablet,
    /// Like `Star`, but all dependent planes have one rank (ruling `ranks`).
    EqualRanks,
    /// Like `Chain`, with ranks 0, 10, 20 … (ruling `ranks`).
    Gaps,
    /// Like `Chain`, with ranks from 1 (ruling `ranks`).
    NoRankZero,
    /// No references, written −2 (ruling `ranks`).
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
                let rank = rank.expect("5 has no divisor in common with 9 or 18");
                (from((i - 5).rem_euclid(count), rank == 0), rank)
            }
            Structure::TwoTrees => {
                let half = count / 2;
                let (root, place) = if i < half { (0, i) } else { (half, i - half) };
                (from(root + (place - 1) / 2, place == 0), i)
            }
            Structure::SharedReference => (from(i / 3 * 3, i % 3 == 0), i),
            Structure::Upward => (from(i + 1, i + 1 == count), count - 1 - i),
            Structure::Rotated => (from(count - 4, i == count - 4), (i + 4) % count),
            Structure::Tablet => {
                // The file has 9 planes; in 18 planes the second half repeats the first, 9 planes and 9 ranks later.
                const REFERENCES: [i64; 9] = [-1, 5, -1, -1, -1, 0, 7, -1, 7];
                const ORDER: [i64; 9] = [4, 8, 3, 0, 1, 7, 5, 2, 6];
                let (place, half) = ((i % 9) as usize, i / 9 * 9);
                let reference = REFERENCES[place];
                (from(reference + half, reference < 0), ORDER[place] + half)
            }
        }
    }
}

impl Compression {
    /// The default compression: no predicted planes; JPEG at quality 75 in blocks that every decoder restores exactly, lossless
    /// JPEG-LS.
    #[must_use]
    pub fn ordinary(format: Format) -> Compression {
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
            stream: Stream::PLAIN,
            alternates: false,
        }
    }

    /// Sets references and ranks.
    pub fn set_structure(&mut self, structure: Structure) {
        (self.references, self.order) = structure.lists(self.order.len() as i64);
    }

    /// Repeats numbers over the predicted planes, or over all; the others have 0.
    #[must_use]
    pub fn cycled<T: Copy + Default>(&self, numbers: &[T], everywhere: bool) -> Vec<T> {
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

    /// Returns the planes by rank, the order in which they are decoded (clause 2.9.4/1).
    #[must_use]
    pub fn in_order(&self) -> Vec<usize> {
        let mut planes: Vec<usize> = (0..self.order.len()).collect();
        planes.sort_by_key(|&plane| self.order[plane]);
        planes
    }

    pub(super) fn vector(&self, plane: usize) -> (i32, i32) {
        (self.motion_x[plane], self.motion_y[plane])
    }

    /// Returns the texels of a plane for which the recipe requests a record.
    pub(super) fn requested_records(&self, plane: usize, size: Size) -> Vec<usize> {
        let (width, texels) = (size.width as usize, size.texels());
        let edge = |place: &usize| {
            place.is_multiple_of(width)
                || place % width == width - 1
                || place / width == 0
                || place / width == size.height as usize - 1
        };
        let mut places: Vec<usize> = Vec::new();
        let concerns = |records: &&Records| self.includes(records.planes, plane);
        for records in self.records.iter().filter(concerns) {
            let more: Vec<usize> = match &records.texels {
                Texels::First | Texels::Twice => vec![0],
                Texels::Last => vec![texels - 1],
                Texels::All => (0..texels).collect(),
                Texels::Border => (0..texels).filter(edge).collect(),
                Texels::These(list) => list.clone(),
            };
            for place in more {
                if !places.contains(&place) {
                    places.push(place);
                }
            }
        }
        places
    }

    /// Returns true if a plane has records of this kind.
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

    /// Returns the predicted planes: their number, transform and vector.
    fn predicted(&self) -> impl Iterator<Item = (usize, u32, (i32, i32))> {
        let planes = (0..self.order.len()).filter(|&plane| self.reference(plane).is_some());
        planes.map(|plane| (plane, self.transforms[plane], self.vector(plane)))
    }

    /// Returns true if a plane is predicted from another.
    #[must_use]
    pub fn predicts(&self) -> bool {
        self.predicted().next().is_some()
    }

    /// Returns true if a reference is inverted.
    #[must_use]
    pub fn inverts(&self) -> bool {
        let mut planes = self.predicted();
        planes.any(|(_, transform, _)| transform & INVERSION != 0)
    }

    /// Returns true if a reference is displaced.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.predicted()
            .any(|(_, transform, _)| transform & MOTION != 0)
    }

    /// Returns the open choices that may affect a file with these lists, possibly more than do.
    #[must_use]
    pub fn axes(&self) -> Vec<&'static str> {
        let is_moved = |&(_, transform, vector): &_| transform & MOTION != 0 && vector != (0, 0);
        let moved: Vec<(usize, u32, (i32, i32))> = self.predicted().filter(is_moved).collect();
        let mut axes = Vec::new();
        let mut add = |axis, shows: bool| axes.extend(shows.then_some(axis));
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
    pub(super) fn check(&self, size: Size) -> Result<(), String> {
        let count = self.order.len();
        let (transforms, references) = (self.transforms.len(), self.references.len());
        let lengths = [
            transforms,
            self.motion_x.len(),
            self.motion_y.len(),
            references,
        ];
        if lengths != [count; 4] {
            return Err(format!(
                "expected {count} numbers in every list of this format"
            ));
        }
        for plane in 0..count {
            match self.reference(plane) {
                Some(reference) if reference >= count => {
                    return Err(format!("there is no plane {reference}"));
                }
                Some(reference) if self.order[reference] >= self.order[plane] => {
                    return Err(format!(
                        "plane {plane} is decoded before its reference {reference}"
                    ));
                }
                _ => {}
            }
            let mut places = self.requested_records(plane, size).into_iter();
            if places.any(|place| place >= size.texels()) {
                return Err("a record refers to a texel that does not exist".to_owned());
            }
        }
        if size.width > 0xffff || size.height > 0xffff {
            return Err("a JPEG stream must not be wider or taller than 65,535 samples".to_owned());
        }
        match self.coding {
            Coding::Jpeg if !(1..=100).contains(&self.parameter) => {
                Err("expected a quality from 1 to 100".to_owned())
            }
            Coding::Jpeg if self.stream.jpeg.step == Some(0) => {
                Err("a divisor must not be 0".to_owned())
            }
            Coding::Jpeg
                if (self.stream.jpeg.table_numbers)
                    .is_some_and(|numbers| numbers.iter().any(|&number| number > 3)) =>
            {
                Err("a table number must be at most 3".to_owned())
            }
            // A mean of 255 and 0 is far from both, so another inverse DCT could deviate by much.
            Coding::Jpeg if self.residuals == Residuals::Natural && self.moves() => {
                Err("motion needs residuals that every inverse DCT reconstructs exactly".to_owned())
            }
            Coding::JpegLs if self.parameter > 127 => {
                Err("expected a loss from 0 to 127".to_owned())
            }
            _ => Ok(()),
        }
    }
}
