//! The conformance images of T.87 (Annex E), and one file by Hewlett-Packard's own encoder.
//!
//! They lie beside the repository and not in it; without them the tests say so and pass. The color
//! images are cut into their scans where these are of one component each; of the line-interleaved
//! and the sample-interleaved ones, only those of one component can be read.

use std::path::Path;

use ptm_conform::codec::jpeg_ls::{self, JpegLsOptions, PresetParameters, decode, encode};

const NAMES: [(&str, &str); 3] = [
    ("R", "test8r.pgm"),
    ("G", "test8g.pgm"),
    ("B", "test8b.pgm"),
];

fn read(name: &str) -> Option<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/t87-conformance");
    if !folder.exists() {
        println!(
            "SKIPPED: {name} is not there, the folder ../shared/data/t87-conformance is missing"
        );
        return None;
    }
    Some(std::fs::read(folder.join(name)).expect(name))
}

/// A PGM file as width, height and samples.
fn pgm(name: &str) -> Option<(u32, u32, Vec<u8>)> {
    let file = read(name)?;
    let mut at = 0;
    let mut word = || {
        let start = at;
        at += file[start..]
            .iter()
            .position(u8::is_ascii_whitespace)
            .expect("a word");
        at += 1;
        std::str::from_utf8(&file[start..at - 1])
            .expect("ASCII")
            .to_owned()
    };
    assert_eq!(word(), "P5");
    let (width, height) = (
        word().parse().expect("a width"),
        word().parse().expect("a height"),
    );
    assert_eq!(word(), "255");
    Some((width, height, file[at..].to_vec()))
}

/// The scans of a stream: the scan header's content, and the entropy-coded data behind it.
fn scans(stream: &[u8]) -> Vec<(&[u8], &[u8])> {
    let mut scans = Vec::new();
    let mut at = 2;
    while stream[at + 1] != 0xD9 {
        let code = stream[at + 1];
        let end = at + 2 + usize::from(u16::from_be_bytes([stream[at + 2], stream[at + 3]]));
        let header = &stream[at + 4..end];
        at = end;
        if code == 0xDA {
            let length = stream[at..]
                .windows(2)
                .position(|two| two[0] == 0xFF && two[1] >= 0x80);
            at += length.expect("a marker");
            scans.push((header, &stream[end..at]));
        }
    }
    scans
}

/// One scan of a color image as an image of its own.
fn alone(width: u32, height: u32, scan: (&[u8], &[u8])) -> Vec<u8> {
    let (header, data) = scan;
    let [w, h] = [width, height].map(|side| u16::try_from(side).expect("a side").to_be_bytes());
    let mut stream = vec![
        0xFF, 0xD8, 0xFF, 0xF7, 0, 11, 8, h[0], h[1], w[0], w[1], 1, header[1], 0x11, 0,
    ];
    stream.extend([0xFF, 0xDA, 0, 8]);
    stream.extend(header);
    stream.extend(data);
    stream.extend([0xFF, 0xD9]);
    stream
}

#[track_caller]
fn within(originals: &[u8], decoded: &[u8], near: u8) {
    assert_eq!(originals.len(), decoded.len());
    let farthest = originals
        .iter()
        .zip(decoded)
        .map(|(a, b)| a.abs_diff(*b))
        .max();
    assert!(farthest <= Some(near), "a sample is {farthest:?} off");
}

/// The three planes of test8, coded one after the other without and with loss.
#[test]
fn each_scan_of_a_color_image_is_read_and_written_alike() {
    for (file, near) in [("t8c0e0.jls", 0), ("t8c0e3.jls", 3)] {
        let Some(stream) = read(file) else { return };
        let scans = scans(&stream);
        assert_eq!(scans.len(), 3);
        for (scan, (plane, picture)) in scans.into_iter().zip(NAMES) {
            let (width, height, originals) = pgm(picture).expect(picture);
            let decoded = decode(&alone(width, height, scan), width, height);
            let decoded = decoded.unwrap_or_else(|error| panic!("{file}, {plane}: {error}"));
            within(&originals, &decoded, near);

            let encoded = encode(
                &originals,
                width,
                height,
                &JpegLsOptions {
                    near,
                    presets: None,
                },
            );
            assert!(encoded.samples == decoded, "{file}, {plane}: other samples");
            let [(_, ours)] = scans_of_one(&encoded.stream);
            assert!(ours == scan.1, "{file}, {plane}: other bits");
        }
    }
}

fn scans_of_one(stream: &[u8]) -> [(&[u8], &[u8]); 1] {
    scans(stream).try_into().expect("one scan")
}

/// The blue plane in half the size, with thresholds and RESET of its own.
#[test]
fn preset_parameters_are_obeyed_to_the_last_byte() {
    let presets = Some(PresetParameters {
        maxval: 255,
        t1: 9,
        t2: 9,
        t3: 9,
        reset: 31,
    });
    for (file, near) in [("t8nde0.jls", 0), ("t8nde3.jls", 3)] {
        let (Some(stream), Some((width, height, originals))) = (read(file), pgm("test8bs2.pgm"))
        else {
            return;
        };
        let decoded =
            decode(&stream, width, height).unwrap_or_else(|error| panic!("{file}: {error}"));
        within(&originals, &decoded, near);
        let encoded = encode(&originals, width, height, &JpegLsOptions { near, presets });
        assert!(encoded.samples == decoded, "{file}: other samples");
        assert!(encoded.stream == stream, "{file}: other bytes");
    }
}

#[test]
fn a_file_by_hewlett_packard_is_read_and_written_alike() {
    let file = "tulips-gray-8bit-512-512-hp-encoder.jls";
    let (Some(stream), Some((width, height, originals))) =
        (read(file), pgm("tulips-gray-8bit-512-512.pgm"))
    else {
        return;
    };
    assert!(decode(&stream, width, height).expect(file) == originals);
    let encoded = encode(
        &originals,
        width,
        height,
        &JpegLsOptions {
            near: 0,
            presets: None,
        },
    );
    assert!(encoded.stream == stream, "other bytes");
}

/// Color images as they are, of three components, are refused.
#[test]
fn a_color_image_is_no_plane() {
    for file in ["t8c0e0.jls", "t8c1e3.jls", "t8c2e0.jls", "t8sse3.jls"] {
        let Some(stream) = read(file) else { return };
        let error = jpeg_ls::decode(&stream, 256, 256).expect_err(file);
        assert_eq!(
            error.to_string(),
            "byte 11: expected one component, found 3",
            "{file}"
        );
    }
}
