//! Subcommand `ptm-conform lint`.

use std::fs::{self, File, Metadata};
use std::io::{self, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicIsize, Ordering::Relaxed};

use clap::Args;
use glob::Pattern;
use indicatif::ProgressBar;

use super::arguments::parse_size;
use super::collection::{
    MemoryPool, WalkItem, estimate_memory, is_list, is_ptm_in_folder, named_sources,
    relative_to_named, walk,
};
use super::files::with_path;
use super::lint_history::{Change, EarlierRow, EarlierRows};
use super::lint_rows::{Renewal, RowFormat, Rows};
use super::output::{self, MachineFormatArgs};
use super::readers;
use super::{CommandResult, EXIT_NOTHING_SELECTED};
use crate::lint_page;
use ptm_files::lint::Lint;
use ptm_files::lint::codes::{ALL, Severity};
use ptm_files::lint::status::{Status, begins_like_a_ptm, is_named_ptm};
use ptm_files::lint::{names::escape_name, settings::Settings};
use ptm_files::readers::ReaderProfile;
use ptm_suite::kit::digest::{sha256, sha256_of_reader};
use ptm_suite::kit::shard::Shard;
use ptm_suite::kit::{parallel::process_in_order, strip_os_error_code, yaml};

/// Check files for errors, predict what other readers may show, and suggest fixes.
///
/// In folders, files whose name ends in .ptm (in upper or lower case) or whose bytes begin with PTM_ are checked; the others are only
/// counted. Files that you name are always checked. Every file gets one row and one of five statuses: sound, damaged, foreign
/// (something else than a PTM), not judged, or unreadable. A file is not judged if it is a symbolic link inside a folder, larger than
/// --limit, or a PTM that has another version or exceeds the limits of the reference. "Sound" means well-formed: a changed texel cannot
/// be detected without a checksum.
///
/// Codes are stable: PTM-E… the file breaks a rule or the reference cannot read it, PTM-W… some readers refuse it or show a
/// different image, PTM-I… information. For example, `ptm-conform explain PTM-W102` describes a code.
///
/// Exit status, the first that applies: 2 usage error, or the results cannot be written; 1 a file is damaged or has errors (or
/// warnings, with --deny-warnings); 6 a file cannot be read; 3 a file is foreign; 4 a file was not judged; 5 there is no file; 0 all
/// files are sound. With --baseline: 1 a file is newly damaged, changed, missing, or new and not sound; 0 otherwise.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform lint coin.ptm\n  ptm-conform lint -r --format csv /archive > archive.csv\n  ptm-conform lint -r --format csv --resume archive.csv /archive > whole.csv\n  ptm-conform lint -r --format html /archive > archive.html\n  ptm-conform lint -rq --baseline archive.csv --renew /archive     # for cron: quiet if nothing has changed\n  find /archive -name '*.ptm' -print0 | ptm-conform lint -0 -\n  ptm-conform lint --only PTM-W301 --severity PTM-W301=error table.ptm"
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
    /// In folders, check the files whose name matches GLOB (such as '*.bak') instead. Repeatable.
    #[arg(long, value_name = "GLOB", value_parser = parse_glob)]
    name: Vec<Pattern>,
    /// Check only part I of N. The path of a file within its folder on the command line determines its part.
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// The format of the results: text, json, jsonl (a JSON record per line), yaml, csv (one row per file), html (a
    /// page with thumbnails) or sarif (2.1.0).
    #[arg(long, value_name = "FORMAT", conflicts_with_all = ["yaml", "json"], hide_possible_values = true)]
    format: Option<RowFormat>,
    /// Print no header row (csv).
    #[arg(long)]
    no_header: bool,
    /// Continue an interrupted run: ROWS are the csv or jsonl rows that it printed. Rows of files with the same size and time are
    /// printed again without reading the files. Use the same options as for the first run.
    #[arg(long, value_name = "ROWS", conflicts_with = "baseline")]
    resume: Option<PathBuf>,
    /// With --resume, also read files of the same size and time, and compare their SHA-256 digest.
    #[arg(long, requires = "resume")]
    rehash: bool,
    /// Compare with the csv or jsonl rows of an earlier run: print only what is new, changed, missing, newly damaged or repaired.
    #[arg(long, value_name = "ROWS", conflicts_with_all = ["format", "yaml", "json", "shard"])]
    baseline: Option<PathBuf>,
    /// With --baseline, replace ROWS by the rows of this run, so that every change is reported once. ROWS stays as it is if a file
    /// or folder cannot be read, or if there is no file to check.
    #[arg(long, requires = "baseline")]
    renew: bool,
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

