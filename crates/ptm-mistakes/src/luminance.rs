//! §2.6 Color Matrix and §2.7.2 `PTM_FORMAT_LUM`: mistakes in applying the matrix and in choosing its operands

use super::anatomy::EditedFile;
use super::hook::{Hook, Steps};

pub const STEPS: Steps = |slug| {
    Some(match slug {
        "matrix-not-read" => Hook::Bytes(|file| {
            let Some(start) = file.nth_field("2.6/2", 0).map(|field| field.range.start) else {
                return file.unchanged();
            };
            file.with_payload(&file.file[start..])
        }),
        "matrix-exponent-refused" => {
            Hook::Bytes(|file| file.refuse_text(&["2.6/2"], |text| text.contains(['e', 'E'])))
        }
        "matrix-fifteen-elements" => Hook::Bytes(|file| {
            let Some(start) = file.nth_field("2.6/2", 0).map(|field| field.range.start) else {
                return file.unchanged();
            };
            let mut lines = file.file[start..].split(|&byte| byte == b'\n');
            let line = lines.next().unwrap_or_default();
            let (before, after) = file.file.split_at(start + line.len());
            match line.split(|&byte| byte == b' ').count() {
                15 => EditedFile::File([before, b" 0", after].concat()),
                _ => file.unchanged(),
            }
        }),
        "matrix-numbers-cut" => Hook::LumMatrix(|m| {
            ptm::decode::color_matrix::column_major_rows(m).map(|row| row.map(f64::trunc))
        }),
        "matrix-transposed-but-translation" => Hook::LumMatrix(|m| {
            [0, 1, 2].map(|row| [4 * row, 4 * row + 1, 4 * row + 2, 12 + row].map(|i| m.0[i]))
        }),
        "matrix-ignored" => Hook::LumMatrix(|_| {
            [0, 1, 2].map(|row| [0, 1, 2, 3].map(|i| f64::from(u8::from(row == i))))
        }),
        "matrix-of-jfif" => Hook::LumMatrix(|_| {
            [
                [1.0, 1.402, 0.0, -179.456],
                [1.0, -0.714_136, -0.344_136, 135.459],
                [1.0, 0.0, 1.772, -226.816],
            ]
        }),
        "colors-of-jfif-first" => Hook::LumVector(jfif_colors, jfif_colors),
        "chroma-removed" => Hook::LumMatrix(|_| [[1.0, 0.0, 0.0, 0.0]; 3]),
        "matrix-rows-as-blue-green-red" => Hook::LumMatrix(|m| {
            let [red, green, blue] = ptm::decode::color_matrix::column_major_rows(m);
            [blue, green, red]
        }),
        "translation-ignored" => Hook::LumTranslation(|_| 0.0),
        "translation-subtracted" => Hook::LumTranslation(|t| -t),
        "chroma-centered" => Hook::LumVector(
            |y, cr, cb| [y, cr - 128.0, cb - 128.0],
            |y, cr, cb| [cr - 128.0, y, cb - 128.0],
        ),
        "chroma-signed" => Hook::LumVector(
            |y, cr, cb| [y, as_signed_byte(cr), as_signed_byte(cb)],
            |y, cr, cb| [as_signed_byte(cr), y, as_signed_byte(cb)],
        ),
        "chroma-swapped-in-the-vector" => {
            Hook::LumVector(|y, cr, cb| [y, cb, cr], |y, cr, cb| [cb, y, cr])
        }
        "luminance-clamped" => Hook::LumVector(
            |y, cr, cb| [y.clamp(0.0, 255.0), cr, cb],
            |y, cr, cb| [cr, y.clamp(0.0, 255.0), cb],
        ),
        "luminance-in-a-byte" => Hook::LumVector(
            |y, cr, cb| [f64::from(y as i64 as u8), cr, cb],
            |y, cr, cb| [cr, f64::from(y as i64 as u8), cb],
        ),
        _ => return None,
    })
};

/// Converts a color to red, green and blue with the constants of JFIF.
fn jfif_colors(y: f64, cr: f64, cb: f64) -> [f64; 3] {
    let (cr, cb) = (cr - 128.0, cb - 128.0);
    [
        y + 1.402 * cr,
        y - 0.714_136 * cr - 0.344_136 * cb,
        y + 1.772 * cb,
    ]
}

fn as_signed_byte(value: f64) -> f64 {
    f64::from(value as u8 as i8)
}
