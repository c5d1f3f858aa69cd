//! Sets of files that share a property.

use super::properties::VIEW_PROPERTIES;
use super::tuning::{COINCIDENCE_ODDS, MIN_SHARING_FILES, MIN_SUPPORT, is_substantial};
use super::witness::Witness;
use crate::ptm::Format;
use crate::suite::cases::Expect;

/// The files that a mistake affects.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum FileScope {
    All,
    Formats(Vec<Format>),
    /// Files with the property at this index, and its clause and text, separated by a space.
    Property(usize, &'static str),
    /// Files whose quantity at this index is at least or at most `nearest`. Other files reach `edge`.
    Beyond {
        quantity: usize,
        /// Clause about the quantity, and its text.
        what: (&'static str, &'static str),
        nearest: f64,
        is_more: bool,
        edge: f64,
    },
}

impl FileScope {
    /// Returns true if the file is in the scope.
    pub fn contains(&self, witness: &Witness) -> bool {
        match self {
            FileScope::All => true,
            FileScope::Formats(formats) => formats.contains(&witness.case.format()),
            FileScope::Property(place, ..) => witness.facts().properties[*place].1,
            FileScope::Beyond {
                quantity,
                nearest,
                is_more,
                ..
            } => {
                let (.., value) = witness.facts().quantities[*quantity];
                value.is_some_and(|value| match is_more {
                    true => value >= *nearest,
                    false => value <= *nearest,
                })
            }
        }
    }

    /// Returns the clause about the format, the property or the quantity.
    pub fn clause(&self) -> Option<&'static str> {
        match self {
            FileScope::Beyond { what, .. } => Some(what.0),
            FileScope::Formats(formats) if formats.len() == 1 => Some(formats[0].layout_clause()),
            FileScope::Formats(_) => Some("2.2/1"),
            FileScope::Property(_, text) => text.split(' ').next(),
            FileScope::All => None,
        }
    }

    /// Returns text that completes "every file …".
    pub fn describe(&self) -> String {
        match self {
            FileScope::All => String::new(),
            FileScope::Formats(formats) => {
                let names: Vec<&str> = formats.iter().map(|format| format.short_name()).collect();
                format!("of format {}", names.join(", "))
            }
            FileScope::Property(_, text) => text
                .split_once(' ')
                .map_or(*text, |(_, words)| words)
                .to_owned(),
            FileScope::Beyond {
                what: (_, words),
                nearest,
                is_more,
                edge,
                ..
            } => {
                let [nearest, edge] = [*nearest, *edge].map(|bound| match bound.abs() < 1e15 {
                    true => bound.to_string(),
                    false => format!("{bound:e}"),
                });
                let [here, there] = match is_more {
                    true => ["least", "most"],
                    false => ["most", "least"],
                };
                let words = words.replace("{}", &format!("at {here} {nearest}"));
                format!("{words} (other files: at {there} {edge})")
            }
        }
    }
}

/// A scope, and the files of a group that are in the scope.
pub(super) struct SharedScope {
    pub scope: FileScope,
    pub cases: Vec<usize>,
}

impl SharedScope {
    /// Counts the legal files in the scope, of one format or of all formats: those in the group, and all others.
    pub fn count_legal(&self, witnesses: &[Witness], format: Option<Format>) -> (usize, usize) {
        let is_legal = |w: &usize| {
            let case = witnesses[*w].case;
            case.expect == Expect::Decode && format.is_none_or(|format| case.format() == format)
        };
        let in_scope =
            (0..witnesses.len()).filter(|w| is_legal(w) && self.scope.contains(&witnesses[*w]));
        let (own, others): (Vec<usize>, Vec<usize>) =
            in_scope.partition(|w| self.cases.contains(w));
        (own.len(), others.len())
    }

    /// Returns true if the group contains a substantial part of the legal files in the scope.
    pub fn is_prevalent(&self, witnesses: &[Witness], format: Option<Format>) -> bool {
        let (own, others) = self.count_legal(witnesses, format);
        is_substantial(own, own + others)
    }
}

