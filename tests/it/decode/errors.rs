//! Tests every error with a witness: the smallest file that causes the error, and the message.

use ptm::error::Class;
use ptm::{Limits, Reading, decode, decode_as};

use crate::table::rows;

/// Returns a header up to and including §2.4.
fn header(format: &str) -> String {
    format!("PTM_1.2\nPTM_FORMAT_{format}\n2\n1\n1 1 1 1 1 1\n0 0 0 0 0 0\n")
}

/// Malformed files: the start of the file, the rest, and the message. The start is `none` (empty), `size` or `scale` (an RGB
/// header up to §2.3 or §2.4), or the format of a complete header. In the rest, `\s` represents a space.
const WITNESSES: &str = r#"
none | | header string (§2.1), byte 0: expected PTM_1.2, found the end of the file
none | PTM_1.1\n | header string (§2.1), byte 0: expected PTM_1.2, found "PTM_1.1"
none | PTM_1.20\n | header string (§2.1), byte 0: expected PTM_1.2, found "PTM_1.20"
none | PTM_1.2 | file format (§2.0), byte 7: expected the end of the line, found the end of the file
none | PTM_1.2\r\n | header string (§2.1), byte 0: expected PTM_1.2, found "PTM_1.2\r"
none | PTM_1.2  \n | file format (§2.0), byte 7: expected the end of the line, found "  "
none | PTM_1.2\n | format string (§2.2), byte 8: expected the name of a format, found the end of the file
none | PTM_1.2\nPTM_FORMAT_\n | format string (§2.2), byte 8: expected the name of a format, found "PTM_FORMAT_"
size | 0 5\n | image size (§2.3), byte 23: expected a width of at least 1, found "0 5"
size | 5\n0\n | image size (§2.3), byte 25: expected a height of at least 1, found "0"
size | -5\n | image size (§2.3), byte 23: expected a width of at least 1, found "-5"
size | 5 \n\n | image size (§2.3), byte 26: expected a height of at least 1, found "\n"
size | 5,5\n | image size (§2.3), byte 23: expected a width of at least 1, found "5,5"
size | 4294967296\n | image size (§2.3), byte 23: expected a number of at most 4294967295, found "4294967296"
scale | 1 1 x | scale and bias (§2.4), byte 31: expected a scale, found "x"
scale | nan\s | scale and bias (§2.4), byte 27: expected a scale, found "nan "
scale | inf\s | scale and bias (§2.4), byte 27: expected a scale, found "inf "
scale | 1e999\s | scale and bias (§2.4), byte 27: expected a scale, found "1e999 "
scale | 0x1\s | scale and bias (§2.4), byte 27: expected a scale, found "0x1 "
scale | 1_0\s | scale and bias (§2.4), byte 27: expected a scale, found "1_0 "
scale | 1\t1 | scale and bias (§2.4), byte 27: expected a scale, found "1\t1"
scale | 1\n1 | scale and bias (§2.4), byte 28: expected a space, found "\n1"
scale | 1 1 1 1 1 1\n1.5\s | scale and bias (§2.4), byte 39: expected an integer bias, found "1.5 "
scale | 1 1 1 1 1 1\n0 0 0 0 0 0 0\n | file format (§2.0), byte 50: expected the end of the line, found " 0"
PTM_LUT | many\n | lookup table (§2.5), byte 55: expected the number of entries, found "many"
PTM_LUT | 3 ENTRIES\n | lookup table (§2.5), byte 57: expected N_LUT_ENTRIES, found "ENTRIES"
PTM_LUT | 3\n01234567890 | lookup table (§2.5), byte 57: the table's entries need 18 bytes, 11 remain
LUM | 1 2 x | color matrix (§2.6), byte 55: expected a matrix element, found "x"
LUM | 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1\s
  | color matrix (§2.6), byte 81: expected a matrix element, found the end of the file
LRGB | 0123456789 | texel data (§2.7), byte 52: the texels need 12 bytes, 10 remain
LRGB | 0123456789ab01234 | texel data (§2.7), byte 64: the texels need 6 bytes, 5 remain
none | PTM_1.2\nPTM_FORMAT_RGB\n4294967295\n4294967295\n1 1 1 1 1 1\n0 0 0 0 0 0\n
  | texel data (§2.7), byte 69: the texels need more bytes than 64 bits can count, 0 remain
