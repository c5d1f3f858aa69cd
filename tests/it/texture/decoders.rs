//! Tests that the example texture stage passes, and that each copy with one mistake fails a case about the misread requirement.

use crate::common::{Workspace, check, edit, have_tool, python_example, repository_text, rows};

/// Returns the source text of the texture stage in Python, if Python is installed.
fn stage() -> Option<String> {
    have_tool("python3").then(|| repository_text("examples/decoders/pex_texture.py"))
}

/// Copies of the texture stage, each with one mistake: the misreading that the diagnosis names, the text to
/// replace, the replacement, and the requirement that both a failing case and the diagnosis cite.
const COPIES: &str = r#"
pre-light-by-default | "rendering_control": "PostLight" | "rendering_control": "PreLight" | R-TBL-04
index-zero-accepted | if not 1 <= index | if not 0 <= index | R-RST-02
undefined-entry-is-fallback-values | for named in (str(index), "1"): | for named in (str(index),): | R-RST-03
back-attributes-without-distinguishing | given.get("facet_distinguish", False) and |  | R-SEL-02
limit-ignored | active[:given.get("max_texture_maps", len(active))] | active | R-SEL-04
empty-list-is-untextured | "entries": ["default"] | "entries": "untextured" | R-SEL-06
checkerboard-black-at-origin | [1.0 - (i + j) % 2] | [0.0 + (i + j) % 2] | R-SEL-13
geometric-normal-always | return own if own is not None else facet | return facet if facet is not None else own
  | R-PAR-15
