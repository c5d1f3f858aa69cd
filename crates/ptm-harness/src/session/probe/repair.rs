//! Repairs an answer: undoes known mistakes of wrappers until the image is correct.

use ptm_suite::compare::Expected;
use ptm_suite::protocol::frame::{Frame, View};

use super::message::{ProbeFault, fault, join_texts};
use super::{arrangement::arrangements, body::interpret_frame};

/// Mistakes that must be undone to obtain the correct image.
pub(super) struct Repair {
    pub(super) mistakes: Vec<ProbeFault>,
    /// True if all samples are right and only their order is wrong.
    pub(super) reorders: bool,
}

impl Repair {
    pub(super) fn fault(self) -> ProbeFault {
        join_texts(self.mistakes, "\n")
    }
}

/// Describes the smallest set of mistakes that must be undone to correct `bytes`. Returns `None` if there is no such set.
pub(super) fn repair(bytes: &[u8], expected: &Expected, view: &View) -> Option<ProbeFault> {
    // Of several smallest sets, the first is returned.
    let repairs = repairs(bytes, expected, view).into_iter();
    let smallest = repairs.min_by_key(|repair| repair.mistakes.len());
    smallest.map(Repair::fault)
}

/// Returns all sets of mistakes that can be undone to make `bytes` the correct answer, except the empty set.
pub(super) fn repairs(bytes: &[u8], expected: &Expected, view: &View) -> Vec<Repair> {
    let mut repairs = Vec::new();
    for (bytes, mistakes) in candidate_streams(bytes) {
        let Some((shape, values)) = interpret_frame(&bytes, expected, view) else {
            continue;
        };
        for (values, encoded) in values {
            let mistakes = [&mistakes[..], &shape, &encoded].concat();
            let reorders = mistakes.is_empty();
            for (values, arranged) in arrangements(&values, expected) {
                let mistakes = [&mistakes[..], &arranged].concat();
                if !mistakes.is_empty() && is_right(&values, expected) {
                    repairs.push(Repair { mistakes, reorders });
                }
            }
        }
    }
    repairs
}

/// Repaired bytes and the mistakes that were undone.
type RepairedBytes = (Vec<u8>, Vec<ProbeFault>);

/// Returns the unchanged bytes, and the results of undoing text encodings and of removing carriage returns and text before the
/// frame.
fn candidate_streams(bytes: &[u8]) -> Vec<RepairedBytes> {
    let mut streams = vec![(bytes.to_vec(), Vec::new())];
    streams.extend(from_utf16(bytes));
    streams.extend(from_utf8(bytes));
    streams.extend(without_carriage_returns(bytes));
    let after_text: Vec<RepairedBytes> = streams.iter().filter_map(without_leading_text).collect();
    streams.extend(after_text);
    streams
}

fn from_utf16(bytes: &[u8]) -> Option<RepairedBytes> {
    let pairs = bytes.strip_prefix(b"\xff\xfe")?.as_chunks::<2>().0;
    let narrow = pairs.iter().map(|&pair| u16::from_le_bytes(pair) as u8);
    Some((narrow.collect(), vec![fault("utf-16", &[])]))
}

fn from_utf8(bytes: &[u8]) -> Option<RepairedBytes> {
    let text = std::str::from_utf8(bytes).ok()?;
    let narrow: Option<Vec<u8>> = text.chars().map(|c| u8::try_from(c).ok()).collect();
    let narrow = narrow.filter(|_| !bytes.is_ascii())?;
    Some((narrow, vec![fault("utf-8", &[])]))
}

/// Returns the stream starting at its PTM1 line, if other bytes precede that line.
fn without_leading_text((bytes, mistakes): &RepairedBytes) -> Option<RepairedBytes> {
    let line = bytes.windows(5).position(|word| word == b"PTM1 ");
    let line = line.filter(|&line| line > 0)?;
    let shown = bytes[..line.min(60)].escape_ascii();
    let text = fault("text-before", &[("text", &shown)]);
    Some((bytes[line..].to_vec(), [&mistakes[..], &[text]].concat()))
}

/// Removes the carriage returns that text mode inserts: from the first line, from the bytes after that line, or from both.
/// Returns all results.
fn without_carriage_returns(bytes: &[u8]) -> Vec<RepairedBytes> {
    let Some(end) = bytes.iter().position(|&byte| byte == b'\n') else {
        return Vec::new();
    };
    let (line, samples) = bytes.split_at(end + 1);
    let [fixed_line, fixed] = [line, samples].map(|bytes| {
        let is_before_line_feed = |i: usize| bytes[i..].starts_with(b"\r\n");
        let kept = (0..bytes.len()).filter(|&i| !is_before_line_feed(i));
        kept.map(|i| bytes[i]).collect::<Vec<u8>>()
    });
    let (line_changed, changed) = (fixed_line != line, fixed != samples);
    let candidates = [
        (line_changed, "crlf-line", [&fixed_line, samples]),
        (changed, "crlf-samples", [line, &fixed]),
        (line_changed && changed, "crlf", [&fixed_line, &fixed]),
    ];
    let changed = candidates.into_iter().filter(|(changed, ..)| *changed);
    let fixed = changed.map(|(_, name, parts)| (parts.concat(), vec![fault(name, &[])]));
    fixed.collect()
}

fn is_right(values: &[f64], expected: &Expected) -> bool {
    let frame = Frame {
        samples: expected.view.samples(values),
        ..expected.frame()
    };
    expected.compare(&frame).is_none()
}
