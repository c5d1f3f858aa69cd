//! The Python wheel and the functions of its module.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{
    PROGRAM, Workspace, assert_contains, have_python, outcome, repository, stdout,
};
use data_encoding::HEXLOWER;

fn python(arguments: &[&str]) -> Command {
    let mut python = Command::new("python3");
    python.args(arguments).env("PTM_CONFORM_PROGRAM", PROGRAM);
    python
}

/// Builds the wheel with a stand-in for the program.
fn wheel(program: &Path, out: &Path) -> PathBuf {
    let script = repository("packages/python/build_wheel.py");
    let platform = "manylinux2014_x86_64.musllinux_1_1_x86_64";
    let mut build = python(&[&script]);
    build.args([program, out]).args(["--platform", platform]);
    stdout(&mut build).trim().into()
}

#[test]
fn wheel_is_reproducible_and_its_record_is_correct() {
    if !have_python(&["zipfile"]) {
        return;
    }
    let here = Workspace::new();
    let program = here.write("ptm-conform", "not a program");
    let [first, second] = ["a", "b"].map(|name| wheel(&program, &here.path(name)));
    let version = env!("CARGO_PKG_VERSION");
    let name =
        format!("ptm_conform-{version}-py3-none-manylinux2014_x86_64.musllinux_1_1_x86_64.whl");
    assert_eq!(first.file_name().expect("a name"), name.as_str());
    assert_eq!(fs::read(&first).ok(), fs::read(&second).ok());
    // The record lists every file with its digest, and the program is executable.
    let check = r#"
import base64, hashlib, sys, zipfile
wheel = zipfile.ZipFile(sys.argv[1])
record = [line.rsplit(",", 2) for line in wheel.read(next(n for n in wheel.namelist() if n.endswith("/RECORD"))).decode().splitlines()]
assert sorted(name for name, _, _ in record) == sorted(wheel.namelist())
for name, digest, size in record:
    if not name.endswith("/RECORD"):
        data = wheel.read(name)
        expected = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        assert (digest, size) == ("sha256=" + expected, str(len(data))), name
program = next(i for i in wheel.infolist() if i.filename.endswith("/scripts/ptm-conform"))
assert program.external_attr >> 16 == 0o100755
assert wheel.read("ptm_conform/__init__.py").count(b"@") == 0
assert wheel.read("ptm_conform/cases.json").startswith(b'["first-rgb", ')
"#;
    stdout(python(&["-c", check]).arg(&first));
}

#[test]
fn python_module_reads_files_like_the_reference() {
    if !have_python(&["numpy"]) {
        return;
    }
    let file = repository("corpus/lum/hand-lum.ptm");
    let script = r#"
import sys
sys.path.insert(0, sys.argv[1])
import ptm_conform
file = open(sys.argv[2], "rb").read()
raw, coef, lit = ptm_conform.decode(file), ptm_conform.decode(file, "coef"), ptm_conform.decode(file, "rgb:0,0")
print(raw.shape, raw.dtype, coef.shape, coef.dtype, lit.shape, raw.tobytes().hex())
print(sorted({finding["code"] for finding in ptm_conform.lint(sys.argv[2])}))
for damaged in (b"", file[:-1]):
    try:
        ptm_conform.decode(damaged)
        sys.exit("a damaged file was decoded")
    except ptm_conform.Malformed as what:
        assert "byte" in str(what) and "/" not in str(what), what
"#;
    let text = stdout(&mut python(&[
        "-c",
        script,
        &repository("packages/python"),
        &file,
    ]));
    let reference = Workspace::new()
        .command(&format!("reference raw {file}"))
        .output();
    let frame = reference.expect("the program starts").stdout;
    let samples = frame.splitn(2, |byte| *byte == b'\n').nth(1);
    let hex = HEXLOWER.encode(samples.expect("samples"));
    assert_contains(
        &text,
        &format!(" uint8  &&  float32  && {hex} && 'PTM-W303'"),
    );
}

