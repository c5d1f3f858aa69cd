//! Renders a map under one light, under many lights, or as surface normals.

use std::io::Cursor;

use image::codecs::jpeg::JpegEncoder;
use image::codecs::pnm::{PnmEncoder, PnmSubtype, SampleEncoding};
use image::{DynamicImage, GenericImageView, ImageFormat, Rgb, RgbImage, imageops};

use tiff::TiffResult;
use tiff::encoder::{Rational, TiffEncoder};
use tiff::tags::Tag;

use crate::error::{Error, Result};
use ptm::evaluate::Coefficients;
use ptm::{Planes, Ptm, Shape, Size};

/// JPEG quality at which the encoder uses small quantization steps and no chroma subsampling.
const JPEG_QUALITY: u8 = 95;
/// Number of pixels between the images of a sheet.
const MARGIN: u32 = 4;
/// Gray background, which is distinguishable from black and white images.
pub(crate) const BACKGROUND: Rgb<u8> = Rgb([48; 3]);
/// Maximum size in bytes of a sheet or an enlarged image.
pub(crate) const MAX_IMAGE_BYTES: u64 = 1 << 30;
/// Radius of the light directions at the edge of a sheet. At 1, the lights would be in the plane of the map.
const RIM_RADIUS: f64 = 0.9;
/// Light of thumbnails and of a page when it opens, from the upper left.
pub const LIGHT: (f64, f64) = (-0.4, 0.4);

/// Renders a map under one light.
#[must_use]
pub fn render_lit(coefficients: &Coefficients, lu: f64, lv: f64) -> RgbImage {
    rgb(coefficients.size, coefficients.evaluate(lu, lv).to_bytes())
}

/// Renders a sheet of images under `side` × `side` lights that cover the hemisphere. The position of an image corresponds
/// to the direction of its light; at the edge, lights are at `RIM_RADIUS`. Images larger than `cell` are downscaled.
///
/// # Errors
/// Returns an error if the sheet is larger than 1 GiB.
pub fn sheet(ptm: &Ptm, side: u32, cell: u32) -> Result<RgbImage> {
    let coefficients = ptm.coefficients();
    let step = |i: u32| match side {
        1 => 0.0,
        _ => 2.0 * f64::from(i) / f64::from(side - 1) - 1.0,
    };
    let Size { width, height } = coefficients.size;
    let factor = width.max(height).div_ceil(cell.max(1));
    let offset = |i: u32, length: u32| MARGIN + i * (length.div_ceil(factor) + MARGIN);
    let (sheet_width, sheet_height) = (offset(side, width), offset(side, height));
    let bytes = 3 * u64::from(sheet_width) * u64::from(sheet_height);
    if bytes > MAX_IMAGE_BYTES {
        return Error::impossible(format!(
            "a sheet of {bytes} bytes is too large; request fewer or smaller images"
        ));
    }
    let mut sheet = RgbImage::from_pixel(sheet_width, sheet_height, BACKGROUND);
    for row in 0..side {
        for column in 0..side {
            let (lu, lv) = square_to_disc(step(column), step(side - 1 - row));
            let small = downscale(&render_lit(&coefficients, lu, lv), factor);
            let (x, y) = (offset(column, width), offset(row, height));
            imageops::replace(&mut sheet, &small, x.into(), y.into());
        }
    }
    Ok(sheet)
}

/// Renders a thumbnail whose longer side has `side` pixels; that of a smaller map is enlarged by a whole number and may be shorter.
/// Of a large map, only the texels that the thumbnail needs are evaluated.
#[must_use]
pub fn thumbnail(ptm: &Ptm, side: u32) -> RgbImage {
    let Size { width, height } = ptm.planes.size;
    let thin = thin_out(ptm, (width.max(height) / (2 * side)).max(1));
    let image = render_lit(&thin.coefficients(), LIGHT.0, LIGHT.1);
    let Size { width, height } = thin.planes.size;
    let longest = width.max(height);
    if longest <= side {
        // A thumbnail that is too large to be enlarged does not fit on a sheet either.
        return upscale(&image, side / longest).unwrap_or(image);
    }
    let scaled = |length: u32| {
        let scaled = u64::from(length) * u64::from(side) / u64::from(longest);
        (scaled as u32).max(1)
    };
    imageops::thumbnail(&image, scaled(width), scaled(height))
}

/// Maps the square from −1 to 1 to the disc of light directions. The edge is mapped to `RIM_RADIUS`.
fn square_to_disc(x: f64, y: f64) -> (f64, f64) {
    let on_disc = |a: f64, b: f64| a * (1.0 - b * b / 2.0).sqrt() * RIM_RADIUS;
    (on_disc(x, y), on_disc(y, x))
}

