//! Traces of damage in the payload that a decoder does not notice: a change of encoding, and lost sectors.

use super::{codes::Problem, diagnostic::Findings};
use crate::dissection::{Dissection, FilePart, Role};
use ptm::Format;

/// Size of the smallest block that a storage device loses.
const SECTOR_BYTES: usize = 512;
/// Length of the shortest run of equal bytes that is reported.
const MIN_LOST_SECTORS: usize = 8;

/// Smallest number of characters above 127 that identify a text. Fewer may be coincidence in a small map.
const MIN_CHARACTERS: usize = 8;

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
pub(crate) enum PayloadDamage {
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
pub(crate) struct TextPayload {
    /// Description of the conversion.
    found: String,
    /// File before the conversion, if it is undone exactly: the result has the size that the header announces.
    pub(crate) restored: Option<Vec<u8>>,
}

/// Returns the damage to the values of a file, as far as the payload shows it.
pub(crate) fn payload_damage(dissection: &Dissection) -> Option<PayloadDamage> {
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

/// Recognizes a payload that was converted to UTF-8: it is UTF-8 text and does not have the size that the header announces.
fn text_payload(dissection: &Dissection, start: usize, needed: usize) -> Option<TextPayload> {
    let (header, payload) = dissection.file.split_at(start);
    if payload.len() == needed {
        return None;
    }
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
    if high < MIN_CHARACTERS {
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
        let (name, undone) = match latin_1 {
            Some(undone) => ("Latin-1", undone),
            None => {
                let windows_1252: Option<Vec<u8>> = text.chars().map(windows_1252_byte).collect();
                ("Windows-1252", windows_1252?)
            }
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
    let mut runs = Vec::new();
    let mut next = start.next_multiple_of(SECTOR_BYTES);
    while next < dissection.file.len() {
        let sectors = equal_sectors(&dissection.file[next..]);
        let end = (next + sectors * SECTOR_BYTES).min(dissection.file.len());
        if sectors >= MIN_LOST_SECTORS && is_loss(dissection, next, end) {
            runs.push(next..end);
        }
        next += SECTOR_BYTES * sectors.max(1);
    }
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

/// Returns the number of sectors at the start of `bytes` that consist of one byte value. The last sector may be incomplete.
fn equal_sectors(bytes: &[u8]) -> usize {
    let first = bytes.first();
    let is_equal = |sector: &&[u8]| sector.iter().all(|byte| Some(byte) == first);
    bytes.chunks(SECTOR_BYTES).take_while(is_equal).count()
}

/// Returns true if the run of equal bytes ends exactly at the sectors, and is not a part of the image: a run that ends at the end
/// of a row, or begins at the start of a row and ends with the file.
fn is_loss(dissection: &Dissection, start: usize, end: usize) -> bool {
    let file = dissection.file;
    let value = file[start];
    if file[start - 1] == value || file.get(end) == Some(&value) {
        return false;
    }
    let boundary = if end == file.len() { start } else { end };
    !is_row_boundary(dissection, boundary)
}

/// Returns true if a row of an uncompressed block begins at `offset`.
fn is_row_boundary(dissection: &Dissection, offset: usize) -> bool {
    let rows = dissection.size.map_or(0, |size| size.height as usize);
    let is_block = |part: &&FilePart| matches!(part.role, Role::Block(_) | Role::Indices);
    let mut blocks = dissection.parts.iter().filter(is_block);
    blocks.any(|part| {
        let length = part
            .full_length
            .map_or(part.length, |length| length as usize);
        let row = length.checked_div(rows).filter(|&row| row > 0);
        let relative = offset.checked_sub(part.offset);
        relative
            .zip(row)
            .is_some_and(|(relative, row)| relative <= length && relative.is_multiple_of(row))
    })
}
