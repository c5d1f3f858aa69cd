//! Open questions of kind *choice* for any suite, and the dialect of a decoder. Each listed reading of a choice is correct, and a
//! decoder must use one of them throughout a run. A case may therefore have several correct answers; the answer that a decoder
//! gives is evidence of its dialect.

use std::ops::Deref;

/// An index into [`Choices`].
pub type Axis = usize;

/// One open question. `R` is the type that a reading changes: the decisions of a decoder, or those of a texture stage.
pub struct Choice<R: 'static> {
    /// The ruling.
    pub ruling: &'static str,
    /// The readings that the ruling allows.
    pub readings: Readings<R>,
}

/// Readings of a choice, the reference's first, each with a description and a function that changes the decisions.
pub(crate) type Readings<R> = &'static [(&'static str, fn(&mut R))];

impl<R> Choice<R> {
    pub(super) const fn new(ruling: &'static str, readings: Readings<R>) -> Choice<R> {
        Choice { ruling, readings }
    }
}

/// All open questions of a suite, in the order of its specification.
pub struct Choices<R: 'static>(pub &'static [Choice<R>]);

/// One reading for every choice, stored as its index in [`Choice::readings`].
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Dialect(pub Vec<usize>);

/// The dialects in which an answer is right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RightDialects {
    /// In all dialects if true, or in none if false, because no choice affects the case.
    Regardless(bool),
    /// It depends on how a dialect resolves the choices that affect the case.
    Depends {
        /// The choices.
        axes: Vec<Axis>,
        /// True if the answer is right in the dialect of the reference. Other dialects are compared when they matter
        /// ([`TestCase::difference_in`](crate::test_case::TestCase::difference_in)).
        in_reference: bool,
    },
}

impl RightDialects {
    /// Returns the choices that affect the case.
    #[must_use]
    pub fn axes(&self) -> &[Axis] {
        match self {
            RightDialects::Regardless(_) => &[],
            RightDialects::Depends { axes, .. } => axes,
        }
    }

    /// Returns true if the answer is right in the dialect of the reference.
    #[must_use]
    pub const fn is_right_in_reference(&self) -> bool {
        match self {
            RightDialects::Regardless(right) => *right,
            RightDialects::Depends { in_reference, .. } => *in_reference,
        }
    }
}

impl<R> Deref for Choices<R> {
    type Target = [Choice<R>];

    fn deref(&self) -> &[Choice<R>] {
        self.0
    }
}

impl<R> Choices<R> {
    /// Returns each ruling, with the reading of the reference.
    #[must_use]
    pub fn reference_readings(&self) -> Vec<(&'static str, &'static str)> {
        let choices = self.iter();
        choices.map(|one| (one.ruling, one.readings[0].0)).collect()
    }

    /// Returns the dialect of the reference.
    #[must_use]
    pub fn reference(&self) -> Dialect {
        Dialect(vec![0; self.len()])
    }

    /// Applies the readings of a dialect to `decisions`.
    #[must_use]
    pub fn apply(&self, dialect: &Dialect, mut decisions: R) -> R {
        for (choice, &taken) in self.iter().zip(&dialect.0) {
            (choice.readings[taken].1)(&mut decisions);
        }
        decisions
    }

    /// Returns every combination of readings of `axes`, the reference's first. The last axis changes fastest.
    #[must_use]
    pub fn combinations(&self, axes: &[Axis]) -> Vec<Dialect> {
        axes.iter().fold(vec![self.reference()], |all, &axis| {
            let each = |dialect: &Dialect| -> Vec<Dialect> {
                let taking = |reading| {
                    let mut taken = dialect.clone();
                    taken.0[axis] = reading;
                    taken
                };
                (0..self[axis].readings.len()).map(taking).collect()
            };
            all.iter().flat_map(each).collect()
        })
    }

    /// Returns the index of a dialect in [`Choices::combinations`] of `axes`.
    #[must_use]
    pub fn combination_index(&self, dialect: &Dialect, axes: &[Axis]) -> usize {
        let step = |place, &axis: &Axis| place * self[axis].readings.len() + dialect.0[axis];
        axes.iter().fold(0, step)
    }

    /// Returns the axes of these rulings, in the order of the specification.
    #[must_use]
    pub fn axes(&self, rulings: &[&str]) -> Vec<Axis> {
        ((0..self.len()).filter(|&axis| rulings.contains(&self[axis].ruling))).collect()
    }
}
