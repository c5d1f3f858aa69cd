//! The specification as formulas, and decoders that compute a formula differently.
//!
//! Decoding a file to an image can be written as 56 formulas (`spec-cases/formulas.yaml`). The functions of
//! [`decode`](mod@ptm::decode) and [`evaluate`](ptm::evaluate) remain the definition, and a test checks that each formula
//! equals its function. An [`Edit`] replaces a formula with a different expression. The catalog states some misreadings in this
//! way, and the diagnosis finds mistakes by trying the edits that [`edits::all`] generates.

mod edit;
pub mod edits;
mod expression;
mod formulas;
mod stages;
mod views;

pub use edit::{Edit, EditedForm};
pub use expression::{Expression, Function, Scope, parse};
pub use formulas::{Formula, Stage, StatedFormula};
pub use stages::{Edits, Outside};
pub use stages::{colors_inside_texel, decode, final_values, floats, image, stored_values};
pub use views::{render, values};
