//! The decoder that the command line of `check` names: a program, this program, a program called through a template, precomputed
//! answers, or functions of the parent process.

use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use ptm_harness::report::words::CALLER_COMMAND;
use ptm_harness::runner::caller::Caller;
use ptm_harness::runner::run::Decoder;
use ptm_harness::runner::scratch::Scratch;
use ptm_harness::runner::template::Template;
use ptm_harness::session::outputs::Outputs;
use ptm_suite::cases::{Case, Expect, Suite};
use ptm_suite::protocol::capabilities::Capabilities;
use ptm_suite::protocol::frame::ViewKind;

use super::{check_args::CheckArgs, files::with_path};

/// A decoder and the part of the suite that applies to it.
pub struct NamedDecoder {
    /// Source of answers.
    pub answers: Answers,
    /// Command line for the report.
    pub words: Vec<String>,
    /// Requested views; empty for all views that the decoder supports.
    pub views: Vec<ViewKind>,
    /// Reasons why cases are not requested, one entry per case; empty if all cases are requested.
    pub withheld: Vec<Option<String>>,
}

/// Source of answers.
pub enum Answers {
    /// Program that is called for each request.
    Program(Decoder),
    /// Precomputed answers, stored in files.
    Precomputed(Outputs),
    /// Parent process, whose functions answer requests.
    Caller(Caller),
}

impl NamedDecoder {
    /// Returns the program, if there is one.
    pub fn program(&self) -> Option<&Decoder> {
        match &self.answers {
            Answers::Program(decoder) => Some(decoder),
            Answers::Precomputed(_) | Answers::Caller(_) => None,
        }
    }

    /// Queries the capabilities of a program. Most programs declare none.
    pub fn query_capabilities(&mut self, args: &CheckArgs, scratch: &Scratch) -> Capabilities {
        let Answers::Program(decoder) = &mut self.answers else {
            return Capabilities::default();
        };
        let capabilities = decoder.capabilities(scratch).unwrap_or_default();
        decoder.reject_exit = args.reject_exit.or(capabilities.reject_exit);
        capabilities
    }

    /// Creates the decoder and applies the limits that the command line specifies.
    pub fn new(
        args: &CheckArgs,
        suite: &Suite,
        stop: &Arc<AtomicBool>,
    ) -> Result<NamedDecoder, String> {
        let mut views = ViewKind::ALL.to_vec();
        views.retain(|view| args.views.contains(view));
        let named = |answers: Answers, words: Vec<String>| NamedDecoder {
            answers,
            words,
            views: views.clone(),
            withheld: Vec::new(),
        };
        if let Some(socket) = &args.caller {
            let caller = Caller::connect(socket, stop).map_err(with_path(socket))?;
            let words = vec![CALLER_COMMAND.to_owned()];
            return Ok(named(Answers::Caller(caller), words));
        }
        if let Some(directory) = &args.outputs {
            let outputs = open_outputs(directory, suite)?;
            let directory = directory.to_string_lossy().into_owned();
            let words = vec!["--outputs".to_owned(), directory];
            return Ok(NamedDecoder {
                views: vec![outputs.view],
                withheld: outputs.withheld(suite),
                ..named(Answers::Precomputed(outputs), words)
            });
        }
        let (mut decoder, words) = match &args.cmd {
            Some(text) => decoder_from_template(text, Template::parse(text))?,
            None => decoder_for_command(&args.decoder)?,
        };
        args.run.calls.apply_limits(&mut decoder, stop)?;
        let mut program = named(Answers::Program(decoder), words);
        if let Some(text) = &args.cmd {
            program.restrict_to(text, args, suite)?;
        }
        Ok(program)
    }

    /// Selects the only view of a template without `{view}`. If refusals cannot be recognized, withholds cases that allow them.
    fn restrict_to(&mut self, text: &str, args: &CheckArgs, suite: &Suite) -> Result<(), String> {
        let template = Template::parse(text)?;
        if !template.has_view() {
            if self.views.is_empty() {
                self.views.push(ViewKind::Rgb);
            }
            if self.views.len() > 1 {
                let says = "without {view}, a template serves only one view; select it with --view";
                return Err("--cmd: ".to_owned() + says);
            }
            if self.views == [ViewKind::Rgb] && !template.has_light() {
                return Err("--cmd: view rgb needs the light: {lu} and {lv}, or {view}".to_owned());
            }
        }
        if args.reject_exit.is_none() {
            let why = "without --reject-exit, the refusals of a program called through --cmd cannot be recognized";
            let refusal = |case: &Case| match case.expect {
                Expect::Decode | Expect::Spelling => None,
                _ => Some(why.to_owned()),
            };
            self.withheld = suite.cases.iter().map(refusal).collect();
        }
        Ok(())
    }
}

/// Opens a directory of precomputed outputs and prints a warning about files that match no request.
fn open_outputs(directory: &Path, suite: &Suite) -> Result<Outputs, String> {
    let matches = |pattern: &str, id: &str| {
        let pattern = glob::Pattern::new(pattern).map_err(|error| error.to_string())?;
        Ok(pattern.matches(id))
    };
    let outputs = Outputs::open(directory, suite, matches)?;
    let unmatched = &outputs.unmatched;
    if !unmatched.is_empty() {
        let (count, first) = (unmatched.len(), &unmatched[..unmatched.len().min(5)]);
        let first = first.join(", ");
        super::output::print_error(&format!(
            "ptm-conform: no request matches these files in the output directory ({count} in total): {first}"
        ));
    }
    Ok(outputs)
}

/// Returns a decoder that is called through a template, and the words of the template for the report.
pub fn decoder_from_template(
    text: &str,
    template: Result<Template, String>,
) -> Result<(Decoder, Vec<String>), String> {
    let template = template.map_err(|error| format!("--cmd: {error}"))?;
    let decoder = Decoder::with_template(template).map_err(|error| error.to_string())?;
    Ok((decoder, shlex::split(text).unwrap_or_default()))
}

/// Returns the decoder that `command` runs (the built-in reference if `command` is empty), and its command line for the report.
pub fn decoder_for_command(command: &[OsString]) -> Result<(Decoder, Vec<String>), String> {
    let mut command = command.to_vec();
    if command.is_empty() {
        let program = std::env::current_exe();
        let program = program.map_err(|error| format!("cannot find this program: {error}"))?;
        command = vec![program.into(), "reference".into()];
    }
    let text = |word: &OsString| word.to_string_lossy().into_owned();
    let decoder = Decoder::new(&command).map_err(|error| error.to_string())?;
    Ok((decoder, command.iter().map(text).collect()))
}
