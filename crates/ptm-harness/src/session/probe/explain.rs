//! Explanations of answers that are not frames.

use ptm_suite::kit::last_message::quote_last_message;
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::Reply;

use super::message::{ProbeFault, Slots, fault};

pub(super) fn explain(reply: &Reply) -> ProbeFault {
    let size = reply.stdout.len();
    let name = match &reply.answer {
        Answer::ProtocolError(_) => match buffer_size(reply) {
            _ if size == 0 && reply.stderr.contains("PTM1 ") => "frame-on-stderr",
            _ if size == 0 => "no-output",
            Some(_) => "cut",
            None if reply.stdout.starts_with(b"PTM1 ") => "wrong-length",
            None => "no-line",
        },
        Answer::Crashed(_) => match reply.exit {
            Some(64 | 2) => "usage-error",
            Some(_) => "crash",
            None => "signal",
        },
        Answer::TimedOut(_) => "time-limit",
        Answer::Rejected => "refusal",
        Answer::Unsupported => "unsupported",
        Answer::Flooded(_) => "flood",
        Answer::OutOfMemory(_) => "out-of-memory",
        Answer::Tampered(_) => "changed-input",
        Answer::NotStarted(_) | Answer::NotAsked(_) | Answer::Decoded(_) => "by-hand",
    };
    let stderr = quote_last_message("\n", &reply.stderr);
    let answer = reply.answer.describe();
    let step = buffer_size(reply).unwrap_or_default();
    let slots: &Slots = &[("size", &size), ("step", &step)];
    let slots = [slots, &[("answer", &answer), ("stderr", &stderr)]].concat();
    fault(name, &slots)
}

/// Returns the buffer size if the output is a frame that was truncated after a whole number of buffers.
pub(super) fn buffer_size(reply: &Reply) -> Option<usize> {
    let is_multiple = |step: &usize| reply.stdout.len().is_multiple_of(*step);
    let begins = reply.stdout.starts_with(b"PTM1 ");
    let step = [65_536, 4096].into_iter().find(is_multiple);
    step.filter(|_| begins && matches!(reply.answer, Answer::ProtocolError(_)))
}

/// Explains an answer to a malformed file that was not refused.
pub(super) fn refusal_fault(reply: &Reply) -> ProbeFault {
    match (&reply.answer, reply.exit) {
        (Answer::Decoded(_), _) => fault("accepted", &[]),
        (Answer::Unsupported, _) => fault("unsupported-malformed", &[]),
        (Answer::ProtocolError(what), _) => fault("silent-malformed", &[("what", what)]),
        (Answer::Crashed(_), Some(status)) => {
            let stderr = quote_last_message("\n", &reply.stderr);
            let slots: &Slots = &[("status", &status), ("stderr", &stderr)];
            fault("crash-malformed", slots)
        }
        _ => explain(reply),
    }
}
