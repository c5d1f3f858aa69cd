//! Website about the format, its readers and this suite. The pages need no server.
//!
//! Start reading at [`build`]. Every worked example is executed during generation, and a failing example aborts the build.
//! The output is reproducible.

pub mod annotated;
mod case_pages;
mod code_pages;
mod docs_pages;
mod drop;
pub mod example;
mod format_pages;
mod formula;
mod gallery;
mod glossary;
mod home;
mod images;
mod library;
mod misreading_pages;
mod objects;
mod overview;
mod page;
mod reader_pages;
pub mod readers;
mod ruling_pages;
mod search;
mod texture_objects;
mod texture_pages;
mod witness;

pub use page::SiteFile;

use annotated::Annotated;
use library::Library;
use page::PageContext;

/// Style sheet of every page, shared with the reports.
const STYLE: &str = crate::report::html::STYLE;
/// Script of every page.
const SCRIPT: &str = include_str!("site.js");

/// Generates all files of the site. `annotated` replaces the embedded annotated format. `module` is the reference decoder as
/// WebAssembly, which runs in the page for dropped files; without it, the site does not have this page.
///
/// # Errors
/// Returns a message that names the clause whose example fails, or the file of the suite that cannot be read.
pub fn build(
    annotated: Option<Annotated>,
    module: Option<&[u8]>,
    jobs: usize,
) -> Result<Vec<SiteFile>, String> {
    let library = Library::open(annotated, jobs)?;
    let top = PageContext {
        library: &library,
        root: "",
        has_drop_page: module.is_some(),
    };
    let nested = PageContext { root: "../", ..top };
    let mut files = vec![
        SiteFile::new("style.css", STYLE),
        SiteFile::new("site.js", SCRIPT),
        search::index(&library),
    ];
    files.extend(library.objects.files());
    files.extend(drop::pages(top, module)?);
    files.push(home::page(top));
    files.push(glossary::page(top));
    files.push(reader_pages::scoreboard(top));
    files.extend(format_pages::pages(nested)?);
    files.extend(ruling_pages::pages(nested));
    files.extend(misreading_pages::pages(nested));
    files.extend(code_pages::pages(nested));
    files.extend(reader_pages::pages(nested));
    files.extend(texture_pages::pages(nested)?);
    files.extend(docs_pages::pages(nested));
    files.extend(case_pages::pages(nested, jobs));
    Ok(files)
}
