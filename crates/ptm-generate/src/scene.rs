//! Painted scenes, by name.

use std::str::FromStr;

use crate::error::{Error, Result};

/// A pattern of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// An independent pseudo-random byte for every sample.
    Noise,
    /// A pseudo-random choice of 0 or 255 for every sample.
    Extremes,
    /// Values that increase to the right, downward and from channel to channel.
    Ramp,
    /// One value per channel, the same for all texels.
    Stripes,
    /// This value for all samples.
    Flat(u8),
    /// Like `Noise`, but all coefficients except a5 are 128. If their biases are also 128, the light has no effect.
    Unlit,
    /// Like `Unlit`, but Cr equals a5, so luminance equals Cr if a5 has scale 1 and bias 0.
    LuminanceIsCr,
    /// An independent pseudo-random byte from 96 to 159 for every sample, far from both ends of the range.
    Soft,
    /// An independent pseudo-random value of this many bits, 1 … 8, for every sample.
    Bits(u8),
    /// Like `Noise`, but with a border of this constant value, two texels wide.
    Framed(u8),
    /// One value along every diagonal from the bottom left to the top right. Successive diagonals cycle through four values.
    Diagonals,
    /// Two values that alternate by column; their sum is odd.
    Columns,
    /// Two values that alternate by row; their sum is odd.
    Rows,
    /// Cells of 3×5 samples that are alternately 0 and 255, shifted from channel to channel.
    Cells,
    /// An independent pseudo-random value for every 8×8 block of every channel.
    Blocks,
    /// Alternating bands of four columns: a constant value, and a value that changes by one in two out of every three rows.
    Edges,
    /// A constant value, with isolated texels that are larger or smaller by one.
    Dots,
    /// 0, except for isolated texels at the beginning of the top row. Their values differ between channels.
    Breaks,
    /// 0, except in the last column, where the value differs between channels.
    LastColumn,
}

impl FromStr for Scene {
    type Err = Error;

    /// Parses the name of a variant in kebab case. `flat`, `framed` and `bits` are followed by a number: `flat-200`.
    fn from_str(name: &str) -> Result<Scene> {
        Ok(match name {
            "noise" => Scene::Noise,
            "extremes" => Scene::Extremes,
            "ramp" => Scene::Ramp,
            "stripes" => Scene::Stripes,
            "unlit" => Scene::Unlit,
            "luminance-is-cr" => Scene::LuminanceIsCr,
            "soft" => Scene::Soft,
            "diagonals" => Scene::Diagonals,
            "columns" => Scene::Columns,
            "rows" => Scene::Rows,
            "cells" => Scene::Cells,
            "blocks" => Scene::Blocks,
            "edges" => Scene::Edges,
            "dots" => Scene::Dots,
            "breaks" => Scene::Breaks,
            "last-column" => Scene::LastColumn,
            _ => {
                let value = |prefix| name.strip_prefix(prefix)?.parse().ok();
                let flat = value("flat-").map(Scene::Flat);
                let framed = || value("framed-").map(Scene::Framed);
                let bits = || {
                    value("bits-")
                        .filter(|bits| (1..=8).contains(bits))
                        .map(Scene::Bits)
                };
                let scene = flat.or_else(framed).or_else(bits);
                scene.ok_or_else(|| Error::unknown("scene", name))?
            }
        })
    }
}
