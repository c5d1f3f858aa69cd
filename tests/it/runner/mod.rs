#![cfg(all(unix, feature = "cli"))]

mod cmd;
mod serve;
mod trouble;
mod zoo;
