//! Table of all fields of a file, with their offsets, clauses and values.

use std::fmt::Write as _;
use std::ops::Range;

use anstyle::{AnsiColor, Style};
use serde::Serialize;

use crate::dissection::{Dissection, FilePart, Role, index_values};
use crate::{describe_position, join_texts, segments::segments, texel_index};
use ptm::error::{Class, Kind};
use ptm::{Format, Size, channel_name};

/// Maximum number of table entries or records that are displayed unless all are requested.
const MAX_ENTRIES: usize = 8;
/// Maximum number of payload bytes that are displayed.
const MAX_PREVIEW_BYTES: usize = 8;

const DIM_STYLE: Style = Style::new().dimmed();
const CLAUSE_STYLE: Style = AnsiColor::Cyan.on_default();
const NAME_STYLE: Style = Style::new().bold();
const VALUE_STYLE: Style = AnsiColor::Green.on_default();
const ERROR_STYLE: Style = AnsiColor::Red.on_default().bold();

/// Description of a file, field by field.
#[derive(Debug, Serialize)]
pub struct Inspection {
    /// Size of the file in bytes.
    pub bytes: usize,
    /// Name of the format, if it could be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub format: Option<&'static str>,
    /// Number of texels per row, if the size could be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width: Option<u32>,
    /// Number of rows, if the size could be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<u32>,
    /// Fields in file order.
    pub fields: Vec<FilePart>,
    /// Decoding error, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<Fault>,
    /// Unread bytes after the damage or after the last value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest: Option<Rest>,
}

/// Error that ended decoding.
#[derive(Debug, Serialize)]
pub struct Fault {
    /// Offset of the error.
    pub offset: usize,
    /// Clause that is violated.
    pub clause: &'static str,
    /// Class of the error: `malformed`, `unsupported` or `limit`.
    pub class: &'static str,
    /// Description of the error.
    #[serde(rename = "what")]
    pub description: String,
    /// Kind of the error. It determines the field after which the error is displayed.
    #[serde(skip)]
    kind: Kind,
}

/// Bytes that do not belong to any field.
#[derive(Debug, Serialize)]
pub struct Rest {
    /// Offset of the first byte.
    pub offset: usize,
    /// Number of bytes.
    pub length: usize,
    /// First bytes in hexadecimal.
    #[serde(rename = "begins")]
    pub first_bytes: String,
}

/// Dissects `file` and describes every part.
#[must_use]
pub fn inspect(file: &[u8]) -> Inspection {
    let dissection = Dissection::parse(file);
    let error = dissection.outcome.as_ref().err().map(|error| Fault {
        offset: error.offset(),
        clause: error.clause(),
        class: match error.class() {
            Class::Malformed => "malformed",
            Class::Unsupported => "unsupported",
            Class::Limit => "limit",
        },
        description: error.kind().to_string(),
        kind: error.kind().clone(),
    });
    let parts = dissection.parts.len();
    let gap = parts.checked_sub(1).map(|last| dissection.gap_after(last));
    let end = dissection.end() + gap.map_or(0, <[u8]>::len);
    Inspection {
        bytes: file.len(),
        format: dissection.format.map(Format::name),
        width: dissection.size.map(|size| size.width),
        height: dissection.size.map(|size| size.height),
        fields: (0..parts).map(|i| inspect_part(&dissection, i)).collect(),
        error,
        rest: (end < file.len()).then(|| Rest {
            offset: end,
            length: file.len() - end,
            first_bytes: hexadecimal(&file[end..]),
        }),
    }
}

/// Returns a part with its value and elements filled in.
fn inspect_part(dissection: &Dissection, i: usize) -> FilePart {
    let part = &dissection.parts[i];
    let bytes = &dissection.file[part.range()];
    let mut field = part.clone();
    if part.role.is_payload() {
        field.first_bytes = hexadecimal(bytes);
        (field.value, field.parts) = describe(dissection, part, bytes);
    } else {
        field.gap = visible_symbols(dissection.gap_after(i));
        field.value = bytes.escape_ascii().to_string();
    }
    field
}

fn describe(dissection: &Dissection, part: &FilePart, bytes: &[u8]) -> (String, Vec<FilePart>) {
    let texels = dissection.size.map_or(0, Size::texels);
    if let Some(whole) = part.full_length {
        let value = format!("truncated: {} of {whole} bytes", bytes.len());
        return (value, Vec::new());
    }
    let value = match part.role {
        Role::Table => return table(dissection, part, bytes),
        Role::Side(_) => return records(dissection, part, bytes),
        Role::Stream(plane) => {
            let parts = segments(bytes).into_iter().map(|segment| {
                let (name, clause) = segment.kind.label();
                let element = part.element(segment.range, clause, name.into_owned());
                FilePart {
                    value: segment.description,
                    ..element
                }
            });
            return (describe_plane(dissection, plane), parts.collect());
        }
        Role::Indices => {
            let width = bytes.len().checked_div(texels).unwrap_or(0);
            let largest = index_values(bytes, width).max().unwrap_or(0);
            let smallest = index_values(bytes, width).min().unwrap_or(0);
            let size = match width {
                1 => "one byte",
                _ => "two bytes, low byte first",
            };
            format!("{texels} indices of {size}, from {smallest} to {largest}, bottom row first")
        }
        _ => {
            let size = bytes.len().checked_div(texels).unwrap_or(0);
            format!("{texels} texels of {size} bytes, bottom row first")
        }
    };
    (value, Vec::new())
}

