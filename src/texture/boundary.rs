//! Boundary conditions and clamp methods: what is beyond the map.
//!
//! Outside is what is not within 0 … 1, both ends included (R-BND-01). Each direction has its own condition (R-BND-02):
//! the clamp method (R-BND-03), the closest texel (R-BND-04), the map again (R-BND-05), or the map reversed (R-BND-06).
//! The clamp method is one for all directions (R-CLM-02): no texture (R-CLM-03), or a color (R-CLM-04).
//!
//! Format notes
//! - One direction with an explicit clamp outside is enough; what the others say does not matter then.
//! - A direction that the map does not have has no boundary.
//! - An index is a whole number of texels, which may lie beyond either end; conditions fold it back.
//! - Within the map an explicit clamp still meets neighbors outside when texels are weighted: the edge again (ruling
//!   `explicit-neighbour`).

use super::entry::{Boundary, ClampMethod, Entry, Vector};
use super::map::Texel;
use super::primitive::Fetched;
use super::rules::Rules;

/// The texel along one direction that the coordinate `t` names in a level of `size` texels.
#[must_use]
pub fn texel_index(boundary: Boundary, t: f64, size: usize, rules: &Rules) -> usize {
    (rules.closest)(boundary, t, size, rules)
}

/// Whether the explicit clamp decides: a direction of the map has that condition and its coordinate is outside.
pub(super) fn is_clamped(entry: &Entry, t: Vector, dimensions: usize, rules: &Rules) -> bool {
    (rules.is_clamped)(entry, t, dimensions, rules)
}

/// The condition of the direction `d` (R-BND-02).
pub(crate) fn condition(entry: &Entry, d: usize) -> Boundary {
    entry.boundary[d]
}

/// Any direction of the map (R-BND-03, R-CLM-02).
pub(crate) fn any_direction(entry: &Entry, t: Vector, dimensions: usize, rules: &Rules) -> bool {
    (0..dimensions)
        .any(|d| (rules.condition)(entry, d) == Boundary::ClampExplicit && (rules.is_outside)(t[d]))
}

/// Not within 0 … 1; both ends are inside (R-BND-01).
pub(crate) fn is_outside(t: f64) -> bool {
    !(0.0..=1.0).contains(&t)
}

/// What the clamp method gives (R-CLM-03, R-CLM-04).
pub(crate) fn by_clamp_method(entry: &Entry) -> Fetched {
    match entry.clamp_method {
        ClampMethod::Discontinue => Fetched::Discontinued,
        // As if it were a texel without alpha, or beyond all composition: ruling clamp-color.
        ClampMethod::Color => Fetched::Clamped(Texel::rgb(entry.clamp_color)),
    }
}

/// A texel number folded back into the map.
pub(crate) fn fold(boundary: Boundary, k: i64, size: usize, rules: &Rules) -> usize {
    match boundary {
        Boundary::Wrap => (rules.wrap)(k, size),
        Boundary::Mirror => (rules.mirror)(k, size),
        Boundary::ClampBorder => (rules.border)(k, size),
        Boundary::ClampExplicit => (rules.explicit_neighbor)(k, size),
    }
}

/// From the opposite edge on (R-BND-05).
pub(crate) fn wrap(k: i64, size: usize) -> usize {
    k.rem_euclid(size as i64) as usize
}

/// There and back again, the edge twice (R-BND-06).
pub(crate) fn mirror(k: i64, size: usize) -> usize {
    let m = k.rem_euclid(2 * size as i64) as usize;
    if m < size { m } else { 2 * size - 1 - m }
}

/// The closest one (R-BND-04).
pub(crate) fn border(k: i64, size: usize) -> usize {
    k.clamp(0, size as i64 - 1) as usize
}
