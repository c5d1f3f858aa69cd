//! Properties that describe a set of files. Each was needed to describe the failures of a real decoder, or corresponds to a
//! `make:` key in the cases.

use std::borrow::Cow;
use std::str::FromStr;

use super::witness::{Facts, Property, Quantity, Witness};
use ptm::decode::compressed::Streams;
use ptm::decode::planes::{parse_records, side_information};
use ptm::parts::Extent;
use ptm::{Coding, Field, Format};
use ptm_generate::spelling::{Count, Line, Lists};
use ptm_generate::{INVERSION, MOTION, Recipe, plan::Compression, planes::StoredPlane};
use ptm_suite::protocol::frame::{Answer, View};

impl Witness<'_> {
    /// Returns the properties of the file, computed on first use.
    pub fn facts(&self) -> &Facts {
        self.facts.get_or_init(|| {
            let file = File::new(self);
            Facts {
                properties: (view_properties(&file).into_iter())
                    .chain(format_properties(&file))
                    .chain(spelling_properties(&file))
                    .chain(data_properties(&file))
                    .chain(prediction_properties(&file))
                    .chain(stream_properties(&file))
                    .collect(),
                quantities: quantities(&file),
            }
        })
    }
}

/// Parts of a file that the properties depend on.
struct File<'a> {
    view: &'a View,
    light: Option<(f64, f64)>,
    format: Format,
    size: Option<(u32, u32)>,
    recipe: Option<&'a Recipe>,
    plan: Option<Compression>,
    /// The compression parameter, as written in the file. It need not be one that a legal file may have.
    parameter: Option<f64>,
    planes: Cow<'a, [StoredPlane]>,
    /// The encoding options of the streams, if the file was generated.
    streams: Option<&'a Compression>,
    header: &'a [u8],
    data: &'a [u8],
    /// The scales, biases and matrix elements, as written in the file.
    numbers: [Vec<&'a str>; 3],
    /// The number of table entries, as written in the file.
    entries: Option<u32>,
    /// The bytes of the indices into the table.
    indices: &'a [u8],
}

impl<'a> File<'a> {
    fn new(witness: &'a Witness) -> File<'a> {
        let file = &witness.built.file;
        let (header, data) = file.split_at(witness.payload_offset().min(file.len()));
        let texts = |clause: &str| -> Vec<&str> {
            let fields = witness.fields().iter();
            let text = |field: &Field| std::str::from_utf8(&file[field.range.clone()]).ok();
            fields
                .filter(|field| field.clause == clause)
                .filter_map(text)
                .collect()
        };
        let mut fields = witness.fields().iter();
        let indices = fields.find(|field| field.clause == "2.8.1/1");
        let format = witness.case.format();
        let painted = witness.model().and_then(|model| model.compressed.as_ref());
        let planes = match painted {
            Some(compressed) => Cow::Borrowed(&compressed.planes[..]),
            None if format.coding().is_some() => Cow::Owned(read_planes(file)),
            None => Cow::Borrowed(&[][..]),
        };
        File {
            view: &witness.observation.view,
            light: match &witness.observation.view {
                View::Rgb(light) => Some((light.lu, light.lv)),
                _ => None,
            },
            format,
            size: match &witness.expected {
                Answer::Decoded(frame) => Some((frame.width, frame.height)),
                _ => None,
            },
            recipe: witness.case.recipe(),
            plan: read_plan(format, texts),
            parameter: texts("2.9.1/1").iter().find_map(|text| text.parse().ok()),
            planes,
            streams: witness.case.compression(),
            header,
            data,
            numbers: [texts("2.4/3"), texts("2.4/4"), texts("2.6/2")],
            entries: texts("2.5/2").iter().find_map(|text| text.parse().ok()),
            indices: indices.map_or(&[], |field| &file[field.range.clone()]),
        }
    }

    /// Returns the motion vectors by which references are displaced.
    fn vectors(&self) -> Vec<(i32, i32)> {
        let Some(plan) = &self.plan else {
            return Vec::new();
        };
        let get = |list: &[i32], plane: usize| list.get(plane).copied().unwrap_or_default();
        let is_displaced = |&plane: &usize| {
            let transform = plan.transforms.get(plane).copied().unwrap_or_default();
            plan.reference(plane).is_some() && transform & MOTION != 0
        };
        let displaced = (0..plan.order.len()).filter(is_displaced);
        let vector = |plane| (get(&plan.motion_x, plane), get(&plan.motion_y, plane));
        displaced.map(vector).collect()
    }
}

/// Reads the lists of a compressed file, without the parameter. Returns `None` for other formats and for lists with faults. `numbers`
/// returns the numbers of a list, as written in the file.
fn read_plan<'a>(format: Format, numbers: impl Fn(&str) -> Vec<&'a str>) -> Option<Compression> {
    fn list<T: FromStr>(texts: &[&str], count: usize) -> Option<Vec<T>> {
        let numbers: Option<Vec<T>> = texts.iter().map(|text| text.parse().ok()).collect();
        numbers.filter(|numbers| numbers.len() == count)
    }
    format.coding()?;
    let mut plan = Compression::default_for(format);
    let count = plan.order.len();
    plan.transforms = list(&numbers("2.9.2/1"), count)?;
    plan.motion_x = list(&numbers("2.9.3/1"), 2 * count)?;
    plan.motion_y = plan.motion_x.split_off(count);
    plan.order = list(&numbers("2.9.4/1"), count)?;
    plan.references = list(&numbers("2.9.5/1"), count)?;
    let exists = |&reference: &i64| reference < count as i64;
    plan.references.iter().all(exists).then_some(plan)
}

