//! Primitives: surfaces, their points, and the colors in the pipeline.

use std::fmt;
use std::str::FromStr;

use super::entry::{Color, Entry, Vector, enumerants};
use super::map::Texel;

enumerants! {
    /// Style in which the interior of a surface is drawn.
    InteriorStyle ["PEXInteriorStyle"] {
        /// Only edges are drawn.
        Hollow,
        /// The interior has one color.
        Solid,
        /// The interior is filled with a pattern.
        Pattern,
        /// The interior is filled with lines.
        Hatch,
        /// Nothing is drawn.
        Empty,
        /// Texture maps are applied.
        Texture,
    }
}

/// Facet, with the part of the pipeline state that selects its textures.
#[derive(Clone, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Surface {
    /// Style of the front, or of both sides if front and back are not distinguished.
    pub interior_style: InteriorStyle,
    /// Table indices of the active textures.
    pub active: Vec<i64>,
    /// Style of the back, if front and back are distinguished.
    pub bf_interior_style: InteriorStyle,
    /// Table indices of the active textures of the back.
    pub bf_active: Vec<i64>,
    /// True if back-facing facets have separate attributes.
    pub facet_distinguish: bool,
    /// True if the back of the facet is visible.
    pub back_facing: bool,
    /// Maximum number of maps on a facet (R-SEL-05).
    pub max_texture_maps: usize,
}

impl Default for Surface {
    fn default() -> Surface {
        Surface {
            interior_style: InteriorStyle::Hollow,
            active: Vec::new(),
            bf_interior_style: InteriorStyle::Hollow,
            bf_active: Vec::new(),
            facet_distinguish: false,
            back_facing: false,
            max_texture_maps: usize::MAX,
        }
    }
}

/// Textures that are applied to a facet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Selection {
    /// No texture is applied.
    Untextured,
    /// The default map is applied with fallback values.
    Default,
    /// The entries with these indices are applied in order.
    Entries(Vec<i64>),
}

/// Vertex in a particular coordinate system.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexData {
    /// Position of the vertex.
    pub position: Option<Vector>,
    /// Position of the eye.
    pub eye: Option<Vector>,
    /// Normal that is specified for the vertex.
    pub normal: Option<Vector>,
    /// Computed normal of the facet.
    pub geometric_normal: Option<Vector>,
}

/// Point on a B-spline surface.
#[derive(Clone, Debug, Default, PartialEq, serde::Deserialize)]
#[serde(default)]
pub struct SplinePoint {
    /// First surface parameter.
    pub u: f64,
    /// Second surface parameter.
    pub v: f64,
    /// Values of each data spline at this point.
    #[serde(rename = "data_splines")]
    pub data: Vec<Vec<f64>>,
}

/// Values from which texture coordinates can be derived. Values that the parameterization method does not need may be missing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Point {
    /// Vertex in modeling coordinates.
    pub mc: VertexData,
    /// Vertex in world coordinates.
    pub wc: VertexData,
    /// Vertex in view reference coordinates.
    pub vrc: VertexData,
    /// Floating-point data of the vertex.
    pub fp_data: Vec<f64>,
    /// Point on the surface, if the primitive is a B-spline surface.
    pub spline: Option<SplinePoint>,
    /// Unit vector from the eye to the vertex, if given directly.
    pub sight: Option<Vector>,
    /// Reflection vector, if given directly.
    pub reflection: Option<Vector>,
}

enumerants! {
    /// Correction of interpolated coordinates in a perspective view.
    Correction ["PEXTMPerspectiveCorrection"] {
        /// No correction: coordinates are interpolated linearly on the screen.
        None,
        /// Coordinates are corrected at the vertices.
        Vertex,
        /// Coordinates are corrected at every pixel.
        Pixel,
    }
}

enumerants! {
    /// Interpolation of the colors of a surface.
    Interpolation ["PEXSurfaceInterp"] {
        /// Each facet has one color.
        None,
        /// Colors of the vertices are interpolated.
        Color,
        /// The dot products in the reflectance equations are interpolated.
        DotProduct,
        /// Normals are interpolated.
        Normal,
    }
}

enumerants! {
    /// Frequency at which a texture is sampled.
    Frequency ["PEXTMSampleFrequency"] {
        /// At every pixel.
        Pixel,
        /// As often as the reflectance calculation is performed.
        InterpDep,
    }
}

enumerants! {
    /// Site at which a texture is sampled.
    Site [] {
        /// Once per facet.
        Facet,
        /// At every vertex.
        Vertex,
        /// At every pixel.
        Pixel,
    }
}

/// Result of sampling a map.
#[derive(Clone, Debug, PartialEq)]
pub enum MapValue {
    /// Sampled texel.
    Texel(Texel),
    /// Clamp color, used instead of a texel.
    Clamped(Texel),
    /// No value; the map is not applied.
    Discontinued,
}

impl MapValue {
    /// Returns the components of the texel or clamp color, if there is one.
    #[must_use]
    pub fn components(&self) -> Option<&[f64]> {
        match self {
            MapValue::Texel(texel) | MapValue::Clamped(texel) => Some(texel.components()),
            MapValue::Discontinued => None,
        }
    }
}

/// Color and opacity of a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shade {
    /// Red, green and blue.
    pub color: Color,
    /// Opacity.
    pub alpha: f64,
}

/// Terms of the composition equations.
#[derive(Clone, Copy, Debug)]
pub struct Terms<'a> {
    /// C and A: color and alpha of the primitive.
    pub input: Shade,
    /// W: light on a white surface in the split form, or white in the direct form.
    pub white: Color,
    /// T: color of the map.
    pub color: Color,
    /// AT: alpha of the map, if it has alpha.
    pub alpha: Option<f64>,
    /// Γ: blending factor per channel.
    pub gamma: Color,
    /// Table entry, which contains E and B.
    pub entry: &'a Entry,
}

/// Primitive and the light on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitPrimitive {
    /// Primitive before lighting.
    pub surface: Shade,
    /// CW: ambient and diffuse light on a white surface (R-CMP-08).
    pub white: Color,
    /// CS: specular light (R-CMP-11).
    pub specular: Color,
}
