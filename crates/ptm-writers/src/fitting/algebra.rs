//! Least squares for the six coefficients of a polynomial.

use crate::fitting::photographs::MAX_RANK_TOLERANCE;

/// Evaluates the terms u², v², uv, u, v and 1 of clause 1.0/1 under a light.
fn terms([u, v]: [f64; 2]) -> [f64; 6] {
    [u * u, v * v, u * v, u, v, 1.0]
}

/// Least-squares solver for a fixed set of lights. If there are several solutions, it returns the one with the smallest norm.
#[derive(Debug)]
pub(super) struct LeastSquares {
    /// Pseudoinverse: for each light, the contribution of its value to each coefficient.
    rows: Vec<[f64; 6]>,
    /// True if the lights determine all six coefficients, with a margin for rounding errors.
    pub is_determined: bool,
}

impl LeastSquares {
    /// Computes the pseudoinverse for the given lights. Singular values of at most `tolerance`, relative to the largest, count as 0.
    pub fn new(lights: &[[f64; 2]], tolerance: f64) -> LeastSquares {
        let design: Vec<[f64; 6]> = lights.iter().map(|&light| terms(light)).collect();
        let product = |i: usize, j: usize| design.iter().map(|row| row[i] * row[j]).sum();
        let normal: [[f64; 6]; 6] = std::array::from_fn(|i| std::array::from_fn(|j| product(i, j)));
        let (values, vectors) = eigensystem(normal);
        let largest = values.iter().copied().fold(0.0, f64::max);
        // An eigenvalue of the normal matrix is the square of a singular value.
        let is_significant = |k: &usize| values[*k] > tolerance * tolerance * largest;
        let row = |light: &[f64; 6]| {
            let mut row = [0.0; 6];
            for k in (0..6).filter(is_significant) {
                let projection: f64 = (0..6).map(|i| vectors[i][k] * light[i]).sum();
                for (i, value) in row.iter_mut().enumerate() {
                    *value += vectors[i][k] * projection / values[k];
                }
            }
            row
        };
        LeastSquares {
            rows: design.iter().map(row).collect(),
            is_determined: (0..6)
                .all(|k| values[k] > MAX_RANK_TOLERANCE * MAX_RANK_TOLERANCE * largest),
        }
    }

    /// Returns the best polynomial for one value per light.
    pub fn fit(&self, values: impl Iterator<Item = f64>) -> [f64; 6] {
        let rows = self.rows.iter().zip(values);
        rows.fold([0.0; 6], |sums, (row, value)| {
            std::array::from_fn(|i| sums[i] + row[i] * value)
        })
    }
}

/// Computes the eigenvalues and eigenvectors (as columns) of a symmetric matrix by Jacobi rotations.
pub(super) fn eigensystem<const N: usize>(mut matrix: [[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut vectors: [[f64; N]; N] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    for _ in 0..50 {
        for p in 0..N {
            for q in p + 1..N {
                if matrix[p][q] != 0.0 {
                    rotate(&mut matrix, &mut vectors, p, q);
                }
            }
        }
    }
    (std::array::from_fn(|i| matrix[i][i]), vectors)
}

/// Rotates rows and columns `p` and `q` so that element (`p`, `q`) becomes zero.
fn rotate<const N: usize>(m: &mut [[f64; N]; N], v: &mut [[f64; N]; N], p: usize, q: usize) {
    let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
    let tangent = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;
    let rotate_pair = |a: f64, b: f64| (cosine * a - sine * b, sine * a + cosine * b);
    for row in m.iter_mut().chain(v) {
        (row[p], row[q]) = rotate_pair(row[p], row[q]);
    }
    let (above, below) = m.split_at_mut(q);
    for (a, b) in above[p].iter_mut().zip(&mut below[0]) {
        (*a, *b) = rotate_pair(*a, *b);
    }
}
