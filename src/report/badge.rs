//! SVG badges that display scores instead of one percentage.

use maud::html;

use ptm_harness::report::document::{Report, Verdict};
use ptm_suite::name::SuiteName;
use ptm_suite::verdicts::scores::Fraction;

/// Width of a letter in tenths of a pixel. The `textLength` attribute enforces this width in every font.
const LETTER_WIDTH: usize = 59;
/// Margin to the left and right of each label, in pixels.
const MARGIN: usize = 4;

/// Renders a report as an SVG badge, 20 pixels high and at most 250 pixels wide. The badge contains the verdict, the correctness
/// score and, if the decoder lacks features, their breadth. Its title lists all scores.
#[must_use]
pub fn badge(report: &Report) -> String {
    let label = match report.suite {
        SuiteName::Ptm => "PTM 1.2",
        SuiteName::Texture => "PEX",
        SuiteName::Writers => "PTM write",
        SuiteName::Fitters => "PTM fit",
    };
    let scores = &report.scores;
    let passed = report.verdict == Verdict::Pass;
    let Fraction { part, whole } = scores.breadth;
    let mark = if passed { "✓" } else { "✗" };
    let score_text = match &report.reason {
        Some(_) => report.verdict.to_string(),
        None if part < whole => {
            format!("{mark} {}, {part} of {whole} features", scores.correctness)
        }
        None => format!("{mark} {}", scores.correctness),
    };
    let color = if passed { "#1d6b3f" } else { "#a8281c" };
    let width = |text: &str| text.chars().count() * LETTER_WIDTH / 10;
    let (left, right) = (width(label) + 2 * MARGIN, width(&score_text) + 2 * MARGIN);
    let command = &report.decoder.command;
    let title = format!("{command}: {}; {scores}", report.verdict);
    let markup = html! {
        svg xmlns="http://www.w3.org/2000/svg" width=(left + right) height="20" role="img" aria-label=(title) {
            title { (title) }
            clipPath id="round" { rect width=(left + right) height="20" rx="3" {} }
            g clip-path="url(#round)" {
                rect width=(left) height="20" fill="#3b4046" {}
                rect x=(left) width=(right) height="20" fill=(color) {}
            }
            g fill="#fff" font-family="Verdana,DejaVu Sans,sans-serif" font-size="10" {
                text x=(MARGIN) y="13" textLength=(width(label)) { (label) }
                text x=(left + MARGIN) y="13" textLength=(width(&score_text)) { (score_text) }
            }
        }
    };
    markup.into_string() + "\n"
}
