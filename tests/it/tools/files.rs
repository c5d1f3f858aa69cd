//! Tests of the tools for files: their output conforms to the schemas, and other programs can read the files that they write.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::Command;

use crate::common::{
    Workspace, assert_conforms, edit, have_python, have_tool, repository, rows, stdout,
};
use crate::repository::tree;
use data_encoding::HEXLOWER;
use ptm::{Coding, Format};
use ptm_files::dissection::{Dissection, FilePart, Role};
use ptm_files::inspect::inspect;
use ptm_files::profiles::{self, Profile};
use ptm_generate::{Model, Recipe, write};
use ptm_suite::cases::{Suite, TableSpelling};
use ptm_suite::kit::{digest::sha256, yaml::from_yaml};
use serde_json::Value;

/// Creates a workspace with an ordinary file of each format, such as `LRGB.ptm`.
fn workspace_with_formats() -> Workspace {
    let here = Workspace::new();
    for format in Format::ALL {
        let recipe = Recipe::default_for(format, "9x5".parse().expect("a size"));
        let file = write(&recipe, &Model::paint(&recipe)).bytes;
        here.write(&format!("{}.ptm", format.short_name()), file);
    }
    here
}

/// Creates a workspace with a sound file, a damaged file, and a file with warnings.
fn workspace_with_corpus() -> Workspace {
    let here = Workspace::new();
    for file in [
        "lrgb/first-lrgb.ptm",
        "lrgb/half-payload-lrgb.ptm",
        "lum/first-lum.ptm",
    ] {
        here.copy_from_corpus(file);
    }
    here
}

/// Runs a command with `--yaml` and `--json`. Asserts that both outputs have the same value and that it conforms to the schema.
#[track_caller]
fn machine_output(here: &Workspace, line: &str, schema: &str) -> Value {
    let print = |form: &str| {
        let output = here.command(&format!("{line} {form}")).output();
        String::from_utf8(output.expect("the program starts").stdout).expect("UTF-8")
    };
    let yaml: Value = from_yaml(&print("--yaml")).expect("YAML");
    let json: Value = serde_json::from_str(&print("--json")).expect("JSON");
    assert_eq!(yaml, json, "{line}");
    assert_conforms(&yaml, schema);
    yaml
}

/// Runs a Python program with file names as arguments. Returns `None` and prints SKIPPED if a package is missing.
fn python(here: &Workspace, packages: &[&str], code: &str, files: &[&str]) -> Option<String> {
    let mut command = Command::new("python3");
    command
        .current_dir(here.path(""))
        .args(["-c", code])
        .args(files);
    have_python(packages).then(|| stdout(&mut command))
}

/// Returns the samples that the reference decoder writes for a view of a file.
fn samples(here: &Workspace, view: &str, file: &str) -> Vec<u8> {
    let output = here.command(&format!("reference {view} {file}")).output();
    let frame = output.expect("the program starts").stdout;
    let end = frame.iter().position(|&byte| byte == b'\n');
    frame[end.expect("a line") + 1..].to_vec()
}

#[test]
fn parts_of_every_file_are_disjoint_and_inside_it() {
    fn check(id: &str, bytes: usize, parts: &[FilePart]) {
        let mut end = 0;
        for part in parts {
            let is_inside = part.offset >= end && part.offset + part.length <= bytes;
            assert!(is_inside, "{id}: {} at {}", part.name, part.offset);
            end = part.offset + part.length;
            check(id, end, &part.parts);
        }
    }
    for case in &Suite::load().expect("the suite loads").cases {
        let built = case.build(TableSpelling::default());
        let inspection = inspect(&built.file);
        check(&case.id, built.file.len(), &inspection.fields);
        let decoded = ptm::decode(&built.file);
        assert_eq!(inspection.error.is_some(), decoded.is_err(), "{}", case.id);
        for all in [false, true] {
            let lines = inspection.to_text("x.ptm", all).lines().count();
            assert!(lines > 2, "{}", case.id);
        }
    }
}

#[test]
fn inspection_is_the_same_in_yaml_and_json() {
    let here = workspace_with_formats();
    for format in Format::ALL {
        let line = format!("inspect {}.ptm", format.short_name());
        let value = machine_output(&here, &line, "inspect");
        assert_eq!(value["format"], format.name());
        assert_eq!((&value["width"], &value["height"]), (&9.into(), &5.into()));
    }
    let here = workspace_with_corpus();
    let value = machine_output(&here, "inspect half-payload-lrgb.ptm", "inspect");
    assert_eq!(value["error"]["clause"], "2.7/3");
    here.exits(65, "inspect half-payload-lrgb.ptm");
}

