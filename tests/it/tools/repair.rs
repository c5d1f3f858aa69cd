//! Tests that repair restores damaged files and refuses ambiguous repairs.

use std::collections::BTreeMap;

use crate::common::Workspace;
use ptm::decode;
use ptm_files::{lint::Lint, repair::repair};
use ptm_suite::cases::{Case, Expect, Suite, TableSpelling};

#[test]
fn repaired_file_equals_its_twin_and_has_no_errors() {
    let suite = Suite::load().expect("the suite loads");
    let mut repaired: BTreeMap<&str, usize> = BTreeMap::new();
    for case in &suite.cases {
        let file = &case.build(TableSpelling::default()).file;
        let Ok(result) = repair(file) else {
            continue;
        };
        let lint = Lint::new(&case.id, &result.bytes);
        let remains = |code: &str| lint.findings.iter().any(|finding| finding.code == code);
        let is_clean = lint.errors == 0 && !remains("PTM-W110") && !remains("PTM-W123");
        assert!(is_clean, "{lint:?}");
        assert!(!result.changes.is_empty(), "{}", case.id);
        assert!(repair(&result.bytes).is_err(), "{}", case.id);
        let after = decode(&result.bytes).expect("a legal file");
        let twin = case.twin_of.as_deref().filter(|_| decode(file).is_err());
        let before = match twin.and_then(|twin| suite.cases.iter().find(|one| one.id == twin)) {
            Some(twin) => decode(&twin.build(TableSpelling::default()).file),
            None => decode(file),
        };
        assert_eq!(Ok(after), before, "{}", case.id);
        let name = case.damage().map_or(&*case.id, |damage| &*damage.name);
        *repaired.entry(name).or_default() += 1;
    }
    println!("{repaired:?}");
    let names = "cr-lf tabs empty-line leading-blank two-spaces-before-newline compressed-size-one-less \
                 compressed-size-one-more newline-behind bytes-behind record-twice-jpeg-lrgb";
    for name in names.split(' ') {
        assert!(repaired.contains_key(name), "{name} is not repaired");
    }
}

#[test]
fn repair_of_a_file_copied_in_text_mode_restores_or_refuses_it() {
    let suite = Suite::load().expect("the suite loads");
    let mut tested = 0;
    let is_legal = |case: &&Case| case.expect == Expect::Decode;
    for case in suite.cases.iter().filter(is_legal) {
        let file = &case.build(TableSpelling::default()).file;
        if case.format().coding().is_some() || file.len() > 4096 {
            continue;
        }
        let lines: Vec<&[u8]> = file.split(|&byte| byte == b'\n').collect();
        let copied = lines.join(&b"\r\n"[..]);
        if let Ok(result) = repair(&copied) {
            assert_eq!(decode(&result.bytes), decode(file), "{}", case.id);
        }
        tested += 1;
    }
    assert!(tested > 500);
}

#[test]
fn bytes_that_may_be_values_are_not_removed() {
    let suite = Suite::load().expect("the suite loads");
    let file = |id| {
        let case = suite.case(id).expect("a case");
        case.build(TableSpelling::default()).file.clone()
    };
    let extended = |(id, extra)| ([&file(id)[..], &vec![0; extra]].concat(), "may be values");
    // A texel, an index, and a record.
    let extended = [
        ("first-lrgb", 9),
        ("first-ptm-c-lut", 1),
        ("first-jpegls-lrgb", 5),
    ]
    .map(extended);
    let map = file("first-lrgb");
    let payload = map.len() - decode(&map).expect("a legal file").planes.samples.len();
    let displaced = [&map[..payload], b"\n", &map[payload..]].concat();
    let to_cr = |byte: &u8| if *byte == b'\n' { b'\r' } else { *byte };
    let copied: Vec<u8> = displaced[..map.len()].iter().map(to_cr).collect();
    let others = [(displaced, "may be values"), (copied, "text mode")];
    for (bytes, message) in extended.into_iter().chain(others) {
        let error = repair(&bytes).expect_err(message);
        assert!(error.to_string().contains(message), "{error}");
    }
}

#[test]
fn the_reason_fits_the_error() {
    let suite = Suite::load().expect("the suite loads");
    let mut tested = 0;
    for case in &suite.cases {
        let file = &case.build(TableSpelling::default()).file;
        let Err(why) = repair(file).map_err(|error| error.to_string()) else {
            continue;
        };
        let lint = Lint::new("a.ptm", file);
        let Some(error) = lint.findings.first().filter(|_| lint.errors > 0) else {
            continue;
        };
        let words = match error.code {
            "PTM-E004" => "nothing is left",
            "PTM-E010" | "PTM-E011" => "the width or the height",
            "PTM-E020" => "a scale is not",
            "PTM-E021" => "a bias is not",
            "PTM-E040" | "PTM-E041" => "a matrix element",
            "PTM-E052" | "PTM-E053" | "PTM-E054" => "how the planes are predicted",
            "PTM-E060" => "an index",
            "PTM-E070" => "bytes are missing",
            _ => continue,
        };
        assert!(why.contains(words), "{}: {}: {why}", case.id, error.code);
        tested += 1;
    }
    assert!(tested > 100, "{tested}");
}

