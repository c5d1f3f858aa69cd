//! Every error has a witness: the smallest file that provokes it, and the sentence it is told in.

use ptm_conform::error::Class;
use ptm_conform::{Limits, Reading, decode, decode_as};

/// The beginning of an ordinary file, up to and with the line that `until` begins.
fn header(format: &str) -> String {
    format!("PTM_1.2\nPTM_FORMAT_{format}\n2\n1\n1 1 1 1 1 1\n0 0 0 0 0 0\n")
}

#[track_caller]
fn rejects(file: impl AsRef<[u8]>, message: &str) {
    let error = decode(file.as_ref()).expect_err("the file is malformed");
    assert_eq!(error.to_string(), message);
    assert_eq!(error.class(), Class::Malformed);
    assert!(error.offset() <= file.as_ref().len());
}

#[test]
fn the_header_string_is_checked() {
    rejects(
        "",
        "header string (§2.1), byte 0: expected PTM_1.2, found the end of the file",
    );
    rejects(
        "PTM_1.1\n",
        "header string (§2.1), byte 0: expected PTM_1.2, found \"PTM_1.1\"",
    );
    rejects(
        "PTM_1.20\n",
        "header string (§2.1), byte 0: expected PTM_1.2, found \"PTM_1.20\"",
    );
    rejects(
        "PTM_1.2",
        "file format (§2.0), byte 7: expected the end of the line, found the end of the file",
    );
    rejects(
        "PTM_1.2\r\n",
        "header string (§2.1), byte 0: expected PTM_1.2, found \"PTM_1.2\\r\"",
    );
    rejects(
        "PTM_1.2  \n",
        "file format (§2.0), byte 7: expected the end of the line, found \"  \"",
    );
}

#[test]
fn the_format_string_is_checked() {
    rejects(
        "PTM_1.2\n",
        "format string (§2.2), byte 8: expected the name of a format, found the end of the file",
    );
    rejects(
        "PTM_1.2\nPTM_FORMAT_\n",
        "format string (§2.2), byte 8: expected the name of a format, found \"PTM_FORMAT_\"",
    );
}

#[test]
fn the_size_is_checked() {
    let file = |size: &str| format!("PTM_1.2\nPTM_FORMAT_RGB\n{size}");
    rejects(
        file("0 5\n"),
        "image size (§2.3), byte 23: expected a width of at least 1, found \"0 5\"",
    );
    rejects(
        file("5\n0\n"),
        "image size (§2.3), byte 25: expected a height of at least 1, found \"0\"",
    );
    rejects(
        file("-5\n"),
        "image size (§2.3), byte 23: expected a width of at least 1, found \"-5\"",
    );
    rejects(
        file("5 \n\n"),
        "image size (§2.3), byte 26: expected a height of at least 1, found \"\\n\"",
    );
    rejects(
        file("5,5\n"),
        "image size (§2.3), byte 23: expected a width of at least 1, found \"5,5\"",
    );
    rejects(
        file("4294967296\n"),
        "image size (§2.3), byte 23: expected a number of at most 4294967295, found \"4294967296\"",
    );
}

#[test]
fn scale_and_bias_are_checked() {
    let file = |numbers: &str| format!("PTM_1.2\nPTM_FORMAT_RGB\n1\n1\n{numbers}");
    rejects(
        file("1 1 x"),
        "scale and bias (§2.4), byte 31: expected a scale, found \"x\"",
    );
    rejects(
        file("nan "),
        "scale and bias (§2.4), byte 27: expected a scale, found \"nan \"",
    );
    rejects(
        file("inf "),
        "scale and bias (§2.4), byte 27: expected a scale, found \"inf \"",
    );
    rejects(
        file("1e999 "),
        "scale and bias (§2.4), byte 27: expected a scale, found \"1e999 \"",
    );
    rejects(
        file("0x1 "),
        "scale and bias (§2.4), byte 27: expected a scale, found \"0x1 \"",
    );
    rejects(
        file("1_0 "),
        "scale and bias (§2.4), byte 27: expected a scale, found \"1_0 \"",
    );
    rejects(
        file("1\t1"),
        "scale and bias (§2.4), byte 27: expected a scale, found \"1\\t1\"",
    );
    rejects(
        file("1\n1"),
        "scale and bias (§2.4), byte 28: expected a space, found \"\\n1\"",
    );
    rejects(
        file("1 1 1 1 1 1\n1.5 "),
        "scale and bias (§2.4), byte 39: expected an integer bias, found \"1.5 \"",
    );
    rejects(
        file("1 1 1 1 1 1\n0 0 0 0 0 0 0\n"),
        "file format (§2.0), byte 50: expected the end of the line, found \" 0\"",
    );
}

#[test]
fn the_table_is_checked() {
    let file = |rest: &str| format!("{}{rest}", header("PTM_LUT"));
    rejects(
        file("many\n"),
        "lookup table (§2.5), byte 55: expected the number of entries, found \"many\"",
    );
    rejects(
        file("3 ENTRIES\n"),
        "lookup table (§2.5), byte 57: expected N_LUT_ENTRIES, found \"ENTRIES\"",
    );
    rejects(
        file("3\n01234567890"),
        "lookup table (§2.5), byte 57: the table's entries need 18 bytes, 11 remain",
    );
}

#[test]
fn the_matrix_is_checked() {
    let file = |rest: &str| format!("{}{rest}", header("LUM"));
    rejects(
        file("1 2 x"),
        "color matrix (§2.6), byte 55: expected a matrix element, found \"x\"",
    );
    rejects(
        file(&"1 ".repeat(15)),
        "color matrix (§2.6), byte 81: expected a matrix element, found the end of the file",
    );
}

#[test]
fn the_payload_is_checked() {
    rejects(
        header("LRGB") + "0123456789",
        "texel data (§2.7), byte 52: the texels need 12 bytes, 10 remain",
    );
    rejects(
        header("LRGB") + "0123456789ab01234",
        "texel data (§2.7), byte 64: the texels need 6 bytes, 5 remain",
    );
    let large = "PTM_1.2\nPTM_FORMAT_RGB\n4294967295\n4294967295\n1 1 1 1 1 1\n0 0 0 0 0 0\n";
    rejects(
        large,
        "texel data (§2.7), byte 69: the texels need more bytes than can be counted, 0 remain",
    );
}

#[test]
fn the_indices_are_checked() {
    let file = |rest: &str| format!("{}{rest}", header("PTM_C_LUT"));
    rejects(
        file("0\n"),
        "lookup table indices (§2.8.1), byte 59: the indices need 2 bytes, 0 remain",
    );
    rejects(
        file("0\n\0\0"),
        "lookup table indices (§2.8), byte 59: index 0 into a table of 0 entries",
    );
    rejects(
        file("1\n012345678\0\x01"),
        "lookup table indices (§2.8), byte 69: index 1 into a table of 1 entries",
    );
}

#[test]
fn limits_are_not_the_files_fault() {
    let file = header("LRGB") + "0123456789ab012345";
    let error = decode_as(file.as_bytes(), &Reading::SPEC, &Limits { memory: 17 })
        .expect_err("the limit is too low");
    assert_eq!(
        error.to_string(),
        "image size (§2.3), byte 70: the planes need 18 bytes, the limit is 17"
    );
    assert_eq!(error.class(), Class::Limit);
}
