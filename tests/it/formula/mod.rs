#![cfg(all(unix, feature = "cli"))]

mod equality;
