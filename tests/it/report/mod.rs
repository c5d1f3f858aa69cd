#![cfg(all(unix, feature = "cli"))]

mod html;
mod html_browser;
mod readme_image;
mod shards;
mod text;
