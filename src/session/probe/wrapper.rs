//! Faults of a wrapper, found by `check` before any case is requested, with the first files, a large one and malformed ones.
//!
//! A wrapper that loses bytes, swaps them, or exits with 1 fails hundreds of cases for reasons unrelated to the format. So the
//! run ends here, with the messages of [`probe`](super::probe).

use std::collections::BTreeMap;

use crate::kit::parallel::in_parallel;
use crate::protocol::frame::{Answer, View};
use crate::runner::run::Reply;
use crate::session::contact::{Contact, First};
use crate::suite::cases::{Case, Suite, TableSpelling};
use crate::suite::compare::Expected;

use super::calls::Calls;
use super::checklist::{Mark, ProbeStep, Reproduction};
use super::explain::{explain, is_cut, not_refused};
use super::message::ProbeFault;
use super::one_shot::{malformed, why_no_frame};
use super::repair::{Repair, repairs};
use super::sample::Sample;

/// A reply to a first file, and that of a correct decoder.
struct FirstReply<'a> {
    case: &'a Case,
    view: &'a View,
    file: Vec<u8>,
    expected: Expected,
    reply: &'a Reply,
}

/// Returns faults of the wrapper, each with a fix and the number of affected views; `jobs` requests are sent in parallel to
/// find them. Refusals are tested only if the run is to judge any.
pub(super) fn faults(
    calls: &Calls,
    suite: &Suite,
    contact: &Contact,
    judges_refusals: bool,
    jobs: usize,
) -> Vec<ProbeStep> {
    let replies: Vec<FirstReply> = (contact.first.iter())
        .filter_map(|first| FirstReply::new(suite, first))
        .collect();
    let mut views: Vec<&View> = Vec::new();
    for reply in &replies {
        if !views.contains(&reply.view) {
            views.push(reply.view);
        }
    }
    let mut faults: Vec<ProbeStep> = (views.iter())
        .filter_map(|&view| of_frames(view, &replies))
        .collect();
    if !faults.is_empty() {
        return each_once(faults);
    }
    if contact.not_a_decoder.is_some() {
        faults.extend(no_frame(calls, &replies));
        return faults;
    }
    let sizes = views
        .iter()
        .filter_map(|&view| first_decoded(view, &replies));
    let sizes: Vec<&FirstReply> = sizes.collect();
    let large = |i: usize| cut_frame(calls, sizes[i], contact.table);
    let cut = in_parallel(sizes.len(), jobs, &|_, _| (), &large);
    faults.extend(cut.into_iter().flatten());
    if let (true, Some(&first)) = (judges_refusals, sizes.first()) {
        faults.extend(no_refusal(calls, first, jobs));
    }
    each_once(faults)
}

/// Keeps the first of several faults with the same fix, with the number of the others.
fn each_once(faults: Vec<ProbeStep>) -> Vec<ProbeStep> {
    let mut each: Vec<(ProbeStep, usize)> = Vec::new();
    for fault in faults {
        match each.iter_mut().find(|(first, _)| first.next == fault.next) {
            Some((_, more)) => *more += 1,
            None => each.push((fault, 0)),
        }
    }
    let with_count = |(first, more): (ProbeStep, usize)| ProbeStep {
        says: match more {
            0 => first.says,
            1 => format!("{}\n(and likewise in another view)", first.says),
            _ => format!("{}\n(and likewise in {more} other views)", first.says),
        },
        ..first
    };
    each.into_iter().map(with_count).collect()
}

impl<'a> FirstReply<'a> {
    fn new(suite: &'a Suite, first: &'a First) -> Option<FirstReply<'a>> {
        let case = &suite.cases[first.case];
        let built = case.build(TableSpelling::default());
        Some(FirstReply {
            case,
            view: &first.view,
            file: built.file.clone(),
            expected: Expected::of(&built.values, &first.view)?,
            reply: &first.reply,
        })
    }

    fn is_decoded(&self) -> bool {
        matches!(self.reply.answer, Answer::Decoded(_))
    }

    /// Returns the received bytes: as they are, or those of the frame if a serving process answered.
    fn bytes(&self) -> Vec<u8> {
        match &self.reply.answer {
            Answer::Decoded(frame) if self.reply.stdout.is_empty() => {
                let mut bytes = Vec::new();
                frame
                    .write(&mut bytes)
                    .expect("writing to memory does not fail");
                bytes
            }
            _ => self.reply.stdout.clone(),
        }
    }

    fn is_right(&self) -> bool {
        let Answer::Decoded(frame) = &self.reply.answer else {
            return false;
        };
        self.expected.compare(frame).is_none()
    }

    fn step(&self, (says, next): ProbeFault) -> ProbeStep {
        let file_name = format!("{}.ptm", self.case.id);
        let repeat = Reproduction::one_shot(self.view, file_name, &self.file);
        step(format!("{}: {says}", self.view), next, repeat)
    }
}

