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

#[test]
fn binary_data_that_became_utf_8_is_restored() {
    let here = Workspace::new();
    here.copy_from_corpus("lrgb/first-lrgb.ptm");
    let sound = here.read("first-lrgb.ptm");
    let text: String = sound.iter().map(|&byte| char::from(byte)).collect();
    assert!(text.len() > sound.len());
    here.write("text.ptm", text);
    here.assert_lines(
        "
1 | lint text.ptm | PTM-E071
0 | convert --repair text.ptm -o bytes.ptm | converted the binary data from UTF-8 back to bytes",
    );
    assert_eq!(here.read("bytes.ptm"), sound);
}
