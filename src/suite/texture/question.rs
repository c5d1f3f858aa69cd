//! Questions about a texture stage, and the reference's answers.
//!
//! A question is `{"op": …, "given": {…}}`. Each op is one step of the pipeline, or all of it (`stage`). A missing field of an
//! entry has its fallback value. Enumerants are written as in the chapter, without their prefix.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::Arc;

use data_encoding::HEXLOWER_PERMISSIVE;
use serde::Deserialize;
use serde::de::{DeserializeOwned, Error as _};
use serde_json::{Map, Value, json};

use crate::protocol::frame::{EXIT_MALFORMED, EXIT_UNSUPPORTED};
use crate::texture::{
    self, Boundary, Color, Correction, Entry, Fetched, Footprint, Frequency, InteriorStyle,
    Interpolation, Level, Lit, Matrix, NoValue, Place, Point, Rounding, Rules, Selection, Shade,
    SplinePoint, Surface, Table, Texel, TexelKind, TextureMap, Vector,
};

/// One question.
#[derive(Clone, Debug)]
pub struct Question(Arc<dyn Operation>);

/// Why a question has no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The input is not a question, or it is out of the valid range; exit status 65.
    Malformed(String),
    /// The question needs something that the reference does not support; exit status 69.
    Unsupported(String),
}

impl Refusal {
    /// Returns 65 or 69.
    #[must_use]
    pub fn exit_status(&self) -> i32 {
        match self {
            Refusal::Malformed(_) => EXIT_MALFORMED,
            Refusal::Unsupported(_) => EXIT_UNSUPPORTED,
        }
    }

    /// Returns the reason as a sentence.
    #[must_use]
    pub fn message(&self) -> &str {
        match self {
            Refusal::Malformed(message) | Refusal::Unsupported(message) => message,
        }
    }
}

/// Reads the `given` of one op.
type Reader = fn(&Value) -> serde_json::Result<Arc<dyn Operation>>;

/// The ops, in the order of the pipeline.
const OPERATIONS: [(&str, Reader); 13] = [
    ("defaults", read::<Nothing>),
    ("select", read::<SelectGiven>),
    ("resolve", read::<ResolveGiven>),
    ("parameterize", read::<ParameterizeGiven>),
    ("reflect", read::<ReflectGiven>),
    ("orient", read::<OrientGiven>),
    ("interpolate", read::<InterpolateGiven>),
    ("sites", read::<SitesGiven>),
    ("depth", read::<DepthGiven>),
    ("index", read::<IndexGiven>),
    ("sample", read::<SampleGiven>),
    ("compose", read::<ComposeGiven>),
    ("stage", read::<StageGiven>),
];

/// Returns the names of the ops, in the order of the pipeline.
pub fn operation_names() -> impl Iterator<Item = &'static str> {
    OPERATIONS.iter().map(|&(name, _)| name)
}

fn read<T: Operation + DeserializeOwned + 'static>(
    given: &Value,
) -> serde_json::Result<Arc<dyn Operation>> {
    Ok(Arc::new(T::deserialize(given)?))
}

impl Question {
    /// Reads a question from the bytes of a file.
    ///
    /// # Errors
    /// [`Refusal::Unsupported`] for an unknown op, else [`Refusal::Malformed`]; both name the place.
    pub fn read(file: &[u8]) -> Result<Question, Refusal> {
        let value: Value =
            serde_json::from_slice(file).map_err(|error| Refusal::Malformed(error.to_string()))?;
        Question::from_value(&value)
    }

    /// Reads a question from its JSON value.
    ///
    /// # Errors
    /// The errors of [`Question::read`].
    pub fn from_value(value: &Value) -> Result<Question, Refusal> {
        let op = value["op"]
            .as_str()
            .ok_or_else(|| Refusal::Malformed("a question has an op".to_owned()))?;
        let (_, read) = OPERATIONS
            .iter()
            .find(|(name, _)| *name == op)
            .ok_or_else(|| Refusal::Unsupported(format!("unknown op {op:?}")))?;
        let given = value.get("given");
        let operation = given.map_or_else(|| Err(serde_json::Error::missing_field("given")), read);
        operation
            .map(Question)
            .map_err(|error| Refusal::Malformed(format!("{op}: {error}")))
    }

