//! Measures of the suite: clauses, kills, separations, pairs of parameters, and redundant cases.
//!
//! - A clause is covered by its cases, and by misreadings of it that are caught.
//! - A misreading is *killed* by the cases that fail a decoder with it. Two misreadings are *separated* by a case
//!   with different answers.
//! - A case is *redundant* if, without it, every misreading is still killed and every pair is still separated. It may
//!   exist for its clause, or for a mistake that nobody has made yet.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use serde::Serialize;

use crate::generate::{Numbers, Recipe};
use crate::ptm::{Format, Size};
use crate::strength::matrix::MatrixRow;
use crate::suite::cases::{Case, Expect, Suite};
use crate::suite::clauses::{self, ClauseStatus};

/// All measures of a suite.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Coverage {
    /// Coverage of every clause, in the order of the text.
    pub clauses: Vec<ClauseCoverage>,
    /// Kills of every misreading, in the order of the catalog.
    pub misreadings: Vec<Kills>,
    /// Separation of misreadings, with its gaps.
    pub separation: Separation,
    /// Pairs of parameters that occur together in some file.
    pub pairwise: Pairwise,
    /// Ids of redundant cases.
    pub redundant: Vec<String>,
}

/// Coverage of a clause.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ClauseCoverage {
    /// Section and ordinal of the clause.
    pub clause: String,
    /// Status: tested, ruled, informative or untestable.
    pub status: String,
    /// Number of cases that test the clause.
    pub cases: usize,
    /// Slugs of the misreadings of the clause that are killed.
    pub killed: Vec<String>,
}

/// The cases that kill a misreading.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Kills {
    /// Slug of the misreading in `misreadings.yaml`.
    pub misreading: String,
    /// Clause of the misreading.
    pub clause: String,
    /// Number of cases that fail because of the misreading.
    pub count: usize,
    /// Ids of all cases that fail because of the misreading.
    pub cases: Vec<String>,
}

/// Pairs of misreadings that the suite separates.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Separation {
    /// Number of pairs of misreadings.
    pub pairs: usize,
    /// Number of pairs that some case separates.
    pub separated: usize,
    /// Sets of misreadings with the same answers to every case.
    pub alike: Vec<Vec<String>>,
}

/// Pairs of parameter values that occur together.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Pairwise {
    /// Parameters and their values.
    pub parameters: BTreeMap<String, BTreeSet<String>>,
    /// Number of pairs of values that can occur together.
    pub pairs: usize,
    /// Number of pairs of values that occur together in a file that must be decoded.
    pub covered: usize,
    /// Pairs of values that do not occur together.
    pub missing: Vec<String>,
}

impl Coverage {
    /// Computes all measures from the matrix of a suite.
    ///
    /// # Errors
    /// Returns an error if the clauses cannot be loaded.
    pub fn new(suite: &Suite, rows: &[MatrixRow]) -> Result<Coverage, String> {
        let id = |&i: &usize| suite.cases[i].id.clone();
        let kills = rows.iter().map(|row| Kills {
            misreading: row.misreading.slug.to_owned(),
            clause: row.misreading.clause.to_owned(),
            count: row.killed_by.len(),
            cases: row.killed_by.iter().map(id).collect(),
        });
        let (separation, unique_separators) = measure_separation(suite, rows);
        Ok(Coverage {
            clauses: measure_clauses(suite, rows)?,
            misreadings: kills.collect(),
            separation,
            pairwise: measure_pairs(suite),
            redundant: find_redundant_cases(suite, rows, &unique_separators),
        })
    }

    /// Formats the measures for a terminal.
    #[must_use]
    pub fn to_text(&self, suite: &Suite) -> String {
        let out = &mut String::new();
        self.write_clauses(out);
        self.write_misreadings(out);
        let missing = &self.pairwise.missing;
        let (covered, pairs) = (self.pairwise.covered, self.pairwise.pairs);
        let _ = writeln!(
            out,
            "pairs of recipe parameters: {covered} of {pairs} occur in a file that must be decoded"
        );
        for pair in missing.iter().take(MAX_MISSING) {
            let _ = writeln!(out, "  missing: {pair}");
        }
        if missing.len() > MAX_MISSING {
            let more = missing.len() - MAX_MISSING;
            let _ = writeln!(out, "  … and {more} more; --yaml lists them");
        }
        let (redundant, all) = (self.redundant.len(), suite.cases.len());
        let _ = writeln!(
            out,
            "redundant: {redundant} of {all} cases neither detect a misreading nor distinguish a pair that no other case does"
        );
        std::mem::take(out)
    }

