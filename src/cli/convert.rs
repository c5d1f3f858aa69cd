//! Subcommand `ptm-conform convert`.

use std::collections::HashSet;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::collection::{WalkItem, is_ptm_in_folder, named_sources, relative_to_named, walk};
use super::{CommandError, CommandResult, files, output, readers};
use ptm::{Format, decode};
use ptm_files::convert::{Target, convert};
use ptm_files::lint::{csv::join_cells, names::escape_name, status::is_named_ptm};
use ptm_files::{convert_for::convert_for, dissection::Dissection, repair::repair};
use ptm_suite::kit::digest::sha256;

/// Convert a map to another format, without loss unless a lossy format is requested.
///
/// RGB and LRGB are converted to each other if every texel can be represented exactly. LRGB can become a table if it has at most
/// 65,536 distinct texels. Every format except LUM has a lossless JPEGLS and a lossy JPEG counterpart. The result is read back
/// and compared before it is written. Conversion to the file's own format normalizes its header; without --quality and --loss, a
/// compressed file keeps its streams.
///
/// With --repair and --out-dir, many files are repaired at once, and a CSV row on standard output says what happened to each. The
/// payload of a compressed file is kept; only its header is written again.
///
/// Exit status: 0 success, 1 the target cannot hold the map or a file cannot be repaired, 2 usage error, 65 the file is malformed,
/// 69 it is not supported.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform convert coin.ptm --to JPEGLS_RGB -o small.ptm\n  ptm-conform convert coin.ptm --to JPEG_RGB --quality 90 -o smaller.ptm\n  ptm-conform convert table.ptm --to LRGB -o plain.ptm\n  ptm-conform convert coin.ptm --for relight,rtiviewer -o everywhere.ptm\n  ptm-conform convert damaged.ptm --repair -o repaired.ptm\n  ptm-conform convert --repair --dry-run --out-dir repaired -r /archive > log.csv"
)]
#[expect(clippy::struct_excessive_bools, reason = "each is a separate option")]
pub struct ConvertArgs {
    /// A PTM file; with --out-dir, any number of files and folders, or - for a list on standard input, one path per line.
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// With --out-dir, also repair the files in subfolders.
    #[arg(short, long, requires = "out_dir")]
    recursive: bool,
    /// Paths in the list end with a zero byte instead of a line feed.
    #[arg(short = '0', long, requires = "out_dir")]
    null: bool,
    /// The target format: RGB, LUM, LRGB, PTM_LUT, PTM_C_LUT, JPEG_RGB, JPEG_LRGB, JPEGLS_RGB or JPEGLS_LRGB.
    #[arg(long, value_name = "FORMAT", value_parser = super::arguments::parse_format, required_unless_present_any = ["readers", "repair"])]
    to: Option<Format>,
    /// Convert without loss to a format and a header spelling that these readers display correctly, or explain why this is
    /// impossible.
    #[arg(long = "for", value_name = "READER,…", value_delimiter = ',', conflicts_with_all = ["to", "quality", "loss"])]
    readers: Vec<String>,
    /// Repair faults that have only one possible correction: blanks and line ends in the header, trailing bytes, compressed sizes
    /// that the streams determine, and overridden records. The changes are listed. The output file must not exist.
    #[arg(long, conflicts_with_all = ["to", "readers", "quality", "loss"])]
    repair: bool,
    /// The quality of JPEG formats, from 20 to 100.
    #[arg(long, value_name = "Q", value_parser = clap::value_parser!(u8).range(20..=100))]
    quality: Option<u8>,
    /// The maximum loss of JPEGLS formats; 0 is lossless.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=127))]
    loss: u8,
    /// The output file.
    #[arg(
        short,
        long = "out",
        alias = "output",
        value_name = "FILE",
        required_unless_present = "out_dir"
    )]
    output: Option<PathBuf>,
    /// Write repaired files to DIR, which is created if necessary, under the names of the originals; files in folders keep their
    /// path within the folder. No file is overwritten.
    #[arg(
        long,
        value_name = "DIR",
        requires = "repair",
        conflicts_with = "output"
    )]
    out_dir: Option<PathBuf>,
    /// With --out-dir, write no file, and print what would be done.
    #[arg(long, requires = "out_dir")]
    dry_run: bool,
}

pub fn run(args: &ConvertArgs) -> CommandResult {
    if let Some(directory) = &args.out_dir {
        return repair_files(args, directory);
    }
    let (Some(output), [file]) = (&args.output, &args.files[..]) else {
        return Err("expected one file; --repair --out-dir DIR repairs many"
            .to_owned()
            .into());
    };
    let source = file.canonicalize().ok();
    if source.is_some() && source == output.canonicalize().ok() {
        let output = output.display();
        return Err(format!("{output} is the input file; write to a different file").into());
    }
    match args.repair {
        true => repair_file(file, output),
        false => convert_file(args, file, output),
    }
}

