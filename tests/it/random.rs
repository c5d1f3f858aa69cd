//! Reproducible pseudorandom numbers.

/// A linear congruential generator. Each draw returns the upper 16 bits of its state.
pub struct Rng(pub u32);

impl Rng {
    pub fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.0 >> 16
    }

    pub fn next_below(&mut self, end: usize) -> usize {
        self.next() as usize % end
    }

    pub fn byte(&mut self) -> u8 {
        self.next_below(256) as u8
    }

    /// Makes one to four random edits. With equal probability, an edit is either before byte `header` or anywhere in the file.
    pub fn damage(&mut self, file: &mut Vec<u8>, header: usize) {
        for _ in 0..=self.next_below(4) {
            let end = [header, file.len()][self.next_below(2)].min(file.len());
            let at = self.next_below(end + 1);
            let rest = file.len() - at;
            let special = b"\x00\xff\x7f\x80\xd8\xd9\xda0123456789-. \n\t";
            let numbers = "0 -1 255 256 65536 4294967296 1e300 99999999999999999999";
            match self.next_below(9) {
                0 if rest > 0 => file[at] ^= 1 << self.next_below(8),
                1 if rest > 0 => file[at] = self.byte(),
                2 if rest > 0 => file[at] = special[self.next_below(special.len())],
                3 if rest > 0 => drop(file.remove(at)),
                4 => file.insert(at, self.byte()),
                5 => file.insert(at, special[self.next_below(special.len())]),
                6 => {
                    let number = numbers
                        .split(' ')
                        .nth(self.next_below(8))
                        .expect("a number");
                    file.splice(at..at, number.bytes());
                }
                7 => file.truncate(at),
                _ => {
                    let piece = file[at..at + self.next_below(rest.min(64) + 1)].to_vec();
                    file.splice(at..at, piece);
                }
            }
        }
    }
}
