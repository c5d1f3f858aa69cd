//! A file as a reader with mistakes reads it, compared with the requested values.
//!
//! A writer misreads a clause in the same way as a reader. Either only such a reader gets the right values from its file, or
//! the file has the values that such a reader gets from the right one.

use crate::decode::fields;
use crate::formula::{self, Edit, Edits};
use crate::misreadings::{
    Anatomy, At, EditedFile, Misreading, Stage, formula_edits, plane_edits, read,
};
use crate::protocol::frame::{Frame, Samples, View};
use crate::ptm::{Ptm, ScaleBias, Shape};
use crate::reading::Reading;
use crate::writers::judge::is_same_number;
use crate::writers::lossy::is_within;
use crate::writers::request::{WriteRequest, map_of};

/// Colors under these lights differ if any coefficient differs.
const LIGHTS: [&str; 4] = [
    "rgb:0.3125,-0.4375",
    "rgb:0,0",
    "rgb:-0.5,0.25",
    "rgb:0.125,0.75",
];

/// A file as a reader sees it.
pub(super) struct SeenFile {
    reading: Reading,
    edits: Vec<&'static Edit>,
    /// The last stage at which the reader's mistakes act.
    stage: Stage,
    ptm: Ptm,
}

/// Returns true if a writer with this mistake would have written `file`. `right` is the reference's file.
pub(super) fn explains(
    request: &WriteRequest,
    right: &[u8],
    file: &[u8],
    mistake: &Misreading,
) -> bool {
    is_right_under(request, file, &[mistake]) || is_lost(right, file, mistake)
}

/// Returns true if a reader with these mistakes, and only such a reader, has the right values of `file`.
pub(super) fn is_right_under(
    request: &WriteRequest,
    file: &[u8],
    mistakes: &[&Misreading],
) -> bool {
    tells(file, mistakes, |seen| seen.is_right(request))
}

/// Returns true if `file` has the values that a reader with this mistake, and only such a reader, gets from the right file.
fn is_lost(right: &[u8], file: &[u8], mistake: &Misreading) -> bool {
    if let Some(seen) = edited(right, mistake)
        && payload(&seen) != payload(right)
        && payload(&seen) == payload(file)
    {
        // The payload is wrong, unless the header ends before the last bias.
        let (fields, _) = fields(file);
        return fields
            .iter()
            .filter(|field| field.clause == "2.4/4")
            .count()
            == 6;
    }
    // A decoding mistake gives the same values when it is repeated as when it is undone.
    mistake.at.stage() != Stage::Decoding
        && tells(right, &[mistake], |seen| seen.is_written_as_seen(file))
}

/// Returns true if `is_so` holds for a reader with these mistakes and not for one without them.
fn tells(file: &[u8], mistakes: &[&Misreading], is_so: impl Fn(&SeenFile) -> bool) -> bool {
    let Some(seen) = SeenFile::new(file, mistakes).filter(&is_so) else {
        return false;
    };
    let stage = seen.stage;
    let plain = SeenFile::new(file, &[]).map(|plain| SeenFile { stage, ..plain });
    !plain.as_ref().is_some_and(is_so)
}

/// Returns the bytes that a reader with this mistake sees in place of the file, if the mistake acts on bytes.
pub(super) fn edited(file: &[u8], mistake: &Misreading) -> Option<Vec<u8>> {
    let At::Bytes(edit) = mistake.at else {
        return None;
    };
    match edit(&Anatomy::new(file, &Reading::SPEC)) {
        EditedFile::File(bytes) => Some(bytes),
        EditedFile::Refused => None,
    }
}

/// Returns the bytes after the header.
fn payload(file: &[u8]) -> &[u8] {
    &file[Anatomy::new(file, &Reading::SPEC).payload_offset()..]
}

impl SeenFile {
    /// Reads `file` with these mistakes. Returns `None` if such a reader refuses it.
    pub fn new(file: &[u8], mistakes: &[&Misreading]) -> Option<SeenFile> {
        let (mut ptm, reading) = read(mistakes, Reading::SPEC, file).ok()?;
        for edit in plane_edits(mistakes) {
            edit(&mut ptm);
        }
        let stages = mistakes.iter().map(|mistake| mistake.at.stage());
        Some(SeenFile {
            reading,
            edits: formula_edits(mistakes),
            stage: stages.max().unwrap_or(Stage::File),
            ptm,
        })
    }

