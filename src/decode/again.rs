//! Streams that are decoded once for all readings that differ only after the codec
//!
//! Most open points of §2.9 concern steps after a stream has been decoded: how its plane is
//! predicted, and which records correct it. To see whether a file looks different to another
//! reader, prediction and correction are repeated; decoding the streams, which takes most of the
//! time, is not.
//!
//! ```text
//! stream ── codec ──> residuals ──┬── Reading::SPEC ──> planes of the reference
//!                                 ├── another one ────> planes of another reader
//!                                 └── …
//! ```

use super::compressed::Streams;
use super::stored::Stored;
use crate::error::Result;
use crate::ptm::Shape;
use crate::reading::Reading;

impl Streams<'_> {
    /// Returns the map under a reading that differs only after the streams are decoded.
    pub(crate) fn stored<'r>(&self, reading: &'r Reading) -> Result<Stored<'r>> {
        let parts = self.channels(self.residuals.clone(), reading)?;
        // All compressed formats have the planes of RGB or those of LRGB (clause 2.9/3).
        let shape = match self.header.format.shape() {
            Shape::Rgb => Shape::Rgb,
            _ => Shape::Lrgb,
        };
        Ok(Stored {
            header: self.header,
            shape,
            parts,
            // The end of the last plane, where a map that is too large is refused.
            at: self.at + self.payload.len(),
            reading,
        })
    }
}
