//! Decoders that each follow one reading that a careful reader of the specification can defend pass, and near misses fail.

use std::borrow::Cow;

use ptm::Reading;
use ptm::Size;
use ptm::decode::predict::predict_without_offset;
use ptm_harness::report::Report;
use ptm_harness::session::plan::RunPlan;
use ptm_harness::session::run::Run;
use ptm_suite::cases::{Case, Suite, TableSpelling};
use ptm_suite::choices::CHOICES;
use ptm_suite::protocol::frame::{Answer, Samples};
use ptm_suite::protocol::request::Request;
use ptm_suite::test_case::TestCase;
use ptm_suite::verdicts::dialect::Certainty;
use ptm_suite::verdicts::observation::Response;
use ptm_suite::verdicts::outcome::Outcome;

use crate::in_process::{self, jobs, misreading, reference_answer, suite_of_small_files};

/// Runs the cases that test one of these sections, and their twins, against a decoder.
fn run(suite: &Suite, sections: &[&str], decoder: impl Fn(&Request) -> Answer + Sync) -> Run {
    let is_selected = |case: &Case| {
        let mut clauses = case.clauses.iter();
        clauses.any(|clause| sections.iter().any(|section| clause.starts_with(section)))
    };
    let plan = RunPlan {
        selected: suite.cases.iter().map(is_selected).collect(),
        ..RunPlan::new(suite, jobs())
    };
    in_process::run(suite, &plan, decoder)
}

fn failures<'a>(suite: &'a Suite, run: &'a Run) -> Vec<(&'a str, &'a str)> {
    let failed = run.judgment.with_outcome(Outcome::Fail);
    let verdict = |i: usize| run.judgment.cases[i].as_ref().expect("a verdict");
    failed
        .map(|i| (&*suite.cases[i].id, &*verdict(i).message))
        .collect()
}

/// Asserts that a decoder passes.
#[track_caller]
fn assert_passes(
    suite: &Suite,
    sections: &[&str],
    decoder: impl Fn(&Request) -> Answer + Sync,
) -> Run {
    let run = run(suite, sections, decoder);
    assert_eq!(failures(suite, &run), []);
    assert!(run.judgment.with_outcome(Outcome::Pass).count() > 50);
    assert_eq!(run.exit_status(), 0);
    run
}

/// Asserts that a decoder fails at least `count` cases.
#[track_caller]
fn assert_fails(
    suite: &Suite,
    sections: &[&str],
    count: usize,
    decoder: impl Fn(&Request) -> Answer + Sync,
) {
    let run = run(suite, sections, decoder);
    let failures = failures(suite, &run);
    assert!(failures.len() >= count, "{failures:#?}");
    assert_eq!(run.exit_status(), 1);
}

/// Returns a decoder that follows `reading`.
fn with_reading(reading: Reading) -> impl Fn(&Request) -> Answer + Sync {
    move |request| ptm_mistakes::answer(&[], reading, request.file, request.view)
}

/// Returns a decoder that reads the file that `rewrite` returns, or refuses the file.
fn with_file<'a>(
    rewrite: impl Fn(&[u8]) -> Option<Vec<u8>> + Sync + 'a,
) -> impl Fn(&Request) -> Answer + Sync + 'a {
    move |request| match rewrite(request.file) {
        Some(file) => ptm_mistakes::answer(&[], Reading::SPEC, &file, request.view),
        None => Answer::Rejected,
    }
}

#[test]
fn decoders_pass_under_each_listed_reading_and_the_reading_is_reported() {
    let suite = suite_of_small_files();
    let motion = ["2.9.2", "2.9.3"];
    let colors = ["1.0", "2"];
    for (ruling, sections) in [
        ("motion-half", motion),
        ("motion-border", motion),
        ("luminance-clamp", colors),
        ("lum-clamp", colors),
        ("lum-chroma", colors),
    ] {
        let axis = CHOICES.axes(&[ruling])[0];
        for (i, (words, change)) in CHOICES[axis].readings.iter().enumerate().skip(1) {
            let mut reading = Reading::SPEC;
            change(&mut reading);
            let run = assert_passes(&suite, &sections, with_reading(reading));
            let judgment = &run.judgment;
            let mut expected = CHOICES.reference();
            expected.0[axis] = i;
            assert_eq!(judgment.dialect, expected, "{words}");
            assert_eq!(judgment.certainties[axis], Certainty::Settled, "{words}");
        }
    }
}

