//! Types of the format, with a glossary.
//!
//! - **texel**: one position in the map.
//! - **plane**: one byte for every texel. The planes of a map are in the order of the specification.
//! - **coefficient**: one of the six values a0…a5 of a polynomial, *raw* as stored or *final* after scale and bias (2.4).
//! - **channel**: one component of every texel. Its values form a plane. A texel of an RGB map has 18 channels.
//! - **entry**, **index**: a row of the lookup table (2.5), and its number (2.8).
//! - **`lu`, `lv`**: the light direction, projected onto the plane of the texture (1.0).
//!
//! In this crate, rows are counted from the top, and columns from the left. Files store the bottom row first.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

pub use crate::codec::Coding;
use crate::error::{self, Error, Kind};

/// One of the nine formats of §2.2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Format {
    /// `PTM_FORMAT_RGB`: one polynomial each for red, green and blue.
    Rgb,
    /// `PTM_FORMAT_LUM`: a polynomial for Y, then Cr and Cb.
    Lum,
    /// `PTM_FORMAT_LRGB`: a polynomial for luminance, then a color.
    Lrgb,
    /// `PTM_FORMAT_PTM_LUT`: polynomials in a table, and a color for each texel.
    PtmLut,
    /// `PTM_FORMAT_PTM_C_LUT`: polynomials and colors in a table.
    PtmCLut,
    /// `PTM_FORMAT_JPEG_RGB`: the 18 planes of RGB, each a JPEG stream.
    JpegRgb,
    /// `PTM_FORMAT_JPEG_LRGB`: the 9 planes of LRGB, each a JPEG stream.
    JpegLrgb,
    /// `PTM_FORMAT_JPEGLS_RGB`: the 18 planes of RGB, each a JPEG-LS stream.
    JpeglsRgb,
    /// `PTM_FORMAT_JPEGLS_LRGB`: the 9 planes of LRGB, each a JPEG-LS stream.
    JpeglsLrgb,
}

impl Format {
    /// All nine formats, in the order of the specification.
    pub const ALL: [Format; 9] = [
        Format::Rgb,
        Format::Lum,
        Format::Lrgb,
        Format::PtmLut,
        Format::PtmCLut,
        Format::JpegRgb,
        Format::JpegLrgb,
        Format::JpeglsRgb,
        Format::JpeglsLrgb,
    ];

    /// Returns the name of the format in a file (clause 2.2/1), the shape of a texel, and the storage of the planes.
    const fn definition(self) -> (&'static str, Shape<()>, Storage) {
        use Coding::{Jpeg, JpegLs};
        use Storage::{ColorTable, Streams, Table, Texels};
        match self {
            Format::Rgb => ("PTM_FORMAT_RGB", Shape::Rgb, Texels),
            Format::Lum => ("PTM_FORMAT_LUM", Shape::Lum(()), Texels),
            Format::Lrgb => ("PTM_FORMAT_LRGB", Shape::Lrgb, Texels),
            Format::PtmLut => ("PTM_FORMAT_PTM_LUT", Shape::Lrgb, Table),
            Format::PtmCLut => ("PTM_FORMAT_PTM_C_LUT", Shape::Lrgb, ColorTable),
            Format::JpegRgb => ("PTM_FORMAT_JPEG_RGB", Shape::Rgb, Streams(Jpeg)),
            Format::JpegLrgb => ("PTM_FORMAT_JPEG_LRGB", Shape::Lrgb, Streams(Jpeg)),
            Format::JpeglsRgb => ("PTM_FORMAT_JPEGLS_RGB", Shape::Rgb, Streams(JpegLs)),
            Format::JpeglsLrgb => ("PTM_FORMAT_JPEGLS_LRGB", Shape::Lrgb, Streams(JpegLs)),
        }
    }

