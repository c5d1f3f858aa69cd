//! Requests the first files, a large file and malformed files to find faults in a wrapper before `check` requests any case.
//!
//! A wrapper that loses bytes, swaps them, or exits with 1 fails hundreds of cases for reasons unrelated to the format. The run
//! therefore ends at this point, with the messages of [`probe`](super::probe).

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::ffi::OsString;

use crate::runner::run::Decoder;
use crate::runner::scratch::Scratch;
use crate::session::contact::{Contact, FirstReply};
use crate::session::plan::RunPlan;
use ptm_suite::cases::{Case, Suite};
use ptm_suite::kit::parallel::map_in_parallel;
use ptm_suite::protocol::frame::{Answer, View};
use ptm_suite::protocol::request::Reply;

use super::calls::Calls;
use super::checklist::{ProbeStep, Reproduction};
use super::explain::{buffer_size, explain, refusal_fault};
use super::repair::{Repair, repairs};
use super::sample::Sample;
use super::{message::ProbeFault, one_shot::malformed};

/// Returns the faults in the wrapper of `decoder`, derived from its answers to the first files, a large file and malformed files.
/// Each fault has a fix, and states how many views are affected. `command` is empty if arguments cannot be appended to it.
/// Refusals are tested only if the run judges cases that must be refused.
#[must_use]
pub fn wrapper_faults(
    command: &[OsString],
    decoder: &Decoder,
    scratch: &Scratch,
    suite: &Suite,
    plan: &RunPlan,
    contact: &Contact,
) -> Vec<ProbeStep> {
    let calls = Calls {
        command,
        decoder,
        scratch,
    };
    let replies = contact.replies(suite);
    let mut views: Vec<&View> = Vec::new();
    for reply in &replies {
        if !views.contains(&reply.view) {
            views.push(reply.view);
        }
    }
    let of_view = |&view: &&View| common_frame_fault(view, &replies);
    let faults: Vec<ProbeStep> = views.iter().filter_map(of_view).collect();
    if !faults.is_empty() {
        return merge_equal_fixes(faults);
    }
    if contact.not_a_decoder.is_some() {
        return Vec::from_iter(explain_missing_frames(&calls, &replies));
    }
    let decoded = |view: &&View| {
        let mut replies = replies.iter().filter(|reply| reply.view == *view);
        replies.find(|reply| reply.frame().is_some())
    };
    let decoded: Vec<&FirstReply> = views.iter().filter_map(decoded).collect();
    // Detect the truncation of a frame that is larger than the buffer of a pipe.
    let large = |i: usize| {
        let (first, view) = (decoded[i], decoded[i].view);
        let sample = Sample::large(first.case.format(), contact.table);
        let reply = calls.ask(view, &sample.file);
        buffer_size(&reply)?;
        let (subject, reproduction) = (sample.size_text(view), sample.reproduction(view));
        Some(ProbeStep::bad(&subject, explain(&reply), reproduction))
    };
    let cut = map_in_parallel(decoded.len(), plan.jobs, &|_, _| (), &large);
    let mut faults: Vec<ProbeStep> = cut.into_iter().flatten().collect();
    let is_judged_refusal = |(i, case): (usize, &Case)| {
        plan.selected[i] && plan.is_requested(i) && case.expect.is_refusal()
    };
    let judges_refusals = suite.cases.iter().enumerate().any(is_judged_refusal);
    if let (true, Some(&first)) = (judges_refusals, decoded.first()) {
        faults.extend(check_refusals(&calls, first, plan.jobs));
    }
    merge_equal_fixes(faults)
}

/// Merges faults with the same fix: keeps the first of them, and adds the number of other affected views.
fn merge_equal_fixes(faults: Vec<ProbeStep>) -> Vec<ProbeStep> {
    let mut list: Vec<(ProbeStep, usize)> = Vec::new();
    for fault in faults {
        match list.iter_mut().find(|(first, _)| first.next == fault.next) {
            Some((_, more)) => *more += 1,
            None => list.push((fault, 0)),
        }
    }
    let with_count = |(first, more): (ProbeStep, usize)| ProbeStep {
        message: match more {
            0 => first.message,
            1 => first.message + "\n(also in one other view)",
            _ => format!("{}\n(also in {more} other views)", first.message),
        },
        ..first
    };
    list.into_iter().map(with_count).collect()
}

