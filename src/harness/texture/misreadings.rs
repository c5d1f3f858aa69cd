//! Executable mistakes: each a plausible misreading of one requirement, at the one decision where it acts.
//!
//! The same catalogue names the mistake of a failing decoder and measures the suite: every misreading must be caught, every pair
//! told apart.

use crate::texture::Rules;
use crate::texture::compose::{mix, times};
use crate::texture::parameterize::{dot, length};
use crate::texture::{
    Boundary, Channel, Entry, Fetched, Frequency, InteriorStyle, Interpolation, Parameterization,
    RenderingControl, SampleMethod, Selection, Shade, Site, Texel,
};

/// One mistake.
pub struct Misreading {
    /// A permanent name.
    pub slug: &'static str,
    /// The requirement it misreads.
    pub clause: &'static str,
    /// What one who makes it does, as a sentence without its subject.
    pub effect: &'static str,
    /// What to do about it.
    pub mend: &'static str,
    /// Where it acts.
    pub change: fn(Rules) -> Rules,
}

/// The misreading of that name.
#[must_use]
pub fn named(slug: &str) -> Option<&'static Misreading> {
    ALL.iter().find(|misreading| misreading.slug == slug)
}

const SPEC: Rules = Rules::SPEC;

/// Shortens the tables below.
const fn m(
    slug: &'static str,
    clause: &'static str,
    effect: &'static str,
    mend: &'static str,
    change: fn(Rules) -> Rules,
) -> Misreading {
    Misreading {
        slug,
        clause,
        effect,
        mend,
        change,
    }
}

