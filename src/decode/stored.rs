//! The values of every texel, wherever in the file they lie: §2.7, §2.8 and §2.9.8 end here, and here alone rows are
//! turned
//!
//! ```text
//! file, LRGB, two rows:  coefficients of the lower row, of the upper row, colors of the lower row, of the upper row
//! part 0                 └──────────────────┬──────────────────────────┘ └──────────────────┬───────────────────┘ part 1
//! picture                upper row: a0 … a5 R G B of each texel; lower row: a0 … a5 R G B of each texel
//! ```
//!
//! Format notes
//! - In every format, the compressed ones included, the first stored row is the bottom row of the picture (ruling `rows`).
//!   Everything before this file counts rows as they are stored, everything after it from the top.
//! - All that can be wrong with a file has been found before: no index is out of range and no byte is missing any more.
//!
//! Rows are made when they are asked for, so that a large map needs no more memory than its file, and a compressed one no
//! more than its planes.

use std::ops::Range;

use super::channels::Channels;
use super::runs;
use crate::error::Result;
use crate::ptm::{Header, Limits, Planes, Ptm, Shape, Size};
use crate::reading::Reading;

/// Texels of a piece, at most: so few that a piece with eighteen channels stays in the nearest cache while it is made.
const PIECE: u32 = 1 << 10;

/// A map of which everything has been checked and nothing put together yet.
pub struct Stored<'a> {
    /// What 2.1–2.4 say of it.
    pub header: Header,
    /// What its channels mean.
    pub shape: Shape,
    pub(super) parts: Vec<Channels<'a>>,
    /// Where the values end in the file.
    pub(super) at: usize,
    pub(super) reading: &'a Reading,
}

impl Stored<'_> {
    /// Puts all texels together.
    ///
    /// # Errors
    /// [`Kind::TooLarge`](crate::error::Kind::TooLarge) if they need more room than the limit allows.
    pub fn planes(&self, limits: &Limits) -> Result<Planes> {
        let Size { width, height } = self.header.size;
        let channels = self.shape.channels();
        // What the parts hold besides the file, the planes of a compressed one, is there at the same time.
        let held: usize = self.parts.iter().map(Channels::held).sum();
        let needs = self.header.size.bytes(channels);
        limits.check(needs.saturating_add(held as u64), self.at)?;
        let mut samples = vec![0; self.header.size.texels() * channels];
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
        let width = self.header.size.width as usize;
        let start = (self.reading.stored_row)(&self.header, row as usize) * width;
        let run = start + columns.start as usize..start + columns.end as usize;
        for part in &self.parts {
            // As [`Channels::put`], sooner.
            runs::put(
                part,
                run.clone(),
                texels,
                self.shape.channels(),
                self.reading,
            );
        }
    }
}