/// Result for an item of a collection.
enum Checked {
    /// A file that was checked, and its thumbnail.
    File(PathBuf, Box<Lint>, Option<String>),
    /// A file that has not changed since the earlier run.
    Earlier(Box<EarlierRow>),
    /// A file in a folder that is not checked.
    Other,
}

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
    let earlier = args.resume.as_deref().map(EarlierRows::read).transpose()?;
    if let Some(earlier) = &earlier {
        earlier.check_format(format, readers.iter().map(|reader| &*reader.name))?;
    }
    let mut baseline = args
        .baseline
        .as_deref()
        .map(EarlierRows::read)
        .transpose()?;
    if let Some(path) = args
        .resume
        .as_ref()
        .filter(|_| earlier.as_ref().is_some_and(EarlierRows::is_empty))
    {
        let path = path.display();
        output::print_error(&format!(
            "ptm-conform: {path} has no rows, so every file is checked; `--resume ROWS > ROWS` empties ROWS before it is read"
        ));
    }
    let mut renewal = match (&args.baseline, &baseline) {
        (Some(path), Some(baseline)) if args.renew => {
            Some(Renewal::new(path, baseline.format(), &readers)?)
        }
        _ => None,
    };
    let folders = args.files.iter().map(|path| escape_name(path.as_os_str()));
    let folders: Vec<String> = folders.filter(|name| name != "-").collect();
    let rows = Rows::new(format, &readers, settings.max, !args.no_header, &folders);
    let mut rows = rows.map_err(|error| error.to_string())?;
    let checker = FileChecker {
        limit: args.limit,
        memory: MemoryPool::new(args.limit.saturating_mul(2)),
        readers: &readers,
        settings: &settings,
        args,
        earlier: earlier.as_ref(),
        has_checksums: format.has_columns() || baseline.is_some(),
        thumbnails: AtomicIsize::new(match format {
            RowFormat::Html => lint_page::MAX_THUMBNAILS as isize,
            _ => 0,
        }),
    };
    let (bar, closed) = (progress(args), AtomicBool::new(false));
    let mut written = Ok(());
    let mut worst = 0;
    let mut has_new_trouble = false;
    let (mut reused, mut unreadable) = (0_usize, 0_usize);
    let walk = walk(named_sources(&args.files, args.null), args.recursive);
    let walk = walk.take_while(|_| !closed.load(Relaxed));
    let walk = walk.filter(|item| {
        args.shard
            .is_none_or(|part| part.contains(&shard_name(&args.files, item.path())))
    });
    let rank = |status: &u8| STATUSES_WORST_FIRST.iter().position(|one| one == status);
    process_in_order(walk, jobs, &|item| checker.check_item(item), |checked| {
        let (judged, shown) = match checked {
            Checked::Other => {
                rows.count_other();
                return bar.inc(1);
            }
            Checked::Earlier(row) => {
                let judged = (row.status, row.errors, row.warnings);
                reused += 1;
                (judged, bar.suspend(|| rows.show_earlier(&row)))
            }
            Checked::File(path, lint, thumbnail) => {
                let judged = (lint.status, lint.errors, lint.warnings);
                unreadable += usize::from(lint.status == Status::Unreadable);
                let renewed = renewal
                    .as_mut()
                    .map_or(Ok(()), |renewal| renewal.add(&lint));
                let shown = match &mut baseline {
                    Some(baseline) => bar.suspend(|| {
                        let change = baseline.compare(&lint);
                        has_new_trouble |= change.is_some_and(Change::needs_attention);
                        rows.show_change(&lint, change)
                    }),
                    None => bar.suspend(|| rows.show(&path, *lint, thumbnail.as_ref())),
                };
                let shown = renewed.and(shown);
                (judged, shown)
            }
        };
        let status = exit_status(judged, settings.deny_warnings);
        worst = std::cmp::min_by_key(worst, status, rank);
        // Stop if standard output was closed, or a disk is full.
        if shown.is_err() {
            closed.store(true, Relaxed);
            written = shown;
        }
        bar.inc(1);
    });
    bar.finish_and_clear();
    if written.is_err() {
        output::check_written(written)?;
        return Ok(worst);
    }
    if let Some(baseline) = &baseline {
        let missing = baseline.missing();
        for file in &missing {
            output::check_written(Rows::show_missing(file))?;
        }
        worst = u8::from(has_new_trouble || !missing.is_empty());
    }
    output::check_written(rows.end())?;
    if let Some(path) = args.resume.as_ref().filter(|_| !output::is_quiet()) {
        let (path, [files, _]) = (path.display(), rows.counts());
        output::print_error(&format!("{reused} of {files} rows are those of {path}"));
    }
    if let Some(renewal) = renewal {
        let kept = match (unreadable, rows.counts()) {
            (_, [0, _]) => Some("there is no file to check".to_owned()),
            (0, _) => None,
            (count, _) => Some(format!("unreadable files and folders: {count}")),
        };
        match kept {
            Some(why) => {
                output::print_error(&format!("ptm-conform: the rows are not renewed; {why}"));
            }
            None => renewal.finish()?,
        }
    }
    if let [0, others] = rows.counts()
        && baseline.is_none()
    {
        let hint = match (others, args.recursive) {
            (0, true) => String::new(),
            (0, false) => "; -r includes subfolders".to_owned(),
            _ => format!(" among {others} files: none is named .ptm or begins with PTM_"),
        };
        output::print_error(&format!("ptm-conform: no file to check{hint}"));
        return Ok(EXIT_NOTHING_SELECTED);
    }
    Ok(worst)
}

