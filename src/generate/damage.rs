//! One fault at a time.
//!
//! A damage is a named edit of a file that was in order. Some make a file that must be refused, some a file that goes
//! beyond the letter; which is which stands with the cases, not here.

#![allow(
    clippy::cast_possible_wrap,
    reason = "planes are at most 18, and streams are in memory"
)]

use std::ops::Range;

use super::Written;
use super::scene::{Compressed, Model};
use crate::codec::{jpeg, jpeg_ls};
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
    damage("version-1.0", "2.1/1", "the version is 1.0", |file, _| {
        file.replace("version", 0, b"PTM_1.0")
    }),
    damage(
        "version-of-three-parts",
        "2.1/1",
        "the version is 1.2.1",
        |file, _| file.replace("version", 0, b"PTM_1.2.1"),
    ),
    damage(
        "version-with-a-letter",
        "2.1/1",
        "a letter follows the version",
        |file, _| file.replace("version", 0, b"PTM_1.2a"),
    ),
    damage(
        "version-without-its-part",
        "2.1/1",
        "the version is 1",
        |file, _| file.replace("version", 0, b"PTM_1"),
    ),
    damage(
        "version-behind-a-letter",
        "2.1/1",
        "a letter stands before the version",
        |file, _| file.replace("version", 0, b"XPTM_1.2"),
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
    damage(
        "format-with-a-letter-behind",
        "2.2/1",
        "a letter follows the name of the format",
        |file, model| file.replace("format", 0, format!("{}A", model.format.name()).as_bytes()),
    ),
    damage(
        "format-with-a-word-behind",
        "2.2/1",
        "_2 follows the name of the format",
        |file, model| file.replace("format", 0, format!("{}_2", model.format.name()).as_bytes()),
    ),
    damage(
        "format-behind-a-letter",
        "2.2/1",
        "a letter stands before the name of the format",
        |file, model| file.replace("format", 0, format!("X{}", model.format.name()).as_bytes()),
    ),
    damage(
        "format-without-its-last-letter",
        "2.2/1",
        "the name of the format lacks its last letter",
        |file, model| {
            let name = model.format.name();
            file.replace("format", 0, &name.as_bytes()[..name.len() - 1])
        },
    ),
    damage(
        "format-without-its-beginning",
        "2.2/1",
        "the name of the format lacks PTM_FORMAT_",
        |file, model| {
            let name = model.format.name().trim_start_matches("PTM_FORMAT_");
            file.replace("format", 0, name.as_bytes())
        },
    ),
    damage(
        "format-in-mixed-case",
        "2.2/1",
        "the name of the format is PTM_Format_ and so on",
        |file, model| {
            let name = model.format.name().replace("FORMAT", "Format");
            file.replace("format", 0, name.as_bytes())
        },
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
        "width-fraction",
        "2.3/1",
        "the width has a fraction",
        |file, model| file.replace("width", 0, format!("{}.5", model.size.width).as_bytes()),
    ),
    damage(
        "width-double-zero",
        "2.3/3",
        "the width is 00",
        |file, _| file.replace("width", 0, b"00"),
    ),
    damage(
        "height-with-a-letter",
        "2.3/1",
        "a letter follows the height's digits",
        |file, model| file.replace("height", 0, format!("{}x", model.size.height).as_bytes()),
    ),
    damage(
        "height-hexadecimal",
        "2.3/1",
        "the height is hexadecimal",
        |file, model| file.replace("height", 0, format!("0x{:x}", model.size.height).as_bytes()),
    ),
    damage(
        "height-beyond-32-bits",
        "2.3/3",
        "the height exceeds 32 bits",
        |file, model| {
            file.replace(
                "height",
                0,
                (u64::from(model.size.height) + (1 << 32))
                    .to_string()
                    .as_bytes(),
            )
        },
    ),
    damage(
        "height-missing",
        "2.3/1",
        "the height is missing",
        |file, _| file.remove_line("height"),
    ),
    damage(
        "width-with-a-plus-sign",
        "2.3/1",
        "the width has a plus sign",
        |file, model| file.replace("width", 0, format!("+{}", model.size.width).as_bytes()),
    ),
    damage(
        "height-with-a-point",
        "2.3/1",
        "the height has a point and a zero",
        |file, model| file.replace("height", 0, format!("{}.0", model.size.height).as_bytes()),
    ),
    damage(
        "size-of-three-numbers",
        "2.3/1",
        "a third number follows width and height",
        |file, model| file.replace("height", 0, format!("{} 1", model.size.height).as_bytes()),
    ),
    damage(
        "size-and-a-word",
        "2.3/1",
        "a word follows the height",
        |file, model| {
            file.replace(
                "height",
                0,
                format!("{} texels", model.size.height).as_bytes(),
            )
        },
    ),
    // 2.4
    damage(
        "scale-seven",
        "2.4/2",
        "there are seven scales",
        |file, _| file.replace("scale", 5, b"0.75 1"),
    ),
    damage(
        "bias-seven",
        "2.4/2",
        "there are seven biases",
        |file, _| file.replace("bias", 5, b"3 0"),
    ),
    damage(
        "bias-and-a-word",
        "2.4/2",
        "a word follows the biases",
        |file, _| file.replace("bias", 5, b"3 bias"),
    ),
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
        "bias-letter-behind",
        "2.4/4",
        "a letter follows the last bias",
        |file, _| file.replace("bias", 5, b"3b"),
    ),
    damage(
        "bias-hexadecimal",
        "2.4/4",
        "a bias is hexadecimal",
        |file, _| file.replace("bias", 2, b"0x10"),
    ),
    damage("bias-inf", "2.4/4", "the last bias is inf", |file, _| {
        file.replace("bias", 5, b"inf")
    }),
    damage(
        "bias-overflows",
        "2.4/4",
        "a bias is beyond every float",
        |file, _| file.replace("bias", 2, b"1e400"),
    ),
    damage(
        "bias-underscore",
        "2.4/4",
        "a bias has an underscore",
        |file, _| file.replace("bias", 0, b"1_28"),
    ),
    damage(
        "last-bias-fraction",
        "2.4/4",
        "the last bias is 3.5",
        |file, _| file.replace("bias", 5, b"3.5"),
    ),
    damage(
        "bias-missing",
        "2.4/2",
        "there are five biases",
        |file, _| file.remove("bias", 5),
    ),
    damage(
        "first-scale-letter-behind",
        "2.4/3",
        "a letter follows the first scale",
        |file, _| file.replace("scale", 0, b"0.5f"),
    ),
    damage(
        "scale-underscore",
        "2.4/3",
        "a scale has an underscore",
        |file, _| file.replace("scale", 0, b"1_0"),
    ),
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
        "entries-with-a-letter",
        "2.5/2",
        "a letter follows the number of entries",
        |file, model| file.replace("count", 0, format!("{}x", model.entries()).as_bytes()),
    ),
    damage(
        "entries-fraction",
        "2.5/2",
        "the number of entries has a fraction",
        |file, model| file.replace("count", 0, format!("{}.5", model.entries()).as_bytes()),
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
        "matrix-letter-behind",
        "2.6/2",
        "a letter follows a matrix element",
        |file, _| file.replace("matrix", 0, b"1f"),
    ),
    damage(
        "matrix-inf",
        "2.6/2",
        "a matrix element is inf",
        |file, _| file.replace("matrix", 10, b"inf"),
    ),
    damage(
        "matrix-overflows",
        "2.6/2",
        "a matrix element is beyond every float",
        |file, _| file.replace("matrix", 5, b"1e400"),
    ),
    damage(
        "matrix-decimal-comma",
        "2.6/2",
        "a matrix element has a decimal comma",
        |file, _| file.replace("matrix", 0, b"0,5"),
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
        "two-bytes-short",
        "2.7/3",
        "the last two bytes are missing",
        |file, _| Some(file.bytes[..file.bytes.len() - 2].to_vec()),
    ),
    damage(
        "last-texel-missing",
        "2.7/3",
        "the last texel is missing",
        |file, model| {
            let (_, last) = file.last_texel(model)?;
            Some(file.bytes[..file.bytes.len() - last].to_vec())
        },
    ),
    damage(
        "last-row-missing",
        "2.7/3",
        "the last row is missing",
        |file, model| {
            let (row, _) = file.last_texel(model)?;
            Some(file.bytes[..file.bytes.len() - row].to_vec())
        },
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
        "index-in-the-middle-past-the-last-entry",
        "2.8/1",
        "an index in the middle equals the number of entries",
        |file, model| file.set_index(model, model.indices.len() / 2, model.entries()),
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
    // 2.9
    damage(
        "no-planes",
        "2.9.8/1",
        "nothing follows the lists",
        |file, _| file.cut_at("plane", 0),
    ),
    damage(
        "last-plane-missing",
        "2.9.8/1",
        "the last plane is missing",
        |file, model| file.cut_at("plane", model.planes() - 1),
    ),
    damage(
        "last-plane-cut",
        "2.9.8/1",
        "the last plane lacks its second half",
        |file, model| {
            let Range { start, end } = file.range("plane", model.planes() - 1)?;
            Some(file.bytes[..start.midpoint(end)].to_vec())
        },
    ),
    damage(
        "last-side-information-cut",
        "2.9.8/4",
        "the last record of side information lacks its value",
        |file, model| {
            let range = file.range("side information", model.planes() - 1)?;
            (!range.is_empty()).then(|| file.bytes[..range.end - 1].to_vec())
        },
    ),
    damage(
        "header-ends-in-references",
        "2.9/3",
        "the file ends within the references",
        |file, _| file.cut_at("references", 3),
    ),
    // 2.9.1
    damage(
        "parameter-missing",
        "2.9.1/1",
        "the parameter is missing",
        |file, _| file.remove_line("parameter"),
    ),
    damage("parameter-0", "2.9.1/1", "the parameter is 0", |file, _| {
        file.replace("parameter", 0, b"0")
    }),
    damage("parameter-3", "2.9.1/1", "the parameter is 3", |file, _| {
        file.replace("parameter", 0, b"3")
    }),
    damage(
        "parameter-19",
        "2.9.1/2",
        "the parameter is 19",
        |file, _| file.replace("parameter", 0, b"19"),
    ),
    damage(
        "parameter-101",
        "2.9.1/2",
        "the parameter is 101",
        |file, _| file.replace("parameter", 0, b"101"),
    ),
    damage(
        "parameter-300",
        "2.9.1/1",
        "the parameter is 300",
        |file, _| file.replace("parameter", 0, b"300"),
    ),
    damage(
        "parameter-negative",
        "2.9.1/1",
        "the parameter is -1",
        |file, _| file.replace("parameter", 0, b"-1"),
    ),
    damage(
        "parameter-fraction",
        "2.9.1/1",
        "the parameter is 75.0",
        |file, _| file.replace("parameter", 0, b"75.0"),
    ),
    // 2.9.2
    damage(
        "transform-4",
        "2.9.2/2",
        "a transform has a bit that means nothing",
        |file, _| file.replace("transforms", 1, b"4"),
    ),
    damage(
        "transform-5",
        "2.9.2/2",
        "a transform has bit 1 and one that means nothing",
        |file, _| file.replace("transforms", 1, b"5"),
    ),
    damage(
        "transform-256",
        "2.9.2/2",
        "a transform is 256, 0 for whoever keeps eight bits",
        |file, _| file.replace("transforms", 1, b"256"),
    ),
    damage(
        "transform-negative",
        "2.9.2/2",
        "a transform is -1",
        |file, _| file.replace("transforms", 1, b"-1"),
    ),
    damage(
        "transform-no-number",
        "2.9/3",
        "a transform is a word",
        |file, _| file.replace("transforms", 1, b"x"),
    ),
    damage(
        "transform-missing",
        "2.9/3",
        "a transform is missing",
        |file, _| file.remove("transforms", 2),
    ),
    // 2.9.3
    damage(
        "motion-x-missing",
        "2.9/3",
        "a vector lacks its x",
        |file, _| file.remove("motion x", 2),
    ),
    damage(
        "motion-y-missing",
        "2.9/3",
        "a vector lacks its y",
        |file, _| file.remove("motion y", 2),
    ),
    damage(
        "motion-y-line-missing",
        "2.9/3",
        "the second half of the vectors is missing",
        |file, _| file.remove_line("motion y"),
    ),
    damage(
        "motion-no-number",
        "2.9/3",
        "a vector is a word",
        |file, _| file.replace("motion x", 2, b"right"),
    ),
    // 2.9.4
    damage("order-missing", "2.9/3", "a rank is missing", |file, _| {
        file.remove("order", 2)
    }),
    damage("order-no-number", "2.9/3", "a rank is a word", |file, _| {
        file.replace("order", 2, b"second")
    }),
    damage(
        "rank-of-the-reference",
        "2.9.4/2",
        "a plane has the rank of its reference",
        |file, model| {
            let (plane, reference) = model.compressed()?.predicted()?;
            file.set_number("order", plane, model.compressed()?.plan.order[reference])
        },
    ),
    damage(
        "rank-below-the-reference",
        "2.9.4/2",
        "a plane and its reference have exchanged their ranks",
        |file, model| {
            let (plane, reference) = model.compressed()?.predicted()?;
            let order = &model.compressed()?.plan.order;
            let (first, second) = (order[plane].to_string(), order[reference].to_string());
            let mut edits = [
                ("order", plane, second.as_bytes()),
                ("order", reference, first.as_bytes()),
            ];
            edits.sort_by_key(|&(_, nth, _)| nth);
            file.replace_all(&edits)
        },
    ),
    damage(
        "plane-0-comes-late",
        "2.9.4/2",
        "a plane is predicted from plane 0, which has a larger rank",
        |file, model| {
            let plan = &model.compressed()?.plan;
            let plane = (1..model.planes()).find(|&plane| plan.reference(plane) == Some(0))?;
            let [late, early] = [plane, 0].map(|plane| plan.order[plane].to_string());
            file.replace_all(&[
                ("order", 0, late.as_bytes()),
                ("order", plane, early.as_bytes()),
            ])
        },
    ),
    // 2.9.5
    damage(
        "references-missing",
        "2.9/3",
        "a reference is missing",
        |file, _| file.remove("references", 2),
    ),
    damage(
        "references-no-number",
        "2.9/3",
        "a reference is a word",
        |file, _| file.replace("references", 2, b"none"),
    ),
    damage(
        "refers-to-itself",
        "2.9.4/2",
        "a plane is its own reference",
        |file, model| {
            let (plane, _) = model.compressed()?.predicted()?;
            file.set_number("references", plane, plane as i64)
        },
    ),
    damage(
        "refers-in-a-cycle",
        "2.9.4/2",
        "two planes are predicted from each other",
        |file, model| {
            let (plane, reference) = model.compressed()?.predicted()?;
            file.set_number("references", reference, plane as i64)
        },
    ),
    damage(
        "intra-refers-to-itself",
        "2.9.4/2",
        "the plane of rank 0 is its own reference",
        |file, model| {
            let plane = *model.compressed()?.plan.in_order().first()?;
            file.set_number("references", plane, plane as i64)
        },
    ),
    damage(
        "refers-past-the-last-plane",
        "2.9.5/1",
        "a reference is the number of planes",
        |file, model| file.set_number("references", model.planes() - 1, model.planes() as i64),
    ),
    damage(
        "refers-far-past-the-last-plane",
        "2.9.5/1",
        "a reference is 2³¹ − 1",
        |file, model| file.set_number("references", model.planes() - 1, i64::from(i32::MAX)),
    ),
    damage(
        "refers-to-a-plane-of-another-format",
        "2.9.5/1",
        "a reference is 12, which only 18 planes have",
        |file, model| {
            if model.planes() == 9 {
                file.set_number("references", 8, 12)
            } else {
                None
            }
        },
    ),
    // 2.9.6
    damage(
        "compressed-size-missing",
        "2.9/3",
        "a compressed size is missing",
        |file, _| file.remove("compressed sizes", 2),
    ),
    damage(
        "compressed-size-no-number",
        "2.9/3",
        "a compressed size is a word",
        |file, _| file.replace("compressed sizes", 2, b"many"),
    ),
    damage(
        "compressed-size-one-more",
        "2.9.6/1",
        "a compressed size is one more than the plane has",
        |file, model| file.set_number("compressed sizes", 0, model.stream_size(0)? + 1),
    ),
    damage(
        "compressed-size-one-less",
        "2.9.6/1",
        "a compressed size is one less than the plane has",
        |file, model| file.set_number("compressed sizes", 0, model.stream_size(0)? - 1),
    ),
    damage(
        "last-compressed-size-one-more",
        "2.9.6/1",
        "the last compressed size is one more than the file has",
        |file, model| {
            file.set_number(
                "compressed sizes",
                model.planes() - 1,
                model.stream_size(model.planes() - 1)? + 1,
            )
        },
    ),
    damage(
        "lists-with-leading-zeros",
        "2.9/3",
        "compressed sizes and ranks have leading zeros",
        |file, model| {
            let plan = &model.compressed()?.plan;
            let spelled = |nth: usize| {
                let size = model.stream_size(nth).unwrap_or_default();
                (format!("0{}", plan.order[nth]), format!("00{size}"))
            };
            let texts: Vec<(String, String)> = (0..model.planes()).map(spelled).collect();
            let ranks = texts.iter().enumerate();
            let ranks = ranks.map(|(nth, (rank, _))| ("order", nth, rank.as_bytes()));
            let sizes = texts.iter().enumerate();
            let sizes = sizes.map(|(nth, (_, size))| ("compressed sizes", nth, size.as_bytes()));
            file.replace_all(&ranks.chain(sizes).collect::<Vec<_>>())
        },
    ),
    damage(
        "compressed-size-zero",
        "2.9.6/1",
        "a compressed size is 0",
        |file, _| file.replace("compressed sizes", 1, b"0"),
    ),
    damage(
        "compressed-size-negative",
        "2.9.6/1",
        "a compressed size is negative",
        |file, model| file.set_number("compressed sizes", 1, -model.stream_size(1)?),
    ),
    damage(
        "compressed-size-near-31-bits",
        "2.9.6/1",
        "a compressed size is 2³¹ − 1",
        |file, _| file.set_number("compressed sizes", 1, i64::from(i32::MAX)),
    ),
    damage(
        "compressed-sizes-beyond-31-bits-together",
        "2.9.6/1",
        "compressed sizes are 2³¹ − 1 each",
        |file, model| {
            let edits: Vec<_> = (0..model.planes())
                .map(|plane| ("compressed sizes", plane, &b"2147483647"[..]))
                .collect();
            file.replace_all(&edits)
        },
    ),
    damage(
        "compressed-size-beyond-32-bits",
        "2.9.6/1",
        "a compressed size is 2³² more than the plane has",
        |file, model| file.set_number("compressed sizes", 1, model.stream_size(1)? + (1 << 32)),
    ),
    damage(
        "compressed-size-near-63-bits",
        "2.9.6/1",
        "a compressed size is 2⁶³ − 1",
        |file, _| file.set_number("compressed sizes", 1, i64::MAX),
    ),
    damage(
        "compressed-size-beyond-64-bits",
        "2.9.6/1",
        "a compressed size is 2⁶⁴ more than the plane has",
        |file, model| {
            file.replace(
                "compressed sizes",
                1,
                (i128::from(model.stream_size(1)?) + (1 << 64))
                    .to_string()
                    .as_bytes(),
            )
        },
    ),
    // 2.9.7
    damage(
        "side-size-missing",
        "2.9/3",
        "a side size is missing",
        |file, _| file.remove("side sizes", 2),
    ),
    damage(
        "side-size-negative",
        "2.9.7/1",
        "a side size is negative",
        |file, _| file.replace("side sizes", 1, b"-5"),
    ),
    damage(
        "side-size-beyond-the-file",
        "2.9.7/1",
        "a side size is beyond the file",
        |file, _| file.replace("side sizes", 1, b"5000000"),
    ),
    damage(
        "side-size-near-31-bits",
        "2.9.7/1",
        "a side size is 2³¹ − 3",
        |file, _| file.replace("side sizes", 1, b"2147483645"),
    ),
    damage(
        "side-size-beyond-32-bits",
        "2.9.7/1",
        "a side size is 2³² more than there is",
        |file, model| {
            let size = model.compressed()?.planes[1].side_information().len() as i64;
            file.set_number("side sizes", 1, size + (1 << 32))
        },
    ),
    damage(
        "side-size-4",
        "2.9.8/5",
        "side information of four bytes",
        |file, model| file.with_side_information(model, model.planes() - 1, &[0, 0, 0, 0]),
    ),
    damage(
        "side-size-1",
        "2.9.8/5",
        "side information of one byte",
        |file, model| file.with_side_information(model, 0, &[7]),
    ),
    damage(
        "side-size-6",
        "2.9.8/5",
        "a record of side information and a byte of another",
        |file, model| file.with_side_information(model, 0, &[0, 0, 0, 0, 77, 0]),
    ),
    // 2.9.8, side information
    damage(
        "position-past-the-last-texel",
        "2.9.8/6",
        "a record is of position width · height",
        |file, model| {
            let position = u32::try_from(model.size.texels()).ok()?;
            file.with_side_information(model, 0, &[&position.to_be_bytes()[..], &[77]].concat())
        },
    ),
    damage(
        "position-near-31-bits",
        "2.9.8/6",
        "a record is of position 2³¹ − 1",
        |file, model| file.with_side_information(model, 0, &[0x7f, 0xff, 0xff, 0xff, 77]),
    ),
    damage(
        "position-with-the-highest-bit",
        "2.9.8/6",
        "a record is of position 2³¹",
        |file, model| file.with_side_information(model, 0, &[0x80, 0, 0, 0, 77]),
    ),
    damage(
        "position-near-32-bits",
        "2.9.8/6",
        "a record is of position 2³² − 1",
        |file, model| {
            file.with_side_information(model, model.planes() - 1, &[0xff, 0xff, 0xff, 0xff, 77])
        },
    ),
    // 2.9.8, streams
    damage(
        "stream-empty",
        "2.9.8/3",
        "a plane is empty",
        |file, model| file.with_stream(model, 1, &[]),
    ),
    damage(
        "stream-without-soi",
        "2.9.8/3",
        "a stream begins with 00 00",
        |file, model| file.with_stream(model, 1, &[&[0, 0], &model.stream(1)?[2..]].concat()),
    ),
    damage(
        "stream-of-a-png",
        "2.9.8/3",
        "a plane is the beginning of a PNG",
        |file, model| {
            file.with_stream(
                model,
                1,
                b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x08\0\0\0\x08\x08\0\0\0\0",
            )
        },
    ),
    damage(
        "stream-without-markers",
        "2.9.8/3",
        "a plane is not compressed",
        |file, model| file.with_stream(model, 1, &vec![128; model.size.texels()]),
    ),
    damage(
        "stream-wider",
        "2.9.8/3",
        "a stream is one texel wider than the map",
        |file, model| file.with_stream(model, 1, &gray(model, model.is_jpeg(), 1, 0)),
    ),
    damage(
        "stream-higher",
        "2.9.8/3",
        "a stream is one texel higher than the map",
        |file, model| file.with_stream(model, 1, &gray(model, model.is_jpeg(), 0, 1)),
    ),
    damage(
        "stream-of-exchanged-sides",
        "2.9.8/3",
        "a stream has the map's width as its height",
        |file, model| {
            let turn = i64::from(model.size.height) - i64::from(model.size.width);
            if turn == 0 {
                None
            } else {
                file.with_stream(model, 1, &gray(model, model.is_jpeg(), turn, -turn))
            }
        },
    ),
    damage(
        "stream-of-the-other-codec",
        "2.9.8/3",
        "a stream is of JPEG in a JPEG-LS file, or of JPEG-LS in a JPEG file",
        |file, model| file.with_stream(model, 1, &gray(model, !model.is_jpeg(), 0, 0)),
    ),
    damage(
        "stream-of-three-components",
        "2.9.8/3",
        "a stream has three components",
        |file, model| file.with_stream(model, 1, &three_components(model)?),
    ),
    damage(
        "all-streams-of-three-components",
        "2.9.8/3",
        "every stream has three components",
        |file, model| {
            let stream = three_components(model)?;
            file.with_streams(model, |_, _| stream.clone())
        },
    ),
    damage(
        "stream-missing-eoi",
        "2.9.8/3",
        "a stream lacks EOI",
        |file, model| {
            let stream = model.stream(1)?;
            file.with_stream(model, 1, &stream[..stream.len() - 2])
        },
    ),
    damage(
        "stream-cut",
        "2.9.8/3",
        "a stream lacks the end of its data",
        |file, model| {
            let stream = model.stream(1)?;
            file.with_stream(model, 1, &stream[..stream.len() - 4])
        },
    ),
    damage(
        "stream-ends-in-its-header",
        "2.9.8/3",
        "a stream ends before its data",
        |file, model| {
            let stream = model.stream(1)?;
            file.with_stream(model, 1, &stream[..find(stream, 0xda)?])
        },
    ),
    damage(
        "stream-data-flipped",
        "2.9.8/3",
        "bits of a stream's data are flipped",
        |file, model| {
            let mut stream = model.stream(1)?.to_vec();
            let at = stream.len() - 4;
            stream[at] ^= 0x5a;
            file.with_stream(model, 1, &stream)
        },
    ),
    damage(
        "stream-data-of-zeros",
        "2.9.8/3",
        "all of a stream's data is zeros",
        |file, model| {
            let mut stream = model.stream(1)?.to_vec();
            let (from, to) = (find(&stream, 0xda)? + 10, stream.len() - 2);
            stream[from..to].fill(0);
            file.with_stream(model, 1, &stream)
        },
    ),
    damage(
        "stream-with-another-marker-in-its-data",
        "2.9.8/3",
        "a marker stands in a stream's data",
        |file, model| {
            let mut stream = model.stream(1)?.to_vec();
            let at = stream.len() - 4;
            stream.splice(at..at, [0xff, 0xd5]);
            file.with_stream(model, 1, &stream)
        },
    ),
    damage(
        "stream-says-progressive",
        "2.9.8/3",
        "the frame of a stream is marked progressive and is not",
        |file, model| {
            if !model.is_jpeg() {
                return None;
            }
            let mut stream = model.stream(1)?.to_vec();
            let at = find(&stream, 0xc0)?;
            stream[at + 1] = 0xc2;
            file.with_stream(model, 1, &stream)
        },
    ),
    damage(
        "stream-of-twelve-bits",
        "2.9.8/3",
        "the frame of a stream says twelve bits",
        |file, model| {
            let mut stream = model.stream(1)?.to_vec();
            let at = find(&stream, 0xc0).or_else(|| find(&stream, 0xf7))?;
            stream[at + 4] = 12;
            file.with_stream(model, 1, &stream)
        },
    ),
    damage(
        "stream-of-no-rows",
        "2.9.8/3",
        "the frame of a stream has height 0, which is to be told later and is not",
        |file, model| {
            let mut stream = model.stream(1)?.to_vec();
            let at = find(&stream, 0xc0).or_else(|| find(&stream, 0xf7))?;
            stream[at + 5..at + 7].fill(0);
            file.with_stream(model, 1, &stream)
        },
    ),
    Damage {
        picture: gray_in_plane_one,
        ..damage(
            "stream-progressive",
            "2.9.8/3",
            "a stream is progressive",
            |file, model| file.with_stream(model, 1, &outside(model, PROGRESSIVE)?),
        )
    },
    Damage {
        picture: gray_in_plane_one,
        ..damage(
            "stream-arithmetic",
            "2.9.8/3",
            "a stream is coded arithmetically",
            |file, model| file.with_stream(model, 1, &outside(model, ARITHMETIC)?),
        )
    },
    damage(
        "stream-of-twelve-bits-throughout",
        "2.9.8/3",
        "a stream has samples of twelve bits",
        |file, model| file.with_stream(model, 1, &outside(model, TWELVE_BITS)?),
    ),
    damage(
        "stream-adobe",
        "2.9.8/3",
        "every stream has the segment of Adobe's writers",
        |file, model| {
            // APP14: name, version 100, two flag words, no color transform.
            file.with_streams(model, |_, stream| {
                behind_soi(stream, b"\xff\xee\0\x0eAdobe\0\x64\0\0\0\0\0")
            })
        },
    ),
    damage(
        "stream-segment-of-no-length",
        "2.9.8/3",
        "a segment of a stream has length 0, less than the length itself takes",
        |file, model| {
            let stream = behind_soi(model.stream(1)?, b"\xff\xfe\0\0");
            file.with_stream(model, 1, &stream)
        },
    ),
    damage(
        "stream-segment-past-the-end",
        "2.9.8/3",
        "a segment of a stream is longer than the stream",
        |file, model| {
            let stream = behind_soi(model.stream(1)?, b"\xff\xfe\xff\xff");
            file.with_stream(model, 1, &stream)
        },
    ),
    damage(
        "stream-of-too-many-codes",
        "2.9.8/3",
        "a Huffman table of a stream has 255 codes more than its segment holds",
        |file, model| {
            let mut stream = model.stream(1)?.to_vec();
            let at = find(&stream, 0xc4)?;
            // Marker, length, class and number; then how many codes of 1 to 16 bits.
            stream[at + 5 + 15] = 255;
            file.with_stream(model, 1, &stream)
        },
    ),
    damage(
        "stream-of-table-15",
        "2.9.8/3",
        "a quantisation table of a stream has number 15, where there are four",
        |file, model| {
            let mut stream = model.stream(1)?.to_vec();
            let at = find(&stream, 0xdb)?;
            stream[at + 4] = 15;
            file.with_stream(model, 1, &stream)
        },
    ),
    damage(
        "stream-of-near-255",
        "2.9.8/3",
        "a scan of JPEG-LS says NEAR 255, twice the most there is",
        |file, model| {
            let mut stream = model.stream(1)?.to_vec();
            let at = find(&stream, 0xda)?;
            // Marker, length, one component, its number and its table; then NEAR.
            *stream.get_mut(at + 7).filter(|_| !model.is_jpeg())? = 255;
            file.with_stream(model, 1, &stream)
        },
    ),
    damage(
        "stream-without-tables",
        "2.9.8/3",
        "a stream lacks its first table",
        |file, model| {
            let mut stream = model.stream(1)?.to_vec();
            let at = find(&stream, 0xc4)?;
            let length = usize::from(stream[at + 2]) * 256 + usize::from(stream[at + 3]);
            stream.drain(at..at + 2 + length);
            file.with_stream(model, 1, &stream)
        },
    ),
    damage(
        "stream-comments",
        "2.9.8/3",
        "every stream has a comment",
        |file, model| {
            // COM of T.81 B.2.4.5, with a marker's bytes in its text.
            file.with_streams(model, |_, stream| {
                behind_soi(stream, b"\xff\xfe\0\x09made\xff\xd9\x00")
            })
        },
    ),
    damage(
        "stream-application-data",
        "2.9.8/3",
        "every stream has a segment of application data",
        |file, model| {
            file.with_streams(model, |_, stream| behind_soi(stream, b"\xff\xe5\0\x06data"))
        },
    ),
    damage(
        "stream-fill-bytes",
        "2.9.8/3",
        "fill bytes stand before a marker of every stream",
        |file, model| {
            // T.81 B.1.1.2.
            file.with_streams(model, |_, stream| behind_soi(stream, &[0xff, 0xff]))
        },
    ),
    damage(
        "stream-bytes-behind",
        "2.9.8/3",
        "two bytes stand behind EOI in every stream",
        |file, model| file.with_streams(model, |_, stream| [stream, &[0, 0]].concat()),
    ),
    damage(
        "stream-restart-interval-unused",
        "2.9.8/3",
        "every stream has a restart interval longer than its data",
        |file, model| {
            file.with_streams(model, |_, stream| {
                let at = find(stream, 0xda).unwrap_or(2);
                [
                    &stream[..at],
                    &[0xff, 0xdd, 0, 4, 0xff, 0xff],
                    &stream[at..],
                ]
                .concat()
            })
        },
    ),
];

