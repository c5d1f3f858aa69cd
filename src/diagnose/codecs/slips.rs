//! Decoders of streams that go wrong in one place.

use super::cache::stream_once;
use crate::error::Result;
use crate::parts::PlaneStream;

/// A slip in a decoder whose decisions are these rules.
pub(super) struct Slip<R: 'static> {
    /// What it is about, with the clause of the standard.
    pub about: &'static str,
    /// What to do about it.
    pub fix: &'static str,
    /// What it does, as a sentence without its subject.
    pub says: &'static str,
    /// How it changes the rules.
    pub change: fn(&mut R),
    /// What it makes of a stream, with 0 for what is not known.
    pub stream: fn(&PlaneStream) -> Result<Vec<u8>>,
}

/// Slips, under what they are about, each as what it does and how it changes the rules of a decoder.
macro_rules! slips {
    ($(in $about:literal: $($says:expr, |$rules:ident| $change:expr;)*)*) => {
        &[$($(Slip {
            about: $about,
            fix: concat!("compare with the standard: ", $about),
            says: $says,
            change: |$rules| $change,
            stream: |stream| slipped(stream, |$rules| $change),
        },)*)*]
    };
}
pub(super) use slips;

/// A number whose lowest eight bits are taken for a signed byte.
pub(super) fn signed_byte(value: i32) -> i32 {
    i32::from(value as i8)
}

/// Whether a sample, at its place in the stream, is as it was shown.
pub(super) type IsShown<'s> = &'s dyn Fn(usize, u8) -> bool;

/// The samples of a stream, and how many of them were found before a decoder lost its way.
pub(super) struct Partial {
    pub samples: Vec<u8>,
    pub known: usize,
    /// Whether one was found that is not as it was shown; those after it are not known.
    pub is_other: bool,
    /// Whether the decoder lost its way, or came to another end than that of the data.
    pub may_refuse: bool,
}

impl Partial {
    /// Of a stream in which a decoder finds no picture.
    pub fn refused(stream: &PlaneStream) -> Partial {
        Partial {
            samples: vec![0; stream.size.texels()],
            known: 0,
            is_other: true,
            may_refuse: true,
        }
    }

    /// As the reference reads a stream that cannot be followed here.
    pub fn right(stream: &PlaneStream) -> Result<Partial> {
        let samples = stream_once(stream)?;
        Ok(Partial {
            known: samples.len(),
            samples,
            is_other: false,
            may_refuse: false,
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use crate::parts::PlaneStream;
    use crate::ptm::Format;
    use crate::suite::cases::{Expect, Suite, TableSpelling};
    use crate::suite::values::Values;

    /// Every stream of a codec that a decoder must read.
    pub fn each_stream(is_of: impl Fn(Format) -> bool, mut visit: impl FnMut(&PlaneStream)) {
        let suite = Suite::load().expect("the suite loads");
        for case in suite.cases {
            if case.expect != Expect::Decode || !is_of(case.format()) {
                continue;
            }
            let built = case.build(TableSpelling::default());
            let Values::Painted(model) = &built.values else {
                continue;
            };
            let coded = model.compressed.as_ref().expect("planes");
            for (plane, stored) in coded.planes.iter().enumerate() {
                visit(&PlaneStream {
                    format: case.format(),
                    plane,
                    at: 0,
                    bytes: &stored.stream,
                    size: model.size,
                });
            }
        }
    }
}
