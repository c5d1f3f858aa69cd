//! Tests of the lint findings for the files of the suite.

use std::collections::BTreeSet;
use std::ops::Range;

use ptm::Size;
use ptm_files::lint::codes::{ALL, Code, Severity};
use ptm_files::lint::diagnostic::Diagnostic;
use ptm_files::lint::lint;
use ptm_suite::cases::{Case, Expect, TableSpelling};

use crate::in_process::suite;

/// Returns an LRGB file with scale 1 and bias 0. All texels have the same coefficients and color.
fn uniform_file(size: &str, scale: u32, coefficients: [u8; 6], color: [u8; 3]) -> Vec<u8> {
    let size: Size = size.parse().expect("a size");
    let Size { width, height } = size;
    let scales = vec![scale.to_string(); 6].join(" ");
    let header = format!("PTM_1.2\nPTM_FORMAT_LRGB\n{width}\n{height}\n{scales}\n0 0 0 0 0 0\n");
    let (coefficients, colors) = (
        coefficients.repeat(size.texels()),
        color.repeat(size.texels()),
    );
    [header.as_bytes(), &coefficients, &colors].concat()
}

/// Returns a map of noise whose payload begins at byte 56, with equal bytes in `range`.
fn overwritten_file(range: Range<usize>) -> Vec<u8> {
    let mut file = uniform_file("100x100", 1, [1; 6], [1; 3]);
    let mut state = 1_u32;
    for byte in &mut file[56..] {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *byte = (state >> 24) as u8 | 1;
    }
    file[range].fill(0);
    file
}

/// Returns a map of noise whose lower part is masked: zero luminance and black.
fn masked_file() -> Vec<u8> {
    let mut file = overwritten_file(0..0);
    file[56 + 6 * 4321..60_056].fill(0);
    file[60_056 + 3 * 4321..].fill(0);
    file
}

/// Converts a file from Latin-1 to UTF-8.
fn as_utf8(file: &[u8]) -> Vec<u8> {
    let text: String = file.iter().map(|&byte| char::from(byte)).collect();
    text.into_bytes()
}

/// Returns files for the codes that no file of the suite triggers.
fn made_files() -> Vec<(&'static str, Vec<u8>)> {
    let noise = overwritten_file(0..0);
    let header = "PTM_1.2\nPTM_FORMAT_PTM_C_LUT\n2\n2\n1 1 1 1 1 1\n0 0 0 0 0 0\n4\n";
    let entries: Vec<u8> = (150..186).collect();
    let table = [header.as_bytes(), &entries, &[0, 1, 2, 3]].concat();
    vec![
        ("PTM-E071", as_utf8(&noise)),
        ("PTM-E071", as_utf8(&noise)[..noise.len()].to_vec()),
        ("PTM-E071", as_utf8(&table)),
        ("PTM-E072", [&noise[..], &noise].concat()),
        (
            "PTM-I205",
            uniform_file("2x2", 1, [0, 0, 0, 0, 0, 200], [9, 99, 255]),
        ),
        ("PTM-I206", uniform_file("2x2", 1, [0; 6], [9, 99, 255])),
        ("PTM-I206", uniform_file("2x2", 160, [255; 6], [255; 3])),
        ("PTM-I207", overwritten_file(1024..1024 + 4096)),
        ("PTM-I207", overwritten_file(2048..56 + 90_000)),
        // The values beside the sectors may be zero as well.
        ("PTM-I207", overwritten_file(1023..1024 + 4097)),
        // One sector, in the luminance and in the colors.
        ("PTM-I207", overwritten_file(1024..1024 + 512)),
        ("PTM-I207", overwritten_file(71_680..71_680 + 512)),
        // Incomplete copies, which end in the luminance, in the colors, and almost at the end.
        ("PTM-I207", overwritten_file(45_000..56 + 90_000)),
        ("PTM-I207", overwritten_file(70_000..56 + 90_000)),
        ("PTM-I207", overwritten_file(89_782..56 + 90_000)),
    ]
}

#[test]
fn codes_without_cases_are_triggered_by_made_files() {
    for (code, file) in made_files() {
        let findings = lint(&file);
        let codes: Vec<&str> = findings.iter().map(|finding| finding.code).collect();
        assert!(codes.contains(&code), "{code} is not found: {codes:?}");
    }
}

#[test]
fn undamaged_payloads_are_not_reported() {
    let is_found = |file: &[u8], code: &str| lint(file).iter().any(|finding| finding.code == code);
    for file in [
        overwritten_file(0..0),
        // Too short, and up to the end of a row.
        overwritten_file(1025..1025 + 1022),
        overwritten_file(90_056 - 255..90_056),
        overwritten_file(512..56 + 11 * 600),
        // White texels within a row, and maps of one value.
        overwritten_file(60_056 + 30 * 70..60_056 + 30 * 170),
        uniform_file("100x100", 1, [0; 6], [0; 3]),
        uniform_file("100x100", 1, [1; 6], [0; 3]),
        masked_file(),
    ] {
        assert!(!is_found(&file, "PTM-I207"));
    }
    // Padding to a multiple of a block size, and a few bytes above 127 before a text.
    let padded = [&overwritten_file(0..0)[..], &vec![0; 200_000]].concat();
    assert!(!is_found(&padded, "PTM-E072") && is_found(&padded, "PTM-W110"));
    let mut file = uniform_file("2x2", 1, [0xc3, 0xa9, 1, 1, 1, 1], [1; 3]);
    assert!(!is_found(&file, "PTM-E071"));
    file.extend(b"text after the last value");
    assert!(!is_found(&file, "PTM-E071"));
    let lit = uniform_file("2x2", 1, [0, 0, 0, 1, 0, 200], [9, 99, 255]);
    assert!(!is_found(&lit, "PTM-I205"));
}

