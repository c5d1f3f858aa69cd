//! The program, as its users meet it.

use std::fs;

use crate::common::{check_with, program, run};

fn text(output: &std::process::Output) -> String {
    String::from_utf8_lossy(&[output.stdout.clone(), output.stderr.clone()].concat()).into_owned()
}

#[test]
fn the_reference_passes_every_case() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let output = program()
        .current_dir(scratch.path())
        .arg("check")
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    let report =
        fs::read_to_string(scratch.path().join("ptm-conform-report.yaml")).expect("a report");
    let published = fs::read_to_string(crate::common::repository("reports/reference.yaml"))
        .expect("the published report");
    assert!(
        report == published,
        "run: ptm-conform check --report reports/reference.yaml"
    );
}

#[test]
fn two_runs_give_equal_reports() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let report = |name: &str, jobs: &str| {
        let path = scratch.path().join(name);
        let output = program()
            .args(["check", "--jobs", jobs, "--case", "lrgb-*", "--report"])
            .arg(&path)
            .output()
            .expect("the program starts");
        assert_eq!(output.status.code(), Some(0), "{}", text(&output));
        fs::read_to_string(path).expect("a report")
    };
    assert_eq!(report("one", "1"), report("two", "7"));
}

#[test]
fn wrong_usage_is_2() {
    for args in [
        &["check", "--jobs", "0"][..],
        &["check", "--timeout", "0"],
        &["check", "--timeout", "-1"],
        &["check", "--timeout", "nan"],
        &["check", "--view", "png"],
        &["check", "--case", "[", "x"],
        &["check", "--no-such-option"],
        &["no-such-command"],
        &["explain", "no-such-thing"],
        &["reference", "png", "x.ptm"],
        &["reference", "raw", "no-such-file.ptm"],
        &[
            "check",
            "--report",
            "no-such-directory/report.yaml",
            "--case",
            "hand-lum",
        ],
    ] {
        assert_eq!(run(args).status.code(), Some(2), "{args:?}");
    }
}

#[test]
fn a_check_without_a_decoder_says_first_and_last_that_it_checks_the_reference() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    for suite in ["ptm", "texture"] {
        let output = program()
            .current_dir(scratch.path())
            .args([
                "check", "--quiet", "--suite", suite, "--case", "*lum*", "--case", "DEP-01",
            ])
            .output()
            .expect("the program starts");
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        let lines: Vec<&str> = said.lines().collect();
        for line in [lines[0], lines[lines.len() - 1]] {
            assert!(line.contains("built-in reference"), "{suite}: {said}");
        }
    }
    let checked = check_with(&["--case", "hand-lum"], &[&crate::common::zoo(), "right"]);
    assert!(!checked.text.contains("reference"), "{}", checked.text);
}

#[test]
fn two_hyphens_without_a_decoder_are_wrong_usage() {
    for args in [&["check", "--"][..], &["check", "--case", "hand-lum", "--"]] {
        let output = run(args);
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        assert!(
            text(&output).contains("ptm-conform check -- python3 decode.py"),
            "{}",
            text(&output)
        );
    }
}

#[test]
fn a_run_that_ends_early_says_why_on_standard_error() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let output = program()
        .current_dir(scratch.path())
        .args([
            "check",
            "--quiet",
            "--timeout",
            "0.3",
            "--",
            &crate::common::zoo(),
            "hangs",
        ])
        .output()
        .expect("the program starts");
    let why = "the run ended early: three legal files in a row hung";
    for said in [output.stdout, output.stderr] {
        let said = String::from_utf8_lossy(&said);
        assert!(said.contains(why), "{said}");
    }
}

#[test]
fn nothing_selected_is_5() {
    assert_eq!(
        run(&["check", "--case", "no-such-case"]).status.code(),
        Some(5)
    );
    assert_eq!(run(&["check", "--clause", "9.9"]).status.code(), Some(5));
}

#[test]
fn what_cannot_be_started_is_3() {
    for decoder in [
        &["./no-such-decoder"][..],
        &["no-such-decoder-in-path"],
        &["sh", "-c", "exit 127"],
        &["/"],
    ] {
        let checked = check_with(&["--case", "hand-lum"], decoder);
        assert_eq!(checked.status, 3, "{decoder:?}: {}", checked.text);
        assert_eq!(checked.report["verdict"], "not a decoder");
    }
}

#[test]
fn a_clause_or_a_section_selects_its_cases() {
    let clause = check_with(
        &["--clause", "2.8.1/3"],
        &[
            &crate::common::examples().join("zoo").to_string_lossy(),
            "right",
        ],
    );
    let section = check_with(
        &["--clause", "2.8"],
        &[
            &crate::common::examples().join("zoo").to_string_lossy(),
            "right",
        ],
    );
    let (clause, section) = (clause.cases("pass"), section.cases("pass"));
    assert!(clause.contains(&"table-of-257-entries-ptm-lut".to_owned()));
    assert!(clause.len() < section.len() && clause.iter().all(|id| section.contains(id)));
}

