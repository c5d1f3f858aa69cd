//! `ptm-conform convert`

use std::path::PathBuf;

use clap::Args;

use super::{Outcome, files, output};
use ptm_conform::ptm::Format;
use ptm_conform::tools::anatomy::Anatomy;
use ptm_conform::tools::convert::{Target, convert};

/// Write the same map in another format, exactly or not at all.
///
/// RGB and LRGB become each other where every texel can be told exactly; LRGB becomes a table of at most 65,536 distinct
/// texels; every format becomes its JPEGLS kind without a loss, and its JPEG kind with the loss that --quality allows.
/// The result is read back and compared before it is written. Into its own format a file is written anew, plainly.
///
/// Exit status: 0, 1 if the target cannot hold the map, 65 if the file is malformed, 69 if it is not read, 2 wrong usage.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform convert coin.ptm --to JPEGLS_RGB -o small.ptm\n  ptm-conform convert coin.ptm --to JPEG_RGB --quality 90 -o smaller.ptm\n  ptm-conform convert table.ptm --to LRGB -o plain.ptm"
)]
pub struct ConvertArgs {
    /// A PTM file.
    file: PathBuf,
    /// RGB, LUM, LRGB, PTM_LUT, PTM_C_LUT, JPEG_RGB, JPEG_LRGB, JPEGLS_RGB or JPEGLS_LRGB.
    #[arg(long, value_name = "FORMAT", value_parser = parse_format)]
    to: Format,
    /// The quality of JPEG formats, from 20 to 100.
    #[arg(long, value_name = "Q", value_parser = clap::value_parser!(u8).range(20..=100))]
    quality: Option<u8>,
    /// The largest loss of JPEGLS formats; 0 is exact.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=127))]
    loss: u8,
    /// Where to write the file.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

pub fn run(args: &ConvertArgs) -> Outcome {
    let target = Target {
        format: args.to,
        quality: args.quality,
        loss: args.loss,
    };
    target.check().map_err(|why| format!("--{why}"))?;
    let file = files::read(&args.file)?;
    let anatomy = Anatomy::of(&file);
    let ptm = match files::map(&args.file, &anatomy) {
        Ok(ptm) => ptm,
        Err(status) => return Ok(status),
    };
    let converted = match convert(&anatomy, ptm, target) {
        Ok(converted) => converted,
        Err(why) => {
            super::output::complain(&format!("ptm-conform: {why}"));
            return Ok(1);
        }
    };
    files::write_whole(&args.output, &converted.bytes)?;
    let loss = match converted.largest {
        0 => "without a loss".to_owned(),
        most => format!("stored values off by {most} at most"),
    };
    let entries = converted
        .entries
        .map(|entries| format!(", {entries} table entries"))
        .unwrap_or_default();
    output::note(&format!(
        "{}: {} -> {}, {} -> {} bytes, {loss}{entries}\n",
        args.output.display(),
        ptm.header.format,
        args.to,
        file.len(),
        converted.bytes.len()
    ));
    Ok(0)
}

fn parse_format(text: &str) -> Result<Format, String> {
    text.to_uppercase().parse::<Format>().map_err(|_| {
        let names: Vec<&str> = Format::ALL
            .iter()
            .map(|format| format.short_name())
            .collect();
        format!("formats are {}", names.join(", "))
    })
}
