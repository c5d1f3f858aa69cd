//! Questions about a texture stage, and the reference's answers.
//!
//! A question is `{"op": …, "given": {…}}`. Each op is one step of the pipeline, or the whole pipeline (`stage`). A missing field
//! of an entry has its fallback value. Enumerants are written as in the chapter, but without their prefixes.

use std::collections::BTreeMap;
use std::sync::Arc;

use data_encoding::HEXLOWER_PERMISSIVE;
use serde::Deserialize;
use serde::de::Error as _;
use serde_json::{Map, Value, json};

use crate::error::{Error, Result};
use crate::protocol::frame::{EXIT_MALFORMED, EXIT_UNSUPPORTED};
use ptm_texture::{
    Boundary, Color, Correction, Entry, Footprint, Frequency, Interpolation, Level, LitPrimitive,
    MapValue, Matrix, NoValue, Point, Rounding, Rules, Selection, Shade, SplinePoint, Surface,
    Texel, TexelKind, TextureMap, Tolerance, ToleratedSample, Vector, VertexData,
};

/// A question for a texture stage.
#[derive(Clone, Debug)]
pub struct Question(Arc<TextureStep>);

/// Reason why a question has no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The input is not a question, or the question is outside the valid range; exit status 65.
    Malformed(String),
    /// The question needs something that the reference does not support; exit status 69.
    Unsupported(String),
}

impl Refusal {
    /// Returns the exit status, 65 or 69, and the reason as a sentence.
    #[must_use]
    pub fn status_and_reason(&self) -> (i32, &str) {
        match self {
            Refusal::Malformed(reason) => (EXIT_MALFORMED, reason),
            Refusal::Unsupported(reason) => (EXIT_UNSUPPORTED, reason),
        }
    }
}

/// Names of the steps, in the order of the pipeline.
pub const OPERATIONS: &str = "defaults select resolve parameterize reflect orient interpolate sites depth index sample \
    compose stage";

impl Question {
    /// Parses a question from the bytes of a file.
    ///
    /// # Errors
    /// Returns [`Refusal::Unsupported`] for an unknown op, and [`Refusal::Malformed`] for all other errors.
    pub fn read(file: &[u8]) -> Result<Question, Refusal> {
        let value: Value =
            serde_json::from_slice(file).map_err(|error| Refusal::Malformed(error.to_string()))?;
        Question::from_value(&value)
    }

    /// Parses a question from its JSON value.
    ///
    /// # Errors
    /// Returns the errors of [`Question::read`].
    pub fn from_value(value: &Value) -> Result<Question, Refusal> {
        let op = value["op"].as_str();
        let op = op.ok_or_else(|| malformed("a question must have an op"))?;
        if OPERATIONS.split(' ').all(|known| known != op) {
            return Err(Refusal::Unsupported(format!("unknown op {op:?}")));
        }
        let step = match value.get("given") {
            Some(given) => serde_json::from_value(json!({ op: given })),
            None => Err(serde_json::Error::missing_field("given")),
        };
        let step = step.map_err(|error| malformed(format!("{op}: {error}")))?;
        Ok(Question(Arc::new(step)))
    }

    /// Computes the answer, a JSON object, under `rules`.
    ///
    /// # Errors
    /// Returns an error if the question is malformed or not supported.
    pub fn answer(&self, rules: &Rules) -> Result<Value, Refusal> {
        let answer = self.answer_with_tolerance(rules)?;
        Ok(answer.answer)
    }

    /// Computes the answer under `rules`, and how far the numbers of another correct answer may be from it.
    ///
    /// # Errors
    /// Returns an error if the question is malformed or not supported.
    pub fn answer_with_tolerance(&self, rules: &Rules) -> Result<ToleratedAnswer, Refusal> {
        let answer = self.0.answer(rules);
        answer.or_else(|Unanswered(result)| result.map(ToleratedAnswer::exact))
    }
}

/// Answer to a question with its tolerance.
#[derive(Clone, Debug, PartialEq)]
pub struct ToleratedAnswer {
    /// Exact answer, a JSON object.
    pub answer: Value,
    /// Allowed deviation of each number (ruling `filter-precision`), in addition to the tolerance for arithmetic. It has the shape
    /// of the answer; fields without a tolerance are missing.
    pub tolerance: Value,
}

