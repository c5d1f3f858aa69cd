//! JPEG-LS streams decoded with one slip in the decoder of T.87.
//!
//! Where a slip is made nothing can be read off the samples that follow: bits and contexts are out of step. So each slip is
//! made, and what comes out is compared with what the decoder under test shows. The decoder here is the plainest one there
//! is; every decision in it is a field of [`Rules`], right by default.

use super::slips::{IsShown, Partial, Slip, signed_byte, slips};
use crate::codec::jpeg_ls::{
    self, J, Neighbors, PresetParameters, default_thresholds, limited_thresholds, stored_scan,
    wanted_thresholds,
};
use crate::error::Result;
use crate::parts::PlaneStream;

/// The numbers of a scan.
struct Scan {
    maxval: i32,
    near: i32,
    step: i32,
    thresholds: [i32; 3],
    reset: i32,
    range: i32,
    qbpp: u32,
    limit: u32,
}

/// The rows so far, with the row that is being decoded as the last one.
struct Plane {
    width: usize,
    samples: Vec<i32>,
}

impl Plane {
    /// A sample, 0 where there is none yet. Columns outside of a row lead into the rows beside it.
    fn flat(&self, row: usize, column: isize) -> i32 {
        let place = (row * self.width) as isize + column;
        let sample = usize::try_from(place)
            .ok()
            .and_then(|at| self.samples.get(at));
        sample.copied().unwrap_or_default()
    }

    /// The same of the row above `row`; 0 above the first.
    fn above(&self, row: usize, column: isize) -> i32 {
        row.checked_sub(1).map_or(0, |row| self.flat(row, column))
    }

    /// a, b, c and d of the template (A.2.1, A.3.1).
    fn neighbors(&self, row: usize, column: usize) -> [i32; 4] {
        let (x, last) = (column as isize, self.width as isize - 1);
        let a = if x > 0 {
            self.flat(row, x - 1)
        } else {
            self.above(row, 0)
        };
        let c = match (x, row) {
            (0, 0 | 1) => 0,
            (0, _) => self.above(row - 1, 0),
            _ => self.above(row, x - 1),
        };
        [a, self.above(row, x), c, self.above(row, (x + 1).min(last))]
    }
}

/// What a context knows: A, B, C and N.
#[derive(Clone, Copy)]
struct Context {
    a: i32,
    b: i32,
    c: i32,
    n: i32,
}

impl Context {
    fn halve(&mut self, rules: &Rules) {
        self.a = (rules.halve_a)(self.a);
        self.b = (rules.halve_b)(self.b);
        self.n >>= 1;
    }
}

/// Every decision of the decoder.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a decision by itself"
)]
pub(in crate::diagnose) struct Rules {
    /// NEAR, as it is stored.
    near: fn(i32) -> i32,
    /// Thresholds as they are stored, 0 for defaults; MAXVAL and NEAR.
    thresholds: fn([i32; 3], i32, i32) -> [i32; 3],
    reset: fn(i32) -> i32,
    range: fn(i32, i32) -> i32,
    qbpp: fn(i32) -> u32,
    /// LIMIT of MAXVAL and qbpp.
    limit: fn(i32, u32) -> u32,
    /// By how much LIMIT is off.
    limit_off: i32,
    /// The presets that count: of those of the stream before and its own.
    keep_presets: fn(PresetParameters, PresetParameters) -> PresetParameters,
    /// Whether contexts, those of runs, and `RUNindex` are kept from the stream before.
    keeps: (bool, bool, bool),
    /// Whether any of these is so.
    pub(in crate::diagnose) is_keeping: bool,
    /// Whether the byte behind 0xFF at this place of the data carries seven bits.
    is_stuffed: fn(usize) -> bool,
    /// Whether a byte 00 behind 0xFF is dropped, as JPEG has it.
    drops_zeros: bool,
    neighbors: fn(&Plane, usize, usize) -> [i32; 4],
    /// The region of a gradient.
    region: fn(&Scan, i32) -> i32,
    /// d − b, b − c and c − a.
    gradients: fn([i32; 4]) -> [i32; 3],
    /// Of regions and gradients.
    is_run: fn(&Scan, [i32; 3], [i32; 3]) -> bool,
    /// The number of a context, and the sign.
    context: fn([i32; 3]) -> (i32, i32),
    predict: fn([i32; 4]) -> i32,
    /// The prediction, the sign and C.
    correct: fn(i32, i32, i32) -> i32,
    limit_prediction: fn(i32, i32) -> i32,
    initial_a: fn(i32) -> i32,
    golomb: fn(i32, i32) -> u32,
    run_golomb: fn(i32, i32) -> u32,
    /// What becomes of k in regular mode.
    regular_k: fn(u32) -> u32,
    /// Zeros of the longest code, of LIMIT and qbpp.
    longest: fn(u32, u32) -> u32,
    /// The bits of an escaped number, of qbpp, and what it is.
    escape_bits: fn(u32) -> u32,
    escaped: fn(i32) -> i32,
    /// Whether negative errors come first, of k, NEAR, B and N.
    is_negative_first: fn(u32, i32, i32, i32) -> bool,
    error: fn(i32) -> i32,
    /// Whether counters are halved, of N and RESET, in regular mode and in run mode.
    is_full: fn(i32, i32) -> bool,
    is_run_full: fn(i32, i32) -> bool,
    /// Whether counters are halved before the error is added to them.
    is_halved_first: bool,
    /// What A and B grow by: the error and 2·NEAR + 1.
    learn_a: fn(i32, i32) -> i32,
    learn_b: fn(i32, i32) -> i32,
    halve_b: fn(i32) -> i32,
    halve_a: fn(i32) -> i32,
    /// What becomes of A and of B where they are stored.
    store_a: fn(i32) -> i32,
    store_b: fn(i32) -> i32,
    /// B, C and N.
    correction: fn(i32, i32, i32) -> (i32, i32),
    /// The limits of C besides.
    c_limits: (i32, i32),
    reconstruct: fn(&Scan, i32, i32) -> i32,
    j: fn(usize) -> u32,
    /// An entry of J that is another, by how much, and whether it is for whole pieces of a run and for the rest of a run.
    typo: (usize, i32, bool, bool),
    /// `RUNindex` at the start of a row.
    start_row: fn(usize) -> usize,
    /// Whether whole pieces of a run are filled with the samples above.
    is_piece_of_above: bool,
    /// The largest `RUNindex`.
    most_run_index: usize,
    /// What a run that the row cuts short, and one that fills the row, add to `RUNindex`.
    partial_counts: isize,
    full_counts: isize,
    /// Whether b at the end of a run is that of its beginning.
    is_early_b: bool,
    shorten: fn(usize) -> usize,
    /// Whether `RUNindex` goes down before the interruption is read.
    is_shortened_first: bool,
    /// Whether a and b are alike, of their difference and NEAR.
    is_alike: fn(i32, i32) -> bool,
    /// The prediction of an interruption: whether alike, a and b.
    interrupted: fn(bool, i32, i32) -> i32,
    /// The sample at the end of a run.
    reconstruct_interrupted: fn(&Scan, i32, i32) -> i32,
    run_sign: fn(bool, i32, i32) -> i32,
    /// The sum that k is computed of: A, N and `RItype`.
    run_sum: fn(i32, i32, i32) -> i32,
    /// Whether A of `RItype` 0 is taken for that of `RItype` 1 too.
    is_run_a_shared: bool,
    run_limit: fn(u32, u32) -> u32,
    /// Of k, NEAR, Nn and N: whether positive errors are favored.
    is_positive_favored: fn(u32, i32, i32, i32) -> bool,
    /// Twice the magnitude, of the number and `RItype`.
    doubled: fn(i32, i32) -> i32,
    /// Whether an error counts as negative, before and after the sign.
    is_negative: fn(i32, i32) -> bool,
    /// What A grows by: the number, `RItype` and the error.
    run_growth: fn(i32, i32, i32) -> i32,
    /// Nn at the start.
    initial_negative: i32,
    halve_negative: fn(i32) -> i32,
}

impl Rules {
    /// The bits of the rest of a run.
    fn j(&self, index: usize) -> u32 {
        let (place, by, _, is_of_rest) = self.typo;
        let by = if is_of_rest && place == index { by } else { 0 };
        (self.j)(index).saturating_add_signed(by)
    }

    /// The samples of a whole piece of a run.
    fn piece(&self, index: usize) -> usize {
        let (place, by, is_of_pieces, _) = self.typo;
        let by = if is_of_pieces && place == index {
            by
        } else {
            0
        };
        1 << (self.j)(index).saturating_add_signed(by)
    }
}

fn bits_for(values: i32) -> u32 {
    (values.max(2) - 1).ilog2() + 1
}

/// Defaults of T1, T2 and T3 in place of zeros.
fn thresholds(stored: [i32; 3], maxval: i32, near: i32) -> [i32; 3] {
    let defaults = default_thresholds(maxval, near);
    [0, 1, 2].map(|i| {
        if stored[i] == 0 {
            defaults[i]
        } else {
            stored[i]
        }
    })
}

fn region(scan: &Scan, gradient: i32) -> i32 {
    // In the order of A.3.3, which matters where wrong thresholds are not over NEAR.
    let [t1, t2, t3] = scan.thresholds;
    let bounds = [
        (-t3, -4),
        (-t2, -3),
        (-t1, -2),
        (-scan.near - 1, -1),
        (scan.near, 0),
    ];
    let lower = bounds.into_iter().find(|&(bound, _)| gradient <= bound);
    let upper = [(t1, 1), (t2, 2), (t3, 3)].into_iter();
    let upper = || upper.clone().find(|&(bound, _)| gradient < bound);
    lower.or_else(upper).map_or(4, |(_, region)| region)
}

