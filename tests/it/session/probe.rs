//! One broken script for each diagnosis of `probe`.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use crate::common::{have, program, repository};

/// Runs `probe OPTIONS… -- WORDS…` in a directory; its status and what it printed.
fn probe_in(directory: &Path, options: &[&str], words: &[&str]) -> (i32, String) {
    let output = program()
        .current_dir(directory)
        .env_remove("PYTHONUNBUFFERED")
        .arg("probe")
        .args(options)
        .arg("--")
        .args(words)
        .output()
        .expect("the program starts");
    let text = [output.stdout, output.stderr].concat();
    (
        output.status.code().unwrap_or(-1),
        String::from_utf8_lossy(&text).into_owned(),
    )
}

fn write(path: &Path, text: &[u8], mode: u32) {
    fs::write(path, text).expect("a file");
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).expect("permissions");
}

/// A shell script around the reference: `right` is the call that answers rightly.
fn shell(body: &str) -> String {
    format!(
        "#!/bin/sh\nright() {{ '{}' reference \"$@\"; }}\n{body}\n",
        env!("CARGO_BIN_EXE_ptm-conform")
    )
}

/// A script is told this, and ends so.
#[track_caller]
fn is_told(text: &str, status: i32, says: &[&str]) -> String {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    write(&scratch.path().join("decoder"), text.as_bytes(), 0o755);
    let (found, told) = probe_in(scratch.path(), &[], &["./decoder"]);
    for says in says {
        assert!(told.contains(says), "{says:?} in:\n{told}");
    }
    assert_eq!(found, status, "{told}");
    told
}

/// A copy of the Python decoder with one line changed.
fn python(find: &str, replace: &str) -> String {
    let text =
        fs::read_to_string(repository("examples/decoders/ptm_decoder.py")).expect("the decoder");
    assert_eq!(text.matches(find).count(), 1, "{find}");
    text.replace(find, replace)
}

#[test]
fn a_right_decoder_is_ready() {
    let told = is_told(
        &shell("right \"$@\" || case $? in 65) exit 65;; *) exit 69;; esac"),
        0,
        &["ready. Next: ptm-conform check -- ./decoder"],
    );
    assert!(
        !told.contains('✗') && told.contains("✓ an unknown view: exited with 69"),
        "{told}"
    );
    if have("python3") {
        let told = is_told(
            &python("serve(sys.stdin.buffer", "serve(sys.stdin.buffer"),
            0,
            &[
                "✓ serve: it ends when its input ends",
                "✓ capabilities: declared",
            ],
        );
        assert!(!told.contains('✗'), "{told}");
    }
}

