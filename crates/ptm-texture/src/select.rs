//! Selects the table entries for a facet.
//!
//! The table is used for surfaces with interior style Texture (R-SEL-01). If facets are distinguished, back-facing facets
//! have a separate style and list (R-SEL-02). Each index in the active list selects an entry (R-SEL-03). Indices after the
//! first `MaxTextureMaps` are ignored (R-SEL-04).
//!
//! Format notes
//! - An empty list does not mean "no texture": the default map is applied once, with fallback values (R-SEL-06).
//! - The list is ordered, and an index that occurs twice is applied twice.

use super::primitive::{InteriorStyle, Selection, Surface};
use super::rules::Rules;

/// Selects the textures for a facet.
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

/// Returns true if the facet uses the separate style and list for back-facing facets. This requires that the facet is back-facing
/// and that facets are distinguished (R-SEL-02).
pub fn uses_back(surface: &Surface) -> bool {
    surface.facet_distinguish && surface.back_facing
}

/// Returns true if the style is Texture (R-SEL-01).
pub fn is_textured(style: InteriorStyle) -> bool {
    style == InteriorStyle::Texture
}

/// Selects the default map (R-SEL-06).
pub fn default_map() -> Selection {
    Selection::Default
}

/// Returns the first `max_maps` indices (R-SEL-04).
pub fn within_limit(active: &[i64], max_maps: usize) -> Vec<i64> {
    active.iter().copied().take(max_maps).collect()
}
