//! One fault at a time.
//!
//! A damage is a named edit of a file that was in order. Some make a file that must be refused, some a file that goes
//! beyond the letter; which is which stands with the cases, not here.

use std::ops::Range;

use super::Written;
use super::scene::Model;
use crate::ptm::Format;

/// A named edit.
pub struct Damage {
    /// A slug that cases use.
    pub name: &'static str,
    /// The clause it breaks, or leaves the letter of.
    pub clause: &'static str,
    /// What is then wrong with the file, as half a sentence.
    pub effect: &'static str,
    edit: fn(&Written, &Model) -> Option<Vec<u8>>,
    /// What the edited file shows, where that is no longer what the original showed.
    picture: fn(&Model) -> Option<Model>,
}

impl Damage {
    /// The damage of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Damage> {
        ALL.iter().find(|damage| damage.name == name)
    }

    /// The edited file; nothing where the file has no such place.
    #[must_use]
    pub fn apply(&self, written: &Written, model: &Model) -> Option<Vec<u8>> {
        (self.edit)(written, model)
    }

    /// The values a reader finds who reads on regardless.
    #[must_use]
    pub fn values(&self, model: &Model) -> Model {
        (self.picture)(model).unwrap_or_else(|| model.clone())
    }
}

const fn damage(
    name: &'static str,
    clause: &'static str,
    effect: &'static str,
    edit: fn(&Written, &Model) -> Option<Vec<u8>>,
) -> Damage {
    Damage {
        name,
        clause,
        effect,
        edit,
        picture: |_| None,
    }
}

