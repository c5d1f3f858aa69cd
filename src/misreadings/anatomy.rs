//! A file as the edits of bytes see it: its bytes, and what they are as far as they can be read.

use crate::decode::examine_as;
use crate::ptm::Field;
use crate::reading::Reading;

/// What a reader with a mistake makes of the bytes.
pub enum Seen {
    /// It refuses them.
    Refused,
    /// It reads them as if they were these.
    File(Vec<u8>),
}

/// A file and its header's parts, for mistakes that act on bytes.
pub struct Anatomy<'a> {
    /// The file.
    pub file: &'a [u8],
    /// Its fields as far as they can be read.
    pub fields: Vec<Field>,
}

impl<'a> Anatomy<'a> {
    /// Takes `file` apart under a reading of the open points.
    #[must_use]
    pub fn of(file: &'a [u8], reading: &Reading) -> Anatomy<'a> {
        Anatomy {
            file,
            fields: examine_as(file, reading).0,
        }
    }

    /// The file, unchanged.
    #[must_use]
    pub fn unchanged(&self) -> Seen {
        Seen::File(self.file.to_vec())
    }

    /// Refused if `refused`, else unchanged.
    #[must_use]
    pub fn refused_if(&self, refused: bool) -> Seen {
        if refused {
            Seen::Refused
        } else {
            self.unchanged()
        }
    }

    /// The header's fields: all before the first byte of the payload.
    fn tokens(&self) -> impl Iterator<Item = &Field> {
        self.fields.iter().take_while(|field| {
            !matches!(
                field.clause,
                "2.5/3" | "2.7/1" | "2.8.1/1" | "2.9.8/2" | "2.9.8/4"
            )
        })
    }

    /// The `n`th field of a clause in the header.
    #[must_use]
    pub fn field(&self, clause: &str, n: usize) -> Option<&Field> {
        self.tokens().filter(|field| field.clause == clause).nth(n)
    }

    /// The text of the fields of these clauses.
    #[must_use]
    pub fn texts(&self, clauses: &[&str]) -> Vec<&'a str> {
        let chosen = self
            .tokens()
            .filter(|field| clauses.contains(&field.clause));
        chosen
            .filter_map(|field| std::str::from_utf8(&self.file[field.range.clone()]).ok())
            .collect()
    }

    /// Where the payload starts: after the line feed that ends the last line of the header.
    #[must_use]
    pub fn payload(&self) -> usize {
        let end = self.tokens().last().map_or(0, |field| field.range.end);
        let line_feed = self.file[end..].iter().position(|&byte| byte == b'\n');
        line_feed.map_or(self.file.len(), |length| end + length + 1)
    }

    /// The header.
    #[must_use]
    pub fn header(&self) -> &'a [u8] {
        &self.file[..self.payload()]
    }

    /// The bytes between the `n`th field of a clause and the one after it.
    #[must_use]
    pub fn after(&self, clause: &str, n: usize) -> &'a [u8] {
        let mut from = self
            .tokens()
            .skip_while(|field| field.clause != clause)
            .skip(n);
        let start = from.next().map(|field| field.range.end);
        let end = from.next().map(|field| field.range.start);
        start.map_or(&[], |start| {
            &self.file[start..end.unwrap_or(self.payload())]
        })
    }

    /// The file with its header spelled anew: `spell` gives another text for a field, or none.
    ///
    /// A field that cannot be read ends the taking apart, so it goes on until nothing changes any more.
    pub fn respelled(&self, spell: fn(clause: &str, text: &str) -> Option<String>) -> Seen {
        let mut file = self.file.to_vec();
        for _ in 0..40 {
            let anatomy = Anatomy::of(&file, &Reading::SPEC);
            let mut bytes = Vec::new();
            let mut at = 0;
            for field in anatomy.tokens() {
                let text = std::str::from_utf8(&file[field.range.clone()]).unwrap_or_default();
                if let Some(text) = spell(field.clause, text) {
                    bytes.extend_from_slice(&file[at..field.range.start]);
                    bytes.extend_from_slice(text.as_bytes());
                    at = field.range.end;
                }
            }
            bytes.extend_from_slice(&file[at..]);
            if bytes == file {
                break;
            }
            file = bytes;
        }
        Seen::File(file)
    }
}
