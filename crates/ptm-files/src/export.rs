//! Exports values to OpenEXR, NPY and PNG.

use std::io::Cursor;

use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image as ExrImage, Layer,
    LayerAttributes, LineOrder, WritableImage,
};
use image::GrayImage;

use crate::error::Result;
use crate::join_texts;
use ptm::{Ptm, Shape, Size, channel_name};

/// Encodes a map as an EXR file with a named float channel for each final coefficient and for each of the remaining channels.
/// Blocks of 16 scan lines are compressed with ZIP. The attribute `ptm` contains the format, scales, biases and matrix. All values are
/// divided by `divisor`, which the attribute states unless it is 1.
///
/// # Errors
/// Returns an error if the map is too large for the format.
pub fn exr(ptm: &Ptm, divisor: f64) -> Result<Vec<u8>> {
    let coefficients = ptm.coefficients();
    let set = &ptm.header.scale_bias;
    let (scale, bias) = (join_texts(set.scale, " "), join_texts(set.bias, " "));
    let mut text = format!("{}; scale {scale}; bias {bias}", ptm.header.format);
    if let Shape::Lum(matrix) = &coefficients.shape {
        text = text + "; matrix in column-major order " + &join_texts(matrix.0, " ");
    }
    if divisor != 1.0 {
        text = text + "; values divided by " + &divisor.to_string();
    }
    let channels = coefficients.shape.channels();
    let values = divide(&coefficients.values, divisor);
    encode_exr(&values, coefficients.size, channels, &text)
}

/// Divides each value.
#[must_use]
pub fn divide(values: &[f64], divisor: f64) -> Vec<f64> {
    values.iter().map(|value| value / divisor).collect()
}

/// Encodes `values` as an EXR file. The values are interleaved, top row first. `text` becomes the attribute `ptm`.
///
/// # Errors
/// Returns an error if the map is too large for the format.
pub fn encode_exr(values: &[f64], size: Size, channels: usize, text: &str) -> Result<Vec<u8>> {
    let channel = |channel: usize| {
        let plane = values.iter().skip(channel).step_by(channels);
        let samples = FlatSamples::F32(plane.map(|&value| value as f32).collect());
        // `a3`, `R`; with three polynomials `green.a3`.
        let mut name = channel_name(channels, channel);
        if let Some((coefficient, color)) = name.split_once(" of ") {
            name = format!("{color}.{coefficient}");
        }
        AnyChannel::new(&*name, samples)
    };
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let mut attributes = LayerAttributes::default();
    // Write only one attribute, because the library writes multiple attributes in random order.
    let text = AttributeValue::Text(Text::from(text));
    attributes.other.insert(Text::from("ptm"), text);
    let side_lengths = (size.width as usize, size.height as usize);
    let channels = AnyChannels::sort((0..channels).map(channel).collect());
    let layer = Layer::new(side_lengths, attributes, encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    let image = ExrImage::from_layer(layer);
    let result = image.write().non_parallel().to_buffered(&mut bytes);
    result.map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

/// Encodes bytes as an NPY array of height × width × channels, top row first.
#[must_use]
pub fn npy_bytes(values: &[u8], size: Size, channels: usize) -> Vec<u8> {
    [&npy_header("|u1", size, channels), values].concat()
}

/// Encodes values as an NPY array of 32-bit floats, height × width × channels, top row first.
pub fn npy_floats(values: &[f64], size: Size, channels: usize) -> Vec<u8> {
    let mut bytes = npy_header("<f4", size, channels);
    let values = values.iter().map(|&value| value as f32);
    bytes.extend(values.flat_map(f32::to_le_bytes));
    bytes
}

/// Returns an NPY 1.0 header: magic, version, length, and a Python dictionary, padded to a multiple of 64 bytes.
fn npy_header(kind: &str, size: Size, channels: usize) -> Vec<u8> {
    let shape = format!("({}, {}, {channels})", size.height, size.width);
    let dictionary = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    let length = (10 + dictionary.len() + 1).next_multiple_of(64) - 10;
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend((length as u16).to_le_bytes());
    header.extend(format!("{dictionary:<width$}\n", width = length - 1).bytes());
    header
}

/// Separates interleaved samples into planes and stacks the planes into a gray image of `channels * height` rows.
///
/// # Panics
/// Panics if the number of samples does not match the size.
#[must_use]
pub fn stacked_planes(samples: &[u8], size: Size, channels: usize) -> GrayImage {
    let plane = |channel: usize| samples.iter().skip(channel).step_by(channels).copied();
    let stacked = (0..channels).flat_map(plane).collect();
    let image = GrayImage::from_raw(size.width, size.height * channels as u32, stacked);
    image.expect("there is a sample for each channel of each texel")
}
