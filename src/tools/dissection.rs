//! The meaning of every byte of a file, as far as it can be read: the fields of the reference decoder, with names for people.
//!
//! A field gets a [`Role`]: its index in its list, and the item that the list describes. If the file is damaged, the dissection
//! ends at the damage; a truncated payload is shown as far as it goes, because the header defines its layout.

use std::collections::HashMap;
use std::ops::Range;

use crate::decode::{Streams, examine, examine_streams};
use crate::error::{Error, Kind};
use crate::ptm::{Field, Format, Ptm, Size, channel_name};

/// A part of a file and its role.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilePart {
    /// Its role.
    pub role: Role,
    /// The clause that requires it.
    pub clause: &'static str,
    /// Its bytes.
    pub range: Range<usize>,
    /// The number of bytes that it should have, if the file ends earlier.
    pub cut_from: Option<u64>,
}

/// The role of a part; numbers are indices of coefficients, matrix elements, blocks or planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)] // they are the format's words
pub enum Role {
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
    pub fn of(file: &'a [u8]) -> Dissection<'a> {
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
        let mut counts: HashMap<&str, usize> = HashMap::new();
        let parts = fields.iter().filter_map(|field| {
            let nth = counts.entry(field.clause).or_default();
            let role = role(field.clause, *nth, &file[field.range.clone()], format)?;
            *nth += 1;
            Some(FilePart {
                role,
                clause: exact_clause(role, format).unwrap_or(field.clause),
                range: field.range.clone(),
                cut_from: None,
            })
        });
        let mut dissection = Dissection {
            file,
            format,
            size: None,
            parts: parts.collect(),
            outcome,
        };
        dissection.size = dissection.read_size();
        if dissection.outcome.is_err() {
            dissection.show_cut_parts();
        }
        dissection
    }

    /// Returns the bytes of the first part of this role.
    #[must_use]
    pub fn bytes(&self, role: Role) -> Option<&'a [u8]> {
        self.part(role).map(|part| &self.file[part.range.clone()])
    }

    /// Returns the first part of this role.
    #[must_use]
    pub fn part(&self, role: Role) -> Option<&FilePart> {
        self.parts.iter().find(|part| part.role == role)
    }

    /// Returns the byte at which this role begins; 0 if the file has no such part.
    #[must_use]
    pub fn start(&self, role: Role) -> usize {
        self.part(role).map_or(0, |part| part.range.start)
    }

    /// Returns the number of planes of a compressed file; 0 in other formats.
    #[must_use]
    pub fn compressed_planes(&self) -> usize {
        self.format
            .filter(|format| format.is_compressed())
            .map_or(0, Format::channels)
    }

    /// Returns the whole number in this role.
    #[must_use]
    pub fn number(&self, role: Role) -> Option<i64> {
        std::str::from_utf8(self.bytes(role)?).ok()?.parse().ok()
    }

    /// Returns the text of the part of this role.
    #[must_use]
    pub fn text(&self, role: Role) -> Option<String> {
        Some(String::from_utf8_lossy(self.bytes(role)?).into_owned())
    }

    /// Returns the end of the last part.
    #[must_use]
    pub fn end(&self) -> usize {
        self.parts
            .iter()
            .map(|part| part.range.end)
            .max()
            .unwrap_or(0)
    }

