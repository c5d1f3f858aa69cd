//! Tests that every sentence that is printed about a small wrong decoder is true, and that its mistakes are told apart.
//!
//! Each decoder makes one or two known mistakes. Its author could refute the sentences that the tests forbid.

use std::cell::RefCell;
use std::ops::Range;
use std::sync::OnceLock;
use std::time::Duration;

use ptm::decode::{decode_as, examine_as, indices, planes, predict};
use ptm::error::Class;
use ptm::parts::{Coded, Plan, PlaneStream, Record, Step};
use ptm::{Coding, Format, Limits, Planes, Ptm, Reading, ScaleBias, Shape, Size, evaluate};
use ptm_conform::report::text::report_to_text;
use ptm_harness::diagnose::{Category, diagnose, equal_up_to_rounding};
use ptm_harness::pipeline::judge_answers;
use ptm_harness::report::document::{LikelyCause, Report};
use ptm_harness::report::suite_texts::SuiteTexts;
use ptm_harness::session::plan::RunPlan;
use ptm_harness::session::run::Run;
use ptm_mistakes::Misreading;
use ptm_mistakes::formula::{Edit, Formula};
use ptm_suite::cases::{Case, Expect, Suite, TableSpelling};
use ptm_suite::choices::CHOICES;
use ptm_suite::compare::Expected;
use ptm_suite::protocol::frame::{Answer, Frame, Samples, TimeLimit, View, ViewKind};
use ptm_suite::protocol::request::{Reply, Request};
use ptm_suite::verdicts::observation::Response;
use ptm_suite::verdicts::outcome::Outcome;

use super::causes::random_sets;
use super::claims::false_claims;
use crate::in_process::{
    answer_with, formula_misreading, jobs, misreading, reference_answer, suite_of_small_files,
};

/// A cause as the report prints it.
struct PrintedCause {
    cause: LikelyCause,
    /// The sentences about the cause, without the failures that are printed below them.
    sentences: String,
    /// The failures below the sentences.
    failures: String,
}

/// The printed report on a decoder, and what is wrong with it.
struct PrintedReport {
    text: String,
    /// Rulings of the open questions whose answers the report states.
    followed: Vec<String>,
    causes: Vec<PrintedCause>,
    problems: Vec<String>,
}

/// Returns the cases of small files that satisfy `is_needed`, and those that are requested first.
fn cases(is_needed: impl Fn(&Case) -> bool) -> Suite {
    static SUITE: OnceLock<Suite> = OnceLock::new();
    let mut suite = SUITE.get_or_init(suite_of_small_files).clone();
    suite.cases.retain(|case| case.first || is_needed(case));
    suite
}

/// Returns the cases of small files that satisfy `is_needed`.
fn only(is_needed: impl Fn(&Case) -> bool) -> Suite {
    let mut suite = cases(|_| true);
    suite.cases.retain(is_needed);
    suite
}

fn is_uncompressed(case: &Case) -> bool {
    case.format().coding().is_none()
}

fn is_compressed(case: &Case) -> bool {
    case.format().coding().is_some()
}

/// Runs the suite against a decoder, searches for causes, and prints them.
///
/// For any decoder, each failure must be listed under exactly one cause. A misreading that is named as a cause, or that "would look
/// the same", must reproduce each response that is listed below it, and so must a formula. No failure is listed because it "may"
/// have a cause.
fn printed_report<R: Into<Reply>>(
    suite: &Suite,
    decoder: impl Fn(&Request) -> R + Sync,
) -> PrintedReport {
    let ask = |request: &Request<'_>, _: usize| -> Reply { decoder(request).into() };
    let run = judge_answers(suite, &RunPlan::new(suite, jobs()), &ask);
    let found = diagnose(suite, &run, &[], jobs());
    let report = Report::new(suite, &run, &["decoder".to_owned()], Vec::new());
    let mut report = report.with_diagnoses(suite, &found.diagnoses);
    report.remove_readings(&found.imitated);
    let texts = SuiteTexts::new(suite).expect("the texts can be read");
    let causes = report.diagnoses.iter().map(|cause| {
        let only = Report {
            remarks: Vec::new(),
            diagnoses: vec![cause.clone()],
            ..report.clone()
        };
        let text = report_to_text(&only, &texts, 0);
        let block = text.split("\n\n").next().unwrap_or_default();
        let end = block.find("\n  FAIL ").unwrap_or(block.len());
        PrintedCause {
            cause: cause.clone(),
            sentences: block[..end].to_owned(),
            failures: block[end..].to_owned(),
        }
    });
    let mut printed = PrintedReport {
        text: report_to_text(&report, &texts, 0),
        followed: (report.dialect.iter())
            .map(|followed| followed.ruling.clone())
            .collect(),
        causes: causes.collect(),
        problems: Vec::new(),
    };
    for cause in &printed.causes {
        println!("{}{}", cause.sentences, cause.failures);
    }
    printed.check_failures_are_listed_once(suite, &run);
    let answer = |request: &Request| decoder(request).into().answer;
    for printed_cause in &printed.causes {
        let claims = false_claims(&printed_cause.cause, suite, &run, &answer);
        printed.problems.extend(claims);
    }
    printed.check_mistakes_reproduce_responses(suite, &run, answer);
    printed.check_misreadings_refuse_no_image(suite, &run);
    printed.never_says("may have the same cause")
}

/// Returns every failing case that is listed under a cause.
fn listed(cause: &LikelyCause) -> impl Iterator<Item = &String> {
    cause.explains.iter()
}

impl PrintedReport {
    /// Returns the line about the readings of open questions.
    fn dialect(&self) -> &str {
        let mut lines = self.text.lines();
        lines
            .find(|line| line.starts_with("dialect: "))
            .unwrap_or_default()
    }

    fn check_failures_are_listed_once(&mut self, suite: &Suite, run: &Run) {
        let failing = run.judgment.with_outcome(Outcome::Fail);
        let mut failing: Vec<&String> = failing.map(|i| &suite.cases[i].id).collect();
        failing.sort_unstable();
        let mut all: Vec<&String> = self
            .causes
            .iter()
            .flat_map(|one| listed(&one.cause))
            .collect();
        all.sort_unstable();
        if run.not_a_decoder.is_none() && all != failing {
            let (all, failing) = (all.len(), failing.len());
            self.problems.push(format!(
                "{all} failures are listed under causes, but {failing} cases fail"
            ));
        }
    }

    /// A misreading that is named or "would look the same", and a formula that "computes … as …", must reproduce each response that
    /// is listed below it, alone or with other named mistakes.
    fn check_mistakes_reproduce_responses(
        &mut self,
        suite: &Suite,
        run: &Run,
        decoder: impl Fn(&Request) -> Answer,
    ) {
        let find = |slug: &String| ptm_mistakes::find(slug);
        let causes = || self.causes.iter().map(|printed| &printed.cause);
        let named = causes().flat_map(|cause| cause.misreading.iter().chain(&cause.accompanying));
        let edited: Vec<Option<Misreading>> = causes().map(edited_formula).collect();
        let edits = edited.iter().flatten();
        let mut named: Vec<&Misreading> = named.filter_map(find).collect();
        named.sort_by_key(|misreading| misreading.slug);
        named.dedup_by_key(|misreading| misreading.slug);
        named.extend(edits);
        let sets = subsets(&named);
        let mut problems = Vec::new();
        for (cause, edited) in causes().zip(&edited) {
            let claimed = cause.misreading.iter().chain(&cause.equivalents);
            for misreading in claimed.filter_map(find).chain(edited) {
                // A decoder makes each mistake once.
                let is_other = |other: &&Misreading| !std::ptr::eq(*other, misreading);
                let is_refuted = |id: &&String| {
                    let others = sets.iter().filter(|set| set.iter().all(is_other));
                    let mut sets = others.map(|set| [&[misreading][..], set].concat());
                    !sets.any(|set| reproduces(&set, id, suite, run, &decoder))
                };
                let refuted: Vec<&String> = listed(cause).filter(is_refuted).collect();
                if let [first, ..] = refuted[..] {
                    let (count, effect) = (refuted.len(), &cause.effect);
                    let slug = misreading.slug;
                    problems.push(format!(
                        "{slug} answers {count} of these cases in another way, for example {first}: {effect}"
                    ));
                }
            }
        }
        self.problems.extend(problems);
    }

    /// A misreading that "would also show no image" of the files listed refuses no file of which the decoder shows an image.
    fn check_misreadings_refuse_no_image(&mut self, suite: &Suite, run: &Run) {
        let causes = self.causes.iter().map(|printed| &printed.cause);
        let refusals = causes.filter(|cause| cause.kind == Some(Category::Refusal));
        let offered = refusals.flat_map(|cause| &cause.equivalents);
        for misreading in offered.filter_map(|slug| ptm_mistakes::find(slug)) {
            let cases = suite.cases.iter().zip(&run.observations);
            let refused = cases.filter(|(case, observation)| {
                let Some(observation) = observation else {
                    return false;
                };
                let is_image = matches!(observation.response, Response::Image { .. });
                let file = &case.build(run.table).file;
                let request = Request::new(&case.id, &observation.view, file, 1 << 24);
                is_image
                    && matches!(reference_answer(&request), Answer::Decoded(_))
                    && answer_with(&[misreading], &request) == Answer::Rejected
            });
            let refused: Vec<&String> = refused.map(|(case, _)| &case.id).collect();
            if let [first, ..] = refused[..] {
                self.problems.push(format!(
                    "the decoder shows an image of {} files that {} refuses, for example {first}",
                    refused.len(),
                    misreading.slug
                ));
            }
        }
    }

    /// Requires that no sentence contains `words`.
    fn never_says(mut self, words: &str) -> PrintedReport {
        let sentences = self.causes.iter().map(|one| &one.sentences);
        let made = sentences.filter(|text| text.contains(words));
        self.problems
            .extend(made.map(|text| format!("\"{words}\" is false or misleading: {text}")));
        self
    }

    /// Requires that the sentences about one cause contain all of `parts`.
    fn says(mut self, parts: &[&str]) -> PrintedReport {
        let mut sentences = self.causes.iter().map(|one| &one.sentences);
        if !sentences.any(|text| parts.iter().all(|part| text.contains(part))) {
            self.problems.push(format!("no cause says {parts:?}"));
        }
        self
    }

    /// Requires at most this number of causes.
    fn has_at_most(self, count: usize) -> PrintedReport {
        let count = count.min(self.causes.len());
        self.has_causes(count)
    }

    /// Requires this number of causes.
    fn has_causes(mut self, count: usize) -> PrintedReport {
        if self.causes.len() != count {
            let causes = self
                .causes
                .iter()
                .map(|one| format!("\n  {}", one.cause.effect));
            let causes: String = causes.collect();
            self.problems
                .push(format!("expected {count} causes: {causes}"));
        }
        self
    }

