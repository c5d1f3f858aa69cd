//! Tests each diagnosis of `probe` with a faulty script.

use crate::common::{
    PROGRAM, Workspace, assert_contains, edit, have_tool, outcome, repository_text, rows,
};

/// Returns a shell script in which `right` calls the reference.
fn shell(body: &str) -> String {
    format!("#!/bin/sh\nright() {{ '{PROGRAM}' reference \"$@\"; }}\n{body}\n")
}

/// Returns the Python decoder, if Python is installed.
fn python_decoder() -> Option<String> {
    have_tool("python3").then(|| repository_text("examples/decoders/ptm_decoder.py"))
}

/// Probes a decoder with the given source text. Returns the exit status and the output.
fn probe(text: &str, options: &str) -> (i32, String) {
    let here = Workspace::new();
    here.write_program("decoder", text);
    let mut command = here.command(&format!("probe {options} -- ./decoder"));
    command.env_remove("PYTHONUNBUFFERED");
    outcome(&command.output().expect("the program starts"))
}

/// Probes a decoder, checks the exit status and the output, and returns the output.
#[track_caller]
fn assert_probed(text: &str, status: &str, parts: &str) -> String {
    // Programs that buffer their output answer only after this time.
    let (found, output) = probe(text, "--timeout 3");
    assert_contains(&output, parts);
    assert_eq!(found.to_string(), status, "{output}");
    output
}

/// Probes shell scripts. Each row contains the exit status, the script, and parts of the output.
#[track_caller]
fn assert_scripts_probed(table: &str) {
    for [status, script, says] in rows(table) {
        assert_probed(&shell(&script), &status, &says);
    }
}

/// Probes copies of the Python decoder. Each row contains the exit status, an edit (old and new text), and parts of the output.
#[track_caller]
fn assert_copies_probed(table: &str) {
    let Some(decoder) = python_decoder() else {
        return;
    };
    for [status, find, replace, says] in rows(table) {
        let copy = edit(&decoder, &find, &replace);
        assert_probed(&copy, &status, &says);
    }
}

#[test]
fn correct_decoder_is_ready() {
    let script = shell("right \"$@\" || case $? in 65) exit 65;; *) exit 69;; esac");
    let says = "ready. Next: ptm-conform check -- ./decoder && ✓ an unknown view: exited with 69";
    let output = assert_probed(&script, "0", says);
    assert!(!output.contains('✗'), "{output}");
    let Some(decoder) = python_decoder() else {
        return;
    };
    let says = "✓ serve: requests that are sent at once are answered in order && \
                ✓ serve: the process ends when its input ends && ✓ capabilities: declared";
    let output = assert_probed(&decoder, "0", says);
    assert!(!output.contains('✗'), "{output}");
}

/// `check` must report the same reason as `probe`.
#[test]
fn commands_that_cannot_be_started_are_explained() {
    let here = Workspace::new();
    here.write("plain.py", "print('hello')\n");
    let s390x = cfg!(target_arch = "s390x");
    let foreign = [if s390x { 62 } else { 22 }, 0];
    let elf = [
        &b"\x7fELF\x02\x01\x01\0\0\0\0\0\0\0\0\0\x02\0"[..],
        &foreign,
        &[0; 100],
    ]
    .concat();
    let script = shell("right \"$@\"");
    for (name, bytes) in [
        ("no-line", &b"print('hello')\n"[..]),
        ("crlf", b"#!/bin/sh\r\nexit 0\r\n"),
        ("bom", b"\xef\xbb\xbf#!/bin/sh\n"),
        ("lost", b"#!/usr/bin/no-such-interpreter -x\n"),
        ("empty", b""),
        ("windows.exe", b"MZ\x90\0"),
        ("some.jar", b"PK\x03\x04"),
        ("in-this-directory", script.as_bytes()),
        ("elsewhere", &elf),
    ] {
        here.write_program(name, bytes);
    }
    for [decoder, says, next] in rows(
        r#"
./no-such-decoder | no such file | check the path of the decoder
no-such-decoder-in-path | no program with this name is in PATH | give the path of the decoder
in-this-directory | looked up only in PATH | write ./in-this-directory
'python3 plain.py' | no program with this name
  | several words; write them without quotation marks: -- python3 plain.py
sh no-such-script.sh | no-such-script.sh: no such file in this directory | give the path of the script
. | is a directory | give the path of a program in the directory
./plain.py | is not executable | chmod +x ./plain.py, or name the interpreter too: -- python3 ./plain.py
./no-line | has no #! line | #!/usr/bin/env python3
./crlf | ends in CR LF | dos2unix
./bom | byte order mark | without a byte order mark
./lost | "/usr/bin/no-such-interpreter", which does not exist | #!/usr/bin/env
./empty | is empty | write the decoder
./windows.exe | is a Windows program | wine
./some.jar | is an archive | java -jar
./elsewhere | a program for a different machine: | build the program for this machine"#,
    ) {
        let output = here.exits(3, &format!("probe -- {decoder}"));
        assert_contains(&output, &format!("{says} && {next}"));
        let checked = here.check(&format!("--case hand-lrgb-blocks -- {decoder}"));
        checked.assert_exit(3, &says);
        assert_eq!(checked.report["verdict"], "not a decoder");
    }
}

