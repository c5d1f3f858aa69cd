//! §2.9.8: side information

use super::{At, Decision, Misreading};
use crate::decode::planes as rule;
use crate::decode::planes::Coded;
use crate::error::Result;
use crate::ptm::{Format, Size};
use crate::reading::Reading;

const MEND: &str = "mend a plane right after it is predicted, and before it is a reference";
const RECORD: &str = "a record is four bytes of position, the high byte first, and a value";
const POSITION: &str = "positions count texels from 0, row after row as the rows are stored";

pub(super) const ALL: &[Misreading] = &[
    // When
    reconstruct(
        "side-information-too-late",
        "2.9.8/7",
        "corrects all planes when all are decoded, and predicts from uncorrected ones",
        MEND,
        |r| Reading {
            reconstruct: |coded, reading| {
                let mut done = uncorrected(coded, reading)?;
                for (i, plane) in done.iter_mut().enumerate() {
                    coded.mend(i, plane, reading)?;
                }
                Ok(done)
            },
            ..r
        },
    ),
    reconstruct(
        "side-information-before-prediction",
        "2.9.8/8",
        "corrects the residuals",
        MEND,
        |r| Reading {
            reconstruct: |coded, reading| {
                let mut done = coded.blank_planes();
                for &i in &coded.plan.sequence {
                    let mut plane = coded.residuals(i, reading)?;
                    coded.mend(i, &mut plane, reading)?;
                    coded.predict(i, &mut plane, &done, reading);
                    done[i] = plane;
                }
                Ok(done)
            },
            ..r
        },
    ),
    reconstruct(
        "side-information-only-for-references",
        "2.9.8/7",
        "corrects a plane for those predicted from it, but not itself",
        MEND,
        |r| Reading {
            reconstruct: |coded, reading| {
                let mut corrected = coded.blank_planes();
                let mut done = coded.blank_planes();
                for &i in &coded.plan.sequence {
                    let mut plane = coded.residuals(i, reading)?;
                    coded.predict(i, &mut plane, &corrected, reading);
                    done[i].clone_from(&plane);
                    coded.mend(i, &mut plane, reading)?;
                    corrected[i] = plane;
                }
                Ok(done)
            },
            ..r
        },
    ),
    reconstruct(
        "side-information-ignored",
        "2.9.8/8",
        "steps over side information",
        MEND,
        |r| Reading {
            reconstruct: uncorrected,
            ..r
        },
    ),
    reconstruct(
        "side-information-of-intra-planes-ignored",
        "2.9.8/8",
        "does not correct intra coded planes",
        MEND,
        |r| Reading {
            reconstruct: |coded, reading| {
                only(coded, reading, |coded, i| {
                    coded.plan.steps[i].reference.is_some()
                })
            },
            ..r
        },
    ),
    reconstruct(
        "side-information-of-intra-planes-only",
        "2.9.8/8",
        "corrects intra coded planes only",
        MEND,
        |r| Reading {
            reconstruct: |coded, reading| {
                only(coded, reading, |coded, i| {
                    coded.plan.steps[i].reference.is_none()
                })
            },
            ..r
        },
    ),
    reconstruct(
        "side-information-of-inverted-planes-ignored",
        "2.9.8/8",
        "does not correct planes predicted with a transform",
        MEND,
        |r| Reading {
            reconstruct: |coded, reading| {
                only(coded, reading, |coded, i| {
                    let step = &coded.plan.steps[i];
                    step.reference.is_none() || !(step.inverted || step.moved)
                })
            },
            ..r
        },
    ),
    reconstruct(
        "side-information-of-colors-ignored",
        "2.9.8/8",
        "corrects coefficients only",
        MEND,
        |r| Reading {
            reconstruct: |coded, reading| {
                only(coded, reading, |coded, i| {
                    coded.plan.steps.len() == 18 || i < 6
                })
            },
            ..r
        },
    ),
    counts(
        "side-information-of-jpeg-ls-ignored",
        "takes JPEG-LS for lossless and steps over its side information",
        |r| Reading {
            side_counts: |format, _| matches!(format, Format::JpegRgb | Format::JpegLrgb),
            ..r
        },
    ),
    counts(
        "quality-100-is-lossless",
        "takes JPEG of quality 100 for lossless and steps over its side information",
        |r| Reading {
            side_counts: |format, parameter| {
                parameter != 100 || !matches!(format, Format::JpegRgb | Format::JpegLrgb)
            },
            ..r
        },
    ),
    // Where
    reconstruct(
        "side-rows-turned",
        "2.9.8/6",
        "counts positions from the top row of the picture",
        POSITION,
        |r| Reading {
            reconstruct: |coded, reading| {
                replaced(coded, reading, |position, size| {
                    let (x, y) = (position % size.width, position / size.width);
                    (size.height - 1 - y) * size.width + x
                })
            },
            ..r
        },
    ),
    reconstruct(
        "side-columns-first",
        "2.9.8/6",
        "counts positions column after column",
        POSITION,
        |r| Reading {
            reconstruct: |coded, reading| {
                replaced(coded, reading, |position, size| {
                    position % size.height * size.width + position / size.height
                })
            },
            ..r
        },
    ),
    reconstruct(
        "side-columns-mirrored",
        "2.9.8/6",
        "counts positions from the right of each row",
        POSITION,
        |r| Reading {
            reconstruct: |coded, reading| {
                replaced(coded, reading, |position, size| {
                    position / size.width * size.width + size.width - 1 - position % size.width
                })
            },
            ..r
        },
    ),
    reconstruct(
        "side-from-the-end",
        "2.9.8/6",
        "counts positions from the last texel",
        POSITION,
        |r| Reading {
            reconstruct: |coded, reading| {
                replaced(coded, reading, |position, size| {
                    size.width * size.height - 1 - position
                })
            },
            ..r
        },
    ),
    records(
        "side-positions-from-one",
        "2.9.8/6",
        "takes position 1 for the first texel",
        POSITION,
        |r| Reading {
            records: |block, at, texels| {
                edited(block, at, texels, |(position, value)| {
                    (position.saturating_sub(1), value)
                })
            },
            ..r
        },
    ),
    records(
        "side-one-texel-late",
        "2.9.8/6",
        "corrects the texel behind the right one",
        POSITION,
        |r| Reading {
            records: |block, at, texels| {
                let last = texels as u32 - 1;
                Ok(rule::records(block, at, texels)?
                    .into_iter()
                    .map(|(position, value)| ((position + 1).min(last), value))
                    .collect())
            },
            ..r
        },
    ),
    records(
        "side-position-zero-skipped",
        "2.9.8/6",
        "takes a record for texel 0 for none",
        POSITION,
        |r| Reading {
            records: |block, at, texels| kept(block, at, texels, |(position, _), _| position > 0),
            ..r
        },
    ),
    records(
        "side-last-texel-skipped",
        "2.9.8/6",
        "takes a record for the last texel to be out of range and ignores it",
        POSITION,
        |r| Reading {
            records: |block, at, texels| {
                kept(block, at, texels, |(position, _), texels| {
                    (position as usize) < texels - 1
                })
            },
            ..r
        },
    ),
    records(
        "side-last-texel-refused",
        "2.9.8/6",
        "refuses a record for the last texel",
        POSITION,
        |r| Reading {
            records: |block, at, texels| rule::records(block, at, texels - 1),
            ..r
        },
    ),
    records(
        "side-position-in-16-bits",
        "2.9.8/5",
        "uses the two low bytes of a position",
        RECORD,
        |r| Reading {
            records: |block, at, texels| {
                edited(block, at, texels, |(position, value)| {
                    (position & 0xFFFF, value)
                })
            },
            ..r
        },
    ),
    records(
        "side-position-in-8-bits",
        "2.9.8/5",
        "uses the lowest byte of a position",
        RECORD,
        |r| Reading {
            records: |block, at, texels| {
                edited(block, at, texels, |(position, value)| {
                    (position & 0xFF, value)
                })
            },
            ..r
        },
    ),
    records(
        "side-position-past-the-end-ignored",
        "2.9.8/6",
        "ignores records for texels that do not exist",
        "refuse them",
        |r| Reading {
            records: |block, _, texels| {
                let (whole, rest) = block.as_chunks::<5>();
                // A partial record is refused as ever.
                rule::records(rest, 0, texels)?;
                Ok(inside(
                    whole.iter().map(|&[p3, p2, p1, p0, value]| {
                        (u32::from_be_bytes([p3, p2, p1, p0]), value)
                    }),
                    texels,
                ))
            },
            ..r
        },
    ),
    // What
    records(
        "side-little-endian",
        "2.9.8/5",
        "reads positions with the low byte first",
        RECORD,
        |r| Reading {
            records: |block, at, texels| {
                reread(block, at, texels, |&[p0, p1, p2, p3, value]| {
                    (u32::from_le_bytes([p0, p1, p2, p3]), value)
                })
            },
            ..r
        },
    ),
    records(
        "side-words-swapped",
        "2.9.8/5",
        "reads positions as two words with the low word first",
        RECORD,
        |r| Reading {
            records: |block, at, texels| {
                reread(block, at, texels, |&[p1, p0, p3, p2, value]| {
                    (u32::from_be_bytes([p3, p2, p1, p0]), value)
                })
            },
            ..r
        },
    ),
    records(
        "side-value-first",
        "2.9.8/5",
        "takes the first byte of a record for the value",
        RECORD,
        |r| Reading {
            records: |block, at, texels| {
                reread(block, at, texels, |&[value, p3, p2, p1, p0]| {
                    (u32::from_be_bytes([p3, p2, p1, p0]), value)
                })
            },
            ..r
        },
    ),
    records(
        "side-bytes-signed",
        "2.9.8/5",
        "adds up positions from signed bytes",
        RECORD,
        |r| Reading {
            records: |block, at, texels| {
                reread(block, at, texels, |&[p3, p2, p1, p0, value]| {
                    let signed =
                        |byte: u8, shift: u32| (i64::from(byte.cast_signed()) << shift) as u32;
                    (
                        signed(p3, 24)
                            .wrapping_add(signed(p2, 16))
                            .wrapping_add(signed(p1, 8))
                            .wrapping_add(signed(p0, 0)),
                        value,
                    )
                })
            },
            ..r
        },
    ),
    records(
        "side-value-signed",
        "2.9.8/5",
        "reads values as signed bytes and sets negative ones to 0",
        RECORD,
        |r| Reading {
            records: |block, at, texels| {
                edited(block, at, texels, |(position, value)| {
                    (position, if value > 127 { 0 } else { value })
                })
            },
            ..r
        },
    ),
    records(
        "side-cursor-by-one",
        "2.9.8/5",
        "goes on by one byte after a record of five",
        RECORD,
        |r| Reading {
            records: |block, at, texels| {
                rule::records(block, at, texels)?;
                let seen = block.windows(5).map(|record| {
                    (
                        u32::from_be_bytes([record[0], record[1], record[2], record[3]]),
                        record[4],
                    )
                });
                Ok(inside(seen, texels))
            },
            ..r
        },
    ),
    records(
        "side-records-of-four-bytes",
        "2.9.8/5",
        "reads records of three bytes of position and a value",
        RECORD,
        |r| Reading {
            records: |block, _, texels| {
                let (whole, _) = block.as_chunks::<4>();
                Ok(inside(
                    whole
                        .iter()
                        .map(|&[p2, p1, p0, value]| (u32::from_be_bytes([0, p2, p1, p0]), value)),
                    texels,
                ))
            },
            ..r
        },
    ),
    records(
        "side-first-record-only",
        "2.9.8/4",
        "reads one record of each plane",
        "read as many bytes as the side information size says",
        |r| Reading {
            records: |block, at, texels| {
                Ok(rule::records(block, at, texels)?
                    .into_iter()
                    .take(1)
                    .collect())
            },
            ..r
        },
    ),
    records(
        "side-first-record-lost",
        "2.9.8/4",
        "steps over the first record of each plane",
        "read as many bytes as the side information size says",
        |r| Reading {
            records: |block, at, texels| {
                Ok(rule::records(block, at, texels)?
                    .into_iter()
                    .skip(1)
                    .collect())
            },
            ..r
        },
    ),
    records(
        "side-last-record-lost",
        "2.9.8/4",
        "stops before the last record of each plane",
        "read as many bytes as the side information size says",
        |r| Reading {
            records: |block, at, texels| {
                let mut records = rule::records(block, at, texels)?;
                records.pop();
                Ok(records)
            },
            ..r
        },
    ),
    records(
        "side-partial-record-ignored",
        "2.9.8/5",
        "ignores a record that is not whole",
        "refuse side information that is no multiple of five bytes",
        |r| Reading {
            records: |block, at, texels| rule::records(&block[..block.len() / 5 * 5], at, texels),
            ..r
        },
    ),
    // How
    mend(
        "side-values-added",
        "adds a record's value to the texel",
        |r| Reading {
            mend: |plane, records| each(plane, records, u8::wrapping_add),
            ..r
        },
    ),
    mend(
        "side-values-are-residuals",
        "adds a record's value, less 128, to the texel",
        |r| Reading {
            mend: |plane, records| {
                each(plane, records, |old, value| {
                    old.wrapping_add(value).wrapping_sub(128)
                });
            },
            ..r
        },
    ),
    mend(
        "side-values-exclusive-or",
        "takes a record's value for the bits that are wrong",
        |r| Reading {
            mend: |plane, records| each(plane, records, |old, value| old ^ value),
            ..r
        },
    ),
    mend(
        "side-values-wrap-only",
        "uses a record only to decide between 0 and 255",
        |r| Reading {
            mend: |plane, records| {
                each(plane, records, |_, value| if value > 127 { 255 } else { 0 });
            },
            ..r
        },
    ),
    mend(
        "side-values-only-where-overflown",
        "corrects a texel only if it is off by more than 127",
        |r| Reading {
            mend: |plane, records| {
                each(plane, records, |old, value| {
                    if old.abs_diff(value) > 127 {
                        value
                    } else {
                        old
                    }
                });
            },
            ..r
        },
    ),
    mend(
        "side-first-of-two-wins",
        "keeps the first of two records for a texel",
        |r| Reading {
            mend: |plane, records| {
                let turned: Vec<_> = records.iter().rev().copied().collect();
                rule::overwrite(plane, &turned);
            },
            ..r
        },
    ),
];

