//! §2.9.8 Compressed Coefficient Planes
//!
//! Each plane is a stream of JPEG or JPEG-LS (clause 2.9.8/3): the plane itself, or its residuals after prediction, plane −
//! predictor + 128 modulo 256 (ruling `prediction`). If lossy compression wraps a texel to the other end of the range, a
//! record of side information contains its value (clauses 2.9.8/4–9).
//!
//! Format notes
//! - The encoder is a closed loop: it predicts from decoded planes, including corrections (clause 2.9.8/7).
//! - The encoders return the samples of an exact decoder, so no stream is decoded here.
//! - An inverse DCT may be off by one. All inverse DCTs agree on constant blocks whose DC coefficient is a multiple of 8. The
//!   default JPEG file is therefore painted as *residuals* in constant blocks, and its planes are computed from them.

use std::collections::HashSet;

use super::plan::{Compression, Residuals, Stream, Texels};
use super::{headers::rewrite_headers, paint::hash};
use super::{predict::predictor, recipe::Recipe};
use ptm::codec::{EncodedImage, jpeg, jpeg_ls};
use ptm::{Coding, Size};

/// The contents of a compressed file (2.9).
#[derive(Clone, Debug, PartialEq)]
pub struct Compressed {
    /// The compression plan, which contains the lists.
    pub plan: Compression,
    /// The planes, in plane order.
    pub planes: Vec<StoredPlane>,
}

/// A plane as it is stored (2.9.8).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredPlane {
    /// The JPEG or JPEG-LS stream.
    pub stream: Vec<u8>,
    /// Records of side information: positions in stored order, and values.
    pub records: Vec<(u32, u8)>,
}

impl StoredPlane {
    /// Returns five bytes per record: the position, big-endian, and the value (clauses 2.9.8/5–8).
    #[must_use]
    pub fn side_information(&self) -> Vec<u8> {
        self.records
            .iter()
            .flat_map(|&(position, value)| [&position.to_be_bytes()[..], &[value]].concat())
            .collect()
    }
}

/// An encoded plane and its decoded samples, in stored order.
#[derive(Clone)]
struct EncodedPlane {
    samples: Vec<u8>,
    /// Maximum difference between the results of inverse DCTs, except for corrected texels.
    slack: u8,
    stored: StoredPlane,
}

/// Encodes the planes of `recipe`, each after its reference (clause 2.9.4/2). `scene` contains the values to encode, texel by
/// texel, top row first.
///
/// Returns the streams, the values that an exact decoder returns, and, for each value, the maximum difference between inverse
/// DCTs (empty if they all agree).
pub(super) fn encode(recipe: &Recipe, scene: &[u8]) -> (Compressed, Vec<u8>, Vec<u8>) {
    let count = recipe.format.channels();
    let plan = &recipe.compression;
    let mut finished: Vec<Option<EncodedPlane>> = vec![None; count];
    for plane in plan.decoding_order() {
        let reference = plan.reference(plane).map(|j| finished[j].as_ref());
        let reference = reference.map(|j| j.expect("Compression::check checked the order"));
        finished[plane] = Some(encode_plane(recipe, scene, plane, reference));
    }
    let finished: Vec<EncodedPlane> = finished.into_iter().flatten().collect();

    let texel = |i: usize| (i % count, stored_position(recipe.size, i / count));
    let positions = || (0..recipe.size.texels() * count).map(texel);
    let sample = |(channel, position): (usize, usize)| finished[channel].samples[position];
    let samples = positions().map(sample).collect();
    let mut slack = Vec::new();
    if finished.iter().any(|plane| plane.slack > 0) {
        let planes = finished.iter().map(|plane| {
            let mut slack = vec![plane.slack; plane.samples.len()];
            // The value of a corrected texel is in the file, so it has no deviation.
            for &(position, _) in &plane.stored.records {
                slack[position as usize] = 0;
            }
            slack
        });
        let planes: Vec<Vec<u8>> = planes.collect();
        slack.extend(positions().map(|(channel, position)| planes[channel][position]));
    }
    let compressed = Compressed {
        plan: plan.clone(),
        planes: finished.into_iter().map(|plane| plane.stored).collect(),
    };
    (compressed, samples, slack)
}

/// Converts the index of a texel, counted from the top, to its stored position. The bottom row is stored first (ruling `rows`).
fn stored_position(size: Size, position: usize) -> usize {
    let width = size.width as usize;
    (size.height as usize - 1 - position / width) * width + position % width
}

