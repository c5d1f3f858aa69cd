//! Scenes that are painted, by name.

use std::str::FromStr;

/// A pattern for the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// An independent pseudo-random byte for every sample.
    Noise,
    /// 0 or 255, pseudo-random.
    Extremes,
    /// Values that increase to the right, downward and from channel to channel.
    Ramp,
    /// One value per channel, the same for all texels.
    Stripes,
    /// One value for all samples.
    Flat(u8),
    /// Like noise, but all coefficients except a5 are 128, so that the light has no effect.
    Unlit,
    /// Like unlit, and Cr equals a5: luminance and Cr are equal under scale 1 and bias 0.
    LuminanceIsCr,
    /// An independent pseudo-random byte from 96 to 159 for every sample, far from both ends.
    Soft,
    /// Like noise, within two rings of one value.
    Framed(u8),
    /// One value along every line from the bottom left to the top right; four values alternate across the lines.
    Diagonals,
    /// Two values that alternate by column; their sum is odd.
    Columns,
    /// Two values that alternate by row; their sum is odd.
    Rows,
    /// Bands of four columns: one value, and one that grows or shrinks by one in two of three rows.
    Edges,
    /// One value, and isolated texels that are one more or one less.
    Dots,
    /// 0, but the top row begins with isolated texels of another value in each channel.
    Breaks,
    /// 0, but another value in the last column of each channel.
    LastColumn,
}

impl FromStr for Scene {
    type Err = String;

    /// `noise`, `extremes`, `ramp`, `stripes`, `flat-200`, `unlit`, `luminance-is-cr`, `soft`, `framed-128`, `diagonals`, `columns`, `rows`, `edges`, `dots`, `breaks`, `last-column`.
    fn from_str(name: &str) -> Result<Scene, String> {
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
            "edges" => Scene::Edges,
            "dots" => Scene::Dots,
            "breaks" => Scene::Breaks,
            "last-column" => Scene::LastColumn,
            _ => {
                let value = |prefix| name.strip_prefix(prefix)?.parse().ok();
                let flat = value("flat-").map(Scene::Flat);
                let scene = flat.or_else(|| value("framed-").map(Scene::Framed));
                scene.ok_or_else(|| format!("unknown scene {name:?}"))?
            }
        })
    }
}
