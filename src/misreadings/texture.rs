//! Executable mistakes: each a plausible misreading of one requirement, at the one decision where it acts.
//!
//! The same catalog names the mistake of a failing decoder and measures the suite: every misreading must be caught, every pair
//! told apart.

use std::sync::LazyLock;

use super::misreading::{Misreading, catalog};
use crate::texture::Rules;
use crate::texture::compose::{mix, times};
use crate::texture::parameterize::{dot, length};
use crate::texture::{
    Boundary, Channel, Entry, Fetched, Frequency, InteriorStyle, Interpolation, Parameterization,
    RenderingControl, SampleMethod, Selection, Shade, Site, Texel,
};

/// A mistake in the rules of texture mapping.
pub type Change = fn(Rules) -> Rules;

/// Read when the first misreading is asked for, once.
static ALL: LazyLock<Vec<Misreading<Change>>> = LazyLock::new(|| {
    catalog(
        include_str!("../../spec-cases/texture/misreadings.yaml"),
        ACTS.iter(),
        |_| None,
    )
    .unwrap_or_else(|error| unreachable!("misreadings.yaml, which a test reads: {error}"))
});

/// All misreadings, in the order of the chapter.
pub fn all() -> impl Iterator<Item = &'static Misreading<Change>> {
    ALL.iter()
}

/// The misreading of that name.
#[must_use]
pub fn named(slug: &str) -> Option<&'static Misreading<Change>> {
    all().find(|misreading| misreading.slug == slug)
}

const SPEC: Rules = Rules::SPEC;

