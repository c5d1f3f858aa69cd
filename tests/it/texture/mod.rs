#![cfg(unix)]

mod decoders;
mod gpu;
mod properties;
mod recordings;
mod suite;
