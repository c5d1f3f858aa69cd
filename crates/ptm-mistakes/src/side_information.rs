//! §2.9.8: mistakes in handling side information

use super::change::{Change, Changes};
use ptm::Coding;
use ptm::decode::planes as rule;
use ptm::error::Result;
use ptm::parts::{Coded, Record};
use ptm::reading::Reading;

pub const CHANGES: Changes = |slug| {
    let change: fn(&mut Reading) = match slug {
        // Time of the correction
        "side-information-too-late" => |r| {
            r.reconstruct = |coded, residuals, reading| {
                let mut done = reconstruct_uncorrected(coded, residuals, reading)?;
                for (i, plane) in done.iter_mut().enumerate() {
                    coded.correct(i, plane, reading)?;
                }
                Ok(done)
            };
        },
        "side-information-before-prediction" => |r| {
            r.reconstruct = |coded, residuals, reading| {
                let mut done = coded.blank_planes();
                for (&i, mut plane) in coded.plan.sequence.iter().zip(residuals) {
                    coded.correct(i, &mut plane, reading)?;
                    coded.predict(i, &mut plane, &done, reading);
                    done[i] = plane;
                }
                Ok(done)
            };
        },
        "side-information-only-for-references" => |r| {
            r.reconstruct = |coded, residuals, reading| {
                let mut corrected = coded.blank_planes();
                let mut done = coded.blank_planes();
                for (&i, mut plane) in coded.plan.sequence.iter().zip(residuals) {
                    coded.predict(i, &mut plane, &corrected, reading);
                    done[i].clone_from(&plane);
                    coded.correct(i, &mut plane, reading)?;
                    corrected[i] = plane;
                }
                Ok(done)
            };
        },
        "side-information-ignored" => |r| r.reconstruct = reconstruct_uncorrected,
        "side-information-of-inverted-planes-ignored" => |r| {
            r.reconstruct = |coded, residuals, reading| {
                reconstruct_partly_corrected(coded, residuals, reading, |coded, i| {
                    let step = &coded.plan.steps[i];
                    step.reference.is_none() || !(step.inverted || step.displaced)
                })
            };
        },
        "side-information-of-colors-ignored" => |r| {
            r.reconstruct = |coded, residuals, reading| {
                reconstruct_partly_corrected(coded, residuals, reading, |coded, i| {
                    coded.plan.steps.len() == 18 || i < 6
                })
            };
        },
        "side-information-of-jpeg-ls-ignored" => |r| {
            r.side_information = |coded, plane| {
                side_information_unless(coded.coding == Coding::JpegLs, coded, plane)
            };
        },
        "quality-100-is-lossless" => |r| {
            r.side_information = |coded, plane| {
                let lossless = coded.plan.parameter == 100 && coded.coding == Coding::Jpeg;
                side_information_unless(lossless, coded, plane)
            };
        },
        // Position
        "side-last-texel-skipped" => |r| {
            r.records = |block, at, texels| {
                let records = rule::parse_records(block, at, texels)?;
                Ok(records_inside(records.into_iter(), texels - 1))
            };
        },
        "side-last-texel-refused" => {
            |r| r.records = |block, at, texels| rule::parse_records(block, at, texels - 1)
        }
        "side-position-past-the-end-ignored" => |r| {
            r.records = |block, _, texels| {
                let (records, rest) = block.as_chunks::<5>();
                // A partial record is still refused.
                rule::parse_records(rest, 0, texels)?;
                Ok(records_inside(
                    records.iter().map(|&record| big_endian(record)),
                    texels,
                ))
            };
        },
        // Value
        "side-little-endian" => |r| {
            r.records = |block, at, texels| {
                read_records_with(block, at, texels, |&[p0, p1, p2, p3, value]| {
                    (u32::from_le_bytes([p0, p1, p2, p3]), value)
                })
            };
        },
        "side-words-swapped" => |r| {
            r.records = |block, at, texels| {
                read_records_with(block, at, texels, |&[p1, p0, p3, p2, value]| {
                    (u32::from_be_bytes([p3, p2, p1, p0]), value)
                })
            };
        },
        "side-value-first" => |r| {
            r.records = |block, at, texels| {
                read_records_with(block, at, texels, |&[value, p3, p2, p1, p0]| {
                    (u32::from_be_bytes([p3, p2, p1, p0]), value)
                })
            };
        },
        "side-bytes-signed" => |r| {
            r.records = |block, at, texels| {
                read_records_with(block, at, texels, |&[p3, p2, p1, p0, value]| {
                    let bytes = [p3, p2, p1, p0].map(|byte| i32::from(byte.cast_signed()));
                    let sum = bytes
                        .into_iter()
                        .fold(0, |sum: i32, byte| (sum << 8).wrapping_add(byte));
                    (sum.cast_unsigned(), value)
                })
            };
        },
        "side-cursor-by-one" => |r| {
            r.records = |block, at, texels| {
                rule::parse_records(block, at, texels)?;
                let records = block
                    .windows(5)
                    .map(|bytes| bytes.try_into().expect("five bytes"));
                Ok(records_inside(records.map(big_endian), texels))
            };
        },
        "side-records-of-four-bytes" => |r| {
            r.records = |block, _, texels| {
                let (records, _) = block.as_chunks::<4>();
                let records = records
                    .iter()
                    .map(|&[p2, p1, p0, value]| big_endian([0, p2, p1, p0, value]));
                Ok(records_inside(records, texels))
            };
        },
        "side-partial-record-ignored" => |r| {
            r.records =
                |block, at, texels| rule::parse_records(&block[..block.len() / 5 * 5], at, texels);
        },
        // Records
        "side-values-exclusive-or" => |r| {
            r.correct = |plane, records| {
                for &(position, value) in records {
                    if let Some(texel) = plane.get_mut(position as usize) {
                        *texel ^= value;
                    }
                }
            };
        },
        "side-first-of-two-wins" => |r| {
            r.correct = |plane, records| {
                let reversed: Vec<_> = records.iter().rev().copied().collect();
                rule::overwrite_samples(plane, &reversed);
            };
        },
        _ => return None,
    };
    Some(Change::Reading(change))
};

