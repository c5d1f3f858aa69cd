//! The planes of a compressed file: faults of each, and what their lists and streams have that is odd.

use super::codes::Problem;
use super::diagnostic::Diagnostic;
use crate::codec::{self, jpeg, jpeg_ls};
use crate::decode::Streams;
use crate::decode::planes::records;
use crate::error::Kind;
use crate::ptm::{Format, Size};
use crate::tools::dissection::{Dissection, FilePart, Role};
use crate::tools::segments::{Segment, SegmentKind, frame, near, segments};

/// What is odd about lists and streams.
pub(super) fn diagnose(dissection: &Dissection, streams: Option<&Streams>) -> Vec<Diagnostic> {
    let count = dissection.compressed_planes();
    let (Some(format), true) = (
        dissection.format,
        count > 0 && dissection.part(Role::SideSize(count - 1)).is_some(),
    ) else {
        return Vec::new();
    };
    let mut diagnostics = [
        ranks(dissection, count),
        parameter(dissection, format),
        unused(dissection, count),
    ]
    .concat();
    for plane in 0..count {
        diagnostics.extend(stream(dissection, plane));
        diagnostics.extend(twice(dissection, plane));
    }
    if let Some(streams) = streams.filter(|_| is_jpeg(format)) {
        diagnostics.extend(other_transforms(dissection, streams));
    }
    first_of_each(diagnostics)
}

/// The faults of all planes, where the reference stops at the first.
pub(super) fn faults(dissection: &Dissection) -> Vec<Diagnostic> {
    let (Some(format), Some(size)) = (dissection.format, dissection.size) else {
        return Vec::new();
    };
    let mut diagnostics = Vec::new();
    for plane in 0..dissection.compressed_planes() {
        if let Some(part) = dissection.part(Role::Stream(plane)) {
            let stream = &dissection.file[part.range.clone()];
            if let Err(error) = decode(format, stream, size) {
                let code = stream_code(format, stream, size, &error);
                let at = part.range.start + error.offset;
                let found = format!("plane {plane}: {}", error.what);
                diagnostics.push(Diagnostic::new(code, at, found));
            }
        }
        if let Some(part) = dissection.part(Role::Side(plane)) {
            let block = &dissection.file[part.range.clone()];
            if let Err(error) = records(block, part.range.start, size.texels()) {
                let code = match error.kind() {
                    Kind::PartialRecord { .. } => Problem::RecordCut,
                    _ => Problem::Position,
                };
                let found = format!("plane {plane}: {}", error.kind());
                diagnostics.push(Diagnostic::new(code, error.offset(), found));
            }
        }
    }
    diagnostics
}

fn decode(format: Format, stream: &[u8], size: Size) -> Result<Vec<u8>, codec::StreamError> {
    if is_jpeg(format) {
        jpeg::decode(stream, size.width, size.height)
    } else {
        jpeg_ls::decode(stream, size.width, size.height)
    }
}

fn is_jpeg(format: Format) -> bool {
    matches!(format, Format::JpegRgb | Format::JpegLrgb)
}

/// What is wrong with a stream that the codec refuses, by what its markers say.
fn stream_code(format: Format, stream: &[u8], size: Size, error: &codec::StreamError) -> Problem {
    if error.fault == codec::StreamFault::Unsupported {
        return Problem::StreamKind;
    }
    let parts = segments(stream);
    if !stream.starts_with(&[0xff, 0xd8]) {
        return Problem::NotAStream;
    }
    match frame(stream, &parts) {
        Some((code, ..)) if (code == 0xf7) == is_jpeg(format) => Problem::NotAStream,
        Some((_, _, height, width, components))
            if (u32::from(width), u32::from(height), components)
                != (size.width, size.height, 1) =>
        {
            Problem::OtherPicture
        }
        _ => Problem::StreamDamaged,
    }
}

/// Ranks that repeat, leave gaps or begin elsewhere; references below −1 (ruling `ranks`).
fn ranks(dissection: &Dissection, count: usize) -> Vec<Diagnostic> {
    let number = |role| dissection.number(role).unwrap_or_default();
    let ranks: Vec<i64> = (0..count).map(|plane| number(Role::Rank(plane))).collect();
    let mut sorted = ranks.clone();
    sorted.sort_unstable();
    let mut diagnostics = Vec::new();
    if !sorted.iter().copied().eq((0..).take(count)) {
        let words: Vec<String> = ranks.iter().map(i64::to_string).collect();
        diagnostics.push(Diagnostic::new(
            Problem::Ranks,
            dissection.start(Role::Rank(0)),
            format!("ranks {}", words.join(" ")),
        ));
    }
    if let Some(plane) = (0..count).find(|&plane| number(Role::Reference(plane)) < -1) {
        let found = format!(
            "the reference of plane {plane} is {}",
            number(Role::Reference(plane))
        );
        diagnostics.push(Diagnostic::new(
            Problem::Ranks,
            dissection.start(Role::Reference(plane)),
            found,
        ));
    }
    diagnostics
}

