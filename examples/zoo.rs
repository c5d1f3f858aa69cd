//! Programs that violate the decoder protocol, each in one way: `zoo KIND VIEW FILE`, `zoo KIND serve`, `zoo KIND capabilities`.
//!
//! They test the harness. The kind `right` is a correct decoder. `tests/it/runner/zoo.rs` lists the expected messages.

use std::fmt::Write as _;
use std::fs;
use std::io::{self, BufRead, Write};
use std::os::unix::fs::symlink;
use std::path::PathBuf;
use std::process::{Command, Stdio, exit};
use std::time::Duration;

use ptm::decode;
use ptm_suite::protocol::frame::{Frame, Samples, View, ViewKind};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        [kind, "capabilities"] => capabilities(kind),
        [kind, "serve"] => serve(kind),
        [kind, view, file] => respond(kind, view, file),
        _ => {
            eprintln!("usage: zoo KIND VIEW FILE, zoo KIND serve, zoo KIND capabilities");
            exit(64);
        }
    }
}

fn respond(kind: &str, view: &str, file: &str) {
    match kind {
        // One fixed output for every file.
        "refuses-all" => exit(65),
        "unsupported-all" => exit(69),
        "exits-1" => exit_with_traceback(1),
        "exits-101" => exit_with_traceback(101),
        "aborts" => std::process::abort(),
        "segfaults" => kill_self("SEGV"),
        "prints-nothing" => exit(0),
        "apologizes" => print_and_exit(b"error: unknown file format\n", 0),
        "accepts-all" => print_and_exit(b"PTM1 raw 1 1 9 u8\n123456789", 0),
        "prints-no-texels" => print_and_exit(b"PTM1 raw 0 0 9 u8\n", 0),

        // Programs that do not end.
        "hangs" => sleep_forever(),
        "hangs-and-ignores-term" => run_shell("trap '' TERM INT HUP; while :; do sleep 1; done"),
        "stops-itself" => run_shell("kill -STOP $PPID"),
        "drips" => drip(view, file),
        "floods" => flood(),
        "closes-stdout-and-runs-on" => close_and_run_on(view, file),
        "closes-everything-and-runs-on" => {
            run_shell(&format!("exec <&- >&- 2>&-; sleep {}", nap()));
        }
        "sleeps-on-slow-files" => {
            sleep_on_slow_file(file);
            answer(view, file, 65, 69);
        }
        "hoards" => hoard(),
        "hoards-by-a-child" => hoard_by_child(),

        // Almost correct frames.
        "cuts-frame" => change(view, file, |bytes| bytes.truncate(bytes.len() - 1)),
        "adds-a-byte" => change(view, file, |bytes| bytes.push(b'\n')),
        "text-mode" => change(view, file, |bytes| {
            let crlf = |&b: &u8| {
                if b == b'\n' {
                    vec![b'\r', b'\n']
                } else {
                    vec![b]
                }
            };
            *bytes = bytes.iter().flat_map(crlf).collect();
        }),
        "wrong-size" => change(view, file, |bytes| {
            *bytes = b"PTM1 raw 1 1 1 u8\nx".to_vec();
        }),
        "announces-too-much" => {
            print_and_exit(b"PTM1 raw 4294967295 4294967295 4294967295 f32\nx", 0);
        }
        "number-out-of-range" => print_and_exit(b"PTM1 raw 99999999999999999999 1 1 u8\nx", 0),
        "upside-down" => change_frame(view, file, upside_down),
        "blue-first" => change_frame(view, file, blue_first),
        "halves" => change_frame(view, file, halves),
        "brightens" => change_frame(view, file, brighten),
        "high-byte-first" => change_frame(view, file, high_byte_first),
        "cuts-large-frames" => change(view, file, |bytes| bytes.truncate(65_536)),

        // Correct answers with other output.
        "chatters" => with_side_effect(view, file, || {
            eprintln!("warning: this is only a test\nerror: it really is");
        }),
        "floods-stderr" => with_side_effect(view, file, || flood_stderr(200)),
        "gigabytes-on-stderr" => with_side_effect(view, file, || {
            if is_lum(file) {
                flood_stderr(16 * 1024);
            }
        }),
        "a-million-writes" => with_side_effect(view, file, || {
            if is_lum(file) {
                trickle(1_000_000);
            }
        }),
        "byte-by-byte" => byte_by_byte(view, file),

        // Correct answers that leave processes or files.
        "leaves-files" => after(view, file, |_| fs::write("litter", "litter")),
        "leaves-a-locked-directory" => after(view, file, |_| {
            try_shell("mkdir -p a/b && touch a/b/c && chmod 0 a/b")
        }),
        "leaves-a-child" => with_side_effect(view, file, || start("sleep", &[&nap()])),
        "leaves-a-grandchild" => with_side_effect(view, file, || {
            start("setsid", &["sh", "-c", &format!("sleep {} & exit", nap())]);
        }),
        "leaves-a-hidden-child" => with_side_effect(view, file, leave_hidden),
        "leaves-a-link" => after(view, file, |_| symlink(precious(), "out")),
        "leaves-a-daemon" => with_side_effect(view, file, leave_daemon),
        "leaves-orphans" => with_side_effect(view, file, leave_orphans),
        "keeps-zombies" => with_side_effect(view, file, keep_zombies),
        "fills-its-scratch" => after(view, file, |_| fill_scratch()),
        "exhausts-descriptors" => after(view, file, |_| exhaust_descriptors()),
        "prints-before-reading" => print_before_reading(view, file),
        "moves-its-directory" => after(view, file, |_| move_directory()),

        // Changed input.
        "deletes-its-input" => after(view, file, |file| fs::remove_file(file)),
        "overwrites-its-input" => after(view, file, |file| {
            fs::remove_file(file)?;
            fs::write(file, "PTM_1.2\n")
        }),
        "links-its-input" => after(view, file, |file| {
            let copy = std::env::temp_dir().join("copy.ptm");
            fs::rename(file, &copy)?;
            symlink(copy, file)
        }),
        "input-becomes-a-pipe" => after(view, file, |file| {
            fs::remove_file(file)?;
            try_shell(&format!("mkfifo '{file}'"))
        }),

        // Refusals.
        "crashes-on-malformed" | "declares-exit-1" => answer(view, file, 1, 69),
        "accepts-malformed" => answer_anything(view, file),
        "unsupported-once" => {
            if fs::read(file).is_ok_and(|bytes| bytes.ends_with(b"\x36\x37\x38\x46\x47\x48")) {
                exit(69);
            }
            answer(view, file, 65, 69);
        }
        "no-lum" | "declares-lum-and-lacks-it" | "is-silent-about-lum" if is_lum(file) => exit(69),
        "no-raw-of-rgb" if view == "raw" && has_format(file, b"PTM_FORMAT_RGB\n") => exit(69),
        "declares-coef-and-lacks-it" if view == "coef" => exit(69),
        "crashes-on-lum" if is_lum(file) => exit_with_traceback(1),

        // Varying answers to equal requests.
        "differs-each-time" => differ(view, file),
        "reads-commas" => read_commas(view, file),
        _ => answer(view, file, 65, 69),
    }
}