    /// Requires that each clause that is printed is tested by every case listed under the cause.
    fn cites_tested_clauses_only(mut self, suite: &Suite) -> PrintedReport {
        let clauses = |id: &String| {
            let mut cases = suite.cases.iter();
            &cases.find(|case| case.id == *id).expect("a case").clauses
        };
        for cause in self.causes.iter().map(|printed| &printed.cause) {
            let Some(clause) = &cause.clause else {
                continue;
            };
            let untested = listed(cause)
                .filter(|id| !clauses(id).contains(clause))
                .count();
            if cause.misreading.is_none() && untested > 0 {
                self.problems.push(format!(
                    "{untested} of the cases do not test clause {clause}: {}",
                    cause.effect
                ));
            }
        }
        self
    }

    #[track_caller]
    fn assert_true(self) {
        assert_all_true([self]);
    }
}

/// Fails if there is a problem with any of the reports, and lists the problems of all.
#[track_caller]
fn assert_all_true(reports: impl IntoIterator<Item = PrintedReport>) {
    let problems = reports.into_iter().flat_map(|report| report.problems);
    let problems: Vec<String> = problems.collect();
    assert!(problems.is_empty(), "\n{}", problems.join("\n"));
}

/// Returns the mistake of a cause that "computes … as …", unless it applies only to some channels.
fn edited_formula(cause: &LikelyCause) -> Option<Misreading> {
    let (value, rest) = cause.effect.strip_prefix("computes ")?.split_once(" as ")?;
    let (expression, rest) = rest.split_once(" instead of ")?;
    if rest.contains(", only in ") && !rest.contains(", only in files ") {
        return None;
    }
    let mut formulas = Formula::ALL.into_iter();
    let (_, name) = formulas.find(|(formula, _)| formula.stated().result == value)?;
    let edit = Edit::parse(name, expression).ok()?;
    Some(formula_misreading(vec![edit]))
}

/// Returns all subsets, the smallest first.
fn subsets<'a>(all: &[&'a Misreading]) -> Vec<Vec<&'a Misreading>> {
    let mut sets = vec![Vec::new()];
    for &one in all {
        let with_it = sets.iter().map(|set| [&set[..], &[one]].concat());
        sets.extend(with_it.collect::<Vec<_>>());
    }
    sets.sort_by_key(Vec::len);
    sets
}

/// Returns true if a decoder with these mistakes, in the reading of the reference or in that of the decoder, answers a case as the
/// decoder does.
fn reproduces(
    mistakes: &[&Misreading],
    id: &str,
    suite: &Suite,
    run: &Run,
    decoder: &impl Fn(&Request) -> Answer,
) -> bool {
    let i = suite.cases.iter().position(|case| case.id == id);
    let i = i.expect("a listed case is in the suite");
    let Some(observation) = &run.observations[i] else {
        return true;
    };
    let (view, built) = (&observation.view, suite.cases[i].build(run.table));
    let answer = decoder(&Request::new(id, view, &built.file, 1 << 24));
    let dialect = CHOICES.apply(&run.judgment.dialect, Reading::SPEC);
    let mut readings = [Reading::SPEC, dialect].into_iter();
    readings.any(|reading| {
        let made = ptm_mistakes::answer(mistakes, reading, &built.file, view);
        is_reproduced_by(&answer, &made)
    })
}

/// Returns true if an answer of a decoder equals the answer that mistakes produce, up to the tolerance for the view. A refusal
/// reproduces any failure without an image.
fn is_reproduced_by(answer: &Answer, made: &Answer) -> bool {
    match (answer, made) {
        (Answer::Decoded(received), Answer::Decoded(made)) => {
            equal_up_to_rounding(received, made)
                || Expected::from_frame(made).compare(received).is_none()
        }
        (Answer::Decoded(_), _) | (_, Answer::Decoded(_)) => false,
        (_, Answer::Rejected | Answer::Unsupported) => true,
        _ => false,
    }
}

// Parts of decoders

/// Returns the file with other texts in the header fields with one of these clauses. `spell` returns the new text of a field, or
/// `None` to keep it.
fn respelled(file: &[u8], clauses: &[&str], spell: impl Fn(&str) -> Option<String>) -> Vec<u8> {
    let mut file = file.to_vec();
    loop {
        let (fields, _) = examine_as(&file, &Reading::SPEC);
        let mut fields = fields.into_iter();
        let change = fields.find_map(|field| {
            let old = std::str::from_utf8(&file[field.range.clone()]).ok()?;
            let new = spell(old).filter(|_| clauses.contains(&field.clause))?;
            (new != old).then_some((field.range, new))
        });
        let Some((range, text)) = change else {
            return file;
        };
        file.splice(range, text.into_bytes());
    }
}

/// Clauses of scales, biases and matrix elements.
const NUMBERS: &[&str] = &["2.4/3", "2.4/4", "2.6/2"];

/// Returns the texts of the header fields with one of these clauses.
fn field_texts(file: &[u8], clauses: &[&str]) -> Vec<String> {
    let (fields, _) = examine_as(file, &Reading::SPEC);
    let selected = fields
        .iter()
        .filter(|field| clauses.contains(&field.clause));
    selected
        .map(|field| String::from_utf8_lossy(&file[field.range.clone()]).into_owned())
        .collect()
}

/// Returns the answer of a decoder that makes its decisions as in `reading`.
fn answer_in(reading: Reading, request: &Request) -> Answer {
    ptm_mistakes::answer(&[], reading, request.file, request.view)
}

/// Decodes a file, changes the map, and renders it.
fn answer_with_map(file: &[u8], view: &View, change: impl Fn(&mut Ptm)) -> Answer {
    match decode_as(file, &Reading::SPEC, &Limits::default()) {
        Ok(mut ptm) => {
            change(&mut ptm);
            Answer::Decoded(Frame::render(&ptm, view))
        }
        Err(error) if error.class() == Class::Malformed => Answer::Rejected,
        Err(_) => Answer::Unsupported,
    }
}

/// Returns the correct answer, with other colors if the request is for colors.
fn answer_with_colors(request: &Request, change: impl Fn(&mut [u8])) -> Answer {
    let mut answer = reference_answer(request);
    if let Answer::Decoded(frame) = &mut answer
        && let (ViewKind::Rgb, Samples::U8(colors)) = (frame.view, &mut frame.samples)
    {
        change(colors);
    }
    answer
}

/// Returns the format of a file that can be decoded.
fn format_of(request: &Request) -> Option<Format> {
    let ptm = decode_as(request.file, &Reading::SPEC, &Limits::default());
    Some(ptm.ok()?.header.format)
}

/// Returns the size of the map in a correct image.
fn size_in(answer: &Answer) -> Option<(u32, u32)> {
    match answer {
        Answer::Decoded(frame) => Some((frame.width, frame.height)),
        _ => None,
    }
}

// Statements about acceptances

/// The decoder accepts any version, and leaves all colors 0 in files of other versions.
#[test]
fn an_acceptance_with_another_image_does_not_look_the_same() {
    let suite = cases(is_uncompressed);
    printed_report(&suite, |request| {
        let file = respelled(request.file, &["2.1/1"], |text| {
            text.starts_with("PTM_").then(|| "PTM_1.2".to_owned())
        });
        let is_other_version = file != request.file;
        answer_with_map(&file, request.view, |ptm| {
            if !is_other_version {
                return;
            }
            let channels = ptm.planes.shape.channels();
            let coefficients = ptm.planes.shape.coefficients();
            let kept = if coefficients == channels {
                0
            } else {
                coefficients
            };
            for texel in ptm.planes.samples.chunks_exact_mut(channels) {
                texel[kept..].fill(0);
            }
        })
    })
    .never_says("reads any version as 1.2")
    .never_says("reads every PTM_1.x version as 1.2")
    .says(&["accepts"])
    .has_at_most(2)
    .assert_true();
}

/// A decoder that reads all numbers as 0 shows the same image of a malformed file and of its legal twin, and the image of a decoder
/// that cuts the fractions of scales below 1.
#[test]
fn a_decoder_that_shows_only_zeros_does_not_show_how_it_reads_a_number() {
    let zero = Edit::parse("final coefficient", "0").expect("a formula");
    let zero = formula_misreading(vec![zero]);
    let mut reports = Vec::new();
    for (slug, fault) in [
        ("bias-fraction-cut", "a bias is 128.5"),
        ("scale-to-the-point", "scale"),
    ] {
        let misreading = misreading(slug);
        let report = printed_report(&cases(is_uncompressed), |request| {
            answer_with(&[misreading, &zero], request)
        });
        let report = report
            .says(&["computes final coefficient i of polynomial c as 0"])
            .says(&["accepts malformed files", fault])
            .never_says("the decoder drops the fractional part")
            .never_says("the decoder reads only the digits");
        reports.push(report);
    }
    assert_all_true(reports);
}

/// The colors of LUM are too large by one. In other formats, this would be within the tolerance of many cases, but not of all.
#[test]
fn an_edit_that_passing_colors_contradict_is_restricted() {
    printed_report(&cases(is_uncompressed), |request| {
        answer_with_colors(request, |colors| {
            if format_of(request) == Some(Format::Lum) {
                for color in colors {
                    *color = color.saturating_add(1);
                }
            }
        })
    })
    .says(&["min(max(value, 0) + 1, 255)", ", in files of format LUM"])
    .never_says("seen in files")
    .assert_true();
}

/// The decoder refuses every map with a table and more than one texel. Most of them use the last entry of the table, but those that
/// do not are refused, too.
#[test]
fn refusals_are_not_explained_by_what_does_not_separate_them() {
    printed_report(&cases(is_uncompressed), |request| {
        let answer = reference_answer(request);
        let has_table = request.file.windows(4).any(|bytes| bytes == b"_LUT");
        match &answer {
            Answer::Decoded(frame) if has_table && frame.width * frame.height > 1 => {
                Answer::Rejected
            }
            _ => answer,
        }
    })
    .says(&["refuses", "legal files of PTM_LUT, PTM_C_LUT"])
    .never_says(misreading("last-entry-refused").effect)
    .assert_true();
}

/// The decoder writes arrays of (channels, height, width), as many libraries for images and machine learning do.
#[test]
fn exchanged_axes_are_named() {
    printed_report(&cases(is_uncompressed), |request| {
        match reference_answer(request) {
            Answer::Decoded(frame) => Answer::Decoded(Frame {
                height: frame.channels,
                width: frame.height,
                channels: frame.width,
                ..frame
            }),
            answer => answer,
        }
    })
    .says(&["exchanges the axes of images: (channels, height, width) instead of (height, width, channels)"])
    .assert_true();
}