    /// Returns the answer under `rules`, a JSON object.
    ///
    /// # Errors
    /// If the question is malformed or not supported.
    pub fn answer(&self, rules: &Rules) -> Result<Value, Refusal> {
        self.0.answer(rules).or_else(|reason| match reason {
            Unanswered::Refused(refusal) => Err(refusal),
            Unanswered::NoValue(NoValue::ImplementationDefined(ruling)) => {
                Ok(json!({ "impl_defined": ruling }))
            }
            Unanswered::NoValue(other) => Err(Refusal::Malformed(other.to_string())),
        })
    }
}

/// The `given` of one op.
trait Operation: Debug + Send + Sync {
    fn answer(&self, rules: &Rules) -> Result<Value, Unanswered>;
}

/// Why an operation has no answer.
enum Unanswered {
    Refused(Refusal),
    NoValue(NoValue),
}

impl From<Refusal> for Unanswered {
    fn from(refusal: Refusal) -> Unanswered {
        Unanswered::Refused(refusal)
    }
}

impl From<NoValue> for Unanswered {
    fn from(reason: NoValue) -> Unanswered {
        Unanswered::NoValue(reason)
    }
}

fn malformed(message: impl Into<String>) -> Refusal {
    Refusal::Malformed(message.into())
}

/// No fields: requests the fallback values.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Nothing {}

impl Operation for Nothing {
    fn answer(&self, rules: &Rules) -> Result<Value, Unanswered> {
        Ok(entry_json(&rules.fallback_entry()))
    }
}

/// Some fields of an entry; missing ones have their fallback values.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(try_from = "Value")]
pub struct EntryGiven {
    fields: Map<String, Value>,
    /// The entry under the fallback values of the text.
    entry: Entry,
}

impl TryFrom<Value> for EntryGiven {
    type Error = serde_json::Error;

    fn try_from(mut value: Value) -> serde_json::Result<EntryGiven> {
        if let Value::Object(fields) = &mut value {
            fields.retain(|_, value| !value.is_null());
        }
        Ok(EntryGiven {
            entry: Entry::deserialize(&value)?,
            fields: value.as_object().cloned().unwrap_or_default(),
        })
    }
}

impl EntryGiven {
    /// Returns the whole entry; `rules` supply the fallback values.
    ///
    /// # Panics
    /// Never: every field was read as a field of an entry.
    #[must_use]
    pub fn entry(&self, rules: &Rules) -> Entry {
        let fallback = rules.fallback_entry();
        if fallback == Entry::default() {
            return self.entry.clone();
        }
        let mut fields = entry_json(&fallback);
        for (name, value) in &self.fields {
            fields[name] = value.clone();
        }
        serde_json::from_value(fields).expect("every field was read before")
    }
}

/// The state of the pipeline that selects entries.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct SelectGiven {
    /// The style of both sides, or of the front; Hollow by default.
    interior_style: Option<InteriorStyle>,
    /// Active textures: indices of the table.
    active: Vec<i64>,
    /// The style of the back; Hollow by default.
    bf_interior_style: Option<InteriorStyle>,
    /// Active textures of the back.
    bf_active: Vec<i64>,
    /// True if back-facing facets have separate attributes.
    facet_distinguish: bool,
    back_facing: bool,
    /// The limit of maps on a facet; none by default.
    max_texture_maps: Option<usize>,
}