/// Response of a correct decoder.
enum Correct {
    Frame(Vec<u8>),
    Malformed,
    Unsupported,
}

fn correct_response(view: &str, file: &str) -> Correct {
    let Ok(view) = view.parse::<View>() else {
        return Correct::Unsupported;
    };
    let file = fs::read(file).unwrap_or_else(|_| exit(66));
    match decode(&file) {
        Ok(ptm) => Correct::Frame(bytes(&Frame::render(&ptm, &view))),
        Err(error) if error.class() == ptm::error::Class::Malformed => Correct::Malformed,
        Err(_) => Correct::Unsupported,
    }
}

fn bytes(frame: &Frame) -> Vec<u8> {
    let mut bytes = Vec::new();
    frame.write(&mut bytes).expect("writing to memory");
    bytes
}

/// Returns the output of a correct decoder, or exits with one of the given statuses if it refuses the file.
fn correct_output(view: &str, file: &str, malformed: i32, unsupported: i32) -> Vec<u8> {
    match correct_response(view, file) {
        Correct::Frame(bytes) => bytes,
        Correct::Malformed => exit(malformed),
        Correct::Unsupported => exit(unsupported),
    }
}

fn answer(view: &str, file: &str, malformed: i32, unsupported: i32) {
    print_and_exit(&correct_output(view, file, malformed, unsupported), 0);
}

