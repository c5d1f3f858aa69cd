//! Programs under test: starting them, limiting their resources, sending requests to them, and ending them.
//!
//! Requires a Unix system.

pub(crate) mod trouble;

pub mod processes;

pub(crate) mod call;

pub mod run;

pub mod write;

pub mod scratch;

pub mod serve;

pub mod caller;

pub mod start;

pub mod template;
