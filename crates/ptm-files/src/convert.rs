//! Converts a map to another format. The generator writes the result, which is then read back and compared.
//!
//! A conversion is either lossless or refused with a reason. A map is never changed to fit the target format. The exceptions are
//! JPEG, whose loss depends on the quality, and near-lossless JPEG-LS, on request. A compressed file that keeps its format also keeps
//! its streams, and gets a new header.
//!
//! Format notes
//! - In LRGB, each final color value is the product of a polynomial and a stored color, divided by 255. RGB converts to LRGB if
//!   the three polynomials of each texel are multiples of a common polynomial. LRGB converts to RGB if each product divided by
//!   255 is an integer that, plus its bias, fits in a byte.
//! - The colors of LUM depend on three open questions, so LUM is not converted to any other format.

use crate::dissection::{Dissection, Role};
use crate::error::{Error, Result};
use crate::{describe_position, join_texts};
use ptm::decode::decode;
use ptm::{Coding, Format, Ptm, Shape};
use ptm_generate::{Model, Recipe, plan::Residuals, write};

/// Target of a conversion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Target {
    /// Target format.
    pub format: Format,
    /// JPEG quality from 20 to 100; required for JPEG formats, unless the streams of the source are kept.
    pub quality: Option<u8>,
    /// Maximum error of JPEG-LS, from 0 to 127.
    pub loss: u8,
}

impl Target {
    /// Returns true if a file of format `source` keeps its streams: the target is the same compressed format, and neither quality nor
    /// loss is requested.
    #[must_use]
    pub fn keeps_streams(self, source: Format) -> bool {
        let has_no_request = self.quality.is_none() && self.loss == 0;
        self.format == source && source.coding().is_some() && has_no_request
    }

    /// Checks that quality and loss apply to the format. The error message begins with the name of the offending parameter.
    ///
    /// # Errors
    /// Returns a message for a JPEG format without a quality, another format with a quality, or a loss for any format but
    /// JPEG-LS.
    pub fn check(self) -> Result<()> {
        let format = self.format;
        let is_jpeg = format.coding() == Some(Coding::Jpeg);
        match self.quality {
            None if is_jpeg => Error::impossible(format!(
                "quality: expected 20 to 100 for the lossy format {format}; JPEGLS formats can be exact"
            )),
            Some(_) if !is_jpeg => {
                Error::impossible(format!("quality is for JPEG formats, not for {format}"))
            }
            _ if self.loss > 0 && (is_jpeg || format.coding().is_none()) => {
                Error::impossible(format!("loss is for JPEGLS formats, not for {format}"))
            }
            _ => Ok(()),
        }
    }
}

/// Converted map.
#[derive(Debug)]
pub struct ConvertedMap {
    /// Bytes of the file.
    pub bytes: Vec<u8>,
    /// Largest change to a stored value caused by compression; 0 if the conversion is lossless.
    pub max_difference: u8,
    /// Number of entries in the lookup table, if there is one.
    pub entries: Option<usize>,
}

/// Converts the file that `dissection` describes.
///
/// # Errors
/// Returns a message if the target cannot represent the map, or if the converted file differs from the map when it is read back.
pub fn convert(dissection: &Dissection, ptm: &Ptm, target: Target) -> Result<ConvertedMap> {
    match target.keeps_streams(ptm.header.format) {
        true => with_new_header(dissection, ptm),
        false => encode(dissection, ptm, target),
    }
}

/// Converts the file that `dissection` describes. Encodes the planes of a compressed target.
pub(crate) fn encode(dissection: &Dissection, ptm: &Ptm, target: Target) -> Result<ConvertedMap> {
    let source = ptm.header.format;
    let samples = samples(ptm, target.format)?;
    let recipe = recipe(dissection, ptm, target)?;
    let model = Model::new(&recipe, &samples);
    let model = model.map_err(|why| format!("{source} into {}: {why}", target.format))?;
    let bytes = write(&recipe, &model).bytes;
    Ok(ConvertedMap {
        max_difference: verify(&bytes, ptm, &samples, target)?,
        bytes,
        entries: (!model.table.is_empty()).then(|| model.entries()),
    })
}

