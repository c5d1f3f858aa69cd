//! §2.6 Color Matrix and §2.7.2 `PTM_FORMAT_LUM`: mistakes with the matrix and its operands

use super::anatomy::EditedFile;
use super::at::At;

pub(super) const CHANGES: &[(&str, At)] = &[
    (
        "matrix-not-read",
        At::Bytes(|file| {
            let Some(start) = file.nth_field("2.6/2", 0).map(|field| field.range.start) else {
                return file.unchanged();
            };
            let matrix = &file.file[start..file.payload_offset()];
            EditedFile::File([file.header(), matrix, &file.file[file.payload_offset()..]].concat())
        }),
    ),
    (
        "matrix-exponent-refused",
        At::Bytes(|file| {
            file.refuse_if(
                file.field_texts(&["2.6/2"])
                    .iter()
                    .any(|text| text.contains(['e', 'E'])),
            )
        }),
    ),
    (
        "matrix-fifteen-elements",
        At::Bytes(|file| {
            let Some(start) = file.nth_field("2.6/2", 0).map(|field| field.range.start) else {
                return file.unchanged();
            };
            let line = file.file[start..]
                .split(|&byte| byte == b'\n')
                .next()
                .unwrap_or_default();
            match line.split(|&byte| byte == b' ').count() {
                15 => EditedFile::File(
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
    ),
    (
        "matrix-numbers-cut",
        At::LumMatrix(|m| {
            crate::decode::color_matrix::column_major_rows(m).map(|row| row.map(f64::trunc))
        }),
    ),
    (
        "matrix-transposed-but-translation",
        At::LumMatrix(|m| {
            [0, 1, 2].map(|row| {
                [
                    m.0[4 * row],
                    m.0[4 * row + 1],
                    m.0[4 * row + 2],
                    m.0[12 + row],
                ]
            })
        }),
    ),
    (
        "matrix-ignored",
        At::LumMatrix(|_| {
            [
                [1.0, 0.0, 0.0, 0.0],
                [0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0],
            ]
        }),
    ),
    (
        "matrix-of-jfif",
        At::LumMatrix(|_| {
            [
                [1.0, 1.402, 0.0, -179.456],
                [1.0, -0.714_136, -0.344_136, 135.459],
                [1.0, 0.0, 1.772, -226.816],
            ]
        }),
    ),
    (
        "colors-of-jfif-first",
        At::LumVector(jfif_colors, jfif_colors),
    ),
    (
        "chroma-removed",
        At::LumMatrix(|_| [[1.0, 0.0, 0.0, 0.0]; 3]),
    ),
    (
        "matrix-rows-as-blue-green-red",
        At::LumMatrix(|m| {
            let [red, green, blue] = crate::decode::color_matrix::column_major_rows(m);
            [blue, green, red]
        }),
    ),
    ("translation-ignored", At::LumTranslation(|_| 0.0)),
    ("translation-subtracted", At::LumTranslation(|t| -t)),
    (
        "chroma-centered",
        At::LumVector(
            |y, cr, cb| [y, cr - 128.0, cb - 128.0],
            |y, cr, cb| [cr - 128.0, y, cb - 128.0],
        ),
    ),
    (
        "chroma-signed",
        At::LumVector(
            |y, cr, cb| [y, as_signed_byte(cr), as_signed_byte(cb)],
            |y, cr, cb| [as_signed_byte(cr), y, as_signed_byte(cb)],
        ),
    ),
    (
        "chroma-swapped-in-the-vector",
        At::LumVector(|y, cr, cb| [y, cb, cr], |y, cr, cb| [cb, y, cr]),
    ),
    (
        "luminance-clamped",
        At::LumVector(
            |y, cr, cb| [y.clamp(0.0, 255.0), cr, cb],
            |y, cr, cb| [cr, y.clamp(0.0, 255.0), cb],
        ),
    ),
    (
        "luminance-in-a-byte",
        At::LumVector(
            |y, cr, cb| [f64::from(y as i64 as u8), cr, cb],
            |y, cr, cb| [cr, f64::from(y as i64 as u8), cb],
        ),
    ),
];

/// Converts a color to red, green and blue with the constants of JFIF.
fn jfif_colors(y: f64, cr: f64, cb: f64) -> [f64; 3] {
    let (cr, cb) = (cr - 128.0, cb - 128.0);
    [
        y + 1.402 * cr,
        y - 0.714_136 * cr - 0.344_136 * cb,
        y + 1.772 * cb,
    ]
}

/// Reinterprets the byte with this value as a signed number.
fn as_signed_byte(value: f64) -> f64 {
    f64::from(value as u8 as i8)
}