#[test]
fn unexpected_arguments_are_explained() {
    assert_scripts_probed(
        r#"
3 | [ -f decoder ] || { echo "no tables next to this program" >&2; exit 1; }↵right "$@"
  | the decoder works only in your working directory && next to itself
3 | cat > in.ptm↵right "$1" in.ptm || exit 1 | reads the PTM from standard input && last argument
3 | [ $# = 1 ] || exit 1↵cat > in.ptm↵right "$1" in.ptm | takes no FILE
3 | [ $# = 0 ] || exit 1↵cat > in.ptm↵right raw in.ptm | takes no arguments
3 | right "$2" "$1" || exit 1 | arguments in reverse order && take VIEW first
3 | case $2 in raw|coef|rgb:*) right "$2" "$1" || exit 65;; *) exit 69;; esac | arguments in reverse order
3 | [ $# = 1 ] || exit 64↵right raw "$1" | the decoder takes no VIEW
3 | no-such-program-at-all "$2" | exit status 127 && absolute paths
3 | exec ./no-such/file "$2" | exit status 12"#,
    );
}

#[test]
fn missing_output_is_explained() {
    assert_scripts_probed(
        r#"
3 | exit 69 | exits with 69 (unsupported) on an ordinary file of every format
3 | exit 65 | rejected && this is an ordinary file
3 | echo Traceback >&2; exit 1 | crash: exit status 1↵  last message on its standard error: Traceback
3 | exit 0 | standard output is empty && flush it
3 | right "$@" >&2 | not to standard error
3 | kill -SEGV $$ | killed by signal 11 && in a debugger
3 | echo unknown command | begins with "unknown command && begin the output with "PTM1 VIEW"#,
    );
    let (status, output) = probe(&shell("sleep 1000.75"), "--timeout 1");
    assert_eq!(status, 3, "{output}");
    assert_contains(
        &output,
        "exceeds the time limit of 3 s (`--timeout`) && open no window, show no prompt",
    );
}

/// A Perl script damages correct frames.
#[test]
fn damaged_frames_are_explained() {
    if !have_tool("perl") {
        return;
    }
    for [status, act, says] in rows(
        r#"
3 | s/\n/\r\n/g | converted to CR LF (text mode) && _O_BINARY
3 | s/\n/\r\n/ | the first line ends in CR LF && a line feed alone
3 | utf8::encode($_) | (UTF-8) && write bytes, not characters
3 | $_ = "\xff\xfe" . join("", map { "$_\0" } split(//)) | UTF-16
3 | $_ = "Loading file...\n$_" | text before the frame: "Loading file...\n" && standard error
3 | $_ .= "\n" | the decoder prints "\n" after the samples && instead of println
3 | s/ /  / | not separated by single spaces
3 | s/(u8|f32)/$1 == "u8" ? "uint8" : "float32"/e | the type is uint8 instead of u8
3 | chop | announces 135 bytes of samples, but 134 follow && exactly as many bytes
3 | s/PTM1/PTM2/ | begins with "PTM2
1 | $_ = substr($_, 0, 65536) | truncated after 65536 bytes, a multiple of 65536 && process.exitCode
1 | $_ = substr($_, 0, 4096 * int(length($_) / 4096)) if length($_) > 4096
  | a multiple of 4096 && _exit()"#,
    ) {
        let perl = format!("binmode STDIN; binmode STDOUT; undef $/; $_ = <STDIN>; {act}; print");
        let script = format!("right \"$@\" > frame || exit $?\nperl -e '{perl}' < frame");
        assert_probed(&shell(&script), &status, &says);
    }
}

#[test]
fn misplaced_samples_are_explained() {
    let Some(decoder) = python_decoder() else {
        return;
    };
    let rows_of_texels =
        "[ptm.texels[y * ptm.width:(y + 1) * ptm.width] for y in range(ptm.height)]";
    let table = r#"
b"".join(b"".join(row) for row in reversed(ROWS)) | the rows are upside down && start the frame with the top row
b"".join(b"".join(reversed(row)) for row in ROWS) | the rows are mirrored, right to left
b"".join(t[::-1] for t in reversed(ptm.texels)) | the samples are in reverse order && start with the first channel
b"".join(reversed(ptm.texels)) | the rows are upside down; and the rows are mirrored, right to left
b"".join(map(bytes, zip(*ptm.texels))) | one whole plane per channel && (interleaved)
b"".join(bytes(c) for row in ROWS for c in zip(*row)) | planar within each row
b"".join(t for column in zip(*ROWS) for t in column) | column-major order
b"".join(t[:6] + t[:5:-1] for t in ptm.texels) | red and blue are swapped (BGR)
b"".join(t[6:] + t[:6] for t in ptm.texels) | the color comes before the coefficients
b"".join(t[:6] + t[:5:-1] for row in reversed(ROWS) for t in row) | (BGR); and the rows are upside down
b"".join(bytes(255 - x for x in t) for t in ptm.texels)
  | the image is wrong: texel (0, 0) && which names the misread clause"#;
    for [samples, says] in rows(&table.replace("ROWS", rows_of_texels)) {
        let samples = format!("samples = {samples}");
        let copy = edit(&decoder, "samples = b\"\".join(ptm.texels)", &samples);
        assert_probed(&copy, "1", &says);
    }
    assert_copies_probed(
        "
1 | samples = bytes(color_byte(channel) for color in colors for channel in color)
  | samples = bytes(color_byte(channel) for color in colors for channel in list(color)[::-1])
  | ✗ LRGB, RGB, LUM, PTM_LUT, PTM_C_LUT && rgb:0.3125,-0.4375: red and blue are swapped (BGR) && 1 thing to fix",
    );
}

#[test]
fn wrong_types_views_and_sizes_are_explained() {
    assert_copies_probed(
        r#"
1 | if sys.byteorder == "big": | if True: | the f32 samples are big-endian && '<f4'
1 | array.array("f") | array.array("d") | the samples are f64 (low byte first)
1 | kind, samples = "f32" | kind, samples = "f64" | says the type is f64 instead of f32
1 | (view.decode(), ptm.width | (os.fsdecode(sys.argv[1]), ptm.width
  | the first line says "rgb:0.3125,-0.4375" && without the light
1 | (view.decode(), ptm.width, ptm.height, | (view.decode(), ptm.height, ptm.width, | width and height swapped
1 | (view.decode(), ptm.width, ptm.height, | ("raw", ptm.width, ptm.height, | says "raw", but coef was requested
1 | samples = b"".join(ptm.texels)
  | samples = array.array("f", (float(c) for t in ptm.texels for c in t)).tobytes(); kind = "f32"
  | the samples are f32 (low byte first), but u8 was requested"#,
    );
}

#[test]
fn wrong_refusals_are_explained() {
    assert_scripts_probed(
        r#"
1 | right "$@" || exit 1 | an empty file: exit status 1 counts as a crash && --reject-exit 1
1 | right "$@" || exit 69 | exited with 69 (unsupported) instead of 65
1 | right "$@" || exit 0 | the decoder exits with 0 and prints no frame
1 | right "$@" || printf 'PTM1 raw 1 1 9 u8\n123456789' | the decoder prints a frame anyway && exit with 65
1 | case $1 in no-*) set raw "$2";; esac↵right "$@" || exit 65
  | an unknown view: the decoder prints a frame anyway"#,
    );
}

/// The first decoder refuses eight formats with exit status 65. The second decoder exits with 1 in one view of a format.
#[test]
fn faults_in_other_formats_are_found() {
    assert_scripts_probed(
        r#"
1 | case $1 in raw|coef|rgb:*) grep -aq FORMAT_LRGB "$2" || exit 65;; *) exit 69;; esac↵right "$@"
  | LRGB raw: decoded && ✗ RGB, LUM, PTM_LUT, PTM_C_LUT, JPEG_RGB, && → exit with 69 for formats
1 | case $1 in coef) grep -aq FORMAT_LUM "$2" && exit 1;; esac↵right "$@"
  | RGB: decoded correctly && ✗ LUM coef && exit status 1"#,
    );
}

/// The first decoder supports one view and one format. The others each support one spelling of the number of entries.
#[test]
fn partial_decoders_are_ready() {
    assert_scripts_probed(
        r#"
0 | case $1 in rgb:*) ;; *) exit 69;; esac↵grep -q PTM_FORMAT_RGB "$2" || { grep -q PTM_FORMAT_ "$2" && exit 69; exit 65; }↵right "$@" || exit 65
  | – not supported: LUM, LRGB, PTM_LUT && ✓ RGB rgb:0.3125,-0.4375: decoded && – RGB raw: exited with 69 && ready.
0 | case $1 in raw|coef|rgb:*) grep -aq 'FORMAT_[RLJ]' "$2" && exit 69; grep -aq nentries "$2" || exit 65;; *) exit 69;; esac↵right "$@"
  | PTM_C_LUT raw: decoded correctly && is spelled "nentries 256" && ready. Next
0 | case $1 in raw|coef|rgb:*) grep -aq 'FORMAT_[RLJ]' "$2" && exit 69; grep -aq _LUT "$2" && ! grep -aq 'nentries\|N_LUT_ENTRIES' "$2" || exit 65;; *) exit 69;; esac↵right "$@"
  | PTM_C_LUT raw: decoded correctly && is spelled "256" && ready. Next
0 | case $1 in raw|coef|rgb:*) grep -aq 'FORMAT_[RL]\|C_LUT\|PTM_LUT' "$2" && exit 69; grep -aq FORMAT_ "$2" || exit 65;; *) exit 69;; esac↵right "$@" || exit 65
  | JPEG_RGB raw: decoded correctly && a frame of 29949 texels in coef && ready. Next"#,
    );
}

