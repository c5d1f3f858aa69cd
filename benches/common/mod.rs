//! Generator of large PTM files.
#![allow(dead_code)] // each benchmark uses a part of this module

use ptm::codec::{jpeg, jpeg_ls};
use ptm::{Coding, Format};

/// Returns a pseudorandom number that depends only on the position and the seed.
fn hash(x: u32, y: u32, seed: u32) -> u32 {
    let mixed = x
        .wrapping_mul(0x9E37_79B1)
        .wrapping_add(y.wrapping_mul(0x85EB_CA77))
        .wrapping_add(seed.wrapping_mul(0xC2B2_AE3D));
    let mixed = (mixed ^ mixed >> 15).wrapping_mul(0x2C1B_3C6D);
    mixed ^ mixed >> 13
}

/// Returns noise from 0 to 255 that is interpolated linearly between the corners of cells.
fn noise(x: u32, y: u32, cell: u32, seed: u32) -> u32 {
    let corner = |dx, dy| hash(x / cell + dx, y / cell + dy, seed + cell) & 255;
    let (fx, fy) = (x % cell, y % cell);
    let row = |dy| corner(0, dy) * (cell - fx) + corner(1, dy) * fx;
    (row(0) * (cell - fy) + row(1) * fy) / (cell * cell)
}

/// Returns a plane that resembles a photograph: shapes, details and some grain.
pub fn plane(width: u32, height: u32, seed: u32) -> Vec<u8> {
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let value = |(x, y)| {
        let sum = 4 * noise(x, y, 128, seed) + 2 * noise(x, y, 32, seed) + noise(x, y, 8, seed);
        (sum / 7 + (hash(x, y, seed) & 3)).min(255) as u8
    };
    places.map(value).collect()
}

/// Returns a file of `width` × `height` texels with planes from [`plane`].
pub fn file(format: Format, width: u32, height: u32) -> Vec<u8> {
    let mut file = format!(
        "PTM_1.2\n{format}\n{width} {height}\n0.5 0.25 0.5 0.25 0.5 0.75\n128 100 140 120 130 3\n"
    )
    .into_bytes();
    let texels = width as usize * height as usize;
    let random = |count: usize| (0..count as u32).map(|i| hash(i, 1, 2) as u8);
    match format {
        Format::Rgb | Format::Lrgb => file.extend(random(texels * format.channels())),
        Format::Lum => {
            file.extend(b"1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n");
            file.extend(random(texels * 8));
        }
        Format::PtmLut => {
            file.extend(b"256 N_LUT_ENTRIES\n");
            file.extend(random(256 * 6 + texels * 4));
        }
        Format::PtmCLut => {
            file.extend(b"4096 N_LUT_ENTRIES\n");
            file.extend(random(4096 * 9));
            file.extend(
                (0..texels as u32).flat_map(|i| (hash(i, 3, 4) as u16 & 4095).to_le_bytes()),
            );
        }
        _ => append_compressed(format, width, height, &mut file),
    }
    file
}

/// Appends the lists and the streams of a file with intra planes.
fn append_compressed(format: Format, width: u32, height: u32, file: &mut Vec<u8>) {
    let planes = format.channels();
    let streams = streams(format, width, height);
    let line = |numbers: Vec<usize>| {
        let numbers: Vec<String> = numbers.iter().map(ToString::to_string).collect();
        numbers.join(" ") + "\n"
    };
    let zeros = || line(vec![0; planes]);
    let parameter = match format.coding() {
        Some(Coding::Jpeg) => "90\n",
        _ => "0\n",
    };
    let lists = [
        parameter.to_owned(),
        zeros(),
        zeros(),
        zeros(),
        zeros(),
        "-1 ".repeat(planes).trim_end().to_owned() + "\n",
        line(streams.iter().map(Vec::len).collect()),
        zeros(),
    ];
    file.extend(lists.concat().into_bytes());
    file.extend(streams.concat());
}

/// Returns the streams of the planes of a compressed file: JPEG with quality 90, or lossless JPEG-LS. Three distinct streams
/// are repeated.
pub fn streams(format: Format, width: u32, height: u32) -> Vec<Vec<u8>> {
    let stream = |seed| {
        let samples = plane(width, height, seed);
        if format.coding() == Some(Coding::Jpeg) {
            jpeg::encode(&samples, width, height, &jpeg::JpegOptions::new(90)).stream
        } else {
            let lossless = jpeg_ls::JpegLsOptions {
                near: 0,
                precision: 8,
                presets: None,
            };
            jpeg_ls::encode(&samples, width, height, &lossless).stream
        }
    };
    let distinct: Vec<Vec<u8>> = (0..3).map(stream).collect();
    distinct
        .into_iter()
        .cycle()
        .take(format.channels())
        .collect()
}
