//! The words of the format and of this suite.

use maud::html;

use super::paper::{Paper, SiteFile};

/// Each word with its definition, in alphabetical order.
pub(super) const WORDS: &[(&str, &str)] = &[
    (
        "bias",
        "What is subtracted from a stored coefficient (2.4/8). One of six integers.",
    ),
    (
        "block",
        "All values of one kind for all texels, in stored order (2.7.1/2, 2.7.3/1).",
    ),
    (
        "channel",
        "One plane seen as a component of a texel. A texel of an RGB map has 18, of an LRGB map 9, of a LUM map 8.",
    ),
    (
        "choice",
        "A ruling under which each listed reading is right, if a decoder keeps to one of them.",
    ),
    (
        "clause",
        "One rule of the format, with a permanent id: section and ordinal, such as 2.4/8.",
    ),
    (
        "coefficient",
        "One of the six numbers a0…a5 of a polynomial. Raw as it is stored, final after scale and bias (2.4/8).",
    ),
    ("component", "Of a JPEG stream: a plane has one (2.9.8/3)."),
    (
        "compression parameter",
        "A number for the encoder, which a decoder does not need (2.9.1/1).",
    ),
    (
        "dialect",
        "The readings that a decoder follows where there is a choice.",
    ),
    ("entry", "A row of the lookup table (2.5/4, 2.5/5)."),
    ("index", "The number of an entry, counted from 0 (2.8/1)."),
    (
        "intra coded",
        "Of a plane: not predicted from another one (2.9.5/2).",
    ),
    ("inversion", "v becomes 255 − v (2.9.2/3)."),
    (
        "lenient",
        "A ruling about files outside the specification: refusing one is right, and so is decoding it as the ruling says.",
    ),
    (
        "lu, lv",
        "The light: the first two components of the unit vector to it (1.0/2).",
    ),
    (
        "luminance",
        "The value of the polynomial where there is one for all three colors (2.7.3/4).",
    ),
    (
        "map",
        "The picture that a file describes: width times height texels.",
    ),
    (
        "misreading",
        "A plausible mistake in one clause. The suite has a faulty decoder for each.",
    ),
    (
        "motion vector",
        "A displacement of the reference, in half texels (2.9.3/2).",
    ),
    (
        "must",
        "A ruling that is settled: a decoder that reads otherwise fails.",
    ),
    (
        "order, rank",
        "Number i of the order list is the rank of plane i: when it is decoded (2.9.4/1).",
    ),
    ("payload", "What follows the header: bytes."),
    (
        "plane",
        "One value for every texel. Planes have the order of the format (2.9.8/1).",
    ),
    (
        "polynomial",
        "The six coefficients of a texel, or of one of its three colors, in the light (1.0/1).",
    ),
    (
        "predictor",
        "The reference plane, inverted and displaced as the transform says (2.9.2/1).",
    ),
    (
        "reading",
        "One way to understand a passage that leaves something open.",
    ),
    (
        "reference plane",
        "The plane from which another one is predicted (2.9.5/1).",
    ),
    (
        "residual",
        "What the stream of a predicted plane holds (2.9.5/4).",
    ),
    (
        "ruling",
        "How this suite reads what the text leaves open, and why.",
    ),
    (
        "scale",
        "What a coefficient is multiplied by after the bias was subtracted (2.4/8). One of six decimal numbers.",
    ),
    (
        "side information",
        "Records that correct single values of a plane (2.9.8/5).",
    ),
    (
        "stored order",
        "Bottom row first, each row from left to right (2.7.1/3).",
    ),
    (
        "stream",
        "A complete JPEG or JPEG-LS image that holds one plane (2.9.8/3).",
    ),
    ("texel", "One position of the map."),
    (
        "transform",
        "What is done to a reference before prediction: inversion, displacement, both or nothing (2.9.2/2).",
    ),
    (
        "twin",
        "The valid file that a damaged one is one edit away from.",
    ),
    (
        "view",
        "What a decoder is asked for: raw, coef or rgb under a light.",
    ),
];

/// Returns the anchor of a word on its page.
pub(super) fn anchor(word: &str) -> String {
    format!("w-{}", word.replace([' ', ','], "-"))
}

/// Returns the glossary.
pub(super) fn page(paper: Paper) -> SiteFile {
    let body = html! {
        h1 { "Glossary" }
        dl.glossary {
            @for (word, means) in WORDS { dt id=(anchor(word)) { (word) } dd { (paper.prose(means)) } }
        }
    };
    paper.page("glossary.html", "Glossary", "Glossary", &body)
}
