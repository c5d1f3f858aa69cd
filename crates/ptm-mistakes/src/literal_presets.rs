//! T.87 Annex A: a JPEG-LS decoder that takes zeros among the preset parameters literally
//!
//! A 0 in an LSE segment means the default value (T.87 C.2.4.1.1). This decoder uses it as it is:
//!
//! - MAXVAL 0 leaves a single sample value, 0.
//! - A gradient of 0 is "at most −T" for a threshold T of 0, so that it belongs to a negative region.
//! - RESET 0 halves the statistics after every error.
//!
//! The bits no longer fit the model. Impossible codes count as 0, and runs end with their line. At the end of the data, the buffer is
//! filled with eight zeros at a time, and a number that needs more is an error. In all of this, the decoder equals pylibjpeg-libjpeg
//! 2.5.0 (libjpeg by Thomas Richter).

use ptm::Size;

/// J by `RUNindex` (A.2.1).
const J: [u32; 32] = [
    0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13,
    14, 15,
];

/// Largest parameter k of a Golomb code. A context that needs a larger one has lost its synchronization.
const LARGEST_K: u32 = 23;

/// Parameters of a scan, as they are in the stream.
pub struct LiteralPresets {
    pub maxval: i64,
    /// T1, T2 and T3.
    pub thresholds: [i64; 3],
    pub reset: i64,
    pub near: i64,
}

/// Decodes entropy-coded data of `size` samples. Returns `None` if the data end too early.
pub fn decode(data: &[u8], size: Size, presets: &LiteralPresets) -> Option<Vec<u8>> {
    let LiteralPresets { maxval, near, .. } = *presets;
    // A.2.1.
    let step = 2 * near + 1;
    let range = (maxval + 2 * near) / step + 1;
    let (qbpp, bpp) = (bit_width(range - 1).max(1), bit_width(maxval).max(2));
    let fresh = Context {
        a: ((range + 32) / 64).max(2),
        b: 0,
        c: 0,
        n: 1,
    };
    let mut scan = Scan {
        presets,
        step,
        range,
        qbpp,
        limit: 2 * (bpp + bpp.max(8)) - qbpp - 1,
        bits: Bits::new(data),
        contexts: [fresh; 365],
        run_contexts: [fresh; 2],
        run_index: 0,
    };
    let width = size.width as usize;
    let mut samples = Vec::with_capacity(size.texels());
    let mut above = vec![0; width + 2];
    for _ in 0..size.height {
        above = scan.decode_line(&above)?;
        samples.extend(above[1..=width].iter().map(|&sample| sample as u8));
    }
    Some(samples)
}

/// Returns the number of bits of a number.
fn bit_width(number: i64) -> u32 {
    i64::BITS - number.leading_zeros()
}

/// Statistics of a context. In run mode, `b` is the number of negative errors, and `c` is unused.
#[derive(Clone, Copy)]
struct Context {
    a: i64,
    b: i64,
    c: i64,
    n: i64,
}

impl Context {
    /// Returns k for the sum of magnitudes `a` (A.5.1).
    fn golomb_parameter(&self, a: i64) -> u32 {
        let is_enough = |k: &u32| self.n << k >= a;
        (0..=LARGEST_K).find(is_enough).unwrap_or(0)
    }

    /// Counts an error, after halving the statistics if there are at least `reset` errors.
    fn count(&mut self, reset: i64) {
        if self.n >= reset {
            self.a >>= 1;
            self.b >>= 1;
            self.n >>= 1;
        }
        self.n += 1;
    }
}

struct Scan<'a> {
    presets: &'a LiteralPresets,
    step: i64,
    range: i64,
    qbpp: u32,
    /// Largest number of zeros before a code in plain binary.
    limit: u32,
    bits: Bits,
    contexts: [Context; 365],
    run_contexts: [Context; 2],
    run_index: usize,
}

