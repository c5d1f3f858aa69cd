//! Arguments of `check` and values derived from them.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::arguments::{id_selection, is_at_or_below, parse_format, parse_refusal, view_parser};
use super::calls::RunArgs;
use super::{CommandError, EXIT_NOTHING_SELECTED};
use super::{ending::OutputArgs, names::did_you_mean};
use ptm::Format;
use ptm_harness::pipeline::recorder::ShardRecorder;
use ptm_harness::runner::processes;
use ptm_harness::session::plan::SAMPLE_INTERVAL;
use ptm_suite::cases::Suite;
use ptm_suite::kit::shard::Shard;
use ptm_suite::protocol::frame::ViewKind;
use ptm_suite::test_case::{Listed, Output};

// Comments on the variants would appear in the help text.
/// A suite for decoders.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DecoderSuite {
    Ptm,
    Texture,
}

/// Run the suite on a decoder and name the clauses that it misreads.
///
/// The decoder is called as `DECODER [ARG…] VIEW FILE` once per case, where VIEW is raw, coef or rgb:LU,LV. It prints one line,
/// "PTM1 VIEW WIDTH HEIGHT CHANNELS u8" (f32 for coef), then the samples, texel by texel, top row first. It exits with 0, with 65
/// if the file is malformed, or with 69 if it does not support the file's format or the view.
///
/// Exit status: 0 no case fails, 1 a case fails, 2 usage error, 3 not a decoder, 4 baseline entries pass and should be removed,
/// 5 no case was selected.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform check ./my-decoder\n  ptm-conform check -- python3 decode.py --strict\n  ptm-conform check --ptm-format LRGB --fail-fast ./my-decoder\n  ptm-conform check --case '*lut*' --skip '*huge*' --jobs 1 ./my-decoder\n  ptm-conform check --cmd 'viewer -u {lu} -v {lv} {in} -o {out}.png' --reject-exit 1\n  ptm-conform check --baseline known-failures.yaml ./my-decoder"
)]
#[expect(clippy::struct_excessive_bools, reason = "each is a separate option")]
pub struct CheckArgs {
    #[command(flatten)]
    pub run: RunArgs,
    /// Run only cases whose id matches; * and ? are wildcards. Repeatable.
    #[arg(long = "case", value_name = "GLOB")]
    pub cases: Vec<String>,
    /// Skip cases whose id matches; * and ? are wildcards. Repeatable.
    #[arg(long = "skip", value_name = "GLOB")]
    pub skipped: Vec<String>,
    /// Run only cases of this format, for example LRGB. Repeatable.
    #[arg(long = "ptm-format", alias = "format", value_name = "FORMAT", value_parser = parse_format)]
    pub formats: Vec<Format>,
    /// Run only cases about this clause or section, for example 2.4/8 or 2.4. Repeatable.
    #[arg(long = "clause", value_name = "ID")]
    pub clauses: Vec<String>,
    /// The suite: PTM files, or the texture mapping table (the decoder is called as `DECODER texture FILE`).
    #[arg(long, value_name = "SUITE", value_enum, default_value = "ptm")]
    pub suite: DecoderSuite,
    /// Request only this view. Repeatable.
    #[arg(long = "view", value_name = "VIEW", value_parser = view_parser())]
    pub views: Vec<ViewKind>,
    /// Run only one part of the suite, for example 3/8, and keep all responses in REPORT.answers for `report merge`, where REPORT
    /// is the file of --report.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Use serve mode (`DECODER serve`); the default if the decoder's capabilities declare it.
    #[arg(long, conflicts_with = "one_shot")]
    pub serve: bool,
    /// Start a new process for each call.
    #[arg(long)]
    pub one_shot: bool,
    /// An exit status other than 65 that also means "malformed".
    ///
    /// In many languages, a program with an uncaught exception exits with 1. Refusals with a status other than 65 are therefore
    /// marked weak in the report: a decoder that crashes on every malformed file would pass these cases, too.
    #[arg(long, value_name = "N", value_parser = parse_refusal)]
    pub reject_exit: Option<i32>,
    /// Check every .ptm file in DIR instead of the suite, against the reference and against other encodings of the same values.
    #[arg(long, value_name = "DIR")]
    pub files: Option<PathBuf>,
    /// Print the ids of the selected cases, one per line, and request nothing. --smoke --list prints the subset for decoders of all
    /// formats, or of those that --ptm-format names.
    #[arg(long)]
    pub list: bool,
    /// End the run after the first failure.
    #[arg(long)]
    pub fail_fast: bool,
    /// Run only the smoke subset: a few cases that catch every misreading in the catalog if the decoder supports all formats. Of a
    /// decoder that supports some, the subsets of its formats are run.
    #[arg(long)]
    pub smoke: bool,
    /// Ask all files of every feature. Without this option, if the decoder exits with 69 (unsupported) for the first files that need
    /// a format or another feature, the other ones are not asked.
    #[arg(long)]
    pub all: bool,
    /// Assume that the decoder has this misreading (a name from the diagnosis), and judge its other answers. Repeatable.
    #[arg(long = "assume", value_name = "SLUG")]
    pub assumed: Vec<String>,
    /// Check a program that does not speak the protocol by running this command line.
    ///
    /// The line is split into words as in a shell, but no shell is run. {in} is the PTM file. {out} is the output file and may
    /// have a suffix ({out}.png). If the line has no {out}, standard output is read. {lu} and {lv} are the light direction;
    /// {view} is raw, coef or rgb:LU,LV. {{ and }} are braces. The output is an image (PNG, PNM, TIFF, BMP, WebP or JPEG), a
    /// NumPy array or a PTM1 frame. Only rgb is requested, unless the line has {view} or --view names one view. Without
    /// --reject-exit, files that must or may be refused are not judged.
    #[arg(long, value_name = "TEMPLATE", conflicts_with_all = ["decoder", "serve"])]
    pub cmd: Option<String>,
    /// Judge images that were made elsewhere, for example in a viewer, in a browser or on another system.
    ///
    /// DIR is a directory written by `generate --requests`. Its subdirectory outputs/ contains one file per case, named after the
    /// case: an image, a NumPy array or a PTM1 frame. Refused and unsupported files are listed in rejected.txt and
    /// unsupported.txt. Cases without an output are not judged.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["decoder", "cmd", "serve", "reject_exit", "views", "files", "shard"])]
    pub outputs: Option<PathBuf>,
    /// Send requests to the process that listens on this Unix socket (for packages in other languages).
    #[arg(long, value_name = "SOCKET", hide = true, conflicts_with_all = ["decoder", "cmd", "serve", "one_shot", "outputs", "files", "shard"])]
    pub caller: Option<PathBuf>,
    #[command(flatten)]
    pub output: OutputArgs,
    /// The decoder and its arguments. Without a decoder, the built-in reference is checked.
    #[arg(value_name = "DECODER", trailing_var_arg = true)]
    pub decoder: Vec<OsString>,
}

