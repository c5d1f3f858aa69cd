//! §2.5 Lookup Table and §2.8 Lookup Table Indices: mistakes with tables and indices

use super::anatomy::{Anatomy, EditedFile};
use super::at::At;
use crate::decode::indices::read_indices_of_width;
use crate::ptm::Format;

pub(super) const CHANGES: &[(&str, At)] = &[
    (
        "lut-formats-swapped",
        At::Bytes(|file| match file.field_texts(&["2.2/1"])[..] {
            ["PTM_FORMAT_PTM_LUT"] => rename_format(file, b"PTM_FORMAT_PTM_C_LUT"),
            ["PTM_FORMAT_PTM_C_LUT"] => rename_format(file, b"PTM_FORMAT_PTM_LUT"),
            _ => file.unchanged(),
        }),
    ),
    (
        "c-lut-is-ptm-lut",
        At::Bytes(|file| match file.field_texts(&["2.2/1"])[..] {
            ["PTM_FORMAT_PTM_C_LUT"] => rename_format(file, b"PTM_FORMAT_PTM_LUT"),
            _ => file.unchanged(),
        }),
    ),
    (
        "table-not-read",
        At::Bytes(|file| match (entries(file), entry_size(file)) {
            (Some(count), Some(size)) => EditedFile::File(
                [
                    file.header(),
                    &vec![0; count * size],
                    &file.file[file.payload_offset()..],
                ]
                .concat(),
            ),
            _ => file.unchanged(),
        }),
    ),
    (
        "c-lut-with-colors-behind",
        At::Blocks(|format| {
            crate::decode::texels::blocks(if format == Format::PtmCLut {
                Format::PtmLut
            } else {
                format
            })
        }),
    ),
    (
        "table-padded-to-256",
        At::Bytes(|file| {
            let (Some(count), Some(size)) = (entries(file), entry_size(file)) else {
                return file.unchanged();
            };
            if count >= 256 {
                return file.unchanged();
            }
            // The indices are read 256 entries after the start of the table.
            let table = file.payload_offset();
            match file.file.get(table + 256 * size..) {
                Some(rest) => EditedFile::File([&file.file[..table + count * size], rest].concat()),
                None => EditedFile::Refused,
            }
        }),
    ),
    (
        "table-one-entry-long",
        At::Bytes(|file| {
            resize_table(file, |table, size, count| Some((table, size * (count + 1))))
        }),
    ),
    (
        "table-one-entry-short",
        At::Bytes(|file| {
            resize_table(file, |table, size, count| {
                (count > 1).then(|| (table, size * (count - 1)))
            })
        }),
    ),
    (
        "table-separated",
        At::Bytes(|file| {
            let (Some(count), Some(size)) = (entries(file), entry_size(file)) else {
                return file.unchanged();
            };
            let table = file.payload_offset();
            let step = size + 1;
            let bytes = (count * step).saturating_sub(1);
            let Some(rest) = file.file.get(table + bytes..) else {
                return EditedFile::Refused;
            };
            let found = (0..count)
                .flat_map(|entry| &file.file[table + entry * step..table + entry * step + size]);
            EditedFile::File(
                file.header()
                    .iter()
                    .chain(found)
                    .chain(rest)
                    .copied()
                    .collect(),
            )
        }),
    ),
    (
        "width-by-largest-index",
        At::Indices(|table, size, input| {
            let mut pairs = input.rest().chunks_exact(2).take(size.texels());
            let wide = table.entries > 256 && pairs.any(|pair| pair[1] != 0);
            read_indices_of_width(if wide { 2 } else { 1 }, size, input)
        }),
    ),
    (
        "index-signed",
        At::Index(|stored| match stored {
            [byte] => usize::from(*byte) | if *byte >= 128 { usize::MAX << 8 } else { 0 },
            _ => crate::decode::indices::little_endian(stored),
        }),
    ),
    (
        "index-one-based",
        At::Entry(|index, entries| index.checked_sub(1).filter(|&index| index < entries)),
    ),
    (
        "index-clamped",
        At::Entry(|index, entries| Some(index.min(entries.saturating_sub(1)))),
    ),
    ("index-wraps", At::Entry(usize::checked_rem)),
    (
        "index-past-the-table-is-0",
        At::Entry(|index, entries| Some(if index < entries { index } else { 0 })),
    ),
    (
        "index-limit-off-by-one",
        At::Entry(|index, entries| {
            if index == entries {
                Some(0)
            } else {
                (index < entries).then_some(index)
            }
        }),
    ),
];

fn format(file: &Anatomy) -> Option<Format> {
    file.field_texts(&["2.2/1"]).first()?.parse().ok()
}

/// Maximum number of table entries that a mistake allocates, which is far more than two-byte indices can address.
const MAX_ENTRIES: usize = 1 << 20;

/// Returns the number of table entries, if the file has a table.
fn entries(file: &Anatomy) -> Option<usize> {
    format(file).filter(|format| format.has_table())?;
    file.field_texts(&["2.5/2"])
        .iter()
        .find_map(|text| text.parse().ok())
        .filter(|count| (1..=MAX_ENTRIES).contains(count))
}

fn entry_size(file: &Anatomy) -> Option<usize> {
    format(file).map(Format::entry_size)
}

fn rename_format(file: &Anatomy, name: &[u8]) -> EditedFile {
    let mut bytes = file.file.to_vec();
    if let Some(field) = file.nth_field("2.2/1", 0) {
        bytes.splice(field.range.clone(), name.iter().copied());
    }
    EditedFile::File(bytes)
}

/// Changes the length of the table. `length` returns the start of the table and its new length.
fn resize_table(
    file: &Anatomy,
    length: fn(usize, usize, usize) -> Option<(usize, usize)>,
) -> EditedFile {
    let (Some(count), Some(size)) = (entries(file), entry_size(file)) else {
        return file.unchanged();
    };
    let Some((start, length)) = length(file.payload_offset(), size, count) else {
        return file.unchanged();
    };
    let Some(rest) = file.file.get(start + length..) else {
        return EditedFile::Refused;
    };
    let mut table = file.file[start..start + length].to_vec();
    table.resize(count * size, 0);
    EditedFile::File([file.header(), &table, rest].concat())
}
