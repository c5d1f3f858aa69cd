//! Subcommand `ptm-conform render`.

use std::path::PathBuf;

use clap::Args;
use image::ImageFormat;

use super::arguments::parse_pair;
use super::{CommandResult, files, output};
use crate::relight;
use ptm_files::render::{encode_image, normals, render_lit, sheet, upscale};

/// Render a map under one light or under many lights, or render its normals.
///
/// A light is LU,LV, its direction projected onto the image plane: LU to the right, LV up; 0,0 is the zenith. Colors are rounded
/// to the nearest byte. The suffix of the output selects the format: .png, .ppm, .tiff, .bmp, .webp (lossless), .jpg (quality
/// 95, no chroma subsampling), or .html: a page with a movable light, which needs nothing but a browser.
///
/// Exit status: 0 success, 2 usage error, 65 the file is malformed, 69 it is not supported.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform render coin.ptm -o coin.html\n  ptm-conform render coin.ptm --light 0.5,0.5 -o coin.png\n  ptm-conform render coin.ptm --sheet 7 --cell 200 -o sheet.png\n  ptm-conform render coin.ptm --normals -o normals.png\n  ptm-conform render tiny.ptm --zoom 32 -o tiny.png"
)]
pub struct RenderArgs {
    /// A PTM file.
    file: PathBuf,
    /// Render under this light.
    #[arg(long, value_name = "LU,LV", value_parser = parse_light, allow_hyphen_values = true, default_value = "0,0")]
    light: (f64, f64),
    /// Render a sheet of N x N images (default 5) with lights from the whole hemisphere.
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "5", conflicts_with_all = ["light", "normals"], value_parser = clap::value_parser!(u8).range(1..=25))]
    sheet: Option<u8>,
    /// The longest side of an image on the sheet; larger maps are scaled down.
    #[arg(long, value_name = "PIXELS", default_value_t = 256, requires = "sheet", value_parser = clap::value_parser!(u16).range(1..))]
    cell: u16,
    /// Render the normals as colors: the direction of the brightest light, with x, y and z from -1 to 1 mapped to 0 to 255, x to
    /// the right, y up.
    #[arg(long, conflicts_with = "light")]
    normals: bool,
    /// Show every texel as a square of N x N pixels.
    #[arg(long, value_name = "N", default_value_t = 1, conflicts_with = "sheet", value_parser = clap::value_parser!(u16).range(1..))]
    zoom: u16,
    /// The output file.
    #[arg(short, long = "out", alias = "output", value_name = "FILE")]
    output: PathBuf,
}

/// Maximum side length, in texels, of an image for which `--zoom` is suggested.
const MAX_SMALL_SIDE: u32 = 32;

pub fn run(args: &RenderArgs) -> CommandResult {
    if args
        .output
        .extension()
        .is_some_and(|suffix| suffix == "html")
    {
        return write_page(args);
    }
    let format = ImageFormat::from_path(&args.output).ok();
    let format = format.filter(ImageFormat::writing_enabled).ok_or_else(|| {
        let expected = "expected a name that ends in .png, .ppm, .tiff, .bmp, .webp, .jpg or .html";
        files::with_path(&args.output)(expected)
    })?;
    let ptm = files::read_map(&args.file)?;
    let (image, content) = match (args.sheet, args.normals, args.light) {
        (Some(side), ..) => {
            let image = sheet(&ptm, side.into(), args.cell.into())?;
            (image, format!("{side} x {side} lights"))
        }
        (None, true, _) => (normals(&ptm), "normals (x to the right, y up)".to_owned()),
        (None, false, (lu, lv)) => {
            let image = render_lit(&ptm.coefficients(), lu, lv);
            (image, format!("light {lu},{lv}"))
        }
    };
    let is_small = image.width().max(image.height()) <= MAX_SMALL_SIDE;
    let hint = match args.sheet.is_none() && args.zoom == 1 && is_small {
        true => "; --zoom 32 enlarges them",
        false => "",
    };
    let image = match args.zoom {
        1 => image,
        zoom => upscale(&image, zoom.into())?,
    };
    let (output, (width, height)) = (args.output.display(), image.dimensions());
    files::write_atomically(&args.output, encode_image(&image.into(), format)?)?;
    output::print_note(&format!(
        "{output}: {content}, {width} x {height} pixels{hint}\n"
    ));
    Ok(0)
}

/// Writes a page on which the map can be relit.
fn write_page(args: &RenderArgs) -> CommandResult {
    if args.sheet.is_some() || args.normals || args.zoom > 1 {
        return Err(
            "a page shows the map under any light; it has no --sheet, --normals or --zoom"
                .to_owned()
                .into(),
        );
    }
    let ptm = files::read_map(&args.file)?;
    let name = args.file.file_name().unwrap_or_default().to_string_lossy();
    let page = relight::page(&ptm, &name)?;
    files::write_atomically(&args.output, &page)?;
    let (output, bytes) = (args.output.display(), page.len());
    output::print_note(&format!(
        "{output}: a page with a movable light, {bytes} bytes\n"
    ));
    Ok(0)
}

/// Parses a light direction within the hemisphere.
fn parse_light(text: &str) -> Result<(f64, f64), String> {
    match parse_pair(text) {
        Some((lu, lv)) if f64::hypot(lu, lv) <= 1.0 => Ok((lu, lv)),
        Some((lu, lv)) if lu.is_finite() && lv.is_finite() => Err(format!(
            "the light {lu},{lv} is below the horizon: LU² + LV² must be at most 1"
        )),
        _ => Err(format!(
            "expected two numbers such as 0.25,-0.5, found {text:?}"
        )),
    }
}
