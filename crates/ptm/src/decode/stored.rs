//! The values of every texel, assembled from §2.7, §2.8 or §2.9.8. This module is the only place that flips rows.
//!
//! ```text
//! file, LRGB, two rows:  coefficients of the lower row, of the upper row, colors of the lower row, of the upper row
//! part 0                 └──────────────────┬──────────────────────────┘ └──────────────────┬───────────────────┘ part 1
//! image                  upper row: a0 … a5 R G B of each texel; lower row: a0 … a5 R G B of each texel
//! ```
//!
//! Format notes
//! - In every format, including compressed ones, the first stored row is the bottom row of the image (ruling `rows`).
//!   Earlier stages count rows in stored order, later ones from the top.
//! - All errors were detected before this stage: no index is out of range, and no byte is missing.
//!
//! Rows are assembled on demand, so a large map needs no more memory than its file, and a compressed map no more than its planes.

use std::ops::Range;

use super::{channels::Channels, runs};
use crate::error::Result;
use crate::reading::Reading;
use crate::types::{Header, Limits, Planes, Ptm, Shape, Size};

/// Maximum number of texels in a piece. A piece with eighteen channels fits in the L1 cache.
const MAX_PIECE_TEXELS: u32 = 1 << 10;

/// A validated map whose texels have not been assembled.
pub struct StoredMap<'a> {
    /// Header (2.1–2.4).
    pub header: Header,
    /// Shape of each texel.
    pub shape: Shape,
    pub(super) parts: Vec<Channels<'a>>,
    /// Offset of the end of the values in the file.
    pub(super) at: usize,
    pub(super) reading: &'a Reading,
}

impl StoredMap<'_> {
    /// Assembles the whole map.
    ///
    /// # Errors
    /// Returns [`Kind::TooLarge`](crate::error::Kind::TooLarge) if the texels need more memory than the limit allows.
    pub fn decode(&self, limits: &Limits) -> Result<Ptm> {
        let Size { width, height } = self.header.size;
        let channels = self.shape.channels();
        // The planes of a compressed file stay in memory in addition to the file and the assembled texels.
        let owned: usize = self.parts.iter().map(Channels::owned_bytes).sum();
        let assembled = self.header.size.bytes(channels);
        limits.check(assembled.saturating_add(owned as u64), self.at)?;
        let mut samples = vec![0; self.header.size.texels() * channels];
        let rows = samples.chunks_exact_mut(width as usize * channels);
        for (row, texels) in (0..height).zip(rows) {
            self.read(row, 0..width, texels);
        }
        let planes = Planes {
            size: self.header.size,
            shape: self.shape,
            samples,
        };
        Ok(Ptm {
            header: self.header,
            planes,
        })
    }

    /// Returns the map as a sequence of small maps of at most one row, from left to right and from top to bottom.
    pub fn pieces(&self) -> impl Iterator<Item = Ptm> {
        let Size { width, height } = self.header.size;
        let columns = move || {
            let starts = (0..width).step_by(MAX_PIECE_TEXELS as usize);
            starts.map(move |start| start..width.min(start.saturating_add(MAX_PIECE_TEXELS)))
        };
        let pieces = (0..height).flat_map(move |row| columns().map(move |columns| (row, columns)));
        pieces.map(|(row, columns)| self.piece(row, columns))
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

    /// Assembles the texels of a row in the given columns. Rows are counted from the top.
    fn read(&self, row: u32, columns: Range<u32>, texels: &mut [u8]) {
        let width = self.header.size.width as usize;
        let start = (self.reading.stored_row)(&self.header, row as usize) * width;
        let run = start + columns.start as usize..start + columns.end as usize;
        for part in &self.parts {
            // This is a faster version of [`Channels::copy_to`].
            runs::copy_run(
                part,
                run.clone(),
                texels,
                self.shape.channels(),
                self.reading,
            );
        }
    }
}
