//! Checklist for authors of writers: one request per format, and the fault of each file.

use crate::cases::load_writer_requests;
use crate::{asking, cases::WriterCase};
use crate::{judge::judge, misread_file::explains};
use crate::{reference::write_requested_file, test_case::WrittenFile};
use ptm_harness::runner::run::Decoder;
use ptm_harness::runner::scratch::Scratch;
use ptm_harness::session::probe::Checklist;
use ptm_mistakes::writing;
use ptm_suite::kit::last_message::quote_last_message;
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::{AttemptKind, Reply};

/// Runs all steps of the checklist against `writer`.
///
/// # Errors
/// Returns an error if the embedded requests cannot be loaded.
pub fn probe(writer: &Decoder, scratch: &Scratch) -> Result<Checklist, String> {
    let suite = load_writer_requests()?;
    let mut list = Checklist::default();
    for case in suite.cases.iter().filter(|case| case.first) {
        let reply = asking::request_file(writer, case, AttemptKind::Alone, scratch);
        let format = case.format.short_name();
        match &reply.answer {
            Answer::Decoded(file) => check_file(&mut list, case, file),
            Answer::Unsupported => {
                list.add_absent(format!("the writer does not write {format} (status 69)"));
            }
            _ => {
                let (says, next) = explain_answer(&reply);
                list.add_bad(format!("{format}: {says}"), next);
            }
        }
        // A program that cannot be started, or takes too long, fails in the same way for every format.
        if matches!(reply.answer, Answer::NotStarted(_) | Answer::TimedOut(_)) {
            return Ok(list);
        }
    }
    if !list.has_frames && list.faults() == 0 {
        let next = "write at least one format; most readers support LRGB";
        list.add_bad(
            "the writer answers every request with 69 (unsupported)",
            next,
        );
    }
    Ok(list)
}

/// Adds a step to the checklist: the file is correct, or it has a fault with a likely cause.
fn check_file(list: &mut Checklist, case: &WriterCase, file: &WrittenFile) {
    list.has_frames = true;
    let (request, format) = (case.request(), case.format.short_name());
    let fault = match judge(&request, &file.0) {
        Ok(()) => {
            return list.add_good(format!("{format}: the file contains the requested values"));
        }
        Err(fault) => fault,
    };
    let right = write_requested_file(&request).unwrap_or_default();
    let mistake = writing::all().find(|m| explains(&request, &right, &file.0, m.change));
    let next = match mistake.map(|mistake| (mistake.effect, mistake.fix)) {
        Some((effect, fix)) => format!("a writer that {effect} would produce this file: {fix}"),
        None => format!("clause {}: ptm-conform explain {0}", fault.clause),
    };
    list.add_bad(format!("{format}: {fault}"), next);
}

fn explain_answer(reply: &Reply<WrittenFile>) -> (String, &'static str) {
    let next = match &reply.answer {
        Answer::ProtocolError(_) if reply.stdout.starts_with(b"PTM_1.") => {
            "write to the file OUT, not to standard output"
        }
        Answer::ProtocolError(_) => "write the file to OUT, the last argument",
        Answer::Crashed(_) => "exit with 0, 65 or 69; any other status counts as a crash",
        Answer::TimedOut(_) => {
            "exit after writing the file, without waiting for input; if the writer needs more time, raise the limit with --timeout"
        }
        Answer::Rejected => {
            "the request is ordinary, so the writer must not refuse it; fix the error that the writer prints to standard error"
        }
        Answer::Flooded(_) => "write only the requested file",
        Answer::OutOfMemory(_) => "allocate buffers for the sizes in the request",
        Answer::Tampered(_) => "open the request and the planes for reading only",
        _ => "run the writer by hand from another directory",
    };
    let name = reply.answer.name();
    let problem = reply.answer.violation().unwrap_or(name.into());
    let last = quote_last_message("\n", &reply.stderr);
    (format!("{problem}{last}"), next)
}
