//! Sets of files that share a property.

use super::properties::VIEW_PROPERTIES;
use super::rules;
use super::tuning::{COINCIDENCE_ODDS, MIN_SHARING_FILES, MIN_SUPPORT, is_substantial, is_third};
use super::witness::Witness;
use ptm::Format;
use ptm_suite::cases::Expect;

/// A set of files: those of some formats, or those with a property.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum FileScope {
    Formats(Vec<Format>),
    /// Files with the property at this index. The string contains the clause and the text of the property, separated by a space.
    Property(usize, &'static str),
    /// Files for which the quantity at index `quantity` is at least or at most `bound`.
    Beyond {
        quantity: usize,
        /// Clause about the quantity, and the text that describes the quantity.
        text: (&'static str, &'static str),
        bound: f64,
        is_minimum: bool,
    },
}

impl FileScope {
    /// Returns true if the file is in the scope.
    pub fn contains(&self, witness: &Witness) -> bool {
        match self {
            FileScope::Formats(formats) => formats.contains(&witness.case.format()),
            FileScope::Property(index, ..) => witness.facts().properties[*index].1,
            FileScope::Beyond {
                quantity,
                bound,
                is_minimum,
                ..
            } => {
                let (.., value) = witness.facts().quantities[*quantity];
                value.is_some_and(|value| match is_minimum {
                    true => value >= *bound,
                    false => value <= *bound,
                })
            }
        }
    }

    /// Returns the clause about the format, the property or the quantity.
    pub fn clause(&self) -> Option<&'static str> {
        match self {
            FileScope::Beyond { text, .. } => Some(text.0),
            FileScope::Formats(formats) if formats.len() == 1 => Some(formats[0].layout_clause()),
            FileScope::Formats(_) => Some("2.2/1"),
            FileScope::Property(_, text) => text.split(' ').next(),
        }
    }

    /// Returns text that completes "files …".
    fn describe(&self) -> String {
        match self {
            FileScope::Formats(formats) => {
                format!("of format {}", list_formats(formats))
            }
            FileScope::Property(_, text) => text
                .split_once(' ')
                .map_or(*text, |(_, words)| words)
                .to_owned(),
            FileScope::Beyond {
                text: ("2.9.8/4", _),
                bound: 0.0,
                ..
            } => "with compressed planes, but without side information".to_owned(),
            FileScope::Beyond {
                text: (_, words),
                bound,
                is_minimum,
                ..
            } => {
                let here = if *is_minimum { "least" } else { "most" };
                words.replace("{}", &format!("at {here} {}", format_bound(*bound)))
            }
        }
    }
}

fn format_bound(value: f64) -> String {
    match value.abs() < 1e15 {
        true => value.to_string(),
        false => format!("{value:e}"),
    }
}

/// A scope, and those files of a group that are in the scope.
pub(super) struct SharedScope {
    /// The formats in which the scope was searched. Files of other formats are disregarded.
    formats: Vec<Format>,
    pub scope: FileScope,
    pub cases: Vec<usize>,
}

impl SharedScope {
    /// Returns true unless the files share only their formats.
    pub fn is_property(&self) -> bool {
        !matches!(self.scope, FileScope::Formats(_))
    }

    /// Returns true if the file is in the scope and has one of the formats in which the scope was searched.
    pub fn contains(&self, witness: &Witness) -> bool {
        self.formats.contains(&witness.case.format()) && self.scope.contains(witness)
    }

    /// Returns the files of the formats that the text about the scope names or, if it names none, of all formats.
    pub fn files_of_formats(&self, witnesses: &[Witness]) -> Vec<usize> {
        let formats = match &self.scope {
            FileScope::Formats(own) => own,
            _ => &self.formats,
        };
        let all: Vec<usize> = (0..witnesses.len()).collect();
        files_of(witnesses, &all, formats)
    }

    /// Adds the formats of `other`, which has the same scope.
    pub fn add_formats(&mut self, other: &SharedScope) {
        let known = |format: &Format, formats: &[Format]| formats.contains(format);
        let all = Format::ALL.into_iter();
        self.formats = all
            .clone()
            .filter(|one| known(one, &self.formats) || known(one, &other.formats))
            .collect();
        if let (FileScope::Formats(own), FileScope::Formats(more)) = (&mut self.scope, &other.scope)
        {
            *own = all
                .filter(|one| known(one, own) || known(one, more))
                .collect();
        }
    }

    /// Counts the legal files in the scope. Returns the number of files in the group and the number of other files.
    pub fn count_legal(&self, witnesses: &[Witness]) -> (usize, usize) {
        let is_legal = |w: &usize| {
            let case = witnesses[*w].case;
            case.expect == Expect::Decode && self.formats.contains(&case.format())
        };
        let in_scope =
            (0..witnesses.len()).filter(|w| is_legal(w) && self.scope.contains(&witnesses[*w]));
        let (own, others): (Vec<usize>, Vec<usize>) =
            in_scope.partition(|w| self.cases.contains(w));
        (own.len(), others.len())
    }

