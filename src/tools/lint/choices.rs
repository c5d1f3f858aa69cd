//! What readers make of the file that read the open points in another way: rulings of kind *choice*.
//!
//! Each other reading is tried, and what differs is reported; nothing is guessed from what the file looks like.

use super::codes;
use super::diagnostic::Diagnostic;
use crate::decode::{Stored, open_as};
use crate::evaluate;
use crate::ptm::{Format, Limits, Ptm, Shape};
use crate::reading::Reading;
use crate::suite::choices::CHOICES;
use crate::tools::dissection::{Dissection, Role};

/// Lights under which colors are compared.
const LIGHTS: [(f64, f64); 3] = [(0.0, 0.0), (0.3125, -0.4375), (-0.625, 0.5)];

pub(super) fn diagnose(dissection: &Dissection) -> Vec<Diagnostic> {
    let Ok(ptm) = &dissection.outcome else {
        return Vec::new();
    };
    let mut diagnostics = tables(dissection, ptm);
    for choice in CHOICES.iter() {
        let code = codes::RULINGS.iter().find(|(of, _)| *of == choice.ruling);
        let (Some((_, code)), Some(place)) = (code, subject(dissection, choice.ruling)) else {
            continue;
        };
        let differing = choice.readings[1..].iter().find_map(|(words, change)| {
            let difference = difference(dissection.file, ptm, &change(Reading::SPEC))?;
            Some(format!("for a reader for whom {words}, {difference}"))
        });
        let at = dissection.start(place);
        diagnostics.extend(differing.map(|found| Diagnostic::new(code, at, found)));
    }
    diagnostics
}

/// Where the numbers stand that the ruling is about; nothing in a file that lacks its subject, which all readings read alike.
fn subject(dissection: &Dissection, ruling: &str) -> Option<Role> {
    let any = |role: fn(usize) -> Role, is: fn(i64) -> bool| {
        (0..18).any(|plane| dissection.number(role(plane)).is_some_and(is))
    };
    let is_lum = dissection.part(Role::Matrix(0)).is_some();
    let is_jpeg_ls = matches!(
        dissection.format,
        Some(Format::JpeglsRgb | Format::JpeglsLrgb)
    );
    let moves = any(Role::Transform, |transform| transform & 2 != 0);
    let (place, is_there) = match ruling {
        "lum-vector" | "lum-major" => (Role::Matrix(0), is_lum),
        "lum-range" => (Role::Matrix(12), is_lum),
        "jpeg-ls-offset" => (
            Role::Reference(0),
            is_jpeg_ls && any(Role::Reference, |reference| reference >= 0),
        ),
        "side-lossless" => (
            Role::SideSize(0),
            is_jpeg_ls && any(Role::SideSize, |size| size > 0),
        ),
        "motion-inversion" => (Role::Transform(0), moves),
        _ => (Role::MotionX(0), moves),
    };
    is_there.then_some(place)
}

/// The count of a lookup table and what follows it.
fn tables(dissection: &Dissection, ptm: &Ptm) -> Vec<Diagnostic> {
    if dissection.part(Role::Count).is_none() {
        return Vec::new();
    }
    let spelled = match dissection.bytes(Role::CountWord) {
        Some(b"nentries") => "nentries, then the number",
        Some(_) => "the number, then N_LUT_ENTRIES",
        None => "the number alone",
    };
    let at = dissection.start(Role::Count);
    let mut diagnostics = vec![Diagnostic::new(&codes::CHOICE_LUT_COUNT, at, spelled)];
    let with_newline = Reading::SPEC.with_newline_after_table();
    if let Some(difference) = difference(dissection.file, ptm, &with_newline) {
        let at = dissection.start(Role::Indices);
        let found = format!("for a reader that expects a line feed, {difference}");
        diagnostics.push(Diagnostic::new(&codes::CHOICE_LUT_NEWLINE, at, found));
    }
    diagnostics
}

/// What another reading makes of the file, where that differs.
fn difference(file: &[u8], ptm: &Ptm, reading: &Reading) -> Option<String> {
    let limits = Limits::default();
    let other = match open_as(file, reading, &limits) {
        Ok(other) => other,
        Err(error) => return Some(format!("it is malformed: {error}")),
    };
    let channels = ptm.planes.shape.channels();
    let mut texels = ptm.planes.samples.chunks(channels);
    let differing: Vec<bool> = match ptm.planes.shape {
        // Planes of LUM are alike under all readings; their colors are not.
        Shape::Lum(_) => colors_differ(
            &open_as(file, &Reading::SPEC, &limits).ok()?,
            &other,
            reading,
        ),
        _ => other
            .pieces()
            .flat_map(|piece| {
                let samples = piece.planes.samples;
                let theirs = samples.chunks(channels);
                theirs
                    .map(|theirs| texels.next() != Some(theirs))
                    .collect::<Vec<_>>()
            })
            .collect(),
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

/// Which texels have another color under some light; piece by piece, because colors take far more room than what they are
/// made of.
fn colors_differ(ours: &Stored, theirs: &Stored, reading: &Reading) -> Vec<bool> {
    let colors = |piece: &Ptm, reading: &Reading, (lu, lv): (f64, f64)| {
        let finals = evaluate::apply(&piece.header.scale_bias, &piece.planes, reading);
        evaluate::evaluate(&finals, lu, lv, reading).to_bytes()
    };
    let pairs = ours.pieces().zip(theirs.pieces());
    let differing = pairs.flat_map(|(our_piece, their_piece)| {
        let mut differing = vec![false; our_piece.planes.size.texels()];
        for light in LIGHTS {
            let pictures = [
                colors(&our_piece, &Reading::SPEC, light),
                colors(&their_piece, reading, light),
            ];
            for (texel, differs) in differing.iter_mut().enumerate() {
                *differs |= pictures[0][3 * texel..][..3] != pictures[1][3 * texel..][..3];
            }
        }
        differing
    });
    differing.collect()
}
