//! Maps as embedded images: small PNGs, shown enlarged with hard edges.

use data_encoding::BASE64;
use image::{
    DynamicImage, GenericImageView, GrayImage, ImageBuffer, ImageFormat, Luma, Pixel, RgbImage,
    imageops,
};
use maud::{Markup, html};

use crate::evaluate::Coefficients;
use crate::protocol::frame::{Frame, Samples, ViewKind};
use crate::tools::render::{lit, to_file};

/// The longest side of an image on the page, in CSS pixels.
const SHOWN: u32 = 224;
/// Maximum side of an image in texels; of larger maps every second, third … texel is shown.
const MAX_SIDE: u32 = 128;
/// The gray between two planes.
const BETWEEN: Luma<u8> = Luma([128]);

/// Renders a map under a light.
pub(super) fn of_map(map: &Coefficients, (lu, lv): (f64, f64), says: &str) -> Markup {
    picture(thinned(&lit(map, lu, lv)), says)
}

/// Returns the image of a frame: colors as they are, other views as planes side by side.
pub(super) fn from_frame(frame: &Frame, says: &str) -> Option<Markup> {
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
        return Some(picture(thinned(&image), says));
    }
    let plane = |channel: u32| {
        let samples = samples.iter().skip(channel as usize);
        let samples = samples.step_by(channels as usize).copied().collect();
        Some(thinned(&GrayImage::from_raw(width, height, samples)?))
    };
    let planes: Vec<GrayImage> = (0..channels).map(plane).collect::<Option<_>>()?;
    let (each, height) = planes[0].dimensions();
    let mut joined = GrayImage::from_pixel(channels * (each + 1) - 1, height, BETWEEN);
    for (plane, x) in planes.iter().zip((0..).step_by(each as usize + 1)) {
        imageops::replace(&mut joined, plane, x, 0);
    }
    Some(picture(joined, says))
}

/// Returns every second, third … texel of a large image.
fn thinned<P: Pixel<Subpixel = u8>>(image: &ImageBuffer<P, Vec<u8>>) -> ImageBuffer<P, Vec<u8>> {
    let (width, height) = image.dimensions();
    let step = width.max(height).div_ceil(MAX_SIDE);
    let texel = |x, y| *image.get_pixel(x * step, y * step);
    ImageBuffer::from_fn(width.div_ceil(step), height.div_ceil(step), texel)
}

fn picture(image: impl Into<DynamicImage>, says: &str) -> Markup {
    let image = image.into();
    let (width, height) = image.dimensions();
    let scale = (SHOWN / width.max(height)).max(1);
    let png = to_file(image, ImageFormat::Png).expect("a thinned picture is small");
    html! {
        img.texels width=(width * scale) height=(height * scale) alt=(says)
            src={ "data:image/png;base64," (BASE64.encode(&png)) };
    }
}
