//! Open questions of the chapter.
//!
//! Each choice is a ruling of kind `choice`; see [`Choices`].

use crate::suite::dialect::{Choice, Choices};
use crate::texture::Rules;

/// All open questions.
pub const CHOICES: Choices<Rules> = Choices(&[
    Choice {
        ruling: "texel-grid",
        readings: &[("cells", |r| r), ("points", Rules::with_points)],
    },
    Choice {
        ruling: "gamma",
        readings: &[("scalar", |r| r), ("vector", Rules::with_vector_gamma)],
    },
    Choice {
        ruling: "clamp-color",
        readings: &[("texel", |r| r), ("result", Rules::with_clamp_color_alone)],
    },
    Choice {
        ruling: "vrc-azimuth",
        readings: &[
            ("rightward", |r| r),
            ("leftward", Rules::with_leftward_azimuth),
            ("cosine", Rules::with_cosine_azimuth),
            ("rear half mirrored", Rules::with_rear_mirrored),
        ],
    },
    Choice {
        ruling: "vrc-height",
        readings: &[
            ("angle", |r| r),
            ("linear", Rules::with_vrc_height_by_y),
            ("downward", Rules::with_vrc_downward),
        ],
    },
    Choice {
        ruling: "wc-azimuth",
        readings: &[
            ("counter-clockwise", |r| r),
            ("clockwise", Rules::with_clockwise),
        ],
    },
    Choice {
        ruling: "wc-height",
        readings: &[
            ("angle", |r| r),
            ("linear", Rules::with_wc_height_by_y),
            ("downward", Rules::with_wc_downward),
        ],
    },
    Choice {
        ruling: "ptm-texels",
        readings: &[("rounded", |r| r), ("kept", Rules::with_real_texels)],
    },
]);

/// Returns a reading by its name in the `also` lists of cases; these are readings of choices and of points that are left to the
/// implementation.
#[must_use]
pub fn find(reading: &str) -> Option<fn(Rules) -> Rules> {
    Some(match reading {
        "cells" | "scalar" => |r| r,
        "points" => Rules::with_points,
        "vector" => Rules::with_vector_gamma,
        "clamp-color-alone" | "clamp-color-final" | "final" => Rules::with_clamp_color_alone,
        "leftward" => Rules::with_leftward_azimuth,
        "cosine-azimuth" => Rules::with_cosine_azimuth,
        "rear-half-mirrored" => Rules::with_rear_mirrored,
        "t1-linear-in-height" => |r| r.with_vrc_height_by_y().with_wc_height_by_y(),
        "t1-downward" => |r| r.with_vrc_downward().with_wc_downward(),
        "clockwise" => Rules::with_clockwise,
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
        "float-texels" => Rules::with_real_texels,
        _ => return None,
    })
}
