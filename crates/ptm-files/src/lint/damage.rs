//! Traces of damage in the payload that a decoder does not notice: a change of encoding, and lost sectors.

use std::ops::Range;

use super::{codes::Problem, diagnostic::Findings};
use crate::dissection::{Dissection, FilePart, Role};
use ptm::Format;

/// Size of the smallest block that a storage device loses.
pub(super) const SECTOR_BYTES: usize = 512;
/// Number of sectors in the shortest run of equal bytes that is reported in streams and in indices of one byte.
const MIN_STREAM_SECTORS: usize = 8;
/// Smallest number of characters above 127 that identify a text whose size is wrong. Fewer may be coincidence in a small map.
const MIN_CHARACTERS: usize = 8;
/// Smallest number of characters above 127 that identify a text that was truncated to the right size.
const MIN_CHARACTERS_OF_RIGHT_SIZE: usize = 64;

pub(super) fn diagnose(findings: &mut Findings) {
    let dissection = findings.dissection;
    let Some(start) = payload_start(dissection) else {
        return;
    };
    match payload_damage(dissection) {
        Some(PayloadDamage::Text(text)) => {
            // The errors in the payload have the same cause.
            findings.list.retain(|finding| finding.offset < start);
            findings.add_at(Problem::Utf8Payload, start, text.found);
        }
        Some(PayloadDamage::Excess { needed, excess }) => {
            let trailing = Problem::Trailing.code().id;
            findings.list.retain(|finding| finding.code != trailing);
            let found =
                format!("{excess} bytes follow the {needed} bytes that the header announces");
            findings.add_at(Problem::Excess, start + needed, found);
        }
        None => report_lost_sectors(findings, start),
    }
}

fn payload_start(dissection: &Dissection) -> Option<usize> {
    let mut parts = dissection.parts.iter();
    parts
        .find(|part| part.role.is_payload())
        .map(|part| part.offset)
}

/// Damage to the values of a file that the reference may read nevertheless.
pub enum PayloadDamage {
    /// The payload was converted to UTF-8.
    Text(TextPayload),
    /// At least as many bytes as the values follow the last value.
    Excess {
        /// Number of bytes of the values.
        needed: usize,
        /// Number of bytes after the last value.
        excess: usize,
    },
}

/// Payload that was converted to UTF-8.
pub struct TextPayload {
    /// Description of the conversion.
    found: String,
    /// File before the conversion, if it is undone exactly: the result has the size that the header announces.
    pub restored: Option<Vec<u8>>,
}

/// Returns the damage to the values of a file, as far as the payload shows it.
pub fn payload_damage(dissection: &Dissection) -> Option<PayloadDamage> {
    let start = payload_start(dissection)?;
    let needed = payload_bytes(dissection)?;
    let payload = &dissection.file[start..];
    if let Some(text) = text_payload(dissection, start, needed) {
        return Some(PayloadDamage::Text(text));
    }
    let excess = payload.len().checked_sub(needed)?;
    let is_damage = excess >= needed.max(SECTOR_BYTES)
        // Equal bytes are padding.
        && payload[needed..].iter().any(|&byte| byte != payload[needed]);
    is_damage.then_some(PayloadDamage::Excess { needed, excess })
}

/// Recognizes a payload that was converted to UTF-8: it is UTF-8 text with many characters above 127. A binary payload is not.
fn text_payload(dissection: &Dissection, start: usize, needed: usize) -> Option<TextPayload> {
    let (header, payload) = dissection.file.split_at(start);
    // Most payloads are refused within the first bytes.
    let text = match std::str::from_utf8(payload) {
        Ok(text) => text,
        // The text was truncated within a character.
        Err(error) if error.error_len().is_none() => {
            std::str::from_utf8(&payload[..error.valid_up_to()]).ok()?
        }
        Err(_) => return None,
    };
    let is_whole = text.len() == payload.len();
    let high = text
        .chars()
        .filter(|character| !character.is_ascii())
        .count();
    if let Some((how, bytes)) = undo_conversion(text, needed).filter(|_| is_whole && high > 0) {
        return Some(TextPayload {
            found: format!("{how}; {high} bytes above 127 became longer"),
            restored: Some([header, &bytes].concat()),
        });
    }
    let min = if payload.len() == needed {
        MIN_CHARACTERS_OF_RIGHT_SIZE
    } else {
        MIN_CHARACTERS
    };
    if high < min {
        return None;
    }
    let lost = text
        .chars()
        .filter(|&character| character == char::REPLACEMENT_CHARACTER)
        .count();
    let characters = text.chars().count();
    let found = format!(
        "{characters} characters where the header announces {needed} bytes{}",
        match lost {
            0 => String::new(),
            _ => format!("; {lost} of them are U+FFFD, which replaced other bytes"),
        }
    );
    Some(TextPayload {
        found,
        restored: None,
    })
}

