//! Table entries: attributes and their fallback values.
//!
//! An entry binds attributes to a texture map resource (R-TBL-01). Unset fields have fallback values (R-TBL-03 … R-TBL-17).
//!
//! Format notes
//! - The entry with all fallback values uses a reflection parameterization, so it needs an eye and a normal even on a flat
//!   surface.
//! - Notes a to g below the chapter's table state which fields are used only in combination with other fields. The pipeline
//!   ignores fields that are not used.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// Red, green and blue. Values from 0 to 1 can be displayed.
pub type Color = [f64; 3];

/// Three coordinates: of a point, of a direction, or in a texture map.
pub type Vector = [f64; 3];

/// Row-major 4×4 matrix that is multiplied by column vectors (ruling `matrix-storage`).
pub type Matrix = [[f64; 4]; 4];

pub const IDENTITY: Matrix = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
];

/// Declares an enumeration. The name of a variant is the name in the chapter without its prefix. Parsing accepts names with
/// any of the prefixes or without a prefix.
macro_rules! enumerants {
    ($(#[$about:meta])* $name:ident [$($prefix:literal)*] { $($(#[$says:meta])* $variant:ident,)+ }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[derive(serde::Deserialize, serde::Serialize)]
        #[serde(try_from = "String")]
        pub enum $name { $($(#[$says])* $variant,)+ }

        impl $name {
            /// All enumerants, in the order of the chapter.
            pub const ALL: &[$name] = &[$($name::$variant,)+];

            /// Returns the name in the chapter without its prefix.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $($name::$variant => stringify!($variant),)+ }
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name())
            }
        }

        impl TryFrom<String> for $name {
            type Error = $crate::Error;

            fn try_from(text: String) -> Result<$name, $crate::Error> {
                text.parse()
            }
        }

        impl FromStr for $name {
            type Err = $crate::Error;

            fn from_str(text: &str) -> Result<$name, $crate::Error> {
                let prefixes: &[&str] = &[$($prefix,)* ""];
                let bare = prefixes.iter().filter_map(|prefix| text.strip_prefix(prefix));
                let mut named = bare.filter_map(|bare| {
                    // Notes f and g use the name ClampExplicitMethod.
                    let bare = bare.strip_suffix("Method").unwrap_or(bare);
                    $name::ALL.iter().copied().find(|one| one.name() == bare)
                });
                named.next().ok_or_else(|| $crate::Error::UnknownName {
                    known: $name::ALL.iter().map(|one| one.name()).collect(),
                    found: text.to_owned(),
                })
            }
        }
    };
}
pub(super) use enumerants;

enumerants! {
    /// Stage of the pipeline at which the map is applied (R-RCT-01).
    RenderingControl ["PEXTMRenderingControl" "PEXTMRC"] {
        /// The map is applied before the reflectance calculation (R-RCT-04).
        PreLight,
        /// The map is applied after the reflectance calculation (R-RCT-05).
        PostLight,
    }
}

enumerants! {
    /// Source of texture coordinates (R-PAR-01).
    Parameterization ["PEXTMParam" "PEXTMPM"] {
        /// Vertex position in modeling coordinates.
        VertexMCCoord,
        /// Vertex position in world coordinates.
        VertexWCCoord,
        /// Vertex normal in modeling coordinates.
        VertexMCNormal,
        /// Vertex normal in world coordinates.
        VertexWCNormal,
        /// Parameters of a B-spline surface.
        NURBUV,
        /// Floating-point data of the vertex.
        FloatData,
        /// Reflection vector on a sphere, in view reference coordinates.
        ReflectionSphereVRC,
        /// Reflection vector on a sphere, in world coordinates.
        ReflectionSphereWC,
    }
}

enumerants! {
    /// Method of combining the color of the map with the color of the primitive (R-CMP-02).
    Composition ["PEXTMComp" "PEXTMCM"] {
        /// The color of the map replaces the color of the primitive.
        Replace,
        /// The colors of the map and the primitive are multiplied.
        Modulate,
        /// The color of the primitive is blended with the environment color, weighted by the map.
        BlendEnvColor,
        /// The map is drawn over the primitive, weighted by the alpha of the map.
        Decal,
        /// The map is drawn over the background color, weighted by the alpha of the map.
        DecalBackground,
    }
}

enumerants! {
    /// Component of a texel that controls the blending of the environment color.
    Channel ["PEXTMChannel"] {
        /// Channel 0 (R-CHN-01).
        Red,
        /// Channel 1 (R-CHN-02).
        Green,
        /// Channel 2 (R-CHN-03).
        Blue,
        /// Channel 3 (R-CHN-04).
        Alpha,
    }
}

enumerants! {
    /// Method of sampling texels (R-SMP-01).
    SampleMethod ["PEXTMSample" "PEXTMSM"] {
        /// Use the closest texel of the base level.
        SingleBase,
        /// Use a weighted average of the closest texels of the base level.
        WeightedBase,
        /// Use the closest texel of the closest level.
        SingleInMipmap,
        /// Use a weighted average of the closest texels of the closest level.
        WeightedInMipmap,
        /// Interpolate between the closest texels of the two closest levels.
        SingleBetweenMipmaps,
        /// Interpolate between weighted averages of the two closest levels.
        WeightedBetweenMipmaps,
    }
}

enumerants! {
    /// Treatment of coordinates outside the map in one direction (R-BND-01).
    Boundary ["PEXTMBoundary" "PEXTMBC"] {
        /// Apply the clamp method.
        ClampExplicit,
        /// Use the closest texel at the edge.
        ClampBorder,
        /// Repeat the map.
        Wrap,
        /// Repeat the map, mirroring every second copy.
        Mirror,
    }
}

enumerants! {
    /// Effect of [`Boundary::ClampExplicit`] outside the map (R-CLM-01).
    ClampMethod ["PEXTMBoundaryClampExplicit" "PEXTMBCM"] {
        /// The map is not applied.
        Discontinue,
        /// The clamp color is applied.
        Color,
    }
}

/// Entry of the texture mapping table.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(default, deny_unknown_fields)]
// Error messages about questions use this name.
#[serde(expecting = "struct GivenEntry")]
pub struct Entry {
    /// Ids of the resources that define the map; empty for the default map (R-SEL-11).
    pub map_ids: Vec<u32>,
    /// Stage at which the map is applied.
    pub rendering_control: RenderingControl,
    /// Source of texture coordinates.
    pub parameterization: Parameterization,
    /// Index of the first datum for [`Parameterization::FloatData`] (note a).
    pub fp_data_index: usize,
    /// Transform of reflection vectors (note b).
    pub reflection_matrix: Matrix,
    /// Optimization hints; ignored (R-PAR-12).
    pub reflection_hints: String,
    /// Transform of texture coordinates (R-ORI-01).
    pub orientation_matrix: Matrix,
    /// Optimization hints; ignored (R-ORI-02).
    pub orientation_hints: String,
    /// Method of combining colors.
    pub composition: Composition,
    /// Channel that controls the blending of the environment color (note c).
    pub channel: Channel,
    /// Environment color for [`Composition::BlendEnvColor`] (note d).
    pub env_color: Color,
    /// Background color for [`Composition::DecalBackground`] (note e).
    pub background_color: Color,
    /// Sampling method for pixels that cover more than one texel.
    pub min_sample: SampleMethod,
    /// Sampling method for pixels that cover less than one texel.
    pub mag_sample: SampleMethod,
    /// Boundary conditions for the directions t0, t1 and t2.
    pub boundary: [Boundary; 3],
    /// Clamp method for [`Boundary::ClampExplicit`] (note f).
    pub clamp_method: ClampMethod,
    /// Clamp color for [`ClampMethod::Color`] (note g).
    pub clamp_color: Color,
    /// Number of levels by which sampling moves away from the base.
    pub depth_bias: f64,
    /// Frequency hints for the directions t0, t1 and t2, greater than 0 and at most 1. Values below 1 reduce blur.
    pub frequency: [f64; 3],
}

impl Default for Entry {
    /// Returns the fallback values (R-TBL-03 … R-TBL-17).
    fn default() -> Entry {
        fallback_values()
    }
}

/// Returns the fallback values of all fields, in the order of the table (R-TBL-03 … R-TBL-17).
pub fn fallback_values() -> Entry {
    Entry {
        map_ids: Vec::new(),
        rendering_control: RenderingControl::PostLight,
        parameterization: Parameterization::ReflectionSphereVRC,
        fp_data_index: 0,
        reflection_matrix: IDENTITY,
        reflection_hints: "Identity".to_owned(),
        orientation_matrix: IDENTITY,
        orientation_hints: "Identity".to_owned(),
        composition: Composition::Replace,
        channel: Channel::Red,
        env_color: [0.0; 3],
        background_color: [0.0; 3],
        min_sample: SampleMethod::SingleBase,
        mag_sample: SampleMethod::SingleBase,
        boundary: [Boundary::Wrap; 3],
        clamp_method: ClampMethod::Discontinue,
        clamp_color: [0.0; 3],
        depth_bias: 0.0,
        frequency: [1.0; 3],
    }
}

/// Defined entries by index.
pub type Table = BTreeMap<i64, Entry>;
