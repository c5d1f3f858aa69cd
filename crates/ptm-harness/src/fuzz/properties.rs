//! Properties that must hold for every input. Fuzz targets and proptest call one function for each property.
//!
//! Each function takes untrusted bytes and panics if its property does not hold. Functions that need structured input derive it
//! from the bytes. If there are too few bytes, they return without testing.

use std::collections::HashSet;
use std::sync::LazyLock;
use std::time::Duration;

use arbitrary::{Result, Unstructured};

use crate::diagnose::diagnose;
use crate::fuzz::draft::Draft;
use crate::pipeline::judge_answers;
use crate::session::plan::RunPlan;
use ptm::codec::{jpeg, jpeg_ls};
use ptm::decode::lookup_table::read_newline_separator;
use ptm::decode::{decode, decode_as, fields};
use ptm::evaluate::{compute_coefficients, evaluate};
use ptm::reading::Reading;
use ptm::{Coding, Limits, Planes};
use ptm_generate::{Compression, Model, Recipe, Spelling, write};
use ptm_generate::{plan::Residuals, spelling::Lists};
use ptm_suite::cases::{Case, Suite, TableSpelling};
use ptm_suite::dialect::{Choice, Dialect};
use ptm_suite::protocol::frame::{Answer, Frame, Samples, TimeLimit, View};
use ptm_suite::protocol::request::{Reply, Request};
use ptm_suite::{choices::CHOICES, compare::Expected};

/// Maximum number of texels in a generated file. A fuzz target can process thousands of small files per second.
const MAX_TEXELS: u32 = 3000;
/// Maximum size, in bytes, of the planes in an arbitrary file.
const MAX_MEMORY: usize = 1 << 24;

/// Checks that decoding any bytes, with several readings of open questions, returns planes or an error with a section and
/// an offset in the file.
///
/// # Panics
/// Panics if the check fails.
pub fn file(bytes: &[u8]) {
    let limits = Limits { memory: MAX_MEMORY };
    // Use the first, second and third reading of every choice, or the last reading if there are fewer.
    let [first, mut second, third] = [0, 1, 2].map(|n| {
        let pick = |choice: &Choice<Reading>| n.min(choice.readings.len() - 1);
        CHOICES.apply(&Dialect(CHOICES.iter().map(pick).collect()), Reading::SPEC)
    });
    second.after_table = read_newline_separator;
    for reading in [first, second, third] {
        match decode_as(bytes, &reading, &limits) {
            Ok(ptm) => {
                assert!(ptm.planes.samples.len() <= MAX_MEMORY, "over the limit");
                let set = &ptm.header.scale_bias;
                let coefficients = compute_coefficients(set, &ptm.planes, &reading);
                let _ = evaluate(&coefficients, 0.5, -0.25, &reading).to_bytes();
            }
            Err(error) => {
                assert!(error.offset() <= bytes.len(), "{error}");
                assert!(error.to_string().contains('§'), "{error}");
            }
        }
    }
    // The fields are in order and inside the file.
    let (fields, _) = fields(bytes);
    for pair in fields.windows(2) {
        assert!(pair[0].range.end <= pair[1].range.start, "{pair:?}");
    }
    assert!(fields.iter().all(|field| field.range.end <= bytes.len()));
}

/// Checks that a generated file decodes to the painted values.
///
/// # Panics
/// Panics if the check fails.
pub fn recipe(bytes: &[u8]) {
    let Some((draft, case)) = draw(bytes) else {
        return;
    };
    let built = case.build(TableSpelling::default());
    let yaml = draft.to_yaml("drawn", "", None);
    let ptm = decode(&built.file).unwrap_or_else(|error| panic!("{error}\n{yaml}"));
    let expected = Expected::new(&built.values, &View::Raw).expect("the values are known");
    let difference = expected.compare(&Frame::render(&ptm, &View::Raw));
    assert!(difference.is_none(), "{difference:?}\n{yaml}");
}

/// Checks that the planes do not depend on the spelling of the header.
///
/// # Panics
/// Panics if the check fails.
pub fn spelling(bytes: &[u8]) {
    let Some((_, case)) = draw(bytes) else {
        return;
    };
    let mut recipe = case.recipe().expect("a draft has a recipe").clone();
    let model = Model::paint(&recipe);
    let drawn = planes(&recipe, &model);
    recipe.spelling.lists = Lists::OneLine;
    assert_eq!(drawn, planes(&recipe, &model));
    recipe.spelling = Spelling::default();
    assert_eq!(drawn, planes(&recipe, &model));
}

