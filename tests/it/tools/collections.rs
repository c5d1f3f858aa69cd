//! `lint` over collections: a row for each file whatever it is, in every form, in bounded memory, and whole when it is killed.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::Write;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::common::{have_python, measured, program, repository, run};

/// The CSV that `lint` prints, as rows of cells.
fn csv(args: &[&str]) -> Vec<Vec<String>> {
    let output = run(&[&["lint", "--format", "csv", "-q"], args].concat());
    rows(&String::from_utf8(output.stdout).expect("it is text"))
}

/// Reads CSV as RFC 4180 describes it. No cell of ours has a line feed, so a line is a row.
fn rows(text: &str) -> Vec<Vec<String>> {
    let row = |line: &str| {
        let (mut cells, mut quoted) = (vec![String::new()], false);
        let mut characters = line.chars().peekable();
        while let Some(character) = characters.next() {
            let cell = cells.last_mut().expect("there is a first cell");
            match character {
                '"' if quoted && characters.peek() == Some(&'"') => {
                    cell.push('"');
                    characters.next();
                }
                '"' => quoted = !quoted,
                ',' if !quoted => cells.push(String::new()),
                _ => cell.push(character),
            }
        }
        assert!(!quoted && cells.len() == 11, "{line}");
        cells
    };
    text.lines().map(row).collect()
}

/// So many files in folders: sound ones, damaged ones, others, one after the other.
fn collection(directory: &Path, files: usize) {
    let originals = [
        "corpus/lrgb/first-lrgb.ptm",
        "corpus/lrgb/half-payload-lrgb.ptm",
        "corpus/MANIFEST.yaml",
        "corpus/lum/first-lum.ptm",
    ];
    let originals = originals.map(|path| fs::read(repository(path)).expect("a file"));
    for file in 0..files {
        let folder = directory.join((file / 1000).to_string());
        fs::create_dir_all(&folder).expect("a folder");
        let bytes = &originals[file % originals.len()];
        let bytes = &bytes[..bytes.len().min(4096)];
        fs::write(folder.join(format!("{file}.ptm")), bytes).expect("a file");
    }
}

#[test]
fn ten_thousand_files_are_ten_thousand_rows_in_the_memory_of_a_thousand() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let [few, many] = [1000, 10_000].map(|files| {
        let folder = scratch.path().join(files.to_string());
        collection(&folder, files);
        let mut command = program();
        command
            .args(["lint", "-rq", "--format", "csv"])
            .arg(&folder);
        let (linted, memory) = measured(command, Path::new("no report"));
        let rows = rows(&linted.text);
        assert_eq!(rows.len(), 1 + files);
        for (status, quarter) in [("sound", 2), ("damaged", 1), ("not-a-ptm", 1)] {
            let of_it = rows.iter().filter(|row| row[1] == status).count();
            assert_eq!(of_it, files / 4 * quarter, "{status}");
        }
        assert_eq!(linted.status, 1);
        memory
    });
    println!("most memory: {few} KiB for 1,000 files, {many} KiB for 10,000");
    assert!(many < few + 8 * 1024, "{few} KiB, then {many} KiB");
}

/// Copies of the files of the corpus, one after the other.
fn copies_of_the_corpus(directory: &Path, files: usize) -> Vec<PathBuf> {
    let mut originals: Vec<PathBuf> = fs::read_dir(repository("corpus"))
        .expect("the corpus")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.is_dir())
        .flat_map(|folder| fs::read_dir(folder).expect("a folder"))
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|suffix| suffix == "ptm"))
        .collect();
    originals.sort();
    let copy = |(number, original): (usize, &PathBuf)| {
        let path = directory.join(format!("{number:05}.ptm"));
        fs::copy(original, &path).expect("a copy");
        path
    };
    originals
        .iter()
        .cycle()
        .take(files)
        .enumerate()
        .map(copy)
        .collect()
}

