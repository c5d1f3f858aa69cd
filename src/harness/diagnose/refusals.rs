//! Legal files that were refused, or that brought the decoder down: what they share and no accepted file has.

use super::traits::Traits;
use super::witness::Witness;
use super::{Diagnosis, Kind};
use crate::harness::cases::Expect;
use crate::harness::judge::Shown;
use crate::harness::protocol::Answer;
use crate::ptm::Format;

/// A trait is said that one in so many of the failures have which nothing else explains.
pub(super) const WORTH_SAYING: usize = 5;
/// What fewer files share may be chance.
const FEWEST: usize = 2;
/// Two traits together are said of no fewer files, and of three in four of them: among so many pairs some fit by chance.
const FEWEST_OF_BOTH: usize = 8;

/// Refusals that a trait explains: every file of the suite that has it is treated so. They are taken out of `left`.
pub(super) fn describe(witnesses: &[Witness], left: &mut Vec<usize>) -> Vec<Diagnosis> {
    let mut diagnoses = Vec::new();
    for deed in deeds(witnesses, left) {
        let mut open: Vec<usize> = left
            .iter()
            .copied()
            .filter(|&w| deed_of(&witnesses[w]).as_ref() == Some(&deed))
            .collect();
        let accepted = accepted(witnesses);
        while let Some((says, of)) = shared(witnesses, &open, &accepted, true) {
            // What few of many share is chance.
            if open.len() > of.len() * WORTH_SAYING {
                break;
            }
            open.retain(|w| !of.contains(w));
            left.retain(|w| !of.contains(w));
            let effect = format!("{} every file {says}", deed.verb);
            let mend =
                "read such files: they are legal; if they are not meant to be read, exit with 69"
                    .to_owned();
            let example = example(witnesses, &of);
            diagnoses.push(Diagnosis::described(
                Kind::Refusal,
                witnesses,
                &of,
                (effect, mend, example),
            ));
        }
    }
    diagnoses
}

/// For each way not to show a picture, the failures that one shared trait explains.
pub(super) fn widest(witnesses: &[Witness], failing: &[usize]) -> Vec<Vec<usize>> {
    let accepted = accepted(witnesses);
    let of = |deed: Deed| {
        let of: Vec<usize> = failing
            .iter()
            .copied()
            .filter(|&w| deed_of(&witnesses[w]).as_ref() == Some(&deed))
            .collect();
        shared(witnesses, &of, &accepted, true).map(|(_, of)| of)
    };
    deeds(witnesses, failing)
        .into_iter()
        .filter_map(of)
        .collect()
}

/// Legal files that the decoder reads, rightly or wrongly. One that ends in another crash says nothing.
fn accepted(witnesses: &[Witness]) -> Vec<usize> {
    (0..witnesses.len())
        .filter(|&w| {
            witnesses[w].case.expect == Expect::Decode
                && matches!(witnesses[w].finding.shown, Shown::Picture { .. })
        })
        .collect()
}

/// What a cause that explains these places comes to, if that is nothing but not to show the legal files that share
/// something: their format, or one other thing.
pub(super) fn all_that_shows(witnesses: &[Witness], explains: &[usize]) -> Option<String> {
    let legal = |w: &usize| witnesses[*w].case.expect == Expect::Decode;
    let legal: Vec<usize> = (0..witnesses.len()).filter(legal).collect();
    let explained = |w: &usize| explains.contains(&witnesses[*w].place);
    let (of, others): (Vec<usize>, Vec<usize>) = legal.into_iter().partition(explained);
    let deed = deed_of(&witnesses[*of.first()?])?;
    if !of
        .iter()
        .all(|&w| deed_of(&witnesses[w]).as_ref() == Some(&deed))
    {
        return None;
    }
    let format = |w: &usize| witnesses[*w].case.format();
    let formats: Vec<Format> = Format::ALL
        .into_iter()
        .filter(|known| of.iter().any(|w| format(w) == *known))
        .collect();
    if !others.iter().any(|w| formats.contains(&format(w))) {
        let names: Vec<&str> = formats.iter().map(|format| format.short_name()).collect();
        return Some(format!("{} every file of {}", deed.verb, names.join(", ")));
    }
    let (says, having) = shared(witnesses, &of, &others, false)?;
    (having.len() == of.len()).then(|| format!("{} every file {says}", deed.verb))
}

