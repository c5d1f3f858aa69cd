//! The first line of a frame and its samples, in every way in which they may be meant.

use crate::protocol::forms;
use crate::protocol::frame::{Samples, View, ViewKind};
use crate::suite::compare::Expected;

use super::mistake::{Interpretation, Mistake, mistake};

/// What is wrong with the first line, and the samples in every way in which they may be meant.
pub(super) fn body(
    bytes: &[u8],
    expected: &Expected,
    view: &View,
) -> Option<(Vec<Mistake>, Vec<Interpretation>)> {
    if let Ok(frame) = forms::read(bytes, view, bytes.len().max(1 << 16)) {
        let kind = frame.samples.sample_type();
        // A frame may be well-formed and its samples still be bytes of something else.
        let mut meant = interpretations(&bytes_of(&frame.samples), expected);
        if kind == expected.view.sample_type() {
            meant.push((frame.samples.to_reals(), Vec::new()));
        }
        let shape = (frame.width, frame.height, frame.channels);
        return Some((
            line_mistakes(frame.view.name(), shape, kind, expected),
            meant,
        ));
    }
    let end = bytes.iter().position(|&byte| byte == b'\n')?;
    let line = std::str::from_utf8(&bytes[..end]).ok()?;
    if line.ends_with('\r') {
        return None;
    }
    let words: Vec<&str> = line.split_whitespace().collect();
    let ["PTM1", name, width, height, channels, kind] = words[..] else {
        return None;
    };
    let shape = (
        width.parse().ok()?,
        height.parse().ok()?,
        channels.parse().ok()?,
    );
    let mut mistakes = line_mistakes(name, shape, kind, expected);
    if line != words.join(" ") {
        mistakes.push(mistake(
            "the words of its first line are not separated by single spaces",
            "write \"PTM1 VIEW WIDTH HEIGHT CHANNELS TYPE\" with exactly one space between two words",
        ));
    }
    Some((mistakes, interpretations(&bytes[end + 1..], expected)))
}

