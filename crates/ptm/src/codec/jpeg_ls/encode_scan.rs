//! T.87 Annex A: samples → bits
//!
//! This is the mirror image of `decode_scan`. The neighbors are decoded samples, which may differ from the image if NEAR is
//! not 0. An encoder that predicts from the original image drifts away from the decoder.
//!
//! Worked example: a line of seven zeros and a one, coded as the bytes FB 40.
//!
//! ```text
//! 1 1 1 1 1    run mode: four segments of one sample, one of two
//! 0 1          interrupted after one more sample
//! 1 01         error 1 with a = b: 2 · 1 − 1 = 1, k = 2
//! 000000       padding
//! ```
//!
//! Format notes
//! - If the last byte is 0xFF, a byte of seven zero bits follows. Without it, a decoder would read the marker as data.

use super::contexts::{Context, fresh_contexts};
use super::run_mode::{Interruption, RunMode};
use super::template::{Lines, Neighbors};
use super::{gradients::context_number, parameters::Parameters, prediction::predict};
use crate::codec::writer::{BitWriter, Writer};

/// Encodes all samples. Returns the samples that a decoder reconstructs.
pub(super) fn encode_scan(
    stream: &mut Writer,
    parameters: &Parameters,
    samples: &[u8],
    width: u32,
) -> Vec<u8> {
    let mut decoded = Vec::with_capacity(samples.len());
    let mut scan = ScanEncoder {
        parameters,
        bits: BitWriter::new(stream),
        contexts: fresh_contexts(parameters),
        run_mode: RunMode::new(parameters),
    };
    let mut lines = Lines::new(width);
    for originals in samples.chunks_exact(width as usize) {
        lines.next();
        scan.encode_line(&mut lines, originals);
        decoded.extend_from_slice(lines.samples());
    }
    scan.bits.finish(0);
    decoded
}

struct ScanEncoder<'p, 's> {
    parameters: &'p Parameters,
    bits: BitWriter<'s, 7>,
    contexts: [Context; 365],
    run_mode: RunMode,
}

impl ScanEncoder<'_, '_> {
    /// Encodes a line. The neighborhood of each sample selects its mode (A.3.2).
    fn encode_line(&mut self, lines: &mut Lines, originals: &[u8]) {
        let width = lines.width();
        let mut x = 0;
        let mut neighbors = lines.neighbors(x);
        while x < width {
            let context = context_number(self.parameters, neighbors);
            let sample = if context == 0 {
                let run = self.run_length(neighbors.a, &originals[x..]);
                self.encode_run_length(run, x + run == width);
                lines.fill(x, run, neighbors.a);
                x += run;
                if x == width {
                    break;
                }
                neighbors = lines.neighbors(x);
                self.encode_interruption(originals[x], neighbors)
            } else {
                self.encode_regular(originals[x], context, neighbors)
            };
            neighbors = lines.set_sample(x, sample, neighbors);
            x += 1;
        }
    }

    /// Encodes one sample in regular mode (A.4 – A.6).
    fn encode_regular(&mut self, original: u8, context: i32, neighbors: Neighbors) -> i32 {
        let parameters = self.parameters;
        let sign = context.signum();
        let context = &mut self.contexts[context.unsigned_abs() as usize];
        let predicted = context.correct_prediction(predict(neighbors), sign, parameters.maxval);
        let error = parameters.quantize_error(sign * (i32::from(original) - predicted));

        let k = context.golomb_parameter();
        let negative_first = context.maps_negative_first(k, parameters.near);
        let ordered = if negative_first { -1 - error } else { error };
        let mapped = 2 * ordered.abs() - i32::from(ordered < 0);
        context.update(error, parameters);
        self.put_golomb(mapped, k, parameters.limit);
        parameters.reconstruct(predicted, sign * error)
    }

    /// Returns the number of leading samples that differ from `a` by at most NEAR (A.7.1.1).
    fn run_length(&self, a: i32, originals: &[u8]) -> usize {
        let is_near = |&&original: &&u8| (i32::from(original) - a).abs() <= self.parameters.near;
        originals.iter().take_while(is_near).count()
    }

    /// Writes the length of a run (A.7.1.2).
    fn encode_run_length(&mut self, mut run: usize, ends_line: bool) {
        while run >= 1 << self.run_mode.segment_bits() {
            self.bits.put_bits(1, 1);
            run -= 1 << self.run_mode.segment_bits();
            self.run_mode.increment_index();
        }
        if !ends_line {
            self.bits
                .put_bits(run as u32, 1 + self.run_mode.segment_bits());
        } else if run > 0 {
            self.bits.put_bits(1, 1);
        }
    }

    /// Encodes the sample that interrupts a run (A.7.2).
    fn encode_interruption(&mut self, original: u8, neighbors: Neighbors) -> i32 {
        let parameters = self.parameters;
        let interruption = Interruption::new(parameters, neighbors.a, neighbors.b);
        let (sign, kind) = (interruption.sign, interruption.kind);
        let error =
            parameters.quantize_error(sign * (i32::from(original) - interruption.predicted));

        let limit = self.run_mode.limit(parameters);
        let context = self.run_mode.context(&interruption);
        let k = context.golomb_parameter(kind);
        let favored = error.signum() == context.favored_sign(k);
        let mapped = 2 * error.abs() - kind - i32::from(favored);
        context.update(error, mapped, kind, parameters.reset);
        self.put_golomb(mapped, k, limit);
        self.run_mode.decrement_index();
        parameters.reconstruct(interruption.predicted, sign * error)
    }

    /// Writes a limited-length Golomb code (A.5.3).
    fn put_golomb(&mut self, mapped: i32, k: u32, limit: u32) {
        let (number, qbpp) = (mapped as u32, self.parameters.qbpp);
        let max_zeros = limit - qbpp - 1;
        let zeros = number >> k;
        if zeros < max_zeros {
            self.bits.put_bits(0, zeros);
            self.bits.put_bits(1 << k | number & ((1 << k) - 1), 1 + k);
        } else {
            self.bits.put_bits(0, max_zeros);
            self.bits.put_bits(1 << qbpp | (number - 1), 1 + qbpp);
        }
    }
}