    /// Returns the name of the format in a file (clause 2.2/1).
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.definition().0
    }

    /// Returns the name without `PTM_FORMAT_`, such as `RGB`, `PTM_LUT` or `JPEGLS_LRGB`.
    #[must_use]
    pub fn short_name(self) -> &'static str {
        &self.name()["PTM_FORMAT_".len()..]
    }

    /// Returns the shape of a texel, without the values of the color matrix.
    #[must_use]
    pub const fn shape(self) -> Shape<()> {
        self.definition().1
    }

    /// Returns the storage of the planes.
    #[must_use]
    pub const fn storage(self) -> Storage {
        self.definition().2
    }

    /// Returns the coding standard of the streams of a compressed format (2.9), or `None` if the format has no streams.
    #[must_use]
    pub const fn coding(self) -> Option<Coding> {
        match self.storage() {
            Storage::Streams(coding) => Some(coding),
            _ => None,
        }
    }

    /// Returns the uncompressed format with the same shape.
    #[must_use]
    pub fn uncompressed(self) -> Format {
        let is_plain =
            |format: &Format| format.shape() == self.shape() && format.storage() == Storage::Texels;
        let plain = Format::ALL.into_iter().find(is_plain);
        plain.expect("every shape has a format with blocks")
    }

    /// Returns the clause that defines the layout of the values.
    #[must_use]
    pub const fn layout_clause(self) -> &'static str {
        match (self.storage(), self.shape()) {
            (Storage::Texels, Shape::Rgb) => "2.7.1/1",
            (Storage::Texels, Shape::Lum(())) => "2.7.2/1",
            (Storage::Texels, Shape::Lrgb) => "2.7.3/1",
            (Storage::Table, _) => "2.8.1/1",
            (Storage::ColorTable, _) => "2.8.2/1",
            (Storage::Streams(_), _) => "2.9/1",
        }
    }

    /// Returns true if the format has a lookup table (2.5) and indices (2.8).
    #[must_use]
    pub const fn has_table(self) -> bool {
        matches!(self.storage(), Storage::Table | Storage::ColorTable)
    }

    /// Returns the number of bytes in a table entry: 6, or 9 if the table contains colors.
    #[must_use]
    pub const fn entry_size(self) -> usize {
        match self.storage() {
            Storage::ColorTable => 9,
            _ => 6,
        }
    }

    /// Returns the number of planes of a map in this format: 18, 9 or 8.
    #[must_use]
    pub const fn channels(self) -> usize {
        self.shape().channels()
    }
}

/// The storage of the planes in a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// Blocks of bytes (2.7).
    Texels,
    /// Indices of table entries with six coefficients, then a block of colors (2.8.1).
    Table,
    /// Indices of table entries with six coefficients and a color (2.8.2).
    ColorTable,
    /// A compressed stream for each plane (2.9).
    Streams(Coding),
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Format {
    type Err = ParseError;

    /// Parses a format name from §2.2, with or without the prefix `PTM_FORMAT_`.
    fn from_str(name: &str) -> Result<Format, ParseError> {
        Format::ALL
            .into_iter()
            .find(|format| format.name() == name || format.short_name() == name)
            .ok_or_else(|| ParseError::UnknownFormat(name.to_owned()))
    }
}

/// The reason why a text, such as an argument of a command, is not the name of a [`Format`] or not a [`Size`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ParseError {
    /// The text is not the name of a format.
    UnknownFormat(String),
    /// The text is not two positive numbers with an `x` between them.
    InvalidSize(String),
}

impl fmt::Display for ParseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ParseError::UnknownFormat(name) => write!(f, "unknown format {name:?}"),
            ParseError::InvalidSize(text) => {
                write!(f, "expected a size such as 8x5, found {text:?}")
            }
        }
    }
}

impl std::error::Error for ParseError {}

/// A program prints errors as texts.
impl From<ParseError> for String {
    fn from(error: ParseError) -> String {
        error.to_string()
    }
}

/// Width and height in texels, both at least 1 (2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Size {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
}

impl Size {
    /// Returns the number of texels, or `usize::MAX` on overflow.
    #[must_use]
    pub fn texels(self) -> usize {
        (self.width as usize).saturating_mul(self.height as usize)
    }

    /// Returns the total number of bytes if each texel takes `bytes_per_texel` bytes, or `u64::MAX` on overflow.
    #[must_use]
    pub fn bytes(self, bytes_per_texel: usize) -> u64 {
        (u64::from(self.width) * u64::from(self.height)).saturating_mul(bytes_per_texel as u64)
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

impl FromStr for Size {
    type Err = ParseError;

    /// Parses `WIDTHxHEIGHT`. Both numbers must be at least 1.
    fn from_str(text: &str) -> Result<Size, ParseError> {
        let syntax_error = || ParseError::InvalidSize(text.to_owned());
        let (width, height) = text.split_once('x').ok_or_else(syntax_error)?;
        match (width.parse(), height.parse()) {
            (Ok(width), Ok(height)) if width > 0 && height > 0 => Ok(Size { width, height }),
            _ => Err(syntax_error()),
        }
    }
}

/// The six scales and six biases of §2.4. Element i belongs to coefficient a*i* of every polynomial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleBias {
    /// Scales: finite real numbers, possibly zero or negative.
    pub scale: [f64; 6],
    /// Biases: integers, possibly negative.
    pub bias: [f64; 6],
}

/// The sixteen numbers of §2.6, as stored.
///
/// The order is column-major: the value in `row` and `column` is element `4 * column + row`. Elements 12–14 are a translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorMatrix(pub [f64; 16]);

/// The header of a map (2.1–2.4). Every `Header` is legal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// Format (2.2).
    pub format: Format,
    /// Width and height (2.3).
    pub size: Size,
    /// Scales and biases, which convert raw coefficients to final coefficients (2.4).
    pub scale_bias: ScaleBias,
}