/// All damages, in the order of the text.
pub const ALL: &[Damage] = &[
    // 2.0
    damage("file-empty", "2.1/1", "the file has no bytes", |_, _| {
        Some(Vec::new())
    }),
    damage("cr-lf", "2.0/1", "header lines end in CR LF", |file, _| {
        Some(file.header_with(b'\n', b"\r\n"))
    }),
    damage("cr-alone", "2.0/1", "header lines end in CR", |file, _| {
        Some(file.header_with(b'\n', b"\r"))
    }),
    damage("tabs", "2.0/1", "tabs part the numbers", |file, _| {
        Some(file.header_with(b' ', b"\t"))
    }),
    damage(
        "two-spaces-before-newline",
        "2.0/2",
        "header lines end in two spaces",
        |file, _| Some(file.header_with(b'\n', b"  \n")),
    ),
    damage(
        "leading-blank",
        "2.0/1",
        "a space stands before the width",
        |file, _| file.insert("width", 0, b" "),
    ),
    damage(
        "leading-blank-before-scale",
        "2.0/1",
        "a space stands before the scales",
        |file, _| file.insert("scale", 0, b" "),
    ),
    damage(
        "empty-line",
        "2.0/1",
        "an empty line stands before the scales",
        |file, _| file.insert("scale", 0, b"\n"),
    ),
    damage(
        "byte-order-mark",
        "2.1/1",
        "a UTF-8 byte order mark stands before the header",
        |file, _| file.insert("version", 0, b"\xef\xbb\xbf"),
    ),
    // 2.1
    Damage {
        picture: interleaved,
        ..damage("version-1.1", "2.1/1", "the version is 1.1", |file, _| {
            file.replace("version", 0, b"PTM_1.1")
        })
    },
    damage("version-1.3", "2.1/1", "the version is 1.3", |file, _| {
        file.replace("version", 0, b"PTM_1.3")
    }),
    damage("version-2.0", "2.1/1", "the version is 2.0", |file, _| {
        file.replace("version", 0, b"PTM_2.0")
    }),
    damage(
        "version-longer",
        "2.1/1",
        "the version is 1.20",
        |file, _| file.replace("version", 0, b"PTM_1.20"),
    ),
    damage(
        "version-lower-case",
        "2.1/1",
        "the version is in lower case",
        |file, _| file.replace("version", 0, b"ptm_1.2"),
    ),
    damage(
        "not-a-ptm",
        "2.1/1",
        "the file begins as a PNG does",
        |file, _| file.replace("version", 0, b"\x89PNG\r\n\x1a"),
    ),
    // 2.2
    damage(
        "format-unknown",
        "2.2/1",
        "no format has that name",
        |file, _| file.replace("format", 0, b"PTM_FORMAT_LRGBA"),
    ),
    damage(
        "format-cut",
        "2.2/1",
        "the name of the format lacks its end",
        |file, _| file.replace("format", 0, b"PTM_FORMAT_"),
    ),
    damage(
        "format-lower-case",
        "2.2/1",
        "the name of the format is in lower case",
        |file, model| file.replace("format", 0, model.format.name().to_lowercase().as_bytes()),
    ),
    // 2.3
    damage("width-zero", "2.3/3", "the width is 0", |file, _| {
        file.replace("width", 0, b"0")
    }),
    damage("height-zero", "2.3/3", "the height is 0", |file, _| {
        file.replace("height", 0, b"0")
    }),
    damage(
        "both-sizes-zero",
        "2.3/3",
        "width and height are 0",
        |file, _| file.replace_all(&[("width", 0, b"0"), ("height", 0, b"0")]),
    ),
    damage(
        "width-negative",
        "2.3/3",
        "the width is negative",
        |file, model| file.replace("width", 0, format!("-{}", model.size.width).as_bytes()),
    ),
    damage(
        "height-negative",
        "2.3/3",
        "the height is negative",
        |file, model| file.replace("height", 0, format!("-{}", model.size.height).as_bytes()),
    ),
    damage(
        "both-sizes-negative",
        "2.3/3",
        "width and height are negative, their product is not",
        |file, model| {
            let (width, height) = (
                format!("-{}", model.size.width),
                format!("-{}", model.size.height),
            );
            file.replace_all(&[
                ("width", 0, width.as_bytes()),
                ("height", 0, height.as_bytes()),
            ])
        },
    ),
    damage(
        "width-no-number",
        "2.3/1",
        "the width is a word",
        |file, _| file.replace("width", 0, b"wide"),
    ),
    damage(
        "width-with-a-letter",
        "2.3/1",
        "a letter follows the width's digits",
        |file, model| file.replace("width", 0, format!("{}x", model.size.width).as_bytes()),
    ),
    damage(
        "width-hexadecimal",
        "2.3/1",
        "the width is hexadecimal",
        |file, model| file.replace("width", 0, format!("0x{:x}", model.size.width).as_bytes()),
    ),
    damage(
        "width-beyond-64-bits",
        "2.3/3",
        "the width exceeds 64 bits",
        |file, model| {
            // 2⁶⁴ more than the truth: the truth again for whoever wraps around.
            file.replace(
                "width",
                0,
                (u128::from(model.size.width) + (1 << 64))
                    .to_string()
                    .as_bytes(),
            )
        },
    ),
    damage(
        "width-beyond-32-bits",
        "2.3/3",
        "the width exceeds 32 bits",
        |file, model| {
            file.replace(
                "width",
                0,
                (u64::from(model.size.width) + (1 << 32))
                    .to_string()
                    .as_bytes(),
            )
        },
    ),
    damage(
        "product-beyond-32-bits",
        "2.3/3",
        "width times height is 2³², 0 for whoever counts in 32 bits",
        |file, _| file.replace_all(&[("width", 0, b"65536"), ("height", 0, b"65536")]),
    ),
    damage(
        "absurdly-large",
        "2.3/3",
        "width and height are 2³¹ − 1",
        |file, _| file.replace_all(&[("width", 0, b"2147483647"), ("height", 0, b"2147483647")]),
    ),
    damage(
        "height-missing",
        "2.3/1",
        "the height is missing",
        |file, _| file.remove_line("height"),
    ),
    // 2.4
    damage("scale-nan", "2.4/3", "a scale is nan", |file, _| {
        file.replace("scale", 2, b"nan")
    }),
    damage("scale-inf", "2.4/3", "a scale is inf", |file, _| {
        file.replace("scale", 5, b"inf")
    }),
    damage(
        "scale-infinity",
        "2.4/3",
        "a scale is -infinity",
        |file, _| file.replace("scale", 0, b"-infinity"),
    ),
    damage(
        "scale-hexadecimal",
        "2.4/3",
        "a scale is hexadecimal",
        |file, _| file.replace("scale", 1, b"0x1p-1"),
    ),
    damage(
        "scale-overflows",
        "2.4/3",
        "a scale is beyond every float",
        |file, _| file.replace("scale", 3, b"1e400"),
    ),
    damage(
        "scale-no-number",
        "2.4/3",
        "a scale is a word",
        |file, _| file.replace("scale", 4, b"one"),
    ),
    damage(
        "scale-decimal-comma",
        "2.4/3",
        "a scale has a decimal comma",
        |file, _| file.replace("scale", 0, b"0,5"),
    ),
    damage(
        "scale-two-points",
        "2.4/3",
        "a scale has two points",
        |file, _| file.replace("scale", 0, b"0.5.0"),
    ),
    damage(
        "scale-only-a-point",
        "2.4/3",
        "a scale is a point without digits",
        |file, _| file.replace("scale", 1, b"."),
    ),
    damage(
        "scale-exponent-empty",
        "2.4/3",
        "a scale has an exponent without digits",
        |file, _| file.replace("scale", 5, b"1e"),
    ),
    damage(
        "scale-letter-behind",
        "2.4/3",
        "a letter follows a scale",
        |file, _| file.replace("scale", 5, b"0.75f"),
    ),
    damage(
        "scale-missing",
        "2.4/2",
        "there are five scales",
        |file, _| file.remove("scale", 0),
    ),
    damage("bias-nan", "2.4/4", "a bias is nan", |file, _| {
        file.replace("bias", 2, b"nan")
    }),
    damage("bias-no-number", "2.4/4", "a bias is a word", |file, _| {
        file.replace("bias", 5, b"none")
    }),
    damage("bias-fraction", "2.4/4", "a bias is 128.5", |file, _| {
        file.replace("bias", 0, b"128.5")
    }),
    damage(
        "bias-as-float",
        "2.4/4",
        "biases are written with a point",
        |file, _| file.replace_all(&[("bias", 0, b"128.0"), ("bias", 5, b"3.0")]),
    ),
    damage(
        "header-ends-in-scales",
        "2.4/2",
        "the file ends within the scales",
        |file, _| file.cut_at("scale", 3),
    ),
    damage(
        "header-ends-before-biases",
        "2.4/2",
        "the file ends before the biases",
        |file, _| file.cut_at("bias", 0),
    ),
    // 2.5
    damage(
        "entries-zero",
        "2.8/1",
        "the table has no entries, and the texels name some",
        |file, model| {
            let table = file.range("table", 0)?;
            let mut bytes = file.replace("count", 0, b"0")?;
            let grown = model.entries().to_string().len() - 1;
            bytes.drain(table.start - grown..table.end - grown);
            Some(bytes)
        },
    ),
    damage(
        "entries-negative",
        "2.5/2",
        "the number of entries is negative",
        |file, model| file.replace("count", 0, format!("-{}", model.entries()).as_bytes()),
    ),
    damage(
        "entries-no-number",
        "2.5/2",
        "the number of entries is a word",
        |file, _| file.replace("count", 0, b"many"),
    ),
    damage(
        "entries-beyond-the-file",
        "2.5/3",
        "the table is larger than the file",
        |file, _| file.replace("count", 0, b"200000000"),
    ),
    damage(
        "entries-beyond-64-bits",
        "2.5/2",
        "the number of entries exceeds 64 bits",
        |file, model| {
            file.replace(
                "count",
                0,
                (model.entries() as u128 + (1 << 64)).to_string().as_bytes(),
            )
        },
    ),
    damage(
        "table-cut",
        "2.5/3",
        "the file ends within the table",
        |file, _| Some(file.bytes[..file.range("table", 0)?.end - 1].to_vec()),
    ),
    // 2.6
    damage(
        "matrix-missing-an-element",
        "2.6/2",
        "the matrix has fifteen elements",
        |file, _| file.remove("matrix", 15),
    ),
    damage(
        "matrix-no-number",
        "2.6/2",
        "a matrix element is a word",
        |file, _| file.replace("matrix", 5, b"x"),
    ),
    damage(
        "matrix-nan",
        "2.6/2",
        "a matrix element is nan",
        |file, _| file.replace("matrix", 12, b"nan"),
    ),
    damage(
        "matrix-missing",
        "2.6/1",
        "the matrix is missing",
        |file, _| file.remove_line("matrix"),
    ),
    // 2.7
    damage(
        "no-payload",
        "2.7/3",
        "nothing follows the header",
        |file, _| Some(file.bytes[..file.payload].to_vec()),
    ),
    damage(
        "one-byte-short",
        "2.7/3",
        "the last byte is missing",
        |file, _| Some(file.bytes[..file.bytes.len() - 1].to_vec()),
    ),
    damage(
        "half-payload",
        "2.7/3",
        "half of the payload is missing",
        |file, _| Some(file.bytes[..file.payload.midpoint(file.bytes.len())].to_vec()),
    ),
    damage(
        "colors-missing",
        "2.7/3",
        "the block of colors is missing",
        |file, _| file.cut_at("colors", 0),
    ),
    damage(
        "blue-missing",
        "2.7/3",
        "the block of blue coefficients is missing",
        |file, _| file.cut_at("blue coefficients", 0),
    ),
    damage(
        "newline-behind",
        "2.7/3",
        "a line feed follows the last value",
        |file, _| Some([&file.bytes[..], b"\n"].concat()),
    ),
    damage(
        "bytes-behind",
        "2.7/3",
        "5,000 bytes follow the last value",
        |file, _| Some([&file.bytes[..], &[0xa5; 5000]].concat()),
    ),
    // 2.8
    damage(
        "index-past-the-last-entry",
        "2.8/1",
        "the last index equals the number of entries",
        |file, model| file.set_index(model, model.indices.len() - 1, model.entries()),
    ),
    damage(
        "index-first-past-the-last-entry",
        "2.8/1",
        "the first index equals the number of entries",
        |file, model| file.set_index(model, 0, model.entries()),
    ),
    damage(
        "index-largest",
        "2.8/1",
        "the last index has all bits set",
        |file, model| {
            file.set_index(
                model,
                model.indices.len() - 1,
                if model.entries() > 256 { 65_535 } else { 255 },
            )
        },
    ),
];

