//! Repairs faults that have only one possible correction:
//!
//! - a byte order mark, spaces or line ends before the header
//! - spaces, tabs and line endings in the header that the specification does not allow
//! - wrong compressed sizes, if the streams determine the correct ones
//! - binary data that was converted from Latin-1 or Windows-1252 to UTF-8, once or repeatedly, if no byte was lost
//! - bytes after the last value
//! - records of side information that a later record for the same texel overrides
//!
//! If the reference can read the file, the repaired file has the same values. Nothing is repaired if the correction is ambiguous.
//! For example, copying a file in text mode also changes payload bytes, which cannot be identified later.

use std::collections::HashSet;

use super::dissection::{Dissection, FilePart, Role};
use super::lint::{
    Lint,
    codes::Problem,
    damage::{PayloadDamage, payload_damage},
    errors::classify,
    status::without_damaged_start,
};
use super::segments::{EOI, SegmentKind, segments};
use crate::count_bytes;
use crate::error::{Error, Result};
use ptm::decode::decode;
use ptm::{Format, Ptm};

/// Repaired file.
#[derive(Debug)]
pub struct RepairedFile {
    /// Bytes of the repaired file.
    pub bytes: Vec<u8>,
    /// Descriptions of the changes.
    pub changes: Vec<String>,
}

/// Header of a file, leniently split into words, and the payload.
struct LenientHeader<'a> {
    /// Words of each line, in the layout of files from HP's programs.
    lines: Vec<Vec<String>>,
    /// Line ending: `\n`, `\r\n` or `\r`.
    line_end: &'static str,
    payload: &'a [u8],
    format: Format,
}

const LOST_BYTES: &str =
    "the payload was converted to text, which does not show all of its bytes; restore a backup";
const EXCESS: &str = "more bytes follow the last value than the header announces; the header or the payload may be wrong";
const TEXT_MODE: &str =
    "the file seems to have been copied in text mode, which also changes the payload";

/// Repairs a file.
///
/// # Errors
/// Returns a message if there is nothing to repair, or if the faults cannot be repaired without guessing.
pub fn repair(file: &[u8]) -> Result<RepairedFile> {
    let before = decode(file);
    let mut changes = Vec::new();
    let mut bytes = without_damaged_start(file).to_vec();
    if bytes.len() < file.len() {
        let removed = file.len() - bytes.len();
        changes.push(format!("removed {} before PTM_1.2", count_bytes(removed)));
    }
    let restored = match payload_damage(&Dissection::parse(&bytes)) {
        Some(PayloadDamage::Text(text)) => Some(text.restored.ok_or(LOST_BYTES)?),
        Some(PayloadDamage::Excess { .. }) => return Error::impossible(EXCESS),
        None => None,
    };
    let was_text = restored.is_some();
    if let Some(restored) = restored {
        changes.push("converted the binary data from UTF-8 back to bytes".to_owned());
        bytes = restored;
    }
    if decode(&bytes).is_err() {
        bytes = with_legal_header(&bytes, &mut changes)?;
    }
    let dissection = Dissection::parse(&bytes);
    // The damage may be visible only in the file with a legal header.
    match payload_damage(&dissection) {
        Some(PayloadDamage::Text(_)) => return Error::impossible(TEXT_MODE),
        Some(PayloadDamage::Excess { .. }) => return Error::impossible(EXCESS),
        None => {}
    }
    let (end, is_read) = (dissection.end(), dissection.outcome.is_ok());
    if is_read && end < bytes.len() {
        let rest = bytes.len() - end;
        if may_be_values(&bytes, end) {
            return Error::impossible(format!(
                "{rest} bytes follow the last value, but they may be values: check the size and the whitespace in the header"
            ));
        }
        if is_converted_text(&bytes, end) {
            return Error::impossible(TEXT_MODE);
        }
        changes.push(format!(
            "removed {} after the last value",
            count_bytes(rest)
        ));
        bytes.truncate(end);
    }
    bytes = remove_overridden_records(bytes, &mut changes)?;
    if changes.is_empty() {
        return Error::impossible("there is nothing to repair");
    }
    let bug = "this is a bug in ptm-conform, and nothing was written";
    let malformed = |error| format!("the result is malformed: {error}; {bug}");
    let after = decode(&bytes).map_err(malformed)?;
    let is_other = before.is_ok_and(|before| before != after) && !was_text;
    if is_other || Lint::new("", &bytes).errors > 0 {
        return Error::impossible(format!("the result is a different map; {bug}"));
    }
    Ok(RepairedFile { bytes, changes })
}

/// Returns the file with a legal header. The reason why there is none depends on the first error.
fn with_legal_header(file: &[u8], changes: &mut Vec<String>) -> Result<Vec<u8>> {
    let dissection = Dissection::parse(file);
    let Err(error) = &dissection.outcome else {
        return Ok(file.to_vec());
    };
    let reason = unrepairable_reason(classify(&dissection, error));
    let made = LenientHeader::read(file).and_then(|header| header.into_legal_file(changes));
    made.or_else(|why| match reason {
        Some(reason) => Error::impossible(reason),
        None => Err(why),
    })
}

