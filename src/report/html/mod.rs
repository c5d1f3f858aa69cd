//! The report as a page: one file that needs no network, no server and no program but a browser.
//!
//! [`page`] is the contents page. Whatever a decoder printed is hostile text: `maud` escapes all of it, and the policy in
//! the head forbids every request and every script but the page's own, which it names by its digest.

mod page;

mod clause_map;

pub(super) mod evidence;

mod pictures;

mod origin;

mod preview;

mod matrix;

mod shell;

pub use matrix::matrix;
pub use page::{EVIDENCE, page};
pub use shell::STYLE;
