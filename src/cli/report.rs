//! `report show`, `diff`, `merge`, `html`, `junit`, `badge` and `markdown`: reports read back.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::known_failures::KnownFailureArgs;
use super::renderings::RenderingArgs;
use ptm_conform::harness::cases::Suite;
use ptm_conform::harness::merge::Answers;
use ptm_conform::harness::report::Report;
use ptm_conform::harness::{badge, github, html, junit};

/// Read reports that check has written.
#[derive(Args)]
pub struct ReportArgs {
    #[command(subcommand)]
    command: ReportCommand,
}

#[derive(Subcommand)]
enum ReportCommand {
    /// Print a report as check prints it.
    Show {
        /// The report.
        file: PathBuf,
        /// Say all of the cases whose id matches instead; * and ? are wild cards. May be given more than once.
        #[arg(long = "case", value_name = "GLOB")]
        cases: Vec<String>,
        /// Failures to print in full.
        #[arg(long, value_name = "N", default_value_t = 10)]
        show: usize,
    },
    /// Make a page for a browser: of one report, or of several a table of decoders and clauses.
    ///
    /// A report holds no pictures; check --html makes a page that does.
    Html {
        /// The reports.
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
        /// Where to write the page.
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
    },
    /// Write a report as `JUnit` XML.
    Junit(Made),
    /// Draw a badge in SVG with the three scores.
    Badge(Made),
    /// Write a summary in Markdown.
    Markdown(Made),
    /// Say exactly what changed from one report to another.
    ///
    /// Cases that began to fail, were mended, changed their outcome, say something else, appeared or vanished; and the
    /// decoder, its scores, dialect and diagnoses.
    ///
    /// Exit status: 0 the reports are equal, 1 they differ, 2 one of them cannot be read.
    Diff {
        /// The report before.
        old: PathBuf,
        /// The report after.
        new: PathBuf,
    },
    Merge(MergeArgs),
}

/// Make the report of a whole run from its parts.
///
/// Each part is run by `check --shard I/N --report PART`, on any machine, with the same decoder and the same arguments;
/// that keeps the decoder's answers in PART.answers, which must lie beside PART. All N parts are needed. Verdicts,
/// dialect and diagnoses are made anew from all answers, so the report is that of the run in one piece.
///
/// Exit status: that of check; 2 if a part is missing, damaged, of another run or did not end.
#[derive(Args)]
#[command(
    after_help = "Example:\n  ptm-conform check --shard 1/2 --report part-1.yaml ./my-decoder\n  ptm-conform check --shard 2/2 --report part-2.yaml ./my-decoder\n  ptm-conform report merge part-1.yaml part-2.yaml"
)]
struct MergeArgs {
    /// The reports of all parts.
    #[arg(value_name = "PART", required = true)]
    parts: Vec<PathBuf>,
    /// Where to write the report.
    #[arg(long, value_name = "FILE", default_value = "ptm-conform-report.yaml")]
    report: PathBuf,
    /// Failures to print in full; the report has all of them.
    #[arg(long, value_name = "N", default_value_t = 10)]
    show: usize,
    #[command(flatten)]
    renderings: RenderingArgs,
    #[command(flatten)]
    known: KnownFailureArgs,
}

#[derive(Args)]
struct Made {
    /// The report.
    file: PathBuf,
    /// Where to write; standard output unless told.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Made {
    fn write(&self, text: &str) -> Result<u8, String> {
        match &self.output {
            Some(path) => super::files::write_whole(path, text)?,
            None => super::output::print(text),
        }
        Ok(0)
    }
}

/// The reports differ.
const EXIT_DIFFERENT: u8 = 1;

pub fn run(args: &ReportArgs) -> Result<u8, String> {
    match &args.command {
        ReportCommand::Show { file, cases, show } => {
            let report = Report::read(file)?;
            let suite = Suite::load()?;
            if cases.is_empty() {
                super::output::print(&printable(&report.to_text(&suite, *show)));
                return Ok(0);
            }
            let globs = super::arguments::globs(cases)?;
            let text = report.cases_to_text(&suite, |id| globs.iter().any(|glob| glob.matches(id)));
            if text.is_empty() {
                super::output::complain("ptm-conform: no case of the report matches");
                return Ok(super::EXIT_NOTHING_SELECTED);
            }
            super::output::print(&printable(&text));
            Ok(0)
        }
        ReportCommand::Merge(args) => merge(args),
        ReportCommand::Html { files, output } => {
            let reports = files.iter().map(|file| Report::read(file));
            let reports: Vec<Report> = reports.collect::<Result<_, _>>()?;
            let page = match &reports[..] {
                [report] => html::page(&Suite::load()?, report, None)?,
                reports => html::matrix(reports)?,
            };
            super::files::write_whole(output, &page)?;
            Ok(0)
        }
        ReportCommand::Junit(made) => made.write(&junit::junit(&Report::read(&made.file)?)?),
        ReportCommand::Badge(made) => made.write(&badge::badge(&Report::read(&made.file)?)),
        ReportCommand::Markdown(made) => {
            let report = Report::read(&made.file)?;
            made.write(&github::summary(&Suite::load()?, &report))
        }
        ReportCommand::Diff { old, new } => {
            let changes = Report::read(old)?.changes_to(&Report::read(new)?);
            super::output::print(&printable(&changes));
            Ok(if changes.is_empty() {
                0
            } else {
                EXIT_DIFFERENT
            })
        }
    }
}

fn merge(args: &MergeArgs) -> Result<u8, String> {
    let suite = Suite::load()?;
    let known = args.known.read(&suite)?;
    let answers = Answers::read(&suite, &args.parts)?;
    let bar = super::output::progress_bar();
    let merged = answers.merge(&suite, super::output::jobs(None)?, &|_, _, done, all| {
        super::output::show_progress(&bar, done, all);
    });
    bar.finish_and_clear();
    let (run, report) = merged?;
    super::check::finish(
        &suite,
        &run,
        report,
        &args.report,
        args.show,
        (&args.known, known.as_ref()),
        &args.renderings,
    )
}

/// What may be shown on a terminal, whoever wrote the report: control characters but line feeds and tabs are escaped.
fn printable(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() && c != '\n' && c != '\t' {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
    }
    shown
}