#[test]
fn functions_and_programs_get_equal_verdicts() {
    if !have_python(&["numpy", "PIL", "pillow_jpls"]) {
        return;
    }
    let script = repository("packages/python/measure.py");
    let text = stdout(&mut python(&[
        &script,
        "--copies",
        "1",
        "--options=--smoke",
        "--no-speed",
    ]));
    assert_contains(
        &text,
        "equal: 0 failures, no cause  the example && big-endian-index",
    );
}

#[test]
fn mistakes_of_a_function_have_separate_messages() {
    if !have_python(&["numpy"]) {
        return;
    }
    let script = r#"
import pathlib, sys, tempfile
sys.path.insert(0, sys.argv[1])
import numpy, ptm_conform
options = ["--case", "hand-*", "--case", "width-zero-lrgb"]
def stop(file):
    raise KeyError("lost")
for wrong in (lambda file: None, lambda file: numpy.zeros((2, 2)), lambda file: ptm_conform.decode(file).astype(int), stop):
    report = ptm_conform.check_callable(wrong, options=options)
    print(report.status, report.data["reason"])
print(report.text.splitlines()[0])
class Damaged(ValueError):
    pass
def refuse(file):
    raise Damaged("no")
both = ptm_conform.check_callable(refuse, malformed=ValueError, unsupported=Damaged, options=options)
print("refused as", {case.outcome for case in both.cases.values()} or both.data["reason"])
for kind in (Exception, (KeyError, BaseException)):
    try:
        ptm_conform.check_callable(stop, malformed=kind)
        sys.exit("a catch-all class was accepted")
    except TypeError as what:
        assert "nearly every error" in str(what), what
report = ptm_conform.check_callable(ptm_conform.decode, options=options)
print(report.passed, sorted({case.outcome for case in report.cases.values()}))
class Unsupported(Exception):
    pass
def gray_only(file):
    if b"_LUM\n" not in file[:40]:
        raise Unsupported("only PTM_FORMAT_LUM")
    return ptm_conform.decode(file)
with tempfile.TemporaryDirectory() as folder:
    page = pathlib.Path(folder, "report.html")
    ptm_conform.check_callable(gray_only, unsupported=Unsupported, options=["--case", "hand-*", "--html", str(page)])
    html = page.read_text("utf-8")
    print("status" if "exit status 69" in html else "unsupported (the exception for unsupported files)" in html)
def interrupted(file):
    raise KeyboardInterrupt
try:
    ptm_conform.check_callable(interrupted)
    sys.exit("the interrupt was lost")
except KeyboardInterrupt:
    pass
"#;
    let text = stdout(&mut python(&["-c", script, &repository("packages/python")]));
    for part in [
        "it returned NoneType, not an array",
        "its array has the shape (2, 2), not (height, width, channels)",
        "its array is of int64; raw is uint8",
        "KeyError: 'lost'",
        "and counts as a crash; if it means a file that is malformed, pass malformed=KeyError",
        "refused as it raises the exception for unsupported files",
        "True ['pass'",
        "\nTrue\n",
    ] {
        assert_contains(&text, part);
    }
}

