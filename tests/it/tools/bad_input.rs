//! Folders that disappear, files that change while they are read, paths of extreme length, and output that cannot be written.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

use crate::common::{PROGRAM, Workspace, outcome, repository, skip};

fn sound_map() -> Vec<u8> {
    fs::read(repository("corpus/lrgb/first-lrgb.ptm")).expect("a file")
}

/// Runs the program in a shell, which expands `$P` to its path.
fn shell(here: &Workspace, script: &str) -> (i32, String) {
    let mut shell = Command::new("sh");
    shell.args(["-c", script]).env("P", PROGRAM);
    outcome(&shell.current_dir(here.path("")).output().expect("a shell"))
}

#[test]
fn folder_that_disappears_loses_no_row() {
    let here = Workspace::new();
    for file in 0..3000 {
        here.write(&format!("files/a/{file}.ptm"), sound_map());
    }
    here.write("files/b/1.ptm", sound_map());
    let mut command = here.command("lint -rq --format csv --no-header files");
    let mut child = command.stdout(Stdio::piped()).spawn().expect("it starts");
    // The program waits until its first rows are read. At that time, it has listed the folder a, but not b.
    let mut out = child.stdout.take().expect("its output");
    let mut rows = vec![0];
    out.read_exact(&mut rows).expect("a row");
    std::thread::sleep(Duration::from_millis(500));
    fs::remove_dir_all(here.path("files")).expect("a folder");
    out.read_to_end(&mut rows).expect("rows");
    let status = child.wait().expect("it exits").code();
    let rows = String::from_utf8(rows).expect("UTF-8");
    let count = |text: &str| rows.lines().filter(|row| row.contains(text)).count();
    assert_eq!((status, rows.lines().count()), (Some(6), 3001), "{rows}");
    let read = count(".ptm,sound,");
    assert!(read > 0 && read < 3000, "{read}");
    assert_eq!(count("No such file or directory"), 3001 - read);
    assert_eq!(count("files/b,unreadable"), 1);
}

#[test]
fn file_that_grows_while_it_is_read_is_not_judged_by_its_beginning() {
    let here = Workspace::new();
    let header = b"PTM_1.2\nPTM_FORMAT_LRGB\n2000\n2000\n1 1 1 1 1 1\n0 0 0 0 0 0\n";
    let path = here.write("grows.ptm", [&header[..], &vec![7; 30_000_000]].concat());
    let is_linted = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut file = File::options().append(true).open(&path).expect("a file");
            while !is_linted.load(Relaxed) {
                file.write_all(&[7; 64]).expect("space");
            }
        });
        let (status, text) = here.run("lint grows.ptm");
        is_linted.store(true, Relaxed);
        let expected = "grows.ptm: unreadable: the file changed while it was read\n";
        assert_eq!((status, &*text), (6, expected));
    });
}

#[test]
fn long_paths_are_read_or_reported() {
    let here = Workspace::new();
    let name = "0".repeat(250);
    let chain = |levels: usize| vec![&*name; levels].join("/");
    // The lower end is built elsewhere, because the system takes no path of more than 4,095 characters. The relative path of the
    // last folder but one has 5 + 16 · 251 = 4,021 characters.
    here.write(&format!("end/{}/a.ptm", chain(1)), sound_map());
    here.write(&format!("end/{}/a.ptm", chain(2)), sound_map());
    fs::create_dir_all(here.path(&format!("files/{}", chain(14)))).expect("folders");
    let end = here.path(&format!("files/{}", chain(15)));
    fs::rename(here.path("end"), end).expect("a folder");
    let (status, text) = here.run("lint -rq --format csv --no-header files");
    let rows: Vec<&str> = text.lines().collect();
    assert_eq!((status, rows.len()), (6, 2), "{text}");
    assert!(rows[0].contains("0,unreadable,") && rows[0].contains("File name too long"));
    assert!(rows[1].contains("0/a.ptm,sound,"), "{text}");
    let path = rows[1].split(',').next().expect("a path");
    assert_eq!(path.len(), 4027);
    let line = format!("convert --repair --dry-run --out-dir new {path}");
    assert!(here.succeeds(&line).contains(",sound,"));
}

#[test]
fn write_limit_leaves_no_partial_file() {
    let here = Workspace::new();
    let header = b"\nPTM_1.2\nPTM_FORMAT_LRGB\n100\n100\n1 1 1 1 1 1\n0 0 0 0 0 0\n";
    here.write("large.ptm", [&header[..], &vec![7; 90_000]].concat());
    here.write("small.ptm", [b"\n", &sound_map()[..]].concat());
    let (status, text) = shell(
        &here,
        "ulimit -f 40; $P convert --repair --out-dir new large.ptm small.ptm",
    );
    let rows: Vec<&str> = text.lines().skip(1).collect();
    assert_eq!((status, rows.len()), (1, 2), "{text}");
    assert!(rows[0].starts_with("large.ptm,not written,") && rows[0].contains("File too large"));
    assert!(rows[1].starts_with("small.ptm,repaired,new/small.ptm,"));
    let names = fs::read_dir(here.path("new")).expect("a folder");
    let names: Vec<_> = names
        .map(|entry| entry.expect("an entry").file_name())
        .collect();
    assert_eq!(names, ["small.ptm"]);
    assert_eq!(here.read("new/small.ptm"), sound_map());
}

#[test]
fn rows_that_cannot_be_written_are_an_error() {
    if !Path::new("/dev/full").exists() {
        skip("/dev/full");
        return;
    }
    let here = Workspace::new();
    here.write("a.ptm", [b"\n", &sound_map()[..]].concat());
    for line in [
        "lint a.ptm",
        "lint --format jsonl a.ptm",
        "convert --repair --out-dir new a.ptm",
    ] {
        let (status, text) = shell(&here, &format!("$P {line} > /dev/full"));
        let expected = "ptm-conform: cannot write the results: No space left on device\n";
        assert_eq!((status, &*text), (2, expected), "{line}");
    }
    let limited = "ulimit -f 1; $P lint --format csv $(yes a.ptm | head -99) > rows.csv";
    let (status, text) = shell(&here, limited);
    assert_eq!(status, 2);
    assert!(
        text.contains("cannot write the results: File too large"),
        "{text}"
    );
}
