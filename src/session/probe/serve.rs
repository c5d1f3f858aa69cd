//! The steps of a probe in serve mode, which is optional but faster: one process for all files.
//!
//! `DECODER serve` reads lines `SEQ VIEW PATH` and answers each with `SEQ ok NBYTES` and a frame, `SEQ reject 65` or `SEQ
//! unsupported FEATURE`, at once. The right answer here is that of one-shot mode, even if that image is wrong.

use crate::protocol::forms;
use crate::protocol::frame::{Answer, EXIT_MALFORMED, Frame, View};

use super::calls::Calls;
use super::checklist::{Checklist, ProbeRequest, Reproduction};
use super::dialog::{Dialog, Served, ServedAnswer};
use super::message::{ProbeFault, fault};
use super::sample::Sample;

const NOT_OFFERED: &str = "serve: not offered, and not needed";

const MALFORMED: &[u8] = b"PTM_1.2\n";

/// The reason why the steps end before the last one.
enum Stop {
    NotOffered,
    /// A fault that occurs after this number of requests.
    Fault(usize, ProbeFault),
}

/// Takes the steps of serve mode: two frames and a refusal, each answered before the next request, then the end.
pub(super) fn look(calls: &Calls, sample: &Sample, view: &View, list: &mut Checklist) {
    let one_shot = calls.ask(view, &sample.file);
    let Answer::Decoded(right) = one_shot.answer else {
        return;
    };
    match steps(calls, sample, view, &right, list) {
        Ok(()) => {}
        Err(Stop::NotOffered) => list.absent(NOT_OFFERED),
        Err(Stop::Fault(count, (says, next))) => {
            let repeat = requests(sample, view, count);
            list.bad(format!("serve: {says}"), next, repeat);
        }
    }
}

fn steps(
    calls: &Calls,
    sample: &Sample,
    view: &View,
    right: &Frame,
    list: &mut Checklist,
) -> Result<(), Stop> {
    let mut dialog = Dialog::start(calls).ok_or(Stop::NotOffered)?;
    let whole = dialog.lay_down("one file.ptm", &sample.file);
    let malformed = dialog.lay_down("malformed.ptm", MALFORMED);
    let at = |count| move |fault| Stop::Fault(count, fault);
    match dialog.ask(1, view, &whole) {
        Served::Answer(answer) => judge(&answer, view, right).map_err(at(1))?,
        Served::Nothing => return Err(kept_back(dialog)),
        Served::Gone(_) => return Err(Stop::NotOffered),
        Served::Wrong(fault) => return Err(Stop::Fault(1, fault)),
    }
    list.good("serve: the first request is answered at once, as in one-shot mode");
    refused(dialog.ask(2, view, &malformed), calls.decoder.reject_exit).map_err(at(2))?;
    list.good("serve: a malformed file is refused");
    answered_again(&dialog.ask(3, view, &whole), view, right).map_err(at(3))?;
    list.good("serve: what was refused leaves no trace");
    match dialog.end() {
        Served::Gone(true) => {
            list.good("serve: it ends when its input ends");
            Ok(())
        }
        _ => Err(Stop::Fault(3, fault("serve-end", &[]))),
    }
}

/// Returns the first requests of the dialog.
fn requests(sample: &Sample, view: &View, count: usize) -> Reproduction {
    let whole = sample.repeat(view).requests.remove(0);
    let malformed = ProbeRequest {
        file_name: "malformed.ptm".to_owned(),
        file: MALFORMED.to_vec(),
        ..whole.clone()
    };
    let mut requests = vec![whole.clone(), malformed, whole];
    requests.truncate(count);
    Reproduction {
        serve: true,
        requests,
    }
}

/// Explains a missing answer. Some programs take the word for a view and wait; some answer when their input ends.
fn kept_back(mut dialog: Dialog) -> Stop {
    match dialog.end() {
        Served::Answer(answer) if answer.line.starts_with("1 ") => {
            Stop::Fault(1, fault("serve-buffered", &[]))
        }
        _ => Stop::NotOffered,
    }
}

/// Checks that an answer is the frame of one-shot mode.
fn judge(answer: &ServedAnswer, view: &View, right: &Frame) -> Result<(), ProbeFault> {
    let most = answer.bytes.len().max(1 << 16);
    let frame = forms::read(&answer.bytes, view, most).map_err(|error| {
        let name = match answer.bytes.contains(&b'\n') {
            true => "serve-count",
            false => "serve-frame",
        };
        fault(
            name,
            &[("error", &error), ("line", &format!("{:?}", answer.line))],
        )
    })?;
    match frame.is_like(right) {
        true => Ok(()),
        false => Err(fault("serve-differs", &[])),
    }
}

fn refused(served: Served, reject_exit: Option<i32>) -> Result<(), ProbeFault> {
    let is_refusal = |line: &str| {
        let code = line.trim_end().strip_prefix("2 reject ");
        let code = code.and_then(|code| code.parse().ok());
        code.is_some() && (code == Some(EXIT_MALFORMED) || code == reject_exit)
    };
    match served {
        Served::Answer(answer) if is_refusal(&answer.line) => Ok(()),
        Served::Answer(answer) => {
            let line = format!("{:?}", answer.line);
            Err(fault("serve-wrong-refusal", &[("line", &line)]))
        }
        Served::Gone(_) => Err(fault("serve-gone", &[])),
        Served::Nothing | Served::Wrong(_) => Err(fault("serve-no-refusal", &[])),
    }
}

fn answered_again(served: &Served, view: &View, right: &Frame) -> Result<(), ProbeFault> {
    match served {
        Served::Answer(answer) if judge(answer, view, right).is_ok() => Ok(()),
        Served::Answer(_) => Err(fault("serve-state", &[])),
        _ => Err(fault("serve-third", &[])),
    }
}