fn number([q1, q2, q3]: [i32; 3]) -> (i32, i32) {
    let number = 81 * q1 + 9 * q2 + q3;
    (number.abs(), if number < 0 { -1 } else { 1 })
}

fn predict([a, b, c, d]: [i32; 4]) -> i32 {
    jpeg_ls::predict(Neighbors { a, b, c, d })
}

fn golomb(a: i32, n: i32) -> u32 {
    (0..24).find(|&k| n << k >= a).unwrap_or(24)
}

fn correction(b: i32, c: i32, n: i32) -> (i32, i32) {
    if b <= -n {
        ((b + n).max(1 - n), (c - 1).max(-128))
    } else if b > 0 {
        ((b - n).min(0), (c + 1).min(127))
    } else {
        (b, c)
    }
}

/// A sample modulo RANGE, not limited.
fn wrapped(scan: &Scan, predicted: i32, error: i32) -> i32 {
    within(scan, scan.range * scan.step, predicted + error * scan.step)
}

/// A sample that is brought back by `modulus` where it is beyond 0 … MAXVAL by more than NEAR.
fn within(scan: &Scan, modulus: i32, sample: i32) -> i32 {
    if sample < -scan.near {
        sample + modulus
    } else if sample > scan.maxval + scan.near {
        sample - modulus
    } else {
        sample
    }
}

fn reconstruct(scan: &Scan, predicted: i32, error: i32) -> i32 {
    wrapped(scan, predicted, error).clamp(0, scan.maxval)
}

pub(in crate::diagnose) const RIGHT: Rules = Rules {
    near: |stored| stored,
    thresholds,
    reset: |stored| if stored == 0 { 64 } else { stored },
    range: |maxval, near| (maxval + 2 * near) / (2 * near + 1) + 1,
    qbpp: bits_for,
    limit: |maxval, _| {
        let bits = bits_for(maxval + 1).max(2);
        2 * (bits + bits.max(8))
    },
    limit_off: 0,
    keep_presets: |_, own| own,
    keeps: (false, false, false),
    is_keeping: false,
    is_stuffed: |_| true,
    drops_zeros: false,
    neighbors: Plane::neighbors,
    region,
    gradients: |[a, b, c, d]| [d - b, b - c, c - a],
    is_run: |_, regions, _| regions == [0; 3],
    context: number,
    predict,
    correct: |predicted, sign, c| predicted + sign * c,
    limit_prediction: |predicted, maxval| predicted.clamp(0, maxval),
    initial_a: |range| ((range + 32) / 64).max(2),
    golomb,
    run_golomb: golomb,
    regular_k: |k| k,
    longest: |limit, qbpp| limit.saturating_sub(qbpp + 1),
    escape_bits: |qbpp| qbpp,
    escaped: |number| number + 1,
    is_negative_first: |k, near, b, n| k == 0 && near == 0 && 2 * b <= -n,
    error: |mapped| (mapped >> 1) ^ -(mapped & 1),
    is_full: |n, reset| n == reset,
    is_run_full: |n, reset| n == reset,
    is_halved_first: false,
    learn_a: |error, _| error.abs(),
    learn_b: |error, step| error * step,
    halve_b: |b| b >> 1,
    halve_a: |a| a >> 1,
    store_a: |a| a,
    store_b: |b| b,
    correction,
    c_limits: (i32::MIN, i32::MAX),
    reconstruct,
    j: |index| J[index],
    typo: (0, 0, true, true),
    start_row: |index| index,
    is_piece_of_above: false,
    most_run_index: 31,
    partial_counts: 0,
    full_counts: 1,
    is_early_b: false,
    shorten: |index| index.saturating_sub(1),
    is_shortened_first: false,
    is_alike: |difference, near| difference.abs() <= near,
    interrupted: |alike, a, b| if alike { a } else { b },
    reconstruct_interrupted: reconstruct,
    run_sign: |alike, a, b| if !alike && a > b { -1 } else { 1 },
    run_sum: |a, n, kind| a + kind * (n >> 1),
    is_run_a_shared: false,
    run_limit: |limit, j| limit.saturating_sub(j + 1),
    is_positive_favored: |k, _, negative, n| k == 0 && 2 * negative < n,
    doubled: |number, kind| number + kind,
    is_negative: |error, _| error < 0,
    run_growth: |number, kind, _| (number + 1 - kind) >> 1,
    initial_negative: 0,
    halve_negative: |negative| negative >> 1,
};

/// The bits of the data. Nothing where they end, at a marker.
struct Bits<'a> {
    data: &'a [u8],
    at: usize,
    unread: u32,
    rules: &'a Rules,
}

impl Bits<'_> {
    fn bit(&mut self) -> Option<u32> {
        if self.unread == 0 {
            let byte = *self.data.get(self.at)?;
            let after_ff = self.at > 0 && self.data[self.at - 1] == 0xFF;
            if byte == 0xFF
                && self
                    .data
                    .get(self.at + 1)
                    .is_none_or(|&next| next >> 7 == 1)
            {
                return None;
            }
            if after_ff && byte == 0 && self.rules.drops_zeros {
                self.at += 1;
                return self.bit();
            }
            let is_stuffed = after_ff && (self.rules.is_stuffed)(self.at);
            self.unread = if is_stuffed { 7 } else { 8 };
            self.at += 1;
        }
        self.unread -= 1;
        Some(u32::from(self.data[self.at - 1] >> self.unread & 1))
    }

    fn receive(&mut self, count: u32) -> Option<i32> {
        (0..count).try_fold(0, |number, _| Some(number << 1 | self.bit()? as i32))
    }

    fn golomb(&mut self, k: u32, longest: u32, qbpp: u32, escaped: fn(i32) -> i32) -> Option<i32> {
        let mut zeros = 0;
        while self.bit()? == 0 {
            zeros += 1;
            // Some take one zero too many for an escape too, some give up.
            if zeros > longest + qbpp + 1 {
                return None;
            }
        }
        match zeros < longest {
            true => Some((zeros as i32) << k | self.receive(k)?),
            false => Some(escaped(self.receive(qbpp)?)),
        }
    }
}

/// A decoder with these rules in the middle of a scan.
struct Decoder<'a> {
    rules: &'a Rules,
    scan: Scan,
    bits: Bits<'a>,
    plane: Plane,
    /// By number of context; a slip may make more of them.
    contexts: Vec<Context>,
    /// A, Nn in place of B, and N, by `RItype`.
    run_contexts: [Context; 2],
    run_index: usize,
}

/// What is stored of a scan: its presets, NEAR, and where its data begin.
pub(in crate::diagnose) type Stored = (PresetParameters, i32, usize);

/// What is stored of the scan of a stream.
pub(in crate::diagnose) fn stored(stream: &PlaneStream) -> Option<Stored> {
    stored_scan(stream.bytes, stream.size.width, stream.size.height).ok()
}

impl Scan {
    fn of(presets: &PresetParameters, near: i32, rules: &Rules) -> Scan {
        let maxval = if presets.maxval == 0 {
            255
        } else {
            i32::from(presets.maxval)
        };
        let stored = [presets.t1, presets.t2, presets.t3].map(i32::from);
        let range = (rules.range)(maxval, near);
        let qbpp = (rules.qbpp)(range);
        Scan {
            maxval,
            near,
            step: 2 * near + 1,
            thresholds: (rules.thresholds)(stored, maxval, near),
            reset: (rules.reset)(presets.reset.into()),
            range,
            qbpp,
            limit: (rules.limit)(maxval, qbpp).saturating_add_signed(rules.limit_off),
        }
    }
}

/// What a decoder may keep from one stream to the next: presets, and the state of the scan.
pub(in crate::diagnose) struct Kept {
    presets: PresetParameters,
    contexts: Vec<Context>,
    run_contexts: [Context; 2],
    run_index: usize,
}

/// The samples of a stream, as a decoder with these rules finds them until it loses its way, or until one is not as it was
/// shown. `kept` is of the stream before.
pub(in crate::diagnose) fn decode(
    stream: &PlaneStream,
    &(presets, near, at): &Stored,
    rules: &Rules,
    kept: &mut Option<Kept>,
    is_shown: IsShown,
) -> Partial {
    let before = kept.take();
    let presets = match &before {
        Some(before) => (rules.keep_presets)(before.presets, presets),
        None => presets,
    };
    let scan = Scan::of(&presets, (rules.near)(near), rules);
    let fresh = Context {
        a: (rules.initial_a)(scan.range),
        b: 0,
        c: 0,
        n: 1,
    };
    let fresh_run = Context {
        b: rules.initial_negative,
        ..fresh
    };
    let (is_kept, is_run_kept, is_index_kept) = rules.keeps;
    let kept_contexts = before.as_ref().filter(|_| is_kept);
    let kept_runs = before.as_ref().filter(|_| is_run_kept);
    let kept_index = before.as_ref().filter(|_| is_index_kept);
    let mut decoder = Decoder {
        rules,
        scan,
        bits: Bits {
            data: &stream.bytes[at..],
            at: 0,
            unread: 0,
            rules,
        },
        plane: Plane {
            width: stream.size.width as usize,
            samples: Vec::with_capacity(stream.size.texels()),
        },
        contexts: kept_contexts.map_or_else(|| vec![fresh; 730], |kept| kept.contexts.clone()),
        run_contexts: kept_runs.map_or([fresh_run; 2], |kept| kept.run_contexts),
        run_index: kept_index.map_or(0, |kept| kept.run_index),
    };
    let partial = decoder.all(stream, is_shown);
    *kept = Some(Kept {
        presets,
        contexts: decoder.contexts,
        run_contexts: decoder.run_contexts,
        run_index: decoder.run_index,
    });
    partial
}

