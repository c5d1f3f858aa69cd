//! Dissection of a file: the meaning of every byte that the reference decoder reads, with human-readable names.
//!
//! Each field has a [`Role`] that identifies the field and its index in a list. If the file is damaged, the dissection ends
//! at the damage. A truncated payload is dissected up to the end of the file, because the header defines its layout.

use std::collections::HashMap;
use std::ops::Range;

use serde::Serialize;

use ptm::decode::{Streams, examine, examine_streams, texels::blocks};
use ptm::error::{Error, Kind};
use ptm::{Field, Format, Ptm, Size};

/// Part of a file: a field, or an element of a field. Values that only `inspect` sets are empty in a dissection.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FilePart {
    /// Offset of the first byte.
    pub offset: usize,
    /// Number of bytes.
    pub length: usize,
    /// Clause that defines the part; inside a compressed plane, a clause of T.81 or T.87.
    pub clause: &'static str,
    /// Name of the part. Coefficients, matrix elements and planes are numbered.
    pub name: String,
    /// Value of the part; set by `inspect`.
    pub value: String,
    /// First bytes of the part, if it is not text; set by `inspect`.
    #[serde(rename = "begins", skip_serializing_if = "String::is_empty")]
    pub first_bytes: String,
    /// Entries, segments or records of the part; set by `inspect`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<FilePart>,
    /// Role of the part.
    #[serde(skip)]
    pub role: Role,
    /// Name of the list that contains the part; empty if it is not in a list.
    #[serde(skip)]
    pub list: &'static str,
    /// Full length of the part, if the file ends inside it.
    #[serde(skip)]
    pub full_length: Option<u64>,
    /// Whitespace before the next part, as visible symbols; set by `inspect`.
    #[serde(skip)]
    pub(super) gap: String,
}

/// Role of a part. The numbers are indices of coefficients, matrix elements, blocks or planes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)] // variants use the terms of the format
pub enum Role {
    /// Entry, segment or record of another part.
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

/// Dissected file.
pub struct Dissection<'a> {
    /// Bytes of the file.
    pub file: &'a [u8],
    /// Format of the file, if it could be read.
    pub format: Option<Format>,
    /// Image size, if it could be read.
    pub size: Option<Size>,
    /// Parts of the file, in file order.
    pub parts: Vec<FilePart>,
    /// Decoded map, or the decoding error.
    pub outcome: Result<Ptm, Error>,
}

impl<'a> Dissection<'a> {
    /// Dissects `file`.
    #[must_use]
    pub fn parse(file: &'a [u8]) -> Dissection<'a> {
        let (fields, outcome) = examine(file);
        Dissection::new(file, &fields, outcome)
    }

    /// Dissects `file`. Also returns the decoded streams of a compressed file if all of them can be decoded.
    pub(crate) fn with_streams(file: &'a [u8]) -> (Dissection<'a>, Option<Streams<'a>>) {
        let (fields, outcome, streams) = examine_streams(file);
        (Dissection::new(file, &fields, outcome), streams)
    }

    pub(crate) fn new(
        file: &'a [u8],
        fields: &[Field],
        outcome: Result<Ptm, Error>,
    ) -> Dissection<'a> {
        let name = fields
            .iter()
            .find(|field| field.clause == FORMAT_NAME_CLAUSE);
        let name = name.map(|field| &file[field.range.clone()]);
        let mut formats = Format::ALL.into_iter();
        let format = formats.find(|format| Some(format.name().as_bytes()) == name);
        let (size, parts) = (None, Vec::new());
        let mut dissection = Dissection {
            file,
            format,
            size,
            parts,
            outcome,
        };
        let mut counts: HashMap<&str, usize> = HashMap::new();
        for field in fields {
            let nth = counts.entry(field.clause).or_default();
            dissection.add_part(field.clause, field.range.clone(), *nth, None);
            *nth += 1;
        }
        let length = |role| {
            let length = u32::try_from(dissection.number(role)?).ok();
            length.filter(|&length| length > 0)
        };
        let size = length(Role::Width).zip(length(Role::Height));
        dissection.size = size.map(|(width, height)| Size { width, height });
        dissection.add_truncated_parts();
        dissection
    }