/// Seconds that a command needs, the least of five.
fn seconds(command: impl Fn() -> Command) -> f64 {
    let once = || {
        let begin = Instant::now();
        let output = command().output().expect("it starts");
        assert!(!output.stdout.is_empty());
        begin.elapsed().as_secs_f64()
    };
    (0..5).map(|_| once()).fold(f64::INFINITY, f64::min)
}

#[test]
#[ignore = "measures time, on a machine that does nothing else"]
fn a_file_takes_at_most_twice_the_time_of_decoding_it() {
    const FILES: usize = 10_000;
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let folder = scratch.path().join("files");
    fs::create_dir(&folder).expect("a folder");
    let requests: String = copies_of_the_corpus(&folder, FILES)
        .iter()
        .enumerate()
        .map(|(number, path)| format!("{number} raw {}\n", path.display()))
        .collect();
    let list = scratch.path().join("requests");
    fs::write(&list, requests).expect("a list");
    let decoding = seconds(|| {
        let mut command = program();
        let requests = File::open(&list).expect("the list");
        command.args(["reference", "serve"]).stdin(requests);
        command
    });
    let linting = seconds(|| {
        let mut command = program();
        command.args(["lint", "-rq", "--format", "csv", "--jobs", "1"]);
        command.arg(&folder);
        command
    });
    let each = |seconds: f64| seconds * 1e6 / FILES as f64;
    println!(
        "{:.1} µs to decode a file, {:.1} µs to lint it: {:.2} times as long",
        each(decoding),
        each(linting),
        linting / decoding
    );
    assert!(linting < 2.0 * decoding);
}

#[test]
fn a_run_that_is_killed_leaves_whole_rows() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let folder = scratch.path().join("files");
    collection(&folder, 3000);
    let mut seen = Vec::new();
    for pause in [5, 20, 40, 80] {
        let out = scratch.path().join("out.csv");
        let mut command = program();
        command.args(["lint", "-r", "--format", "csv"]).arg(&folder);
        command.stdout(File::create(&out).expect("a file"));
        let mut child = command.stderr(Stdio::null()).spawn().expect("it starts");
        std::thread::sleep(Duration::from_millis(pause));
        child.kill().expect("it is killed");
        child.wait().expect("it has ended");
        let text = fs::read_to_string(&out).expect("it is text");
        assert!(text.is_empty() || text.ends_with('\n'), "{text}");
        seen.push(rows(&text).len());
    }
    println!("rows at the end: {seen:?}");
}

/// Files whose names are made to harm whoever prints them.
fn hostile(directory: &Path) -> usize {
    let names: [&[u8]; 9] = [
        b"line\nfeed.ptm",
        b"=HYPERLINK(\"x\").ptm",
        b"@SUM(1,2)",
        b"-rf",
        b"\x1b[2J\x07red.ptm",
        b"\xff\xfe.ptm",
        "c1\u{9b}31m and \u{202e}mtp.ptm".as_bytes(),
        b"semi;colon \"quoted\" 'ptm'",
        b"tab\tand\rreturn",
    ];
    for name in names {
        let file = b"PTM_1.2\nPTM_\x1b[31m\x9b\n";
        fs::write(directory.join(OsStr::from_bytes(name)), file).expect("a file");
    }
    names.len()
}

#[track_caller]
fn is_plain(output: &Output) {
    for text in [&output.stdout, &output.stderr] {
        let text = String::from_utf8(text.clone()).expect("it is UTF-8");
        let control = text.chars().find(|c| c.is_control() && *c != '\n');
        assert!(control.is_none() && !text.contains('\u{202e}'), "{text}");
    }
}

