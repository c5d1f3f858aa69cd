//! One binary for all integration tests; folders are named after the crates and modules that they test.

#[cfg(unix)]
mod common;
mod in_process;
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
mod pipeline;
mod protocol;
mod readers;
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
