//! Tests of fitters: the optimal fit passes, and the mistakes of faulty fitters are diagnosed.

use std::fs;
use std::path::Path;

use ptm::Format;
use ptm::decode;
use ptm_writers::fitting::photographs::{Encoding, FORMATS, FitRequest, ImageSet};
use ptm_writers::fitting::polynomials::Polynomials;
use ptm_writers::fitting::sets::SETS;
use ptm_writers::fitting::{judge::judge, optimum::optimum};
use ptm_writers::{reference::write_requested_file, request::WriteRequest};

use crate::common::{
    PROGRAM, Workspace, check_writer, edit, have_python, outcome, python_example, repository,
    repository_text, rows, skip,
};

/// Returns the path of the `.lp` file for twelve real photographs, stored next to HP's fit, or `None` if the file is missing.
fn real_photographs() -> Option<String> {
    let lp = repository("../shared/data/ptmfitter-8x5/reference_8x5.lp");
    (Path::new(&lp).exists() || skip("the real photographs in ../shared/data/ptmfitter-8x5"))
        .then_some(lp)
}

#[test]
fn optimum_is_as_close_as_the_images_allow() {
    for plan in SETS.iter() {
        for format in FORMATS {
            let set = plan.make(format);
            let map = optimum(&set, format);
            let file = write_requested_file(&WriteRequest::from_ptm(&map)).expect("a file");
            assert_eq!(judge(&set, format, &file), Ok(()), "{}", plan.name);
            let errors = Polynomials::new(&map).expect("RGB or LRGB").errors(&set);
            let largest = errors.into_iter().fold(0.0, f64::max);
            // Errors are caused by noise, rounding, and clamping to black and white.
            let noise = match &*plan.name {
                "saturated" => 40.0,
                _ => 9.0,
            };
            assert!(largest < noise, "{} {format}: {largest}", plan.name);
        }
    }
}

#[test]
fn no_map_with_the_same_steps_is_closer() {
    let set = SETS[1].make(Format::Rgb);
    let best = optimum(&set, Format::Rgb);
    let total = |map: &ptm::Ptm| -> f64 {
        let errors = Polynomials::new(map).expect("RGB").errors(&set);
        errors.iter().map(|error| error * error).sum()
    };
    for channel in [3, 5, 9, 17] {
        for step in [-2_i16, 2] {
            let mut other = best.clone();
            for value in other.planes.samples.iter_mut().skip(channel).step_by(18) {
                *value = (i16::from(*value) + step).clamp(0, 255) as u8;
            }
            assert!(
                total(&other) > total(&best),
                "channel {channel}, step {step}"
            );
        }
    }
}

#[test]
fn image_sets_round_trip_through_files() {
    let set = SETS[7].make(Format::Lrgb);
    let folder = tempfile::tempdir().expect("a directory");
    for photograph in &set.photographs {
        let path = folder.path().join(&photograph.name);
        fs::write(path, photograph.file(set.size, Encoding::Png)).expect("a file");
    }
    let lp = folder.path().join("lights.lp");
    fs::write(&lp, set.lp()).expect("a file");
    assert_eq!(ImageSet::read(&lp), Ok(set));
    fs::write(&lp, "2\nlight-00.png 0 0 1\n").expect("a file");
    let error = ImageSet::read(&lp).expect_err("a missing image");
    assert!(
        error.ends_with("expected 2 images according to the first line, found 1"),
        "{error}"
    );
}

#[test]
fn requests_conform_to_their_schema_and_round_trip() {
    let schema = include_str!("../../../spec-cases/schema/fit-request.schema.json");
    let schema: serde_json::Value = serde_json::from_str(schema).expect("JSON");
    let validator = jsonschema::validator_for(&schema).expect("a schema");
    for format in FORMATS {
        let size = SETS[0].make(format).size;
        let request = FitRequest {
            format: format.name().to_owned(),
            width: size.width,
            height: size.height,
            lp: "lights.lp".to_owned(),
        };
        let mut json = serde_json::to_value(&request).expect("JSON");
        assert!(validator.is_valid(&json), "{json}");
        assert_eq!(
            FitRequest::read(json.to_string().as_bytes()),
            Ok((format, request))
        );
        json["scale"] = 1.into();
        assert!(!validator.is_valid(&json), "{json}");
        assert!(FitRequest::read(json.to_string().as_bytes()).is_err());
    }
}

