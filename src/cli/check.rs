//! `ptm-conform check`: runs a suite, from first contact to the report and the likely causes.

use std::cell::OnceCell;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::driver::{Check, ProgramRun};
use super::ending::ReportWriter;
use super::guard::{ScratchGuard, check_for_trouble, stop_on_signals};
use super::names::did_you_mean;
use super::output::{jobs, print};
use super::probe::save_files;
use super::subject::{Answers, Subject, decoder_for_command};
use super::terminal::print_styled;
use super::{CommandResult, own_files};
use super::{calls::quote_command, check_args::CheckArgs};
use crate::report::reported::find_misreadings;
use crate::report::shards::{Circumstances, OtherRemarks};
use crate::runner::{processes, run::Request, scratch::Scratch, serve::Servers};
use crate::session::contact::Contact;
use crate::session::plan::{Repeat, RunPlan};
use crate::session::probe::{ProbeStep, wrapper_faults};
use crate::session::remark::Remark;
use crate::session::{lit_scene, locale, texture_stage};
use crate::strength::smoke;
use ptm_suite::protocol::capabilities::Capabilities;
use ptm_suite::{cases::Suite, texture::test_case::TextureView};

/// Runs a suite.
pub fn run(args: &CheckArgs) -> CommandResult {
    args.reject_bare_hyphens()?;
    let stop = stop_on_signals()?;
    processes::prepare();
    args.output.check(&args.run.report)?;
    let has_decoder = !args.decoder.is_empty() || args.cmd.is_some();
    let is_reference = !has_decoder && args.outputs.is_none() && args.caller.is_none();
    if is_reference {
        print("No decoder given: checking the built-in reference.\n");
    }
    let status = match args.suite.as_str() {
        "texture" => check_stage(args, &stop),
        _ => check_decoder(args, &stop),
    }?;
    if is_reference {
        print("This was the built-in reference. ");
        print("To check a decoder: ptm-conform check ./my-decoder\n");
    }
    Ok(status)
}

fn check_decoder(args: &CheckArgs, stop: &Arc<AtomicBool>) -> CommandResult {
    let suite = Suite::load()?;
    let subset = match args.smoke {
        true => smoke::selection(&suite)?,
        false => vec![true; suite.cases.len()],
    };
    let selected = args.select_cases(&suite, &subset)?;
    for slug in &args.assumed {
        let slugs = ptm_mistakes::all().map(|misreading| misreading.slug);
        let known = find_misreadings(std::slice::from_ref(slug));
        known.map_err(|error| error + &did_you_mean(slug, slugs))?;
    }
    let mut subject = Subject::new(args, &suite, stop)?;
    let guarded = ScratchGuard::new()?;
    let scratch = &guarded.scratch;
    let capabilities = capabilities(&mut subject, args, scratch);
    if let (Some(directory), Some(decoder)) = (&args.files, subject.program()) {
        return own_files::check(directory, &args.views, &args.run.report, decoder, scratch);
    }
    let serves = args.serve || capabilities.serves && !args.one_shot;
    let mut plan = plan(args, &suite, &subject, serves)?.with_capabilities(&capabilities);
    (plan.selected, plan.stop) = (selected, Arc::clone(stop));
    let served = subject.program().filter(|_| serves);
    let servers = served.map(|decoder| Servers::new(decoder, scratch, plan.jobs));
    let ask = |request: &Request<'_>, job: usize| {
        let reply = match (&subject.answers, &servers) {
            (Answers::Precomputed(outputs), _) => outputs.ask(request),
            (Answers::Caller(caller), _) => caller.ask(request),
            (Answers::Program(_), Some(servers)) => servers.ask(request, job),
            (Answers::Program(decoder), None) => decoder.ask(request, scratch),
        };
        subject.interpret_reply(&suite, request, reply)
    };
    let circumstances = Circumstances {
        command: subject.words.clone(),
        name: capabilities.name.clone(),
        version: capabilities.version.clone(),
        assumed: args.assumed.clone(),
        limits: args.limits(serves),
    };
    let writer = ReportWriter::new(&suite, &args.run.report, &args.output)?;
    let mut check = Check::new(&suite, &plan, circumstances, writer, args.shard)?;
    if !serves && args.cmd.is_none() {
        check.speed_hint = SERVE_MODE_IS_FASTER;
    }
    let faults = OnceCell::new();
    let mut run = check.run_cases(&ask, &|contact| {
        let Some(decoder) = subject.program() else {
            return;
        };
        // The command is empty for a template or the built-in reference.
        let found = wrapper_faults(&args.decoder, decoder, scratch, &suite, &plan, contact);
        report_wrapper_faults(contact, &found);
        if let (Some(why), Some(command)) = (&mut contact.not_a_decoder, args.reordered_command()) {
            *why = format!("{why}\n→ options come before the decoder: {command}");
        }
        let _ = faults.set(found);
    });
    subject.program().map_or(Ok(()), check_for_trouble)?;
    if args.output.html.is_some() && run.ended_early.is_none() {
        run.scene = lit_scene::request(&run.offer, &run.judgment.decoded, &ask);
    }
    let notes = capabilities.remarks.iter();
    let notes = notes.map(|says| Remark::note(format!("capabilities: {says}")));
    // The answers may differ in a locale with a decimal comma, if the system has one.
    let whole = run.not_a_decoder.is_none() && run.ended_early.is_none();
    let locale = subject.program().filter(|_| whole).and_then(|decoder| {
        let locale = locale::comma_locale()?;
        locale::difference(&suite, &run, decoder, &locale, scratch).map(Remark::failure)
    });
    let others = OtherRemarks {
        before: serve_mode_remarks(servers.as_ref()),
        after: notes.chain(locale).collect(),
    };
    let status = check.conclude(run, others)?;
    print_commands(args, &faults.into_inner().unwrap_or_default());
    Ok(status)
}