/// The shape of a texel. The nine formats have three shapes. After decoding, only the shape matters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape<Matrix = ColorMatrix> {
    /// 18 channels: a0…a5 of red, green and blue.
    Rgb,
    /// 9 channels: a0…a5 of luminance, then R, G, B.
    Lrgb,
    /// 8 channels: a0…a5 of Y, then Cr and Cb, with the matrix that converts Y, Cr and Cb to a color.
    Lum(Matrix),
}

impl<Matrix> Shape<Matrix> {
    /// Returns the number of channels in a texel.
    #[must_use]
    pub const fn channels(&self) -> usize {
        match self {
            Shape::Rgb => 18,
            Shape::Lrgb => 9,
            Shape::Lum(_) => 8,
        }
    }

    /// Returns the number of coefficients in a texel. The first channels of a texel are its coefficients.
    #[must_use]
    pub const fn coefficients(&self) -> usize {
        match self {
            Shape::Rgb => 18,
            Shape::Lrgb | Shape::Lum(_) => 6,
        }
    }
}

impl Shape<()> {
    /// Returns the shape with its color matrix. Calls `read` only if the shape has a matrix.
    ///
    /// # Errors
    /// Returns the error of `read`.
    pub fn with_matrix<E>(self, read: impl FnOnce() -> Result<ColorMatrix, E>) -> Result<Shape, E> {
        Ok(match self {
            Shape::Rgb => Shape::Rgb,
            Shape::Lrgb => Shape::Lrgb,
            Shape::Lum(()) => Shape::Lum(read()?),
        })
    }
}

/// Returns the name of a channel in a texel with `channels` channels, such as `a3 of green`, `a0`, `R` or `Cb`.
#[must_use]
pub fn channel_name(channels: usize, channel: usize) -> String {
    match (channels, channel) {
        (18, _) => format!(
            "a{} of {}",
            channel % 6,
            ["red", "green", "blue"][channel / 6 % 3]
        ),
        (_, 0..6) if channels > 3 => format!("a{channel}"),
        (9, _) => ["R", "G", "B"][channel % 3].to_owned(),
        (8, _) => ["Cr", "Cb"][channel % 2].to_owned(),
        _ => ["red", "green", "blue"][channel % 3].to_owned(),
    }
}

/// Stored values of a map, after table lookup, decompression, prediction and correction.
#[derive(Clone, Debug, PartialEq)]
pub struct Planes {
    /// Width and height.
    pub size: Size,
    /// Shape of each texel.
    pub shape: Shape,
    /// `height * width * channels` bytes, texel by texel, top row first. The channels of a texel are adjacent.
    pub samples: Vec<u8>,
}

impl Planes {
    /// Returns the channels of every texel, top row first.
    pub fn texels(&self) -> impl Iterator<Item = &[u8]> {
        self.samples.chunks_exact(self.shape.channels())
    }
}

/// A decoded file.
#[derive(Clone, Debug, PartialEq)]
pub struct Ptm {
    /// Header of the file.
    pub header: Header,
    /// Stored values, top row first.
    pub planes: Planes,
}

/// Limits on the resources that a file may need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Maximum number of bytes for the planes, 1 GiB by default.
    pub memory: usize,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { memory: 1 << 30 }
    }
}

impl Limits {
    /// Checks that `needed` bytes are within the limit. `at` is the offset in the file that an error reports.
    pub(crate) fn check(&self, needed: u64, at: usize) -> error::Result<()> {
        if needed > self.memory as u64 {
            let limit = self.memory;
            return Err(Error::new("2.3/3", at, Kind::TooLarge { needed, limit }));
        }
        Ok(())
    }
}

/// A part of a file, with its meaning.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Clause that requires the field.
    pub clause: &'static str,
    /// Description of the field, as used in error messages: `a width of at least 1`, `a scale`.
    pub name: &'static str,
    /// Byte range of the field in the file.
    pub range: Range<usize>,
}
