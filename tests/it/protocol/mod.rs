#![cfg(all(unix, feature = "cli"))]

mod frames;
