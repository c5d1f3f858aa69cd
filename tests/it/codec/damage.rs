//! Streams with bytes changed, lost and doubled: the decoders answer, and if they answer with
//! samples, these are as many as were asked for.

use ptm_conform::codec::{StreamError, StreamFault, jpeg, jpeg_ls};

type Decode = fn(&[u8], u32, u32) -> Result<Vec<u8>, StreamError>;

/// A linear congruential generator; each draw is its upper 16 bits.
struct Draws(u32);

impl Draws {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 16) as usize % end
    }

    fn byte(&mut self) -> u8 {
        u8::try_from(self.below(256)).expect("a byte")
    }
}

/// Pictures with something of everything: flat above, noise below, a slope in between.
fn picture(width: u32, height: u32, draws: &mut Draws) -> Vec<u8> {
    let texel = |x: u32, y: u32, noise: u8| match 3 * y / height {
        0 => 77,
        1 => u8::try_from((3 * x + 5 * y) % 256).expect("a byte"),
        _ => noise,
    };
    (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| texel(x, y, draws.byte()))
        .collect()
}

const SIZES: [(u32, u32); 5] = [(1, 1), (8, 8), (17, 9), (40, 30), (3, 50)];

fn jpeg_streams() -> Vec<(Vec<u8>, u32, u32)> {
    let mut draws = Draws(1);
    let mut streams = Vec::new();
    for (width, height) in SIZES {
        for quality in [10, 75, 100] {
            for optimized in [false, true] {
                let plain = jpeg::JpegOptions::new(quality);
                let interval = if optimized { 2 } else { 0 };
                let options = jpeg::JpegOptions {
                    baseline: optimized,
                    optimized,
                    restart_interval: interval,
                    ..plain
                };
                let samples = picture(width, height, &mut draws);
                streams.push((
                    jpeg::encode(&samples, width, height, &options).stream,
                    width,
                    height,
                ));
            }
        }
    }
    streams
}

fn jpeg_ls_streams() -> Vec<(Vec<u8>, u32, u32)> {
    let mut draws = Draws(2);
    let mut streams = Vec::new();
    for (width, height) in SIZES {
        for near in [0, 1, 9] {
            for reset in [None, Some(5)] {
                let presets = reset.map(|reset| jpeg_ls::PresetParameters {
                    reset,
                    ..Default::default()
                });
                let options = jpeg_ls::JpegLsOptions { near, presets };
                let samples = picture(width, height, &mut draws);
                streams.push((
                    jpeg_ls::encode(&samples, width, height, &options).stream,
                    width,
                    height,
                ));
            }
        }
    }
    streams
}

fn damage(stream: &mut Vec<u8>, draws: &mut Draws) {
    for _ in 0..=draws.below(3) {
        let at = draws.below(stream.len());
        match draws.below(7) {
            0 => stream[at] ^= 1 << draws.below(8),
            1 => stream[at] = draws.byte(),
            2 => stream[at] = [0x00, 0xFF, 0x7F, 0x80, 0xD9][draws.below(5)],
            3 => drop(stream.remove(at)),
            4 => stream.insert(at, draws.byte()),
            5 => stream.truncate(at.max(1)),
            _ => {
                let end = at + draws.below(stream.len() - at);
                stream.extend_from_within(at..end);
            }
        }
        if stream.is_empty() {
            return;
        }
    }
}

/// Damages streams so many times; returns how often they were decoded, malformed and unsupported.
fn survive(decode: Decode, streams: &[(Vec<u8>, u32, u32)], times: usize) -> [usize; 3] {
    let mut draws = Draws(3);
    let mut outcomes = [0; 3];
    for i in 0..times {
        let (stream, width, height) = &streams[i % streams.len()];
        let mut damaged = stream.clone();
        damage(&mut damaged, &mut draws);
        let outcome = match decode(&damaged, *width, *height) {
            Ok(samples) => {
                assert_eq!(samples.len(), (width * height) as usize);
                0
            }
            Err(error) => {
                assert!(
                    error.offset <= damaged.len(),
                    "{error} in {} bytes",
                    damaged.len()
                );
                if error.fault == StreamFault::Malformed {
                    1
                } else {
                    2
                }
            }
        };
        outcomes[outcome] += 1;
    }
    println!("{times} streams: {outcomes:?} decoded, malformed, unsupported");
    outcomes
}

#[test]
fn damaged_streams_are_survived() {
    survive(jpeg::decode, &jpeg_streams(), 5_000);
    survive(jpeg_ls::decode, &jpeg_ls_streams(), 5_000);
}

#[test]
#[ignore = "the same for longer"]
fn many_damaged_streams_are_survived() {
    survive(jpeg::decode, &jpeg_streams(), 100_000);
    survive(jpeg_ls::decode, &jpeg_ls_streams(), 100_000);
}

/// A stream that ends early is never taken for a whole one, wherever it ends.
#[test]
fn streams_cut_short_are_malformed() {
    let all = jpeg_streams()
        .into_iter()
        .map(|stream| (jpeg::decode as Decode, stream));
    let all = all.chain(
        jpeg_ls_streams()
            .into_iter()
            .map(|stream| (jpeg_ls::decode as Decode, stream)),
    );
    for (decode, (stream, width, height)) in all {
        for end in 0..stream.len() {
            let error = decode(&stream[..end], width, height).expect_err("an error");
            assert_eq!(
                error.fault,
                StreamFault::Malformed,
                "{error}, {end} of {} bytes",
                stream.len()
            );
        }
    }
}

/// Any size but the stream's own is refused, however large.
#[test]
fn streams_of_another_size_are_malformed() {
    for (decode, streams) in [
        (jpeg::decode as Decode, jpeg_streams()),
        (jpeg_ls::decode, jpeg_ls_streams()),
    ] {
        for (stream, width, height) in streams {
            for (w, h) in [
                (width + 1, height),
                (width, height + 1),
                (0, 0),
                (u32::MAX, u32::MAX),
                (65_536 + width, height),
            ] {
                let error = decode(&stream, w, h).expect_err("an error");
                assert_eq!(error.fault, StreamFault::Malformed, "{error}");
            }
        }
    }
}

/// The encoders know what decoders will make of their streams.
#[test]
fn encoders_know_the_decoded_samples() {
    let mut draws = Draws(4);
    for (width, height) in SIZES {
        let samples = picture(width, height, &mut draws);
        for quality in 1..=100 {
            let encoded = jpeg::encode(&samples, width, height, &jpeg::JpegOptions::new(quality));
            assert_eq!(
                jpeg::decode(&encoded.stream, width, height),
                Ok(encoded.samples)
            );
        }
        for near in 0..=127 {
            let options = jpeg_ls::JpegLsOptions {
                near,
                presets: None,
            };
            let encoded = jpeg_ls::encode(&samples, width, height, &options);
            let farthest = samples
                .iter()
                .zip(&encoded.samples)
                .map(|(a, b)| a.abs_diff(*b))
                .max();
            assert!(farthest <= Some(near), "NEAR {near}: {farthest:?}");
            assert_eq!(
                jpeg_ls::decode(&encoded.stream, width, height),
                Ok(encoded.samples)
            );
        }
    }
}
