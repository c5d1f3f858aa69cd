//! Tests of HTML pages, badges, `JUnit` files and GitHub output.

use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;

use crate::common::{Workspace, have_python, rows, stdout};
use crate::in_process::{answer_with, misreading, reference_answer, suite};
use data_encoding::BASE64;
use ptm_conform::report::html::{self, Evidence};
use ptm_conform::report::{badge, github, junit};
use ptm_harness::diagnose::{Category, diagnose};
use ptm_harness::pipeline::{self, Check, check, judge_answers};
use ptm_harness::report::Report;
use ptm_harness::report::document::Verdict;
use ptm_harness::report::suite_texts::SuiteTexts;
use ptm_harness::session::plan::RunPlan;
use ptm_harness::session::run::Run;
use ptm_suite::address::SITE;
use ptm_suite::cases::Suite;
use ptm_suite::protocol::frame::{Answer, Samples, ViewKind};
use ptm_suite::protocol::request::{Reply, Request};
use ptm_suite::test_case::Listed;
use ptm_suite::verdicts::outcome::Outcome;
use ptm_suite::{name::SuiteName, texture::cases::TextureView, values::Values};
use ptm_texture::Rules;

/// Output of a hostile decoder.
const HOSTILE: &str = "<script>document.title = 'owned'</script>\n<img src=x onerror=alert(1)> & \"quoted\" 'too'\n::error::x\n\u{1b}[31mred";

/// Runs every fourth case with a decoder that makes one mistake and prints hostile text. Returns the suite, run and report.
fn run_misreading(slug: &str) -> (Suite, Run, Report) {
    let (suite, mistake) = (suite(), misreading(slug));
    let mut plan = RunPlan::new(&suite, 2);
    plan.selected = (0..suite.cases.len()).map(|i| i % 4 == 0).collect();
    let ask = |request: &Request<'_>, _: usize| Reply {
        stderr: HOSTILE.to_owned(),
        ..Reply::from(answer_with(&[mistake], request))
    };
    let run = judge_answers(&suite, &plan, &ask);
    let diagnoses = diagnose(&suite, &run, &[], 2).diagnoses;
    let command = ["/somewhere/<b>decoder</b>".to_owned(), slug.to_owned()];
    let report = Report::new(&suite, &run, &command, Vec::new()).with_diagnoses(&suite, &diagnoses);
    (suite, run, report)
}

/// Returns the suite, run and report of a decoder that reads rows top-down and therefore fails nearly every case.
fn run_upside_down() -> &'static (Suite, Run, Report) {
    static RUN: LazyLock<(Suite, Run, Report)> = LazyLock::new(|| run_misreading("rows-top-down"));
    &RUN
}

fn texts<C: Listed>(suite: &Suite<C>) -> SuiteTexts {
    SuiteTexts::new(suite).expect("the texts can be read")
}

fn render(suite: &Suite, report: &Report, run: &Run) -> String {
    let evidence = Evidence::new(suite, run, html::case_evidence);
    html::page(&texts(suite), report, &evidence)
}

fn matrix(reports: &[Report]) -> Result<String, String> {
    let texts = texts(&run_upside_down().0);
    html::matrix(reports, &texts)
}

fn failures(report: &Report) -> usize {
    let cases = report.cases.iter();
    cases.filter(|case| case.outcome == Outcome::Fail).count()
}

/// Saves a page for the browser test.
fn save_page(name: &str, text: &str) {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(path, text).expect("a file");
}

