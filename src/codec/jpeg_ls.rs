//! JPEG-LS: ITU-T T.87 | ISO/IEC 14495-1, lossless and near-lossless, one component of 8 bits
//!
//! Samples are coded one by one, left to right and top to bottom. Each is predicted from four
//! neighbours that are already known, and the error of the prediction is written with a Golomb
//! code. How steep the neighbourhood is chooses one of 364 *contexts*, which learn from what they
//! have seen how far the prediction is off and how long the codes should be. Where the
//! neighbourhood is flat, the coder counts equal samples instead (*run mode*).
//!
//! ```text
//! c b d        a, b, c, d: the neighbours of x, as the decoder knows them
//! a x
//! ```
//!
//! With NEAR above 0 each sample may come out wrong by up to NEAR: the error is divided by 2·NEAR +
//! 1 and rounded, and both sides go on from the sample that the decoder will have.
//!
//! Decoder and encoder learn alike, so they share the state (`Coder`) and everything that neither
//! reads nor writes bits.
//!
//! Format notes
//! - Above the first row there are zeros. To the right of a row, d is b. To the left of a row, a is
//!   b, and c is what a was at the start of the row before: it does *not* stand directly above.
//! - The errors are numbers modulo RANGE. Their signs are folded into the low bit, and where a
//!   context's errors are mostly negative the folding is turned around, but only if k and NEAR are
//!   0.
//! - A code has at most LIMIT bits: a prefix of LIMIT − qbpp − 1 zeros announces a plain number.
//! - LIMIT follows from MAXVAL, not from the precision in the frame header.
//! - After a byte 0xFF the next byte has only seven bits, its first bit is 0 (A.1). This is not the
//!   stuffed zero byte of T.81, and 0xFF with a first bit of 1 behind it is a marker.
//! - The interruption of a run uses `RUNindex` as it was *before* the run's end lowers it.
//! - A run that ends with its row is not interrupted: no sample follows, and `RUNindex` stays.
//! - In the preset parameters a zero stands for the default, which depends on MAXVAL and NEAR.
//! - A decoder must take part in NEAR: the frame looks the same with and without loss.

use super::{
    Error, Frame, Input, Marker, Result, Scan, malformed, marker, room_for_samples, unsupported,
};

#[cfg(feature = "generate")]
pub use write::{Options, Presets, encode};

/// Markers that only JPEG-LS has (Table C.1).
const SOF55: u8 = 0xF7;
const LSE: u8 = 0xF8;

/// Decodes a JPEG-LS stream of one component and `width` × `height` samples, in row order from the
/// top.
///
/// # Errors
///
/// [`Class::Malformed`](super::Class) if the stream breaks the standard, has another size or
/// another number of components; [`Class::Unsupported`](super::Class) for other precisions, mapping
/// tables, point transforms, oversize images and restart intervals.
pub fn decode(stream: &[u8], width: u32, height: u32) -> Result<Vec<u8>> {
    let mut input = Input::open(stream)?;
    let mut presets = Stored::default();
    let frame = read_frame(&mut input, &mut presets, width, height)?;
    let parameters = read_scan(&mut input, &mut presets, &frame)?;
    let samples = read_samples(&mut input, &parameters, width, height)?;
    read_end(&mut input, &mut presets)?;
    Ok(samples)
}

// C.2: the frame header, the scan header and the end, each with other segments before it.

fn read_frame(input: &mut Input, presets: &mut Stored, width: u32, height: u32) -> Result<Frame> {
    let marker = presets.read(input)?;
    if marker.code != SOF55 {
        return Err(unexpected(marker, "a JPEG-LS frame header"));
    }
    Frame::read(
        input,
        width,
        height,
        &[2, 3, 4, 5, 6, 7, 9, 10, 11, 12, 13, 14, 15, 16],
    )
}

fn read_scan(input: &mut Input, presets: &mut Stored, frame: &Frame) -> Result<Parameters> {
    let marker = presets.read(input)?;
    if marker.code != marker::SOS {
        return Err(unexpected(marker, "the scan header"));
    }
    let scan = Scan::read(input, frame)?;
    let [near, interleave, transform] = scan.parameters;
    if scan.tables != 0 {
        return Err(unsupported(
            scan.at,
            "samples that a mapping table translates are not implemented",
        ));
    }
    if interleave != 0 {
        let what = format!("one component cannot be interleaved, found ILV {interleave}");
        return Err(malformed(scan.at + 2, what));
    }
    if transform != 0 {
        return Err(unsupported(
            scan.at + 3,
            "a point transform is not implemented",
        ));
    }
    Parameters::new(presets, near, scan.at + 1)
}

fn read_end(input: &mut Input, presets: &mut Stored) -> Result<()> {
    let marker = presets.read(input)?;
    if marker.code == marker::EOI {
        Ok(())
    } else {
        Err(unexpected(marker, "the end of the image"))
    }
}

fn unexpected(marker: Marker, expected: &str) -> Error {
    match marker.code {
        marker::DNL => unsupported(marker.at, "a height told by DNL is not implemented"),
        _ => malformed(marker.at, format!("expected {expected}, found {marker}")),
    }
}

// C.2.4.1: preset parameters.

/// The parameters as an LSE segment stores them; 0 stands for the default.
#[derive(Default)]
struct Stored {
    maxval: u16,
    thresholds: [u16; 3],
    reset: u16,
    /// Where they stand in the stream.
    at: usize,
}

impl Stored {
    /// Reads preset parameters, steps over comments and application data, and returns the first
    /// other marker.
    fn read(&mut self, input: &mut Input) -> Result<Marker> {
        loop {
            let marker = input.marker()?;
            match marker.code {
                LSE => self.read_presets(input.segment("the preset parameter segment")?)?,
                marker::DRI => {
                    read_restart_interval(input.segment("the restart interval segment")?)?;
                }
                marker::COM | marker::APP0..=marker::APP15 => {
                    input.segment("a comment or application segment")?;
                }
                _ => return Ok(marker),
            }
        }
    }

