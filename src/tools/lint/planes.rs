//! The planes of a compressed file: faults of each, and what their lists and streams have that is odd.

use super::Finding;
use super::codes::{self, Code};
use super::errors;
use crate::codec::{self, jpeg, jpeg_ls};
use crate::decode::planes::records;
use crate::error::Kind as ErrorKind;
use crate::ptm::{Format, Size};
use crate::tools::anatomy::{Anatomy, Part, Role};
use crate::tools::segments::{Kind, Segment, frame, near, segments};

/// What is odd about lists and streams.
pub(super) fn find(anatomy: &Anatomy) -> Vec<Finding> {
    let count = errors::planes(anatomy.format);
    let (Some(format), true) = (
        anatomy.format,
        count > 0 && anatomy.part(Role::SideSize(count - 1)).is_some(),
    ) else {
        return Vec::new();
    };
    let mut findings = [
        ranks(anatomy, count),
        parameter(anatomy, format),
        unused(anatomy, count),
    ]
    .concat();
    for plane in 0..count {
        findings.extend(stream(anatomy, plane));
        findings.extend(twice(anatomy, plane));
    }
    findings.extend(other_transforms(anatomy, format));
    first_of_each(findings)
}

/// The faults of all planes, where the reference stops at the first.
pub(super) fn faults(anatomy: &Anatomy) -> Vec<Finding> {
    let (Some(format), Some(size)) = (anatomy.format, anatomy.size) else {
        return Vec::new();
    };
    let mut findings = Vec::new();
    for plane in 0..errors::planes(anatomy.format) {
        if let Some(part) = anatomy.part(Role::Stream(plane)) {
            let stream = &anatomy.file[part.range.clone()];
            if let Err(error) = decode(format, stream, size) {
                findings.push(Finding::new(
                    stream_code(format, stream, size, &error),
                    part.range.start + error.offset,
                    format!("plane {plane}: {}", error.what),
                ));
            }
        }
        if let Some(part) = anatomy.part(Role::Side(plane))
            && let Err(error) = records(
                &anatomy.file[part.range.clone()],
                part.range.start,
                size.texels(),
            )
        {
            let code = match error.kind() {
                ErrorKind::PartialRecord { .. } => &codes::RECORD_CUT,
                _ => &codes::POSITION,
            };
            findings.push(Finding::new(
                code,
                error.offset(),
                format!("plane {plane}: {}", error.kind()),
            ));
        }
    }
    findings
}

fn decode(format: Format, stream: &[u8], size: Size) -> Result<Vec<u8>, codec::Error> {
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
fn stream_code(format: Format, stream: &[u8], size: Size, error: &codec::Error) -> &'static Code {
    if error.class == codec::Class::Unsupported {
        return &codes::STREAM_KIND;
    }
    let parts = segments(stream);
    if !stream.starts_with(&[0xff, 0xd8]) {
        return &codes::NOT_A_STREAM;
    }
    match frame(stream, &parts) {
        Some((code, ..)) if (code == 0xf7) == is_jpeg(format) => &codes::NOT_A_STREAM,
        Some((_, _, height, width, components))
            if (u32::from(width), u32::from(height), components)
                != (size.width, size.height, 1) =>
        {
            &codes::OTHER_PICTURE
        }
        _ => &codes::STREAM_DAMAGED,
    }
}

/// Ranks that repeat, leave gaps or begin elsewhere; references below −1 (ruling `ranks`).
fn ranks(anatomy: &Anatomy, count: usize) -> Vec<Finding> {
    let number = |role| anatomy.number(role).unwrap_or_default();
    let at = |role| anatomy.part(role).map_or(0, |part| part.range.start);
    let ranks: Vec<i64> = (0..count).map(|plane| number(Role::Rank(plane))).collect();
    let mut sorted = ranks.clone();
    sorted.sort_unstable();
    let mut findings = Vec::new();
    if !sorted.iter().copied().eq((0..).take(count)) {
        let words: Vec<String> = ranks.iter().map(i64::to_string).collect();
        findings.push(Finding::new(
            &codes::RANKS,
            at(Role::Rank(0)),
            format!("ranks {}", words.join(" ")),
        ));
    }
    if let Some(plane) = (0..count).find(|&plane| number(Role::Reference(plane)) < -1) {
        let found = format!(
            "the reference of plane {plane} is {}",
            number(Role::Reference(plane))
        );
        findings.push(Finding::new(
            &codes::RANKS,
            at(Role::Reference(plane)),
            found,
        ));
    }
    findings
}

