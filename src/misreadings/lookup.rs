//! §2.5 Lookup Table and §2.8 Lookup Table Indices

use super::anatomy::{Anatomy, Seen};
use super::at::At;
use super::layout::{PLANES, blocks, each, turned, turned_if};
use crate::decode::indices::take;
use crate::ptm::Format;

pub(super) const ACTS: &[(&str, At)] = &[
    (
        "lut-formats-swapped",
        At::Bytes(|file| match file.texts(&["2.2/1"])[..] {
            ["PTM_FORMAT_PTM_LUT"] => renamed(file, b"PTM_FORMAT_PTM_C_LUT"),
            ["PTM_FORMAT_PTM_C_LUT"] => renamed(file, b"PTM_FORMAT_PTM_LUT"),
            _ => file.unchanged(),
        }),
    ),
    (
        "c-lut-is-ptm-lut",
        At::Bytes(|file| match file.texts(&["2.2/1"])[..] {
            ["PTM_FORMAT_PTM_C_LUT"] => renamed(file, b"PTM_FORMAT_PTM_LUT"),
            _ => file.unchanged(),
        }),
    ),
    (
        "table-not-read",
        At::Bytes(|file| match (entries(file), entry_size(file)) {
            (Some(count), Some(size)) => Seen::File(
                [
                    file.header(),
                    &vec![0; count * size],
                    &file.file[file.payload()..],
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
            // Such a reader finds the indices 256 entries after the start of the table.
            let table = file.payload();
            match file.file.get(table + 256 * size..) {
                Some(rest) => Seen::File([&file.file[..table + count * size], rest].concat()),
                None => Seen::Refused,
            }
        }),
    ),
    (
        "table-one-entry-long",
        At::Bytes(|file| with_table(file, |table, size, count| Some((table, size * (count + 1))))),
    ),
    (
        "table-one-entry-short",
        At::Bytes(|file| {
            with_table(file, |table, size, count| {
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
            let table = file.payload();
            let step = size + 1;
            let bytes = (count * step).saturating_sub(1);
            let Some(rest) = file.file.get(table + bytes..) else {
                return Seen::Refused;
            };
            let found = (0..count)
                .flat_map(|entry| &file.file[table + entry * step..table + entry * step + size]);
            Seen::File(
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
        "table-in-planes",
        At::Bytes(|file| {
            rearranged(file, |table, size, count| {
                (0..count * size)
                    .map(|i| table[i % size * count + i / size])
                    .collect()
            })
        }),
    ),
    (
        "table-from-its-end",
        At::Bytes(|file| {
            rearranged(file, |table, size, _| {
                table.rchunks_exact(size).flatten().copied().collect()
            })
        }),
    ),
    (
        "table-entries-reversed",
        At::Bytes(|file| {
            rearranged(file, |table, size, _| {
                let turned = |entry: &[u8]| {
                    entry[..6]
                        .iter()
                        .rev()
                        .chain(&entry[6..])
                        .copied()
                        .collect::<Vec<_>>()
                };
                table.chunks_exact(size).flat_map(turned).collect()
            })
        }),
    ),
    (
        "c-lut-color-first",
        At::Bytes(|file| {
            rearranged(file, |table, size, _| {
                let turned = |entry: &[u8]| {
                    if size == 9 {
                        [&entry[3..], &entry[..3]].concat()
                    } else {
                        entry.to_vec()
                    }
                };
                table.chunks_exact(size).flat_map(turned).collect()
            })
        }),
    ),
    (
        "c-lut-bgr",
        At::Planes(|ptm| {
            if ptm.header.format == Format::PtmCLut {
                each(ptm, |texel| texel.swap(6, 8));
            }
        }),
    ),
    (
        "width-at-256",
        At::Indices(|table, size, input| {
            take(if table.entries < 256 { 1 } else { 2 }, size, input)
        }),
    ),
    (
        "width-at-255",
        At::Indices(|table, size, input| {
            take(if table.entries < 255 { 1 } else { 2 }, size, input)
        }),
    ),
    (
        "width-at-258",
        At::Indices(|table, size, input| {
            take(if table.entries <= 257 { 1 } else { 2 }, size, input)
        }),
    ),
    (
        "width-at-128",
        At::Indices(|table, size, input| {
            take(if table.entries <= 128 { 1 } else { 2 }, size, input)
        }),
    ),
    (
        "width-by-largest-index",
        At::Indices(|table, size, input| {
            let mut pairs = input.rest().chunks_exact(2).take(size.texels());
            let wide = table.entries > 256 && pairs.any(|pair| pair[1] != 0);
            take(if wide { 2 } else { 1 }, size, input)
        }),
    ),
    (
        "width-always-one",
        At::Indices(|_, size, input| take(1, size, input)),
    ),
    (
        "width-always-two",
        At::Indices(|_, size, input| take(2, size, input)),
    ),
    (
        "width-four-at-65536",
        At::Indices(|table, size, input| {
            let width = match table.entries {
                0..=256 => 1,
                257..65_536 => 2,
                _ => 4,
            };
            take(width, size, input)
        }),
    ),
    (
        "c-lut-width-at-256",
        At::Indices(|table, size, input| {
            // An entry of PTM_C_LUT has nine bytes, one of PTM_LUT six.
            let narrow = if table.entry_size == 9 { 255 } else { 256 };
            take(if table.entries <= narrow { 1 } else { 2 }, size, input)
        }),
    ),
    (
        "c-lut-width-always-one",
        At::Indices(|table, size, input| {
            let narrow = table.entries <= 256 || table.entry_size == 9;
            take(if narrow { 1 } else { 2 }, size, input)
        }),
    ),
    (
        "big-endian-index",
        At::Index(|stored| {
            stored
                .iter()
                .fold(0, |index, &byte| index << 8 | usize::from(byte))
        }),
    ),
    (
        "index-high-byte-ignored",
        At::Index(|stored| stored.first().map_or(0, |&low| usize::from(low))),
    ),
    (
        "index-signed",
        At::Index(|stored| match stored {
            [byte] => usize::from(*byte) | if *byte >= 128 { usize::MAX << 8 } else { 0 },
            _ => crate::decode::indices::little_endian(stored),
        }),
    ),
    (
        "wide-index-signed",
        At::Index(|stored| match stored {
            [_, high] if *high >= 128 => usize::MAX,
            _ => crate::decode::indices::little_endian(stored),
        }),
    ),
    (
        "wide-index-low-byte-signed",
        At::Index(|stored| match stored {
            [low, high] if *low >= 128 => {
                (usize::from(*high) << 8)
                    .wrapping_add(usize::from(*low))
                    .wrapping_sub(256)
                    & 0xffff
            }
            _ => crate::decode::indices::little_endian(stored),
        }),
    ),
    (
        "index-in-12-bits",
        At::Index(|stored| crate::decode::indices::little_endian(stored) & 0xfff),
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
    (
        "lut-colors-before-indices",
        At::Bytes(|file| {
            let (Some(Format::PtmLut), Some(count)) = (format(file), entries(file)) else {
                return file.unchanged();
            };
            let width = if count <= 256 { 1 } else { 2 };
            let (head, rest) = file
                .file
                .split_at((file.payload() + count * 6).min(file.file.len()));
            let indices = rest.len() / (width + 3) * width;
            let colors = rest.len() - indices;
            Seen::File([head, &rest[colors..], &rest[..colors]].concat())
        }),
    ),
    (
        "lut-index-and-color-interleaved",
        At::Bytes(|file| {
            let (Some(Format::PtmLut), Some(count)) = (format(file), entries(file)) else {
                return file.unchanged();
            };
            let width = if count <= 256 { 1 } else { 2 };
            let (head, rest) = file
                .file
                .split_at((file.payload() + count * 6).min(file.file.len()));
            let texels = || rest.chunks_exact(width + 3);
            let apart = texels()
                .flat_map(|texel| &texel[..width])
                .chain(texels().flat_map(|texel| &texel[width..]));
            Seen::File(head.iter().chain(apart).copied().collect())
        }),
    ),
    (
        "lut-colors-in-planes",
        At::Blocks(|format| blocks(format, Format::PtmLut, &PLANES[6..9])),
    ),
    (
        "lut-colors-bgr",
        At::Planes(|ptm| {
            if ptm.header.format == Format::PtmLut {
                each(ptm, |texel| texel.swap(6, 8));
            }
        }),
    ),
    (
        "lut-indices-top-down",
        At::Planes(|ptm| {
            if ptm.header.format.has_table() {
                turned(
                    ptm,
                    0..if ptm.header.format == Format::PtmCLut {
                        9
                    } else {
                        6
                    },
                );
            }
        }),
    ),
    (
        "lut-colors-top-down",
        At::Planes(|ptm| {
            if ptm.header.format == Format::PtmLut {
                turned(ptm, 6..9);
            }
        }),
    ),
    (
        "lut-rows-top-down",
        At::StoredRow(|header, row| turned_if(header.format.has_table(), header, row)),
    ),
    (
        "c-lut-rows-top-down",
        At::StoredRow(|header, row| turned_if(header.format == Format::PtmCLut, header, row)),
    ),
];

fn format(file: &Anatomy) -> Option<Format> {
    file.texts(&["2.2/1"]).first()?.parse().ok()
}

/// Entries of the largest table that a mistake makes room for: far more than an index of two bytes can name.
const MOST_ENTRIES: usize = 1 << 20;

/// The number of table entries, where the file gives one.
fn entries(file: &Anatomy) -> Option<usize> {
    format(file).filter(|format| format.has_table())?;
    file.texts(&["2.5/2"])
        .iter()
        .find_map(|text| text.parse().ok())
        .filter(|count| (1..=MOST_ENTRIES).contains(count))
}

fn entry_size(file: &Anatomy) -> Option<usize> {
    format(file).map(|format| if format == Format::PtmCLut { 9 } else { 6 })
}

fn renamed(file: &Anatomy, name: &[u8]) -> Seen {
    let mut bytes = file.file.to_vec();
    if let Some(field) = file.field("2.2/1", 0) {
        bytes.splice(field.range.clone(), name.iter().copied());
    }
    Seen::File(bytes)
}

/// The file with a table of another length, the rest after it: `length` gives where the table starts and its length.
fn with_table(file: &Anatomy, length: fn(usize, usize, usize) -> Option<(usize, usize)>) -> Seen {
    let (Some(count), Some(size)) = (entries(file), entry_size(file)) else {
        return file.unchanged();
    };
    let Some((start, length)) = length(file.payload(), size, count) else {
        return file.unchanged();
    };
    let Some(rest) = file.file.get(start + length..) else {
        return Seen::Refused;
    };
    let mut table = file.file[start..start + length].to_vec();
    table.resize(count * size, 0);
    Seen::File([file.header(), &table, rest].concat())
}

/// The file with its table's bytes in another order.
fn rearranged(file: &Anatomy, order: fn(&[u8], usize, usize) -> Vec<u8>) -> Seen {
    let (Some(count), Some(size)) = (entries(file), entry_size(file)) else {
        return file.unchanged();
    };
    let start = file.payload();
    match file.file.get(start..start + count * size) {
        Some(table) => Seen::File(
            [
                file.header(),
                &order(table, size, count),
                &file.file[start + count * size..],
            ]
            .concat(),
        ),
        None => file.unchanged(),
    }
}
