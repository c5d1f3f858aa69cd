//! Addresses of pages on the site, defined in one place.
//!
//! Addresses are paths from the root of the site, which is [`SITE`] once published. A test on the site checks that each leads
//! to a page.

use crate::suite::name::SuiteName;

/// The root of the published site.
pub const SITE: &str = env!("CARGO_PKG_HOMEPAGE");

/// The sections that have a page; a clause is on the page of the longest one that it begins with.
const CHAPTERS: [&str; 12] = [
    "1.0", "2.0", "2.1", "2.2", "2.3", "2.4", "2.5", "2.6", "2.7", "2.8", "2.9", "2.9.8",
];

/// Returns the address of a page on the published site.
#[must_use]
pub fn published(page: &str) -> String {
    format!("{SITE}{page}")
}

/// Returns the page of a section.
#[must_use]
pub fn chapter(section: &str) -> String {
    format!("format/{section}.html")
}

/// Returns the page of a code of `lint`.
#[must_use]
pub fn code(id: &str) -> String {
    format!("codes/{id}.html")
}

/// Returns the page of a public reader.
#[must_use]
pub fn reader(name: &str) -> String {
    format!("readers/{}.html", slug(name))
}

/// Returns a name in the form of file names: its words in lower case, with hyphens between them.
pub(crate) fn slug(name: &str) -> String {
    let name = name.to_lowercase();
    let words = name.split(|c: char| !c.is_ascii_alphanumeric());
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    words.join("-")
}

impl SuiteName {
    /// Returns the page of a case; requests to writers have none.
    #[must_use]
    pub fn case_page(self, id: &str) -> Option<String> {
        matches!(self, SuiteName::Ptm | SuiteName::Texture).then(|| self.page("cases", id))
    }

    /// Returns the place of a clause.
    #[must_use]
    pub fn clause_page(self, id: &str) -> Option<String> {
        if self == SuiteName::Texture {
            return Some(format!("texture/index.html#{id}"));
        }
        let (section, _) = id.split_once('/')?;
        let holds = |chapter: &&&str| {
            let rest = section.strip_prefix(**chapter);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let holding = CHAPTERS.iter().filter(holds);
        let holding = holding.max_by_key(|chapter| chapter.len())?;
        Some(format!("{}#c-{}", chapter(holding), id.replace('/', "-")))
    }

    /// Returns the page of a ruling.
    #[must_use]
    pub fn ruling_page(self, id: &str) -> String {
        self.page("rulings", id)
    }

    /// Returns the page of a misreading.
    #[must_use]
    pub fn misreading_page(self, slug: &str) -> String {
        self.page("misreadings", slug)
    }

    /// Returns the page of an id, or its place on the page of a folder.
    fn page(self, folder: &str, id: &str) -> String {
        match self {
            SuiteName::Texture => format!("texture/{folder}.html#{id}"),
            _ => format!("{folder}/{id}.html"),
        }
    }

    /// Returns the page to read first about the protocol.
    #[must_use]
    pub fn protocol_page(self) -> &'static str {
        match self {
            SuiteName::Ptm => "docs/protocol.html",
            SuiteName::Texture => "docs/spec-cases-texture.html",
            SuiteName::Writers | SuiteName::Fitters => "docs/writers.html",
        }
    }
}