/// All misreadings, in the order of the chapter.
pub const ALL: &[Misreading] = &[
    // ---------------------------------------------------------------- fallback values
    m(
        "pre-light-by-default",
        "R-TBL-04",
        "applies a map before the light unless told",
        "let rendering control fall back to PostLight",
        |r| Rules {
            fallback_values: || Entry {
                rendering_control: RenderingControl::PreLight,
                ..Entry::default()
            },
            ..r
        },
    ),
    m(
        "vertex-coordinates-by-default",
        "R-TBL-05",
        "takes vertex coordinates unless told",
        "let the parameterization method fall back to ReflectionSphereVRC",
        |r| Rules {
            fallback_values: || Entry {
                parameterization: Parameterization::VertexMCCoord,
                ..Entry::default()
            },
            ..r
        },
    ),
    m(
        "reflection-in-world-by-default",
        "R-TBL-05",
        "reflects in world coordinates unless told",
        "let the parameterization method fall back to ReflectionSphereVRC",
        |r| Rules {
            fallback_values: || Entry {
                parameterization: Parameterization::ReflectionSphereWC,
                ..Entry::default()
            },
            ..r
        },
    ),
    m(
        "modulate-by-default",
        "R-TBL-09",
        "multiplies colors unless told",
        "let the composition method fall back to Replace",
        |r| Rules {
            fallback_values: || Entry {
                composition: crate::texture::Composition::Modulate,
                ..Entry::default()
            },
            ..r
        },
    ),
    m(
        "alpha-by-default",
        "R-TBL-10",
        "selects alpha unless told",
        "let the channel selector fall back to Red",
        |r| Rules {
            fallback_values: || Entry {
                channel: Channel::Alpha,
                ..Entry::default()
            },
            ..r
        },
    ),
    m(
        "white-by-default",
        "R-TBL-11",
        "takes white for colors that are not set",
        "let environment, background and clamp color fall back to black",
        |r| Rules {
            fallback_values: || Entry {
                env_color: [1.0; 3],
                background_color: [1.0; 3],
                clamp_color: [1.0; 3],
                ..Entry::default()
            },
            ..r
        },
    ),
    m(
        "weighted-by-default",
        "R-TBL-13",
        "averages texels unless told",
        "let both sample methods fall back to SingleBase",
        |r| Rules {
            fallback_values: || Entry {
                min_sample: SampleMethod::WeightedBase,
                mag_sample: SampleMethod::WeightedBase,
                ..Entry::default()
            },
            ..r
        },
    ),
    m(
        "border-by-default",
        "R-TBL-14",
        "clamps to the border unless told",
        "let the boundary conditions fall back to Wrap",
        |r| Rules {
            fallback_values: || Entry {
                boundary: [Boundary::ClampBorder; 3],
                ..Entry::default()
            },
            ..r
        },
    ),
    m(
        "clamp-color-by-default",
        "R-TBL-15",
        "applies the clamp color unless told",
        "let the clamp method fall back to Discontinue",
        |r| Rules {
            fallback_values: || Entry {
                clamp_method: crate::texture::ClampMethod::Color,
                ..Entry::default()
            },
            ..r
        },
    ),
    m(
        "hints-of-zero-by-default",
        "R-TBL-17",
        "takes 0 for frequency hints that are not set",
        "let the frequency hints fall back to 1.0",
        |r| Rules {
            fallback_values: || Entry {
                frequency: [0.0; 3],
                ..Entry::default()
            },
            ..r
        },
    ),
    // ---------------------------------------------------------------- indices
    m(
        "index-zero-accepted",
        "R-RST-02",
        "accepts index 0",
        "refuse indices below 1",
        |r| Rules {
            valid_index: |i| (0..=65535).contains(&i),
            ..r
        },
    ),
    m(
        "index-unbounded",
        "R-RST-02",
        "accepts indices above 65535",
        "refuse them",
        |r| Rules {
            valid_index: |i| i >= 1,
            ..r
        },
    ),
    m(
        "index-65535-refused",
        "R-RST-02",
        "refuses index 65535",
        "accept it: the range includes its end",
        |r| Rules {
            valid_index: |i| (1..65535).contains(&i),
            ..r
        },
    ),
    m(
        "undefined-entry-is-fallback-values",
        "R-RST-03",
        "takes the fallback values for an index without an entry",
        "take entry 1 where there is one",
        |r| Rules {
            undefined_entry: |_, rules| (rules.fallback_values)(),
            ..r
        },
    ),
    m(
        "undefined-entry-is-the-first-defined",
        "R-RST-03",
        "takes the lowest entry there is for an index without an entry",
        "take entry 1, and fallback values if it is not there",
        |r| Rules {
            undefined_entry: |table, rules| {
                table
                    .values()
                    .next()
                    .cloned()
                    .unwrap_or_else(rules.fallback_values)
            },
            ..r
        },
    ),
    // ---------------------------------------------------------------- selection
    m(
        "style-ignored",
        "R-SEL-01",
        "applies textures whatever the interior style",
        "look at the list only where the style is Texture",
        |r| Rules {
            is_textured: |_| true,
            ..r
        },
    ),
    m(
        "any-filled-style-is-textured",
        "R-SEL-01",
        "applies textures to solid surfaces",
        "look at the list only where the style is Texture",
        |r| Rules {
            is_textured: |style| matches!(style, InteriorStyle::Texture | InteriorStyle::Solid),
            ..r
        },
    ),
    m(
        "back-attributes-without-distinguishing",
        "R-SEL-02",
        "uses the attributes of the back although facets are not distinguished",
        "use them only if facet distinguishing is on",
        |r| Rules {
            uses_back: |_, back| back,
            ..r
        },
    ),
    m(
        "back-attributes-ignored",
        "R-SEL-02",
        "uses the attributes of the front for both sides",
        "use those of the back for back-facing facets if facets are distinguished",
        |r| Rules {
            uses_back: |_, _| false,
            ..r
        },
    ),
    m(
        "back-attributes-on-the-front",
        "R-SEL-02",
        "uses the attributes of the back for all facets if they are distinguished",
        "use them for back-facing facets only",
        |r| Rules {
            uses_back: |surface, _| surface.facet_distinguish,
            ..r
        },
    ),
    m(
        "limit-ignored",
        "R-SEL-04",
        "applies more maps than MaxTextureMaps",
        "ignore the indices behind the first MaxTextureMaps",
        |r| Rules {
            within_limit: |active, _| active.to_vec(),
            ..r
        },
    ),
    m(
        "last-maps-kept",
        "R-SEL-04",
        "keeps the last MaxTextureMaps indices",
        "keep the first",
        |r| Rules {
            within_limit: |active, most| active[active.len().saturating_sub(most)..].to_vec(),
            ..r
        },
    ),
    m(
        "repeats-dropped",
        "R-SEL-03",
        "applies an entry once although its index stands in the list twice",
        "apply the list index by index",
        |r| Rules {
            within_limit: |active, most| {
                let mut kept = (SPEC.within_limit)(active, most);
                kept.dedup();
                kept
            },
            ..r
        },
    ),
    m(
        "limit-off-by-one",
        "R-SEL-04",
        "applies one map more than MaxTextureMaps",
        "count the maps from 1",
        |r| Rules {
            within_limit: |active, most| (SPEC.within_limit)(active, most.saturating_add(1)),
            ..r
        },
    ),
    m(
        "empty-list-is-untextured",
        "R-SEL-06",
        "applies no texture where the list is empty",
        "apply the default map once, with fallback values",
        |r| Rules {
            empty_list: || Selection::Untextured,
            ..r
        },
    ),
    m(
        "empty-list-is-entry-one",
        "R-SEL-06",
        "applies entry 1 where the list is empty",
        "apply the default map with fallback values; the table is not looked at",
        |r| Rules {
            empty_list: || Selection::Entries(vec![1]),
            ..r
        },
    ),
    // ---------------------------------------------------------------- the default map
    m(
        "checkerboard-black-at-origin",
        "R-SEL-13",
        "begins the default map with black",
        "make the square at t0 = t1 = 0 white",
        |r| Rules {
            is_white: |i, j| !(SPEC.is_white)(i, j),
            ..r
        },
    ),
    m(
        "checkerboard-of-single-texels",
        "R-SEL-12",
        "makes squares of one texel",
        "make squares of 2×2 texels",
        |r| Rules {
            checkerboard: || (16, 1),
            ..r
        },
    ),
    m(
        "checkerboard-of-8-texels",
        "R-SEL-12",
        "makes the default map of 8×8 texels",
        "make it of 16×16 texels, each square of 2×2",
        |r| Rules {
            checkerboard: || (8, 1),
            ..r
        },
    ),
    m(
        "checkerboard-is-stripes",
        "R-SEL-11",
        "makes stripes of the default map",
        "let squares alternate in both directions",
        |r| Rules {
            is_white: |i, _| i.is_multiple_of(2),
            ..r
        },
    ),
    // ---------------------------------------------------------------- parameterization
    m(
        "world-is-modelling",
        "R-PAR-14",
        "takes modelling coordinates where world coordinates are asked for",
        "transform the vertex, and its normal, first",
        |r| Rules {
            parameterize: |entry, point, dimensions, rules| {
                let mut untransformed = point.clone();
                untransformed.wc.position = point.mc.position.or(point.wc.position);
                (SPEC.parameterize)(entry, &untransformed, dimensions, rules)
            },
            ..r
        },
    ),
    m(
        "modelling-is-world",
        "R-PAR-13",
        "takes world coordinates where modelling coordinates are asked for",
        "take the vertex as it was specified",
        |r| Rules {
            parameterize: |entry, point, dimensions, rules| {
                let mut transformed = point.clone();
                transformed.mc.position = point.wc.position.or(point.mc.position);
                (SPEC.parameterize)(entry, &transformed, dimensions, rules)
            },
            ..r
        },
    ),
    m(
        "normal-is-not-transformed",
        "R-PAR-17",
        "takes the normal in modelling coordinates where world coordinates are asked for",
        "transform the normal first",
        |r| Rules {
            parameterize: |entry, point, dimensions, rules| {
                let mut untransformed = point.clone();
                untransformed.wc.normal = point.mc.normal.or(point.wc.normal);
                (SPEC.parameterize)(entry, &untransformed, dimensions, rules)
            },
            ..r
        },
    ),
    m(
        "normal-in-world-always",
        "R-PAR-15",
        "takes the normal in world coordinates where modelling coordinates are asked for",
        "take the normal as it was specified",
        |r| Rules {
            parameterize: |entry, point, dimensions, rules| {
                let mut transformed = point.clone();
                transformed.mc.normal = point.wc.normal.or(point.mc.normal);
                (SPEC.parameterize)(entry, &transformed, dimensions, rules)
            },
            ..r
        },
    ),
    m(
        "geometric-normal-always",
        "R-PAR-15",
        "takes the computed normal although the vertex has one",
        "take the normal of the vertex where there is one",
        |r| Rules {
            normal: |place| place.geometric_normal.or(place.normal),
            ..r
        },
    ),
    m(
        "geometric-normal-never",
        "R-PAR-16",
        "takes (0, 0, 1) for a vertex without a normal",
        "take the normal of the facet",
        |r| Rules {
            normal: |place| Some(place.normal.unwrap_or([0.0, 0.0, 1.0])),
            ..r
        },
    ),
    m(
        "normals-moved-into-0-1",
        "R-PAR-15",
        "moves normals from −1…1 into 0…1",
        "take the components as they are",
        |r| Rules {
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
        },
    ),
    m(
        "spline-parameters-exchanged",
        "R-PAR-19",
        "exchanges u and v",
        "t0 = u, t1 = v",
        |r| Rules {
            spline_parameters: |point| {
                let [u, v, w] = (SPEC.spline_parameters)(point);
                [v, u, w]
            },
            ..r
        },
    ),
    m(
        "spline-parameters-elsewhere",
        "R-PAR-20",
        "takes vertex coordinates for (u, v) where there is no B-spline surface",
        "set all coordinates to 0",
        |r| Rules {
            spline_parameters: |point| match (&point.spline, point.mc.position) {
                (None, Some(position)) => position,
                _ => (SPEC.spline_parameters)(point),
            },
            ..r
        },
    ),
    m(
        "data-index-ignored",
        "R-PAR-21",
        "takes the first data of a vertex whatever the index",
        "begin with the datum at the floating-point data index",
        |r| Rules {
            float_data: |point, _, dimensions| (SPEC.float_data)(point, 0, dimensions),
            ..r
        },
    ),
    m(
        "data-index-for-all-methods",
        "R-TBL-19",
        "takes data of the vertex wherever the data index is set",
        "let the index count for FloatData only",
        |r| Rules {
            parameterize: |entry, point, dimensions, rules| {
                let mut entry = entry.clone();
                if entry.fp_data_index > 0 && !point.fp_data.is_empty() {
                    entry.parameterization = Parameterization::FloatData;
                }
                (SPEC.parameterize)(&entry, point, dimensions, rules)
            },
            ..r
        },
    ),
    m(
        "data-index-from-one",
        "R-PAR-21",
        "counts data from 1",
        "count them from 0: the fallback index names the first",
        |r| Rules {
            float_data: |point, index, dimensions| {
                (SPEC.float_data)(point, index.saturating_sub(1), dimensions)
            },
            ..r
        },
    ),
    m(
        "data-in-steps-of-the-dimension",
        "R-PAR-21",
        "counts groups of data instead of data",
        "the index counts single values",
        |r| Rules {
            float_data: |point, index, dimensions| {
                (SPEC.float_data)(point, index.saturating_mul(dimensions), dimensions)
            },
            ..r
        },
    ),
    m(
        "same-datum-for-all",
        "R-PAR-22",
        "takes one datum for all coordinates",
        "take the following data for t1 and t2",
        |r| Rules {
            float_data: |point, index, dimensions| {
                let t = (SPEC.float_data)(point, index, dimensions)?;
                Ok([0, 1, 2].map(|c| if c < dimensions { t[0] } else { 0.0 }))
            },
            ..r
        },
    ),
    m(
        "three-data-needed",
        "R-PAR-23",
        "needs three data whatever the map's dimension",
        "take as many as the map has dimensions",
        |r| Rules {
            float_data: |point, index, _| (SPEC.float_data)(point, index, 3),
            ..r
        },
    ),
    m(
        "data-of-two-dimensions",
        "R-PAR-22",
        "takes two data even for a 3D map",
        "take a third one for t2",
        |r| Rules {
            float_data: |point, index, dimensions| {
                (SPEC.float_data)(point, index, dimensions.min(2))
            },
            ..r
        },
    ),
    m(
        "vertex-data-on-splines",
        "R-PAR-24",
        "takes vertex data on a B-spline surface",
        "take the first value of each data spline",
        |r| Rules {
            float_data: |point, index, dimensions| {
                let mut plain = point.clone();
                if !plain.fp_data.is_empty() {
                    plain.spline = None;
                }
                (SPEC.float_data)(&plain, index, dimensions)
            },
            ..r
        },
    ),
    m(
        "one-spline-for-all-coordinates",
        "R-PAR-24",
        "takes all coordinates from one data spline",
        "take the first value of each of as many data splines",
        |r| Rules {
            float_data: |point, index, dimensions| {
                let Some(spline) = &point.spline else {
                    return (SPEC.float_data)(point, index, dimensions);
                };
                let values = spline.data.get(index).cloned().unwrap_or_default();
                let at = |c: usize| values.get(c).copied().unwrap_or_default();
                Ok([0, 1, 2].map(|c| if c < dimensions { at(c) } else { 0.0 }))
            },
            ..r
        },
    ),
    m(
        "reflection-inwards",
        "R-PAR-29",
        "reflects the vector to the eye instead of that from the eye",
        "s = i − 2(n·i)n with i from the eye to the vertex",
        |r| Rules {
            reflect: |i, n| (SPEC.reflect)(i, n).map(|c| -c),
            ..r
        },
    ),
    m(
        "reflection-half",
        "R-PAR-29",
        "subtracts (n·i)n once",
        "subtract it twice",
        |r| Rules {
            reflect: |i, n| {
                let along = dot(n, i);
                [0, 1, 2].map(|c| i[c] - along * n[c])
            },
            ..r
        },
    ),
    m(
        "no-reflection",
        "R-PAR-29",
        "projects the line of sight without reflecting it",
        "reflect it at the normal",
        |r| Rules {
            reflect: |i, _| i,
            ..r
        },
    ),
    m(
        "normal-as-reflection",
        "R-PAR-29",
        "projects the normal",
        "project the reflection vector",
        |r| Rules {
            reflect: |_, n| n,
            ..r
        },
    ),
    m(
        "sight-towards-the-eye",
        "R-PAR-28",
        "takes the vector from the vertex to the eye for the line of sight",
        "take the vector from the eye to the vertex",
        |r| Rules {
            sight: |eye, position| (SPEC.sight)(position, eye),
            ..r
        },
    ),
    m(
        "eye-in-world",
        "R-PAR-30",
        "reflects in world coordinates where view reference coordinates are asked for",
        "transform vertex, normal and eye to VRC first",
        |r| Rules {
            vrc_place: |point| {
                if point.wc.normal.is_some() {
                    point.wc.clone()
                } else {
                    point.vrc.clone()
                }
            },
            ..r
        },
    ),
    m(
        "eye-in-vrc",
        "R-PAR-35",
        "reflects in view reference coordinates where world coordinates are asked for",
        "stay in world coordinates",
        |r| Rules {
            wc_place: |point| {
                if point.vrc.normal.is_some() {
                    point.vrc.clone()
                } else {
                    point.wc.clone()
                }
            },
            ..r
        },
    ),
    m(
        "reflection-matrix-ignored",
        "R-PAR-09",
        "does not apply the reflection matrix",
        "multiply every reflection vector by it",
        |r| Rules {
            turn: |_, s| s,
            ..r
        },
    ),
    m(
        "reflection-matrix-transposed",
        "R-PAR-10",
        "multiplies rows by the reflection matrix",
        "multiply the matrix by a column",
        |r| Rules {
            turn: |matrix, s| [0, 1, 2].map(|c| dot([matrix[0][c], matrix[1][c], matrix[2][c]], s)),
            ..r
        },
    ),
    m(
        "reflection-matrix-moves",
        "R-PAR-10",
        "translates reflection vectors",
        "a direction has w = 0",
        |r| Rules {
            turn: |matrix, s| [0, 1, 2].map(|row| (SPEC.turn)(matrix, s)[row] + matrix[row][3]),
            ..r
        },
    ),
    m(
        "reflection-matrix-for-all-methods",
        "R-TBL-20",
        "applies the reflection matrix to coordinates of every method",
        "apply it to reflection vectors only",
        |r| Rules {
            parameterize: |entry, point, dimensions, rules| {
                let t = (SPEC.parameterize)(entry, point, dimensions, rules)?;
                Ok(match entry.parameterization {
                    Parameterization::ReflectionSphereVRC
                    | Parameterization::ReflectionSphereWC => t,
                    _ => (SPEC.turn)(&entry.reflection_matrix, t),
                })
            },
            ..r
        },
    ),
    m(
        "vector-not-normalized",
        "R-PAR-32",
        "takes y for the height of a vector of any length",
        "normalize the reflection vector first",
        |r| Rules {
            wc_height: |s| (-s[1]).clamp(-1.0, 1.0).acos() / std::f64::consts::PI,
            vrc_height: |s| (-s[1]).clamp(-1.0, 1.0).acos() / std::f64::consts::PI,
            ..r
        },
    ),
    m(
        "vrc-once-around",
        "R-PAR-27",
        "runs once around the VRC sphere, with one seam",
        "run from seam to seam: from −x to +x and again",
        |r| Rules {
            vrc_azimuth: SPEC.wc_azimuth,
            ..r
        },
    ),
    m(
        "wc-twice-around",
        "R-PAR-34",
        "runs twice around the WC sphere",
        "run once around, from the seam at +x",
        |r| Rules {
            wc_azimuth: SPEC.vrc_azimuth,
            ..r
        },
    ),
    m(
        "seam-at-minus-x",
        "R-PAR-34",
        "has the seam of the WC sphere at −x, as atan2 gives it",
        "add a whole turn to negative angles",
        |r| Rules {
            wc_azimuth: |s| ((SPEC.wc_azimuth)(s) + 0.5).fract(),
            ..r
        },
    ),
    m(
        "azimuth-in-radians",
        "R-PAR-34",
        "takes the angle itself for t0",
        "divide it by 2π: coordinates run from 0 to 1",
        |r| Rules {
            wc_azimuth: |s| (SPEC.wc_azimuth)(s) * 2.0 * std::f64::consts::PI,
            ..r
        },
    ),
    m(
        "axis-is-z",
        "R-PAR-33",
        "takes z for the axis of the spheres",
        "revolve around +y",
        |r| Rules {
            wc_azimuth: |s| (SPEC.wc_azimuth)([s[0], s[2], -s[1]]),
            wc_height: |s| (SPEC.wc_height)([s[0], s[2], -s[1]]),
            vrc_azimuth: |s| (SPEC.vrc_azimuth)([s[0], s[2], -s[1]]),
            vrc_height: |s| (SPEC.vrc_height)([s[0], s[2], -s[1]]),
            ..r
        },
    ),
    m(
        "sphere-map-of-opengl",
        "R-PAR-26",
        "projects as OpenGL's sphere map does",
        "project onto a sphere around +y with its seams at ±x",
        |r| Rules {
            vrc_azimuth: |s| opengl(s)[0],
            vrc_height: |s| opengl(s)[1],
            ..r
        },
    ),
    // ---------------------------------------------------------------- orientation, interpolation
    m(
        "orientation-ignored",
        "R-ORI-01",
        "does not apply the orientation matrix",
        "apply it to the coordinates of every method",
        |r| Rules {
            orient: |_, t| t,
            ..r
        },
    ),
    m(
        "orientation-transposed",
        "R-ORI-01",
        "multiplies rows by the orientation matrix",
        "multiply the matrix by a column: translations stand in its last column",
        |r| Rules {
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
        },
    ),
    m(
        "orientation-without-translation",
        "R-ORI-01",
        "does not translate coordinates",
        "coordinates are points: w = 1",
        |r| Rules {
            orient: |matrix, t| (SPEC.turn)(matrix, t),
            ..r
        },
    ),
    m(
        "orientation-of-two-coordinates",
        "R-ORI-01",
        "transforms t0 and t1 only",
        "transform all three coordinates, whatever the map's dimension",
        |r| Rules {
            orient: |matrix, t| {
                let moved = (SPEC.orient)(matrix, [t[0], t[1], 0.0]);
                [moved[0], moved[1], t[2]]
            },
            ..r
        },
    ),
    m(
        "orientation-after-sampling-range",
        "R-ORI-01",
        "folds coordinates into 0…1 before the orientation matrix",
        "transform first; boundary conditions come at the end",
        |r| Rules {
            orient: |matrix, t| (SPEC.orient)(matrix, t.map(|t| t - t.floor())),
            ..r
        },
    ),
    m(
        "no-perspective-correction",
        "R-ORI-04",
        "interpolates linearly although correction Pixel is asked for",
        "interpolate t/w and 1/w, and divide",
        |r| Rules {
            hyperbolic: |ts, b, w| (SPEC.linear)(ts, b, w),
            ..r
        },
    ),
    m(
        "perspective-always",
        "R-ORI-04",
        "corrects for perspective although correction None is asked for",
        "interpolate linearly",
        |r| Rules {
            linear: |ts, b, w| (SPEC.hyperbolic)(ts, b, w),
            ..r
        },
    ),
    m(
        "perspective-inverted",
        "R-ORI-04",
        "multiplies by w where it should divide",
        "interpolate t/w and 1/w, and divide",
        |r| Rules {
            hyperbolic: |ts, b, w| {
                let inverse: Vec<f64> = w.iter().map(|w| 1.0 / w).collect();
                (SPEC.hyperbolic)(ts, b, &inverse)
            },
            ..r
        },
    ),
    m(
        "sampled-per-vertex-always",
        "R-CMP-22",
        "samples at vertices wherever the frequency is InterpDep",
        "follow the interpolation method: facet, vertex, or pixel",
        |r| Rules {
            site: |_, frequency| {
                if frequency == Frequency::Pixel {
                    Site::Pixel
                } else {
                    Site::Vertex
                }
            },
            ..r
        },
    ),
    m(
        "sampled-per-pixel-always",
        "R-CMP-22",
        "samples at every pixel whatever the frequency",
        "with InterpDep sample where the reflectance calculation is done",
        |r| Rules {
            site: |_, _| Site::Pixel,
            ..r
        },
    ),
    m(
        "sample-frequency-overruled",
        "R-CMP-22",
        "follows the interpolation method although frequency Pixel is asked for",
        "sample at every pixel",
        |r| Rules {
            site: |interpolation, _| (SPEC.site)(interpolation, Frequency::InterpDep),
            ..r
        },
    ),
    m(
        "dot-product-per-vertex",
        "R-CMP-22",
        "samples at vertices where dot products are interpolated",
        "sample at every pixel: there the reflectance calculation is done",
        |r| Rules {
            site: |interpolation, frequency| match (interpolation, frequency) {
                (Interpolation::DotProduct, Frequency::InterpDep) => Site::Vertex,
                _ => (SPEC.site)(interpolation, frequency),
            },
            ..r
        },
    ),
    // ---------------------------------------------------------------- stages
    m(
        "order-reversed",
        "R-CMP-05",
        "applies maps in reverse order",
        "feed the output of map i to map i + 1",
        |r| Rules {
            stage: |maps, lit, interpolation, frequency, rules| {
                let reversed: Vec<_> = maps.iter().rev().cloned().collect();
                (SPEC.stage)(&reversed, lit, interpolation, frequency, rules)
            },
            ..r
        },
    ),
    m(
        "only-the-last-map",
        "R-CMP-05",
        "applies the last map only",
        "feed the output of map i to map i + 1",
        |r| Rules {
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
        },
    ),
    m(
        "only-the-first-map",
        "R-CMP-06",
        "applies the first map only",
        "apply all active maps in order",
        |r| Rules {
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
        },
    ),
    m(
        "post-light-before-light",
        "R-RCT-05",
        "applies all maps before the light",
        "apply PostLight maps to the lit color",
        |r| Rules {
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
        },
    ),
    m(
        "pre-light-after-light",
        "R-RCT-04",
        "applies all maps after the light",
        "apply PreLight maps to the color before the reflectance calculation",
        |r| Rules {
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
        },
    ),
    m(
        "list-order-over-stages",
        "R-RCT-01",
        "lets the first map's rendering control decide for all",
        "each entry has its own: PreLight maps first, then light, then PostLight maps",
        |r| Rules {
            stage: |maps, lit, interpolation, frequency, rules| {
                let control = maps
                    .first()
                    .map_or(RenderingControl::PostLight, |(entry, _)| {
                        entry.rendering_control
                    });
                (SPEC.stage)(&all_at(maps, control), lit, interpolation, frequency, rules)
            },
            ..r
        },
    ),
    m(
        "specular-textured",
        "R-CMP-12",
        "multiplies the highlight by the textured color",
        "leave CS alone and add it at the end",
        |r| Rules {
            add_specular: |shade, specular| Shade {
                color: [0, 1, 2].map(|c| shade.color[c] + specular[c] * shade.color[c]),
                ..shade
            },
            ..r
        },
    ),
    m(
        "specular-lost",
        "R-CMP-13",
        "forgets the highlight of textured surfaces",
        "add CS to the textured color",
        |r| Rules {
            add_specular: |shade, _| shade,
            ..r
        },
    ),
    m(
        "white-light-lost",
        "R-CMP-08",
        "takes the texture's color for lit where it is applied to each pixel of a facet or of interpolated colors",
        "multiply what the texture brings in by CW",
        |r| Rules {
            stage: |maps, lit, interpolation, frequency, rules| {
                let split = (rules.is_split)(interpolation, frequency);
                if !split {
                    return (SPEC.stage)(maps, lit, interpolation, frequency, rules);
                }
                unlit(maps, lit, rules)
            },
            ..r
        },
    ),
    m(
        "split-multiplies-twice",
        "R-CMP-20",
        "multiplies the textured color by CW in the split form although it is already lit",
        "add CS only; the light is in CD and CW",
        |r| Rules {
            stage: |maps, lit, interpolation, frequency, rules| {
                let shade = (SPEC.stage)(maps, lit, interpolation, frequency, rules);
                let pre = maps
                    .iter()
                    .any(|(entry, _)| entry.rendering_control == RenderingControl::PreLight);
                if pre && (rules.is_split)(interpolation, frequency) {
                    let textured = [0, 1, 2].map(|c| {
                        (shade.color[c] - lit.specular[c]) * lit.white[c] + lit.specular[c]
                    });
                    return Shade {
                        color: textured,
                        ..shade
                    };
                }
                shade
            },
            ..r
        },
    ),
    m(
        "direct-form-unlit",
        "R-CMP-23",
        "does not light the textured color where normals or dot products are interpolated",
        "apply the reflectance calculation to the textured color",
        |r| Rules {
            light: |shade, lit| (SPEC.add_specular)(shade, lit.specular),
            ..r
        },
    ),
    // ---------------------------------------------------------------- composition
    m(
        "luminance-is-red",
        "R-CMP-14",
        "takes luminance for red, and nothing for green and blue",
        "take it for all three",
        |r| Rules {
            texel_color: |texel| match texel.luminance() {
                Some(luminance) => [luminance, 0.0, 0.0],
                None => (SPEC.texel_color)(texel),
            },
            ..r
        },
    ),
    m(
        "premultiplied",
        "R-CMP-15",
        "multiplies a texel's color by its alpha",
        "take the color as it is",
        |r| Rules {
            texel_color: |texel| {
                (SPEC.texel_color)(texel).map(|c| c * texel.alpha().unwrap_or(1.0))
            },
            ..r
        },
    ),
    m(
        "replace-modulates",
        "R-CMP-30",
        "multiplies where it should replace",
        "Replace takes no account of the primitive's color",
        |r| Rules {
            replace: |x| Shade {
                alpha: x.alpha.unwrap_or(x.input.alpha),
                ..(SPEC.modulate)(x)
            },
            ..r
        },
    ),
    m(
        "replace-keeps-alpha",
        "R-CMP-31",
        "keeps the primitive's alpha although the texel has one",
        "replace alpha too",
        |r| Rules {
            replace: |x| Shade {
                alpha: x.input.alpha,
                ..(SPEC.replace)(x)
            },
            ..r
        },
    ),
    m(
        "replace-makes-opaque",
        "R-CMP-30",
        "makes a primitive opaque where the texel has no alpha",
        "keep the primitive's alpha",
        |r| Rules {
            replace: |x| Shade {
                alpha: x.alpha.unwrap_or(1.0),
                ..(SPEC.replace)(x)
            },
            ..r
        },
    ),
    m(
        "replace-multiplies-alpha",
        "R-CMP-31",
        "multiplies alphas where it should replace",
        "take the texel's alpha",
        |r| Rules {
            replace: |x| Shade {
                alpha: x.input.alpha * x.alpha.unwrap_or(1.0),
                ..(SPEC.replace)(x)
            },
            ..r
        },
    ),
    m(
        "replace-unlit",
        "R-CMP-30",
        "does not light a replacing color in the split form",
        "multiply it by CW",
        |r| Rules {
            replace: |x| Shade {
                color: x.color,
                ..(SPEC.replace)(x)
            },
            ..r
        },
    ),
    m(
        "modulate-keeps-alpha",
        "R-CMP-33",
        "multiplies colors but not alphas",
        "multiply alphas too, where the texel has one",
        |r| Rules {
            modulate: |x| Shade {
                alpha: x.input.alpha,
                ..(SPEC.modulate)(x)
            },
            ..r
        },
    ),
    m(
        "modulate-replaces-alpha",
        "R-CMP-33",
        "takes the texel's alpha when it modulates",
        "multiply alphas",
        |r| Rules {
            modulate: |x| Shade {
                alpha: x.alpha.unwrap_or(x.input.alpha),
                ..(SPEC.modulate)(x)
            },
            ..r
        },
    ),
    m(
        "modulate-doubles",
        "R-CMP-32",
        "doubles the product, as later hardware does",
        "multiply once",
        |r| Rules {
            modulate: |x| Shade {
                color: (SPEC.modulate)(x).color.map(|c| 2.0 * c),
                ..(SPEC.modulate)(x)
            },
            ..r
        },
    ),
    m(
        "modulate-adds",
        "R-CMP-32",
        "adds colors where it should multiply",
        "multiply them",
        |r| Rules {
            modulate: |x| Shade {
                color: [0, 1, 2].map(|c| x.input.color[c] + x.color[c]),
                ..(SPEC.modulate)(x)
            },
            ..r
        },
    ),
    m(
        "modulate-lit-twice",
        "R-CMP-32",
        "multiplies by CW when it modulates in the split form",
        "CD is lit already: CD·T",
        |r| Rules {
            modulate: |x| Shade {
                color: times(x.white, (SPEC.modulate)(x).color),
                ..(SPEC.modulate)(x)
            },
            ..r
        },
    ),
    m(
        "blend-the-other-way",
        "R-CMP-34",
        "shows the environment color where the texel is dark",
        "(1 − Γ)·C + Γ·E",
        |r| Rules {
            blend_env_color: |x| {
                (SPEC.blend_env_color)(&crate::texture::compose::Terms {
                    gamma: x.gamma.map(|g| 1.0 - g),
                    ..*x
                })
            },
            ..r
        },
    ),
    m(
        "blend-adds",
        "R-CMP-34",
        "adds the environment color without taking from the primitive's",
        "(1 − Γ)·C + Γ·E",
        |r| Rules {
            blend_env_color: |x| {
                let environment = times(x.white, x.entry.env_color);
                let color = [0, 1, 2].map(|c| x.input.color[c] + x.gamma[c] * environment[c]);
                Shade {
                    color,
                    ..(SPEC.blend_env_color)(x)
                }
            },
            ..r
        },
    ),
    m(
        "blend-with-the-texel",
        "R-CMP-16",
        "blends in the texel's color instead of the environment color",
        "the texel says how much; the environment color is what is blended in",
        |r| Rules {
            blend_env_color: |x| Shade {
                color: mix(x.input.color, times(x.white, x.color), x.gamma),
                ..(SPEC.blend_env_color)(x)
            },
            ..r
        },
    ),
    m(
        "blend-environment-unlit",
        "R-CMP-34",
        "does not light the environment color in the split form",
        "multiply it by CW",
        |r| Rules {
            blend_env_color: |x| Shade {
                color: mix(x.input.color, x.entry.env_color, x.gamma),
                ..(SPEC.blend_env_color)(x)
            },
            ..r
        },
    ),
    m(
        "blend-keeps-alpha",
        "R-CMP-35",
        "leaves alpha alone when it blends with a texel that has alpha",
        "multiply alphas",
        |r| Rules {
            blend_env_color: |x| Shade {
                alpha: x.input.alpha,
                ..(SPEC.blend_env_color)(x)
            },
            ..r
        },
    ),
    m(
        "background-for-environment",
        "R-CMP-16",
        "blends in the background color",
        "take the environment color of the entry",
        |r| Rules {
            blend_env_color: |x| Shade {
                color: mix(
                    x.input.color,
                    times(x.white, x.entry.background_color),
                    x.gamma,
                ),
                ..(SPEC.blend_env_color)(x)
            },
            ..r
        },
    ),
    m(
        "channel-ignored",
        "R-CHN-02",
        "blends by red whatever the channel selector",
        "take the selected channel",
        |r| Rules {
            gamma: |_, texel| [(SPEC.texel_color)(texel)[0]; 3],
            ..r
        },
    ),
    m(
        "channels-from-blue",
        "R-CHN-01",
        "counts channels from blue",
        "red is channel 0, green 1, blue 2",
        |r| Rules {
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
        },
    ),
    m(
        "channels-from-alpha",
        "R-CHN-04",
        "counts channels from alpha",
        "alpha is channel 3",
        |r| Rules {
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
        },
    ),
    m(
        "gray-of-the-texel",
        "R-CMP-18",
        "blends by the mean of red, green and blue",
        "blend by the selected channel",
        |r| Rules {
            gamma: |_, texel| [(SPEC.texel_color)(texel).iter().sum::<f64>() / 3.0; 3],
            ..r
        },
    ),
    m(
        "luminance-alpha-selected",
        "R-CMP-18",
        "blends a luminance texel by its alpha if the selector says so",
        "texels of luminance blend by luminance",
        |r| Rules {
            gamma: |entry, texel| match (entry.channel, texel.luminance(), texel.alpha()) {
                (Channel::Alpha, Some(_), Some(alpha)) => [alpha; 3],
                _ => (SPEC.gamma)(entry, texel),
            },
            ..r
        },
    ),
    m(
        "decal-the-other-way",
        "R-CMP-37",
        "shows the primitive where the texel is opaque",
        "(1 − AT)·C + AT·T",
        |r| Rules {
            decal: |x| match x.alpha {
                Some(alpha) => Shade {
                    color: mix(x.input.color, times(x.white, x.color), [1.0 - alpha; 3]),
                    ..x.input
                },
                None => (SPEC.decal)(x),
            },
            ..r
        },
    ),
    m(
        "decal-by-primitive-alpha",
        "R-CMP-37",
        "blends by the primitive's alpha",
        "blend by the texel's",
        |r| Rules {
            decal: |x| Shade {
                color: mix(x.input.color, times(x.white, x.color), [x.input.alpha; 3]),
                ..x.input
            },
            ..r
        },
    ),
    m(
        "decal-replaces-alpha",
        "R-CMP-37",
        "takes the texel's alpha for a decal",
        "leave the primitive's alpha unchanged",
        |r| Rules {
            decal: |x| Shade {
                alpha: x.alpha.unwrap_or(x.input.alpha),
                ..(SPEC.decal)(x)
            },
            ..r
        },
    ),
    m(
        "decal-multiplies-alpha",
        "R-CMP-37",
        "multiplies alphas for a decal",
        "leave the primitive's alpha unchanged",
        |r| Rules {
            decal: |x| Shade {
                alpha: x.input.alpha * x.alpha.unwrap_or(1.0),
                ..(SPEC.decal)(x)
            },
            ..r
        },
    ),
    m(
        "decal-without-alpha-is-nothing",
        "R-CMP-36",
        "leaves the primitive where a decal has no alpha",
        "without alpha the texture replaces the color",
        |r| Rules {
            decal: |x| {
                if x.alpha.is_none() {
                    x.input
                } else {
                    (SPEC.decal)(x)
                }
            },
            ..r
        },
    ),
    m(
        "decal-by-channel",
        "R-CMP-19",
        "blends a decal by the selected channel, as the list of symbols has it",
        "blend it by the texel's alpha",
        |r| Rules {
            decal: |x| Shade {
                color: mix(x.input.color, times(x.white, x.color), x.gamma),
                ..x.input
            },
            ..r
        },
    ),
    m(
        "decal-unlit",
        "R-CMP-37",
        "does not light a decal in the split form",
        "multiply the texel's color by CW",
        |r| Rules {
            decal: |x| Shade {
                color: mix(x.input.color, x.color, [x.alpha.unwrap_or(1.0); 3]),
                ..x.input
            },
            ..r
        },
    ),
    m(
        "background-is-primitive",
        "R-CMP-39",
        "blends over the primitive's color instead of the background color",
        "blend over the background color of the entry",
        |r| Rules {
            decal_background: |x| (SPEC.decal)(x),
            ..r
        },
    ),
    m(
        "environment-for-background",
        "R-CMP-17",
        "blends over the environment color",
        "take the background color of the entry",
        |r| Rules {
            decal_background: |x| Shade {
                color: times(
                    x.white,
                    mix(x.entry.env_color, x.color, [x.alpha.unwrap_or(1.0); 3]),
                ),
                ..x.input
            },
            ..r
        },
    ),
    m(
        "background-unlit",
        "R-CMP-39",
        "does not light the background color in the split form",
        "multiply the whole blend by CW",
        |r| Rules {
            decal_background: |x| Shade {
                color: mix(
                    x.entry.background_color,
                    times(x.white, x.color),
                    [x.alpha.unwrap_or(1.0); 3],
                ),
                ..x.input
            },
            ..r
        },
    ),
    m(
        "background-replaces-alpha",
        "R-CMP-39",
        "takes the texel's alpha for a decal over the background",
        "leave the primitive's alpha unchanged",
        |r| Rules {
            decal_background: |x| Shade {
                alpha: x.alpha.unwrap_or(x.input.alpha),
                ..(SPEC.decal_background)(x)
            },
            ..r
        },
    ),
    m(
        "background-without-alpha",
        "R-CMP-38",
        "shows the background color where a decal over it has no alpha",
        "without alpha the texture replaces the color",
        |r| Rules {
            decal_background: |x| match x.alpha {
                Some(_) => (SPEC.decal_background)(x),
                None => Shade {
                    color: times(x.white, x.entry.background_color),
                    ..x.input
                },
            },
            ..r
        },
    ),
    m(
        "background-the-other-way",
        "R-CMP-39",
        "shows the background where the texel is opaque",
        "(1 − AT)·B + AT·T",
        |r| Rules {
            decal_background: |x| match x.alpha {
                Some(alpha) => Shade {
                    color: times(x.white, mix(x.color, x.entry.background_color, [alpha; 3])),
                    ..x.input
                },
                None => (SPEC.decal_background)(x),
            },
            ..r
        },
    ),
    // ---------------------------------------------------------------- sampling
    m(
        "minification-always",
        "R-SMP-03",
        "samples by the minification method where the map is enlarged",
        "take the magnification method",
        |r| Rules {
            method: |entry, _| entry.min_sample,
            ..r
        },
    ),
    m(
        "methods-exchanged",
        "R-SMP-02",
        "samples by the magnification method where the map is shrunk",
        "take the minification method where a pixel covers more than a texel",
        |r| Rules {
            method: |entry, magnify| (SPEC.method)(entry, !magnify),
            ..r
        },
    ),
    m(
        "texels-column-first",
        "R-SMP-04",
        "takes texels column by column",
        "t0 runs fastest, then t1, then t2",
        |r| Rules {
            place: |size, at| (at[0] * size[1] + at[1]) * size[2] + at[2],
            ..r
        },
    ),
    m(
        "first-row-at-the-top",
        "R-SMP-04",
        "takes the first row for the top",
        "t0 = t1 = 0 is the first texel, at the lower left",
        |r| Rules {
            place: |size, at| (SPEC.place)(size, [at[0], size[1] - 1 - at[1], at[2]]),
            ..r
        },
    ),
    m(
        "slices-ignored",
        "R-PAR-03",
        "samples 3D maps by two coordinates",
        "one coordinate for each dimension",
        |r| Rules {
            place: |size, at| (SPEC.place)(size, [at[0], at[1], 0]),
            ..r
        },
    ),
    m(
        "coordinates-in-texels",
        "R-PAR-04",
        "counts coordinates in texels",
        "0 to 1 spans the map",
        |r| Rules {
            closest: |boundary, t, size, rules| {
                (SPEC.closest)(boundary, t / size as f64, size, rules)
            },
            ..r
        },
    ),
    m(
        "closest-rounds",
        "R-SMP-04",
        "rounds t·N to the nearest number",
        "take ⌊t·N⌋: texel k covers k/N to (k + 1)/N",
        |r| Rules {
            closest: |boundary, t, size, rules| {
                (SPEC.closest)(boundary, t + 0.5 / size as f64, size, rules)
            },
            ..r
        },
    ),
    m(
        "weighted-is-single",
        "R-SMP-05",
        "takes the closest texel where a weighted average is asked for",
        "average the closest 2ⁿ texels",
        |r| Rules {
            neighbours: |boundary, t, size, rules| {
                [((rules.closest)(boundary, t, size, rules), 1.0), (0, 0.0)]
            },
            ..r
        },
    ),
    m(
        "weighted-half-off",
        "R-SMP-05",
        "weights from the edges of texels and not from their middles",
        "measure from (k + ½)/N",
        |r| Rules {
            neighbours: |boundary, t, size, rules| {
                (SPEC.neighbours)(boundary, t + 0.5 / size as f64, size, rules)
            },
            ..r
        },
    ),
    m(
        "weights-exchanged",
        "R-SMP-05",
        "gives the farther texel the larger weight",
        "the nearer texel weighs more",
        |r| Rules {
            neighbours: |boundary, t, size, rules| {
                let [(a, wa), (b, wb)] = (SPEC.neighbours)(boundary, t, size, rules);
                [(a, wb), (b, wa)]
            },
            ..r
        },
    ),
    m(
        "weights-equal",
        "R-SMP-05",
        "gives all texels the same weight",
        "weight them by how near they are",
        |r| Rules {
            neighbours: |boundary, t, size, rules| {
                (SPEC.neighbours)(boundary, t, size, rules).map(|(at, _)| (at, 0.5))
            },
            ..r
        },
    ),
    m(
        "weights-smoothed",
        "R-SMP-05",
        "bends the weights by 3f² − 2f³",
        "weight linearly",
        |r| Rules {
            neighbours: |boundary, t, size, rules| {
                let [(a, _), (b, f)] = (SPEC.neighbours)(boundary, t, size, rules);
                let smooth = f * f * (3.0 - 2.0 * f);
                [(a, 1.0 - smooth), (b, smooth)]
            },
            ..r
        },
    ),
    m(
        "level-rounded-down",
        "R-SMP-06",
        "takes the level below the depth",
        "take the closest level",
        |r| Rules {
            closest_level: |depth, top| (depth.floor().max(0.0) as usize).min(top),
            ..r
        },
    ),
    m(
        "level-rounded-up",
        "R-SMP-06",
        "takes the level above the depth",
        "take the closest level",
        |r| Rules {
            closest_level: |depth, top| (depth.ceil().max(0.0) as usize).min(top),
            ..r
        },
    ),
    m(
        "levels-from-the-pinnacle",
        "R-SMP-06",
        "counts levels from the pinnacle",
        "depth 0 is the base",
        |r| Rules {
            closest_level: |depth, top| (SPEC.closest_level)(top as f64 - depth, top),
            levels: |depth, top| (SPEC.levels)(top as f64 - depth, top),
            ..r
        },
    ),
    m(
        "levels-ignored",
        "R-SMP-06",
        "samples the base whatever the depth",
        "choose the level by the depth",
        |r| Rules {
            closest_level: |_, _| 0,
            levels: |_, _| (0, 0, 0.0),
            ..r
        },
    ),
    m(
        "between-is-closest",
        "R-SMP-08",
        "takes the closest level where an interpolation of two is asked for",
        "interpolate the two closest levels at the exact depth",
        |r| Rules {
            levels: |depth, top| ((SPEC.closest_level)(depth, top), 0, 0.0),
            ..r
        },
    ),
    m(
        "between-is-the-mean",
        "R-SMP-08",
        "takes the mean of two levels whatever the depth",
        "interpolate at the exact depth",
        |r| Rules {
            levels: |depth, top| {
                let (lower, upper, share) = (SPEC.levels)(depth, top);
                (lower, upper, if share > 0.0 { 0.5 } else { 0.0 })
            },
            ..r
        },
    ),
    m(
        "between-the-other-way",
        "R-SMP-08",
        "gives the farther level the larger weight",
        "the nearer level weighs more",
        |r| Rules {
            levels: |depth, top| {
                let (lower, upper, share) = (SPEC.levels)(depth, top);
                (lower, upper, if share > 0.0 { 1.0 - share } else { 0.0 })
            },
            ..r
        },
    ),
    m(
        "depth-extrapolated",
        "R-SMP-09",
        "goes on interpolating beyond the ends of the levels",
        "beyond an end use that level alone",
        |r| Rules {
            levels: |depth, top| {
                let lower = (depth.floor().max(0.0) as usize).min(top.saturating_sub(1));
                (lower, (lower + 1).min(top), depth - lower as f64)
            },
            ..r
        },
    ),
    m(
        "depth-wraps",
        "R-SMP-09",
        "falls back to the base beyond the pinnacle",
        "use the pinnacle",
        |r| Rules {
            levels: |depth, top| {
                if depth > top as f64 {
                    (0, 0, 0.0)
                } else {
                    (SPEC.levels)(depth, top)
                }
            },
            ..r
        },
    ),
    // ---------------------------------------------------------------- boundaries
    m(
        "wrap-in-c",
        "R-BND-05",
        "takes the remainder with the sign of the coordinate",
        "wrap to a number from 0 to N − 1",
        |r| Rules {
            wrap: |k, size| (k % size as i64).unsigned_abs() as usize,
            ..r
        },
    ),
    m(
        "wrap-truncates",
        "R-BND-05",
        "cuts off negative coordinates towards 0 before it wraps",
        "take the floor of t·N",
        |r| Rules {
            closest: |boundary, t, size, rules| {
                let t = if boundary == Boundary::Wrap && t < 0.0 {
                    t + 1.0 / size as f64
                } else {
                    t
                };
                (SPEC.closest)(boundary, t, size, rules)
            },
            ..r
        },
    ),
    m(
        "wrap-loses-the-last-texel",
        "R-BND-05",
        "wraps after N − 1 texels",
        "the period is N texels",
        |r| Rules {
            wrap: |k, size| {
                if (0..size as i64).contains(&k) {
                    k as usize
                } else {
                    k.rem_euclid((size as i64 - 1).max(1)) as usize
                }
            },
            ..r
        },
    ),
    m(
        "wrap-clamps-neighbours",
        "R-BND-05",
        "repeats the edge texel when it averages at an edge of a wrapped map",
        "take the texel of the opposite edge",
        |r| Rules {
            neighbours: |boundary, t, size, rules| {
                let boundary = if boundary == Boundary::Wrap && (0.0..=1.0).contains(&t) {
                    Boundary::ClampBorder
                } else {
                    boundary
                };
                (SPEC.neighbours)(boundary, t, size, rules)
            },
            ..r
        },
    ),
    m(
        "mirror-wraps",
        "R-BND-06",
        "wraps where it should mirror",
        "reverse every other tile",
        |r| Rules {
            mirror: SPEC.wrap,
            ..r
        },
    ),
    m(
        "mirror-once",
        "R-BND-06",
        "mirrors once and then clamps",
        "go on: the period is 2",
        |r| Rules {
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
        },
    ),
    m(
        "mirror-without-the-edge",
        "R-BND-06",
        "does not repeat the edge texel",
        "the mirror stands at the edge of the map: the edge texel comes twice",
        |r| Rules {
            mirror: |k, size| {
                let period = (2 * (size as i64 - 1)).max(1);
                let m = k.rem_euclid(period);
                m.min(period - m).min(size as i64 - 1) as usize
            },
            ..r
        },
    ),
    m(
        "mirror-of-the-first-tile",
        "R-BND-06",
        "reverses the tiles with even numbers",
        "the map itself is not reversed",
        |r| Rules {
            mirror: |k, size| size - 1 - (SPEC.mirror)(k, size),
            ..r
        },
    ),
    m(
        "border-wraps",
        "R-BND-04",
        "wraps where it should clamp to the border",
        "take the closest texel",
        |r| Rules {
            border: SPEC.wrap,
            ..r
        },
    ),
    m(
        "border-is-black",
        "R-BND-04",
        "does not texture beyond a border that clamps",
        "take the closest texel",
        |r| Rules {
            is_clamped: |entry, t, dimensions, rules| {
                (SPEC.is_clamped)(entry, t, dimensions, rules)
                    || (0..dimensions).any(|d| {
                        entry.boundary[d] == Boundary::ClampBorder && (rules.is_outside)(t[d])
                    })
            },
            ..r
        },
    ),
    m(
        "border-of-the-first-texel",
        "R-BND-04",
        "takes the first texel on both sides",
        "take the closest texel",
        |r| Rules {
            border: |k, size| {
                if (0..size as i64).contains(&k) {
                    k as usize
                } else {
                    0
                }
            },
            ..r
        },
    ),
    m(
        "explicit-is-border",
        "R-BND-03",
        "clamps to the border where the clamp method should decide",
        "do what the clamp method says",
        |r| Rules {
            is_clamped: |_, _, _, _| false,
            ..r
        },
    ),
    m(
        "one-is-outside",
        "R-BND-01",
        "takes coordinate 1 for outside",
        "both ends of 0…1 are inside",
        |r| Rules {
            is_outside: |t| !(0.0..1.0).contains(&t),
            ..r
        },
    ),
    m(
        "zero-is-outside",
        "R-BND-01",
        "takes coordinate 0 for outside",
        "both ends of 0…1 are inside",
        |r| Rules {
            is_outside: |t| !(t > 0.0 && t <= 1.0),
            ..r
        },
    ),
    m(
        "only-beyond-one-is-outside",
        "R-BND-01",
        "does not take negative coordinates for outside",
        "outside is on both sides",
        |r| Rules {
            is_outside: |t| t > 1.0,
            ..r
        },
    ),
    m(
        "all-directions-must-be-outside",
        "R-CLM-02",
        "lets the clamp method decide only where every direction is outside",
        "one direction with an explicit clamp outside is enough",
        |r| Rules {
            is_clamped: |entry, t, dimensions, rules| {
                (0..dimensions).all(|d| (rules.is_outside)(t[d]))
                    && (SPEC.is_clamped)(entry, t, dimensions, rules)
            },
            ..r
        },
    ),
    m(
        "any-outside-clamps",
        "R-BND-02",
        "lets the clamp method decide wherever any direction is outside",
        "only directions with an explicit clamp count",
        |r| Rules {
            is_clamped: |entry, t, dimensions, rules| {
                let explicit =
                    (0..dimensions).any(|d| entry.boundary[d] == Boundary::ClampExplicit);
                explicit && (0..dimensions).any(|d| (rules.is_outside)(t[d]))
            },
            ..r
        },
    ),
    m(
        "t2-clamps-a-picture",
        "R-BND-02",
        "looks at the boundary of t2 on a 2D map",
        "a map has boundaries in its own directions only",
        |r| Rules {
            is_clamped: |entry, t, _, rules| (SPEC.is_clamped)(entry, t, 3, rules),
            ..r
        },
    ),
    m(
        "one-condition-for-all",
        "R-BND-02",
        "uses the boundary condition of t0 for all directions",
        "each direction has its own",
        |r| Rules {
            condition: |entry, _| entry.boundary[0],
            ..r
        },
    ),
    m(
        "discontinue-is-black",
        "R-CLM-03",
        "applies black where it should not texture",
        "leave the primitive as it was before this map",
        |r| Rules {
            clamp: |entry| match (SPEC.clamp)(entry) {
                Fetched::Discontinued => Fetched::Texel(Texel::rgb([0.0; 3])),
                other => other,
            },
            ..r
        },
    ),
    m(
        "clamp-color-ignored",
        "R-CLM-04",
        "does not texture where the clamp color should be applied",
        "apply the clamp color",
        |r| Rules {
            clamp: |_| Fetched::Discontinued,
            ..r
        },
    ),
    m(
        "clamp-color-is-background",
        "R-CLM-04",
        "applies the background color where the clamp color should be",
        "apply the clamp color",
        |r| Rules {
            clamp: |entry| {
                (SPEC.clamp)(&Entry {
                    clamp_color: entry.background_color,
                    ..entry.clone()
                })
            },
            ..r
        },
    ),
    m(
        "clamp-color-always",
        "R-CLM-01",
        "applies the clamp color although the method says Discontinue",
        "look at the clamp method",
        |r| Rules {
            clamp: |entry| Fetched::Clamped(Texel::rgb(entry.clamp_color)),
            ..r
        },
    ),
    // ---------------------------------------------------------------- a PTM as a map
    m(
        "ptm-top-row-first",
        "R-SMP-04",
        "takes the top row of a PTM for t1 = 0",
        "t1 = 0 is the bottom row, which a PTM stores first",
        |r| Rules {
            rows: |picture| {
                picture
                    .values
                    .chunks_exact(3)
                    .map(|c| [c[0], c[1], c[2]])
                    .collect()
            },
            ..r
        },
    ),
    m(
        "ptm-mirrored",
        "R-SMP-04",
        "takes the right column of a PTM for t0 = 0",
        "t0 = 0 is the left column",
        |r| Rules {
            rows: |picture| {
                let width = picture.size.width as usize;
                (SPEC.rows)(picture)
                    .chunks_exact(width)
                    .flat_map(|row| row.iter().rev().copied())
                    .collect()
            },
            ..r
        },
    ),
    m(
        "ptm-blue-first",
        "R-CMP-14",
        "takes a PTM's colors in the order blue, green, red",
        "take them as red, green, blue",
        |r| Rules {
            rows: |picture| {
                (SPEC.rows)(picture)
                    .into_iter()
                    .map(|[r, g, b]| [b, g, r])
                    .collect()
            },
            ..r
        },
    ),
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
fn opengl(s: [f64; 3]) -> [f64; 2] {
    let l = length(s);
    let [x, y, z] = s.map(|c| c / l);
    let m = 2.0 * (x * x + y * y + (z + 1.0) * (z + 1.0)).sqrt();
    if m == 0.0 {
        return [0.5, 0.5];
    }
    [x / m + 0.5, y / m + 0.5]
}
