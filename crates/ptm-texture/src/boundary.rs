//! Boundary conditions and clamp methods for coordinates outside the map.
//!
//! Coordinates outside 0 … 1 are outside the map; both ends are inside (R-BND-01). Each direction has its own condition
//! (R-BND-02): use the clamp method (R-BND-03), use the closest texel (R-BND-04), repeat the map (R-BND-05), or mirror the
//! map (R-BND-06). There is one clamp method for all directions (R-CLM-02): no texture (R-CLM-03), or a color (R-CLM-04).
//!
//! Format notes
//! - If a direction with explicit clamp has a coordinate outside the map, the other boundary conditions have no effect.
//! - Directions beyond the dimensions of the map have no boundary condition.
//! - A texel index may be out of range; the boundary condition maps it to a texel of the map.
//! - Inside the map, weighted averages under an explicit clamp may need neighbors outside the map. In that case, the edge is
//!   replicated (ruling `explicit-neighbour`).

use super::entry::{Boundary, ClampMethod, Entry, SampleMethod, Vector};
use super::map::{Texel, TextureMap};
use super::{primitive::MapValue, rules::Rules};

/// Returns the texel index along one direction for coordinate `t` in a level of `size` texels.
#[must_use]
pub fn texel_index(boundary: Boundary, t: f64, size: usize, rules: &Rules) -> usize {
    (rules.closest)(boundary, t, size, rules)
}

/// Returns true if the explicit clamp applies: a direction with this condition has a coordinate outside the map.
pub(super) fn is_clamped(entry: &Entry, t: Vector, dimensions: usize, rules: &Rules) -> bool {
    (rules.is_clamped)(entry, t, dimensions, rules)
}

/// Returns the boundary condition of direction `d` (R-BND-02).
#[must_use]
pub fn condition(entry: &Entry, d: usize) -> Boundary {
    entry.boundary[d]
}

/// Returns true if `t` is outside the map in a direction with an explicit clamp (R-BND-03, R-CLM-02).
#[must_use]
pub fn is_clamped_in_any_direction(
    entry: &Entry,
    t: Vector,
    dimensions: usize,
    rules: &Rules,
) -> bool {
    (0..dimensions)
        .any(|d| (rules.condition)(entry, d) == Boundary::ClampExplicit && (rules.is_outside)(t[d]))
}

/// Returns true if `t` is outside 0 … 1. Both ends are inside (R-BND-01).
#[must_use]
pub fn is_outside(t: f64) -> bool {
    !(0.0..=1.0).contains(&t)
}

/// Returns the sample at a coordinate outside the map under an explicit clamp: the result of the clamp method, whatever the
/// sampling method is and however close the map is (R-BND-03).
#[must_use]
pub fn sample_outside(
    entry: &Entry,
    _: &TextureMap,
    _: Vector,
    _: SampleMethod,
    rules: &Rules,
) -> MapValue {
    (rules.clamp)(entry)
}

/// Returns the result of the clamp method (R-CLM-03, R-CLM-04).
#[must_use]
pub fn apply_clamp_method(entry: &Entry) -> MapValue {
    match entry.clamp_method {
        ClampMethod::Discontinue => MapValue::Discontinued,
        // clamp-color: the color is composed like a texel without alpha.
        ClampMethod::Color => MapValue::Clamped(Texel::rgb(entry.clamp_color)),
    }
}

/// Maps a texel index that may be out of range to a texel of the map.
#[must_use]
pub fn fold_index(boundary: Boundary, k: i64, size: usize, rules: &Rules) -> usize {
    match boundary {
        Boundary::Wrap => (rules.wrap)(k, size),
        Boundary::Mirror => (rules.mirror)(k, size),
        Boundary::ClampBorder => (rules.border)(k, size),
        Boundary::ClampExplicit => clamp_to_edge(k, size),
    }
}

/// Repeats the map: an index beyond an edge continues at the opposite edge (R-BND-05).
#[must_use]
pub fn wrap(k: i64, size: usize) -> usize {
    k.rem_euclid(size as i64) as usize
}

/// Mirrors the map at its edges, where the edge texels are repeated (R-BND-06).
#[must_use]
pub fn mirror(k: i64, size: usize) -> usize {
    let m = k.rem_euclid(2 * size as i64) as usize;
    if m < size { m } else { 2 * size - 1 - m }
}

/// Clamps an index to the closest texel of the map (R-BND-04).
#[must_use]
pub fn clamp_to_edge(k: i64, size: usize) -> usize {
    k.clamp(0, size as i64 - 1) as usize
}