const fn reconstruct(
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
        at: At::Reading(Decision::Reconstruct, change),
    }
}

const fn records(
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
        at: At::Reading(Decision::Records, change),
    }
}

const fn counts(
    slug: &'static str,
    effect: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause: "2.9.8/4",
        effect,
        mend: "apply side information wherever its size is not 0",
        at: At::Reading(Decision::SideCounts, change),
    }
}

const fn mend(
    slug: &'static str,
    effect: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause: "2.9.8/8",
        effect,
        mend: "a record's value takes the place of the texel's",
        at: At::Reading(Decision::Mend, change),
    }
}

/// All planes without any correction.
fn uncorrected(coded: &Coded, reading: &Reading) -> Result<Vec<Vec<u8>>> {
    only(coded, reading, |_, _| false)
}

/// All planes, of which only some are corrected.
fn only(
    coded: &Coded,
    reading: &Reading,
    corrected: fn(&Coded, usize) -> bool,
) -> Result<Vec<Vec<u8>>> {
    let mut done = coded.blank_planes();
    for &i in &coded.plan.sequence {
        let mut plane = coded.residuals(i, reading)?;
        coded.predict(i, &mut plane, &done, reading);
        if corrected(coded, i) {
            coded.mend(i, &mut plane, reading)?;
        }
        done[i] = plane;
    }
    Ok(done)
}

