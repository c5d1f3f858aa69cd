//! What several rooms need and none owns: work on all threads, digests, YAML at the door, last words.

pub mod digest;

#[cfg(unix)]
pub(crate) mod last_words;

pub mod parallel;

pub mod yaml;
