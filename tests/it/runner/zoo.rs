//! Tests the harness with programs that misbehave, each in one way (`examples/zoo.rs`). No process, file or memory may leak.

use std::fs;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::{
    CheckRun, Workspace, assert_contains, have_proc, processes, rows, run_measured, wait_until, zoo,
};

/// Options that select a few small cases of every kind. Programs that never end then take only seconds.
const FEW_CASES: &str = "--case hand-[fjpr]* --case hand-lrgb* --case hand-lum --case hand-lum-in-color \
                   --case version-1-3-lrgb --case version-1-3-rgb --case header-plain-*";

/// A program in the zoo, and the expected verdict.
///
/// A row of a table contains program names, the exit status of `check`, the options of `check`, the failing cases, and parts of
/// the output. The failing cases are `none` (and some pass), `some`, `any` (if the result depends on which process is faster), a
/// number, their ids, or `not judged`. The timeout is 60 s unless the options specify another one.
type FaultyDecoder = [String; 5];

/// Programs that neither run forever nor use too much memory.
const ANSWERING: &str = "
right chatters floods-stderr gigabytes-on-stderr a-million-writes byte-by-byte leaves-files
  leaves-a-locked-directory leaves-a-child leaves-a-grandchild leaves-a-hidden-child leaves-a-link moves-its-directory
  leaves-a-daemon leaves-orphans keeps-zombies fills-its-scratch exhausts-descriptors prints-before-reading
  declares-rgb-only declares-exit-1 declares-everything-and-fails floods-on-capabilities
  bombs-on-capabilities babbles-on-capabilities | 0 | | none | pass: 17 pass
refuses-all | 3 | | not judged | refuses all of the 48 first files
unsupported-all | 3 | | not judged | 69 (unsupported) on all of the first requests
exits-1 | 3 | | not judged | crash: exit status 1
exits-101 | 3 | | not judged | crash: exit status 101
aborts | 3 | | not judged | crash: killed by signal 6
segfaults | 3 | | not judged | crash: killed by signal 11
prints-nothing | 3 | | not judged | protocol error: standard output is empty
apologizes | 3 | | not judged | begins with
prints-no-texels | 3 | | not judged | an image without texels
text-mode | 3 | | not judged | CR LF && set standard output to binary mode
cuts-frame adds-a-byte | 3 | | not judged | announces
announces-too-much | 3 | | not judged | more bytes than 64 bits can count
number-out-of-range | 3 | | not judged | is not a number
floods | 3 | | not judged | flood: more than
deletes-its-input | 3 | | not judged | tampering: the input file was changed or removed
overwrites-its-input links-its-input input-becomes-a-pipe | 3 | | not judged | tampering
accepts-all | 1 | | 17 | received raw 1x1
accepts-malformed | 1 | | 2 | accepted a file that must be refused
wrong-size | 1 | | 15 | received raw 1x1 with 1 channels
crashes-on-malformed
  | 1 | | not judged | an empty file, and other malformed files: exit status 1 counts as a crash && use check --reject-exit 1 && to reproduce this:↵  $
crashes-on-malformed | 0 | --reject-exit 1 | none | pass: 17 pass
crashes-on-lum | 1 | | hand-lum hand-lum-in-color header-plain-lum | ends with exit status 1 on 3 legal files
differs-each-time | 1 | | 15 | two calls returned different responses: a wrong image
upside-down | 1 | | none | raw, coef, rgb: the rows are upside down, in all of the first files
blue-first | 1 | | none | rgb: red and blue are swapped (BGR), in all of the first files
halves | 1 | | none | raw: all values are divided by about 2. && coef: all values are divided by about 2.000
brightens | 1 | | none | rgb: the sRGB curve is applied to all values, in all of the first files
high-byte-first | 1 | | not judged | coef: the f32 samples are big-endian && to reproduce this:↵  $
cuts-large-frames | 1 | | not judged | the decoder exits before all bytes are written && to reproduce this:↵  $
unsupported-once | 1 | | 1 | decodes other files of this kind
no-lum | 0 | | none | unsupported (exit status 69): LUM, rgb of LUM
no-raw-of-rgb | 0 | | none | unsupported (exit status 69): raw of RGB
is-silent-about-lum | 0 | | none | unsupported (exit status 69): LUM
declares-lum-and-lacks-it | 1 | | hand-lum hand-lum-in-color header-plain-lum | declare LUM, but it decodes no file of this kind
declares-coef-and-lacks-it | 1 | | none | declare view coef, but it exits with 69
declares-coef-only | 0 | | none | pass:
declares-exit-0 | 0 | | none | note: capabilities: exit status 0 cannot mean a refusal
";

/// Programs that exceed a limit.
const STOPPED: &str = "
hangs hangs-and-ignores-term stops-itself drips closes-stdout-and-runs-on closes-everything-and-runs-on
  | 3 | --timeout 1 | not judged | it exceeds the time limit of 3 s (`--timeout`) and decodes none of the first files
