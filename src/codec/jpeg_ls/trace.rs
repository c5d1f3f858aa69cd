//! How the samples of a stream are coded, for whoever looks for a mistake in another decoder
//!
//! The question is what the samples have in common that come out wrong there first. A decoder and its
//! encoder do the same with every sample but for the bits, so the decoded samples are gone through once
//! more as `encode_scan` would, with the same contexts and the same run mode, and no bit is written.
//!
//! Format notes
//! - With NEAR over 0 the end of a run may decode to the value of the run, and is then taken for one more
//!   of it. That is rare, and nobody decodes by this.

use super::contexts::{Context, fresh_contexts};
use super::decoder::{decode, read_headers};
use super::gradients::context_number;
use super::parameters::Parameters;
use super::prediction::predict;
use super::run_mode::{Interruption, RunMode};
use super::template::{Lines, Neighbors};
use crate::codec::markers::Cursor;
use crate::codec::stream_error::Result;

/// How a sample is coded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// On its own, by its neighborhood (A.4 – A.6).
    Regular,
    /// As one of a run (A.7.1).
    Run,
    /// As the end of a run where its neighbors a and b differ: `RItype` 0 (A.7.2).
    EndOfRun,
    /// As the end of a run where they are alike: `RItype` 1.
    EndOfRunAlike,
}

/// A sample as it is coded. Numbers that its mode does not have are 0.
#[derive(Clone, Copy)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a fact that may be true of a sample"
)]
pub struct SampleTrace {
    pub mode: Mode,
    pub column: usize,
    pub row: usize,
    /// a, b, c and d of the template.
    pub neighbors: [i32; 4],
    /// −1 where errors count the other way.
    pub sign: i32,
    /// How many samples its context had met before.
    pub met: u32,
    /// What its context had learned: C.
    pub correction: i32,
    /// Whether the corrected prediction had to be limited.
    pub is_limited: bool,
    /// The prediction error as it is coded.
    pub error: i32,
    /// Whether prediction and error make the sample only modulo RANGE.
    pub is_wrapped: bool,
    /// Whether the sign of the shortest code was that of negative errors.
    pub is_negative_first: bool,
    pub k: u32,
    /// Whether its code is one that would be too long otherwise.
    pub is_escaped: bool,
    /// `RUNindex` where the run began that it belongs to or ends.
    pub run_index: u32,
    /// Whether that was the first run of its row.
    pub is_first_run: bool,
    /// Whether the run goes to the end of the row.
    pub ends_row: bool,
}

/// What a scan is coded with.
#[derive(Clone, Copy)]
pub struct ScanTrace {
    pub near: i32,
    pub thresholds: [i32; 3],
    pub reset: i32,
}

/// The samples of a stream in their order.
///
/// # Errors
///
/// As [`decode`].
pub fn trace(stream: &[u8], width: u32, height: u32) -> Result<(Vec<SampleTrace>, ScanTrace)> {
    let samples = decode(stream, width, height)?;
    let parameters = read_headers(&mut Cursor::open(stream)?, width, height)?.0;
    let mut scan = Walk {
        parameters: &parameters,
        contexts: fresh_contexts(&parameters),
        met: [0; 365],
        run_mode: RunMode::new(&parameters),
        run_index: 0,
        runs_met: [0; 2],
        traced: Vec::with_capacity(samples.len()),
    };
    let mut lines = Lines::new(width);
    for (row, line) in samples.chunks_exact(width as usize).enumerate() {
        lines.next();
        scan.line(&mut lines, row, line);
    }
    let scan_trace = ScanTrace {
        near: parameters.near,
        thresholds: parameters.thresholds,
        reset: parameters.reset,
    };
    Ok((scan.traced, scan_trace))
}

/// The state of a scan.
struct Walk<'p> {
    parameters: &'p Parameters,
    contexts: [Context; 365],
    met: [u32; 365],
    run_mode: RunMode,
    run_index: u32,
    runs_met: [u32; 2],
    traced: Vec<SampleTrace>,
}

