//! T.87 C.2: reading a stream
//!
//! ```text
//! SOI  [LSE]  SOF55  [LSE]  SOS  entropy-coded data  [LSE]  EOI
//! ```
//!
//! Format notes
//! - Preset parameters may precede either header. The last ones before the scan header apply.
//! - LSE has thirteen types. Only type 1 applies to an image with one component and no mapping table. T.870
//!   added types 5 to 13.
//! - An APP8 segment may name a color space. It is skipped like any other application segment.

use super::decode_scan::decode_scan;
use super::parameters::{Parameters, PresetParameters};
use crate::codec::bit_buffer::BitBuffer;
use crate::codec::headers::{FrameHeader, ScanHeader};
use crate::codec::markers::{Cursor, DNL, DRI, EOI, SOS};
use crate::codec::stream_error::{StreamResult, malformed, unsupported};

// Markers that only JPEG-LS uses (Table C.1).
const SOF55: u8 = 0xF7;
const LSE: u8 = 0xF8;

/// Decodes a JPEG-LS stream with one component and `width` × `height` samples. Returns the samples in row order from the top.
///
/// A stream with a precision of P bits, 2 … 8, has samples from 0 to 2^P − 1, which are returned as they are.
///
/// # Errors
/// Returns [`StreamFault::Malformed`](crate::codec::StreamFault) if the stream violates the standard or differs in size or number
/// of components, and [`StreamFault::Unsupported`](crate::codec::StreamFault) for more than 8 bits per sample, mapping tables, point
/// transforms, oversize images and restart intervals.
pub fn decode(stream: &[u8], width: u32, height: u32) -> StreamResult<Vec<u8>> {
    let mut stream = Cursor::open(stream)?;
    let mut presets = StoredPresets::default();
    presets.read_until(&mut stream, SOF55, "a JPEG-LS frame header")?;
    let frame = FrameHeader::read(&mut stream, width, height, 2..=8, 9..=16)?;
    presets.read_until(&mut stream, SOS, "the scan header")?;
    let scan = ScanHeader::read(&mut stream, &frame)?;
    let parameters = read_scan_parameters(&presets, &scan, frame.precision)?;
    // `BitBuffer<7>` is the fast version, and `Bits<7>` the plain one.
    let samples = decode_scan::<BitBuffer<7>>(&mut stream, &parameters, width, height)?;
    presets.read_until(&mut stream, EOI, "the end of the image")?;
    Ok(samples)
}

/// Checks the scan header and combines its NEAR with the preset parameters (C.2.3).
fn read_scan_parameters(
    presets: &StoredPresets,
    scan: &ScanHeader,
    precision: u8,
) -> StreamResult<Parameters> {
    let [near, interleave, transform] = scan.parameters;
    if scan.tables != 0 {
        let what = "mapping tables are not implemented";
        return Err(unsupported(scan.at, what));
    }
    if interleave != 0 {
        let what = format!("a single component cannot be interleaved, found ILV {interleave}");
        return Err(malformed(scan.at + 2, what));
    }
    if transform != 0 {
        let what = "point transforms are not implemented";
        return Err(unsupported(scan.at + 3, what));
    }
    Parameters::new(
        precision,
        &presets.parameters,
        presets.at,
        near,
        scan.at + 1,
    )
}

/// Preset coding parameters that apply at the current position in the stream.
#[derive(Default)]
struct StoredPresets {
    parameters: PresetParameters,
    /// Offset of the preset parameters in the stream.
    at: usize,
}

impl StoredPresets {
    /// Reads preset parameters up to the marker `code`. Skips comments and application data. Any other marker is an error.
    fn read_until(&mut self, stream: &mut Cursor, code: u8, what: &str) -> StreamResult<()> {
        loop {
            let marker = stream.read_marker_after_comments()?;
            let at = marker.at;
            match marker.code {
                LSE => self.read_segment(stream.read_segment("the preset parameter segment")?)?,
                DRI => read_restart_interval(stream.read_segment("the restart interval segment")?)?,
                found if found == code => return Ok(()),
                DNL => {
                    return Err(unsupported(
                        at,
                        "a height defined by DNL is not implemented",
                    ));
                }
                _ => return Err(malformed(at, format!("expected {what}, found {marker}"))),
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
                let what = format!("a preset parameter segment has unknown type {kind}");
                return Err(malformed(at, what));
            }
        };
        let what = format!("{not_implemented} are not implemented");
        Err(unsupported(at, what))
    }
}

/// Reads a restart interval segment. Only the value 0 (no restart interval) is supported.
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
