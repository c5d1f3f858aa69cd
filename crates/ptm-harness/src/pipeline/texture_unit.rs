//! Tests with texture stages whose filters have the precision of texture units (ruling `filter-precision`).

use proptest::prelude::*;
use proptest::sample::select;
use serde_json::{Value, json};

use crate::pipeline::texture::judge_answers;
use crate::session::plan::RunPlan;
use crate::session::texture::TextureRun;
use ptm_suite::cases::Suite;
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::Request;
use ptm_suite::texture::cases::{TextureCase, TextureView};
use ptm_suite::texture::choices::CHOICES;
use ptm_suite::texture::question::Question;
use ptm_suite::verdicts::outcome::Outcome;
use ptm_texture::map::CellPair;
use ptm_texture::{
    Boundary, Channel, Composition, Entry, Frequency, Level, MAX_WEIGHT_ERROR, RenderingControl,
    Rules, SampleMethod, Texel, TexelKind, TextureMap, fetch, fetch_with_tolerance, sample,
};

/// Rounds to the nearest multiple of 1/`STEPS`.
fn round<const STEPS: u32>(weight: f64) -> f64 {
    (weight * f64::from(STEPS) + 0.5).floor() / f64::from(STEPS)
}

fn round_pair<const STEPS: u32>([(lower, _), (upper, weight)]: CellPair) -> CellPair {
    let weight = round::<STEPS>(weight);
    [(lower, 1.0 - weight), (upper, weight)]
}

/// Rounds the weights of texels. In two directions, the product of the rounded weights is rounded, too, and the weights of the
/// other three texels follow. In three directions, which were not measured, two such averages are interpolated.
fn round_corner_weights<const STEPS: u32>(weights: &[[f64; 2]; 3]) -> [f64; 8] {
    let [[_, a], [_, b], slices] = *weights;
    let both = round::<STEPS>(a * b);
    let plane = [1.0 - a - b + both, a - both, b - both, both];
    std::array::from_fn(|corner| slices[corner >> 2] * plane[corner & 3])
}

/// Truncates the weight of the upper level to a multiple of 1/`STEPS`.
fn truncate_level_weight<const STEPS: u32>(depth: f64, top: usize) -> (usize, usize, f64) {
    let (lower, upper, weight) = sample::levels_around(depth, top);
    let weight = (weight * f64::from(STEPS)).floor() / f64::from(STEPS);
    (lower, upper, weight)
}

/// Returns the reference's rules with the weights of a texture unit.
fn texture_unit<const STEPS: u32>() -> Rules {
    Rules {
        neighbors: |edge, t, size, rules| {
            round_pair::<STEPS>(sample::cells_around(edge, t, size, rules))
        },
        corner_weights: round_corner_weights::<STEPS>,
        levels: truncate_level_weight::<STEPS>,
        ..Rules::SPEC
    }
}

fn run(rules: &Rules) -> (Suite<TextureCase>, TextureRun) {
    let suite = Suite::load_texture().expect("the suite loads");
    let ask = |request: &Request<'_, TextureView>, _: usize| {
        let case = suite.case(request.name).expect("the case exists");
        let answer: Answer<Value> = case.answer(rules);
        answer.into()
    };
    let run = judge_answers(&suite, &RunPlan::new(&suite, 1), &ask);
    (suite, run)
}

fn failures(rules: &Rules) -> Vec<String> {
    let (suite, run) = run(rules);
    let failing = run.judgment.with_outcome(Outcome::Fail);
    failing.map(|i| suite.cases[i].id.clone()).collect()
}

#[test]
fn weights_of_8_bits_pass() {
    let (_, run) = run(&texture_unit::<256>());
    assert_eq!(run.exit_status(), 0);
    assert_eq!(run.judgment.dialect, CHOICES.reference());
    // The ruling does not depend on the reading.
    let points = Rules {
        closest: sample::point_index,
        neighbors: |edge, t, size, rules| {
            round_pair::<256>(sample::points_around(edge, t, size, rules))
        },
        ..texture_unit::<256>()
    };
    assert!(failures(&points).is_empty());
}