    fn write_clauses(&self, out: &mut String) {
        let mut statuses: BTreeMap<&str, usize> = BTreeMap::new();
        for clause in &self.clauses {
            *statuses.entry(&clause.status).or_default() += 1;
        }
        let statuses = statuses.iter();
        let statuses = statuses.map(|(status, count)| format!("{count} {status}"));
        let (all, statuses) = (self.clauses.len(), statuses.collect::<Vec<_>>().join(", "));
        let _ = writeln!(out, "clauses: {all}: {statuses}");
        let is_weak = |clause: &&ClauseCoverage| {
            clause.status == "tested" && (clause.cases == 0 || clause.killed.is_empty())
        };
        for clause in self.clauses.iter().filter(is_weak) {
            let _ = writeln!(
                out,
                "  {}: {} cases, but none detects a misreading",
                clause.clause, clause.cases
            );
        }
    }

    fn write_misreadings(&self, out: &mut String) {
        let all = self.misreadings.len();
        let killed = self.misreadings.iter().filter(|kills| kills.count > 0);
        let _ = writeln!(out, "misreadings: {} of {all} killed", killed.count());
        for kills in self.misreadings.iter().filter(|kills| kills.count < 2) {
            let _ = writeln!(
                out,
                "  {} ({}): killed by {}",
                kills.misreading,
                kills.clause,
                kills.cases.first().map_or("no case", String::as_str)
            );
        }
        let (separated, pairs) = (self.separation.separated, self.separation.pairs);
        let _ = writeln!(
            out,
            "pairs of misreadings: {separated} of {pairs} distinguished"
        );
        for set in &self.separation.alike {
            let _ = writeln!(out, "  alike in every case: {}", set.join(", "));
        }
    }
}

/// Maximum number of missing pairs of parameters in the summary.
const MAX_MISSING: usize = 20;

fn measure_clauses(suite: &Suite, rows: &[MatrixRow]) -> Result<Vec<ClauseCoverage>, String> {
    let one = |clause: clauses::Clause| ClauseCoverage {
        status: match clause.status {
            ClauseStatus::Tested => "tested",
            ClauseStatus::Ruled => "ruled",
            ClauseStatus::Informative => "informative",
            ClauseStatus::Untestable => "untestable",
        }
        .to_owned(),
        cases: {
            let about = |case: &&Case| case.clauses.contains(&clause.id);
            suite.cases.iter().filter(about).count()
        },
        killed: {
            let mistakes = rows.iter().filter(|row| !row.killed_by.is_empty());
            let mistakes = mistakes.map(|row| row.misreading);
            let mistakes = mistakes.filter(|mistake| mistake.clause == clause.id);
            mistakes.map(|mistake| mistake.slug.to_owned()).collect()
        },
        clause: clause.id,
    };
    Ok(clauses::clauses()?.into_iter().map(one).collect())
}

/// Returns the separation of misreadings, and the cases that are the only ones to separate some pair.
fn measure_separation(suite: &Suite, rows: &[MatrixRow]) -> (Separation, BTreeSet<usize>) {
    let mut unique_separators = BTreeSet::new();
    let mut alike: BTreeMap<&[u64], Vec<String>> = BTreeMap::new();
    let mut separated = 0;
    for (i, a) in rows.iter().enumerate() {
        let slug = a.misreading.slug.to_owned();
        alike.entry(&a.answers).or_default().push(slug);
        for b in &rows[i + 1..] {
            let mut apart = (0..suite.cases.len()).filter(|&c| a.answers[c] != b.answers[c]);
            match (apart.next(), apart.next()) {
                (Some(only), None) => {
                    separated += 1;
                    unique_separators.insert(only);
                }
                (Some(_), Some(_)) => separated += 1,
                (None, _) => {}
            }
        }
    }
    let separation = Separation {
        pairs: rows.len() * rows.len().saturating_sub(1) / 2,
        separated,
        alike: alike.into_values().filter(|set| set.len() > 1).collect(),
    };
    (separation, unique_separators)
}

fn find_redundant_cases(
    suite: &Suite,
    rows: &[MatrixRow],
    unique_separators: &BTreeSet<usize>,
) -> Vec<String> {
    let only = |row: &MatrixRow| match row.killed_by[..] {
        [only] => Some(only),
        _ => None,
    };
    let killing: BTreeSet<usize> = rows.iter().filter_map(only).collect();
    let needed = |i: &usize| killing.contains(i) || unique_separators.contains(i);
    (0..suite.cases.len())
        .filter(|i| !needed(i))
        .map(|i| suite.cases[i].id.clone())
        .collect()
}