impl Scan<'_> {
    /// Decodes a line below `above`. Both have a sample before the first and after the last one.
    fn decode_line(&mut self, above: &[i64]) -> Option<Vec<i64>> {
        let width = above.len() - 2;
        let mut line = vec![0; width + 2];
        line[0] = above[1];
        let mut column = 1;
        while column <= width {
            // A.3.1: a on the left, and c, b and d above, from left to right.
            let (a, [c, b, d]) = (
                line[column - 1],
                [above[column - 1], above[column], above[column + 1]],
            );
            let gradients = [d - b, b - c, c - a];
            let is_flat = gradients.iter().all(|d| d.abs() <= self.presets.near);
            if is_flat {
                let end = column + self.decode_run(width + 1 - column)?;
                line[column..end].fill(a);
                column = end;
            }
            if column <= width {
                line[column] = match is_flat {
                    true => self.decode_interruption(line[column - 1], above[column])?,
                    false => self.decode_regular(gradients, [a, b, c])?,
                };
                column += 1;
            }
        }
        line[width + 1] = line[width];
        Some(line)
    }

    /// Returns the length of a run (A.7.1), at most `left`.
    fn decode_run(&mut self, left: usize) -> Option<usize> {
        let mut run = 0;
        while self.bits.read(1)? == 1 {
            run += 1 << J[self.run_index];
            if run <= left {
                self.run_index = (self.run_index + 1).min(31);
            }
            if run >= left {
                return Some(left);
            }
        }
        let rest = self.bits.read(J[self.run_index])? as usize;
        Some((run + rest).min(left))
    }

    /// Decodes the sample after a run (A.7.2).
    fn decode_interruption(&mut self, a: i64, b: i64) -> Option<i64> {
        let is_near = (a - b).abs() <= self.presets.near;
        let kind = i64::from(is_near);
        let context = self.run_contexts[usize::from(is_near)];
        let k = context.golomb_parameter(context.a + kind * (context.n >> 1));
        let mapped = self.read_golomb(k, self.limit - J[self.run_index] - 1)?;
        let positive_first = k == 0 && 2 * context.b < context.n;
        let error = unmap(mapped + kind);
        let error = if positive_first { -error } else { error };
        let context = &mut self.run_contexts[usize::from(is_near)];
        context.b += i64::from(error < 0);
        context.a += error.abs() - kind;
        context.count(self.presets.reset);
        self.run_index = self.run_index.saturating_sub(1);
        Some(match is_near {
            true => self.reconstruct(a, error),
            false => self.reconstruct(b, if a > b { -error } else { error }),
        })
    }

    /// Decodes a sample in regular mode (A.4 – A.6).
    fn decode_regular(&mut self, gradients: [i64; 3], [a, b, c]: [i64; 3]) -> Option<i64> {
        let [q1, q2, q3] = gradients.map(|gradient| self.region(gradient));
        let number = 81 * q1 + 9 * q2 + q3;
        let sign = if number < 0 { -1 } else { 1 };
        let index = number.unsigned_abs() as usize;
        let context = self.contexts[index];
        let predicted = match c {
            c if c >= a.max(b) => a.min(b),
            c if c <= a.min(b) => a.max(b),
            _ => a + b - c,
        };
        let predicted = (predicted + sign * context.c).clamp(0, self.presets.maxval);
        let k = context.golomb_parameter(context.a);
        let error = unmap(self.read_golomb(k, self.limit)?);
        let negative_first = self.presets.near == 0 && k == 0 && 2 * context.b <= -context.n;
        let error = if negative_first { -1 - error } else { error };

        let context = &mut self.contexts[index];
        context.b += error * self.step;
        context.a += error.abs();
        context.count(self.presets.reset);
        if context.b <= -context.n {
            context.c = (context.c - 1).max(-128);
            context.b = (context.b + context.n).max(1 - context.n);
        } else if context.b > 0 {
            context.c = (context.c + 1).min(127);
            context.b = (context.b - context.n).min(0);
        }
        Some(self.reconstruct(predicted, sign * error))
    }

    /// Returns the region of a gradient: the first interval that contains it, from the most negative one on (A.3.3).
    fn region(&self, gradient: i64) -> i64 {
        let [t1, t2, t3] = self.presets.thresholds;
        let near = self.presets.near;
        match gradient {
            d if d <= -t3 => -4,
            d if d <= -t2 => -3,
            d if d <= -t1 => -2,
            d if d < -near => -1,
            d if d <= near => 0,
            d if d < t1 => 1,
            d if d < t2 => 2,
            d if d < t3 => 3,
            _ => 4,
        }
    }

    /// Adds an error to a prediction (A.4.5).
    fn reconstruct(&self, predicted: i64, error: i64) -> i64 {
        let LiteralPresets { maxval, near, .. } = *self.presets;
        let mut value = predicted + error * self.step;
        if value < -near {
            value += self.range * self.step;
        }
        if value > maxval + near {
            value -= self.range * self.step;
        }
        value.clamp(0, maxval)
    }

    /// Reads a Golomb code, or returns 0 if it starts with more than `limit` zeros.
    fn read_golomb(&mut self, k: u32, limit: u32) -> Option<i64> {
        let mut zeros = 0;
        loop {
            let more = self.bits.count_zeros_of_eight();
            zeros += more;
            if zeros > limit {
                return Some(0);
            }
            if more == 8 {
                self.bits.skip(8)?;
                continue;
            }
            self.bits.skip(more as usize + 1)?;
            return Some(match zeros == limit {
                true => self.bits.read(self.qbpp)? + 1,
                false => (i64::from(zeros) << k) | self.bits.read(k)?,
            });
        }
    }
}

