//! Home page of the site.

use maud::html;

use super::objects;
use super::overview;
use super::page::{PageContext, SiteFile};

/// URL of an archived copy of the specification.
const SPECIFICATION: &str =
    "https://web.archive.org/web/2012/http://www.hpl.hp.com/research/ptm/downloads/PtmFormat12.pdf";

pub(super) fn page(context: PageContext) -> SiteFile {
    let library = context.library;
    let counts = [
        library.clauses.len(),
        library.suite.cases.len(),
        ptm_mistakes::all().count(),
        library.rulings.len(),
        library.readers().len(),
    ];
    let body = html! {
        h1 { "Polynomial Texture Maps, PTM 1.2" }
        p.lead {
            "A Polynomial Texture Map (PTM) is an image that can be relit: six numbers per texel describe its response to light. Museums and archives use it for "
            "Reflectance Transformation Imaging (RTI). This site explains and tests the format, rule by rule."
        }
        p {
            "The specification is " cite { "Polynomial Texture Map (.ptm) File Format" } ", Tom Malzbender and Dan Gelb, Hewlett-Packard Laboratories, version 1.2, November 2001 ("
            a href=(SPECIFICATION) { "archived copy" } "). It leaves some questions open, and readers answer them differently. "
            "The suite and its tools are " a href=(env!("CARGO_PKG_REPOSITORY")) { "ptm-conform" } "."
        }
        div.hero {
            (objects::home(context))
            p.quiet { "The same file in two decoders. To move the light, drag over an image or the dial, or use the arrow keys." }
        }
        ul.doors { @for ((url, name), count) in library.texts.counts.iter().zip(counts) { li { a href=(url) { b { (count) } " " (name) } } } }
        h2 { "File structure" }
        (overview::drawing(context))
        h2 { "From bytes to an image" }
        (overview::flow(context))
        h2 { "Getting started" }
        ul {
            li { "To write a reader, read " a href="format/index.html" { "the format" } " (start with the first chapter), implement " (context.protocol()) " in your program, and test it with " a href="docs/check.html" { code { "ptm-conform check" } } "." }
            li { "If a file looks wrong, " @if context.has_drop_page { a href="drop.html" { "drop it on this page" } ", or " } "run " code { "ptm-conform lint FILE" } ". See the list of " a href="codes/index.html" { "codes" } " for their meanings." }
            li { "If a program displays a file incorrectly, find the mistake among the " a href="misreadings/index.html" { "misreadings" } ", or see " a href="scoreboard.html" { "the results of public readers" } "." }
            li { "To map a PTM onto a surface, read " a href="texture/index.html" { "the texture chapter" } "." }
        }
    };
    context.page("index.html", "", "Polynomial Texture Maps", &body)
}
