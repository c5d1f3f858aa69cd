//! Rendering control and the two forms: all maps of a primitive, and its light.
//!
//! Each map works on what the one before left (R-CMP-05, R-CMP-06). `PreLight` maps come before the reflectance calculation,
//! `PostLight` maps after it (R-RCT-04, R-RCT-05). Where light is computed for a facet or its vertices and texture for each
//! pixel, texture comes too late: light hands over what it did to the surface and what it would do to a white one, and the
//! maps work on these (R-CMP-20); everything else is direct (R-CMP-21).
//!
//! Format notes
//! - The reflectance calculation is `CW·C + CS`: ambient and diffuse light on the color, and the highlight. That is all a
//!   stage needs to know of light, and it is an input.
//! - Both forms give the same color: CW is placed so that they do (ruling `split-form`).
//! - Maps of both kinds in one list are two stages, each in the list's order (ruling `two-stages`).

use super::compose::{compose, times};
use super::entry::{Color, Entry, RenderingControl};
use super::primitive::{Fetched, Frequency, Interpolation, Lit, Shade};
use super::rules::Rules;

/// The primitive after all `maps` and its light.
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

/// `PreLight` maps, light, `PostLight` maps.
pub(crate) fn before_and_after(
    maps: &[(Entry, Fetched)],
    lit: &Lit,
    interpolation: Interpolation,
    frequency: Frequency,
    rules: &Rules,
) -> Shade {
    let all = |control: RenderingControl, input: Shade, white: Color| {
        let with = maps
            .iter()
            .filter(|(entry, _)| entry.rendering_control == control);
        with.fold(input, |input, (entry, fetched)| {
            compose(entry, fetched, input, white, rules)
        })
    };
    let split = (rules.is_split)(interpolation, frequency);
    let lit = if split {
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

/// Light on facets or vertices, texture on pixels (R-CMP-20, R-CMP-23).
pub(crate) fn is_split(interpolation: Interpolation, frequency: Frequency) -> bool {
    matches!(interpolation, Interpolation::None | Interpolation::Color)
        && frequency == Frequency::Pixel
}

/// The highlight on top (R-CMP-13).
pub(crate) fn add_specular(shade: Shade, specular: Color) -> Shade {
    Shade {
        color: [0, 1, 2].map(|c| shade.color[c] + specular[c]),
        ..shade
    }
}

/// The reflectance calculation: CW·C + CS.
pub(crate) fn light(shade: Shade, lit: &Lit) -> Shade {
    let color = times(lit.white, shade.color);
    add_specular(Shade { color, ..shade }, lit.specular)
}
