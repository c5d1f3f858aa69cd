//! Utilities that several modules share: threads, digests, YAML, messages of crashed programs.

pub mod digest;
pub mod last_message;
pub mod parallel;
pub mod shard;
pub mod yaml;

/// Returns the message of an error without the error number of the operating system.
pub fn strip_os_error_code(error: &dyn std::fmt::Display) -> String {
    let text = error.to_string();
    let (message, _) = text.split_once(" (os error").unwrap_or((&text, ""));
    message.to_owned()
}

/// Escapes control characters other than line feeds and tabs, so that text from an untrusted source is safe to print.
#[must_use]
pub fn escape_controls(text: &str) -> String {
    let escape = |c: char| match c {
        '\n' | '\t' => c.to_string(),
        c if c.is_control() => c.escape_default().to_string(),
        c => c.to_string(),
    };
    text.chars().map(escape).collect()
}
