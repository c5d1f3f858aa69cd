//! Open questions of the texture mapping chapter.
//!
//! Each choice is a ruling of kind `choice`; see [`Choices`].

use crate::dialect::{Choice, Choices, Readings};
use ptm_texture::map::texel_color;
use ptm_texture::parameterize::{
    azimuth_proportional_to_x, full_turn_fraction, half_turn_fraction, height_by_y, height_from_top,
};
use ptm_texture::{Rules, Shade, depth, sample};

const TEXEL_GRID: Readings<Rules> = &[
    ("cells", |_| {}),
    ("points", |r| {
        r.closest = sample::point_index;
        r.neighbors = sample::points_around;
    }),
];
const GAMMA: Readings<Rules> = &[
    ("scalar", |_| {}),
    ("vector", |r| r.gamma = |_, texel| texel_color(texel)),
];
const CLAMP_COLOR: Readings<Rules> = &[
    ("texel", |_| {}),
    ("result", |r| {
        r.clamp_color = |_, color, input, _, rules| Shade {
            color: (rules.texel_color)(color),
            ..input
        };
    }),
];
const VRC_AZIMUTH: Readings<Rules> = &[
    ("rightward", |_| {}),
    ("leftward", |r| {
        r.vrc_azimuth = |s| (1.0 - half_turn_fraction(s)).fract();
    }),
    ("cosine", |r| r.vrc_azimuth = azimuth_proportional_to_x),
    ("rear half mirrored", |r| {
        r.vrc_azimuth = |[x, y, z]| half_turn_fraction([x, y, z.abs()]);
    }),
];
const VRC_HEIGHT: Readings<Rules> = &[
    ("angle", |_| {}),
    ("linear", |r| r.vrc_height = height_by_y),
    ("downward", |r| r.vrc_height = height_from_top),
];
const WC_AZIMUTH: Readings<Rules> = &[
    ("counter-clockwise", |_| {}),
    ("clockwise", |r| {
        r.wc_azimuth = |s| (1.0 - full_turn_fraction(s)).fract();
    }),
];
const WC_HEIGHT: Readings<Rules> = &[
    ("angle", |_| {}),
    ("linear", |r| r.wc_height = height_by_y),
    ("downward", |r| r.wc_height = height_from_top),
];
const BIAS_AND_MODE: Readings<Rules> = &[
    ("span", |_| {}),
    ("biased depth", |r| {
        r.is_magnified = depth::biased_depth_at_most_zero;
    }),
];
const PTM_TEXELS: Readings<Rules> = &[
    ("rounded", |_| {}),
    ("kept", |r| r.to_eight_bits = |value| value),
];

/// All open questions.
pub const CHOICES: Choices<Rules> = Choices(&[
    Choice::new("texel-grid", TEXEL_GRID),
    Choice::new("gamma", GAMMA),
    Choice::new("clamp-color", CLAMP_COLOR),
    Choice::new("vrc-azimuth", VRC_AZIMUTH),
    Choice::new("vrc-height", VRC_HEIGHT),
    Choice::new("wc-azimuth", WC_AZIMUTH),
    Choice::new("wc-height", WC_HEIGHT),
    Choice::new("bias-and-mode", BIAS_AND_MODE),
    Choice::new("ptm-texels", PTM_TEXELS),
]);

/// Finds a reading by the name that cases use for it in their `also` lists. It is a reading of a choice, or of a point that is
/// left to the implementation.
#[must_use]
pub fn find(reading: &str) -> Option<fn(&mut Rules)> {
    Some(match reading {
        "cells" | "scalar" => |_| {},
        "points" => TEXEL_GRID[1].1,
        "vector" => GAMMA[1].1,
        "clamp-color-alone" | "clamp-color-final" | "final" => CLAMP_COLOR[1].1,
        "leftward" => VRC_AZIMUTH[1].1,
        "cosine-azimuth" => VRC_AZIMUTH[2].1,
        "rear-half-mirrored" => VRC_AZIMUTH[3].1,
        "clockwise" => WC_AZIMUTH[1].1,
        "biased-depth" => BIAS_AND_MODE[1].1,
        "float-texels" => PTM_TEXELS[1].1,
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
                let is_missing = texel.alpha().is_none() && texel.luminance().is_none();
                let is_alpha = entry.channel == ptm_texture::Channel::Alpha;
                if is_alpha && is_missing {
                    [0.0; 3]
                } else {
                    selected
                }
            };
        },
        _ => return None,
    })
}
