//! Compares predictions about readers with the recorded responses, and tests conversions for readers.

use std::collections::BTreeMap;

use crate::in_process::suite;
use crate::recordings::{digest, recorded_answers};
use crate::table::rows;
use ptm::decode;
use ptm::evaluate::{Coefficients, compute_coefficients};
use ptm::reading::Reading;
use ptm::{Format, Planes, Ptm, Size};
use ptm_files::readers::{
    Evidence, LIGHTS, MAX_INVISIBLE_DIFFERENCE, OpenedFile, ReaderPrediction, ReaderProfile,
    Rendering, parse_profiles, profiles,
};
use ptm_files::{convert_for::convert_for, dissection::Dissection};
use ptm_suite::cases::{Case, Expect, TableSpelling};
use ptm_suite::compare::Expected;
use ptm_suite::protocol::frame::{Answer, Frame, ViewKind};

fn reader(name: &str) -> &'static ReaderProfile {
    let found = profiles().iter().find(|profile| profile.name == name);
    found.unwrap_or_else(|| panic!("no reader {name}"))
}

#[test]
fn readers_have_unique_names_and_misreadings_of_the_catalog() {
    let mut names: Vec<&str> = profiles().iter().map(|profile| &*profile.name).collect();
    assert_eq!(names.len(), 24);
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), 24);
    let slugs = profiles().iter().flat_map(|profile| &profile.misreadings);
    for known in slugs {
        assert!(ptm_mistakes::find(&known.slug).is_some(), "{}", known.slug);
    }
}

#[test]
fn impossible_profiles_are_refused() {
    for [more, why] in rows(
        "
reads: [GIF] | unknown format GIF
reads: [RGB]↵  misreadings: [{ slug: none, evidence: code }] | unknown misreading none
reads: [RGB]↵  misreadings: [{ slug: no-128, evidence: code }, { slug: wrap-mod-255, evidence: code }]
  | change the same decision
reads: [RGB]↵  limits: [{ limit: none, evidence: code }] | none
reads: [RGB]↵  likes: all | likes",
    ) {
        let yaml = format!("- name: x\n  reader: x/y\n  evidence: code\n  {more}\n");
        let error = parse_profiles(&yaml).expect_err("an error");
        assert!(error.to_string().contains(&why), "{error}");
    }
}

/// Returns the recorded result of a reader for each legal file.
fn recorded_results(name: &str, cases: &[&Case]) -> Vec<(usize, Rendering)> {
    let answers = recorded_answers(name);
    let shown = |place: usize| {
        let built = cases[place].build(TableSpelling::default());
        let file = digest(&built.file);
        let mut views = cases[place].views.iter();
        let (view, recorded) = views.find_map(|view| {
            let recorded = answers.get(&(file.clone(), view.to_string()))?;
            Some((view, recorded))
        })?;
        Some(match &recorded.answer {
            // An image that equals the expected one is not recorded.
            None => Rendering::Same,
            Some(Answer::Decoded(frame)) => {
                let expected = Expected::new(&built.values, view).expect("a legal file has values");
                match expected.compare(frame) {
                    None => Rendering::Same,
                    Some(_) if is_nearly_equal(&built.file, &expected, frame) => {
                        Rendering::NearlySame
                    }
                    Some(_) => Rendering::Wrong,
                }
            }
            Some(_) => Rendering::Nothing,
        })
    };
    let indices = 0..cases.len();
    indices
        .filter_map(|index| Some((index, shown(index)?)))
        .collect()
}

/// Returns true if the images of a recorded frame differ by at most [`MAX_INVISIBLE_DIFFERENCE`] from the expected ones: the image in
/// the frame, or those under [`LIGHTS`] if the frame has values or coefficients.
fn is_nearly_equal(file: &[u8], expected: &Expected, frame: &Frame) -> bool {
    let (width, height) = (frame.width, frame.height);
    let size = Size { width, height };
    let received = frame.samples.to_reals();
    if size != expected.size || received.len() != expected.values.len() {
        return false;
    }
    let is_close = |a: f64, b: f64| {
        let difference = (a.round() as u8).abs_diff(b.round() as u8);
        difference <= MAX_INVISIBLE_DIFFERENCE
    };
    let are_close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(&a, &b)| is_close(a, b));
    let Ptm { header, planes } = decode(file).expect("a legal file");
    let finals = |values: &[f64]| match frame.view {
        ViewKind::Raw => {
            let samples = values.iter().map(|&value| value as u8).collect();
            let planes = Planes { samples, ..planes };
            compute_coefficients(&header.scale_bias, &planes, &Reading::SPEC)
        }
        _ => Coefficients {
            size: planes.size,
            shape: planes.shape,
            values: values.to_vec(),
        },
    };
    if frame.view == ViewKind::Rgb {
        // The reader may round in another way.
        let mut pairs = expected.values.iter().zip(&received);
        let tolerance = f64::from(MAX_INVISIBLE_DIFFERENCE) + 1.0 + 1.0 / 64.0;
        return pairs.all(|(a, b)| (a - b).abs() <= tolerance);
    }
    let (ours, theirs) = (finals(&expected.values), finals(&received));
    LIGHTS.into_iter().all(|(lu, lv)| {
        let [ours, theirs] = [&ours, &theirs].map(|finals| finals.evaluate(lu, lv));
        are_close(&ours.values, &theirs.values)
    })
}