#[test]
fn commands_that_cannot_be_started() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let here = scratch.path();
    let right = shell("right \"$@\"");
    write(&here.join("plain.py"), b"print('hello')\n", 0o644);
    write(&here.join("no-line"), b"print('hello')\n", 0o755);
    write(&here.join("crlf"), b"#!/bin/sh\r\nexit 0\r\n", 0o755);
    write(&here.join("bom"), b"\xef\xbb\xbf#!/bin/sh\n", 0o755);
    write(
        &here.join("lost"),
        b"#!/usr/bin/no-such-interpreter -x\n",
        0o755,
    );
    write(&here.join("empty"), b"", 0o755);
    write(&here.join("windows.exe"), b"MZ\x90\0", 0o755);
    write(&here.join("some.jar"), b"PK\x03\x04", 0o755);
    write(&here.join("in-this-directory"), right.as_bytes(), 0o755);
    let mut elf = b"\x7fELF\x02\x01\x01\0\0\0\0\0\0\0\0\0\x02\0".to_vec();
    elf.extend(
        if cfg!(target_arch = "s390x") {
            62u16
        } else {
            22
        }
        .to_le_bytes(),
    );
    elf.extend([0; 100]);
    write(&here.join("elsewhere"), &elf, 0o755);
    for (words, says, next) in [
        (
            &["./no-such-decoder"][..],
            "no such file",
            "name the decoder by a path",
        ),
        (
            &["no-such-decoder-in-path"],
            "no program of this name is in PATH",
            "name the decoder",
        ),
        (
            &["in-this-directory"],
            "looked up in PATH only",
            "write ./in-this-directory",
        ),
        (
            &["python3 plain.py"],
            "no program of this name",
            "several words: write them without quotation marks, -- python3 plain.py",
        ),
        (
            &["sh", "no-such-script.sh"],
            "no-such-script.sh: no such file in this directory",
            "by a path that leads to it",
        ),
        (&["."], "is a directory", "name the program in it"),
        (
            &["./plain.py"],
            "is not executable",
            "chmod +x ./plain.py, or name the interpreter too: -- python3 ./plain.py",
        ),
        (&["./no-line"], "has no #! line", "#!/usr/bin/env python3"),
        (&["./crlf"], "ends in CR LF", "dos2unix"),
        (&["./bom"], "byte order mark", "without byte order mark"),
        (
            &["./lost"],
            "\"/usr/bin/no-such-interpreter\", which is not there",
            "#!/usr/bin/env",
        ),
        (&["./empty"], "is empty", "write the decoder"),
        (&["./windows.exe"], "is a Windows program", "wine"),
        (&["./some.jar"], "is an archive", "java -jar"),
        (
            &["./elsewhere"],
            "a program for another machine: ",
            "build it for this machine",
        ),
    ] {
        let (status, told) = probe_in(here, &[], words);
        assert_eq!(status, 3, "{words:?}: {told}");
        assert!(
            told.contains(says) && told.contains(next),
            "{words:?}: {told}"
        );
    }
}

#[test]
fn decoders_that_expect_to_be_called_otherwise() {
    let relative = "[ -f decoder ] || { echo \"no tables beside me\" >&2; exit 1; }\nright \"$@\"";
    is_told(
        &shell(relative),
        3,
        &["it works in your directory only", "beside itself"],
    );
    is_told(
        &shell("cat > in.ptm\nright \"$1\" in.ptm || exit 1"),
        3,
        &["reads the PTM from standard input", "last argument"],
    );
    is_told(
        &shell("[ $# = 1 ] || exit 1\ncat > in.ptm\nright \"$1\" in.ptm"),
        3,
        &["takes no FILE"],
    );
    is_told(
        &shell("[ $# = 0 ] || exit 1\ncat > in.ptm\nright raw in.ptm"),
        3,
        &["takes no arguments"],
    );
    is_told(
        &shell("right \"$2\" \"$1\" || exit 1"),
        3,
        &["arguments the other way round", "the first is the VIEW"],
    );
    is_told(
        &shell("[ $# = 1 ] || exit 64\nright raw \"$1\""),
        3,
        &["it takes no VIEW"],
    );
    is_told(
        &shell("no-such-program-at-all \"$2\""),
        3,
        &["exit status 127", "absolute paths"],
    );
    is_told(&shell("exec ./no-such/file \"$2\""), 3, &["exit status 12"]);
}

#[test]
fn decoders_that_show_nothing() {
    is_told(
        &shell("exit 69"),
        3,
        &["exits with 69 (unsupported) on an ordinary file of every format"],
    );
    is_told(
        &shell("exit 65"),
        3,
        &["rejected", "this is an ordinary file"],
    );
    is_told(
        &shell("echo Traceback >&2; exit 1"),
        3,
        &["crash: exit status 1\n  its standard error ends: Traceback"],
    );
    is_told(
        &shell("exit 0"),
        3,
        &["standard output is empty", "flush it"],
    );
    is_told(
        &shell("right \"$@\" >&2"),
        3,
        &["it prints the frame on standard error"],
    );
    is_told(
        &shell("kill -SEGV $$"),
        3,
        &["killed by signal 11", "in a debugger"],
    );
    is_told(
        &shell("echo unknown command"),
        3,
        &["begins with \"unknown command", "begin with \"PTM1 VIEW"],
    );
    let scratch = tempfile::tempdir().expect("a scratch directory");
    write(
        &scratch.path().join("decoder"),
        shell("sleep 1000.75").as_bytes(),
        0o755,
    );
    let (status, told) = probe_in(scratch.path(), &["--timeout", "1"], &["./decoder"]);
    assert_eq!(status, 3, "{told}");
    assert!(
        told.contains("hang: no end within 1 s") && told.contains("no window, no prompt"),
        "{told}"
    );
}

