//! Subcommand `ptm-conform convert`.

use std::path::PathBuf;

use clap::Args;

use super::{CommandError, CommandResult, files, output, readers};
use ptm::Format;
use ptm_files::convert::{Target, convert};
use ptm_files::{convert_for::convert_for, dissection::Dissection, repair::repair};

/// Convert a map to another format, without loss unless a lossy format is requested.
///
/// RGB and LRGB are converted to each other if every texel can be represented exactly. LRGB can become a table if it has at most
/// 65,536 distinct texels. Every format except LUM has a lossless JPEGLS and a lossy JPEG counterpart. The result is read back
/// and compared before it is written. Conversion to the file's own format normalizes its header.
///
/// Exit status: 0 success, 1 the target cannot hold the map or nothing can be repaired, 2 usage error, 65 the file is malformed,
/// 69 it is not supported.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform convert coin.ptm --to JPEGLS_RGB -o small.ptm\n  ptm-conform convert coin.ptm --to JPEG_RGB --quality 90 -o smaller.ptm\n  ptm-conform convert table.ptm --to LRGB -o plain.ptm\n  ptm-conform convert coin.ptm --for relight,rtiviewer -o everywhere.ptm\n  ptm-conform convert damaged.ptm --repair -o repaired.ptm"
)]
pub struct ConvertArgs {
    /// A PTM file.
    file: PathBuf,
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
    #[arg(short, long = "out", alias = "output", value_name = "FILE")]
    output: PathBuf,
}

pub fn run(args: &ConvertArgs) -> CommandResult {
    let source = args.file.canonicalize().ok();
    if source.is_some() && source == args.output.canonicalize().ok() {
        let output = args.output.display();
        return Err(format!("{output} is the input file; write to a different file").into());
    }
    if args.repair {
        return repair_file(args);
    }
    let target = args.to.map(|format| Target {
        format,
        quality: args.quality,
        loss: args.loss,
    });
    let checked = target.map_or(Ok(()), Target::check);
    checked.map_err(|why| format!("--{why}"))?;
    let profiles = readers::load_profiles(None)?;
    let readers = readers::select_profiles(&profiles, &args.readers)?;
    let file = files::read(&args.file)?;
    let dissection = Dissection::parse(&file);
    let ptm = files::map(&args.file, &dissection)?;
    let converted = match target {
        Some(target) => convert(&dissection, ptm, target).map(|made| (target.format, made)),
        None => convert_for(&dissection, ptm, &readers),
    };
    let (format, converted) = converted.map_err(|why| CommandError::new(1, &why.to_string()))?;
    files::write_atomically(&args.output, &converted.bytes)?;
    let (output, source) = (args.output.display(), ptm.header.format);
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
fn repair_file(args: &ConvertArgs) -> CommandResult {
    let output = args.output.display();
    if args.output.symlink_metadata().is_ok() {
        return Err(format!("{output} already exists; --repair never overwrites a file").into());
    }
    let unrepaired =
        |why: ptm_files::Error| CommandError::new(1, &files::with_path(&args.file)(why));
    let repaired = repair(&files::read(&args.file)?).map_err(unrepaired)?;
    files::write_atomically(&args.output, &repaired.bytes)?;
    for change in &repaired.changes {
        output::print_note(&format!("{output}: {change}\n"));
    }
    Ok(0)
}