fn encode_plane(
    recipe: &Recipe,
    scene: &[u8],
    plane: usize,
    reference: Option<&EncodedPlane>,
) -> EncodedPlane {
    let plan = &recipe.compression;
    let (transform, vector) = (plan.transforms[plane], plan.vector(plane));
    let predictor =
        reference.map(|reference| predictor(&reference.samples, recipe.size, transform, vector));
    let (original, residual) = paint(recipe, scene, plane, predictor.as_deref());
    let encoded = run_codec(recipe, plane, &residual);
    let (stream, received) = (encoded.stream, encoded.samples);
    let own_slack = match recipe.compression.coding {
        Coding::Jpeg => u8::from(!is_exact_in_every_transform(&residual, &received, recipe)),
        Coding::JpegLs => 0,
    };
    let mut samples = reconstruct_plane(&received, predictor.as_deref());
    let records = records(plan, plane, &original, &samples, recipe.size);
    for &(position, value) in &records {
        samples[position as usize] = value; // 2.9.8/8
    }
    let slack = own_slack + reference.map_or(0, |reference| reference.slack);
    EncodedPlane {
        samples,
        slack,
        stored: StoredPlane { stream, records },
    }
}

/// Returns the original values of a plane, and its residuals after prediction.
fn paint(
    recipe: &Recipe,
    scene: &[u8],
    plane: usize,
    predictor: Option<&[u8]>,
) -> (Vec<u8>, Vec<u8>) {
    let size = recipe.size;
    let channels = recipe.format.channels();
    let scene = |position: usize| scene[stored_position(size, position) * channels + plane];
    if recipe.compression.residuals == Residuals::Natural {
        let original: Vec<u8> = (0..size.texels()).map(scene).collect();
        let mut residual = original.clone();
        // An intra plane is stored directly.
        for (sample, predictor) in residual.iter_mut().zip(predictor.unwrap_or_default()) {
            *sample = sample.wrapping_sub(*predictor).wrapping_add(128);
        }
        return (original, residual);
    }
    let residual = paint_residuals(recipe, plane, predictor);
    let mut original = reconstruct_plane(&residual, predictor);
    // Texels with requested records have their original values from the scene, so that the records have an effect.
    for position in recipe.compression.requested_records(plane, size) {
        original[position] = scene(position);
    }
    (original, residual)
}

/// Reconstructs a plane: residual + predictor − 128 modulo 256, or the residual itself without a predictor (ruling `prediction`).
fn reconstruct_plane(residual: &[u8], predictor: Option<&[u8]>) -> Vec<u8> {
    let mut plane = residual.to_vec();
    for (sample, predictor) in plane.iter_mut().zip(predictor.unwrap_or_default()) {
        *sample = sample.wrapping_add(*predictor).wrapping_sub(128);
    }
    plane
}

/// Paints residuals in constant 8×8 blocks with values that every inverse DCT reconstructs exactly.
fn paint_residuals(recipe: &Recipe, plane: usize, predictor: Option<&[u8]>) -> Vec<u8> {
    let size = recipe.size;
    let (width, height) = (size.width as usize, size.height as usize);
    let (columns, rows) = (width.div_ceil(8), height.div_ceil(8));
    let step = exact_step(recipe);
    let value = |block: usize| -> u8 {
        let (column, row) = (block % columns, block / columns);
        let random = hash(recipe.seed ^ 0x0b1c, block, plane);
        // 128 plus a multiple of the step, within 0 to 255.
        let (below, above) = (128 / step, 127 / step);
        let noise = (128 - below * step + random % (below + above + 1) * step) as u8;
        let edge = column == 0 || row == 0 || column + 1 == columns || row + 1 == rows;
        match (recipe.compression.residuals, predictor) {
            (Residuals::Gray, _) => 128,
            (Residuals::Framed, _) if edge => 128,
            (Residuals::Wraps, Some(predictor)) => {
                wrapping_residual(predictor[row * 8 * width + column * 8], random)
            }
            _ => noise,
        }
    };
    let values: Vec<u8> = (0..rows * columns).map(value).collect();
    let texel = |position: usize| values[position / width / 8 * columns + position % width / 8];
    (0..size.texels()).map(texel).collect()
}

