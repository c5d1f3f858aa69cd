//! Primitives: surfaces, their points, and the colors in the pipeline.

use std::fmt;
use std::str::FromStr;

use super::entry::{Color, Entry, Vector, enumerants};
use super::map::Texel;

enumerants! {
    /// The style in which the inside of a surface is drawn.
    InteriorStyle ["PEXInteriorStyle"] {
        /// Edges only.
        Hollow,
        /// One color.
        Solid,
        /// A pattern.
        Pattern,
        /// Lines.
        Hatch,
        /// Nothing.
        Empty,
        /// Texture maps.
        Texture,
    }
}

/// A facet, and the part of the pipeline's state that selects its textures.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "harness", derive(serde::Deserialize))]
#[cfg_attr(feature = "harness", serde(default, deny_unknown_fields))]
pub struct Surface {
    /// The style of both sides, or of the front.
    pub interior_style: InteriorStyle,
    /// Active textures: indices of the table.
    pub active: Vec<i64>,
    /// The style of the back, if facets are distinguished.
    pub bf_interior_style: InteriorStyle,
    /// Active textures of the back.
    pub bf_active: Vec<i64>,
    /// True if back-facing facets have separate attributes.
    pub facet_distinguish: bool,
    /// True if the back of the facet is seen.
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

/// The textures that are applied to a facet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Selection {
    /// No texture.
    Untextured,
    /// The default map, with fallback values.
    Default,
    /// These entries, in this order.
    Entries(Vec<i64>),
}

/// A vertex in one coordinate system.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Place {
    /// The position of the vertex.
    pub position: Option<Vector>,
    /// The position of the eye.
    pub eye: Option<Vector>,
    /// The normal that came with the vertex.
    pub normal: Option<Vector>,
    /// The normal of the facet, computed.
    pub geometric_normal: Option<Vector>,
}

/// A point of a B-spline surface.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "harness", derive(serde::Deserialize))]
#[cfg_attr(feature = "harness", serde(default))]
pub struct SplinePoint {
    /// The first parameter.
    pub u: f64,
    /// The second parameter.
    pub v: f64,
    /// The values of each data spline at this point.
    #[cfg_attr(feature = "harness", serde(rename = "data_splines"))]
    pub data: Vec<Vec<f64>>,
}

/// All values from which coordinates may be derived. Values that a method does not need may be missing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Point {
    /// In modeling coordinates.
    pub mc: Place,
    /// In world coordinates.
    pub wc: Place,
    /// In view reference coordinates.
    pub vrc: Place,
    /// The vertex's floating-point data.
    pub fp_data: Vec<f64>,
    /// The point of the B-spline surface, if the primitive is one.
    pub spline: Option<SplinePoint>,
    /// The unit vector from the eye, if it is known without eye and position.
    pub sight: Option<Vector>,
    /// The reflection vector, if it is known without sight and normal.
    pub reflection: Option<Vector>,
}

enumerants! {
    /// The interpolation of coordinates in a perspective view.
    Correction ["PEXTMPerspectiveCorrection"] {
        /// Linearly on the screen.
        None,
        /// Corrected at the vertices.
        Vertex,
        /// Corrected at every pixel.
        Pixel,
    }
}

enumerants! {
    /// The interpolation of a surface's colors.
    Interpolation ["PEXSurfaceInterp"] {
        /// One color per facet.
        None,
        /// Colors of the vertices.
        Color,
        /// Dot products of the reflectance equations.
        DotProduct,
        /// Normals.
        Normal,
    }
}

enumerants! {
    /// The frequency at which a texture is sampled.
    Frequency ["PEXTMSampleFrequency"] {
        /// At every pixel.
        Pixel,
        /// At the frequency of the reflectance calculation.
        InterpDep,
    }
}

enumerants! {
    /// The places where a texture is sampled.
    Site [] {
        /// Once per facet.
        Facet,
        /// At every vertex.
        Vertex,
        /// At every pixel.
        Pixel,
    }
}

/// The result of sampling a map.
#[derive(Clone, Debug, PartialEq)]
pub enum Fetched {
    /// A value to compose with.
    Texel(Texel),
    /// The clamp color, in place of a texel.
    Clamped(Texel),
    /// Nothing: the map is not applied here.
    Discontinued,
}

impl Fetched {
    /// Returns its components, if it has any.
    #[must_use]
    pub fn components(&self) -> Option<&[f64]> {
        match self {
            Fetched::Texel(texel) | Fetched::Clamped(texel) => Some(texel.components()),
            Fetched::Discontinued => None,
        }
    }
}

/// The color of a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shade {
    /// Red, green, blue.
    pub color: Color,
    /// Opacity.
    pub alpha: f64,
}

/// The terms of an equation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terms<'a> {
    /// C and A: the primitive.
    pub input: Shade,
    /// W: the light on a white surface, or white.
    pub white: Color,
    /// T: the map's color.
    pub color: Color,
    /// AT: the map's alpha, if it has one.
    pub alpha: Option<f64>,
    /// Γ.
    pub gamma: Color,
    /// The entry, for E and B.
    pub entry: &'a Entry,
}

/// A primitive and the light on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lit {
    /// The primitive before any light.
    pub surface: Shade,
    /// CW: ambient and diffuse light on a white surface (R-CMP-08).
    pub white: Color,
    /// CS: the specular part (R-CMP-11).
    pub specular: Color,
}
