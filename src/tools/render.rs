//! Images of a map: under one light, under many, or its surface normals.

use std::io::Cursor;

use image::codecs::jpeg::JpegEncoder;
use image::codecs::pnm::{PnmEncoder, PnmSubtype, SampleEncoding};
use image::{ExtendedColorType, ImageEncoder, ImageFormat, write_buffer_with_format};

use crate::evaluate::Coefficients;
use crate::ptm::{Ptm, Shape, Size};

/// An image of 8 bits per sample, top row first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Number of pixels in a row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Number of samples per pixel: 1 for gray, 3 for red, green and blue.
    pub channels: usize,
    /// `height * width * channels` samples.
    pub samples: Vec<u8>,
}

/// At this quality the encoder uses small steps and no chroma subsampling.
const JPEG_QUALITY: u8 = 95;
/// Number of pixels between the images of a contact sheet.
const MARGIN: usize = 4;
/// A gray that differs from black and white images.
const BACKGROUND: u8 = 48;
/// Maximum number of bytes of a contact sheet, or of an enlarged image.
const MAX_IMAGE_BYTES: usize = 1 << 30;
/// The radius of the lights at the edge of a contact sheet; at 1 they would be in the plane of the map.
const RIM_RADIUS: f64 = 0.9;

/// Returns the map under one light.
#[must_use]
pub fn lit(ptm: &Ptm, lu: f64, lv: f64) -> Image {
    picture(&ptm.coefficients(), lu, lv)
}

fn picture(coefficients: &Coefficients, lu: f64, lv: f64) -> Image {
    let samples = coefficients.evaluate(lu, lv).to_bytes();
    Image::rgb(coefficients.size, samples)
}

/// Returns images under `side` × `side` lights over the hemisphere, from the right on the right and from above at the top;
/// those at the edge have lights at `RIM_RADIUS`. Images larger than `cell` are reduced.
///
/// # Errors
/// If the sheet needs more than 1 GiB.
pub fn sheet(ptm: &Ptm, side: usize, cell: usize) -> Result<Image, String> {
    let coefficients = ptm.coefficients();
    let step = |at: usize| match side {
        1 => 0.0,
        _ => 2.0 * at as f64 / (side - 1) as f64 - 1.0,
    };
    let size = coefficients.size;
    let (width, height) = (size.width as usize, size.height as usize);
    let factor = width.max(height).div_ceil(cell.max(1));
    let (cell_width, cell_height) = (width.div_ceil(factor), height.div_ceil(factor));
    let place = |at: usize, length: usize| MARGIN + at * (length + MARGIN);
    let (width, height) = (place(side, cell_width), place(side, cell_height));
    let bytes = width.saturating_mul(height).saturating_mul(3);
    if bytes > MAX_IMAGE_BYTES {
        return Err(format!(
            "a sheet of {bytes} bytes is too large; request fewer or smaller images"
        ));
    }
    let mut sheet = Image {
        channels: 3,
        ..Image::gray(width, height, vec![BACKGROUND; bytes])
    };
    for row in 0..side {
        for column in 0..side {
            let (lu, lv) = square_to_disc(step(column), step(side - 1 - row));
            let small = picture(&coefficients, lu, lv).shrunk(factor);
            sheet.paste(&small, place(column, cell_width), place(row, cell_height));
        }
    }
    Ok(sheet)
}

/// Maps the square from −1 to 1 to the disc of the lights, its edge to the rim.
fn square_to_disc(x: f64, y: f64) -> (f64, f64) {
    (
        x * (1.0 - y * y / 2.0).sqrt() * RIM_RADIUS,
        y * (1.0 - x * x / 2.0).sqrt() * RIM_RADIUS,
    )
}

/// Returns the normals as colors: x, y and z from −1 to 1 as 0 to 255, x to the right, y up, z towards the viewer.
///
/// A normal points to the light under which its texel is brightest (Malzbender, Gelb and Wolters, SIGGRAPH 2001).
#[must_use]
pub fn normals(ptm: &Ptm) -> Image {
    let coefficients = ptm.coefficients();
    let channels = coefficients.shape.channels();
    let luminance = |texel: &[f64]| -> [f64; 6] {
        match coefficients.shape {
            Shape::Rgb => std::array::from_fn(|i| texel[i] + texel[6 + i] + texel[12 + i]),
            Shape::Lrgb | Shape::Lum(_) => std::array::from_fn(|i| texel[i]),
        }
    };
    let color = |texel: &[f64]| {
        normal(&luminance(texel)).map(|axis| (f64::midpoint(axis, 1.0) * 255.0).round() as u8)
    };
    let texels = coefficients.values.chunks(channels);
    Image::rgb(coefficients.size, texels.flat_map(color).collect())
}

