//! No file makes the decoder panic: it decodes or it says clearly what is wrong.
#![cfg(feature = "harness")]

use proptest::prelude::*;
use ptm_conform::harness::cases::{Suite, TableSpelling};
use ptm_conform::{Limits, Reading, decode, decode_as};

/// The small accepted files of the suite, one of each format and spelling.
fn files() -> Vec<Vec<u8>> {
    let suite = Suite::load().expect("the suite loads");
    let small = suite.cases.iter().filter(|case| {
        case.id.starts_with("header-plain")
            || case.id.starts_with("space-behind-every")
            || case.id.starts_with("hand-")
    });
    small
        .map(|case| case.build(TableSpelling::default()).file.clone())
        .collect()
}

/// The length of the header: all but the payload.
fn header_length(file: &[u8]) -> usize {
    let (fields, _) = ptm_conform::decode::fields(file);
    let payload = fields
        .iter()
        .find(|field| matches!(field.clause, "2.5/3" | "2.7/1"));
    payload.map_or(file.len(), |field| field.range.start)
}

#[track_caller]
fn answers(file: &[u8]) {
    if let Err(error) = decode(file) {
        assert!(error.offset() <= file.len(), "{error}");
        assert!(error.to_string().contains("§2."), "{error}");
    }
}

#[test]
fn a_file_cut_at_any_byte_is_refused() {
    for file in files() {
        for length in 0..file.len() {
            assert!(
                decode(&file[..length]).is_err(),
                "{length} of {} bytes",
                file.len()
            );
        }
    }
}

#[test]
fn any_byte_anywhere_in_the_header_is_answered() {
    for file in files() {
        for place in 0..header_length(&file) {
            for byte in 0..=255 {
                let mut file = file.clone();
                file[place] = byte;
                answers(&file);
            }
        }
    }
}

#[test]
fn sizes_far_beyond_the_file_cost_nothing() {
    for (width, height) in [
        ("4294967295", "1"),
        ("65536", "65536"),
        ("2147483647", "2147483647"),
        ("1", "4294967295"),
    ] {
        for format in ["RGB", "LUM", "LRGB", "PTM_LUT", "PTM_C_LUT"] {
            let rest = if format == "LUM" {
                "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n"
            } else {
                "1\n123456789"
            };
            let file = format!(
                "PTM_1.2\nPTM_FORMAT_{format}\n{width}\n{height}\n1 1 1 1 1 1\n0 0 0 0 0 0\n{rest}"
            );
            assert!(decode(file.as_bytes()).is_err());
        }
    }
}

#[test]
fn numbers_and_lines_of_a_megabyte_are_answered() {
    for long in [
        "1".repeat(1 << 20),
        " ".repeat(1 << 20),
        "0".repeat(1 << 20) + "1",
    ] {
        answers(format!("PTM_1.2\nPTM_FORMAT_LRGB\n{long}\n1\n").as_bytes());
        answers(
            format!(
                "PTM_1.2\nPTM_FORMAT_LRGB\n1\n1\n{long} 1 1 1 1 1\n0 0 0 0 0 {long}\n123456789"
            )
            .as_bytes(),
        );
        answers(long.as_bytes());
    }
}

proptest! {
    #[test]
    fn arbitrary_bytes_are_answered(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        answers(&bytes);
    }

    #[test]
    fn damaged_files_are_answered(which in any::<proptest::sample::Index>(), place in any::<proptest::sample::Index>(), insert in proptest::collection::vec(any::<u8>(), 0..4), remove in 0usize..6) {
        let files = files();
        let mut file = which.get(&files).clone();
        let place = place.index(file.len());
        let end = (place + remove).min(file.len());
        file.splice(place..end, insert);
        answers(&file);
        let _ = decode_as(&file, &Reading::SPEC, &Limits { memory: 100 });
    }
}
