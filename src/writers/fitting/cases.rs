//! The suite of photographs as a run asks it, and what its failures are made of.

use std::collections::BTreeSet;

use crate::decode::decode;
use crate::diagnose::{Category, Cause, Diagnosis};
use crate::misreadings::Misreading;
use crate::ptm::Format;
use crate::session::observation::Response;
use crate::session::outcome::Outcome;
use crate::session::run::Run;
use crate::suite::cases::{Expect, Suite, TableSpelling};
use crate::suite::dialect::{Choices, Dialect, Right};
use crate::suite::features::Feature;
use crate::suite::test_case::{Allowance, Comparison, TestCase};
use crate::writers::diagnose::described;
use crate::writers::fault::WriterFault;
use crate::writers::fitting::judge::judge;
use crate::writers::fitting::mistakes::{COARSE, Evidence, FitMistake, MISTAKES};
use crate::writers::fitting::pictures::{FORMATS, FitRequest, PictureSet};
use crate::writers::fitting::sets::{SETS, SetPlan};
use crate::writers::test_case::{WriteView, WrittenFile};

/// Photographs to be fitted in a format.
#[derive(Clone, Debug)]
pub struct FitCase {
    id: String,
    because: String,
    clauses: Vec<String>,
    /// The format that is asked for.
    pub format: Format,
    source: PictureSource,
}

/// Where the photographs of a case come from.
#[derive(Clone, Debug)]
enum PictureSource {
    Made(&'static SetPlan),
    Given(PictureSet),
}

/// What a fitter is sent.
pub struct BuiltFit {
    /// The request in JSON, in which the path of the `.lp` file is still a name in braces.
    pub json: Vec<u8>,
    /// The photographs.
    pub set: PictureSet,
}

impl Suite<FitCase> {
    /// The photographs that are part of the program, and those of somebody's own.
    #[must_use]
    pub fn of_photographs(own: Option<&PictureSet>) -> Suite<FitCase> {
        let made = SETS.iter().flat_map(|plan| {
            FORMATS.map(|format| FitCase {
                id: id_of(plan.name, format),
                because: plan.because.to_owned(),
                clauses: vec![plan.clause.to_owned()],
                format,
                source: PictureSource::Made(plan),
            })
        });
        let given = own.into_iter().flat_map(|set| {
            FORMATS.map(|format| FitCase {
                id: id_of("own", format),
                because: "The pictures that --lp names.".to_owned(),
                clauses: vec!["1.0/1".to_owned()],
                format,
                source: PictureSource::Given(set.clone()),
            })
        });
        Suite {
            cases: made.chain(given).collect(),
        }
    }
}

fn id_of(set: &str, format: Format) -> String {
    format!("fit-{}-{set}", format.short_name().to_lowercase())
}

impl FitCase {
    /// The photographs.
    #[must_use]
    pub fn photographs(&self) -> PictureSet {
        match &self.source {
            PictureSource::Made(plan) => plan.made(self.format),
            PictureSource::Given(set) => set.clone(),
        }
    }
}

impl TestCase for FitCase {
    type View = WriteView;
    type Output = WrittenFile;
    type Difference = WriterFault;
    type Feature = Feature;
    type Built = BuiltFit;
    type Decisions = ();

    const VIEWS: &'static [&'static str] = &["write"];
    const CHOICES: Choices<()> = Choices(&[]);

    fn id(&self) -> &str {
        &self.id
    }

    fn clauses(&self) -> &[String] {
        &self.clauses
    }

    fn because(&self) -> String {
        self.because.clone()
    }

    fn ruling(&self) -> Option<&str> {
        None
    }

    fn expect(&self) -> Expect {
        Expect::Decode
    }

