//! The meaning of every byte of a file, as far as it can be read: the fields of the reference decoder, with names for people.
//!
//! A field gets a [`Role`]: its index in its list, and the item that the list describes. If the file is damaged, the dissection
//! ends at the damage; a truncated payload is shown as far as it goes, because the header defines its layout.

use std::collections::HashMap;
use std::ops::Range;

use serde::Serialize;

use crate::decode::texels::blocks;
use crate::decode::{Streams, examine, examine_streams};
use crate::error::{Error, Kind};
use crate::ptm::{Field, Format, Ptm, Size};

/// A part of a file: a field, or an element of one. What `inspect` adds is empty in a dissection.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FilePart {
    /// Its position.
    pub offset: usize,
    /// Number of its bytes.
    pub length: usize,
    /// The clause that requires it; within a plane, of T.81 or T.87.
    pub clause: &'static str,
    /// Its name; coefficients, matrix elements and planes are numbered.
    pub name: String,
    /// Its value; from `inspect`.
    pub value: String,
    /// Its first bytes, if it is not text; from `inspect`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub begins: String,
    /// Its elements: entries, segments, records; from `inspect`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<FilePart>,
    /// Its role.
    #[serde(skip)]
    pub role: Role,
    /// The name of the list it is an element of; empty if it is none.
    #[serde(skip)]
    pub list: &'static str,
    /// The number of bytes that it should have, if the file ends earlier.
    #[serde(skip)]
    pub cut_from: Option<u64>,
    /// The white space before the next part, in visible form; from `inspect`.
    #[serde(skip)]
    pub(super) gap: String,
}

/// The role of a part; numbers are indices of coefficients, matrix elements, blocks or planes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)] // they are the format's words
pub enum Role {
    /// An entry, segment or record of another part.
    #[default]
    Element,
    Version,
    Format,
    Width,
    Height,
    Scale(usize),
    Bias(usize),
    CountWord,
    Count,
    Table,
    Matrix(usize),
    Indices,
    Block(usize),
    Parameter,
    Transform(usize),
    MotionX(usize),
    MotionY(usize),
    Rank(usize),
    Reference(usize),
    StreamSize(usize),
    SideSize(usize),
    Stream(usize),
    Side(usize),
}

/// A dissected file.
pub struct Dissection<'a> {
    /// The file.
    pub file: &'a [u8],
    /// Its format, if it could be read.
    pub format: Option<Format>,
    /// Its size, if it could be read.
    pub size: Option<Size>,
    /// Its parts in file order.
    pub parts: Vec<FilePart>,
    /// The map, or the reason why there is none.
    pub outcome: Result<Ptm, Error>,
}

impl<'a> Dissection<'a> {
    /// Dissects `file`.
    #[must_use]
    pub fn parse(file: &'a [u8]) -> Dissection<'a> {
        let (fields, outcome) = examine(file);
        Dissection::new(file, &fields, outcome)
    }

    /// Dissects `file`, and returns its decoded streams if it is a compressed file that has all of them.
    pub(crate) fn with_streams(file: &'a [u8]) -> (Dissection<'a>, Option<Streams<'a>>) {
        let (fields, outcome, streams) = examine_streams(file);
        (Dissection::new(file, &fields, outcome), streams)
    }

    fn new(file: &'a [u8], fields: &[Field], outcome: Result<Ptm, Error>) -> Dissection<'a> {
        let name = fields.iter().find(|field| field.clause == FORMAT_NAME);
        let name = name.map(|field| &file[field.range.clone()]);
        let format = Format::ALL
            .into_iter()
            .find(|format| Some(format.name().as_bytes()) == name);
        let mut dissection = Dissection {
            file,
            format,
            size: None,
            parts: Vec::new(),
            outcome,
        };
        let mut counts: HashMap<&str, usize> = HashMap::new();
        for field in fields {
            let nth = counts.entry(field.clause).or_default();
            dissection.add_part(field.clause, field.range.clone(), *nth, None);
            *nth += 1;
        }
        let side = |role| {
            let side = u32::try_from(dissection.number(role)?).ok();
            side.filter(|&side| side > 0)
        };
        let sides = side(Role::Width).zip(side(Role::Height));
        dissection.size = sides.map(|(width, height)| Size { width, height });
        dissection.add_cut_parts();
        dissection
    }

    /// Returns the bytes of the first part of this role.
    #[must_use]
    pub fn bytes(&self, role: Role) -> Option<&'a [u8]> {
        self.part(role).map(|part| &self.file[part.range()])
    }

    /// Returns the first part of this role.
    #[must_use]
    pub fn part(&self, role: Role) -> Option<&FilePart> {
        self.parts.iter().find(|part| part.role == role)
    }

    /// Returns the byte at which this role begins; 0 if the file has no such part.
    #[must_use]
    pub fn start(&self, role: Role) -> usize {
        self.part(role).map_or(0, |part| part.offset)
    }

    /// Returns the number of planes of a compressed file; 0 in other formats.
    #[must_use]
    pub fn compressed_planes(&self) -> usize {
        self.format
            .filter(|format| format.coding().is_some())
            .map_or(0, Format::channels)
    }

    /// Returns the whole number in this role.
    #[must_use]
    pub fn number(&self, role: Role) -> Option<i64> {
        std::str::from_utf8(self.bytes(role)?).ok()?.parse().ok()
    }

    /// Returns the number of entries of the lookup table.
    #[must_use]
    pub fn entries(&self) -> Option<usize> {
        usize::try_from(self.number(Role::Count)?).ok()
    }

    /// Returns the text of the part of this role.
    #[must_use]
    pub fn text(&self, role: Role) -> Option<String> {
        Some(String::from_utf8_lossy(self.bytes(role)?).into_owned())
    }

    /// Returns the end of the last part.
    #[must_use]
    pub fn end(&self) -> usize {
        let ends = self.parts.iter().map(|part| part.range().end);
        ends.max().unwrap_or(0)
    }

    /// Returns the white space between the part at `place` and the next one.
    #[must_use]
    pub fn gap_after(&self, place: usize) -> &'a [u8] {
        let from = self.parts[place].range().end;
        let to = self
            .parts
            .get(place + 1)
            .map_or_else(|| from + self.line_end(from), |next| next.offset.max(from));
        &self.file[from..to]
    }

