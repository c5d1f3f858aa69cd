//! From findings to verdicts.
//!
//! A finding is what one request showed. What it means depends on others: a file that must be refused proves nothing
//! where its accepted twin was not decoded; "unsupported" is honest only of a whole feature; a reading of an open
//! question must be the same everywhere. All of that is decided here, from findings alone.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use crate::harness::cases::{Case, Expect, Feature, Suite};
use crate::harness::choices::{Axis, CHOICES, Choice, Dialect, combinations};
use crate::harness::compare::Difference;
use crate::harness::protocol::{Answer, Frame, View};
use crate::ptm::Format;

/// What one request showed.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The view that was asked for.
    pub view: View,
    /// What the decoder did.
    pub shown: Shown,
    /// Whether it is a refusal by an exit status that also means something else.
    pub weak: bool,
    /// The beginning of its standard error.
    pub stderr: String,
    /// The case that the same process was asked before, where it serves.
    pub after: Option<String>,
    /// How two answers to this request differ, if it was asked for twice and they do.
    pub unsteady: Option<Unsteady>,
}

/// Two answers to one request.
#[derive(Clone, Debug)]
pub struct Unsteady {
    /// Whether one of them is of a serving process.
    pub served: bool,
    /// How they differ.
    pub says: String,
}

/// An answer, held against what was expected.
#[derive(Clone, Debug)]
pub enum Shown {
    /// A picture.
    Picture {
        /// Where it is right: in every dialect, or in some.
        right: Right,
        /// How it differs from the reference's, if it does and there is one.
        difference: Option<Difference>,
        /// Whether it is right only because inverse DCTs may differ (ruling `jpeg-samples`).
        another_transform: bool,
        /// The picture itself where it differs.
        frame: Option<Frame>,
    },
    /// Exit status 65.
    Rejected,
    /// Exit status 69.
    Unsupported,
    /// Anything else.
    Misconduct(Answer),
}

impl Shown {
    /// Whether it is the same in all that a decoder is responsible for.
    #[must_use]
    pub fn is_like(&self, other: &Shown) -> bool {
        match (self, other) {
            (
                Shown::Picture { right, frame, .. },
                Shown::Picture {
                    right: other_right,
                    frame: other_frame,
                    ..
                },
            ) => {
                let alike = match (frame, other_frame) {
                    (Some(a), Some(b)) => a.is_like(b),
                    (a, b) => a.is_none() && b.is_none(),
                };
                right == other_right && alike
            }
            (Shown::Misconduct(a), Shown::Misconduct(b)) => a.is_like(b),
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }

    /// What it is, in words.
    #[must_use]
    pub fn describe(&self) -> String {
        match self {
            Shown::Picture {
                difference: Some(difference),
                ..
            } => format!("a wrong picture ({difference})"),
            Shown::Picture { .. } => "a picture".to_owned(),
            Shown::Rejected => "a refusal".to_owned(),
            Shown::Unsupported => "\"unsupported\"".to_owned(),
            Shown::Misconduct(answer) => {
                format!(
                    "{}: {}",
                    answer.name(),
                    answer.misconduct().unwrap_or_default()
                )
            }
        }
    }

    /// One or two words for a report.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Shown::Picture { .. } => "decoded",
            Shown::Rejected => "rejected",
            Shown::Unsupported => "unsupported",
            Shown::Misconduct(answer) => answer.name(),
        }
    }
}

/// In which dialects a picture is right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Right {
    /// In all or none: no choice shows in the file.
    Anyway(bool),
    /// Some choices show in the file, and it depends on them alone.
    In {
        /// The choices.
        axes: Vec<Axis>,
        /// Of [`combinations`] of these axes, those in which it is right.
        combinations: Vec<bool>,
    },
}

/// What is said of a case.
#[derive(Clone, Debug)]
pub struct Judged {
    /// The view that was asked for; nothing if none was.
    pub view: Option<View>,
    /// The verdict.
    pub outcome: Outcome,
    /// Why, in a sentence; empty where there is nothing to say.
    pub says: String,
}

