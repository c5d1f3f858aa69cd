//! Features that a decoder may lack.

use std::fmt;

use ptm::Format;

/// A feature that a decoder may lack.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Feature {
    /// One of the nine formats.
    Format(Format),
    /// Tables with more than 256 entries.
    LargeTables,
    /// The `rgb` view of LUM files.
    LumColor,
    /// Planes that are predicted from other planes.
    Prediction,
    /// Prediction from inverted planes.
    Inversion,
    /// Prediction from displaced planes.
    Motion,
    /// Side information after the planes.
    SideInformation,
}

impl fmt::Display for Feature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Feature::Format(format) => f.write_str(format.short_name()),
            Feature::LargeTables => f.write_str("tables over 256 entries"),
            Feature::LumColor => f.write_str("rgb of LUM"),
            Feature::Prediction => f.write_str("prediction"),
            Feature::Inversion => f.write_str("inversion"),
            Feature::Motion => f.write_str("motion compensation"),
            Feature::SideInformation => f.write_str("side information"),
        }
    }
}
