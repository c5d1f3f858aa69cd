#[cfg(all(unix, feature = "cli"))]
mod cmd;

#[cfg(all(unix, feature = "cli"))]
mod serve;

#[cfg(all(unix, feature = "cli"))]
mod trouble;

#[cfg(all(unix, feature = "cli"))]
mod zoo;
