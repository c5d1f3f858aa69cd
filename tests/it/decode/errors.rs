//! Every error has a witness: the smallest file that provokes it, and its message.

use ptm_conform::error::Class;
use ptm_conform::{Limits, Reading, decode, decode_as};

use crate::table::rows;

/// Returns a header up to the numbers of §2.4.
fn header(format: &str) -> String {
    format!("PTM_1.2\nPTM_FORMAT_{format}\n2\n1\n1 1 1 1 1 1\n0 0 0 0 0 0\n")
}

/// Malformed files: the beginning, the rest, and the message. The beginning is `none`, `size` or `scale` for an RGB file
/// up to §2.3 or §2.4, or the format of a whole header. In the rest, `\s` stands for a space.
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
  | texel data (§2.7), byte 69: the texels need more bytes than can be counted, 0 remain
PTM_C_LUT | 0\n | lookup table indices (§2.8.1), byte 59: the indices need 2 bytes, 0 remain
PTM_C_LUT | 0\n\0\0 | lookup table indices (§2.8), byte 59: index 0 into a table of 0 entries
PTM_C_LUT | 1\n012345678\0\1 | lookup table indices (§2.8), byte 69: index 1 into a table of 1 entries
"#;

/// Replaces escapes in a cell of the table.
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
fn each_malformed_file_is_refused_with_its_message() {
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

#[test]
fn limits_are_not_the_files_fault() {
    let file = header("LRGB") + "0123456789ab012345";
    let limits = Limits { memory: 17 };
    let error = decode_as(file.as_bytes(), &Reading::SPEC, &limits).expect_err("a low limit");
    let message = "image size (§2.3), byte 70: the planes need 18 bytes, the limit is 17";
    assert_eq!(error.to_string(), message);
    assert_eq!(error.class(), Class::Limit);
}
