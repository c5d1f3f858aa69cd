//! Compares requested values with the values that a reader with mistakes sees in a file.
//!
//! A writer can misread a clause in the same way as a reader. In that case, either only a reader with this mistake sees the right
//! values in the file, or the file contains the values that this reader sees in the right file.

use crate::request::{WriteRequest, new_map};
use crate::{judge::is_same_number, lossy::matches_within_loss};
use ptm::decode::fields;
use ptm::reading::Reading;
use ptm::{Ptm, ScaleBias, Shape};
use ptm_mistakes::formula::{self, Edit, Edits};
use ptm_mistakes::{
    Anatomy, Change, EditedFile, Misreading, Stage, formula_edits, plane_edits, read,
};
use ptm_suite::protocol::frame::{Samples, View};

/// Views under four lights; if any coefficient differs, the color differs in at least one of the views.
const VIEWS: [&str; 4] = [
    "rgb:0.3125,-0.4375",
    "rgb:0,0",
    "rgb:-0.5,0.25",
    "rgb:0.125,0.75",
];

/// File as seen by a reader with mistakes.
pub struct MisreadFile {
    reading: Reading,
    edits: Vec<&'static Edit>,
    /// Last stage at which a mistake of the reader takes effect.
    stage: Stage,
    ptm: Ptm,
}

/// Returns true if a writer with this mistake would write `file`. `right` is the file of the reference.
pub fn explains(request: &WriteRequest, right: &[u8], file: &[u8], mistake: &Misreading) -> bool {
    is_right_only_with(request, file, &[mistake]) || contains_misread_values(right, file, mistake)
}

/// Returns true if a reader with these mistakes sees the right values in `file`, but not if one of them is corrected.
pub fn is_right_only_with(request: &WriteRequest, file: &[u8], mistakes: &[&Misreading]) -> bool {
    requires_mistakes(file, mistakes, |seen| seen.is_right(request))
}

/// Returns true if `file` contains the wrong values that a reader with this mistake would see in the right file.
fn contains_misread_values(right: &[u8], file: &[u8], mistake: &Misreading) -> bool {
    if let Some(seen) = edit_bytes(right, mistake)
        && payload(&seen) != payload(right)
        && payload(&seen) == payload(file)
    {
        // The payload counts as moved only if the header is complete up to the last bias.
        let (fields, _) = fields(file);
        let biases = fields.iter().filter(|field| field.clause == "2.4/4");
        return biases.count() == 6;
    }
    // Applying a decoding mistake twice undoes it.
    mistake.stage() != Stage::Decoding
        && requires_mistakes(right, &[mistake], |seen| seen.has_values_of(file))
}

/// Returns true if `predicate` is true for a reader with these mistakes, but false as soon as one of them is corrected.
fn requires_mistakes(
    file: &[u8],
    mistakes: &[&Misreading],
    predicate: impl Fn(&MisreadFile) -> bool,
) -> bool {
    let Some(seen) = MisreadFile::new(file, mistakes).filter(&predicate) else {
        return false;
    };
    let stage = seen.stage;
    let is_needed = |i: usize| {
        let others = [&mistakes[..i], &mistakes[i + 1..]].concat();
        let corrected = MisreadFile::new(file, &others).map(|seen| MisreadFile { stage, ..seen });
        !corrected.as_ref().is_some_and(&predicate)
    };
    (0..mistakes.len()).all(is_needed)
}

/// Returns the bytes that a reader with this mistake sees instead of the file, or `None` if the mistake does not change bytes.
pub fn edit_bytes(file: &[u8], mistake: &Misreading) -> Option<Vec<u8>> {
    match mistake.change {
        Change::Bytes(edit) => match edit(&Anatomy::new(file, &Reading::SPEC)) {
            EditedFile::File(bytes) => Some(bytes),
            EditedFile::Refused => None,
        },
        _ => None,
    }
}

/// Returns the bytes after the header.
fn payload(file: &[u8]) -> &[u8] {
    &file[Anatomy::new(file, &Reading::SPEC).payload_offset()..]
}

impl MisreadFile {
    /// Reads `file` with these mistakes. Returns `None` if a reader with these mistakes refuses the file.
    pub fn new(file: &[u8], mistakes: &[&Misreading]) -> Option<MisreadFile> {
        let (mut ptm, reading) = read(mistakes, Reading::SPEC, file).ok()?;
        for edit in plane_edits(mistakes) {
            edit(&mut ptm);
        }
        let stages = mistakes.iter().map(|mistake| mistake.stage());
        Some(MisreadFile {
            reading,
            edits: formula_edits(mistakes),
            stage: stages.max().unwrap_or(Stage::File),
            ptm,
        })
    }

