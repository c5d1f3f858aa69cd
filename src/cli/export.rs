//! `ptm-conform export`

use std::path::{Path, PathBuf};

use clap::Args;
use image::ImageFormat;

use super::{CommandResult, files, output};
use ptm_conform::tools::dissection::Dissection;
use ptm_conform::tools::export;

/// Write the values of a map as OpenEXR, NPY or PNG; the name of the output decides.
///
/// .exr has the final coefficients, (raw - bias) * scale, as named float channels (a0 … a5, R, G, B; of RGB maps red.a0 …
/// blue.a5; of LUM maps Cr, Cb). .npy has the stored bytes as an array of height x width x channels, or with --final the
/// final coefficients as 32-bit floats. .png has the stored planes below each other, in the order of the text. Top row
/// first in all of them.
///
/// Exit status: 0, 65 if the file is malformed, 69 if it is not supported, 2 usage error.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform export coin.ptm -o coin.exr\n  ptm-conform export coin.ptm --final -o coin.npy\n  ptm-conform export coin.ptm -o planes.png"
)]
pub struct ExportArgs {
    /// A PTM file.
    file: PathBuf,
    /// The path of the output: .exr, .npy or .png.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Write final coefficients instead of stored bytes (NPY).
    #[arg(long = "final")]
    final_values: bool,
}

/// The format of the output, from its file name.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ExportEncoding {
    Exr,
    Npy,
    Png,
}

impl ExportEncoding {
    fn of(path: &Path) -> Result<ExportEncoding, String> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        match extension.to_lowercase().as_str() {
            "exr" => Ok(ExportEncoding::Exr),
            "npy" => Ok(ExportEncoding::Npy),
            "png" => Ok(ExportEncoding::Png),
            _ => Err(format!(
                "{}: expected a name that ends in .exr, .npy or .png",
                path.display()
            )),
        }
    }
}

pub fn run(args: &ExportArgs) -> CommandResult {
    let encoding = ExportEncoding::of(&args.output)?;
    if args.final_values && encoding == ExportEncoding::Png {
        return Err("final coefficients are real numbers, which PNG cannot hold; name the output .exr or .npy".to_owned().into());
    }
    let file = files::read(&args.file)?;
    let dissection = Dissection::of(&file);
    let ptm = files::map(&args.file, &dissection)?;
    let channels = ptm.planes.shape.channels();
    let what = match (encoding, args.final_values) {
        (ExportEncoding::Exr, _) => format!("final coefficients in {channels} float channels"),
        (ExportEncoding::Npy, true) => "final coefficients, 32-bit floats".to_owned(),
        (ExportEncoding::Npy, false) => "stored bytes".to_owned(),
        (ExportEncoding::Png, _) => format!("{channels} stored planes below each other"),
    };
    let (size, samples) = (ptm.planes.size, &ptm.planes.samples);
    let bytes = match (encoding, args.final_values) {
        (ExportEncoding::Exr, _) => export::exr(ptm)?,
        (ExportEncoding::Npy, true) => {
            export::npy_floats(&ptm.coefficients().values, size, channels)
        }
        (ExportEncoding::Npy, false) => export::npy_bytes(samples, size, channels),
        (ExportEncoding::Png, _) => {
            export::stacked_planes(samples, size, channels).to_file(ImageFormat::Png)?
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
