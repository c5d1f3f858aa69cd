//! Export of values to files that other programs read: OpenEXR, NPY, PNG.

use std::io::Cursor;

use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image as ExrImage, Layer,
    LayerAttributes, LineOrder, WritableImage,
};

use crate::ptm::{Ptm, Shape, Size};
use crate::tools::render::Image;

/// Returns the name of channel `channel` in an EXR file: `a3`, `R`; with three polynomials `green.a3`.
#[must_use]
pub fn channel_name(channels: usize, channel: usize) -> String {
    match (channels, channel) {
        (18, _) => format!("{}.a{}", ["red", "green", "blue"][channel / 6], channel % 6),
        (_, 0..6) => format!("a{channel}"),
        (9, _) => ["R", "G", "B"][channel - 6].to_owned(),
        _ => ["Cr", "Cb"][channel - 6].to_owned(),
    }
}

/// Returns the final coefficients, and the other channels as plain numbers, as an EXR file of named float channels, in scan
/// line blocks of 16 compressed with ZIP. An attribute named `ptm` has format, scales, biases and matrix.
///
/// # Errors
/// If the map is too large for the format.
pub fn exr(ptm: &Ptm) -> Result<Vec<u8>, String> {
    let coefficients = ptm.coefficients();
    let mut about = format!(
        "{}; scale {}; bias {}",
        ptm.header.format,
        words(&ptm.header.scale_bias.scale),
        words(&ptm.header.scale_bias.bias)
    );
    if let Shape::Lum(matrix) = &coefficients.shape {
        about = format!("{about}; matrix, columns first, {}", words(&matrix.0));
    }
    exr_of(
        &coefficients.values,
        coefficients.size,
        coefficients.shape.channels(),
        &about,
    )
}

/// Returns an EXR file of `values`, texel after texel, top row first, with an attribute `ptm` that describes them.
///
/// # Errors
/// If the map is too large for the format.
pub fn exr_of(values: &[f64], size: Size, channels: usize, about: &str) -> Result<Vec<u8>, String> {
    let channel = |channel: usize| {
        let plane = values
            .iter()
            .skip(channel)
            .step_by(channels)
            .map(|&value| value as f32);
        AnyChannel::new(
            channel_name(channels, channel).as_str(),
            FlatSamples::F32(plane.collect()),
        )
    };
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let mut attributes = LayerAttributes::default();
    // Only one attribute, because the library writes several in random order.
    attributes
        .other
        .insert(Text::from("ptm"), AttributeValue::Text(Text::from(about)));
    let layer = Layer::new(
        (size.width as usize, size.height as usize),
        attributes,
        encoding,
        AnyChannels::sort((0..channels).map(channel).collect()),
    );
    let mut bytes = Cursor::new(Vec::new());
    ExrImage::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut bytes)
        .map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

/// Returns an NPY array of bytes, height × width × channels, top row first.
#[must_use]
pub fn npy_bytes(values: &[u8], size: Size, channels: usize) -> Vec<u8> {
    [&npy_header("|u1", size, channels), values].concat()
}

/// Returns an NPY array of 32-bit floats, height × width × channels, top row first.
#[must_use]
pub fn npy_floats(values: &[f64], size: Size, channels: usize) -> Vec<u8> {
    let mut bytes = npy_header("<f4", size, channels);
    bytes.extend(
        values
            .iter()
            .flat_map(|&value| (value as f32).to_le_bytes()),
    );
    bytes
}

/// Returns the header of NPY 1.0: magic, version, length, and a Python dictionary padded to a multiple of 64 bytes.
fn npy_header(kind: &str, size: Size, channels: usize) -> Vec<u8> {
    let shape = format!("({}, {}, {channels})", size.height, size.width);
    let mut dictionary =
        format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    while !(10 + dictionary.len() + 1).is_multiple_of(64) {
        dictionary.push(' ');
    }
    dictionary.push('\n');
    [
        &b"\x93NUMPY\x01\x00"[..],
        &(dictionary.len() as u16).to_le_bytes(),
        dictionary.as_bytes(),
    ]
    .concat()
}

/// Stacks the planes of samples that lie texel after texel: a gray image of `channels * height` rows.
#[must_use]
pub fn stacked_planes(samples: &[u8], size: Size, channels: usize) -> Image {
    let plane = |channel: usize| samples.iter().skip(channel).step_by(channels).copied();
    Image {
        width: size.width as usize,
        height: size.height as usize * channels,
        channels: 1,
        samples: (0..channels).flat_map(plane).collect(),
    }
}

fn words(numbers: &[f64]) -> String {
    let words: Vec<String> = numbers.iter().map(f64::to_string).collect();
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size {
        width: 2,
        height: 1,
    };

    #[test]
    fn an_array_has_a_header_of_whole_lines_of_64_bytes() {
        let bytes = npy_bytes(&[1, 2, 3, 4, 5, 6], SIZE, 3);
        assert_eq!(bytes.len(), 128 + 6);
        assert!(bytes.starts_with(b"\x93NUMPY\x01\x00\x76\x00{'descr': '|u1', 'fortran_order': False, 'shape': (1, 2, 3), }"));
        assert_eq!(bytes[127], b'\n');
    }

    #[test]
    fn planes_are_stacked_in_the_order_of_the_text() {
        let image = stacked_planes(&[1, 2, 3, 4, 5, 6], SIZE, 3);
        assert_eq!((image.width, image.height), (2, 3));
        assert_eq!(image.samples, [1, 4, 2, 5, 3, 6]);
    }

    #[test]
    fn channels_have_names_that_layers_understand() {
        let names = |channels| {
            (0..channels)
                .map(|channel| channel_name(channels, channel))
                .collect::<Vec<_>>()
        };
        assert_eq!(names(8), ["a0", "a1", "a2", "a3", "a4", "a5", "Cr", "Cb"]);
        assert_eq!(names(9)[5..], ["a5", "R", "G", "B"]);
        assert_eq!(
            [&names(18)[0], &names(18)[10], &names(18)[17]],
            ["red.a0", "green.a4", "blue.a5"]
        );
    }
}
