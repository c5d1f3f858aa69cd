//! Executable misreadings of the texture chapter.
//!
//! This catalog identifies the mistakes of a failing stage and measures the suite: every misreading must be caught, and every
//! pair distinguished. A misreading replaces one decision of [`Rules`](ptm_texture::Rules), usually by modifying the result of
//! the correct decision.

use std::sync::LazyLock;

use super::half::round_to_half;
use super::misreading::{Misreading, load_catalog};
use ptm_texture::boundary::fold_index;
use ptm_texture::compose::{mix, multiply};
use ptm_texture::map::texel_color;
use ptm_texture::parameterize::{dot, length};
use ptm_texture::{
    Boundary, Channel, ClampMethod, Color, Composition, Entry, Frequency, InteriorStyle,
    Interpolation, LitPrimitive, MapValue, Parameterization, RenderingControl, Rules, SampleMethod,
    Selection, Shade, Site, Texel, TexelKind, TextureMap,
};
use ptm_texture::{primitive::Terms, stage::is_split};

/// A function that introduces a mistake into the rules of texture mapping.
pub type Change = fn(&mut Rules);

impl Misreading<Change> {
    /// Applies this mistake to `rules`.
    #[must_use]
    pub fn apply_to(&self, rules: Rules) -> Rules {
        with_change(rules, self.change)
    }
}

/// The catalog, loaded on first use.
static ALL: LazyLock<Vec<Misreading<Change>>> = LazyLock::new(|| {
    let yaml = ptm_spec_cases::texture::MISREADINGS;
    load_catalog(yaml, CHANGES, |_| None)
        .unwrap_or_else(|error| unreachable!("invalid embedded misreadings.yaml: {error}"))
});

/// Returns all misreadings, in the order of the chapter.
pub fn all() -> impl Iterator<Item = &'static Misreading<Change>> {
    ALL.iter()
}

/// Returns the misreading with this slug, if any.
#[must_use]
pub fn find(slug: &str) -> Option<&'static Misreading<Change>> {
    all().find(|misreading| misreading.slug == slug)
}

use RenderingControl::{PostLight, PreLight};

const SPEC: Rules = Rules::SPEC;