impl Operation for SelectGiven {
    fn answer(&self, rules: &Rules) -> Result<Value, Unanswered> {
        let surface = Surface {
            interior_style: self.interior_style.unwrap_or(InteriorStyle::Hollow),
            active: self.active.clone(),
            bf_interior_style: self.bf_interior_style.unwrap_or(InteriorStyle::Hollow),
            bf_active: self.bf_active.clone(),
            facet_distinguish: self.facet_distinguish,
            max_texture_maps: self.max_texture_maps.unwrap_or(usize::MAX),
        };
        Ok(match texture::select(&surface, self.back_facing, rules) {
            Selection::Untextured => json!({ "entries": "untextured" }),
            Selection::Default => json!({ "entries": ["default"] }),
            Selection::Entries(entries) => json!({ "entries": entries }),
        })
    }
}

/// A table and an index.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ResolveGiven {
    /// Entries by index.
    #[serde(default)]
    table: BTreeMap<String, EntryGiven>,
    /// The index to resolve.
    index: i64,
}

impl Operation for ResolveGiven {
    fn answer(&self, rules: &Rules) -> Result<Value, Unanswered> {
        let mut table = Table::new();
        for (index, given) in &self.table {
            let index = index
                .parse()
                .map_err(|_| malformed(format!("table: {index:?} is no index")))?;
            table.insert(index, given.entry(rules));
        }
        let entry = texture::resolve(&table, self.index, rules)?;
        Ok(entry_json(&entry))
    }
}

/// A spline surface, or true if there is one.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Nurb {
    Is(bool),
    With(SplineGiven),
}

/// A point of a spline surface.
#[derive(Debug, Deserialize)]
struct SplineGiven {
    /// The first parameter.
    #[serde(default)]
    u: f64,
    /// The second parameter.
    #[serde(default)]
    v: f64,
    /// The values of each data spline at the point.
    #[serde(default)]
    data_splines: Vec<Data>,
}

/// The values of a data spline at a point.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Data {
    One(f64),
    Many(Vec<f64>),
}

/// A point of a surface: positions, eyes and normals in three coordinate systems, and their replacements.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct PointGiven {
    mc: Option<Vector>,
    wc: Option<Vector>,
    vrc: Option<Vector>,
    eye_mc: Option<Vector>,
    eye_wc: Option<Vector>,
    eye_vrc: Option<Vector>,
    mc_normal: Option<Vector>,
    wc_normal: Option<Vector>,
    vrc_normal: Option<Vector>,
    mc_geometric_normal: Option<Vector>,
    wc_geometric_normal: Option<Vector>,
    vrc_geometric_normal: Option<Vector>,
    fp_data: Vec<f64>,
    nurb: Option<Nurb>,
    u: Option<f64>,
    v: Option<f64>,
    data_splines: Vec<Data>,
    i: Option<Vector>,
    s: Option<Vector>,
}

impl PointGiven {
    fn point(&self) -> Point {
        let place = |position, eye, normal, geometric_normal| Place {
            position,
            eye,
            normal,
            geometric_normal,
        };
        let [mc, wc, vrc] = [
            (self.mc, self.eye_mc, self.mc_normal),
            (self.wc, self.eye_wc, self.wc_normal),
            (self.vrc, self.eye_vrc, self.vrc_normal),
        ];
        Point {
            mc: place(mc.0, mc.1, mc.2, self.mc_geometric_normal),
            wc: place(wc.0, wc.1, wc.2, self.wc_geometric_normal),
            vrc: place(vrc.0, vrc.1, vrc.2, self.vrc_geometric_normal),
            fp_data: self.fp_data.clone(),
            spline: self.spline(),
            sight: self.i,
            reflection: self.s,
        }
    }