fn big_endian([p3, p2, p1, p0, value]: [u8; 5]) -> Record {
    (u32::from_be_bytes([p3, p2, p1, p0]), value)
}

fn side_information_unless<'a>(skipped: bool, coded: &Coded<'a>, plane: usize) -> &'a [u8] {
    if skipped {
        &[]
    } else {
        rule::side_information(coded, plane)
    }
}

/// Reconstructs all planes without corrections.
fn reconstruct_uncorrected(
    coded: &Coded,
    residuals: Vec<Vec<u8>>,
    reading: &Reading,
) -> Result<Vec<Vec<u8>>> {
    reconstruct_partly_corrected(coded, residuals, reading, |_, _| false)
}

fn reconstruct_partly_corrected(
    coded: &Coded,
    residuals: Vec<Vec<u8>>,
    reading: &Reading,
    is_corrected: fn(&Coded, usize) -> bool,
) -> Result<Vec<Vec<u8>>> {
    let mut done = coded.blank_planes();
    for (&i, mut plane) in coded.plan.sequence.iter().zip(residuals) {
        coded.predict(i, &mut plane, &done, reading);
        if is_corrected(coded, i) {
            coded.correct(i, &mut plane, reading)?;
        }
        done[i] = plane;
    }
    Ok(done)
}

/// Parses each record of a legal block with `read`. Ignores records with positions past the end of the plane.
fn read_records_with(
    block: &[u8],
    at: usize,
    texels: usize,
    read: fn(&[u8; 5]) -> Record,
) -> Result<Vec<Record>> {
    rule::parse_records(block, at, texels)?;
    let records = block.as_chunks::<5>().0.iter().map(read);
    Ok(records_inside(records, texels))
}

fn records_inside(records: impl Iterator<Item = Record>, texels: usize) -> Vec<Record> {
    let is_inside = |&(position, _): &Record| (position as usize) < texels;
    records.filter(is_inside).collect()
}
