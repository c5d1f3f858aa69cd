//! Escapes file names, so that no name can move the cursor or forge a line of output.

use std::ffi::OsStr;
use std::fmt::Write as _;

/// Escapes control characters, bidirectional marks, line separators, and bytes that are not UTF-8. A backslash that is not
/// a separator is doubled, so the escapes are unambiguous.
#[must_use]
pub fn escape_name(name: &OsStr) -> String {
    let mut out = String::new();
    for chunk in name.as_encoded_bytes().utf8_chunks() {
        for character in chunk.valid().chars() {
            match character {
                '\\' if !cfg!(windows) => out.push_str("\\\\"),
                _ if is_control_character(character) => out.extend(character.escape_default()),
                _ => out.push(character),
            }
        }
        for byte in chunk.invalid() {
            let _ = write!(out, "\\x{byte:02x}");
        }
    }
    out
}

/// Returns true if a terminal or an editor interprets this character instead of displaying it.
fn is_control_character(character: char) -> bool {
    character.is_control()
        || matches!(character, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
}

/// Converts a name to the path of a URI. All bytes except unreserved characters and separators are percent-encoded.
pub(crate) fn as_uri(name: &OsStr) -> String {
    let mut out = String::new();
    let bytes = name.as_encoded_bytes();
    if bytes.starts_with(b"/") {
        out.push_str("file://");
    }
    for &byte in bytes {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                out.push(byte.into());
            }
            b'\\' if cfg!(windows) => out.push('/'),
            _ => out.extend(format!("%{byte:02X}").chars()),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn invalid_bytes_and_backslashes_are_distinguishable() {
        use std::os::unix::ffi::OsStrExt;
        assert_eq!(escape_name(OsStr::from_bytes(b"a\xffb")), "a\\xffb");
        assert_eq!(escape_name(OsStr::new("a\\xffb")), "a\\\\xffb");
        let uri = as_uri(OsStr::from_bytes(b"/a b/\xff%.ptm"));
        assert_eq!(uri, "file:///a%20b/%FF%25.ptm");
    }
}