#[test]
fn lint_is_the_same_in_yaml_and_json() {
    let here = workspace_with_corpus();
    let line = "lint first-lrgb.ptm half-payload-lrgb.ptm first-lum.ptm";
    let value = machine_output(&here, line, "lint");
    assert_eq!(value[1]["findings"][0]["code"], "PTM-E070");
    assert_eq!(value[0]["errors"], 0);
    machine_output(&here, "lint --codes", "lint-codes");
}

#[test]
fn commands_have_the_expected_status_and_output() {
    let here = workspace_with_corpus();
    here.assert_lines(
        "
1 | lint --deny-warnings first-lum.ptm |
0 | lint --deny-warnings --allow PTM-W303 --allow PTM-W304 --allow PTM-W313 first-lum.ptm |
2 | lint --allow PTM-E999 first-lrgb.ptm |
2 | lint |
2 | render first-lrgb.ptm -o x.gif | .jpg or .html
2 | render first-lrgb.ptm --light 0.9,0.9 -o x.png | below the horizon
2 | render first-lrgb.ptm --light north -o x.png | two numbers such as
2 | export first-lrgb.ptm -o x.tif | .exr, .npy or .png
2 | export first-lrgb.ptm --final -o x.png | PNG cannot store
2 | export first-lrgb.ptm --normalize -o x.npy | only final coefficients
2 | convert first-lrgb.ptm --to TIFF -o x.ptm | expected one of RGB, LUM
2 | convert first-lrgb.ptm --to JPEG_LRGB -o ./first-lrgb.ptm | is the input file
2 | generate --ptm-format LRGB | --profile
0 | generate --profile minimal --ptm-format lrgb --out lrgb | correct answers in lrgb
0 | explain relight | cnr-isti-vclab/relight && version-with-space-is-1.1
2 | inspect no-such-file.ptm | no-such-file.ptm
65 | render half-payload-lrgb.ptm -o x.png | ptm-conform inspect
0 | explain PTM-E070 | code PTM-E070 (error, clause 2.7/3) && Fix:
2 | explain lut-cuont | did you mean lut-count?",
    );
    for line in [
        "--quiet lint first-lum.ptm",
        "render -q first-lum.ptm -o x.png",
    ] {
        assert_eq!(here.succeeds(line), "", "{line}");
    }
}

#[test]
fn images_are_read_by_pillow() {
    let here = workspace_with_formats();
    let read = "import sys; from PIL import Image; im = Image.open(sys.argv[1]); print(im.mode, *im.size, im.tobytes().hex())";
    for format in Format::ALL {
        let file = format!("{}.ptm", format.short_name());
        here.succeeds(&format!("render {file} --light -0.25,0.5 -o x.png"));
        let Some(image) = python(&here, &["PIL"], read, &["x.png"]) else {
            return;
        };
        let hex = HEXLOWER.encode(&samples(&here, "rgb:-0.25,0.5", &file));
        assert_eq!(image.trim(), format!("RGB 9 5 {hex}"), "{format}");

        here.succeeds(&format!("export {file} -o x.png"));
        let (channels, raw) = (format.channels(), samples(&here, "raw", &file));
        let plane = |plane| raw.iter().skip(plane).step_by(channels).copied();
        let planes: Vec<u8> = (0..channels).flat_map(plane).collect();
        let image = python(&here, &["PIL"], read, &["x.png"]).expect("Pillow is installed");
        let expected = format!("L 9 {} {}", 5 * channels, HEXLOWER.encode(&planes));
        assert_eq!(image.trim(), expected, "{format}");
    }
    for options in ["--normals", "--sheet", "--sheet=3 --cell 4"] {
        here.succeeds(&format!("render RGB.ptm -o x.png {options}"));
        let image = python(&here, &["PIL"], read, &["x.png"]).expect("Pillow is installed");
        assert!(image.starts_with("RGB "), "{options}");
    }
}

