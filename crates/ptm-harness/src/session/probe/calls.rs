//! Calls to the probed decoder, both as defined by the protocol and in other ways.

use std::ffi::OsString;
use std::path::Path;

use crate::runner::run::Decoder;
use crate::runner::scratch::Scratch;
use crate::runner::start::{check_program, is_script_name};
use crate::runner::template::Template;
use ptm_suite::compare::Expected;
use ptm_suite::protocol::frame::{Answer, View};
use ptm_suite::protocol::request::{Reply, Request};

use super::message::{ProbeFault, fault};
use super::repair::repair;
use super::sample::MAX_TEXELS;

/// Calls the probed decoder in a scratch directory.
pub(super) struct Calls<'a> {
    /// Command that starts the decoder; empty if arguments cannot be appended to the command.
    pub(super) command: &'a [OsString],
    pub(super) decoder: &'a Decoder,
    pub(super) scratch: &'a Scratch,
}

impl Calls<'_> {
    pub(super) fn check_command(&self) -> Result<(), ProbeFault> {
        let Some((program, words)) = self.command.split_first() else {
            return Err(fault("no-command", &[]));
        };
        check_program(program, &program.to_string_lossy())?;
        for word in words {
            let text = word.to_string_lossy();
            let is_script = is_script_name(&text) && !text.starts_with('-');
            if is_script && !Path::new(word).exists() {
                return Err(fault("no-script", &[("word", &text)]));
            }
        }
        Ok(())
    }

    /// Sends a request as defined by the protocol.
    pub(super) fn ask(&self, view: &View, file: &[u8]) -> Reply {
        self.call_with_template(None, view, file)
    }

    /// Calls the decoder with a word that is not a view.
    pub(super) fn call_with_word(&self, word: &str, after: &[&str], file: &[u8]) -> Reply {
        let words = self.template_around(&[], &[&[word][..], after].concat());
        self.call_with_template(Some(words), &View::Raw, file)
    }

    fn call_with_template(&self, template: Option<Template>, view: &View, file: &[u8]) -> Reply {
        // All output is examined, so the limit leaves room for 18 values per texel in any type, also for compressed files.
        let texels = file.len().max(MAX_TEXELS);
        let request = Request::new("probe", view, file, texels * 18 * size_of::<f32>());
        let other = template.map(|template| self.decoder.with_command_line(template));
        (other.as_ref().unwrap_or(self.decoder)).ask(&request, self.scratch)
    }

    fn template_around(&self, before: &[&str], after: &[&str]) -> Template {
        let before = before.iter().map(OsString::from);
        let after = after.iter().map(OsString::from);
        let command = self.decoder.command().iter().cloned();
        Template::from_words(&before.chain(command).chain(after).collect::<Vec<_>>())
    }

    /// Explains an answer that is not a frame, if the cause is known.
    pub(super) fn explain_no_frame(
        &self,
        file: &[u8],
        expected: &Expected,
        view: &View,
        reply: &Reply,
    ) -> Option<ProbeFault> {
        let last = reply.stderr.lines().last().unwrap_or_default();
        let not_run = match (&reply.answer, reply.exit) {
            (Answer::NotStarted(why), _) => Some(("not-started", why.as_str())),
            (Answer::Crashed(_), Some(127)) => Some(("status-127", last)),
            (Answer::Crashed(_), Some(126)) => Some(("status-126", last)),
            _ => None,
        };
        let not_run = not_run.filter(|_| !self.command.is_empty());
        let not_run = not_run.map(|(name, why)| fault(name, &[("why", &why), ("last", &why)]));
        let known = repair(&reply.stdout, expected, view).or(not_run);
        // A decoder that exceeds the time limit would exceed it with any command line.
        if known.is_some() || matches!(reply.answer, Answer::TimedOut(_)) {
            return known;
        }
        self.find_other_call(file, expected, view)
    }

    /// Finds a different command line that makes the decoder print a frame.
    fn find_other_call(&self, file: &[u8], expected: &Expected, view: &View) -> Option<ProbeFault> {
        let here = std::env::current_dir().ok()?;
        let (here, stdin) = (here.to_string_lossy(), "exec \"$@\" < \"$0\"");
        let home = ["sh", "-c", "cd \"$0\" && exec \"$@\"", &here];
        let from_stdin = ["sh", "-c", stdin, "{in}"];
        let ways: [(&[&str], &[&str], &str); 6] = [
            (&home, &["{view}", "{in}"], "own-directory"),
            (&from_stdin, &["{view}", "{in}"], "stdin"),
            (&from_stdin, &["{view}"], "stdin-and-view"),
            (&[], &["{in}", "{view}"], "arguments-exchanged"),
            (&[], &["{in}"], "no-view"),
            (&from_stdin, &[], "stdin-alone"),
        ];
        let (.., name) = ways.into_iter().find(|(before, after, _)| {
            let reply =
                self.call_with_template(Some(self.template_around(before, after)), view, file);
            matches!(reply.answer, Answer::Decoded(_))
                || repair(&reply.stdout, expected, view).is_some()
        })?;
        Some(fault(name, &[]))
    }
}
