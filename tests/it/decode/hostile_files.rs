//! Tests that no file makes the decoder panic: the decoder either decodes the file or returns a clear error.

use ptm::{Limits, Reading, decode, decode_as};
use ptm_suite::cases::{Case, Suite, TableSpelling};

use crate::random::Rng;

/// Returns the files of the cases for which `is_wanted` returns true.
fn suite_files(is_wanted: impl Fn(&Case) -> bool) -> Vec<Vec<u8>> {
    let suite = Suite::load().expect("the suite loads");
    let cases = suite.cases.iter().filter(|case| is_wanted(case));
    cases
        .map(|case| case.build(TableSpelling::default()).file.clone())
        .collect()
}

/// Returns small legal files of the suite in every format and spelling.
fn files() -> Vec<Vec<u8>> {
    let prefixes = ["header-plain", "space-behind-every", "hand-"];
    suite_files(|case| prefixes.iter().any(|prefix| case.id.starts_with(prefix)))
}

/// Returns the length of the header in bytes.
fn header_length(file: &[u8]) -> usize {
    let (fields, _) = ptm::decode::fields(file);
    let payload = fields
        .iter()
        .find(|field| matches!(field.clause, "2.5/3" | "2.7/1" | "2.9.8/2"));
    payload.map_or(file.len(), |field| field.range.start)
}

#[test]
fn fields_do_not_depend_on_decoding() {
    for file in suite_files(|_| true) {
        let fields = ptm::decode::fields_as(&file, &Reading::SPEC);
        assert_eq!(fields, ptm::decode::fields(&file).0);
    }
}

#[track_caller]
fn assert_decodes_or_fails(file: &[u8]) {
    if let Err(error) = decode(file) {
        assert!(error.offset() <= file.len(), "{error}");
        assert!(error.to_string().contains("§2."), "{error}");
    }
}

#[test]
fn truncated_files_are_refused() {
    for file in files() {
        for length in 0..file.len() {
            let decoded = decode(&file[..length]);
            assert!(decoded.is_err(), "{length} of {} bytes", file.len());
        }
    }
}

#[test]
fn any_header_byte_gives_a_result() {
    for file in files() {
        for at in 0..header_length(&file) {
            for byte in 0..=255 {
                let mut file = file.clone();
                file[at] = byte;
                assert_decodes_or_fails(&file);
            }
        }
    }
}

#[test]
fn huge_sizes_allocate_nothing() {
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
fn megabyte_numbers_and_lines_give_a_result() {
    for long in [
        "1".repeat(1 << 20),
        " ".repeat(1 << 20),
        "0".repeat(1 << 20) + "1",
    ] {
        assert_decodes_or_fails(format!("PTM_1.2\nPTM_FORMAT_LRGB\n{long}\n1\n").as_bytes());
        let numbers = format!("{long} 1 1 1 1 1\n0 0 0 0 0 {long}\n123456789");
        assert_decodes_or_fails(format!("PTM_1.2\nPTM_FORMAT_LRGB\n1\n1\n{numbers}").as_bytes());
        assert_decodes_or_fails(long.as_bytes());
    }
}

/// Decoding a damaged file uses little memory and either succeeds or fails in much less time than the test allows.
#[test]
fn damaged_compressed_files_give_a_result() {
    // Include every format, structure and kind of stream.
    let files = suite_files(|case| {
        let recipe = case.recipe().filter(|recipe| recipe.size.texels() <= 200);
        recipe.is_some() && case.damage().is_none() && case.compression().is_some()
    });
    assert!(files.len() > 100, "{} files", files.len());
    let limits = Limits { memory: 16 << 20 };
    let mut rng = Rng(1);
    let (mut decoded, mut slowest) = (0, std::time::Duration::ZERO);
    for i in 0..3_000 {
        let mut file = files[i % files.len()].clone();
        let header = header_length(&file);
        rng.damage(&mut file, header);
        let start = std::time::Instant::now();
        match decode_as(&file, &Reading::SPEC, &limits) {
            Ok(ptm) => {
                decoded += 1;
                let samples = ptm.planes.samples.len();
                assert!(samples * 2 <= limits.memory, "{samples} samples");
            }
            Err(error) => assert!(error.offset() <= file.len(), "{error}"),
        }
        slowest = slowest.max(start.elapsed());
    }
    println!("{decoded} of 3,000 decoded, the slowest took {slowest:?}");
    // This limit detects hangs. It does not test the speed.
    assert!(slowest.as_secs() < 20, "{slowest:?}");
}