impl ToleratedAnswer {
    fn exact(answer: Value) -> ToleratedAnswer {
        let tolerance = json!({});
        ToleratedAnswer { answer, tolerance }
    }
}

/// Result of a step that has no value: a refusal, or the ruling that leaves the value to the implementation.
struct Unanswered(Result<Value, Refusal>);

impl From<Refusal> for Unanswered {
    fn from(refusal: Refusal) -> Unanswered {
        Unanswered(Err(refusal))
    }
}

impl From<NoValue> for Unanswered {
    fn from(reason: NoValue) -> Unanswered {
        Unanswered(match reason {
            NoValue::ImplementationDefined(ruling) => Ok(json!({ "impl_defined": ruling })),
            other => Err(malformed(other.to_string())),
        })
    }
}

fn malformed(message: impl Into<String>) -> Refusal {
    Refusal::Malformed(message.into())
}

/// A step of the pipeline with its arguments: the `op` and the `given` of a question.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
enum TextureStep {
    /// Returns the fallback values.
    Defaults {},
    /// Selects entries for a facet.
    Select(Surface),
    /// Looks up an index in a table.
    Resolve {
        #[serde(default)]
        table: BTreeMap<i64, GivenEntry>,
        index: i64,
    },
    /// Derives 1, 2 or 3 coordinates from a point.
    Parameterize {
        #[serde(default)]
        entry: GivenEntry,
        #[serde(default)]
        point: GivenPoint,
        #[serde(default = "two")]
        dim: usize,
    },
    /// Reflects a unit vector from the eye about a normal.
    Reflect { i: Vector, n: Vector },
    /// Transforms coordinates with a matrix of four rows.
    Orient { matrix: Matrix, t: Vector },
    /// Interpolates between the corners of a facet.
    Interpolate {
        /// One to three coordinates for each corner.
        ts: Vec<Vec<f64>>,
        /// The screen-space weight of each corner.
        b: Vec<f64>,
        /// The w of each corner; 1 by default.
        w: Option<Vec<f64>>,
        correction: Correction,
    },
    /// Returns the site at which a texture is sampled.
    Sites {
        interp: Interpolation,
        frequency: Frequency,
    },
    /// Returns the depth at which a map is sampled for a footprint.
    Depth {
        /// Number of texels in each direction of the base level.
        size: Vec<usize>,
        /// The change in the coordinates from a pixel to its right neighbor.
        dtdx: Vec<f64>,
        /// The change in the coordinates from a pixel to the pixel above.
        dtdy: Vec<f64>,
        /// The depth sampling bias hint.
        #[serde(default)]
        bias: f64,
        /// The frequency hints.
        #[serde(default)]
        freq: Vec<f64>,
    },
    /// Returns the indices of the texels at the given coordinates along one direction.
    Index {
        boundary: Boundary,
        size: usize,
        t: Vec<f64>,
    },
    /// Samples a map.
    Sample {
        map: GivenMap,
        t: Vector,
        /// The sample depth.
        #[serde(default)]
        depth: f64,
        /// True if the map is magnified.
        #[serde(default, rename = "mag")]
        is_magnified: bool,
        #[serde(default)]
        entry: GivenEntry,
    },
    /// Applies one map to the color of a primitive.
    Compose {
        #[serde(default)]
        entry: GivenEntry,
        texel: GivenTexel,
        /// The color of the primitive. In the split form, this is the color after lighting.
        color: Color,
        #[serde(default = "opaque")]
        alpha: f64,
        /// The lit color of a white primitive; present only in the split form.
        #[serde(default = "white")]
        cw: Color,
    },
    /// Applies all maps of a primitive, in order.
    Stage {
        surface: GivenSurface,
        interp: Option<Interpolation>,
        frequency: Option<Frequency>,
        entries: Vec<StageEntry>,
    },
}

