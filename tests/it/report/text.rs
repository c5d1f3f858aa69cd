//! Reports read back, compared, and held against lists of known failures.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{program, zoo};

/// Runs the program in `directory`; its status and what it printed.
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

/// Checks a program of the zoo on two cases of each kind into `directory/NAME.yaml`.
fn check(directory: &Path, name: &str, kind: &str, options: &[&str]) -> (i32, String) {
    let (report, zoo) = (format!("{name}.yaml"), zoo());
    let some = [
        "check",
        "--report",
        &report,
        "--case",
        "header-plain-*",
        "--case",
        "version-1-3-*",
    ];
    run(directory, &[&some, options, &[&zoo, kind]].concat())
}

fn published() -> String {
    crate::common::repository("reports/reference.yaml")
}

fn write(directory: &Path, name: &str, text: &str) -> PathBuf {
    let path = directory.join(name);
    fs::write(&path, text).expect("a file");
    path
}

#[test]
fn show_prints_what_check_printed() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let (status, told) = check(scratch.path(), "bad", "accepts-malformed", &["--quiet"]);
    assert_eq!(status, 1, "{told}");
    let (status, shown) = run(scratch.path(), &["report", "show", "bad.yaml"]);
    assert_eq!(status, 0);
    assert_eq!(format!("{shown}report: bad.yaml\n"), told);
    let (status, shown) = run(
        scratch.path(),
        &["report", "show", "bad.yaml", "--case", "version-1-3-l*"],
    );
    assert_eq!(status, 0);
    assert!(shown.starts_with("version-1-3-lrgb: fail"), "{shown}");
    assert!(!shown.contains("header-plain"), "{shown}");
    let none = run(
        scratch.path(),
        &["report", "show", "bad.yaml", "--case", "x"],
    );
    assert_eq!(none.0, 5);
}

#[test]
fn diff_states_every_change() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let here = scratch.path();
    check(here, "right", "right", &[]);
    check(here, "bad", "accepts-malformed", &[]);
    assert_eq!(
        run(here, &["report", "diff", "right.yaml", "right.yaml"]),
        (0, String::new())
    );
    let (status, text) = run(here, &["report", "diff", "right.yaml", "bad.yaml"]);
    assert_eq!(status, 1);
    for says in [
        "verdict:\n  - pass\n  + fail\n",
        "began to fail:\n",
        "  version-1-3-lrgb: pass → fail\n",
        "    + says: \"accepted a file that must be refused",
        "  + command: zoo accepts-malformed\n",
    ] {
        assert!(text.contains(says), "{says:?} in:\n{text}");
    }
    let (status, text) = run(here, &["report", "diff", "bad.yaml", "right.yaml"]);
    assert_eq!(status, 1);
    assert!(text.contains("cases fixed:\n"), "{text}");
}

#[test]
fn diff_groups_many_changes_by_cause_and_clause() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let old = fs::read_to_string(published()).expect("the published report");
    let (head, cases) = old.split_once("\ncases:\n").expect("cases");
    let failing = cases.replacen("outcome: pass", "outcome: fail", 40);
    let ids: Vec<&str> = failing
        .split("- id: ")
        .filter(|case| case.contains("outcome: fail"))
        .filter_map(|case| case.lines().next())
        .collect();
    assert_eq!(ids.len(), 40);
    let cause = format!(
        "diagnoses:\n- misreading: m\n  clause: 1.0/1\n  effect: e\n  fix: f\n  explains: [{}]",
        ids[..30].join(", ")
    );
    let head = head.replacen("diagnoses: []", &cause, 1);
    let new = write(
        scratch.path(),
        "new.yaml",
        &format!("{head}\ncases:\n{failing}"),
    );
    let new = new.to_string_lossy();
    let (status, text) = run(scratch.path(), &["report", "diff", &published(), &new]);
    assert_eq!(status, 1);
    assert!(text.lines().count() < 30, "{text}");
    for says in [
        "40 cases began to fail:\n",
        &format!(
            "     30  pass → fail: m (clause 1.0/1), for example {}\n",
            ids[0]
        ),
        "  pass → fail: no cause, section ",
        "  + m (clause 1.0/1): e; fix: f (explains 30)\n",
    ] {
        assert!(text.contains(says), "{says:?} in:\n{text}");
    }
    let (_, text) = run(
        scratch.path(),
        &["report", "diff", "--cases", &published(), &new],
    );
    for id in ids {
        assert!(
            text.contains(&format!("\n  {id}: pass → fail\n")),
            "{id} in:\n{text}"
        );
    }
}

