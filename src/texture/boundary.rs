//! Boundary conditions and clamp methods for coordinates beyond the map.
//!
//! Coordinates outside 0 … 1 are beyond the map; both ends are inside (R-BND-01). Each direction has its own condition
//! (R-BND-02): the clamp method (R-BND-03), the closest texel (R-BND-04), the map repeated (R-BND-05), or the map reversed
//! (R-BND-06). There is one clamp method for all directions (R-CLM-02): no texture (R-CLM-03), or a color (R-CLM-04).
//!
//! Format notes
//! - One direction with an explicit clamp outside is enough; the conditions of the others do not matter then.
//! - A direction that the map does not have has no boundary condition.
//! - An index is a texel number that may be beyond either end; conditions map it to a texel of the map.
//! - Within the map, weighted averages under an explicit clamp may need neighbors outside: the edge is replicated (ruling
//!   `explicit-neighbour`).

use super::entry::{Boundary, ClampMethod, Entry, Vector};
use super::map::Texel;
use super::primitive::Fetched;
use super::rules::Rules;

/// Returns the texel along one direction for the coordinate `t` in a level of `size` texels.
#[must_use]
pub fn texel_index(boundary: Boundary, t: f64, size: usize, rules: &Rules) -> usize {
    (rules.closest)(boundary, t, size, rules)
}

/// Returns true if the explicit clamp applies: a direction of the map has that condition and its coordinate is outside.
pub(super) fn is_clamped(entry: &Entry, t: Vector, dimensions: usize, rules: &Rules) -> bool {
    (rules.is_clamped)(entry, t, dimensions, rules)
}

/// Returns the condition of direction `d` (R-BND-02).
pub(crate) fn condition(entry: &Entry, d: usize) -> Boundary {
    entry.boundary[d]
}

/// Returns true if any direction of the map is clamped (R-BND-03, R-CLM-02).
pub(crate) fn any_direction(entry: &Entry, t: Vector, dimensions: usize, rules: &Rules) -> bool {
    (0..dimensions)
        .any(|d| (rules.condition)(entry, d) == Boundary::ClampExplicit && (rules.is_outside)(t[d]))
}

/// Returns true outside 0 … 1; both ends are inside (R-BND-01).
pub(crate) fn is_outside(t: f64) -> bool {
    !(0.0..=1.0).contains(&t)
}

/// Returns the result of the clamp method (R-CLM-03, R-CLM-04).
pub(crate) fn by_clamp_method(entry: &Entry) -> Fetched {
    match entry.clamp_method {
        ClampMethod::Discontinue => Fetched::Discontinued,
        // Like a texel without alpha, or independent of composition: ruling clamp-color.
        ClampMethod::Color => Fetched::Clamped(Texel::rgb(entry.clamp_color)),
    }
}

/// Maps a texel number to a texel of the map.
pub(crate) fn fold(boundary: Boundary, k: i64, size: usize, rules: &Rules) -> usize {
    match boundary {
        Boundary::Wrap => (rules.wrap)(k, size),
        Boundary::Mirror => (rules.mirror)(k, size),
        Boundary::ClampBorder => (rules.border)(k, size),
        Boundary::ClampExplicit => border(k, size),
    }
}

/// Continues from the opposite edge (R-BND-05).
pub(crate) fn wrap(k: i64, size: usize) -> usize {
    k.rem_euclid(size as i64) as usize
}

/// Mirrors the map, repeating texels at the edge (R-BND-06).
pub(crate) fn mirror(k: i64, size: usize) -> usize {
    let m = k.rem_euclid(2 * size as i64) as usize;
    if m < size { m } else { 2 * size - 1 - m }
}

/// Returns the closest texel (R-BND-04).
pub(crate) fn border(k: i64, size: usize) -> usize {
    k.clamp(0, size as i64 - 1) as usize
}
