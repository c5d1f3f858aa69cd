//! Programs that do not speak the protocol, called by a template.

use std::fs;
use std::path::Path;

use crate::common::{Checked, measured, program};

/// A viewer: `viewer LU LV IN OUT`, which writes a pixmap, or to standard output if OUT is `-`.
fn viewer(scratch: &Path, malformed: u8) -> String {
    let text = format!(
        "#!/bin/sh\n\
         '{}' reference \"rgb:$1,$2\" \"$3\" > frame || exit {malformed}\n\
         pixmap() {{ read -r magic view width height rest; printf 'P6 %s %s 255\\n' $width $height; cat; }}\n\
         if [ \"$4\" = - ]; then pixmap < frame; else pixmap < frame > \"$4\"; fi\n",
        env!("CARGO_BIN_EXE_ptm-conform")
    );
    script(scratch, "my viewer", &text)
}

/// An executable of that text; its path in quotation marks.
fn script(scratch: &Path, name: &str, text: &str) -> String {
    use std::os::unix::fs::PermissionsExt;
    let path = scratch.join(name);
    fs::write(&path, text).expect("a script");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("permissions");
    format!("'{}'", path.display())
}

/// `check --cmd TEMPLATE OPTIONS…` on a few small cases.
fn check(template: &str, options: &[&str]) -> Checked {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let path = scratch.path().join("report.yaml");
    let output = program()
        .args(["check", "--case", "hand-*", "--case", "version-1-3-*"])
        .args([
            "--case",
            "header-plain-*",
            "--timeout",
            "60",
            "--cmd",
            template,
        ])
        .args(options)
        .arg("--report")
        .arg(&path)
        .output()
        .expect("the program starts");
    let report = fs::read_to_string(&path)
        .ok()
        .and_then(|text| ptm_conform::kit::yaml::from_yaml(&text).ok());
    Checked {
        status: output.status.code().unwrap_or(-1),
        text: String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned(),
        report: report.unwrap_or_default(),
    }
}

#[test]
fn a_viewer_that_writes_pictures_passes() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let viewer = viewer(scratch.path(), 3);
    for template in [
        format!("{viewer} {{lu}} {{lv}} {{in}} {{out}}"),
        format!("{viewer} {{lu}} {{lv}} {{in}} {{out}}.ppm"),
        format!("{viewer} {{lu}} {{lv}} {{in}} -"),
    ] {
        let checked = check(&template, &[]);
        assert_eq!(checked.status, 0, "{template}: {}", checked.text);
        assert_eq!(
            checked.report["decoder"]["views"],
            serde_json::json!(["rgb"])
        );
        // Without a status for refusals nobody can tell them from breakdowns.
        let unjudged = checked.cases("not judged");
        assert!(
            unjudged.contains(&"version-1-3-lrgb".to_owned()),
            "{unjudged:?}"
        );
        assert!(
            checked
                .cases("pass")
                .contains(&"hand-lum-in-color".to_owned())
        );
    }
}

#[test]
fn pictures_of_every_form_are_answers_and_those_of_jpeg_are_marked() {
    let own = format!("'{}' render {{in}}", env!("CARGO_BIN_EXE_ptm-conform"));
    for suffix in ["png", "ppm", "tiff", "bmp", "webp", "jpg"] {
        let right = format!("{own} --light={{lu}},{{lv}} -o {{out}}.{suffix}");
        let checked = check(&right, &["--reject-exit", "65"]);
        assert_eq!(checked.status, 0, "{suffix}: {}", checked.text);
        let marked = checked
            .text
            .contains("responses are JPEG images, which are lossy");
        assert_eq!(marked, suffix == "jpg", "{suffix}: {}", checked.text);
        // Lit from elsewhere.
        let wrong = format!("{own} --light={{lv}},{{lu}} -o {{out}}.{suffix}");
        let checked = check(&wrong, &["--reject-exit", "65"]);
        assert_eq!(checked.status, 1, "{suffix}: {}", checked.text);
    }
}

#[test]
fn a_huge_picture_takes_no_memory() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let liar = script(
        scratch.path(),
        "liar",
        "#!/bin/sh\nprintf 'P6 30000 30000 255 x' > \"$2\"\n",
    );
    let template = format!("{liar} {{lu}},{{lv}},{{in}} {{out}}");
    let mut command = program();
    command.args(["check", "--case", "hand-*", "--cmd", &template, "--report"]);
    let report = scratch.path().join("report.yaml");
    command.arg(&report);
    let (checked, memory) = measured(command, &report);
    assert!(
        checked.text.contains("30000 x 30000 texels are more"),
        "{}",
        checked.text
    );
    println!("{memory} KiB");
    assert!(memory < 512 << 10, "{memory} KiB");
}

