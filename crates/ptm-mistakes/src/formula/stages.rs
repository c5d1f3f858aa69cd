//! The stages of decoding from stored bytes to an image, in terms of formulas.
//!
//! A formula without an edit is computed by the corresponding function of the [`Reading`]. Edits can therefore be combined with
//! other readings of the open questions, and with misreadings that are implemented as functions.

use std::borrow::Cow;
use std::cell::Cell;
use std::ops::RangeInclusive;

use super::edit::{Edit, EditedForm};
use super::expression::{Expression, Function, index_of};
use super::formulas::{Formula, Stage};
pub use ptm::decode::{self, Streams, decode_as};
use ptm::error::{Error, Kind, Result};
use ptm::evaluate::{self, Coefficients, RelitImage};
use ptm::input::Input;
use ptm::parts::{Coded, RawLists, Step};
use ptm::reading::Reading;
use ptm::{Coding, Header, Limits, Planes, Ptm, Shape, Size, Storage};

/// Edits that a decoder makes, at most one per formula.
#[derive(Clone, Copy)]
pub struct Edits<'a>(pub &'a [&'a Edit]);

impl Edits<'_> {
    fn change(&self, formula: Formula) -> Option<&EditedForm> {
        let mut edits = self.0.iter();
        let edit = edits.find(|edit| edit.formula == formula);
        edit.map(|edit| &edit.change)
    }

    fn edits_any(&self, formulas: RangeInclusive<Formula>) -> bool {
        self.0.iter().any(|edit| formulas.contains(&edit.formula))
    }

    fn is_edited(&self, formula: Formula) -> bool {
        self.change(formula).is_some()
    }

    fn has_stage(&self, stage: Stage) -> bool {
        self.0.iter().any(|edit| edit.formula.stage() == stage)
    }

    /// Evaluates the edit of a formula, or the stated formula if there is no edit.
    fn value(&self, formula: Formula, variables: &[f64], lists: &[&[f64]]) -> f64 {
        let stated = || formula.stated().expression.value(variables, lists);
        self.edited_value(formula, variables, lists)
            .unwrap_or_else(stated)
    }

    /// Evaluates the edit of a formula, or calls `unedited` if there is no edit.
    fn value_or(&self, formula: Formula, variables: &[f64], unedited: impl FnOnce() -> f64) -> f64 {
        let edited_value = self.edited_value(formula, variables, &[]);
        edited_value.unwrap_or_else(unedited)
    }

    fn edited_value(&self, formula: Formula, variables: &[f64], lists: &[&[f64]]) -> Option<f64> {
        self.change(formula).map(|change| match change {
            EditedForm::Expression(expression) => expression.value(variables, lists),
            EditedForm::Table(table) => f64::from(table[usize::from(to_byte(variables[0]))]),
        })
    }
}

/// Converts a value to a byte: `floor(value) mod 256`.
fn to_byte(value: f64) -> u8 {
    value.floor().rem_euclid(256.0) as u8
}

/// What a decoder does at an edited position outside the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// It refuses the file.
    Refused,
    /// It finds this byte.
    Byte(u8),
    /// It finds nothing, so that all later values move up, and the last ones are 0. A slice of a JavaScript or Python array ends
    /// with the data.
    Nothing,
}

/// Decodes a file with edited formulas. A byte or sample at an edited position outside the data is `outside`.
///
/// # Errors
/// Returns the violated clause, the byte offset, and what was found there.
pub fn decode(file: &[u8], reading: &Reading, edits: Edits, outside: Outside) -> Result<Ptm> {
    match edits.has_stage(Stage::Decoding) {
        true => decode_stages(file, reading, edits, outside),
        false => decode_as(file, reading, &Limits::default()),
    }
}

/// Computes the stored values of a decoded map with edited formulas.
#[must_use]
pub fn stored_values<'a>(ptm: &'a Ptm, edits: Edits) -> Cow<'a, Ptm> {
    let mut ptm = Cow::Borrowed(ptm);
    if edits.is_edited(Formula::ValueChannel) {
        write_to_channels(&mut ptm.to_mut().planes, edits);
    }
    if edits.is_edited(Formula::StoredValue) {
        let planes = &mut ptm.to_mut().planes;
        let (size, channels) = (planes.size, planes.shape.channels());
        for (k, sample) in planes.samples.iter_mut().enumerate() {
            let [i, c] = coefficient_index(k % channels);
            let [row, t] = stored_position(size, k / channels);
            let [n, height] = [size.texels() as f64, f64::from(size.height)];
            let variables = [f64::from(*sample), i, c, t, n, row, height];
            *sample = to_byte(edits.value(Formula::StoredValue, &variables, &[]));
        }
    }
    ptm
}

/// Returns the stored row of an image texel, and its number in stored order, bottom row first.
fn stored_position(size: Size, texel: usize) -> [f64; 2] {
    let width = size.width as usize;
    let row = size.height as usize - 1 - texel / width;
    [row, row * width + texel % width].map(|number| number as f64)
}

