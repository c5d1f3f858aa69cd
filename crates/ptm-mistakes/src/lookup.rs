//! §2.5 Lookup Table and §2.8 Lookup Table Indices: mistakes in reading tables and indices

use super::anatomy::{Anatomy, EditedFile};
use super::change::{Change, Changes};
use ptm::Format;
use ptm::decode::indices::read_indices_of_width;

pub const CHANGES: Changes = |slug| {
    Some(match slug {
        "lut-formats-swapped" => Change::Bytes(|file| match file.field_texts(&["2.2/1"])[..] {
            ["PTM_FORMAT_PTM_LUT"] => rename_format(file, b"PTM_FORMAT_PTM_C_LUT"),
            ["PTM_FORMAT_PTM_C_LUT"] => rename_format(file, b"PTM_FORMAT_PTM_LUT"),
            _ => file.unchanged(),
        }),
        "c-lut-is-ptm-lut" => Change::Bytes(|file| match file.field_texts(&["2.2/1"])[..] {
            ["PTM_FORMAT_PTM_C_LUT"] => rename_format(file, b"PTM_FORMAT_PTM_LUT"),
            _ => file.unchanged(),
        }),
        "table-not-read" => Change::Bytes(|file| match table_size(file) {
            Some((count, size)) => {
                file.with_payload(&[&vec![0; count * size], file.payload()].concat())
            }
            None => file.unchanged(),
        }),
        "c-lut-with-colors-behind" => Change::Reading(|r| {
            r.blocks = |format| {
                ptm::decode::texels::blocks(match format {
                    Format::PtmCLut => Format::PtmLut,
                    other => other,
                })
            };
        }),
        "table-padded-to-256" => Change::Bytes(|file| {
            let Some((count @ ..256, size)) = table_size(file) else {
                return file.unchanged();
            };
            // The indices are read 256 entries after the start of the table.
            match file.payload().get(256 * size..) {
                Some(rest) => file.with_payload(&[&file.payload()[..count * size], rest].concat()),
                None => EditedFile::Refused,
            }
        }),
        "table-one-entry-long" => Change::Bytes(|file| resize_table(file, |count| count + 1)),
        "table-one-entry-short" => Change::Bytes(|file| resize_table(file, |count| count - 1)),
        "table-separated" => Change::Bytes(|file| {
            let Some((count, size)) = table_size(file) else {
                return file.unchanged();
            };
            let payload = file.payload();
            let Some(rest) = payload.get(count * (size + 1) - 1..) else {
                return EditedFile::Refused;
            };
            let entries = payload.chunks(size + 1).take(count);
            let mut parts: Vec<&[u8]> = entries.map(|entry| &entry[..size]).collect();
            parts.push(rest);
            file.with_payload(&parts.concat())
        }),
        "width-by-largest-index" => Change::Reading(|r| {
            r.indices = |table, size, input| {
                let mut pairs = input.rest().chunks_exact(2).take(size.texels());
                let wide = table.entries > 256 && pairs.any(|pair| pair[1] != 0);
                read_indices_of_width(if wide { 2 } else { 1 }, size, input)
            };
        }),
        "index-signed" => Change::Reading(|r| {
            r.index = |stored| match stored {
                [byte] => usize::from(*byte) | if *byte >= 128 { usize::MAX << 8 } else { 0 },
                _ => ptm::decode::indices::little_endian(stored),
            };
        }),
        "index-bytes-signed" => Change::Reading(|r| {
            r.index = |stored| {
                let bytes = stored
                    .iter()
                    .rev()
                    .map(|byte| isize::from(byte.cast_signed()));
                // A negative index is past every table.
                bytes
                    .fold(0, |index, byte| 256 * index + byte)
                    .cast_unsigned()
            };
        }),
        "index-one-based" => Change::Reading(|r| {
            r.entry = |index, entries| index.checked_sub(1).filter(|&index| index < entries);
        }),
        "index-clamped" => Change::Reading(|r| {
            r.entry = |index, entries| Some(index.min(entries.saturating_sub(1)));
        }),
        "index-wraps" => Change::Reading(|r| r.entry = usize::checked_rem),
        "index-past-the-table-is-0" => Change::Reading(|r| {
            r.entry = |index, entries| Some(if index < entries { index } else { 0 });
        }),
        "index-limit-off-by-one" => Change::Reading(|r| {
            r.entry = |index, entries| {
                (index <= entries).then_some(if index == entries { 0 } else { index })
            };
        }),
        _ => return None,
    })
};

/// Maximum number of table entries in files that a mistake edits. The limit bounds the memory used. It far exceeds the number
/// that two-byte indices can address.
const MAX_ENTRIES: usize = 1 << 20;

/// Returns the number of table entries and the size of an entry in bytes, if the file has a table.
fn table_size(file: &Anatomy) -> Option<(usize, usize)> {
    let format: Format = file.field_texts(&["2.2/1"]).first()?.parse().ok()?;
    let mut counts = file.field_texts(&["2.5/2"]).into_iter();
    let count = counts.find_map(|text| text.parse().ok())?;
    let is_table = format.has_table() && (1..=MAX_ENTRIES).contains(&count);
    is_table.then(|| (count, format.entry_size()))
}

fn rename_format(file: &Anatomy, name: &[u8]) -> EditedFile {
    let mut bytes = file.file.to_vec();
    if let Some(field) = file.nth_field("2.2/1", 0) {
        bytes.splice(field.range.clone(), name.iter().copied());
    }
    EditedFile::File(bytes)
}

/// Edits a file so that it contains what a decoder would see if it assumed `new_count(count)` table entries. Leaves the file
/// unchanged if `new_count` returns 0.
fn resize_table(file: &Anatomy, new_count: fn(usize) -> usize) -> EditedFile {
    let size = table_size(file).filter(|&(count, _)| new_count(count) > 0);
    let Some((count, size)) = size else {
        return file.unchanged();
    };
    let Some((table, rest)) = file.payload().split_at_checked(new_count(count) * size) else {
        return EditedFile::Refused;
    };
    let mut table = table.to_vec();
    table.resize(count * size, 0);
    file.with_payload(&[&table, rest].concat())
}
