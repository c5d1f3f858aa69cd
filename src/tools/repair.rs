//! Repair of faults that have only one correction:
//!
//! - blanks and line ends in the header that the specification does not allow
//! - wrong compressed sizes, if the streams determine the correct ones
//! - bytes after the last value
//! - records of side information that a later record for the same texel overrides
//!
//! If the reference can read the file, the repaired file has the same values. Nothing is repaired if the correction is
//! ambiguous. For example, copying a file in text mode also changes payload bytes, which cannot be identified afterwards.

use std::collections::HashSet;

use super::dissection::{Dissection, FilePart, Role};
use super::lint::Lint;
use super::segments::{EOI, SegmentKind, segments};
use crate::decode::decode;
use crate::ptm::Format;

/// Repaired file.
#[derive(Debug)]
pub struct Repaired {
    /// Bytes of the repaired file.
    pub bytes: Vec<u8>,
    /// Descriptions of the changes.
    pub changes: Vec<String>,
}

/// Header of a file, split into words by lenient rules, and the payload.
struct LenientHeader<'a> {
    /// Words of each line, in the layout of files from HP's programs.
    lines: Vec<Vec<String>>,
    /// Line end: `\n`, `\r\n` or `\r`.
    line_end: &'static str,
    payload: &'a [u8],
    format: Format,
}

/// Repairs a file.
///
/// # Errors
/// Returns a message if there is nothing to repair, or if the faults cannot be repaired without guessing.
pub fn repair(file: &[u8]) -> Result<Repaired, String> {
    let before = decode(file);
    let mut changes = Vec::new();
    let mut bytes = file.to_vec();
    if before.is_err() {
        let loose = LenientHeader::read(file)?;
        bytes = loose.into_legal_file(&mut changes)?;
    }
    let dissection = Dissection::parse(&bytes);
    let (end, is_read) = (dissection.end(), dissection.outcome.is_ok());
    if is_read && end < bytes.len() {
        let rest = bytes.len() - end;
        changes.push(format!("{rest} bytes after the last value are removed"));
        bytes.truncate(end);
    }
    bytes = remove_overridden_records(bytes, &mut changes)?;
    if changes.is_empty() {
        return Err("there is nothing to repair".to_owned());
    }
    let unlike = "this is a bug in ptm-conform, and nothing is written";
    let malformed = |error| format!("the result is malformed: {error}; {unlike}");
    let after = decode(&bytes).map_err(malformed)?;
    if before.is_ok_and(|before| before != after) || Lint::new("", &bytes).errors > 0 {
        return Err(format!("the result is another map; {unlike}"));
    }
    Ok(Repaired { bytes, changes })
}

