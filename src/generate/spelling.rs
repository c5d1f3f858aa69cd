//! Every legal way to write the same header, and two that the text leaves open.

use std::str::FromStr;

/// A line of the header, named by the last thing on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Line {
    /// 2.1
    Version,
    /// 2.2
    Format,
    /// 2.3, where width has a line of its own
    Width,
    /// 2.3
    Height,
    /// 2.4, where the scales have a line of their own
    Scale,
    /// 2.4
    Bias,
    /// 2.5
    Count,
    /// 2.6
    Matrix,
    /// 2.9.1
    Parameter,
    /// 2.9.2
    Transforms,
    /// 2.9.3, the first half
    MotionX,
    /// 2.9.3, the second half
    MotionY,
    /// 2.9.4
    Order,
    /// 2.9.5
    References,
    /// 2.9.6
    Sizes,
    /// 2.9.7
    SideSizes,
}

impl Line {
    /// All of them, in file order.
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

    /// What they are called.
    const NAMES: [&str; 16] = [
        "version",
        "format",
        "width",
        "height",
        "scale",
        "bias",
        "count",
        "matrix",
        "parameter",
        "transforms",
        "motion-x",
        "motion-y",
        "order",
        "references",
        "sizes",
        "side-sizes",
    ];
}

impl Line {
    /// As it is written in cases.
    #[must_use]
    pub fn name(self) -> &'static str {
        Line::NAMES[self as usize]
    }
}

impl FromStr for Line {
    type Err = String;

    fn from_str(name: &str) -> Result<Line, String> {
        let position = Line::NAMES.iter().position(|&known| known == name);
        position.map(|i| Line::ALL[i]).ok_or_else(|| {
            format!(
                "unknown header line {name:?}; lines are {}",
                Line::NAMES.join(", ")
            )
        })
    }
}

/// How the number of table entries is written (ruling `lut-count`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Count {
    /// `256 N_LUT_ENTRIES`
    #[default]
    NumberWord,
    /// `256`
    Number,
    /// `nentries 256`
    WordNumber,
}

impl Count {
    /// The three, in the order in which a decoder is asked for them.
    pub const ALL: [Count; 3] = [Count::NumberWord, Count::Number, Count::WordNumber];

    /// As it is written in cases and reports.
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
    type Err = String;

    fn from_str(name: &str) -> Result<Count, String> {
        Count::ALL
            .into_iter()
            .find(|count| count.name() == name)
            .ok_or_else(|| format!("unknown spelling of the count {name:?}"))
    }
}

/// How the lists of 2.9 are split into lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Lists {
    /// Each on its own, motion on two (ruling `list-layout`).
    #[default]
    Lines,
    /// Motion on one line too (ruling `list-lines`, as for all that follow).
    MotionOnOneLine,
    /// All numbers on one line.
    OneLine,
    /// Every number on its own.
    NumberPerLine,
}

impl FromStr for Lists {
    type Err = String;

    fn from_str(name: &str) -> Result<Lists, String> {
        Ok(match name {
            "lines" => Lists::Lines,
            "motion-on-one-line" => Lists::MotionOnOneLine,
            "one-line" => Lists::OneLine,
            "number-per-line" => Lists::NumberPerLine,
            _ => return Err(format!("unknown layout of lists {name:?}")),
        })
    }
}

/// The spelling of one file. The default is the one that every known reader accepts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Spelling {
    /// Lines that have a space before their line feed (clauses 2.0/2, 2.4/7).
    pub space_before_newline: Vec<Line>,
    /// Width and height on two lines (clause 2.3/2).
    pub size_on_two_lines: bool,
    /// Scales and biases on two lines (clause 2.4/6).
    pub scale_bias_on_two_lines: bool,
    /// Spaces between two numbers.
    pub gap: usize,
    /// The number of table entries (ruling `lut-count`).
    pub count: Count,
    /// A line feed between table and indices (ruling `lut-newline`).
    pub newline_after_table: bool,
    /// Matrix elements on a line: 16, or 4 or 1 by ruling `lum-layout`.
    pub matrix_line: usize,
    /// The lists of 2.9.
    pub lists: Lists,
}

impl Default for Spelling {
    fn default() -> Spelling {
        Spelling {
            space_before_newline: Vec::new(),
            size_on_two_lines: true,
            scale_bias_on_two_lines: true,
            gap: 1,
            count: Count::NumberWord,
            newline_after_table: false,
            matrix_line: 16,
            lists: Lists::Lines,
        }
    }
}