/// A stream with more bytes behind its first marker.
fn behind_soi(stream: &[u8], bytes: &[u8]) -> Vec<u8> {
    [&stream[..2], bytes, &stream[2..]].concat()
}

/// Where the marker of this code stands, before the data.
fn find(stream: &[u8], code: u8) -> Option<usize> {
    let mut at = 2;
    while at + 4 <= stream.len() && stream[at + 1] != code {
        if stream[at + 1] == 0xda {
            return None;
        }
        at += 2 + usize::from(stream[at + 2]) * 256 + usize::from(stream[at + 3]);
    }
    (at + 4 <= stream.len()).then_some(at)
}

/// One component of 9×6 samples of 8 bits, all 128, by the progressive process: a scan of the DC coefficient, one of all
/// others. Like the next two without quantisation (a table of ones) and as `scripts/odd_streams.py` makes it.
const PROGRESSIVE: &[&[u8]] = &[
    b"\xff\xc2\0\x0b\x08\0\x06\0\x09\x01\x01\x11\0",
    b"\xff\xc4\0\x14\0\x01\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0",
    b"\xff\xda\0\x08\x01\x01\0\0\0\0\x3f",
    b"\xff\xc4\0\x14\x10\x01\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0",
    b"\xff\xda\0\x08\x01\x01\0\x01\x3f\0\x3f",
];

