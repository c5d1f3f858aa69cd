//! The packages for other languages.

#![cfg(all(unix, feature = "cli"))]

mod node;
mod python;