/// Bytes that may stand after the last one of the data: a marker, and padding.
const AFTER: usize = 3;

impl Decoder<'_> {
    fn all(&mut self, stream: &PlaneStream, is_shown: IsShown) -> Partial {
        let mut is_other = false;
        for row in 0..stream.size.height as usize {
            let is_whole = self.row(row).is_some();
            let start = row * self.plane.width;
            let new = self.plane.samples.iter().enumerate().skip(start);
            is_other = { new }.any(|(place, &sample)| !is_shown(place, sample as u8));
            if is_other || !is_whole {
                break;
            }
        }
        let samples = self.plane.samples.iter().map(|&sample| sample as u8);
        let mut samples: Vec<u8> = samples.collect();
        let known = samples.len();
        samples.resize(stream.size.texels(), 0);
        Partial {
            is_other,
            may_refuse: known < samples.len() || self.bits.data.len() > self.bits.at + AFTER,
            samples,
            known,
        }
    }

    fn row(&mut self, row: usize) -> Option<()> {
        let end = (row + 1) * self.plane.width;
        self.run_index = (self.rules.start_row)(self.run_index);
        while self.plane.samples.len() < end {
            let column = self.plane.samples.len() - row * self.plane.width;
            let mut neighbors = (self.rules.neighbors)(&self.plane, row, column);
            let gradients = (self.rules.gradients)(neighbors);
            let regions = gradients.map(|gradient| (self.rules.region)(&self.scan, gradient));
            let sample = if (self.rules.is_run)(&self.scan, regions, gradients) {
                let left = end - self.plane.samples.len();
                let [pieces, run] = self.run(left)?;
                for i in 0..run {
                    self.plane
                        .samples
                        .push(match self.rules.is_piece_of_above && i < pieces {
                            true => self.plane.above(row, (column + i) as isize),
                            false => neighbors[0],
                        });
                }
                if run == left {
                    break;
                }
                let [a, early_b, ..] = neighbors;
                neighbors = (self.rules.neighbors)(&self.plane, row, column + run);
                let b = if self.rules.is_early_b {
                    early_b
                } else {
                    neighbors[1]
                };
                self.interruption(a, b)?
            } else {
                self.regular(neighbors, regions)?
            };
            // A picture in bytes.
            self.plane.samples.push(sample & 0xff);
        }
        Some(())
    }

    fn regular(&mut self, neighbors: [i32; 4], regions: [i32; 3]) -> Option<i32> {
        let (rules, scan) = (self.rules, &self.scan);
        let (place, sign) = (rules.context)(regions);
        let context = self.contexts.get_mut(place as usize)?;
        let predicted = (rules.correct)((rules.predict)(neighbors), sign, context.c);
        let predicted = (rules.limit_prediction)(predicted, scan.maxval);
        let k = (rules.regular_k)((rules.golomb)(context.a, context.n));
        let longest = (rules.longest)(scan.limit, scan.qbpp);
        let mapped = self
            .bits
            .golomb(k, longest, (rules.escape_bits)(scan.qbpp), rules.escaped)?;
        let mut error = (rules.error)(mapped);
        if (rules.is_negative_first)(k, scan.near, context.b, context.n) {
            error = -1 - error;
        }
        if error.abs() > 1 << 9 {
            return None;
        }
        let is_full = (rules.is_full)(context.n, scan.reset);
        if rules.is_halved_first && is_full {
            context.halve(rules);
        }
        context.b = (rules.store_b)(context.b + (rules.learn_b)(error, scan.step));
        context.a = (rules.store_a)(context.a + (rules.learn_a)(error, scan.step));
        if !rules.is_halved_first && is_full {
            context.halve(rules);
        }
        context.n += 1;
        (context.b, context.c) = (rules.correction)(context.b, context.c, context.n);
        context.c = context.c.clamp(rules.c_limits.0, rules.c_limits.1);
        Some((rules.reconstruct)(scan, predicted, sign * error))
    }

    /// The samples of whole pieces of a run, and of all of it.
    fn run(&mut self, left: usize) -> Option<[usize; 2]> {
        let mut run = 0;
        while self.bits.bit()? == 1 {
            let piece = self.rules.piece(self.run_index);
            if run + piece > left {
                let index = self
                    .run_index
                    .saturating_add_signed(self.rules.partial_counts);
                self.run_index = index.min(self.rules.most_run_index);
                return Some([left; 2]);
            }
            run += piece;
            let adds = if run == left {
                self.rules.full_counts
            } else {
                1
            };
            let index = self.run_index.saturating_add_signed(adds);
            self.run_index = index.min(self.rules.most_run_index);
            if run == left {
                return Some([left; 2]);
            }
        }
        let all = run + self.bits.receive(self.rules.j(self.run_index))? as usize;
        (all < left).then_some([run, all])
    }

    fn interruption(&mut self, a: i32, b: i32) -> Option<i32> {
        let (rules, scan) = (self.rules, &self.scan);
        if rules.is_shortened_first {
            self.run_index = (rules.shorten)(self.run_index);
        }
        let alike = (rules.is_alike)(a - b, scan.near);
        let kind = i32::from(alike);
        let shared = self.run_contexts[0].a;
        let context = &mut self.run_contexts[kind as usize];
        let sum = if rules.is_run_a_shared {
            shared
        } else {
            context.a
        };
        let k = (rules.run_golomb)((rules.run_sum)(sum, context.n, kind), context.n);
        let limit = (rules.run_limit)(scan.limit, rules.j(self.run_index));
        let longest = (rules.longest)(limit, scan.qbpp);
        let number = self
            .bits
            .golomb(k, longest, (rules.escape_bits)(scan.qbpp), rules.escaped)?;
        let doubled = (rules.doubled)(number, kind);
        let magnitude = (doubled + 1) >> 1;
        let is_favored = doubled & 1 == 1;
        let is_positive = (rules.is_positive_favored)(k, scan.near, context.b, context.n);
        let error = if is_favored == is_positive {
            magnitude
        } else {
            -magnitude
        };
        if error.abs() > 1 << 9 {
            return None;
        }
        let sign = (rules.run_sign)(alike, a, b);
        context.b += i32::from((rules.is_negative)(error, sign * error));
        context.a = (rules.store_a)(context.a + (rules.run_growth)(number, kind, error));
        if (rules.is_run_full)(context.n, scan.reset) {
            context.a = (rules.halve_a)(context.a);
            context.b = (rules.halve_negative)(context.b);
            context.n >>= 1;
        }
        context.n += 1;
        if !rules.is_shortened_first {
            self.run_index = (rules.shorten)(self.run_index);
        }
        Some((rules.reconstruct_interrupted)(
            scan,
            (rules.interrupted)(alike, a, b),
            sign * error,
        ))
    }
}

/// A stream of JPEG-LS with this slip, and 0 for what is not known.
fn slipped(stream: &PlaneStream, slip: fn(&mut Rules)) -> Result<Vec<u8>> {
    let mut rules = RIGHT;
    slip(&mut rules);
    let partial = match stored(stream) {
        Some(stored) => decode(stream, &stored, &rules, &mut None, &|_, _| true),
        None => Partial::right(stream)?,
    };
    Ok(partial.samples)
}

macro_rules! wrong_entries {
    ($($index:literal)*) => {
        slips! {in "the table J of runs (T.87 A.7.1.1)": $(
            concat!("has a J[", $index, "] that is one too large"), |r| r.typo = ($index, 1, true, true);
            concat!("has a J[", $index, "] that is one too small"), |r| r.typo = ($index, -1, true, true);
            concat!("takes twice 2^J for a whole piece of a run at RUNindex ", $index), |r| r.typo = ($index, 1, true, false);
            concat!("takes half of 2^J for a whole piece of a run at RUNindex ", $index), |r| r.typo = ($index, -1, true, false);
            concat!("reads one bit too many for the rest of a run at RUNindex ", $index), |r| r.typo = ($index, 1, false, true);
            concat!("reads one bit too few for the rest of a run at RUNindex ", $index), |r| r.typo = ($index, -1, false, true);
        )*}
    };
}

/// One wrong entry in the table J.
static WRONG_ENTRIES: &[Slip<Rules>] = wrong_entries!(4 5 6 7 8 9 10 11 12 13 14 15 16 17);

macro_rules! c_limits {
    ($($least:literal $most:literal)*) => {
        slips! {in "the limits of C, −128 … 127 (T.87 A.6.2)": $(
            concat!("limits C to ", $least, "…", $most), |r| r.c_limits = ($least, $most);
        )*}
    };
}

/// Other limits of C.
static C_LIMITS: &[Slip<Rules>] = c_limits!(-8 8 -5 5 -3 3 -2 2 -1 1 -10 127 -128 10 -10 10 -20 127 -128 20 -50 127 -128 50 -100 127 -128 100 -4 127 -128 4 -4 4 -8 127 -128 8 -16 127 -128 16 -32 127 -128 32 -64 127 -128 64 -128 0 0 127 -7 7 -8 7 -15 15 -16 15 -31 31 -32 31 -63 63 -64 63 -127 127 -128 126 -100 100 -32 32 -64 64 -16 16);

macro_rules! factors {
    ($name:literal $place:literal $right:literal: $($factor:literal)*) => {
        slips! {in "the default thresholds (T.87 C.2.4.1.1)": $(
            concat!("computes the default ", $name, " with ", $factor, "·NEAR where ", $right, "·NEAR belongs"),
            |r| r.thresholds = |s, m, n| defaults(s, m, n, |wanted| wanted[$place] += ($factor - $right) * n);
        )*}
    };
}