/// Copies the streams and the side information of a compressed file, and writes its header in the spelling that every known reader
/// accepts.
fn with_new_header(dissection: &Dissection, ptm: &Ptm) -> Result<ConvertedMap> {
    let header = &ptm.header;
    let planes = dissection.compressed_planes();
    let payload = dissection.parts.iter().find(|part| part.role.is_payload());
    let start = payload.map_or(dissection.end(), |part| part.offset);
    let mut lines = vec![
        "PTM_1.2".to_owned(),
        header.format.to_string(),
        header.size.width.to_string(),
        header.size.height.to_string(),
        texts(dissection, Role::Scale, 6),
        join_texts(integer_biases(ptm), " "),
        texts(dissection, |_| Role::Parameter, 1),
    ];
    let lists: [fn(usize) -> Role; 7] = [
        Role::Transform,
        Role::MotionX,
        Role::MotionY,
        Role::Rank,
        Role::Reference,
        Role::StreamSize,
        Role::SideSize,
    ];
    lines.extend(lists.map(|role| texts(dissection, role, planes)));
    let mut bytes = (lines.join("\n") + "\n").into_bytes();
    bytes.extend(&dissection.file[start..dissection.end()]);
    let (quality, loss) = (None, 0);
    let target = Target {
        format: header.format,
        quality,
        loss,
    };
    if verify(&bytes, ptm, &ptm.planes.samples, target)? > 0 {
        return Error::impossible(format!("the copied streams have different values; {BUG}"));
    }
    Ok(ConvertedMap {
        bytes,
        max_difference: 0,
        entries: None,
    })
}

/// Returns the numbers of a list as they are written in the file.
fn texts(dissection: &Dissection, role: impl Fn(usize) -> Role, count: usize) -> String {
    join_texts((0..count).filter_map(|i| dissection.text(role(i))), " ")
}

/// Returns the biases as decimal integers.
fn integer_biases(ptm: &Ptm) -> [String; 6] {
    ptm.header.scale_bias.bias.map(|bias| format!("{bias:.0}"))
}

/// Returns the recipe of the converted file. Scales keep their spelling, biases are written as integers, and everything
/// else uses the spelling that every known reader accepts.
fn recipe(dissection: &Dissection, ptm: &Ptm, target: Target) -> Result<Recipe> {
    let mut recipe = Recipe::default_for(target.format, ptm.header.size);
    recipe.scale = texts(dissection, Role::Scale, 6).parse()?;
    recipe.bias = join_texts(integer_biases(ptm), " ").parse()?;
    if let Shape::Lum(_) = ptm.planes.shape {
        recipe.matrix = texts(dissection, Role::Matrix, 16).parse()?;
    }
    target.check()?;
    if target.format.coding().is_some() {
        recipe.compression.parameter = target.quality.unwrap_or(target.loss);
    }
    recipe.compression.residuals = Residuals::Natural;
    recipe.check()?;
    Ok(recipe)
}

/// Converts the values of the map to the planes of the target format.
fn samples(ptm: &Ptm, target: Format) -> Result<Vec<u8>> {
    let source = ptm.header.format;
    match (ptm.planes.shape, target.shape()) {
        (Shape::Rgb, Shape::Rgb) | (Shape::Lrgb, Shape::Lrgb) | (Shape::Lum(_), Shape::Lum(())) => {
            Ok(ptm.planes.samples.clone())
        }
        (Shape::Lum(_), _) => Error::impossible(format!(
            "cannot convert {source} to {target}: the colors of LUM can be read in several ways (rulings lum-vector, lum-major, lum-range, lum-chroma, lum-clamp), so no other format can represent all of them"
        )),
        (_, Shape::Lum(())) => Error::impossible(format!(
            "cannot convert {source} to {target}: conversion to Y, Cr and Cb always loses precision"
        )),
        _ => convert_texels(ptm, target),
    }
}

/// Reason why an RGB texel cannot be converted to LRGB.
const NOT_ONE_POLYNOMIAL: &str =
    "its three polynomials are not multiples of one representable polynomial";
/// Reason why an LRGB texel cannot be converted to RGB.
const NOT_A_BYTE: &str =
    "a coefficient times its color, divided by 255, is not a representable integer";

/// Maximum absolute value of a bias. Products of two such biases fit in an `i64`.
const MAX_ABSOLUTE_BIAS: f64 = 1e9;

/// Conversion of a texel, given the biases and one flag per coefficient. The flag is true if the scale of the coefficient is not
/// 0.
type TexelRule = fn(&[u8], &[i64; 6], [bool; 6]) -> Option<Vec<u8>>;

