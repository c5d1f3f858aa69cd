//! Answers made elsewhere, from an exported list of requests.

use std::fs;
use std::path::Path;

use crate::common::program;

fn run(directory: &Path, args: &[&str]) -> (i32, String) {
    let output = program()
        .current_dir(directory)
        .args(args)
        .output()
        .expect("the program starts");
    let text = [output.stdout, output.stderr].concat();
    (
        output.status.code().unwrap_or(-1),
        String::from_utf8_lossy(&text).into_owned(),
    )
}

/// `check --outputs e`, its report as a value.
fn check(directory: &Path) -> (i32, String, serde_json::Value) {
    let (status, text) = run(
        directory,
        &["check", "--outputs", "e", "--report", "r.yaml"],
    );
    let report = fs::read_to_string(directory.join("r.yaml"))
        .ok()
        .and_then(|text| ptm_conform::kit::yaml::from_yaml(&text).ok());
    (status, text, report.unwrap_or_default())
}

fn outcome(report: &serde_json::Value, id: &str) -> String {
    let cases = report["cases"].as_array().expect("cases");
    let case = cases
        .iter()
        .find(|case| case["id"] == id)
        .expect("the case");
    case["outcome"].as_str().unwrap_or_default().to_owned()
}

/// The requests whose id begins so: id, file, view, output.
fn requests(directory: &Path, beginning: &str) -> Vec<[String; 4]> {
    let table = fs::read_to_string(directory.join("e/requests.tsv")).expect("the list");
    let lines = table
        .lines()
        .skip(1)
        .filter(|line| line.starts_with(beginning));
    lines
        .map(|line| {
            let words: Vec<String> = line.split('\t').map(str::to_owned).collect();
            words.try_into().expect("four columns")
        })
        .collect()
}

/// Answers the requests whose id begins so, by the reference; what it refuses is listed.
#[expect(
    clippy::format_push_string,
    reason = "texts are short where they are put together"
)]
fn answer(directory: &Path, beginning: &str) {
    let mut refused = String::new();
    for [id, file, view, output] in requests(directory, beginning) {
        let said = program()
            .current_dir(directory.join("e"))
            .args(["reference", &view, &file])
            .output()
            .expect("the program starts");
        if said.status.success() {
            fs::write(directory.join("e").join(output), said.stdout).expect("an output");
        } else {
            refused += &format!("{id}\n");
        }
    }
    fs::write(directory.join("e/outputs/rejected.txt"), refused).expect("a list");
}

#[test]
fn answers_made_elsewhere_are_judged_as_those_of_a_decoder() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let here = scratch.path();
    for view in ["rgb", "raw", "coef"] {
        let _ = fs::remove_dir_all(here.join("e"));
        let (status, text) = run(here, &["generate", "--requests", view, "--out", "e"]);
        assert_eq!(status, 0, "{text}");
        answer(here, "header-");
        answer(here, "first-lrgb");
        let [id, _, asked, _] = &requests(here, "first-lrgb")[0];
        assert!(id == "first-lrgb" && asked.starts_with(view), "{asked}");
        let (status, text, report) = check(here);
        assert_eq!(status, 0, "{text}");
        assert_eq!(outcome(&report, "first-lrgb"), "pass");
        assert_eq!(outcome(&report, "first-rgb"), "not judged");
        assert_eq!(report["decoder"]["views"], serde_json::json!([view]));
    }
}

#[test]
fn refusals_are_files_or_lists() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let here = scratch.path();
    assert_eq!(run(here, &["generate", "--requests", "--out", "e"]).0, 0);
    let outputs = here.join("e/outputs");
    let (status, text, _) = check(here);
    assert!(
        status == 2 && text.contains("no answer to any request"),
        "{text}"
    );

    answer(here, "header-plain-lrgb");
    let put = |name: &str, text: &str| fs::write(outputs.join(name), text).expect("a file");
    put("version-1-3-lrgb.reject", "");
    put("unsupported.txt", "# all of them\n\n*-lum\nlum-*\r\n");
    let (status, text, report) = check(here);
    assert_eq!(status, 0, "{text}");
    assert_eq!(outcome(&report, "version-1-3-lrgb"), "pass");
    assert_eq!(outcome(&report, "first-lum"), "unsupported");
    assert_eq!(outcome(&report, "first-rgb"), "not judged");

    // A legal file that was refused, a picture that is none, and one of another file.
    put("rejected.txt", "first-lrgb\n");
    put("hand-final-coefficients.png", "no picture");
    let picture = fs::read(outputs.join("header-plain-lrgb.png")).expect("an answer");
    fs::write(outputs.join("lrgb-under-0-5-0"), picture).expect("an answer");
    let (status, text, report) = check(here);
    assert_eq!(status, 1, "{text}");
    for id in ["first-lrgb", "lrgb-under-0-5-0"] {
        assert_eq!(outcome(&report, id), "fail", "{text}");
    }
    fs::remove_file(outputs.join("lrgb-under-0-5-0")).expect("a file");

    for (name, text, says) in [
        (
            "rejected.txt",
            "first-lrgb\nno-such-case\n",
            "line 2: no request matches",
        ),
        ("rejected.txt", "[\n", "line 1"),
        (
            "version-1-3-lrgb.png",
            "x",
            "two answers for version-1-3-lrgb",
        ),
    ] {
        let before = fs::read(outputs.join(name)).ok();
        put(name, text);
        let (status, told, _) = check(here);
        assert!(status == 2 && told.contains(says), "{says}: {told}");
        match before {
            Some(before) => fs::write(outputs.join(name), before).expect("a file"),
            None => fs::remove_file(outputs.join(name)).expect("a file"),
        }
    }
    put("Thumbs.db", "");
    let (_, told, _) = check(here);
    let says = "files in the outputs belong to no request: ";
    assert!(told.contains(says) && told.contains("Thumbs.db"), "{told}");
}

#[test]
fn lists_of_another_version_are_told() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let here = scratch.path();
    assert_eq!(run(here, &["generate", "--requests", "--out", "e"]).0, 0);
    let list = here.join("e/requests.yaml");
    let sound = fs::read_to_string(&list).expect("the list");
    let at = sound.find("sha256: ").expect("a digest") + 8;
    let other = format!("{}{}{}", &sound[..at], "0".repeat(64), &sound[at + 64..]);
    for (text, says) in [
        (&*other, "export them anew"),
        ("[]", "there are no requests"),
        ("- id: x\n", "line 1"),
        ("&a [*a]", "line 1"),
    ] {
        fs::write(&list, text).expect("a list");
        let (status, told, _) = check(here);
        assert!(
            status == 2 && told.contains("requests.yaml: ") && told.contains(says),
            "{says}: {told}"
        );
    }
    for args in [
        &["check", "--outputs", "e", "decoder"][..],
        &["check", "--outputs", "e", "--reject-exit", "1"],
        &["check", "--outputs", "no-such-directory"],
        &["generate", "--requests", "png", "--out", "e"],
        &["generate", "--requests", "rgb", "--all"],
    ] {
        assert_eq!(run(here, args).0, 2, "{args:?}");
    }
}
