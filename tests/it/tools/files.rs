//! The tools for files: what they print is what their schemas say, and what they write is what other programs read.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::common::{have_python, program, repository, run};
use ptm_conform::generate::{Model, Recipe, write};
use ptm_conform::ptm::Format;
use ptm_conform::suite::cases::{Suite, TableSpelling};
use ptm_conform::tools::dissection::FilePart;
use ptm_conform::tools::inspect::inspect;
use ptm_conform::tools::profiles::Profile;
use serde_json::Value;

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[output.stdout.clone(), output.stderr.clone()].concat()).into_owned()
}

/// An ordinary file of each format.
fn files(directory: &Path) -> Vec<(Format, PathBuf)> {
    let write_one = |format: Format| {
        let recipe = Recipe::ordinary(format, "9x5".parse().expect("a size"));
        let path = directory.join(format!("{}.ptm", format.short_name()));
        fs::write(&path, write(&recipe, &Model::paint(&recipe)).bytes).expect("a file is written");
        (format, path)
    };
    Format::ALL.into_iter().map(write_one).collect()
}

#[track_caller]
fn succeeds(args: &[&str]) -> Output {
    let output = run(args);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", text(&output));
    output
}

#[track_caller]
fn conforms(value: &Value, schema: &str) {
    let path = repository(&format!("spec-cases/schema/{schema}"));
    let schema: Value = serde_json::from_str(&fs::read_to_string(path).expect("a schema"))
        .expect("a schema is JSON");
    let validator = jsonschema::validator_for(&schema).expect("a schema is a schema");
    let errors: Vec<String> = validator
        .iter_errors(value)
        .map(|error| format!("{}: {error}", error.instance_path()))
        .take(5)
        .collect();
    assert!(errors.is_empty(), "{errors:#?}");
}

/// What a command prints as YAML and as JSON, which is to be the same and what the schema says.
#[track_caller]
fn printed(args: &[&str], schema: &str) -> Value {
    let said = |form: &str| {
        let output = run(&[args, &[form]].concat());
        String::from_utf8(output.stdout).expect("it is text")
    };
    let yaml: Value = ptm_conform::kit::yaml::from_yaml(&said("--yaml")).expect("it is YAML");
    let json: Value = serde_json::from_str(&said("--json")).expect("it is JSON");
    assert_eq!(yaml, json, "{args:?}");
    conforms(&yaml, schema);
    yaml
}

/// Runs a Python program; nothing, and SKIPPED aloud, where a package it imports is missing.
fn python(packages: &[&str], code: &str, args: &[&Path]) -> Option<String> {
    if !have_python(packages) {
        return None;
    }
    let output = Command::new("python3")
        .arg("-c")
        .arg(code)
        .args(args)
        .output()
        .expect("python3 starts");
    assert!(output.status.success(), "{}", text(&output));
    Some(String::from_utf8(output.stdout).expect("it is text"))
}

/// A frame of the reference without its first line.
fn frame(view: &str, file: &Path) -> Vec<u8> {
    let output = program()
        .arg("reference")
        .arg(view)
        .arg(file)
        .output()
        .expect("the program starts");
    let end = output
        .stdout
        .iter()
        .position(|&byte| byte == b'\n')
        .expect("a line");
    output.stdout[end + 1..].to_vec()
}

#[test]
fn every_part_of_every_file_of_the_suite_lies_within_it() {
    fn check(id: &str, bytes: usize, shown: &[FilePart]) {
        let mut end = 0;
        for part in shown {
            assert!(
                part.offset >= end && part.offset + part.length <= bytes,
                "{id}: {} at {}",
                part.name,
                part.offset
            );
            end = part.offset + part.length;
            check(id, end, &part.parts);
        }
    }
    for case in &Suite::load().expect("the suite loads").cases {
        let built = case.build(TableSpelling::default());
        let inspection = inspect(&built.file);
        check(&case.id, built.file.len(), &inspection.fields);
        let (error, decoded) = (inspection.error.is_some(), ptm_conform::decode(&built.file));
        assert_eq!(error, decoded.is_err(), "{}", case.id);
        for all in [false, true] {
            assert!(
                inspection.to_text("x.ptm", all).lines().count() > 2,
                "{}",
                case.id
            );
        }
    }
}

