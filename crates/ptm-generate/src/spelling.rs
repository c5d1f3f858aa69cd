//! Spellings of a header: all legal spellings, including those that the text does not specify.

use std::str::FromStr;

use crate::error::{Error, Result};

/// A line of the header, named after the last item on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Line {
    /// The version (2.1).
    Version,
    /// The format (2.2).
    Format,
    /// The width, if it is on its own line (2.3).
    Width,
    /// The height, or width and height (2.3).
    Height,
    /// The scales, if they are on their own line (2.4).
    Scale,
    /// The biases, or scales and biases (2.4).
    Bias,
    /// The number of table entries (2.5).
    Count,
    /// The color matrix (2.6).
    Matrix,
    /// The compression parameter (2.9.1).
    Parameter,
    /// The transforms (2.9.2).
    Transforms,
    /// The horizontal motion (2.9.3).
    MotionX,
    /// The vertical motion (2.9.3).
    MotionY,
    /// The ranks of the planes (2.9.4).
    Order,
    /// The references (2.9.5).
    References,
    /// The sizes of the streams (2.9.6).
    Sizes,
    /// The sizes of the side information (2.9.7).
    SideSizes,
}

impl Line {
    /// The last lines of sections, where 2.0/2 allows a space.
    pub const SECTION_ENDS: [Line; 6] = [
        Line::Version,
        Line::Format,
        Line::Height,
        Line::Scale,
        Line::Bias,
        Line::Matrix,
    ];

    /// All lines, in file order.
    pub const ALL: [Line; 16] = [
        Line::Version,
        Line::Format,
        Line::Width,
        Line::Height,
        Line::Scale,
        Line::Bias,
        Line::Count,
        Line::Matrix,
        Line::Parameter,
        Line::Transforms,
        Line::MotionX,
        Line::MotionY,
        Line::Order,
        Line::References,
        Line::Sizes,
        Line::SideSizes,
    ];
}

/// The spelling of the number of table entries (ruling `lut-count`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Count {
    /// The number, then a word: `256 N_LUT_ENTRIES`.
    #[default]
    NumberWord,
    /// The number alone: `256`.
    Number,
    /// A word, then the number: `nentries 256`.
    WordNumber,
}

impl Count {
    /// The three spellings, in the order in which `ptm-conform check` tries them.
    pub const ALL: [Count; 3] = [Count::NumberWord, Count::Number, Count::WordNumber];

    /// Returns the name used in cases and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Count::NumberWord => "256 N_LUT_ENTRIES",
            Count::Number => "256",
            Count::WordNumber => "nentries 256",
        }
    }
}

impl FromStr for Count {
    type Err = Error;

    fn from_str(name: &str) -> Result<Count> {
        Count::ALL
            .into_iter()
            .find(|count| count.name() == name)
            .ok_or_else(|| Error::unknown("count spelling", name))
    }
}

/// The line breaks in the lists of 2.9.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Lists {
    /// Each list on its own line, and motion vectors on two lines (ruling `list-layout`).
    #[default]
    Lines,
    /// Each list on its own line, with all motion vectors on one line (ruling `list-lines`).
    MotionOnOneLine,
    /// All numbers on one line (ruling `list-lines`).
    OneLine,
    /// Every number on its own line (ruling `list-lines`).
    NumberPerLine,
}

/// The spelling of one file. Every known reader accepts the default.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Spelling {
    /// Lines that have a space before their line feed (clauses 2.0/2, 2.4/7).
    pub space_before_newline: Vec<Line>,
    /// True if width and height are on two lines (clause 2.3/2).
    pub size_on_two_lines: bool,
    /// True if scales and biases are on two lines (clause 2.4/6).
    pub scale_bias_on_two_lines: bool,
    /// Number of spaces between two numbers.
    pub gap: usize,
    /// Number of zeros before the digits of each scale and bias. They do not change the value.
    pub leading_zeros: usize,
    /// The spelling of the number of table entries (ruling `lut-count`).
    pub count: Count,
    /// True to write a line feed between the table and the indices (ruling `lut-newline`).
    pub newline_after_table: bool,
    /// Number of matrix elements per line: 16, 4 or 1 (ruling `lum-layout`).
    pub matrix_line: usize,
    /// The line breaks in the lists of 2.9.
    pub lists: Lists,
}

impl Default for Spelling {
    fn default() -> Spelling {
        Spelling {
            space_before_newline: Vec::new(),
            size_on_two_lines: true,
            scale_bias_on_two_lines: true,
            gap: 1,
            leading_zeros: 0,
            count: Count::NumberWord,
            newline_after_table: false,
            matrix_line: 16,
            lists: Lists::Lines,
        }
    }
}