/// The decoder refuses near-lossless JPEG-LS streams.
#[test]
fn near_lossless_streams_are_a_property() {
    let is_jpeg_ls = |case: &Case| case.format().coding() == Some(Coding::JpegLs);
    printed_report(&cases(is_jpeg_ls), |request| {
        // NEAR is the second byte from the end of the scan header, after the marker, the length and one component.
        let mut scans = request
            .file
            .windows(8)
            .filter(|bytes| bytes[..5] == [0xFF, 0xDA, 0, 8, 1]);
        match scans.any(|scan| scan[7] > 0) {
            true => Answer::Rejected,
            false => reference_answer(request),
        }
    })
    .says(&["refuses every legal file", "near-lossless"])
    .assert_true();
}

/// Each decoder refuses the files with one property.
#[test]
fn properties_of_numbers_sizes_and_data_are_named() {
    fn numbers(file: &[u8]) -> Vec<&str> {
        let (fields, _) = ptm::decode::fields(file);
        let numbers = fields
            .into_iter()
            .filter(|field| ["2.4/3", "2.4/4", "2.6/2"].contains(&field.clause));
        let texts = numbers.map(|field| std::str::from_utf8(&file[field.range]));
        texts.filter_map(Result::ok).collect()
    }
    fn has_bare_exponent(number: &str) -> bool {
        let exponent = number.split_once(['e', 'E']);
        exponent.is_some_and(|(_, exponent)| !exponent.starts_with(['+', '-']))
    }
    fn has_exponent_without_point(number: &str) -> bool {
        number.contains(['e', 'E']) && !number.contains('.')
    }
    type Refuses = fn(&[u8], &Frame) -> bool;
    let decoders: [(&str, Refuses); 5] = [
        (
            "an exponent and no decimal point in one number",
            |file, _| numbers(file).into_iter().any(has_exponent_without_point),
        ),
        ("an exponent without a sign in a number", |file, _| {
            numbers(file).into_iter().any(has_bare_exponent)
        }),
        (
            "a decimal point and an exponent in one number",
            |file, _| {
                let mut numbers = numbers(file).into_iter();
                numbers.any(|number| number.contains('.') && number.contains(['e', 'E']))
            },
        ),
        ("a line feed at the end of the binary data", |file, _| {
            file.ends_with(b"\n")
        }),
        ("an odd number of texels", |_, frame| {
            frame.width * frame.height % 2 == 1
        }),
    ];
    let suite = cases(is_uncompressed);
    for (property, is_refused) in decoders {
        printed_report(&suite, |request| match reference_answer(request) {
            Answer::Decoded(frame) if is_refused(request.file, &frame) => Answer::Rejected,
            answer => answer,
        })
        .says(&["refuses every legal file with", property])
        .assert_true();
    }
}

#[test]
fn properties_of_planes_are_named() {
    type Refuses = fn(&Plan, &[u8]) -> bool;
    let decoders: [(&str, Refuses); 4] = [
        ("prediction from a plane of another color", |plan, _| {
            let mut steps = plan.steps.iter().enumerate();
            plan.steps.len() == 18
                && steps.any(|(i, step)| step.reference.is_some_and(|other| other / 6 != i / 6))
        }),
        (
            "side information for planes with inverted references",
            |plan, _| {
                let mut steps = plan.steps.iter().zip(&plan.extents);
                steps.any(|(step, extent)| {
                    step.reference.is_some() && step.inverted && !extent.side.is_empty()
                })
            },
        ),
        (
            "a transform other than 0 for an intra-coded plane",
            |plan, _| {
                let mut intra = plan.steps.iter().filter(|step| step.reference.is_none());
                intra.any(|step| step.inverted || step.displaced)
            },
        ),
        (
            "an order other than 0 for an intra-coded plane",
            |plan, file| {
                let ranks = field_texts(file, &["2.9.4/1"]);
                let mut ranks = plan.steps.iter().zip(ranks);
                ranks.any(|(step, rank)| step.reference.is_none() && rank != "0")
            },
        ),
    ];
    let suite = cases(is_compressed);
    for (property, is_refused) in decoders {
        printed_report(&suite, |request| {
            match (reference_answer(request), plan_of(request.file)) {
                (Answer::Decoded(_), Some(plan)) if is_refused(&plan, request.file) => {
                    Answer::Rejected
                }
                (answer, _) => answer,
            }
        })
        .says(&["refuses every ", property])
        .assert_true();
    }
}

/// The decoder refuses JPEG-LS files whose parameter is 60, and reads one whose parameter is 300.
#[test]
fn a_parameter_that_no_legal_file_has_refutes_a_limit_of_the_loss() {
    let is_jpeg_ls = |case: &Case| case.format().coding() == Some(Coding::JpegLs);
    printed_report(&cases(is_jpeg_ls), |request| {
        let (fields, _) = ptm::decode::fields(request.file);
        let mut parameters = fields.into_iter().filter(|field| field.clause == "2.9.1/1");
        let parameter = parameters.next().map(|field| &request.file[field.range]);
        match parameter {
            Some(b"60") => Answer::Rejected,
            _ => reference_answer(request),
        }
    })
    .says(&["refuses"])
    .never_says("maximum loss is at least 60")
    .assert_true();
}

/// The decoder refuses lights whose u is negative, and does not support colors of one format.
#[test]
fn unsupported_files_of_another_format_make_a_property_one_of_judged_files() {
    let answer = |request: &Request| match (reference_answer(request), request.view) {
        (Answer::Decoded(_), View::Rgb(_)) if format_of(request) == Some(Format::Lum) => {
            Answer::Unsupported
        }
        (Answer::Decoded(_), View::Rgb(light)) if light.lu < 0.0 => Answer::Rejected,
        (answer, _) => answer,
    };
    printed_report(&cases(is_uncompressed), answer)
        .says(&["refuses every judged legal file requested under a light whose u is negative"])
        .assert_true();
}

/// The decoder takes missing bytes as 255.
#[test]
fn padding_with_another_byte_does_not_look_the_same() {
    let has_plain_texels =
        |case: &Case| matches!(case.format(), Format::Rgb | Format::Lrgb | Format::Lum);
    let mut reports = Vec::new();
    for suite in [
        cases(|_| true),
        cases(is_uncompressed),
        only(has_plain_texels),
    ] {
        let report = printed_report(&suite, |request| match reference_answer(request) {
            Answer::Rejected => {
                let padding = vec![255; request.file.len() + 4096];
                let padded = [request.file, &padding].concat();
                ptm_mistakes::answer(&[], Reading::SPEC, &padded, request.view)
            }
            answer => answer,
        })
        .never_says("as zeros")
        .never_says("substitutes zeros")
        .says(&["accepts"]);
        reports.push(report);
    }
    assert_all_true(reports);
}

/// Reads positions low byte first. Ignores records outside the plane.
fn little_endian_records(block: &[u8], at: usize, texels: usize) -> ptm::Result<Vec<Record>> {
    let all = checked_little_endian_records(block, at, usize::MAX)?;
    let records = all.into_iter();
    Ok(records
        .filter(|&(position, _)| (position as usize) < texels)
        .collect())
}

/// Reads positions low byte first. Refuses records outside the plane.
fn checked_little_endian_records(
    block: &[u8],
    at: usize,
    texels: usize,
) -> ptm::Result<Vec<Record>> {
    let swap = |record: &[u8]| [record[3], record[2], record[1], record[0], record[4]];
    let mut swapped: Vec<u8> = block.chunks_exact(5).flat_map(swap).collect();
    swapped.extend_from_slice(block.chunks_exact(5).remainder());
    planes::parse_records(&swapped, at, texels)
}

#[test]
fn another_order_of_position_bytes_does_not_look_the_same() {
    let suite = cases(is_compressed);
    let mut reports = Vec::new();
    let decoders: [(fn(&[u8], usize, usize) -> ptm::Result<Vec<Record>>, &str); 2] = [
        (little_endian_records, "reads positions low byte first"),
        (
            checked_little_endian_records,
            "every legal file with a record whose position is at least 1",
        ),
    ];
    for (records, words) in decoders {
        let reading = Reading {
            records,
            ..Reading::SPEC
        };
        let report = printed_report(&suite, |request| answer_in(reading, request))
            .never_says("two 16-bit words")
            .says(&[words]);
        reports.push(report);
    }
    assert_all_true(reports);
}

/// Spelling of a number that stands for a value that is not a number.
const UNKNOWN_SCALE: &str = "1e77";
const UNKNOWN_BIAS: &str = "1000000000000077";

/// The decoder takes any word that is not a number as NaN, as `parseFloat` without a check does.
#[test]
fn one_number_parser_is_one_cause_without_a_mechanism() {
    let suite = cases(is_uncompressed);
    let is_known = |text: &str| {
        let is_decimal = |byte: u8| byte.is_ascii_digit() || b"+-.eE".contains(&byte);
        text.bytes().all(is_decimal) && text.parse::<f64>().is_ok_and(f64::is_finite)
    };
    printed_report(&suite, |request| {
        let unknown = |text: &str, stand_in: &str| (!is_known(text)).then(|| stand_in.to_owned());
        let file = respelled(request.file, &["2.4/3", "2.6/2"], |text| {
            unknown(text, UNKNOWN_SCALE)
        });
        let file = respelled(&file, &["2.4/4"], |text| unknown(text, UNKNOWN_BIAS));
        let file = respelled(&file, &["2.4/3", "2.6/2"], |text| {
            unknown(text, UNKNOWN_SCALE)
        });
        answer_with_map(&file, request.view, |ptm| {
            let ScaleBias { scale, bias } = &mut ptm.header.scale_bias;
            let mut values: Vec<&mut f64> = scale.iter_mut().chain(bias).collect();
            if let Shape::Lum(matrix) = &mut ptm.planes.shape {
                values.extend(&mut matrix.0);
            }
            for value in values {
                if [1e77, 1_000_000_000_000_077.0].contains(value) {
                    *value = f64::NAN;
                }
            }
        })
    })
    .never_says("as strtod does")
    .never_says("accepts inf and infinity as numbers")
    .says(&["accepts"])
    .has_at_most(2)
    .assert_true();
}

/// The decoder reads any first line as that of version 1.2.
#[test]
fn a_part_of_the_acceptances_of_a_missing_check_is_no_misreading() {
    let suite = cases(is_uncompressed);
    printed_report(&suite, |request| {
        let file = respelled(request.file, &["2.1/1"], |_| Some("PTM_1.2".to_owned()));
        answer_with(&[], &Request::new("", request.view, &file, 1 << 24))
    })
    .never_says("anywhere in the first line")
    .has_at_most(2)
    .assert_true();
}

// Statements about arithmetic

fn rounded(value: f64) -> f64 {
    value.round()
}

