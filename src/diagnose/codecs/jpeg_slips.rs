//! JPEG streams decoded with one slip in the decoder of T.81.
//!
//! The codes of a stream are read by the reference; what is made of them is made here, in the plainest way, with every
//! decision a field of [`Rules`], right by default. Slips in reading the codes themselves are not among them.

use std::sync::LazyLock;

use super::segments::{self, DHT, DQT, DRI, SOF, SOS};
use super::slips::{IsShown, Partial, Slip, signed_byte, slips};
use crate::codec::jpeg::{self, BlockTrace};
use crate::codec::segments::Segment;
use crate::error::Result;
use crate::parts::PlaneStream;

/// Coefficients of a block, by rows.
type Block = [i32; 64];

/// Every decision of the decoder.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a decision by itself"
)]
pub(in crate::diagnose) struct Rules {
    /// What is made of the segments before the data, if they are read otherwise.
    segments: Option<fn(&mut Vec<Segment>)>,
    /// The place of coefficient k of the zigzag order.
    place: fn(usize) -> usize,
    /// The number that was coded, and its bits.
    extend: fn(i32, u32) -> i32,
    /// The DC coefficient: the one before and the difference.
    dc: fn(i32, i32) -> i32,
    /// The DC coefficient before, after a restart, which may be the start of a row of blocks, and at the start of such a row.
    restarted: fn(i32, bool) -> i32,
    row_started: fn(i32) -> i32,
    /// How many zeros ZRL skips.
    zeros: usize,
    /// The last AC coefficient that is read.
    last: usize,
    /// Steps in zigzag order and k: the one that is used.
    step: fn(&[u16; 64], usize) -> i32,
    dequantized: fn(i32) -> i32,
    /// What a block holds before it is read: of the one before, and whether it is the first of a row.
    fresh: fn(&Block, bool) -> Block,
    /// The coefficients that are transformed.
    prepared: fn(Block) -> Block,
    /// What becomes of the samples of a block, before 128 is added.
    transformed: fn([i32; 64]) -> [i32; 64],
    shown: fn(i32) -> u8,
    /// Blocks of a row, of its samples.
    across: fn(usize) -> usize,
    /// Where a block stands: its number, blocks across and down.
    block: fn(usize, usize, usize) -> (usize, usize),
    /// Columns of the last block of a row that are copied: of those that are there.
    copied: fn(usize) -> usize,
    /// How many rows at the end repeat the one before, of the height; and how many rows are shown.
    repeated: fn(usize) -> usize,
    rows: fn(usize) -> usize,
    /// The columns and the rows that are shown, of width and height.
    edges: fn(usize, usize) -> (usize, usize),
    /// How many blocks are read, of the blocks in a row and of all.
    read: fn(usize, usize) -> usize,
    /// Whether zeros are skipped behind a coefficient, not before it.
    is_skipping_late: bool,
    /// Whether blocks stand where they should.
    is_in_place: bool,
    /// Whether the steps of the first stream count, and the DC coefficient of the stream before; whether either does.
    keeps_steps: bool,
    keeps_dc: bool,
    pub(in crate::diagnose) is_keeping: bool,
}

/// Figure A.6: the place of each coefficient in its block.
fn zigzag(k: usize) -> usize {
    usize::from(jpeg::ZIGZAG[k])
}

/// The cosine of basis function `u` at `x`, with its norm.
fn basis(x: usize, u: usize) -> f64 {
    let norm = if u == 0 {
        std::f64::consts::FRAC_1_SQRT_2
    } else {
        1.0
    };
    norm * ((2 * x + 1) as f64 * u as f64 * std::f64::consts::PI / 16.0).cos() / 2.0
}

static BASIS: LazyLock<[[f64; 8]; 8]> =
    LazyLock::new(|| std::array::from_fn(|x| std::array::from_fn(|u| basis(x, u))));

