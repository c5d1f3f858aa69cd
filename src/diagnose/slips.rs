//! Decoders of streams that go wrong in one place.

use super::stream_cache::stream_once;
use crate::error::Result;
use crate::parts::PlaneStream;

/// A decoder of streams with a slip.
pub(super) struct Slip {
    /// What it does, as a sentence without its subject.
    pub says: &'static str,
    /// What it makes of a stream.
    pub partial: fn(&PlaneStream) -> Result<Partial>,
    /// The same, with 0 for what is not known.
    pub stream: fn(&PlaneStream) -> Result<Vec<u8>>,
}

/// Slips, each as what it does and how it changes the rules of a decoder.
macro_rules! slips {
    ($($says:expr, |$rules:ident| $change:expr;)*) => {
        &[$(Slip {
            says: $says,
            partial: |stream| slipped(stream, |$rules| $change),
            stream: |stream| Ok(slipped(stream, |$rules| $change)?.samples),
        }),*]
    };
}
pub(super) use slips;

/// The samples of a stream, and how many of them were found before a decoder lost its way.
pub(super) struct Partial {
    pub samples: Vec<u8>,
    pub known: usize,
}

impl Partial {
    /// Samples that go on to the end.
    pub fn whole(samples: Vec<u8>) -> Partial {
        Partial {
            known: samples.len(),
            samples,
        }
    }

    /// What a decoder made of a stream; what cannot be read at all is as the reference reads it, or its error.
    pub fn or_right(made: Option<Partial>, stream: &PlaneStream) -> Result<Partial> {
        match made {
            Some(partial) => Ok(partial),
            None => Ok(Partial::whole(stream_once(stream)?)),
        }
    }

    /// The samples that were found of a stream.
    pub fn of(mut samples: Vec<u8>, stream: &PlaneStream) -> Partial {
        let known = samples.len();
        samples.resize(stream.size.texels(), 0);
        Partial { samples, known }
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
