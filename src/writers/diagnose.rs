//! From wrong files to causes: which mistake of a writer makes just these files.
//!
//! A mistake explains a file if a reader who makes it has the right values of it, or if the file has what such a reader
//! makes of the right one. It is contradicted by every request that was carried out rightly and that a writer with this
//! mistake gets wrong. The one that explains most goes first, those with more contradictions than explanations last, and
//! then the next for what is left; then pairs of mistakes; what is then left is put into words.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use crate::diagnose::{Category, Cause, Diagnosis, composable};
use crate::kit::parallel::in_parallel;
use crate::misreadings::Misreading;
use crate::misreadings::writing::{self, Miswriting};
use crate::ptm::Format;
use crate::session::observation::Response;
use crate::session::outcome::Outcome;
use crate::session::run::Run;
use crate::suite::cases::Suite;
use crate::suite::test_case::TestCase;
use crate::writers::cases::WriterCase;
use crate::writers::fault::WriterFault;
use crate::writers::reference::written;
use crate::writers::request::WriteRequest;
use crate::writers::seen::SeenFile;
use crate::writers::wrong;

/// Larger files are not searched.
const SEARCHED: usize = 100_000;

/// So many of the smallest wrong files of each format are held against every mistake.
const SCREENED: usize = 3;

/// So many of the smallest files without a cause are held against pairs of mistakes.
const IN_PAIRS: usize = 4;

/// A cause of a writer's failures.
type WriterDiagnosis = Diagnosis<&'static Misreading>;

/// A request that was carried out, rightly or not.
struct Exhibit {
    /// Its place in the suite.
    place: usize,
    request: WriteRequest,
    /// The reference's file.
    right: Vec<u8>,
    /// The file, if it is wrong.
    wrong: Option<Vec<u8>>,
}

/// A mistake that might be made.
struct Candidate {
    mistake: &'static Miswriting,
    /// Places of the suite.
    explains: Vec<usize>,
    /// Right files that it would have got wrong, by their places.
    contradicted: Vec<usize>,
}

/// Why the failures of `run` failed; most telling first.
#[must_use]
pub fn diagnose(
    suite: &Suite<WriterCase>,
    run: &Run<WriterCase>,
    threads: usize,
) -> Vec<WriterDiagnosis> {
    let mut failing: Vec<usize> = run.judgement.with(Outcome::Fail).collect();
    if failing.is_empty() {
        return Vec::new();
    }
    let exhibits = exhibits(suite, run, threads);
    let mut diagnoses = single(&exhibits, threads, &mut failing);
    diagnoses.extend(pairs(&exhibits, threads, &mut failing));
    diagnoses.extend(described(suite, run, &failing));
    diagnoses
}

/// All files that can be searched.
fn exhibits(suite: &Suite<WriterCase>, run: &Run<WriterCase>, threads: usize) -> Vec<Exhibit> {
    let passing: Vec<usize> = run.judgement.with(Outcome::Pass).collect();
    let exhibit = |place: usize| {
        let observation = run.observations[place].as_ref()?;
        let Response::Picture { frame, .. } = &observation.response else {
            return None;
        };
        let wrong = frame.as_ref().map(|file| file.0.clone());
        if wrong.is_none() && !passing.contains(&place) {
            return None;
        }
        let request = suite.cases[place].request();
        let right = written(&request).ok()?;
        let longest = right.len().max(wrong.as_ref().map_or(0, Vec::len));
        (longest <= SEARCHED).then_some(Exhibit {
            place,
            request,
            right,
            wrong,
        })
    };
    let exhibits = in_parallel(suite.cases.len(), threads, &|_, _| (), &exhibit);
    exhibits.into_iter().flatten().collect()
}

impl Exhibit {
    /// Whether the wrong file is one of a writer with this mistake.
    fn is_of(&self, mistake: &Misreading) -> bool {
        let wrong = self.wrong.as_ref();
        wrong.is_some_and(|file| wrong::explains(&self.request, &self.right, file, mistake))
    }

    /// Whether a writer with this mistake gets the request wrong, which was carried out rightly.
    fn contradicts(&self, mistake: &Misreading) -> bool {
        let is_right = |seen: SeenFile| seen.is_right(&self.request);
        self.wrong.is_none() && !SeenFile::of(&self.right, &[mistake]).is_some_and(is_right)
    }
}