#[test]
fn pytest_has_a_test_for_each_case() {
    if !have_python(&["numpy", "pytest"]) {
        return;
    }
    let here = Workspace::new();
    let stand_in = here.write("ptm-conform", "");
    let wheel = wheel(&stand_in, &here.path(""));
    stdout(python(&["-m", "zipfile", "-e"]).args([wheel, here.path("unpacked")]));
    let tests = "import ptm_conform, pytest\n\
        @pytest.fixture(scope='session')\n\
        def ptm_decoder():\n    return lambda file: ptm_conform.decode(file)[::-1]\n\
        def test_ptm(ptm_case):\n    ptm_case.check()\n";
    here.write("test_ptm.py", tests);
    let run = |words: &[&str]| {
        let options = "-m pytest -q -rA -p no:cacheprovider -k".split(' ');
        let output = python(&options.collect::<Vec<_>>())
            .args(words)
            .env("PYTHONPATH", here.path("unpacked"))
            .current_dir(here.path(""))
            .output();
        outcome(&output.expect("python3 starts")).1
    };
    let some = "hand-rgb-blocks or width-zero-lrgb";
    let text = run(&[some]);
    let says = "FAILED test_ptm.py::test_ptm[hand-rgb-blocks] - Failed: && test_ptm[width-zero-lrgb] && causes of PTM failures && 1 of 1: raw: the rows are upside down";
    assert_contains(&text, says);
    // A known failure is expected, and a known failure that passes fails.
    here.write(
        "known.yaml",
        "- id: hand-rgb-blocks\n  reason: rows\n- id: width-zero-lrgb\n",
    );
    let text = run(&[some, "--ptm-baseline", "known.yaml"]);
    let says = "XFAIL test_ptm.py::test_ptm[hand-rgb-blocks] - rows: && known failures that pass; remove them from known.yaml && 1 failed && 1 xfailed";
    assert_contains(&text, says);
    // Exceptions that are not declared are named, with their places. Cases of a format that is not read are skipped.
    let tests = "import ptm_conform, pytest\n\
        class Damaged(Exception):\n    pass\n\
        def decode(file):\n    \
            if b'_LRGB\\n' not in file[:40]:\n        raise ptm_conform.Unsupported('only LRGB')\n    \
            try:\n        return ptm_conform.decode(file)\n    \
            except ptm_conform.Malformed as what:\n        raise Damaged(what)\n\
        @pytest.fixture(scope='session')\n\
        def ptm_decoder():\n    return {'raw': decode, 'options': ['--jobs', '1']}\n\
        def test_ptm(ptm_case):\n    ptm_case.check()\n";
    here.write("test_ptm.py", tests);
    let text = run(&["test_ptm"]);
    for part in [
        "not asked: the decoder reads none of the first files of this kind",
        "Damaged is declared neither as malformed nor as unsupported",
        "if it means a file that is malformed, pass malformed=Damaged",
    ] {
        assert_contains(&text, part);
    }
    assert!(!text.contains("TypeError"), "{text}");
}

/// Runs the program of docs/scale.md with two worker processes, one of which is killed, and compares the rows with those of `lint`.
#[test]
fn dask_checks_an_archive_although_a_worker_is_killed() {
    if !have_python(&["distributed"]) {
        return;
    }
    let here = Workspace::new();
    let names = ["lrgb/first-lrgb", "lrgb/half-payload-lrgb", "lum/first-lum"];
    let files = names.map(|name| {
        fs::read(repository(&format!("corpus/{name}.ptm"))).expect("a file of the corpus")
    });
    for i in 0..2000 {
        here.write(&format!("files/{i:04}.ptm"), &files[i % files.len()]);
    }
    let scale = fs::read_to_string(repository("docs/scale.md")).expect("a document");
    let code = scale.split("```python\n").nth(1).expect("a program");
    let code = code.split("```").next().expect("its end");
    here.write("archive.py", code);
    here.write(
        "test.py",
        "\
import os, signal, sys, threading
import distributed, archive

if __name__ == '__main__':
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            pids = list(client.run(os.getpid).values())
            kill = threading.Timer(0.3, os.kill, [pids[0], signal.SIGKILL])
            kill.start()
            archive.main('files', 'rows.jsonl', client)
            kill.join()
",
    );
    let package = repository("packages/python");
    let mut run = Command::new("python3");
    run.arg("test.py").current_dir(here.path("."));
    run.env("PYTHONPATH", format!("{package}:."));
    // Each of the twenty batches takes a while, so the worker is killed in the middle.
    let slow = format!("#!/bin/sh\nsleep 0.2\nexec {PROGRAM} \"$@\"\n");
    run.env("PTM_CONFORM_PROGRAM", here.write_program("slow", &slow));
    let output = run.output().expect("python starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    let mut lint = here.command("lint -rq --format jsonl files");
    let expected = lint.output().expect("the program starts").stdout;
    let expected = String::from_utf8(expected).expect("UTF-8");
    let parse = |text: &str| -> Vec<serde_json::Value> {
        let rows = text.lines().map(serde_json::from_str);
        rows.collect::<Result<_, _>>().expect("JSON")
    };
    let rows = parse(&here.text("rows.jsonl"));
    assert_eq!(rows.len(), 2000);
    assert_eq!(rows, parse(&expected));
}