/// What version 1.1 means by the payload of an LRGB file: nine bytes of each texel side by side.
fn interleaved(model: &Model) -> Option<Model> {
    if model.format != Format::Lrgb {
        return None;
    }
    let row = model.size.width as usize * 9;
    let bottom_up: Vec<&[u8]> = model
        .samples
        .chunks(row)
        .rev()
        .flat_map(|row| row.chunks(9))
        .collect();
    let blocks = bottom_up
        .iter()
        .flat_map(|texel| &texel[..6])
        .chain(bottom_up.iter().flat_map(|texel| &texel[6..]));
    let stored: Vec<u8> = blocks.copied().collect();
    let samples = stored.chunks(row).rev().flatten().copied().collect();
    Some(Model {
        samples,
        ..model.clone()
    })
}

/// The edits that damages are made of. Places are named by a field and which of that name it is.
impl Written {
    fn range(&self, name: &str, nth: usize) -> Option<Range<usize>> {
        self.fields
            .iter()
            .filter(|field| field.name == name)
            .nth(nth)
            .map(|field| field.range.clone())
    }

    fn replace(&self, name: &str, nth: usize, text: &[u8]) -> Option<Vec<u8>> {
        self.replace_all(&[(name, nth, text)])
    }

    fn replace_all(&self, edits: &[(&str, usize, &[u8])]) -> Option<Vec<u8>> {
        let mut bytes = self.bytes.clone();
        // From the back, so that earlier places stay where the map has them.
        for &(name, nth, text) in edits.iter().rev() {
            bytes.splice(self.range(name, nth)?, text.iter().copied());
        }
        Some(bytes)
    }

