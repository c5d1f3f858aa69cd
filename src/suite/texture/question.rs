//! What is asked about a texture stage, and what the reference answers.
//!
//! A question is `{"op": …, "given": {…}}`. Each op is one step of the pipeline, or all of it (`stage`). Fields of an entry that
//! are left out have their fallback values; enumerants go by the chapter's names without prefix.

use std::collections::BTreeMap;
use std::str::FromStr;

use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value, json};

use crate::protocol::frame::{EXIT_MALFORMED, EXIT_UNSUPPORTED};
use crate::texture::{
    self, Boundary, Channel, ClampMethod, Color, Composition, Correction, Entry, Fetched,
    Footprint, Frequency, InteriorStyle, Interpolation, Level, Lit, Matrix, NoValue,
    Parameterization, Place, Point, RenderingControl, Rounding, Rules, SampleMethod, Selection,
    Shade, SplinePoint, Surface, Table, Texel, TexelKind, TextureMap, Vector,
};

/// One question.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "op", content = "given", rename_all = "lowercase")]
pub enum Question {
    /// The fallback values of all fields.
    Defaults(Nothing),
    /// Which entries a facet asks for.
    Select(SelectGiven),
    /// The entry that an index names.
    Resolve(ResolveGiven),
    /// Texture coordinates of a point.
    Parameterize(ParameterizeGiven),
    /// A reflection vector.
    Reflect(ReflectGiven),
    /// Coordinates after the orientation matrix.
    Orient(OrientGiven),
    /// Coordinates inside a facet.
    Interpolate(InterpolateGiven),
    /// Where a texture is sampled.
    Sites(SitesGiven),
    /// Sample depth, and whether the map is shrunk.
    Depth(DepthGiven),
    /// Texels along one direction.
    Index(IndexGiven),
    /// A value of a map.
    Sample(SampleGiven),
    /// A color after one map.
    Compose(ComposeGiven),
    /// A color after all maps and light.
    Stage(StageGiven),
}

/// Why a question has no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// It is not a question, or it is out of the valid range; exit status 65.
    Malformed(String),
    /// It is about something that is not known here; exit status 69.
    Unsupported(String),
}

impl Refusal {
    /// 65 or 69.
    #[must_use]
    pub fn exit_status(&self) -> i32 {
        match self {
            Refusal::Malformed(_) => EXIT_MALFORMED,
            Refusal::Unsupported(_) => EXIT_UNSUPPORTED,
        }
    }

    /// In words.
    #[must_use]
    pub fn message(&self) -> &str {
        match self {
            Refusal::Malformed(message) | Refusal::Unsupported(message) => message,
        }
    }
}

/// The ops, in the order of the pipeline.
pub const OPS: [&str; 13] = [
    "defaults",
    "select",
    "resolve",
    "parameterize",
    "reflect",
    "orient",
    "interpolate",
    "sites",
    "depth",
    "index",
    "sample",
    "compose",
    "stage",
];

impl Question {
    /// A question from the bytes of a file.
    ///
    /// # Errors
    /// [`Refusal::Unsupported`] for an op that is not known, else [`Refusal::Malformed`]; both name the place.
    pub fn read(file: &[u8]) -> Result<Question, Refusal> {
        let value: Value =
            serde_json::from_slice(file).map_err(|error| Refusal::Malformed(error.to_string()))?;
        Question::of(&value)
    }

    /// A question from its JSON value.
    ///
    /// # Errors
    /// As [`Question::read`].
    pub fn of(value: &Value) -> Result<Question, Refusal> {
        let op = value["op"]
            .as_str()
            .ok_or_else(|| Refusal::Malformed("a question has an op".to_owned()))?;
        if !OPS.contains(&op) {
            return Err(Refusal::Unsupported(format!("unknown op {op:?}")));
        }
        Question::deserialize(value).map_err(|error| Refusal::Malformed(format!("{op}: {error}")))
    }
}

/// An enumerant, by its name.
#[derive(Clone, Copy, Debug)]
pub struct Named<T>(T);

impl<'de, T: FromStr<Err = String>> Deserialize<'de> for Named<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        name.parse().map(Named).map_err(serde::de::Error::custom)
    }
}

