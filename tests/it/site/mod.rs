//! The site: its examples hold, its links lead somewhere, its pages work in a browser.

mod annotated;

#[cfg(all(unix, feature = "cli"))]
mod browser;

mod pages;
