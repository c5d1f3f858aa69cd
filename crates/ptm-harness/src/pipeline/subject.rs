//! The subject of a check: a program, a function or a recording that answers requests.

use std::ffi::OsString;

use crate::report::shards::OtherRemarks;
use crate::runner::{caller::Caller, run::Decoder, scratch::Scratch, serve::Servers};
use crate::session::{outputs::Outputs, remark::Remark};
use ptm_suite::cases::{Expect, Suite};
use ptm_suite::protocol::capabilities::Capabilities;
use ptm_suite::protocol::frame::{Answer, Frame, View};
use ptm_suite::protocol::request::{Reply, Request};

/// The subject of a check. Every function `Fn(&Request, usize) -> Reply` is one. `V` is the type of views, and `T` that of outputs.
pub trait Subject<V = View, T = Frame>: Sync {
    /// Answers a request. `worker` identifies the thread that sends it.
    fn ask(&self, request: &Request<'_, V>, worker: usize) -> Reply<T>;

    /// Returns true if several requests may be sent at once.
    fn is_pipelined(&self) -> bool {
        false
    }

    /// Answers several requests that are sent at once. Returns the replies to the first of them, perhaps to none.
    fn ask_pipelined(&self, _requests: &[Request<'_, V>], _worker: usize) -> Vec<Reply<T>> {
        Vec::new()
    }

    /// Returns the program that decodes PTM files, if the subject is one. It is then sent additional requests.
    fn program(&self) -> Option<Program<'_>> {
        None
    }

    /// Returns the reason why requests could not be sent, if it is not the decoder's fault.
    fn trouble(&self) -> Option<String> {
        None
    }

    /// Returns remarks that are not derived from answers.
    fn remarks(&self) -> OtherRemarks {
        OtherRemarks::default()
    }
}

impl<V, T, F> Subject<V, T> for F
where
    F: Fn(&Request<'_, V>, usize) -> Reply<T> + Sync,
{
    fn ask(&self, request: &Request<'_, V>, worker: usize) -> Reply<T> {
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

impl<V, T, F> Subject<V, T> for OneShot<'_, F>
where
    F: Fn(&Request<'_, V>, usize) -> Reply<T> + Sync,
{
    fn ask(&self, request: &Request<'_, V>, worker: usize) -> Reply<T> {
        (self.ask)(request, worker)
    }

    fn trouble(&self) -> Option<String> {
        self.program.trouble().map(str::to_owned)
    }
}

/// A program that decodes PTM files.
#[derive(Clone, Copy)]
pub struct Program<'a> {
    /// The program and its limits.
    pub decoder: &'a Decoder,
    /// Directories for files and processes.
    pub scratch: &'a Scratch,
    /// The command that the user has given; empty if arguments cannot be appended to it.
    pub command: &'a [OsString],
    /// The declared capabilities.
    pub capabilities: &'a Capabilities,
    /// Advice for the case that the program is not a decoder.
    pub advice: Option<&'a str>,
}

/// Remark on a program that does not answer pipelined requests, followed by the reason and the advice.
const PIPELINING_FAILED: &str =
    "the decoder declares `pipelined`, but answers only requests that are sent one at a time";
/// Advice for a program that does not answer pipelined requests.
const PIPELINING_ADVICE: &str = "Answer all lines of standard input in order, also those that were read together, or do not declare `pipelined`";

/// A program that decodes PTM files, with its processes.
pub struct RunningProgram<'a> {
    /// The program.
    pub program: Program<'a>,
    /// The serving processes, unless each request starts a process.
    pub servers: Option<Servers<'a>>,
    /// The suite, if refusals cannot be recognized. A crash on an optional table spelling then counts as a refusal.
    pub without_refusals: Option<&'a Suite>,
}

impl Subject for RunningProgram<'_> {
    fn ask(&self, request: &Request, worker: usize) -> Reply {
        let mut reply = match &self.servers {
            Some(servers) => servers.ask(request, worker),
            None => self.program.decoder.ask(request, self.program.scratch),
        };
        if let (Some(suite), Answer::Crashed(_)) = (self.without_refusals, &reply.answer)
            && let Some(case) = suite.case(request.name)
            && case.expect == Expect::Spelling
        {
            reply.answer = Answer::Rejected;
        }
        reply
    }

    fn is_pipelined(&self) -> bool {
        self.servers.is_some() && self.program.capabilities.pipelined
    }

    fn ask_pipelined(&self, requests: &[Request], worker: usize) -> Vec<Reply> {
        let servers = self.servers.as_ref();
        servers.map_or_else(Vec::new, |servers| servers.ask_pipelined(requests, worker))
    }

    fn program(&self) -> Option<Program<'_>> {
        Some(self.program)
    }

    fn trouble(&self) -> Option<String> {
        self.program.decoder.trouble().map(str::to_owned)
    }

    /// Reports a failure of serve mode or of pipelining, and unknown words in the declared capabilities.
    fn remarks(&self) -> OtherRemarks {
        let mut remarks = OtherRemarks::default();
        if let Some(why) = self.servers.as_ref().and_then(Servers::failure) {
            remarks.before.push(Remark::failure(format!(
                "serve mode failed and was replaced by one process per request: {why}"
            )));
        }
        if let Some(failure) = self.servers.as_ref().and_then(Servers::pipelining_failure) {
            let reason = &failure.reason;
            let message = match failure.is_timeout {
                true => {
                    format!(
                        "some requests that were sent at once were not answered in time, so requests are sent one at a time: {reason}. Either a file takes long, or the decoder answers only one of several lines that it reads at once"
                    )
                }
                false => format!("{PIPELINING_FAILED}: {reason}. {PIPELINING_ADVICE}"),
            };
            remarks.before.push(Remark {
                failure: !failure.is_timeout,
                message,
            });
        }
        for remark in &self.program.capabilities.remarks {
            let message = format!("capabilities: {remark}");
            remarks.after.push(Remark::note(message));
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
