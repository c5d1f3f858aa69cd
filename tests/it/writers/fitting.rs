//! Tests of fitters: the optimal fit passes, and the mistakes of faulty fitters are diagnosed.

use std::fs;
use std::path::Path;

use ptm::Format;
use ptm::decode;
use ptm_writers::fitting::photographs::{FORMATS, FitRequest, ImageSet};
use ptm_writers::fitting::polynomials::Polynomials;
use ptm_writers::fitting::sets::SETS;
use ptm_writers::fitting::{judge::judge, optimum::optimum};
use ptm_writers::{reference::write_requested_file, request::WriteRequest};

use crate::common::{
    Workspace, check_writer, edit, have_python, python_example, repository, repository_text, rows,
    skip,
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
        fs::write(path, photograph.png(set.size)).expect("a file");
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
/// cause. The seventh copy chooses an arbitrary solution if there are several.
const COPIES: &str = r#"
u, v = lights[:, 0], lights[:, 1] | u, v = lights[:, 0], -lights[:, 1] | negates v
u, v = lights[:, 0], lights[:, 1] | u, v = lights[:, 1], lights[:, 0] | swaps u and v
lights = lights / np.linalg.norm(lights, axis=1, keepdims=True) | pass | does not normalize the light vectors
images[:, ::-1] | images | stores the top row first
texels = images[:, ::-1] | texels = images[:, ::-1, :, ::-1] | swaps red and blue
fit(design, texels.astype(float)) | fit(design, (texels / 255) ** 2.2 * 255) | removes the gamma of the images
np.linalg.lstsq(design, values, rcond=1e-6)[0]
  | np.linalg.lstsq(design, values, rcond=1e-6)[0] + 3000 * np.linalg.svd(design)[2][len(design):].sum(axis=0)[:, None] * np.sin(np.arange(values.shape[1]))
  | fits without a constraint
return scale, np.round(-low / scale) | return scale, np.zeros(6) | clamps coefficients
np.maximum((high - low) / 254, 1e-6) | np.full(6, 16.0) | scales that are too coarse
raw = np.round(coefficients / scale[:, None] + bias[:, None])
  | raw = np.round(coefficients / scale[:, None] + bias[:, None]); bias *= -scale; bias[:] = np.round(bias)
  | added after scaling
return scale, np.round(-low / scale) | return scale, np.round(low / scale) | clamps coefficients
raw = np.round(coefficients / scale[:, None] + bias[:, None])
  | raw = np.round(coefficients / scale[:, None] + bias[:, None]); bias *= -1 | biases with the wrong sign
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
}
