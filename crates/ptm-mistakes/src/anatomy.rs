//! Files and their header fields, for misreadings that edit bytes.

use std::borrow::Cow;

use ptm::Field;
use ptm::decode::fields_as;
use ptm::reading::Reading;

/// Empty list of clauses, for which [`Anatomy::respell`] selects every header field.
pub const ANY: &[&str] = &[];

/// The file as a decoder with a mistake sees it.
pub enum EditedFile {
    /// The decoder refuses the file.
    Refused,
    /// The decoder reads the file as if it contained these bytes.
    File(Vec<u8>),
}

/// A file and its fields.
pub struct Anatomy<'a> {
    /// Contents of the file.
    pub file: &'a [u8],
    /// Fields of the file, up to the first error.
    pub fields: Cow<'a, [Field]>,
}

impl<'a> Anatomy<'a> {
    /// Parses the fields of `file` under a reading of the open questions.
    #[must_use]
    pub fn new(file: &'a [u8], reading: &Reading) -> Anatomy<'a> {
        Anatomy {
            file,
            fields: Cow::Owned(fields_as(file, reading)),
        }
    }

    /// Returns the unchanged file.
    #[must_use]
    pub fn unchanged(&self) -> EditedFile {
        EditedFile::File(self.file.to_vec())
    }

    /// Returns a refusal if `refused` is true, or else the unchanged file.
    #[must_use]
    pub fn refuse_if(&self, refused: bool) -> EditedFile {
        if refused {
            EditedFile::Refused
        } else {
            self.unchanged()
        }
    }

    fn tokens(&self) -> impl Iterator<Item = &Field> {
        self.fields.iter().take_while(|field| {
            !matches!(
                field.clause,
                "2.5/3" | "2.7/1" | "2.8.1/1" | "2.9.8/2" | "2.9.8/4"
            )
        })
    }

    /// Returns the `n`th field with this clause in the header.
    #[must_use]
    pub fn nth_field(&self, clause: &str, n: usize) -> Option<&Field> {
        self.tokens().filter(|field| field.clause == clause).nth(n)
    }

    /// Returns the text of each header field with one of these clauses.
    #[must_use]
    pub fn field_texts(&self, clauses: &[&str]) -> Vec<&'a str> {
        let selected = self
            .tokens()
            .filter(|field| clauses.contains(&field.clause));
        selected
            .filter_map(|field| std::str::from_utf8(&self.file[field.range.clone()]).ok())
            .collect()
    }

    /// Returns a refusal if `is_refused` returns true for the text of a header field with one of these clauses.
    pub(super) fn refuse_text(&self, clauses: &[&str], is_refused: fn(&str) -> bool) -> EditedFile {
        self.refuse_if(self.field_texts(clauses).into_iter().any(is_refused))
    }

    /// Returns the offset of the payload, which starts after the line feed of the last header line.
    #[must_use]
    pub fn payload_offset(&self) -> usize {
        let end = self.tokens().last().map_or(0, |field| field.range.end);
        let line_feed = self.file[end..].iter().position(|&byte| byte == b'\n');
        line_feed.map_or(self.file.len(), |length| end + length + 1)
    }

    /// Returns the bytes of the header.
    #[must_use]
    pub fn header(&self) -> &'a [u8] {
        &self.file[..self.payload_offset()]
    }

    /// Returns the bytes after the header.
    pub(super) fn payload(&self) -> &'a [u8] {
        &self.file[self.payload_offset()..]
    }

    pub(super) fn with_payload(&self, payload: &[u8]) -> EditedFile {
        EditedFile::File([self.header(), payload].concat())
    }

    /// Returns the bytes between the `n`th field with this clause and the next field.
    #[must_use]
    pub fn bytes_after(&self, clause: &str, n: usize) -> &'a [u8] {
        let mut fields = self
            .tokens()
            .skip_while(|field| field.clause != clause)
            .skip(n);
        let start = fields.next().map(|field| field.range.end);
        let end = fields.next().map(|field| field.range.start);
        start.map_or(&[], |start| {
            &self.file[start..end.unwrap_or(self.payload_offset())]
        })
    }

    /// Replaces the text of each header field with one of these clauses, or of every header field for [`ANY`]. `spell` returns
    /// the new text, or `None` to keep the old one.
    ///
    /// Fields after an error are unknown, so the replacement is repeated until the file no longer changes.
    pub(super) fn respell(
        &self,
        clauses: &[&str],
        spell: fn(&str) -> Option<String>,
    ) -> EditedFile {
        let mut file = self.file.to_vec();
        let mut respelled = self.respell_known(clauses, spell);
        for _ in 1..40 {
            if respelled == file {
                break;
            }
            file = respelled;
            respelled = Anatomy::new(&file, &Reading::SPEC).respell_known(clauses, spell);
        }
        EditedFile::File(respelled)
    }

    /// Returns the file with the text of each known header field with one of these clauses replaced.
    fn respell_known(&self, clauses: &[&str], spell: fn(&str) -> Option<String>) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.file.len());
        let mut at = 0;
        let matches = |field: &&Field| clauses.is_empty() || clauses.contains(&field.clause);
        for field in self.tokens().filter(matches) {
            let text = std::str::from_utf8(&self.file[field.range.clone()]).unwrap_or_default();
            if let Some(text) = spell(text) {
                bytes.extend_from_slice(&self.file[at..field.range.start]);
                bytes.extend_from_slice(text.as_bytes());
                at = field.range.end;
            }
        }
        bytes.extend_from_slice(&self.file[at..]);
        bytes
    }
}