fn color_shifted_by_eight(luminance: f64, color: f64) -> f64 {
    (luminance * color / 256.0).floor()
}

/// The decoder rounds the luminance to an integer, and shifts its product with the color by eight bits.
#[test]
fn a_formula_is_not_fitted_to_the_rest_of_another_cause() {
    let suite = cases(is_uncompressed);
    let reading = Reading {
        luminance: rounded,
        modulate: color_shifted_by_eight,
        ..Reading::SPEC
    };
    printed_report(&suite, |request| answer_in(reading, request))
        .never_says("+ 0.5")
        .never_says("in files of PTM_LUT, PTM_C_LUT")
        .never_says("in files of format PTM_LUT, PTM_C_LUT")
        .says(&["256"])
        .assert_true();
}

fn mean_rounded_to_odd(samples: [u8; 4]) -> u8 {
    let sum: u16 = samples.into_iter().map(u16::from).sum();
    let (mean, rest) = (sum >> 2, sum & 3);
    (mean + u16::from(rest == 3 || rest == 2 && mean % 2 == 0)) as u8
}

fn mean_rounded_down_twice([a, b, c, d]: [u8; 4]) -> u8 {
    let mean = |a: u8, b: u8| u8::midpoint(a, b);
    mean(mean(a, b), mean(c, d))
}

fn mean_rounded_up_along_y_first([a, b, c, d]: [u8; 4]) -> u8 {
    predict::mean_rounded_up_twice([a, c, b, d])
}

fn mean_rounded_down_and_up([a, b, c, d]: [u8; 4]) -> u8 {
    let [a, b, c, d] = [a, b, c, d].map(u16::from);
    ((((a + b) >> 1) + ((c + d) >> 1) + 1) >> 1) as u8
}

fn mean_rounded_up_and_down([a, b, c, d]: [u8; 4]) -> u8 {
    let [a, b, c, d] = [a, b, c, d].map(u16::from);
    ((((a + b + 1) >> 1) + ((c + d + 1) >> 1)) >> 1) as u8
}

/// The decoder follows one rounding of half-texel means, but none of the listed ones.
#[test]
fn a_rounding_that_is_not_listed_is_not_called_inconsistent() {
    let suite = cases(is_compressed);
    let mut reports = Vec::new();
    for motion_half in [
        mean_rounded_to_odd,
        mean_rounded_down_twice,
        mean_rounded_up_along_y_first,
        mean_rounded_down_and_up,
        mean_rounded_up_and_down,
    ] {
        let reading = Reading {
            motion_half,
            ..Reading::SPEC
        };
        let report = printed_report(&suite, |request| answer_in(reading, request))
            .never_says("a different reading of an open question than in its other images")
            .never_says("follow one reading of the question in all files")
            .says(&["predicted planes"]);
        reports.push(report);
    }
    assert_all_true(reports);
}

/// The message about a failure is printed as well.
#[test]
fn a_rounding_that_is_not_listed_does_not_mix_readings() {
    let suite = cases(is_compressed);
    let reading = Reading {
        motion_half: mean_rounded_to_odd,
        ..Reading::SPEC
    };
    let mut report = printed_report(&suite, |request| answer_in(reading, request));
    for cause in &report.causes {
        if cause.failures.contains("mixes readings") {
            let why = format!("the decoder mixes no readings:{}", cause.failures);
            report.problems.push(why);
        }
    }
    report.assert_true();
}

/// Rounds to the eleven significant bits of a half-precision float.
fn half(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let step = f64::powf(2.0, value.abs().log2().floor().max(-14.0) - 10.0);
    (value / step).round_ties_even() * step
}

fn half_final_coefficient(raw: u8, channel: usize, set: &ScaleBias) -> f64 {
    half(half(evaluate::final_coefficient(raw, channel, set)))
}

fn half_polynomial(a: &[f64], u: f64, v: f64) -> f64 {
    let (u, v) = (half(u), half(v));
    let powers = [half(u * u), half(v * v), half(u * v), u, v, 1.0];
    let add = |sum: f64, (a, power): (&f64, f64)| half(sum + half(half(*a) * power));
    a.iter().zip(powers).fold(0.0, add)
}

fn half_modulate(luminance: f64, color: f64) -> f64 {
    half(half(luminance / 255.0) * half(color))
}

fn truncated_color(value: f64) -> f64 {
    half(value).clamp(0.0, 255.0).floor()
}

/// The decoder computes colors with half-precision floats and truncates them. It has no other view.
#[test]
fn low_precision_is_not_a_formula() {
    let suite = cases(is_uncompressed);
    let reading = Reading {
        final_coefficient: half_final_coefficient,
        polynomial: half_polynomial,
        modulate: half_modulate,
        clamp: truncated_color,
        ..Reading::SPEC
    };
    printed_report(&suite, |request| match request.view {
        View::Rgb(_) => answer_in(reading, request),
        _ => Answer::Unsupported,
    })
    .never_says("computes a color as")
    .never_says("truncate(")
    .never_says("255 / 256")
    .never_says("by 256")
    .assert_true();
}

/// Moves two samples of a JPEG plane of more than 50 samples: one within the tolerance, and one beyond it.
fn stream_with_two_moved_samples(stream: &PlaneStream) -> ptm::Result<Vec<u8>> {
    let mut samples = planes::decode_stream(stream)?;
    if stream.coding == Coding::Jpeg && samples.len() > 50 {
        for (i, step) in [(2, 1), (45, 3)] {
            let sample = &mut samples[i];
            *sample = if *sample < 128 {
                *sample + step
            } else {
                *sample - step
            };
        }
    }
    Ok(samples)
}

/// Returns the received and the expected value in an example.
fn example_values(sentences: &str) -> Option<(f64, f64)> {
    let (_, values) = sentences.split_once("received ")?;
    let (received, rest) = values.split_once(", expected ")?;
    let end = rest.find(|c: char| !c.is_ascii_digit() && !"−-.".contains(c));
    let expected = &rest[..end.unwrap_or(rest.len())];
    Some((
        received.parse().ok()?,
        expected.trim_end_matches('.').parse().ok()?,
    ))
}

/// Returns true if correct inverse DCTs may differ by one in every sample of the file.
fn has_tolerance(case: &Case) -> bool {
    let values = &case.build(TableSpelling::default()).values;
    let expected = Expected::new(values, &View::Raw);
    expected.is_some_and(|expected| {
        !expected.slack.is_empty() && expected.slack.iter().all(|&slack| slack >= 1.0)
    })
}

#[test]
fn the_sample_of_an_example_is_wrong_beyond_the_tolerance() {
    let suite = cases(|case| case.format().coding() == Some(Coding::Jpeg) && has_tolerance(case));
    let reading = Reading {
        stream: stream_with_two_moved_samples,
        ..Reading::SPEC
    };
    let mut report = printed_report(&suite, |request| answer_in(reading, request));
    for cause in &report.causes {
        let is_within = |(received, expected): (f64, f64)| (received - expected).abs() <= 1.0;
        let is_raw = cause.failures.contains("\n    raw: ");
        if is_raw && example_values(&cause.sentences).is_some_and(is_within) {
            report.problems.push(format!(
                "the difference in the example is allowed: {}",
                cause.sentences
            ));
        }
    }
    report.assert_true();
}

/// The example is about the first failure that is printed below it.
#[test]
fn an_example_is_a_failure_that_is_printed() {
    let suite = cases(|case| case.format().coding() == Some(Coding::Jpeg));
    let reading = Reading {
        stream: stream_with_two_moved_samples,
        ..Reading::SPEC
    };
    let mut report = printed_report(&suite, |request| answer_in(reading, request));
    for cause in &report.causes {
        let first = cause.failures.split_whitespace().nth(1).unwrap_or_default();
        let example = cause.cause.example.as_deref();
        if example.is_some_and(|example| !example.starts_with(&format!("for example {first}"))) {
            report.problems.push(format!(
                "the failure {first} is printed below {}",
                cause.sentences
            ));
        }
    }
    report.assert_true();
}

// The number of causes

/// The decoder truncates final coefficients, and clamps the sums of residuals and references.
#[test]
fn a_second_mistake_is_a_cause_of_its_own() {
    let suite = cases(|_| true);
    let mistakes = ["coefficient-truncated", "clamp-not-wrap"].map(misreading);
    let mut reports = Vec::new();
    for views in [&ViewKind::ALL[..], &[ViewKind::Rgb], &[ViewKind::Coef]] {
        let report = printed_report(&suite, |request| {
            match views.contains(&request.view.kind()) {
                true => answer_with(&mistakes, request),
                false => Answer::Unsupported,
            }
        });
        let second = "clamps sums to 0…255";
        let is_second = |one: &PrintedCause| {
            one.cause.misreading.as_deref() == Some("clamp-not-wrap")
                || one.cause.effect.contains(second)
                || one.cause.effect.contains("predicted planes")
        };
        let is_named = report.causes.iter().any(is_second);
        let mut report = report.says(&["truncates final coefficients"]);
        if !is_named {
            report.problems.push(format!("no cause \"{second}\""));
        }
        reports.push(report);
    }
    assert_all_true(reports);
}

thread_local! {
    /// The sums of residuals and references of the map that was decoded last, without modular arithmetic.
    static SUMS: RefCell<Vec<Vec<f64>>> = const { RefCell::new(Vec::new()) };
}

/// Keeps the sums of residuals and predictors in addition to the planes.
fn reconstruct_and_keep_sums(
    coded: &Coded,
    residuals: Vec<Vec<u8>>,
    reading: &Reading,
) -> ptm::Result<Vec<Vec<u8>>> {
    let streams = residuals.clone();
    let planes = planes::reconstruct(coded, residuals, reading)?;
    let mut sums = vec![Vec::new(); planes.len()];
    for (&i, residual) in coded.plan.sequence.iter().zip(&streams) {
        let step = &coded.plan.steps[i];
        sums[i] = planes[i].iter().copied().map(f64::from).collect();
        let Some(reference) = step.reference else {
            continue;
        };
        let predictor = (reading.predictor)(&planes[reference], step, coded.size, reading);
        for (t, sum) in sums[i].iter_mut().enumerate() {
            let exact = f64::from(residual[t]) + f64::from(predictor[t]) - 128.0;
            // Corrected texels keep their values.
            if (exact - *sum) % 256.0 == 0.0 {
                *sum = exact;
            }
        }
    }
    SUMS.set(sums);
    Ok(planes)
}

