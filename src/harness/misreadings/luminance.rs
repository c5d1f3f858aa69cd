//! §2.6 Color Matrix and §2.7.2 `PTM_FORMAT_LUM`

use super::layout::one;
use super::{At, Decision, Misreading, Seen};
use crate::decode::texels::{self, Block};
use crate::ptm::{Format, Shape};
use crate::reading::Reading;

pub(super) const ALL: &[Misreading] = &[
    Misreading {
        slug: "matrix-not-read",
        clause: "2.6/1",
        effect: "takes the matrix for payload",
        mend: "sixteen numbers on a line follow the biases of a LUM file",
        at: At::Bytes(|file| {
            let Some(start) = file
                .fields
                .iter()
                .find(|field| field.clause == "2.6/2")
                .map(|field| field.range.start)
            else {
                return file.unchanged();
            };
            let matrix = &file.file[start..file.payload()];
            Seen::File([file.header(), matrix, &file.file[file.payload()..]].concat())
        }),
    },
    Misreading {
        slug: "matrix-exponent-refused",
        clause: "2.6/2",
        effect: "refuses matrix elements with an exponent",
        mend: "they are floating point numbers",
        at: At::Bytes(|file| {
            file.refused_if(
                file.texts(&["2.6/2"])
                    .iter()
                    .any(|text| text.contains(['e', 'E'])),
            )
        }),
    },
    Misreading {
        slug: "matrix-fifteen-elements",
        clause: "2.6/2",
        effect: "does not miss an element of the matrix",
        mend: "refuse a matrix of fewer than sixteen elements",
        at: At::Bytes(|file| {
            let Some(start) = file
                .fields
                .iter()
                .find(|field| field.clause == "2.6/2")
                .map(|field| field.range.start)
            else {
                return file.unchanged();
            };
            let line = file.file[start..]
                .split(|&byte| byte == b'\n')
                .next()
                .unwrap_or_default();
            match line.split(|&byte| byte == b' ').count() {
                15 => Seen::File(
                    [
                        &file.file[..start + line.len()],
                        b" 0",
                        &file.file[start + line.len()..],
                    ]
                    .concat(),
                ),
                _ => file.unchanged(),
            }
        }),
    },
    Misreading {
        slug: "matrix-numbers-cut",
        clause: "2.6/2",
        effect: "reads matrix elements as integers",
        mend: "they are floating point numbers",
        at: At::Reading(Decision::LumMatrix, |r| Reading {
            lum_matrix: |m| {
                crate::decode::color_matrix::columns_first(m).map(|row| row.map(f64::trunc))
            },
            ..r
        }),
    },
    Misreading {
        slug: "matrix-transposed-but-translation",
        clause: "2.6/3",
        effect: "reads the nine factors rows first and the translation columns first",
        mend: "all sixteen are stored columns first",
        at: At::Reading(Decision::LumMatrix, |r| Reading {
            lum_matrix: |m| {
                [0, 1, 2].map(|row| {
                    [
                        m.0[4 * row],
                        m.0[4 * row + 1],
                        m.0[4 * row + 2],
                        m.0[12 + row],
                    ]
                })
            },
            ..r
        }),
    },
    Misreading {
        slug: "matrix-ignored",
        clause: "2.6/4",
        effect: "takes Y, Cr, Cb for red, green, blue and does not use the matrix",
        mend: "multiply by the matrix",
        at: At::Reading(Decision::LumMatrix, |r| Reading {
            lum_matrix: |_| {
                [
                    [1.0, 0.0, 0.0, 0.0],
                    [0.0, 1.0, 0.0, 0.0],
                    [0.0, 0.0, 1.0, 0.0],
                ]
            },
            ..r
        }),
    },
    Misreading {
        slug: "matrix-of-jfif",
        clause: "2.6/4",
        effect: "converts YCbCr with JPEG's constants instead of the file's matrix",
        mend: "multiply by the matrix of the file",
        at: At::Reading(Decision::LumMatrix, |r| Reading {
            lum_matrix: |_| {
                [
                    [1.0, 1.402, 0.0, -179.456],
                    [1.0, -0.714_136, -0.344_136, 135.459],
                    [1.0, 0.0, 1.772, -226.816],
                ]
            },
            ..r
        }),
    },
    Misreading {
        slug: "colors-of-jfif-first",
        clause: "2.6/4",
        effect: "makes red, green and blue of Y, Cr and Cb with JPEG's constants, and multiplies these by the matrix",
        mend: "the matrix multiplies Y, Cr, Cb and 1 themselves",
        at: At::Reading(Decision::LumVector, |r| Reading {
            lum_vector: |y, cr, cb| {
                let (cr, cb) = (cr - 128.0, cb - 128.0);
                [
                    y + 1.402 * cr,
                    y - 0.714_136 * cr - 0.344_136 * cb,
                    y + 1.772 * cb,
                ]
            },
            ..r
        }),
    },
    Misreading {
        slug: "chroma-removed",
        clause: "2.6/4",
        effect: "shows Y as a grey picture",
        mend: "multiply by the matrix",
        at: At::Reading(Decision::LumMatrix, |r| Reading {
            lum_matrix: |_| [[1.0, 0.0, 0.0, 0.0]; 3],
            ..r
        }),
    },
    Misreading {
        slug: "matrix-rows-as-blue-green-red",
        clause: "2.6/4",
        effect: "takes the first row of the matrix for blue",
        mend: "the rows make red, green and blue",
        at: At::Reading(Decision::LumMatrix, |r| Reading {
            lum_matrix: |m| {
                let [red, green, blue] = crate::decode::color_matrix::columns_first(m);
                [blue, green, red]
            },
            ..r
        }),
    },
    Misreading {
        slug: "translation-ignored",
        clause: "2.6/5",
        effect: "does not add the translation",
        mend: "elements 12, 13 and 14 are added",
        at: At::Reading(Decision::LumTranslation, |r| Reading {
            lum_translation: |_| 0.0,
            ..r
        }),
    },
    Misreading {
        slug: "translation-subtracted",
        clause: "2.6/5",
        effect: "subtracts the translation",
        mend: "elements 12, 13 and 14 are added",
        at: At::Reading(Decision::LumTranslation, |r| Reading {
            lum_translation: |t| -t,
            ..r
        }),
    },
    Misreading {
        slug: "chroma-centered",
        clause: "2.6/4",
        effect: "subtracts 128 from Cr and Cb before multiplying",
        mend: "offsets are the matrix's business: it has a translation",
        at: At::Reading(Decision::LumVector, |r| {
            multiplying(
                r,
                |y, cr, cb| [y, cr - 128.0, cb - 128.0],
                |y, cr, cb| [cr - 128.0, y, cb - 128.0],
            )
        }),
    },
    Misreading {
        slug: "chroma-signed",
        clause: "2.6/4",
        effect: "takes Cr and Cb for signed bytes",
        mend: "they count from 0 to 255; offsets are the matrix's business",
        at: At::Reading(Decision::LumVector, |r| {
            multiplying(
                r,
                |y, cr, cb| [y, signed(cr), signed(cb)],
                |y, cr, cb| [signed(cr), y, signed(cb)],
            )
        }),
    },
    Misreading {
        slug: "chroma-swapped-in-the-vector",
        clause: "2.7.2/2",
        effect: "multiplies the matrix by (Y, Cb, Cr, 1)",
        mend: "Cr comes before Cb, as it is stored",
        at: At::Reading(Decision::LumVector, |r| {
            multiplying(r, |y, cr, cb| [y, cb, cr], |y, cr, cb| [cb, y, cr])
        }),
    },
    Misreading {
        slug: "luminance-clamped",
        clause: "2.7.3/5",
        effect: "clamps Y to 0…255 before multiplying by the matrix",
        mend: "clamp the final color only",
        at: At::Reading(Decision::LumVector, |r| {
            multiplying(
                r,
                |y, cr, cb| [y.clamp(0.0, 255.0), cr, cb],
                |y, cr, cb| [cr, y.clamp(0.0, 255.0), cb],
            )
        }),
    },
    Misreading {
        slug: "luminance-in-a-byte",
        clause: "2.7.3/5",
        effect: "keeps Y in a byte, wrapping around, before multiplying by the matrix",
        mend: "clamp the final color only",
        at: At::Reading(Decision::LumVector, |r| {
            multiplying(
                r,
                |y, cr, cb| [f64::from(y as i64 as u8), cr, cb],
                |y, cr, cb| [cr, f64::from(y as i64 as u8), cb],
            )
        }),
    },
    Misreading {
        slug: "cb-before-cr",
        clause: "2.7.2/1",
        effect: "reads Cb before Cr",
        mend: "the order is a0…a5, Cr, Cb",
        at: At::Planes(|ptm| {
            if let Shape::Lum(_) = ptm.planes.shape {
                ptm.planes
                    .samples
                    .chunks_exact_mut(8)
                    .for_each(|texel| texel.swap(6, 7));
            }
        }),
    },
    Misreading {
        slug: "chroma-before-coefficients",
        clause: "2.7.2/1",
        effect: "reads Cr and Cb before the coefficients",
        mend: "the order is a0…a5, Cr, Cb",
        at: At::Planes(|ptm| {
            if let Shape::Lum(_) = ptm.planes.shape {
                ptm.planes
                    .samples
                    .chunks_exact_mut(8)
                    .for_each(|texel| texel.rotate_left(2));
            }
        }),
    },
    Misreading {
        slug: "lum-planar",
        clause: "2.7.2/1",
        effect: "reads LUM texels as eight planes",
        mend: "the eight bytes of a texel stand side by side",
        at: At::Reading(Decision::Blocks, |r| Reading {
            blocks: |format| match format {
                Format::Lum => {
                    const {
                        &[
                            one(0),
                            one(1),
                            one(2),
                            one(3),
                            one(4),
                            one(5),
                            one(6),
                            one(7),
                        ]
                    }
                }
                _ => texels::blocks(format),
            },
            ..r
        }),
    },
    Misreading {
        slug: "lum-two-blocks",
        clause: "2.7.2/1",
        effect: "reads LUM as a block of coefficients and a block of Cr, Cb",
        mend: "the eight bytes of a texel stand side by side",
        at: At::Reading(Decision::Blocks, |r| Reading {
            blocks: |format| match format {
                Format::Lum => {
                    const {
                        &[
                            Block {
                                channel: 0,
                                channels: 6,
                            },
                            Block {
                                channel: 6,
                                channels: 2,
                            },
                        ]
                    }
                }
                _ => texels::blocks(format),
            },
            ..r
        }),
    },
    Misreading {
        slug: "lum-chroma-in-planes",
        clause: "2.7.2/1",
        effect: "reads LUM as a block of coefficients, a plane of Cr and a plane of Cb",
        mend: "the eight bytes of a texel stand side by side",
        at: At::Reading(Decision::Blocks, |r| Reading {
            blocks: |format| match format {
                Format::Lum => {
                    const {
                        &[
                            Block {
                                channel: 0,
                                channels: 6,
                            },
                            one(6),
                            one(7),
                        ]
                    }
                }
                _ => texels::blocks(format),
            },
            ..r
        }),
    },
    Misreading {
        slug: "lum-rows-top-down",
        clause: "2.7.2/3",
        effect: "takes the first stored row of a LUM file for the top",
        mend: "the bottom row is stored first",
        at: At::Reading(Decision::StoredRow, |r| Reading {
            stored_row: |format, _, row, height| {
                if format == Format::Lum {
                    row
                } else {
                    height - 1 - row
                }
            },
            ..r
        }),
    },
];

/// The byte of this value, read as a signed one.
fn signed(value: f64) -> f64 {
    f64::from(value as u8 as i8)
}

/// What the matrix multiplies, for a reader who has Y first and for one who has Cr first (ruling `lum-vector`).
fn multiplying(
    reading: Reading,
    y_first: fn(f64, f64, f64) -> [f64; 3],
    cr_first: fn(f64, f64, f64) -> [f64; 3],
) -> Reading {
    let [first, ..] = (reading.lum_vector)(1.0, 2.0, 3.0);
    Reading {
        lum_vector: if first == 2.0 { cr_first } else { y_first },
        ..reading
    }
}
