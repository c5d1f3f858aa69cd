//! A drawing of the file, and the steps from bytes to an image.

use maud::{Markup, html};

use super::paper::Paper;

/// A kind of file: its name, and its parts, each with the section that describes it.
const KINDS: &[(&str, &[(&str, &str, bool)])] = &[
    (
        "RGB, LRGB, LUM",
        &[
            ("PTM_1.2", "2.1", false),
            ("PTM_FORMAT_…", "2.2", false),
            ("width, height", "2.3", false),
            ("six scales", "2.4", false),
            ("six biases", "2.4", false),
            ("LUM: 16 numbers of a matrix", "2.6", false),
            ("texels, bottom row first", "2.7", true),
        ],
    ),
    (
        "PTM_LUT, PTM_C_LUT",
        &[
            ("PTM_1.2", "2.1", false),
            ("PTM_FORMAT_…", "2.2", false),
            ("width, height", "2.3", false),
            ("six scales", "2.4", false),
            ("six biases", "2.4", false),
            ("number of entries", "2.5", false),
            ("entries", "2.5", true),
            ("an index for each texel", "2.8", true),
            ("PTM_LUT: colors", "2.8", true),
        ],
    ),
    (
        "JPEG_…, JPEGLS_…",
        &[
            ("PTM_1.2", "2.1", false),
            ("PTM_FORMAT_…", "2.2", false),
            ("width, height", "2.3", false),
            ("six scales", "2.4", false),
            ("six biases", "2.4", false),
            ("parameter", "2.9", false),
            ("transforms, motion, order,", "2.9", false),
            ("references, sizes, side sizes", "2.9", false),
            ("stream of plane 0", "2.9.8", true),
            ("its side information", "2.9.8", true),
            ("stream of plane 1 …", "2.9.8", true),
        ],
    ),
];

/// Returns a drawing of each kind of file; every part has a link to its chapter.
pub(super) fn drawing(paper: Paper) -> Markup {
    html! {
        div.drawings {
            @for (name, parts) in KINDS { (kind(paper, name, parts)) }
        }
        p.legend { span.swatch {} " text, a line each " span.swatch.data {} " bytes" }
    }
}

fn kind(paper: Paper, name: &str, parts: &[(&str, &str, bool)]) -> Markup {
    let height = 30 * parts.len() + 34;
    html! {
        svg.file viewBox={ "0 0 300 " (height) } role="group" aria-label={ "A file of " (name) } {
            text.name x="2" y="20" { (name) }
            @for (i, (what, section, data)) in parts.iter().enumerate() {
                @let y = 32 + 30 * i;
                @let place = paper.library.place(section).unwrap_or_default();
                a href={ (paper.root) (place) } {
                    rect class=(if *data { "data" } else { "line" }) x="2" y=(y) width="296" height="26" rx="4" {}
                    text x="12" y=(y + 18) { (what) }
                    text.section x="288" y=(y + 18) text-anchor="end" { (section) }
                }
            }
        }
    }
}

/// Returns the four steps from bytes to an image.
pub(super) fn flow(paper: Paper) -> Markup {
    let steps = [
        (
            "bytes → stored values",
            "18, 9 or 8 bytes for each texel",
            "2.7",
        ),
        (
            "stored values → coefficients",
            "(raw − bias) · scale",
            "2.4/8",
        ),
        (
            "coefficients → luminance or color",
            "the polynomial, in the light",
            "1.0/1",
        ),
        (
            "luminance → color",
            "L · RGB / 255, or a matrix; clamped at the end",
            "2.7.3/4",
        ),
    ];
    html! {
        ol.flow { @for (what, how, id) in steps { li { b { (what) } br; (how) " " span.quiet { (paper.link_as(id, &html! { (id) })) } } } }
    }
}
