//! Parses a response: a PTM1 frame, an image or a NumPy array, which are distinguished by their first bytes.
//!
//! Programs that do not speak the protocol write images, which become frames of the view `rgb`. An array does not name its view,
//! so the requested view is assumed. A response in any form must be complete, and no bytes may follow it.

use super::{image_file, npy};
use crate::error::{Error, Result};
use crate::protocol::frame::{Frame, View};

/// Parses `bytes`, the complete response to a request for `view`. Decompresses at most `max_bytes` bytes.
///
/// # Errors
/// Returns the reason why `bytes` is not a valid response.
pub fn read(bytes: &[u8], view: &View, max_bytes: usize) -> Result<Frame> {
    if bytes.starts_with(b"\x93NUMPY") {
        npy::read(bytes, view.kind()).map_err(|error| error.in_place("a NumPy array"))
    } else if let Some(image) = image_file::read(bytes, max_bytes) {
        image
    } else if let Some(form) = unsupported_form(bytes) {
        Error::invalid(format!(
            "{form}; an image is a PNG, PNM, TIFF, BMP, WebP or JPEG file, or a PTM1 line followed by samples"
        ))
    } else {
        Frame::read(bytes)
    }
}

/// Recognizes an unsupported file format by the first bytes of the file, and returns the name of the format.
fn unsupported_form(bytes: &[u8]) -> Option<&'static str> {
    let forms: [(&[u8], &str); 2] = [(b"GIF8", "a GIF image"), (b"PTM_1.", "the PTM file itself")];
    forms
        .into_iter()
        .find(|(first, _)| bytes.starts_with(first))
        .map(|(_, form)| form)
}