    /// Returns the number of bytes of a line end at `from`.
    fn line_end(&self, from: usize) -> usize {
        let in_header = !self.parts.iter().any(|part| part.role.is_payload());
        match &self.file[from..] {
            [b'\n', ..] if in_header => 1,
            [b' ', b'\n', ..] if in_header => 2,
            _ => 0,
        }
    }

    /// Adds the parts that the header declares and that are truncated.
    fn add_cut_parts(&mut self) {
        let Err(error) = &self.outcome else {
            return;
        };
        let &Kind::Short { needs, .. } = error.kind() else {
            return;
        };
        let (clause, mut at) = (error.clause(), error.offset());
        if clause != COMPRESSED_PLANE {
            let blocks = self.parts.iter();
            let blocks = blocks.filter(|part| matches!(part.role, Role::Block(_)));
            let (nth, range) = (blocks.count(), at..self.file.len());
            return self.add_part(clause, range, nth, Some(needs));
        }
        // The planes, as far as the file goes.
        for plane in 0..self.compressed_planes() {
            for (size, clause) in [
                (Role::StreamSize(plane), COMPRESSED_PLANE),
                (Role::SideSize(plane), SIDE_INFORMATION),
            ] {
                let size = self.number(size).and_then(|size| u64::try_from(size).ok());
                let size = size.unwrap_or(0);
                let there = (self.file.len() - at) as u64;
                let range = at..at + size.min(there) as usize;
                at = range.end;
                self.add_part(clause, range, plane, (there < size).then_some(size));
            }
        }
    }

    /// Adds the bytes of a field, the `nth` one of its clause; `cut_from` is the length that the file is too short for.
    fn add_part(
        &mut self,
        clause: &'static str,
        range: Range<usize>,
        nth: usize,
        cut_from: Option<u64>,
    ) {
        let planes = self.format.map_or(9, Format::channels);
        let is_y = clause == "2.9.3/1" && nth >= planes;
        let nth = if is_y { nth - planes } else { nth };
        let is_word = matches!(&self.file[range.clone()], b"nentries" | b"N_LUT_ENTRIES");
        let (role, name, list) = match clause {
            "2.1/1" => (Role::Version, "version", ""),
            FORMAT_NAME => (Role::Format, "format", ""),
            "2.3/1" if nth == 0 => (Role::Width, "width", ""),
            "2.3/1" => (Role::Height, "height", ""),
            "2.4/3" => (Role::Scale(nth), "scale of a#", "scales of a0…a5"),
            "2.4/4" => (Role::Bias(nth), "bias of a#", "biases of a0…a5"),
            "2.5/2" if is_word => (Role::CountWord, "word at the number of entries", ""),
            "2.5/2" => (Role::Count, "number of entries", ""),
            "2.5/3" => (Role::Table, "lookup table", ""),
            "2.6/2" => (Role::Matrix(nth), "matrix element #", "color matrix"),
            // Bytes that are present, and bytes that are missing.
            "2.7/1" | "2.7/3" => (Role::Block(nth), block_name(self.format, nth), ""),
            "2.8.1/1" => (Role::Indices, "indices", ""),
            "2.9.1/1" => (Role::Parameter, "compression parameter", ""),
            "2.9.2/1" => (Role::Transform(nth), "transform of plane #", "transforms"),
            "2.9.3/1" if is_y => (Role::MotionY(nth), "vector of plane #, y", "vectors, y"),
            "2.9.3/1" => (Role::MotionX(nth), "vector of plane #, x", "vectors, x"),
            "2.9.4/1" => (Role::Rank(nth), "rank of plane #", "order"),
            "2.9.5/1" => (Role::Reference(nth), "reference of plane #", "references"),
            "2.9.6/1" => {
                let (name, list) = ("compressed size of plane #", "compressed sizes");
                (Role::StreamSize(nth), name, list)
            }
            "2.9.7/1" => {
                let (name, list) = ("side information size of plane #", "side sizes");
                (Role::SideSize(nth), name, list)
            }
            COMPRESSED_PLANE => (Role::Stream(nth), "plane #", ""),
            SIDE_INFORMATION => (Role::Side(nth), "side information of plane #", ""),
            _ => return,
        };
        self.parts.push(FilePart {
            role,
            name: name.replace('#', &nth.to_string()),
            list,
            // The exact clause, if the decoder cites the one that all formats share.
            clause: match (role, self.format) {
                (Role::Block(_), Some(format)) => {
                    (blocks(format).get(nth)).map_or(clause, |block| block.clause)
                }
                (Role::Indices, Some(Format::PtmCLut)) => "2.8.2/1",
                (Role::Table, Some(Format::PtmLut)) => "2.5/4",
                (Role::Table, _) => "2.5/5",
                _ => clause,
            },
            offset: range.start,
            length: range.len(),
            cut_from,
            ..FilePart::default()
        });
    }
}

