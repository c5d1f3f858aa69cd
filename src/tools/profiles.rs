//! The suite as a corpus for other projects: files, right answers as arrays and images, a manifest, and instructions.
//!
//! `corpus/` is for the tests of this repository; this corpus is for other projects. It needs no protocol: a test loads a file,
//! decodes it, and compares with an array. The same version and profile give the same bytes.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::Path;
use std::str::FromStr;

use image::{DynamicImage, ImageFormat};
use serde::Serialize;

use crate::kit::digest::sha256;
use crate::kit::parallel::map_in_parallel;
use crate::kit::yaml::to_yaml;
use crate::protocol::frame::{Samples, View, ViewKind};
use crate::suite::cases::{Case, Expect, Suite, TableSpelling};
use crate::suite::choices::{CHOICES, relevant_axes};
use crate::suite::compare::Expected;
use crate::suite::corpus::put;
use crate::tools::export::{exr_of, npy_bytes, npy_floats, stacked_planes};
use crate::tools::lint::codes::Code;
use crate::tools::render::{rgb, to_file};

/// A selection from the suite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// One small file to decode and one to refuse for every clause; stored values as arrays.
    Minimal,
    /// Every file up to 64 KiB; stored values as arrays and images, and the best view of each case.
    Standard,
    /// Every file, including tables of 65,536 entries; every view of every case, final coefficients as EXR too.
    Exhaustive,
}

impl Profile {
    /// All profiles, each with its name and the maximum number of bytes of a file.
    const ALL: [(Profile, &'static str, usize); 3] = [
        (Profile::Minimal, "minimal", 4 << 10),
        (Profile::Standard, "standard", 64 << 10),
        (Profile::Exhaustive, "exhaustive", usize::MAX),
    ];

    /// Returns its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    /// Returns the maximum number of bytes of a file.
    const fn largest(self) -> usize {
        Self::ALL[self as usize].2
    }

    /// Returns the views for which the right answer of a case is included.
    fn views(self, case: &Case) -> Vec<View> {
        let of_case = match self {
            Profile::Minimal => &[][..],
            Profile::Standard => &case.views[..1],
            Profile::Exhaustive => &case.views[..],
        };
        let more = of_case.iter().filter(|view| **view != View::Raw).cloned();
        std::iter::once(View::Raw).chain(more).collect()
    }

    /// Returns its cases, in the order of the suite.
    #[must_use]
    pub fn cases(self, suite: &Suite) -> Vec<&Case> {
        let size = |case: &Case| case.build(TableSpelling::default()).file.len();
        let cases = suite.cases.iter();
        let fitting = cases.filter(|case| size(case) <= self.largest());
        if self != Profile::Minimal {
            return fitting.collect();
        }
        // The first case of each expectation for every clause and format, and their twins.
        let mut covered = BTreeSet::new();
        let mut ids = BTreeSet::new();
        for case in fitting.filter(|case| matches!(case.expect, Expect::Decode | Expect::Reject)) {
            let fresh = case.clauses.iter().filter(|clause| {
                covered.insert((case.expect.name(), case.format(), (*clause).clone()))
            });
            if fresh.count() > 0 || case.first {
                ids.insert(case.id.as_str());
                ids.extend(case.twin_of.as_deref());
            }
        }
        let in_it = |case: &&Case| ids.contains(case.id.as_str());
        suite.cases.iter().filter(in_it).collect()
    }
}

impl FromStr for Profile {
    type Err = String;

