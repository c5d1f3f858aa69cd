//! A file as a reader with mistakes sees it, held against the values that were asked for.

use crate::decode::decode_as;
use crate::misreadings::{Anatomy, At, Misreading, Seen, Stage, misread};
use crate::protocol::frame::{Frame, Samples, View};
use crate::ptm::{ColorMatrix, Header, Limits, Planes, Ptm, ScaleBias, Shape};
use crate::reading::Reading;
use crate::writers::judge::is_same_number;
use crate::writers::lossy::is_within;
use crate::writers::request::WriteRequest;

/// Lights that tell every coefficient from every other.
const LIGHTS: [&str; 4] = [
    "rgb:0.3125,-0.4375",
    "rgb:0,0",
    "rgb:-0.5,0.25",
    "rgb:0.125,0.75",
];

/// A file as somebody reads it.
pub(super) struct SeenFile {
    reading: Reading,
    stage: Stage,
    ptm: Ptm,
}

impl SeenFile {
    /// What a reader who makes these mistakes sees; nothing where it refuses the file.
    pub fn of(file: &[u8], mistakes: &[&Misreading]) -> Option<SeenFile> {
        let reading = misread(mistakes, Reading::SPEC);
        let mut bytes = file.to_vec();
        for mistake in mistakes {
            if let At::Bytes(edit) = mistake.at {
                match edit(&Anatomy::of(&bytes, &reading)) {
                    Seen::Refused => return None,
                    Seen::File(seen) => bytes = seen,
                }
            }
        }
        let mut ptm = decode_as(&bytes, &reading, &Limits::default()).ok()?;
        for mistake in mistakes {
            if let At::Planes(edit) = mistake.at {
                edit(&mut ptm);
            }
        }
        let stages = mistakes.iter().map(|mistake| mistake.at.stage());
        Some(SeenFile {
            reading,
            stage: stages.max().unwrap_or(Stage::File),
            ptm,
        })
    }

    /// What a reader without mistakes sees, as far as these mistakes could change it.
    pub fn plainly(file: &[u8], mistakes: &[&Misreading]) -> Option<SeenFile> {
        let stages = mistakes.iter().map(|mistake| mistake.at.stage());
        let stage = stages.max().unwrap_or(Stage::File);
        let plain = SeenFile::of(file, &[])?;
        Some(SeenFile { stage, ..plain })
    }

    /// Whether these are the values of `request`: the stored ones, or where a mistake acts later, what is made of them.
    pub fn is_right(&self, request: &WriteRequest) -> bool {
        let right = SeenFile::wanted(request);
        let found = &self.ptm;
        let same_map = found.header.format == right.ptm.header.format
            && found.header.size == right.ptm.header.size
            && found.planes.samples.len() == request.samples.len();
        same_map
            && is_within(request, &found.planes.samples)
            && match self.stage {
                Stage::Coefficients => self.shows(&right, "coef"),
                Stage::Color => LIGHTS.iter().all(|light| self.shows(&right, light)),
                _ => has_numbers(found, &right.ptm),
            }
    }

    /// Whether `file`, read rightly, has just what this reader sees.
    pub fn is_written_as_seen(&self, file: &[u8]) -> bool {
        let Some(found) = SeenFile::of(file, &[]) else {
            return false;
        };
        found.ptm.planes.samples == self.ptm.planes.samples
            && found.ptm.header.size == self.ptm.header.size
            && match self.stage {
                Stage::Coefficients => found.shows(self, "coef"),
                Stage::Color => LIGHTS.iter().all(|light| found.shows(self, light)),
                _ => has_numbers(&found.ptm, &self.ptm),
            }
    }

    /// The map as it is read.
    pub fn into_map(self) -> Ptm {
        self.ptm
    }

    /// The values of a request as a map.
    pub fn wanted(request: &WriteRequest) -> SeenFile {
        let shape = match (request.header.matrix, request.format.channels()) {
            (Some(matrix), _) => Shape::Lum(ColorMatrix(matrix)),
            (None, 18) => Shape::Rgb,
            _ => Shape::Lrgb,
        };
        SeenFile {
            reading: Reading::SPEC,
            stage: Stage::File,
            ptm: Ptm {
                header: Header {
                    format: request.format,
                    size: request.size(),
                    scale_bias: ScaleBias {
                        scale: request.header.scale,
                        bias: request.header.bias.map(|bias| bias as f64),
                    },
                },
                planes: Planes {
                    size: request.size(),
                    shape,
                    samples: request.samples.clone(),
                },
            },
        }
    }

    /// Whether both look the same in a view, as far as `f32` tells.
    fn shows(&self, other: &SeenFile, view: &str) -> bool {
        let view: View = view.parse().expect("a view");
        let frame = |of: &SeenFile| Frame::under(&of.ptm, &view, &of.reading).samples;
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

/// Whether scales, biases and matrix are about the same.
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
