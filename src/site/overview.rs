//! Diagram of the file format, and the steps from bytes to an image.

use maud::{Markup, html};

use super::page::PageContext;

/// Renders a diagram of each kind of file. Every part links to its chapter.
pub(super) fn drawing(context: PageContext) -> Markup {
    html! {
        div.drawings {
            @for drawing in &context.library.texts.drawings {
                @let text = drawing.text.iter().map(|part| (part, "line"));
                @let parts = text.chain(drawing.bytes.iter().map(|part| (part, "data")));
                @let height = 30 * parts.clone().count() + 34;
                svg.file viewBox={ "0 0 300 " (height) } role="group" aria-label={ "Parts of a file: " (drawing.name) } {
                    text.name x="2" y="20" { (drawing.name) }
                    @for (i, ((part, section), class)) in parts.enumerate() {
                        @let y = 32 + 30 * i;
                        @let url = context.library.page_url(section).unwrap_or_default();
                        a href={ (context.root) (url) } {
                            rect class=(class) x="2" y=(y) width="296" height="26" rx="4" {}
                            text x="12" y=(y + 18) { (part) }
                            text.section x="288" y=(y + 18) text-anchor="end" { (section) }
                        }
                    }
                }
            }
        }
        p.legend { span.swatch {} " text, one line each " span.swatch.data {} " bytes" }
    }
}

/// Renders the four steps from bytes to an image.
pub(super) fn flow(context: PageContext) -> Markup {
    html! {
        ol.flow { @for (step, method, id) in &context.library.texts.flow { li { b { (step) } br; (method) " " span.quiet { (context.link_as(id, &html! { (id) })) } } } }
    }
}
