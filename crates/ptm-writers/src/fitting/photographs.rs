//! Photographs of an object, and the `.lp` file that lists them with their lights.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use image::{ImageError, ImageFormat, ImageReader};
use serde::{Deserialize, Serialize};

use ptm::{Format, Size};
use ptm_files::render::{encode_image, rgb};

/// Formats that are requested from fitters.
pub const FORMATS: [Format; 2] = [Format::Lrgb, Format::Rgb];

/// Request to a fitter, in JSON.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitRequest {
    /// Name of the format (2.2): RGB or LRGB.
    pub format: String,
    /// Width of the map and of the photographs.
    pub width: u32,
    /// Height of the map and of the photographs.
    pub height: u32,
    /// Path of the `.lp` file, which refers to images in the same directory.
    pub lp: String,
}

/// Photograph and its light.
#[derive(Clone, Debug, PartialEq)]
pub struct Photograph {
    /// File name, as listed in the `.lp` file.
    pub name: String,
    /// Vector to the light, as listed in the `.lp` file. Its components point right, up, and toward the camera. Its length is
    /// arbitrary.
    pub light: [f64; 3],
    /// Red, green and blue of each pixel, top row first.
    pub pixels: Vec<u8>,
}

/// Photographs of one object, in the order of their `.lp` file.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageSet {
    /// Size of every photograph.
    pub size: Size,
    /// Photographs, one per light.
    pub photographs: Vec<Photograph>,
}

impl FitRequest {
    /// Reads the JSON of a request.
    ///
    /// # Errors
    /// Returns a message that describes the error.
    pub fn read(json: &[u8]) -> Result<(Format, FitRequest), String> {
        let request: Result<FitRequest, _> = serde_json::from_slice(json);
        let request = request.map_err(|error| format!("the request: {error}"))?;
        Ok((request.format.parse()?, request))
    }
}

impl Photograph {
    /// Returns `lu` and `lv`: the vector to the light, normalized and projected (clause 1.0/2).
    #[must_use]
    pub fn direction(&self) -> [f64; 2] {
        let [x, y, z] = self.light;
        let length = (x * x + y * y + z * z).sqrt();
        [x / length, y / length]
    }

    /// Encodes the photograph as a PNG file.
    ///
    /// # Panics
    /// Panics if the number of pixels does not match `size`.
    #[must_use]
    pub fn png(&self, size: Size) -> Vec<u8> {
        let image = rgb(size, self.pixels.clone()).into();
        encode_image(&image, ImageFormat::Png).expect("the image is small")
    }
}

impl ImageSet {
    /// Returns the text of the `.lp` file.
    #[must_use]
    pub fn lp(&self) -> String {
        let line = |photograph: &Photograph| {
            let [x, y, z] = photograph.light;
            format!("{} {x} {y} {z}\n", photograph.name)
        };
        let lines: String = self.photographs.iter().map(line).collect();
        format!("{}\n{lines}", self.photographs.len())
    }

    /// Reads an `.lp` file and the images that it lists.
    ///
    /// # Errors
    /// Returns a message that names the file or line and the error.
    pub fn read(path: &Path) -> Result<ImageSet, String> {
        let locate = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let text = fs::read_to_string(path).map_err(|error| locate(&error))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut lines = text.lines().filter(|line| !line.trim().is_empty());
        let count = lines.next().and_then(|line| line.trim().parse().ok());
        let count: usize =
            count.ok_or_else(|| locate(&"the first line is not the number of images"))?;
        let (mut size, mut photographs) = (None, Vec::new());
        for line in lines {
            let photograph = read_photograph(line, folder, &mut size);
            photographs.push(photograph.map_err(|error| locate(&error))?);
        }
        match (size, photographs.len()) {
            (Some(size), listed) if listed == count => Ok(ImageSet { size, photographs }),
            (_, listed) => Err(locate(&format!(
                "expected {count} images according to the first line, found {listed}"
            ))),
        }
    }
}

/// Reads the photograph that a line describes. The line consists of a name, possibly with spaces, and three numbers. Returns an
/// error if the size of the photograph differs from `size`.
fn read_photograph(line: &str, base: &Path, size: &mut Option<Size>) -> Result<Photograph, String> {
    let invalid = || format!("expected a name and three numbers, found {line:?}");
    let mut words = line.trim().rsplitn(4, char::is_whitespace);
    let mut light = [0.0; 3];
    for number in light.iter_mut().rev() {
        let parsed = words.next().and_then(|word| word.parse().ok());
        *number = parsed.filter(|n: &f64| n.is_finite()).ok_or_else(invalid)?;
    }
    if light == [0.0; 3] {
        return Err(format!("{line:?}: a light must have a direction"));
    }
    let name = words.next().ok_or_else(invalid)?.trim();
    let with_name = |error: &dyn std::fmt::Display| format!("{name}: {error}");
    let bytes = fs::read(base.join(name)).map_err(|error| with_name(&error))?;
    // The reader has the same type as in `protocol::image_file`, so that the image decoders are compiled only once.
    let mut cursor = Cursor::new(&*bytes);
    let reader = ImageReader::new(&mut cursor).with_guessed_format();
    let image = reader
        .map_err(ImageError::from)
        .and_then(ImageReader::decode);
    let image = image.map_err(|error| with_name(&error))?;
    let (width, height) = (image.width(), image.height());
    let actual = Size { width, height };
    if *size.get_or_insert(actual) != actual {
        let says = "the size of the image differs from that of the first image";
        return Err(with_name(&says));
    }
    let (name, pixels) = (name.to_owned(), image.into_rgb8().into_raw());
    Ok(Photograph {
        name,
        light,
        pixels,
    })
}
