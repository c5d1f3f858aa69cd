//! Reader profiles for the option `--for`.

use std::path::Path;

use ptm_files::readers::{
    OpenedFile, ReaderPrediction, ReaderProfile, Rendering, parse_profiles, profiles,
};
use ptm_files::{convert_for::convert_for, dissection::Dissection};
use ptm_suite::kit::yaml;

use super::{files::with_path, names::did_you_mean};

/// Loads reader profiles from a file, or returns the built-in ones if no file is given.
pub fn load_profiles(file: Option<&Path>) -> Result<Vec<ReaderProfile>, String> {
    match file {
        None => Ok(profiles().to_vec()),
        Some(path) => parse_profiles(&yaml::read_text(path)?).map_err(with_path(path)),
    }
}

/// Selects profiles by name. The name `all` selects every profile.
pub fn select_profiles<'a>(
    known: &'a [ReaderProfile],
    names: &[String],
) -> Result<Vec<&'a ReaderProfile>, String> {
    let mut found: Vec<&ReaderProfile> = Vec::new();
    for name in names {
        let has_name = |profile: &&ReaderProfile| {
            name == "all" || profile.name == *name || profile.reader == *name
        };
        let matching: Vec<&ReaderProfile> = known.iter().filter(has_name).collect();
        if matching.is_empty() {
            let names: Vec<&str> = known.iter().map(|profile| &*profile.name).collect();
            let meant = did_you_mean(name, names.iter().copied());
            let names = names.join(", ");
            return Err(format!("--for {name}: expected {names} or all{meant}"));
        }
        for profile in matching {
            if !found.iter().any(|one| one.name == profile.name) {
                found.push(profile);
            }
        }
    }
    Ok(found)
}

/// Predicts what each reader displays for a file. Suggests a fix for each reader that does not display the correct image.
pub fn predict_readers(file: &[u8], readers: &[&ReaderProfile]) -> Vec<ReaderPrediction> {
    if readers.is_empty() {
        return Vec::new();
    }
    let subject = OpenedFile::new(file);
    let predict = |profile: &&ReaderProfile| {
        let mut prediction = subject.predict(profile);
        if prediction.result != Rendering::Right {
            let (dissection, name) = (Dissection::parse(file), &profile.name);
            let says = "regenerate the file from its source; `lint` lists the errors";
            let ptm = dissection.outcome.as_ref().map_err(|_| says.to_owned());
            let converted = ptm.and_then(|ptm| Ok(convert_for(&dissection, ptm, &[profile])?));
            let fix = converted.map(|(format, _)| {
                format!("`ptm-conform convert --for {name}` writes this map as {format}")
            });
            prediction.fix = Some(fix.unwrap_or_else(|why| why));
        }
        prediction
    };
    readers.iter().map(predict).collect()
}
