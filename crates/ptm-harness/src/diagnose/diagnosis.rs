//! Causes of failures, and the cases that they explain.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::{rules, witness::Witness};
use ptm_mistakes::{Change, Misreading};
use ptm_suite::cases::Case;

/// A cause and the cases that it explains.
pub struct Diagnosis<A: 'static = Change> {
    /// The cause.
    pub cause: Cause<A>,
    /// Suite indices of the failing cases that the cause reproduces or describes. The example is the first one.
    pub explains: Vec<usize>,
    /// Other mistakes that some of these cases need.
    pub accompanying: Vec<Accompanying<A>>,
    /// True if the cause states how the decoder computes, and a decoder that computes in this way reproduces the responses.
    pub is_mechanism: bool,
}

/// A second mistake that some of the cases of a cause need.
pub enum Accompanying<A: 'static = Change> {
    /// A misreading in the catalog.
    Misreading(&'static Misreading<A>),
    /// The effect of another mistake, as a sentence without a subject.
    Edit(String),
}

/// The result of a search for causes.
pub struct Causes<A: 'static = Change> {
    /// Diagnoses, sorted by the number of failures that they explain, in descending order.
    pub diagnoses: Vec<Diagnosis<A>>,
    /// Rulings of open questions whose readings the passing images do not show, because a mistake looks like the reading.
    pub imitated: Vec<&'static str>,
    /// Number of answers that were computed for decoders with mistakes.
    pub answer_count: usize,
    /// CPU time of the search, if the system reports it.
    pub cpu_time: Option<Duration>,
}

impl<A> From<Vec<Diagnosis<A>>> for Causes<A> {
    fn from(diagnoses: Vec<Diagnosis<A>>) -> Causes<A> {
        Causes {
            diagnoses,
            imitated: Vec::new(),
            answer_count: 0,
            cpu_time: None,
        }
    }
}

/// A cause of failures.
pub enum Cause<A: 'static = Change> {
    /// A misreading in the catalog.
    Misreading {
        /// The misreading that explains the cases.
        misreading: &'static Misreading<A>,
        /// Misreadings that explain the same cases equally well.
        equivalents: Vec<&'static Misreading<A>>,
    },
    /// A description of the failures, if no misreading is named.
    Described {
        /// Category of the failures.
        category: Category,
        /// Clause that all of the cases test, if there is one.
        clause: Option<String>,
        /// Behavior of the decoder, as a sentence without a subject: "refuses …".
        effect: String,
        /// Advice, in the imperative: "read …".
        fix: String,
        /// One failing case in detail, down to the bytes of the file.
        example: String,
        /// Misreadings that would have the same effect.
        equivalents: Vec<&'static Misreading<A>>,
    },
}

/// Categories of failures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Category {
    /// The decoder refused legal files or crashed on them.
    Refusal,
    /// The decoder accepted malformed files.
    Acceptance,
    /// The decoder crashed, exceeded a limit or wrote a malformed frame for files that it must or may refuse.
    Violation,
    /// The decoder output wrong images.
    Difference,
    /// The decoder returned different responses to the same request.
    Nondeterminism,
}

impl Category {
    /// Returns the name used in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Category::Refusal => "refusal",
            Category::Acceptance => "acceptance",
            Category::Violation => "violation",
            Category::Difference => "difference",
            Category::Nondeterminism => "nondeterminism",
        }
    }
}

pub(super) struct CauseText {
    pub effect: String,
    pub fix: String,
    pub example: String,
}

impl<A> Diagnosis<A> {
    /// Creates a diagnosis with a cause and the cases that it explains.
    #[must_use]
    pub fn new(cause: Cause<A>, explains: Vec<usize>) -> Diagnosis<A> {
        Diagnosis {
            cause,
            explains,
            accompanying: Vec::new(),
            is_mechanism: false,
        }
    }
}

impl Diagnosis {
    /// Creates a diagnosis that describes these failures. The clause is `clause` if all of the cases test it.
    pub(super) fn from_description(
        category: Category,
        witnesses: &[Witness],
        cases: &[usize],
        text: CauseText,
        clause: Option<&str>,
    ) -> Diagnosis {
        let judged: Vec<&Case> = cases.iter().map(|&w| witnesses[w].case).collect();
        let clause = rules::common_clause(&judged, clause);
        let cause = Cause::Described {
            category,
            clause: clause.map(str::to_owned),
            effect: text.effect,
            fix: text.fix,
            example: text.example,
            equivalents: Vec::new(),
        };
        Diagnosis::new(
            cause,
            cases.iter().map(|&w| witnesses[w].case_index).collect(),
        )
    }

    /// Declares the cause a mechanism, which misreads this clause.
    pub(super) fn with_mechanism(mut self, misread: &str) -> Diagnosis {
        self.is_mechanism = true;
        if let Cause::Described { clause, .. } = &mut self.cause {
            *clause = Some(misread.to_owned()).filter(|clause| !clause.is_empty());
        }
        self
    }

    /// Sets the misreadings that would have the same effect.
    pub(super) fn with_equivalents(mut self, others: Vec<&'static Misreading>) -> Diagnosis {
        if let Cause::Described { equivalents, .. } = &mut self.cause {
            *equivalents = others;
        }
        self
    }
}