/// Computes final coefficients from the sums, and truncates them.
fn truncated_finals_of_sums(set: &ScaleBias, planes: &Planes, _: &Reading) -> Vec<f64> {
    let Size { width, height } = planes.size;
    let coefficients = planes.shape.coefficients();
    let sums = SUMS.take();
    let mut finals = Vec::new();
    for (t, texel) in planes.texels().enumerate() {
        let (x, y) = (t % width as usize, t / width as usize);
        let stored = (height as usize - 1 - y) * width as usize + x;
        for (channel, &raw) in texel.iter().enumerate() {
            let raw = sums
                .get(channel)
                .map_or(f64::from(raw), |plane| plane[stored]);
            finals.push(match channel < coefficients {
                true => ((raw - set.bias[channel % 6]) * set.scale[channel % 6]).trunc(),
                false => raw,
            });
        }
    }
    finals
}

/// The decoder truncates final coefficients, and does not wrap the sums of residuals and references.
#[test]
fn a_second_mistake_without_a_name_is_a_cause_of_its_own() {
    let suite = cases(|_| true);
    let reading = Reading {
        reconstruct: reconstruct_and_keep_sums,
        finals: truncated_finals_of_sums,
        ..Reading::SPEC
    };
    let mut reports = Vec::new();
    for views in [&[ViewKind::Rgb][..], &[ViewKind::Coef, ViewKind::Rgb]] {
        let report = printed_report(&suite, |request| {
            SUMS.take();
            match views.contains(&request.view.kind()) {
                true => answer_in(reading, request),
                false => Answer::Unsupported,
            }
        })
        .says(&["truncates final coefficients"])
        .says(&["predicted planes"]);
        reports.push(report);
    }
    assert_all_true(reports);
}

/// Two mistakes, each of which shows in every case that can show it.
#[test]
fn a_mistake_that_always_shows_does_not_show_in_some_cases() {
    let pairs = [
        ["coefficient-truncated", "side-rows-turned"],
        ["clamp-not-wrap", "side-rows-turned"],
    ];
    let suite = cases(|_| true);
    let mut reports = Vec::new();
    for pair in pairs {
        let mistakes = pair.map(misreading);
        println!("{pair:?}");
        let report = printed_report(&suite, |request| answer_with(&mistakes, request))
            .never_says("In some of these cases")
            .says(&[mistakes[0].effect])
            .says(&[mistakes[1].effect])
            .has_causes(2);
        reports.push(report);
    }
    assert_all_true(reports);
}

/// The decoder cannot read exponents. It hangs, crashes or refuses the file.
#[test]
fn one_mistake_with_three_symptoms_is_one_cause() {
    let suite = cases(is_uncompressed);
    printed_report(&suite, |request| {
        let numbers = field_texts(request.file, NUMBERS).join(" ");
        match reference_answer(request) {
            Answer::Decoded(_) if numbers.contains('E') => Answer::Rejected,
            Answer::Decoded(_) if numbers.contains("e-") => {
                Answer::Crashed("killed by signal 11".to_owned())
            }
            Answer::Decoded(_) if numbers.contains('e') => {
                Answer::TimedOut(TimeLimit(Duration::from_secs(10)))
            }
            answer => answer,
        }
    })
    .never_says("the cause is unknown")
    .says(&["with a number in scientific notation"])
    .has_causes(1)
    .assert_true();
}

/// Reads the rows of a decoded map as if their lengths were padded to multiples of eight texels.
fn with_row_stride(ptm: &mut Ptm) {
    let Planes {
        size: Size { width, .. },
        shape,
        ref mut samples,
    } = ptm.planes;
    let (row, channels) = (width as usize * shape.channels(), shape.channels());
    let stride = (width as usize).next_multiple_of(8) * channels;
    let old = samples.clone();
    for (y, new) in samples.chunks_exact_mut(row).enumerate() {
        for (x, sample) in new.iter_mut().enumerate() {
            *sample = old.get(y * stride + x).copied().unwrap_or_default();
        }
    }
}

#[test]
fn one_row_stride_in_all_formats_is_one_cause() {
    let suite = cases(|_| true);
    printed_report(&suite, |request| {
        answer_with_map(request.file, request.view, with_row_stride)
    })
    .has_causes(1)
    .assert_true();
}

/// The decoder shows the top row twice, instead of the second one.
#[test]
fn one_mistake_in_all_formats_is_one_cause() {
    let suite = cases(|_| true);
    printed_report(&suite, |request| {
        answer_with_map(request.file, request.view, |ptm| {
            let row = ptm.planes.size.width as usize * ptm.planes.shape.channels();
            if ptm.planes.size.height > 1 {
                ptm.planes.samples.copy_within(..row, row);
            }
        })
    })
    .has_causes(1)
    .assert_true();
}

/// Returns true if a JPEG stream in the file has one component with the sampling factors 3×2.
fn has_sampling_factors(file: &[u8]) -> bool {
    // SOF0 or SOF1, length 11, precision 8, height, width, one component, its id, and its sampling factors.
    file.windows(12).any(|bytes| {
        matches!(bytes[..5], [0xff, 0xc0 | 0xc1, 0, 11, 8]) && bytes[9] == 1 && bytes[11] == 0x32
    })
}

/// The decoder refuses the sampling factors 3×2, and sides above 16,384. Its messages differ.
#[test]
fn refusals_with_different_messages_are_different_causes() {
    let decoder = |request: &Request| {
        let refusal = |message: &str| Reply {
            stderr: format!("{message}\n"),
            ..Answer::Rejected.into()
        };
        let answer = reference_answer(request);
        let side = size_in(&answer).map_or(0, |(width, height)| width.max(height));
        match answer {
            Answer::Decoded(_) if has_sampling_factors(request.file) => {
                refusal("error: unsupported sampling factors")
            }
            Answer::Decoded(_) if side > 16_384 => refusal("error: image is too large"),
            answer => answer.into(),
        }
    };
    // In the second suite, only one map is so large.
    let mut suites = [
        cases(|_| true),
        cases(|case| case.format().coding() == Some(Coding::Jpeg)),
    ];
    let large = cases(|_| true)
        .cases
        .into_iter()
        .find(|case| case.id.contains("20000x1"));
    suites[1]
        .cases
        .push(large.expect("a case with a large side"));
    assert_all_true(suites.map(|suite| {
        printed_report(&suite, decoder)
            .says(&["sampling factors"])
            .says(&["image is too large"])
            .has_causes(2)
    }));
}

#[test]
fn a_refusal_of_maps_of_one_row_cites_no_clause_that_the_files_do_not_test() {
    let suite = cases(is_uncompressed);
    printed_report(&suite, |request| match reference_answer(request) {
        answer @ Answer::Decoded(_) if size_in(&answer).is_some_and(|(_, height)| height == 1) => {
            Answer::Rejected
        }
        answer => answer,
    })
    .never_says("(clause 2.0/1)")
    .cites_tested_clauses_only(&suite)
    .says(&["of one row"])
    .assert_true();
}

/// The decoder refuses files of fewer than 100 bytes.
#[test]
fn a_refusal_of_short_files_cites_no_clause_that_the_files_do_not_test() {
    let suite = cases(is_uncompressed);
    printed_report(&suite, |request| match reference_answer(request) {
        Answer::Decoded(_) if request.file.len() < 100 => Answer::Rejected,
        answer => answer,
    })
    .never_says("(clause 2.3/1)")
    .cites_tested_clauses_only(&suite)
    .says(&["bytes"])
    .assert_true();
}

/// The decoder reads numbers with `atoi`, so scales below 1 are 0.
#[test]
fn black_images_belong_to_the_mistake_that_makes_them_black() {
    let suite = cases(|case| matches!(case.format(), Format::Rgb | Format::Lrgb | Format::Lum));
    let integer = |text: &str| {
        let digits = text.trim_start_matches(['+', '-']);
        let end = digits.find(|c: char| !c.is_ascii_digit());
        let sign = if text.starts_with('-') { "-" } else { "" };
        match &digits[..end.unwrap_or(digits.len())] {
            "" => "0".to_owned(),
            digits => format!("{sign}{digits}"),
        }
    };
    let mut reports = Vec::new();
    for (views, numbers) in [
        (&ViewKind::ALL[..], NUMBERS),
        (&[ViewKind::Rgb], &["2.4/3"]),
    ] {
        let report = printed_report(&suite, |request| match reference_answer(request) {
            Answer::Decoded(_) if !views.contains(&request.view.kind()) => Answer::Unsupported,
            Answer::Decoded(_) => {
                let file = respelled(request.file, numbers, |text| Some(integer(text)));
                ptm_mistakes::answer(&[], Reading::SPEC, &file, request.view)
            }
            answer => answer,
        })
        .never_says("in every sample")
        .has_causes(1);
        reports.push(report);
    }
    assert_all_true(reports);
}

// Vague words

fn has_table(file: &[u8]) -> bool {
    file.windows(3).take(40).any(|word| word == b"LUT")
}

/// Returns the frame with a fourth channel of 255.
fn with_alpha(mut frame: Frame) -> Frame {
    if let Samples::U8(samples) = &frame.samples {
        let texels = samples.chunks_exact(3);
        let rgba = texels.flat_map(|rgb| [rgb[0], rgb[1], rgb[2], 255]);
        (frame.channels, frame.samples) = (4, Samples::U8(rgba.collect()));
    }
    frame
}

#[test]
fn the_number_of_channels_is_named() {
    let suite = cases(is_uncompressed);
    printed_report(&suite, |request| match reference_answer(request) {
        Answer::Decoded(frame) if has_table(request.file) && frame.view == ViewKind::Rgb => {
            Answer::Decoded(with_alpha(frame))
        }
        answer => answer,
    })
    .never_says("or a different sample type")
    .says(&["4 channels"])
    .assert_true();
}

#[test]
fn the_sample_type_is_named() {
    let suite = cases(is_uncompressed);
    printed_report(&suite, |request| match reference_answer(request) {
        Answer::Decoded(mut frame) if has_table(request.file) && frame.view == ViewKind::Coef => {
            if let Samples::F32(values) = &frame.samples {
                let bytes = values.iter().map(|&value| value.round() as u8);
                frame.samples = Samples::U8(bytes.collect());
            }
            Answer::Decoded(frame)
        }
        answer => answer,
    })
    .never_says("a different number of channels")
    .says(&["u8", "f32"])
    .assert_true();
}

#[test]
fn a_malformed_frame_is_described_by_what_was_written() {
    let suite = cases(is_uncompressed);
    printed_report(&suite, |request| match reference_answer(request) {
        Answer::Decoded(frame) if has_table(request.file) => {
            let line = format!("PTM1 {} {} {}\n", frame.view, frame.width, frame.height);
            let error = Frame::read(line.as_bytes()).expect_err("the line is too short");
            Answer::ProtocolError(error.to_string())
        }
        answer => answer,
    })
    .never_says("(… is not …)")
    .never_says("… is not")
    .says(&["PTM1 VIEW WIDTH HEIGHT CHANNELS TYPE"])
    .assert_true();
}

