//! Whether a file has the values that were asked for.
//!
//! The reference decodes it; header and planes are those of the request, planes of lossy formats as far as the quality
//! allows; and `lint` finds no error in it.

use std::fmt::Write;

use crate::error::Error;
use crate::ptm::{Ptm, Shape, channel_name};
use crate::tools::dissection::{Dissection, Role};
use crate::tools::lint::codes::Severity;
use crate::tools::lint::lint;
use crate::writers::fault::WriterFault;
use crate::writers::request::WriteRequest;

/// How far a number of the header may be off, relative to its own size: room for one rounding to `f32`.
pub(super) const NUMBERS: f64 = 1e-6;

/// Judges the file that was written for `request`.
///
/// # Errors
/// What is wrong with it.
pub fn judge(request: &WriteRequest, file: &[u8]) -> Result<(), WriterFault> {
    let dissection = Dissection::of(file);
    let ptm = match &dissection.outcome {
        Ok(ptm) => ptm,
        Err(error) => return Err(refusal(file, error)),
    };
    compare_headers(request, ptm)?;
    compare_parameter(request, &dissection)?;
    if request.is_lossy() {
        super::lossy::compare(request, &dissection, &ptm.planes.samples)?;
    } else {
        compare_planes(request, &dissection, &ptm.planes.samples)?;
    }
    match lint(file).first() {
        Some(first) if first.severity == Severity::Error => Err(WriterFault::new(
            first.clause,
            format!(
                "lint {} at byte {}: {} ({})",
                first.code, first.offset, first.says, first.found
            ),
        )),
        _ => Ok(()),
    }
}

/// The reference refuses it: why, and the bytes at that place.
fn refusal(file: &[u8], error: &Error) -> WriterFault {
    let from = error.offset().min(file.len());
    let shown = &file[from..file.len().min(from + 16)];
    let bytes = match shown.is_empty() {
        true => "the file ends there".to_owned(),
        false => format!("the bytes there: \"{}\"", shown.escape_ascii()),
    };
    WriterFault::new(
        error.clause(),
        format!("the reference refuses the file: {error}; {bytes}"),
    )
}

/// 2.2–2.4 and 2.6.
fn compare_headers(request: &WriteRequest, ptm: &Ptm) -> Result<(), WriterFault> {
    let (wanted, found) = (&request.header, &ptm.header);
    if found.format != request.format {
        return Err(WriterFault::new(
            "2.2/1",
            format!("expected {}, the file is {}", request.format, found.format),
        ));
    }
    if found.size != request.size() {
        return Err(WriterFault::new(
            "2.3/1",
            format!(
                "expected {} texels, the file has {}",
                request.size(),
                found.size
            ),
        ));
    }
    let set = &found.scale_bias;
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

/// Two lists of numbers, each about the same.
fn compare_numbers(
    clause: &str,
    name: &str,
    wanted: &[f64],
    found: &[f64],
) -> Result<(), WriterFault> {
    let mut pairs = wanted.iter().zip(found).enumerate();
    let differing = pairs.find(|(_, (wanted, found))| !is_same_number(**wanted, **found));
    match differing {
        None => Ok(()),
        Some((i, _)) => Err(WriterFault::new(
            clause,
            format!(
                "{name} {i}: expected {}, the file has {} (all of them: {} instead of {})",
                wanted[i],
                found[i],
                listed(found),
                listed(wanted)
            ),
        )),
    }
}

pub(super) fn is_same_number(wanted: f64, found: f64) -> bool {
    (wanted - found).abs() <= NUMBERS * wanted.abs()
}

fn listed(numbers: &[f64]) -> String {
    let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
    numbers.join(" ")
}

/// 2.9.1.
fn compare_parameter(request: &WriteRequest, dissection: &Dissection) -> Result<(), WriterFault> {
    let wanted = request.header.quality.or(request.header.near);
    let found = dissection.number(Role::Parameter);
    match (wanted.map(i64::from), found) {
        (Some(wanted), Some(found)) if wanted != found => Err(WriterFault::new(
            "2.9.1/1",
            format!("expected the compression parameter {wanted}, the file has {found}"),
        )),
        _ => Ok(()),
    }
}

/// The planes of a lossless file.
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
    let width = request.header.width as usize;
    let count = (0..wanted.len()).filter(differs).count();
    let (x, y) = (texel % width, texel / width);
    let name = channel_name(channels, channel);
    let mut says = format!(
        "texel ({x}, {y}), {name}: expected {}, the file gives {}; {count} of {} values differ",
        wanted[first],
        found[first],
        wanted.len()
    );
    if let Some(at) = byte_of(request, dissection, x, y, channel) {
        let byte = dissection.file.get(at).copied().unwrap_or_default();
        let _ = write!(
            says,
            "; the value is read from byte {at}, which is {byte:02x}"
        );
    }
    Err(WriterFault::new(clause_of_planes(request), says))
}

/// The clause that says where the values of a format stand.
fn clause_of_planes(request: &WriteRequest) -> &'static str {
    use crate::ptm::Format;
    match request.format {
        Format::Rgb => "2.7.1/1",
        Format::Lum => "2.7.2/1",
        Format::Lrgb => "2.7.3/1",
        Format::PtmLut => "2.8.1/1",
        Format::PtmCLut => "2.8.2/1",
        _ => "2.9.8/1",
    }
}

/// Which byte of an uncompressed file holds a value.
fn byte_of(
    request: &WriteRequest,
    dissection: &Dissection,
    x: usize,
    y: usize,
    channel: usize,
) -> Option<usize> {
    use crate::ptm::Format;
    let width = request.header.width as usize;
    let texel = (request.header.height as usize - 1 - y) * width + x;
    let (block, of_block, within) = match (request.format, channel) {
        (Format::Rgb, _) => (channel / 6, 6, channel % 6),
        (Format::Lrgb, 0..6) => (0, 6, channel),
        (Format::Lrgb, _) => (1, 3, channel - 6),
        (Format::Lum, _) => (0, 8, channel),
        _ => return None,
    };
    let start = dissection.part(Role::Block(block))?.range.start;
    Some(start + texel * of_block + within)
}

impl WriteRequest {
    /// Whether the planes may lose something.
    #[must_use]
    pub fn is_lossy(&self) -> bool {
        self.header.quality.is_some() || self.header.near.is_some_and(|near| near > 0)
    }
}
