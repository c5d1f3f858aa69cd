//! What every byte of a file is, as far as it can be read: the fields of the reference decoder, named for people.
//!
//! A field gets a [`Role`]: which of the numbers of its list it is, and whose. Where the file is damaged, the anatomy ends
//! at the damage; a payload that is cut short is shown as far as it goes, because the header says where its parts lie.

use std::collections::HashMap;
use std::ops::Range;

use crate::decode::{Ptm, examine};
use crate::error::{Error, Kind};
use crate::ptm::{Format, Size, channel_name};

/// A part of a file and what it is for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// What it is for.
    pub role: Role,
    /// The clause that puts it there.
    pub clause: &'static str,
    /// Its bytes.
    pub range: Range<usize>,
    /// How many bytes it should have, where the file ends before.
    pub cut_from: Option<usize>,
}

/// What a part is for; numbers count coefficients, matrix elements, blocks or planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

/// A file taken apart.
pub struct Anatomy<'a> {
    /// The file.
    pub file: &'a [u8],
    /// Its format, if that was read.
    pub format: Option<Format>,
    /// Its size, if that was read.
    pub size: Option<Size>,
    /// Its parts in file order.
    pub parts: Vec<Part>,
    /// The map, or why there is none.
    pub outcome: Result<Ptm, Error>,
}

impl<'a> Anatomy<'a> {
    /// Takes `file` apart.
    #[must_use]
    pub fn of(file: &'a [u8]) -> Anatomy<'a> {
        let (fields, outcome) = examine(file);
        let format = fields
            .iter()
            .find(|field| field.name == FORMAT)
            .and_then(|field| {
                let name = &file[field.range.clone()];
                Format::ALL
                    .into_iter()
                    .find(|format| format.name().as_bytes() == name)
            });
        let mut seen = HashMap::new();
        let parts = fields.iter().filter_map(|field| {
            let nth = seen.entry(field.name).or_insert(0);
            let role = role(field.name, *nth, format)?;
            *nth += 1;
            Some(Part {
                role,
                clause: exact_clause(role, format).unwrap_or(field.clause),
                range: field.range.clone(),
                cut_from: None,
            })
        });
        let mut anatomy = Anatomy {
            file,
            format,
            size: None,
            parts: parts.collect(),
            outcome,
        };
        anatomy.size = anatomy.read_size();
        anatomy.show_cut_parts();
        anatomy
    }

    /// The bytes of the first part of this role.
    #[must_use]
    pub fn bytes(&self, role: Role) -> Option<&'a [u8]> {
        self.part(role).map(|part| &self.file[part.range.clone()])
    }

    /// The first part of this role.
    #[must_use]
    pub fn part(&self, role: Role) -> Option<&Part> {
        self.parts.iter().find(|part| part.role == role)
    }

    /// The whole number that stands in this role.
    #[must_use]
    pub fn number(&self, role: Role) -> Option<i64> {
        std::str::from_utf8(self.bytes(role)?).ok()?.parse().ok()
    }

    /// How the part of this role is written.
    #[must_use]
    pub fn text(&self, role: Role) -> Option<String> {
        Some(String::from_utf8_lossy(self.bytes(role)?).into_owned())
    }

    /// Where the reading ended: behind the last part.
    #[must_use]
    pub fn end(&self) -> usize {
        self.parts
            .iter()
            .map(|part| part.range.end)
            .max()
            .unwrap_or(0)
    }

    /// Where the part at `place` is followed by the next one: the white space between the two.
    #[must_use]
    pub fn behind(&self, place: usize) -> &'a [u8] {
        let from = self.parts[place].range.end;
        let to = self.parts.get(place + 1).map_or_else(
            || from + self.line_end(from),
            |next| next.range.start.max(from),
        );
        &self.file[from..to]
    }

    /// What plane `plane` is of: `a3 of green`.
    #[must_use]
    pub fn channel(&self, plane: usize) -> String {
        channel_name(self.format.map_or(9, Format::channels), plane)
    }

    /// The bytes of a line end that stands at `from`.
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

    /// What the file announces and has not all of.
    fn show_cut_parts(&mut self) {
        let Err(error) = &self.outcome else {
            return;
        };
        let &Kind::Short { what, needs, .. } = error.kind() else {
            return;
        };
        if error.clause() != "2.9.8/2" {
            let nth = self
                .parts
                .iter()
                .filter(|part| matches!(part.role, Role::Block(_)))
                .count();
            self.parts
                .extend(role(what, nth, self.format).map(|role| Part {
                    role,
                    clause: exact_clause(role, self.format).unwrap_or(error.clause()),
                    range: error.offset()..self.file.len(),
                    cut_from: Some(needs),
                }));
            return;
        }
        let mut at = error.offset();
        for plane in 0..self.format.map_or(0, Format::channels) {
            for (role, size, clause) in [
                (Role::Stream(plane), Role::StreamSize(plane), "2.9.8/2"),
                (Role::Side(plane), Role::SideSize(plane), "2.9.8/4"),
            ] {
                let size = self
                    .number(size)
                    .and_then(|size| usize::try_from(size).ok())
                    .unwrap_or(0);
                let end = at.saturating_add(size).min(self.file.len());
                self.parts.push(Part {
                    role,
                    clause,
                    range: at..end,
                    cut_from: (end - at < size).then_some(size),
                });
                at = end;
            }
        }
    }
}

