//! From failures to causes: what to mend, in a sentence.
//!
//! First the catalogue: the smallest set of misreadings with which a decoder gives the same answers, the same picture or
//! the same refusal, and which no passing case contradicts. What is then left is put into words: refusals by what the
//! refused files share, acceptances by the damage, pictures by how they differ and where.

mod acceptances;
mod assume;
mod formats;
mod formulas;
mod misconduct;
mod pictures;
mod promises;
mod provenance;
mod refusals;
mod search;
mod streams;
mod traits;
mod unsteady;
mod witness;

pub use assume::assume;
pub use witness::{alike, applies, composable};
pub(crate) use witness::{spoken, stream_once};

use crate::harness::cases::{Expect, Suite};
use crate::harness::check::Run;
use crate::harness::judge::Outcome;
use crate::harness::misreadings::Misreading;
use crate::harness::protocol::View;
use search::Search;
use witness::{Agreement, Witness, witnesses};

/// A cause and what it explains.
pub struct Diagnosis {
    /// What it is.
    pub cause: Cause,
    /// Failing cases it reproduces, by their place in the suite.
    pub explains: Vec<usize>,
    /// Failing cases in which a decoder with this mistake would go wrong too, but not quite in this way.
    pub partly: Vec<usize>,
    /// Passing cases that a decoder with this mistake would fail: the mistake is made, but not everywhere.
    pub except: Vec<usize>,
    /// What is all that shows of it, as a sentence without its subject, where other causes would show alike.
    pub shows: Option<String>,
}

/// What is wrong.
pub enum Cause {
    /// A mistake of the catalogue.
    Misreading {
        /// The mistake.
        misreading: &'static Misreading,
        /// Others that explain the same cases as well.
        alike: Vec<&'static Misreading>,
        /// Others that are made besides, and show in the same cases.
        with: Vec<&'static Misreading>,
    },
    /// A difference that no mistake of the catalogue makes.
    Described {
        /// What kind of failure it is.
        kind: Kind,
        /// The clause that the cases are about.
        clause: String,
        /// What the decoder does, as a sentence without its subject: "refuses …".
        effect: String,
        /// What to do about it.
        mend: String,
        /// The first example, down to the bytes of the file.
        example: String,
    },
}

/// Kinds of failure that are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Legal files were refused, or answered with a crash.
    Refusal,
    /// Malformed files were accepted.
    Acceptance,
    /// Files that must or may be refused ended in a crash, a hang or nonsense.
    Misconduct,
    /// Pictures are wrong.
    Difference,
    /// The same request is answered in two ways.
    Unsteady,
}

impl Kind {
    /// As it stands in a report.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Refusal => "refusal",
            Kind::Acceptance => "acceptance",
            Kind::Misconduct => "misconduct",
            Kind::Difference => "difference",
            Kind::Unsteady => "unsteady",
        }
    }
}

impl Diagnosis {
    /// A cause that explains these places, and no more is known of it.
    fn of(cause: Cause, explains: Vec<usize>) -> Diagnosis {
        Diagnosis {
            cause,
            explains,
            partly: Vec::new(),
            except: Vec::new(),
            shows: None,
        }
    }

    fn described(
        kind: Kind,
        witnesses: &[Witness],
        of: &[usize],
        (effect, mend, example): (String, String, String),
    ) -> Diagnosis {
        Diagnosis::of(
            Cause::Described {
                kind,
                clause: told_by(witnesses, of).unwrap_or_default(),
                effect,
                mend,
                example,
            },
            of.iter().map(|&w| witnesses[w].place).collect(),
        )
    }

    /// The same, about a clause that is known better than by what the cases are about.
    fn about(mut self, known: &str) -> Diagnosis {
        if let Cause::Described { clause, .. } = &mut self.cause {
            known.clone_into(clause);
        }
        self
    }
}

/// The clause that tells these cases from the others: most of them are about it, and few others are.
fn told_by(witnesses: &[Witness], of: &[usize]) -> Option<String> {
    let about = |clause: &String, w: &&usize| witnesses[**w].case.clauses.contains(clause);
    let all: Vec<usize> = (0..witnesses.len()).collect();
    let mut clauses: Vec<&String> = of
        .iter()
        .flat_map(|&w| &witnesses[w].case.clauses)
        .collect();
    clauses.sort();
    clauses.dedup();
    let worth = |clause: &String| {
        let count = |places: &[usize]| places.iter().filter(|w| about(clause, w)).count();
        let (mine, theirs) = (count(of), count(&all));
        (mine * mine * mine) as f64 / theirs as f64
    };
    clauses
        .into_iter()
        .max_by(|a, b| worth(a).total_cmp(&worth(b)).then(b.cmp(a)))
        .cloned()
}

