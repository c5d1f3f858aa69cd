//! The page of `lint --format html`: totals, a bar for each status and format, and a thumbnail and the findings of each file.
//!
//! Files are written one after the other, so the totals come last in the document; a style puts them first.

use std::time::{Duration, SystemTime};

use data_encoding::BASE64;
use image::ImageFormat;
use maud::{Markup, PreEscaped, html};

use ptm_files::lint::codes::Severity;
use ptm_files::lint::status::Status;
use ptm_files::lint::{Lint, totals::Totals};
use ptm_files::render::{self, encode_image};

/// Returns the beginning of the page. `folders` are the named files and folders.
#[must_use]
pub fn head(folders: &[String]) -> String {
    let title = match folders {
        [folder] => format!("PTM files in {folder}"),
        [folder, ..] => format!("PTM files in {folder} and {} others", folders.len() - 1),
        [] => "PTM files".to_owned(),
    };
    let made = format!("{}, ptm-conform {}", today(), env!("CARGO_PKG_VERSION"));
    let escaped = |text: String| html! { (text) }.into_string();
    include_str!("lint_page.html")
        .replace("MADE", &made)
        .replace("TITLE", &escaped(title))
}

/// Returns the date of the page. The variable `SOURCE_DATE_EPOCH` sets it, so that pages can be compared.
fn today() -> String {
    let seconds = std::env::var("SOURCE_DATE_EPOCH").ok();
    let seconds = seconds.and_then(|text| text.parse::<u32>().ok());
    let time = seconds.map_or_else(SystemTime::now, |seconds| {
        SystemTime::UNIX_EPOCH + Duration::from_secs(seconds.into())
    });
    let text = humantime::format_rfc3339_seconds(time).to_string();
    text[..10].to_owned()
}

/// Number of files with a thumbnail. More would make the page too large for a browser.
pub const MAX_THUMBNAILS: usize = 2000;

/// Longer side of a thumbnail in pixels.
const THUMBNAIL_SIDE: u32 = 96;

/// Returns a thumbnail of a map as a PNG in base64, or `None` if the file is not a legal map.
#[must_use]
pub fn thumbnail(file: &[u8]) -> Option<String> {
    let ptm = ptm::decode(file).ok()?;
    let image = render::thumbnail(&ptm, THUMBNAIL_SIDE);
    let bytes = encode_image(&image.into(), ImageFormat::Png).ok()?;
    Some(BASE64.encode(&bytes))
}

/// Returns the part of the page about a file.
#[must_use]
pub fn article(lint: &Lint, thumbnail: Option<&String>) -> Markup {
    let facts = [
        lint.format.map(str::to_owned),
        lint.width
            .zip(lint.height)
            .map(|(width, height)| format!("{width} × {height}")),
        lint.bytes.map(|bytes| format!("{bytes} bytes")),
    ];
    let facts: Vec<String> = facts.into_iter().flatten().collect();
    html! {
        article data-status=(lint.status.name()) {
            @match thumbnail {
                Some(image) => img loading="lazy" alt="" src={ "data:image/png;base64," (image) };,
                None => div.none {},
            }
            div {
                h2 { (lint.file) }
                p { (badge(lint.status)) " " (facts.join(", ")) }
                @if let Some(reason) = &lint.reason { p { (reason) } }
                @if let Some(repairable) = &lint.repairable {
                    @match repairable.strip_prefix("no: ") {
                        Some(why) => p { "Not repairable: " (why) },
                        None => p { "Repairable: " (repairable) },
                    }
                }
                @if !lint.findings.is_empty() {
                    ul {
                        @for finding in &lint.findings {
                            li {
                                @if finding.severity == Severity::Error { b { (finding.code) } } @else { (finding.code) }
                                ", byte " (finding.offset) ": " (finding.text())
                                @if !finding.fix.is_empty() { ". Fix: " (finding.fix) }
                            }
                        }
                    }
                }
                @for reader in &lint.readers {
                    p { "In " (reader.reader) ": " (reader.result.label()) " " (reader.fault) }
                }
            }
        }
        "\n"
    }
}

fn badge(status: Status) -> Markup {
    html! { b.status style={ "--color: var(--" (status.name()) ")" } { (status.label()) } }
}

/// Returns the end of the page, with the totals.
#[must_use]
pub fn tail(totals: &Totals) -> Markup {
    let bar = |name: &str, count: usize, color: Option<&str>| {
        let share = 100.0 * count as f64 / totals.files.max(1) as f64;
        let color = color.map_or(String::new(), |color| format!("; --color: var(--{color})"));
        html! {
            div.bar { span { (name) } span { i style={ "width: " (format!("{share:.2}")) "%" (color) } {} } span { (count) } }
        }
    };
    html! {
        header {
            p { (totals.files) " files" @if totals.others > 0 { "; " (totals.others) " in folders that are not PTM files were not checked" } }
            @for status in Status::ALL {
                @if totals.count(status) > 0 { (bar(status.label(), totals.count(status), Some(status.name()))) }
            }
            details {
                summary { "Formats" }
                @for (format, count) in totals.formats() { (bar(format.trim_start_matches("PTM_FORMAT_"), count, None)) }
            }
        }
        (PreEscaped("\n</html>\n"))
    }
}
