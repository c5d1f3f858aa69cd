//! Compressed planes: errors in each plane, and unusual properties of the lists and streams.

use super::codes::Problem;
use super::diagnostic::{Diagnostic, Findings};
use crate::dissection::Role;
use crate::segments::{Segment, SegmentKind, frame, near, segments};
use crate::{describe_position, join_texts, texel_index};
use ptm::codec::StreamFault;
use ptm::decode::{Streams, planes::parse_records};
use ptm::error::Kind;
use ptm::{Coding, Format, Size};

/// Reports unusual properties of lists and streams.
pub(super) fn diagnose(findings: &mut Findings, streams: Option<&Streams>) {
    let dissection = findings.dissection;
    let count = dissection.compressed_planes();
    let Some(coding) = dissection.format.and_then(Format::coding) else {
        return;
    };
    if dissection.part(Role::SideSize(count - 1)).is_none() {
        return;
    }
    let mut all = Findings::new(dissection);
    check_ranks(&mut all, count);
    // The range of the compression parameter (clause 2.9.1/2).
    let range = match coding {
        Coding::Jpeg => 20..=100,
        Coding::JpegLs => 0..=127,
    };
    let value = dissection.number(Role::Parameter);
    if let Some(value) = value.filter(|value| !range.contains(value)) {
        let found = format!("{value}, expected {} to {}", range.start(), range.end());
        all.add(Problem::Parameter, Role::Parameter, found);
    }
    check_unused_transforms(&mut all, count);
    for plane in 0..count {
        check_stream(&mut all, coding, plane);
        check_duplicate_records(&mut all, plane);
    }
    if let Some(streams) = streams.filter(|_| coding == Coding::Jpeg) {
        check_wraparound(&mut all, streams);
    }
    findings.list.extend(merge_by_code(all.list));
}

/// Reports the errors in all planes. The reference stops at the first error.
pub(super) fn diagnose_errors(findings: &mut Findings) {
    let dissection = findings.dissection;
    let coding = dissection.format.and_then(Format::coding);
    let (Some(coding), Some(size)) = (coding, dissection.size) else {
        return;
    };
    for plane in 0..dissection.compressed_planes() {
        if let Some(stream) = dissection.bytes(Role::Stream(plane))
            && let Err(error) = coding.decode(stream, size.width, size.height)
        {
            let problem = match error.fault {
                StreamFault::Unsupported => Problem::StreamKind,
                StreamFault::Malformed => stream_problem(coding, stream, size),
            };
            let offset = dissection.start(Role::Stream(plane)) + error.offset;
            findings.add_at(problem, offset, format!("plane {plane}: {}", error.what));
        }
        let start = dissection.start(Role::Side(plane));
        if let Some(block) = dissection.bytes(Role::Side(plane))
            && let Err(error) = parse_records(block, start, size.texels())
        {
            let problem = match error.kind() {
                Kind::PartialRecord { .. } => Problem::RecordCut,
                _ => Problem::Position,
            };
            let found = format!("plane {plane}: {}", error.kind());
            findings.add_at(problem, error.offset(), found);
        }
    }
}

/// Classifies the problem with a stream that the codec refuses, based on the markers in the stream.
fn stream_problem(coding: Coding, stream: &[u8], size: Size) -> Problem {
    let is_stream = stream.starts_with(&[0xff, 0xd8]);
    match frame(&segments(stream)) {
        _ if !is_stream => Problem::NotAStream,
        None => Problem::StreamDamaged,
        Some((code, ..)) if (code == 0xf7) == (coding == Coding::Jpeg) => Problem::NotAStream,
        Some((_, _, height, width, 1))
            if (u32::from(width), u32::from(height)) == (size.width, size.height) =>
        {
            Problem::StreamDamaged
        }
        Some(_) => Problem::OtherImage,
    }
}