    fn read_presets(&mut self, mut segment: Input) -> Result<()> {
        let at = segment.at;
        let kind = segment.byte("its type")?;
        match kind {
            1 => {}
            2 | 3 => return Err(unsupported(at, "mapping tables are not implemented")),
            4 => return Err(unsupported(at, "sizes over 65,535 are not implemented")),
            5..=13 => {
                return Err(unsupported(
                    at,
                    "the extensions of T.870 are not implemented",
                ));
            }
            _ => {
                return Err(malformed(
                    at,
                    format!("no preset parameter segment has type {kind}"),
                ));
            }
        }
        self.at = segment.at;
        self.maxval = segment.u16("MAXVAL")?;
        self.thresholds = [segment.u16("T1")?, segment.u16("T2")?, segment.u16("T3")?];
        self.reset = segment.u16("RESET")?;
        segment.expect_end()
    }
}

/// The standard leaves open in what unit JPEG-LS counts an interval, and implementations differ.
fn read_restart_interval(mut segment: Input) -> Result<()> {
    let at = segment.at;
    match segment.u16("the restart interval")? {
        0 => segment.expect_end(),
        _ => Err(unsupported(
            at,
            "restart intervals in JPEG-LS are not implemented",
        )),
    }
}

/// The numbers that a scan is coded with.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Parameters {
    /// The largest sample.
    maxval: i32,
    near: i32,
    /// T1, T2, T3: from where on a difference counts as steeper.
    thresholds: [i32; 3],
    /// After so many samples a context forgets half of what it knows.
    reset: i32,
    /// 2·NEAR + 1: how far neighbouring errors are apart.
    step: i32,
    /// How many different errors there are.
    range: i32,
    /// The bits of an error written as a plain number.
    qbpp: u32,
    /// The bits of the longest code.
    limit: u32,
}

impl Parameters {
    /// Fills in defaults (C.2.4.1.1) and checks. NEAR stands apart from the others, at `near_at`.
    fn new(stored: &Stored, near: u8, near_at: usize) -> Result<Parameters> {
        let or = |value: u16, default: i32| {
            if value == 0 {
                default
            } else {
                i32::from(value)
            }
        };
        let near = i32::from(near);

        let maxval = or(stored.maxval, 255);
        if maxval > 255 {
            return Err(malformed(
                stored.at,
                format!("MAXVAL {maxval} does not fit into 8 bits"),
            ));
        }
        if near > maxval / 2 {
            let what = format!("NEAR {near} is more than half of MAXVAL {maxval}");
            return Err(malformed(near_at, what));
        }

        let default = default_thresholds(maxval, near);
        let mut thresholds = [0; 3];
        let mut least = near + 1;
        for (i, value) in stored.thresholds.into_iter().enumerate() {
            thresholds[i] = or(value, default[i]);
            if !(least..=maxval).contains(&thresholds[i]) {
                let found = thresholds[i];
                let what = format!(
                    "T{} must be within {least} to {maxval}, found {found}",
                    i + 1
                );
                return Err(malformed(stored.at + 2 + 2 * i, what));
            }
            least = thresholds[i];
        }
        let reset = or(stored.reset, 64);
        if !(3..=255).contains(&reset) {
            let what = format!("RESET must be within 3 to 255, found {reset}");
            return Err(malformed(stored.at + 8, what));
        }

        // A.2.1.
        let step = 2 * near + 1;
        let range = (maxval + 2 * near) / step + 1;
        let bits = |values: i32| (values - 1).ilog2() + 1; // that many values need
        let bpp = bits(maxval + 1).max(2);
        let limit = 2 * (bpp + bpp.max(8));
        Ok(Parameters {
            maxval,
            near,
            thresholds,
            reset,
            step,
            range,
            qbpp: bits(range),
            limit,
        })
    }
}

/// C.2.4.1.1.1: 3, 7, 21 for 8 bits without loss, and from there in proportion to MAXVAL and NEAR.
///
/// What comes out larger than MAXVAL, or smaller than its predecessor, gives way to that one.
fn default_thresholds(maxval: i32, near: i32) -> [i32; 3] {
    let wanted = if maxval >= 128 {
        let factor = (maxval.min(4095) + 128) / 256;
        [
            factor + 2 + 3 * near,
            4 * factor + 3 + 5 * near,
            17 * factor + 4 + 7 * near,
        ]
    } else {
        let divisor = 256 / (maxval + 1);
        [
            (3 / divisor + 3 * near).max(2),
            (7 / divisor + 5 * near).max(3),
            (21 / divisor + 7 * near).max(4),
        ]
    };
    let mut least = near + 1;
    wanted.map(|threshold| {
        least = if (least..=maxval).contains(&threshold) {
            threshold
        } else {
            least
        };
        least
    })
}

// A.2 – A.7: what decoder and encoder have in common.

/// What is known of samples in one kind of neighbourhood (A.2.1).
#[derive(Clone, Copy)]
struct Context {
    /// Sum of the magnitudes of errors: how long the codes should be.
    a: i32,
    /// Sum of the errors themselves, less what C has taken over.
    b: i32,
    /// What is added to the prediction.
    c: i32,
    /// How many errors these are of.
    n: i32,
}

/// What is known of samples that interrupt a run (A.7.2); the standard's contexts 365 and 366.
#[derive(Clone, Copy)]
struct Interruption {
    a: i32,
    n: i32,
    /// How many of the errors were negative.
    negative: i32,
}

/// The state of a scan.
struct Coder<'p> {
    parameters: &'p Parameters,
    /// By difference + 255: its region, −4 … 4.
    regions: [i8; 511],
    /// Number 0 is the flat neighbourhood, which is run mode's, and not used.
    contexts: [Context; 365],
    /// By the standard's `RItype`: 0 if a and b differ, 1 if they are alike.
    interruptions: [Interruption; 2],
    /// `RUNindex`: how long runs have been lately.
    run_index: usize,
}

/// By `RUNindex`, the J of the standard: a 1 in the stream means 2^J samples (A.2.1).
const RUN_BITS: [u32; 32] = [
    0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13,
    14, 15,
];