/// An image shows a reading only if another reading of the question gives another image. A refusal shows no spelling of a table.
#[test]
fn images_that_show_a_reading_depend_on_it() {
    let suite = suite_of_small_files();
    let run = run(&suite, &["2.5", "2.6", "2.9.2", "2.9.3"], reference_answer);
    let report = Report::new(&suite, &run, &[], Vec::new());
    let mut shown = 0;
    for followed in &report.dialect {
        let axis = CHOICES.iter().position(|one| one.ruling == followed.ruling);
        for id in &followed.shown_by {
            let case = suite.cases.iter().position(|case| case.id == *id);
            let case = case.expect("a case");
            let observation = run.observations[case].as_ref().expect("a response");
            let is_image = matches!(observation.response, Response::Image { .. });
            assert!(is_image, "{id} was not decoded");
            let Some(axis) = axis else {
                assert_eq!(suite.cases[case].spelling(), Some(run.table), "{id}");
                continue;
            };
            let file = suite.cases[case].make(TableSpelling::default());
            let view = &observation.view;
            let answers = CHOICES[axis].readings.iter().map(|(_, change)| {
                let mut reading = Reading::SPEC;
                change(&mut reading);
                ptm_mistakes::answer(&[], reading, &file.file, view)
            });
            let answers: Vec<Answer> = answers.collect();
            let is_shown = answers.iter().any(|answer| *answer != answers[0]);
            assert!(is_shown, "{id} does not depend on {}", followed.ruling);
            shown += 1;
        }
    }
    assert!(shown > 10, "{shown}");
}

#[test]
fn other_means_of_half_texels_fail() {
    let suite = suite_of_small_files();
    let off_by_two: fn([u8; 4]) -> u8 = |samples| {
        let sum: u16 = samples.into_iter().map(u16::from).sum();
        // A whole position has four equal samples.
        let is_whole = samples.iter().all(|&sample| sample == samples[0]);
        if is_whole {
            samples[0]
        } else {
            ((sum + 2) / 4 + 2).min(255) as u8
        }
    };
    // The pairs (a, b) and (c, d) are rows: their means are rounded up, and the mean of the means is rounded down.
    let down_along_y: fn([u8; 4]) -> u8 = |[a, b, c, d]| {
        let [first, second] =
            [[a, b], [c, d]].map(|[a, b]| (u16::from(a) + u16::from(b)).div_ceil(2));
        first.midpoint(second) as u8
    };
    for half in [off_by_two, down_along_y] {
        let reading = Reading {
            motion_half: half,
            ..Reading::SPEC
        };
        assert_fails(&suite, &["2.9.2", "2.9.3"], 2, with_reading(reading));
    }
}

/// Displaces a plane as the reference does, except that `outside` returns the samples outside the plane.
fn displace(
    plane: &[u8],
    size: Size,
    (mx, my): (i64, i64),
    outside: fn(&[u8], [i64; 2], [i64; 2]) -> u8,
) -> Vec<u8> {
    let [width, height] = [size.width, size.height].map(i64::from);
    let sample = |x: i64, y: i64| {
        if (0..width).contains(&x) && (0..height).contains(&y) {
            plane[(y * width + x) as usize]
        } else {
            outside(plane, [x, y], [width, height])
        }
    };
    let texel = |i: i64| {
        let (x2, y2) = (
            mx.saturating_add(2 * (i % width)),
            my.saturating_add(2 * (i / width)),
        );
        let (x, y) = (x2.div_euclid(2), y2.div_euclid(2));
        let (right, next) = (x + x2.rem_euclid(2), y + y2.rem_euclid(2));
        let samples = [(x, y), (right, y), (x, next), (right, next)];
        let sum: u16 = samples.map(|(x, y)| u16::from(sample(x, y))).iter().sum();
        ((sum + 2) / 4) as u8
    };
    (0..width * height).map(texel).collect()
}

