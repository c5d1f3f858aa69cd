//! Where the wrong samples of a picture are: in which channels, and at which texels.

use super::pair::Pair;
use super::witness::Witness;
use crate::generate::planes::Compressed;

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
        count > 3 && (count == 18 || k < 6)
    }),
    (", only in red", |count, k| of_color(count, k) == Some(0)),
    (", only in green", |count, k| of_color(count, k) == Some(1)),
    (", only in blue", |count, k| of_color(count, k) == Some(2)),
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

/// What is true of the wrong channels; the most telling first.
pub(super) fn channels_concerned(pair: &Pair, witness: &Witness) -> Vec<&'static str> {
    let wrong = root_channels(pair, witness);
    let all = |holds: &dyn Fn(usize) -> bool| (0..pair.channels).all(|k| !wrong[k] || holds(k));
    let coded = coded(pair, witness);
    let planes = OF_PLANES
        .iter()
        .filter(|(_, holds)| coded.is_some_and(|coded| all(&|k| holds(coded, k))))
        .map(|(says, _)| *says);
    let channels = OF_CHANNELS
        .iter()
        .filter(|(_, holds)| all(&|k| holds(pair.channels, k)))
        .map(|(says, _)| *says);
    planes.chain(channels).collect()
}

/// What is true of the wrong texels, the most telling first; and what of that is not true of every texel.
pub(super) fn texels_concerned(
    pair: &Pair,
    witness: &Witness,
) -> (Vec<&'static str>, Vec<&'static str>) {
    let size = (pair.width, pair.height);
    let roots = root_channels(pair, witness);
    let mut wrong = pair.wrong();
    wrong.retain(|i| roots[i % pair.channels]);
    let place = |i: &usize| (i / pair.channels % size.0, i / pair.channels / size.0);
    let mut says = Vec::new();
    if let Some(coded) = coded(pair, witness) {
        // Positions count in the stored raster, from the bottom row.
        let is_corrected = |i: &usize| {
            let (x, y) = place(i);
            let stored = (size.1 - 1 - y) * size.0 + x;
            let mut records = coded.planes[i % pair.channels].records.iter();
            records.any(|&(position, _)| position as usize == stored)
        };
        let corrected = wrong.iter().filter(|i| is_corrected(i)).count();
        if corrected == wrong.len() {
            says.push(", only at texels that side information corrects");
        } else if corrected * 2 >= wrong.len() {
            says.push(", only at texels that side information corrects and at others in their stead: records land elsewhere");
        }
    }
    let holding = OF_TEXELS
        .iter()
        .filter(|(_, holds)| wrong.iter().all(|i| holds(place(i), size)));
    let mut telling = says.clone();
    let texels = || (0..size.0 * size.1).map(|i| (i % size.0, i / size.0));
    for (claim, holds) in holding {
        says.push(claim);
        if !texels().all(|texel| holds(texel, size)) {
            telling.push(claim);
        }
    }
    (says, telling)
}
