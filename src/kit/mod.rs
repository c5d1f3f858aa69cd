//! Shared by several modules: work on all threads, digests, YAML, last messages of crashed programs.

pub mod digest;

#[cfg(unix)]
pub(crate) mod last_words;

pub mod parallel;

pub mod yaml;

/// Returns the message of an error without the number that the operating system gives it.
#[must_use]
pub fn without_code(error: &dyn std::fmt::Display) -> String {
    let text = error.to_string();
    let (message, _) = text.split_once(" (os error").unwrap_or((&text, ""));
    message.to_owned()
}
