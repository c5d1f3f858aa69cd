//! Calls of the decoder under probe, by the protocol and by other command lines.

use std::ffi::OsString;

use crate::protocol::frame::{Answer, View};
use crate::runner::run::{Decoder, Reply, Request};
use crate::runner::scratch::Scratch;
use crate::runner::template::Template;
use crate::suite::compare::Expected;

use super::repair;

/// The decoder under probe, and where it works.
pub(super) struct Calls<'a> {
    /// Its command as it was given.
    pub(super) command: &'a [OsString],
    pub(super) decoder: &'a Decoder,
    pub(super) scratch: &'a Scratch,
}

impl Calls<'_> {
    /// Asks as the protocol says.
    pub(super) fn ask(&self, view: &View, file: &[u8]) -> Reply {
        self.ask_by(None, view, file)
    }

    /// Asks with a word that is no view.
    pub(super) fn ask_for(&self, word: &str, after: &[&str], file: &[u8]) -> Reply {
        let words = self.around(&[], &[&[word][..], after].concat());
        self.ask_by(Some(words), &View::Raw, file)
    }

    fn ask_by(&self, template: Option<Template>, view: &View, file: &[u8]) -> Reply {
        let request = Request {
            name: "probe",
            view,
            file,
            // Whatever it prints is looked at: an f64 for each byte of the file, and more.
            largest_frame: file.len().max(1 << 12) * 18,
            timeout_factor: 1,
            alone: true,
        };
        match template {
            None => self.decoder.ask(&request, self.scratch),
            Some(template) => (self.decoder.called_by(template)).ask(&request, self.scratch),
        }
    }

    /// A template of words around the command.
    fn around(&self, before: &[&str], after: &[&str]) -> Template {
        let before = before.iter().map(OsString::from);
        let after = after.iter().map(OsString::from);
        let command = self.decoder.command().iter().cloned();
        Template::of_words(&before.chain(command).chain(after).collect::<Vec<_>>())
    }

    /// The way of calling it that gives a frame where the protocol's gives none: what to say, and what to do.
    pub(super) fn other_way(
        &self,
        file: &[u8],
        expected: &Expected,
        view: &View,
    ) -> Option<(&str, &str)> {
        let here = std::env::current_dir().ok()?;
        let ways = self.other_ways(&here.to_string_lossy());
        let mut ways = ways.into_iter();
        let (_, says, next) = ways.find(|(template, ..)| {
            let reply = self.ask_by(Some(template.clone()), view, file);
            matches!(reply.answer, Answer::Decoded(_))
                || repair::repair(&reply.stdout, expected, view).is_some()
        })?;
        Some((says, next))
    }

    fn other_ways(&self, here: &str) -> [(Template, &'static str, &'static str); 6] {
        let stdin = "exec \"$@\" < \"$0\"";
        let home = "cd \"$0\" && exec \"$@\"";
        [
            (
                self.around(&["sh", "-c", home, here], &["{view}", "{in}"]),
                "it works in your directory only: calls run in an empty directory of their own",
                "let it find its own files beside itself and not in the working directory; words of the command that name \
                 existing files are made absolute, but not paths within words such as --lib=path",
            ),
            (
                self.around(&["sh", "-c", stdin, "{in}"], &["{view}", "{in}"]),
                "it reads the PTM from standard input, which is empty",
                "open the file whose path is the last argument",
            ),
            (
                self.around(&["sh", "-c", stdin, "{in}"], &["{view}"]),
                "it reads the PTM from standard input and takes no FILE",
                "open the file whose path is the last argument",
            ),
            (
                self.around(&[], &["{in}", "{view}"]),
                "it takes its arguments the other way round",
                "the first is the VIEW, the second the FILE",
            ),
            (
                self.around(&[], &["{in}"]),
                "it takes no VIEW",
                "take VIEW (raw, coef or rgb:LU,LV) and FILE, and exit with 69 for a view that it does not support",
            ),
            (
                self.around(&["sh", "-c", stdin, "{in}"], &[]),
                "it reads the PTM from standard input and takes no arguments",
                "take VIEW and FILE, and open the file",
            ),
        ]
    }
}
