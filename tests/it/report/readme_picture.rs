//! The picture in the README is made by this program: the lit scene, right and as decoders with one mistake show it.

use std::fs;
use std::path::Path;

use crate::common::repository;
use ptm_conform::Reading;
use ptm_conform::generate::spelling::Count;
use ptm_conform::misreadings::{self, Misreading};
use ptm_conform::protocol::frame::{Answer, View};
use ptm_conform::ptm::Format;
use ptm_conform::session::lit_scene::{SIDE, file, picture};

/// The mistakes, in the order of the picture, whose first one has none.
const MISTAKES: [Option<&str>; 6] = [
    None,
    Some("rows-top-down"),
    Some("v-negated"),
    Some("color-block-bgr"),
    Some("bias-ignored"),
    Some("lrgb-coefficients-in-planes"),
];
/// A texel is so many pixels wide and high.
const SCALE: usize = 2;
const GAP: usize = 8;

#[test]
fn the_picture_is_what_the_program_makes() {
    let file = file(Format::Lrgb, Count::default());
    let view: View = "rgb:-0.5,0.5".parse().expect("a view");
    let pictures = MISTAKES.map(|slug| {
        let mistake = slug.map(|slug| misreadings::named(slug).expect("a misreading"));
        let mistakes: Vec<&Misreading> = mistake.into_iter().collect();
        let answer = misreadings::answer(&mistakes, Reading::SPEC, &file, &view);
        let Answer::Decoded(frame) = answer else {
            panic!("{slug:?}: a picture")
        };
        picture(&file, &frame).expect("of the scene")
    });
    let distinct: std::collections::BTreeSet<_> = pictures.iter().collect();
    assert_eq!(distinct.len(), pictures.len(), "two mistakes look alike");
    let png = side_by_side(&pictures);
    assert!(png.len() <= 60_000, "{} bytes", png.len());
    let made = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mistakes.png");
    fs::write(&made, &png).expect("a file");
    let kept = fs::read(repository("docs/mistakes.png")).unwrap_or_default();
    assert!(kept == png, "copy {} to docs/mistakes.png", made.display());
}

fn side_by_side(pictures: &[Vec<u8>]) -> Vec<u8> {
    let side = SIDE as usize * SCALE;
    let width = pictures.len() * (side + GAP) - GAP;
    let mut pixels = vec![0; width * side * 4];
    for (i, picture) in pictures.iter().enumerate() {
        for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
            let from = 3 * (y / SCALE * SIDE as usize + x / SCALE);
            let to = 4 * (y * width + i * (side + GAP) + x);
            pixels[to..to + 3].copy_from_slice(&picture[from..from + 3]);
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
