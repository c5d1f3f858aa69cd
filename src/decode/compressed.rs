//! §2.9 Compressed Data
//!
//! Not read yet: the four compressed formats are refused as unsupported.

use super::Input;
use crate::error::{Error, Kind, Result};
use crate::ptm::Planes;

pub(super) fn read(input: &Input) -> Result<Planes> {
    Err(Error::new(
        "2.9/1",
        input.at(),
        Kind::NotRead {
            what: "compressed planes",
        },
    ))
}
