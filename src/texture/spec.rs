//! The reading of the reference, and the other readings of the open points of the chapter.

use super::entry::{self, Entry, Vector};
use super::rules::Rules;
use super::{
    boundary, checkerboard, compose, depth, from_ptm, map, orient, parameterize, sample, select,
    stage, table,
};

impl Rules {
    /// The reading of the reference: the chapter, and the rulings of `spec-cases/texture/rulings.yaml` where it is silent.
    pub const SPEC: Rules = Rules {
        fallback_values: entry::fallback_values,
        valid_index: table::valid_index,
        undefined_entry: table::entry_one,
        uses_back: select::uses_back,
        is_textured: select::is_textured,
        empty_list: select::default_map,
        within_limit: select::within_limit,
        checkerboard: checkerboard::sixteen_by_two,
        is_white: checkerboard::white_at_origin,
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
        neighbors: sample::cells_around,
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
        explicit_neighbor: boundary::border,
        depth: depth::log2_of_widest,
        biased: depth::add,
        magnifies: depth::none_over_one,
        rows: from_ptm::rows_from_bottom,
        to_eight_bits: from_ptm::halves_up,
    };

    /// Returns an entry in which no field was set.
    #[must_use]
    pub fn fallback_entry(&self) -> Entry {
        (self.fallback_values)()
    }

    /// Reflects a line of sight at a surface with normal `n`.
    #[must_use]
    pub fn reflected(&self, sight: Vector, n: Vector) -> Vector {
        (self.reflect)(sight, n)
    }

    /// Ruling `texel-grid`, the other reading: the first and the last texel are the points 0 and 1.
    #[must_use]
    pub const fn with_points(self) -> Rules {
        Rules {
            closest: sample::point,
            neighbors: sample::points_around,
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

    /// Ruling `ptm-texels`, the other reading: texels of a PTM are always real numbers.
    #[must_use]
    pub const fn with_real_texels(self) -> Rules {
        Rules {
            to_eight_bits: from_ptm::unrounded,
            ..self
        }
    }
}
