//! Something to say of a run as a whole.

use serde::{Deserialize, Serialize};

/// Something to say of a run as a whole.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Remark {
    /// Whether the decoder fails because of it.
    pub failure: bool,
    /// A sentence.
    pub says: String,
}

impl Remark {
    /// A reason to fail.
    #[must_use]
    pub fn failure(says: String) -> Remark {
        Remark {
            failure: true,
            says,
        }
    }

    /// Something to know.
    #[must_use]
    pub fn note(says: String) -> Remark {
        Remark {
            failure: false,
            says,
        }
    }
}
