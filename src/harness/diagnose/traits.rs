//! What can be said of a file, so that those which a decoder treats alike can be found alike.

use super::witness::Witness;
use crate::generate::plan::Coding;
use crate::generate::spelling::{Count, Lists};
use crate::harness::protocol::View;
use crate::ptm::{Field, Format};

/// What can be said of one file.
pub(super) struct Traits {
    /// Each completes "files …"; from the general to the particular.
    pub has: Vec<String>,
    /// What was asked for: completes "files …" too.
    pub asked: &'static str,
    /// Each completes "files with more than N …".
    pub numbers: Vec<(&'static str, i64)>,
}

/// All that can be said of a file.
pub(super) fn traits(witness: &Witness) -> Traits {
    let mut traits = Traits {
        has: Vec::new(),
        asked: match witness.finding.view {
            View::Raw => "asked for stored values",
            View::Coef => "asked for final values",
            View::Rgb(_) => "asked for colors under a light",
        },
        numbers: Vec::new(),
    };
    of_format(witness, &mut traits);
    of_spelling(witness, &mut traits);
    of_numbers(witness, &mut traits);
    of_compression(witness, &mut traits);
    traits
}

impl Traits {
    /// In words, with what was asked for at the end if `asked`.
    pub fn said(&self, asked: bool) -> Vec<&str> {
        let asked = asked.then_some(self.asked);
        self.has.iter().map(String::as_str).chain(asked).collect()
    }