/// Where each acts, in the order of `spec-cases/texture/misreadings.yaml`.
const ACTS: &[(&str, Change)] = &[
    // ---------------------------------------------------------------- fallback values
    ("pre-light-by-default", |r| Rules {
        fallback_values: || Entry {
            rendering_control: RenderingControl::PreLight,
            ..Entry::default()
        },
        ..r
    }),
    ("vertex-coordinates-by-default", |r| Rules {
        fallback_values: || Entry {
            parameterization: Parameterization::VertexMCCoord,
            ..Entry::default()
        },
        ..r
    }),
    ("reflection-in-world-by-default", |r| Rules {
        fallback_values: || Entry {
            parameterization: Parameterization::ReflectionSphereWC,
            ..Entry::default()
        },
        ..r
    }),
    ("modulate-by-default", |r| Rules {
        fallback_values: || Entry {
            composition: crate::texture::Composition::Modulate,
            ..Entry::default()
        },
        ..r
    }),
    ("alpha-by-default", |r| Rules {
        fallback_values: || Entry {
            channel: Channel::Alpha,
            ..Entry::default()
        },
        ..r
    }),
    ("white-by-default", |r| Rules {
        fallback_values: || Entry {
            env_color: [1.0; 3],
            background_color: [1.0; 3],
            clamp_color: [1.0; 3],
            ..Entry::default()
        },
        ..r
    }),
    ("weighted-by-default", |r| Rules {
        fallback_values: || Entry {
            min_sample: SampleMethod::WeightedBase,
            mag_sample: SampleMethod::WeightedBase,
            ..Entry::default()
        },
        ..r
    }),
    ("border-by-default", |r| Rules {
        fallback_values: || Entry {
            boundary: [Boundary::ClampBorder; 3],
            ..Entry::default()
        },
        ..r
    }),
    ("clamp-color-by-default", |r| Rules {
        fallback_values: || Entry {
            clamp_method: crate::texture::ClampMethod::Color,
            ..Entry::default()
        },
        ..r
    }),
    ("hints-of-zero-by-default", |r| Rules {
        fallback_values: || Entry {
            frequency: [0.0; 3],
            ..Entry::default()
        },
        ..r
    }),
    // ---------------------------------------------------------------- indices
    ("index-zero-accepted", |r| Rules {
        valid_index: |i| (0..=65535).contains(&i),
        ..r
    }),
    ("index-unbounded", |r| Rules {
        valid_index: |i| i >= 1,
        ..r
    }),
    ("index-65535-refused", |r| Rules {
        valid_index: |i| (1..65535).contains(&i),
        ..r
    }),
    ("undefined-entry-is-fallback-values", |r| Rules {
        undefined_entry: |_, rules| (rules.fallback_values)(),
        ..r
    }),
    ("undefined-entry-is-the-first-defined", |r| Rules {
        undefined_entry: |table, rules| {
            table
                .values()
                .next()
                .cloned()
                .unwrap_or_else(rules.fallback_values)
        },
        ..r
    }),
    // ---------------------------------------------------------------- selection
    ("style-ignored", |r| Rules {
        is_textured: |_| true,
        ..r
    }),
    ("any-filled-style-is-textured", |r| Rules {
        is_textured: |style| matches!(style, InteriorStyle::Texture | InteriorStyle::Solid),
        ..r
    }),
    ("back-attributes-without-distinguishing", |r| Rules {
        uses_back: |_, back| back,
        ..r
    }),
    ("back-attributes-ignored", |r| Rules {
        uses_back: |_, _| false,
        ..r
    }),
    ("back-attributes-on-the-front", |r| Rules {
        uses_back: |surface, _| surface.facet_distinguish,
        ..r
    }),
    ("limit-ignored", |r| Rules {
        within_limit: |active, _| active.to_vec(),
        ..r
    }),
    ("last-maps-kept", |r| Rules {
        within_limit: |active, most| active[active.len().saturating_sub(most)..].to_vec(),
        ..r
    }),
    ("repeats-dropped", |r| Rules {
        within_limit: |active, most| {
            let mut kept = (SPEC.within_limit)(active, most);
            kept.dedup();
            kept
        },
        ..r
    }),
    ("limit-off-by-one", |r| Rules {
        within_limit: |active, most| (SPEC.within_limit)(active, most.saturating_add(1)),
        ..r
    }),
    ("empty-list-is-untextured", |r| Rules {
        empty_list: || Selection::Untextured,
        ..r
    }),
    ("empty-list-is-entry-one", |r| Rules {
        empty_list: || Selection::Entries(vec![1]),
        ..r
    }),
    // ---------------------------------------------------------------- the default map
    ("checkerboard-black-at-origin", |r| Rules {
        is_white: |i, j| !(SPEC.is_white)(i, j),
        ..r
    }),
    ("checkerboard-of-single-texels", |r| Rules {
        checkerboard: || (16, 1),
        ..r
    }),
    ("checkerboard-of-8-texels", |r| Rules {
        checkerboard: || (8, 1),
        ..r
    }),
    ("checkerboard-is-stripes", |r| Rules {
        is_white: |i, _| i.is_multiple_of(2),
        ..r
    }),
    // ---------------------------------------------------------------- parameterization
    ("world-is-modelling", |r| Rules {
        parameterize: |entry, point, dimensions, rules| {
            let mut untransformed = point.clone();
            untransformed.wc.position = point.mc.position.or(point.wc.position);
            (SPEC.parameterize)(entry, &untransformed, dimensions, rules)
        },
        ..r
    }),
    ("modelling-is-world", |r| Rules {
        parameterize: |entry, point, dimensions, rules| {
            let mut transformed = point.clone();
            transformed.mc.position = point.wc.position.or(point.mc.position);
            (SPEC.parameterize)(entry, &transformed, dimensions, rules)
        },
        ..r
    }),
    ("normal-is-not-transformed", |r| Rules {
        parameterize: |entry, point, dimensions, rules| {
            let mut untransformed = point.clone();
            untransformed.wc.normal = point.mc.normal.or(point.wc.normal);
            (SPEC.parameterize)(entry, &untransformed, dimensions, rules)
        },
        ..r
    }),
    ("normal-in-world-always", |r| Rules {
        parameterize: |entry, point, dimensions, rules| {
            let mut transformed = point.clone();
            transformed.mc.normal = point.wc.normal.or(point.mc.normal);
            (SPEC.parameterize)(entry, &transformed, dimensions, rules)
        },
        ..r
    }),
    ("geometric-normal-always", |r| Rules {
        normal: |place| place.geometric_normal.or(place.normal),
        ..r
    }),
    ("geometric-normal-never", |r| Rules {
        normal: |place| Some(place.normal.unwrap_or([0.0, 0.0, 1.0])),
        ..r
    }),
    ("normals-moved-into-0-1", |r| Rules {
        parameterize: |entry, point, dimensions, rules| {
            let t = (SPEC.parameterize)(entry, point, dimensions, rules)?;
            Ok(match entry.parameterization {
                Parameterization::VertexMCNormal | Parameterization::VertexWCNormal => {
                    t.map(|t| f64::midpoint(t, 1.0))
                }
                _ => t,
            })
        },
        ..r
    }),
    ("spline-parameters-exchanged", |r| Rules {
        spline_parameters: |point| {
            let [u, v, w] = (SPEC.spline_parameters)(point);
            [v, u, w]
        },
        ..r
    }),
    ("spline-parameters-elsewhere", |r| Rules {
        spline_parameters: |point| match (&point.spline, point.mc.position) {
            (None, Some(position)) => position,
            _ => (SPEC.spline_parameters)(point),
        },
        ..r
    }),
    ("data-index-ignored", |r| Rules {
        float_data: |point, _, dimensions| (SPEC.float_data)(point, 0, dimensions),
        ..r
    }),
    ("data-index-for-all-methods", |r| Rules {
        parameterize: |entry, point, dimensions, rules| {
            let mut entry = entry.clone();
            if entry.fp_data_index > 0 && !point.fp_data.is_empty() {
                entry.parameterization = Parameterization::FloatData;
            }
            (SPEC.parameterize)(&entry, point, dimensions, rules)
        },
        ..r
    }),
    ("data-index-from-one", |r| Rules {
        float_data: |point, index, dimensions| {
            (SPEC.float_data)(point, index.saturating_sub(1), dimensions)
        },
        ..r
    }),
    ("data-in-steps-of-the-dimension", |r| Rules {
        float_data: |point, index, dimensions| {
            (SPEC.float_data)(point, index.saturating_mul(dimensions), dimensions)
        },
        ..r
    }),
    ("same-datum-for-all", |r| Rules {
        float_data: |point, index, dimensions| {
            let t = (SPEC.float_data)(point, index, dimensions)?;
            Ok([0, 1, 2].map(|c| if c < dimensions { t[0] } else { 0.0 }))
        },
        ..r
    }),
    ("three-data-needed", |r| Rules {
        float_data: |point, index, _| (SPEC.float_data)(point, index, 3),
        ..r
    }),
    ("data-of-two-dimensions", |r| Rules {
        float_data: |point, index, dimensions| (SPEC.float_data)(point, index, dimensions.min(2)),
        ..r
    }),
    ("vertex-data-on-splines", |r| Rules {
        float_data: |point, index, dimensions| {
            let mut plain = point.clone();
            if !plain.fp_data.is_empty() {
                plain.spline = None;
            }
            (SPEC.float_data)(&plain, index, dimensions)
        },
        ..r
    }),
    ("one-spline-for-all-coordinates", |r| Rules {
        float_data: |point, index, dimensions| {
            let Some(spline) = &point.spline else {
                return (SPEC.float_data)(point, index, dimensions);
            };
            let values = spline.data.get(index).cloned().unwrap_or_default();
            let at = |c: usize| values.get(c).copied().unwrap_or_default();
            Ok([0, 1, 2].map(|c| if c < dimensions { at(c) } else { 0.0 }))
        },
        ..r
    }),
    ("reflection-inwards", |r| Rules {
        reflect: |i, n| (SPEC.reflect)(i, n).map(|c| -c),
        ..r
    }),
    ("reflection-half", |r| Rules {
        reflect: |i, n| {
            let along = dot(n, i);
            [0, 1, 2].map(|c| i[c] - along * n[c])
        },
        ..r
    }),
    ("no-reflection", |r| Rules {
        reflect: |i, _| i,
        ..r
    }),
    ("normal-as-reflection", |r| Rules {
        reflect: |_, n| n,
        ..r
    }),
    ("sight-towards-the-eye", |r| Rules {
        sight: |eye, position| (SPEC.sight)(position, eye),
        ..r
    }),
    ("eye-in-world", |r| Rules {
        vrc_place: |point| {
            if point.wc.normal.is_some() {
                point.wc.clone()
            } else {
                point.vrc.clone()
            }
        },
        ..r
    }),
    ("eye-in-vrc", |r| Rules {
        wc_place: |point| {
            if point.vrc.normal.is_some() {
                point.vrc.clone()
            } else {
                point.wc.clone()
            }
        },
        ..r
    }),
    ("reflection-matrix-ignored", |r| Rules {
        turn: |_, s| s,
        ..r
    }),
    ("reflection-matrix-transposed", |r| Rules {
        turn: |matrix, s| [0, 1, 2].map(|c| dot([matrix[0][c], matrix[1][c], matrix[2][c]], s)),
        ..r
    }),
    ("reflection-matrix-moves", |r| Rules {
        turn: |matrix, s| [0, 1, 2].map(|row| (SPEC.turn)(matrix, s)[row] + matrix[row][3]),
        ..r
    }),
    ("reflection-matrix-for-all-methods", |r| Rules {
        parameterize: |entry, point, dimensions, rules| {
            let t = (SPEC.parameterize)(entry, point, dimensions, rules)?;
            Ok(match entry.parameterization {
                Parameterization::ReflectionSphereVRC | Parameterization::ReflectionSphereWC => t,
                _ => (SPEC.turn)(&entry.reflection_matrix, t),
            })
        },
        ..r
    }),
    ("vector-not-normalized", |r| Rules {
        wc_height: |s| (-s[1]).clamp(-1.0, 1.0).acos() / std::f64::consts::PI,
        vrc_height: |s| (-s[1]).clamp(-1.0, 1.0).acos() / std::f64::consts::PI,
        ..r
    }),
    ("vrc-once-around", |r| Rules {
        vrc_azimuth: SPEC.wc_azimuth,
        ..r
    }),
    ("wc-twice-around", |r| Rules {
        wc_azimuth: SPEC.vrc_azimuth,
        ..r
    }),
    ("seam-at-minus-x", |r| Rules {
        wc_azimuth: |s| ((SPEC.wc_azimuth)(s) + 0.5).fract(),
        ..r
    }),
    ("azimuth-in-radians", |r| Rules {
        wc_azimuth: |s| (SPEC.wc_azimuth)(s) * 2.0 * std::f64::consts::PI,
        ..r
    }),
    ("axis-is-z", |r| Rules {
        wc_azimuth: |s| (SPEC.wc_azimuth)([s[0], s[2], -s[1]]),
        wc_height: |s| (SPEC.wc_height)([s[0], s[2], -s[1]]),
        vrc_azimuth: |s| (SPEC.vrc_azimuth)([s[0], s[2], -s[1]]),
        vrc_height: |s| (SPEC.vrc_height)([s[0], s[2], -s[1]]),
        ..r
    }),
    ("sphere-map-of-opengl", |r| Rules {
        vrc_azimuth: |s| opengl(s)[0],
        vrc_height: |s| opengl(s)[1],
        ..r
    }),
    // ---------------------------------------------------------------- orientation, interpolation
    ("orientation-ignored", |r| Rules {
        orient: |_, t| t,
        ..r
    }),
    ("orientation-transposed", |r| Rules {
        orient: |matrix, t| {
            let mut transposed = *matrix;
            for (i, row) in matrix.iter().enumerate() {
                for (j, &value) in row.iter().enumerate() {
                    transposed[j][i] = value;
                }
            }
            (SPEC.orient)(&transposed, t)
        },
        ..r
    }),
    ("orientation-without-translation", |r| Rules {
        orient: |matrix, t| (SPEC.turn)(matrix, t),
        ..r
    }),
    ("orientation-of-two-coordinates", |r| Rules {
        orient: |matrix, t| {
            let moved = (SPEC.orient)(matrix, [t[0], t[1], 0.0]);
            [moved[0], moved[1], t[2]]
        },
        ..r
    }),
    ("orientation-after-sampling-range", |r| Rules {
        orient: |matrix, t| (SPEC.orient)(matrix, t.map(|t| t - t.floor())),
        ..r
    }),
    ("no-perspective-correction", |r| Rules {
        hyperbolic: |ts, b, w| (SPEC.linear)(ts, b, w),
        ..r
    }),
    ("perspective-always", |r| Rules {
        linear: |ts, b, w| (SPEC.hyperbolic)(ts, b, w),
        ..r
    }),
    ("perspective-inverted", |r| Rules {
        hyperbolic: |ts, b, w| {
            let inverse: Vec<f64> = w.iter().map(|w| 1.0 / w).collect();
            (SPEC.hyperbolic)(ts, b, &inverse)
        },
        ..r
    }),
    ("sampled-per-vertex-always", |r| Rules {
        site: |_, frequency| {
            if frequency == Frequency::Pixel {
                Site::Pixel
            } else {
                Site::Vertex
            }
        },
        ..r
    }),
    ("sampled-per-pixel-always", |r| Rules {
        site: |_, _| Site::Pixel,
        ..r
    }),
    ("sample-frequency-overruled", |r| Rules {
        site: |interpolation, _| (SPEC.site)(interpolation, Frequency::InterpDep),
        ..r
    }),
    ("dot-product-per-vertex", |r| Rules {
        site: |interpolation, frequency| match (interpolation, frequency) {
            (Interpolation::DotProduct, Frequency::InterpDep) => Site::Vertex,
            _ => (SPEC.site)(interpolation, frequency),
        },
        ..r
    }),
    // ---------------------------------------------------------------- stages
    ("order-reversed", |r| Rules {
        stage: |maps, lit, interpolation, frequency, rules| {
            let reversed: Vec<_> = maps.iter().rev().cloned().collect();
            (SPEC.stage)(&reversed, lit, interpolation, frequency, rules)
        },
        ..r
    }),
    ("only-the-last-map", |r| Rules {
        stage: |maps, lit, interpolation, frequency, rules| {
            (SPEC.stage)(
                &maps[maps.len().saturating_sub(1)..],
                lit,
                interpolation,
                frequency,
                rules,
            )
        },
        ..r
    }),
    ("only-the-first-map", |r| Rules {
        stage: |maps, lit, interpolation, frequency, rules| {
            (SPEC.stage)(
                &maps[..maps.len().min(1)],
                lit,
                interpolation,
                frequency,
                rules,
            )
        },
        ..r
    }),
    ("post-light-before-light", |r| Rules {
        stage: |maps, lit, interpolation, frequency, rules| {
            (SPEC.stage)(
                &all_at(maps, RenderingControl::PreLight),
                lit,
                interpolation,
                frequency,
                rules,
            )
        },
        ..r
    }),
    ("pre-light-after-light", |r| Rules {
        stage: |maps, lit, interpolation, frequency, rules| {
            (SPEC.stage)(
                &all_at(maps, RenderingControl::PostLight),
                lit,
                interpolation,
                frequency,
                rules,
            )
        },
        ..r
    }),
    ("list-order-over-stages", |r| Rules {
        stage: |maps, lit, interpolation, frequency, rules| {
            let control = maps
                .first()
                .map_or(RenderingControl::PostLight, |(entry, _)| {
                    entry.rendering_control
                });
            (SPEC.stage)(&all_at(maps, control), lit, interpolation, frequency, rules)
        },
        ..r
    }),
    ("specular-textured", |r| Rules {
        add_specular: |shade, specular| Shade {
            color: [0, 1, 2].map(|c| shade.color[c] + specular[c] * shade.color[c]),
            ..shade
        },
        ..r
    }),
    ("specular-lost", |r| Rules {
        add_specular: |shade, _| shade,
        ..r
    }),
    ("white-light-lost", |r| Rules {
        stage: |maps, lit, interpolation, frequency, rules| {
            let split = (rules.is_split)(interpolation, frequency);
            if !split {
                return (SPEC.stage)(maps, lit, interpolation, frequency, rules);
            }
            unlit(maps, lit, rules)
        },
        ..r
    }),
    ("split-multiplies-twice", |r| Rules {
        stage: |maps, lit, interpolation, frequency, rules| {
            let shade = (SPEC.stage)(maps, lit, interpolation, frequency, rules);
            let pre = maps
                .iter()
                .any(|(entry, _)| entry.rendering_control == RenderingControl::PreLight);
            if pre && (rules.is_split)(interpolation, frequency) {
                let textured = [0, 1, 2]
                    .map(|c| (shade.color[c] - lit.specular[c]) * lit.white[c] + lit.specular[c]);
                return Shade {
                    color: textured,
                    ..shade
                };
            }
            shade
        },
        ..r
    }),
    ("direct-form-unlit", |r| Rules {
        light: |shade, lit| (SPEC.add_specular)(shade, lit.specular),
        ..r
    }),
    // ---------------------------------------------------------------- composition
    ("luminance-is-red", |r| Rules {
        texel_color: |texel| match texel.luminance() {
            Some(luminance) => [luminance, 0.0, 0.0],
            None => (SPEC.texel_color)(texel),
        },
        ..r
    }),
    ("premultiplied", |r| Rules {
        texel_color: |texel| (SPEC.texel_color)(texel).map(|c| c * texel.alpha().unwrap_or(1.0)),
        ..r
    }),
    ("replace-modulates", |r| Rules {
        replace: |x| Shade {
            alpha: x.alpha.unwrap_or(x.input.alpha),
            ..(SPEC.modulate)(x)
        },
        ..r
    }),
    ("replace-keeps-alpha", |r| Rules {
        replace: |x| Shade {
            alpha: x.input.alpha,
            ..(SPEC.replace)(x)
        },
        ..r
    }),
    ("replace-makes-opaque", |r| Rules {
        replace: |x| Shade {
            alpha: x.alpha.unwrap_or(1.0),
            ..(SPEC.replace)(x)
        },
        ..r
    }),
    ("replace-multiplies-alpha", |r| Rules {
        replace: |x| Shade {
            alpha: x.input.alpha * x.alpha.unwrap_or(1.0),
            ..(SPEC.replace)(x)
        },
        ..r
    }),
    ("replace-unlit", |r| Rules {
        replace: |x| Shade {
            color: x.color,
            ..(SPEC.replace)(x)
        },
        ..r
    }),
    ("modulate-keeps-alpha", |r| Rules {
        modulate: |x| Shade {
            alpha: x.input.alpha,
            ..(SPEC.modulate)(x)
        },
        ..r
    }),
    ("modulate-replaces-alpha", |r| Rules {
        modulate: |x| Shade {
            alpha: x.alpha.unwrap_or(x.input.alpha),
            ..(SPEC.modulate)(x)
        },
        ..r
    }),
    ("modulate-doubles", |r| Rules {
        modulate: |x| Shade {
            color: (SPEC.modulate)(x).color.map(|c| 2.0 * c),
            ..(SPEC.modulate)(x)
        },
        ..r
    }),
    ("modulate-adds", |r| Rules {
        modulate: |x| Shade {
            color: [0, 1, 2].map(|c| x.input.color[c] + x.color[c]),
            ..(SPEC.modulate)(x)
        },
        ..r
    }),
    ("modulate-lit-twice", |r| Rules {
        modulate: |x| Shade {
            color: times(x.white, (SPEC.modulate)(x).color),
            ..(SPEC.modulate)(x)
        },
        ..r
    }),
    ("blend-the-other-way", |r| Rules {
        blend_env_color: |x| {
            (SPEC.blend_env_color)(&crate::texture::primitive::Terms {
                gamma: x.gamma.map(|g| 1.0 - g),
                ..*x
            })
        },
        ..r
    }),
    ("blend-adds", |r| Rules {
        blend_env_color: |x| {
            let environment = times(x.white, x.entry.env_color);
            let color = [0, 1, 2].map(|c| x.input.color[c] + x.gamma[c] * environment[c]);
            Shade {
                color,
                ..(SPEC.blend_env_color)(x)
            }
        },
        ..r
    }),
    ("blend-with-the-texel", |r| Rules {
        blend_env_color: |x| Shade {
            color: mix(x.input.color, times(x.white, x.color), x.gamma),
            ..(SPEC.blend_env_color)(x)
        },
        ..r
    }),
    ("blend-environment-unlit", |r| Rules {
        blend_env_color: |x| Shade {
            color: mix(x.input.color, x.entry.env_color, x.gamma),
            ..(SPEC.blend_env_color)(x)
        },
        ..r
    }),
    ("blend-keeps-alpha", |r| Rules {
        blend_env_color: |x| Shade {
            alpha: x.input.alpha,
            ..(SPEC.blend_env_color)(x)
        },
        ..r
    }),
    ("background-for-environment", |r| Rules {
        blend_env_color: |x| Shade {
            color: mix(
                x.input.color,
                times(x.white, x.entry.background_color),
                x.gamma,
            ),
            ..(SPEC.blend_env_color)(x)
        },
        ..r
    }),
    ("channel-ignored", |r| Rules {
        gamma: |_, texel| [(SPEC.texel_color)(texel)[0]; 3],
        ..r
    }),
    ("channels-from-blue", |r| Rules {
        gamma: |entry, texel| {
            let channel = match entry.channel {
                Channel::Red => Channel::Blue,
                Channel::Blue => Channel::Red,
                other => other,
            };
            (SPEC.gamma)(
                &Entry {
                    channel,
                    ..entry.clone()
                },
                texel,
            )
        },
        ..r
    }),
    ("channels-from-alpha", |r| Rules {
        gamma: |entry, texel| {
            let channel = match entry.channel {
                Channel::Alpha => Channel::Red,
                Channel::Red => Channel::Green,
                Channel::Green => Channel::Blue,
                Channel::Blue => Channel::Alpha,
            };
            (SPEC.gamma)(
                &Entry {
                    channel,
                    ..entry.clone()
                },
                texel,
            )
        },
        ..r
    }),
    ("gray-of-the-texel", |r| Rules {
        gamma: |_, texel| [(SPEC.texel_color)(texel).iter().sum::<f64>() / 3.0; 3],
        ..r
    }),
    ("luminance-alpha-selected", |r| Rules {
        gamma: |entry, texel| match (entry.channel, texel.luminance(), texel.alpha()) {
            (Channel::Alpha, Some(_), Some(alpha)) => [alpha; 3],
            _ => (SPEC.gamma)(entry, texel),
        },
        ..r
    }),
    ("decal-the-other-way", |r| Rules {
        decal: |x| match x.alpha {
            Some(alpha) => Shade {
                color: mix(x.input.color, times(x.white, x.color), [1.0 - alpha; 3]),
                ..x.input
            },
            None => (SPEC.decal)(x),
        },
        ..r
    }),
    ("decal-by-primitive-alpha", |r| Rules {
        decal: |x| Shade {
            color: mix(x.input.color, times(x.white, x.color), [x.input.alpha; 3]),
            ..x.input
        },
        ..r
    }),
    ("decal-replaces-alpha", |r| Rules {
        decal: |x| Shade {
            alpha: x.alpha.unwrap_or(x.input.alpha),
            ..(SPEC.decal)(x)
        },
        ..r
    }),
    ("decal-multiplies-alpha", |r| Rules {
        decal: |x| Shade {
            alpha: x.input.alpha * x.alpha.unwrap_or(1.0),
            ..(SPEC.decal)(x)
        },
        ..r
    }),
    ("decal-without-alpha-is-nothing", |r| Rules {
        decal: |x| {
            if x.alpha.is_none() {
                x.input
            } else {
                (SPEC.decal)(x)
            }
        },
        ..r
    }),
    ("decal-by-channel", |r| Rules {
        decal: |x| Shade {
            color: mix(x.input.color, times(x.white, x.color), x.gamma),
            ..x.input
        },
        ..r
    }),
    ("decal-unlit", |r| Rules {
        decal: |x| Shade {
            color: mix(x.input.color, x.color, [x.alpha.unwrap_or(1.0); 3]),
            ..x.input
        },
        ..r
    }),
    ("background-is-primitive", |r| Rules {
        decal_background: |x| (SPEC.decal)(x),
        ..r
    }),
    ("environment-for-background", |r| Rules {
        decal_background: |x| Shade {
            color: times(
                x.white,
                mix(x.entry.env_color, x.color, [x.alpha.unwrap_or(1.0); 3]),
            ),
            ..x.input
        },
        ..r
    }),
    ("background-unlit", |r| Rules {
        decal_background: |x| Shade {
            color: mix(
                x.entry.background_color,
                times(x.white, x.color),
                [x.alpha.unwrap_or(1.0); 3],
            ),
            ..x.input
        },
        ..r
    }),
    ("background-replaces-alpha", |r| Rules {
        decal_background: |x| Shade {
            alpha: x.alpha.unwrap_or(x.input.alpha),
            ..(SPEC.decal_background)(x)
        },
        ..r
    }),
    ("background-without-alpha", |r| Rules {
        decal_background: |x| match x.alpha {
            Some(_) => (SPEC.decal_background)(x),
            None => Shade {
                color: times(x.white, x.entry.background_color),
                ..x.input
            },
        },
        ..r
    }),
    ("background-the-other-way", |r| Rules {
        decal_background: |x| match x.alpha {
            Some(alpha) => Shade {
                color: times(x.white, mix(x.color, x.entry.background_color, [alpha; 3])),
                ..x.input
            },
            None => (SPEC.decal_background)(x),
        },
        ..r
    }),
    // ---------------------------------------------------------------- sampling
    ("minification-always", |r| Rules {
        method: |entry, _| entry.min_sample,
        ..r
    }),
    ("methods-exchanged", |r| Rules {
        method: |entry, magnify| (SPEC.method)(entry, !magnify),
        ..r
    }),
    ("texels-column-first", |r| Rules {
        place: |size, at| (at[0] * size[1] + at[1]) * size[2] + at[2],
        ..r
    }),
    ("first-row-at-the-top", |r| Rules {
        place: |size, at| (SPEC.place)(size, [at[0], size[1] - 1 - at[1], at[2]]),
        ..r
    }),
    ("slices-ignored", |r| Rules {
        place: |size, at| (SPEC.place)(size, [at[0], at[1], 0]),
        ..r
    }),
    ("coordinates-in-texels", |r| Rules {
        closest: |boundary, t, size, rules| (SPEC.closest)(boundary, t / size as f64, size, rules),
        ..r
    }),
    ("closest-rounds", |r| Rules {
        closest: |boundary, t, size, rules| {
            (SPEC.closest)(boundary, t + 0.5 / size as f64, size, rules)
        },
        ..r
    }),
    ("weighted-is-single", |r| Rules {
        neighbors: |boundary, t, size, rules| {
            [((rules.closest)(boundary, t, size, rules), 1.0), (0, 0.0)]
        },
        ..r
    }),
    ("weighted-half-off", |r| Rules {
        neighbors: |boundary, t, size, rules| {
            (SPEC.neighbors)(boundary, t + 0.5 / size as f64, size, rules)
        },
        ..r
    }),
    ("weights-exchanged", |r| Rules {
        neighbors: |boundary, t, size, rules| {
            let [(a, wa), (b, wb)] = (SPEC.neighbors)(boundary, t, size, rules);
            [(a, wb), (b, wa)]
        },
        ..r
    }),
    ("weights-equal", |r| Rules {
        neighbors: |boundary, t, size, rules| {
            (SPEC.neighbors)(boundary, t, size, rules).map(|(at, _)| (at, 0.5))
        },
        ..r
    }),
    ("weights-smoothed", |r| Rules {
        neighbors: |boundary, t, size, rules| {
            let [(a, _), (b, f)] = (SPEC.neighbors)(boundary, t, size, rules);
            let smooth = f * f * (3.0 - 2.0 * f);
            [(a, 1.0 - smooth), (b, smooth)]
        },
        ..r
    }),
    ("level-rounded-down", |r| Rules {
        closest_level: |depth, top| (depth.floor().max(0.0) as usize).min(top),
        ..r
    }),
    ("level-rounded-up", |r| Rules {
        closest_level: |depth, top| (depth.ceil().max(0.0) as usize).min(top),
        ..r
    }),
    ("levels-from-the-pinnacle", |r| Rules {
        closest_level: |depth, top| (SPEC.closest_level)(top as f64 - depth, top),
        levels: |depth, top| (SPEC.levels)(top as f64 - depth, top),
        ..r
    }),
    ("levels-ignored", |r| Rules {
        closest_level: |_, _| 0,
        levels: |_, _| (0, 0, 0.0),
        ..r
    }),
    ("between-is-closest", |r| Rules {
        levels: |depth, top| ((SPEC.closest_level)(depth, top), 0, 0.0),
        ..r
    }),
    ("between-is-the-mean", |r| Rules {
        levels: |depth, top| {
            let (lower, upper, share) = (SPEC.levels)(depth, top);
            (lower, upper, if share > 0.0 { 0.5 } else { 0.0 })
        },
        ..r
    }),
    ("between-the-other-way", |r| Rules {
        levels: |depth, top| {
            let (lower, upper, share) = (SPEC.levels)(depth, top);
            (lower, upper, if share > 0.0 { 1.0 - share } else { 0.0 })
        },
        ..r
    }),
    ("depth-extrapolated", |r| Rules {
        levels: |depth, top| {
            let lower = (depth.floor().max(0.0) as usize).min(top.saturating_sub(1));
            (lower, (lower + 1).min(top), depth - lower as f64)
        },
        ..r
    }),
    ("depth-wraps", |r| Rules {
        levels: |depth, top| {
            if depth > top as f64 {
                (0, 0, 0.0)
            } else {
                (SPEC.levels)(depth, top)
            }
        },
        ..r
    }),
    // ---------------------------------------------------------------- boundaries
    ("wrap-in-c", |r| Rules {
        wrap: |k, size| (k % size as i64).unsigned_abs() as usize,
        ..r
    }),
    ("wrap-truncates", |r| Rules {
        closest: |boundary, t, size, rules| {
            let t = if boundary == Boundary::Wrap && t < 0.0 {
                t + 1.0 / size as f64
            } else {
                t
            };
            (SPEC.closest)(boundary, t, size, rules)
        },
        ..r
    }),
    ("wrap-loses-the-last-texel", |r| Rules {
        wrap: |k, size| {
            if (0..size as i64).contains(&k) {
                k as usize
            } else {
                k.rem_euclid((size as i64 - 1).max(1)) as usize
            }
        },
        ..r
    }),
    ("wrap-clamps-neighbours", |r| Rules {
        neighbors: |boundary, t, size, rules| {
            let boundary = if boundary == Boundary::Wrap && (0.0..=1.0).contains(&t) {
                Boundary::ClampBorder
            } else {
                boundary
            };
            (SPEC.neighbors)(boundary, t, size, rules)
        },
        ..r
    }),
    ("mirror-wraps", |r| Rules {
        mirror: SPEC.wrap,
        ..r
    }),
    ("mirror-once", |r| Rules {
        mirror: |k, size| {
            let n = size as i64;
            (SPEC.border)(
                if k < 0 {
                    -1 - k
                } else if k >= n {
                    2 * n - 1 - k
                } else {
                    k
                },
                size,
            )
        },
        ..r
    }),
    ("mirror-without-the-edge", |r| Rules {
        mirror: |k, size| {
            let period = (2 * (size as i64 - 1)).max(1);
            let m = k.rem_euclid(period);
            m.min(period - m).min(size as i64 - 1) as usize
        },
        ..r
    }),
    ("mirror-of-the-first-tile", |r| Rules {
        mirror: |k, size| size - 1 - (SPEC.mirror)(k, size),
        ..r
    }),
    ("border-wraps", |r| Rules {
        border: SPEC.wrap,
        ..r
    }),
    ("border-is-black", |r| Rules {
        is_clamped: |entry, t, dimensions, rules| {
            (SPEC.is_clamped)(entry, t, dimensions, rules)
                || (0..dimensions)
                    .any(|d| entry.boundary[d] == Boundary::ClampBorder && (rules.is_outside)(t[d]))
        },
        ..r
    }),
    ("border-of-the-first-texel", |r| Rules {
        border: |k, size| {
            if (0..size as i64).contains(&k) {
                k as usize
            } else {
                0
            }
        },
        ..r
    }),
    ("explicit-is-border", |r| Rules {
        is_clamped: |_, _, _, _| false,
        ..r
    }),
    ("one-is-outside", |r| Rules {
        is_outside: |t| !(0.0..1.0).contains(&t),
        ..r
    }),
    ("zero-is-outside", |r| Rules {
        is_outside: |t| !(t > 0.0 && t <= 1.0),
        ..r
    }),
    ("only-beyond-one-is-outside", |r| Rules {
        is_outside: |t| t > 1.0,
        ..r
    }),
    ("all-directions-must-be-outside", |r| Rules {
        is_clamped: |entry, t, dimensions, rules| {
            (0..dimensions).all(|d| (rules.is_outside)(t[d]))
                && (SPEC.is_clamped)(entry, t, dimensions, rules)
        },
        ..r
    }),
    ("any-outside-clamps", |r| Rules {
        is_clamped: |entry, t, dimensions, rules| {
            let explicit = (0..dimensions).any(|d| entry.boundary[d] == Boundary::ClampExplicit);
            explicit && (0..dimensions).any(|d| (rules.is_outside)(t[d]))
        },
        ..r
    }),
    ("t2-clamps-a-picture", |r| Rules {
        is_clamped: |entry, t, _, rules| (SPEC.is_clamped)(entry, t, 3, rules),
        ..r
    }),
    ("one-condition-for-all", |r| Rules {
        condition: |entry, _| entry.boundary[0],
        ..r
    }),
    ("discontinue-is-black", |r| Rules {
        clamp: |entry| match (SPEC.clamp)(entry) {
            Fetched::Discontinued => Fetched::Texel(Texel::rgb([0.0; 3])),
            other => other,
        },
        ..r
    }),
    ("clamp-color-ignored", |r| Rules {
        clamp: |_| Fetched::Discontinued,
        ..r
    }),
    ("clamp-color-is-background", |r| Rules {
        clamp: |entry| {
            (SPEC.clamp)(&Entry {
                clamp_color: entry.background_color,
                ..entry.clone()
            })
        },
        ..r
    }),
    ("clamp-color-always", |r| Rules {
        clamp: |entry| Fetched::Clamped(Texel::rgb(entry.clamp_color)),
        ..r
    }),
    // ---------------------------------------------------------------- a PTM as a map
    ("ptm-top-row-first", |r| Rules {
        rows: |picture| {
            picture
                .values
                .chunks_exact(3)
                .map(|c| [c[0], c[1], c[2]])
                .collect()
        },
        ..r
    }),
    ("ptm-mirrored", |r| Rules {
        rows: |picture| {
            let width = picture.size.width as usize;
            (SPEC.rows)(picture)
                .chunks_exact(width)
                .flat_map(|row| row.iter().rev().copied())
                .collect()
        },
        ..r
    }),
    ("ptm-blue-first", |r| Rules {
        rows: |picture| {
            (SPEC.rows)(picture)
                .into_iter()
                .map(|[r, g, b]| [b, g, r])
                .collect()
        },
        ..r
    }),
];

