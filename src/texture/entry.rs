//! Table entries: the attributes and their fallback values.
//!
//! An entry binds attributes to a texture map resource (R-TBL-01). A field that is not set has its fallback value
//! (R-TBL-03 … R-TBL-17).
//!
//! Format notes
//! - The entry of fallback values uses a reflection parameterization: it needs an eye and a normal even on a flat surface.
//! - Notes a to g under the table say which fields count only together with others; the stages of the pipeline
//!   ignore the rest.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// Red, green and blue; values from 0 to 1 can be displayed.
pub type Color = [f64; 3];

/// Three coordinates, of a point, a direction or a texture map.
pub type Vector = [f64; 3];

/// Four rows of four; it multiplies columns (ruling `matrix-storage`).
pub type Matrix = [[f64; 4]; 4];

pub(super) const IDENTITY: Matrix = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
];

/// Declares the enumerants of a field: the short name is that of the chapter without its prefix; parsing accepts it with any of
/// the prefixes or with none.
macro_rules! enumerants {
    ($(#[$about:meta])* $name:ident [$($prefix:literal)*] { $($(#[$says:meta])* $variant:ident,)+ }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "harness", derive(serde::Deserialize, serde::Serialize))]
        #[cfg_attr(feature = "harness", serde(try_from = "String"))]
        pub enum $name { $($(#[$says])* $variant,)+ }

        impl $name {
            /// Every enumerant, in the order of the chapter.
            pub const ALL: &[$name] = &[$($name::$variant,)+];

            /// Returns the chapter's name without its prefix.
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
            type Error = String;

            fn try_from(text: String) -> Result<$name, String> {
                text.parse()
            }
        }

        impl FromStr for $name {
            type Err = String;

            fn from_str(text: &str) -> Result<$name, String> {
                let prefixes: &[&str] = &[$($prefix,)* ""];
                let bare = prefixes.iter().filter_map(|prefix| text.strip_prefix(prefix));
                let mut named = bare.filter_map(|bare| {
                    // Notes f and g say ClampExplicitMethod.
                    let bare = bare.strip_suffix("Method").unwrap_or(bare);
                    $name::ALL.iter().copied().find(|one| one.name() == bare)
                });
                named.next().ok_or_else(|| {
                    let known: Vec<&str> = $name::ALL.iter().map(|one| one.name()).collect();
                    format!("expected one of {}, found {text:?}", known.join(", "))
                })
            }
        }
    };
}
pub(super) use enumerants;

enumerants! {
    /// The stage of the pipeline at which the map is applied (R-RCT-01).
    RenderingControl ["PEXTMRenderingControl" "PEXTMRC"] {
        /// Before the reflectance calculation (R-RCT-04).
        PreLight,
        /// After the reflectance calculation (R-RCT-05).
        PostLight,
    }
}

enumerants! {
    /// The source of texture coordinates (R-PAR-01).
    Parameterization ["PEXTMParam" "PEXTMPM"] {
        /// The vertex in modeling coordinates.
        VertexMCCoord,
        /// The vertex in world coordinates.
        VertexWCCoord,
        /// The vertex normal in modeling coordinates.
        VertexMCNormal,
        /// The vertex normal in world coordinates.
        VertexWCNormal,
        /// The parameters of a B-spline surface.
        NURBUV,
        /// The vertex's floating-point data.
        FloatData,
        /// A reflection vector on a sphere, in view reference coordinates.
        ReflectionSphereVRC,
        /// A reflection vector on a sphere, in world coordinates.
        ReflectionSphereWC,
    }
}

enumerants! {
    /// The combination of the map's color with that of the primitive (R-CMP-02).
    Composition ["PEXTMComp" "PEXTMCM"] {
        /// The map replaces the primitive.
        Replace,
        /// Product of both.
        Modulate,
        /// Primitive and environment color, blended by the map.
        BlendEnvColor,
        /// The map over the primitive, by the map's alpha.
        Decal,
        /// The map over the background color, by the map's alpha.
        DecalBackground,
    }
}

enumerants! {
    /// The component that blends in the environment color.
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
    /// A method of sampling texels (R-SMP-01).
    SampleMethod ["PEXTMSample" "PEXTMSM"] {
        /// The closest texel of the base level.
        SingleBase,
        /// A weighted average of the closest texels of the base level.
        WeightedBase,
        /// The closest texel of the closest level.
        SingleInMipmap,
        /// A weighted average of the closest texels of the closest level.
        WeightedInMipmap,
        /// The closest texels of the two closest levels, interpolated.
        SingleBetweenMipmaps,
        /// Weighted averages of the two closest levels, interpolated.
        WeightedBetweenMipmaps,
    }
}

enumerants! {
    /// The treatment of coordinates beyond an edge of the map, in one direction (R-BND-01).
    Boundary ["PEXTMBoundary" "PEXTMBC"] {
        /// The clamp method.
        ClampExplicit,
        /// The closest texel of the edge.
        ClampBorder,
        /// The map repeated.
        Wrap,
        /// The map repeated, alternately reversed.
        Mirror,
    }
}

enumerants! {
    /// The effect of [`Boundary::ClampExplicit`] outside (R-CLM-01).
    ClampMethod ["PEXTMBoundaryClampExplicit" "PEXTMBCM"] {
        /// The map is not applied.
        Discontinue,
        /// The clamp color is applied.
        Color,
    }
}

/// An entry of the table.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "harness", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "harness", serde(default, deny_unknown_fields))]
// The name that error messages of questions use.
#[cfg_attr(feature = "harness", serde(expecting = "struct EntryGiven"))]
pub struct Entry {
    /// The resources that define the map, by name; none means the default map (R-SEL-11).
    pub map_ids: Vec<u32>,
    /// Application of the map before or after the light.
    pub rendering_control: RenderingControl,
    /// The source of coordinates.
    pub parameterization: Parameterization,
    /// The index of the first datum for [`Parameterization::FloatData`] (note a).
    pub fp_data_index: usize,
    /// The transform of reflection vectors (note b).
    pub reflection_matrix: Matrix,
    /// Hints for optimization; ignored (R-PAR-12).
    pub reflection_hints: String,
    /// The transform of coordinates (R-ORI-01).
    pub orientation_matrix: Matrix,
    /// Hints for optimization; ignored (R-ORI-02).
    pub orientation_hints: String,
    /// The composition of colors.
    pub composition: Composition,
    /// The channel that blends in the environment color (note c).
    pub channel: Channel,
    /// For [`Composition::BlendEnvColor`] (note d).
    pub env_color: Color,
    /// For [`Composition::DecalBackground`] (note e).
    pub background_color: Color,
    /// The method for pixels that cover more than a texel.
    pub min_sample: SampleMethod,
    /// The method for pixels that cover less than a texel.
    pub mag_sample: SampleMethod,
    /// Boundary conditions in the directions t0, t1, t2.
    pub boundary: [Boundary; 3],
    /// For [`Boundary::ClampExplicit`] (note f).
    pub clamp_method: ClampMethod,
    /// For [`ClampMethod::Color`] (note g).
    pub clamp_color: Color,
    /// Number of levels to move away from the base.
    pub depth_bias: f64,
    /// From above 0 to 1 for the directions t0, t1, t2; values below 1 reduce blur.
    pub frequency: [f64; 3],
}

impl Default for Entry {
    /// Returns the fallback values (R-TBL-03 … R-TBL-17).
    fn default() -> Entry {
        fallback_values()
    }
}

/// Returns the fallback column of the table, from the top (R-TBL-03 … R-TBL-17).
pub(crate) fn fallback_values() -> Entry {
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

/// The defined entries, by index.
pub type Table = BTreeMap<i64, Entry>;