impl TextureStep {
    fn answer(&self, rules: &Rules) -> Result<ToleratedAnswer, Unanswered> {
        Ok(ToleratedAnswer::exact(match self {
            TextureStep::Defaults {} => entry_json(&(rules.fallback_values)()),
            TextureStep::Select(surface) => match ptm_texture::select(surface, rules) {
                Selection::Untextured => json!({ "entries": "untextured" }),
                Selection::Default => json!({ "entries": ["default"] }),
                Selection::Entries(entries) => json!({ "entries": entries }),
            },
            TextureStep::Resolve { table, index } => {
                let table = table.iter().map(|(&i, given)| (i, given.entry(rules)));
                entry_json(&ptm_texture::resolve(&table.collect(), *index, rules)?)
            }
            TextureStep::Parameterize { dim, .. } if !(1..=3).contains(dim) => {
                return Err(malformed("dim: 1, 2 or 3").into());
            }
            TextureStep::Parameterize { entry, point, dim } => {
                let (entry, point) = (entry.entry(rules), &point.0);
                let t = ptm_texture::parameterize(&entry, point, *dim, rules)?;
                json!({ "t": numbers(&t) })
            }
            TextureStep::Reflect { i, n } => json!({ "s": numbers(&(rules.reflect)(*i, *n)) }),
            TextureStep::Orient { matrix, t } => {
                json!({ "t": numbers(&ptm_texture::orient(matrix, *t, rules)) })
            }
            TextureStep::Interpolate {
                ts,
                b,
                w,
                correction,
            } => interpolate(ts, b, w.as_deref(), *correction, rules)?,
            TextureStep::Sites { interp, frequency } => {
                let site = ptm_texture::site(*interp, *frequency, rules);
                json!({ "site": site.name().to_lowercase() })
            }
            TextureStep::Depth {
                size,
                dtdx,
                dtdy,
                bias,
                freq,
            } => {
                if !(1..=3).contains(&size.len()) || dtdx.len() > 3 || dtdy.len() > 3 {
                    return Err(malformed("size: expected 1 to 3 numbers").into());
                }
                let (dt_dx, dt_dy) = (padded(dtdx, 0.0), padded(dtdy, 0.0));
                let footprint = Footprint { dt_dx, dt_dy };
                let hints = padded(freq, 1.0);
                let depth = ptm_texture::sample_depth(size, &footprint, *bias, hints);
                let is_magnified = ptm_texture::is_magnified(size, &footprint, *bias, rules);
                let mode = if is_magnified { "mag" } else { "min" };
                json!({ "depth": number(depth), "mode": mode })
            }
            TextureStep::Index { size, .. } if !(1..=1 << 31).contains(size) => {
                return Err(malformed("size: expected a number from 1 to 2^31").into());
            }
            TextureStep::Index { boundary, size, t } => {
                let index = |&t: &f64| ptm_texture::texel_index(*boundary, t, *size, rules);
                json!({ "index": t.iter().map(index).collect::<Vec<usize>>() })
            }
            _ => return self.color(rules),
        }))
    }

    /// Computes the result of a step that returns a texel or a color.
    fn color(&self, rules: &Rules) -> Result<ToleratedAnswer, Unanswered> {
        Ok(match self {
            TextureStep::Sample {
                map,
                t,
                depth,
                is_magnified,
                entry,
            } => {
                let (map, entry) = (map.map(rules)?, entry.entry(rules));
                let (depth, is_magnified) = (*depth, *is_magnified);
                let sample =
                    ptm_texture::fetch_with_tolerance(&entry, &map, *t, depth, is_magnified, rules);
                texel_json(&sample)
            }
            &TextureStep::Compose {
                ref entry,
                ref texel,
                color,
                alpha,
                cw,
            } => {
                let (fetched, entry) = (texel.fetched()?, entry.entry(rules));
                let input = Shade { color, alpha };
                let shade = ptm_texture::compose(&entry, &fetched, input, cw, rules);
                ToleratedAnswer::exact(shade_json(shade))
            }
            TextureStep::Stage {
                surface,
                interp,
                frequency,
                entries,
            } => {
                let mut maps = Vec::new();
                let mut tolerances = Vec::new();
                for given in entries {
                    let entry = given.entry.entry(rules);
                    let sample = given.sample(&entry, rules)?;
                    maps.push((entry, sample.value));
                    tolerances.push(sample.tolerance);
                }
                let interpolation = interp.unwrap_or(Interpolation::None);
                let frequency = frequency.unwrap_or(Frequency::InterpDep);
                let (color, alpha) = (surface.color, surface.alpha);
                let lit = LitPrimitive {
                    surface: Shade { color, alpha },
                    white: surface.cw,
                    specular: surface.cs,
                };
                let shade = |maps: &[(Entry, MapValue)]| {
                    ptm_texture::stage(maps, &lit, interpolation, frequency, rules)
                };
                ToleratedAnswer {
                    answer: shade_json(shade(&maps)),
                    tolerance: shade_json(tolerance_of_shade(&maps, &tolerances, shade)),
                }
            }
            _ => unreachable!("the other steps have been answered"),
        })
    }
}

