//! A failing decoder is told what to fix.

use std::collections::HashMap;

use ptm_conform::Reading;
use ptm_conform::diagnose::{Cause, Diagnosis, composable, diagnose};
use ptm_conform::misreadings::{self, Misreading};
use ptm_conform::protocol::frame::{Answer, Frame, Samples, View, ViewKind};
use ptm_conform::ptm::Format;
use ptm_conform::runner::run::{Reply, Request};
use ptm_conform::session::outcome::Outcome;
use ptm_conform::session::plan::RunPlan;
use ptm_conform::session::run::{Run, check};
use ptm_conform::strength::matrix::ask_all;
use ptm_conform::suite::cases::{Case, Expect, Suite, TableSpelling};

fn suite() -> Suite {
    Suite::load().expect("the suite loads").prepared()
}

fn jobs() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The causes that are found, without a fault of the search.
fn causes(suite: &Suite, run: &Run) -> Vec<Diagnosis> {
    let causes = diagnose(suite, run, &[], jobs());
    assert!(causes.faults.is_empty(), "{:?}", causes.faults);
    causes.diagnoses
}

fn failures(run: &Run) -> Vec<usize> {
    let judged = run.judgement.cases.iter().enumerate();
    judged
        .filter(|(_, judged)| {
            judged
                .as_ref()
                .is_some_and(|judged| judged.outcome == Outcome::Fail)
        })
        .map(|(i, _)| i)
        .collect()
}

/// The misreadings that are named, or said to look the same.
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

/// What a wrong decoder makes of the right answer.
type Wrong = fn(&Request, Answer) -> Answer;

/// A run of a decoder that answers as `wrong` makes of the reference's answer.
fn run_of(suite: &Suite, wrong: impl Fn(&Request, Answer) -> Answer + Sync) -> Run {
    let ask = |request: &Request<'_>, _: usize| {
        let right = misreadings::answer(&[], Reading::SPEC, request.file, request.view);
        Reply::from(wrong(request, right))
    };
    let plan = RunPlan::of(suite, jobs());
    check(suite, &plan, &ask, &|_, _, _, _| ())
}

/// The diagnosis of such a decoder, in words.
fn told(suite: &Suite, wrong: impl Fn(&Request, Answer) -> Answer + Sync) -> Vec<String> {
    let run = run_of(suite, wrong);
    let diagnoses = causes(suite, &run);
    let mut stand: Vec<usize> = diagnoses
        .iter()
        .flat_map(|diagnosis| diagnosis.explains.iter().chain(&diagnosis.partly))
        .copied()
        .collect();
    stand.sort_unstable();
    assert_eq!(
        stand,
        failures(&run),
        "every failure stands under one diagnosis"
    );
    let told: Vec<String> = diagnoses
        .iter()
        .map(|diagnosis| {
            format!(
                "{}+{}-{}: {}",
                diagnosis.explains.len(),
                diagnosis.partly.len(),
                diagnosis.except.len(),
                words(diagnosis)
            )
        })
        .collect();
    for line in &told {
        println!("  {line}");
    }
    told
}

/// Answers that a search may make for each case, however much fails.
const WORK: usize = 200;

#[test]
fn a_search_among_failures_that_share_nothing_ends() {
    let mut suite = suite();
    let is_quick = |case: &Case| !case.format().is_compressed();
    suite.cases.retain(is_quick);
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
    assert!(
        causes.answered < WORK * suite.cases.len(),
        "{}",
        causes.answered
    );
}

