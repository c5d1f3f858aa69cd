//! Expected values of files: painted by the generator, or computed by hand.

use crate::error::{Error, Result};
use data_encoding::HEXLOWER_PERMISSIVE;
use serde::Deserialize;

use crate::protocol::frame::{Frame, Samples, View, ViewKind};
use ptm::{Format, Size};
use ptm_generate::{Model, spelling::Count};

/// Expected values of a file.
#[derive(Clone, Debug)]
pub enum Values {
    /// Painted by the generator.
    Painted(Model),
    /// Computed by hand.
    Hand(HandValues),
    /// Any values are correct.
    Any,
    /// The file must be refused.
    None,
}

impl Values {
    /// Returns true if `frame` is a raw frame that contains exactly the painted values. If not, the frame may still be correct.
    pub(super) fn has_equal_samples(&self, frame: &Frame) -> bool {
        let Values::Painted(model) = self else {
            return false;
        };
        let size = (frame.width, frame.height) == (model.size.width, model.size.height);
        let is_raw = frame.view == ViewKind::Raw && !frame.lossy && size;
        is_raw && matches!(&frame.samples, Samples::U8(bytes) if *bytes == model.samples)
    }
}

/// A part of a hand-assembled file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HandPiece {
    /// Name of the part, which also serves as its description.
    #[serde(rename = "is")]
    pub name: String,
    text: Option<String>,
    hex: Option<String>,
}

/// The values of a hand-assembled file; one line per texel, top row first.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandValues {
    /// Width and height.
    pub size: String,
    /// Stored values.
    pub raw: Vec<String>,
    /// Final coefficients, after scale and bias.
    pub coef: Option<Vec<String>>,
    /// Colors under a light.
    pub rgb: Option<HandImage>,
}

/// Colors of a hand-assembled file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandImage {
    /// Direction of the light, as `LU,LV`.
    pub light: String,
    /// Colors, as real numbers from 0 to 255.
    pub texels: Vec<String>,
}

impl HandPiece {
    /// Returns the bytes of the part; `count` and `newline` select the spelling of a lookup table.
    pub fn bytes(&self, count: Count, newline: bool) -> Result<Vec<u8>> {
        let mut bytes = match (&self.text, &self.hex) {
            (Some(text), None) => text.as_bytes().to_vec(),
            (None, Some(hex)) => parse_hex(hex)?,
            _ => return Error::invalid(format!("piece {:?} needs either text or hex", self.name)),
        };
        if self.name == "count" {
            let text = String::from_utf8_lossy(&bytes);
            let mut words = text.split_whitespace();
            let number = words.find(|word| word.parse::<u32>().is_ok());
            let number = number.ok_or("a piece with `is: count` needs a number")?;
            bytes = format!("{}\n", count.name().replace("256", number)).into_bytes();
        }
        if self.name == "table" && newline {
            bytes.push(b'\n');
        }
        Ok(bytes)
    }
}

pub(super) fn format_of(pieces: &[HandPiece]) -> Result<Format> {
    let format = pieces.iter().find(|piece| piece.name == "format");
    let text = format.and_then(|piece| piece.text.as_ref());
    Ok(text
        .ok_or("a hand-assembled file needs a piece with `is: format`")?
        .trim()
        .parse()?)
}

/// Parses bytes as pairs of hexadecimal digits.
///
/// # Errors
/// Returns a message that describes the error in the text.
pub fn parse_hex(text: &str) -> Result<Vec<u8>> {
    let digits: String = text.split_whitespace().collect();
    let bytes = HEXLOWER_PERMISSIVE.decode(digits.as_bytes());
    bytes.map_err(|_| format!("expected pairs of hex digits, found {text:?}").into())
}

impl HandValues {
    /// Parses the numbers in `lines`, texel by texel.
    #[must_use]
    pub fn numbers(lines: &[String]) -> Vec<f64> {
        let words = lines.iter().flat_map(|line| line.split_whitespace());
        words.filter_map(|number| number.parse().ok()).collect()
    }

    pub(super) fn views(&self) -> Result<Vec<View>> {
        let coef = self.coef.iter().map(|_| Ok(View::Coef));
        let light = self.rgb.iter().map(|image| &image.light);
        let rgb = light.map(|light| format!("rgb:{light}").parse());
        [Ok(View::Raw)].into_iter().chain(coef).chain(rgb).collect()
    }

    pub(super) fn check(&self, format: Format) -> Result<()> {
        let texels = self.size.parse::<Size>()?.texels();
        let check = |name: &str, lines: &[String], channels: usize| {
            let words = lines.iter().map(|line| line.split_whitespace().count());
            let numbers = HandValues::numbers(lines).len();
            if lines.len() != texels
                || words.clone().any(|count| count != channels)
                || words.sum::<usize>() != numbers
            {
                return Error::invalid(format!(
                    "{name} needs {texels} lines of {channels} numbers"
                ));
            }
            Ok(())
        };
        check("raw", &self.raw, format.channels())?;
        if let Some(coef) = &self.coef {
            check("coef", coef, format.channels())?;
        }
        match &self.rgb {
            Some(image) => check("rgb", &image.texels, 3),
            None => Ok(()),
        }
    }
}