/// Returns the scope that contains most of `these` files and none of `others`, unless it may be a coincidence.
/// Considers the requested view only if `with_view` is true.
pub(super) fn shared_scope(
    witnesses: &[Witness],
    these: &[usize],
    others: &[usize],
    with_view: bool,
) -> Option<SharedScope> {
    let has_none = |scope: &FileScope| !others.iter().any(|&w| scope.contains(&witnesses[w]));
    let formats = Format::ALL.map(|format| FileScope::Formats(vec![format]));
    let properties = &witnesses.first()?.facts().properties;
    let places = if with_view { 0 } else { VIEW_PROPERTIES }..properties.len();
    let property = |place: usize| FileScope::Property(place, properties[place].0);
    let scopes: Vec<FileScope> = formats
        .into_iter()
        .chain(places.map(property))
        .chain(thresholds(witnesses, these, others))
        .collect();
    let found = scopes.iter().map(|scope| {
        let indices = these
            .iter()
            .copied()
            .filter(|&w| scope.contains(&witnesses[w]));
        (scope, indices.collect::<Vec<usize>>())
    });
    let found: Vec<(&FileScope, Vec<usize>)> =
        found.filter(|(_, indices)| !indices.is_empty()).collect();
    // Any of the other files could have been in this group instead.
    let part = these.len() as f64 / (these.len() + others.len()) as f64;
    let is_telling = |count: usize| {
        let chance = part.powi(count as i32) * found.len() as f64;
        count >= MIN_SHARING_FILES && chance * COINCIDENCE_ODDS < 1.0
    };
    let telling = found
        .iter()
        .filter(|(scope, indices)| is_telling(indices.len()) && has_none(scope));
    let most = telling.clone().map(|(_, indices)| indices.len()).max()?;
    let mut largest = telling.filter(|(_, indices)| indices.len() == most);
    let (scope, indices) = largest.next()?;
    Some(SharedScope {
        scope: (*scope).clone(),
        cases: indices.clone(),
    })
}

/// Returns scopes for thresholds that separate all of `these` files from all `others`.
fn thresholds(witnesses: &[Witness], these: &[usize], others: &[usize]) -> Vec<FileScope> {
    let mut found = Vec::new();
    let quantities = witnesses
        .first()
        .map_or(&[][..], |witness| &witness.facts().quantities);
    for (quantity, &(clause, words, _)) in quantities.iter().enumerate() {
        let value = |&w: &usize| witnesses[w].facts().quantities[quantity].2;
        let values = |indices: &[usize]| indices.iter().filter_map(value).collect::<Vec<f64>>();
        let (mine, theirs) = (values(these), values(others));
        let least = |indices: &[f64]| indices.iter().copied().fold(f64::MAX, f64::min);
        let most = |indices: &[f64]| indices.iter().copied().fold(f64::MIN, f64::max);
        // A single value among the other files is not a limit unless several files have it.
        let is_one = least(&theirs) == most(&theirs) && theirs.len() < MIN_SUPPORT;
        if mine.is_empty() || theirs.is_empty() || is_one {
            continue;
        }
        for (is_more, nearest, edge) in [
            (true, least(&mine), most(&theirs)),
            (false, most(&mine), least(&theirs)),
        ] {
            let is_apart = match is_more {
                true => nearest > edge,
                // No reader has trouble with short lines.
                false => nearest < edge && clause != "2.0/1",
            };
            if is_apart {
                found.push(FileScope::Beyond {
                    quantity,
                    what: (clause, words),
                    nearest,
                    is_more,
                    edge,
                });
            }
        }
    }
    found
}

/// Returns the scope that contains the `explained` files and none of the `denied` ones: a set of formats, or a property.
pub(super) fn separating_scope(
    witnesses: &[Witness],
    explained: &[usize],
    denied: &[usize],
) -> Option<FileScope> {
    let format = |w: &usize| witnesses[*w].case.format();
    let is_denied = |one: Format| denied.iter().any(|w| format(w) == one);
    if explained.len() >= MIN_SHARING_FILES && !explained.iter().any(|w| is_denied(format(w))) {
        let mut formats = Format::ALL.to_vec();
        formats.retain(|&one| explained.iter().any(|w| format(w) == one));
        return Some(FileScope::Formats(formats));
    }
    let shared = shared_scope(witnesses, explained, denied, false)?;
    (shared.cases.len() == explained.len()).then_some(shared.scope)
}