/// No fields.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Nothing {}

/// Fields of an entry; what is left out has its fallback value.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)] // each is a field of Entry
pub struct EntryGiven {
    pub map_ids: Option<Vec<u32>>,
    pub rendering_control: Option<Named<RenderingControl>>,
    pub parameterization: Option<Named<Parameterization>>,
    pub fp_data_index: Option<usize>,
    pub reflection_matrix: Option<Matrix>,
    pub reflection_hints: Option<String>,
    pub orientation_matrix: Option<Matrix>,
    pub orientation_hints: Option<String>,
    pub composition: Option<Named<Composition>>,
    pub channel: Option<Named<Channel>>,
    pub env_color: Option<Color>,
    pub background_color: Option<Color>,
    pub min_sample: Option<Named<SampleMethod>>,
    pub mag_sample: Option<Named<SampleMethod>>,
    pub boundary: Option<[Named<Boundary>; 3]>,
    pub clamp_method: Option<Named<ClampMethod>>,
    pub clamp_color: Option<Color>,
    pub depth_bias: Option<f64>,
    pub frequency: Option<[f64; 3]>,
}

impl EntryGiven {
    /// The whole entry.
    #[must_use]
    pub fn entry(&self, rules: &Rules) -> Entry {
        let Entry {
            map_ids,
            rendering_control,
            parameterization,
            fp_data_index,
            reflection_matrix,
            reflection_hints,
            orientation_matrix,
            orientation_hints,
            composition,
            channel,
            env_color,
            background_color,
            min_sample,
            mag_sample,
            boundary,
            clamp_method,
            clamp_color,
            depth_bias,
            frequency,
        } = rules.fallback_entry();
        Entry {
            map_ids: self.map_ids.clone().unwrap_or(map_ids),
            rendering_control: named(self.rendering_control, rendering_control),
            parameterization: named(self.parameterization, parameterization),
            fp_data_index: self.fp_data_index.unwrap_or(fp_data_index),
            reflection_matrix: self.reflection_matrix.unwrap_or(reflection_matrix),
            reflection_hints: self.reflection_hints.clone().unwrap_or(reflection_hints),
            orientation_matrix: self.orientation_matrix.unwrap_or(orientation_matrix),
            orientation_hints: self.orientation_hints.clone().unwrap_or(orientation_hints),
            composition: named(self.composition, composition),
            channel: named(self.channel, channel),
            env_color: self.env_color.unwrap_or(env_color),
            background_color: self.background_color.unwrap_or(background_color),
            min_sample: named(self.min_sample, min_sample),
            mag_sample: named(self.mag_sample, mag_sample),
            boundary: self
                .boundary
                .map_or(boundary, |given| given.map(|one| one.0)),
            clamp_method: named(self.clamp_method, clamp_method),
            clamp_color: self.clamp_color.unwrap_or(clamp_color),
            depth_bias: self.depth_bias.unwrap_or(depth_bias),
            frequency: self.frequency.unwrap_or(frequency),
        }
    }
}

fn named<T>(given: Option<Named<T>>, otherwise: T) -> T {
    given.map_or(otherwise, |given| given.0)
}

/// The pipeline's state. An interior style that is left out is Hollow, a list empty, a limit none.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)] // each is a field of Surface
pub struct SelectGiven {
    pub interior_style: Option<Named<InteriorStyle>>,
    pub active: Vec<i64>,
    pub bf_interior_style: Option<Named<InteriorStyle>>,
    pub bf_active: Vec<i64>,
    pub facet_distinguish: bool,
    pub back_facing: bool,
    pub max_texture_maps: Option<usize>,
}

/// A table and an index.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResolveGiven {
    /// Entries by index.
    #[serde(default)]
    pub table: BTreeMap<String, EntryGiven>,
    /// Which one is asked for.
    pub index: i64,
}

/// A spline surface, or only whether there is one.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub enum Nurb {
    /// There is one, or there is none.
    Is(bool),
    /// There is this one.
    With {
        /// The first parameter.
        #[serde(default)]
        u: f64,
        /// The second parameter.
        #[serde(default)]
        v: f64,
        /// The values of each data spline at the point.
        #[serde(default)]
        data_splines: Vec<Data>,
    },
}

