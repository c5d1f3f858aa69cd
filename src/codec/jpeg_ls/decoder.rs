//! T.87 C.2: reading of a stream
//!
//! ```text
//! SOI  [LSE]  SOF55  [LSE]  SOS  entropy-coded data  [LSE]  EOI
//! ```
//!
//! Format notes
//! - Preset parameters may precede either header. The last ones before the scan header apply.
//! - LSE has thirteen types. Only type 1 applies to an image with one component of 8 bits and no mapping table. T.870
//!   added types 5 to 13.
//! - An APP8 segment may name a color space. It is skipped like any other.

use super::decode_scan::decode_scan;
use super::parameters::{Parameters, PresetParameters};
use crate::codec::bit_buffer::BitBuffer;
use crate::codec::headers::{FrameHeader, ScanHeader};
use crate::codec::markers::{Cursor, DNL, DRI, EOI, Marker, SOS};
use crate::codec::stream_error::{StreamError, StreamResult, malformed, unsupported};

// Markers that only JPEG-LS uses (Table C.1).
const SOF55: u8 = 0xF7;
const LSE: u8 = 0xF8;

/// Decodes a JPEG-LS stream with one component and `width` × `height` samples. Returns the samples in row order from the top.
///
/// # Errors
///
/// Returns [`StreamFault::Malformed`](crate::codec::StreamFault) if the stream violates the standard, or has another
/// size or another number of components, and [`StreamFault::Unsupported`](crate::codec::StreamFault) for other
/// precisions, mapping tables, point transforms, oversize images and restart intervals.
pub fn decode(stream: &[u8], width: u32, height: u32) -> StreamResult<Vec<u8>> {
    let mut stream = Cursor::open(stream)?;
    let (parameters, mut presets) = read_headers(&mut stream, width, height)?;
    // `BitBuffer<7>` is the fast version, and `Bits<7>` the plain one.
    let samples = decode_scan::<BitBuffer<7>>(&mut stream, &parameters, width, height)?;
    read_until(&mut stream, &mut presets, EOI, "the end of the image")?;
    Ok(samples)
}

/// Reads everything before the entropy-coded data.
pub(super) fn read_headers(
    stream: &mut Cursor,
    width: u32,
    height: u32,
) -> StreamResult<(Parameters, StoredPresets)> {
    let mut presets = StoredPresets::default();
    read_until(stream, &mut presets, SOF55, "a JPEG-LS frame header")?;
    let frame = FrameHeader::read(stream, width, height, &OTHER_PRECISIONS)?;
    read_until(stream, &mut presets, SOS, "the scan header")?;
    let scan = ScanHeader::read(stream, &frame)?;
    Ok((read_scan_parameters(&presets, &scan)?, presets))
}

/// Sample precisions that the standard allows but this decoder does not implement.
const OTHER_PRECISIONS: [u8; 14] = [2, 3, 4, 5, 6, 7, 9, 10, 11, 12, 13, 14, 15, 16];

/// Converts the scan header to parameters: no mapping table, NEAR, the interleave mode, the point transform (C.2.3).
fn read_scan_parameters(presets: &StoredPresets, scan: &ScanHeader) -> StreamResult<Parameters> {
    let [near, interleave, transform] = scan.parameters;
    if scan.tables != 0 {
        let what = "samples that a mapping table translates are not implemented";
        return Err(unsupported(scan.at, what));
    }
    if interleave != 0 {
        let what = format!("one component cannot be interleaved, found ILV {interleave}");
        return Err(malformed(scan.at + 2, what));
    }
    if transform != 0 {
        let what = "a point transform is not implemented";
        return Err(unsupported(scan.at + 3, what));
    }
    Parameters::new(&presets.parameters, presets.at, near, scan.at + 1)
}

/// Reads preset parameters up to the marker `code`. Any other marker is an error.
fn read_until(
    stream: &mut Cursor,
    presets: &mut StoredPresets,
    code: u8,
    what: &str,
) -> StreamResult<()> {
    let marker = presets.read(stream)?;
    match marker.code == code {
        true => Ok(()),
        false => Err(unexpected_marker(marker, what)),
    }
}

fn unexpected_marker(marker: Marker, expected: &str) -> StreamError {
    match marker.code {
        DNL => unsupported(marker.at, "a height defined by DNL is not implemented"),
        _ => malformed(marker.at, format!("expected {expected}, found {marker}")),
    }
}

/// Preset coding parameters at some position in the stream.
#[derive(Default)]
pub(super) struct StoredPresets {
    parameters: PresetParameters,
    /// Offset of the parameters in the stream.
    at: usize,
}

impl StoredPresets {
    /// Reads preset parameters and skips comments and application data. Returns the first other marker.
    fn read(&mut self, stream: &mut Cursor) -> StreamResult<Marker> {
        loop {
            let marker = stream.read_marker_after_comments()?;
            match marker.code {
                LSE => self.read_segment(stream.read_segment("the preset parameter segment")?)?,
                DRI => read_restart_interval(stream.read_segment("the restart interval segment")?)?,
                _ => return Ok(marker),
            }
        }
    }

    /// Reads a segment of preset parameters (C.2.4.1).
    fn read_segment(&mut self, mut segment: Cursor) -> StreamResult<()> {
        let at = segment.at;
        let not_implemented = match segment.read_byte("its type")? {
            1 => {
                self.at = segment.at;
                self.parameters = PresetParameters {
                    maxval: segment.read_u16("MAXVAL")?,
                    t1: segment.read_u16("T1")?,
                    t2: segment.read_u16("T2")?,
                    t3: segment.read_u16("T3")?,
                    reset: segment.read_u16("RESET")?,
                };
                return segment.expect_end();
            }
            2 | 3 => "mapping tables",
            4 => "sizes over 65,535",
            5..=13 => "the extensions of T.870",
            kind => {
                let what = format!("no preset parameter segment has type {kind}");
                return Err(malformed(at, what));
            }
        };
        Err(unsupported(
            at,
            format!("{not_implemented} are not implemented"),
        ))
    }
}

/// Reads a restart interval segment. Only 0 is supported, which means no restart interval.
fn read_restart_interval(mut segment: Cursor) -> StreamResult<()> {
    let at = segment.at;
    match segment.read_u16("the restart interval")? {
        0 => segment.expect_end(),
        _ => Err(unsupported(
            at,
            "restart intervals in JPEG-LS are not implemented",
        )),
    }
}
