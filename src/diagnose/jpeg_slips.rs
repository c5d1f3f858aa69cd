//! JPEG streams decoded with one slip in the decoder of T.81.
//!
//! The codes of a stream are read by the reference; what is made of them is made here, in the plainest way, with every
//! decision a field of [`Rules`], right by default. Slips in reading the codes themselves are not among them.

use super::slips::{Partial, Slip, slips};
use crate::codec::jpeg::{self, BlockTrace};
use crate::error::Result;
use crate::parts::PlaneStream;

/// Coefficients of a block, by rows.
type Block = [i32; 64];

/// Every decision of the decoder.
struct Rules {
    /// The place of coefficient k of the zigzag order.
    place: fn(usize) -> usize,
    /// The number that was coded, and its bits.
    extend: fn(i32, u32) -> i32,
    /// The DC coefficient: the one before and the difference.
    dc: fn(i32, i32) -> i32,
    /// The DC coefficient before, after a restart and at the start of a row of blocks.
    restarted: fn(i32) -> i32,
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

/// A.3.3 in real numbers, columns first; 128 is not added yet.
fn transform(block: &Block) -> [f64; 64] {
    let table: [[f64; 8]; 8] = std::array::from_fn(|x| std::array::from_fn(|u| basis(x, u)));
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

const RIGHT: Rules = Rules {
    place: zigzag,
    extend: |value, _| value,
    dc: |before, difference| before + difference,
    restarted: |_| 0,
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
                k += run;
                let value = traced.coefficients.get(stored).copied().unwrap_or_default();
                if k <= rules.last {
                    let value = (rules.extend)(value, size) * (rules.step)(steps, k);
                    block[(rules.place)(k) % 64] = (rules.dequantized)(value);
                }
                stored += 1;
                k += 1;
            }
        }
    }
    block
}

/// The samples of a stream, as a decoder with these rules finds them; nothing where the reference does not read it.
fn decode(stream: &PlaneStream, rules: &Rules) -> Option<Partial> {
    let (width, height) = (stream.size.width as usize, stream.size.height as usize);
    let (traced, steps) = jpeg::trace(stream.bytes, stream.size.width, stream.size.height).ok()?;
    let (columns, across) = (width.div_ceil(8), (rules.across)(width));
    let mut samples = vec![0; width * height];
    let (mut dc, mut block) = (0, [0; 64]);
    // Where rows have no blocks nothing is shown.
    let shown = if across == 0 { 0 } else { traced.len() };
    for (number, one) in traced.iter().take(shown).enumerate() {
        let starts_row = number % columns == 0;
        if one.is_restarted {
            dc = (rules.restarted)(dc);
        }
        if starts_row && number > 0 {
            dc = (rules.row_started)(dc);
        }
        let size = one
            .codes
            .first()
            .map_or(0, |&(symbol, _)| u32::from(symbol));
        dc = (rules.dc)(dc, (rules.extend)(one.dc_difference, size));
        block = read(one, &steps, dc, (rules.fresh)(&block, starts_row), rules);
        let made = transform(&(rules.prepared)(block)).map(|value| value.round() as i32);
        let made = (rules.transformed)(made);
        let (left, top) = (rules.block)(number, across, height.div_ceil(8));
        let copied = (rules.copied)(width.saturating_sub(8 * left).min(8));
        for (i, &sample) in made.iter().enumerate() {
            let (x, y) = (8 * left + i % 8, 8 * top + i / 8);
            if i % 8 < copied && x < width && y < height {
                samples[y * width + x] = (rules.shown)(sample);
            }
        }
    }
    Some(Partial::whole(samples))
}

/// A stream of JPEG with this slip.
fn slipped(stream: &PlaneStream, slip: fn(&mut Rules)) -> Result<Partial> {
    let mut rules = RIGHT;
    slip(&mut rules);
    Partial::or_right(decode(stream, &rules), stream)
}

/// Two coefficients of the zigzag order exchanged.
fn exchanged(k: usize, i: usize, j: usize) -> usize {
    zigzag(if k == i {
        j
    } else if k == j {
        i
    } else {
        k
    })
}

/// A block with rows and columns exchanged.
fn transposed(values: [i32; 64]) -> [i32; 64] {
    std::array::from_fn(|i| values[i % 8 * 8 + i / 8])
}

fn signed_byte(value: i32) -> i32 {
    i32::from(value as i8)
}

