//! No file makes the decoder panic: it decodes or it says clearly what is wrong.

use proptest::prelude::*;
use ptm_conform::suite::cases::{Case, Suite, TableSpelling};
use ptm_conform::{Limits, Reading, decode, decode_as};

use crate::draws::Draws;

/// The small accepted files of the suite, one of each format and spelling.
fn files() -> Vec<Vec<u8>> {
    let suite = Suite::load().expect("the suite loads");
    let prefixes = ["header-plain", "space-behind-every", "hand-"];
    let is_small = |case: &&Case| prefixes.iter().any(|prefix| case.id.starts_with(prefix));
    let small = suite.cases.iter().filter(is_small);
    small
        .map(|case| case.build(TableSpelling::default()).file.clone())
        .collect()
}

/// The length of the header: all but the payload.
fn header_length(file: &[u8]) -> usize {
    let (fields, _) = ptm_conform::decode::fields(file);
    let payload = fields
        .iter()
        .find(|field| matches!(field.clause, "2.5/3" | "2.7/1" | "2.9.8/2"));
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
            let decoded = decode(&file[..length]);
            assert!(decoded.is_err(), "{length} of {} bytes", file.len());
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
        let numbers = format!("{long} 1 1 1 1 1\n0 0 0 0 0 {long}\n123456789");
        answers(format!("PTM_1.2\nPTM_FORMAT_LRGB\n1\n1\n{numbers}").as_bytes());
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

/// Small compressed files of every format, structure and kind of stream.
fn compressed_files() -> Vec<Vec<u8>> {
    let suite = Suite::load().expect("the suite loads");
    let is_small = |case: &Case| {
        case.recipe()
            .is_some_and(|recipe| recipe.size.texels() <= 200)
    };
    let is_wanted = |case: &Case| case.damage().is_none() && case.compression().is_some();
    let cases = suite.cases.iter();
    let small = cases.filter(|case| is_wanted(case) && is_small(case));
    small
        .map(|case| case.build(TableSpelling::default()).file.clone())
        .collect()
}

/// Changes a few bytes: anywhere, or in the lists, where a digit weighs most.
fn mutate(file: &mut Vec<u8>, header: usize, draws: &mut Draws) {
    for _ in 0..=draws.below(3) {
        let end = [header, file.len()][draws.below(2)];
        let at = draws.below(end.min(file.len()).max(1)).min(file.len() - 1);
        match draws.below(8) {
            0 => file[at] ^= 1 << draws.below(8),
            1 => file[at] = draws.below(256) as u8,
            2 => file[at] = b"0123456789- \n"[draws.below(13)],
            3 => file[at] = [0x00, 0xff, 0x7f, 0x80, 0xd8, 0xda][draws.below(6)],
            4 if file.len() > 1 => drop(file.remove(at)),
            5 => file.insert(at, b"0123456789-. \n"[draws.below(14)]),
            6 => file.truncate(at.max(1)),
            _ => {
                let end = at + draws.below((file.len() - at).min(64));
                let part = file[at..end].to_vec();
                file.splice(at..at, part);
            }
        }
    }
}

/// Decodes damaged files. Each needs little memory, and far less time than the limit.
fn survive_compressed(times: usize) {
    let with_header = |file: Vec<u8>| {
        let (fields, _) = ptm_conform::decode::fields(&file);
        let mut fields = fields.iter();
        let planes = fields.find(|field| field.clause.starts_with("2.9.8"));
        let header = planes.map_or(file.len(), |field| field.range.start);
        (file, header)
    };
    let files: Vec<(Vec<u8>, usize)> = compressed_files().into_iter().map(with_header).collect();
    assert!(files.len() > 100, "{} files", files.len());
    let limits = Limits { memory: 16 << 20 };
    let mut draws = Draws(1);
    let (mut decoded, mut slowest) = (0, std::time::Duration::ZERO);
    for i in 0..times {
        let (file, header) = &files[i % files.len()];
        let mut file = file.clone();
        mutate(&mut file, *header, &mut draws);
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
    println!("{times} files: {decoded} decoded, the slowest took {slowest:?}");
    // No test of speed: a hang is what takes thousands of times as long.
    assert!(slowest.as_secs() < 20, "{slowest:?}");
}

#[test]
fn damaged_compressed_files_are_answered() {
    survive_compressed(3_000);
}

#[test]
#[ignore = "the same for longer"]
fn many_damaged_compressed_files_are_answered() {
    survive_compressed(100_000);
}