    fn add(&mut self, holds: bool, says: impl Into<String>) {
        if holds {
            self.has.push(says.into());
        }
    }
}

fn of_format(witness: &Witness, traits: &mut Traits) {
    let format = witness.case.format();
    let lossy = matches!(format, Format::JpegRgb | Format::JpegLrgb);
    traits.add(format.is_compressed(), "with compressed planes");
    traits.add(!format.is_compressed(), "without compressed planes");
    traits.add(lossy, "with JPEG planes");
    traits.add(format.is_compressed() && !lossy, "with JPEG-LS planes");
    traits.add(format.has_table(), "with a lookup table");
    traits.add(!format.has_table(), "without a lookup table");
    traits.add(
        format.channels() == 18,
        "with three polynomials (RGB, JPEG_RGB, JPEGLS_RGB)",
    );
    traits.add(
        format.channels() == 9,
        "with one polynomial and a color (LRGB, tables, JPEG_LRGB, JPEGLS_LRGB)",
    );
    traits.add(true, format!("of format {}", format.short_name()));
    if let View::Rgb(light) = &witness.finding.view {
        traits.add(
            light.lu < 0.0 && light.lv >= 0.0,
            "under a light from the left",
        );
        traits.add(
            light.lv < 0.0 && light.lu >= 0.0,
            "under a light from below",
        );
        traits.add(
            light.lu < 0.0 && light.lv < 0.0,
            "under a light from below left",
        );
    }
}

fn of_spelling(witness: &Witness, traits: &mut Traits) {
    if let Some(recipe) = witness.case.recipe() {
        let spelling = &recipe.spelling;
        traits.add(
            spelling.size_on_two_lines,
            "whose width and height stand on two lines",
        );
        traits.add(
            !spelling.size_on_two_lines,
            "whose width and height stand on one line",
        );
        traits.add(
            spelling.scale_bias_on_two_lines,
            "whose scales and biases stand on two lines",
        );
        traits.add(
            !spelling.scale_bias_on_two_lines,
            "whose scales and biases stand on one line",
        );
        traits.add(
            !spelling.space_before_newline.is_empty(),
            "with a space before the line feed of a header line",
        );
        traits.add(
            spelling.space_before_newline.is_empty(),
            "without a space before any line feed of the header",
        );
        for line in &spelling.space_before_newline {
            traits.add(
                true,
                format!(
                    "with a space before the line feed of the line of the {}",
                    line.name()
                ),
            );
        }
        traits.add(
            spelling.gap > 1,
            "with more than one space between two numbers",
        );
        if recipe.format.has_table() {
            traits.add(
                spelling.count == Count::NumberWord,
                "with the number of entries written as \"256 N_LUT_ENTRIES\"",
            );
            traits.add(
                spelling.count == Count::Number,
                "with the number of entries written as \"256\"",
            );
            traits.add(
                spelling.count == Count::WordNumber,
                "with the number of entries written as \"nentries 256\"",
            );
            traits.add(
                spelling.newline_after_table,
                "with a line feed after the table",
            );
        }
        if recipe.format.is_compressed() {
            traits.add(
                spelling.lists != Lists::Lines,
                "whose lists of 2.9 are split into lines in another way than the real file's",
            );
        }
    }
    let payload = witness.payload();
    let file = &witness.built.file;
    if let Some(&first) = file.get(payload) {
        traits.add(
            first.is_ascii_whitespace() || first == 0x0b,
            "whose first byte after the header is white space",
        );
        for (byte, name) in [
            (b' ', "a space"),
            (b'\n', "a line feed"),
            (b'\r', "a carriage return"),
            (b'\t', "a tab"),
            (0, "zero"),
        ] {
            traits.add(
                first == byte,
                format!("whose first byte after the header is {name}"),
            );
        }
        traits.add(
            first.is_ascii_digit() || matches!(first, b'-' | b'+' | b'.'),
            "whose first byte after the header looks like part of a number",
        );
        traits.add(
            first == b'#',
            "whose first byte after the header is a number sign",
        );
    }
    let data = &file[payload.min(file.len())..];
    traits.add(
        data.windows(2).any(|pair| pair == b"\r\n"),
        "with the bytes CR LF in the binary data",
    );
    for byte in [0x00, 0x0a, 0x0d, 0x1a, 0xff] {
        traits.add(
            data.contains(&byte),
            format!("with the byte {byte:#04x} in the binary data"),
        );
    }
    if let Ok(ptm) = witness.decoded() {
        for value in [0, 255] {
            traits.add(
                ptm.planes.samples.contains(&value),
                format!("with a stored value of {value}"),
            );
        }
    }
}

fn of_numbers(witness: &Witness, traits: &mut Traits) {
    let texts = |name: &str| -> Vec<&str> {
        let file = &witness.built.file;
        let of = |field: &&Field| field.name == name;
        let text = |field: &Field| std::str::from_utf8(&file[field.range.clone()]).ok();
        witness
            .fields()
            .iter()
            .filter(of)
            .filter_map(text)
            .collect()
    };
    let value = |text: &str| text.parse::<f64>().unwrap_or_default();
    for (name, what) in [
        ("scale", "a scale"),
        ("bias", "a bias"),
        ("matrix", "a number of the matrix"),
    ] {
        let texts = texts(name);
        let any = |says: &dyn Fn(&str) -> bool| texts.iter().any(|text| says(text));
        traits.add(
            any(&|text| text.contains(['e', 'E'])),
            format!("with {what} that has an exponent"),
        );
        traits.add(
            any(&|text| text.contains('E')),
            format!("with {what} that has an exponent with a capital E"),
        );
        traits.add(
            any(&|text| text.contains("e-") || text.contains("E-")),
            format!("with {what} that has a negative exponent"),
        );
        traits.add(
            any(&|text| text.starts_with('+')),
            format!("with {what} that has a plus sign"),
        );
        traits.add(
            any(&|text| text.trim_start_matches(['+', '-']).starts_with('.')),
            format!("with {what} that begins with its decimal point"),
        );
        traits.add(
            any(&|text| text.ends_with('.')),
            format!("with {what} that ends in its decimal point"),
        );
        traits.add(
            any(&|text| value(text) < 0.0),
            format!("with {what} below zero"),
        );
        traits.add(
            any(&|text| value(text) == 0.0),
            format!("with {what} of zero"),
        );
        traits.add(
            any(&|text| text.len() > 9),
            format!("with {what} of more than nine characters"),
        );
        if name == "scale" {
            traits.add(
                any(&|text| !text.contains(['.', 'e', 'E'])),
                "with a scale that has no decimal point",
            );
            traits.add(any(&|text| value(text) > 1.0), "with a scale over 1");
            traits.add(
                texts
                    .windows(2)
                    .any(|pair| value(pair[0]) != value(pair[1])),
                "whose six scales differ",
            );
        }
        if name == "bias" {
            traits.add(any(&|text| value(text) > 255.0), "with a bias over 255");
            traits.add(
                any(&|text| value(text) > 127.0 && value(text) <= 255.0),
                "with a bias from 128 to 255",
            );
        }
    }
    let Some(recipe) = witness.case.recipe() else {
        return;
    };
    let (width, height) = (recipe.size.width, recipe.size.height);
    traits.add(width == 1 && height == 1, "of one texel");
    traits.add(width == 1, "of one column");
    traits.add(height == 1, "of one row");
    traits.add(width % 2 == 1, "of odd width");
    traits.add(height % 2 == 1, "of odd height");
    traits.add(width % 2 == 0, "of even width");
    traits.add(width % 4 != 0, "whose width is no multiple of 4");
    traits.add(
        width % 8 != 0 || height % 8 != 0,
        "whose width or height is no multiple of 8",
    );
    traits.add(width != height, "of unequal width and height");
    traits.add(width > height, "wider than high");
    traits.add(height > width, "higher than wide");
    traits.numbers.extend([
        ("texels", recipe.size.texels() as i64),
        ("columns", i64::from(width)),
        ("rows", i64::from(height)),
        ("bytes", witness.built.file.len() as i64),
    ]);
    let longest = |name| {
        texts(name)
            .into_iter()
            .map(str::len)
            .max()
            .unwrap_or_default() as i64
    };
    let header = &witness.built.file[..witness.payload()];
    let lines = header.split(|&byte| byte == b'\n').map(<[u8]>::len);
    let largest = texts("bias")
        .into_iter()
        .map(value)
        .fold(f64::MIN, f64::max);
    traits.numbers.extend([
        ("bytes of header", header.len() as i64),
        (
            "bytes in one line of the header",
            lines.max().unwrap_or_default() as i64,
        ),
        ("characters in one scale", longest("scale")),
        ("characters in one bias", longest("bias")),
        ("characters in one number of the matrix", longest("matrix")),
        ("as their largest bias", largest as i64),
    ]);
    if recipe.format.has_table() {
        let entries = i64::from(recipe.entries);
        traits.add(entries == 1, "with a table of one entry");
        traits.add(entries == 256, "with a table of 256 entries");
        traits.add(entries > 256, "with a table of more than 256 entries");
        traits.add(entries <= 256, "with a table of at most 256 entries");
        traits.numbers.push(("entries", entries));
        let largest = witness
            .model()
            .and_then(|model| model.indices.iter().max().copied());
        if let Some(largest) = largest {
            traits
                .numbers
                .push(("as their largest index", i64::from(largest)));
        }
    }
    traits.add(
        recipe.format == Format::Lum && recipe.spelling.matrix_line != 16,
        "whose matrix stands on several lines",
    );
}

fn of_compression(witness: &Witness, traits: &mut Traits) {
    let Some(plan) = witness.case.compression() else {
        return;
    };
    let coding = witness.case.recipe().map(crate::generate::Recipe::coding);
    let planes = plan.order.len();
    traits.add(plan.predicts(), "with predicted planes");
    traits.add(!plan.predicts(), "without predicted planes");
    traits.add(plan.inverts(), "with inverted references");
    traits.add(plan.moves(), "with motion vectors");
    let moving: Vec<(i32, i32)> = (0..planes)
        .filter(|&plane| plan.reference(plane).is_some())
        .map(|plane| {
            let at = |list: &[i32]| list.get(plane).copied().unwrap_or_default();
            (at(&plan.motion_x), at(&plan.motion_y))
        })
        .collect();
    traits.add(
        plan.moves() && moving.iter().any(|(x, y)| x % 2 != 0 || y % 2 != 0),
        "with motion vectors of half texels",
    );
    traits.add(
        plan.moves() && moving.iter().any(|(x, y)| *x < 0 || *y < 0),
        "with motion vectors below zero",
    );
    let farthest = moving.iter().map(|(x, y)| x.abs().max(y.abs())).max();
    let farthest = farthest.filter(|_| plan.moves()).unwrap_or_default();
    let behind = |plane: &usize| plan.reference(*plane);
    let deepest = (0..planes).map(|plane| {
        std::iter::successors(Some(plane), behind)
            .take(planes)
            .count()
    });
    traits.numbers.extend([
        ("half texels of motion", i64::from(farthest)),
        (
            "planes in one chain of predictions",
            deepest.max().unwrap_or_default() as i64,
        ),
        (
            "as their largest rank",
            plan.order.iter().copied().max().unwrap_or_default(),
        ),
    ]);
    traits.add(
        plan.order
            .iter()
            .enumerate()
            .any(|(plane, &rank)| rank != plane as i64),
        "whose order is not 0, 1, 2 …",
    );
    traits.add(
        (0..planes).any(|plane| plan.reference(plane).is_some_and(|other| other > plane)),
        "in which a plane is predicted from one that is stored after it",
    );
    traits.add(
        (0..planes).any(|plane| {
            plan.reference(plane)
                .is_some_and(|other| plan.reference(other).is_some())
        }),
        "in which a predicted plane is a reference itself",
    );
    let records = witness
        .model()
        .and_then(|model| model.compressed.as_ref())
        .map(|compressed| &compressed.planes);
    let count = records.map_or(0, |planes| {
        planes.iter().map(|plane| plane.records.len()).sum()
    });
    let on = |predicted: bool| {
        records.is_some_and(|stored| {
            stored.iter().enumerate().any(|(plane, stored)| {
                !stored.records.is_empty() && plan.reference(plane).is_some() == predicted
            })
        })
    };
    traits.add(count > 0, "with side information");
    traits.add(count == 0, "without side information");
    traits.add(on(false), "with side information of intra planes");
    traits.add(on(true), "with side information of predicted planes");
    traits.add(
        coding == Some(Coding::JpegLs) && plan.parameter > 0,
        "with JPEG-LS planes of a parameter over 0",
    );
    traits.add(
        coding == Some(Coding::JpegLs) && plan.parameter == 0,
        "with JPEG-LS planes of parameter 0",
    );
    let stream = &plan.stream;
    traits.add(
        plan.alternates,
        "whose planes have streams of different kinds",
    );
    traits.add(
        stream.restart_interval > 0,
        "with restart markers in their JPEG streams",
    );
    traits.add(
        stream.optimised,
        "with Huffman tables of their own in their JPEG streams",
    );
    traits.add(
        !stream.baseline && coding == Some(Coding::Jpeg) && plan.parameter < 24,
        "with 16-bit quantisation tables (SOF1) in their JPEG streams",
    );
    traits.add(
        stream.sampling != (1, 1) && coding == Some(Coding::Jpeg),
        "with sampling factors other than 1x1 in their JPEG streams",
    );
    traits.add(
        stream.presets.is_some(),
        "with preset parameters (LSE) in their JPEG-LS streams",
    );
    traits
        .numbers
        .push(("records of side information", count as i64));
    if coding == Some(Coding::Jpeg) {
        traits
            .numbers
            .push(("as their JPEG quality", i64::from(plan.parameter)));
        if let Some(recipe) = witness.case.recipe()
            && stream.restart_interval > 0
        {
            let blocks = recipe.size.width.div_ceil(8) * recipe.size.height.div_ceil(8);
            let markers = (blocks - 1) / u32::from(stream.restart_interval);
            traits
                .numbers
                .push(("restart markers in one plane", i64::from(markers)));
        }
    } else {
        traits
            .numbers
            .push(("as their largest loss", i64::from(plan.parameter)));
    }
}