    /// Returns the point of the spline surface, from `nurb` or from the fields next to it.
    fn spline(&self) -> Option<SplinePoint> {
        let is_given = self.u.is_some() || self.v.is_some() || !self.data_splines.is_empty();
        let (u, v, data_splines) = match &self.nurb {
            Some(Nurb::With(spline)) => (spline.u, spline.v, &spline.data_splines),
            Some(Nurb::Is(false)) => return None,
            None if !is_given => return None,
            Some(Nurb::Is(true)) | None => (
                self.u.unwrap_or_default(),
                self.v.unwrap_or_default(),
                &self.data_splines,
            ),
        };
        let values = data_splines.iter().map(|data| match data {
            Data::One(value) => vec![*value],
            Data::Many(values) => values.clone(),
        });
        let data = values.collect();
        Some(SplinePoint { u, v, data })
    }
}

/// An entry, a point, and the number of coordinates of the map.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ParameterizeGiven {
    #[serde(default)]
    entry: EntryGiven,
    #[serde(default)]
    point: PointGiven,
    /// 1, 2 or 3.
    #[serde(default = "two")]
    dim: usize,
}

fn two() -> usize {
    2
}

impl Operation for ParameterizeGiven {
    fn answer(&self, rules: &Rules) -> Result<Value, Unanswered> {
        if !(1..=3).contains(&self.dim) {
            return Err(malformed("dim: 1, 2 or 3").into());
        }
        let (entry, point) = (self.entry.entry(rules), self.point.point());
        let t = texture::parameterize(&entry, &point, self.dim, rules)?;
        Ok(json!({ "t": numbers(&t) }))
    }
}

/// A line of sight and a normal.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ReflectGiven {
    /// The unit vector from the eye.
    i: Vector,
    /// The normal.
    n: Vector,
}

impl Operation for ReflectGiven {
    fn answer(&self, rules: &Rules) -> Result<Value, Unanswered> {
        Ok(json!({ "s": numbers(&rules.reflected(self.i, self.n)) }))
    }
}

/// A matrix of four rows, and coordinates.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct OrientGiven {
    matrix: Matrix,
    t: Vector,
}

impl Operation for OrientGiven {
    fn answer(&self, rules: &Rules) -> Result<Value, Unanswered> {
        Ok(json!({ "t": numbers(&texture::orient(&self.matrix, self.t, rules)) }))
    }
}

/// Corners of a facet.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct InterpolateGiven {
    /// One to three coordinates for each corner.
    ts: Vec<Vec<f64>>,
    /// The weight of each corner on the screen.
    b: Vec<f64>,
    /// The w of each corner; 1 by default.
    w: Option<Vec<f64>>,
    correction: Correction,
}

impl Operation for InterpolateGiven {
    fn answer(&self, rules: &Rules) -> Result<Value, Unanswered> {
        let count = self.ts.first().map_or(0, Vec::len);
        let all_one = vec![1.0; self.b.len()];
        let w = self.w.as_ref().unwrap_or(&all_one);
        let equal_counts = self.ts.iter().all(|t| t.len() == count);
        let equal_corners = self.ts.len() == self.b.len() && self.b.len() == w.len();
        if !(1..=3).contains(&count) || !equal_counts || !equal_corners {
            let expected = "ts, b and w: as many as there are corners, 1 to 3 coordinates each";
            return Err(malformed(expected).into());
        }
        let ts: Vec<Vector> = self.ts.iter().map(|t| padded(t, 0.0)).collect();
        let t = texture::interpolate(&ts, &self.b, w, self.correction, rules)?;
        Ok(json!({ "t": numbers(&t[..count]) }))
    }
}

/// The interpolation method and the sample frequency of a surface.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SitesGiven {
    interp: Interpolation,
    frequency: Frequency,
}

impl Operation for SitesGiven {
    fn answer(&self, rules: &Rules) -> Result<Value, Unanswered> {
        let site = texture::site(self.interp, self.frequency, rules);
        Ok(json!({ "site": site.name().to_lowercase() }))
    }
}

/// A footprint on a map.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct DepthGiven {
    /// Texels of the base level in each direction.
    size: Vec<usize>,
    /// The change of the coordinates to the next pixel on the right.
    dtdx: Vec<f64>,
    /// The change to the next pixel above.
    dtdy: Vec<f64>,
    /// The depth sampling bias hint.
    #[serde(default)]
    bias: f64,
    /// The frequency hints.
    #[serde(default)]
    freq: Vec<f64>,
}

