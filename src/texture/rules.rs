//! The decisions that the chapter asks of its reader.
//!
//! [`Rules::SPEC`] names, for each, the function that stands with its requirement in the module of its topic. The flow calls
//! the decision and never asks why it is so: another reading of an open point, or a deliberate mistake, is another function in
//! the same place and nothing else.

use super::compose::{self, Shade, Terms};
use super::entry::{self, Boundary, Entry, Matrix, SampleMethod, Table, Vector};
use super::map::{self, Color, Texel};
use super::orient::{self, Frequency, Interpolation, Site};
use super::parameterize::{self, Place, Point};
use super::sample::{self, Fetched};
use super::select::{self, InteriorStyle, Selection, Surface};
use super::stage::{self, Lit};
use super::{NoValue, boundary, depth, from_ptm};
use crate::evaluate::Picture;

/// How the chapter is read: one decision for each thing it asks, in its order.
#[derive(Clone, Copy)]
#[allow(missing_docs)] // each is documented at the function SPEC names
pub struct Rules {
    // table
    pub(crate) fallback_values: fn() -> Entry,
    pub(crate) valid_index: fn(i64) -> bool,
    pub(crate) undefined_entry: fn(&Table, &Rules) -> Entry,
    // selection
    pub(crate) uses_back: fn(&Surface, back_facing: bool) -> bool,
    pub(crate) is_textured: fn(InteriorStyle) -> bool,
    pub(crate) empty_list: fn() -> Selection,
    pub(crate) within_limit: fn(&[i64], usize) -> Vec<i64>,
    // the default map
    pub(crate) checkerboard: fn() -> (usize, usize),
    pub(crate) is_white: fn(usize, usize) -> bool,
    // parameterization
    pub(crate) parameterize: fn(&Entry, &Point, usize, &Rules) -> Result<Vector, NoValue>,
    pub(crate) coordinates: fn(&Place) -> Option<Vector>,
    pub(crate) normal: fn(&Place) -> Option<Vector>,
    pub(crate) spline_parameters: fn(&Point) -> Vector,
    pub(crate) float_data: fn(&Point, usize, usize) -> Result<Vector, NoValue>,
    pub(crate) vrc_place: fn(&Point) -> Place,
    pub(crate) wc_place: fn(&Point) -> Place,
    pub(crate) sight: fn(eye: Vector, position: Vector) -> Vector,
    pub(crate) reflect: fn(i: Vector, n: Vector) -> Vector,
    pub(crate) turn: fn(&Matrix, Vector) -> Vector,
    pub(crate) vrc_azimuth: fn(Vector) -> f64,
    pub(crate) vrc_height: fn(Vector) -> f64,
    pub(crate) wc_azimuth: fn(Vector) -> f64,
    pub(crate) wc_height: fn(Vector) -> f64,
    // orientation, interpolation
    pub(crate) orient: fn(&Matrix, Vector) -> Vector,
    pub(crate) linear: fn(&[Vector], &[f64], &[f64]) -> Vector,
    pub(crate) hyperbolic: fn(&[Vector], &[f64], &[f64]) -> Vector,
    pub(crate) site: fn(Interpolation, Frequency) -> Site,
    // composition
    pub(crate) stage: fn(&[(Entry, Fetched)], &Lit, Interpolation, Frequency, &Rules) -> Shade,
    pub(crate) is_split: fn(Interpolation, Frequency) -> bool,
    pub(crate) add_specular: fn(Shade, Color) -> Shade,
    pub(crate) light: fn(Shade, &Lit) -> Shade,
    pub(crate) texel_color: fn(&Texel) -> Color,
    pub(crate) gamma: fn(&Entry, &Texel) -> Color,
    pub(crate) replace: fn(&Terms) -> Shade,
    pub(crate) modulate: fn(&Terms) -> Shade,
    pub(crate) blend_env_color: fn(&Terms) -> Shade,
    pub(crate) decal: fn(&Terms) -> Shade,
    pub(crate) decal_background: fn(&Terms) -> Shade,
    // sampling
    pub(crate) method: fn(&Entry, magnify: bool) -> SampleMethod,
    pub(crate) closest: fn(Boundary, f64, usize, &Rules) -> usize,
    pub(crate) neighbours: fn(Boundary, f64, usize, &Rules) -> [(usize, f64); 2],
    pub(crate) place: fn([usize; 3], [usize; 3]) -> usize,
    pub(crate) closest_level: fn(f64, usize) -> usize,
    pub(crate) levels: fn(f64, usize) -> (usize, usize, f64),
    // boundary conditions, clamp methods
    pub(crate) condition: fn(&Entry, usize) -> Boundary,
    pub(crate) is_clamped: fn(&Entry, Vector, usize, &Rules) -> bool,
    pub(crate) is_outside: fn(f64) -> bool,
    pub(crate) clamp: fn(&Entry) -> Fetched,
    pub(crate) clamp_color: fn(&Entry, &Texel, Shade, Color, &Rules) -> Shade,
    pub(crate) wrap: fn(i64, usize) -> usize,
    pub(crate) mirror: fn(i64, usize) -> usize,
    pub(crate) border: fn(i64, usize) -> usize,
    pub(crate) explicit_neighbour: fn(i64, usize) -> usize,
    // sampling hints
    pub(crate) depth: fn(&[f64], [f64; 3]) -> f64,
    pub(crate) biased: fn(f64, f64) -> f64,
    pub(crate) magnifies: fn(&[f64]) -> bool,
    // a PTM as a map
    pub(crate) rows: fn(&Picture) -> Vec<[f64; 3]>,
    pub(crate) to_eight_bits: fn(f64) -> f64,
}

