//! A mistake that no catalog lists, solved from the answers: what is done, where, and in which files.

use super::codecs::stream_slips::StreamSlip;
use super::files::scope::Scope;
use super::layout::blocks::{Block, Part, block_clause, row_clause, texel_clause};
use super::layout::indices::{Index, look_up, read_indices};
use super::layout::strides::{Extent, Strides};
use super::layout::table_layouts::TableLayout;
use super::planes::rules::Slip;
use super::planes::slips::PlaneSlip;
use super::values::changes::{Change, Values};
use super::values::color_rules::ColorRule;
use super::values::final_rules::FinalRule;
use super::values::formulas::{Formula, Numbers};
use super::values::number_readers::{NumberReader, OtherNumbers};
use super::values::powers::Powers;
use super::values::terms::Terms;
use super::values::variants::VARIANTS;
use super::witness::Witness;
use crate::evaluate::{self, Coefficients};
use crate::misreadings::{self, misread};
use crate::protocol::frame::{Answer, Frame, Light, Samples, View};
use crate::ptm::{Format, Ptm, Shape, channel_name};
use crate::reading::Reading;

/// One mistake.
pub(super) struct Solved {
    pub act: Act,
    /// In which files it is made.
    pub scope: Scope,
}

/// What is done.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Act {
    /// Channel i of a texel is read from another one, in maps with so many channels.
    Channels(Vec<usize>),
    /// Coefficient i of every polynomial is read from another one.
    Coefficients([usize; 6]),
    /// A block of the payload is read with other strides.
    Block { block: Block, strides: Strides },
    /// Texels are taken from other places, of some channels.
    Texels {
        channels: Channels,
        strides: Strides,
    },
    /// Other indices into the table are looked up.
    Index(Index),
    /// Tables are read otherwise.
    Table(TableLayout),
    /// Stored values are changed.
    Stored { channels: Channels, change: Change },
    /// Final values are changed.
    Final { channels: Channels, change: Change },
    /// Streams are decoded with a slip.
    Stream(StreamSlip),
    /// Planes are rebuilt with a slip.
    Planes(PlaneSlip),
    /// Numbers of the header are read otherwise.
    Numbers(NumberReader),
    /// Some texts of scales and biases stand for other numbers.
    OtherNumbers(OtherNumbers),
    /// Other scales and biases are used.
    Terms(Terms),
    /// Final values are computed otherwise.
    Rule(FinalRule),
    /// The polynomial is another.
    Powers(Powers),
    /// Colors are computed otherwise.
    Color(ColorRule),
    /// A formula is another, by its place among the variants.
    Variant(usize),
    /// One number of a formula is another, in words.
    Slip(Formula, String),
    /// A mistake of the catalog, by its name, that is made in some channels only.
    Partly {
        slug: &'static str,
        channels: Channels,
    },
    /// A mistake of the catalog that is made in some colors only.
    PartlyShown {
        slug: &'static str,
        colors: [bool; 3],
    },
    /// One number of a formula is another, in some colors only.
    PartlySlipped {
        formula: Formula,
        says: String,
        colors: [bool; 3],
    },
    /// The colors that come out are changed.
    Shown { colors: [bool; 3], change: Change },
}

/// Part of the channels of a texel, in every shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Channels {
    /// Which of a0 … a5.
    pub coefficients: [bool; 6],
    /// Of which of three polynomials.
    pub polynomials: [bool; 3],
    /// Which stored colors, or Cr and Cb.
    pub colors: [bool; 3],
}

impl Channels {
    /// Those of a texel with `count` channels; nothing for sets that other shapes could not have.
    pub fn of(mask: &[bool]) -> Option<Channels> {
        let mut channels = Channels {
            coefficients: [false; 6],
            polynomials: [true; 3],
            colors: [false; 3],
        };
        match mask.len() {
            18 => {
                channels.polynomials = [0, 1, 2].map(|p| mask[6 * p..6 * p + 6].contains(&true));
                for (k, _) in mask.iter().enumerate().filter(|(_, is)| **is) {
                    channels.coefficients[k % 6] = true;
                }
                channels.colors = [channels.coefficients == [true; 6]; 3];
            }
            8 | 9 => {
                channels.coefficients.copy_from_slice(&mask[..6]);
                channels.colors[..mask.len() - 6].copy_from_slice(&mask[6..]);
                if mask.len() == 8 && mask[6] && mask[7] {
                    channels.colors[2] = true;
                }
            }
            _ => return None,
        }
        let same = (0..mask.len()).all(|k| channels.holds(mask.len(), k) == mask[k]);
        same.then_some(channels)
    }

