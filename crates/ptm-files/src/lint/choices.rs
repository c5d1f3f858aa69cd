//! Effects that alternative readings of open questions (rulings of kind *choice*) have on a file.
//!
//! Every alternative reading is tried, and differences are reported. Nothing is guessed from the contents of the image.

use super::codes::{self, Problem};
use super::diagnostic::Findings;
use crate::describe_position;
use crate::dissection::{Dissection, Role};
use ptm::decode::lookup_table::read_newline_separator;
use ptm::decode::{StoredMap, Streams, open_as};
use ptm::evaluate;
use ptm::reading::Reading;
use ptm::{Coding, Format, Limits, Planes, Ptm, Shape, Size};
use ptm_suite::choices::CHOICES;

/// Light directions under which colors are compared.
const LIGHTS: [(f64, f64); 3] = [(0.0, 0.0), (0.3125, -0.4375), (-0.625, 0.5)];

/// Number of texels whose colors are computed at a time.
const CHUNK_TEXELS: usize = 4096;

pub(super) fn diagnose(findings: &mut Findings, streams: Option<&Streams>) {
    let dissection = findings.dissection;
    let Ok(ptm) = &dissection.outcome else { return };
    diagnose_tables(findings, ptm);
    for choice in CHOICES.iter() {
        let mut codes = codes::ALL.iter();
        let code = codes.find(|code| code.ruling.as_deref() == Some(choice.ruling));
        let Some((code, role)) = code.zip(affected_role(dissection, choice.ruling)) else {
            continue;
        };
        for (words, change) in &choice.readings[1..] {
            let mut reading = Reading::SPEC;
            change(&mut reading);
            if let Some(difference) = difference(dissection, ptm, streams, &reading) {
                let found = format!("under the reading “{words}”, {difference}");
                findings.add_code(code, dissection.start(role), found);
                break;
            }
        }
    }
}

/// Returns the role of the numbers that the ruling is about, or `None` if the file has no such numbers and cannot be affected.
fn affected_role(dissection: &Dissection, ruling: &str) -> Option<Role> {
    let any = |role: fn(usize) -> Role, test: fn(i64) -> bool| {
        let mut planes = 0..dissection.compressed_planes();
        planes.any(|plane| dissection.number(role(plane)).is_some_and(test))
    };
    let is_lum = dissection.part(Role::Matrix(0)).is_some();
    let is_jpeg_ls = dissection.format.and_then(Format::coding) == Some(Coding::JpegLs);
    let moves = any(Role::Transform, |transform| transform & 2 != 0);
    let is_predicted = is_jpeg_ls && any(Role::Reference, |reference| reference >= 0);
    let has_records = is_jpeg_ls && any(Role::SideSize, |size| size > 0);
    let (role, is_present) = match ruling {
        "lum-vector" | "lum-major" | "lum-chroma" | "lum-clamp" => (Role::Matrix(0), is_lum),
        "lum-range" => (Role::Matrix(12), is_lum),
        "jpeg-ls-offset" => (Role::Reference(0), is_predicted),
        "side-lossless" => (Role::SideSize(0), has_records),
        "motion-inversion" => (Role::Transform(0), moves),
        _ => (Role::MotionX(0), moves),
    };
    is_present.then_some(role)
}

/// Reports the spelling of the entry count of a lookup table, and the effect of a line feed after the table.
fn diagnose_tables(findings: &mut Findings, ptm: &Ptm) {
    let dissection = findings.dissection;
    if dissection.part(Role::Count).is_none() {
        return;
    }
    let spelling = match dissection.bytes(Role::CountWord) {
        Some(b"nentries") => "nentries, then the number",
        Some(_) => "the number, then N_LUT_ENTRIES",
        None => "only the number",
    };
    findings.add(Problem::ChoiceLutCount, Role::Count, spelling);
    let with_newline = Reading {
        after_table: read_newline_separator,
        ..Reading::SPEC
    };
    if let Some(difference) = difference(dissection, ptm, None, &with_newline) {
        let found = format!("for a reader that expects a line feed after the table, {difference}");
        findings.add(Problem::ChoiceLutNewline, Role::Indices, found);
    }
}

/// Describes how the values or colors of the file differ under another reading. Returns `None` if they do not.
fn difference(
    dissection: &Dissection,
    ptm: &Ptm,
    streams: Option<&Streams>,
    reading: &Reading,
) -> Option<String> {
    // The planes of LUM are equal under all readings, but the colors may differ.
    if let Shape::Lum(_) = ptm.planes.shape {
        return describe_texels(ptm, &differing_colors(ptm, reading));
    }
    let other = match streams {
        Some(streams) => streams.reconstruct_map(reading),
        None => open_as(dissection.file, reading, &Limits::default()),
    };
    match other {
        Ok(other) => describe_texels(ptm, &differing_planes(ptm, &other)),
        Err(error) => Some(format!("it is malformed: {error}")),
    }
}

/// States the number of differing texels and the position of the first. Returns `None` if there are none.
fn describe_texels(ptm: &Ptm, differing: &[bool]) -> Option<String> {
    let first = differing.iter().position(|&differs| differs)?;
    let count = differing.iter().filter(|&&differs| differs).count();
    let differ = if count == 1 { "differs" } else { "differ" };
    let (all, position) = (differing.len(), describe_position(ptm.planes.size, first));
    Some(format!(
        "{count} of {all} texels {differ}, the first at {position}"
    ))
}

/// Returns one flag per texel: true if the stored values differ.
fn differing_planes(ptm: &Ptm, other: &StoredMap) -> Vec<bool> {
    let channels = ptm.planes.shape.channels();
    let mut texels = ptm.planes.samples.chunks(channels);
    let mut differing = Vec::new();
    for piece in other.pieces() {
        let others = piece.planes.samples.chunks(channels);
        differing.extend(others.map(|other| texels.next() != Some(other)));
    }
    differing
}

/// Returns one flag per texel: true if the color differs under any of [`LIGHTS`]. Works in chunks to limit memory use.
fn differing_colors(ptm: &Ptm, reading: &Reading) -> Vec<bool> {
    let shape = ptm.planes.shape;
    let mut all = Vec::new();
    for samples in ptm.planes.samples.chunks(CHUNK_TEXELS * shape.channels()) {
        let (width, height) = ((samples.len() / shape.channels()) as u32, 1);
        let (size, samples) = (Size { width, height }, samples.to_vec());
        let planes = Planes {
            size,
            shape,
            samples,
        };
        // The readings of LUM differ in the use of coefficients, not in the coefficients themselves.
        let scale_bias = &ptm.header.scale_bias;
        let finals = evaluate::compute_coefficients(scale_bias, &planes, &Reading::SPEC);
        let mut differing = vec![false; size.texels()];
        for (lu, lv) in LIGHTS {
            let colors = |reading| evaluate::evaluate(&finals, lu, lv, reading).to_bytes();
            let (ours, theirs) = (colors(&Reading::SPEC), colors(reading));
            let pairs = ours.chunks(3).zip(theirs.chunks(3));
            for (differs, (ours, theirs)) in differing.iter_mut().zip(pairs) {
                *differs |= ours != theirs;
            }
        }
        all.extend(differing);
    }
    all
}