/// All planes, corrected at other positions.
fn replaced(coded: &Coded, reading: &Reading, moved: fn(u32, Size) -> u32) -> Result<Vec<Vec<u8>>> {
    let mut done = coded.blank_planes();
    for &i in &coded.plan.sequence {
        let mut plane = coded.residuals(i, reading)?;
        coded.predict(i, &mut plane, &done, reading);
        if (reading.side_counts)(coded.format, coded.plan.parameter) {
            let block = &coded.payload[coded.plan.extents[i].side.clone()];
            let records = (reading.records)(block, 0, plane.len())?;
            let records: Vec<_> = records
                .into_iter()
                .map(|(position, value)| (moved(position, coded.size), value))
                .collect();
            (reading.mend)(&mut plane, &records);
        }
        done[i] = plane;
    }
    Ok(done)
}

/// The records of a legal block, some of them changed.
fn edited(
    block: &[u8],
    at: usize,
    texels: usize,
    change: fn((u32, u8)) -> (u32, u8),
) -> Result<Vec<(u32, u8)>> {
    Ok(rule::records(block, at, texels)?
        .into_iter()
        .map(change)
        .collect())
}

/// Some of the records of a legal block.
fn kept(
    block: &[u8],
    at: usize,
    texels: usize,
    keep: fn((u32, u8), usize) -> bool,
) -> Result<Vec<(u32, u8)>> {
    Ok(rule::records(block, at, texels)?
        .into_iter()
        .filter(|&record| keep(record, texels))
        .collect())
}

/// The records of a legal block, read otherwise; those past the end are ignored.
fn reread(
    block: &[u8],
    at: usize,
    texels: usize,
    read: fn(&[u8; 5]) -> (u32, u8),
) -> Result<Vec<(u32, u8)>> {
    rule::records(block, at, texels)?;
    Ok(inside(block.as_chunks::<5>().0.iter().map(read), texels))
}

fn inside(records: impl Iterator<Item = (u32, u8)>, texels: usize) -> Vec<(u32, u8)> {
    records
        .filter(|&(position, _)| (position as usize) < texels)
        .collect()
}

fn each(plane: &mut [u8], records: &[(u32, u8)], change: fn(old: u8, value: u8) -> u8) {
    for &(position, value) in records {
        let texel = &mut plane[position as usize];
        *texel = change(*texel, value);
    }
}