    pub fn holds(&self, count: usize, channel: usize) -> bool {
        match count {
            18 => self.coefficients[channel % 6] && self.polynomials[channel / 6],
            _ if channel < 6 => self.coefficients[channel],
            _ => self.colors[channel - 6],
        }
    }

    /// Whether no coefficient is among them.
    fn is_of_colors(&self) -> bool {
        self.coefficients == [false; 6]
    }

    /// ", only in a3"; nothing for all.
    fn says(&self) -> String {
        let all_coefficients = self.coefficients == [true; 6];
        let polynomial = ["red", "green", "blue"];
        let of = match self.polynomials {
            [true, true, true] => String::new(),
            some => {
                let names = (0..3).filter(|&p| some[p]).map(|p| polynomial[p]);
                format!(" of {}", names.collect::<Vec<_>>().join(" and "))
            }
        };
        let mut names: Vec<String> = match all_coefficients {
            true => vec![format!("the coefficients{of}")],
            false => (0..6)
                .filter(|&a| self.coefficients[a])
                .map(|a| format!("a{a}{of}"))
                .collect(),
        };
        match self.colors {
            [true, true, true] if all_coefficients && of.is_empty() => return String::new(),
            [true, true, true] if names.is_empty() => names.push("the stored colors".to_owned()),
            colors if !all_coefficients => {
                let which = (0..3).filter(|&color| colors[color]);
                names.extend(which.map(|color| {
                    let (name, lum) = (channel_name(9, 6 + color), ["Cr", "Cb", ""][color]);
                    if lum.is_empty() {
                        name
                    } else {
                        format!("{name} ({lum} of LUM)")
                    }
                }));
            }
            _ => {}
        }
        format!(", only in {}", names.join(", "))
    }
}

impl Act {
    /// Whether it shows in this view.
    pub fn shows_in(&self, view: &View) -> bool {
        match self {
            Act::Numbers(reader) if !reader.is_of_header() => matches!(view, View::Rgb(_)),
            Act::Final { .. }
            | Act::Numbers(_)
            | Act::OtherNumbers(_)
            | Act::Terms(_)
            | Act::Rule(_)
            | Act::Slip(Formula::Final, _) => *view != View::Raw,
            Act::Slip(..)
            | Act::Powers(_)
            | Act::Color(_)
            | Act::Variant(_)
            | Act::PartlyShown { .. }
            | Act::PartlySlipped { .. }
            | Act::Shown { .. } => matches!(view, View::Rgb(_)),
            _ => true,
        }
    }

    /// Whether it is a slip in the decoder of the streams of these files.
    pub fn is_of_streams(&self, format: Format) -> bool {
        matches!(self, Act::Stream(slip) if slip.is_of(format))
    }

    /// Whether other entries of a table are looked up.
    pub const fn is_of_indices(&self) -> bool {
        matches!(
            self,
            Act::Index(_)
                | Act::Block {
                    block: Block::Indices,
                    ..
                }
        )
    }

    /// Whether values are computed or changed, wherever they stand.
    pub const fn is_of_values(&self) -> bool {
        !matches!(
            self,
            Act::Block { .. } | Act::Texels { .. } | Act::Index(_) | Act::Table(_) | Act::Powers(_)
        )
    }

    /// Whether it says of single values what becomes of them: in few files that may be chance.
    pub const fn is_of_few_values(&self) -> bool {
        matches!(
            self,
            Act::Stored {
                change: Change::Points(_) | Change::Table(_) | Change::Constant(_),
                ..
            } | Act::Final {
                change: Change::Constant(_),
                ..
            }
        )
    }

