//! The steps of a probe and their results.

use std::borrow::Cow;
use std::fmt::{Display, Write};
use std::path::Path;

use super::message::ProbeFault;

/// The result of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// The step succeeded.
    Good,
    /// Something must be fixed.
    Bad,
    /// An optional part is missing.
    Absent,
}

/// A step of a probe.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProbeStep {
    /// Result of the step.
    pub mark: Mark,
    /// The observation.
    pub message: String,
    /// The suggested action, if there is something to do.
    pub next: Option<String>,
    /// Requests that reproduce the observation, if there is something to fix.
    pub reproduction: Option<Reproduction>,
}

impl ProbeStep {
    /// Creates a step for a fault in `subject`, with instructions to reproduce the fault.
    pub(super) fn bad(
        subject: &dyn Display,
        fault: ProbeFault,
        reproduction: Reproduction,
    ) -> ProbeStep {
        ProbeStep {
            mark: Mark::Bad,
            message: format!("{subject}: {}", fault.0),
            next: Some(fault.1),
            reproduction: Some(reproduction),
        }
    }
}

/// Requests that reproduce an observation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reproduction {
    /// True if all requests are sent to one process in serve mode.
    pub serve: bool,
    /// The requests, in order.
    pub requests: Vec<ProbeRequest>,
}

/// A request to decode a file in a view.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProbeRequest {
    /// The view, as a word on the command line.
    pub view: String,
    /// A name for the file.
    pub file_name: String,
    /// Bytes of the file.
    pub file: Vec<u8>,
}

impl Reproduction {
    pub(super) fn one_shot(
        view: &dyn Display,
        file_name: impl Into<String>,
        file: &[u8],
    ) -> Reproduction {
        let request = ProbeRequest {
            view: view.to_string(),
            file_name: file_name.into(),
            file: file.to_vec(),
        };
        let (serve, requests) = (false, vec![request]);
        Reproduction { serve, requests }
    }

    /// Returns the command line that reproduces the observation. `decoder` is the command of the decoder, and `directory`
    /// contains the files.
    #[must_use]
    pub fn command(&self, decoder: &str, directory: &Path) -> String {
        let shown = "xxd | head";
        let requests = (1..).zip(&self.requests).map(|(number, request)| {
            let path = directory.join(&request.file_name);
            let path = path.to_string_lossy();
            let view = &request.view;
            if self.serve {
                return format!("{number} {view} {path}\\n");
            }
            let path = shlex::try_quote(&path).unwrap_or(Cow::Borrowed(&path));
            format!("{decoder} {view} {path} | {shown}")
        });
        let requests: Vec<String> = requests.collect();
        match self.serve {
            true => format!("printf '{}' | {decoder} serve | {shown}", requests.concat()),
            false => requests.join("\n"),
        }
    }
}

/// The steps that were taken, and their results.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Checklist {
    /// The steps, in the order in which they were taken.
    pub steps: Vec<ProbeStep>,
    /// True if the decoder returned a well-formed frame for at least one first file.
    pub has_frames: bool,
}

impl Checklist {
    fn add(&mut self, mark: Mark, message: impl Into<String>, next: Option<String>) {
        let (message, reproduction) = (message.into(), None);
        self.steps.push(ProbeStep {
            mark,
            message,
            next,
            reproduction,
        });
    }

    /// Adds a step that succeeded.
    pub fn add_good(&mut self, message: impl Into<String>) {
        self.add(Mark::Good, message, None);
    }

    /// Adds a fault and a suggested fix.
    pub fn add_bad(&mut self, message: impl Into<String>, next: impl Into<String>) {
        self.add(Mark::Bad, message, Some(next.into()));
    }

    /// Adds a fault found in `subject`, with instructions to reproduce it. The same fault in several subjects is one step.
    pub(super) fn add_fault(
        &mut self,
        subject: &dyn Display,
        fault: ProbeFault,
        reproduction: Reproduction,
    ) {
        // A subject is a format and a view. The same view in another format adds the name of the format.
        let subject = subject.to_string();
        let (name, view) = subject.split_once(' ').unwrap_or((&subject, ""));
        let ending = format!(" {view}: {}", fault.0);
        let is_same = |step: &&mut ProbeStep| {
            step.mark == Mark::Bad
                && step.next.as_ref() == Some(&fault.1)
                && step.message.ends_with(&ending)
        };
        if let Some(step) = self.steps.iter_mut().find(is_same) {
            let names = step.message.len() - ending.len();
            step.message.insert_str(names, &format!(", {name}"));
        } else {
            self.steps
                .push(ProbeStep::bad(&subject, fault, reproduction));
        }
    }

    /// Adds a step that does not apply.
    pub fn add_absent(&mut self, message: impl Into<String>) {
        self.add(Mark::Absent, message, None);
    }

    /// Returns the exit status: 0 if the decoder is ready for `check`, 3 if it is not a decoder yet, and 1 in all other cases.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        match (self.has_frames, self.faults()) {
            (false, _) => 3,
            (true, 1..) => 1,
            (true, 0) => 0,
        }
    }

    /// Returns the number of faults.
    #[must_use]
    pub fn faults(&self) -> usize {
        let bad = self.steps.iter().filter(|step| step.mark == Mark::Bad);
        bad.count()
    }

    /// Returns the list as text for a terminal. `command` returns the command line that reproduces an observation.
    #[must_use]
    pub fn to_text(&self, command: &dyn Fn(&Reproduction) -> Option<String>) -> String {
        let mut text = String::new();
        for step in &self.steps {
            let mark = match step.mark {
                Mark::Good => '✓',
                Mark::Bad => '✗',
                Mark::Absent => '–',
            };
            let _ = writeln!(text, "{mark} {}", step.message.replace('\n', "\n  "));
            if let Some(next) = &step.next {
                let _ = writeln!(text, "  → {}", next.replace('\n', "\n    "));
            }
            if let Some(command) = step.reproduction.as_ref().and_then(command) {
                let _ = writeln!(text, "  $ {}", command.replace('\n', "\n  $ "));
            }
        }
        text
    }
}
