//! Exports the suite as a corpus for other projects: files, expected arrays and images, a manifest, and instructions.
//!
//! Unlike `corpus/`, which is for the tests of this repository, an exported corpus needs no protocol: a test loads a file,
//! decodes it, and compares the result with an array. The same version and profile always produce the same bytes.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::Path;
use std::str::FromStr;

use image::{DynamicImage, ImageFormat};
use serde::Serialize;

use crate::error::{Error, Result};
use crate::export::{encode_exr, npy_bytes, npy_floats, stacked_planes};
use crate::lint::codes::Code;
use crate::render::{encode_image, rgb};
use ptm_suite::cases::{Case, Expect, Suite, TableSpelling};
use ptm_suite::choices::{CHOICES, relevant_axes};
use ptm_suite::kit::{digest::sha256, parallel::map_in_parallel, yaml::to_yaml};
use ptm_suite::protocol::frame::{View, ViewKind};
use ptm_suite::values::Values;
use ptm_suite::{compare::Expected, corpus::write_file};

/// Selection of cases from the suite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// One small file to decode and one to refuse for every clause and format, with stored values as arrays.
    Minimal,
    /// Every file up to 64 KiB, with stored values as arrays and images, and the preferred view of each case.
    Standard,
    /// Every file, including files with tables of 65,536 entries. Every view of every case is included, and final coefficients
    /// are also stored as EXR.
    Exhaustive,
}

impl Profile {
    /// All profiles with their names and maximum file sizes in bytes.
    const ALL: [(Profile, &'static str, usize); 3] = [
        (Profile::Minimal, "minimal", 4 << 10),
        (Profile::Standard, "standard", 64 << 10),
        (Profile::Exhaustive, "exhaustive", usize::MAX),
    ];

    /// Returns the name of the profile.
    #[must_use]
    pub const fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    const fn max_file_bytes(self) -> usize {
        Self::ALL[self as usize].2
    }

    /// Returns the views in which the profile includes the expected answers of a case.
    fn views(self, case: &Case) -> Vec<View> {
        let preferred = match self {
            Profile::Minimal => &[][..],
            Profile::Standard => &case.views[..1],
            Profile::Exhaustive => &case.views[..],
        };
        let more = preferred.iter().filter(|view| **view != View::Raw).cloned();
        std::iter::once(View::Raw).chain(more).collect()
    }

    /// Returns the cases of the profile, in suite order.
    #[must_use]
    pub fn cases(self, suite: &Suite) -> Vec<&Case> {
        let size = |case: &Case| case.build(TableSpelling::default()).file.len();
        let cases = suite.cases.iter();
        let fitting = cases.filter(|case| size(case) <= self.max_file_bytes());
        if self != Profile::Minimal {
            return fitting.collect();
        }
        // Select the first case of each expectation for every clause and format, and its twin.
        let mut covered = BTreeSet::new();
        let mut ids = BTreeSet::new();
        for case in fitting.filter(|case| matches!(case.expect, Expect::Decode | Expect::Reject)) {
            let mut is_new = false;
            for clause in &case.clauses {
                is_new |= covered.insert((case.expect.name(), case.format(), clause));
            }
            if is_new || case.first {
                ids.insert(case.id.as_str());
                ids.extend(case.twin_of.as_deref());
            }
        }
        let is_selected = |case: &&Case| ids.contains(case.id.as_str());
        suite.cases.iter().filter(is_selected).collect()
    }
}

impl FromStr for Profile {
    type Err = Error;