    /// Returns the bytes of the first part with the given role.
    #[must_use]
    pub fn bytes(&self, role: Role) -> Option<&'a [u8]> {
        self.part(role).map(|part| &self.file[part.range()])
    }

    /// Returns the first part with the given role.
    #[must_use]
    pub fn part(&self, role: Role) -> Option<&FilePart> {
        self.parts.iter().find(|part| part.role == role)
    }

    /// Returns the offset of the first part with the given role, or 0 if there is none.
    #[must_use]
    pub fn start(&self, role: Role) -> usize {
        self.part(role).map_or(0, |part| part.offset)
    }

    /// Returns the number of planes if the file is compressed, or 0 otherwise.
    pub(crate) fn compressed_planes(&self) -> usize {
        let format = self.format.filter(|format| format.coding().is_some());
        format.map_or(0, Format::channels)
    }

    /// Returns the integer stored in the part with the given role.
    #[must_use]
    pub fn number(&self, role: Role) -> Option<i64> {
        std::str::from_utf8(self.bytes(role)?).ok()?.parse().ok()
    }

    /// Returns the number of entries in the lookup table.
    #[must_use]
    pub fn entries(&self) -> Option<usize> {
        usize::try_from(self.number(Role::Count)?).ok()
    }

    /// Returns the text of the part with the given role.
    #[must_use]
    pub fn text(&self, role: Role) -> Option<String> {
        Some(String::from_utf8_lossy(self.bytes(role)?).into_owned())
    }

    /// Returns the offset of the first byte after the last part.
    #[must_use]
    pub fn end(&self) -> usize {
        let ends = self.parts.iter().map(|part| part.range().end);
        ends.max().unwrap_or(0)
    }

    /// Returns the whitespace between the part with index `i` and the next part.
    pub(crate) fn gap_after(&self, i: usize) -> &'a [u8] {
        let start = self.parts[i].range().end;
        let in_header = || !self.parts.iter().any(|part| part.role.is_payload());
        let length = match (self.parts.get(i + 1), &self.file[start..]) {
            (Some(next), _) => next.offset.saturating_sub(start),
            // A damaged header may end with a line ending.
            (None, [b'\n', ..]) if in_header() => 1,
            (None, [b' ', b'\n', ..]) if in_header() => 2,
            _ => 0,
        };
        &self.file[start..start + length]
    }

    /// Adds the parts of a truncated payload, using the lengths declared in the header.
    fn add_truncated_parts(&mut self) {
        let Err(error) = &self.outcome else { return };
        let &Kind::Short { needed, .. } = error.kind() else {
            return;
        };
        let (clause, mut offset) = (error.clause(), error.offset());
        if clause != COMPRESSED_PLANE_CLAUSE {
            let blocks = self.parts.iter();
            let blocks = blocks.filter(|part| matches!(part.role, Role::Block(_)));
            let (nth, range) = (blocks.count(), offset..self.file.len());
            return self.add_part(clause, range, nth, Some(needed));
        }
        // Add the planes up to the end of the file.
        for plane in 0..self.compressed_planes() {
            for (size, clause) in [
                (Role::StreamSize(plane), COMPRESSED_PLANE_CLAUSE),
                (Role::SideSize(plane), SIDE_INFORMATION_CLAUSE),
            ] {
                let size = self.number(size).and_then(|size| u64::try_from(size).ok());
                let size = size.unwrap_or(0);
                let available = (self.file.len() - offset) as u64;
                let range = offset..offset + size.min(available) as usize;
                offset = range.end;
                self.add_part(clause, range, plane, (available < size).then_some(size));
            }
        }
    }

    /// Adds the `nth` field of a clause. If the field is truncated, `full_length` is its full length.
    fn add_part(
        &mut self,
        clause: &'static str,
        range: Range<usize>,
        nth: usize,
        full_length: Option<u64>,
    ) {
        let planes = self.format.map_or(9, Format::channels);
        let is_y = clause == "2.9.3/1" && nth >= planes;
        let nth = if is_y { nth - planes } else { nth };
        let is_word = matches!(&self.file[range.clone()], b"nentries" | b"N_LUT_ENTRIES");
        let (role, name, list) = match clause {
            "2.1/1" => (Role::Version, "version", ""),
            FORMAT_NAME_CLAUSE => (Role::Format, "format", ""),
            "2.3/1" if nth == 0 => (Role::Width, "width", ""),
            "2.3/1" => (Role::Height, "height", ""),
            "2.4/3" => (Role::Scale(nth), "scale of a#", "scales of a0…a5"),
            "2.4/4" => (Role::Bias(nth), "bias of a#", "biases of a0…a5"),
            "2.5/2" if is_word => (Role::CountWord, "keyword of the entry count", ""),
            "2.5/2" => (Role::Count, "number of entries", ""),
            "2.5/3" => (Role::Table, "lookup table", ""),
            "2.6/2" => (Role::Matrix(nth), "matrix element #", "color matrix"),
            // Complete and truncated blocks have different clauses.
            "2.7/1" | "2.7/3" => (Role::Block(nth), block_name(self.format, nth), ""),
            "2.8.1/1" => (Role::Indices, "indices", ""),
            "2.9.1/1" => (Role::Parameter, "compression parameter", ""),
            "2.9.2/1" => (Role::Transform(nth), "transform of plane #", "transforms"),
            "2.9.3/1" if is_y => (Role::MotionY(nth), "vector of plane #, y", "vectors, y"),
            "2.9.3/1" => (Role::MotionX(nth), "vector of plane #, x", "vectors, x"),
            "2.9.4/1" => (Role::Rank(nth), "rank of plane #", "order"),
            "2.9.5/1" => (Role::Reference(nth), "reference of plane #", "references"),
            "2.9.6/1" => (Role::StreamSize(nth), STREAM_SIZE, "compressed sizes"),
            "2.9.7/1" => (Role::SideSize(nth), SIDE_SIZE, "side sizes"),
            COMPRESSED_PLANE_CLAUSE => (Role::Stream(nth), "plane #", ""),
            SIDE_INFORMATION_CLAUSE => (Role::Side(nth), "side information of plane #", ""),
            _ => return,
        };
        self.parts.push(FilePart {
            role,
            name: name.replace('#', &nth.to_string()),
            list,
            // Replace a clause that all formats share by the clause for this format.
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
            full_length,
            ..FilePart::default()
        });
    }
}