#[test]
fn arrays_are_read_by_numpy() {
    let here = workspace_with_formats();
    let read = "import sys, numpy; a = numpy.load(sys.argv[1]); print(a.dtype.str, a.shape, a.tobytes().hex())";
    for format in Format::ALL {
        let (file, channels) = (format!("{}.ptm", format.short_name()), format.channels());
        for (view, kind, option) in [("raw", "|u1", ""), ("coef", "<f4", "--final")] {
            here.succeeds(&format!("export {file} -o x.npy {option}"));
            let Some(array) = python(&here, &["numpy"], read, &["x.npy"]) else {
                return;
            };
            let hex = HEXLOWER.encode(&samples(&here, view, &file));
            let expected = format!("{kind} (5, 9, {channels}) {hex}");
            assert_eq!(array.trim(), expected, "{format}");
        }
    }
}

#[test]
fn normalized_coefficients_are_divided_by_255() {
    let here = workspace_with_formats();
    for format in Format::ALL {
        let file = format!("{}.ptm", format.short_name());
        here.succeeds(&format!("export {file} --final --normalize -o x.npy"));
        let array = std::fs::read(here.path("x.npy")).expect("an array");
        let map = ptm::decode(&std::fs::read(here.path(&file)).expect("a map"));
        let values = map.expect("a sound map").coefficients().values;
        let values = values.iter().map(|value| (value / 255.0) as f32);
        let expected: Vec<u8> = values.flat_map(f32::to_le_bytes).collect();
        assert!(array.ends_with(&expected), "{format}");
    }
    here.succeeds("export LRGB.ptm --normalize -o x.exr");
    let exr = std::fs::read(here.path("x.exr")).expect("an image");
    let stated = b"; values divided by 255";
    assert!(exr.windows(stated.len()).any(|part| part == stated));
}

#[test]
fn coefficients_are_read_by_openexr() {
    let here = workspace_with_formats();
    let read = "
import sys, numpy, OpenEXR
file = OpenEXR.File(sys.argv[1], separate_channels=True)
assert file.header()['type'] == OpenEXR.scanlineimage and file.header()['compression'] == OpenEXR.ZIP_COMPRESSION
for name, channel in sorted(file.channels().items()):
    print(name, channel.pixels.dtype.str, channel.pixels.shape, channel.pixels.tobytes().hex())
print(file.header()['ptm'])";
    for format in Format::ALL {
        let (file, channels) = (format!("{}.ptm", format.short_name()), format.channels());
        here.succeeds(&format!("export {file} -o x.exr"));
        let Some(text) = python(&here, &["numpy", "OpenEXR"], read, &["x.exr"]) else {
            return;
        };
        let names = match channels {
            18 => {
                "red.a0 red.a1 red.a2 red.a3 red.a4 red.a5 green.a0 green.a1 green.a2 green.a3 green.a4 green.a5 \
                   blue.a0 blue.a1 blue.a2 blue.a3 blue.a4 blue.a5"
            }
            9 => "a0 a1 a2 a3 a4 a5 R G B",
            _ => "a0 a1 a2 a3 a4 a5 Cr Cb",
        };
        let bytes = samples(&here, "coef", &file);
        let line = |(channel, name): (usize, &str)| {
            let plane = bytes.chunks(4).skip(channel).step_by(channels);
            let plane = HEXLOWER.encode(&plane.flatten().copied().collect::<Vec<u8>>());
            format!("{name} <f4 (5, 9) {plane}")
        };
        let mut expected: Vec<String> = names.split(' ').enumerate().map(line).collect();
        expected.sort();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[..channels], expected, "{format}");
        let header = format!("{format}; scale 0.5 0.25");
        assert!(lines[channels].starts_with(&header), "{text}");
    }
}

#[test]
fn exports_are_reproducible() {
    let here = workspace_with_formats();
    for format in Format::ALL {
        for name in ["x.exr", "x.npy", "x.png"] {
            let [one, two] = [1, 2].map(|_| {
                here.succeeds(&format!("export {}.ptm -o {name}", format.short_name()));
                here.read(name)
            });
            assert!(one == two, "{name}");
        }
    }
}

#[test]
fn representable_maps_are_converted_losslessly() {
    let here = workspace_with_formats();
    let mut converted = 0;
    for from in Format::ALL {
        for to in Format::ALL {
            let is_lossy = to.coding() == Some(Coding::Jpeg);
            if is_lossy || from.channels() != to.channels() {
                continue;
            }
            let (from, to) = (from.short_name(), to.short_name());
            here.succeeds(&format!("convert {from}.ptm --to {to} -o out.ptm"));
            here.succeeds(&format!("diff {from}.ptm out.ptm"));
            converted += 1;
        }
    }
    // 3 RGB sources have 2 targets each, 5 LRGB sources have 4 targets each, and LUM converts to itself.
    assert_eq!(converted, 3 * 2 + 5 * 4 + 1);
}