/// Perl, sed and tr turn right bytes into wrong ones.
#[test]
fn frames_that_are_spoiled_on_their_way() {
    if !have("perl") {
        return;
    }
    let spoiled = |act: &str| {
        shell(&format!(
            "right \"$@\" > frame || exit $?\nperl -e 'binmode STDIN; binmode STDOUT; undef $/; $_ = <STDIN>; {act}; print' < frame"
        ))
    };
    is_told(
        &spoiled("s/\\n/\\r\\n/g"),
        3,
        &["has become CR LF: text mode", "_O_BINARY"],
    );
    is_told(
        &spoiled("s/\\n/\\r\\n/"),
        3,
        &["its first line ends in CR LF", "a line feed alone"],
    );
    is_told(
        &spoiled("utf8::encode($_)"),
        3,
        &["(UTF-8)", "write bytes, not characters"],
    );
    is_told(
        &spoiled("$_ = \"\\xff\\xfe\" . join(\"\", map { \"$_\\0\" } split(//))"),
        3,
        &["UTF-16"],
    );
    is_told(
        &spoiled("$_ = \"Loading file...\\n$_\""),
        3,
        &[
            "text before the frame: \"Loading file...\\n\"",
            "standard error",
        ],
    );
    is_told(
        &spoiled("$_ .= \"\\n\""),
        3,
        &["it prints \"\\n\" after the samples", "not println"],
    );
    is_told(&spoiled("s/ /  /"), 3, &["not separated by single spaces"]);
    is_told(
        &spoiled("s/(u8|f32)/$1 == \"u8\" ? \"uint8\" : \"float32\"/e"),
        3,
        &["the type is uint8 instead of u8"],
    );
    is_told(
        &spoiled("chop"),
        3,
        &[
            "announces 135 bytes of samples, 134 follow",
            "exactly as many bytes",
        ],
    );
    is_told(&spoiled("s/PTM1/PTM2/"), 3, &["begins with \"PTM2"]);
    // Only a frame larger than a pipe's buffer is cut.
    is_told(
        &spoiled("$_ = substr($_, 0, 65536)"),
        1,
        &[
            "ends after 65536 bytes, a multiple of 65536",
            "process.exitCode",
        ],
    );
    is_told(
        &spoiled("$_ = substr($_, 0, 4096 * int(length($_) / 4096)) if length($_) > 4096"),
        1,
        &["a multiple of 4096", "_exit()"],
    );
}

#[test]
fn frames_whose_samples_stand_elsewhere() {
    if !have("python3") {
        return;
    }
    let flatten = "samples = b\"\".join(ptm.texels)";
    let rows = "[ptm.texels[y * ptm.width:(y + 1) * ptm.width] for y in range(ptm.height)]";
    let told = |with: &str, says: &[&str]| {
        is_told(&python(flatten, &format!("samples = {with}")), 1, says)
    };
    told(
        &format!("b\"\".join(b\"\".join(row) for row in reversed({rows}))"),
        &["its rows are upside down", "top row first"],
    );
    told(
        &format!("b\"\".join(b\"\".join(reversed(row)) for row in {rows})"),
        &["its rows run from right to left"],
    );
    told(
        "b\"\".join(reversed(ptm.texels))",
        &["its rows are upside down; and its rows run from right to left"],
    );
    told(
        "b\"\".join(map(bytes, zip(*ptm.texels)))",
        &["as whole planes", "side by side"],
    );
    told(
        &format!("b\"\".join(bytes(c) for row in {rows} for c in zip(*row))"),
        &["follow each other within each row"],
    );
    told(
        &format!("b\"\".join(t for column in zip(*{rows}) for t in column)"),
        &["column by column"],
    );
    told(
        "b\"\".join(t[:6] + t[:5:-1] for t in ptm.texels)",
        &["red and blue are exchanged (BGR)"],
    );
    told(
        "b\"\".join(t[6:] + t[:6] for t in ptm.texels)",
        &["the color stands before the coefficients"],
    );
    told(
        &format!("b\"\".join(t[:6] + t[:5:-1] for row in reversed({rows}) for t in row)"),
        &["(BGR); and its rows are upside down"],
    );
    told(
        "b\"\".join(bytes(255 - x for x in t) for t in ptm.texels)",
        &["the image is wrong: texel (0, 0)", "check names the clause"],
    );
    let bgr =
        "samples = bytes(color_byte(channel) for color in colors for channel in list(color)[::-1])";
    let plain = "samples = bytes(color_byte(channel) for color in colors for channel in color)";
    is_told(
        &python(plain, bgr),
        1,
        &["LRGB rgb:0.3125,-0.4375: red and blue are exchanged (BGR)"],
    );
}

