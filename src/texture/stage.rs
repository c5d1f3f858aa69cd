//! Rendering control: all maps of a primitive and its light, in one of two forms.
//!
//! Each map applies to the result of the previous one (R-CMP-05, R-CMP-06). `PreLight` maps precede the reflectance
//! calculation, `PostLight` maps follow it (R-RCT-04, R-RCT-05). If light is computed for a facet or its vertices and texture
//! for each pixel, texture comes too late: the light on the surface and the light on a white one are passed on, and the maps
//! apply to these (R-CMP-20); all other cases are direct (R-CMP-21).
//!
//! Format notes
//! - The reflectance calculation is `CW·C + CS`: ambient and diffuse light times the color, plus the highlight. A
//!   stage needs no other properties of light, and these are inputs.
//! - Both forms give the same color because of the place of CW (ruling `split-form`).
//! - Maps of both kinds in one list make two stages, each in the order of the list (ruling `two-stages`).

use super::compose::{compose, times};
use super::entry::{Color, Entry, RenderingControl};
use super::primitive::{Fetched, Frequency, Interpolation, Lit, Shade};
use super::rules::Rules;

/// Returns the primitive after all `maps` and its light.
#[must_use]
pub fn stage(
    maps: &[(Entry, Fetched)],
    lit: &Lit,
    interpolation: Interpolation,
    frequency: Frequency,
    rules: &Rules,
) -> Shade {
    (rules.stage)(maps, lit, interpolation, frequency, rules)
}

/// Applies `PreLight` maps, light, `PostLight` maps.
pub(crate) fn before_and_after(
    maps: &[(Entry, Fetched)],
    lit: &Lit,
    interpolation: Interpolation,
    frequency: Frequency,
    rules: &Rules,
) -> Shade {
    let all = |control: RenderingControl, input: Shade, white: Color| {
        let with = maps.iter();
        let with = with.filter(|(entry, _)| entry.rendering_control == control);
        with.fold(input, |input, (entry, fetched)| {
            compose(entry, fetched, input, white, rules)
        })
    };
    let lit = if is_split(interpolation, frequency) {
        let diffuse = Shade {
            color: times(lit.white, lit.surface.color),
            ..lit.surface
        };
        let textured = all(RenderingControl::PreLight, diffuse, lit.white);
        // CS is only added at the end (R-CMP-12, R-CMP-13).
        (rules.add_specular)(textured, lit.specular)
    } else {
        let textured = all(RenderingControl::PreLight, lit.surface, [1.0; 3]);
        (rules.light)(textured, lit)
    };
    all(RenderingControl::PostLight, lit, [1.0; 3])
}

/// Returns true if light is computed on facets or vertices, and texture on pixels (R-CMP-20, R-CMP-23).
pub(crate) fn is_split(interpolation: Interpolation, frequency: Frequency) -> bool {
    matches!(interpolation, Interpolation::None | Interpolation::Color)
        && frequency == Frequency::Pixel
}

/// Adds the highlight (R-CMP-13).
pub(crate) fn add_specular(shade: Shade, specular: Color) -> Shade {
    Shade {
        color: [0, 1, 2].map(|c| shade.color[c] + specular[c]),
        ..shade
    }
}

/// Performs the reflectance calculation: CW·C + CS.
pub(crate) fn light(shade: Shade, lit: &Lit) -> Shade {
    let color = times(lit.white, shade.color);
    add_specular(Shade { color, ..shade }, lit.specular)
}
