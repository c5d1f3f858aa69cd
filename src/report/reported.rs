//! Parts of a suite that are needed only for reports.

use maud::Markup;

use crate::diagnose::{self, Causes};
use crate::report::{document::FollowedReading, html::evidence, leniency::passing_case_ids};
use crate::session::run::{Run, Session};
use crate::session::{contact::Contact, observation::Observation, transform};
use ptm_mistakes::Misreading;
use ptm_mistakes::texture::Change;
use ptm_suite::cases::{Case, Expect, Suite, TableSpelling};
use ptm_suite::clauses::{self, Clause, Ruling};
use ptm_suite::features::Feature;
use ptm_suite::kit::digest::sha256;
use ptm_suite::{name::SuiteName, test_case::TestCase, texture, texture::cases::TextureCase};

/// Case type of a suite for which reports can be created.
pub trait Reportable: TestCase {
    /// Name of the suite.
    const SUITE: SuiteName;

    /// Reads the clauses that the suite tests; by default, those of the PTM specification.
    const CLAUSES: fn() -> Result<Vec<Clause>, String> = clauses::clauses;
    /// Reads the rulings on open questions of the specification.
    const RULINGS: fn() -> Result<Vec<Ruling>, String> = clauses::rulings;

    /// Type of the point in a decoder at which a misreading of this suite takes effect.
    type MisreadingPoint: 'static;

    /// Returns the embedded suite.
    ///
    /// # Errors
    /// Returns a message that names the file and the error.
    fn suite() -> Result<Suite<Self>, String>;
    /// Returns a digest of all requests and expected results, in order.
    fn digest(suite: &Suite<Self>) -> String;
    /// Returns the readings that determine only which files are sent to the decoder, not which answers are correct.
    #[must_use]
    fn readings_of_files(_: &Suite<Self>, _: &Run<Self>) -> Vec<FollowedReading> {
        Vec::new()
    }
    /// Shows the file, the response and the difference on the page of a report.
    fn evidence(&self, table: TableSpelling, observation: &Observation<Self>) -> Markup;

    /// Finds transforms that the images of the first files have in common, reports them, and undoes them in all later images.
    fn undo_common_transforms(_: &Suite<Self>, _: &mut Session<Self>, _: &mut Contact<Self>) {}
    /// Assumes the given misreadings. Failures explained by one of them no longer count as failures.
    ///
    /// # Errors
    /// Returns a message that names the first unknown misreading.
    fn assume(_: &Suite<Self>, _: &mut Run<Self>, ids: &[String], _: usize) -> Result<(), String> {
        match ids {
            [] => Ok(()),
            _ => Err("--assume works only with --suite ptm".to_owned()),
        }
    }
    /// Returns the causes of failures, without the assumed misreadings, sorted by the number of cases that each explains.
    fn diagnose(
        suite: &Suite<Self>,
        run: &Run<Self>,
        slugs: &[String],
        jobs: usize,
    ) -> Causes<Self::MisreadingPoint>;
}

/// Looks up misreadings by slug.
///
/// # Errors
/// Returns a message that names the first unknown slug.
pub fn find_misreadings(slugs: &[String]) -> Result<Vec<&'static Misreading>, String> {
    let one = |slug: &String| {
        ptm_mistakes::find(slug).ok_or_else(|| format!("--assume {slug}: unknown misreading"))
    };
    slugs.iter().map(one).collect()
}

impl Reportable for Case {
    const SUITE: SuiteName = SuiteName::Ptm;

    type MisreadingPoint = ptm_mistakes::Change;

    fn suite() -> Result<Suite, String> {
        Suite::load()
    }

    /// Returns the recorded digest of all files. Generating the files would take longer than most runs of single cases.
    fn digest(_: &Suite) -> String {
        ptm_spec_cases::CORPUS_DIGEST.trim().to_owned()
    }

    fn readings_of_files(suite: &Suite, run: &Run) -> Vec<FollowedReading> {
        let is_table =
            |feature: &Feature| matches!(feature, Feature::Format(format) if format.has_table());
        if !run.judgment.decoded.iter().any(is_table) {
            return Vec::new();
        }
        let newline = ["nothing", "one line feed"][usize::from(run.table.newline)];
        let reading = |ruling: &str, reading: &str| FollowedReading {
            ruling: ruling.to_owned(),
            reading: reading.to_owned(),
            shown_by: passing_case_ids(suite, run, |i| {
                let case = &suite.cases[i];
                case.expect == Expect::Spelling && case.ruling.as_deref() == Some(ruling)
            }),
        };
        let count = reading("lut-count", run.table.count.name());
        vec![count, reading("lut-newline", newline)]
    }

    /// Shows the file, the response and the difference on the page of a report.
    fn evidence(&self, table: TableSpelling, observation: &Observation) -> Markup {
        evidence::case_evidence(self, table, observation)
    }

    fn undo_common_transforms(suite: &Suite, session: &mut Session<Case>, contact: &mut Contact) {
        let common = transform::common_transforms(suite, contact);
        let remarks = &mut contact.remarks;
        remarks.splice(0..0, transform::remarks(&common));
        session.undone_transforms = common.into_iter().map(|one| one.undo).collect();
    }

    fn assume(suite: &Suite, run: &mut Run, slugs: &[String], jobs: usize) -> Result<(), String> {
        diagnose::assume(suite, run, &find_misreadings(slugs)?, jobs);
        Ok(())
    }

    fn diagnose(suite: &Suite, run: &Run, slugs: &[String], jobs: usize) -> Causes {
        // `assume` has already rejected unknown slugs.
        let assumed = find_misreadings(slugs).unwrap_or_default();
        diagnose::diagnose(suite, run, &assumed, jobs)
    }
}

impl Reportable for TextureCase {
    const SUITE: SuiteName = SuiteName::Texture;
    const CLAUSES: fn() -> Result<Vec<Clause>, String> = texture::cases::clauses;
    const RULINGS: fn() -> Result<Vec<Ruling>, String> = texture::cases::rulings;

    type MisreadingPoint = Change;

    fn suite() -> Result<Suite<TextureCase>, String> {
        Suite::load_texture()
    }

    fn digest(suite: &Suite<TextureCase>) -> String {
        let text = |case: &TextureCase| format!("{}{}{}", case.id, case.question(), case.expect);
        sha256(suite.cases.iter().map(text).collect::<String>().as_bytes())
    }

    fn evidence(&self, _: TableSpelling, observation: &Observation<TextureCase>) -> Markup {
        evidence::question_evidence(self, observation)
    }

    fn diagnose(suite: &Suite<Self>, run: &Run<Self>, _: &[String], _: usize) -> Causes<Change> {
        diagnose::texture::diagnose(suite, run).into()
    }
}
