//! The formulas of the specification: `spec-cases/formulas.yaml`, and the names that each of them may use.

use std::sync::LazyLock;

use serde::Deserialize;

use super::expression::{Expression, Scope, parse};
use crate::kit::yaml;
use crate::ptm::Format;

/// A step from the bytes of a file to an image that the specification states, or implies, as arithmetic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(missing_docs)] // `formulas.yaml` describes each of them
pub enum Formula {
    LightU,
    LightV,
    Polynomial,
    Color,
    MatrixRow,
    Shown,
    FinalCoefficient,
    FinalColor,
    StoredValue,
    StoredRow,
    StoredColumn,
    RgbSample,
    LumSample,
    LrgbCoefficient,
    LrgbColor,
    IndexSize,
    IndexByte,
    Index,
    TableSample,
    TableColor,
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

/// The stages of decoding, in their order. A mistake at one stage shows there and at later stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// The bytes that are read.
    File,
    /// From bytes to planes.
    Decoding,
    /// The finished planes.
    Planes,
    /// Final coefficients.
    Coefficients,
    /// Colors under a light.
    Color,
}

const fn scope(variables: &'static [&'static str], lists: &'static [&'static str]) -> Scope {
    Scope { variables, lists }
}

const LIGHT: Scope = scope(&["u", "v"], &[]);
const FINAL: Scope = scope(&["raw", "i", "c"], &["scale", "bias"]);
const TEXEL: Scope = scope(&["x", "y", "width", "height"], &[]);
const OF_SAMPLES: &[&str] = &[
    "row", "x", "width", "height", "i", "c", "k", "entries", "size", "bytes",
];
const LUM_SAMPLE: Scope = scope(OF_SAMPLES.split_at(5).0, &[]);
const RGB_SAMPLE: Scope = scope(OF_SAMPLES.split_at(6).0, &[]);
const LRGB_SAMPLE: Scope = scope(OF_SAMPLES.split_at(7).0, &[]);
const TABLE_SAMPLE: Scope = scope(OF_SAMPLES, &[]);
const PLANE: Scope = scope(&["p", "planes", "reference", "rank"], LISTS);
const LISTS: &[&str] = &["transform", "motion", "references"];
const DISPLACEMENT: Scope = scope(&["x", "y", "mx", "my", "width", "height"], &[]);
const RECORD: Scope = scope(
    &[
        "position",
        "row",
        "column",
        "width",
        "height",
        "r",
        "value",
        "predicted",
    ],
    &[],
);

impl Formula {
    /// All formulas with their names and scopes, from the image back to the bytes.
    pub const ALL: [(Formula, &'static str, Scope); 43] = [
        (Formula::LightU, "light u", LIGHT),
        (Formula::LightV, "light v", LIGHT),
        (
            Formula::Polynomial,
            "polynomial",
            scope(&["a0", "a1", "a2", "a3", "a4", "a5", "u", "v"], &[]),
        ),
        (Formula::Color, "color", scope(&["L", "rgb"], &[])),
        (
            Formula::MatrixRow,
            "matrix row",
            scope(&["Y", "Cr", "Cb", "k"], &["m"]),
        ),
        (Formula::Shown, "shown value", scope(&["value"], &[])),
        (Formula::FinalCoefficient, "final coefficient", FINAL),
        (Formula::FinalColor, "final color", FINAL),
        (
            Formula::StoredValue,
            "stored value",
            scope(&["raw", "i", "c"], &[]),
        ),
        (Formula::StoredRow, "stored row", TEXEL),
        (Formula::StoredColumn, "stored column", TEXEL),
        (Formula::RgbSample, "RGB sample", RGB_SAMPLE),
        (Formula::LumSample, "LUM sample", LUM_SAMPLE),
        (Formula::LrgbCoefficient, "LRGB coefficient", LUM_SAMPLE),
        (Formula::LrgbColor, "LRGB color", LRGB_SAMPLE),
        (Formula::IndexSize, "bytes of an index", TABLE_SAMPLE),
        (Formula::IndexByte, "index byte", TABLE_SAMPLE),
        (
            Formula::Index,
            "index",
            scope(&["low", "high", "entries"], &[]),
        ),
        (
            Formula::TableSample,
            "table sample",
            scope(&["index", "i", "size", "entries"], &[]),
        ),
        (Formula::TableColor, "PTM_LUT color", TABLE_SAMPLE),
        (Formula::RgbPlane, "RGB plane", RGB_SAMPLE),
        (Formula::LrgbPlane, "LRGB plane", LUM_SAMPLE),
        (Formula::Transform, "transform", PLANE),
        (
            Formula::Inverted,
            "inversion bit",
            scope(&["transform"], &[]),
        ),
        (Formula::Displaced, "motion bit", scope(&["transform"], &[])),
        (Formula::VectorX, "vector x", PLANE),
        (Formula::VectorY, "vector y", PLANE),
        (Formula::Reference, "reference", PLANE),
        (
            Formula::Predictor,
            "predictor",
            scope(&["reference", "uncorrected", "coded", "previous"], &[]),
        ),
        (Formula::Inversion, "inverted value", scope(&["v"], &[])),
        (Formula::DisplacedX, "displaced x", DISPLACEMENT),
        (Formula::DisplacedY, "displaced y", DISPLACEMENT),
        (Formula::MeanOfTwo, "mean of two", scope(&["a", "b"], &[])),
        (
            Formula::MeanOfFour,
            "mean of four",
            scope(&["a", "b", "c", "d"], &[]),
        ),
        (Formula::EdgeX, "column at the edge", TEXEL),
        (Formula::EdgeY, "row at the edge", TEXEL),
        (
            Formula::StreamSample,
            "stream sample",
            scope(&["sample", "p", "predicted"], &[]),
        ),
        (
            Formula::Plane,
            "plane",
            scope(&["residual", "predictor", "inverted", "displaced"], &[]),
        ),
        (
            Formula::RecordCount,
            "number of records",
            scope(&["size", "parameter"], &[]),
        ),
        (
            Formula::RecordByte,
            "record byte",
            scope(&["r", "k", "count"], &[]),
        ),
        (
            Formula::RecordPosition,
            "record position",
            scope(&["p3", "p2", "p1", "p0", "v"], &[]),
        ),
        (Formula::RecordPlace, "record place", RECORD),
        (
            Formula::Corrected,
            "corrected value",
            scope(
                &["value", "plane", "residual", "position", "r", "predicted"],
                &[],
            ),
        ),
    ];

    /// Returns the name in `formulas.yaml` and in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.row().1
    }

