//! Guides the author of a decoder through the protocol, step by step.
//!
//! `check` judges; this explains. Each step sends one request to the decoder and describes errors and their fixes. A wrong
//! answer is also repaired in all the ways in which wrappers are known to fail (text before the frame, line ends, byte order,
//! planar samples, rows upside down …), and the repair that makes it right is the fix.

use std::ffi::OsString;

use crate::runner::run::Decoder;
use crate::runner::scratch::Scratch;
use crate::session::contact::Contact;
use crate::session::plan::RunPlan;
use crate::suite::cases::{Case, Expect, Suite};

pub(super) use arrangement::Arrangement;
pub use checklist::{Checklist, Mark, ProbeRequest, ProbeStep, Reproduction};

mod arrangement;
mod body;
mod calls;
mod checklist;
mod command;
mod dialog;
mod explain;
mod message;
mod one_shot;
mod repair;
mod sample;
mod serve;
mod wrapper;

/// Returns the faults of the wrapper of `decoder`, from its answers to the first files, a large one and malformed ones; none if
/// it is ready. `command` is empty if it is not a command to which the file can be appended.
#[must_use]
pub fn wrapper_faults(
    command: &[OsString],
    decoder: &Decoder,
    scratch: &Scratch,
    suite: &Suite,
    plan: &RunPlan,
    contact: &Contact,
) -> Vec<ProbeStep> {
    let calls = calls::Calls {
        command,
        decoder,
        scratch,
    };
    let is_judged_refusal = |(i, case): (usize, &Case)| {
        plan.selected[i] && plan.asks(i) && matches!(case.expect, Expect::Reject | Expect::Refuse)
    };
    let judges_refusals = suite.cases.iter().enumerate().any(is_judged_refusal);
    wrapper::faults(&calls, suite, contact, judges_refusals, plan.jobs)
}

/// Takes all steps with `decoder`, which was made from `command`.
#[must_use]
pub fn probe(command: &[OsString], decoder: &Decoder, scratch: &Scratch) -> Checklist {
    let calls = calls::Calls {
        command,
        decoder,
        scratch,
    };
    let mut list = Checklist::default();
    if let Err((says, next)) = command::look(command) {
        list.bad(says, next, None);
        return list;
    }
    let Some(first) = one_shot::first_frame(&calls, &mut list) else {
        return list;
    };
    list.answers = true;
    one_shot::large_frame(&calls, &first, &mut list);
    one_shot::refusals(&calls, &first, &mut list);
    one_shot::unknown_view(&calls, &first.sample, &mut list);
    one_shot::capabilities(&calls, &mut list);
    serve::look(&calls, &first.sample, &first.views[0], &mut list);
    list
}
