//! Cases of the fitter suite, and the causes of their failures.

use std::collections::BTreeMap;

use crate::diagnose::{describe, describe_differences};
use crate::fault::WriterFault;
use crate::fitting::judge::{compare_worst_light, judge};
use crate::fitting::mistakes::{MISTAKES, WrongMap};
use crate::fitting::optimum::{is_determined, optimum};
use crate::fitting::photographs::{Encoding, FORMATS, FitRequest, ImageSet};
use crate::fitting::sets::{SETS, SetPlan};
use crate::test_case::{BuiltRequest, ComparedFrames, FileCase, RequestValues, wrong_file};
use crate::{reference::write_requested_file, request::WriteRequest};
use ptm::Format;
use ptm_harness::diagnose::Diagnosis;
use ptm_harness::diagnose::cover::{CoverCandidate, cover};
use ptm_harness::runner::write::Attachment;
use ptm_harness::session::run::RunOf;
use ptm_mistakes::Misreading;
use ptm_suite::cases::{Expect, Suite};
use ptm_suite::name::SuiteName;
use ptm_suite::verdicts::outcome::Outcome;

/// A set of photographs to which a map in a given format is fitted.
pub type FitCase = FileCase<ImageSource>;

/// Photographs of a case, and their encoding.
#[derive(Clone, Debug)]
pub struct ImageSource {
    origin: ImageOrigin,
    encoding: Encoding,
}

#[derive(Clone, Debug)]
enum ImageOrigin {
    /// Generated photographs.
    Generated(&'static SetPlan),
    /// Photographs provided by the user.
    Provided(ImageSet),
}

/// Photographs as they are sent.
pub struct SentImages {
    set: ImageSet,
    encoding: Encoding,
}

/// Creates a suite with the generated photographs and, optionally, the user's photographs.
#[must_use]
pub fn load_fitter_requests(user_set: Option<&ImageSet>, encoding: Encoding) -> Suite<FitCase> {
    let generated = SETS.iter().map(ImageOrigin::Generated);
    let origins = generated.chain(user_set.cloned().map(ImageOrigin::Provided));
    let sources = origins.map(|origin| ImageSource { origin, encoding });
    let cases = sources.flat_map(|source| {
        const OWN: &str = "The request contains the images that the --lp file lists.";
        let (name, because, clause) = match &source.origin {
            ImageOrigin::Generated(plan) => (&*plan.name, &*plan.because, &*plan.clause),
            ImageOrigin::Provided(_) => ("own", OWN, "1.0/1"),
        };
        let may_be_refused = !is_determined(&source.photographs(FORMATS[0]));
        FORMATS.map(|format| FitCase {
            id: format!("fit-{}-{name}", format.short_name().to_lowercase()),
            because: because.to_owned(),
            clauses: vec![clause.to_owned()],
            expect: match may_be_refused {
                true => Expect::Lenient,
                false => Expect::Decode,
            },
            first: name == SETS[0].name,
            smoke: true,
            format,
            values: source.clone(),
        })
    });
    let cases = cases.collect();
    Suite { cases }
}

impl ImageSource {
    /// Returns the photographs for a map in this format.
    #[must_use]
    pub fn photographs(&self, format: Format) -> ImageSet {
        let set = match &self.origin {
            ImageOrigin::Generated(plan) => plan.make(format),
            ImageOrigin::Provided(set) => set.clone(),
        };
        set.encoded_as(self.encoding)
    }
}

impl RequestValues for ImageSource {
    type Request = SentImages;

    const SUITE: SuiteName = SuiteName::Fitters;
    const VERB: &'static str = "fit";
    const EXPECTED: &'static str = "a map that fits the images";
    const PLACEHOLDERS: &'static [&'static str] = &["lp", "format", "width", "height"];