/// Reads the streams and records of a compressed file. Returns no planes if the reference refuses the file.
fn read_planes(file: &[u8]) -> Vec<StoredPlane> {
    let (_, _, streams) = ptm::decode::examine_streams(file);
    let Some(coded) = streams.as_ref().map(Streams::coded) else {
        return Vec::new();
    };
    let extents = coded.plan.extents.iter().enumerate();
    let plane = |(index, extent): (usize, &Extent)| {
        let block = side_information(&coded, index);
        StoredPlane {
            stream: coded.payload[extent.stream.clone()].to_vec(),
            records: parse_records(block, 0, coded.size.texels()).unwrap_or_default(),
        }
    };
    extents.map(plane).collect()
}

/// Number of properties that describe the requested view. These properties come first.
pub(super) const VIEW_PROPERTIES: usize = 3;

fn view_properties(f: &File) -> [Property; 6] {
    let light = |test: fn(f64, f64) -> bool| f.light.is_some_and(|(u, v)| test(u, v));
    let is_outside = light(|u, v| u * u + v * v > 1.0);
    [
        ("2.7/1 requested in view raw", *f.view == View::Raw),
        ("2.4/8 requested in view coef", *f.view == View::Coef),
        ("1.0/1 requested in view rgb", f.light.is_some()),
        (
            "1.0/2 requested under a light whose u is negative",
            light(|u, _| u < 0.0),
        ),
        (
            "1.0/2 requested under a light whose v is negative",
            light(|_, v| v < 0.0),
        ),
        (
            "1.0/2 requested under a light outside the unit circle",
            is_outside,
        ),
    ]
}

fn format_properties(f: &File) -> [Property; 6] {
    let coding = f.format.coding();
    let is_large = f.entries.is_some_and(|entries| entries > 256);
    [
        ("2.9/1 with compressed planes", coding.is_some()),
        ("2.7/1 without compressed planes", coding.is_none()),
        ("2.9.8/3 with JPEG planes", coding == Some(Coding::Jpeg)),
        (
            "2.9.8/3 with JPEG-LS planes",
            coding == Some(Coding::JpegLs),
        ),
        ("2.5/1 with a lookup table", f.format.has_table()),
        ("2.8.1/3 with a table of more than 256 entries", is_large),
    ]
}

