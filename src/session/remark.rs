//! Remarks on a run as a whole.

use serde::{Deserialize, Serialize};

/// A remark on a run as a whole.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Remark {
    /// True if the decoder fails because of it.
    pub failure: bool,
    /// A sentence.
    pub says: String,
}

impl Remark {
    /// Makes a remark that makes the decoder fail.
    #[must_use]
    pub fn failure(says: String) -> Remark {
        Remark {
            failure: true,
            says,
        }
    }

    /// Makes a remark for information.
    #[must_use]
    pub fn note(says: String) -> Remark {
        Remark {
            failure: false,
            says,
        }
    }
}
