//! Recipes for files: format, size, scene, numbers, spelling.

use std::borrow::Cow;
use std::str::FromStr;

use super::{plan::Compression, scene::Scene, spelling::Spelling};
use crate::error::{Error, Result};
use ptm::{Format, Size};

/// `N` numbers, each with its spelling.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbers<const N: usize> {
    /// All spellings in one string, to save memory: a suite may have a hundred thousand recipes.
    text: Box<str>,
    /// The values of the numbers.
    pub values: [f64; N],
}

impl<const N: usize> FromStr for Numbers<N> {
    type Err = Error;

    /// Parses numbers separated by spaces: `"2 2 0.5 1e-1 -3 .25"`.
    fn from_str(text: &str) -> Result<Numbers<N>> {
        let values: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
        let values = values.map_err(|_| Error::syntax("numbers", text))?;
        let values = values
            .try_into()
            .map_err(|_| Error::syntax(format!("{N} numbers"), text))?;
        Ok(Numbers {
            text: text.into(),
            values,
        })
    }
}

impl<const N: usize> Numbers<N> {
    /// Returns the spelling of each number.
    #[must_use]
    pub fn texts(&self) -> Vec<&str> {
        self.text.split_whitespace().collect()
    }
}

/// The table entries that texels use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Indices {
    /// Any entries, including the first and the last if there are enough texels.
    Any,
    /// Only entries below this number.
    Below(u32),
    /// Only entries whose two-byte index has two different bytes.
    BytesDiffer,
    /// These entries, repeated cyclically, starting with the top row.
    List(Vec<u32>),
}

/// The description of a file to write.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// The format of the file.
    pub format: Format,
    /// Width and height.
    pub size: Size,
    /// The painted scene.
    pub scene: Scene,
    /// The seed of the pseudo-random numbers.
    pub seed: u32,
    /// The scales (2.4).
    pub scale: Numbers<6>,
    /// The biases (2.4).
    pub bias: Numbers<6>,
    /// The color matrix (2.6), in file order.
    pub matrix: Numbers<16>,
    /// Number of entries in the lookup table (2.5).
    pub entries: u32,
    /// The table entries that texels use.
    pub indices: Indices,
    /// The compression of the planes (2.9); ignored for uncompressed formats.
    pub compression: Compression,
    /// The first byte of the payload, if it is fixed.
    pub first_byte: Option<u8>,
    /// The spelling of the header.
    pub spelling: Spelling,
}

impl Recipe {
    /// Returns the recipe of a default file: noise, with scales and biases that keep most colors between 0 and 255.
    ///
    /// # Panics
    /// Panics only if a constant is not a valid number, which would be a bug.
    #[must_use]
    pub fn default_for(format: Format, size: Size) -> Recipe {
        let numbers = "the constants are valid numbers";
        Recipe {
            format,
            size,
            scene: Scene::Noise,
            seed: 1,
            scale: "0.5 0.25 0.5 0.25 0.5 0.75".parse().expect(numbers),
            bias: "128 100 140 120 130 3".parse().expect(numbers),
            // In column-major order. All nine factors differ. There is no translation, because its position is an open question.
            matrix: "0.875 0.75 0.625 0 0.5 -0.25 0.125 0 -0.0625 -0.1875 0.375 0 0 0 0 1"
                .parse()
                .expect(numbers),
            entries: 7,
            indices: Indices::Any,
            compression: Compression::default_for(format),
            first_byte: None,
            spelling: Spelling::default(),
        }
    }

    /// Checks that this recipe can be written.
    ///
    /// # Errors
    /// Returns the reason why the recipe cannot be written.
    pub fn check(&self) -> Result<()> {
        fn invalid(reason: impl Into<Cow<'static, str>>) -> Result<()> {
            Err(Error::InvalidRecipe(reason.into()))
        }
        if self.format.coding().is_some() {
            self.compression.check(self.size)?;
            if self.first_byte.is_some() {
                return invalid(
                    "a compressed format cannot have `first_byte`, because the payload begins with a stream",
                );
            }
        }
        if self.format.has_table() && !(1..=1 << 20).contains(&self.entries) {
            return invalid(format!(
                "expected 1 to {} table entries, found {}",
                1 << 20,
                self.entries
            ));
        }
        match &self.indices {
            Indices::Below(0) => return invalid("an index must not be negative"),
            Indices::BytesDiffer if self.entries < 2 => {
                return invalid(
                    "expected at least 2 entries, because the two bytes of index 0 are equal",
                );
            }
            Indices::List(list) if list.is_empty() => return invalid("no indices listed"),
            Indices::List(list) if list.iter().any(|&index| index >= self.entries) => {
                return invalid("an index is past the last entry");
            }
            _ => {}
        }
        if ![1, 4, 16].contains(&self.spelling.matrix_line)
            || !(1..=1000).contains(&self.spelling.gap)
            || self.spelling.leading_zeros > 1000
        {
            return invalid(
                "a matrix line must have 1, 4 or 16 numbers, a gap must have 1 to 1000 spaces, and a number at most 1000 leading zeros",
            );
        }
        if self.size.texels() > 1 << 26 {
            return invalid(format!(
                "{} texels exceed the limit for generated images",
                self.size.texels()
            ));
        }
        Ok(())
    }
}
