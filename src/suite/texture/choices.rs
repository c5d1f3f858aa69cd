//! Open questions of the chapter.
//!
//! Each choice is a ruling of kind `choice`; see [`Choices`].

use crate::suite::dialect::{Choice, Choices};
use crate::texture::map::texel_color;
use crate::texture::{Rules, Shade, parameterize, sample};

/// All open questions.
pub const CHOICES: Choices<Rules> = Choices(&[
    Choice {
        ruling: "texel-grid",
        readings: &[
            ("cells", |r| r),
            ("points", |r| Rules {
                closest: sample::point_index,
                neighbors: sample::points_around,
                ..r
            }),
        ],
    },
    Choice {
        ruling: "gamma",
        readings: &[
            ("scalar", |r| r),
            ("vector", |r| Rules {
                gamma: |_, texel| texel_color(texel),
                ..r
            }),
        ],
    },
    Choice {
        ruling: "clamp-color",
        readings: &[
            ("texel", |r| r),
            ("result", |r| Rules {
                clamp_color: |_, color, input, _, rules| Shade {
                    color: (rules.texel_color)(color),
                    ..input
                },
                ..r
            }),
        ],
    },
    Choice {
        ruling: "vrc-azimuth",
        readings: &[
            ("rightward", |r| r),
            ("leftward", |r| Rules {
                vrc_azimuth: |s| (1.0 - parameterize::half_turn_fraction(s)).fract(),
                ..r
            }),
            ("cosine", |r| Rules {
                vrc_azimuth: parameterize::azimuth_proportional_to_x,
                ..r
            }),
            ("rear half mirrored", |r| Rules {
                vrc_azimuth: |[x, y, z]| parameterize::half_turn_fraction([x, y, z.abs()]),
                ..r
            }),
        ],
    },
    Choice {
        ruling: "vrc-height",
        readings: &[
            ("angle", |r| r),
            ("linear", |r| Rules {
                vrc_height: parameterize::height_by_y,
                ..r
            }),
            ("downward", |r| Rules {
                vrc_height: parameterize::height_from_top,
                ..r
            }),
        ],
    },
    Choice {
        ruling: "wc-azimuth",
        readings: &[
            ("counter-clockwise", |r| r),
            ("clockwise", |r| Rules {
                wc_azimuth: |s| (1.0 - parameterize::full_turn_fraction(s)).fract(),
                ..r
            }),
        ],
    },
    Choice {
        ruling: "wc-height",
        readings: &[
            ("angle", |r| r),
            ("linear", |r| Rules {
                wc_height: parameterize::height_by_y,
                ..r
            }),
            ("downward", |r| Rules {
                wc_height: parameterize::height_from_top,
                ..r
            }),
        ],
    },
    Choice {
        ruling: "ptm-texels",
        readings: &[
            ("rounded", |r| r),
            ("kept", |r| Rules {
                to_eight_bits: |value| value,
                ..r
            }),
        ],
    },
]);

/// Returns a reading by its name in the `also` lists of cases; these are readings of choices and of points that are left to the
/// implementation.
#[must_use]
pub fn find(reading: &str) -> Option<fn(Rules) -> Rules> {
    let listed = |ruling: &str, reading: usize| {
        let choice = CHOICES.iter().find(|choice| choice.ruling == ruling);
        choice.map(|choice| choice.readings[reading].1)
    };
    Some(match reading {
        "cells" | "scalar" => |r| r,
        "points" => return listed("texel-grid", 1),
        "vector" => return listed("gamma", 1),
        "clamp-color-alone" | "clamp-color-final" | "final" => return listed("clamp-color", 1),
        "leftward" => return listed("vrc-azimuth", 1),
        "cosine-azimuth" => return listed("vrc-azimuth", 2),
        "rear-half-mirrored" => return listed("vrc-azimuth", 3),
        "clockwise" => return listed("wc-azimuth", 1),
        "float-texels" => return listed("ptm-texels", 1),
        "t1-linear-in-height" => |r| Rules {
            vrc_height: parameterize::height_by_y,
            wc_height: parameterize::height_by_y,
            ..r
        },
        "t1-downward" => |r| Rules {
            vrc_height: parameterize::height_from_top,
            wc_height: parameterize::height_from_top,
            ..r
        },
        "half-goes-up" => |r| Rules {
            closest_level: |depth, top| ((depth + 0.5).floor().max(0.0) as usize).min(top),
            ..r
        },
        "missing-alpha-is-0" => |r| Rules {
            gamma: |entry, texel| {
                let selected = (Rules::SPEC.gamma)(entry, texel);
                let missing = entry.channel == crate::texture::Channel::Alpha
                    && texel.alpha().is_none()
                    && texel.luminance().is_none();
                if missing { [0.0; 3] } else { selected }
            },
            ..r
        },
        _ => return None,
    })
}
