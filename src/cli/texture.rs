//! Subcommands of `ptm-conform texture`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::arguments::parse_pair;
use super::files::{self, with_path, write_atomically};
use super::output::{print, print_note};
use super::{CommandError, CommandResult, EXIT_NOTHING_SELECTED};

use ptm::Size;
use ptm_files::render::{encode_image, rgb};
use ptm_suite::kit::yaml::from_yaml;
use ptm_suite::texture::cases::parse_cases;
use ptm_suite::texture::question::{GivenEntry, Question};
use ptm_suite::texture::verify::verify;
use ptm_texture::{Preview, PreviewShape, Rounding, Rules, TextureMap, preview};

/// Texture mapping: check a file of cases, or render a table entry.
#[derive(Args)]
#[command(after_help = "Example:\n  ptm-conform texture render --shape sphere -o sphere.png")]
pub struct TextureArgs {
    #[command(subcommand)]
    command: TextureCommand,
}

#[derive(Subcommand)]
enum TextureCommand {
    Cases(CasesArgs),
    Render(TextureRenderArgs),
}

/// Check that the reference gives the expected answer to every case in a file.
///
/// The file has the format of spec-cases/texture/cases: a YAML list of cases, or a document with a list of cases under "cases".
/// Numbers must agree within 1e-9 or the case's tolerance. Answers under other readings are also checked, if these readings are
/// known.
///
/// Exit status: 0 all cases hold, 1 a case does not, 2 the file cannot be read, 5 it has no cases.
#[derive(Args)]
#[command(after_help = "Example:\n  ptm-conform texture cases spec-cases/texture/cases/table.yaml")]
struct CasesArgs {
    /// A file with cases.
    file: PathBuf,
    /// Print only the cases that do not hold.
    #[arg(long)]
    quiet: bool,
}

/// Render a textured plane or sphere under a light, to show the effect of a table entry.
///
/// The map is in the middle of the shape; --around controls how much of the shape is shown around the map, to make boundary
/// conditions visible. For methods that need a reflection, the eye is in front of the shape. The lamp at --light lights the
/// surface; a PTM is rendered under --ptm-light.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform texture render -o wrap.png\n  ptm-conform texture render --shape sphere --map coin.ptm --ptm-light 0.4,0.3 -o sphere.png\n  ptm-conform texture render --map coin.ptm --entry '{boundary: [Mirror, Wrap, Wrap], composition: Modulate}' -o mirror.png"
)]
struct TextureRenderArgs {
    /// The output file, a PNG.
    #[arg(short, long = "out", alias = "output", value_name = "FILE")]
    output: PathBuf,
    /// The textured shape.
    #[arg(long, value_name = "SHAPE", default_value = "plane", value_parser = ["plane", "sphere"])]
    shape: String,
    /// A PTM as the texture map; by default a checkerboard.
    #[arg(long, value_name = "PTM")]
    map: Option<PathBuf>,
    /// The light under which the PTM is rendered.
    #[arg(long, value_name = "LU,LV", default_value = "0.3,0.4", allow_hyphen_values = true, value_parser = parse_light)]
    ptm_light: (f64, f64),
    /// The light on the surface.
    #[arg(long, value_name = "LU,LV", default_value = "-0.4,0.5", allow_hyphen_values = true, value_parser = parse_light)]
    light: (f64, f64),
    /// Fields of the table entry, in YAML. Omitted fields have their fallback values, except for two fields whose defaults make
    /// the effect visible: `parameterization: FloatData` (the shape's own coordinates) and `rendering_control: PreLight`.
    #[arg(long, value_name = "YAML", default_value = "{}")]
    entry: String,
    /// Generate mipmap levels for the map with a box filter.
    #[arg(long)]
    mipmap: bool,
    /// Width of the margin around the map, as a multiple of the map's size: the shape's coordinates run from -N to 1 + N.
    #[arg(long, value_name = "N", default_value_t = 0.5, value_parser = parse_around)]
    around: f64,
    /// The color of the surface: red, green, blue from 0 to 1.
    #[arg(long, value_name = "R,G,B", default_value = "0.85,0.75,0.6", value_parser = parse_color)]
    surface_color: [f64; 3],
    /// Width and height of the image.
    #[arg(long, value_name = "PIXELS", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=8192))]
    size: u32,
}

fn parse_around(text: &str) -> Result<f64, String> {
    let around = text.parse().ok();
    let around = around.filter(|around| (0.0..=1000.0).contains(around));
    around.ok_or_else(|| format!("expected a number from 0 to 1000, found {text:?}"))
}

