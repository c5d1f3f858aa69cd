//! Tests of reports on the terminal: display, comparison, and baselines.

use std::fs;

use crate::common::{Workspace, assert_contains, rows, zoo};

/// Creates a workspace with a report on the reference decoder.
fn workspace_with_report() -> (Workspace, String) {
    let here = Workspace::new();
    here.succeeds("check --report old.yaml");
    let published = here.text("old.yaml");
    (here, published)
}

/// Returns a command line that checks a decoder from the zoo on a few cases and writes `NAME.yaml`.
fn check(name: &str, kind: &str, options: &str) -> String {
    let zoo = zoo(kind);
    format!("check --report {name}.yaml --case header-plain-* --case version-1-3-* {options} {zoo}")
}

#[test]
fn show_prints_the_output_of_check() {
    let here = Workspace::new();
    let checked = here.exits(1, &check("bad", "accepts-malformed", "--quiet"));
    let shown = here.succeeds("report show bad.yaml");
    assert_eq!(format!("{shown}report: bad.yaml\n"), checked);
    let shown = here.succeeds("report show bad.yaml --case version-1-3-l*");
    assert!(shown.starts_with("version-1-3-lrgb: fail"), "{shown}");
    assert!(!shown.contains("header-plain"), "{shown}");
    here.exits(5, "report show bad.yaml --case x");
}

#[test]
fn diff_lists_every_change() {
    let here = Workspace::new();
    here.succeeds(&check("right", "right", ""));
    here.exits(1, &check("bad", "accepts-malformed", ""));
    assert_eq!(here.succeeds("report diff right.yaml right.yaml"), "");
    let text = here.exits(1, "report diff right.yaml bad.yaml");
    for says in [
        "verdict:\n  - pass\n  + fail\n",
        "began to fail:\n",
        "  version-1-3-lrgb: pass → fail\n",
        "    + says: \"accepted a file that must be refused",
        "  + command: zoo accepts-malformed\n",
    ] {
        assert_contains(&text, says);
    }
    let text = here.exits(1, "report diff bad.yaml right.yaml");
    assert_contains(&text, "cases fixed:\n");
}

#[test]
fn diff_groups_many_changes_by_cause_and_clause() {
    let (here, old) = workspace_with_report();
    let (head, cases) = old.split_once("\ncases:\n").expect("cases");
    let failing = cases.replacen("outcome: pass", "outcome: fail", 40);
    let entries = failing.split("- id: ");
    let entries = entries.filter(|case| case.contains("outcome: fail"));
    let ids: Vec<&str> = entries.filter_map(|case| case.lines().next()).collect();
    assert_eq!(ids.len(), 40);
    let cause = format!(
        "diagnoses:\n- misreading: m\n  clause: 1.0/1\n  effect: e\n  fix: f\n  explains: [{}]",
        ids[..30].join(", ")
    );
    let head = head.replacen("diagnoses: []", &cause, 1);
    here.write("new.yaml", format!("{head}\ncases:\n{failing}"));
    let text = here.exits(1, "report diff old.yaml new.yaml");
    assert!(text.lines().count() < 30, "{text}");
    assert_contains(&text, "40 cases began to fail:\n");
    let example = format!(
        "     30  pass → fail: m (clause 1.0/1), for example {}\n",
        ids[0]
    );
    assert_contains(&text, &example);
    assert_contains(&text, "  pass → fail: no cause, section ");
    assert_contains(&text, "  + m (clause 1.0/1): e; fix: f (explains 30)\n");
    let text = here.exits(1, "report diff --cases old.yaml new.yaml");
    for id in ids {
        assert_contains(&text, &format!("\n  {id}: pass → fail\n"));
    }
}

/// Each edit of a report produces a separate line in the diff.
#[test]
fn diff_reports_each_kind_of_change() {
    let (here, old) = workspace_with_report();
    let place = |id: &str| old.find(&format!("- id: {id}\n")).expect("a case");
    let places = [
        place("first-lum"),
        place("first-lrgb"),
        place("first-ptm-lut"),
    ];
    let (before, lum) = (&old[..places[0]], &old[places[0]..places[1]]);
    let (lrgb, after) = (&old[places[1]..places[2]], &old[places[2]..]);
    let assert_diff = |new: &str, says: &str| {
        here.write("new.yaml", new);
        let text = here.exits(1, "report diff old.yaml new.yaml");
        assert_contains(&text, says);
    };
    let vanished = "1 case vanished:\n  first-lum: pass\n";
    assert_diff(&[before, lrgb, after].concat(), vanished);
    assert_diff(&[before, lrgb, lum, after].concat(), "in a different order");
    assert_diff(&old.replacen("  - coef\n", "", 1), "  - - coef\n");
    let correctness = old.replacen("correctness: ", "correctness: 1", 1);
    assert_diff(&correctness, "  + correctness: 1");
    for [find, replace, says] in rows(
        "
10 s per call | 20 s per call | + - \"wall-clock time: 20 s
breadth: 15/15 | breadth: 14/15 | + breadth: 14/15
reading: nothing | reading: one line feed | + lut-newline: one line feed
- id: first-lum↵  outcome: pass | - id: first-lum↵  outcome: fail
  | 1 case began to fail:↵  first-lum: pass → fail↵
- id: first-lum↵  outcome: pass | - id: first-lum↵  outcome: unsupported
  | 1 case changed outcome:↵  first-lum: pass → unsupported↵
- id: first-lum↵  outcome: pass↵  view: raw | - id: first-lum↵  outcome: pass↵  view: coef
  | 1 case same outcome, other details:↵  first-lum: pass↵      - view: raw↵      + view: coef↵
diagnoses: []
  | diagnoses:↵- misreading: m↵  clause: 1.0/1↵  effect: e↵  fix: f↵  explains: [first-lum]
  | + m (clause 1.0/1): e; fix: f↵  + explains first-lum↵
verdict: pass | verdict: pass↵baseline:↵  known: [a]↵  new: []↵  stale: [] | known failures:↵",
    ) {
        assert!(old.contains(&find), "{find}");
        assert_diff(&old.replacen(&find, &replace, 1), &says);
    }
}