fn interpolate(
    ts: &[Vec<f64>],
    b: &[f64],
    w: Option<&[f64]>,
    correction: Correction,
    rules: &Rules,
) -> Result<Value, Unanswered> {
    let count = ts.first().map_or(0, Vec::len);
    let all_one = vec![1.0; b.len()];
    let w = w.unwrap_or(&all_one);
    let equal_counts = ts.iter().all(|t| t.len() == count);
    let equal_corners = ts.len() == b.len() && b.len() == w.len();
    if !(1..=3).contains(&count) || !equal_counts || !equal_corners {
        let expected = "expected one element per corner, and 1 to 3 coordinates per element of ts";
        return Err(malformed(format!("ts, b and w: {expected}")).into());
    }
    let ts: Vec<Vector> = ts.iter().map(|t| padded(t, 0.0)).collect();
    let t = ptm_texture::interpolate(&ts, b, w, correction, rules)?;
    Ok(json!({ "t": numbers(&t[..count]) }))
}

fn two() -> usize {
    2
}

fn opaque() -> f64 {
    1.0
}

fn white() -> Color {
    [1.0; 3]
}

/// The fields of a table entry that are given in a question. Missing fields have their fallback values.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(try_from = "Value")]
pub struct GivenEntry {
    fields: Map<String, Value>,
    /// The entry, with the fallback values from the chapter.
    entry: Entry,
}

impl TryFrom<Value> for GivenEntry {
    type Error = serde_json::Error;

    fn try_from(mut value: Value) -> serde_json::Result<GivenEntry> {
        if let Value::Object(fields) = &mut value {
            fields.retain(|_, value| !value.is_null());
        }
        Ok(GivenEntry {
            entry: Entry::deserialize(&value)?,
            fields: value.as_object().cloned().unwrap_or_default(),
        })
    }
}

impl GivenEntry {
    /// Returns the complete entry, with fallback values from `rules`.
    ///
    /// # Panics
    /// Panics only if a field is invalid, which parsing rules out.
    #[must_use]
    pub fn entry(&self, rules: &Rules) -> Entry {
        let fallback = (rules.fallback_values)();
        if fallback == Entry::default() {
            return self.entry.clone();
        }
        let mut fields = entry_json(&fallback);
        for (name, value) in &self.fields {
            fields[name] = value.clone();
        }
        serde_json::from_value(fields).expect("the fields were read successfully before")
    }
}

/// The fields of a point in a question.
const POINT_FIELDS: &str = "`mc`, `wc`, `vrc`, `eye_mc`, `eye_wc`, `eye_vrc`, `mc_normal`, `wc_normal`, `vrc_normal`, \
    `mc_geometric_normal`, `wc_geometric_normal`, `vrc_geometric_normal`, `fp_data`, `nurb`, `u`, `v`, `data_splines`, `i`, `s`";

/// A point on a surface. Field names such as `mc`, `eye_mc`, `mc_normal` and `mc_geometric_normal` state the coordinate system.
#[derive(Debug, Default, Deserialize)]
#[serde(try_from = "Map<String, Value>")]
struct GivenPoint(Point);

impl TryFrom<Map<String, Value>> for GivenPoint {
    type Error = serde_json::Error;