/// A.3.3 in real numbers, columns first; 128 is not added yet.
fn transform(block: &Block) -> [f64; 64] {
    let table = &*BASIS;
    let mut half = [0.0; 64];
    for (i, value) in half.iter_mut().enumerate() {
        let (y, u) = (i / 8, i % 8);
        *value = (0..8)
            .map(|v| table[y][v] * f64::from(block[8 * v + u]))
            .sum();
    }
    std::array::from_fn(|i| {
        let (y, x) = (i / 8, i % 8);
        (0..8).map(|u| table[x][u] * half[8 * y + u]).sum()
    })
}

pub(in crate::diagnose) const RIGHT: Rules = Rules {
    segments: None,
    place: zigzag,
    extend: |value, _| value,
    dc: |before, difference| before + difference,
    restarted: |_, _| 0,
    row_started: |before| before,
    zeros: 16,
    last: 63,
    step: |steps, k| i32::from(steps[k]),
    dequantized: |value| value,
    fresh: |_, _| [0; 64],
    prepared: |block| block,
    transformed: |samples| samples,
    shown: |sample| (sample + 128).clamp(0, 255) as u8,
    across: |width| width.div_ceil(8),
    block: |number, across, _| (number % across, number / across),
    copied: |columns| columns,
    repeated: |_| 0,
    rows: |height| height,
    edges: |width, height| (width, height),
    read: |_, all| all,
    is_skipping_late: false,
    is_in_place: true,
    keeps_steps: false,
    keeps_dc: false,
    is_keeping: false,
};

/// A block as it is read, in its own order.
fn read(traced: &BlockTrace, steps: &[u16; 64], dc: i32, mut block: Block, rules: &Rules) -> Block {
    block[0] = (rules.dequantized)(dc * (rules.step)(steps, 0));
    let mut stored = 1;
    let mut k = 1;
    for &(symbol, _) in traced.codes.iter().skip(1) {
        let (run, size) = (usize::from(symbol >> 4), u32::from(symbol & 15));
        match (run, size) {
            (0, 0) => break,
            (_, 0) => {
                stored += 16;
                k += rules.zeros;
            }
            _ => {
                stored += run;
                if !rules.is_skipping_late {
                    k += run;
                }
                let value = traced.coefficients.get(stored).copied().unwrap_or_default();
                if k <= rules.last {
                    let value = (rules.extend)(value, size) * (rules.step)(steps, k);
                    block[(rules.place)(k) % 64] = (rules.dequantized)(value);
                }
                stored += 1;
                k += if rules.is_skipping_late { run + 1 } else { 1 };
            }
        }
    }
    block
}

/// What a decoder may keep from one stream to the next: the steps of the first one, and the DC coefficient.
#[derive(Clone, Copy)]
pub(in crate::diagnose) struct Kept {
    steps: [u16; 64],
    dc: i32,
}

/// The blocks of a stream, and its steps in zigzag order.
pub(in crate::diagnose) type Traced = (Vec<BlockTrace>, [u16; 64]);

/// The blocks of a stream; nothing where the reference does not read it.
pub(in crate::diagnose) fn traced(stream: &PlaneStream) -> Option<Traced> {
    trace(stream.bytes, stream)
}

/// The same of other bytes in its place.
fn trace(bytes: &[u8], stream: &PlaneStream) -> Option<Traced> {
    jpeg::trace(bytes, stream.size.width, stream.size.height).ok()
}