impl<'p> Coder<'p> {
    fn new(parameters: &'p Parameters) -> Self {
        let &Parameters {
            near,
            thresholds: [t1, t2, t3],
            range,
            ..
        } = parameters;
        // A.3.3. The flat region has NEAR on both sides.
        let region = |difference: i32| {
            let steepness = match difference.abs() {
                d if d <= near => 0,
                d if d < t1 => 1,
                d if d < t2 => 2,
                d if d < t3 => 3,
                _ => 4,
            };
            if difference < 0 {
                -steepness
            } else {
                steepness
            }
        };
        let a = ((range + 32) / 64).max(2);
        Coder {
            parameters,
            regions: std::array::from_fn(|i| region(i as i32 - 255)),
            contexts: [Context {
                a,
                b: 0,
                c: 0,
                n: 1,
            }; 365],
            interruptions: [Interruption {
                a,
                n: 1,
                negative: 0,
            }; 2],
            run_index: 0,
        }
    }

    /// A.3: the number of the neighbourhood; its mirror image has the same with the other sign.
    #[inline]
    fn neighbourhood(&self, a: i32, b: i32, c: i32, d: i32) -> i32 {
        let region = |difference: i32| i32::from(self.regions[(difference + 255) as usize]);
        81 * region(d - b) + 9 * region(b - c) + region(c - a)
    }
}

impl Parameters {
    /// A.4.4: the nearest multiple of the step, as a number of steps.
    #[cfg(feature = "generate")]
    fn quantise(&self, error: i32) -> i32 {
        let &Parameters { near, step, .. } = self;
        (error + near * error.signum()) / step
    }

    /// A.4.5: the error of the same sample that is nearest to zero.
    #[cfg(feature = "generate")]
    fn reduce(&self, error: i32) -> i32 {
        let range = self.range;
        let error = if error < 0 { error + range } else { error };
        if error >= (range + 1) / 2 {
            error - range
        } else {
            error
        }
    }

    /// Whether `reduce` can have given it.
    #[inline]
    fn is_reduced(&self, error: i32) -> bool {
        let range = self.range;
        -(range / 2) <= error && error < (range + 1) / 2
    }

    /// A.4.4: the sample that an error makes of a prediction, for the decoder and everyone after
    /// it.
    #[inline]
    fn reconstruct(&self, predicted: i32, error: i32) -> i32 {
        let &Parameters {
            maxval,
            near,
            step,
            range,
            ..
        } = self;
        // The ordinary case, where all that follows comes to a sum modulo 256.
        if near == 0 && maxval == 255 {
            return (predicted + error) & 255;
        }
        let sample = predicted + error * step;
        let sample = if sample < -near {
            sample + range * step
        } else if sample > maxval + near {
            sample - range * step
        } else {
            sample
        };
        sample.clamp(0, maxval)
    }

    /// A.7.2: how the sample that interrupts a run of a is predicted, with b above it.
    fn ending(&self, a: i32, b: i32) -> Ending {
        if (a - b).abs() <= self.near {
            Ending {
                predicted: a,
                sign: 1,
                alike: 1,
            }
        } else {
            Ending {
                predicted: b,
                sign: if a > b { -1 } else { 1 },
                alike: 0,
            }
        }
    }
}

/// The prediction for the sample that interrupts a run.
struct Ending {
    predicted: i32,
    /// −1 if errors are counted the other way.
    sign: i32,
    /// The standard's `RItype`: 1 if a and b are alike, else 0.
    alike: i32,
}

/// A.4.1: b or a if c tells that an edge runs through the neighbourhood, else the plane through
/// all three.
#[inline]
fn median(a: i32, b: i32, c: i32) -> i32 {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    if c >= high {
        low
    } else if c <= low {
        high
    } else {
        a + b - c
    }
}

/// The smallest k with n·2^k ≥ a (A.5.1).
#[inline]
fn golomb_k(a: i32, n: i32) -> u32 {
    let mut k = 0;
    while n << k < a {
        k += 1;
    }
    k
}

impl Context {
    /// A.4.2: the prediction, corrected by what was learned. `sign` is −1 in the mirrored
    /// neighbourhood.
    #[inline]
    fn correct(&self, predicted: i32, sign: i32, maxval: i32) -> i32 {
        (predicted + sign * self.c).clamp(0, maxval)
    }

    /// A.5.2: whether negative errors are folded onto even numbers.
    #[inline]
    fn is_mirrored(&self, k: u32, near: i32) -> bool {
        k == 0 && near == 0 && 2 * self.b <= -self.n
    }

    /// A.6.
    #[inline]
    fn learn(&mut self, error: i32, parameters: &Parameters) {
        self.b += error * parameters.step;
        self.a += error.abs();
        if self.n == parameters.reset {
            self.a >>= 1;
            self.b >>= 1; // rounded down, also below zero
            self.n >>= 1;
        }
        self.n += 1;

        // C takes over whole units of the mean error; B keeps within −N < B ≤ 0.
        if self.b <= -self.n {
            self.c = (self.c - 1).max(-128);
            self.b = (self.b + self.n).max(1 - self.n);
        } else if self.b > 0 {
            self.c = (self.c + 1).min(127);
            self.b = (self.b - self.n).min(0);
        }
    }
}

impl Interruption {
    /// A.7.2: as `golomb_k`. `alike` is `RItype`.
    fn golomb_k(&self, alike: i32) -> u32 {
        golomb_k(self.a + alike * (self.n >> 1), self.n)
    }

    /// A.7.2: which of the two errors of one magnitude gets the smaller number: the map of the
    /// standard is 1 exactly if the error is not 0 and its sign is this one.
    fn favours(&self, k: u32) -> i32 {
        if k == 0 && 2 * self.negative < self.n {
            1
        } else {
            -1
        }
    }

    /// A.7.2. `number` is the error as it was written.
    fn learn(&mut self, error: i32, number: i32, alike: i32, reset: i32) {
        if error < 0 {
            self.negative += 1;
        }
        self.a += (number + 1 - alike) >> 1;
        if self.n == reset {
            self.a >>= 1;
            self.n >>= 1;
            self.negative >>= 1;
        }
        self.n += 1;
    }
}

/// A row of samples and what stands to the left and right of it, in the places 0 and width + 1.
struct Rows {
    above: Vec<u8>,
    row: Vec<u8>,
}

