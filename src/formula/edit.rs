//! An edit of a formula.

use super::expression::{Expression, parse};
use super::formulas::Formula;

/// A formula that a decoder computes differently.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// The edited formula.
    pub formula: Formula,
    /// The replacement.
    pub change: EditedForm,
}

/// The replacement of a formula.
#[derive(Clone, Debug, PartialEq)]
pub enum EditedForm {
    /// Another expression, in the formula's scope.
    Expression(Expression),
    /// A table of values, indexed by the formula's first variable from 0 to 255.
    Table(Box<[u8; 256]>),
}

impl Edit {
    /// Reads an edit: the name of a formula, and the expression that replaces it.
    ///
    /// # Errors
    /// A sentence that names the unknown formula or what is wrong with the expression.
    pub fn parse(name: &str, expression: &str) -> Result<Edit, String> {
        let formula =
            Formula::from_name(name).ok_or_else(|| format!("unknown formula {name:?}"))?;
        let change = EditedForm::Expression(parse(expression, formula.scope())?);
        Ok(Edit { formula, change })
    }

    /// Returns what is computed, as text.
    #[must_use]
    pub fn computes(&self) -> String {
        match &self.change {
            EditedForm::Expression(expression) => expression.display(self.formula.scope()),
            EditedForm::Table(table) => {
                let differs = |&value: &usize| usize::from(table[value]) != value;
                let differing: Vec<usize> = (0..256).filter(differs).collect();
                let first = differing.first().copied().unwrap_or_default();
                let offsets = differing
                    .iter()
                    .map(|&value| usize::from(table[value]).abs_diff(value));
                let by = match offsets.max().unwrap_or_default() {
                    1 => " by one".to_owned(),
                    most => format!(" by up to {most}"),
                };
                format!(
                    "a table (at least {} of 256 values differ{by}, for example {first} -> {})",
                    differing.len(),
                    table[first]
                )
            }
        }
    }

    /// Returns the formula of the specification, as text.
    #[must_use]
    pub fn stated(&self) -> String {
        let stated = &self.formula.stated().expression;
        stated.display(self.formula.scope())
    }
}
