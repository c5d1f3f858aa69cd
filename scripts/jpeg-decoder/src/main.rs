//! A PTM decoder that takes the samples of JPEG planes from the crate jpeg-decoder, and everything else from the reference.
//!
//! ```text
//! cargo build --release --manifest-path scripts/jpeg-decoder/Cargo.toml
//! ptm-conform check --clause 2.9.8/11 -- scripts/jpeg-decoder/target/release/ptm-with-jpeg-decoder
//! ```
//!
//! With `--shard 1/1 --report FILE`, `check` records the answers. `tests/it/recordings/jpeg-decoder-0.3.2.answers.gz` was recorded
//! this way on an x86-64 processor with SSSE3.

use std::env;
use std::io::{self, Write};
use std::process::ExitCode;

use ptm::{Coding, Reading};
use ptm_mistakes::{Change, Misreading, Step};
use ptm_suite::protocol::frame::{Answer, EXIT_MALFORMED, EXIT_UNSUPPORTED, View};

fn main() -> ExitCode {
    let words: Vec<String> = env::args().collect();
    let [_, view, file] = &words[..] else {
        eprintln!("usage: ptm-with-jpeg-decoder VIEW FILE");
        return ExitCode::from(2);
    };
    let (Ok(view), Ok(file)) = (view.parse(), std::fs::read(file)) else {
        return ExitCode::from(2);
    };
    match answer(&file, &view) {
        Answer::Decoded(frame) => {
            let mut out = io::BufWriter::new(io::stdout().lock());
            let written = frame.write(&mut out).and_then(|()| out.flush());
            written.map_or(ExitCode::from(2), |()| ExitCode::SUCCESS)
        }
        Answer::Rejected => ExitCode::from(EXIT_MALFORMED as u8),
        _ => ExitCode::from(EXIT_UNSUPPORTED as u8),
    }
}

fn answer(file: &[u8], view: &View) -> Answer {
    let is_jpeg = |ptm: &ptm::Ptm| ptm.header.format.coding() == Some(Coding::Jpeg);
    if !ptm::decode(file).is_ok_and(|ptm| is_jpeg(&ptm)) {
        // Only legal JPEG files are of interest here; the reference answers for the others.
        return ptm_mistakes::answer(&[], Reading::SPEC, file, view);
    }
    // The samples of JPEG planes come from the crate.
    let change = Change::Reading(|r| {
        r.stream = |stream| {
            jpeg_decoder::Decoder::new(stream.bytes)
                .decode()
                .or_else(|error| {
                    eprintln!("plane {}: {error}", stream.plane);
                    // Any error refuses the file.
                    ptm::decode(&[]).map(|_| Vec::new())
                })
        };
    });
    let codec = Misreading {
        step: Step::find("stream"),
        ..Misreading::unlisted("2.9.8/11", change)
    };
    ptm_mistakes::answer(&[&codec], Reading::SPEC, file, view)
}