#[test]
fn hostile_names_print_no_control_byte_and_are_no_formulas() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let files = hostile(scratch.path());
    let folder = scratch.path().to_string_lossy().into_owned();
    for format in ["text", "json", "yaml", "csv", "sarif"] {
        is_plain(&run(&["lint", "--format", format, &folder]));
    }
    // Relative to their folder, names begin as they please.
    let mut child = program()
        .current_dir(scratch.path())
        .args(["lint", "--format", "csv", "-0", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let mut list = Vec::new();
    for entry in fs::read_dir(scratch.path()).expect("a folder") {
        list.extend_from_slice(entry.expect("an entry").file_name().as_bytes());
        list.push(0);
    }
    child
        .stdin
        .take()
        .expect("it is piped")
        .write_all(&list)
        .expect("it reads");
    let text = child.wait_with_output().expect("it ends").stdout;
    let rows = rows(&String::from_utf8(text).expect("it is text"));
    assert_eq!(rows.len(), 1 + files);
    for row in &rows[1..] {
        assert!(!row[0].starts_with(['=', '@', '-', '+']), "{}", row[0]);
        assert_eq!(row[1], "damaged", "{}", row[0]);
    }
}

#[test]
fn python_reads_the_rows() {
    if !have_python(&["csv"]) {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let files = hostile(scratch.path());
    let out = run(&[
        "lint",
        "-q",
        "--format",
        "csv",
        &scratch.path().to_string_lossy(),
    ]);
    let path = scratch.path().join("rows.csv");
    fs::write(&path, out.stdout).expect("a file");
    let code = "import csv, sys; rows = list(csv.DictReader(open(sys.argv[1], newline=''), strict=True)); \
                print(len(rows), {len(row) for row in rows}, {row['status'] for row in rows})";
    let output = Command::new("python3")
        .args(["-c", code])
        .arg(&path)
        .output();
    let said = String::from_utf8(output.expect("python3 starts").stdout).expect("it is text");
    assert_eq!(said.trim(), format!("{files} {{11}} {{'damaged'}}"));
}

#[test]
fn what_is_no_file_or_too_large_is_a_row_and_not_read() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let path = |name: &str| scratch.path().join(name);
    let sparse = |name: &str, head: &[u8]| {
        let mut file = File::create(path(name)).expect("a file");
        file.write_all(head).expect("it is written");
        file.set_len(1 << 40).expect("a file system with holes");
    };
    sparse("disk.img", b"");
    sparse("huge.ptm", b"PTM_1.2\nPTM_FORMAT_RGB\n100000\n100000\n");
    symlink(repository("corpus/lrgb/first-lrgb.ptm"), path("link.ptm")).expect("a link");
    symlink(".", path("round")).expect("a link");
    fs::create_dir(path("inner")).expect("a folder");
    fs::write(path("inner/empty"), b"").expect("a file");
    let folder = scratch.path().to_string_lossy().into_owned();
    let found = |args: &[&str]| -> Vec<(String, String)> {
        let rows = csv(args).into_iter().skip(1);
        let name = |path: &str| path.rsplit('/').next().expect("a last part").to_owned();
        rows.map(|row| (name(&row[0]), row[1].clone())).collect()
    };
    let mut expected = vec![
        ("disk.img", "not-a-ptm"),
        ("huge.ptm", "not-judged"),
        ("inner/empty", "not-a-ptm"),
        ("link.ptm", "not-judged"),
        ("round", "not-judged"),
    ];
    let words = |pairs: &[(&str, &str)]| -> Vec<(String, String)> {
        let last = |path: &str| path.rsplit('/').next().expect("a last part").to_owned();
        pairs
            .iter()
            .map(|(a, b)| (last(a), (*b).to_owned()))
            .collect()
    };
    assert_eq!(found(&["-r", &folder]), words(&expected));
    expected.remove(2);
    assert_eq!(found(&[&folder]), words(&expected));
    // What is named is followed.
    let link = path("link.ptm").to_string_lossy().into_owned();
    assert_eq!(found(&[&link]), words(&[("link.ptm", "sound")]));
}

#[test]
fn the_exit_status_is_that_of_the_worst_file() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let other = scratch.path().join("picture.ppm");
    fs::write(&other, b"P6\n").expect("a file");
    let other = other.to_string_lossy().into_owned();
    let [sound, damaged] =
        ["first", "half-payload"].map(|name| repository(&format!("corpus/lrgb/{name}-lrgb.ptm")));
    for (args, status) in [
        (&[&sound[..]][..], 0),
        (&["--limit", "10", &sound], 4),
        (&["--limit", "10", &sound, &other], 3),
        (&[&sound, &other], 3),
        (&[&sound, &other, &damaged], 1),
        (&[&sound, &other, &damaged, "no-such-file"], 2),
        (&["--allow", "PTM-E001", &sound, &other], 0),
        (&["--severity", "PTM-E070=warning", &damaged], 0),
        (
            &[
                "--severity",
                "PTM-E070=warning",
                "--deny-warnings",
                &damaged,
            ],
            1,
        ),
        (&["--severity", "PTM-E070=fatal", &damaged], 2),
        (&["--only", "PTM-W999", &sound], 2),
    ] {
        assert_eq!(
            run(&[&["lint"], args].concat()).status.code(),
            Some(status),
            "{args:?}"
        );
    }
}