/// Returns the indices of a lookup table, each in `width` bytes, low byte first (2.8.1/2).
pub(crate) fn index_values(bytes: &[u8], width: usize) -> impl Iterator<Item = usize> {
    let value = |bytes: &[u8]| {
        let bytes = bytes.iter().rev();
        bytes.fold(0, |index, &byte| index << 8 | usize::from(byte))
    };
    bytes.chunks(width.max(1)).map(value)
}

impl Role {
    /// Returns true if it follows the text of the header.
    #[must_use]
    pub const fn is_payload(self) -> bool {
        matches!(
            self,
            Role::Table | Role::Indices | Role::Block(_) | Role::Stream(_) | Role::Side(_)
        )
    }
}

/// Returns the name of a block of texel data.
fn block_name(format: Option<Format>, block: usize) -> &'static str {
    match (format, block) {
        (Some(Format::Rgb), 0) => "red coefficients",
        (Some(Format::Rgb), 1) => "green coefficients",
        (Some(Format::Rgb), _) => "blue coefficients",
        (Some(Format::Lum), _) => "coefficients, Cr and Cb",
        (Some(Format::Lrgb), 0) => "coefficients",
        _ => "colors",
    }
}

/// Clauses for the format's name, the streams and the side information.
const FORMAT_NAME: &str = "2.2/1";
const COMPRESSED_PLANE: &str = "2.9.8/2";
const SIDE_INFORMATION: &str = "2.9.8/4";

impl FilePart {
    /// Returns the positions of its bytes.
    #[must_use]
    pub fn range(&self) -> Range<usize> {
        self.offset..self.offset + self.length
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{Model, Recipe, write};

    #[test]
    fn parts_cover_every_byte() {
        for format in Format::ALL {
            let recipe = Recipe::ordinary(format, "4x3".parse().unwrap());
            let written = write(&recipe, &Model::paint(&recipe));
            let dissection = Dissection::parse(&written.bytes);
            assert!(dissection.outcome.is_ok(), "{format}");
            // The writer's map and the reader's agree on the position of every part.
            let ranges = dissection.parts.iter().map(FilePart::range);
            let fields = written.fields.iter().map(|field| field.range.clone());
            assert!(ranges.eq(fields), "{format}");
            assert_eq!(dissection.end(), written.bytes.len());
            for place in 0..dissection.parts.len() {
                let gap = dissection.gap_after(place);
                assert!(matches!(gap, b"" | b" " | b"\n"), "{format}");
            }
        }
    }

    #[test]
    fn truncated_parts_are_shown() {
        for format in Format::ALL {
            let recipe = Recipe::ordinary(format, "4x3".parse().unwrap());
            let file = write(&recipe, &Model::paint(&recipe)).bytes;
            let (whole, cut) = (
                Dissection::parse(&file),
                Dissection::parse(&file[..file.len() - 5]),
            );
            let part = cut
                .parts
                .iter()
                .find(|part| part.cut_from.is_some())
                .unwrap();
            assert_eq!(part.range().end, file.len() - 5, "{format}");
            let uncut = whole.part(part.role).unwrap();
            assert_eq!(part.offset, uncut.offset, "{format}");
            assert_eq!(part.cut_from, Some(uncut.length as u64), "{format}");
        }
    }
}
