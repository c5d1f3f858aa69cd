//! Compares streams and samples with those of libjpeg and `CharLS` for every image in witnesses.txt.
//!
//! The file contains recipes and digests. It was written by `scripts/codec_witnesses.py`, which generates each image from its
//! recipe, encodes and decodes it with those codecs, and records the digests. This test generates the same images.

#![allow(
    clippy::manual_midpoint,
    clippy::manual_is_multiple_of,
    reason = "the formulas are written as in the script"
)]

use ptm::codec::jpeg_ls::PresetParameters;
use ptm::codec::{EncodedImage, jpeg, jpeg_ls};
use ptm_suite::kit::digest::sha256;

use crate::random::Rng;

/// A line of witnesses.txt.
struct Witness {
    recipe: &'static str,
    kind: &'static str,
    width: u32,
    height: u32,
    parameters: &'static str,
    seed: u32,
    stream: &'static str,
    samples: &'static str,
}

fn witnesses(codec: &str) -> Vec<Witness> {
    let lines = include_str!("witnesses.txt").lines();
    let lines = lines.filter(|line| line.split(' ').next() == Some(codec));
    let witness = |recipe: &'static str| {
        let words: Vec<&str> = recipe.split(' ').collect();
        let [_, kind, width, height, parameters, seed, stream, samples] = words[..] else {
            panic!("a witness has eight words: {recipe}")
        };
        let [width, height, seed] = [width, height, seed].map(|word| word.parse().expect(recipe));
        Witness {
            recipe,
            kind,
            width,
            height,
            parameters,
            seed,
            stream,
            samples,
        }
    };
    lines.map(witness).collect()
}

#[expect(clippy::many_single_char_names, reason = "variables of formulas")]
fn paint(witness: &Witness) -> Vec<u8> {
    let &Witness {
        kind,
        width,
        height,
        seed,
        ..
    } = witness;
    let mut rng = Rng(seed);
    let (p, q, s) = (rng.next(), rng.next(), rng.next());
    let mut samples: Vec<u8> = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let r = rng.next();
            let value = match kind {
                "noise" => r >> 8,
                "gradient" => (x * (p % 7) + y * (q % 5) + s) % 256,
                "smooth" => (x * (p >> 8) / width + y * (q >> 8) / height) / 2 + r % 4,
                "checker" => (x / (1 + p % 9) + y / (1 + p % 9)) % 2 * 255,
                "flat" => p >> 8,
                "residual" => 113 + r % 16 + (r >> 8) % 16,
                "wrapped" => (r % 16 + 248) % 256,
                "dots" => (if r % 37 == 0 { r } else { p }) >> 8,
                "walk" => {
                    let i = samples.len();
                    let left = if x > 0 { samples[i - 1] } else { 128 };
                    let above = if y > 0 {
                        samples[i - width as usize]
                    } else {
                        left
                    };
                    let (left, above) = (u32::from(left), u32::from(above));
                    ((left + above) / 2 + r % 32).saturating_sub(15).min(255)
                }
                _ => panic!("unknown kind {kind}"),
            };
            samples.push(u8::try_from(value).expect("a sample"));
        }
    }
    samples
}

fn jpeg_options(parameters: &str) -> jpeg::JpegOptions {
    let mut options = jpeg::JpegOptions::new(75);
    for parameter in parameters.split(',') {
        let number = |text: &str| text.parse().expect(parameters);
        match parameter.split_once('=') {
            Some(("restart", blocks)) => {
                options.restart_interval = blocks.parse().expect(parameters);
            }
            Some(("sampling", factors)) => {
                let (h, v) = factors.split_once('x').expect(parameters);
                options.sampling = (number(h), number(v));
            }
            None if parameter == "optimised" => options.optimized = true,
            None if parameter == "extended" => options.baseline = false,
            _ => options.quality = number(parameter.strip_prefix('q').expect(parameters)),
        }
    }
    options
}

fn jpeg_ls_options(parameters: &str) -> jpeg_ls::JpegLsOptions {
    let mut options = jpeg_ls::JpegLsOptions {
        near: 0,
        precision: 8,
        presets: None,
    };
    for parameter in parameters.split(',') {
        match parameter.split_once('=') {
            Some(("near", near)) => options.near = near.parse().expect(parameters),
            Some(("bits", bits)) => options.precision = bits.parse().expect(parameters),
            Some(("presets", values)) => {
                let values = values.split(':');
                let values: Vec<u16> = values
                    .map(|value| value.parse().expect(parameters))
                    .collect();
                let [maxval, t1, t2, t3, reset] = values[..] else {
                    panic!("{parameters}")
                };
                options.presets = Some(PresetParameters {
                    maxval,
                    t1,
                    t2,
                    t3,
                    reset,
                });
            }
            _ => panic!("{parameters}"),
        }
    }
    options
}

/// Returns the bytes between the scan header and EOI. The segments must be those of our encoder.
fn scan_bytes(stream: &[u8]) -> &[u8] {
    let mut at = 2;
    loop {
        let code = stream[at + 1];
        at += 2 + usize::from(u16::from_be_bytes([stream[at + 2], stream[at + 3]]));
        if code == 0xDA {
            return &stream[at..stream.len() - 2];
        }
    }
}

#[track_caller]
fn compare(witness: &Witness, digested: &[u8], encoded: &EncodedImage, decoded: &[u8]) {
    let recipe = witness.recipe;
    assert_eq!(sha256(digested), witness.stream, "the stream of {recipe}");
    assert_eq!(sha256(decoded), witness.samples, "the samples of {recipe}");
    assert!(
        encoded.samples == decoded,
        "the samples of the encoder of {recipe}"
    );
}

#[test]
fn jpeg_streams_and_samples_equal_those_of_libjpeg() {
    let witnesses = witnesses("jpeg");
    assert!(witnesses.len() >= 500);
    for witness in &witnesses {
        let options = jpeg_options(witness.parameters);
        let encoded = jpeg::encode(&paint(witness), witness.width, witness.height, &options);
        let decoded =
            jpeg::decode(&encoded.stream, witness.width, witness.height).expect("an image");
        compare(witness, &encoded.stream, &encoded, &decoded);
    }
}

#[test]
fn jpeg_ls_scans_and_samples_equal_those_of_charls() {
    let witnesses = witnesses("jpeg-ls");
    assert!(witnesses.len() >= 1500);
    for witness in &witnesses {
        let options = jpeg_ls_options(witness.parameters);
        let mut originals = paint(witness);
        for sample in &mut originals {
            *sample >>= 8 - options.precision;
        }
        let encoded = jpeg_ls::encode(&originals, witness.width, witness.height, &options);
        let decoded =
            jpeg_ls::decode(&encoded.stream, witness.width, witness.height).expect("an image");
        compare(witness, scan_bytes(&encoded.stream), &encoded, &decoded);
        let mut pairs = originals.iter().zip(&decoded);
        let are_near = pairs.all(|(&a, &b)| a.abs_diff(b) <= options.near);
        assert!(are_near, "{}: an error exceeds NEAR", witness.parameters);
    }
}