#[test]
fn inspection_is_yaml_and_json_of_one_content() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    for (format, path) in files(scratch.path()) {
        let file = path.to_string_lossy();
        let value = printed(&["inspect", &file], "inspect.schema.json");
        assert_eq!(value["format"], format.name());
        assert_eq!((&value["width"], &value["height"]), (&9.into(), &5.into()));
    }
    let damaged = repository("corpus/lrgb/half-payload-lrgb.ptm");
    let value = printed(&["inspect", &damaged], "inspect.schema.json");
    assert_eq!(value["error"]["clause"], "2.7/3");
    assert_eq!(run(&["inspect", &damaged]).status.code(), Some(65));
}

#[test]
fn lint_is_yaml_and_json_of_one_content_and_has_exit_statuses() {
    let sound = repository("corpus/lrgb/first-lrgb.ptm");
    let damaged = repository("corpus/lrgb/half-payload-lrgb.ptm");
    let doubtful = repository("corpus/lum/first-lum.ptm");
    let value = printed(&["lint", &sound, &damaged, &doubtful], "lint.schema.json");
    assert_eq!(value[1]["findings"][0]["code"], "PTM-E070");
    assert_eq!(value[0]["errors"], 0);
    printed(&["lint", "--codes"], "lint-codes.schema.json");
    for (args, status) in [
        (&["lint", &sound][..], 0),
        (&["lint", &sound, &damaged], 1),
        (&["lint", &doubtful], 0),
        (&["lint", "--deny-warnings", &doubtful], 1),
        (
            &[
                "lint",
                "--deny-warnings",
                "--allow",
                "PTM-W303",
                "--allow",
                "PTM-W304",
                "--allow",
                "PTM-W305",
                &doubtful,
            ],
            0,
        ),
        (&["lint", "no-such-file.ptm", &sound], 2),
        (&["lint", "--allow", "PTM-E999", &sound], 2),
        (&["lint"], 2),
    ] {
        assert_eq!(run(args).status.code(), Some(status), "{args:?}");
    }
}

#[test]
fn color_is_where_it_is_asked_for() {
    let file = repository("corpus/lrgb/first-lrgb.ptm");
    let escapes = |args: &[&str]| succeeds(args).stdout.contains(&0x1b);
    assert!(!escapes(&["inspect", &file]));
    assert!(escapes(&["inspect", "--color", "always", &file]));
    assert!(!escapes(&["--color", "never", "inspect", &file]));
}

#[test]
fn quiet_prints_results_only() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let (file, out) = (
        repository("corpus/lum/first-lum.ptm"),
        scratch.path().join("x.png"),
    );
    assert!(succeeds(&["--quiet", "lint", &file]).stdout.is_empty());
    assert!(
        succeeds(&["render", "-q", &file, "-o", &out.to_string_lossy()])
            .stdout
            .is_empty()
    );
}

#[test]
fn pictures_are_read_by_pillow() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    for (format, path) in files(scratch.path()) {
        let (file, out) = (
            path.to_string_lossy().into_owned(),
            scratch.path().join("x.png"),
        );
        let out_text = out.to_string_lossy().into_owned();
        let read = "import sys; from PIL import Image; im = Image.open(sys.argv[1]); print(im.mode, *im.size, im.tobytes().hex())";
        let hex =
            |bytes: &[u8]| -> String { bytes.iter().map(|byte| format!("{byte:02x}")).collect() };

        succeeds(&["render", &file, "--light", "-0.25,0.5", "-o", &out_text]);
        let Some(said) = python(&["PIL"], read, &[&out]) else {
            return;
        };
        assert_eq!(
            said.trim(),
            format!("RGB 9 5 {}", hex(&frame("rgb:-0.25,0.5", &path))),
            "{format}"
        );

        succeeds(&["export", &file, "-o", &out_text]);
        let channels = format.channels();
        let raw = frame("raw", &path);
        let planes: Vec<u8> = (0..channels)
            .flat_map(|plane| raw.iter().skip(plane).step_by(channels).copied())
            .collect();
        let said = python(&["PIL"], read, &[&out]).expect("it was there before");
        assert_eq!(
            said.trim(),
            format!("L 9 {} {}", 5 * channels, hex(&planes)),
            "{format}"
        );

        if format != Format::Rgb {
            continue;
        }
        for more in [
            &["--normals"][..],
            &["--sheet"],
            &["--sheet=3", "--cell", "4"],
        ] {
            succeeds(&[&["render", file.as_str(), "-o", &out_text], more].concat());
            assert!(
                python(&["PIL"], read, &[&out])
                    .expect("it was there before")
                    .starts_with("RGB "),
                "{more:?}"
            );
        }
    }
}