/// Returns the path that determines the part of a file: relative to the folder that was named, so that a collection has the same
/// parts under every mount point.
fn shard_name(named: &[PathBuf], path: &Path) -> Vec<u8> {
    let parts = relative_to_named(named, path).unwrap_or(path).components();
    let parts = parts.filter(|part| *part != Component::CurDir);
    let parts: Vec<&[u8]> = parts
        .map(|part| part.as_os_str().as_encoded_bytes())
        .collect();
    parts.join(&b'/')
}

/// Exit statuses from worst to best: damaged, unreadable, foreign, not judged, sound.
const STATUSES_WORST_FIRST: [u8; 5] = [1, 6, 3, 4, 0];

/// Returns the exit status for a file with this status and these numbers of errors and warnings.
fn exit_status((status, errors, warnings): (Status, usize, usize), deny_warnings: bool) -> u8 {
    match status {
        Status::Damaged => 1,
        Status::Unreadable => 6,
        Status::Foreign => 3,
        Status::NotJudged => 4,
        Status::Sound => u8::from(errors > 0 || deny_warnings && warnings > 0),
    }
}

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

/// Creates a progress bar. A separate thread counts the files, so that the remaining time can be estimated.
fn progress(args: &LintArgs) -> ProgressBar {
    let bar = output::bar(None, "{pos}/{len} files, {eta} left");
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
    args: &'a LintArgs,
    /// The rows of an interrupted run.
    earlier: Option<&'a EarlierRows>,
    /// True if the results include the time and the digest of a file.
    has_checksums: bool,
    /// Number of thumbnails that are still to be made, or less than 1 if there are no more.
    thumbnails: AtomicIsize,
}