/// Describes the lookup table and its entries.
fn table(dissection: &Dissection, part: &FilePart, bytes: &[u8]) -> (String, Vec<FilePart>) {
    let entries = dissection.entries().unwrap_or(0);
    let size = bytes.len().checked_div(entries).unwrap_or(0);
    let entry = |(i, entry): (usize, &[u8])| {
        let range = i * size..i * size + entry.len();
        let element = part.element(range, part.clause, format!("entry {i}"));
        FilePart {
            value: join_texts(entry, " "),
            ..element
        }
    };
    let parts = bytes.chunks(size.max(1)).enumerate().map(entry).collect();
    (format!("{entries} entries of {size} bytes"), parts)
}

impl FilePart {
    /// Creates an element of this part with an empty value. `range` is relative to the beginning of the part.
    fn element(&self, range: Range<usize>, clause: &'static str, name: String) -> FilePart {
        FilePart {
            offset: self.offset + range.start,
            length: range.len(),
            clause,
            name,
            ..FilePart::default()
        }
    }
}

/// Describes the channel, rank, reference and transform of a plane.
fn describe_plane(dissection: &Dissection, plane: usize) -> String {
    let number = |role| dissection.number(role).unwrap_or_default();
    let planes = dissection.compressed_planes();
    let (channel, rank) = (channel_name(planes, plane), number(Role::Rank(plane)));
    let reference = number(Role::Reference(plane));
    if reference < 0 {
        return format!("{channel}, rank {rank}, intra");
    }
    let transform = number(Role::Transform(plane));
    let inverted = if transform & 1 != 0 { " inverted" } else { "" };
    let [x, y] = [Role::MotionX, Role::MotionY].map(|role| number(role(plane)) as f64 / 2.0);
    let displaced = match transform & 2 {
        0 => String::new(),
        _ => format!(" displaced by ({x}, {y})"),
    };
    format!("{channel}, rank {rank}, predicted from plane {reference}{inverted}{displaced}")
}

/// Describes a block of side information and its records (clause 2.9.8/5).
fn records(dissection: &Dissection, part: &FilePart, block: &[u8]) -> (String, Vec<FilePart>) {
    const CLAUSE: &str = "2.9.8/5";
    let (whole, rest) = block.as_chunks::<5>();
    let record = |(i, &[p3, p2, p1, p0, value]): (usize, &[u8; 5])| {
        let position = u32::from_be_bytes([p3, p2, p1, p0]);
        let texel = match dissection.size {
            Some(size) if (position as usize) < size.texels() => {
                describe_position(size, texel_index(size, position))
            }
            _ => "no texel".to_owned(),
        };
        let value = format!("position {position} ({texel}) is set to {value}");
        let element = part.element(5 * i..5 * i + 5, CLAUSE, format!("record {i}"));
        FilePart { value, ..element }
    };
    let mut parts: Vec<FilePart> = whole.iter().enumerate().map(record).collect();
    if !rest.is_empty() {
        let (range, name) = (5 * whole.len()..block.len(), "part of a record".to_owned());
        let (element, value) = (part.element(range, CLAUSE, name), join_texts(rest, " "));
        parts.push(FilePart { value, ..element });
    }
    let summary = match whole.len() {
        0 if rest.is_empty() => "no records".to_owned(),
        1 => "1 record".to_owned(),
        count => format!("{count} records"),
    };
    (summary, parts)
}

