//! The packages for other languages, as their users meet them.

#![cfg(all(unix, feature = "cli"))]

mod node;
mod python;
