//! The diagnosis names the mistakes of a failing decoder.

use std::collections::HashMap;

use ptm_conform::Reading;
use ptm_conform::diagnose::{Cause, Diagnosis, applies, composable, diagnose};
use ptm_conform::misreadings::{self, Misreading};
use ptm_conform::protocol::frame::{Answer, Frame, Samples, View, ViewKind};
use ptm_conform::ptm::Format;
use ptm_conform::runner::run::Request;
use ptm_conform::session::outcome::Outcome;
use ptm_conform::session::run::Run;
use ptm_conform::strength::matrix::ask_all;
use ptm_conform::suite::cases::{Case, Expect, Suite, TableSpelling};

use crate::in_process::{jobs, misread, misreading, right, run_all, suite};

/// Returns the causes that are found, without a fault of the search.
fn causes(suite: &Suite, run: &Run) -> Vec<Diagnosis> {
    let causes = diagnose(suite, run, &[], jobs());
    assert!(causes.faults.is_empty(), "{:?}", causes.faults);
    causes.diagnoses
}

fn failures(run: &Run) -> Vec<usize> {
    run.judgement.with(Outcome::Fail).collect()
}

/// Returns the misreadings that are named, or said to look the same.
fn slugs(diagnosis: &Diagnosis) -> Vec<&'static str> {
    let (first, alike) = match &diagnosis.cause {
        Cause::Misreading {
            misreading, alike, ..
        } => (Some(*misreading), alike),
        Cause::Described { alike, .. } => (None, alike),
    };
    let all = first.into_iter().chain(alike.iter().copied());
    all.map(|misreading| misreading.slug).collect()
}

fn words(diagnosis: &Diagnosis) -> String {
    match &diagnosis.cause {
        Cause::Misreading { misreading, .. } => misreading.slug.to_owned(),
        Cause::Described {
            effect, example, ..
        } => format!("{effect} [{example}]"),
    }
}

/// Changes the correct answer as a wrong decoder does.
type Wrong = fn(&Request, Answer) -> Answer;

/// Runs a decoder that changes the correct answers.
fn run_of(suite: &Suite, wrong: impl Fn(&Request, Answer) -> Answer + Sync) -> Run {
    run_all(suite, |request| wrong(request, right(request)))
}

/// Returns the diagnosis of a decoder that changes the correct answers, in words.
fn diagnosed(suite: &Suite, wrong: impl Fn(&Request, Answer) -> Answer + Sync) -> Vec<String> {
    let run = run_of(suite, wrong);
    let diagnoses = causes(suite, &run);
    let explained = diagnoses
        .iter()
        .flat_map(|one| one.explains.iter().chain(&one.partly));
    let mut explained: Vec<usize> = explained.copied().collect();
    explained.sort_unstable();
    assert_eq!(explained, failures(&run), "every failure has one diagnosis");
    let lines = diagnoses.iter().map(|one| {
        let (explains, partly, except) = (one.explains.len(), one.partly.len(), one.except.len());
        format!("{explains}+{partly}-{except}: {}", words(one))
    });
    let lines: Vec<String> = lines.collect();
    println!("  {}", lines.join("\n  "));
    lines
}

/// Answers that a search may make for each case, however much fails.
const WORK: usize = 200;

#[test]
fn a_search_among_failures_that_share_nothing_ends() {
    let mut suite = suite().prepared();
    suite.cases.retain(|case| !case.format().is_compressed());
    let run = run_of(&suite, |_, _| {
        Answer::Decoded(Frame {
            view: ViewKind::Raw,
            width: 1,
            height: 1,
            channels: 9,
            samples: Samples::U8(b"123456789".to_vec()),
            lossy: false,
        })
    });
    let failing = failures(&run).len();
    let causes = diagnose(&suite, &run, &[], jobs());
    println!("{failing} failures, {} answers", causes.answered);
    assert!(failing > 500);
    let limit = WORK * suite.cases.len();
    assert!(causes.answered < limit, "{}", causes.answered);
}