#[test]
fn weights_of_8_bits_are_outside_single_precision() {
    let (suite, _) = run(&Rules::SPEC);
    let rules = texture_unit::<256>();
    let differing = suite.cases.iter().filter(|case| {
        let mut expected = case.expected(&CHOICES.reference());
        expected.filter_tolerance = Value::Null;
        let Answer::Decoded(answer) = case.answer(&rules) else {
            return false;
        };
        expected.difference(&answer).is_some()
    });
    let differing: Vec<&str> = differing.map(|case| case.id.as_str()).collect();
    let expected = [
        "SMP-08", "SMP-11", "SMP-21", "SMP-52", "SMP-59", "SMP-60", "SMP-73", "BND-26", "PTM-56",
    ];
    assert_eq!(differing, expected);
}

#[test]
fn weights_of_7_bits_fail() {
    let coarse = texture_unit::<128>();
    assert_eq!(failures(&coarse), ["SMP-08", "SMP-73", "BND-26", "PTM-56"]);
    let filters = Rules {
        levels: Rules::SPEC.levels,
        ..coarse
    };
    assert_eq!(failures(&filters), ["SMP-08", "BND-26", "PTM-56"]);
    let levels = Rules {
        levels: coarse.levels,
        ..Rules::SPEC
    };
    assert_eq!(failures(&levels), ["SMP-73"]);
}

#[test]
fn composed_colors_have_the_tolerance_of_their_samples() {
    let suite = Suite::load_texture().expect("the suite loads");
    let reference = CHOICES.reference();
    let tolerance = |id: &str| {
        let expected = suite
            .case(id)
            .expect("the case exists")
            .expected(&reference);
        expected.filter_tolerance
    };
    // Replace keeps the tolerance of the sample; texels and closest texels have none.
    let expected = [12.0 + 48.0, 3.0 + 2.0, 1.2 + 1.2].map(|sum| sum * MAX_WEIGHT_ERROR / 255.0);
    for (c, expected) in expected.into_iter().enumerate() {
        let found = tolerance("PTM-17")["color"][c].as_f64().expect("a number");
        assert!((found - expected).abs() < 1e-12, "{c}: {found} {expected}");
    }
    assert_eq!(tolerance("PTM-17")["alpha"], 0.0);
    assert_eq!(tolerance("PTM-14")["color"][0], 0.0);
}

fn map(dimensions: usize, size: [usize; 3], values: &[f64]) -> TextureMap {
    let texel = |&value: &f64| Texel::new(TexelKind::L, &[value]).expect("one component");
    let texels = values.iter().map(texel).collect();
    TextureMap::new(dimensions, vec![Level { size, texels }]).expect("a map")
}

/// Samples a map exactly and with the weights of a texture unit. Returns the difference and the tolerance.
fn deviation(entry: &Entry, map: &TextureMap, t: [f64; 3], depth: f64) -> (f64, f64) {
    let exact = fetch_with_tolerance(entry, map, t, depth, false, &Rules::SPEC);
    let rounded = fetch(entry, map, t, depth, false, &texture_unit::<256>());
    let first = |components: Option<&[f64]>| components.expect("a texel")[0];
    let apart = first(rounded.components()) - first(exact.value.components());
    (apart.abs(), exact.tolerance[0])
}

/// The weights of four texels are not products of two rounded weights. The texel differences alone do not explain the deviation.
#[test]
fn four_rounded_weights_need_the_difference_of_the_differences() {
    let entry = Entry {
        min_sample: SampleMethod::WeightedBase,
        ..Entry::default()
    };
    let saddle = map(2, [2, 2, 1], &[0.0, 1.0, 1.0, 0.0]);
    let texel_differences = 2.0 * MAX_WEIGHT_ERROR;
    let mut largest = 0.0_f64;
    for i in 0..128 {
        for j in 0..128 {
            let t = [i, j].map(|k| 0.25 + (f64::from(k) + 0.3) / 256.0);
            let (apart, tolerance) = deviation(&entry, &saddle, [t[0], t[1], 0.0], 0.0);
            assert!(apart <= tolerance + 1e-12, "{t:?}: {apart} {tolerance}");
            largest = largest.max(apart);
        }
    }
    assert!(largest > texel_differences, "{largest}");
}

