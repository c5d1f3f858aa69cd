//! §2.9.8: the streams of planes, and which way their rows run

use super::compressed::reconstruct;
use super::{At, Decision, Misreading};
use crate::codec::{Class, Error};
use crate::decode::planes::{self, Coded};
use crate::ptm::{Format, Size};
use crate::reading::Reading;

type Samples = Result<Vec<u8>, Error>;

const STREAM: &str =
    "a plane is any stream of its standard with one component of 8 bits and the size of the map";

pub(super) const ALL: &[Misreading] = &[
    // Rows
    rows(
        "compressed-rows-top-down",
        "takes the first row of a compressed plane for the top",
        |r| Reading {
            stored_row: |format, _, row, height| {
                if format.is_compressed() {
                    row
                } else {
                    height - 1 - row
                }
            },
            ..r
        },
    ),
    rows(
        "jpeg-rows-top-down",
        "takes the first row of a JPEG plane for the top",
        |r| Reading {
            stored_row: |format, _, row, height| if jpeg(format) { row } else { height - 1 - row },
            ..r
        },
    ),
    rows(
        "jpeg-ls-rows-top-down",
        "takes the first row of a JPEG-LS plane for the top",
        |r| Reading {
            stored_row: |format, _, row, height| {
                if jpeg_ls(format) {
                    row
                } else {
                    height - 1 - row
                }
            },
            ..r
        },
    ),
    rows(
        "compressed-colors-top-down",
        "takes the first row of the color planes of LRGB for the top",
        |r| Reading {
            stored_row: |format, plane, row, height| {
                let colors = format.is_compressed() && format.channels() == 9 && plane > 5;
                if colors { row } else { height - 1 - row }
            },
            ..r
        },
    ),
    rows(
        "compressed-green-and-blue-top-down",
        "takes the first row of the green and blue planes of RGB for the top",
        |r| Reading {
            stored_row: |format, plane, row, height| {
                let others = format.is_compressed() && format.channels() == 18 && plane > 5;
                if others { row } else { height - 1 - row }
            },
            ..r
        },
    ),
    // Samples
    stream(
        "jpeg-rows-padded-to-4",
        "takes the rows of a JPEG plane to fill multiples of four bytes",
        "rows lie one behind another",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                sheared(
                    planes::stream(format, plane, bytes, size),
                    jpeg(format),
                    size,
                    4,
                )
            },
            ..r
        },
    ),
    stream(
        "jpeg-rows-padded-to-8",
        "takes the rows of a JPEG plane to fill whole blocks",
        "cut what blocks have beyond the width",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                sheared(
                    planes::stream(format, plane, bytes, size),
                    jpeg(format),
                    size,
                    8,
                )
            },
            ..r
        },
    ),
    stream(
        "compressed-columns-mirrored",
        "reads the rows of a plane from right to left",
        "the first sample of a row is the left one",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                let mut samples = planes::stream(format, plane, bytes, size)?;
                samples
                    .chunks_exact_mut(size.width as usize)
                    .for_each(<[u8]>::reverse);
                Ok(samples)
            },
            ..r
        },
    ),
    samples(
        "jpeg-studio-range",
        "stretches JPEG samples from 16…235 to 0…255",
        "samples are 0 to 255 as they are",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                each(
                    planes::stream(format, plane, bytes, size),
                    jpeg(format),
                    |value| ((i32::from(value) - 16) * 255 / 219).clamp(0, 255) as u8,
                )
            },
            ..r
        },
    ),
    samples(
        "jpeg-studio-range-made",
        "squeezes JPEG samples from 0…255 to 16…235",
        "samples are 0 to 255 as they are",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                each(
                    planes::stream(format, plane, bytes, size),
                    jpeg(format),
                    |value| (u16::from(value) * 219 / 255 + 16) as u8,
                )
            },
            ..r
        },
    ),
    samples(
        "jpeg-without-level-shift",
        "does not add 128 to JPEG samples",
        "the inverse transform gives −128 to 127",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                each(
                    planes::stream(format, plane, bytes, size),
                    jpeg(format),
                    |value| value.saturating_sub(128),
                )
            },
            ..r
        },
    ),
    samples(
        "jpeg-gamma",
        "takes grey JPEG samples for linear light",
        "samples are numbers, not colors",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                // A square root is near enough to what color management does, and the same everywhere.
                each(
                    planes::stream(format, plane, bytes, size),
                    jpeg(format),
                    |value| (u16::from(value) * 255).isqrt() as u8,
                )
            },
            ..r
        },
    ),
    samples(
        "jpeg-low-bit-lost",
        "keeps seven bits of JPEG samples",
        "samples have eight bits",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                each(
                    planes::stream(format, plane, bytes, size),
                    jpeg(format),
                    |value| value & 0xFE,
                )
            },
            ..r
        },
    ),
    // What streams may have
    stream(
        "restart-markers-refused",
        "refuses JPEG planes with restart intervals",
        STREAM,
        |r| Reading {
            stream: |format, plane, bytes, size| {
                refused_if(has(bytes, 0xDD), format, plane, bytes, size)
            },
            ..r
        },
    ),
    stream(
        "sof1-refused",
        "refuses JPEG planes of the extended sequential process",
        STREAM,
        |r| Reading {
            stream: |format, plane, bytes, size| {
                refused_if(has(bytes, 0xC1), format, plane, bytes, size)
            },
            ..r
        },
    ),
    stream(
        "tables-of-16-bits-refused",
        "refuses JPEG planes with quantisation tables of 16 bits",
        STREAM,
        |r| Reading {
            stream: |format, plane, bytes, size| {
                let wide = segments(bytes).any(|(code, segment)| {
                    code == 0xDB && segment.first().is_some_and(|&first| first >> 4 == 1)
                });
                refused_if(wide, format, plane, bytes, size)
            },
            ..r
        },
    ),
    stream(
        "tables-of-16-bits-cut",
        "uses the low bytes of quantisation tables of 16 bits",
        STREAM,
        |r| Reading {
            stream: |format, plane, bytes, size| {
                let cut = edited(bytes, |code, segment| {
                    if let (0xDB, Some((16..=31, table))) = (
                        code,
                        segment
                            .split_first_mut()
                            .map(|(&mut first, table)| (first, table)),
                    ) {
                        for entry in table.chunks_exact_mut(2) {
                            // A divisor of 0 is no divisor; such a reader finds at least 1.
                            entry[0] = 0;
                            entry[1] = entry[1].max(1);
                        }
                    }
                });
                planes::stream(format, plane, &cut, size)
            },
            ..r
        },
    ),
    stream(
        "quantisation-table-in-rows",
        "reads quantisation tables row by row",
        "they stand in zigzag order",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                let turned = edited(bytes, |code, segment| {
                    if let (0xDB, [0..=15, table @ ..]) = (code, segment)
                        && table.len() == 64
                    {
                        // Entry k of the file is taken for the frequency at place k, which stands at another place of the file.
                        let stored = table.to_vec();
                        table
                            .iter_mut()
                            .zip(zigzag())
                            .for_each(|(entry, place)| *entry = stored[place]);
                    }
                });
                planes::stream(format, plane, &turned, size)
            },
            ..r
        },
    ),
    stream(
        "optimised-tables-refused",
        "refuses JPEG planes whose Huffman tables are not those of the standard's annex",
        STREAM,
        |r| Reading {
            stream: |format, plane, bytes, size| {
                // The tables of Annex K have 12 and 162 codes.
                let codes = |segment: &[u8]| {
                    segment
                        .get(1..17)
                        .map_or(0, |counts| counts.iter().map(|&n| u32::from(n)).sum())
                };
                let own = segments(bytes).any(|(code, segment)| {
                    code == 0xC4 && ![12, 162, 174].contains(&codes(segment))
                });
                refused_if(own, format, plane, bytes, size)
            },
            ..r
        },
    ),
    stream(
        "sampling-factors-refused",
        "refuses JPEG planes whose sampling factors are not 1",
        STREAM,
        |r| Reading {
            stream: |format, plane, bytes, size| {
                let factors = segments(bytes).any(|(code, segment)| {
                    matches!(code, 0xC0 | 0xC1) && segment.get(7).is_some_and(|&f| f != 0x11)
                });
                refused_if(factors, format, plane, bytes, size)
            },
            ..r
        },
    ),
    stream(
        "jfif-required",
        "refuses JPEG planes without a JFIF segment",
        STREAM,
        |r| Reading {
            stream: |format, plane, bytes, size| {
                refused_if(
                    jpeg(format) && !has(bytes, 0xE0),
                    format,
                    plane,
                    bytes,
                    size,
                )
            },
            ..r
        },
    ),
    stream(
        "one-row-refused",
        "refuses planes that are smaller than a block",
        STREAM,
        |r| Reading {
            stream: |format, plane, bytes, size| {
                refused_if(
                    jpeg(format) && (size.width < 8 || size.height < 8),
                    format,
                    plane,
                    bytes,
                    size,
                )
            },
            ..r
        },
    ),
    // JPEG-LS parameters
    stream(
        "near-ignored",
        "reads lossy JPEG-LS as lossless",
        "the scan header says how large the loss is",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                let lossless = edited(bytes, |code, segment| {
                    if let (0xDA, [1, _, _, near, ..], true) = (code, segment, jpeg_ls(format)) {
                        *near = 0;
                    }
                });
                planes::stream(format, plane, &lossless, size)
            },
            ..r
        },
    ),
    stream(
        "presets-ignored",
        "ignores the parameters of an LSE segment",
        "an LSE segment changes the parameters of the scan",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                with_presets(format, plane, bytes, size, |segment| segment[1..11].fill(0))
            },
            ..r
        },
    ),
    stream(
        "thresholds-ignored",
        "ignores T1, T2 and T3 of an LSE segment",
        "an LSE segment changes the parameters of the scan",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                with_presets(format, plane, bytes, size, |segment| segment[3..9].fill(0))
            },
            ..r
        },
    ),
    stream(
        "reset-ignored",
        "ignores RESET of an LSE segment",
        "an LSE segment changes the parameters of the scan",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                with_presets(format, plane, bytes, size, |segment| segment[9..11].fill(0))
            },
            ..r
        },
    ),
    kept(
        "presets-kept",
        "keeps the parameters of an LSE segment for the planes behind it",
        |r| Reading {
            reconstruct: |coded, reading| keeping(coded, reading, 0xF8),
            ..r
        },
    ),
    kept(
        "restart-interval-kept",
        "keeps the restart interval of a plane for the planes behind it",
        |r| Reading {
            reconstruct: |coded, reading| keeping(coded, reading, 0xDD),
            ..r
        },
    ),
    stream(
        "presets-refused",
        "refuses JPEG-LS planes with an LSE segment",
        STREAM,
        |r| Reading {
            stream: |format, plane, bytes, size| {
                refused_if(has(bytes, 0xF8), format, plane, bytes, size)
            },
            ..r
        },
    ),
    // What streams must not be
    stream(
        "plane-size-unchecked",
        "lets a plane of another size stand at the corner of an empty one",
        "refuse it",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                let found = segments(bytes)
                    .find(|&(code, _)| matches!(code, 0xC0 | 0xC1 | 0xF7))
                    .map(|(_, segment)| segment);
                let Some([_, h1, h0, w1, w0, ..]) = found else {
                    return planes::stream(format, plane, bytes, size);
                };
                let own = Size {
                    width: u16::from_be_bytes([*w1, *w0]).into(),
                    height: u16::from_be_bytes([*h1, *h0]).into(),
                };
                if own.texels() > 1 << 24 {
                    return planes::stream(format, plane, bytes, size);
                }
                let samples = planes::stream(format, plane, bytes, own)?;
                let mut placed = vec![0; size.texels()];
                for (to, from) in placed
                    .chunks_exact_mut(size.width as usize)
                    .zip(samples.chunks_exact(own.width as usize))
                {
                    to.iter_mut().zip(from).for_each(|(to, &from)| *to = from);
                }
                Ok(placed)
            },
            ..r
        },
    ),
    stream(
        "empty-stream-is-a-blank-plane",
        "takes an empty stream for a plane of zeros",
        "refuse it: every plane is a stream",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                if bytes.is_empty() {
                    Ok(vec![0; size.texels()])
                } else {
                    planes::stream(format, plane, bytes, size)
                }
            },
            ..r
        },
    ),
    stream(
        "codec-from-the-stream",
        "reads JPEG-LS streams in JPEG files and the other way round",
        "the format names the codec",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                let found = if has(bytes, 0xF7) {
                    Format::JpeglsLrgb
                } else {
                    Format::JpegLrgb
                };
                planes::stream(
                    if bytes.is_empty() { format } else { found },
                    plane,
                    bytes,
                    size,
                )
            },
            ..r
        },
    ),
    stream(
        "broken-plane-is-blank",
        "takes a plane that it cannot decode for zeros",
        "refuse the file",
        |r| Reading {
            stream: |format, plane, bytes, size| {
                Ok(planes::stream(format, plane, bytes, size)
                    .unwrap_or_else(|_| vec![0; size.texels()]))
            },
            ..r
        },
    ),
];

