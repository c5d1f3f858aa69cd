//! Tests properties that hold for every texture map, entry and light.

use proptest::prelude::*;
use proptest::sample::select;

use ptm::evaluate::Coefficients;
use ptm::{Shape, Size};
use ptm_texture::{
    Boundary, Channel, ClampMethod, Color, Composition, Correction, Entry, Frequency,
    Interpolation, Level, LitPrimitive, MapValue, Matrix, Parameterization, Point,
    RenderingControl, Rounding, Rules, SampleMethod, Shade, Texel, TexelKind, TextureMap, compose,
    fetch, interpolate, orient, parameterize, stage,
};

const RULES: &Rules = &Rules::SPEC;

fn is_close(a: &[f64], b: &[f64]) -> bool {
    let mut pairs = a.iter().zip(b);
    a.len() == b.len() && pairs.all(|(a, b)| (a - b).abs() <= 1e-9 * (1.0 + a.abs()))
}

fn unit() -> impl Strategy<Value = f64> {
    (0..=64_u32).prop_map(|n| f64::from(n) / 64.0)
}

fn color() -> impl Strategy<Value = Color> {
    [unit(), unit(), unit()]
}

fn kind() -> impl Strategy<Value = TexelKind> {
    select(TexelKind::ALL)
}

fn texel() -> impl Strategy<Value = Texel> {
    (kind(), [unit(), unit(), unit(), unit()]).prop_map(|(kind, values)| {
        Texel::new(kind, &values[..kind.components()]).expect("one value per component")
    })
}

fn entry() -> impl Strategy<Value = Entry> {
    let fields = (
        select(Composition::ALL),
        select(Channel::ALL),
        color(),
        color(),
    );
    fields.prop_map(
        |(composition, channel, env_color, background_color)| Entry {
            composition,
            channel,
            env_color,
            background_color,
            ..Entry::default()
        },
    )
}

fn sample_components(entry: &Entry, map: &TextureMap, t: [f64; 3], depth: f64) -> Vec<f64> {
    let fetched = fetch(entry, map, t, depth, false, RULES);
    fetched.components().unwrap_or_default().to_vec()
}

fn entry_with_boundary(boundary: [Boundary; 3], min_sample: SampleMethod) -> Entry {
    Entry {
        boundary,
        min_sample,
        ..Entry::default()
    }
}

/// Generates luminance maps with one to three dimensions.
fn luminance_map() -> impl Strategy<Value = TextureMap> {
    (1..=3_usize, [1..=5_usize, 1..=5, 1..=5]).prop_flat_map(|(dimensions, mut size)| {
        size[dimensions..].fill(1);
        let count = size.iter().product::<usize>();
        let values = proptest::collection::vec(unit(), count);
        values.prop_map(move |values| new_map(dimensions, size, &values))
    })
}

fn new_map(dimensions: usize, size: [usize; 3], values: &[f64]) -> TextureMap {
    let texel = |&value: &f64| Texel::new(TexelKind::L, &[value]).expect("one component");
    let texels = values.iter().map(texel).collect();
    TextureMap::new(dimensions, vec![Level { size, texels }]).expect("a map")
}

/// Generates coordinates that are exact in binary and not on a cell boundary of a map with up to 255 cells.
fn coordinate() -> impl Strategy<Value = f64> {
    (-512..512_i32).prop_map(|n| f64::from(2 * n + 1) / 512.0)
}

fn method() -> impl Strategy<Value = SampleMethod> {
    select(SampleMethod::ALL)
}

fn coefficients(width: u32, height: u32, values: Vec<f64>) -> Coefficients {
    Coefficients {
        size: Size { width, height },
        shape: Shape::Rgb,
        values,
    }
}

/// Generates RGB PTMs whose colors stay within 0…255 under every light.
fn ptm_strategy() -> impl Strategy<Value = Coefficients> {
    (1..=5_u32, 1..=5_u32).prop_flat_map(|(width, height)| {
        let texels = (width * height) as usize;
        let polynomial = [-16..16_i32, -16..16, -16..16, -16..16, -16..16, 90..160];
        let texel = [polynomial.clone(), polynomial.clone(), polynomial];
        proptest::collection::vec(texel, texels).prop_map(move |texels| {
            let values = texels.iter().flatten().flatten();
            let values = values.map(|&a| f64::from(a)).collect();
            coefficients(width, height, values)
        })
    })
}

