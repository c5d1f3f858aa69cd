//! Programs that answer the decoder protocol wrongly, each in one way: `zoo KIND VIEW FILE`.
//!
//! The harness is tested against them; they are also a list of what wrappers get wrong. `right` is right.

use std::fs;
use std::io::{self, Write};
use std::process::{Command, Stdio, exit};
use std::time::Duration;

use ptm_conform::decode;
use ptm_conform::harness::protocol::{Frame, View};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [kind, view, file] = &words[..] else {
        eprintln!("usage: zoo KIND VIEW FILE");
        exit(64);
    };
    match kind.as_str() {
        "refuses-all" => exit(65),
        "unsupported-all" => exit(69),
        "exits-1" => panicked(1),
        "exits-101" => panicked(101),
        "aborts" => std::process::abort(),
        "segfaults" => die_by("SEGV"),
        "hangs" => sleep_for_ever(),
        "hangs-and-ignores-term" => ignore_term(),
        "says-nothing" => exit(0),
        "apologises" => print_and_exit(b"error: unknown file format\n", 0),
        "accepts-all" => print_and_exit(b"PTM1 raw 1 1 9 u8\n123456789", 0),
        "crashes-on-malformed" => answer(view, file, 1, 69),
        "accepts-malformed" => answer_anything(view, file),
        "drips" => drip(view, file),
        "floods" => flood(),
        "floods-errors" => flood_errors(view, file),
        "chatters" => chatter(view, file),
        "cuts-frame" => change(view, file, |bytes| bytes.truncate(bytes.len() - 1)),
        "adds-a-byte" => change(view, file, |bytes| bytes.push(b'\n')),
        "text-mode" => change(view, file, |bytes| {
            *bytes = bytes
                .iter()
                .flat_map(|&b| {
                    if b == b'\n' {
                        vec![b'\r', b'\n']
                    } else {
                        vec![b]
                    }
                })
                .collect();
        }),
        "wrong-size" => change(view, file, |bytes| {
            *bytes = b"PTM1 raw 1 1 1 u8\nx".to_vec();
        }),
        "leaves-a-child" => leave_child(view, file),
        "deletes-its-input" => after(view, file, |file| fs::remove_file(file)),
        "overwrites-its-input" => after(view, file, |file| {
            fs::remove_file(file)?;
            fs::write(file, "PTM_1.2\n")
        }),
        "closes-stdout-and-runs-on" => close_and_run_on(view, file),
        "leaves-files" => after(view, file, |_| fs::write("litter", "litter")),
        "differs-each-time" => differ(view, file),
        "unsupported-once" => unsupported_once(view, file),
        _ => answer(view, file, 65, 69),
    }
}

/// What a right decoder prints; the status it exits with otherwise.
fn right(view: &str, file: &str, malformed: i32, unsupported: i32) -> Vec<u8> {
    let Ok(view) = view.parse::<View>() else {
        exit(unsupported)
    };
    let file = fs::read(file).unwrap_or_else(|_| exit(66));
    match decode(&file) {
        Ok(ptm) => {
            let mut bytes = Vec::new();
            Frame::of(&ptm, &view)
                .write(&mut bytes)
                .expect("writing to memory");
            bytes
        }
        Err(error) if error.class() == ptm_conform::error::Class::Malformed => exit(malformed),
        Err(_) => exit(unsupported),
    }
}

fn answer(view: &str, file: &str, malformed: i32, unsupported: i32) {
    print_and_exit(&right(view, file, malformed, unsupported), 0);
}

fn print_and_exit(bytes: &[u8], status: i32) {
    let _ = io::stdout().write_all(bytes);
    let _ = io::stdout().flush();
    exit(status);
}

fn change(view: &str, file: &str, change: fn(&mut Vec<u8>)) {
    let mut bytes = right(view, file, 65, 69);
    change(&mut bytes);
    print_and_exit(&bytes, 0);
}

fn panicked(status: i32) {
    eprintln!("Traceback (most recent call last):");
    exit(status);
}

/// Twice, because Rust's own handler lets the first segmentation fault from outside pass.
fn die_by(signal: &str) {
    let kill = format!(
        "kill -{signal} {0}; sleep 0.1; kill -{signal} {0}",
        std::process::id()
    );
    let _ = Command::new("sh").args(["-c", &kill]).status();
    sleep_for_ever();
}

fn sleep_for_ever() {
    loop {
        std::thread::sleep(Duration::from_secs(1000));
    }
}

fn ignore_term() {
    let _ = Command::new("sh")
        .args(["-c", "trap '' TERM INT HUP; while :; do sleep 1; done"])
        .status();
}

/// Accepts what is malformed with the picture of an empty map.
fn answer_anything(view: &str, file: &str) {
    let bytes = fs::read(file).unwrap_or_default();
    if decode(&bytes).is_ok() {
        answer(view, file, 65, 69);
    }
    let (name, kind) = if view == "coef" {
        ("coef", "f32")
    } else if view == "raw" {
        ("raw", "u8")
    } else {
        ("rgb", "u8")
    };
    print_and_exit(format!("PTM1 {name} 0 0 9 {kind}\n").as_bytes(), 0);
}

fn drip(view: &str, file: &str) {
    for byte in right(view, file, 65, 69) {
        let _ = io::stdout().write_all(&[byte]);
        let _ = io::stdout().flush();
        std::thread::sleep(Duration::from_millis(200));
    }
    exit(0);
}

fn flood() {
    let block = [b'x'; 65_536];
    while io::stdout().write_all(&block).is_ok() {}
}

fn flood_errors(view: &str, file: &str) {
    let block = [b'e'; 65_536];
    for _ in 0..200 {
        let _ = io::stderr().write_all(&block);
    }
    answer(view, file, 65, 69);
}

fn chatter(view: &str, file: &str) {
    eprintln!("warning: this is only a test\nerror: it really is");
    answer(view, file, 65, 69);
}

fn leave_child(view: &str, file: &str) {
    let child = Command::new("sleep")
        .arg("1000.25")
        .stdin(Stdio::null())
        .spawn();
    drop(child);
    answer(view, file, 65, 69);
}

fn after(view: &str, file: &str, deed: fn(&str) -> io::Result<()>) {
    let bytes = right(view, file, 65, 69);
    let _ = deed(file);
    print_and_exit(&bytes, 0);
}

fn close_and_run_on(view: &str, file: &str) {
    let bytes = right(view, file, 65, 69);
    let _ = io::stdout().write_all(&bytes);
    let _ = io::stdout().flush();
    // A shell closes its own streams and goes on; this process waits for it.
    let _ = Command::new("sh")
        .args(["-c", "exec >&- 2>&-; sleep 1000.5"])
        .status();
}

fn differ(view: &str, file: &str) {
    let mut bytes = right(view, file, 65, 69);
    let now = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(0, |time| time.subsec_nanos());
    let last = bytes.len() - 1;
    bytes[last] ^= (now / 64) as u8;
    print_and_exit(&bytes, 0);
}

/// 69 to one file only, of a kind that it decodes elsewhere.
fn unsupported_once(view: &str, file: &str) {
    if fs::read(file).is_ok_and(|bytes| bytes.ends_with(b"\x36\x37\x38\x46\x47\x48")) {
        exit(69);
    }
    answer(view, file, 65, 69);
}
