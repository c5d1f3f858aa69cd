//! `ptm-conform check`: runs a suite, from first contact to the report and the likely causes.

use std::sync::Arc;

use super::calls::{StopFlag, quote_command, reordered_command};
use super::check_args::{CheckArgs, DecoderSuite};
use super::display::Display;
use super::ending::ReportWriter;
use super::guard::{ScratchGuard, stop_on_signals};
use super::names::did_you_mean;
use super::output::{jobs, print, print_note};
use super::probe::save_files;
use super::subject::{Answers, NamedDecoder, decoder_for_command};
use super::terminal::print_styled;
use super::{CommandResult, own_files};
use crate::report::html::{self, Evidence};
use ptm::Format;
use ptm_harness::pipeline::checkable::find_misreadings;
use ptm_harness::pipeline::subject::{OneShot, Program, RunningProgram, Subject};
use ptm_harness::pipeline::texture::TextureCheck;
use ptm_harness::pipeline::{self, Check, Checked};
use ptm_harness::report::shards::Circumstances;
use ptm_harness::runner::run::Decoder;
use ptm_harness::runner::scratch::Scratch;
use ptm_harness::runner::{processes, serve::Servers};
use ptm_harness::session::plan::{Repeat, RunPlan};
use ptm_harness::session::probe::ProbeStep;
use ptm_harness::session::texture_stage;
use ptm_harness::strength::smoke;
use ptm_suite::cases::{Case, Suite, TableSpelling};
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::Request;
use ptm_suite::test_case::{Listed, TestCase};
use ptm_suite::texture::cases::TextureView;

/// Runs a suite.
pub fn run(args: &CheckArgs) -> CommandResult {
    args.reject_bare_hyphens()?;
    let stop = stop_on_signals()?;
    processes::prepare();
    args.output.check(&args.run.report)?;
    let has_decoder = !args.decoder.is_empty() || args.cmd.is_some();
    let is_reference =
        !args.list && !has_decoder && args.outputs.is_none() && args.caller.is_none();
    if is_reference {
        print("No decoder given: checking the built-in reference.\n");
    }
    let status = match args.suite {
        DecoderSuite::Ptm => check_decoder(args, &stop),
        DecoderSuite::Texture => check_stage(args, &stop),
    }?;
    if is_reference {
        print("This was the built-in reference. ");
        print("To check a decoder: ptm-conform check ./my-decoder\n");
    }
    Ok(status)
}

fn check_decoder(args: &CheckArgs, stop: &StopFlag) -> CommandResult {
    let suite = Suite::load()?;
    let smoke = smoke::selection(&suite, &[])?;
    let is_of_format =
        |i: usize| args.formats.is_empty() || args.formats.contains(&suite.cases[i].format());
    let smoke_of = |formats: &[Format]| match args.smoke {
        true => smoke::selection(&suite, formats),
        false => Ok(vec![true; suite.cases.len()]),
    };
    if args.list {
        let smoke = smoke_of(&args.formats)?;
        let selected = args.select_cases(&suite, |i| smoke[i] && is_of_format(i))?;
        return Ok(list_cases(&suite, &selected));
    }
    reject_unknown_misreadings(&args.assumed)?;

    let mut decoder = NamedDecoder::new(args, &suite, stop)?;
    let guarded = ScratchGuard::new()?;
    let scratch = &guarded.scratch;
    let capabilities = decoder.query_capabilities(args, scratch);
    // The parts of a run must have the same cases, so they do not depend on the answers.
    let chosen = match decoder.program() {
        _ if !args.formats.is_empty() => args.formats.clone(),
        Some(program) if args.smoke && args.shard.is_none() => {
            supported_formats(program, &suite, scratch)
        }
        _ => Vec::new(),
    };
    let in_smoke = smoke_of(&chosen)?;
    let selected = args.select_cases(&suite, |i| in_smoke[i] && is_of_format(i))?;
    if let (Some(directory), Some(program)) = (&args.files, decoder.program()) {
        return own_files::check(directory, &args.views, &args.run.report, program, scratch);
    }
    let serves = args.serve || capabilities.serves && !args.one_shot;

    let precomputed = matches!(decoder.answers, Answers::Precomputed(_));
    let plan = RunPlan {
        selected,
        prioritized: smoke,
        views: decoder.views.clone(),
        withheld: decoder.withheld.clone(),
        precomputed,
        repeat: if precomputed {
            Repeat::Nothing
        } else if serves {
            Repeat::FailuresAndSample
        } else {
            Repeat::Failures
        },
        stop: Arc::clone(stop),
        fail_fast: args.fail_fast.then(Arc::default),
        ..RunPlan::new(&suite, jobs(args.run.calls.jobs)?)
    }
    .with_capabilities(&capabilities);
    let mut check = Check {
        circumstances: Circumstances {
            command: decoder.words.clone(),
            name: capabilities.name.clone(),
            version: capabilities.version.clone(),
            assumed: args.assumed.clone(),
            limits: args.limits(serves),
        },
        requests_scene: args.output.html.is_some(),
        // Answers in files cost nothing, and the parts of a run must not depend on each other.
        asks_all: args.all || precomputed || args.shard.is_some(),
        ..Check::new(&suite, &plan)
    };
    let advice = reordered_command::<CheckArgs>("check", &args.decoder);
    let advice = advice.map(|command| format!("options come before the decoder: {command}"));
    if let Some(advice) = &advice {
        print_note(&format!(
            "note: these words are passed to the decoder; {advice}\n"
        ));
    }
    let subject: Box<dyn Subject> = match &decoder.answers {
        Answers::Precomputed(outputs) => Box::new(outputs),
        Answers::Caller(caller) => Box::new(caller),
        Answers::Program(program) => Box::new(RunningProgram {
            program: Program {
                decoder: program,
                scratch,
                command: &args.decoder,
                capabilities: &capabilities,
                advice: advice.as_deref(),
            },
            servers: serves.then(|| Servers::new(program, scratch, plan.jobs)),
            without_refusals: (!decoder.withheld.is_empty()).then_some(&suite),
        }),
    };

    let writer = ReportWriter::new(&suite, &args.run.report, &args.output)?;
    check.recorder = args.recorder()?;
    let speed_hint = (!serves && args.cmd.is_none()).then_some(SERVE_MODE_IS_FASTER);
    let display = Display::new(writer, speed_hint)?;
    let Checked {
        run,
        report,
        faults,
        scene,
    } = pipeline::check(&check, &*subject, &display)?;
    let evidence = Evidence {
        scene: scene.as_ref(),
        ..Evidence::new(&suite, &run, html::case_evidence)
    };
    let status = display.finish(run.ending(), report, &evidence)?;
    print_commands(args, &faults);
    Ok(status)
}

