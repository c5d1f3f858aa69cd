//! Capabilities that a decoder declares: `DECODER capabilities` (PTM-CP 1, optional).
//!
//! Capabilities are used only if the program prints YAML that contains `protocol: 1` and exits with 0. Any other result,
//! including a crash, a timeout or too much output, is not a failure, because the command is optional.

use crate::error::{Error, Result};
use serde::Deserialize;

use crate::kit::yaml::from_yaml;
use crate::protocol::frame::{EXIT_UNSUPPORTED, ViewKind};
use ptm::Format;

/// Maximum number of characters in a name or version.
const MAX_NAME_LENGTH: usize = 100;

/// Capabilities that a decoder declares. An optional value is `None` if the decoder does not declare it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Capabilities {
    /// Name of the decoder.
    pub name: Option<String>,
    /// Version of the decoder.
    pub version: Option<String>,
    /// Views that the decoder supports.
    pub views: Option<Vec<ViewKind>>,
    /// Formats that the decoder reads.
    pub formats: Option<Vec<Format>>,
    /// True if the decoder supports `serve`.
    pub serves: bool,
    /// True if a serving process may be sent several requests before it answers the first of them.
    pub pipelined: bool,
    /// Exit status for malformed files, in addition to 65.
    pub reject_exit: Option<i32>,
    /// Warnings about unknown words, one sentence each.
    pub remarks: Vec<String>,
}

/// The YAML document that the decoder prints. Other keys are ignored.
#[derive(Deserialize)]
#[serde(expecting = "a mapping with protocol: 1")]
struct CapabilitiesRecord {
    protocol: i64,
    name: Option<String>,
    version: Option<String>,
    views: Option<Vec<String>>,
    formats: Option<Vec<String>>,
    modes: Option<Vec<String>>,
    #[serde(default)]
    pipelined: bool,
    reject_exit: Option<i64>,
}

/// Removes control characters from a word, and limits its length.
fn remove_control_characters(word: &str) -> String {
    let chars = word.chars().filter(|c| !c.is_control());
    chars.take(MAX_NAME_LENGTH).collect()
}

impl Capabilities {
    /// Parses the output of `DECODER capabilities`.
    ///
    /// # Errors
    /// Returns the reason why the output is not a valid declaration.
    pub fn read(answer: &[u8]) -> Result<Capabilities> {
        let text = std::str::from_utf8(answer).map_err(|_| "the answer is not UTF-8".to_owned())?;
        let record: CapabilitiesRecord =
            from_yaml(text).map_err(|error| format!("the answer is not valid: {error}"))?;
        if record.protocol != 1 {
            return Error::invalid(format!(
                "the decoder speaks protocol {}, but this program speaks protocol 1",
                record.protocol
            ));
        }
        let mut remarks = Vec::new();
        let views = parse_words(record.views, "view", &mut remarks, ViewKind::from_name);
        let format = |word: &str| word.parse().ok();
        let formats = parse_words(record.formats, "format", &mut remarks, format);
        let mode = |word: &str| ["one-shot", "serve"].into_iter().find(|&mode| mode == word);
        let modes = parse_words(record.modes, "mode", &mut remarks, mode);
        let reject_exit = record.reject_exit.and_then(|status| {
            let valid = i32::try_from(status)
                .ok()
                .filter(|status| (1..=255).contains(status) && *status != EXIT_UNSUPPORTED);
            if valid.is_none() {
                remarks.push(format!("exit status {status} cannot mean a refusal"));
            }
            valid
        });
        Ok(Capabilities {
            name: record.name.as_deref().map(remove_control_characters),
            version: record.version.as_deref().map(remove_control_characters),
            views,
            formats,
            serves: modes.is_some_and(|modes| modes.contains(&"serve")),
            pipelined: record.pipelined,
            reject_exit,
            remarks,
        })
    }

    /// Returns true if the decoder declares support for `format`.
    #[must_use]
    pub fn declares(&self, format: Format) -> bool {
        self.formats
            .as_ref()
            .is_some_and(|formats| formats.contains(&format))
    }
}

fn parse_words<T>(
    words: Option<Vec<String>>,
    kind: &str,
    remarks: &mut Vec<String>,
    parse: impl Fn(&str) -> Option<T>,
) -> Option<Vec<T>> {
    let parse_word = |word: String| {
        let word = remove_control_characters(&word);
        let known = parse(&word);
        if known.is_none() && remarks.len() < 10 {
            remarks.push(format!("the decoder declares an unknown {kind}: {word:?}"));
        }
        known
    };
    Some(words?.into_iter().filter_map(parse_word).collect())
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use super::*;

    #[test]
    fn only_declared_capabilities_are_set() {
        let read = Capabilities::read(b"protocol: 1\nname: x\nversion: 1.10\nviews: [raw, png]\nmodes: [serve]\ncolour: blue\nreject_exit: 1\n");
        let capabilities = read.expect("it is valid");
        assert_eq!(capabilities.name.as_deref(), Some("x"));
        assert_eq!(capabilities.version.as_deref(), Some("1.10"));
        assert_eq!(capabilities.views, Some(vec![ViewKind::Raw]));
        assert_eq!(capabilities.formats, None);
        assert!(capabilities.serves && !capabilities.pipelined);
        assert_eq!(capabilities.reject_exit, Some(1));
        assert_eq!(
            capabilities.remarks,
            ["the decoder declares an unknown view: \"png\""]
        );
    }

    #[test]
    fn reserved_statuses_cannot_mean_refusal() {
        for status in ["0", "69", "256", "-1", "99999999999"] {
            let answer = format!("protocol: 1\nreject_exit: {status}\n");
            let capabilities = Capabilities::read(answer.as_bytes()).expect("it is valid");
            assert_eq!(capabilities.reject_exit, None, "{status}");
            assert_eq!(capabilities.remarks.len(), 1);
        }
    }

    /// The inputs include nested lists that would need terabytes of memory.
    #[test]
    fn invalid_declarations_are_rejected() {
        let mut laughs = "a: &a [x, x, x, x, x, x, x, x, x, x]\n".to_owned();
        for (this, last) in ('b'..='p').zip('a'..) {
            let list = vec![format!("*{last}"); 10].join(", ");
            let _ = writeln!(laughs, "{this}: &{this} [{list}]");
        }
        let _ = Capabilities::read(format!("protocol: 1\n{laughs}").as_bytes());
        let bomb = format!("protocol: 1\n{laughs}views: *p\n");
        let deep = format!("protocol: 1\nx: {}", "[".repeat(15_000));
        for (answer, says) in [
            (&b""[..], "not valid"),
            (b"usage: dec VIEW FILE\n", "not valid"),
            (b"name: x\n", "not valid"),
            (b"protocol: 2\n", "protocol 2"),
            (b"protocol: one\n", "not valid"),
            (b"protocol: 1\nviews: 3\n", "not valid"),
            (b"protocol: 1\npipelined: often\n", "not valid"),
            (b"PTM1 raw 1 1 1 u8\n\xff", "not UTF-8"),
            (b"protocol: 1\nprotocol: 1\n", "not valid"),
            (bomb.as_bytes(), "not valid"),
            (deep.as_bytes(), "not valid"),
        ] {
            let error = Capabilities::read(answer).expect_err("it is invalid");
            assert!(error.to_string().contains(says), "{error}");
        }
    }
}
