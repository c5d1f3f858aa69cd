//! The example decoders in C and in shell pass; what they lack is listed as unsupported.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{Checked, check_with, have, repository};

/// The C decoder, compiled into `directory`; nothing where there is no compiler.
fn compiled(directory: &Path) -> Option<PathBuf> {
    if !have("cc") {
        return None;
    }
    let program = directory.join("ptm_decoder");
    let output = Command::new("cc")
        .args([
            "-std=c99",
            "-pedantic",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-O1",
            "-o",
        ])
        .arg(&program)
        .arg(repository("examples/decoders/ptm_decoder.c"))
        .arg("-lm")
        .output()
        .expect("the compiler starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    Some(program)
}

const LACKS: [&str; 10] = [
    "LUM",
    "JPEG_RGB",
    "JPEG_LRGB",
    "JPEGLS_RGB",
    "JPEGLS_LRGB",
    "rgb of LUM",
    "prediction",
    "inversion",
    "motion compensation",
    "side information",
];

#[track_caller]
fn passes(checked: &Checked, lacks: &[&str]) {
    assert_eq!(checked.status, 0, "{}", checked.text);
    assert_eq!(checked.report["verdict"], "pass");
    assert_eq!(
        checked.report["decoder"]["unsupported"],
        serde_json::json!(lacks),
        "{}",
        checked.text
    );
    assert!(checked.cases("pass").len() > 500, "{}", checked.text);
}

#[test]
fn the_c_decoder_passes_in_every_view() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let Some(program) = compiled(scratch.path()) else {
        return;
    };
    let program = program.to_string_lossy();
    passes(&check_with(&[], &[&program]), &LACKS);
    let without_color_of_lum: Vec<&str> = LACKS
        .into_iter()
        .filter(|lack| *lack != "rgb of LUM")
        .collect();
    passes(
        &check_with(&["--view", "coef"], &[&program]),
        &without_color_of_lum,
    );
    passes(&check_with(&["--view", "rgb"], &[&program]), &LACKS);
}

#[test]
fn the_c_decoder_reads_the_other_spellings_of_tables() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let Some(program) = compiled(scratch.path()) else {
        return;
    };
    for count in ["256 N_LUT_ENTRIES", "256", "nentries 256"] {
        let count = count.replace("256", "1");
        let header =
            format!("PTM_1.2\nPTM_FORMAT_PTM_C_LUT\n1 1\n1 1 1 1 1 1\n0 0 0 0 0 0\n{count}\n");
        let path = scratch.path().join("a.ptm");
        fs::write(&path, [header.as_bytes(), b"abcdefghi\0"].concat()).expect("a file");
        let output = Command::new(&program)
            .arg("raw")
            .arg(&path)
            .output()
            .expect("it starts");
        assert_eq!(output.stdout, b"PTM1 raw 1 1 9 u8\nabcdefghi", "{count}");
    }
}

/// A viewer that writes pictures, made of the C decoder: `viewer LU LV FILE PICTURE`, exit status 1 for all that fails.
#[test]
fn a_viewer_that_only_writes_pictures_passes_in_its_wrapper() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let Some(program) = compiled(scratch.path()) else {
        return;
    };
    let viewer = scratch.path().join("viewer");
    let text = format!(
        "'{}' \"rgb:$1,$2\" \"$3\" > frame || exit 1\n\
         {{ read -r magic view width height rest; printf 'P6\\n%s %s\\n255\\n' $width $height; cat; }} < frame > \"$4\"\n",
        program.display()
    );
    fs::write(&viewer, text).expect("a script");
    let wrapper = repository("examples/decoders/wrap_viewer.sh");
    let named = format!("VIEWER=sh {}", viewer.display());
    let checked = check_with(&[], &["env", &named, "sh", &wrapper]);
    assert_eq!(
        checked.report["decoder"]["views"],
        serde_json::json!(["rgb"]),
        "{}",
        checked.text
    );
    passes(&checked, &LACKS);
}
