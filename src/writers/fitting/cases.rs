//! Cases of the fitter suite, and the causes of their failures.

use std::collections::BTreeMap;

use maud::{Markup, html};

use crate::diagnose::cover::{CoverCandidate, cover};
use crate::diagnose::{Causes, Diagnosis};
use crate::kit::digest::sha256;
use crate::misreadings::Misreading;
use crate::ptm::Format;
use crate::report::html::standard_error;
use crate::report::reported::Reported;
use crate::runner::write::Attachment;
use crate::session::observation::Observation;
use crate::session::outcome::Outcome;
use crate::session::run::Run;
use crate::suite::cases::{Expect, Suite, TableSpelling};
use crate::suite::dialect::{Choices, Right};
use crate::suite::features::Feature;
use crate::suite::name::SuiteName;
use crate::suite::test_case::{Allowance, Comparison, TestCase};
use crate::writers::asking::{RequestInput, WritingCase};
use crate::writers::diagnose::{describe, describe_differences};
use crate::writers::fault::WriterFault;
use crate::writers::fitting::judge::judge;
use crate::writers::fitting::mistakes::{MISTAKES, WrongMap};
use crate::writers::fitting::pictures::{FORMATS, FitRequest, ImageSet};
use crate::writers::fitting::sets::{SETS, SetPlan};
use crate::writers::test_case::{WriteView, WrittenFile, wrong_file};

/// Set of photographs to be fitted in a format.
#[derive(Clone, Debug)]
pub struct FitCase {
    id: String,
    because: String,
    clauses: Vec<String>,
    /// Requested format.
    pub format: Format,
    source: ImageSource,
}