const fn rows(
    slug: &'static str,
    effect: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause: "2.9.8/9",
        effect,
        mend: "the bottom row is stored first, in compressed planes too",
        at: At::Reading(Decision::StoredRow, change),
    }
}

const fn stream(
    slug: &'static str,
    effect: &'static str,
    mend: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause: "2.9.8/3",
        effect,
        mend,
        at: At::Reading(Decision::Stream, change),
    }
}

const fn samples(
    slug: &'static str,
    effect: &'static str,
    mend: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause: "2.9.8/11",
        effect,
        mend,
        at: At::Reading(Decision::Stream, change),
    }
}

const fn kept(
    slug: &'static str,
    effect: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    let mend = "every plane is a stream of its own; what one says holds for no other";
    reconstruct(slug, "2.9.8/3", effect, mend, change)
}

/// All planes, where those without a segment of this marker have that of the plane before.
fn keeping(coded: &Coded, reading: &Reading, marker: u8) -> crate::Result<Vec<Vec<u8>>> {
    let mut payload = Vec::new();
    let mut plan = coded.plan.clone();
    let mut known: Vec<u8> = Vec::new();
    for extent in &mut plan.extents {
        let mut stream = coded.payload[extent.stream.clone()].to_vec();
        // With its marker and length, four bytes.
        let own = places(&stream)
            .into_iter()
            .find(|&(code, _)| code == marker)
            .map(|(_, segment)| stream[segment.start - 4..segment.end].to_vec());
        match own {
            Some(own) => known = own,
            None if stream.len() > 2 => {
                stream.splice(2..2, known.iter().copied());
            }
            None => {}
        }
        let start = payload.len();
        payload.extend_from_slice(&stream);
        let middle = payload.len();
        payload.extend_from_slice(&coded.payload[extent.side.clone()]);
        extent.stream = start..middle;
        extent.side = middle..payload.len();
    }
    let kept = Coded {
        plan: &plan,
        payload: &payload,
        ..*coded
    };
    planes::reconstruct(&kept, reading)
}

