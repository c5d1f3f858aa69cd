//! Maps as embedded images: small PNGs, shown enlarged with hard edges.

use data_encoding::BASE64;
use image::ImageFormat;
use maud::{Markup, html};

use crate::evaluate::Coefficients;
use crate::protocol::frame::{Frame, Samples, ViewKind};
use crate::ptm::Ptm;
use crate::tools::render::{Image, lit};

/// The longest side of an image on the page, in CSS pixels.
const SHOWN: usize = 224;
/// Maximum side of an image in texels; of larger maps every second, third … texel is shown.
const MAX_SIDE: usize = 128;

/// Renders a map under a light.
pub(super) fn of_map(ptm: &Ptm, (lu, lv): (f64, f64), says: &str) -> Markup {
    picture(&thinned(lit(ptm, lu, lv)), says)
}

/// Renders coefficients under a light.
pub(super) fn of_coefficients(map: &Coefficients, (lu, lv): (f64, f64), says: &str) -> Markup {
    let samples = map.evaluate(lu, lv).to_bytes();
    picture(&Image::rgb(map.size, samples), says)
}

/// Returns the image of a frame: colors as they are, other views as planes side by side.
pub(super) fn from_frame(frame: &Frame, says: &str) -> Option<Markup> {
    let (width, height) = (frame.width as usize, frame.height as usize);
    let channels = frame.channels as usize;
    let Samples::U8(samples) = &frame.samples else {
        return None;
    };
    if samples.len() != width * height * channels || samples.is_empty() {
        return None;
    }
    if frame.view == ViewKind::Rgb {
        let image = Image {
            channels,
            ..Image::gray(width, height, samples.clone())
        };
        return Some(picture(&thinned(image), says));
    }
    let plane = |channel: usize| {
        let samples = samples.iter().skip(channel).step_by(channels).copied();
        thinned(Image::gray(width, height, samples.collect()))
    };
    let planes: Vec<Image> = (0..channels).map(plane).collect();
    Some(picture(&join_images(&planes), says))
}

/// Joins gray images side by side, separated by a column.
fn join_images(planes: &[Image]) -> Image {
    const BETWEEN: u8 = 128;
    let (each, height) = (planes[0].width, planes[0].height);
    let mut samples = Vec::new();
    for y in 0..height {
        for (i, plane) in planes.iter().enumerate() {
            if i > 0 {
                samples.push(BETWEEN);
            }
            samples.extend(&plane.samples[y * each..(y + 1) * each]);
        }
    }
    Image::gray(planes.len() * (each + 1) - 1, height, samples)
}

fn thinned(image: Image) -> Image {
    let step = image.width.max(image.height).div_ceil(MAX_SIDE);
    if step <= 1 {
        return image;
    }
    let (width, height) = (image.width.div_ceil(step), image.height.div_ceil(step));
    let texel = |x: usize, y: usize| (y * step * image.width + x * step) * image.channels;
    let places = (0..width * height).map(|i| texel(i % width, i / width));
    let samples = places.flat_map(|at| &image.samples[at..at + image.channels]);
    Image {
        channels: image.channels,
        ..Image::gray(width, height, samples.copied().collect())
    }
}

fn picture(image: &Image, says: &str) -> Markup {
    let scale = (SHOWN / image.width.max(image.height)).max(1);
    let png = image
        .to_file(ImageFormat::Png)
        .expect("a thinned picture is small");
    html! {
        img.texels width=(image.width * scale) height=(image.height * scale) alt=(says)
            src={ "data:image/png;base64," (BASE64.encode(&png)) };
    }
}
