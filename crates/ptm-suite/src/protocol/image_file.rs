//! Reads PNG, Netpbm, TIFF, BMP, WebP and JPEG images in 8-bit gray or color. The samples are used unchanged.
//!
//! The `image` crate decodes the files. There is no color management: gamma, profiles and chromaticities are ignored, because the
//! samples are the output of the decoder. Gray is expanded to three equal channels. Alpha is dropped if it is opaque.
//!
//! JPEG compression is lossy, so a frame from a JPEG is marked as lossy. A JPEG must have small quantization steps and no chroma
//! subsampling, so that each sample is close to the one that was saved. A coarser JPEG or a lossy WebP does not determine
//! individual texels.

use std::io::Cursor;
use std::panic::catch_unwind;

use image::codecs::pnm::{PnmDecoder, PnmSubtype};
use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use crate::error::{Error, Result};
use crate::protocol::frame::{Frame, Samples, ViewKind};
use crate::protocol::tiff_file::Directory;
use ptm::codec::markers;

/// Largest quantization step of an accepted JPEG: the largest step of libjpeg at quality 95.
const MAX_QUANTIZATION_STEP: u16 = 12;
/// Memory, in bytes, for the tables and embedded profiles of an image, in addition to its samples.
const WORKING_MEMORY: usize = 64 << 20;

/// The accepted file formats.
const FORMATS: [(ImageFormat, &str); 6] = [
    (ImageFormat::Png, "a PNG"),
    (ImageFormat::Pnm, "a Netpbm file"),
    (ImageFormat::Tiff, "a TIFF"),
    (ImageFormat::Bmp, "a BMP"),
    (ImageFormat::WebP, "a WebP"),
    (ImageFormat::Jpeg, "a JPEG"),
];

/// Decodes `bytes` if they begin with the signature of an accepted format. Decompresses at most `max_bytes` bytes of samples.
pub(crate) fn read(bytes: &[u8], max_bytes: usize) -> Option<Result<Frame>> {
    let found = image::guess_format(bytes).ok()?;
    let (format, name) = FORMATS.into_iter().find(|(format, _)| *format == found)?;
    // A panic in the image library must not end the run.
    let read = catch_unwind(|| read_as(format, bytes, max_bytes));
    let read = read.unwrap_or_else(|_| Error::invalid("the image library cannot read the image"));
    Some(read.map_err(|error| error.in_place(name)))
}

fn read_as(format: ImageFormat, bytes: &[u8], max_bytes: usize) -> Result<Frame> {
    let to_text = |error: image::ImageError| error.to_string();
    let directory = (format == ImageFormat::Tiff)
        .then(|| Directory::read(bytes))
        .flatten();
    if let Some(directory) = &directory {
        directory.check()?;
    }
    if let Some(directory) = &directory
        && directory.has_palette()
    {
        return read_palette(directory, bytes, max_bytes);
    }
    let mut cursor = Cursor::new(bytes);
    let mut reader = ImageReader::with_format(&mut cursor, format);
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(max_bytes.saturating_add(WORKING_MEMORY) as u64);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(to_text)?;
    let (width, height) = decoder.dimensions();
    // Check the size before allocating memory for the texels.
    check_size(width, height, decoder.total_bytes(), max_bytes)?;
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    check_orientation(orientation.to_exif())?;
    let color = decoder.color_type();
    if color.bytes_per_pixel() != color.channel_count() {
        let bits = 8 * color.bytes_per_pixel() / color.channel_count();
        return Error::invalid(format!("the image has {bits} bits per sample, not 8"));
    }
    match format {
        ImageFormat::Pnm => check_full_range(bytes)?,
        ImageFormat::Jpeg => check_quality(bytes)?,
        ImageFormat::WebP if is_lossy_webp(bytes) => {
            return Error::invalid(
                "four texels share one color, because the image is lossy; write a lossless image",
            );
        }
        _ => {}
    }
    let image = DynamicImage::from_decoder(decoder).map_err(to_text)?;
    check_end(format, bytes, cursor.position() as usize)?;
    if let Some(directory) = &directory {
        directory.check_end(bytes)?;
    }
    if color.has_alpha() {
        check_opaque(&image)?;
    }
    Ok(Frame {
        view: ViewKind::Rgb,
        width,
        height,
        channels: 3,
        samples: Samples::U8(image.into_rgb8().into_raw()),
        lossy: format == ImageFormat::Jpeg,
    })
}

/// Decodes a TIFF with a palette, which the `image` crate does not support.
fn read_palette(directory: &Directory, bytes: &[u8], max_bytes: usize) -> Result<Frame> {
    let (width, height) = directory.size();
    check_size(
        width,
        height,
        3 * u64::from(width) * u64::from(height),
        max_bytes,
    )?;
    check_orientation(directory.orientation())?;
    directory.check_end(bytes)?;
    Ok(Frame {
        view: ViewKind::Rgb,
        width,
        height,
        channels: 3,
        samples: Samples::U8(directory.read_palette(bytes)?),
        lossy: false,
    })
}

fn check_size(width: u32, height: u32, bytes: u64, max_bytes: usize) -> Result<()> {
    match bytes > max_bytes as u64 {
        true => Error::invalid(format!(
            "the image has {width} x {height} texels, more than the PTM file"
        )),
        false => Ok(()),
    }
}