    fn build(&self, format: Format) -> BuiltRequest<SentImages> {
        let set = self.photographs(format);
        let request = FitRequest {
            format: format.name().to_owned(),
            width: set.size.width,
            height: set.size.height,
            lp: "{lp}".to_owned(),
        };
        BuiltRequest {
            json: serde_json::to_string_pretty(&request).expect("numbers and names"),
            size: set.size,
            request: SentImages {
                set,
                encoding: self.encoding,
            },
        }
    }

    fn attachments(built: &BuiltRequest<SentImages>) -> Vec<Attachment> {
        let mut attachments = vec![Attachment {
            name: "lp".to_owned(),
            file_name: "lights.lp".to_owned(),
            bytes: built.request.set.lp().into_bytes(),
        }];
        let images = built.request.set.photographs.iter().enumerate();
        attachments.extend(images.map(|(k, photograph)| Attachment {
            name: format!("picture-{k}"),
            file_name: photograph.name.clone(),
            bytes: photograph.file(built.size, built.request.encoding),
        }));
        attachments
    }

    fn judge(request: &SentImages, format: Format, file: &[u8]) -> Result<(), WriterFault> {
        judge(&request.set, format, file)
    }

    fn reference_file(request: &SentImages, format: Format) -> Option<Vec<u8>> {
        let map = optimum(&request.set, format);
        write_requested_file(&WriteRequest::from_ptm(&map)).ok()
    }

    fn images(request: &SentImages, format: Format, file: &[u8]) -> Option<ComparedFrames> {
        compare_worst_light(&request.set, format, file)
    }

    fn to_bytes(built: &BuiltRequest<SentImages>) -> Vec<u8> {
        let mut bytes = built.request.set.lp().into_bytes();
        for photograph in &built.request.set.photographs {
            bytes.extend(&photograph.pixels);
        }
        bytes
    }

    fn describe(built: &BuiltRequest<SentImages>) -> (&'static str, String) {
        ("Lights and images", built.request.set.lp())
    }

    fn diagnose(
        suite: &Suite<FitCase>,
        run: &RunOf<FitCase>,
        _: usize,
    ) -> Vec<Diagnosis<&'static Misreading>> {
        let mut failing: Vec<usize> = run.judgment.with_outcome(Outcome::Fail).collect();
        let wrong_map = |index: usize| wrong_file(run.observations[index].as_ref());
        let mut evidence: BTreeMap<usize, WrongMap> = BTreeMap::new();
        for &index in &failing {
            let (case, file) = (&suite.cases[index], wrong_map(index).map(|(file, _)| file));
            let map = |file| WrongMap::new(case.values.photographs(case.format), case.format, file);
            evidence.extend(file.and_then(map).map(|map| (index, map)));
        }
        let candidates = MISTAKES.iter().filter_map(|mistake| {
            let verdict = |index: usize| evidence.get(&index)?.verdict(mistake);
            let verdicts: BTreeMap<usize, Option<bool>> = failing
                .iter()
                .map(|&index| (index, verdict(index)))
                .collect();
            let count = |wanted| {
                verdicts
                    .values()
                    .filter(|&&one| one == Some(wanted))
                    .count()
            };
            // A mistake that explains few of the maps that it would change may resemble another one there.
            let shows = |index: usize| verdicts[&index] == Some(true) && count(true) > count(false);
            CoverCandidate::new(mistake, &failing, shows, &[], |_| false)
        });
        let mut diagnoses = Vec::new();
        for candidate in cover(candidates.collect(), &mut failing) {
            let (mistake, first) = (candidate.cause, candidate.explains[0]);
            let fault = wrong_map(first).map_or("", |(_, fault)| &fault.message);
            let example = format!("for example {}: {fault}", suite.cases[first].id);
            let cause = describe(&mistake.clause, (&mistake.effect, &mistake.fix), example);
            diagnoses.push(Diagnosis::new(cause, candidate.explains));
        }
        diagnoses.extend(describe_differences(suite, run, &failing));
        diagnoses
    }
}