/// Each of these edits of a report is told, and told as what it is.
#[test]
fn diff_leaves_no_change_unsaid() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let old = fs::read_to_string(published()).expect("the published report");
    let first = old.find("- id: first-lum\n").expect("a case");
    let second = first + old[first..].find("- id: first-lrgb\n").expect("a case");
    let without = format!("{}{}", &old[..first], &old[second..]);
    let swapped = format!(
        "{}{}{}",
        &old[..first],
        &old[second..second + old[second..].find("- id: first-ptm-lut\n").expect("a case")],
        &old[first..second]
    ) + &old[second + old[second..].find("- id: first-ptm-lut\n").expect("a case")..];
    let edit = |find: &str, replace: &str| {
        assert!(old.contains(find), "{find}");
        old.replacen(find, replace, 1)
    };
    for (new, says) in [
        (
            edit("10 s per call", "20 s per call"),
            "  + - \"wall clock: 20 s",
        ),
        (edit("  - coef\n", ""), "  - - coef\n"),
        (
            edit("correctness: ", "correctness: 1"),
            "  + correctness: 1",
        ),
        (
            edit("breadth: 15/15", "breadth: 14/15"),
            "  + breadth: 14/15",
        ),
        (
            edit("reading: nothing", "reading: one line feed"),
            "  + lut-newline: one line feed",
        ),
        (
            edit(
                "- id: first-lum\n  outcome: pass",
                "- id: first-lum\n  outcome: fail",
            ),
            "1 case began to fail:\n  first-lum: pass → fail\n",
        ),
        (
            edit(
                "- id: first-lum\n  outcome: pass",
                "- id: first-lum\n  outcome: unsupported",
            ),
            "1 case changed outcome:\n  first-lum: pass → unsupported\n",
        ),
        (
            edit(
                "- id: first-lum\n  outcome: pass\n  view: raw",
                "- id: first-lum\n  outcome: pass\n  view: coef",
            ),
            "1 case same outcome, other details:\n  first-lum: pass\n      - view: raw\n      + view: coef\n",
        ),
        (
            edit(
                "diagnoses: []",
                "diagnoses:\n- misreading: m\n  clause: 1.0/1\n  effect: e\n  fix: f\n  explains: [first-lum]",
            ),
            "  + m (clause 1.0/1): e; fix: f\n  + explains first-lum\n",
        ),
        (without, "1 case vanished:\n  first-lum: pass\n"),
        (swapped, "another order"),
        (
            edit(
                "verdict: pass",
                "verdict: pass\nbaseline:\n  known: [a]\n  new: []\n  stale: []",
            ),
            "known failures:\n",
        ),
    ] {
        let new = write(scratch.path(), "new.yaml", &new);
        let (status, text) = run(
            scratch.path(),
            &["report", "diff", &published(), &new.to_string_lossy()],
        );
        assert_eq!(status, 1, "{says}: {text}");
        assert!(text.contains(says), "{says:?} in:\n{text}");
    }
}

#[test]
fn hostile_reports_are_refused_at_a_line() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let here = scratch.path();
    let old = fs::read_to_string(published()).expect("the published report");
    let bomb: String = (1..30)
        .map(|i| format!("b{i}: &b{i} [*b{0}, *b{0}]\n", i - 1))
        .collect();
    for (text, says) in [
        (String::new(), ""),
        ("tool: {}\n".to_owned(), "line 1"),
        (
            "- id: first-lum\n  answer: decoded\n".to_owned(),
            "FILE.partial",
        ),
        (old.replacen("verdict: pass", "verdict: [pass]", 1), "line "),
        (
            old.replacen("  outcome: pass", "  outcome: {a: b}", 1),
            "line ",
        ),
        (format!("b0: &b0 [x, x]\n{bomb}"), "line 1"),
        (format!("tool: {}", "[".repeat(100_000)), "line 1"),
        (format!("tool: {}\n", "x".repeat(5_000_000)), "line 1"),
        ("\u{1}\u{2}".to_owned(), "line 1"),
        ("tool: \"\n".to_owned(), "line "),
    ] {
        let path = write(here, "hostile.yaml", &text);
        let (status, told) = run(here, &["report", "show", &path.to_string_lossy()]);
        let beginning: String = told.chars().take(300).collect();
        assert_eq!(status, 2, "{beginning}");
        assert!(
            told.contains("hostile.yaml: ") && told.contains(says),
            "{says:?}: {beginning}"
        );
        assert!(told.len() < 2000, "{beginning}");
    }
    let escapes = old.replacen("verdict: pass", "verdict: \"\\e]0;x\\a\"", 1);
    write(here, "escapes.yaml", &escapes);
    let (status, told) = run(here, &["report", "diff", "escapes.yaml", &published()]);
    assert!(
        status == 1 && !told.contains('\x1b') && told.contains("\\u{1b}]0;x"),
        "{told}"
    );
    fs::write(here.join("latin.yaml"), b"tool: 1\nverdict: \xe4\n").expect("a file");
    let (status, told) = run(here, &["report", "show", "latin.yaml"]);
    assert!(status == 2 && told.contains("line 2: not UTF-8"), "{told}");
    let large = fs::File::create(here.join("large.yaml")).expect("a file");
    large.set_len(1 << 34).expect("a hole");
    let (status, told) = run(here, &["report", "diff", "large.yaml", &published()]);
    assert!(status == 2 && told.contains("larger than"), "{told}");
    assert_eq!(run(here, &["report", "show", "no-such-file"]).0, 2);
    assert_eq!(run(here, &["report", "show", "."]).0, 2);
}

