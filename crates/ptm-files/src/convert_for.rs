//! Converts a map to a file that the given readers display correctly.
//!
//! Tries lossless conversion to each format that all of the readers support, beginning with the format of the file, and
//! predicts what the readers display for each candidate. Candidates use the spelling that every known reader accepts. The first
//! candidate for a compressed file keeps its streams.

use super::convert::{ConvertedMap, Target, convert, encode};
use super::{dissection::Dissection, join_texts};
use crate::error::{Error, Result};
use crate::readers::{OpenedFile, ReaderProfile, Rendering};
use ptm::{Coding, Format, Ptm};

/// Formats to try after the format of the file, the most widely supported first.
const FORMATS_TO_TRY: [Format; 7] = [
    Format::Lrgb,
    Format::Rgb,
    Format::PtmLut,
    Format::PtmCLut,
    Format::JpeglsLrgb,
    Format::JpeglsRgb,
    Format::Lum,
];

/// Converts the file that `dissection` describes to the first format that all of `readers` display correctly, or else to the first
/// that all of them display nearly correctly.
///
/// # Errors
/// Returns a message that explains why each format that the readers support is unsuitable.
pub fn convert_for(
    dissection: &Dissection,
    ptm: &Ptm,
    readers: &[&ReaderProfile],
) -> Result<(Format, ConvertedMap)> {
    let own = ptm.header.format;
    let others = FORMATS_TO_TRY.into_iter().filter(|&format| format != own);
    let is_supported = |format: &Format| readers.iter().all(|reader| reader.reads(*format));
    let formats = std::iter::once(own).chain(others).filter(is_supported);
    let formats: Vec<Format> = formats.collect();
    let names = join_texts(readers.iter().map(|reader| &*reader.name), " and ");
    if formats.is_empty() {
        let reason = |format: &Format| {
            let reader = readers.iter().find(|reader| !reader.reads(*format))?;
            Some(format!("{} does not read {format}", reader.name))
        };
        let reasons = join_texts(FORMATS_TO_TRY.iter().filter_map(reason), ", ");
        let count = readers.len();
        return Error::impossible(format!(
            "no lossless format is supported by all {count} readers: {reasons}"
        ));
    }
    let mut reasons = Vec::new();
    let mut nearly = None;
    let is_exact = |format: &Format| format.coding() != Some(Coding::Jpeg);
    let encoded = formats.iter().copied().filter(is_exact);
    let mut attempts: Vec<(Format, Conversion)> = Vec::new();
    if own.coding().is_some() && formats.contains(&own) {
        attempts.push((own, convert));
    }
    attempts.extend(encoded.map(|format| (format, encode as Conversion)));
    for (format, conversion) in attempts {
        match try_format(dissection, ptm, format, conversion, readers) {
            Ok((converted, Rendering::Same)) => return Ok((format, converted)),
            Ok((converted, _)) => nearly = nearly.or(Some((format, converted))),
            Err(why) => reasons.push(why.to_string()),
        }
    }
    if let Some(nearly) = nearly {
        return Ok(nearly);
    }
    Error::impossible(format!(
        "{names} would not display this map correctly in any format: {}",
        reasons.join("; ")
    ))
}

/// Function that converts a map.
type Conversion = fn(&Dissection, &Ptm, Target) -> Result<ConvertedMap>;

/// Converts the map to `format`. Also returns the worst result of the readers: the same image, or nearly the same. Returns an error
/// if a reader would not display either.
fn try_format(
    dissection: &Dissection,
    ptm: &Ptm,
    format: Format,
    conversion: Conversion,
    readers: &[&ReaderProfile],
) -> Result<(ConvertedMap, Rendering)> {
    let (quality, loss) = (None, 0);
    let target = Target {
        format,
        quality,
        loss,
    };
    let converted = conversion(dissection, ptm, target)?;
    let subject = OpenedFile::new(&converted.bytes);
    let mut worst = Rendering::Same;
    for reader in readers {
        let prediction = subject.predict(reader);
        worst = worst.max(prediction.result);
        if !prediction.result.is_right() {
            let (shows, how) = (prediction.result.label(), prediction.fault);
            let reader = prediction.reader;
            return Error::impossible(format!(
                "as {format}, the result in {reader} would be: {shows} ({how})"
            ));
        }
    }
    Ok((converted, worst))
}