impl CheckArgs {
    /// Returns an error if no decoder follows `--`, for example because a shell variable is empty.
    pub fn reject_bare_hyphens(&self) -> Result<(), String> {
        let last = std::env::args_os().next_back();
        if self.decoder.is_empty() && last.is_some_and(|last| last == "--") {
            let says = "check: expected a decoder after --, for example: ptm-conform check -- python3 decode.py (without --, check runs the built-in reference)";
            return Err(says.to_owned());
        }
        Ok(())
    }

    /// Returns one flag per case: true if the case is in the subset, matches the patterns, the formats and the clauses, and belongs to
    /// the shard. Returns an error if no case is selected.
    pub fn select_cases<C: Listed>(
        &self,
        suite: &Suite<C>,
        is_in_subset: impl Fn(usize) -> bool,
    ) -> Result<Vec<bool>, CommandError> {
        let is_named = id_selection(&self.cases, &self.skipped)?;
        let is_about = |clause: &String| {
            let mut asked = self.clauses.iter();
            asked.any(|asked| is_at_or_below(clause, asked))
        };
        let is_in_shard = |id: &str| self.shard.is_none_or(|shard| shard.contains(id.as_bytes()));
        let matches = |case: &C| {
            is_named(case.id())
                && (self.clauses.is_empty() || case.clauses().iter().any(is_about))
                && is_in_shard(case.id())
        };
        let cases = suite.cases.iter().enumerate();
        let selected: Vec<bool> = cases
            .map(|(i, case)| is_in_subset(i) && matches(case))
            .collect();
        if selected.contains(&true) {
            return Ok(selected);
        }
        let ids = || suite.cases.iter().map(Listed::id);
        let meant = self.cases.iter().map(|name| did_you_mean(name, ids()));
        let says = format!(
            "no case matches --case, --skip, --ptm-format, --clause, --smoke and --shard{}; ptm-conform explain 2.5 lists the clauses and cases of section 2.5",
            meant.collect::<String>()
        );
        Err(CommandError::new(EXIT_NOTHING_SELECTED, &says))
    }

    /// Creates the recorder of answers, if only a part of the suite is run.
    pub fn recorder<T: Output>(&self) -> Result<Option<ShardRecorder<T>>, String> {
        let recorder = |part| ShardRecorder::new(part, &self.run.report);
        self.shard.map(recorder).transpose()
    }

    /// Describes the limits in force.
    pub fn limits(&self, serves: bool) -> Vec<String> {
        if self.outputs.is_some() {
            return vec!["none: the outputs were produced outside this run".to_owned()];
        }
        if self.caller.is_some() {
            return vec!["none: the decoder is a function of the calling process".to_owned()];
        }
        let killed = match processes::can_inspect_processes() {
            true => ", and processes that have left it, are",
            false => " is",
        };
        let mut limits = self.run.calls.describe_limits();
        limits.extend([
            "standard output: 4 times the size of the file's largest frame, plus 64 KiB".to_owned(),
            "files: 4 GiB each, no core dumps".to_owned(),
            format!("processes: the process group of a call{killed} killed when the call ends"),
            "input: each file is compared with its original bytes after the call, and must be unchanged".to_owned(),
            "locale: C; the first files are requested again in a locale with a decimal comma, if the system has one"
                .to_owned(),
        ]);
        if serves {
            limits.push(format!("serve mode: one process per job; failed cases and one in {SAMPLE_INTERVAL} of the others are repeated in one-shot mode"));
        }
        limits
    }
}