/// The verdict on a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Outcome {
    /// As it should be.
    Pass,
    /// Not as it should be.
    Fail,
    /// The accepted twin was not decoded, so this proves nothing.
    Inconclusive,
    /// The decoder does not do this kind of file, and says so everywhere.
    Unsupported,
    /// A legal spelling or reading that this decoder does not follow; it follows another.
    OtherDialect,
    /// As a mistake has it that the user takes as given.
    Assumed,
    /// None of the case's views is offered.
    NotJudged,
    /// The run ended before.
    NotRun,
}

impl Outcome {
    /// All, in the order in which they are counted for people.
    pub const ALL: [Outcome; 8] = [
        Outcome::Pass,
        Outcome::Fail,
        Outcome::Unsupported,
        Outcome::Inconclusive,
        Outcome::OtherDialect,
        Outcome::Assumed,
        Outcome::NotJudged,
        Outcome::NotRun,
    ];

    /// As it stands in a report.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Outcome::Pass => "pass",
            Outcome::Fail => "fail",
            Outcome::Inconclusive => "inconclusive",
            Outcome::Unsupported => "unsupported",
            Outcome::OtherDialect => "other dialect",
            Outcome::Assumed => "as assumed",
            Outcome::NotJudged => "not judged",
            Outcome::NotRun => "not run",
        }
    }
}

/// What a decoder offers.
#[derive(Clone, Debug, Default)]
pub struct Offer {
    /// The views, best first.
    pub views: Vec<&'static str>,
    /// Views that it lacks of a format which it shows in others.
    pub lacking: Vec<(&'static str, Format)>,
    /// The formats that it declares to read.
    pub declared: Vec<Format>,
}

impl Offer {
    /// Whether it shows files of this format in other views only.
    #[must_use]
    pub fn lacks(&self, view: &View, format: Format) -> bool {
        self.lacking.contains(&(view.name(), format))
    }

    /// The first of the case's views that is offered, of files of its format if there is such a one.
    #[must_use]
    pub fn chosen_view<'a>(&self, case: &'a Case) -> Option<&'a View> {
        let offered = |view: &&View| self.views.contains(&view.name());
        let mut views = case.views.iter().filter(offered);
        views
            .clone()
            .find(|view| !self.lacks(view, case.format()))
            .or_else(|| views.next())
    }
}

/// What is said of a decoder.
#[derive(Clone, Debug)]
pub struct Judgement {
    /// One for each case of the suite; nothing for those that were not selected.
    pub cases: Vec<Option<Judged>>,
    /// How it reads the open questions: ruling and reading; nothing where no case showed it.
    pub dialect: Vec<(&'static str, Option<&'static str>)>,
    /// Features that every file needing them was answered 69.
    pub unsupported: BTreeSet<Feature>,
    /// Features of which a file was decoded.
    pub decoded: BTreeSet<Feature>,
}

/// Judges the findings of a run. `findings` has a place for each case of the suite; nothing where none of its views is
/// offered. `selected` says which cases are to be judged; the others only serve as twins.
#[must_use]
pub fn judge(
    suite: &Suite,
    selected: &[bool],
    findings: &[Option<Finding>],
    offer: &Offer,
) -> Judgement {
    let places: HashMap<&str, usize> = suite
        .cases
        .iter()
        .enumerate()
        .map(|(i, case)| (case.id.as_str(), i))
        .collect();
    let spoken = spoken(findings);
    let dialect = dialect(&spoken);
    let (unsupported, decoded) = features(suite, findings, offer);
    let spelling_known = suite.cases.iter().zip(findings).any(|(case, finding)| {
        case.expect == Expect::Spelling
            && finding
                .as_ref()
                .is_some_and(|finding| is_right(finding, &dialect))
    });
    let one = |i: usize| -> Judged {
        let case = &suite.cases[i];
        let Some(finding) = &findings[i] else {
            return Judged {
                view: None,
                outcome: Outcome::NotJudged,
                says: "none of its views is offered".to_owned(),
            };
        };
        let twin = case
            .twin_of
            .as_ref()
            .and_then(|twin| findings[places[twin.as_str()]].as_ref());
        let (outcome, says) = verdict(case, finding, twin, &dialect, &unsupported, spelling_known);
        let (outcome, says) = honest(outcome, says, case, finding, offer, &unsupported);
        Judged {
            view: Some(finding.view.clone()),
            outcome,
            says,
        }
    };
    let cases = (0..suite.cases.len())
        .map(|i| selected[i].then(|| one(i)))
        .collect();
    Judgement {
        cases,
        dialect: describe(&spoken),
        unsupported,
        decoded,
    }
}