#[test]
fn arrays_are_read_by_numpy() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let read = "import sys, numpy; a = numpy.load(sys.argv[1]); print(a.dtype.str, a.shape, a.tobytes().hex())";
    let hex = |bytes: &[u8]| -> String { bytes.iter().map(|byte| format!("{byte:02x}")).collect() };
    for (format, path) in files(scratch.path()) {
        let out = scratch.path().join("x.npy");
        for (view, kind, more) in [("raw", "|u1", None), ("coef", "<f4", Some("--final"))] {
            let mut command = program();
            command
                .arg("export")
                .arg(&path)
                .arg("-o")
                .arg(&out)
                .args(more);
            assert!(
                command
                    .output()
                    .expect("the program starts")
                    .status
                    .success()
            );
            let Some(said) = python(&["numpy"], read, &[&out]) else {
                return;
            };
            let expected = format!(
                "{kind} (5, 9, {}) {}",
                format.channels(),
                hex(&frame(view, &path))
            );
            assert_eq!(said.trim(), expected, "{format}");
        }
    }
}

#[test]
fn coefficients_are_read_by_openexr() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let read = "
import sys, numpy, OpenEXR
file = OpenEXR.File(sys.argv[1], separate_channels=True)
assert file.header()['type'] == OpenEXR.scanlineimage and file.header()['compression'] == OpenEXR.ZIP_COMPRESSION
for name, channel in sorted(file.channels().items()):
    print(name, channel.pixels.dtype.str, channel.pixels.shape, channel.pixels.tobytes().hex())
print(file.header()['ptm'])";
    for (format, path) in files(scratch.path()) {
        let out = scratch.path().join("x.exr");
        succeeds(&[
            "export",
            &path.to_string_lossy(),
            "-o",
            &out.to_string_lossy(),
        ]);
        let Some(said) = python(&["numpy", "OpenEXR"], read, &[&out]) else {
            return;
        };
        let bytes = frame("coef", &path);
        let channels = format.channels();
        let names: Vec<String> = match channels {
            18 => ["red", "green", "blue"]
                .iter()
                .flat_map(|color| (0..6).map(move |i| format!("{color}.a{i}")))
                .collect(),
            9 => "a0 a1 a2 a3 a4 a5 R G B"
                .split(' ')
                .map(str::to_owned)
                .collect(),
            _ => "a0 a1 a2 a3 a4 a5 Cr Cb"
                .split(' ')
                .map(str::to_owned)
                .collect(),
        };
        let mut lines: Vec<String> = names
            .iter()
            .enumerate()
            .map(|(channel, name)| {
                let plane: String = bytes
                    .chunks(4)
                    .skip(channel)
                    .step_by(channels)
                    .flatten()
                    .map(|byte| format!("{byte:02x}"))
                    .collect();
                format!("{name} <f4 (5, 9) {plane}")
            })
            .collect();
        lines.sort();
        let said: Vec<&str> = said.lines().collect();
        assert_eq!(said[..channels], lines, "{format}");
        assert!(
            said[channels].starts_with(&format!("{format}; scale 0.5 0.25")),
            "{}",
            said[channels]
        );
    }
}

#[test]
fn an_exported_file_is_the_same_every_time() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    for (_, path) in files(scratch.path()) {
        let written = |name: &str| {
            let out = scratch.path().join(name);
            succeeds(&[
                "export",
                &path.to_string_lossy(),
                "-o",
                &out.to_string_lossy(),
            ]);
            fs::read(out).expect("a file")
        };
        for name in ["x.exr", "x.npy", "x.png"] {
            assert!(written(name) == written(name), "{name}");
        }
    }
}

#[test]
fn maps_are_converted_without_a_loss_where_the_target_can_hold_them() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let out = scratch.path().join("out.ptm");
    let out = out.to_string_lossy().into_owned();
    let mut converted = 0;
    for (format, path) in files(scratch.path()) {
        let file = path.to_string_lossy().into_owned();
        for target in Format::ALL {
            let lossy = matches!(target, Format::JpegRgb | Format::JpegLrgb);
            if lossy || format.channels() != target.channels() {
                continue;
            }
            succeeds(&["convert", &file, "--to", target.short_name(), "-o", &out]);
            succeeds(&["diff", &file, &out]);
            converted += 1;
        }
    }
    // 2 of RGB's kind from 3 formats, 4 of LRGB's kind from 5, LUM into itself.
    assert_eq!(converted, 3 * 2 + 5 * 4 + 1);
}