fn step(says: String, next: String, repeat: Reproduction) -> ProbeStep {
    ProbeStep {
        mark: Mark::Bad,
        says,
        next: Some(next),
        repeat: Some(repeat),
    }
}

/// Returns the smallest set of mistakes that, undone, corrects most frames of a view, one of them a wrapper's.
fn of_frames(view: &View, replies: &[FirstReply]) -> Option<ProbeStep> {
    let of_view = || replies.iter().filter(|reply| reply.view == view);
    if of_view().any(FirstReply::is_right) {
        return None;
    }
    let printed: Vec<(&FirstReply, Vec<u8>)> = of_view()
        .map(|reply| (reply, reply.bytes()))
        .filter(|(_, bytes)| !bytes.is_empty())
        .collect();
    // The fix identifies a set of mistakes; the observation differs from file to file.
    let mut explained: BTreeMap<Vec<String>, Vec<(&FirstReply, Repair)>> = BTreeMap::new();
    for (reply, bytes) in &printed {
        for repair in repairs(bytes, &reply.expected, view) {
            let key: Vec<String> = repair
                .0
                .iter()
                .map(|mistake| mistake.next.clone())
                .collect();
            let of_key = explained.entry(key).or_default();
            if of_key
                .last()
                .is_none_or(|(last, _)| last.case.id != reply.case.id)
            {
                of_key.push((reply, repair));
            }
        }
    }
    let by_count = |(key, of): &(&Vec<String>, &Vec<_>)| (of.len(), std::cmp::Reverse(key.len()));
    let (_, of) = explained.iter().max_by_key(by_count)?;
    let (reply, repair) = of.first()?;
    let of_wrapper = repair.0.iter().any(|mistake| !mistake.is_order);
    (of_wrapper && 2 * of.len() > printed.len()).then(|| reply.step(repair.fault()))
}

/// Returns the reason why no first file gave a frame, from the first reply that shows one.
fn no_frame(calls: &Calls, replies: &[FirstReply]) -> Option<ProbeStep> {
    let tells = |reply: &&FirstReply| reply.reply.answer.violation().is_some();
    let first = replies.iter().find(tells).or_else(|| replies.first())?;
    let is_plain = matches!(
        first.reply.answer,
        Answer::Unsupported | Answer::NotStarted(_) | Answer::NotAsked(_)
    );
    if calls.command.is_empty() || is_plain {
        return None;
    }
    let file = (&first.file[..], &first.expected);
    let known = why_no_frame(calls, file, first.view, first.reply);
    // The answer itself has been reported.
    let unknown = || {
        (
            "this is an ordinary file".to_owned(),
            explain(first.reply).1,
        )
    };
    Some(first.step(known.unwrap_or_else(unknown)))
}

/// Returns the first file that was decoded in a view.
fn first_decoded<'a>(view: &View, replies: &'a [FirstReply]) -> Option<&'a FirstReply<'a>> {
    let mut of_view = replies.iter().filter(|reply| reply.view == view);
    of_view.find(|reply| reply.is_decoded())
}

/// Checks for a truncated frame that is larger than the buffer of a pipe.
fn cut_frame(calls: &Calls, first: &FirstReply, table: TableSpelling) -> Option<ProbeStep> {
    let sample = Sample::new(first.case.format(), "201x149", table);
    let reply = calls.ask(first.view, &sample.file);
    if !is_cut(&reply) {
        return None;
    }
    let (says, next) = explain(&reply);
    let says = format!(
        "a frame of {} texels in {}: {says}",
        sample.size.texels(),
        first.view
    );
    Some(step(says, next, sample.repeat(first.view)))
}

/// Checks for malformed files that all end in one exit status which is not that of a refusal.
fn no_refusal(calls: &Calls, first: &FirstReply, jobs: usize) -> Option<ProbeStep> {
    let files = malformed(&first.file);
    let ask = |i: usize| calls.ask(first.view, files[i].2);
    let replies = in_parallel(files.len(), jobs, &|_, _| (), &ask);
    let status = replies[0].exit?;
    let exits =
        |reply: &Reply| matches!(reply.answer, Answer::Crashed(_)) && reply.exit == Some(status);
    if !replies.iter().all(exits) {
        return None;
    }
    let (says, next) = not_refused(&replies[0]);
    let (what, file_name, file) = files[0];
    let says = format!("{what}, and other malformed ones: {says}");
    let repeat = Reproduction::one_shot(first.view, file_name, file);
    Some(step(says, next, repeat))
}
