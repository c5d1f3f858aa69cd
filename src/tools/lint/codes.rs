//! The problems that lint can report: a permanent code for each, with its text from `spec-cases/lint-codes.yaml`.

use std::sync::LazyLock;

use serde::{Deserialize, Deserializer, Serialize};

use crate::kit::yaml::from_yaml;

/// The severity of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The file breaks a rule, or the reference cannot read it.
    Error,
    /// Some readers refuse the file or show another image.
    Warning,
    /// For information.
    Info,
}

impl Severity {
    /// Returns the severity in one word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Info => "info",
        }
    }
}

/// A problem that lint can find in a file; [`Problem::code`] has its text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)] // the text says what each is
pub enum Problem {
    NotAPtm,
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
    NotAStream,
    OtherPicture,
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
    ChoiceLumVector,
    ChoiceLumMajor,
    ChoiceLumRange,
    ChoiceJpegLsOffset,
    ChoiceMotionSign,
    ChoiceMotionVertical,
    ChoiceMotionHalf,
    ChoiceMotionBorder,
    ChoiceMotionInversion,
    ChoiceSideLossless,
    StreamExtras,
    StreamTrailing,
    StreamMaxval,
    OtherTransform,
    SpaceBeforeNewline,
    ScaleZero,
    EntriesUnused,
    PredictionUnused,
    Restarts,
}

impl Problem {
    /// Returns the code of the problem.
    ///
    /// # Panics
    /// Never: a test finds every problem in a file.
    #[must_use]
    pub fn code(self) -> &'static Code {
        let code = ALL.iter().find(|code| code.problem == self);
        code.expect("every problem has a code")
    }
}

/// The code of a problem, and its text.
#[derive(Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Code {
    /// The permanent identifier, for example `PTM-E001`.
    #[serde(rename = "code", deserialize_with = "leaked")]
    pub id: Text,
    /// The problem.
    #[serde(skip_serializing)]
    pub problem: Problem,
    /// Its severity.
    pub severity: Severity,
    /// The clause that it is about.
    #[serde(deserialize_with = "leaked")]
    pub clause: Text,
    /// The problem in a sentence.
    #[serde(deserialize_with = "leaked")]
    pub says: Text,
    /// The suggested fix for a writer; empty if there is nothing to do.
    #[serde(default, deserialize_with = "leaked")]
    pub fix: Text,
    /// The ruling of kind *choice* that changes the image.
    #[serde(skip_serializing)]
    pub ruling: Option<String>,
    /// Names of damages and ids of cases, each of which provokes the code.
    pub provoked_by: Vec<String>,
}

/// A text of the table, with the lifetime of the program.
type Text = &'static str;

fn leaked<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Text, D::Error> {
    Ok(String::deserialize(deserializer)?.leak())
}

/// All codes, errors first, in the order of the text.
pub static ALL: LazyLock<Vec<Code>> = LazyLock::new(|| {
    from_yaml(include_str!("../../../spec-cases/lint-codes.yaml"))
        .expect("the embedded codes are well-formed")
});

impl Code {
    /// Returns the code with this id.
    #[must_use]
    pub fn by_id(id: &str) -> Option<&'static Code> {
        ALL.iter().find(|code| code.id == id)
    }

    /// Returns true if this damage, or the case with this id, provokes the code.
    #[must_use]
    pub fn is_provoked_by(&self, damage_or_case: &str) -> bool {
        self.provoked_by.iter().any(|name| name == damage_or_case)
    }

    /// Returns the code of a must-reject file made by this damage, or of the must-reject case with this id.
    #[must_use]
    pub fn of_refused(damage_or_case: &str) -> Option<&'static Code> {
        let mut errors = ALL.iter().filter(|code| code.severity == Severity::Error);
        errors.find(|code| code.is_provoked_by(damage_or_case))
    }
}
