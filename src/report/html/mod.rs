//! The report as a page: one file that needs no network, no server and no program but a browser.
//!
//! [`page`] is the contents page. Whatever a decoder printed is hostile text: `maud` escapes all of it, and the policy in
//! the head forbids every request and every script but the page's own, which it names by its digest.

mod page;

mod diagnosis;

mod cases;

mod clause_map;

pub(super) mod evidence;

mod pictures;

mod compare;

mod scene;

mod preview;

mod matrix;

mod shell;

#[cfg(feature = "cli")]
pub(crate) use evidence::download;
pub use matrix::matrix;
pub use page::page;
pub use shell::STYLE;
