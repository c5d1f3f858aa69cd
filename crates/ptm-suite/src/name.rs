//! Names of the suites.

use serde::{Deserialize, Serialize};

/// The name of a suite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SuiteName {
    /// PTM files.
    Ptm,
    /// Questions for a texture stage.
    Texture,
    /// Requests to write PTM files.
    Writers,
    /// Images to be fitted.
    Fitters,
}

impl SuiteName {
    /// Returns a short title of the suite.
    #[must_use]
    pub const fn short_title(self) -> &'static str {
        match self {
            SuiteName::Ptm => "PTM 1.2",
            SuiteName::Texture => "PEX texture mapping",
            SuiteName::Writers => "PTM 1.2 writing",
            SuiteName::Fitters => "PTM 1.2 fitting",
        }
    }

    /// Returns the title of the suite.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            SuiteName::Ptm => "Conformance with the Polynomial Texture Map format, PTM 1.2",
            SuiteName::Texture => "Conformance with the texture mapping table of PEXlib",
            SuiteName::Writers => "Conformance of PTM 1.2 files written by a program",
            SuiteName::Fitters => "How well PTM 1.2 files fit the images they were made from",
        }
    }

    /// Returns the kind of program under test.
    #[must_use]
    pub const fn subject(self) -> &'static str {
        match self {
            SuiteName::Ptm | SuiteName::Texture => "decoder",
            SuiteName::Writers => "writer",
            SuiteName::Fitters => "fitter",
        }
    }
}