/// Converts every texel between RGB and LRGB, or reports the first texel that the target cannot represent.
fn convert_texels(ptm: &Ptm, target: Format) -> Result<Vec<u8>> {
    let (why, convert): (_, TexelRule) = match ptm.planes.shape {
        Shape::Rgb => (NOT_ONE_POLYNOMIAL, factor_colors),
        _ => (NOT_A_BYTE, multiply_colors),
    };
    let (source, set) = (ptm.header.format, &ptm.header.scale_bias);
    if set.bias.iter().any(|bias| bias.abs() > MAX_ABSOLUTE_BIAS) {
        return Error::impossible(format!(
            "cannot convert {source} to {target}: a bias exceeds {MAX_ABSOLUTE_BIAS}"
        ));
    }
    let bias = set.bias.map(|bias| bias as i64);
    let used = set.scale.map(|scale| scale != 0.0);
    let mut samples = Vec::with_capacity(ptm.planes.size.texels() * target.channels());
    let mut misfits = Vec::new();
    for (i, texel) in ptm.planes.texels().enumerate() {
        match convert(texel, &bias, used) {
            Some(texel) => samples.extend(texel),
            None => misfits.push(i),
        }
    }
    let Some(&first) = misfits.first() else {
        return Ok(samples);
    };
    let (count, size) = (misfits.len(), ptm.planes.size);
    let (all, position) = (size.texels(), describe_position(size, first));
    Error::impossible(format!(
        "cannot convert {source} to {target}: {count} of {all} texels do not fit, the first at {position}: {why}"
    ))
}

/// Factors three polynomials into one polynomial and three colors. Returns `None` if there is no exact factorization.
///
/// After subtraction of the biases, the three polynomials must be multiples m·d of a primitive vector d. The common
/// polynomial is n·d for some n, and each color is 255·m/n.
fn factor_colors(texel: &[u8], bias: &[i64; 6], used: [bool; 6]) -> Option<Vec<u8>> {
    let value = |channel: usize, i: usize| match used[i] {
        true => i64::from(texel[6 * channel + i]) - bias[i],
        false => 0,
    };
    let vectors = [0, 1, 2].map(|channel| std::array::from_fn::<i64, 6, _>(|i| value(channel, i)));
    // Coefficients with a scale of 0 have no effect and keep their stored values.
    let stored = |i: usize, value: i64| match used[i] {
        true => u8::try_from(value + bias[i]).ok(),
        false => Some(texel[i]),
    };
    let Some(longest) = vectors.iter().find(|vector| vector.iter().any(|&x| x != 0)) else {
        return Some([&texel[..6], &[0, 0, 0]].concat());
    };
    let sizes = longest.iter().map(|x| x.abs());
    let factor = sizes.fold(0, greatest_common_divisor);
    let direction = longest.map(|x| x / factor);
    let lead = direction.iter().position(|&x| x != 0)?;
    let multiples = vectors.map(|vector| vector[lead] / direction[lead]);
    let is_parallel =
        |(vector, multiple): (&[i64; 6], i64)| (0..6).all(|i| vector[i] == multiple * direction[i]);
    if !vectors.iter().zip(multiples).all(is_parallel) {
        return None;
    }
    // Each element of n · d plus its bias must fit a byte, so there are at most 256 candidates for n.
    let values = (0..=255).map(|byte| byte - bias[lead]);
    let fitting = values.filter(|value| *value != 0 && value % direction[lead] == 0);
    fitting.map(|value| value / direction[lead]).find_map(|n| {
        let polynomial = (0..6).map(|i| stored(i, n * direction[i]));
        let color = |multiple: i64| {
            ((255 * multiple) % n == 0).then(|| u8::try_from(255 * multiple / n).ok())?
        };
        polynomial.chain(multiples.map(color)).collect()
    })
}

/// Multiplies the polynomial of a texel by its three colors. Returns `None` if a product is not exact.
fn multiply_colors(texel: &[u8], bias: &[i64; 6], used: [bool; 6]) -> Option<Vec<u8>> {
    let coefficient = |(color, i): (u8, usize)| {
        if !used[i] {
            return Some(texel[i]);
        }
        let product = (i64::from(texel[i]) - bias[i]) * i64::from(color);
        (product % 255 == 0).then(|| u8::try_from(product / 255 + bias[i]).ok())?
    };
    let colors = texel[6..9].iter();
    let pairs = colors.flat_map(|&color| (0..6).map(move |i| (color, i)));
    pairs.map(coefficient).collect()
}

fn greatest_common_divisor(a: i64, b: i64) -> i64 {
    match b {
        0 => a,
        _ => greatest_common_divisor(b, a % b),
    }
}

const BUG: &str = "this is a bug in ptm-conform, and nothing was written";

