//! Remarks on a run as a whole.

use serde::{Deserialize, Serialize};

/// A remark on a run as a whole.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Remark {
    /// True if the remark counts as a failure of the decoder.
    pub failure: bool,
    /// The text of the remark, as a sentence.
    #[serde(rename = "says")]
    pub message: String,
}

impl Remark {
    /// Creates a remark that counts as a failure of the decoder.
    #[must_use]
    pub fn failure(message: String) -> Remark {
        Remark {
            failure: true,
            message,
        }
    }

    /// Creates an informational remark.
    #[must_use]
    pub fn note(message: String) -> Remark {
        Remark {
            failure: false,
            message,
        }
    }
}