/// Returns the sample that follows the edge in memory: the next column of the last one is the first of the next row.
fn next_in_memory(plane: &[u8], [x, y]: [i64; 2], [width, _]: [i64; 2]) -> u8 {
    let at = y
        .saturating_mul(width)
        .saturating_add(x)
        .rem_euclid(plane.len() as i64);
    plane[at as usize]
}

/// Returns the mirrored sample, without repeating the edge: c b | a b c.
fn mirrored_without_the_edge(plane: &[u8], position: [i64; 2], size: [i64; 2]) -> u8 {
    let [x, y] = [0, 1].map(|axis| {
        let period = (2 * size[axis] - 2).max(1);
        let at = position[axis].rem_euclid(period);
        at.min(period - at).clamp(0, size[axis] - 1)
    });
    plane[(y * size[0] + x) as usize]
}

#[test]
fn other_borders_fail() {
    macro_rules! border {
        ($outside:expr) => {
            Reading {
                predictor: |reference, step, size, _| {
                    let mut plane = reference.to_vec();
                    if step.inverted {
                        for value in &mut plane {
                            *value = 255 - *value;
                        }
                    }
                    if step.displaced {
                        plane = displace(&plane, size, step.motion, $outside);
                    }
                    Cow::Owned(plane)
                },
                ..Reading::SPEC
            }
        };
    }
    let suite = suite_of_small_files();
    let sections = ["2.9.2", "2.9.3"];
    // The same function with the border of the reference passes.
    let edge = border!(|plane, [x, y], [width, height]| {
        plane[(y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize]
    });
    assert_passes(&suite, &sections, with_reading(edge));
    for border in [
        border!(|_, _, _| 64),
        border!(next_in_memory),
        border!(mirrored_without_the_edge),
    ] {
        assert_fails(&suite, &sections, 2, with_reading(border));
    }
}

#[test]
fn other_colors_fail() {
    let suite = suite_of_small_files();
    // A limit of 254 is within one level of 255, which any rounding may cause.
    let clamped_at_250 = Reading {
        luminance: |value| value.min(250.0),
        ..Reading::SPEC
    };
    assert_fails(
        &suite,
        &["1.0", "2.7", "2.8"],
        2,
        with_reading(clamped_at_250),
    );
    let centered_at_127 = Reading {
        lum_chroma: |stored| stored - 127.0,
        ..Reading::SPEC
    };
    assert_fails(&suite, &["2.6", "2.7"], 2, with_reading(centered_at_127));
}

/// The words of a header and the bytes after its last line feed.
struct Header<'a> {
    format: &'a str,
    text: &'a str,
    payload: &'a [u8],
}

/// Splits a file after the last number of its header. Returns `None` if the header is incomplete or is not text.
fn split(file: &[u8]) -> Option<Header<'_>> {
    let end_of_line =
        |from: usize| Some(from + file.get(from..)?.iter().position(|&byte| byte == b'\n')? + 1);
    let names = end_of_line(end_of_line(0)?)?;
    let format = std::str::from_utf8(&file[end_of_line(0)?..names])
        .ok()?
        .trim();
    let planes = if format.ends_with("JPEG_RGB") || format.ends_with("JPEGLS_RGB") {
        18
    } else {
        9
    };
    let mut numbers = match format {
        "PTM_FORMAT_LUM" => 14 + 16,
        _ if format.contains("JPEG") => 14 + 1 + 7 * planes,
        _ => 14,
    };
    let mut at = names;
    while numbers > 0 {
        let start = at
            + file
                .get(at..)?
                .iter()
                .position(|byte| !byte.is_ascii_whitespace())?;
        at = start + file[start..].iter().position(u8::is_ascii_whitespace)?;
        numbers -= 1;
    }
    if format.contains("LUT") {
        at = end_of_line(end_of_line(at)? - 1)?;
        at = end_of_line(at)? - 1;
    }
    let end = end_of_line(at)?;
    Some(Header {
        format,
        text: std::str::from_utf8(&file[..end]).ok()?,
        payload: &file[end..],
    })
}

