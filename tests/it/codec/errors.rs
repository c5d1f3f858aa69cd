//! Tests every error of the codecs with a witness: the smallest stream that causes the error, and the message.
//!
//! Each row of a table contains a stream and its result. A stream is written as bytes in hexadecimal (`01*64` stands for
//! sixty-four 01 bytes) and names of parts of the smallest stream. A stream may end early if the rest does not matter. A result
//! is an error, or samples that are repeated to fill the image.

use ptm::codec::{StreamError, StreamFault, jpeg, jpeg_ls};

use crate::table::rows;

type Decode = fn(&[u8], u32, u32) -> Result<Vec<u8>, StreamError>;

/// A decoder, and the parts of its smallest stream.
type Codec = (Decode, &'static [(&'static str, &'static str)]);

/// The smallest JPEG stream: one block of 8 × 8 samples, with two one-bit codes.
const JPEG: Codec = (
    jpeg::decode,
    &[
        ("SOI", "FF D8"),
        ("DQT", "FF DB 00 43 00 01*64"),
        ("SOF", "FF C0 00 0B 08 00 08 00 08 01 01 11 00"),
        ("WIDE", "FF C0 00 0B 08 00 08 00 10 01 01 11 00"),
        ("DHT0", "FF C4 00 14 00 01 00*15 00"),
        ("DHT1", "FF C4 00 14 10 01 00*15 00"),
        ("SOS", "FF DA 00 08 01 01 00 00 3F 00"),
        ("DATA", "3F"),
        ("EOI", "FF D9"),
    ],
);

/// The smallest JPEG-LS stream: a run of four zero samples, which is coded as four 1 bits.
const JPEG_LS: Codec = (
    jpeg_ls::decode,
    &[
        ("SOI", "FF D8"),
        ("SOF", "FF F7 00 0B 08 00 01 00 04 01 01 11 00"),
        ("LSE", "FF F8 00 0D 01"),
        ("SOS", "FF DA 00 08 01 01 00 00 00 00"),
        ("DATA", "F0"),
        ("EOI", "FF D9"),
    ],
);

/// Returns the bytes that a cell of a table describes.
fn parse_bytes(cell: &str, parts: &[(&str, &str)]) -> Vec<u8> {
    let word = |word: &str| {
        if let Some((_, part)) = parts.iter().find(|(name, _)| *name == word) {
            return parse_bytes(part, &[]);
        }
        let (digits, times) = word.split_once('*').unwrap_or((word, "1"));
        let byte = u8::from_str_radix(digits, 16).expect("two hexadecimal digits");
        vec![byte; times.parse().expect("a repeat count")]
    };
    cell.split_whitespace().flat_map(word).collect()
}

#[track_caller]
fn check_results((decode, parts): Codec, width: u32, height: u32, table: &str) {
    for [stream, result] in rows(table) {
        match decode(&parse_bytes(&stream, parts), width, height) {
            Ok(samples) => {
                let expected = parse_bytes(&result, &[]);
                let expected = expected.repeat(samples.len() / expected.len());
                assert_eq!(samples, expected, "{stream}");
            }
            Err(error) => {
                assert_eq!(error.to_string(), result, "{stream}");
                let is_unsupported = result.ends_with(" not implemented");
                assert_eq!(error.fault == StreamFault::Unsupported, is_unsupported);
            }
        }
    }
}

/// Unusual valid streams: comments, fill bytes, restart intervals, moved tables, 16-bit steps, SOF1, other sampling factors.
const JPEG_SPELLINGS: &str = "
SOI DQT SOF DHT0 DHT1 SOS DATA EOI | 80
SOI FF E0 00 04 4A 46 FF FE 00 02 DQT SOF DHT0 DHT1 SOS DATA EOI | 80
SOI FF FF FF DQT SOF DHT0 DHT1 SOS DATA EOI | 80
SOI DQT SOF DHT0 DHT1 SOS DATA FF FF EOI | 80
SOI DQT SOF DHT0 DHT1 SOS DATA FF FE 00 03 00 EOI | 80
SOI DQT SOF DHT0 DHT1 FF DD 00 04 00 07 SOS DATA EOI | 80
SOI DQT SOF DQT DHT0 DHT1 SOS DATA EOI | 80
SOI DQT SOF DHT0 DHT1 SOS DATA EOI 01 02 03 | 80
SOI FF DB 00 83 10 01*128 SOF DHT0 DHT1 SOS DATA EOI | 80
SOI DQT FF C1 00 0B 08 00 08 00 08 01 01 43 00 DHT0 DHT1 SOS DATA EOI | 80
SOI DQT SOF FF C4 00 26 00 01 00*15 00 10 01 00*15 00 SOS DATA EOI | 80
";

/// Streams that no encoder writes: their values are out of range for the inverse transform. A DC coefficient of 1,200 · 4 is 600
/// above gray. In ten bits, this wraps to 424 below gray, which is black; plain clamping would produce white. An AC coefficient
/// of 1,000 · 200 has more than fourteen bits. Its result was computed with the C code of the Independent JPEG Group.
const JPEG_EXTREMES: &str = "
SOI FF DB 00 43 00 04*64 SOF FF C4 00 14 00 01 00*15 0B DHT1 SOS 4B 07 EOI | 00
SOI FF DB 00 43 00 C8*64 SOF DHT0 FF C4 00 15 10 00 02 00*14 00 0A SOS 3F 41 EOI | 00 00 FF 00 FF 00 FF FF
";

const JPEG_ERRORS: &str = "
 | byte 0: the stream is empty
EOI | byte 0: the stream does not start with SOI (bytes FF D8)
SOI | byte 2: the stream ends before a marker
SOI FF | byte 3: the stream ends before the code of a marker
SOI 00 | byte 2: expected a marker, found byte 00
SOI EOI | byte 2: expected a frame header, found marker FFD9
SOI FF FE 00 | byte 5: the stream ends before the length of a segment
SOI FF FE 00 01 | byte 4: a comment or application segment has length 1, which is less than 2
SOI FF FE 00 03 | byte 4: a comment or application segment of 3 bytes extends past the end of the stream
SOI FF F7 | byte 2: expected a frame header, found a JPEG-LS frame
SOI DQT WIDE | byte 76: expected 8 x 8 samples, found 16 x 8
SOI DQT FF C0 00 11 08 00 08 00 08 03 01 11 00 02 11 00 03 11 00 | byte 80: expected one component, found 3
SOI DQT FF C0 00 0B 07 00 08 00 08 01 01 11 00 | byte 75: 7-bit samples are not allowed
SOI DQT FF C0 00 0B 08 00 08 00 08 01 01 15 00 | byte 82: sampling factors must be from 1 to 4, found 1 x 5
SOI DQT FF C0 00 0B 08 00 08 00 08 01 01 01 00 | byte 82: sampling factors must be from 1 to 4, found 0 x 1
SOI DQT FF C0 00 0A 08 00 08 00 08 01 01 11
  | byte 83: the frame header ends before the quantization table of the component
SOI DQT FF C0 00 0C 08 00 08 00 08 01 01 11 00 00 | byte 84: the frame header is 1 bytes too long
SOI FF C2 | byte 2: progressive coding (marker FFC2) is not implemented
SOI FF C3 | byte 2: lossless coding (marker FFC3) is not implemented
SOI FF C9 | byte 2: arithmetic coding (marker FFC9) is not implemented
SOI FF CC | byte 2: arithmetic coding (marker FFCC) is not implemented
SOI FF DE | byte 2: hierarchical coding (marker FFDE) is not implemented
SOI DQT FF C1 00 0B 0C 00 08 00 08 01 01 11 00 | byte 75: 12-bit samples are not implemented
SOI DQT FF C0 00 0B 08 00 00 00 08 01 01 11 00 | byte 76: a height defined by DNL is not implemented
SOI DQT SOF DHT0 DHT1 SOS DATA FF DC 00 04 00 08 EOI
  | byte 139: a height defined by DNL (marker FFDC) is not implemented
SOI FF DB 00 03 20 | byte 6: illegal quantization table: precision or class 2, index 0
SOI FF DB 00 03 04 | byte 6: illegal quantization table: precision or class 0, index 4
SOI FF DB 00 03 00 | byte 7: the quantization table segment ends before the 64 quantization steps
SOI FF DB 00 43 00 01*63 00 | byte 70: a quantization step is zero
SOI DQT SOF FF C4 00 03 20 | byte 88: illegal Huffman table: precision or class 2, index 0
SOI DQT SOF FF C4 00 03 04 | byte 88: illegal Huffman table: precision or class 0, index 4
SOI DQT SOF FF C4 00 03 00 | byte 89: the Huffman table segment ends before the 16 code counts
SOI DQT SOF FF C4 00 13 00 01 00*15 | byte 105: the Huffman table segment ends before the symbols of a Huffman table
SOI DQT SOF FF C4 00 15 00 02 00*15 00 01 | byte 89: a Huffman table has too many codes of 1 bits
SOI DQT SOF FF C4 00 13 00 00*14 FF FF | byte 89: a Huffman table has 510 codes; at most 256 are allowed
SOI DQT SOF DHT0 DHT1 FF DD 00 03 00 | byte 133: the restart interval segment ends before the restart interval
SOI DQT SOF DHT0 DHT1 FF DD 00 05 00 00 00 | byte 134: the restart interval segment is 1 bytes too long
SOI SOF DHT0 DHT1 SOS | byte 65: quantization table 0 was not defined
SOI DQT SOF DHT1 SOS | byte 112: DC Huffman table 0 was not defined
SOI DQT SOF DHT0 SOS | byte 112: AC Huffman table 0 was not defined
SOI DQT SOF DHT0 DHT1 DATA | byte 128: expected a marker, found byte 3F
SOI DQT SOF DHT0 DHT1 EOI | byte 128: expected the scan header, found marker FFD9
SOI DQT SOF DHT0 DHT1 SOF | byte 128: expected the scan header, found marker FFC0
SOI DQT SOF DHT0 DHT1 FF DA 00 0A 02 01 00 02 00 00 3F 00 | byte 132: expected one component, found 2
SOI DQT SOF DHT0 DHT1 FF DA 00 08 01 02 00 00 3F 00 | byte 133: expected a scan of component 1, found 2
SOI DQT SOF DHT0 DHT1 FF DA 00 08 01 01 00 00 3E 00
  | byte 135: expected parameters 0 63 0 for a sequential scan, found 0 62 0
SOI DQT SOF DHT0 DHT1 FF DA 00 08 01 01 40 00 3F 00 | byte 134: DC Huffman table 4 was not defined
SOI DQT SOF DHT0 DHT1 FF DA 00 07 01 01 00 00 3F | byte 137: the scan header ends before the parameters of the scan
SOI DQT SOF DHT0 DHT1 SOS EOI | byte 138: the entropy-coded segment ends too early
SOI DQT SOF DHT0 DHT1 SOS BF FF 00 FF 00 EOI | byte 138: the next bits match no code in the Huffman table
SOI DQT SOF DHT0 DHT1 SOS 3F 00 EOI | byte 139: the entropy-coded segment continues after the last sample
SOI DQT SOF DHT0 DHT1 SOS FF EOI | byte 138: the entropy-coded segment ends too early
SOI DQT SOF DHT0 DHT1 SOS DATA | byte 139: the stream ends before a marker
SOI DQT SOF DHT0 DHT1 SOS DATA FF | byte 140: the stream ends before the code of a marker
SOI DQT SOF DHT0 DHT1 SOS DATA FF D0 | byte 139: expected the end of the image, found marker FFD0
SOI DQT SOF FF C4 00 14 00 01 00*15 0C DHT1 SOS DATA EOI | byte 138: no DC difference has 12 bits
SOI DQT SOF DHT0 FF C4 00 14 10 01 00*15 0B SOS DATA EOI | byte 138: no AC code has run 0 and size 11
SOI DQT SOF DHT0 FF C4 00 14 10 01 00*15 10 SOS DATA EOI | byte 138: no AC code has run 1 and size 0
SOI DQT SOF DHT0 FF C4 00 14 10 01 00*15 F0 SOS 07 EOI | byte 138: a run of zeros extends past the end of the block
SOI DQT SOF DHT0 FF C4 00 14 10 01 00*15 F1 SOS 2A EOI | byte 139: a run of zeros extends past the end of the block
";

/// Streams with two blocks. In all rows but the last, DC code 00 means no difference, and 01 means a difference of four bits. 01
/// 1000 0 | 01 1000 0 gives the values 8 and 16, which the transform divides by 8. After a restart marker, the second value is 8
/// again. In the last row, both differences are 2047.
const JPEG_BLOCKS: &str = "
SOI DQT WIDE FF C4 00 15 00 00 02 00*14 00 04 DHT1 SOS 60 C3 EOI | 81*8 82*8
SOI DQT WIDE FF C4 00 15 00 00 02 00*14 00 04 DHT1 FF DD 00 04 00 01 SOS 61 FF D0 61 EOI | 81
SOI DQT WIDE FF C4 00 15 00 00 02 00*14 00 04 DHT1 FF DD 00 04 00 01 SOS 61 FF D1 61 EOI
  | byte 146: expected restart marker 0, found marker FFD1
SOI DQT WIDE FF C4 00 15 00 00 02 00*14 00 04 DHT1 FF DD 00 04 00 01 SOS 60 C3 EOI
  | byte 146: the entropy-coded segment continues after the last sample
SOI DQT WIDE FF C4 00 14 00 01 00*15 0B DHT1 SOS 7F F3 FF 00 BF EOI
  | byte 142: the DC coefficient 4094 is out of range
";

#[test]
fn jpeg_streams_give_the_listed_results() {
    for table in [JPEG_SPELLINGS, JPEG_EXTREMES, JPEG_ERRORS] {
        check_results(JPEG, 8, 8, table);
    }
    check_results(JPEG, 16, 8, JPEG_BLOCKS);
    let huge = "SOI DQT FF C0 00 0B 08 FF FF FF FF 01 01 11 00 DHT0 DHT1 SOS DATA EOI \
        | byte 138: 65535 x 65535 samples cannot be coded in the 3 bytes left";
    check_results(JPEG, 65_535, 65_535, huge);
}

/// Unusual valid streams: comments, fill bytes, a restart interval of 0, preset parameters that equal the
/// defaults or precede the frame header, other sampling factors, and other padding bits.
const JPEG_LS_SPELLINGS: &str = "
SOI SOF SOS DATA EOI | 00
SOI FF E8 00 04 4A 46 FF FE 00 02 SOF SOS DATA EOI | 00
SOI FF FF FF SOF SOS DATA EOI | 00
SOI SOF SOS DATA FF FF EOI | 00
SOI SOF SOS DATA FF FE 00 02 EOI | 00
SOI SOF SOS DATA EOI 01 02 03 | 00
SOI SOF FF DD 00 04 00 00 SOS DATA EOI | 00
SOI SOF LSE 00*10 SOS DATA EOI | 00
SOI SOF LSE 00 FF 00 03 00 07 00 15 00 40 SOS DATA EOI | 00
SOI LSE 00*10 SOF SOS DATA EOI | 00
SOI FF F7 00 0B 08 00 01 00 04 01 01 42 00 SOS DATA EOI | 00
SOI SOF SOS F7 EOI | 00
";

/// Invalid streams. In the last row, an empty run, 22 zero bits, a one bit and the bits 1111 1111 encode the mapped error 256,
/// which is too large.
const JPEG_LS_ERRORS: &str = "
 | byte 0: the stream is empty
D8 FF | byte 0: the stream does not start with SOI (bytes FF D8)
SOI FF C0 | byte 2: expected a JPEG-LS frame header, found marker FFC0
SOI EOI | byte 2: expected a JPEG-LS frame header, found marker FFD9
SOI SOF SOF | byte 15: expected the scan header, found marker FFF7
SOI SOF SOS DATA | byte 26: the stream ends before a marker
SOI SOF SOS DATA FF | byte 27: the stream ends before the code of a marker
SOI SOF SOS DATA SOS | byte 26: expected the end of the image, found marker FFDA
SOI SOF SOS DATA FF DC | byte 26: a height defined by DNL is not implemented
SOI FF F7 00 0B 08 00 01 00 05 01 01 11 00 | byte 7: expected 4 x 1 samples, found 5 x 1
SOI FF F7 00 0B 08 00 01 00 04 03 01 11 00 | byte 11: expected one component, found 3
SOI FF F7 00 0B 01 00 01 00 04 01 01 11 00 | byte 6: 1-bit samples are not allowed
SOI FF F7 00 0B 09 00 01 00 04 01 01 11 00 | byte 6: 9-bit samples are not implemented
SOI FF F7 00 0B 0C 00 01 00 04 01 01 11 00 | byte 6: 12-bit samples are not implemented
SOI FF F7 00 0B 08 00 00 00 04 01 01 11 00 | byte 7: a height defined by DNL is not implemented
SOI SOF LSE 01 00 00*8 SOS | byte 20: MAXVAL 256 does not fit in 8 bits
SOI FF F7 00 0B 07 00 01 00 04 01 01 11 00 LSE 00 80 00*8 SOS | byte 20: MAXVAL 128 does not fit in 7 bits
SOI SOF LSE 00 FF 01 00 00*6 SOS | byte 22: T1 must be from 1 to 255, found 256
SOI SOF LSE 00 FF 00 05 00 04 00*4 SOS | byte 24: T2 must be from 5 to 255, found 4
SOI SOF LSE 00 FF 00*4 00 03 00 00 SOS | byte 26: T3 must be from 7 to 255, found 3
SOI SOF LSE 00*8 00 02 SOS | byte 28: RESET must be from 3 to 255, found 2
SOI SOF LSE 00*8 01 00 SOS | byte 28: RESET must be from 3 to 255, found 256
SOI SOF FF F8 00 0C 01 00*9 | byte 29: the preset parameter segment ends before RESET
SOI SOF FF F8 00 0E 01 00*11 | byte 30: the preset parameter segment is 1 bytes too long
SOI SOF FF F8 00 03 00 | byte 19: a preset parameter segment has unknown type 0
SOI SOF FF F8 00 05 02 01 01 | byte 19: mapping tables are not implemented
SOI SOF FF F8 00 05 03 01 01 | byte 19: mapping tables are not implemented
SOI SOF FF F8 00 06 04 02 00 00 | byte 19: sizes over 65,535 are not implemented
SOI SOF FF F8 00 03 05 | byte 19: the extensions of T.870 are not implemented
SOI SOF FF DD 00 04 00 01 | byte 19: restart intervals in JPEG-LS are not implemented
SOI SOF FF DA 00 08 02 01 00 00 00 00 | byte 19: expected one component, found 2
SOI SOF FF DA 00 08 01 07 00 00 00 00 | byte 20: expected a scan of component 1, found 7
SOI SOF FF DA 00 08 01 01 01 00 00 00 | byte 21: mapping tables are not implemented
SOI SOF FF DA 00 08 01 01 00 80 00 00 | byte 22: NEAR 128 is more than half of MAXVAL 255
SOI SOF FF DA 00 08 01 01 00 00 01 00 | byte 23: a single component cannot be interleaved, found ILV 1
SOI SOF FF DA 00 08 01 01 00 00 00 01 | byte 24: point transforms are not implemented
SOI SOF SOS EOI | byte 25: the entropy-coded segment ends too early
SOI SOF SOS 00 EOI | byte 26: the entropy-coded segment ends too early
SOI SOF SOS FF EOI | byte 25: the entropy-coded segment ends too early
SOI SOF SOS F0 00 EOI | byte 26: the entropy-coded segment continues after the last sample
SOI SOF SOS 00*5 EOI | byte 25: a code begins with more than 22 zeros
SOI SOF SOS 00 00 01 FF 00 EOI | byte 29: the prediction error -129 is out of range
";

#[test]
fn jpeg_ls_streams_give_the_listed_results() {
    check_results(JPEG_LS, 4, 1, JPEG_LS_SPELLINGS);
    check_results(JPEG_LS, 4, 1, JPEG_LS_ERRORS);
    // 0: empty run. Then 1 and 11, because k = 2: mapped error 3, which is error 2.
    let interrupted = "SOI FF F7 00 0B 08 00 01 00 01 01 01 11 00 SOS 70 EOI | 02";
    check_results(JPEG_LS, 1, 1, interrupted);
    // Four samples, then the end of the run: one more sample, and one that interrupts the run.
    let long = "SOI FF F7 00 0B 08 00 01 00 05 01 01 11 00 SOS F4 EOI \
        | byte 25: a run of 5 samples is interrupted, but the line has only 5 left";
    check_results(JPEG_LS, 5, 1, long);
    let huge = "SOI FF F7 00 0B 08 FF FF FF FF 01 01 11 00 SOS DATA EOI \
        | byte 25: 65535 x 65535 samples cannot be coded in the 3 bytes left";
    check_results(JPEG_LS, 65_535, 65_535, huge);
}
