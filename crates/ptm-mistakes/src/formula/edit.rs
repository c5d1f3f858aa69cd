//! Edits of formulas.

use super::expression::{Expression, parse};
use super::formulas::Formula;
use crate::error::{Error, Result};

/// A formula, and what a decoder computes instead.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// The formula being edited.
    pub formula: Formula,
    /// Replacement for the formula.
    pub change: EditedForm,
}

/// A replacement for a formula.
#[derive(Clone, Debug, PartialEq)]
pub enum EditedForm {
    /// An expression in the scope of the formula.
    Expression(Expression),
    /// A table of values, indexed by the first variable of the formula (0 to 255).
    Table(Box<[u8; 256]>),
}

impl Edit {
    /// Parses an edit from the name of a formula and the expression that replaces the formula.
    ///
    /// # Errors
    /// Returns a sentence that names the unknown formula or describes the error in the expression.
    pub fn parse(name: &str, expression: &str) -> Result<Edit> {
        let formula = Formula::from_name(name)
            .ok_or_else(|| Error::Formula(format!("unknown formula {name:?}")))?;
        let change = EditedForm::Expression(parse(expression, formula.scope())?);
        Ok(Edit { formula, change })
    }

    /// Returns the edited expression as text.
    #[must_use]
    pub fn edited_text(&self) -> String {
        match &self.change {
            EditedForm::Expression(expression) => expression.display(self.formula.scope()),
            EditedForm::Table(table) => {
                let differs = |&value: &usize| usize::from(table[value]) != value;
                let differing: Vec<usize> = (0..256).filter(differs).collect();
                let first = differing.first().copied().unwrap_or_default();
                let offsets = differing
                    .iter()
                    .map(|&value| usize::from(table[value]).abs_diff(value));
                let amount = match offsets.max().unwrap_or_default() {
                    1 => " by one".to_owned(),
                    max => format!(" by up to {max}"),
                };
                format!(
                    "a table (at least {} of 256 values differ{amount}, for example {first} becomes {})",
                    differing.len(),
                    table[first]
                )
            }
        }
    }

    /// Returns a clause such as ", where t is the number of the texel in the file", which explains the variables of the edited
    /// expression, or an empty text.
    #[must_use]
    pub fn explanations(&self) -> String {
        let EditedForm::Expression(edited) = &self.change else {
            return String::new();
        };
        let (stated, scope) = (self.formula.stated(), self.formula.scope());
        let meanings = stated.meanings.iter();
        let used = meanings.filter(|(variable, _)| edited.uses(*variable));
        let used = used.map(|(variable, text)| format!("{} is {text}", scope.variables[*variable]));
        let used: Vec<String> = used.collect();
        match &used[..] {
            [] => String::new(),
            [only] => format!(", where {only}"),
            [others @ .., last] => format!(", where {} and {last}", others.join(", ")),
        }
    }

    /// Returns the formula of the specification as text.
    #[must_use]
    pub fn stated_text(&self) -> String {
        let stated = &self.formula.stated().expression;
        stated.display(self.formula.scope())
    }
}
