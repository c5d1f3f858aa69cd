//! Verdicts from observations. [`outcome`] is the table of verdicts. Some of its rows depend on other observations: whether the
//! valid twin of a malformed file was decoded, whether a feature is supported, and how the decoder reads an open question. These
//! facts are derived here, from observations alone.

use std::collections::{BTreeMap, BTreeSet};

use crate::cases::{Case, Expect, Suite, TableSpelling};
use crate::dialect::{Axis, Choices, Dialect, RightDialects};
use crate::features::Feature;
use crate::protocol::frame::{Answer, ViewKind};
use crate::test_case::TestCase;
use crate::verdicts::dialect::{Certainty, DependentAnswers, dialect_of};
use crate::verdicts::observation::{Observation, ObservationOf, Response};
use crate::verdicts::offer::Offer;
use crate::verdicts::outcome::{Outcome, Verdict, outcome};

/// The result of judging a decoder. `F` is the type of features.
#[derive(Clone, Debug)]
pub struct Judgment<F = Feature> {
    /// Verdicts, one slot per case of the suite; `None` if the case was not selected.
    pub cases: Vec<Option<Verdict>>,
    /// Reading of each open question. If no case reveals the decoder's reading, this is the reading of the reference.
    pub dialect: Dialect,
    /// Certainty of each reading.
    pub certainties: Vec<Certainty>,
    /// Features that the decoder does not support.
    pub unsupported: BTreeSet<F>,
    /// Features with at least one decoded file.
    pub decoded: BTreeSet<F>,
}

impl<F> Judgment<F> {
    /// Returns the indices of the cases with this outcome.
    pub fn with_outcome(&self, outcome: Outcome) -> impl Iterator<Item = usize> {
        let judged = self.cases.iter().enumerate();
        judged.filter_map(move |(i, of)| (of.as_ref()?.outcome == outcome).then_some(i))
    }
}

/// Judges the observations of a run. `observations` has a slot for each case of the suite: `None` if no view of the case is
/// offered. `selected` marks the cases to judge; the others only serve as twins.
#[must_use]
pub fn judge<C: TestCase>(
    suite: &Suite<C>,
    selected: &[bool],
    observations: &[Option<ObservationOf<C>>],
    offer: &Offer,
) -> Judgment {
    let answers = DependentAnswers::new(suite, observations);
    let (dialect, certain) = dialect_of(&answers);
    let (unsupported, decoded) = features(suite, observations, offer);
    let twins = C::twins(&suite.cases);
    let reads_some_spelling = (suite.cases.iter().enumerate())
        .any(|(i, case)| case.expect() == Expect::Spelling && answers.is_right(i, &dialect));
    let judged = |i: usize| {
        let Some(observation) = &observations[i] else {
            return verdict(Outcome::NotJudged, "no view of the case is supported");
        };
        let facts = CaseFacts {
            index: i,
            case: &suite.cases[i],
            observation,
            twins: &twins[i],
            answers: &answers,
            dialect: &dialect,
            unsupported: &unsupported,
            reads_some_spelling,
        };
        facts.verdict(offer)
    };
    let cases = (0..suite.cases.len()).map(|i| selected[i].then(|| judged(i)));
    Judgment {
        cases: cases.collect(),
        dialect,
        certainties: certain,
        unsupported,
        decoded,
    }
}

impl Suite {
    /// Judges the answers of a decoder that is called in this process, for example in `cargo test`. `answers` has one answer per
    /// case, in order, each to the request for the case's file with tables spelled as `table` says, in the first view of the case.
    /// Cases without an answer are not judged.
    ///
    /// A decoder that supports only some formats answers the others with [`Answer::Unsupported`].
    #[must_use]
    pub fn judge_answers(&self, table: TableSpelling, answers: &[Answer]) -> Judgment {
        let mut observations = vec![None; self.cases.len()];
        for ((case, answer), observation) in self.cases.iter().zip(answers).zip(&mut observations) {
            let (built, view) = (case.build(table), &case.views[0]);
            *observation = Some(Observation::of_answer(case, &built, view, answer));
        }
        let offer = Offer {
            views: ViewKind::NAMES.to_vec(),
            ..Offer::default()
        };
        judge(self, &vec![true; self.cases.len()], &observations, &offer)
    }
}

impl Judgment {
    /// Returns the failures of a run of `suite`, with their reasons.
    pub fn failures<'a>(
        &'a self,
        suite: &'a Suite,
    ) -> impl Iterator<Item = (&'a Case, &'a Verdict)> {
        let judged = suite.cases.iter().zip(&self.cases);
        judged.filter_map(|(case, verdict)| {
            let verdict = verdict.as_ref()?;
            (verdict.outcome == Outcome::Fail).then_some((case, verdict))
        })
    }
}

