//! [`Channels::put`] with a separate loop for each number of channels that the text has
//!
//! A copy of six bytes is two moves if the compiler knows that there are six, and a call if it does
//! not. The result is the same; a test below compares the two.

use std::ops::Range;

use super::channels::{Channels, Values, entry};
use crate::reading::Reading;

/// Does the same as [`Channels::put`].
pub(super) fn put(
    channels: &Channels,
    run: Range<usize>,
    texels: &mut [u8],
    size: usize,
    reading: &Reading,
) {
    let (channel, count) = (channels.block.channel, channels.block.channels);
    match &channels.values {
        Values::Bytes(bytes) => {
            let bytes = &bytes[run.start * count..run.end * count];
            match count {
                _ if count == size => texels.copy_from_slice(bytes),
                1 => spread(bytes.as_chunks::<1>().0.iter(), channel, texels, size),
                3 => spread(bytes.as_chunks::<3>().0.iter(), channel, texels, size),
                6 => spread(bytes.as_chunks::<6>().0.iter(), channel, texels, size),
                _ => channels.put(run, texels, size, reading),
            }
        }
        Values::Entries(indices, table) => {
            let entries =
                run.map(|at| entry(indices, table, at, reading).expect("all were checked"));
            if count == 6 {
                let table = table.bytes.as_chunks::<6>().0;
                spread(entries.map(|entry| &table[entry]), channel, texels, size);
            } else {
                let table = table.bytes.as_chunks::<9>().0;
                spread(entries.map(|entry| &table[entry]), channel, texels, size);
            }
        }
    }
}

/// Copies `N` values of each texel to its channels from `channel` on.
fn spread<'a, const N: usize>(
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

    /// Returns the results of both for a run; bytes that they do not fill are 99.
    fn both(channels: &Channels, run: &Range<usize>, size: usize) -> [Vec<u8>; 2] {
        let blank = vec![99; run.len() * size];
        let (mut plain, mut soon) = (blank.clone(), blank);
        channels.put(run.clone(), &mut plain, size, &Reading::SPEC);
        put(channels, run.clone(), &mut soon, size, &Reading::SPEC);
        [plain, soon]
    }

    proptest! {
        #[test]
        fn runs_are_texel_by_texel(
            bytes in proptest::collection::vec(any::<u8>(), 12 * 18),
            (channel, channels) in (0usize..18, 1usize..=18),
            (start, end) in (0usize..12, 0usize..=12),
        ) {
            let run = start.min(end)..end;
            let part = Channels {
                block: Block { channel, channels },
                values: Values::Bytes(Cow::Owned(bytes)),
            };
            let [plain, soon] = both(&part, &run, channel + channels);
            prop_assert_eq!(plain, soon);
        }

        #[test]
        fn runs_of_entries_are_texel_by_texel(
            table in proptest::collection::vec(any::<u8>(), 9 * 300),
            indices in proptest::collection::vec(0u16..300, 12),
            nine in any::<bool>(),
            wide in any::<bool>(),
            (start, end) in (0usize..12, 0usize..=12),
        ) {
            let entry_size = if nine { 9 } else { 6 };
            let width = if wide { 2 } else { 1 };
            let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()[..width].to_vec()).collect();
            let part = Channels {
                block: Block { channel: 0, channels: entry_size },
                values: Values::Entries(
                    IndexBlock { bytes: &bytes, width },
                    LookupTable { entries: 300, entry_size, bytes: &table[..300 * entry_size] },
                ),
            };
            let [plain, soon] = both(&part, &(start.min(end)..end), 9);
            prop_assert_eq!(plain, soon);
        }
    }
}
