//! Files with the same image, for which the results of a decoder must not differ.
//!
//! These checks need no expected output. They catch mistakes that reference and decoder share, and they work on any file.

use crate::generate::spelling::Line;
use crate::generate::{Model, Numbers, Recipe, Spelling, write};
use crate::ptm::{Format, Ptm, Shape};

/// Another file with the same stored values.
pub struct OtherFile {
    /// Its difference, in words: "as `JPEGLS_RGB`".
    pub how: String,
    /// The file.
    pub file: Vec<u8>,
}

/// Returns the same values in other formats, and in other spellings of the header.
#[must_use]
pub fn encodings(ptm: &Ptm) -> Vec<OtherFile> {
    let formats: &[Format] = match ptm.planes.shape {
        Shape::Rgb => &[Format::Rgb, Format::JpeglsRgb],
        Shape::Lrgb => &[
            Format::Lrgb,
            Format::PtmLut,
            Format::PtmCLut,
            Format::JpeglsLrgb,
        ],
        Shape::Lum(_) => &[Format::Lum],
    };
    let own = formats[0];
    let mut encodings: Vec<OtherFile> = formats
        .iter()
        .filter_map(|&format| {
            Some(OtherFile {
                how: format!("as {}", format.short_name()),
                file: encode(ptm, format, Spelling::default())?,
            })
        })
        .collect();
    let spellings: [(&str, fn(&mut Spelling)); 4] = [
        ("with width and height on one line", |s| {
            s.size_on_two_lines = false;
        }),
        ("with scales and biases on one line", |s| {
            s.scale_bias_on_two_lines = false;
        }),
        ("with a space before each line feed of the header", |s| {
            s.space_before_newline = Line::ALL.to_vec();
        }),
        ("with two spaces between numbers", |s| s.gap = 2),
    ];
    for (how, spell) in spellings {
        let mut spelling = Spelling::default();
        spell(&mut spelling);
        encodings.extend(encode(ptm, own, spelling).map(|file| OtherFile {
            how: format!("as {}, {how}", own.short_name()),
            file,
        }));
    }
    encodings
}

/// Returns the values of `ptm` in another format of the same shape, or `None` if they do not fit into it.
fn encode(ptm: &Ptm, format: Format, spelling: Spelling) -> Option<Vec<u8>> {
    let size = ptm.planes.size;
    // A JPEG-LS stream has at most 65,535 columns and rows.
    if format.is_compressed() && size.width.max(size.height) > 65_535 {
        return None;
    }
    let ordinary = Recipe::ordinary(format, size);
    let recipe = Recipe {
        scale: numbers(&ptm.header.scale_bias.scale)?,
        bias: numbers(&ptm.header.scale_bias.bias)?,
        matrix: match ptm.planes.shape {
            Shape::Lum(matrix) => numbers(&matrix.0)?,
            _ => ordinary.matrix,
        },
        spelling,
        ..ordinary
    };
    let model = Model::of(&recipe, &ptm.planes.samples).ok()?;
    Some(write(&recipe, &model).bytes)
}

/// Returns numbers in a spelling that is read as the same value.
fn numbers<const N: usize>(values: &[f64; N]) -> Option<Numbers<N>> {
    let texts: Vec<String> = values.iter().map(f64::to_string).collect();
    texts.join(" ").parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decode;

    #[test]
    fn every_encoding_holds_the_same_values() {
        for format in [Format::Rgb, Format::Lrgb, Format::Lum, Format::PtmLut] {
            let recipe = Recipe::ordinary(format, "7x5".parse().expect("a size"));
            let file = write(&recipe, &Model::paint(&recipe)).bytes;
            let ptm = decode(&file).expect("a generated file is legal");
            let encodings = encodings(&ptm);
            assert!(encodings.len() >= 5);
            for encoding in encodings {
                let again = decode(&encoding.file).expect("an encoding is legal");
                assert_eq!(again.planes, ptm.planes, "{format} {}", encoding.how);
                assert_eq!(again.header.scale_bias, ptm.header.scale_bias);
            }
        }
    }
}