/// Counts of predictions and recorded results.
#[derive(Default)]
struct Tally {
    /// Number of files by prediction and recorded result.
    pairs: BTreeMap<(Rendering, Rendering), usize>,
}

impl Tally {
    fn add(&mut self, predicted: Rendering, seen: Rendering) {
        *self.pairs.entry((predicted, seen)).or_default() += 1;
    }

    fn count(&self, matches: impl Fn(Rendering, Rendering) -> bool) -> usize {
        let pairs = self.pairs.iter();
        let pairs = pairs.filter(|((predicted, seen), _)| matches(*predicted, *seen));
        pairs.map(|(_, count)| count).sum()
    }

    /// Returns the precision and recall of predictions for the results that satisfy `matches`.
    fn scores(&self, matches: impl Fn(Rendering) -> bool) -> (f64, f64) {
        let both = self.count(|predicted, seen| matches(predicted) && matches(seen)) as f64;
        let share = |all: usize| both / (all.max(1) as f64);
        (
            share(self.count(|predicted, _| matches(predicted))),
            share(self.count(|_, seen| matches(seen))),
        )
    }
}

#[test]
fn predictions_match_recorded_readers() {
    let suite = suite();
    let is_small = |case: &Case| case.build(TableSpelling::default()).file.len() <= 4096;
    let legal = suite.cases.iter();
    let legal = legal.filter(|case| case.expect == Expect::Decode && is_small(case));
    let cases: Vec<&Case> = legal.collect();
    let mut all = Tally::default();
    for name in [
        "cceh-rti",
        "jedmills",
        "oxrti",
        "ptmconvert",
        "relight",
        "rtiprep",
        "rtiviewer",
    ] {
        let profile = reader(name.trim_end_matches("-rti"));
        let mut tally = Tally::default();
        for (place, seen) in recorded_results(name, &cases) {
            let file = &cases[place].build(TableSpelling::default()).file;
            let predicted = OpenedFile::new(file).predict(profile).result;
            // A map may be nearly the same under the recorded light, and wrong under another one.
            let seen = match (predicted, seen) {
                (Rendering::Wrong, Rendering::NearlySame) => Rendering::Wrong,
                _ => seen,
            };
            tally.add(predicted, seen);
            all.add(predicted, seen);
        }
        // Users want to know which files are displayed correctly.
        let scores = report(name, &tally);
        assert!(scores[3] >= 0.95, "{name}: {:?}", tally.pairs);
    }
    let scores = report("all", &all);
    assert!(scores.iter().all(|&score| score >= 0.95), "{:?}", all.pairs);
}

/// Prints the precision and recall of every kind of prediction, and returns the smaller of the two for each kind.
fn report(name: &str, tally: &Tally) -> [f64; 4] {
    let kinds: [(&str, fn(Rendering) -> bool); 4] = [
        ("right", Rendering::is_right),
        ("wrong", |shown| shown == Rendering::Wrong),
        ("nothing", |shown| shown == Rendering::Nothing),
        ("not right", |shown| !shown.is_right()),
    ];
    kinds.map(|(kind, matches)| {
        let (precision, recall) = tally.scores(matches);
        println!("{name}, {kind}: precision {precision:.3}, recall {recall:.3}");
        precision.min(recall)
    })
}

#[test]
fn files_converted_for_a_reader_keep_the_map() {
    let suite = suite();
    let mut counts: BTreeMap<Format, usize> = BTreeMap::new();
    let (mut converted, mut refused) = (0, 0);
    let legal = suite
        .cases
        .iter()
        .filter(|case| case.expect == Expect::Decode);
    for case in legal {
        let count = counts.entry(case.format()).or_default();
        let file = &case.build(TableSpelling::default()).file;
        if *count >= 6 || file.len() > 16_384 {
            continue;
        }
        *count += 1;
        let dissection = Dissection::parse(file);
        let ptm = dissection.outcome.as_ref().expect("a legal file");
        for name in ["cceh", "relight", "rtiviewer", "joncooper"] {
            match convert_for(&dissection, ptm, &[reader(name)]) {
                Ok((_, made)) => {
                    let back = decode(&made.bytes).expect("a legal file");
                    assert_same_map(ptm, &back, &case.id);
                    let shown = OpenedFile::new(&made.bytes).predict(reader(name)).result;
                    assert!(shown.is_right(), "{} for {name}", case.id);
                    converted += 1;
                }
                Err(why) => {
                    assert!(why.to_string().contains(name), "{why}");
                    refused += 1;
                }
            }
        }
    }
    assert_eq!(counts.values().sum::<usize>(), 54);
    println!("{converted} converted, {refused} refused with a reason");
    assert!(converted > 90);
}