/// Reports ranks that are not a permutation of 0, 1, 2, …, and references below −1 (ruling `ranks`).
fn check_ranks(findings: &mut Findings, count: usize) {
    let dissection = findings.dissection;
    let number = |role| dissection.number(role).unwrap_or_default();
    let ranks: Vec<i64> = (0..count).map(|plane| number(Role::Rank(plane))).collect();
    let mut sorted = ranks.clone();
    sorted.sort_unstable();
    if !sorted.iter().copied().eq((0..).take(count)) {
        let found = format!("ranks {}", join_texts(&ranks, " "));
        findings.add(Problem::Ranks, Role::Rank(0), found);
    }
    let reference = |plane| number(Role::Reference(plane));
    if let Some(plane) = (0..count).find(|&plane| reference(plane) < -1) {
        let found = format!("the reference of plane {plane} is {}", reference(plane));
        findings.add(Problem::Ranks, Role::Reference(plane), found);
    }
}

/// Reports transforms and motion vectors that have no effect.
fn check_unused_transforms(findings: &mut Findings, count: usize) {
    let dissection = findings.dissection;
    let number = |role| dissection.number(role).unwrap_or_default();
    let has_no_effect = |plane: &usize| {
        let transform = number(Role::Transform(*plane));
        let intra = number(Role::Reference(*plane)) < 0;
        let vector = (number(Role::MotionX(*plane)), number(Role::MotionY(*plane)));
        (intra && transform != 0) || (vector != (0, 0) && (intra || transform & 2 == 0))
    };
    let planes: Vec<usize> = (0..count).filter(has_no_effect).collect();
    if let Some(&first) = planes.first() {
        let found = format!("planes {}", join_texts(&planes, ", "));
        findings.add(Problem::PredictionUnused, Role::Transform(first), found);
    }
}

/// Reports parts of a stream that a plane encoder would not normally write (ruling `plane-odd`).
fn check_stream(findings: &mut Findings, coding: Coding, plane: usize) {
    let role = Role::Stream(plane);
    let stream = findings.dissection.bytes(role).unwrap_or_default();
    if !stream.starts_with(&[0xff, 0xd8]) {
        return;
    }
    let (start, parts) = (findings.dissection.start(role), segments(stream));
    for segment in &parts {
        if let Some(problem) = segment_problem(coding, segment) {
            let details = match segment.description.as_str() {
                "" => String::new(),
                details => format!(" ({details})"),
            };
            let found = format!("plane {plane}: {}{details}", segment.kind.label().0);
            findings.add_at(problem, start + segment.range.start, found);
        }
    }
    // Report a JPEG-LS stream whose NEAR differs from the compression parameter.
    let is_jpeg_ls = frame(&parts).is_some_and(|(code, ..)| code == 0xf7);
    let near = near(&parts).filter(|_| is_jpeg_ls);
    if let (Some(near), Some(parameter)) = (near, findings.dissection.number(Role::Parameter))
        && i64::from(near) != parameter
    {
        let found = format!("plane {plane}: NEAR is {near}, but the parameter is {parameter}");
        findings.add(Problem::Near, role, found);
    }
}

fn segment_problem(coding: Coding, segment: &Segment) -> Option<Problem> {
    let is_jfif = coding == Coding::Jpeg && segment.kind == SegmentKind::Marker(0xe0);
    match (segment.kind, segment.bytes) {
        (SegmentKind::Marker(0xe0..=0xef | 0xfe), _) if !is_jfif => Some(Problem::StreamExtras),
        (SegmentKind::Fill, _) => Some(Problem::StreamExtras),
        (SegmentKind::Marker(0xdd), _) => Some(Problem::Restarts),
        (SegmentKind::Marker(0xdb), bytes) if has_16_bit_table(bytes) => {
            Some(Problem::StreamTables16)
        }
        (SegmentKind::Trailing, _) => Some(Problem::StreamTrailing),
        (SegmentKind::Marker(0xf7), [_, _, _, _, 2..=7, ..]) => Some(Problem::StreamPrecision),
        // LSE of type 1 with MAXVAL below 255. The value 0 means the default (T.87 C.2.4.1.1).
        (SegmentKind::Marker(0xf8), [_, _, _, _, 1, 0, 1..=254, ..]) => Some(Problem::StreamMaxval),
        _ => None,
    }
}