#[test]
fn a_mistake_in_one_color_is_named_with_it() {
    let wraps = misreading("color-wraps");
    let causes = diagnosed(&suite().prepared(), |request, answer| {
        let wrong = misread(&[wraps], request);
        match (answer, wrong) {
            (Answer::Decoded(mut frame), Answer::Decoded(wrong)) if frame.view == ViewKind::Rgb => {
                if let (Samples::U8(right), Samples::U8(wrong)) =
                    (&mut frame.samples, wrong.samples)
                {
                    let blue = right.iter_mut().zip(wrong).skip(2).step_by(3);
                    blue.for_each(|(right, wrong)| *right = wrong);
                }
                Answer::Decoded(frame)
            }
            (Answer::Decoded(_), _) => Answer::Unsupported,
            (other, _) => other,
        }
    });
    for part in ["computes a color", "mod(", "only in blue"] {
        assert!(causes[0].contains(part), "{causes:#?}");
    }
}

/// Turns every second stored row.
fn snaking(frame: &Frame) -> Frame {
    let mut turned = frame.clone();
    if let Samples::U8(samples) = &mut turned.samples {
        let (width, channels) = (frame.width as usize, frame.channels as usize);
        let rows = samples.chunks_exact_mut(width * channels).rev();
        for row in rows.skip(1).step_by(2) {
            let texels: Vec<u8> = row.rchunks_exact(channels).flatten().copied().collect();
            row.copy_from_slice(&texels);
        }
    }
    turned
}

#[test]
fn rows_that_turn_are_described_as_places() {
    let mut suite = suite().prepared();
    suite.cases.retain(|case| case.format() == Format::Lrgb);
    let causes = diagnosed(&suite, |_, answer| match answer {
        Answer::Decoded(frame) if frame.view == ViewKind::Raw => Answer::Decoded(snaking(&frame)),
        Answer::Decoded(_) => Answer::Unsupported,
        other => other,
    });
    let says = "the correct values in the wrong places";
    assert!(causes[0].contains(says), "{causes:#?}");
}

/// A decoder without a format refuses some of its files before it sees their format, as any other.
#[test]
fn a_format_of_which_no_file_is_decoded_is_unsupported_though_some_are_refused() {
    let mut suite = suite().prepared();
    let is_wanted = |case: &Case| match case.format() {
        Format::Lum => case.expect == Expect::Decode,
        format => case.first && format == Format::Rgb,
    };
    suite.cases.retain(is_wanted);
    let is_refused = |file: &[u8]| file.len().is_multiple_of(7);
    let is_lum = |file: &[u8]| file.windows(14).any(|word| word == b"PTM_FORMAT_LUM");
    let run = run_of(&suite, |request, answer| match answer {
        Answer::Decoded(_) if is_lum(request.file) => match is_refused(request.file) {
            true => Answer::Rejected,
            false => Answer::Unsupported,
        },
        other => other,
    });
    let count = |outcome| run.judgement.with(outcome).count();
    let (refused, unsupported) = (count(Outcome::Fail), count(Outcome::Unsupported));
    assert!(unsupported > 3 * refused, "{refused} {unsupported}");
    let lum = (suite.cases.iter()).filter(|case| case.format() == Format::Lum);
    let of_length = lum.filter(|case| is_refused(&case.build(TableSpelling::default()).file));
    assert!((1..=of_length.count()).contains(&refused), "{refused}");
}