    /// Returns true if this reader sees the values of `request`: the stored values and, depending on the stage, the header
    /// numbers or the derived values.
    pub fn is_right(&self, request: &WriteRequest) -> bool {
        self.ptm.header.format == request.format
            && self.ptm.planes.samples.len() == request.samples.len()
            && matches_within_loss(request, &self.ptm.planes.samples)
            && self.has_equal_numbers(&MisreadFile::from_request(request), self.stage)
    }

    /// Returns true if `file`, read without mistakes, contains exactly the values that this reader sees.
    fn has_values_of(&self, file: &[u8]) -> bool {
        MisreadFile::new(file, &[]).is_some_and(|found| {
            found.ptm.planes.samples == self.ptm.planes.samples
                && found.has_equal_numbers(self, self.stage)
        })
    }

    /// Returns true if both maps have the same size and, depending on `stage`, the same header numbers or derived values.
    fn has_equal_numbers(&self, other: &MisreadFile, stage: Stage) -> bool {
        self.ptm.header.size == other.ptm.header.size
            && match stage {
                Stage::Coefficients => self.equals_in_view(other, "coef"),
                Stage::Color => VIEWS.iter().all(|light| self.equals_in_view(other, light)),
                _ => equal_header_numbers(&self.ptm, &other.ptm),
            }
    }

    /// Returns the map with the effective scales and biases, which convert raw values to the final coefficients of this reader.
    pub fn into_effective_map(self) -> Ptm {
        let mut map = self.ptm;
        if self.stage == Stage::Coefficients {
            let uniform_finals = |raw: u8| {
                let mut uniform = map.clone();
                uniform.planes.samples.fill(raw);
                formula::final_values(&uniform, &self.reading, Edits(&self.edits)).values
            };
            let [zeros, ones] = [0, 1].map(uniform_finals);
            for i in 0..6 {
                let (zero, one) = (zeros[i], ones[i]);
                map.header.scale_bias.scale[i] = one - zero;
                map.header.scale_bias.bias[i] = zero / (zero - one);
            }
        }
        map
    }

    /// Creates the file that a reader without mistakes should see for a request.
    pub fn from_request(request: &WriteRequest) -> MisreadFile {
        let (header, size) = (&request.header, request.size());
        let scale_bias = ScaleBias {
            scale: header.scale,
            bias: header.bias.map(|bias| bias as f64),
        };
        let samples = request.samples.clone();
        MisreadFile {
            reading: Reading::SPEC,
            edits: Vec::new(),
            stage: Stage::File,
            ptm: new_map(request.format, size, scale_bias, header.matrix, samples),
        }
    }

    /// Returns true if both maps have the same values in a view, up to rounding.
    fn equals_in_view(&self, other: &MisreadFile, view: &str) -> bool {
        let view: View = view.parse().expect("a view");
        let [one, other] = [self, other]
            .map(|it| formula::render(&it.ptm, &view, &it.reading, Edits(&it.edits)).samples);
        match (one, other) {
            (Samples::U8(one), Samples::U8(other)) => {
                (one.iter().zip(&other)).all(|(a, b)| a.abs_diff(*b) <= 1)
            }
            (Samples::F32(one), Samples::F32(other)) => {
                (one.iter().zip(&other)).all(|(a, b)| (a - b).abs() <= 2e-6 * a.abs().max(b.abs()))
            }
            _ => false,
        }
    }
}

/// Returns true if the scales, the biases and the matrices are equal within [`NUMBER_TOLERANCE`](super::judge::NUMBER_TOLERANCE).
fn equal_header_numbers(found: &Ptm, wanted: &Ptm) -> bool {
    let numbers = |ptm: &Ptm| {
        let mut numbers = [ptm.header.scale_bias.scale, ptm.header.scale_bias.bias].concat();
        if let (Shape::Lum(_), Shape::Lum(matrix)) = (&wanted.planes.shape, &ptm.planes.shape) {
            numbers.extend(matrix.0);
        }
        numbers
    };
    let (wanted, found) = (numbers(wanted), numbers(found));
    (wanted.iter().zip(found)).all(|(wanted, found)| is_same_number(*wanted, found))
}
