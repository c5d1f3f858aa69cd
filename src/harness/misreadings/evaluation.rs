//! §1.0 Background: the polynomial, the light, the color

use super::{At, Decision, Misreading};
use crate::reading::Reading;

pub(super) const ALL: &[Misreading] = &[
    light("v-negated", "negates v", |r| Reading {
        light: |lu, lv| (lu, -lv),
        ..r
    }),
    light("u-negated", "negates u", |r| Reading {
        light: |lu, lv| (-lu, lv),
        ..r
    }),
    light("u-and-v-negated", "negates u and v", |r| Reading {
        light: |lu, lv| (-lu, -lv),
        ..r
    }),
    light("u-and-v-exchanged", "exchanges u and v", |r| Reading {
        light: |lu, lv| (lv, lu),
        ..r
    }),
    light("light-from-0-to-1", "moves u and v into 0…1", |r| {
        Reading {
            light: |lu, lv| (f64::midpoint(lu, 1.0), f64::midpoint(lv, 1.0)),
            ..r
        }
    }),
    light("light-in-degrees", "takes u and v for angles", |r| {
        Reading {
            light: |lu, lv| (lu.sin(), lv.sin()),
            ..r
        }
    }),
    light(
        "light-stretched",
        "stretches the light to the edge of the unit circle",
        |r| Reading {
            light: |lu, lv| {
                let length = lu.hypot(lv);
                if length > 0.0 {
                    (lu / length, lv / length)
                } else {
                    (lu, lv)
                }
            },
            ..r
        },
    ),
    light("light-ignored", "takes every light for (0, 0)", |r| {
        Reading {
            light: |_, _| (0.0, 0.0),
            ..r
        }
    }),
    light(
        "light-to-one-decimal",
        "keeps one decimal of u and v",
        |r| Reading {
            light: |lu, lv| ((lu * 10.0).trunc() / 10.0, (lv * 10.0).trunc() / 10.0),
            ..r
        },
    ),
    light("light-not-negative", "takes negative u and v for 0", |r| {
        Reading {
            light: |lu, lv| (lu.max(0.0), lv.max(0.0)),
            ..r
        }
    }),
    polynomial("a0-a1-swapped", "exchanges a0 and a1", |r| Reading {
        polynomial: |a, u, v| spec(&[a[1], a[0], a[2], a[3], a[4], a[5]], u, v),
        ..r
    }),
    polynomial("a3-a4-swapped", "exchanges a3 and a4", |r| Reading {
        polynomial: |a, u, v| spec(&[a[0], a[1], a[2], a[4], a[3], a[5]], u, v),
        ..r
    }),
    polynomial("a1-a2-swapped", "exchanges a1 and a2", |r| Reading {
        polynomial: |a, u, v| spec(&[a[0], a[2], a[1], a[3], a[4], a[5]], u, v),
        ..r
    }),
    polynomial("a0-a5-swapped", "exchanges a0 and a5", |r| Reading {
        polynomial: |a, u, v| spec(&[a[5], a[1], a[2], a[3], a[4], a[0]], u, v),
        ..r
    }),
    polynomial("a2-a3-swapped", "exchanges a2 and a3", |r| Reading {
        polynomial: |a, u, v| spec(&[a[0], a[1], a[3], a[2], a[4], a[5]], u, v),
        ..r
    }),
    polynomial("no-cross-term", "leaves a2·u·v out", |r| Reading {
        polynomial: |a, u, v| spec(a, u, v) - a[2] * u * v,
        ..r
    }),
    polynomial("cross-term-twice", "adds a2·u·v twice", |r| Reading {
        polynomial: |a, u, v| spec(a, u, v) + a[2] * u * v,
        ..r
    }),
    polynomial("no-constant-term", "leaves a5 out", |r| Reading {
        polynomial: |a, u, v| spec(a, u, v) - a[5],
        ..r
    }),
    polynomial("no-squares", "leaves a0·u² and a1·v² out", |r| {
        Reading {
            polynomial: |a, u, v| spec(a, u, v) - a[0] * u * u - a[1] * v * v,
            ..r
        }
    }),
    polynomial(
        "squares-not-squared",
        "uses u and v where their squares belong",
        |r| Reading {
            polynomial: |a, u, v| (a[0] + a[3]) * u + (a[1] + a[4]) * v + a[2] * u * v + a[5],
            ..r
        },
    ),
    polynomial(
        "squares-with-sign",
        "gives u² and v² the signs of u and v",
        |r| Reading {
            polynomial: |a, u, v| {
                a[0] * u * u.abs() + a[1] * v * v.abs() + a[2] * u * v + a[3] * u + a[4] * v + a[5]
            },
            ..r
        },
    ),
    polynomial(
        "terms-ascending",
        "takes a0 for the constant term and a5 for u²",
        |r| Reading {
            polynomial: |a, u, v| {
                a[0] + a[1] * u + a[2] * v + a[3] * u * v + a[4] * v * v + a[5] * u * u
            },
            ..r
        },
    ),
    beyond_a_color(
        "luminance-truncated",
        "cuts the value of the polynomial to a whole number",
        "round the final color only",
        |r| Reading {
            polynomial: |a, u, v| spec(a, u, v).trunc(),
            ..r
        },
    ),
    beyond_a_color(
        "luminance-mirrored",
        "takes the absolute value of the polynomial",
        "the polynomial may be negative; clamp the final color only",
        |r| Reading {
            polynomial: |a, u, v| spec(a, u, v).abs(),
            ..r
        },
    ),
    modulate(
        "color-over-256",
        "divides luminance times color by 256",
        |r| Reading {
            modulate: |l, c| l * c / 256.0,
            ..r
        },
    ),
    modulate(
        "color-over-256-truncated",
        "divides luminance times color by 256 and cuts the fraction off",
        |r| Reading {
            modulate: |l, c| (l * c / 256.0).floor(),
            ..r
        },
    ),
    modulate(
        "color-not-divided",
        "does not divide luminance times color",
        |r| Reading {
            modulate: |l, c| l * c,
            ..r
        },
    ),
    modulate(
        "color-divided-twice",
        "divides luminance times color by 255 twice",
        |r| Reading {
            modulate: |l, c| l * c / 255.0 / 255.0,
            ..r
        },
    ),
    modulate("color-added", "adds luminance and color", |r| Reading {
        modulate: |l, c| l + c,
        ..r
    }),
    modulate("color-ignored", "shows the luminance alone", |r| Reading {
        modulate: |l, _| l,
        ..r
    }),
    modulate("luminance-ignored", "shows the color alone", |r| Reading {
        modulate: |_, c| c,
        ..r
    }),
    modulate(
        "luminance-over-128",
        "divides luminance times color by 128",
        |r| Reading {
            modulate: |l, c| l * c / 128.0,
            ..r
        },
    ),
    clamped(
        "clamp-before-color",
        "clamps the luminance to 0…255 before multiplying by the color",
        |r| Reading {
            modulate: |l, c| l.clamp(0.0, 255.0) * c / 255.0,
            ..r
        },
    ),
    clamped(
        "luminance-wraps",
        "keeps the luminance in a byte before multiplying by the color",
        |r| Reading {
            modulate: |l, c| f64::from(l as i64 as u8) * c / 255.0,
            ..r
        },
    ),
    final_clamp(
        "color-wraps",
        "lets colors beyond 0…255 wrap around",
        |r| Reading {
            clamp: |value| f64::from(value as i64 as u8),
            ..r
        },
    ),
    final_clamp(
        "color-wraps-below",
        "lets colors below 0 wrap around",
        |r| Reading {
            clamp: |value| {
                if value < 0.0 {
                    f64::from(value as i64 as u8)
                } else {
                    value.min(255.0)
                }
            },
            ..r
        },
    ),
    final_clamp(
        "color-wraps-above",
        "lets colors above 255 wrap around",
        |r| Reading {
            clamp: |value| {
                if value > 255.0 {
                    f64::from(value as i64 as u8)
                } else {
                    value.max(0.0)
                }
            },
            ..r
        },
    ),
    final_clamp(
        "negative-color-mirrored",
        "shows the absolute value of a negative color",
        |r| Reading {
            clamp: |value| value.abs().min(255.0),
            ..r
        },
    ),
    final_clamp("overflow-is-black", "shows colors above 255 as 0", |r| {
        Reading {
            clamp: |value| if value > 255.0 { 0.0 } else { value.max(0.0) },
            ..r
        }
    }),
    final_clamp("color-gamma", "applies a gamma of 2.2", |r| Reading {
        clamp: |value| (value.clamp(0.0, 255.0) / 255.0).powf(1.0 / 2.2) * 255.0,
        ..r
    }),
    final_clamp("colors-inverted", "shows the negative", |r| Reading {
        clamp: |value| 255.0 - value.clamp(0.0, 255.0),
        ..r
    }),
];

