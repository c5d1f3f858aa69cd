//! T.87 A.3.1, A.2.1: the causal template
//!
//! The neighbors of the sample x are decoded samples: a is left of x, b is above x, and c and d are left and right of b.
//!
//! ```text
//!     c  b  d
//!     a  x
//! ```
//!
//! Worked example: the neighbors at the edges of two lines with three samples.
//!
//! ```text
//!  0 |  0  0  0 | 0     the line above the first one is zero
//!  0 | 10 20 30 | 30    at the right edge, d equals b
//! 10 | 40 50 60         at the left edge, a equals b
//! ```
//!
//! Format notes
//! - For the first sample of a line, c is the value of a at the start of the previous line. In the example it is 0
//!   for the sample 40, and *not* 10.

/// The previous and the current line. Each has one extra sample on the left and two on the right, so column x is at index x + 1.
pub(super) struct Lines {
    above: Vec<u8>,
    line: Vec<u8>,
}

/// The four neighbors of a sample.
#[derive(Clone, Copy)]
pub struct Neighbors {
    pub a: i32,
    pub b: i32,
    pub c: i32,
    pub d: i32,
}

impl Lines {
    pub fn new(width: u32) -> Lines {
        let zeros = vec![0; width as usize + 3];
        Lines {
            above: zeros.clone(),
            line: zeros,
        }
    }

    /// Moves to the next line and sets its edges.
    pub fn next(&mut self) {
        std::mem::swap(&mut self.above, &mut self.line);
        let width = self.width();
        self.above[width + 1] = self.above[width];
        self.line[0] = self.above[1];
    }

    pub fn width(&self) -> usize {
        self.line.len() - 3
    }

    /// Returns the neighbors of the sample in column `x`.
    pub fn neighbors(&self, x: usize) -> Neighbors {
        Neighbors {
            a: i32::from(self.line[x]),
            b: i32::from(self.above[x + 1]),
            c: i32::from(self.above[x]),
            d: i32::from(self.above[x + 2]),
        }
    }

    /// Sets the sample in column `x`, given its neighbors. Returns the neighbors of the next sample.
    #[inline]
    pub fn set_sample(&mut self, x: usize, sample: i32, neighbors: Neighbors) -> Neighbors {
        self.line[x + 1] = sample as u8;
        Neighbors {
            a: sample,
            b: neighbors.d,
            c: neighbors.b,
            d: i32::from(self.above[x + 3]),
        }
    }

    /// Sets a run of samples that starts in column `x`.
    pub fn fill(&mut self, x: usize, run: usize, sample: i32) {
        self.line[x + 1..][..run].fill(sample as u8);
    }

    /// Returns the samples of the current line.
    pub fn samples(&self) -> &[u8] {
        &self.line[1..=self.width()]
    }
}
