//! Who is checked: a decoder, this program, a program that a template calls, or precomputed answers.

use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use ptm_conform::protocol::frame::{Answer, ViewKind};
use ptm_conform::runner::caller::Caller;
use ptm_conform::runner::run::{Decoder, Reply, Request};
use ptm_conform::runner::template::Template;
use ptm_conform::session::outputs::Outputs;
use ptm_conform::suite::cases::{Expect, Suite};

use super::check_args::CheckArgs;

/// Who is checked, and what of the suite can be asked.
pub struct Subject {
    /// Who answers.
    pub answers: Answers,
    /// Its command as the report has it.
    pub words: Vec<String>,
    /// The views to ask for; all that it offers if empty.
    pub views: Vec<&'static str>,
    /// Why a case is not asked, an entry for each case; empty if all are.
    pub withheld: Vec<Option<String>>,
}

/// Who answers.
pub enum Answers {
    /// A program.
    Program(Decoder),
    /// Files that hold the answers.
    Precomputed(Outputs),
    /// A function of the process that started this one.
    Caller(Caller),
}

impl Subject {
    /// The program, if there is one.
    pub fn program(&self) -> Option<&Decoder> {
        match &self.answers {
            Answers::Program(decoder) => Some(decoder),
            Answers::Precomputed(_) | Answers::Caller(_) => None,
        }
    }

    /// What a reply means of this program.
    pub fn understand(&self, suite: &Suite, request: &Request, mut reply: Reply) -> Reply {
        // No decoder has to read every spelling of a table; where a refusal looks like a crash, this is one.
        let one_of_several = || {
            suite
                .case(request.name)
                .is_some_and(|case| case.expect == Expect::Spelling)
        };
        if !self.withheld.is_empty()
            && matches!(reply.answer, Answer::Crashed(_))
            && one_of_several()
        {
            reply.answer = Answer::Rejected;
        }
        reply
    }

    /// What the command line names.
    pub fn of(args: &CheckArgs, suite: &Suite, stop: &Arc<AtomicBool>) -> Result<Subject, String> {
        let views = ViewKind::NAMES
            .into_iter()
            .filter(|view| args.views.iter().any(|asked| asked == view))
            .collect();
        if let Some(socket) = &args.caller {
            let caller = Caller::connect(socket, stop);
            return Ok(Subject {
                answers: Answers::Caller(
                    caller.map_err(|error| format!("{}: {error}", socket.display()))?,
                ),
                words: vec!["a function of the caller".to_owned()],
                views,
                withheld: Vec::new(),
            });
        }
        match (&args.cmd, &args.outputs) {
            (Some(text), _) => Subject::of_template(text, views, args.reject_exit, suite),
            (None, Some(directory)) => Subject::of_outputs(directory, suite),
            (None, None) => {
                let (decoder, words) = program(&args.decoder)?;
                Ok(Subject {
                    answers: Answers::Program(decoder),
                    words,
                    views,
                    withheld: Vec::new(),
                })
            }
        }
    }

    fn of_outputs(directory: &Path, suite: &Suite) -> Result<Subject, String> {
        let matches = |pattern: &str, id: &str| {
            let pattern = glob::Pattern::new(pattern).map_err(|error| error.to_string())?;
            Ok(pattern.matches(id))
        };
        let outputs = Outputs::open(directory, suite, matches)?;
        if !outputs.strangers.is_empty() {
            super::output::complain(&format!(
                "ptm-conform: {} files in the outputs belong to no request: {}",
                outputs.strangers.len(),
                outputs.strangers[..outputs.strangers.len().min(5)].join(", ")
            ));
        }
        Ok(Subject {
            words: vec![
                "--outputs".to_owned(),
                directory.to_string_lossy().into_owned(),
            ],
            views: vec![outputs.view],
            withheld: outputs.withheld(suite),
            answers: Answers::Precomputed(outputs),
        })
    }

    fn of_template(
        text: &str,
        views: Vec<&'static str>,
        reject_exit: Option<i32>,
        suite: &Suite,
    ) -> Result<Subject, String> {
        let template = Template::parse(text).map_err(|error| format!("--cmd: {error}"))?;
        let views = match (template.names_view(), views.is_empty()) {
            (false, true) => vec!["rgb"],
            _ => views,
        };
        if !template.names_view() && views.len() > 1 {
            return Err(
                "--cmd: without {view} it answers one view only; name one by --view".to_owned(),
            );
        }
        if !template.names_view() && views == ["rgb"] && !template.names_light() {
            return Err("--cmd: a picture needs its light: {lu} and {lv}, or {view}".to_owned());
        }
        let refusal = |expect: Expect| {
            (expect != Expect::Decode && expect != Expect::Spelling).then(|| {
                "a program called by --cmd shows no refusal without --reject-exit".to_owned()
            })
        };
        let withheld = match reject_exit {
            Some(_) => Vec::new(),
            None => suite
                .cases
                .iter()
                .map(|case| refusal(case.expect))
                .collect(),
        };
        Ok(Subject {
            answers: Answers::Program(
                Decoder::with_template(template).map_err(|error| error.to_string())?,
            ),
            words: shlex::split(text).unwrap_or_default(),
            views,
            withheld,
        })
    }
}

/// A program and its arguments, and its words as the report has them; this program if there are none.
pub fn program(command: &[OsString]) -> Result<(Decoder, Vec<String>), String> {
    let reference;
    let command = if command.is_empty() {
        reference = reference_command()?;
        &reference
    } else {
        command
    };
    let decoder = Decoder::new(command).map_err(|error| error.to_string())?;
    let words = command
        .iter()
        .map(|word| word.to_string_lossy().into_owned());
    Ok((decoder, words.collect()))
}

/// This program, asked as any other decoder.
fn reference_command() -> Result<Vec<OsString>, String> {
    let program =
        std::env::current_exe().map_err(|error| format!("cannot find this program: {error}"))?;
    Ok(vec![program.into(), "reference".into()])
}