/// Whether a legal file was answered 69, each time it was asked for.
fn steadily_69(case: &Case, finding: &Finding) -> bool {
    matches!(finding.shown, Shown::Unsupported)
        && case.expect == Expect::Decode
        && finding.unsteady.is_none()
}

/// Whether it was answered 69 as every file of a format is that the decoder declares to read.
pub(in crate::harness) fn breaks_promise(
    case: &Case,
    finding: &Finding,
    offer: &Offer,
    unsupported: &BTreeSet<Feature>,
) -> bool {
    steadily_69(case, finding)
        && offer.declared.contains(&case.format())
        && unsupported.contains(&Feature::Format(case.format()))
}

/// What remains of a verdict if "unsupported" is held against what is offered.
fn honest(
    outcome: Outcome,
    says: String,
    case: &Case,
    finding: &Finding,
    offer: &Offer,
    unsupported: &BTreeSet<Feature>,
) -> (Outcome, String) {
    let format = case.format();
    if !steadily_69(case, finding) {
        (outcome, says)
    } else if breaks_promise(case, finding, offer, unsupported) {
        let says = format!(
            "its capabilities declare {format}, and it answers 69 (unsupported) to all such files"
        );
        (Outcome::Fail, says)
    } else if offer.lacks(&finding.view, format) {
        (Outcome::Unsupported, String::new())
    } else {
        (outcome, says)
    }
}

fn verdict(
    case: &Case,
    finding: &Finding,
    twin: Option<&Finding>,
    dialect: &Dialect,
    unsupported: &BTreeSet<Feature>,
    spelling_known: bool,
) -> (Outcome, String) {
    use Outcome::{Fail, Inconclusive, OtherDialect, Pass, Unsupported};
    let fail = |says: String| (Fail, says);
    let pass = (Pass, String::new());
    if let Some(how) = &finding.unsteady {
        return fail(how.says.clone());
    }
    // Negative cases stand on their accepted twin.
    let twin_decoded = matches!(
        twin,
        Some(Finding {
            shown: Shown::Picture { .. },
            ..
        })
    );
    if let (Some(id), false) = (&case.twin_of, twin_decoded) {
        return (Inconclusive, format!("its twin {id} was not decoded"));
    }
    let twin_right = twin.is_none_or(|twin| is_right(twin, dialect));
    match (&finding.shown, case.expect) {
        (Shown::Misconduct(answer), _) => fail(format!(
            "{}: {}",
            answer.name(),
            answer.misconduct().unwrap_or_default()
        )),
        (Shown::Rejected, Expect::Reject | Expect::Refuse | Expect::Lenient | Expect::Spelling) => {
            pass
        }
        (Shown::Unsupported, Expect::Refuse | Expect::Lenient | Expect::Spelling) => pass,
        (Shown::Unsupported, Expect::Reject) => {
            fail("answered 69 (unsupported) to a malformed file of a kind it decodes".to_owned())
        }
        (Shown::Picture { .. }, Expect::Reject | Expect::Refuse) => fail(format!(
            "accepted a file that must be refused: {}",
            fault(case)
        )),
        (Shown::Rejected, Expect::Decode) => fail("refused a legal file".to_owned()),
        (Shown::Unsupported, Expect::Decode) => {
            if case.features(&finding.view).is_disjoint(unsupported) {
                fail("answered 69 (unsupported), but decodes other files of this kind".to_owned())
            } else {
                (Unsupported, String::new())
            }
        }
        (
            Shown::Picture {
                difference, right, ..
            },
            expect,
        ) => {
            if is_right(finding, dialect) {
                return pass;
            }
            let differs = difference
                .as_ref()
                .map(ToString::to_string)
                .unwrap_or_default();
            match (expect, right) {
                (Expect::Spelling, _) if spelling_known => (OtherDialect, String::new()),
                (Expect::Lenient, _) if !twin_right => {
                    (Inconclusive, "its twin was decoded wrongly".to_owned())
                }
                (_, Right::In { combinations, .. }) if combinations.contains(&true) => fail(
                    format!("mixes readings: elsewhere it follows another one. {differs}"),
                ),
                _ => fail(differs),
            }
        }
    }
}