/// The same by the sequential process with arithmetic coding.
const ARITHMETIC: &[&[u8]] = &[
    b"\xff\xc9\0\x0b\x08\0\x06\0\x09\x01\x01\x11\0",
    b"\xff\xda\0\x08\x01\x01\0\0\x3f\0\x3f\0\x40",
];

/// The same with samples of 12 bits, all 2048.
const TWELVE_BITS: &[&[u8]] = &[
    b"\xff\xc1\0\x0b\x0c\0\x06\0\x09\x01\x01\x11\0",
    b"\xff\xc4\0\x14\0\x01\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0",
    b"\xff\xc4\0\x14\x10\x01\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0",
    b"\xff\xda\0\x08\x01\x01\0\0\x3f\0\x0f",
];

/// The stream of these segments, for a JPEG map of 9×6 texels and no other.
fn outside(model: &Model, segments: &[&[u8]]) -> Option<Vec<u8>> {
    let fits = model.is_jpeg() && (model.size.width, model.size.height) == (9, 6);
    let table = [&b"\xff\xdb\0\x43\0"[..], &[1; 64]].concat();
    let stream = [b"\xff\xd8", &table[..], &segments.concat(), b"\xff\xd9"].concat();
    fits.then_some(stream)
}

/// The map whose plane 1 is 128 everywhere.
fn gray_in_plane_one(model: &Model) -> Option<Model> {
    let mut model = model.clone();
    let channels = model.format.channels();
    for sample in model.samples.iter_mut().skip(1).step_by(channels) {
        *sample = 128;
    }
    Some(model)
}

