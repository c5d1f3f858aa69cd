//! Random numbers that are the same everywhere.

/// A linear congruential generator; each draw is its upper 16 bits.
pub struct Draws(pub u32);

impl Draws {
    pub fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.0 >> 16
    }

    pub fn below(&mut self, end: usize) -> usize {
        self.next() as usize % end
    }

    pub fn byte(&mut self) -> u8 {
        self.below(256) as u8
    }
}
