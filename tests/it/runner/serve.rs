//! Tests serve mode, capabilities, and various language runtimes.

use std::fs::{self, File};
use std::process::Command;

use ptm::Format;
use ptm_harness::runner::{run::Decoder, scratch::Scratch, serve::Servers};
use ptm_suite::protocol::capabilities::Capabilities;
use ptm_suite::protocol::frame::{Answer, Frame, View, ViewKind};
use ptm_suite::protocol::request::{AttemptKind, Request};

use crate::common::{
    CheckRun, PROGRAM, Workspace, assert_conforms, assert_contains, check, edit, have_tool,
    python_example, repository, repository_text, skip, zoo,
};

const FEW_CASES: &str = "--case hand-* --case version-1-3-* --case header-plain-* --timeout 60";

/// Checks a program from the zoo on a few cases.
fn check_zoo(kind: &str) -> CheckRun {
    check(&format!("{FEW_CASES} -- {}", zoo(kind)))
}

/// Returns the output of the reference in serve mode.
fn serve(here: &Workspace, requests: &str) -> Vec<u8> {
    here.write("requests", requests);
    let mut serving = here.command("reference serve");
    serving.stdin(File::open(here.path("requests")).expect("requests"));
    let output = serving.output().expect("the program starts");
    assert!(output.status.success());
    output.stdout
}

/// The examples in `docs/check.md` must equal the actual output.
#[test]
fn documented_capabilities_and_responses_work() {
    let page = repository_text("docs/check.md");
    let lines = page.lines().skip_while(|line| *line != "    protocol: 1");
    let lines = lines.take_while(|line| !line.is_empty());
    let yaml: String = lines.map(|line| [line.trim(), "\n"].concat()).collect();
    let read = Capabilities::read(yaml.as_bytes()).expect("capabilities");
    assert_eq!(read.formats.as_deref(), Some(&Format::ALL[..]));
    assert_eq!(read.views.as_deref(), Some(&ViewKind::ALL[..]));
    assert!(
        read.serves && read.pipelined && read.remarks.is_empty(),
        "{read:?}"
    );

    let file = repository("corpus/lrgb/first-lrgb.ptm");
    let answer = serve(&Workspace::new(), &format!("1 raw {file}\n"));
    let head = b"1 ok 72\nPTM1 raw 3 2 9 u8\n";
    assert!(answer.starts_with(head) && answer.len() == head.len() + 54);
    assert!(page.contains("< 1 ok 72\n    < PTM1 raw 3 2 9 u8 "));
}

#[test]
fn serving_and_one_shot_give_the_same_verdicts() {
    let [served, one_shot] = ["serve", "one-shot"].map(|mode| {
        let checked = check(&format!("--{mode} --timeout 60 -- {PROGRAM} reference"));
        checked.assert_exit(0, "");
        assert_eq!(checked.report["decoder"]["mode"], mode);
        checked.report
    });
    for field in ["verdict", "scores", "dialect", "cases"] {
        assert_eq!(served[field], one_shot[field], "{field}");
    }
}

#[test]
fn pipelined_requests_give_the_same_report() {
    if !have_tool("python3") {
        return;
    }
    let text = repository_text("examples/decoders/ptm_decoder.py");
    // A wrong decoder: its failures are equal, too.
    let text = edit(&text, "255 - value", "(256 - value) % 256");
    let text = edit(&text, "if words != [b\"PTM_1.2\"]:", "if False:");
    let here = Workspace::new();
    here.write("pipelined.py", &text);
    here.write("single.py", edit(&text, "pipelined: true\n", ""));
    let [pipelined, single] = ["pipelined", "single"].map(|name| {
        let mut checked = here.check(&format!("--timeout 60 -- python3 {name}.py"));
        assert_eq!(checked.report["decoder"]["mode"], "serve");
        assert!(!checked.cases("fail").is_empty());
        checked.report["decoder"]["command"].take();
        checked.report
    });
    assert_eq!(pipelined, single);
}

