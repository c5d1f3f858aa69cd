//! Conformance of writers: the suite gives the values, the program under test writes the file.
//!
//! ```text
//! WRITER [ARG…] write REQUEST OUT
//! ```
//!
//! REQUEST is a JSON file with the values of the header and the path of the planes ([`request`]); OUT is the path of the
//! PTM file. The exit status is 0 if the file was written, 69 if the program does not write such files, and 65 if no file
//! can hold these values.
//!
//! A file is right if the reference decodes it to the values that were given ([`judge`]). The catalog of misreadings
//! explains wrong files (`diagnose`): if only a reader with a misreading gets the right values from a file, its writer
//! makes that mistake.

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
#[cfg(unix)]
pub mod probe;
pub mod reference;
#[cfg(unix)]
mod reported;
pub mod request;
mod seen;
#[cfg(unix)]
pub mod test_case;
pub mod wrong;