fn spelling_properties(f: &File) -> [Property; 15] {
    let spelling = f.recipe.map(|recipe| &recipe.spelling);
    // True if the two items are on separate lines.
    let size = spelling.map(|s| s.size_on_two_lines);
    let numbers = spelling.map(|s| s.scale_bias_on_two_lines);
    let has_gap = spelling.is_some_and(|s| s.gap > 1);
    let spaces = spelling.map_or(&[][..], |s| &s.space_before_newline);
    let has = |line: Line| spaces.contains(&line);
    let is_split = f.format == Format::Lum && spelling.is_some_and(|s| s.matrix_line < 16);
    let is_bare = f.format.has_table() && spelling.is_some_and(|s| s.count == Count::Number);
    let has_lists = f.format.coding().is_some();
    let has_other_lists = has_lists && spelling.is_some_and(|s| s.lists != Lists::default());
    [
        (
            "2.3/1 with width and height on one line",
            size == Some(false),
        ),
        (
            "2.3/2 with width and height on two lines",
            size == Some(true),
        ),
        (
            "2.4/6 with scales and biases on one line",
            numbers == Some(false),
        ),
        (
            "2.4/6 with scales and biases on two lines",
            numbers == Some(true),
        ),
        ("2.4/5 with several spaces between two numbers", has_gap),
        ("2.0/2 with a space before a line feed", !spaces.is_empty()),
        ("2.0/2 with a space after the version", has(Line::Version)),
        ("2.0/2 with a space after the format", has(Line::Format)),
        ("2.0/2 with a space after the width", has(Line::Width)),
        ("2.0/2 with a space after the height", has(Line::Height)),
        ("2.4/7 with a space after the scales", has(Line::Scale)),
        ("2.4/7 with a space after the biases", has(Line::Bias)),
        ("2.6/2 with the matrix on several lines", is_split),
        ("2.5/2 with an entry count that is a bare number", is_bare),
        (
            "2.9/2 with one list on several lines or several lists on one line",
            has_other_lists,
        ),
    ]
}

fn data_properties(f: &File) -> [Property; 27] {
    let [scales, biases, _] = &f.numbers;
    let value = |text: &str| text.parse().unwrap_or(0.0);
    let is_negative = |texts: &[&str]| texts.iter().any(|text| value(text) < 0.0);
    let has_minus = |texts: &[&str]| texts.iter().any(|text| text.starts_with('-'));
    let any = |test: fn(&str) -> bool| f.numbers.iter().flatten().any(|text| test(text));
    let has_outer_point =
        any(|text| text.trim_start_matches(['+', '-']).starts_with('.') || text.ends_with('.'));
    let has_point = any(|text| text.contains('.'));
    let is_scientific = any(|text| text.contains(['e', 'E']));
    let has_negative_exponent = any(|text| text.contains("e-") || text.contains("E-"));
    let has_bare_exponent = any(|text| {
        let (_, exponent) = text.split_once(['e', 'E']).unwrap_or_default();
        exponent.starts_with(|first: char| first.is_ascii_digit())
    });
    let has_point_and_exponent = any(|text| text.contains('.') && text.contains(['e', 'E']));
    let has_exponent_alone = any(|text| !text.contains('.') && text.contains(['e', 'E']));
    let has_plus_in_exponent = any(|text| text.contains("e+") || text.contains("E+"));
    let has_plus = any(|text| text.starts_with('+'));
    let is_space = matches!(f.data, [9..=13 | b' ', ..]);
    let is_line_feed = f.data.starts_with(b"\n");
    let (width, height) = f.size.unwrap_or_default();
    let is_ragged = width % 4 != 0 && height > 1;
    [
        ("2.4/4 with a negative bias", is_negative(biases)),
        ("2.4/3 with a negative scale", is_negative(scales)),
        ("2.4/4 with a minus sign in a bias", has_minus(biases)),
        ("2.4/3 with a minus sign in a scale", has_minus(scales)),
        ("2.4/3 with a decimal point in a number", has_point),
        (
            "2.0/1 with a byte of 0x80 or more in the header",
            f.header.iter().any(|&byte| byte >= 0x80),
        ),
        (
            "2.7/1 with a byte of 0x80 or more in the binary data",
            f.data.iter().any(|&byte| byte >= 0x80),
        ),
        (
            "2.8.1/1 with a byte of 0x80 or more in an index",
            f.indices.iter().any(|&byte| byte >= 0x80),
        ),
        ("2.4/3 with a number in scientific notation", is_scientific),
        (
            "2.4/3 with a negative exponent in a number",
            has_negative_exponent,
        ),
        ("2.4/3 with a number that starts with a plus sign", has_plus),
        (
            "2.4/3 with a plus sign in an exponent",
            has_plus_in_exponent,
        ),
        (
            "2.4/3 with an exponent without a sign in a number",
            has_bare_exponent,
        ),
        (
            "2.4/3 with a decimal point and an exponent in one number",
            has_point_and_exponent,
        ),
        (
            "2.4/3 with an exponent and no decimal point in one number",
            has_exponent_alone,
        ),
        (
            "2.4/3 with a number that starts or ends with its decimal point",
            has_outer_point,
        ),
        (
            "2.0/2 with whitespace at the start of the binary data",
            is_space,
        ),
        (
            "2.0/2 with a line feed at the start of the binary data",
            is_line_feed,
        ),
        (
            "2.7/1 with a line feed at the end of the binary data",
            f.data.ends_with(b"\n"),
        ),
        ("2.3/1 of one row or one column", width == 1 || height == 1),
        ("2.3/1 of one row", height == 1),
        ("2.3/1 of odd width", width % 2 == 1),
        ("2.3/1 of odd height", height % 2 == 1),
        ("2.3/1 of even width", width > 0 && width % 2 == 0),
        ("2.3/1 of even height", height > 0 && height % 2 == 0),
        (
            "2.3/1 with an odd number of texels",
            width % 2 == 1 && height % 2 == 1,
        ),
        (
            "2.7/2 with several rows and a width that is not a multiple of 4",
            is_ragged,
        ),
    ]
}

