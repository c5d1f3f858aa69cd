//! Parallel decoding of the streams of 2.9.8
//!
//! Streams are independent, so they are decoded in parallel. Prediction and correction depend on other planes and follow later.
//! The result equals that of [`planes::residuals`]. If several streams are invalid, the first in decoding order determines the
//! error.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::planes;
use crate::error::Result;
use crate::parts::Coded;
use crate::reading::Reading;

/// Minimum number of texels in a plane for parallel decoding. Decoding a smaller plane takes less time than starting a thread.
const MIN_THREADED_TEXELS: usize = 1 << 16;

/// Returns the same result as [`planes::residuals`].
pub(super) fn residuals(coded: &Coded, reading: &Reading) -> Result<Vec<Vec<u8>>> {
    if coded.size.texels() < MIN_THREADED_TEXELS {
        return planes::residuals(coded, reading);
    }
    // Some systems read files to determine the number of threads, so avoid the call for small planes.
    match std::thread::available_parallelism().map_or(1, usize::from) {
        1 => planes::residuals(coded, reading),
        threads => residuals_on_threads(threads, coded, reading),
    }
}

fn residuals_on_threads(threads: usize, coded: &Coded, reading: &Reading) -> Result<Vec<Vec<u8>>> {
    let sequence = &coded.plan.sequence;
    let next = AtomicUsize::new(0);
    // Each thread takes the next plane until none is left.
    let decode_some = || {
        let mut decoded = Vec::new();
        let mut index = next.fetch_add(1, Ordering::Relaxed);
        while let Some(&plane) = sequence.get(index) {
            decoded.push((index, (reading.stream)(&coded.stream(plane))));
            index = next.fetch_add(1, Ordering::Relaxed);
        }
        decoded
    };
    let mut all: Vec<_> = std::thread::scope(|scope| {
        // The current thread participates, so that decoding works even if no thread can be started.
        let start = |_| std::thread::Builder::new().spawn_scoped(scope, decode_some);
        let workers: Vec<_> = (1..threads.min(sequence.len()))
            .map_while(|i| start(i).ok())
            .collect();
        let mut decoded = decode_some();
        let joined = workers.into_iter().map(std::thread::ScopedJoinHandle::join);
        decoded.extend(joined.flat_map(|decoded| decoded.expect("the codecs do not panic")));
        decoded
    });
    all.sort_by_key(|&(index, _)| index);
    all.into_iter().map(|(_, residuals)| residuals).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::error::{Error, Kind};
    use crate::parts::{Extent, Plan, PlaneStream};
    use crate::types::{Coding, Size};

    /// Fake decoder: the samples of a one-byte stream are the plane index and the byte. Rejects the byte 255, and waits before it
    /// decodes a byte below 8.
    fn stream(stream: &PlaneStream) -> Result<Vec<u8>> {
        if stream.bytes[0] < 8 {
            std::thread::sleep(std::time::Duration::from_micros(200));
        }
        match stream.bytes[0] {
            255 => Err(Error::new(
                "2.9.8/3",
                stream.at,
                Kind::NotSupported {
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
            prop_assert_eq!(residuals_on_threads(threads, &coded, &reading), planes::residuals(&coded, &reading));
        }
    }
}
