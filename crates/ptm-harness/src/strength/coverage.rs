//! Measurements of the suite: coverage of clauses, kills, separations, pairs of parameters, and redundant cases.
//!
//! - The *coverage* of a clause consists of its cases, and of those of its misreadings that the suite catches.
//! - A case *kills* a misreading that makes a decoder fail the case, and *separates* two misreadings whose answers differ.
//! - A case is *redundant* if, without it, every misreading is still killed and every pair is still separated. Such a case may
//!   exist for its clause, or for a mistake that nobody has made yet.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use crate::strength::matrix::MatrixRow;
use ptm::{Format, Size};
use ptm_generate::{Numbers, Recipe};
use ptm_suite::cases::{Case, Expect, Suite};
use ptm_suite::clauses::{self, ClauseStatus};

/// All measurements of a suite.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Coverage {
    /// Coverage of every clause, in the order of the specification.
    pub clauses: Vec<ClauseCoverage>,
    /// Kills of every misreading, in the order of the catalog.
    pub misreadings: Vec<Kills>,
    /// Separation of misreadings, including sets that are not separated.
    pub separation: Separation,
    /// Pairs of parameter values that occur together in some file.
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
    /// Slugs of the clause's misreadings that the suite kills.
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
    /// Number of pairs that at least one case separates.
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
    /// Number of pairs of values that occur together in a must-accept file.
    pub covered: usize,
    /// Pairs of values that can occur together, but do not.
    pub missing: Vec<String>,
}

impl Coverage {
    /// Computes all measurements from the matrix of a suite.
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
        let (separation, mut needed) = measure_separation(suite, rows);
        for row in rows {
            if let [only] = row.killed_by[..] {
                needed.insert(only);
            }
        }
        let redundant = (0..suite.cases.len()).filter(|i| !needed.contains(i));
        Ok(Coverage {
            clauses: measure_clauses(suite, rows)?,
            misreadings: kills.collect(),
            separation,
            pairwise: measure_pairs(suite),
            redundant: redundant.map(|i| id(&i)).collect(),
        })
    }

    /// Formats the measurements for a terminal.
    #[must_use]
    pub fn to_text(&self, suite: &Suite) -> String {
        let mut lines = Vec::new();
        self.describe_clauses(&mut lines);
        self.describe_misreadings(&mut lines);
        let missing = &self.pairwise.missing;
        let (covered, pairs) = (self.pairwise.covered, self.pairwise.pairs);
        lines.push(format!(
            "pairs of recipe parameters: {covered} of {pairs} occur in a file that must be decoded"
        ));
        let listed = missing.iter().take(MAX_MISSING);
        lines.extend(listed.map(|pair| format!("  missing: {pair}")));
        if missing.len() > MAX_MISSING {
            let more = missing.len() - MAX_MISSING;
            lines.push(format!("  … and {more} more; --yaml lists them"));
        }
        let (redundant, all) = (self.redundant.len(), suite.cases.len());
        lines.push(format!(
            "redundant: for {redundant} of {all} cases, other cases detect the same misreadings and distinguish the same pairs\n"
        ));
        lines.join("\n")
    }

    fn describe_clauses(&self, lines: &mut Vec<String>) {
        let mut statuses: BTreeMap<&str, usize> = BTreeMap::new();
        for clause in &self.clauses {
            *statuses.entry(&clause.status).or_default() += 1;
        }
        let statuses = statuses.iter();
        let statuses = statuses.map(|(status, count)| format!("{count} {status}"));
        let (all, statuses) = (self.clauses.len(), statuses.collect::<Vec<_>>().join(", "));
        lines.push(format!("clauses: {all}: {statuses}"));
        for coverage in &self.clauses {
            let (clause, cases) = (&coverage.clause, coverage.cases);
            if coverage.status == "tested" && (cases == 0 || coverage.killed.is_empty()) {
                lines.push(format!(
                    "  {clause}: {cases} cases, but none detects a misreading"
                ));
            }
        }
    }

    fn describe_misreadings(&self, lines: &mut Vec<String>) {
        let all = self.misreadings.len();
        let killed = self.misreadings.iter().filter(|kills| kills.count > 0);
        lines.push(format!("misreadings: {} of {all} killed", killed.count()));
        for kills in self.misreadings.iter().filter(|kills| kills.count < 2) {
            let (slug, clause) = (&kills.misreading, &kills.clause);
            let case = kills.cases.first().map_or("no case", String::as_str);
            lines.push(format!("  {slug} ({clause}): killed by {case}"));
        }
        let (separated, pairs) = (self.separation.separated, self.separation.pairs);
        lines.push(format!(
            "pairs of misreadings: {separated} of {pairs} distinguished"
        ));
        let alike = self.separation.alike.iter().map(|set| set.join(", "));
        lines.extend(alike.map(|set| format!("  equivalent in every case: {set}")));
    }
}

/// Maximum number of missing pairs of values that the summary lists.
const MAX_MISSING: usize = 20;