#[test]
fn frames_of_the_wrong_type_view_or_size() {
    if !have("python3") {
        return;
    }
    is_told(
        &python("    if sys.byteorder == \"big\":", "    if True:"),
        1,
        &["its f32 have the high byte first", "'<f4'"],
    );
    is_told(
        &python("array.array(\"f\")", "array.array(\"d\")"),
        1,
        &["its samples are f64, low byte first"],
    );
    is_told(
        &python("kind, samples = \"f32\"", "kind, samples = \"f64\""),
        1,
        &["says the type is f64 instead of f32"],
    );
    let light = "line = \"PTM1 %s %d %d %d %s\\n\" % (os.fsdecode(sys.argv[1]), ptm.width";
    is_told(
        &python(
            "line = \"PTM1 %s %d %d %d %s\\n\" % (view.decode(), ptm.width",
            light,
        ),
        1,
        &[
            "its first line says \"rgb:0.3125,-0.4375\"",
            "without the light",
        ],
    );
    is_told(
        &python(
            "(view.decode(), ptm.width, ptm.height,",
            "(view.decode(), ptm.height, ptm.width,",
        ),
        1,
        &["height and width exchanged"],
    );
    is_told(
        &python(
            "(view.decode(), ptm.width, ptm.height,",
            "(\"raw\", ptm.width, ptm.height,",
        ),
        1,
        &["says \"raw\" where coef is asked for"],
    );
    let floats = "samples = array.array(\"f\", (float(c) for t in ptm.texels for c in t)).tobytes(); kind = \"f32\"";
    is_told(
        &python("samples = b\"\".join(ptm.texels)", floats),
        1,
        &["its samples are f32, low byte first, where u8 is asked for"],
    );
}

#[test]
fn refusals_that_are_none() {
    is_told(
        &shell("right \"$@\" || exit 1"),
        1,
        &[
            "an empty file: exit status 1 counts as a crash",
            "--reject-exit 1",
        ],
    );
    is_told(
        &shell("right \"$@\" || exit 69"),
        1,
        &["exited with 69 (unsupported) instead of 65"],
    );
    is_told(
        &shell("right \"$@\" || exit 0"),
        1,
        &["it exits with 0 and prints no frame"],
    );
    is_told(
        &shell("right \"$@\" || printf 'PTM1 raw 1 1 9 u8\\n123456789'"),
        1,
        &["it prints a frame all the same", "exit with 65"],
    );
    is_told(
        &shell("case $1 in no-*) set raw \"$2\";; esac\nright \"$@\" || exit 65"),
        1,
        &["an unknown view: it prints a frame all the same"],
    );
}

#[test]
fn a_decoder_of_one_view_and_one_format_is_ready() {
    let only = "case $1 in rgb:*) ;; *) exit 69;; esac\ngrep -q PTM_FORMAT_RGB \"$2\" || { grep -q PTM_FORMAT_ \"$2\" && exit 69; exit 65; }\nright \"$@\" || exit 65";
    let told = is_told(
        &shell(only),
        0,
        &[
            "– not decoded: LRGB",
            "✓ RGB rgb:0.3125,-0.4375: decoded",
            "– RGB raw: exited with 69",
        ],
    );
    assert!(told.contains("ready."), "{told}");
}

