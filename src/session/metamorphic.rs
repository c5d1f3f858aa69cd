//! The same picture in other files: what a decoder makes of them must not differ.
//!
//! These checks need no expected output. They catch mistakes that reference and decoder share, and they work on any file.

use std::collections::HashMap;

use crate::codec::jpeg_ls;
use crate::generate::model::Model;
use crate::generate::planes::{Compressed, StoredPlane};
use crate::generate::spelling::Line;
use crate::generate::{Compression, Numbers, Recipe, Spelling, write};
use crate::ptm::{Format, Ptm, Shape};

/// Another file with the same stored values.
pub struct OtherFile {
    /// How it differs, in words: "as `JPEGLS_RGB`".
    pub how: String,
    /// The file.
    pub file: Vec<u8>,
}

/// The same values in other formats, and in other spellings of the header.
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

/// The values of `ptm` in another format of the same shape; nothing where they do not fit into one.
fn encode(ptm: &Ptm, format: Format, spelling: Spelling) -> Option<Vec<u8>> {
    let size = ptm.planes.size;
    let recipe = Recipe {
        scale: numbers(&ptm.header.scale_bias.scale)?,
        bias: numbers(&ptm.header.scale_bias.bias)?,
        matrix: match ptm.planes.shape {
            Shape::Lum(matrix) => numbers(&matrix.0)?,
            _ => Recipe::ordinary(format, size).matrix,
        },
        spelling,
        ..Recipe::ordinary(format, size)
    };
    let mut model = Model {
        format,
        size,
        samples: ptm.planes.samples.clone(),
        table: Vec::new(),
        indices: Vec::new(),
        scale: recipe.scale.values,
        bias: recipe.bias.values,
        matrix: recipe.matrix.values,
        compressed: None,
        slack: Vec::new(),
    };
    if format.has_table() {
        tabulate(&mut model)?;
    }
    if format.is_compressed() {
        compress(&mut model)?;
    }
    Some(write(&recipe, &model).bytes)
}

/// Numbers written so that they are read as they are.
fn numbers<const N: usize>(values: &[f64; N]) -> Option<Numbers<N>> {
    let texts: Vec<String> = values.iter().map(f64::to_string).collect();
    texts.join(" ").parse().ok()
}

/// Every different entry once, in the order in which they occur; nothing if there are more than indices reach.
fn tabulate(model: &mut Model) -> Option<()> {
    let entry_size = if model.format == Format::PtmLut { 6 } else { 9 };
    let mut known: HashMap<Vec<u8>, u32> = HashMap::new();
    for texel in model.samples.chunks_exact(9) {
        let entry = texel[..entry_size].to_vec();
        let next = known.len() as u32;
        let index = *known.entry(entry).or_insert_with_key(|entry| {
            model.table.extend_from_slice(entry);
            next
        });
        model.indices.push(index);
    }
    (known.len() <= 65_536).then_some(())
}

/// Every channel a JPEG-LS stream of its own, without loss or prediction.
fn compress(model: &mut Model) -> Option<()> {
    let (width, height) = (model.size.width, model.size.height);
    if width > 65_535 || height > 65_535 {
        return None;
    }
    let channels = model.format.channels();
    let options = jpeg_ls::JpegLsOptions {
        near: 0,
        presets: None,
    };
    let row = width as usize * channels;
    let plane = |channel: usize| -> StoredPlane {
        // The bottom row is stored first.
        let rows = model.samples.chunks(row).rev();
        let samples: Vec<u8> = rows
            .flat_map(|row| row.iter().skip(channel).step_by(channels))
            .copied()
            .collect();
        StoredPlane {
            stream: jpeg_ls::encode(&samples, width, height, &options).stream,
            records: Vec::new(),
        }
    };
    model.compressed = Some(Compressed {
        plan: Compression::ordinary(model.format),
        planes: (0..channels).map(plane).collect(),
    });
    Some(())
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