    /// Returns true if these are the values of `request`: the stored values, or values computed from them if a mistake acts
    /// later.
    pub fn is_right(&self, request: &WriteRequest) -> bool {
        self.ptm.header.format == request.format
            && self.ptm.planes.samples.len() == request.samples.len()
            && is_within(request, &self.ptm.planes.samples)
            && self.has_numbers_of(&SeenFile::wanted(request), self.stage)
    }

    /// Returns true if `file`, read without mistakes, has exactly the values that this reader sees.
    fn is_written_as_seen(&self, file: &[u8]) -> bool {
        SeenFile::new(file, &[]).is_some_and(|found| {
            found.ptm.planes.samples == self.ptm.planes.samples
                && found.has_numbers_of(self, self.stage)
        })
    }

    /// Returns true if both have the same size and the same numbers in the header, or the same derived values up to a stage.
    fn has_numbers_of(&self, other: &SeenFile, stage: Stage) -> bool {
        self.ptm.header.size == other.ptm.header.size
            && match stage {
                Stage::Coefficients => self.shows(other, "coef"),
                Stage::Color => LIGHTS.iter().all(|light| self.shows(other, light)),
                _ => has_numbers(&self.ptm, &other.ptm),
            }
    }

    /// Returns the map with the scales and biases by which this reader's final coefficients follow from the raw values.
    pub fn into_effective_map(self) -> Ptm {
        let mut map = self.ptm;
        if self.stage == Stage::Coefficients {
            let finals_of = |raw: u8| {
                let mut uniform = map.clone();
                uniform.planes.samples.fill(raw);
                formula::finals(&uniform, &self.reading, Edits(&self.edits)).values
            };
            let [zeros, ones] = [0, 1].map(finals_of);
            for i in 0..6 {
                let (zero, one) = (zeros[i], ones[i]);
                map.header.scale_bias.scale[i] = one - zero;
                map.header.scale_bias.bias[i] = zero / (zero - one);
            }
        }
        map
    }

    /// Returns the values of a request, as a reader without mistakes has them.
    pub fn wanted(request: &WriteRequest) -> SeenFile {
        let WriteRequest {
            header,
            format,
            samples,
        } = request;
        let scale_bias = ScaleBias {
            scale: header.scale,
            bias: header.bias.map(|bias| bias as f64),
        };
        SeenFile {
            reading: Reading::SPEC,
            edits: Vec::new(),
            stage: Stage::File,
            ptm: map_of(
                *format,
                request.size(),
                scale_bias,
                header.matrix,
                samples.clone(),
            ),
        }
    }

    /// Returns true if both look the same in a view, within the rounding of `f32`.
    fn shows(&self, other: &SeenFile, view: &str) -> bool {
        let view: View = view.parse().expect("a view");
        let frame = |of: &SeenFile| {
            Frame::render_edited(&of.ptm, &view, &of.reading, Edits(&of.edits)).samples
        };
        match (frame(self), frame(other)) {
            (Samples::U8(one), Samples::U8(other)) => {
                let mut pairs = one.iter().zip(&other);
                pairs.all(|(a, b)| a.abs_diff(*b) <= 1)
            }
            (Samples::F32(one), Samples::F32(other)) => {
                let mut pairs = one.iter().zip(&other);
                pairs.all(|(a, b)| (a - b).abs() <= 2e-6 * a.abs().max(b.abs()))
            }
            _ => false,
        }
    }
}

/// Returns true if scales, biases and matrix are equal within the tolerance of the judge.
fn has_numbers(found: &Ptm, wanted: &Ptm) -> bool {
    let same = |wanted: &[f64], found: &[f64]| {
        let mut pairs = wanted.iter().zip(found);
        pairs.all(|(wanted, found)| is_same_number(*wanted, *found))
    };
    let (set, right) = (&found.header.scale_bias, &wanted.header.scale_bias);
    same(&right.scale, &set.scale)
        && same(&right.bias, &set.bias)
        && match (&wanted.planes.shape, &found.planes.shape) {
            (Shape::Lum(wanted), Shape::Lum(found)) => same(&wanted.0, &found.0),
            _ => true,
        }
}
