//! The subject of a run: a decoder, this program, a program that a template calls, or precomputed answers; and the limits of its
//! calls.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args;

use ptm_conform::protocol::frame::{Answer, ViewKind};
use ptm_conform::runner::caller::Caller;
use ptm_conform::runner::processes;
use ptm_conform::runner::run::{Decoder, Reply, Request};
use ptm_conform::runner::template::Template;
use ptm_conform::session::outputs::Outputs;
use ptm_conform::suite::cases::{Case, Expect, Suite};

use super::arguments::{parse_refusal, parse_size, positive_seconds};
use super::check_args::CheckArgs;
use super::files::named;

/// Options of the run of a suite.
#[derive(Args)]
pub struct RunArgs {
    /// The file for the YAML report.
    #[arg(long, value_name = "FILE", default_value = "ptm-conform-report.yaml")]
    pub report: PathBuf,
    /// Calls in parallel; by default one per processor.
    #[arg(long, value_name = "N")]
    pub jobs: Option<usize>,
    /// Wall-clock limit of a call; the first call gets three times as much.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    timeout: f64,
    /// Memory limit of a call, all its processes together: bytes, or with K, M or G.
    #[arg(long, value_name = "SIZE", default_value = "2G", value_parser = parse_size)]
    memory: u64,
}

impl RunArgs {
    /// Applies the limits to a program, which stops when `stop` is set.
    pub fn limit(&self, program: &mut Decoder, stop: &Arc<AtomicBool>) -> Result<(), String> {
        limit(program, self.timeout, self.memory, stop)
    }

    /// Returns the limits in force, in words.
    pub fn limits_to_text(&self) -> Vec<String> {
        let (seconds, size) = (self.timeout, self.memory >> 20);
        let memory = match processes::can_be_watched() {
            true => {
                format!("memory: {size} MiB, the resident sets of a call's processes, sampled")
            }
            false => "memory: not limited, because this system has no /proc".to_owned(),
        };
        let time = format!("wall clock: {seconds} s a call, three times that for the first");
        vec![time, memory]
    }
}

/// Options for calls of a decoder.
#[derive(Args)]
pub struct CallArgs {
    /// Calls at a time; by default as many as there are processors.
    #[arg(long, value_name = "N")]
    pub jobs: Option<usize>,
    /// Wall-clock limit of a call.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    timeout: f64,
    /// Memory that a call may hold, all its processes together: bytes, or with K, M or G.
    #[arg(long, value_name = "SIZE", default_value = "2G", value_parser = parse_size)]
    memory: u64,
    /// An exit status that means "malformed" besides 65.
    #[arg(long, value_name = "N", value_parser = parse_refusal)]
    reject_exit: Option<i32>,
}

impl CallArgs {
    /// Returns the decoder that `command` starts; it stops when `stop` is set.
    pub fn decoder(&self, command: &[OsString], stop: &Arc<AtomicBool>) -> Result<Decoder, String> {
        processes::prepare();
        let mut decoder = Decoder::new(command).map_err(|error| error.to_string())?;
        limit(&mut decoder, self.timeout, self.memory, stop)?;
        decoder.reject_exit = self.reject_exit;
        Ok(decoder)
    }
}

fn limit(
    program: &mut Decoder,
    seconds: f64,
    memory: u64,
    stop: &Arc<AtomicBool>,
) -> Result<(), String> {
    program.timeout = positive_seconds(seconds)?;
    program.memory = memory;
    program.stop = Arc::clone(stop);
    Ok(())
}

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
        let subject = |answers: Answers, words: Vec<String>| Subject {
            answers,
            words,
            views: ViewKind::NAMES.into_iter().filter(is_asked).collect(),
            withheld: Vec::new(),
        };
        if let Some(socket) = &args.caller {
            let caller = Caller::connect(socket, stop).map_err(named(socket))?;
            let words = vec!["a function of the caller".to_owned()];
            return Ok(subject(Answers::Caller(caller), words));
        }
        if let Some(directory) = &args.outputs {
            let outputs = outputs(directory, suite)?;
            let directory = directory.to_string_lossy().into_owned();
            let words = vec!["--outputs".to_owned(), directory];
            return Ok(Subject {
                views: vec![outputs.view],
                withheld: outputs.withheld(suite),
                ..subject(Answers::Precomputed(outputs), words)
            });
        }
        let (mut decoder, words) = match &args.cmd {
            Some(text) => called_by(text, Template::parse(text))?,
            None => program(&args.decoder)?,
        };
        args.run.limit(&mut decoder, stop)?;
        let mut subject = subject(Answers::Program(decoder), words);
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
            let why = "a program called by --cmd shows no refusal without --reject-exit";
            let refusal = |case: &Case| match case.expect {
                Expect::Decode | Expect::Spelling => None,
                _ => Some(why.to_owned()),
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

/// Returns a program that a template calls, and the words of the template for the report.
pub fn called_by(
    text: &str,
    template: Result<Template, String>,
) -> Result<(Decoder, Vec<String>), String> {
    let template = template.map_err(|error| format!("--cmd: {error}"))?;
    let decoder = Decoder::with_template(template).map_err(|error| error.to_string())?;
    Ok((decoder, shlex::split(text).unwrap_or_default()))
}

/// Returns the program that a command starts, and its words for the report; this program if the command is empty.
pub fn program(command: &[OsString]) -> Result<(Decoder, Vec<String>), String> {
    let mut command = command.to_vec();
    if command.is_empty() {
        let program = std::env::current_exe();
        let program = program.map_err(|error| format!("cannot find this program: {error}"))?;
        command = vec![program.into(), "reference".into()];
    }
    let words = command
        .iter()
        .map(|word| word.to_string_lossy().into_owned());
    let decoder = Decoder::new(&command).map_err(|error| error.to_string())?;
    Ok((decoder, words.collect()))
}

/// Returns a command quoted for a shell.
pub fn in_one_line(command: &[OsString]) -> String {
    let words: Vec<_> = command.iter().map(|word| word.to_string_lossy()).collect();
    shlex::try_join(words.iter().map(AsRef::as_ref)).unwrap_or_default()
}
