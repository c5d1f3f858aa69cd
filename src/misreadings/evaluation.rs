//! §1.0 Background: the polynomial, the light, the color

use super::at::At;

pub(super) const ACTS: &[(&str, At)] = &[
    ("v-negated", At::Light(|lu, lv| (lu, -lv))),
    ("u-negated", At::Light(|lu, lv| (-lu, lv))),
    ("u-and-v-negated", At::Light(|lu, lv| (-lu, -lv))),
    ("u-and-v-exchanged", At::Light(|lu, lv| (lv, lu))),
    (
        "light-from-0-to-1",
        At::Light(|lu, lv| (f64::midpoint(lu, 1.0), f64::midpoint(lv, 1.0))),
    ),
    ("light-in-degrees", At::Light(|lu, lv| (lu.sin(), lv.sin()))),
    (
        "light-stretched",
        At::Light(|lu, lv| {
            let length = lu.hypot(lv);
            if length > 0.0 {
                (lu / length, lv / length)
            } else {
                (lu, lv)
            }
        }),
    ),
    ("light-ignored", At::Light(|_, _| (0.0, 0.0))),
    (
        "light-to-one-decimal",
        At::Light(|lu, lv| ((lu * 10.0).trunc() / 10.0, (lv * 10.0).trunc() / 10.0)),
    ),
    (
        "light-not-negative",
        At::Light(|lu, lv| (lu.max(0.0), lv.max(0.0))),
    ),
    (
        "a0-a1-swapped",
        At::Polynomial(|a, u, v| spec(&[a[1], a[0], a[2], a[3], a[4], a[5]], u, v)),
    ),
    (
        "a3-a4-swapped",
        At::Polynomial(|a, u, v| spec(&[a[0], a[1], a[2], a[4], a[3], a[5]], u, v)),
    ),
    (
        "a1-a2-swapped",
        At::Polynomial(|a, u, v| spec(&[a[0], a[2], a[1], a[3], a[4], a[5]], u, v)),
    ),
    (
        "a0-a5-swapped",
        At::Polynomial(|a, u, v| spec(&[a[5], a[1], a[2], a[3], a[4], a[0]], u, v)),
    ),
    (
        "a2-a3-swapped",
        At::Polynomial(|a, u, v| spec(&[a[0], a[1], a[3], a[2], a[4], a[5]], u, v)),
    ),
    (
        "no-cross-term",
        At::Polynomial(|a, u, v| spec(a, u, v) - a[2] * u * v),
    ),
    (
        "cross-term-twice",
        At::Polynomial(|a, u, v| spec(a, u, v) + a[2] * u * v),
    ),
    (
        "no-constant-term",
        At::Polynomial(|a, u, v| spec(a, u, v) - a[5]),
    ),
    (
        "no-squares",
        At::Polynomial(|a, u, v| spec(a, u, v) - a[0] * u * u - a[1] * v * v),
    ),
    (
        "squares-not-squared",
        At::Polynomial(|a, u, v| (a[0] + a[3]) * u + (a[1] + a[4]) * v + a[2] * u * v + a[5]),
    ),
    (
        "squares-with-sign",
        At::Polynomial(|a, u, v| {
            a[0] * u * u.abs() + a[1] * v * v.abs() + a[2] * u * v + a[3] * u + a[4] * v + a[5]
        }),
    ),
    (
        "terms-ascending",
        At::Polynomial(|a, u, v| {
            a[0] + a[1] * u + a[2] * v + a[3] * u * v + a[4] * v * v + a[5] * u * u
        }),
    ),
    (
        "luminance-truncated",
        At::Polynomial(|a, u, v| spec(a, u, v).trunc()),
    ),
    (
        "luminance-mirrored",
        At::Polynomial(|a, u, v| spec(a, u, v).abs()),
    ),
    ("color-over-256", At::Modulate(|l, c| l * c / 256.0)),
    (
        "color-over-256-truncated",
        At::Modulate(|l, c| (l * c / 256.0).floor()),
    ),
    ("color-not-divided", At::Modulate(|l, c| l * c)),
    (
        "color-divided-twice",
        At::Modulate(|l, c| l * c / 255.0 / 255.0),
    ),
    ("color-added", At::Modulate(|l, c| l + c)),
    ("color-ignored", At::Modulate(|l, _| l)),
    ("luminance-ignored", At::Modulate(|_, c| c)),
    ("luminance-over-128", At::Modulate(|l, c| l * c / 128.0)),
    (
        "clamp-before-color",
        At::Modulate(|l, c| l.clamp(0.0, 255.0) * c / 255.0),
    ),
    (
        "luminance-wraps",
        At::Modulate(|l, c| f64::from(l as i64 as u8) * c / 255.0),
    ),
    (
        "color-wraps",
        At::Clamp(|value| f64::from(value as i64 as u8)),
    ),
    (
        "color-wraps-below",
        At::Clamp(|value| {
            if value < 0.0 {
                f64::from(value as i64 as u8)
            } else {
                value.min(255.0)
            }
        }),
    ),
    (
        "color-wraps-above",
        At::Clamp(|value| {
            if value > 255.0 {
                f64::from(value as i64 as u8)
            } else {
                value.max(0.0)
            }
        }),
    ),
    (
        "negative-color-mirrored",
        At::Clamp(|value| value.abs().min(255.0)),
    ),
    (
        "overflow-is-black",
        At::Clamp(|value| if value > 255.0 { 0.0 } else { value.max(0.0) }),
    ),
    (
        "color-gamma",
        At::Clamp(|value| (value.clamp(0.0, 255.0) / 255.0).powf(1.0 / 2.2) * 255.0),
    ),
    (
        "colors-inverted",
        At::Clamp(|value| 255.0 - value.clamp(0.0, 255.0)),
    ),
];

fn spec(a: &[f64], lu: f64, lv: f64) -> f64 {
    crate::evaluate::polynomial(a, lu, lv)
}