#[test]
fn hp_fit_is_close_to_the_optimum() {
    let Some(lp) = real_photographs() else { return };
    let set = ImageSet::read(Path::new(&lp)).expect("the set");
    let file = fs::read(Path::new(&lp).with_extension("ptm")).expect("the map");
    assert_eq!(judge(&set, Format::Lrgb, &file), Ok(()));
    let mean = |map: &ptm::Ptm| {
        let errors = Polynomials::new(map).expect("LRGB").errors(&set);
        errors.iter().sum::<f64>() / errors.len() as f64
    };
    let hp = mean(&decode(&file).expect("a map"));
    let best = mean(&optimum(&set, Format::Lrgb));
    println!("HP {hp:.3}, optimum {best:.3}");
    assert!(best <= hp, "{best} {hp}");
}

#[test]
fn reference_and_python_fitter_pass() {
    let checked = check_writer("--fitter");
    checked.assert_exit(0, "");
    assert_eq!(checked.report["suite"], "fitters");
    if have_python(&["numpy"]) {
        let lp = real_photographs()
            .map(|lp| format!("--lp {lp}"))
            .unwrap_or_default();
        let fitter = python_example("writers/ptm_fitter.py");
        check_writer(&format!("--fitter {lp} -- {fitter}")).assert_exit(0, "");
    }
}

/// Copies of the Python fitter, each with one mistake: the text to replace, the replacement, and a part of the first
/// cause. The eighth copy chooses an arbitrary solution if there are several.
const COPIES: &str = r#"
u, v = lights[:, 0], lights[:, 1] | u, v = lights[:, 0], -lights[:, 1] | negates v
rcond=tolerance | rcond=1e-7 | although the lights do not determine all coefficients
u, v = lights[:, 0], lights[:, 1] | u, v = lights[:, 1], lights[:, 0] | swaps u and v
lights = lights / np.linalg.norm(lights, axis=1, keepdims=True) | pass | does not normalize the light vectors
images[:, ::-1] | images | stores the top row first
texels = images[:, ::-1] | texels = images[:, ::-1, :, ::-1] | swaps red and blue
fit(design, texels.astype(float), | fit(design, (texels / 255) ** 2.2 * 255, | removes the gamma of the images
np.linalg.lstsq(design, values, rcond=tolerance)[0]
  | np.linalg.lstsq(design, values, rcond=tolerance)[0] + 3000 * np.linalg.svd(design)[2][len(design):].sum(axis=0)[:, None] * np.sin(np.arange(values.shape[1]))
  | fits without a constraint
bias = np.round(-low / np.maximum(scale, 1e-9)) | bias = np.zeros(6) | clamps coefficients
scale = np.where(zero, 1, np.where(constant, np.abs(middle) / 255, scale))
  | scale, middle = np.where(constant, 1, scale), low * 0 + 1 | clamps coefficients
np.maximum((high - low) / 254, np.abs(low) / 1e4) | np.full(6, 16.0) | scales that are too coarse
raw = np.round(coefficients / scale[:, None] + bias[:, None])
  | raw = np.round(coefficients / scale[:, None] + bias[:, None]); bias *= -scale; bias[:] = np.round(bias)
  | added after scaling
bias = np.round(-low / np.maximum(scale, 1e-9)) | bias = np.round(low / np.maximum(scale, 1e-9)) | clamps coefficients
raw = np.round(coefficients / scale[:, None] + bias[:, None])
  | raw = np.round(coefficients / scale[:, None] + bias[:, None]); bias *= -1 | biases with the wrong sign
u, v = lights[:, 0], lights[:, 1] | u, v = -lights[:, 0], -lights[:, 1] | negates u and v
texels = images[:, ::-1] | texels = images[:, ::-1, ::-1] | mirrors the images
return lights, tolerance, images | return np.roll(lights, -1, axis=0), tolerance, images | the light of the next one
payload = stored(luminance, scale, bias) + color.astype(np.uint8).tobytes()
  | payload = b"".join(a + bytes(b) for a, b in zip(np.frombuffer(stored(luminance, scale, bias), "V6").tolist(), color.astype(np.uint8).tolist()))
  | writes all values of a texel together
np.stack([u * u, v * v, u * v, u, v, np.ones_like(u)], axis=1)
  | np.stack([np.ones_like(u), u, v, u * v, u * u, v * v], axis=1) | in the order 1, u, v
" ".join(line[:-3]))) for line in lines] | name)) for name in sorted(" ".join(line[:-3]) for line in lines)]
  | sorts the images by name