/// Checks that planes stored as plain texels and planes stored as lossless JPEG-LS with any prediction decode to the same values.
///
/// # Panics
/// Panics if the check fails.
pub fn re_encoding(bytes: &[u8]) {
    let Some((_, case)) = draw(bytes) else {
        return;
    };
    let mut natural = case.recipe().expect("a draft has a recipe").clone();
    let is_jpeg_ls = natural.format.coding() == Some(Coding::JpegLs);
    // Corrections of lossless planes equal the painted values. Corrections of lossy planes would differ.
    if !is_jpeg_ls || natural.compression.parameter > 0 {
        return;
    }
    natural.compression.residuals = Residuals::Natural;
    let mut plain = natural.clone();
    plain.format = natural.format.uncompressed();
    plain.compression = Compression::default_for(plain.format);
    let [plain, natural] = [plain, natural].map(|recipe| planes(&recipe, &Model::paint(&recipe)));
    assert_eq!(plain.samples, natural.samples);
}

/// Checks that decoding any bytes as JPEG returns the requested number of samples, or an error at an offset in the stream.
///
/// # Panics
/// Panics if the check fails.
pub fn jpeg_stream(bytes: &[u8]) {
    check_stream(bytes, jpeg::decode);
}

/// Checks that decoding any bytes as JPEG-LS returns the requested number of samples, or an error at an offset in the stream.
///
/// # Panics
/// Panics if the check fails.
pub fn jpeg_ls_stream(bytes: &[u8]) {
    check_stream(bytes, jpeg_ls::decode);
}

fn check_stream(bytes: &[u8], decode: fn(&[u8], u32, u32) -> Decoded<Vec<u8>>) {
    let [width, height, stream @ ..] = bytes else {
        return;
    };
    let (width, height) = (u32::from(*width) + 1, u32::from(*height) + 1);
    match decode(stream, width, height) {
        Ok(samples) => assert_eq!(samples.len(), (width * height) as usize),
        Err(error) => assert!(error.offset <= stream.len(), "{error}"),
    }
}

type Decoded<T> = std::result::Result<T, ptm::codec::StreamError>;

/// Checks that a JPEG stream decodes to the samples that its encoder returns. Returns the stream, the size of the image and those
/// samples, for comparison with another decoder.
///
/// # Panics
/// Panics if the check fails.
#[must_use]
pub fn jpeg_round_trip(bytes: &[u8]) -> Option<(Vec<u8>, u32, u32, Vec<u8>)> {
    let u = &mut Unstructured::new(bytes);
    let (width, height, options) = jpeg_options(u).ok()?;
    let samples = samples_from_bytes(width, height, u);
    let encoded = jpeg::encode(&samples, width, height, &options);
    let decoded = jpeg::decode(&encoded.stream, width, height).expect("the stream is legal");
    assert_eq!(decoded, encoded.samples);
    Some((encoded.stream, width, height, decoded))
}

/// Returns true if our samples of a JPEG stream are within 18 of those of another decoder, which may use a different DCT.
///
/// Skips blocks that contain a 0 or a 255, because their unclamped values may be far out of range, where a 16-bit DCT overflows.
#[must_use]
pub fn nearly_equal(ours: &[u8], theirs: &[u8], width: u32) -> bool {
    let block = |i: usize| (i % width as usize / 8, i / width as usize / 8);
    let extremes = (0..ours.len()).filter(|&i| matches!(ours[i], 0 | 255));
    let skipped: HashSet<(usize, usize)> = extremes.map(block).collect();
    let is_near = |i: usize| ours[i].abs_diff(theirs[i]) <= 18 || skipped.contains(&block(i));
    ours.len() == theirs.len() && (0..ours.len()).all(is_near)
}