#[test]
fn large_pages_are_complete_small_and_self_contained() {
    let (suite, run, report) = run_upside_down();
    let page = render(suite, report, run);
    save_page("failures.html", &page);
    let count = failures(report);
    assert!(count >= 200, "{count}");
    assert!(page.len() <= 5_000_000, "{}", page.len());
    for case in &report.cases {
        assert!(page.contains(&format!(">{}<", case.id)), "{}", case.id);
    }
    let cause = &report.diagnoses[0];
    assert_eq!(cause.name(), "rows-top-down");
    let clause = cause.clause.as_ref().expect("a clause");
    for words in [&cause.effect, &cause.fix, clause] {
        assert!(page.contains(words.as_str()), "{words}");
    }
    // All links lead to the site, and nothing refers to another server.
    let links = page.matches("href=\"https://").count();
    assert!(links > 1000 && page.matches("https:").count() == links);
    assert_eq!(page.matches(&format!("href=\"{SITE}")).count(), links);
    for address in "http: //cdn @import url( fetch( XMLHttpRequest".split(' ') {
        assert!(!page.contains(address), "{address}");
    }
    let again = render(suite, report, run);
    assert!(page == again);
}

#[test]
fn decoder_output_is_escaped() {
    let (suite, run, report) = run_misreading("v-negated");
    for page in [
        render(&suite, &report, &run),
        html::page_without_images(&texts(&suite), &report),
        matrix(&[report.clone(), report.clone()]).expect("a page"),
    ] {
        assert_eq!(page.matches("<script").count(), 1, "only one script");
        assert!(!page.contains("<img src=x"));
        assert!(!page.contains("<b>decoder"));
        assert!(page.contains("default-src 'none'"));
    }
    let page = render(&suite, &report, &run);
    assert!(page.contains("&lt;script&gt;document.title"));
}