#[test]
fn runs_of_equal_values_in_legal_maps_are_not_reported() {
    let is_legal = |case: &&Case| matches!(case.expect, Expect::Decode | Expect::Lenient);
    for case in suite().cases.iter().filter(is_legal) {
        let codes = lint_codes(case);
        let is_damage = |code: &str| ["PTM-I207", "PTM-E071", "PTM-E072"].contains(&code);
        assert!(!codes.iter().any(|code| is_damage(code)), "{}", case.id);
    }
}

#[test]
fn a_truncated_file_is_compared_with_its_announced_size() {
    let file = overwritten_file(0..0);
    for length in [56, 57, 60_056, 45_056, 90_055] {
        let findings = lint(&file[..length]);
        let found = &findings[0].found;
        assert_eq!(
            found,
            &format!("the file should have 90056 bytes and has {length}")
        );
    }
}

#[test]
fn exchanged_names_of_tables_are_found() {
    let suite = suite();
    let case = suite.case("first-ptm-c-lut").expect("a case");
    let file = &case.build(TableSpelling::default()).file;
    let text = b"PTM_FORMAT_PTM_C_LUT";
    let mut windows = file.windows(text.len());
    let place = windows
        .position(|window| window == text)
        .expect("the format");
    let renamed = [
        &file[..place],
        b"PTM_FORMAT_PTM_LUT",
        &file[place + text.len()..],
    ]
    .concat();
    let findings = lint(&renamed);
    let is_explained = |finding: &Diagnostic| finding.found.contains("reads PTM_LUT as PTM_C_LUT");
    assert!(findings.iter().any(is_explained), "{findings:?}");
}

fn lint_codes(case: &Case) -> BTreeSet<&'static str> {
    let findings = lint(&case.build(TableSpelling::default()).file);
    findings.iter().map(|finding| finding.code).collect()
}

#[test]
fn every_damage_that_must_be_refused_has_a_code() {
    let suite = suite();
    let is_refused = |case: &&Case| case.expect.is_refusal();
    let refused: Vec<&Case> = suite.cases.iter().filter(is_refused).collect();
    for case in &refused {
        let name = case.damage().map_or(&*case.id, |damage| &*damage.name);
        assert!(
            Code::for_rejected_file(name).is_some(),
            "no code for {name}"
        );
    }
    assert!(refused.len() > 300);
}

#[test]
fn every_code_is_triggered_by_its_cases() {
    let suite = suite();
    for code in ALL.iter() {
        let is_made = made_files().iter().any(|(id, _)| *id == code.id);
        assert_eq!(code.provoked_by.is_empty(), is_made, "{}", code.id);
        for name in &code.provoked_by {
            let is_named = |case: &&Case| {
                case.id == *name || case.damage().is_some_and(|damage| damage.name == *name)
            };
            let cases: Vec<&Case> = suite.cases.iter().filter(is_named).collect();
            assert!(!cases.is_empty(), "{}: no case {name}", code.id);
            for case in cases {
                let is_found = lint_codes(case).contains(code.id);
                assert!(is_found, "{} is not found in {}", code.id, case.id);
            }
        }
    }
}

#[test]
fn codes_have_one_severity_and_unique_texts() {
    let mut damages = BTreeSet::new();
    let mut ids = BTreeSet::new();
    let mut texts = BTreeSet::new();
    for code in ALL.iter() {
        assert!(ids.insert(code.id), "{}", code.id);
        assert!(texts.insert(code.message), "{}", code.message);
        let letter = match code.severity {
            Severity::Error => 'E',
            Severity::Warning => 'W',
            Severity::Info => 'I',
        };
        assert!(code.id.starts_with(&format!("PTM-{letter}")), "{}", code.id);
        if code.severity == Severity::Error {
            for name in &code.provoked_by {
                assert!(damages.insert(name), "{name}");
            }
        }
    }
}

#[test]
fn every_clause_of_a_code_exists() {
    let clauses = ptm_suite::clauses::clauses().expect("the clauses load");
    for code in ALL.iter() {
        let is_known = clauses.iter().any(|clause| clause.id == code.clause);
        assert!(is_known, "{}: {}", code.id, code.clause);
    }
}

#[test]
fn findings_depend_only_on_choices_of_their_case() {
    let (suite, mut rulings) = (suite(), BTreeSet::new());
    let is_wanted = |case: &&Case| case.compression().is_some() && case.damage().is_none();
    for case in suite.cases.iter().filter(is_wanted) {
        let codes = lint_codes(case);
        let found = ALL.iter().filter(|code| codes.contains(code.id));
        for ruling in found.filter_map(|code| code.ruling.as_deref()) {
            assert!(case.axes().contains(&ruling), "{}: {ruling}", case.id);
            rulings.insert(ruling);
        }
    }
    assert_eq!(rulings.len(), 7, "{rulings:?}");
}
