//! Preview of the effect of an entry: a plane or a sphere with one map, under a nearby light.
//!
//! Rendering is not part of the chapter. The preview is an aid for readers of the chapter. It runs the whole pipeline for each
//! pixel: coordinates, orientation, depth from the footprint of the pixel, sampling, and composition with light that is computed
//! from normals. An outline marks the edge of the map, at coordinates 0 and 1.

use std::f64::consts::PI;

use super::depth::{Footprint, is_magnified, sample_depth};
use super::entry::{Color, Entry, Vector};
use super::parameterize::{dot, length, parameterize};
use super::primitive::{
    Frequency, Interpolation, LitPrimitive, Point, Shade, SplinePoint, VertexData,
};
use super::{map::TextureMap, no_value::NoValue, orient::orient};
use super::{rules::Rules, sample::fetch, stage::stage};

/// Shape to which the map is applied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PreviewShape {
    /// Square that faces the eye.
    Plane,
    /// Front half of a sphere.
    Sphere,
}

/// Parameters of a preview.
#[derive(Clone, Debug)]
pub struct Preview {
    /// Shape to which the map is applied.
    pub shape: PreviewShape,
    /// Texture map that is applied to the shape.
    pub map: TextureMap,
    /// Table entry that determines how the map is applied.
    pub entry: Entry,
    /// Direction of the light on a hemisphere in front of the shape: +u points right, +v up.
    pub light: (f64, f64),
    /// Color of the surface.
    pub color: Color,
    /// Margin around the map: the coordinates of the shape range from −`margin` to 1 + `margin` in both directions.
    pub margin: f64,
}

const EYE_POSITION: Vector = [0.0, 0.0, 4.0];
/// Distance of the light from the center of the shape.
const LIGHT_DISTANCE: f64 = 2.2;
const OUTLINE: Color = [0.95, 0.45, 0.1];
const BACKGROUND: Color = [0.13, 0.13, 0.15];
/// Number of samples along each side of a pixel.
const SAMPLES_PER_SIDE: usize = 2;

/// Renders a preview of `side` × `side` pixels as interleaved red, green and blue, top row first.
///
/// # Errors
/// Returns an error if the parameterization of the entry cannot derive coordinates for the shape.
pub fn preview(preview: &Preview, side: usize, rules: &Rules) -> Result<Vec<u8>, NoValue> {
    let mut rgb = Vec::with_capacity(3 * side * side);
    for row in 0..side {
        for column in 0..side {
            let mut sum = [0.0; 3];
            for sample in 0..SAMPLES_PER_SIDE * SAMPLES_PER_SIDE {
                let at = |pixel: usize, part: usize| {
                    (pixel as f64 + (part as f64 + 0.5) / SAMPLES_PER_SIDE as f64) / side as f64
                };
                let x = 2.0 * at(column, sample % SAMPLES_PER_SIDE) - 1.0;
                let y = 1.0 - 2.0 * at(row, sample / SAMPLES_PER_SIDE);
                let color = color_at(preview, x, y, 2.0 / side as f64, rules)?;
                sum = [0, 1, 2].map(|c| sum[c] + color[c].clamp(0.0, 1.0));
            }
            let bytes = sum
                .map(|c| (c / (SAMPLES_PER_SIDE * SAMPLES_PER_SIDE) as f64 * 255.0).round() as u8);
            rgb.extend(bytes);
        }
    }
    Ok(rgb)
}

/// Returns the color at (x, y). Both coordinates range from −1 to 1. `step` is the distance between pixels.
fn color_at(preview: &Preview, x: f64, y: f64, step: f64, rules: &Rules) -> Result<Color, NoValue> {
    let Some(point) = surface(preview, x, y) else {
        return Ok(BACKGROUND);
    };
    let here = coordinates(preview, &point, rules)?;
    // At the edge of a sphere, where the map is hardly visible, the neighboring pixel may be outside the sphere.
    let neighbor = |x, y| match surface(preview, x, y) {
        Some(point) => coordinates(preview, &point, rules),
        None => Ok(here),
    };
    let (right, above) = (neighbor(x + step, y)?, neighbor(x, y + step)?);
    if is_outline(preview, here, [right, above]) {
        return Ok(OUTLINE);
    }
    // Ignore large differences, which occur at seams where coordinates jump.
    let difference = |there: Vector| {
        [0, 1, 2].map(|c| {
            let difference = there[c] - here[c];
            if difference.abs() > 0.5 {
                0.0
            } else {
                difference
            }
        })
    };
    let footprint = Footprint {
        dt_dx: difference(right),
        dt_dy: difference(above),
    };
    let (bias, frequency) = (preview.entry.depth_bias, preview.entry.frequency);
    let base = &preview.map.levels()[0].size[..preview.map.dimensions()];
    let depth = sample_depth(base, &footprint, bias, frequency);
    let magnify = is_magnified(base, &footprint, bias, rules);
    let fetched = fetch(&preview.entry, &preview.map, here, depth, magnify, rules);
    let maps = [(preview.entry.clone(), fetched)];
    let lit = light_surface(preview, &point);
    // Normals are interpolated, so texture and light are combined at each pixel.
    let shade = stage(&maps, &lit, Interpolation::Normal, Frequency::Pixel, rules);
    Ok([0, 1, 2].map(|c| shade.alpha * shade.color[c] + (1.0 - shade.alpha) * BACKGROUND[c]))
}