#[test]
fn settings_come_from_a_file_and_from_options() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let config = scratch.path().join("lint.yaml");
    fs::write(
        &config,
        "allow: [PTM-W303]\nseverity: { PTM-W304: error }\n",
    )
    .expect("a file");
    let (config, file) = (
        config.to_string_lossy().into_owned(),
        repository("corpus/lum/first-lum.ptm"),
    );
    let row = &csv(&["--config", &config, &file])[1];
    assert_eq!((&row[6][..], &row[9][..]), ("1", "PTM-W304"));
    let row = &csv(&["--config", &config, "--severity", "PTM-W304=info", &file])[1];
    assert_eq!((&row[6][..], &row[8][..]), ("0", "1"));
    let printed = run(&["lint", "--json", "--max", "1", &file]).stdout;
    let printed: Value = serde_json::from_slice(&printed).expect("it is JSON");
    assert_eq!(printed[0]["findings"].as_array().map(Vec::len), Some(1));
    assert_eq!(printed[0]["warnings"], 2);
}

#[test]
fn sarif_has_a_result_for_each_finding_with_its_rule_and_place() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    symlink(".", scratch.path().join("link")).expect("a link");
    fs::write(scratch.path().join("a b%.ptm"), b"PTM_1.2\n").expect("a file");
    let (folder, lum) = (
        scratch.path().to_string_lossy().into_owned(),
        repository("corpus/lum/first-lum.ptm"),
    );
    let printed = run(&["lint", "--format", "sarif", &folder, &lum]).stdout;
    let log: Value = serde_json::from_slice(&printed).expect("it is JSON");
    assert_eq!(log["version"], "2.1.0");
    let run = &log["runs"][0];
    let rules = run["tool"]["driver"]["rules"].as_array().expect("rules");
    let results = run["results"].as_array().expect("results");
    assert_eq!(results.len(), 4);
    let place = |result: &Value| result["locations"][0]["physicalLocation"].clone();
    for result in results {
        let uri = place(result)["artifactLocation"]["uri"].clone();
        assert!(
            uri.as_str().is_some_and(|uri| uri.starts_with("file:///")),
            "{uri}"
        );
        assert!(result["message"]["text"].is_string());
        match result["ruleIndex"].as_u64() {
            Some(index) => {
                assert_eq!(rules[index as usize]["id"], result["ruleId"]);
                assert!(place(result)["region"]["byteOffset"].is_u64());
            }
            // SARIF wants the level `none` of whatever is no failure.
            None => assert_eq!(
                (&result["kind"], &result["level"]),
                (&"open".into(), &"none".into())
            ),
        }
    }
    let uri = place(&results[0])["artifactLocation"]["uri"].clone();
    assert!(
        uri.as_str()
            .is_some_and(|uri| uri.ends_with("/a%20b%25.ptm")),
        "{uri}"
    );
    assert_eq!(results[0]["level"], "error");
}
