//! The decoder in JavaScript passes what it claims and says "unsupported" to the rest.

use crate::common::{check_with, have, repository};

#[test]
fn the_decoder_in_javascript_passes() {
    if !have("node") {
        return;
    }
    let decoder = repository("examples/decoders/ptm_decoder.js");
    // A part of the suite that has all of its formats, spellings and views; the whole takes a process for each file.
    let globs = [
        "first-*",
        "hand-*",
        "header-*",
        "table-*",
        "lum-*",
        "*-missing-*",
        "index-*",
        "lrgb-under-*",
    ];
    let options: Vec<&str> = globs.iter().flat_map(|glob| ["--case", glob]).collect();
    let checked = check_with(&options, &["node", &decoder]);
    assert_eq!(checked.status, 0, "{}", checked.text);
    assert!(checked.cases("pass").len() > 100, "{}", checked.text);
    let unsupported = checked.cases("unsupported");
    assert!(
        !unsupported.is_empty()
            && unsupported
                .iter()
                .all(|id| id.contains("jpeg") || id.contains("tablet")),
        "{unsupported:?}"
    );
}

#[test]
fn a_large_picture_goes_through_a_pipe_whole() {
    if !have("node") {
        return;
    }
    // 600 × 400 texels of nine bytes: many times what a pipe holds.
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let path = scratch.path().join("large.ptm");
    let mut file = b"PTM_1.2\nPTM_FORMAT_LRGB\n600\n400\n1 1 1 1 1 1\n0 0 0 0 0 0\n".to_vec();
    file.extend((0..600 * 400 * 9_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8));
    std::fs::write(&path, file).expect("a file is written");
    let said = |program: &mut std::process::Command| {
        program
            .args(["coef", &path.to_string_lossy()])
            .output()
            .expect("the program starts")
            .stdout
    };
    let ours = said(crate::common::program().arg("reference"));
    let theirs = said(
        std::process::Command::new("node").arg(repository("examples/decoders/ptm_decoder.js")),
    );
    assert!(ours == theirs, "{} and {} bytes", ours.len(), theirs.len());
}
