//! From findings to verdicts.
//!
//! A finding is what one request showed. What it means depends on others: a file that must be refused proves nothing
//! where its accepted twin was not decoded; "unsupported" is honest only of a whole feature; a reading of an open
//! question must be the same everywhere. All of that is decided here, from findings alone.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use crate::harness::cases::{Case, Expect, Feature, Suite};
use crate::harness::choices::{CHOICES, Dialect};
use crate::harness::compare::Difference;
use crate::harness::protocol::{Answer, Frame, View};

/// What one request showed.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The view that was asked for.
    pub view: View,
    /// What the decoder did.
    pub shown: Shown,
    /// The beginning of its standard error.
    pub stderr: String,
}

/// An answer, held against what was expected.
#[derive(Clone, Debug)]
pub enum Shown {
    /// A picture.
    Picture {
        /// Where it is right: in every dialect, or in these of [`Dialect::all`].
        right: Right,
        /// How it differs from the reference's, if it does and there is one.
        difference: Option<Difference>,
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
    /// In those of [`Dialect::all`] that are marked.
    In(Vec<bool>),
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
    /// None of the case's views is offered.
    NotJudged,
    /// The run ended before.
    NotRun,
}

impl Outcome {
    /// As it stands in a report.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Outcome::Pass => "pass",
            Outcome::Fail => "fail",
            Outcome::Inconclusive => "inconclusive",
            Outcome::Unsupported => "unsupported",
            Outcome::OtherDialect => "other dialect",
            Outcome::NotJudged => "not judged",
            Outcome::NotRun => "not run",
        }
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
pub fn judge(suite: &Suite, selected: &[bool], findings: &[Option<Finding>]) -> Judgement {
    let places: HashMap<&str, usize> = suite
        .cases
        .iter()
        .enumerate()
        .map(|(i, case)| (case.id.as_str(), i))
        .collect();
    let dialect = dialect(findings);
    let (unsupported, decoded) = features(suite, findings);
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
        dialect: describe(findings, &dialect),
        unsupported,
        decoded,
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
                (_, Right::In(dialects)) if dialects.contains(&true) => fail(format!(
                    "mixes readings: elsewhere it follows another one. {differs}"
                )),
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
            right: Right::In(right),
            ..
        } => Dialect::all()
            .iter()
            .position(|known| known == dialect)
            .is_some_and(|place| right[place]),
        _ => false,
    }
}

/// The evidence of a dialect: how many pictures are right in each.
fn evidence(findings: &[Option<Finding>]) -> Vec<usize> {
    let mut counts = vec![0; Dialect::all().len()];
    for finding in findings.iter().flatten() {
        if let Shown::Picture {
            right: Right::In(right),
            ..
        } = &finding.shown
        {
            for (count, &right) in counts.iter_mut().zip(right) {
                *count += usize::from(right);
            }
        }
    }
    counts
}

/// The dialect in which most pictures are right; among equals the one nearest to the reference's.
fn dialect(findings: &[Option<Finding>]) -> Dialect {
    let counts = evidence(findings);
    let most = counts.iter().max().copied().unwrap_or_default();
    let place = counts
        .iter()
        .position(|&count| count == most)
        .unwrap_or_default();
    Dialect::all().swap_remove(place)
}

/// Each choice with the reading taken, if the evidence tells it from every other.
fn describe(
    findings: &[Option<Finding>],
    dialect: &Dialect,
) -> Vec<(&'static str, Option<&'static str>)> {
    let counts = evidence(findings);
    let all = Dialect::all();
    let most = counts.iter().max().copied().unwrap_or_default();
    let best: Vec<&Dialect> = all
        .iter()
        .zip(&counts)
        .filter(|&(_, &count)| count == most)
        .map(|(dialect, _)| dialect)
        .collect();
    let settled = |i: usize| most > 0 && best.iter().all(|other| other.0[i] == dialect.0[i]);
    let one = |(i, choice): (usize, &crate::harness::choices::Choice)| {
        (
            choice.ruling,
            settled(i).then(|| choice.readings[dialect.0[i]].0),
        )
    };
    CHOICES.iter().enumerate().map(one).collect()
}

/// Features that every must-accept file needing them was answered 69, and those that were decoded.
fn features(suite: &Suite, findings: &[Option<Finding>]) -> (BTreeSet<Feature>, BTreeSet<Feature>) {
    let mut all_unsupported: BTreeMap<Feature, bool> = BTreeMap::new();
    let mut decoded = BTreeSet::new();
    for (case, finding) in suite.cases.iter().zip(findings) {
        let (Some(finding), Expect::Decode) = (finding, case.expect) else {
            continue;
        };
        for feature in case.features(&finding.view) {
            let unsupported = matches!(finding.shown, Shown::Unsupported);
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