/// The same maps with another rendering control.
fn all_at(maps: &[(Entry, Fetched)], rendering_control: RenderingControl) -> Vec<(Entry, Fetched)> {
    let controlled = maps.iter().cloned().map(|(entry, fetched)| {
        let entry = Entry {
            rendering_control,
            ..entry
        };
        (entry, fetched)
    });
    controlled.collect()
}

/// `PreLight` maps on the lit color, as if light on white were white.
fn unlit(maps: &[(Entry, Fetched)], lit: &crate::texture::Lit, rules: &Rules) -> Shade {
    let color = times(lit.white, lit.surface.color);
    let diffuse = crate::texture::Lit {
        surface: Shade {
            color,
            ..lit.surface
        },
        white: [1.0; 3],
        ..*lit
    };
    (SPEC.stage)(
        maps,
        &diffuse,
        Interpolation::Normal,
        Frequency::Pixel,
        rules,
    )
}

/// OpenGL's sphere map of a reflection vector.
#[expect(clippy::many_single_char_names, reason = "the letters of the formula")]
fn opengl(s: [f64; 3]) -> [f64; 2] {
    let l = length(s);
    let [x, y, z] = s.map(|c| c / l);
    let m = 2.0 * (x * x + y * y + (z + 1.0) * (z + 1.0)).sqrt();
    if m == 0.0 {
        return [0.5, 0.5];
    }
    [x / m + 0.5, y / m + 0.5]
}
