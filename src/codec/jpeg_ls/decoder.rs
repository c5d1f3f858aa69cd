//! T.87 C.2: the order of a stream, read
//!
//! ```text
//! SOI  [LSE]  SOF55  [LSE]  SOS  entropy-coded data  [LSE]  EOI
//! ```
//!
//! Format notes
//! - Preset parameters may precede either header; the last ones before the scan header count.
//! - LSE has thirteen types. Only type 1 applies to an image of one component of 8 bits without a
//!   mapping table; T.870 has added types 5 to 13.
//! - An APP8 segment may name a color space; it is skipped like any other.

use super::decode_scan::decode_scan;
use super::parameters::{Parameters, PresetParameters};
use crate::codec::bit_buffer::BitBuffer;
use crate::codec::headers::{FrameHeader, ScanHeader};
use crate::codec::markers::{Cursor, DNL, DRI, EOI, Marker, SOS};
use crate::codec::stream_error::{Result, StreamError, malformed, unsupported};

// Markers of JPEG-LS only (Table C.1).
const SOF55: u8 = 0xF7;
const LSE: u8 = 0xF8;

/// Decodes a JPEG-LS stream of one component and `width` × `height` samples, in row order from the
/// top.
///
/// # Errors
///
/// [`StreamFault::Malformed`](crate::codec::StreamFault) if the stream violates the standard, has
/// another size or another number of components;
/// [`StreamFault::Unsupported`](crate::codec::StreamFault) for other precisions, mapping tables,
/// point transforms, oversize images and restart intervals.
pub fn decode(stream: &[u8], width: u32, height: u32) -> Result<Vec<u8>> {
    let mut stream = Cursor::open(stream)?;
    let (parameters, mut presets) = read_headers(&mut stream, width, height)?;
    // The fast version; `Bits<7>` in place of `BitBuffer<7>` is the plain one.
    let samples = decode_scan::<BitBuffer<7>>(&mut stream, &parameters, width, height)?;
    expect(&mut stream, &mut presets, EOI, "the end of the image")?;
    Ok(samples)
}

/// Reads everything before the entropy-coded data.
pub(super) fn read_headers(
    stream: &mut Cursor,
    width: u32,
    height: u32,
) -> Result<(Parameters, StoredPresets)> {
    let mut presets = StoredPresets::default();
    expect(stream, &mut presets, SOF55, "a JPEG-LS frame header")?;
    let frame = FrameHeader::read(stream, width, height, &OTHER_PRECISIONS)?;
    expect(stream, &mut presets, SOS, "the scan header")?;
    let scan = ScanHeader::read(stream, &frame)?;
    Ok((parameters_of_scan(&presets, &scan)?, presets))
}

/// Sample precisions that the standard allows but this decoder does not implement.
const OTHER_PRECISIONS: [u8; 14] = [2, 3, 4, 5, 6, 7, 9, 10, 11, 12, 13, 14, 15, 16];