impl Operation for DepthGiven {
    fn answer(&self, rules: &Rules) -> Result<Value, Unanswered> {
        let count = self.size.len();
        if !(1..=3).contains(&count) || self.dtdx.len() > 3 || self.dtdy.len() > 3 {
            let expected = "size: one number for each of 1 to 3 directions";
            return Err(malformed(expected).into());
        }
        let footprint = Footprint {
            dt_dx: padded(&self.dtdx, 0.0),
            dt_dy: padded(&self.dtdy, 0.0),
        };
        let hints = padded(&self.freq, 1.0);
        let depth = texture::sample_depth(&self.size, &footprint, self.bias, hints, rules);
        let mode = match texture::magnifies(&self.size, &footprint, rules) {
            true => "mag",
            false => "min",
        };
        Ok(json!({ "depth": number(depth), "mode": mode }))
    }
}

/// Coordinates along one direction, and a number of texels.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct IndexGiven {
    boundary: Boundary,
    size: usize,
    t: Vec<f64>,
}

impl Operation for IndexGiven {
    fn answer(&self, rules: &Rules) -> Result<Value, Unanswered> {
        if !(1..=1 << 31).contains(&self.size) {
            return Err(malformed("size: from 1 to 2^31").into());
        }
        let index = |&t: &f64| texture::texel_index(self.boundary, t, self.size, rules);
        let indices: Vec<usize> = self.t.iter().map(index).collect();
        Ok(json!({ "index": indices }))
    }
}

/// A map.
#[derive(Debug, Deserialize)]
#[serde(try_from = "Value")]
enum MapGiven {
    /// `"default"`
    Named(String),
    Ptm(PtmGiven),
    Levels(LevelsGiven),
}

/// A PTM under a light.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PtmGiven {
    /// The file, in hexadecimal digits.
    ptm: String,
    light: [f64; 2],
    /// `rgb_float` or `rgb8`.
    texel: Option<String>,
    /// `none` or `box`.
    mipmap: Option<String>,
}

/// The texels of a map.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LevelsGiven {
    kind: TexelKind,
    /// From the base to the pinnacle.
    levels: Vec<LevelGiven>,
    /// `none` or `box`.
    mipmap: Option<String>,
}

/// The texels of a level.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LevelGiven {
    /// One number for each direction of the map.
    size: Vec<usize>,
    /// The components of each texel, t0 fastest.
    texels: Vec<Vec<f64>>,
}

impl TryFrom<Value> for MapGiven {
    type Error = String;

    fn try_from(value: Value) -> Result<MapGiven, String> {
        let read = match &value {
            Value::String(name) => Ok(MapGiven::Named(name.clone())),
            Value::Object(fields) if fields.contains_key("ptm") => {
                PtmGiven::deserialize(&value).map(MapGiven::Ptm)
            }
            _ => LevelsGiven::deserialize(&value).map(MapGiven::Levels),
        };
        read.map_err(|error| format!("map: {error}"))
    }
}

impl MapGiven {
    fn map(&self, rules: &Rules) -> Result<TextureMap, Refusal> {
        let (map, mipmap) = match self {
            MapGiven::Named(name) if name == "default" => (TextureMap::checkerboard(rules), &None),
            MapGiven::Named(name) => return Err(malformed(format!("no map {name:?}"))),
            MapGiven::Ptm(ptm) => (ptm.map(rules)?, &ptm.mipmap),
            MapGiven::Levels(levels) => (levels.map()?, &levels.mipmap),
        };
        match mipmap.as_deref() {
            None | Some("none") => Ok(map),
            Some("box") => Ok(map.with_box_levels()),
            Some(other) => Err(Refusal::Unsupported(format!("mipmap {other:?}"))),
        }
    }
}