fn parse_light(text: &str) -> Result<(f64, f64), String> {
    let light = parse_pair(text).filter(|(lu, lv)| lu.hypot(*lv) <= 1.0);
    light.ok_or_else(|| {
        format!("expected a light such as 0.25,-0.5 within the unit circle, found {text:?}")
    })
}

fn parse_color(text: &str) -> Result<[f64; 3], String> {
    let parts: Result<Vec<f64>, _> = text.split(',').map(str::parse).collect();
    match parts.as_deref() {
        Ok(&[r, g, b]) if [r, g, b].iter().all(|c| (0.0..=1.0).contains(c)) => Ok([r, g, b]),
        _ => Err(format!(
            "expected a color such as 0.8,0.5,0.2, found {text:?}"
        )),
    }
}

/// Runs `ptm-conform texture …`.
pub fn run(args: &TextureArgs) -> CommandResult {
    match &args.command {
        TextureCommand::Cases(args) => run_cases(args),
        TextureCommand::Render(args) => run_render(args),
    }
}

fn run_cases(args: &CasesArgs) -> CommandResult {
    let text = String::from_utf8(files::read(&args.file)?).map_err(with_path(&args.file))?;
    let cases = parse_cases(&text).map_err(with_path(&args.file))?;
    let (mut held, mut wrong, mut unknown) = (0, 0, 0);
    let mut out = String::new();
    for line in cases.iter().flat_map(verify) {
        let (word, count) = match line.agrees {
            Some(true) => ("pass", &mut held),
            Some(false) => ("FAIL", &mut wrong),
            None => ("----", &mut unknown),
        };
        *count += 1;
        if line.agrees == Some(false) || !args.quiet {
            let reading = line.reading.map(|name| format!(" under {name}"));
            let reading = reading.unwrap_or_default();
            let _ = writeln!(out, "{word} {}{reading}: {}", line.id, line.message);
        }
    }
    let aside = match unknown {
        0 => String::new(),
        _ => format!(", {unknown} under unknown readings"),
    };
    let count = cases.len();
    print(&format!(
        "{out}{count} cases: {held} correct, {wrong} wrong{aside}\n"
    ));
    Ok(match count {
        0 => EXIT_NOTHING_SELECTED,
        _ => u8::from(wrong > 0),
    })
}

/// Answers `ptm-conform reference texture FILE`.
pub fn answer(file: &Path) -> CommandResult {
    let question = Question::read(&files::read(file)?);
    let answer = question.and_then(|question| question.answer(&Rules::SPEC));
    let answer = answer.map_err(|refusal| {
        let (status, reason) = refusal.status_and_reason();
        CommandError::refused(file, status as u8, reason)
    });
    print(&format!("{}\n", answer?));
    Ok(0)
}

fn run_render(args: &TextureRenderArgs) -> CommandResult {
    let mut fields: serde_json::Value =
        from_yaml(&args.entry).map_err(|error| format!("--entry: {error}"))?;
    if let Some(fields) = fields.as_object_mut() {
        for (name, value) in [
            ("parameterization", "FloatData"),
            ("rendering_control", "PreLight"),
        ] {
            fields.entry(name).or_insert_with(|| value.into());
        }
    }
    let given: GivenEntry =
        serde_json::from_value(fields).map_err(|error| format!("--entry: {error}"))?;
    let map = match &args.map {
        None => TextureMap::checkerboard(&Rules::SPEC),
        Some(path) => {
            let ptm = ptm::decode(&files::read(path)?).map_err(with_path(path))?;
            let (lu, lv) = args.ptm_light;
            TextureMap::from_ptm(&ptm.coefficients(), lu, lv, Rounding::None, &Rules::SPEC)
        }
    };
    let scene = Preview {
        shape: match args.shape.as_str() {
            "sphere" => PreviewShape::Sphere,
            _ => PreviewShape::Plane,
        },
        map: match args.mipmap {
            true => map.with_box_levels(),
            false => map,
        },
        entry: given.entry(&Rules::SPEC),
        light: args.light,
        color: args.surface_color,
        margin: args.around,
    };
    let drawn = preview(&scene, args.size as usize, &Rules::SPEC)
        .map_err(|error| format!("cannot draw these coordinates: {error}"))?;
    let (width, height) = (args.size, args.size);
    let image = rgb(Size { width, height }, drawn).into();
    write_atomically(&args.output, encode_image(&image, image::ImageFormat::Png)?)?;
    print_note(&format!(
        "{}: {width} x {height} pixels\n",
        args.output.display()
    ));
    Ok(0)
}