/// Reads the parameters of a scan: no mapping table, NEAR, the interleave mode, the point transform (C.2.3).
fn parameters_of_scan(presets: &StoredPresets, scan: &ScanHeader) -> Result<Parameters> {
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

/// Reads preset parameters up to this marker.
fn expect(stream: &mut Cursor, presets: &mut StoredPresets, code: u8, what: &str) -> Result<()> {
    let marker = presets.read(stream)?;
    match marker.code == code {
        true => Ok(()),
        false => Err(unexpected(marker, what)),
    }
}

fn unexpected(marker: Marker, expected: &str) -> StreamError {
    match marker.code {
        DNL => unsupported(marker.at, "a height defined by DNL is not implemented"),
        _ => malformed(marker.at, format!("expected {expected}, found {marker}")),
    }
}

/// The preset coding parameters at one position of the stream.
#[derive(Default)]
pub(super) struct StoredPresets {
    parameters: PresetParameters,
    /// Their position.
    at: usize,
}

impl StoredPresets {
    /// Reads preset parameters, skips comments and application data, and returns the first other
    /// marker.
    fn read(&mut self, stream: &mut Cursor) -> Result<Marker> {
        loop {
            let marker = stream.marker_after_comments()?;
            match marker.code {
                LSE => self.read_segment(stream.segment("the preset parameter segment")?)?,
                DRI => read_restart_interval(stream.segment("the restart interval segment")?)?,
                _ => return Ok(marker),
            }
        }
    }

    /// Reads a segment of preset parameters (C.2.4.1).
    fn read_segment(&mut self, mut segment: Cursor) -> Result<()> {
        let at = segment.at;
        let not_implemented = match segment.byte("its type")? {
            1 => {
                self.at = segment.at;
                self.parameters = PresetParameters {
                    maxval: segment.u16("MAXVAL")?,
                    t1: segment.u16("T1")?,
                    t2: segment.u16("T2")?,
                    t3: segment.u16("T3")?,
                    reset: segment.u16("RESET")?,
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

/// Accepts an interval of 0, which means none.
fn read_restart_interval(mut segment: Cursor) -> Result<()> {
    let at = segment.at;
    match segment.u16("the restart interval")? {
        0 => segment.expect_end(),
        _ => Err(unsupported(
            at,
            "restart intervals in JPEG-LS are not implemented",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::decode;
    use crate::codec::StreamFault;
    use crate::codec::witness::bytes;

    // The smallest stream: a row of four zeros, which is a run, written as four ones.
    const SOI: &str = "FF D8";
    const SOF: &str = "FF F7 00 0B  08  00 01 00 04  01  01 11 00";
    const SOS: &str = "FF DA 00 08  01  01 00  00  00 00";
    const DATA: &str = "F0";
    const EOI: &str = "FF D9";

    /// Returns the smallest stream with one of its five parts replaced.
    fn patch(part: usize, other: &str) -> String {
        let mut parts = [SOI, SOF, SOS, DATA, EOI];
        parts[part] = other;
        parts.join(" ")
    }

    /// Returns the smallest stream with preset parameters: MAXVAL, T1, T2, T3, RESET.
    fn presets(values: &str) -> String {
        patch(2, &format!("FF F8 00 0D  01  {values}  {SOS}"))
    }

    #[track_caller]
    fn reads(text: &str) -> Vec<u8> {
        decode(&bytes(text), 4, 1).unwrap_or_else(|error| panic!("{error}"))
    }

    #[track_caller]
    fn refuses(fault: StreamFault, text: &str, expected: &str) {
        let error = decode(&bytes(text), 4, 1).expect_err("an error");
        assert_eq!((error.to_string().as_str(), error.fault), (expected, fault));
    }

    #[track_caller]
    fn rejects(text: &str, expected: &str) {
        refuses(StreamFault::Malformed, text, expected);
    }

    #[track_caller]
    fn lacks(text: &str, expected: &str) {
        refuses(StreamFault::Unsupported, text, expected);
    }

    #[test]
    fn the_smallest_stream_is_black() {
        assert_eq!(reads(&patch(0, SOI)), [0; 4]);
    }

    /// 0: no run. 1 and then 11, because k is 2: number 3, which is error 2.
    #[test]
    fn a_run_may_be_interrupted_at_once() {
        let one = patch(1, "FF F7 00 0B 08 00 01 00 01 01 01 11 00").replace(DATA, "70");
        assert_eq!(decode(&bytes(&one), 1, 1), Ok(vec![2]));
    }

    #[test]
    fn one_picture_may_be_spelled_in_many_ways() {
        let black = [0; 4];
        assert_eq!(
            reads(&patch(1, &format!("FF E8 00 04 4A 46  FF FE 00 02 {SOF}"))),
            black,
            "APP8"
        );
        assert_eq!(
            reads(&patch(1, &format!("FF FF FF {SOF}"))),
            black,
            "fill bytes"
        );
        assert_eq!(
            reads(&patch(4, "FF FF FF D9")),
            black,
            "fill bytes after the scan"
        );
        assert_eq!(
            reads(&patch(4, "FF FE 00 02 FF D9")),
            black,
            "a comment after the scan"
        );
        assert_eq!(
            reads(&patch(4, "FF D9 01 02 03")),
            black,
            "bytes after the end"
        );
        assert_eq!(
            reads(&patch(2, &format!("FF DD 00 04 00 00 {SOS}"))),
            black,
            "no interval"
        );
        assert_eq!(
            reads(&presets("00 00 00 00 00 00 00 00 00 00")),
            black,
            "all defaults"
        );
        assert_eq!(
            reads(&presets("00 FF 00 03 00 07 00 15 00 40")),
            black,
            "the same, spelled out"
        );
        assert_eq!(
            reads(&patch(1, &format!("FF F8 00 0D 01 00*10 {SOF}"))),
            black,
            "presets first"
        );
        assert_eq!(
            reads(&patch(1, "FF F7 00 0B 08 00 01 00 04 01 01 42 00")),
            black,
            "4 x 2"
        );
        assert_eq!(reads(&patch(3, "F7")), black, "other bits after the last");
    }

    #[test]
    fn what_is_no_stream_is_rejected() {
        rejects("", "byte 0: the stream is empty");
        rejects(
            "D8 FF",
            "byte 0: the stream does not start with SOI, bytes FF D8",
        );
        rejects(
            "FF D8 FF C0",
            "byte 2: expected a JPEG-LS frame header, found marker FFC0",
        );
        rejects(
            "FF D8 FF D9",
            "byte 2: expected a JPEG-LS frame header, found marker FFD9",
        );
        rejects(
            &patch(2, SOF),
            "byte 15: expected the scan header, found marker FFF7",
        );
        rejects(&patch(4, ""), "byte 26: the stream ends before a marker");
        rejects(
            &patch(4, "FF"),
            "byte 27: the stream ends before the code of a marker",
        );
        rejects(
            &patch(4, SOS),
            "byte 26: expected the end of the image, found marker FFDA",
        );
    }

    #[test]
    fn what_is_no_plane_is_rejected() {
        let sof = |content: &str| patch(1, &format!("FF F7 00 0B {content}"));
        rejects(
            &sof("08 00 01 00 05 01 01 11 00"),
            "byte 7: expected 4 x 1 samples, found 5 x 1",
        );
        rejects(
            &sof("08 00 01 00 04 03 01 11 00"),
            "byte 11: expected one component, found 3",
        );
        rejects(
            &sof("01 00 01 00 04 01 01 11 00"),
            "byte 6: samples of 1 bits do not exist here",
        );
        lacks(
            &sof("0C 00 01 00 04 01 01 11 00"),
            "byte 6: samples of 12 bits are not implemented",
        );
        let later = "byte 7: a height defined by DNL is not implemented";
        lacks(&sof("08 00 00 00 04 01 01 11 00"), later);
        lacks(
            &patch(4, "FF DC"),
            "byte 26: a height defined by DNL is not implemented",
        );
    }

    #[test]
    fn preset_parameters_out_of_range_are_rejected() {
        let zeros = "00 00 00 00 00 00 00 00";
        rejects(
            &presets(&format!("01 00 {zeros}")),
            "byte 20: MAXVAL 256 does not fit in 8 bits",
        );
        let t1 = "byte 22: T1 must be within 1 to 255, found 256";
        rejects(&presets("00 FF 01 00 00 00 00 00 00 00"), t1);
        let t2 = "byte 24: T2 must be within 5 to 255, found 4";
        rejects(&presets("00 FF 00 05 00 04 00 00 00 00"), t2);
        let t3 = "byte 26: T3 must be within 7 to 255, found 3";
        rejects(&presets("00 FF 00 00 00 00 00 03 00 00"), t3);
        rejects(
            &presets(&format!("{zeros} 00 02")),
            "byte 28: RESET must be within 3 to 255, found 2",
        );
        rejects(
            &presets(&format!("{zeros} 01 00")),
            "byte 28: RESET must be within 3 to 255, found 256",
        );
        let lse = |content: &str| patch(2, &format!("FF F8 {content} {SOS}"));
        rejects(
            &lse("00 0C 01 00*9"),
            "byte 29: the preset parameter segment ends before RESET",
        );
        rejects(
            &lse("00 0E 01 00*11"),
            "byte 30: the preset parameter segment is 1 bytes too long",
        );
        rejects(
            &lse("00 03 00"),
            "byte 19: no preset parameter segment has type 0",
        );
        lacks(
            &lse("00 05 02 01 01"),
            "byte 19: mapping tables are not implemented",
        );
        lacks(
            &lse("00 05 03 01 01"),
            "byte 19: mapping tables are not implemented",
        );
        lacks(
            &lse("00 07 04 02 00 00"),
            "byte 19: sizes over 65,535 are not implemented",
        );
        lacks(
            &lse("00 03 05"),
            "byte 19: the extensions of T.870 are not implemented",
        );
        let interval = "byte 19: restart intervals in JPEG-LS are not implemented";
        lacks(&patch(2, "FF DD 00 04 00 01"), interval);
    }

    #[test]
    fn scan_headers_that_do_not_fit_are_rejected() {
        let sos = |content: &str| patch(2, &format!("FF DA 00 08 {content}"));
        rejects(
            &sos("02 01 00 00 00 00"),
            "byte 19: expected one component, found 2",
        );
        rejects(
            &sos("01 07 00 00 00 00"),
            "byte 20: the scan is of component 7, the frame has only 1",
        );
        lacks(
            &sos("01 01 01 00 00 00"),
            "byte 21: samples that a mapping table translates are not implemented",
        );
        rejects(
            &sos("01 01 00 80 00 00"),
            "byte 22: NEAR 128 is more than half of MAXVAL 255",
        );
        rejects(
            &sos("01 01 00 00 01 00"),
            "byte 23: one component cannot be interleaved, found ILV 1",
        );
        lacks(
            &sos("01 01 00 00 00 01"),
            "byte 24: a point transform is not implemented",
        );
    }

    #[test]
    fn damaged_data_is_rejected() {
        rejects(
            &patch(3, ""),
            "byte 25: the entropy-coded segment ends too early",
        );
        rejects(
            &patch(3, "00"),
            "byte 26: the entropy-coded segment ends too early",
        );
        rejects(
            &patch(3, "FF"),
            "byte 25: the entropy-coded segment ends too early",
        );
        rejects(
            &patch(3, "F0 00"),
            "byte 26: the entropy-coded segment continues after its last sample",
        );
        rejects(
            &patch(3, "00*5"),
            "byte 25: a code begins with more than 22 zeros",
        );
        // No run; then 22 zeros, a one and 1111 1111: number 256, one more than the largest error.
        rejects(
            &patch(3, "00 00 01 FF 00"),
            "byte 29: no sample has prediction error -129",
        );

        // Four samples, then a run that ends: one more, and another one that interrupts it.
        let five = patch(1, "FF F7 00 0B 08 00 01 00 05 01 01 11 00").replace(DATA, "F4");
        let error = decode(&bytes(&five), 5, 1).expect_err("too long");
        assert_eq!(
            error.to_string(),
            "byte 25: a run of 5 samples and its end in a line with 5 to go"
        );
    }

    /// 65,535 × 65,535 samples would be four gigabytes.
    #[test]
    fn a_short_stream_cannot_claim_a_large_image() {
        let text = patch(1, "FF F7 00 0B 08 FF FF FF FF 01 01 11 00");
        let error = decode(&bytes(&text), 65_535, 65_535).expect_err("too little data");
        assert_eq!(
            error.to_string(),
            "byte 25: 65535 x 65535 samples do not fit in the 3 bytes left"
        );
    }
}