impl Rows {
    fn new(width: u32) -> Rows {
        let zeros = vec![0; width as usize + 2];
        Rows {
            above: zeros.clone(),
            row: zeros,
        }
    }

    /// Goes one row down and sets its edges (see the format notes).
    fn next(&mut self) {
        std::mem::swap(&mut self.above, &mut self.row);
        let width = self.row.len() - 2;
        self.above[width + 1] = self.above[width];
        self.row[0] = self.above[1];
    }

    /// The samples themselves.
    fn inside(&self) -> &[u8] {
        &self.row[1..self.row.len() - 1]
    }
}

// Annex F, which is Annex A read the other way round: bits → samples.

/// Every sample from the first to the last, and nothing after it.
fn read_samples(
    input: &mut Input,
    parameters: &Parameters,
    width: u32,
    height: u32,
) -> Result<Vec<u8>> {
    // A row that continues the run of the row before still takes a bit. This keeps a short stream
    // from claiming a high image.
    if (input.stream.len() - input.at) as u64 * 8 < u64::from(height) {
        let what = format!("{height} rows cannot be held by the bytes that remain");
        return Err(malformed(input.at, what));
    }
    let mut samples = room_for_samples(width, height, input.at)?;
    let mut bits = Bits {
        stream: input.stream,
        at: input.at,
        window: 0,
        count: 0,
    };
    let mut coder = Coder::new(parameters);
    let mut rows = Rows::new(width);
    for _ in 0..height {
        rows.next();
        coder.read_row(&mut bits, &rows.above, &mut rows.row)?;
        samples.extend_from_slice(rows.inside());
    }
    bits.finish()?;
    input.at = bits.at;
    Ok(samples)
}

impl Coder<'_> {
    /// A.3.2: each sample in the mode that its neighbourhood asks for.
    fn read_row(&mut self, bits: &mut Bits, above: &[u8], row: &mut [u8]) -> Result<()> {
        let end = row.len() - 1;
        let above = &above[..=end];
        let (mut a, mut b, mut c) = (i32::from(row[0]), i32::from(above[1]), i32::from(above[0]));
        let mut x = 1;
        while x < end {
            let d = i32::from(above[x + 1]);
            let neighbourhood = self.neighbourhood(a, b, c, d);
            if neighbourhood == 0 {
                let run = self.read_run(bits, end - x)?;
                row[x..x + run].fill(a as u8);
                x += run;
                if x == end {
                    break;
                }
                b = i32::from(above[x]);
                a = self.read_interruption(bits, a, b)?;
                c = b;
                b = i32::from(above[x + 1]);
            } else {
                a = self.read_regular(bits, neighbourhood, a, b, c)?;
                c = b;
                b = d;
            }
            row[x] = a as u8;
            x += 1;
        }
        Ok(())
    }

    /// A.4 – A.6: one sample in regular mode.
    #[inline]
    fn read_regular(
        &mut self,
        bits: &mut Bits,
        neighbourhood: i32,
        a: i32,
        b: i32,
        c: i32,
    ) -> Result<i32> {
        let parameters = self.parameters;
        let sign = neighbourhood.signum();
        let context = &mut self.contexts[neighbourhood.unsigned_abs() as usize];
        let predicted = context.correct(median(a, b, c), sign, parameters.maxval);

        let k = golomb_k(context.a, context.n);
        let number = bits.golomb(k, parameters.limit, parameters.qbpp)?;
        let folded = (number >> 1) ^ -(number & 1); // 0, −1, 1, −2, 2 …
        let error = if context.is_mirrored(k, parameters.near) {
            -1 - folded
        } else {
            folded
        };
        if !parameters.is_reduced(error) {
            return Err(malformed(
                bits.offset(),
                format!("no sample has prediction error {error}"),
            ));
        }
        context.learn(error, parameters);
        Ok(parameters.reconstruct(predicted, sign * error))
    }

    /// A.7.1: how many samples equal a, up to the end of the row, which is `left` samples away.
    fn read_run(&mut self, bits: &mut Bits, left: usize) -> Result<usize> {
        let mut run = 0;
        while bits.number(1)? == 1 {
            let samples = 1 << RUN_BITS[self.run_index];
            if run + samples > left {
                return Ok(left); // A.7.1.2: a run that the row cuts short
            }
            run += samples;
            self.run_index = (self.run_index + 1).min(31);
            if run == left {
                return Ok(left);
            }
        }
        run += bits.number(RUN_BITS[self.run_index])? as usize;
        if run >= left {
            let what = format!("a run of {run} samples and its end in a row with {left} to go");
            return Err(malformed(bits.offset(), what));
        }
        Ok(run)
    }

    /// A.7.2: the sample that interrupts a run.
    fn read_interruption(&mut self, bits: &mut Bits, a: i32, b: i32) -> Result<i32> {
        let parameters = self.parameters;
        let Ending {
            predicted,
            sign,
            alike,
        } = parameters.ending(a, b);
        let context = &mut self.interruptions[alike as usize];

        let k = context.golomb_k(alike);
        let limit = parameters.limit - RUN_BITS[self.run_index] - 1;
        let number = bits.golomb(k, limit, parameters.qbpp)?;
        let doubled = number + alike; // twice the magnitude, less one for the favoured sign
        let magnitude = (doubled + 1) >> 1;
        let favours = context.favours(k);
        let error = if doubled & 1 == 1 {
            favours * magnitude
        } else {
            -favours * magnitude
        };
        if !parameters.is_reduced(error) {
            return Err(malformed(
                bits.offset(),
                format!("no sample has prediction error {error}"),
            ));
        }
        context.learn(error, number, alike, parameters.reset);
        self.run_index = self.run_index.saturating_sub(1);
        Ok(parameters.reconstruct(predicted, sign * error))
    }
}

/// The bits of the entropy-coded segment, first bit of a byte first.
struct Bits<'a> {
    stream: &'a [u8],
    at: usize,
    /// The next bits, from the top; zeros below them.
    window: u64,
    /// How many of them there are.
    count: u32,
}