/// The parameter (clause 2.9.1/2).
fn parameter(dissection: &Dissection, format: Format) -> Vec<Diagnostic> {
    let range = if is_jpeg(format) { 20..=100 } else { 0..=127 };
    let value = dissection.number(Role::Parameter);
    let Some(value) = value.filter(|value| !range.contains(value)) else {
        return Vec::new();
    };
    let found = format!("{value}, expected {} to {}", range.start(), range.end());
    let at = dissection.start(Role::Parameter);
    vec![Diagnostic::new(Problem::Parameter, at, found)]
}

/// Transforms and vectors without an effect.
fn unused(dissection: &Dissection, count: usize) -> Vec<Diagnostic> {
    let number = |role| dissection.number(role).unwrap_or_default();
    let idle = |plane: usize| {
        let (transform, intra) = (
            number(Role::Transform(plane)),
            number(Role::Reference(plane)) < 0,
        );
        let vector = (number(Role::MotionX(plane)), number(Role::MotionY(plane)));
        (intra && transform != 0) || (vector != (0, 0) && (intra || transform & 2 == 0))
    };
    let planes: Vec<usize> = (0..count).filter(|&plane| idle(plane)).collect();
    let Some(&first) = planes.first() else {
        return Vec::new();
    };
    let words: Vec<String> = planes.iter().map(usize::to_string).collect();
    let at = dissection.start(Role::Transform(first));
    let found = format!("planes {}", words.join(", "));
    vec![Diagnostic::new(Problem::PredictionUnused, at, found)]
}

/// What a stream has besides what an encoder of planes writes (ruling `plane-odd`).
fn stream(dissection: &Dissection, plane: usize) -> Vec<Diagnostic> {
    let (Some(part), Some(format)) = (dissection.part(Role::Stream(plane)), dissection.format)
    else {
        return Vec::new();
    };
    let stream = &dissection.file[part.range.clone()];
    if !stream.starts_with(&[0xff, 0xd8]) {
        return Vec::new();
    }
    let parts = segments(stream);
    let odd = parts.iter().filter_map(|segment| {
        let code = odd_segment(format, segment, stream)?;
        let says = if segment.says.is_empty() {
            String::new()
        } else {
            format!(" ({})", segment.says)
        };
        Some(Diagnostic::new(
            code,
            part.range.start + segment.range.start,
            format!("plane {plane}: {}{says}", segment.kind.label().0),
        ))
    });
    odd.chain(other_near(dissection, plane, part, stream, &parts))
        .collect()
}

fn odd_segment(format: Format, segment: &Segment, stream: &[u8]) -> Option<Problem> {
    let jfif = is_jpeg(format) && segment.kind == SegmentKind::Marker(0xe0);
    match segment.kind {
        SegmentKind::Marker(0xe0..=0xef | 0xfe) if !jfif => Some(Problem::StreamExtras),
        SegmentKind::Fill => Some(Problem::StreamExtras),
        SegmentKind::Marker(0xdd) => Some(Problem::Restarts),
        SegmentKind::Behind => Some(Problem::StreamTrailing),
        // LSE of type 1 with MAXVAL below 255; 0 stands for the largest there is (T.87 C.2.4.1.1).
        SegmentKind::Marker(0xf8) => match stream[segment.range.clone()] {
            [_, _, _, _, 1, high, low, ..] => ((1..255).contains(&u16::from_be_bytes([high, low])))
                .then_some(Problem::StreamMaxval),
            _ => None,
        },
        _ => None,
    }
}

/// A JPEG-LS stream whose NEAR is not the parameter.
fn other_near(
    dissection: &Dissection,
    plane: usize,
    part: &FilePart,
    stream: &[u8],
    parts: &[Segment],
) -> Option<Diagnostic> {
    let near = near(stream, parts)
        .filter(|_| frame(stream, parts).is_some_and(|(code, ..)| code == 0xf7))?;
    let parameter = dissection.number(Role::Parameter)?;
    (i64::from(near) != parameter).then(|| {
        let found = format!("plane {plane}: NEAR {near}, the parameter is {parameter}");
        Diagnostic::new(Problem::Near, part.range.start, found)
    })
}