#[test]
fn too_much_output_is_described_in_words() {
    let suite = cases(is_uncompressed);
    printed_report(&suite, |request| match reference_answer(request) {
        Answer::Decoded(_) if has_table(request.file) => {
            let limit = request.max_answer_bytes();
            Answer::Flooded(format!("{} bytes exceed the limit of {limit}", limit + 1))
        }
        answer => answer,
    })
    .never_says("fails (flood)")
    .says(&["output"])
    .assert_true();
}

#[test]
fn a_decoder_that_refuses_every_file_is_not_said_to_be_silent() {
    let suite = cases(|_| false);
    let report = printed_report(&suite, |_| Answer::Rejected);
    println!("{}", report.text);
    assert!(!report.text.contains("no output"), "{}", report.text);
    assert!(report.text.contains("refuses"), "{}", report.text);
    report.assert_true();
}

// The object of a statement

/// Reads coefficients and colors as signed bytes.
fn signed_finals(set: &ScaleBias, planes: &Planes, _: &Reading) -> Vec<f64> {
    let coefficients = planes.shape.coefficients();
    let final_values = |texel: &[u8]| -> Vec<f64> {
        let channels = texel.iter().enumerate();
        let value = |(channel, &raw): (usize, &u8)| match f64::from(raw.cast_signed()) {
            raw if channel < coefficients => (raw - set.bias[channel % 6]) * set.scale[channel % 6],
            raw => raw,
        };
        channels.map(value).collect()
    };
    planes.texels().flat_map(final_values).collect()
}

#[test]
fn a_statement_about_colors_shows_a_color() {
    let suite = cases(is_uncompressed);
    let reading = Reading {
        finals: signed_finals,
        ..Reading::SPEC
    };
    let mut reports = Vec::new();
    for views in [&ViewKind::ALL[..], &[ViewKind::Coef], &[ViewKind::Rgb]] {
        let mut report = printed_report(&suite, |request| {
            match views.contains(&request.view.kind()) {
                true => answer_in(reading, request),
                false => Answer::Unsupported,
            }
        });
        for cause in &report.causes {
            let example = cause.cause.example.as_deref().unwrap_or_default();
            let is_about_colors = cause.sentences.contains("final R, G, B, Cr or Cb");
            let coefficients = (0..6).map(|i| format!(", a{i}: received"));
            if is_about_colors && coefficients.into_iter().any(|name| example.contains(&name)) {
                report.problems.push(format!(
                    "the example shows a coefficient: {}",
                    cause.sentences
                ));
            }
        }
        reports.push(report);
    }
    assert_all_true(reports);
}

// Mistakes of output, and of one channel

/// Returns the reference's answer with its final values changed by `change`, in the channels of one texel.
///
/// `change` gets the map, the channel, the stored value and the final value.
fn with_final_values(request: &Request, change: impl Fn(&Ptm, usize, u8, &mut f64)) -> Answer {
    let Ok(ptm) = decode_as(request.file, &Reading::SPEC, &Limits::default()) else {
        return reference_answer(request);
    };
    if request.view.kind() == ViewKind::Raw {
        return reference_answer(request);
    }
    let mut coefficients =
        evaluate::compute_coefficients(&ptm.header.scale_bias, &ptm.planes, &Reading::SPEC);
    let channels = ptm.planes.shape.channels();
    let values = coefficients.values.iter_mut().zip(&ptm.planes.samples);
    for (i, (value, &stored)) in values.enumerate() {
        change(&ptm, i % channels, stored, value);
    }
    let samples = match request.view {
        View::Rgb(light) => {
            let image = evaluate::evaluate(&coefficients, light.lu, light.lv, &Reading::SPEC);
            image.values
        }
        _ => coefficients.values,
    };
    let samples = request.view.kind().samples(&samples);
    Answer::Decoded(Frame::of_map(&ptm, request.view, samples))
}

#[test]
fn values_that_only_the_frame_has_wrong_are_said_to_be_written_wrong() {
    let suite = cases(is_uncompressed);
    let with_values = |request: &Request, change: fn(f32) -> f32| match reference_answer(request) {
        Answer::Decoded(mut frame) if request.view.kind() == ViewKind::Coef => {
            if let Samples::F32(values) = &mut frame.samples {
                for value in values.iter_mut() {
                    *value = change(*value);
                }
            }
            Answer::Decoded(frame)
        }
        answer => answer,
    };
    let without_third_byte: fn(f32) -> f32 = |value| f32::from_bits(value.to_bits() & 0xff00_ffff);
    let report = printed_report(&suite, |request| with_values(request, without_third_byte));
    let report = report
        .says(&["although all colors under a light in the formats of these files are correct"]);
    let nan = printed_report(&suite, |request| with_values(request, |_| f32::NAN));
    assert_all_true([
        report.has_causes(1),
        nan.has_causes(1).says(&["shows NaN in every sample of"]),
    ]);
}

/// If only colors are wrong in another format, a second mistake may be the reason in this one, too.
#[test]
fn colors_do_not_follow_from_stored_values_if_only_colors_are_wrong_in_another_format() {
    let suite = cases(is_uncompressed);
    let change_each = |samples: &mut [u8], first: usize, change: fn(u8) -> u8| {
        let changed = samples.iter_mut().skip(first).step_by(5);
        changed.for_each(|sample| *sample = change(*sample));
    };
    let decoder = |request: &Request| {
        let mut answer = reference_answer(request);
        if let Answer::Decoded(frame) = &mut answer
            && let Samples::U8(samples) = &mut frame.samples
        {
            match (frame.view, frame.channels) {
                (ViewKind::Raw, 18) => change_each(samples, 3, |value| value ^ 0x55),
                (ViewKind::Rgb, _) => change_each(samples, 2, |value| value / 2),
                _ => {}
            }
        }
        answer
    };
    let report = printed_report(&suite, decoder)
        .says(&["shows wrong stored values"])
        .says(&["shows wrong colors"])
        .never_says(" in view rgb)");
    assert_all_true([report]);
}

#[test]
fn one_unscaled_channel_and_one_scaled_color_are_named() {
    let suite = cases(is_uncompressed);
    let unscaled = |request: &Request| {
        with_final_values(request, |_, channel, stored, value| {
            if channel == 17 {
                *value = f64::from(stored);
            }
        })
    };
    let scaled = |request: &Request| {
        with_final_values(request, |ptm, channel, _, value| {
            let set = &ptm.header.scale_bias;
            if channel == 6 && ptm.planes.shape.channels() == 9 {
                *value = (*value - set.bias[0]) * set.scale[0];
            }
        })
    };
    assert_all_true([
        printed_report(&suite, unscaled)
            .says(&["as raw instead of (raw - bias[i]) * scale[i], only in a5 of blue"])
            .has_causes(1),
        printed_report(&suite, scaled)
            .says(&["as ((raw - bias[i]) * scale[i] if i <= 0, else raw) instead of raw"])
            .has_causes(1),
    ]);
}

#[test]
fn coefficients_of_another_color_are_named() {
    let suite = cases(|case| case.format().channels() == 18 && is_uncompressed(case));
    let decoder = |request: &Request| {
        let View::Rgb(light) = request.view else {
            return reference_answer(request);
        };
        let Answer::Decoded(mut frame) = reference_answer(request) else {
            return reference_answer(request);
        };
        let ptm = decode_as(request.file, &Reading::SPEC, &Limits::default());
        let ptm = ptm.expect("the reference reads the file");
        let set = &ptm.header.scale_bias;
        let values = evaluate::compute_coefficients(set, &ptm.planes, &Reading::SPEC).values;
        let green = values.chunks_exact(18).map(|texel| {
            let value = (Reading::SPEC.polynomial)(&texel[5..11], light.lu, light.lv);
            (Reading::SPEC.clamp)(value)
        });
        if let Samples::U8(samples) = &mut frame.samples {
            for (texel, green) in samples.chunks_exact_mut(3).zip(green) {
                texel[1] = (green + 0.5) as u8;
            }
        }
        Answer::Decoded(frame)
    };
    printed_report(&suite, decoder)
        .says(&["the channel of coefficient i of a color as c * 5 + i"])
        .says(&["only in green"])
        .assert_true();
}

// Statements about open questions

/// In some lossless files, only intra-coded planes have records, so skipping these looks like skipping the records of lossless
/// files. A decoder whose motion runs over the ends of rows follows no reading of the border, and one that ignores motion follows
/// neither direction of it. A decoder that reads Cr and Cb as signed bytes does not use them as stored.
#[test]
fn a_reading_that_a_named_mistake_imitates_is_not_listed() {
    let compressed = cases(is_compressed);
    let lum = cases(|case| case.format() == Format::Lum);
    for (suite, slug, ruling) in [
        (
            &compressed,
            "side-information-of-intra-planes-ignored",
            "side-lossless",
        ),
        (&compressed, "motion-runs-over-row-ends", "motion-border"),
        (&compressed, "motion-ignored", "motion-vertical"),
        (&lum, "chroma-signed", "lum-chroma"),
    ] {
        let mistake = misreading(slug);
        let printed = printed_report(suite, |request| answer_with(&[mistake], request));
        assert!(!printed.followed.contains(&ruling.to_owned()), "{ruling}");
        printed.says(&[mistake.effect]).assert_true();
    }
}

/// Without a mistake that looks like it, the same reading is listed.
#[test]
fn a_reading_is_listed_in_spite_of_other_mistakes() {
    let suite = cases(is_compressed);
    let reading = Reading {
        side_information: planes::side_information_if_lossy,
        ..Reading::SPEC
    };
    let other = misreading("inversion-ignored");
    let printed = printed_report(&suite, |request| {
        ptm_mistakes::answer(&[other], reading, request.file, request.view)
    });
    assert!(printed.dialect().contains("side-lossless"));
    printed.says(&[other.effect]).assert_true();
}

/// The decoder adds 1 to each color above 0. The named formula also changes the others, in images with black texels.
#[test]
fn places_of_wrong_values_include_those_that_a_named_mistake_explains() {
    let suite = cases(is_uncompressed);
    printed_report(&suite, |request| {
        answer_with_colors(request, |colors| {
            for color in colors.iter_mut().filter(|color| **color > 0) {
                *color = color.saturating_add(1);
            }
        })
    })
    .says(&["value + 1"])
    .never_says("only in")
    .assert_true();
}

/// Reconstructs planes with another plan.
fn reconstruct_as(
    coded: &Coded,
    residuals: Vec<Vec<u8>>,
    reading: &Reading,
    change: impl Fn(&mut Plan),
) -> ptm::Result<Vec<Vec<u8>>> {
    let mut plan = coded.plan.clone();
    change(&mut plan);
    let coded = Coded {
        plan: &plan,
        ..*coded
    };
    planes::reconstruct(&coded, residuals, reading)
}