/// Returns true if `here` and one of its neighbors are on different sides of the edge of the map.
fn is_outline(preview: &Preview, here: Vector, next: [Vector; 2]) -> bool {
    let is_inside = |t: Vector| {
        let mut directions = t.iter().take(preview.map.dimensions());
        directions.all(|t| (0.0..=1.0).contains(t))
    };
    next.into_iter().any(|t| is_inside(t) != is_inside(here))
}

fn coordinates(preview: &Preview, point: &Point, rules: &Rules) -> Result<Vector, NoValue> {
    let t = parameterize(&preview.entry, point, preview.map.dimensions(), rules)?;
    Ok(orient(&preview.entry.orientation_matrix, t, rules))
}

/// Returns the point on the shape that is visible at (x, y), if there is one.
fn surface(preview: &Preview, x: f64, y: f64) -> Option<Point> {
    const MARGIN: f64 = 1.06;
    let (x, y) = (x * MARGIN, y * MARGIN);
    let (position, normal, fractions) = match preview.shape {
        PreviewShape::Plane if x.abs() > 1.0 || y.abs() > 1.0 => return None,
        PreviewShape::Plane => (
            [x, y, 0.0],
            [0.0, 0.0, 1.0],
            [x, y].map(|c| f64::midpoint(c, 1.0)),
        ),
        PreviewShape::Sphere if x.hypot(y) > 1.0 => return None,
        PreviewShape::Sphere => {
            let z = (1.0 - x * x - y * y).sqrt();
            let fractions = [x.atan2(z), y.asin()].map(|angle| angle / PI + 0.5);
            ([x, y, z], [x, y, z], fractions)
        }
    };
    let [u, v] = fractions.map(|c| c * (1.0 + 2.0 * preview.margin) - preview.margin);
    let vertex = |position| VertexData {
        position: Some(position),
        eye: Some(EYE_POSITION),
        normal: Some(normal),
        geometric_normal: Some(normal),
    };
    Some(Point {
        mc: vertex([u, v, f64::midpoint(position[2], 1.0)]),
        wc: vertex(position),
        vrc: vertex(position),
        fp_data: vec![u, v, f64::midpoint(position[2], 1.0)],
        spline: Some(SplinePoint {
            u,
            v,
            data: vec![vec![u], vec![v], vec![f64::midpoint(position[2], 1.0)]],
        }),
        sight: None,
        reflection: None,
    })
}

/// Computes the ambient and diffuse light and the highlight.
fn light_surface(preview: &Preview, point: &Point) -> LitPrimitive {
    let position = point.wc.position.unwrap_or_default();
    let normal = point.wc.normal.unwrap_or_default();
    let (lu, lv) = preview.light;
    let lw = (1.0 - lu * lu - lv * lv).max(0.0).sqrt();
    let to_light = normalize([0, 1, 2].map(|c| [lu, lv, lw][c] * LIGHT_DISTANCE - position[c]));
    let to_eye = normalize([0, 1, 2].map(|c| EYE_POSITION[c] - position[c]));
    let halfway = normalize([0, 1, 2].map(|c| to_light[c] + to_eye[c]));
    let diffuse = dot(normal, to_light).max(0.0);
    let highlight = dot(normal, halfway).max(0.0).powi(60);
    LitPrimitive {
        surface: Shade {
            color: preview.color,
            alpha: 1.0,
        },
        white: [0.18 + 0.82 * diffuse; 3],
        specular: [0.32 * highlight; 3],
    }
}

fn normalize(a: Vector) -> Vector {
    let length = length(a);
    a.map(|c| c / length)
}