/// A texel with two records (ruling `side-twice`).
fn twice(dissection: &Dissection, plane: usize) -> Option<Diagnostic> {
    let part = dissection.part(Role::Side(plane))?;
    let mut positions: Vec<(u32, usize)> =
        records(&dissection.file[part.range.clone()], 0, usize::MAX)
            .ok()?
            .iter()
            .enumerate()
            .map(|(record, &(position, _))| (position, record))
            .collect();
    positions.sort_unstable();
    let pair = positions
        .windows(2)
        .filter(|pair| pair[0].0 == pair[1].0)
        .min_by_key(|pair| pair[1].1)?;
    let (position, record) = pair[1];
    let found = format!(
        "plane {plane}: records {} and {record} are both of position {position}",
        pair[0].1
    );
    Some(Diagnostic::new(
        Problem::RecordTwice,
        part.range.start + 5 * record,
        found,
    ))
}

/// Texels of predicted JPEG planes so close to an end of the range that another inverse DCT may carry them to the other.
///
/// An inverse DCT may be off by one in every plane on the way, except in blocks of one value, which all decode alike;
/// and a corrected texel is certain.
fn other_transforms(dissection: &Dissection, streams: &Streams) -> Vec<Diagnostic> {
    let (Ok(ptm), Some(size)) = (&dissection.outcome, dissection.size) else {
        return Vec::new();
    };
    let channels = ptm.planes.shape.channels();
    let reference = |plane| usize::try_from(dissection.number(Role::Reference(plane))?).ok();
    if (0..channels).all(|plane| reference(plane).is_none()) {
        return Vec::new();
    }
    let mut slack = vec![0u8; channels];
    let mut diagnostics = Vec::new();
    for (plane, residuals) in streams.residuals() {
        let (reference, exact) = (
            reference(plane),
            in_blocks_of_one_value(residuals, size.width as usize),
        );
        slack[plane] = u8::from(!exact) + reference.map_or(0, |reference| slack[reference]);
        if reference.is_some() && slack[plane] > 0 {
            let samples = ptm.planes.samples.iter().skip(plane);
            let samples = samples.step_by(channels).copied();
            let side = dissection.bytes(Role::Side(plane)).unwrap_or_default();
            let found = near_an_end(samples, slack[plane], side, size);
            let found = found.map(|texels| format!("plane {plane}: {texels}"));
            let at = dissection.start(Role::Stream(plane));
            diagnostics
                .extend(found.map(|found| Diagnostic::new(Problem::OtherTransform, at, found)));
        }
    }
    diagnostics
}

/// The texels of a plane, top row first, that are within `slack` of 0 or 255 and that no record corrects.
fn near_an_end(
    samples: impl Iterator<Item = u8>,
    slack: u8,
    side: &[u8],
    size: Size,
) -> Option<String> {
    let near = |sample: u8| sample < slack || 255 - sample < slack;
    let mut texels: Vec<bool> = samples.map(near).collect();
    for &(position, _) in &records(side, 0, size.texels()).unwrap_or_default() {
        let (x, y) = (position % size.width, position / size.width);
        texels[((size.height - 1 - y) * size.width + x) as usize] = false;
    }
    let first = texels.iter().position(|&near| near)?;
    let width = size.width as usize;
    Some(format!(
        "{} texels within {slack} of 0 or 255, the first at column {}, row {} from the top",
        texels.iter().filter(|&&near| near).count(),
        first % width,
        first / width
    ))
}

fn in_blocks_of_one_value(samples: &[u8], width: usize) -> bool {
    let first_of_block = |at: usize| samples[at / width / 8 * 8 * width + at % width / 8 * 8];
    (0..samples.len()).all(|at| samples[at] == first_of_block(at))
}

/// One diagnostic of each code, with the number of its like: eighteen planes mostly have the same oddity.
#[expect(
    clippy::format_push_string,
    reason = "texts are short where they are put together"
)]
fn first_of_each(diagnostics: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let mut kept: Vec<(Diagnostic, usize)> = Vec::new();
    for diagnostic in diagnostics {
        match kept
            .iter_mut()
            .find(|(first, _)| first.code == diagnostic.code)
        {
            Some((_, like)) => *like += 1,
            None => kept.push((diagnostic, 0)),
        }
    }
    for (diagnostic, like) in kept.iter_mut().filter(|(_, like)| *like > 0) {
        diagnostic.found += &format!("; and {like} more such places");
    }
    kept.into_iter().map(|(diagnostic, _)| diagnostic).collect()
}
