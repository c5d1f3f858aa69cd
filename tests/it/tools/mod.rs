#![cfg(all(unix, feature = "cli"))]

mod collections;
mod files;
mod hostile;
mod identification;
mod lint;
mod repair;