#[test]
fn images_contain_the_generated_samples() {
    let (suite, run, report) = run_upside_down();
    let page = render(suite, report, run);
    let mut compared = 0;
    for part in page.split("<details class=\"case\" id=\"case-").skip(1) {
        let id = part.split('"').next().expect("an id");
        let case = suite.case(id).expect("a case");
        let built = case.build(run.table);
        let Values::Painted(model) = &built.values else {
            continue;
        };
        let is_raw = part.contains("Requested: <code>raw</code>");
        let is_large = model.size.width > 48 || model.size.height > 48;
        if !is_raw || model.format.channels() == 18 || is_large {
            continue;
        }
        let Some(image) = part.split("data:image/png;base64,").nth(1) else {
            continue;
        };
        let image = image.split('"').next().expect("an end");
        let bytes = BASE64.decode(image.as_bytes()).expect("base 64");
        let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info();
        let mut reader = reader.expect("a PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut pixels).expect("pixels");
        let (width, height) = (model.size.width as usize, model.size.height as usize);
        let channels = model.format.channels();
        let total = channels * (width + 1) - 1;
        assert_eq!(reader.info().size(), (total as u32, height as u32), "{id}");
        for (i, &sample) in model.samples.iter().enumerate() {
            let (texel, channel) = (i / channels, i % channels);
            let (x, y) = (texel % width, texel / width);
            let at = 4 * (y * total + channel * (width + 1) + x);
            assert_eq!(pixels[at..at + 4], [sample, sample, sample, 255], "{id}");
        }
        compared += 1;
    }
    assert!(compared > 20, "{compared}");
}

#[test]
fn five_thousand_cases_fit_on_a_page() {
    let (suite, run, report) = run_upside_down();
    let mut report = report.clone();
    let cases = report.cases.clone();
    for (i, case) in cases.iter().cycle().take(5000 - cases.len()).enumerate() {
        let mut case = case.clone();
        case.id = format!("{}-again-{i}", case.id);
        report.cases.push(case);
    }
    let page = render(suite, &report, run);
    save_page("many.html", &page);
    assert_eq!(report.cases.len(), 5000);
    assert!(failures(&report) > 2000);
    println!("{} failures, {} bytes", failures(&report), page.len());
    assert!(page.len() < 10_000_000, "{}", page.len());
}

#[test]
fn several_reports_are_rendered_as_a_matrix() {
    let reports = [run_upside_down().2.clone(), run_misreading("no-128").2];
    let page = matrix(&reports).expect("a page");
    save_page("matrix.html", &page);
    for report in &reports {
        assert!(page.contains(&report.scores.correctness.to_string()));
        assert!(page.contains(report.diagnoses[0].name()));
    }
    let states = |clause: &str| -> Vec<String> {
        let row = page.split(&format!("<code>{clause}</code>")).nth(1);
        let row = row.and_then(|row| row.split("</tr>").next());
        let cells = row.expect("a row").split("data-state=\"").skip(1);
        cells
            .filter_map(|cell| cell.split('"').next().map(str::to_owned))
            .collect()
    };
    let all = run_upside_down().0.cases.len();
    let selected = format!("{} of {all}", reports[0].cases.len());
    assert_eq!(page.matches(&selected).count(), 2, "{selected}");
    assert_eq!(states("2.7.1/3"), ["fail", "pass"]);
    assert_eq!(states("2.9.5/4"), ["fail", "fail"]);
}

#[test]
fn crashes_are_not_misreadings() {
    let (suite, _, report) = run_upside_down();
    let mut report = report.clone();
    report.diagnoses.truncate(1);
    let cause = &mut report.diagnoses[0];
    cause.misreading = None;
    cause.kind = Some(Category::Violation);
    cause.effect = "crashes on two files".to_owned();
    cause.example = Some("for example first-rgb: It crashes.".to_owned());
    let page = html::page_without_images(&texts(suite), &report);
    assert!(page.contains("<p>For example first-rgb: It crashes.</p>"));
    assert!(!page.contains("<p class=\"rule\">"));
    assert!(!page.contains(" data-blamed "));
    let matrix = matrix(&[report.clone(), report]).expect("a page");
    assert!(matrix.contains("crashes on two files"));
    assert!(!matrix.contains("violation"));
    for number in ["(1)", "(2)"] {
        let number = format!("<span class=\"quiet\">{number}</span>");
        assert_eq!(matrix.matches(&number).count(), 1);
    }
}

#[test]
fn badge_shows_correctness_and_breadth() {
    let (_, _, report) = run_upside_down();
    let mut report = report.clone();
    save_page("badge.svg", &badge::badge(&report));
    for (suite, not) in [
        (SuiteName::Ptm, Verdict::NotADecoder),
        (SuiteName::Texture, Verdict::NotADecoder),
        (SuiteName::Writers, Verdict::NotAWriter),
    ] {
        report.suite = suite;
        for verdict in [Verdict::Pass, Verdict::Fail, not] {
            report.verdict = verdict;
            report.reason = (verdict == not).then(|| "it does not start".to_owned());
            let badge = badge::badge(&report);
            let scores = &report.scores;
            for score in [scores.correctness, scores.breadth, scores.robustness] {
                assert!(badge.contains(&score.to_string()));
            }
            assert!(!badge.contains("<b>"));
            let width = badge.split("width=\"").nth(1).expect("a width");
            let (width, _) = width.split_once('"').expect("an end");
            let width: u32 = width.parse().expect("pixels");
            assert!((60..=250).contains(&width), "{suite:?} {verdict}: {width}");
        }
    }
}

/// Every failing case has a command that reruns the case and, if the file is small, a download link.
#[test]
fn failing_cases_have_a_file_and_a_command() {
    let (suite, run, report) = run_upside_down();
    let page = render(suite, report, run);
    let mut files = 0;
    for part in page.split("<details class=\"case\" id=\"case-").skip(1) {
        let id = part.split('"').next().expect("an id");
        // The name of the decoder contains shell metacharacters.
        let command = format!("ptm-conform check --case {id} -- 'b&gt;' rows-top-down");
        assert!(part.contains(&command), "{id}");
        let data = "href=\"data:application/octet-stream;base64,";
        let Some(file) = part.split(data).nth(1) else {
            continue;
        };
        let file = file.split('"').next().expect("an end");
        let built = suite.case(id).expect("a case").build(run.table);
        assert!(
            BASE64.decode(file.as_bytes()) == Ok(built.file.clone()),
            "{id}"
        );
        files += 1;
    }
    assert!(files > 100, "{files}");
}

/// The page of a decoder that supports only colors contains images, arithmetic and the scene.
#[test]
fn colors_are_explained_with_their_arithmetic() {
    let suite = suite();
    let halve_red = |request: &Request<'_>, _: usize| {
        let Answer::Decoded(mut frame) = reference_answer(request) else {
            return Reply::from(Answer::Rejected);
        };
        if frame.view != ViewKind::Rgb {
            return Reply::from(Answer::Unsupported);
        }
        if let Samples::U8(bytes) = &mut frame.samples {
            for texel in bytes.chunks_exact_mut(3) {
                texel[0] /= 2;
            }
        }
        Reply::from(Answer::Decoded(frame))
    };
    let mut plan = RunPlan::new(&suite, 2);
    plan.selected = (0..suite.cases.len()).map(|i| i % 16 == 0).collect();
    let check_of_answers = Check {
        requests_scene: true,
        ..Check::of_answers(&suite, &plan)
    };
    let checked = check(&check_of_answers, &halve_red, &());
    let checked = checked.expect("a function has no trouble");
    let evidence = Evidence {
        scene: checked.scene.as_ref(),
        ..Evidence::new(&suite, &checked.run, html::case_evidence)
    };
    let page = html::page(&texts(&suite), &checked.report, &evidence);
    save_page("colors.html", &page);
    assert!(
        page.contains("<figure class=\"scene\">") && page.contains("The scene is for illustration")
    );
    assert!(page.matches("<figure class=\"colors\">").count() > 20);
    assert!(page.contains("a0·u² + a1·v² + a2·u·v + a3·u + a4·v + a5 = "));
    assert!(page.contains("red differs in "));
}

