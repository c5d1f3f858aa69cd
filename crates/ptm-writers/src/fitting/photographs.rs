//! Photographs of an object, and the `.lp` file that lists them with their lights.

use std::collections::BTreeSet;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::codecs::tga::TgaEncoder;
use image::{ExtendedColorType, ImageError, ImageFormat, ImageReader, RgbImage};
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

/// File format in which photographs are sent to a fitter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// PNG.
    #[default]
    Png,
    /// Binary PPM (P6).
    Ppm,
    /// TGA.
    Tga,
    /// JPEG of quality 95 without chroma subsampling.
    Jpeg,
}

impl Encoding {
    /// Names of all encodings, in the order of the enum.
    pub const NAMES: [&str; 4] = ["png", "ppm", "tga", "jpeg"];

    /// Finds an encoding by its name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Encoding> {
        let all = [Encoding::Png, Encoding::Ppm, Encoding::Tga, Encoding::Jpeg];
        let place = Encoding::NAMES.iter().position(|&known| known == name)?;
        Some(all[place])
    }

    const fn image_format(self) -> ImageFormat {
        match self {
            Encoding::Png => ImageFormat::Png,
            Encoding::Ppm => ImageFormat::Pnm,
            Encoding::Tga => ImageFormat::Tga,
            Encoding::Jpeg => ImageFormat::Jpeg,
        }
    }

    const fn extension(self) -> &'static str {
        match self {
            Encoding::Png => "png",
            Encoding::Ppm => "ppm",
            Encoding::Tga => "tga",
            Encoding::Jpeg => "jpg",
        }
    }

    fn encode(self, size: Size, pixels: &[u8]) -> Vec<u8> {
        if self == Encoding::Tga {
            // Uncompressed, because the run-length packets of this encoder extend over several rows, which Pillow refuses.
            let mut file = Vec::new();
            TgaEncoder::new(&mut file)
                .disable_rle()
                .encode(pixels, size.width, size.height, ExtendedColorType::Rgb8)
                .expect("the image is small");
            return file;
        }
        let image = rgb(size, pixels.to_vec()).into();
        encode_image(&image, self.image_format()).expect("the image is small")
    }
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
    /// The lossy file that the pixels were decoded from, which is sent instead of a new one.
    pub lossy_file: Option<Vec<u8>>,
}

/// Photographs of one object, in the order of their `.lp` file.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageSet {
    /// Size of every photograph.
    pub size: Size,
    /// Photographs, one per light.
    pub photographs: Vec<Photograph>,
}

/// Lower limit of [`ImageSet::rank_tolerance`]: vectors with more decimals are computed, and are less exact than their decimals.
const MIN_RANK_TOLERANCE: f64 = 1e-5;

/// Upper limit of [`ImageSet::rank_tolerance`], which lights from all directions never reach, even if they are whole numbers.
pub(super) const MAX_RANK_TOLERANCE: f64 = 3e-3;

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

    /// Returns the photograph as a file.
    ///
    /// # Panics
    /// Panics if the number of pixels does not match `size`.
    #[must_use]
    pub fn file(&self, size: Size, encoding: Encoding) -> Vec<u8> {
        match &self.lossy_file {
            Some(file) => file.clone(),
            None => encoding.encode(size, &self.pixels),
        }
    }
}

impl ImageSet {
    /// Returns the set as a fitter receives it. File names have no directory, are distinct, and end with the usual extension of the
    /// encoding. The pixels are those that a reader decodes from the files.
    ///
    /// # Panics
    /// Panics if the number of pixels of a photograph does not match the size of the set.
    #[must_use]
    pub fn encoded_as(mut self, encoding: Encoding) -> ImageSet {
        let mut taken = BTreeSet::new();
        for (k, photograph) in self.photographs.iter_mut().enumerate() {
            let last = last_component(&photograph.name);
            let stem = last.rsplit_once('.').map_or(last, |(stem, _)| stem);
            let mut name = format!("{stem}.{}", encoding.extension());
            if !taken.insert(name.clone()) {
                name = format!("{k}-{last}.{}", encoding.extension());
                taken.insert(name.clone());
            }
            photograph.name = name;
            if encoding == Encoding::Jpeg {
                let file = encoding.encode(self.size, &photograph.pixels);
                let image = decode_image(&photograph.name, &file).expect("the file is an image");
                photograph.pixels = image.into_raw();
                photograph.lossy_file = Some(file);
            }
        }
        self
    }