#[test]
fn a_loss_stays_within_what_was_allowed() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let path = |name: &str| scratch.path().join(name).to_string_lossy().into_owned();
    let (file, out) = (path("LRGB.ptm"), path("out.ptm"));
    files(scratch.path());
    succeeds(&[
        "convert",
        &file,
        "--to",
        "jpegls_lrgb",
        "--loss",
        "3",
        "-o",
        &out,
    ]);
    let value = printed(&["diff", &file, &out], "diff.schema.json");
    let planes = value["planes"].as_array().expect("planes differ");
    assert!(
        !planes.is_empty()
            && planes
                .iter()
                .all(|plane| plane["largest"].as_u64() <= Some(3)),
        "{value}"
    );
    succeeds(&[
        "convert",
        &file,
        "--to",
        "JPEG_LRGB",
        "--quality",
        "95",
        "-o",
        &out,
    ]);
    assert_eq!(run(&["diff", &file, &out]).status.code(), Some(1));
}

#[test]
fn what_a_target_cannot_hold_is_refused_and_nothing_is_written() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    files(scratch.path());
    let path = |name: &str| scratch.path().join(name).to_string_lossy().into_owned();
    let out = path("out.ptm");
    for (file, more, words) in [
        (
            "RGB.ptm",
            &["--to", "LRGB"][..],
            "45 of 45 texels do not fit, the first at column 0, row 0",
        ),
        ("LRGB.ptm", &["--to", "RGB"], "texels do not fit"),
        ("LUM.ptm", &["--to", "LRGB"], "lum-vector"),
        ("LRGB.ptm", &["--to", "LUM"], "without a loss"),
        ("LRGB.ptm", &["--to", "JPEG_LRGB"], "--quality"),
        (
            "LRGB.ptm",
            &["--to", "PTM_LUT", "--quality", "90"],
            "--quality is for JPEG",
        ),
        (
            "LRGB.ptm",
            &["--to", "PTM_LUT", "--loss", "3"],
            "--loss is for JPEGLS",
        ),
    ] {
        let usage = words.starts_with("--");
        let output = run(&[&["convert", path(file).as_str(), "-o", &out], more].concat());
        assert_eq!(
            output.status.code(),
            Some(if usage { 2 } else { 1 }),
            "{file} {more:?}: {}",
            text(&output)
        );
        assert!(text(&output).contains(words), "{}", text(&output));
        assert!(!Path::new(&out).exists());
    }
}

#[test]
fn gray_rgb_becomes_lrgb_and_comes_back() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let path = |name: &str| scratch.path().join(name).to_string_lossy().into_owned();
    // Red and green alike, blue three fifths of them, biases all 100; worked out by hand.
    let mut file =
        b"PTM_1.2\nPTM_FORMAT_RGB\n1\n1\n1 1 2 1 1 1\n100 100 100 100 100 100\n".to_vec();
    file.extend([
        110, 120, 95, 100, 130, 105, 110, 120, 95, 100, 130, 105, 106, 112, 97, 100, 118, 103,
    ]);
    fs::write(path("a.ptm"), &file).expect("a file is written");
    succeeds(&[
        "convert",
        &path("a.ptm"),
        "--to",
        "LRGB",
        "-o",
        &path("b.ptm"),
    ]);
    let written = fs::read(path("b.ptm")).expect("a file");
    assert!(
        written.ends_with(&[110, 120, 95, 100, 130, 105, 255, 255, 153]),
        "{written:?}"
    );
    succeeds(&[
        "convert",
        &path("b.ptm"),
        "--to",
        "RGB",
        "-o",
        &path("c.ptm"),
    ]);
    succeeds(&["diff", &path("a.ptm"), &path("c.ptm")]);
    assert!(fs::read(path("c.ptm")).expect("a file") == file);
}

