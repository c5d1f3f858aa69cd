//! Streams that are decoded once, for all readings that differ only in what they make of them
//!
//! Most open points of §2.9 are about what happens after a stream has been decoded: how its plane is predicted, and which
//! records correct it. To see whether a file looks another way to another reader, prediction and correction are done again
//! and the streams, which take most of the time, are not.
//!
//! ```text
//! stream ── codec ──> residuals ──┬── Reading::SPEC ──> planes of the reference
//!                                 ├── another one ────> planes of another reader
//!                                 └── …
//! ```

use super::compressed::Streams;
use super::stored::Stored;
use crate::error::Result;
use crate::ptm::{Format, Shape};
use crate::reading::Reading;

impl Streams<'_> {
    /// The map under a reading that differs only in what it makes of the streams.
    pub(crate) fn stored<'r>(&self, reading: &'r Reading) -> Result<Stored<'r>> {
        let parts = self.channels(self.residuals.clone(), reading)?;
        // All compressed formats have the planes of RGB or those of LRGB (clause 2.9/3).
        let shape = match self.header.format {
            Format::JpegRgb | Format::JpeglsRgb => Shape::Rgb,
            _ => Shape::Lrgb,
        };
        Ok(Stored {
            header: self.header,
            shape,
            parts,
            // The end of the last plane, where too large a map is refused.
            at: self.at + self.payload.len(),
            reading,
        })
    }
}
