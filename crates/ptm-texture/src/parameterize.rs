//! Parameterization controls: sources of texture coordinates.
//!
//! Four methods use the vertex or its normal, in modeling or world coordinates (R-PAR-13 … R-PAR-18). One method uses the
//! parameters of a B-spline surface (R-PAR-19, R-PAR-20), and one uses the data of the vertex (R-PAR-21 … R-PAR-25). Two methods
//! reflect the line of sight and project the result onto a sphere around the y axis (R-PAR-06 … R-PAR-12, R-PAR-26 … R-PAR-37).
//!
//! Format notes
//! - Components that a method does not provide are 0.
//! - `i` points from the eye to the vertex, so the reflection is `i − 2(n·i)n`. Another common form uses −i.
//! - The reflection matrix rotates directions: its last column has no effect (ruling `reflection-matrix`).
//! - The formulas that map the sphere to (t0, t1) are lost (rulings `vrc-azimuth`, `wc-azimuth`, `vrc-height`, `wc-height`).
//! - Normals are not normalized (ruling `normal-length`).

use std::f64::consts::PI;

use super::entry::{Entry, Matrix, Parameterization, Vector};
use super::no_value::NoValue;
use super::primitive::{Point, VertexData};
use super::rules::Rules;

/// Returns the texture coordinates of `point` before orientation. Coordinates beyond the `dimensions` of the map are arbitrary.
///
/// # Errors
/// Returns [`NoValue::ImplementationDefined`] if there are too few data values for the map (R-PAR-25) or the reflection vector is
/// zero, and [`NoValue::Missing`] if the point lacks a value that the method needs.
pub fn parameterize(
    entry: &Entry,
    point: &Point,
    dimensions: usize,
    rules: &Rules,
) -> Result<Vector, NoValue> {
    (rules.parameterize)(entry, point, dimensions, rules)
}

/// Applies the parameterization method of the entry.
///
/// # Errors
/// Returns an error if the method has no value for this point.
pub fn apply_method(
    entry: &Entry,
    point: &Point,
    dimensions: usize,
    rules: &Rules,
) -> Result<Vector, NoValue> {
    match entry.parameterization {
        // (x, y, z) (R-PAR-13, R-PAR-14)
        Parameterization::VertexMCCoord => point.mc.position.ok_or(NoValue::Missing("mc")),
        Parameterization::VertexWCCoord => point.wc.position.ok_or(NoValue::Missing("wc")),
        Parameterization::VertexMCNormal => {
            (rules.normal)(&point.mc).ok_or(NoValue::Missing("mc_normal or mc_geometric_normal"))
        }
        Parameterization::VertexWCNormal => {
            (rules.normal)(&point.wc).ok_or(NoValue::Missing("wc_normal or wc_geometric_normal"))
        }
        Parameterization::NURBUV => Ok((rules.spline_parameters)(point)),
        Parameterization::FloatData => (rules.float_data)(point, entry.fp_data_index, dimensions),
        Parameterization::ReflectionSphereVRC => {
            let s = reflection(entry, point, &(rules.vrc_vertex)(point), rules)?;
            Ok([(rules.vrc_azimuth)(s), (rules.vrc_height)(s), 0.0])
        }
        Parameterization::ReflectionSphereWC => {
            let s = reflection(entry, point, &(rules.wc_vertex)(point), rules)?;
            Ok([(rules.wc_azimuth)(s), (rules.wc_height)(s), 0.0])
        }
    }
}

/// Returns the vertex in view reference coordinates (R-PAR-30).
#[must_use]
pub fn vertex_in_vrc(point: &Point) -> VertexData {
    point.vrc.clone()
}

/// Returns the vertex in world coordinates (R-PAR-35).
#[must_use]
pub fn vertex_in_wc(point: &Point) -> VertexData {
    point.wc.clone()
}

/// Returns the normal of the vertex, or the geometric normal if there is none (R-PAR-15 … R-PAR-18).
#[must_use]
pub fn normal(vertex: &VertexData) -> Option<Vector> {
    vertex.normal.or(vertex.geometric_normal)
}

/// Returns (u, v, 0) on a B-spline surface, and (0, 0, 0) elsewhere (R-PAR-19, R-PAR-20).
#[must_use]
pub fn spline_parameters(point: &Point) -> Vector {
    let (u, v) = point.spline.as_ref().map_or((0.0, 0.0), |s| (s.u, s.v));
    [u, v, 0.0]
}

/// Returns as many data values as the map has dimensions, beginning at `index` (R-PAR-21 … R-PAR-23). On a B-spline surface, the
/// first value of each data spline is used (R-PAR-24).
///
/// # Errors
/// Returns an error if the point has too few numbers.
pub fn float_data(point: &Point, index: usize, count: usize) -> Result<Vector, NoValue> {
    let mut t = [0.0; 3];
    for (i, t) in t.iter_mut().enumerate().take(count) {
        let at = index.saturating_add(i);
        let datum = match &point.spline {
            Some(spline) => spline.data.get(at).and_then(|values| values.first()),
            None => point.fp_data.get(at),
        };
        // R-PAR-25
        *t = *datum.ok_or(NoValue::ImplementationDefined("fp-data-short"))?;
    }
    Ok(t)
}