/// Decodes table indices of `width` bytes each, low byte first (2.8.1/2).
pub(crate) fn index_values(bytes: &[u8], width: usize) -> impl Iterator<Item = usize> {
    let value = |bytes: &[u8]| {
        let bytes = bytes.iter().rev();
        bytes.fold(0, |index, &byte| index << 8 | usize::from(byte))
    };
    bytes.chunks(width.max(1)).map(value)
}

impl Role {
    /// Returns true if parts with this role follow the text of the header.
    pub(crate) const fn is_payload(self) -> bool {
        matches!(
            self,
            Role::Table | Role::Indices | Role::Block(_) | Role::Stream(_) | Role::Side(_)
        )
    }
}

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

/// Names of the fields that contain the sizes of streams and of side information.
const STREAM_SIZE: &str = "compressed size of plane #";
const SIDE_SIZE: &str = "side information size of plane #";

const FORMAT_NAME_CLAUSE: &str = "2.2/1";
const COMPRESSED_PLANE_CLAUSE: &str = "2.9.8/2";
const SIDE_INFORMATION_CLAUSE: &str = "2.9.8/4";

impl FilePart {
    /// Returns the byte range of the part.
    #[must_use]
    pub fn range(&self) -> Range<usize> {
        self.offset..self.offset + self.length
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ptm_generate::{Model, Recipe, write};

    #[test]
    fn truncated_parts_are_included() {
        for format in Format::ALL {
            let recipe = Recipe::default_for(format, "4x3".parse().unwrap());
            let file = write(&recipe, &Model::paint(&recipe)).bytes;
            let [full, cut] = [5, 0].map(|kept| Dissection::parse(&file[..file.len() - 5 + kept]));
            let mut parts = cut.parts.iter();
            let part = parts.find(|part| part.full_length.is_some()).unwrap();
            assert_eq!(part.range().end, file.len() - 5, "{format}");
            let expected = full.part(part.role).unwrap();
            assert_eq!(part.offset, expected.offset, "{format}");
            assert_eq!(part.full_length, Some(expected.length as u64), "{format}");
        }
    }
}