/// What is wrong with a file that must be refused.
fn fault(case: &Case) -> &str {
    case.damage().map_or(&case.because, |damage| damage.effect)
}

fn is_right(finding: &Finding, dialect: &Dialect) -> bool {
    match &finding.shown {
        Shown::Picture {
            right: Right::Anyway(right),
            ..
        } => *right,
        Shown::Picture {
            right: Right::In { axes, combinations },
            ..
        } => combinations[dialect.place(axes)],
        _ => false,
    }
}

/// What the pictures show of choices that some file shows together: an answer for these axes and for no other.
struct Spoken {
    axes: Vec<Axis>,
    /// The combinations of these axes in which most pictures are right, the nearest to the reference's first; all of them
    /// where there is no evidence.
    best: Vec<Dialect>,
    /// Whether there is any.
    evidence: bool,
}

/// The evidence of the dialect, group by group.
///
/// Choices that no file shows together are independent: the pictures right in a dialect are the sum over the groups, so
/// most are right where most are right in every group, and nobody has to look at all dialects.
fn spoken(findings: &[Option<Finding>]) -> Vec<Spoken> {
    let shown: Vec<(&[Axis], &[bool])> = findings
        .iter()
        .flatten()
        .filter(|finding| finding.unsteady.is_none())
        .filter_map(|finding| match &finding.shown {
            Shown::Picture {
                right: Right::In { axes, combinations },
                ..
            } => Some((&axes[..], &combinations[..])),
            _ => None,
        })
        .collect();
    let one = |axes: Vec<Axis>| {
        let all = combinations(&axes);
        let about: Vec<_> = shown
            .iter()
            .filter(|(of, _)| of.iter().any(|axis| axes.contains(axis)))
            .collect();
        let right_in = |dialect: &Dialect| {
            about
                .iter()
                .filter(|(of, right)| right[dialect.place(of)])
                .count()
        };
        let counts: Vec<usize> = all.iter().map(right_in).collect();
        let most = counts.iter().max().copied().unwrap_or_default();
        let best = all
            .into_iter()
            .zip(counts)
            .filter(|&(_, count)| count == most)
            .map(|(dialect, _)| dialect)
            .collect();
        Spoken {
            axes,
            best,
            evidence: most > 0,
        }
    };
    groups(shown.iter().map(|&(axes, _)| axes))
        .into_iter()
        .map(one)
        .collect()
}

/// The choices, parted so that those which stand together in any of `together` stand together.
fn groups<'a>(together: impl Iterator<Item = &'a [Axis]>) -> Vec<Vec<Axis>> {
    let mut groups: Vec<Vec<Axis>> = (0..CHOICES.len()).map(|axis| vec![axis]).collect();
    for axes in together {
        let (joined, apart): (Vec<_>, Vec<_>) = groups
            .into_iter()
            .partition(|group| group.iter().any(|axis| axes.contains(axis)));
        let mut joined = joined.concat();
        joined.sort_unstable();
        groups = apart;
        groups.extend((!joined.is_empty()).then_some(joined));
    }
    groups
}

/// The dialect in which most pictures are right; among equals the one nearest to the reference's.
fn dialect(spoken: &[Spoken]) -> Dialect {
    let mut dialect = Dialect::reference();
    for group in spoken {
        for &axis in &group.axes {
            dialect.0[axis] = group.best[0].0[axis];
        }
    }
    dialect
}

/// Each choice with the reading taken, if the evidence tells it from every other.
fn describe(spoken: &[Spoken]) -> Vec<(&'static str, Option<&'static str>)> {
    let one = |(axis, choice): (Axis, &Choice)| {
        let group = spoken
            .iter()
            .find(|group| group.axes.contains(&axis))
            .expect("every axis is in a group");
        let taken = group.best[0].0[axis];
        let settled = group.evidence && group.best.iter().all(|other| other.0[axis] == taken);
        (choice.ruling, settled.then(|| choice.readings[taken].0))
    };
    CHOICES.iter().enumerate().map(one).collect()
}