/// Undoes conversions from Latin-1 or Windows-1252 to UTF-8 until the text has `needed` bytes. Returns `None` if it never has.
fn undo_conversion(text: &str, needed: usize) -> Option<(String, Vec<u8>)> {
    let mut bytes = text.as_bytes().to_vec();
    let mut steps = Vec::new();
    while bytes.len() > needed {
        let text = std::str::from_utf8(&bytes).ok()?;
        let latin_1: Option<Vec<u8>> = text.chars().map(|one| u8::try_from(one).ok()).collect();
        let (name, undone) = if let Some(undone) = latin_1 {
            ("Latin-1", undone)
        } else {
            let windows_1252: Option<Vec<u8>> = text.chars().map(windows_1252_byte).collect();
            ("Windows-1252", windows_1252?)
        };
        // A text of ASCII characters does not become shorter.
        if undone.len() == bytes.len() {
            return None;
        }
        steps.push(name);
        bytes = undone;
    }
    let how = match &steps[..] {
        [name] => format!("from {name}"),
        [first, ..] if steps.iter().all(|name| name == first) => {
            format!("from {first}, {} times", steps.len())
        }
        _ => format!("from {}", steps.join(" and ")),
    };
    (bytes.len() == needed && !steps.is_empty()).then_some((how, bytes))
}

/// Returns the byte of a character in Windows-1252. The five bytes without a character are control characters.
fn windows_1252_byte(character: char) -> Option<u8> {
    const FROM_128: [char; 32] = [
        '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž',
        '\u{8f}', //
        '\u{90}', '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}', 'ž', 'Ÿ',
    ];
    match FROM_128.iter().position(|&one| one == character) {
        Some(place) => Some(128 + place as u8),
        None => u8::try_from(character)
            .ok()
            .filter(|byte| !(128..160).contains(byte)),
    }
}

/// Returns the number of bytes that the header announces for the whole file.
pub(super) fn announced_bytes(dissection: &Dissection) -> Option<usize> {
    payload_start(dissection)?.checked_add(payload_bytes(dissection)?)
}

/// Returns the number of bytes of the payload that the header announces.
fn payload_bytes(dissection: &Dissection) -> Option<usize> {
    let texels = dissection.size?.texels();
    let format = dissection.format?;
    let entry_bytes = match format {
        Format::Rgb | Format::Lrgb | Format::Lum => {
            return texels.checked_mul(format.channels());
        }
        Format::PtmLut => 6,
        Format::PtmCLut => 9,
        _ => {
            let planes = 0..dissection.compressed_planes();
            let roles = planes.flat_map(|plane| [Role::StreamSize(plane), Role::SideSize(plane)]);
            let mut sizes = roles.map(|role| usize::try_from(dissection.number(role)?).ok());
            return sizes.try_fold(0_usize, |sum, size| sum.checked_add(size?));
        }
    };
    let entries = dissection.entries()?;
    let index_bytes = if entries <= 256 { 1 } else { 2 };
    let color_bytes = if format == Format::PtmLut { 3 } else { 0 };
    let table = entries.checked_mul(entry_bytes)?;
    table.checked_add(texels.checked_mul(index_bytes + color_bytes)?)
}

/// Reports the longest run of equal bytes that looks like lost sectors, and the number of such runs.
fn report_lost_sectors(findings: &mut Findings, start: usize) {
    let dissection = findings.dissection;
    let length = dissection.file.len();
    let end =
        payload_bytes(dissection).map_or(length, |needed| length.min(start.saturating_add(needed)));
    let mut runs = runs_with_sectors(&dissection.file[..end], start);
    runs.retain(|run| is_loss(dissection, &(start..end), run));
    let Some(longest) = runs
        .iter()
        .max_by_key(|run| (run.len(), usize::MAX - run.start))
    else {
        return;
    };
    let (length, byte) = (longest.len(), dissection.file[longest.start]);
    let more = match runs.len() {
        1 => String::new(),
        count => format!("; {count} runs in all"),
    };
    let found = format!("{length} bytes are 0x{byte:02x}{more}");
    findings.add_at(Problem::LostSectors, longest.start, found);
}

/// Returns the runs of equal bytes from `start` that contain a whole sector or are at the end.
fn runs_with_sectors(bytes: &[u8], start: usize) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let mut next = start.next_multiple_of(SECTOR_BYTES);
    while let Some(sector) = bytes.get(next..next + SECTOR_BYTES) {
        if sector.iter().all(|&byte| byte == sector[0]) {
            let run = run_around(bytes, start, next);
            next = run.end.next_multiple_of(SECTOR_BYTES);
            runs.push(run);
        } else {
            next += SECTOR_BYTES;
        }
    }
    if start < bytes.len() && runs.last().is_none_or(|run| run.end < bytes.len()) {
        runs.push(run_around(bytes, start, bytes.len() - 1));
    }
    runs
}