    /// Returns the smallest singular value of the terms of all lights that is not due to rounding, relative to the largest. It
    /// depends on the decimals of the light vectors: the terms of lights on a ring are dependent, but those of the rounded vectors
    /// are not.
    #[must_use]
    pub(super) fn rank_tolerance(&self) -> f64 {
        let lights = self.photographs.iter().map(|photograph| photograph.light);
        let decimals = |number: f64| {
            number
                .to_string()
                .rsplit_once('.')
                .map_or(0, |(_, d)| d.len())
        };
        let most = lights
            .clone()
            .flatten()
            .map(decimals)
            .max()
            .unwrap_or_default();
        let length = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z).sqrt();
        let shortest = lights.map(length).fold(f64::INFINITY, f64::min);
        let precision = 0.1_f64.powi(most.min(20) as i32) / shortest;
        precision.clamp(MIN_RANK_TOLERANCE, MAX_RANK_TOLERANCE)
    }

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

    /// Reads an `.lp` file and the images that it lists. The file may be UTF-8, UTF-16 or Latin-1.
    ///
    /// # Errors
    /// Returns a message that names the file or line and the error.
    pub fn read(path: &Path) -> Result<ImageSet, String> {
        let locate = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let text = decode_text(&fs::read(path).map_err(|error| locate(&error))?);
        let folder = path.parent().unwrap_or(Path::new(""));
        let lines = text.split(['\n', '\r']);
        let mut lines = lines.filter(|line| !line.trim().is_empty());
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
    let bytes = read_named_file(base, name).map_err(|error| with_name(&error))?;
    let image = decode_image(name, &bytes).map_err(|error| with_name(&error))?;
    let (width, height) = (image.width(), image.height());
    let actual = Size { width, height };
    if *size.get_or_insert(actual) != actual {
        let says = "the size of the image differs from that of the first image";
        return Err(with_name(&says));
    }
    Ok(Photograph {
        name: name.to_owned(),
        light,
        pixels: image.into_raw(),
        lossy_file: None,
    })
}

/// Decodes an image. TGA files are recognized by their name, because they have no signature.
fn decode_image(name: &str, bytes: &[u8]) -> Result<RgbImage, ImageError> {
    // The reader has the same type as in `protocol::image_file`, so that the image decoders are compiled only once.
    let mut cursor = Cursor::new(bytes);
    let mut reader = ImageReader::new(&mut cursor).with_guessed_format()?;
    if reader.format().is_none() && name.to_ascii_lowercase().ends_with(".tga") {
        reader.set_format(ImageFormat::Tga);
    }
    Ok(reader.decode()?.into_rgb8())
}

/// Reads an image of an `.lp` file. A file name in an older encoding is Latin-1 in `name`, so its bytes are tried as well. A path
/// of another computer is replaced by its last component.
fn read_named_file(base: &Path, name: &str) -> std::io::Result<Vec<u8>> {
    let last = last_component(name);
    let spellings = |name: &str| [Some(name.into()), latin1_path(name)];
    let names = spellings(name).into_iter().chain(spellings(last));
    let mut paths = names.flatten().map(|name| base.join(name));
    let found = paths.find(|path| path.is_file());
    fs::read(found.unwrap_or_else(|| base.join(name)))
}

/// Returns the path whose bytes are the Latin-1 characters of `name`.
#[cfg(unix)]
fn latin1_path(name: &str) -> Option<PathBuf> {
    use std::os::unix::ffi::OsStringExt;
    let bytes = name
        .chars()
        .map(|c| u8::try_from(c).ok())
        .collect::<Option<Vec<u8>>>()?;
    Some(std::ffi::OsString::from_vec(bytes).into())
}

#[cfg(not(unix))]
fn latin1_path(_: &str) -> Option<PathBuf> {
    None
}

/// Returns the part of a path after the last slash or backslash.
fn last_component(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// Decodes a text file in UTF-8 or UTF-16, with or without a byte order mark, or else in Latin-1.
fn decode_text(bytes: &[u8]) -> String {
    let utf16 = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = bytes.as_chunks::<2>().0.iter().map(|&pair| unit(pair));
        char::decode_utf16(units)
            .map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect()
    };
    match bytes {
        [0xff, 0xfe, text @ ..] => utf16(text, u16::from_le_bytes),
        [0xfe, 0xff, text @ ..] => utf16(text, u16::from_be_bytes),
        // The first character is a digit or white space.
        [1..=255, 0, ..] => utf16(bytes, u16::from_le_bytes),
        [0, 1..=255, ..] => utf16(bytes, u16::from_be_bytes),
        _ => match std::str::from_utf8(bytes) {
            Ok(text) => text.trim_start_matches('\u{feff}').to_owned(),
            Err(_) => bytes.iter().copied().map(char::from).collect(),
        },
    }
}
