#![cfg(unix)]

mod decoders;
mod properties;
mod recordings;
mod suite;
