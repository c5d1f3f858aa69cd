//! `ptm-conform export`

use std::path::PathBuf;

use clap::Args;

use super::{Outcome, files, output};
use ptm_conform::tools::anatomy::Anatomy;
use ptm_conform::tools::export;

/// Write the values of a map as OpenEXR, NPY or PNG, by the name of the output.
///
/// .exr has the final coefficients, (raw - bias) * scale, as named float channels (a0 … a5, R, G, B; of RGB maps red.a0 …
/// blue.a5; of LUM maps Cr, Cb). .npy has the stored bytes as an array of height x width x channels, or with --final the
/// final coefficients as 32-bit floats. .png has the stored planes below each other, in the order of the text. Top row
/// first in all of them.
///
/// Exit status: 0, 65 if the file is malformed, 69 if it is not read, 2 wrong usage.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform export coin.ptm -o coin.exr\n  ptm-conform export coin.ptm --final -o coin.npy\n  ptm-conform export coin.ptm -o planes.png"
)]
pub struct ExportArgs {
    /// A PTM file.
    file: PathBuf,
    /// Where to write: .exr, .npy or .png.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Final coefficients in NPY, too, instead of stored bytes.
    #[arg(long = "final")]
    final_values: bool,
}

pub fn run(args: &ExportArgs) -> Outcome {
    let extension = args
        .output
        .extension()
        .map(|extension| extension.to_string_lossy().to_lowercase());
    let extension = extension.as_deref().unwrap_or("");
    if !["exr", "npy", "png"].contains(&extension) {
        return Err(format!(
            "{}: expected a name that ends in .exr, .npy or .png",
            args.output.display()
        ));
    }
    if args.final_values && extension == "png" {
        return Err("final coefficients are real numbers, which PNG cannot hold; name the output .exr or .npy".to_owned());
    }
    let file = files::read(&args.file)?;
    let anatomy = Anatomy::of(&file);
    let ptm = match files::map(&args.file, &anatomy) {
        Ok(ptm) => ptm,
        Err(status) => return Ok(status),
    };
    let channels = ptm.planes.shape.channels();
    let (bytes, what) = match (extension, args.final_values) {
        ("exr", _) => (
            export::exr(ptm)?,
            format!("final coefficients in {channels} float channels"),
        ),
        ("npy", true) => (
            export::npy_final(ptm),
            "final coefficients, 32-bit floats".to_owned(),
        ),
        ("npy", false) => (export::npy_stored(ptm), "stored bytes".to_owned()),
        _ => {
            let description = format!(
                "{}: {channels} stored planes below each other",
                ptm.header.format
            );
            (
                export::stacked(ptm).to_png(&description)?,
                format!("{channels} stored planes below each other"),
            )
        }
    };
    files::write_whole(&args.output, bytes)?;
    output::note(&format!(
        "{}: {what}, {} texels\n",
        args.output.display(),
        ptm.header.size
    ));
    Ok(0)
}