/// Returns a file with other header text.
fn join(text: &str, payload: &[u8]) -> Vec<u8> {
    [text.as_bytes(), payload].concat()
}

/// Replaces each number of the header after the format that `replace` changes. Returns `None` if it returns `None`.
fn with_numbers(file: &[u8], replace: impl Fn(&str) -> Option<String>) -> Option<Vec<u8>> {
    let Some(header) = split(file) else {
        return Some(file.to_vec());
    };
    let names = header.text.match_indices('\n').nth(1)?.0 + 1;
    let mut text = header.text[..names].to_owned();
    for word in header.text[names..].split_inclusive([' ', '\n']) {
        let number = word.trim_end_matches([' ', '\n']);
        text += &replace(number)?;
        text += &word[number.len()..];
    }
    Some(join(&text, header.payload))
}

/// Reads a number as C's strtod does, or returns `None` if that does not read the whole word.
fn strtod(word: &str) -> Option<f64> {
    let (sign, digits) = match word.strip_prefix('-') {
        Some(digits) => (-1.0, digits),
        None => (1.0, word.strip_prefix('+').unwrap_or(word)),
    };
    let Some(hex) = digits.strip_prefix("0x") else {
        let value: f64 = digits.parse().ok()?;
        return Some(sign * value);
    };
    let (mantissa, exponent) = hex.split_once('p').unwrap_or((hex, "0"));
    let mantissa = i64::from_str_radix(mantissa, 16).ok()?;
    let exponent: i32 = exponent.parse().ok()?;
    Some(sign * mantissa as f64 * 2f64.powi(exponent))
}

#[test]
fn parsers_of_numbers_like_those_of_c_pass() {
    let suite = suite_of_small_files();
    let sections = ["2.3", "2.4", "2.5", "2.6"];
    // inf, nan and numbers that overflow give some image.
    assert_passes(
        &suite,
        &sections,
        with_file(|file| {
            with_numbers(file, |word| {
                Some(match strtod(word) {
                    Some(value) if !value.is_finite() => "1".to_owned(),
                    Some(value) if word.contains("0x") => value.to_string(),
                    _ => word.to_owned(),
                })
            })
        }),
    );
    // ERANGE is an error: a result that is subnormal, or 0 although a digit is not.
    assert_passes(
        &suite,
        &sections,
        with_file(|file| {
            with_numbers(file, |word| {
                let mantissa = word.split(['e', 'E']).next().unwrap_or_default();
                let is_zero = !mantissa.contains(|c| ('1'..='9').contains(&c));
                let is_normal = strtod(word).is_none_or(|value| value.is_normal() || is_zero);
                is_normal.then(|| word.to_owned())
            })
        }),
    );
    // A decimal comma, and the digits before the first letter.
    let with_comma = with_file(|file| with_numbers(file, |word| Some(word.replace(',', "."))));
    assert_fails(&suite, &sections, 2, with_comma);
    let prefix = with_file(|file| {
        with_numbers(file, |word| {
            let is_integer_with_exponent = !word.contains('.')
                && word.contains('e')
                && word.starts_with(|c: char| c.is_ascii_digit());
            let digits = word.split('e').next().unwrap_or_default();
            Some(
                if is_integer_with_exponent {
                    digits
                } else {
                    word
                }
                .to_owned(),
            )
        })
    });
    assert_fails(&suite, &["2.4/4"], 2, prefix);
}

