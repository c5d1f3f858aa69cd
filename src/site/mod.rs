//! The site: all information about the format, its readers and this suite, as pages that need no server.
//!
//! [`build`] is the table of contents. Every worked example is executed while its page is made; a failing one ends the build.
//! The output is reproducible.

pub mod annotated;
mod case_pages;
mod code_pages;
mod docs_pages;
mod drop;
pub mod example;
mod format_pages;
mod formula;
mod glossary;
mod home;
mod library;
mod misreading_pages;
mod overview;
mod paper;
mod pictures;
mod reader_pages;
pub mod readers;
mod ruling_pages;
mod search;
mod texts;
mod texture_pages;
mod witness;

pub use paper::SiteFile;

use annotated::Annotated;
use library::Library;
use paper::Paper;

/// The style of every page, also used for reports.
const STYLE: &str = crate::report::html::STYLE;
/// The script of every page.
const SCRIPT: &str = include_str!("site.js");

/// Returns all files of the site. `annotated` replaces the embedded annotated format; with `module`, the reference as
/// WebAssembly, there is a page for dropped files.
///
/// # Errors
/// A sentence that names the clause whose example fails, or the file of the suite that cannot be read.
pub fn build(
    annotated: Option<Annotated>,
    module: Option<&[u8]>,
    jobs: usize,
) -> Result<Vec<SiteFile>, String> {
    let library = Library::open(annotated, jobs)?;
    let top = Paper {
        library: &library,
        root: "",
    };
    let below = Paper { root: "../", ..top };
    let mut files = vec![
        SiteFile::new("style.css", STYLE),
        SiteFile::new("site.js", SCRIPT),
        search::index(&library),
    ];
    files.extend(drop::pages(top, module)?);
    files.push(home::page(top));
    files.push(glossary::page(top));
    files.push(reader_pages::scoreboard(top));
    files.extend(format_pages::pages(below)?);
    files.extend(ruling_pages::pages(below));
    files.extend(misreading_pages::pages(below));
    files.extend(code_pages::pages(below));
    files.extend(reader_pages::pages(below));
    files.extend(texture_pages::pages(below)?);
    files.extend(docs_pages::pages(below));
    files.extend(case_pages::pages(below, jobs));
    Ok(files)
}