    fn insert(&self, name: &str, nth: usize, text: &[u8]) -> Option<Vec<u8>> {
        let at = self.range(name, nth)?.start;
        Some([&self.bytes[..at], text, &self.bytes[at..]].concat())
    }

    /// Without a number and the space that parts it from its neighbour.
    fn remove(&self, name: &str, nth: usize) -> Option<Vec<u8>> {
        let Range { start, end } = self.range(name, nth)?;
        let range = if self.bytes[end] == b' ' {
            start..end + 1
        } else {
            start - 1..end
        };
        Some([&self.bytes[..range.start], &self.bytes[range.end..]].concat())
    }

    /// Without the line that begins with this field.
    fn remove_line(&self, name: &str) -> Option<Vec<u8>> {
        let start = self.range(name, 0)?.start;
        let length = self.bytes[start..].iter().position(|&byte| byte == b'\n')? + 1;
        Some([&self.bytes[..start], &self.bytes[start + length..]].concat())
    }

    fn cut_at(&self, name: &str, nth: usize) -> Option<Vec<u8>> {
        Some(self.bytes[..self.range(name, nth)?.start].to_vec())
    }

    /// The header with every byte `from` written as `to`.
    fn header_with(&self, from: u8, to: &[u8]) -> Vec<u8> {
        let spelled = |byte: &u8| {
            if *byte == from {
                to.to_vec()
            } else {
                vec![*byte]
            }
        };
        let header = self.bytes[..self.payload].iter().flat_map(spelled);
        header
            .chain(self.bytes[self.payload..].iter().copied())
            .collect()
    }

    /// With another index for a texel, counted as stored.
    fn set_index(&self, model: &Model, texel: usize, index: usize) -> Option<Vec<u8>> {
        let start = self.range("indices", 0)?.start;
        let mut bytes = self.bytes.clone();
        if model.entries() > 256 {
            bytes[start + 2 * texel] = (index % 256) as u8;
            bytes[start + 2 * texel + 1] = u8::try_from(index / 256).ok()?;
        } else {
            bytes[start + texel] = u8::try_from(index).ok()?;
        }
        Some(bytes)
    }
}
