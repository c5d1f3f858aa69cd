//! Compares a written file with the requested values.
//!
//! The reference must be able to decode the file, and `lint` must find no error. The header and the planes must match the
//! request. For planes of lossy formats, the tolerance depends on the compression parameter.

use std::fmt::Write;

use crate::fault::{FaultKind, WriterFault};
use crate::request::WriteRequest;
use ptm::decode::texels::block_containing;
use ptm::error::Error;
use ptm::{Format, Ptm, Shape, Size, Storage, channel_name};
use ptm_files::dissection::{Dissection, Role};
use ptm_files::join_texts;
use ptm_files::lint::{codes::Severity, diagnostic::Diagnostic, lint};

/// Relative tolerance for header numbers: one rounding to `f32`.
pub(super) const NUMBER_TOLERANCE: f64 = 1e-6;

/// Judges the file that was written for `request`.
///
/// # Errors
/// Returns the fault of the file.
pub fn judge(request: &WriteRequest, file: &[u8]) -> Result<(), WriterFault> {
    let dissection = Dissection::parse(file);
    let ptm = dissection.outcome.as_ref();
    let ptm = ptm.map_err(|error| refusal(file, error))?;
    compare_headers(request, ptm)?;
    compare_parameter(request, &dissection)?;
    if request.is_lossy() {
        let side = |plane| dissection.bytes(Role::Side(plane)).unwrap_or_default();
        super::lossy::check(request, &ptm.planes.samples, side)?;
    } else {
        compare_planes(request, &dissection, &ptm.planes.samples)?;
    }
    check_lint(file)
}

pub(super) fn check_lint(file: &[u8]) -> Result<(), WriterFault> {
    match first_error(file) {
        Some(first) => {
            let problem = format!("{} ({})", first.message, first.found);
            let says = format!("lint {} at byte {}: {problem}", first.code, first.offset);
            Err(WriterFault {
                kind: FaultKind::LintError,
                fix: first.fix,
                ..WriterFault::new(first.clause, says)
            })
        }
        None => Ok(()),
    }
}

/// Returns the first error that `lint` finds in a file.
fn first_error(file: &[u8]) -> Option<Diagnostic> {
    let mut found = lint(file).into_iter();
    found.find(|found| found.severity == Severity::Error)
}

/// Describes why the reference refuses a file. Includes the bytes at the error.
pub(super) fn refusal(file: &[u8], error: &Error) -> WriterFault {
    let start = error.offset().min(file.len());
    let excerpt = &file[start..file.len().min(start + 16)];
    let bytes = match excerpt.is_empty() {
        true => "the file ends there".to_owned(),
        false => format!("the bytes there are \"{}\"", excerpt.escape_ascii()),
    };
    let says = format!("the reference refuses the file: {error}; {bytes}");
    let same = first_error(file).filter(|found| found.offset == error.offset());
    WriterFault {
        kind: FaultKind::Refused,
        fix: same.map_or("", |found| found.fix),
        ..WriterFault::new(error.clause(), says)
    }
}

/// Compares the format and size (2.2 and 2.3).
pub(super) fn compare_map(format: Format, size: Size, ptm: &Ptm) -> Result<(), WriterFault> {
    let found = &ptm.header;
    if found.format != format {
        let says = format!("expected {format}, but the file is {}", found.format);
        return Err(WriterFault::new("2.2/1", says));
    }
    if found.size != size {
        let says = format!("expected {size} texels, but the file has {}", found.size);
        return Err(WriterFault::new("2.3/1", says));
    }
    Ok(())
}

