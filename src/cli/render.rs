//! Subcommand `ptm-conform render`.

use std::path::{Path, PathBuf};

use clap::Args;
use image::{DynamicImage, ImageFormat, RgbImage};

use super::arguments::parse_pair;
use super::collection::{WalkItem, walk};
use super::{CommandResult, EXIT_NOTHING_SELECTED, files, output};
use crate::relight;
use ptm_files::contact_sheet::{Cell, Notice, contact_sheet, sheet_size};
use ptm_files::lint::status::{Status, is_named_ptm};
use ptm_files::lint::{Lint, names::escape_name};
use ptm_files::render::{encode_image, normals, render_lit, sheet, thumbnail, upscale};

/// Render a map under one light or under many lights, render its normals, or render thumbnails of many maps.
///
/// A light is LU,LV, its direction projected onto the image plane: LU to the right, LV up; 0,0 is the zenith. Colors are rounded
/// to the nearest byte. The suffix of the output selects the format: .png, .ppm, .pgm (gray), .tiff, .bmp, .webp (lossless), .jpg (quality
/// 95, no chroma subsampling), or .html: a page with a movable light, which needs nothing but a browser.
///
/// With --sheet, several files or a folder become a contact sheet: a thumbnail of each map, lit from the upper left, with the name of
/// its file, sorted by path. Instead of a thumbnail, a file that `lint` does not find sound has a red cell with its status and the
/// code of its first error. Of folders and their subfolders, the files named .ptm are shown.
///
/// Exit status: 0 success, 2 usage error or a file cannot be read, 5 there is no file, 65 the file is malformed, 69 it is not
/// supported.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform render coin.ptm -o coin.html\n  ptm-conform render coin.ptm --light 0.5,0.5 -o coin.png\n  ptm-conform render coin.ptm --sheet 7 --cell 200 -o sheet.png\n  ptm-conform render coins/ --sheet 8 --cell 160 -o coins.png\n  ptm-conform render coin.ptm --normals -o normals.png\n  ptm-conform render tiny.ptm --zoom 32 -o tiny.png"
)]
pub struct RenderArgs {
    /// A PTM file; with --sheet, any number of files and folders.
    #[arg(value_name = "PATH", required = true)]
    files: Vec<PathBuf>,
    /// Render under this light.
    #[arg(long, value_name = "LU,LV", value_parser = parse_light, allow_hyphen_values = true, default_value = "0,0")]
    light: (f64, f64),
    /// Render a sheet of N x N images (default 5): one map with lights from the whole hemisphere, or one image of each of many
    /// maps. If the maps need several sheets, these are numbered: sheet-1.png, sheet-2.png and so on.
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "5", conflicts_with_all = ["light", "normals"], value_parser = parse_sheet)]
    sheet: Option<u8>,
    /// The longer side of an image on the sheet; larger maps are scaled down.
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

/// Maximum size of a file on a contact sheet.
const MAX_FILE_BYTES: u64 = 1 << 30;

pub fn run(args: &RenderArgs) -> CommandResult {
    let file = match &args.files[..] {
        [file] if !file.is_dir() => file,
        _ => return write_contact_sheets(args),
    };
    if args
        .output
        .extension()
        .is_some_and(|suffix| suffix == "html")
    {
        return write_page(args, file);
    }
    let format = image_format(&args.output)?;
    let ptm = files::read_map(file)?;
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
    files::write_atomically(
        &args.output,
        encode_image(&colored(image, &args.output), format)?,
    )?;
    output::print_note(&format!(
        "{output}: {content}, {width} x {height} pixels{hint}\n"
    ));
    Ok(0)
}

/// Returns the image, in gray if the output is a PGM file.
fn colored(image: RgbImage, output: &Path) -> DynamicImage {
    let is_gray = output
        .extension()
        .is_some_and(|suffix| suffix.eq_ignore_ascii_case("pgm"));
    match is_gray {
        true => DynamicImage::from(image).to_luma8().into(),
        false => image.into(),
    }
}

/// Returns the format that the suffix of the output selects.
fn image_format(output: &Path) -> Result<ImageFormat, String> {
    let format = ImageFormat::from_path(output).ok();
    format.filter(ImageFormat::writing_enabled).ok_or_else(|| {
        let expected =
            "expected a name that ends in .png, .ppm, .pgm, .tiff, .bmp, .webp, .jpg or .html";
        files::with_path(output)(expected)
    })
}