const fn light(
    slug: &'static str,
    effect: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause: "1.0/2",
        effect,
        mend: "+u points to the right, +v up; use them as they are",
        at: At::Reading(Decision::Light, change),
    }
}

const fn polynomial(
    slug: &'static str,
    effect: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    let mend = "C = a0·u² + a1·v² + a2·u·v + a3·u + a4·v + a5";
    Misreading {
        slug,
        clause: "1.0/1",
        effect,
        mend,
        at: At::Reading(Decision::Polynomial, change),
    }
}

/// What is done too early to a value that is no color yet.
const fn beyond_a_color(
    slug: &'static str,
    effect: &'static str,
    mend: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause: "1.0/1",
        effect,
        mend,
        at: At::Reading(Decision::Polynomial, change),
    }
}

const fn modulate(
    slug: &'static str,
    effect: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause: "2.7.3/4",
        effect,
        mend: "color = L · RGB / 255",
        at: At::Reading(Decision::Modulate, change),
    }
}

const fn clamped(
    slug: &'static str,
    effect: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause: "2.7.3/5",
        effect,
        mend: "clamp the final color only",
        at: At::Reading(Decision::Modulate, change),
    }
}

const fn final_clamp(
    slug: &'static str,
    effect: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause: "2.7.3/5",
        effect,
        mend: "clamp the final color to 0…255",
        at: At::Reading(Decision::Clamp, change),
    }
}

fn spec(a: &[f64], lu: f64, lv: f64) -> f64 {
    crate::evaluate::polynomial(a, lu, lv)
}