    /// What it makes of the stored values; the answer where it finds none.
    pub fn apply(&self, ptm: &mut Ptm, witness: &Witness) -> Result<(), Answer> {
        let shape = ptm.planes.shape;
        let count = shape.channels();
        match self {
            Act::Channels(from) if from.len() == count => {
                for texel in ptm.planes.samples.chunks_exact_mut(count) {
                    let right = texel.to_vec();
                    for (sample, &from) in texel.iter_mut().zip(from) {
                        *sample = right[from];
                    }
                }
            }
            Act::Coefficients(from) => {
                for a in ptm
                    .planes
                    .samples
                    .chunks_exact_mut(count)
                    .flat_map(|texel| texel[..shape.coefficients()].chunks_exact_mut(6))
                {
                    let right = a.to_vec();
                    for (sample, &from) in a.iter_mut().zip(from) {
                        *sample = right[from];
                    }
                }
            }
            Act::Block {
                block: Block::Indices,
                strides,
            } => read_indices(ptm, witness, strides)?,
            Act::Block { block, strides } => read_block(ptm, witness, *block, strides),
            Act::Texels { channels, strides } => move_texels(ptm, channels, strides),
            Act::Index(index) => look_up(ptm, witness, index)?,
            Act::Table(layout) => layout.apply(ptm, witness),
            Act::Numbers(reader) => reader.apply(ptm, witness),
            Act::OtherNumbers(numbers) => numbers.apply(ptm, witness),
            Act::Partly { slug, channels } => misread_in(ptm, witness, slug, channels),
            Act::Stored { channels, change } => {
                for (i, sample) in ptm.planes.samples.iter_mut().enumerate() {
                    if channels.holds(count, i % count) {
                        *sample = change.apply(f64::from(*sample), Values::Bytes) as u8;
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// By how much it shifts the samples of all streams, if that is what it does.
    pub const fn level_shift(&self) -> Option<i8> {
        match self {
            Act::Planes(PlaneSlip {
                slip: Slip::Shifted(by),
                ..
            }) => Some(*by),
            _ => None,
        }
    }

    /// Whether it may find nothing to show.
    pub const fn may_refuse(&self) -> bool {
        self.is_of_indices() || matches!(self, Act::Stream(_))
    }

    /// What it makes of the final values.
    fn change_finals(&self, values: &mut [f64], shape: Shape) {
        let count = shape.channels();
        if let Act::Final { channels, change } = self {
            for (i, value) in values.iter_mut().enumerate() {
                let channel = i % count;
                if channels.holds(count, channel) {
                    *value = change.apply(*value, Values::Reals);
                }
            }
        }
    }

    /// What it does, as a sentence without its subject.
    pub fn says(&self) -> String {
        match self {
            Act::Channels(from) => {
                let name = |channel: usize| channel_name(from.len(), channel);
                let moved: Vec<String> = from
                    .iter()
                    .enumerate()
                    .filter(|&(channel, &from)| channel != from)
                    .map(|(channel, &from)| format!("{} in {}", name(from), name(channel)))
                    .collect();
                format!("shows channels exchanged ({})", moved.join(", "))
            }
            Act::Coefficients([5, 4, 3, 2, 1, 0]) => {
                "takes the six coefficients in reverse order, a5 … a0".to_owned()
            }
            Act::Coefficients(from) if !(0..6).all(|a| from.contains(&a)) => {
                let taken = (0..6).filter(|&a| from[a] != a);
                let taken: Vec<String> = taken.map(|a| format!("a{} for a{a}", from[a])).collect();
                format!("takes {}", taken.join(", "))
            }
            Act::Coefficients(from) => {
                let moved: Vec<String> = (0..6)
                    .filter(|&a| from[a] != a)
                    .map(|a| format!("a{} in a{a}", from[a]))
                    .collect();
                format!("shows coefficients exchanged ({})", moved.join(", "))
            }
            Act::Block {
                block: Block::Alternating,
                ..
            } => "takes the rows of the blocks in turns: a row of the first block, then the same row of the next".to_owned(),
            Act::Block { block, strides } => {
                let channels = match block {
                    Block::Colors => 3,
                    Block::Indices => 1,
                    _ => 6,
                };
                strides.says(block.name(), channels)
            }
            Act::Texels { channels, strides } => {
                format!("{}{}", strides.says_of_texels(), channels.says())
            }
            Act::Index(index) => index.says(),
            Act::Table(layout) => layout.says().to_owned(),
            Act::Stored { channels, change } => {
                format!(
                    "shows stored values wrong: {}{}",
                    change.says(Values::Bytes),
                    channels.says()
                )
            }
            Act::Final { channels, change } => {
                format!(
                    "shows final values wrong: {}{}",
                    change.says(Values::Reals),
                    channels.says()
                )
            }
            Act::Stream(slip) => slip.says(),
            Act::Planes(slip) => slip.says(),
            Act::Numbers(reader) => reader.says(),
            Act::OtherNumbers(numbers) => numbers.says(),
            Act::Terms(terms) => terms.says(),
            Act::Rule(rule) => rule.says(),
            Act::Powers(powers) => powers.says(),
            Act::Color(rule) => rule.says(),
            Act::Variant(variant) => VARIANTS[*variant].says.to_owned(),
            Act::Slip(_, says) => format!("computes values as if {says}"),
            Act::Partly { slug, channels } => format!("{}{}", effect(slug), channels.says()),
            Act::PartlyShown { slug, colors } => format!("{}{}", effect(slug), only_in(*colors)),
            Act::PartlySlipped { says, colors, .. } => {
                format!("computes values as if {says}{}", only_in(*colors))
            }
            Act::Shown { colors, change } => format!(
                "shows colors wrong: {}{}",
                change.says(Values::Colors),
                only_in(*colors)
            ),
        }
    }

    /// What to do about it.
    pub fn fix(&self) -> String {
        match self {
            Act::Channels(_) | Act::Coefficients(_) => {
                "follow one texel of the example from its bytes to its channels; the first byte is the first channel"
            }
            Act::Block { strides, .. } | Act::Texels { strides, .. }
                if *strides == Strides::RIGHT.moved(strides.shift) =>
            {
                "begin right behind what stands before: the line feed of the last header line, or the last value of the block before"
            }
            Act::Block { .. } | Act::Texels { .. } => {
                "compute the place of a value as row · width · channels + column · channels + channel, rows from the bottom of the picture"
            }
            Act::Index(index) => index.fix(),
            Act::Table(layout) => layout.fix(),
            Act::Stored { .. } => "stored values are bytes from 0 to 255; take them as they are",
            Act::Final { channels, .. } if channels.is_of_colors() => {
                "take colors, Cr and Cb as they are stored: they have neither scale nor bias"
            }
            Act::Final { .. } | Act::Terms(_) | Act::Rule(_) => Formula::Final.fix(),
            Act::Powers(_) => Formula::Polynomial.fix(),
            Act::Color(rule) => rule.formula().fix(),
            Act::Variant(variant) => VARIANTS[*variant].formula.fix(),
            Act::Stream(slip) => slip.fix(),
            Act::Planes(slip) => slip.slip.fix(),
            Act::Numbers(_) | Act::OtherNumbers(_) => {
                "read numbers as decimal numbers: a sign, digits, a point and digits, an exponent; a library function does"
            }
            Act::Slip(formula, _) | Act::PartlySlipped { formula, .. } => formula.fix(),
            Act::Partly { slug, .. } | Act::PartlyShown { slug, .. } => {
                misreadings::named(slug).map_or("", |known| known.fix)
            }
            Act::Shown { .. } => "round and clamp the computed color to 0…255 and show it as it is, without a color space or a curve",
        }
        .to_owned()
    }

    /// The clause that it violates in files of `format`; nothing where that depends on the files.
    pub fn clause(&self, format: Format) -> Option<&'static str> {
        match self {
            Act::Slip(formula, _) | Act::PartlySlipped { formula, .. } => Some(formula.clause()),
            Act::Partly { slug, .. } | Act::PartlyShown { slug, .. } => {
                misreadings::named(slug).map(|known| known.clause)
            }
            Act::Final { channels, .. } if channels.is_of_colors() => Some("2.4/9"),
            Act::Final { .. } | Act::Terms(_) | Act::Rule(_) => Some("2.4/8"),
            Act::Powers(_) => Some(Formula::Polynomial.clause()),
            Act::Color(rule) => Some(rule.formula().clause()),
            Act::Variant(variant) => Some(VARIANTS[*variant].formula.clause()),
            Act::Stream(_) => Some("2.9.8/3"),
            Act::Planes(slip) => Some(slip.slip.clause()),
            Act::Numbers(reader) => Some(reader.clause()),
            Act::OtherNumbers(numbers) => Some(numbers.clause()),
            Act::Shown { .. } => Some("1.0/1"),
            Act::Channels(_) | Act::Coefficients(_) => texel_clause(format),
            Act::Block {
                block: Block::Indices,
                ..
            } => block_clause(format, Block::Indices),
            Act::Block { strides, .. } if strides.leaves_gaps() => Some("2.7/2"),
            Act::Block { strides, .. } | Act::Texels { strides, .. } if strides.is_of_rows() => {
                row_clause(format)
            }
            Act::Block { block, .. } => block_clause(format, *block),
            Act::Index(index) => Some(index.clause()),
            Act::Table(layout) => Some(layout.clause(format)),
            _ => None,
        }
    }
}

/// ", only in red"; nothing for all three.
fn only_in(colors: [bool; 3]) -> String {
    let names = ["red", "green", "blue"];
    let some: Vec<&str> = (0..3).filter(|&k| colors[k]).map(|k| names[k]).collect();
    match some.len() {
        3 => String::new(),
        _ => format!(", only in {}", some.join(" and ")),
    }
}

/// What a mistake of the catalog does.
fn effect(slug: &'static str) -> &'static str {
    misreadings::named(slug).map_or(slug, |known| known.effect)
}

/// The picture with these acts in its formulas.
pub(super) fn frame(acts: &[&Act], ptm: &Ptm, view: &View, reading: &Reading) -> Frame {
    let values = || values(acts, ptm, view, reading);
    let (channels, samples) = match view {
        View::Raw => return Frame::under(ptm, view, reading),
        View::Coef => {
            let values = values().into_iter().map(|value| value as f32);
            (
                ptm.planes.shape.channels() as u32,
                Samples::F32(values.collect()),
            )
        }
        View::Rgb(_) => {
            let bytes = values().into_iter().map(|value| value.round() as u8);
            (3, Samples::U8(bytes.collect()))
        }
    };
    Frame {
        view: view.name(),
        width: ptm.planes.size.width,
        height: ptm.planes.size.height,
        channels,
        samples,
        lossy: false,
    }
}

/// The final values, or the colors before they are rounded.
pub(super) fn values(acts: &[&Act], ptm: &Ptm, view: &View, reading: &Reading) -> Vec<f64> {
    let reading = &acts.iter().fold(*reading, |reading, act| match act {
        Act::Variant(variant) => VARIANTS[*variant].at.change(reading),
        _ => reading,
    });
    let slips: Vec<&str> = acts
        .iter()
        .filter_map(|act| match act {
            Act::Slip(_, says) if act.shows_in(view) => Some(says.as_str()),
            _ => None,
        })
        .collect();
    let mut values = if slips.is_empty() {
        let mut finals = evaluate::apply(&ptm.header.scale_bias, &ptm.planes, reading);
        for act in acts {
            match act {
                Act::Terms(terms) => {
                    terms.apply(&mut finals.values, &ptm.planes, &ptm.header.scale_bias);
                }
                Act::Rule(rule) => {
                    rule.apply(&mut finals.values, &ptm.planes, &ptm.header.scale_bias);
                }
                _ => {}
            }
            act.change_finals(&mut finals.values, ptm.planes.shape);
        }
        match view {
            View::Rgb(light) => colors(acts, finals, light, reading),
            _ => finals.values,
        }
    } else {
        Numbers::of(&ptm.planes, &ptm.header.scale_bias, view, reading)
            .with(&slips, ptm.planes.shape)
            .values(&ptm.planes, reading)
    };
    if !matches!(view, View::Rgb(_)) {
        return values;
    }
    for act in acts {
        match act {
            Act::Shown { colors, change } => {
                for texel in values.chunks_exact_mut(3) {
                    for (value, _) in texel.iter_mut().zip(colors).filter(|(_, is)| **is) {
                        *value = change.apply(*value, Values::Colors);
                    }
                }
            }
            Act::PartlyShown { slug, colors } => {
                if let Some(misreading) = misreadings::named(slug) {
                    let misread = misread(&[misreading], *reading);
                    let others = self::values(&[], ptm, view, &misread);
                    exchange(&mut values, &others, *colors);
                }
            }
            Act::PartlySlipped {
                formula,
                says,
                colors,
            } => {
                let slip = Act::Slip(*formula, says.clone());
                let others = self::values(&[&slip], ptm, view, reading);
                exchange(&mut values, &others, *colors);
            }
            _ => {}
        }
    }
    values
}

/// The colors that final values have under a light, not rounded.
fn colors(acts: &[&Act], mut finals: Coefficients, light: &Light, reading: &Reading) -> Vec<f64> {
    let mut rule = None;
    let mut place = (light.lu, light.lv);
    for act in acts {
        match act {
            Act::Powers(powers) => {
                let light = (reading.light)(light.lu, light.lv);
                powers.apply(&mut finals.values, finals.shape, light);
            }
            Act::Numbers(reader) => place = reader.light(light),
            Act::Color(one) => rule = Some(one),
            _ => {}
        }
    }
    match rule {
        Some(rule) => rule.colors(&finals, light, reading),
        None => evaluate::evaluate(&finals, place.0, place.1, reading).values,
    }
}

/// Takes some colors from another picture.
fn exchange(values: &mut [f64], others: &[f64], colors: [bool; 3]) {
    for (i, (value, other)) in values.iter_mut().zip(others).enumerate() {
        if colors[i % 3] {
            *value = *other;
        }
    }
}

/// Takes some channels from what a decoder with this mistake alone finds.
fn misread_in(ptm: &mut Ptm, witness: &Witness, slug: &str, channels: &Channels) {
    let Some(misreading) = misreadings::named(slug) else {
        return;
    };
    let count = ptm.planes.shape.channels();
    match witness.misread(&[misreading], witness.reading) {
        Ok(other) if other.planes.samples.len() == ptm.planes.samples.len() => {
            let pairs = ptm.planes.samples.iter_mut().zip(other.planes.samples);
            for (i, (sample, other)) in pairs.enumerate() {
                if channels.holds(count, i % count) {
                    *sample = other;
                }
            }
        }
        _ => {}
    }
}

/// A block read with other strides, from the bytes of the file; what lies outside of it is 0.
fn read_block(ptm: &mut Ptm, witness: &Witness, block: Block, strides: &Strides) {
    let (width, height) = (
        ptm.planes.size.width as usize,
        ptm.planes.size.height as usize,
    );
    for part in block.parts(witness, width) {
        let extent = Extent {
            row: part.row,
            ..Extent::of(width, height, part.channels)
        };
        read_part(ptm, &witness.built.file, &part, extent, strides);
    }
}

/// The same of some channels.
fn read_part(ptm: &mut Ptm, file: &[u8], part: &Part, extent: Extent, strides: &Strides) {
    let count = ptm.planes.shape.channels();
    if ptm.planes.samples.len() != extent.w * extent.h * count || part.first + extent.c > count {
        return;
    }
    for (texel, samples) in ptm.planes.samples.chunks_exact_mut(count).enumerate() {
        let (column, row) = (texel % extent.w, extent.h - 1 - texel / extent.w);
        for (k, sample) in samples[part.first..part.first + extent.c]
            .iter_mut()
            .enumerate()
        {
            let place = part.start as isize + strides.place(column, row, k, extent);
            let byte = usize::try_from(place).ok().and_then(|at| file.get(at));
            *sample = byte.copied().unwrap_or_default();
        }
    }
}

/// Texels from other places; what lies outside of the picture is 0.
fn move_texels(ptm: &mut Ptm, channels: &Channels, strides: &Strides) {
    let count = ptm.planes.shape.channels();
    let extent = Extent::of(
        ptm.planes.size.width as usize,
        ptm.planes.size.height as usize,
        1,
    );
    let right = ptm.planes.samples.clone();
    let (w, h) = (extent.w, extent.h);
    for (texel, samples) in ptm.planes.samples.chunks_exact_mut(count).enumerate() {
        let place = strides.place(texel % w, h - 1 - texel / w, 0, extent);
        let from = usize::try_from(place).ok().filter(|&place| place < w * h);
        for (k, sample) in samples.iter_mut().enumerate() {
            if channels.holds(count, k) {
                *sample = from.map_or(0, |stored| {
                    right[((h - 1 - stored / w) * w + stored % w) * count + k]
                });
            }
        }
    }
}
