#![cfg(all(unix, feature = "cli"))]

mod properties;
mod rare;