/// The values of a data spline at a point.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub enum Data {
    /// Its only value.
    One(f64),
    /// Its values.
    Many(Vec<f64>),
}

/// A point of a surface.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)] // each is a field of Point
pub struct PointGiven {
    pub mc: Option<Vector>,
    pub wc: Option<Vector>,
    pub vrc: Option<Vector>,
    pub eye_mc: Option<Vector>,
    pub eye_wc: Option<Vector>,
    pub eye_vrc: Option<Vector>,
    pub mc_normal: Option<Vector>,
    pub wc_normal: Option<Vector>,
    pub vrc_normal: Option<Vector>,
    pub mc_geometric_normal: Option<Vector>,
    pub wc_geometric_normal: Option<Vector>,
    pub vrc_geometric_normal: Option<Vector>,
    pub fp_data: Vec<f64>,
    pub nurb: Option<Nurb>,
    pub u: Option<f64>,
    pub v: Option<f64>,
    pub data_splines: Vec<Data>,
    pub i: Option<Vector>,
    pub s: Option<Vector>,
}

impl PointGiven {
    fn point(&self) -> Point {
        let place = |position, eye, normal, geometric_normal| Place {
            position,
            eye,
            normal,
            geometric_normal,
        };
        Point {
            mc: place(
                self.mc,
                self.eye_mc,
                self.mc_normal,
                self.mc_geometric_normal,
            ),
            wc: place(
                self.wc,
                self.eye_wc,
                self.wc_normal,
                self.wc_geometric_normal,
            ),
            vrc: place(
                self.vrc,
                self.eye_vrc,
                self.vrc_normal,
                self.vrc_geometric_normal,
            ),
            fp_data: self.fp_data.clone(),
            spline: self.spline(),
            sight: self.i,
            reflection: self.s,
        }
    }

    fn spline(&self) -> Option<SplinePoint> {
        let values = |data: &[Data]| {
            data.iter()
                .map(|values| match values {
                    Data::One(value) => vec![*value],
                    Data::Many(values) => values.clone(),
                })
                .collect()
        };
        match &self.nurb {
            Some(Nurb::Is(false)) => None,
            Some(Nurb::With { u, v, data_splines }) => Some(SplinePoint {
                u: *u,
                v: *v,
                data: values(data_splines),
            }),
            None if self.u.is_none() && self.v.is_none() && self.data_splines.is_empty() => None,
            None | Some(Nurb::Is(true)) => Some(SplinePoint {
                u: self.u.unwrap_or_default(),
                v: self.v.unwrap_or_default(),
                data: values(&self.data_splines),
            }),
        }
    }
}

/// An entry, a point, and how many coordinates the map has.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterizeGiven {
    /// The entry.
    #[serde(default)]
    pub entry: EntryGiven,
    /// The point.
    #[serde(default)]
    pub point: PointGiven,
    /// 1, 2 or 3.
    #[serde(default = "two")]
    pub dim: usize,
}

fn two() -> usize {
    2
}

/// A line of sight and a normal.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReflectGiven {
    /// The unit vector from the eye.
    pub i: Vector,
    /// The normal.
    pub n: Vector,
}

/// A matrix and coordinates.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrientGiven {
    /// Four rows.
    pub matrix: Matrix,
    /// The coordinates.
    pub t: Vector,
}

/// Corners of a facet.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InterpolateGiven {
    /// One to three coordinates for each corner.
    pub ts: Vec<Vec<f64>>,
    /// The share of each corner on the screen.
    pub b: Vec<f64>,
    /// The w of each corner; all 1 if left out.
    pub w: Option<Vec<f64>>,
    /// How they are interpolated.
    pub correction: Named<Correction>,
}

/// How a surface is lit and textured.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SitesGiven {
    /// The interpolation method.
    pub interp: Named<Interpolation>,
    /// The sample frequency.
    pub frequency: Named<Frequency>,
}

