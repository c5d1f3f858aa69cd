//! Where the wrong samples of a picture are: in which channels, and at which texels.

use crate::diagnose::pair::Pair;
use crate::diagnose::witness::Witness;
use crate::generate::planes::Compressed;

/// Where all wrong samples of a picture are.
#[derive(Clone, Copy)]
pub(super) struct Claim {
    /// Completes "shows wrong values": ", only in red".
    pub says: &'static str,
    /// The logarithm of the chance that so many channels or texels, drawn blindly, are all there.
    pub chance: f64,
}

impl Claim {
    /// `wrong` ones are all among the `there` of `all` that it is true of.
    fn of(says: &'static str, wrong: usize, there: usize, all: usize) -> Claim {
        let chance = wrong as f64 * (there as f64 / all as f64).ln();
        Claim { says, chance }
    }
}

/// Words, and of which planes they are true.
type OfPlanes = (&'static str, fn(&Compressed, usize) -> bool);

const OF_PLANES: &[OfPlanes] = &[
    (
        ", only in planes predicted with motion vectors of half texels along columns and rows",
        |coded, plane| vector(coded, plane).is_some_and(|(x, y)| x & y & 1 != 0),
    ),
    (
        ", only in planes predicted with motion vectors of half texels along rows",
        |coded, plane| vector(coded, plane).is_some_and(|(x, _)| x & 1 != 0),
    ),
    (
        ", only in planes predicted with motion vectors of half texels along columns",
        |coded, plane| vector(coded, plane).is_some_and(|(_, y)| y & 1 != 0),
    ),
    (
        ", only in planes predicted with motion vectors of half texels",
        |coded, plane| vector(coded, plane).is_some_and(|(x, y)| (x | y) & 1 != 0),
    ),
    (
        ", only in planes predicted with a motion vector below zero along rows",
        |coded, plane| vector(coded, plane).is_some_and(|(x, _)| x < 0),
    ),
    (
        ", only in planes predicted with a motion vector below zero along columns",
        |coded, plane| vector(coded, plane).is_some_and(|(_, y)| y < 0),
    ),
    (
        ", only in planes predicted with a motion vector along rows",
        |coded, plane| vector(coded, plane).is_some_and(|(x, _)| x != 0),
    ),
    (
        ", only in planes predicted with a motion vector along columns",
        |coded, plane| vector(coded, plane).is_some_and(|(_, y)| y != 0),
    ),
    (
        ", only in planes predicted with inversion and motion",
        |coded, plane| transform(coded, plane) & 3 == 3,
    ),
    (", only in planes predicted with motion", |coded, plane| {
        transform(coded, plane) & 2 != 0
    }),
    (
        ", only in planes predicted from an inverted reference",
        |coded, plane| transform(coded, plane) & 1 != 0,
    ),
    (", only in predicted planes", |coded, plane| {
        coded.plan.reference(plane).is_some()
    }),
    (", only in planes that are not predicted", |coded, plane| {
        coded.plan.predicts() && coded.plan.reference(plane).is_none()
    }),
];

/// Words, and of which channels they are true, of so many.
type OfChannels = (&'static str, fn(usize, usize) -> bool);

const OF_CHANNELS: &[OfChannels] = &[
    (", only in a0", |count, k| is_a(count, k, 0)),
    (", only in a1", |count, k| is_a(count, k, 1)),
    (", only in a2", |count, k| is_a(count, k, 2)),
    (", only in a3", |count, k| is_a(count, k, 3)),
    (", only in a4", |count, k| is_a(count, k, 4)),
    (", only in a5", |count, k| is_a(count, k, 5)),
    (", only in the coefficients of red", |count, k| {
        count == 18 && k / 6 == 0
    }),
    (", only in the coefficients of green", |count, k| {
        count == 18 && k / 6 == 1
    }),
    (", only in the coefficients of blue", |count, k| {
        count == 18 && k / 6 == 2
    }),
    (", only in coefficients", |count, k| {
        // Where there is nothing else, this says nothing.
        matches!(count, 8 | 9) && k < 6
    }),
    (", only in red", |count, k| of_color(count, k) == Some(0)),
    (", only in green", |count, k| of_color(count, k) == Some(1)),
    (", only in blue", |count, k| of_color(count, k) == Some(2)),
    (", only in red and green", |count, k| {
        matches!(of_color(count, k), Some(0 | 1))
    }),
    (", only in red and blue", |count, k| {
        matches!(of_color(count, k), Some(0 | 2))
    }),
    (", only in green and blue", |count, k| {
        matches!(of_color(count, k), Some(1 | 2))
    }),
    (", only in Cr", |count, k| count == 8 && k == 6),
    (", only in Cb", |count, k| count == 8 && k == 7),
    (", only in colors", |count, k| {
        matches!(count, 8 | 9) && k >= 6
    }),
];

/// Words, and of which texels they are true: column and row from the top, width and height.
type OfTexels = (&'static str, fn((usize, usize), (usize, usize)) -> bool);

const OF_TEXELS: &[OfTexels] = &[
    (
        ", only at the last texel (bottom right)",
        |(x, y), (w, h)| (x, y) == (w - 1, h - 1),
    ),
    (
        ", only at the texel that is stored last (top right)",
        |(x, y), (w, _)| (x, y) == (w - 1, 0),
    ),
    (", only at the first texel (top left)", |place, _| {
        place == (0, 0)
    }),
    (
        ", only at the texel that is stored first (bottom left)",
        |(x, y), (_, h)| (x, y) == (0, h - 1),
    ),
    (
        ", only in the top row, which is stored last",
        |(_, y), _| y == 0,
    ),
    (
        ", only in the bottom row, which is stored first",
        |(_, y), (_, h)| y == h - 1,
    ),
    (", only in the left column", |(x, _), _| x == 0),
    (", only in the right column", |(x, _), (w, _)| x == w - 1),
    (", only at the border", |(x, y), (w, h)| {
        x == 0 || y == 0 || x == w - 1 || y == h - 1
    }),
    (", only in every second column", |(x, _), _| x % 2 == 1),
    (", only in every second row", |(_, y), _| y % 2 == 1),
    (", everywhere but at the border", |(x, y), (w, h)| {
        x > 0 && y > 0 && x < w - 1 && y < h - 1
    }),
    (", only beyond the first 8x8 block", |(x, y), _| {
        x >= 8 || y >= 8
    }),
    (
        ", only from the 65,537th stored texel on",
        |(x, y), (w, h)| (h - 1 - y) * w + x >= 65_536,
    ),
    (", only from the 257th stored texel on", |(x, y), (w, h)| {
        (h - 1 - y) * w + x >= 256
    }),
];

fn is_a(count: usize, k: usize, a: usize) -> bool {
    count > 3 && (count == 18 || k < 6) && k % 6 == a
}

fn of_color(count: usize, k: usize) -> Option<usize> {
    match count {
        3 => Some(k),
        9 => k.checked_sub(6),
        _ => None,
    }
}

/// What is done to the reference of a plane, if it has one.
fn transform(coded: &Compressed, plane: usize) -> u32 {
    let plan = &coded.plan;
    let transform = plan.transforms.get(plane).copied().unwrap_or_default();
    plan.reference(plane).map_or(0, |_| transform)
}

/// The motion vector of a plane that is predicted with motion, in half texels.
fn vector(coded: &Compressed, plane: usize) -> Option<(i32, i32)> {
    let plan = &coded.plan;
    let at = |list: &[i32]| list.get(plane).copied().unwrap_or_default();
    (transform(coded, plane) & 2 != 0).then(|| (at(&plan.motion_x), at(&plan.motion_y)))
}

/// The wrong channels in which it begins: planes that are predicted from a wrong plane are wrong anyhow.
pub(super) fn root_channels(pair: &Pair, witness: &Witness) -> Vec<bool> {
    let wrong = pair.wrong_channels();
    let Some(coded) = coded(pair, witness) else {
        return wrong;
    };
    let is_root = |k: usize| {
        let reference = coded.plan.reference(k);
        wrong[k] && reference.is_none_or(|other| wrong.get(other) != Some(&true))
    };
    let roots: Vec<bool> = (0..wrong.len()).map(is_root).collect();
    if roots.contains(&true) { roots } else { wrong }
}

/// How the planes of a compressed file are coded, where they are the channels of this picture.
fn coded<'w>(pair: &Pair, witness: &'w Witness) -> Option<&'w Compressed> {
    let compressed = witness.model()?.compressed.as_ref()?;
    (pair.view != "rgb" && compressed.planes.len() == pair.channels).then_some(compressed)
}

/// What is true of the wrong channels; the narrowest first.
pub(super) fn channels_concerned(pair: &Pair, witness: &Witness) -> Vec<Claim> {
    let wrong = root_channels(pair, witness);
    let count = wrong.iter().filter(|is| **is).count();
    let claim = |says: &'static str, holds: &dyn Fn(usize) -> bool| {
        let there: Vec<usize> = (0..pair.channels).filter(|&k| holds(k)).collect();
        let is_there = (0..pair.channels).all(|k| !wrong[k] || there.contains(&k));
        is_there.then(|| Claim::of(says, count, there.len(), pair.channels))
    };
    let coded = coded(pair, witness);
    let planes = OF_PLANES
        .iter()
        .filter_map(|(says, holds)| coded.and_then(|coded| claim(says, &|k| holds(coded, k))));
    let channels = OF_CHANNELS
        .iter()
        .filter_map(|(says, holds)| claim(says, &|k| holds(pair.channels, k)));
    planes.chain(channels).collect()
}

