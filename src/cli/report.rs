//! `ptm-conform report`: displays, compares, merges and converts existing reports.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::arguments::id_filter;
use super::ending::{OutputArgs, ReportWriter};
use super::{CommandError, CommandResult, EXIT_NOTHING_SELECTED};
use crate::report::html::{self, Evidence};
use crate::report::{badge, github, junit, text};
use ptm_harness::pipeline::merge::RecordedAnswers;
use ptm_harness::pipeline::{Checked, FinishedCase, Observer};
use ptm_harness::report::{Report, suite_texts::SuiteTexts};
use ptm_suite::cases::Suite;
use ptm_suite::kit::escape_controls;
use ptm_suite::name::SuiteName;
use ptm_writers::cases::load_writer_requests;
use ptm_writers::fitting::cases::load_fitter_requests;
use ptm_writers::fitting::photographs::Encoding;

/// Show, compare, merge and convert reports of check.
#[derive(Args)]
#[command(after_help = "Example:\n  ptm-conform report show ptm-conform-report.yaml")]
pub struct ReportArgs {
    #[command(subcommand)]
    command: ReportCommand,
}

#[derive(Subcommand)]
enum ReportCommand {
    /// Print a report as check does.
    #[command(
        after_help = "Example:\n  ptm-conform report show ptm-conform-report.yaml --case '*lut*'"
    )]
    Show {
        /// The report.
        file: PathBuf,
        /// Print in full the cases whose id matches; * and ? are wildcards. Repeatable.
        #[arg(long = "case", value_name = "GLOB")]
        cases: Vec<String>,
        /// Number of failures to print in full.
        #[arg(long, value_name = "N", default_value_t = 10)]
        show: usize,
    },
    /// Write an HTML page for one report, or a table of decoders and clauses for several.
    ///
    /// A report contains no images; `check --html` writes a page with images.
    #[command(after_help = "Example:\n  ptm-conform report html old.yaml new.yaml -o page.html")]
    Html {
        /// The reports.
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
        /// The output file.
        #[arg(short, long = "out", alias = "output", value_name = "FILE")]
        output: PathBuf,
    },
    /// Write a report as JUnit XML.
    #[command(after_help = "Example:\n  ptm-conform report junit report.yaml -o junit.xml")]
    Junit(OutputFormatArgs),
    /// Write an SVG badge with the three scores.
    #[command(after_help = "Example:\n  ptm-conform report badge report.yaml -o badge.svg")]
    Badge(OutputFormatArgs),
    /// Write a summary in Markdown.
    #[command(after_help = "Example:\n  ptm-conform report markdown report.yaml -o summary.md")]
    Markdown(OutputFormatArgs),
    /// Show what changed between two reports.
    ///
    /// Lists the cases that began to fail, were fixed, changed in other ways, or were added or removed. Also lists changes in the
    /// decoder, its scores, dialect and causes. If many cases changed, they are grouped by cause and clause.
    ///
    /// Exit status: 0 the reports are equal, 1 they differ, 2 one of them cannot be read.
    #[command(after_help = "Example:\n  ptm-conform report diff old.yaml new.yaml")]
    Diff {
        /// The old report.
        old: PathBuf,
        /// The new report.
        new: PathBuf,
        /// List every changed case.
        #[arg(long)]
        cases: bool,
    },
    Merge(MergeArgs),
}

/// Merge the parts of a sharded run into one report.
///
/// Each part is written by `check --shard I/N --report PART`, on any machine, with the same decoder and arguments. The responses
/// are kept in PART.answers next to PART. All N parts are needed. Verdicts, dialect and causes are computed again from all
/// responses, so the result equals the report of an undivided run.
///
/// Exit status: that of check; 2 if a part is missing, damaged, unfinished or from a different run.
#[derive(Args)]
#[command(
    after_help = "Example:\n  ptm-conform check --shard 1/2 --report part-1.yaml ./my-decoder\n  ptm-conform check --shard 2/2 --report part-2.yaml ./my-decoder\n  ptm-conform report merge part-1.yaml part-2.yaml"
)]
struct MergeArgs {
    /// The reports of all parts.
    #[arg(value_name = "PART", required = true)]
    parts: Vec<PathBuf>,
    /// The output file.
    #[arg(long, value_name = "FILE", default_value = "ptm-conform-report.yaml")]
    report: PathBuf,
    #[command(flatten)]
    outputs: OutputArgs,
}

#[derive(Args)]
struct OutputFormatArgs {
    /// The report.
    file: PathBuf,
    /// The output file; standard output by default.
    #[arg(short, long = "out", alias = "output", value_name = "FILE")]
    output: Option<PathBuf>,
}

