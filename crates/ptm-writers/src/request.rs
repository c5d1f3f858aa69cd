//! Requests to a writer: header values in JSON, and the planes in a separate NumPy array.
//!
//! ```json
//! {
//!   "format": "PTM_FORMAT_JPEG_LRGB", "width": 3, "height": 2,
//!   "scale": [0.5, 0.25, 0.5, 0.25, 0.5, 0.75], "bias": [128, 100, 140, 120, 130, 3],
//!   "quality": 75,
//!   "planes": "/scratch/7/planes.npy"
//! }
//! ```
//!
//! - `matrix`: sixteen numbers in file order, for LUM only.
//! - `quality`: 20 to 100, for JPEG formats. `near`: maximum error, 0 for lossless, for JPEG-LS formats.
//! - `prediction`: optional; suggests how to predict planes from one another. A writer may ignore it. Its five lists,
//!   `references`, `order`, `transforms`, `motion_x` and `motion_y`, contain one number per plane, as defined in 2.9.2 to 2.9.5.
//! - `planes`: path of the stored values, height × width × channels, u8, top row first.

use serde::{Deserialize, Serialize};

use ptm::{Coding, ColorMatrix, Format, Header, Planes, Ptm, ScaleBias, Shape, Size};
use ptm_files::export::npy_bytes;
use ptm_suite::protocol::frame::{Samples, ViewKind};
use ptm_suite::protocol::npy;

/// Request to write a file.
#[derive(Clone, Debug, PartialEq)]
pub struct WriteRequest {
    /// Header values.
    pub header: RequestHeader,
    /// Format named in `header`.
    pub format: Format,
    /// Stored values, `height * width * channels`, interleaved, top row first.
    pub samples: Vec<u8>,
}

/// JSON part of a request: everything except the planes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RequestHeader {
    /// Name of the format (2.2).
    pub format: String,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Six scales (2.4).
    pub scale: [f64; 6],
    /// Six biases (2.4).
    pub bias: [i64; 6],
    /// Color matrix (2.6), in file order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matrix: Option<[f64; 16]>,
    /// Quality of JPEG planes (2.9.1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quality: Option<u8>,
    /// Maximum error of JPEG-LS planes (2.9.1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub near: Option<u8>,
    /// Suggested prediction between planes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prediction: Option<PredictionAdvice>,
    /// Path of the NumPy file that contains the planes.
    pub planes: String,
}

/// Suggested prediction between planes. Every list contains one number per plane.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PredictionAdvice {
    /// Reference of each plane, −1 for none (2.9.5).
    pub references: Vec<i64>,
    /// Rank of each plane (2.9.4).
    pub order: Vec<i64>,
    /// Transform of the reference of each plane (2.9.2).
    pub transforms: Vec<u32>,
    /// Horizontal motion in half texels (2.9.3).
    pub motion_x: Vec<i32>,
    /// Vertical motion in half texels (2.9.3).
    pub motion_y: Vec<i32>,
}

impl RequestHeader {
    /// Creates a header without the format-specific values, and with the placeholder `{planes}` for the path.
    pub(super) fn new(format: Format, size: Size, set: &ScaleBias) -> RequestHeader {
        RequestHeader {
            format: format.name().to_owned(),
            width: size.width,
            height: size.height,
            scale: set.scale,
            bias: set.bias.map(|bias| bias as i64),
            matrix: None,
            quality: None,
            near: None,
            prediction: None,
            planes: "{planes}".to_owned(),
        }
    }

    /// Reads the JSON of a request.
    ///
    /// # Errors
    /// Returns a message that describes the error.
    pub fn read(json: &[u8]) -> Result<RequestHeader, String> {
        serde_json::from_slice(json).map_err(|error| format!("the request: {error}"))
    }

    /// Serializes the header as indented JSON.
    #[must_use]
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self);
        text.expect("a request consists of numbers and strings") + "\n"
    }

    /// Combines the header with planes from a NumPy file.
    ///
    /// # Errors
    /// Returns a message if the array or the header does not fit the format.
    pub fn with_planes(self, array: &[u8]) -> Result<WriteRequest, String> {
        let (format, header): (Format, _) = (self.format.parse()?, self);
        let frame = npy::read(array, ViewKind::Raw);
        let frame = frame.map_err(|error| format!("the planes: {error}"))?;
        let Samples::U8(samples) = frame.samples else {
            return Err("the planes: the element type is not u8".to_owned());
        };
        let shape = (frame.height, frame.width, frame.channels);
        let expected = (header.height, header.width, format.channels() as u32);
        if shape != expected {
            return Err(format!(
                "the planes: expected shape {expected:?}, found {shape:?}"
            ));
        }
        header.validate(format)?;
        Ok(WriteRequest {
            header,
            format,
            samples,
        })
    }

    /// Checks that the header has exactly the values that its format needs.
    fn validate(&self, format: Format) -> Result<(), String> {
        let has_coding = |coding| format.coding() == Some(coding);
        for (key, needed, given) in [
            ("matrix", format == Format::Lum, self.matrix.is_some()),
            ("quality", has_coding(Coding::Jpeg), self.quality.is_some()),
            ("near", has_coding(Coding::JpegLs), self.near.is_some()),
        ] {
            match (needed, given) {
                (true, false) => return Err(format!("{format} requires \"{key}\"")),
                (false, true) => return Err(format!("{format} does not allow \"{key}\"")),
                _ => {}
            }
        }
        if self.width == 0 || self.height == 0 {
            return Err("a map must have at least one texel".to_owned());
        }
        if !self.scale.iter().all(|scale| scale.is_finite()) {
            return Err("a scale must be a finite number".to_owned());
        }
        if self.prediction.is_some() && format.coding().is_none() {
            return Err(format!("{format} does not allow \"prediction\""));
        }
        Ok(())
    }
}

/// Creates a map from its values. LUM maps need a matrix.
pub(super) fn new_map(
    format: Format,
    size: Size,
    scale_bias: ScaleBias,
    matrix: Option<[f64; 16]>,
    samples: Vec<u8>,
) -> Ptm {
    let shape = format
        .shape()
        .with_matrix(|| matrix.map(ColorMatrix).ok_or(()))
        .expect("a LUM map has a matrix");
    Ptm {
        header: Header {
            format,
            size,
            scale_bias,
        },
        planes: Planes {
            size,
            shape,
            samples,
        },
    }
}

impl WriteRequest {
    /// Creates a request for the values of an uncompressed map.
    #[must_use]
    pub fn from_ptm(ptm: &Ptm) -> WriteRequest {
        let format = ptm.header.format;
        let mut header = RequestHeader::new(format, ptm.header.size, &ptm.header.scale_bias);
        if let Shape::Lum(matrix) = ptm.planes.shape {
            header.matrix = Some(matrix.0);
        }
        let samples = ptm.planes.samples.clone();
        WriteRequest {
            header,
            format,
            samples,
        }
    }

    /// Returns the width and height.
    #[must_use]
    pub fn size(&self) -> Size {
        Size {
            width: self.header.width,
            height: self.header.height,
        }
    }

    /// Encodes the planes as a NumPy file.
    #[must_use]
    pub fn to_npy(&self) -> Vec<u8> {
        npy_bytes(&self.samples, self.size(), self.format.channels())
    }
}
