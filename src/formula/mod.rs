//! The specification as formulas, and decoders that compute one of them differently.
//!
//! From the bytes of a file to an image, the specification amounts to some forty formulas (`spec-cases/formulas.yaml`). The
//! functions of [`decode`](mod@crate::decode) and [`evaluate`](crate::evaluate) remain the definition; a test proves that each formula
//! equals its function. An [`Edit`] is another expression in the place of a formula: the catalog states misreadings so, and
//! the diagnosis finds mistakes by trying the edits that [`edits::all`] generates.

pub mod edits;
mod expression;
mod formulas;
mod stages;

pub use expression::{Expression, Function, Scope, parse};
pub use formulas::{Formula, Stage, Stated};
pub use stages::Edits;
pub(crate) use stages::{decode, finals, image};

/// A formula that a decoder computes differently.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// The edited formula.
    pub formula: Formula,
    /// The replacement.
    pub change: Change,
}

/// The replacement of a formula.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
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
        let formula = Formula::named(name).ok_or_else(|| format!("unknown formula {name:?}"))?;
        let change = Change::Expression(parse(expression, formula.scope())?);
        Ok(Edit { formula, change })
    }

    /// Returns what is computed, as text.
    #[must_use]
    pub fn computes(&self) -> String {
        match &self.change {
            Change::Expression(expression) => expression.display(self.formula.scope()),
            Change::Table(table) => {
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