/// What no trait explains.
pub(super) fn rest(witnesses: &[Witness], left: &mut Vec<usize>) -> Vec<Diagnosis> {
    let mut diagnoses = Vec::new();
    for deed in deeds(witnesses, left) {
        let of: Vec<usize> = left
            .iter()
            .copied()
            .filter(|&w| deed_of(&witnesses[w]).as_ref() == Some(&deed))
            .collect();
        left.retain(|w| !of.contains(w));
        let files = match of.len() {
            1 => "a legal file",
            _ => "legal files; nothing was found that they share and files it reads have not",
        };
        diagnoses.push(Diagnosis::described(
            Kind::Refusal,
            witnesses,
            &of,
            (
                format!("{} {files}", deed.verb),
                "look at the first of them with ptm-conform explain".to_owned(),
                example(witnesses, &of),
            ),
        ));
    }
    diagnoses
}

/// What a decoder does instead of showing a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Deed {
    /// "refuses", "crashes on (exit status 1)".
    pub verb: String,
}

pub(super) fn deed_of(witness: &Witness) -> Option<Deed> {
    let verb = match &witness.finding.shown {
        Shown::Picture { .. } => return None,
        Shown::Rejected => "refuses".to_owned(),
        Shown::Unsupported => "answers 69 (unsupported) to".to_owned(),
        Shown::Misconduct(Answer::Crashed(how)) => format!("crashes ({how}) on"),
        Shown::Misconduct(Answer::Hung(_)) => "does not come to an end on".to_owned(),
        Shown::Misconduct(Answer::ProtocolError(what)) => {
            // Numbers differ from file to file.
            let general: String = what.chars().take_while(|c| *c != '"').collect();
            let general = if general.is_empty() {
                "its output is no frame"
            } else {
                general.trim_end()
            };
            format!("gives no well-formed frame ({general}) for")
        }
        Shown::Misconduct(answer) => format!("ends in {} on", answer.name()),
    };
    Some(Deed { verb })
}

/// The deeds among the failures that are left, the most frequent first.
pub(super) fn deeds(witnesses: &[Witness], left: &[usize]) -> Vec<Deed> {
    let mut deeds: Vec<(Deed, usize)> = Vec::new();
    for deed in left.iter().filter_map(|&w| deed_of(&witnesses[w])) {
        match deeds.iter_mut().find(|(known, _)| *known == deed) {
            Some((_, count)) => *count += 1,
            None => deeds.push((deed, 1)),
        }
    }
    deeds.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
    deeds.into_iter().map(|(deed, _)| deed).collect()
}

