//! T.81 B.2.2, B.2.3 (T.87 C.2.2, C.2.3): the frame header and the scan header
//!
//! The frame header contains the size of the image, the precision of the samples, and the components. The scan header lists the
//! components in the entropy-coded data that follows. A plane has one component, so both headers have a fixed length here.
//!
//! ```text
//! SOF  00 0B  08         00 08   00 10  01          01    11            00
//!      length precision  height  width  components  id    factors 1x1   quantization table
//! SOS  00 08  01          01    00                      00 3F 00
//!      length components  id    Huffman or mapping tables  three parameters
//! ```
//!
//! Format notes
//! - Height precedes width. A height of zero means "defined later, by DNL" (B.2.5).
//! - Sampling factors are relative: they set the size of a component compared to the *other* components (A.1.1), and a scan of
//!   one component has its blocks in plain raster order regardless of its factors (A.2.2). All legal factors are therefore
//!   equivalent here.
//! - The id of a component can be any byte. It must be the same in both headers.
//! - The three parameters of a scan depend on the standard. In T.81, they are the start and end of the spectral
//!   selection and the successive approximation. In T.87, they are NEAR, the interleave mode and the point transform.

use std::ops::RangeInclusive;

use super::markers::Cursor;
use super::stream_error::{StreamResult, malformed, unsupported};

/// Frame header (T.81 B.2.2), without the values that are fixed for a plane.
pub(super) struct FrameHeader {
    /// Number of bits per sample.
    pub precision: u8,
    /// Component id, which the scan header must repeat.
    component: u8,
    /// Index of the quantization table (T.81 only).
    pub quantization_table: u8,
}

impl FrameHeader {
    /// Reads a frame header. The frame must have `width` × `height` samples, one component and a precision in `precisions`.
    ///
    /// `other_precisions` are those that the standard allows but this decoder does not implement.
    pub fn read(
        stream: &mut Cursor,
        width: u32,
        height: u32,
        precisions: RangeInclusive<u8>,
        other_precisions: RangeInclusive<u8>,
    ) -> StreamResult<FrameHeader> {
        let mut header = stream.read_segment("the frame header")?;
        let precision = read_precision(&mut header, &precisions, &other_precisions)?;
        expect_size(&mut header, width, height)?;
        expect_one_component(&mut header)?;
        let component = header.read_byte("the component id")?;
        check_sampling_factors(&mut header)?;
        let quantization_table = header.read_byte("the quantization table of the component")?;
        header.expect_end()?;
        Ok(FrameHeader {
            precision,
            component,
            quantization_table,
        })
    }
}

fn read_precision(
    header: &mut Cursor,
    precisions: &RangeInclusive<u8>,
    other_precisions: &RangeInclusive<u8>,
) -> StreamResult<u8> {
    let at = header.at;
    match header.read_byte("the sample precision")? {
        bits if precisions.contains(&bits) => Ok(bits),
        bits if other_precisions.contains(&bits) => Err(unsupported(
            at,
            format!("{bits}-bit samples are not implemented"),
        )),
        bits => Err(malformed(at, format!("{bits}-bit samples are not allowed"))),
    }
}

/// Checks the size of a plane against the size in the PTM header (ruling `plane-stream`), before anything is allocated.
fn expect_size(header: &mut Cursor, width: u32, height: u32) -> StreamResult<()> {
    let at = header.at;
    let rows = header.read_u16("the height")?;
    let columns = header.read_u16("the width")?;
    if rows == 0 {
        let what = "a height defined by DNL is not implemented";
        return Err(unsupported(at, what));
    }
    if (u32::from(columns), u32::from(rows)) != (width, height) {
        let what = format!("expected {width} x {height} samples, found {columns} x {rows}");
        return Err(malformed(at, what));
    }
    Ok(())
}

fn expect_one_component(header: &mut Cursor) -> StreamResult<()> {
    let at = header.at;
    match header.read_byte("the number of components")? {
        1 => Ok(()),
        components => Err(malformed(
            at,
            format!("expected one component, found {components}"),
        )),
    }
}

/// Checks the horizontal and vertical sampling factors, four bits each (B.2.2). Legal factors have no effect.
fn check_sampling_factors(header: &mut Cursor) -> StreamResult<()> {
    let at = header.at;
    let factors = header.read_byte("the sampling factors")?;
    let (horizontal, vertical) = (factors >> 4, factors & 15);
    if !(1..=4).contains(&horizontal) || !(1..=4).contains(&vertical) {
        let what = format!("sampling factors must be from 1 to 4, found {horizontal} x {vertical}");
        return Err(malformed(at, what));
    }
    Ok(())
}

/// Scan header (T.81 B.2.3): the tables of the single component, and three parameters.
pub(super) struct ScanHeader {
    pub tables: u8,
    pub parameters: [u8; 3],
    /// Offset of `tables` in the stream. `parameters` follows directly.
    pub at: usize,
}

impl ScanHeader {
    pub fn read(stream: &mut Cursor, frame: &FrameHeader) -> StreamResult<ScanHeader> {
        let mut header = stream.read_segment("the scan header")?;
        expect_one_component(&mut header)?;
        let at = header.at;
        let component = header.read_byte("the component id")?;
        if component != frame.component {
            let expected = frame.component;
            let what = format!("expected a scan of component {expected}, found {component}");
            return Err(malformed(at, what));
        }
        let at = header.at;
        let tables = header.read_byte("the tables of the component")?;
        let mut parameters = [0; 3];
        for parameter in &mut parameters {
            *parameter = header.read_byte("the parameters of the scan")?;
        }
        header.expect_end()?;
        Ok(ScanHeader {
            tables,
            parameters,
            at,
        })
    }
}

/// Allocates zeroed samples for a scan whose entropy-coded data starts at the cursor.
///
/// A scan must have at least `min_bits` bits, so that a short stream cannot declare a large image. Returns an error
/// instead of aborting if there is not enough memory.
pub(super) fn allocate_samples(
    stream: &Cursor,
    width: u32,
    height: u32,
    min_bits: u64,
) -> StreamResult<Vec<u8>> {
    let remaining = stream.stream.len() - stream.at;
    if (remaining as u64 * 8) < min_bits {
        let what =
            format!("{width} x {height} samples cannot be coded in the {remaining} bytes left");
        return Err(malformed(stream.at, what));
    }
    // Both sides are at most 65,535, the maximum of the frame header.
    let count = usize::try_from(u64::from(width) * u64::from(height)).unwrap_or(usize::MAX);
    let mut samples = Vec::new();
    if samples.try_reserve_exact(count).is_err() {
        let what = format!("not enough memory for {width} x {height} samples");
        return Err(unsupported(stream.at, what));
    }
    samples.resize(count, 0);
    Ok(samples)
}
