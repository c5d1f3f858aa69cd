//! Tests that the image in the README is up to date. The image shows the lit scene as rendered by decoders with various mistakes.

use std::fs;
use std::path::Path;

use crate::common::repository;
use ptm::Format;
use ptm::Reading;
use ptm_harness::session::lit_scene::{LIGHT, SIDE, SceneFile, frame_to_image};
use ptm_mistakes::Misreading;
use ptm_suite::protocol::frame::{Answer, View};

use crate::in_process::misreading;

/// Mistakes of the decoders, in the order of their scenes from left to right. The first scene is correct.
const MISTAKES: [Option<&str>; 6] = [
    None,
    Some("rows-top-down"),
    Some("v-negated"),
    Some("color-block-bgr"),
    Some("bias-ignored"),
    Some("lrgb-coefficients-in-planes"),
];
/// Width and height of a texel in pixels.
const SCALE: usize = 2;
const GAP_PIXELS: usize = 8;

#[test]
fn readme_image_is_up_to_date() {
    let file = SceneFile::all(Format::Lrgb)[0][0].bytes();
    let view: View = format!("rgb:{},{}", LIGHT.0, LIGHT.1)
        .parse()
        .expect("a view");
    let scenes = MISTAKES.map(|slug| {
        let mistakes: Vec<&Misreading> = slug.map(misreading).into_iter().collect();
        let answer = ptm_mistakes::answer(&mistakes, Reading::SPEC, &file, &view);
        let Answer::Decoded(frame) = answer else {
            panic!("{slug:?}: no image")
        };
        frame_to_image(&file, &frame).expect("an image of the scene")
    });
    let distinct: std::collections::BTreeSet<_> = scenes.iter().collect();
    assert_eq!(distinct.len(), scenes.len(), "two mistakes look alike");
    let png = side_by_side(&scenes);
    assert!(png.len() <= 60_000, "{} bytes", png.len());
    let made = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mistakes.png");
    fs::write(&made, &png).expect("a file");
    let old = fs::read(repository("docs/mistakes.png")).unwrap_or_default();
    assert!(old == png, "copy {} to docs/mistakes.png", made.display());
}

fn side_by_side(scenes: &[Vec<u8>]) -> Vec<u8> {
    let side = SIDE as usize * SCALE;
    let width = scenes.len() * (side + GAP_PIXELS) - GAP_PIXELS;
    let mut pixels = vec![0; width * side * 4];
    for (i, scene) in scenes.iter().enumerate() {
        for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
            let from = 3 * (y / SCALE * SIDE as usize + x / SCALE);
            let to = 4 * (y * width + i * (side + GAP_PIXELS) + x);
            pixels[to..to + 3].copy_from_slice(&scene[from..from + 3]);
            pixels[to + 3] = 255;
        }
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, side as u32);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header().expect("a size");
    writer.write_image_data(&pixels).expect("pixels");
    drop(writer);
    bytes
}