/// A footprint on a map.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DepthGiven {
    /// Texels of the base level in each direction.
    pub size: Vec<usize>,
    /// How coordinates change from a pixel to the next on its right.
    pub dtdx: Vec<f64>,
    /// How they change to the next above.
    pub dtdy: Vec<f64>,
    /// The depth sampling bias hint.
    #[serde(default)]
    pub bias: f64,
    /// The frequency hints.
    #[serde(default)]
    pub freq: Vec<f64>,
}

/// Coordinates along one direction.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IndexGiven {
    /// The boundary condition.
    pub boundary: Named<Boundary>,
    /// How many texels.
    pub size: usize,
    /// The coordinates.
    pub t: Vec<f64>,
}

/// A map.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "Value")]
pub enum MapGiven {
    /// `"default"`
    Named(String),
    /// A PTM under a light.
    Ptm(PtmGiven),
    /// Its texels.
    Levels(LevelsGiven),
}

/// A PTM under a light.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PtmGiven {
    /// The file, in hexadecimal digits.
    pub ptm: String,
    /// The light.
    pub light: [f64; 2],
    /// `rgb_float` or `rgb8`.
    pub texel: Option<String>,
    /// `none` or `box`.
    pub mipmap: Option<String>,
}

/// The texels of a map.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LevelsGiven {
    /// Of all texels.
    pub kind: Named<TexelKind>,
    /// From the base to the pinnacle.
    pub levels: Vec<LevelGiven>,
    /// `none` or `box`.
    pub mipmap: Option<String>,
}

/// The texels of a level.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LevelGiven {
    /// One number for each direction of the map.
    pub size: Vec<usize>,
    /// The components of each, t0 fastest.
    pub texels: Vec<Vec<f64>>,
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
            MapGiven::Named(name) => return Err(Refusal::Malformed(format!("no map {name:?}"))),
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
        let file = bytes_of_hex(&self.ptm)
            .ok_or_else(|| Refusal::Malformed("ptm: not hexadecimal digits".to_owned()))?;
        let ptm = crate::decode(&file).map_err(|error| Refusal::Malformed(error.to_string()))?;
        let rounding = match self.texel.as_deref() {
            None | Some("rgb_float") => Rounding::None,
            Some("rgb8") => Rounding::EightBits,
            Some(other) => return Err(Refusal::Unsupported(format!("texel {other:?}"))),
        };
        let [lu, lv] = self.light;
        Ok(TextureMap::from_ptm(
            &ptm.coefficients(),
            lu,
            lv,
            rounding,
            rules,
        ))
    }
}

fn bytes_of_hex(text: &str) -> Option<Vec<u8>> {
    let digits: Option<Vec<u8>> = text.chars().map(|c| Some(c.to_digit(16)? as u8)).collect();
    let digits = digits.filter(|digits| digits.len().is_multiple_of(2))?;
    Some(
        digits
            .chunks(2)
            .map(|pair| pair[0] << 4 | pair[1])
            .collect(),
    )
}

impl LevelsGiven {
    fn map(&self) -> Result<TextureMap, Refusal> {
        let malformed = |message: String| Refusal::Malformed(format!("map: {message}"));
        let dimensions = self.levels.first().map_or(0, |level| level.size.len());
        let mut levels = Vec::new();
        for given in &self.levels {
            if given.size.len() != dimensions || dimensions > 3 {
                return Err(malformed(
                    "a size has one number for each of 1 to 3 directions".into(),
                ));
            }
            let mut size = [1; 3];
            size[..dimensions].copy_from_slice(&given.size);
            let texels: Option<Vec<Texel>> = given
                .texels
                .iter()
                .map(|components| Texel::new(self.kind.0, components))
                .collect();
            let texels = texels.ok_or_else(|| {
                malformed(format!(
                    "a texel of kind {} has {} components",
                    self.kind.0,
                    self.kind.0.components()
                ))
            })?;
            levels.push(Level { size, texels });
        }
        TextureMap::new(dimensions, levels).map_err(malformed)
    }
}

/// Sampling a map.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampleGiven {
    /// The map.
    pub map: MapGiven,
    /// The coordinates.
    pub t: Vector,
    /// The sample depth.
    #[serde(default)]
    pub depth: f64,
    /// Whether the map is enlarged.
    #[serde(default)]
    pub mag: bool,
    /// The entry.
    #[serde(default)]
    pub entry: EntryGiven,
}

