//! From a wrong value back to the bytes of the file it comes from, by the map that the generator drew.

use std::fmt::Write;

use super::blocks::Block;
use super::indices::IndexBlock;
use crate::diagnose::pair::Pair;
use crate::diagnose::witness::Witness;
use crate::ptm::{Format, Size};

/// How far a payload may have been read from the wrong place and still be recognised, in bytes.
const FAR: isize = 64;

/// The bytes of one stored value, in words: nothing for planes of files that were put together by hand or damaged.
pub(in crate::diagnose) fn sample(
    witness: &Witness,
    x: usize,
    y: usize,
    channel: usize,
) -> Option<String> {
    if witness.case.format().is_compressed() {
        return sample_of_plane(witness, x, y, channel);
    }
    let (block, at) = byte(witness, x, y, channel)?;
    let via = match index(witness, x, y).filter(|_| block == Block::Table) {
        Some(index) => format!(" (entry {index} of the table, by the index of that texel)"),
        None => String::new(),
    };
    Some(format!("byte {at} (0x{at:x}), {}{via}", block.name()))
}

fn sample_of_plane(witness: &Witness, x: usize, y: usize, channel: usize) -> Option<String> {
    let model = witness.model()?;
    let stored = stored_texel(model.size, x, y)?;
    let compressed = model.compressed.as_ref()?;
    let mut says = plane(witness, channel)?;
    if let Some(reference) = compressed.plan.reference(channel) {
        let _ = write!(says, ", predicted from plane {reference}");
    }
    let records = &compressed.planes[channel].records;
    let corrects = |&(position, _): &(u32, u8)| position as usize == stored;
    if let Some(at) = records.iter().rposition(corrects) {
        let from = field(witness, "side information", channel)?.start + 5 * at;
        let to = from + 4;
        let _ = write!(
            says,
            ", and is corrected by the record at bytes {from}–{to}"
        );
    }
    Some(says)
}

/// The bytes of a texel's color under a light.
pub(in crate::diagnose) fn texel(witness: &Witness, x: usize, y: usize) -> Option<String> {
    let (block, at) = byte(witness, x, y, 0)?;
    Some(format!(
        "all stored values of that texel, the first at byte {at} (0x{at:x}), {}",
        block.name()
    ))
}

/// By how many bytes every value was read from the wrong place, if one number says it.
pub(in crate::diagnose) fn shift(witness: &Witness, pair: &Pair) -> Option<isize> {
    let format = witness.case.format();
    if pair.channels != format.channels() || format.has_table() {
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

/// The place in the file of one value of a file without compressed planes, and where it stands.
fn byte(witness: &Witness, x: usize, y: usize, channel: usize) -> Option<(Block, usize)> {
    let size = witness.decoded().as_ref().ok()?.planes.size;
    let stored = stored_texel(size, x, y)?;
    let entry = || index(witness, x, y);
    let (block, per_texel, place, texel) = match witness.case.format() {
        Format::Rgb => {
            let block = [Block::Red, Block::Green, Block::Blue][channel / 6];
            (block, 6, channel % 6, stored)
        }
        Format::Lum => (Block::Coefficients, 8, channel, stored),
        Format::Lrgb if channel < 6 => (Block::Coefficients, 6, channel, stored),
        Format::Lrgb => (Block::Colors, 3, channel - 6, stored),
        Format::PtmLut if channel >= 6 => (Block::Colors, 3, channel - 6, stored),
        Format::PtmLut => (Block::Table, 6, channel, entry()?),
        Format::PtmCLut => (Block::Table, 9, channel, entry()?),
        _ => return None,
    };
    let start = block.range(witness)?.start;
    Some((block, start + texel * per_texel + place))
}

/// The index of a texel into the table.
fn index(witness: &Witness, x: usize, y: usize) -> Option<usize> {
    let size = witness.decoded().as_ref().ok()?.planes.size;
    let indices = IndexBlock::of(witness)?;
    let extent = indices.extent(size);
    (x < extent.w && y < extent.h).then(|| indices.stored(y * extent.w + x, extent))
}

/// Which of the stored texels, bottom row first, stands there in a picture; it may be higher than the map.
fn stored_texel(size: Size, x: usize, y: usize) -> Option<usize> {
    let row = (size.height as usize).checked_sub(y + 1)?;
    Some(row * size.width as usize + x)
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
