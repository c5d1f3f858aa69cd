//! Every field of a file: where it is, which clause puts it there, what it says.

use std::fmt::Write as _;

use anstyle::{AnsiColor, Style};
use serde::Serialize;

use crate::error::{Class, Kind};
use crate::kit::yaml::to_yaml;
use crate::ptm::{Format, Size};
use crate::tools::dissection::{Dissection, FilePart, Role};
use crate::tools::segments::{self, segments};

/// How many entries of a table, or records, are shown unless all are asked for.
const SOME: usize = 8;
/// How many bytes of a payload are shown.
const PREVIEW: usize = 8;

const DIM: Style = Style::new().dimmed();
const CLAUSE: Style = AnsiColor::Cyan.on_default();
const NAME: Style = Style::new().bold();
const VALUE: Style = AnsiColor::Green.on_default();
const WRONG: Style = AnsiColor::Red.on_default().bold();

/// A file, field by field.
#[derive(Debug, Serialize)]
pub struct Inspection {
    /// Its bytes.
    pub bytes: usize,
    /// The name of its format, if that was read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub format: Option<&'static str>,
    /// Texels in a row, if the size was read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width: Option<u32>,
    /// Rows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<u32>,
    /// Its fields, in file order.
    pub fields: Vec<InspectedField>,
    /// What is wrong, if anything is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<Fault>,
    /// What nobody reads: behind the damage, or behind the last value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest: Option<Rest>,
}

/// A field.
#[derive(Debug, Serialize)]
pub struct InspectedField {
    /// Where it begins.
    pub offset: usize,
    /// How many bytes it has.
    pub length: usize,
    /// The clause that puts it there; of T.81 or T.87 within a plane.
    pub clause: &'static str,
    /// What it is called.
    pub name: String,
    /// What it says.
    pub value: String,
    /// White space up to the next field, made visible.
    #[serde(skip)]
    behind: String,
    /// What it is for; nothing within a part.
    #[serde(skip)]
    role: Option<Role>,
    /// Its first bytes, where it is not text.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub begins: String,
    /// What it consists of: entries, segments, records.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<InspectedField>,
}

/// Where the reading ended and why.
#[derive(Debug, Serialize)]
pub struct Fault {
    /// The byte at which it shows.
    pub offset: usize,
    /// The clause that is broken.
    pub clause: &'static str,
    /// `malformed`, `unsupported` or `limit`.
    pub class: &'static str,
    /// What is wrong.
    pub what: String,
    /// Whether the file has ended too early: then it shows behind everything.
    #[serde(skip)]
    at_end: bool,
    /// The plane whose stream is at fault.
    #[serde(skip)]
    plane: Option<usize>,
}

/// Bytes that belong to no field.
#[derive(Debug, Serialize)]
pub struct Rest {
    /// Where they begin.
    pub offset: usize,
    /// How many they are.
    pub length: usize,
    /// The first of them.
    pub begins: String,
}

/// Takes `file` apart and describes every part.
#[must_use]
pub fn inspect(file: &[u8]) -> Inspection {
    let dissection = Dissection::of(file);
    let fields = (0..dissection.parts.len())
        .map(|place| show(&dissection, place))
        .collect();
    let error = dissection.outcome.as_ref().err().map(|error| Fault {
        offset: error.offset(),
        clause: error.clause(),
        class: match error.class() {
            Class::Malformed => "malformed",
            Class::Unsupported => "unsupported",
            Class::Limit => "limit",
        },
        what: error.kind().to_string(),
        at_end: matches!(error.kind(), Kind::Short { .. }),
        plane: match *error.kind() {
            Kind::Stream { plane, .. } => Some(plane),
            _ => None,
        },
    });
    let end = dissection.end()
        + dissection
            .parts
            .len()
            .checked_sub(1)
            .map_or(0, |last| dissection.gap_after(last).len());
    Inspection {
        bytes: file.len(),
        format: dissection.format.map(Format::name),
        width: dissection.size.map(|size| size.width),
        height: dissection.size.map(|size| size.height),
        fields,
        error,
        rest: (end < file.len()).then(|| Rest {
            offset: end,
            length: file.len() - end,
            begins: hexadecimal(&file[end..]),
        }),
    }
}

