//! Properties that describe a set of files. Each was needed for a real decoder, or is a key of `make:` in the cases.

use super::witness::{Facts, Witness};
use crate::generate::Recipe;
use crate::generate::plan::Compression;
use crate::generate::planes::StoredPlane;
use crate::generate::spelling::{Count, Line, Lists};
use crate::protocol::frame::{Answer, View};
use crate::ptm::{Coding, Field, Format};

impl Witness<'_> {
    /// Returns the properties of the file, computed on first use.
    pub fn facts(&self) -> &Facts {
        self.facts.get_or_init(|| {
            let file = File::new(self);
            Facts {
                properties: PROPERTIES.iter().map(|(.., holds)| holds(&file)).collect(),
                quantities: QUANTITIES
                    .iter()
                    .map(|quantity| (quantity.value)(&file))
                    .collect(),
            }
        })
    }
}

/// Parts of a file that the properties depend on.
pub(super) struct File<'a> {
    view: &'a View,
    format: Format,
    size: Option<(u32, u32)>,
    recipe: Option<&'a Recipe>,
    plan: Option<&'a Compression>,
    planes: &'a [StoredPlane],
    header: &'a [u8],
    data: &'a [u8],
    /// Texts of the scales, the biases and the matrix elements.
    numbers: [Vec<&'a str>; 3],
}

