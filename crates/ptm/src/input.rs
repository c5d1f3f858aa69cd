//! A reader that tracks its position in the bytes of a file.
//!
//! A header line consists of *tokens*, which are separated by *gaps* and terminated by a *line end*:
//!
//! - A token is a run of bytes other than space and line feed.
//! - A gap is one or more spaces (ruling `size-spelling`).
//! - A line end is a line feed, optionally preceded by one space (clause 2.0/2, ruling `header-line-end`).
//!
//! Tabs, carriage returns, leading blanks, empty lines and extra spaces are errors (ruling `header-blanks`).

use std::ops::Range;
use std::str::FromStr;

use crate::error::{Error, Kind, Result};
use crate::types::Field;

/// A file, the current position, and the fields read so far.
#[derive(Debug)]
pub struct Input<'a> {
    file: &'a [u8],
    at: usize,
    fields: Vec<Field>,
}

impl<'a> Input<'a> {
    /// Creates an input at the start of a file.
    #[must_use]
    pub fn new(file: &'a [u8]) -> Input<'a> {
        Input {
            file,
            at: 0,
            // Room for the fields of an uncompressed file.
            fields: Vec::with_capacity(64),
        }
    }

    /// Returns the offset of the next byte.
    #[must_use]
    pub fn at(&self) -> usize {
        self.at
    }

    pub(crate) fn into_fields(self) -> Vec<Field> {
        self.fields
    }

    /// Returns the unread rest of the file.
    #[must_use]
    pub fn rest(&self) -> &'a [u8] {
        &self.file[self.at..]
    }

    /// Reads the next token and records it as a field.
    pub(crate) fn token(&mut self, clause: &'static str, name: &'static str) -> Result<&'a [u8]> {
        let rest = self.rest();
        let length = rest
            .iter()
            .position(|byte| matches!(byte, b' ' | b'\n'))
            .unwrap_or(rest.len());
        if length == 0 {
            return Err(self.unexpected(clause, name));
        }
        self.fields.push(Field {
            clause,
            name,
            range: self.at..self.at + length,
        });
        self.at += length;
        Ok(&rest[..length])
    }

    /// Reads a token that must equal `word`.
    pub(crate) fn word(&mut self, clause: &'static str, word: &'static str) -> Result<()> {
        let start = self.at;
        if self.token(clause, word)? == word.as_bytes() {
            return Ok(());
        }
        self.at = start;
        Err(self.unexpected(clause, word))
    }

    /// Reads a finite decimal number (ruling `numbers`).
    pub(crate) fn number(&mut self, clause: &'static str, name: &'static str) -> Result<f64> {
        let start = self.at;
        let value = decimal(self.token(clause, name)?);
        value.ok_or_else(|| self.unexpected_at(start, clause, name))
    }

    /// Reads an integer, written in decimal digits with an optional sign. The integer must fit in `T`, which is `u32` or `i64`.
    pub(crate) fn integer<T: FromStr>(
        &mut self,
        clause: &'static str,
        name: &'static str,
    ) -> Result<T> {
        let start = self.at;
        let token = std::str::from_utf8(self.token(clause, name)?).ok();
        let value = token.and_then(|digits| digits.parse().ok());
        value.ok_or_else(|| self.unexpected_at(start, clause, name))
    }

    /// Reads a gap: one or more spaces.
    pub(crate) fn gap(&mut self, clause: &'static str) -> Result<()> {
        let spaces = self.rest().iter().take_while(|&&byte| byte == b' ').count();
        if spaces == 0 {
            return Err(self.unexpected(clause, "a space"));
        }
        self.at += spaces;
        Ok(())
    }

    /// Reads a line end: a line feed, optionally preceded by one space.
    pub(crate) fn line_end(&mut self, clause: &'static str) -> Result<()> {
        if !self.skip_line_end() {
            return Err(self.unexpected(clause, "the end of the line"));
        }
        Ok(())
    }

    /// Reads a gap or a line end, where the text allows either.
    pub(crate) fn gap_or_line_end(&mut self, clause: &'static str) -> Result<()> {
        if self.skip_line_end() {
            Ok(())
        } else {
            self.gap(clause)
        }
    }

    /// Reads the next `count` bytes of the payload as one field.
    ///
    /// # Errors
    /// Returns an error if fewer bytes remain.
    pub fn take(
        &mut self,
        clause: &'static str,
        name: &'static str,
        count: u64,
    ) -> Result<&'a [u8]> {
        let rest = self.peek_bytes(clause, name, count)?;
        self.fields.push(Field {
            clause,
            name,
            range: self.at..self.at + rest.len(),
        });
        self.at += rest.len();
        Ok(rest)
    }

    /// Reads the next `count` bytes of the payload. Records several fields, with ranges relative to the current position.
    pub(crate) fn take_parts(
        &mut self,
        clause: &'static str,
        name: &'static str,
        count: u64,
        parts: impl Iterator<Item = (&'static str, &'static str, Range<usize>)>,
    ) -> Result<&'a [u8]> {
        let rest = self.peek_bytes(clause, name, count)?;
        let start = self.at;
        self.fields.extend(parts.map(|(clause, name, range)| Field {
            clause,
            name,
            range: start + range.start..start + range.end,
        }));
        self.at += rest.len();
        Ok(rest)
    }

    /// Returns the next `count` bytes without consuming them, or an error if the file is too short. `count` may exceed
    /// the address space.
    fn peek_bytes(&self, clause: &'static str, what: &'static str, count: u64) -> Result<&'a [u8]> {
        let rest = self.rest();
        let remaining = rest.len();
        let bytes = usize::try_from(count)
            .ok()
            .and_then(|count| rest.get(..count));
        bytes.ok_or_else(|| {
            let kind = Kind::Short {
                what,
                needed: count,
                remaining,
            };
            Error::new(clause, self.at, kind)
        })
    }

    /// Returns the error for something other than `what` at the current position.
    pub(crate) fn unexpected(&self, clause: &'static str, what: &'static str) -> Error {
        self.unexpected_at(self.at, clause, what)
    }

    fn unexpected_at(&self, offset: usize, clause: &'static str, what: &'static str) -> Error {
        // Quote 1 to 24 bytes of the line, to make it recognizable.
        let rest = &self.file[offset..];
        let start = &rest[..rest.len().min(24)];
        let is_line_end = |i: &usize| *i > 0 && start[*i] == b'\n';
        let end = (0..start.len()).find(is_line_end).unwrap_or(start.len());
        let kind = match &start[..end] {
            [] => Kind::Ended { what },
            found => Kind::Expected {
                what,
                found: found.escape_ascii().to_string(),
            },
        };
        Error::new(clause, offset, kind)
    }

    /// Returns true if the next bytes are a line end.
    pub(crate) fn at_line_end(&self) -> bool {
        self.rest().starts_with(b"\n") || self.rest().starts_with(b" \n")
    }

    fn skip_line_end(&mut self) -> bool {
        let is_line_end = self.at_line_end();
        if is_line_end {
            self.at += if self.rest()[0] == b'\n' { 1 } else { 2 };
        }
        is_line_end
    }
}

/// Parses `[+-]?(d+.?d*|.d+)([eE][+-]?d+)?` with a finite value.
fn decimal(token: &[u8]) -> Option<f64> {
    // For these characters, the standard library accepts exactly this grammar. The check excludes `inf`, `infinity` and `nan`.
    let text = std::str::from_utf8(token).ok()?;
    if text
        .bytes()
        .any(|byte| !matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E'))
    {
        return None;
    }
    text.parse().ok().filter(|value: &f64| value.is_finite())
}