fn print_and_exit(bytes: &[u8], status: i32) {
    write_stdout(bytes);
    exit(status);
}

fn has_format(file: &str, format: &[u8]) -> bool {
    fs::read(file).is_ok_and(|bytes| {
        bytes
            .windows(format.len())
            .take(40)
            .any(|part| part == format)
    })
}

fn is_lum(file: &str) -> bool {
    has_format(file, b"PTM_FORMAT_LUM")
}

fn change(view: &str, file: &str, change: fn(&mut Vec<u8>)) {
    let mut bytes = correct_output(view, file, 65, 69);
    change(&mut bytes);
    print_and_exit(&bytes, 0);
}

fn change_frame(view: &str, file: &str, change: fn(&mut Frame)) {
    let mut frame = Frame::read(&correct_output(view, file, 65, 69)).expect("a correct frame");
    change(&mut frame);
    print_and_exit(&bytes(&frame), 0);
}

fn upside_down(frame: &mut Frame) {
    fn turn<T: Copy>(samples: &[T], row: usize) -> Vec<T> {
        samples.chunks(row).rev().flatten().copied().collect()
    }
    let row = (frame.width * frame.channels) as usize;
    frame.samples = match &frame.samples {
        Samples::U8(bytes) => Samples::U8(turn(bytes, row)),
        Samples::F32(values) => Samples::F32(turn(values, row)),
    };
}

fn blue_first(frame: &mut Frame) {
    if let (ViewKind::Rgb, Samples::U8(bytes)) = (frame.view, &mut frame.samples) {
        bytes.chunks_mut(3).for_each(<[u8]>::reverse);
    }
}

fn halves(frame: &mut Frame) {
    match &mut frame.samples {
        Samples::U8(bytes) => bytes.iter_mut().for_each(|byte| *byte /= 2),
        Samples::F32(values) => values.iter_mut().for_each(|value| *value /= 2.0),
    }
}

/// Applies a gamma curve, like an image library that assumes linear light.
fn brighten(frame: &mut Frame) {
    let encoded = |byte: u8| {
        let light = f64::from(byte) / 255.0;
        let value = match light <= 0.003_130_8 {
            true => 12.92 * light,
            false => 1.055 * light.powf(1.0 / 2.4) - 0.055,
        };
        (255.0 * value).round() as u8
    };
    if let (ViewKind::Rgb, Samples::U8(bytes)) = (frame.view, &mut frame.samples) {
        for byte in bytes.iter_mut() {
            *byte = encoded(*byte);
        }
    }
}

fn high_byte_first(frame: &mut Frame) {
    if let Samples::F32(values) = &mut frame.samples {
        let swapped = |value: f32| f32::from_bits(value.to_bits().swap_bytes());
        for value in values.iter_mut() {
            *value = swapped(*value);
        }
    }
}

fn exit_with_traceback(status: i32) {
    eprintln!("Traceback (most recent call last):");
    exit(status);
}

/// Sends itself a signal twice, because Rust's handler ignores the first SIGSEGV from another process.
fn kill_self(signal: &str) {
    let id = std::process::id();
    run_shell(&format!(
        "kill -{signal} {id}; sleep 0.1; kill -{signal} {id}"
    ));
}