    fn try_from(mut fields: Map<String, Value>) -> serde_json::Result<GivenPoint> {
        fields.retain(|_, value| !value.is_null());
        let is_known = |name: &String| POINT_FIELDS.contains(&format!("`{name}`"));
        if let Some(name) = fields.keys().find(|name| !is_known(name)) {
            let error = format!("unknown field `{name}`, expected one of {POINT_FIELDS}");
            return Err(serde_json::Error::custom(error));
        }
        let spline = spline(&mut fields)?;
        let fp_data = fields.remove("fp_data").map(serde_json::from_value);
        let mut vector = |name: &str| -> serde_json::Result<Option<Vector>> {
            fields.remove(name).map(serde_json::from_value).transpose()
        };
        let (sight, reflection) = (vector("i")?, vector("s")?);
        let mut place = |system: &str| -> serde_json::Result<VertexData> {
            Ok(VertexData {
                position: vector(system)?,
                eye: vector(&format!("eye_{system}"))?,
                normal: vector(&format!("{system}_normal"))?,
                geometric_normal: vector(&format!("{system}_geometric_normal"))?,
            })
        };
        Ok(GivenPoint(Point {
            mc: place("mc")?,
            wc: place("wc")?,
            vrc: place("vrc")?,
            fp_data: fp_data.transpose()?.unwrap_or_default(),
            spline,
            sight,
            reflection,
        }))
    }
}

/// Reads the point of a spline surface from the field `nurb`, or from the sibling fields if `nurb` is true or missing.
fn spline(fields: &mut Map<String, Value>) -> serde_json::Result<Option<SplinePoint>> {
    let names = ["u", "v", "data_splines"].into_iter();
    let flat: Map<String, Value> = names.filter_map(|name| fields.remove_entry(name)).collect();
    let mut spline = match fields.remove("nurb") {
        Some(Value::Bool(false)) => return Ok(None),
        None if flat.is_empty() => return Ok(None),
        Some(Value::Bool(true)) | None => Value::Object(flat),
        Some(nurb) => nurb,
    };
    // A data spline with one value may be a number.
    let splines = spline.get_mut("data_splines").and_then(Value::as_array_mut);
    for values in splines.into_iter().flatten() {
        if values.is_number() {
            *values = json!([values]);
        }
    }
    serde_json::from_value(spline).map(Some)
}

/// A map in a question: a name, a PTM, or texels.
#[derive(Debug, Deserialize)]
#[serde(try_from = "Value")]
enum GivenMap {
    /// The name of a map; only `"default"` exists.
    Named(String),
    Ptm(GivenPtm),
    Levels(GivenLevels),
}

/// A PTM under a light.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GivenPtm {
    /// The file, in hexadecimal.
    ptm: String,
    light: [f64; 2],
    /// Texel type: `rgb_float` or `rgb8`.
    texel: Option<String>,
    /// Mipmap filter: `none` or `box`.
    mipmap: Option<String>,
}

/// The texels of a map.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GivenLevels {
    kind: TexelKind,
    /// The levels, from the base to the pinnacle.
    levels: Vec<GivenLevel>,
    /// Mipmap filter: `none` or `box`.
    mipmap: Option<String>,
}

/// The texels of a level.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GivenLevel {
    /// Number of texels in each direction of the map.
    size: Vec<usize>,
    /// The components of each texel, with t0 varying fastest.
    texels: Vec<Vec<f64>>,
}

impl TryFrom<Value> for GivenMap {
    type Error = Error;

    fn try_from(value: Value) -> Result<GivenMap> {
        let read = match &value {
            Value::String(name) => Ok(GivenMap::Named(name.clone())),
            Value::Object(fields) if fields.contains_key("ptm") => {
                GivenPtm::deserialize(&value).map(GivenMap::Ptm)
            }
            _ => GivenLevels::deserialize(&value).map(GivenMap::Levels),
        };
        read.map_err(|error| format!("map: {error}").into())
    }
}