/// A texel: kind and components, or `"discontinue"`.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub enum TexelGiven {
    /// Kind and components.
    Texel(Named<TexelKind>, Vec<f64>),
    /// What came of sampling outside.
    Word(String),
}

impl TexelGiven {
    fn fetched(&self) -> Result<Fetched, Refusal> {
        let refused = || Refusal::Malformed("texel: [kind, components] or \"discontinue\"".into());
        match self {
            TexelGiven::Texel(kind, components) => Texel::new(kind.0, components)
                .map(Fetched::Texel)
                .ok_or_else(refused),
            TexelGiven::Word(word) if word == "discontinue" => Ok(Fetched::Discontinued),
            TexelGiven::Word(_) => Err(refused()),
        }
    }
}

/// One map on a color.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComposeGiven {
    /// The entry.
    #[serde(default)]
    pub entry: EntryGiven,
    /// The texel.
    pub texel: TexelGiven,
    /// The primitive's color; in the split form, the lit one.
    pub color: Color,
    /// The primitive's alpha.
    #[serde(default = "opaque")]
    pub alpha: f64,
    /// The light on white; there in the split form only.
    pub cw: Option<Color>,
}

fn opaque() -> f64 {
    1.0
}

/// A primitive and its light.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceGiven {
    /// The color before light.
    pub color: Color,
    /// Its alpha.
    #[serde(default = "opaque")]
    pub alpha: f64,
    /// Ambient and diffuse light on white.
    #[serde(default = "white")]
    pub cw: Color,
    /// The specular part.
    #[serde(default)]
    pub cs: Color,
}

fn white() -> Color {
    [1.0; 3]
}

/// One map of a stage: a texel, or a map and where it is sampled.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageEntry {
    /// The entry.
    #[serde(default)]
    pub entry: EntryGiven,
    /// What was sampled.
    pub texel: Option<TexelGiven>,
    /// The map; the default map if left out.
    pub map: Option<MapGiven>,
    /// Where it is sampled, after orientation.
    pub t: Option<Vector>,
    /// The point from which coordinates are derived.
    pub point: Option<PointGiven>,
    /// The sample depth.
    #[serde(default)]
    pub depth: f64,
    /// Whether the map is enlarged.
    #[serde(default)]
    pub mag: bool,
}

/// A primitive, its light and its maps.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageGiven {
    /// The primitive.
    pub surface: SurfaceGiven,
    /// The interpolation method.
    pub interp: Option<Named<Interpolation>>,
    /// The sample frequency.
    pub frequency: Option<Named<Frequency>>,
    /// The maps, in order.
    pub entries: Vec<StageEntry>,
}

impl From<NoValue> for Refusal {
    fn from(why: NoValue) -> Refusal {
        Refusal::Malformed(why.to_string())
    }
}

impl Question {
    /// The answer under `rules`, a JSON object.
    ///
    /// # Errors
    /// As the exit status says it: malformed, or not supported.
    pub fn answer(&self, rules: &Rules) -> Result<Value, Refusal> {
        let answered = match self {
            Question::Defaults(_) => return Ok(entry_json(&rules.fallback_entry())),
            Question::Select(given) => return Ok(given.answer(rules)),
            Question::Resolve(given) => given.answer(rules)?,
            Question::Parameterize(given) => given.answer(rules)?,
            Question::Reflect(given) => {
                Ok(json!({ "s": numbers(&rules.reflected(given.i, given.n)) }))
            }
            Question::Orient(given) => {
                let t = texture::orient(&given.matrix, given.t, rules);
                Ok(json!({ "t": numbers(&t) }))
            }
            Question::Interpolate(given) => given.answer(rules)?,
            Question::Sites(given) => {
                let site = texture::site(given.interp.0, given.frequency.0, rules);
                Ok(json!({ "site": site.name().to_lowercase() }))
            }
            Question::Depth(given) => given.answer(rules).map(Ok)?,
            Question::Index(given) => given.answer(rules).map(Ok)?,
            Question::Sample(given) => {
                let map = given.map.map(rules)?;
                let entry = given.entry.entry(rules);
                let fetched = texture::fetch(&entry, &map, given.t, given.depth, given.mag, rules);
                Ok(match fetched.components() {
                    Some(components) => json!({ "texel": numbers(components) }),
                    None => json!({ "texel": "discontinue" }),
                })
            }
            Question::Compose(given) => given.answer(rules).map(Ok)?,
            Question::Stage(given) => given.answer(rules)?,
        };
        match answered {
            Ok(value) => Ok(value),
            Err(NoValue::ImplementationDefined(ruling)) => Ok(json!({ "impl_defined": ruling })),
            Err(other) => Err(other.into()),
        }
    }
}

