//! Tests that the scene of the report shows every mistake that changes the colors of ordinary files.

use std::collections::BTreeSet;

use ptm::{Format, Reading};
use ptm_harness::session::lit_scene::{LIGHT, SceneFile, differ_visibly};
use ptm_mistakes::Misreading;
use ptm_suite::cases::{Suite, TableSpelling};
use ptm_suite::protocol::frame::{Frame, Samples, View};

/// Mistakes that change the colors of an ordinary file, but not visibly those of the scene. A report on such a decoder has no
/// picture.
const INVISIBLE: &str = "\
text-mode-universal: only files with certain bytes change
last-texel-lost: a single texel differs
bias-over-256: colors differ by at most 1
coefficient-truncated: final values differ by less than 1
coefficient-rounded: final values differ by less than 1
coefficient-floored: final values differ by less than 1
coefficient-in-16-bits: final values differ by less than 1
square-only: the scene is square
height-before-width: the scene is square
luminance-truncated: colors differ by at most 1
color-over-256: colors differ by at most 1
color-over-256-truncated: colors differ by at most 2
colors-in-half-precision: colors differ by at most 1";

fn colors(mistakes: &[&Misreading], file: &[u8], view: &View) -> Option<Vec<u8>> {
    let answer = ptm_mistakes::answer(mistakes, Reading::SPEC, file, view);
    match answer.decoded::<Frame>().ok()?.samples {
        Samples::U8(colors) => Some(colors),
        Samples::F32(_) => None,
    }
}

#[test]
fn scene_shows_every_mistake_that_changes_ordinary_colors() {
    let suite = Suite::load().expect("the suite");
    let default: View = View::DEFAULT_RGB.parse().expect("a view");
    let lit: View = format!("rgb:{},{}", LIGHT.0, LIGHT.1)
        .parse()
        .expect("a view");
    let first = suite.cases.iter().filter(|case| case.first);
    let ordinary: Vec<Vec<u8>> = first
        .map(|case| case.build(TableSpelling::default()).file.clone())
        .collect();
    let scenes: Vec<Vec<u8>> = Format::ALL
        .into_iter()
        .flat_map(SceneFile::all)
        .map(|spellings| spellings[0].bytes())
        .collect();
    let differs = |files: &[Vec<u8>],
                   view: &View,
                   mistake: &Misreading,
                   differ: fn(&[u8], &[u8]) -> bool| {
        files.iter().any(|file| {
            let images = [&[][..], &[mistake]].map(|mistakes| colors(mistakes, file, view));
            matches!(images, [Some(correct), Some(wrong)] if correct.len() == wrong.len() && differ(&correct, &wrong))
        })
    };
    let listed: BTreeSet<&str> = INVISIBLE
        .lines()
        .map(|line| line.split_once(": ").expect("a name and a reason").0)
        .collect();
    let mut invisible = BTreeSet::new();
    for mistake in ptm_mistakes::all() {
        if differs(&ordinary, &default, mistake, |a, b| a != b)
            && !differs(&scenes, &lit, mistake, differ_visibly)
        {
            invisible.insert(mistake.slug);
        }
    }
    assert_eq!(invisible, listed);
}