/// Why the failures of `run` failed; most telling first. `assumed` are mistakes that the user knows of. Where the user
/// ends the search, most failures have no cause.
#[must_use]
pub fn diagnose(
    suite: &Suite,
    run: &Run,
    assumed: &[&'static Misreading],
    threads: usize,
) -> Vec<Diagnosis> {
    let mut apart = unsteady::describe(suite, run);
    apart.extend(promises::describe(suite, run));
    let judged = run.judgement.cases.iter().flatten();
    if !judged
        .into_iter()
        .any(|judged| judged.outcome == Outcome::Fail)
    {
        return apart;
    }
    let witnesses = witnesses(suite, run, spoken(run), threads);
    if !witnesses.iter().any(|witness| witness.failed) {
        return apart;
    }
    let search = Search::new(&witnesses, assumed, threads, &run.stop);
    let mut found = search.run();
    if search.is_interrupted() {
        return apart;
    }
    drop_accidents(&search, &mut found);
    drop_chance(&search, &mut found);
    let (mut diagnoses, mut left) = named(&search, &found);
    diagnoses.extend(formats::describe(&witnesses, &mut left));
    diagnoses.extend(acceptances::describe(&witnesses, &mut left));
    let misconduct = misconduct::describe(&witnesses, &mut left);
    let in_streams = streams::describe(&search, &found, &mut left);
    let refusals = refusals::describe(&witnesses, &mut left);
    search_in_part(&search, &found, &mut diagnoses, &mut left);
    diagnoses.extend(in_streams);
    diagnoses.extend(refusals);
    diagnoses.extend(refusals::rest(&witnesses, &mut left));
    diagnoses.extend(misconduct);
    diagnoses.extend(pictures::describe(
        &search,
        &search::of(&found.members),
        &left,
    ));
    diagnoses.extend(apart);
    // What explains most comes first; what is known by name counts more than what is put into words.
    diagnoses.sort_by_key(|diagnosis| {
        let named = matches!(diagnosis.cause, Cause::Misreading { .. });
        let explained = diagnosis.explains.len() + diagnosis.partly.len();
        std::cmp::Reverse(explained * if named { 4 } else { 1 })
    });
    diagnoses
}

/// Takes away mistakes that only refuse, where one thing that the refused files share says more, or where passing cases
/// speak against them: many things end in a refusal.
fn drop_accidents(search: &Search, found: &mut search::Found) {
    let witnesses = search.witnesses;
    let set = search::of(&found.members);
    let failing = failing(witnesses);
    let shared = refusals::widest(witnesses, &failing);
    let explained = search.each(&set, |&misreading| {
        let agreements = failing
            .iter()
            .map(|&w| (w, search.agreement(w, &[misreading])));
        agreements
            .filter(|(_, agreement)| !matches!(agreement, Agreement::None | Agreement::Against))
            .collect::<Vec<(usize, Agreement)>>()
    });
    let by = |member: usize, w: usize| explained[member].iter().any(|&(other, _)| other == w);
    let places: Vec<usize> = (0..set.len()).collect();
    let keep = search.each(&places, |&member| {
        let of = &explained[member];
        let refuses = of
            .iter()
            .all(|(_, agreement)| matches!(agreement, Agreement::Word | Agreement::Crash));
        let less =
            |wide: &Vec<usize>| wide.len() > of.len() && of.iter().all(|(w, _)| wide.contains(w));
        let one = [set[member]];
        let contradicted = || {
            (0..witnesses.len())
                .any(|w| search.contradicted(w, &one) && search.contradicted(w, &set))
        };
        // Refusals that no other mistake explains.
        let refused = failing.iter().filter(|&&w| {
            let others = places.iter().filter(|&&other| other != member);
            refusals::deed_of(&witnesses[w]).is_some() && !others.into_iter().any(|&o| by(o, w))
        });
        // What is no refusal by itself would show a picture somewhere.
        let by_chance =
            !set[member].effect.starts_with("refuses") && of.len() * 3 < refused.count();
        of.is_empty() || !refuses || !by_chance && !shared.iter().any(less) && !contradicted()
    });
    found.keep(&keep);
}

/// Where passing cases speak against the mistakes found, takes away those that explain fewer pictures than one wrong number
/// in a formula: colors are rounded, and some agree by chance.
fn drop_chance(search: &Search, found: &mut search::Found) {
    let witnesses = search.witnesses;
    let set = search::of(&found.members);
    let all: Vec<usize> = (0..witnesses.len()).collect();
    let contradicted = search.each(&all, |&w| search.contradicted(w, &set));
    if !contradicted.contains(&true) {
        return;
    }
    let failing = failing(witnesses);
    let slip = pictures::widest_slip(search, &failing);
    let is_shown = |w: usize, set: &[&'static Misreading]| {
        matches!(search.agreement(w, set), Agreement::Picture)
    };
    // For each failure, which of the mistakes cannot be missed for the picture that was shown.
    let needed = search.each(&failing, |&w| {
        let is_needed = |&place: &usize| {
            let mut without = set.clone();
            without.remove(place);
            !is_shown(w, &without)
        };
        match is_shown(w, &set) {
            true => (0..set.len()).filter(is_needed).collect(),
            false => Vec::new(),
        }
    });
    let keep: Vec<bool> = (0..set.len())
        .map(|member| {
            let of = failing.iter().zip(&needed);
            let of: Vec<usize> = of
                .filter(|(_, needed)| needed.contains(&member))
                .map(|(&w, _)| w)
                .collect();
            let computed = |&w: &usize| witnesses[w].finding.view != View::Raw;
            of.is_empty() || of.len() >= slip || !of.iter().all(computed)
        })
        .collect();
    found.keep(&keep);
}

/// Legal files that are not shown as they should be.
fn failing(witnesses: &[Witness]) -> Vec<usize> {
    (0..witnesses.len())
        .filter(|&w| witnesses[w].failed && witnesses[w].case.expect == Expect::Decode)
        .collect()
}

/// What each of the mistakes found explains, and which failing cases none of them does.
fn named(search: &Search, found: &search::Found) -> (Vec<Diagnosis>, Vec<usize>) {
    let witnesses = search.witnesses;
    let set = search::of(&found.members);
    let mut left = Vec::new();
    let mut explains: Vec<Vec<usize>> = vec![Vec::new(); set.len()];
    let mut with: Vec<Vec<&'static Misreading>> = vec![Vec::new(); set.len()];
    let failed: Vec<usize> = (0..witnesses.len())
        .filter(|&w| witnesses[w].failed)
        .collect();
    let needed = search.each(&failed, |&w| needed(search, w, &set));
    for (w, needed) in failed.into_iter().zip(needed) {
        // The case stands under the last of those that cannot be missed.
        let Some((&last, others)) = needed.split_last() else {
            left.push(w);
            continue;
        };
        explains[last].push(witnesses[w].place);
        for &other in others {
            if !with[last].iter().any(|known| known.slug == set[other].slug) {
                with[last].push(set[other]);
            }
        }
    }
    let members = found.members.iter().zip(explains.into_iter().zip(with));
    let diagnoses = members.map(|(member, (explains, with))| {
        let one = [member.misreading];
        let all: Vec<usize> = (0..witnesses.len()).collect();
        let excepted = search.each(&all, |&w| search.contradicted(w, &one));
        let except = all.into_iter().zip(excepted).filter(|&(_, is)| is);
        Diagnosis {
            cause: Cause::Misreading {
                misreading: member.misreading,
                alike: member.alike.clone(),
                with,
            },
            shows: (!member.misreading.effect.starts_with("refuses"))
                .then(|| refusals::all_that_shows(witnesses, &explains))
                .flatten(),
            explains,
            partly: Vec::new(),
            except: except.map(|(w, _)| witnesses[w].place).collect(),
        }
    });
    let mut diagnoses: Vec<Diagnosis> = diagnoses.collect();
    diagnoses.retain(|diagnosis| !diagnosis.explains.is_empty());
    (diagnoses, left)
}

/// Which of `set` explain a failure: one alone, or those that cannot be missed; none if all together do not.
fn needed(search: &Search, w: usize, set: &[&'static Misreading]) -> Vec<usize> {
    let explained = |set: &[&'static Misreading]| {
        matches!(
            search.agreement(w, set),
            Agreement::Picture | Agreement::Word | Agreement::Crash
        )
    };
    if let Some(alone) = (0..set.len()).find(|&member| explained(&[set[member]])) {
        return vec![alone];
    }
    if set.is_empty() || !explained(set) {
        return Vec::new();
    }
    let is_needed = |&member: &usize| {
        let mut without = set.to_vec();
        without.remove(member);
        !explained(&without)
    };
    let needed: Vec<usize> = (0..set.len()).filter(is_needed).collect();
    if needed.is_empty() { vec![0] } else { needed }
}

/// Failures that are near to one of the mistakes found stand under it, in part.
fn search_in_part(
    search: &Search,
    found: &search::Found,
    diagnoses: &mut [Diagnosis],
    left: &mut Vec<usize>,
) {
    let set = search::of(&found.members);
    left.retain(|&w| {
        let witness = &search.witnesses[w];
        let near = set
            .iter()
            .position(|&misreading| pictures::is_near(search, w, &set, misreading));
        let place = near.and_then(|member| {
            diagnoses.iter().position(|diagnosis| {
                matches!(&diagnosis.cause, Cause::Misreading { misreading, .. } if misreading.slug == set[member].slug)
            })
        });
        if let Some(place) = place {
            diagnoses[place].partly.push(witness.place);
        }
        place.is_none()
    });
}