impl Bits<'_> {
    /// Fills the window: at least 57 bits, unless the data ends.
    fn fill(&mut self) {
        if self.count > 56 {
            return;
        }
        // Eight bytes at once if neither they nor the one before them are 0xFF, which would be a
        // zero byte of the complement.
        if let Some(&[before, eight @ ..]) = self.stream[self.at - 1..].first_chunk::<9>() {
            let eight = u64::from_be_bytes(eight);
            let complement = !eight;
            if before != 0xFF
                && complement.wrapping_sub(0x0101_0101_0101_0101)
                    & !complement
                    & 0x8080_8080_8080_8080
                    == 0
            {
                let bytes = (64 - self.count) / 8;
                self.window |= (eight >> (64 - 8 * bytes)) << (64 - self.count - 8 * bytes);
                self.count += 8 * bytes;
                self.at += bytes as usize;
                return;
            }
        }
        while self.count <= 56 {
            let Some(&byte) = self.stream.get(self.at) else {
                return;
            };
            // 0xFF and then a first bit of 1 is a marker; so is a 0xFF that ends the stream.
            if byte == 0xFF
                && self
                    .stream
                    .get(self.at + 1)
                    .is_none_or(|&next| next >= 0x80)
            {
                return;
            }
            let bits = self.bits_of(self.at);
            self.window |= u64::from(byte) << (64 - bits - self.count);
            self.count += bits;
            self.at += 1;
        }
    }

    /// After 0xFF the first bit of a byte is 0 and carries nothing (A.1). The scan header, which
    /// stands before the data, does not end in 0xFF.
    fn bits_of(&self, at: usize) -> u32 {
        if self.stream[at - 1] == 0xFF { 7 } else { 8 }
    }

    /// Steps over bits of the window, if they are there.
    #[inline]
    fn skip(&mut self, bits: u32) -> Result<()> {
        if bits > self.count {
            return Err(malformed(self.at, "the entropy-coded data ends too early"));
        }
        self.window <<= bits;
        self.count -= bits;
        Ok(())
    }

    /// A plain number of up to 16 bits.
    #[inline]
    fn number(&mut self, bits: u32) -> Result<i32> {
        if self.count < 16 {
            self.fill();
        }
        let number = first(self.window, bits);
        self.skip(bits)?;
        Ok(number)
    }

    /// A.5.3: zeros, a one, and k bits: the number of zeros are the high bits. Or as many zeros as
    /// there can be, a one, and the number less one in qbpp bits.
    #[allow(
        clippy::inline_always,
        reason = "without it the decoder takes a fifth longer"
    )]
    #[inline(always)]
    fn golomb(&mut self, k: u32, limit: u32, qbpp: u32) -> Result<i32> {
        if self.count < 48 {
            self.fill();
        }
        let longest = limit - qbpp - 1;
        let zeros = self.window.leading_zeros();
        if zeros < longest {
            let low = first(self.window << (zeros + 1), k);
            self.skip(zeros + 1 + k)?;
            Ok((zeros << k) as i32 + low)
        } else if zeros == longest {
            let number = first(self.window << (zeros + 1), qbpp);
            self.skip(zeros + 1 + qbpp)?;
            Ok(number + 1)
        } else if self.count <= longest {
            Err(malformed(self.at, "the entropy-coded data ends too early"))
        } else {
            Err(malformed(
                self.offset(),
                format!("a code begins with more than {longest} zeros"),
            ))
        }
    }

    /// The byte of the stream that holds the next bit.
    fn offset(&self) -> usize {
        let (mut at, mut bits) = (self.at, 0);
        while bits < self.count {
            at -= 1;
            bits += self.bits_of(at);
        }
        at
    }

    /// Drops the bits that fill the last byte; the data must end there.
    fn finish(&mut self) -> Result<()> {
        self.fill();
        if self.count >= 8 {
            let what = "the entropy-coded data goes on after the last sample";
            return Err(malformed(self.offset() + 1, what));
        }
        Ok(())
    }
}

/// The first bits of a window, as a number.
#[inline]
fn first(window: u64, bits: u32) -> i32 {
    // In two steps, because no bits at all would be a shift by 64, which is not defined.
    (window >> 1 >> (63 - bits)) as i32
}

#[cfg(feature = "generate")]
mod write {
    //! The same way forth: Annex A as it stands, samples → bits.

    use super::super::{Encoded, marker};
    use super::{Coder, Ending, LSE, Parameters, RUN_BITS, Rows, SOF55, Stored, golomb_k, median};