/// Sleeps if the file equals one in the directory `ZOO_SLOW_FILES`. The number before the first hyphen in its name is the time in
/// seconds.
fn sleep_on_slow_file(file: &str) {
    let bytes = fs::read(file).unwrap_or_default();
    let directory = std::env::var_os("ZOO_SLOW_FILES").unwrap_or_default();
    for entry in fs::read_dir(directory).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let seconds = name.split('-').next().and_then(|text| text.parse().ok());
        if let (Some(seconds), Ok(true)) =
            (seconds, fs::read(entry.path()).map(|slow| slow == bytes))
        {
            std::thread::sleep(Duration::from_secs_f64(seconds));
        }
    }
}

fn sleep_forever() {
    loop {
        std::thread::sleep(Duration::from_secs(1000));
    }
}

/// Runs a shell command, waits for it, and never returns.
fn run_shell(command: &str) {
    let _ = Command::new("sh").args(["-c", command]).status();
    sleep_forever();
}

fn try_shell(command: &str) -> io::Result<()> {
    Command::new("sh")
        .args(["-c", command])
        .status()
        .map(|_| ())
}

fn start(program: &str, words: &[&str]) {
    let child = Command::new(program)
        .args(words)
        .stdin(Stdio::null())
        .spawn();
    drop(child);
}

/// Returns the seconds for which children sleep: practically endless, and different in each test.
fn nap() -> String {
    std::env::var("ZOO_NAP").unwrap_or_else(|_| "1000.25".to_owned())
}

/// Returns the path of a directory that the harness must not change.
fn precious() -> PathBuf {
    std::env::var_os("ZOO_PRECIOUS").map_or_else(|| PathBuf::from("/nowhere"), PathBuf::from)
}

/// Starts a process in a new session and in the root directory, without an environment.
fn leave_hidden() {
    let child = Command::new("setsid")
        .args(["-f", "sleep", &nap()])
        .env_clear()
        .env("PATH", "/usr/bin:/bin")
        .current_dir("/")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    drop(child);
}

/// Starts a daemon: forks twice, into a new session.
fn leave_daemon() {
    let daemon = format!(
        "(setsid sh -c 'sleep {0} & sleep {0}' &) >&- 2>&- <&-",
        nap()
    );
    let _ = try_shell(&daemon);
}

/// Starts orphaned processes that reveal nothing about their origin and end a moment later.
fn leave_orphans() {
    let orphans = "cd /; for i in 1 2 3 4 5; do env -i setsid -f sleep 0.05; done >&- 2>&- <&-";
    let _ = try_shell(orphans);
}

/// Leaves zombie children.
fn keep_zombies() {
    (0..20).for_each(|_| start("true", &[]));
    std::thread::sleep(Duration::from_millis(20));
}

/// Writes 64 MiB, unless the disk is full or a limit is reached before.
fn fill_scratch() -> io::Result<()> {
    let mut file = fs::File::create("ballast")?;
    let block = vec![b'x'; 1 << 20];
    for _ in 0..64 {
        file.write_all(&block)?;
    }
    Ok(())
}

/// Opens files until the system refuses.
#[expect(
    clippy::unnecessary_wraps,
    reason = "other functions of this type can fail"
)]
fn exhaust_descriptors() -> io::Result<()> {
    let opened: Vec<fs::File> = (0..100_000)
        .map_while(|_| fs::File::open("/dev/null").ok())
        .collect();
    // They stay open until the program exits.
    std::mem::forget(opened);
    Ok(())
}

/// Starts its answer before it reads the file.
fn print_before_reading(view: &str, file: &str) {
    write_stdout(b"PTM1 ");
    let frame = correct_output(view, file, 65, 69);
    print_and_exit(&frame[b"PTM1 ".len()..], 0);
}

/// Replaces its working directory with a link to the precious directory.
fn move_directory() -> io::Result<()> {
    let here = std::env::current_dir()?;
    fs::rename(&here, here.with_extension("moved"))?;
    symlink(precious(), &here)
}

/// Accepts malformed files with an image of one texel.
fn answer_anything(view: &str, file: &str) {
    let bytes = fs::read(file).unwrap_or_default();
    if decode(&bytes).is_ok() {
        answer(view, file, 65, 69);
    }
    let name = view.split(':').next().unwrap_or(view);
    print_and_exit(format!("PTM1 {name} 1 1 1 u8\nx").as_bytes(), 0);
}