    fn expectation(&self) -> &'static str {
        "write"
    }

    fn is_first(&self) -> bool {
        matches!(self.source, PictureSource::Made(plan) if plan.name == SETS[0].name)
    }

    fn views(&self) -> &[WriteView] {
        &[WriteView]
    }

    fn view_name(_: &WriteView) -> &'static str {
        "write"
    }

    fn kind(&self) -> Feature {
        Feature::Format(self.format)
    }

    fn features(&self, _: &WriteView) -> BTreeSet<Feature> {
        BTreeSet::from([self.kind()])
    }

    fn twins(cases: &[FitCase]) -> Vec<Vec<usize>> {
        vec![Vec::new(); cases.len()]
    }

    fn has_table(&self) -> bool {
        false
    }

    fn spelling(&self) -> Option<TableSpelling> {
        None
    }

    fn made(&self, _: TableSpelling) -> BuiltFit {
        let set = self.photographs();
        let request = FitRequest {
            format: self.format.name().to_owned(),
            width: set.size.width,
            height: set.size.height,
            lp: "{lp}".to_owned(),
        };
        BuiltFit {
            json: serde_json::to_vec_pretty(&request).expect("numbers and names"),
            set,
        }
    }

    fn file(built: &BuiltFit) -> &[u8] {
        &built.json
    }

    /// Twice what lies in the planes, and the largest header.
    fn largest_answer(&self, built: &BuiltFit) -> usize {
        2 * built.set.size.texels() * self.format.channels() + 65_536
    }

    fn compare(&self, built: &BuiltFit, _: &WriteView, file: &WrittenFile) -> Comparison<FitCase> {
        let difference = judge(&built.set, self.format, &file.0).err();
        Comparison {
            right: Right::Anyway(difference.is_none()),
            difference,
            allowance: Allowance::None,
        }
    }

    fn difference_in(&self, _: &WriteView, _: &WrittenFile, _: &Dialect) -> Option<WriterFault> {
        None
    }

    /// A fit is good enough or not.
    fn likeness(_: &WriterFault) -> f64 {
        0.0
    }

    /// Two files with the same values are the same.
    fn is_like(one: &WrittenFile, other: &WrittenFile) -> bool {
        one == other || decode(&one.0).ok() == decode(&other.0).ok()
    }

    fn expected_output(&self, _: &WriteView) -> Option<WrittenFile> {
        None
    }

    fn expected_in_words(&self) -> Option<String> {
        Some("a map that fits the pictures".to_owned())
    }

    fn fault(&self) -> String {
        unreachable!("every set of pictures can be fitted")
    }
}

/// Why the failures of `run` failed; most telling first.
pub(super) fn diagnose(
    suite: &Suite<FitCase>,
    run: &Run<FitCase>,
) -> Vec<Diagnosis<&'static Misreading>> {
    let mut failing: Vec<usize> = run.judgement.with(Outcome::Fail).collect();
    let mut diagnoses = Vec::new();
    let all = MISTAKES.iter();
    let mut explained: Vec<(&FitMistake, Vec<usize>)> = all.map(|one| (one, Vec::new())).collect();
    let mut coarse = Vec::new();
    for &place in &failing {
        let case = &suite.cases[place];
        let (set, file) = (case.photographs(), file_of(run, place));
        let Some(evidence) = file.and_then(|file| Evidence::of(&set, case.format, file)) else {
            continue;
        };
        for (mistake, places) in &mut explained {
            if evidence.shows(mistake) {
                places.push(place);
            }
        }
        if evidence.shows(&COARSE) {
            coarse.push(place);
        }
    }
    explained.push((&COARSE, coarse));
    loop {
        for (_, places) in &mut explained {
            places.retain(|place| failing.contains(place));
        }
        // Of equals the first.
        let best = explained
            .iter()
            .rev()
            .max_by_key(|(_, places)| places.len());
        let Some((mistake, places)) = best.filter(|(_, places)| !places.is_empty()) else {
            break;
        };
        failing.retain(|place| !places.contains(place));
        diagnoses.push(of_mistake(suite, run, mistake, places.clone()));
    }
    diagnoses.extend(described(suite, run, &failing));
    diagnoses
}

/// The file of a failure, where there is one.
fn file_of(run: &Run<FitCase>, place: usize) -> Option<&[u8]> {
    match &run.observations[place].as_ref()?.response {
        Response::Picture { frame, .. } => frame.as_ref().map(|file| &file.0[..]),
        _ => None,
    }
}

fn of_mistake(
    suite: &Suite<FitCase>,
    run: &Run<FitCase>,
    mistake: &FitMistake,
    explains: Vec<usize>,
) -> Diagnosis<&'static Misreading> {
    let first = explains[0];
    let observation = run.observations[first].as_ref();
    let says = match observation.map(|observation| &observation.response) {
        Some(Response::Picture {
            difference: Some(fault),
            ..
        }) => fault.says.as_str(),
        _ => "",
    };
    Diagnosis {
        cause: Cause::Described {
            category: Category::Difference,
            clause: mistake.clause.to_owned(),
            effect: mistake.effect.to_owned(),
            fix: mistake.fix.to_owned(),
            example: format!("for example {}: {says}", suite.cases[first].id),
            alike: Vec::new(),
        },
        explains,
        partly: Vec::new(),
        except: Vec::new(),
        shows: None,
        certain: false,
    }
}
