//! All possible interpretations of a malformed frame.

use ptm_suite::compare::Expected;
use ptm_suite::protocol::forms;
use ptm_suite::protocol::frame::{Samples, View, ViewKind};

use super::message::{ProbeFault, Slots, fault};

/// Samples as numbers, and the mistakes that were undone to read the samples.
pub(super) type Interpretation = (Vec<f64>, Vec<ProbeFault>);

/// Returns the mistakes in the first line, and the samples in all possible interpretations.
pub(super) fn interpret_frame(
    bytes: &[u8],
    expected: &Expected,
    view: &View,
) -> Option<(Vec<ProbeFault>, Vec<Interpretation>)> {
    if let Ok(frame) = forms::read(bytes, view, bytes.len().max(1 << 16)) {
        let kind = frame.samples.sample_type();
        let bytes = match &frame.samples {
            Samples::U8(values) => values.clone(),
            Samples::F32(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
        };
        // A frame may be well-formed even if its samples are bytes of a different type.
        let mut results = interpretations(&bytes, expected);
        if kind == expected.view.sample_type() {
            results.push((frame.samples.to_reals(), Vec::new()));
        }
        let shape = (frame.width, frame.height, frame.channels);
        let mistakes = line_mistakes(frame.view.name(), shape, kind, expected);
        return Some((mistakes, results));
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
        mistakes.push(fault("spaces", &[]));
    }
    Some((mistakes, interpretations(&bytes[end + 1..], expected)))
}

/// Returns the mistakes in the words of the first line of the frame.
fn line_mistakes(
    name: &str,
    (width, height, channels): (u32, u32, u32),
    kind: &str,
    expected: &Expected,
) -> Vec<ProbeFault> {
    let (size, view) = (expected.size, expected.view.name());
    let right_kind = expected.view.sample_type();
    let is_light = name.starts_with("rgb:") && view == "rgb";
    let is_swapped = (width, height) == (size.height, size.width) && width != height;
    let is_wrong_size = !is_swapped && (width, height) != (size.width, size.height);
    let is_wrong_count = channels != expected.channels as u32;
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
        (is_swapped, "size-exchanged", &[]),
        (is_wrong_size, "wrong-size", sized),
        (is_wrong_count, "wrong-channels", counted),
        (kind != right_kind, "wrong-type", typed),
    ];
    let made = mistakes.into_iter().filter(|(is_made, ..)| *is_made);
    made.map(|(_, name, slots)| fault(name, slots)).collect()
}

fn interpretations(bytes: &[u8], expected: &Expected) -> Vec<Interpretation> {
    let is_real = expected.view.sample_type() == "f32";
    let count = expected.size.texels() * expected.channels;
    let mut results = Vec::new();
    // Samples of the correct type, optionally followed by a line end.
    let right_width = if is_real { 4 } else { 1 };
    if let Some(rest @ 0..=2) = bytes.len().checked_sub(right_width * count) {
        let (samples, trailing) = bytes.split_at(right_width * count);
        let says = || fault("trailing-bytes", &[("rest", &trailing.escape_ascii())]);
        let mistakes = (rest > 0).then(says).into_iter().collect();
        results.push((numbers(samples, right_width, false), mistakes));
    }
    for (is_big_endian, order) in [(false, "low"), (true, "high")] {
        let other_types = [
            ("big-endian", is_real && is_big_endian, 4, 1.0),
            ("floats", !is_real, 4, 1.0),
            ("fractions", !is_real, 4, 255.0),
            ("doubles", true, 8, 1.0),
        ];
        for (name, is_possible, width, factor) in other_types {
            if is_possible && bytes.len() == width * count {
                let values = numbers(bytes, width, is_big_endian).into_iter();
                let whole = |value: f64| if is_real { value } else { value.round() };
                let values = values.map(|value| whole(value * factor)).collect();
                results.push((values, vec![fault(name, &[("order", &order)])]));
            }
        }
    }
    if expected.view == ViewKind::Rgb && bytes.len() == 4 * expected.size.texels() {
        for (alpha, place) in [(3, "last"), (0, "first")] {
            let colors = bytes.iter().enumerate().filter(|(i, _)| i % 4 != alpha);
            let values = colors.map(|(_, &byte)| byte.into()).collect();
            results.push((values, vec![fault("alpha", &[("place", &place)])]));
        }
    }
    // Numbers in ASCII.
    if let Ok(text) = std::str::from_utf8(bytes) {
        let words = text.split(|c: char| c.is_whitespace() || c == ',');
        let words = words.filter(|word| !word.is_empty());
        let values: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
        results.extend(values.map(|values| (values, vec![fault("ascii", &[])])));
    }
    results
}

fn numbers(bytes: &[u8], width: usize, is_big_endian: bool) -> Vec<f64> {
    let number = |sample: &[u8]| {
        let mut sample = sample.to_vec();
        if is_big_endian {
            sample.reverse();
        }
        match sample[..] {
            [byte] => byte.into(),
            [a, b, c, d] => f32::from_le_bytes([a, b, c, d]).into(),
            _ => f64::from_le_bytes(sample.try_into().expect("8 bytes")),
        }
    };
    bytes.chunks_exact(width).map(number).collect()
}
