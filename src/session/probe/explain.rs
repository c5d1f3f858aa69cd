//! What an answer that is no frame means, and what to do about it.

use crate::kit::last_words::last_words;
use crate::protocol::frame::Answer;
use crate::runner::run::Reply;

/// An answer in a few words.
pub(super) fn briefly(answer: &Answer) -> String {
    match answer.violation() {
        Some(what) => format!("{}: {what}", answer.name()),
        None => answer.name().to_owned(),
    }
}

/// The last line of its standard error, as a line of its own.
fn its_last_words(reply: &Reply) -> String {
    last_words(&reply.stderr).map_or(String::new(), |line| {
        format!("\nits standard error ends: {line}")
    })
}

/// An answer that is no frame, and what to do about it.
pub(super) fn explain(reply: &Reply) -> (String, String) {
    let stderr = its_last_words(reply);
    let next = match &reply.answer {
        Answer::ProtocolError(_) => return protocol_error(reply),
        Answer::Crashed(_) => match reply.exit {
            Some(64 | 2) => {
                "it seems to reject its arguments: it is called as DECODER VIEW FILE, VIEW being raw, coef or rgb:LU,LV"
            }
            Some(_) => {
                "fix what its standard error says; a status other than 0, 65 and 69 counts as a crash"
            }
            None => "it was killed by a signal: run it by hand, in a debugger or with a sanitizer",
        },
        Answer::Hung(_) => {
            "let it end after the frame: no window, no prompt, nothing read from standard input, which is empty"
        }
        Answer::Rejected => "this is an ordinary file: fix what its standard error says",
        Answer::Unsupported => "exit with 69 only for what it does not support",
        Answer::Flooded(_) => "print one frame and nothing else",
        Answer::OutOfMemory(_) => "allocate by the sizes in the file, or allow more by --memory",
        Answer::Tampered(_) => "open the file for reading only",
        Answer::NotStarted(_) | Answer::NotAsked(_) | Answer::Decoded(_) => "run it by hand",
    };
    (
        format!("{}{stderr}", briefly(&reply.answer)),
        next.to_owned(),
    )
}

/// The size of a buffer, if only whole buffers of a frame came.
fn multiple_of(reply: &Reply) -> Option<usize> {
    let is_multiple = |step: &usize| reply.stdout.len().is_multiple_of(*step);
    let begins = reply.stdout.starts_with(b"PTM1 ");
    [65_536, 4096]
        .into_iter()
        .find(is_multiple)
        .filter(|_| begins)
}

/// Whether a frame ends before all of it is written.
pub(super) fn cut(reply: &Reply) -> bool {
    matches!(reply.answer, Answer::ProtocolError(_)) && multiple_of(reply).is_some()
}

fn protocol_error(reply: &Reply) -> (String, String) {
    let says = briefly(&reply.answer);
    let size = reply.stdout.len();
    if size == 0 {
        let next = if reply.stderr.contains("PTM1 ") {
            "it prints the frame on standard error; print it on standard output"
        } else {
            "print the frame on standard output, and flush it before the end"
        };
        return (says, next.to_owned());
    }
    if let Some(step) = multiple_of(reply) {
        return (
            format!("its output ends after {size} bytes, a multiple of {step}: it ends before all is written\n{says}"),
            "flush standard output before the end. In Node do not call process.exit() after write(): set process.exitCode; \
             in C return from main or fflush(stdout), no _exit(); in Python sys.stdout.buffer.flush(), no os._exit()"
                .to_owned(),
        );
    }
    let next = if reply.stdout.starts_with(b"PTM1 ") {
        "write exactly as many bytes as the line announces: WIDTH · HEIGHT · CHANNELS, four times that for f32"
    } else {
        "begin with \"PTM1 VIEW WIDTH HEIGHT CHANNELS TYPE\" and a line feed; the samples follow directly"
    };
    (says, next.to_owned())
}

/// What it means that a malformed file was not refused.
pub(super) fn not_refused(reply: &Reply) -> (String, String) {
    let stderr = its_last_words(reply);
    match (&reply.answer, reply.exit) {
        (Answer::Decoded(_), _) => (
            "it prints a frame all the same".to_owned(),
            "compare sizes with what is there before reading, and exit with 65".to_owned(),
        ),
        (Answer::Unsupported, _) => (
            "exited with 69 (unsupported) instead of 65".to_owned(),
            "69 is for valid files that it does not read; a malformed file is 65".to_owned(),
        ),
        (Answer::ProtocolError(what), _) => (
            format!("it exits with 0 and prints no frame: {what}"),
            "exit with 65 where the file is malformed".to_owned(),
        ),
        (Answer::Crashed(_), Some(status)) => (
            format!("exit status {status} counts as a crash, not as a refusal{stderr}"),
            format!(
                "catch the error and exit with 65; if that cannot be changed, use check --reject-exit {status}, \
                 which marks such refusals weak"
            ),
        ),
        _ => explain(reply),
    }
}