fn jpeg(format: Format) -> bool {
    matches!(format, Format::JpegRgb | Format::JpegLrgb)
}

fn jpeg_ls(format: Format) -> bool {
    matches!(format, Format::JpeglsRgb | Format::JpeglsLrgb)
}

/// Other samples, where they are `concerned`.
fn each(samples: Samples, concerned: bool, change: fn(u8) -> u8) -> Samples {
    let mut samples = samples?;
    if concerned {
        for value in &mut samples {
            *value = change(*value);
        }
    }
    Ok(samples)
}

/// The first samples of a buffer in which rows are filled up to a multiple of `unit`, taken for the plane.
fn sheared(samples: Samples, concerned: bool, size: Size, unit: usize) -> Samples {
    let samples = samples?;
    if !concerned {
        return Ok(samples);
    }
    let width = size.width as usize;
    let padded = width.next_multiple_of(unit);
    let at = |i: usize| samples[i / padded * width + (i % padded).min(width - 1)];
    Ok((0..samples.len()).map(at).collect())
}

fn refused_if(refused: bool, format: Format, plane: usize, bytes: &[u8], size: Size) -> Samples {
    if refused {
        return Err(Error {
            class: Class::Malformed,
            offset: 0,
            what: "such streams are not read".to_owned(),
        });
    }
    planes::stream(format, plane, bytes, size)
}