/// Writes each value to an edited channel, as a decoder does that copies the values of one texel after the other, in stored order. A
/// channel may be one of another texel. Later values overwrite earlier ones, and a channel that is never written is 0.
fn write_to_channels(planes: &mut Planes, edits: Edits) {
    let (width, channels) = (planes.size.width as usize, planes.shape.channels());
    let offset = |channel| edits.value(Formula::ValueChannel, &coefficient_index(channel), &[]);
    let offsets: Vec<f64> = (0..channels).map(offset).collect();
    let mut written = vec![0; planes.samples.len()];
    for row in planes
        .samples
        .chunks_exact(width * channels)
        .enumerate()
        .rev()
    {
        let (y, values) = row;
        for (k, &value) in values.iter().enumerate() {
            let texel = y * width + k / channels;
            let address = (texel * channels) as f64 + offsets[k % channels];
            write_at(&mut written, address, value);
        }
    }
    planes.samples = written;
}

/// Returns the indices of a coefficient and of its polynomial. Colors, Cr and Cb count as coefficients of a second polynomial.
fn coefficient_index(channel: usize) -> [f64; 2] {
    [channel % 6, channel / 6].map(|number| number as f64)
}

fn decode_stages(file: &[u8], reading: &Reading, edits: Edits, outside: Outside) -> Result<Ptm> {
    let mut input = Input::new(file);
    let header = decode::read_header(&mut input)?;
    // Edits of formulas that the format does not use change nothing.
    let mut formulas = edits.0.iter().map(|edit| edit.formula);
    if !formulas.any(|formula| formula.is_used_by(header.format)) {
        return decode_as(file, reading, &Limits::default());
    }
    let shape = header.format.shape();
    let shape = shape.with_matrix(|| decode::color_matrix::read(&mut input))?;
    let texels = TexelLayout {
        file,
        header: &header,
        reading,
        edits,
        outside,
    };
    // A texel has at least one byte, so an edited address cannot turn a small file into a large image.
    let max_texels = input.rest().len() as u64;
    if header.format.coding().is_none() && header.size.bytes(1) > max_texels {
        return Err(outside_data_error(input.at()));
    }
    let has_groups = edits.edits_any(Formula::GroupSize..=Formula::GroupEnd);
    let samples = match header.format.storage() {
        Storage::Texels | Storage::Table | Storage::ColorTable if has_groups => {
            texels.samples_of_groups(&mut input)?
        }
        Storage::Texels => texels.samples_of_blocks(&input)?,
        Storage::Table | Storage::ColorTable => texels.samples_of_table(&mut input)?,
        Storage::Streams(coding) => {
            let limits = Limits::default();
            let streams = Streams::read(&header, coding, &mut input, reading, &limits)?;
            let planes = CompressedPlanes {
                coded: streams.coded(),
                lists: &streams.lists,
                reading,
                edits,
                outside,
            };
            texels.samples_of_planes(&planes.decode(streams.residuals())?)?
        }
    };
    let planes = Planes {
        size: header.size,
        shape,
        samples,
    };
    Ok(Ptm { header, planes })
}

/// Layout of a file, which determines the address of each value.
struct TexelLayout<'a> {
    file: &'a [u8],
    header: &'a Header,
    reading: &'a Reading,
    edits: Edits<'a>,
    outside: Outside,
}

fn outside_data_error(offset: usize) -> Error {
    let kind = Kind::Short {
        what: "the addressed values",
        needed: 1,
        remaining: 0,
    };
    Error::new("2.7/3", offset, kind)
}

fn element_at<T>(data: &[T], address: f64) -> Result<&T> {
    let found = index_of(address).and_then(|address| data.get(address));
    found.ok_or_else(|| outside_data_error(0))
}

/// Returns the bytes in a range, as far as they are in the data. As in JavaScript and Python, a negative position counts from the end.
fn slice(data: &[u8], from: f64, to: f64) -> &[u8] {
    let length = data.len() as f64;
    let [from, to] = [from, to].map(|position| {
        let position = if position < 0.0 {
            position + length
        } else {
            position
        };
        position.clamp(0.0, length) as usize
    });
    data.get(from..to).unwrap_or_default()
}

/// Maximum number of bytes of an index whose size is computed with an edited formula.
const MAX_INDEX_BYTES: f64 = 8.0;

/// Returns the value at an address, or what `outside` says if the address is an integer outside the data.
fn value_at(data: &[u8], address: f64, outside: Outside) -> Result<Option<u8>> {
    match (element_at(data, address), outside) {
        (Err(_), Outside::Byte(value)) if address.fract() == 0.0 => Ok(Some(value)),
        (Err(_), Outside::Nothing) if address.fract() == 0.0 => Ok(None),
        (found, _) => found.copied().map(Some),
    }
}