/// Returns the parameters of a recipe, with names and values.
fn recipe_parameters(case: &Case, recipe: &Recipe) -> Vec<(&'static str, String)> {
    let spelling = &recipe.spelling;
    let lines = |two: bool| if two { "two lines" } else { "one line" };
    let bias = match recipe.bias.values.iter().any(|&bias| bias > 255.0) {
        true => "over 255",
        false => number_kind(&recipe.bias),
    };
    let scale_bias = spelling.scale_bias_on_two_lines;
    let space = !spelling.space_before_newline.is_empty();
    let mut chosen = vec![
        ("format", recipe.format.short_name()),
        ("size", size_kind(recipe.size)),
        ("size is written on", lines(spelling.size_on_two_lines)),
        ("scale and bias are written on", lines(scale_bias)),
        ("space before a line feed", yes_or_no(space)),
        ("scale", number_kind(&recipe.scale)),
        ("bias", bias),
    ];
    if recipe.format.has_table() {
        let entries = match recipe.entries {
            1 => "one",
            2..=255 => "up to 255",
            256 => "256",
            _ => "more than 256",
        };
        chosen.push(("entries", entries));
    }
    if let Some(plan) = case.compression() {
        let prediction = match (plan.predicts(), plan.inverts(), plan.moves()) {
            (false, ..) => "none",
            (_, false, false) => "plain",
            (_, true, false) => "inverted",
            (_, false, true) => "moved",
            (_, true, true) => "inverted and moved",
        };
        chosen.push(("prediction", prediction));
        chosen.push(("side information", yes_or_no(!plan.records.is_empty())));
    }
    let owned = |(name, value): (&'static str, &str)| (name, value.to_owned());
    chosen.into_iter().map(owned).collect()
}

fn yes_or_no(yes: bool) -> &'static str {
    if yes { "yes" } else { "no" }
}

fn number_kind(numbers: &Numbers<6>) -> &'static str {
    let values = &numbers.values;
    if numbers.texts().iter().any(|text| text.contains(['e', 'E'])) {
        "an exponent"
    } else if values.iter().any(|&value| value < 0.0) {
        "below zero"
    } else if values.contains(&0.0) {
        "zero"
    } else {
        "ordinary"
    }
}

fn size_kind(size: Size) -> &'static str {
    match (size.width, size.height) {
        (1, 1) => "one texel",
        (_, 1) => "one row",
        (1, _) => "one column",
        (width, height) if width > 255 || height > 255 => "over 255",
        (width, height) if width == height => "square",
        _ => "oblong",
    }
}

/// Returns true if two parameter values can occur in the same file.
fn can_occur_together(a: (&str, &str), b: (&str, &str)) -> bool {
    let rules_out = |(name, value): (&str, &str), other: (&str, &str)| {
        let format = value.parse::<Format>();
        name == "format"
            && format.is_ok_and(|format| match other.0 {
                "entries" => !format.has_table(),
                "prediction" | "side information" => format.coding().is_none(),
                _ => false,
            })
    };
    let apart = |a: &str, b: &str| a == "entries" && matches!(b, "prediction" | "side information");
    !(rules_out(a, b) || rules_out(b, a) || apart(a.0, b.0) || apart(b.0, a.0))
}

fn measure_pairs(suite: &Suite) -> Pairwise {
    let mut values: BTreeMap<&'static str, BTreeSet<String>> = BTreeMap::new();
    let mut seen = BTreeSet::new();
    let decoded = suite.cases.iter();
    let decoded = decoded.filter(|case| case.expect == Expect::Decode);
    for (case, recipe) in decoded.filter_map(|case| Some((case, case.recipe()?))) {
        let chosen = recipe_parameters(case, recipe);
        for (i, (a, x)) in chosen.iter().enumerate() {
            values.entry(a).or_default().insert(x.clone());
            for (b, y) in &chosen[i + 1..] {
                seen.insert(((*a, x.clone()), (*b, y.clone())));
            }
        }
    }
    let (mut pairs, mut covered, mut missing) = (0, 0, Vec::new());
    for (a, xs) in &values {
        for (b, ys) in values.range(*a..).skip(1) {
            for (x, y) in xs.iter().flat_map(|x| ys.iter().map(move |y| (x, y))) {
                if !can_occur_together((a, x), (b, y)) {
                    continue;
                }
                pairs += 1;
                let (one, other) = ((*a, x.clone()), (*b, y.clone()));
                if seen.contains(&(one.clone(), other.clone())) || seen.contains(&(other, one)) {
                    covered += 1;
                } else {
                    missing.push(format!("{a}: {x}, and {b}: {y}"));
                }
            }
        }
    }
    let owned = |(name, values): (&str, BTreeSet<String>)| (name.to_owned(), values);
    Pairwise {
        parameters: values.into_iter().map(owned).collect(),
        pairs,
        covered,
        missing,
    }
}
