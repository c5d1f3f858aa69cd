//! Sampling controls: samples a map at given coordinates and at a given depth.
//!
//! There are six methods. They use the closest texel or a weighted average of the closest 2ⁿ texels, in the base level, in
//! the closest level, or in the two closest levels with interpolation by depth (R-SMP-04 … R-SMP-11).
//!
//! Format notes
//! - n is the number of dimensions of the map. "2n" in the chapter stands for 2ⁿ.
//! - Texel k of N covers k/N to (k + 1)/N (ruling `texel-grid`). On the border between two texels, the one with the higher
//!   index counts as the closest (ruling `texel-tie`).
//! - Samples are exact. `precision` states how far a correct sample may be from an exact one (ruling `filter-precision`).
//! - A depth at or beyond the first or last level selects that level, without interpolation (R-SMP-09, R-SMP-11).

use super::boundary::{fold_index, is_clamped};
use super::entry::{Boundary, Entry, SampleMethod, Vector};
use super::map::{CellPair, Level, Texel, TextureMap};
use super::precision::{Filtered, ToleratedSample, tolerance_of_average};
use super::{primitive::MapValue, rules::Rules};

/// Samples `map` at `t` and `depth` with the method that the entry specifies for magnified or minified maps.
#[must_use]
pub fn fetch(
    entry: &Entry,
    map: &TextureMap,
    t: Vector,
    depth: f64,
    magnify: bool,
    rules: &Rules,
) -> MapValue {
    fetch_with_tolerance(entry, map, t, depth, magnify, rules).value
}

/// Samples `map` like [`fetch`], and returns how far a correct sample may be from the exact one (ruling `filter-precision`).
#[must_use]
pub fn fetch_with_tolerance(
    entry: &Entry,
    map: &TextureMap,
    t: Vector,
    depth: f64,
    magnify: bool,
    rules: &Rules,
) -> ToleratedSample {
    let method = (rules.method)(entry, magnify);
    if is_clamped(entry, t, map.dimensions(), rules) {
        return ToleratedSample::exact((rules.outside)(entry, map, t, method, rules));
    }
    let top = map.levels().len() - 1;
    let level =
        |number: usize, average: fn(&Entry, &TextureMap, &Level, Vector, &Rules) -> Filtered| {
            average(entry, map, &map.levels()[number.min(top)], t, rules)
        };
    let between = |average| {
        let (lower, upper, weight) = (rules.levels)(depth, top);
        Filtered::interpolate(&level(lower, average), &level(upper, average), weight)
    };
    let closest = (rules.closest_level)(depth, top);
    let filtered = match method {
        SampleMethod::SingleBase => level(0, closest_texel),
        SampleMethod::WeightedBase => level(0, weighted_average),
        SampleMethod::SingleInMipmap => level(closest, closest_texel),
        SampleMethod::WeightedInMipmap => level(closest, weighted_average),
        SampleMethod::SingleBetweenMipmaps => between(closest_texel),
        SampleMethod::WeightedBetweenMipmaps => between(weighted_average),
    };
    ToleratedSample {
        value: MapValue::Texel(filtered.texel),
        tolerance: filtered.tolerance,
    }
}

/// Returns the sampling method for magnification or minification (R-SMP-02, R-SMP-03).
#[must_use]
pub fn method(entry: &Entry, magnify: bool) -> SampleMethod {
    match magnify {
        true => entry.mag_sample,
        false => entry.min_sample,
    }
}

fn closest_texel(
    entry: &Entry,
    map: &TextureMap,
    level: &Level,
    t: Vector,
    rules: &Rules,
) -> Filtered {
    let mut at = [0; 3];
    for d in 0..map.dimensions() {
        at[d] = (rules.closest)((rules.condition)(entry, d), t[d], level.size[d], rules);
    }
    Filtered::exact(level.texels[(rules.offset)(level.size, at)])
}

