//! Tests of `lint` on collections: one row per file in every output format, bounded memory, and no partial rows if `lint` is
//! killed.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use ptm_suite::kit::digest::sha256;
use serde_json::Value;

use crate::common::{
    PROGRAM, Workspace, have_python, repository, repository_text, run_measured, stdout,
};
use ptm_files::readers::profiles;

/// Runs `lint` with CSV output and returns the cells of each row.
fn lint_csv(here: &Workspace, line: &str) -> Vec<Vec<String>> {
    let output = here
        .command(&format!("lint --format csv -q {line}"))
        .output();
    let output = output.expect("the program starts");
    parse_csv(&String::from_utf8(output.stdout).expect("UTF-8"))
}

/// Runs the program, which may find damaged files, and returns what it prints.
fn printed(here: &Workspace, line: &str) -> String {
    let output = here.command(line).output().expect("the program starts");
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Number of columns without predictions.
const COLUMNS: usize = 20;

/// Parses CSV according to RFC 4180. Cells contain no line feeds, so every line is a row.
fn parse_csv(text: &str) -> Vec<Vec<String>> {
    let row = |line: &str| {
        let (mut cells, mut quoted) = (vec![String::new()], false);
        let mut characters = line.chars().peekable();
        while let Some(character) = characters.next() {
            let cell = cells.last_mut().expect("a cell");
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
        assert!(!quoted && cells.len() == COLUMNS, "{line}");
        cells
    };
    text.lines().map(row).collect()
}

/// Writes files to subfolders of `directory`: LRGB files, damaged files, files that are not PTMs, and LUM files, in turn.
fn write_collection(here: &Workspace, directory: &str, count: usize) {
    let originals = [
        "lrgb/first-lrgb.ptm",
        "lrgb/half-payload-lrgb.ptm",
        "MANIFEST.yaml",
        "lum/first-lum.ptm",
    ];
    let read = |name| fs::read(repository(&format!("corpus/{name}"))).expect("a file");
    let originals = originals.map(read);
    for file in 0..count {
        let bytes = &originals[file % originals.len()];
        let bytes = &bytes[..bytes.len().min(4096)];
        here.write(&format!("{directory}/{}/{file}.ptm", file / 1000), bytes);
    }
}

#[test]
fn memory_does_not_grow_with_the_number_of_files() {
    let here = Workspace::new();
    let [few, many] = [1000, 10_000].map(|files| {
        write_collection(&here, &files.to_string(), files);
        let command = here.command(&format!("lint -rq --format csv {files}"));
        let (linted, memory) = run_measured(command, Path::new("no report"));
        let rows = parse_csv(&linted.text);
        assert_eq!(rows.len(), 1 + files);
        for (status, quarter) in [("sound", 2), ("damaged", 1), ("foreign", 1)] {
            let count = rows.iter().filter(|row| row[1] == status).count();
            assert_eq!(count, files / 4 * quarter, "{status}");
        }
        assert_eq!(linted.status, 1);
        memory
    });
    println!("peak memory: {few} KiB for 1,000 files, {many} KiB for 10,000");
    assert!(many < few + 8 * 1024, "{few} KiB, then {many} KiB");
}

#[test]
fn killed_lint_leaves_complete_rows() {
    let here = Workspace::new();
    write_collection(&here, "files", 3000);
    let mut seen = Vec::new();
    for pause in [5, 20, 40, 80] {
        let mut command = here.command("lint -r --format csv files");
        command.stdout(File::create(here.path("out.csv")).expect("a file"));
        let mut child = command.stderr(Stdio::null()).spawn().expect("it starts");
        std::thread::sleep(Duration::from_millis(pause));
        child.kill().expect("it can be killed");
        child.wait().expect("it exits");
        let text = here.text("out.csv");
        assert!(text.is_empty() || text.ends_with('\n'), "{text}");
        seen.push(parse_csv(&text).len());
    }
    println!("rows before the kill: {seen:?}");
}

/// Prints the rows of the collection in `files` to `out`, and kills the program after `pause`.
fn lint_until_killed(here: &Workspace, options: &str, out: &str, pause: Duration) {
    let mut command = here.command(&format!("lint -r {options} files"));
    command.stdout(File::create(here.path(out)).expect("a file"));
    let mut child = command.stderr(Stdio::null()).spawn().expect("it starts");
    std::thread::sleep(pause);
    child.kill().expect("it can be killed");
    child.wait().expect("it exits");
}

#[test]
fn killed_runs_are_continued_with_the_same_rows() {
    let here = Workspace::new();
    write_collection(&here, "files", 3000);
    for format in ["csv", "jsonl"] {
        let whole = printed(&here, &format!("lint -rq --format {format} files"));
        let mut rows = String::new();
        for round in 0..10 {
            let mut options = format!("--format {format}");
            if round > 0 {
                here.write("rows", &rows);
                options += " --resume rows";
            }
            let pause = Duration::from_millis(5 + 13 * round);
            lint_until_killed(&here, &options, "out", pause);
            let text = here.text("out");
            assert!(whole.starts_with(&text), "a row is missing or differs");
            // A killed run may have printed fewer rows than the run that it continued.
            if text.len() > rows.len() {
                rows = text;
            }
        }
        here.write("rows", &rows);
        let line = format!("lint -rq --format {format} --resume rows files");
        assert_eq!(printed(&here, &line), whole);
    }
}

#[test]
fn only_changed_files_are_read_again() {
    let here = Workspace::new();
    write_collection(&here, "files", 8);
    let rows = |line: &str| printed(&here, line);
    let before = rows("lint -r --format csv files");
    // A mark in an old row shows that the row was not computed again.
    let marked = before.replace("PTM-E070", "PTM-E070 old");
    assert_ne!(marked, before);
    here.write("rows.csv", &marked);
    assert_eq!(rows("lint -r --format csv --resume rows.csv files"), marked);
    assert_eq!(
        rows("lint -r --format csv --resume rows.csv --rehash files"),
        marked
    );
    fs::write(here.path("files/0/1.ptm"), b"PTM_1.2\n").expect("a file");
    let after = rows("lint -r --format csv --resume rows.csv files");
    assert_eq!(
        after,
        rows("lint -r --format csv files").replace("PTM-E070", "PTM-E070 old")
    );
    here.write("empty.csv", "");
    here.write("bom.csv", format!("\u{feff}{before}"));
    here.write("semicolons.csv", before.replace(',', ";"));
    here.assert_lines(
        "
2 | lint --resume rows.csv --format jsonl files | --format csv
2 | lint --resume rows.csv --format csv --for relight files | the same --for
2 | lint --resume files/0/1.ptm --format csv files | not the rows
2 | lint --resume none.csv --format csv files | none.csv
1 | lint --resume empty.csv --format csv -r files | empties ROWS before it is read
1 | lint --resume rows.csv --format csv -r files | 7 of 8 rows are those of rows.csv
2 | lint --baseline bom.csv files | a spreadsheet seems to have saved them
2 | lint --baseline semicolons.csv files | a spreadsheet seems to have saved them
2 | lint --renew files | --baseline
2 | lint --baseline rows.csv --shard 1/2 files | cannot be used with
2 | lint --baseline rows.csv --json files | cannot be used with",
    );
}

#[test]
fn a_baseline_reports_changes_only() {
    let here = Workspace::new();
    write_collection(&here, "files", 8);
    for format in ["csv", "jsonl"] {
        let rows = printed(&here, &format!("lint -r --format {format} files"));
        here.write(format, rows);
    }
    here.assert_lines(
        "
0 | lint -rq --baseline csv files |
0 | lint -rq --baseline jsonl files |",
    );
    let quiet = here.command("lint -rq --baseline csv files").output();
    let quiet = quiet.expect("the program starts");
    assert_eq!((quiet.stdout, quiet.stderr), (Vec::new(), Vec::new()));

    let sound = fs::read(here.path("files/0/0.ptm")).expect("a file");
    here.write("files/0/1.ptm", &sound);
    here.write("files/0/4.ptm", &sound[..sound.len() - 1]);
    here.write("files/0/new.ptm", &sound);
    let mut changed = sound.clone();
    *changed.last_mut().expect("a byte") ^= 1;
    here.write("files/0/0.ptm", &changed);
    fs::remove_file(here.path("files/0/7.ptm")).expect("a file");
    for format in ["csv", "jsonl"] {
        let output = here
            .command(&format!("lint -rq --baseline {format} files"))
            .output();
        let output = output.expect("the program starts");
        let text = String::from_utf8(output.stdout).expect("UTF-8");
        for line in [
            "files/0/0.ptm: changed\n",
            "files/0/1.ptm: repaired\n",
            "files/0/4.ptm: newly damaged\n",
            "files/0/new.ptm: new, sound\n",
            "files/0/7.ptm: missing\n",
        ] {
            assert!(text.contains(line), "{line} is not in:\n{text}");
        }
        assert_eq!(output.status.code(), Some(1));
    }
}

#[test]
fn reports_of_every_kind_obey_the_color_option() {
    let here = Workspace::new();
    write_collection(&here, "files", 4);
    here.write("rows", printed(&here, "lint -r --format csv files"));
    let damaged = here.read("files/0/1.ptm");
    here.write("files/0/0.ptm", damaged);
    for line in ["lint -r", "lint -r --baseline rows", "lint -r --for all"] {
        let is_colored = |line: String| printed(&here, &line).contains('\u{1b}');
        assert!(!is_colored(format!("{line} files")));
        assert!(!is_colored(format!("{line} --color never files")));
        assert!(is_colored(format!("{line} --color always files")), "{line}");
    }
}

/// Returns the commands of the section "Every night" of the documentation, for the folder `files`.
fn nightly_commands() -> Vec<String> {
    let text = repository_text("docs/archives.md");
    let (_, section) = text.split_once("## Every night\n").expect("the section");
    let lines = section.lines().skip_while(|line| line.is_empty());
    let lines = lines.take_while(|line| line.starts_with("    "));
    lines
        .map(|line| line.trim().replace("/archive", "files"))
        .collect()
}

#[test]
fn the_nightly_commands_report_every_change_once() {
    let here = Workspace::new();
    write_collection(&here, "files", 8);
    let commands = nightly_commands();
    let [first, nightly] = &commands[..] else {
        panic!("two commands: {commands:?}");
    };
    let run = |command: &str| {
        let folder = Path::new(PROGRAM).parent().expect("a folder");
        let path = std::env::var("PATH").expect("a path");
        let mut shell = Command::new("sh");
        shell.args(["-c", command]).current_dir(here.path("."));
        shell.env("PATH", format!("{}:{path}", folder.display()));
        let output = shell.output().expect("a shell");
        let text = [output.stdout, output.stderr].concat();
        let text = String::from_utf8(text).expect("UTF-8");
        (output.status.code().expect("a status"), text)
    };
    assert_eq!(run(first), (1, String::new()));
    let quiet = (0, String::new());
    assert_eq!(run(nightly), quiet);
    let sound = here.read("files/0/0.ptm");
    here.write("files/0/new.ptm", &sound);
    assert_eq!(
        run(nightly),
        (0, "files/0/new.ptm: new, sound\n".to_owned())
    );
    assert_eq!(run(nightly), quiet);
    here.write("files/0/0.ptm", [&sound[..], b"\n"].concat());
    assert_eq!(run(nightly), (1, "files/0/0.ptm: changed\n".to_owned()));
    assert_eq!(run(nightly), quiet);
    assert_eq!(
        here.text("rows.csv"),
        printed(&here, "lint -rq --format csv files")
    );
    // A disk that is not mounted.
    fs::rename(here.path("files"), here.path("away")).expect("a folder");
    fs::create_dir(here.path("files")).expect("a folder");
    let (status, text) = run(nightly);
    assert!(status == 1 && text.contains("not renewed"), "{text}");
    fs::remove_dir(here.path("files")).expect("an empty folder");
    assert!(run(nightly).1.contains("not renewed"));
    fs::rename(here.path("away"), here.path("files")).expect("a folder");
    assert_eq!(run(nightly), quiet);
}

#[test]
fn spellings_of_a_path_are_equal() {
    let here = Workspace::new();
    write_collection(&here, "a/files", 12);
    write_collection(&here, "other/mount/files", 12);
    here.write("rows", printed(&here, "lint -r --format csv a/files"));
    let absolute = here.path("a/files");
    for folder in ["./a/files", "a//files/", &absolute.display().to_string()] {
        assert_eq!(
            here.run(&format!("lint -rq --baseline rows {folder}")),
            (0, String::new())
        );
    }
    let part = |folder: &str, directory: &str| {
        let line = format!("lint -rq --shard 2/3 --format csv --no-header {folder}");
        let output = here
            .command(&line)
            .current_dir(here.path(directory))
            .output();
        let text = String::from_utf8(output.expect("the program starts").stdout).expect("UTF-8");
        let names = text.lines().map(|line| {
            let name = line.split(',').next().expect("a name");
            name.rsplit('/').take(2).collect::<Vec<_>>().join(" ")
        });
        names.collect::<Vec<String>>()
    };
    let expected = part("a/files", ".");
    assert!(expected.len() > 1 && expected.len() < 12);
    for (folder, directory) in [
        ("./a/files/", "."),
        (".", "a/files"),
        ("other/mount/files", "."),
    ] {
        assert_eq!(part(folder, directory), expected, "{folder}");
    }
}

#[test]
fn parts_contain_every_file_once() {
    let here = Workspace::new();
    write_collection(&here, "files", 40);
    let rows = |options: &str| {
        let line = format!("lint -r --format csv --no-header {options} files");
        let text = printed(&here, &line);
        let mut rows: Vec<String> = text.lines().map(str::to_owned).collect();
        rows.sort_unstable();
        rows
    };
    let parts = ["--shard 1/3", "--shard 2/3", "--shard 3/3"].map(rows);
    assert!(parts.iter().all(|part| part.len() > 4));
    let mut all = parts.concat();
    all.sort_unstable();
    assert_eq!(all, rows(""));
}

#[test]
fn photographs_beside_maps_are_counted_only() {
    let here = Workspace::new();
    here.copy_from_corpus("lrgb/first-lrgb.ptm");
    let map = fs::read(here.path("first-lrgb.ptm")).expect("a file");
    here.write("files/IMG_0.JPG", b"\xff\xd8\xff");
    here.write("files/map without a suffix", &map);
    here.write("files/COIN.PTM", &map);
    here.write("files/line.ptm", [b"\n", &map[..]].concat());
    here.write("files/module.ptm", b"\x60PTM module");
    here.write("files/coin.ptm.bak", &map);
    here.assert_lines(
        "
1 | lint -r files | not checked: 1 in folders, neither named .ptm nor beginning with PTM_
1 | lint -r files | files/line.ptm: damaged: 1 error, 0 warnings, 0 infos; repairable
1 | lint -r files | files/module.ptm: foreign
0 | lint -r files --name '*.bak' | sound: 0 errors
5 | lint -r files --name *.none | no file to check among 6 files
3 | lint files/IMG_0.JPG | foreign
0 | convert --repair files/line.ptm -o repaired.ptm | removed 1 byte before PTM_1.2",
    );
    assert_eq!(fs::read(here.path("repaired.ptm")).expect("a file"), map);
}

#[test]
fn lost_and_foreign_files_have_digests_and_no_error_counts() {
    let here = Workspace::new();
    here.copy_from_corpus("lrgb/first-lrgb.ptm");
    let map = here.read("first-lrgb.ptm");
    let long = [&[0; 512][..], &map, &[7; 5000]].concat();
    here.write("files/lost.ptm", &long);
    here.write("files/zeros.ptm", [0; 100]);
    here.write("files/empty.ptm", "");
    let foreign: [(&str, Vec<u8>, &str); 9] = [
        ("archive", b"\x1f\x8b\x08".to_vec(), "a gzip archive"),
        ("photo", b"\xff\xd8\xff\xe0".to_vec(), "a JPEG image"),
        ("scan", b"II*\0".to_vec(), "a TIFF image"),
        ("error", b"\n<!DOCTYPE HTML>".to_vec(), "an HTML page"),
        ("mac", [&[0; 128][..], &map].concat(), "a PTM in MacBinary"),
        (
            "text",
            map.iter().flat_map(|&byte| [byte, 0]).collect(),
            "UTF-16",
        ),
        ("mail", b"UFRNXzEuMgo=".to_vec(), "base64"),
        (
            "comment",
            [b"# a comment\n", &map[..]].concat(),
            "a PTM after 12 other bytes",
        ),
        (
            "module",
            [&b"title"[..], &[9; 9000]].concat(),
            "expected PTM_1.2",
        ),
    ];
    for (name, bytes, _) in &foreign {
        here.write(&format!("files/{name}.ptm"), bytes);
    }
    let rows = lint_csv(&here, "files");
    let row = |name: &str| {
        let file = format!("files/{name}.ptm");
        rows.iter().find(|row| row[0] == file).expect("a row")
    };
    for (name, bytes, kind) in &foreign {
        let row = row(name);
        assert_eq!(
            (&*row[1], &*row[6], &*row[9]),
            ("foreign", "0", ""),
            "{row:?}"
        );
        assert!(row[10].contains(kind), "{row:?}");
        assert_eq!(row[11], sha256(bytes));
    }
    for name in ["lost", "zeros", "empty"] {
        assert_eq!((&*row(name)[1], &*row(name)[9]), ("damaged", "PTM-E004"));
        assert!(row(name)[19].contains("nothing is left"));
    }
    assert_eq!(row("lost")[11], sha256(&long));
    // A change after the first bytes is found.
    here.write("rows", printed(&here, "lint --format csv files"));
    here.write(
        "files/module.ptm",
        [&b"title"[..], &[9; 8999], b"x"].concat(),
    );
    here.exits(1, "lint -q --baseline rows files");
}

/// File names that could harm programs that print them.
const HOSTILE_NAMES: [&[u8]; 9] = [
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

/// Creates a workspace whose directory `files` contains files with hostile names.
fn workspace_with_hostile_names() -> Workspace {
    let here = Workspace::new();
    fs::create_dir(here.path("files")).expect("a folder");
    for name in HOSTILE_NAMES {
        let path = here.path("files").join(OsStr::from_bytes(name));
        fs::write(path, b"PTM_1.2\nPTM_\x1b[31m\x9b\n").expect("a file");
    }
    here
}

#[track_caller]
fn assert_no_control_characters(output: &Output) {
    for text in [&output.stdout, &output.stderr] {
        let text = String::from_utf8(text.clone()).expect("UTF-8");
        let control = text.chars().find(|c| c.is_control() && *c != '\n');
        assert!(control.is_none() && !text.contains('\u{202e}'), "{text}");
    }
}

#[test]
fn hostile_names_are_escaped() {
    let here = workspace_with_hostile_names();
    for format in ["text", "json", "jsonl", "yaml", "csv", "html", "sarif"] {
        let output = here
            .command(&format!("lint --format {format} files"))
            .output();
        assert_no_control_characters(&output.expect("the program starts"));
    }
    // Names relative to their folder may begin with any byte.
    here.write(
        "list",
        HOSTILE_NAMES.map(|name| [name, b"\0"].concat()).concat(),
    );
    let output = here
        .command("lint --format csv -0 -")
        .current_dir(here.path("files"))
        .stdin(File::open(here.path("list")).expect("the list"))
        .output();
    let text = output.expect("the program starts").stdout;
    let rows = parse_csv(&String::from_utf8(text).expect("UTF-8"));
    assert_eq!(rows.len(), 1 + HOSTILE_NAMES.len());
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
    let here = workspace_with_hostile_names();
    let output = here.command("lint -q --format csv files").output();
    here.write("rows.csv", output.expect("the program starts").stdout);
    let code = "import csv, sys; rows = list(csv.DictReader(open(sys.argv[1], newline=''), strict=True)); \
                print(len(rows), {len(row) for row in rows}, {row['status'] for row in rows})";
    let mut python = Command::new("python3");
    let text = stdout(python.args(["-c", code]).arg(here.path("rows.csv")));
    assert_eq!(
        text.trim(),
        format!("{} {{{COLUMNS}}} {{'damaged'}}", HOSTILE_NAMES.len())
    );
}

#[test]
fn special_and_large_files_are_listed_but_not_read() {
    let here = Workspace::new();
    let sparse = |name: &str, head: &[u8]| {
        let file = File::options().write(true).open(here.write(name, head));
        let resized = file.and_then(|file| file.set_len(1 << 40));
        resized.expect("a file system with holes");
    };
    sparse("files/disk.img", b"");
    sparse(
        "files/huge.ptm",
        b"PTM_1.2\nPTM_FORMAT_RGB\n100000\n100000\n",
    );
    let target = repository("corpus/lrgb/first-lrgb.ptm");
    symlink(target, here.path("files/link.ptm")).expect("a link");
    symlink(".", here.path("files/round")).expect("a link");
    here.write("files/inner/empty.PTM", b"");
    here.write("files/inner/photograph.jpg", b"JFIF");
    let found = |line: &str| {
        let row = |row: &Vec<String>| format!("{} {}", row[0], row[1]);
        lint_csv(&here, line)[1..]
            .iter()
            .map(row)
            .collect::<Vec<_>>()
    };
    let mut expected = vec![
        "files/huge.ptm not-judged",
        "files/inner/empty.PTM damaged",
        "files/link.ptm not-judged",
    ];
    assert_eq!(found("-r files"), expected);
    expected.remove(1);
    assert_eq!(found("files"), expected);
    // Links on the command line are followed.
    assert_eq!(found("files/link.ptm"), ["files/link.ptm sound"]);
}

#[test]
fn exit_status_is_determined_by_the_worst_file() {
    let here = Workspace::new();
    here.write("other.ppm", b"P6\n");
    here.write("unknown-key.yaml", "alow: []\n");
    here.write("version-1.1.ptm", "PTM_1.1\nPTM_FORMAT_LRGB\n");
    here.copy_from_corpus("lrgb/first-lrgb.ptm");
    here.copy_from_corpus("lrgb/half-payload-lrgb.ptm");
    let table = "
0 | lint SOUND |
4 | lint --limit 10 SOUND |
3 | lint --limit 10 SOUND other.ppm |
3 | lint other.ppm | other.ppm: foreign: expected PTM_1.2
3 | lint SOUND other.ppm | other.ppm: foreign: expected PTM_1.2
1 | lint SOUND other.ppm DAMAGED |
1 | lint SOUND other.ppm DAMAGED no-such-file |
6 | lint SOUND other.ppm no-such-file | no-such-file: unreadable
3 | lint --allow PTM-E001 SOUND other.ppm |
4 | lint version-1.1.ptm | version-1.1.ptm: not judged: the file has a format version other than 1.2
1 | lint --severity PTM-E070=warning DAMAGED |
1 | lint --allow PTM-E070 DAMAGED | damaged: 0 errors, 0 warnings, 0 infos (1 error not shown)
1 | lint --severity PTM-E070=warning --deny-warnings DAMAGED |
2 | lint --severity PTM-E070=fatal DAMAGED |
2 | lint --only PTM-W999 SOUND |
1 | lint --only PTM-E070 --only PTM-W101 DAMAGED |
1 | lint --only PTM-W101 DAMAGED |
2 | lint --config unknown-key.yaml SOUND | alow";
    let table = table.replace("SOUND", "first-lrgb.ptm");
    here.assert_lines(&table.replace("DAMAGED", "half-payload-lrgb.ptm"));
}

#[test]
fn settings_come_from_a_file_and_from_options() {
    let here = Workspace::new();
    here.copy_from_corpus("lum/first-lum.ptm");
    here.write(
        "lint.yaml",
        "allow: [PTM-W303, PTM-W313]\nseverity: { PTM-W304: error }\n",
    );
    let row = &lint_csv(&here, "--config lint.yaml first-lum.ptm")[1];
    assert_eq!((&row[6][..], &row[9][..]), ("1", "PTM-W304"));
    let row = &lint_csv(
        &here,
        "--config lint.yaml --severity PTM-W304=info first-lum.ptm",
    )[1];
    assert_eq!((&row[6][..], &row[8][..]), ("0", "1"));
    let output = here.command("lint --json --max 1 first-lum.ptm").output();
    let printed = output.expect("the program starts").stdout;
    let printed: Value = serde_json::from_slice(&printed).expect("JSON");
    assert_eq!(printed[0]["findings"].as_array().map(Vec::len), Some(1));
    assert_eq!(printed[0]["warnings"], 3);
}

#[test]
fn sarif_lists_each_finding_with_rule_and_location() {
    let here = Workspace::new();
    here.write("files/a b%.ptm", b"PTM_1.2\n");
    symlink(".", here.path("files/link.ptm")).expect("a link");
    here.copy_from_corpus("lum/first-lum.ptm");
    let paths = ["files", "first-lum.ptm", "none.ptm"].map(|name| here.path(name));
    let output = here.command("lint --format sarif").args(paths).output();
    let printed = output.expect("the program starts").stdout;
    let log: Value = serde_json::from_slice(&printed).expect("JSON");
    assert_eq!(log["version"], "2.1.0");
    let run = &log["runs"][0];
    let rules = run["tool"]["driver"]["rules"].as_array().expect("rules");
    let results = run["results"].as_array().expect("results");
    assert_eq!(results.len(), 6);
    let place = |result: &Value| result["locations"][0]["physicalLocation"].clone();
    let uri = |result: &Value| {
        let uri = place(result)["artifactLocation"]["uri"].clone();
        uri.as_str().expect("an address").to_owned()
    };
    for result in results {
        assert!(uri(result).starts_with("file:///"), "{result}");
        assert!(result["message"]["text"].is_string());
        if let Some(index) = result["ruleIndex"].as_u64() {
            assert_eq!(rules[index as usize]["id"], result["ruleId"]);
            assert!(place(result)["region"]["byteOffset"].is_u64());
            continue;
        }
        // SARIF requires the level `none` for a result that is not a failure.
        let expected = match uri(result).ends_with("none.ptm") {
            true => ["fail", "error"],
            false => ["open", "none"],
        };
        assert_eq!([&result["kind"], &result["level"]], expected);
    }
    assert!(uri(&results[0]).ends_with("/a%20b%25.ptm"), "{log}");
    assert_eq!(results[0]["level"], "error");
}

#[test]
fn many_files_are_repaired_at_once() {
    let here = Workspace::new();
    let sound = fs::read(repository("corpus/lrgb/first-lrgb.ptm")).expect("a file");
    here.write("a/sound.ptm", &sound);
    here.write("a/line.ptm", [b"\n", &sound[..]].concat());
    here.write("b/line.ptm", [b"\n", &sound[..]].concat());
    here.write("b/long.ptm", [&sound[..], &[0; 1000]].concat());
    here.write("b/short.ptm", &sound[..sound.len() - 1]);
    let files = "a/sound.ptm a/line.ptm b/line.ptm b/long.ptm b/short.ptm none.ptm";
    let results = |options: &str| -> Vec<String> {
        let text = printed(&here, &format!("convert --repair {options} {files}"));
        let rows = text.lines().skip(1);
        rows.map(|row| row.split(',').nth(1).expect("a result").to_owned())
            .collect()
    };
    let expected = [
        "sound",
        "repairable",
        "not written",
        "repairable",
        "not repairable",
        "unreadable",
    ];
    assert_eq!(results("--dry-run --out-dir new"), expected);
    assert!(!here.path("new").exists());
    let expected = expected.map(|result| result.replace("repairable", "repaired"));
    let expected = expected.map(|result| result.replace("not repaired", "not repairable"));
    assert_eq!(results("--out-dir new"), expected);
    for name in ["new/line.ptm", "new/long.ptm"] {
        assert_eq!(fs::read(here.path(name)).expect("a file"), sound);
    }
    assert!(
        results("--out-dir new")
            .iter()
            .all(|result| result != "repaired")
    );
    here.assert_lines(
        "
1 | convert --repair --out-dir new2 b/short.ptm | not repairable
0 | convert --repair --out-dir new2 a/line.ptm | removed 1 byte before PTM_1.2
0 | convert --repair --out-dir new2 a/sound.ptm | sound
2 | convert --repair a/line.ptm b/long.ptm -o c.ptm | expected one file",
    );
}

#[test]
fn folders_and_lists_are_repaired() {
    let here = Workspace::new();
    let sound = fs::read(repository("corpus/lrgb/first-lrgb.ptm")).expect("a file");
    for name in ["a/line.ptm", "a/b/line.ptm", "a/b/c/line.ptm"] {
        here.write(&format!("files/{name}"), [b"\n", &sound[..]].concat());
    }
    here.write("files/a/photo.jpg", b"\xff\xd8\xff");
    let repaired = |line: &str| {
        let text = here.run(line).1;
        text.lines()
            .filter(|row| row.contains(",repaired,"))
            .count()
    };
    assert_eq!(repaired("convert --repair --out-dir flat files/a"), 1);
    assert_eq!(repaired("convert --repair --out-dir deep -r files"), 3);
    assert_eq!(here.read("deep/a/b/c/line.ptm"), sound);
    assert!(!here.path("deep/a/photo.jpg").exists());
    assert_eq!(repaired("convert --repair --out-dir deep -r files"), 0);
    here.write("list", b"files/a/line.ptm\0files/a/b/line.ptm\0");
    let mut command = here.command("convert --repair --out-dir listed -0 -");
    command.stdin(File::open(here.path("list")).expect("the list"));
    let text = stdout_of_any_status(&mut command);
    assert!(
        text.contains("files/a/line.ptm,repaired")
            && text.contains("files/a/b/line.ptm,not written")
    );
    here.exits(2, "convert --repair -r files -o none.ptm");
}

/// Returns what a command prints to standard output, whatever its exit status is.
fn stdout_of_any_status(command: &mut Command) -> String {
    let output = command.output().expect("the program starts");
    String::from_utf8(output.stdout).expect("UTF-8")
}

#[test]
fn totals_count_the_predictions_of_each_reader() {
    let here = Workspace::new();
    write_collection(&here, "files", 8);
    let text = printed(&here, "lint -r --for relight,joncooper files");
    let totals: Vec<&str> = text.lines().rev().take(2).collect();
    for (line, reader) in totals.iter().zip(["joncooper", "relight"]) {
        assert!(line.starts_with(&format!("  in {reader}: ")), "{line}");
        assert!(line.contains("same") && line.contains("nothing"), "{line}");
    }
}

#[test]
fn known_readers_are_listed_in_the_documentation() {
    let text = repository_text("docs/archives.md");
    for profile in profiles() {
        let title = profile.title.as_ref();
        let title = title.map_or_else(String::new, |title| format!("{title}, "));
        let row = format!("| {} | {title}{} | ", profile.name, profile.reader);
        assert!(text.contains(&row), "{row}");
    }
    let here = Workspace::new();
    here.assert_lines(
        "
0 | explain hp-java | HP's Java viewer
0 | explain rtiviewer | shows files of version 1.1, in the format LRGB",
    );
}

#[test]
fn a_page_shows_totals_thumbnails_and_findings() {
    let here = Workspace::new();
    write_collection(&here, "files", 8);
    here.write("files/<b>&.ptm", b"PTM_1.2\n");
    here.write("files/photo.jpg", b"");
    let output = here
        .command("lint -rq --format html files")
        .env("SOURCE_DATE_EPOCH", "86400")
        .output();
    let page = String::from_utf8(output.expect("the program starts").stdout).expect("UTF-8");
    let version = env!("CARGO_PKG_VERSION");
    assert!(page.contains("<h1>PTM files in files</h1>"));
    assert!(page.contains(&format!("1970-01-02, ptm-conform {version}")));
    assert!(page.contains("<article data-status=\"foreign\">"));
    assert_eq!(page.matches("<article ").count(), 9);
    assert_eq!(page.matches("data:image/png;base64,").count(), 4);
    assert!(page.contains("9 files; 1 in folders that are not PTM files were not checked"));
    assert!(page.contains("files/&lt;b&gt;&amp;.ptm") && !page.contains("<b>&"));
    assert!(page.contains("PTM-E070") && page.ends_with("</html>\n"));
    assert!(!page.contains("http"));
}
