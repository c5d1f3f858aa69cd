//! One answer, in whatever form it comes: a PTM1 frame, a picture or a NumPy array, distinguished by its first bytes.
//!
//! Programs that nobody will change write pictures; those become frames of the view `rgb`. An array says nothing of its
//! view, so it is one of the view that was asked for. Whatever the form, there is exactly one of it, whole, with nothing
//! after it.

use super::{npy, picture};
use crate::protocol::frame::{Frame, View};

/// Reads the one answer that `bytes` are, to a request for `view`. Nothing above `most` bytes is unpacked.
///
/// # Errors
/// A sentence that says what keeps `bytes` from being one.
pub fn read(bytes: &[u8], view: &View, most: usize) -> Result<Frame, String> {
    if bytes.starts_with(b"\x93NUMPY") {
        npy::read(bytes, view.kind()).map_err(|error| format!("a NumPy array: {error}"))
    } else if let Some(picture) = picture::read(bytes, most) {
        picture
    } else if let Some(form) = known_but_not_read(bytes) {
        Err(format!(
            "{form}; a picture is a PNG, PNM, TIFF, BMP, WebP or JPEG, or a PTM1 line and samples"
        ))
    } else {
        Frame::read(bytes)
    }
}

/// Forms that are known by their first bytes and are no answers.
fn known_but_not_read(bytes: &[u8]) -> Option<&'static str> {
    let forms: [(&[u8], &str); 2] = [
        (b"GIF8", "a GIF picture"),
        (b"PTM_1.", "the PTM file itself"),
    ];
    forms
        .into_iter()
        .find(|(first, _)| bytes.starts_with(first))
        .map(|(_, form)| form)
}
