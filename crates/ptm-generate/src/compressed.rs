//! §2.9 Compressed Data
//!
//! The parameter, six lists with one number per plane (two for motion vectors), and the planes (clause 2.9/1). Each list is on
//! its own line, and motion vectors are on two lines (ruling `list-layout`). Ruling `list-lines` allows other line breaks.

use super::spelling::{Line, Lists};
use super::{model::Model, output::Output, planes::Compressed};

pub fn write(model: &Model, out: &mut Output) {
    let compressed = model.compressed.as_ref();
    let compressed = compressed.expect("a model with a compressed format has streams");
    write_lists(compressed, out);
    write_planes(compressed, out);
}

/// Writes the lists of a compressed format (2.9.1–2.9.7).
fn write_lists(compressed: &Compressed, out: &mut Output) {
    let Compressed { plan, planes } = compressed;
    let sizes: Vec<usize> = planes.iter().map(|plane| plane.stream.len()).collect();
    let side_sizes: Vec<usize> = planes.iter().map(|plane| 5 * plane.records.len()).collect();

    write_list(Line::Parameter, "parameter", &[plan.parameter], out);
    write_list(Line::Transforms, "transforms", &plan.transforms, out);
    write_list(Line::MotionX, "motion x", &plan.motion_x, out);
    write_list(Line::MotionY, "motion y", &plan.motion_y, out);
    write_list(Line::Order, "order", &plan.order, out);
    write_list(Line::References, "references", &plan.references, out);
    write_list(Line::Sizes, "compressed sizes", &sizes, out);
    write_list(Line::SideSizes, "side sizes", &side_sizes, out);
}

fn write_list(line: Line, name: &'static str, numbers: &[impl ToString], out: &mut Output) {
    let clause = match line {
        Line::Parameter => "2.9.1/1",
        Line::MotionX | Line::MotionY => "2.9.3/1",
        _ => "2.9/3",
    };
    for (i, number) in numbers.iter().enumerate() {
        if i > 0 {
            out.line_end_or_gap(out.spelling.lists == Lists::NumberPerLine, line);
        }
        out.token(clause, name, &number.to_string());
    }
    let ends = match out.spelling.lists {
        Lists::Lines | Lists::NumberPerLine => true,
        Lists::MotionOnOneLine => line != Line::MotionX,
        // The header must end in a line feed in every layout.
        Lists::OneLine => line == Line::SideSizes,
    };
    out.line_end_or_gap(ends, line);
}

/// Writes the planes (2.9.8) in plane order, regardless of the decoding order (ruling `planes-stored`).
fn write_planes(compressed: &Compressed, out: &mut Output) {
    for plane in &compressed.planes {
        out.put("2.9.8/1", "plane", &plane.stream);
        out.put("2.9.8/4", "side information", &plane.side_information());
    }
}
