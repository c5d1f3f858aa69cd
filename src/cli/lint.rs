//! Subcommand `ptm-conform lint`.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use clap::Args;
use indicatif::ProgressBar;

use super::arguments::parse_size;
use super::collection::{MemoryPool, NamedPath, WalkItem, estimate_memory, paths, walk};
use super::files::with_path;
use super::lint_rows::{RowFormat, Rows};
use super::output::{self, MachineFormatArgs};
use super::readers;
use super::{CommandResult, EXIT_NOTHING_SELECTED};
use ptm_files::lint::Lint;
use ptm_files::lint::codes::{ALL, Severity};
use ptm_files::lint::status::{MAGIC, Status};
use ptm_files::lint::{names::escape_name, settings::Settings};
use ptm_files::readers::ReaderProfile;
use ptm_suite::kit::{parallel::process_in_order, strip_os_error_code, yaml};

/// Check files for errors, predict what other readers may show, and suggest fixes.
///
/// Every file gets one row and one of four statuses: sound, damaged, not a PTM, or not judged. A file is not judged if it is
/// unreadable, a symbolic link inside a folder, larger than --limit, or a PTM that has an unsupported version or exceeds the
/// limits of the reference.
///
/// Codes are stable: PTM-E… the file breaks a rule or the reference cannot read it, PTM-W… some readers refuse it or show a
/// different image, PTM-I… information. For example, `ptm-conform explain PTM-W102` describes a code.
///
/// Exit status, the first that applies: 2 usage error, or a file cannot be read; 1 errors in a PTM (or warnings, with
/// --deny-warnings); 3 a file is not a PTM; 4 a file was not judged; 5 there is no file; 0 all files are sound.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform lint coin.ptm\n  ptm-conform lint -r --format csv /archive > archive.csv\n  find /archive -name '*.ptm' -print0 | ptm-conform lint -0 -\n  ptm-conform lint --only PTM-W301 --severity PTM-W301=error table.ptm"
)]
#[expect(clippy::struct_excessive_bools, reason = "each is a separate option")]
pub struct LintArgs {
    /// PTM files, folders, or - for a list on standard input, one path per line.
    #[arg(required_unless_present = "codes", value_name = "PATH")]
    files: Vec<PathBuf>,
    /// Also check the files in subfolders.
    #[arg(short, long)]
    recursive: bool,
    /// Paths in the list end with a zero byte instead of a line feed.
    #[arg(short = '0', long)]
    null: bool,
    /// The format of the results: text, json, yaml, csv (one row per file) or sarif (2.1.0).
    #[arg(long, value_name = "FORMAT", conflicts_with_all = ["yaml", "json"], hide_possible_values = true)]
    format: Option<RowFormat>,
    /// Do not report this code. Repeatable.
    #[arg(long, value_name = "CODE")]
    allow: Vec<String>,
    /// Report only this code. Repeatable.
    #[arg(long, value_name = "CODE")]
    only: Vec<String>,
    /// Print at most N findings per file, worst first; all findings are counted.
    #[arg(long, value_name = "N")]
    max: Option<usize>,
    /// Change the severity of a code to error, warning or info. Repeatable.
    #[arg(long, value_name = "CODE=LEVEL", value_parser = parse_severity)]
    severity: Vec<(String, Severity)>,
    /// Also exit with 1 for warnings.
    #[arg(long)]
    deny_warnings: bool,
    /// A YAML file with allow, only, severity (a mapping), max and deny_warnings. Options on the command line extend or override
    /// these settings.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Do not read files larger than this.
    #[arg(long, value_name = "SIZE", default_value = "1G", value_parser = parse_size)]
    limit: u64,
    /// Predict what these readers display: the correct image, a wrong image (with the reason) or no image. Separate readers by
    /// commas, or use `all`.
    #[arg(long = "for", value_name = "READER,…", value_delimiter = ',')]
    readers: Vec<String>,
    /// A YAML file with reader profiles to use instead of the built-in ones, in the format of spec-cases/readers.yaml.
    #[arg(long = "readers", value_name = "FILE", requires = "readers")]
    profiles: Option<PathBuf>,
    /// Number of files read in parallel; one per processor by default.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
    /// List all codes and exit.
    #[arg(long)]
    codes: bool,
    #[command(flatten)]
    machine: MachineFormatArgs,
}

