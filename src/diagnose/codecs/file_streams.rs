//! The streams of a file's planes, beside what should come of them and what a decoder shows of them.
//!
//! What a decoder with a slip makes of a stream is known to the sample. So a slip is held against everything that was shown:
//! against the samples of each plane that nothing but its stream makes, up to the first that is another, and against files
//! that the decoder reads right.

use std::sync::{OnceLock, PoisonError};

use super::cache::stream_once;
use super::inverse_dcts::ShownBlock;
use super::jpeg_ls_slips;
use super::jpeg_slips;
use super::slips::{IsShown, Partial};
use super::stream_slips::StreamSlip;
use crate::codec::jpeg::ZIGZAG;
use crate::diagnose::failure_mode::FailureMode;
use crate::diagnose::pair::distance;
use crate::diagnose::witness::Witness;
use crate::evaluate::final_coefficient;
use crate::generate::planes::StoredPlane;
use crate::parts::PlaneStream;
use crate::protocol::frame::{Frame, Samples, View};
use crate::session::observation::Response;
use crate::suite::compare::is_close;

/// What is shown of a plane, as it is stored.
enum Shown {
    Bytes(Vec<u8>),
    /// Final values, and what each stored value makes.
    Finals(Vec<f32>, Box<[f64]>),
}

/// What became of a file.
enum Outcome {
    /// It is right: every plane is known.
    Right,
    /// A picture that is not; of each plane that nothing but its stream makes.
    Shown(Vec<Option<Shown>>),
    /// No picture.
    Refused,
    /// Colors, right or wrong, which tell nothing of single planes.
    Colors,
}

/// A stream, taken apart.
enum Parts {
    Jpeg(jpeg_slips::Traced),
    JpegLs(jpeg_ls_slips::Stored),
}

/// What is kept of the streams before.
#[derive(Default)]
struct Kept {
    jpeg: Option<jpeg_slips::Kept>,
    jpeg_ls: Option<jpeg_ls_slips::Kept>,
}

/// How a decoder with slips would do on a file, and how this one did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::diagnose) enum Fit {
    /// It would show the same, also what is right.
    Unmoved,
    /// It would show the same, with so many wrong samples that are compared.
    Same(usize),
    /// It would show something else, or get a file wrong that is right.
    Other,
    /// It may refuse the file, as was done.
    Refused,
    /// It would show a picture of a file that was refused.
    Picture,
    /// Colors are shown.
    Unknown,
}

/// The streams of a file.
pub(in crate::diagnose) struct FileStreams<'w> {
    streams: Vec<PlaneStream<'w>>,
    parts: Vec<OnceLock<Option<Parts>>>,
    right: Vec<Vec<u8>>,
    /// The samples of each plane that side information corrects: what a stream has there is not seen.
    records: Vec<&'w [(u32, u8)]>,
    outcome: Outcome,
    /// By how much samples may differ that inverse transforms make.
    slack: u8,
}