/// A plane of 128, by so much wider and higher than the map.
fn gray(model: &Model, jpeg: bool, wider: i64, higher: i64) -> Vec<u8> {
    let width = (i64::from(model.size.width) + wider) as u32;
    let height = (i64::from(model.size.height) + higher) as u32;
    let samples = vec![128; width as usize * height as usize];
    if jpeg {
        jpeg::encode(&samples, width, height, &jpeg::Options::new(75)).stream
    } else {
        jpeg_ls::encode(
            &samples,
            width,
            height,
            &jpeg_ls::Options {
                near: 0,
                presets: None,
            },
        )
        .stream
    }
}

/// A gray picture of the map's size with three components of full size.
fn three_components(model: &Model) -> Option<Vec<u8>> {
    let one = gray(model, model.is_jpeg(), 0, 0);
    let (frame, scan) = (
        find(&one, 0xc0).or_else(|| find(&one, 0xf7))?,
        find(&one, 0xda)?,
    );
    let (end, table) = (one.len() - 2, one[frame + 12]);
    // The frame header grows by three bytes for each component: name, sampling factors, table.
    let header = [
        &[one[frame], one[frame + 1], 0, 17],
        &one[frame + 4..frame + 9],
        &[3],
        &[1, 0x11, table],
        &[2, 0x11, table],
        &[3, 0x11, table],
    ]
    .concat();
    let before = [
        &one[..frame],
        &header,
        &one[frame + 2 + usize::from(one[frame + 3])..scan],
    ]
    .concat();
    let data = |component: u8| {
        let mut data = one[scan..end].to_vec();
        data[5] = component;
        data
    };
    // A scan for each, which both standards allow.
    Some([before, data(1), data(2), data(3), one[end..].to_vec()].concat())
}