#[test]
fn a_mistake_that_the_catalog_lacks_is_described() {
    let suite = suite().prepared();
    let decoders: &[(&str, Wrong, &[&str])] = &[
        (
            "too wide",
            |_, answer| match answer {
                Answer::Decoded(frame) if frame.width > 16 => Answer::Rejected,
                other => other,
            },
            &["refuses every legal file with", "columns"],
        ),
        (
            "crashes on tables over 256",
            |request, answer| {
                let header = &request.file[..request.file.len().min(200)];
                let header = String::from_utf8_lossy(header);
                let count = header.split_once(" N_LUT_ENTRIES");
                let count = count.and_then(|(before, _)| before.rsplit('\n').next()?.parse().ok());
                match answer {
                    Answer::Decoded(_) if count > Some(256_u32) => {
                        Answer::Crashed("signal 11".to_owned())
                    }
                    other => other,
                }
            },
            &["crashes", "more than 256 entries"],
        ),
        (
            "highest bit of a3",
            |_, answer| {
                edited(answer, ViewKind::Raw, |frame, samples| {
                    for texel in samples.chunks_exact_mut(frame) {
                        let a3 = texel.iter_mut().skip(3).step_by(6);
                        a3.for_each(|a3| *a3 ^= 0x80);
                    }
                })
            },
            &["+ 128 instead of", "only in a3"],
        ),
        (
            "last texel lost",
            |_, answer| {
                edited(answer, ViewKind::Raw, |channels, samples| {
                    let last = samples.len() - channels;
                    samples[last..].fill(0);
                })
            },
            &["wrong stored values"],
        ),
        (
            "one more",
            |_, answer| {
                edited(answer, ViewKind::Raw, |_, samples| {
                    for sample in samples {
                        *sample = sample.wrapping_add(1);
                    }
                })
            },
            &["raw + 1 instead of raw"],
        ),
        (
            "a bias of −1 counts as none",
            |request, answer| match (answer, request.view) {
                (Answer::Decoded(frame), view) if frame.view != ViewKind::Raw => {
                    with_samples(frame, |ptm| {
                        let mut ptm = ptm.clone();
                        for bias in &mut ptm.header.scale_bias.bias {
                            *bias = if *bias == -1.0 { 0.0 } else { *bias };
                        }
                        let values = ptm.coefficients();
                        match view {
                            View::Rgb(light) => {
                                Samples::U8(values.evaluate(light.lu, light.lv).to_bytes())
                            }
                            _ => Samples::F32(
                                values.values.iter().map(|&value| value as f32).collect(),
                            ),
                        }
                    })(request.file)
                }
                (other, _) => other,
            },
            &["wrong final values"],
        ),
        (
            "a4 is not scaled, in a decoder of final values",
            |request, answer| match answer {
                Answer::Decoded(frame) if frame.view == ViewKind::Coef => {
                    with_samples(frame, |ptm| {
                        let bias = ptm.header.scale_bias.bias[4];
                        let raw = ptm.planes.texels().flatten();
                        let values = ptm.coefficients().values.into_iter().zip(raw).enumerate();
                        let channels = ptm.planes.shape.channels();
                        let polynomials = ptm.planes.shape.coefficients();
                        let value = |(i, (value, &raw)): (usize, (f64, &u8))| match i % channels {
                            channel if channel < polynomials && channel % 6 == 4 => {
                                (f64::from(raw) - bias) as f32
                            }
                            _ => value as f32,
                        };
                        Samples::F32(values.map(value).collect())
                    })(request.file)
                }
                Answer::Decoded(_) => Answer::Unsupported,
                other => other,
            },
            &["raw - bias[i] instead of", "only in a4"],
        ),
        (
            "a1 is left out, in a decoder of colors",
            |request, answer| match (answer, request.view) {
                (Answer::Decoded(frame), View::Rgb(light)) => with_samples(frame, |ptm| {
                    let mut values = ptm.coefficients();
                    let channels = ptm.planes.shape.channels();
                    for texel in values.values.chunks_exact_mut(channels) {
                        for a1 in (1..ptm.planes.shape.coefficients()).step_by(6) {
                            texel[a1] = 0.0;
                        }
                    }
                    Samples::U8(values.evaluate(light.lu, light.lv).to_bytes())
                })(request.file),
                (Answer::Decoded(_), _) => Answer::Unsupported,
                (other, _) => other,
            },
            &["a0 * u * u + a2 * u * v"],
        ),
    ];
    for (name, wrong, says) in decoders {
        println!("{name}");
        let causes = diagnosed(&suite, wrong);
        let first = causes.first().expect("a cause");
        let is_said = says.iter().all(|words| first.contains(words));
        assert!(is_said, "{name}: {causes:#?}");
    }
}