/// What most of `these` share and none of `others` has, in words; and which of `these` have it. It may be what they were
/// asked for, if `asked`.
pub(super) fn shared(
    witnesses: &[Witness],
    these: &[usize],
    others: &[usize],
    asked: bool,
) -> Option<(String, Vec<usize>)> {
    if these.is_empty() {
        return None;
    }
    let of = |places: &[usize]| -> Vec<&Traits> {
        places.iter().map(|&w| witnesses[w].traits()).collect()
    };
    let (mine, theirs) = (of(these), of(others));
    let (my_words, their_words) = (said(&mine, asked), said(&theirs, asked));
    let all = distinct(my_words.iter().flatten().copied());
    // For each trait, which of both have it.
    let having = |words: &[Vec<&str>]| -> Vec<Vec<bool>> {
        let have = |says| words.iter().map(|words| words.contains(says)).collect();
        all.iter().map(have).collect()
    };
    let (my_traits, their_traits) = (having(&my_words), having(&their_words));
    let both = |lists: &[Vec<bool>], a: usize, b: usize| -> Vec<bool> {
        lists[a]
            .iter()
            .zip(&lists[b])
            .map(|(a, b)| *a && *b)
            .collect()
    };
    let absent = |a: usize, b: usize| !both(&their_traits, a, b).contains(&true);
    let having = |a: usize, b: usize| -> Vec<usize> {
        let having = both(&my_traits, a, b);
        these
            .iter()
            .zip(having)
            .filter(|&(_, has)| has)
            .map(|(&w, _)| w)
            .collect()
    };
    let mut best: Option<(String, Vec<usize>)> = None;
    let mut offer = |says: String, of: Vec<usize>| {
        if best
            .as_ref()
            .is_none_or(|(_, known)| of.len() > known.len())
            && of.len() >= FEWEST
        {
            best = Some((says, of));
        }
    };
    for (i, says) in all.iter().enumerate() {
        if absent(i, i) {
            offer((*says).to_owned(), having(i, i));
        }
    }
    for (says, of) in thresholds(these, &mine, &theirs) {
        offer(says, of);
    }
    // Two together must say clearly more than one alone.
    let single = best.as_ref().map_or(0, |(_, of)| of.len());
    if single * 4 < these.len() * 3 {
        for a in 0..all.len() {
            for b in a + 1..all.len() {
                let of = having(a, b);
                let known = best.as_ref().map_or(0, |(_, known)| known.len());
                let is_telling = of.len() >= FEWEST_OF_BOTH && of.len() * 4 >= these.len() * 3;
                if of.len() > known && is_telling && absent(a, b) {
                    best = Some((format!("{} and {}", all[a], all[b]), of));
                }
            }
        }
    }
    best
}

/// What is said of each file.
fn said<'a>(traits: &[&'a Traits], asked: bool) -> Vec<Vec<&'a str>> {
    traits.iter().map(|traits| traits.said(asked)).collect()
}

/// Each once, in the order in which they come.
fn distinct<'a>(words: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut all = Vec::new();
    for word in words {
        if !all.contains(&word) {
            all.push(word);
        }
    }
    all
}

/// Numbers over which, or under which, there is none of the others.
fn thresholds(these: &[usize], mine: &[&Traits], theirs: &[&Traits]) -> Vec<(String, Vec<usize>)> {
    let number = |traits: &Traits, name: &str| {
        traits
            .numbers
            .iter()
            .find(|(known, _)| *known == name)
            .map(|&(_, number)| number)
    };
    let mut found = Vec::new();
    let names = mine.iter().flat_map(|traits| &traits.numbers);
    for name in distinct(names.map(|&(name, _)| name)) {
        let theirs = || theirs.iter().filter_map(|traits| number(traits, name));
        let (Some(least), Some(most)) = (theirs().min(), theirs().max()) else {
            continue;
        };
        let those = |is: &dyn Fn(i64) -> bool| -> Vec<(usize, i64)> {
            let numbers = these.iter().zip(mine);
            numbers
                .filter_map(|(&w, traits)| Some((w, number(traits, name)?)))
                .filter(|&(_, number)| is(number))
                .collect()
        };
        let over = those(&|number| number > most);
        let under = those(&|number| number < least);
        for (side, those, edge) in [("more", over, most), ("fewer", under, least)] {
            let numbers = those.iter().map(|&(_, number)| number);
            let nearest = if side == "more" {
                numbers.min()
            } else {
                numbers.max()
            };
            if let Some(nearest) = nearest {
                let says = format!("with {nearest} or {side} {name} (it reads {edge})");
                found.push((says, those.into_iter().map(|(w, _)| w).collect()));
            }
        }
    }
    found
}

pub(super) fn example(witnesses: &[Witness], of: &[usize]) -> String {
    let smallest = of
        .iter()
        .map(|&w| &witnesses[w])
        .min_by_key(|witness| witness.built.file.len())
        .expect("a diagnosis explains at least one case");
    let stderr = smallest.finding.stderr.lines().last().unwrap_or_default();
    let words = if stderr.is_empty() {
        String::new()
    } else {
        format!("; its standard error ends: {stderr}")
    };
    format!(
        "for example {}: {}{words}",
        smallest.case.id, smallest.case.because
    )
}
