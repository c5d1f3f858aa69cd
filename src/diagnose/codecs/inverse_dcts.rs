//! What is wrong with an inverse DCT, solved from the blocks that were shown.
//!
//! An inverse DCT is linear: rows and columns of a block are each multiplied by one matrix of 8 × 8. One wrong constant of a
//! fast transform, one wrong factor of a table or one wrong basis function changes that matrix by one number, which the
//! samples tell. It is said where with this number all samples of all blocks come out as they were shown.

use std::f64::consts::PI;

/// Coefficients of a block, by rows, and its samples as far as they are shown.
pub(in crate::diagnose) struct ShownBlock {
    pub coefficients: [i32; 64],
    pub samples: [Option<u8>; 64],
}

type Matrix = [[f64; 8]; 8];

/// The constants of the transform of Loeffler, Ligtenberg and Moschytz, as libjpeg names and uses them.
const CONSTANTS: [f64; 12] = [
    0.298_631_336,
    0.390_180_644,
    0.541_196_100,
    0.765_366_865,
    0.899_976_223,
    1.175_875_602,
    1.501_321_110,
    1.847_759_065,
    1.961_570_560,
    2.053_119_869,
    2.562_915_447,
    3.072_711_026,
];

/// One number of a transform.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Number {
    /// A place in [`CONSTANTS`].
    Constant(usize),
    /// The factor of a coefficient in one sample of eight: the sample and the coefficient.
    Factor(usize, usize),
    /// What all factors of a coefficient are multiplied by.
    Basis(usize),
}

impl Number {
    fn all() -> impl Iterator<Item = Number> {
        let factors = (0..64).map(|i| Number::Factor(i / 8, i % 8));
        let constants = (0..12).map(Number::Constant);
        constants.chain((0..8).map(Number::Basis)).chain(factors)
    }

    /// What it should be.
    fn right(self) -> f64 {
        match self {
            Number::Constant(place) => CONSTANTS[place],
            Number::Factor(sample, coefficient) => factor(sample, coefficient),
            Number::Basis(_) => 1.0,
        }
    }

    /// The transform, where it is another.
    fn matrix(self, number: f64) -> Matrix {
        let mut matrix: Matrix = std::array::from_fn(|x| std::array::from_fn(|u| factor(x, u)));
        match self {
            Number::Constant(place) => {
                let mut constants = CONSTANTS;
                constants[place] = number;
                return fast(&constants);
            }
            Number::Factor(sample, coefficient) => matrix[sample][coefficient] = number,
            Number::Basis(coefficient) => {
                for row in &mut matrix {
                    row[coefficient] *= number;
                }
            }
        }
        matrix
    }

    fn says(self, number: f64) -> String {
        let right = self.right();
        match self {
            Number::Constant(_) => format!(
                "as if the constant {right:.9} of its inverse DCT ({:.0} of 8192) were about {number:.4} ({:.0} of 8192)",
                right * 8192.0,
                number * 8192.0
            ),
            Number::Factor(sample, coefficient) => format!(
                "as if the factor of coefficient {coefficient} in sample {sample} of eight, both counted from 0, were about {number:.4} and not {right:.4} in its inverse DCT"
            ),
            Number::Basis(coefficient) => format!(
                "as if coefficient {coefficient} of eight, counted from 0, were multiplied by about {number:.4} in its inverse DCT"
            ),
        }
    }
}

/// A.3.3: the factor of coefficient `u` in sample `x`, times √8.
fn factor(x: usize, u: usize) -> f64 {
    let scale = if u == 0 { 1.0 } else { 2.0_f64.sqrt() };
    scale * ((2 * x + 1) as f64 * u as f64 * PI / 16.0).cos()
}

/// The fast transform with these constants, as a matrix.
fn fast(k: &[f64; 12]) -> Matrix {
    let mut matrix = [[0.0; 8]; 8];
    for u in 0..8 {
        let mut c = [0.0; 8];
        c[u] = 1.0;
        let z = (c[2] + c[6]) * k[2];
        let (even2, even3) = (z - c[6] * k[7], z + c[2] * k[3]);
        let (even0, even1) = (c[0] + c[4], c[0] - c[4]);
        let even = [even0 + even3, even1 + even2, even1 - even2, even0 - even3];
        let z5 = (c[7] + c[3] + c[5] + c[1]) * k[5];
        let (z1, z2) = (-(c[7] + c[1]) * k[4], -(c[5] + c[3]) * k[10]);
        let (z3, z4) = (z5 - (c[7] + c[3]) * k[8], z5 - (c[5] + c[1]) * k[1]);
        let odd = [
            c[1] * k[6] + z1 + z4,
            c[3] * k[11] + z2 + z3,
            c[5] * k[9] + z2 + z4,
            c[7] * k[0] + z1 + z3,
        ];
        for x in 0..4 {
            matrix[x][u] = even[x] + odd[x];
            matrix[7 - x][u] = even[x] - odd[x];
        }
    }
    matrix
}

/// The samples of a block, 128 added, not rounded or limited.
fn transform(matrix: &Matrix, coefficients: &[i32; 64]) -> [f64; 64] {
    let half: [f64; 64] = std::array::from_fn(|i| {
        let (y, u) = (i / 8, i % 8);
        (0..8)
            .map(|v| matrix[y][v] * f64::from(coefficients[8 * v + u]))
            .sum()
    });
    std::array::from_fn(|i| {
        let (y, x) = (i / 8, i % 8);
        let sum: f64 = (0..8).map(|u| matrix[x][u] * half[8 * y + u]).sum();
        sum / 8.0 + 128.0
    })
}

