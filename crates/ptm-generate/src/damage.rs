//! Damages: one fault at a time.
//!
//! A damage is a named edit of a valid file. The cases that use it state whether the result must be refused or is outside the
//! specification. Damages are defined in `spec-cases/damages.yaml`, and `spec-cases/README.md` explains each edit.
//!
//! Every edit replaces ranges of the undamaged file, so the order of the edits in a damage does not matter.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::de::{IntoDeserializer, value};
use serde::{Deserialize, Deserializer};

use super::place::{DamagePlace, NamedPlaces, Spot};
use super::recipe::Recipe;
use super::stand_in::StandIn;
use super::{model::Model, output::GeneratedFile};
use crate::error::{Error, Result};
use ptm::{Coding, Format, Size};

/// A named edit that damages a valid file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Damage {
    /// Slug by which cases refer to the damage.
    #[serde(rename = "slug")]
    pub name: String,
    /// Clause that the damaged file violates or goes beyond.
    pub clause: String,
    /// The resulting fault in the file, as a sentence without a period.
    pub effect: String,
    /// Restrictions on the files that the damage applies to.
    needs: Needs,
    replace: BTreeMap<DamagePlace, String>,
    overwrite: BTreeMap<DamagePlace, String>,
    fill: BTreeMap<DamagePlace, String>,
    flip: BTreeMap<DamagePlace, String>,
    insert: BTreeMap<DamagePlace, String>,
    /// Number of bytes to remove from the beginning of each place, or from its end if the number is negative.
    cut: BTreeMap<DamagePlace, isize>,
    /// Amounts to add to numbers. An amount may need 65 bits.
    add: BTreeMap<DamagePlace, String>,
    /// A number to remove, together with one adjacent space.
    remove: Option<DamagePlace>,
    remove_line: Option<DamagePlace>,
    /// The place at which the file is cut off.
    end: Option<DamagePlace>,
    /// Bytes in the header and their replacements.
    header: BTreeMap<String, String>,
    index: BTreeMap<TexelPlace, Index>,
    /// True if the sizes of streams and side information are adjusted to the edited planes.
    #[serde(rename = "fit")]
    adjusts_sizes: bool,
    reads_as: Option<DamageChange>,
    /// Values of scales and biases that the edit changes, such as `scale[1]`.
    means: BTreeMap<String, String>,
}

/// Restrictions on the files that a damage applies to.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Needs {
    planes: Option<usize>,
    size: Option<String>,
    #[serde(deserialize_with = "coding_from_name")]
    coding: Option<Coding>,
}

/// The name of a [`Coding`] in `damages.yaml`.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum CodingName {
    Jpeg,
    JpegLs,
}

fn coding_from_name<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<Coding>, D::Error> {
    Ok(Some(match CodingName::deserialize(deserializer)? {
        CodingName::Jpeg => Coding::Jpeg,
        CodingName::JpegLs => Coding::JpegLs,
    }))
}

/// A texel whose index is set. Texels are counted in stored order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum TexelPlace {
    First,
    Middle,
    Last,
}

/// The new value of an index.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Index {
    /// The number of entries, which is the first invalid index.
    Entries,
    AllOnes,
}

/// A change to the values that a reader finds if it ignores the damage.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum DamageChange {
    /// LRGB values, read as version 1.1: nine adjacent bytes per texel, starting at the bottom left.
    InterleavedTexels,
    #[serde(rename = "plane-1-is-128")]
    PlaneOneIs128,
}

/// A part of the undamaged file and its replacement.
type Splice = (Spot, Vec<u8>);

/// Number of bytes that an edit removes, and the bytes that it inserts.
type ByteEdit = (usize, Vec<u8>);