#[test]
fn compressed_file_that_keeps_its_format_keeps_its_streams() {
    let here = workspace_with_formats();
    let compressed = Format::ALL.into_iter().filter(|one| one.coding().is_some());
    for format in compressed.map(Format::short_name) {
        let original = here.read(&format!("{format}.ptm"));
        let dissection = Dissection::parse(&original);
        let payload = dissection
            .parts
            .iter()
            .find(|part| part.role == Role::Stream(0));
        let (header, streams) = original.split_at(payload.expect("a stream").offset);
        let header = String::from_utf8(header.to_vec()).expect("text");
        // Some readers need width and height on separate lines.
        here.write(
            &format!("{format}-line.ptm"),
            [edit(&header, "\n9\n5\n", "\n9 5\n").as_bytes(), streams].concat(),
        );
        here.succeeds(&format!(
            "convert {format}-line.ptm --to {format} -o out.ptm"
        ));
        assert!(here.read("out.ptm") == original, "{format}");
    }
    here.succeeds("convert JPEG_LRGB-line.ptm --for relight -o out.ptm");
    assert!(here.read("out.ptm") == here.read("JPEG_LRGB.ptm"));
    let line = "convert JPEG_LRGB.ptm --to JPEG_LRGB --quality 20 -o smaller.ptm";
    assert!(here.succeeds(line).contains("differ by at most"));
}

#[test]
fn conversion_loss_stays_within_the_limit() {
    let here = workspace_with_formats();
    here.succeeds("convert LRGB.ptm --to jpegls_lrgb --loss 3 -o out.ptm");
    let value = machine_output(&here, "diff LRGB.ptm out.ptm", "diff");
    let planes = value["planes"].as_array().expect("planes differ");
    let is_small = |plane: &Value| plane["largest"].as_u64() <= Some(3);
    assert!(!planes.is_empty() && planes.iter().all(is_small), "{value}");
    here.succeeds("convert LRGB.ptm --to JPEG_LRGB --quality 95 -o out.ptm");
    here.exits(1, "diff LRGB.ptm out.ptm");
}

#[test]
fn unrepresentable_conversions_write_nothing() {
    let here = workspace_with_formats();
    for [status, file, options, says] in rows(
        "
1 | RGB.ptm | --to LRGB | 45 of 45 texels do not fit, the first at column 0, row 0
1 | LRGB.ptm | --to RGB | texels do not fit
1 | LUM.ptm | --to LRGB | lum-vector
1 | LRGB.ptm | --to LUM | always loses precision
2 | LRGB.ptm | --to JPEG_LRGB | --quality
2 | LRGB.ptm | --to PTM_LUT --quality 90 | --quality is for JPEG
2 | LRGB.ptm | --to PTM_LUT --loss 3 | --loss is for JPEGLS",
    ) {
        let (found, text) = here.run(&format!("convert {file} {options} -o out.ptm"));
        assert_eq!(found.to_string(), status, "{file} {options}: {text}");
        assert!(text.contains(&says), "{text}");
        assert!(!here.path("out.ptm").exists());
    }
}

#[test]
fn gray_rgb_round_trips_through_lrgb() {
    let here = Workspace::new();
    // Calculated by hand: red and green are equal, blue is three fifths of red, and all biases are 100.
    let header = b"PTM_1.2\nPTM_FORMAT_RGB\n1\n1\n1 1 2 1 1 1\n100 100 100 100 100 100\n";
    let gray = [110, 120, 95, 100, 130, 105];
    let file = [&header[..], &gray, &gray, &[106, 112, 97, 100, 118, 103]].concat();
    here.write("a.ptm", &file);
    here.succeeds("convert a.ptm --to LRGB -o b.ptm");
    let expected = [110, 120, 95, 100, 130, 105, 255, 255, 153];
    assert!(here.read("b.ptm").ends_with(&expected));
    here.succeeds("convert b.ptm --to RGB -o c.ptm");
    here.succeeds("diff a.ptm c.ptm");
    assert!(here.read("c.ptm") == file);
}