#[test]
fn hostile_reports_are_refused_with_a_line() {
    let (here, old) = workspace_with_report();
    let bomb: Vec<String> = (1..30)
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
        ("b0: &b0 [x, x]\n".to_owned() + &bomb.concat(), "line 1"),
        (format!("tool: {}", "[".repeat(100_000)), "line 1"),
        (format!("tool: {}\n", "x".repeat(5_000_000)), "line 1"),
        ("\u{1}\u{2}".to_owned(), "line 1"),
        ("tool: \"\n".to_owned(), "line "),
    ] {
        here.write("hostile.yaml", text);
        let output = here.exits(2, "report show hostile.yaml");
        assert_contains(&output, "hostile.yaml: ");
        assert_contains(&output, says);
        assert!(output.len() < 2000, "{output}");
    }
    for (status, field) in [(1, "reading: "), (2, "verdict: ")] {
        let escapes = format!("{field}\"\\e]0;x\\a\" # ");
        here.write("escapes.yaml", old.replacen(field, &escapes, 1));
        let output = here.exits(status, "report diff escapes.yaml old.yaml");
        assert!(!output.contains('\x1b'), "{output}");
        assert_contains(&output, "\\u{1b}]0;x");
    }
    here.write("latin.yaml", b"tool: 1\nverdict: \xe4\n");
    assert_contains(
        &here.exits(2, "report show latin.yaml"),
        "line 2: not UTF-8",
    );
    let large = fs::File::create(here.path("large.yaml")).expect("a file");
    large.set_len(1 << 34).expect("a sparse file");
    assert_contains(
        &here.exits(2, "report diff large.yaml old.yaml"),
        "larger than",
    );
    here.exits(2, "report show no-such-file");
    here.exits(2, "report show .");
}

#[test]
fn known_failures_are_not_reported_as_new() {
    let here = Workspace::new();
    let wrong = |options: &str| check("report", "accepts-malformed", options);
    // Writing a baseline does not change the exit status.
    here.exits(1, &wrong("--write-baseline known.yaml"));
    let known = here.text("known.yaml");
    assert_contains(&known, "- id: version-1-3-lrgb\n");

    // All failures are known, but they are still failures.
    here.exits(0, &wrong("--baseline known.yaml"));
    let report = here.text("report.yaml");
    assert_contains(&report, "verdict: fail\n");
    assert_contains(&report, "baseline:\n");

    // A failure that is not listed is new.
    let fewer = known.replacen("- id: version-1-3-lrgb\n", "", 1);
    here.write("fewer.yaml", &fewer);
    let text = here.exits(1, &wrong("--baseline fewer.yaml"));
    assert_contains(
        &text,
        "new failures (not in the baseline): 1\n  version-1-3-lrgb\n",
    );

    // A listed case that passes is stale. Cases that were not selected are ignored.
    let stale = "- id: header-plain-lrgb\n  reason: |\n    two\n    lines\n";
    let later = "- id: hand-lum\n  reason: later\n";
    here.write("more.yaml", format!("{known}{stale}{later}"));
    let text = here.exits(4, &wrong("--baseline more.yaml"));
    assert_contains(&text, "stale, listed but passing: 1\n  header-plain-lrgb\n");

    // New failures take precedence over stale entries.
    here.write("both.yaml", format!("{fewer}- id: header-plain-lrgb\n"));
    here.exits(1, &wrong("--baseline both.yaml"));

    // The updated baseline omits the passing case and keeps the unselected case with its reason.
    here.exits(4, &wrong("--baseline more.yaml --write-baseline more.yaml"));
    let updated = here.text("more.yaml");
    assert!(!updated.contains("header-plain-lrgb"), "{updated}");
    assert_contains(&updated, later);
    here.exits(0, &wrong("--baseline more.yaml"));

    // If nothing fails, the baseline is an empty list, which can be read.
    here.exits(0, &check("report", "right", "--write-baseline none.yaml"));
    here.exits(0, &check("report", "right", "--baseline none.yaml"));

    // For a program that is not a decoder, no baseline is written.
    let options = "--baseline known.yaml --write-baseline no.yaml";
    here.exits(3, &check("report", "exits-1", options));
    assert!(!here.path("no.yaml").exists());
}

#[test]
fn invalid_baselines_are_usage_errors() {
    let here = Workspace::new();
    for [list, says] in rows(
        r#"
- id: hand-lum↵- id: no-such-case↵ | line 2: unknown case "no-such-case"
- id: hand-lum↵- id: hand-lum↵ | line 2: duplicate case hand-lum
- id: hand-lum↵  because: x↵ | because
hand-lum: x↵ | line 1
- hand-lum↵ | line 1"#,
    ) {
        here.write("list.yaml", list);
        let text = here.exits(2, &check("report", "right", "--baseline list.yaml"));
        assert_contains(&text, &format!("list.yaml: && {says}"));
    }
    here.exits(2, &check("report", "right", "--baseline no-such-file"));
}