impl GivenMap {
    fn map(&self, rules: &Rules) -> Result<TextureMap, Refusal> {
        let (map, mipmap) = match self {
            GivenMap::Named(name) if name == "default" => (TextureMap::checkerboard(rules), &None),
            GivenMap::Named(name) => return Err(malformed(format!("no map {name:?}"))),
            GivenMap::Ptm(ptm) => (ptm.map(rules)?, &ptm.mipmap),
            GivenMap::Levels(levels) => (levels.map()?, &levels.mipmap),
        };
        match mipmap.as_deref() {
            None | Some("none") => Ok(map.stored(rules)),
            Some("box") => Ok(map.stored(rules).with_box_levels().stored(rules)),
            Some(other) => Err(Refusal::Unsupported(format!("mipmap {other:?}"))),
        }
    }
}

impl GivenPtm {
    fn map(&self, rules: &Rules) -> Result<TextureMap, Refusal> {
        let file = HEXLOWER_PERMISSIVE.decode(self.ptm.as_bytes());
        let file = file.map_err(|_| malformed("ptm: expected hexadecimal digits"))?;
        let ptm = ptm::decode(&file).map_err(|error| malformed(error.to_string()))?;
        let rounding = match self.texel.as_deref() {
            None | Some("rgb_float") => Rounding::None,
            Some("rgb8") => Rounding::EightBits,
            Some(other) => return Err(Refusal::Unsupported(format!("texel {other:?}"))),
        };
        let ([lu, lv], coefficients) = (self.light, ptm.coefficients());
        Ok(TextureMap::from_ptm(&coefficients, lu, lv, rounding, rules))
    }
}

impl GivenLevels {
    fn map(&self) -> Result<TextureMap, Refusal> {
        let malformed = |message: String| malformed(format!("map: {message}"));
        let dimensions = self.levels.first().map_or(0, |level| level.size.len());
        let mut levels = Vec::new();
        for given in &self.levels {
            if given.size.len() != dimensions || dimensions > 3 {
                return Err(malformed("expected a size of 1 to 3 numbers".to_owned()));
            }
            let mut size = [1; 3];
            size[..dimensions].copy_from_slice(&given.size);
            let (kind, count) = (self.kind, self.kind.components());
            let texels = given.texels.iter().map(|texel| Texel::new(kind, texel));
            let texels: Option<_> = texels.collect();
            let error = || malformed(format!("a texel of kind {kind} has {count} components"));
            let texels = texels.ok_or_else(error)?;
            levels.push(Level { size, texels });
        }
        TextureMap::new(dimensions, levels).map_err(|error| malformed(error.to_string()))
    }
}

/// A texel: kind and components, or `"discontinue"`.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum GivenTexel {
    Texel(TexelKind, Vec<f64>),
    Word(String),
}

impl GivenTexel {
    fn fetched(&self) -> Result<MapValue, Refusal> {
        let texel = match self {
            GivenTexel::Texel(kind, components) => Texel::new(*kind, components),
            GivenTexel::Word(word) if word == "discontinue" => return Ok(MapValue::Discontinued),
            GivenTexel::Word(_) => None,
        };
        let texel = texel.map(MapValue::Texel);
        texel.ok_or_else(|| malformed("texel: expected [kind, components] or \"discontinue\""))
    }
}

/// A primitive and its light.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GivenSurface {
    /// The color before lighting.
    color: Color,
    #[serde(default = "opaque")]
    alpha: f64,
    /// CW: ambient and diffuse light on a white surface.
    #[serde(default = "white")]
    cw: Color,
    /// CS: specular light.
    #[serde(default)]
    cs: Color,
}

/// One map of a stage: a texel, or a map and the position at which it is sampled.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct StageEntry {
    #[serde(default)]
    entry: GivenEntry,
    /// The sampled value.
    texel: Option<GivenTexel>,
    /// The map, or the default map if omitted.
    map: Option<GivenMap>,
    /// The coordinates at which the map is sampled, after orientation.
    t: Option<Vector>,
    /// The point from which coordinates are derived.
    point: Option<GivenPoint>,
    /// The sample depth.
    #[serde(default)]
    depth: f64,
    /// True if the map is magnified.
    #[serde(default, rename = "mag")]
    is_magnified: bool,
}

