//! The samples of a scene, computed with integers only, so that a recipe produces the same values on every machine.

use super::recipe::{Indices, Recipe};
use super::scene::Scene;

/// Returns the painted value of one channel of a texel or of a table entry.
#[expect(
    clippy::match_same_arms,
    reason = "a table is easier to read with one line per row"
)]
pub fn sample(recipe: &Recipe, texel: usize, channel: usize) -> u8 {
    let noise = hash(recipe.seed, texel, channel) as u8;
    if recipe.scene == Scene::Noise {
        // The most frequent scene returns early, without the divisions for coordinates.
        return noise;
    }
    let (width, height) = (recipe.size.width as usize, recipe.size.height as usize);
    let (x, y) = (texel % width, texel / width);
    match recipe.scene {
        Scene::Noise => noise,
        Scene::Extremes => noise % 2 * 255,
        Scene::Ramp => (x * 7 + y * 29 + channel * 53 + recipe.seed as usize) as u8,
        Scene::Stripes => (10 + channel * 13 + recipe.seed as usize) as u8,
        Scene::Breaks if y == 0 && x < 128 && x % 5 == 3 => 1 + channel as u8,
        Scene::Breaks => 0,
        Scene::LastColumn if x + 1 == width => 1 + channel as u8,
        Scene::LastColumn => 0,
        Scene::Flat(value) => value,
        Scene::Unlit if channel < 5 => 128,
        Scene::Unlit => noise,
        Scene::LuminanceIsCr if channel < 5 => 128,
        Scene::LuminanceIsCr if channel == 6 => hash(recipe.seed, texel, 5) as u8,
        Scene::LuminanceIsCr => noise,
        Scene::Framed(value) if x.min(y) < 2 || x + 2 >= width || y + 2 >= height => value,
        Scene::Framed(_) => noise,
        Scene::Bits(bits) => noise & (0xff >> (8 - bits)),
        Scene::Soft => 96 + noise % 64,
        // x + y is constant along a line, because y runs downward here.
        Scene::Diagonals => hash(recipe.seed, (x + y) % 4, channel) as u8,
        Scene::Columns => alternating_byte(recipe.seed, x, channel),
        Scene::Rows => alternating_byte(recipe.seed, y, channel),
        Scene::Cells => ((x + channel) / 3 + (y + channel) / 5) as u8 % 2 * 255,
        // Blocks begin at the first stored row, which is the last row of the image.
        Scene::Blocks => hash(recipe.seed, x / 8 + (height - 1 - y) / 8 * width, channel) as u8,
        Scene::Edges if x % 8 < 4 => [200, 40][channel % 2],
        Scene::Edges if channel % 4 < 2 => 120 + drift(recipe.seed, y),
        Scene::Edges => 120 - drift(recipe.seed, y),
        Scene::Dots if x % 5 != 3 || y % 2 == 0 => 100,
        Scene::Dots => 99 + u8::from(noise.is_multiple_of(4) == channel.is_multiple_of(2)) * 2,
    }
}

/// Returns the drift of a value that changes in two out of every three rows.
fn drift(seed: u32, y: usize) -> u8 {
    (2 * (y + seed as usize) / 3 % 60) as u8
}

/// Returns one of two bytes with different parity, depending on the parity of `position`.
fn alternating_byte(seed: u32, position: usize, channel: usize) -> u8 {
    let even = hash(seed, 0, channel) as u8;
    if position.is_multiple_of(2) {
        even
    } else {
        hash(seed, 1, channel) as u8 & 0xfe | !even & 1
    }
}

pub fn entry_of_texel(recipe: &Recipe, texel: usize) -> u32 {
    let entries = recipe.entries;
    let random = hash(recipe.seed ^ 0x5bd1, texel, 99);
    match &recipe.indices {
        Indices::Any => match texel {
            1 => entries - 1,
            2 => 0,
            _ => random % entries,
        },
        Indices::Below(limit) => random % entries.min(*limit),
        Indices::BytesDiffer => {
            // Continue to the next index whose bytes differ. The bytes differ in at least one of two adjacent indices.
            let start = random % entries;
            let mut following = (0..entries).map(|step| (start + step) % entries);
            following
                .find(|index| index % 256 != index / 256)
                .unwrap_or(0)
        }
        Indices::List(list) => list[texel % list.len()],
    }
}

/// Returns a pseudo-random number: the seed, texel and channel, mixed by the finalizer of `MurmurHash3`.
pub fn hash(seed: u32, texel: usize, channel: usize) -> u32 {
    let mut h = seed.wrapping_mul(0x9e37_79b1)
        ^ (texel as u32).wrapping_mul(0x85eb_ca77)
        ^ (channel as u32).wrapping_mul(0xc2b2_ae3d);
    h = (h ^ h >> 16).wrapping_mul(0x85eb_ca6b);
    h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
    h ^ h >> 16
}
