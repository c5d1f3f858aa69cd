//! The first line of a frame and its samples, in all possible interpretations.

use crate::protocol::forms;
use crate::protocol::frame::{Samples, View, ViewKind};
use crate::suite::compare::Expected;

use super::message::{Interpretation, Slots, WrapperMistake, mistake};

/// Returns the mistakes in the first line, and the samples in all possible interpretations.
pub(super) fn body(
    bytes: &[u8],
    expected: &Expected,
    view: &View,
) -> Option<(Vec<WrapperMistake>, Vec<Interpretation>)> {
    if let Ok(frame) = forms::read(bytes, view, bytes.len().max(1 << 16)) {
        let kind = frame.samples.sample_type();
        let bytes = match &frame.samples {
            Samples::U8(values) => values.clone(),
            Samples::F32(values) => values
                .iter()
                .flat_map(|value| value.to_le_bytes())
                .collect(),
        };
        // A frame may be well-formed and its samples still be bytes of another type.
        let mut meant = interpretations(&bytes, expected);
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
    let (width, height) = (width.parse().ok()?, height.parse().ok()?);
    let shape = (width, height, channels.parse().ok()?);
    let mut mistakes = line_mistakes(name, shape, kind, expected);
    if line != words.join(" ") {
        mistakes.push(mistake("spaces", &[]));
    }
    Some((mistakes, interpretations(&bytes[end + 1..], expected)))
}

/// Returns the mistakes in the words of the first line.
fn line_mistakes(
    name: &str,
    (width, height, channels): (u32, u32, u32),
    kind: &str,
    expected: &Expected,
) -> Vec<WrapperMistake> {
    let (size, view, right_kind) = (
        expected.size,
        expected.view.name(),
        expected.view.sample_type(),
    );
    let is_light = name.starts_with("rgb:") && view == "rgb";
    let is_exchanged = (width, height) == (size.height, size.width) && width != height;
    let is_wrong_size = !is_exchanged && (width, height) != (size.width, size.height);
    let shown = format!("{name:?}");
    let right_size = format!("{} x {}", size.width, size.height);
    let named: &Slots = &[("expected", &view), ("name", &shown)];
    let sized: &Slots = &[
        ("width", &width),
        ("height", &height),
        ("size", &right_size),
    ];
    let counted: &Slots = &[("channels", &channels), ("expected", &expected.channels)];
    let typed: &Slots = &[("expected", &right_kind), ("kind", &kind)];
    let mistakes = [
        (is_light, "view-with-light", named),
        (!is_light && name != view, "wrong-view", named),
        (is_exchanged, "size-exchanged", &[]),
        (is_wrong_size, "wrong-size", sized),
        (
            channels != expected.channels as u32,
            "wrong-channels",
            counted,
        ),
        (kind != right_kind, "wrong-type", typed),
    ];
    let made = mistakes.into_iter().filter(|(is_made, ..)| *is_made);
    made.map(|(_, name, slots)| mistake(name, slots)).collect()
}

/// Returns the numbers that the bytes of the samples may represent.
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

/// Reads samples of the right type, with an optional line end after them.
fn plain(bytes: &[u8], count: usize, is_real: bool) -> Vec<Interpretation> {
    let size = if is_real { 4 * count } else { count };
    let Some(rest @ 0..=2) = bytes.len().checked_sub(size) else {
        return Vec::new();
    };
    let (samples, trailing) = bytes.split_at(size);
    let values = match is_real {
        true => floats(samples, f32::from_le_bytes),
        false => samples.iter().map(|&byte| byte.into()).collect(),
    };
    let says = || mistake("trailing-bytes", &[("rest", &trailing.escape_ascii())]);
    vec![(values, (rest > 0).then(says).into_iter().collect())]
}

/// Reads four bytes per sample: big-endian floats, or floats instead of bytes, perhaps from 0 to 1.
fn wide(bytes: &[u8], count: usize, is_real: bool) -> Vec<Interpretation> {
    if bytes.len() != 4 * count {
        return Vec::new();
    }
    if is_real {
        let says = mistake("big-endian", &[]);
        return vec![(floats(bytes, f32::from_be_bytes), vec![says])];
    }
    let orders: [(fn([u8; 4]) -> f32, _); 2] =
        [(f32::from_le_bytes, "low"), (f32::from_be_bytes, "high")];
    let both = orders.into_iter().flat_map(|(read, order)| {
        let values = floats(bytes, read);
        [("floats", 1.0), ("fractions", 255.0)].map(|(name, factor)| {
            let rounded = values.iter().map(|value| (value * factor).round());
            (rounded.collect(), vec![mistake(name, &[("order", &order)])])
        })
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
        (
            values.collect(),
            vec![mistake("doubles", &[("order", &order)])],
        )
    });
    both.collect()
}

/// Reads colors of four samples.
fn with_alpha(bytes: &[u8], expected: &Expected) -> Vec<Interpretation> {
    if expected.view != ViewKind::Rgb || bytes.len() != 4 * expected.size.texels() {
        return Vec::new();
    }
    let both = [(3, "last"), (0, "first")]
        .into_iter()
        .map(|(alpha, place)| {
            let kept = bytes.iter().enumerate().filter(|(i, _)| i % 4 != alpha);
            let says = mistake("alpha", &[("place", &place)]);
            (kept.map(|(_, &byte)| byte.into()).collect(), vec![says])
        });
    both.collect()
}

fn in_ascii(bytes: &[u8]) -> Option<Interpretation> {
    let text = std::str::from_utf8(bytes).ok()?;
    let words = text.split(|c: char| c.is_whitespace() || c == ',');
    let words = words.filter(|word| !word.is_empty());
    let values: Result<Vec<f64>, _> = words.map(str::parse).collect();
    Some((values.ok()?, vec![mistake("ascii", &[])]))
}

fn floats(bytes: &[u8], read: fn([u8; 4]) -> f32) -> Vec<f64> {
    let samples = bytes.as_chunks::<4>().0.iter();
    samples.map(|&sample| read(sample).into()).collect()
}
