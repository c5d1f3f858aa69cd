//! Expected answers to texture questions, under the reference's readings and under other correct readings.

use serde_json::Value;

use crate::dialect::{Axis, Dialect};
use crate::protocol::frame::Answer;
use crate::texture::cases::{Basis, TextureCase};
use crate::texture::choices::CHOICES;
use crate::texture::compare::ExpectedAnswer;
use crate::texture::question::{Refusal, ToleratedAnswer};
use ptm_texture::Rules;

impl TextureCase {
    /// Returns true if the question is outside the valid range and must be refused.
    pub(crate) fn must_be_refused(&self) -> bool {
        self.expect.get("error").is_some()
    }

    /// Computes the answer under `rules`, which represent one reading of the chapter.
    #[must_use]
    pub fn answer(&self, rules: &Rules) -> Answer<Value> {
        match self.read().and_then(|question| question.answer(rules)) {
            Ok(value) => Answer::Decoded(value),
            Err(Refusal::Malformed(_)) => Answer::Rejected,
            Err(Refusal::Unsupported(_)) => Answer::Unsupported,
        }
    }

    /// Returns the expected answer. It is stated in the case for the reference's dialect, and computed for any other dialect.
    /// Tolerances are always computed.
    #[must_use]
    pub fn expected(&self, dialect: &Dialect) -> ExpectedAnswer {
        let rules = CHOICES.apply(dialect, Rules::SPEC);
        let computed = self.expected_under(&rules);
        match computed {
            Some(computed) if *dialect == CHOICES.reference() => ExpectedAnswer {
                answer: self.expect.clone(),
                ..computed
            },
            Some(computed) => computed,
            None => ExpectedAnswer {
                answer: self.expect.clone(),
                filter_tolerance: Value::Null,
                arithmetic_tolerance: self.tolerance,
            },
        }
    }

    /// Returns the answer that is computed under `rules`, with its tolerances, or `None` if the question is refused.
    #[must_use]
    pub fn expected_under(&self, rules: &Rules) -> Option<ExpectedAnswer> {
        let question = self.read().ok()?;
        let ToleratedAnswer { answer, tolerance } = question.answer_with_tolerance(rules).ok()?;
        Some(ExpectedAnswer {
            answer,
            filter_tolerance: tolerance,
            arithmetic_tolerance: self.tolerance,
        })
    }

    /// Returns the choices whose readings change the expected answer.
    #[must_use]
    pub fn relevant_axes(&self) -> &[Axis] {
        self.relevant_axes.get_or_init(|| {
            let reference = self.expected(&CHOICES.reference());
            let changes = |&axis: &Axis| {
                (1..CHOICES[axis].readings.len()).any(|reading| {
                    let mut dialect = CHOICES.reference();
                    dialect.0[axis] = reading;
                    let other = self.expected(&dialect).answer;
                    reference.difference(&other).is_some()
                })
            };
            // Answers that are left to the implementation are right in every dialect.
            let axes = (0..CHOICES.len()).filter(|_| self.basis != Basis::Impl);
            axes.filter(changes).collect()
        })
    }
}
