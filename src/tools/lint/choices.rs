//! What readers make of the file who read the open points otherwise: rulings of kind *choice*.
//!
//! Each other reading is tried, and what differs is told; nothing is guessed from what the file looks like.

use super::Finding;
use super::codes::{self, Code};
use crate::decode::{Limits, Ptm, decode_as};
use crate::evaluate;
use crate::harness::choices::CHOICES;
use crate::ptm::{Format, Shape};
use crate::reading::Reading;
use crate::tools::anatomy::{Anatomy, Role};

/// The code of each ruling that changes a picture.
const RULINGS: &[(&str, &Code)] = &[
    ("lum-vector", &codes::CHOICE_LUM_VECTOR),
    ("lum-major", &codes::CHOICE_LUM_MAJOR),
    ("lum-range", &codes::CHOICE_LUM_RANGE),
    ("jpeg-ls-offset", &codes::CHOICE_JPEG_LS_OFFSET),
    ("motion-sign", &codes::CHOICE_MOTION_SIGN),
    ("motion-vertical", &codes::CHOICE_MOTION_VERTICAL),
    ("motion-half", &codes::CHOICE_MOTION_HALF),
    ("motion-border", &codes::CHOICE_MOTION_BORDER),
    ("motion-inversion", &codes::CHOICE_MOTION_INVERSION),
    ("side-lossless", &codes::CHOICE_SIDE_LOSSLESS),
];

/// Lights under which colors are compared.
const LIGHTS: [(f64, f64); 3] = [(0.0, 0.0), (0.3125, -0.4375), (-0.625, 0.5)];

pub(super) fn find(anatomy: &Anatomy) -> Vec<Finding> {
    let Ok(ptm) = &anatomy.outcome else {
        return Vec::new();
    };
    let mut findings = tables(anatomy, ptm);
    for choice in CHOICES {
        let Some((_, code)) = RULINGS.iter().find(|(ruling, _)| *ruling == choice.ruling) else {
            continue;
        };
        if !may_show(anatomy, choice.ruling) {
            continue;
        }
        let differing = choice.readings[1..].iter().find_map(|(words, change)| {
            let difference = difference(anatomy.file, ptm, &change(Reading::SPEC))?;
            Some(format!("for a reader for whom {words}, {difference}"))
        });
        findings.extend(
            differing.map(|words| Finding::new(code, place(anatomy, choice.ruling), words)),
        );
    }
    findings
}

/// Where the numbers stand that the ruling is about.
fn place(anatomy: &Anatomy, ruling: &str) -> usize {
    let role = match ruling {
        "lum-vector" | "lum-major" => Role::Matrix(0),
        "lum-range" => Role::Matrix(12),
        "jpeg-ls-offset" => Role::Reference(0),
        "motion-inversion" => Role::Transform(0),
        "side-lossless" => Role::SideSize(0),
        _ => Role::MotionX(0),
    };
    anatomy.part(role).map_or(0, |part| part.range.start)
}

/// Whether it is worth while to read the file once more: no reading of this ruling shows in files that lack its subject.
fn may_show(anatomy: &Anatomy, ruling: &str) -> bool {
    let any = |role: fn(usize) -> Role, is: fn(i64) -> bool| {
        (0..18).any(|plane| anatomy.number(role(plane)).is_some_and(is))
    };
    let is_jpeg_ls = matches!(anatomy.format, Some(Format::JpeglsRgb | Format::JpeglsLrgb));
    match ruling {
        "lum-vector" | "lum-major" | "lum-range" => anatomy.part(Role::Matrix(0)).is_some(),
        "jpeg-ls-offset" => is_jpeg_ls && any(Role::Reference, |reference| reference >= 0),
        "side-lossless" => is_jpeg_ls && any(Role::SideSize, |size| size > 0),
        _ => any(Role::Transform, |transform| transform & 2 != 0),
    }
}

/// The count of a lookup table and what follows it.
fn tables(anatomy: &Anatomy, ptm: &Ptm) -> Vec<Finding> {
    let Some(count) = anatomy.part(Role::Count) else {
        return Vec::new();
    };
    let word = anatomy.text(Role::CountWord);
    let spelled = match word.as_deref() {
        Some("nentries") => "nentries, then the number",
        Some(_) => "the number, then N_LUT_ENTRIES",
        None => "the number alone",
    };
    let mut findings = vec![Finding::new(
        &codes::CHOICE_LUT_COUNT,
        count.range.start,
        spelled,
    )];
    if let Some(difference) =
        difference(anatomy.file, ptm, &Reading::SPEC.with_newline_after_table())
    {
        let at = anatomy
            .part(Role::Indices)
            .map_or(0, |part| part.range.start);
        let found = format!("for a reader that expects a line feed, {difference}");
        findings.push(Finding::new(&codes::CHOICE_LUT_NEWLINE, at, found));
    }
    findings
}

/// What another reading makes of the file, where that differs.
fn difference(file: &[u8], ptm: &Ptm, reading: &Reading) -> Option<String> {
    let other = match decode_as(file, reading, &Limits::default()) {
        Ok(other) => other,
        Err(error) => return Some(format!("it is malformed: {error}")),
    };
    let channels = ptm.planes.shape.channels();
    let pairs = ptm
        .planes
        .samples
        .chunks(channels)
        .zip(other.planes.samples.chunks(channels));
    let differing: Vec<bool> = match ptm.planes.shape {
        Shape::Lum(_) => colors_differ(ptm, &other, reading),
        _ => pairs.map(|(ours, theirs)| ours != theirs).collect(),
    };
    let first = differing.iter().position(|&differs| differs)?;
    let width = ptm.planes.size.width as usize;
    Some(format!(
        "{} of {} texels differ, the first at column {}, row {} from the top",
        differing.iter().filter(|&&differs| differs).count(),
        differing.len(),
        first % width,
        first / width
    ))
}

/// Which texels have another color under some light.
fn colors_differ(ptm: &Ptm, other: &Ptm, reading: &Reading) -> Vec<bool> {
    let ours = ptm.coefficients();
    let theirs = evaluate::apply(&other.header.scale_bias, &other.planes, reading);
    let mut differing = vec![false; ptm.planes.size.texels()];
    for (lu, lv) in LIGHTS {
        let pictures = [
            ours.evaluate(lu, lv).to_bytes(),
            evaluate::evaluate(&theirs, lu, lv, reading).to_bytes(),
        ];
        for (texel, differs) in differing.iter_mut().enumerate() {
            *differs |= pictures[0][3 * texel..][..3] != pictures[1][3 * texel..][..3];
        }
    }
    differing
}