data-index-ignored | wanted = data[first:first + dimensions] | wanted = data[:dimensions] | R-PAR-21
reflection-half | a - 2 * n_dot_i * b | a - n_dot_i * b | R-PAR-29
vrc-once-around | turns(x, z) * 2 % 1 | turns(x, z) | R-PAR-27
orientation-transposed | for row in matrix) | for row in list(zip(*matrix))) | R-ORI-01
perspective-inverted | b / w for b, w in zip(shares | b * w for b, w in zip(shares | R-ORI-04
dot-product-per-vertex | "DotProduct": "pixel" | "DotProduct": "vertex" | R-CMP-22
mirror-without-the-edge | k %= 2 * n↵        return k if k < n else 2 * n - 1 - k
  | k %= max(1, 2 * n - 2)↵        return min(k if k < n else 2 * n - 2 - k, n - 1) | R-BND-06
one-is-outside | not 0 <= t[d] <= 1 | not 0 <= t[d] < 1 | R-BND-01
weights-exchanged | weight *= share if corner[d] else 1 - share | weight *= 1 - share if corner[d] else share
  | R-SMP-05
texels-of-8-bits | return level["texels"][number] | return [round(c * 255) / 255 for c in level["texels"][number]]
  | R-SMP-04
level-rounded-down | math.ceil(sample_depth - 0.5) | math.floor(sample_depth) | R-SMP-06
between-is-the-mean | a + (exact - lower) * (b - a) | a + (0.5 if exact > lower else 0) * (b - a) | R-SMP-08
methods-exchanged | if magnify else entry["min_sample"] | if not magnify else entry["min_sample"] | R-SMP-02
replace-keeps-alpha | return lit, texel_alpha if has_alpha else alpha | return lit, alpha | R-CMP-31
modulate-keeps-alpha | return [c * t for c, t in zip(color, texel)], alpha * texel_alpha
  | return [c * t for c, t in zip(color, texel)], alpha | R-CMP-33
decal-the-other-way | return blend(color, lit, texel_alpha), alpha
  | return blend(lit, color, texel_alpha if has_alpha else 0), alpha | R-CMP-37
specular-lost | color = [c + s for c, s in zip(color, specular)] | pass | R-CMP-13
ptm-top-row-first | for row in reversed(rows) for color in row | for row in rows for color in row | R-SMP-04
"#;

#[test]
fn python_example_passes() {
    if !have_tool("python3") {
        return;
    }
    let stage = python_example("decoders/pex_texture.py");
    let checked = check(&format!("--suite texture -- {stage}"));
    checked.assert_exit(0, "");
    assert_eq!(checked.report["verdict"], "pass");
    assert!(checked.cases("pass").len() > 280, "{}", checked.text);
    // A PTM under a light, sampled through a table entry.
    for case in ["PTM-16", "PTM-17", "PTM-56"] {
        assert_eq!(checked.case(case)["outcome"], "pass", "{case}");
    }
}

#[test]
fn each_wrong_copy_fails_for_its_requirement() {
    let Some(text) = stage() else { return };
    let here = Workspace::new();
    let decoder = repository_text("examples/decoders/ptm_decoder.py");
    here.write("ptm_decoder.py", decoder);
    let copies = rows(COPIES);
    assert!(copies.len() >= 20);
    for [name, find, replace, clause] in copies {
        here.write("stage.py", edit(&text, &find, &replace));
        // Run only the cases about the misread requirement, which takes seconds instead of minutes.
        let line = format!("--suite texture --clause {clause} -- python3 stage.py");
        let checked = here.check(&line);
        checked.assert_exit(1, "");
        let mut cases = checked.report["cases"].as_array().expect("cases").iter();
        let cites = cases.any(|case| {
            let clauses = case["clauses"].as_array().expect("clauses");
            case["outcome"] == "fail" && clauses.iter().any(|one| *one == clause)
        });
        assert!(cites, "{name}: {}", checked.text);
        let first = &checked.report["diagnoses"][0];
        assert_eq!(first["misreading"], name, "{}", checked.text);
        assert_eq!(first["clause"], clause, "{}", checked.text);
    }
}

#[test]
fn maps_are_unsupported_without_a_ptm_reader() {
    let Some(text) = stage() else { return };
    let here = Workspace::new();
    here.write("alone.py", text);
    let options = "--suite texture --case PTM-0* --case SMP-0*";
    let checked = here.check(&format!("{options} -- python3 alone.py"));
    checked.assert_exit(0, "");
    let unsupported = serde_json::json!(["PTM maps"]);
    assert_eq!(checked.report["decoder"]["unsupported"], unsupported);
}

#[test]
fn silent_programs_are_rejected_with_a_reason() {
    check("--suite texture -- true").assert_exit(3, "protocol error");
    check("--suite texture -- false").assert_exit(3, "crash");
    check("--suite texture -- /nonexistent/stage").assert_exit(3, "cannot be started");
}

#[test]
fn reference_follows_the_texture_protocol() {
    let here = Workspace::new();
    for [status, question, answer] in rows(
        r#"
0 | {"op":"orient","given":{"matrix":[[2,0,0,0],[0,1,0,0.25],[0,0,1,0],[0,0,0,1]],"t":[0.5,0.5,0]}}
  | {"t":[1.0,0.75,0.0]}↵
65 | {"op":"resolve","given":{"index":0}} |
69 | {"op":"paint","given":{}} |"#,
    ) {
        here.write("question.json", &question);
        let (found, text) = here.run("reference texture question.json");
        assert_eq!(found.to_string(), status, "{question}");
        assert!(text == answer || answer.is_empty(), "{text}");
    }
}

#[test]
fn case_file_is_checked_against_the_reference() {
    let here = Workspace::new();
    let cases = "\
suite: pex-texture
version: 1
cases:
- {id: A-01, req: [R-BND-05], basis: text, op: index, given: {boundary: Wrap, size: 4, t: [-0.1]}, expect: {index: [3]}, why: right}
- {id: A-02, req: [R-BND-05], basis: text, op: index, given: {boundary: Wrap, size: 4, t: [-0.1]}, expect: {index: [0]}, why: wrong,
   alt: [{reading: nobody-knows, expect: {index: [1]}}]}
";
    here.write("cases.yaml", cases);
    let text = here.exits(1, "texture cases cases.yaml");
    for says in [
        "pass A-01: index: [3]",
        "FAIL A-02: index: expected [0], received [3]",
        "2 cases: 1 correct, 1 wrong, 1 under unknown readings",
    ] {
        assert!(text.contains(says), "{text}");
    }
}

#[test]
fn ptm_on_a_sphere_is_rendered() {
    let here = Workspace::new();
    let header = b"PTM_1.2\nPTM_FORMAT_LRGB\n1 1\n1 1 1 1 1 1 0 0 0 0 0 0\n";
    let texel = [0, 0, 0, 0, 0, 128, 255, 128, 0];
    here.write("map.ptm", [&header[..], &texel].concat());
    let render = "texture render --shape sphere --size 32 --map map.ptm -o ball.png --entry";
    let entry = "parameterization: ReflectionSphereVRC, min_sample: WeightedBetweenMipmaps";
    here.succeeds(&format!("{render} '{{{entry}}}'"));
    let image = here.read("ball.png");
    assert!(image.starts_with(b"\x89PNG\r\n\x1a\n"));
    assert_eq!(image[16..24], [0, 0, 0, 32, 0, 0, 0, 32]);
    let text = here.exits(2, &format!("{render} '{{composition: Paint}}'"));
    assert!(text.contains("Replace, Modulate"), "{text}");
}