impl Damage {
    /// Returns the edited file.
    ///
    /// # Errors
    /// Returns an error if the file lacks a place that the damage edits.
    pub fn apply(&self, written: &GeneratedFile, model: &Model) -> Result<Vec<u8>> {
        self.needs.check(model)?;
        let file = NamedPlaces { written, model };
        let mut splices = self.content_edits(&file)?;
        splices.extend(self.header_edits(&file));
        splices.extend(self.removals(&file)?);
        for (place, number) in &self.add {
            splices.push(add_to_number(&file, place, number)?);
        }
        for (&texel, &index) in &self.index {
            splices.push(set_index(&file, texel, index)?);
        }
        if self.adjusts_sizes {
            splices.extend(size_edits(&file, &splices));
        }
        apply_splices(&written.bytes, splices)
    }

    /// Returns the edits that write new bytes: replacements, insertions, overwrites, fills and flips.
    fn content_edits(&self, file: &NamedPlaces) -> Result<Vec<Splice>> {
        let edits: [(
            &BTreeMap<DamagePlace, String>,
            fn(&[u8], Vec<u8>) -> ByteEdit,
        ); 5] = [
            (&self.replace, |old, new| (old.len(), new)),
            (&self.insert, |_, new| (0, new)),
            (&self.overwrite, |_, new| (new.len(), new)),
            (&self.fill, |old, new| (old.len(), new.repeat(old.len()))),
            (&self.flip, |old, new| {
                let flipped = old.iter().zip(&new).map(|(old, bits)| old ^ bits);
                (new.len(), flipped.collect())
            }),
        ];
        let mut splices = Vec::new();
        for (places, edit) in edits {
            for (place, content) in places {
                for Spot { field, range } in file.spots(place)? {
                    let new = expand_content(content, file, &range)?;
                    let (removed, new) = edit(&file.written.bytes[range.clone()], new);
                    let range = range.start..range.start + removed;
                    splices.push((Spot { field, range }, new));
                }
            }
        }
        Ok(splices)
    }

    /// Returns the edits that replace bytes in the header, at every occurrence.
    fn header_edits(&self, file: &NamedPlaces) -> Vec<Splice> {
        let header = file.text(&(0..file.written.payload));
        let replacements = |(old, new): (&String, &String)| -> Vec<Splice> {
            let places = header.match_indices(old.as_str());
            let splice = |(at, _)| (Spot::outside(at..at + old.len()), new.clone().into_bytes());
            places.map(splice).collect()
        };
        self.header.iter().flat_map(replacements).collect()
    }

    fn removals(&self, file: &NamedPlaces) -> Result<Vec<Splice>> {
        let bytes = &file.written.bytes;
        let mut removed = Vec::new();
        for (place, &count) in &self.cut {
            let Spot { field, range } = file.spot(place)?;
            let length = count.unsigned_abs().min(range.len());
            let range = match count < 0 {
                true => range.end - length..range.end,
                false => range.start..range.start + length,
            };
            removed.push(Spot { field, range });
        }
        if let Some(place) = &self.remove {
            let Range { start, end } = file.spot(place)?.range;
            removed.push(Spot::outside(match bytes[end] {
                b' ' => start..end + 1,
                _ => start - 1..end,
            }));
        }
        if let Some(place) = &self.remove_line {
            let start = file.spot(place)?.range.start;
            let length = bytes[start..].iter().position(|&byte| byte == b'\n');
            let length = 1 + length.ok_or(Error::NotApplicable(
                "no line feed follows the location".into(),
            ))?;
            removed.push(Spot::outside(start..start + length));
        }
        if let Some(place) = &self.end {
            let start = file.spot(place)?.range.start;
            removed.push(Spot::outside(start..bytes.len()));
        }
        Ok(removed.into_iter().map(|spot| (spot, Vec::new())).collect())
    }