    /// Returns true if the group contains a substantial part of the legal files in the scope.
    pub fn is_prevalent(&self, witnesses: &[Witness]) -> bool {
        let (own, others) = self.count_legal(witnesses);
        is_substantial(own, own + others)
    }

    /// Returns text that completes "every legal file …", including the nearest value of a quantity in the files outside the scope.
    pub fn describe(&self, witnesses: &[Witness]) -> String {
        let scope = self.scope.describe();
        let nearest = self.nearest_value_outside(witnesses);
        match self.scope {
            FileScope::Formats(_) => scope,
            _ if self.formats.len() == Format::ALL.len() => scope + &nearest,
            _ => format!("of {} {scope}{nearest}", list_formats(&self.formats)),
        }
    }

    /// Returns text such as " (other files: at most 4)", or an empty string if the scope is not limited by a quantity or contains
    /// other files: those fail in another way, or were not judged.
    fn nearest_value_outside(&self, witnesses: &[Witness]) -> String {
        let FileScope::Beyond {
            quantity,
            bound,
            is_minimum,
            ..
        } = self.scope
        else {
            return String::new();
        };
        let all = self.files_of_formats(witnesses);
        let (inside, others): (Vec<usize>, Vec<usize>) = all
            .iter()
            .partition(|&&w| self.scope.contains(&witnesses[w]));
        let is_whole = inside.iter().all(|w| self.cases.contains(w));
        if !is_whole
            || has_unjudged_files(witnesses, &all)
            || has_inconsistent_files(witnesses, &all)
        {
            return String::new();
        }
        let others = others.iter().map(|&w| &witnesses[w]);
        let values = others.filter_map(|witness| witness.facts().quantities[quantity].2);
        let (side, nearest) = match is_minimum {
            true => ("most", values.reduce(f64::max)),
            false => ("least", values.reduce(f64::min)),
        };
        let nearest = nearest.filter(|_| bound != 0.0).map(format_bound);
        nearest.map_or_else(String::new, |value| {
            format!(" (other files: at {side} {value})")
        })
    }
}

/// Returns the sets of formats in which a property is searched: all formats, those of `files`, and each of these alone.
pub(super) fn format_sets(witnesses: &[Witness], files: &[usize]) -> Vec<Vec<Format>> {
    let own = own_formats(witnesses, files, &[]);
    let single = own.iter().map(|&format| vec![format]);
    let single: Vec<Vec<Format>> = single.collect();
    [vec![Format::ALL.to_vec(), own], single].concat()
}

/// Returns the files that have one of `formats`.
pub(super) fn files_of(witnesses: &[Witness], files: &[usize], formats: &[Format]) -> Vec<usize> {
    let has_format = |w: &usize| formats.contains(&witnesses[*w].case.format());
    files.iter().copied().filter(has_format).collect()
}

/// Returns the names of the formats, separated by commas.
pub(super) fn list_formats(formats: &[Format]) -> String {
    let names: Vec<&str> = formats.iter().map(|format| format.short_name()).collect();
    names.join(", ")
}

/// Returns the scope that contains the most files of `group` and none of `others`, unless the match may be a coincidence, or unless
/// most files without the property are also in `group` or in `open`. Only files of these formats are considered, and the requested
/// view only if `with_view` is true.
pub(super) fn shared_scope(
    witnesses: &[Witness],
    formats: &[Format],
    group: &[usize],
    others: &[usize],
    open: &[usize],
    with_view: bool,
) -> Option<SharedScope> {
    let [group, others, open] =
        [group, others, open].map(|files| files_of(witnesses, files, formats));
    let is_pure = |scope: &FileScope| !others.iter().any(|&w| scope.contains(&witnesses[w]));
    let own_formats = FileScope::Formats(own_formats(witnesses, &group, &others));
    let properties = &witnesses.first()?.facts().properties;
    let range = if with_view { 0 } else { VIEW_PROPERTIES }..properties.len();
    let property = |index: usize| FileScope::Property(index, properties[index].0);
    let scopes = std::iter::once(own_formats)
        .chain(range.map(property))
        .chain(thresholds(witnesses, &group, &others));
    let shared = scopes.map(|scope| {
        let is_inside = |w: &usize| scope.contains(&witnesses[*w]);
        let cases = group.iter().copied().filter(is_inside).collect();
        SharedScope {
            formats: formats.to_vec(),
            scope,
            cases,
        }
    });
    let found: Vec<SharedScope> = shared.filter(|one| !one.cases.is_empty()).collect();
    // Any of the other files could have been in this group instead.
    let share = group.len() as f64 / (group.len() + others.len()) as f64;
    let candidates = found.len() as f64;
    let is_significant = |count: usize| {
        let chance = share.powi(count as i32) * candidates;
        count >= MIN_SHARING_FILES && chance * COINCIDENCE_ODDS < 1.0
    };
    // Reversed, because `max_by_key` returns the last maximum.
    let valid = (found.into_iter().rev())
        .filter(|one| is_significant(one.cases.len()) && is_pure(&one.scope))
        .filter(|one| rules::separates(witnesses, &one.scope, [&group, &open], &others));
    valid.max_by_key(|one| one.cases.len())
}