fn show(dissection: &Dissection, place: usize) -> InspectedField {
    let part = &dissection.parts[place];
    let bytes = &dissection.file[part.range.clone()];
    let (value, parts) = if let Some(whole) = part.cut_from {
        (format!("cut: {} of {whole} bytes", bytes.len()), Vec::new())
    } else if part.role.is_payload() {
        describe(dissection, part, bytes)
    } else {
        (bytes.escape_ascii().to_string(), Vec::new())
    };
    InspectedField {
        offset: part.range.start,
        length: bytes.len(),
        clause: part.clause,
        name: part.role.name(dissection.format),
        value,
        behind: if part.role.is_payload() {
            String::new()
        } else {
            visible(dissection.gap_after(place))
        },
        role: Some(part.role),
        begins: if part.role.is_payload() {
            hexadecimal(bytes)
        } else {
            String::new()
        },
        parts,
    }
}

/// What a part of the payload is, and what it consists of.
fn describe(
    dissection: &Dissection,
    part: &FilePart,
    bytes: &[u8],
) -> (String, Vec<InspectedField>) {
    let texels = dissection.size.map_or(0, Size::texels);
    match part.role {
        Role::Table => table(dissection, part, bytes),
        Role::Indices => (indices(bytes, texels), Vec::new()),
        Role::Stream(plane) => (plan(dissection, plane), stream_parts(part, bytes)),
        Role::Side(_) => records(dissection, part, bytes),
        _ => {
            let each = bytes.len().checked_div(texels).unwrap_or(0);
            (
                format!("{texels} texels of {each} bytes, bottom row first"),
                Vec::new(),
            )
        }
    }
}

/// The entries of the lookup table.
fn table(dissection: &Dissection, part: &FilePart, bytes: &[u8]) -> (String, Vec<InspectedField>) {
    let entries = dissection.number(Role::Count);
    let entries = entries.and_then(|count| usize::try_from(count).ok());
    let entries = entries.unwrap_or(0);
    let size = bytes.len().checked_div(entries).unwrap_or(0);
    let entry = |(i, entry): (usize, &[u8])| {
        let (name, value) = (format!("entry {i}"), decimal(entry));
        child(part, i * size, entry.len(), part.clause, name, value)
    };
    let parts = bytes.chunks(size.max(1)).enumerate().map(entry).collect();
    (format!("{entries} entries of {size} bytes"), parts)
}

/// How many indices there are, of what width and in what range.
fn indices(bytes: &[u8], texels: usize) -> String {
    let width = bytes.len().checked_div(texels).unwrap_or(0);
    let index = |bytes: &[u8]| {
        let bytes = bytes.iter().rev();
        bytes.fold(0, |index, &byte| index << 8 | usize::from(byte))
    };
    let largest = bytes.chunks(width.max(1)).map(index).max().unwrap_or(0);
    let smallest = bytes.chunks(width.max(1)).map(index).min().unwrap_or(0);
    let each = match width {
        1 => "one byte",
        _ => "two bytes, low byte first",
    };
    format!("{texels} of {each}, from {smallest} to {largest}, bottom row first")
}

fn child(
    part: &FilePart,
    at: usize,
    length: usize,
    clause: &'static str,
    name: String,
    value: String,
) -> InspectedField {
    InspectedField {
        offset: part.range.start + at,
        length,
        clause,
        name,
        value,
        behind: String::new(),
        role: None,
        begins: String::new(),
        parts: Vec::new(),
    }
}

/// How a plane is made: its channel, its rank, its reference and what is done to it.
fn plan(dissection: &Dissection, plane: usize) -> String {
    let number = |role| dissection.number(role).unwrap_or_default();
    let mut words = format!(
        "{}, rank {}",
        dissection.channel(plane),
        number(Role::Rank(plane))
    );
    let reference = number(Role::Reference(plane));
    if reference < 0 {
        words += ", intra";
        return words;
    }
    let _ = write!(words, ", predicted from plane {reference}");
    let transform = number(Role::Transform(plane));
    if transform & 1 != 0 {
        words += " inverted";
    }
    if transform & 2 != 0 {
        let half = |role| number(role) as f64 / 2.0;
        let _ = write!(
            words,
            " moved by ({}, {})",
            half(Role::MotionX(plane)),
            half(Role::MotionY(plane))
        );
    }
    words
}

