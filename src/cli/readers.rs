//! Reader profiles for the option `--for`.

use std::cell::OnceCell;
use std::path::Path;

use ptm_files::readers::{
    OpenedFile, ReaderPrediction, ReaderProfile, Rendering, UnusualKind, parse_profiles, profiles,
};
use ptm_files::repair::{RepairedFile, repair};
use ptm_files::{convert_for::convert_for, dissection::Dissection};
use ptm_mistakes::Stage;
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
    let (dissection, repaired) = (OnceCell::new(), OnceCell::new());
    let fixes = Fixes {
        kind: subject.kind(),
        dissection: || dissection.get_or_init(|| Dissection::parse(file)),
        repaired: || repaired.get_or_init(|| repair(file).ok()).as_ref(),
    };
    let predict = |profile: &&ReaderProfile| {
        let prediction = subject.predict(profile);
        let fix = fixes.find(&prediction, profile);
        ReaderPrediction { fix, ..prediction }
    };
    readers.iter().map(predict).collect()
}

/// Finds fixes for a file. The file is dissected and repaired only if a reader does not display it.
struct Fixes<D, R> {
    kind: Option<UnusualKind>,
    dissection: D,
    repaired: R,
}

impl<'a, D, R> Fixes<D, R>
where
    D: Fn() -> &'a Dissection<'a>,
    R: Fn() -> Option<&'a RepairedFile>,
{
    /// Returns a fix for a prediction, or states that there is none. Returns `None` if no fix is needed or known.
    fn find(&self, prediction: &ReaderPrediction, profile: &ReaderProfile) -> Option<String> {
        if prediction.result.is_right() {
            return None;
        }
        let name = &profile.name;
        let outcome = &(self.dissection)().outcome;
        if let Some(repaired) = (self.repaired)()
            && helps(repaired, outcome.is_err(), profile)
        {
            return Some("`ptm-conform convert --repair` repairs this file".to_owned());
        }
        let Ok(ptm) = outcome else {
            let is_progressive = self.kind == Some(UnusualKind::Progressive);
            let fix = "make the planes sequential with `jpegtran`, which is lossless";
            return is_progressive.then(|| fix.to_owned());
        };
        if let Ok((format, _)) = convert_for((self.dissection)(), ptm, &[profile]) {
            let fix = format!("`ptm-conform convert --for {name}` writes this map as {format}");
            return Some(fix);
        }
        let causes = prediction.misreadings.iter().copied();
        let mut causes = causes.filter_map(ptm_mistakes::find);
        // Arithmetic is the same in every format.
        let cause = causes.find(|cause| cause.stage() >= Stage::Coefficients);
        Some(match cause {
            Some(cause) => format!("no fix: {name} {} in every format", cause.effect),
            None => format!("no fix: {name} shows no lossless copy of this map correctly"),
        })
    }
}

/// Returns true if the reader shows the repaired file correctly, or at least opens it if the file was damaged.
fn helps(repaired: &RepairedFile, was_damaged: bool, profile: &ReaderProfile) -> bool {
    let result = OpenedFile::new(&repaired.bytes).predict(profile).result;
    result.is_right() || was_damaged && result == Rendering::Wrong
}