/// Checks that a JPEG-LS stream decodes to the samples that its encoder returned, and that their error is at most NEAR.
///
/// # Panics
/// Panics if the check fails.
pub fn jpeg_ls_round_trip(bytes: &[u8]) {
    let u = &mut Unstructured::new(bytes);
    let Ok((width, height, options)) = jpeg_ls_options(u) else {
        return;
    };
    let mut samples = samples_from_bytes(width, height, u);
    for sample in &mut samples {
        *sample >>= 8 - options.precision;
    }
    let encoded = jpeg_ls::encode(&samples, width, height, &options);
    let decoded = jpeg_ls::decode(&encoded.stream, width, height).expect("the stream is legal");
    assert_eq!(decoded, encoded.samples);
    let mut pairs = decoded.iter().zip(&samples);
    assert!(pairs.all(|(a, b)| a.abs_diff(*b) <= options.near));
}

fn jpeg_options(u: &mut Unstructured) -> Result<(u32, u32, jpeg::JpegOptions)> {
    let mut options = jpeg::JpegOptions {
        quality: u.int_in_range(1..=100)?,
        baseline: u.arbitrary()?,
        optimized: u.arbitrary()?,
        restart_interval: u.int_in_range(0..=5)?,
        sampling: (u.int_in_range(1..=4)?, u.int_in_range(1..=4)?),
        step: u.ratio(1, 4)?.then_some(u.int_in_range(1..=2000)?),
        ..jpeg::JpegOptions::new(75)
    };
    if u.arbitrary()? {
        let mut number = || u.int_in_range(0..=3);
        options.table_numbers = Some([number()?, number()?, number()?]);
    }
    options.tables_together = u.arbitrary()?;
    Ok((u.int_in_range(1..=40)?, u.int_in_range(1..=40)?, options))
}

fn jpeg_ls_options(u: &mut Unstructured) -> Result<(u32, u32, jpeg_ls::JpegLsOptions)> {
    let (mut near, mut precision, mut presets) = (0, 8, None);
    if u.arbitrary()? {
        precision = u.int_in_range(2..=8)?;
    }
    let maxval = (1 << precision) - 1;
    if u.arbitrary()? {
        near = u.int_in_range(1..=20.min(maxval / 2))?;
    }
    if u.arbitrary()? {
        let t1 = u.int_in_range(near + 1..=maxval)?;
        let t2 = u.int_in_range(t1..=maxval)?;
        presets = Some(jpeg_ls::PresetParameters {
            maxval,
            t1,
            t2,
            t3: u.int_in_range(t2..=maxval)?,
            reset: u.int_in_range(3..=255)?,
        });
    }
    let options = jpeg_ls::JpegLsOptions {
        near: near as u8,
        precision,
        presets,
    };
    Ok((u.int_in_range(1..=60)?, u.int_in_range(1..=40)?, options))
}

/// Returns samples that consist of the remaining bytes, repeated as needed. A single byte produces a run, and many bytes produce
/// noise.
fn samples_from_bytes(width: u32, height: u32, u: &mut Unstructured) -> Vec<u8> {
    let bytes = u.bytes(u.len()).unwrap_or_default();
    let bytes = if bytes.is_empty() { &[128][..] } else { bytes };
    let samples = bytes.iter().copied().cycle();
    samples.take((width * height) as usize).collect()
}