#[test]
fn a_table_of_too_many_texels_is_refused_with_their_number() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let path = |name: &str| scratch.path().join(name).to_string_lossy().into_owned();
    for (entries, status) in [(65_536, 0), (65_537, 1)] {
        let mut file =
            format!("PTM_1.2\nPTM_FORMAT_LRGB\n{entries}\n1\n1 1 1 1 1 1\n0 0 0 0 0 0\n")
                .into_bytes();
        file.extend(
            (0..entries as u32).flat_map(|i| [0, 0, 0, (i >> 16) as u8, (i >> 8) as u8, i as u8]),
        );
        file.extend(vec![9; 3 * entries]);
        fs::write(path("a.ptm"), file).expect("a file is written");
        let output = run(&[
            "convert",
            &path("a.ptm"),
            "--to",
            "PTM_C_LUT",
            "-o",
            &path("b.ptm"),
        ]);
        assert_eq!(output.status.code(), Some(status), "{}", text(&output));
        if status == 1 {
            assert!(
                text(&output).contains("65537 texels are distinct"),
                "{}",
                text(&output)
            );
        } else {
            succeeds(&["diff", &path("a.ptm"), &path("b.ptm")]);
        }
    }
}

#[test]
fn differences_are_told_exactly() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let path = |name: &str| scratch.path().join(name).to_string_lossy().into_owned();
    let header = "PTM_1.2\nPTM_FORMAT_LRGB\n2\n2\n1 1 1 1 1 1\n0 0 0 0 0 0\n";
    let file: Vec<u8> = [header.as_bytes(), &(0..36).collect::<Vec<u8>>()].concat();
    let mut other = file.clone();
    // a3 of the second texel of the first stored row, which is the bottom row; and a bias.
    other[header.len() + 9] = 19;
    let other = String::from_utf8_lossy(&other)
        .replace("0 0 0 0 0 0\n", "0 0 0 0 0 -7\n")
        .into_bytes();
    fs::write(path("a.ptm"), &file).expect("a file is written");
    fs::write(path("b.ptm"), other).expect("a file is written");
    let value = printed(
        &["diff", &path("a.ptm"), &path("b.ptm")],
        "diff.schema.json",
    );
    let expected = serde_json::json!({
        "same": false,
        "header": ["bias of a5: 0 and -7"],
        "planes": [{ "plane": 3, "channel": "a3", "texels": 1, "largest": 10, "first": { "x": 1, "y": 1, "values": [9, 19] } }],
        "written": [],
    });
    assert_eq!(value, expected);
    let damaged = repository("corpus/lrgb/half-payload-lrgb.ptm");
    for (a, b, status) in [
        ("a.ptm", "a.ptm", 0),
        ("a.ptm", "b.ptm", 1),
        ("a.ptm", "none.ptm", 2),
    ] {
        assert_eq!(
            run(&["diff", &path(a), &path(b)]).status.code(),
            Some(status)
        );
    }
    assert_eq!(
        run(&["diff", &path("a.ptm"), &damaged]).status.code(),
        Some(2)
    );
}

#[test]
fn wrong_usage_is_2_and_says_what_to_try() {
    let file = repository("corpus/lrgb/first-lrgb.ptm");
    for (args, words) in [
        (&["render", &file, "-o", "x.gif"][..], ".webp or .jpg"),
        (
            &["render", &file, "--light", "0.9,0.9", "-o", "x.png"],
            "below the horizon",
        ),
        (
            &["render", &file, "--light", "north", "-o", "x.png"],
            "two numbers such as",
        ),
        (&["export", &file, "-o", "x.tif"], ".exr, .npy or .png"),
        (
            &["export", &file, "--final", "-o", "x.png"],
            "PNG cannot hold",
        ),
        (
            &["convert", &file, "--to", "TIFF", "-o", "x.ptm"],
            "formats are RGB, LUM",
        ),
        (&["inspect", "no-such-file.ptm"], "no-such-file.ptm"),
    ] {
        let output = run(args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", text(&output));
        assert!(text(&output).contains(words), "{}", text(&output));
    }
    let damaged = repository("corpus/lrgb/half-payload-lrgb.ptm");
    let output = run(&["render", &damaged, "-o", "x.png"]);
    assert_eq!(output.status.code(), Some(65));
    assert!(
        text(&output).contains("ptm-conform inspect"),
        "{}",
        text(&output)
    );
}

/// All files below a directory.
fn tree(directory: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    let mut left = vec![directory.to_owned()];
    while let Some(place) = left.pop() {
        for entry in fs::read_dir(&place).expect("a directory") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                left.push(path);
            } else {
                let name = path.strip_prefix(directory).expect("it is below");
                files.push((
                    name.to_string_lossy().into_owned(),
                    fs::read(&path).expect("a file"),
                ));
            }
        }
    }
    files.sort();
    files
}

