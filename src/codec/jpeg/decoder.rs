//! T.81 B.2.1: the order of a stream, read
//!
//! ```text
//! SOI  [tables]  SOF0 or SOF1  [tables]  SOS  entropy-coded data  [tables]  EOI
//! ```
//!
//! Format notes
//! - Tables may be defined again; the last definition before the scan header counts.
//! - SOF0 (baseline) and SOF1 (extended) differ in what tables they may use. For samples of 8 bits
//!   a decoder that can read SOF1 can read both alike.
//! - The frame header of another process follows the same SOI; only its marker identifies
//!   the process.

use super::processes::unexpected;
use super::scan::{ScanTables, decode_scan};
use super::tables::Tables;
use crate::codec::bit_buffer::BitBuffer;
use crate::codec::headers::{FrameHeader, ScanHeader};
use crate::codec::markers::{Cursor, EOI, SOS};
use crate::codec::stream_error::{Result, malformed};

/// Frame headers of JPEG only (Table B.1): baseline and extended sequential, Huffman coded.
const SOF0: u8 = 0xC0;
const SOF1: u8 = 0xC1;

/// Decodes a JPEG stream of one component and `width` × `height` samples, in row order from the top.
///
/// # Errors
///
/// [`StreamFault::Malformed`](crate::codec::StreamFault) if the stream violates the standard, has
/// another size or another number of components;
/// [`StreamFault::Unsupported`](crate::codec::StreamFault) for the processes of T.81 other than
/// sequential Huffman with 8 bits.
pub fn decode(stream: &[u8], width: u32, height: u32) -> Result<Vec<u8>> {
    let mut stream = Cursor::open(stream)?;
    let mut tables = Tables::default();
    let scan_tables = read_headers(&mut stream, &mut tables, width, height)?;
    // The fast version; `Bits<0>` in place of `BitBuffer<0>` is the plain one.
    let samples = decode_scan::<BitBuffer<0>>(&mut stream, &scan_tables, width, height)?;
    expect(&mut stream, &mut tables, &[EOI], "the end of the image")?;
    Ok(samples)
}

/// Reads everything before the entropy-coded data.
pub(super) fn read_headers(
    stream: &mut Cursor,
    tables: &mut Tables,
    width: u32,
    height: u32,
) -> Result<ScanTables> {
    expect(stream, tables, &[SOF0, SOF1], "a frame header")?;
    let frame = FrameHeader::read(stream, width, height, &[12])?;
    expect(stream, tables, &[SOS], "the scan header")?;
    let scan = ScanHeader::read(stream, &frame)?;
    tables_of_scan(tables, &frame, &scan)
}

/// Reads tables up to one of these markers.
fn expect(stream: &mut Cursor, tables: &mut Tables, codes: &[u8], what: &str) -> Result<()> {
    let marker = tables.read(stream)?;
    match codes.contains(&marker.code) {
        true => Ok(()),
        false => Err(unexpected(marker, what)),
    }
}

/// Returns the tables that the headers name (B.2.3).
fn tables_of_scan(tables: &Tables, frame: &FrameHeader, scan: &ScanHeader) -> Result<ScanTables> {
    // The whole spectrum at once, and no successive approximation: the rest is for progressive
    // frames (Table B.3).
    if scan.parameters != [0, 63, 0] {
        let [first, last, approximation] = scan.parameters;
        let found = format!("{first} {last} {approximation}");
        let what = format!("a sequential scan has parameters 0 63 0, found {found}");
        return Err(malformed(scan.at + 1, what));
    }
    let (dc, ac) = (scan.tables >> 4, scan.tables & 15);
    tables.of_scan(frame.quantization_table, dc, ac, scan.at)
}

#[cfg(test)]
mod tests {
    use super::decode;
    use crate::codec::StreamFault;
    use crate::codec::witness::bytes;

    // The smallest stream: one block of 8 × 8 samples, with two codes of one bit.
    const SOI: &str = "FF D8";
    const DQT: &str = "FF DB 00 43  00  01*64";
    const SOF: &str = "FF C0 00 0B  08  00 08 00 08  01  01 11 00";
    const DC: &str = "FF C4 00 14  00  01 00*15  00";
    const AC: &str = "FF C4 00 14  10  01 00*15  00";
    const SOS: &str = "FF DA 00 08  01  01 00  00 3F 00";
    const DATA: &str = "3F";
    const EOI: &str = "FF D9";

    /// Returns the smallest stream with one of its eight parts replaced.
    fn patch(part: usize, other: &str) -> String {
        let mut parts = [SOI, DQT, SOF, DC, AC, SOS, DATA, EOI];
        parts[part] = other;
        parts.join(" ")
    }

    #[track_caller]
    fn reads(text: &str) -> Vec<u8> {
        decode(&bytes(text), 8, 8).unwrap_or_else(|error| panic!("{error}"))
    }

