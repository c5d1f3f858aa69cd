//! Tolerances for the requested planes in lossy formats.
//!
//! In JPEG, the error of a DCT coefficient is at most half its quantization step, and the transform preserves the sum of
//! squares. For every encoder, the sum of squared errors of a block is therefore at most a quarter of the sum of squared
//! steps. In JPEG-LS, no sample is off by more than NEAR.
//!
//! Format notes
//! - Residuals wrap around, so errors are measured modulo 256. However, a texel that wraps to the other end of the range
//!   is wrong, and a record of side information must correct it (clause 2.9.8/4).
//! - A corrected texel has exactly the requested value.

use std::collections::HashSet;

use crate::{fault::WriterFault, request::WriteRequest};
use ptm::channel_name;
pub use ptm::codec::jpeg::scaled_steps;
use ptm::decode::planes::parse_records;

/// Additional tolerance per sample for rounding in the integer transforms of the encoder and the decoder.
const ROUNDING_TOLERANCE: f64 = 1.0;

/// Returns true if the samples differ from the requested samples by no more than the format allows. Ignores side information.
pub fn matches_within_loss(request: &WriteRequest, decoded: &[u8]) -> bool {
    match request.is_lossy() {
        true => check(request, decoded, |_| &[]).is_ok(),
        false => decoded == request.samples,
    }
}

/// Compares all planes with the requested planes. `side` returns the side information of a plane. Returns the first fault.
pub fn check<'a>(
    request: &WriteRequest,
    decoded: &[u8],
    side: impl Fn(usize) -> &'a [u8],
) -> Result<(), WriterFault> {
    (0..request.format.channels()).try_for_each(|plane| {
        let plane = LossyPlane::new(request, plane, decoded, side(plane));
        plane.check_wraparound()?;
        match request.header.quality {
            Some(quality) => plane.check_blocks(quality),
            None => plane.check_near(request.header.near.unwrap_or_default()),
        }
    })
}

/// Returns the samples of a plane in stored order, bottom row first.
fn stored_plane(request: &WriteRequest, samples: &[u8], plane: usize) -> Vec<u8> {
    let channels = request.format.channels();
    let row = request.header.width as usize * channels;
    let rows = samples.chunks_exact(row).rev();
    let samples = rows.flat_map(|row| row.iter().skip(plane).step_by(channels));
    samples.copied().collect()
}

struct LossyPlane<'a> {
    request: &'a WriteRequest,
    plane: usize,
    /// Requested samples, in stored order.
    requested: Vec<u8>,
    /// Samples that the reference decodes, in stored order.
    decoded: Vec<u8>,
    /// Indices of texels with a record of side information.
    corrected: HashSet<usize>,
}

impl<'a> LossyPlane<'a> {
    fn new(request: &'a WriteRequest, plane: usize, decoded: &[u8], side: &[u8]) -> LossyPlane<'a> {
        let records = parse_records(side, 0, usize::MAX).unwrap_or_default();
        LossyPlane {
            request,
            plane,
            requested: stored_plane(request, &request.samples, plane),
            decoded: stored_plane(request, decoded, plane),
            corrected: records.iter().map(|&(index, _)| index as usize).collect(),
        }
    }

    /// Checks that corrected texels are right, and that no other texel wraps to the wrong end of the range.
    fn check_wraparound(&self) -> Result<(), WriterFault> {
        let pairs = self.requested.iter().zip(&self.decoded).enumerate();
        for (index, (&wanted, &found)) in pairs {
            if self.corrected.contains(&index) && wanted != found {
                let why = "the side information record for the texel has a different value";
                return Err(self.fault("2.9.8/8", index, why));
            }
            if wanted.abs_diff(found) > 128 {
                let why = "the texel wraps around because of lossy compression, and no record of side information corrects it";
                return Err(self.fault("2.9.8/4", index, why));
            }
        }
        Ok(())
    }

    /// Checks that no sample of a JPEG-LS plane is off by more than `near`.
    fn check_near(&self, near: u8) -> Result<(), WriterFault> {
        let mut pairs = self.requested.iter().zip(&self.decoded);
        let index = pairs.position(|(&wanted, &found)| distance_modulo_256(wanted, found) > near);
        let why = format!("a loss of at most {near} was requested");
        index.map_or(Ok(()), |index| Err(self.fault("2.9.1/1", index, &why)))
    }

    /// Checks that no block of a JPEG plane is off by more than the quantization steps of `quality` allow.
    fn check_blocks(&self, quality: u8) -> Result<(), WriterFault> {
        let steps = scaled_steps(quality, false).map(f64::from);
        let quarter_sum = steps.iter().map(|step| step * step / 4.0).sum::<f64>();
        let allowed = (quarter_sum.sqrt() + 8.0 * ROUNDING_TOLERANCE).powi(2);
        let width = self.request.header.width as usize;
        let columns = width.div_ceil(8);
        let rows = (self.request.header.height as usize).div_ceil(8);
        let mut errors = vec![0.0; columns * rows];
        for (index, (&wanted, &found)) in self.requested.iter().zip(&self.decoded).enumerate() {
            let block = index / width / 8 * columns + index % width / 8;
            errors[block] += f64::from(distance_modulo_256(wanted, found)).powi(2);
        }
        let Some(block) = errors.iter().position(|&error| error > allowed) else {
            return Ok(());
        };
        let index = block / columns * 8 * width + block % columns * 8;
        let [error, allowed] = [errors[block], allowed].map(|sum| (sum / 64.0).sqrt());
        let why = format!(
            "the RMS error of the block of 8 × 8 samples is {error:.1}, but quality {quality} allows only {allowed:.1}"
        );
        Err(self.fault("2.9.1/1", index, &why))
    }

    /// Creates a fault for the texel at an index in stored order.
    fn fault(&self, clause: &str, index: usize, why: &str) -> WriterFault {
        let width = self.request.header.width as usize;
        let height = self.request.header.height as usize;
        let (x, y) = (index % width, height - 1 - index / width);
        let (wanted, found) = (self.requested[index], self.decoded[index]);
        let name = channel_name(self.request.format.channels(), self.plane);
        WriterFault::new(
            clause,
            format!("texel ({x}, {y}), {name}: expected {wanted}, found {found}: {why}"),
        )
    }
}

/// Returns the distance between two values modulo 256.
fn distance_modulo_256(a: u8, b: u8) -> u8 {
    a.wrapping_sub(b).min(b.wrapping_sub(a))
}
