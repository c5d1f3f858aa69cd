//! Tests of the command-line interface.

use crate::common::{
    PROGRAM, Workspace, assert_contains, check, repository, repository_text, rows, zoo,
};

#[test]
fn reference_passes_every_case() {
    let here = Workspace::new();
    here.succeeds("check --short");
    assert!(
        here.text("ptm-conform-report.yaml") == repository_text("reports/reference.yaml"),
        "run: ptm-conform check --short --report reports/reference.yaml"
    );
}

#[test]
fn two_runs_give_equal_reports() {
    let here = Workspace::new();
    for (name, jobs) in [("one", 1), ("two", 7)] {
        here.succeeds(&format!(
            "check --jobs {jobs} --case lrgb-* --report {name}"
        ));
    }
    assert_eq!(here.text("one"), here.text("two"));
}

#[test]
fn check_files_continues_after_an_unreadable_file() {
    let here = Workspace::new();
    here.copy_from_corpus("lrgb/first-lrgb.ptm");
    std::os::unix::fs::symlink("no-such-file", here.path("a.ptm")).expect("a link");
    let output = here.exits(1, "check --files .");
    assert_contains(
        &output,
        "not run a.ptm && pass first-lrgb.ptm && not run: 2 files",
    );
}

#[test]
fn commands_have_the_expected_status_and_output() {
    let here = Workspace::new();
    here.assert_lines(
        "
2 | check --jobs 0 |
2 | check --timeout 0 |
2 | check --timeout -1 |
2 | check --timeout nan |
2 | check --view png |
2 | check --case [ x |
2 | check --no-such-option |
2 | no-such-command |
2 | explain no-such-thing |
69 | reference png x.ptm | unknown view
2 | reference raw no-such-file.ptm |
2 | check --report no-such-directory/report.yaml --case hand-lum |
2 | check -- | ptm-conform check -- python3 decode.py
2 | check --case hand-lum -- | ptm-conform check -- python3 decode.py
5 | check --case no-such-case |
5 | check --clause 9.9 |
5 | check --case hand-lom | did you mean hand-lum
2 | explain hand-lom | did you mean hand-lum
2 | explain row-top-down | rows-top-down
0 | explain ptm-e07 | PTM-E070: && PTM-E071:
0 | explain nentries | cases:
0 | explain first-jpegls-rgb | more of this clause; --all lists them
0 | check --list --ptm-format LRGB --case 'first-*' --skip '*line' | first-lrgb
2 | check --x | unexpected argument '--x'
2 | explain zzz | explain lists all
3 | check --case hand-lum --report /dev/null -- sh -c 'exit 127' | not a decoder
0 | check --help | DECODER && VIEW && 65 && 69 && Exit status && Examples
0 | explain | 2.9.8 && lut-count && rows-top-down && PTM-W102
0 | explain hand-rgb-blocks | 2.7.1/2
0 | explain table-of-257-entries-ptm-lut | N_LUT_ENTRIES
0 | explain width-zero-lrgb | the width is 0
0 | explain 2.4/8 | (raw − bias) · scale
0 | explain 2.8 | 2.8/1
0 | explain PTM_LUT | format PTM_FORMAT_PTM_LUT (clause 2.2/1) && 2.8.1    17 cases
0 | explain lut-count | nentries
0 | explain rows-top-down
  | the first stored row as the top && expected 24 25 26 && received 16 17 18
0 | explain big-endian-index
  | Fix: read the low byte first && cases: table-of-257-entries-ptm-lut
  && generate --case entries-of-the-first-and-last-texels-of-a-wide-table-ptm-lut && raw: refused a legal file",
    );
    assert_contains(
        &here.run("generate --case hand-lom").1,
        "did you mean hand-lum",
    );
}

#[test]
fn check_without_a_decoder_mentions_the_reference() {
    let here = Workspace::new();
    for suite in ["ptm", "texture"] {
        let line = format!("check --quiet --suite {suite} --case *lum* --case DEP-01");
        let output = here.command(&line).output().expect("the program starts");
        let text = String::from_utf8(output.stdout).expect("UTF-8");
        let lines: Vec<&str> = text.lines().collect();
        for line in [lines[0], lines[lines.len() - 1]] {
            assert!(line.contains("built-in reference"), "{suite}: {text}");
        }
    }
    let checked = check(&format!("--case hand-lum -- {}", zoo("right")));
    assert!(!checked.text.contains("reference"), "{}", checked.text);
}

#[test]
fn interrupted_run_prints_the_reason_to_standard_error() {
    let here = Workspace::new();
    let line = format!("check --quiet --timeout 0.3 -- {}", zoo("hangs"));
    let output = here.command(&line).output().expect("the program starts");
    for text in [output.stdout, output.stderr] {
        let why = "the run ended early: the decoder exceeds the time limit of 0.9 s (`--timeout`) on three legal files in a row";
        assert_contains(&String::from_utf8_lossy(&text), why);
    }
}

#[test]
fn clause_and_section_options_select_cases() {
    let passing =
        |clause: &str| check(&format!("--clause {clause} -- {}", zoo("right"))).cases("pass");
    let (clause, section) = (passing("2.8.1/3"), passing("2.8"));
    assert!(clause.contains(&"table-of-257-entries-ptm-lut".to_owned()));
    assert!(clause.len() < section.len() && clause.iter().all(|id| section.contains(id)));
}

#[test]
fn single_case_file_can_be_written() {
    let here = Workspace::new();
    here.succeeds("generate --case hand-lum -o x.ptm");
    let committed = std::fs::read(repository("corpus/lum/hand-lum.ptm"));
    assert_eq!(here.read("x.ptm"), committed.expect("a file"));
}

#[test]
fn files_that_cannot_be_executed_are_described() {
    let source = repository("src/main.rs");
    let missing = "--cmd 'no-such-viewer {in} {lu} {lv}'";
    for (decoder, says) in [
        (
            &*format!("-- {source}"),
            "main.rs is Rust source code, not a program; compile it",
        ),
        ("-- /dev/null", "null is a device, a pipe or a socket"),
        (missing, "no program with this name is in PATH"),
    ] {
        let checked = check(&format!("--case hand-lum {decoder}"));
        checked.assert_exit(3, says);
        assert!(!checked.text.contains("os error"), "{}", checked.text);
    }
}

#[test]
fn pipes_get_no_color_by_default() {
    let here = Workspace::new();
    here.copy_from_corpus("lrgb/first-lrgb.ptm");
    for [line, is_colored] in rows(
        "
explain lut-count | false
--color always explain lut-count | true
inspect first-lrgb.ptm | false
inspect --color always first-lrgb.ptm | true
--color never inspect first-lrgb.ptm | false",
    ) {
        let text = here.succeeds(&line);
        assert_eq!(text.contains('\x1b').to_string(), is_colored, "{line}");
    }
}

#[test]
fn decoder_path_is_relative_to_the_working_directory() {
    let here = Workspace::new();
    let script = format!("#!/bin/sh\nexec '{PROGRAM}' reference \"$@\"\n");
    here.write("my decoders/decode it", script);
    here.succeeds("check --case hand-* -- sh 'my decoders/decode it'");
}