fn bytes_of(samples: &Samples) -> Vec<u8> {
    match samples {
        Samples::U8(values) => values.clone(),
        Samples::F32(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
    }
}

/// What is wrong with the words of the first line.
fn line_mistakes(
    name: &str,
    (width, height, channels): (u32, u32, u32),
    kind: &str,
    expected: &Expected,
) -> Vec<Mistake> {
    let (size, right_kind) = (expected.size, expected.view.sample_type());
    let mut mistakes: Vec<Mistake> = view_mistake(name, expected).into_iter().collect();
    if (width, height) == (size.height, size.width) && width != height {
        mistakes.push(mistake(
            "its first line has height and width exchanged",
            "the width stands before the height",
        ));
    } else if (width, height) != (size.width, size.height) {
        mistakes.push(mistake(
            format!(
                "its first line says {width} x {height} where the file is {} x {}",
                size.width, size.height
            ),
            "width and height are those of the file",
        ));
    }
    if channels != expected.channels as u32 {
        mistakes.push(mistake(
            format!(
                "its first line says {channels} channels instead of {}",
                expected.channels
            ),
            "channels: 18 for RGB, 9 for LRGB and tables, 8 for LUM; 3 for rgb",
        ));
    }
    if kind != right_kind {
        mistakes.push(mistake(
            format!("its first line says the type is {kind} instead of {right_kind}"),
            "types: u8 for raw and rgb, f32 for coef",
        ));
    }
    mistakes
}

fn view_mistake(name: &str, expected: &Expected) -> Option<Mistake> {
    let right = expected.view.name();
    if name.starts_with("rgb:") && expected.view == ViewKind::Rgb {
        return Some(mistake(
            format!("its first line says {name:?}"),
            "the line has rgb alone, without the light",
        ));
    }
    (name != right).then(|| {
        mistake(
            format!("its first line says {name:?} where {right} is asked for"),
            "the line names the view that was asked for: raw, coef or rgb",
        )
    })
}

/// The numbers that the bytes of the samples may mean.
fn interpretations(bytes: &[u8], expected: &Expected) -> Vec<Interpretation> {
    let is_real = expected.view.sample_type() == "f32";
    let count = expected.size.texels() * expected.channels;
    let ways = [
        plain(bytes, count, is_real),
        wide(bytes, count, is_real),
        doubles(bytes, count, is_real),
        with_alpha(bytes, expected),
        in_ascii(bytes).into_iter().collect(),
    ];
    ways.concat()
}

const LITTLE_ENDIAN_FLOATS: &str = "samples are 4-byte floats, low byte first: '<f4' in NumPy, \"<f\" in Python's struct, LITTLE_ENDIAN in Java";

/// The right type, perhaps with a line end after the samples.
fn plain(bytes: &[u8], count: usize, is_real: bool) -> Vec<Interpretation> {
    let values = |bytes: &[u8]| -> Vec<f64> {
        match is_real {
            true => floats(bytes, f32::from_le_bytes),
            false => bytes.iter().map(|&byte| byte.into()).collect(),
        }
    };
    let size = if is_real { 4 * count } else { count };
    match bytes.len().checked_sub(size) {
        Some(0) => vec![(values(bytes), Vec::new())],
        Some(1 | 2) => {
            let (samples, rest) = bytes.split_at(size);
            let says = format!("it prints \"{}\" after the samples", rest.escape_ascii());
            let next = "print nothing after the samples: write, not println or puts";
            vec![(values(samples), vec![mistake(says, next)])]
        }
        _ => Vec::new(),
    }
}

/// Four bytes a sample: floats in the other byte order, or floats where bytes are right, perhaps from 0 to 1.
fn wide(bytes: &[u8], count: usize, is_real: bool) -> Vec<Interpretation> {
    if bytes.len() != 4 * count {
        return Vec::new();
    }
    if is_real {
        let says = mistake("its f32 have the high byte first", LITTLE_ENDIAN_FLOATS);
        return vec![(floats(bytes, f32::from_be_bytes), vec![says])];
    }
    let orders: [(fn([u8; 4]) -> f32, _); 2] =
        [(f32::from_le_bytes, "low"), (f32::from_be_bytes, "high")];
    let next = "one byte for each sample, from 0 to 255";
    let both = orders.into_iter().flat_map(|(read, order)| {
        let says = format!("its samples are f32, {order} byte first, where u8 is asked for");
        let values = floats(bytes, read);
        let full = values.iter().map(|value| (value * 255.0).round()).collect();
        let fraction = mistake(format!("{says}, from 0 to 1"), next);
        let rounded = values.iter().map(|value| value.round()).collect();
        [(rounded, vec![mistake(says, next)]), (full, vec![fraction])]
    });
    both.collect()
}

fn doubles(bytes: &[u8], count: usize, is_real: bool) -> Vec<Interpretation> {
    if bytes.len() != 8 * count {
        return Vec::new();
    }
    let orders: [(fn([u8; 8]) -> f64, _); 2] =
        [(f64::from_le_bytes, "low"), (f64::from_be_bytes, "high")];
    let both = orders.into_iter().map(|(read, order)| {
        let samples = bytes.as_chunks::<8>().0.iter();
        let samples = samples.map(|&sample| read(sample));
        let values = samples.map(|value| if is_real { value } else { value.round() });
        let says = format!("its samples are f64, {order} byte first");
        (values.collect(), vec![mistake(says, LITTLE_ENDIAN_FLOATS)])
    });
    both.collect()
}

/// Colors of four samples.
fn with_alpha(bytes: &[u8], expected: &Expected) -> Vec<Interpretation> {
    let is_color = expected.view == ViewKind::Rgb;
    if !is_color || bytes.len() != 4 * expected.size.texels() {
        return Vec::new();
    }
    let both = [(3, "last"), (0, "first")]
        .into_iter()
        .map(|(alpha, name)| {
            let kept = bytes.iter().enumerate().filter(|(i, _)| i % 4 != alpha);
            let says = format!("its texels have four samples; the {name} is no color (alpha?)");
            let mistake = mistake(says, "three samples a texel: red, green, blue");
            (kept.map(|(_, &byte)| byte.into()).collect(), vec![mistake])
        });
    both.collect()
}

fn in_ascii(bytes: &[u8]) -> Option<Interpretation> {
    let text = std::str::from_utf8(bytes).ok()?;
    let words = text.split(|c: char| c.is_whitespace() || c == ',');
    let values: Result<Vec<f64>, _> = words
        .filter(|word| !word.is_empty())
        .map(str::parse)
        .collect();
    let says = mistake("its samples are numbers in ASCII", "write samples as bytes");
    Some((values.ok()?, vec![says]))
}

fn floats(bytes: &[u8], read: fn([u8; 4]) -> f32) -> Vec<f64> {
    let samples = bytes.as_chunks::<4>().0.iter();
    samples.map(|&sample| read(sample).into()).collect()
}