/// Features that every must-accept file needing them was answered 69, and those that were decoded.
fn features(
    suite: &Suite,
    findings: &[Option<Finding>],
    offer: &Offer,
) -> (BTreeSet<Feature>, BTreeSet<Feature>) {
    let mut all_unsupported: BTreeMap<Feature, bool> = BTreeMap::new();
    let mut decoded = BTreeSet::new();
    for (case, finding) in suite.cases.iter().zip(findings) {
        let (Some(finding), Expect::Decode) = (finding, case.expect) else {
            continue;
        };
        for feature in case.features(&finding.view) {
            let unsupported = matches!(finding.shown, Shown::Unsupported);
            // That it lacks this view of this format says nothing of the format.
            if unsupported
                && feature == Feature::Format(case.format())
                && offer.lacks(&finding.view, case.format())
            {
                continue;
            }
            all_unsupported
                .entry(feature.clone())
                .and_modify(|all| *all &= unsupported)
                .or_insert(unsupported);
            if matches!(finding.shown, Shown::Picture { .. }) {
                decoded.insert(feature);
            }
        }
    }
    (
        all_unsupported
            .into_iter()
            .filter(|&(_, all)| all)
            .map(|(feature, _)| feature)
            .collect(),
        decoded,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::harness::choices::axes;

    /// A picture that is right in the combinations of `rulings` that `right` names, by its readings on them.
    fn shown(rulings: &[&str], right: impl Fn(&[usize]) -> bool) -> Option<Finding> {
        let axes = axes(rulings);
        let on = |dialect: &Dialect| {
            right(&axes.iter().map(|&axis| dialect.0[axis]).collect::<Vec<_>>())
        };
        let combinations = combinations(&axes).iter().map(on).collect();
        let right = Right::In { axes, combinations };
        Some(Finding {
            view: View::Raw,
            shown: Shown::Picture {
                right,
                difference: None,
                another_transform: false,
                frame: None,
            },
            weak: false,
            stderr: String::new(),
            after: None,
            unsteady: None,
        })
    }

    fn said(findings: &[Option<Finding>]) -> Vec<(&'static str, usize)> {
        let spoken = spoken(findings);
        let settled = describe(&spoken).into_iter().zip(dialect(&spoken).0);
        settled
            .filter_map(|((ruling, said), reading)| said.map(|_| (ruling, reading)))
            .collect()
    }

    #[test]
    fn without_evidence_the_dialect_is_the_references() {
        assert_eq!(dialect(&spoken(&[])), Dialect::reference());
        assert_eq!(said(&[]), []);
    }

    #[test]
    fn groups_that_no_file_joins_are_settled_apart() {
        let findings = [
            shown(&["motion-sign", "motion-border"], |of| of == [1, 2]),
            shown(&["side-lossless"], |of| of == [1]),
            None,
        ];
        assert_eq!(
            said(&findings),
            [
                ("motion-sign", 1),
                ("motion-border", 2),
                ("side-lossless", 1)
            ]
        );
        assert_eq!(
            dialect(&spoken(&findings)).0,
            [0, 0, 0, 0, 1, 0, 0, 2, 0, 1]
        );
    }

    #[test]
    fn files_that_share_a_choice_join_their_groups() {
        // Alone, the first says "one of both is read otherwise"; the second says which.
        let findings = [
            shown(&["motion-sign", "jpeg-ls-offset"], |of| {
                of.iter().sum::<usize>() == 1
            }),
            shown(&["jpeg-ls-offset", "side-lossless"], |of| of[0] == 0),
        ];
        assert_eq!(said(&findings[..1]), []);
        assert_eq!(said(&findings), [("motion-sign", 1), ("jpeg-ls-offset", 0)]);
    }

    #[test]
    fn the_reading_of_most_pictures_counts_and_ties_go_to_the_references() {
        let other = || shown(&["motion-half"], |of| of == [1]);
        let reference = || shown(&["motion-half"], |of| of == [0]);
        assert_eq!(said(&[other(), other(), reference()]), [("motion-half", 1)]);
        let tie = [other(), reference()];
        assert_eq!(said(&tie), []);
        assert_eq!(dialect(&spoken(&tie)), Dialect::reference());
        assert!(!is_right(tie[0].as_ref().unwrap(), &Dialect::reference()));
    }
}
