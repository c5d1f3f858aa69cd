//! Utilities that several modules share: threads, digests, YAML, messages of crashed programs.

pub mod digest;

#[cfg(unix)]
pub(crate) mod last_message;

pub mod parallel;

pub mod yaml;

/// Returns the message of an error without the error number of the operating system.
#[must_use]
pub fn strip_os_error_code(error: &dyn std::fmt::Display) -> String {
    let text = error.to_string();
    let (message, _) = text.split_once(" (os error").unwrap_or((&text, ""));
    message.to_owned()
}
