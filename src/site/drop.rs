//! The page for dropped files: the reference as WebAssembly, in a single self-contained page.
//!
//! It is made twice: for the site, with navigation, and as a standalone file.

use std::io::Write;

use data_encoding::BASE64;
use flate2::Compression;
use flate2::write::GzEncoder;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use sha2::{Digest, Sha256};

use super::paper::{Paper, SiteFile};
use crate::report::html::STYLE;

const SCRIPT: &str = include_str!("drop.js");
/// The script of every page.
const COMMON: &str = include_str!("site.js");

/// Returns the page of the site, and the standalone page.
///
/// # Errors
/// If `module` is not WebAssembly.
pub(super) fn pages(paper: Paper, module: &[u8]) -> Result<Vec<SiteFile>, String> {
    if !module.starts_with(b"\0asm") {
        return Err("the module is not WebAssembly".to_owned());
    }
    let packed = packed(module).map_err(|error| error.to_string())?;
    let page = |path: &str, own: bool| SiteFile {
        path: path.to_owned(),
        bytes: whole(paper, &packed, own).into_bytes(),
    };
    Ok(vec![
        page("drop.html", false),
        page("ptm-viewer.html", true),
    ])
}

fn packed(module: &[u8]) -> std::io::Result<String> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(module)?;
    Ok(BASE64.encode(&encoder.finish()?))
}

/// Returns the page. Its policy forbids all requests, and all scripts except those of the site.
fn whole(paper: Paper, packed: &str, own: bool) -> String {
    let digest = |script: &str| BASE64.encode(&Sha256::digest(script));
    let policy = format!(
        "default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; {}; base-uri 'none'; form-action 'none'",
        match own {
            true => format!("script-src 'sha256-{}' 'wasm-unsafe-eval'", digest(SCRIPT)),
            // The search index is a separate script.
            false => "script-src 'unsafe-inline' 'self' file: 'wasm-unsafe-eval'".to_owned(),
        }
    );
    let sections: Vec<&str> = paper
        .library
        .annotated
        .chapters
        .iter()
        .map(|chapter| chapter.section.as_str())
        .collect();
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(policy);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { "Drop a file — PTM 1.2" }
                link rel="icon" href="data:,";
                style { (PreEscaped(STYLE)) }
            }
            body.site data-root=[(!own).then_some("")] {
                a.skip href="#main" { "To the file" }
                @if !own { (paper.head("Drop a file")) }
                main #main tabindex="-1" { (contents(own)) }
                script #chapters type="application/json" { (PreEscaped(serde_json::json!(sections).to_string())) }
                script #module type="application/octet-stream" { (packed) }
                script { (PreEscaped(SCRIPT)) }
                @if !own { script { (PreEscaped(COMMON)) } }
            }
        }
    };
    markup.into_string()
}

fn contents(own: bool) -> Markup {
    html! {
        h1 { "Drop a PTM file" }
        p.lead { "It is read here, in your browser, by the reference decoder; it never leaves this machine." }
        @if !own { p { a href="ptm-viewer.html" download { "This page as one file" } ", for use without the site." } }
        p.dropzone {
            label for="file" { "A PTM file" } " " input #file type="file" accept=".ptm";
        }
        p #status role="status" aria-live="polite" { "Starting…" }
        div #result hidden {
            section #screen aria-labelledby="relight" {
                h2 #relight { "Under a light" }
                p.quiet { "Drag over the picture or the ball, or use the sliders." }
                div.relight {
                    canvas #picture role="img" aria-label="the map under the light" {}
                    div {
                        canvas #ball width="120" height="120" role="img" aria-label="the light on a ball" {}
                        p { label { "u, to the right " input #u type="range" min="-1" max="1" step="0.01" value="0"; } }
                        p { label { "v, up " input #v type="range" min="-1" max="1" step="0.01" value="0"; } }
                        output #light {}
                    }
                }
                h2 { "Beside the picture of your viewer" }
                p { label for="png" { "A PNG of the same map under the same light" } " " input #png type="file" accept="image/*"; }
                div #comparison hidden {
                    p #difference role="status" aria-live="polite" {}
                    div.relight { canvas #viewer role="img" aria-label="the picture of your viewer" {} canvas #heat role="img" aria-label="where they differ" {} }
                }
            }
            section aria-labelledby="says" { h2 #says { "What is said of it" } div #faults {} }
            section aria-labelledby="parts" { h2 #parts { "The file, field by field" } div #fields.scroll tabindex="0" {} }
        }
    }
}
