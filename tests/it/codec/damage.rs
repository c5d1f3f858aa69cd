//! Tests damaged streams. The decoders must refuse them or return the requested number of samples.

use ptm::codec::{StreamError, StreamFault, jpeg, jpeg_ls};

use crate::random::Rng;

type Decode = fn(&[u8], u32, u32) -> Result<Vec<u8>, StreamError>;

/// Generates an image with flat rows at the top, a slope in the middle, and noise at the bottom.
fn image(width: u32, height: u32, rng: &mut Rng) -> Vec<u8> {
    let texel = |x: u32, y: u32, noise: u8| match 3 * y / height {
        0 => 77,
        1 => u8::try_from((3 * x + 5 * y) % 256).expect("a byte"),
        _ => noise,
    };
    (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| texel(x, y, rng.byte()))
        .collect()
}

const SIZES: [(u32, u32); 5] = [(1, 1), (8, 8), (17, 9), (40, 30), (3, 50)];

/// A decoder, and streams with their widths and heights.
type Streams = (Decode, Vec<(Vec<u8>, u32, u32)>);

fn jpeg_streams() -> Streams {
    let (mut rng, mut streams) = (Rng(1), Vec::new());
    for (width, height) in SIZES {
        for (quality, optimized) in [10, 75, 100]
            .map(|quality| [(quality, false), (quality, true)])
            .concat()
        {
            let options = jpeg::JpegOptions {
                baseline: optimized,
                optimized,
                restart_interval: if optimized { 2 } else { 0 },
                ..jpeg::JpegOptions::new(quality)
            };
            let samples = image(width, height, &mut rng);
            let encoded = jpeg::encode(&samples, width, height, &options);
            streams.push((encoded.stream, width, height));
        }
    }
    (jpeg::decode, streams)
}

fn jpeg_ls_streams() -> Streams {
    let (mut rng, mut streams) = (Rng(2), Vec::new());
    for (width, height) in SIZES {
        for (near, reset) in [0, 1, 9]
            .map(|near| [(near, None), (near, Some(5))])
            .concat()
        {
            let presets = reset.map(|reset| jpeg_ls::PresetParameters {
                reset,
                ..Default::default()
            });
            let options = jpeg_ls::JpegLsOptions {
                near,
                precision: 8,
                presets,
            };
            let samples = image(width, height, &mut rng);
            let encoded = jpeg_ls::encode(&samples, width, height, &options);
            streams.push((encoded.stream, width, height));
        }
    }
    (jpeg_ls::decode, streams)
}

/// A damaged stream is decoded, or refused with an offset within the stream.
#[test]
fn damaged_streams_cause_no_panic() {
    for (decode, streams) in [jpeg_streams(), jpeg_ls_streams()] {
        let mut rng = Rng(3);
        let mut outcomes = [0; 3];
        for (stream, width, height) in streams.iter().cycle().take(5_000) {
            let mut damaged = stream.clone();
            rng.damage(&mut damaged, 200);
            let outcome = match decode(&damaged, *width, *height) {
                Ok(samples) => {
                    assert_eq!(samples.len(), (width * height) as usize);
                    0
                }
                Err(error) => {
                    let length = damaged.len();
                    assert!(error.offset <= length, "{error} in {length} bytes");
                    1 + usize::from(error.fault != StreamFault::Malformed)
                }
            };
            outcomes[outcome] += 1;
        }
        println!("{outcomes:?} decoded, malformed, unsupported");
    }
}

/// Every truncated stream is refused, and so is every stream if a different size is requested, however large that size is.
#[test]
fn truncated_or_resized_streams_are_malformed() {
    for (decode, streams) in [jpeg_streams(), jpeg_ls_streams()] {
        for (stream, width, height) in streams {
            let assert_malformed = |stream: &[u8], width, height| {
                let error = decode(stream, width, height).expect_err("an error");
                assert_eq!(
                    error.fault,
                    StreamFault::Malformed,
                    "{error}, {} bytes",
                    stream.len()
                );
            };
            for end in 0..stream.len() {
                assert_malformed(&stream[..end], width, height);
            }
            assert_malformed(&stream, width + 1, height);
            assert_malformed(&stream, width, height + 1);
            assert_malformed(&stream, 0, 0);
            assert_malformed(&stream, u32::MAX, u32::MAX);
            assert_malformed(&stream, 65_536 + width, height);
        }
    }
}