/// Returns maps of one to three dimensions with box-filtered levels.
fn maps() -> impl Strategy<Value = TextureMap> {
    (1..=3_usize, [1..=5_usize, 1..=5, 1..=5]).prop_flat_map(|(dimensions, mut size)| {
        size[dimensions..].fill(1);
        let values = proptest::collection::vec(0.0..1.0, size.iter().product::<usize>());
        values.prop_map(move |values| map(dimensions, size, &values).with_box_levels())
    })
}

/// Returns a map of 2×2 texels with alpha, the coordinates at which it is sampled, and the fields of an entry.
fn sampled_entry() -> impl Strategy<Value = Value> {
    let texel = || [0.0..1.0, 0.0..1.0, 0.0..1.0, 0.0..1.0];
    let texels = [texel(), texel(), texel(), texel()];
    let color = [0.0..1.0, 0.0..1.0, 0.0..1.0];
    let choices = (
        select(Composition::ALL),
        select(Channel::ALL),
        select(RenderingControl::ALL),
    );
    (texels, [-1.0..2.0, -1.0..2.0], color, choices).prop_map(
        |(texels, [t0, t1], color, (composition, channel, control))| {
            json!({
                "map": { "kind": "RGBA", "levels": [{ "size": [2, 2], "texels": texels }] },
                "t": [t0, t1, 0],
                "entry": {
                    "min_sample": "WeightedBase", "composition": composition.name(), "channel": channel.name(),
                    "rendering_control": control.name(), "env_color": color, "background_color": color,
                },
            })
        },
    )
}

/// Returns the color and alpha of an answer.
fn components(answer: &Value) -> [f64; 4] {
    let number = |value: &Value| value.as_f64().expect("a number");
    let [r, g, b] = [0, 1, 2].map(|c| number(&answer["color"][c]));
    [r, g, b, number(&answer["alpha"])]
}

proptest! {
    #[test]
    fn colors_from_a_texture_unit_are_within_the_tolerance(
        entries in proptest::collection::vec(sampled_entry(), 1..3), alpha in 0.0..1.0,
        color in [0.0..1.0, 0.0..1.0, 0.0..1.0], cw in [0.0..1.0, 0.0..1.0, 0.0..1.0],
        frequency in select(Frequency::ALL),
    ) {
        let surface = json!({ "color": color, "alpha": alpha, "cw": cw, "cs": [0.1, 0.1, 0.1] });
        let given = json!({ "surface": surface, "interp": "Color", "frequency": frequency.name(), "entries": entries });
        let question = Question::from_value(&json!({ "op": "stage", "given": given })).expect("a question");
        let exact = question.answer_with_tolerance(&Rules::SPEC).expect("an answer");
        let rounded = question.answer(&texture_unit::<256>()).expect("an answer");
        let [expected, received, tolerance] = [&exact.answer, &rounded, &exact.tolerance].map(components);
        for c in 0..4 {
            prop_assert!((expected[c] - received[c]).abs() <= tolerance[c] + 1e-12, "{exact:?} {rounded}");
        }
    }

    #[test]
    fn samples_of_a_texture_unit_are_within_the_tolerance(
        map in maps(), t in [-1.5..2.5, -1.5..2.5, -1.5..2.5], depth in -1.0..4.0,
        method in select(SampleMethod::ALL),
        boundary in select(&[Boundary::Wrap, Boundary::Mirror, Boundary::ClampBorder]),
    ) {
        let entry = Entry { boundary: [boundary; 3], min_sample: method, ..Entry::default() };
        let (apart, tolerance) = deviation(&entry, &map, t, depth);
        prop_assert!(apart <= tolerance + 1e-12, "{apart} {tolerance}");
    }
}