pub(super) static SLIPS: &[Slip] = slips! {
    // Numbers
    "takes the largest negative number of each size for positive", |r| r.extend = |v, s| if s > 0 && v == -(1 << (s - 1)) { v + (1 << s) - 1 } else { v };
    "takes numbers of EXTEND for negative that begin with a 1 and nothing but zeros (≤ for <)", |r| r.extend = |v, s| if s > 0 && v == 1 << (s - 1) { v + 1 - (1 << s) } else { v };
    "extends negative numbers by −2^size, where 1 − 2^size belongs", |r| r.extend = |v, s| if v < 0 { v - 1 } else { v }.max(-(1 << s));
    "extends negative numbers by 2 − 2^size, where 1 − 2^size belongs", |r| r.extend = |v, _| if v < 0 { v + 1 } else { v };
    "takes all numbers for positive (no EXTEND)", |r| r.extend = |v, s| if v < 0 { v + (1 << s) - 1 } else { v };
    "gives negative numbers their magnitude", |r| r.extend = |v, _| v.abs();
    // DC
    "does not add the DC coefficient of the block before", |r| r.dc = |_, difference| difference;
    "subtracts the difference of DC coefficients", |r| r.dc = |before, difference| before - difference;
    "keeps the DC coefficient before in a signed byte", |r| r.dc = |before, difference| signed_byte(before) + difference;
    "keeps the DC coefficient in a signed byte", |r| r.dc = |before, difference| signed_byte(before + difference);
    "keeps the DC coefficient in a byte", |r| r.dc = |before, difference| (before + difference) & 0xff;
    "limits the DC coefficient to ±1023", |r| r.dc = |before, difference| (before + difference).clamp(-1023, 1023);
    "takes 0 for the DC coefficient before at the start of each row of blocks", |r| r.row_started = |_| 0;
    "keeps the DC coefficient before across restart markers", |r| r.restarted = |before| before;
    "takes 128 for the DC coefficient before after restart markers", |r| r.restarted = |_| 128;
    "takes 1024 for the DC coefficient before after restart markers", |r| r.restarted = |_| 1024;
    // AC
    "skips 15 zeros for ZRL, where 16 belong", |r| r.zeros = 15;
    "skips 17 zeros for ZRL, where 16 belong", |r| r.zeros = 17;
    "skips no zeros for ZRL", |r| r.zeros = 0;
    "leaves out coefficient 63", |r| r.last = 62;
    "leaves out the last row of the zigzag order (coefficients from 57 on)", |r| r.last = 56;
    "leaves out all AC coefficients", |r| r.last = 0;
    "leaves the coefficients of the block before, where it reads none", |r| r.fresh = |before, _| *before;
    "leaves the coefficients of the block before, but at the start of a row of blocks", |r| r.fresh = |before, starts_row| if starts_row { [0; 64] } else { *before };
    // Order
    "does not undo the zigzag order", |r| r.place = |k| k;
    "exchanges rows and columns of the zigzag order", |r| r.place = |k| zigzag(k) % 8 * 8 + zigzag(k) / 8;
    "exchanges coefficients 1 and 2 of the zigzag order", |r| r.place = |k| exchanged(k, 1, 2);
    "exchanges coefficients 61 and 62 of the zigzag order", |r| r.place = |k| exchanged(k, 61, 62);
    "exchanges coefficients 62 and 63 of the zigzag order", |r| r.place = |k| exchanged(k, 62, 63);
    "puts coefficients one place too late in the zigzag order", |r| r.place = |k| zigzag((k + 1).min(63));
    // Steps
    "uses no steps: coefficients are not dequantized", |r| r.step = |_, _| 1;
    "uses the step of DC for all coefficients", |r| r.step = |steps, _| steps[0].into();
    "uses the second step for DC", |r| r.step = |steps, k| steps[k.max(1)].into();
    "takes steps by the place in the block, without the zigzag order", |r| r.step = |steps, k| steps[zigzag(k)].into();
    "takes steps with rows and columns exchanged", |r| r.step = |steps, k| { let place = zigzag(k) % 8 * 8 + zigzag(k) / 8; (0..64).find(|&j| zigzag(j) == place).map_or(1, |j| steps[j].into()) };
    "takes steps for signed bytes", |r| r.step = |steps, k| if steps[k] < 256 { signed_byte(steps[k].into()) } else { steps[k].into() };
    "takes the step of the coefficient before", |r| r.step = |steps, k| steps[k.saturating_sub(1)].into();
    "takes the step of the next coefficient", |r| r.step = |steps, k| steps[(k + 1).min(63)].into();
    "limits dequantized coefficients to ±1023", |r| r.dequantized = |value| value.clamp(-1023, 1023);
    "limits dequantized coefficients to ±2047", |r| r.dequantized = |value| value.clamp(-2047, 2047);
    "keeps dequantized coefficients in a signed byte", |r| r.dequantized = signed_byte;
    // Inverse transform
    "exchanges rows and columns of the coefficients of a block", |r| r.prepared = transposed;
    "exchanges rows and columns of the samples of a block", |r| r.transformed = transposed;
    "turns each block upside down", |r| r.transformed = |samples| std::array::from_fn(|i| samples[(7 - i / 8) * 8 + i % 8]);
    "mirrors each block from left to right", |r| r.transformed = |samples| std::array::from_fn(|i| samples[i / 8 * 8 + 7 - i % 8]);
    "takes a column of a block for flat whose coefficients of the rows 1 to 6 are 0, without the last row", |r| r.prepared = |block| std::array::from_fn(|i| if i >= 56 && (1..7).all(|y| block[8 * y + i % 8] == 0) { 0 } else { block[i] });
    "takes a column of a block for flat whose coefficients of the rows 2 to 7 are 0, without the row 1", |r| r.prepared = |block| std::array::from_fn(|i| if i / 8 == 1 && (2..8).all(|y| block[8 * y + i % 8] == 0) { 0 } else { block[i] });
    "takes a row of a block for flat whose coefficients of the columns 1 to 6 are 0, without the last column", |r| r.prepared = |block| std::array::from_fn(|i| if i % 8 == 7 && (1..7).all(|x| block[i / 8 * 8 + x] == 0) { 0 } else { block[i] });
    "leaves out the last row of coefficients", |r| r.prepared = |block| std::array::from_fn(|i| if i >= 56 { 0 } else { block[i] });
    "leaves out the last column of coefficients", |r| r.prepared = |block| std::array::from_fn(|i| if i % 8 == 7 { 0 } else { block[i] });
    "divides samples by 4, where 8 belongs", |r| r.transformed = |samples| samples.map(|sample| 2 * sample);
    "divides samples by 16, where 8 belongs", |r| r.transformed = |samples| samples.map(|sample| sample / 2);
    // Samples
    "lets samples below 0 wrap around", |r| r.shown = |sample| (sample + 128).min(255) as u8;
    "lets samples above 255 wrap around", |r| r.shown = |sample| (sample + 128).max(0) as u8;
    "lets samples beyond 0…255 wrap around", |r| r.shown = |sample| (sample + 128) as u8;
    "limits samples to ±127 before 128 is added", |r| r.shown = |sample| (sample.clamp(-127, 127) + 128) as u8;
    "limits samples to 0…255 before 128 is added", |r| r.shown = |sample| (sample.clamp(0, 255) + 128) as u8;
    "adds 127 to samples, where 128 belongs", |r| r.shown = |sample| (sample + 127).clamp(0, 255) as u8;
    "shows samples inverted", |r| r.shown = |sample| (127 - sample).clamp(0, 255) as u8;
    // Blocks
    "takes rows to have width / 8 + 1 blocks", |r| r.across = |width| width / 8 + 1;
    "takes rows to have width / 8 blocks, rounded to the nearest", |r| r.across = |width| (width + 4) / 8;
    "takes rows to have width / 8 blocks, rounded down", |r| r.across = |width| width / 8;
    "puts blocks in columns", |r| r.block = |number, _, down| (number / down, number % down);
    "puts rows of blocks from the bottom to the top", |r| r.block = |number, across, down| (number % across, (down - 1).saturating_sub(number / across));
    "leaves out the last column of blocks that extend past the right edge", |r| r.copied = |columns| if columns < 8 { columns.saturating_sub(1) } else { 8 };
    "leaves out blocks that extend past the right edge", |r| r.copied = |columns| if columns < 8 { 0 } else { 8 };
};

#[cfg(test)]
mod tests {
    use super::super::slips::tests::each_stream;
    use super::{RIGHT, decode};
    use crate::decode::planes;
    use crate::ptm::Format;

    #[test]
    fn without_a_slip_streams_are_read_as_the_reference_reads_them() {
        each_stream(Format::is_jpeg, |stream| {
            let read = decode(stream, &RIGHT).expect("a stream");
            let right = planes::stream(stream).expect("a legal stream");
            let mut pairs = read.samples.iter().zip(&right);
            assert!(pairs.all(|(read, right)| read.abs_diff(*right) <= 1));
        });
    }
}