/// Returns the reflection vector of a point, rotated by the reflection matrix (R-PAR-09, R-PAR-10).
fn reflection(
    entry: &Entry,
    point: &Point,
    vertex: &VertexData,
    rules: &Rules,
) -> Result<Vector, NoValue> {
    let reflected = || {
        let n = (rules.normal)(vertex).ok_or(NoValue::Missing("a normal"))?;
        Ok((rules.reflect)(sight(point, vertex, rules)?, n))
    };
    let s = point.reflection.map_or_else(reflected, Ok)?;
    let rotated = (rules.rotate)(&entry.reflection_matrix, s);
    if rotated == [0.0; 3] {
        return Err(NoValue::ImplementationDefined("no-reflection"));
    }
    Ok(rotated)
}

fn sight(point: &Point, vertex: &VertexData, rules: &Rules) -> Result<Vector, NoValue> {
    if let Some(sight) = point.sight {
        return Ok(sight);
    }
    let eye = vertex.eye.ok_or(NoValue::Missing("an eye"))?;
    let position = vertex.position.ok_or(NoValue::Missing("a position"))?;
    Ok((rules.sight)(eye, position))
}

/// Returns the unit vector from the eye to the vertex, or zero if they coincide (R-PAR-29).
#[must_use]
pub fn sight_from_eye(eye: Vector, position: Vector) -> Vector {
    let direction = [0, 1, 2].map(|c| position[c] - eye[c]);
    let length = length(direction);
    if length == 0.0 {
        return direction;
    }
    direction.map(|c| c / length)
}

/// Reflects the line of sight `i` off a surface with normal `n`: i − 2(n·i)n (R-PAR-29, ruling `reflection-vector`).
#[must_use]
pub fn reflect(i: Vector, n: Vector) -> Vector {
    let projection = dot(n, i);
    [0, 1, 2].map(|c| i[c] - 2.0 * projection * n[c])
}

/// Computes M·(s, 0), which rotates a direction without translation (ruling `reflection-matrix`).
#[must_use]
pub fn rotate(matrix: &Matrix, s: Vector) -> Vector {
    [0, 1, 2].map(|row| dot([matrix[row][0], matrix[row][1], matrix[row][2]], s))
}

/// Returns the angle of `s` around the y axis, from 0 to 2π. It is measured from +x, counterclockwise as seen from +y. The angle
/// is 0 if `s` is on the y axis (ruling `poles`).
#[must_use]
pub fn azimuth(s: Vector) -> f64 {
    if s[0] == 0.0 && s[2] == 0.0 {
        return 0.0;
    }
    let angle = (-s[2]).atan2(s[0]);
    if angle < 0.0 { angle + 2.0 * PI } else { angle }
}

/// Maps each half turn of the azimuth to 0 … 1. The seams are at +x and −x, ½ is toward the viewer, and values increase to the
/// right (R-PAR-27, ruling `vrc-azimuth`).
#[must_use]
pub fn half_turn_fraction(s: Vector) -> f64 {
    (azimuth(s) / PI).fract()
}

/// Maps x linearly to t0 (alternative to ruling `vrc-azimuth`).
#[must_use]
pub fn azimuth_proportional_to_x(s: Vector) -> f64 {
    let radius = s[0].hypot(s[2]);
    if radius == 0.0 {
        return 0.0;
    }
    f64::midpoint(1.0, s[0] / radius)
}

/// Maps a full turn of the azimuth to 0 … 1, with the seam at +x (R-PAR-34, ruling `wc-azimuth`).
#[must_use]
pub fn full_turn_fraction(s: Vector) -> f64 {
    azimuth(s) / (2.0 * PI)
}

/// Returns the angle from −y as a fraction of a half turn, 0 at −y and 1 at +y (rulings `vrc-height`, `wc-height`).
#[must_use]
pub fn height_by_angle(s: Vector) -> f64 {
    (-s[1] / length(s)).clamp(-1.0, 1.0).acos() / PI
}

/// Maps y linearly to t1 (alternative to rulings `vrc-height` and `wc-height`).
#[must_use]
pub fn height_by_y(s: Vector) -> f64 {
    f64::midpoint(1.0, s[1] / length(s))
}

/// Returns the angle from +y as a fraction of a half turn (alternative to rulings `vrc-height` and `wc-height`).
#[must_use]
pub fn height_from_top(s: Vector) -> f64 {
    1.0 - height_by_angle(s)
}

/// Returns the scalar product of two vectors.
#[must_use]
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the length of a vector.
#[must_use]
pub fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}
