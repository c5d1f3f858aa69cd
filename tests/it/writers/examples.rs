//! Tests of writers as processes: the reference writer and the Python writer.

use crate::common::{PROGRAM, Workspace, check_writer, have_tool, python_example};

#[test]
fn reference_writer_passes_as_a_process() {
    let checked = check_writer("--smoke");
    checked.assert_exit(0, "");
    assert_eq!(checked.report["suite"], "writers");
}

#[test]
fn python_writer_passes_in_its_formats() {
    if have_tool("python3") {
        let writer = python_example("writers/ptm_writer.py");
        let lacks = "unsupported (exit status 69): JPEG_RGB, JPEG_LRGB, JPEGLS_RGB, JPEGLS_LRGB";
        check_writer(&format!("--smoke -- {writer}")).assert_exit(0, lacks);
    }
}

#[test]
fn template_may_call_any_program() {
    let checked = check_writer("--format LRGB --cmd 'cp {planes} {out}'");
    checked.assert_exit(1, "the bytes there are \"\\x93NUMPY");
    check_writer("--cmd 'cp {planes} x'").assert_exit(2, "{out}");
}

#[test]
fn check_writer_exit_statuses_match_check() {
    check_writer("-- true").assert_exit(3, "true is not a writer");
    check_writer("--case no-such-case").assert_exit(5, "");
    check_writer("--ok-exit 65 -- true").assert_exit(2, "other than 65 and 69");
    check_writer("--cmd 'true {in} {out}'").assert_exit(3, "{matrix}, {quality} and {near}");
    check_writer("--ok-exit 1 -- false").assert_exit(3, "although the program exited with 1");
    Workspace::new().exits(2, "reference write no-such-request.json");
}

#[test]
fn probe_tests_a_writer_step_by_step() {
    let here = Workspace::new();
    let swap = format!("{PROGRAM} reference write \"$2\" x && sed '3{{h;d}};4{{G}}' x > \"$3\"");
    here.write("swaps-sizes.sh", swap);
    let table = r#"
0 | PROBE PROGRAM reference | JPEGLS_LRGB: the file contains the requested values
3 | PROBE sh -c "printf 'PTM_1.2\n'" | not to standard output
3 | PROBE sh -c 'exit 69' | write at least one format
1 | PROBE sh swaps-sizes.sh | would produce this file"#;
    let table = table.replace("PROBE", "probe --writer --");
    here.assert_lines(&table.replace("PROGRAM", PROGRAM));
}
