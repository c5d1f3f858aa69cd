#![doc = include_str!("../README.md")]
//!
//! # Design
//!
//! The suite provides the values, and the program under test writes the file.
//!
//! ```text
//! WRITER [ARG…] write REQUEST OUT
//! ```
//!
//! REQUEST is a JSON file with the values of the header and the path of the planes ([`request`]). OUT is the path of the
//! PTM file to write. The exit status is 0 if the program wrote the file, 69 if it does not support the requested kind of
//! file, and 65 if no file can represent the values.
//!
//! A file is correct if the reference decodes it to the requested values ([`judge`]). The catalog of misreadings explains wrong
//! files (`diagnose`): if only a reader with a misreading sees the right values in a file, the writer makes the same mistake.

#[cfg(unix)]
pub mod asking;
#[cfg(unix)]
pub mod cases;
#[cfg(unix)]
pub mod diagnose;
pub mod fault;
pub mod fitting;
pub mod judge;
mod lossy;
mod misread_file;
#[cfg(unix)]
pub mod notes;
#[cfg(unix)]
pub mod probe;
pub mod reference;
pub mod request;
#[cfg(unix)]
pub mod test_case;
pub mod wrong_files;