impl Walk<'_> {
    fn line(&mut self, lines: &mut Lines, row: usize, samples: &[u8]) {
        let width = samples.len();
        let mut x = 0;
        let mut is_first_run = true;
        let mut neighbors = lines.neighbors(x);
        while x < width {
            let number = context_number(self.parameters, neighbors);
            let mut one = fresh(neighbors, x, row);
            if number == 0 {
                let alike = |&&sample: &&u8| i32::from(sample) == neighbors.a;
                let run = samples[x..].iter().take_while(alike).count();
                one.mode = Mode::Run;
                one.run_index = self.run_index;
                one.is_first_run = std::mem::take(&mut is_first_run);
                one.ends_row = x + run == width;
                let of_run = (x..x + run).map(|column| SampleTrace { column, ..one });
                self.traced.extend(of_run);
                self.count_run(run);
                lines.fill(x, run, neighbors.a);
                x += run;
                if x == width {
                    break;
                }
                neighbors = lines.neighbors(x);
                let of_end = fresh(neighbors, x, row);
                let (run_index, is_first_run) = (one.run_index, one.is_first_run);
                one = SampleTrace {
                    run_index,
                    is_first_run,
                    ..of_end
                };
                self.interruption(&mut one, samples[x], neighbors);
            } else {
                self.regular(&mut one, samples[x], number, neighbors);
            }
            self.traced.push(one);
            neighbors = lines.set(x, i32::from(samples[x]), neighbors);
            x += 1;
        }
    }

    fn regular(&mut self, one: &mut SampleTrace, sample: u8, number: i32, neighbors: Neighbors) {
        let parameters = self.parameters;
        let place = number.unsigned_abs() as usize;
        let context = &mut self.contexts[place];
        one.mode = Mode::Regular;
        one.sign = number.signum();
        one.met = self.met[place];
        // 128 is far from both ends of what is limited to −256 … 511.
        one.correction = context.correct(128, 1, 255) - 128;
        let free = predict(neighbors) + one.sign * one.correction;
        let predicted = context.correct(predict(neighbors), one.sign, parameters.maxval);
        one.is_limited = free != predicted;
        one.error = parameters.quantize_error(one.sign * (i32::from(sample) - predicted));
        one.is_wrapped = is_wrapped(parameters, predicted, one);
        one.k = context.golomb_parameter();
        one.is_negative_first = context.maps_negative_first(one.k, parameters.near);
        let ordered = if one.is_negative_first {
            -1 - one.error
        } else {
            one.error
        };
        let mapped = 2 * ordered.abs() - i32::from(ordered < 0);
        one.is_escaped = is_escaped(parameters, mapped, one.k, parameters.limit);
        context.update(one.error, parameters);
        self.met[place] += 1;
    }

    fn interruption(&mut self, one: &mut SampleTrace, sample: u8, neighbors: Neighbors) {
        let parameters = self.parameters;
        let interruption = Interruption::new(parameters, neighbors.a, neighbors.b);
        let (sign, kind) = (interruption.sign, interruption.kind);
        one.mode = [Mode::EndOfRun, Mode::EndOfRunAlike][kind as usize];
        one.sign = sign;
        one.met = self.runs_met[kind as usize];
        let difference = i32::from(sample) - interruption.predicted;
        one.error = parameters.quantize_error(sign * difference);
        one.is_wrapped = is_wrapped(parameters, interruption.predicted, one);
        let limit = self.run_mode.limit(parameters);
        let context = self.run_mode.context(&interruption);
        one.k = context.golomb_parameter(kind);
        one.is_negative_first = context.favored_sign(one.k) < 0;
        let favored = one.error.signum() == context.favored_sign(one.k);
        let mapped = 2 * one.error.abs() - kind - i32::from(favored);
        one.is_escaped = is_escaped(parameters, mapped, one.k, limit);
        context.update(one.error, mapped, kind, parameters.reset);
        self.runs_met[kind as usize] += 1;
        self.run_mode.shorten();
        self.run_index = self.run_index.saturating_sub(1);
    }

    /// A.7.1.2, as far as it changes `RUNindex`.
    fn count_run(&mut self, mut run: usize) {
        while run >= 1 << self.run_mode.j() {
            run -= 1 << self.run_mode.j();
            self.run_mode.lengthen();
            self.run_index = (self.run_index + 1).min(31);
        }
    }
}

/// Nothing but its place.
fn fresh(neighbors: Neighbors, column: usize, row: usize) -> SampleTrace {
    let Neighbors { a, b, c, d } = neighbors;
    SampleTrace {
        mode: Mode::Regular,
        column,
        row,
        neighbors: [a, b, c, d],
        sign: 1,
        met: 0,
        correction: 0,
        is_limited: false,
        error: 0,
        is_wrapped: false,
        is_negative_first: false,
        k: 0,
        is_escaped: false,
        run_index: 0,
        is_first_run: false,
        ends_row: false,
    }
}

fn is_wrapped(parameters: &Parameters, predicted: i32, one: &SampleTrace) -> bool {
    let (near, maxval) = (parameters.near, parameters.maxval);
    let sample = predicted + one.sign * one.error * parameters.step;
    !(-near..=maxval + near).contains(&sample)
}

/// A.5.3: whether its zeros would be more than a code may have.
fn is_escaped(parameters: &Parameters, mapped: i32, k: u32, limit: u32) -> bool {
    mapped as u32 >> k >= limit - parameters.qbpp - 1
}

#[cfg(test)]
mod tests {
    use super::super::encoder::{JpegLsOptions, encode};
    use super::{Mode, trace};

    #[test]
    fn a_trace_tells_runs_and_their_ends_from_other_samples() {
        let samples = [0, 0, 0, 0, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0, 0];
        let options = JpegLsOptions {
            near: 0,
            presets: None,
        };
        let stream = encode(&samples, 8, 2, &options).stream;
        let (traced, scan) = trace(&stream, 8, 2).expect("our own stream");
        assert_eq!((traced.len(), scan.near, scan.reset), (16, 0, 64));
        let modes: Vec<Mode> = traced.iter().map(|one| one.mode).collect();
        assert_eq!(modes[..7], [Mode::Run; 7]);
        assert_eq!((modes[7], traced[7].error), (Mode::EndOfRunAlike, 9));
        assert_eq!(
            (modes[8], traced[8].run_index),
            (Mode::Run, 4),
            "one row later"
        );
        assert!(traced[8].is_first_run && traced[8].row == 1);
        assert!(modes[15] == Mode::Run && traced[15].ends_row);
    }
}