#[test]
fn oversized_tables_are_refused_with_a_count() {
    let here = Workspace::new();
    let write = |entries: u32| {
        let header = format!("PTM_1.2\nPTM_FORMAT_LRGB\n{entries}\n1\n1 1 1 1 1 1\n0 0 0 0 0 0\n");
        let texel = |i: u32| [0, 0, 0, (i >> 16) as u8, (i >> 8) as u8, i as u8];
        let texels: Vec<u8> = (0..entries).flat_map(texel).collect();
        let colors = vec![9; 3 * entries as usize];
        here.write("a.ptm", [header.into_bytes(), texels, colors].concat());
    };
    write(65_536);
    here.succeeds("convert a.ptm --to PTM_C_LUT -o b.ptm");
    here.succeeds("diff a.ptm b.ptm");
    write(65_537);
    let text = here.exits(1, "convert a.ptm --to PTM_C_LUT -o b.ptm");
    assert!(text.contains("65537 distinct texels"), "{text}");
}

#[test]
fn differences_are_exact() {
    let here = workspace_with_corpus();
    let header = "PTM_1.2\nPTM_FORMAT_LRGB\n2\n2\n1 1 1 1 1 1\n0 0 0 0 0 0\n";
    let file: Vec<u8> = [header.as_bytes(), &(0..36).collect::<Vec<u8>>()].concat();
    let mut other = file.clone();
    // Change a3 of the second texel of the first stored row, which is the bottom row, and a bias.
    other[header.len() + 9] = 19;
    let other = String::from_utf8_lossy(&other).replace("0 0 0 0 0 0\n", "0 0 0 0 0 -7\n");
    here.write("a.ptm", &file);
    here.write("b.ptm", other);
    let value = machine_output(&here, "diff a.ptm b.ptm", "diff");
    let expected = serde_json::json!({
        "same": false,
        "header": ["bias of a5: 0 and -7"],
        "planes": [{ "plane": 3, "channel": "a3", "texels": 1, "largest": 10, "first": { "x": 1, "y": 1, "values": [9, 19] } }],
        "written": [],
    });
    assert_eq!(value, expected);
    here.exits(0, "diff a.ptm a.ptm");
    here.exits(1, "diff a.ptm b.ptm");
    here.exits(2, "diff a.ptm none.ptm");
    here.exits(2, "diff a.ptm half-payload-lrgb.ptm");
}

#[test]
fn generated_corpus_is_complete_and_reproducible() {
    let here = Workspace::new();
    for (name, profile, jobs) in [
        ("one", "minimal", 1),
        ("seven", "minimal", 7),
        ("all", "standard", 2),
    ] {
        here.succeeds(&format!(
            "generate --profile {profile} --jobs {jobs} --out {name}"
        ));
    }
    assert!(tree(&here.path("one")) == tree(&here.path("seven")));
    for corpus in ["one", "all"] {
        let yaml: Value = from_yaml(&here.text(&format!("{corpus}/MANIFEST.yaml"))).expect("YAML");
        let json = here.text(&format!("{corpus}/MANIFEST.json"));
        let json: Value = serde_json::from_str(&json).expect("JSON");
        assert_eq!(yaml, json);
        assert_conforms(&json, "profile");
        let mut listed = [
            "README.md",
            ".gitattributes",
            "MANIFEST.yaml",
            "MANIFEST.json",
        ]
        .map(str::to_owned)
        .to_vec();
        let cases = json["cases"].as_array().expect("cases");
        for case in cases {
            let answers = case["expected"].as_array().cloned().unwrap_or_default();
            for file in std::iter::once(case).chain(&answers) {
                let path = file["file"].as_str().expect("a path");
                let bytes = here.read(&format!("{corpus}/{path}"));
                assert_eq!(file["sha256"], sha256(&bytes), "{path}");
                listed.push(path.to_owned());
                listed.extend(file["slack"].as_str().map(str::to_owned));
            }
            if case["expect"] == "reject" {
                assert!(case["lint"].is_string(), "{case}");
                let is_twin = |one: &Value| one["id"] == case["twin_of"];
                assert!(cases.iter().any(is_twin), "{case}");
            }
        }
        let listed: BTreeSet<PathBuf> = listed.into_iter().map(PathBuf::from).collect();
        assert!(
            listed.iter().eq(tree(&here.path(corpus)).keys()),
            "{listed:?}"
        );
    }
    // A directory that is not empty is rejected.
    here.exits(2, "generate --profile minimal --out .");
}

