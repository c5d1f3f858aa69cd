//! Subcommand `ptm-conform export`.

use std::path::PathBuf;

use clap::Args;
use image::ImageFormat;

use super::{CommandResult, files, output};
use ptm_files::{export, render::encode_image};

/// Export the values of a map as OpenEXR, NPY or PNG. The suffix of the output file selects the format.
///
/// .exr contains the final coefficients, (raw - bias) * scale, as named float channels (a0 … a5, R, G, B; for RGB maps red.a0 …
/// blue.a5; for LUM maps Cr, Cb). OpenEXR stores channels in alphabetical order (B, G, R, a0 …), so read them by name. Colors range
/// from 0 to 255, so image viewers show white; --normalize divides all values by 255. .npy contains the stored bytes as an array of height x width x channels or, with
/// --final, the final coefficients as 32-bit floats. .png contains the stored planes stacked vertically, in specification order. The
/// top row is always first.
///
/// Exit status: 0 success, 2 usage error, 65 the file is malformed, 69 it is not supported.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform export coin.ptm -o coin.exr\n  ptm-conform export coin.ptm --final -o coin.npy\n  ptm-conform export coin.ptm -o planes.png"
)]
pub struct ExportArgs {
    /// A PTM file.
    file: PathBuf,
    /// The output file: .exr, .npy or .png.
    #[arg(short, long = "out", alias = "output", value_name = "FILE")]
    output: PathBuf,
    /// Write final coefficients instead of stored bytes (NPY).
    #[arg(long = "final")]
    final_values: bool,
    /// Divide final coefficients by 255, so that 1 is white (EXR, and NPY with --final). Polynomials and colors then give images from 0
    /// to 1: L * rgb instead of L * rgb / 255. Divide the last column of the matrix of LUM by 255, too.
    #[arg(long)]
    normalize: bool,
}

pub fn run(args: &ExportArgs) -> CommandResult {
    let suffix = args.output.extension().unwrap_or_default();
    let suffix = suffix.to_string_lossy().to_lowercase();
    if !["exr", "npy", "png"].contains(&&*suffix) {
        let expected = "expected a name that ends in .exr, .npy or .png";
        return Err(files::with_path(&args.output)(expected).into());
    }
    if args.final_values && suffix == "png" {
        return Err("final coefficients are real numbers, which PNG cannot store; use an output file with the suffix .exr or .npy".to_owned().into());
    }
    let is_final = suffix == "exr" || args.final_values;
    if args.normalize && !is_final {
        return Err(
            "only final coefficients can be normalized; use .exr, or .npy with --final"
                .to_owned()
                .into(),
        );
    }
    let divisor = if args.normalize { 255.0 } else { 1.0 };
    let ptm = files::read_map(&args.file)?;
    let (size, samples) = (ptm.planes.size, &ptm.planes.samples);
    let channels = ptm.planes.shape.channels();
    let (bytes, content) = match (&*suffix, args.final_values) {
        ("exr", _) => {
            let content = format!("final coefficients in {channels} float channels");
            (export::exr(&ptm, divisor)?, content)
        }
        ("npy", true) => {
            let content = "final coefficients, 32-bit floats".to_owned();
            let values = export::divide(&ptm.coefficients().values, divisor);
            (export::npy_floats(&values, size, channels), content)
        }
        ("npy", false) => {
            let bytes = export::npy_bytes(samples, size, channels);
            (bytes, "stored bytes".to_owned())
        }
        _ => {
            let planes = export::stacked_planes(samples, size, channels);
            let content = format!("{channels} stored planes, stacked vertically");
            (encode_image(&planes.into(), ImageFormat::Png)?, content)
        }
    };
    files::write_atomically(&args.output, bytes)?;
    let (output, size) = (args.output.display(), ptm.header.size);
    output::print_note(&format!("{output}: {content}, {size} texels\n"));
    Ok(0)
}