/// Asserts that two maps have equal colors under six lights and, if they have the same shape, equal final coefficients.
#[track_caller]
fn assert_same_map(a: &ptm::Ptm, b: &ptm::Ptm, id: &str) {
    let (a, b) = (a.coefficients(), b.coefficients());
    if a.shape == b.shape {
        assert_eq!(a.values, b.values, "{id}");
    }
    let lights = [
        (0.0, 0.0),
        (0.5, 0.0),
        (0.0, 0.5),
        (-0.5, 0.25),
        (0.25, -0.5),
        (0.625, 0.625),
    ];
    for (lu, lv) in lights {
        let images = [a.evaluate(lu, lv), b.evaluate(lu, lv)];
        let mut pairs = images[0].values.iter().zip(&images[1].values);
        assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-6), "{id}");
    }
}

#[test]
fn wrong_images_are_described() {
    let suite = suite();
    let how = |case: &str, profile: &str| {
        let case = suite.case(case).expect("a case");
        let yaml = format!(
            "- name: x\n  reader: x\n  reads: [RGB, LRGB]\n  evidence: code\n  misreadings: [{{ slug: {profile}, evidence: code }}]\n"
        );
        let profile = parse_profiles(&yaml).expect("a profile").remove(0);
        OpenedFile::new(&case.build(TableSpelling::default()).file)
            .predict(&profile)
            .fault
    };
    for (misreading, words) in [
        ("rows-top-down", "upside down"),
        ("mirrored", "mirrored"),
        ("rgb-blocks-bgr", "red and blue swapped"),
        ("color-over-256", ""),
    ] {
        assert_eq!(how("first-rgb", misreading), words, "{misreading}");
    }
    assert!(how("first-lrgb", "luminance-over-128").starts_with("too bright"));
    assert!(how("first-lrgb", "color-divided-twice").starts_with("too dark"));
    assert!(how("first-lrgb", "v-negated").starts_with("wrong when the light moves"));
}

/// A header of version 1.2, with a size of 2 × 2 texels, and values.
const LEGAL_FILE: &[u8] = b"PTM_1.2\nPTM_FORMAT_LRGB\n2\n2\n1 1 1 1 1 1\n0 0 0 0 0 0\n\
    abcdefABCDEFghijklGHIJKLrgbRGBxyzXYZ";

/// Predicts what the reader with this name shows.
fn predict(name: &str, file: &[u8]) -> ReaderPrediction {
    OpenedFile::new(file).predict(reader(name))
}

/// Replaces the first occurrence of a text in a file.
fn replaced(file: &[u8], old: &str, new: &str) -> Vec<u8> {
    let mut windows = file.windows(old.len());
    let place = windows.position(|window| window == old.as_bytes());
    let place = place.unwrap_or_else(|| panic!("no {old:?}"));
    [&file[..place], new.as_bytes(), &file[place + old.len()..]].concat()
}

#[test]
fn only_known_behavior_is_predicted_for_files_of_version_1_1() {
    let interleaved = b"abcdefrgbABCDEFRGBghijklxyzGHIJKLXYZ";
    let file = [&replaced(LEGAL_FILE, "1.2", "1.1")[..52], interleaved].concat();
    for name in [
        "rtiviewer",
        "webglrtimaker",
        "rtiprep",
        "isf",
        "rtiparser",
        "pixelplus",
    ] {
        assert_eq!(predict(name, &file).result, Rendering::Same, "{name}");
    }
    // It divides colors by 256.
    assert!(predict("hp-java", &file).result.is_right());
    assert_eq!(predict("cceh", &file).result, Rendering::Nothing);
    assert_eq!(predict("cceh", &file).evidence, Some(Evidence::Code));
    assert_eq!(predict("claudertidemo", &file).result, Rendering::Wrong);
    let unknown = predict("make-rti-dz", &file);
    assert_eq!(unknown.result, Rendering::NotPredicted);
    assert_eq!(unknown.fault, "no evidence about files of version 1.1");
    assert_eq!(unknown.evidence, None);
}