struct CaseFacts<'a, C: TestCase> {
    /// Index of the case in the suite.
    index: usize,
    case: &'a C,
    observation: &'a ObservationOf<C>,
    /// Indices of the valid twins of the case.
    twins: &'a [usize],
    answers: &'a DependentAnswers<'a, C>,
    dialect: &'a Dialect,
    unsupported: &'a BTreeSet<Feature>,
    /// True if the decoder read at least one table spelling correctly.
    reads_some_spelling: bool,
}

/// Creates a verdict.
pub(crate) fn verdict(outcome: Outcome, message: impl Into<String>) -> Verdict {
    let message = message.into();
    Verdict { outcome, message }
}

/// Creates the verdict on a failure.
pub(crate) fn fail(says: impl Into<String>) -> Verdict {
    verdict(Outcome::Fail, says)
}

impl<C: TestCase> CaseFacts<'_, C> {
    /// Returns the outcome and the reason, according to the table and the exceptions in docs/protocol.md.
    fn verdict(&self, offer: &Offer) -> Verdict {
        let (case, observation) = (self.case, self.observation);
        let expect = case.expect();
        if let Some(how) = &observation.nondeterminism {
            return fail(&*how.message);
        }
        if offer.is_broken_by(case, observation, self.unsupported) {
            let kind = case.kind();
            return fail(format!(
                "its capabilities declare {kind}, but it decodes no file of this kind and exits with 69 (unsupported)"
            ));
        }
        // True if the decoder supports every feature that the case needs, and this view for its kind.
        let view = &observation.view;
        let is_supported = case.features(view).is_disjoint(self.unsupported);
        let is_supported = is_supported && !offer.lacks(C::view_name(view), &case.kind());
        let is_right = self.answers.is_right(self.index, self.dialect);
        let outcome = outcome(expect, is_supported, observation.response.kind(is_right));
        if outcome == Outcome::Unsupported {
            return verdict(outcome, "");
        }
        let is_image = |&twin: &usize| self.answers.is_image(twin);
        let id = |twin: usize| self.answers.suite.cases[twin].id();
        if !matches!(observation.response, Response::Violation(_))
            && let Some(says) = undecoded_twin_reason(self.twins, is_image, id)
        {
            return verdict(Outcome::Inconclusive, says);
        }
        match &observation.response {
            _ if outcome == Outcome::Pass => verdict(outcome, ""),
            Response::Violation(answer) => fail(answer.describe()),
            Response::Rejected => match (expect, case.expected_text()) {
                (Expect::ImplementationDefined, expected) => {
                    let expected = expected.unwrap_or_default();
                    let says = format!("received a refusal; the reference answers {expected}");
                    verdict(outcome, says)
                }
                (_, Some(expected)) => fail(format!("expected {expected}, received a refusal")),
                (_, None) => fail("refused a legal file"),
            },
            Response::Unsupported if expect == Expect::Reject => {
                fail("exited with 69 (unsupported) on a malformed file of a kind that it decodes")
            }
            Response::Unsupported => {
                let kind = case.features(view);
                let kind: Vec<String> = kind.iter().map(ToString::to_string).collect();
                fail(format!("{} ({})", C::UNSUPPORTED_MESSAGE, kind.join(", ")))
            }
            Response::Image {
                right, difference, ..
            } => {
                let own = self.answers.difference(self.index, self.dialect);
                let differs = own.as_ref().or(difference.as_ref());
                let differs = differs.map(ToString::to_string).unwrap_or_default();
                let differs = match readings_text(&C::CHOICES, right.axes(), self.dialect) {
                    Some(readings) => format!("{readings}, {differs}"),
                    None => differs,
                };
                self.wrong_image_verdict(right, differs)
            }
        }
    }

    /// Returns the verdict on a wrong image, or on any image of a file that must be refused.
    fn wrong_image_verdict(&self, right: &RightDialects, difference: String) -> Verdict {
        let is_right = |&twin: &usize| self.answers.is_right(twin, self.dialect);
        match (self.case.expect(), right) {
            (Expect::Reject | Expect::Refuse, _) => {
                fail(format!("{}: {}", C::ACCEPTED_MESSAGE, self.case.fault()))
            }
            (Expect::Spelling, _) if self.reads_some_spelling => verdict(Outcome::OtherDialect, ""),
            (Expect::Lenient | Expect::Robust, _)
                if !self.twins.is_empty() && !self.twins.iter().any(is_right) =>
            {
                verdict(Outcome::Inconclusive, "its twin was decoded incorrectly")
            }
            (Expect::ImplementationDefined, _) => verdict(
                Outcome::ImplementationDefined,
                format!("left to the implementation; the reference differs: {difference}"),
            ),
            (_, RightDialects::Depends { axes, .. }) => {
                let mut dialects = C::CHOICES.combinations(axes).into_iter();
                match dialects.find(|other| self.answers.is_right(self.index, other)) {
                    Some(other) => {
                        let mixed = mixed_readings_text(&C::CHOICES, axes, self.dialect, &other);
                        fail(mixed + &difference)
                    }
                    None => fail(difference),
                }
            }
            _ => fail(difference),
        }
    }
}