#[test]
fn refusals_through_a_named_status_are_weak() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let viewer = viewer(scratch.path(), 3);
    let template = format!("{viewer} {{lu}} {{lv}} {{in}} {{out}}");
    let checked = check(&template, &["--reject-exit", "3"]);
    assert_eq!(checked.status, 0, "{}", checked.text);
    assert!(
        checked.text.contains("refusals are weak"),
        "{}",
        checked.text
    );
    let cases = checked.report["cases"].as_array().expect("cases");
    let refused = cases.iter().find(|case| case["id"] == "version-1-3-lrgb");
    let refused = refused.expect("the case");
    assert_eq!(
        (&refused["outcome"], &refused["weak"]),
        (&"pass".into(), &true.into())
    );
    assert!(cases.iter().any(|case| case.get("weak").is_none()));
}

#[test]
fn refusals_through_65_are_not_weak() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let viewer = viewer(scratch.path(), 65);
    let template = format!("{viewer} {{lu}} {{lv}} {{in}} {{out}}");
    let checked = check(&template, &["--reject-exit", "3"]);
    assert_eq!(checked.status, 0, "{}", checked.text);
    assert!(!checked.text.contains("weak"), "{}", checked.text);
}

#[test]
fn a_view_may_be_a_word_of_the_command() {
    let template = format!(
        "'{}' reference {{view}} {{in}}",
        env!("CARGO_BIN_EXE_ptm-conform")
    );
    let checked = check(&template, &["--reject-exit", "65"]);
    assert_eq!(checked.status, 0, "{}", checked.text);
    assert_eq!(
        checked.report["decoder"]["views"],
        serde_json::json!(["raw", "coef", "rgb"])
    );
}

#[test]
fn outputs_that_are_no_files_are_not_followed() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    for (deed, says) in [
        ("ln -s /etc/passwd \"$2\"", "its output file is a link"),
        ("mkfifo \"$2\"", "its output file is not a regular file"),
        ("mkdir \"$2\"", "its output file is not a regular file"),
        (":", "its output file is not there"),
        (": > \"$2\"", "its output file is empty"),
        (
            "dd if=/dev/zero of=\"$2\" bs=1 count=1 seek=1000000000 2> /dev/null",
            "flood",
        ),
        (
            "w=$(pwd) && cd / && mv \"$w\" \"$w.old\" && ln -s /etc \"$w\" && : ",
            "its output file is not there",
        ),
        ("printf 'P6 1 1 255 x' > \"$2\"", "a Netpbm file: "),
    ] {
        let script = script(scratch.path(), "deed", &format!("#!/bin/sh\n{deed}\n"));
        let checked = check(&format!("{script} {{lu}},{{lv}},{{in}} {{out}}"), &[]);
        assert_eq!(checked.status, 3, "{deed}: {}", checked.text);
        assert!(checked.text.contains(says), "{deed}: {}", checked.text);
    }
}

#[test]
fn wrong_templates_are_wrong_usage() {
    for (template, options, says) in [
        ("", &[][..], "empty"),
        ("viewer", &[], "{in}"),
        ("viewer {in}", &[], "{lu} and {lv}"),
        ("viewer {lu} {in}", &[], "{lu} and {lv}"),
        (
            "viewer {in} {lu} {lv} {light}",
            &[],
            "unknown placeholder {light}",
        ),
        ("viewer {in} {lu} {lv} {out} {out}", &[], "more than once"),
        ("viewer 'x {in} {lu} {lv}", &[], "quotation"),
        ("{in} {lu} {lv}", &[], "first word is the program"),
        (
            "viewer {in} {lu} {lv}",
            &["--view", "raw", "--view", "rgb"],
            "one view only",
        ),
        ("viewer {in} {lu} {lv}", &["decoder"], "cannot be used with"),
    ] {
        let checked = check(template, options);
        assert_eq!(checked.status, 2, "{template}: {}", checked.text);
        assert!(checked.text.contains(says), "{template}: {}", checked.text);
    }
}

#[test]
fn doubled_braces_are_braces() {
    let template = "sh -c 'echo ${{HOME:+x}} {{in}} {\"a\"} >&2; exit 9' {in} {lu} {lv}";
    let checked = check(template, &[]);
    assert_eq!(checked.status, 3);
    assert!(checked.text.contains("x {in} {a}"), "{}", checked.text);
}