impl PtmGiven {
    fn map(&self, rules: &Rules) -> Result<TextureMap, Refusal> {
        let file = HEXLOWER_PERMISSIVE.decode(self.ptm.as_bytes());
        let file = file.map_err(|_| malformed("ptm: not hexadecimal digits"))?;
        let ptm = crate::decode(&file).map_err(|error| malformed(error.to_string()))?;
        let rounding = match self.texel.as_deref() {
            None | Some("rgb_float") => Rounding::None,
            Some("rgb8") => Rounding::EightBits,
            Some(other) => return Err(Refusal::Unsupported(format!("texel {other:?}"))),
        };
        let ([lu, lv], coefficients) = (self.light, ptm.coefficients());
        Ok(TextureMap::from_ptm(&coefficients, lu, lv, rounding, rules))
    }
}

impl LevelsGiven {
    fn map(&self) -> Result<TextureMap, Refusal> {
        let malformed = |message: String| malformed(format!("map: {message}"));
        let dimensions = self.levels.first().map_or(0, |level| level.size.len());
        let mut levels = Vec::new();
        for given in &self.levels {
            if given.size.len() != dimensions || dimensions > 3 {
                let expected = "a size has one number for each of 1 to 3 directions";
                return Err(malformed(expected.to_owned()));
            }
            let mut size = [1; 3];
            size[..dimensions].copy_from_slice(&given.size);
            let texels = given.texels.iter();
            let texels: Option<_> = texels.map(|texel| Texel::new(self.kind, texel)).collect();
            let texels = texels.ok_or_else(|| {
                let (kind, count) = (self.kind, self.kind.components());
                malformed(format!("a texel of kind {kind} has {count} components"))
            })?;
            levels.push(Level { size, texels });
        }
        TextureMap::new(dimensions, levels).map_err(malformed)
    }
}

/// A map, and the coordinates and the depth at which it is sampled.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SampleGiven {
    map: MapGiven,
    t: Vector,
    /// The sample depth.
    #[serde(default)]
    depth: f64,
    /// True if the map is enlarged.
    #[serde(default)]
    mag: bool,
    #[serde(default)]
    entry: EntryGiven,
}

impl Operation for SampleGiven {
    fn answer(&self, rules: &Rules) -> Result<Value, Unanswered> {
        let (map, entry) = (self.map.map(rules)?, self.entry.entry(rules));
        let fetched = texture::fetch(&entry, &map, self.t, self.depth, self.mag, rules);
        Ok(match fetched.components() {
            Some(components) => json!({ "texel": numbers(components) }),
            None => json!({ "texel": "discontinue" }),
        })
    }
}

/// A texel: kind and components, or `"discontinue"`.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum TexelGiven {
    Texel(TexelKind, Vec<f64>),
    Word(String),
}

impl TexelGiven {
    fn fetched(&self) -> Result<Fetched, Refusal> {
        let texel = match self {
            TexelGiven::Texel(kind, components) => Texel::new(*kind, components),
            TexelGiven::Word(word) if word == "discontinue" => return Ok(Fetched::Discontinued),
            TexelGiven::Word(_) => None,
        };
        let texel = texel.map(Fetched::Texel);
        texel.ok_or_else(|| malformed("texel: [kind, components] or \"discontinue\""))
    }
}

/// One map on the color of a primitive.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ComposeGiven {
    #[serde(default)]
    entry: EntryGiven,
    texel: TexelGiven,
    /// The primitive's color; in the split form, the lit one.
    color: Color,
    #[serde(default = "opaque")]
    alpha: f64,
    /// The light on white; present in the split form only.
    cw: Option<Color>,
}

fn opaque() -> f64 {
    1.0
}

