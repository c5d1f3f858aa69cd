//! HTML page skeleton and symbols for outcomes.

use data_encoding::BASE64;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use sha2::{Digest, Sha256};

use ptm_harness::report::document::Verdict;
use ptm_suite::address::published_url;
use ptm_suite::verdicts::outcome::Outcome;

/// Style sheet of the reports and of the site.
pub const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("report.js");

pub(super) fn complete_page(title: &str, body: &Markup) -> String {
    let digest = BASE64.encode(&Sha256::digest(SCRIPT));
    let policy = format!(
        "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-{digest}'; base-uri 'none'; form-action 'none'"
    );
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(policy);
                meta name="viewport" content="width=device-width, initial-scale=1";
                // Followed links do not reveal the location of the report.
                meta name="referrer" content="no-referrer";
                meta name="color-scheme" content="light dark";
                meta name="generator" content=(concat!("ptm-conform ", env!("CARGO_PKG_VERSION")));
                title { (title) }
                // No icon, so that browsers do not request one.
                link rel="icon" href="data:,";
                style { (PreEscaped(STYLE)) }
            }
            body {
                a.skip href="#main" { "Skip to the results" }
                (body)
                script { (PreEscaped(SCRIPT)) }
            }
        }
    };
    markup.into_string()
}

/// Links `words` to a page of the published site, or returns `words` if there is no page. Names in a report are untrusted.
pub(super) fn link(page: Option<String>, words: &Markup) -> Markup {
    match page {
        Some(page) => html! { a href=(published_url(&page)) { (words) } },
        None => words.clone(),
    }
}

/// Returns a symbol for an outcome, so that outcomes are not distinguished by color alone.
pub(super) fn mark(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "✓",
        Outcome::Fail => "✗",
        Outcome::ImplementationDefined => "≠",
        Outcome::Inconclusive => "?",
        Outcome::Unsupported => "–",
        Outcome::OtherDialect => "≈",
        Outcome::Assumed => "=",
        Outcome::NotJudged => "·",
        Outcome::NotRun => "○",
    }
}

pub(super) fn verdict_mark(verdict: Verdict) -> &'static str {
    if verdict == Verdict::Pass {
        "✓"
    } else {
        "✗"
    }
}