    /// Returns the white space between the part at `place` and the next one.
    #[must_use]
    pub fn gap_after(&self, place: usize) -> &'a [u8] {
        let from = self.parts[place].range.end;
        let to = self.parts.get(place + 1).map_or_else(
            || from + self.line_end(from),
            |next| next.range.start.max(from),
        );
        &self.file[from..to]
    }

    /// Returns the channel name of plane `plane`: `a3 of green`.
    #[must_use]
    pub fn channel(&self, plane: usize) -> String {
        channel_name(self.format.map_or(9, Format::channels), plane)
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

    fn read_size(&self) -> Option<Size> {
        let side = |role| {
            u32::try_from(self.number(role)?)
                .ok()
                .filter(|&side| side > 0)
        };
        Some(Size {
            width: side(Role::Width)?,
            height: side(Role::Height)?,
        })
    }

    /// Adds the parts that the header declares and that are truncated.
    fn show_cut_parts(&mut self) {
        let Err(error) = &self.outcome else {
            return;
        };
        let &Kind::Short { needs, .. } = error.kind() else {
            return;
        };
        if error.clause() == COMPRESSED_PLANE {
            return self.show_cut_planes(error.offset());
        }
        let blocks = self.parts.iter();
        let blocks = blocks.filter(|part| matches!(part.role, Role::Block(_)));
        let role = role(error.clause(), blocks.count(), &[], self.format);
        self.parts.extend(role.map(|role| FilePart {
            role,
            clause: exact_clause(role, self.format).unwrap_or(error.clause()),
            range: error.offset()..self.file.len(),
            cut_from: Some(needs),
        }));
    }

    /// Adds the planes from byte `at` on, as far as the file goes.
    fn show_cut_planes(&mut self, mut at: usize) {
        for plane in 0..self.compressed_planes() {
            let (stream, side) = (Role::StreamSize(plane), Role::SideSize(plane));
            for (role, size, clause) in [
                (Role::Stream(plane), stream, COMPRESSED_PLANE),
                (Role::Side(plane), side, SIDE_INFORMATION),
            ] {
                let size = self.number(size).and_then(|size| u64::try_from(size).ok());
                let size = size.unwrap_or(0);
                let there = (self.file.len() - at) as u64;
                let end = at + size.min(there) as usize;
                self.parts.push(FilePart {
                    role,
                    clause,
                    range: at..end,
                    cut_from: (there < size).then_some(size),
                });
                at = end;
            }
        }
    }
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

    /// Returns the plane it belongs to, in a compressed file.
    #[must_use]
    pub fn plane(self) -> Option<usize> {
        let (number, ..) = self.naming(None);
        number.filter(|_| !matches!(self, Role::Scale(_) | Role::Bias(_) | Role::Matrix(_)))
    }

    /// Returns the name of the list it is an element of, if it is one.
    #[must_use]
    pub fn list(self) -> Option<&'static str> {
        self.naming(None).2
    }

    /// Returns its name; planes are numbered.
    #[must_use]
    pub fn name(self, format: Option<Format>) -> String {
        let (number, name, _) = self.naming(format);
        number.map_or_else(|| name.to_owned(), |n| name.replace("{n}", &n.to_string()))
    }

    /// Returns its number among its kind, its name with the place of the number, and the name of its list.
    fn naming(self, format: Option<Format>) -> (Option<usize>, &'static str, Option<&'static str>) {
        let alone = |name| (None, name, None);
        let element = |n, name, list| (Some(n), name, Some(list));
        match self {
            Role::Version => alone("version"),
            Role::Format => alone("format"),
            Role::Width => alone("width"),
            Role::Height => alone("height"),
            Role::Scale(i) => element(i, "scale of a{n}", "scales of a0…a5"),
            Role::Bias(i) => element(i, "bias of a{n}", "biases of a0…a5"),
            Role::CountWord => alone("word at the number of entries"),
            Role::Count => alone("number of entries"),
            Role::Table => alone("lookup table"),
            Role::Matrix(i) => element(i, "matrix element {n}", "color matrix"),
            Role::Indices => alone("indices"),
            Role::Block(i) => alone(block_name(format, i)),
            Role::Parameter => alone("compression parameter"),
            Role::Transform(i) => element(i, "transform of plane {n}", "transforms"),
            Role::MotionX(i) => element(i, "vector of plane {n}, x", "vectors, x"),
            Role::MotionY(i) => element(i, "vector of plane {n}, y", "vectors, y"),
            Role::Rank(i) => element(i, "rank of plane {n}", "order"),
            Role::Reference(i) => element(i, "reference of plane {n}", "references"),
            Role::StreamSize(i) => element(i, "compressed size of plane {n}", "compressed sizes"),
            Role::SideSize(i) => element(i, "side information size of plane {n}", "side sizes"),
            Role::Stream(i) => (Some(i), "plane {n}", None),
            Role::Side(i) => (Some(i), "side information of plane {n}", None),
        }
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

/// Clauses for the format's name, the streams and the side information.
const FORMAT_NAME: &str = "2.2/1";
const COMPRESSED_PLANE: &str = "2.9.8/2";
const SIDE_INFORMATION: &str = "2.9.8/4";

/// Returns the role of the `nth` field of `clause`.
fn role(clause: &str, nth: usize, bytes: &[u8], format: Option<Format>) -> Option<Role> {
    let planes = format.map_or(9, Format::channels);
    Some(match clause {
        "2.1/1" => Role::Version,
        FORMAT_NAME => Role::Format,
        "2.3/1" if nth == 0 => Role::Width,
        "2.3/1" => Role::Height,
        "2.4/3" => Role::Scale(nth),
        "2.4/4" => Role::Bias(nth),
        "2.5/2" if matches!(bytes, b"nentries" | b"N_LUT_ENTRIES") => Role::CountWord,
        "2.5/2" => Role::Count,
        "2.5/3" => Role::Table,
        "2.6/2" => Role::Matrix(nth),
        // Bytes that are present, and bytes that are missing.
        "2.7/1" | "2.7/3" => Role::Block(nth),
        "2.8.1/1" => Role::Indices,
        "2.9.1/1" => Role::Parameter,
        "2.9.2/1" => Role::Transform(nth),
        "2.9.3/1" if nth < planes => Role::MotionX(nth),
        "2.9.3/1" => Role::MotionY(nth - planes),
        "2.9.4/1" => Role::Rank(nth),
        "2.9.5/1" => Role::Reference(nth),
        "2.9.6/1" => Role::StreamSize(nth),
        "2.9.7/1" => Role::SideSize(nth),
        COMPRESSED_PLANE => Role::Stream(nth),
        SIDE_INFORMATION => Role::Side(nth),
        _ => return None,
    })
}

/// Returns the clause for the format of the file, if the decoder cites the one that all formats share.
fn exact_clause(role: Role, format: Option<Format>) -> Option<&'static str> {
    Some(match (role, format?) {
        (Role::Block(_), Format::Rgb) => "2.7.1/2",
        (Role::Block(_), Format::Lum) => "2.7.2/1",
        (Role::Block(0), Format::Lrgb) => "2.7.3/1",
        (Role::Block(_), Format::Lrgb) => "2.7.3/2",
        (Role::Block(_), Format::PtmLut) => "2.8.1/4",
        (Role::Indices, Format::PtmCLut) => "2.8.2/1",
        (Role::Table, Format::PtmLut) => "2.5/4",
        (Role::Table, Format::PtmCLut) => "2.5/5",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{Model, Recipe, write};

    #[test]
    fn every_byte_of_every_format_is_in_a_part_or_between_two() {
        for format in Format::ALL {
            let recipe = Recipe::ordinary(format, "4x3".parse().unwrap());
            let written = write(&recipe, &Model::paint(&recipe));
            let dissection = Dissection::of(&written.bytes);
            assert!(dissection.outcome.is_ok(), "{format}");
            // The writer's map and the reader's agree on the position of every part.
            let ranges: Vec<_> = dissection
                .parts
                .iter()
                .map(|part| part.range.clone())
                .collect();
            let fields: Vec<_> = written
                .fields
                .iter()
                .map(|field| field.range.clone())
                .collect();
            assert_eq!(ranges, fields, "{format}");
            assert_eq!(dissection.end(), written.bytes.len());
            for place in 0..dissection.parts.len() {
                assert!(
                    [&b""[..], b" ", b"\n"].contains(&dissection.gap_after(place)),
                    "{format}"
                );
            }
        }
    }

    #[test]
    fn blocks_that_are_cut_are_shown_as_far_as_they_go() {
        for format in [Format::Rgb, Format::Lum, Format::Lrgb, Format::PtmLut] {
            let recipe = Recipe::ordinary(format, "4x3".parse().unwrap());
            let file = write(&recipe, &Model::paint(&recipe)).bytes;
            let cut = Dissection::of(&file[..file.len() - 5]);
            let last = cut.parts.last().unwrap();
            assert!(matches!(last.role, Role::Block(_)), "{format}");
            assert_eq!(last.cut_from, Some(last.range.len() as u64 + 5), "{format}");
        }
    }

    #[test]
    fn planes_that_are_cut_are_shown_as_far_as_they_go() {
        let recipe = Recipe::ordinary(Format::JpeglsLrgb, "4x3".parse().unwrap());
        let file = write(&recipe, &Model::paint(&recipe)).bytes;
        let cut = &file[..file.len() - 5];
        let dissection = Dissection::of(cut);
        assert!(dissection.outcome.is_err());
        assert_eq!(
            dissection.bytes(Role::Stream(0)),
            Dissection::of(&file).bytes(Role::Stream(0))
        );
        assert_eq!(
            dissection.part(Role::Stream(8)).unwrap().range.end,
            cut.len()
        );
    }
}