/// Predicts the last three of nine planes without motion.
fn without_motion_of_colors(plan: &mut Plan) {
    if plan.steps.len() == 9 {
        let colors = plan.steps[6..].iter_mut();
        colors.for_each(|step| step.displaced = false);
    }
}

/// Keeps only the first record of each plane.
fn with_one_record(plan: &mut Plan) {
    for Range { start, end } in plan.extents.iter_mut().map(|extent| &mut extent.side) {
        *end = (*end).min(*start + 5);
    }
}

/// The decoder predicts the color planes of LRGB without motion, and applies only the first record of each plane, which is named.
/// Missing records leave wrong values in planes that are not predicted.
#[test]
fn planes_that_a_named_mistake_makes_wrong_are_not_called_correct() {
    let suite = cases(is_compressed);
    let without_motion = Reading {
        reconstruct: |coded, residuals, reading| {
            reconstruct_as(coded, residuals, reading, without_motion_of_colors)
        },
        ..Reading::SPEC
    };
    let with_both = Reading {
        reconstruct: |coded, residuals, reading| {
            reconstruct_as(coded, residuals, reading, |plan| {
                without_motion_of_colors(plan);
                with_one_record(plan);
            })
        },
        ..Reading::SPEC
    };
    let elsewhere = "apart from what named mistakes explain, nowhere else";
    let motion = printed_report(&suite, |request| answer_in(without_motion, request))
        .says(&["wrong values in predicted planes, and nowhere else"])
        .never_says(elsewhere);
    let both = printed_report(&suite, |request| answer_in(with_both, request))
        .says(&["reads only one record per plane"])
        .says(&["wrong values in predicted planes", elsewhere]);
    assert_all_true([motion, both]);
}

/// The decoder swaps the bytes of indices. It never ends on one file in which an index is then past the last entry.
#[test]
fn exceeded_limits_are_not_listed_under_a_misreading_of_values() {
    let suite = cases(is_uncompressed);
    let mistake = misreading("big-endian-index");
    let slow = suite.case("table-of-257-entries-ptm-lut");
    let slow = slow.expect("the case is in the suite");
    let file = &slow.build(TableSpelling::default()).file;
    let mut printed = printed_report(&suite, |request| match request.file == file {
        true => Answer::TimedOut(TimeLimit(Duration::from_secs(10))),
        false => answer_with(&[mistake], request),
    });
    for cause in &printed.causes {
        let is_slow = cause.sentences.contains("exceeds the time limit of 10 s");
        if is_slow != listed(&cause.cause).any(|id| *id == slow.id) {
            printed.problems.push(cause.sentences.clone());
        }
    }
    printed.says(&[mistake.effect]).assert_true();
}

// Statements about coincidences

/// The decoder reads green and blue of RGB from memory that is 0.
#[test]
fn a_channel_that_does_not_exist_explains_no_color() {
    let suite = cases(is_uncompressed);
    printed_report(&suite, |request| {
        answer_with_colors(request, |colors| {
            if format_of(request) == Some(Format::Rgb) {
                for color in colors.chunks_exact_mut(3) {
                    color[1..].fill(0);
                }
            }
        })
    })
    .never_says("the channel of coefficient")
    .has_at_most(2)
    .assert_true();
}

/// The decoder refuses tables in all files that are requested in view rgb, and in most others.
#[test]
fn refusals_in_several_views_are_not_attributed_to_one() {
    let suite = cases(is_uncompressed);
    printed_report(&suite, |request| {
        let has_table = matches!(format_of(request), Some(Format::PtmLut | Format::PtmCLut));
        let is_read = request.view.kind() != ViewKind::Rgb && request.file.len() % 5 == 0;
        match reference_answer(request) {
            Answer::Decoded(_) if has_table && !is_read => Answer::Rejected,
            answer => answer,
        }
    })
    .never_says("requested in view rgb")
    .assert_true();
}

/// The decoder refuses the files that a decoder with indices of two bytes refuses, except some that have the same value everywhere:
/// it shows their images.
#[test]
fn a_misreading_that_refuses_a_file_with_an_image_is_not_offered() {
    let suite = cases(is_uncompressed);
    let mistake = misreading("width-always-two");
    let is_uniform = |case: &&Case| case.id.starts_with("payload-of-");
    let uniform = suite.cases.iter().filter(is_uniform);
    let uniform = uniform.map(|case| case.build(TableSpelling::default()).file.clone());
    let uniform: Vec<_> = uniform.collect();
    assert!(!uniform.is_empty());
    printed_report(&suite, |request| match answer_with(&[mistake], request) {
        Answer::Rejected if !uniform.iter().any(|file| **file == *request.file) => Answer::Rejected,
        _ => reference_answer(request),
    })
    .never_says(mistake.slug)
    .assert_true();
}

/// Returns the decoding plan of a compressed file that the reference reads.
fn plan_of(file: &[u8]) -> Option<Plan> {
    let (_, _, streams) = ptm::decode::examine_streams(file);
    Some(streams?.coded().plan.clone())
}

fn has_side_information(file: &[u8]) -> bool {
    plan_of(file).is_some_and(|plan| plan.extents.iter().any(|extent| !extent.side.is_empty()))
}

fn has_motion_compensation(file: &[u8]) -> bool {
    let is_displaced = |step: &Step| step.reference.is_some() && step.displaced;
    plan_of(file).is_some_and(|plan| plan.steps.iter().any(is_displaced))
}

/// Changes the stored values of an image so that no formula gives them.
fn scrambled(mut frame: Frame) -> Answer {
    if let Samples::U8(samples) = &mut frame.samples {
        for (i, sample) in samples.iter_mut().enumerate() {
            *sample ^= (i * i % 251) as u8;
        }
    }
    Answer::Decoded(frame)
}

/// One of the files was written by hand.
#[test]
fn files_written_by_hand_share_properties_with_generated_files() {
    let suite = cases(is_compressed);
    printed_report(&suite, |request| match reference_answer(request) {
        Answer::Decoded(_) if has_side_information(request.file) => Answer::Rejected,
        answer => answer,
    })
    .says(&["refuses every legal file with side information"])
    .has_causes(1)
    .assert_true();
}

/// The decoder refuses large sides, and some numbers for another reason. For some files, the message is not known.
#[test]
fn a_failure_without_a_message_belongs_to_the_files_with_the_same_property() {
    let suite = cases(is_uncompressed);
    printed_report(&suite, |request| {
        let refusal = |message: &str| Reply {
            stderr: message.to_owned(),
            ..Answer::Rejected.into()
        };
        let answer = reference_answer(request);
        let (width, height) = size_in(&answer).unwrap_or_default();
        let has_plus = request
            .file
            .windows(3)
            .any(|bytes| matches!(bytes, [b' ', b'+', b'0'..=b'9']));
        match answer {
            Answer::Decoded(_) if has_plus => refusal("error: not a number"),
            Answer::Decoded(_) if width.max(height) > 500 => {
                let is_known = format_of(request) != Some(Format::Lum) || height > width;
                refusal(if is_known { "error: too large" } else { "" })
            }
            answer => answer.into(),
        }
    })
    .says(&["refuses every legal file whose larger side"])
    .assert_true();
}

/// The mean of two texels is rounded down, as in a permitted reading, but that of four is not. In that reading, another sample is wrong
/// first.
#[test]
fn example_of_a_mistake_is_a_sample_that_it_changes() {
    let suite = cases(is_compressed);
    let edit = Edit::parse("mean of two", "floor((a + b) / 2)").expect("an edit");
    let mistake = formula_misreading(vec![edit]);
    printed_report(&suite, |request| answer_with(&[&mistake], request))
        .says(&[
            "floor((a + b) / 2) instead of floor((a + b + 1) / 2)",
            "motion-in-structure-deep-jpegls-lrgb, texel (2, 4), a4: received 136, expected 137;",
        ])
        .assert_true();
}

/// The cause in the README is the one that `check` prints.
#[test]
fn failing_run_in_the_readme_is_printed() {
    let big_endian = misreading("big-endian-index");
    let report = printed_report(&cases(|_| true), |request| {
        answer_with(&[big_endian], request)
    });
    let readme = include_str!("../../../README.md");
    let block = readme
        .split("\n\n")
        .find(|block| block.contains("of 66 failures"));
    for line in block.expect("a cause").lines().map(str::trim) {
        // This suite has fewer files.
        let line = line.trim_start_matches("66 of 66 ");
        assert!(report.text.contains(line), "{line}\n{}", report.text);
    }
}

/// The decoder overwrites memory for some files. The C library notices this in different ways.
#[test]
fn crashes_of_the_heap_are_one_cause() {
    let suite = cases(|case| case.format() == Format::Lrgb && case.expect == Expect::Decode);
    printed_report(&suite, |request| {
        let messages = [
            "free(): invalid next size (fast)",
            "malloc(): corrupted top size",
            "corrupted size vs. prev_size",
        ];
        match reference_answer(request) {
            Answer::Decoded(_) if request.file.len() % 7 == 0 => Reply {
                stderr: messages[request.file.len() % 3].to_owned(),
                ..Answer::Crashed("killed by signal 6".to_owned()).into()
            },
            answer => answer.into(),
        }
    })
    .has_causes(1)
    .assert_true();
}

/// The decoder scales the first channel after a5 in view coef, which is R or Cr.
#[test]
fn channels_with_different_names_are_described_by_their_place() {
    let suite = cases(|case| case.format() != Format::Rgb && is_uncompressed(case));
    printed_report(&suite, |request| {
        let mut answer = reference_answer(request);
        if let Answer::Decoded(frame) = &mut answer
            && let (Samples::F32(values), channels) = (&mut frame.samples, frame.channels)
        {
            for value in values.iter_mut().skip(6).step_by(channels as usize) {
                *value = (*value - 3.0) * 1.25;
            }
        }
        answer
    })
    .says(&[
        "shows wrong final values",
        "only in the first channel after a5",
    ])
    .has_causes(1)
    .assert_true();
}

/// Texels are moved if there are three or more and no scale is small. Final values are rounded to three decimals.
#[test]
fn small_errors_of_final_values_are_no_wrong_stored_values() {
    let suite = cases(|case| case.format() == Format::Lrgb);
    printed_report(&suite, |request| {
        let mut answer = answer_with_map(request.file, request.view, |ptm| {
            let by = ptm.planes.shape.channels() + 1;
            if ptm.planes.samples.len() > 2 * by
                && ptm.header.scale_bias.scale.iter().all(|&scale| scale > 0.1)
            {
                ptm.planes.samples.rotate_left(by);
            }
        });
        if let Answer::Decoded(frame) = &mut answer
            && let Samples::F32(values) = &mut frame.samples
        {
            for value in values {
                *value = (*value * 1000.0).round() / 1000.0;
            }
        }
        answer
    })
    .says(&["shows wrong final values", "received 4.063"])
    .assert_true();
}

