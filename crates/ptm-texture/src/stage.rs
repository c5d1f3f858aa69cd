//! Rendering control: applies all maps and the light to a primitive, in one of two forms.
//!
//! Each map is applied to the result of the previous one (R-CMP-05, R-CMP-06). `PreLight` maps precede the reflectance
//! calculation, and `PostLight` maps follow it (R-RCT-04, R-RCT-05). If light is computed per facet or vertex but the texture is
//! sampled per pixel, the split form is used: the light on the surface and the light on a white surface are computed first, and
//! the maps are applied to both (R-CMP-20). All other cases use the direct form (R-CMP-21).
//!
//! Format notes
//! - The reflectance calculation is `CW·C + CS`: ambient and diffuse light times the color, plus the highlight. A stage
//!   needs no other properties of the light. CW and CS are inputs.
//! - Both forms produce the same color because of the position of CW in the equations (ruling `split-form`).
//! - If a list contains maps of both kinds, there are two stages, each in the order of the list (ruling `two-stages`).

use super::compose::{compose, multiply};
use super::entry::{Color, Entry, RenderingControl};
use super::primitive::{Frequency, Interpolation, LitPrimitive, MapValue, Shade};
use super::rules::Rules;

/// Applies all `maps` and the light to a primitive.
#[must_use]
pub fn stage(
    maps: &[(Entry, MapValue)],
    lit: &LitPrimitive,
    interpolation: Interpolation,
    frequency: Frequency,
    rules: &Rules,
) -> Shade {
    (rules.stage)(maps, lit, interpolation, frequency, rules)
}

/// Applies `PreLight` maps, the light, and `PostLight` maps.
#[must_use]
pub fn apply_all_maps(
    maps: &[(Entry, MapValue)],
    lit: &LitPrimitive,
    interpolation: Interpolation,
    frequency: Frequency,
    rules: &Rules,
) -> Shade {
    let apply = |control: RenderingControl, input: Shade, white: Color| {
        let maps = maps.iter();
        let maps = maps.filter(|(entry, _)| entry.rendering_control == control);
        maps.fold(input, |input, (entry, fetched)| {
            compose(entry, fetched, input, white, rules)
        })
    };
    let lit = if is_split(interpolation, frequency) {
        let diffuse = Shade {
            color: multiply(lit.white, lit.surface.color),
            ..lit.surface
        };
        let textured = apply(RenderingControl::PreLight, diffuse, lit.white);
        // CS is added only at the end (R-CMP-12, R-CMP-13).
        (rules.add_specular)(textured, lit.specular)
    } else {
        let textured = apply(RenderingControl::PreLight, lit.surface, [1.0; 3]);
        (rules.light)(textured, lit)
    };
    apply(RenderingControl::PostLight, lit, [1.0; 3])
}

/// Returns true if light is computed per facet or vertex, but the texture is sampled per pixel (R-CMP-20, R-CMP-23).
#[must_use]
pub fn is_split(interpolation: Interpolation, frequency: Frequency) -> bool {
    matches!(interpolation, Interpolation::None | Interpolation::Color)
        && frequency == Frequency::Pixel
}

/// Adds the highlight (R-CMP-13).
#[must_use]
pub fn add_specular(shade: Shade, specular: Color) -> Shade {
    Shade {
        color: [0, 1, 2].map(|c| shade.color[c] + specular[c]),
        ..shade
    }
}

/// Performs the reflectance calculation: CW·C + CS.
#[must_use]
pub fn apply_light(shade: Shade, lit: &LitPrimitive) -> Shade {
    let color = multiply(lit.white, shade.color);
    add_specular(Shade { color, ..shade }, lit.specular)
}