#[test]
fn known_failures_are_no_news() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let here = scratch.path();
    let (status, _) = check(
        here,
        "a",
        "accepts-malformed",
        &["--write-baseline", "known.yaml"],
    );
    assert_eq!(status, 1, "writing a list changes no status");
    let known = fs::read_to_string(here.join("known.yaml")).expect("a list");
    assert!(known.contains("- id: version-1-3-lrgb\n"), "{known}");

    // All are known.
    let (status, text) = check(
        here,
        "b",
        "accepts-malformed",
        &["--baseline", "known.yaml"],
    );
    assert_eq!(status, 0, "{text}");
    let report = fs::read_to_string(here.join("b.yaml")).expect("a report");
    assert!(
        report.contains("verdict: fail\n") && report.contains("baseline:\n"),
        "a known failure is a failure"
    );

    // One is not listed: news.
    let fewer = known.replacen("- id: version-1-3-lrgb\n", "", 1);
    write(here, "fewer.yaml", &fewer);
    let (status, text) = check(
        here,
        "c",
        "accepts-malformed",
        &["--baseline", "fewer.yaml"],
    );
    assert_eq!(status, 1, "{text}");
    assert!(
        text.contains("new, not in the list: 1\n  version-1-3-lrgb\n"),
        "{text}"
    );

    // One passes: stale. Those that were not selected are left alone.
    let more = format!(
        "{known}- id: header-plain-lrgb\n  reason: |\n    two\n    lines\n- id: hand-lum\n  reason: later\n"
    );
    write(here, "more.yaml", &more);
    let (status, text) = check(here, "d", "accepts-malformed", &["--baseline", "more.yaml"]);
    assert_eq!(status, 4, "{text}");
    assert!(
        text.contains("stale, listed but passing: 1\n  header-plain-lrgb\n"),
        "{text}"
    );

    // News goes before staleness.
    let both = format!("{fewer}- id: header-plain-lrgb\n");
    write(here, "both.yaml", &both);
    let (status, text) = check(here, "e", "accepts-malformed", &["--baseline", "both.yaml"]);
    assert_eq!(status, 1, "{text}");

    // Written anew, the list loses what passes and keeps what was not asked, with its reason.
    let renew = ["--baseline", "more.yaml", "--write-baseline", "more.yaml"];
    assert_eq!(check(here, "f", "accepts-malformed", &renew).0, 4);
    let renewed = fs::read_to_string(here.join("more.yaml")).expect("a list");
    assert!(!renewed.contains("header-plain-lrgb"), "{renewed}");
    assert!(
        renewed.contains("- id: hand-lum\n  reason: later\n"),
        "{renewed}"
    );
    assert_eq!(
        check(here, "g", "accepts-malformed", &["--baseline", "more.yaml"]).0,
        0
    );

    // Nothing fails: an empty list, which can be read.
    assert_eq!(
        check(here, "h", "right", &["--write-baseline", "none.yaml"]).0,
        0
    );
    assert_eq!(check(here, "i", "right", &["--baseline", "none.yaml"]).0, 0);

    // A program that is no decoder stays none, and writes no list.
    let (status, _) = check(
        here,
        "j",
        "exits-1",
        &["--baseline", "known.yaml", "--write-baseline", "no.yaml"],
    );
    assert!(status == 3 && !here.join("no.yaml").exists());
}

#[test]
fn wrong_lists_are_wrong_usage() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let here = scratch.path();
    for (list, says) in [
        (
            "- id: hand-lum\n- id: no-such-case\n",
            "line 2: unknown case \"no-such-case\"",
        ),
        (
            "- id: hand-lum\n- id: hand-lum\n",
            "line 2: duplicate case hand-lum",
        ),
        ("- id: hand-lum\n  because: x\n", "because"),
        ("hand-lum: x\n", "line 1"),
        ("- hand-lum\n", "line 1"),
    ] {
        write(here, "list.yaml", list);
        let (status, text) = check(here, "x", "right", &["--baseline", "list.yaml"]);
        assert_eq!(status, 2, "{list}: {text}");
        assert!(
            text.contains("list.yaml: ") && text.contains(says),
            "{says:?}: {text}"
        );
    }
    assert_eq!(
        check(here, "x", "right", &["--baseline", "no-such-file"]).0,
        2
    );
}
