//! Page template: head, navigation, and relative links.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::library::{Library, NamedTexts, PROTOCOL};

/// File of the site.
pub struct SiteFile {
    /// Path relative to the root of the site.
    pub path: String,
    /// Contents of the file.
    pub bytes: Vec<u8>,
}

impl SiteFile {
    pub(super) fn new(path: impl Into<String>, bytes: impl Into<Vec<u8>>) -> SiteFile {
        let (path, bytes) = (path.into(), bytes.into());
        SiteFile { path, bytes }
    }
}

/// Rendering context of a page: the library, and the path to the root.
#[derive(Clone, Copy)]
pub(super) struct PageContext<'a> {
    pub library: &'a Library,
    /// Relative path from the page to the root of the site: empty or `../`.
    pub root: &'static str,
    /// True if the site has the page onto which files are dropped.
    pub has_drop_page: bool,
}

impl PageContext<'_> {
    /// Renders an id as a link to its page, or as plain text if it has no page.
    pub(super) fn link(&self, id: &str) -> Markup {
        self.link_as(id, &html! { code { (id) } })
    }

    pub(super) fn link_as(&self, id: &str, text: &Markup) -> Markup {
        match self.library.page_url(id) {
            Some(url) => html! { a href={ (self.root) (url) } { (text) } },
            None => text.clone(),
        }
    }

    pub(super) fn protocol(&self) -> Markup {
        self.link_as(PROTOCOL, &html! { "the decoder protocol" })
    }

    /// Renders links to several ids, separated by commas.
    pub(super) fn links<'b>(&self, ids: impl IntoIterator<Item = &'b str>) -> Markup {
        html! {
            @for (i, id) in ids.into_iter().enumerate() { @if i > 0 { ", " } (self.link(id)) }
        }
    }

    /// Renders text with `code`, *emphasis*, and links for clause ids and for ids in code.
    pub(super) fn prose(&self, text: &str) -> Markup {
        html! {
            @for (i, part) in text.split('`').enumerate() {
                @if i % 2 == 1 { (self.link(part)) } @else {
                    @for (i, part) in part.split('*').enumerate() {
                        @if i % 2 == 1 { em { (part) } } @else { (self.link_clauses(part)) }
                    }
                }
            }
        }
    }

    /// Adds links to all clause ids in `text`.
    fn link_clauses(&self, text: &str) -> Markup {
        let mut out = String::new();
        let mut rest = text;
        while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
            let length = rest[start..].find(|c: char| !c.is_ascii_digit() && c != '.' && c != '/');
            let word = &rest[start..start + length.unwrap_or(rest.len() - start)];
            let id = word.trim_end_matches(['.', '/']);
            let plain = &rest[..start];
            out += &html! { (plain) }.0;
            let is_clause = id.contains('.') && (id.contains('/') || id.starts_with("2."));
            out += &match is_clause && self.library.page_url(id).is_some() {
                true => self.link_as(id, &html! { (id) }).0,
                false => html! { (id) }.0,
            };
            rest = &rest[start + id.len()..];
        }
        PreEscaped(out + &html! { (rest) }.0)
    }

    /// Renders a list of descriptions, selected by name.
    pub(super) fn descriptions(texts: &NamedTexts, names: &[&str]) -> Markup {
        html! {
            dl.kinds { @for &name in names { dt { span.chip { (name) } } dd { (texts[name]) } } }
        }
    }

    pub(super) fn list(&self, part: &str, contents: &Markup) -> SiteFile {
        let mut parts = self.library.texts.navigation.iter();
        let entry = parts.find(|(_, name)| name == part);
        let (path, _) = entry.expect("the navigation contains this part");
        self.page(path, part, part, &html! { h1 { (part) } (contents) })
    }

    /// Renders the page for an id, with a link to the list page of `part`.
    pub(super) fn entry(&self, part: &str, id: &str, title: &str, contents: &Markup) -> SiteFile {
        let path = self.library.page_url(id).expect("every subject has a page");
        let kicker = html! { p.kicker { a href="index.html" { (part) } } };
        self.page(path, part, title, &html! { (kicker) (contents) })
    }

    /// Renders a complete page. `path` is the path of the page, and `part` is the part of the site that it belongs to.
    pub(super) fn page(&self, path: &str, part: &str, title: &str, body: &Markup) -> SiteFile {
        let root = self.root;
        let markup = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    meta name="generator" content=(concat!("ptm-conform ", env!("CARGO_PKG_VERSION")));
                    title { (title) " — PTM 1.2" }
                    link rel="icon" href="data:,";
                    link rel="stylesheet" href={ (root) "style.css" };
                    script src={ (root) "site.js" } defer {}
                }
                body.site data-root=(root) {
                    a.skip href="#main" { "Skip to the content" }
                    (self.head(part))
                    main #main tabindex="-1" { (body) }
                    footer {
                        p { "Generated by ptm-conform " (env!("CARGO_PKG_VERSION")) " from the files of its suite. The pages load nothing from a server." }
                    }
                }
            }
        };
        SiteFile::new(path, markup.into_string())
    }

    pub(super) fn head(&self, part: &str) -> Markup {
        let root = self.root;
        let parts = self.library.texts.navigation.iter();
        let parts = parts.map(|(url, name)| (url.as_str(), name.as_str()));
        let drop = self.has_drop_page.then_some(("drop.html", "Drop a file"));
        let parts = parts.chain(drop);
        html! {
            header.top {
                div.bar {
                    a.brand href={ (root) "index.html" } { "PTM 1.2, annotated and tested" }
                    button #theme type="button" aria-pressed="false" title="Dark or light mode" { "◐ " span { "Dark or light mode" } }
                }
                nav aria-label="Parts of the site" {
                    @for (url, name) in parts {
                        a href={ (root) (url) } aria-current=[(name == part).then_some("page")] { (name) }
                    }
                }
                search {
                    label for="search" { "Search" }
                    input #search type="search" placeholder="an id or a word" autocomplete="off" spellcheck="false"
                        role="combobox" aria-expanded="false" aria-controls="hits" aria-autocomplete="list";
                    ul #hits role="listbox" aria-label="Pages found" hidden {}
                }
            }
        }
    }
}