impl Rules {
    /// The reading of the reference: the chapter where it speaks, and the rulings of `spec-cases/texture/rulings.yaml` where it
    /// does not.
    pub const SPEC: Rules = Rules {
        fallback_values: entry::fallback_values,
        valid_index: entry::valid_index,
        undefined_entry: entry::entry_one,
        uses_back: select::uses_back,
        is_textured: select::is_textured,
        empty_list: select::default_map,
        within_limit: select::within_limit,
        checkerboard: map::sixteen_by_two,
        is_white: map::white_at_origin,
        parameterize: parameterize::by_method,
        coordinates: parameterize::coordinates,
        normal: parameterize::normal,
        spline_parameters: parameterize::spline_parameters,
        float_data: parameterize::float_data,
        vrc_place: parameterize::in_vrc,
        wc_place: parameterize::in_wc,
        sight: parameterize::sight_from_eye,
        reflect: parameterize::reflect,
        turn: parameterize::turn,
        vrc_azimuth: parameterize::half_turns,
        vrc_height: parameterize::by_angle,
        wc_azimuth: parameterize::whole_turn,
        wc_height: parameterize::by_angle,
        orient: orient::rows_times_column,
        linear: orient::linear,
        hyperbolic: orient::hyperbolic,
        site: orient::as_often_as_lit,
        stage: stage::before_and_after,
        is_split: stage::is_split,
        add_specular: stage::add_specular,
        light: stage::light,
        texel_color: map::texel_color,
        gamma: compose::selected_channel,
        replace: compose::replace,
        modulate: compose::modulate,
        blend_env_color: compose::blend_env_color,
        decal: compose::decal,
        decal_background: compose::decal_background,
        method: sample::method,
        closest: sample::cell,
        neighbours: sample::cells_around,
        place: map::place,
        closest_level: sample::closest_level,
        levels: sample::levels_around,
        condition: boundary::condition,
        is_clamped: boundary::any_direction,
        is_outside: boundary::is_outside,
        clamp: boundary::by_clamp_method,
        clamp_color: compose::with_texel,
        wrap: boundary::wrap,
        mirror: boundary::mirror,
        border: boundary::border,
        explicit_neighbour: boundary::border,
        depth: depth::log2_of_widest,
        biased: depth::add,
        magnifies: depth::none_over_one,
        rows: from_ptm::from_the_bottom,
        to_eight_bits: from_ptm::halves_up,
    };

    /// An entry in which nothing was set.
    #[must_use]
    pub fn fallback_entry(&self) -> Entry {
        (self.fallback_values)()
    }

    /// The mirror image of a line of sight at a surface of normal `n`.
    #[must_use]
    pub fn reflected(&self, sight: Vector, n: Vector) -> Vector {
        (self.reflect)(sight, n)
    }

    /// Ruling `texel-grid`, the other reading: the first and the last texel are the points 0 and 1.
    #[must_use]
    pub const fn with_points(self) -> Rules {
        Rules {
            closest: sample::point,
            neighbours: sample::points_around,
            ..self
        }
    }

    /// Ruling `gamma`, the other reading: the texel's color blends, component by component.
    #[must_use]
    pub const fn with_vector_gamma(self) -> Rules {
        Rules {
            gamma: compose::whole_color,
            ..self
        }
    }

    /// Ruling `clamp-color`, the other reading: the clamp color is the result.
    #[must_use]
    pub const fn with_clamp_color_alone(self) -> Rules {
        Rules {
            clamp_color: compose::clamp_color_alone,
            ..self
        }
    }

    /// Ruling `vrc-azimuth`, another reading: t0 grows to the left.
    #[must_use]
    pub const fn with_leftward_azimuth(self) -> Rules {
        Rules {
            vrc_azimuth: parameterize::half_turns_leftward,
            ..self
        }
    }

    /// Ruling `vrc-azimuth`, another reading: t0 grows with x.
    #[must_use]
    pub const fn with_cosine_azimuth(self) -> Rules {
        Rules {
            vrc_azimuth: parameterize::along_x,
            ..self
        }
    }

    /// Ruling `vrc-azimuth`, another reading: the rear half mirrors the front half.
    #[must_use]
    pub const fn with_rear_mirrored(self) -> Rules {
        Rules {
            vrc_azimuth: parameterize::rear_mirrored,
            ..self
        }
    }

    /// Ruling `vrc-height`, another reading: t1 grows with y.
    #[must_use]
    pub const fn with_vrc_height_by_y(self) -> Rules {
        Rules {
            vrc_height: parameterize::by_y,
            ..self
        }
    }

    /// Ruling `vrc-height`, another reading: t1 grows downward.
    #[must_use]
    pub const fn with_vrc_downward(self) -> Rules {
        Rules {
            vrc_height: parameterize::downward,
            ..self
        }
    }

    /// Ruling `wc-azimuth`, the other reading: clockwise.
    #[must_use]
    pub const fn with_clockwise(self) -> Rules {
        Rules {
            wc_azimuth: parameterize::whole_turn_clockwise,
            ..self
        }
    }

    /// Ruling `wc-height`, another reading: t1 grows with y.
    #[must_use]
    pub const fn with_wc_height_by_y(self) -> Rules {
        Rules {
            wc_height: parameterize::by_y,
            ..self
        }
    }

    /// Ruling `wc-height`, another reading: t1 grows downward.
    #[must_use]
    pub const fn with_wc_downward(self) -> Rules {
        Rules {
            wc_height: parameterize::downward,
            ..self
        }
    }

    /// Ruling `ptm-texels`, the other reading: texels of a PTM are real numbers always.
    #[must_use]
    pub const fn with_real_texels(self) -> Rules {
        Rules {
            to_eight_bits: from_ptm::kept,
            ..self
        }
    }
}