/// The samples of a stream, as a decoder with these rules finds them, to the block of which one is not as it was shown.
pub(in crate::diagnose) fn decode(
    stream: &PlaneStream,
    traced: &Traced,
    rules: &Rules,
    kept: &mut Option<Kept>,
    is_shown: IsShown,
) -> Partial {
    let change = rules.segments;
    let changed = change.and_then(|change| segments::changed(stream.bytes, change));
    let other = match changed.map(|bytes| trace(&bytes, stream)) {
        Some(None) => return Partial::refused(stream),
        other => other.flatten(),
    };
    let (traced, steps) = other.as_ref().unwrap_or(traced);
    let steps = match kept {
        Some(kept) if rules.keeps_steps => &kept.steps.clone(),
        _ => steps,
    };
    let (width, height) = (stream.size.width as usize, stream.size.height as usize);
    let (columns, across) = (width.div_ceil(8), (rules.across)(width));
    let (rows, repeated) = ((rules.rows)(height), (rules.repeated)(height));
    let is_in_place = rules.is_in_place && repeated == 0;
    let mut samples = vec![0; width * height];
    let before = kept.filter(|_| rules.keeps_dc);
    let (mut dc, mut block) = (before.map_or(0, |kept| kept.dc), [0; 64]);
    // Where rows have no blocks nothing is shown.
    let shown = match across {
        0 => 0,
        _ => (rules.read)(columns, traced.len()),
    };
    let (right, bottom) = (rules.edges)(width, rows);
    let mut is_other = false;
    for (number, one) in traced.iter().take(shown).enumerate() {
        let starts_row = number % columns == 0;
        if one.is_restarted {
            dc = (rules.restarted)(dc, starts_row);
        }
        if starts_row && number > 0 {
            dc = (rules.row_started)(dc);
        }
        let size = one
            .codes
            .first()
            .map_or(0, |&(symbol, _)| u32::from(symbol));
        dc = (rules.dc)(dc, (rules.extend)(one.dc_difference, size));
        block = read(one, steps, dc, (rules.fresh)(&block, starts_row), rules);
        let made = transform(&(rules.prepared)(block)).map(|value| value.round() as i32);
        let made = (rules.transformed)(made);
        let (left, top) = (rules.block)(number, across, height.div_ceil(8));
        let copied = (rules.copied)(width.saturating_sub(8 * left).min(8));
        for (i, &sample) in made.iter().enumerate() {
            let (x, y) = (8 * left + i % 8, 8 * top + i / 8);
            if i % 8 < copied && x < width.min(right) && y < rows.min(bottom) {
                samples[y * width + x] = (rules.shown)(sample);
                // Where blocks stand elsewhere they may overwrite each other.
                is_other |= is_in_place && !is_shown(y * width + x, samples[y * width + x]);
            }
        }
        if is_other {
            break;
        }
    }
    repeat_rows(&mut samples, width, repeated);
    *kept = Some(Kept { steps: *steps, dc });
    let pairs = || samples.iter().enumerate();
    is_other = is_other || pairs().any(|(place, &sample)| !is_shown(place, sample));
    Partial {
        known: samples.len(),
        samples,
        is_other,
        may_refuse: shown > traced.len(),
    }
}

/// Makes so many rows at the end what the one before them is.
fn repeat_rows(samples: &mut [u8], width: usize, repeated: usize) {
    let height = samples.len() / width;
    for row in height - repeated.min(height)..height {
        samples.copy_within((row - 1) * width..row * width, row * width);
    }
}

/// A stream of JPEG with this slip.
fn slipped(stream: &PlaneStream, slip: fn(&mut Rules)) -> Result<Vec<u8>> {
    let mut rules = RIGHT;
    slip(&mut rules);
    let partial = match traced(stream) {
        Some(traced) => decode(stream, &traced, &rules, &mut None, &|_, _| true),
        None => Partial::right(stream)?,
    };
    Ok(partial.samples)
}

/// A number of which two are exchanged.
fn swapped(k: usize, i: usize, j: usize) -> usize {
    if k == i {
        j
    } else if k == j {
        i
    } else {
        k
    }
}

/// Two coefficients of the zigzag order exchanged.
fn exchanged(k: usize, i: usize, j: usize) -> usize {
    zigzag(swapped(k, i, j))
}

/// A block with rows and columns exchanged.
fn transposed(values: [i32; 64]) -> [i32; 64] {
    std::array::from_fn(|i| values[i % 8 * 8 + i / 8])
}

/// Two columns of a block exchanged.
fn columns_exchanged(values: [i32; 64], one: usize, other: usize) -> [i32; 64] {
    std::array::from_fn(|i| values[i / 8 * 8 + swapped(i % 8, one, other)])
}

/// Two rows of a block exchanged.
fn rows_exchanged(values: [i32; 64], one: usize, other: usize) -> [i32; 64] {
    transposed(columns_exchanged(transposed(values), one, other))
}