fn prediction_properties(f: &File) -> [Property; 18] {
    let plan = f.plan.as_ref();
    let has = |test: fn(&Compression) -> bool| plan.is_some_and(test);
    let vectors = f.vectors();
    let is_half = vectors.iter().any(|(x, y)| (x | y) & 1 == 1);
    let is_negative = vectors.iter().any(|(x, y)| *x < 0 || *y < 0);
    let is_transformed = has(|plan| plan.transforms.iter().any(|&transform| transform != 0));
    let is_both = has(|plan| plan.transforms.contains(&3));
    let planes = plan.map_or(0, |plan| plan.order.len());
    let is_reordered = has(|plan| (0..).zip(&plan.order).any(|(plane, &rank)| rank != plane));
    let reference = |plane: usize| plan.and_then(|plan| plan.reference(plane));
    let is_later = (0..planes).any(|p| reference(p).is_some_and(|other| other > p));
    let is_chained = (0..planes).any(|p| reference(p).and_then(reference).is_some());
    let has_records = |plane: usize| !f.planes[plane].records.is_empty();
    let corrected = || (0..f.planes.len()).filter(|&plane| has_records(plane));
    let is_corrected = corrected().next().is_some();
    let unneeded = is_corrected && f.parameter == Some(0.0);
    let displaces = has(Compression::displaces);
    let inverts = has(Compression::inverts);
    let corrects_intra = corrected().any(|plane| reference(plane).is_none());
    let corrects_predicted = corrected().any(|plane| reference(plane).is_some());
    let transform = |plane: usize| plan.map_or(0, |plan| plan.transforms[plane]);
    let is_inverted =
        |plane: usize| reference(plane).is_some() && transform(plane) & INVERSION != 0;
    let corrects_inverted = corrected().any(is_inverted);
    let mut intra = (0..planes).filter(|&plane| reference(plane).is_none());
    let has_idle_transform = intra.clone().any(|plane| transform(plane) != 0);
    let has_late_intra = intra.any(|plane| plan.is_some_and(|plan| plan.order[plane] != 0));
    let color = |plane: usize| (planes == 18).then_some(plane / 6);
    let mixes_colors =
        (0..planes).any(|p| reference(p).is_some_and(|other| color(p) != color(other)));
    [
        ("2.9.5/4 with predicted planes", has(Compression::predicts)),
        ("2.9.2/1 with a transform other than 0", is_transformed),
        ("2.9.2/3 with inverted references", inverts),
        (
            "2.9.2/1 with a transform other than 0 for an intra-coded plane",
            has_idle_transform,
        ),
        (
            "2.9.2/4 with motion compensation in a predicted plane",
            displaces,
        ),
        ("2.9.2/1 with a transform of 3", is_both),
        ("2.9.3/5 with references displaced by half texels", is_half),
        (
            "2.9.3/2 with references displaced by a negative vector",
            is_negative,
        ),
        ("2.9.4/1 with an order other than 0, 1, 2, …", is_reordered),
        (
            "2.9.4/1 with an order other than 0 for an intra-coded plane",
            has_late_intra,
        ),
        (
            "2.9.5/1 with prediction from a plane of another color",
            mixes_colors,
        ),
        ("2.9.4/2 with prediction from a later plane", is_later),
        ("2.9.4/2 with prediction from a predicted plane", is_chained),
        ("2.9.8/4 with side information", is_corrected),
        ("2.9.8/4 with side information and parameter 0", unneeded),
        (
            "2.9.8/7 with side information for intra-coded planes",
            corrects_intra,
        ),
        (
            "2.9.8/7 with side information for predicted planes",
            corrects_predicted,
        ),
        (
            "2.9.8/7 with side information for planes with inverted references",
            corrects_inverted,
        ),
    ]
}