/// Writes contact sheets of many maps. Memory holds the paths, one map and one sheet.
fn write_contact_sheets(args: &RenderArgs) -> CommandResult {
    let Some(side) = args.sheet else {
        return Err("several maps or a folder need --sheet".to_owned().into());
    };
    if args
        .output
        .extension()
        .is_some_and(|suffix| suffix == "html")
    {
        let hint = "`ptm-conform lint --format html` makes a page of many maps";
        return Err(format!("a contact sheet is an image; {hint}").into());
    }
    let format = image_format(&args.output)?;
    let mut status = 0;
    let mut paths = Vec::new();
    for item in walk(args.files.iter().map(|path| (path.clone(), false)), true) {
        match item {
            WalkItem::Found(path) if !is_named_ptm(&path.to_string_lossy()) => {}
            WalkItem::File(path) | WalkItem::Found(path) => paths.push(path),
            WalkItem::Skipped(..) => {}
            WalkItem::Unreadable(path, error) => {
                output::print_error(&files::with_path(&path)(error));
                status = 2;
            }
        }
    }
    paths.sort();
    if paths.is_empty() {
        output::print_error("ptm-conform: no file is named .ptm");
        return Ok(status.max(EXIT_NOTHING_SELECTED));
    }
    let (side, pixels) = (u32::from(side), u32::from(args.cell));
    let sheets: Vec<&[PathBuf]> = paths.chunks((side * side) as usize).collect();
    sheet_size(sheets[0].len() as u32, side, pixels)?;
    let bar = output::bar(Some(paths.len() as u64), "{pos}/{len} files, {eta} left");
    let mut empty = 0;
    for (number, sheet) in (1..).zip(&sheets) {
        let cells: Vec<Cell> = sheet
            .iter()
            .map(|path| {
                bar.inc(1);
                let name = escape_name(path.file_name().unwrap_or_default());
                let content = match read_limited(path) {
                    Ok(file) => thumbnail_of(path, &file, pixels),
                    Err(error) => {
                        bar.suspend(|| output::print_error(&error));
                        status = 2;
                        Err(Notice {
                            lines: vec![Status::Unreadable.label().to_owned()],
                            is_alarm: true,
                        })
                    }
                };
                empty += usize::from(content.is_err());
                Cell { name, content }
            })
            .collect();
        let image = contact_sheet(&cells, side, pixels)?;
        let path = match sheets.len() {
            1 => args.output.clone(),
            count => numbered(&args.output, number, count),
        };
        files::write_atomically(&path, encode_image(&colored(image, &path), format)?)?;
        let (path, count) = (path.display(), cells.len());
        let plural = if count == 1 { "" } else { "s" };
        bar.suspend(|| output::print_note(&format!("{path}: {count} file{plural}\n")));
    }
    bar.finish_and_clear();
    if empty > 0 {
        let all = paths.len();
        output::print_note(&format!(
            "{empty} of {all} files have no thumbnail; `ptm-conform lint` says why\n"
        ));
    }
    Ok(status)
}

/// Reads a file of a contact sheet.
fn read_limited(path: &Path) -> Result<Vec<u8>, String> {
    let length = path.metadata().map_err(files::with_path(path))?.len();
    match length > MAX_FILE_BYTES {
        true => Err(files::with_path(path)("larger than 1 GiB")),
        false => files::read(path),
    }
}

/// Returns the thumbnail of a file, or a notice that says why there is none.
fn thumbnail_of(path: &Path, file: &[u8], side: u32) -> Result<RgbImage, Notice> {
    let lint = Lint::new(&path.to_string_lossy(), file);
    if lint.status == Status::Sound
        && let Ok(ptm) = ptm::decode(file)
    {
        return Ok(thumbnail(&ptm, side));
    }
    let code = lint.findings.first().map(|finding| finding.code.to_owned());
    let mut lines = vec![lint.status.label().to_owned()];
    // The reason of a file that breaks no rule is more useful than the code of a warning.
    lines.extend(lint.reason.or(code));
    let is_alarm = !matches!(lint.status, Status::Foreign | Status::NotJudged);
    Err(Notice { lines, is_alarm })
}

/// Returns the path of one of several sheets: sheet-07.png of 12.
fn numbered(output: &Path, number: usize, count: usize) -> PathBuf {
    let digits = count.to_string().len();
    let mut name = output.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{number:0digits$}."));
    name.push(output.extension().unwrap_or_default());
    output.with_file_name(name)
}

/// Writes a page on which the map can be relit.
fn write_page(args: &RenderArgs, file: &Path) -> CommandResult {
    if args.sheet.is_some() || args.normals || args.zoom > 1 {
        return Err(
            "a page shows the map under any light; it has no --sheet, --normals or --zoom"
                .to_owned()
                .into(),
        );
    }
    let ptm = files::read_map(file)?;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let page = relight::page(&ptm, &name)?;
    files::write_atomically(&args.output, &page)?;
    let (output, bytes) = (args.output.display(), page.len());
    output::print_note(&format!(
        "{output}: a page with a movable light, {bytes} bytes\n"
    ));
    Ok(0)
}

/// Parses the number of images in a row of a sheet.
fn parse_sheet(text: &str) -> Result<u8, String> {
    let number = text.parse().ok().filter(|number| (1..=25).contains(number));
    number
        .ok_or_else(|| "expected a number from 1 to 25; write the paths before --sheet".to_owned())
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