/// The parameter (clause 2.9.1/2).
fn parameter(anatomy: &Anatomy, format: Format) -> Vec<Finding> {
    let (Some(part), Some(value)) = (
        anatomy.part(Role::Parameter),
        anatomy.number(Role::Parameter),
    ) else {
        return Vec::new();
    };
    let range = if is_jpeg(format) { 20..=100 } else { 0..=127 };
    if range.contains(&value) {
        return Vec::new();
    }
    let found = format!("{value}, expected {} to {}", range.start(), range.end());
    vec![Finding::new(&codes::PARAMETER, part.range.start, found)]
}

/// Transforms and vectors without an effect.
fn unused(anatomy: &Anatomy, count: usize) -> Vec<Finding> {
    let number = |role| anatomy.number(role).unwrap_or_default();
    let idle = |plane: usize| {
        let (transform, intra) = (
            number(Role::Transform(plane)),
            number(Role::Reference(plane)) < 0,
        );
        let vector = (number(Role::MotionX(plane)), number(Role::MotionY(plane)));
        (intra && transform != 0) || (vector != (0, 0) && (intra || transform & 2 == 0))
    };
    let planes: Vec<usize> = (0..count).filter(|&plane| idle(plane)).collect();
    let first = planes
        .first()
        .and_then(|&plane| anatomy.part(Role::Transform(plane)));
    first.map_or_else(Vec::new, |part| {
        let words: Vec<String> = planes.iter().map(usize::to_string).collect();
        vec![Finding::new(
            &codes::PREDICTION_UNUSED,
            part.range.start,
            format!("planes {}", words.join(", ")),
        )]
    })
}

/// What a stream has besides what an encoder of planes writes (ruling `plane-odd`).
fn stream(anatomy: &Anatomy, plane: usize) -> Vec<Finding> {
    let (Some(part), Some(format)) = (anatomy.part(Role::Stream(plane)), anatomy.format) else {
        return Vec::new();
    };
    let stream = &anatomy.file[part.range.clone()];
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
        Some(Finding::new(
            code,
            part.range.start + segment.range.start,
            format!("plane {plane}: {}{says}", segment.kind.name()),
        ))
    });
    odd.chain(other_near(anatomy, plane, part, stream, &parts))
        .collect()
}

fn odd_segment(format: Format, segment: &Segment, stream: &[u8]) -> Option<&'static Code> {
    let jfif = is_jpeg(format) && segment.kind == Kind::Marker(0xe0);
    match segment.kind {
        Kind::Marker(0xe0..=0xef | 0xfe) if !jfif => Some(&codes::STREAM_EXTRAS),
        Kind::Fill => Some(&codes::STREAM_EXTRAS),
        Kind::Marker(0xdd) => Some(&codes::RESTARTS),
        Kind::Behind => Some(&codes::STREAM_TRAILING),
        // LSE of type 1 with MAXVAL below 255; 0 stands for the largest there is (T.87 C.2.4.1.1).
        Kind::Marker(0xf8) => match stream[segment.range.clone()] {
            [_, _, _, _, 1, high, low, ..] => ((1..255).contains(&u16::from_be_bytes([high, low])))
                .then_some(&codes::STREAM_MAXVAL),
            _ => None,
        },
        _ => None,
    }
}

