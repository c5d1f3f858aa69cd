//! The report as a web page: one file that needs only a browser, without network, server or other programs.
//!
//! [`page()`] is the table of contents. All output of a decoder is untrusted: `maud` escapes it, and the policy in the head
//! forbids every request and every script except that of the page, which it identifies by its digest.

mod cases;
mod clause_map;
mod compare;
mod diagnosis;
pub(super) mod evidence;
mod matrix;
mod page;
mod pictures;
mod preview;
mod scene;
mod shell;

#[cfg(feature = "cli")]
pub(crate) use evidence::{download, number, standard_error};
pub use matrix::matrix;
pub use page::page;
pub use shell::STYLE;