impl<'a> File<'a> {
    fn new(witness: &'a Witness) -> File<'a> {
        let file = &witness.built.file;
        let (header, data) = file.split_at(witness.payload_offset().min(file.len()));
        let texts = |clause: &str| -> Vec<&str> {
            let fields = witness
                .fields()
                .iter()
                .filter(|field| field.clause == clause);
            let text = |field: &Field| std::str::from_utf8(&file[field.range.clone()]).ok();
            fields.filter_map(text).collect()
        };
        let compressed = witness.model().and_then(|model| model.compressed.as_ref());
        File {
            view: &witness.observation.view,
            format: witness.case.format(),
            size: match &witness.right {
                Answer::Decoded(frame) => Some((frame.width, frame.height)),
                _ => None,
            },
            recipe: witness.case.recipe(),
            plan: witness.case.compression(),
            planes: compressed.map_or(&[], |compressed| &compressed.planes),
            header,
            data,
            numbers: [texts("2.4/3"), texts("2.4/4"), texts("2.6/2")],
        }
    }

    fn recipe_has(&self, holds: impl Fn(&Recipe) -> bool) -> bool {
        self.recipe.is_some_and(holds)
    }

    fn plan_has(&self, holds: impl Fn(&Compression) -> bool) -> bool {
        self.plan.is_some_and(holds)
    }

    fn has_size(&self, holds: impl Fn(u32, u32) -> bool) -> bool {
        self.size
            .is_some_and(|(width, height)| holds(width, height))
    }

    fn has_space(&self, line: Line) -> bool {
        self.recipe_has(|recipe| recipe.spelling.space_before_newline.contains(&line))
    }

    fn has_number(&self, holds: impl Fn(&str) -> bool) -> bool {
        self.numbers.iter().flatten().any(|text| holds(text))
    }

    fn starts_with(&self, holds: impl Fn(u8) -> bool) -> bool {
        self.data.first().is_some_and(|&byte| holds(byte))
    }

    fn has_streams_of(&self, coding: Coding) -> bool {
        self.format.coding() == Some(coding)
    }

    fn parameter(&self, coding: Coding) -> Option<f64> {
        let plan = self.plan.filter(|_| self.has_streams_of(coding))?;
        Some(f64::from(plan.parameter))
    }

    fn entries(&self) -> Option<u32> {
        let recipe = self.recipe.filter(|recipe| recipe.format.has_table())?;
        Some(recipe.entries)
    }

    fn light(&self) -> Option<(f64, f64)> {
        match self.view {
            View::Rgb(light) => Some((light.lu, light.lv)),
            _ => None,
        }
    }

    /// Returns the motion vectors of the predicted planes.
    fn vectors(&self) -> Vec<(i32, i32)> {
        let Some(plan) = self.plan.filter(|plan| plan.moves()) else {
            return Vec::new();
        };
        let at = |list: &[i32], plane: usize| list.get(plane).copied().unwrap_or_default();
        let predicted = (0..plan.order.len()).filter(|&plane| plan.reference(plane).is_some());
        let vector = |plane| (at(&plan.motion_x, plane), at(&plan.motion_y, plane));
        predicted.map(vector).collect()
    }

    /// Returns true if a plane that is predicted (or not, if `predicted` is false) has side information.
    fn has_records(&self, predicted: bool) -> bool {
        let mut planes = self.planes.iter().enumerate();
        planes.any(|(plane, stored)| {
            let reference = self.plan.and_then(|plan| plan.reference(plane));
            !stored.records.is_empty() && reference.is_some() == predicted
        })
    }

    /// Returns the maximum of `number` over the side information of all planes.
    fn max_over_planes(&self, number: fn(&StoredPlane) -> Option<u32>) -> Option<f64> {
        self.planes.iter().filter_map(number).max().map(f64::from)
    }
}

/// Text that completes "files …", a flag for the requested view, and the condition.
type Property = (&'static str, bool, fn(&File) -> bool);

const fn property(words: &'static str, holds: fn(&File) -> bool) -> Property {
    (words, false, holds)
}

pub(super) const PROPERTIES: &[Property] = &[
    // Views
    ("if stored values are requested", true, |f| {
        *f.view == View::Raw
    }),
    ("if final values are requested", true, |f| {
        *f.view == View::Coef
    }),
    ("if colors are requested", true, |f| f.light().is_some()),
    property("under a light whose u is negative", |f| {
        f.light().is_some_and(|(u, _)| u < 0.0)
    }),
    property("under a light whose v is negative", |f| {
        f.light().is_some_and(|(_, v)| v < 0.0)
    }),
    property("under a light outside the unit circle", |f| {
        f.light().is_some_and(|(u, v)| u * u + v * v > 1.0)
    }),
    // Formats
    property("with compressed planes", |f| f.format.coding().is_some()),
    property("without compressed planes", |f| f.format.coding().is_none()),
    property("with JPEG planes", |f| f.has_streams_of(Coding::Jpeg)),
    property("with JPEG-LS planes", |f| f.has_streams_of(Coding::JpegLs)),
    property("with a lookup table", |f| f.format.has_table()),
    property("with a table of more than 256 entries", |f| {
        f.entries().is_some_and(|n| n > 256)
    }),
    // Spelling
    property("with width and height on one line", |f| {
        f.recipe_has(|r| !r.spelling.size_on_two_lines)
    }),
    property("with width and height on two lines", |f| {
        f.recipe_has(|r| r.spelling.size_on_two_lines)
    }),
    property("with scales and biases on one line", |f| {
        f.recipe_has(|r| !r.spelling.scale_bias_on_two_lines)
    }),
    property("with scales and biases on two lines", |f| {
        f.recipe_has(|r| r.spelling.scale_bias_on_two_lines)
    }),
    property("with several spaces between two numbers", |f| {
        f.recipe_has(|r| r.spelling.gap > 1)
    }),
    property("with a space before a line feed", |f| {
        f.recipe_has(|r| !r.spelling.space_before_newline.is_empty())
    }),
    property("with a space after the version", |f| {
        f.has_space(Line::Version)
    }),
    property("with a space after the format", |f| {
        f.has_space(Line::Format)
    }),
    property("with a space after the width", |f| f.has_space(Line::Width)),
    property("with a space after the height", |f| {
        f.has_space(Line::Height)
    }),
    property("with a space after the scales", |f| {
        f.has_space(Line::Scale)
    }),
    property("with a space after the biases", |f| f.has_space(Line::Bias)),
    property("with the matrix on several lines", |f| {
        f.format == Format::Lum && f.recipe_has(|r| r.spelling.matrix_line < 16)
    }),
    property("with an entry count that is a bare number", |f| {
        f.format.has_table() && f.recipe_has(|r| r.spelling.count == Count::Number)
    }),
    property(
        "with the numbers of a list on several lines or of several lists on one",
        |f| f.format.coding().is_some() && f.recipe_has(|r| r.spelling.lists != Lists::default()),
    ),
    // Numbers
    property("with a negative bias", |f| {
        f.numbers[1].iter().any(|text| text.starts_with('-'))
    }),
    property("with a negative scale", |f| {
        f.numbers[0].iter().any(|text| text.starts_with('-'))
    }),
    property("with a number in scientific notation", |f| {
        f.has_number(|text| text.contains(['e', 'E']))
    }),
    property("with a number that starts with a plus sign", |f| {
        f.has_number(|text| text.starts_with('+'))
    }),
    property(
        "with a number that starts or ends with its decimal point",
        |f| {
            f.has_number(|text| {
                text.trim_start_matches(['+', '-']).starts_with('.') || text.ends_with('.')
            })
        },
    ),
    // Data
    property("with white space at the start of the binary data", |f| {
        f.starts_with(|byte| matches!(byte, 9..=13 | b' '))
    }),
    property("with a line feed at the start of the binary data", |f| {
        f.starts_with(|byte| byte == b'\n')
    }),
    // Size
    property("of odd width", |f| f.has_size(|width, _| width % 2 == 1)),
    property("of odd height", |f| f.has_size(|_, height| height % 2 == 1)),
    property(
        "of several rows with a width that is not a multiple of 4",
        |f| f.has_size(|width, height| width % 4 != 0 && height > 1),
    ),
    // Compression
    property("with predicted planes", |f| {
        f.plan_has(Compression::predicts)
    }),
    property("with a transform other than 0", |f| {
        f.plan_has(|plan| plan.transforms.iter().any(|&transform| transform != 0))
    }),
    property("with inverted references", |f| {
        f.plan_has(Compression::inverts)
    }),
    property("with displaced references", |f| {
        f.plan_has(Compression::moves)
    }),
    property("with references that are inverted and displaced", |f| {
        f.plan_has(|plan| plan.transforms.contains(&3))
    }),
    property("with motion vectors of half texels", |f| {
        f.vectors().iter().any(|(x, y)| (x | y) & 1 == 1)
    }),
    property("with negative motion vectors", |f| {
        f.vectors().iter().any(|(x, y)| *x < 0 || *y < 0)
    }),
    property("with an order other than 0, 1, 2, …", |f| {
        f.plan_has(|plan| {
            plan.order
                .iter()
                .enumerate()
                .any(|(p, &rank)| rank != p as i64)
        })
    }),
    property("with a plane predicted from a later one", |f| {
        f.plan_has(|plan| {
            (0..plan.order.len()).any(|p| plan.reference(p).is_some_and(|other| other > p))
        })
    }),
    property("with a plane predicted from a predicted one", |f| {
        f.plan_has(|plan| {
            (0..plan.order.len())
                .any(|p| plan.reference(p).and_then(|q| plan.reference(q)).is_some())
        })
    }),
    property("with side information", |f| {
        f.planes.iter().any(|plane| !plane.records.is_empty())
    }),
    property("with side information of intra planes", |f| {
        f.has_records(false)
    }),
    property("with side information of predicted planes", |f| {
        f.has_records(true)
    }),
    property("with a compression parameter of 0", |f| {
        f.plan_has(|plan| plan.parameter == 0)
    }),
    property("with restart markers", |f| {
        f.plan_has(|plan| plan.stream.jpeg.restart_interval > 0)
    }),
    property("with several tables in one marker segment", |f| {
        f.plan_has(|plan| plan.stream.jpeg.tables_together)
    }),
    property("with 16-bit quantization tables", |f| {
        f.has_streams_of(Coding::Jpeg)
            && f.plan_has(|plan| !plan.stream.jpeg.baseline && plan.parameter < 24)
    }),
    property("with sampling factors other than 1x1", |f| {
        f.has_streams_of(Coding::Jpeg) && f.plan_has(|plan| plan.stream.jpeg.sampling != (1, 1))
    }),
    property("with preset parameters (LSE)", |f| {
        f.plan_has(|plan| plan.stream.presets.is_some())
    }),
];

/// A numeric property of a file.
pub(super) struct Quantity {
    /// Clause about the quantity.
    pub clause: &'static str,
    /// Text after "with 17 or more".
    pub words: &'static str,
    value: fn(&File) -> Option<f64>,
}

const fn quantity(
    clause: &'static str,
    words: &'static str,
    value: fn(&File) -> Option<f64>,
) -> Quantity {
    Quantity {
        clause,
        words,
        value,
    }
}

pub(super) const QUANTITIES: &[Quantity] = &[
    quantity("2.7/3", "texels", |f| {
        f.size.map(|(w, h)| f64::from(w) * f64::from(h))
    }),
    quantity("2.3/1", "columns", |f| {
        f.size.map(|(width, _)| f64::from(width))
    }),
    quantity("2.3/1", "rows", |f| {
        f.size.map(|(_, height)| f64::from(height))
    }),
    quantity("2.3/1", "columns or rows", |f| {
        f.size.map(|(w, h)| f64::from(w.max(h)))
    }),
    quantity("2.0/1", "bytes in one line of the header", |f| {
        let lines = f.header.split(|&byte| byte == b'\n').map(<[u8]>::len);
        lines.max().map(|longest| longest as f64)
    }),
    quantity("2.5/2", "table entries", |f| f.entries().map(f64::from)),
    quantity("2.9.4/3", "as their largest rank", |f| {
        f.plan?.order.iter().max().map(|&rank| rank as f64)
    }),
    quantity("2.9.3/1", "half texels of motion", |f| {
        let farthest = f.vectors().iter().map(|(x, y)| x.abs().max(y.abs())).max();
        farthest.map(f64::from)
    }),
    quantity("2.9.8/4", "records in one plane", |f| {
        f.max_over_planes(|plane| u32::try_from(plane.records.len()).ok())
    }),
    quantity("2.9.8/5", "as their largest position of a record", |f| {
        f.max_over_planes(|plane| plane.records.iter().map(|record| record.0).max())
    }),
    quantity("2.9.1/1", "as their JPEG quality", |f| {
        f.parameter(Coding::Jpeg)
    }),
    quantity("2.9.1/1", "as their maximum loss", |f| {
        f.parameter(Coding::JpegLs)
    }),
    quantity("1.0/2", "as the length of (u, v)", |f| {
        f.light().map(|(u, v)| u.hypot(v))
    }),
];