#[test]
fn literal_readers_of_spaces_pass() {
    let suite = suite_of_small_files();
    let is_compressed = |header: &Header| header.format.contains("JPEG");
    assert_passes(
        &suite,
        &["2.0", "2.9"],
        with_file(|file| {
            let spaced = split(file).filter(is_compressed);
            let ends_in_space = spaced.is_some_and(|header| {
                let lists = header.text.lines().rev().take(8);
                lists.into_iter().any(|line| line.ends_with(' '))
            });
            (!ends_in_space).then(|| file.to_vec())
        }),
    );
    assert_passes(
        &suite,
        &["2.0", "2.3", "2.4", "2.9"],
        with_file(|file| {
            let has_gap = split(file).is_some_and(|header| header.text.contains("  "));
            (!has_gap).then(|| file.to_vec())
        }),
    );
    assert_passes(
        &suite,
        &["2.0", "2.3", "2.4"],
        with_file(|file| {
            // The first line of a size on two lines ends in a space.
            let spaced = split(file).is_some_and(|header| {
                let line = header.text.lines().nth(2).unwrap_or_default();
                line.ends_with(' ') && !line.trim_end().contains(' ')
            });
            (!spaced).then(|| file.to_vec())
        }),
    );
}

#[test]
fn other_versions_pass_or_fail_by_format() {
    let suite = suite_of_small_files();
    let as_1_2 = |file: &[u8], formats: fn(&str) -> bool| {
        let old = file.strip_prefix(b"PTM_1.1\n").filter(|rest| {
            let format = rest.split(|&byte| byte == b'\n').next().unwrap_or_default();
            formats(std::str::from_utf8(format).unwrap_or_default())
        });
        Some(old.map_or_else(|| file.to_vec(), |rest| [b"PTM_1.2\n", rest].concat()))
    };
    let not_lrgb = with_file(|file| as_1_2(file, |format| format != "PTM_FORMAT_LRGB"));
    assert_passes(&suite, &["2.1", "2.9"], not_lrgb);
    let all = run(
        &suite,
        &["2.1", "2.2"],
        with_file(|file| as_1_2(file, |_| true)),
    );
    let ids: Vec<&str> = failures(&suite, &all).iter().map(|(id, _)| *id).collect();
    assert_eq!(ids, ["version-1-1-interleaves"]);
}

/// Returns true if a JPEG stream of the file defines a 16-bit quantization table (DQT with Pq = 1, T.81 B.2.4.1).
fn has_16_bit_tables(file: &[u8]) -> bool {
    file.windows(5)
        .any(|bytes| bytes[..2] == [0xff, 0xdb] && bytes[4] >> 4 == 1)
}

#[test]
fn refusal_of_16_bit_quantization_tables_passes() {
    let suite = suite_of_small_files();
    let run = assert_passes(&suite, &["2.9.8"], |request| {
        if has_16_bit_tables(request.file) {
            return Answer::Rejected;
        }
        reference_answer(request)
    });
    let refused = suite.cases.iter().zip(&run.observations);
    let refused = refused.filter(|(case, seen)| {
        case.ruling.as_deref() == Some("plane-tables")
            && seen
                .as_ref()
                .is_some_and(|seen| seen.response.name() == "rejected")
    });
    assert!(refused.count() >= 6);
}

