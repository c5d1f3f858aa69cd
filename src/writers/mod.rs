//! Other people's writers under test: we give the values, the program writes the file.
//!
//! ```text
//! WRITER [ARG…] write REQUEST OUT
//! ```
//!
//! REQUEST is a JSON file with the header's values and the path of the planes ([`request`]); OUT is where the PTM goes. Exit
//! status: 0 written, 69 not a kind of file that it writes, 65 no file can hold these values.
//!
//! A file is right if the reference decodes it to the values that were given ([`judge`]). A wrong one is diagnosed by the
//! catalog of misreadings looked at from the other side (`diagnose`): a file that gives the right values only under a
//! misreading was written by someone who makes that mistake.

pub mod request;

pub mod reference;

pub mod fault;

mod lossy;

pub mod judge;

mod seen;

pub mod wrong;

#[cfg(unix)]
pub mod cases;

#[cfg(unix)]
pub mod test_case;

#[cfg(unix)]
mod reported;

#[cfg(unix)]
pub mod asking;

#[cfg(unix)]
pub mod diagnose;

#[cfg(unix)]
pub mod probe;

pub mod fitting;