impl TexelLayout<'_> {
    fn size(&self) -> [f64; 2] {
        let Size { width, height } = self.header.size;
        [f64::from(width), f64::from(height)]
    }

    /// Collects the samples of the image in order. Calls `sample` with the stored row, the stored column, and the channel.
    fn collect(
        &self,
        mut sample: impl FnMut(f64, f64, usize) -> Result<Option<u8>>,
    ) -> Result<Vec<u8>> {
        let edits = self.edits;
        let [width, height] = self.size();
        let channels = self.header.format.channels();
        let total = self.header.size.texels() * channels;
        let mut samples = Vec::with_capacity(total);
        // If values move up, the texels after the last one of the image are read, too.
        let is_edited = edits.is_edited(Formula::StoredTexel);
        let times = if is_edited && self.outside == Outside::Nothing {
            2.0
        } else {
            1.0
        };
        let mut texel = [0.0, 0.0, width, height];
        while samples.len() < total && texel[1] < times * height {
            let [x, y, ..] = texel;
            let (stored_row, stored_column) = if is_edited {
                let variables = [x, y, width, height, y * width + x];
                let t = edits.value(Formula::StoredTexel, &variables, &[]);
                if y >= height && t < 0.0 {
                    break;
                }
                // A texel before the first is in the same row.
                let stored_row = (t / width).floor().max(0.0);
                (stored_row, t - stored_row * width)
            } else {
                let unedited = || (self.reading.stored_row)(self.header, y as usize) as f64;
                let stored_row = edits.value_or(Formula::StoredRow, &texel, unedited);
                let stored_column = edits.value_or(Formula::StoredColumn, &texel, || x);
                (stored_row, stored_column)
            };
            for channel in 0..channels {
                samples.extend(if is_edited && stored_column.is_nan() {
                    Some(0)
                } else {
                    sample(stored_row, stored_column, channel)?
                });
            }
            let is_last = x + 1.0 == width;
            texel[0] = if is_last { 0.0 } else { x + 1.0 };
            texel[1] = if is_last { y + 1.0 } else { y };
        }
        samples.resize(total, 0);
        Ok(samples)
    }

    /// Returns the address of a value in the payload. `table` contains the number of entries, their size and the
    /// number of bytes per index.
    fn address_of(&self, formula: Formula, pos: [f64; 2], channel: usize, table: [f64; 3]) -> f64 {
        let [row, x] = pos;
        let [width, height] = self.size();
        let [i, c] = match formula {
            Formula::LumSample | Formula::LrgbPlane => [channel as f64, 0.0],
            _ => coefficient_index(channel),
        };
        // Index of the color in a texel, or of the byte in an index.
        let k = match formula {
            Formula::IndexByte => channel,
            _ => channel.saturating_sub(6),
        };
        let [entries, size, bytes] = table;
        let variables = [row, x, width, height, i, c, k as f64, entries, size, bytes];
        let address = self.edits.value(formula, &variables, &[]);
        if !self.edits.is_edited(Formula::BlockLength) {
            return address;
        }
        let texels = width * height;
        let earlier_blocks: &[(f64, [f64; 2])] = match formula {
            Formula::RgbSample => &[(c, [texels, 6.0])],
            Formula::LrgbColor => &[(1.0, [texels, 6.0])],
            Formula::IndexByte => &[(1.0, [entries, size])],
            Formula::TableColor => &[(1.0, [entries, size]), (1.0, [texels, bytes])],
            _ => &[],
        };
        let shifts = earlier_blocks.iter().map(|(number, block)| {
            let length = self.edits.value(Formula::BlockLength, block, &[]);
            number * (length - block[0] * block[1])
        });
        address + shifts.sum::<f64>()
    }

    fn samples_of_blocks(&self, input: &Input) -> Result<Vec<u8>> {
        let start = input.at() as f64;
        let start = self.edits.value(Formula::TexelStart, &[start], &[]);
        self.collect(|row, column, channel| {
            let formula = match self.header.format.shape() {
                Shape::Rgb => Formula::RgbSample,
                Shape::Lum(()) => Formula::LumSample,
                Shape::Lrgb if channel < 6 => Formula::LrgbCoefficient,
                Shape::Lrgb => Formula::LrgbColor,
            };
            let address = self.address_of(formula, [row, column], channel, [0.0; 3]);
            // A position before the payload is in the header.
            value_at(self.file, start + address, self.outside)
        })
    }

    fn samples_of_table(&self, input: &mut Input) -> Result<Vec<u8>> {
        let count = (self.reading.entry_count)(input)?;
        let entry_size = self.header.format.entry_size();
        let start = input.at();
        input.take(
            "2.5/3",
            "the table's entries",
            count as u64 * entry_size as u64,
        )?;
        // An optional line feed after the table is not part of the data.
        let to_end_of_table = &self.file[..input.at()];
        (self.reading.after_table)(input)?;
        let data = [to_end_of_table, input.rest()].concat();
        let byte_at = |address: f64| value_at(&data, start as f64 + address, self.outside);
        let (entries, size) = (count as f64, entry_size as f64);
        let bytes = self.address_of(Formula::IndexSize, [0.0; 2], 0, [entries, size, 0.0]);
        // The end of the data does not limit an index if bytes outside have a value.
        if bytes > MAX_INDEX_BYTES {
            return Err(outside_data_error(start));
        }
        let layout = [entries, size, bytes];
        let last = Cell::new((f64::NAN, f64::NAN, 0.0));
        let may_be_outside =
            |index: usize| index >= count && matches!(self.outside, Outside::Byte(_));
        let index_at = |row: f64, column: f64| -> Result<f64> {
            if last.get().0 == row && last.get().1 == column {
                return Ok(last.get().2);
            }
            let stored = |k| byte_at(self.address_of(Formula::IndexByte, [row, column], k, layout));
            let stored = (0..bytes as usize)
                .map(stored)
                .collect::<Result<Vec<Option<u8>>>>()?;
            let stored: Vec<u8> = stored.into_iter().flatten().collect();
            let digit = |k: usize| stored.get(k).map_or(0.0, |&digit| f64::from(digit));
            let unedited = || (self.reading.index)(&stored) as f64;
            let variables = [digit(0), digit(1), entries];
            // The formula only applies to indices of two bytes.
            let index = match stored.len() {
                0 if bytes > 0.0 => 0.0,
                1 => unedited(),
                _ => self.edits.value_or(Formula::Index, &variables, unedited),
            };
            // An edited index retains its fraction and its sign, so that its address is refused.
            let entry = match index_of(index) {
                // Only an index past the table may find any byte. Others are refused because a mistake refuses them.
                Some(whole) => (self.reading.entry)(whole, count)
                    .map(|entry| entry as f64)
                    .or_else(|| may_be_outside(whole).then_some(index))
                    .ok_or_else(|| outside_data_error(0))?,
                None => index,
            };
            last.set((row, column, entry));
            Ok(entry)
        };
        self.collect(|row, column, channel| {
            let address = match channel < entry_size {
                true => {
                    let variables = [index_at(row, column)?, channel as f64, size, entries];
                    self.edits.value(Formula::TableSample, &variables, &[])
                }
                false => self.address_of(Formula::TableColor, [row, column], channel, layout),
            };
            byte_at(address)
        })
    }

    /// Collects the samples of the image texel by texel, each from a *group* of bytes in every block, as a decoder does that takes
    /// slices: a group ends with the file at the latest, and groups of another size move all values that follow.
    fn samples_of_groups(&self, input: &mut Input) -> Result<Vec<u8>> {
        let (edits, format, size) = (self.edits, self.header.format, self.header.size);
        let texels = size.texels();
        let entries = match format.has_table() {
            true => (self.reading.entry_count)(input)?,
            false => 0,
        };
        let index_size = if entries <= 256 { 1 } else { 2 };
        let stated: &[(usize, usize)] = match format.shape() {
            Shape::Rgb => &[(texels, 6); 3],
            Shape::Lum(()) => &[(texels, 8)],
            Shape::Lrgb => match format.storage() {
                Storage::Table => &[(entries, 6), (texels, index_size), (texels, 3)],
                Storage::ColorTable => &[(entries, 9), (texels, index_size)],
                _ => &[(texels, 6), (texels, 3)],
            },
        };
        let mut blocks = Vec::new();
        for (b, &(count, size)) in stated.iter().enumerate() {
            let size_of = |count: usize| {
                let variables = [size, count, b].map(|number| number as f64);
                edits.value(Formula::GroupSize, &variables, &[])
            };
            let edited = size_of(count);
            // If a group has as many bytes as there are texels, their two numbers are exchanged, and the block has the same size.
            let is_exchanged = edited != size_of(count + 1);
            let group_size = if is_exchanged { size as f64 } else { edited };
            blocks.push((input.at() as f64, edited));
            input.take("2.7/3", "the block", (count as f64 * group_size) as u64)?;
            if b == 0 && format.has_table() {
                (self.reading.after_table)(input)?;
            }
        }
        let group = |b: usize, t: usize| {
            let (start, size) = blocks[b];
            let variables = [t as f64, size];
            let [from, to] = [Formula::GroupStart, Formula::GroupEnd]
                .map(|formula| start + edits.value(formula, &variables, &[]));
            slice(self.file, from, to)
        };
        let entry = |t: usize| -> Result<&[u8]> {
            let digits = group(1, t);
            let (low, high) = digits.split_at(digits.len().min(4));
            let index = low
                .iter()
                .rev()
                .fold(0, |index, &byte| index * 256 + usize::from(byte));
            match index < entries && high.iter().all(|&byte| byte == 0) {
                true => Ok(group(0, index)),
                false => Err(outside_data_error(input.at())),
            }
        };
        let total = texels * format.channels();
        let mut samples = Vec::with_capacity(total);
        for y in 0..size.height as usize {
            let row = (self.reading.stored_row)(self.header, y);
            for x in 0..size.width as usize {
                let t = row * size.width as usize + x;
                for b in 0..blocks.len() {
                    let bytes = match (format.has_table(), b) {
                        (true, 0) => entry(t)?,
                        (true, 1) => continue,
                        _ => group(b, t),
                    };
                    let left = total - samples.len();
                    samples.extend(&bytes[..bytes.len().min(left)]);
                }
            }
        }
        samples.resize(total, 0);
        Ok(samples)
    }

    fn samples_of_planes(&self, planes: &[Vec<u8>]) -> Result<Vec<u8>> {
        let formula = match self.header.format.channels() {
            18 => Formula::RgbPlane,
            _ => Formula::LrgbPlane,
        };
        let plane_of = |channel| {
            let index = self.address_of(formula, [0.0; 2], channel, [0.0; 3]);
            element_at(planes, index)
        };
        let planes: Vec<&Vec<u8>> = (0..planes.len()).map(plane_of).collect::<Result<_>>()?;
        let [width, height] = self.size();
        self.collect(|row, column, channel| {
            let is_inside = row >= 0.0 && row < height && column >= 0.0 && column < width;
            let address = if is_inside {
                row * width + column
            } else {
                -1.0
            };
            value_at(planes[channel], address, self.outside)
        })
    }
}

