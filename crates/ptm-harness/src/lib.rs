#![doc = include_str!("../README.md")]
#![cfg(unix)]

pub mod diagnose;
pub mod fuzz;
pub mod pipeline;
pub mod report;
pub mod runner;
pub mod session;
pub mod strength;
