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
    const FORMS: [(&[u8], &str); 22] = [
        (b"PTM_1.", "the PTM file itself"),
        (b"GIF8", "a GIF image"),
        (b"\x76\x2f\x31\x01", "an OpenEXR image"),
        (b"II+\0", "a BigTIFF image"),
        (b"MM\0+", "a BigTIFF image"),
        (b"PF\n", "a PFM image"),
        (b"Pf\n", "a PFM image"),
        (b"\xff\x0a", "a JPEG XL image"),
        (b"\0\0\0\x0cJXL ", "a JPEG XL image"),
        (b"\0\0\0\x0cjP  ", "a JPEG 2000 image"),
        (b"\xff\x4f\xff\x51", "a JPEG 2000 image"),
        (b"qoif", "a QOI image"),
        (b"#?", "a Radiance image"),
        (b"\0\0\x01\0", "an icon (ICO)"),
        (b"farbfeld", "a farbfeld image"),
        (b"DDS ", "a DDS texture"),
        (b"8BPS", "a Photoshop image"),
        (b"PK\x03\x04", "a ZIP archive or an NPZ file"),
        (b"%PDF", "a PDF document"),
        (b"<svg", "an SVG image"),
        (b"<?xml", "an XML or SVG document"),
        (b"<!DOCTYPE", "an HTML document"),
    ];
    let mut forms = FORMS.iter();
    if let Some((_, form)) = forms.find(|(first, _)| bytes.starts_with(first)) {
        return Some(form);
    }
    // Four bytes of length precede the brand of a HEIF file, and a TGA file may end with a signature.
    match bytes.get(4..12) {
        Some(b"ftypavif" | b"ftypavis") => Some("an AVIF image"),
        Some([b'f', b't', b'y', b'p', ..]) => Some("a HEIF image or a film"),
        _ if bytes.ends_with(b"TRUEVISION-XFILE.\0") => Some("a TGA image"),
        _ => None,
    }
}