/// Renders the normals as colors: x, y and z from −1 to 1 become 0 to 255. x points right, y up, and z toward the viewer.
///
/// The normal of a texel is the light direction under which the texel is brightest (Malzbender, Gelb and Wolters, SIGGRAPH 2001).
#[must_use]
pub fn normals(ptm: &Ptm) -> RgbImage {
    let coefficients = ptm.coefficients();
    let channels = coefficients.shape.channels();
    let color = |texel: &[f64]| {
        let luminance = std::array::from_fn(|i| match coefficients.shape {
            Shape::Rgb => texel[i] + texel[6 + i] + texel[12 + i],
            Shape::Lrgb | Shape::Lum(_) => texel[i],
        });
        normal(&luminance).map(|axis| (f64::midpoint(axis, 1.0) * 255.0).round() as u8)
    };
    let texels = coefficients.values.chunks(channels);
    rgb(coefficients.size, texels.flat_map(color).collect())
}

/// Returns the light direction at which the polynomial is largest.
///
/// This is the point with zero gradient if it is a maximum within the hemisphere, or else a point on the rim. If several
/// directions are equally bright, returns the one nearest to the zenith. For a constant polynomial, this is the zenith.
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

/// Finds the angle on the circle at which `brightness` is largest, by repeated refinement.
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

/// Creates an image from three samples per pixel.
///
/// # Panics
/// Panics if the number of samples does not match the size.
#[must_use]
pub fn rgb(size: Size, samples: Vec<u8>) -> RgbImage {
    let image = RgbImage::from_raw(size.width, size.height, samples);
    image.expect("three samples per pixel")
}

/// Encodes an image in the given file format. JPEG files use `JPEG_QUALITY`.
///
/// # Errors
/// Returns an error if the image is too large for the format.
pub fn encode_image(image: &DynamicImage, kind: ImageFormat) -> Result<Vec<u8>> {
    let mut out = Cursor::new(Vec::new());
    let result = match kind {
        ImageFormat::Pnm => {
            // The default is the newer variant P7, which few programs read.
            let subtype = match image {
                DynamicImage::ImageLuma8(_) => PnmSubtype::Graymap(SampleEncoding::Binary),
                _ => PnmSubtype::Pixmap(SampleEncoding::Binary),
            };
            image.write_with_encoder(PnmEncoder::new(&mut out).with_subtype(subtype))
        }
        ImageFormat::Jpeg => {
            image.write_with_encoder(JpegEncoder::new_with_quality(&mut out, JPEG_QUALITY))
        }
        ImageFormat::Tiff => {
            return encode_tiff(&image.to_rgb8()).map_err(|error| error.to_string().into());
        }
        _ => image.write_to(&mut out, kind),
    };
    result.map_err(|error| error.to_string())?;
    Ok(out.into_inner())
}

/// Encodes an uncompressed TIFF in one strip. The encoder of the `image` crate would add a predictor, which belongs to compressed
/// images only; libtiff warns about it.
fn encode_tiff(image: &RgbImage) -> TiffResult<Vec<u8>> {
    let mut out = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut out)?;
    let mut directory = encoder.image_directory()?;
    let samples = &image.as_raw()[..];
    let offset = directory.write_data(samples)? as u32;
    directory.write_tag(Tag::ImageWidth, image.width())?;
    directory.write_tag(Tag::ImageLength, image.height())?;
    directory.write_tag(Tag::BitsPerSample, &[8_u16, 8, 8][..])?;
    directory.write_tag(Tag::Compression, 1_u16)?;
    directory.write_tag(Tag::PhotometricInterpretation, 2_u16)?;
    directory.write_tag(Tag::StripOffsets, offset)?;
    directory.write_tag(Tag::SamplesPerPixel, 3_u16)?;
    directory.write_tag(Tag::RowsPerStrip, image.height())?;
    directory.write_tag(Tag::StripByteCounts, samples.len() as u32)?;
    directory.write_tag(Tag::XResolution, Rational { n: 72, d: 1 })?;
    directory.write_tag(Tag::YResolution, Rational { n: 72, d: 1 })?;
    directory.write_tag(Tag::ResolutionUnit, 2_u16)?;
    directory.finish()?;
    Ok(out.into_inner())
}

/// Enlarges an image: every pixel becomes a square of `factor` × `factor` pixels.
///
/// # Errors
/// Returns an error if the image is larger than 1 GiB.
pub fn upscale(image: &RgbImage, factor: u32) -> Result<RgbImage> {
    let area = u64::from(factor) * u64::from(factor);
    let bytes = area.saturating_mul(image.len() as u64);
    if bytes > MAX_IMAGE_BYTES {
        let hint = "request a smaller factor";
        return Error::impossible(format!("an image of {bytes} bytes is too large; {hint}"));
    }
    let (width, height) = (image.width() * factor, image.height() * factor);
    let pixel = |x, y| *image.get_pixel(x / factor, y / factor);
    Ok(RgbImage::from_fn(width, height, pixel))
}

