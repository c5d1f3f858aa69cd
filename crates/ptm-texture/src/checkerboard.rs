//! Default map: a checkerboard of 8×8 squares on 16×16 texels, white at the origin (R-SEL-11 … R-SEL-13).

use super::map::{Level, Texel, TextureMap};
use super::rules::Rules;

impl TextureMap {
    /// Creates the default map (R-SEL-11, R-SEL-12).
    #[must_use]
    pub fn checkerboard(rules: &Rules) -> TextureMap {
        let (side, square) = (rules.checkerboard)();
        let texel = |at: usize| {
            let (i, j) = (at % side / square, at / side / square);
            Texel::rgb([f64::from(u8::from((rules.is_white)(i, j))); 3])
        };
        let base = Level {
            size: [side, side, 1],
            texels: (0..side * side).map(texel).collect(),
        };
        TextureMap::new(2, vec![base]).expect("a checkerboard has texels")
    }
}

/// Returns the side lengths in texels of the default map and of a square (R-SEL-12).
pub fn board_and_square_size() -> (usize, usize) {
    (16, 2)
}

/// Returns true if square (i, j) of the default map is white, like square (0, 0) (R-SEL-13).
pub fn is_white_square(i: usize, j: usize) -> bool {
    (i + j).is_multiple_of(2)
}
