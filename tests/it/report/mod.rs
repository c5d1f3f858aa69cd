#![cfg(unix)]

mod html;
mod html_browser;
mod readme_image;
mod scene;
mod shards;
mod text;