/// If a case has twins and none was decoded, returns the reason why a refusal proves nothing.
pub(crate) fn undecoded_twin_reason<'a>(
    twins: &[usize],
    is_decoded: impl Fn(&usize) -> bool,
    id: impl Fn(usize) -> &'a str,
) -> Option<String> {
    let (&first, others) = twins.split_first()?;
    if twins.iter().any(is_decoded) {
        return None;
    }
    let first = id(first);
    Some(if others.is_empty() {
        format!("its twin {first} was not decoded")
    } else {
        format!("no legal file of its kind (such as {first}) was decoded")
    })
}

/// Names the readings other than the reference's that an expected image follows, as in "with motion-border: samples outside a plane
/// are 128". Returns `None` if it follows the reference.
#[must_use]
pub fn readings_text<R>(choices: &Choices<R>, axes: &[Axis], dialect: &Dialect) -> Option<String> {
    let is_own = |&&axis: &&Axis| dialect.0[axis] != 0;
    let readings = axes.iter().filter(is_own).map(|&axis| {
        let choice = &choices[axis];
        format!("{}: {}", choice.ruling, choice.readings[dialect.0[axis]].0)
    });
    let readings: Vec<String> = readings.collect();
    (!readings.is_empty()).then(|| format!("with {}", readings.join("; ")))
}

/// Describes the readings that a decoder mixes. The answer is right in the `other` dialect.
pub(crate) fn mixed_readings_text<R>(
    choices: &Choices<R>,
    axes: &[Axis],
    dialect: &Dialect,
    other: &Dialect,
) -> String {
    let differs = |&&axis: &&Axis| other.0[axis] != dialect.0[axis];
    let readings = axes.iter().filter(differs).map(|&axis| {
        let choice = &choices[axis];
        let name = |dialect: &Dialect| choice.readings[dialect.0[axis]].0;
        let (here, elsewhere) = (name(other), name(dialect));
        format!("{}: {here} here, {elsewhere} elsewhere", choice.ruling)
    });
    let readings: Vec<String> = readings.collect();
    format!("mixes readings ({}): ", readings.join("; "))
}

/// Returns the unsupported and the decoded features. A feature is unsupported if none of its must-accept files was decoded and
/// most were answered with 69. The others may have been refused because of a different mistake, for example in the header.
fn features<C: TestCase>(
    suite: &Suite<C>,
    observations: &[Option<ObservationOf<C>>],
    offer: &Offer,
) -> (BTreeSet<Feature>, BTreeSet<Feature>) {
    let mut tally = FeatureTally::default();
    for (case, observation) in suite.cases.iter().zip(observations) {
        let Some(observation) = observation else {
            continue;
        };
        let kind = case.kind();
        // The first files of an unsupported kind were answered with 69, even if they are not selected.
        if offer.unsupported.contains(&kind) {
            tally.count_first_files(&kind);
        }
        if !matches!(
            case.expect(),
            Expect::Decode | Expect::ImplementationDefined
        ) {
            continue;
        }
        let is_view_missing = matches!(observation.response, Response::Unsupported)
            && offer.lacks(C::view_name(&observation.view), &kind);
        for feature in case.features(&observation.view) {
            // A missing view proves nothing about the kind.
            if !(is_view_missing && feature == kind) {
                tally.count(feature, &observation.response);
            }
        }
    }
    tally.unsupported_and_decoded()
}

/// Counts, for each feature, the requests that need it and those of them that were answered with 69.
pub(crate) struct FeatureTally<F> {
    asked: BTreeMap<F, (usize, usize)>,
    decoded: BTreeSet<F>,
}

impl<F> Default for FeatureTally<F> {
    fn default() -> Self {
        FeatureTally {
            asked: BTreeMap::new(),
            decoded: BTreeSet::new(),
        }
    }
}

impl<F: Clone + Ord> FeatureTally<F> {
    /// Counts the first files of a kind, which were all answered with 69, unless files of this kind have been counted.
    pub fn count_first_files(&mut self, kind: &F) {
        self.asked.entry(kind.clone()).or_insert((1, 1));
    }

    /// Counts a response to a request that needs the feature.
    pub fn count<T, D>(&mut self, feature: F, response: &Response<T, D>) {
        let (all, unsupported) = self.asked.entry(feature.clone()).or_default();
        *all += 1;
        match response {
            Response::Unsupported => *unsupported += 1,
            Response::Image { .. } => {
                self.decoded.insert(feature);
            }
            _ => {}
        }
    }

    /// Returns the features that were never decoded and mostly answered with 69, and the features that were decoded.
    pub fn unsupported_and_decoded(self) -> (BTreeSet<F>, BTreeSet<F>) {
        let FeatureTally { asked, decoded } = self;
        let unsupported = asked
            .into_iter()
            .filter(|(feature, (all, unsupported))| {
                *unsupported * 2 > *all && !decoded.contains(feature)
            })
            .map(|(feature, _)| feature)
            .collect();
        (unsupported, decoded)
    }
}