/// The smallest wrong files of each format, which show soon what is no cause.
fn screen(exhibits: &[Exhibit]) -> Vec<&Exhibit> {
    let mut wrong: Vec<&Exhibit> = exhibits.iter().filter(|of| of.wrong.is_some()).collect();
    wrong.sort_by_key(|exhibit| exhibit.right.len());
    let mut of_format: BTreeMap<Format, usize> = BTreeMap::new();
    wrong.retain(|exhibit| {
        let count = of_format.entry(exhibit.request.format).or_default();
        *count += 1;
        *count <= SCREENED
    });
    wrong
}

/// The fewest single mistakes that explain the failures, as far as they do.
fn single(exhibits: &[Exhibit], threads: usize, failing: &mut Vec<usize>) -> Vec<WriterDiagnosis> {
    let mistakes: Vec<&'static Miswriting> = writing::all().collect();
    let screen = screen(exhibits);
    let candidate = |i: usize| {
        let mistake = mistakes[i];
        if !screen.iter().any(|exhibit| exhibit.is_of(mistake.at)) {
            return None;
        }
        let places = |these: fn(&Exhibit, &Misreading) -> bool| {
            let these = exhibits.iter().filter(|one| these(one, mistake.at));
            these.map(|exhibit| exhibit.place).collect()
        };
        Some(Candidate {
            mistake,
            explains: places(Exhibit::is_of),
            contradicted: places(Exhibit::contradicts),
        })
    };
    let found = in_parallel(mistakes.len(), threads, &|_, _| (), &candidate);
    let mut candidates: Vec<Candidate> = found.into_iter().flatten().collect();
    let mut diagnoses = Vec::new();
    loop {
        for candidate in &mut candidates {
            candidate.explains.retain(|place| failing.contains(place));
        }
        candidates.retain(|candidate| !candidate.explains.is_empty());
        let Some(best) = (0..candidates.len()).min_by_key(|&at| candidates[at].rank()) else {
            return diagnoses;
        };
        let best = candidates.remove(best);
        let is_alike = |other: &&Candidate| {
            other.explains == best.explains && other.contradicted == best.contradicted
        };
        let alike = candidates
            .iter()
            .filter(is_alike)
            .map(|other| other.mistake)
            .collect();
        failing.retain(|place| !best.explains.contains(place));
        diagnoses.push(Diagnosis {
            certain: best.contradicted.is_empty(),
            except: best.contradicted,
            ..of_mistakes(best.mistake, alike, Vec::new(), best.explains)
        });
    }
}

impl Candidate {
    /// Its place among others: the smallest goes first.
    fn rank(&self) -> impl Ord + use<> {
        let (explained, contradicted) = (self.explains.len(), self.contradicted.len());
        (explained <= contradicted, Reverse(explained), contradicted)
    }
}

/// Two mistakes together, for files that none explains alone.
fn pairs(exhibits: &[Exhibit], threads: usize, failing: &mut Vec<usize>) -> Vec<WriterDiagnosis> {
    let mistakes: Vec<&'static Miswriting> = writing::all().collect();
    let mut diagnoses = Vec::new();
    for _ in 0..2 {
        let mut left: Vec<&Exhibit> = exhibits
            .iter()
            .filter(|exhibit| exhibit.wrong.is_some() && failing.contains(&exhibit.place))
            .collect();
        left.sort_by_key(|exhibit| exhibit.right.len());
        let found = left.iter().take(IN_PAIRS).find_map(|exhibit| {
            let with_first = |i: usize| {
                let second = (i + 1..mistakes.len()).find(|&j| {
                    composable(mistakes[i].at, mistakes[j].at)
                        && exhibit.is_right_under(&[mistakes[i].at, mistakes[j].at])
                });
                second.map(|j| (mistakes[i], mistakes[j]))
            };
            let found = in_parallel(mistakes.len(), threads, &|_, _| (), &with_first);
            found.into_iter().flatten().next()
        });
        let Some((first, second)) = found else { break };
        let of_both = left
            .iter()
            .filter(|exhibit| exhibit.is_right_under(&[first.at, second.at]));
        let explains: Vec<usize> = of_both.map(|exhibit| exhibit.place).collect();
        failing.retain(|place| !explains.contains(place));
        diagnoses.push(of_mistakes(first, Vec::new(), vec![second], explains));
    }
    diagnoses
}

