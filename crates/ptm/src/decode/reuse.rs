//! Reuse of decoded streams under several readings
//!
//! Most open questions of §2.9 concern steps after a stream is decoded: how its plane is predicted, and which records
//! correct it. To find out whether another decoder would decode a file differently, prediction and correction are
//! repeated. The streams are decoded only once, because decoding takes most of the time.
//!
//! ```text
//! stream ── codec ──> residuals ──┬── Reading::SPEC ──> planes of the reference
//!                                 ├── alternative ────> planes of another reader
//!                                 └── …
//! ```

use super::{compressed::Streams, stored::StoredMap};
use crate::error::Result;
use crate::reading::Reading;
use crate::types::Shape;

impl Streams<'_> {
    /// Returns the map under a reading that differs from the original one only in steps after stream decoding.
    ///
    /// # Errors
    /// Returns the violated clause, the byte offset, and what was found there.
    pub fn reconstruct_map<'r>(&self, reading: &'r Reading) -> Result<StoredMap<'r>> {
        let parts = self.channels(self.residuals.clone(), reading)?;
        // All compressed formats have the planes of RGB or those of LRGB (clause 2.9/3).
        let shape = match self.header.format.shape() {
            Shape::Rgb => Shape::Rgb,
            _ => Shape::Lrgb,
        };
        Ok(StoredMap {
            header: self.header,
            shape,
            parts,
            // The end of the last plane is the offset of the error if the map is too large.
            at: self.at + self.payload.len(),
            reading,
        })
    }
}
