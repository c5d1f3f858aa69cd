//! Serve mode, capabilities, and what starts and what does not.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Stdio;

use ptm_conform::protocol::capabilities::Capabilities;
use ptm_conform::ptm::Format;

use crate::common::{Checked, check_with, have, make_executable, program, repository, zoo};

const FEW: &[&str] = &[
    "--case",
    "hand-*",
    "--case",
    "version-1-3-*",
    "--case",
    "header-plain-*",
    "--timeout",
    "60",
];

fn reference() -> Vec<&'static str> {
    vec![env!("CARGO_BIN_EXE_ptm-conform"), "reference"]
}

/// The examples of the page on serve mode are what is read and written.
#[test]
fn capabilities_and_answers_are_as_the_page_shows_them() {
    let page = fs::read_to_string(repository("docs/check.md")).expect("the page");
    let lines = page.lines().skip_while(|line| *line != "    protocol: 1");
    let lines = lines.take_while(|line| !line.is_empty());
    let yaml: String = lines.map(|line| format!("{}\n", line.trim())).collect();
    let said = Capabilities::read(yaml.as_bytes()).expect("it counts");
    assert_eq!(said.formats.as_deref(), Some(&Format::ALL[..]));
    assert_eq!(said.views, Some(vec!["raw", "coef", "rgb"]));
    assert!(said.serves && said.remarks.is_empty(), "{said:?}");

    let mut serving = program()
        .args(["reference", "serve"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the reference starts");
    let file = repository("corpus/lrgb/first-lrgb.ptm");
    let mut requests = serving.stdin.take().expect("its input");
    writeln!(requests, "1 raw {file}").expect("a request");
    drop(requests);
    let answer = serving.wait_with_output().expect("an end").stdout;
    let head = b"1 ok 72\nPTM1 raw 3 2 9 u8\n";
    assert!(answer.starts_with(head) && answer.len() == head.len() + 54);
    assert!(page.contains("< 1 ok 72\n    < PTM1 raw 3 2 9 u8 "));
}

#[test]
fn serving_and_one_shot_give_the_same_verdicts() {
    let served = check_with(&["--serve", "--timeout", "60"], &reference());
    let one_shot = check_with(&["--one-shot", "--timeout", "60"], &reference());
    assert_eq!((served.status, one_shot.status), (0, 0), "{}", served.text);
    assert_eq!(served.report["decoder"]["mode"], "serve");
    assert_eq!(one_shot.report["decoder"]["mode"], "one-shot");
    for field in ["verdict", "scores", "dialect", "cases"] {
        assert_eq!(served.report[field], one_shot.report[field], "{field}");
    }
}

#[test]
fn the_reference_serves_request_after_request() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let path = scratch.path().join("a file.ptm");
    fs::write(&path, b"PTM_1.2\nPTM_FORMAT_LRGB\n1\n1\n1 1 1 1 1 0.5\n0 0 0 0 0 0\n\x01\x02\x03\x04\x05\x80\xff\x80\x00").expect("a file");
    let broken = scratch.path().join("broken.ptm");
    fs::write(&broken, b"PTM_1.2\n").expect("a file");
    let mut child = program()
        .args(["reference", "serve"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("it starts");
    let requests = format!(
        "1 raw {0}\n2 rgb:0,0 {0}\n3 raw {1}\n44 png {0}\n",
        path.display(),
        broken.display()
    );
    child
        .stdin
        .take()
        .expect("a pipe")
        .write_all(requests.as_bytes())
        .expect("it listens");
    let output = child.wait_with_output().expect("it ends");
    assert!(output.status.success());
    let expected = [
        &b"1 ok 27\nPTM1 raw 1 1 9 u8\n\x01\x02\x03\x04\x05\x80\xff\x80\x00"[..],
        b"2 ok 21\nPTM1 rgb 1 1 3 u8\n\x40\x20\x00",
        b"3 reject 65\n44 unsupported view\n",
    ]
    .concat();
    assert_eq!(
        output.stdout.escape_ascii().to_string(),
        expected.escape_ascii().to_string()
    );
}

#[test]
fn the_python_decoder_is_served_by_its_own_word() {
    if !have("python3") {
        return;
    }
    let checked = check_with(
        FEW,
        &["python3", &repository("examples/decoders/ptm_decoder.py")],
    );
    assert_eq!(checked.status, 0, "{}", checked.text);
    assert_eq!(checked.report["decoder"]["mode"], "serve");
    assert_eq!(checked.report["decoder"]["name"], "ptm-decoder-python");
    assert_eq!(checked.report["decoder"]["version"], "1.0");
}

#[test]
fn what_leaks_is_told_with_the_file_before_and_is_the_same_in_every_run() {
    let check = || {
        check_with(
            &[FEW, &["--serve", "--jobs", "2"]].concat(),
            &[&zoo(), "serves-with-leaks"],
        )
    };
    let (one, two) = (check(), check());
    assert_eq!(one.status, 1, "{}", one.text);
    assert_eq!(one.report, two.report);
    let says = says(&one, "header-plain-ptm-lut");
    assert!(
        says.contains("in serve mode, after ") && says.contains("state leaks between files"),
        "{says}"
    );
}

fn says(checked: &Checked, id: &str) -> String {
    let cases = checked.report["cases"]
        .as_array()
        .cloned()
        .unwrap_or_default();
    let case = cases
        .into_iter()
        .find(|case| case["id"] == id)
        .unwrap_or_default();
    case["says"].as_str().unwrap_or_default().to_owned()
}

#[test]
fn capabilities_name_the_decoder_and_its_views() {
    let checked = check_with(FEW, &[&zoo(), "declares-rgb-only"]);
    assert_eq!(checked.report["decoder"]["name"], "modest");
    assert_eq!(checked.report["decoder"]["mode"], "one-shot");
    let checked = check_with(FEW, &[&zoo(), "declares-coef-only"]);
    assert_eq!(
        checked.report["decoder"]["views"],
        serde_json::json!(["coef"])
    );
    let checked = check_with(FEW, &[&zoo(), "declares-everything-and-fails"]);
    assert_eq!(checked.report["decoder"]["name"], serde_json::Value::Null);
}

#[test]
fn reports_with_remarks_conform_to_the_schema() {
    for kind in [
        "upside-down",
        "declares-serve-and-lacks-it",
        "no-raw-of-rgb",
        "serves-with-leaks",
    ] {
        let checked = check_with(FEW, &[&zoo(), kind]);
        let errors = crate::common::report_errors(&checked.report);
        assert!(errors.is_empty(), "{kind}: {errors:#?}");
    }
}

/// Asks for one case of a decoder that is found from `directory`.
fn start(directory: &Path, words: &[&str]) -> (i32, String) {
    let output = program()
        .current_dir(directory)
        .args([
            "check",
            "--case",
            "hand-lrgb-blocks",
            "--timeout",
            "60",
            "--",
        ])
        .args(words)
        .output()
        .expect("the program starts");
    let text = [output.stdout, output.stderr].concat();
    (
        output.status.code().unwrap_or(-1),
        String::from_utf8_lossy(&text).into_owned(),
    )
}

#[test]
fn what_does_not_start_is_told_why() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let directory = scratch.path();
    let put = |name: &str, bytes: &[u8], executable: bool| {
        let path = directory.join(name);
        fs::write(&path, bytes).expect("a file");
        if executable {
            make_executable(&path);
        }
    };
    put("plain.py", b"#!/usr/bin/env python3\n", false);
    put("bare", b"#!/bin/sh\n", true);
    put("no-first-line.py", b"print('x')\n", true);
    put("crlf", b"#!/bin/sh\r\necho\r\n", true);
    put("gone", b"#!/no/such/interpreter\n", true);
    let mut elf = b"\x7fELF\x02\x01\x01".to_vec();
    elf.resize(64, 0);
    elf[18] = if cfg!(target_arch = "aarch64") {
        62
    } else {
        183
    };
    put("foreign", &elf, true);
    put("dec.exe", b"MZ\x90\0", true);
    put("empty", b"", true);
    for (word, says) in [
        ("./plain.py", "is not executable; chmod +x plain.py"),
        ("bare", "write ./bare"),
        (
            "no-such-program-at-all",
            "no program of this name is in PATH",
        ),
        ("./no-such-file", "no such file"),
        ("./crlf", "ends in CR LF"),
        (
            "./gone",
            "names the interpreter \"/no/such/interpreter\", which is not there",
        ),
        ("./no-first-line.py", "has no #! line"),
        ("./foreign", "is a program for another machine"),
        ("./dec.exe", "is a Windows program"),
        ("./empty", "is empty"),
        ("/", "is a directory"),
    ] {
        let (status, text) = start(directory, &[word]);
        assert!(
            status == 3 && text.contains(says),
            "{word} should be told {says:?}: {status} {text}"
        );
    }
}

/// A decoder of `LRGB` in `raw`, for runtimes: the header as its parent spells it, and 69 for all else.
const NODE: &str = r"
const fs = require('fs');
const [view, path] = process.argv.slice(2);
const file = fs.readFileSync(path || '/dev/null');
let at = 0;
const line = () => { const end = file.indexOf(10, at); const text = file.toString('latin1', at, end); at = end + 1; return text; };
if (view !== 'raw' || line() !== 'PTM_1.2' || line() !== 'PTM_FORMAT_LRGB') process.exit(69);
const numbers = []; while (numbers.length < 14) numbers.push(...line().trim().split(/ +/).map(Number));
const [w, h] = numbers;
const out = Buffer.alloc(w * h * 9);
for (let y = 0; y < h; y++) for (let x = 0; x < w; x++) {
  const from = (h - 1 - y) * w + x, to = (y * w + x) * 9;
  file.copy(out, to, at + from * 6, at + from * 6 + 6);
  file.copy(out, to + 6, at + w * h * 6 + from * 3, at + w * h * 6 + from * 3 + 3);
}
fs.writeSync(1, Buffer.concat([Buffer.from(`PTM1 raw ${w} ${h} 9 u8\n`), out]));
";

const JAVA: &str = r#"
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
fn node_runs_under_the_default_limit_of_memory() {
    if !have("node") {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    fs::create_dir(scratch.path().join("my decoders")).expect("a directory");
    fs::write(scratch.path().join("my decoders/dec ptm.js"), NODE).expect("a script");
    let (status, text) = start(scratch.path(), &["node", "my decoders/dec ptm.js"]);
    assert!(status == 0 && text.contains("pass: 1 pass"), "{text}");
}

#[test]
fn java_runs_under_the_default_limit_of_memory() {
    if !have("javac") || !have("java") {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    fs::write(scratch.path().join("Dec.java"), JAVA).expect("a source file");
    let compiled = std::process::Command::new("javac")
        .current_dir(scratch.path())
        .args(["-d", "my classes", "Dec.java"])
        .status();
    assert!(compiled.expect("javac starts").success());
    let (status, text) = start(scratch.path(), &["java", "-cp", "my classes", "Dec"]);
    assert!(status == 0 && text.contains("pass: 1 pass"), "{text}");
}

#[test]
fn a_virtual_environment_is_found_by_a_relative_path() {
    if !have("python3") {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let made = std::process::Command::new("python3")
        .current_dir(scratch.path())
        .args(["-m", "venv", "--without-pip", "my venv"])
        .status();
    if !made.is_ok_and(|status| status.success()) {
        println!("SKIPPED: python3 has no venv");
        return;
    }
    let packages = fs::read_dir(scratch.path().join("my venv/lib"))
        .expect("a directory")
        .flatten()
        .next()
        .expect("a python");
    fs::write(packages.path().join("site-packages/only_here.py"), "").expect("a module");
    let decoder =
        fs::read_to_string(repository("examples/decoders/ptm_decoder.py")).expect("the decoder");
    fs::write(
        scratch.path().join("dec.py"),
        format!("import only_here\n{decoder}"),
    )
    .expect("a script");
    let (status, text) = start(scratch.path(), &["my venv/bin/python3", "dec.py"]);
    assert!(status == 0 && text.contains("pass: 1 pass"), "{text}");
    let (status, _) = start(scratch.path(), &["python3", "dec.py"]);
    assert_eq!(status, 3, "without the environment the module is missing");
}
