//! Composition controls: combining the color of a map with the color of the primitive.
//!
//! Each method has equations for texels without alpha (RGB, L) and with alpha (RGBA, LA) (R-CMP-30 … R-CMP-39). In the
//! *split* form (R-CMP-20), the texture is applied after lighting, and W is the light on a white surface. In the *direct*
//! form (R-CMP-21), W is white:
//!
//! | method | color, no alpha | color, with alpha | alpha, no alpha | alpha, with alpha |
//! |---|---|---|---|---|
//! | Replace | W·T | W·T | A | AT |
//! | Modulate | C·T | C·T | A | A·AT |
//! | `BlendEnvColor` | (1 − Γ)·C + Γ·W·E | same | A | A·AT |
//! | Decal | W·T | (1 − AT)·C + AT·W·T | A | A |
//! | `DecalBackground` | W·T | W·((1 − AT)·B + AT·T) | A | A |
//!
//! Format notes
//! - Both decal methods leave the alpha of the primitive unchanged. The other three methods change it.
//! - Γ is used by `BlendEnvColor` (ruling `gamma`), despite the chapter's list of symbols.
//! - No result is clamped to 0 … 1 (ruling `color-range`).

use super::entry::{Channel, Color, Composition, Entry};
use super::map::{Texel, texel_color};
use super::primitive::{MapValue, Shade, Terms};
use super::rules::Rules;

/// Applies a map to a primitive. `white` is the light on a white surface in the split form, and white in the direct form.
#[must_use]
pub fn compose(
    entry: &Entry,
    fetched: &MapValue,
    input: Shade,
    white: Color,
    rules: &Rules,
) -> Shade {
    match fetched {
        // R-CLM-03
        MapValue::Discontinued => input,
        MapValue::Clamped(color) => (rules.clamp_color)(entry, color, input, white, rules),
        MapValue::Texel(texel) => compose_texel(entry, texel, input, white, rules),
    }
}

/// Applies the composition method to a texel. The clamp color is treated as a texel without alpha (ruling `clamp-color`).
#[must_use]
pub fn compose_texel(
    entry: &Entry,
    texel: &Texel,
    input: Shade,
    white: Color,
    rules: &Rules,
) -> Shade {
    let terms = Terms {
        input,
        white,
        color: (rules.texel_color)(texel),
        alpha: texel.alpha(),
        gamma: (rules.gamma)(entry, texel),
        entry,
    };
    match entry.composition {
        Composition::Replace => (rules.replace)(&terms),
        Composition::Modulate => (rules.modulate)(&terms),
        Composition::BlendEnvColor => (rules.blend_env_color)(&terms),
        Composition::Decal => (rules.decal)(&terms),
        Composition::DecalBackground => (rules.decal_background)(&terms),
    }
}

/// Composes with method Replace (R-CMP-30, R-CMP-31).
#[must_use]
pub fn replace(x: &Terms) -> Shade {
    Shade {
        color: multiply(x.white, x.color),
        alpha: x.alpha.unwrap_or(x.input.alpha),
    }
}

/// Composes with method Modulate (R-CMP-32, R-CMP-33).
#[must_use]
pub fn modulate(x: &Terms) -> Shade {
    Shade {
        color: multiply(x.input.color, x.color),
        alpha: x.input.alpha * x.alpha.unwrap_or(1.0),
    }
}

/// Composes with method `BlendEnvColor` (R-CMP-34, R-CMP-35).
#[must_use]
pub fn blend_env_color(x: &Terms) -> Shade {
    let environment = multiply(x.white, x.entry.env_color);
    Shade {
        color: mix(x.input.color, environment, x.gamma),
        alpha: x.input.alpha * x.alpha.unwrap_or(1.0),
    }
}

/// Composes with method Decal (R-CMP-36, R-CMP-37).
#[must_use]
pub fn decal(x: &Terms) -> Shade {
    let weight = x.alpha.unwrap_or(1.0);
    Shade {
        color: mix(x.input.color, multiply(x.white, x.color), [weight; 3]),
        alpha: x.input.alpha,
    }
}

/// Composes with method `DecalBackground` (R-CMP-38, R-CMP-39).
#[must_use]
pub fn decal_background(x: &Terms) -> Shade {
    let weight = x.alpha.unwrap_or(1.0);
    let covered = mix(x.entry.background_color, x.color, [weight; 3]);
    Shade {
        color: multiply(x.white, covered),
        alpha: x.input.alpha,
    }
}

/// Returns Γ: the selected channel, or the luminance (R-CMP-18, R-CHN-01 … R-CHN-04, ruling `gamma`). If alpha is selected,
/// a texel without alpha is treated as opaque (ruling `no-alpha-to-select`).
#[must_use]
pub fn selected_channel(entry: &Entry, texel: &Texel) -> Color {
    let rgb = texel_color(texel);
    let gamma = texel.luminance().unwrap_or(match entry.channel {
        Channel::Red => rgb[0],
        Channel::Green => rgb[1],
        Channel::Blue => rgb[2],
        Channel::Alpha => texel.alpha().unwrap_or(1.0),
    });
    [gamma; 3]
}

/// Multiplies two colors, channel by channel.
#[must_use]
pub fn multiply(a: Color, b: Color) -> Color {
    [0, 1, 2].map(|c| a[c] * b[c])
}

/// Interpolates from `a` to `b`. `weight` is the weight of `b`, per channel.
#[must_use]
pub fn mix(a: Color, b: Color, weight: Color) -> Color {
    [0, 1, 2].map(|c| (1.0 - weight[c]) * a[c] + weight[c] * b[c])
}