impl OutputFormatArgs {
    fn write(&self, text: &str) -> CommandResult {
        match &self.output {
            Some(path) => super::files::write_atomically(path, text)?,
            None => super::output::print(text),
        }
        Ok(0)
    }
}

pub fn run(args: &ReportArgs) -> CommandResult {
    let reports = match &args.command {
        ReportCommand::Html { files, .. } => &files[..],
        ReportCommand::Show { file, .. } => std::slice::from_ref(file),
        ReportCommand::Junit(args) | ReportCommand::Badge(args) | ReportCommand::Markdown(args) => {
            std::slice::from_ref(&args.file)
        }
        ReportCommand::Merge(args) => {
            // All parts of a run have the same suite, so the first part determines it.
            return match Report::read(&args.parts[0]).map(|report| report.suite) {
                Ok(SuiteName::Texture) => merge_texture(args),
                _ => merge(args),
            };
        }
        ReportCommand::Diff { old, new, cases } => {
            let changes = Report::read(old)?.changes_to(&Report::read(new)?, *cases);
            super::terminal::print_styled(&escape_controls(&changes));
            return Ok(u8::from(!changes.is_empty()));
        }
    };
    let reports = reports.iter().map(|file| Report::read(file));
    let reports: Vec<Report> = reports.collect::<Result<_, _>>()?;
    let texts = match reports[0].suite {
        SuiteName::Ptm => SuiteTexts::new(&Suite::load()?)?,
        SuiteName::Texture => SuiteTexts::new(&Suite::load_texture()?)?,
        SuiteName::Writers => SuiteTexts::new(&load_writer_requests()?)?,
        SuiteName::Fitters => SuiteTexts::new(&load_fitter_requests(None, Encoding::default()))?,
    };
    convert(&args.command, &reports, &texts)
}

/// Converts reports on a suite to the requested format, and prints the result or writes it to a file.
fn convert(command: &ReportCommand, reports: &[Report], texts: &SuiteTexts) -> CommandResult {
    let (report, suite_size) = (&reports[0], texts.cases.len());
    match command {
        ReportCommand::Junit(args) => args.write(&junit::junit(report, None)),
        ReportCommand::Badge(args) => args.write(&badge::badge(report)),
        ReportCommand::Markdown(args) => args.write(&github::summary(report, suite_size)),
        ReportCommand::Html { output, .. } => {
            let page = match reports {
                [report] => html::page_without_images(texts, report),
                reports => html::matrix(reports, texts)?,
            };
            super::files::write_atomically(output, page)?;
            Ok(0)
        }
        ReportCommand::Show { cases, show, .. } => {
            let text = match &cases[..] {
                [] => text::report_to_text(report, texts, *show),
                cases => text::cases_to_text(report, texts, id_filter("--case", cases)?),
            };
            if text.is_empty() {
                let says = "no case in the report matches the pattern";
                return Err(CommandError::new(EXIT_NOTHING_SELECTED, says));
            }
            super::terminal::print_styled(&escape_controls(&text));
            Ok(0)
        }
        ReportCommand::Merge(_) | ReportCommand::Diff { .. } => Ok(0),
    }
}

/// Merges the parts of a run.
fn merge(args: &MergeArgs) -> CommandResult {
    let suite = Suite::load()?;
    let writer = ReportWriter::new(&suite, &args.report, &args.outputs)?;
    let answers = RecordedAnswers::read(&suite, &args.parts)?;
    let jobs = super::output::jobs(None)?;
    let Checked { run, report, .. } = super::output::with_progress(|progress| {
        answers.merge(&suite, jobs, &MergeProgress(progress))
    })?;
    let evidence = Evidence::new(&suite, &run, html::case_evidence);
    Ok(writer.finish(run.ending(), report, &evidence, None)?)
}

/// Merges the parts of a run of a texture stage.
fn merge_texture(args: &MergeArgs) -> CommandResult {
    let suite = Suite::load_texture()?;
    let writer = ReportWriter::new(&suite, &args.report, &args.outputs)?;
    let answers = RecordedAnswers::read(&suite, &args.parts)?;
    let jobs = super::output::jobs(None)?;
    let (run, report) = super::output::with_progress(|progress| {
        answers.merge_texture(&suite, jobs, &MergeProgress(progress))
    })?;
    let evidence = Evidence::new(&suite, &run, html::question_evidence);
    Ok(writer.finish(run.ending(), report, &evidence, None)?)
}

/// Shows the number of replayed cases.
struct MergeProgress<'a>(&'a (dyn Fn(usize, usize) + Sync));

impl Observer for MergeProgress<'_> {
    fn case_finished(&self, _: &FinishedCase, done: usize, total: usize) {
        (self.0)(done, total);
    }
}
