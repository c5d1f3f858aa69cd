//! Sampling controls: from coordinates and depth to one value.
//!
//! Six methods: the closest texel or a weighted average of the closest 2ⁿ, of the base level, of the closest level, or of
//! both closest levels, interpolated at the exact depth (R-SMP-04 … R-SMP-11).
//!
//! Format notes
//! - n is the number of the map's dimensions; "2n" in the chapter is a lost superscript.
//! - Texel k of N covers k/N to (k + 1)/N, with its center between them (ruling `texel-grid`). On the line between two, the
//!   upper one is closest (ruling `texel-tie`).
//! - A depth at or beyond an end of the levels is that end, with no interpolation (R-SMP-09, R-SMP-11).

use super::boundary::{fold, is_clamped};
use super::entry::{Boundary, Entry, SampleMethod, Vector};
use super::map::{Level, Texel, TextureMap};
use super::primitive::Fetched;
use super::rules::Rules;

/// Samples `map` at `t` and `depth`, by the entry's method for magnified or for minified maps.
#[must_use]
pub fn fetch(
    entry: &Entry,
    map: &TextureMap,
    t: Vector,
    depth: f64,
    magnify: bool,
    rules: &Rules,
) -> Fetched {
    if is_clamped(entry, t, map.dimensions(), rules) {
        return (rules.clamp)(entry);
    }
    let top = map.levels().len() - 1;
    let level =
        |number: usize, average: fn(&Entry, &TextureMap, &Level, Vector, &Rules) -> Texel| {
            average(entry, map, &map.levels()[number.min(top)], t, rules)
        };
    let between = |average| {
        let (lower, upper, share) = (rules.levels)(depth, top);
        let parts = [
            (level(lower, average), 1.0 - share),
            (level(upper, average), share),
        ];
        Texel::sum(map.kind(), parts.into_iter())
    };
    let closest = (rules.closest_level)(depth, top);
    Fetched::Texel(match (rules.method)(entry, magnify) {
        SampleMethod::SingleBase => level(0, single),
        SampleMethod::WeightedBase => level(0, weighted),
        SampleMethod::SingleInMipmap => level(closest, single),
        SampleMethod::WeightedInMipmap => level(closest, weighted),
        SampleMethod::SingleBetweenMipmaps => between(single),
        SampleMethod::WeightedBetweenMipmaps => between(weighted),
    })
}

/// Returns the minification method, or the magnification method (R-SMP-02, R-SMP-03).
pub(crate) fn method(entry: &Entry, magnify: bool) -> SampleMethod {
    match magnify {
        true => entry.mag_sample,
        false => entry.min_sample,
    }
}

/// Returns the closest texel.
fn single(entry: &Entry, map: &TextureMap, level: &Level, t: Vector, rules: &Rules) -> Texel {
    let mut at = [0; 3];
    for d in 0..map.dimensions() {
        at[d] = (rules.closest)((rules.condition)(entry, d), t[d], level.size[d], rules);
    }
    level.texels[(rules.place)(level.size, at)]
}

/// Returns the average of the closest 2ⁿ texels, weighted in each direction.
fn weighted(entry: &Entry, map: &TextureMap, level: &Level, t: Vector, rules: &Rules) -> Texel {
    let mut near = [[(0, 1.0), (0, 0.0)]; 3];
    for d in 0..map.dimensions() {
        near[d] = (rules.neighbors)((rules.condition)(entry, d), t[d], level.size[d], rules);
    }
    let corners = (0..1_usize << map.dimensions()).map(|corner| {
        let chosen = [0, 1, 2].map(|d| near[d][corner >> d & 1]);
        let at = chosen.map(|(at, _)| at);
        let weight = chosen.iter().map(|(_, weight)| weight).product();
        (level.texels[(rules.place)(level.size, at)], weight)
    });
    Texel::sum(map.kind(), corners)
}

/// Returns cell ⌊t·N⌋ (rulings `texel-grid`, `texel-tie`).
pub(crate) fn cell(boundary: Boundary, t: f64, size: usize, rules: &Rules) -> usize {
    fold(boundary, (t * size as f64).floor() as i64, size, rules)
}

/// Returns the cells whose centers are around t, weighted by proximity (rulings `texel-grid`, `weights`).
pub(crate) fn cells_around(
    boundary: Boundary,
    t: f64,
    size: usize,
    rules: &Rules,
) -> [(usize, f64); 2] {
    let u = t * size as f64 - 0.5;
    let (k, share) = (u.floor() as i64, u - u.floor());
    [
        (fold(boundary, k, size, rules), 1.0 - share),
        (fold(boundary, k.saturating_add(1), size, rules), share),
    ]
}

/// Treats texel k of N as the point k/(N − 1): the other reading of `texel-grid`.
#[cfg(feature = "harness")]
pub(crate) fn point(boundary: Boundary, t: f64, size: usize, _: &Rules) -> usize {
    ((inside(boundary, t) * (size - 1) as f64).round() as usize).min(size - 1)
}

/// Returns the points around t, weighted: the other reading of `texel-grid`.
#[cfg(feature = "harness")]
pub(crate) fn points_around(
    boundary: Boundary,
    t: f64,
    size: usize,
    _: &Rules,
) -> [(usize, f64); 2] {
    let u = inside(boundary, t) * (size - 1) as f64;
    let k = u.floor();
    let at = |k: f64| (k as usize).min(size - 1);
    [(at(k), 1.0 - (u - k)), (at(k + 1.0), u - k)]
}

/// Maps a coordinate to 0 … 1: if texels are points, boundary conditions apply to the map itself, not to texels.
#[cfg(feature = "harness")]
fn inside(boundary: Boundary, t: f64) -> f64 {
    match boundary {
        // 1 is the last point of the map, not the first of the next.
        Boundary::Wrap if t == 1.0 => 1.0,
        Boundary::Wrap => t - t.floor(),
        Boundary::Mirror => 1.0 - (t.rem_euclid(2.0) - 1.0).abs(),
        Boundary::ClampBorder | Boundary::ClampExplicit => t.clamp(0.0, 1.0),
    }
}

/// Returns the level closest to the depth; of two equally close ones the lower (R-SMP-06, ruling `level-tie`).
pub(crate) fn closest_level(depth: f64, top: usize) -> usize {
    ((depth - 0.5).ceil().max(0.0) as usize).min(top)
}

/// Returns the two levels around the depth and the weight of the upper one; beyond the ends only the end (R-SMP-08 … R-SMP-11).
pub(crate) fn levels_around(depth: f64, top: usize) -> (usize, usize, f64) {
    let depth = depth.clamp(0.0, top as f64);
    let lower = depth.floor();
    (lower as usize, (lower as usize + 1).min(top), depth - lower)
}