/// Returns the direction of the light under which the polynomial is largest.
///
/// That is the point where its gradient is zero, if it has a maximum there within the hemisphere, and else a point on the rim.
/// Of several equally bright directions the one nearest to the zenith is taken; a flat polynomial has the zenith.
#[must_use]
pub fn normal(a: &[f64; 6]) -> [f64; 3] {
    let largest = a[..5].iter().map(|a| a.abs()).fold(0.0, f64::max);
    if largest == 0.0 {
        return [0.0, 0.0, 1.0];
    }
    // A slight preference for the zenith breaks ties.
    let (a0, a1, a2) = (a[0] - 1e-9 * largest, a[1] - 1e-9 * largest, a[2]);
    let determinant = 4.0 * a0 * a1 - a2 * a2;
    if a0 < 0.0 && determinant > 0.0 {
        let u = (a2 * a[4] - 2.0 * a1 * a[3]) / determinant;
        let v = (a2 * a[3] - 2.0 * a0 * a[4]) / determinant;
        if u.hypot(v) < 1.0 {
            return [u, v, (1.0 - u * u - v * v).sqrt()];
        }
    }
    let on_rim = |angle: f64| {
        let (v, u) = angle.sin_cos();
        a0 * u * u + a1 * v * v + a2 * u * v + a[3] * u + a[4] * v
    };
    let (v, u) = brightest_angle(&on_rim).sin_cos();
    [u, v, 0.0]
}

/// Returns the angle on the circle at which `brightness` is largest, by repeated refinement.
fn brightest_angle(brightness: &impl Fn(f64) -> f64) -> f64 {
    const STEPS: usize = 64;
    let mut step = std::f64::consts::TAU / STEPS as f64;
    let brighter = |best: f64, angle: f64| match brightness(angle) > brightness(best) {
        true => angle,
        false => best,
    };
    let mut best = (1..STEPS).map(|i| i as f64 * step).fold(0.0, brighter);
    for _ in 0..24 {
        step /= 2.0;
        best = [best - step, best + step].into_iter().fold(best, brighter);
    }
    best
}

impl Image {
    /// Returns an image of one sample per pixel.
    #[must_use]
    pub fn gray(width: usize, height: usize, samples: Vec<u8>) -> Image {
        let channels = 1;
        Image {
            width,
            height,
            channels,
            samples,
        }
    }

    /// Returns an image of three samples per pixel.
    #[must_use]
    pub fn rgb(size: Size, samples: Vec<u8>) -> Image {
        let (width, height) = (size.width as usize, size.height as usize);
        Image {
            channels: 3,
            ..Image::gray(width, height, samples)
        }
    }

    /// Returns a file of that format; JPEG has the quality that `check` accepts in answers.
    ///
    /// # Errors
    /// If the image is too large for the format.
    pub fn to_file(&self, format: ImageFormat) -> Result<Vec<u8>, String> {
        let side = |length: usize| u32::try_from(length).map_err(|_| "the image is too large");
        let (width, height) = (side(self.width)?, side(self.height)?);
        let color = match self.channels {
            1 => ExtendedColorType::L8,
            _ => ExtendedColorType::Rgb8,
        };
        // By default it would write the newer variant P7, which few programs read.
        let subtype = match self.channels {
            1 => PnmSubtype::Graymap(SampleEncoding::Binary),
            _ => PnmSubtype::Pixmap(SampleEncoding::Binary),
        };
        let (mut out, samples) = (Cursor::new(Vec::new()), &self.samples);
        let written = match format {
            ImageFormat::Pnm => PnmEncoder::new(&mut out)
                .with_subtype(subtype)
                .write_image(samples, width, height, color),
            ImageFormat::Jpeg => JpegEncoder::new_with_quality(&mut out, JPEG_QUALITY)
                .write_image(samples, width, height, color),
            _ => write_buffer_with_format(&mut out, samples, width, height, color, format),
        };
        written.map_err(|error| error.to_string())?;
        Ok(out.into_inner())
    }

    /// Returns every pixel as a square of `factor` × `factor`.
    ///
    /// # Errors
    /// If the image needs more than 1 GiB.
    pub fn enlarged(&self, factor: usize) -> Result<Image, String> {
        let area = factor.saturating_mul(factor);
        let bytes = self.samples.len().saturating_mul(area);
        if bytes > MAX_IMAGE_BYTES {
            return Err(format!(
                "an image of {bytes} bytes is too large; enlarge it less"
            ));
        }
        let row_bytes = (self.width * self.channels).max(1);
        let wide = |row: &[u8]| -> Vec<u8> {
            let pixels = row.chunks(self.channels);
            pixels.flat_map(|pixel| pixel.repeat(factor)).collect()
        };
        let rows = self.samples.chunks(row_bytes);
        Ok(Image {
            width: self.width * factor,
            height: self.height * factor,
            samples: rows.flat_map(|row| wide(row).repeat(factor)).collect(),
            ..*self
        })
    }

