//! Pages for the documents of the repository.

use maud::{Markup, PreEscaped, html};
use pulldown_cmark::{Event, HeadingLevel, Options, Parser, Tag, TagEnd};

use super::page::{PageContext, SiteFile};

macro_rules! document {
    ($file:literal, $page:literal) => {
        ($file, $page, include_str!(concat!("../../", $file)))
    };
}

/// Documents: path in the repository, name of the page, and text.
const DOCUMENTS: &[(&str, &str, &str)] = &[
    document!("README.md", "index"),
    document!("docs/install.md", "install"),
    document!("docs/protocol.md", "protocol"),
    document!("docs/check.md", "check"),
    document!("docs/report.md", "report"),
    document!("docs/diagnosis.md", "diagnosis"),
    document!("docs/fuzz.md", "fuzz"),
    document!("docs/files.md", "files"),
    document!("docs/writers.md", "writers"),
    document!("docs/archives.md", "archives"),
    document!("docs/scale.md", "scale"),
    document!("docs/texture.md", "texture"),
    document!("docs/site.md", "site"),
    ("spec-cases/README.md", "spec-cases", ptm_spec_cases::README),
    (
        "spec-cases/texture/README.md",
        "spec-cases-texture",
        ptm_spec_cases::texture::README,
    ),
    document!("CONTRIBUTING.md", "contributing"),
    document!("CHANGELOG.md", "changelog"),
];

/// Image in the README: file name on the site, and bytes.
const README_IMAGE: (&str, &[u8]) = ("mistakes.png", include_bytes!("../../docs/mistakes.png"));

pub(super) fn pages(context: PageContext) -> Vec<SiteFile> {
    let page = |(file, name, text): &(&str, &str, &str)| {
        let (headings, markup) = render_document(file, text);
        let body = html! {
            nav.within aria-label="Documents" { @for (other, page, _) in DOCUMENTS { a href={ (page) ".html" } aria-current=[(page == name).then_some("page")] { (short_name(other)) } " " } }
            div.document { (markup) }
        };
        let path = format!("docs/{name}.html");
        context.page(&path, "Documentation", &headings[0], &body)
    };
    let image = SiteFile::new(format!("docs/{}", README_IMAGE.0), README_IMAGE.1);
    DOCUMENTS.iter().map(page).chain([image]).collect()
}

/// Returns every heading in the documents, its URL relative to the root of the site, and the name of its document.
pub(super) fn headings() -> impl Iterator<Item = (String, String, &'static str)> {
    DOCUMENTS.iter().flat_map(|(file, name, text)| {
        let (headings, _) = render_document(file, text);
        headings.into_iter().map(move |heading| {
            let url = format!("docs/{name}.html#{}", anchor(&heading));
            (heading, url, short_name(file))
        })
    })
}

fn short_name(file: &str) -> &str {
    file.trim_end_matches(".md").trim_start_matches("docs/")
}

/// Renders a document with links to pages of the site. Also returns the headings, beginning with the title.
fn render_document(file: &str, text: &str) -> (Vec<String>, Markup) {
    let mut headings = Vec::new();
    let mut heading: Option<(HeadingLevel, String)> = None;
    let mut inside_link = Vec::new();
    // Skip badges, which are images on other servers.
    let lines = text.lines().filter(|line| !line.starts_with("[!["));
    let text = lines.collect::<Vec<_>>().join("\n");
    let events = Parser::new_ext(&text, Options::ENABLE_TABLES).filter_map(|mut event| {
        match &mut event {
            Event::Start(Tag::Link { dest_url, .. }) => {
                let page = resolve_link(file, dest_url);
                inside_link.push(page.is_some());
                *dest_url = page?.into();
            }
            Event::End(TagEnd::Link) if inside_link.pop() != Some(true) => return None,
            Event::Start(Tag::Image { dest_url, .. }) => *dest_url = README_IMAGE.0.into(),
            Event::Start(Tag::Heading { level, .. }) => {
                heading = Some((*level, String::new()));
                return None;
            }
            Event::End(TagEnd::Heading(_)) => {
                let (level, text) = heading.take()?;
                // Add the anchor for links to the heading.
                let words = html! { (text) }.0;
                let element = format!("<{level} id=\"{}\">{words}</{level}>", anchor(&text));
                event = Event::Html(element.into());
                headings.push(text);
            }
            // Headings contain only text.
            Event::Text(text) | Event::Code(text) if heading.is_some() => {
                heading.as_mut()?.1.push_str(text);
                return None;
            }
            Event::Html(_) | Event::InlineHtml(_) => return None,
            _ => {}
        }
        Some(event)
    });
    let mut markup = String::new();
    pulldown_cmark::html::push_html(&mut markup, events);
    let table = "<div class=\"scroll\" tabindex=\"0\"><table class=\"list\">";
    let markup = markup
        .replace("<table>", table)
        .replace("</table>", "</table></div>")
        .replace("<pre>", "<pre tabindex=\"0\">")
        .replace("<th></th>", "<td></td>");
    (headings, PreEscaped(markup))
}

fn anchor(heading: &str) -> String {
    let mut anchor = heading.to_lowercase().replace(' ', "-");
    anchor.retain(|c| c.is_alphanumeric() || c == '-');
    anchor
}

/// Returns the target of a link in a document, as a link on the site. Returns `None` if the target is a file that has no page on
/// the site.
fn resolve_link(file: &str, link: &str) -> Option<String> {
    if link.starts_with('#') || link.starts_with("https://") {
        return Some(link.to_owned());
    }
    let folder = file.rsplit_once('/').map_or("", |(folder, _)| folder);
    let mut path: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
    let (target, anchor) = link.split_at(link.find('#').unwrap_or(link.len()));
    for part in target.split('/').filter(|&part| part != ".") {
        match part {
            ".." => drop(path.pop()),
            part => path.push(part),
        }
    }
    let target = path.join("/");
    let (_, page, _) = DOCUMENTS.iter().find(|(file, _, _)| *file == target)?;
    Some(format!("{page}.html{anchor}"))
}