PTM_C_LUT | 0\n | lookup table indices (§2.8.1), byte 59: the indices need 2 bytes, 0 remain
PTM_C_LUT | 0\n\0\0 | lookup table indices (§2.8), byte 59: index 0, but the table has 0 entries
PTM_C_LUT | 1\n012345678\0\1 | lookup table indices (§2.8), byte 69: index 1, but the table has 1 entries
JPEGLS_LRGB | | compressed data (§2.9.1), byte 59: expected a compression parameter, found the end of the file
JPEGLS_LRGB | best\n | compressed data (§2.9.1), byte 59: expected a compression parameter, found "best"
JPEGLS_LRGB | 0\n0 0 x | compressed data (§2.9.2), byte 65: expected a transform, found "x"
JPEGLS_LRGB | 0\n0 0 | compressed data (§2.9), byte 64: expected a space, found the end of the file
JPEGLS_LRGB | 0\n0 0 9999999999999999999
  | compressed data (§2.9.2), byte 65: expected a transform, found "9999999999999999999"
"#;

/// Replaces the escape sequences in a cell of the table.
fn unescape(cell: &str) -> String {
    let escapes = [
        ("\\n", "\n"),
        ("\\r", "\r"),
        ("\\t", "\t"),
        ("\\0", "\0"),
        ("\\1", "\x01"),
        ("\\s", " "),
    ];
    let replace = |text: String, (escape, byte): (&str, &str)| text.replace(escape, byte);
    escapes.into_iter().fold(cell.to_owned(), replace)
}

#[test]
fn malformed_files_give_the_listed_messages() {
    for [beginning, rest, message] in rows(WITNESSES) {
        let beginning = match beginning.as_str() {
            "none" => String::new(),
            "size" => "PTM_1.2\nPTM_FORMAT_RGB\n".to_owned(),
            "scale" => "PTM_1.2\nPTM_FORMAT_RGB\n1\n1\n".to_owned(),
            format => header(format),
        };
        let file = beginning + &unescape(&rest);
        let error = decode(file.as_bytes()).expect_err("the file is malformed");
        assert_eq!(error.to_string(), message);
        assert_eq!(error.class(), Class::Malformed);
        assert!(error.offset() <= file.len());
    }
}

/// The smallest JPEG-LS stream, whose only sample is 0.
const STREAM: &str =
    "FF D8 FF F7 00 0B 08 00 01 00 01 01 01 11 00 FF DA 00 08 01 01 00 00 00 00 80 FF D9";

/// Malformed compressed files: changes to a file with one texel and nine planes, and the message. A change sets a
/// number in a list, or the bytes of a stream or of side information in hexadecimal.
const COMPRESSED_WITNESSES: &str = r#"
transforms 2 4 | compressed data (§2.9.2), byte 65: transforms other than 0 to 3 are not supported
transforms 2 5 | compressed data (§2.9.2), byte 65: transforms other than 0 to 3 are not supported
transforms 2 -1 | compressed data (§2.9.2), byte 65: transforms other than 0 to 3 are not supported
references 1 9 | compressed data (§2.9.5), byte 136: plane 1 is predicted from plane 9, but the last plane is 8
references 0 3 | compressed data (§2.9.4), byte 133:
  plane 0 (rank 0) is predicted from plane 3 (rank 0), which is not decoded before it
references 0 3 ; order 0 4 ; order 3 5 | compressed data (§2.9.4), byte 133:
  plane 0 (rank 4) is predicted from plane 3 (rank 5), which is not decoded before it
references 0 0 ; order 0 4 | compressed data (§2.9.4), byte 133:
  plane 0 (rank 4) is predicted from plane 0 (rank 4), which is not decoded before it
sizes 1 -28 | compressed data (§2.9.6), byte 163: expected a compressed size of at least 0, found "-28"
side-sizes 0 -5 | compressed data (§2.9.7), byte 187: expected a side information size of at least 0, found "-5"
sizes 8 29 | compressed data (§2.9.8), byte 205:
  the compressed planes and their side information need 253 bytes, 252 remain
