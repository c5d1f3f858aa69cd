//! Page onto which users drop files. It is self-contained and includes the reference decoder as WebAssembly.
//!
//! The page is generated twice: with navigation, for the site, and as a standalone file.

use std::io::Write;

use data_encoding::BASE64;
use flate2::Compression;
use flate2::write::GzEncoder;
use maud::{DOCTYPE, PreEscaped, html};
use sha2::{Digest, Sha256};

use super::page::{PageContext, SiteFile};
use crate::report::html::STYLE;
use ptm::Format;
use ptm_harness::session::lit_scene;
use ptm_suite::cases::TableSpelling;

/// Commands that build the module and the site with this page.
const BUILD_COMMANDS: &str = "\
rustup target add wasm32-unknown-unknown
cargo build --release --target wasm32-unknown-unknown --manifest-path packages/wasm/Cargo.toml
ptm-conform site --out site --module packages/wasm/target/wasm32-unknown-unknown/release/ptm_conform_wasm.wasm";

const SCRIPT: &str = include_str!("drop.js");
const CONTENTS: &str = include_str!("drop.html");
/// Script shared by all pages of the site.
const SITE_SCRIPT: &str = include_str!("site.js");

/// Functions that the module exports and the page calls.
const EXPORTS: &str = "reserve open examine report report_length samples relight";

/// Renders the page of the site and the standalone page, or no page without a module. Returns an error if `module` is not the
/// reference decoder as WebAssembly.
pub(super) fn pages(context: PageContext, module: Option<&[u8]>) -> Result<Vec<SiteFile>, String> {
    let Some(module) = module else {
        return Ok(Vec::new());
    };
    check_module(module)
        .map_err(|fault| format!("--module: {fault}; to build it:\n{BUILD_COMMANDS}"))?;
    let packed = compress(module).map_err(|error| error.to_string())?;
    let samples = samples(context);
    let pages = [("drop.html", false), ("ptm-viewer.html", true)];
    let page =
        |(path, standalone)| SiteFile::new(path, page_text(context, &packed, &samples, standalone));
    Ok(pages.map(page).into())
}

/// Checks that a file is a WebAssembly module with the functions that the page calls.
fn check_module(module: &[u8]) -> Result<(), String> {
    if !module.starts_with(b"\0asm\x01\0\0\0") {
        return Err("the module is not WebAssembly".to_owned());
    }
    let is_exported = |name: &&str| {
        // In the binary format, a name consists of its length and its bytes.
        let entry = [&[name.len() as u8], name.as_bytes()].concat();
        module.windows(entry.len()).any(|window| window == entry)
    };
    match EXPORTS.split(' ').find(|name| !is_exported(name)) {
        None => Ok(()),
        Some(name) => Err(format!("the module has no function {name}")),
    }
}

/// Returns sample files as JSON: label, name and contents.
fn samples(context: PageContext) -> String {
    let sample = |label: &str, id: &str| {
        let case = context.library.suite.case(id).expect("the case exists");
        let file = &case.build(TableSpelling::default()).file;
        (label.to_owned(), format!("{id}.ptm"), BASE64.encode(file))
    };
    let ball = BASE64.encode(&lit_scene::SceneFile::all(Format::Lrgb)[0][0].bytes());
    let samples = [
        ("a legal file".to_owned(), "ball.ptm".to_owned(), ball),
        sample("a damaged file", "one-byte-short-lrgb"),
        sample("a file that is not a PTM", "not-a-ptm-lrgb"),
    ];
    serde_json::json!(samples).to_string()
}

fn compress(module: &[u8]) -> std::io::Result<String> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(module)?;
    Ok(BASE64.encode(&encoder.finish()?))
}

/// Renders the page. Its content security policy forbids all requests, except for the site's own scripts.
fn page_text(context: PageContext, packed: &str, samples: &str, standalone: bool) -> String {
    let digest = |script: &str| BASE64.encode(&Sha256::digest(script));
    let policy = format!(
        "default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; {}; base-uri 'none'; form-action 'none'",
        match standalone {
            true => format!("script-src 'sha256-{}' 'wasm-unsafe-eval'", digest(SCRIPT)),
            // The search index is loaded as a separate script.
            false => "script-src 'unsafe-inline' 'self' file: 'wasm-unsafe-eval'".to_owned(),
        }
    );
    let chapters = context.library.annotated.chapters.iter();
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
                a.skip href="#main" { "Skip to the file" }
                @if !standalone { (context.head("Drop a file")) }
                main #main tabindex="-1" { (PreEscaped(contents(standalone))) }
                script #chapters type="application/json" { (PreEscaped(serde_json::json!(sections).to_string())) }
                script #samples type="application/json" { (PreEscaped(samples)) }
                script #module type="application/octet-stream" { (packed) }
                script { (PreEscaped(SCRIPT)) }
                @if !standalone { script { (PreEscaped(SITE_SCRIPT)) } }
            }
        }
    };
    markup.into_string()
}

/// Returns the contents of the page without indentation. The standalone page has no link to itself.
fn contents(standalone: bool) -> String {
    let is_shown = |line: &&str| !standalone || !line.contains("ptm-viewer.html");
    let lines = CONTENTS.lines().map(str::trim_start);
    lines.filter(is_shown).collect()
}