/// Returns the formats of the first files that the program decodes in any view.
fn supported_formats(program: &Decoder, suite: &Suite, scratch: &Scratch) -> Vec<Format> {
    let first: Vec<&Case> = suite.cases.iter().filter(|case| case.first).collect();
    let is_decoded = |case: &&Case, table: TableSpelling| {
        let built = case.build(table);
        case.views.iter().any(|view| {
            let request = Request::new(&case.id, view, &built.file, case.max_output_bytes(&built));
            matches!(program.ask(&request, scratch).answer, Answer::Decoded(_))
        })
    };
    let is_supported = |format: &Format| {
        let mut cases = first.iter().filter(|case| case.format() == *format);
        cases.any(|case| TableSpelling::of(*format).any(|table| is_decoded(case, table)))
    };
    Format::ALL.into_iter().filter(is_supported).collect()
}

/// Prints the ids of the selected cases. Returns the exit status.
pub(super) fn list_cases<C: Listed>(suite: &Suite<C>, selected: &[bool]) -> u8 {
    let cases = suite.cases.iter().zip(selected);
    for (case, _) in cases.filter(|(_, selected)| **selected) {
        print(&format!("{}\n", case.id()));
    }
    0
}

/// Returns an error, with similar names, if an assumed misreading is unknown.
fn reject_unknown_misreadings(slugs: &[String]) -> Result<(), String> {
    for slug in slugs {
        if let Err(error) = find_misreadings(std::slice::from_ref(slug)) {
            let known = ptm_mistakes::all().map(|misreading| misreading.slug);
            return Err(error + &did_you_mean(slug, known));
        }
    }
    Ok(())
}

/// Prints commands that reproduce the faults of a wrapper, and saves the files that they need.
fn print_commands(args: &CheckArgs, faults: &[ProbeStep]) {
    if args.cmd.is_some() {
        return;
    }
    let directory = args.run.report.with_file_name("ptm-conform-probe");
    let command = quote_command(&args.decoder);
    for reproduction in faults
        .iter()
        .filter_map(|fault| fault.reproduction.as_ref())
    {
        if let Some(command) = save_files(reproduction, &command, &directory) {
            print_styled(&format!("to reproduce this:\n  $ {command}\n"));
        }
    }
}

fn check_stage(args: &CheckArgs, stop: &StopFlag) -> CommandResult {
    reject_file_options(args)?;
    let suite = Suite::load_texture()?;
    let selected = args.select_cases(&suite, |_| true)?;
    if args.list {
        return Ok(list_cases(&suite, &selected));
    }
    let (mut decoder, words) = decoder_for_command(&args.decoder)?;
    args.run.calls.apply_limits(&mut decoder, stop)?;
    let guarded = ScratchGuard::new()?;
    let plan = RunPlan {
        selected,
        repeat: Repeat::Failures,
        stop: Arc::clone(stop),
        fail_fast: args.fail_fast.then(Arc::default),
        ..RunPlan::new(&suite, jobs(args.run.calls.jobs)?)
    };
    let circumstances = Circumstances {
        command: words,
        limits: args.limits(false),
        ..Circumstances::default()
    };
    let mut check = TextureCheck {
        circumstances,
        ..TextureCheck::new(&suite, &plan)
    };
    let stage = OneShot {
        program: &decoder,
        ask: |request: &Request<'_, TextureView>, _: usize| {
            texture_stage::send_question(&decoder, request, &guarded.scratch)
        },
    };
    let writer = ReportWriter::new(&suite, &args.run.report, &args.output)?;
    check.recorder = args.recorder()?;
    let display = Display::new(writer, None)?;
    let (run, report) = pipeline::texture::check(&check, &stage, &display)?;
    let evidence = Evidence::new(&suite, &run, html::question_evidence);
    Ok(display.finish(run.ending(), report, &evidence)?)
}

/// Returns an error if an option does not apply to texture questions.
fn reject_file_options(args: &CheckArgs) -> Result<(), String> {
    let option = match args {
        _ if args.smoke => "--smoke",
        _ if !args.formats.is_empty() => "--ptm-format",
        _ if !args.views.is_empty() => "--view",
        _ if args.serve => "--serve",
        _ if !args.assumed.is_empty() => "--assume",
        _ if args.cmd.is_some() => "--cmd",
        _ if args.outputs.is_some() => "--outputs",
        _ if args.files.is_some() => "--files",
        _ => return Ok(()),
    };
    Err(format!("{option} works only with --suite ptm"))
}

/// Hint that serve mode is faster, for a run that does not use it.
const SERVE_MODE_IS_FASTER: &str = "\nServe mode is faster: one process answers all requests. To print a decoder that supports it, run: ptm-conform example python";
