//! Open questions of the chapter.
//!
//! Each choice is a ruling of kind `choice`; see [`Choices`].

use crate::suite::dialect::{Choice, Choices};
use crate::texture::map::texel_color;
use crate::texture::parameterize::{
    azimuth_proportional_to_x, full_turn_fraction, half_turn_fraction, height_by_y, height_from_top,
};
use crate::texture::{Rules, Shade, sample};

/// All open questions.
pub const CHOICES: Choices<Rules> = Choices(&[
    Choice {
        ruling: "texel-grid",
        readings: &[
            ("cells", |_| {}),
            ("points", |r| {
                r.closest = sample::point_index;
                r.neighbors = sample::points_around;
            }),
        ],
    },
    Choice {
        ruling: "gamma",
        readings: &[
            ("scalar", |_| {}),
            ("vector", |r| r.gamma = |_, texel| texel_color(texel)),
        ],
    },
    Choice {
        ruling: "clamp-color",
        readings: &[
            ("texel", |_| {}),
            ("result", |r| {
                r.clamp_color = |_, color, input, _, rules| Shade {
                    color: (rules.texel_color)(color),
                    ..input
                };
            }),
        ],
    },
    Choice {
        ruling: "vrc-azimuth",
        readings: &[
            ("rightward", |_| {}),
            ("leftward", |r| {
                r.vrc_azimuth = |s| (1.0 - half_turn_fraction(s)).fract();
            }),
            ("cosine", |r| r.vrc_azimuth = azimuth_proportional_to_x),
            ("rear half mirrored", |r| {
                r.vrc_azimuth = |[x, y, z]| half_turn_fraction([x, y, z.abs()]);
            }),
        ],
    },
    Choice {
        ruling: "vrc-height",
        readings: &[
            ("angle", |_| {}),
            ("linear", |r| r.vrc_height = height_by_y),
            ("downward", |r| r.vrc_height = height_from_top),
        ],
    },
    Choice {
        ruling: "wc-azimuth",
        readings: &[
            ("counter-clockwise", |_| {}),
            ("clockwise", |r| {
                r.wc_azimuth = |s| (1.0 - full_turn_fraction(s)).fract();
            }),
        ],
    },
    Choice {
        ruling: "wc-height",
        readings: &[
            ("angle", |_| {}),
            ("linear", |r| r.wc_height = height_by_y),
            ("downward", |r| r.wc_height = height_from_top),
        ],
    },
    Choice {
        ruling: "ptm-texels",
        readings: &[
            ("rounded", |_| {}),
            ("kept", |r| r.to_eight_bits = |value| value),
        ],
    },
]);

/// Returns a reading by its name in the `also` lists of cases; these are readings of choices and of points that are left to the
/// implementation.
#[must_use]
pub fn find(reading: &str) -> Option<fn(&mut Rules)> {
    let listed = |ruling: &str, reading: usize| {
        let choice = CHOICES.iter().find(|choice| choice.ruling == ruling);
        choice.map(|choice| choice.readings[reading].1)
    };
    Some(match reading {
        "cells" | "scalar" => |_| {},
        "points" => return listed("texel-grid", 1),
        "vector" => return listed("gamma", 1),
        "clamp-color-alone" | "clamp-color-final" | "final" => return listed("clamp-color", 1),
        "leftward" => return listed("vrc-azimuth", 1),
        "cosine-azimuth" => return listed("vrc-azimuth", 2),
        "rear-half-mirrored" => return listed("vrc-azimuth", 3),
        "clockwise" => return listed("wc-azimuth", 1),
        "float-texels" => return listed("ptm-texels", 1),
        "t1-linear-in-height" => |r| {
            r.vrc_height = height_by_y;
            r.wc_height = height_by_y;
        },
        "t1-downward" => |r| {
            r.vrc_height = height_from_top;
            r.wc_height = height_from_top;
        },
        "half-goes-up" => {
            |r| r.closest_level = |depth, top| ((depth + 0.5).floor().max(0.0) as usize).min(top)
        }
        "missing-alpha-is-0" => |r| {
            r.gamma = |entry, texel| {
                let selected = (Rules::SPEC.gamma)(entry, texel);
                let missing = entry.channel == crate::texture::Channel::Alpha
                    && texel.alpha().is_none()
                    && texel.luminance().is_none();
                if missing { [0.0; 3] } else { selected }
            };
        },
        _ => return None,
    })
}
