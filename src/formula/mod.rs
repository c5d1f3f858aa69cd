//! The specification as formulas, and decoders that compute one of them differently.
//!
//! From the bytes of a file to an image, the specification amounts to some forty formulas (`spec-cases/formulas.yaml`). The
//! functions of [`decode`](mod@crate::decode) and [`evaluate`](crate::evaluate) remain the definition; a test proves that each formula
//! equals its function. An [`Edit`] is another expression in the place of a formula: the catalog states misreadings so, and
//! the diagnosis finds mistakes by trying the edits that [`edits::all`] generates.

mod edit;
pub mod edits;
mod expression;
mod formulas;
mod stages;

pub use edit::{Edit, EditedForm};
pub use expression::{Expression, Function, Scope, parse};
pub use formulas::{Formula, Stage, Stated};
pub use stages::Edits;
pub(crate) use stages::{decode, finals, image, stored};
