//! Tests that the search for causes does a bounded amount of work for any decoder.

use ptm::Reading;
use ptm_harness::diagnose::{Cause, diagnose};
use ptm_suite::protocol::frame::{Answer, Frame, Samples, ViewKind};
use ptm_suite::protocol::request::Request;

use crate::in_process::{answer_with, misreading, reference_answer, run_all, suite_of_small_files};

/// Maximum number of answers that the search may compute.
const MAX_ANSWERS: usize = 200_000;

/// Returns the correct answer with all samples set to the same value.
fn with_uniform_samples(request: &Request) -> Answer {
    let mut answer = reference_answer(request);
    if let Answer::Decoded(frame) = &mut answer {
        match &mut frame.samples {
            Samples::U8(samples) => samples.fill(77),
            Samples::F32(samples) => samples.fill(0.5),
        }
    }
    answer
}

/// Returns the same image for every file, even for a malformed one.
fn constant_image(request: &Request) -> Answer {
    let mut frame = Frame {
        view: request.view.kind(),
        width: 3,
        height: 2,
        channels: 9,
        samples: Samples::U8(vec![0; 54]),
        lossy: false,
    };
    match frame.view {
        ViewKind::Coef => frame.samples = Samples::F32(vec![0.0; 54]),
        ViewKind::Rgb => (frame.channels, frame.samples) = (3, Samples::U8(vec![0; 18])),
        ViewKind::Raw => {}
    }
    Answer::Decoded(frame)
}

/// Returns the answer of a decoder that truncates the width and the height to eight bits.
fn with_sizes_truncated_to_bytes(request: &Request) -> Answer {
    let text = String::from_utf8_lossy(request.file);
    let mut tokens = text.split_ascii_whitespace().skip(2);
    let mut file = request.file.to_vec();
    for _ in 0..2 {
        let Some(token) = tokens.next() else { break };
        let Ok(size) = token.parse::<u32>() else {
            break;
        };
        let at = token.as_ptr() as usize - text.as_ptr() as usize;
        let low = format!("{:>1$}", size % 256, token.len());
        file[at..at + token.len()].copy_from_slice(low.as_bytes());
    }
    ptm_mistakes::answer(&[], Reading::SPEC, &file, request.view)
}

#[test]
fn search_is_bounded_for_any_decoder() {
    let suite = suite_of_small_files();
    let decoders: [(&str, fn(&Request) -> Answer, &str); 4] = [
        ("uniform", with_uniform_samples, ""),
        ("constant image", constant_image, ""),
        ("sizes in bytes", with_sizes_truncated_to_bytes, ""),
        (
            "swapped sizes",
            |request| answer_with(&[misreading("height-before-width")], request),
            "height-before-width",
        ),
    ];
    for (name, decoder, slug) in decoders {
        let run = run_all(&suite, decoder);
        let causes = diagnose(&suite, &run, &[], 2);
        let count = causes.answer_count;
        println!("{name}: {count} answers, {:?}", causes.cpu_time);
        for diagnosis in &causes.diagnoses {
            let name = match &diagnosis.cause {
                Cause::Misreading { misreading, .. } => misreading.slug,
                Cause::Described { effect, .. } => effect,
            };
            println!("  {} {name}", diagnosis.explains.len());
        }
        assert!(count <= MAX_ANSWERS, "{count}");
        let named = causes.diagnoses.iter().any(|one| {
            matches!(&one.cause, Cause::Misreading { misreading, .. } if misreading.slug == slug)
        });
        assert!(named || slug.is_empty(), "{slug} is not named");
    }
}
