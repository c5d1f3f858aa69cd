//! The values of every texel, wherever in the file they lie: §2.7, §2.8 and §2.9.8 end here, and here alone rows are
//! turned.
//!
//! A format stores its channels in *parts*: blocks of a few channels (2.7), indices into a table (2.8), planes (2.9.8).
//! A part has its rows one after another; which of them is which row of the picture is the reading's to say. Rows are
//! made when they are asked for, so that a large map needs no more room than its file, and a compressed one no more than
//! its planes.

use std::borrow::Cow;
use std::ops::Range;

use super::indices::Indices;
use super::{Header, Limits, Ptm};
use crate::error::{Error, Kind, Result};
use crate::ptm::{Planes, Shape, Size};
use crate::reading::Reading;

/// Texels of a piece, at most: so few that a piece with eighteen channels stays in the nearest cache while it is made.
const PIECE: u32 = 1 << 10;

/// A map of which everything has been checked and nothing put together yet.
pub struct Stored<'a> {
    /// What 2.1–2.4 say of it.
    pub header: Header,
    /// What its channels mean.
    pub shape: Shape,
    pub(super) parts: Vec<Part<'a>>,
    /// Where the values end in the file.
    pub(super) at: usize,
    pub(super) reading: &'a Reading,
}

/// Some channels of every texel.
pub(super) struct Part<'a> {
    /// The first of its channels.
    pub channel: usize,
    /// How many channels, side by side.
    pub channels: usize,
    pub values: Values<'a>,
}

/// How a part has its values: texel after texel, row after stored row.
pub(super) enum Values<'a> {
    /// As they are.
    Bytes(Cow<'a, [u8]>),
    /// As rows of a table.
    Indices(Indices<'a>),
}

impl Stored<'_> {
    /// Puts all texels together.
    ///
    /// # Errors
    /// [`Kind::TooLarge`] if they need more room than the limit allows.
    pub fn planes(&self, limits: &Limits) -> Result<Planes> {
        let Size { width, height } = self.header.size;
        let channels = self.shape.channels();
        let planes = self.header.size.texels().saturating_mul(channels);
        let held = self.parts.iter().map(Part::held).sum();
        limits.check(planes.saturating_add(held), self.at)?;
        let mut samples = vec![0; planes];
        let rows = samples.chunks_exact_mut(width as usize * channels);
        for (row, texels) in (0..height).zip(rows) {
            self.read(row, 0..width, texels);
        }
        Ok(Planes {
            size: self.header.size,
            shape: self.shape,
            samples,
        })
    }

    /// The map in pieces of a row or less, from left to right and from top to bottom: little maps.
    pub fn pieces(&self) -> impl Iterator<Item = Ptm> {
        let Size { width, height } = self.header.size;
        let columns = move || {
            let starts = (0..width).step_by(PIECE as usize);
            starts.map(move |start| start..width.min(start.saturating_add(PIECE)))
        };
        let places = (0..height).flat_map(move |row| columns().map(move |columns| (row, columns)));
        places.map(|(row, columns)| self.piece(row, columns))
    }

    fn piece(&self, row: u32, columns: Range<u32>) -> Ptm {
        let size = Size {
            width: columns.end - columns.start,
            height: 1,
        };
        let mut samples = vec![0; size.texels() * self.shape.channels()];
        self.read(row, columns, &mut samples);
        Ptm {
            header: Header {
                size,
                ..self.header
            },
            planes: Planes {
                size,
                shape: self.shape,
                samples,
            },
        }
    }

    /// Puts together some texels of row `row` from the top.
    fn read(&self, row: u32, columns: Range<u32>, texels: &mut [u8]) {
        let Size { width, height } = self.header.size;
        for (i, part) in self.parts.iter().enumerate() {
            let stored_row = self.reading.stored_row;
            let stored = stored_row(self.header.format, i, row as usize, height as usize);
            let start = stored * width as usize;
            let run = start + columns.start as usize..start + columns.end as usize;
            part.read(run, texels, self.shape.channels(), self.reading);
        }
    }
}

impl Part<'_> {
    /// Bytes that it takes besides the file.
    fn held(&self) -> usize {
        match &self.values {
            Values::Bytes(Cow::Owned(bytes)) => bytes.len(),
            _ => 0,
        }
    }

    /// Puts the values of some stored texels where they belong in `texels`, which have `size` channels each.
    fn read(&self, run: Range<usize>, texels: &mut [u8], size: usize, reading: &Reading) {
        match &self.values {
            Values::Bytes(bytes) => {
                let bytes = &bytes[run.start * self.channels..run.end * self.channels];
                // The numbers of channels that the text has, each with a loop of its own; the others have one together.
                match self.channels {
                    channels if channels == size => texels.copy_from_slice(bytes),
                    1 => place::<1>(bytes, self.channel, texels, size),
                    3 => place::<3>(bytes, self.channel, texels, size),
                    6 => place::<6>(bytes, self.channel, texels, size),
                    channels => {
                        for (texel, values) in texels
                            .chunks_exact_mut(size)
                            .zip(bytes.chunks_exact(channels))
                        {
                            texel[self.channel..][..channels].copy_from_slice(values);
                        }
                    }
                }
            }
            Values::Indices(indices) => indices.read(run, texels, size, reading),
        }
    }
}

/// Puts `N` values of each texel behind its first `channel`.
fn place<const N: usize>(bytes: &[u8], channel: usize, texels: &mut [u8], size: usize) {
    for (texel, values) in texels.chunks_exact_mut(size).zip(bytes.as_chunks::<N>().0) {
        texel[channel..][..N].copy_from_slice(values);
    }
}

impl Limits {
    /// Whether so many bytes are within the limit; `at` is where the file asks for them.
    pub(super) fn check(&self, needs: usize, at: usize) -> Result<()> {
        if needs > self.memory {
            let limit = self.memory;
            return Err(Error::new("2.3/3", at, Kind::TooLarge { needs, limit }));
        }
        Ok(())
    }
}
