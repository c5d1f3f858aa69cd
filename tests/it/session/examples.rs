//! The example decoders in C, shell and JavaScript pass, and features that a decoder lacks are reported as unsupported.

use std::process::Command;

use crate::common::{CheckRun, Workspace, have_tool, program, repository, stdout};
use crate::table::rows;

/// Creates a workspace with the compiled C decoder `ptm_decoder`. Returns `None` if there is no compiler.
fn workspace_with_c_decoder() -> Option<Workspace> {
    let here = Workspace::new();
    let flags = "-std=c99 -pedantic -Wall -Wextra -Werror -O1 -o ptm_decoder";
    have_tool("cc").then(|| {
        let mut compiler = Command::new("cc");
        compiler
            .current_dir(here.path(""))
            .args(flags.split(' '))
            .args([&repository("examples/decoders/ptm_decoder.c"), "-lm"]);
        stdout(&mut compiler);
        here
    })
}

/// Features that the C decoder lacks.
const MISSING_FEATURES: [&str; 10] = [
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

/// Options that select cases of every format and of every feature that the C decoder lacks.
const VARIED_CASES: &str = "--case first-* --case hand-* --case header-* --case lrgb-* --case table-* --case luminance-* \
                            --case *-star-jpeg*";

#[track_caller]
fn assert_passes(checked: &CheckRun, lacks: &[&str]) {
    checked.assert_exit(0, "");
    assert_eq!(checked.report["verdict"], "pass");
    let unsupported = &checked.report["decoder"]["unsupported"];
    assert_eq!(*unsupported, serde_json::json!(lacks));
    assert!(checked.cases("pass").len() > 100, "{}", checked.text);
}

#[test]
fn c_decoder_passes_in_every_view() {
    let Some(here) = workspace_with_c_decoder() else {
        return;
    };
    let checked = here.check("-- ./ptm_decoder");
    assert_passes(&checked, &MISSING_FEATURES);
    assert!(checked.cases("pass").len() > 500, "{}", checked.text);
    let checked = here.check(&format!("{VARIED_CASES} --view rgb -- ./ptm_decoder"));
    assert_passes(&checked, &MISSING_FEATURES);
    let checked = here.check(&format!("{VARIED_CASES} --view coef -- ./ptm_decoder"));
    let not_in_color = [&MISSING_FEATURES[..5], &MISSING_FEATURES[6..]].concat();
    assert_passes(&checked, &not_in_color);
}

#[test]
fn c_decoder_reads_all_spellings_of_tables() {
    let Some(here) = workspace_with_c_decoder() else {
        return;
    };
    for count in ["1 N_LUT_ENTRIES", "1", "nentries 1"] {
        let header =
            format!("PTM_1.2\nPTM_FORMAT_PTM_C_LUT\n1 1\n1 1 1 1 1 1\n0 0 0 0 0 0\n{count}\n");
        let file = here.write("a.ptm", header + "abcdefghi\0");
        let frame = stdout(Command::new(here.path("ptm_decoder")).arg("raw").arg(file));
        assert_eq!(frame, "PTM1 raw 1 1 9 u8\nabcdefghi", "{count}");
    }
}

/// The program `viewer LU LV FILE IMAGE` calls the C decoder and exits with 1 for every failure.
#[test]
fn wrapped_viewer_passes() {
    let Some(here) = workspace_with_c_decoder() else {
        return;
    };
    let program = here.path("ptm_decoder");
    let text = format!(
        "'{}' \"rgb:$1,$2\" \"$3\" > frame || exit 1\n\
         {{ read -r magic view width height rest; printf 'P6\\n%s %s\\n255\\n' $width $height; cat; }} < frame > \"$4\"\n",
        program.display()
    );
    let viewer = here.write("viewer", text);
    let wrapper = repository("examples/decoders/wrap_viewer.sh");
    let checked = here.check(&format!(
        "{VARIED_CASES} -- env 'VIEWER=sh {}' sh {wrapper}",
        viewer.display()
    ));
    let views = &checked.report["decoder"]["views"];
    assert_eq!(*views, serde_json::json!(["rgb"]), "{}", checked.text);
    assert_passes(&checked, &MISSING_FEATURES);
}

#[test]
fn minimal_decoder_of_each_language_passes_in_serve_mode() {
    let starters = "\
python | decoder.py | true | python3 decoder.py
javascript | decoder.js | true | node decoder.js
java | Decoder.java | true | java Decoder.java
c | decoder.c | cc -std=c99 -pedantic -Wall -Wextra -Werror -o decoder decoder.c -lm | ./decoder
rust | decoder.rs | rustc -O --edition 2021 -o decoder decoder.rs | ./decoder";
    for [language, file, build, decoder] in rows(starters) {
        let (command, arguments) = build.split_once(' ').unwrap_or((&build, ""));
        let here = Workspace::new();
        let text = stdout(program().args(["example", &language]));
        here.write(&file, text);
        let interpreter = decoder.split(' ').next().expect("a command");
        if ![command, interpreter]
            .into_iter()
            .all(|name| name.starts_with("./") || have_tool(name))
        {
            continue;
        }
        stdout(
            Command::new(command)
                .args(arguments.split_whitespace())
                .current_dir(here.path("")),
        );
        let checked = here.check(&format!("--smoke --timeout 60 -- {decoder}"));
        checked.assert_exit(0, "");
        assert_eq!(checked.report["decoder"]["mode"], "serve", "{language}");
        assert!(checked.cases("pass").len() > 10, "{}", checked.text);
    }
}

#[test]
fn javascript_decoder_passes() {
    if !have_tool("node") {
        return;
    }
    // These cases include all formats, spellings and views. The whole suite would start a process for each file.
    let cases = "--case first-* --case hand-* --case header-* --case table-* --case lum-* --case *-missing-* \
                 --case index-* --case lrgb-under-*";
    let decoder = repository("examples/decoders/ptm_decoder.js");
    let checked = crate::common::check(&format!("{cases} -- node {decoder}"));
    checked.assert_exit(0, "");
    assert!(checked.cases("pass").len() > 100, "{}", checked.text);
    let unsupported = checked.cases("unsupported");
    let is_expected = |id: &String| id.contains("jpeg") || id.contains("tablet");
    assert!(
        !unsupported.is_empty() && unsupported.iter().all(is_expected),
        "{unsupported:?}"
    );
}

#[test]
fn javascript_decoder_writes_large_images_completely() {
    if !have_tool("node") {
        return;
    }
    // 600 × 400 texels of nine coefficients: many times the size of a pipe buffer.
    let here = Workspace::new();
    let header = b"PTM_1.2\nPTM_FORMAT_LRGB\n600\n400\n1 1 1 1 1 1\n0 0 0 0 0 0\n";
    let samples = (0..600 * 400 * 9_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8);
    let file = header.iter().copied().chain(samples).collect::<Vec<u8>>();
    let file = here.write("large.ptm", file);
    let frame = |program: &mut Command| {
        let output = program.arg("coef").arg(&file).output();
        output.expect("the program starts").stdout
    };
    let expected = frame(program().arg("reference"));
    let found = frame(Command::new("node").arg(repository("examples/decoders/ptm_decoder.js")));
    assert!(
        expected == found,
        "{} and {} bytes",
        expected.len(),
        found.len()
    );
}