impl Exhibit {
    /// Whether a reader with these mistakes has the right values of the wrong file.
    fn is_right_under(&self, mistakes: &[&Misreading]) -> bool {
        let wrong = self.wrong.as_ref();
        wrong.is_some_and(|file| wrong::is_right_under(&self.request, file, mistakes))
    }
}

fn of_mistakes(
    misreading: &'static Miswriting,
    alike: Vec<&'static Miswriting>,
    with: Vec<&'static Miswriting>,
    explains: Vec<usize>,
) -> WriterDiagnosis {
    Diagnosis {
        cause: Cause::Misreading {
            misreading,
            alike,
            with,
        },
        explains,
        partly: Vec::new(),
        except: Vec::new(),
        shows: None,
        certain: true,
    }
}

/// What no mistake of the catalog makes, by the clause that it is about.
pub(super) fn described<C: TestCase<Difference = WriterFault>>(
    suite: &Suite<C>,
    run: &Run<C>,
    failing: &[usize],
) -> Vec<WriterDiagnosis> {
    let mut groups: BTreeMap<&str, Vec<(usize, &WriterFault)>> = BTreeMap::new();
    for &place in failing {
        let observation = run.observations[place].as_ref();
        if let Some(Response::Picture {
            difference: Some(fault),
            ..
        }) = observation.map(|observation| &observation.response)
        {
            groups
                .entry(&fault.clause)
                .or_default()
                .push((place, fault));
        }
    }
    let mut diagnoses: Vec<WriterDiagnosis> = groups
        .into_iter()
        .map(|(clause, faults)| {
            let (effect, fix) = words_of(clause, faults[0].1);
            let (place, fault) = faults[0];
            let cause = Cause::Described {
                category: Category::Difference,
                clause: clause.to_owned(),
                effect: effect.to_owned(),
                fix: fix.to_owned(),
                example: format!("for example {}: {fault}", suite.cases[place].id()),
                alike: Vec::new(),
            };
            Diagnosis {
                cause,
                explains: faults.iter().map(|&(place, _)| place).collect(),
                partly: Vec::new(),
                except: Vec::new(),
                shows: None,
                certain: false,
            }
        })
        .collect();
    diagnoses.sort_by_key(|diagnosis| Reverse(diagnosis.explains.len()));
    diagnoses
}

/// What a writer does whose files differ in a clause, and what to do about it.
const OF_CLAUSES: [(&str, (&str, &str)); 9] = [
    (
        "1.0/1",
        (
            "fits the pictures worse than they can be fitted",
            "look at the pictures under the light of the example",
        ),
    ),
    (
        "2.2/1",
        (
            "writes another format than it is asked for",
            "write the format of the request, or exit with 69",
        ),
    ),
    (
        "2.3/1",
        (
            "writes another size than it is asked for",
            "write the width, then the height",
        ),
    ),
    (
        "2.4/3",
        (
            "writes other scales than it is asked for",
            "write all digits of the six scales, in the order of the coefficients",
        ),
    ),
    (
        "2.4/4",
        (
            "writes other biases than it is asked for",
            "write the six biases as they are, whatever their sign and size",
        ),
    ),
    (
        "2.6/2",
        (
            "writes another matrix than it is asked for",
            "write the sixteen numbers in the order of the request, with all their digits",
        ),
    ),
    (
        "2.9.1/1",
        (
            "loses more than the compression parameter allows, or writes another one",
            "predict from the planes that a decoder has, and encode with the parameter of the request",
        ),
    ),
    (
        "2.9.8/4",
        (
            "writes no side information where the loss wraps around",
            "after each plane, write a record for every texel that the loss takes past the end of the scale",
        ),
    ),
    (
        "2.9.8/8",
        (
            "writes wrong values into side information",
            "write the value that the texel should have",
        ),
    ),
];

/// What a writer does whose files differ in this clause, and what to do about it.
fn words_of(clause: &str, fault: &WriterFault) -> (&'static str, &'static str) {
    if fault.says.starts_with("the reference refuses") {
        return (
            "writes files that no reader can decode",
            "look at the byte that the example names",
        );
    }
    let other = (
        "writes other values than it is asked for",
        "see where the values of the example lie in the file",
    );
    let known = OF_CLAUSES.iter().find(|(of, _)| *of == clause);
    known.map_or(other, |(_, words)| *words)
}