/// Source of the photographs of a case.
#[derive(Clone, Debug)]
enum ImageSource {
    Generated(&'static SetPlan),
    Given(ImageSet),
}

/// Input for a fitter.
pub struct BuiltFit {
    /// Request in JSON, with a placeholder as the path of the `.lp` file.
    pub json: Vec<u8>,
    /// Photographs to be fitted.
    pub set: ImageSet,
}

impl Suite<FitCase> {
    /// Creates a suite with the generated photographs and, optionally, the user's photographs.
    #[must_use]
    pub fn load_fitter_requests(own: Option<&ImageSet>) -> Suite<FitCase> {
        let made = SETS.iter().map(ImageSource::Generated);
        let sources = made.chain(own.cloned().map(ImageSource::Given));
        let cases = sources.flat_map(|source| {
            let (name, because, clause) = match &source {
                ImageSource::Generated(plan) => (plan.name, plan.because, plan.clause),
                ImageSource::Given(_) => ("own", "The images that --lp names.", "1.0/1"),
            };
            FORMATS.map(|format| FitCase {
                id: format!("fit-{}-{name}", format.short_name().to_lowercase()),
                because: because.to_owned(),
                clauses: vec![clause.to_owned()],
                format,
                source: source.clone(),
            })
        });
        Suite {
            cases: cases.collect(),
        }
    }
}

impl FitCase {
    /// Returns the photographs of the case.
    #[must_use]
    pub fn photographs(&self) -> ImageSet {
        match &self.source {
            ImageSource::Generated(plan) => plan.make(self.format),
            ImageSource::Given(set) => set.clone(),
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

    fn expect(&self) -> Expect {
        Expect::Decode
    }

    fn expectation(&self) -> &'static str {
        "write"
    }

    fn is_first(&self) -> bool {
        matches!(self.source, ImageSource::Generated(plan) if plan.name == SETS[0].name)
    }

    fn views(&self) -> &[WriteView] {
        &[WriteView]
    }

    fn kind(&self) -> Feature {
        Feature::Format(self.format)
    }

    fn make(&self, _: TableSpelling) -> BuiltFit {
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

    /// Returns twice the size of the planes plus the maximum size of a header.
    fn largest_answer(&self, built: &BuiltFit) -> usize {
        2 * built.set.size.texels() * self.format.channels() + 65_536
    }

    fn compare(&self, built: &BuiltFit, _: &WriteView, file: &WrittenFile) -> Comparison<FitCase> {
        let difference = judge(&built.set, self.format, &file.0).err();
        Comparison {
            right: Right::InAll(difference.is_none()),
            difference,
            allowance: Allowance::None,
        }
    }

    fn is_equivalent(one: &WrittenFile, other: &WrittenFile) -> bool {
        one.decodes_equally(other)
    }

    fn expected_text(&self) -> Option<String> {
        Some("a map that fits the images".to_owned())
    }

    fn fault(&self) -> String {
        unreachable!("every set of images can be fitted")
    }
}

impl WritingCase for FitCase {
    const VERB: &'static str = "fit";

    fn format(&self) -> Format {
        self.format
    }

    fn sent(built: &BuiltFit) -> RequestInput {
        let lp = Attachment {
            name: "lp".to_owned(),
            file_name: "lights.lp".to_owned(),
            bytes: built.set.lp().into_bytes(),
        };
        let images = built.set.photographs.iter().enumerate();
        let images = images.map(|(k, of)| Attachment {
            name: format!("picture-{k}"),
            file_name: of.name.clone(),
            bytes: of.png(built.set.size),
        });
        RequestInput {
            json: String::from_utf8_lossy(&built.json).into_owned(),
            attachments: [lp].into_iter().chain(images).collect(),
            values: vec![
                ("width", built.set.size.width.to_string()),
                ("height", built.set.size.height.to_string()),
            ],
        }
    }
}

impl Reported for FitCase {
    const SUITE: SuiteName = SuiteName::Fitters;

    type MisreadingPoint = &'static Misreading;

    fn suite() -> Result<Suite<FitCase>, String> {
        Ok(Suite::load_fitter_requests(None))
    }

    fn digest(suite: &Suite<FitCase>) -> String {
        let digests = suite.cases.iter().map(|case| {
            let set = case.photographs();
            let pixels = set.photographs.iter().flat_map(|of| &of.pixels).copied();
            let lp = set.lp().into_bytes();
            sha256(&lp.into_iter().chain(pixels).collect::<Vec<u8>>())
        });
        sha256(digests.collect::<String>().as_bytes())
    }

    fn evidence(&self, _: TableSpelling, observation: &Observation<FitCase>) -> Markup {
        html! {
            p.label { "Lights and images" }
            pre.bytes tabindex="0" { (self.photographs().lp()) }
            @if !observation.stderr.is_empty() { (standard_error(&observation.stderr)) }
        }
    }

    fn diagnose(
        suite: &Suite<FitCase>,
        run: &Run<FitCase>,
        _: &[String],
        _: usize,
    ) -> Causes<&'static Misreading> {
        diagnose(suite, run).into()
    }
}

/// Returns the causes of the failures of `run`, sorted by the number of cases that each explains.
fn diagnose(suite: &Suite<FitCase>, run: &Run<FitCase>) -> Vec<Diagnosis<&'static Misreading>> {
    let mut failing: Vec<usize> = run.judgement.with_outcome(Outcome::Fail).collect();
    let wrong = |place: usize| wrong_file(run.observations[place].as_ref());
    let evidence = failing.iter().filter_map(|&place| {
        let (case, (file, _)) = (&suite.cases[place], wrong(place)?);
        Some((place, WrongMap::new(case.photographs(), case.format, file)?))
    });
    let evidence: BTreeMap<usize, WrongMap> = evidence.collect();
    let candidates = MISTAKES.iter().filter_map(|mistake| {
        let shows = |place: usize| evidence.get(&place).is_some_and(|of| of.matches(mistake));
        CoverCandidate::new(mistake, &failing, shows, &[], |_| false)
    });
    let candidates = candidates.collect();
    let chosen = cover(candidates, &mut failing).into_iter();
    let mut diagnoses: Vec<_> = chosen
        .map(|chosen| {
            let (mistake, first) = (chosen.cause, chosen.explains[0]);
            let fault = wrong(first).map_or("", |(_, fault)| &fault.says);
            let example = format!("for example {}: {fault}", suite.cases[first].id);
            let cause = describe(mistake.clause, (mistake.effect, mistake.fix), example);
            Diagnosis::new(cause, chosen.explains)
        })
        .collect();
    diagnoses.extend(describe_differences(suite, run, &failing));
    diagnoses
}
