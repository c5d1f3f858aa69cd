//! Decoding of the streams of 2.9.8 on all threads
//!
//! Streams are independent, so all of them can be decoded at once; prediction and correction, which
//! go from plane to plane, come after. The result is that of [`planes::residuals`], including its
//! error: that of the first plane in the order of decoding.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::planes;
use crate::error::Result;
use crate::parts::Coded;
use crate::reading::Reading;

/// Minimum number of texels of a plane for threads: smaller planes are decoded faster than a thread starts.
const MIN_THREADED_TEXELS: usize = 1 << 16;

/// Does the same as [`planes::residuals`].
pub(super) fn residuals(coded: &Coded, reading: &Reading) -> Result<Vec<Vec<u8>>> {
    if coded.size.texels() < MIN_THREADED_TEXELS {
        return planes::residuals(coded, reading);
    }
    // Some systems read files to find the number of threads, so it is not requested for small planes.
    match std::thread::available_parallelism().map_or(1, usize::from) {
        1 => planes::residuals(coded, reading),
        threads => residuals_by(threads, coded, reading),
    }
}

fn residuals_by(threads: usize, coded: &Coded, reading: &Reading) -> Result<Vec<Vec<u8>>> {
    let sequence = &coded.plan.sequence;
    let next = AtomicUsize::new(0);
    // Each thread takes the next plane, until there is none.
    let decode_some = || {
        let mut decoded = Vec::new();
        let mut place = next.fetch_add(1, Ordering::Relaxed);
        while let Some(&plane) = sequence.get(place) {
            decoded.push((place, (reading.stream)(&coded.stream(plane))));
            place = next.fetch_add(1, Ordering::Relaxed);
        }
        decoded
    };
    let mut all: Vec<_> = std::thread::scope(|scope| {
        // This thread takes part, so that planes are decoded even if no thread can be started.
        let start = |_| std::thread::Builder::new().spawn_scoped(scope, decode_some);
        let workers: Vec<_> = (1..threads.min(sequence.len()))
            .map_while(|i| start(i).ok())
            .collect();
        let mut decoded = decode_some();
        let joined = workers.into_iter().map(std::thread::ScopedJoinHandle::join);
        decoded.extend(joined.flat_map(|decoded| decoded.expect("the codecs do not panic")));
        decoded
    });
    all.sort_by_key(|&(place, _)| place);
    all.into_iter().map(|(_, residuals)| residuals).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::error::{Error, Kind};
    use crate::parts::{Extent, Plan, PlaneStream};
    use crate::ptm::{Coding, Size};

    /// A "stream" of one byte is its plane; 255 is refused, and values below 8 only after a delay.
    fn stream(stream: &PlaneStream) -> Result<Vec<u8>> {
        if stream.bytes[0] < 8 {
            std::thread::sleep(std::time::Duration::from_micros(200));
        }
        match stream.bytes[0] {
            255 => Err(Error::new(
                "2.9.8/3",
                stream.at,
                Kind::NotRead {
                    what: "streams of 255",
                },
            )),
            value => Ok(vec![stream.plane as u8, value]),
        }
    }

    proptest! {
        #[test]
        fn threads_give_the_same_residuals_and_errors(
            payload in proptest::collection::vec(any::<u8>(), 18),
            sequence in proptest::collection::vec(0usize..18, 0..30),
            threads in 1usize..6,
        ) {
            let reading = Reading { stream, ..Reading::SPEC };
            let extent = |i| Extent { stream: i..i + 1, side: 0..0 };
            let plan = Plan {
                parameter: 0,
                steps: vec![crate::parts::Step::default(); 18],
                sequence,
                extents: (0..18).map(extent).collect(),
            };
            let size = Size { width: 1, height: 1 };
            let coded = Coded { coding: Coding::Jpeg, size, plan: &plan, at: 100, payload: &payload };
            prop_assert_eq!(residuals_by(threads, &coded, &reading), planes::residuals(&coded, &reading));
        }
    }
}
