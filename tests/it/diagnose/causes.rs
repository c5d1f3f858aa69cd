//! Tests that the diagnosis names the mistakes of a failing decoder.

use std::collections::HashMap;

use ptm::Format;
use ptm::Reading;
use ptm::decode::lookup_table::read_newline_separator;
use ptm_harness::diagnose::{Cause, Diagnosis, assume, can_affect_file, can_combine, diagnose};
use ptm_harness::session::run::Run;
use ptm_harness::strength::matrix::run_with_mistakes;
use ptm_mistakes::Misreading;
use ptm_mistakes::formula::{Edit, Outside};
use ptm_suite::cases::{Case, Expect, Suite, TableSpelling};
use ptm_suite::protocol::frame::{Answer, Frame, Samples, ViewKind};
use ptm_suite::protocol::request::Request;
use ptm_suite::verdicts::observation::Nondeterminism;
use ptm_suite::verdicts::outcome::Outcome;

use crate::in_process::{
    answer_with, formula_misreading, jobs, misreading, reference_answer, run_all,
    suite_of_small_files,
};
use crate::table::rows;

/// Returns the causes that the diagnosis finds.
fn causes(suite: &Suite, run: &Run) -> Vec<Diagnosis> {
    diagnose(suite, run, &[], jobs()).diagnoses
}

fn failures(run: &Run) -> Vec<usize> {
    run.judgment.with_outcome(Outcome::Fail).collect()
}

/// Returns the slugs of the misreadings that a diagnosis names or lists as equivalent.
fn slugs(diagnosis: &Diagnosis) -> Vec<&'static str> {
    let (first, equivalents) = match &diagnosis.cause {
        Cause::Misreading {
            misreading,
            equivalents,
            ..
        } => (Some(*misreading), equivalents),
        Cause::Described { equivalents, .. } => (None, equivalents),
    };
    let all = first.into_iter().chain(equivalents.iter().copied());
    all.map(|misreading| misreading.slug).collect()
}

fn cause_text(diagnosis: &Diagnosis) -> String {
    match &diagnosis.cause {
        Cause::Misreading { misreading, .. } => misreading.slug.to_owned(),
        Cause::Described {
            effect, example, ..
        } => format!("{effect} [{example}]"),
    }
}

/// Function that changes the correct answer as a faulty decoder would.
type ChangeAnswer = fn(&Request, Answer) -> Answer;

/// Runs the suite against a decoder that changes the correct answers.
fn run_faulty_decoder(suite: &Suite, change: impl Fn(&Request, Answer) -> Answer + Sync) -> Run {
    run_all(suite, |request| change(request, reference_answer(request)))
}

/// Returns the diagnosis of a decoder that changes the correct answers, one line per cause.
fn diagnose_faulty_decoder(
    suite: &Suite,
    change: impl Fn(&Request, Answer) -> Answer + Sync,
) -> Vec<String> {
    let run = run_faulty_decoder(suite, change);
    let diagnoses = causes(suite, &run);
    let explained = diagnoses.iter().flat_map(|one| &one.explains);
    let mut explained: Vec<usize> = explained.copied().collect();
    explained.sort_unstable();
    assert_eq!(explained, failures(&run), "one diagnosis per failure");
    let lines = diagnoses
        .iter()
        .map(|one| format!("{}: {}", one.explains.len(), cause_text(one)));
    let lines: Vec<String> = lines.collect();
    println!("  {}", lines.join("\n  "));
    lines
}

/// Maximum number of answers per case that a search may compute, regardless of the number of failures.
const MAX_ANSWERS_PER_CASE: usize = 200;

