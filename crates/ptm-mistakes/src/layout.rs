//! §2.7 Uncompressed Per Texel Data: mistakes in the layout of texels

use std::ops::Range;

use super::anatomy::EditedFile;
use super::change::{Change, Changes};
use ptm::decode::{decode, read_header, texels};
use ptm::input::Input;
use ptm::{Coding, Format, Header, Ptm, Storage};

pub const CHANGES: Changes = |slug| {
    Some(match slug {
        "payload-reversed" => Change::Bytes(|file| {
            let mut payload = file.payload().to_vec();
            payload.reverse();
            flip_rows_of_blocks(file.file, &mut payload);
            file.with_payload(&payload)
        }),
        "format-ignored" => {
            Change::Bytes(|file| file.respell(&["2.2/1"], |_| Some("PTM_FORMAT_LRGB".to_owned())))
        }
        "rgb-as-lrgb" => Change::Bytes(|file| {
            file.respell(&["2.2/1"], |text| {
                (text == "PTM_FORMAT_RGB").then(|| "PTM_FORMAT_LRGB".to_owned())
            })
        }),
        "coefficients-reversed" => Change::Map(|ptm| for_each_polynomial(ptm, <[u8]>::reverse)),
        "a0-last" => Change::Map(|ptm| for_each_polynomial(ptm, |a| a.rotate_right(1))),
        "last-row-lost" => Change::Map(|ptm| {
            let (row, _) = row_and_channels(ptm);
            ptm.planes.samples[..row].fill(0);
        }),
        "first-row-lost" => Change::Map(|ptm| {
            let (row, _) = row_and_channels(ptm);
            let start = ptm.planes.samples.len() - row;
            ptm.planes.samples[start..].fill(0);
        }),
        "last-column-lost" => Change::Map(|ptm| {
            let (row, channels) = row_and_channels(ptm);
            let rows = ptm.planes.samples.chunks_exact_mut(row);
            rows.for_each(|samples| samples[row - channels..].fill(0));
        }),
        "rows-rotated-by-one" => Change::Map(|ptm| {
            let (row, _) = row_and_channels(ptm);
            ptm.planes.samples.rotate_right(row);
        }),
        "texels-counted-in-16-bits" => Change::Map(|ptm| {
            // The top rows are stored last.
            let (row, channels) = row_and_channels(ptm);
            let rows = ptm.planes.samples.chunks_exact_mut(row).rev();
            for texel in rows
                .flat_map(|row| row.chunks_exact_mut(channels))
                .skip(65_536)
            {
                texel.fill(0);
            }
        }),
        "columns-counted-in-8-bits" => Change::Map(|ptm| {
            let (row, channels) = row_and_channels(ptm);
            for row in ptm.planes.samples.chunks_exact_mut(row) {
                row.chunks_exact_mut(channels)
                    .skip(256)
                    .for_each(|texel| texel.fill(0));
            }
        }),
        "rows-counted-in-8-bits" => Change::Map(|ptm| {
            let (row, _) = row_and_channels(ptm);
            let lost = (ptm.planes.size.height as usize).saturating_sub(256) * row;
            ptm.planes.samples[..lost].fill(0);
        }),
        "square-only" => Change::Map(|ptm| {
            let (row, channels) = row_and_channels(ptm);
            let (size, samples) = (ptm.planes.size, &ptm.planes.samples);
            let stride = size.height as usize * channels;
            if size.height > size.width {
                let source = |i: usize| (i / row * stride + i % row) % samples.len();
                ptm.planes.samples = (0..samples.len()).map(|i| samples[source(i)]).collect();
            }
        }),
        "height-before-width" => Change::Bytes(|file| {
            let [Some(width), Some(height)] = [0, 1].map(|n| file.nth_field("2.3/1", n)) else {
                return file.unchanged();
            };
            let (width, height) = (&width.range, &height.range);
            let mut bytes = file.file.to_vec();
            bytes.splice(height.clone(), file.file[width.clone()].iter().copied());
            bytes.splice(width.clone(), file.file[height.clone()].iter().copied());
            EditedFile::File(bytes)
        }),
        "blocks-separated" => Change::Bytes(|file| {
            let has_blocks = matches!(
                file.field_texts(&["2.2/1"])[..],
                ["PTM_FORMAT_RGB" | "PTM_FORMAT_LRGB"]
            );
            let Some(ptm) = has_blocks.then(|| decode(file.file).ok()).flatten() else {
                return file.unchanged();
            };
            // Each block after the first starts one byte later than the previous one.
            let first = file.payload_offset() + ptm.header.size.texels() * 6;
            let second = first + ptm.header.size.texels() * 6 + 1;
            let mut bytes = file.file.to_vec();
            for separator in [second, first] {
                let exists = separator == first || ptm.header.format == Format::Rgb;
                if exists && separator < bytes.len() {
                    bytes.remove(separator);
                }
            }
            EditedFile::File(bytes)
        }),
        "trailing-bytes-are-the-end" => Change::Bytes(|file| {
            let end = file.fields.iter().map(|field| field.range.end).max();
            let extra = file.file.len() - end.unwrap_or(file.file.len());
            match file.file.get(file.payload_offset() + extra..) {
                Some(payload) if extra > 0 && decode(file.file).is_ok() => {
                    file.with_payload(payload)
                }
                _ => file.unchanged(),
            }
        }),
        _ => return None,
    })
};

/// Flips the rows of each block of texels, for decoders that do not flip them.
fn flip_rows_of_blocks(file: &[u8], payload: &mut [u8]) {
    let Ok(Header { format, size, .. }) = read_header(&mut Input::new(file)) else {
        return;
    };
    if format.storage() != Storage::Texels || decode(file).is_err() {
        return;
    }
    let mut rest = payload;
    for block in texels::blocks(format) {
        let length = (size.texels() * block.channels).min(rest.len());
        let (rows, after) = rest.split_at_mut(length);
        let flipped = rows.chunks(size.width as usize * block.channels).rev();
        let flipped: Vec<u8> = flipped.flatten().copied().collect();
        rows.copy_from_slice(&flipped);
        rest = after;
    }
}

/// Returns the stored index of `row` for a decoder that expects the top row first in files with these codings.
pub fn top_row_first(codings: &[Coding], header: &Header, row: usize) -> usize {
    match header.format.coding() {
        Some(coding) if codings.contains(&coding) => row,
        _ => texels::bottom_row_first(header, row),
    }
}

/// Flips some channels vertically.
pub fn flip_rows(ptm: &mut Ptm, channels: Range<usize>) {
    let (row, texel) = row_and_channels(ptm);
    let original = ptm.planes.samples.clone();
    let rows = ptm.planes.samples.chunks_exact_mut(row);
    for (to, from) in rows.zip(original.rchunks_exact(row)) {
        let texels = to.chunks_exact_mut(texel).zip(from.chunks_exact(texel));
        texels.for_each(|(to, from)| to[channels.clone()].copy_from_slice(&from[channels.clone()]));
    }
}

/// Applies `change` to the stored coefficients of every polynomial.
fn for_each_polynomial(ptm: &mut Ptm, change: fn(&mut [u8])) {
    let channels = ptm.planes.shape.channels();
    let coefficients = ptm.planes.shape.coefficients();
    for texel in ptm.planes.samples.chunks_exact_mut(channels) {
        texel[..coefficients].chunks_exact_mut(6).for_each(change);
    }
}

/// Returns the number of bytes in a row and in a texel.
fn row_and_channels(ptm: &Ptm) -> (usize, usize) {
    let channels = ptm.planes.shape.channels();
    (ptm.planes.size.width as usize * channels, channels)
}