impl<'a> LenientHeader<'a> {
    /// Reads a header with arbitrary whitespace between its words.
    fn read(file: &'a [u8]) -> Result<LenientHeader<'a>, String> {
        let mut at = 0;
        let version = next_word(file, &mut at)?;
        if version != "PTM_1.2" {
            return Err("it does not begin with PTM_1.2".to_owned());
        }
        let line_end = match strip_leading_blanks(&file[at..]) {
            [b'\r', b'\n', ..] => "\r\n",
            [b'\r', ..] => "\r",
            _ => "\n",
        };
        let name = next_word(file, &mut at)?;
        let format = Format::ALL.into_iter().find(|format| format.name() == name);
        let format = format.ok_or_else(|| format!("unknown format {name:?}"))?;
        let mut lines = vec![vec![version], vec![name]];
        let planes = format.channels();
        let more = match format {
            Format::PtmLut | Format::PtmCLut => {
                return Err("the spelling of a lookup table's header is left as it is".to_owned());
            }
            Format::Lum => vec![16],
            _ if format.coding().is_some() => [&[1][..], &[planes; 7]].concat(),
            _ => Vec::new(),
        };
        for count in [1, 1, 6, 6].into_iter().chain(more) {
            let words = (0..count).map(|_| next_word(file, &mut at));
            lines.push(words.collect::<Result<_, _>>()?);
        }
        let rest = strip_leading_blanks(&file[at..]);
        let payload = rest.strip_prefix(line_end.as_bytes());
        Ok(LenientHeader {
            lines,
            line_end,
            payload: payload.ok_or("the end of its header cannot be found")?,
            format,
        })
    }

    /// Returns a file with a legal header, and describes the changes.
    fn into_legal_file(mut self, changes: &mut Vec<String>) -> Result<Vec<u8>, String> {
        const BLANKS: &str = "the numbers in the header are now separated by single spaces, and its lines end in line feeds";
        let as_lines = self.to_bytes();
        if let Ok(ptm) = decode(&as_lines) {
            let is_exact = Dissection::parse(&as_lines).end() == as_lines.len();
            if self.line_end != "\n" && !is_exact {
                return Err(format!(
                    "its header has line ends other than line feeds, and its payload is longer than {} texels need: it was copied in text mode, which also changed the payload",
                    ptm.header.size
                ));
            }
            changes.push(BLANKS.to_owned());
            return Ok(as_lines);
        }
        if self.format.coding().is_none() {
            let says = "its faults cannot be repaired without guessing; `lint` lists them";
            return Err(says.to_owned());
        }
        self.measure_streams(changes)?;
        Ok(self.to_bytes())
    }

    fn to_bytes(&self) -> Vec<u8> {
        let lines = self.lines.iter().map(|line| line.join(" ") + "\n");
        let header: String = lines.collect();
        [header.as_bytes(), self.payload].concat()
    }

    /// Corrects the compressed sizes if the streams and their side information fill the payload without gaps.
    fn measure_streams(&mut self, changes: &mut Vec<String>) -> Result<(), String> {
        const SIZES: usize = 12;
        let unsettled = "the streams do not determine the correct sizes";
        let mut at = 0_usize;
        for plane in 0..self.format.channels() {
            let stream = self.payload.get(at..).ok_or(unsettled)?;
            let size = stream_length(stream).ok_or(unsettled)?;
            let text = &mut self.lines[SIZES][plane];
            if *text != size.to_string() {
                let size_of = format!("the compressed size of plane {plane}");
                changes.push(format!("{size_of} is {size}, not {text}"));
                *text = size.to_string();
            }
            let side = self.lines[SIZES + 1][plane].parse::<usize>();
            let end = side.ok().and_then(|side| (at + size).checked_add(side));
            at = end.ok_or(unsettled)?;
        }
        match at == self.payload.len() && !changes.is_empty() {
            true => Ok(()),
            false => Err(unsettled.to_owned()),
        }
    }
}

/// Skips whitespace and returns the next word of a header. Advances `at` to the end of the word.
fn next_word(file: &[u8], at: &mut usize) -> Result<String, String> {
    let is_blank = |byte: &&u8| matches!(byte, b' ' | b'\t' | b'\r' | b'\n');
    *at += file[*at..].iter().take_while(is_blank).count();
    let letters = file[*at..].iter();
    let length = letters.take_while(|byte| byte.is_ascii_graphic()).count();
    let word = String::from_utf8_lossy(&file[*at..*at + length]).into_owned();
    *at += length;
    match length {
        0 => Err(format!("its header ends at byte {at}")),
        _ => Ok(word),
    }
}

/// Strips leading spaces and tabs.
fn strip_leading_blanks(bytes: &[u8]) -> &[u8] {
    let blanks = bytes.iter().take_while(|byte| matches!(byte, b' ' | b'\t'));
    &bytes[blanks.count()..]
}

/// Returns the length of a stream from SOI to EOI. Returns `None` if there are stray bytes between them.
fn stream_length(stream: &[u8]) -> Option<usize> {
    let parts = segments(stream);
    let first = |kind| parts.iter().position(|part| part.kind == kind);
    let end = first(SegmentKind::Marker(EOI))?;
    let is_sound = first(SegmentKind::Stray).is_none_or(|stray| stray > end);
    (is_sound && stream.starts_with(&[0xff, 0xd8])).then_some(parts[end].range.end)
}

/// Removes records that a later record for the same texel overrides.
fn remove_overridden_records(bytes: Vec<u8>, changes: &mut Vec<String>) -> Result<Vec<u8>, String> {
    let dissection = Dissection::parse(&bytes);
    if let Err(error) = &dissection.outcome {
        return Err(error.to_string());
    }
    let mut edits = Vec::new();
    for plane in 0..dissection.compressed_planes() {
        let part = |role| dissection.part(role).map(FilePart::range);
        let (Some(size), Some(side)) = (part(Role::SideSize(plane)), part(Role::Side(plane)))
        else {
            continue;
        };
        let mut seen = HashSet::new();
        let mut kept: Vec<&[u8]> = bytes[side.clone()].rchunks(5).collect();
        let all = kept.len();
        kept.retain(|record| seen.insert(&record[..4]));
        kept.reverse();
        if kept.len() < all {
            let removed = format!(
                "{} records that later ones override are removed",
                all - kept.len()
            );
            changes.push(format!("plane {plane}: {removed}"));
            let kept = kept.concat();
            edits.push((size, kept.len().to_string().into_bytes()));
            edits.push((side, kept));
        }
    }
    // Apply edits from the end, so that the ranges of earlier edits remain valid.
    edits.sort_by_key(|(range, _)| std::cmp::Reverse(range.start));
    let mut bytes = bytes;
    for (range, with) in edits {
        bytes.splice(range, with);
    }
    Ok(bytes)
}