#[test]
fn test_in_the_corpus_readme_passes() {
    let here = Workspace::new();
    here.succeeds("generate --profile minimal --out corpus");
    let readme = here.text("corpus/README.md");
    let snippet: String = readme
        .lines()
        .filter_map(|line| line.strip_prefix("    "))
        .map(|line| [line, "\n"].concat())
        .collect();
    assert!(snippet.contains("numpy.load"), "{snippet}");
    // Run the test of the README with the Python decoder. It prints the number of compared answers.
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
    let decoders = repository("examples/decoders");
    let packages = ["numpy", "PIL", "pillow_jpls"];
    let Some(counts) = python(&here, &packages, &code, &[&decoders, "corpus"]) else {
        return;
    };
    let counts = numbers(&counts);
    assert!(counts[0] > 100 && counts[1] > 40, "{counts:?}");
}

fn numbers(text: &str) -> Vec<usize> {
    let words = text.split_whitespace();
    words.map(|word| word.parse().expect("a number")).collect()
}

#[test]
fn corpus_images_and_exr_files_equal_its_arrays() {
    let here = Workspace::new();
    let mut suite = Suite::load().expect("the suite loads");
    // Compare a few cases of each kind, because comparing all takes too long.
    let is_wanted = |id: &str| id.starts_with("overflows-corrected");
    suite.cases.retain(|case| case.first || is_wanted(&case.id));
    let corpus = here.path("corpus");
    let written = profiles::write(&suite, &corpus, Profile::Exhaustive, 2, &|_, _| ());
    written.expect("the corpus is written");
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
            image = numpy.array(Image.open(answer['file']))
            expected = numpy.moveaxis(array, 2, 0).reshape(-1, columns) if answer['view'] == 'raw' else array
            assert abs(image - expected.astype('f8')).max() <= 0.5 + 1e-4, answer
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
    let packages = ["numpy", "PIL", "OpenEXR"];
    let Some(counts) = python(&here, &packages, code, &["corpus"]) else {
        return;
    };
    let counts = numbers(&counts);
    assert!(counts.iter().all(|&count| count > 0), "{counts:?}");
}

#[test]
fn completions_and_man_pages_name_every_command() {
    let here = Workspace::new();
    let commands = "check reference generate explain inspect lint render export convert diff";
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let text = here.succeeds(&format!("completions {shell}"));
        let mut commands = commands.split(' ');
        assert!(commands.all(|command| text.contains(command)), "{shell}");
    }
    here.succeeds("man man1");
    for command in commands.split(' ') {
        let page = here.text(&format!("man1/ptm-conform-{command}.1"));
        assert!(page.contains(".SH SYNOPSIS"), "{command}");
    }
    assert!(!here.path("man1/ptm-conform-watch.1").exists());
}

#[test]
fn bash_accepts_its_completions() {
    if !have_tool("bash") {
        return;
    }
    let here = Workspace::new();
    here.write("ptm-conform", here.succeeds("completions bash"));
    let code = "source ./ptm-conform; f=$(complete -p ptm-conform | sed 's/.*-F \\([^ ]*\\).*/\\1/'); COMP_WORDS=(ptm-conform lin); COMP_CWORD=1; $f ptm-conform lin ptm-conform; echo \"${COMPREPLY[@]}\"";
    let output = Command::new("bash")
        .current_dir(here.path(""))
        .args(["-c", code])
        .output();
    let output = output.expect("bash starts");
    assert_eq!(output.stdout, b"lint\n", "{output:?}");
}

#[test]
fn many_files_are_inspected() {
    let here = Workspace::new();
    here.copy_from_corpus("lrgb/first-lrgb.ptm");
    let sound = here.read("first-lrgb.ptm");
    here.write("files/a/one.ptm", &sound);
    here.write("files/two.PTM", &sound[..60]);
    here.write("files/photo.jpg", b"\xff\xd8");
    let output = here.command("inspect --json files first-lrgb.ptm").output();
    let output = output.expect("the program starts");
    assert_eq!(output.status.code(), Some(65));
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let records = text.lines().map(serde_json::from_str::<serde_json::Value>);
    let records: Vec<_> = records.collect::<Result<_, _>>().expect("JSON");
    let names: Vec<_> = records
        .iter()
        .map(|record| record["file"].as_str())
        .collect();
    let expected = ["files/a/one.ptm", "files/two.PTM", "first-lrgb.ptm"].map(Some);
    assert_eq!(names, expected);
    assert_eq!(records[0]["width"], records[2]["width"]);
    here.assert_lines(
        "
0 | inspect files/a | files/a/one.ptm
2 | inspect files/a none.ptm | none.ptm",
    );
}