impl<'w> FileStreams<'w> {
    /// Those of a file whose planes are known.
    pub fn of(witness: &'w Witness) -> Option<FileStreams<'w>> {
        let model = witness.model()?;
        let planes = &model.compressed.as_ref()?.planes;
        let stream = |(plane, stored): (usize, &'w StoredPlane)| PlaneStream {
            format: model.format,
            plane,
            at: 0,
            bytes: &stored.stream,
            size: model.size,
        };
        let streams: Vec<PlaneStream> = planes.iter().enumerate().map(stream).collect();
        let right: Option<Vec<Vec<u8>>> = streams.iter().map(|one| stream_once(one).ok()).collect();
        let outcome = match &witness.observation.response {
            _ if FailureMode::of(witness).is_some() => Outcome::Refused,
            _ if matches!(witness.observation.view, View::Rgb(_)) => Outcome::Colors,
            _ if !witness.failed => Outcome::Right,
            Response::Picture {
                frame: Some(frame), ..
            } => Outcome::Shown(shown(witness, frame, streams.len())?),
            _ => return None,
        };
        Some(FileStreams {
            parts: streams.iter().map(|_| OnceLock::new()).collect(),
            right: right?,
            slack: u8::from(model.format.is_jpeg()),
            outcome,
            records: planes.iter().map(|stored| &stored.records[..]).collect(),
            streams,
        })
    }

    /// How many bytes the streams have.
    pub fn len(&self) -> usize {
        self.streams.iter().map(|stream| stream.bytes.len()).sum()
    }

    fn is_near(&self, a: u8, b: u8) -> bool {
        distance(a, b) <= self.slack
    }

    fn is_right(&self, plane: usize, place: usize, sample: u8) -> bool {
        self.is_near(sample, self.right[plane][place])
    }

    fn is_corrected(&self, plane: usize, place: usize) -> bool {
        let mut records = self.records[plane].iter();
        records.any(|&(position, _)| position as usize == place)
    }

    fn is_shown(&self, shown: &Shown, place: usize, sample: u8) -> bool {
        match shown {
            Shown::Bytes(bytes) => self.is_near(sample, bytes[place]),
            Shown::Finals(values, finals) => {
                let step = (finals[1] - finals[0]).abs() * f64::from(self.slack);
                is_close(finals[usize::from(sample)], f64::from(values[place]), step)
            }
        }
    }

    /// The blocks of JPEG streams whose samples are shown as bytes, or are right.
    pub fn shown_blocks(&self) -> Vec<ShownBlock> {
        let mut blocks = Vec::new();
        for plane in 0..self.streams.len() {
            let bytes = match &self.outcome {
                Outcome::Right => &self.right[plane],
                Outcome::Shown(shown) => match &shown[plane] {
                    Some(Shown::Bytes(bytes)) => bytes,
                    _ => continue,
                },
                _ => continue,
            };
            let Some(Parts::Jpeg((traced, steps))) = self.parts(plane) else {
                continue;
            };
            let size = self.streams[plane].size;
            let (width, height) = (size.width as usize, size.height as usize);
            for (number, one) in traced.iter().enumerate() {
                let across = width.div_ceil(8);
                let (left, top) = (number % across * 8, number / across * 8);
                let mut coefficients = [0; 64];
                for (k, place) in ZIGZAG.into_iter().enumerate() {
                    coefficients[usize::from(place)] = one.coefficients[k] * i32::from(steps[k]);
                }
                let samples = std::array::from_fn(|i| {
                    let (x, y) = (left + i % 8, top + i / 8);
                    (x < width && y < height).then(|| bytes[y * width + x])
                });
                blocks.push(ShownBlock {
                    coefficients,
                    samples,
                });
            }
        }
        blocks
    }

    /// Whether a decoder with these slips gets any of the streams wrong, or loses its way in it. Of a file that is read right
    /// the latter says nothing: it may be lucky.
    pub fn are_changed_by(&self, slips: &[StreamSlip]) -> bool {
        let may_be_lucky = matches!(self.outcome, Outcome::Right);
        self.any_made(slips, |made| {
            made.is_other || made.known < made.samples.len() && !may_be_lucky
        })
    }

    /// Whether a decoder with these slips makes a wrong sample.
    fn are_spoiled_by(&self, slips: &[StreamSlip]) -> bool {
        self.any_made(slips, |made| made.is_other)
    }

    /// Whether this is so of any stream, as these slips make it to the first wrong sample.
    fn any_made(&self, slips: &[StreamSlip], is_so: impl Fn(&Partial) -> bool) -> bool {
        let mut kept = Kept::default();
        (0..self.streams.len()).any(|plane| {
            let is_right: IsShown = &|place, sample| {
                self.is_right(plane, place, sample) || self.is_corrected(plane, place)
            };
            let made = self.made(slips, plane, &mut kept, is_right);
            made.is_some_and(|made| is_so(&made))
        })
    }

    /// Whether this is so of any stream, as these slips make it to its end.
    fn any_followed(&self, slips: &[StreamSlip], is_so: impl Fn(&Partial) -> bool) -> bool {
        let mut kept = Kept::default();
        (0..self.streams.len()).any(|plane| {
            let made = self.made(slips, plane, &mut kept, &|_, _| true);
            made.is_some_and(|made| is_so(&made))
        })
    }

    /// What a decoder with these slips would do, held against what this one did.
    pub fn fit(&self, slips: &[StreamSlip]) -> Fit {
        match &self.outcome {
            Outcome::Right if self.are_spoiled_by(slips) => Fit::Other,
            Outcome::Right => Fit::Unmoved,
            Outcome::Colors => Fit::Unknown,
            Outcome::Shown(shown) => self.fit_of_picture(slips, shown),
            Outcome::Refused if self.any_followed(slips, |made| made.may_refuse) => Fit::Refused,
            Outcome::Refused => Fit::Picture,
        }
    }

    fn fit_of_picture(&self, slips: &[StreamSlip], shown: &[Option<Shown>]) -> Fit {
        let mut kept = Kept::default();
        let mut wrong = 0;
        let is_keeping = keeps(slips);
        for (plane, shown) in shown.iter().enumerate() {
            let made = match shown {
                Some(shown) => {
                    let as_shown: IsShown = &|place, sample| self.is_shown(shown, place, sample);
                    self.made(slips, plane, &mut kept, as_shown)
                }
                None if is_keeping => self.made(slips, plane, &mut kept, &|_, _| true),
                None => continue,
            };
            let Some(made) = made else {
                return Fit::Other;
            };
            if made.is_other {
                return Fit::Other;
            }
            if let Some(shown) = shown {
                let known = made.samples[..made.known].iter().enumerate();
                wrong += known
                    .filter(|&(place, &sample)| !self.is_right(plane, place, sample))
                    .count();
                // Where it loses its way samples are wrong from there on.
                let is_lost = made.known < made.samples.len();
                wrong += usize::from(is_lost && self.first_wrong(plane, shown) == Some(made.known));
            }
        }
        if wrong == 0 {
            Fit::Unmoved
        } else {
            Fit::Same(wrong)
        }
    }

    /// The first sample of a plane that is shown wrong.
    fn first_wrong(&self, plane: usize, shown: &Shown) -> Option<usize> {
        let mut right = self.right[plane].iter().enumerate();
        right.position(|(place, &right)| !self.is_shown(shown, place, right))
    }

    /// For each plane that is shown wrong, whether a decoder with these slips makes its first wrong sample as it was shown,
    /// and all before it.
    pub fn begins(&self, slips: &[StreamSlip]) -> Vec<bool> {
        let Outcome::Shown(shown) = &self.outcome else {
            return Vec::new();
        };
        let mut kept = Kept::default();
        let planes = shown.iter().enumerate();
        let begins = planes.filter_map(|(plane, shown)| {
            let shown = shown.as_ref()?;
            let first = self.first_wrong(plane, shown)?;
            let as_shown: IsShown =
                &|place, sample| place > first || self.is_shown(shown, place, sample);
            let made = self.made(slips, plane, &mut kept, as_shown)?;
            let is_lost = made.known == first && made.known < made.samples.len();
            Some(!made.is_other && (made.known > first || is_lost))
        });
        begins.collect()
    }

    /// A stream, taken apart; nothing where the reference does not read it.
    fn parts(&self, plane: usize) -> Option<&Parts> {
        let stream = &self.streams[plane];
        let parts = self.parts[plane].get_or_init(|| match stream.format.is_jpeg() {
            true => jpeg_slips::traced(stream).map(Parts::Jpeg),
            false => jpeg_ls_slips::stored(stream).map(Parts::JpegLs),
        });
        parts.as_ref()
    }

    /// What a decoder with these slips makes of a stream.
    fn made(
        &self,
        slips: &[StreamSlip],
        plane: usize,
        kept: &mut Kept,
        is_shown: IsShown,
    ) -> Option<Partial> {
        let stream = &self.streams[plane];
        Some(match self.parts(plane)? {
            Parts::Jpeg(traced) => {
                let mut rules = jpeg_slips::RIGHT;
                for slip in slips {
                    slip.change_jpeg(&mut rules);
                }
                jpeg_slips::decode(stream, traced, &rules, &mut kept.jpeg, is_shown)
            }
            Parts::JpegLs(stored) => {
                let mut rules = jpeg_ls_slips::RIGHT;
                for slip in slips {
                    slip.change_jpeg_ls(&mut rules);
                }
                jpeg_ls_slips::decode(stream, stored, &rules, &mut kept.jpeg_ls, is_shown)
            }
        })
    }
}

/// Whether streams of this file come out wrong with a slip, by more than inverse transforms may differ.
pub(in crate::diagnose) fn acts_on(slip: StreamSlip, witness: &Witness) -> bool {
    if !slip.is_of(witness.case.format()) {
        return false;
    }
    let known = || witness.slips.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(&acts) = known().get(slip.effect()) {
        return acts;
    }
    let acts = FileStreams::of(witness).is_some_and(|streams| streams.are_changed_by(&[slip]));
    known().insert(slip.effect(), acts);
    acts
}

/// Whether what was received is what a decoder with these slips finds, as far as it does not lose its way. Only planes are
/// compared that nothing but their stream makes; where these are right, the slips change the stream of another. Colors of a
/// decoder that loses its way may be any.
pub(in crate::diagnose) fn is_shown(slips: &[StreamSlip], witness: &Witness) -> bool {
    let is_lost = |made: &Partial| made.known < made.samples.len();
    FileStreams::of(witness).is_some_and(|streams| match streams.fit(slips) {
        Fit::Same(_) | Fit::Unmoved => true,
        Fit::Unknown => streams.any_followed(slips, is_lost),
        _ => false,
    })
}

/// Whether a decoder with these slips keeps something from one stream to the next.
fn keeps(slips: &[StreamSlip]) -> bool {
    let mut rules = jpeg_ls_slips::RIGHT;
    let mut jpeg = jpeg_slips::RIGHT;
    for slip in slips {
        slip.change_jpeg_ls(&mut rules);
        slip.change_jpeg(&mut jpeg);
    }
    rules.is_keeping || jpeg.is_keeping
}

/// What a picture shows of each plane that nothing but its stream makes, bottom row first.
fn shown(witness: &Witness, frame: &Frame, planes: usize) -> Option<Vec<Option<Shown>>> {
    let ptm = witness.decoded().as_ref().ok()?;
    let (w, h) = (
        ptm.planes.size.width as usize,
        ptm.planes.size.height as usize,
    );
    let channels = frame.channels as usize;
    if channels != planes || (frame.width as usize, frame.height as usize) != (w, h) {
        return None;
    }
    let at = |plane: usize, place: usize| ((h - 1 - place / w) * w + place % w) * channels + plane;
    let of_plane = |plane: usize| match &frame.samples {
        Samples::U8(bytes) => Shown::Bytes((0..w * h).map(|i| bytes[at(plane, i)]).collect()),
        Samples::F32(values) => {
            let finals = (0..=255).map(|sample| match channels {
                8 | 9 if plane > 5 => f64::from(sample),
                _ => final_coefficient(sample, plane, &ptm.header.scale_bias),
            });
            let values = (0..w * h).map(|i| values[at(plane, i)]).collect();
            Shown::Finals(values, finals.collect())
        }
    };
    let planes = (0..planes).map(|plane| witness.is_of_stream(plane).then(|| of_plane(plane)));
    Some(planes.collect())
}