/// The thresholds with other defaults, which are still kept within their limits.
fn defaults(stored: [i32; 3], maxval: i32, near: i32, change: impl Fn(&mut [i32; 3])) -> [i32; 3] {
    let mut wanted = wanted_thresholds(maxval, near);
    change(&mut wanted);
    let defaults = limited_thresholds(wanted, maxval, near);
    [0, 1, 2].map(|i| {
        if stored[i] == 0 {
            defaults[i]
        } else {
            stored[i]
        }
    })
}

/// The thresholds with these defaults in the place of their own.
fn with_defaults(stored: [i32; 3], maxval: i32, near: i32, own: [Option<i32>; 3]) -> [i32; 3] {
    let defaults = default_thresholds(maxval, near);
    [0, 1, 2].map(|i| match stored[i] {
        0 => own[i].unwrap_or(defaults[i]),
        stored => stored,
    })
}

macro_rules! constants {
    ($where:literal $holds:expr; $($name:literal $place:literal: $($number:literal)*;)*) => {
        slips! {in "the default thresholds (T.87 C.2.4.1.1)": $($(
            concat!("takes ", $number, " for the default ", $name, $where), |r| r.thresholds = |s, m, n| {
                let holds: fn(i32) -> bool = $holds;
                let mut own = [None; 3];
                own[$place] = holds(n).then_some($number);
                with_defaults(s, m, n, own)
            };
        )*)*}
    };
}

/// Defaults that are one number.
static CONSTANTS: &[Slip<Rules>] =
    constants!(", whatever NEAR is" |_| true; "T1" 0: 2 3 4; "T2" 1: 6 7 8; "T3" 2: 20 21 22;);

/// Wrong ones of lossless streams alone.
static LOSSLESS_CONSTANTS: &[Slip<Rules>] =
    constants!(" where NEAR is 0" |near| near == 0; "T1" 0: 2 4; "T2" 1: 6 8; "T3" 2: 20 22;);

/// Other factors of NEAR.
const FACTORS: [&[Slip<Rules>]; 3] = [
    factors!("T1" 0 3: 0 1 2 4 5 6 7),
    factors!("T2" 1 5: 0 1 2 3 4 6 7 8),
    factors!("T3" 2 7: 0 1 2 3 4 5 6 8 9),
];

macro_rules! bases {
    ($name:literal $place:literal $of_near:literal: $($own:literal $off:literal $words:literal)*) => {
        slips! {in "the default thresholds (T.87 C.2.4.1.1)": $(
            concat!("takes a default ", $name, " that is ", $words), |r| r.thresholds = |s, m, n| {
                let mut all = thresholds(s, m, n);
                if s[$place] == 0 { all[$place] += $off }
                all
            };
            concat!("takes a default ", $name, " that is ", $words, ", and then keeps it within its limits"),
            |r| r.thresholds = |s, m, n| defaults(s, m, n, |wanted| wanted[$place] += $off);
            concat!("takes ", $own, " + ", $of_near, "·NEAR for the default ", $name, ", without limits"),
            |r| r.thresholds = |s, m, n| {
                let mut own = [None; 3];
                own[$place] = Some($own + $of_near * n);
                with_defaults(s, m, n, own)
            };
        )*}
    };
}

/// Defaults that are off by one number.
const BASES: [&[Slip<Rules>]; 3] = [
    bases!("T1" 0 3: 1 -2 "2 too small" 2 -1 "1 too small" 4 1 "1 too large" 5 2 "2 too large"),
    bases!("T2" 1 5: 5 -2 "2 too small" 6 -1 "1 too small" 8 1 "1 too large" 9 2 "2 too large"),
    bases!("T3" 2 7: 19 -2 "2 too small" 20 -1 "1 too small" 22 1 "1 too large" 23 2 "2 too large"),
];

macro_rules! limits {
    ($($off:literal $words:literal)*) => {
        slips! {in "LIMIT, 2·(bpp + max(8, bpp)) (T.87 A.2.1)": $(
            concat!("takes a LIMIT that is ", $words), |r| r.limit_off = $off;
        )*}
    };
}

/// Other numbers for LIMIT.
static LIMITS: &[Slip<Rules>] = limits!(-8 "8 too small" -4 "4 too small" -2 "2 too small" -1 "1 too small" 1 "1 too large" 2 "2 too large" 4 "4 too large" 8 "8 too large");

/// The same, where the error is not multiplied by 2·NEAR + 1.
fn unscaled(scan: &Scan, predicted: i32, error: i32) -> i32 {
    within(scan, scan.range * scan.step, predicted + error).clamp(0, scan.maxval)
}

/// Other samples in regular mode and at the end of runs.
fn both(rules: &mut Rules, reconstruct: fn(&Scan, i32, i32) -> i32) {
    rules.reconstruct = reconstruct;
    rules.reconstruct_interrupted = reconstruct;
}

/// The neighborhood with another a in the first column.
fn with_a(plane: &Plane, row: usize, column: usize, a: i32) -> [i32; 4] {
    let [right, b, c, d] = plane.neighbors(row, column);
    [if column == 0 { a } else { right }, b, c, d]
}

/// With another c in the first column.
fn with_c(plane: &Plane, row: usize, column: usize, c: i32) -> [i32; 4] {
    let [a, b, right, d] = plane.neighbors(row, column);
    [a, b, if column == 0 { c } else { right }, d]
}

/// With another d in the last column.
fn with_d(plane: &Plane, row: usize, column: usize, d: i32) -> [i32; 4] {
    let [a, b, c, right] = plane.neighbors(row, column);
    [a, b, c, if column + 1 == plane.width { d } else { right }]
}

/// With b, c and d as signed bytes.
fn with_signed_row_above(plane: &Plane, row: usize, column: usize) -> [i32; 4] {
    let [a, b, c, d] = plane.neighbors(row, column);
    [a, signed_byte(b), signed_byte(c), signed_byte(d)]
}

/// All lists.
pub(in crate::diagnose) static LISTS: &[&[Slip<Rules>]] = &[
    SLIPS,
    FACTORS[0],
    FACTORS[1],
    FACTORS[2],
    BASES[0],
    BASES[1],
    BASES[2],
    CONSTANTS,
    LOSSLESS_CONSTANTS,
    LIMITS,
    C_LIMITS,
    WRONG_ENTRIES,
];