/// Planes of a compressed file, before their rows are flipped.
struct CompressedPlanes<'a> {
    coded: Coded<'a>,
    lists: &'a RawLists,
    reading: &'a Reading,
    edits: Edits<'a>,
    outside: Outside,
}

impl CompressedPlanes<'_> {
    fn decode<'r>(
        &self,
        residuals: impl Iterator<Item = (usize, &'r [u8])>,
    ) -> Result<Vec<Vec<u8>>> {
        let mut coded = self.coded.blank_planes();
        let mut uncorrected = self.coded.blank_planes();
        let mut planes = self.coded.blank_planes();
        let mut previous = vec![0; self.coded.size.texels()];
        for (p, residuals) in residuals {
            let step = self.edited_step(p)?;
            let mut plane = self.stream_samples(p, residuals, step.reference.is_some());
            coded[p].clone_from(&plane);
            if let Some(reference) = step.reference {
                let sources = [
                    &planes[reference],
                    &uncorrected[reference],
                    &coded[reference],
                    &previous,
                ];
                let predictor = self.predictor(&sources, &step)?;
                self.add_predictor(&mut plane, &predictor, &step);
            }
            uncorrected[p].clone_from(&plane);
            self.correct(p, &mut plane, &coded[p], step.reference.is_some())?;
            previous.clone_from(&plane);
            planes[p] = plane;
        }
        Ok(planes)
    }

    fn stream_samples(&self, p: usize, residuals: &[u8], predicted: bool) -> Vec<u8> {
        let mut samples = residuals.to_vec();
        if self.edits.is_edited(Formula::StreamSample) {
            for sample in &mut samples {
                let variables = [f64::from(*sample), p as f64, f64::from(u8::from(predicted))];
                *sample = to_byte(self.edits.value(Formula::StreamSample, &variables, &[]));
            }
        }
        samples
    }

    fn edited_step(&self, p: usize) -> Result<Step> {
        let default = self.coded.plan.steps[p];
        if !self
            .edits
            .edits_any(Formula::Transform..=Formula::Reference)
        {
            return Ok(default);
        }
        let raw = self.lists;
        let lists = [&raw.transforms, &raw.motion, &raw.references];
        let lists = lists
            .map(|list| -> Vec<f64> { list.iter().map(|number| number.value as f64).collect() });
        let lists: Vec<&[f64]> = lists.iter().map(Vec::as_slice).collect();
        let variables = [
            p as f64,
            self.coded.plan.steps.len() as f64,
            lists[2][p],
            raw.order[p].value as f64,
        ];
        let value = |formula| self.edits.value(formula, &variables, &lists);
        let edited_or = |formula, default: i64| match self.edits.is_edited(formula) {
            true => value(formula) as i64,
            false => default,
        };
        let transform = value(Formula::Transform);
        let has = |formula| self.edits.value(formula, &[transform], &[]) != 0.0;
        let reference = edited_or(
            Formula::Reference,
            default.reference.map_or(-1, |plane| plane as i64),
        );
        if reference >= self.coded.plan.steps.len() as i64 {
            return Err(outside_data_error(self.coded.at));
        }
        Ok(Step {
            reference: usize::try_from(reference).ok(),
            inverted: has(Formula::Inverted),
            displaced: has(Formula::Displaced),
            motion: (
                edited_or(Formula::VectorX, default.motion.0),
                edited_or(Formula::VectorY, default.motion.1),
            ),
        })
    }

    /// Returns the predictor of a plane. `sources` contains three versions of the reference (corrected, uncorrected, as coded)
    /// and the previous plane.
    fn predictor(&self, sources: &[&Vec<u8>; 4], step: &Step) -> Result<Vec<u8>> {
        if !self.edits.edits_any(Formula::Predictor..=Formula::EdgeY) {
            let plane = (self.reading.predictor)(sources[0], step, self.coded.size, self.reading);
            return Ok(plane.into_owned());
        }
        match self.edits.change(Formula::Predictor) {
            Some(EditedForm::Expression(expression)) => {
                self.evaluate_planes(expression, sources, step)
            }
            _ => self.evaluate_planes(&Formula::Predictor.stated().expression, sources, step),
        }
    }

    fn evaluate_planes(
        &self,
        expression: &Expression,
        sources: &[&Vec<u8>; 4],
        step: &Step,
    ) -> Result<Vec<u8>> {
        let inner = |inner| self.evaluate_planes(inner, sources, step);
        match expression {
            Expression::Variable(source) => Ok(sources[*source].clone()),
            Expression::Call(Function::Invert, arguments) => {
                let mut plane = inner(&arguments[0])?;
                if step.inverted {
                    self.invert(&mut plane);
                }
                Ok(plane)
            }
            Expression::Call(Function::Displace, arguments) => {
                let plane = inner(&arguments[0])?;
                if step.displaced {
                    self.displace(&plane, step)
                } else {
                    Ok(plane)
                }
            }
            // Any other expression is evaluated element by element.
            _ => {
                let value = |i: usize| {
                    let values = sources.map(|plane| f64::from(plane[i]));
                    to_byte(expression.value(&values, &[]))
                };
                Ok((0..sources[0].len()).map(value).collect())
            }
        }
    }

    fn invert(&self, plane: &mut [u8]) {
        if !self.edits.is_edited(Formula::Inversion) {
            return (self.reading.invert)(plane);
        }
        for value in plane {
            let variables = [f64::from(*value)];
            *value = to_byte(self.edits.value(Formula::Inversion, &variables, &[]));
        }
    }

    fn displace(&self, plane: &[u8], step: &Step) -> Result<Vec<u8>> {
        let Size { width, height } = self.coded.size;
        let (width, height) = (f64::from(width), f64::from(height));
        let mx = (self.reading.motion_sign)(step.motion.0) as f64;
        let my = (self.reading.motion_sign)((self.reading.motion_vertical)(step.motion.1)) as f64;
        let mut displaced = Vec::with_capacity(plane.len());
        for i in 0..plane.len() {
            let (x, y) = ((i as f64) % width, (i as f64 / width).floor());
            let variables = [x, y, mx, my, width, height];
            if self
                .edits
                .edits_any(Formula::FirstColumn..=Formula::SecondRow)
            {
                let [left, right, first, second] = [
                    Formula::FirstColumn,
                    Formula::SecondColumn,
                    Formula::FirstRow,
                    Formula::SecondRow,
                ]
                .map(|formula| self.edits.value(formula, &variables, &[]).floor());
                let corners = self.corners(plane, [left, right], [first, second])?;
                displaced.push((self.reading.motion_half)(corners));
                continue;
            }
            let position = |formula| (2.0 * self.edits.value(formula, &variables, &[])).floor();
            let (x2, y2) = (position(Formula::DisplacedX), position(Formula::DisplacedY));
            displaced.push(self.interpolate(plane, x2, y2)?);
        }
        Ok(displaced)
    }

    /// Returns the interpolated value at a position in half texels.
    fn interpolate(&self, plane: &[u8], x2: f64, y2: f64) -> Result<u8> {
        let (left, first) = ((x2 / 2.0).floor(), (y2 / 2.0).floor());
        let (right, second) = ((x2 / 2.0).ceil(), (y2 / 2.0).ceil());
        let corners = self.corners(plane, [left, right], [first, second])?;
        let [a, b, c, d] = corners.map(f64::from);
        let formula = match (left < right, first < second) {
            (true, true) => Formula::MeanOfFour,
            (false, false) => return Ok(corners[0]),
            _ => Formula::MeanOfTwo,
        };
        if !self.edits.is_edited(formula) {
            return Ok((self.reading.motion_half)(corners));
        }
        let values: &[f64] = match formula {
            Formula::MeanOfFour => &[a, b, c, d],
            _ => &[a, if left < right { b } else { c }],
        };
        Ok(to_byte(self.edits.value(formula, values, &[])))
    }

    /// Returns the samples in two columns of two rows, the first row first.
    fn corners(&self, plane: &[u8], columns: [f64; 2], rows: [f64; 2]) -> Result<[u8; 4]> {
        let sample = |x, y| self.sample_at(plane, x, y);
        let ([left, right], [first, second]) = (columns, rows);
        Ok([
            sample(left, first)?,
            sample(right, first)?,
            sample(left, second)?,
            sample(right, second)?,
        ])
    }

    /// Returns the sample at a position that may be outside the plane.
    fn sample_at(&self, plane: &[u8], x: f64, y: f64) -> Result<u8> {
        let size = self.coded.size;
        if !self.edits.edits_any(Formula::EdgeX..=Formula::EdgeY) {
            return Ok((self.reading.motion_border)(
                plane, size, x as i64, y as i64,
            ));
        }
        let (width, height) = (f64::from(size.width), f64::from(size.height));
        let variables = [x, y, width, height];
        let column = self.edits.value(Formula::EdgeX, &variables, &[]);
        let row = self.edits.value(Formula::EdgeY, &variables, &[]);
        let found = value_at(plane, row * width + column, self.outside)?;
        found.ok_or_else(|| outside_data_error(0))
    }

    fn add_predictor(&self, plane: &mut [u8], predictor: &[u8], step: &Step) {
        if !self.edits.is_edited(Formula::Plane) {
            return match self.coded.coding {
                Coding::Jpeg => (self.reading.predict)(plane, predictor),
                Coding::JpegLs => (self.reading.predict_jpeg_ls)(plane, predictor),
            };
        }
        let [inverted, moved] =
            [step.inverted, step.displaced].map(|flag| f64::from(u8::from(flag)));
        for (value, &predictor) in plane.iter_mut().zip(predictor) {
            let variables = [f64::from(*value), f64::from(predictor), inverted, moved];
            *value = to_byte(self.edits.value(Formula::Plane, &variables, &[]));
        }
    }

    /// Applies the side information of plane `p`, whose stream decodes to `residuals`.
    fn correct(&self, p: usize, plane: &mut [u8], residuals: &[u8], predicted: bool) -> Result<()> {
        let edits = self.edits;
        if !edits.edits_any(Formula::RecordCount..=Formula::Corrected) {
            return self.coded.correct(p, plane, self.reading);
        }
        let block = (self.reading.side_information)(&self.coded, p);
        let start = self.coded.at + self.coded.plan.extents[p].side.start;
        if !edits.edits_any(Formula::RecordCount..=Formula::RecordPosition) {
            (self.reading.records)(block, start, plane.len())?;
        }
        let size = [block.len() as f64, self.coded.plan.parameter as f64];
        let count = edits.value(Formula::RecordCount, &size, &[]);
        if count.fract() != 0.0 {
            return Err(outside_data_error(start));
        }
        // An edited count may be any number, but there are never more records than bytes.
        for r in 0..(count as usize).min(block.len()) {
            let mut bytes = [0.0; 5];
            for (k, value) in bytes.iter_mut().enumerate() {
                let address = edits.value(Formula::RecordByte, &[r as f64, k as f64, count], &[]);
                *value = f64::from(*element_at(block, address)?);
            }
            let position = edits.value(Formula::RecordPosition, &bytes, &[]);
            let value = bytes[4];
            let Size { width, height } = self.coded.size;
            let (width, height) = (f64::from(width), f64::from(height));
            let (row, column) = ((position / width).floor(), position.rem_euclid(width));
            let predicted = f64::from(u8::from(predicted));
            let record = [
                position, row, column, width, height, r as f64, value, predicted,
            ];
            let texel = edits.value(Formula::RecordPlace, &record, &[]);
            let before = f64::from(*element_at(plane, texel)?);
            let residual = f64::from(residuals[texel as usize]);
            let correction = [value, before, residual, position, r as f64, predicted];
            plane[texel as usize] = to_byte(edits.value(Formula::Corrected, &correction, &[]));
        }
        Ok(())
    }
}