/// Checks that any decoder output either is refused with a message or is a frame whose shape survives a round trip.
///
/// # Panics
/// Panics if the check fails.
pub fn frame(bytes: &[u8]) {
    match Frame::read(bytes) {
        Ok(frame) => {
            let mut written = Vec::new();
            frame.write(&mut written).expect("memory is writable");
            let read = Frame::read(&written);
            assert_eq!(read.as_ref().map(Frame::shape), Ok(frame.shape()));
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Checks that any text is either a valid case file or refused with a message.
///
/// # Panics
/// Panics if the check fails.
pub fn case_file(bytes: &[u8]) {
    // A large size is legal but slow to paint.
    let mut fours = bytes.windows(4);
    let is_long = fours.any(|four| four.iter().all(u8::is_ascii_digit));
    if let (Ok(text), false) = (std::str::from_utf8(bytes), is_long)
        && let Err(error) = Suite::from_files(&[("case.yaml", text)])
    {
        assert!(error.to_string().starts_with("case.yaml"), "{error}");
    }
}

fn draw(bytes: &[u8]) -> Option<(Draft, Case)> {
    let draft = Draft::draw(&mut Unstructured::new(bytes)).ok()?;
    if draft.width * draft.height > MAX_TEXELS {
        return None;
    }
    let cases = draft.cases("drawn");
    let mut cases =
        cases.unwrap_or_else(|error| panic!("{error}\n{}", draft.to_yaml("drawn", "", None)));
    Some((draft, cases.pop()?))
}

fn planes(recipe: &Recipe, model: &Model) -> Planes {
    let file = write(recipe, model).bytes;
    decode(&file).expect("a legal recipe").planes
}

/// Checks that the diagnosis attributes every failure to at most one cause, and does not panic, whatever the answers are.
///
/// # Panics
/// Panics if the check fails.
pub fn diagnosis(bytes: &[u8]) {
    static SUITE: LazyLock<Suite> = LazyLock::new(|| {
        let mut suite = Suite::load().expect("the suite loads");
        let is_small = |case: &Case| case.build(TableSpelling::default()).file.len() < MAX_BYTES;
        let mut selected = HashSet::new();
        for (i, case) in suite.cases.iter().enumerate() {
            if case.first || i % CASE_STRIDE == 0 && is_small(case) {
                selected.insert(case.id.clone());
                selected.extend(case.twin_of.clone());
            }
        }
        suite.cases.retain(|case| selected.contains(&case.id));
        suite.with_prepared_files()
    });
    let script: Vec<u8> = bytes.iter().copied().take(SUITE.cases.len()).collect();
    let ask = |request: &Request<'_>, _: usize| {
        let right = ptm_mistakes::answer(&[], Reading::SPEC, request.file, request.view);
        let bytes = request.file.iter().map(|&byte| usize::from(byte));
        let sum = bytes.sum::<usize>();
        let choice = script.get(sum % script.len().max(1)).copied();
        Reply::from(wrong_answer(choice.unwrap_or_default(), right, request))
    };
    let run = judge_answers(&SUITE, &RunPlan::new(&SUITE, 1), &ask);
    let mut explained = HashSet::new();
    let causes = diagnose(&SUITE, &run, &[], 1);
    for diagnosis in causes.diagnoses {
        for index in diagnosis.explains {
            assert!(explained.insert(index), "{} twice", SUITE.cases[index].id);
        }
    }
}

/// Interval between the cases that are used in addition to the `first` cases. Large files are skipped.
const CASE_STRIDE: usize = 40;
const MAX_BYTES: usize = 2000;

fn wrong_answer(choice: u8, right: Answer, request: &Request<'_>) -> Answer {
    let change = |edit: &dyn Fn(usize, u8) -> u8| match right.clone() {
        Answer::Decoded(mut frame) => {
            match &mut frame.samples {
                Samples::U8(samples) => {
                    for (i, sample) in samples.iter_mut().enumerate() {
                        *sample = edit(i, *sample);
                    }
                }
                Samples::F32(samples) => {
                    for (i, sample) in samples.iter_mut().enumerate() {
                        *sample = f32::from_bits(sample.to_bits() ^ u32::from(edit(i, 0)) << 16);
                    }
                }
            }
            Answer::Decoded(frame)
        }
        other => other,
    };
    match choice {
        0..64 => right,
        64..80 => Answer::Rejected,
        80..88 => Answer::Unsupported,
        88..96 => Answer::Crashed(format!("killed by signal {}", choice % 4)),
        96..104 => Answer::TimedOut(TimeLimit(Duration::from_secs(10))),
        104..112 => change(&|i, sample| sample ^ (i as u8).wrapping_mul(choice)),
        112..128 => change(&|_, sample| sample.wrapping_add(choice)),
        128..136 => change(&|i, sample| sample * u8::from(i % 7 != usize::from(choice % 7))),
        136..144 => match right {
            Answer::Decoded(mut frame) => {
                (frame.width, frame.height) = (frame.height, frame.width);
                Answer::Decoded(frame)
            }
            _ => Answer::ProtocolError("no frame".to_owned()),
        },
        _ => {
            let all: Vec<_> = ptm_mistakes::all().collect();
            let misreading = all[usize::from(choice) * 4 % all.len()];
            ptm_mistakes::answer(&[misreading], Reading::SPEC, request.file, request.view)
        }
    }
}
