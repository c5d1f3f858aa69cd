//! Addresses of pages on the site, defined in one place.
//!
//! Addresses are paths relative to [`SITE`], the root of the published site. A test checks that each address has a page.

use crate::name::SuiteName;

/// URL of the published site.
pub const SITE: &str = env!("CARGO_PKG_HOMEPAGE");

/// Sections with a page. A clause is on the page of its longest prefix in this list.
const CHAPTERS: [&str; 12] = [
    "1.0", "2.0", "2.1", "2.2", "2.3", "2.4", "2.5", "2.6", "2.7", "2.8", "2.9", "2.9.8",
];

/// Returns the address of a page on the published site.
#[must_use]
pub fn published_url(page: &str) -> String {
    format!("{SITE}{page}")
}

/// Returns the address of the page for a section.
#[must_use]
pub fn chapter(section: &str) -> String {
    format!("format/{section}.html")
}

/// Returns the address of the page for a lint code.
#[must_use]
pub fn code(id: &str) -> String {
    format!("codes/{id}.html")
}

/// Returns the address of the page for a public reader.
#[must_use]
pub fn reader(name: &str) -> String {
    format!("readers/{}.html", slug(name))
}

/// Converts a name to a file name: lowercase words separated by hyphens.
#[must_use]
pub fn slug(name: &str) -> String {
    let name = name.to_lowercase();
    let words = name.split(|c: char| !c.is_ascii_alphanumeric());
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    words.join("-")
}

impl SuiteName {
    /// Returns the address of the page for a case, or `None` for requests to writers and fitters, which have no page.
    #[must_use]
    pub fn case_page(self, id: &str) -> Option<String> {
        matches!(self, SuiteName::Ptm | SuiteName::Texture).then(|| self.page("cases", id))
    }

    /// Returns the address of the page for a clause.
    #[must_use]
    pub fn clause_page(self, id: &str) -> Option<String> {
        if self == SuiteName::Texture {
            return Some(format!("texture/index.html#{id}"));
        }
        let (section, _) = id.split_once('/')?;
        let contains = |chapter: &&&str| {
            let rest = section.strip_prefix(**chapter);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let chapters = CHAPTERS.iter().filter(contains);
        let longest = chapters.max_by_key(|chapter| chapter.len())?;
        Some(format!("{}#c-{}", chapter(longest), id.replace('/', "-")))
    }

    /// Returns the address of the page for a ruling.
    #[must_use]
    pub fn ruling_page(self, id: &str) -> String {
        self.page("rulings", id)
    }

    /// Returns the address of the page for a misreading.
    #[must_use]
    pub fn misreading_page(self, slug: &str) -> String {
        self.page("misreadings", slug)
    }

    /// Returns the address of the description of `id`: a page in `folder`, or an anchor on the texture page that `folder` names.
    fn page(self, folder: &str, id: &str) -> String {
        match self {
            SuiteName::Texture => format!("texture/{folder}.html#{id}"),
            _ => format!("{folder}/{id}.html"),
        }
    }

    /// Returns the address of the introduction to the protocol.
    #[must_use]
    pub fn protocol_page(self) -> &'static str {
        match self {
            SuiteName::Ptm => "docs/protocol.html",
            SuiteName::Texture => "docs/spec-cases-texture.html",
            SuiteName::Writers | SuiteName::Fitters => "docs/writers.html",
        }
    }
}
