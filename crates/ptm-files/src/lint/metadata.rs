//! Facts about a file that an inventory lists, apart from findings.

use serde::Serialize;

use crate::dissection::{Dissection, Role};
use crate::join_texts;
use ptm::Coding;

/// Identifier of PTM 1.2 in PRONOM, the registry of file formats.
pub const PUID: &str = "fmt/519";

/// Facts about a file. A fact is `None` if the header could not be read that far, or if the format does not have it.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Metadata {
    /// Version, as in the first line: `PTM_1.2`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
    /// The six scales, as written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<String>,
    /// The six biases, as written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bias: Option<String>,
    /// Compression parameter of a compressed file: the quality of JPEG, or the maximum error of JPEG-LS.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quality: Option<String>,
    /// True if the stored values are exactly those that were compressed. The parameter of the header says so; streams may differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lossless: Option<bool>,
    /// Identifier of the format in PRONOM.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub puid: Option<&'static str>,
}

impl Metadata {
    /// Reads the facts from a dissected file.
    #[must_use]
    pub fn new(dissection: &Dissection) -> Metadata {
        let text = |role: Role| dissection.text(role);
        let six = |role: fn(usize) -> Role| {
            let texts: Vec<String> = (0..6).filter_map(|i| text(role(i))).collect();
            (texts.len() == 6).then(|| join_texts(texts, " "))
        };
        let version = text(Role::Version);
        let quality = text(Role::Parameter);
        let lossless = dissection.format.and_then(|format| match format.coding() {
            None => Some(true),
            Some(Coding::Jpeg) => Some(false),
            Some(Coding::JpegLs) => quality.as_ref().map(|near| near.parse() == Ok(0.0)),
        });
        Metadata {
            puid: (version.as_deref() == Some("PTM_1.2")).then_some(PUID),
            version,
            scale: six(Role::Scale),
            bias: six(Role::Bias),
            quality,
            lossless,
        }
    }
}