fn stream_parts(part: &FilePart, stream: &[u8]) -> Vec<InspectedField> {
    let shown = |segment: segments::Segment| {
        child(
            part,
            segment.range.start,
            segment.range.len(),
            segment.kind.clause(),
            segment.kind.name(),
            segment.says,
        )
    };
    segments(stream).into_iter().map(shown).collect()
}

/// The records of a block of side information (clause 2.9.8/5).
fn records(
    dissection: &Dissection,
    part: &FilePart,
    block: &[u8],
) -> (String, Vec<InspectedField>) {
    const CLAUSE: &str = "2.9.8/5";
    let (whole, rest) = block.as_chunks::<5>();
    let record = |(i, &[p3, p2, p1, p0, value]): (usize, &[u8; 5])| {
        let position = u32::from_be_bytes([p3, p2, p1, p0]);
        let place = place(dissection.size, position);
        let value = format!("position {position} ({place}) becomes {value}");
        child(part, 5 * i, 5, CLAUSE, format!("record {i}"), value)
    };
    let mut parts: Vec<InspectedField> = whole.iter().enumerate().map(record).collect();
    if !rest.is_empty() {
        let (at, name) = (5 * whole.len(), "part of a record".to_owned());
        parts.push(child(part, at, rest.len(), CLAUSE, name, decimal(rest)));
    }
    let words = match whole.len() {
        0 if rest.is_empty() => "no records".to_owned(),
        1 => "1 record".to_owned(),
        count => format!("{count} records"),
    };
    (words, parts)
}

/// Where in the picture a position of the stored raster is.
fn place(size: Option<Size>, position: u32) -> String {
    match size {
        Some(size) if (position as usize) < size.texels() => format!(
            "column {}, row {} from the top",
            position % size.width,
            size.height - 1 - position / size.width
        ),
        _ => "no texel".to_owned(),
    }
}

impl Inspection {
    /// The fields as YAML.
    ///
    /// # Errors
    /// None that a file could cause.
    pub fn to_yaml(&self) -> Result<String, String> {
        to_yaml(self)
    }

    /// The fields as a table for a terminal, with its colors; `all` shows every entry, segment and record.
    #[must_use]
    pub fn to_text(&self, name: &str, all: bool) -> String {
        let mut out = format!("{NAME}{name}{NAME:#}: {}", self.summary());
        let _ = writeln!(
            out,
            "\n\n{DIM}  offset   length  clause        what{:<29}value{DIM:#}",
            ""
        );
        let mut shown = self.error.is_none();
        let mut fields = self.fields.iter().peekable();
        while let Some(first) = fields.next() {
            let mut line = first.line();
            while first.list().is_some()
                && fields
                    .peek()
                    .is_some_and(|next| next.list() == first.list())
            {
                line.extend(fields.next().expect("it was just seen"));
            }
            if first.length == 0 && matches!(first.role, Some(Role::Side(_))) {
                continue;
            }
            line.write(&mut out, 0);
            let hit = !shown && line.holds(first, self.error.as_ref());
            first.write_parts(&mut out, all, hit);
            if hit {
                shown = true;
                self.write_error(&mut out);
            }
        }
        if !shown {
            self.write_error(&mut out);
        }
        if let Some(rest) = &self.rest {
            let why = if self.error.is_some() {
                "not read"
            } else {
                "after the last value, read by nobody"
            };
            let _ = writeln!(
                out,
                "{DIM}{:>8} {:>8}{DIM:#}  {:<12}  {NAME}{why}{NAME:#}  {DIM}{}{DIM:#}",
                rest.offset, rest.length, "", rest.begins
            );
        }
        out
    }

    fn summary(&self) -> String {
        let size = self.width.zip(self.height);
        let size = size.map_or_else(String::new, |(width, height)| {
            format!("{width} x {height} texels, ")
        });
        let format = self.format.map_or_else(
            || "no known format, ".to_owned(),
            |format| format!("{format}, "),
        );
        format!("{format}{size}{} bytes", self.bytes)
    }

