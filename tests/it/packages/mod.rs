//! The packages for other languages, as their users meet them.

mod node;

mod python;
