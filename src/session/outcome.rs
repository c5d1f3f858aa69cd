//! What is said of a case.

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
    /// The decoder does not do this kind of file, and says so everywhere.
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
