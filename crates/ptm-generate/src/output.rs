//! Methods that write fields and record them, mirroring the methods of the reader.

use super::spelling::{Line, Spelling};
use ptm::Field;

/// A written file and its fields.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GeneratedFile {
    /// The bytes of the file.
    pub bytes: Vec<u8>,
    /// Fields that describe the meaning of each byte, in file order.
    pub fields: Vec<Field>,
    /// The offset of the first byte after the header text.
    pub payload: usize,
}

pub struct Output<'a> {
    /// The spelling of the header.
    pub spelling: &'a Spelling,
    bytes: Vec<u8>,
    fields: Vec<Field>,
    payload: Option<usize>,
}

impl<'a> Output<'a> {
    pub fn new(spelling: &'a Spelling) -> Output<'a> {
        Output {
            spelling,
            bytes: Vec::new(),
            fields: Vec::new(),
            payload: None,
        }
    }

    pub fn into_written(self) -> GeneratedFile {
        let payload = self.payload.unwrap_or(self.bytes.len());
        GeneratedFile {
            bytes: self.bytes,
            fields: self.fields,
            payload,
        }
    }

    /// Writes one field of the header.
    pub fn token(&mut self, clause: &'static str, name: &'static str, text: &str) {
        self.field(clause, name, text.as_bytes());
    }

    /// Writes numbers with gaps between them.
    pub fn numbers(&mut self, clause: &'static str, name: &'static str, texts: &[&str]) {
        for (i, text) in texts.iter().enumerate() {
            if i > 0 {
                self.gap();
            }
            self.token(clause, name, text);
        }
    }

    /// Writes numbers with the leading zeros of the spelling, after the sign.
    pub fn padded_numbers(&mut self, clause: &'static str, name: &'static str, texts: &[&str]) {
        let zeros = "0".repeat(self.spelling.leading_zeros);
        let padded = texts.iter().map(|text| {
            let (sign, digits) =
                text.split_at(text.len() - text.trim_start_matches(['+', '-']).len());
            format!("{sign}{zeros}{digits}")
        });
        let padded: Vec<String> = padded.collect();
        self.numbers(
            clause,
            name,
            &padded.iter().map(String::as_str).collect::<Vec<_>>(),
        );
    }

    /// Writes the spaces between two numbers (clause 2.4/5).
    pub fn gap(&mut self) {
        self.bytes
            .resize(self.bytes.len() + self.spelling.gap, b' ');
    }

    /// Writes the end of a line, with its optional space (clause 2.0/2).
    pub fn line_end(&mut self, line: Line) {
        if self.spelling.space_before_newline.contains(&line) {
            self.bytes.push(b' ');
        }
        self.bytes.push(b'\n');
    }

    /// Writes a line end if `two_lines` is true, or else a gap.
    pub fn line_end_or_gap(&mut self, two_lines: bool, line: Line) {
        if two_lines {
            self.line_end(line);
        } else {
            self.gap();
        }
    }

    /// Writes a field of the payload.
    pub fn put(&mut self, clause: &'static str, name: &'static str, bytes: &[u8]) {
        self.payload.get_or_insert(self.bytes.len());
        self.field(clause, name, bytes);
    }

    fn field(&mut self, clause: &'static str, name: &'static str, bytes: &[u8]) {
        let start = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.fields.push(Field {
            clause,
            name,
            range: start..self.bytes.len(),
        });
    }
}
