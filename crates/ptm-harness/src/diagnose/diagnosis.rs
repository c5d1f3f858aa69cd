//! Causes of failures, and the cases that they explain.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::{tuning::is_most, witness::Witness};
use ptm::Format;
use ptm_mistakes::{Change, Misreading};

/// A cause and the cases that it explains.
pub struct Diagnosis<A: 'static = Change> {
    /// The cause.
    pub cause: Cause<A>,
    /// Suite indices of the failing cases that the cause reproduces.
    pub explains: Vec<usize>,
    /// Failing cases that the cause partially explains.
    pub partial: Vec<usize>,
    /// Passing cases that a decoder with this mistake would fail.
    pub contradicted_by: Vec<usize>,
    /// Observed behavior, which is reported instead of the cause if other causes would have the same effect.
    pub observed: Option<Cause<A>>,
    /// True if a decoder with this mistake was compared with every case and reproduces the responses.
    pub is_certain: bool,
}

/// The result of a search for causes.
pub struct Causes<A: 'static = Change> {
    /// Diagnoses, sorted by the number of failures that they explain, in descending order.
    pub diagnoses: Vec<Diagnosis<A>>,
    /// Messages of panics during the search. Each indicates a bug in this program that may hide a cause.
    pub faults: Vec<String>,
    /// Number of answers that were computed for decoders with mistakes.
    pub answer_count: usize,
    /// CPU time of the search, if the system reports it.
    pub cpu_time: Option<Duration>,
}

impl<A> From<Vec<Diagnosis<A>>> for Causes<A> {
    fn from(diagnoses: Vec<Diagnosis<A>>) -> Causes<A> {
        Causes {
            diagnoses,
            faults: Vec::new(),
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
        /// Other misreadings that also affect these cases.
        accompanying: Vec<&'static Misreading<A>>,
    },
    /// A description of the failures, if no misreading is named.
    Described {
        /// Category of the failures.
        category: Category,
        /// Clause that the cases test.
        clause: String,
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
            partial: Vec::new(),
            contradicted_by: Vec::new(),
            observed: None,
            is_certain: false,
        }
    }
}

impl Diagnosis {
    /// Creates a diagnosis that describes the witnesses at `indices`, with the first clause of most of them.
    pub(super) fn from_description(
        category: Category,
        witnesses: &[Witness],
        indices: &[usize],
        text: CauseText,
    ) -> Diagnosis {
        let cause = Cause::Described {
            category,
            clause: most_frequent_clause(witnesses, indices).to_owned(),
            effect: text.effect,
            fix: text.fix,
            example: text.example,
            equivalents: Vec::new(),
        };
        Diagnosis::new(
            cause,
            indices.iter().map(|&w| witnesses[w].case_index).collect(),
        )
    }

    /// Sets the misreadings that would have the same effect.
    pub(super) fn with_equivalents(mut self, others: Vec<&'static Misreading>) -> Diagnosis {
        if let Cause::Described { equivalents, .. } = &mut self.cause {
            *equivalents = others;
        }
        self
    }

    /// Replaces the clause that was inferred from the cases, unless `new` is `None`.
    pub(super) fn with_clause<'a>(mut self, new: impl Into<Option<&'a str>>) -> Diagnosis {
        if let (Cause::Described { clause, .. }, Some(new)) = (&mut self.cause, new.into()) {
            new.clone_into(clause);
        }
        self
    }
}

/// Returns the first clause of most of these cases or, if there is none, the clause about the layout that the files share.
fn most_frequent_clause<'a>(witnesses: &'a [Witness], indices: &[usize]) -> &'a str {
    let clause = |w: &usize| {
        witnesses[*w]
            .case
            .clauses
            .first()
            .map_or("", String::as_str)
    };
    let count = |clause_of: &str| indices.iter().filter(|w| clause(w) == clause_of).count();
    let mut clauses = indices.iter().map(clause);
    let most = clauses.find(|&one| !one.is_empty() && is_most(count(one), indices.len()));
    most.unwrap_or_else(|| shared_clause(witnesses, indices))
}

/// Returns the clause about the layout that these files share: the layout of their format, of tables, or of compressed planes. If
/// the layouts differ in other ways, returns the clause about the header.
fn shared_clause(witnesses: &[Witness], indices: &[usize]) -> &'static str {
    let formats = indices.iter().map(|&w| witnesses[w].case.format());
    let formats: Vec<Format> = formats.collect();
    let first = formats[0].layout_clause();
    match formats.iter().all(|format| format.layout_clause() == first) {
        true => first,
        false if formats.iter().all(|format| format.has_table()) => "2.5/1",
        false => "2.0/1",
    }
}
