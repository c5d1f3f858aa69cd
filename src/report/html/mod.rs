//! Reports as web pages. Each page is one self-contained file that needs no network or server.
//!
//! Begin with [`page()`]. All output of a decoder is untrusted. `maud` escapes it, and the content security policy of the page
//! forbids all requests and all scripts except the page's own script, which is identified by digest.

mod cases;
mod clause_map;
mod compare;
mod diagnosis;
mod evidence;
mod figures;
mod matrix;
mod page;
mod preview;
mod scene;
mod shell;

pub(crate) use clause_map::ClauseTally;
pub(crate) use evidence::number;
pub use evidence::{Evidence, case_evidence, file_evidence, question_evidence};
pub use matrix::matrix;
pub use page::{page, page_without_images};
pub use shell::STYLE;