#[test]
fn everything_can_be_explained() {
    for (id, says) in [
        ("hand-rgb-blocks", "2.7.1/2"),
        ("table-of-257-entries-ptm-lut", "N_LUT_ENTRIES"),
        ("width-zero-lrgb", "the width is 0"),
        ("2.4/8", "(raw − bias) · scale"),
        ("2.8", "2.8/1"),
        ("lut-count", "nentries"),
        ("rows-top-down", "the first stored row as the top"),
    ] {
        let output = run(&["explain", id]);
        assert!(
            output.status.success() && text(&output).contains(says),
            "{id}: {}",
            text(&output)
        );
    }
}

#[test]
fn explain_alone_lists_what_it_knows() {
    let said = text(&run(&["explain"]));
    for known in ["2.9.8 ", "lut-count", "rows-top-down", "PTM-W102"] {
        assert!(said.contains(known), "{known}: {said}");
    }
}

#[test]
fn a_misreading_is_explained_by_the_smallest_file_that_shows_it() {
    let said = text(&run(&["explain", "big-endian-index"]));
    for part in [
        "Fix: read the low byte first",
        " cases: table-of-257-entries-ptm-lut",
        "generate --case entries-of-the-first-and-last-texels-of-a-wide-table-ptm-lut",
        "raw: refused a legal file",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let said = text(&run(&["explain", "rows-top-down"]));
    assert!(
        said.contains("expected 24 25 26") && said.contains("received 16 17 18"),
        "{said}"
    );
}

#[test]
fn what_was_meant_is_suggested() {
    for args in [
        &["check", "--case", "hand-lom"][..],
        &["generate", "--case", "hand-lom"],
        &["explain", "hand-lom"],
    ] {
        let said = text(&run(args));
        assert!(said.contains("did you mean hand-lum"), "{args:?}: {said}");
    }
}

#[test]
fn the_file_of_one_case_is_written_alone() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let path = scratch.path().join("x.ptm");
    let output = program()
        .args(["generate", "--case", "hand-lum", "-o"])
        .arg(&path)
        .output()
        .expect("the program starts");
    assert!(output.status.success(), "{}", text(&output));
    let committed = crate::common::repository("corpus/lum/hand-lum.ptm");
    assert_eq!(fs::read(path).ok(), fs::read(committed).ok());
}

#[test]
fn what_is_no_program_is_called_what_it_is() {
    let source = crate::common::repository("src/main.rs");
    for (named, says) in [
        (
            source.as_str(),
            "main.rs is Rust source code, not a program; build it",
        ),
        ("/dev/null", "null is a device, a pipe or a socket"),
    ] {
        let checked = check_with(&["--case", "hand-lum"], &[named]);
        assert_eq!(checked.status, 3);
        assert!(checked.text.contains(says), "{}", checked.text);
        assert!(!checked.text.contains("os error"), "{}", checked.text);
    }
    let output = run(&[
        "check",
        "--case",
        "hand-lum",
        "--report",
        "/dev/null",
        "--cmd",
        "no-such-viewer {in} {lu} {lv}",
    ]);
    let said = text(&output);
    assert!(
        said.contains("no program of this name is in PATH"),
        "{said}"
    );
    assert!(!said.contains("os error"), "{said}");
}

#[test]
fn a_pipe_gets_no_color_unless_it_is_asked_for() {
    let escapes = |args: &[&str]| run(args).stdout.contains(&0x1b);
    assert!(!escapes(&["explain", "lut-count"]));
    assert!(escapes(&["--color", "always", "explain", "lut-count"]));
}

#[test]
fn the_reference_speaks_the_protocol() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let path = scratch.path().join("a file.ptm");
    let ask = |view: &str, bytes: &[u8]| {
        fs::write(&path, bytes).expect("a file");
        program()
            .args(["reference", view])
            .arg(&path)
            .output()
            .expect("the program starts")
    };
    let file = b"PTM_1.2\nPTM_FORMAT_LRGB\n1\n1\n1 1 1 1 1 0.5\n0 0 0 0 0 0\n\x01\x02\x03\x04\x05\x80\xff\x80\x00";
    assert_eq!(
        ask("raw", file).stdout,
        b"PTM1 raw 1 1 9 u8\n\x01\x02\x03\x04\x05\x80\xff\x80\x00"
    );
    assert_eq!(
        ask("rgb:0,0", file).stdout,
        b"PTM1 rgb 1 1 3 u8\n\x40\x20\x00"
    );
    assert_eq!(
        ask("coef", file).stdout[..23],
        *b"PTM1 coef 1 1 9 f32\n\x00\x00\x80"
    );
    assert_eq!(ask("raw", &file[..file.len() - 1]).status.code(), Some(65));
}

#[test]
fn a_decoder_is_found_from_the_users_own_directory() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let folder = scratch.path().join("my decoders");
    fs::create_dir(&folder).expect("a directory");
    let script = format!(
        "#!/bin/sh\nexec '{}' reference \"$@\"\n",
        env!("CARGO_BIN_EXE_ptm-conform")
    );
    fs::write(folder.join("decode it"), script).expect("a script");
    let output = program()
        .current_dir(scratch.path())
        .args([
            "check",
            "--case",
            "hand-*",
            "--",
            "sh",
            "my decoders/decode it",
        ])
        .output();
    let output = output.expect("the program starts");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
}

#[test]
fn help_teaches() {
    let output = run(&["check", "--help"]);
    for word in ["DECODER", "VIEW", "65", "69", "Exit status", "Examples"] {
        assert!(text(&output).contains(word), "{word}");
    }
}