impl Operation for ComposeGiven {
    fn answer(&self, rules: &Rules) -> Result<Value, Unanswered> {
        let input = Shade {
            color: self.color,
            alpha: self.alpha,
        };
        let (fetched, entry) = (self.texel.fetched()?, self.entry.entry(rules));
        let white = self.cw.unwrap_or_else(white);
        let shade = texture::compose(&entry, &fetched, input, white, rules);
        Ok(shade_json(shade))
    }
}

/// A primitive and its light.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SurfaceGiven {
    /// The color before light.
    color: Color,
    #[serde(default = "opaque")]
    alpha: f64,
    /// Ambient and diffuse light on white.
    #[serde(default = "white")]
    cw: Color,
    /// The specular part.
    #[serde(default)]
    cs: Color,
}

fn white() -> Color {
    [1.0; 3]
}

/// One map of a stage: a texel, or a map and the position at which it is sampled.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct StageEntry {
    #[serde(default)]
    entry: EntryGiven,
    /// The sampled value.
    texel: Option<TexelGiven>,
    /// The map; the default map if left out.
    map: Option<MapGiven>,
    /// The coordinates at which it is sampled, after orientation.
    t: Option<Vector>,
    /// The point from which coordinates are derived.
    point: Option<PointGiven>,
    /// The sample depth.
    #[serde(default)]
    depth: f64,
    /// True if the map is enlarged.
    #[serde(default)]
    mag: bool,
}

impl StageEntry {
    fn fetched(&self, entry: &Entry, rules: &Rules) -> Result<Fetched, Unanswered> {
        if let Some(texel) = &self.texel {
            return Ok(texel.fetched()?);
        }
        let map = match &self.map {
            Some(map) => map.map(rules)?,
            None => TextureMap::checkerboard(rules),
        };
        let t = match (self.t, &self.point) {
            (Some(t), _) => t,
            (None, Some(point)) => {
                let t = texture::parameterize(entry, &point.point(), map.dimensions(), rules)?;
                texture::orient(&entry.orientation_matrix, t, rules)
            }
            (None, None) => return Err(malformed("an entry needs texel, t or point").into()),
        };
        let fetched = texture::fetch(entry, &map, t, self.depth, self.mag, rules);
        Ok(fetched)
    }
}

/// A primitive, its light and its maps, in order.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct StageGiven {
    surface: SurfaceGiven,
    interp: Option<Interpolation>,
    frequency: Option<Frequency>,
    entries: Vec<StageEntry>,
}

impl Operation for StageGiven {
    fn answer(&self, rules: &Rules) -> Result<Value, Unanswered> {
        let mut maps = Vec::new();
        for given in &self.entries {
            let entry = given.entry.entry(rules);
            let fetched = given.fetched(&entry, rules)?;
            maps.push((entry, fetched));
        }
        let lit = Lit {
            surface: Shade {
                color: self.surface.color,
                alpha: self.surface.alpha,
            },
            white: self.surface.cw,
            specular: self.surface.cs,
        };
        let interpolation = self.interp.unwrap_or(Interpolation::None);
        let frequency = self.frequency.unwrap_or(Frequency::InterpDep);
        let shade = texture::stage(&maps, &lit, interpolation, frequency, rules);
        Ok(shade_json(shade))
    }
}

fn padded(values: &[f64], with: f64) -> Vector {
    [0, 1, 2].map(|c| values.get(c).copied().unwrap_or(with))
}

fn shade_json(shade: Shade) -> Value {
    json!({ "color": numbers(&shade.color), "alpha": number(shade.alpha) })
}

fn numbers(values: &[f64]) -> Value {
    values.iter().copied().map(number).collect()
}

/// Returns a JSON number; infinities, which JSON lacks, become words.
fn number(value: f64) -> Value {
    match serde_json::Number::from_f64(value) {
        Some(number) => Value::Number(number),
        None => Value::String(value.to_string()),
    }
}

fn entry_json(entry: &Entry) -> Value {
    serde_json::to_value(entry).expect("the fields of an entry are numbers and words")
}
