//! Repair of an answer: the mistakes of wrappers, undone until the image is right.

use crate::protocol::frame::{Frame, View};
use crate::suite::compare::Expected;

use super::arrangement::arrangements;
use super::body::body;
use super::message::{ProbeFault, WrapperMistake, mistake};

/// The mistakes that must be undone to get the right image.
pub(super) struct Repair(pub(super) Vec<WrapperMistake>);

impl Repair {
    pub(super) fn fault(&self) -> ProbeFault {
        let says: Vec<&str> = self.0.iter().map(|mistake| &*mistake.says).collect();
        let next: Vec<&str> = self.0.iter().map(|mistake| &*mistake.next).collect();
        (says.join("; and "), next.join("\n"))
    }
}

/// Returns the smallest set of mistakes that must be undone to make `bytes` the right answer; None if there is none.
pub(super) fn repair(bytes: &[u8], expected: &Expected, view: &View) -> Option<Repair> {
    let repairs = repairs(bytes, expected, view);
    // The first among equals.
    repairs.into_iter().min_by_key(|repair| repair.0.len())
}

/// Returns all sets of mistakes that can be undone to make `bytes` the right answer; none if nothing has to be undone.
pub(super) fn repairs(bytes: &[u8], expected: &Expected, view: &View) -> Vec<Repair> {
    let mut repairs = Vec::new();
    for (bytes, mistakes) in streams(bytes) {
        let Some((shape, values)) = body(&bytes, expected, view) else {
            continue;
        };
        for (values, encoded) in values {
            for (values, arranged) in arrangements(&values, expected) {
                let all: Vec<WrapperMistake> =
                    [&mistakes[..], &shape, &encoded, &arranged].concat();
                if !all.is_empty() && is_right(&values, expected) {
                    repairs.push(Repair(all));
                }
            }
        }
    }
    repairs
}

/// Bytes, and the mistakes that were undone to get them.
type Stream = (Vec<u8>, Vec<WrapperMistake>);

/// Returns the bytes, also with the effects of text mode, encodings and messages undone.
fn streams(bytes: &[u8]) -> Vec<Stream> {
    let mut streams = vec![(bytes.to_vec(), Vec::new())];
    streams.extend(from_utf16(bytes));
    streams.extend(from_utf8(bytes));
    streams.extend(line_ends(bytes));
    let after_text: Vec<Stream> = streams.iter().filter_map(without_text_before).collect();
    streams.extend(after_text);
    streams
}

fn from_utf16(bytes: &[u8]) -> Option<Stream> {
    let pairs = bytes.strip_prefix(b"\xff\xfe")?.as_chunks::<2>().0;
    let narrow = pairs.iter().map(|&pair| u16::from_le_bytes(pair) as u8);
    Some((narrow.collect(), vec![mistake("utf-16", &[])]))
}

fn from_utf8(bytes: &[u8]) -> Option<Stream> {
    let text = std::str::from_utf8(bytes).ok()?;
    if bytes.is_ascii() || text.chars().any(|c| u32::from(c) > 255) {
        return None;
    }
    let narrow = text.chars().map(|c| u32::from(c) as u8);
    Some((narrow.collect(), vec![mistake("utf-8", &[])]))
}

/// Returns the stream from its PTM1 line on, if other bytes precede it.
fn without_text_before((bytes, mistakes): &Stream) -> Option<Stream> {
    let line = bytes.windows(5).position(|word| word == b"PTM1 ");
    let line = line.filter(|&line| line > 0)?;
    let text = mistake(
        "text-before",
        &[("text", &bytes[..line.min(60)].escape_ascii())],
    );
    Some((bytes[line..].to_vec(), [&mistakes[..], &[text]].concat()))
}

/// Returns the bytes without the carriage returns that text mode puts before line feeds: in the first line, after it, or
/// everywhere.
fn line_ends(bytes: &[u8]) -> Vec<Stream> {
    let Some(end) = bytes.iter().position(|&byte| byte == b'\n') else {
        return Vec::new();
    };
    let (line, samples) = bytes.split_at(end + 1);
    let (fixed_line, fixed) = (
        without_carriage_returns(line),
        without_carriage_returns(samples),
    );
    let (line_changed, changed) = (fixed_line != line, fixed != samples);
    let candidates = [
        (
            line_changed,
            [&fixed_line[..], samples].concat(),
            "crlf-line",
        ),
        (changed, [line, &fixed].concat(), "crlf-samples"),
        (
            line_changed && changed,
            [fixed_line, fixed].concat(),
            "crlf",
        ),
    ];
    let changed = candidates.into_iter().filter(|(changed, ..)| *changed);
    let fixed = changed.map(|(_, bytes, name)| (bytes, vec![mistake(name, &[])]));
    fixed.collect()
}

fn without_carriage_returns(bytes: &[u8]) -> Vec<u8> {
    let mut kept = Vec::with_capacity(bytes.len());
    for (i, &byte) in bytes.iter().enumerate() {
        if byte != b'\r' || bytes.get(i + 1) != Some(&b'\n') {
            kept.push(byte);
        }
    }
    kept
}

fn is_right(values: &[f64], expected: &Expected) -> bool {
    let frame = Frame {
        samples: expected.view.samples(values),
        ..expected.frame()
    };
    expected.compare(&frame).is_none()
}