/// Each frame is many times as large as the buffer of a pipe.
#[test]
fn large_pipelined_frames_arrive_in_order() {
    let command = [PROGRAM.into(), "reference".into()];
    let decoder = Decoder::new(&command).expect("a directory");
    let scratch = Scratch::new().expect("a scratch directory");
    let servers = Servers::new(&decoder, &scratch, 1);
    let view: View = "coef".parse().expect("a view");
    let files = [100, 200, 300, 100, 200, 300, 100, 200].map(|width| {
        let header = format!("PTM_1.2\nPTM_FORMAT_LRGB\n{width}\n200\n1 1 1 1 1 1\n0 0 0 0 0 0\n");
        let samples =
            (0..width * 200 * 9).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8);
        header.bytes().chain(samples).collect::<Vec<u8>>()
    });
    let requests = files.each_ref().map(|file| Request {
        attempt: AttemptKind::Usual,
        ..Request::new("large", &view, file, 4 * file.len())
    });
    for _ in 0..4 {
        let replies = servers.ask_pipelined(&requests, 0);
        assert_eq!(replies.len(), requests.len());
        for (reply, file) in replies.iter().zip(&files) {
            let ptm = ptm::decode(file).expect("a legal file");
            assert_eq!(reply.answer, Answer::Decoded(Frame::render(&ptm, &view)));
        }
    }
    assert!(servers.pipelining_failure().is_none());
}

#[test]
fn reference_serves_many_requests() {
    let here = Workspace::new();
    let file = b"PTM_1.2\nPTM_FORMAT_LRGB\n1\n1\n1 1 1 1 1 0.5\n0 0 0 0 0 0\n\x01\x02\x03\x04\x05\x80\xff\x80\x00";
    here.write("a file.ptm", file);
    here.write("broken.ptm", b"PTM_1.2\n");
    let requests = "1 raw a file.ptm\n2 rgb:0,0 a file.ptm\n3 raw broken.ptm\n44 png a file.ptm\n";
    let expected = [
        &b"1 ok 27\nPTM1 raw 1 1 9 u8\n\x01\x02\x03\x04\x05\x80\xff\x80\x00"[..],
        b"2 ok 21\nPTM1 rgb 1 1 3 u8\n\x40\x20\x00",
        b"3 reject 65\n44 unsupported view\n",
    ];
    let answers = serve(&here, requests).escape_ascii().to_string();
    assert_eq!(answers, expected.concat().escape_ascii().to_string());
}

#[test]
fn the_python_decoder_declares_serve_mode_and_is_served() {
    if !have_tool("python3") {
        return;
    }
    let decoder = python_example("decoders/ptm_decoder.py");
    let checked = check(&format!("{FEW_CASES} -- {decoder}"));
    checked.assert_exit(0, "");
    let decoder = &checked.report["decoder"];
    assert_eq!(decoder["mode"], "serve");
    assert_eq!(decoder["name"], "ptm-decoder-python");
    assert_eq!(decoder["version"], "1.0");
}

#[test]
fn state_leak_is_reported_with_the_previous_file() {
    let line = format!(
        "{FEW_CASES} --serve --jobs 2 -- {}",
        zoo("serves-with-leaks")
    );
    let (one, two) = (check(&line), check(&line));
    one.assert_exit(1, "");
    assert_eq!(one.report, two.report);
    let says = one.case("header-plain-ptm-lut")["says"].as_str();
    let expected = "in serve mode (the previous request was  && state may leak between files";
    assert_contains(says.unwrap_or_default(), expected);
}

#[test]
fn capabilities_name_the_decoder_and_its_views() {
    let declared = |kind: &str| check_zoo(kind).report["decoder"].clone();
    let rgb_only = declared("declares-rgb-only");
    assert_eq!(rgb_only["name"], "modest");
    assert_eq!(rgb_only["mode"], "one-shot");
    let coef = serde_json::json!(["coef"]);
    assert_eq!(declared("declares-coef-only")["views"], coef);
    assert!(declared("declares-everything-and-fails")["name"].is_null());
}