/// Computes the final values with edited formulas (2.4).
#[must_use]
pub fn final_values(ptm: &Ptm, reading: &Reading, edits: Edits) -> Coefficients {
    let (set, planes) = (&ptm.header.scale_bias, &ptm.planes);
    let mut coefficients = evaluate::compute_coefficients(set, planes, reading);
    if edits.has_stage(Stage::Coefficients) {
        let channels = planes.shape.channels();
        let values = coefficients.values.iter_mut().zip(&planes.samples);
        for (i, (value, &raw)) in values.enumerate() {
            let channel = i % channels;
            let formula = match channel < planes.shape.coefficients() {
                true => Formula::FinalCoefficient,
                false => Formula::FinalColor,
            };
            if edits.is_edited(formula) || edits.is_edited(Formula::ByteNumber) {
                let [i, c] = coefficient_index(channel);
                let number = edits.value(Formula::ByteNumber, &[f64::from(raw), i, c], &[]);
                let variables = [number, i, c];
                *value = edits.value(formula, &variables, &[&set.scale, &set.bias]);
            }
        }
    }
    coefficients
}

/// Returns the final values as view coef shows them, if the bytes of its floats or their positions are computed with an edited formula.
#[must_use]
pub fn floats(values: Vec<f64>, edits: Edits) -> Vec<f64> {
    if !edits.edits_any(Formula::FloatPlace..=Formula::FloatByte) {
        return values;
    }
    let mut bytes = vec![0; 4 * values.len()];
    for (v, &value) in values.iter().enumerate() {
        // A number outside the range becomes the smallest integer, as on x86.
        let truncate = |value: f64| {
            let is_in_range = value.abs() < f64::from(1_u32 << 31);
            if is_in_range { value as i32 } else { i32::MIN }
        };
        let integer = truncate(f64::from(value as f32)).cast_unsigned();
        let [bits, truncated] =
            [value, f64::from(truncate(value))].map(|value| f64::from((value as f32).to_bits()));
        let place = edits.value(Formula::FloatPlace, &[v as f64], &[]);
        for (k, unedited) in (value as f32).to_le_bytes().into_iter().enumerate() {
            let k = k as f64;
            let variables = [bits, k, f64::from(integer), truncated];
            let byte = edits.value_or(Formula::FloatByte, &variables, || f64::from(unedited));
            write_at(&mut bytes, place + k, to_byte(byte));
        }
    }
    let (floats, _) = bytes.as_chunks();
    floats
        .iter()
        .map(|&bytes| f64::from(f32::from_le_bytes(bytes)))
        .collect()
}

