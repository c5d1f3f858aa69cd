//! The cause of a failure, and the cases that it explains.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::witness::Witness;
use crate::misreadings::{At, Misreading};

/// A cause and what it explains.
pub struct Diagnosis<A: 'static = At> {
    /// The cause.
    pub cause: Cause<A>,
    /// Failing cases that it reproduces, by their places in the suite.
    pub explains: Vec<usize>,
    /// Failing cases that it explains in part.
    pub partly: Vec<usize>,
    /// Passing cases that a decoder with this mistake would fail.
    pub except: Vec<usize>,
    /// The observation in words, if other mistakes would look the same. A report states it instead of the cause.
    pub shows: Option<Cause<A>>,
    /// True if a decoder with this mistake was compared with every case, and reproduces the responses.
    pub certain: bool,
}

/// The result of a search for causes.
pub struct Causes<A: 'static = At> {
    /// The diagnoses, the one that explains most first.
    pub diagnoses: Vec<Diagnosis<A>>,
    /// Messages of panics in the search. Each is a bug in this program, and costs one cause.
    pub faults: Vec<String>,
    /// The number of answers of decoders with mistakes that were computed.
    pub answered: usize,
    /// The CPU time that the search took, where the system can tell.
    pub cpu_time: Option<Duration>,
}

impl<A> From<Vec<Diagnosis<A>>> for Causes<A> {
    fn from(diagnoses: Vec<Diagnosis<A>>) -> Causes<A> {
        Causes {
            diagnoses,
            faults: Vec::new(),
            answered: 0,
            cpu_time: None,
        }
    }
}

/// A cause of failures.
pub enum Cause<A: 'static = At> {
    /// A mistake of the catalog.
    Misreading {
        /// The mistake.
        misreading: &'static Misreading<A>,
        /// Misreadings that explain the same cases equally well.
        alike: Vec<&'static Misreading<A>>,
        /// Misreadings that show in the same cases too.
        with: Vec<&'static Misreading<A>>,
    },
    /// A difference that no misreading of the catalog produces.
    Described {
        /// The kind of failure.
        category: Category,
        /// The clause that the cases are about.
        clause: String,
        /// The decoder's behavior, as a sentence without its subject: "refuses …".
        effect: String,
        /// The advice, as a command: "read …".
        fix: String,
        /// One failing case in detail, down to the bytes of the file.
        example: String,
        /// Misreadings that would look the same.
        alike: Vec<&'static Misreading<A>>,
    },
}

/// The kinds of failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Category {
    /// Legal files were refused, or ended in a crash.
    Refusal,
    /// Malformed files were accepted.
    Acceptance,
    /// Files that must or may be refused ended in a crash, a hang or a malformed frame.
    Violation,
    /// Images are wrong.
    Difference,
    /// A request has different responses.
    Nondeterminism,
}

impl Category {
    /// Returns the name in a report.
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

/// The words of a described cause.
pub(super) struct CauseWords {
    pub effect: String,
    pub fix: String,
    pub example: String,
}

impl<A> Diagnosis<A> {
    /// Returns the diagnosis that `cause` explains these cases, and nothing else.
    pub(crate) fn new(cause: Cause<A>, explains: Vec<usize>) -> Diagnosis<A> {
        Diagnosis {
            cause,
            explains,
            partly: Vec::new(),
            except: Vec::new(),
            shows: None,
            certain: false,
        }
    }
}

impl Diagnosis {
    /// Returns the diagnosis that describes these witnesses, with the clause that they have more often than the others.
    pub(super) fn described(
        category: Category,
        witnesses: &[Witness],
        of: &[usize],
        words: CauseWords,
    ) -> Diagnosis {
        let cause = Cause::Described {
            category,
            clause: common_clause(witnesses, of).unwrap_or_default(),
            effect: words.effect,
            fix: words.fix,
            example: words.example,
            alike: Vec::new(),
        };
        Diagnosis::new(cause, of.iter().map(|&w| witnesses[w].place).collect())
    }

    /// Sets the misreadings that would look the same.
    pub(super) fn with_alike(mut self, others: Vec<&'static Misreading>) -> Diagnosis {
        if let Cause::Described { alike, .. } = &mut self.cause {
            *alike = others;
        }
        self
    }

    /// Sets the clause, if it is known better than from the clauses of the cases.
    pub(super) fn with_clause(mut self, known: &str) -> Diagnosis {
        if let Cause::Described { clause, .. } = &mut self.cause {
            known.clone_into(clause);
        }
        self
    }
}

/// Returns the clause that most of these cases are about and few others.
fn common_clause(witnesses: &[Witness], of: &[usize]) -> Option<String> {
    let about = |clause: &String, w: &&usize| witnesses[**w].case.clauses.contains(clause);
    let all: Vec<usize> = (0..witnesses.len()).collect();
    let mut clauses: Vec<&String> = of
        .iter()
        .flat_map(|&w| &witnesses[w].case.clauses)
        .collect();
    clauses.sort();
    clauses.dedup();
    let worth = |clause: &String| {
        let count = |places: &[usize]| places.iter().filter(|w| about(clause, w)).count();
        let (mine, theirs) = (count(of), count(&all));
        (mine * mine * mine) as f64 / theirs as f64
    };
    clauses
        .into_iter()
        .max_by(|a, b| worth(a).total_cmp(&worth(b)).then(b.cmp(a)))
        .cloned()
}