hoards hoards-by-a-child | 3 | --memory 150M | not judged | out of memory: the processes of the program used more than 150 MiB
hangs-on-capabilities | 0 | --timeout 2 | none | pass: 17 pass
";

/// Programs that support serve mode. If serve mode fails, each file is requested in one-shot mode.
const SERVING: &str = r#"
serves | 0 | | none | pass: 17 pass
serves serves-and-deletes-later | 0 | --serve --jobs 1 | none | pass: 17 pass
serves-not | 1 | --serve | none | serve mode failed && ended (exit status 64) without an answer
declares-serve-and-lacks-it | 1 | | none | serve mode failed && ended (exit status 64) without an answer
serves-the-number-before | 1 | --serve | none | serve mode failed && the answer to request 1 has the number 0
serves-the-wrong-number | 1 | --serve | none | serve mode failed && the answer to request 1 has the number 4711
serves-interleaved | 1 | --serve | none | serve mode failed && protocol error
serves-huge-numbers
  | 1 | --serve | none | serve mode failed && announces 18446744073709551615 bytes, but no frame
serves-impossible-numbers | 1 | --serve | none | serve mode failed && expected "1 ok NBYTES"
serves-without-the-line | 1 | --serve | none | serve mode failed && including the first line of the frame
serves-bare-frames | 1 | --serve | none | serve mode failed && write a separate answer line before the frame
serves-logs | 1 | --serve | none | serve mode failed && found "decoding"
serves-text-mode | 1 | --serve | none | serve mode failed && text mode
serves-without-flush
  | 1 | --timeout 2 --serve | none | serve mode failed && flush standard output after each answer
serves-extra | 1 | --serve | none | in serve mode && protocol error
serves-before-asked | 1 | --serve --jobs 1 | any | in serve mode && protocol error
serves-exit-codes | 1 | --serve --jobs 1 | 2 | expected the refusal code 65
serves-five-times | 1 | --serve --jobs 1 | 2 | ended (exit status 0) without an answer; it had answered 5 requests
serves-five-times-and-ignores-the-rest | 0 | --timeout 2 --serve --jobs 1 | none | exceeded the time limit of 2 s (`--timeout`) on && the time is no failure
serves-until-lum
  | 1 | --serve --jobs 1 | hand-lum hand-lum-in-color header-plain-lum | in serve mode (the previous request was first-rgb): crash: the serving process ended (killed by signal 6)
serves-and-hangs-at-lum
  | 1 | --timeout 2 --serve --jobs 1 | hand-lum hand-lum-in-color header-plain-lum | exceeds the time limit of 6 s (`--timeout`)
pipelined | 0 | | none | pass: 17 pass
pipelined-crashes-on-version-1-3
  | 1 | | version-1-3-lrgb version-1-3-rgb | in serve mode && crash: the serving process ended (killed by signal 6)
pipelined-hangs-on-version-1-3
  | 1 | --timeout 2 | version-1-3-lrgb version-1-3-rgb | exceeds the time limit of 6 s (`--timeout`)
pipelined-takes-one
  | 0 | --timeout 2 | none | note: some requests that were sent at once were not answered in time, so requests are sent one at a time: it answered 1 of
pipelined-skips-one pipelined-backward
  | 1 | | none | FAIL: the decoder declares `pipelined`, but && has the number && or do not declare `pipelined`
pipelined-ends-early
  | 1 | | none | FAIL: the decoder declares `pipelined`, but && ended (exit status 0) without an answer
serves-and-hoards | 1 | --serve --jobs 1 --memory 250M | some | out of memory: the processes of the program used more than 250 MiB
serves-and-deletes | 1 | --serve | none | serve mode failed && tampering
serves-with-leaks | 1 | --serve --jobs 1 | 11 | state may leak between files && one-shot mode, with an image
serves-other-answers
  | 1 | --serve --jobs 1 | some | state may leak between files && it answers with "unsupported"; twice in one-shot mode, with an image
"#;

/// Expands a table to one entry per program.
fn expand_table(table: &str) -> Vec<FaultyDecoder> {
    let mut all: Vec<FaultyDecoder> = Vec::new();
    for row in rows::<5>(table) {
        for kind in row[0].split(' ') {
            let mut faulty = row.clone();
            kind.clone_into(&mut faulty[0]);
            if !row[2].contains("--timeout") {
                faulty[2] += " --timeout 60";
            }
            all.push(faulty);
        }
    }
    all
}

/// Number of runs so far, which distinguishes the processes of different runs.
static RUN_COUNT: AtomicUsize = AtomicUsize::new(0);

