//! Utilities that several modules share: threads, digests, YAML, messages of crashed programs.

pub mod digest;
#[cfg(unix)]
pub(crate) mod last_message;
pub mod parallel;
pub mod yaml;

/// Returns the name and the text of files of a folder of the repository. They are embedded in the program, so that an installed
/// one needs no checkout.
macro_rules! embedded {
    ($folder:literal, $($name:literal),* $(,)?) => {
        &[$((
            $name,
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/", $folder, "/", $name)),
        )),*]
    };
}
pub(crate) use embedded;

/// Returns the message of an error without the error number of the operating system.
#[must_use]
pub fn strip_os_error_code(error: &dyn std::fmt::Display) -> String {
    let text = error.to_string();
    let (message, _) = text.split_once(" (os error").unwrap_or((&text, ""));
    message.to_owned()
}