    fn from_str(name: &str) -> Result<Profile, String> {
        let mut profiles = Profile::ALL.into_iter();
        let found = profiles.find(|(_, known, _)| *known == name);
        let found = found.map(|(profile, ..)| profile);
        found.ok_or_else(|| {
            format!("unknown profile {name:?}; profiles are minimal, standard and exhaustive")
        })
    }
}

/// The manifest of the corpus.
#[derive(Debug, Serialize)]
pub struct Manifest {
    /// `ptm-conform`
    pub suite: &'static str,
    /// The version that wrote it.
    pub version: &'static str,
    /// The profile.
    pub profile: &'static str,
    /// The files, in the order of the suite.
    pub cases: Vec<ProfileCase>,
}

/// A file and the expected results of a decoder.
#[derive(Debug, Serialize)]
pub struct ProfileCase {
    /// The case; permanent.
    pub id: String,
    /// Path of the file.
    pub file: String,
    /// Its size.
    pub bytes: usize,
    /// Its digest.
    pub sha256: String,
    /// Its format, or that of the file before it was damaged.
    pub format: &'static str,
    /// `decode`, `reject`, `refuse`, `lenient`, `robust` or `spelling`.
    pub expect: &'static str,
    /// The purpose of the case.
    pub because: String,
    /// The clauses that it tests.
    pub clauses: Vec<String>,
    /// The ruling that it shows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ruling: Option<String>,
    /// The accepted file that it was edited from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twin_of: Option<String>,
    /// The effect of the edit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damage: Option<&'static str>,
    /// The code of `ptm-conform lint`, if it must be refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lint: Option<&'static str>,
    /// The right answers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub expected: Vec<ProfiledAnswer>,
}

/// A right answer in a file.
#[derive(Debug, Serialize)]
pub struct ProfiledAnswer {
    /// `raw`, `coef` or `rgb:LU,LV`.
    pub view: String,
    /// Path of the file.
    pub file: String,
    /// `npy`, `png` or `exr`.
    pub encoding: &'static str,
    /// Rows, columns, channels.
    pub shape: [usize; 3],
    /// Its digest.
    pub sha256: String,
    /// An array of the same shape: the additional tolerance of each value, because inverse DCTs differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slack: Option<String>,
    /// Open choices that affect it: other readings of these rulings have other right answers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shows: Vec<&'static str>,
}

type ProfileFile = (String, Vec<u8>);

/// Writes the corpus below `directory`, which must be empty or missing. The output does not depend on `jobs`.
///
/// # Errors
/// Errors of the file system, with the path; or a directory that is not empty.
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
    let entries = map_in_parallel(cases.len(), jobs, progress, &|place| {
        let (entry, outputs) = entry(cases[place], profile).map_err(io::Error::other)?;
        for (path, bytes) in outputs {
            put(&directory.join(path), &bytes)?;
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
    put(&directory.join("MANIFEST.yaml"), yaml.as_bytes())?;
    put(&directory.join("MANIFEST.json"), (json + "\n").as_bytes())?;
    let readme = README.replace("{profile}", profile.name());
    let readme = readme.replace("{version}", manifest.version);
    put(&directory.join("README.md"), readme.as_bytes())?;
    put(&directory.join(".gitattributes"), GITATTRIBUTES.as_bytes())?;
    Ok(manifest)
}

fn entry(case: &Case, profile: Profile) -> Result<(ProfileCase, Vec<ProfileFile>), String> {
    let built = case.build(TableSpelling::default());
    let place = case.format().short_name().to_lowercase();
    let file = format!("files/{place}/{}.ptm", case.id);
    let mut outputs = vec![(file.clone(), built.file.clone())];
    let mut expected = Vec::new();
    for view in profile.views(case) {
        if let Some(values) = Expected::new(&built.values, &view) {
            expected.extend(answers(case, &view, &values, profile, &mut outputs)?);
        }
    }
    let refused = matches!(case.expect, Expect::Reject | Expect::Refuse);
    let damage = case.damage();
    let code = damage.filter(|_| refused);
    let code = code.and_then(|damage| Code::of_refused(&damage.name));
    let entry = ProfileCase {
        id: case.id.clone(),
        file,
        bytes: built.file.len(),
        sha256: sha256(&built.file),
        format: case.format().name(),
        expect: case.expect.manifest_name(),
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

/// Returns one right answer in all its forms: always an array; images and EXR if they are equivalent; and their files.
fn answers(
    case: &Case,
    view: &View,
    expected: &Expected,
    profile: Profile,
    outputs: &mut Vec<ProfileFile>,
) -> Result<Vec<ProfiledAnswer>, String> {
    let axes = relevant_axes(case, view).into_iter();
    let shows: Vec<&str> = axes.map(|axis| CHOICES[axis].ruling).collect();
    // `raw`, `coef`, `rgb-0.25--0.5`
    let suffix = view.to_string().replace([':', ','], "-");
    let place = case.format().short_name().to_lowercase();
    let stem = format!("expected/{place}/{}.{suffix}", case.id);
    let mut answers = Vec::new();
    let (size, channels) = (expected.size, expected.channels);
    let slack = (!expected.slack.is_empty()).then(|| format!("{stem}.slack.npy"));
    if let Some(path) = &slack {
        outputs.push((path.clone(), npy_floats(&expected.slack, size, channels)));
    }
    for (encoding, bytes) in encoded(expected, &stem, profile)? {
        let path = format!("{stem}.{encoding}");
        answers.push(ProfiledAnswer {
            view: view.to_string(),
            file: path.clone(),
            encoding,
            shape: [size.height as usize, size.width as usize, channels],
            sha256: sha256(&bytes),
            slack: slack.clone(),
            shows: shows.clone(),
        });
        outputs.push((path, bytes));
    }
    Ok(answers)
}

/// Returns an answer as NPY, and as the image or EXR of the profile, each with its suffix.
fn encoded(
    expected: &Expected,
    description: &str,
    profile: Profile,
) -> Result<Vec<(&'static str, Vec<u8>)>, String> {
    let (size, channels) = (expected.size, expected.channels);
    let png = |image: DynamicImage| Ok::<_, String>(("png", to_file(image, ImageFormat::Png)?));
    let values = &expected.values;
    let floats = ("npy", npy_floats(values, size, channels));
    Ok(match expected.view {
        ViewKind::Raw => {
            let Samples::U8(bytes) = expected.view.samples(values) else {
                return Err("stored values are bytes".to_owned());
            };
            let npy = ("npy", npy_bytes(&bytes, size, channels));
            match profile {
                Profile::Minimal => vec![npy],
                _ => vec![npy, png(stacked_planes(&bytes, size, channels).into())?],
            }
        }
        ViewKind::Coef => match profile {
            Profile::Exhaustive => {
                let exr = exr_of(values, size, channels, description)?;
                vec![floats, ("exr", exr)]
            }
            _ => vec![floats],
        },
        ViewKind::Rgb => {
            let bytes = values.iter().map(|value| value.round() as u8);
            vec![floats, png(rgb(size, bytes.collect()).into())?]
        }
    })
}

/// Git must not change any bytes.
const GITATTRIBUTES: &str = include_str!("../../spec-cases/profile.gitattributes");

/// Instructions for the corpus.
const README: &str = include_str!("../../spec-cases/profile.md");

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
            let asked = cases.iter().filter(|case| case.expect == Expect::Decode);
            asked.flat_map(|case| case.clauses.clone()).collect()
        };
        let size = |case: &Case| case.build(TableSpelling::default()).file.len();
        let is_small = |case: &&Case| size(case) <= Profile::Minimal.largest();
        let small: Vec<&Case> = suite.cases.iter().filter(is_small).collect();
        assert_eq!(clauses(&minimal), clauses(&small));
    }
}