/// Replaces the samples of a frame by some that are computed from the map in the file.
fn with_samples(
    frame: Frame,
    samples: impl Fn(&ptm_conform::Ptm) -> Samples,
) -> impl Fn(&[u8]) -> Answer {
    move |file| {
        let ptm = ptm_conform::decode(file).expect("the reference showed it");
        Answer::Decoded(Frame {
            samples: samples(&ptm),
            ..frame.clone()
        })
    }
}

/// Changes the samples of a frame of this view; other views are unsupported.
fn edited(answer: Answer, view: ViewKind, edit: fn(usize, &mut [u8])) -> Answer {
    match answer {
        Answer::Decoded(mut frame) if frame.view == view => {
            let channels = frame.channels as usize;
            if let Samples::U8(samples) = &mut frame.samples {
                edit(channels, samples);
            }
            Answer::Decoded(Frame { ..frame })
        }
        Answer::Decoded(_) => Answer::Unsupported,
        other => other,
    }
}

/// Counts the mistakes that are among the first causes.
fn named_of(mistakes: &[&'static Misreading], diagnoses: &[Diagnosis]) -> usize {
    let first = || diagnoses.iter().take(mistakes.len());
    let is_named =
        |mistake: &&&Misreading| first().any(|diagnosis| slugs(diagnosis).contains(&mistake.slug));
    mistakes.iter().filter(is_named).count()
}

/// Returns the causes that are stated as certain, and are not among the mistakes.
fn false_of(mistakes: &[&'static Misreading], diagnoses: &[Diagnosis]) -> Vec<String> {
    let is_false = |diagnosis: &&Diagnosis| {
        let slugs = slugs(diagnosis);
        let is_made = mistakes.iter().any(|mistake| slugs.contains(&mistake.slug));
        diagnosis.certain && !is_made
    };
    diagnoses.iter().filter(is_false).map(words).collect()
}

fn described(mistakes: &[&'static Misreading], failing: usize, diagnoses: &[Diagnosis]) -> String {
    let slugs: Vec<&str> = mistakes.iter().map(|mistake| mistake.slug).collect();
    let causes: Vec<String> = diagnoses
        .iter()
        .map(|diagnosis| format!("    {} {}", diagnosis.explains.len(), words(diagnosis)))
        .collect();
    format!("{slugs:?}, {failing} failures:\n{}", causes.join("\n"))
}

/// Checks every `step`th misreading from `first` on: its decoder fails, and the misreading is the first cause.
fn names_every(suite: &Suite, first: usize, step: usize, run: impl Fn(&'static Misreading) -> Run) {
    let (mut wrong, mut count) = (Vec::new(), 0);
    for mistake in misreadings::all().skip(first).step_by(step) {
        count += 1;
        let run = run(mistake);
        let failing = failures(&run).len();
        let diagnoses = causes(suite, &run);
        if failing == 0 || named_of(&[mistake], &diagnoses) == 0 {
            wrong.push(described(&[mistake], failing, &diagnoses));
            println!("{}", wrong[wrong.len() - 1]);
        }
        if count % 10 == 0 {
            println!("{count} done, {} missed", wrong.len());
        }
    }
    println!("{count} misreadings, {} not named first", wrong.len());
    assert!(wrong.is_empty(), "{wrong:#?}");
}

fn names_in_reference_dialect(first: usize, step: usize) {
    let suite = suite().prepared();
    let (_, right) = ask_all(&suite, &[], &[], jobs(), &HashMap::new());
    let run = |mistake| ask_all(&suite, &[mistake], &[], jobs(), &right).0;
    names_every(&suite, first, step, run);
}

/// Checks misreadings of a decoder that resolves an open question in another way than the reference.
fn names_where_a_line_feed_ends_the_table(first: usize, step: usize) {
    let suite = suite().prepared();
    let reading = Reading::SPEC.with_newline_after_table();
    let run = |mistake| {
        run_all(&suite, |request| {
            misreadings::answer(&[mistake], reading, request.file, request.view)
        })
    };
    names_every(&suite, first, step, run);
}

#[test]
fn one_misreading_in_forty_is_named() {
    names_in_reference_dialect(7, 40);
}

#[test]
#[ignore = "takes minutes"]
fn every_misreading_is_named() {
    names_in_reference_dialect(0, 1);
}

#[test]
fn one_in_forty_is_named_where_a_line_feed_ends_the_table() {
    names_where_a_line_feed_ends_the_table(3, 40);
}

#[test]
#[ignore = "takes minutes"]
fn every_misreading_is_named_where_a_line_feed_ends_the_table() {
    names_where_a_line_feed_ends_the_table(0, 1);
}

/// Draws sets of composable misreadings, the same everywhere.
fn drawn(count: usize, size: usize) -> Vec<Vec<&'static Misreading>> {
    let all: Vec<&'static Misreading> = misreadings::all().collect();
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut draw = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        all[(state % all.len() as u64) as usize]
    };
    let mut sets = Vec::new();
    while sets.len() < count {
        let mut set: Vec<&'static Misreading> = Vec::new();
        while set.len() < size {
            let next = draw();
            if set.iter().all(|other| composable(other, next)) {
                set.push(next);
            }
        }
        sets.push(set);
    }
    sets
}

/// Returns true if each member still changes an answer of a decoder that makes the others.
fn all_show(suite: &Suite, set: &[&'static Misreading]) -> bool {
    let answer = |set: &[&Misreading], file: &[u8], view| {
        misreadings::answer(set, Reading::SPEC, file, view)
    };
    set.iter().all(|member| {
        let others = set.iter().filter(|other| other.slug != member.slug);
        let others: Vec<&Misreading> = others.copied().collect();
        suite.cases.iter().any(|case| {
            let file = &case.build(TableSpelling::default()).file;
            let shows = |view| answer(set, file, view) != answer(&others, file, view);
            applies(member, file) && case.views.first().is_some_and(shows)
        })
    })
}

/// Draws `count` sets of `size` mistakes that all show. Each set must be caught; of a hundred, at least `least` must be
/// named whole among the first causes, and at most `most_false` may have a false cause that is stated as certain.
fn names_sets(count: usize, size: usize, least: usize, most_false: usize) {
    let suite = suite().prepared();
    let (_, right) = ask_all(&suite, &[], &[], jobs(), &HashMap::new());
    let (mut tried, mut whole, mut false_ones) = (0, 0, 0);
    for set in drawn(count * 4, size) {
        if tried == count {
            break;
        }
        if !all_show(&suite, &set) {
            continue;
        }
        tried += 1;
        let (run, _) = ask_all(&suite, &set, &[], jobs(), &right);
        let failing = failures(&run).len();
        assert!(failing > 0, "{set:?} fail no case");
        let diagnoses = causes(&suite, &run);
        let is_whole = named_of(&set, &diagnoses) == size;
        let wrong = false_of(&set, &diagnoses);
        whole += usize::from(is_whole);
        false_ones += usize::from(!wrong.is_empty());
        if !is_whole || !wrong.is_empty() {
            println!("{}", described(&set, failing, &diagnoses));
            println!("  FALSE {wrong:?}");
        }
        println!("{tried} sets of {size}: {whole} named whole, {false_ones} with a false cause");
    }
    assert!(whole * 100 >= tried * least, "{whole} of {tried}");
    assert!(
        false_ones * 100 <= tried * most_false,
        "{false_ones} of {tried}"
    );
}

#[test]
fn ten_pairs_are_named() {
    names_sets(10, 2, 80, 20);
}

#[test]
#[ignore = "takes minutes"]
fn two_hundred_pairs_are_caught_and_nine_in_ten_named() {
    names_sets(200, 2, 90, 5);
}

#[test]
#[ignore = "takes minutes"]
fn sixty_triples_are_caught_and_most_named() {
    names_sets(60, 3, 80, 5);
}

#[test]
#[ignore = "takes minutes"]
fn sixty_quadruples_are_caught_and_most_named() {
    names_sets(60, 4, 60, 10);
}
