//! Maps errors of the reference decoder to lint codes.

use super::{
    codes::Problem, damage::announced_bytes, diagnostic::Findings, fits, planes,
    status::has_lost_header,
};
use crate::dissection::{Dissection, Role};
use ptm::error::{Class, Error, Kind};
use ptm::{Limits, Size};

pub(super) fn diagnose(findings: &mut Findings) {
    let dissection = findings.dissection;
    let is_too_large = diagnose_size(findings);
    let Err(error) = &dissection.outcome else {
        return;
    };
    match error.clause() {
        // The reference stops at the first error, so check every plane.
        "2.9.8/3" | "2.9.8/5" | "2.9.8/6" => planes::diagnose_errors(findings),
        clause if !is_too_large || error.class() != Class::Limit => {
            let problem = classify(dissection, error);
            let announced = announced_bytes(dissection).filter(|_| problem == Problem::PayloadEnds);
            let mut found = match announced {
                Some(bytes) => {
                    let length = dissection.file.len();
                    format!("the file should have {bytes} bytes and has {length}")
                }
                None if problem == Problem::HeaderLost => String::new(),
                None => error.kind().to_string(),
            };
            if let Problem::Index | Problem::PayloadEnds | Problem::EntryCount = problem
                && let Some(explanation) = fits::explanation(dissection)
            {
                found = format!("{found}; {explanation}");
            }
            findings.add_at(problem, error.offset(), found);
            findings.list.last_mut().expect("it was just added").clause = clause;
        }
        _ => {}
    }
}

/// Reports the image size as too large if the planes would exceed the memory limit, even if the file is truncated. Returns true
/// if the size was reported.
fn diagnose_size(findings: &mut Findings) -> bool {
    let dissection = findings.dissection;
    let (Some(format), Some(size)) = (dissection.format, dissection.size) else {
        return false;
    };
    let (channels, limit) = (format.channels(), Limits::default().memory);
    let is_too_large = Size::texels(size).saturating_mul(channels) > limit;
    if is_too_large {
        let found = format!("{size} texels of {channels} bytes each; the limit is {limit} bytes");
        findings.add(Problem::TooLarge, Role::Width, found);
    }
    is_too_large
}

/// Returns the problem that the decoder reports as this error.
pub fn classify(dissection: &Dissection, error: &Error) -> Problem {
    if has_lost_header(dissection.file) {
        return Problem::HeaderLost;
    }
    if let Some(code) = classify_whitespace(dissection, error) {
        return code;
    }
    match (error.clause(), error.kind()) {
        ("2.1/1", _) if dissection.file.starts_with(b"PTM_") => Problem::OtherVersion,
        ("2.1/1", _) => Problem::NotAPtm,
        (_, Kind::TooLarge { .. }) => Problem::TooLarge,
        (_, Kind::Short { .. }) => Problem::PayloadEnds,
        (_, Kind::IndexOutOfRange { .. }) => Problem::Index,
        (_, Kind::NotAPlane { .. }) => Problem::NotAPlane,
        (_, Kind::NotCausal { .. }) => Problem::NotCausal,
        (_, Kind::PartialRecord { .. }) => Problem::RecordCut,
        (_, Kind::PositionOutOfRange { .. }) => Problem::Position,
        (_, Kind::NotSupported { .. }) => Problem::Transform,
        (_, Kind::Stream { .. }) => Problem::StreamDamaged,
        (_, Kind::Ended { .. }) => Problem::HeaderEnds,
        (clause, Kind::Expected { .. }) => {
            classify_token(clause, token(dissection.file, error.offset()))
        }
    }
}

/// Classifies an unexpected token by its text and by the clause that requires a different token.
fn classify_token(clause: &str, token: &[u8]) -> Problem {
    match clause {
        "2.2/1" => Problem::UnknownFormat,
        "2.3/1" | "2.3/3" if is_integer(token) => Problem::SizeOutOfRange,
        "2.3/1" | "2.3/2" | "2.3/3" => Problem::SizeNotANumber,
        "2.4/3" => Problem::Scale,
        "2.4/4" => Problem::Bias,
        "2.4/5" | "2.4/6" => Problem::TooFewNumbers,
        "2.5/2" => Problem::EntryCount,
        "2.6/2" if is_text(token) => Problem::Matrix,
        "2.6/2" => Problem::MatrixShort,
        "2.9.6/2" | "2.9.7/3" => Problem::NegativeSize,
        _ if !clause.starts_with("2.9") => Problem::Layout,
        _ if is_text(token) => Problem::ListNumber,
        // A list was too short, so bytes of the planes were read as its last numbers.
        _ => Problem::ListsShort,
    }
}

/// Classifies whitespace that the specification does not allow (ruling `header-blanks`).
fn classify_whitespace(dissection: &Dissection, error: &Error) -> Option<Problem> {
    if !matches!(error.kind(), Kind::Expected { .. }) {
        return None;
    }
    let rest = &dissection.file[error.offset().min(dissection.file.len())..];
    let word = token(dissection.file, error.offset());
    let is_readable = |byte: &u8| byte.is_ascii_graphic() || b"\r\t".contains(byte);
    // Treat the first line as a version only if no more than its line ending is wrong.
    let is_ptm = error.clause() != "2.1/1" || rest.starts_with(b"PTM_1.2\r");
    let is_text_line = is_ptm && word.iter().all(is_readable);
    match (rest.first(), error.clause()) {
        _ if is_text_line && word.contains(&b'\r') => Some(Problem::CarriageReturn),
        _ if is_text_line && word.contains(&b'\t') => Some(Problem::Tab),
        // A line feed between numbers means that a number is missing.
        (_, "2.4/5" | "2.9/2") => None,
        (Some(b' ' | b'\n'), _) => Some(Problem::Layout),
        _ => None,
    }
}

/// Returns the token at `offset`, up to a space or a line feed.
fn token(file: &[u8], offset: usize) -> &[u8] {
    let rest = &file[offset.min(file.len())..];
    let end = rest.iter().position(|byte| matches!(byte, b' ' | b'\n'));
    &rest[..end.unwrap_or(rest.len())]
}

fn is_text(token: &[u8]) -> bool {
    !token.is_empty() && token.len() <= 64 && token.iter().all(u8::is_ascii_graphic)
}

fn is_integer(token: &[u8]) -> bool {
    let unsigned = token.strip_prefix(b"-").or(token.strip_prefix(b"+"));
    let digits = unsigned.unwrap_or(token);
    !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
}