fn light() -> impl Strategy<Value = (f64, f64)> {
    (-40..=40_i32, -40..=40_i32).prop_map(|(u, v)| (f64::from(u) / 64.0, f64::from(v) / 64.0))
}

/// Converts one coefficient of a PTM to a map, bottom row first.
fn coefficient_map(ptm: &Coefficients, channel: usize) -> TextureMap {
    let (width, height) = (ptm.size.width as usize, ptm.size.height as usize);
    let at = |x: usize, y: usize| ptm.values[(y * width + x) * 18 + channel];
    let places = (0..height)
        .rev()
        .flat_map(|y| (0..width).map(move |x| (x, y)));
    let values: Vec<f64> = places.map(|(x, y)| at(x, y)).collect();
    new_map(2, [width, height, 1], &values)
}

/// Evaluates the 18 coefficients of a texel under a light. The results range from 0 to 1.
fn lit_color(values: Vec<f64>, (lu, lv): (f64, f64)) -> Vec<f64> {
    let lit = coefficients(1, 1, values).evaluate(lu, lv);
    lit.values.iter().map(|c| c / 255.0).collect()
}

proptest! {
    #[test]
    fn texturing_and_lighting_commute(
        maps in proptest::collection::vec((entry(), texel(), any::<bool>()), 0..5),
        surface in color(), alpha in unit(), white in color(), specular in color(),
    ) {
        let maps: Vec<(Entry, MapValue)> = maps
            .into_iter()
            .map(|(mut entry, texel, is_pre_light)| {
                if is_pre_light {
                    entry.rendering_control = RenderingControl::PreLight;
                }
                (entry, MapValue::Texel(texel))
            })
            .collect();
        let lit = LitPrimitive { surface: Shade { color: surface, alpha }, white, specular };
        let split = stage(&maps, &lit, Interpolation::Color, Frequency::Pixel, RULES);
        let direct = stage(&maps, &lit, Interpolation::Normal, Frequency::Pixel, RULES);
        prop_assert!(is_close(&split.color, &direct.color), "{split:?} {direct:?}");
        prop_assert!(is_close(&[split.alpha], &[direct.alpha]));
    }

    #[test]
    fn bilinear_sampling_commutes_with_relighting(
        ptm in ptm_strategy(), light in light(), t in [coordinate(), coordinate()],
        boundary in select(&[Boundary::Wrap, Boundary::Mirror, Boundary::ClampBorder]),
    ) {
        let t = [t[0], t[1], 0.0];
        let entry = entry_with_boundary([boundary; 3], SampleMethod::WeightedBase);
        let map = TextureMap::from_ptm(&ptm, light.0, light.1, Rounding::None, RULES);
        let lit_then_sampled = sample_components(&entry, &map, t, 0.0);
        let coefficients = (0..18).map(|c| sample_components(&entry, &coefficient_map(&ptm, c), t, 0.0)[0]);
        let sampled_then_lit = lit_color(coefficients.collect(), light);
        prop_assert!(is_close(&lit_then_sampled, &sampled_then_lit));
    }

    #[test]
    fn box_filtered_levels_commute_with_relighting(ptm in ptm_strategy(), light in light(), t in [coordinate(), coordinate()], depth in 0.0..3.0) {
        let t = [t[0], t[1], 0.0];
        let entry = entry_with_boundary([Boundary::Wrap; 3], SampleMethod::WeightedBetweenMipmaps);
        let map = TextureMap::from_ptm(&ptm, light.0, light.1, Rounding::None, RULES).with_box_levels();
        let lit_first = sample_components(&entry, &map, t, depth);
        let coefficients = (0..18).map(|c| sample_components(&entry, &coefficient_map(&ptm, c).with_box_levels(), t, depth)[0]);
        prop_assert!(is_close(&lit_first, &lit_color(coefficients.collect(), light)));
    }

    #[test]
    fn a_wrapped_map_repeats_with_period_one_and_a_mirrored_one_with_two(
        map in luminance_map(), t in [coordinate(), coordinate(), coordinate()], k in [-3..4_i32, -3..4, -3..4], method in method(),
    ) {
        let wrapped = entry_with_boundary([Boundary::Wrap; 3], method);
        let mirrored = entry_with_boundary([Boundary::Mirror; 3], method);
        let moved = |period: f64| [0, 1, 2].map(|c| t[c] + period * f64::from(k[c]));
        prop_assert_eq!(sample_components(&wrapped, &map, t, 0.0), sample_components(&wrapped, &map, moved(1.0), 0.0));
        prop_assert_eq!(sample_components(&mirrored, &map, t, 0.0), sample_components(&mirrored, &map, moved(2.0), 0.0));
        let opposite = sample_components(&mirrored, &map, t.map(|t| -t), 0.0);
        prop_assert!(is_close(&sample_components(&mirrored, &map, t, 0.0), &opposite));
    }

    #[test]
    fn boundary_conditions_agree_inside_the_map(map in luminance_map(), t in [0..256_i32, 0..256, 0..256]) {
        let t = t.map(|n| f64::from(2 * n + 1) / 512.0);
        let with = |boundary, method| sample_components(&entry_with_boundary([boundary; 3], method), &map, t, 0.0);
        let expected = with(Boundary::Wrap, SampleMethod::SingleBase);
        for &boundary in Boundary::ALL {
            prop_assert_eq!(&with(boundary, SampleMethod::SingleBase), &expected);
        }
        let size = map.levels()[0].size;
        let surrounded = (0..map.dimensions()).all(|d| {
            let half = 0.5 / size[d] as f64;
            (half..=1.0 - half).contains(&t[d])
        });
        if surrounded {
            let expected = with(Boundary::Wrap, SampleMethod::WeightedBase);
            for &boundary in Boundary::ALL {
                prop_assert!(is_close(&with(boundary, SampleMethod::WeightedBase), &expected));
            }
        }
    }

    #[test]
    fn averages_lie_between_their_texels(
        map in luminance_map(), at in [0..5_usize, 0..5, 0..5], t in [coordinate(), coordinate(), coordinate()],
        boundary in select(Boundary::ALL),
    ) {
        let size = map.levels()[0].size;
        let center = [0, 1, 2].map(|d| ((at[d] % size[d]) as f64 + 0.5) / size[d] as f64);
        let single = entry_with_boundary([boundary; 3], SampleMethod::SingleBase);
        let weighted = entry_with_boundary([boundary; 3], SampleMethod::WeightedBase);
        prop_assert!(is_close(&sample_components(&single, &map, center, 0.0), &sample_components(&weighted, &map, center, 0.0)));
        let values = map.levels()[0].texels.iter().map(|texel| texel.components()[0]);
        let (least, most) = values.fold((1.0_f64, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
        for value in sample_components(&weighted, &map, t, 0.0) {
            prop_assert!((least - 1e-12..=most + 1e-12).contains(&value));
        }
    }

    #[test]
    fn a_constant_map_is_constant(
        value in unit(), size in [1..5_usize, 1..5], t in [coordinate(), coordinate()], depth in -2.0..5.0, method in method(),
        boundary in select(&[Boundary::Wrap, Boundary::Mirror, Boundary::ClampBorder]),
    ) {
        let map = new_map(2, [size[0], size[1], 1], &vec![value; size[0] * size[1]]).with_box_levels();
        let entry = entry_with_boundary([boundary; 3], method);
        prop_assert!(is_close(&sample_components(&entry, &map, [t[0], t[1], 0.0], depth), &[value]));
    }

    #[test]
    fn irrelevant_fields_change_nothing(
        entry in entry(), texel in texel(), input in color(), other in color(), index in 0..9_usize,
        map in luminance_map(), t in [coordinate(), coordinate(), coordinate()], turned in -4..4_i32,
    ) {
        let input = Shade { color: input, alpha: 0.5 };
        let composed = |entry: &Entry| compose(entry, &MapValue::Texel(texel), input, [0.5; 3], RULES);
        // Notes c, d and e.
        if entry.composition != Composition::BlendEnvColor {
            let changed = Entry { channel: Channel::Alpha, env_color: other, ..entry.clone() };
            prop_assert_eq!(composed(&entry), composed(&changed));
        }
        if entry.composition != Composition::DecalBackground {
            let changed = Entry { background_color: other, ..entry.clone() };
            prop_assert_eq!(composed(&entry), composed(&changed));
        }
        // Notes f and g.
        let clamped = Entry { clamp_method: ClampMethod::Color, clamp_color: other, ..entry.clone() };
        prop_assert_eq!(sample_components(&entry, &map, t, 0.0), sample_components(&clamped, &map, t, 0.0));
        let explicit = Entry { boundary: [Boundary::ClampExplicit; 3], ..entry.clone() };
        let changed = Entry { clamp_color: other, ..explicit.clone() };
        prop_assert_eq!(sample_components(&explicit, &map, t, 0.0), sample_components(&changed, &map, t, 0.0));
        // Notes a and b, and hints.
        let mut point = Point { fp_data: vec![0.25; 12], reflection: Some(t), ..Point::default() };
        point.wc.position = Some(t);
        let derived = |entry: &Entry| parameterize(entry, &point, 3, RULES);
        let coordinates = Entry { parameterization: Parameterization::VertexWCCoord, ..entry.clone() };
        let matrix = [[0.0, f64::from(turned), 0.0, 1.0]; 4];
        let changed = Entry { fp_data_index: index, reflection_matrix: matrix, ..coordinates.clone() };
        prop_assert_eq!(derived(&coordinates), derived(&changed));
        let hinted = Entry { reflection_hints: "Rotation".to_owned(), orientation_hints: "Translation".to_owned(), ..entry.clone() };
        prop_assert_eq!(derived(&entry), derived(&hinted));
    }

    #[test]
    fn affine_orientation_and_linear_interpolation_commute(
        rows in [[-4..4_i32, -4..4, -4..4, -4..4], [-4..4, -4..4, -4..4, -4..4], [-4..4, -4..4, -4..4, -4..4]],
        ts in [[unit(), unit(), unit()], [unit(), unit(), unit()], [unit(), unit(), unit()]], b in [unit(), unit()],
    ) {
        let row = |r: usize| rows[r].map(f64::from);
        let matrix: Matrix = [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]];
        let shares = [b[0] / 2.0, b[1] / 2.0, 1.0 - b[0] / 2.0 - b[1] / 2.0];
        let blended = |ts: &[[f64; 3]]| interpolate(ts, &shares, &[1.0; 3], Correction::None, RULES).expect("a value");
        let oriented = ts.map(|t| orient(&matrix, t, RULES));
        prop_assert!(is_close(&blended(&oriented), &orient(&matrix, blended(&ts), RULES)));
    }

    #[test]
    fn composition_methods_agree_for_neutral_texels(input in color(), alpha in unit(), t in color(), white in color(), environment in color(), background in color()) {
        let input = Shade { color: input, alpha };
        let by = |composition, kind: TexelKind, values: &[f64]| {
            let entry = Entry { composition, env_color: environment, background_color: background, ..Entry::default() };
            let texel = Texel::new(kind, values).expect("a texel");
            compose(&entry, &MapValue::Texel(texel), input, white, RULES)
        };
        let lit = |c: Color| [0, 1, 2].map(|i| white[i] * c[i]);
        let (opaque, clear) = ([t[0], t[1], t[2], 1.0], [t[0], t[1], t[2], 0.0]);
        prop_assert_eq!(by(Composition::Modulate, TexelKind::L, &[1.0]), input);
        prop_assert_eq!(by(Composition::Decal, TexelKind::RGBA, &clear), input);
        prop_assert_eq!(by(Composition::BlendEnvColor, TexelKind::L, &[0.0]), input);
        prop_assert!(is_close(&by(Composition::BlendEnvColor, TexelKind::L, &[1.0]).color, &lit(environment)));
        let decal = by(Composition::Decal, TexelKind::RGBA, &opaque);
        prop_assert_eq!(decal, by(Composition::Replace, TexelKind::RGB, &t));
        prop_assert!(is_close(&decal.color, &by(Composition::DecalBackground, TexelKind::RGBA, &opaque).color));
        prop_assert!(is_close(&by(Composition::DecalBackground, TexelKind::RGBA, &clear).color, &lit(background)));
        let nothing = compose(&Entry::default(), &MapValue::Discontinued, input, white, RULES);
        prop_assert_eq!(nothing, input);
    }
}

#[test]
fn orientation_comes_before_interpolation() {
    // With a matrix that is not affine, the order matters: the reference first orients the vertices, then interpolates.
    let mut matrix: Matrix =
        [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| if i == j { 1.0 } else { 0.0 }));
    matrix[3][0] = 1.0;
    let corners = [[0.0; 3], [1.0, 0.0, 0.0]];
    let oriented = corners.map(|t| orient(&matrix, t, RULES));
    let blended = |ts: &[[f64; 3]]| {
        interpolate(ts, &[0.5, 0.5], &[1.0, 1.0], Correction::None, RULES).expect("a value")
    };
    assert!((blended(&oriented)[0] - 0.25).abs() < 1e-12);
    assert!((orient(&matrix, blended(&corners), RULES)[0] - 1.0 / 3.0).abs() < 1e-12);
}