/// The decoder scrambles stored values in legal files of RGB, and in files of other formats that need not be decoded.
#[test]
fn formats_of_files_that_need_not_be_decoded_are_those_of_these_files() {
    let suite = cases(is_uncompressed);
    let is_optional = |request: &Request| {
        let case = suite.case(request.name);
        case.is_some_and(|case| case.expect.is_optional())
    };
    printed_report(&suite, |request| {
        let is_scrambled = (format_of(request) == Some(Format::Rgb)) != is_optional(request);
        match reference_answer(request) {
            Answer::Decoded(frame) if is_scrambled => scrambled(frame),
            answer => answer,
        }
    })
    .says(&[
        "legal files of RGB (and ",
        " of LUM, LRGB, PTM_LUT, PTM_C_LUT that need not be decoded)",
    ])
    .assert_true();
}

/// The decoder refuses legal files with motion compensation in a predicted plane, but reads such files that need not be decoded.
#[test]
fn a_file_that_need_not_be_decoded_refutes_a_property() {
    let suite = cases(is_compressed);
    printed_report(&suite, |request| {
        let is_legal = suite
            .case(request.name)
            .is_some_and(|case| case.expect == Expect::Decode);
        match reference_answer(request) {
            Answer::Decoded(_) if is_legal && has_motion_compensation(request.file) => {
                Answer::Rejected
            }
            answer => answer,
        }
    })
    .never_says("every legal file with motion compensation in a predicted plane")
    .assert_true();
}

/// The decoder crashes on some files with motion compensation in a predicted plane, and shows a wrong image of the others.
#[test]
fn crashes_and_wrong_images_of_files_with_one_property_are_one_cause() {
    let suite = cases(is_compressed);
    printed_report(&suite, |request| match reference_answer(request) {
        Answer::Decoded(_)
            if has_motion_compensation(request.file) && request.file.len() % 7 == 0 =>
        {
            Answer::Crashed("exit status 1".to_owned())
        }
        Answer::Decoded(frame) if has_motion_compensation(request.file) => scrambled(frame),
        answer => answer,
    })
    .says(&["every legal file with motion compensation in a predicted plane (and "])
    .has_causes(1)
    .assert_true();
}

/// The decoder computes the sum of the bytes of an index times 256, and refuses an index past the table.
#[test]
fn an_index_past_the_table_that_is_refused_elsewhere_shows_no_formula() {
    let suite = cases(is_uncompressed);
    let reading = Reading {
        index: |stored| match stored {
            [low, high] => (usize::from(*low) + usize::from(*high)) * 256,
            _ => indices::little_endian(stored),
        },
        ..Reading::SPEC
    };
    printed_report(&suite, |request| answer_in(reading, request))
        .never_says("computes the index as")
        .says(&["with a table of more than 256 entries"])
        .assert_true();
}

/// The decoder reads the first three bytes of a position, and refuses positions outside the plane.
#[test]
fn an_edited_position_alone_decides_whether_a_record_is_in_range() {
    let suite = cases(is_compressed);
    let reading = Reading {
        records: |block, at, texels| {
            let shift = |record: &[u8]| [0, record[0], record[1], record[2], record[4]];
            let mut shifted: Vec<u8> = block.chunks_exact(5).flat_map(shift).collect();
            shifted.extend_from_slice(block.chunks_exact(5).remainder());
            planes::parse_records(&shifted, at, texels)
        },
        ..Reading::SPEC
    };
    printed_report(&suite, |request| answer_in(reading, request))
        .never_says("ignores records")
        .has_causes(1)
        .assert_true();
}

/// The decoder exits with 69 if a transform has the bit of motion, even that of a plane without a reference.
#[test]
fn exit_status_69_does_not_mean_malformed() {
    let suite = cases(is_compressed);
    let has_motion = |file: &[u8]| {
        let (fields, _) = ptm::decode::fields(file);
        let mut transforms = fields.iter().filter(|field| field.clause == "2.9.2/1");
        transforms.any(|field| matches!(&file[field.range.clone()], b"2" | b"3"))
    };
    printed_report(&suite, |request| match reference_answer(request) {
        Answer::Decoded(_) if has_motion(request.file) => Answer::Unsupported,
        answer => answer,
    })
    .never_says("the decoder refuses")
    .says(&["exits with 69 (unsupported) on"])
    .assert_true();
}

/// The decoder looks for indices so far before the file that it finds zeros, or in the header, where it finds letters.
#[test]
fn a_position_of_which_nothing_is_in_the_data_is_not_named() {
    let suite = cases(|case| case.format() == Format::PtmCLut);
    let first_index = Reading {
        index: |_| 0,
        ..Reading::SPEC
    };
    printed_report(&suite, |request| {
        let (fields, _) = ptm::decode::fields(request.file);
        let table = fields.iter().find(|field| field.clause == "2.5/3");
        match table.map(|field| &field.range) {
            Some(table) if table.start >= table.len() => Answer::Rejected,
            Some(_) => answer_in(first_index, request),
            None => reference_answer(request),
        }
    })
    .never_says("the decoder computes the ")
    .assert_true();
}

/// The decoder shows the bottom row of the file in all rows, but reads all indices.
#[test]
fn refused_indices_in_rows_that_are_not_shown_contradict_no_order_of_rows() {
    let suite = cases(is_uncompressed);
    printed_report(&suite, |request| match reference_answer(request) {
        Answer::Decoded(_) => answer_with_map(request.file, request.view, |ptm| {
            let planes = &mut ptm.planes;
            let row = planes.size.width as usize * planes.shape.channels();
            let first = planes.samples[..row].to_vec();
            planes
                .samples
                .chunks_exact_mut(row)
                .for_each(|one| one.copy_from_slice(&first));
        }),
        answer => answer,
    })
    .says(&["computes the stored row of an image row as height - 1 instead of"])
    .never_says("in files of format")
    .assert_true();
}

/// The decoder crashes on every file that need not be decoded but has no fault. Such files have rulings instead.
#[test]
fn files_that_need_not_be_decoded_are_listed_by_their_rulings() {
    let suite = cases(is_uncompressed);
    let build = |case: &Case| case.build(TableSpelling::default()).file.clone();
    let is_lenient = |case: &&Case| case.expect == Expect::Lenient && case.damage().is_none();
    let lenient: Vec<Vec<u8>> = suite.cases.iter().filter(is_lenient).map(build).collect();
    printed_report(&suite, |request| match reference_answer(request) {
        _ if lenient.iter().any(|file| file == request.file) => {
            Answer::Crashed("exit status 3".to_owned())
        }
        answer => answer,
    })
    .says(&[
        "files that must or may be refused (",
        "ruling header-blanks; ruling inner-line-end; ",
    ])
    .assert_true();
}

/// The decoder reads every version as 1.2. Files of version 1.1 need not be refused.
#[test]
fn faults_of_accepted_files_are_those_of_malformed_files() {
    let suite = cases(|case| matches!(case.format(), Format::Lrgb | Format::Rgb));
    printed_report(&suite, |request| {
        let file = respelled(request.file, &["2.1/1"], |_| Some("PTM_1.2".to_owned()));
        match reference_answer(request) {
            image @ Answer::Decoded(_) => image,
            _ => ptm_mistakes::answer(&[], Reading::SPEC, &file, request.view),
        }
    })
    .never_says("the version is 1.1")
    .assert_true();
}

/// The decoder computes colors of RGB from the wrong channels, and those of other formats correctly. With the same formula, all colors of
/// these formats would come from outside the texel.
#[test]
fn correct_colors_contradict_channels_outside_the_texel() {
    let suite = cases(is_uncompressed);
    let edit = Edit::parse("channel of a coefficient", "c + 6 + i").expect("a formula");
    let mistake = formula_misreading(vec![edit]);
    printed_report(&suite, |request| match format_of(request) {
        Some(Format::Rgb) => answer_with(&[&mistake], request),
        _ => reference_answer(request),
    })
    .says(&["c + 6 + i instead of c * 6 + i", "in files of format RGB"])
    .never_says("seen in files")
    .assert_true();
}

/// The decoder reads the biases in reverse order, and leaves the middle row of files of odd height empty. The stored values of other
/// files are correct, so their colors are not said to follow from stored values.
#[test]
fn colors_without_earlier_values_are_wrong_colors() {
    let suite = cases(is_uncompressed);
    printed_report(&suite, |request| {
        answer_with_map(request.file, request.view, |ptm| {
            ptm.header.scale_bias.bias.reverse();
            let Size { width, height } = ptm.header.size;
            let row = width as usize * ptm.planes.shape.channels();
            let middle = height as usize / 2;
            if height % 2 == 1 {
                ptm.planes.samples[middle * row..][..row].fill(0);
            }
        })
    })
    .says(&["every wrong sample in view raw is 0", "odd height"])
    .says(&["shows wrong final values"])
    .says(&["shows wrong colors"])
    .assert_true();
}

/// Two mistakes in files with tables: one of the index or of its width, and refusals of many texels. A mistake that refuses files with
/// correct images does not explain the refusals, even if the other mistake changes the same value.
#[test]
fn refusals_beside_a_mistake_of_the_index_are_described() {
    let suite = cases(is_uncompressed);
    for slug in ["big-endian-index", "width-always-one"] {
        let mistake = misreading(slug);
        printed_report(&suite, |request| {
            let is_large = has_table(request.file)
                && size_in(&reference_answer(request))
                    .is_some_and(|(width, height)| width * height > 256);
            match is_large {
                true => Answer::Rejected,
                false => answer_with(&[mistake], request),
            }
        })
        .says(&["index"])
        .says(&["number of texels is at least 257"])
        .never_says("refuses the index")
        .never_says("would also show no image")
        .has_at_most(2)
        .assert_true();
    }
}

/// Decoders with several random mistakes, of which many are not named. Each set is tried twice: the second time, all mistakes but the
/// first are made only in files with an odd number of bytes, which no mistake of the search depends on.
#[test]
#[ignore = "takes minutes"]
fn claims_about_random_sets_are_true() {
    let suite = cases(|_| true);
    let sets = [2, 3, 4, 6].map(|size| random_sets(20, size));
    let reports = sets.iter().flatten().flat_map(|set| {
        println!("{:?}", set.iter().map(|one| one.slug).collect::<Vec<_>>());
        [false, true].map(|depends| {
            printed_report(&suite, |request| {
                let is_even = request.file.len() % 2 == 0;
                let count = if depends && is_even { 1 } else { set.len() };
                answer_with(&set[..count], request)
            })
        })
    });
    assert_all_true(reports);
}