    /// How to encode.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct Options {
        /// How far a sample may come out from what it was; 0 for no loss.
        pub near: u8,
        /// Preset parameters to write; without them no LSE segment is written.
        pub presets: Option<Presets>,
    }

    /// The preset parameters of an LSE segment (C.2.4.1.1). 0 stands for the default.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
    pub struct Presets {
        /// The largest sample: 1 … 255.
        pub maxval: u16,
        /// T1, NEAR + 1 … MAXVAL: from where on a difference counts as steeper.
        pub t1: u16,
        /// T2, T1 … MAXVAL.
        pub t2: u16,
        /// T3, T2 … MAXVAL.
        pub t3: u16,
        /// RESET, 3 … 255: after so many samples a context forgets half of what it knows.
        pub reset: u16,
    }

    /// Encodes `width` × `height` samples, given in row order from the top.
    ///
    /// # Panics
    ///
    /// If there are not `width` × `height` samples, a side is not within 1 … 65,535, a sample is
    /// over MAXVAL, or an option is out of its range.
    #[must_use]
    pub fn encode(samples: &[u8], width: u32, height: u32, options: &Options) -> Encoded {
        assert!(
            (1..=0xFFFF).contains(&width) && (1..=0xFFFF).contains(&height),
            "{width} x {height}"
        );
        assert_eq!(
            samples.len(),
            width as usize * height as usize,
            "samples of {width} x {height}"
        );
        let Presets {
            maxval,
            t1,
            t2,
            t3,
            reset,
        } = options.presets.unwrap_or_default();
        let stored = Stored {
            maxval,
            thresholds: [t1, t2, t3],
            reset,
            at: 0,
        };
        let parameters =
            Parameters::new(&stored, options.near, 0).unwrap_or_else(|error| panic!("{error}"));
        let largest = samples
            .iter()
            .max()
            .map_or(0, |&largest| i32::from(largest));
        assert!(
            largest <= parameters.maxval,
            "sample {largest} is over MAXVAL {}",
            parameters.maxval
        );

        let mut stream = vec![0xFF, marker::SOI];
        write_frame_header(&mut stream, width, height);
        if let Some(presets) = options.presets {
            write_presets(&mut stream, presets);
        }
        // C.2.3: no mapping table, NEAR, not interleaved, no point transform.
        segment(&mut stream, marker::SOS, &[1, 1, 0, options.near, 0, 0]);
        let samples = write_samples(&mut stream, &parameters, samples, width);
        stream.extend([0xFF, marker::EOI]);
        Encoded { stream, samples }
    }

    fn segment(stream: &mut Vec<u8>, code: u8, content: &[u8]) {
        stream.extend([0xFF, code]);
        stream.extend((content.len() as u16 + 2).to_be_bytes());
        stream.extend(content);
    }

    /// C.2.2.
    fn write_frame_header(stream: &mut Vec<u8>, width: u32, height: u32) {
        let mut content = vec![8];
        content.extend((height as u16).to_be_bytes());
        content.extend((width as u16).to_be_bytes());
        content.extend([1, 1, 0x11, 0]);
        segment(stream, SOF55, &content);
    }

    /// C.2.4.1.1.
    fn write_presets(stream: &mut Vec<u8>, presets: Presets) {
        let Presets {
            maxval,
            t1,
            t2,
            t3,
            reset,
        } = presets;
        let mut content = vec![1];
        content.extend(
            [maxval, t1, t2, t3, reset]
                .into_iter()
                .flat_map(u16::to_be_bytes),
        );
        segment(stream, LSE, &content);
    }

    /// Writes all samples and returns what they become.
    fn write_samples(
        stream: &mut Vec<u8>,
        parameters: &Parameters,
        samples: &[u8],
        width: u32,
    ) -> Vec<u8> {
        let mut decoded = Vec::with_capacity(samples.len());
        let mut bits = Bits {
            stream,
            window: 0,
            count: 0,
            room: 8,
        };
        let mut coder = Coder::new(parameters);
        let mut rows = Rows::new(width);
        for originals in samples.chunks_exact(width as usize) {
            rows.next();
            coder.write_row(&mut bits, originals, &rows.above, &mut rows.row);
            decoded.extend_from_slice(rows.inside());
        }
        bits.finish();
        decoded
    }

    impl Coder<'_> {
        /// A.3.2: each sample in the mode that its neighbourhood asks for.
        fn write_row(&mut self, bits: &mut Bits, originals: &[u8], above: &[u8], row: &mut [u8]) {
            // A row has one sample more on its left.
            let original = |x: usize| i32::from(originals[x - 1]);
            let end = row.len() - 1;
            let mut x = 1;
            while x < end {
                let [a, b, c, d] =
                    [row[x - 1], above[x], above[x - 1], above[x + 1]].map(i32::from);
                let neighbourhood = self.neighbourhood(a, b, c, d);
                if neighbourhood == 0 {
                    let near = self.parameters.near;
                    let run = (x..end)
                        .take_while(|&x| (original(x) - a).abs() <= near)
                        .count();
                    self.write_run(bits, run, x + run == end);
                    row[x..x + run].fill(a as u8);
                    x += run;
                    if x == end {
                        break;
                    }
                    let b = i32::from(above[x]);
                    row[x] = self.write_interruption(bits, original(x), a, b) as u8;
                } else {
                    row[x] = self.write_regular(bits, original(x), neighbourhood, a, b, c) as u8;
                }
                x += 1;
            }
        }

        /// A.4 – A.6: one sample in regular mode.
        fn write_regular(
            &mut self,
            bits: &mut Bits,
            original: i32,
            neighbourhood: i32,
            a: i32,
            b: i32,
            c: i32,
        ) -> i32 {
            let parameters = self.parameters;
            let sign = neighbourhood.signum();
            let context = &mut self.contexts[neighbourhood.unsigned_abs() as usize];
            let predicted = context.correct(median(a, b, c), sign, parameters.maxval);
            let error = parameters.reduce(parameters.quantise(sign * (original - predicted)));

            let k = golomb_k(context.a, context.n);
            let mirrored = context.is_mirrored(k, parameters.near);
            let folded = if mirrored { -1 - error } else { error };
            let number = if folded < 0 {
                -2 * folded - 1
            } else {
                2 * folded
            };
            bits.golomb(number as u32, k, parameters.limit, parameters.qbpp);
            context.learn(error, parameters);
            parameters.reconstruct(predicted, sign * error)
        }

        /// A.7.1.2.
        fn write_run(&mut self, bits: &mut Bits, mut run: usize, ends_row: bool) {
            while run >= 1 << RUN_BITS[self.run_index] {
                bits.put(1, 1);
                run -= 1 << RUN_BITS[self.run_index];
                self.run_index = (self.run_index + 1).min(31);
            }
            if !ends_row {
                bits.put(run as u32, 1 + RUN_BITS[self.run_index]);
            } else if run > 0 {
                bits.put(1, 1);
            }
        }

        /// A.7.2: the sample that interrupts a run.
        fn write_interruption(&mut self, bits: &mut Bits, original: i32, a: i32, b: i32) -> i32 {
            let parameters = self.parameters;
            let Ending {
                predicted,
                sign,
                alike,
            } = parameters.ending(a, b);
            let context = &mut self.interruptions[alike as usize];
            let error = parameters.reduce(parameters.quantise(sign * (original - predicted)));

            let k = context.golomb_k(alike);
            let favoured = error.signum() == context.favours(k);
            let number = 2 * error.abs() - alike - i32::from(favoured);
            let limit = parameters.limit - RUN_BITS[self.run_index] - 1;
            bits.golomb(number as u32, k, limit, parameters.qbpp);
            context.learn(error, number, alike, parameters.reset);
            self.run_index = self.run_index.saturating_sub(1);
            parameters.reconstruct(predicted, sign * error)
        }
    }

    struct Bits<'a> {
        stream: &'a mut Vec<u8>,
        /// Bits that do not yet make a byte, at the bottom.
        window: u64,
        count: u32,
        /// The bits that the next byte takes: 7 after 0xFF (A.1).
        room: u32,
    }

    impl Bits<'_> {
        fn put(&mut self, bits: u32, count: u32) {
            self.window = self.window << count | u64::from(bits);
            self.count += count;
            while self.count >= self.room {
                self.count -= self.room;
                let byte = (self.window >> self.count) as u8 & (0xFF >> (8 - self.room));
                self.stream.push(byte);
                self.room = if byte == 0xFF { 7 } else { 8 };
            }
        }

        /// A.5.3.
        fn golomb(&mut self, number: u32, k: u32, limit: u32, qbpp: u32) {
            let longest = limit - qbpp - 1;
            if number >> k < longest {
                self.put(0, number >> k);
                self.put(1 << k | number & ((1 << k) - 1), 1 + k);
            } else {
                self.put(0, longest);
                self.put(1 << qbpp | (number - 1), 1 + qbpp);
            }
        }

        /// Fills the last byte with zeros. After 0xFF there is one more, of seven zeros.
        fn finish(&mut self) {
            if self.count > 0 || self.room == 7 {
                self.put(0, self.room - self.count);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Class, bytes};
    use super::{Parameters, Stored, decode};

    // The smallest stream: a row of four zeros, which is a run, written as four ones.
    const SOI: &str = "FF D8";
    const SOF: &str = "FF F7 00 0B  08  00 01 00 04  01  01 11 00";
    const SOS: &str = "FF DA 00 08  01  01 00  00  00 00";
    const DATA: &str = "F0";
    const EOI: &str = "FF D9";

    /// The smallest stream, with one of its five parts replaced.
    fn with(part: usize, other: &str) -> String {
        let mut parts = [SOI, SOF, SOS, DATA, EOI];
        parts[part] = other;
        parts.join(" ")
    }

    /// The smallest stream with preset parameters: MAXVAL, T1, T2, T3, RESET.
    fn presets(values: &str) -> String {
        with(2, &format!("FF F8 00 0D  01  {values}  {SOS}"))
    }

    #[track_caller]
    fn reads(text: &str) -> Vec<u8> {
        decode(&bytes(text), 4, 1).unwrap_or_else(|error| panic!("{error}"))
    }

    #[track_caller]
    fn refuses(class: Class, text: &str, expected: &str) {
        let error = decode(&bytes(text), 4, 1).expect_err("an error");
        assert_eq!((error.to_string().as_str(), error.class), (expected, class));
    }

    #[track_caller]
    fn rejects(text: &str, expected: &str) {
        refuses(Class::Malformed, text, expected);
    }

    #[track_caller]
    fn lacks(text: &str, expected: &str) {
        refuses(Class::Unsupported, text, expected);
    }

    #[test]
    fn the_smallest_stream_is_black() {
        assert_eq!(reads(&with(0, SOI)), [0; 4]);
    }

    /// 0: no run. 1 and then 11, because k is 2: number 3, which is error 2.
    #[test]
    fn a_run_may_be_interrupted_at_once() {
        let one = with(1, "FF F7 00 0B 08 00 01 00 01 01 01 11 00").replace(DATA, "70");
        assert_eq!(decode(&bytes(&one), 1, 1), Ok(vec![2]));
    }

    #[test]
    fn one_picture_may_be_spelled_in_many_ways() {
        let black = [0; 4];
        assert_eq!(
            reads(&with(1, &format!("FF E8 00 04 4A 46  FF FE 00 02 {SOF}"))),
            black,
            "APP8"
        );
        assert_eq!(
            reads(&with(1, &format!("FF FF FF {SOF}"))),
            black,
            "fill bytes"
        );
        assert_eq!(
            reads(&with(4, "FF FF FF D9")),
            black,
            "fill bytes after the scan"
        );
        assert_eq!(
            reads(&with(4, "FF FE 00 02 FF D9")),
            black,
            "a comment after the scan"
        );
        assert_eq!(
            reads(&with(4, "FF D9 01 02 03")),
            black,
            "bytes after the end"
        );
        assert_eq!(
            reads(&with(2, &format!("FF DD 00 04 00 00 {SOS}"))),
            black,
            "no interval"
        );
        assert_eq!(
            reads(&presets("00 00 00 00 00 00 00 00 00 00")),
            black,
            "all defaults"
        );
        assert_eq!(
            reads(&presets("00 FF 00 03 00 07 00 15 00 40")),
            black,
            "the same, spelled out"
        );
        assert_eq!(
            reads(&with(1, &format!("FF F8 00 0D 01 00*10 {SOF}"))),
            black,
            "presets first"
        );
        assert_eq!(
            reads(&with(1, "FF F7 00 0B 08 00 01 00 04 01 01 42 00")),
            black,
            "4 x 2"
        );
        assert_eq!(reads(&with(3, "F7")), black, "other bits behind the last");
    }

    #[test]
    fn what_is_no_stream_is_rejected() {
        rejects("", "byte 0: the stream is empty");
        rejects(
            "D8 FF",
            "byte 0: the stream does not start with SOI, bytes FF D8",
        );
        rejects(
            "FF D8 FF C0",
            "byte 2: expected a JPEG-LS frame header, found marker FFC0",
        );
        rejects(
            "FF D8 FF D9",
            "byte 2: expected a JPEG-LS frame header, found marker FFD9",
        );
        rejects(
            &with(2, SOF),
            "byte 15: expected the scan header, found marker FFF7",
        );
        rejects(&with(4, ""), "byte 26: the stream ends before a marker");
        rejects(
            &with(4, "FF"),
            "byte 27: the stream ends before the code of a marker",
        );
        rejects(
            &with(4, SOS),
            "byte 26: expected the end of the image, found marker FFDA",
        );
    }

    #[test]
    fn what_is_no_plane_is_rejected() {
        let sof = |content: &str| with(1, &format!("FF F7 00 0B {content}"));
        rejects(
            &sof("08 00 01 00 05 01 01 11 00"),
            "byte 7: expected 4 x 1 samples, found 5 x 1",
        );
        rejects(
            &sof("08 00 01 00 04 03 01 11 00"),
            "byte 11: expected one component, found 3",
        );
        rejects(
            &sof("01 00 01 00 04 01 01 11 00"),
            "byte 6: samples of 1 bits do not exist here",
        );
        lacks(
            &sof("0C 00 01 00 04 01 01 11 00"),
            "byte 6: samples of 12 bits are not implemented",
        );
        let later = "byte 7: a height that DNL tells later is not implemented";
        lacks(&sof("08 00 00 00 04 01 01 11 00"), later);
        lacks(
            &with(4, "FF DC"),
            "byte 26: a height told by DNL is not implemented",
        );
    }

    #[test]
    fn preset_parameters_out_of_range_are_rejected() {
        let zeros = "00 00 00 00 00 00 00 00";
        rejects(
            &presets(&format!("01 00 {zeros}")),
            "byte 20: MAXVAL 256 does not fit into 8 bits",
        );
        let t1 = "byte 22: T1 must be within 1 to 255, found 256";
        rejects(&presets("00 FF 01 00 00 00 00 00 00 00"), t1);
        let t2 = "byte 24: T2 must be within 5 to 255, found 4";
        rejects(&presets("00 FF 00 05 00 04 00 00 00 00"), t2);
        let t3 = "byte 26: T3 must be within 7 to 255, found 3";
        rejects(&presets("00 FF 00 00 00 00 00 03 00 00"), t3);
        rejects(
            &presets(&format!("{zeros} 00 02")),
            "byte 28: RESET must be within 3 to 255, found 2",
        );
        rejects(
            &presets(&format!("{zeros} 01 00")),
            "byte 28: RESET must be within 3 to 255, found 256",
        );
        let lse = |content: &str| with(2, &format!("FF F8 {content} {SOS}"));
        rejects(
            &lse("00 0C 01 00*9"),
            "byte 29: the preset parameter segment ends before RESET",
        );
        rejects(
            &lse("00 0E 01 00*11"),
            "byte 30: the preset parameter segment is 1 bytes too long",
        );
        rejects(
            &lse("00 03 00"),
            "byte 19: no preset parameter segment has type 0",
        );
        lacks(
            &lse("00 05 02 01 01"),
            "byte 19: mapping tables are not implemented",
        );
        lacks(
            &lse("00 05 03 01 01"),
            "byte 19: mapping tables are not implemented",
        );
        lacks(
            &lse("00 07 04 02 00 00"),
            "byte 19: sizes over 65,535 are not implemented",
        );
        lacks(
            &lse("00 03 05"),
            "byte 19: the extensions of T.870 are not implemented",
        );
        let interval = "byte 19: restart intervals in JPEG-LS are not implemented";
        lacks(&with(2, "FF DD 00 04 00 01"), interval);
    }

    #[test]
    fn scan_headers_that_do_not_fit_are_rejected() {
        let sos = |content: &str| with(2, &format!("FF DA 00 08 {content}"));
        rejects(
            &sos("02 01 00 00 00 00"),
            "byte 19: expected a scan of one component, found 2",
        );
        rejects(
            &sos("01 07 00 00 00 00"),
            "byte 20: the scan is of component 7, the frame has only 1",
        );
        lacks(
            &sos("01 01 01 00 00 00"),
            "byte 21: samples that a mapping table translates are not implemented",
        );
        rejects(
            &sos("01 01 00 80 00 00"),
            "byte 22: NEAR 128 is more than half of MAXVAL 255",
        );
        rejects(
            &sos("01 01 00 00 01 00"),
            "byte 23: one component cannot be interleaved, found ILV 1",
        );
        lacks(
            &sos("01 01 00 00 00 01"),
            "byte 24: a point transform is not implemented",
        );
    }

    #[test]
    fn damaged_data_is_rejected() {
        rejects(
            &with(3, ""),
            "byte 25: the entropy-coded data ends too early",
        );
        rejects(
            &with(3, "00"),
            "byte 26: the entropy-coded data ends too early",
        );
        rejects(
            &with(3, "FF"),
            "byte 25: the entropy-coded data ends too early",
        );
        rejects(
            &with(3, "F0 00"),
            "byte 26: the entropy-coded data goes on after the last sample",
        );
        rejects(
            &with(3, "00*5"),
            "byte 25: a code begins with more than 22 zeros",
        );
        // No run; then 22 zeros, a one and 1111 1111: number 256, one more than errors have.
        rejects(
            &with(3, "00 00 01 FF 00"),
            "byte 29: no sample has prediction error -129",
        );

        // Four samples, then a run that ends: one more, and another one that interrupts it.
        let five = with(1, "FF F7 00 0B 08 00 01 00 05 01 01 11 00").replace(DATA, "F4");
        let error = decode(&bytes(&five), 5, 1).expect_err("too long");
        assert_eq!(
            error.to_string(),
            "byte 25: a run of 5 samples and its end in a row with 5 to go"
        );
    }

    /// 65,535 × 65,535 samples would be four gigabytes.
    #[test]
    fn a_short_stream_cannot_claim_a_large_image() {
        let text = with(1, "FF F7 00 0B 08 FF FF FF FF 01 01 11 00");
        let error = decode(&bytes(&text), 65_535, 65_535).expect_err("too little data");
        assert_eq!(
            error.to_string(),
            "byte 25: 65535 rows cannot be held by the bytes that remain"
        );
    }

    #[test]
    fn defaults_follow_from_maxval_and_near() {
        let all = |maxval, near| {
            let stored = Stored {
                maxval,
                ..Stored::default()
            };
            let p = Parameters::new(&stored, near, 0).expect("legal parameters");
            (p.thresholds, p.reset, p.range, p.qbpp, p.limit)
        };
        assert_eq!(all(0, 0), ([3, 7, 21], 64, 256, 8, 32));
        assert_eq!(all(255, 3), ([12, 22, 42], 64, 38, 6, 32));
        assert_eq!(all(127, 0), ([2, 3, 10], 64, 128, 7, 30));
        assert_eq!(all(128, 0), ([3, 7, 21], 64, 129, 8, 32));
        assert_eq!(all(1, 0), ([1, 1, 1], 64, 2, 1, 20));
    }
}
