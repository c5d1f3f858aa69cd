//! Selection of textures: the entries for a facet.
//!
//! The table is used for surfaces of interior style Texture (R-SEL-01); back-facing facets have a separate style and list if
//! facets are distinguished (R-SEL-02). Each index of the active list selects an entry (R-SEL-03); those beyond the first
//! `MaxTextureMaps` are ignored (R-SEL-04).
//!
//! Format notes
//! - An empty list does not mean "no texture": the default map is applied once, with fallback values (R-SEL-06).
//! - The list is ordered, and an index that occurs twice is applied twice.

use super::primitive::{InteriorStyle, Selection, Surface};
use super::rules::Rules;

/// Returns the textures for a facet.
#[must_use]
pub fn select(surface: &Surface, rules: &Rules) -> Selection {
    let (style, active) = match (rules.uses_back)(surface) {
        true => (surface.bf_interior_style, &surface.bf_active),
        false => (surface.interior_style, &surface.active),
    };
    if !(rules.is_textured)(style) {
        Selection::Untextured
    } else if active.is_empty() {
        (rules.empty_list)()
    } else {
        Selection::Entries((rules.within_limit)(active, surface.max_texture_maps))
    }
}

/// Returns true if style and list of the back apply: to back-facing facets, if facets are distinguished (R-SEL-02).
pub(crate) fn uses_back(surface: &Surface) -> bool {
    surface.facet_distinguish && surface.back_facing
}

/// Returns true for style Texture (R-SEL-01).
pub(crate) fn is_textured(style: InteriorStyle) -> bool {
    style == InteriorStyle::Texture
}

/// Returns the default map (R-SEL-06).
pub(crate) fn default_map() -> Selection {
    Selection::Default
}

/// Returns the first `most` indices (R-SEL-04).
pub(crate) fn within_limit(active: &[i64], most: usize) -> Vec<i64> {
    active.iter().copied().take(most).collect()
}