    fn from_str(name: &str) -> Result<Profile> {
        let mut profiles = Profile::ALL.into_iter();
        match profiles.find(|(_, known, _)| *known == name) {
            Some((profile, ..)) => Ok(profile),
            None => Error::impossible(format!(
                "unknown profile {name:?}; profiles are minimal, standard and exhaustive"
            )),
        }
    }
}

/// Manifest of an exported corpus.
#[derive(Debug, Serialize)]
pub struct Manifest {
    /// Name of the suite: `ptm-conform`.
    pub suite: &'static str,
    /// Version of the program that wrote the corpus.
    pub version: &'static str,
    /// Name of the profile.
    pub profile: &'static str,
    /// Cases in suite order.
    pub cases: Vec<ProfileCase>,
}

/// File and the results expected from a decoder.
#[derive(Debug, Serialize)]
pub struct ProfileCase {
    /// Permanent id of the case.
    pub id: String,
    /// Path of the file.
    pub file: String,
    /// Size of the file in bytes.
    pub bytes: usize,
    /// SHA-256 digest of the file.
    pub sha256: String,
    /// Format of the file before any damage.
    pub format: &'static str,
    /// Expected result: `decode`, `reject`, `refuse`, `lenient`, `robust` or `spelling`.
    pub expect: Expect,
    /// Reason why the case exists.
    pub because: String,
    /// Clauses that the case tests.
    pub clauses: Vec<String>,
    /// Ruling that the case is about.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ruling: Option<String>,
    /// Id of the valid case whose file was damaged to create this file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twin_of: Option<String>,
    /// Effect of the damage, if the file is damaged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damage: Option<&'static str>,
    /// Lint code, if the file must be refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lint: Option<&'static str>,
    /// Expected answers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub expected: Vec<ProfileAnswer>,
}

/// Expected answer that is stored in a file.
#[derive(Debug, Serialize)]
pub struct ProfileAnswer {
    /// View: `raw`, `coef` or `rgb:LU,LV`.
    pub view: String,
    /// Path of the file.
    pub file: String,
    /// File format: `npy`, `png` or `exr`.
    pub encoding: &'static str,
    /// Number of rows, number of columns, and number of channels.
    pub shape: [usize; 3],
    /// SHA-256 digest of the file.
    pub sha256: String,
    /// Path of an array of the same shape with an additional tolerance for each value, which allows for different inverse DCTs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slack: Option<String>,
    /// Rulings that affect the answer. Decoders that follow other readings of these rulings have different correct answers.
    #[serde(rename = "shows", skip_serializing_if = "Vec::is_empty")]
    pub rulings: Vec<&'static str>,
}

type ProfileFile = (String, Vec<u8>);

/// Writes the corpus to `directory`, which must be empty or missing. The output does not depend on `jobs`.
///
/// # Errors
/// Returns an error with the path if the directory is not empty or a file cannot be written.
pub fn write(
    suite: &Suite,
    directory: &Path,
    profile: Profile,
    jobs: usize,
    progress: &(impl Fn(usize, usize) + Sync),
) -> io::Result<Manifest> {
    if fs::read_dir(directory).is_ok_and(|mut entries| entries.next().is_some()) {
        let why = format!("{}: the directory is not empty", directory.display());
        return Err(io::Error::new(io::ErrorKind::AlreadyExists, why));
    }
    let cases = profile.cases(suite);
    let entries = map_in_parallel(cases.len(), jobs, progress, &|i| {
        let (entry, outputs) = entry(cases[i], profile).map_err(io::Error::other)?;
        for (path, bytes) in outputs {
            write_file(&directory.join(path), &bytes)?;
        }
        Ok(entry)
    });
    let manifest = Manifest {
        suite: "ptm-conform",
        version: env!("CARGO_PKG_VERSION"),
        profile: profile.name(),
        cases: entries.into_iter().collect::<io::Result<_>>()?,
    };
    let yaml = to_yaml(&manifest).map_err(io::Error::other)?;
    let json = serde_json::to_string_pretty(&manifest).map_err(io::Error::other)?;
    write_file(&directory.join("MANIFEST.yaml"), yaml.as_bytes())?;
    write_file(&directory.join("MANIFEST.json"), (json + "\n").as_bytes())?;
    let readme = README.replace("{profile}", profile.name());
    let readme = readme.replace("{version}", manifest.version);
    write_file(&directory.join("README.md"), readme.as_bytes())?;
    write_file(&directory.join(".gitattributes"), GITATTRIBUTES.as_bytes())?;
    Ok(manifest)
}

fn entry(case: &Case, profile: Profile) -> Result<(ProfileCase, Vec<ProfileFile>)> {
    let built = case.build(TableSpelling::default());
    let folder = case.format().short_name().to_lowercase();
    let file = format!("files/{folder}/{}.ptm", case.id);
    let mut outputs = vec![(file.clone(), built.file.clone())];
    let mut expected = Vec::new();
    for view in profile.views(case) {
        if let Some(values) = Expected::new(&built.values, &view) {
            expected.extend(answers(
                case,
                &built.values,
                &view,
                &values,
                profile,
                &mut outputs,
            )?);
        }
    }
    let refused = case.expect.is_refusal();
    let damage = case.damage();
    let code = damage.filter(|_| refused);
    let code = code.and_then(|damage| Code::for_rejected_file(&damage.name));
    let entry = ProfileCase {
        id: case.id.clone(),
        file,
        bytes: built.file.len(),
        sha256: sha256(&built.file),
        format: case.format().name(),
        expect: case.expect,
        because: case.because.clone(),
        clauses: case.clauses.clone(),
        ruling: case.ruling.clone(),
        twin_of: case.twin_of.clone(),
        damage: damage.map(|damage| damage.effect.as_str()),
        lint: code.map(|code| code.id),
        expected,
    };
    Ok((entry, outputs))
}

/// Adds the files of an expected answer to `outputs`: an array and, depending on the profile and the view, an image or an EXR
/// file. Returns their manifest entries.
fn answers(
    case: &Case,
    values: &Values,
    view: &View,
    expected: &Expected,
    profile: Profile,
    outputs: &mut Vec<ProfileFile>,
) -> Result<Vec<ProfileAnswer>> {
    let axes = relevant_axes(case, values, view).into_iter();
    let shows: Vec<&str> = axes.map(|axis| CHOICES[axis].ruling).collect();
    // `raw`, `coef`, `rgb-0.25--0.5`
    let suffix = view.to_string().replace([':', ','], "-");
    let folder = case.format().short_name().to_lowercase();
    let stem = format!("expected/{folder}/{}.{suffix}", case.id);
    let mut answers = Vec::new();
    let (size, channels) = (expected.size, expected.channels);
    let slack = (!expected.slack.is_empty()).then(|| format!("{stem}.slack.npy"));
    if let Some(path) = &slack {
        outputs.push((path.clone(), npy_floats(&expected.slack, size, channels)));
    }
    for (encoding, bytes) in encode_answer(expected, &stem, profile)? {
        let path = format!("{stem}.{encoding}");
        answers.push(ProfileAnswer {
            view: view.to_string(),
            file: path.clone(),
            encoding,
            shape: [size.height as usize, size.width as usize, channels],
            sha256: sha256(&bytes),
            slack: slack.clone(),
            rulings: shows.clone(),
        });
        outputs.push((path, bytes));
    }
    Ok(answers)
}

/// Encodes an answer as NPY and, depending on the profile, as an image or EXR. Returns pairs of file suffix and bytes.
fn encode_answer(
    expected: &Expected,
    description: &str,
    profile: Profile,
) -> Result<Vec<(&'static str, Vec<u8>)>> {
    let (size, channels) = (expected.size, expected.channels);
    let png =
        |image: DynamicImage| Ok::<_, String>(("png", encode_image(&image, ImageFormat::Png)?));
    let values = &expected.values;
    let floats = ("npy", npy_floats(values, size, channels));
    let rounded = values.iter().map(|value| value.round() as u8);
    let bytes = || rounded.clone().collect::<Vec<u8>>();
    Ok(match (expected.view, profile) {
        (ViewKind::Raw, Profile::Minimal) => vec![("npy", npy_bytes(&bytes(), size, channels))],
        (ViewKind::Raw, _) => {
            let npy = ("npy", npy_bytes(&bytes(), size, channels));
            vec![npy, png(stacked_planes(&bytes(), size, channels).into())?]
        }
        (ViewKind::Coef, Profile::Exhaustive) => {
            let exr = encode_exr(values, size, channels, description)?;
            vec![floats, ("exr", exr)]
        }
        (ViewKind::Coef, _) => vec![floats],
        (ViewKind::Rgb, _) => vec![floats, png(rgb(size, bytes()).into())?],
    })
}

/// Git attributes that prevent changes to the bytes of the files.
const GITATTRIBUTES: &str = ptm_spec_cases::PROFILE_GITATTRIBUTES;

/// Instructions for users of the corpus.
const README: &str = ptm_spec_cases::PROFILE_README;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_are_nested_and_minimal_covers_every_clause() {
        let suite = Suite::load().expect("the suite loads");
        let [minimal, standard, exhaustive] = Profile::ALL.map(|row| row.0.cases(&suite));
        assert!(minimal.len() * 2 < standard.len() && standard.len() < exhaustive.len());
        assert_eq!(exhaustive.len(), suite.cases.len());
        let clauses = |cases: &[&Case]| -> BTreeSet<String> {
            let legal = cases.iter().filter(|case| case.expect == Expect::Decode);
            legal.flat_map(|case| case.clauses.clone()).collect()
        };
        let size = |case: &Case| case.build(TableSpelling::default()).file.len();
        let is_small = |case: &&Case| size(case) <= Profile::Minimal.max_file_bytes();
        let small: Vec<&Case> = suite.cases.iter().filter(is_small).collect();
        assert_eq!(clauses(&minimal), clauses(&small));
    }
}
