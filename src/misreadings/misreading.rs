//! The record of a misreading.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;

use super::at::At;
use crate::formula::Edit;
use crate::kit::yaml;

/// A mistake: a record of `misreadings.yaml`, and the place where it acts. The PTM suite and the texture suite share the record
/// and have different places.
#[derive(Clone, Debug)]
pub struct Misreading<A = At> {
    /// A permanent name.
    pub slug: &'static str,
    /// The clause that it misreads.
    pub clause: &'static str,
    /// Its effect, as a sentence without its subject: "reads …".
    pub effect: &'static str,
    /// The fix, as a sentence without a period.
    pub fix: &'static str,
    /// Its symptom.
    pub shows: Symptom,
    /// Public readers that make it.
    pub seen: Vec<Sighting>,
    /// The place where it acts.
    pub at: A,
}

/// The symptom of a mistake in the answers of a decoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Symptom {
    /// It only refuses legal files.
    Refusals,
    /// It changes values in some files, or accepts files that should be refused.
    #[default]
    Values,
}

/// A public reader that makes a mistake.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sighting {
    /// Its name; for a repository, owner and name.
    pub reader: String,
    /// The examined version, if known.
    pub version: Option<String>,
}

impl fmt::Display for Sighting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.version {
            Some(version) => write!(f, "{} at {version}", self.reader),
            None => f.write_str(&self.reader),
        }
    }
}

/// A record of the YAML file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MisreadingRecord {
    slug: String,
    clause: String,
    effect: String,
    fix: String,
    #[serde(default)]
    shows: Symptom,
    #[serde(default)]
    seen: Vec<Sighting>,
    /// Edits of formulas, by the names of the formulas.
    #[serde(default)]
    edits: BTreeMap<String, String>,
}

/// Joins the records of a YAML file with the places where they act. The place of a record with formulas is made by `edited`; the
/// slug of any other record must be the next one of `acts`.
///
/// The texts are never freed; a catalog is made once.
///
/// # Errors
/// A sentence that names the line.
pub(crate) fn catalog<A: Copy + 'static>(
    yaml: &str,
    mut acts: impl Iterator<Item = &'static (&'static str, A)>,
    edited: impl Fn(&'static [Edit]) -> Option<A>,
) -> Result<Vec<Misreading<A>>, String> {
    let mut all = Vec::new();
    for (line, record) in yaml::records::<MisreadingRecord>(yaml)? {
        let slug: &str = record.slug.leak();
        let edits = record
            .edits
            .iter()
            .map(|(name, text)| Edit::parse(name, text));
        let edits: Vec<Edit> = edits
            .collect::<Result<_, _>>()
            .map_err(|error| format!("line {line}: {error}"))?;
        let at = match (edits.is_empty(), acts.by_ref()) {
            (false, _) => edited(edits.leak()),
            (true, acts) => match acts.next() {
                Some((name, at)) if *name == slug => Some(*at),
                Some((name, _)) => {
                    return Err(format!("line {line}: expected {name}, found {slug}"));
                }
                None => None,
            },
        };
        all.push(Misreading {
            slug,
            clause: record.clause.leak(),
            effect: record.effect.leak(),
            fix: record.fix.leak(),
            shows: record.shows,
            seen: record.seen,
            at: at.ok_or_else(|| format!("line {line}: {slug} acts nowhere"))?,
        });
    }
    match acts.next() {
        Some((name, _)) => Err(format!("expected {name}, found the end of the file")),
        None => Ok(all),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHANGES: &[(&str, u8)] = &[("one", 1), ("two", 2)];

    fn record(slug: &str) -> String {
        format!("- {{ slug: {slug}, clause: 2.1/1, effect: errs, fix: do not }}\n")
    }

    #[track_caller]
    fn rejects(yaml: &str, why: &str) {
        let error = catalog(yaml, CHANGES.iter(), |_| None).expect_err("the catalog is refused");
        assert!(error.contains(why), "{error}");
    }

    #[test]
    fn record_and_decision_become_one_misreading() {
        let yaml = record("one")
            + "- slug: two\n  clause: 2.2/1\n  effect: errs\n  fix: do not\n  shows: refusals\n  seen: [{ reader: someone }]\n";
        let all = catalog(&yaml, CHANGES.iter(), |_| None).unwrap();
        assert_eq!(
            (all[0].slug, all[0].at, all[0].shows),
            ("one", 1, Symptom::Values)
        );
        assert_eq!(
            (all[1].clause, all[1].at, all[1].shows),
            ("2.2/1", 2, Symptom::Refusals)
        );
        assert_eq!(all[1].seen[0].reader, "someone");
    }

    #[test]
    fn unknown_key_is_reported_with_its_line() {
        rejects(&(record("one") + "- slug: two\n  cause: 2.2/1\n"), "line 3");
    }

    #[test]
    fn mismatched_slugs_are_errors() {
        rejects(&record("one"), "expected two, found the end of the file");
        rejects(
            &(record("two") + &record("one")),
            "line 1: expected one, found two",
        );
        rejects(
            &(record("one") + &record("two") + &record("three")),
            "line 3: three acts nowhere",
        );
    }
}