/// Reads the converted file back and compares it with the map. Returns the largest difference between stored values.
fn verify(bytes: &[u8], ptm: &Ptm, samples: &[u8], target: Target) -> Result<u8> {
    let wrong = |fault: &str| format!("the converted file was read back and {fault}; {BUG}");
    let back = decode(bytes).map_err(|error| wrong(&format!("is refused: {error}")))?;
    if back.header.size != ptm.header.size || back.header.scale_bias != ptm.header.scale_bias {
        return Err(wrong("has a different header").into());
    }
    let pairs = back.planes.samples.iter().zip(samples);
    let largest = pairs.map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
    if target.format.coding() != Some(Coding::Jpeg) && largest > target.loss {
        return Err(wrong("contains different values").into());
    }
    if back.planes.shape.channels() != ptm.planes.shape.channels() && largest == 0 {
        check_same_colors(ptm, &back).map_err(|fault| wrong(&fault.to_string()))?;
    }
    Ok(largest)
}

/// Checks that an RGB map and an LRGB map have the same colors. A polynomial has six coefficients, so six lights suffice.
fn check_same_colors(a: &Ptm, b: &Ptm) -> Result<()> {
    const LU: [f64; 6] = [0.0, 0.5, 0.0, -0.5, 0.25, 0.625];
    const LV: [f64; 6] = [0.0, 0.0, 0.5, 0.25, -0.5, 0.625];
    let (a, b) = (a.coefficients(), b.coefficients());
    for (lu, lv) in LU.into_iter().zip(LV) {
        let (a, b) = (a.evaluate(lu, lv), b.evaluate(lu, lv));
        let mut pairs = a.values.iter().zip(&b.values);
        if pairs.any(|(a, b)| (a - b).abs() > 1e-6) {
            return Error::impossible(format!("has different colors under the light {lu},{lv}"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNTS: [bool; 6] = [true; 6];

    #[test]
    fn only_multiples_of_one_polynomial_are_factored() {
        // Multiples 10, 6 and 0 of d = (1, 2, −1, 0, 3, 1) over a bias of 100.
        let p = |m: i64| [1, 2, -1, 0, 3, 1].map(|d: i64| (m * d + 100) as u8);
        let found = factor_colors(&[p(10), p(6), p(0)].concat(), &[100; 6], COUNTS);
        assert_eq!(found, Some([&p(10)[..], &[255, 153, 0]].concat()));
        let gray = factor_colors(&[[1, 2, 3, 4, 5, 6]; 3].concat(), &[0; 6], COUNTS);
        assert_eq!(gray, Some(vec![1, 2, 3, 4, 5, 6, 255, 255, 255]));
        let black = factor_colors(&[7; 18], &[7; 6], COUNTS).unwrap();
        assert_eq!(black[6..], [0, 0, 0]);
        let other: Vec<u8> = (0..18_u32).map(|i| (i * i % 251) as u8).collect();
        assert_eq!(factor_colors(&other, &[0; 6], COUNTS), None);
    }

    /// Half of the texels are convertible by construction: colors are multiples of 51, and coefficients are multiples of 5.
    #[test]
    fn exact_products_are_factored() {
        let bias = [20, 30, 40, 50, 60, 70];
        let mut fitting = 0;
        for seed in 0..4000_u32 {
            let byte = |i: u32| (seed.wrapping_mul(2_654_435_761).rotate_left(5 * i) >> 24) as u8;
            let value = |i: u32| match (seed % 2, byte(i)) {
                (0, x) => x,
                (_, x) if i < 6 => (bias[i as usize] + 5 * (i64::from(x) % 30)) as u8,
                (_, x) => x / 51 * 51,
            };
            let texel: Vec<u8> = (0..9).map(value).collect();
            let expected = |i: usize| {
                let (value, color) = (i64::from(texel[i % 6]), i64::from(texel[6 + i / 6]));
                let product = (value - bias[i % 6]) * color;
                let byte = u8::try_from(product / 255 + bias[i % 6]).ok();
                byte.filter(|_| product % 255 == 0)
            };
            let three = multiply_colors(&texel, &bias, COUNTS);
            assert_eq!(three, (0..18).map(expected).collect());
            let Some(three) = three else { continue };
            fitting += 1;
            let one = factor_colors(&three, &bias, COUNTS).expect("it is a product");
            assert_eq!(multiply_colors(&one, &bias, COUNTS), Some(three));
        }
        assert!(fitting > 10, "{fitting}");
    }
}