#[test]
fn serve_modes_that_go_wrong() {
    if !have("python3") {
        return;
    }
    let flush = "        answers.flush()\n";
    let scratch = tempfile::tempdir().expect("a scratch directory");
    write(
        &scratch.path().join("decoder"),
        python(flush, "").as_bytes(),
        0o755,
    );
    let (status, told) = probe_in(scratch.path(), &["--timeout", "8"], &["./decoder"]);
    assert!(
        status == 1 && told.contains("serve: it answers only when its standard input ends"),
        "{told}"
    );
    assert!(
        told.contains("flush standard output after each answer"),
        "{told}"
    );
    is_told(
        &python(flush, "        answers.flush(); sys.exit(0)\n"),
        1,
        &["serve: it ends at a malformed file"],
    );
    is_told(
        &python(
            "b\"%s ok %d\\n\" % (sequence, len(answer))",
            "b\"%s ok %d\\n\" % (sequence, len(answer) - 20)",
        ),
        1,
        &["NBYTES counts the PTM1 line"],
    );
    is_told(
        &python("b\"%s ok %d\\n\" % (sequence, ", "b\"ok %d %d\\n\" % (0, "),
        1,
        &["it answers \"ok 0 "],
    );
    is_told(
        &python(
            "answers.write(sequence + b\" reject 65\\n\")",
            "answers.write(sequence + b\" unsupported x\\n\")",
        ),
        1,
        &["a malformed file is answered \"2 unsupported x\""],
    );
}

#[test]
fn a_reader_of_one_spelling_of_the_count_is_ready() {
    for (knows, says) in [
        ("grep -aq nentries", "is written \"nentries 256\""),
        (
            "! grep -aq 'nentries\\|N_LUT_ENTRIES'",
            "is written \"256\"",
        ),
    ] {
        let text = format!(
            "case $1 in raw|coef|rgb:*) grep -aq _LUT \"$2\" && {knows} \"$2\" || exit 65;; *) exit 69;; esac\n\
             right \"$@\""
        );
        let right = "PTM_C_LUT raw: decoded correctly";
        is_told(&shell(&text), 0, &[right, says, "ready. Next"]);
    }
}

#[test]
fn serve_mode_is_compared_with_one_shot_mode() {
    if !have("python3") {
        return;
    }
    // A picture that is wrong in both modes is no fault of serve mode.
    is_told(
        &python(
            "for y in reversed(range(height)) for",
            "for y in range(height) for",
        ),
        1,
        &[
            "its rows are upside down",
            "✓ serve: the first request is answered at once, as in one-shot mode",
        ],
    );
    is_told(
        &python(
            "            answer = frame(view, path)\n",
            "            answer = frame(view, path)[:-1] + b'x'\n",
        ),
        1,
        &[
            "serve: the answer differs from that of one-shot mode",
            "$ printf '1 raw ptm-conform-probe/lrgb-5x3.ptm\\n' | ./decoder serve | xxd | head",
        ],
    );
}

#[test]
fn an_observation_can_be_repeated_by_hand() {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let decoder = scratch.path().join("decoder");
    write(
        &decoder,
        shell("right \"$@\" | tr -d '\\n'").as_bytes(),
        0o755,
    );
    let (_, told) = probe_in(scratch.path(), &[], &["./decoder"]);
    let command = told.lines().find_map(|line| line.trim().strip_prefix("$ "));
    let command = command.unwrap_or_else(|| panic!("no command in:\n{told}"));
    assert_eq!(
        command,
        "./decoder raw ptm-conform-probe/lrgb-5x3.ptm | xxd | head"
    );
    let repeated = std::process::Command::new("sh")
        .current_dir(scratch.path())
        .args(["-c", command.trim_end_matches(" | xxd | head")])
        .output()
        .expect("a shell starts");
    assert!(repeated.stdout.starts_with(b"PTM1 raw 5 3 9 u8"));
}