    /// Returns the recipe and the values of an undamaged file in which a reader finds what one of the damaged file finds.
    #[must_use]
    pub fn without_damage(&self, recipe: &Recipe) -> (Recipe, Model) {
        let model = self.values(&Model::paint(recipe));
        let mut recipe = recipe.clone();
        for (place, text) in &self.means {
            let numbers = if place.starts_with("scale") {
                &mut recipe.scale
            } else {
                &mut recipe.bias
            };
            let mut texts = numbers.texts();
            for (i, number) in texts.iter_mut().enumerate() {
                if place.ends_with(&format!("[{i}]")) {
                    *number = text;
                }
            }
            *numbers = texts.join(" ").parse().expect("six numbers");
        }
        (recipe, model)
    }

    /// Returns the values that a reader finds if it ignores the damage, or reads it as the damage says.
    #[must_use]
    pub fn values(&self, model: &Model) -> Model {
        let mut model = model.clone();
        for (place, value) in &self.means {
            let value = value.parse().expect("the schema requires numbers");
            for (i, (scale, bias)) in model.scale.iter_mut().zip(&mut model.bias).enumerate() {
                if *place == format!("scale[{i}]") {
                    *scale = value;
                } else if *place == format!("bias[{i}]") {
                    *bias = value;
                }
            }
        }
        match self.reads_as {
            Some(DamageChange::InterleavedTexels) if model.format == Format::Lrgb => {
                interleave_texels(&model)
            }
            Some(DamageChange::PlaneOneIs128) => {
                let channels = model.format.channels();
                let plane = model.samples.iter_mut().skip(1).step_by(channels);
                plane.for_each(|sample| *sample = 128);
                model
            }
            _ => model,
        }
    }
}

impl Needs {
    fn check(&self, model: &Model) -> Result<()> {
        let size = self.size.as_deref().map(|text| {
            text.parse::<Size>()
                .map_err(|_| Error::syntax("a size such as 8x5", text))
        });
        let size = size.transpose()?;
        let planes = self.planes;
        let is_met = planes.is_none_or(|planes| planes == model.format.channels())
            && size.is_none_or(|size| size == model.size)
            && (self.coding.is_none() || self.coding == model.format.coding());
        if is_met {
            Ok(())
        } else {
            let reason = "the file does not have the number of planes, the size or the coding that this damage requires";
            Err(Error::NotApplicable(reason.into()))
        }
    }
}

/// Returns the bytes of new content for a range: `hex` bytes, a stand-in `stream`, or text with placeholders.
fn expand_content(content: &str, file: &NamedPlaces, at: &Range<usize>) -> Result<Vec<u8>> {
    if let Some(hex) = content.strip_prefix("hex ") {
        let words = hex.split_whitespace();
        let words: Result<Vec<_>> = words.map(|word| hex_bytes(word, file.model)).collect();
        return Ok(words?.concat());
    }
    if let Some(name) = content.strip_prefix("stream ") {
        let unknown = || Error::unknown("stream", name);
        let gray = name.strip_prefix("gray-").ok_or_else(unknown)?;
        let stand_in = StandIn::deserialize(gray.into_deserializer());
        return stand_in
            .map_err(|_: value::Error| unknown())?
            .stream(file.model);
    }
    let (mut bytes, mut rest) = (String::new(), content);
    while let Some((text, (name, tail))) = rest
        .split_once('{')
        .and_then(|(text, rest)| Some((text, rest.split_once('}')?)))
    {
        bytes += text;
        bytes += &file.fill(name, at)?;
        rest = tail;
    }
    Ok((bytes + rest).into_bytes())
}

/// Parses `ff`, `a5*5000` or `80*{texels}`: a byte and an optional count. `{texels}` is the number of texels as a big-endian u32.
fn hex_bytes(word: &str, model: &Model) -> Result<Vec<u8>> {
    let unknown = || Error::syntax("a byte in hex", word);
    let texels = model.size.texels();
    if word == "{texels}" {
        return Ok((texels as u32).to_be_bytes().to_vec());
    }
    let (byte, times) = word.split_once('*').unwrap_or((word, "1"));
    let times = match times {
        "{texels}" => Some(texels),
        _ => times.parse().ok(),
    };
    let value = u8::from_str_radix(byte, 16).ok();
    let byte = value.filter(|_| byte.len() == 2);
    Ok(vec![byte.ok_or_else(unknown)?; times.ok_or_else(unknown)?])
}