#[test]
fn repair_never_overwrites() {
    let here = Workspace::new();
    here.copy_from_corpus("lrgb/first-lrgb.ptm");
    let sound = here.read("first-lrgb.ptm");
    let damaged = [&sound[..], b"\0\0"].concat();
    here.write("old.ptm", &damaged);
    here.exits(2, "convert --repair old.ptm -o old.ptm");
    assert_eq!(here.read("old.ptm"), damaged);
    let text = here.succeeds("convert --repair old.ptm -o new.ptm");
    assert!(text.contains("2 bytes after the last value"), "{text}");
    assert_eq!(here.read("new.ptm"), sound);
    here.exits(2, "convert --repair old.ptm -o new.ptm");
    here.exits(1, "convert --repair new.ptm -o newer.ptm");
}

/// Converts the bytes of a file to UTF-8. `character` returns the character of a byte.
fn as_utf8(file: &[u8], character: impl Fn(u8) -> char) -> Vec<u8> {
    let text: String = file.iter().map(|&byte| character(byte)).collect();
    text.into_bytes()
}

/// Returns the character of a byte in Windows-1252, and U+FFFD for the bytes 0x81 to 0x9f that this table does not contain.
fn windows_1252(byte: u8) -> char {
    match byte {
        0x80 => '€',
        0x85 => '…',
        0x92 => '’',
        0x99 => '™',
        0x81..=0x9f => char::REPLACEMENT_CHARACTER,
        _ => byte.into(),
    }
}

#[test]
fn binary_data_that_became_utf_8_is_restored() {
    let here = Workspace::new();
    here.copy_from_corpus("lrgb/first-lrgb.ptm");
    let sound = here.read("first-lrgb.ptm");
    let once = as_utf8(&sound, char::from);
    assert!(once.len() > sound.len());
    here.write("twice.ptm", as_utf8(&once, char::from));
    here.write("once.ptm", once);
    // A payload with the bytes that Windows-1252 assigns to other characters.
    let mut other = sound.clone();
    let end = other.len();
    other[end - 5..].copy_from_slice(&[0x80, 0x85, 0x92, 0x99, 0xff]);
    for byte in &mut other[end - 60..end - 5] {
        *byte |= if *byte >= 0x80 { 0x20 } else { 0 };
    }
    here.write("windows.ptm", as_utf8(&other, windows_1252));
    for (name, expected) in [("once", &sound), ("twice", &sound), ("windows", &other)] {
        here.assert_lines(
            &"
1 | lint NAME.ptm | PTM-E071 && repairable
0 | convert --repair NAME.ptm -o NAME-bytes.ptm | converted the binary data from UTF-8 back to bytes"
                .replace("NAME", name),
        );
        assert_eq!(&here.read(&format!("{name}-bytes.ptm")), expected);
    }
}

#[test]
fn payloads_that_lost_bytes_are_not_cut() {
    let here = Workspace::new();
    here.copy_from_corpus("lrgb/first-lrgb.ptm");
    let sound = here.read("first-lrgb.ptm");
    here.write("replaced.ptm", String::from_utf8_lossy(&sound).as_bytes());
    // Mac Roman, in which no byte is lost, but which the program does not know.
    let mac = |byte: u8| {
        if byte < 0x80 {
            byte.into()
        } else {
            char::from_u32(0x100 + u32::from(byte)).expect("a character")
        }
    };
    here.write("mac.ptm", as_utf8(&sound, mac));
    let text = as_utf8(&sound, char::from);
    here.write("cut.ptm", &text[..text.len() - 3]);
    here.write(
        "two.ptm",
        [&sound[..], &sound, &sound, &sound, &sound].concat(),
    );
    let header = sound.len() - decode(&sound).expect("a legal file").planes.samples.len();
    let mut lines = sound.clone();
    lines.truncate(sound.len() - 7);
    lines
        .iter_mut()
        .skip(header)
        .filter(|byte| **byte == b'\n')
        .for_each(|byte| *byte = 1);
    lines.extend(b"\r\n\r\n\r\n\r\n\r\n\r\n\r\n");
    here.write("lines.ptm", lines);
    here.assert_lines(
        "
1 | lint replaced.ptm | PTM-E071 && replaced other bytes
1 | lint mac.ptm | PTM-E071
1 | lint cut.ptm | PTM-E071
1 | lint two.ptm | PTM-E072",
    );
    here.exits(1, "convert --repair lines.ptm -o none.ptm");
    for name in ["replaced", "mac", "cut", "two"] {
        here.exits(1, &format!("convert --repair {name}.ptm -o none.ptm"));
        let row = here
            .run(&format!("lint --format csv --no-header {name}.ptm"))
            .1;
        assert!(row.contains(",damaged,") && row.contains("no: "), "{row}");
    }
}