/// What damages ask of a compressed map.
impl Model {
    fn compressed(&self) -> Option<&Compressed> {
        self.compressed.as_ref()
    }

    fn planes(&self) -> usize {
        self.format.channels()
    }

    fn is_jpeg(&self) -> bool {
        matches!(self.format, Format::JpegRgb | Format::JpegLrgb)
    }

    fn stream(&self, plane: usize) -> Option<&[u8]> {
        Some(&self.compressed()?.planes[plane].stream)
    }

    fn stream_size(&self, plane: usize) -> Option<i64> {
        Some(self.stream(plane)?.len() as i64)
    }
}

impl Compressed {
    /// The last predicted plane by rank, and its reference.
    fn predicted(&self) -> Option<(usize, usize)> {
        self.plan
            .in_order()
            .into_iter()
            .rev()
            .find_map(|plane| Some((plane, self.plan.reference(plane)?)))
    }
}

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

    fn set_number(&self, name: &str, nth: usize, number: i64) -> Option<Vec<u8>> {
        self.replace(name, nth, number.to_string().as_bytes())
    }

    /// With another stream for a plane, and its size to match.
    fn with_stream(&self, model: &Model, plane: usize, stream: &[u8]) -> Option<Vec<u8>> {
        self.with_streams(model, |i, old| {
            if i == plane {
                stream.to_vec()
            } else {
                old.to_vec()
            }
        })
    }

    /// With other streams, and their sizes to match.
    fn with_streams(
        &self,
        model: &Model,
        stream: impl Fn(usize, &[u8]) -> Vec<u8>,
    ) -> Option<Vec<u8>> {
        let planes = &model.compressed.as_ref()?.planes;
        let streams: Vec<Vec<u8>> = planes
            .iter()
            .enumerate()
            .map(|(i, plane)| stream(i, &plane.stream))
            .collect();
        let sizes: Vec<String> = streams
            .iter()
            .map(|stream| stream.len().to_string())
            .collect();
        let sizes = sizes
            .iter()
            .enumerate()
            .map(|(i, size)| ("compressed sizes", i, size.as_bytes()));
        let streams = streams
            .iter()
            .enumerate()
            .map(|(i, stream)| ("plane", i, &stream[..]));
        self.replace_all(&sizes.chain(streams).collect::<Vec<_>>())
    }

    /// With these bytes as all the side information of a plane, and their number to match.
    fn with_side_information(&self, model: &Model, plane: usize, bytes: &[u8]) -> Option<Vec<u8>> {
        model.compressed.as_ref()?;
        let size = bytes.len().to_string();
        self.replace_all(&[
            ("side sizes", plane, size.as_bytes()),
            ("side information", plane, bytes),
        ])
    }

    /// Bytes of the last row and of the last texel of the last block.
    fn last_texel(&self, model: &Model) -> Option<(usize, usize)> {
        let block = self.fields.last()?.range.len();
        let texel = block.checked_div(model.size.texels())?;
        Some((texel * model.size.width as usize, texel))
    }

    /// With another index for a texel, counted as stored.
    fn set_index(&self, model: &Model, texel: usize, index: usize) -> Option<Vec<u8>> {
        // In a full table every index is one.
        if index < model.entries() {
            return None;
        }
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