#[test]
fn only_known_behavior_is_predicted_for_line_ends_and_biases() {
    let header = String::from_utf8(LEGAL_FILE[..52].to_vec()).expect("ASCII");
    let header = header.replace('\n', "\r\n");
    let file = [header.as_bytes(), &LEGAL_FILE[52..]].concat();
    for (name, result, evidence) in [
        ("ptmgenerator", Rendering::Same, Some(Evidence::Run)),
        ("claudertidemo", Rendering::Wrong, Some(Evidence::Code)),
        ("ptmconvert", Rendering::Same, Some(Evidence::Code)),
        ("rtiprep", Rendering::Same, Some(Evidence::Code)),
        ("oxrti", Rendering::Nothing, Some(Evidence::Code)),
        ("rtiviewer", Rendering::Wrong, Some(Evidence::Code)),
        ("d-k-e", Rendering::Nothing, Some(Evidence::Code)),
        ("make-rti-dz", Rendering::NotPredicted, None),
    ] {
        let prediction = predict(name, &file);
        assert_eq!(prediction.result, result, "{name}: {}", prediction.fault);
        assert_eq!(prediction.evidence, evidence, "{name}");
    }
    let file = replaced(LEGAL_FILE, "0 0 0\n", "0 0 1.5\n");
    assert_eq!(predict("oxrti", &file).result, Rendering::Same);
    assert_eq!(predict("cceh", &file).result, Rendering::NotPredicted);
}

#[test]
fn small_maps_are_refused_by_claudertidemo() {
    let file = replaced(LEGAL_FILE, "2\n2\n", "1\n1\n");
    let prediction = predict("claudertidemo", &file[..52 + 9]);
    assert_eq!(prediction.result, Rendering::Nothing);
    assert_eq!(prediction.evidence, Some(Evidence::Run));
    // It clamps luminance before it multiplies by the color.
    assert_eq!(
        predict("claudertidemo", LEGAL_FILE).result,
        Rendering::Wrong
    );
}

#[test]
fn unusual_planes_are_shown_by_some_readers() {
    let suite = suite();
    let sequential = suite.case("first-jpeg-lrgb").expect("a case");
    let file = &sequential.build(TableSpelling::default()).file;
    let mut file = replaced(file, "0.5 0.25 0.5 0.25 0.5 0.75", "2 2 2 2 2 2");
    for place in 1..file.len() {
        if file[place - 1..].starts_with(&[0xff, 0xc0]) {
            file[place] = 0xc2;
        }
    }
    for name in ["cceh", "hp-java", "ptmconvert"] {
        let prediction = predict(name, &file);
        assert!(prediction.result.is_right(), "{name}: {}", prediction.fault);
        assert_eq!(prediction.largest_difference, None);
    }
    assert_eq!(predict("rtiviewer", &file).result, Rendering::NotPredicted);
    let colored = suite.cases.iter().find(|case| {
        let damage = case.damage().map(|damage| &*damage.name);
        damage == Some("all-streams-of-three-components") && case.format() == Format::JpegLrgb
    });
    let colored = colored.expect("a case");
    let file = colored.build(TableSpelling::default()).file.clone();
    let prediction = predict("hp-java", &file);
    assert_eq!(prediction.result, Rendering::Wrong);
    assert_eq!(prediction.fault, "the planes are three times too wide");
    assert_eq!(predict("ptmconvert", &file).result, Rendering::Nothing);
    assert_eq!(predict("relight", &file).result, Rendering::NotPredicted);
}

#[test]
fn damaged_values_are_never_shown_correctly() {
    let suite = suite();
    let case = suite.case("first-lrgb").expect("a case");
    let file = &case.build(TableSpelling::default()).file;
    let text: String = file.iter().map(|&byte| char::from(byte)).collect();
    let twice: String = text.bytes().map(char::from).collect();
    let joined = file.repeat(6);
    for damaged in [text.as_bytes(), twice.as_bytes(), &joined] {
        for profile in profiles() {
            let result = predict(&profile.name, damaged).result;
            assert!(!result.is_right(), "{}: {result:?}", profile.name);
        }
    }
    let prediction = predict("rtiviewer", text.as_bytes());
    assert_eq!(prediction.result, Rendering::Wrong);
    assert_eq!(prediction.fault, "an image of a damaged file");
}

#[test]
fn truncated_coefficients_are_nearly_the_same() {
    let file = replaced(LEGAL_FILE, "1 1 1 1 1 1", "0.75 0.75 0.75 0.75 0.75 0.75");
    let prediction = predict("rtiviewer", &file);
    assert_eq!(
        prediction.result,
        Rendering::NearlySame,
        "{}",
        prediction.fault
    );
    assert_eq!(prediction.visible_share, Some(0.0));
    assert_eq!(prediction.misreadings, ["coefficient-truncated"]);
    let cells = prediction.cells();
    assert_eq!((&*cells[0], &*cells[2]), ("nearly-the-same", "0.0000"));
}