static SLIPS: &[Slip<Rules>] = slips! {
    in "the template (T.87 A.2.1, A.3.1)":
    "takes 0 for a (Ra) in the first column, where the sample above belongs", |r| r.neighbors = |p, y, x| with_a(p, y, x, 0);
    "takes the last sample of the row above for a (Ra) in the first column, where the first one belongs", |r| r.neighbors = |p, y, x| with_a(p, y, x, p.above(y, p.width as isize - 1));
    "takes c for a (Ra) in the first column, where the sample above belongs", |r| r.neighbors = |p, y, x| with_a(p, y, x, p.neighbors(y, 0)[2]);
    "takes the second sample of the row above for a (Ra) in the first column", |r| r.neighbors = |p, y, x| with_a(p, y, x, p.above(y, 1));
    "takes 0 for c (Rc) in the first column, where a of the row above belongs", |r| r.neighbors = |p, y, x| with_c(p, y, x, 0);
    "takes 0 for d (Rd) in the last column from the third row on, where b belongs", |r| r.neighbors = |p, y, x| if y > 1 { with_d(p, y, x, 0) } else { p.neighbors(y, x) };
    "takes the last sample two rows above for d (Rd) in the last column, where b belongs", |r| r.neighbors = |p, y, x| with_d(p, y, x, if y > 1 { p.above(y - 1, p.width as isize - 1) } else { 0 });
    "takes 0 for a (Ra) in the first column from the third row on, where the sample above belongs", |r| r.neighbors = |p, y, x| if y > 1 { with_a(p, y, x, 0) } else { p.neighbors(y, x) };
    "takes the sample above for c (Rc) in the first column, where a of the row above belongs", |r| r.neighbors = |p, y, x| with_c(p, y, x, p.above(y, 0));
    "takes the last sample of the row two above for c (Rc) in the first column", |r| r.neighbors = |p, y, x| with_c(p, y, x, p.above(y, -1));
    "takes 0 for d (Rd) in the last column, where b belongs", |r| r.neighbors = |p, y, x| with_d(p, y, x, 0);
    "takes the first sample of the same row for d (Rd) in the last column, where b belongs", |r| r.neighbors = |p, y, x| with_d(p, y, x, p.flat(y, 0));
    "takes the first sample of the row above for d (Rd) in the last column, where b belongs", |r| r.neighbors = |p, y, x| with_d(p, y, x, p.above(y, 0));
    "takes c for d (Rd) in the last column, where b belongs", |r| r.neighbors = |p, y, x| with_d(p, y, x, p.neighbors(y, x)[2]);
    "takes a for d (Rd) in the last column, where b belongs", |r| r.neighbors = |p, y, x| with_d(p, y, x, p.neighbors(y, x)[0]);
    "takes b for d (Rd) in the last two columns", |r| r.neighbors = |p, y, x| { let [a, b, c, d] = p.neighbors(y, x); [a, b, c, if x + 2 >= p.width { b } else { d }] };
    "takes b for d (Rd) everywhere", |r| r.neighbors = |p, y, x| { let [a, b, c, _] = p.neighbors(y, x); [a, b, c, b] };
    "takes 128 for the row above the first, where 0 belongs", |r| r.neighbors = |p, y, x| { let [a, b, c, d] = p.neighbors(y, x); if y == 0 { [if x == 0 { 128 } else { a }, 128, 128, 128] } else { [a, b, c, d] } };
    "takes 128 for the row above the first and for the sample to its left, where 0 belongs", |r| r.neighbors = |p, y, x| { let [a, b, c, d] = p.neighbors(y, x); match (y, x) { (0, _) => [if x == 0 { 128 } else { a }, 128, 128, 128], (1, 0) => [a, b, 128, d], _ => [a, b, c, d] } };
    "takes 0 for a (Ra) and c (Rc) in the first column, where samples above belong", |r| r.neighbors = |p, y, x| { let [a, b, c, d] = p.neighbors(y, x); if x == 0 { [0, b, 0, d] } else { [a, b, c, d] } };
    "takes c for d (Rd) in the last column of planes of two columns or more, where b belongs", |r| r.neighbors = |p, y, x| { let [_, b, c, _] = p.neighbors(y, x); with_d(p, y, x, if p.width > 1 { c } else { b }) };
    "keeps the row above in signed bytes", |r| r.neighbors = |p, y, x| { let [a, b, c, d] = with_signed_row_above(p, y, x); [if x == 0 { signed_byte(a) } else { a }, b, c, d] };
    "keeps the row above in signed bytes, but not for a (Ra) in the first column", |r| r.neighbors = with_signed_row_above;
    "takes a for b, c and d in the first row, where 0 belongs", |r| r.neighbors = |p, y, x| { let all = p.neighbors(y, x); if y == 0 { [all[0]; 4] } else { all } };
    in "gradients and contexts (T.87 A.3)":
    "computes the gradient d − b as d − a", |r| r.gradients = |[a, b, c, d]| [d - a, b - c, c - a];
    "computes the gradient b − c as b − a", |r| r.gradients = |[a, b, c, d]| [d - b, b - a, c - a];
    "computes the gradient c − a as b − a", |r| r.gradients = |[a, b, c, d]| [d - b, b - c, b - a];
    "computes the gradient d − b as d − c", |r| r.gradients = |[a, b, c, d]| [d - c, b - c, c - a];
    "computes the gradient c − a as a − c", |r| r.gradients = |[a, b, c, d]| [d - b, b - c, a - c];
    "computes the gradient b − c as c − b", |r| r.gradients = |[a, b, c, d]| [d - b, c - b, c - a];
    "computes the gradient d − b as b − d", |r| r.gradients = |[a, b, c, d]| [b - d, b - c, c - a];
    "exchanges the gradients b − c and c − a", |r| r.gradients = |[a, b, c, d]| [d - b, c - a, b - c];
    "exchanges the gradients d − b and b − c", |r| r.gradients = |[a, b, c, d]| [b - c, d - b, c - a];
    "exchanges the gradients d − b and c − a", |r| r.gradients = |[a, b, c, d]| [c - a, b - c, d - b];
    "numbers contexts by 81·Q1 + 8·Q2 + Q3, where 9·Q2 belongs", |r| r.context = |q| { let sign = number(q).1; let [q1, q2, q3] = q.map(|q| sign * q); ((81 * q1 + 8 * q2 + q3).max(0), sign) };
    "numbers contexts by 80·Q1 + 9·Q2 + Q3, where 81·Q1 belongs", |r| r.context = |q| { let sign = number(q).1; let [q1, q2, q3] = q.map(|q| sign * q); ((80 * q1 + 9 * q2 + q3).max(0), sign) };
    "compares negative gradients with the thresholds by < −T where ≤ −T belongs", |r| r.region = |s, g| region(s, if g < 0 { (g + 1).min(0) } else { g });
    "compares negative gradients with T3 by < −T3 where ≤ −T3 belongs", |r| r.region = |s, g| if g == -s.thresholds[2] { region(s, g + 1) } else { region(s, g) };
    "compares negative gradients with T2 by < −T2 where ≤ −T2 belongs", |r| r.region = |s, g| if g == -s.thresholds[1] { region(s, g + 1) } else { region(s, g) };
    "compares negative gradients with T1 by < −T1 where ≤ −T1 belongs", |r| r.region = |s, g| if g == -s.thresholds[0] { region(s, g + 1) } else { region(s, g) };
    "compares positive gradients with the thresholds by > T where ≥ T belongs", |r| r.region = |s, g| region(s, if g > 0 && s.thresholds.contains(&g) { g - 1 } else { g });
    "compares positive gradients with T3 by > T3 where ≥ T3 belongs", |r| r.region = |s, g| if g == s.thresholds[2] { region(s, g - 1) } else { region(s, g) };
    "compares positive gradients with T2 by > T2 where ≥ T2 belongs", |r| r.region = |s, g| if g == s.thresholds[1] { region(s, g - 1) } else { region(s, g) };
    "compares positive gradients with T1 by > T1 where ≥ T1 belongs", |r| r.region = |s, g| if g == s.thresholds[0] { region(s, g - 1) } else { region(s, g) };
    "compares all gradients with the thresholds by > T where ≥ T belongs", |r| r.region = |s, g| region(s, if s.thresholds.contains(&g.abs()) { g - g.signum() } else { g });
    "takes gradients of ±NEAR for other than flat", |r| r.region = |s, g| if s.near > 0 && g.abs() == s.near { g.signum() } else { region(s, g) };
    "takes positive gradients of NEAR for other than flat (< NEAR for ≤ NEAR)", |r| r.region = |s, g| if s.near > 0 && g == s.near { 1 } else { region(s, g) };
    "takes negative gradients of −NEAR for other than flat (< for ≤)", |r| r.region = |s, g| if s.near > 0 && g == -s.near { -1 } else { region(s, g) };
    "takes positive gradients of NEAR for other than flat, also where NEAR is 0", |r| r.region = |s, g| if g == s.near { 1 } else { region(s, g) };
    "takes gradients of NEAR − 1 at the most for flat, also where NEAR is 0", |r| r.region = |s, g| if g == s.near || g == -s.near { if g < 0 { -1 } else { 1 } } else { region(s, g) };
    "takes only gradients of 0 for flat, whatever NEAR is", |r| r.region = |s, g| if g != 0 && g.abs() <= s.near { g.signum() } else { region(s, g) };
    "goes into run mode only where all gradients are 0, whatever NEAR is", |r| r.is_run = |_, _, g| g == [0; 3];
    "takes gradients within NEAR for other than flat, but not where it looks for runs", |r| { r.region = |s, g| if g != 0 && g.abs() <= s.near { g.signum() } else { region(s, g) }; r.is_run = |s, _, g| g.iter().all(|g| g.abs() <= s.near); };
    "goes into run mode without looking at the gradient d − b", |r| r.is_run = |_, q, _| q[1] == 0 && q[2] == 0;
    "goes into run mode without looking at the gradient c − a", |r| r.is_run = |_, q, _| q[0] == 0 && q[1] == 0;
    "never mirrors the neighborhood (no SIGN)", |r| r.context = |[q1, q2, q3]| (81 * (q1 + 4) + 9 * (q2 + 4) + q3 + 4, 1);
    "mirrors the neighborhood by the first gradient alone", |r| r.context = |q| if q[0] < 0 { (number(q).0, -1) } else { (81 * q[0] + 9 * (q[1] + 4) + q[2] + 4, 1) };
    "does not mirror the neighborhood where only the last gradient is other than 0 and negative", |r| r.context = |q| if q[0] == 0 && q[1] == 0 && q[2] < 0 { (364 - q[2], 1) } else { number(q) };
    "does not turn the sign where only the last gradient is other than 0 and negative", |r| r.context = |q| { let (place, sign) = number(q); (place, if q[0] == 0 && q[1] == 0 { 1 } else { sign }) };
    "does not mirror the neighborhood where the first gradient is 0 and the second negative", |r| r.context = |q| if q[0] == 0 && q[1] < 0 { (400 + 9 * -q[1] + q[2] + 4, 1) } else { number(q) };
    in "thresholds and other parameters (T.87 A.2.1, C.2.4.1.1)":
    "ignores the thresholds of an LSE segment", |r| r.thresholds = |_, maxval, near| thresholds([0; 3], maxval, near);
    "computes the default thresholds as if NEAR were 0", |r| r.thresholds = |stored, maxval, _| thresholds(stored, maxval, 0);
    "takes 3, 7 and 21 for the default thresholds, whatever NEAR is", |r| r.thresholds = |s, maxval, near| with_defaults(s, maxval, near, [Some(3), Some(7), Some(21)]);
    "computes all default thresholds with 3·NEAR", |r| r.thresholds = |stored, maxval, near| { let t = thresholds([0; 3], maxval, near); let own = [t[0], t[1] - 2 * near, t[2] - 4 * near]; [0, 1, 2].map(|i| if stored[i] == 0 { own[i] } else { stored[i] }) };
    "takes the two lowest bits of NEAR", |r| r.near = |near| near & 3;
    "takes the three lowest bits of NEAR", |r| r.near = |near| near & 7;
    "takes the four lowest bits of NEAR", |r| r.near = |near| near & 15;
    "takes 0 for NEAR", |r| r.near = |_| 0;
    "takes 1 for every NEAR over 0", |r| r.near = |near| near.min(1);
    "takes NEAR to be one larger where it is over 0", |r| r.near = |near| near + i32::from(near > 0);
    "takes NEAR to be one smaller where it is over 0", |r| r.near = |near| (near - 1).max(0);
    "takes the seven lowest bits of T3 of an LSE segment", |r| r.thresholds = |[a, b, c], maxval, near| thresholds([a, b, c & 127], maxval, near);
    "takes the seven lowest bits of each threshold of an LSE segment", |r| r.thresholds = |stored, maxval, near| thresholds(stored.map(|t| t & 127), maxval, near);
    "takes the seven lowest bits of RESET", |r| r.reset = |stored| if stored == 0 { 64 } else { stored & 127 };
    "takes the six lowest bits of RESET", |r| r.reset = |stored| if stored == 0 { 64 } else { stored & 63 };
    "uses a RESET of 64, whatever an LSE segment says", |r| r.reset = |_| 64;
    "computes RANGE as MAXVAL / (2·NEAR + 1) + 1, without 2·NEAR above the line", |r| r.range = |maxval, near| maxval / (2 * near + 1) + 1;
    "computes RANGE one too small where NEAR is over 0: (MAXVAL + 2·NEAR) / (2·NEAR + 1), without + 1", |r| r.range = |maxval, near| (maxval + 2 * near) / (2 * near + 1) + i32::from(near == 0);
    "computes RANGE as MAXVAL / (2·NEAR + 1) where (MAXVAL + 2·NEAR) / (2·NEAR + 1) + 1 belongs, if NEAR is over 0", |r| r.range = |maxval, near| maxval / (2 * near + 1) + i32::from(near == 0);
    "computes RANGE one too large where NEAR is over 0", |r| r.range = |maxval, near| (maxval + 2 * near) / (2 * near + 1) + 1 + i32::from(near > 0);
    "computes RANGE with NEAR above the line, where 2·NEAR belongs", |r| r.range = |maxval, near| (maxval + near) / (2 * near + 1) + 1;
    "uses stored thresholds only where none of the three is 0", |r| r.thresholds = |stored, maxval, near| thresholds(if stored.contains(&0) { [0; 3] } else { stored }, maxval, near);
    "takes thresholds of 0 in an LSE segment for 0, where the default belongs", |r| r.thresholds = |stored, maxval, near| if stored == [0; 3] { thresholds(stored, maxval, near) } else { stored };
    "reads T3 of an LSE segment before T2", |r| r.thresholds = |[a, b, c], maxval, near| thresholds([a, c, b], maxval, near);
    "reads T2 of an LSE segment before T1", |r| r.thresholds = |[a, b, c], maxval, near| thresholds([b, a, c], maxval, near);
    "reads T1, T2 and T3 of an LSE segment in reverse order", |r| r.thresholds = |[a, b, c], maxval, near| thresholds([c, b, a], maxval, near);
    "ignores T1 of an LSE segment", |r| r.thresholds = |[_, b, c], maxval, near| thresholds([0, b, c], maxval, near);
    "ignores T2 of an LSE segment", |r| r.thresholds = |[a, _, c], maxval, near| thresholds([a, 0, c], maxval, near);
    "ignores T3 of an LSE segment", |r| r.thresholds = |[a, b, _], maxval, near| thresholds([a, b, 0], maxval, near);
    "takes T2 of an LSE segment for T3 too", |r| r.thresholds = |[a, b, _], maxval, near| thresholds([a, b, b], maxval, near);
    "takes T1 of an LSE segment for T2 too", |r| r.thresholds = |[a, _, c], maxval, near| thresholds([a, a, c], maxval, near);
    "takes the thresholds of an LSE segment for signed bytes", |r| r.thresholds = |stored, maxval, near| thresholds(stored.map(signed_byte), maxval, near);
    "limits default thresholds over MAXVAL to MAXVAL, where the threshold before belongs", |r| r.thresholds = |stored, maxval, near| { let mut least = near + 1; let own = wanted_thresholds(maxval, near).map(|t| { least = if t < least { least } else { t.min(maxval) }; Some(least) }); with_defaults(stored, maxval, near, own) };
    "takes 63 for the default RESET", |r| r.reset = |stored| if stored == 0 { 63 } else { stored };
    "takes 65 for the default RESET", |r| r.reset = |stored| if stored == 0 { 65 } else { stored };
    "takes 32 for the default RESET", |r| r.reset = |stored| if stored == 0 { 32 } else { stored };
    "takes 128 for the default RESET", |r| r.reset = |stored| if stored == 0 { 128 } else { stored };
    "uses only the stored T1, and computes T2 and T3", |r| r.thresholds = |stored, maxval, near| thresholds([stored[0], 0, 0], maxval, near);
    "uses default thresholds, whatever an LSE segment says", |r| r.thresholds = |_, maxval, near| thresholds([0; 3], maxval, near);
    "takes 256 for RANGE, whatever NEAR is", |r| r.range = |_, _| 256;
    "takes 255 for RANGE, whatever NEAR is", |r| r.range = |_, _| 255;
    "computes RANGE one too small: (MAXVAL + 2·NEAR) / (2·NEAR + 1), without + 1", |r| r.range = |maxval, near| (maxval + 2 * near) / (2 * near + 1);
    "takes 8 for qbpp, whatever RANGE is", |r| r.qbpp = |_| 8;
    "computes qbpp one too small where RANGE is no power of two", |r| r.qbpp = |range| range.max(2).ilog2();
    "takes 24 for LIMIT", |r| r.limit = |_, _| 24;
    "takes 23 for LIMIT", |r| r.limit = |_, _| 23;
    "takes 16 for LIMIT", |r| r.limit = |_, _| 16;
    in "the prediction (T.87 A.4)":
    "exchanges min(a, b) and max(a, b) in the prediction", |r| r.predict = |[a, b, c, _]| if c >= a.max(b) { a.max(b) } else if c <= a.min(b) { a.min(b) } else { a + b - c };
    "predicts a + b − c, limited to 0…255, without looking for an edge", |r| r.predict = |[a, b, c, _]| (a + b - c).clamp(0, 255);
    "predicts a + b − c without looking for an edge", |r| r.predict = |[a, b, c, _]| a + b - c;
    "predicts a", |r| r.predict = |[a, ..]| a;
    "predicts b", |r| r.predict = |[_, b, ..]| b;
    "predicts the mean of a and b where there is no edge", |r| r.predict = |n| { let [a, b, c, _] = n; if c >= a.max(b) || c <= a.min(b) { predict(n) } else { i32::midpoint(a, b) } };
    "predicts the mean of a and b", |r| r.predict = |[a, b, ..]| i32::midpoint(a, b);
    "predicts by the edge only where c is at least as large as a and b", |r| r.predict = |[a, b, c, _]| if c >= a.max(b) { a.min(b) } else { a + b - c };
    "predicts by the edge only where c is at least as small as a and b", |r| r.predict = |[a, b, c, _]| if c <= a.min(b) { a.max(b) } else { a + b - c };
    "adds C to the prediction without SIGN", |r| r.correct = |predicted, _, c| predicted + c;
    "subtracts C from the prediction", |r| r.correct = |predicted, sign, c| predicted - sign * c;
    "does not correct the prediction by C", |r| r.correct = |predicted, _, _| predicted;
    "does not limit the corrected prediction", |r| r.limit_prediction = |predicted, _| predicted;
    "does not limit the corrected prediction to MAXVAL", |r| r.limit_prediction = |predicted, _| predicted.max(0);
    "does not limit the corrected prediction to 0", |r| r.limit_prediction = |predicted, maxval| predicted.min(maxval);
    in "the codes (T.87 A.5)":
    "starts with A one larger than max(2, (RANGE + 32) / 64)", |r| r.initial_a = |range| ((range + 32) / 64).max(2) + 1;
    "starts with A one smaller than max(2, (RANGE + 32) / 64)", |r| r.initial_a = |range| ((range + 32) / 64).max(2) - 1;
    "starts with A twice max(2, (RANGE + 32) / 64)", |r| r.initial_a = |range| ((range + 32) / 64).max(2) * 2;
    "starts with A = 2", |r| r.initial_a = |_| 2;
    "starts with A = 4, whatever RANGE is", |r| r.initial_a = |_| 4;
    "starts with A = (RANGE + 32) / 64, but not 2 at the least", |r| r.initial_a = |range| (range + 32) / 64;
    "starts with A = (RANGE + 32) / 64, and 1 at the least", |r| r.initial_a = |range| ((range + 32) / 64).max(1);
    "starts with A = (RANGE + 32) / 64, and 3 at the least", |r| r.initial_a = |range| ((range + 32) / 64).max(3);
    "starts with A = (RANGE + 64) / 64, and 2 at the least", |r| r.initial_a = |range| ((range + 64) / 64).max(2);
    "starts with A = (RANGE + 32) / 32, and 2 at the least", |r| r.initial_a = |range| ((range + 32) / 32).max(2);
    "starts with A = (RANGE + 32) / 128, and 2 at the least", |r| r.initial_a = |range| ((range + 32) / 128).max(2);
    "starts with A = RANGE / 64, and 3 at the least", |r| r.initial_a = |range| (range / 64).max(3);
    "starts with A = 3, whatever RANGE is", |r| r.initial_a = |_| 3;
    "starts with A = 5, whatever RANGE is", |r| r.initial_a = |_| 5;
    "starts with A = 6, whatever RANGE is", |r| r.initial_a = |_| 6;
    "starts with A = 8, whatever RANGE is", |r| r.initial_a = |_| 8;
    "starts with A = 0", |r| r.initial_a = |_| 0;
    "starts with A = 1", |r| r.initial_a = |_| 1;
    "computes k by N · 2^k > A where ≥ belongs", |r| { r.golomb = |a, n| golomb(a + 1, n); r.run_golomb = r.golomb; };
    "computes k by N · 2^k > A where ≥ belongs, in regular mode alone", |r| r.golomb = |a, n| golomb(a + 1, n);
    "computes k by N · 2^k > A where ≥ belongs, at the end of runs alone", |r| r.run_golomb = |a, n| golomb(a + 1, n);
    "computes k one too large", |r| { r.golomb = |a, n| golomb(a, n) + 1; r.run_golomb = r.golomb; };
    "limits k to 4 in regular mode", |r| r.regular_k = |k| k.min(4);
    "limits k to 5 in regular mode", |r| r.regular_k = |k| k.min(5);
    "limits k to 6 in regular mode", |r| r.regular_k = |k| k.min(6);
    "limits k to 4", |r| { r.golomb = |a, n| golomb(a, n).min(4); r.run_golomb = r.golomb; };
    "limits k to 5", |r| { r.golomb = |a, n| golomb(a, n).min(5); r.run_golomb = r.golomb; };
    "limits k to 6", |r| { r.golomb = |a, n| golomb(a, n).min(6); r.run_golomb = r.golomb; };
    "escapes after LIMIT − qbpp zeros where LIMIT − qbpp − 1 belongs", |r| r.longest = |limit, qbpp| limit.saturating_sub(qbpp);
    "escapes after LIMIT − qbpp − 2 zeros where LIMIT − qbpp − 1 belongs", |r| r.longest = |limit, qbpp| limit.saturating_sub(qbpp + 2);
    "never escapes: takes every code for zeros, a one and k bits", |r| r.longest = |_, _| 200;
    "escapes after LIMIT − 9 zeros, whatever qbpp is", |r| r.longest = |limit, _| limit.saturating_sub(9);
    "does not add 1 to an escaped number", |r| r.escaped = |number| number;
    "adds 2 to an escaped number where 1 belongs", |r| r.escaped = |number| number + 2;
    "lets negative errors come first for every NEAR (k = 0, 2B ≤ −N)", |r| r.is_negative_first = |k, _, b, n| k == 0 && 2 * b <= -n;
    "lets negative errors come first by 2B < −N where ≤ belongs", |r| r.is_negative_first = |k, near, b, n| k == 0 && near == 0 && 2 * b < -n;
    "lets negative errors come first by B ≤ −N where 2B belongs", |r| r.is_negative_first = |k, near, b, n| k == 0 && near == 0 && b <= -n;
    "lets negative errors come first for every k (2B ≤ −N)", |r| r.is_negative_first = |_, near, b, n| near == 0 && 2 * b <= -n;
    "never lets negative errors come first", |r| r.is_negative_first = |_, _, _, _| false;
    "always lets negative errors come first where k is 0", |r| r.is_negative_first = |k, near, _, _| k == 0 && near == 0;
    "takes odd numbers for positive errors and even ones for negative", |r| r.error = |m| if m & 1 == 1 { (m + 1) >> 1 } else { -(m >> 1) };
    "takes −(m / 2) for the error of an odd number m where −(m + 1) / 2 belongs", |r| r.error = |m| if m & 1 == 1 { -(m >> 1) } else { m >> 1 };
    "reads escaped numbers of 8 bits, whatever qbpp is", |r| r.escape_bits = |_| 8;
    "computes LIMIT of qbpp, where the bits of a sample belong", |r| r.limit = |_, qbpp| 2 * (qbpp + qbpp.max(8));
    in "what contexts learn (T.87 A.6)":
    "keeps A in one byte", |r| r.store_a = |a| a & 0xff;
    "keeps A in a signed byte", |r| r.store_a = signed_byte;
    "keeps B in a signed byte", |r| r.store_b = signed_byte;
    "halves the counters of a context at N > RESET where N = RESET belongs", |r| { r.is_full = |n, reset| n > reset; r.is_run_full = r.is_full; };
    "halves the counters of a context at N > RESET where N = RESET belongs, in regular mode alone", |r| r.is_full = |n, reset| n > reset;
    "halves the counters of a context of runs at N > RESET where N = RESET belongs", |r| r.is_run_full = |n, reset| n > reset;
    "halves the counters of a context one sample too early", |r| { r.is_full = |n, reset| n + 1 >= reset; r.is_run_full = r.is_full; };
    "halves the counters of a context one sample too early, in regular mode alone", |r| r.is_full = |n, reset| n + 1 >= reset;
    "halves the counters of a context of runs one sample too early", |r| r.is_run_full = |n, reset| n + 1 >= reset;
    "never halves the counters of a context", |r| { r.is_full = |_, _| false; r.is_run_full = r.is_full; };
    "never halves the counters of a context, in regular mode alone", |r| r.is_full = |_, _| false;
    "never halves the counters of a context of runs", |r| r.is_run_full = |_, _| false;
    "halves the counters of a context before it adds an error to them, in regular mode", |r| r.is_halved_first = true;
    "adds errors to A with the factor 2·NEAR + 1, which only B has", |r| r.learn_a = |error, step| error.abs() * step;
    "halves B toward 0 where it is rounded down", |r| r.halve_b = |b| b / 2;
    "does not halve B", |r| r.halve_b = |b| b;
    "does not halve A", |r| r.halve_a = |a| a;
    "rounds A up when it is halved", |r| r.halve_a = |a| (a + 1) >> 1;
    "adds errors to B without the factor 2·NEAR + 1", |r| r.learn_b = |error, _| error;
    "does not add errors to B", |r| r.learn_b = |_, _| 0;
    "adds the magnitude of errors to B", |r| r.learn_b = |error, step| error.abs() * step;
    "does not limit C", |r| r.correction = |b, c, n| if b <= -n { ((b + n).max(1 - n), c - 1) } else if b > 0 { ((b - n).min(0), c + 1) } else { (b, c) };
    "limits C to −127", |r| r.correction = |b, c, n| { let (b, c) = correction(b, c, n); (b, c.max(-127)) };
    "limits C to 128", |r| r.correction = |b, c, n| if b > 0 { ((b - n).min(0), (c + 1).min(128)) } else { correction(b, c, n) };
    "does not limit B after C took over (B > −N)", |r| r.correction = |b, c, n| if b <= -n { (b + n, (c - 1).max(-128)) } else { correction(b, c, n) };
    "does not limit B after C took over (B ≤ 0)", |r| r.correction = |b, c, n| if b > 0 { (b - n, (c + 1).min(127)) } else { correction(b, c, n) };
    "does not limit B after C took over", |r| r.correction = |b, c, n| if b <= -n { (b + n, (c - 1).max(-128)) } else if b > 0 { (b - n, (c + 1).min(127)) } else { (b, c) };
    "lowers C by B < −N where ≤ belongs", |r| r.correction = |b, c, n| if b == -n { (b, c) } else { correction(b, c, n) };
    "raises C by B > 1 where B > 0 belongs", |r| r.correction = |b, c, n| if b == 1 { (b, c) } else { correction(b, c, n) };
    "raises C by B ≥ 0 where > belongs", |r| r.correction = |b, c, n| if b == 0 { ((b - n).min(0), (c + 1).min(127)) } else { correction(b, c, n) };
    "limits B to −N where 1 − N belongs", |r| r.correction = |b, c, n| if b <= -n { ((b + n).max(-n), (c - 1).max(-128)) } else { correction(b, c, n) };
    "never changes C", |r| r.correction = |b, c, n| (correction(b, c, n).0, c);
    "compares B with N before N is counted up", |r| r.correction = |b, c, n| { let (b, c) = correction(b, c, n - 1); (b, c) };
    in "the reconstruction of samples (T.87 A.4.4, A.4.5)":
    "does not take samples modulo RANGE", |r| both(r, |s, p, e| (p + e * s.step).clamp(0, s.maxval));
    "does not limit samples to 0 … MAXVAL, which matters where NEAR is over 0", |r| both(r, wrapped);
    "takes samples modulo RANGE beyond 0 … MAXVAL, without NEAR", |r| both(r, |s, p, e| { let (m, x) = (s.range * s.step, p + e * s.step); let x = if x < 0 { x + m } else if x > s.maxval { x - m } else { x }; x.clamp(0, s.maxval) });
    "takes samples modulo RANGE without the factor 2·NEAR + 1", |r| both(r, |s, p, e| { let x = p + e * s.step; let x = if x < -s.near { x + s.range } else if x > s.maxval + s.near { x - s.range } else { x }; x.clamp(0, s.maxval) });
    "takes samples modulo 256", |r| both(r, |s, p, e| (p + e * s.step) & 0xff);
    "does not multiply errors by 2·NEAR + 1", |r| both(r, |s, p, e| { let x = p + e; if x < 0 { x + s.range } else if x > s.maxval { x - s.range } else { x } });
    "does not multiply errors by 2·NEAR + 1, but RANGE", |r| both(r, unscaled);
    "takes samples modulo RANGE only where they are too large", |r| both(r, |s, p, e| wrapped(s, p, e).min(if p + e * s.step < -s.near { p + e * s.step } else { i32::MAX }).clamp(0, s.maxval));
    "takes samples modulo RANGE only where they are too small", |r| both(r, |s, p, e| if p + e * s.step > s.maxval + s.near { s.maxval } else { reconstruct(s, p, e) });
    "takes samples modulo RANGE from 0 downward, where −NEAR belongs", |r| both(r, |s, p, e| { let (m, x) = (s.range * s.step, p + e * s.step); if x < 0 { (x + m).clamp(0, s.maxval) } else { reconstruct(s, p, e) } });
    "takes samples modulo RANGE from MAXVAL upward, where MAXVAL + NEAR belongs", |r| both(r, |s, p, e| { let (m, x) = (s.range * s.step, p + e * s.step); if x > s.maxval { (x - m).clamp(0, s.maxval) } else { reconstruct(s, p, e) } });
    "takes samples of MAXVAL + NEAR modulo RANGE (≥ for >)", |r| both(r, |s, p, e| { let (m, x) = (s.range * s.step, p + e * s.step); if x >= s.maxval + s.near { (x - m).clamp(0, s.maxval) } else { reconstruct(s, p, e) } });
    "does not multiply the error at the end of a run by 2·NEAR + 1", |r| r.reconstruct_interrupted = unscaled;
    "does not multiply errors by 2·NEAR + 1 but at the end of a run", |r| r.reconstruct = unscaled;
    "does not take the sample at the end of a run modulo RANGE", |r| r.reconstruct_interrupted = |s, p, e| (p + e * s.step).clamp(0, s.maxval);
    "takes samples modulo RANGE at the end of a run alone", |r| r.reconstruct = |s, p, e| (p + e * s.step).clamp(0, s.maxval);
    in "runs (T.87 A.7)":
    "has a J[18] that is one too large", |r| r.typo = (18, 1, true, true);
    "has a J[18] that is one too small", |r| r.typo = (18, -1, true, true);
    "starts each row with RUNindex 0", |r| r.start_row = |_| 0;
    "counts RUNindex down at the end of a row that a run fills", |r| { r.partial_counts = -1; };
    "counts RUNindex down after each run, also where the row ends", |r| { r.partial_counts = -1; r.full_counts = 0; };
    "does not count up RUNindex for a piece of a run that ends with the row", |r| r.full_counts = 0;
    "takes b of the beginning of a run for b at its end", |r| r.is_early_b = true;
    "fills whole pieces of a run with the samples above, where a belongs", |r| r.is_piece_of_above = true;
    "counts up RUNindex for a run that the end of the row cuts short", |r| r.partial_counts = 1;
    "does not count RUNindex down after a run is interrupted", |r| r.shorten = |index| index;
    "sets RUNindex to 0 after a run is interrupted", |r| r.shorten = |_| 0;
    "counts RUNindex down before the end of the run is read", |r| r.is_shortened_first = true;
    "reads the table J one entry too late", |r| r.j = |i| J[(i + 1).min(31)];
    "reads the table J one entry too early", |r| r.j = |i| J[i.saturating_sub(1)];
    "has J = RUNindex / 4", |r| r.j = |i| i as u32 / 4;
    "stops RUNindex at 30", |r| r.most_run_index = 30;
    "stops RUNindex at 15", |r| r.most_run_index = 15;
    "stops RUNindex at 16", |r| r.most_run_index = 16;
    "stops RUNindex at 7", |r| r.most_run_index = 7;
    "stops RUNindex at 8", |r| r.most_run_index = 8;
    "stops J at 4", |r| r.j = |i| J[i].min(4);
    "takes a and b for alike at the end of a run only where they are equal, whatever NEAR is", |r| r.is_alike = |difference, _| difference == 0;
    "takes a and b for alike at the end of a run by |a − b| < NEAR where ≤ belongs", |r| r.is_alike = |difference, near| difference.abs() < near.max(1);
    "never takes a and b for alike at the end of a run (RItype 0)", |r| r.is_alike = |_, _| false;
    "always takes a and b for alike at the end of a run (RItype 1)", |r| r.is_alike = |_, _| true;
    "predicts the end of a run by b also where a and b are alike", |r| r.interrupted = |_, _, b| b;
    "predicts the end of a run by a also where a and b differ", |r| r.interrupted = |_, a, _| a;
    "turns the sign at the end of a run also where a and b are alike", |r| r.run_sign = |_, a, b| if a > b { -1 } else { 1 };
    "never turns the sign at the end of a run", |r| r.run_sign = |_, _, _| 1;
    "turns the sign at the end of a run where b is over a", |r| r.run_sign = |alike, a, b| if !alike && a < b { -1 } else { 1 };
    "computes k at the end of a run of A, without N / 2 for RItype 1", |r| r.run_sum = |a, _, _| a;
    "computes k at the end of a run of A + N for RItype 1, where N / 2 belongs", |r| r.run_sum = |a, n, kind| a + kind * n;
    "computes k at the end of a run of A + N / 2 for both types", |r| r.run_sum = |a, n, _| a + (n >> 1);
    "computes k at the end of a run of (A + N) / 2 for RItype 1", |r| r.run_sum = |a, n, kind| if kind == 1 { (a + n) >> 1 } else { a };
    "computes k at the end of a run of A of RItype 0 for RItype 1 too", |r| r.is_run_a_shared = true;
    "does not lessen LIMIT by J + 1 at the end of a run", |r| r.run_limit = |limit, _| limit;
    "lessens LIMIT by J at the end of a run, where J + 1 belongs", |r| r.run_limit = |limit, j| limit.saturating_sub(j);
    "lessens LIMIT by 1 at the end of a run, where J + 1 belongs", |r| r.run_limit = |limit, _| limit.saturating_sub(1);
    "favors positive errors at the end of a run also where k is over 0", |r| r.is_positive_favored = |_, _, negative, n| 2 * negative < n;
    "favors positive errors at the end of a run wherever k is 0", |r| r.is_positive_favored = |k, _, _, _| k == 0;
    "never favors positive errors at the end of a run", |r| r.is_positive_favored = |_, _, _, _| false;
    "starts with Nn = 1", |r| r.initial_negative = 1;
    "favors positive errors at the end of a run by 2Nn ≤ N where < belongs", |r| r.is_positive_favored = |k, _, negative, n| k == 0 && 2 * negative <= n;
    "favors positive errors at the end of a run also where NEAR or k is over 0", |r| r.is_positive_favored = |_, _, negative, n| 2 * negative <= n;
    "favors positive errors at the end of a run by Nn < N where 2Nn belongs", |r| r.is_positive_favored = |k, _, negative, n| k == 0 && negative < n;
    "does not add RItype to the number of an error at the end of a run", |r| r.doubled = |number, _| number;
    "adds 1 to the number of an error at the end of a run for both types", |r| r.doubled = |number, _| number + 1;
    "counts negative errors at the end of a run after the sign was turned", |r| r.is_negative = |_, turned| turned < 0;
    "never counts negative errors at the end of a run", |r| r.is_negative = |_, _| false;
    "counts all errors other than 0 at the end of a run for negative ones", |r| r.is_negative = |error, _| error != 0;
    "adds (number + 1) / 2 to A at the end of a run, without − RItype", |r| r.run_growth = |number, _, _| (number + 1) >> 1;
    "adds the number to A at the end of a run, not half of it", |r| r.run_growth = |number, kind, _| number + 1 - kind;
    "adds the magnitude of the error to A at the end of a run, where (number + 1 − RItype) / 2 belongs", |r| r.run_growth = |_, _, error| error.abs();
    "adds (number − RItype) / 2 to A at the end of a run, without + 1", |r| r.run_growth = |number, kind, _| (number - kind) >> 1;
    "adds number / 2 to A at the end of a run", |r| r.run_growth = |number, _, _| number >> 1;
    "does not halve Nn", |r| r.halve_negative = |negative| negative;
    in "the start of a scan (T.87 A.2, A.8)":
    "keeps RUNindex of the stream before", |r| { r.keeps.2 = true; r.is_keeping = true; };
    "keeps the contexts of runs of the stream before", |r| { r.keeps.1 = true; r.is_keeping = true; };
    "keeps the contexts of the stream before", |r| { r.keeps.0 = true; r.is_keeping = true; };
    "keeps all contexts and RUNindex of the stream before", |r| { r.keeps = (true, true, true); r.is_keeping = true; };
    "keeps all contexts of the stream before", |r| { r.keeps = (true, true, false); r.is_keeping = true; };
    "keeps thresholds and RESET of the stream before, where there is no LSE segment", |r| { r.keep_presets = |before, own| if own == PresetParameters::default() { before } else { own }; r.is_keeping = true; };
    "keeps the thresholds of the stream before where its own are 0", |r| { r.keep_presets = |before, own| PresetParameters { t1: if own.t1 == 0 { before.t1 } else { own.t1 }, t2: if own.t2 == 0 { before.t2 } else { own.t2 }, t3: if own.t3 == 0 { before.t3 } else { own.t3 }, ..own }; r.is_keeping = true; };
    "keeps thresholds of the stream before", |r| { r.keep_presets = |before, own| if [own.t1, own.t2, own.t3] == [0; 3] { PresetParameters { t1: before.t1, t2: before.t2, t3: before.t3, ..own } } else { own }; r.is_keeping = true; };
    in "the bits of the data (T.87 9.1)":
    "takes the byte behind 0xFF whole, with its stuffed bit", |r| r.is_stuffed = |_| false;
    "drops a byte 00 behind 0xFF, as JPEG has it", |r| r.drops_zeros = true;
    "drops the stuffed bit behind 0xFF only at odd places", |r| r.is_stuffed = |at| at % 2 == 1;
    "drops the stuffed bit behind 0xFF only at even places", |r| r.is_stuffed = |at| at % 2 == 0;
    "does not drop the stuffed bit behind 0xFF at places that are multiples of 4", |r| r.is_stuffed = |at| at % 4 != 0;
};

#[cfg(test)]
mod tests {
    use super::super::slips::tests::each_stream;
    use super::{RIGHT, decode, stored};
    use crate::decode::planes;
    use crate::ptm::Format;

    #[test]
    fn without_a_slip_streams_are_read_as_the_reference_reads_them() {
        each_stream(Format::is_jpeg_ls, |stream| {
            let stored = stored(stream).expect("a stream");
            let read = decode(stream, &stored, &RIGHT, &mut None, &|_, _| true);
            assert!(read.known == read.samples.len() && !read.may_refuse);
            let right = planes::stream(stream).expect("a legal stream");
            assert_eq!(read.samples, right);
        });
    }
}