/// Returns true if a DQT segment has a table of 16-bit steps (T.81 B.2.4.1). Such tables require 12-bit samples (ruling
/// `plane-tables`), and a plane has 8-bit samples.
fn has_16_bit_table(segment: &[u8]) -> bool {
    const STEPS: usize = 64;
    let mut tables = segment.get(4..).unwrap_or_default();
    while let [precision_and_number, rest @ ..] = tables {
        match precision_and_number >> 4 {
            0 => tables = rest.get(STEPS..).unwrap_or_default(),
            _ => return true,
        }
    }
    false
}

/// Reports the first texel that has two records (ruling `side-twice`).
fn check_duplicate_records(findings: &mut Findings, plane: usize) {
    let role = Role::Side(plane);
    let block = findings.dissection.bytes(role).unwrap_or_default();
    let records = parse_records(block, 0, usize::MAX).unwrap_or_default();
    let numbered = records.iter().enumerate();
    let mut positions: Vec<(u32, usize)> = numbered.map(|(i, &(p, _))| (p, i)).collect();
    positions.sort_unstable();
    let pairs = positions.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    if let Some(&[(_, first), (position, second)]) = pairs.min_by_key(|pair| pair[1].1) {
        let found = format!("records {first} and {second} have the same position {position}");
        let start = findings.dissection.start(role);
        let found = format!("plane {plane}: {found}");
        findings.add_at(Problem::RecordTwice, start + 5 * second, found);
    }
}

/// Reports texels of predicted JPEG planes so close to 0 or 255 that they may wrap around in a decoder with another inverse DCT.
///
/// An inverse DCT may be off by one in every plane of a prediction chain, except in constant blocks, for which all decoders
/// agree. Texels that a record corrects are exact.
fn check_wraparound(findings: &mut Findings, streams: &Streams) {
    let dissection = findings.dissection;
    let (Ok(ptm), Some(size)) = (&dissection.outcome, dissection.size) else {
        return;
    };
    let channels = ptm.planes.shape.channels();
    let reference = |plane| usize::try_from(dissection.number(Role::Reference(plane))?).ok();
    if (0..channels).all(|plane| reference(plane).is_none()) {
        return;
    }
    let mut max_deviation = vec![0u8; channels];
    for (plane, residuals) in streams.residuals() {
        let width = size.width as usize;
        let first_of_block = |i: usize| residuals[i / width / 8 * 8 * width + i % width / 8 * 8];
        let is_exact = (0..residuals.len()).all(|i| residuals[i] == first_of_block(i));
        let reference = reference(plane);
        max_deviation[plane] =
            u8::from(!is_exact) + reference.map_or(0, |reference| max_deviation[reference]);
        if reference.is_none() || max_deviation[plane] == 0 {
            continue;
        }
        let limit = max_deviation[plane];
        let samples = ptm.planes.samples.iter().skip(plane).step_by(channels);
        let is_near_limit = |&sample: &u8| sample < limit || 255 - sample < limit;
        let mut texels: Vec<bool> = samples.map(is_near_limit).collect();
        let side = dissection.bytes(Role::Side(plane)).unwrap_or_default();
        for (position, _) in parse_records(side, 0, size.texels()).unwrap_or_default() {
            texels[texel_index(size, position)] = false;
        }
        if let Some(first) = texels.iter().position(|&flag| flag) {
            let count = texels.iter().filter(|&&flag| flag).count();
            let texel = describe_position(size, first);
            let found = format!("{count} texels within {limit} of 0 or 255, the first at {texel}");
            let found = format!("plane {plane}: {found}");
            findings.add(Problem::OtherTransform, Role::Stream(plane), found);
        }
    }
}

/// Keeps the first finding of each code and counts the others, because usually all planes have the same property.
fn merge_by_code(diagnostics: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let mut kept: Vec<(Diagnostic, usize)> = Vec::new();
    for diagnostic in diagnostics {
        let mut known = kept.iter_mut();
        match known.find(|(first, _)| first.code == diagnostic.code) {
            Some((_, others)) => *others += 1,
            None => kept.push((diagnostic, 0)),
        }
    }
    for (diagnostic, others) in kept.iter_mut().filter(|(_, others)| *others > 0) {
        diagnostic.found = format!("{}; and {others} more", diagnostic.found);
    }
    kept.into_iter().map(|(diagnostic, _)| diagnostic).collect()
}
