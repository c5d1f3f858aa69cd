//! Shared by several modules: work on all threads, digests, YAML, last messages of crashed programs.

pub mod digest;

#[cfg(unix)]
pub(crate) mod last_words;

pub mod parallel;

pub mod yaml;