/// What is true of the wrong texels, the narrowest first.
pub(super) fn texels_concerned(pair: &Pair, witness: &Witness) -> Vec<Claim> {
    let size = (pair.width, pair.height);
    let roots = root_channels(pair, witness);
    let mut wrong = pair.wrong();
    wrong.retain(|i| roots[i % pair.channels]);
    let place = |texel: usize| (texel % size.0, texel / size.0);
    let mut claims = Vec::new();
    if let Some(coded) = coded(pair, witness) {
        // Positions count in the stored raster, from the bottom row.
        let is_corrected = |i: &usize| {
            let (x, y) = place(i / pair.channels);
            let stored = (size.1 - 1 - y) * size.0 + x;
            let mut records = coded.planes[i % pair.channels].records.iter();
            records.any(|&(position, _)| position as usize == stored)
        };
        let corrected = wrong.iter().filter(|i| is_corrected(i)).count();
        let says = match corrected {
            _ if corrected == wrong.len() => ", only at texels that side information corrects",
            _ if corrected * 2 >= wrong.len() => {
                ", only at texels that side information corrects and at others in their stead: records land elsewhere"
            }
            _ => "",
        };
        // A file corrects few of its samples.
        let chance = f64::NEG_INFINITY;
        claims.extend((!says.is_empty()).then_some(Claim { says, chance }));
    }
    let mut texels: Vec<usize> = wrong.iter().map(|i| i / pair.channels).collect();
    texels.dedup();
    claims.extend(OF_TEXELS.iter().filter_map(|(says, holds)| {
        let is_there = texels.iter().all(|&texel| holds(place(texel), size));
        let there = || (0..size.0 * size.1).filter(|&texel| holds(place(texel), size));
        is_there.then(|| Claim::of(says, texels.len(), there().count(), size.0 * size.1))
    }));
    claims
}

#[cfg(test)]
mod tests {
    use super::Claim;

    #[test]
    fn few_wrong_texels_are_nowhere_in_particular() {
        // One texel of a picture of 17 by 9 that happens to be in the bottom row, and a row that is wrong as a whole.
        let one = Claim::of(", only in the bottom row", 1, 17, 153);
        let row = Claim::of(", only in the bottom row", 17, 17, 153);
        assert!(
            one.chance > -3.0 && row.chance < -30.0,
            "{} {}",
            one.chance,
            row.chance
        );
        // What is true of every texel says nothing, however many are wrong.
        assert_eq!(Claim::of(", only in the left column", 9, 9, 9).chance, 0.0);
    }
}