/// Rejects an image with an orientation tag other than 1, because other programs would show the image differently.
fn check_orientation(orientation: u8) -> Result<()> {
    match orientation {
        1 => Ok(()),
        other => Error::invalid(format!(
            "a tag tells viewers to turn or mirror the image (orientation {other}), which is not done here; store the top row first, without the tag"
        )),
    }
}

/// Rejects Netpbm files whose maximum value is not 255, because samples are not scaled.
fn check_full_range(bytes: &[u8]) -> Result<()> {
    let decoder = PnmDecoder::new(bytes).map_err(|error| error.to_string())?;
    let header = decoder.header();
    match (header.subtype(), header.maximal_sample()) {
        (PnmSubtype::Bitmap(_), _) | (_, 255) => Ok(()),
        (_, largest) => Error::invalid(format!("the maxval is {largest}, not 255")),
    }
}

/// Returns true if a WebP contains a lossy image, in the first or in a later chunk.
fn is_lossy_webp(bytes: &[u8]) -> bool {
    let mut rest = bytes.get(12..).unwrap_or_default();
    while let [a, b, c, d, s0, s1, s2, s3, chunk @ ..] = rest {
        if &[*a, *b, *c, *d] == b"VP8 " {
            return true;
        }
        let size = u32::from_le_bytes([*s0, *s1, *s2, *s3]) as usize;
        rest = chunk
            .get(size.saturating_add(size % 2)..)
            .unwrap_or_default();
    }
    false
}

/// Rejects a JPEG with chroma subsampling or large quantization steps.
fn check_quality(bytes: &[u8]) -> Result<()> {
    let advice = "write the image with quality 95 or more and without subsampling, or use another image format";
    let mut stream = markers::Cursor::new(bytes, 2);
    while let Ok((code, content)) = stream.read_marker_segment()
        && code != markers::SOS
    {
        match (code, content) {
            (0xdb, tables) if largest_step(tables) > MAX_QUANTIZATION_STEP => {
                let step = largest_step(tables);
                return Error::invalid(format!(
                    "the quantization is too coarse, with steps of {step}; {advice}"
                ));
            }
            (0xc4 | 0xc8 | 0xcc, _) => {}
            // The sampling factors of each component follow its id.
            (0xc0..=0xcf, [_, _, _, _, _, _, components @ ..]) => {
                let mut factors = components.chunks(3).map(|component| component.get(1));
                let first = factors.next();
                if factors.any(|other| Some(other) != first) {
                    return Error::invalid(format!("several texels share one color; {advice}"));
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// Returns the largest step in the quantization tables of a segment (T.81 B.2.4.1).
fn largest_step(mut tables: &[u8]) -> u16 {
    let mut largest = 0;
    while let [kind, rest @ ..] = tables {
        let length = if kind >> 4 == 0 { 64 } else { 128 };
        let (table, more) = rest.split_at(length.min(rest.len()));
        let steps = table.chunks(length / 64);
        let step = |bytes: &[u8]| {
            bytes
                .iter()
                .fold(0, |step, &byte| step << 8 | u16::from(byte))
        };
        largest = steps.map(step).max().unwrap_or(0).max(largest);
        tables = more;
    }
    largest
}

/// Rejects an image that lacks its end marker or is followed by other bytes or images. `end` is the position after the samples,
/// where a Netpbm file ends. [`Directory`] checks TIFF.
fn check_end(format: ImageFormat, bytes: &[u8], end: usize) -> Result<()> {
    const IEND: &[u8] = b"\0\0\0\0IEND\xae\x42\x60\x82";
    let end = match format {
        ImageFormat::Png => {
            if bytes.windows(4).any(|name| name == b"acTL") {
                return Error::invalid("the image is animated; write a single frame");
            }
            let last = bytes.windows(IEND.len()).position(|bytes| bytes == IEND);
            last.ok_or("the image has no IEND chunk")? + IEND.len()
        }
        // Only whitespace may follow the numbers of an ASCII file.
        ImageFormat::Pnm
            if matches!(bytes[1], b'1'..=b'3') && bytes[end..].trim_ascii().is_empty() =>
        {
            bytes.len()
        }
        ImageFormat::Pnm => end,
        ImageFormat::Jpeg if !bytes.ends_with(b"\xff\xd9") => {
            return Error::invalid("the image does not end with the marker FFD9");
        }
        ImageFormat::Bmp => declared_length(bytes, 2).unwrap_or(bytes.len()),
        ImageFormat::WebP => {
            if bytes.windows(4).any(|name| name == b"ANMF") {
                return Error::invalid("the image is animated; write a single frame");
            }
            declared_length(bytes, 4)
                .map_or(bytes.len(), |length| length.saturating_add(8 + length % 2))
        }
        _ => bytes.len(),
    };
    match bytes.len().saturating_sub(end) {
        0 => Ok(()),
        more => Error::invalid(format!("{more} bytes follow the end marker")),
    }
}

/// Returns the length that a file declares at an offset, if it is not 0.
fn declared_length(bytes: &[u8], at: usize) -> Option<usize> {
    let length = u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?);
    (length > 0).then_some(length as usize)
}

/// Rejects an image with alpha other than 255.
fn check_opaque(image: &DynamicImage) -> Result<()> {
    let image = image.to_rgba8();
    let mut texels = image.enumerate_pixels();
    match texels.find(|(_, _, texel)| texel.0[3] != 255) {
        None => Ok(()),
        Some((x, y, texel)) => Error::invalid(format!(
            "texel ({x}, {y}) is not opaque (its alpha is {}), but PTMs have no transparency",
            texel.0[3]
        )),
    }
}