/// Returns the error with this number in the order 0, −1, 1, −2, 2 …
fn unmap(mapped: i64) -> i64 {
    (mapped >> 1) ^ -(mapped & 1)
}

/// The bits of a scan, without those that are stuffed after a byte 0xFF (A.1).
struct Bits {
    data: Vec<bool>,
    at: usize,
    /// End of the buffered bits. After the last bit of the data, there are zeros.
    buffered: usize,
}

impl Bits {
    fn new(data: &[u8]) -> Bits {
        let mut bits = Vec::with_capacity(8 * data.len());
        let mut previous = 0;
        for (i, &byte) in data.iter().enumerate() {
            let is_marker = byte == 0xFF && data.get(i + 1).is_none_or(|&next| next >= 0x80);
            if is_marker {
                break;
            }
            let count = if previous == 0xFF { 7 } else { 8 };
            bits.extend((0..count).rev().map(|bit| byte >> bit & 1 == 1));
            previous = byte;
        }
        Bits {
            data: bits,
            at: 0,
            buffered: 0,
        }
    }

    fn bit(&self, at: usize) -> bool {
        self.data.get(at).copied().unwrap_or(false)
    }

    /// Buffers 25 bits, or eight zeros more if the data end before.
    fn fill(&mut self) {
        if self.buffered < self.data.len() {
            self.buffered = self.data.len().min(self.at + 25);
        }
        if self.buffered < self.at + 25 {
            self.buffered += 8;
        }
    }

    fn skip(&mut self, count: usize) -> Option<()> {
        self.at += count;
        (self.at <= self.buffered).then_some(())
    }

    fn read(&mut self, count: u32) -> Option<i64> {
        let from = self.at;
        if from + count as usize > self.buffered {
            self.fill();
        }
        self.skip(count as usize)?;
        let bits = (from..self.at).map(|at| i64::from(self.bit(at)));
        Some(bits.fold(0, |value, bit| value << 1 | bit))
    }

    /// Returns the number of zeros at the start of the next eight bits.
    fn count_zeros_of_eight(&mut self) -> u32 {
        if self.at + 16 > self.buffered {
            self.fill();
        }
        let is_one = |&i: &usize| self.bit(self.at + i);
        (0..8).find(is_one).unwrap_or(8) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::{LiteralPresets, decode};
    use ptm::Size;

    /// pylibjpeg-libjpeg 2.5.0 decodes these data, which were encoded with the default parameters, to these samples.
    #[test]
    fn zeros_are_taken_as_in_libjpeg() {
        let data = b"\x00\x00\x01\xfb\x8c\x01\x71\x4e\x04\x06\x88\xa4\x21\x46\x3d\x5a\x58\x33\x90\xd0\xed\xc0\xff\xd9";
        let size = Size {
            width: 6,
            height: 5,
        };
        let decode_with = |maxval, thresholds, reset| {
            let presets = LiteralPresets {
                maxval,
                thresholds,
                reset,
                near: 0,
            };
            decode(data, size, &presets).expect("enough data")
        };
        let seen = [
            129, 129, 131, 123, 120, 124, 135, 147, 136, 128, 130, 128, 137, 140, 139, 147, 150,
            148, 136, 136, 136, 143, 145, 138, 128, 127, 116, 113, 112, 113,
        ];
        assert_eq!(decode_with(255, [0, 7, 0], 0), seen);
        assert_eq!(decode_with(0, [3, 7, 21], 64), [0; 30]);
    }
}
