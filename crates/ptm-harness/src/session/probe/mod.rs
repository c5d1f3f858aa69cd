//! Guides the author of a decoder through the protocol, step by step.
//!
//! `check` judges, and `probe` explains. Each step sends requests to the decoder and describes errors and their fixes. For a
//! wrong answer, known mistakes of wrappers (text before the frame, line endings, byte order, planar samples, flipped rows and
//! others) are undone, singly and in combination. The combination that makes the answer correct tells the author what to fix.

use std::ffi::OsString;

use crate::runner::{run::Decoder, scratch::Scratch};

pub(super) use arrangement::Arrangement;
pub use checklist::{Checklist, Mark, ProbeRequest, ProbeStep, Reproduction};
pub(super) use message::{ProbeFault, join_texts};
pub use wrapper::wrapper_faults;

mod arrangement;
mod body;
mod calls;
mod checklist;
mod explain;
mod message;
mod one_shot;
mod repair;
mod sample;
mod serve;
mod wrapper;

/// Runs all steps with `decoder`, which was created from `command`.
#[must_use]
pub fn probe(command: &[OsString], decoder: &Decoder, scratch: &Scratch) -> Checklist {
    let calls = calls::Calls {
        command,
        decoder,
        scratch,
    };
    let mut list = Checklist::default();
    if let Err((says, next)) = calls.check_command() {
        list.add_bad(says, next);
        return list;
    }
    let Some(first) = one_shot::find_first_frames(&calls, &mut list) else {
        return list;
    };
    list.has_frames = true;
    one_shot::request_other_formats(&calls, &first, &mut list);
    one_shot::request_large_frame(&calls, &first, &mut list);
    one_shot::request_malformed_files(&calls, &first, &mut list);
    one_shot::request_unknown_view(&calls, &first.sample, &mut list);
    one_shot::request_capabilities(&calls, &mut list);
    serve::probe_serve_mode(&calls, &first, &mut list);
    list
}