/// Returns the weighted average of the closest 2ⁿ texels of a level.
fn weighted_average(
    entry: &Entry,
    map: &TextureMap,
    level: &Level,
    t: Vector,
    rules: &Rules,
) -> Filtered {
    let mut neighbors = [[(0, 1.0), (0, 0.0)]; 3];
    for d in 0..map.dimensions() {
        neighbors[d] = (rules.neighbors)((rules.condition)(entry, d), t[d], level.size[d], rules);
    }
    let corners: Vec<Texel> = (0..1_usize << map.dimensions())
        .map(|corner| {
            let at = [0, 1, 2].map(|d| neighbors[d][corner >> d & 1].0);
            level.texels[(rules.offset)(level.size, at)]
        })
        .collect();
    let weights = (rules.corner_weights)(&neighbors.map(|pair| pair.map(|(_, weight)| weight)));
    let upper = neighbors.map(|[_, (_, weight)]| weight);
    Filtered {
        texel: Texel::sum(map.kind(), corners.iter().copied().zip(weights)),
        tolerance: tolerance_of_average(&corners, &upper[..map.dimensions()]),
    }
}

/// Returns the weight of each corner: the product of its weights in the three directions (ruling `weights`). Bit d of the index
/// of a corner is set if the corner is the upper neighbor in direction d.
#[must_use]
pub fn products_of_weights(weights: &[[f64; 2]; 3]) -> [f64; 8] {
    std::array::from_fn(|corner| (0..3).map(|d| weights[d][corner >> d & 1]).product())
}

/// Returns ⌊t·N⌋, the index of the cell that contains `t` (rulings `texel-grid`, `texel-tie`).
#[must_use]
pub fn cell_index(boundary: Boundary, t: f64, size: usize, rules: &Rules) -> usize {
    fold_index(boundary, (t * size as f64).floor() as i64, size, rules)
}

/// Returns the two cells whose centers are closest to `t`, with linear weights (rulings `texel-grid`, `weights`).
#[must_use]
pub fn cells_around(boundary: Boundary, t: f64, size: usize, rules: &Rules) -> CellPair {
    let u = t * size as f64 - 0.5;
    let (k, weight) = (u.floor() as i64, u - u.floor());
    [
        (fold_index(boundary, k, size, rules), 1.0 - weight),
        (
            fold_index(boundary, k.saturating_add(1), size, rules),
            weight,
        ),
    ]
}

/// Returns the index of the closest texel if texel k of N is the point k/(N − 1) (alternative to ruling `texel-grid`).
#[must_use]
pub fn point_index(boundary: Boundary, t: f64, size: usize, _: &Rules) -> usize {
    ((fold_coordinate(boundary, t) * (size - 1) as f64).round() as usize).min(size - 1)
}

/// Returns the two points closest to `t` with linear weights (alternative to ruling `texel-grid`).
#[must_use]
pub fn points_around(boundary: Boundary, t: f64, size: usize, _: &Rules) -> CellPair {
    let u = fold_coordinate(boundary, t) * (size - 1) as f64;
    let k = u.floor();
    let at = |k: f64| (k as usize).min(size - 1);
    [(at(k), 1.0 - (u - k)), (at(k + 1.0), u - k)]
}

/// Maps a coordinate to 0 … 1. If texels are points, boundary conditions apply to coordinates, not to texel indices.
fn fold_coordinate(boundary: Boundary, t: f64) -> f64 {
    match boundary {
        // 1 is the last point of the map, not the first point of the repeated map.
        Boundary::Wrap if t == 1.0 => 1.0,
        Boundary::Wrap => t - t.floor(),
        Boundary::Mirror => 1.0 - (t.rem_euclid(2.0) - 1.0).abs(),
        Boundary::ClampBorder | Boundary::ClampExplicit => t.clamp(0.0, 1.0),
    }
}

/// Returns the level closest to the depth, or the lower level if two are equally close (R-SMP-06, ruling `level-tie`).
#[must_use]
pub fn closest_level(depth: f64, top: usize) -> usize {
    ((depth - 0.5).ceil().max(0.0) as usize).min(top)
}

/// Returns the two levels closest to the depth, and the weight of the upper level. Depths out of range are clamped (R-SMP-08 …
/// R-SMP-11).
#[must_use]
pub fn levels_around(depth: f64, top: usize) -> (usize, usize, f64) {
    let depth = depth.clamp(0.0, top as f64);
    let lower = depth.floor();
    (lower as usize, (lower as usize + 1).min(top), depth - lower)
}