/// Downscales an image. Every pixel is the mean of `factor` × `factor` pixels, or of fewer at the right and bottom edges.
fn downscale(image: &RgbImage, factor: u32) -> RgbImage {
    let (width, height) = image.dimensions();
    RgbImage::from_fn(width.div_ceil(factor), height.div_ceil(factor), |x, y| {
        let (x, y) = (x * factor, y * factor);
        let block = image.view(x, y, factor.min(width - x), factor.min(height - y));
        let count = block.pixels().count();
        Rgb([0, 1, 2].map(|channel| {
            let value = |(_, _, pixel): (u32, u32, Rgb<u8>)| usize::from(pixel[channel]);
            let sum: usize = block.pixels().map(value).sum();
            ((sum + count / 2) / count) as u8
        }))
    })
}

/// Returns a map with every n-th row and column. `step` is n, at least 1.
#[must_use]
pub fn thin_out(ptm: &Ptm, step: u32) -> Ptm {
    let (Size { width, height }, channels) = (ptm.planes.size, ptm.planes.shape.channels());
    let row_length = width as usize * channels;
    let rows = ptm.planes.samples.chunks(row_length).step_by(step as usize);
    let texels = rows.flat_map(|row| row.chunks(channels).step_by(step as usize));
    let samples = texels.flatten().copied().collect();
    let size = Size {
        width: width.div_ceil(step),
        height: height.div_ceil(step),
    };
    Ptm {
        header: ptm.header,
        planes: Planes {
            size,
            shape: ptm.planes.shape,
            samples,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayImage, Luma};

    /// Polynomials and their normals. The first two have a maximum inside the disc: −(u − 0.3)² − (v + 0.4)² up to a constant,
    /// and −u² − v² + uv + 0.3u with its maximum at (0.2, 0.1). The next four are largest on the rim: two linear polynomials, one
    /// with a maximum outside the disc, and the saddle u² − v² + 0.1u. The last two are ties, for which the zenith is returned.
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
            let is_near = pairs.all(|(a, b)| (a - b).abs() < 1e-6);
            assert!(is_near, "{found:?}, expected {expected:?}");
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
        let image = RgbImage::from_pixel(1, 1, Rgb([7; 3])).into();
        let file = |format| encode_image(&image, format).expect("a small image");
        let gray = encode_image(
            &GrayImage::from_pixel(1, 1, Luma([9])).into(),
            ImageFormat::Pnm,
        );
        assert_eq!(gray.expect("a small image"), b"P5\n1 1 255\n\x09");
        assert_eq!(file(ImageFormat::Pnm), b"P6\n1 1 255\n\x07\x07\x07");
        for format in [Png, Tiff, Bmp, WebP, Jpeg] {
            let read = image::load_from_memory_with_format(&file(format), format);
            let read = read.expect("an image").into_rgb8();
            assert_eq!(read.into_raw(), [7, 7, 7], "{format:?}");
        }
    }

    #[test]
    fn upscaling_repeats_and_downscaling_averages_pixels() {
        let gray = |width, height, values: &[u8]| {
            let samples = values.iter().flat_map(|&value| [value; 3]);
            rgb(Size { width, height }, samples.collect())
        };
        let image = gray(3, 2, &[10, 20, 31, 30, 41, 33]);
        assert_eq!(downscale(&image, 2), gray(2, 1, &[25, 32]));
        let image = gray(2, 2, &[1, 2, 3, 4]);
        let samples = [1, 1, 2, 2, 1, 1, 2, 2, 3, 3, 4, 4, 3, 3, 4, 4];
        assert_eq!(upscale(&image, 2), Ok(gray(4, 4, &samples)));
        assert!(upscale(&image, u32::MAX).is_err());
    }

    #[test]
    fn thumbnails_have_the_requested_size() {
        let map = |width, height| {
            let header = "1 1 1 1 1 1\n0 0 0 0 0 0\n";
            let header = format!("PTM_1.2\nPTM_FORMAT_LRGB\n{width}\n{height}\n{header}");
            let mut file = header.into_bytes();
            file.resize(file.len() + (width * height * 9) as usize, 9);
            ptm::decode(&file).expect("a legal file")
        };
        for (width, height, expected) in [
            (1000, 10, (96, 1)),
            (97, 96, (96, 95)),
            (96, 40, (96, 40)),
            (50, 40, (50, 40)),
            (3, 48, (6, 96)),
        ] {
            assert_eq!(thumbnail(&map(width, height), 96).dimensions(), expected);
        }
    }
}