    fn write_error(&self, out: &mut String) {
        if let Some(error) = &self.error {
            let _ = writeln!(
                out,
                "{WRONG}{:>8} {:>8}  {:<12}  {}: {}{WRONG:#}",
                error.offset, "", error.clause, error.class, error.what
            );
        }
    }
}

/// A row of the table: a field, or all of a list.
struct Line {
    offset: usize,
    end: usize,
    clause: &'static str,
    name: String,
    value: String,
    begins: String,
}

impl Line {
    fn extend(&mut self, next: &InspectedField) {
        self.end = next.offset + next.length;
        self.value += &next.styled();
    }

    /// Whether the error is to be told here: in it or, of a stream, in its plane.
    fn holds(&self, first: &InspectedField, error: Option<&Fault>) -> bool {
        error.is_some_and(|error| match error.plane {
            Some(plane) => first.role == Some(Role::Stream(plane)),
            None => {
                !error.at_end
                    && (self.offset..self.end.max(self.offset + 1)).contains(&error.offset)
            }
        })
    }

    fn write(&self, out: &mut String, indent: usize) {
        let _ = write!(
            out,
            "{DIM}{:>8} {:>8}{DIM:#}  {CLAUSE}{:<12}{CLAUSE:#}  {:indent$}{NAME}{}{NAME:#}",
            self.offset,
            self.end - self.offset,
            self.clause,
            "",
            self.name
        );
        if !self.value.is_empty() {
            let space = 33_usize
                .saturating_sub(indent + self.name.chars().count())
                .max(1);
            let _ = write!(out, "{:space$}{}", "", self.value);
        }
        if !self.begins.is_empty() {
            let _ = write!(out, "  {DIM}{}{DIM:#}", self.begins);
        }
        out.push('\n');
    }
}

impl InspectedField {
    /// The list it is an element of.
    fn list(&self) -> Option<&'static str> {
        self.role.and_then(Role::list)
    }

    fn line(&self) -> Line {
        Line {
            offset: self.offset,
            end: self.offset + self.length,
            clause: self.clause,
            name: self.list().map_or_else(|| self.name.clone(), str::to_owned),
            value: self.styled(),
            begins: self.begins.clone(),
        }
    }

    fn styled(&self) -> String {
        match self.value.as_str() {
            "" => String::new(),
            value => format!("{VALUE}{value}{VALUE:#}{DIM}{}{DIM:#}", self.behind),
        }
    }

    /// Entries, segments and records: all, or some of them; segments of a sound stream on one line.
    fn write_parts(&self, out: &mut String, all: bool, damaged: bool) {
        let of_a_stream = self
            .parts
            .first()
            .is_some_and(|part| part.clause.starts_with('T'));
        if of_a_stream && !all && !damaged {
            let words: Vec<String> = self.parts.iter().map(|part| part.name.clone()).collect();
            let _ = writeln!(out, "{:33}{DIM}{}{DIM:#}", "", words.join(", "));
            return;
        }
        let shown = if all || of_a_stream {
            self.parts.len()
        } else {
            self.parts.len().min(SOME)
        };
        for part in &self.parts[..shown] {
            part.line().write(out, 2);
        }
        if shown < self.parts.len() {
            let _ = writeln!(
                out,
                "{:33}{DIM}… and {} more; --all shows them{DIM:#}",
                "",
                self.parts.len() - shown
            );
        }
    }
}

/// Spaces and line feeds as signs of their own.
fn visible(bytes: &[u8]) -> String {
    bytes
        .iter()
        .map(|byte| match byte {
            b' ' => '␠',
            b'\n' => '␊',
            _ => '·',
        })
        .collect()
}

fn hexadecimal(bytes: &[u8]) -> String {
    let shown: Vec<String> = bytes
        .iter()
        .take(PREVIEW)
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let more = if bytes.len() > PREVIEW { " …" } else { "" };
    format!("{}{more}", shown.join(" "))
}

fn decimal(bytes: &[u8]) -> String {
    let words: Vec<String> = bytes.iter().map(u8::to_string).collect();
    words.join(" ")
}
