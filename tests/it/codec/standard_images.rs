//! The conformance images of T.87 (Annex E), and one file by Hewlett-Packard's own encoder.
//!
//! They are not in the repository; without them the tests say so and pass. The color images are cut into their scans where
//! these have one component each; of the interleaved ones, only those of one component can be read.

use std::path::Path;

use ptm_conform::codec::Encoded;
use ptm_conform::codec::jpeg_ls::{JpegLsOptions, PresetParameters, decode, encode};

const NAMES: [(&str, &str); 3] = [
    ("R", "test8r.pgm"),
    ("G", "test8g.pgm"),
    ("B", "test8b.pgm"),
];

fn read(name: &str) -> Option<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/t87-conformance");
    if !folder.exists() {
        println!("SKIPPED: {name}: the folder ../shared/data/t87-conformance is missing");
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
        let length = file[start..].iter().position(u8::is_ascii_whitespace);
        at += length.expect("a word") + 1;
        String::from_utf8_lossy(&file[start..at - 1]).into_owned()
    };
    assert_eq!(word(), "P5");
    let [width, height] = [word(), word()].map(|side| side.parse().expect("a side"));
    assert_eq!(word(), "255");
    Some((width, height, file[at..].to_vec()))
}

/// Returns the scans of a stream: the content of the scan header, and the entropy-coded data after it.
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

/// Makes an image of one scan of a color image.
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
    let mut pairs = originals.iter().zip(decoded);
    assert!(pairs.all(|(a, b)| a.abs_diff(*b) <= near));
}

/// Encodes without preset parameters.
fn plainly_encoded(samples: &[u8], width: u32, height: u32, near: u8) -> Encoded {
    let presets = None;
    encode(samples, width, height, &JpegLsOptions { near, presets })
}

/// The three planes of test8, coded one after the other without and with loss.
#[test]
fn each_scan_of_a_color_image_is_read_and_written_alike() {
    for (file, near) in [("t8c0e0.jls", 0), ("t8c0e3.jls", 3)] {
        let Some(stream) = read(file) else { return };
        let scans = scans(&stream);
        assert_eq!(scans.len(), 3);
        for (scan, (plane, image)) in scans.into_iter().zip(NAMES) {
            let (width, height, originals) = pgm(image).expect(image);
            let decoded = decode(&alone(width, height, scan), width, height);
            let decoded = decoded.unwrap_or_else(|error| panic!("{file}, {plane}: {error}"));
            within(&originals, &decoded, near);

            let encoded = plainly_encoded(&originals, width, height, near);
            assert!(encoded.samples == decoded, "{file}, {plane}: other samples");
            let [(_, ours)] = scans_of_one(&encoded.stream);
            assert!(ours == scan.1, "{file}, {plane}: other bits");
        }
    }
}

fn scans_of_one(stream: &[u8]) -> [(&[u8], &[u8]); 1] {
    scans(stream).try_into().expect("one scan")
}

/// The blue plane in half the size, with other thresholds and RESET.
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
    let encoded = plainly_encoded(&originals, width, height, 0);
    assert!(encoded.stream == stream, "other bytes");
}

/// Color images as they are, of three components, are refused.
#[test]
fn a_color_image_is_refused() {
    for file in ["t8c0e0.jls", "t8c1e3.jls", "t8c2e0.jls", "t8sse3.jls"] {
        let Some(stream) = read(file) else { return };
        let error = decode(&stream, 256, 256).expect_err(file);
        let message = "byte 11: expected one component, found 3";
        assert_eq!(error.to_string(), message, "{file}");
    }
}