/// A value, or that there is none.
type Answered = Result<Value, NoValue>;

impl SelectGiven {
    fn answer(&self, rules: &Rules) -> Value {
        let surface = Surface {
            interior_style: named(self.interior_style, InteriorStyle::Hollow),
            active: self.active.clone(),
            bf_interior_style: named(self.bf_interior_style, InteriorStyle::Hollow),
            bf_active: self.bf_active.clone(),
            facet_distinguish: self.facet_distinguish,
            max_texture_maps: self.max_texture_maps.unwrap_or(usize::MAX),
        };
        match texture::select(&surface, self.back_facing, rules) {
            Selection::Untextured => json!({ "entries": "untextured" }),
            Selection::Default => json!({ "entries": ["default"] }),
            Selection::Entries(entries) => json!({ "entries": entries }),
        }
    }
}

impl ResolveGiven {
    fn answer(&self, rules: &Rules) -> Result<Answered, Refusal> {
        let mut table = Table::new();
        for (index, given) in &self.table {
            let index = index
                .parse()
                .map_err(|_| Refusal::Malformed(format!("table: {index:?} is no index")))?;
            table.insert(index, given.entry(rules));
        }
        Ok(texture::resolve(&table, self.index, rules).map(|entry| entry_json(&entry)))
    }
}

impl ParameterizeGiven {
    fn answer(&self, rules: &Rules) -> Result<Answered, Refusal> {
        if !(1..=3).contains(&self.dim) {
            return Err(Refusal::Malformed("dim: 1, 2 or 3".to_owned()));
        }
        let entry = self.entry.entry(rules);
        let t = texture::parameterize(&entry, &self.point.point(), self.dim, rules);
        Ok(t.map(|t| json!({ "t": numbers(&t) })))
    }
}

impl InterpolateGiven {
    fn answer(&self, rules: &Rules) -> Result<Answered, Refusal> {
        let count = self.ts.first().map_or(0, Vec::len);
        let all_one = vec![1.0; self.b.len()];
        let w = self.w.as_ref().unwrap_or(&all_one);
        let alike = self.ts.iter().all(|t| t.len() == count);
        let corners = self.ts.len() == self.b.len() && self.b.len() == w.len();
        if !(1..=3).contains(&count) || !alike || !corners {
            let wanted = "ts, b and w: as many as there are corners, 1 to 3 coordinates each";
            return Err(Refusal::Malformed(wanted.to_owned()));
        }
        let ts: Vec<Vector> = self.ts.iter().map(|t| padded(t, 0.0)).collect();
        let t = texture::interpolate(&ts, &self.b, w, self.correction.0, rules);
        Ok(t.map(|t| json!({ "t": numbers(&t[..count]) })))
    }
}

