//! What can be said of a file, so that files which a decoder treats alike can be described.
//!
//! Tables of words and predicates. How many bytes a file has is a trait at the sizes of buffers alone: size goes with everything else.

use std::sync::LazyLock;

use super::trait_list::Traits;
use crate::diagnose::witness::Witness;
use crate::generate::Recipe;
use crate::generate::plan::{Coding, Compression};
use crate::generate::planes::StoredPlane;
use crate::generate::spelling::{Count, Line, Lists};
use crate::protocol::frame::{Answer, View};
use crate::ptm::{Field, Format};

/// A file, taken apart for the predicates.
struct Facts<'a> {
    view: &'a View,
    format: Format,
    size: Option<(u32, u32)>,
    recipe: Option<&'a Recipe>,
    plan: Option<&'a Compression>,
    planes: Option<&'a [StoredPlane]>,
    /// The bytes of the header.
    header: usize,
    /// Everything after it.
    data: &'a [u8],
    longest_line: usize,
    /// The texts of scales, biases and matrix elements.
    numbers: [Vec<&'a str>; 3],
    largest_index: Option<u32>,
    /// Stored values, where the reference reads the file.
    samples: &'a [u8],
}

/// A trait.
pub(super) struct Trait {
    /// Completes "files …".
    pub says: String,
    /// Whether it is the view that was asked for, which is no property of the file.
    pub is_view: bool,
    /// The clause of what is spelled so, where it is one number of the header.
    pub clause: Option<&'static str>,
    holds: Box<dyn Fn(&Facts) -> bool + Send + Sync>,
}

/// A number that files have.
pub(super) struct Quantity {
    /// The clause that it is a number of.
    pub clause: &'static str,
    /// Completes "files …" after a number and "or more": "with 17 or more columns".
    pub words: [&'static str; 2],
    value: fn(&Facts) -> Option<f64>,
}

/// All traits, the formats first.
pub(super) static TRAITS: LazyLock<Vec<Trait>> = LazyLock::new(all_traits);

/// All that can be said of a file.
pub(super) fn traits<'w>(witness: &'w Witness) -> &'w Traits {
    witness.traits.get_or_init(|| {
        let facts = Facts::of(witness);
        Traits {
            has: TRAITS.iter().map(|one| (one.holds)(&facts)).collect(),
            quantities: QUANTITIES.iter().map(|one| (one.value)(&facts)).collect(),
        }
    })
}

