//! Generates wrong files for tests, as a writer with a misreading would write them.
//!
//! Three rules cover all misreadings. If none of them produces a file that reveals the misreading, no such file exists.
//!
//! - *Lost*: the writer writes the values that a reader with this misreading sees in the right file.
//! - *Moved*: the writer stores each value at the position where this reader looks for it.
//! - *Repaired*: the writer corrects each number by the error of this reader, until the reader sees the right numbers.

use crate::misread_file::{MisreadFile, edit_bytes, explains};
use crate::reference::write_requested_file;
use crate::request::{RequestHeader, WriteRequest};
use ptm::Ptm;
use ptm_mistakes::Misreading;

/// Maximum number of repairs. Several are needed if planes are predicted from one another in a chain.
const MAX_REPAIRS: usize = 20;

/// Changes to the header before the first repair: none, negated biases, or reciprocal scales.
const STARTING_HEADERS: [fn(&mut RequestHeader); 3] = [
    |_| (),
    |header| header.bias = header.bias.map(|bias| -bias),
    |header| header.scale = header.scale.map(|scale| 1.0 / scale),
];

/// Returns the file that a writer with this mistake would write, or `None` if no rule produces one.
#[must_use]
pub fn write_with_mistake(request: &WriteRequest, mistake: &Misreading) -> Option<Vec<u8>> {
    let right = write_requested_file(request).ok()?;
    let lost = || reference_file(&with_values(request, &read_with_mistake(request, mistake)?));
    let repaired = |start: &fn(&mut RequestHeader)| repair_values(request, *start, mistake);
    let is_right =
        |file: &[u8]| MisreadFile::new(file, &[]).is_some_and(|seen| seen.is_right(request));
    let reveals = |file: &Vec<u8>| !is_right(file) && explains(request, &right, file, mistake);
    let found = edit_bytes(&right, mistake).filter(reveals);
    let found = found.or_else(|| lost().filter(reveals));
    let found = found.or_else(|| move_values(request, mistake).filter(reveals));
    found.or_else(|| STARTING_HEADERS.iter().filter_map(repaired).find(reveals))
}

/// Returns the reference's file for a request, or `None` if it cannot be written.
fn reference_file(request: &WriteRequest) -> Option<Vec<u8>> {
    let is_finite = request.header.scale.iter().all(|scale| scale.is_finite());
    is_finite.then(|| write_requested_file(request).ok())?
}

/// Returns the map that a reader with this mistake sees in the reference's file.
fn read_with_mistake(request: &WriteRequest, mistake: &Misreading) -> Option<Ptm> {
    let map = MisreadFile::new(&reference_file(request)?, &[mistake])?.into_effective_map();
    (map.planes.samples.len() == request.samples.len()).then_some(map)
}

/// Returns the request with header numbers and samples from `map`.
fn with_values(request: &WriteRequest, map: &Ptm) -> WriteRequest {
    let (values, mut other) = (WriteRequest::from_ptm(map), request.clone());
    other.samples = values.samples;
    (other.header.width, other.header.height) = (values.header.width, values.header.height);
    (other.header.scale, other.header.bias) = (values.header.scale, values.header.bias);
    other
}

/// Returns a file in which each value is where a reader with this mistake expects it, if the mistake only moves values.
fn move_values(request: &WriteRequest, mistake: &Misreading) -> Option<Vec<u8>> {
    let count = request.samples.len();
    let mut other = request.clone();
    // Determine the source index of each value with three files whose values are the bytes of their indices.
    let mut sources = vec![0; count];
    for shift in [0, 8, 16] {
        other.samples = (0..count).map(|i| (i >> shift) as u8).collect();
        let bytes = read_with_mistake(&other, mistake)?.planes.samples;
        for (source, byte) in sources.iter_mut().zip(bytes) {
            *source |= usize::from(byte) << shift;
        }
    }
    for (&source, value) in sources.iter().zip(&request.samples) {
        *other.samples.get_mut(source)? = *value;
    }
    reference_file(&other)
}

/// Repairs a request until a reader with this mistake sees the right values in its file. Returns `None` if this never happens.
fn repair_values(
    request: &WriteRequest,
    start: fn(&mut RequestHeader),
    mistake: &Misreading,
) -> Option<Vec<u8>> {
    let mut other = request.clone();
    start(&mut other.header);
    for _ in 0..MAX_REPAIRS {
        let map = read_with_mistake(&other, mistake)?;
        let values = other.samples.iter_mut().zip(&request.samples);
        for ((value, wanted), seen) in values.zip(&map.planes.samples) {
            *value = value.wrapping_add(wanted.wrapping_sub(*seen));
        }
        let (header, seen) = (&mut other.header, map.header.scale_bias);
        for i in 0..6 {
            header.scale[i] *= request.header.scale[i] / seen.scale[i];
            let missing = request.header.bias[i] as f64 - seen.bias[i];
            header.bias[i] = header.bias[i].saturating_add(missing.round() as i64);
        }
        let file = reference_file(&other)?;
        if MisreadFile::new(&file, &[mistake]).is_some_and(|seen| seen.is_right(request)) {
            return Some(file);
        }
    }
    None
}
