//! Tests programs that do not implement the protocol and are called through a command-line template.

use crate::common::{CheckRun, PROGRAM, Workspace, assert_contains, rows, run_measured};

/// Creates a workspace with the program `viewer LU LV IN OUT`, which writes a pixmap to OUT, or to standard output if OUT is
/// `-`. For a file that it cannot read, it exits with the status `malformed`.
fn workspace_with_viewer(malformed: u8) -> Workspace {
    let here = Workspace::new();
    let text = format!(
        "#!/bin/sh\n\
         '{PROGRAM}' reference \"rgb:$1,$2\" \"$3\" > frame || exit {malformed}\n\
         pixmap() {{ read -r magic view width height rest; printf 'P6 %s %s 255\\n' $width $height; cat; }}\n\
         if [ \"$4\" = - ]; then pixmap < frame; else pixmap < frame > \"$4\"; fi\n"
    );
    here.write_program("viewer", text);
    here
}

/// Runs `check OPTIONS --cmd TEMPLATE` on a few small cases.
fn check(here: &Workspace, template: &str, options: &str) -> CheckRun {
    let cases = "--case hand-* --case version-1-3-* --case header-plain-* --timeout 60";
    let template = template.replace('\'', "'\\''");
    here.check(&format!("{cases} {options} --cmd '{template}'"))
}

#[test]
fn viewer_that_writes_images_passes() {
    let here = workspace_with_viewer(3);
    for output in ["{out}", "{out}.ppm", "-"] {
        let checked = check(
            &here,
            &format!("./viewer {{lu}} {{lv}} {{in}} {output}"),
            "",
        );
        checked.assert_exit(0, "");
        let views = &checked.report["decoder"]["views"];
        assert_eq!(*views, serde_json::json!(["rgb"]));
        // Without `--reject-exit`, refusals look like crashes.
        assert_eq!(checked.case("version-1-3-lrgb")["outcome"], "not judged");
        assert_eq!(checked.case("hand-lum-in-color")["outcome"], "pass");
    }
}

#[test]
fn every_image_format_is_accepted_and_jpeg_is_marked() {
    let here = Workspace::new();
    for suffix in ["png", "ppm", "tiff", "bmp", "webp", "jpg"] {
        let render = |light: &str| {
            let template = format!("{PROGRAM} render {{in}} --light={light} -o {{out}}.{suffix}");
            check(&here, &template, "--reject-exit 65")
        };
        let right = render("{lu},{lv}");
        right.assert_exit(0, "");
        let jpeg = "responses are JPEG images, which are lossy";
        assert_eq!(
            right.text.contains(jpeg),
            suffix == "jpg",
            "{suffix}: {}",
            right.text
        );
        // With swapped light coordinates, the check fails.
        render("{lv},{lu}").assert_exit(1, "");
    }
}

#[test]
fn huge_images_allocate_no_memory() {
    let here = Workspace::new();
    let script = "#!/bin/sh\nprintf 'P6 30000 30000 255 x' > \"$2\"\n";
    here.write_program("liar", script);
    let template = "./liar {lu},{lv},{in} {out}";
    let line = format!("check --case hand-* --cmd '{template}' --report report.yaml");
    let (checked, memory) = run_measured(here.command(&line), &here.path("report.yaml"));
    assert_contains(&checked.text, "30000 x 30000 texels, more");
    println!("{memory} KiB");
    assert!(memory < 512 << 10, "{memory} KiB");
}

#[test]
fn refusals_with_another_status_are_weak() {
    let template = "./viewer {lu} {lv} {in} {out}";
    let checked = check(&workspace_with_viewer(3), template, "--reject-exit 3");
    checked.assert_exit(0, "weak refusals:");
    let refused = checked.case("version-1-3-lrgb");
    assert_eq!(refused["outcome"], "pass");
    assert_eq!(refused["weak"], true);
    let cases = checked.report["cases"].as_array().expect("cases");
    assert!(cases.iter().any(|case| case.get("weak").is_none()));

    let checked = check(&workspace_with_viewer(65), template, "--reject-exit 3");
    checked.assert_exit(0, "");
    assert!(!checked.text.contains("weak"), "{}", checked.text);
}

#[test]
fn template_may_contain_the_view() {
    let template = format!("{PROGRAM} reference {{view}} {{in}}");
    let checked = check(&Workspace::new(), &template, "--reject-exit 65");
    checked.assert_exit(0, "");
    let views = serde_json::json!(["raw", "coef", "rgb"]);
    assert_eq!(checked.report["decoder"]["views"], views);
}

#[test]
fn outputs_that_are_not_regular_files_are_not_followed() {
    let here = Workspace::new();
    for [script, says] in rows(
        r#"
ln -s /etc/passwd "$2" | the output file is a link
mkfifo "$2" | the output file is not a regular file
mkdir "$2" | the output file is not a regular file
: | the output file is missing
: > "$2" | the output file is empty
dd if=/dev/zero of="$2" bs=1 count=1 seek=1000000000 2> /dev/null | flood
w=$(pwd) && cd / && mv "$w" "$w.old" && ln -s /etc "$w" && : | the output file is missing
printf 'P6 1 1 255 x' > "$2" | a Netpbm file:"#,
    ) {
        here.write_program("program", format!("#!/bin/sh\n{script}\n"));
        check(&here, "./program {lu},{lv},{in} {out}", "").assert_exit(3, &says);
    }
}

#[test]
fn invalid_templates_are_usage_errors() {
    let here = Workspace::new();
    for [template, options, says] in rows(
        "
viewer | | {in}
viewer {in} | | {lu} and {lv}
viewer {lu} {in} | | {lu} and {lv}
viewer {in} {lu} {lv} {light} | | unknown placeholder {light}
viewer {in} {lu} {lv} {out} {out} | | more than once
viewer 'x {in} {lu} {lv} | | quotation
{in} {lu} {lv} | | first word must be the program
viewer {in} {lu} {lv} | --view raw --view rgb | serves only one view",
    ) {
        check(&here, &template, &options).assert_exit(2, &says);
    }
    check(&here, "", "").assert_exit(2, "empty");
    let with_decoder = here.check("--cmd 'viewer {in} {lu} {lv}' decoder");
    with_decoder.assert_exit(2, "cannot be used with");
}

#[test]
fn doubled_braces_are_literal() {
    let template = "sh -c 'echo ${{HOME:+x}} {{in}} {\"a\"} >&2; exit 9' {in} {lu} {lv}";
    check(&Workspace::new(), template, "").assert_exit(3, "x {in} {a}");
}