"#;

#[test]
fn faulty_fitters_fail_with_the_cause() {
    if !have_python(&["numpy"]) {
        return;
    }
    let source = repository_text("examples/writers/ptm_fitter.py");
    for [find, replace, words] in rows(COPIES) {
        let here = Workspace::new();
        here.write("fitter.py", edit(&source, &find, &replace));
        let checked = here.check_writer("--fitter --ptm-format LRGB -- python3 fitter.py");
        checked.assert_exit(1, "");
        let mut parts = checked.text.split("\n\n");
        let first = parts.find(|part| part.contains("failures: the fitter"));
        let is_named = first.is_some_and(|first| first.contains(&words));
        assert!(is_named, "{replace}: {words}\n{}", checked.text);
    }
    // This mistake resembles a gamma in one set of dark images.
    let here = Workspace::new();
    let mean = "luminance, color = split_color(design, coefficients); luminance = coefficients.mean(axis=2); color = np.clip(np.round(texels.reshape(len(images), -1, 3).mean(axis=0)), 0, 255)";
    let split = "luminance, color = split_color(design, coefficients)";
    here.write("fitter.py", edit(&source, split, mean));
    let checked = here.check_writer("--fitter --ptm-format LRGB -- python3 fitter.py");
    checked.assert_exit(1, "");
    assert!(
        checked
            .text
            .contains("colors that still contain the luminance"),
        "{}",
        checked.text
    );
    assert!(!checked.text.contains("gamma"), "{}", checked.text);
}

#[test]
fn image_sets_round_trip_in_every_encoding() {
    for name in Encoding::NAMES {
        let encoding = Encoding::from_name(name).expect("an encoding");
        let plain = SETS[0].make(Format::Rgb);
        let sent = plain.clone().encoded_as(encoding);
        let folder = tempfile::tempdir().expect("a directory");
        for photograph in &sent.photographs {
            let path = folder.path().join(&photograph.name);
            fs::write(path, photograph.file(sent.size, encoding)).expect("a file");
        }
        let lp = folder.path().join("lights.lp");
        fs::write(&lp, sent.lp()).expect("a file");
        let read = ImageSet::read(&lp).expect("the set");
        for ((read, sent), plain) in read
            .photographs
            .iter()
            .zip(&sent.photographs)
            .zip(&plain.photographs)
        {
            assert_eq!(read.pixels, sent.pixels, "{name}");
            let errors = plain.pixels.iter().zip(&sent.pixels);
            let largest = errors.map(|(a, b)| a.abs_diff(*b)).max();
            let limit = if encoding == Encoding::Jpeg { 24 } else { 0 };
            assert!(largest <= Some(limit), "{name}: {largest:?}");
        }
        check_writer(&format!(
            "--fitter --images {name} --case fit-lrgb-ordinary --case fit-rgb-noise"
        ))
        .assert_exit(0, "");
    }
    check_writer("--fitter --images gif").assert_exit(2, "jpeg");
    check_writer("--images ppm").assert_exit(2, "--fitter");
}

