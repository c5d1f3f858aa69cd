//! Compares predictions about readers with the recorded responses, and tests conversions for readers.

use std::collections::BTreeMap;

use crate::in_process::suite;
use crate::recordings::{digest, recorded_answers};
use crate::table::rows;
use ptm::Format;
use ptm::decode;
use ptm_files::readers::{OpenedFile, ReaderProfile, Rendering, parse_profiles, profiles};
use ptm_files::{convert_for::convert_for, dissection::Dissection};
use ptm_suite::cases::{Case, Expect, TableSpelling};
use ptm_suite::compare::Expected;
use ptm_suite::protocol::frame::Answer;

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
            None => Rendering::Right,
            Some(Answer::Decoded(frame)) => {
                let expected = Expected::new(&built.values, view).expect("a legal file has values");
                match expected.compare(frame) {
                    None => Rendering::Right,
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
        ("right", |shown| shown == Rendering::Right),
        ("wrong", |shown| shown == Rendering::Wrong),
        ("nothing", |shown| shown == Rendering::Nothing),
        ("not right", |shown| shown != Rendering::Right),
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
                    assert_eq!(shown, Rendering::Right, "{} for {name}", case.id);
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
