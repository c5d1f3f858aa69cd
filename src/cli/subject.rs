//! The subject of a check: a decoder, this program, a program that a template calls, or precomputed answers.

use std::borrow::Cow;
use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use ptm_conform::protocol::frame::{Answer, ViewKind};
use ptm_conform::runner::caller::Caller;
use ptm_conform::runner::run::{Decoder, Reply, Request};
use ptm_conform::runner::template::Template;
use ptm_conform::session::outputs::Outputs;
use ptm_conform::suite::cases::{Case, Expect, Suite};

use super::arguments::limit;
use super::check_args::CheckArgs;

/// The subject of a check, and the part of the suite that applies to it.
pub struct Subject {
    /// The source of answers.
    pub answers: Answers,
    /// Its command, for the report.
    pub words: Vec<String>,
    /// The requested views; all that it offers if empty.
    pub views: Vec<&'static str>,
    /// The reasons why cases are not requested, an entry for each case; empty if all are requested.
    pub withheld: Vec<Option<String>>,
}

/// A source of answers.
pub enum Answers {
    /// A program.
    Program(Decoder),
    /// Precomputed answers in files.
    Precomputed(Outputs),
    /// A function of the parent process.
    Caller(Caller),
}

impl Subject {
    /// Returns the program, if there is one.
    pub fn program(&self) -> Option<&Decoder> {
        match &self.answers {
            Answers::Program(decoder) => Some(decoder),
            Answers::Precomputed(_) | Answers::Caller(_) => None,
        }
    }

    /// Interprets a reply: if a refusal looks like a crash, a crash may be a refusal, because no decoder has to support every
    /// spelling of a table.
    pub fn understand(&self, suite: &Suite, request: &Request, mut reply: Reply) -> Reply {
        let is_spelling = |case: &Case| case.expect == Expect::Spelling;
        if !self.withheld.is_empty()
            && matches!(reply.answer, Answer::Crashed(_))
            && suite.case(request.name).is_some_and(is_spelling)
        {
            reply.answer = Answer::Rejected;
        }
        reply
    }

    /// Returns the subject that the command line names, under the limits that it gives.
    pub fn new(args: &CheckArgs, suite: &Suite, stop: &Arc<AtomicBool>) -> Result<Subject, String> {
        let is_asked = |view: &&str| args.views.iter().any(|asked| asked == view);
        let mut subject = Subject {
            views: ViewKind::NAMES.into_iter().filter(is_asked).collect(),
            withheld: Vec::new(),
            words: Vec::new(),
            answers: match (&args.caller, &args.cmd, &args.outputs) {
                (Some(socket), ..) => Answers::Caller(
                    Caller::connect(socket, stop)
                        .map_err(|error| format!("{}: {error}", socket.display()))?,
                ),
                (None, Some(text), _) => Answers::Program(called_by(text)?),
                (None, None, Some(directory)) => Answers::Precomputed(outputs(directory, suite)?),
                (None, None, None) => Answers::Program(program(&args.decoder)?),
            },
        };
        match (&mut subject.answers, &args.cmd, &args.outputs) {
            (Answers::Program(decoder), cmd, _) => {
                limit(decoder, args.timeout, args.memory, stop)?;
                subject.words = match cmd {
                    Some(text) => shlex::split(text).unwrap_or_default(),
                    None => words_of(&args.decoder)?,
                };
            }
            (Answers::Precomputed(outputs), _, Some(directory)) => {
                subject.views = vec![outputs.view];
                subject.withheld = outputs.withheld(suite);
                let directory = directory.to_string_lossy().into_owned();
                subject.words = vec!["--outputs".to_owned(), directory];
            }
            _ => subject.words = vec!["a function of the caller".to_owned()],
        }
        if let Some(text) = &args.cmd {
            subject.restrict_to(&Template::parse(text)?, args, suite)?;
        }
        Ok(subject)
    }

    /// Restricts a program that a template calls to requests that the template can express and answers that it can show.
    fn restrict_to(
        &mut self,
        template: &Template,
        args: &CheckArgs,
        suite: &Suite,
    ) -> Result<(), String> {
        if !template.names_view() {
            if self.views.is_empty() {
                self.views.push("rgb");
            }
            if self.views.len() > 1 {
                return Err(
                    "--cmd: without {view} it answers one view only; name one by --view".to_owned(),
                );
            }
            if self.views == ["rgb"] && !template.names_light() {
                return Err("--cmd: a picture needs its light: {lu} and {lv}, or {view}".to_owned());
            }
        }
        if args.reject_exit.is_none() {
            let refusal = |case: &Case| {
                (case.expect != Expect::Decode && case.expect != Expect::Spelling).then(|| {
                    "a program called by --cmd shows no refusal without --reject-exit".to_owned()
                })
            };
            self.withheld = suite.cases.iter().map(refusal).collect();
        }
        Ok(())
    }
}

/// Reads answers that were made elsewhere, and reports files that are not answers.
fn outputs(directory: &Path, suite: &Suite) -> Result<Outputs, String> {
    let matches = |pattern: &str, id: &str| {
        let pattern = glob::Pattern::new(pattern).map_err(|error| error.to_string())?;
        Ok(pattern.matches(id))
    };
    let outputs = Outputs::open(directory, suite, matches)?;
    let strangers = &outputs.strangers;
    if !strangers.is_empty() {
        super::output::complain(&format!(
            "ptm-conform: {} files in the outputs belong to no request: {}",
            strangers.len(),
            strangers[..strangers.len().min(5)].join(", ")
        ));
    }
    Ok(outputs)
}

/// Returns a program that a template calls.
fn called_by(text: &str) -> Result<Decoder, String> {
    let template = Template::parse(text).map_err(|error| format!("--cmd: {error}"))?;
    Decoder::with_template(template).map_err(|error| error.to_string())
}

/// Returns the program that a command starts; this program if the command is empty.
pub fn program(command: &[OsString]) -> Result<Decoder, String> {
    Decoder::new(&command_or_reference(command)?).map_err(|error| error.to_string())
}

/// Returns the words of a command, for the report.
pub fn words_of(command: &[OsString]) -> Result<Vec<String>, String> {
    let command = command_or_reference(command)?;
    let words = command.iter().map(|word| word.to_string_lossy());
    Ok(words.map(Cow::into_owned).collect())
}

fn command_or_reference(command: &[OsString]) -> Result<Vec<OsString>, String> {
    if !command.is_empty() {
        return Ok(command.to_vec());
    }
    let program =
        std::env::current_exe().map_err(|error| format!("cannot find this program: {error}"))?;
    Ok(vec![program.into(), "reference".into()])
}
