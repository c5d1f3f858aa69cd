//! §2.7 Uncompressed Per Texel Data: how texels lie in the file

use super::{At, Decision, Misreading, Seen};
use crate::decode::Ptm;
use crate::decode::texels::{self, Block};
use crate::ptm::Format;
use crate::reading::Reading;

pub(super) const ALL: &[Misreading] = &[
    stored_row(
        "rows-top-down",
        "2.7.1/3",
        "takes the first stored row for the top",
        |r| Reading {
            stored_row: |_, _, row, _| row,
            ..r
        },
    ),
    stored_row(
        "rgb-rows-top-down",
        "2.7.1/3",
        "takes the first stored row of an RGB file for the top",
        |r| Reading {
            stored_row: |format, _, row, height| {
                if format == Format::Rgb {
                    row
                } else {
                    height - 1 - row
                }
            },
            ..r
        },
    ),
    stored_row(
        "lrgb-rows-top-down",
        "2.7.3/3",
        "takes the first stored row of an LRGB file for the top",
        |r| Reading {
            stored_row: |format, _, row, height| {
                if format == Format::Lrgb {
                    row
                } else {
                    height - 1 - row
                }
            },
            ..r
        },
    ),
    stored_row(
        "lrgb-colors-top-down",
        "2.7.3/3",
        "takes the first row of an LRGB file's colors for the top",
        |r| Reading {
            stored_row: |format, part, row, height| {
                if (format, part) == (Format::Lrgb, 1) {
                    row
                } else {
                    height - 1 - row
                }
            },
            ..r
        },
    ),
    stored_row(
        "lrgb-coefficients-top-down",
        "2.7.3/3",
        "takes the first row of an LRGB file's coefficients for the top",
        |r| Reading {
            stored_row: |format, part, row, height| {
                if (format, part) == (Format::Lrgb, 0) {
                    row
                } else {
                    height - 1 - row
                }
            },
            ..r
        },
    ),
    stored_row(
        "rgb-only-red-turned",
        "2.7.1/3",
        "turns the rows of the red block only",
        |r| Reading {
            stored_row: |format, part, row, height| {
                if format == Format::Rgb && part > 0 {
                    row
                } else {
                    height - 1 - row
                }
            },
            ..r
        },
    ),
    Misreading {
        slug: "payload-reversed",
        clause: "2.7.1/3",
        effect: "reverses all bytes of the payload to turn the picture",
        mend: "turn the order of the rows, not the bytes within them",
        at: At::Bytes(|file| {
            let turned = file.file[file.payload()..].iter().rev();
            Seen::File(file.header().iter().chain(turned).copied().collect())
        }),
    },
    blocks(
        "lrgb-nine-interleaved",
        "2.7.3/2",
        "reads nine interleaved bytes for each LRGB texel, as in version 1.1",
        |r| Reading {
            blocks: |format| match format {
                Format::Lrgb => const { &[run(0, 9)] },
                _ => texels::blocks(format),
            },
            ..r
        },
    ),
    blocks(
        "lrgb-nine-planes",
        "2.7.3/1",
        "reads LRGB as nine planes",
        |r| Reading {
            blocks: |format| match format {
                Format::Lrgb => {
                    const {
                        &[
                            run(0, 1),
                            run(1, 1),
                            run(2, 1),
                            run(3, 1),
                            run(4, 1),
                            run(5, 1),
                            run(6, 1),
                            run(7, 1),
                            run(8, 1),
                        ]
                    }
                }
                _ => texels::blocks(format),
            },
            ..r
        },
    ),
    blocks(
        "lrgb-coefficients-in-planes",
        "2.7.3/1",
        "reads LRGB coefficients as six planes",
        |r| Reading {
            blocks: |format| match format {
                Format::Lrgb => {
                    const {
                        &[
                            run(0, 1),
                            run(1, 1),
                            run(2, 1),
                            run(3, 1),
                            run(4, 1),
                            run(5, 1),
                            run(6, 3),
                        ]
                    }
                }
                _ => texels::blocks(format),
            },
            ..r
        },
    ),
    blocks(
        "lrgb-colors-in-planes",
        "2.7.3/2",
        "reads LRGB colors as three planes",
        |r| Reading {
            blocks: |format| match format {
                Format::Lrgb => const { &[run(0, 6), run(6, 1), run(7, 1), run(8, 1)] },
                _ => texels::blocks(format),
            },
            ..r
        },
    ),
    blocks(
        "color-block-first",
        "2.7.3/2",
        "reads the color block of an LRGB file before its coefficients",
        |r| Reading {
            blocks: |format| match format {
                Format::Lrgb => const { &[run(6, 3), run(0, 6)] },
                _ => texels::blocks(format),
            },
            ..r
        },
    ),
    blocks(
        "rgb-eighteen-interleaved",
        "2.7.1/2",
        "reads eighteen interleaved bytes for each RGB texel",
        |r| Reading {
            blocks: |format| match format {
                Format::Rgb => const { &[run(0, 18)] },
                _ => texels::blocks(format),
            },
            ..r
        },
    ),
    blocks(
        "rgb-eighteen-planes",
        "2.7.1/1",
        "reads RGB as eighteen planes",
        |r| Reading {
            blocks: |format| match format {
                Format::Rgb => {
                    const {
                        &[
                            run(0, 1),
                            run(1, 1),
                            run(2, 1),
                            run(3, 1),
                            run(4, 1),
                            run(5, 1),
                            run(6, 1),
                            run(7, 1),
                            run(8, 1),
                            run(9, 1),
                            run(10, 1),
                            run(11, 1),
                            run(12, 1),
                            run(13, 1),
                            run(14, 1),
                            run(15, 1),
                            run(16, 1),
                            run(17, 1),
                        ]
                    }
                }
                _ => texels::blocks(format),
            },
            ..r
        },
    ),
    blocks(
        "rgb-blocks-bgr",
        "2.7.1/2",
        "takes the first block of an RGB file for blue",
        |r| Reading {
            blocks: |format| match format {
                Format::Rgb => const { &[run(12, 6), run(6, 6), run(0, 6)] },
                _ => texels::blocks(format),
            },
            ..r
        },
    ),
    blocks(
        "rgb-green-and-blue-exchanged",
        "2.7.1/2",
        "takes the second block of an RGB file for blue",
        |r| Reading {
            blocks: |format| match format {
                Format::Rgb => const { &[run(0, 6), run(12, 6), run(6, 6)] },
                _ => texels::blocks(format),
            },
            ..r
        },
    ),
    Misreading {
        slug: "rgb-as-lrgb",
        clause: "2.2/1",
        effect: "reads RGB as LRGB",
        mend: "RGB has three polynomials for each texel",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                (clause == "2.2/1" && text == "PTM_FORMAT_RGB")
                    .then(|| "PTM_FORMAT_LRGB".to_owned())
            })
        }),
    },
    Misreading {
        slug: "rgb-coefficients-by-color",
        clause: "2.7.1/1",
        effect: "takes a texel's eighteen bytes for a0 of red, green, blue, then a1 and so on",
        mend: "each block holds a0…a5 of one color",
        at: At::Planes(|ptm| {
            if ptm.header.format == Format::Rgb {
                each(ptm, |texel| {
                    let stored = texel.to_vec();
                    for (i, value) in texel.iter_mut().enumerate() {
                        *value = stored[i % 6 * 3 + i / 6];
                    }
                });
            }
        }),
    },
    planes(
        "color-block-bgr",
        "2.7.3/2",
        "reads the color block of an LRGB file as B, G, R",
        |ptm| {
            if ptm.header.format == Format::Lrgb {
                each(ptm, |texel| texel.swap(6, 8));
            }
        },
    ),
    planes(
        "coefficients-reversed",
        "2.7.1/1",
        "reads the coefficients of a texel from a5 to a0",
        |ptm| {
            each(ptm, |texel| {
                let polynomials = if texel.len() == 18 { 18 } else { 6 };
                texel[..polynomials]
                    .chunks_exact_mut(6)
                    .for_each(<[u8]>::reverse);
            });
        },
    ),
    planes(
        "a0-last",
        "2.7.1/1",
        "reads the coefficients of a texel as a1…a5, a0",
        |ptm| {
            each(ptm, |texel| {
                let polynomials = if texel.len() == 18 { 18 } else { 6 };
                texel[..polynomials]
                    .chunks_exact_mut(6)
                    .for_each(|a| a.rotate_right(1));
            });
        },
    ),
    planes(
        "mirrored",
        "2.7.1/3",
        "runs each row from right to left",
        |ptm| {
            let (row, channels) = row_and_channels(ptm);
            let turned = ptm
                .planes
                .samples
                .chunks_exact(row)
                .flat_map(|row| row.rchunks_exact(channels).flatten())
                .copied();
            ptm.planes.samples = turned.collect();
        },
    ),
    planes(
        "columns-first",
        "2.7.1/3",
        "takes texels column after column",
        |ptm| {
            let (width, height) = (
                ptm.planes.size.width as usize,
                ptm.planes.size.height as usize,
            );
            let channels = ptm.planes.shape.channels();
            // Back to stored order, then down the columns from the bottom.
            let row = width * channels;
            let stored: Vec<u8> = ptm
                .planes
                .samples
                .rchunks_exact(row)
                .flatten()
                .copied()
                .collect();
            let texel = |i: usize| {
                let (x, y) = (i % width, height - 1 - i / width);
                &stored[(x * height + y) * channels..][..channels]
            };
            ptm.planes.samples = (0..width * height).flat_map(texel).copied().collect();
        },
    ),
    planes(
        "last-row-lost",
        "2.7.1/3",
        "leaves the last stored row empty",
        |ptm| {
            let (row, _) = row_and_channels(ptm);
            ptm.planes.samples[..row].fill(0);
        },
    ),
    planes(
        "first-row-lost",
        "2.7.1/3",
        "leaves the first stored row empty",
        |ptm| {
            let (row, _) = row_and_channels(ptm);
            let start = ptm.planes.samples.len() - row;
            ptm.planes.samples[start..].fill(0);
        },
    ),
    planes(
        "last-column-lost",
        "2.7.1/3",
        "leaves the last column empty",
        |ptm| {
            let (row, channels) = row_and_channels(ptm);
            ptm.planes.samples.chunks_exact_mut(row).for_each(|row| {
                row.iter_mut()
                    .rev()
                    .take(channels)
                    .for_each(|value| *value = 0);
            });
        },
    ),
    planes(
        "rows-rotated-by-one",
        "2.7.1/3",
        "puts the first stored row at the top and all others one row lower",
        |ptm| {
            let (row, _) = row_and_channels(ptm);
            ptm.planes.samples.rotate_right(row);
        },
    ),
    planes(
        "texels-counted-in-16-bits",
        "2.7/1",
        "leaves texels from the 65,536th on empty",
        |ptm| {
            let channels = ptm.planes.shape.channels();
            let (width, height) = (
                ptm.planes.size.width as usize,
                ptm.planes.size.height as usize,
            );
            for (i, texel) in ptm.planes.samples.chunks_exact_mut(channels).enumerate() {
                let stored = (height - 1 - i / width) * width + i % width;
                if stored >= 65_536 {
                    texel.fill(0);
                }
            }
        },
    ),
    planes(
        "columns-counted-in-8-bits",
        "2.3/1",
        "leaves columns from the 256th on empty",
        |ptm| {
            let (row, channels) = row_and_channels(ptm);
            for row in ptm.planes.samples.chunks_exact_mut(row) {
                row.iter_mut()
                    .skip(256 * channels)
                    .for_each(|value| *value = 0);
            }
        },
    ),
    planes(
        "rows-counted-in-8-bits",
        "2.3/1",
        "leaves stored rows from the 256th on empty",
        |ptm| {
            let (row, _) = row_and_channels(ptm);
            let lost = (ptm.planes.size.height as usize).saturating_sub(256) * row;
            ptm.planes.samples[..lost].fill(0);
        },
    ),
    planes(
        "square-only",
        "2.3/1",
        "takes the larger of width and height for a row's length",
        |ptm| {
            let (width, height) = (
                ptm.planes.size.width as usize,
                ptm.planes.size.height as usize,
            );
            if height > width {
                let channels = ptm.planes.shape.channels();
                let length = ptm.planes.samples.len();
                let shifted: Vec<u8> = (0..length)
                    .map(|i| {
                        ptm.planes.samples[(i / (width * channels) * height * channels
                            + i % (width * channels))
                            % length]
                    })
                    .collect();
                ptm.planes.samples = shifted;
            }
        },
    ),
    Misreading {
        slug: "height-before-width",
        clause: "2.3/1",
        effect: "takes the first size for the height",
        mend: "the width comes first",
        at: At::Bytes(|file| match file.texts(&["2.3/1"])[..] {
            [width, height] => {
                let (width, height) = (width.to_owned(), height.to_owned());
                let places: Vec<_> = file
                    .fields
                    .iter()
                    .filter(|field| field.clause == "2.3/1")
                    .map(|field| field.range.clone())
                    .collect();
                let mut bytes = file.file.to_vec();
                bytes.splice(places[1].clone(), width.bytes());
                bytes.splice(places[0].clone(), height.bytes());
                Seen::File(bytes)
            }
            _ => file.unchanged(),
        }),
    },
    Misreading {
        slug: "blocks-separated",
        clause: "2.7/2",
        effect: "expects a byte between the blocks of a file",
        mend: "nothing stands between blocks",
        at: At::Bytes(|file| {
            let (Ok(ptm), ["PTM_FORMAT_RGB" | "PTM_FORMAT_LRGB"]) = (
                crate::decode::decode(file.file),
                &file.texts(&["2.2/1"])[..],
            ) else {
                return file.unchanged();
            };
            // The blocks that follow the first one start a byte later each.
            let first = file.payload() + ptm.header.size.texels() * 6;
            let second = first + ptm.header.size.texels() * 6 + 1;
            let mut bytes = file.file.to_vec();
            if ptm.header.format == Format::Rgb && second < bytes.len() {
                bytes.remove(second);
            }
            bytes.remove(first);
            Seen::File(bytes)
        }),
    },
    Misreading {
        slug: "trailing-bytes-are-the-end",
        clause: "2.7/3",
        effect: "counts the payload from the end of the file",
        mend: "the payload follows the header; what follows it belongs to nobody",
        at: At::Bytes(|file| {
            let extra = crate::decode::decode(file.file)
                .ok()
                .map(|_| file.fields.last().map_or(0, |field| field.range.end));
            let extra = file.file.len() - extra.unwrap_or(file.file.len());
            Seen::File([file.header(), &file.file[file.payload() + extra..]].concat())
        }),
    },
];