/// Returns the reason why a file with this problem is not repaired, or `None` for problems that are repaired if nothing else is wrong.
fn unrepairable_reason(problem: Problem) -> Option<&'static str> {
    Some(match problem {
        Problem::CarriageReturn | Problem::Tab | Problem::Layout => return None,
        Problem::HeaderLost => "nothing is left of the header; restore a backup",
        Problem::NotAPtm | Problem::OtherVersion => {
            "the first line is wrong, and may be of another format or version"
        }
        Problem::UnknownFormat => "the format name is wrong, and the data fits several formats",
        Problem::HeaderEnds => "the file ends within its header; restore a backup",
        Problem::SizeNotANumber | Problem::SizeOutOfRange => {
            "the width or the height is wrong; only other records show the right one"
        }
        Problem::Scale => "a scale is not a number; only other records show the right one",
        Problem::Bias => "a bias is not an integer; only other records show the right one",
        Problem::TooFewNumbers => {
            "a scale or a bias is missing or extra; only other records show the right ones"
        }
        Problem::EntryCount => {
            "the number of table entries is wrong; only other records show the right one"
        }
        Problem::Matrix | Problem::MatrixShort => {
            "a matrix element is wrong or missing; only other records show the right one"
        }
        Problem::ListsShort | Problem::ListNumber => {
            "a number of a list is wrong or missing, and the streams do not show the right one"
        }
        Problem::Transform | Problem::NotAPlane | Problem::NotCausal => {
            "the header does not say how the planes are predicted; a guess would change the image"
        }
        Problem::NegativeSize => "a size is negative, and the streams do not show the right one",
        Problem::Index => {
            "an index refers to an entry that the table does not have; nothing shows the right one"
        }
        Problem::PayloadEnds => {
            "bytes are missing, or a number in the header is wrong, and nothing shows which; restore a backup"
        }
        Problem::NotAStream
        | Problem::OtherImage
        | Problem::StreamKind
        | Problem::StreamDamaged => {
            "a stream is damaged, or is not what the format needs; its values cannot be restored"
        }
        Problem::RecordCut | Problem::Position => {
            "side information is wrong, and nothing shows the right records"
        }
        _ => "the faults have more than one possible correction",
    })
}