#[test]
fn names_in_an_image_set_are_distinct_and_have_no_directory() {
    let mut set = SETS[0].make(Format::Rgb);
    for (photograph, name) in
        set.photographs
            .iter_mut()
            .zip(["a/x.jpg", "b/x.jpg", "C:\\dome\\x.tif", "x", "été.png"])
    {
        photograph.name = name.to_owned();
    }
    let sent = set.encoded_as(Encoding::Ppm);
    let names: Vec<&str> = sent.photographs.iter().map(|p| &*p.name).collect();
    let expected = [
        "x.ppm",
        "1-x.jpg.ppm",
        "2-x.tif.ppm",
        "3-x.ppm",
        "été.ppm",
        "light-05.ppm",
    ];
    assert_eq!(names[..6], expected);
}

/// The `.lp` file of one photograph with a name that is not ASCII, in several encodings.
#[test]
fn lp_files_may_have_any_encoding() {
    use std::os::unix::ffi::OsStrExt;
    let here = Workspace::new();
    let photograph = &SETS[0].make(Format::Rgb).photographs[0];
    let png = photograph.file(SETS[0].make(Format::Rgb).size, Encoding::Png);
    here.write("lumière 1.png", &png);
    let latin1_name = std::ffi::OsStr::from_bytes(b"lumi\xe8re 2.png");
    fs::write(here.path("").join(latin1_name), &png).expect("a file");
    let text = "2\r\nlumière 1.png 0 0 1\r\nlumière 2.png 0.6 0 0.8\r\n";
    let utf16 = |order: fn(u16) -> [u8; 2], mark: &str| {
        let units = format!("{mark}{text}");
        units.encode_utf16().flat_map(order).collect::<Vec<u8>>()
    };
    let latin1: Vec<u8> = text
        .chars()
        .map(|c| u8::try_from(c).expect("Latin-1"))
        .collect();
    for (name, bytes) in [
        ("UTF-8", text.as_bytes().to_vec()),
        ("UTF-8 with a mark", format!("\u{feff}{text}").into_bytes()),
        ("UTF-16LE", utf16(u16::to_le_bytes, "\u{feff}")),
        ("UTF-16BE", utf16(u16::to_be_bytes, "\u{feff}")),
        ("UTF-16LE without a mark", utf16(u16::to_le_bytes, "")),
        ("UTF-16BE without a mark", utf16(u16::to_be_bytes, "")),
        ("Latin-1", latin1),
        ("CR", text.replace("\r\n", "\r").into_bytes()),
    ] {
        here.write("lights.lp", &bytes);
        let set = ImageSet::read(&here.path("lights.lp"));
        let set = set.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(set.photographs[1].name, "lumière 2.png", "{name}");
        assert_eq!(set.photographs[1].light, [0.6, 0.0, 0.8], "{name}");
    }
    here.check_writer("--fitter --lp lights.lp --case 'fit-*-own'")
        .assert_exit(0, "");
    here.write("lights.lp", "1\nC:\\dome\\lumière 1.png 0 0 1\n");
    assert!(ImageSet::read(&here.path("lights.lp")).is_ok());
}

#[test]
fn constant_coefficients_have_small_biases() {
    let plan = SETS.iter().find(|plan| plan.name == "constant");
    for format in FORMATS {
        let set = plan.expect("the set").make(format);
        let map = optimum(&set, format);
        let scale_bias = &map.header.scale_bias;
        assert!(scale_bias.scale.iter().all(|&scale| scale > 1e-3));
        if format == Format::Lrgb {
            let is_end = |&bias: &f64| bias == 0.0 || bias == 255.0;
            assert!(scale_bias.bias.iter().all(is_end), "{scale_bias:?}");
        }
    }
}