impl Role {
    /// Whether it stands behind the header's text.
    #[must_use]
    pub const fn is_payload(self) -> bool {
        matches!(
            self,
            Role::Table | Role::Indices | Role::Block(_) | Role::Stream(_) | Role::Side(_)
        )
    }

    /// The plane it belongs to, in a compressed file.
    #[must_use]
    pub const fn plane(self) -> Option<usize> {
        match self {
            Role::Transform(plane)
            | Role::MotionX(plane)
            | Role::MotionY(plane)
            | Role::Rank(plane)
            | Role::Reference(plane)
            | Role::StreamSize(plane)
            | Role::SideSize(plane)
            | Role::Stream(plane)
            | Role::Side(plane) => Some(plane),
            _ => None,
        }
    }

    /// The list it is an element of; nothing for what stands alone.
    #[must_use]
    pub const fn list(self) -> Option<&'static str> {
        Some(match self {
            Role::Scale(_) => "scales of a0…a5",
            Role::Bias(_) => "biases of a0…a5",
            Role::Matrix(_) => "color matrix",
            Role::Transform(_) => "transforms",
            Role::MotionX(_) => "vectors, x",
            Role::MotionY(_) => "vectors, y",
            Role::Rank(_) => "order",
            Role::Reference(_) => "references",
            Role::StreamSize(_) => "compressed sizes",
            Role::SideSize(_) => "side sizes",
            _ => return None,
        })
    }

    /// What it is called; planes by their number.
    #[must_use]
    pub fn name(self, format: Option<Format>) -> String {
        match self {
            Role::Version => "version".to_owned(),
            Role::Format => "format".to_owned(),
            Role::Width => "width".to_owned(),
            Role::Height => "height".to_owned(),
            Role::Scale(i) => format!("scale of a{i}"),
            Role::Bias(i) => format!("bias of a{i}"),
            Role::CountWord => "word at the number of entries".to_owned(),
            Role::Count => "number of entries".to_owned(),
            Role::Table => "lookup table".to_owned(),
            Role::Matrix(i) => format!("matrix element {i}"),
            Role::Indices => "indices".to_owned(),
            Role::Block(i) => block_name(format, i).to_owned(),
            Role::Parameter => "compression parameter".to_owned(),
            Role::Transform(plane) => format!("transform of plane {plane}"),
            Role::MotionX(plane) => format!("vector of plane {plane}, x"),
            Role::MotionY(plane) => format!("vector of plane {plane}, y"),
            Role::Rank(plane) => format!("rank of plane {plane}"),
            Role::Reference(plane) => format!("reference of plane {plane}"),
            Role::StreamSize(plane) => format!("compressed size of plane {plane}"),
            Role::SideSize(plane) => format!("side information size of plane {plane}"),
            Role::Stream(plane) => format!("plane {plane}"),
            Role::Side(plane) => format!("side information of plane {plane}"),
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

/// What the decoder calls the second line.
const FORMAT: &str = "the name of a format";

/// The role of the `nth` field that the decoder calls `name`.
fn role(name: &str, nth: usize, format: Option<Format>) -> Option<Role> {
    let planes = format.map_or(9, Format::channels);
    Some(match name {
        "PTM_1.2" => Role::Version,
        FORMAT => Role::Format,
        "a width of at least 1" => Role::Width,
        "a height of at least 1" => Role::Height,
        "a scale" => Role::Scale(nth),
        "an integer bias" => Role::Bias(nth),
        "nentries" | "N_LUT_ENTRIES" => Role::CountWord,
        "the number of entries" => Role::Count,
        "the table's entries" => Role::Table,
        "a matrix element" => Role::Matrix(nth),
        "the indices" => Role::Indices,
        "the texels" => Role::Block(nth),
        "a compression parameter" => Role::Parameter,
        "a transform" => Role::Transform(nth),
        "a motion vector" if nth < planes => Role::MotionX(nth),
        "a motion vector" => Role::MotionY(nth - planes),
        "the order of a plane" => Role::Rank(nth),
        "a reference plane" => Role::Reference(nth),
        "a compressed size" => Role::StreamSize(nth),
        "a side information size" => Role::SideSize(nth),
        "a compressed plane" => Role::Stream(nth),
        "side information" => Role::Side(nth),
        _ => return None,
    })
}

/// The clause of the format at hand, where the decoder cites the one that all formats share.
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
            let anatomy = Anatomy::of(&written.bytes);
            assert!(anatomy.outcome.is_ok(), "{format}");
            // The writer's map and the reader's agree on the place of every part.
            let ranges: Vec<_> = anatomy
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
            assert_eq!(anatomy.end(), written.bytes.len());
            for place in 0..anatomy.parts.len() {
                assert!(
                    [&b""[..], b" ", b"\n"].contains(&anatomy.behind(place)),
                    "{format}"
                );
            }
        }
    }

    #[test]
    fn planes_that_are_cut_are_shown_as_far_as_they_go() {
        let recipe = Recipe::ordinary(Format::JpeglsLrgb, "4x3".parse().unwrap());
        let file = write(&recipe, &Model::paint(&recipe)).bytes;
        let cut = &file[..file.len() - 5];
        let anatomy = Anatomy::of(cut);
        assert!(anatomy.outcome.is_err());
        assert_eq!(
            anatomy.bytes(Role::Stream(0)),
            Anatomy::of(&file).bytes(Role::Stream(0))
        );
        assert_eq!(anatomy.part(Role::Stream(8)).unwrap().range.end, cut.len());
    }
}
