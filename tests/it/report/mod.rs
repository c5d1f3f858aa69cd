#![cfg(all(unix, feature = "cli"))]

mod html;
mod html_browser;
mod readme_picture;
mod shards;
mod text;
