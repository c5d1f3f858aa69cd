//! §2.6 Color Matrix and §2.7.2 `PTM_FORMAT_LUM`: mistakes in applying the matrix and in choosing its operands

use super::anatomy::EditedFile;
use super::change::{Change, Changes};
use ptm::decode::color_matrix::column_major_rows;
use ptm::evaluate;

pub const CHANGES: Changes = |slug| {
    Some(match slug {
        "matrix-not-read" => Change::Bytes(|file| {
            let Some(start) = file.nth_field("2.6/2", 0).map(|field| field.range.start) else {
                return file.unchanged();
            };
            file.with_payload(&file.file[start..])
        }),
        "matrix-exponent-refused" => {
            Change::Bytes(|file| file.refuse_text(&["2.6/2"], |text| text.contains(['e', 'E'])))
        }
        "matrix-fifteen-elements" => Change::Bytes(|file| {
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
        "matrix-numbers-cut" => Change::Reading(|r| {
            r.lum_matrix = |m| column_major_rows(m).map(|row| row.map(f64::trunc));
        }),
        "matrix-transposed-but-translation" => Change::Reading(|r| {
            r.lum_matrix = |m| {
                [0, 1, 2].map(|row| [4 * row, 4 * row + 1, 4 * row + 2, 12 + row].map(|i| m.0[i]))
            };
        }),
        "matrix-ignored" => Change::Reading(|r| {
            r.lum_matrix =
                |_| [0, 1, 2].map(|row| [0, 1, 2, 3].map(|i| f64::from(u8::from(row == i))));
        }),
        "matrix-of-jfif" => Change::Reading(|r| {
            r.lum_matrix = |_| {
                [
                    [1.0, 1.402, 0.0, -179.456],
                    [1.0, -0.714_136, -0.344_136, 135.459],
                    [1.0, 0.0, 1.772, -226.816],
                ]
            };
        }),
        "colors-of-jfif-first" => Change::Reading(|r| r.lum_vector = jfif_colors),
        "chroma-removed" => Change::Reading(|r| r.lum_matrix = |_| [[1.0, 0.0, 0.0, 0.0]; 3]),
        "matrix-rows-as-blue-green-red" => Change::Reading(|r| {
            r.lum_matrix = |m| {
                let [red, green, blue] = column_major_rows(m);
                [blue, green, red]
            };
        }),
        "translation-ignored" => Change::Reading(|r| r.lum_translation = |_| 0.0),
        "translation-subtracted" => Change::Reading(|r| r.lum_translation = |t| -t),
        "chroma-centered" => Change::Reading(|r| r.lum_chroma = evaluate::centered_lum_chroma),
        "chroma-signed" => Change::Reading(|r| {
            r.lum_values = |y, cr, cb| [y, as_signed_byte(cr), as_signed_byte(cb)];
        }),
        "chroma-swapped-in-the-vector" => {
            Change::Reading(|r| r.lum_values = |y, cr, cb| [y, cb, cr])
        }
        "luminance-clamped" => {
            Change::Reading(|r| r.lum_luminance = evaluate::clamped_lum_luminance)
        }
        "luminance-in-a-byte" => {
            Change::Reading(|r| r.lum_values = |y, cr, cb| [f64::from(y as i64 as u8), cr, cb])
        }
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
