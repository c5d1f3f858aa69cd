//! Color images side by side: the expected one, the received one, and the difference between the two. The script of the page adds
//! a third image with a movable divider: expected on the left, received on the right.

use std::io::Cursor;

use data_encoding::BASE64;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use maud::{Markup, html};

/// Maximum side length of a displayed image, in CSS pixels.
const MAX_SIDE_PIXELS: usize = 208;

/// Expected and received images of the same size, with three bytes per texel.
pub(super) struct ComparedImages<'a> {
    pub width: usize,
    pub height: usize,
    pub expected: &'a [u8],
    pub received: &'a [u8],
    /// Difference image, with four bytes per texel.
    pub difference: Option<&'a [u8]>,
}

impl ComparedImages<'_> {
    /// Renders the images. `subject` is the caption of the received image.
    pub(super) fn markup(&self, subject: &str) -> Markup {
        let opaque = |rgb: &[u8]| -> Vec<u8> {
            let texels = rgb.as_chunks().0.iter();
            texels.flat_map(|&[r, g, b]| [r, g, b, 255]).collect()
        };
        html! {
            div.compare {
                (self.render_image("expected", "expected", &opaque(self.expected)))
                (self.render_image("received", subject, &opaque(self.received)))
                @if let Some(difference) = self.difference { (self.render_image("difference", "difference", difference)) }
            }
        }
    }

    fn render_image(&self, role: &str, name: &str, rgba: &[u8]) -> Markup {
        let scale = (MAX_SIDE_PIXELS / self.width.max(self.height)).max(1);
        html! {
            div.picture data-role=(role) {
                img width=(self.width * scale) height=(self.height * scale) alt=(name) src=(png_data_url(self.width, self.height, rgba));
                span { (name) }
            }
        }
    }
}

pub(super) fn png_data_url(width: usize, height: usize, rgba: &[u8]) -> String {
    // The encoder has the same type as in `tools::render`, so that it is compiled only once.
    let mut png = Cursor::new(Vec::new());
    PngEncoder::new_with_quality(&mut png, CompressionType::Best, FilterType::Adaptive)
        .write_image(rgba, width as u32, height as u32, ExtendedColorType::Rgba8)
        .expect("there are four bytes for each pixel");
    format!("data:image/png;base64,{}", BASE64.encode(png.get_ref()))
}
