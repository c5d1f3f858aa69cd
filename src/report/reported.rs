//! What a report says of a suite beyond what a run needs to know of it.

use maud::Markup;

use crate::diagnose::{self, Causes};
use crate::kit::digest::sha256;
use crate::kit::parallel::in_parallel;
use crate::misreadings::texture::Change;
use crate::misreadings::{self, At, Misreading};
use crate::ptm::Format;
use crate::report::document::FollowedReading;
use crate::report::html::evidence;
use crate::report::leniency::passing;
use crate::session::asking::Undo;
use crate::session::contact::Contact;
use crate::session::observation::Observation;
use crate::session::remark::Remark;
use crate::session::run::Run;
use crate::session::transform;
use crate::suite::cases::{Case, Expect, Suite, TableSpelling};
use crate::suite::clauses::{self, Clause, Ruling};
use crate::suite::features::Feature;
use crate::suite::name::SuiteName;
use crate::suite::test_case::TestCase;
use crate::suite::texture;
use crate::suite::texture::cases::TextureCase;

/// A case of a suite on which reports are made.
pub trait Reported: TestCase {
    /// The name of the suite.
    const SUITE: SuiteName;

    /// The kind of place where its misreadings act.
    type Place: 'static;

    /// The suite that is part of the program.
    ///
    /// # Errors
    /// What is wrong with which file.
    fn suite() -> Result<Suite<Self>, String>;
    /// Returns the clauses of the text: of the PTM specification, unless the suite has another text.
    ///
    /// # Errors
    /// What is wrong with the file.
    fn all_clauses() -> Result<Vec<Clause>, String> {
        clauses::clauses()
    }
    /// Returns the rulings on what the text leaves open.
    ///
    /// # Errors
    /// What is wrong with the file.
    fn all_rulings() -> Result<Vec<Ruling>, String> {
        clauses::rulings()
    }
    /// A digest of all that is asked and expected, in order.
    fn digest(suite: &Suite<Self>) -> String;
    /// Readings of open questions that change no answer but the file that is sent.
    #[must_use]
    fn readings_of_files(_: &Suite<Self>, _: &Run<Self>) -> Vec<FollowedReading> {
        Vec::new()
    }
    /// Whether a view that is lacking of a kind is a feature of its own, which is listed anyway.
    #[must_use]
    fn is_listed(_: &str, _: &Self::Feature) -> bool {
        false
    }
    /// What there is to see of a failure.
    fn evidence(&self, table: TableSpelling, observation: &Observation<Self>) -> Markup;

    /// What all first files have in common that is wrong: how it is undone, and what is to be said of it.
    #[must_use]
    fn common_transforms(_: &Suite<Self>, _: &Contact<Self>) -> (Vec<Undo<Self>>, Vec<Remark>) {
        (Vec::new(), Vec::new())
    }
    /// Takes mistakes as given: failures that they explain are no failures any more.
    ///
    /// # Errors
    /// A sentence with the first name that is none of a misreading.
    fn assume(
        _: &Suite<Self>,
        _: &mut Run<Self>,
        slugs: &[String],
        _: usize,
    ) -> Result<(), String> {
        match slugs {
            [] => Ok(()),
            _ => Err("--assume is for decoders".to_owned()),
        }
    }
    /// Why the failures failed, beside the mistakes that are taken as given; most telling first.
    fn diagnose(
        suite: &Suite<Self>,
        run: &Run<Self>,
        slugs: &[String],
        jobs: usize,
    ) -> Causes<Self::Place>;
}

/// The misreadings of these names.
///
/// # Errors
/// A sentence with the first that is none.
pub fn named(slugs: &[String]) -> Result<Vec<&'static Misreading>, String> {
    let one = |slug: &String| {
        misreadings::named(slug).ok_or_else(|| format!("--assume {slug}: unknown misreading"))
    };
    slugs.iter().map(one).collect()
}

