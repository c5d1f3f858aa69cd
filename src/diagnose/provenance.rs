//! From a wrong value back to the bytes of the file it comes from, by the map that the generator drew.

use std::fmt::Write;

use super::pair::Pair;
use super::witness::Witness;
use crate::generate::Model;
use crate::ptm::Format;

/// How far a payload may have been read from the wrong place and still be recognised, in bytes.
const FAR: isize = 64;

/// The bytes of one stored value, in words: nothing for files that were put together by hand or damaged.
pub(super) fn sample(witness: &Witness, x: usize, y: usize, channel: usize) -> Option<String> {
    let model = witness.model()?;
    let stored = stored_texel(model, x, y)?;
    if let Some(compressed) = &model.compressed {
        let mut says = plane(witness, channel)?;
        if let Some(reference) = compressed.plan.reference(channel) {
            let _ = write!(says, ", predicted from plane {reference}");
        }
        let records = &compressed.planes[channel].records;
        if let Some(at) = records
            .iter()
            .rposition(|&(position, _)| position as usize == stored)
        {
            let side = field(witness, "side information", channel)?;
            let from = side.start + 5 * at;
            let _ = write!(
                says,
                ", and is corrected by the record at bytes {from}–{}",
                from + 4
            );
        }
        return Some(says);
    }
    let (name, at) = byte(witness, x, y, channel)?;
    let via = if model.format.has_table() && !name.starts_with("colors") {
        let index = model.indices[y * model.size.width as usize + x];
        format!(" (entry {index} of the table, by the index of that texel)")
    } else {
        String::new()
    };
    Some(format!("byte {at} (0x{at:x}), {name}{via}"))
}

/// The bytes of a texel's color under a light.
pub(super) fn texel(witness: &Witness, x: usize, y: usize) -> Option<String> {
    let (name, at) = byte(witness, x, y, 0)?;
    Some(format!(
        "all stored values of that texel, the first at byte {at} (0x{at:x}), {name}"
    ))
}

/// By how many bytes every value was read from the wrong place, if one number says it.
pub(super) fn shift(witness: &Witness, pair: &Pair) -> Option<isize> {
    let model = witness.model()?;
    if pair.channels != model.format.channels() || model.format.has_table() {
        return None;
    }
    let file = &witness.built.file;
    let wrong: Vec<(usize, f64)> = pair
        .wrong()
        .into_iter()
        .map(|i| {
            let (texel, channel) = (i / pair.channels, i % pair.channels);
            let at = byte(witness, texel % pair.width, texel / pair.width, channel)?.1;
            // Of final values only raw ones can be looked for in the file.
            (pair.got[i].fract() == 0.0 && (0.0..256.0).contains(&pair.got[i]))
                .then_some((at, pair.got[i]))
        })
        .collect::<Option<_>>()?;
    let reads = |shift: isize| {
        let mut seen = 0;
        let fits = wrong.iter().all(|&(at, got)| {
            match at.checked_add_signed(shift).and_then(|at| file.get(at)) {
                Some(&byte) => {
                    seen += 1;
                    f64::from(byte) == got
                }
                None => true,
            }
        });
        fits && seen >= 4
    };
    (1..=FAR)
        .flat_map(|far| [far, -far])
        .find(|&shift| reads(shift))
}

/// The place in the file of one value of a file without compressed planes.
fn byte(witness: &Witness, x: usize, y: usize, channel: usize) -> Option<(&'static str, usize)> {
    let model = witness.model()?;
    let stored = stored_texel(model, x, y)?;
    let entry = || Some(*model.indices.get(y * model.size.width as usize + x)? as usize);
    let (name, per_texel, place, texel) = match model.format {
        Format::Rgb => (
            [
                "red coefficients",
                "green coefficients",
                "blue coefficients",
            ][channel / 6],
            6,
            channel % 6,
            stored,
        ),
        Format::Lum => ("coefficients, Cr and Cb", 8, channel, stored),
        Format::Lrgb if channel < 6 => ("coefficients", 6, channel, stored),
        Format::Lrgb => ("colors", 3, channel - 6, stored),
        Format::PtmLut if channel >= 6 => ("colors", 3, channel - 6, stored),
        Format::PtmLut => ("table", 6, channel, entry()?),
        Format::PtmCLut => ("table", 9, channel, entry()?),
        _ => return None,
    };
    let field = field(witness, name, 0)?;
    Some((name, field.start + texel * per_texel + place))
}

/// Which of the stored texels, bottom row first, stands there in a picture; it may be higher than the map.
fn stored_texel(model: &Model, x: usize, y: usize) -> Option<usize> {
    let row = (model.size.height as usize).checked_sub(y + 1)?;
    Some(row * model.size.width as usize + x)
}

/// The stream of a plane.
fn plane(witness: &Witness, channel: usize) -> Option<String> {
    let range = field(witness, "plane", channel)?;
    Some(format!(
        "plane {channel}, the stream at bytes {}–{} (0x{:x}–0x{:x})",
        range.start,
        range.end - 1,
        range.start,
        range.end - 1
    ))
}

/// The bytes of the `n`th field of that name.
fn field(witness: &Witness, name: &str, n: usize) -> Option<std::ops::Range<usize>> {
    let fields = &witness.built.fields;
    let mut named = fields.iter().filter(|field| field.name == name);
    named.nth(n).map(|field| field.range.clone())
}
