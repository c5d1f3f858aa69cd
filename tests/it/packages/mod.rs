//! The packages for other languages.

#![cfg(unix)]

mod node;
mod python;