#[test]
fn page_of_a_non_decoder_names_the_next_step() {
    let (suite, _, report) = run_upside_down();
    let mut report = report.clone();
    report.verdict = Verdict::NotADecoder;
    report.reason = Some("no first file was <b>decoded</b>".to_owned());
    report.cases.clear();
    report.diagnoses.clear();
    let page = html::page_without_images(&texts(suite), &report);
    save_page("no-decoder.html", &page);
    for words in [
        "What to do next",
        "ptm-conform probe DECODER",
        "PTM1 raw WIDTH",
        "docs/protocol.html",
    ] {
        assert!(page.contains(words), "{words}");
    }
    for words in ["id=\"filter\"", "All judged cases passed", "<b>decoded"] {
        assert!(!page.contains(words), "{words}");
    }
}

/// The page of the texture suite contains questions, links to the site, and the command.
#[test]
fn page_of_a_texture_stage_contains_the_questions() {
    let suite = Suite::load_texture().expect("the texture suite");
    let plan = RunPlan::new(&suite, 2);
    let mistake = ptm_mistakes::texture::all().next().expect("a misreading");
    let ask = |request: &Request<'_, TextureView>, _: usize| {
        let case = suite.case(request.name).expect("a case");
        Reply::from(case.answer(&mistake.apply_to(Rules::SPEC)))
    };
    let run = pipeline::texture::judge_answers(&suite, &plan, &ask);
    let command = ["stage".to_owned()];
    let report = Report::on_texture_stage(&suite, &run, &command, Vec::new());
    let evidence = Evidence::new(&suite, &run, html::question_evidence);
    let page = html::page(&texts(&suite), &report, &evidence);
    save_page("texture.html", &page);
    let failing = failures(&report);
    assert!(failing > 0);
    let command = "ptm-conform check --suite texture --case ";
    assert_eq!(page.matches(command).count(), failing);
    assert!(page.matches(".json\" href=\"data:").count() > 0);
    assert!(page.contains(&format!("{SITE}texture/cases.html#")));
}