#[test]
fn a_corpus_for_others_is_whole_and_the_same_every_time() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let made = |name: &str, profile: &str, jobs: &str| {
        let out = scratch.path().join(name);
        succeeds(&[
            "generate",
            "--profile",
            profile,
            "--jobs",
            jobs,
            "--out",
            &out.to_string_lossy(),
        ]);
        out
    };
    let (one, seven) = (made("one", "minimal", "1"), made("seven", "minimal", "7"));
    assert!(tree(&one) == tree(&seven));
    for corpus in [one, made("standard", "standard", "2")] {
        let text = |name: &str| fs::read_to_string(corpus.join(name)).expect("a manifest");
        let yaml: Value =
            ptm_conform::kit::yaml::from_yaml(&text("MANIFEST.yaml")).expect("it is YAML");
        let json: Value = serde_json::from_str(&text("MANIFEST.json")).expect("it is JSON");
        assert_eq!(yaml, json);
        conforms(&json, "profile.schema.json");
        let mut listed: Vec<String> = [
            "README.md",
            ".gitattributes",
            "MANIFEST.yaml",
            "MANIFEST.json",
        ]
        .map(str::to_owned)
        .to_vec();
        let ids: Vec<&Value> = json["cases"]
            .as_array()
            .expect("cases")
            .iter()
            .map(|case| &case["id"])
            .collect();
        for case in json["cases"].as_array().expect("cases") {
            let answers = case["expected"].as_array().cloned().unwrap_or_default();
            for file in std::iter::once(case).chain(&answers) {
                let path = file["file"].as_str().expect("a path");
                let bytes = fs::read(corpus.join(path)).expect("the file is there");
                assert_eq!(
                    file["sha256"],
                    ptm_conform::kit::digest::sha256(&bytes),
                    "{path}"
                );
                listed.push(path.to_owned());
                listed.extend(file["slack"].as_str().map(str::to_owned));
            }
            if case["expect"] == "reject" {
                assert!(case["lint"].is_string(), "{case}");
                assert!(ids.contains(&&case["twin_of"]), "{case}");
            }
        }
        listed.sort();
        listed.dedup();
        let there: Vec<String> = tree(&corpus).into_iter().map(|(name, _)| name).collect();
        assert_eq!(listed, there);
    }
    let output = run(&[
        "generate",
        "--profile",
        "minimal",
        "--out",
        &scratch.path().to_string_lossy(),
    ]);
    assert_eq!(
        output.status.code(),
        Some(2),
        "a directory that is not empty"
    );
}

#[test]
fn the_test_in_the_readme_of_the_corpus_runs() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let corpus = scratch.path().join("corpus");
    succeeds(&[
        "generate",
        "--profile",
        "minimal",
        "--out",
        &corpus.to_string_lossy(),
    ]);
    let readme = fs::read_to_string(corpus.join("README.md")).expect("the README");
    let snippet: String = readme
        .lines()
        .filter_map(|line| line.strip_prefix("    "))
        .map(|line| format!("{line}\n"))
        .collect();
    assert!(snippet.contains("numpy.load"), "{snippet}");
    // The test of the README with the Python decoder as the reader's own; it says how many answers it compared.
    let around = "
import os, sys, numpy
sys.path.insert(0, sys.argv[1])
os.chdir(sys.argv[2])
import ptm_decoder
compared = [0, 0]
def my_decoder(path):
    compared[0] += 1
    ptm = ptm_decoder.read_ptm(open(path, 'rb').read())
    return numpy.array([list(texel) for texel in ptm.texels], 'u1').reshape(ptm.height, ptm.width, -1)
def my_decoder_refuses(path):
    compared[1] += 1
    try: my_decoder(path)
    except ptm_decoder.Malformed: return True
";
    let code = format!("{around}{snippet}print(*compared)");
    let decoders = PathBuf::from(repository("examples/decoders"));
    let Some(said) = python(
        &["numpy", "PIL", "pillow_jpls"],
        &code,
        &[&decoders, &corpus],
    ) else {
        return;
    };
    let counts: Vec<usize> = said
        .split_whitespace()
        .map(|word| word.parse().expect("a number"))
        .collect();
    assert!(counts[0] > 100 && counts[1] > 40, "{counts:?}");
}