fn convert_file(args: &ConvertArgs, file: &Path, output: &Path) -> CommandResult {
    let target = args.to.map(|format| Target {
        format,
        quality: args.quality,
        loss: args.loss,
    });
    let profiles = readers::load_profiles(None)?;
    let readers = readers::select_profiles(&profiles, &args.readers)?;
    let path = file;
    let file = files::read(path)?;
    let dissection = Dissection::parse(&file);
    let ptm = files::map(path, &dissection)?;
    let encoded = target.filter(|target| !target.keeps_streams(ptm.header.format));
    let checked = encoded.map_or(Ok(()), Target::check);
    checked.map_err(|why| format!("--{why}"))?;
    let converted = match target {
        Some(target) => convert(&dissection, ptm, target).map(|made| (target.format, made)),
        None => convert_for(&dissection, ptm, &readers),
    };
    let (format, converted) = converted.map_err(|why| CommandError::new(1, &why.to_string()))?;
    files::write_atomically(output, &converted.bytes)?;
    let (output, source) = (output.display(), ptm.header.format);
    let (before, after) = (file.len(), converted.bytes.len());
    let mut losses = match converted.max_difference {
        0 => "without loss".to_owned(),
        most => format!("stored values differ by at most {most}"),
    };
    if let Some(entries) = converted.entries {
        losses = format!("{losses}, {entries} table entries");
    }
    output::print_note(&format!(
        "{output}: {source} -> {format}, {before} -> {after} bytes, {losses}\n"
    ));
    Ok(0)
}

/// Writes a repaired file. Never replaces an existing file.
fn repair_file(file: &Path, output: &Path) -> CommandResult {
    check_new(output)?;
    let unrepaired = |why: ptm_files::Error| CommandError::new(1, &files::with_path(file)(why));
    let repaired = repair(&files::read(file)?).map_err(unrepaired)?;
    files::write_atomically(output, &repaired.bytes)?;
    for change in &repaired.changes {
        output::print_note(&format!("{}: {change}\n", output.display()));
    }
    Ok(0)
}

fn check_new(output: &Path) -> Result<(), String> {
    match output.symlink_metadata() {
        Ok(_) => {
            let output = output.display();
            Err(format!(
                "{output} already exists; --repair never overwrites a file"
            ))
        }
        Err(_) => Ok(()),
    }
}

/// Repairs many files, and prints a CSV row for each.
fn repair_files(args: &ConvertArgs, directory: &Path) -> CommandResult {
    if !args.dry_run {
        std::fs::create_dir_all(directory).map_err(files::with_path(directory))?;
    }
    let row = |cells: [&str; 6]| {
        let cells = cells.into_iter().map(str::to_owned);
        let row = join_cells(cells);
        output::check_written(std::io::stdout().write_all(row.as_bytes()))
    };
    row([
        "file",
        "result",
        "output",
        "sha256",
        "sha256 of output",
        "details",
    ])?;
    let bar = output::bar(None, "{pos} files");
    let mut status = 0;
    let mut written = HashSet::new();
    for item in walk(named_sources(&args.files, args.null), args.recursive) {
        let file = item.path();
        let read = match &item {
            WalkItem::Found(path) if !is_ptm_in_folder(path) => continue,
            WalkItem::Skipped(path, _) if !is_named_ptm(&path.to_string_lossy()) => continue,
            WalkItem::File(path) | WalkItem::Found(path) => files::read(path),
            WalkItem::Skipped(path, why) => Err(files::with_path(path)(why)),
            WalkItem::Unreadable(path, error) => Err(files::with_path(path)(error)),
        };
        let name = escape_name(file.as_os_str());
        let within = relative_to_named(&args.files, file);
        let output =
            directory.join(within.unwrap_or(file.file_name().unwrap_or_default().as_ref()));
        let before = read.as_ref().map_or(String::new(), |bytes| sha256(bytes));
        let repaired = match &read {
            Err(why) => Err(("unreadable", why.clone())),
            Ok(bytes) => repair(bytes).map_err(|why| match decode(bytes) {
                Ok(_) => ("sound", String::new()),
                Err(_) => ("not repairable", why.to_string()),
            }),
        };
        let done = repaired.and_then(|repaired| {
            let is_new = written.insert(output.clone()) && check_new(&output).is_ok();
            if !is_new {
                return Err((
                    "not written",
                    "a file of this name already exists".to_owned(),
                ));
            }
            if !args.dry_run {
                let folder = output.parent().unwrap_or(directory);
                let made = std::fs::create_dir_all(folder).map_err(files::with_path(folder));
                let done = made.and_then(|()| files::write_atomically(&output, &repaired.bytes));
                done.map_err(|why| ("not written", why))?;
            }
            Ok(repaired)
        });
        bar.suspend(|| match done {
            Ok(repaired) => {
                let result = if args.dry_run {
                    "repairable"
                } else {
                    "repaired"
                };
                let output = escape_name(output.as_os_str());
                let (after, changes) = (sha256(&repaired.bytes), repaired.changes.join("; "));
                row([&name, result, &output, &before, &after, &changes])
            }
            Err((result, why)) => {
                status = status.max(u8::from(result != "sound"));
                row([&name, result, "", &before, "", &why])
            }
        })?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(status)
}