impl<'a> Facts<'a> {
    fn of(witness: &'a Witness) -> Facts<'a> {
        let file = &witness.built.file;
        let payload = witness.payload().min(file.len());
        let (header, data) = file.split_at(payload);
        let texts = |clause: &str| -> Vec<&str> {
            let text = |field: &Field| std::str::from_utf8(&file[field.range.clone()]).ok();
            let of = witness
                .fields()
                .iter()
                .filter(|field| field.clause == clause);
            of.filter_map(text).collect()
        };
        let lines = header.split(|&byte| byte == b'\n').map(<[u8]>::len);
        let model = witness.model();
        let compressed = model.and_then(|model| model.compressed.as_ref());
        Facts {
            view: &witness.observation.view,
            format: witness.case.format(),
            size: match &witness.right {
                Answer::Decoded(frame) => Some((frame.width, frame.height)),
                _ => None,
            },
            recipe: witness.case.recipe(),
            plan: witness.case.compression(),
            planes: compressed.map(|compressed| &compressed.planes[..]),
            header: header.len(),
            data,
            longest_line: lines.max().unwrap_or_default(),
            numbers: [texts("2.4/3"), texts("2.4/4"), texts("2.6/2")],
            largest_index: model.and_then(|model| model.indices.iter().max().copied()),
            samples: witness
                .decoded()
                .as_ref()
                .map_or(&[], |ptm| &ptm.planes.samples),
        }
    }

    fn light(&self) -> Option<(f64, f64)> {
        match self.view {
            View::Rgb(light) => Some((light.lu, light.lv)),
            _ => None,
        }
    }

    fn is_lossy(&self) -> bool {
        self.format.is_jpeg()
    }

    fn spelled(&self, holds: impl Fn(&Recipe) -> bool) -> bool {
        self.recipe.is_some_and(holds)
    }

    fn planned(&self, holds: impl Fn(&Compression) -> bool) -> bool {
        self.plan.is_some_and(holds)
    }

    fn size(&self) -> Option<(u32, u32)> {
        self.size
    }

    fn sized(&self, holds: impl Fn(u32, u32) -> bool) -> bool {
        self.size()
            .is_some_and(|(width, height)| holds(width, height))
    }

    fn first(&self, holds: impl Fn(u8) -> bool) -> bool {
        self.data.first().is_some_and(|&byte| holds(byte))
    }

    fn largest(&self, list: usize) -> Option<f64> {
        let values = self.numbers[list].iter().map(|text| number(text));
        values.max_by(f64::total_cmp)
    }

    fn longest(&self, list: usize) -> Option<f64> {
        let lengths = self.numbers[list].iter().map(|text| text.len());
        lengths.max().map(|length| length as f64)
    }

    /// The motion vectors of predicted planes.
    fn vectors(&self) -> Vec<(i32, i32)> {
        let Some(plan) = self.plan.filter(|plan| plan.moves()) else {
            return Vec::new();
        };
        let at = |list: &[i32], plane: usize| list.get(plane).copied().unwrap_or_default();
        let predicted = (0..plan.order.len()).filter(|&plane| plan.reference(plane).is_some());
        predicted
            .map(|plane| (at(&plan.motion_x, plane), at(&plan.motion_y, plane)))
            .collect()
    }

    /// Whether planes that are predicted, or that are not, have side information.
    fn has_records(&self, predicted: bool) -> bool {
        let (Some(planes), Some(plan)) = (self.planes, self.plan) else {
            return false;
        };
        planes.iter().enumerate().any(|(plane, stored)| {
            !stored.records.is_empty() && plan.reference(plane).is_some() == predicted
        })
    }

    /// The restart markers of a plane, where it has any.
    fn markers(&self) -> Option<u32> {
        let interval = u32::from(self.plan?.stream.restart_interval);
        let (width, height) = self.size()?;
        let blocks = width.div_ceil(8) * height.div_ceil(8);
        (interval > 0 && self.recipe?.coding() == Coding::Jpeg).then(|| (blocks - 1) / interval)
    }

    fn records(&self) -> Option<usize> {
        let planes = self.planes?.iter();
        Some(planes.map(|plane| plane.records.len()).sum())
    }
}

/// The digits of an exponent.
fn exponent(text: &str) -> Option<&str> {
    let (_, digits) = text.split_once(['e', 'E'])?;
    Some(digits.trim_start_matches(['+', '-']))
}

/// The digits behind a decimal point.
fn fraction(text: &str) -> Option<&str> {
    let (_, rest) = text.split_once('.')?;
    let end = rest.find(|c: char| !c.is_ascii_digit());
    Some(&rest[..end.unwrap_or(rest.len())])
}

fn number(text: &str) -> f64 {
    text.parse().unwrap_or_default()
}

type Row = (&'static str, fn(&Facts) -> bool);

/// A trait and its opposite.
type Pair = (&'static str, &'static str, fn(&Facts) -> bool);

const OF_FORMAT: &[Pair] = &[
    ("with compressed planes", "without compressed planes", |f| {
        f.format.is_compressed()
    }),
    ("with JPEG planes", "", |f| f.is_lossy()),
    ("with JPEG-LS planes", "", |f| {
        f.format.is_compressed() && !f.is_lossy()
    }),
    ("with a lookup table", "without a lookup table", |f| {
        f.format.has_table()
    }),
    (
        "with three polynomials (RGB, JPEG_RGB, JPEGLS_RGB)",
        "",
        |f| f.format.channels() == 18,
    ),
    (
        "with one polynomial and a color (LRGB, tables, JPEG_LRGB, JPEGLS_LRGB)",
        "",
        |f| f.format.channels() == 9,
    ),
];

const OF_SPELLING: &[Pair] = &[
    (
        "whose width and height stand on two lines",
        "whose width and height stand on one line",
        |f| f.spelled(|recipe| recipe.spelling.size_on_two_lines),
    ),
    (
        "whose scales and biases stand on two lines",
        "whose scales and biases stand on one line",
        |f| f.spelled(|recipe| recipe.spelling.scale_bias_on_two_lines),
    ),
    (
        "with a space before the line feed of a header line",
        "without a space before any line feed of the header",
        |f| f.spelled(|recipe| !recipe.spelling.space_before_newline.is_empty()),
    ),
    ("with more than one space between two numbers", "", |f| {
        f.spelled(|recipe| recipe.spelling.gap > 1)
    }),
    ("with three spaces or more between two numbers", "", |f| {
        f.spelled(|recipe| recipe.spelling.gap > 2)
    }),
    (
        "with the number of entries written as \"256 N_LUT_ENTRIES\"",
        "",
        |f| f.format.has_table() && f.spelled(|recipe| recipe.spelling.count == Count::NumberWord),
    ),
    ("with the number of entries written as \"256\"", "", |f| {
        f.format.has_table() && f.spelled(|recipe| recipe.spelling.count == Count::Number)
    }),
    (
        "with the number of entries written as \"nentries 256\"",
        "",
        |f| f.format.has_table() && f.spelled(|recipe| recipe.spelling.count == Count::WordNumber),
    ),
    ("with a line feed after the table", "", |f| {
        f.format.has_table() && f.spelled(|recipe| recipe.spelling.newline_after_table)
    }),
    (
        "whose lists of 2.9 are split into lines unlike the real file's",
        "",
        |f| f.format.is_compressed() && f.spelled(|recipe| recipe.spelling.lists != Lists::Lines),
    ),
    ("whose matrix stands on several lines", "", |f| {
        f.format == Format::Lum && f.spelled(|recipe| recipe.spelling.matrix_line != 16)
    }),
];

const OF_BYTES: &[Row] = &[
    ("whose first byte after the header is white space", |f| {
        f.first(|byte| byte.is_ascii_whitespace() || byte == 0x0b)
    }),
    ("whose first byte after the header is a space", |f| {
        f.first(|byte| byte == b' ')
    }),
    ("whose first byte after the header is a line feed", |f| {
        f.first(|byte| byte == b'\n')
    }),
    (
        "whose first byte after the header is a carriage return",
        |f| f.first(|byte| byte == b'\r'),
    ),
    ("whose first byte after the header is a tab", |f| {
        f.first(|byte| byte == b'\t')
    }),
    (
        "whose first byte after the header is a tab or a carriage return",
        |f| f.first(|byte| matches!(byte, b'\t' | b'\r')),
    ),
    ("whose first byte after the header is zero", |f| {
        f.first(|byte| byte == 0)
    }),
    (
        "whose first byte after the header looks like part of a number",
        |f| f.first(|byte| byte.is_ascii_digit() || matches!(byte, b'-' | b'+' | b'.')),
    ),
    ("whose first byte after the header is a number sign", |f| {
        f.first(|byte| byte == b'#')
    }),
    ("with the bytes CR LF in the binary data", |f| {
        f.data.windows(2).any(|pair| pair == b"\r\n")
    }),
    ("with the byte 0x00 in the binary data", |f| {
        f.data.contains(&0)
    }),
    ("with the byte 0x0a in the binary data", |f| {
        f.data.contains(&0x0a)
    }),
    ("with the byte 0x0d in the binary data", |f| {
        f.data.contains(&0x0d)
    }),
    ("with the byte 0x1a in the binary data", |f| {
        f.data.contains(&0x1a)
    }),
    ("with the byte 0xff in the binary data", |f| {
        f.data.contains(&0xff)
    }),
    ("with a stored value of 0", |f| f.samples.contains(&0)),
    ("with a stored value of 255", |f| f.samples.contains(&255)),
];

/// The lists of numbers in a header.
const LISTS: [(&str, &str); 3] = [
    ("a scale", "2.4/3"),
    ("a bias", "2.4/4"),
    ("a number of the matrix", "2.6/2"),
];

/// What can be said of a number, of each list.
const OF_NUMBERS: &[(&str, fn(&str) -> bool)] = &[
    ("that has an exponent", |text| text.contains(['e', 'E'])),
    ("that has an exponent with a capital E", |text| {
        text.contains('E')
    }),
    ("that has a negative exponent", |text| {
        text.contains("e-") || text.contains("E-")
    }),
    ("that has an exponent of one digit", |text| {
        exponent(text).is_some_and(|digits| digits.len() == 1)
    }),
    ("that has an exponent of more than one digit", |text| {
        exponent(text).is_some_and(|digits| digits.len() > 1)
    }),
    ("that has an exponent with a plus sign", |text| {
        text.contains("e+") || text.contains("E+")
    }),
    ("that has an exponent without a sign", |text| {
        text.contains(['e', 'E'])
            && !text.contains("e+")
            && !text.contains("E+")
            && !text.contains("e-")
            && !text.contains("E-")
    }),
    ("that has a minus sign", |text| text.starts_with('-')),
    ("that has a plus sign", |text| text.starts_with('+')),
    ("that has a sign", |text| text.starts_with(['+', '-'])),
    ("that begins with its decimal point", |text| {
        text.trim_start_matches(['+', '-']).starts_with('.')
    }),
    (
        "that begins with its decimal point, without a sign",
        |text| text.starts_with('.'),
    ),
    ("that ends in its decimal point", |text| text.ends_with('.')),
    ("that begins or ends with its decimal point", |text| {
        text.trim_start_matches(['+', '-']).starts_with('.') || text.ends_with('.')
    }),
    ("that has a decimal point", |text| text.contains('.')),
    ("that has a fraction of one digit", |text| {
        fraction(text).is_some_and(|digits| digits.len() == 1)
    }),
    ("that is one digit and nothing else", |text| {
        text.len() == 1 && text.as_bytes()[0].is_ascii_digit()
    }),
    ("that has no decimal point", |text| {
        !text.contains(['.', 'e', 'E'])
    }),
    ("that begins with a zero and another digit", |text| {
        let mut digits = text.trim_start_matches(['+', '-']).bytes();
        digits.next() == Some(b'0') && digits.next().is_some_and(|byte| byte.is_ascii_digit())
    }),
    ("that is no whole number", |text| {
        number(text).fract() != 0.0
    }),
    ("below zero", |text| number(text) < 0.0),
    ("of zero", |text| number(text) == 0.0),
    ("over 1", |text| number(text) > 1.0),
    ("over 255", |text| number(text) > 255.0),
    ("from 128 to 255", |text| {
        (128.0..=255.0).contains(&number(text))
    }),
];

const OF_SIZE: &[Row] = &[
    ("whose six scales differ", |f| {
        f.numbers[0]
            .windows(2)
            .any(|pair| number(pair[0]) != number(pair[1]))
    }),
    ("of one texel", |f| f.sized(|w, h| w == 1 && h == 1)),
    ("of one column", |f| f.sized(|w, _| w == 1)),
    ("of one row", |f| f.sized(|_, h| h == 1)),
    ("of odd width", |f| f.sized(|w, _| w % 2 == 1)),
    ("of odd height", |f| f.sized(|_, h| h % 2 == 1)),
    ("of even width", |f| f.sized(|w, _| w % 2 == 0)),
    ("of even height", |f| f.sized(|_, h| h % 2 == 0)),
    ("whose width is no multiple of 4", |f| {
        f.sized(|w, _| w % 4 != 0)
    }),
    ("whose width is no multiple of 8", |f| {
        f.sized(|w, _| w % 8 != 0)
    }),
    ("whose width or height is no multiple of 8", |f| {
        f.sized(|w, h| w % 8 != 0 || h % 8 != 0)
    }),
    ("whose width and height are multiples of 8", |f| {
        f.sized(|w, h| w % 8 == 0 && h % 8 == 0)
    }),
    ("whose width or height is less than 8", |f| {
        f.sized(|w, h| w < 8 || h < 8)
    }),
    ("of unequal width and height", |f| f.sized(|w, h| w != h)),
    ("wider than high", |f| f.sized(|w, h| w > h)),
    ("higher than wide", |f| f.sized(|w, h| h > w)),
    ("with a table of one entry", |f| {
        entries(f).is_some_and(|entries| entries == 1.0)
    }),
    ("with a table of 256 entries", |f| {
        entries(f).is_some_and(|entries| entries == 256.0)
    }),
    ("whose first byte after the table is a line feed", |f| {
        let size = if f.format == Format::PtmCLut { 9 } else { 6 };
        let after = entries(f).map(|entries| entries as usize * size);
        after.and_then(|after| f.data.get(after)) == Some(&b'\n')
    }),
    ("with a table of more than 256 entries", |f| {
        entries(f).is_some_and(|entries| entries > 256.0)
    }),
    ("with the index of the last of several entries", |f| {
        let last = entries(f).map(|entries| entries - 1.0);
        last.is_some_and(|last| last > 0.0) && f.largest_index.map(f64::from) == last
    }),
    ("with a table of at most 256 entries", |f| {
        entries(f).is_some_and(|entries| entries <= 256.0)
    }),
];

/// Entries of the lookup table.
fn entries(facts: &Facts) -> Option<f64> {
    let recipe = facts.recipe.filter(|recipe| recipe.format.has_table())?;
    Some(f64::from(recipe.entries))
}

const OF_LIGHT: &[Row] = &[
    ("under a light whose u is negative", |f| {
        f.light().is_some_and(|(u, _)| u < 0.0)
    }),
    ("under a light whose v is negative", |f| {
        f.light().is_some_and(|(_, v)| v < 0.0)
    }),
    ("under a light whose u and v are equal", |f| {
        f.light().is_some_and(|(u, v)| u == v)
    }),
    ("under a light whose u is zero", |f| {
        f.light().is_some_and(|(u, _)| u == 0.0)
    }),
    ("under a light whose v is zero", |f| {
        f.light().is_some_and(|(_, v)| v == 0.0)
    }),
    ("under a light whose u and v have opposite signs", |f| {
        f.light().is_some_and(|(u, v)| u * v < 0.0)
    }),
    ("under a light whose u is positive", |f| {
        f.light().is_some_and(|(u, _)| u > 0.0)
    }),
    ("under a light whose v is positive", |f| {
        f.light().is_some_and(|(_, v)| v > 0.0)
    }),
    ("under a light from the left", |f| {
        f.light().is_some_and(|(u, v)| u < 0.0 && v >= 0.0)
    }),
    ("under a light from below", |f| {
        f.light().is_some_and(|(u, v)| v < 0.0 && u >= 0.0)
    }),
    ("under a light from below left", |f| {
        f.light().is_some_and(|(u, v)| u < 0.0 && v < 0.0)
    }),
    ("under a light that is not straight above", |f| {
        f.light().is_some_and(|light| light != (0.0, 0.0))
    }),
    ("under a light outside the unit circle", |f| {
        f.light().is_some_and(|(u, v)| u * u + v * v > 1.0)
    }),
];

const OF_COMPRESSION: &[Pair] = &[
    ("with predicted planes", "without predicted planes", |f| {
        f.planned(Compression::predicts)
    }),
    ("with inverted references", "", |f| {
        f.planned(Compression::inverts)
    }),
    ("with motion vectors", "", |f| f.planned(Compression::moves)),
    ("with motion vectors of half texels", "", |f| {
        f.vectors().iter().any(|(x, y)| x % 2 != 0 || y % 2 != 0)
    }),
    ("with motion vectors below zero", "", |f| {
        f.vectors().iter().any(|(x, y)| *x < 0 || *y < 0)
    }),
    ("with a transform other than 0", "", |f| {
        f.planned(|plan| plan.transforms.iter().any(|&transform| transform != 0))
    }),
    (
        "with references that are both inverted and moved",
        "",
        |f| f.planned(|plan| plan.transforms.contains(&3)),
    ),
    ("whose order is not 0, 1, 2 …", "", |f| {
        f.planned(|plan| {
            let mut ranks = plan.order.iter().enumerate();
            ranks.any(|(plane, &rank)| rank != plane as i64)
        })
    }),
    (
        "in which a plane is predicted from one that is stored after it",
        "",
        |f| {
            f.planned(|plan| {
                let later =
                    |plane: &usize| plan.reference(*plane).is_some_and(|other| other > *plane);
                (0..plan.order.len()).any(|plane| later(&plane))
            })
        },
    ),
    (
        "in which a predicted plane is a reference itself",
        "",
        |f| {
            f.planned(|plan| {
                let chained = |plane: usize| plan.reference(plan.reference(plane)?);
                (0..plan.order.len()).any(|plane| chained(plane).is_some())
            })
        },
    ),
    ("with side information", "without side information", |f| {
        f.records().is_some_and(|count| count > 0)
    }),
    ("with side information of intra planes", "", |f| {
        f.has_records(false)
    }),
    ("with side information of predicted planes", "", |f| {
        f.has_records(true)
    }),
    ("with JPEG-LS planes of a parameter over 0", "", |f| {
        !f.is_lossy() && f.planned(|plan| plan.parameter > 0)
    }),
    ("with JPEG-LS planes of parameter 0", "", |f| {
        !f.is_lossy() && f.planned(|plan| plan.parameter == 0)
    }),
    ("whose planes have streams of different kinds", "", |f| {
        f.planned(|plan| plan.alternates)
    }),
    ("with restart markers in their JPEG streams", "", |f| {
        f.planned(|plan| plan.stream.restart_interval > 0)
    }),
    (
        "with more than eight restart markers in one plane (RST0 follows RST7)",
        "",
        |f| f.markers().is_some_and(|markers| markers > 8),
    ),
    (
        "with several tables in one segment of their JPEG streams",
        "",
        |f| f.planned(|plan| plan.stream.tables_together),
    ),
    (
        "with tables in their JPEG streams that nothing uses",
        "",
        |f| f.planned(|plan| plan.stream.table_numbers.is_some()),
    ),
    (
        "with Huffman tables of their own in their JPEG streams",
        "",
        |f| f.planned(|plan| plan.stream.optimized),
    ),
    (
        "with 16-bit quantization tables (SOF1) in their JPEG streams",
        "",
        |f| f.is_lossy() && f.planned(|plan| !plan.stream.baseline && plan.parameter < 24),
    ),
    (
        "with sampling factors other than 1x1 in their JPEG streams",
        "",
        |f| f.is_lossy() && f.planned(|plan| plan.stream.sampling != (1, 1)),
    ),
    (
        "with preset parameters (LSE) in their JPEG-LS streams",
        "",
        |f| f.planned(|plan| plan.stream.presets.is_some()),
    ),
];

const VIEWS: &[Row] = &[
    ("asked for stored values", |f| *f.view == View::Raw),
    ("asked for final values", |f| *f.view == View::Coef),
    ("asked for colors under a light", |f| f.light().is_some()),
];

/// All tables in one list.
fn all_traits() -> Vec<Trait> {
    let row = |&(says, holds): &Row| Trait {
        says: says.to_owned(),
        is_view: false,
        clause: None,
        holds: Box::new(holds),
    };
    let both = |&(says, opposite, holds): &Pair| {
        // How a file is spelled is known where it was made of a recipe.
        let is_known = |facts: &Facts| facts.size.is_some() && facts.recipe.is_some();
        let not = (!opposite.is_empty()).then(|| Trait {
            says: opposite.to_owned(),
            is_view: false,
            clause: None,
            holds: Box::new(move |facts| is_known(facts) && !holds(facts)),
        });
        [Some(row(&(says, holds))), not].into_iter().flatten()
    };
    let of_format = |format: Format| Trait {
        says: format!("of format {}", format.short_name()),
        is_view: false,
        clause: None,
        holds: Box::new(move |facts| facts.format == format),
    };
    // Where only one format of a kind is read, it is named.
    let mut all: Vec<Trait> = Format::ALL.map(of_format).into_iter().collect();
    all.extend(OF_FORMAT.iter().flat_map(both));
    all.extend(OF_LIGHT.iter().map(row));
    all.extend(OF_SPELLING.iter().flat_map(both));
    all.extend(Line::ALL.map(|line| Trait {
        says: format!(
            "with a space before the line feed of the line of the {}",
            line.name()
        ),
        is_view: false,
        clause: None,
        holds: Box::new(move |facts| {
            facts.spelled(|recipe| recipe.spelling.space_before_newline.contains(&line))
        }),
    }));
    all.extend(OF_BYTES.iter().map(row));
    for (list, (what, clause)) in LISTS.into_iter().enumerate() {
        all.extend(OF_NUMBERS.iter().map(|&(says, holds)| Trait {
            says: format!("with {what} {says}"),
            is_view: false,
            clause: Some(clause),
            holds: Box::new(move |facts| facts.numbers[list].iter().any(|text| holds(text))),
        }));
    }
    all.extend(OF_NUMBERS.iter().map(|&(says, holds)| Trait {
        says: format!("with a number in the header {says}"),
        is_view: false,
        clause: None,
        holds: Box::new(move |facts| facts.numbers.iter().flatten().any(|text| holds(text))),
    }));
    all.extend(OF_NUMBERS.iter().map(|&(says, holds)| Trait {
        says: format!("with a scale or a bias {says}"),
        is_view: false,
        clause: None,
        holds: Box::new(move |facts| facts.numbers[..2].iter().flatten().any(|text| holds(text))),
    }));
    all.extend(OF_SIZE.iter().map(row));
    all.extend(of_lengths());
    all.extend(OF_COMPRESSION.iter().flat_map(both));
    all.extend(VIEWS.iter().map(|view| Trait {
        is_view: true,
        ..row(view)
    }));
    all
}

/// Files that are longer than buffers or counters are.
fn of_lengths() -> impl Iterator<Item = Trait> {
    let buffers = BUFFERS.map(|size| Trait {
        says: format!("of more than {size} bytes"),
        is_view: false,
        clause: None,
        holds: Box::new(move |facts| facts.header + facts.data.len() > size),
    });
    let counts = COUNTS.map(|count| Trait {
        says: format!("of more than {count} texels"),
        is_view: false,
        clause: Some("2.3/1"),
        holds: Box::new(move |facts| {
            let size = facts.size();
            size.is_some_and(|(width, height)| u64::from(width) * u64::from(height) > count)
        }),
    });
    buffers.into_iter().chain(counts)
}

/// Sizes of buffers, in bytes, and of counters of texels.
const BUFFERS: [usize; 8] = [
    1 << 11,
    1 << 12,
    1 << 13,
    1 << 14,
    1 << 15,
    1 << 16,
    1 << 17,
    1 << 20,
];
/// Where several tell the same files apart the largest says least.
const COUNTS: [u64; 5] = [65_536, 65_535, 256, 255, 127];

/// All quantities.
pub(super) const QUANTITIES: &[Quantity] = &[
    quantity("2.3/1", ["with", "texels"], |f| {
        let (width, height) = f.size()?;
        Some(f64::from(width) * f64::from(height))
    }),
    quantity("2.3/1", ["with", "columns"], |f| {
        Some(f64::from(f.size()?.0))
    }),
    quantity("2.3/1", ["with", "rows"], |f| Some(f64::from(f.size()?.1))),
    quantity("2.3/1", ["with", "columns or rows"], |f| {
        let (width, height) = f.size()?;
        Some(f64::from(width.max(height)))
    }),
    quantity("2.0/1", ["with", "bytes in one line of the header"], |f| {
        Some(f.longest_line as f64)
    }),
    quantity("2.0/1", ["with", "bytes of header"], |f| {
        Some(f.header as f64)
    }),
    quantity("2.4/3", ["with", "characters in one scale"], |f| {
        f.longest(0)
    }),
    quantity("2.4/4", ["with", "characters in one bias"], |f| {
        f.longest(1)
    }),
    quantity(
        "2.6/2",
        ["with", "characters in one number of the matrix"],
        |f| f.longest(2),
    ),
    quantity("2.4/3", ["with", "as their largest scale"], |f| {
        f.largest(0)
    }),
    quantity("2.4/4", ["with", "as their largest bias"], |f| f.largest(1)),
    quantity("2.5/2", ["with", "entries"], entries),
    quantity("2.8.1/3", ["with", "as their largest index"], |f| {
        f.largest_index.map(f64::from)
    }),
    quantity("1.0/2", ["under a light", "from the middle"], |f| {
        f.light().map(|(u, v)| u.hypot(v))
    }),
    quantity("2.9.3/1", ["with", "half texels of motion"], |f| {
        let farthest = f.vectors().iter().map(|(x, y)| x.abs().max(y.abs())).max();
        farthest.map(f64::from)
    }),
    quantity(
        "2.9.5/4",
        ["with", "planes in one chain of predictions"],
        |f| {
            let plan = f.plan?;
            let planes = plan.order.len();
            let chain = |plane| {
                let from = std::iter::successors(Some(plane), |&plane| plan.reference(plane));
                from.take(planes).count()
            };
            (0..planes).map(chain).max().map(|deepest| deepest as f64)
        },
    ),
    quantity("2.9.4/3", ["with", "as their largest rank"], |f| {
        f.plan?.order.iter().max().map(|&rank| rank as f64)
    }),
    quantity("2.9.8/4", ["with", "records of side information"], |f| {
        f.records().map(|count| count as f64)
    }),
    quantity(
        "2.9.8/4",
        ["with", "records of side information in one plane"],
        |f| {
            let planes = f.planes?.iter();
            planes
                .map(|plane| plane.records.len())
                .max()
                .map(|most| most as f64)
        },
    ),
    quantity(
        "2.9.8/5",
        ["with", "as their largest position of side information"],
        |f| {
            let records = f.planes?.iter().flat_map(|plane| &plane.records);
            records
                .map(|&(position, _)| f64::from(position))
                .max_by(f64::total_cmp)
        },
    ),
    quantity(
        "2.9.6/1",
        ["with", "as the largest compressed size of a plane"],
        |f| {
            let sizes = f.planes?.iter().map(|plane| plane.stream.len());
            sizes.max().map(|largest| largest as f64)
        },
    ),
    quantity(
        "2.9.6/1",
        ["with", "bytes in all compressed planes together"],
        |f| {
            let sizes = f.planes?.iter().map(|plane| plane.stream.len());
            Some(sizes.sum::<usize>() as f64)
        },
    ),
    quantity("2.9.8/3", ["with", "as their JPEG quality"], |f| {
        let plan = f.plan.filter(|_| f.is_lossy())?;
        Some(f64::from(plan.parameter))
    }),
    quantity("2.9.8/3", ["with", "as their largest loss"], |f| {
        let plan = f.plan.filter(|_| !f.is_lossy())?;
        Some(f64::from(plan.parameter))
    }),
    quantity("2.9.8/3", ["with", "restart markers in one plane"], |f| {
        f.markers().map(f64::from)
    }),
];

const fn quantity(
    clause: &'static str,
    words: [&'static str; 2],
    value: fn(&Facts) -> Option<f64>,
) -> Quantity {
    Quantity {
        clause,
        words,
        value,
    }
}