/// A JPEG-LS stream whose NEAR is not the parameter.
fn other_near(
    anatomy: &Anatomy,
    plane: usize,
    part: &Part,
    stream: &[u8],
    parts: &[Segment],
) -> Option<Finding> {
    let near = near(stream, parts)
        .filter(|_| frame(stream, parts).is_some_and(|(code, ..)| code == 0xf7))?;
    let parameter = anatomy.number(Role::Parameter)?;
    (i64::from(near) != parameter).then(|| {
        let found = format!("plane {plane}: NEAR {near}, the parameter is {parameter}");
        Finding::new(&codes::NEAR, part.range.start, found)
    })
}

/// A texel with two records (ruling `side-twice`).
fn twice(anatomy: &Anatomy, plane: usize) -> Option<Finding> {
    let part = anatomy.part(Role::Side(plane))?;
    let mut positions: Vec<(u32, usize)> =
        records(&anatomy.file[part.range.clone()], 0, usize::MAX)
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
    Some(Finding::new(
        &codes::RECORD_TWICE,
        part.range.start + 5 * record,
        found,
    ))
}

/// Texels of predicted JPEG planes so near to an end of the scale that another inverse DCT may carry them to the other.
///
/// An inverse DCT may be off by one in every plane on the way, save in blocks of one value, which all give back alike;
/// and a corrected texel is certain.
fn other_transforms(anatomy: &Anatomy, format: Format) -> Vec<Finding> {
    let (Ok(ptm), Some(size), true) = (&anatomy.outcome, anatomy.size, is_jpeg(format)) else {
        return Vec::new();
    };
    let number = |role| anatomy.number(role).unwrap_or_default();
    let count = format.channels();
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|&plane| number(Role::Rank(plane)));
    let mut slack = vec![0u8; count];
    let mut findings = Vec::new();
    for plane in order {
        let Some(part) = anatomy.part(Role::Stream(plane)) else {
            continue;
        };
        let exact = decode(format, &anatomy.file[part.range.clone()], size)
            .is_ok_and(|samples| in_blocks_of_one_value(&samples, size.width as usize));
        let reference = usize::try_from(number(Role::Reference(plane))).ok();
        slack[plane] = u8::from(!exact) + reference.map_or(0, |reference| slack[reference]);
        if reference.is_none() || slack[plane] == 0 {
            continue;
        }
        let mut texels: Vec<bool> = (0..size.texels())
            .map(|texel| {
                let sample = ptm.planes.samples[texel * count + plane];
                sample < slack[plane] || 255 - sample < slack[plane]
            })
            .collect();
        let side = anatomy.bytes(Role::Side(plane)).unwrap_or_default();
        for &(position, _) in &records(side, 0, size.texels()).unwrap_or_default() {
            let (x, y) = (
                position % size.width,
                size.height - 1 - position / size.width,
            );
            texels[(y * size.width + x) as usize] = false;
        }
        if let Some(first) = texels.iter().position(|&near| near) {
            let found = format!(
                "plane {plane}: {} texels within {} of 0 or 255, the first at column {}, row {} from the top",
                texels.iter().filter(|&&near| near).count(),
                slack[plane],
                first % size.width as usize,
                first / size.width as usize
            );
            findings.push(Finding::new(
                &codes::OTHER_TRANSFORM,
                part.range.start,
                found,
            ));
        }
    }
    findings
}

fn in_blocks_of_one_value(samples: &[u8], width: usize) -> bool {
    let first_of_block = |at: usize| samples[at / width / 8 * 8 * width + at % width / 8 * 8];
    (0..samples.len()).all(|at| samples[at] == first_of_block(at))
}

/// One finding of each code, with the number of its like: eighteen planes mostly have the same oddity.
fn first_of_each(findings: Vec<Finding>) -> Vec<Finding> {
    let mut kept: Vec<(Finding, usize)> = Vec::new();
    for finding in findings {
        match kept
            .iter_mut()
            .find(|(first, _)| first.code.id == finding.code.id)
        {
            Some((_, like)) => *like += 1,
            None => kept.push((finding, 0)),
        }
    }
    let worded = |(mut finding, like): (Finding, usize)| {
        if like > 0 {
            finding.what = format!("{}; and {like} more such places", finding.what);
        }
        finding
    };
    kept.into_iter().map(worded).collect()
}