    #[track_caller]
    fn refuses(fault: StreamFault, text: &str, expected: &str) {
        let error = decode(&bytes(text), 8, 8).expect_err("an error");
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
    fn the_smallest_stream_is_gray() {
        assert_eq!(reads(&patch(0, SOI)), [128; 64]);
    }

    #[test]
    fn one_picture_may_be_spelled_in_many_ways() {
        let gray = [128; 64];
        let more = |part: usize, what: &str, text: &str| patch(part, &format!("{what} {text}"));
        assert_eq!(
            reads(&more(1, "FF E0 00 04 4A 46  FF FE 00 02", DQT)),
            gray,
            "APP0 and COM"
        );
        assert_eq!(reads(&more(1, "FF FF FF", DQT)), gray, "fill bytes");
        assert_eq!(
            reads(&more(7, "FF FF", EOI)),
            gray,
            "fill bytes after the scan"
        );
        assert_eq!(
            reads(&more(7, "FF FE 00 03 00", EOI)),
            gray,
            "a comment after the scan"
        );
        assert_eq!(
            reads(&more(5, "FF DD 00 04 00 07", SOS)),
            gray,
            "an interval of 7 blocks"
        );
        assert_eq!(
            reads(&more(3, DQT, DC)),
            gray,
            "tables defined twice and late"
        );
        assert_eq!(
            reads(&patch(7, "FF D9 01 02 03")),
            gray,
            "bytes after the end"
        );
        assert_eq!(
            reads(&patch(1, "FF DB 00 83  10  01*128")),
            gray,
            "16-bit steps"
        );
        let sof1 = "FF C1 00 0B  08  00 08 00 08  01  01 43 00";
        assert_eq!(reads(&patch(2, sof1)), gray, "SOF1, factors 4 x 3");
        let both = "FF C4 00 26  00  01 00*15  00  10  01 00*15  00";
        let text = [SOI, DQT, SOF, both, SOS, DATA, EOI].join(" ");
        assert_eq!(reads(&text), gray, "two tables in one segment");
    }

    /// Two blocks with a marker between them; the difference of the second starts at zero again.
    #[test]
    fn a_restart_marker_forgets_the_block_before() {
        let sof = "FF C0 00 0B  08  00 08 00 10  01  01 11 00";
        let dc = "FF C4 00 15  00  00 02 00*14  00 04"; // 00: no difference, 01: four bits
        let interval = format!("FF DD 00 04 00 01 {SOS}");
        let read = |sos: &str, data: &str| {
            let text = [SOI, DQT, sof, dc, AC, sos, data, EOI].join(" ");
            decode(&bytes(&text), 16, 8).map(|samples| (samples[0], samples[8]))
        };
        // 01 1000 0 | 01 1000 0: eight and then sixteen, divided by eight by the transform
        assert_eq!(read(SOS, "60 C3"), Ok((129, 130)));
        assert_eq!(read(&interval, "61 FF D0 61"), Ok((129, 129)));
        let error = read(&interval, "61 FF D1 61").expect_err("the wrong marker");
        assert_eq!(
            error.to_string(),
            "byte 146: expected restart marker 0, found marker FFD1"
        );
        let error = read(&interval, "60 C3").expect_err("no marker");
        assert_eq!(
            error.to_string(),
            "byte 146: the entropy-coded segment continues after its last sample"
        );
    }

    #[test]
    fn what_is_no_stream_is_rejected() {
        rejects("", "byte 0: the stream is empty");
        rejects(
            "FF D9",
            "byte 0: the stream does not start with SOI, bytes FF D8",
        );
        rejects("FF D8", "byte 2: the stream ends before a marker");
        rejects(
            "FF D8 FF",
            "byte 3: the stream ends before the code of a marker",
        );
        rejects("FF D8 00", "byte 2: expected a marker, found byte 00");
        rejects(
            "FF D8 FF D9",
            "byte 2: expected a frame header, found marker FFD9",
        );
        rejects(
            "FF D8 FF FE 00",
            "byte 5: the stream ends before the length of a segment",
        );
        rejects(
            "FF D8 FF FE 00 01",
            "byte 4: a comment or application segment has length 1, which does not cover itself",
        );
        rejects(
            "FF D8 FF FE 00 03",
            "byte 4: a comment or application segment of 3 bytes extends past the end of the stream",
        );
        rejects(
            "FF D8 FF F7",
            "byte 2: expected a frame header, found a JPEG-LS frame",
        );
    }

    #[test]
    fn what_is_no_plane_is_rejected() {
        rejects(
            &patch(2, "FF C0 00 0B 08 00 08 00 09 01 01 11 00"),
            "byte 76: expected 8 x 8 samples, found 9 x 8",
        );
        rejects(
            &patch(
                2,
                "FF C0 00 11 08 00 08 00 08 03 01 11 00 02 11 00 03 11 00",
            ),
            "byte 80: expected one component, found 3",
        );
        rejects(
            &patch(2, "FF C0 00 0B 07 00 08 00 08 01 01 11 00"),
            "byte 75: samples of 7 bits do not exist here",
        );
        rejects(
            &patch(2, "FF C0 00 0B 08 00 08 00 08 01 01 15 00"),
            "byte 82: sampling factors 1 x 5 are not within 1 to 4",
        );
        rejects(
            &patch(2, "FF C0 00 0B 08 00 08 00 08 01 01 01 00"),
            "byte 82: sampling factors 0 x 1 are not within 1 to 4",
        );
        rejects(
            &patch(2, "FF C0 00 0A 08 00 08 00 08 01 01 11"),
            "byte 83: the frame header ends before the quantization table of the component",
        );
        rejects(
            &patch(2, "FF C0 00 0C 08 00 08 00 08 01 01 11 00 00"),
            "byte 84: the frame header is 1 bytes too long",
        );
    }

    #[test]
    fn the_other_processes_are_not_implemented() {
        lacks(
            "FF D8 FF C2",
            "byte 2: progressive coding (marker FFC2) is not implemented",
        );
        lacks(
            "FF D8 FF C3",
            "byte 2: lossless coding (marker FFC3) is not implemented",
        );
        lacks(
            "FF D8 FF C9",
            "byte 2: arithmetic coding (marker FFC9) is not implemented",
        );
        lacks(
            "FF D8 FF CC",
            "byte 2: arithmetic coding (marker FFCC) is not implemented",
        );
        lacks(
            "FF D8 FF DE",
            "byte 2: hierarchical coding (marker FFDE) is not implemented",
        );
        lacks(
            &patch(2, "FF C1 00 0B 0C 00 08 00 08 01 01 11 00"),
            "byte 75: samples of 12 bits are not implemented",
        );
        lacks(
            &patch(2, "FF C0 00 0B 08 00 00 00 08 01 01 11 00"),
            "byte 76: a height defined by DNL is not implemented",
        );
        lacks(
            &patch(7, "FF DC 00 04 00 08 FF D9"),
            "byte 139: a height defined by DNL (marker FFDC) is not implemented",
        );
    }

    #[test]
    fn tables_that_are_none_are_rejected() {
        rejects(
            &patch(1, "FF DB 00 03 20"),
            "byte 6: no quantization table has precision or class 2 and number 0",
        );
        rejects(
            &patch(1, "FF DB 00 03 04"),
            "byte 6: no quantization table has precision or class 0 and number 4",
        );
        rejects(
            &patch(1, "FF DB 00 03 00"),
            "byte 7: the quantization table segment ends before 64 quantization steps",
        );
        rejects(
            &patch(1, "FF DB 00 43 00 01*63 00"),
            "byte 70: a quantization step is zero",
        );
        rejects(
            &patch(3, "FF C4 00 03 20"),
            "byte 88: no Huffman table has precision or class 2 and number 0",
        );
        rejects(
            &patch(3, "FF C4 00 03 04"),
            "byte 88: no Huffman table has precision or class 0 and number 4",
        );
        rejects(
            &patch(3, "FF C4 00 03 00"),
            "byte 89: the Huffman table segment ends before 16 numbers of codes",
        );
        rejects(
            &patch(3, "FF C4 00 13 00 01 00*15"),
            "byte 105: the Huffman table segment ends before the symbols of a Huffman table",
        );
        rejects(
            &patch(3, "FF C4 00 15 00 02 00*15 00 01"),
            "byte 89: a Huffman table has too many codes of 1 bits",
        );
        rejects(
            &patch(3, "FF C4 00 13 00 00*14 FF FF"),
            "byte 89: a Huffman table of 510 codes has more than 256",
        );
        rejects(
            &patch(5, "FF DD 00 03 00"),
            "byte 133: the restart interval segment ends before the restart interval",
        );
        rejects(
            &patch(5, "FF DD 00 05 00 00 00"),
            "byte 134: the restart interval segment is 1 bytes too long",
        );
    }

    #[test]
    fn scan_headers_that_do_not_fit_are_rejected() {
        rejects(
            &patch(1, ""),
            "byte 65: quantization table 0 was not defined",
        );
        rejects(
            &patch(3, ""),
            "byte 112: DC Huffman table 0 was not defined",
        );
        rejects(
            &patch(4, ""),
            "byte 112: AC Huffman table 0 was not defined",
        );
        rejects(&patch(5, ""), "byte 128: expected a marker, found byte 3F");
        rejects(
            &patch(5, "FF D9"),
            "byte 128: expected the scan header, found marker FFD9",
        );
        rejects(
            &patch(5, SOF),
            "byte 128: expected the scan header, found marker FFC0",
        );
        rejects(
            &patch(5, "FF DA 00 0A 02 01 00 02 00 00 3F 00"),
            "byte 132: expected one component, found 2",
        );
        rejects(
            &patch(5, "FF DA 00 08 01 02 00 00 3F 00"),
            "byte 133: the scan is of component 2, the frame has only 1",
        );
        rejects(
            &patch(5, "FF DA 00 08 01 01 00 00 3E 00"),
            "byte 135: a sequential scan has parameters 0 63 0, found 0 62 0",
        );
        rejects(
            &patch(5, "FF DA 00 08 01 01 40 00 3F 00"),
            "byte 134: DC Huffman table 4 was not defined",
        );
        rejects(
            &patch(5, "FF DA 00 07 01 01 00 00 3F"),
            "byte 137: the scan header ends before its parameters",
        );
    }

    #[test]
    fn damaged_data_is_rejected() {
        rejects(
            &patch(6, ""),
            "byte 138: the entropy-coded segment ends too early",
        );
        rejects(
            &patch(6, "BF FF 00 FF 00"),
            "byte 138: the next bits are no code of the Huffman table",
        );
        rejects(
            &patch(6, "3F 00"),
            "byte 139: the entropy-coded segment continues after its last sample",
        );
        rejects(
            &patch(6, "FF"),
            "byte 138: the entropy-coded segment ends too early",
        );
        rejects(&patch(7, ""), "byte 139: the stream ends before a marker");
        rejects(
            &patch(7, "FF"),
            "byte 140: the stream ends before the code of a marker",
        );
        rejects(
            &patch(7, "FF D0"),
            "byte 139: expected the end of the image, found marker FFD0",
        );
        let (dc, ac) = (
            |symbol| format!("FF C4 00 14 00 01 00*15 {symbol}"),
            |symbol| format!("FF C4 00 14 10 01 00*15 {symbol}"),
        );
        rejects(
            &patch(3, &dc("0C")),
            "byte 138: a DC difference of 12 bits does not exist",
        );
        rejects(
            &patch(4, &ac("0B")),
            "byte 138: an AC code for run 0, size 11 does not exist",
        );
        rejects(
            &patch(4, &ac("10")),
            "byte 138: an AC code for run 1, size 0 does not exist",
        );
        // Four runs of sixteen are one too many; so is a run of fifteen before the last
        // coefficient.
        let runs = |symbol, data| [SOI, DQT, SOF, DC, &ac(symbol), SOS, data, EOI].join(" ");
        rejects(
            &runs("F0", "07"),
            "byte 138: a run of zeros leaves the block",
        );
        rejects(
            &runs("F1", "2A"),
            "byte 139: a run of zeros leaves the block",
        );
        // Two blocks, each a difference of eleven bits 1 and an end of block.
        let sof = "FF C0 00 0B 08 00 08 00 10 01 01 11 00";
        let text = [SOI, DQT, sof, &dc("0B"), AC, SOS, "7F F3 FF 00 BF", EOI].join(" ");
        let error = decode(&bytes(&text), 16, 8).expect_err("too large");
        assert_eq!(
            error.to_string(),
            "byte 142: a DC coefficient of 4094 does not exist"
        );
    }

    /// 65,535 × 65,535 samples would be four gigabytes.
    #[test]
    fn a_short_stream_cannot_claim_a_large_image() {
        let text = patch(2, "FF C0 00 0B 08 FF FF FF FF 01 01 11 00");
        let error = decode(&bytes(&text), 65_535, 65_535).expect_err("too little data");
        assert_eq!(
            error.to_string(),
            "byte 138: 65535 x 65535 samples do not fit in the 3 bytes left"
        );
    }

    /// A DC coefficient of 1,200 times 4 is 600 above gray, which in ten bits is 424 below it. So it is black, but would be
    /// white with clamping alone. No encoder writes it.
    #[test]
    fn samples_are_cut_to_ten_bits_before_they_are_clamped() {
        let dqt = "FF DB 00 43 00 04*64";
        let dc = "FF C4 00 14 00 01 00*15 0B";
        let text = [SOI, dqt, SOF, dc, AC, SOS, "4B 07", EOI].join(" ");
        assert_eq!(reads(&text), [0; 64]);
    }

    /// An AC coefficient of 1,000 times 200, as the Group's own C code returns it.
    #[test]
    fn frequencies_of_over_fourteen_bits_lose_nothing() {
        let dqt = "FF DB 00 43 00 C8*64";
        let ac = "FF C4 00 15 10 00 02 00*14 00 0A";
        let text = [SOI, dqt, SOF, DC, ac, SOS, "3F 41", EOI].join(" ");
        assert_eq!(reads(&text), [0, 0, 255, 0, 255, 0, 255, 255].repeat(8)[..]);
    }
}
