//! §2.7 Uncompressed Per Texel Data: mistakes with the layout of texels

use std::ops::Range;

use super::anatomy::EditedFile;
use super::at::At;
use crate::decode::{decode, texels};
use crate::ptm::{Format, Header, Ptm};

pub(super) const CHANGES: &[(&str, At)] = &[
    (
        "payload-reversed",
        At::Bytes(|file| {
            let flip_rows = file.file[file.payload_offset()..].iter().rev();
            EditedFile::File(file.header().iter().chain(flip_rows).copied().collect())
        }),
    ),
    (
        "rgb-as-lrgb",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                (clause == "2.2/1" && text == "PTM_FORMAT_RGB")
                    .then(|| "PTM_FORMAT_LRGB".to_owned())
            })
        }),
    ),
    (
        "coefficients-reversed",
        At::Planes(|ptm| {
            for_each_texel(ptm, |texel| {
                let polynomials = if texel.len() == 18 { 18 } else { 6 };
                texel[..polynomials]
                    .chunks_exact_mut(6)
                    .for_each(<[u8]>::reverse);
            });
        }),
    ),
    (
        "a0-last",
        At::Planes(|ptm| {
            for_each_texel(ptm, |texel| {
                let polynomials = if texel.len() == 18 { 18 } else { 6 };
                texel[..polynomials]
                    .chunks_exact_mut(6)
                    .for_each(|a| a.rotate_right(1));
            });
        }),
    ),
    (
        "last-row-lost",
        At::Planes(|ptm| {
            let (row, _) = row_and_channels(ptm);
            ptm.planes.samples[..row].fill(0);
        }),
    ),
    (
        "first-row-lost",
        At::Planes(|ptm| {
            let (row, _) = row_and_channels(ptm);
            let start = ptm.planes.samples.len() - row;
            ptm.planes.samples[start..].fill(0);
        }),
    ),
    (
        "last-column-lost",
        At::Planes(|ptm| {
            let (row, channels) = row_and_channels(ptm);
            ptm.planes.samples.chunks_exact_mut(row).for_each(|row| {
                row.iter_mut()
                    .rev()
                    .take(channels)
                    .for_each(|value| *value = 0);
            });
        }),
    ),
    (
        "rows-rotated-by-one",
        At::Planes(|ptm| {
            let (row, _) = row_and_channels(ptm);
            ptm.planes.samples.rotate_right(row);
        }),
    ),
    (
        "texels-counted-in-16-bits",
        At::Planes(|ptm| {
            let channels = ptm.planes.shape.channels();
            let (width, height) = (
                ptm.planes.size.width as usize,
                ptm.planes.size.height as usize,
            );
            for (i, texel) in ptm.planes.samples.chunks_exact_mut(channels).enumerate() {
                let stored = (height - 1 - i / width) * width + i % width;
                if stored >= 65_536 {
                    texel.fill(0);
                }
            }
        }),
    ),
    (
        "columns-counted-in-8-bits",
        At::Planes(|ptm| {
            let (row, channels) = row_and_channels(ptm);
            for row in ptm.planes.samples.chunks_exact_mut(row) {
                row.iter_mut()
                    .skip(256 * channels)
                    .for_each(|value| *value = 0);
            }
        }),
    ),
    (
        "rows-counted-in-8-bits",
        At::Planes(|ptm| {
            let (row, _) = row_and_channels(ptm);
            let lost = (ptm.planes.size.height as usize).saturating_sub(256) * row;
            ptm.planes.samples[..lost].fill(0);
        }),
    ),
    (
        "square-only",
        At::Planes(|ptm| {
            let (width, height) = (
                ptm.planes.size.width as usize,
                ptm.planes.size.height as usize,
            );
            if height > width {
                let channels = ptm.planes.shape.channels();
                let length = ptm.planes.samples.len();
                let shifted: Vec<u8> = (0..length)
                    .map(|i| {
                        ptm.planes.samples[(i / (width * channels) * height * channels
                            + i % (width * channels))
                            % length]
                    })
                    .collect();
                ptm.planes.samples = shifted;
            }
        }),
    ),
    (
        "height-before-width",
        At::Bytes(
            |file| match (file.nth_field("2.3/1", 0), file.nth_field("2.3/1", 1)) {
                (Some(width), Some(height)) => EditedFile::File(
                    [
                        &file.file[..width.range.start],
                        &file.file[height.range.clone()],
                        &file.file[width.range.end..height.range.start],
                        &file.file[width.range.clone()],
                        &file.file[height.range.end..],
                    ]
                    .concat(),
                ),
                _ => file.unchanged(),
            },
        ),
    ),
    (
        "blocks-separated",
        At::Bytes(|file| {
            let format = file.field_texts(&["2.2/1"]);
            let (Ok(ptm), ["PTM_FORMAT_RGB" | "PTM_FORMAT_LRGB"]) =
                (decode(file.file), &format[..])
            else {
                return file.unchanged();
            };
            // Each block after the first starts one byte later than the previous one.
            let first = file.payload_offset() + ptm.header.size.texels() * 6;
            let second = first + ptm.header.size.texels() * 6 + 1;
            let mut bytes = file.file.to_vec();
            for separator in [second, first] {
                let stands = separator == first || ptm.header.format == Format::Rgb;
                if stands && separator < bytes.len() {
                    bytes.remove(separator);
                }
            }
            EditedFile::File(bytes)
        }),
    ),
    (
        "trailing-bytes-are-the-end",
        At::Bytes(|file| {
            let end = file.fields.iter().map(|field| field.range.end).max();
            let extra = match (end, decode(file.file)) {
                (Some(end), Ok(_)) => file.file.len() - end,
                _ => 0,
            };
            match file.file.get(file.payload_offset() + extra..) {
                Some(payload) => EditedFile::File([file.header(), payload].concat()),
                None => file.unchanged(),
            }
        }),
    ),
];

/// Returns the index of the stored row if the top row is stored first in some files.
pub(super) fn stored_row_if_top_down(top_down: bool, header: &Header, row: usize) -> usize {
    if top_down {
        row
    } else {
        texels::bottom_row_first(header, row)
    }
}

/// Flips some channels vertically.
pub(super) fn flip_rows(ptm: &mut Ptm, channels: Range<usize>) {
    let (row, texel) = row_and_channels(ptm);
    let upright = ptm.planes.samples.clone();
    let rows = ptm.planes.samples.chunks_exact_mut(row);
    for (to, from) in rows.zip(upright.rchunks_exact(row)) {
        let texels = to.chunks_exact_mut(texel).zip(from.chunks_exact(texel));
        texels.for_each(|(to, from)| to[channels.clone()].copy_from_slice(&from[channels.clone()]));
    }
}

/// Applies `change` to the channels of every texel.
pub(super) fn for_each_texel(ptm: &mut Ptm, change: fn(&mut [u8])) {
    let channels = ptm.planes.shape.channels();
    ptm.planes
        .samples
        .chunks_exact_mut(channels)
        .for_each(change);
}

/// Returns the number of bytes in a row and in a texel.
fn row_and_channels(ptm: &Ptm) -> (usize, usize) {
    let channels = ptm.planes.shape.channels();
    (ptm.planes.size.width as usize * channels, channels)
}