impl Rules {
    /// Whether a decoder with these may find no picture: the others read all codes as they should.
    pub const fn may_refuse(&self) -> bool {
        self.segments.is_some()
    }
}

/// A change of the content of each segment of one kind.
macro_rules! each {
    ($kind:path, $change:expr) => {
        Some(|segments: &mut Vec<Segment>| segments::each(segments, $kind, $change))
    };
}

pub(in crate::diagnose) static SLIPS: &[Slip<Rules>] = slips! {
    in "the numbers of tables (T.81 B.2.3, B.2.4)":
    "stores every Huffman table under number 0", |r| r.segments = each!(DHT, |dht| dht.renumber(|number| number & 0xf0));
    "ignores the numbers of Huffman tables: the last one counts", |r| r.segments = Some(|all| { segments::each(all, DHT, |dht| dht.renumber(|number| number & 0xf0)); segments::each(all, SOS, |sos| sos.content[2] = 0); });
    "takes the numbers of Huffman tables modulo 2", |r| r.segments = Some(|all| { segments::each(all, DHT, |dht| dht.renumber(|number| number & 0xf1)); segments::each(all, SOS, |sos| sos.content[2] &= 0x11); });
    "takes Huffman tables 0, whatever the scan header says", |r| r.segments = each!(SOS, |sos| sos.content[2] = 0);
    "takes the AC table of the number of the DC table", |r| r.segments = each!(SOS, |sos| sos.content[2] = sos.content[2] >> 4 | sos.content[2] & 0xf0);
    "takes the DC table of the number of the AC table", |r| r.segments = each!(SOS, |sos| sos.content[2] = sos.content[2] << 4 | sos.content[2] & 0x0f);
    "exchanges the numbers of DC and AC table", |r| r.segments = each!(SOS, |sos| sos.content[2] = sos.content[2].rotate_left(4));
    "keeps one AC table, the last one, whatever its number is", |r| r.segments = Some(|all| { segments::each(all, DHT, |dht| dht.renumber(|number| if number & 0xf0 == 0 { number } else { number & 0xf0 })); segments::each(all, SOS, |sos| sos.content[2] &= 0xf0); });
    "keeps one DC table, the last one, whatever its number is", |r| r.segments = Some(|all| { segments::each(all, DHT, |dht| dht.renumber(|number| if number & 0xf0 == 0 { 0 } else { number })); segments::each(all, SOS, |sos| sos.content[2] &= 0x0f); });
    "keeps the first Huffman table of a number, not the last one", |r| r.segments = Some(|all| segments::keep_first(all, DHT));
    "reads only the first Huffman table of a segment", |r| r.segments = each!(DHT, Segment::keep_first_table);
    "ignores the number of a quantization table: the last one counts", |r| r.segments = Some(|all| { segments::each(all, DQT, |dqt| dqt.renumber(|number| number & 0xf0)); segments::each(all, SOF, |sof| sof.content[8] = 0); });
    "exchanges the two bytes of steps of 16 bits", |r| r.segments = each!(DQT, Segment::exchange_bytes);
    "stores every quantization table under number 0", |r| r.segments = each!(DQT, |dqt| dqt.renumber(|number| number & 0xf0));
    "takes quantization table 0, whatever the frame header says", |r| r.segments = each!(SOF, |sof| sof.content[8] = 0);
    "keeps the first quantization table of a number, not the last one", |r| r.segments = Some(|all| segments::keep_first(all, DQT));
    "reads only the first quantization table of a segment", |r| r.segments = each!(DQT, Segment::keep_first_table);
    in "restart intervals (T.81 B.2.4.4)":
    "takes the lowest byte of a restart interval", |r| r.segments = each!(DRI, |dri| dri.content[0] = 0);
    "exchanges the two bytes of a restart interval", |r| r.segments = each!(DRI, |dri| dri.content.reverse());
    "ignores restart intervals", |r| r.segments = Some(|all| all.retain(|segment| segment.code != DRI));
    "takes restart intervals to be one longer", |r| r.segments = each!(DRI, |dri| dri.content[1] = dri.content[1].wrapping_add(1));
    in "EXTEND (T.81 F.2.2.1)":
    "takes the largest negative number of each size for positive", |r| r.extend = |v, s| if s > 0 && v == -(1 << (s - 1)) { v + (1 << s) - 1 } else { v };
    "takes numbers of EXTEND for negative that begin with a 1 and nothing but zeros (≤ for <)", |r| r.extend = |v, s| if s > 0 && v == 1 << (s - 1) { v + 1 - (1 << s) } else { v };
    "extends negative numbers by −2^size, where 1 − 2^size belongs", |r| r.extend = |v, s| if v < 0 { v - 1 } else { v }.max(-(1 << s));
    "extends negative numbers by 2 − 2^size, where 1 − 2^size belongs", |r| r.extend = |v, _| if v < 0 { v + 1 } else { v };
    "takes 0 for −1, a number of one bit", |r| r.extend = |v, s| if s == 1 && v < 0 { 0 } else { v };
    "takes all numbers for positive (no EXTEND)", |r| r.extend = |v, s| if v < 0 { v + (1 << s) - 1 } else { v };
    "extends negative numbers of 8 bits and more by −2^size, where 1 − 2^size belongs", |r| r.extend = |v, s| if v < 0 && s >= 8 { v - 1 } else { v };
    "extends negative numbers of 8 bits and more by 2 − 2^size, where 1 − 2^size belongs", |r| r.extend = |v, s| if v < 0 && s >= 8 { v + 1 } else { v };
    "takes numbers of 8 bits and more for negative that begin with a 1 and nothing but zeros (≤ for <)", |r| r.extend = |v, s| if s >= 8 && v == 1 << (s - 1) { v + 1 - (1 << s) } else { v };
    "takes the largest negative number of each size of 8 bits and more for positive", |r| r.extend = |v, s| if s >= 8 && v == -(1 << (s - 1)) { v + (1 << s) - 1 } else { v };
    "takes numbers of 8 bits and more for positive (no EXTEND)", |r| r.extend = |v, s| if v < 0 && s >= 8 { v + (1 << s) - 1 } else { v };
    "gives negative numbers their magnitude", |r| r.extend = |v, _| v.abs();
    in "the DC coefficient (T.81 F.2.2.1)":
    "does not add the DC coefficient of the block before", |r| r.dc = |_, difference| difference;
    "subtracts the difference of DC coefficients", |r| r.dc = |before, difference| before - difference;
    "keeps the DC coefficient before in a signed byte", |r| r.dc = |before, difference| signed_byte(before) + difference;
    "keeps the DC coefficient in a signed byte", |r| r.dc = |before, difference| signed_byte(before + difference);
    "keeps the DC coefficient in a byte", |r| r.dc = |before, difference| (before + difference) & 0xff;
    "limits the DC coefficient to ±1023", |r| r.dc = |before, difference| (before + difference).clamp(-1023, 1023);
    "takes 0 for the DC coefficient before at the start of each row of blocks", |r| r.row_started = |_| 0;
    "keeps the DC coefficient before across restart markers", |r| r.restarted = |before, _| before;
    "takes 0 for the DC coefficient before after restart markers only at the start of a row of blocks", |r| r.restarted = |before, starts_row| if starts_row { 0 } else { before };
    "begins with the DC coefficient of the stream before, where 0 belongs", |r| { r.keeps_dc = true; r.is_keeping = true; };
    "takes 128 for the DC coefficient before after restart markers", |r| r.restarted = |_, _| 128;
    "takes 1024 for the DC coefficient before after restart markers", |r| r.restarted = |_, _| 1024;
    in "AC coefficients (T.81 F.2.2.2)":
    "skips 15 zeros for ZRL, where 16 belong", |r| r.zeros = 15;
    "skips 17 zeros for ZRL, where 16 belong", |r| r.zeros = 17;
    "skips no zeros for ZRL", |r| r.zeros = 0;
    "leaves out coefficient 63", |r| r.last = 62;
    "leaves out the last row of the zigzag order (coefficients from 57 on)", |r| r.last = 56;
    "leaves out all AC coefficients", |r| r.last = 0;
    "puts coefficients before their zeros, not behind them", |r| r.is_skipping_late = true;
    "leaves the coefficients of the block before, where it reads none", |r| r.fresh = |before, _| *before;
    "leaves the coefficients of the block before, but at the start of a row of blocks", |r| r.fresh = |before, starts_row| if starts_row { [0; 64] } else { *before };
    in "the zigzag order (T.81 Figure A.6)":
    "does not undo the zigzag order", |r| r.place = |k| k;
    "exchanges rows and columns of the zigzag order", |r| r.place = |k| zigzag(k) % 8 * 8 + zigzag(k) / 8;
    "exchanges coefficients 1 and 2 of the zigzag order", |r| r.place = |k| exchanged(k, 1, 2);
    "exchanges coefficients 61 and 62 of the zigzag order", |r| r.place = |k| exchanged(k, 61, 62);
    "exchanges coefficients 62 and 63 of the zigzag order", |r| r.place = |k| exchanged(k, 62, 63);
    "puts coefficients one place too late in the zigzag order", |r| r.place = |k| zigzag((k + 1).min(63));
    in "quantization (T.81 A.3.4)":
    "uses no steps: coefficients are not dequantized", |r| r.step = |_, _| 1;
    "does not dequantize DC coefficients", |r| r.step = |steps, k| if k == 0 { 1 } else { steps[k].into() };
    "does not dequantize AC coefficients", |r| r.step = |steps, k| if k == 0 { steps[0].into() } else { 1 };
    "uses the step of DC for all coefficients", |r| r.step = |steps, _| steps[0].into();
    "uses the second step for DC", |r| r.step = |steps, k| steps[k.max(1)].into();
    "takes steps by the place in the block, without the zigzag order", |r| r.step = |steps, k| steps[zigzag(k)].into();
    "takes steps with rows and columns exchanged", |r| r.step = |steps, k| { let place = zigzag(k) % 8 * 8 + zigzag(k) / 8; (0..64).find(|&j| zigzag(j) == place).map_or(1, |j| steps[j].into()) };
    "takes steps for signed bytes", |r| r.step = |steps, k| if steps[k] < 256 { signed_byte(steps[k].into()) } else { steps[k].into() };
    "takes the steps of the first plane for all planes, not those of the stream before them in the file", |r| { r.keeps_steps = true; r.is_keeping = true; };
    "takes the step of the coefficient before the last one for the last one", |r| r.step = |steps, k| steps[k.min(62)].into();
    "puts steps of more than 255 in plain order, without the zigzag order", |r| r.step = |steps, k| if steps.iter().any(|&step| step > 255) { steps[zigzag(k)].into() } else { steps[k].into() };
    "takes the lowest byte of steps of 16 bits", |r| r.step = |steps, k| i32::from(steps[k] & 0xff);
    "takes 255 for steps of more than 255", |r| r.step = |steps, k| steps[k].min(255).into();
    "takes the step of the coefficient before", |r| r.step = |steps, k| steps[k.saturating_sub(1)].into();
    "takes the step of the next coefficient", |r| r.step = |steps, k| steps[(k + 1).min(63)].into();
    "limits dequantized coefficients to ±1023", |r| r.dequantized = |value| value.clamp(-1023, 1023);
    "limits dequantized coefficients to ±2047", |r| r.dequantized = |value| value.clamp(-2047, 2047);
    "keeps dequantized coefficients in a signed byte", |r| r.dequantized = signed_byte;
    in "the inverse DCT (T.81 A.3.3)":
    "exchanges rows and columns of the coefficients of a block", |r| r.prepared = transposed;
    "exchanges rows and columns of the samples of a block", |r| r.transformed = transposed;
    "turns each block upside down", |r| r.transformed = |samples| std::array::from_fn(|i| samples[(7 - i / 8) * 8 + i % 8]);
    "mirrors each block from left to right", |r| r.transformed = |samples| std::array::from_fn(|i| samples[i / 8 * 8 + 7 - i % 8]);
    "takes a column of a block for flat whose coefficients of the rows 1 to 6 are 0, without the last row", |r| r.prepared = |block| std::array::from_fn(|i| if i >= 56 && (1..7).all(|y| block[8 * y + i % 8] == 0) { 0 } else { block[i] });
    "takes a column of a block for flat whose coefficients of the rows 2 to 7 are 0, without the row 1", |r| r.prepared = |block| std::array::from_fn(|i| if i / 8 == 1 && (2..8).all(|y| block[8 * y + i % 8] == 0) { 0 } else { block[i] });
    "takes a row of a block for flat whose coefficients of the columns 1 to 6 are 0, without the last column", |r| r.prepared = |block| std::array::from_fn(|i| if i % 8 == 7 && (1..7).all(|x| block[i / 8 * 8 + x] == 0) { 0 } else { block[i] });
    "exchanges coefficients 1 and 3 of each row", |r| r.prepared = |block| columns_exchanged(block, 1, 3);
    "exchanges coefficients 3 and 5 of each row", |r| r.prepared = |block| columns_exchanged(block, 3, 5);
    "exchanges coefficients 5 and 7 of each row", |r| r.prepared = |block| columns_exchanged(block, 5, 7);
    "exchanges coefficients 2 and 6 of each row", |r| r.prepared = |block| columns_exchanged(block, 2, 6);
    "exchanges coefficients 3 and 5 of each column", |r| r.prepared = |block| rows_exchanged(block, 3, 5);
    "exchanges coefficients 2 and 6 of each column", |r| r.prepared = |block| rows_exchanged(block, 2, 6);
    "exchanges the rows 3 and 4 of the samples of a block", |r| r.transformed = |samples| rows_exchanged(samples, 3, 4);
    "exchanges the columns 3 and 4 of the samples of a block", |r| r.transformed = |samples| columns_exchanged(samples, 3, 4);
    "exchanges the rows 1 and 2 of the samples of a block", |r| r.transformed = |samples| rows_exchanged(samples, 1, 2);
    "exchanges the columns 1 and 2 of the samples of a block", |r| r.transformed = |samples| columns_exchanged(samples, 1, 2);
    "exchanges the rows 0 and 7 of the samples of a block", |r| r.transformed = |samples| rows_exchanged(samples, 0, 7);
    "exchanges the columns 0 and 7 of the samples of a block", |r| r.transformed = |samples| columns_exchanged(samples, 0, 7);
    "repeats the row before for the last row of each block", |r| r.transformed = |samples| std::array::from_fn(|i| samples[(i / 8).min(6) * 8 + i % 8]);
    "repeats the column before for the last column of each block", |r| r.transformed = |samples| std::array::from_fn(|i| samples[i / 8 * 8 + (i % 8).min(6)]);
    "leaves out the last row of coefficients", |r| r.prepared = |block| std::array::from_fn(|i| if i >= 56 { 0 } else { block[i] });
    "leaves out the last column of coefficients", |r| r.prepared = |block| std::array::from_fn(|i| if i % 8 == 7 { 0 } else { block[i] });
    "divides samples by 4, where 8 belongs", |r| r.transformed = |samples| samples.map(|sample| 2 * sample);
    "divides samples by 16, where 8 belongs", |r| r.transformed = |samples| samples.map(|sample| sample / 2);
    in "limits and level shift of samples (T.81 A.3.1)":
    "lets samples below 0 wrap around", |r| r.shown = |sample| (sample + 128).min(255) as u8;
    "lets samples above 255 wrap around", |r| r.shown = |sample| (sample + 128).max(0) as u8;
    "lets samples beyond 0…255 wrap around", |r| r.shown = |sample| (sample + 128) as u8;
    "limits samples to ±127 before 128 is added", |r| r.shown = |sample| (sample.clamp(-127, 127) + 128) as u8;
    "limits samples to 0…255 before 128 is added", |r| r.shown = |sample| (sample.clamp(0, 255) + 128) as u8;
    "limits samples to 16…235", |r| r.shown = |sample| (sample + 128).clamp(16, 235) as u8;
    "limits samples to 1…254", |r| r.shown = |sample| (sample + 128).clamp(1, 254) as u8;
    "limits samples to 0…254", |r| r.shown = |sample| (sample + 128).clamp(0, 254) as u8;
    "limits samples to 1…255", |r| r.shown = |sample| (sample + 128).clamp(1, 255) as u8;
    "adds 129 to samples, where 128 belongs", |r| r.shown = |sample| (sample + 129).clamp(0, 255) as u8;
    "does not add 128 to samples", |r| r.shown = |sample| sample.clamp(0, 255) as u8;
    "adds 127 to samples, where 128 belongs", |r| r.shown = |sample| (sample + 127).clamp(0, 255) as u8;
    "shows samples inverted", |r| r.shown = |sample| (127 - sample).clamp(0, 255) as u8;
    in "the places of blocks (T.81 A.2)":
    "takes rows to have width / 8 + 1 blocks", |r| { r.across = |width| width / 8 + 1; r.is_in_place = false; };
    "takes rows to have width / 8 blocks, rounded to the nearest", |r| { r.across = |width| (width + 4) / 8; r.is_in_place = false; };
    "takes rows to have width / 8 blocks, rounded down", |r| { r.across = |width| width / 8; r.is_in_place = false; };
    "takes width for height and height for width where blocks are cut off", |r| { r.edges = |width, height| (height, width); r.is_in_place = false; };
    "reads as many rows of blocks as a row has blocks", |r| { r.read = |across, _| across * across; r.is_in_place = false; };
    "leaves out the last row of blocks", |r| { r.read = |across, all| all - across; r.is_in_place = false; };
    "puts blocks in columns", |r| { r.block = |number, _, down| (number / down, number % down); r.is_in_place = false; };
    "puts rows of blocks from the bottom to the top", |r| { r.block = |number, across, down| (number % across, (down - 1).saturating_sub(number / across)); r.is_in_place = false; };
    "repeats the row before for the last row of a plane whose height is 1 more than a multiple of 8", |r| r.repeated = |height| usize::from(height > 8 && height % 8 == 1);
    "repeats the row before for the last row of a plane whose height is not a multiple of 8", |r| r.repeated = |height| usize::from(height > 8 && height % 8 > 0);
    "repeats the row before for the last row of a plane", |r| r.repeated = |height| usize::from(height > 1);
    "leaves out the last row of blocks where they extend past the last row, but not the only one", |r| r.rows = |height| if height > 8 { height / 8 * 8 } else { height };
    "leaves out the last row of blocks that extend past the last row", |r| r.rows = |height| if height % 8 > 0 { height - 1 } else { height };
    "leaves out the last row of blocks where they extend past the last row", |r| r.rows = |height| height / 8 * 8;
    "leaves out the last column of a plane whose width is 1 more than a multiple of 8", |r| r.edges = |width, height| (if width > 8 && width % 8 == 1 { width - 1 } else { width }, height);
    "leaves out the last column of blocks that extend past the right edge", |r| { r.copied = |columns| if columns < 8 { columns.saturating_sub(1) } else { 8 }; r.is_in_place = false; };
    "leaves out blocks that extend past the right edge", |r| { r.copied = |columns| if columns < 8 { 0 } else { 8 }; r.is_in_place = false; };
};

#[cfg(test)]
mod tests {
    use super::super::slips::tests::each_stream;
    use super::{RIGHT, decode, traced};
    use crate::decode::planes;
    use crate::ptm::Format;

    #[test]
    fn without_a_slip_streams_are_read_as_the_reference_reads_them() {
        each_stream(Format::is_jpeg, |stream| {
            let traced = traced(stream).expect("a stream");
            let read = decode(stream, &traced, &RIGHT, &mut None, &|_, _| true);
            let right = planes::stream(stream).expect("a legal stream");
            let mut pairs = read.samples.iter().zip(&right);
            assert!(pairs.all(|(read, right)| read.abs_diff(*right) <= 1));
        });
    }
}
