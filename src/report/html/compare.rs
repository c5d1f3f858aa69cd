//! Colored images next to each other: expected, received, and their difference. The page's script adds an image with a movable
//! border: expected to its left, received to its right.

use data_encoding::BASE64;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use maud::{Markup, html};

/// The longest side on the page, in CSS pixels.
const MAX_SIDE_PIXELS: usize = 208;

/// Two images of the same size, three bytes per texel.
pub(super) struct Compared<'a> {
    pub width: usize,
    pub height: usize,
    pub expected: &'a [u8],
    pub received: &'a [u8],
    /// The difference of each texel, four bytes per texel.
    pub difference: Option<&'a [u8]>,
}

impl Compared<'_> {
    /// Returns the images; `subject` is the name of the received one.
    pub(super) fn markup(&self, subject: &str) -> Markup {
        let opaque = |rgb: &[u8]| -> Vec<u8> {
            let texels = rgb.as_chunks().0.iter();
            texels.flat_map(|&[r, g, b]| [r, g, b, 255]).collect()
        };
        html! {
            div.compare {
                (self.picture("expected", "expected", &opaque(self.expected)))
                (self.picture("received", subject, &opaque(self.received)))
                @if let Some(difference) = self.difference { (self.picture("difference", "difference", difference)) }
            }
        }
    }

    fn picture(&self, role: &str, name: &str, rgba: &[u8]) -> Markup {
        let scale = (MAX_SIDE_PIXELS / self.width.max(self.height)).max(1);
        html! {
            div.picture data-role=(role) {
                img width=(self.width * scale) height=(self.height * scale) alt=(name) src=(png(self.width, self.height, rgba));
                span { (name) }
            }
        }
    }
}

/// Returns an image of four bytes per texel as a data URL.
pub(super) fn png(width: usize, height: usize, rgba: &[u8]) -> String {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive)
        .write_image(rgba, width as u32, height as u32, ExtendedColorType::Rgba8)
        .expect("there are four bytes for each pixel");
    format!("data:image/png;base64,{}", BASE64.encode(&bytes))
}
