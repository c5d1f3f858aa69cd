//! The forms of a report: terminal, HTML, `JUnit`, GitHub and a badge. Each is a function of a
//! [`Report`](ptm_harness::report::Report) and of the texts of its suite; the HTML page also shows evidence from the run.

pub mod badge;
pub mod github;
pub mod html;
pub mod junit;
pub mod text;