#[test]
fn github_output_contains_no_commands() {
    let (suite, _, report) = run_upside_down();
    let mut report = report.clone();
    let annotations = github::annotations(&report);
    assert!(annotations.lines().count() <= 11);
    assert!(annotations.starts_with("::error title=PTM 1.2%2C clause "));
    report.verdict = Verdict::NotADecoder;
    report.reason =
        Some("it says:\n::set-env name=PATH::x\r\n  ::stop-commands::y, 100%".to_owned());
    let annotations = github::annotations(&report);
    let escaped = "it says:%0A::set-env name=PATH::x%0D%0A  ::stop-commands::y, 100%25\n";
    assert!(annotations.starts_with(&format!("::error title=not a decoder::{escaped}")));
    let is_known = |line: &str| line.starts_with("::error ") || line.starts_with("::notice ");
    assert!(annotations.lines().all(is_known));
    let text = github::quote_commands("fine\n  ::add-mask::x\n##[error]y\nends");
    assert_eq!(text, "fine\n>   ::add-mask::x\n> ##[error]y\nends");
    let summary = github::summary(&report, suite.cases.len());
    save_page("summary.md", &summary);
    assert!(summary.len() < 1 << 20);
    assert!(!summary.contains("<b>"));
}

#[test]
fn junit_output_can_be_parsed() {
    let mut report = run_upside_down().2.clone();
    let last = report.cases.len() - 1;
    report.cases[last].outcome = Outcome::NotRun;
    report.cases[last - 1].outcome = Outcome::Unsupported;
    let xml = junit::junit(&report, None);
    save_page("junit.xml", &xml);
    let count = |outcome: Outcome| report.with_outcome(outcome).count();
    let skipped =
        report.cases.len() - count(Outcome::Pass) - count(Outcome::Fail) - count(Outcome::NotRun);
    assert!(skipped > 0);
    let script = "import sys, junitparser\n\
        xml = junitparser.JUnitXml.fromfile(sys.argv[1])\n\
        suites = list(xml)\n\
        cases = list(suites[0])\n\
        kind = lambda k: sum(any(isinstance(r, k) for r in c.result) for c in cases)\n\
        print(len(suites), len(cases), kind(junitparser.Failure), kind(junitparser.Error), kind(junitparser.Skipped))\n\
        print(suites[0].tests, suites[0].failures, suites[0].errors, suites[0].skipped)\n";
    if !have_python(&["junitparser"]) {
        return;
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("junit.xml");
    let text = stdout(Command::new("python3").args(["-c", script]).arg(path));
    let (cases, failed, not_run) = (
        report.cases.len(),
        count(Outcome::Fail),
        count(Outcome::NotRun),
    );
    let counts = format!("{cases} {failed} {not_run} {skipped}");
    assert_eq!(text, format!("1 {counts}\n{counts}\n"));
}

#[test]
fn program_writes_every_format() {
    let here = Workspace::new();
    let outputs = "--report report.yaml --html report.html --junit junit.xml";
    let mut check = here.command(&format!("check --case hand-* --github {outputs}"));
    let checked = check
        .env("GITHUB_STEP_SUMMARY", here.path("summary.md"))
        .status();
    assert!(checked.expect("the program starts").success());
    here.succeeds("check --report published.yaml");
    assert!(here.text("report.html").starts_with("<!DOCTYPE html>"));
    assert!(here.text("summary.md").starts_with("## ✅ PTM 1.2"));
    for [line, begins] in rows(
        "
html report.yaml | <!DOCTYPE html>
html report.yaml published.yaml | <!DOCTYPE html>
junit report.yaml | <?xml
badge published.yaml | <svg
markdown published.yaml | ## ✅",
    ) {
        here.succeeds(&format!("report {line} -o made"));
        assert!(here.text("made").starts_with(&begins), "{line}");
    }
    assert!(here.text("junit.xml").contains("<testsuites"));
    here.write("broken.yaml", "tool: [");
    for wrong in ["broken.yaml", "missing.yaml"] {
        let text = here.exits(2, &format!("report badge {wrong}"));
        assert!(text.contains(wrong), "{text}");
    }
}
