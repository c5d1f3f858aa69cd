#[cfg(all(unix, feature = "cli"))]
mod html;

#[cfg(all(unix, feature = "cli"))]
mod html_browser;

#[cfg(all(unix, feature = "cli"))]
mod shards;

#[cfg(all(unix, feature = "cli"))]
mod text;

#[cfg(all(unix, feature = "cli"))]
mod readme_picture;
