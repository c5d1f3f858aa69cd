#![cfg(unix)]

mod properties;
mod rare;