impl DepthGiven {
    fn answer(&self, rules: &Rules) -> Result<Value, Refusal> {
        let count = self.size.len();
        if !(1..=3).contains(&count) || self.dtdx.len() > 3 || self.dtdy.len() > 3 {
            return Err(Refusal::Malformed(
                "size: one number for each of 1 to 3 directions".into(),
            ));
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

impl IndexGiven {
    fn answer(&self, rules: &Rules) -> Result<Value, Refusal> {
        if !(1..=1 << 31).contains(&self.size) {
            return Err(Refusal::Malformed("size: from 1 to 2^31".to_owned()));
        }
        let index = |&t: &f64| texture::texel_index(self.boundary.0, t, self.size, rules);
        let indices: Vec<usize> = self.t.iter().map(index).collect();
        Ok(json!({ "index": indices }))
    }
}

impl ComposeGiven {
    fn answer(&self, rules: &Rules) -> Result<Value, Refusal> {
        let input = Shade {
            color: self.color,
            alpha: self.alpha,
        };
        let fetched = self.texel.fetched()?;
        let entry = self.entry.entry(rules);
        let white = self.cw.unwrap_or([1.0; 3]);
        Ok(shade_json(texture::compose(
            &entry, &fetched, input, white, rules,
        )))
    }
}

impl StageEntry {
    fn fetched(&self, entry: &Entry, rules: &Rules) -> Result<Result<Fetched, NoValue>, Refusal> {
        if let Some(texel) = &self.texel {
            return texel.fetched().map(Ok);
        }
        let map = match &self.map {
            Some(map) => map.map(rules)?,
            None => TextureMap::checkerboard(rules),
        };
        let t = match (self.t, &self.point) {
            (Some(t), _) => t,
            (None, Some(point)) => {
                match texture::parameterize(entry, &point.point(), map.dimensions(), rules) {
                    Ok(t) => texture::orient(&entry.orientation_matrix, t, rules),
                    Err(none) => return Ok(Err(none)),
                }
            }
            (None, None) => {
                return Err(Refusal::Malformed(
                    "an entry needs texel, t or point".into(),
                ));
            }
        };
        let fetched = texture::fetch(entry, &map, t, self.depth, self.mag, rules);
        Ok(Ok(fetched))
    }
}

impl StageGiven {
    fn answer(&self, rules: &Rules) -> Result<Answered, Refusal> {
        let mut maps = Vec::new();
        for given in &self.entries {
            let entry = given.entry.entry(rules);
            match given.fetched(&entry, rules)? {
                Ok(fetched) => maps.push((entry, fetched)),
                Err(none) => return Ok(Err(none)),
            }
        }
        let lit = Lit {
            surface: Shade {
                color: self.surface.color,
                alpha: self.surface.alpha,
            },
            white: self.surface.cw,
            specular: self.surface.cs,
        };
        let interpolation = named(self.interp, Interpolation::None);
        let frequency = named(self.frequency, Frequency::InterpDep);
        let shade = texture::stage(&maps, &lit, interpolation, frequency, rules);
        Ok(Ok(shade_json(shade)))
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

/// JSON has no infinities; they go as words.
fn number(value: f64) -> Value {
    match serde_json::Number::from_f64(value) {
        Some(number) => Value::Number(number),
        None => Value::String(value.to_string()),
    }
}

fn entry_json(entry: &Entry) -> Value {
    let mut fields = Map::new();
    let mut put = |name: &str, value: Value| {
        fields.insert(name.to_owned(), value);
    };
    let matrix = |matrix: &Matrix| matrix.iter().map(|row| numbers(row)).collect::<Value>();
    put("map_ids", json!(entry.map_ids));
    put("rendering_control", json!(entry.rendering_control.name()));
    put("parameterization", json!(entry.parameterization.name()));
    put("fp_data_index", json!(entry.fp_data_index));
    put("reflection_matrix", matrix(&entry.reflection_matrix));
    put("reflection_hints", json!(entry.reflection_hints));
    put("orientation_matrix", matrix(&entry.orientation_matrix));
    put("orientation_hints", json!(entry.orientation_hints));
    put("composition", json!(entry.composition.name()));
    put("channel", json!(entry.channel.name()));
    put("env_color", numbers(&entry.env_color));
    put("background_color", numbers(&entry.background_color));
    put("min_sample", json!(entry.min_sample.name()));
    put("mag_sample", json!(entry.mag_sample.name()));
    put("boundary", json!(entry.boundary.map(Boundary::name)));
    put("clamp_method", json!(entry.clamp_method.name()));
    put("clamp_color", numbers(&entry.clamp_color));
    put("depth_bias", number(entry.depth_bias));
    put("frequency", numbers(&entry.frequency));
    Value::Object(fields)
}