#[test]
fn pictures_and_exr_of_the_corpus_say_what_its_arrays_say() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let suite = Suite::load().expect("the suite loads");
    // A few cases of each kind; the whole takes long.
    let few = Suite {
        cases: suite
            .cases
            .into_iter()
            .filter(|case| case.first || case.id.starts_with("overflows-corrected"))
            .collect(),
    };
    let out = scratch.path().join("corpus");
    ptm_conform::tools::profiles::write(&few, &out, Profile::Exhaustive, 2, &|_, _| ())
        .expect("it is written");
    let code = "
import json, os, sys, numpy, OpenEXR
from PIL import Image
os.chdir(sys.argv[1])
pairs = dict(png=0, exr=0, slack=0)
for case in json.load(open('MANIFEST.json'))['cases']:
    for answer in case.get('expected', []):
        array = numpy.load(answer['file'][:-3] + 'npy')
        rows, columns, channels = answer['shape']
        assert array.shape == (rows, columns, channels), answer
        assert array.dtype == ('u1' if answer['view'] == 'raw' else 'f4'), answer
        if 'slack' in answer:
            assert numpy.load(answer['slack']).shape == array.shape
            pairs['slack'] += 1
        if answer['encoding'] == 'png':
            picture = numpy.array(Image.open(answer['file']))
            expected = numpy.moveaxis(array, 2, 0).reshape(-1, columns) if answer['view'] == 'raw' else array
            assert abs(picture - expected.astype('f8')).max() <= 0.5 + 1e-4, answer
        elif answer['encoding'] == 'exr':
            names = {18: [c + '.a%d' % i for c in ('red', 'green', 'blue') for i in range(6)],
                     9: ['a%d' % i for i in range(6)] + list('RGB'),
                     8: ['a%d' % i for i in range(6)] + ['Cr', 'Cb']}[channels]
            layers = OpenEXR.File(answer['file'], separate_channels=True).channels()
            assert sorted(layers) == sorted(names)
            for i, name in enumerate(names):
                assert (layers[name].pixels == array[:, :, i]).all(), answer
        if answer['encoding'] != 'npy':
            pairs[answer['encoding']] += 1
print(*pairs.values())";
    let Some(said) = python(&["numpy", "PIL", "OpenEXR"], code, &[&out]) else {
        return;
    };
    let counts: Vec<usize> = said
        .split_whitespace()
        .map(|word| word.parse().expect("a number"))
        .collect();
    assert!(counts.iter().all(|&count| count > 0), "{counts:?}");
}

#[test]
fn completions_and_man_pages_name_every_command() {
    let commands = [
        "check",
        "reference",
        "generate",
        "explain",
        "inspect",
        "lint",
        "render",
        "export",
        "convert",
        "diff",
    ];
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let said = text(&succeeds(&["completions", shell]));
        assert!(
            commands.iter().all(|command| said.contains(command)),
            "{shell}"
        );
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let pages = scratch.path().join("man1");
    succeeds(&["man", &pages.to_string_lossy()]);
    for command in commands {
        let page =
            fs::read_to_string(pages.join(format!("ptm-conform-{command}.1"))).expect("a page");
        assert!(page.contains(".SH SYNOPSIS"), "{command}");
    }
    assert!(!pages.join("ptm-conform-watch.1").exists());
}

#[test]
fn bash_accepts_its_completions() {
    if !crate::common::have("bash") {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let path = scratch.path().join("ptm-conform");
    fs::write(&path, succeeds(&["completions", "bash"]).stdout).expect("a file is written");
    let code = "source \"$1\"; f=$(complete -p ptm-conform | sed 's/.*-F \\([^ ]*\\).*/\\1/'); COMP_WORDS=(ptm-conform lin); COMP_CWORD=1; $f ptm-conform lin ptm-conform; echo \"${COMPREPLY[@]}\"";
    let output = Command::new("bash")
        .args(["-c", code, "bash"])
        .arg(&path)
        .output()
        .expect("bash starts");
    assert_eq!(
        String::from_utf8_lossy(&output.stdout).trim(),
        "lint",
        "{}",
        text(&output)
    );
}

#[test]
fn a_code_of_lint_is_explained() {
    let said = text(&succeeds(&["explain", "PTM-E070"]));
    assert!(
        said.contains("code PTM-E070 (error, clause 2.7/3)") && said.contains("Fix: "),
        "{said}"
    );
    let output = run(&["explain", "lut-cuont"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output).contains("did you mean lut-count?"),
        "{}",
        text(&output)
    );
}