impl FirstReply<'_> {
    /// Returns the received bytes; for a serving process, those of the frame.
    fn bytes(&self) -> Vec<u8> {
        match self.frame() {
            Some(frame) if self.reply.stdout.is_empty() => frame.to_bytes(),
            _ => self.reply.stdout.clone(),
        }
    }

    fn step(&self, fault: ProbeFault) -> ProbeStep {
        let file_name = format!("{}.ptm", self.case.id);
        let reproduction = Reproduction::one_shot(self.view, file_name, &self.file);
        ProbeStep::bad(self.view, fault, reproduction)
    }
}

/// Returns the smallest set of mistakes that explains most frames of a view. Returns `None` if there is no such set, if undoing
/// it only reorders samples, or if a frame is already correct.
fn common_frame_fault(view: &View, replies: &[FirstReply]) -> Option<ProbeStep> {
    let of_view = || replies.iter().filter(|reply| reply.view == view);
    if of_view().any(FirstReply::is_right) {
        return None;
    }
    let mut printed = 0;
    // The fix identifies a set of mistakes; the observation differs from file to file.
    let mut explained: BTreeMap<Vec<String>, Vec<(&FirstReply, Repair)>> = BTreeMap::new();
    for reply in of_view() {
        let bytes = reply.bytes();
        printed += usize::from(!bytes.is_empty());
        for repair in repairs(&bytes, &reply.expected, view) {
            let fixes = repair.mistakes.iter().map(|(_, next)| next.clone());
            let same = explained.entry(fixes.collect()).or_default();
            let is_last = |(last, _): &(&FirstReply, Repair)| std::ptr::eq(*last, reply);
            if !same.last().is_some_and(is_last) {
                same.push((reply, repair));
            }
        }
    }
    let by_count = |(fixes, same): &(Vec<String>, Vec<_>)| (same.len(), Reverse(fixes.len()));
    let (_, same) = explained.into_iter().max_by_key(by_count)?;
    let is_common = 2 * same.len() > printed;
    let (reply, repair) = same.into_iter().next()?;
    (is_common && !repair.reorders).then(|| reply.step(repair.fault()))
}

/// Explains why the decoder returned no frame for any first file, based on the first reply that violates the protocol, or on the
/// first reply if none does.
fn explain_missing_frames(calls: &Calls, replies: &[FirstReply]) -> Option<ProbeStep> {
    let failed = |reply: &&FirstReply| reply.reply.answer.violation().is_some();
    let first = replies.iter().find(failed).or_else(|| replies.first())?;
    match first.reply.answer {
        Answer::Unsupported | Answer::NotStarted(_) | Answer::NotAsked(_) => return None,
        _ if calls.command.is_empty() => return None,
        _ => {}
    }
    let known = calls.explain_no_frame(&first.file, &first.expected, first.view, first.reply);
    let missing = || calls.check_command().err();
    let known = known.or_else(|| is_missing_file(first.reply).then(missing).flatten());
    // The answer itself has already been reported.
    let unknown = || {
        (
            "this is an ordinary file".to_owned(),
            explain(first.reply).1,
        )
    };
    Some(first.step(known.unwrap_or_else(unknown)))
}

/// Returns true if an interpreter seems not to have found the file of the decoder.
fn is_missing_file(reply: &Reply) -> bool {
    let words = ["open", "find", "such file", "access"];
    let mut lines = reply.stderr.lines();
    let says_so = lines.any(|line| words.iter().any(|word| line.contains(word)));
    reply.stdout.is_empty() && reply.exit != Some(0) && says_so
}

/// Returns a fault if all malformed files cause the same exit status and this status does not mean a refusal.
fn check_refusals(calls: &Calls, first: &FirstReply, jobs: usize) -> Option<ProbeStep> {
    let files = malformed(&first.file);
    let ask = |i: usize| calls.ask(first.view, files[i].2);
    let replies = map_in_parallel(files.len(), jobs, &|_, _| (), &ask);
    let is_crash = |reply: &Reply| matches!(reply.answer, Answer::Crashed(_));
    let exit = replies[0].exit?;
    if !(replies.iter()).all(|reply| is_crash(reply) && reply.exit == Some(exit)) {
        return None;
    }
    let (subject, file_name, file) = files[0];
    let subject = format!("{subject}, and other malformed files");
    let reproduction = Reproduction::one_shot(first.view, file_name, file);
    Some(ProbeStep::bad(
        &subject,
        refusal_fault(&replies[0]),
        reproduction,
    ))
}
