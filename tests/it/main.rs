//! One binary for all integration tests; folders are named after the `src` modules that they test.

#[cfg(all(unix, feature = "cli"))]
mod common;
#[cfg(feature = "harness")]
mod in_process;
#[cfg(feature = "generate")]
mod random;
mod skip;
mod table;

mod cli;
mod codec;
mod decode;
mod diagnose;
mod formula;
mod fuzz;
mod misreadings;
mod packages;
mod protocol;
mod readers;
#[cfg(feature = "harness")]
mod recordings;
mod report;
mod repository;
mod runner;
mod session;
mod site;
mod suite;
mod texture;
mod tools;
mod writers;