/// Returns the property that all of these files and the fewest others of the same formats in the same views have, as text that
/// completes "files …", unless the match may be a coincidence.
pub(super) fn common_property(witnesses: &[Witness], cases: &[usize]) -> Option<&'static str> {
    let formats = own_formats(witnesses, cases, &[]);
    let view = |w: &usize| witnesses[*w].observation.view.kind();
    let is_other = |w: &usize| !cases.contains(w) && cases.iter().any(|case| view(case) == view(w));
    let others: Vec<usize> = (0..witnesses.len()).filter(is_other).collect();
    let others = files_of(witnesses, &others, &formats);
    let has = |w: &usize, index: usize| witnesses[*w].facts().properties[index].1;
    let properties = &witnesses.first()?.facts().properties;
    let common = (VIEW_PROPERTIES..properties.len())
        .filter(|&index| cases.iter().all(|w| has(w, index)))
        .map(|index| (others.iter().filter(|w| has(w, index)).count(), index));
    let (count, index) = common.min()?;
    // The files that have the property, and this one.
    let chance = ((count + 1) as f64 / (others.len() + 1) as f64).powi(cases.len() as i32);
    let is_significant = chance * properties.len() as f64 * COINCIDENCE_ODDS < 1.0;
    let (_, text) = properties[index].0.split_once(' ')?;
    let is_rare = !is_substantial(count, others.len());
    // If most files with the property are read, it is not what these files fail for.
    let is_telling = is_third(cases.len(), cases.len() + count);
    (is_rare && is_telling && is_significant && cases.len() >= MIN_SHARING_FILES).then_some(text)
}

/// Returns true if some legal files of the same formats were asked, but are neither witnesses nor inconsistent, for example because
/// they are unsupported.
pub(super) fn has_unjudged_files(witnesses: &[Witness], indices: &[usize]) -> bool {
    let is_legal_of = |format: Format, witness: &&Witness| {
        witness.case.format() == format && witness.case.expect == Expect::Decode
    };
    indices.iter().any(|&w| {
        let format = witnesses[w].case.format();
        let legal = witnesses
            .iter()
            .filter(|witness| is_legal_of(format, witness));
        legal.count() + witnesses[w].inconsistent_files < witnesses[w].legal_files
    })
}

/// Returns true if some legal files of the same formats failed, but are not witnesses, because the responses were inconsistent.
pub(super) fn has_inconsistent_files(witnesses: &[Witness], indices: &[usize]) -> bool {
    indices.iter().any(|&w| witnesses[w].inconsistent_files > 0)
}

/// Returns the formats of the files in `group` that no file in `others` has.
pub(super) fn own_formats(witnesses: &[Witness], group: &[usize], others: &[usize]) -> Vec<Format> {
    let has = |files: &[usize], one| files.iter().any(|&w| witnesses[w].case.format() == one);
    let is_own = |format: &Format| has(group, *format) && !has(others, *format);
    Format::ALL.into_iter().filter(is_own).collect()
}

/// Returns scopes for thresholds that separate all files in `group` from all files in `others`.
fn thresholds(witnesses: &[Witness], group: &[usize], others: &[usize]) -> Vec<FileScope> {
    let mut found = Vec::new();
    let quantities = witnesses
        .first()
        .map_or(&[][..], |witness| &witness.facts().quantities);
    for (quantity, &(clause, words, _)) in quantities.iter().enumerate() {
        let is_length = ["of the header", "of header", "characters"]
            .iter()
            .any(|end| words.ends_with(end));
        let value = |&w: &usize| witnesses[w].facts().quantities[quantity].2;
        let values = |indices: &[usize]| indices.iter().filter_map(value).collect::<Vec<f64>>();
        let (own, theirs) = (values(group), values(others));
        let min = |values: &[f64]| values.iter().copied().fold(f64::MAX, f64::min);
        let max = |values: &[f64]| values.iter().copied().fold(f64::MIN, f64::max);
        // A single value among the other files is not a limit unless several files have it.
        let is_single = min(&theirs) == max(&theirs) && theirs.len() < MIN_SUPPORT;
        if own.is_empty() || theirs.is_empty() || is_single {
            continue;
        }
        for (is_minimum, bound, other_bound) in [
            (true, min(&own), max(&theirs)),
            (false, max(&own), min(&theirs)),
        ] {
            let is_separate = match is_minimum {
                true => bound > other_bound,
                // No decoder has trouble with short lines, headers or numbers.
                false => bound < other_bound && !is_length,
            };
            if is_separate {
                found.push(FileScope::Beyond {
                    quantity,
                    text: (clause, words),
                    bound,
                    is_minimum,
                });
            }
        }
    }
    found
}
