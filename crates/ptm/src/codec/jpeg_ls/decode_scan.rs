//! T.87 Annex F: bits → samples
//!
//! Decodes every sample in order. The template selects one of two modes: regular mode codes one sample, and run mode
//! codes any number of equal samples and the sample after them.
//!
//! Worked example: an image with a single sample, coded as the byte 70 (bits 0111 0000).
//!
//! ```text
//!        a, b, c and d are 0: all gradients are flat, so run mode is used
//! 0      no segment of a run, and the rest has J = 0 bits: the run is empty
//! 1 11   the Golomb code of 3, with k = 2
//!        RItype 1: 3 + 1 = 4 is twice the magnitude, with the sign that is not favored: error 2
//!        sample 0 + 2
//! 0000   padding
//! ```
//!
//! Format notes
//! - The template after a run belongs to the interrupting sample: b is above *that* sample.
//! - Errors are range-checked, because the range of a Golomb code is larger than that of errors.

use super::contexts::{Context, fresh_contexts};
use super::golomb::ReadGolomb;
use super::run_mode::{Interruption, RunMode};
use super::template::{Lines, Neighbors};
use super::{gradients::context_number, parameters::Parameters, prediction::predict};
use crate::codec::stream_error::{StreamError, StreamResult, malformed};
use crate::codec::{headers::allocate_samples, markers::Cursor};

/// Decodes the entropy-coded data that starts at the cursor. Leaves the cursor at the marker that ends the data.
pub(super) fn decode_scan<'a, B: ReadGolomb<'a>>(
    stream: &mut Cursor<'a>,
    parameters: &Parameters,
    width: u32,
    height: u32,
) -> StreamResult<Vec<u8>> {
    // A line that continues the run of the previous line still takes one bit.
    let mut samples = allocate_samples(stream, width, height, u64::from(height))?;
    let mut scan = ScanDecoder {
        parameters,
        bits: B::new(stream.stream, stream.at),
        contexts: fresh_contexts(parameters),
        run_mode: RunMode::new(parameters),
    };
    let mut lines = Lines::new(width);
    for line in samples.chunks_exact_mut(width as usize) {
        lines.next();
        scan.decode_line(&mut lines)?;
        line.copy_from_slice(lines.samples());
    }
    stream.at = scan.bits.plain_bits().finish()?;
    Ok(samples)
}

struct ScanDecoder<'p, B> {
    parameters: &'p Parameters,
    bits: B,
    contexts: [Context; 365],
    run_mode: RunMode,
}

impl<'a, B: ReadGolomb<'a>> ScanDecoder<'_, B> {
    /// Decodes a line. The neighborhood of each sample selects its mode (A.3.2).
    fn decode_line(&mut self, lines: &mut Lines) -> StreamResult<()> {
        let width = lines.width();
        let mut x = 0;
        let mut neighbors = lines.neighbors(x);
        while x < width {
            let context = context_number(self.parameters, neighbors);
            let sample = if context == 0 {
                let run = self.decode_run_length(width - x)?;
                lines.fill(x, run, neighbors.a);
                x += run;
                if x == width {
                    break;
                }
                neighbors = lines.neighbors(x);
                self.decode_interruption(neighbors)?
            } else {
                self.decode_regular(context, neighbors)?
            };
            neighbors = lines.set_sample(x, sample, neighbors);
            x += 1;
        }
        Ok(())
    }

    /// Decodes one sample in regular mode (A.4 – A.6).
    #[inline]
    fn decode_regular(&mut self, context: i32, neighbors: Neighbors) -> StreamResult<i32> {
        let parameters = self.parameters;
        let sign = context.signum();
        let context = &mut self.contexts[context.unsigned_abs() as usize];
        let predicted = context.correct_prediction(predict(neighbors), sign, parameters.maxval);

        let k = context.golomb_parameter();
        let (limit, qbpp) = (parameters.limit, parameters.qbpp);
        let mapped = self.bits.read_golomb(k, limit, qbpp)?;
        let error = (mapped >> 1) ^ -(mapped & 1); // 0, −1, 1, −2, 2 …
        let negative_first = context.maps_negative_first(k, parameters.near);
        let error = if negative_first { -1 - error } else { error };
        if !parameters.is_reduced(error) {
            return Err(impossible_error(&self.bits, error));
        }
        context.update(error, parameters);
        Ok(parameters.reconstruct(predicted, sign * error))
    }

    /// Reads the length of a run of samples equal to `a` (A.7.1). It is at most `left`, the number of samples left in the line.
    fn decode_run_length(&mut self, left: usize) -> StreamResult<usize> {
        let mut run = 0;
        while self.bits.receive(1)? == 1 {
            let segment = 1 << self.run_mode.segment_bits();
            if run + segment > left {
                return Ok(left); // A.7.1.2: a run that the end of the line truncates
            }
            run += segment;
            self.run_mode.increment_index();
            if run == left {
                return Ok(left);
            }
        }
        run += self.bits.receive(self.run_mode.segment_bits())? as usize;
        if run >= left {
            let what =
                format!("a run of {run} samples is interrupted, but the line has only {left} left");
            return Err(malformed(self.bits.plain_bits().offset(), what));
        }
        Ok(run)
    }

    /// Decodes the sample that interrupts a run (A.7.2).
    fn decode_interruption(&mut self, neighbors: Neighbors) -> StreamResult<i32> {
        let parameters = self.parameters;
        let interruption = Interruption::new(parameters, neighbors.a, neighbors.b);
        let limit = self.run_mode.limit(parameters);
        let context = self.run_mode.context(&interruption);

        let kind = interruption.kind;
        let k = context.golomb_parameter(kind);
        let mapped = self.bits.read_golomb(k, limit, parameters.qbpp)?;
        let doubled = mapped + kind; // twice the magnitude, minus one for the favored sign
        let magnitude = (doubled + 1) >> 1;
        let favored = context.favored_sign(k) * magnitude;
        let error = if doubled & 1 == 1 { favored } else { -favored };
        if !parameters.is_reduced(error) {
            return Err(impossible_error(&self.bits, error));
        }
        context.update(error, mapped, kind, parameters.reset);
        self.run_mode.decrement_index();
        Ok(parameters.reconstruct(interruption.predicted, interruption.sign * error))
    }
}

#[cold]
fn impossible_error<'a>(bits: &impl ReadGolomb<'a>, error: i32) -> StreamError {
    let what = format!("the prediction error {error} is out of range");
    malformed(bits.plain_bits().offset(), what)
}
