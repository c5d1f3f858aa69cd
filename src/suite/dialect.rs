//! Open questions of kind *choice*, whatever is asked, and the dialect that a decoder follows.
//!
//! Each listed reading of a choice is right, and one run must show one of them throughout. A case may have several right
//! answers then; which of them a decoder gives is evidence of its dialect.

use std::ops::Deref;

/// A place in [`Choices`].
pub type Axis = usize;

/// One open question. `R` is what a reading changes: the decisions of a decoder, or those of a texture stage.
pub struct Choice<R: 'static> {
    /// The ruling.
    pub ruling: &'static str,
    /// The readings, the reference's first: in words, and as a change to the decisions.
    pub readings: &'static [(&'static str, fn(R) -> R)],
}

/// All open questions of a suite, in the order of its text.
pub struct Choices<R: 'static>(pub &'static [Choice<R>]);

/// One reading of every choice, by its place in [`Choice::readings`].
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Dialect(pub Vec<usize>);

/// In which dialects an answer is right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Right {
    /// In all or none: no choice shows in the case.
    Anyway(bool),
    /// Some choices show in the case, and it depends on them alone.
    In {
        /// The choices.
        axes: Vec<Axis>,
        /// Of [`Choices::combinations`] of these axes, those in which it is right.
        combinations: Vec<bool>,
    },
}

impl<R> Deref for Choices<R> {
    type Target = [Choice<R>];

    fn deref(&self) -> &[Choice<R>] {
        self.0
    }
}

impl<R> Choices<R> {
    /// The reference's dialect.
    #[must_use]
    pub fn reference(&self) -> Dialect {
        Dialect(vec![0; self.len()])
    }

    /// `decisions` made as the dialect says.
    #[must_use]
    pub fn under(&self, dialect: &Dialect, decisions: R) -> R {
        let taken = self.iter().zip(&dialect.0);
        taken.fold(decisions, |decisions, (choice, &taken)| {
            (choice.readings[taken].1)(decisions)
        })
    }

    /// Every combination of readings on `axes`, the reference's first; the last axis changes fastest.
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

    /// Which of [`Choices::combinations`] of `axes` a dialect takes.
    #[must_use]
    pub fn place(&self, dialect: &Dialect, axes: &[Axis]) -> usize {
        axes.iter().fold(0, |place, &axis| {
            place * self[axis].readings.len() + dialect.0[axis]
        })
    }

    /// The axes of these rulings, in the order of the text.
    #[must_use]
    pub fn axes(&self, rulings: &[&str]) -> Vec<Axis> {
        (0..self.len())
            .filter(|&axis| rulings.contains(&self[axis].ruling))
            .collect()
    }

    /// Whether an answer is right in a dialect.
    #[must_use]
    pub fn is_right(&self, right: &Right, dialect: &Dialect) -> bool {
        match right {
            Right::Anyway(right) => *right,
            Right::In { axes, combinations } => combinations[self.place(dialect, axes)],
        }
    }
}
