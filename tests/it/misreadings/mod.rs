#![cfg(all(unix, feature = "cli"))]

mod catalog;
mod totality;
