//! §2.5 Lookup Table and §2.8 Lookup Table Indices

use super::layout::{each, one, stored_row};
use super::{Anatomy, At, Decision, Misreading, Seen};
use crate::ptm::Format;
use crate::reading::Reading;

pub(super) const ALL: &[Misreading] = &[
    Misreading {
        slug: "lut-formats-swapped",
        clause: "2.5/4",
        effect: "takes PTM_LUT for PTM_C_LUT and the other way round",
        mend: "C_LUT has the colors in its table",
        at: At::Bytes(|file| match file.texts(&["2.2/1"])[..] {
            ["PTM_FORMAT_PTM_LUT"] => renamed(file, b"PTM_FORMAT_PTM_C_LUT"),
            ["PTM_FORMAT_PTM_C_LUT"] => renamed(file, b"PTM_FORMAT_PTM_LUT"),
            _ => file.unchanged(),
        }),
    },
    Misreading {
        slug: "c-lut-is-ptm-lut",
        clause: "2.5/5",
        effect: "reads PTM_C_LUT as PTM_LUT",
        mend: "entries of PTM_C_LUT have nine bytes, and no colors follow the indices",
        at: At::Bytes(|file| match file.texts(&["2.2/1"])[..] {
            ["PTM_FORMAT_PTM_C_LUT"] => renamed(file, b"PTM_FORMAT_PTM_LUT"),
            _ => file.unchanged(),
        }),
    },
    Misreading {
        slug: "table-not-read",
        clause: "2.5/1",
        effect: "takes the table for indices",
        mend: "the table stands between the count and the indices",
        at: At::Bytes(|file| match (entries(file), entry_size(file)) {
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
    },
    Misreading {
        slug: "c-lut-with-colors-behind",
        clause: "2.8.2/1",
        effect: "expects colors after the indices of a PTM_C_LUT",
        mend: "the colors of PTM_C_LUT are in its table",
        at: At::Reading(Decision::Blocks, |r| Reading {
            blocks: |format| {
                crate::decode::texels::blocks(if format == Format::PtmCLut {
                    Format::PtmLut
                } else {
                    format
                })
            },
            ..r
        }),
    },
    Misreading {
        slug: "table-padded-to-256",
        clause: "2.5/3",
        effect: "expects room for 256 entries whatever their number",
        mend: "the table has as many entries as its count says",
        at: At::Bytes(|file| {
            let (Some(count), Some(size)) = (entries(file), entry_size(file)) else {
                return file.unchanged();
            };
            if count >= 256 {
                return file.unchanged();
            }
            // Such a reader finds the indices 256 entries behind the beginning of the table.
            let table = file.payload();
            match file.file.get(table + 256 * size..) {
                Some(rest) => Seen::File([&file.file[..table + count * size], rest].concat()),
                None => Seen::Refused,
            }
        }),
    },
    Misreading {
        slug: "table-one-entry-long",
        clause: "2.5/2",
        effect: "takes the count for the last index and reads one more entry",
        mend: "the count is the number of entries",
        at: At::Bytes(|file| {
            with_table(file, |table, size, count| Some((table, size * (count + 1))))
        }),
    },
    Misreading {
        slug: "table-one-entry-short",
        clause: "2.5/2",
        effect: "reads one entry less than the table has",
        mend: "the count is the number of entries",
        at: At::Bytes(|file| {
            with_table(file, |table, size, count| {
                (count > 1).then(|| (table, size * (count - 1)))
            })
        }),
    },
    Misreading {
        slug: "table-separated",
        clause: "2.5/3",
        effect: "expects a byte between the entries of the table",
        mend: "no characters stand between entries",
        at: At::Bytes(|file| {
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
    },
    Misreading {
        slug: "table-in-planes",
        clause: "2.5/3",
        effect: "reads the table as all a0, all a1 and so on",
        mend: "the table is stored entry after entry",
        at: At::Bytes(|file| {
            rearranged(file, |table, size, count| {
                (0..count * size)
                    .map(|i| table[i % size * count + i / size])
                    .collect()
            })
        }),
    },
    Misreading {
        slug: "table-from-its-end",
        clause: "2.5/3",
        effect: "counts entries from the end of the table",
        mend: "index 0 is the first entry",
        at: At::Bytes(|file| {
            rearranged(file, |table, size, _| {
                table.rchunks_exact(size).flatten().copied().collect()
            })
        }),
    },
    Misreading {
        slug: "table-entries-reversed",
        clause: "2.5/4",
        effect: "reads the coefficients of an entry from a5 to a0",
        mend: "an entry runs from a0 to a5",
        at: At::Bytes(|file| {
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
    },
    Misreading {
        slug: "c-lut-color-first",
        clause: "2.5/5",
        effect: "reads R, G, B before the coefficients of an entry",
        mend: "an entry of PTM_C_LUT is a0…a5, R, G, B",
        at: At::Bytes(|file| {
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
    },
    Misreading {
        slug: "c-lut-bgr",
        clause: "2.5/5",
        effect: "reads the color of a PTM_C_LUT entry as B, G, R",
        mend: "the order is R, G, B",
        at: At::Planes(|ptm| {
            if ptm.header.format == Format::PtmCLut {
                each(ptm, |texel| texel.swap(6, 8));
            }
        }),
    },
    index_width(
        "width-at-256",
        "2.8.1/2",
        "uses two bytes for an index already at 256 entries",
        |r| Reading {
            index_width: |_, entries, _, _| if entries < 256 { 1 } else { 2 },
            ..r
        },
    ),
    index_width(
        "width-at-255",
        "2.8.1/2",
        "uses two bytes for an index already at 255 entries",
        |r| Reading {
            index_width: |_, entries, _, _| if entries < 255 { 1 } else { 2 },
            ..r
        },
    ),
    index_width(
        "width-at-258",
        "2.8.1/3",
        "uses one byte for an index still at 257 entries",
        |r| Reading {
            index_width: |_, entries, _, _| if entries <= 257 { 1 } else { 2 },
            ..r
        },
    ),
    index_width(
        "width-at-128",
        "2.8.1/2",
        "uses two bytes for an index above 128 entries",
        |r| Reading {
            index_width: |_, entries, _, _| if entries <= 128 { 1 } else { 2 },
            ..r
        },
    ),
    index_width(
        "width-by-largest-index",
        "2.8.1/3",
        "uses one byte for an index where no index exceeds 255",
        |r| Reading {
            index_width: |_, entries, stored, texels| {
                let wide = stored.chunks_exact(2).take(texels).any(|pair| pair[1] != 0);
                if entries <= 256 || !wide { 1 } else { 2 }
            },
            ..r
        },
    ),
    index_width(
        "width-always-one",
        "2.8.1/3",
        "uses one byte for every index",
        |r| Reading {
            index_width: |_, _, _, _| 1,
            ..r
        },
    ),
    index_width(
        "width-always-two",
        "2.8.1/2",
        "uses two bytes for every index",
        |r| Reading {
            index_width: |_, _, _, _| 2,
            ..r
        },
    ),
    index_width(
        "width-four-at-65536",
        "2.8.1/3",
        "uses four bytes for an index at 65,536 entries",
        |r| Reading {
            index_width: |_, entries, _, _| match entries {
                0..=256 => 1,
                257..65_536 => 2,
                _ => 4,
            },
            ..r
        },
    ),
    index_width(
        "c-lut-width-at-256",
        "2.8.2/2",
        "uses two bytes for an index of PTM_C_LUT already at 256 entries",
        |r| Reading {
            index_width: |format, entries, _, _| {
                if entries < 256 || (entries == 256 && format == Format::PtmLut) {
                    1
                } else {
                    2
                }
            },
            ..r
        },
    ),
    index_width(
        "c-lut-width-always-one",
        "2.8.2/3",
        "uses one byte for every index of PTM_C_LUT",
        |r| Reading {
            index_width: |format, entries, _, _| {
                if entries <= 256 || format == Format::PtmCLut {
                    1
                } else {
                    2
                }
            },
            ..r
        },
    ),
    index(
        "big-endian-index",
        "2.8.1/3",
        "reads the high byte of an index first",
        "the low byte comes first",
        |r| Reading {
            index: |stored| {
                stored
                    .iter()
                    .fold(0, |index, &byte| index << 8 | usize::from(byte))
            },
            ..r
        },
    ),
    index(
        "index-high-byte-ignored",
        "2.8.1/3",
        "ignores the high byte of an index",
        "use both bytes",
        |r| Reading {
            index: |stored| usize::from(stored[0]),
            ..r
        },
    ),
    index(
        "index-signed",
        "2.8.1/1",
        "reads one-byte indices as signed numbers",
        "they are unsigned",
        |r| Reading {
            index: |stored| match stored {
                [byte] => usize::from(*byte) | if *byte >= 128 { usize::MAX << 8 } else { 0 },
                _ => crate::decode::indices::little_endian(stored),
            },
            ..r
        },
    ),
    index(
        "wide-index-signed",
        "2.8.1/3",
        "reads two-byte indices as signed numbers",
        "they are unsigned",
        |r| Reading {
            index: |stored| match stored {
                [_, high] if *high >= 128 => usize::MAX,
                _ => crate::decode::indices::little_endian(stored),
            },
            ..r
        },
    ),
    index(
        "wide-index-low-byte-signed",
        "2.8.1/3",
        "sign-extends the low byte of a two-byte index",
        "both bytes are unsigned",
        |r| Reading {
            index: |stored| match stored {
                [low, high] if *low >= 128 => {
                    (usize::from(*high) << 8)
                        .wrapping_add(usize::from(*low))
                        .wrapping_sub(256)
                        & 0xffff
                }
                _ => crate::decode::indices::little_endian(stored),
            },
            ..r
        },
    ),
    index(
        "index-in-12-bits",
        "2.8.1/3",
        "keeps twelve bits of an index",
        "use both bytes",
        |r| Reading {
            index: |stored| crate::decode::indices::little_endian(stored) & 0xfff,
            ..r
        },
    ),
    entry(
        "index-one-based",
        "2.8/1",
        "counts entries from one",
        "index 0 is the first entry",
        |r| Reading {
            entry: |index, entries| index.checked_sub(1).filter(|&index| index < entries),
            ..r
        },
    ),
    entry(
        "index-clamped",
        "2.8/1",
        "takes an index past the table for the last entry",
        "refuse it",
        |r| Reading {
            entry: |index, entries| Some(index.min(entries.saturating_sub(1))),
            ..r
        },
    ),
    entry(
        "index-wraps",
        "2.8/1",
        "takes an index past the table modulo the number of entries",
        "refuse it",
        |r| Reading {
            entry: |index, entries| index.checked_rem(entries),
            ..r
        },
    ),
    entry(
        "index-past-the-table-is-0",
        "2.8/1",
        "takes an index past the table for the first entry",
        "refuse it",
        |r| Reading {
            entry: |index, entries| Some(if index < entries { index } else { 0 }),
            ..r
        },
    ),
    Misreading {
        slug: "index-limit-off-by-one",
        clause: "2.8/1",
        effect: "accepts an index equal to the number of entries, and reads on behind the table",
        mend: "the last index is the number of entries minus one",
        at: At::Reading(Decision::Entry, |r| Reading {
            entry: |index, entries| {
                if index == entries {
                    Some(0)
                } else {
                    (index < entries).then_some(index)
                }
            },
            ..r
        }),
    },
    Misreading {
        slug: "lut-colors-before-indices",
        clause: "2.8.1/4",
        effect: "reads the colors of a PTM_LUT before its indices",
        mend: "the indices of all texels come first",
        at: At::Bytes(|file| {
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
    },
    Misreading {
        slug: "lut-index-and-color-interleaved",
        clause: "2.8.1/4",
        effect: "reads the index and the color of each texel of a PTM_LUT side by side",
        mend: "the indices of all texels come first",
        at: At::Bytes(|file| {
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
    },
    Misreading {
        slug: "lut-colors-in-planes",
        clause: "2.8.1/4",
        effect: "reads all R, all G, all B of a PTM_LUT",
        mend: "colors are stored texel after texel",
        at: At::Reading(Decision::Blocks, |r| Reading {
            blocks: |format| match format {
                Format::PtmLut => const { &[one(6), one(7), one(8)] },
                _ => crate::decode::texels::blocks(format),
            },
            ..r
        }),
    },
    Misreading {
        slug: "lut-colors-bgr",
        clause: "2.8.1/4",
        effect: "reads the colors of a PTM_LUT as B, G, R",
        mend: "the order is R, G, B",
        at: At::Planes(|ptm| {
            if ptm.header.format == Format::PtmLut {
                each(ptm, |texel| texel.swap(6, 8));
            }
        }),
    },
    stored_row(
        "lut-indices-top-down",
        "2.8.1/5",
        "takes the first row of indices for the top",
        |r| Reading {
            stored_row: |format, part, row, height| {
                if format.has_table() && part == 0 {
                    row
                } else {
                    height - 1 - row
                }
            },
            ..r
        },
    ),
    stored_row(
        "lut-colors-top-down",
        "2.8.1/5",
        "takes the first row of a PTM_LUT's colors for the top",
        |r| Reading {
            stored_row: |format, part, row, height| {
                if format.has_table() && part == 1 {
                    row
                } else {
                    height - 1 - row
                }
            },
            ..r
        },
    ),
    stored_row(
        "lut-rows-top-down",
        "2.8.1/5",
        "takes the first row of lookup table formats for the top",
        |r| Reading {
            stored_row: |format, _, row, height| {
                if format.has_table() {
                    row
                } else {
                    height - 1 - row
                }
            },
            ..r
        },
    ),
    stored_row(
        "c-lut-rows-top-down",
        "2.8.2/4",
        "takes the first row of a PTM_C_LUT for the top",
        |r| Reading {
            stored_row: |format, _, row, height| {
                if format == Format::PtmCLut {
                    row
                } else {
                    height - 1 - row
                }
            },
            ..r
        },
    ),
];

const fn index_width(
    slug: &'static str,
    clause: &'static str,
    effect: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    let mend = "one byte up to 256 entries, two above; the number of entries decides";
    Misreading {
        slug,
        clause,
        effect,
        mend,
        at: At::Reading(Decision::IndexWidth, change),
    }
}

const fn index(
    slug: &'static str,
    clause: &'static str,
    effect: &'static str,
    mend: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause,
        effect,
        mend,
        at: At::Reading(Decision::Index, change),
    }
}

const fn entry(
    slug: &'static str,
    clause: &'static str,
    effect: &'static str,
    mend: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause,
        effect,
        mend,
        at: At::Reading(Decision::Entry, change),
    }
}

fn format(file: &Anatomy) -> Option<Format> {
    file.texts(&["2.2/1"]).first()?.parse().ok()
}

/// The number of table entries, as far as the file says one.
fn entries(file: &Anatomy) -> Option<usize> {
    format(file).filter(|format| format.has_table())?;
    file.texts(&["2.5/2"])
        .iter()
        .find_map(|text| text.parse().ok())
        .filter(|&count: &usize| count > 0)
}

fn entry_size(file: &Anatomy) -> Option<usize> {
    format(file).map(|format| if format == Format::PtmCLut { 9 } else { 6 })
}

fn renamed(file: &Anatomy, name: &[u8]) -> Seen {
    let format = file.fields.iter().find(|field| field.clause == "2.2/1");
    let mut bytes = file.file.to_vec();
    if let Some(field) = format {
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
