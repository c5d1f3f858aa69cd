//! Decisions that an implementation of the chapter has to make.
//!
//! For each decision, [`Rules::SPEC`] contains the function that implements the requirement. The pipeline calls these functions
//! only through [`Rules`], so replacing one implements an alternative reading or a deliberate mistake.

use super::entry::{Boundary, Color, Entry, Matrix, SampleMethod, Table, Vector};
use super::map::{CellPair, Texel, TextureMap};
use super::no_value::NoValue;
use super::primitive::{
    Frequency, InteriorStyle, Interpolation, LitPrimitive, MapValue, Point, Selection, Shade, Site,
    Surface, Terms, VertexData,
};
use ptm::evaluate::RelitImage;

/// Reading of the chapter: one function per decision, in the order of the chapter.
#[derive(Clone, Copy)]
#[allow(missing_docs)] // each field is documented at its function in SPEC
pub struct Rules {
    // table
    pub fallback_values: fn() -> Entry,
    pub is_valid_index: fn(i64) -> bool,
    pub undefined_entry: fn(&Table, &Rules) -> Entry,
    // selection
    pub uses_back: fn(&Surface) -> bool,
    pub is_textured: fn(InteriorStyle) -> bool,
    pub empty_list: fn() -> Selection,
    pub within_limit: fn(&[i64], usize) -> Vec<i64>,
    // the default map
    pub checkerboard: fn() -> (usize, usize),
    pub is_white: fn(usize, usize) -> bool,
    // parameterization
    pub parameterize: fn(&Entry, &Point, usize, &Rules) -> Result<Vector, NoValue>,
    pub normal: fn(&VertexData) -> Option<Vector>,
    pub spline_parameters: fn(&Point) -> Vector,
    pub float_data: fn(&Point, usize, usize) -> Result<Vector, NoValue>,
    pub vrc_vertex: fn(&Point) -> VertexData,
    pub wc_vertex: fn(&Point) -> VertexData,
    pub sight: fn(eye: Vector, position: Vector) -> Vector,
    pub reflect: fn(i: Vector, n: Vector) -> Vector,
    pub rotate: fn(&Matrix, Vector) -> Vector,
    pub vrc_azimuth: fn(Vector) -> f64,
    pub vrc_height: fn(Vector) -> f64,
    pub wc_azimuth: fn(Vector) -> f64,
    pub wc_height: fn(Vector) -> f64,
    // orientation, interpolation
    pub orient: fn(&Matrix, Vector) -> Vector,
    pub linear: fn(&[Vector], &[f64], &[f64]) -> Vector,
    pub hyperbolic: fn(&[Vector], &[f64], &[f64]) -> Vector,
    pub site: fn(Interpolation, Frequency) -> Site,
    // composition
    pub stage: fn(&[(Entry, MapValue)], &LitPrimitive, Interpolation, Frequency, &Rules) -> Shade,
    pub add_specular: fn(Shade, Color) -> Shade,
    pub light: fn(Shade, &LitPrimitive) -> Shade,
    pub texel_color: fn(&Texel) -> Color,
    pub gamma: fn(&Entry, &Texel) -> Color,
    pub replace: fn(&Terms) -> Shade,
    pub modulate: fn(&Terms) -> Shade,
    pub blend_env_color: fn(&Terms) -> Shade,
    pub decal: fn(&Terms) -> Shade,
    pub decal_background: fn(&Terms) -> Shade,
    // texels
    pub stored_component: fn(f64) -> f64,
    // sampling
    pub is_magnified: fn(spans: &[f64], bias: f64) -> bool,
    pub method: fn(&Entry, magnify: bool) -> SampleMethod,
    pub closest: fn(Boundary, f64, usize, &Rules) -> usize,
    pub neighbors: fn(Boundary, f64, usize, &Rules) -> CellPair,
    pub corner_weights: fn(&[[f64; 2]; 3]) -> [f64; 8],
    pub offset: fn([usize; 3], [usize; 3]) -> usize,
    pub closest_level: fn(f64, usize) -> usize,
    pub levels: fn(f64, usize) -> (usize, usize, f64),
    // boundary conditions, clamp methods
    pub condition: fn(&Entry, usize) -> Boundary,
    pub is_clamped: fn(&Entry, Vector, usize, &Rules) -> bool,
    pub is_outside: fn(f64) -> bool,
    pub outside: fn(&Entry, &TextureMap, Vector, SampleMethod, &Rules) -> MapValue,
    pub clamp: fn(&Entry) -> MapValue,
    pub clamp_color: fn(&Entry, &Texel, Shade, Color, &Rules) -> Shade,
    pub wrap: fn(i64, usize) -> usize,
    pub mirror: fn(i64, usize) -> usize,
    pub border: fn(i64, usize) -> usize,
    // a PTM as a map
    pub rows: fn(&RelitImage) -> Vec<[f64; 3]>,
    pub to_eight_bits: fn(f64) -> f64,
}