fn add_to_number(file: &NamedPlaces, place: &DamagePlace, amount: &str) -> Result<Splice> {
    let spot = file.spot(place)?;
    let number = |text: &str| {
        text.parse::<i128>()
            .map_err(|_| Error::syntax("a number", text))
    };
    let sum = number(&file.text(&spot.range))? + number(amount)?;
    Ok((spot, sum.to_string().into_bytes()))
}

/// Returns the edit that sets an index to a value past the last entry.
fn set_index(file: &NamedPlaces, texel: TexelPlace, index: Index) -> Result<Splice> {
    let entries = file.model.entries();
    let width = if entries > 256 { 2 } else { 1 };
    let spot = file.spot(&"indices".parse()?)?;
    let count = spot.range.len() / width;
    let texel = match texel {
        TexelPlace::First => 0,
        TexelPlace::Middle => count / 2,
        TexelPlace::Last => count - 1,
    };
    let largest = (1 << (8 * width)) - 1;
    let index: usize = match index {
        Index::Entries => entries,
        Index::AllOnes => largest,
    };
    if index < entries || index > largest {
        return Err(Error::NotApplicable(
            "the table is full, so no index is past the last entry".into(),
        ));
    }
    let start = spot.range.start + width * texel;
    let range = start..start + width;
    let bytes = index.to_le_bytes()[..width].to_vec();
    Ok((Spot { range, ..spot }, bytes))
}

/// Returns the edits that adjust the sizes of planes and of their side information to these splices.
fn size_edits(file: &NamedPlaces, splices: &[Splice]) -> Vec<Splice> {
    let size = |(list, part): (Spot, Spot)| {
        let own = splices.iter().filter(|(spot, _)| spot.field == part.field);
        let length = own.fold(part.range.len(), |length, (spot, new)| {
            length - spot.range.len() + new.len()
        });
        (list, length.to_string().into_bytes())
    };
    let pairs = |list, part| {
        file.fields_named(list)
            .into_iter()
            .zip(file.fields_named(part))
    };
    let sizes = pairs("compressed sizes", "plane");
    sizes
        .chain(pairs("side sizes", "side information"))
        .map(size)
        .collect()
}

/// Applies non-overlapping splices to a file.
fn apply_splices(bytes: &[u8], mut splices: Vec<Splice>) -> Result<Vec<u8>> {
    // An empty place may have the same start as the next field.
    splices.sort_by_key(|(spot, _)| (spot.range.start, spot.field));
    let (mut edited, mut at) = (Vec::with_capacity(bytes.len()), 0);
    for (Spot { range, .. }, new) in splices {
        let between = bytes
            .get(at..range.start)
            .ok_or(Error::NotApplicable("two edits overlap".into()))?;
        edited.extend_from_slice(between);
        edited.extend_from_slice(&new);
        at = range.end;
    }
    edited.extend_from_slice(bytes.get(at..).ok_or(Error::NotApplicable(
        "an edit extends past the end of the file".into(),
    ))?);
    Ok(edited)
}

/// Returns the values that a reader of version 1.1 finds in an LRGB payload: nine adjacent bytes per texel.
fn interleave_texels(model: &Model) -> Model {
    let row = model.size.width as usize * 9;
    let rows = model.samples.chunks(row).rev();
    let bottom_up: Vec<&[u8]> = rows.flat_map(|row| row.chunks(9)).collect();
    let coefficients = bottom_up.iter().flat_map(|texel| &texel[..6]);
    let colors = bottom_up.iter().flat_map(|texel| &texel[6..]);
    let stored: Vec<u8> = coefficients.chain(colors).copied().collect();
    Model {
        samples: stored.chunks(row).rev().flatten().copied().collect(),
        ..model.clone()
    }
}
