//! The example of a texture stage passes, and copies of it with one mistake each fail with the requirement they misread.

use std::fs;
use std::path::Path;

use crate::common::{Checked, check_with, have, repository, run};

const STAGE: &str = "examples/decoders/pex_texture.py";

/// A copy with one mistake.
struct Copy {
    /// The misreading that the diagnosis names.
    name: &'static str,
    find: &'static str,
    replace: &'static str,
    /// The requirement that a failing case cites, and the diagnosis with it.
    clause: &'static str,
}

const COPIES: &[Copy] = &[
    copy(
        "pre-light-by-default",
        "\"rendering_control\": \"PostLight\"",
        "\"rendering_control\": \"PreLight\"",
        "R-TBL-04",
    ),
    copy(
        "index-zero-accepted",
        "if not 1 <= index",
        "if not 0 <= index",
        "R-RST-02",
    ),
    copy(
        "undefined-entry-is-fallback-values",
        "for named in (str(index), \"1\"):",
        "for named in (str(index),):",
        "R-RST-03",
    ),
    copy(
        "back-attributes-without-distinguishing",
        "given.get(\"facet_distinguish\", False) and",
        "",
        "R-SEL-02",
    ),
    copy(
        "limit-ignored",
        "active[:given.get(\"max_texture_maps\", len(active))]",
        "active",
        "R-SEL-04",
    ),
    copy(
        "empty-list-is-untextured",
        "\"entries\": [\"default\"]",
        "\"entries\": \"untextured\"",
        "R-SEL-06",
    ),
    copy(
        "checkerboard-black-at-origin",
        "[1.0 - (i + j) % 2]",
        "[0.0 + (i + j) % 2]",
        "R-SEL-13",
    ),
    copy(
        "geometric-normal-always",
        "return own if own is not None else facet",
        "return facet if facet is not None else own",
        "R-PAR-15",
    ),
    copy(
        "data-index-ignored",
        "wanted = data[first:first + dimensions]",
        "wanted = data[:dimensions]",
        "R-PAR-21",
    ),
    copy(
        "reflection-half",
        "a - 2 * n_dot_i * b",
        "a - n_dot_i * b",
        "R-PAR-29",
    ),
    copy(
        "vrc-once-around",
        "turns(x, z) * 2 % 1",
        "turns(x, z)",
        "R-PAR-27",
    ),
    copy(
        "orientation-transposed",
        "for row in matrix)",
        "for row in list(zip(*matrix)))",
        "R-ORI-01",
    ),
    copy(
        "perspective-inverted",
        "b / w for b, w in zip(shares",
        "b * w for b, w in zip(shares",
        "R-ORI-04",
    ),
    copy(
        "dot-product-per-vertex",
        "\"DotProduct\": \"pixel\"",
        "\"DotProduct\": \"vertex\"",
        "R-CMP-22",
    ),
    copy(
        "mirror-without-the-edge",
        "        k %= 2 * n\n        return k if k < n else 2 * n - 1 - k",
        "        k %= max(1, 2 * n - 2)\n        return min(k if k < n else 2 * n - 2 - k, n - 1)",
        "R-BND-06",
    ),
    copy(
        "one-is-outside",
        "not 0 <= t[d] <= 1",
        "not 0 <= t[d] < 1",
        "R-BND-01",
    ),
    copy(
        "weights-exchanged",
        "weight *= share if corner[d] else 1 - share",
        "weight *= 1 - share if corner[d] else share",
        "R-SMP-05",
    ),
    copy(
        "level-rounded-down",
        "math.ceil(sample_depth - 0.5)",
        "math.floor(sample_depth)",
        "R-SMP-06",
    ),
    copy(
        "between-is-the-mean",
        "a + (exact - lower) * (b - a)",
        "a + (0.5 if exact > lower else 0) * (b - a)",
        "R-SMP-08",
    ),
    copy(
        "methods-exchanged",
        "if magnify else entry[\"min_sample\"]",
        "if not magnify else entry[\"min_sample\"]",
        "R-SMP-02",
    ),
    copy(
        "replace-keeps-alpha",
        "return lit, texel_alpha if has_alpha else alpha",
        "return lit, alpha",
        "R-CMP-31",
    ),
    copy(
        "modulate-keeps-alpha",
        "return [c * t for c, t in zip(color, texel)], alpha * texel_alpha",
        "return [c * t for c, t in zip(color, texel)], alpha",
        "R-CMP-33",
    ),
    copy(
        "decal-the-other-way",
        "return blend(color, lit, texel_alpha), alpha",
        "return blend(lit, color, texel_alpha if has_alpha else 0), alpha",
        "R-CMP-37",
    ),
    copy(
        "specular-lost",
        "color = [c + s for c, s in zip(color, specular)]",
        "pass",
        "R-CMP-13",
    ),
    copy(
        "ptm-top-row-first",
        "for row in reversed(rows) for color in row",
        "for row in rows for color in row",
        "R-SMP-04",
    ),
];