/// Maps the slug of a misreading to its function. The slugs are in the order of `spec-cases/texture/misreadings.yaml`.
const CHANGES: fn(&str) -> Option<Change> = |slug| {
    Some(match slug {
        // ---------------------------------------------------------------- fallback values
        "pre-light-by-default" => |r| {
            r.fallback_values = || entry_with(|e| e.rendering_control = PreLight);
        },
        "vertex-coordinates-by-default" => |r| {
            r.fallback_values =
                || entry_with(|e| e.parameterization = Parameterization::VertexMCCoord);
        },
        "reflection-in-world-by-default" => |r| {
            r.fallback_values =
                || entry_with(|e| e.parameterization = Parameterization::ReflectionSphereWC);
        },
        "modulate-by-default" => |r| {
            r.fallback_values = || entry_with(|e| e.composition = Composition::Modulate);
        },
        "alpha-by-default" => |r| {
            r.fallback_values = || entry_with(|e| e.channel = Channel::Alpha);
        },
        "white-by-default" => |r| {
            r.fallback_values =
                || entry_with(|e| [e.env_color, e.background_color, e.clamp_color] = [[1.0; 3]; 3]);
        },
        "weighted-by-default" => |r| {
            r.fallback_values =
                || entry_with(|e| [e.min_sample, e.mag_sample] = [SampleMethod::WeightedBase; 2]);
        },
        "border-by-default" => |r| {
            r.fallback_values = || entry_with(|e| e.boundary = [Boundary::ClampBorder; 3]);
        },
        "clamp-color-by-default" => |r| {
            r.fallback_values = || entry_with(|e| e.clamp_method = ClampMethod::Color);
        },
        "hints-of-zero-by-default" => |r| {
            r.fallback_values = || entry_with(|e| e.frequency = [0.0; 3]);
        },
        // ---------------------------------------------------------------- indices
        "index-zero-accepted" => |r| r.is_valid_index = |i| (0..=65535).contains(&i),
        "index-unbounded" => |r| r.is_valid_index = |i| i >= 1,
        "index-65535-refused" => |r| r.is_valid_index = |i| (1..65535).contains(&i),
        "undefined-entry-is-fallback-values" => |r| {
            r.undefined_entry = |_, rules| (rules.fallback_values)();
        },
        "undefined-entry-is-the-first-defined" => |r| {
            r.undefined_entry = |table, rules| {
                let first = table.values().next().cloned();
                first.unwrap_or_else(rules.fallback_values)
            };
        },
        // ---------------------------------------------------------------- selection
        "style-ignored" => |r| r.is_textured = |_| true,
        "any-filled-style-is-textured" => |r| {
            r.is_textured = |style| matches!(style, InteriorStyle::Texture | InteriorStyle::Solid);
        },
        "back-attributes-without-distinguishing" => |r| r.uses_back = |surface| surface.back_facing,
        "back-attributes-ignored" => |r| r.uses_back = |_| false,
        "back-attributes-on-the-front" => |r| r.uses_back = |surface| surface.facet_distinguish,
        "limit-ignored" => |r| r.within_limit = |active, _| active.to_vec(),
        "last-maps-kept" => |r| {
            r.within_limit = |active, limit| active[active.len().saturating_sub(limit)..].to_vec();
        },
        "repeats-dropped" => |r| {
            r.within_limit =
                |active, limit| with_change((SPEC.within_limit)(active, limit), Vec::dedup);
        },
        "limit-off-by-one" => |r| {
            r.within_limit = |active, limit| (SPEC.within_limit)(active, limit.saturating_add(1));
        },
        "empty-list-is-untextured" => |r| r.empty_list = || Selection::Untextured,
        "empty-list-is-entry-one" => |r| r.empty_list = || Selection::Entries(vec![1]),
        // ---------------------------------------------------------------- the default map
        "checkerboard-black-at-origin" => |r| r.is_white = |i, j| !(SPEC.is_white)(i, j),
        "checkerboard-of-single-texels" => |r| r.checkerboard = || (16, 1),
        "checkerboard-of-8-texels" => |r| r.checkerboard = || (8, 1),
        "checkerboard-is-stripes" => |r| r.is_white = |i, _| i.is_multiple_of(2),
        // ---------------------------------------------------------------- parameterization
        "world-is-modelling" => |r| {
            r.parameterize = |entry, point, n, rules| {
                let mut changed = point.clone();
                changed.wc.position = point.mc.position.or(point.wc.position);
                (SPEC.parameterize)(entry, &changed, n, rules)
            };
        },
        "modelling-is-world" => |r| {
            r.parameterize = |entry, point, n, rules| {
                let mut changed = point.clone();
                changed.mc.position = point.wc.position.or(point.mc.position);
                (SPEC.parameterize)(entry, &changed, n, rules)
            };
        },
        "normal-is-not-transformed" => |r| {
            r.parameterize = |entry, point, n, rules| {
                let changed =
                    with_change(point.clone(), |p| p.wc.normal = p.mc.normal.or(p.wc.normal));
                (SPEC.parameterize)(entry, &changed, n, rules)
            };
        },
        "normal-in-world-always" => |r| {
            r.parameterize = |entry, point, n, rules| {
                let changed =
                    with_change(point.clone(), |p| p.mc.normal = p.wc.normal.or(p.mc.normal));
                (SPEC.parameterize)(entry, &changed, n, rules)
            };
        },
        "geometric-normal-always" => |r| r.normal = |place| place.geometric_normal.or(place.normal),
        "geometric-normal-never" => |r| {
            r.normal = |place| Some(place.normal.unwrap_or([0.0, 0.0, 1.0]));
        },
        "normals-moved-into-0-1" => |r| {
            r.parameterize = |entry, point, n, rules| {
                use Parameterization::{VertexMCNormal, VertexWCNormal};
                let t = (SPEC.parameterize)(entry, point, n, rules)?;
                Ok(match entry.parameterization {
                    VertexMCNormal | VertexWCNormal => t.map(|t| f64::midpoint(t, 1.0)),
                    _ => t,
                })
            };
        },
        "spline-parameters-exchanged" => |r| {
            r.spline_parameters =
                |point| with_change((SPEC.spline_parameters)(point), |t| t.swap(0, 1));
        },
        "spline-parameters-elsewhere" => |r| {
            r.spline_parameters = |point| match (&point.spline, point.mc.position) {
                (None, Some(position)) => position,
                _ => (SPEC.spline_parameters)(point),
            };
        },
        "data-index-ignored" => |r| r.float_data = |point, _, n| (SPEC.float_data)(point, 0, n),
        "data-index-for-all-methods" => |r| {
            r.parameterize = |entry, point, n, rules| {
                let mut entry = entry.clone();
                if entry.fp_data_index > 0 && !point.fp_data.is_empty() {
                    entry.parameterization = Parameterization::FloatData;
                }
                (SPEC.parameterize)(&entry, point, n, rules)
            };
        },
        "data-index-from-one" => |r| {
            r.float_data = |point, i, n| (SPEC.float_data)(point, i.saturating_sub(1), n);
        },
        "data-in-steps-of-the-dimension" => |r| {
            r.float_data = |point, i, n| (SPEC.float_data)(point, i.saturating_mul(n), n);
        },
        "same-datum-for-all" => |r| {
            r.float_data = |point, index, n| {
                let t = (SPEC.float_data)(point, index, n)?;
                Ok([0, 1, 2].map(|c| if c < n { t[0] } else { 0.0 }))
            };
        },
        "three-data-needed" => |r| {
            r.float_data = |point, index, _| (SPEC.float_data)(point, index, 3);
        },
        "data-of-two-dimensions" => |r| {
            r.float_data = |point, i, n| (SPEC.float_data)(point, i, n.min(2));
        },
        "vertex-data-on-splines" => |r| {
            r.float_data = |point, index, n| {
                let mut plain = point.clone();
                plain.spline.take_if(|_| !point.fp_data.is_empty());
                (SPEC.float_data)(&plain, index, n)
            };
        },
        "one-spline-for-all-coordinates" => |r| {
            r.float_data = |point, index, n| {
                let Some(spline) = &point.spline else {
                    return (SPEC.float_data)(point, index, n);
                };
                let values = spline.data.get(index).cloned().unwrap_or_default();
                let at = |c: usize| values.get(c).copied().unwrap_or_default();
                Ok([0, 1, 2].map(|c| if c < n { at(c) } else { 0.0 }))
            };
        },
        "reflection-inwards" => |r| r.reflect = |i, n| (SPEC.reflect)(i, n).map(|c| -c),
        "reflection-half" => |r| r.reflect = |i, n| [0, 1, 2].map(|c| i[c] - dot(n, i) * n[c]),
        "no-reflection" => |r| r.reflect = |i, _| i,
        "normal-as-reflection" => |r| r.reflect = |_, n| n,
        "sight-towards-the-eye" => |r| r.sight = |eye, position| (SPEC.sight)(position, eye),
        "eye-in-world" => |r| {
            r.vrc_vertex = |p| match p.wc.normal {
                Some(_) => p.wc.clone(),
                None => p.vrc.clone(),
            };
        },
        "eye-in-vrc" => |r| {
            r.wc_vertex = |p| match p.vrc.normal {
                Some(_) => p.vrc.clone(),
                None => p.wc.clone(),
            };
        },
        "reflection-matrix-ignored" => |r| r.rotate = |_, s| s,
        "reflection-matrix-transposed" => |r| {
            r.rotate = |m, s| [0, 1, 2].map(|c| dot([m[0][c], m[1][c], m[2][c]], s));
        },
        "reflection-matrix-moves" => |r| {
            r.rotate = |m, s| [0, 1, 2].map(|row| (SPEC.rotate)(m, s)[row] + m[row][3]);
        },
        "reflection-matrix-for-all-methods" => |r| {
            r.parameterize = |entry, point, n, rules| {
                use Parameterization::{ReflectionSphereVRC, ReflectionSphereWC};
                let t = (SPEC.parameterize)(entry, point, n, rules)?;
                Ok(match entry.parameterization {
                    ReflectionSphereVRC | ReflectionSphereWC => t,
                    _ => (SPEC.rotate)(&entry.reflection_matrix, t),
                })
            };
        },
        "vector-not-normalized" => |r| {
            r.wc_height = |s| (-s[1]).clamp(-1.0, 1.0).acos() / std::f64::consts::PI;
            r.vrc_height = r.wc_height;
        },
        "vrc-once-around" => |r| r.vrc_azimuth = SPEC.wc_azimuth,
        "wc-twice-around" => |r| r.wc_azimuth = SPEC.vrc_azimuth,
        "seam-at-minus-x" => |r| r.wc_azimuth = |s| ((SPEC.wc_azimuth)(s) + 0.5).fract(),
        "azimuth-in-radians" => |r| {
            r.wc_azimuth = |s| (SPEC.wc_azimuth)(s) * 2.0 * std::f64::consts::PI;
        },
        "axis-is-z" => |r| {
            r.wc_azimuth = |s| (SPEC.wc_azimuth)([s[0], s[2], -s[1]]);
            r.wc_height = |s| (SPEC.wc_height)([s[0], s[2], -s[1]]);
            r.vrc_azimuth = |s| (SPEC.vrc_azimuth)([s[0], s[2], -s[1]]);
            r.vrc_height = |s| (SPEC.vrc_height)([s[0], s[2], -s[1]]);
        },
        "sphere-map-of-opengl" => |r| {
            r.vrc_azimuth = |s| opengl_sphere_map(s)[0];
            r.vrc_height = |s| opengl_sphere_map(s)[1];
        },
        // ---------------------------------------------------------------- orientation, interpolation
        "orientation-ignored" => |r| r.orient = |_, t| t,
        "orientation-transposed" => |r| {
            r.orient = |m, t| {
                let transposed = std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]));
                (SPEC.orient)(&transposed, t)
            };
        },
        "orientation-without-translation" => |r| r.orient = |matrix, t| (SPEC.rotate)(matrix, t),
        "orientation-of-two-coordinates" => |r| {
            r.orient = |m, t| with_change((SPEC.orient)(m, [t[0], t[1], 0.0]), |out| out[2] = t[2]);
        },
        "orientation-after-sampling-range" => |r| {
            r.orient = |matrix, t| (SPEC.orient)(matrix, t.map(|t| t - t.floor()));
        },
        "no-perspective-correction" => |r| r.hyperbolic = SPEC.linear,
        "perspective-always" => |r| r.linear = SPEC.hyperbolic,
        "perspective-inverted" => |r| {
            r.hyperbolic = |ts, b, w| {
                let inverse: Vec<f64> = w.iter().map(|w| 1.0 / w).collect();
                (SPEC.hyperbolic)(ts, b, &inverse)
            };
        },
        "sampled-per-vertex-always" => |r| {
            r.site = |_, frequency| match frequency {
                Frequency::Pixel => Site::Pixel,
                Frequency::InterpDep => Site::Vertex,
            };
        },
        "sampled-per-pixel-always" => |r| r.site = |_, _| Site::Pixel,
        "sample-frequency-overruled" => |r| {
            r.site = |interpolation, _| (SPEC.site)(interpolation, Frequency::InterpDep);
        },
        "dot-product-per-vertex" => |r| {
            r.site = |interpolation, frequency| match (interpolation, frequency) {
                (Interpolation::DotProduct, Frequency::InterpDep) => Site::Vertex,
                _ => (SPEC.site)(interpolation, frequency),
            };
        },
        // ---------------------------------------------------------------- stages
        "order-reversed" => |r| {
            r.stage = |maps, lit, i, f, rules| {
                let reversed: Vec<_> = maps.iter().rev().cloned().collect();
                (SPEC.stage)(&reversed, lit, i, f, rules)
            };
        },
        "only-the-last-map" => |r| {
            r.stage = |maps, lit, i, f, rules| {
                (SPEC.stage)(&maps[maps.len().saturating_sub(1)..], lit, i, f, rules)
            };
        },
        "only-the-first-map" => |r| {
            r.stage =
                |maps, lit, i, f, rules| (SPEC.stage)(&maps[..maps.len().min(1)], lit, i, f, rules);
        },
        "post-light-before-light" => |r| {
            r.stage = |maps, lit, i, f, rules| {
                (SPEC.stage)(&with_rendering_control(maps, PreLight), lit, i, f, rules)
            };
        },
        "pre-light-after-light" => |r| {
            r.stage = |maps, lit, i, f, rules| {
                (SPEC.stage)(&with_rendering_control(maps, PostLight), lit, i, f, rules)
            };
        },
        "list-order-over-stages" => |r| {
            r.stage = |maps, lit, i, f, rules| {
                let control = |(entry, _): &(Entry, MapValue)| entry.rendering_control;
                let first = maps.first().map_or(PostLight, control);
                (SPEC.stage)(&with_rendering_control(maps, first), lit, i, f, rules)
            };
        },
        "specular-textured" => |r| {
            r.add_specular = |shade, specular| {
                let textured = [0, 1, 2].map(|c| shade.color[c] + specular[c] * shade.color[c]);
                with_color(shade, textured)
            };
        },
        "specular-lost" => |r| r.add_specular = |shade, _| shade,
        "white-light-lost" => |r| {
            r.stage = |maps, lit, i, f, rules| {
                if is_split(i, f) {
                    apply_to_lit_color(maps, lit, rules)
                } else {
                    (SPEC.stage)(maps, lit, i, f, rules)
                }
            };
        },
        "split-multiplies-twice" => |r| {
            r.stage = |maps, lit, i, f, rules| {
                let shade = (SPEC.stage)(maps, lit, i, f, rules);
                let is_pre = |(entry, _): &(Entry, MapValue)| entry.rendering_control == PreLight;
                if !(maps.iter().any(is_pre) && is_split(i, f)) {
                    return shade;
                }
                let [white, specular] = [lit.white, lit.specular];
                let twice = |c: usize| (shade.color[c] - specular[c]) * white[c] + specular[c];
                with_color(shade, [0, 1, 2].map(twice))
            };
        },
        "direct-form-unlit" => |r| r.light = |shade, lit| (SPEC.add_specular)(shade, lit.specular),
        // ---------------------------------------------------------------- composition
        "luminance-is-red" => |r| {
            r.texel_color = |texel| match texel.luminance() {
                Some(luminance) => [luminance, 0.0, 0.0],
                None => (SPEC.texel_color)(texel),
            };
        },
        "premultiplied" => |r| {
            r.texel_color =
                |texel| (SPEC.texel_color)(texel).map(|c| c * texel.alpha().unwrap_or(1.0));
        },
        "replace-modulates" => |r| {
            r.replace = |x| with_alpha((SPEC.modulate)(x), x.alpha.unwrap_or(x.input.alpha));
        },
        "replace-keeps-alpha" => |r| r.replace = |x| with_alpha((SPEC.replace)(x), x.input.alpha),
        "replace-makes-opaque" => |r| {
            r.replace = |x| with_alpha((SPEC.replace)(x), x.alpha.unwrap_or(1.0));
        },
        "replace-multiplies-alpha" => |r| {
            r.replace = |x| with_alpha((SPEC.replace)(x), x.input.alpha * x.alpha.unwrap_or(1.0));
        },
        "replace-unlit" => |r| r.replace = |x| with_color((SPEC.replace)(x), x.color),
        "modulate-keeps-alpha" => |r| {
            r.modulate = |x| with_alpha((SPEC.modulate)(x), x.input.alpha);
        },
        "modulate-replaces-alpha" => |r| {
            r.modulate = |x| with_alpha((SPEC.modulate)(x), x.alpha.unwrap_or(x.input.alpha));
        },
        "modulate-doubles" => |r| {
            r.modulate =
                |x| with_change((SPEC.modulate)(x), |y| y.color = y.color.map(|c| 2.0 * c));
        },
        "modulate-adds" => |r| {
            r.modulate = |x| {
                let sum = [0, 1, 2].map(|c| x.input.color[c] + x.color[c]);
                with_color((SPEC.modulate)(x), sum)
            };
        },
        "modulate-lit-twice" => |r| {
            r.modulate =
                |x| with_change((SPEC.modulate)(x), |y| y.color = multiply(x.white, y.color));
        },
        "blend-the-other-way" => |r| {
            r.blend_env_color = |x| {
                (SPEC.blend_env_color)(&with_change(*x, |x| x.gamma = x.gamma.map(|g| 1.0 - g)))
            };
        },
        "blend-adds" => |r| {
            r.blend_env_color = |x| {
                let environment = multiply(x.white, x.entry.env_color);
                let sum = [0, 1, 2].map(|c| x.input.color[c] + x.gamma[c] * environment[c]);
                with_color((SPEC.blend_env_color)(x), sum)
            };
        },
        "blend-with-the-texel" => |r| {
            r.blend_env_color = |x| blend_with(x, multiply(x.white, x.color));
        },
        "blend-environment-unlit" => |r| r.blend_env_color = |x| blend_with(x, x.entry.env_color),
        "blend-keeps-alpha" => |r| {
            r.blend_env_color = |x| with_alpha((SPEC.blend_env_color)(x), x.input.alpha);
        },
        "background-for-environment" => |r| {
            r.blend_env_color = |x| blend_with(x, multiply(x.white, x.entry.background_color));
        },
        "channel-ignored" => |r| {
            r.gamma = |_, texel| [(SPEC.texel_color)(texel)[0]; 3];
        },
        "channels-from-blue" => |r| {
            r.gamma = |entry, texel| {
                let other = match entry.channel {
                    Channel::Red => Channel::Blue,
                    Channel::Blue => Channel::Red,
                    other => other,
                };
                (SPEC.gamma)(&with_change(entry.clone(), |e| e.channel = other), texel)
            };
        },
        "channels-from-alpha" => |r| {
            r.gamma = |entry, texel| {
                let other = match entry.channel {
                    Channel::Alpha => Channel::Red,
                    Channel::Red => Channel::Green,
                    Channel::Green => Channel::Blue,
                    Channel::Blue => Channel::Alpha,
                };
                (SPEC.gamma)(&with_change(entry.clone(), |e| e.channel = other), texel)
            };
        },
        "gray-of-the-texel" => |r| {
            r.gamma = |_, texel| [(SPEC.texel_color)(texel).iter().sum::<f64>() / 3.0; 3];
        },
        "luminance-alpha-selected" => |r| {
            r.gamma = |entry, texel| match (entry.channel, texel.luminance(), texel.alpha()) {
                (Channel::Alpha, Some(_), Some(alpha)) => [alpha; 3],
                _ => (SPEC.gamma)(entry, texel),
            };
        },
        "decal-the-other-way" => |r| {
            r.decal = |x| match x.alpha {
                Some(alpha) => cover_with(x, multiply(x.white, x.color), [1.0 - alpha; 3]),
                None => (SPEC.decal)(x),
            };
        },
        "decal-by-primitive-alpha" => |r| {
            r.decal = |x| cover_with(x, multiply(x.white, x.color), [x.input.alpha; 3]);
        },
        "decal-replaces-alpha" => |r| {
            r.decal = |x| with_alpha((SPEC.decal)(x), x.alpha.unwrap_or(x.input.alpha));
        },
        "decal-multiplies-alpha" => |r| {
            r.decal = |x| with_alpha((SPEC.decal)(x), x.input.alpha * x.alpha.unwrap_or(1.0));
        },
        "decal-without-alpha-is-nothing" => |r| {
            r.decal = |x| x.alpha.map_or(x.input, |_| (SPEC.decal)(x));
        },
        "decal-by-channel" => |r| r.decal = |x| cover_with(x, multiply(x.white, x.color), x.gamma),
        "decal-unlit" => |r| r.decal = |x| cover_with(x, x.color, [x.alpha.unwrap_or(1.0); 3]),
        "background-is-primitive" => |r| r.decal_background = SPEC.decal,
        "environment-for-background" => |r| {
            r.decal_background = |x| {
                let over = mix(x.entry.env_color, x.color, [x.alpha.unwrap_or(1.0); 3]);
                with_color(x.input, multiply(x.white, over))
            };
        },
        "background-unlit" => |r| {
            r.decal_background = |x| {
                let [lit, share] = [multiply(x.white, x.color), [x.alpha.unwrap_or(1.0); 3]];
                with_color(x.input, mix(x.entry.background_color, lit, share))
            };
        },
        "background-replaces-alpha" => |r| {
            r.decal_background =
                |x| with_alpha((SPEC.decal_background)(x), x.alpha.unwrap_or(x.input.alpha));
        },
        "background-without-alpha" => |r| {
            r.decal_background = |x| match x.alpha {
                Some(_) => (SPEC.decal_background)(x),
                None => with_color(x.input, multiply(x.white, x.entry.background_color)),
            };
        },
        "background-the-other-way" => |r| {
            r.decal_background = |x| match x.alpha {
                Some(alpha) => {
                    let under = mix(x.color, x.entry.background_color, [alpha; 3]);
                    with_color(x.input, multiply(x.white, under))
                }
                None => (SPEC.decal_background)(x),
            };
        },
        // ---------------------------------------------------------------- sampling
        "minification-always" => |r| r.method = |entry, _| entry.min_sample,
        "methods-exchanged" => |r| r.method = |entry, magnify| (SPEC.method)(entry, !magnify),
        "texels-of-8-bits" => |r| {
            r.stored_component = |value| (value.clamp(0.0, 1.0) * 255.0).round() / 255.0;
        },
        "texels-of-half-floats" => |r| r.stored_component = round_to_half,
        "texels-column-first" => |r| {
            r.offset = |size, at| (at[0] * size[1] + at[1]) * size[2] + at[2];
        },
        "first-row-at-the-top" => |r| {
            r.offset = |size, at| (SPEC.offset)(size, [at[0], size[1] - 1 - at[1], at[2]]);
        },
        "slices-ignored" => |r| r.offset = |size, at| (SPEC.offset)(size, [at[0], at[1], 0]),
        "coordinates-in-texels" => |r| {
            r.closest = |edge, t, size, rules| (SPEC.closest)(edge, t / size as f64, size, rules);
        },
        "closest-rounds" => |r| {
            r.closest =
                |edge, t, size, rules| (SPEC.closest)(edge, t + 0.5 / size as f64, size, rules);
        },
        "weighted-is-single" => |r| {
            r.neighbors =
                |edge, t, size, rules| [((rules.closest)(edge, t, size, rules), 1.0), (0, 0.0)];
        },
        "weighted-half-off" => |r| {
            r.neighbors =
                |edge, t, size, rules| (SPEC.neighbors)(edge, t + 0.5 / size as f64, size, rules);
        },
        "weights-exchanged" => |r| {
            r.neighbors = |edge, t, size, rules| {
                let [(a, wa), (b, wb)] = (SPEC.neighbors)(edge, t, size, rules);
                [(a, wb), (b, wa)]
            };
        },
        "weights-equal" => |r| {
            r.neighbors = |edge, t, size, rules| {
                (SPEC.neighbors)(edge, t, size, rules).map(|(at, _)| (at, 0.5))
            };
        },
        "weights-smoothed" => |r| {
            r.neighbors = |edge, t, size, rules| {
                let [(a, _), (b, f)] = (SPEC.neighbors)(edge, t, size, rules);
                let smooth = f * f * (3.0 - 2.0 * f);
                [(a, 1.0 - smooth), (b, smooth)]
            };
        },
        "level-rounded-down" => |r| {
            r.closest_level = |depth, top| (depth.floor().max(0.0) as usize).min(top);
        },
        "level-rounded-up" => |r| {
            r.closest_level = |depth, top| (depth.ceil().max(0.0) as usize).min(top);
        },
        "levels-from-the-pinnacle" => |r| {
            r.closest_level = |depth, top| (SPEC.closest_level)(top as f64 - depth, top);
            r.levels = |depth, top| (SPEC.levels)(top as f64 - depth, top);
        },
        "levels-ignored" => |r| {
            r.closest_level = |_, _| 0;
            r.levels = |_, _| (0, 0, 0.0);
        },
        "between-is-closest" => |r| {
            r.levels = |depth, top| ((SPEC.closest_level)(depth, top), 0, 0.0);
        },
        "between-is-the-mean" => |r| {
            r.levels = |depth, top| {
                with_change((SPEC.levels)(depth, top), |at| {
                    at.2 = if at.2 > 0.0 { 0.5 } else { 0.0 }
                })
            };
        },
        "between-the-other-way" => |r| {
            r.levels = |depth, top| {
                with_change((SPEC.levels)(depth, top), |at| {
                    at.2 = if at.2 > 0.0 { 1.0 - at.2 } else { 0.0 }
                })
            };
        },
        "depth-extrapolated" => |r| {
            r.levels = |depth, top| {
                let lower = (depth.floor().max(0.0) as usize).min(top.saturating_sub(1));
                (lower, (lower + 1).min(top), depth - lower as f64)
            };
        },
        "depth-wraps" => |r| {
            r.levels = |depth, top| {
                if depth > top as f64 {
                    (0, 0, 0.0)
                } else {
                    (SPEC.levels)(depth, top)
                }
            };
        },
        // ---------------------------------------------------------------- boundaries
        "wrap-in-c" => |r| r.wrap = |k, size| (k % size as i64).unsigned_abs() as usize,
        "wrap-truncates" => |r| {
            r.closest = |edge, t, size, rules| {
                let is_negative = edge == Boundary::Wrap && t < 0.0;
                (SPEC.closest)(edge, t + f64::from(is_negative) / size as f64, size, rules)
            };
        },
        "wrap-loses-the-last-texel" => |r| {
            r.wrap = |k, size| {
                if (0..size as i64).contains(&k) {
                    k as usize
                } else {
                    k.rem_euclid((size as i64 - 1).max(1)) as usize
                }
            };
        },
        "wrap-clamps-neighbours" => |r| {
            r.neighbors = |edge, t, size, rules| {
                let edge = match edge {
                    Boundary::Wrap if (0.0..=1.0).contains(&t) => Boundary::ClampBorder,
                    _ => edge,
                };
                (SPEC.neighbors)(edge, t, size, rules)
            };
        },
        "mirror-wraps" => |r| r.mirror = SPEC.wrap,
        "mirror-once" => |r| {
            r.mirror = |k, size| match size as i64 {
                _ if k < 0 => (SPEC.border)(-1 - k, size),
                n if k >= n => (SPEC.border)(2 * n - 1 - k, size),
                _ => (SPEC.border)(k, size),
            };
        },
        "mirror-without-the-edge" => |r| {
            r.mirror = |k, size| {
                let period = (2 * (size as i64 - 1)).max(1);
                let m = k.rem_euclid(period);
                m.min(period - m).min(size as i64 - 1) as usize
            };
        },
        "mirror-of-the-first-tile" => |r| r.mirror = |k, size| size - 1 - (SPEC.mirror)(k, size),
        "border-wraps" => |r| r.border = SPEC.wrap,
        "border-is-black" => |r| {
            r.is_clamped = |entry, t, n, rules| {
                let is_border = |d| entry.boundary[d] == Boundary::ClampBorder;
                (SPEC.is_clamped)(entry, t, n, rules)
                    || (0..n).any(|d| is_border(d) && (rules.is_outside)(t[d]))
            };
        },
        "border-of-the-first-texel" => |r| {
            r.border = |k, size| usize::try_from(k).ok().filter(|&k| k < size).unwrap_or(0);
        },
        "explicit-is-border" => |r| r.is_clamped = |_, _, _, _| false,
        "clamp-color-blended" => |r| {
            r.outside = |entry, map, t, method, rules| match entry.clamp_method {
                ClampMethod::Color if method == SampleMethod::WeightedBase => {
                    MapValue::Clamped(average_with_border(entry, map, t, rules))
                }
                _ => (rules.clamp)(entry),
            };
        },
        "one-is-outside" => |r| r.is_outside = |t| !(0.0..1.0).contains(&t),
        "zero-is-outside" => |r| r.is_outside = |t| !(t > 0.0 && t <= 1.0),
        "only-beyond-one-is-outside" => |r| r.is_outside = |t| t > 1.0,
        "all-directions-must-be-outside" => |r| {
            r.is_clamped = |entry, t, n, rules| {
                (0..n).all(|d| (rules.is_outside)(t[d])) && (SPEC.is_clamped)(entry, t, n, rules)
            };
        },
        "any-outside-clamps" => |r| {
            r.is_clamped = |entry, t, n, rules| {
                entry.boundary[..n].contains(&Boundary::ClampExplicit)
                    && t[..n].iter().any(|&t| (rules.is_outside)(t))
            };
        },
        "t2-clamps-a-picture" => |r| {
            r.is_clamped = |entry, t, _, rules| (SPEC.is_clamped)(entry, t, 3, rules);
        },
        "one-condition-for-all" => |r| r.condition = |entry, _| entry.boundary[0],
        "discontinue-is-black" => |r| {
            r.clamp = |entry| match (SPEC.clamp)(entry) {
                MapValue::Discontinued => MapValue::Texel(Texel::rgb([0.0; 3])),
                other => other,
            };
        },
        "clamp-color-ignored" => |r| r.clamp = |_| MapValue::Discontinued,
        "clamp-color-is-background" => |r| {
            r.clamp = |entry| {
                (SPEC.clamp)(&with_change(entry.clone(), |e| {
                    e.clamp_color = e.background_color;
                }))
            };
        },
        "clamp-color-always" => |r| {
            r.clamp = |entry| MapValue::Clamped(Texel::rgb(entry.clamp_color));
        },
        // ---------------------------------------------------------------- a PTM as a map
        "ptm-top-row-first" => |r| r.rows = |image| image.values.as_chunks::<3>().0.to_vec(),
        "ptm-mirrored" => |r| {
            r.rows = |image| {
                let rows = (SPEC.rows)(image);
                let rows = rows.chunks_exact(image.size.width as usize);
                rows.flat_map(|row| row.iter().rev().copied()).collect()
            };
        },
        "ptm-blue-first" => |r| {
            r.rows = |image| {
                let rows = (SPEC.rows)(image).into_iter();
                rows.map(|[r, g, b]| [b, g, r]).collect()
            };
        },
        _ => return None,
    })
};

