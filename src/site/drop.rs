//! The page for dropped files: the reference as WebAssembly, in a single self-contained page.
//!
//! It is made twice: for the site, with navigation, and as a standalone file.

use std::io::Write;

use data_encoding::BASE64;
use flate2::Compression;
use flate2::write::GzEncoder;
use maud::{DOCTYPE, PreEscaped, html};
use sha2::{Digest, Sha256};

use super::paper::{Paper, SiteFile};
use crate::report::html::STYLE;

const SCRIPT: &str = include_str!("drop.js");
const CONTENTS: &str = include_str!("drop.html");
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
    let page =
        |path: &str, standalone: bool| SiteFile::new(path, page_text(paper, &packed, standalone));
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
fn page_text(paper: Paper, packed: &str, standalone: bool) -> String {
    let digest = |script: &str| BASE64.encode(&Sha256::digest(script));
    let policy = format!(
        "default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; {}; base-uri 'none'; form-action 'none'",
        match standalone {
            true => format!("script-src 'sha256-{}' 'wasm-unsafe-eval'", digest(SCRIPT)),
            // The search index is a separate script.
            false => "script-src 'unsafe-inline' 'self' file: 'wasm-unsafe-eval'".to_owned(),
        }
    );
    let chapters = paper.library.annotated.chapters.iter();
    let sections: Vec<&str> = chapters.map(|chapter| &*chapter.section).collect();
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
            body.site data-root=[(!standalone).then_some("")] {
                a.skip href="#main" { "To the file" }
                @if !standalone { (paper.head("Drop a file")) }
                main #main tabindex="-1" { (PreEscaped(contents(standalone))) }
                script #chapters type="application/json" { (PreEscaped(serde_json::json!(sections).to_string())) }
                script #module type="application/octet-stream" { (packed) }
                script { (PreEscaped(SCRIPT)) }
                @if !standalone { script { (PreEscaped(COMMON)) } }
            }
        }
    };
    markup.into_string()
}

/// Returns the contents of the page, without the indentation of their source; the standalone page has no link to itself.
fn contents(standalone: bool) -> String {
    let lines = CONTENTS.lines().map(str::trim_start);
    lines
        .filter(|line| !standalone || !line.contains("ptm-viewer.html"))
        .collect()
}