#[test]
fn serve_mode_faults_are_explained() {
    let Some(decoder) = python_decoder() else {
        return;
    };
    let copy = edit(&decoder, "answers.flush()", "pass");
    let (status, output) = probe(&copy, "--timeout 3");
    let says = "serve: the decoder answers only when its standard input ends && flush standard output after each answer";
    assert_eq!(status, 1, "{output}");
    assert_contains(&output, says);
    assert_copies_probed(
        r#"
1 | answers.flush() | answers.flush(); sys.exit(0) | serve: the decoder exits on a malformed file
1 | b"%s ok %d\n" % (sequence, len(answer)) | b"%s ok %d\n" % (sequence, len(answer) - 20)
  | count the PTM1 line
1 | b"%s ok %d\n" % (sequence, | b"ok %d %d\n" % (0, | the decoder answers "ok 0
1 | for request in requests: | for request in iter(lambda: requests.read1().splitlines(True)[:1], []):↵        request = request[0]
  | of four requests that are sent at once, 1 are answered && remove pipelined from the capabilities
1 | answers.write(sequence + b" reject 65\n") | answers.write(sequence + b" unsupported x\n")
  | the decoder answers "2 unsupported x" to a malformed file"#,
    );
}

/// An image that is wrong in both modes is not a fault of serve mode.
#[test]
fn serve_mode_is_compared_with_one_shot_mode() {
    let Some(decoder) = python_decoder() else {
        return;
    };
    assert_copies_probed(
        "
1 | for y in reversed(range(height)) for | for y in range(height) for
  | the rows are upside down && ✓ serve: the first response comes immediately and equals the one-shot response",
    );
    let copy = edit(
        &decoder,
        "answer = frame(view, path)",
        "answer = frame(view, path)[:-1] + b'x'",
    );
    let says = "serve: the answer differs from the one in one-shot mode && \
                $ printf '1 raw ptm-conform-probe/lrgb-5x3.ptm\\n' | ./decoder serve | xxd | head";
    assert_probed(&copy, "1", says);
}

#[test]
fn printed_command_repeats_the_observation() {
    let here = Workspace::new();
    here.write_program("decoder", shell("right \"$@\" | tr -d '\\n'"));
    let (_, output) = here.run("probe -- ./decoder");
    let command = output
        .lines()
        .find_map(|line| line.trim().strip_prefix("$ "));
    let command = command.unwrap_or_else(|| panic!("no command in:\n{output}"));
    let expected = "./decoder raw ptm-conform-probe/lrgb-5x3.ptm | xxd | head";
    assert_eq!(command, expected);
    let repeated = std::process::Command::new("sh")
        .current_dir(here.path(""))
        .args(["-c", command.trim_end_matches(" | xxd | head")])
        .output()
        .expect("a shell starts");
    assert!(repeated.stdout.starts_with(b"PTM1 raw 5 3 9 u8"));
}