impl Reported for Case {
    const SUITE: SuiteName = SuiteName::Ptm;

    type Place = At;

    fn suite() -> Result<Suite, String> {
        Suite::load()
    }

    fn digest(suite: &Suite) -> String {
        let jobs = std::thread::available_parallelism().map_or(1, usize::from);
        let digest = |place: usize| suite.cases[place].digest();
        let digests = in_parallel(suite.cases.len(), jobs, &|_, _| (), &digest);
        sha256(digests.concat().as_bytes())
    }

    fn readings_of_files(suite: &Suite, run: &Run) -> Vec<FollowedReading> {
        let decoded = &run.judgement.decoded;
        let is_table =
            |feature: &Feature| matches!(feature, Feature::Format(format) if format.has_table());
        if !decoded.iter().any(is_table) {
            return Vec::new();
        }
        let newline = match run.table.newline {
            true => "one line feed",
            false => "nothing",
        };
        let reading = |ruling: &str, reading: &str| FollowedReading {
            ruling: ruling.to_owned(),
            reading: reading.to_owned(),
            shown_by: passing(suite, run, |i| {
                let case = &suite.cases[i];
                case.expect == Expect::Spelling && case.ruling.as_deref() == Some(ruling)
            }),
        };
        vec![
            reading("lut-count", run.table.count.name()),
            reading("lut-newline", newline),
        ]
    }

    fn is_listed(view: &str, kind: &Feature) -> bool {
        // The colors of LUM.
        view == "rgb" && *kind == Feature::Format(Format::Lum)
    }

    fn evidence(&self, table: TableSpelling, observation: &Observation) -> Markup {
        evidence::of_case(self, table, observation)
    }

    fn common_transforms(suite: &Suite, contact: &Contact) -> (Vec<Undo<Case>>, Vec<Remark>) {
        let common = transform::common(suite, contact);
        let said = transform::in_words(&common);
        (common.into_iter().map(|of| of.undo).collect(), said)
    }

    fn assume(suite: &Suite, run: &mut Run, slugs: &[String], jobs: usize) -> Result<(), String> {
        diagnose::assume(suite, run, &named(slugs)?, jobs);
        Ok(())
    }

    fn diagnose(suite: &Suite, run: &Run, slugs: &[String], jobs: usize) -> Causes {
        // What no catalog knows has been refused before.
        let assumed = named(slugs).unwrap_or_default();
        diagnose::diagnose(suite, run, &assumed, jobs)
    }
}

impl Reported for TextureCase {
    const SUITE: SuiteName = SuiteName::Texture;

    type Place = Change;

    fn suite() -> Result<Suite<TextureCase>, String> {
        Suite::of_textures()
    }

    fn all_clauses() -> Result<Vec<Clause>, String> {
        texture::cases::clauses()
    }

    fn all_rulings() -> Result<Vec<Ruling>, String> {
        texture::cases::rulings()
    }

    fn digest(suite: &Suite<TextureCase>) -> String {
        let cases = suite.cases.iter();
        let all: String = cases
            .map(|case| format!("{}{}{}", case.id, case.question(), case.expect))
            .collect();
        sha256(all.as_bytes())
    }

    fn evidence(&self, _: TableSpelling, observation: &Observation<TextureCase>) -> Markup {
        evidence::of_question(self, observation)
    }

    fn assume(
        _: &Suite<TextureCase>,
        _: &mut Run<TextureCase>,
        slugs: &[String],
        _: usize,
    ) -> Result<(), String> {
        match slugs {
            [] => Ok(()),
            _ => Err("--assume is for the suite of PTM files".to_owned()),
        }
    }

    fn diagnose(
        suite: &Suite<TextureCase>,
        run: &Run<TextureCase>,
        _: &[String],
        _: usize,
    ) -> Causes<Change> {
        diagnose::texture::diagnose(suite, run).into()
    }
}