/// Returns the run of equal bytes from `start` that contains `place`.
fn run_around(bytes: &[u8], start: usize, place: usize) -> Range<usize> {
    let is_equal = |byte: &&u8| **byte == bytes[place];
    let before = bytes[start..place]
        .iter()
        .rev()
        .take_while(is_equal)
        .count();
    let after = bytes[place..].iter().take_while(is_equal).count();
    place - before..place + after
}

/// Returns true if a run of equal bytes is long enough for a lost sector and is not a part of the image. `values` is the range of
/// all values in the file.
fn is_loss(dissection: &Dissection, values: &Range<usize>, run: &Range<usize>) -> bool {
    let sectors = (run.end / SECTOR_BYTES).saturating_sub(run.start.div_ceil(SECTOR_BYTES));
    let is_compressed = dissection.format.and_then(Format::coding).is_some();
    // The stream of a constant plane may consist of equal bytes.
    let needed = if is_compressed { MIN_STREAM_SECTORS } else { 1 };
    let is_tail = run.end == values.end && run.len() >= SECTOR_BYTES / 2;
    let is_long = sectors >= needed || is_tail;
    is_long && run != values && (is_compressed || !is_in_image(dissection, run))
}

/// Uncompressed values of all texels: a block or the indices.
struct TexelBlock {
    range: Range<usize>,
    texel_bytes: usize,
    row_bytes: usize,
}

impl TexelBlock {
    fn all(dissection: &Dissection) -> Vec<TexelBlock> {
        let size = dissection.size.filter(|size| size.texels() > 0);
        let parts = dissection.parts.iter();
        let blocks = parts.filter(|part| matches!(part.role, Role::Block(_) | Role::Indices));
        let block = |part: &FilePart| {
            let length = part
                .full_length
                .map_or(part.length, |length| length as usize);
            let texel_bytes = length / size?.texels();
            let block = TexelBlock {
                range: part.offset..part.offset + length,
                texel_bytes,
                row_bytes: texel_bytes * size?.width as usize,
            };
            (texel_bytes > 0).then_some(block)
        };
        blocks.filter_map(block).collect()
    }

    fn begins_texel(&self, offset: usize) -> bool {
        (offset - self.range.start).is_multiple_of(self.texel_bytes)
    }

    fn begins_row(&self, offset: usize) -> bool {
        (offset - self.range.start).is_multiple_of(self.row_bytes)
    }

    /// Returns true if the texels whose values in `other` are completely in `run` have equal values in this block. Texels after the
    /// end of the file are ignored.
    fn is_constant(&self, file: &[u8], other: &TexelBlock, run: &Range<usize>) -> bool {
        let first = (run.start - other.range.start).div_ceil(other.texel_bytes);
        let last = (run.end - other.range.start) / other.texel_bytes;
        let [from, to] = [first, last].map(|texel| {
            let offset = self.range.start + texel * self.texel_bytes;
            offset.min(file.len())
        });
        let values = &file[from..to.max(from)];
        let texels = values.chunks_exact(self.texel_bytes);
        texels
            .clone()
            .zip(texels.skip(1))
            .all(|(one, next)| one == next)
    }
}

/// Returns true if a run of equal bytes may be a part of the image: it consists of whole texels, and the other values of these
/// texels do not contradict that.
fn is_in_image(dissection: &Dissection, run: &Range<usize>) -> bool {
    let file = dissection.file;
    let blocks = TexelBlock::all(dissection);
    let block_of = |offset: usize| blocks.iter().find(|block| block.range.contains(&offset));
    let (Some(first), Some(last)) = (block_of(run.start), block_of(run.end - 1)) else {
        // A table may have unused entries.
        return true;
    };
    let is_whole_texels = first.begins_texel(run.start) && last.begins_texel(run.end);
    let reaches_end = run.end == file.len() || run.end == blocks[blocks.len() - 1].range.end;
    let is_whole_rows = match reaches_end {
        true => first.begins_row(run.start),
        false => is_whole_texels && last.begins_row(run.end),
    };
    if is_whole_rows {
        return true;
    }
    if first.range != last.range {
        return is_whole_texels && !reaches_end;
    }
    // Indices of one byte are always whole, so only exact sectors are remarkable.
    if first.texel_bytes == 1 {
        let is_boundary = |offset: usize| offset.is_multiple_of(SECTOR_BYTES);
        let is_exact = is_boundary(run.start) && (is_boundary(run.end) || reaches_end);
        return !is_exact || run.len() < MIN_STREAM_SECTORS * SECTOR_BYTES;
    }
    match (dissection.format, &blocks[..]) {
        // A dark or masked part of an object has neither luminance nor color.
        (Some(Format::Lrgb), [luminance, color]) if first.range == luminance.range => {
            color.is_constant(file, luminance, run)
        }
        // White or black texels are common, but seldom up to the end.
        (Some(Format::Lrgb), [luminance, color]) => {
            is_whole_texels && !reaches_end || luminance.is_constant(file, color, run)
        }
        _ => is_whole_texels,
    }
}
