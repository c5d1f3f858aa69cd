//! Values in other places: rows, columns, channels, blocks.

use crate::parts::Block;
use crate::ptm::{Format, Header, Ptm};
use crate::writers::reference::written;
use crate::writers::request::WriteRequest;
use crate::writers::seen::SeenFile;

/// The file of other values.
pub(super) fn with_samples(request: &WriteRequest, samples: Vec<u8>) -> Option<Vec<u8>> {
    let mut other = request.clone();
    other.samples = samples;
    written(&other).ok()
}

/// Files from which `edit` gives the values back, and of what it makes of them.
pub(super) fn edited(request: &WriteRequest, edit: fn(&mut Ptm)) -> Vec<Vec<u8>> {
    let mut lost = SeenFile::wanted(request).into_map();
    edit(&mut lost);
    let undone = moved(request, edit).map(|from| undo(&request.samples, &from));
    let files = undone.into_iter().chain([lost.planes.samples]);
    files
        .filter(|samples| samples.len() == request.samples.len())
        .filter_map(|samples| with_samples(request, samples))
        .collect()
}

/// Where `edit` takes each value from, if it only moves them.
fn moved(request: &WriteRequest, edit: fn(&mut Ptm)) -> Option<Vec<usize>> {
    let count = request.samples.len();
    let mut from = vec![0_usize; count];
    for shift in [0, 8, 16] {
        let mut map = SeenFile::wanted(request).into_map();
        let address = |i: usize| (i >> shift) as u8;
        map.planes.samples = (0..count).map(address).collect();
        edit(&mut map);
        if map.planes.samples.len() != count {
            return None;
        }
        for (from, byte) in from.iter_mut().zip(map.planes.samples) {
            *from |= usize::from(byte) << shift;
        }
    }
    let mut taken = vec![false; count];
    from.iter()
        .all(|&i| i < count && !std::mem::replace(&mut taken[i], true))
        .then_some(from)
}

/// The values from which taking `from[i]` for `i` gives `wanted`.
fn undo(wanted: &[u8], from: &[usize]) -> Vec<u8> {
    let mut values = vec![0; wanted.len()];
    for (value, &from) in wanted.iter().zip(from) {
        values[from] = *value;
    }
    values
}

/// The file whose rows lie where `row` looks for them.
pub(super) fn in_rows(request: &WriteRequest, row: fn(&Header, usize) -> usize) -> Vec<Vec<u8>> {
    let header = SeenFile::wanted(request).into_map().header;
    let length = request.header.width as usize * request.format.channels();
    let height = request.header.height as usize;
    let mut samples = vec![0; request.samples.len()];
    for (i, values) in request.samples.chunks_exact(length).enumerate() {
        let stored = row(&header, i);
        if stored >= height {
            return Vec::new();
        }
        samples[(height - 1 - stored) * length..][..length].copy_from_slice(values);
    }
    with_samples(request, samples).into_iter().collect()
}

/// An uncompressed file whose values lie in other blocks.
pub(super) fn in_blocks(
    request: &WriteRequest,
    right: &[u8],
    blocks: fn(Format) -> &'static [Block],
) -> Vec<Vec<u8>> {
    if request.format.has_table() || request.format.is_compressed() {
        return Vec::new();
    }
    let header = &right[..right.len() - request.samples.len()];
    vec![[header, &laid_out(request, blocks(request.format))].concat()]
}

/// The channels of every texel, block after block, the bottom row first.
pub(super) fn laid_out(request: &WriteRequest, blocks: &[Block]) -> Vec<u8> {
    let channels = request.format.channels();
    let row = request.header.width as usize * channels;
    let mut bytes = Vec::new();
    for block in blocks {
        let of_block = block.channel..block.channel + block.channels;
        for texel in request
            .samples
            .chunks_exact(row)
            .rev()
            .flat_map(|row| row.chunks_exact(channels))
        {
            bytes.extend(texel.get(of_block.clone()).unwrap_or_default());
        }
    }
    bytes
}
