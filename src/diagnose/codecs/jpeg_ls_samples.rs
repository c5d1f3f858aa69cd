//! What can be said of a sample of a JPEG-LS stream, so that samples which a decoder gets wrong can be described.

use std::sync::LazyLock;

use super::separate::Feature;
use crate::codec::jpeg_ls::{Mode, SampleTrace, ScanTrace, trace};
use crate::generate::plan::Stream;

/// A sample, and what its scan is coded with.
pub(super) struct Sample {
    trace: SampleTrace,
    scan: ScanTrace,
    width: usize,
    stream: Stream,
}

/// All features of samples, the plainer ones first.
pub(super) static FEATURES: LazyLock<Vec<Feature<Sample>>> = LazyLock::new(all_features);

/// The samples of a stream in their order, where it is one.
pub(super) fn samples(
    bytes: &[u8],
    (width, height): (usize, usize),
    stream: Stream,
) -> Vec<Sample> {
    let Ok((traced, scan)) = trace(bytes, width as u32, height as u32) else {
        return Vec::new();
    };
    let sample = |trace| Sample {
        trace,
        scan,
        width,
        stream,
    };
    traced.into_iter().map(sample).collect()
}

impl Sample {
    fn is_in(&self, mode: Mode) -> bool {
        self.trace.mode == mode
    }

    fn ends_run(&self) -> bool {
        matches!(self.trace.mode, Mode::EndOfRun | Mode::EndOfRunAlike)
    }

    fn is_of_run(&self) -> bool {
        !self.is_in(Mode::Regular)
    }

    /// d − b, b − c and c − a (A.3.2).
    fn gradients(&self) -> [i32; 3] {
        let [a, b, c, d] = self.trace.neighbors;
        [d - b, b - c, c - a]
    }

    /// Whether it is coded in regular mode and one of its gradients is this.
    fn has_gradient(&self, gradient: i32) -> bool {
        self.is_in(Mode::Regular) && self.gradients().contains(&gradient)
    }

    /// Whether the sums of its context were halved before.
    fn is_halved(&self) -> bool {
        self.trace.met >= self.scan.reset as u32
    }
}

