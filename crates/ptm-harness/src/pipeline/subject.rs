//! The subject of a check: a program, a function or a recording that answers requests.

use std::ffi::OsString;

use crate::report::shards::OtherRemarks;
use crate::runner::{caller::Caller, run::Decoder, scratch::Scratch, serve::Servers};
use crate::session::probe::{ProbeStep, wrapper_faults};
use crate::session::{asking::ReplyTo, contact::Contact, locale, outputs::Outputs};
use crate::session::{plan::RunPlan, remark::Remark, run::Run};
use ptm_suite::cases::{Case, Expect, Suite};
use ptm_suite::protocol::capabilities::Capabilities;
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::{Reply, Request};
use ptm_suite::test_case::TestCase;

/// The subject of a check. Every function `Fn(&Request, usize) -> Reply` is one.
pub trait Subject<C: TestCase = Case>: Sync {
    /// Answers a request. `worker` identifies the thread that sends it.
    fn ask(&self, request: &Request<'_, C::View>, worker: usize) -> ReplyTo<C>;

    /// Returns faults in the wrapper of a program, found with additional requests after first contact.
    fn wrapper_faults(&self, _: &Suite<C>, _: &RunPlan, _: &Contact<C>) -> Vec<ProbeStep> {
        Vec::new()
    }

    /// Returns advice for the case that the program is not a decoder.
    fn advice(&self) -> Option<&str> {
        None
    }

    /// Returns the reason why requests could not be sent, if it is not the decoder's fault.
    fn trouble(&self) -> Option<String> {
        None
    }

    /// Returns remarks that are not derived from the answers of `run`.
    fn remarks(&self, _suite: &Suite<C>, _run: &Run<C>) -> OtherRemarks {
        OtherRemarks::default()
    }
}

impl<C: TestCase, F> Subject<C> for F
where
    F: Fn(&Request<'_, C::View>, usize) -> ReplyTo<C> + Sync,
{
    fn ask(&self, request: &Request<'_, C::View>, worker: usize) -> ReplyTo<C> {
        self(request, worker)
    }
}

/// A program that is started anew for each request.
pub struct OneShot<'a, F> {
    /// The program and its limits.
    pub program: &'a Decoder,
    /// Sends a request to the program.
    pub ask: F,
}

impl<C: TestCase, F> Subject<C> for OneShot<'_, F>
where
    F: Fn(&Request<'_, C::View>, usize) -> ReplyTo<C> + Sync,
{
    fn ask(&self, request: &Request<'_, C::View>, worker: usize) -> ReplyTo<C> {
        (self.ask)(request, worker)
    }

    fn trouble(&self) -> Option<String> {
        self.program.trouble().map(str::to_owned)
    }
}

/// A program that decodes PTM files.
pub struct Program<'a> {
    /// The program and its limits.
    pub decoder: &'a Decoder,
    /// The serving processes, unless each request starts a process.
    pub servers: Option<Servers<'a>>,
    /// Directories for files and processes.
    pub scratch: &'a Scratch,
    /// The command that the user has given; empty if arguments cannot be appended to it.
    pub command: &'a [OsString],
    /// The declared capabilities.
    pub capabilities: &'a Capabilities,
    /// Advice for the case that the program is not a decoder.
    pub advice: Option<String>,
    /// The suite, if refusals cannot be recognized. A crash on an optional table spelling then counts as a refusal.
    pub without_refusals: Option<&'a Suite>,
}

impl Subject for Program<'_> {
    fn ask(&self, request: &Request, worker: usize) -> Reply {
        let mut reply = match &self.servers {
            Some(servers) => servers.ask(request, worker),
            None => self.decoder.ask(request, self.scratch),
        };
        if let (Some(suite), Answer::Crashed(_)) = (self.without_refusals, &reply.answer)
            && let Some(case) = suite.case(request.name)
            && case.expect == Expect::Spelling
        {
            reply.answer = Answer::Rejected;
        }
        reply
    }

    fn wrapper_faults(&self, suite: &Suite, plan: &RunPlan, contact: &Contact) -> Vec<ProbeStep> {
        let (command, decoder) = (self.command, self.decoder);
        wrapper_faults(command, decoder, self.scratch, suite, plan, contact)
    }

    fn advice(&self) -> Option<&str> {
        self.advice.as_deref()
    }

    fn trouble(&self) -> Option<String> {
        self.decoder.trouble().map(str::to_owned)
    }

    /// Reports a failure of serve mode, unknown words in the declared capabilities, and different answers in a locale with a
    /// decimal comma, if the system has one.
    fn remarks(&self, suite: &Suite, run: &Run) -> OtherRemarks {
        let mut remarks = OtherRemarks::default();
        let is_whole = run.not_a_decoder.is_none() && run.ended_early.is_none();
        for remark in &self.capabilities.remarks {
            let message = format!("capabilities: {remark}");
            remarks.after.push(Remark::note(message));
        }
        if is_whole && let Some(locale) = locale::comma_locale() {
            let difference = locale::difference(suite, run, self.decoder, &locale, self.scratch);
            remarks.after.extend(difference.map(Remark::failure));
        }
        if let Some(why) = self.servers.as_ref().and_then(Servers::failure) {
            remarks.before.push(Remark::failure(format!(
                "serve mode failed and was replaced by one process per request: {why}"
            )));
        }
        remarks
    }
}

/// Answers from files.
impl Subject for &Outputs {
    fn ask(&self, request: &Request, _: usize) -> Reply {
        Outputs::ask(self, request)
    }
}

/// Answers of a function in the parent process.
impl Subject for &Caller {
    fn ask(&self, request: &Request, _: usize) -> Reply {
        Caller::ask(self, request)
    }
}
