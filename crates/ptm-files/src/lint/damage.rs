//! Traces of damage in the payload that a decoder does not notice: a change of encoding, and lost sectors.

use super::{codes::Problem, diagnostic::Findings};
use crate::dissection::{Dissection, FilePart, Role};
use ptm::Format;

/// Size of the smallest block that a storage device loses.
const SECTOR_BYTES: usize = 512;
/// Length of the shortest run of equal bytes that is reported.
const MIN_LOST_SECTORS: usize = 8;

pub(super) fn diagnose(findings: &mut Findings) {
    let dissection = findings.dissection;
    let payload = dissection.parts.iter().find(|part| part.role.is_payload());
    let Some(start) = payload.map(|part| part.offset) else {
        return;
    };
    if let Some(surplus) = utf8_surplus(dissection, start) {
        let found = format!("each of {surplus} bytes above 127 became two bytes");
        // The bytes after the last value have the same cause.
        let trailing = Problem::Trailing.code().id;
        findings.list.retain(|finding| finding.code != trailing);
        findings.add_at(Problem::Utf8Payload, start, found);
    }
    report_lost_sectors(findings, start);
}

/// Returns the number of bytes that a conversion from Latin-1 to UTF-8 added to the payload, or `None` if the payload was not
/// converted: then it is no UTF-8 text of these characters, or its size differs from that of a converted payload.
fn utf8_surplus(dissection: &Dissection, start: usize) -> Option<usize> {
    let payload = &dissection.file[start..];
    // Most payloads are refused within the first bytes.
    let mut surplus = 0;
    let mut bytes = payload.iter();
    while let Some(byte) = bytes.next() {
        match byte {
            0..=0x7f => {}
            0xc2 | 0xc3 if matches!(bytes.next(), Some(0x80..=0xbf)) => surplus += 1,
            _ => return None,
        }
    }
    let expected = payload_bytes(dissection)?;
    (surplus > 0 && payload.len() - surplus == expected).then_some(surplus)
}

/// Returns the file before its payload was converted from Latin-1 to UTF-8, or `None` if it was not converted.
pub fn without_utf8(dissection: &Dissection) -> Option<Vec<u8>> {
    let payload = dissection
        .parts
        .iter()
        .find(|part| part.role.is_payload())?;
    utf8_surplus(dissection, payload.offset)?;
    let (header, payload) = dissection.file.split_at(payload.offset);
    let text = std::str::from_utf8(payload).ok()?;
    let bytes = text.chars().map(|character| character as u8);
    Some(header.iter().copied().chain(bytes).collect())
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
