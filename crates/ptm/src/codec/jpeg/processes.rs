//! T.81 Table B.1: the markers of the other coding processes
//!
//! An unexpected marker is either an error in the stream or a sign of a process that T.81 defines but this decoder
//! does not support. The frame header identifies the process:
//!
//! ```text
//! SOF      Huffman  arithmetic
//!          C0 C1    C9            sequential (baseline C0)
//!          C2       CA            progressive
//!          C3       CB            lossless
//!          C5 – C7  CD – CF       hierarchical, with DHP (DE) and EXP (DF)
//! ```
//!
//! Format notes
//! - C4 and C8 are not frame headers: C4 is DHT, and C8 is reserved. CC (DAC) defines arithmetic coding conditions.

use crate::codec::markers::{DNL, Marker};
use crate::codec::stream_error::{StreamError, malformed, unsupported};

pub(super) fn unexpected_marker(marker: Marker, expected: &str) -> StreamError {
    let process = match marker.code {
        0xC2 => "progressive coding",
        0xC3 => "lossless coding",
        0xC5..=0xC7 | 0xCD..=0xCF | 0xDE | 0xDF => "hierarchical coding",
        0xC9..=0xCC => "arithmetic coding",
        DNL => "a height defined by DNL",
        0xF7 => {
            let what = format!("expected {expected}, found a JPEG-LS frame");
            return malformed(marker.at, what);
        }
        _ => return malformed(marker.at, format!("expected {expected}, found {marker}")),
    };
    let what = format!("{process} ({marker}) is not implemented");
    unsupported(marker.at, what)
}