/// Number of bytes that are initially read from every file.
const HEAD_BYTES: u64 = 4096;

/// Path of a file, its lint results, and a flag that is true if the file could not be read.
type Row = (PathBuf, Lint, bool);

pub fn run(args: &LintArgs) -> CommandResult {
    if args.codes {
        return list_codes(args);
    }
    let settings = settings(args)?;
    let jobs = output::jobs(args.jobs)?;
    let format = match (args.format, args.machine.yaml, args.machine.json) {
        (Some(format), ..) => format,
        (None, true, _) => RowFormat::Yaml,
        (None, _, true) => RowFormat::Json,
        (None, ..) => RowFormat::Text,
    };
    let profiles = readers::load_profiles(args.profiles.as_deref())?;
    let readers = readers::select_profiles(&profiles, &args.readers)?;
    let rows = Rows::new(format, &readers, settings.max);
    let mut rows = rows.map_err(|error| error.to_string())?;
    let checker = FileChecker {
        limit: args.limit,
        memory: MemoryPool::new(args.limit.saturating_mul(2)),
        readers: &readers,
        settings: &settings,
    };
    let (bar, closed) = (progress(args), AtomicBool::new(false));
    let mut worst = 0;
    let walk = walk(named_sources(args), args.recursive);
    let walk = walk.take_while(|_| !closed.load(Relaxed));
    let rank = |status: &u8| STATUSES_WORST_FIRST.iter().position(|one| one == status);
    process_in_order(
        walk,
        jobs,
        &|item| checker.lint_item(item),
        |(path, lint, failed)| {
            let fails = lint.errors > 0 || (settings.deny_warnings && lint.warnings > 0);
            let status = match lint.status {
                _ if failed => 2,
                Status::NotAPtm if fails => 3,
                Status::NotJudged if fails || lint.reason.is_some() => 4,
                _ => u8::from(fails),
            };
            worst = std::cmp::min_by_key(worst, status, rank);
            let shown = bar.suspend(|| rows.show(&path, lint, failed));
            // Stop if standard output was closed.
            closed.fetch_or(shown.is_err(), Relaxed);
            bar.inc(1);
        },
    );
    let count = bar.position();
    bar.finish_and_clear();
    let _ = rows.end();
    if count == 0 {
        let hint = match args.recursive {
            true => "",
            false => "; -r includes subfolders",
        };
        output::print_error(&format!("ptm-conform: no file to check{hint}"));
        return Ok(EXIT_NOTHING_SELECTED);
    }
    Ok(worst)
}

/// Exit statuses from worst to best: unreadable, errors, not a PTM, not judged, sound.
const STATUSES_WORST_FIRST: [u8; 5] = [2, 1, 3, 4, 0];

fn settings(args: &LintArgs) -> Result<Settings, String> {
    let file = match &args.config {
        Some(path) => yaml::from_yaml(&yaml::read_text(path)?).map_err(with_path(path))?,
        None => Settings::default(),
    };
    let settings = file.merge(Settings {
        allow: args.allow.clone(),
        only: args.only.clone(),
        severity: args.severity.iter().cloned().collect(),
        max: args.max,
        deny_warnings: args.deny_warnings,
    });
    settings.check()?;
    Ok(settings)
}

/// Returns the paths from the command line and from the list on standard input.
fn named_sources(args: &LintArgs) -> impl Iterator<Item = NamedPath> + Send {
    let end = if args.null { 0 } else { b'\n' };
    let expand = move |path: &PathBuf| -> Box<dyn Iterator<Item = NamedPath> + Send> {
        match is_list(path) {
            true => Box::new(paths(BufReader::new(io::stdin()), end).map(|path| (path, true))),
            false => Box::new(std::iter::once((path.clone(), false))),
        }
    };
    args.files.iter().flat_map(expand)
}