#[test]
fn reports_with_remarks_conform_to_the_schema() {
    for kind in [
        "upside-down",
        "declares-serve-and-lacks-it",
        "no-raw-of-rgb",
        "serves-with-leaks",
    ] {
        assert_conforms(&check_zoo(kind).report, "report");
    }
}

/// Command that checks a decoder on a single case.
const CHECK_ONE_CASE: &str = "check --case hand-lrgb-blocks --timeout 60 --";

/// A decoder for the view `raw` of `LRGB`. It supports some spellings of the header and exits with 69 for everything else.
const JAVA_DECODER: &str = r#"
import java.io.*; import java.nio.file.*;
public class Dec {
  static byte[] file; static int at = 0;
  static String line() { int end = at; while (file[end] != 10) end++; String text = new String(file, at, end - at); at = end + 1; return text; }
  public static void main(String[] words) throws IOException {
    if (words.length != 2 || !words[0].equals("raw")) System.exit(69);
    file = Files.readAllBytes(Paths.get(words[1]));
    if (!line().equals("PTM_1.2") || !line().equals("PTM_FORMAT_LRGB")) System.exit(69);
    StringBuilder numbers = new StringBuilder(); int count = 0;
    while (count < 14) { String text = line().trim(); numbers.append(text).append(' '); count += text.split(" +").length; }
    String[] size = numbers.toString().split(" +"); int w = Integer.parseInt(size[0]), h = Integer.parseInt(size[1]);
    ByteArrayOutputStream out = new ByteArrayOutputStream();
    out.write(("PTM1 raw " + w + " " + h + " 9 u8\n").getBytes());
    for (int y = 0; y < h; y++) for (int x = 0; x < w; x++) {
      int from = (h - 1 - y) * w + x;
      out.write(file, at + from * 6, 6); out.write(file, at + w * h * 6 + from * 3, 3);
    }
    System.out.write(out.toByteArray()); System.out.flush();
  }
}
"#;

#[test]
fn java_runs_under_the_default_memory_limit() {
    if have_tool("javac") && have_tool("java") {
        let here = Workspace::new();
        here.write("Dec.java", JAVA_DECODER);
        let mut javac = Command::new("javac");
        javac
            .current_dir(here.path(""))
            .args(["-d", "my classes", "Dec.java"]);
        assert!(javac.status().expect("javac starts").success());
        let text = here.succeeds(&format!("{CHECK_ONE_CASE} java -cp 'my classes' Dec"));
        assert_contains(&text, "pass: 1 pass");
    }
}

#[test]
fn virtual_environment_is_found_by_relative_path() {
    if !have_tool("python3") {
        return;
    }
    let here = Workspace::new();
    let made = Command::new("python3")
        .current_dir(here.path(""))
        .args(["-m", "venv", "--without-pip", "my venv"])
        .status();
    if !made.is_ok_and(|status| status.success()) {
        skip("the module venv of python3");
        return;
    }
    let mut versions = fs::read_dir(here.path("my venv/lib"))
        .expect("a directory")
        .flatten();
    let packages = versions
        .next()
        .expect("a version")
        .path()
        .join("site-packages");
    fs::write(packages.join("only_here.py"), "").expect("a module");
    let decoder = repository_text("examples/decoders/ptm_decoder.py");
    here.write("dec.py", format!("import only_here\n{decoder}"));
    let text = here.succeeds(&format!("{CHECK_ONE_CASE} 'my venv/bin/python3' dec.py"));
    assert_contains(&text, "pass: 1 pass");
    // Outside the virtual environment, the module is missing.
    here.exits(3, &format!("{CHECK_ONE_CASE} python3 dec.py"));
}
