//! Photographs of one object, and the `.lp` file that lists them with their lights.

use std::fs;
use std::path::Path;

use image::ImageFormat;
use serde::{Deserialize, Serialize};

use crate::ptm::{Format, Size};
use crate::tools::render::{rgb, to_file};

/// The formats that fitters are asked for.
pub const FORMATS: [Format; 2] = [Format::Lrgb, Format::Rgb];

/// A request to a fitter, in JSON.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitRequest {
    /// The name in 2.2: that of RGB or of LRGB.
    pub format: String,
    /// Number of texels in a row, and of pixels.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// The path of the `.lp` file, which names files in the same directory.
    pub lp: String,
}

/// A photograph and its light.
#[derive(Clone, Debug, PartialEq)]
pub struct Photograph {
    /// Its name in the `.lp` file.
    pub name: String,
    /// The vector to the light as it is listed, of any length: right, up, towards the camera.
    pub light: [f64; 3],
    /// Red, green and blue of each pixel, top row first.
    pub pixels: Vec<u8>,
}

/// Photographs of one object, in the order of their `.lp` file.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureSet {
    /// The size of every photograph.
    pub size: Size,
    /// One for each light.
    pub photographs: Vec<Photograph>,
}

impl FitRequest {
    /// Reads the JSON of a request.
    ///
    /// # Errors
    /// A sentence that names the error.
    pub fn read(json: &[u8]) -> Result<(Format, FitRequest), String> {
        let request: FitRequest =
            serde_json::from_slice(json).map_err(|error| format!("the request: {error}"))?;
        Ok((request.format.parse()?, request))
    }
}

impl Photograph {
    /// Returns `lu` and `lv`: the normalized vector to the light, projected (clause 1.0/2).
    #[must_use]
    pub fn direction(&self) -> [f64; 2] {
        let [x, y, z] = self.light;
        let length = (x * x + y * y + z * z).sqrt();
        [x / length, y / length]
    }

    /// Returns a PNG file.
    ///
    /// # Panics
    /// Never for photographs of a set.
    #[must_use]
    pub fn png(&self, size: Size) -> Vec<u8> {
        let image = rgb(size, self.pixels.clone());
        to_file(image, ImageFormat::Png).expect("a small picture")
    }
}

impl PictureSet {
    /// Returns the `.lp` file.
    #[must_use]
    pub fn lp(&self) -> String {
        let line = |of: &Photograph| {
            let [x, y, z] = of.light;
            format!("{} {x} {y} {z}\n", of.name)
        };
        let lines: String = self.photographs.iter().map(line).collect();
        format!("{}\n{lines}", self.photographs.len())
    }

    /// Reads an `.lp` file and the images that it lists.
    ///
    /// # Errors
    /// A sentence that names the file or line and the error.
    pub fn read(path: &Path) -> Result<PictureSet, String> {
        let at = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let text = fs::read_to_string(path).map_err(|error| at(&error))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut lines = text.lines().filter(|line| !line.trim().is_empty());
        let count: usize = lines
            .next()
            .and_then(|line| line.trim().parse().ok())
            .ok_or_else(|| at(&"its first line is not the number of images"))?;
        let mut size = None;
        let photographs: Vec<Photograph> = lines
            .map(|line| photograph(line, folder, &mut size))
            .collect::<Result<_, _>>()
            .map_err(|error| at(&error))?;
        match size {
            Some(size) if photographs.len() == count => Ok(PictureSet { size, photographs }),
            _ => Err(at(&format!(
                "its first line announces {count} images, but it lists {}",
                photographs.len()
            ))),
        }
    }
}

/// Reads the photograph of a line: a name, which may have spaces, and three numbers. All must have the same size.
fn photograph(line: &str, folder: &Path, size: &mut Option<Size>) -> Result<Photograph, String> {
    let wrong = || format!("expected a name and three numbers, found {line:?}");
    let mut words = line.trim().rsplitn(4, char::is_whitespace);
    let mut light = [0.0; 3];
    for number in light.iter_mut().rev() {
        let parsed = words.next().and_then(|word| word.parse().ok());
        *number = parsed.filter(|n: &f64| n.is_finite()).ok_or_else(wrong)?;
    }
    if light == [0.0; 3] {
        return Err(format!("{line:?}: a light has a direction"));
    }
    let name = words.next().ok_or_else(wrong)?.trim();
    let named = |error: &dyn std::fmt::Display| format!("{name}: {error}");
    let bytes = fs::read(folder.join(name)).map_err(|error| named(&error))?;
    let picture = image::load_from_memory(&bytes).map_err(|error| named(&error))?;
    let found = Size {
        width: picture.width(),
        height: picture.height(),
    };
    if *size.get_or_insert(found) != found {
        return Err(named(&"its size differs from the size of the first image"));
    }
    Ok(Photograph {
        name: name.to_owned(),
        light,
        pixels: picture.into_rgb8().into_raw(),
    })
}