const fn copy(
    name: &'static str,
    find: &'static str,
    replace: &'static str,
    clause: &'static str,
) -> Copy {
    Copy {
        name,
        find,
        replace,
        clause,
    }
}

/// The example, changed, beside the decoder it needs.
fn write_copy(directory: &Path, text: &str) -> String {
    let decoder = repository("examples/decoders/ptm_decoder.py");
    fs::copy(decoder, directory.join("ptm_decoder.py")).expect("a copy");
    let path = directory.join("stage.py");
    fs::write(&path, text).expect("a copy");
    path.to_string_lossy().into_owned()
}

fn check(options: &[&str], stage: &str) -> Checked {
    let options = [&["--suite", "texture"], options].concat();
    check_with(&options, &["python3", stage])
}

#[test]
fn the_python_example_passes() {
    if !have("python3") {
        return;
    }
    let checked = check(&[], &repository(STAGE));
    assert_eq!(checked.status, 0, "{}", checked.text);
    assert_eq!(checked.report["verdict"], "pass");
    assert!(checked.cases("pass").len() > 280, "{}", checked.text);
    // A lit PTM, sampled through an entry by a program of its own.
    let passed = checked.cases("pass");
    for case in ["PTM-16", "PTM-17", "PTM-56"] {
        assert!(passed.contains(&case.to_owned()), "{case}");
    }
}

#[test]
fn each_wrong_copy_fails_with_the_requirement_it_misreads() {
    if !have("python3") {
        return;
    }
    assert!(COPIES.len() >= 20);
    let text = fs::read_to_string(repository(STAGE)).expect("the example");
    for wrong in COPIES {
        let (name, clause) = (wrong.name, wrong.clause);
        assert_eq!(
            text.matches(wrong.find).count(),
            1,
            "{name}: {}",
            wrong.find
        );
        let scratch = tempfile::tempdir().expect("a scratch directory");
        let stage = write_copy(scratch.path(), &text.replace(wrong.find, wrong.replace));
        // The cases about the misread requirement are enough to tell, and take seconds instead of minutes.
        let checked = check(&["--clause", clause], &stage);
        assert_eq!(checked.status, 1, "{name}: {}", checked.text);
        let cases = checked.report["cases"].as_array().expect("cases");
        let cites = cases.iter().any(|case| {
            let clauses = case["clauses"].as_array().expect("clauses");
            case["outcome"] == "fail" && clauses.iter().any(|one| one == clause)
        });
        assert!(cites, "{name}: {}", checked.text);
        let first = &checked.report["diagnoses"][0];
        assert_eq!(first["misreading"], name, "{}", checked.text);
        assert_eq!(first["clause"], clause, "{}", checked.text);
    }
}