/// Compares the headers (2.2–2.4 and 2.6).
fn compare_headers(request: &WriteRequest, ptm: &Ptm) -> Result<(), WriterFault> {
    compare_map(request.format, request.size(), ptm)?;
    let wanted = &request.header;
    let set = &ptm.header.scale_bias;
    compare_numbers("2.4/3", "scale", &wanted.scale, &set.scale)?;
    let bias = wanted.bias.map(|bias| bias as f64);
    compare_numbers("2.4/4", "bias", &bias, &set.bias)?;
    match (&wanted.matrix, &ptm.planes.shape) {
        (Some(wanted), Shape::Lum(found)) => {
            compare_numbers("2.6/2", "matrix element", wanted, &found.0)
        }
        _ => Ok(()),
    }
}

/// Compares two lists of numbers within [`NUMBER_TOLERANCE`].
fn compare_numbers(
    clause: &str,
    name: &str,
    wanted: &[f64],
    found: &[f64],
) -> Result<(), WriterFault> {
    let differs = |&i: &usize| !is_same_number(wanted[i], found[i]);
    let Some(i) = (0..wanted.len()).find(differs) else {
        return Ok(());
    };
    let [all, expected] = [found, wanted].map(|numbers| join_texts(numbers, " "));
    let says = format!(
        "{name} {i}: expected {}, found {} (all values: {all} instead of {expected})",
        wanted[i], found[i],
    );
    Err(WriterFault::new(clause, says))
}

pub(super) fn is_same_number(wanted: f64, found: f64) -> bool {
    (wanted - found).abs() <= NUMBER_TOLERANCE * wanted.abs()
}

/// Compares the compression parameter with the requested one (2.9.1).
fn compare_parameter(request: &WriteRequest, dissection: &Dissection) -> Result<(), WriterFault> {
    let wanted = request.header.quality.or(request.header.near);
    match (wanted, dissection.number(Role::Parameter)) {
        (Some(wanted), Some(found)) if i64::from(wanted) != found => {
            let says = format!("expected the compression parameter {wanted}, found {found}");
            Err(WriterFault::new("2.9.1/1", says))
        }
        _ => Ok(()),
    }
}

fn compare_planes(
    request: &WriteRequest,
    dissection: &Dissection,
    found: &[u8],
) -> Result<(), WriterFault> {
    let wanted = &request.samples;
    let differs = |&i: &usize| wanted[i] != found[i];
    let Some(first) = (0..wanted.len()).find(differs) else {
        return Ok(());
    };
    let channels = request.format.channels();
    let (texel, channel) = (first / channels, first % channels);
    let (width, all) = (request.header.width as usize, wanted.len());
    let count = (0..all).filter(differs).count();
    let (x, y) = (texel % width, texel / width);
    let name = channel_name(channels, channel);
    let (wanted, found) = (wanted[first], found[first]);
    let mut says = format!(
        "texel ({x}, {y}), {name}: expected {wanted}, found {found}; {count} of {all} values differ"
    );
    if let Some(at) = value_offset(request, dissection, (x, y), channel) {
        let byte = dissection.file.get(at).copied().unwrap_or_default();
        let _ = write!(
            says,
            "; the value is read from byte {at}, which is 0x{byte:02x}"
        );
    }
    let clause = match request.format.coding() {
        Some(_) => "2.9.8/1",
        None => request.format.layout_clause(),
    };
    Err(WriterFault::new(clause, says))
}

/// Returns the offset of a value in an uncompressed file, or `None` for other formats.
fn value_offset(
    request: &WriteRequest,
    dissection: &Dissection,
    (x, y): (usize, usize),
    channel: usize,
) -> Option<usize> {
    if request.format.storage() != Storage::Texels {
        return None;
    }
    let texel = (request.header.height as usize - 1 - y) * request.header.width as usize + x;
    let (place, block) = block_containing(request.format, channel)?;
    let start = dissection.part(Role::Block(place))?.offset;
    Some(start + texel * block.channels + channel - block.channel)
}

impl WriteRequest {
    /// Returns true if the compression of the planes may be lossy.
    #[must_use]
    pub fn is_lossy(&self) -> bool {
        self.header.quality.is_some() || self.header.near.is_some_and(|near| near > 0)
    }
}