type Row = (&'static str, fn(&Sample) -> bool);

/// What is so of whole streams.
const STREAM_ROWS: &[Row] = &[
    ("of streams with a loss (NEAR over 0)", |s| s.scan.near > 0),
    ("of streams with presets (LSE)", |s| {
        s.stream.presets.is_some()
    }),
    (
        "of streams whose component has another number than 1",
        |s| s.stream.component != 1,
    ),
    (
        "of streams whose presets (LSE) stand before the frame header",
        |s| s.stream.presets.is_some() && s.stream.frame_moved,
    ),
    ("of streams with a RESET other than 64", |s| {
        s.scan.reset != 64
    }),
    (
        "of streams with presets (LSE) in which some of T1, T2 and T3 are 0, for the default, and others are not",
        |s| {
            s.stream.presets.is_some_and(|p| {
                let zeros = [p.t1, p.t2, p.t3].map(|t| t == 0);
                zeros.contains(&true) && zeros.contains(&false)
            })
        },
    ),
    ("of streams with presets (LSE) whose MAXVAL is not 0", |s| {
        s.stream.presets.is_some_and(|p| p.maxval != 0)
    }),
    (
        "of streams with presets (LSE) whose T1, T2 or T3 is not 0",
        |s| {
            s.stream
                .presets
                .is_some_and(|p| [p.t1, p.t2, p.t3] != [0; 3])
        },
    ),
];

/// How many of [`FEATURES`], the first ones, are of whole streams.
pub(super) const OF_STREAMS: usize = STREAM_ROWS.len();

const ROWS: &[Row] = &[
    ("in regular mode", |s| s.is_in(Mode::Regular)),
    ("in a run or at its end", Sample::is_of_run),
    ("in a run", |s| s.is_in(Mode::Run)),
    ("that end a run", Sample::ends_run),
    ("that end a run, a and b being different (RItype 0)", |s| {
        s.is_in(Mode::EndOfRun)
    }),
    ("that end a run, a and b being alike (RItype 1)", |s| {
        s.is_in(Mode::EndOfRunAlike)
    }),
    ("that end a run, a being over b", |s| {
        s.is_in(Mode::EndOfRun) && s.trace.neighbors[0] > s.trace.neighbors[1]
    }),
    ("that end a run, b being over a", |s| {
        s.is_in(Mode::EndOfRun) && s.trace.neighbors[0] < s.trace.neighbors[1]
    }),
    (
        "that end a run, a and b differing by no more than the loss",
        |s| s.is_in(Mode::EndOfRunAlike) && s.trace.neighbors[0] != s.trace.neighbors[1],
    ),
    (
        "that end a run of a stream with a loss (NEAR over 0)",
        |s| s.ends_run() && s.scan.near > 0,
    ),
    ("that end a run with an error below 0", |s| {
        s.ends_run() && s.trace.error < 0
    }),
    (
        "that end a run where negative errors have the shorter code",
        |s| s.ends_run() && s.trace.is_negative_first && s.trace.k == 0,
    ),
    ("that end a run with a code of k = 0", |s| {
        s.ends_run() && s.trace.k == 0
    }),
    (
        "that end a run with a code of limited length (escape)",
        |s| s.ends_run() && s.trace.is_escaped,
    ),
    (
        "that end a run after their counters were halved (RESET)",
        |s| s.ends_run() && s.is_halved(),
    ),
    ("in a run to the end of the row", |s| {
        s.is_in(Mode::Run) && s.trace.ends_row
    }),
    (
        "in or after the first run of a row, RUNindex being over 0 from a row before",
        |s| s.is_of_run() && s.trace.is_first_run && s.trace.run_index > 0,
    ),
    (
        "in or after the first run of a row, RUNindex being 4 or more (J over 0) from a row before",
        |s| s.is_of_run() && s.trace.is_first_run && s.trace.run_index > 3,
    ),
    ("in or after a run that begins with RUNindex over 0", |s| {
        s.is_of_run() && s.trace.run_index > 0
    }),
    (
        "in or after a run that begins with RUNindex 4 or more (J over 0)",
        |s| s.is_of_run() && s.trace.run_index > 3,
    ),
    ("in the first column", |s| s.trace.column == 0),
    ("in the first column of a row that is not the first", |s| {
        s.trace.column == 0 && s.trace.row > 0
    }),
    ("in the first column of the third row or a later one", |s| {
        s.trace.column == 0 && s.trace.row > 1
    }),
    ("in the first column, c and b being different", |s| {
        s.trace.column == 0 && s.trace.neighbors[2] != s.trace.neighbors[1]
    }),
    ("in the first column, in regular mode", |s| {
        s.trace.column == 0 && s.is_in(Mode::Regular)
    }),
    ("in the first row", |s| s.trace.row == 0),
    ("in a row that is not the first", |s| s.trace.row > 0),
    ("in the last column of the third row or a later one", |s| {
        s.trace.column + 1 == s.width && s.trace.row > 1
    }),
    ("in the last column", |s| s.trace.column + 1 == s.width),
    ("in the last column of a row that is not the first", |s| {
        s.trace.column + 1 == s.width && s.trace.row > 0
    }),
    ("in the mirrored neighborhood (SIGN −1)", |s| {
        s.is_in(Mode::Regular) && s.trace.sign < 0
    }),
    ("whose context is met for the first time", |s| {
        s.is_in(Mode::Regular) && s.trace.met == 0
    }),
    ("whose context was met before", |s| {
        s.is_in(Mode::Regular) && s.trace.met > 0
    }),
    ("whose context was halved before (N at RESET)", |s| {
        s.is_in(Mode::Regular) && s.is_halved()
    }),
    ("whose counters were halved before (N at RESET)", |s| {
        !s.is_in(Mode::Run) && s.is_halved()
    }),
    ("whose prediction is corrected (C other than 0)", |s| {
        s.trace.correction != 0
    }),
    ("whose prediction is corrected upward (C over 0)", |s| {
        s.trace.correction > 0
    }),
    ("whose prediction is corrected downward (C below 0)", |s| {
        s.trace.correction < 0
    }),
    ("whose correction C is at its limit", |s| {
        s.trace.correction == -128 || s.trace.correction == 127
    }),
    (
        "whose corrected prediction has to be limited to 0 … MAXVAL",
        |s| s.trace.is_limited,
    ),
    ("whose error is taken modulo RANGE", |s| s.trace.is_wrapped),
    ("with an error below 0", |s| s.trace.error < 0),
    ("with a code of limited length (escape)", |s| {
        s.trace.is_escaped
    }),
    ("with a code of k = 0", |s| {
        !s.is_in(Mode::Run) && s.trace.k == 0
    }),
    (
        "in regular mode whose negative errors have the shorter code (k = 0, 2B ≤ −N)",
        |s| s.is_in(Mode::Regular) && s.trace.is_negative_first,
    ),
    ("whose c is not between a and b", |s| {
        let [a, b, c, _] = s.trace.neighbors;
        s.is_in(Mode::Regular) && !(a.min(b)..=a.max(b)).contains(&c)
    }),
    ("whose c is between a and b", |s| {
        let [a, b, c, _] = s.trace.neighbors;
        s.is_in(Mode::Regular) && c > a.min(b) && c < a.max(b)
    }),
];

/// A gradient of just T1, T2 or T3, or of the opposite.
fn of_threshold(i: usize, sign: i32) -> Feature<Sample> {
    let minus = if sign < 0 { "−" } else { "" };
    Feature {
        says: format!("with a gradient of just {minus}T{}", i + 1),
        holds: Box::new(move |s| s.has_gradient(sign * s.scan.thresholds[i])),
    }
}

fn all_features() -> Vec<Feature<Sample>> {
    let rows = STREAM_ROWS.iter().chain(ROWS);
    let rows = rows.map(|&(says, holds)| Feature {
        says: says.to_owned(),
        holds: Box::new(holds) as Box<dyn Fn(&Sample) -> bool + Send + Sync>,
    });
    let mut all: Vec<Feature<Sample>> = rows.collect();
    all.extend((0..3).flat_map(|i| [1, -1].map(|sign| of_threshold(i, sign))));
    all.push(Feature {
        says: "with a gradient of just NEAR or −NEAR, not 0".to_owned(),
        holds: Box::new(|s| {
            let near = s.scan.near;
            near > 0 && (s.has_gradient(near) || s.has_gradient(-near))
        }),
    });
    for k in 1..8 {
        all.push(Feature {
            says: format!("with a code of k = {k} or more"),
            holds: Box::new(move |s| s.trace.k >= k),
        });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::{FEATURES, samples};
    use crate::codec::jpeg_ls::{JpegLsOptions, encode};
    use crate::generate::plan::Stream;

    #[test]
    fn features_follow_from_how_a_sample_is_coded() {
        let options = JpegLsOptions {
            near: 0,
            presets: None,
        };
        let stream = encode(&[5, 5, 5, 5, 9, 5, 5, 5], 4, 2, &options).stream;
        let samples = samples(&stream, (4, 2), Stream::PLAIN);
        let says = |place: usize| -> Vec<&str> {
            let holds = FEATURES.iter().filter(|one| (one.holds)(&samples[place]));
            holds.map(|one| one.says.as_str()).collect()
        };
        assert!(says(0).contains(&"that end a run, a and b being alike (RItype 1)"));
        assert!(says(1).contains(&"in regular mode"), "{:?}", says(1));
        assert!(says(3).contains(&"in the last column"));
        assert!(says(4).contains(&"in the first column of a row that is not the first"));
    }
}