impl StageEntry {
    /// Returns the given texel, or samples the map.
    fn sample(&self, entry: &Entry, rules: &Rules) -> Result<ToleratedSample, Unanswered> {
        if let Some(texel) = &self.texel {
            return Ok(ToleratedSample::exact(texel.fetched()?));
        }
        let map = match &self.map {
            Some(map) => map.map(rules)?,
            None => TextureMap::checkerboard(rules),
        };
        let t = match (self.t, &self.point) {
            (Some(t), _) => t,
            (None, Some(point)) => {
                let t = ptm_texture::parameterize(entry, &point.0, map.dimensions(), rules)?;
                ptm_texture::orient(&entry.orientation_matrix, t, rules)
            }
            (None, None) => return Err(malformed("an entry needs texel, t or point").into()),
        };
        let (depth, is_magnified) = (self.depth, self.is_magnified);
        Ok(ptm_texture::fetch_with_tolerance(
            entry,
            &map,
            t,
            depth,
            is_magnified,
            rules,
        ))
    }
}

/// Maximum number of texel components of a stage whose tolerance is propagated.
const MAX_INEXACT_COMPONENTS: usize = 16;

/// Propagates the tolerances of samples to the color of a primitive.
///
/// Color and alpha are affine in each component of each sample, so the largest deviations occur where every component deviates
/// by its full tolerance. Returns the largest deviations, as a color. Components after the first 16 that have a tolerance are
/// treated as exact.
fn tolerance_of_shade(
    maps: &[(Entry, MapValue)],
    tolerances: &[Tolerance],
    shade: impl Fn(&[(Entry, MapValue)]) -> Shade,
) -> Shade {
    let exact = shade(maps);
    let mut largest = Shade {
        color: [0.0; 3],
        alpha: 0.0,
    };
    let inexact: Vec<(usize, usize)> = (0..maps.len())
        .flat_map(|map| (0..4).map(move |component| (map, component)))
        .filter(|&(map, component)| tolerances[map][component] > 0.0)
        .take(MAX_INEXACT_COMPONENTS)
        .collect();
    if inexact.is_empty() {
        return largest;
    }
    for signs in 0..1_u32 << inexact.len() {
        let mut changed = maps.to_vec();
        for (i, &(map, component)) in inexact.iter().enumerate() {
            let sign = if signs >> i & 1 == 1 { 1.0 } else { -1.0 };
            if let MapValue::Texel(texel) = &mut changed[map].1 {
                *texel = texel.map_components(|c, value| {
                    if c == component {
                        value + sign * tolerances[map][component]
                    } else {
                        value
                    }
                });
            }
        }
        let changed = shade(&changed);
        largest.alpha = largest.alpha.max((changed.alpha - exact.alpha).abs());
        for c in 0..3 {
            let deviation = (changed.color[c] - exact.color[c]).abs();
            largest.color[c] = largest.color[c].max(deviation);
        }
    }
    largest
}

fn padded(values: &[f64], with: f64) -> Vector {
    [0, 1, 2].map(|c| values.get(c).copied().unwrap_or(with))
}

fn shade_json(shade: Shade) -> Value {
    json!({ "color": numbers(&shade.color), "alpha": number(shade.alpha) })
}

fn texel_json(sample: &ToleratedSample) -> ToleratedAnswer {
    match sample.value.components() {
        Some(components) => ToleratedAnswer {
            answer: json!({ "texel": numbers(components) }),
            tolerance: json!({ "texel": numbers(&sample.tolerance[..components.len()]) }),
        },
        None => ToleratedAnswer::exact(json!({ "texel": "discontinue" })),
    }
}

fn numbers(values: &[f64]) -> Value {
    values.iter().copied().map(number).collect()
}

/// Returns a JSON number; infinities, which JSON lacks, become words.
fn number(value: f64) -> Value {
    serde_json::Number::from_f64(value).map_or_else(|| value.to_string().into(), Value::Number)
}

fn entry_json(entry: &Entry) -> Value {
    serde_json::to_value(entry).expect("the fields of an entry are numbers and strings")
}