sizes 0 9223372036854775807 ; sizes 1 9223372036854775807 ; sizes 2 9223372036854775807
  | compressed data (§2.9.8), byte 256:
  the compressed planes and their side information need more bytes than 64 bits can count, 252 remain
side-sizes 3 4 ; side 3 00 00 00 00 | compressed data (§2.9.8), byte 317:
  4 bytes of side information are not a whole number of 5-byte records
side-sizes 8 10 ; side 8 00 00 00 00 07 00 00 00 01 07 | compressed data (§2.9.8), byte 463:
  a record refers to texel 1, but the last texel is 0
side-sizes 8 5 ; side 8 FF FF FF FF 07 | compressed data (§2.9.8), byte 457:
  a record refers to texel 4294967295, but the last texel is 0
sizes 2 0 ; stream 2 | compressed data (§2.9.8), byte 260: plane 2: the stream is empty
sizes 2 2 ; stream 2 D8 FF | compressed data (§2.9.8), byte 260:
  plane 2: the stream does not start with SOI (bytes FF D8)
sizes 2 4 ; stream 2 FF D8 FF C0 | compressed data (§2.9.8), byte 262:
  plane 2: expected a JPEG-LS frame header, found marker FFC0
sizes 2 15 ; stream 2 FF D8 FF F7 00 0B 08 00 01 00 02 01 01 11 00 | compressed data (§2.9.8), byte 268:
  plane 2: expected 1 x 1 samples, found 2 x 1
sizes 2 15 ; stream 2 FF D8 FF F7 00 0B 0C 00 01 00 01 01 01 11 00 | compressed data (§2.9.8), byte 267:
  plane 2: 12-bit samples are not implemented
"#;

/// Applies changes to a file with one texel and nine intra planes of zeros. Returns the changed file.
fn compressed_file(changes: &str) -> Vec<u8> {
    let names = "transforms x y order references sizes side-sizes stream side";
    let mut values = ["0", "0", "0", "0", "-1", "28", "0", STREAM, ""].map(|value| [value; 9]);
    for change in changes.split(';').filter(|change| !change.is_empty()) {
        let (name, rest) = change.trim().split_once(' ').expect("a name");
        let (plane, value) = rest.split_once(' ').unwrap_or((rest, ""));
        let list = names.split(' ').position(|known| known == name);
        values[list.expect("a list")][plane.parse::<usize>().expect("a plane")] = value;
    }
    let [lists @ .., streams, sides] = values;
    let lists = lists.map(|numbers| numbers.join(" ")).join("\n");
    let header = header("JPEGLS_LRGB").replace("\n2\n", "\n1\n") + &format!("0\n{lists}\n");
    let payload = streams.into_iter().zip(sides);
    let bytes = payload.flat_map(|(stream, side)| [stream, side]);
    let bytes = bytes.flat_map(str::split_whitespace);
    let bytes = bytes.map(|byte| u8::from_str_radix(byte, 16).expect("a byte"));
    header.bytes().chain(bytes).collect()
}

#[test]
fn malformed_compressed_files_give_the_listed_messages() {
    for [changes, message] in rows(COMPRESSED_WITNESSES) {
        let error = decode(&compressed_file(&changes)).expect_err(&changes);
        assert_eq!(error.to_string(), message);
        let is_unsupported =
            message.ends_with("not supported") || message.ends_with("not implemented");
        assert_eq!(
            error.class() == Class::Unsupported,
            is_unsupported,
            "{message}"
        );
    }
}

#[test]
fn exceeded_limits_are_not_malformed_files() {
    let plain = header("LRGB") + "0123456789ab012345";
    let size = "image size (§2.3), byte 70: the planes need 18 bytes; the limit is 17";
    let planes = "image size (§2.3), byte 457: the planes need 9 bytes; the limit is 8";
    for (file, memory, message) in [
        (plain.into_bytes(), 17, size),
        (compressed_file(""), 8, planes),
    ] {
        let read = |memory| decode_as(&file, &Reading::SPEC, &Limits { memory });
        let error = read(memory).expect_err("a low limit");
        assert_eq!(error.to_string(), message);
        assert_eq!(error.class(), Class::Limit);
        assert!(read(18).is_ok());
    }
}
