//! The outcome of a case, and the table that decides it.

use crate::suite::cases::Expect;

/// What is said of a case.
#[derive(Clone, Debug)]
pub struct Judged {
    /// The verdict.
    pub outcome: Outcome,
    /// Why, in a sentence; empty where there is nothing to say.
    pub says: String,
}

/// The verdict on a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Outcome {
    /// As it should be.
    Pass,
    /// Not as it should be.
    Fail,
    /// Left to the implementation, and this one differs from the reference.
    ImplementationDefined,
    /// The decoder does not support a feature that the case needs, and says so everywhere.
    Unsupported,
    /// The accepted twin was not decoded, so nothing follows.
    Inconclusive,
    /// A legal spelling or reading that this decoder does not follow; it follows another.
    OtherDialect,
    /// As a mistake has it that the user takes as given.
    Assumed,
    /// None of the case's views is offered.
    NotJudged,
    /// The run ended before.
    NotRun,
}

impl Outcome {
    /// All, in the order in which they are counted for people.
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

    /// As it stands in a report.
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

/// What a decoder did with a file, as far as the outcome depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResponseKind {
    /// The expected image, or any image where every image is right.
    Expected,
    /// Another image.
    Different,
    /// Exit status 65.
    Rejected,
    /// Exit status 69.
    Unsupported,
    /// A crash, a hang or anything else that the protocol does not allow.
    Violation,
}

/// Returns the outcome of a case. docs/protocol.md shows the same table, and the exceptions to it.
///
/// `is_supported` says whether the decoder supports every feature that the case needs.
#[must_use]
#[expect(
    clippy::match_same_arms,
    reason = "the arms are the rows of the table, in its order"
)]
pub const fn outcome(expect: Expect, is_supported: bool, response: ResponseKind) -> Outcome {
    use Expect::{Decode, ImplementationDefined, Lenient, Refuse, Reject, Spelling};
    use ResponseKind::{Different, Expected, Rejected, Unsupported, Violation};
    match (response, is_supported, expect) {
        (Expected, _, _) => Outcome::Pass,

        (Different, _, Decode | Reject | Refuse | Lenient) => Outcome::Fail,
        (Different, _, Spelling) => Outcome::OtherDialect,
        (Different, _, ImplementationDefined) => Outcome::ImplementationDefined,

        (Rejected, _, Decode) => Outcome::Fail,
        (Rejected, true, Reject | Refuse | Lenient | Spelling) => Outcome::Pass,
        (Rejected, true, ImplementationDefined) => Outcome::ImplementationDefined,

        (Unsupported, true, Refuse | Lenient | Spelling) => Outcome::Pass,
        (Unsupported, true, Decode | Reject | ImplementationDefined) => Outcome::Fail,

        (Rejected | Unsupported, false, _) => Outcome::Unsupported,

        (Violation, _, _) => Outcome::Fail,
    }
}
