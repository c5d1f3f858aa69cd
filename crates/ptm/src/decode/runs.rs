//! Fast version of [`Channels::copy_to`] with a separate loop for each common number of channels
//!
//! Copying six bytes takes two moves if the compiler knows the length, and a function call if it does not. A test
//! compares the two versions.

use std::ops::Range;

use super::channels::{Channels, ValueLayout, table_entry};
use crate::reading::Reading;

/// Returns the same result as [`Channels::copy_to`].
pub(super) fn copy_run(
    channels: &Channels,
    run: Range<usize>,
    texels: &mut [u8],
    size: usize,
    reading: &Reading,
) {
    let (channel, count) = (channels.block.channel, channels.block.channels);
    match &channels.values {
        ValueLayout::Bytes(bytes) => {
            let bytes = &bytes[run.start * count..run.end * count];
            match count {
                _ if count == size => texels.copy_from_slice(bytes),
                1 => copy_values(bytes.as_chunks::<1>().0.iter(), channel, texels, size),
                3 => copy_values(bytes.as_chunks::<3>().0.iter(), channel, texels, size),
                6 => copy_values(bytes.as_chunks::<6>().0.iter(), channel, texels, size),
                _ => channels.copy_to(run, texels, size, reading),
            }
        }
        ValueLayout::Entries(indices, table) => {
            let entries =
                run.map(|i| table_entry(indices, table, i, reading).expect("a valid index"));
            if count == 6 {
                let table = table.bytes.as_chunks::<6>().0;
                copy_values(entries.map(|entry| &table[entry]), channel, texels, size);
            } else {
                let table = table.bytes.as_chunks::<9>().0;
                copy_values(entries.map(|entry| &table[entry]), channel, texels, size);
            }
        }
    }
}

/// Copies `N` values per texel to the channels that start at `channel`.
fn copy_values<'a, const N: usize>(
    values: impl Iterator<Item = &'a [u8; N]>,
    channel: usize,
    texels: &mut [u8],
    size: usize,
) {
    for (texel, values) in texels.chunks_exact_mut(size).zip(values) {
        texel[channel..][..N].copy_from_slice(values);
    }
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use proptest::prelude::*;

    use super::*;
    use crate::parts::{Block, IndexBlock, LookupTable};

    proptest! {
        #[test]
        fn runs_equal_plain_texel_order(
            bytes in proptest::collection::vec(any::<u8>(), 9 * 300),
            indices in proptest::collection::vec(0u16..300, 12),
            (channel, count) in (0usize..18, 1usize..=18),
            entry_size in prop::option::of(prop::sample::select(&[6, 9])),
            width in 1usize..=2,
            (start, end) in (0usize..12, 0usize..=12),
        ) {
            let index = |index: &u16| index.to_le_bytes()[..width].to_vec();
            let index_bytes: Vec<u8> = indices.iter().flat_map(index).collect();
            let count = entry_size.unwrap_or(count);
            let values = match entry_size {
                None => ValueLayout::Bytes(Cow::Borrowed(&bytes)),
                Some(entry_size) => ValueLayout::Entries(
                    IndexBlock { bytes: &index_bytes, width },
                    LookupTable { entries: 300, entry_size, bytes: &bytes[..300 * entry_size] },
                ),
            };
            let channels = Channels { block: Block { channel, channels: count, clause: "" }, values };
            let (run, size) = (start.min(end)..end, channel + count);
            let mut plain = vec![99; run.len() * size];
            let mut fast = plain.clone();
            channels.copy_to(run.clone(), &mut plain, size, &Reading::SPEC);
            copy_run(&channels, run, &mut fast, size, &Reading::SPEC);
            prop_assert_eq!(plain, fast);
        }
    }
}
