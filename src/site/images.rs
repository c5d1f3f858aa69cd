//! Embedded images of maps: small PNGs that are enlarged with hard edges when they are displayed.

use data_encoding::BASE64;
use image::{DynamicImage, GenericImageView, GrayImage, ImageBuffer, ImageFormat, imageops};
use image::{Luma, Pixel, RgbImage};
use maud::{Markup, html};

use ptm::evaluate::Coefficients;
use ptm_files::render::{encode_image, render_lit};
use ptm_suite::protocol::frame::{Frame, Samples, ViewKind};

/// Maximum side length of a displayed image, in CSS pixels.
const MAX_DISPLAYED_SIDE: u32 = 224;
/// Maximum side length of an image in texels. Larger images are subsampled.
const MAX_SIDE: u32 = 128;
/// Gray level of the separator between two planes.
const SEPARATOR_GRAY: Luma<u8> = Luma([128]);

/// Renders a map under a light as an embedded image. `alt` is the alternative text.
pub(super) fn render_map(map: &Coefficients, (lu, lv): (f64, f64), alt: &str) -> Markup {
    embed_image(&subsample(&render_lit(map, lu, lv)).into(), alt)
}

/// Renders a frame as an embedded image: colors directly, and other views as planes side by side.
pub(super) fn render_frame(frame: &Frame, alt: &str) -> Option<Markup> {
    let (width, height, channels) = (frame.width, frame.height, frame.channels);
    let Samples::U8(samples) = &frame.samples else {
        return None;
    };
    let count = width as usize * height as usize * channels as usize;
    if samples.len() != count || samples.is_empty() {
        return None;
    }
    if frame.view == ViewKind::Rgb {
        let image = RgbImage::from_raw(width, height, samples.clone())?;
        return Some(embed_image(&subsample(&image).into(), alt));
    }
    let plane = |channel: u32| {
        let samples = samples.iter().skip(channel as usize);
        let samples = samples.step_by(channels as usize).copied().collect();
        Some(subsample(&GrayImage::from_raw(width, height, samples)?))
    };
    let planes: Vec<GrayImage> = (0..channels).map(plane).collect::<Option<_>>()?;
    let (side, height) = planes[0].dimensions();
    let mut joined = GrayImage::from_pixel(channels * (side + 1) - 1, height, SEPARATOR_GRAY);
    for (plane, x) in planes.iter().zip((0..).step_by(side as usize + 1)) {
        imageops::replace(&mut joined, plane, x, 0);
    }
    Some(embed_image(&joined.into(), alt))
}

/// Subsamples an image whose sides exceed [`MAX_SIDE`].
fn subsample<P: Pixel<Subpixel = u8>>(image: &ImageBuffer<P, Vec<u8>>) -> ImageBuffer<P, Vec<u8>> {
    let (width, height) = image.dimensions();
    let step = width.max(height).div_ceil(MAX_SIDE);
    let texel = |x, y| *image.get_pixel(x * step, y * step);
    ImageBuffer::from_fn(width.div_ceil(step), height.div_ceil(step), texel)
}

fn embed_image(image: &DynamicImage, alt: &str) -> Markup {
    let (width, height) = image.dimensions();
    let scale = (MAX_DISPLAYED_SIDE / width.max(height)).max(1);
    let png = encode_image(image, ImageFormat::Png).expect("the image is small enough to encode");
    html! {
        img.texels width=(width * scale) height=(height * scale) alt=(alt)
            src={ "data:image/png;base64," (BASE64.encode(&png)) };
    }
}
