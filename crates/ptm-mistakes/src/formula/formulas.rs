//! The formulas of the specification (`spec-cases/formulas.yaml`), with the names that each formula may use.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

use super::expression::{Expression, Scope, parse};
use crate::error::{Error, Result};
use ptm::{Format, Storage};
use ptm_suite::kit::yaml;

/// A step of decoding that the specification states or implies as arithmetic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(missing_docs)] // see `formulas.yaml`
pub enum Formula {
    LightU,
    LightV,
    Polynomial,
    IntensityChannel,
    ColorChannel,
    Color,
    MatrixRow,
    Rendering,
    ColorPlace,
    FloatPlace,
    FloatByte,
    FinalCoefficient,
    FinalColor,
    ByteNumber,
    StoredValue,
    ValueChannel,
    StoredRow,
    StoredColumn,
    StoredTexel,
    TexelStart,
    RgbSample,
    LumSample,
    LrgbCoefficient,
    LrgbColor,
    IndexSize,
    IndexByte,
    Index,
    TableSample,
    TableColor,
    BlockLength,
    GroupSize,
    GroupStart,
    GroupEnd,
    RgbPlane,
    LrgbPlane,
    Transform,
    Inverted,
    Displaced,
    VectorX,
    VectorY,
    Reference,
    Predictor,
    Inversion,
    DisplacedX,
    DisplacedY,
    FirstColumn,
    SecondColumn,
    FirstRow,
    SecondRow,
    MeanOfTwo,
    MeanOfFour,
    EdgeX,
    EdgeY,
    StreamSample,
    Plane,
    RecordCount,
    RecordByte,
    RecordPosition,
    RecordPlace,
    Corrected,
}

/// Stages of decoding, in order. A mistake in one stage affects that stage and all later stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Reading the bytes.
    File,
    /// Converting bytes to planes.
    Decoding,
    /// Finished planes.
    Planes,
    /// Final coefficients.
    Coefficients,
    /// Colors under a light.
    Color,
}

impl Formula {
    /// All formulas with their names, in order from the image back to the bytes.
    pub const ALL: [(Formula, &'static str); 60] = [
        (Formula::LightU, "light u"),
        (Formula::LightV, "light v"),
        (Formula::Polynomial, "polynomial"),
        (Formula::IntensityChannel, "channel of a coefficient"),
        (Formula::ColorChannel, "channel of a color"),
        (Formula::Color, "color"),
        (Formula::MatrixRow, "matrix row"),
        (Formula::Rendering, "shown value"),
        (Formula::ColorPlace, "color place"),
        (Formula::FloatPlace, "float place"),
        (Formula::FloatByte, "float byte"),
        (Formula::FinalCoefficient, "final coefficient"),
        (Formula::FinalColor, "final color"),
        (Formula::ByteNumber, "number of a byte"),
        (Formula::StoredValue, "stored value"),
        (Formula::ValueChannel, "channel of a value"),
        (Formula::StoredRow, "stored row"),
        (Formula::StoredColumn, "stored column"),
        (Formula::StoredTexel, "stored texel"),
        (Formula::TexelStart, "start of the texels"),
        (Formula::RgbSample, "RGB sample"),
        (Formula::LumSample, "LUM sample"),
        (Formula::LrgbCoefficient, "LRGB coefficient"),
        (Formula::LrgbColor, "LRGB color"),
        (Formula::IndexSize, "bytes of an index"),
        (Formula::IndexByte, "index byte"),
        (Formula::Index, "index"),
        (Formula::TableSample, "table sample"),
        (Formula::TableColor, "PTM_LUT color"),
        (Formula::BlockLength, "length of a block"),
        (Formula::GroupSize, "size of a group"),
        (Formula::GroupStart, "start of a group"),
        (Formula::GroupEnd, "end of a group"),
        (Formula::RgbPlane, "RGB plane"),
        (Formula::LrgbPlane, "LRGB plane"),
        (Formula::Transform, "transform"),
        (Formula::Inverted, "inversion bit"),
        (Formula::Displaced, "motion bit"),
        (Formula::VectorX, "vector x"),
        (Formula::VectorY, "vector y"),
        (Formula::Reference, "reference"),
        (Formula::Predictor, "predictor"),
        (Formula::Inversion, "inverted value"),
        (Formula::DisplacedX, "displaced x"),
        (Formula::DisplacedY, "displaced y"),
        (Formula::FirstColumn, "first column of a mean"),
        (Formula::SecondColumn, "second column of a mean"),
        (Formula::FirstRow, "first row of a mean"),
        (Formula::SecondRow, "second row of a mean"),
        (Formula::MeanOfTwo, "mean of two"),
        (Formula::MeanOfFour, "mean of four"),
        (Formula::EdgeX, "column at the edge"),
        (Formula::EdgeY, "row at the edge"),
        (Formula::StreamSample, "stream sample"),
        (Formula::Plane, "plane"),
        (Formula::RecordCount, "number of records"),
        (Formula::RecordByte, "record byte"),
        (Formula::RecordPosition, "record position"),
        (Formula::RecordPlace, "record place"),
        (Formula::Corrected, "corrected value"),
    ];

    /// Returns the name used in `formulas.yaml` and in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        Formula::ALL[self as usize].1
    }

    /// Returns the names that the formula and its edits may use.
    #[must_use]
    pub fn scope(self) -> Scope {
        self.stated().scope
    }