/// By how much a sample may be off: it is rounded, and so are the values between two passes.
const ROUNDING: f64 = 1.5;
/// By how much more it may be off in a picture that is right.
const TOLERANCE: f64 = 2.0;
/// Blocks from which a number is solved, and fewer that tell nothing.
const SOLVED_FROM: usize = 120;
const FEWEST: usize = 8;
/// Steps until it is found.
const STEPS: usize = 6;

/// By how much a sample is off that should be `made`.
fn off(made: f64, shown: u8) -> f64 {
    f64::from(shown) - made.clamp(0.0, 255.0)
}

/// How far the samples of a block are from what this transform makes.
fn farthest(matrix: &Matrix, block: &ShownBlock) -> f64 {
    let made = transform(matrix, &block.coefficients);
    let pairs = made.iter().zip(&block.samples);
    let offs = pairs.filter_map(|(&made, shown)| Some(off(made, (*shown)?).abs()));
    offs.fold(0.0, f64::max)
}

/// The largest error of any sample.
pub(in crate::diagnose) fn largest_error(blocks: &[ShownBlock]) -> f64 {
    let right = fast(&CONSTANTS);
    blocks
        .iter()
        .map(|block| farthest(&right, block))
        .fold(0.0, f64::max)
}

/// The one number of the inverse DCT with which these blocks are as they were shown, in words. `right_ones` are blocks that are
/// shown right, but for what inverse transforms may differ.
pub(in crate::diagnose) fn wrong_number(
    blocks: &[ShownBlock],
    right_ones: &[ShownBlock],
) -> Option<String> {
    let right = fast(&CONSTANTS);
    let mut wrong: Vec<&ShownBlock> = (blocks.iter())
        .filter(|block| farthest(&right, block) > ROUNDING)
        .collect();
    if wrong.len() < FEWEST {
        return None;
    }
    let step = wrong.len().div_ceil(SOLVED_FROM);
    wrong = wrong.into_iter().step_by(step).collect();
    Number::all().find_map(|one| {
        let number = solve(one, &wrong)?;
        let matrix = one.matrix(number);
        let is_so = |block: &&ShownBlock| farthest(&matrix, block) <= ROUNDING;
        let is_right = |block: &ShownBlock| farthest(&matrix, block) <= ROUNDING + TOLERANCE;
        let is_it = wrong.iter().all(is_so) && blocks.iter().all(|block| is_so(&block));
        (is_it && right_ones.iter().all(is_right)).then(|| one.says(number))
    })
}

/// What a number is that these blocks were made with, by least squares.
fn solve(one: Number, blocks: &[&ShownBlock]) -> Option<f64> {
    const LITTLE: f64 = 1e-4;
    let mut number = one.right();
    for _ in 0..STEPS {
        let (here, there) = (one.matrix(number), one.matrix(number + LITTLE));
        let (mut product, mut square) = (0.0, 0.0);
        for block in blocks {
            let made = transform(&here, &block.coefficients);
            let next = transform(&there, &block.coefficients);
            for i in 0..64 {
                // What is limited tells nothing.
                if let Some(shown) = block.samples[i].filter(|&shown| shown > 0 && shown < 255) {
                    let slope = (next[i] - made[i]) / LITTLE;
                    product += slope * (f64::from(shown) - made[i]);
                    square += slope * slope;
                }
            }
        }
        if square == 0.0 {
            return None;
        }
        number += product / square;
    }
    number.is_finite().then_some(number)
}

#[cfg(test)]
mod tests {
    use super::{CONSTANTS, Matrix, Number, ShownBlock, factor, fast, transform, wrong_number};

    fn blocks(matrix: &Matrix) -> Vec<ShownBlock> {
        let of = |seed: i32| {
            let coefficients: [i32; 64] = std::array::from_fn(|i| {
                let i = i as i32;
                let scale = if i % 8 < 5 && i < 40 { 9 } else { 1 };
                scale * ((seed * 37 + i * 61 + seed * i * 7) % 41 - 20)
            });
            let samples = transform(matrix, &coefficients);
            ShownBlock {
                coefficients,
                samples: samples.map(|sample| Some(sample.round().clamp(0.0, 255.0) as u8)),
            }
        };
        (1..60).map(of).collect()
    }

    #[test]
    fn the_fast_transform_is_that_of_the_standard() {
        let fast = fast(&CONSTANTS);
        for (x, row) in fast.iter().enumerate() {
            for (u, value) in row.iter().enumerate() {
                assert!((value - factor(x, u)).abs() < 1e-6, "{x} {u}: {value}");
            }
        }
    }

    #[test]
    fn one_wrong_number_of_a_transform_is_found() {
        for (number, wrong, words) in [
            (Number::Constant(3), 0.9, "constant 0.765366865"),
            (Number::Constant(11), -3.072_711_026, "were about -3.07"),
            (Number::Factor(2, 3), -0.9, "coefficient 3 in sample 2"),
            (Number::Basis(4), 0.5, "coefficient 4 of eight"),
        ] {
            let told = wrong_number(&blocks(&number.matrix(wrong)), &[]);
            assert!(
                told.as_ref().is_some_and(|told| told.contains(words)),
                "{number:?}: {told:?}"
            );
        }
        assert_eq!(wrong_number(&blocks(&fast(&CONSTANTS)), &[]), None);
    }
}