fn stream_properties(f: &File) -> [Property; 8] {
    let has = |test: fn(&Compression) -> bool| f.streams.is_some_and(test);
    let is_jpeg = f.format.coding() == Some(Coding::Jpeg);
    let is_zero = has(|plan| plan.parameter == 0);
    let is_wide = is_jpeg && has(|plan| !plan.stream.jpeg.baseline && plan.parameter < 24);
    let is_near_lossless =
        f.format.coding() == Some(Coding::JpegLs) && has(|plan| plan.parameter > 0);
    let has_restarts = has(|plan| plan.stream.jpeg.restart_interval > 0);
    let is_joint = has(|plan| plan.stream.jpeg.tables_together);
    let has_factors = is_jpeg && has(|plan| plan.stream.jpeg.sampling != (1, 1));
    let has_presets = has(|plan| plan.stream.presets.is_some());
    let has_zero_preset = has(|plan| {
        let presets = plan.stream.presets;
        presets.is_some_and(|all| [all.maxval, all.t1, all.t2, all.t3, all.reset].contains(&0))
    });
    [
        ("2.9.1/2 with a compression parameter of 0", is_zero),
        (
            "2.9.8/3 with near-lossless streams (NEAR over 0)",
            is_near_lossless,
        ),
        ("2.9.8/3 with restart markers", has_restarts),
        (
            "2.9.8/3 with several tables in one marker segment",
            is_joint,
        ),
        ("2.9.8/3 with 16-bit quantization tables", is_wide),
        ("2.9.8/3 with sampling factors other than 1x1", has_factors),
        ("2.9.8/3 with preset parameters (LSE)", has_presets),
        (
            "2.9.8/3 with a zero among the preset parameters (LSE)",
            has_zero_preset,
        ),
    ]
}

fn quantities(f: &File) -> Vec<Quantity> {
    let size = f
        .size
        .map(|(width, height)| (f64::from(width), f64::from(height)));
    let lines = f.header.split(|&byte| byte == b'\n').map(<[u8]>::len);
    let longest = lines.max().map(|longest| longest as f64);
    let rank = f.plan.iter().flat_map(|plan| &plan.order).max();
    let rank = rank.map(|&rank| rank as f64);
    let motion = f.vectors().iter().map(|(x, y)| x.abs().max(y.abs())).max();
    let records = f.planes.iter().map(|plane| plane.records.len()).max();
    let positions = f.planes.iter().flat_map(|plane| &plane.records);
    let position = positions.map(|record| record.0).max().map(f64::from);
    let parameter = |coding: Coding| f.parameter.filter(|_| f.format.coding() == Some(coding));
    let loss = parameter(Coding::JpegLs);
    let distance = f.light.map(|(u, v)| u.hypot(v));
    let texels = size.map(|(width, height)| width * height);
    let (width, height) = size.unzip();
    let side = size.map(|(width, height)| width.max(height));
    let entries = f.entries.map(f64::from);
    let numbers = f.numbers.iter().flatten().map(|text| text.len());
    let longest_number = numbers.max().map(|longest| longest as f64);
    let [header, data] = [f.header, f.data].map(|part| part.len() as f64);
    vec![
        ("2.7/3", "whose number of texels is {}", texels),
        ("2.3/1", "whose width is {}", width),
        ("2.3/1", "whose height is {}", height),
        ("2.3/1", "whose larger side is {}", side),
        ("2.0/1", "of {} bytes", Some(header + data)),
        ("2.7/1", "with {} bytes of binary data", Some(data)),
        ("2.0/1", "with {} bytes of header", Some(header)),
        ("2.4/3", "with a number of {} characters", longest_number),
        ("2.0/1", "with {} bytes in one line of the header", longest),
        ("2.5/2", "whose number of table entries is {}", entries),
        ("2.9.4/3", "whose largest rank is {}", rank),
        (
            "2.9.3/1",
            "with references displaced by {} half texels",
            motion.map(f64::from),
        ),
        (
            "2.9.8/4",
            "with {} records in one plane",
            records.map(|n| n as f64),
        ),
        ("2.9.8/5", "with a record whose position is {}", position),
        ("2.9.1/1", "of JPEG quality {}", parameter(Coding::Jpeg)),
        ("2.9.1/1", "whose maximum loss is {}", loss),
        (
            "1.0/2",
            "requested under a light where |(u, v)| is {}",
            distance,
        ),
    ]
}