impl Inspection {
    /// Formats the fields as a colored table for a terminal. Includes every entry, segment and record if `all` is true.
    #[must_use]
    pub fn to_text(&self, name: &str, all: bool) -> String {
        let size = self.width.zip(self.height);
        let size = size.map(|(width, height)| format!("{width} x {height} texels, "));
        let mut out = format!(
            "{NAME_STYLE}{name}{NAME_STYLE:#}: {}, {}{} bytes\n\n{DIM_STYLE}  offset   length  clause        what{:<29}value{DIM_STYLE:#}\n",
            self.format.unwrap_or("unknown format"),
            size.unwrap_or_default(),
            self.bytes,
            ""
        );
        let mut fault = self.error.as_ref();
        let is_same_list = |a: &FilePart, b: &FilePart| !a.list.is_empty() && a.list == b.list;
        for line in self.fields.chunk_by(is_same_list) {
            let first = &line[0];
            if first.length == 0 && matches!(first.role, Role::Side(_)) {
                continue;
            }
            write_line(&mut out, line, 0);
            let own_fault = fault.take_if(|fault| fault.is_in(line));
            first.write_parts(&mut out, all, own_fault.is_some());
            write_fault(&mut out, own_fault);
        }
        write_fault(&mut out, fault);
        if let Some(rest) = &self.rest {
            let label = match self.error {
                Some(_) => "not read",
                None => "after the last value, unused",
            };
            let _ = writeln!(
                out,
                "{DIM_STYLE}{:>8} {:>8}{DIM_STYLE:#}  {:<12}  {NAME_STYLE}{label}{NAME_STYLE:#}  {DIM_STYLE}{}{DIM_STYLE:#}",
                rest.offset, rest.length, "", rest.first_bytes
            );
        }
        out
    }
}

impl Fault {
    /// Returns true if `line` contains the byte at which the error occurred, or the compressed plane that caused the error. The
    /// fault is displayed after this line.
    fn is_in(&self, line: &[FilePart]) -> bool {
        let (start, end) = (line[0].offset, line[line.len() - 1].range().end);
        match self.kind {
            Kind::Stream { plane, .. } => line[0].role == Role::Stream(plane),
            Kind::Short { .. } => false,
            _ => (start..end.max(start + 1)).contains(&self.offset),
        }
    }
}

fn write_fault(out: &mut String, fault: Option<&Fault>) {
    if let Some(fault) = fault {
        let _ = writeln!(
            out,
            "{ERROR_STYLE}{:>8} {:>8}  {:<12}  {}: {}{ERROR_STYLE:#}",
            fault.offset, "", fault.clause, fault.class, fault.description
        );
    }
}

/// Writes a row of the table for a field or for all elements of a list.
fn write_line(out: &mut String, line: &[FilePart], indent: usize) {
    let first = &line[0];
    let name = match first.list {
        "" => &first.name,
        list => list,
    };
    let _ = write!(
        out,
        "{DIM_STYLE}{:>8} {:>8}{DIM_STYLE:#}  {CLAUSE_STYLE}{:<12}{CLAUSE_STYLE:#}  {:indent$}{NAME_STYLE}{name}{NAME_STYLE:#}",
        first.offset,
        line[line.len() - 1].range().end - first.offset,
        first.clause,
        "",
    );
    let width = indent + name.chars().count();
    let mut space = 33_usize.saturating_sub(width).max(1);
    for FilePart { value, gap, .. } in line.iter().filter(|part| !part.value.is_empty()) {
        let _ = write!(
            out,
            "{:space$}{VALUE_STYLE}{value}{VALUE_STYLE:#}{DIM_STYLE}{gap}{DIM_STYLE:#}",
            ""
        );
        space = 0;
    }
    if !first.first_bytes.is_empty() {
        let _ = write!(out, "  {DIM_STYLE}{}{DIM_STYLE:#}", first.first_bytes);
    }
    out.push('\n');
}

impl FilePart {
    /// Writes the entries, segments or records of this part. Unless `all` is true, shortens long lists of entries and records,
    /// and writes the segments of an intact stream on one line.
    fn write_parts(&self, out: &mut String, all: bool, damaged: bool) {
        let is_stream = matches!(self.role, Role::Stream(_)) && !self.parts.is_empty();
        if is_stream && !all && !damaged {
            let names: Vec<&str> = self.parts.iter().map(|part| part.name.as_str()).collect();
            let _ = writeln!(out, "{:33}{DIM_STYLE}{}{DIM_STYLE:#}", "", names.join(", "));
            return;
        }
        let hidden = match all || is_stream {
            true => 0,
            false => self.parts.len().saturating_sub(MAX_ENTRIES),
        };
        for part in self.parts[..self.parts.len() - hidden].chunks(1) {
            write_line(out, part, 2);
        }
        if hidden > 0 {
            let _ = writeln!(
                out,
                "{:33}{DIM_STYLE}… and {hidden} more; --all shows them{DIM_STYLE:#}",
                ""
            );
        }
    }
}

/// Replaces spaces and line feeds with visible symbols.
fn visible_symbols(bytes: &[u8]) -> String {
    let symbol = |byte: &u8| match byte {
        b' ' => '␠',
        b'\n' => '␊',
        _ => '·',
    };
    bytes.iter().map(symbol).collect()
}

fn hexadecimal(bytes: &[u8]) -> String {
    let first = bytes.iter().take(MAX_PREVIEW_BYTES);
    let preview = join_texts(first.map(|byte| format!("{byte:02x}")), " ");
    match bytes.len() {
        0..=MAX_PREVIEW_BYTES => preview,
        _ => preview + " …",
    }
}