impl FileChecker<'_> {
    /// Reads and checks a file. A panic affects only the result for this file.
    fn check_item(&self, item: WalkItem) -> Checked {
        let unread = |path: &Path, reason: &str| {
            let name = escape_name(path.as_os_str());
            Lint::unread(&name, None, Some(reason.to_owned()))
        };
        let (path, judged) = match item {
            WalkItem::Found(path) if !self.selects(&path) => return Checked::Other,
            WalkItem::Skipped(path, _) if !self.selects_name(&path) => return Checked::Other,
            WalkItem::File(path) | WalkItem::Found(path) => {
                let earlier = self.earlier.and_then(|rows| rows.get(&path));
                if let Some(row) = earlier.filter(|row| self.is_unchanged(&path, row)) {
                    return Checked::Earlier(Box::new(row.clone()));
                }
                let judged = catch_unwind(AssertUnwindSafe(|| self.check_file(&path)));
                let failed = |_| Err(io::Error::other("internal error in ptm-conform"));
                let judged = judged.unwrap_or_else(failed);
                (path, judged)
            }
            WalkItem::Skipped(path, why) => (path.clone(), Ok((unread(&path, why), None))),
            WalkItem::Unreadable(path, error) => (path, Err(error)),
        };
        let (lint, thumbnail) = judged.unwrap_or_else(|error| {
            let lint = Lint {
                status: Status::Unreadable,
                ..unread(&path, &strip_os_error_code(&error))
            };
            (lint, None)
        });
        Checked::File(path, Box::new(self.settings.apply(lint)), thumbnail)
    }

    /// Returns true if a file in a folder is checked. A file that cannot be read is checked, so that this is reported.
    fn selects(&self, path: &Path) -> bool {
        match &self.args.name[..] {
            [] => is_ptm_in_folder(path),
            _ => self.selects_name(path),
        }
    }

    /// Returns true if the name of a file in a folder selects it.
    fn selects_name(&self, path: &Path) -> bool {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        match &self.args.name[..] {
            [] => is_named_ptm(&name),
            patterns => patterns.iter().any(|pattern| pattern.matches(&name)),
        }
    }

    /// Returns true if a file has not changed since its earlier row.
    fn is_unchanged(&self, path: &Path, row: &EarlierRow) -> bool {
        let Ok(data) = path.metadata() else {
            return false;
        };
        row.is_unchanged(data.len(), &modification_time(&data))
            && (!self.args.rehash
                || row.sha256.is_empty()
                || fs::read(path).is_ok_and(|bytes| sha256(&bytes) == row.sha256))
    }

    /// Checks a file. If the file is a PTM, waits until there is enough memory for it and its planes.
    fn check_file(&self, path: &Path) -> io::Result<(Lint, Option<String>)> {
        let (name, limit) = (escape_name(path.as_os_str()), self.limit);
        let too_long = |length: Option<u64>| {
            let reason = format!("larger than the limit of {limit} bytes");
            Ok((Lint::unread(&name, length, Some(reason)), None))
        };
        let mut file = File::open(path)?;
        let data = file.metadata()?;
        let length = data.len();
        let modified = self.has_checksums.then(|| modification_time(&data));
        let mut bytes = Vec::with_capacity(HEAD_BYTES as usize);
        file.by_ref().take(HEAD_BYTES).read_to_end(&mut bytes)?;
        if !begins_like_a_ptm(&bytes) {
            // The file system does not report the real length of a pipe or device.
            let length = length.max(bytes.len() as u64);
            let has_checksum = self.has_checksums && data.is_file() && length <= limit;
            let digest = has_checksum.then(|| sha256_of_reader((&bytes[..]).chain(file)));
            let lint = Lint {
                bytes: Some(length),
                sha256: digest.transpose()?,
                modified,
                ..Lint::new(&name, &bytes)
            };
            return Ok((lint, None));
        }
        if length > limit {
            return too_long(Some(length));
        }
        let needed = estimate_memory(&bytes, length);
        self.memory.run_when_free(needed, || {
            // A shorter file has already been read completely.
            if bytes.len() as u64 == HEAD_BYTES {
                let rest = limit.saturating_add(1).saturating_sub(HEAD_BYTES);
                file.take(rest).read_to_end(&mut bytes)?;
            }
            if data.is_file() && bytes.len() as u64 != length {
                return Err(io::Error::other("the file changed while it was read"));
            }
            if bytes.len() as u64 > limit {
                return too_long(None);
            }
            let has_thumbnail = self.thumbnails.fetch_sub(1, Relaxed) > 0;
            let thumbnail = has_thumbnail
                .then(|| lint_page::thumbnail(&bytes))
                .flatten();
            let lint = Lint {
                readers: readers::predict_readers(&bytes, self.readers),
                sha256: self.has_checksums.then(|| sha256(&bytes)),
                modified,
                ..Lint::new(&name, &bytes)
            };
            Ok((lint, thumbnail))
        })
    }
}

/// Returns the time of the last change to a file in UTC, or an empty text if the system does not report it.
fn modification_time(data: &Metadata) -> String {
    let time = data.modified();
    time.map_or_else(
        |_| String::new(),
        |time| humantime::format_rfc3339_nanos(time).to_string(),
    )
}

fn parse_glob(text: &str) -> Result<Pattern, String> {
    Pattern::new(text).map_err(|error| error.to_string())
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