/// Replaces one list of a compressed file. `replace` gets the references and the list.
fn with_list(
    file: &[u8],
    line_from_end: usize,
    replace: impl Fn(&[i64], &[i64]) -> Vec<i64>,
) -> Vec<u8> {
    let Some(header) = split(file).filter(|header| header.format.contains("JPEG")) else {
        return file.to_vec();
    };
    let mut lines: Vec<String> = header.text.lines().map(str::to_owned).collect();
    let numbers = |line: &String| -> Option<Vec<i64>> {
        line.split_whitespace()
            .map(|word| word.parse().ok())
            .collect()
    };
    // The last three lines are the references, the sizes of streams and those of side information.
    let parsed = lines
        .len()
        .checked_sub(3)
        .zip(lines.len().checked_sub(line_from_end));
    let lists = parsed.and_then(|(references, at)| {
        Some((numbers(&lines[references])?, numbers(&lines[at])?, at))
    });
    let Some((references, list, at)) =
        lists.filter(|(references, list, _)| references.len() == list.len())
    else {
        return file.to_vec();
    };
    let edited = replace(&references, &list)
        .iter()
        .map(i64::to_string)
        .collect::<Vec<_>>();
    lines[at] = edited.join(" ");
    join(&(lines.join("\n") + "\n"), header.payload)
}

#[test]
fn references_are_followed_with_or_without_ranks() {
    let suite = suite_of_small_files();
    // A decoder that follows the references finds the same order as one whose ranks are the lengths of the chains.
    let follows = |file: &[u8]| {
        Some(with_list(file, 4, |references, ranks| {
            let parent = |plane: i64| {
                usize::try_from(plane)
                    .ok()
                    .and_then(|plane| references.get(plane))
                    .copied()
            };
            let length = |plane: usize| {
                let chain = std::iter::successors(Some(plane as i64), |&plane| parent(plane));
                chain
                    .take_while(|&plane| plane >= 0)
                    .take(ranks.len() + 1)
                    .count() as i64
            };
            (0..ranks.len()).map(length).collect()
        }))
    };
    assert_passes(&suite, &["2.9.4", "2.9.5"], with_file(follows));
    // The image of a lenient file follows the readings of the decoder, too.
    let without_offset = Reading {
        predict_jpeg_ls: predict_without_offset,
        ..Reading::SPEC
    };
    assert_passes(&suite, &["2.9.4", "2.9.5"], |request| {
        let file = follows(request.file).expect("a file");
        ptm_mistakes::answer(&[], without_offset, &file, request.view)
    });
    let missing_is_0 = |file: &[u8]| {
        Some(with_list(file, 3, |references, _| {
            let planes = references.len() as i64;
            references
                .iter()
                .map(|&plane| if plane >= planes { 0 } else { plane })
                .collect()
        }))
    };
    assert_fails(&suite, &["2.9.4", "2.9.5"], 2, with_file(missing_is_0));
    let sequence = misreading("order-as-sequence");
    assert_fails(&suite, &["2.9.4", "2.9.5"], 2, |request| {
        in_process::answer_with(&[sequence], request)
    });
}

/// A shorter path for blocks without AC coefficients that truncates is half a level too dark: one level in half of the samples.
#[test]
fn systematic_error_in_flat_blocks_is_reported_without_a_verdict() {
    let suite = suite_of_small_files();
    let darken = |request: &Request| {
        let mut answer = reference_answer(request);
        if let Answer::Decoded(frame) = &mut answer
            && request.name.starts_with("flat-blocks-")
            && let Samples::U8(samples) = &mut frame.samples
        {
            samples
                .iter_mut()
                .step_by(2)
                .for_each(|sample| *sample = sample.saturating_sub(1));
        }
        answer
    };
    let notes = |decoder: &(dyn Fn(&Request) -> Answer + Sync)| {
        let run = run(&suite, &["2.9.8/11"], decoder);
        assert_eq!(failures(&suite, &run), []);
        let report = Report::new(&suite, &run, &["none".to_owned()], Vec::new());
        let notes = report.remarks.into_iter().map(|remark| remark.message);
        notes
            .filter(|note| note.contains("flat blocks"))
            .collect::<Vec<String>>()
    };
    assert_eq!(notes(&reference_answer), Vec::<String>::new());
    let found = notes(&darken);
    assert_eq!(found.len(), 1);
    // A few samples are 0 already.
    assert!(
        found[0].contains("0.49 below") || found[0].contains("0.50 below"),
        "{found:?}"
    );
}
