//! What is said of a failing decoder: a cause, and the cases that it explains.

use super::witness::Witness;
use crate::misreadings::{At, Misreading};

/// A cause and what it explains.
pub struct Diagnosis<A: 'static = At> {
    /// What it is.
    pub cause: Cause<A>,
    /// Failing cases it reproduces, by their place in the suite.
    pub explains: Vec<usize>,
    /// Failing cases in which a decoder with this mistake would go wrong too, but not quite in this way.
    pub partly: Vec<usize>,
    /// Passing cases that a decoder with this mistake would fail: the mistake is made, but not everywhere.
    pub except: Vec<usize>,
    /// The observation in words, if other mistakes would look the same. A report states it instead of the cause.
    pub shows: Option<Cause<A>>,
    /// Whether a decoder with this mistake was held against every case, and gives the answers that were received.
    pub certain: bool,
}

/// What a search for causes brought.
pub struct Causes<A: 'static = At> {
    /// Most telling first.
    pub diagnoses: Vec<Diagnosis<A>>,
    /// What panicked in the search, a fault of ours: each cost the cause it was after.
    pub faults: Vec<String>,
    /// How much work it was: answers of decoders with mistakes that were made.
    pub answered: usize,
}

impl<A> From<Vec<Diagnosis<A>>> for Causes<A> {
    fn from(diagnoses: Vec<Diagnosis<A>>) -> Causes<A> {
        Causes {
            diagnoses,
            faults: Vec::new(),
            answered: 0,
        }
    }
}

/// What is wrong.
pub enum Cause<A: 'static = At> {
    /// A mistake of the catalog.
    Misreading {
        /// The mistake.
        misreading: &'static Misreading<A>,
        /// Others that explain the same cases as well.
        alike: Vec<&'static Misreading<A>>,
        /// Others that are made as well, in the same cases.
        with: Vec<&'static Misreading<A>>,
    },
    /// A difference that no mistake of the catalog makes.
    Described {
        /// What kind of failure it is.
        category: Category,
        /// The clause that the cases are about.
        clause: String,
        /// What the decoder does, as a sentence without its subject: "refuses …".
        effect: String,
        /// What to do about it.
        fix: String,
        /// The first example, down to the bytes of the file.
        example: String,
        /// Mistakes of the catalog that would look the same.
        alike: Vec<&'static Misreading<A>>,
    },
}

/// Kinds of failure that are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// Legal files were refused, or ended in a crash.
    Refusal,
    /// Malformed files were accepted.
    Acceptance,
    /// Files that must or may be refused ended in a crash, a hang or a malformed frame.
    Violation,
    /// Pictures are wrong.
    Difference,
    /// The same request is answered in two ways.
    Nondeterminism,
}

impl Category {
    /// As it stands in a report.
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
pub(super) struct Words {
    pub effect: String,
    pub fix: String,
    pub example: String,
}

impl<A> Diagnosis<A> {
    /// Returns the diagnosis that `cause` explains these cases, and nothing else.
    pub(crate) fn of(cause: Cause<A>, explains: Vec<usize>) -> Diagnosis<A> {
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
    /// A cause in words, of `of` among the `witnesses`; about the clause that tells these from the others.
    pub(super) fn described(
        category: Category,
        witnesses: &[Witness],
        of: &[usize],
        words: Words,
    ) -> Diagnosis {
        let cause = Cause::Described {
            category,
            clause: common_clause(witnesses, of).unwrap_or_default(),
            effect: words.effect,
            fix: words.fix,
            example: words.example,
            alike: Vec::new(),
        };
        Diagnosis::of(cause, of.iter().map(|&w| witnesses[w].place).collect())
    }

    /// The same, where these mistakes of the catalog would look the same.
    pub(super) fn like(mut self, others: Vec<&'static Misreading>) -> Diagnosis {
        if let Cause::Described { alike, .. } = &mut self.cause {
            *alike = others;
        }
        self
    }

    /// The same, about a clause that is known better than by what the cases are about.
    pub(super) fn about(mut self, known: &str) -> Diagnosis {
        if let Cause::Described { clause, .. } = &mut self.cause {
            known.clone_into(clause);
        }
        self
    }
}

/// The clause that tells these cases from the others: most of them are about it, and few others are.
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