    /// Returns the names that the formula may use.
    #[must_use]
    pub fn scope(self) -> Scope {
        self.row().2
    }

    fn row(self) -> &'static (Formula, &'static str, Scope) {
        let is_own = |row: &&(Formula, &str, Scope)| row.0 == self;
        let row = Formula::ALL.iter().find(is_own);
        row.expect("a test finds every formula in the list")
    }

    /// Returns the stage of decoding whose result the formula computes.
    #[must_use]
    pub fn stage(self) -> Stage {
        match self {
            _ if self >= Formula::StoredRow => Stage::Decoding,
            Formula::StoredValue => Stage::Planes,
            Formula::FinalCoefficient | Formula::FinalColor => Stage::Coefficients,
            _ => Stage::Color,
        }
    }

    /// Returns true if the values of some file of that format depend on the formula.
    #[must_use]
    pub fn is_used_by(self, format: Format) -> bool {
        let channels = format.channels();
        match self {
            Formula::Color => channels == 9,
            Formula::MatrixRow | Formula::LumSample => format == Format::Lum,
            Formula::FinalColor => channels < 18,
            Formula::RgbSample => format == Format::Rgb,
            Formula::LrgbCoefficient | Formula::LrgbColor => format == Format::Lrgb,
            Formula::TableColor => format == Format::PtmLut,
            Formula::RgbPlane => format.is_compressed() && channels == 18,
            Formula::LrgbPlane => format.is_compressed() && channels == 9,
            _ if self < Formula::RgbSample => true,
            _ if self < Formula::RgbPlane => format.has_table(),
            _ => format.is_compressed(),
        }
    }

    /// Returns true if an edit of the formula can lead outside the data, so that the file is refused.
    #[must_use]
    pub fn may_refuse(self) -> bool {
        let makes_values = [
            Formula::StoredRow,
            Formula::StoredColumn,
            Formula::Inversion,
            Formula::MeanOfTwo,
            Formula::MeanOfFour,
            Formula::Predictor,
            Formula::StreamSample,
            Formula::Plane,
            Formula::Corrected,
        ];
        self.stage() == Stage::Decoding && !makes_values.contains(&self)
    }

    /// Returns the formula of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Formula> {
        let row = Formula::ALL.iter().find(|row| row.1 == name);
        row.map(|row| row.0)
    }

    /// Returns the specification's clause and expression.
    #[must_use]
    pub fn stated(self) -> &'static Stated {
        let place = Formula::ALL.iter().position(|row| row.0 == self);
        &STATED[place.expect("a test finds every formula in the list")]
    }
}

/// A formula as `formulas.yaml` states it.
#[derive(Debug)]
pub struct Stated {
    /// The clause that states or implies it.
    pub clause: &'static str,
    /// The computed value, as a noun phrase.
    pub computes: &'static str,
    /// The expression, in the formula's scope.
    pub expression: Expression,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Record {
    name: String,
    clause: String,
    computes: String,
    formula: String,
}

/// All formulas in the order of [`Formula::ALL`].
static STATED: LazyLock<Vec<Stated>> = LazyLock::new(|| {
    let text = include_str!("../../spec-cases/formulas.yaml");
    read(text).unwrap_or_else(|error| unreachable!("formulas.yaml, which a test reads: {error}"))
});

fn read(text: &str) -> Result<Vec<Stated>, String> {
    let records = yaml::records::<Record>(text)?;
    let stated = |&(_, name, scope): &(Formula, &str, Scope)| {
        let (line, record) = records
            .iter()
            .find(|(_, record)| record.name == name)
            .ok_or_else(|| format!("formula {name:?} is missing"))?;
        let expression = parse(&record.formula, scope);
        Ok(Stated {
            clause: record.clause.clone().leak(),
            computes: record.computes.clone().leak(),
            expression: expression.map_err(|error| format!("line {line}: {error}"))?,
        })
    };
    let all = Formula::ALL
        .iter()
        .map(stated)
        .collect::<Result<Vec<_>, String>>()?;
    match records
        .iter()
        .find(|(_, record)| Formula::named(&record.name).is_none())
    {
        Some((line, record)) => Err(format!("line {line}: unknown formula {:?}", record.name)),
        None => Ok(all),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_formula_is_stated_and_listed_once() {
        let stated = read(include_str!("../../spec-cases/formulas.yaml")).unwrap();
        assert_eq!(stated.len(), Formula::ALL.len());
        for (place, &(formula, name, _)) in Formula::ALL.iter().enumerate() {
            assert_eq!(formula as usize, place, "{name}");
            assert_eq!(Formula::named(name), Some(formula));
        }
    }
}
