//! Tests of the site: examples are correct, links are valid, and pages work in a browser.

#![cfg(unix)]

mod annotated;
mod browser;
mod pages;

use std::sync::LazyLock;

use ptm_conform::site::{SiteFile, build};

/// Files of the site, which is built once for all tests.
static SITE: LazyLock<Vec<SiteFile>> =
    LazyLock::new(|| build(None, None, 2).expect("the site is built"));