/// Checks a faulty decoder: the verdict must be exact, and nothing may leak. Returns the peak memory of the harness in KiB.
#[track_caller]
fn check_faulty_decoder(faulty: &FaultyDecoder) -> u64 {
    let here = Workspace::new();
    let run = RUN_COUNT.fetch_add(1, Ordering::Relaxed);
    let nap = format!("1000.{}{run:06}", std::process::id());
    let temporary = here.path("a place");
    fs::create_dir(&temporary).expect("a directory");
    let precious = here.write("precious/file", "precious");
    let [kind, _, options, ..] = faulty;
    let line = format!(
        "check {FEW_CASES} {options} --report report.yaml -- {}",
        zoo(kind)
    );
    let mut command = here.command(&line);
    command
        .env("TMPDIR", &temporary)
        .env("ZOO_NAP", &nap)
        .env("ZOO_PRECIOUS", precious.parent().expect("a directory"));
    let (checked, memory) = run_measured(command, &here.path("report.yaml"));
    judge(faulty, &checked);
    assert_eq!(here.text("precious/file"), "precious", "{kind}");
    let left: Vec<_> = fs::read_dir(&temporary).expect("a directory").collect();
    assert!(left.is_empty(), "{kind}: {left:?} remain");
    if have_proc() {
        // The watchdog may take a moment to exit.
        let mark = format!("TMPDIR={}", temporary.display());
        let alive = || {
            processes(|command, environment| command.contains(&nap) || environment.contains(&mark))
        };
        assert!(
            wait_until(5, || alive().is_empty()),
            "{kind}: {:?} survive",
            alive()
        );
    }
    memory
}

#[track_caller]
fn judge(faulty: &FaultyDecoder, checked: &CheckRun) {
    let [kind, status, _, fails, says] = faulty;
    let found = checked.status.to_string();
    assert_eq!(found, *status, "{kind}: {}", checked.text);
    assert_contains(&checked.text, says);
    let (mut failing, passing) = (checked.cases("fail"), checked.cases("pass").len());
    failing.sort_unstable();
    let is_right = match fails.as_str() {
        "none" => failing.is_empty() && passing > 0,
        "some" => !failing.is_empty(),
        "any" => failing.len() + passing > 0,
        "not judged" => failing.len() + passing == 0,
        expected => expected == failing.len().to_string() || expected == failing.join(" "),
    };
    assert!(
        is_right,
        "{kind}: expected {fails}, {failing:#?} fail\n{}",
        checked.text
    );
}

/// Maximum memory of the harness in KiB, for any decoder. The harness holds the suite and little else.
const MAX_MEMORY_KIB: u64 = 100 << 10;

/// Checks the decoders of a table, three at a time because most of them only wait, and reports all problems at the end.
#[track_caller]
fn check_table(table: &str) {
    let all = expand_table(table);
    let (next, problems) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let worker = || {
        while let Some(faulty) = all.get(next.fetch_add(1, Ordering::Relaxed)) {
            let problem = match std::panic::catch_unwind(|| check_faulty_decoder(faulty)) {
                Ok(memory) if memory <= MAX_MEMORY_KIB => continue,
                Ok(memory) => format!("the harness used {memory} KiB"),
                Err(panic) => panic
                    .downcast_ref::<String>()
                    .map_or("a panic", String::as_str)
                    .to_owned(),
            };
            let mut problems = problems.lock().expect("no holder panics");
            problems.push(format!("{}: {problem}", faulty[0]));
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(worker);
        }
    });
    let problems = problems.into_inner().expect("no holder panics");
    assert!(problems.is_empty(), "{}", problems.join("\n\n"));
}

#[test]
fn answering_decoders_get_the_listed_verdicts() {
    check_table(ANSWERING);
}

#[test]
fn endless_decoders_are_stopped() {
    check_table(STOPPED);
}

#[test]
fn serving_decoders_get_the_listed_verdicts() {
    check_table(SERVING);
}

#[test]
fn decimal_comma_is_detected() {
    // Add a fake `locale` program, in case the locale is not installed. The decoder only reads LC_ALL.
    let here = Workspace::new();
    here.write_program("locale", "#!/bin/sh\necho C\necho de_DE.utf8\n");
    let path = std::env::var("PATH").unwrap_or_default();
    let path = format!("{}:{path}", here.path("").display());
    let check = |kind: &str| {
        let line = format!(
            "check {FEW_CASES} --timeout 60 --report report.yaml -- {}",
            zoo(kind)
        );
        let mut command = here.command(&line);
        command.env("PATH", &path);
        run_measured(command, &here.path("report.yaml")).0
    };
    let checked = check("reads-commas");
    let says = "FAIL: in the locale de_DE.utf8, which uses a decimal comma, first-rgb in coef gives a different image";
    checked.assert_exit(1, says);
    assert!(checked.cases("fail").is_empty());
    check("right").assert_exit(0, "");
}
