//! Compares two files: header, planes and encoding.

use std::fmt::Write as _;

use serde::Serialize;

use ptm::{Planes, Ptm, Shape, channel_name};

/// Differences between two files.
#[derive(Debug, Default, PartialEq, Serialize)]
pub struct MapDifference {
    /// True if both files represent the same map.
    pub same: bool,
    /// Descriptions of differences between the headers.
    pub header: Vec<String>,
    /// Planes that differ, if both maps have the same number of planes and the same size.
    pub planes: Vec<PlaneDifference>,
    /// Differences in encoding that do not change the map.
    #[serde(rename = "written")]
    pub encoding: Vec<String>,
}

/// Differences between two versions of a plane.
#[derive(Debug, PartialEq, Serialize)]
pub struct PlaneDifference {
    /// Number of the plane.
    pub plane: usize,
    /// Name of the channel.
    pub channel: String,
    /// Number of texels that differ.
    pub texels: usize,
    /// Largest difference between two stored values.
    pub largest: u8,
    /// First texel that differs, in row-major order from the top left.
    pub first: FirstTexel,
}

/// Texel with different values in two files.
#[derive(Debug, PartialEq, Serialize)]
pub struct FirstTexel {
    /// Column, counted from the left.
    pub x: usize,
    /// Row, counted from the top.
    pub y: usize,
    /// Stored value in each file.
    pub values: [u8; 2],
}

/// Compares two maps. `a` and `b` each consist of the bytes of a file and the decoded map.
#[must_use]
pub fn diff(a: (&[u8], &Ptm), b: (&[u8], &Ptm)) -> MapDifference {
    let ((a_file, a), (b_file, b)) = (a, b);
    let mut difference = MapDifference {
        header: compare_headers(a, b),
        ..MapDifference::default()
    };
    if a.planes.size == b.planes.size && a.planes.shape.channels() == b.planes.shape.channels() {
        difference.planes = compare_planes(&a.planes, &b.planes);
    }
    if a.header.format != b.header.format {
        let (a, b) = (a.header.format, b.header.format);
        difference.encoding.push(format!("format: {a} and {b}"));
    }
    difference.same = difference.header.is_empty() && difference.planes.is_empty();
    if difference.same && difference.encoding.is_empty() && a_file != b_file {
        let (a, b) = (a_file.len(), b_file.len());
        let first = a_file.iter().zip(b_file).position(|(a, b)| a != b);
        let first = first.unwrap_or(a.min(b));
        difference.encoding.push(format!(
            "{a} and {b} bytes; the first difference is at byte {first}"
        ));
    }
    difference
}

fn compare_headers(a: &Ptm, b: &Ptm) -> Vec<String> {
    let (mut layout, mut numbers) = (Vec::new(), Vec::new());
    let (a_shape, b_shape) = (a.planes.shape, b.planes.shape);
    let [(a_format, a_planes), (b_format, b_planes)] =
        [(a, a_shape), (b, b_shape)].map(|(ptm, shape)| (ptm.header.format, shape.channels()));
    if a_planes != b_planes {
        layout.push(format!(
            "format: {a_format} has {a_planes} planes, {b_format} has {b_planes}; planes of different kinds are not compared"
        ));
    }
    let mut compare = |name: String, a: f64, b: f64| {
        if a != b {
            numbers.push(format!("{name}: {a} and {b}"));
        }
    };
    let (a_set, b_set) = (&a.header.scale_bias, &b.header.scale_bias);
    for i in 0..6 {
        compare(format!("scale of a{i}"), a_set.scale[i], b_set.scale[i]);
        compare(format!("bias of a{i}"), a_set.bias[i], b_set.bias[i]);
    }
    if let (Shape::Lum(a), Shape::Lum(b)) = (a_shape, b_shape) {
        (0..16).for_each(|i| compare(format!("matrix element {i}"), a.0[i], b.0[i]));
    }
    let (a, b) = (a.header.size, b.header.size);
    if a != b {
        layout.push(format!(
            "size: {a} and {b}; planes are compared only if the sizes are equal"
        ));
    }
    [layout, numbers].concat()
}

fn compare_planes(a: &Planes, b: &Planes) -> Vec<PlaneDifference> {
    let channels = a.shape.channels();
    let width = a.size.width as usize;
    let compare = |plane: usize| {
        let pairs = a.samples.iter().zip(&b.samples);
        let pairs = || pairs.clone().skip(plane).step_by(channels);
        let first = pairs().position(|(a, b)| a != b)?;
        let texel = first * channels + plane;
        Some(PlaneDifference {
            plane,
            channel: channel_name(channels, plane),
            texels: pairs().filter(|(a, b)| a != b).count(),
            largest: pairs().map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0),
            first: FirstTexel {
                x: first % width,
                y: first / width,
                values: [a.samples[texel], b.samples[texel]],
            },
        })
    };
    (0..channels).filter_map(compare).collect()
}

impl MapDifference {
    /// Describes the differences, one per line. Returns an empty string for equal files.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut out = String::new();
        for line in &self.header {
            let _ = writeln!(out, "{line}");
        }
        for plane in &self.planes {
            let differ = match plane.texels {
                1 => "1 texel differs".to_owned(),
                texels => format!("{texels} texels differ"),
            };
            let (name, largest, first) = (&plane.channel, plane.largest, &plane.first);
            let [a, b] = first.values;
            let _ = writeln!(
                out,
                "plane {} ({name}): {differ}, by at most {largest}; the first is at column {}, row {} from the top: {a} and {b}",
                plane.plane, first.x, first.y
            );
        }
        for line in &self.encoding {
            let _ = writeln!(out, "encoded differently: {line}");
        }
        out
    }
}
