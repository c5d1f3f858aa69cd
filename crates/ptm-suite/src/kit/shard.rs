//! Parts of a suite or of a collection, for several machines.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// A part of a set of names, written as `3/8` for the third of eight parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Number of the part, starting at 1.
    pub number: u32,
    /// Total number of parts.
    #[serde(rename = "of")]
    pub total: u32,
}

impl Shard {
    /// Returns true if this part contains `name`. Adding names does not move existing ones to other parts, because the part depends
    /// only on the name.
    #[must_use]
    pub fn contains(self, name: &[u8]) -> bool {
        let digest = Sha256::digest(name);
        let first = u64::from_be_bytes(digest[..8].try_into().expect("eight bytes"));
        first % u64::from(self.total) == u64::from(self.number - 1)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Shard, String> {
        let wrong = || format!("expected a part such as 3/8, found {text:?}");
        let (number, of) = text.split_once('/').ok_or_else(wrong)?;
        match (number.parse(), of.parse()) {
            (Ok(number), Ok(total)) if (1..=total).contains(&number) => Ok(Shard { number, total }),
            _ => Err(wrong()),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.total)
    }
}
