//! Three scores on a badge; never one percentage.

use maud::html;

use crate::report::document::Report;

/// The width of a letter in tenths of a pixel; `textLength` makes it so whatever the font.
const LETTER: usize = 64;

/// An SVG picture, 20 pixels high: the verdict, then correctness, breadth and robustness.
#[must_use]
pub fn badge(report: &Report) -> String {
    let label = report.suite.short();
    let sign = if report.verdict == "pass" {
        "✓"
    } else {
        "✗"
    };
    let scores = &report.scores;
    let says = match &report.reason {
        Some(_) => format!("{sign} {}", report.verdict),
        None => format!(
            "{sign} correct {} · breadth {} · robust {}",
            scores.correctness, scores.breadth, scores.robustness
        ),
    };
    let color = if report.verdict == "pass" {
        "#1d6b3f"
    } else {
        "#a8281c"
    };
    let width = |text: &str| text.chars().count() * LETTER / 10;
    let (left, right) = (width(label) + 12, width(&says) + 12);
    let title = format!(
        "{}: {}; correctness {}, breadth {}, robustness {}",
        report.decoder.command,
        report.verdict,
        scores.correctness,
        scores.breadth,
        scores.robustness
    );
    let markup = html! {
        svg xmlns="http://www.w3.org/2000/svg" width=(left + right) height="20" role="img" aria-label=(title) {
            title { (title) }
            clipPath id="round" { rect width=(left + right) height="20" rx="3" {} }
            g clip-path="url(#round)" {
                rect width=(left) height="20" fill="#3b4046" {}
                rect x=(left) width=(right) height="20" fill=(color) {}
            }
            g fill="#fff" font-family="Verdana,DejaVu Sans,sans-serif" font-size="11" {
                text x="6" y="14" textLength=(width(label)) { (label) }
                text x=(left + 6) y="14" textLength=(width(&says)) { (says) }
            }
        }
    };
    markup.into_string() + "\n"
}