fn is_list(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Creates a progress bar. A separate thread counts the files, so that the remaining time can be estimated.
fn progress(args: &LintArgs) -> ProgressBar {
    let bar = output::bar(None, "{pos}/{len} files, {per_sec}, {eta} left");
    // A list can be read only once.
    if bar.is_hidden() || args.files.iter().any(|path| is_list(path)) {
        return bar;
    }
    let (files, recursive, counted) = (args.files.clone(), args.recursive, bar.clone());
    std::thread::spawn(move || {
        let walk = walk(files.into_iter().map(|path| (path, false)), recursive);
        let files = walk.take_while(|_| !counted.is_finished()).count();
        counted.set_length(files as u64);
    });
    bar
}

/// Checks files with settings that apply to all of them.
struct FileChecker<'a> {
    limit: u64,
    memory: MemoryPool,
    readers: &'a [&'a ReaderProfile],
    settings: &'a Settings,
}

impl FileChecker<'_> {
    /// Reads and checks a file. A panic affects only the result for this file.
    fn lint_item(&self, item: WalkItem) -> Row {
        let unread = |path: &Path, reason: &str| {
            let name = escape_name(path.as_os_str());
            Lint::unread(&name, None, Some(reason.to_owned()))
        };
        let (path, judged) = match item {
            WalkItem::File(path) => {
                let judged = catch_unwind(AssertUnwindSafe(|| self.check_file(&path)));
                let failed = |_| Err(io::Error::other("internal error in ptm-conform"));
                let judged = judged.unwrap_or_else(failed);
                (path, judged)
            }
            WalkItem::Skipped(path, why) => (path.clone(), Ok(unread(&path, why))),
            WalkItem::Unreadable(path, error) => (path, Err(error)),
        };
        let failed = judged.is_err();
        let lint = judged.unwrap_or_else(|error| unread(&path, &strip_os_error_code(&error)));
        (path, self.settings.apply(lint), failed)
    }

    /// Checks a file. If the file is a PTM, waits until there is enough memory for it and its planes.
    fn check_file(&self, path: &Path) -> io::Result<Lint> {
        let (name, limit) = (escape_name(path.as_os_str()), self.limit);
        let too_long = |length: Option<u64>| {
            let reason = format!("larger than the limit of {limit} bytes");
            Lint::unread(&name, length, Some(reason))
        };
        let mut file = File::open(path)?;
        let length = file.metadata()?.len();
        let mut bytes = Vec::with_capacity(HEAD_BYTES as usize);
        file.by_ref().take(HEAD_BYTES).read_to_end(&mut bytes)?;
        if !bytes.starts_with(MAGIC) {
            // The file system does not report the real length of a pipe or device.
            let length = length.max(bytes.len() as u64);
            return Ok(Lint {
                bytes: Some(length),
                ..Lint::new(&name, &bytes)
            });
        }
        if length > limit {
            return Ok(too_long(Some(length)));
        }
        let needed = estimate_memory(&bytes, length);
        self.memory.run_when_free(needed, || {
            // A shorter file has already been read completely.
            if bytes.len() as u64 == HEAD_BYTES {
                let rest = limit.saturating_add(1).saturating_sub(HEAD_BYTES);
                file.take(rest).read_to_end(&mut bytes)?;
            }
            if bytes.len() as u64 > limit {
                return Ok(too_long(None));
            }
            let mut lint = Lint::new(&name, &bytes);
            lint.readers = readers::predict_readers(&bytes, self.readers);
            Ok(lint)
        })
    }
}

fn list_codes(args: &LintArgs) -> CommandResult {
    if !args.machine.print(&*ALL)? {
        for code in ALL.iter() {
            let (id, clause, says) = (code.id, code.clause, code.message);
            output::print(&format!("{id}  {clause:<8} {says}\n"));
        }
    }
    Ok(0)
}

fn parse_severity(text: &str) -> Result<(String, Severity), String> {
    let severities = [Severity::Error, Severity::Warning, Severity::Info];
    let pair = text.split_once('=').and_then(|(code, level)| {
        let severity = severities.into_iter().find(|one| one.name() == level)?;
        Some((code.to_owned(), severity))
    });
    let expected = "expected a code and a level (error, warning or info), such as PTM-W301=error";
    pair.ok_or_else(|| format!("{expected}, found {text:?}"))
}