fn with_change<T>(mut value: T, change: impl FnOnce(&mut T)) -> T {
    change(&mut value);
    value
}

/// Returns an entry with fallback values, some of which are changed by `change`.
fn entry_with(change: fn(&mut Entry)) -> Entry {
    with_change(Entry::default(), change)
}

fn with_color(shade: Shade, color: Color) -> Shade {
    Shade { color, ..shade }
}

fn with_alpha(shade: Shade, alpha: f64) -> Shade {
    Shade { alpha, ..shade }
}

/// Blends the primitive with `color` instead of the lit environment color (R-CMP-34).
fn blend_with(x: &Terms, color: Color) -> Shade {
    with_color(
        (SPEC.blend_env_color)(x),
        mix(x.input.color, color, x.gamma),
    )
}

/// Covers the primitive with `color`, weighted per channel by `weights`, like a decal (R-CMP-37).
fn cover_with(x: &Terms, color: Color, weights: Color) -> Shade {
    with_color(x.input, mix(x.input.color, color, weights))
}

/// Returns the weighted average of the base level, in which the texels beyond an edge with explicit clamp have the clamp color.
/// Texture units do this at a border.
fn average_with_border(entry: &Entry, map: &TextureMap, t: [f64; 3], rules: &Rules) -> Texel {
    let level = &map.levels()[0];
    let corners = (0..1_usize << map.dimensions()).map(|corner| {
        let (mut at, mut weight, mut is_border) = ([0; 3], 1.0, false);
        for d in 0..map.dimensions() {
            let (boundary, size) = ((rules.condition)(entry, d), level.size[d]);
            let u = t[d] * size as f64 - 0.5;
            let is_upper = corner >> d & 1 == 1;
            let k = u.floor() as i64 + i64::from(is_upper);
            let share = u - u.floor();
            weight *= if is_upper { share } else { 1.0 - share };
            is_border |= boundary == Boundary::ClampExplicit && !(0..size as i64).contains(&k);
            at[d] = fold_index(boundary, k, size, rules);
        }
        let color = if is_border {
            entry.clamp_color
        } else {
            texel_color(&level.texels[(rules.offset)(level.size, at)])
        };
        (Texel::rgb(color), weight)
    });
    Texel::sum(TexelKind::RGB, corners)
}