fn drip(view: &str, file: &str) {
    for byte in correct_output(view, file, 65, 69) {
        write_stdout(&[byte]);
        std::thread::sleep(Duration::from_secs(1));
    }
    exit(0);
}

#[expect(clippy::large_stack_arrays, reason = "a buffer of a pipe's size")]
fn flood() {
    let block = [b'x'; 65_536];
    while io::stdout().write_all(&block).is_ok() {}
}

#[expect(clippy::large_stack_arrays, reason = "a buffer of a pipe's size")]
fn flood_stderr(blocks: usize) {
    let block = [b'e'; 65_536];
    for _ in 0..blocks {
        let _ = io::stderr().write_all(&block);
    }
}

fn trickle(writes: usize) {
    for _ in 0..writes {
        let _ = io::stderr().write_all(b"e");
    }
}

fn byte_by_byte(view: &str, file: &str) {
    for byte in correct_output(view, file, 65, 69) {
        write_stdout(&[byte]);
    }
    exit(0);
}

fn hoard() {
    let mut hoard = Vec::new();
    loop {
        hoard.push(vec![1_u8; 8 << 20]);
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Allocates memory in a grandchild, in another process group.
fn hoard_by_child() {
    let this = std::env::current_exe().unwrap_or_default();
    let child = Command::new("setsid")
        .arg("-f")
        .arg(this)
        .args(["hoards", "raw", "x"])
        .status();
    drop(child);
    sleep_forever();
}

fn with_side_effect(view: &str, file: &str, action: impl Fn()) {
    action();
    // Run until the harness is killed.
    if std::env::var_os("ZOO_LINGERS").is_some() {
        sleep_forever();
    }
    answer(view, file, 65, 69);
}

fn after(view: &str, file: &str, action: fn(&str) -> io::Result<()>) {
    let response = correct_response(view, file);
    if let Err(error) = action(file) {
        eprintln!("zoo: {error}");
    }
    match response {
        Correct::Frame(bytes) => print_and_exit(&bytes, 0),
        Correct::Malformed => exit(65),
        Correct::Unsupported => exit(69),
    }
}

fn close_and_run_on(view: &str, file: &str) {
    let bytes = correct_output(view, file, 65, 69);
    write_stdout(&bytes);
    // The shell closes its streams and continues. This process waits for it.
    run_shell(&format!("exec >&- 2>&-; sleep {}", nap()));
}

fn differ(view: &str, file: &str) {
    let mut bytes = correct_output(view, file, 65, 69);
    let now = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(0, |time| time.subsec_nanos());
    let last = bytes.len() - 1;
    // The error is at least two, because colors may differ by one.
    bytes[last] = bytes[last].wrapping_add(2 + (now / 64 % 253) as u8);
    print_and_exit(&bytes, 0);
}

/// Reads numbers in its locale: in a locale with decimal commas, it ignores the digits after a point.
fn read_commas(view: &str, file: &str) {
    if !std::env::var("LC_ALL").is_ok_and(|locale| locale.starts_with("de_DE")) || view == "raw" {
        answer(view, file, 65, 69);
    }
    change_frame(view, file, halves);
}

/// Prints the capabilities of a kind. Most kinds have none.
fn capabilities(kind: &str) {
    let formats = "PTM_FORMAT_RGB, LUM, LRGB, PTM_LUT, PTM_C_LUT";
    match kind {
        "declares-lum-and-lacks-it" => {
            print_and_exit(format!("protocol: 1\nformats: [{formats}]\n").as_bytes(), 0);
        }
        "is-silent-about-lum" => print_and_exit(b"protocol: 1\nformats: [RGB, LRGB]\n", 0),
        "declares-rgb-only" => print_and_exit(
            b"protocol: 1\nname: modest\nversion: 0.9\nformats: [RGB]\n",
            0,
        ),
        "declares-coef-and-lacks-it" => print_and_exit(b"protocol: 1\nviews: [raw, coef]\n", 0),
        "declares-coef-only" => print_and_exit(b"protocol: 1\nviews: [coef]\n", 0),
        "declares-exit-1" => print_and_exit(b"protocol: 1\nreject_exit: 1\n", 0),
        "declares-exit-0" => print_and_exit(b"protocol: 1\nreject_exit: 0\n", 0),
        "declares-serve-and-lacks-it" | "serves" => {
            print_and_exit(b"protocol: 1\nmodes: [one-shot, serve]\n", 0);
        }
        kind if kind.starts_with("pipelined") => {
            let declared = b"protocol: 1\nmodes: [one-shot, serve]\npipelined: true\n";
            print_and_exit(declared, 0);
        }
        "declares-everything-and-fails" => {
            print_and_exit(b"protocol: 1\nname: liar\nformats: [RGB]\n", 1);
        }
        "hangs-on-capabilities" => sleep_forever(),
        "floods-on-capabilities" => flood(),
        "bombs-on-capabilities" => print_and_exit(bomb().as_bytes(), 0),
        "babbles-on-capabilities" => print_and_exit(b"\xff\xfe{{{{: [\n- protocol: 1", 0),
        _ => exit(64),
    }
}

/// Returns a short YAML document whose aliases expand to ten billion words.
fn bomb() -> String {
    let mut text = "protocol: 1\na: &a [x, x, x, x, x, x, x, x, x, x]\n".to_owned();
    for (this, last) in ('b'..='j').zip('a'..) {
        let list = vec![format!("*{last}"); 10].join(", ");
        let _ = writeln!(text, "{this}: &{this} [{list}]");
    }
    text + "views: *j\n"
}

/// State of a serving program.
#[derive(Default)]
struct Memory {
    answered: usize,
    last: String,
    hoard: Vec<Vec<u8>>,
}

fn serve(kind: &str) {
    match kind {
        "serves-not" | "declares-serve-and-lacks-it" => exit(64),
        "serves-before-asked" => write_stdout(b"1 reject 65\n"),
        _ if kind.starts_with("pipelined") => return serve_pipelined(kind),
        _ => {}
    }
    let mut memory = Memory::default();
    let mut buffered = Vec::new();
    for line in io::stdin().lock().lines() {
        let line = line.unwrap_or_default();
        let words: Vec<&str> = line.splitn(3, ' ').collect();
        let [sequence, view, file] = words[..] else {
            exit(64)
        };
        let reply = reply(kind, sequence, view, file, &mut memory);
        memory.answered += 1;
        file.clone_into(&mut memory.last);
        if kind == "serves-without-flush" {
            buffered.extend(reply);
        } else {
            write_stdout(&reply);
        }
    }
    write_stdout(&buffered);
}

/// Answers requests that were sent at once together.
fn serve_pipelined(kind: &str) {
    let (mut input, mut memory) = (io::stdin().lock(), Memory::default());
    loop {
        let chunk = input.fill_buf().unwrap_or_default();
        if chunk.is_empty() {
            return;
        }
        let (text, length) = (String::from_utf8_lossy(chunk).into_owned(), chunk.len());
        input.consume(length);
        let mut lines: Vec<&str> = text.lines().collect();
        match kind {
            "pipelined-takes-one" => lines.truncate(1),
            "pipelined-skips-one" if lines.len() > 1 => drop(lines.remove(1)),
            "pipelined-backward" => lines.reverse(),
            "pipelined-ends-early" if lines.len() > 1 => exit(0),
            _ => {}
        }
        for line in lines {
            let words: Vec<&str> = line.splitn(3, ' ').collect();
            let [sequence, view, file] = words[..] else {
                exit(64)
            };
            let is_future = fs::read(file).is_ok_and(|bytes| bytes.starts_with(b"PTM_1.3"));
            match kind {
                "pipelined-crashes-on-version-1-3" if is_future => std::process::abort(),
                "pipelined-hangs-on-version-1-3" if is_future => sleep_forever(),
                _ => write_stdout(&reply(kind, sequence, view, file, &mut memory)),
            }
        }
    }
}

fn write_stdout(bytes: &[u8]) {
    let _ = io::stdout().write_all(bytes);
    let _ = io::stdout().flush();
}

fn reply(kind: &str, sequence: &str, view: &str, file: &str, memory: &mut Memory) -> Vec<u8> {
    let correct = correct_response(view, file);
    let line = |words: &str| format!("{sequence} {words}\n").into_bytes();
    let whole = match &correct {
        Correct::Frame(frame) => [line(&format!("ok {}", frame.len())), frame.clone()].concat(),
        Correct::Malformed => line("reject 65"),
        Correct::Unsupported => line("unsupported this"),
    };
    let lum = is_lum(file);
    match (kind, correct) {
        ("serves-the-number-before", _) => {
            let before = sequence.parse::<u64>().unwrap_or(1) - 1;
            let rest = whole
                .iter()
                .position(|&byte| byte == b' ')
                .unwrap_or_default();
            [before.to_string().as_bytes(), &whole[rest..]].concat()
        }
        ("serves-the-wrong-number", _) => {
            let rest = whole
                .iter()
                .position(|&byte| byte == b' ')
                .unwrap_or_default();
            [b"4711", &whole[rest..]].concat()
        }
        ("serves-interleaved", _) => {
            let (first, second) = whole.split_at(whole.len() / 2);
            [first, &whole, second].concat()
        }
        ("serves-huge-numbers", Correct::Frame(frame)) => {
            [line("ok 18446744073709551615"), frame].concat()
        }
        ("serves-impossible-numbers", Correct::Frame(frame)) => {
            [line("ok 99999999999999999999999"), frame].concat()
        }
        ("serves-without-the-line", Correct::Frame(frame)) => [
            line(&format!(
                "ok {}",
                frame.len() - frame.iter().position(|&b| b == b'\n').unwrap_or_default() - 1
            )),
            frame,
        ]
        .concat(),
        ("serves-bare-frames", Correct::Frame(frame)) => frame,
        ("serves-logs", _) => [b"decoding\n", &whole[..]].concat(),
        ("serves-extra", _) => [&whole[..], b"\n"].concat(),
        ("serves-text-mode", _) => [
            &whole[..whole.iter().position(|&b| b == b'\n').unwrap_or_default()],
            b"\r\n",
        ]
        .concat(),
        ("serves-exit-codes", Correct::Malformed) => line("reject 1"),
        ("serves-five-times", _) if memory.answered == 5 => exit(0),
        ("serves-five-times-and-ignores-the-rest", _) if memory.answered >= 5 => Vec::new(),
        ("serves-until-lum", _) if lum => std::process::abort(),
        ("serves-and-hangs-at-lum", _) if lum => {
            sleep_forever();
            Vec::new()
        }
        ("sleeps-on-slow-files", _) => {
            sleep_on_slow_file(file);
            whole
        }
        ("serves-and-hoards", _) => {
            memory.hoard.push(vec![1; 32 << 20]);
            // Give the harness time to notice it.
            std::thread::sleep(Duration::from_millis(150));
            whole
        }
        ("serves-and-deletes", _) => {
            let _ = fs::remove_file(file);
            whole
        }
        ("serves-and-deletes-later", _) => {
            let _ = fs::remove_file(&memory.last);
            whole
        }
        // After a LUM file, all other images are wrong.
        ("serves-with-leaks", Correct::Frame(mut frame)) if !memory.hoard.is_empty() && !lum => {
            if let Some(last) = frame.last_mut() {
                *last ^= 1;
            }
            [line(&format!("ok {}", frame.len())), frame].concat()
        }
        ("serves-with-leaks", _) => {
            memory.hoard.extend(lum.then(Vec::new));
            whole
        }
        ("serves-other-answers", Correct::Frame(_)) if lum => line("unsupported luminance"),
        _ => whole,
    }
}