impl<'a> LenientHeader<'a> {
    /// Reads a header with arbitrary whitespace between its words.
    fn read(file: &'a [u8]) -> Result<LenientHeader<'a>> {
        let mut offset = 0;
        let version = next_word(file, &mut offset)?;
        if version != "PTM_1.2" {
            return Error::impossible("the file does not begin with PTM_1.2");
        }
        let line_end = match strip_leading_blanks(&file[offset..]) {
            [b'\r', b'\n', ..] => "\r\n",
            [b'\r', ..] => "\r",
            _ => "\n",
        };
        let name = next_word(file, &mut offset)?;
        let format = Format::ALL.into_iter().find(|format| format.name() == name);
        let format = format.ok_or_else(|| format!("unknown format {name:?}"))?;
        let mut lines = vec![vec![version], vec![name]];
        let planes = format.channels();
        let more = match format {
            Format::PtmLut | Format::PtmCLut => {
                return Error::impossible("headers of files with a lookup table are not repaired");
            }
            Format::Lum => vec![16],
            _ if format.coding().is_some() => [&[1][..], &[planes; 7]].concat(),
            _ => Vec::new(),
        };
        for count in [1, 1, 6, 6].into_iter().chain(more) {
            let words = (0..count).map(|_| next_word(file, &mut offset));
            lines.push(words.collect::<Result<_, _>>()?);
        }
        let rest = strip_leading_blanks(&file[offset..]);
        let payload = rest.strip_prefix(line_end.as_bytes());
        Ok(LenientHeader {
            lines,
            line_end,
            payload: payload.ok_or("the end of the header cannot be found")?,
            format,
        })
    }

    fn into_legal_file(mut self, changes: &mut Vec<String>) -> Result<Vec<u8>> {
        const WHITESPACE: &str = "replaced the whitespace in the header with spaces and line feeds";
        let normalized = self.to_bytes();
        if decode(&normalized).is_ok() {
            let is_exact = Dissection::parse(&normalized).end() == normalized.len();
            if self.line_end != "\n" && !is_exact || self.has_converted_payload() {
                return Error::impossible(TEXT_MODE);
            }
            changes.push(WHITESPACE.to_owned());
            return Ok(normalized);
        }
        if self.format.coding().is_none() {
            let remaining = Dissection::parse(&normalized);
            let problem = remaining
                .outcome
                .as_ref()
                .err()
                .map(|error| classify(&remaining, error));
            let reason = problem.and_then(unrepairable_reason);
            return Error::impossible(
                reason.unwrap_or("the whitespace in the header is ambiguous"),
            );
        }
        self.measure_streams(changes)?;
        Ok(self.to_bytes())
    }

    /// Returns true if every line feed in the payload seems to have been converted to the line ending of the header.
    fn has_converted_payload(&self) -> bool {
        let count = |pattern: &[u8]| {
            self.payload
                .windows(pattern.len())
                .filter(|w| *w == pattern)
                .count()
        };
        match self.line_end {
            "\r" => count(b"\r") > 0 && count(b"\n") == 0,
            "\r\n" => count(b"\n") > 0 && count(b"\n") == count(b"\r\n"),
            _ => false,
        }
    }

    fn to_bytes(&self) -> Vec<u8> {
        let lines = self.lines.iter().map(|line| line.join(" ") + "\n");
        let header: String = lines.collect();
        [header.as_bytes(), self.payload].concat()
    }

    /// Corrects the compressed sizes if the streams and their side information fill the payload without gaps.
    fn measure_streams(&mut self, changes: &mut Vec<String>) -> Result<()> {
        const SIZES: usize = 12;
        let ambiguous = "the streams do not determine the correct sizes";
        let mut offset = 0_usize;
        for plane in 0..self.format.channels() {
            let stream = self.payload.get(offset..).ok_or(ambiguous)?;
            let size = stream_length(stream).ok_or(ambiguous)?;
            let text = &mut self.lines[SIZES][plane];
            if *text != size.to_string() {
                let name = format!("the compressed size of plane {plane}");
                changes.push(format!("corrected {name} from {text} to {size}"));
                *text = size.to_string();
            }
            let side = self.lines[SIZES + 1][plane].parse::<usize>();
            let end = side.ok().and_then(|side| (offset + size).checked_add(side));
            offset = end.ok_or(ambiguous)?;
        }
        match offset == self.payload.len() && !changes.is_empty() {
            true => Ok(()),
            false => Error::impossible(ambiguous),
        }
    }
}

/// Returns true if the bytes after `end` may be values. In a file with a table, any bytes may be indices. In a compressed file,
/// the bytes may be whole records of side information. In other files, they may be whole texels, or values that were displaced
/// because the payload seems to begin with header whitespace.
fn may_be_values(bytes: &[u8], end: usize) -> bool {
    let Ok(Ptm { header, .. }) = decode(bytes) else {
        return false;
    };
    let extra = bytes.len() - end;
    let texel = header.format.channels();
    match header.format {
        format if format.has_table() => true,
        format if format.coding().is_some() => extra.is_multiple_of(5),
        _ => {
            let first = bytes[end - header.size.texels() * texel];
            extra.is_multiple_of(texel) || first.is_ascii_whitespace()
        }
    }
}

/// Returns true if the bytes after `end` are as many as the carriage returns that a copy in text mode adds to the line feeds of the
/// payload.
fn is_converted_text(bytes: &[u8], end: usize) -> bool {
    let Ok(Ptm { planes, header }) = decode(bytes) else {
        return false;
    };
    if header.format.has_table() || header.format.coding().is_some() {
        return false;
    }
    let payload = &bytes[end - planes.samples.len()..];
    let count = |pattern: &[u8]| {
        payload
            .windows(pattern.len())
            .filter(|window| *window == pattern)
            .count()
    };
    let pairs = count(b"\r\n");
    pairs == count(b"\n") && pairs == bytes.len() - end
}

/// Skips whitespace and returns the next word of a header. Advances `offset` to the end of the word.
fn next_word(file: &[u8], offset: &mut usize) -> Result<String> {
    let is_blank = |byte: &&u8| matches!(byte, b' ' | b'\t' | b'\r' | b'\n');
    *offset += file[*offset..].iter().take_while(is_blank).count();
    let rest = file[*offset..].iter();
    let length = rest.take_while(|byte| byte.is_ascii_graphic()).count();
    let word = String::from_utf8_lossy(&file[*offset..*offset + length]).into_owned();
    *offset += length;
    match length {
        0 => Error::impossible(format!("the header cannot be read beyond byte {offset}")),
        _ => Ok(word),
    }
}

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
fn remove_overridden_records(bytes: Vec<u8>, changes: &mut Vec<String>) -> Result<Vec<u8>> {
    let dissection = Dissection::parse(&bytes);
    if let Err(error) = &dissection.outcome {
        return Err(error.clone().into());
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
            let removed = all - kept.len();
            changes.push(format!(
                "plane {plane}: removed {removed} records that later records override"
            ));
            let kept = kept.concat();
            edits.push((size, kept.len().to_string().into_bytes()));
            edits.push((side, kept));
        }
    }
    // Apply edits from the end, so that the ranges of earlier edits remain valid.
    edits.sort_by_key(|(range, _)| std::cmp::Reverse(range.start));
    let mut bytes = bytes;
    for (range, replacement) in edits {
        bytes.splice(range, replacement);
    }
    Ok(bytes)
}