#[test]
fn without_a_ptm_reader_such_maps_are_unsupported() {
    if !have("python3") {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let stage = scratch.path().join("alone.py");
    fs::copy(repository(STAGE), &stage).expect("a copy");
    let checked = check(
        &["--case", "PTM-0*", "--case", "SMP-0*"],
        &stage.to_string_lossy(),
    );
    assert_eq!(checked.status, 0, "{}", checked.text);
    assert_eq!(
        checked.report["decoder"]["unsupported"],
        serde_json::json!(["PTM maps"])
    );
}

#[test]
fn programs_that_answer_nothing_are_told_so() {
    for (program, says) in [
        (&["true"][..], "protocol error"),
        (&["false"][..], "crash"),
        (&["/nonexistent/stage"][..], "cannot be started"),
    ] {
        let checked = check_with(&["--suite", "texture"], program);
        assert_eq!(checked.status, 3, "{program:?}: {}", checked.text);
        assert!(checked.text.contains(says), "{program:?}: {}", checked.text);
    }
}

#[test]
fn the_reference_answers_and_refuses_as_the_protocol_says() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let ask = |question: &str| {
        let file = scratch.path().join("question.json");
        fs::write(&file, question).expect("a question");
        let output = run(&["reference", "texture", &file.to_string_lossy()]);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        (output.status.code(), text)
    };
    let (status, text) = ask(
        r#"{"op":"orient","given":{"matrix":[[2,0,0,0],[0,1,0,0.25],[0,0,1,0],[0,0,0,1]],"t":[0.5,0.5,0]}}"#,
    );
    assert_eq!(
        (status, text.as_str()),
        (Some(0), "{\"t\":[1.0,0.75,0.0]}\n")
    );
    assert_eq!(ask(r#"{"op":"resolve","given":{"index":0}}"#).0, Some(65));
    assert_eq!(ask(r#"{"op":"paint","given":{}}"#).0, Some(69));
}

#[test]
fn a_file_of_cases_is_held_against_the_reference() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let file = scratch.path().join("cases.yaml");
    let cases = "\
suite: pex-texture
version: 1
cases:
- {id: A-01, req: [R-BND-05], basis: text, op: index, given: {boundary: Wrap, size: 4, t: [-0.1]}, expect: {index: [3]}, why: right}
- {id: A-02, req: [R-BND-05], basis: text, op: index, given: {boundary: Wrap, size: 4, t: [-0.1]}, expect: {index: [0]}, why: wrong,
   alt: [{reading: nobody-knows, expect: {index: [1]}}]}
";
    fs::write(&file, cases).expect("a file");
    let output = run(&["texture", "cases", &file.to_string_lossy()]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1));
    assert!(text.contains("pass A-01: index: [3]"), "{text}");
    assert!(
        text.contains("FAIL A-02: index: expected [0], received [3]"),
        "{text}"
    );
    assert!(
        text.contains("2 cases: 1 answers hold, 1 do not, 1 of readings"),
        "{text}"
    );
}

#[test]
fn a_picture_is_drawn_of_a_ptm_on_a_ball() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let map = scratch.path().join("map.ptm");
    let header = b"PTM_1.2\nPTM_FORMAT_LRGB\n1 1\n1 1 1 1 1 1 0 0 0 0 0 0\n".to_vec();
    fs::write(
        &map,
        [header, vec![0, 0, 0, 0, 0, 128, 255, 128, 0]].concat(),
    )
    .expect("a file");
    let picture = scratch.path().join("ball.png");
    let draw = |entry: &str| {
        run(&[
            "texture",
            "render",
            "--shape",
            "sphere",
            "--size",
            "32",
            "--map",
            &map.to_string_lossy(),
            "--entry",
            entry,
            "-o",
            &picture.to_string_lossy(),
        ])
    };
    let drawn = draw("{parameterization: ReflectionSphereVRC, min_sample: WeightedBetweenMipmaps}");
    assert!(
        drawn.status.success(),
        "{}",
        String::from_utf8_lossy(&drawn.stderr)
    );
    let bytes = fs::read(&picture).expect("a picture");
    assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"));
    assert_eq!(bytes[16..24], [0, 0, 0, 32, 0, 0, 0, 32]);
    let wrong = draw("{composition: Paint}");
    assert_eq!(wrong.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&wrong.stderr).contains("Replace, Modulate"));
}
