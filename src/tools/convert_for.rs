//! Conversion of a map to a file that certain readers show correctly.
//!
//! Every format that all of them read is tried without loss, the format of the file first, in the spelling that every known
//! reader accepts. The results of the readers for each candidate are predicted.

use super::convert::{Converted, Target, convert};
use super::dissection::Dissection;
use super::joined;
use crate::ptm::{Coding, Format, Ptm};
use crate::readers::{OpenedFile, ReaderProfile, Shown};

/// Formats to try after that of the file: most widely supported first.
const FORMATS_TO_TRY: [Format; 7] = [
    Format::Lrgb,
    Format::Rgb,
    Format::PtmLut,
    Format::PtmCLut,
    Format::JpeglsLrgb,
    Format::JpeglsRgb,
    Format::Lum,
];

/// Converts the file that `dissection` describes into the first format that all of `readers` show right.
///
/// # Errors
/// Why there is none, in a sentence for each format that they read.
pub fn convert_for(
    dissection: &Dissection,
    ptm: &Ptm,
    readers: &[&ReaderProfile],
) -> Result<(Format, Converted), String> {
    let own = ptm.header.format;
    let others = FORMATS_TO_TRY.into_iter().filter(|&format| format != own);
    let read_by_all = |format: &Format| readers.iter().all(|reader| reader.reads(*format));
    let formats = std::iter::once(own).chain(others).filter(read_by_all);
    let formats: Vec<Format> = formats.collect();
    let names = joined(readers.iter().map(|reader| &*reader.name), " and ");
    if formats.is_empty() {
        return Err(format!(
            "{names}: no lossless format is read by all of them"
        ));
    }
    let mut reasons = Vec::new();
    for format in formats {
        match attempt(dissection, ptm, format, readers) {
            Ok(converted) => return Ok((format, converted)),
            Err(why) => reasons.push(why),
        }
    }
    Err(format!(
        "{names} display no spelling of this map correctly: {}",
        reasons.join("; ")
    ))
}

/// Returns the map in `format`, if all readers will show it correctly.
fn attempt(
    dissection: &Dissection,
    ptm: &Ptm,
    format: Format,
    readers: &[&ReaderProfile],
) -> Result<Converted, String> {
    if format.coding() == Some(Coding::Jpeg) {
        return Err(format!("{format} would lose something"));
    }
    let target = Target {
        format,
        quality: None,
        loss: 0,
    };
    let converted = convert(dissection, ptm, target)?;
    let subject = OpenedFile::new(&converted.bytes);
    for reader in readers {
        let prediction = subject.predict(reader);
        if prediction.shows != Shown::Right {
            let (reader, shows) = (&prediction.reader, prediction.shows.name());
            return Err(format!(
                "as {format}, {reader} would show {shows} ({})",
                prediction.how
            ));
        }
    }
    Ok(converted)
}