    /// Returns an image in which every pixel is the mean of `factor` × `factor` pixels, fewer at the right and bottom edges.
    fn shrunk(&self, factor: usize) -> Image {
        if factor <= 1 {
            return self.clone();
        }
        let (width, height) = (self.width.div_ceil(factor), self.height.div_ceil(factor));
        let mean = |i: usize| {
            let (pixel, channel) = (i / self.channels, i % self.channels);
            let (x, y) = (pixel % width * factor, pixel / width * factor);
            let (mut sum, mut count) = (0, 0);
            for row in y..(y + factor).min(self.height) {
                for column in x..(x + factor).min(self.width) {
                    let at = (row * self.width + column) * self.channels + channel;
                    sum += usize::from(self.samples[at]);
                    count += 1;
                }
            }
            ((sum + count / 2) / count) as u8
        };
        Image {
            width,
            height,
            samples: (0..width * height * self.channels).map(mean).collect(),
            ..*self
        }
    }

    fn paste(&mut self, small: &Image, x: usize, y: usize) {
        let row_bytes = small.width * small.channels;
        for (row, samples) in small.samples.chunks(row_bytes).enumerate() {
            let at = ((y + row) * self.width + x) * self.channels;
            self.samples[at..at + row_bytes].copy_from_slice(samples);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Polynomials and their normals. The first two have a summit: −(u − 0.3)² − (v + 0.4)² up to a constant, and with a
    /// mixed term −u² − v² + uv + 0.3u, highest at (0.2, 0.1). Then the rim: slopes, a summit below the horizon, and the
    /// saddle u² − v² + 0.1u, which is largest at the right. Where nothing decides, it is the zenith.
    const NORMALS: [([f64; 6], [f64; 3]); 8] = [
        ([-1.0, -1.0, 0.0, 0.6, -0.8, 7.0], [0.3, -0.4, 0.866_025_4]),
        ([-1.0, -1.0, 1.0, 0.3, 0.0, 0.0], [0.2, 0.1, 0.974_679_4]),
        ([0.0, 0.0, 0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ([0.0, 0.0, 0.0, 3.0, -4.0, 0.0], [0.6, -0.8, 0.0]),
        ([-1.0, -1.0, 0.0, 0.0, 4.0, 0.0], [0.0, 1.0, 0.0]),
        ([1.0, -1.0, 0.0, 0.1, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ([0.0, 0.0, 0.0, 0.0, 0.0, 9.0], [0.0, 0.0, 1.0]),
        ([-5.0, 0.0, 0.0, 0.0, 0.0, 9.0], [0.0, 0.0, 1.0]),
    ];

    #[test]
    fn normal_points_to_the_brightest_light() {
        for (polynomial, expected) in NORMALS {
            let found = normal(&polynomial);
            let mut pairs = found.iter().zip(expected);
            assert!(
                pairs.all(|(a, b)| (a - b).abs() < 1e-6),
                "{found:?}, expected {expected:?}"
            );
        }
    }

    #[test]
    fn outer_images_of_a_sheet_are_lit_from_the_rim() {
        for (x, y) in [(1.0, 0.0), (1.0, 1.0), (-0.5, 1.0), (1.0, -0.25)] {
            let (lu, lv) = square_to_disc(x, y);
            assert!((lu.hypot(lv) - RIM_RADIUS).abs() < 1e-9, "{x}, {y}");
        }
        assert_eq!(square_to_disc(0.0, 0.0), (0.0, 0.0));
    }

    #[test]
    fn image_is_encoded_in_every_file_format() {
        use ImageFormat::{Bmp, Jpeg, Png, Tiff, WebP};
        let image = Image::rgb("1x1".parse().expect("a size"), vec![7, 7, 7]);
        let file = |format| image.to_file(format).expect("a small picture");
        assert_eq!(file(ImageFormat::Pnm), b"P6\n1 1 255\n\x07\x07\x07");
        for format in [Png, Tiff, Bmp, WebP, Jpeg] {
            let read = image::load_from_memory_with_format(&file(format), format);
            let read = read.expect("a picture").into_rgb8();
            assert_eq!(read.into_raw(), [7, 7, 7], "{format:?}");
        }
    }

    #[test]
    fn enlarging_repeats_and_shrinking_averages_pixels() {
        let image = Image::gray(3, 2, vec![10, 20, 31, 30, 41, 33]);
        assert_eq!(image.shrunk(2), Image::gray(2, 1, vec![25, 32]));
        let image = Image::gray(2, 2, vec![1, 2, 3, 4]);
        let samples = vec![1, 1, 2, 2, 1, 1, 2, 2, 3, 3, 4, 4, 3, 3, 4, 4];
        assert_eq!(image.enlarged(2), Ok(Image::gray(4, 4, samples)));
        assert!(image.enlarged(usize::MAX).is_err());
    }
}