fn measure_clauses(suite: &Suite, rows: &[MatrixRow]) -> Result<Vec<ClauseCoverage>, String> {
    let coverage = |clause: clauses::Clause| {
        let status = match clause.status {
            ClauseStatus::Tested => "tested",
            ClauseStatus::Ruled => "ruled",
            ClauseStatus::Informative => "informative",
            ClauseStatus::Untestable => "untestable",
        };
        let cases = suite.cases.iter();
        let cases = cases.filter(|case| case.clauses.contains(&clause.id));
        let killed = rows.iter().filter(|row| !row.killed_by.is_empty());
        let killed = killed.map(|row| row.misreading);
        let killed = killed.filter(|misreading| misreading.clause == clause.id);
        ClauseCoverage {
            status: status.to_owned(),
            cases: cases.count(),
            killed: killed.map(|killed| killed.slug.to_owned()).collect(),
            clause: clause.id,
        }
    };
    Ok(clauses::clauses()?.into_iter().map(coverage).collect())
}

/// Returns the separation of misreadings, and the cases without which some pair would not be separated.
fn measure_separation(suite: &Suite, rows: &[MatrixRow]) -> (Separation, BTreeSet<usize>) {
    let mut unique_separators = BTreeSet::new();
    let mut alike: BTreeMap<&[u64], Vec<String>> = BTreeMap::new();
    let mut separated = 0;
    for (i, a) in rows.iter().enumerate() {
        let slug = a.misreading.slug.to_owned();
        alike.entry(&a.answers).or_default().push(slug);
        for b in &rows[i + 1..] {
            let mut separating = (0..suite.cases.len()).filter(|&c| a.answers[c] != b.answers[c]);
            if let Some(first) = separating.next() {
                separated += 1;
                unique_separators.extend(separating.next().is_none().then_some(first));
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

fn recipe_parameters(case: &Case, recipe: &Recipe) -> Vec<(&'static str, String)> {
    let spelling = &recipe.spelling;
    let line_count = |two: bool| if two { "two lines" } else { "one line" };
    let yes_or_no = |yes: bool| if yes { "yes" } else { "no" };
    let bias = match recipe.bias.values.iter().any(|&bias| bias > 255.0) {
        true => "over 255",
        false => number_kind(&recipe.bias),
    };
    let scale_bias = spelling.scale_bias_on_two_lines;
    let space = !spelling.space_before_newline.is_empty();
    let mut parameters = vec![
        ("format", recipe.format.short_name()),
        ("size", size_kind(recipe.size)),
        ("size is written on", line_count(spelling.size_on_two_lines)),
        ("scale and bias are written on", line_count(scale_bias)),
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
        parameters.push(("entries", entries));
    }
    if let Some(plan) = case.compression() {
        let prediction = match (plan.predicts(), plan.inverts(), plan.displaces()) {
            (false, ..) => "none",
            (_, false, false) => "plain",
            (_, true, false) => "inverted",
            (_, false, true) => "displaced",
            (_, true, true) => "inverted and displaced",
        };
        parameters.push(("prediction", prediction));
        parameters.push(("side information", yes_or_no(!plan.records.is_empty())));
    }
    let owned = |(name, value): (&'static str, &str)| (name, value.to_owned());
    parameters.into_iter().map(owned).collect()
}

fn number_kind(numbers: &Numbers<6>) -> &'static str {
    let values = &numbers.values;
    if numbers.texts().iter().any(|text| text.contains(['e', 'E'])) {
        "with an exponent"
    } else if values.iter().any(|&value| value < 0.0) {
        "negative"
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
        _ => "not square",
    }
}

/// Returns true if this value of the first parameter rules out the second parameter.
fn rules_out((name, value): (&str, &str), other: &str) -> bool {
    let is_of_planes = matches!(other, "prediction" | "side information");
    match (name, value.parse::<Format>()) {
        ("entries", _) => is_of_planes,
        ("format", Ok(format)) if is_of_planes => format.coding().is_none(),
        ("format", Ok(format)) => other == "entries" && !format.has_table(),
        _ => false,
    }
}

fn measure_pairs(suite: &Suite) -> Pairwise {
    let mut values: BTreeMap<&'static str, BTreeSet<String>> = BTreeMap::new();
    let mut seen = BTreeSet::new();
    for case in &suite.cases {
        let recipe = case.recipe().filter(|_| case.expect == Expect::Decode);
        let Some(recipe) = recipe else { continue };
        let parameters = recipe_parameters(case, recipe);
        for (i, (a, x)) in parameters.iter().enumerate() {
            values.entry(a).or_default().insert(x.clone());
            for (b, y) in &parameters[i + 1..] {
                seen.insert(BTreeSet::from([(*a, x.clone()), (*b, y.clone())]));
            }
        }
    }
    let (mut pairs, mut missing) = (0, Vec::new());
    for (a, xs) in &values {
        for (b, ys) in values.range(*a..).skip(1) {
            for (x, y) in xs.iter().flat_map(|x| ys.iter().map(move |y| (x, y))) {
                if rules_out((a, x), b) || rules_out((b, y), a) {
                    continue;
                }
                pairs += 1;
                if !seen.contains(&BTreeSet::from([(*a, x.clone()), (*b, y.clone())])) {
                    missing.push(format!("{a}: {x}, and {b}: {y}"));
                }
            }
        }
    }
    let parameters = values.into_iter();
    let parameters = parameters.map(|(name, values)| (name.to_owned(), values));
    Pairwise {
        parameters: parameters.collect(),
        pairs,
        covered: pairs - missing.len(),
        missing,
    }
}
