#![cfg(all(unix, feature = "cli"))]

mod decoders;
mod properties;
mod recordings;
mod suite;