#[test]
fn search_ends_for_unrelated_failures() {
    let mut suite = suite_of_small_files();
    suite.cases.retain(|case| case.format().coding().is_none());
    let run = run_faulty_decoder(&suite, |_, _| {
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
    println!("{failing} failures, {} answers", causes.answer_count);
    assert!(failing > 500);
    let limit = MAX_ANSWERS_PER_CASE * suite.cases.len();
    assert!(causes.answer_count < limit, "{}", causes.answer_count);
}

#[test]
fn mistake_in_one_channel_names_the_channel() {
    let wraps = misreading("color-wraps");
    let causes = diagnose_faulty_decoder(&suite_of_small_files(), |request, answer| {
        let wrong = answer_with(&[wraps], request);
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

/// Each text must occur in some cause.
fn assert_said(causes: &[String], texts: [&str; 2]) {
    for text in texts {
        let is_said = causes.iter().any(|cause| cause.contains(text));
        assert!(is_said, "{text}: {causes:#?}");
    }
}

/// The polynomial of blue begins one channel early, and side information corrects residuals.
#[test]
fn mistake_in_one_channel_of_some_formats_is_named_beside_another() {
    let corrects_residuals = misreading("side-information-before-prediction");
    let edit = Edit::parse("channel of a coefficient", "c * 6 + i - 1").expect("an edit");
    let early = formula_misreading(vec![edit]);
    let causes = diagnose_faulty_decoder(&suite_of_small_files(), |request, _| {
        let mut answer = answer_with(&[corrects_residuals], request);
        let early = answer_with(&[corrects_residuals, &early], request);
        if let (Answer::Decoded(frame), Answer::Decoded(early)) = (&mut answer, early)
            && frame.view == ViewKind::Rgb
            && request.file.windows(4).any(|word| word == b"_RGB")
            && let (Samples::U8(colors), Samples::U8(early)) = (&mut frame.samples, early.samples)
        {
            let blue = colors.iter_mut().zip(early).skip(2).step_by(3);
            blue.for_each(|(color, early)| *color = early);
        }
        answer
    });
    assert_said(
        &causes,
        ["c * 6 + i - 1", "side-information-before-prediction"],
    );
}

/// The colors of LRGB are read as planes. Final values and colors are wrong in a way that has no name.
#[test]
fn mistake_in_stored_values_is_named_although_later_values_are_wrong() {
    let planes = misreading("lrgb-colors-in-planes");
    let causes = diagnose_faulty_decoder(&suite_of_small_files(), |request, _| {
        let mut answer = answer_with(&[planes], request);
        if let Answer::Decoded(frame) = &mut answer {
            match (&mut frame.samples, frame.view) {
                (Samples::F32(values), _) => {
                    let shifts = (0..5_u8).map(|i| f32::from(i) * 3.0).cycle();
                    values
                        .iter_mut()
                        .zip(shifts)
                        .for_each(|(value, by)| *value += by);
                }
                (Samples::U8(colors), ViewKind::Rgb) => {
                    let shifts = (0..7).map(|i| i * 9).cycle();
                    let pairs = colors.iter_mut().zip(shifts);
                    pairs.for_each(|(color, by)| *color = color.wrapping_add(by));
                }
                _ => {}
            }
        }
        answer
    });
    assert_said(&causes, ["lrgb-colors-in-planes", "wrong final values"]);
}

/// A decoder that lacks a format may refuse some files in that format before it reads the format name.
#[test]
fn undecoded_format_is_unsupported_despite_refusals() {
    let mut suite = suite_of_small_files();
    let is_wanted = |case: &Case| match case.format() {
        Format::Lum => case.expect == Expect::Decode,
        format => case.first && format == Format::Rgb,
    };
    suite.cases.retain(is_wanted);
    let is_refused = |file: &[u8]| file.len().is_multiple_of(7);
    let is_lum = |file: &[u8]| file.windows(14).any(|word| word == b"PTM_FORMAT_LUM");
    let run = run_faulty_decoder(&suite, |request, answer| match answer {
        Answer::Decoded(_) if is_lum(request.file) => match is_refused(request.file) {
            true => Answer::Rejected,
            false => Answer::Unsupported,
        },
        other => other,
    });
    let count = |outcome| run.judgment.with_outcome(outcome).count();
    let (refused, unsupported) = (count(Outcome::Fail), count(Outcome::Unsupported));
    assert!(unsupported > 3 * refused, "{refused} {unsupported}");
    let lum = (suite.cases.iter()).filter(|case| case.format() == Format::Lum);
    let refusable = lum.filter(|case| is_refused(&case.build(TableSpelling::default()).file));
    assert!((1..=refusable.count()).contains(&refused), "{refused}");
}

/// "Every legal file" must not include files whose responses are inconsistent, and that are not compared.
#[test]
fn files_with_inconsistent_responses_are_not_among_all_files_with_a_property() {
    let mut suite = suite_of_small_files();
    suite.cases.retain(|case| case.format() == Format::Rgb);
    let mut run = run_faulty_decoder(&suite, |_, answer| match answer {
        Answer::Decoded(frame) if frame.width * frame.height > 20 => Answer::Rejected,
        other => other,
    });
    let one = failures(&run)[0];
    run.observations[one]
        .as_mut()
        .expect("a response")
        .nondeterminism = Some(Nondeterminism {
        in_serve_mode: false,
        message: "two calls returned different responses".to_owned(),
    });
    let causes = causes(&suite, &run)
        .iter()
        .map(cause_text)
        .collect::<Vec<_>>();
    println!("{causes:#?}");
    let says = "every legal file with consistent responses whose number of texels is at least";
    assert!(causes[0].contains(says), "{causes:#?}");
}

/// Mistakes in formulas: the name of the formula, the wrong expression, the only view that the decoder supports, and parts of the
/// text of the first cause.
const FORMULA_MISTAKES: &str = "
stored value | mod(raw + 128 * select(at_most(abs(i - 3), 0), 1, 0), 256) | raw | + 128 instead of && only in a3
stored value | mod(raw + 1, 256) | raw | raw + 1 instead of raw
final coefficient | (raw - select(at_most(abs(bias[i] + 1), 0), 0, bias[i])) * scale[i] | any | wrong final values
final coefficient | select(at_most(abs(i - 4), 0), raw - bias[i], (raw - bias[i]) * scale[i])
  | coef | raw - bias[i] instead of && only in a4
stored column | select(at_most(mod(height - 1 - y, 2), 0), x, width - 1 - x) | raw | the correct values in the wrong places
polynomial | a0 * u * u + a1 * v * v + a2 * u * v + a3 * u + a4 * v - a5 | rgb | + a4 * v - a5 instead of
matrix row | m[k] + Y + (m[4 + k] + Cr) + (m[8 + k] + Cb) + (m[12 + k] + 1) | rgb | m[4 + k] + Cr && m[12 + k] + 1
matrix row | m[k] * Y + m[4 + k] * a5 + m[8 + k] * Cb + m[12 + k] | rgb | m[4 + k] * a5
color | L + rgb / 255 | rgb | L + rgb / 255 instead of
RGB sample | (c + width * height + row * width + x) * 6 + i | any | (c + width * height + (row * width + x)) * 6 + i instead of
channel of a coefficient | c * 6 + i + 1 | rgb | c * 6 + i + 1 instead of
matrix row | m[k] * Y + m[5 + k] * Cr + m[10 + k] * Cb + m[15 + k] | rgb | m[10 + k] * Cb
plane | mod(residual + predictor - 129, 256) | any | residual + predictor - 129, 256) instead of
second column of a mean | x - floor((mx + 1) / 2) | any | x - floor((mx + 1) / 2) instead of
first row of a mean | y + floor(my / 3) | any | y + floor(my / 3) instead of
LUM sample | (row * width + x) * 8 + i - 1 | any | the first byte after the header as at - 1
LRGB color | width * height * 6 + k - (row * width + x) * 3 | any | k - (row * width + x) * 3
LRGB coefficient | row * width + x + 6 + i | any | x + 6 + i instead of
RGB sample | ((c * height + row) * width + x) * 5 + i | any | * 5 + i instead of
polynomial | a0 * u * u + a2 * u * v + a3 * u + a4 * v + a5 | rgb | a0 * u * u + a2 * u * v
final coefficient | (raw - bias[i]) * scale[mod(c * 6 + i, 5)] | any | scale[mod(c * 6 + i, 5)] instead of
final coefficient | (raw - bias[c + i / 6]) * scale[i] | any | bias[c + i / 6]
final color | select(at_most(i, 0), (raw - bias[i]) * scale[i], raw) | any | ((raw - bias[i]) * scale[i] if i <= 0, else raw)
number of a byte | mod(raw + 128, 256) - 128 | any | mod(raw + 128, 256) - 128 instead of raw
float byte | select(at_most(3, k), 0, mod(floor(bits / power(2, 8 * k)), 256)) | any | byte k of a float && (0 if 3 <= k
float byte | mod(floor(integer / power(2, 8 * k)), 256) | any | where integer is the float without its fraction
float place | 3 * v | any | 3 * v instead of
color place | t * 4 + k | any | t * 4 + k instead of
color place | select(at_most(abs(t), 0), none, t * 3 + k) | any | (none if t = 0, else t * 3 + k)
color place | select(at_most(n - 1, t), none, t * 3 + k) | any | where n is the number of texels
color place | select(at_most(abs(t), 0), t * 3 + k, none) | any | (t * 3 + k if t = 0, else none)
final coefficient | select(at_most(i, 0), (raw - bias[i]) * scale[i], 0) | any | ((raw - bias[i]) * scale[i] if i <= 0, else 0)
final coefficient | select(at_most(abs(i - 5), 0), 0, (raw - bias[i]) * scale[i]) | any | 0 instead of && only in a5
shown value | max(min(value, 255) - 1, 0) | rgb | max(min(value, 255) - 1, 0) instead of
shown value | select(at_most(value, 0), 0, select(at_most(255, value), 255, value + 1)) | rgb | (255 if 255 <= value, else value + 1)
shown value | select(at_most(value, 0), 0, select(at_most(255, value), 255, max(value - 1, 0)))
  | rgb | (255 if 255 <= value, else max(value - 1, 0))
shown value | max(max(value, 0), 255) | any | max(max(value, 0), 255) instead of
channel of a coefficient | c * 6 + i - 1 | any | c * 6 + i - 1 instead of
matrix row | m[k] * Y + m[12 + k] * Cr + m[8 + k] * Cb + m[12 + k] | rgb | m[12 + k] * Cr
stored value | select(at_most(abs(t), 0), 0, raw) | any | (0 if t = 0, else raw) && t is the number of the texel
stored value | select(at_most(abs(t), 0), raw, 0) | any | (raw if t = 0, else 0)
channel of a value | c * 5 + i | any | c * 5 + i instead of
channel of a value | select(at_most(abs(c), 0), i + 3, i) | any | (i + 3 if c = 0, else i)
stored texel | (height - 1 - floor(p / (width + 1))) * width + mod(p, width + 1) - 1 | any | mod(p, width + 1)
record position | (p3 * 256 + p2) * 256 + p1 | any | (p3 * 256 + p2) * 256 + p1 instead of
start of the texels | at - 1 | any | the first byte after the header as at - 1 instead of at
size of a group | count | any | as count instead of size && count is the number of texels
size of a group | select(at_most(abs(b - 1), 0), size - 1, size) | any | (size - 1 if b = 1, else size)
end of a group | (t + 2) * size | any | (t + 2) * size instead of (t + 1) * size
float byte | mod(floor(truncated / power(2, 8 * k)), 256) | any | where truncated is the bit pattern
length of a block | 0 | any | as 0 instead of count * size
index byte | entries * size + select(at_most(1, k), (row * width + x) * 2 + 2, (row * width + x) * bytes + k)
  | any | bytes
RGB sample | (c + height * width + row * width + x) * 6 + i | any | c + width * height
";

#[test]
fn formula_mistake_is_described() {
    let suite = suite_of_small_files();
    for [formula, expression, view, says] in rows(FORMULA_MISTAKES) {
        println!("{formula} = {expression}");
        let edit = Edit::parse(&formula, &expression).expect("a formula");
        let mistake = formula_misreading(vec![edit]);
        let causes = diagnose_faulty_decoder(&suite, |request, answer| match answer {
            Answer::Decoded(_) if view != "any" && view != request.view.name() => {
                Answer::Unsupported
            }
            _ => answer_with(&[&mistake], request),
        });
        let mut parts = says.split(" && ");
        let is_described = parts.all(|part| causes[0].contains(part));
        assert!(is_described, "{expression}: {causes:#?}");
    }
}

/// A channel outside the texel may have any value.
#[test]
fn channel_outside_the_texel_is_described() {
    let suite = suite_of_small_files();
    for (formula, expression, format, says) in [
        (
            "channel of a color",
            "7 + k",
            Format::PtmLut,
            "7 + k instead of 6 + k",
        ),
        (
            "channel of a coefficient",
            "c * 7 + i",
            Format::Rgb,
            "c * 7 + i instead of",
        ),
    ] {
        let edit = Edit::parse(formula, expression).expect("a formula");
        let mistake = formula_misreading(vec![edit]);
        let mut suite = suite.clone();
        suite.cases.retain(|case| case.format() == format);
        let causes = diagnose_faulty_decoder(&suite, |request, _| {
            let mut answer = answer_with(&[&mistake], request);
            if let Answer::Decoded(frame) = &mut answer
                && frame.view == ViewKind::Rgb
                && let Samples::U8(samples) = &mut frame.samples
            {
                let blue = samples.iter_mut().skip(2).step_by(3);
                blue.for_each(|sample| *sample = 77);
            }
            answer
        });
        assert!(causes[0].contains(says), "{expression}: {causes:#?}");
    }
}

/// A decoder that reads outside the data finds anything or nothing there.
#[test]
fn position_outside_the_data_is_described() {
    let suite = suite_of_small_files();
    for (formula, expression, outside, says) in [
        (
            "PTM_LUT color",
            "entries * size + width * height * bytes + (row * width + x) * 4 + k",
            Outside::Byte(0x5a),
            "(row * width + x) * 4 + k",
        ),
        (
            "LRGB coefficient",
            "i - (row * width + x) * 6",
            Outside::Byte(0x5a),
            "i - (row * width + x) * 6 instead of",
        ),
        (
            "stored texel",
            "(height - 1 - floor(p / (width + 1))) * width + mod(p, width + 1)",
            Outside::Nothing,
            "mod(p, width + 1) instead of",
        ),
    ] {
        let edit = Edit::parse(formula, expression).expect("a formula");
        let mistake = formula_misreading(vec![edit]);
        let causes = diagnose_faulty_decoder(&suite, |request, answer| match answer {
            Answer::Decoded(_) => {
                let (file, view) = (request.file, request.view);
                ptm_mistakes::answer_with(&[&mistake], Reading::SPEC, file, view, outside)
            }
            other => other,
        });
        assert!(causes[0].contains(says), "{expression}: {causes:#?}");
    }
}

#[test]
fn mistake_outside_the_formulas_is_described() {
    let suite = suite_of_small_files();
    let decoders: &[(&str, ChangeAnswer, &[&str])] = &[
        (
            "refuses two formats, which one misreading would also explain",
            |request, answer| match request.file.windows(16).any(|at| at == b"PTM_FORMAT_JPEG_") {
                true if answer != Answer::Unsupported => Answer::Rejected,
                _ => answer,
            },
            &["refuses every legal file in format JPEG_RGB or JPEG_LRGB"],
        ),
        (
            "reads indices as signed bytes",
            |request, answer| {
                let fields = ptm::decode::fields_as(request.file, &Reading::SPEC);
                let mut indices = fields.iter().filter(|field| field.clause == "2.8.1/1");
                let is_negative = |field: &ptm::Field| {
                    let indices = &request.file[field.range.clone()];
                    indices.iter().any(|&byte| byte >= 0x80)
                };
                match answer {
                    Answer::Decoded(_) if indices.any(is_negative) => Answer::Rejected,
                    other => other,
                }
            },
            &["every legal file with a byte of 0x80 or more in an index"],
        ),
        (
            "too wide",
            |_, answer| match answer {
                Answer::Decoded(frame) if frame.width > 16 => Answer::Rejected,
                other => other,
            },
            &["refuses every legal file", "width"],
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
            "colors one byte too late",
            |_, answer| match answer {
                Answer::Decoded(mut frame) => {
                    if let (Samples::U8(samples), 9) = (&mut frame.samples, frame.channels) {
                        for texel in samples.chunks_exact_mut(9) {
                            texel.copy_within(6..8, 7);
                            texel[6] = 0;
                        }
                    }
                    Answer::Decoded(frame)
                }
                other => other,
            },
            &["wrong stored values: G has the values of R, B those of G, only in"],
        ),
        (
            "samples one place too early",
            |_, answer| match answer {
                Answer::Decoded(mut frame) if frame.view == ViewKind::Raw => {
                    if let Samples::U8(samples) = &mut frame.samples {
                        samples.rotate_left(1);
                    }
                    Answer::Decoded(frame)
                }
                Answer::Decoded(_) => Answer::Unsupported,
                other => other,
            },
            &["every channel but the last has the values of the next one"],
        ),
        (
            "first stored texel zero",
            |_, answer| match answer {
                Answer::Decoded(mut frame) if frame.view == ViewKind::Raw => {
                    let texel = (frame.width * (frame.height - 1)) as usize;
                    let channels = frame.channels as usize;
                    if let Samples::U8(samples) = &mut frame.samples {
                        samples[texel * channels..][..channels].fill(0);
                    }
                    Answer::Decoded(frame)
                }
                Answer::Decoded(_) => Answer::Unsupported,
                other => other,
            },
            &["computes a stored value", "as (0 if t = 0, else raw)"],
        ),
        (
            "last texel zero",
            |_, answer| match answer {
                Answer::Decoded(mut frame) if frame.view == ViewKind::Raw => {
                    if let Samples::U8(samples) = &mut frame.samples {
                        let last = samples.len() - frame.channels as usize;
                        samples[last..].fill(0);
                    }
                    Answer::Decoded(frame)
                }
                Answer::Decoded(_) => Answer::Unsupported,
                other => other,
            },
            &["wrong stored values"],
        ),
        (
            "noise in all planes, also in those with side information",
            |request, answer| match answer {
                Answer::Decoded(mut frame) if frame.view == ViewKind::Raw => {
                    let is_coded = request.file.windows(16).any(|at| at == b"PTM_FORMAT_JPEGL");
                    if let (Samples::U8(samples), true) = (&mut frame.samples, is_coded) {
                        for (i, sample) in samples.iter_mut().enumerate() {
                            *sample ^= (i * i % 251) as u8 | 1;
                        }
                    }
                    Answer::Decoded(frame)
                }
                Answer::Decoded(_) => Answer::Unsupported,
                other => other,
            },
            &["shows wrong values in planes that are not predicted, in"],
        ),
        (
            "red and green exchanged",
            |_, answer| match answer {
                Answer::Decoded(mut frame) => {
                    if let (Samples::U8(samples), 18) = (&mut frame.samples, frame.channels) {
                        let texels = samples.chunks_exact_mut(18);
                        texels.for_each(|texel| texel[..12].rotate_left(6));
                    }
                    Answer::Decoded(frame)
                }
                other => other,
            },
            &["wrong places: red has the values of green, green those of red"],
        ),
        (
            "height instead of width",
            |_, answer| match answer {
                Answer::Decoded(mut frame) if frame.height < 100 => {
                    frame.width = frame.height;
                    let count = (frame.width * frame.height * frame.channels) as usize;
                    if let Samples::U8(samples) = &mut frame.samples {
                        samples.resize(count, 0);
                    }
                    Answer::Decoded(frame)
                }
                other => other,
            },
            &["different size: height × height instead of width × height"],
        ),
        (
            "signed limit of colors",
            |_, answer| match answer {
                Answer::Decoded(mut frame) if frame.view == ViewKind::Rgb => {
                    if let Samples::U8(samples) = &mut frame.samples {
                        let limited = samples.iter_mut().filter(|value| **value == 255);
                        limited.for_each(|value| *value = 127);
                    }
                    Answer::Decoded(frame)
                }
                other => other,
            },
            &["wrong colors: every wrong sample is 127 instead of 255"],
        ),
    ];
    for (name, change, says) in decoders {
        println!("{name}");
        let causes = diagnose_faulty_decoder(&suite, change);
        let is_described = says.iter().all(|part| causes[0].contains(part));
        assert!(is_described, "{name}: {causes:#?}");
    }
}

/// A property of most files is no cause if most files without it fail, too.
#[test]
fn property_of_the_few_files_that_are_read_is_not_named() {
    let suite = suite_of_small_files();
    let causes = diagnose_faulty_decoder(&suite, |_, answer| match answer {
        Answer::Decoded(frame) if frame.height % 2 == 1 || frame.width % 3 != 0 => Answer::Rejected,
        other => other,
    });
    let names_height = causes.iter().any(|cause| cause.contains("odd height"));
    assert!(!names_height, "{causes:#?}");
}

/// Counts the mistakes that are among the first `mistakes.len()` causes.
fn count_named(mistakes: &[&'static Misreading], diagnoses: &[Diagnosis]) -> usize {
    let first = || diagnoses.iter().take(mistakes.len());
    let is_named =
        |mistake: &&&Misreading| first().any(|diagnosis| slugs(diagnosis).contains(&mistake.slug));
    mistakes.iter().filter(is_named).count()
}

/// Returns the causes that are reported as certain, but are not in `mistakes`.
fn false_causes(mistakes: &[&'static Misreading], diagnoses: &[Diagnosis]) -> Vec<String> {
    let is_false = |diagnosis: &&Diagnosis| {
        let slugs = slugs(diagnosis);
        let is_real = mistakes.iter().any(|mistake| slugs.contains(&mistake.slug));
        diagnosis.is_mechanism && !is_real
    };
    diagnoses.iter().filter(is_false).map(cause_text).collect()
}

fn describe_result(mistakes: &[&'static Misreading], count: usize, found: &[Diagnosis]) -> String {
    let slugs: Vec<&str> = mistakes.iter().map(|mistake| mistake.slug).collect();
    let causes: Vec<String> = found
        .iter()
        .map(|diagnosis| format!("    {} {}", diagnosis.explains.len(), cause_text(diagnosis)))
        .collect();
    format!("{slugs:?}, {count} failures:\n{}", causes.join("\n"))
}

/// Misreadings that look alike if the decoder expects a line feed after tables and therefore reads hardly any tables.
const HIDDEN_BY_LINE_FEED: &str = "lut-formats-swapped table-not-read table-padded-to-256 table-one-entry-short \
    table-separated width-always-two index-one-based";

/// Checks every `step`th misreading, starting at `first`: a decoder with this misreading must fail, and the first cause must name
/// the misreading.
fn check_every_misreading(
    (first, step): (usize, usize),
    suite: &Suite,
    hidden: &str,
    run: impl Fn(&'static Misreading) -> Run,
) {
    let (mut wrong, mut count) = (Vec::new(), 0);
    let all = ptm_mistakes::all().filter(|one| !hidden.split(' ').any(|slug| slug == one.slug));
    for mistake in all.skip(first).step_by(step) {
        count += 1;
        let run = run(mistake);
        let failing = failures(&run).len();
        let diagnoses = causes(suite, &run);
        if failing == 0 || count_named(&[mistake], &diagnoses) == 0 {
            wrong.push(describe_result(&[mistake], failing, &diagnoses));
            println!("{}", wrong[wrong.len() - 1]);
        }
        if count % 10 == 0 {
            println!("{count} done, {} missed", wrong.len());
        }
    }
    println!("{count} misreadings, {} not named first", wrong.len());
    assert!(wrong.is_empty(), "{wrong:#?}");
}

fn check_in_reference_dialect(first: usize, step: usize) {
    let suite = suite_of_small_files();
    let (_, right) = run_with_mistakes(&suite, &[], &[], jobs(), &HashMap::new());
    let run = |mistake| run_with_mistakes(&suite, &[mistake], &[], jobs(), &right).0;
    check_every_misreading((first, step), &suite, "", run);
}

/// Checks misreadings of a decoder that reads an open question differently from the reference.
fn check_with_line_feed_after_tables(first: usize, step: usize) {
    let suite = suite_of_small_files();
    let reading = Reading {
        after_table: read_newline_separator,
        ..Reading::SPEC
    };
    let run = |mistake| {
        run_all(&suite, |request| {
            ptm_mistakes::answer(&[mistake], reading, request.file, request.view)
        })
    };
    check_every_misreading((first, step), &suite, HIDDEN_BY_LINE_FEED, run);
}

#[test]
fn one_misreading_in_forty_is_named() {
    check_in_reference_dialect(8, 40);
}

#[test]
#[ignore = "takes minutes"]
fn every_misreading_is_named() {
    check_in_reference_dialect(0, 1);
}

#[test]
fn one_misreading_in_eighty_is_named_with_line_feed_after_tables() {
    check_with_line_feed_after_tables(3, 80);
}

#[test]
#[ignore = "takes minutes"]
fn every_misreading_is_named_with_line_feed_after_tables() {
    check_with_line_feed_after_tables(0, 1);
}

/// Generates the same pseudorandom sets of compatible misreadings on every platform.
pub(super) fn random_sets(count: usize, size: usize) -> Vec<Vec<&'static Misreading>> {
    let all: Vec<&'static Misreading> = ptm_mistakes::all().collect();
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
            if set.iter().all(|other| can_combine(other, next)) {
                set.push(next);
            }
        }
        sets.push(set);
    }
    sets
}

/// Returns true if each mistake in the set changes at least one answer of a decoder that makes the other mistakes.
fn all_have_an_effect(suite: &Suite, set: &[&'static Misreading]) -> bool {
    let answer = |set: &[&Misreading], file: &[u8], view| {
        ptm_mistakes::answer(set, Reading::SPEC, file, view)
    };
    set.iter().all(|member| {
        let others = set.iter().filter(|other| other.slug != member.slug);
        let others: Vec<&Misreading> = others.copied().collect();
        suite.cases.iter().any(|case| {
            let file = &case.build(TableSpelling::default()).file;
            let shows = |view| answer(set, file, view) != answer(&others, file, view);
            can_affect_file(member, file) && case.views.first().is_some_and(shows)
        })
    })
}

/// Tests `count` sets of `size` mistakes that all have an effect. Each set must be caught. For at least `min_named` percent of
/// the sets, all mistakes must be among the first causes. For at most `max_false` percent, a false cause may be reported as
/// certain.
fn check_sets(count: usize, size: usize, min_named: usize, max_false: usize) {
    let suite = suite_of_small_files();
    let (_, right) = run_with_mistakes(&suite, &[], &[], jobs(), &HashMap::new());
    let (mut tried, mut named, mut misled) = (0, 0, 0);
    for set in random_sets(count * 4, size) {
        if tried == count {
            break;
        }
        if !all_have_an_effect(&suite, &set) {
            continue;
        }
        tried += 1;
        let (run, _) = run_with_mistakes(&suite, &set, &[], jobs(), &right);
        let failing = failures(&run).len();
        assert!(failing > 0, "no case fails for {set:?}");
        let diagnoses = causes(&suite, &run);
        let is_named = count_named(&set, &diagnoses) == size;
        let wrong = false_causes(&set, &diagnoses);
        named += usize::from(is_named);
        misled += usize::from(!wrong.is_empty());
        if !is_named || !wrong.is_empty() {
            println!("{}", describe_result(&set, failing, &diagnoses));
            println!("  FALSE {wrong:?}");
        }
        println!("{tried} sets of {size}: {named} named, {misled} with a false cause");
    }
    assert!(named * 100 >= tried * min_named, "{named} of {tried}");
    assert!(misled * 100 <= tried * max_false, "{misled} of {tried}");
}

#[test]
fn mistake_is_named_in_addition_to_an_assumed_one() {
    let suite = suite_of_small_files();
    let [assumed, second] = ["coefficients-reversed", "u-and-v-exchanged"].map(misreading);
    let (mut run, _) = run_with_mistakes(&suite, &[assumed, second], &[], jobs(), &HashMap::new());
    assume(&suite, &mut run, &[assumed], jobs());
    let causes = diagnose(&suite, &run, &[assumed], jobs()).diagnoses;
    assert_eq!(causes.len(), 1);
    assert_eq!(slugs(&causes[0]), ["u-and-v-exchanged"]);
    assert_eq!(causes[0].explains.len(), failures(&run).len());
}

/// Mistakes of which one changes some images only together with the other.
#[test]
fn mistakes_that_show_only_together_are_named() {
    let suite = suite_of_small_files();
    for pair in [
        ["a0-a5-swapped", "rgb-coefficients-by-color"],
        ["side-last-record-lost", "side-values-wrap-only"],
    ] {
        let pair = pair.map(misreading);
        let (run, _) = run_with_mistakes(&suite, &pair, &[], jobs(), &HashMap::new());
        let diagnoses = causes(&suite, &run);
        println!(
            "{}",
            describe_result(&pair, failures(&run).len(), &diagnoses)
        );
        assert_eq!(count_named(&pair, &diagnoses), 2);
        assert_eq!(false_causes(&pair, &diagnoses), [""; 0]);
    }
}

#[test]
fn ten_pairs_are_named() {
    check_sets(10, 2, 80, 20);
}

#[test]
#[ignore = "takes minutes"]
fn two_hundred_pairs_are_named_without_false_causes() {
    check_sets(200, 2, 95, 0);
}

#[test]
#[ignore = "takes minutes"]
fn sixty_triples_are_caught_and_most_named() {
    check_sets(60, 3, 80, 5);
}