pub(super) const fn stored_row(
    slug: &'static str,
    clause: &'static str,
    effect: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause,
        effect,
        mend: "the bottom row is stored first",
        at: At::Reading(Decision::StoredRow, change),
    }
}

const fn planes(
    slug: &'static str,
    clause: &'static str,
    effect: &'static str,
    edit: fn(&mut Ptm),
) -> Misreading {
    Misreading {
        slug,
        clause,
        effect,
        mend: "compare your texel loop with the clause",
        at: At::Planes(edit),
    }
}

const fn blocks(
    slug: &'static str,
    clause: &'static str,
    effect: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause,
        effect,
        mend: "compare your loop over the payload with the clause",
        at: At::Reading(Decision::Blocks, change),
    }
}

/// A block of one channel.
pub(super) const fn one(channel: usize) -> Block {
    run(channel, 1)
}

const fn run(channel: usize, channels: usize) -> Block {
    Block { channel, channels }
}

/// Changes the channels of every texel.
pub(super) fn each(ptm: &mut Ptm, change: fn(&mut [u8])) {
    let channels = ptm.planes.shape.channels();
    ptm.planes
        .samples
        .chunks_exact_mut(channels)
        .for_each(change);
}

/// Bytes of a row, bytes of a texel.
fn row_and_channels(ptm: &Ptm) -> (usize, usize) {
    let channels = ptm.planes.shape.channels();
    (ptm.planes.size.width as usize * channels, channels)
}
