//! Tests answers that are produced offline from an exported list of requests.

use std::fs;

use serde_json::json;

use crate::common::{CheckRun, Workspace, assert_contains, rows};

/// Judges the answers in the directory `e`.
fn check(here: &Workspace) -> CheckRun {
    here.check("--outputs e")
}

/// Returns the id, file, view and output path of each request whose id begins with `beginning`.
fn requests(here: &Workspace, beginning: &str) -> Vec<[String; 4]> {
    let table = here.text("e/requests.tsv");
    let lines = table.lines().skip(1);
    let lines = lines.filter(|line| line.starts_with(beginning));
    let cells = lines.map(|line| line.split('\t').map(str::to_owned).collect::<Vec<_>>());
    cells
        .map(|cells| cells.try_into().expect("four columns"))
        .collect()
}

/// Answers requests with the reference and lists the refusals.
fn answer(here: &Workspace, beginning: &str) {
    let mut refused = Vec::new();
    for [id, file, view, output] in requests(here, beginning) {
        let mut reference = here.command(&format!("reference {view} {file}"));
        let frame = reference.current_dir(here.path("e")).output();
        let frame = frame.expect("the program starts");
        if frame.status.success() {
            here.write(&format!("e/{output}"), frame.stdout);
        } else {
            refused.push(id + "\n");
        }
    }
    here.write("e/outputs/rejected.txt", refused.concat());
}

#[test]
fn offline_outputs_are_judged_like_a_decoder() {
    for view in ["rgb", "raw", "coef"] {
        let here = Workspace::new();
        here.succeeds(&format!("generate --requests {view} --out e"));
        answer(&here, "header-");
        answer(&here, "first-lrgb");
        let [id, _, asked, _] = &requests(&here, "first-lrgb")[0];
        assert!(id == "first-lrgb" && asked.starts_with(view), "{asked}");
        let checked = check(&here);
        checked.assert_exit(0, "");
        assert_eq!(checked.case("first-lrgb")["outcome"], "pass");
        assert_eq!(checked.case("first-rgb")["outcome"], "not judged");
        assert_eq!(checked.report["decoder"]["views"], json!([view]));
    }
}

#[test]
fn offline_refusals_are_files_or_lists() {
    let here = Workspace::new();
    here.succeeds("generate --requests --out e");
    check(&here).assert_exit(2, "contains no answer to any request");

    answer(&here, "header-plain-lrgb");
    let write = |name: &str, text: &str| here.write(&format!("e/outputs/{name}"), text);
    write("version-1-3-lrgb.reject", "");
    write("unsupported.txt", "# all of them\n\n*-lum\nlum-*\r\n");
    let checked = check(&here);
    checked.assert_exit(0, "");
    assert_eq!(checked.case("version-1-3-lrgb")["outcome"], "pass");
    assert_eq!(checked.case("first-lum")["outcome"], "unsupported");
    assert_eq!(checked.case("first-rgb")["outcome"], "not judged");

    // A refused legal file, text instead of an image, and the image of a different file.
    write("rejected.txt", "first-lrgb\n");
    write("hand-final-coefficients.png", "not an image");
    let image = here.read("e/outputs/header-plain-lrgb.png");
    let other = here.write("e/outputs/lrgb-under-0-5-0", image);
    let checked = check(&here);
    checked.assert_exit(1, "");
    for id in ["first-lrgb", "lrgb-under-0-5-0"] {
        assert_eq!(checked.case(id)["outcome"], "fail", "{}", checked.text);
    }
    fs::remove_file(other).expect("a file");

    for [name, text, says] in rows(
        "
rejected.txt | first-lrgb↵no-such-case↵ | line 2: no request matches
rejected.txt | [↵ | line 1
version-1-3-lrgb.png | x | two answers for version-1-3-lrgb",
    ) {
        let before = fs::read(here.path("e/outputs").join(&name)).ok();
        let path = write(&name, &text);
        check(&here).assert_exit(2, &says);
        match before {
            Some(before) => fs::write(path, before).expect("a file"),
            None => fs::remove_file(path).expect("a file"),
        }
    }
    write("Thumbs.db", "");
    let says = "no request matches these files && Thumbs.db";
    assert_contains(&check(&here).text, says);
}

#[test]
fn request_lists_of_other_versions_are_usage_errors() {
    let here = Workspace::new();
    here.succeeds("generate --requests --out e");
    let valid = here.text("e/requests.yaml");
    let at = valid.find("sha256: ").expect("a digest") + 8;
    let other = format!("{}{}{}", &valid[..at], "0".repeat(64), &valid[at + 64..]);
    for (text, says) in [
        (&*other, "export them again"),
        ("[]", "there are no requests"),
        ("- id: x\n", "line 1"),
        ("&a [*a]", "line 1"),
    ] {
        here.write("e/requests.yaml", text);
        check(&here).assert_exit(2, &format!("requests.yaml:  && {says}"));
    }
    here.assert_lines(
        "
2 | check --outputs e decoder |
2 | check --outputs e --reject-exit 1 |
2 | check --outputs no-such-directory |
2 | generate --requests png --out e |
2 | generate --requests rgb --all |",
    );
}