#[test]
fn a_mistake_in_one_color_is_named_with_it() {
    let wraps = misreadings::named("color-wraps").expect("the catalog has it");
    let told = told(&suite(), |request, answer| {
        let wrong = misreadings::answer(&[wraps], Reading::SPEC, request.file, request.view);
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
    let is_named = |words: &&str| told[0].contains(words);
    assert!(
        ["computes a color", "mod(", "only in blue"]
            .iter()
            .all(is_named),
        "{told:#?}"
    );
}

/// Every second stored row from right to left.
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
    let mut suite = suite();
    suite.cases.retain(|case| case.format() == Format::Lrgb);
    let told = told(&suite, |_, answer| match answer {
        Answer::Decoded(frame) if frame.view == ViewKind::Raw => Answer::Decoded(snaking(&frame)),
        Answer::Decoded(_) => Answer::Unsupported,
        other => other,
    });
    let says = "the correct values in the wrong places";
    assert!(told[0].contains(says), "{told:#?}");
}

/// A decoder without a format refuses some of its files before it sees their format, as any other.
#[test]
fn a_format_of_which_no_file_is_decoded_is_unsupported_though_some_are_refused() {
    let mut suite = suite();
    let is_legal = |case: &Case| case.expect == Expect::Decode;
    suite
        .cases
        .retain(|case| is_legal(case) && case.format() == Format::Lum);
    suite.cases.extend(
        self::suite()
            .cases
            .into_iter()
            .filter(|case| case.first && case.format() == Format::Rgb),
    );
    let is_refused = |file: &[u8]| file.len().is_multiple_of(7);
    let is_lum = |file: &[u8]| file.windows(14).any(|word| word == b"PTM_FORMAT_LUM");
    let run = run_of(&suite, |request, answer| match answer {
        Answer::Decoded(_) if is_lum(request.file) => match is_refused(request.file) {
            true => Answer::Rejected,
            false => Answer::Unsupported,
        },
        other => other,
    });
    let outcomes = run.judgement.cases.iter().flatten();
    let (mut refused, mut unsupported) = (0, 0);
    for judged in outcomes {
        match judged.outcome {
            Outcome::Fail => refused += 1,
            Outcome::Unsupported => unsupported += 1,
            _ => {}
        }
    }
    assert!(unsupported > 3 * refused, "{refused} {unsupported}");
    let lum = (suite.cases.iter()).filter(|case| case.format() == Format::Lum);
    let of_length = lum.filter(|case| is_refused(&case.build(TableSpelling::default()).file));
    assert!((1..=of_length.count()).contains(&refused), "{refused}");
}

#[test]
fn what_the_catalogue_does_not_know_is_put_into_words() {
    let suite = suite();
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
                let words = String::from_utf8_lossy(&request.file[..request.file.len().min(200)])
                    .into_owned();
                let large = words
                    .split_once(" N_LUT_ENTRIES")
                    .and_then(|(before, _)| before.rsplit('\n').next()?.parse::<u32>().ok())
                    .is_some_and(|count| count > 256);
                match answer {
                    Answer::Decoded(_) if large => {
                        Answer::Crashed("killed by signal 11".to_owned())
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
                        texel
                            .iter_mut()
                            .skip(3)
                            .step_by(6)
                            .for_each(|a3| *a3 ^= 0x80);
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
        let told = told(&suite, wrong);
        assert!(
            told.first()
                .is_some_and(|first| says.iter().all(|words| first.contains(words))),
            "{name}: {told:#?}"
        );
    }
}

/// The frame with other samples, made of the map that the file holds.
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

/// The samples of a raw frame changed; other answers as they are.
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

/// What keeps the diagnosis of a decoder with these mistakes from naming them all.
fn missed(
    suite: &Suite,
    mistakes: &[&'static Misreading],
    run: &Run,
) -> Result<Option<String>, &'static str> {
    let failing = failures(run);
    if failing.is_empty() {
        return Err("fails no case");
    }
    let diagnoses = causes(suite, run);
    let named = named_of(mistakes, &diagnoses) == mistakes.len();
    Ok((!named).then(|| described(mistakes, failing.len(), &diagnoses)))
}

/// How many of the mistakes stand among the first causes.
fn named_of(mistakes: &[&'static Misreading], diagnoses: &[Diagnosis]) -> usize {
    let first = || diagnoses.iter().take(mistakes.len());
    let is_named =
        |mistake: &&&Misreading| first().any(|diagnosis| slugs(diagnosis).contains(&mistake.slug));
    mistakes.iter().filter(is_named).count()
}

/// Causes that are said for certain, and are none of the mistakes.
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

/// Every `step`th misreading, from the `first` on: fails, and is named first.
fn names_every(first: usize, step: usize) {
    let suite = suite();
    let (_, right) = ask_all(&suite, &[], &[], jobs(), &HashMap::new());
    let mut wrong = Vec::new();
    let mut count = 0;
    for misreading in misreadings::all().skip(first).step_by(step) {
        count += 1;
        let (run, _) = ask_all(&suite, &[misreading], &[], jobs(), &right);
        match missed(&suite, &[misreading], &run) {
            Ok(None) => {}
            Ok(Some(why)) => {
                println!("{why}");
                wrong.push(why);
            }
            Err(why) => wrong.push(format!("{} {why}", misreading.slug)),
        }
        if count % 10 == 0 {
            println!("{count} done, {} missed", wrong.len());
        }
    }
    println!("{count} misreadings, {} not named first", wrong.len());
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn one_misreading_in_forty_is_named() {
    names_every(7, 40);
}

/// Misreadings of all sections, made by a decoder that reads the open questions otherwise than the reference.
fn names_in_dialect(reading: Reading, first: usize, step: usize) {
    let suite = suite();
    let mut wrong = Vec::new();
    for misreading in misreadings::all().skip(first).step_by(step) {
        let ask = |request: &Request<'_>, _: usize| {
            Reply::from(misreadings::answer(
                &[misreading],
                reading,
                request.file,
                request.view,
            ))
        };
        let run = check(&suite, &RunPlan::of(&suite, jobs()), &ask, &|_, _, _, _| ());
        match missed(&suite, &[misreading], &run) {
            Ok(None) => {}
            Ok(Some(why)) => wrong.push(why),
            Err(why) => wrong.push(format!("{} {why}", misreading.slug)),
        }
    }
    println!("{} not named first", wrong.len());
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn one_in_forty_is_named_where_a_line_feed_ends_the_table() {
    names_in_dialect(Reading::SPEC.with_newline_after_table(), 3, 40);
}

#[test]
#[ignore = "takes minutes"]
fn every_misreading_is_named_where_a_line_feed_ends_the_table() {
    names_in_dialect(Reading::SPEC.with_newline_after_table(), 0, 1);
}

#[test]
#[ignore = "takes minutes"]
fn every_misreading_is_named() {
    names_every(0, 1);
}

/// Sets of composable misreadings, without a pattern and the same everywhere.
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

/// Whether each member still changes an answer where the others are made.
fn all_show(suite: &Suite, set: &[&'static Misreading]) -> bool {
    set.iter().all(|member| {
        let others: Vec<&Misreading> = set
            .iter()
            .copied()
            .filter(|other| other.slug != member.slug)
            .collect();
        suite.cases.iter().any(|case| {
            let built = case.build(ptm_conform::suite::cases::TableSpelling::default());
            ptm_conform::diagnose::applies(member, &built.file)
                && case.views.first().is_some_and(|view| {
                    misreadings::answer(set, Reading::SPEC, &built.file, view)
                        != misreadings::answer(&others, Reading::SPEC, &built.file, view)
                })
        })
    })
}

/// Draws `count` sets of `size` mistakes that all show: each must be caught, `least` in a hundred named whole among the
/// first causes, and nothing else said for certain of more than `most_false` in a hundred.
fn names_sets(count: usize, size: usize, least: usize, most_false: usize) {
    let suite = suite();
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