/// The markers of a stream up to its scan and what their segments hold behind the length.
fn segments(bytes: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    places(bytes)
        .into_iter()
        .map(|(code, range)| (code, &bytes[range]))
}

fn has(bytes: &[u8], marker: u8) -> bool {
    segments(bytes).any(|(code, _)| code == marker)
}

fn places(bytes: &[u8]) -> Vec<(u8, std::ops::Range<usize>)> {
    let mut found = Vec::new();
    let mut at = 2;
    while let Some(&[0xFF, code, high, low]) = bytes.get(at..at + 4) {
        let end = at + 2 + usize::from(u16::from_be_bytes([high, low]));
        if end < at + 4 || end > bytes.len() {
            break;
        }
        found.push((code, at + 4..end));
        at = end;
        if code == 0xDA {
            break;
        }
    }
    found
}

/// The stream with other segments.
fn edited(bytes: &[u8], edit: impl Fn(u8, &mut [u8])) -> Vec<u8> {
    let mut stream = bytes.to_vec();
    for (code, range) in places(bytes) {
        edit(code, &mut stream[range]);
    }
    stream
}

/// The stream with other preset parameters; 0 is the default of each.
fn with_presets(
    format: Format,
    plane: usize,
    bytes: &[u8],
    size: Size,
    edit: fn(&mut [u8]),
) -> Samples {
    let changed = edited(bytes, |code, segment| {
        if code == 0xF8 && segment.len() == 11 && segment[0] == 1 {
            edit(segment);
        }
    });
    planes::stream(format, plane, &changed, size)
}

/// For each place in rows, which entry in zigzag order it has; and, entry by entry, where the other way round.
fn zigzag() -> [usize; 64] {
    let mut order: Vec<usize> = (0..64).collect();
    // Diagonal after diagonal; up the even ones, down the odd ones.
    order.sort_by_key(|&place| {
        let (row, column) = (place / 8, place % 8);
        let diagonal = row + column;
        (diagonal, if diagonal % 2 == 0 { column } else { row })
    });
    let mut places = [0; 64];
    places.copy_from_slice(&order);
    places
}