/// Runs the documented command for HP's fitter with a stand-in that has the same command line, reads names without spaces only,
/// and exits with 1 on success.
#[test]
fn documented_fitter_command_works() {
    let page = repository_text("docs/writers.md");
    let line = page.lines().find(|line| line.contains("PTMfitter -i"));
    let line = line.expect("the command").trim();
    let line = line.strip_prefix("ptm-conform ").expect("a command");
    let here = Workspace::new();
    let script = format!(
        r#"#!/bin/sh
test "$1 $3" = "-i -o" || exit 2
grep -q '[^ ]* [^ ]* [^ ]* [^ ]* ' "$2" && exit 2
grep -q '^light-00.jpg ' "$2" || exit 2
printf '{{"format": "PTM_FORMAT_LRGB", "width": 1, "height": 1, "lp": "%s"}}' "$2" > request.json
'{PROGRAM}' reference fit request.json "$4" && exit 1
exit 2
"#
    );
    here.write_program("PTMfitter", &script);
    let path = std::env::var("PATH").expect("a path");
    let path = format!("{}:{path}", here.path("").display());
    let run = |line: &str| {
        let output = here.command(line).env("PATH", &path).output();
        outcome(&output.expect("the program starts"))
    };
    let (status, text) = run(line);
    assert_eq!(status, 0, "{text}");
    let (status, text) = run(&line.replace("--ok-exit 1", ""));
    assert_eq!(status, 3, "{text}");
    assert!(
        text.contains("--ok-exit") && text.contains("{lp}"),
        "{text}"
    );
    assert!(!text.contains("request.json out.ptm"), "{text}");
    let (status, text) = run(&line.replace("-o {out}.ptm", "-o {out}.ptm {scale}"));
    assert_eq!(status, 2, "{text}");
    assert!(
        text.contains("{in}, {out}, {lp}, {format}, {width}, {height}"),
        "{text}"
    );
}

#[test]
fn fitters_may_refuse_lights_that_determine_too_little() {
    let here = Workspace::new();
    let script = |condition: &str, status: i32| {
        format!(
            "lp=$(sed -n 's/.*\"lp\": \"\\(.*\\)\".*/\\1/p' \"$2\")\n{condition} && exit {status}\nexec '{PROGRAM}' reference fit \"$2\" \"$3\"\n"
        )
    };
    let few = "test $(head -n 1 \"$lp\") = 5";
    for status in [65, 69] {
        here.write("fitter.sh", script(few, status));
        let checked = here.check_writer("--fitter -- sh fitter.sh");
        checked.assert_exit(
            0,
            "note: the program refuses fit-lrgb-few-lights, fit-rgb-few-lights, which is allowed: the lights do not determine",
        );
        assert_eq!(checked.case("fit-rgb-few-lights")["expect"], "lenient");
    }
    here.write("fitter.sh", script("test $(head -n 1 \"$lp\") = 14", 65));
    here.check_writer("--fitter -- sh fitter.sh")
        .assert_exit(1, "fit-lrgb-one-side");
}

#[test]
fn warnings_of_lint_are_notes() {
    let here = Workspace::new();
    here.write(
        "writer.sh",
        format!("'{PROGRAM}' reference \"$@\" && echo >> \"$3\"\n"),
    );
    let note = "bytes follow the last value (PTM-W110)";
    here.check_writer("--smoke --ptm-format LRGB -- sh writer.sh")
        .assert_exit(0, note);
    let fitted = here.check_writer("--fitter --case fit-lrgb-noise -- sh writer.sh");
    fitted.assert_exit(
        0,
        "note: lint warns about 3 files, for example fit-lrgb-noise: ",
    );
    fitted.assert_exit(0, note);
    // The request has such a bias, so the warning is unavoidable.
    let wide = check_writer("--case lrgb-bias-past-16-bits");
    wide.assert_exit(0, "1 pass");
    assert!(!wide.text.contains("PTM-W108"), "{}", wide.text);
}