    /// Returns the stage of decoding whose result the formula computes.
    #[must_use]
    pub fn stage(self) -> Stage {
        match self {
            _ if self >= Formula::StoredRow => Stage::Decoding,
            Formula::StoredValue | Formula::ValueChannel => Stage::Planes,
            Formula::FloatPlace
            | Formula::FloatByte
            | Formula::FinalCoefficient
            | Formula::FinalColor
            | Formula::ByteNumber => Stage::Coefficients,
            _ => Stage::Color,
        }
    }

    /// Returns true if decoding a file in this format may use the formula.
    #[must_use]
    pub fn is_used_by(self, format: Format) -> bool {
        let channels = format.channels();
        match self {
            Formula::Color | Formula::ColorChannel => channels == 9,
            Formula::MatrixRow | Formula::LumSample => format == Format::Lum,
            Formula::FinalColor => channels < 18,
            Formula::RgbSample => format == Format::Rgb,
            // LUM has a single block.
            Formula::BlockLength => format.coding().is_none() && format != Format::Lum,
            Formula::GroupSize | Formula::GroupStart | Formula::GroupEnd => {
                format.coding().is_none()
            }
            Formula::TexelStart => format.storage() == Storage::Texels,
            Formula::LrgbCoefficient | Formula::LrgbColor => format == Format::Lrgb,
            Formula::TableColor => format == Format::PtmLut,
            Formula::RgbPlane => format.coding().is_some() && channels == 18,
            Formula::LrgbPlane => format.coding().is_some() && channels == 9,
            _ if self < Formula::RgbSample => true,
            _ if self < Formula::RgbPlane => format.has_table(),
            _ => format.coding().is_some(),
        }
    }

    /// Returns true if the formula only affects view coef.
    #[must_use]
    pub fn is_only_for_final_values(self) -> bool {
        matches!(self, Formula::FloatPlace | Formula::FloatByte)
    }

    /// Returns true if an edit of the formula may address bytes outside the data, in which case the decoder refuses the file.
    pub(crate) fn may_refuse(self) -> bool {
        let addresses = [
            Formula::StoredTexel..=Formula::Reference,
            Formula::DisplacedX..=Formula::SecondRow,
            Formula::EdgeX..=Formula::EdgeY,
            Formula::RecordCount..=Formula::RecordPlace,
        ];
        addresses.iter().any(|range| range.contains(&self))
    }

    /// Returns the formula with this name, if any.
    pub(crate) fn from_name(name: &str) -> Option<Formula> {
        let row = Formula::ALL.iter().find(|row| row.1 == name);
        row.map(|row| row.0)
    }

    /// Returns the formula as the specification states it.
    #[must_use]
    pub fn stated(self) -> &'static StatedFormula {
        &STATED_FORMULAS[self as usize]
    }
}

/// A formula as stated in `formulas.yaml`.
#[derive(Debug)]
pub struct StatedFormula {
    /// Clause that states or implies the formula, or an empty text if the protocol states it.
    pub clause: &'static str,
    /// Description of the result, as a noun phrase.
    pub result: &'static str,
    /// Names that the formula and its edits may use.
    pub scope: Scope,
    /// Expression in this scope.
    pub expression: Expression,
    /// Explanations of variables: the index of the variable, and a text that completes "it is".
    pub meanings: Vec<(usize, &'static str)>,
    /// Field of `Reading` that makes the same decision, if there is one.
    pub step: Option<&'static str>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FormulaRecord {
    name: String,
    clause: String,
    computes: String,
    formula: String,
    variables: String,
    #[serde(default)]
    lists: String,
    #[serde(default, rename = "where")]
    meanings: BTreeMap<String, String>,
    step: Option<String>,
}

/// All formulas, in the order of [`Formula::ALL`].
static STATED_FORMULAS: LazyLock<Vec<StatedFormula>> = LazyLock::new(|| {
    let text = ptm_spec_cases::FORMULAS;
    read(text).unwrap_or_else(|error| unreachable!("invalid embedded formulas.yaml: {error}"))
});

/// Parses the formulas. Leaks their text, because references to it must be `'static`.
fn read(text: &str) -> Result<Vec<StatedFormula>> {
    let records = yaml::records::<FormulaRecord>(text)?;
    let all = Formula::ALL.iter().map(|row| row.1);
    if !records.iter().map(|(_, record)| &*record.name).eq(all) {
        let message = "the names must equal those of Formula::ALL, in the same order";
        return Err(Error::Formula(message.to_owned()));
    }
    let names = |text: String| -> &'static [&'static str] {
        let text: &'static str = text.leak();
        text.split_whitespace().collect::<Vec<_>>().leak()
    };
    let stated = |(line, record): (usize, FormulaRecord)| {
        let scope = Scope {
            variables: names(record.variables),
            lists: names(record.lists),
        };
        let expression = parse(&record.formula, scope);
        let index = |name: &str| scope.variables.iter().position(|known| *known == name);
        let meaning = |(name, text): (String, String)| {
            let unknown = || Error::Record {
                line,
                message: format!("unknown variable {name}"),
            };
            Ok((index(&name).ok_or_else(unknown)?, &*text.leak()))
        };
        let meanings: Result<Vec<_>> = record.meanings.into_iter().map(meaning).collect();
        Ok(StatedFormula {
            clause: record.clause.leak(),
            result: record.computes.leak(),
            scope,
            expression: expression.map_err(|error| Error::Record {
                line,
                message: error.to_string(),
            })?,
            meanings: meanings?,
            step: record.step.map(|step| &*step.leak()),
        })
    };
    records.into_iter().map(stated).collect()
}
