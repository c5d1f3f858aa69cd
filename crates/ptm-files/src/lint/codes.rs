//! Problems that lint can report. Each has a permanent code with a description in `spec-cases/lint-codes.yaml`.

use std::sync::LazyLock;

use serde::{Deserialize, Deserializer, Serialize};

use ptm_suite::kit::yaml::from_yaml;

/// Severity of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The file breaks a rule, or the reference cannot read it.
    Error,
    /// Some readers refuse the file or show a different image.
    Warning,
    /// The finding is for information only.
    Info,
}

impl Severity {
    /// Returns the name of the severity.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Info => "info",
        }
    }
}

/// Problem that lint can find in a file. [`Problem::code`] returns its description.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)] // the codes describe the variants
pub enum Problem {
    NotAPtm,
    HeaderLost,
    OtherVersion,
    UnknownFormat,
    CarriageReturn,
    Tab,
    Layout,
    HeaderEnds,
    SizeNotANumber,
    SizeOutOfRange,
    TooLarge,
    Scale,
    Bias,
    TooFewNumbers,
    EntryCount,
    Matrix,
    MatrixShort,
    ListsShort,
    ListNumber,
    Transform,
    NotAPlane,
    NotCausal,
    NegativeSize,
    Index,
    PayloadEnds,
    Utf8Payload,
    Excess,
    NotAStream,
    OtherImage,
    StreamDamaged,
    StreamKind,
    RecordCut,
    Position,
    SpaceAfterName,
    SizeOnOneLine,
    ScaleBiasOnOneLine,
    WideGap,
    ListLayout,
    MatrixLayout,
    BiasAsFloat,
    BiasTooLarge,
    Trailing,
    HugeTable,
    MatrixLastRow,
    Ranks,
    Parameter,
    Near,
    RecordTwice,
    ChoiceLutCount,
    ChoiceLutNewline,
    StreamExtras,
    StreamTrailing,
    StreamMaxval,
    StreamTables16,
    StreamPrecision,
    OtherTransform,
    SpaceBeforeNewline,
    ScaleZero,
    EntriesUnused,
    PredictionUnused,
    Restarts,
    LightWithoutEffect,
    BlackOrWhite,
    LostSectors,
}

impl Problem {
    /// Returns the code of the problem.
    ///
    /// # Panics
    /// Panics only if a problem has no code, which would be a bug.
    #[must_use]
    pub fn code(self) -> &'static Code {
        let code = ALL.iter().find(|code| code.problem == Some(self));
        code.expect("every problem has a code")
    }
}

/// Code of a problem and its description.
#[derive(Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Code {
    /// Permanent identifier, for example `PTM-E001`.
    #[serde(rename = "code", deserialize_with = "deserialize_static")]
    pub id: Text,
    /// Problem that the code identifies, unless `ruling` identifies it.
    #[serde(skip_serializing)]
    pub problem: Option<Problem>,
    /// Default severity.
    pub severity: Severity,
    /// Clause that the problem is about.
    #[serde(deserialize_with = "deserialize_static")]
    pub clause: Text,
    /// Description of the problem.
    #[serde(rename = "says", deserialize_with = "deserialize_static")]
    pub message: Text,
    /// Suggested fix for a writer; empty if there is nothing to do.
    #[serde(default, deserialize_with = "deserialize_static")]
    pub fix: Text,
    /// Ruling of kind *choice* whose readings produce different images.
    #[serde(skip_serializing)]
    pub ruling: Option<String>,
    /// Names of kinds of damage, and ids of cases, that trigger the code. Empty if no file of the suite triggers it; then a test makes
    /// a file that does.
    #[serde(default)]
    pub provoked_by: Vec<String>,
}

/// String from the table of codes, with static lifetime.
type Text = &'static str;

fn deserialize_static<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Text, D::Error> {
    Ok(String::deserialize(deserializer)?.leak())
}

/// All codes, errors first, in the order of the specification.
pub static ALL: LazyLock<Vec<Code>> = LazyLock::new(|| {
    from_yaml(ptm_spec_cases::LINT_CODES).expect("the embedded codes are well-formed")
});

impl Code {
    /// Looks up a code by id.
    #[must_use]
    pub fn find(id: &str) -> Option<&'static Code> {
        ALL.iter().find(|code| code.id == id)
    }

    /// Returns true if the damage with this name or the case with this id triggers the code.
    #[must_use]
    pub fn is_triggered_by(&self, damage_or_case: &str) -> bool {
        self.provoked_by.iter().any(|name| name == damage_or_case)
    }

    /// Returns the error code triggered by a must-reject file with this damage, or by the must-reject case with this id.
    #[must_use]
    pub fn for_rejected_file(damage_or_case: &str) -> Option<&'static Code> {
        let mut errors = ALL.iter().filter(|code| code.severity == Severity::Error);
        errors.find(|code| code.is_triggered_by(damage_or_case))
    }
}
