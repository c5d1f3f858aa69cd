//! The outcome of a case, and the table that decides it.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::cases::Expect;

/// The verdict on a case, with a reason.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// The outcome.
    pub outcome: Outcome,
    /// The reason, in a sentence; empty if there is none.
    pub message: String,
}

/// The outcome of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The response is right.
    Pass,
    /// The response is wrong.
    Fail,
    /// The correct response is implementation-defined, and the decoder's response differs from the reference's.
    ImplementationDefined,
    /// The decoder consistently does not support a feature that the case needs.
    Unsupported,
    /// The valid twin was not decoded, so nothing can be concluded.
    Inconclusive,
    /// The case uses a legal spelling or reading other than the decoder's.
    #[serde(rename = "other dialect")]
    OtherDialect,
    /// The response follows from an assumed mistake.
    #[serde(rename = "as assumed")]
    Assumed,
    /// The decoder offers none of the case's views, or the case was withheld.
    #[serde(rename = "not judged")]
    NotJudged,
    /// The run ended before the case was requested.
    #[serde(rename = "not run")]
    NotRun,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Outcome {
    /// All outcomes, in the order in which they are counted in reports.
    pub const ALL: [Outcome; 9] = [
        Outcome::Pass,
        Outcome::Fail,
        Outcome::ImplementationDefined,
        Outcome::Unsupported,
        Outcome::Inconclusive,
        Outcome::OtherDialect,
        Outcome::Assumed,
        Outcome::NotJudged,
        Outcome::NotRun,
    ];

    /// Returns the name used in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Outcome::Pass => "pass",
            Outcome::Fail => "fail",
            Outcome::ImplementationDefined => "implementation-defined",
            Outcome::Unsupported => "unsupported",
            Outcome::Inconclusive => "inconclusive",
            Outcome::OtherDialect => "other dialect",
            Outcome::Assumed => "as assumed",
            Outcome::NotJudged => "not judged",
            Outcome::NotRun => "not run",
        }
    }
}

/// The kind of a response, as far as it affects the outcome.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResponseKind {
    /// The expected image, or any image if every image is correct.
    Expected,
    /// A different image.
    Different,
    /// Exit status 65.
    Rejected,
    /// Exit status 69.
    Unsupported,
    /// A crash, a timeout or any other violation of the protocol.
    Violation,
}

/// Returns the outcome of a case. docs/protocol.md shows the same table and the exceptions to it.
///
/// `is_supported` is true if the decoder supports every feature that the case needs.
#[must_use]
#[expect(clippy::match_same_arms, reason = "the arms are the rows of the table")]
pub const fn outcome(expect: Expect, is_supported: bool, response: ResponseKind) -> Outcome {
    use Expect::{Decode, ImplementationDefined, Lenient, Refuse, Reject, Robust, Spelling};
    use ResponseKind::{Different, Expected, Rejected, Unsupported, Violation};
    match (response, is_supported, expect) {
        (Expected, _, _) => Outcome::Pass,

        (Different, _, Decode | Reject | Refuse | Lenient | Robust) => Outcome::Fail,
        (Different, _, Spelling) => Outcome::OtherDialect,
        (Different, _, ImplementationDefined) => Outcome::ImplementationDefined,

        (Rejected, _, Decode) => Outcome::Fail,
        (Rejected, true, Reject | Refuse | Lenient | Robust | Spelling) => Outcome::Pass,
        (Rejected, true, ImplementationDefined) => Outcome::ImplementationDefined,

        (Unsupported, true, Refuse | Lenient | Robust | Spelling) => Outcome::Pass,
        (Unsupported, true, Decode | Reject | ImplementationDefined) => Outcome::Fail,

        (Rejected | Unsupported, false, _) => Outcome::Unsupported,

        (Violation, _, _) => Outcome::Fail,
    }
}
