#![cfg(all(unix, feature = "cli"))]

mod usage;