fn with_rendering_control(
    maps: &[(Entry, MapValue)],
    control: RenderingControl,
) -> Vec<(Entry, MapValue)> {
    let mut maps = maps.to_vec();
    for (entry, _) in &mut maps {
        entry.rendering_control = control;
    }
    maps
}

/// Applies the maps to the lit color: multiplies the surface color by the light, then treats the light as white.
fn apply_to_lit_color(maps: &[(Entry, MapValue)], lit: &LitPrimitive, rules: &Rules) -> Shade {
    let diffuse = LitPrimitive {
        surface: with_color(lit.surface, multiply(lit.white, lit.surface.color)),
        white: [1.0; 3],
        ..*lit
    };
    let (i, f) = (Interpolation::Normal, Frequency::Pixel);
    (SPEC.stage)(maps, &diffuse, i, f, rules)
}

/// Returns the coordinates of a reflection vector in OpenGL's sphere map.
#[expect(clippy::many_single_char_names, reason = "the letters of the formula")]
fn opengl_sphere_map(s: [f64; 3]) -> [f64; 2] {
    let l = length(s);
    let [x, y, z] = s.map(|c| c / l);
    let m = 2.0 * (x * x + y * y + (z + 1.0) * (z + 1.0)).sqrt();
    if m == 0.0 {
        return [0.5, 0.5];
    }
    [x / m + 0.5, y / m + 0.5]
}