/// Writes a value if its position is inside `data`.
fn write_at<T>(data: &mut [T], position: f64, value: T) {
    if let Some(place) = index_of(position).and_then(|position| data.get_mut(position)) {
        *place = value;
    }
}

/// Returns, for red, green and blue, whether all channels that an edited formula uses are in the texel.
#[must_use]
pub fn colors_inside_texel<M>(shape: &Shape<M>, edits: Edits) -> [bool; 3] {
    let channels = shape.channels() as f64;
    let is_inside = |formula: Formula, variables: &[f64]| {
        !edits.is_edited(formula) || (0.0..channels).contains(&edits.value(formula, variables, &[]))
    };
    let is_intensity_inside = |c: f64| {
        let mut coefficients = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].into_iter();
        coefficients.all(|i| is_inside(Formula::IntensityChannel, &[i, c]))
    };
    [0.0, 1.0, 2.0].map(|k| match shape {
        Shape::Rgb => is_intensity_inside(k),
        Shape::Lrgb => is_intensity_inside(0.0) && is_inside(Formula::ColorChannel, &[k]),
        Shape::Lum(_) => is_intensity_inside(0.0),
    })
}

/// Computes the image under a light with edited formulas (1.0, 2.6, 2.7.3).
#[must_use]
pub fn image(
    coefficients: &Coefficients,
    lu: f64,
    lv: f64,
    reading: &Reading,
    edits: Edits,
) -> RelitImage {
    if !edits.has_stage(Stage::Color) {
        return evaluate::evaluate(coefficients, lu, lv, reading);
    }
    let (lu, lv) = (reading.light)(lu, lv);
    let [u, v] = [Formula::LightU, Formula::LightV].map(|light| edits.value(light, &[lu, lv], &[]));
    let polynomial = |a: &[f64]| {
        let variables = [a[0], a[1], a[2], a[3], a[4], a[5], u, v];
        edits.value_or(Formula::Polynomial, &variables, || {
            (reading.polynomial)(a, u, v)
        })
    };
    // A channel may be one of another texel.
    let at = |start: usize, formula: Formula, variables: &[f64]| {
        let index = index_of(start as f64 + edits.value(formula, variables, &[]));
        let value = index.and_then(|index| coefficients.values.get(index));
        value.copied().unwrap_or(f64::NAN)
    };
    let intensity = |start: usize, c: usize| {
        if !edits.is_edited(Formula::IntensityChannel) {
            return polynomial(&coefficients.values[start + 6 * c..][..6]);
        }
        let coefficient = |i: usize| at(start, Formula::IntensityChannel, &[i as f64, c as f64]);
        polynomial(&[0, 1, 2, 3, 4, 5].map(coefficient))
    };
    let color = |start: usize| match coefficients.shape {
        Shape::Rgb => [0, 1, 2].map(|c| intensity(start, c)),
        Shape::Lrgb => {
            let luminance = (reading.luminance)(intensity(start, 0));
            [0.0, 1.0, 2.0].map(|k| {
                let rgb = at(start, Formula::ColorChannel, &[k]);
                let unedited = || (reading.modulate)(luminance, rgb);
                edits.value_or(Formula::Color, &[luminance, rgb], unedited)
            })
        }
        Shape::Lum(matrix) => {
            let texel = &coefficients.values[start..];
            let (y, cr, cb) = (intensity(start, 0), texel[6], texel[7]);
            if !edits.is_edited(Formula::MatrixRow) {
                return evaluate::lum_color(&matrix, y, cr, cb, reading);
            }
            let row = |k| {
                let variables = [y, cr, cb, k, texel[5]];
                edits.value(Formula::MatrixRow, &variables, &[&matrix.0])
            };
            [0.0, 1.0, 2.0].map(row)
        }
    };
    let clamp = |value: f64| {
        let clamped = edits.value_or(Formula::Rendering, &[value], || (reading.clamp)(value));
        if clamped.is_nan() {
            // A byte cannot represent NaN.
            0.0
        } else if edits.is_edited(Formula::Rendering) && clamped.is_finite() {
            clamped - 256.0 * ((clamped + 0.5) / 256.0).floor()
        } else {
            clamped
        }
    };
    let channels = coefficients.shape.channels();
    let texels = (0..coefficients.values.len()).step_by(channels);
    let colors = texels.flat_map(color).map(clamp);
    let mut values: Vec<f64> = colors.collect();
    if edits.is_edited(Formula::ColorPlace) {
        let mut written = vec![0.0; values.len()];
        let count = values.len() / 3;
        for (index, value) in values.into_iter().enumerate() {
            let variables = [index / 3, index % 3, count].map(|number| number as f64);
            let place = edits.value(Formula::ColorPlace, &variables, &[]);
            write_at(&mut written, place, value);
        }
        values = written;
    }
    RelitImage {
        size: coefficients.size,
        values,
    }
}