/// Returns a residual for which residual + predictor − 128 is −1, 0, 255 or 256.
fn wrapping_residual(predictor: u8, random: u32) -> u8 {
    let sums = if predictor > 128 { [255, 256] } else { [0, -1] };
    // Only the sum −1 with the predictor 128 has a residual out of range, −1. It falls back to the sum 0.
    let residual = |sum: i32| sum + 128 - i32::from(predictor);
    let wanted = residual(sums[(random % 2) as usize]);
    u8::try_from(wanted).unwrap_or_else(|_| residual(sums[0]) as u8)
}

/// Returns the step between the values of constant blocks whose DC coefficient, 8 · (value − 128), is a multiple of both the
/// quantization step and 8. Returns 1 for JPEG-LS, which has no DC coefficient.
fn exact_step(recipe: &Recipe) -> u32 {
    let quality = u32::from(recipe.compression.parameter).clamp(1, 100);
    if recipe.compression.coding == Coding::JpegLs {
        return 1;
    }
    // The Independent JPEG Group's definition of quality, applied to the DC step 16 (T.81 Table K.1).
    let percent = match quality {
        ..50 => 5000 / quality,
        _ => 200 - 2 * quality,
    };
    let options = &recipe.compression.stream.jpeg;
    let largest = if options.baseline { 255 } else { 32767 };
    let quality_step = ((16 * percent + 50) / 100).clamp(1, largest);
    let step = options.step.map_or(quality_step, u32::from);
    step >> step.trailing_zeros().min(3)
}

/// Returns true if every inverse DCT reconstructs the residuals exactly: all blocks are constant and unchanged by the encoder.
fn is_exact_in_every_transform(residual: &[u8], received: &[u8], recipe: &Recipe) -> bool {
    let width = recipe.size.width as usize;
    let first_of_block =
        |position: usize| residual[position / width / 8 * 8 * width + position % width / 8 * 8];
    let step = exact_step(recipe) as u8;
    let is_exact = |position: usize| {
        residual[position] == first_of_block(position)
            && residual[position].abs_diff(128).is_multiple_of(step)
    };
    residual == received && (0..residual.len()).all(is_exact)
}

fn run_codec(recipe: &Recipe, plane: usize, residual: &[u8]) -> EncodedImage {
    let (plan, Size { width, height }) = (&recipe.compression, recipe.size);
    let stream = match plan.even_planes_only && plane % 2 == 1 {
        true => Stream::DEFAULT,
        false => plan.stream,
    };
    let encoded = match recipe.compression.coding {
        Coding::Jpeg => {
            let options = jpeg::JpegOptions {
                quality: plan.parameter,
                ..stream.jpeg
            };
            jpeg::encode(residual, width, height, &options)
        }
        Coding::JpegLs => jpeg_ls::encode(
            residual,
            width,
            height,
            &jpeg_ls::JpegLsOptions {
                near: plan.parameter,
                precision: stream.precision,
                presets: stream.presets,
            },
        ),
    };
    EncodedImage {
        stream: rewrite_headers(&encoded.stream, &stream),
        ..encoded
    }
}

/// Returns the side information of a plane: the requested records, and a record for every texel that wraps around.
fn records(
    plan: &Compression,
    plane: usize,
    original: &[u8],
    decoded: &[u8],
    size: Size,
) -> Vec<(u32, u8)> {
    let mut positions = plan.requested_records(plane, size);
    let requested: HashSet<usize> = positions.iter().copied().collect();
    let overflows = |position: &usize| original[*position].abs_diff(decoded[*position]) > 128;
    positions.extend((0..original.len()).filter(|p| overflows(p) && !requested.contains(p)));
    let mut records = Vec::with_capacity(positions.len());
    for position in positions {
        // side-twice: the first of the two values is wrong.
        if position == 0 && plan.has_records(plane, &Texels::Twice) {
            records.push((position as u32, !original[position]));
        }
        records.push((position as u32, original[position]));
    }
    records
}

#[cfg(test)]
mod tests {
    use crate::{Model, Recipe};
    use ptm::Format;

    #[test]
    fn blocks_round_trip_at_every_quality() {
        for (quality, baseline) in (1..=100).flat_map(|quality| [(quality, true), (quality, false)])
        {
            let mut recipe = Recipe::default_for(Format::JpegLrgb, "17x9".parse().expect("a size"));
            recipe.compression.parameter = quality;
            recipe.compression.stream.jpeg.baseline = baseline;
            assert!(Model::paint(&recipe).slack.is_empty(), "quality {quality}");
        }
    }
}