/// Adds the wrapper's faults to the results of first contact. If there are any faults, the run ends after first contact.
fn report_wrapper_faults(contact: &mut Contact, faults: &[ProbeStep]) {
    for fault in faults {
        let says = match &fault.next {
            Some(next) => format!("{}\n→ {next}", fault.message),
            None => fault.message.clone(),
        };
        match &mut contact.not_a_decoder {
            Some(why) => *why = format!("{why}\n{says}"),
            None => contact.remarks.push(Remark::failure(says)),
        }
        contact.end_reason = Some(FIX_THE_WRAPPER.to_owned());
    }
}

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

fn check_stage(args: &CheckArgs, stop: &Arc<AtomicBool>) -> CommandResult {
    reject_file_options(args)?;
    let suite = Suite::load_texture()?;
    let selected = args.select_cases(&suite, &vec![true; suite.cases.len()])?;
    let (mut decoder, words) = decoder_for_command(&args.decoder)?;
    args.run.calls.apply_limits(&mut decoder, stop)?;
    let guarded = ScratchGuard::new()?;
    let ask = |request: &Request<'_, TextureView>, _: usize| {
        texture_stage::send_question(&decoder, request, &guarded.scratch)
    };
    let run = ProgramRun {
        program: &decoder,
        words: &words,
        limits: args.limits(false),
        args: &args.run,
        output: &args.output,
        shard: args.shard,
    };
    run.check(&suite, selected, &ask)
}

/// Returns an error if an option does not apply to texture questions.
fn reject_file_options(args: &CheckArgs) -> Result<(), String> {
    let option = match args {
        _ if args.smoke => "--smoke",
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

fn plan(args: &CheckArgs, suite: &Suite, tested: &Subject, serve: bool) -> Result<RunPlan, String> {
    let precomputed = matches!(tested.answers, Answers::Precomputed(_));
    Ok(RunPlan {
        prioritized: smoke::selection(suite)?,
        views: tested.views.clone(),
        withheld: tested.withheld.clone(),
        precomputed,
        repeat: match (precomputed, serve) {
            (true, _) => Repeat::Nothing,
            (false, true) => Repeat::FailuresAndSample,
            (false, false) => Repeat::Failures,
        },
        ..RunPlan::new(suite, jobs(args.run.calls.jobs)?)
    })
}

/// Requests the capabilities of a program. Most programs declare none.
fn capabilities(subject: &mut Subject, args: &CheckArgs, scratch: &Scratch) -> Capabilities {
    let Answers::Program(decoder) = &mut subject.answers else {
        return Capabilities::default();
    };
    let capabilities = decoder.capabilities(scratch).unwrap_or_default();
    decoder.reject_exit = args.reject_exit.or(capabilities.reject_exit);
    capabilities
}

/// Reason why a run with a faulty wrapper ends at first contact.
const FIX_THE_WRAPPER: &str = "the run ended after the initial checks: fix the wrapper first, because its faults would make most cases fail";

/// Returns a remark if the decoder never answered in serve mode.
fn serve_mode_remarks(servers: Option<&Servers>) -> Vec<Remark> {
    let failure = servers.and_then(Servers::failure);
    let remark = failure
        .map(|why| format!("serve mode failed and was replaced by one process per request: {why}"));
    remark.map(Remark::failure).into_iter().collect()
}

/// Hint that serve mode is faster, for a run that does not use it.
const SERVE_MODE_IS_FASTER: &str = "\nServe mode is faster: one process answers all requests. To print a decoder that supports it, run: ptm-conform example python";
