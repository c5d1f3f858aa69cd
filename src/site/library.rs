//! All subjects of the site, and the addresses of their pages.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::annotated::{Annotated, CHAPTERS, FILES};
use super::example::execute_all;
use super::readers::{ReaderRun, reader_runs};
use super::texts::{TEXTS, Texts};
use super::witness::{Witness, witnesses};
use crate::kit::yaml::from_yaml;
use crate::misreadings;
use crate::readers::profiles;
use crate::suite::address;
use crate::suite::cases::{Case, Suite};
use crate::suite::clauses::{self, Clause, Ruling};
use crate::suite::name::SuiteName;
use crate::suite::texture::cases::{self as texture, TextureCase};
use crate::tools::lint::codes;

/// The id of the protocol between the suite and a decoder.
pub(super) const PROTOCOL: &str = "PTM-CP 1";

/// The data that pages are made from.
pub(super) struct Library {
    pub suite: Suite,
    pub textures: Suite<TextureCase>,
    pub clauses: Vec<Clause>,
    pub rulings: Vec<Ruling>,
    pub requirements: Vec<Clause>,
    pub texture_rulings: Vec<Ruling>,
    pub annotated: Annotated,
    pub texts: Texts,
    pub runs: Vec<ReaderRun>,
    /// The smallest file that shows each misreading.
    pub witnesses: HashMap<&'static str, Witness>,
    /// The results of each reader for each case, in the order of `runs`.
    pub outcomes: Vec<BTreeMap<String, String>>,
    /// Pages by id, from the root of the site.
    places: HashMap<String, String>,
}

impl Library {
    /// Loads all data. `jobs` files are decoded in parallel.
    pub(super) fn open(annotated: Option<Annotated>, jobs: usize) -> Result<Library, String> {
        let annotated = annotated.map_or_else(|| Annotated::read(CHAPTERS, FILES), Ok)?;
        execute_all(&annotated)?;
        let suite = Suite::load()?.prepared();
        let runs = reader_runs()?;
        let owned = |run: &ReaderRun| {
            let outcomes = run.by_case().into_iter();
            outcomes
                .map(|(case, outcome)| (case.to_owned(), outcome.to_owned()))
                .collect()
        };
        let mut library = Library {
            witnesses: witnesses(&suite, jobs),
            suite,
            textures: Suite::of_textures()?,
            clauses: clauses::clauses()?,
            rulings: clauses::rulings()?,
            requirements: texture::clauses()?,
            texture_rulings: texture::rulings()?,
            annotated,
            texts: from_yaml(TEXTS)?,
            outcomes: runs.iter().map(owned).collect(),
            runs,
            places: HashMap::new(),
        };
        library.places = library.all_places();
        Ok(library)
    }

    fn all_places(&self) -> HashMap<String, String> {
        let mut places = HashMap::new();
        let mut put = |id: &str, place: Option<String>| {
            places.extend(place.map(|place| (id.to_owned(), place)));
        };
        let (ptm, texture) = (SuiteName::Ptm, SuiteName::Texture);
        put(PROTOCOL, Some(ptm.protocol_page().to_owned()));
        for case in &self.suite.cases {
            put(&case.id, ptm.case_page(&case.id));
        }
        for misreading in misreadings::all() {
            put(misreading.slug, Some(ptm.misreading_page(misreading.slug)));
        }
        for code in codes::ALL.iter() {
            put(code.id, Some(address::code(code.id)));
        }
        for reader in self.readers() {
            put(reader, Some(address::reader(reader)));
        }
        for chapter in &self.annotated.chapters {
            put(&chapter.section, Some(address::chapter(&chapter.section)));
        }
        let texts = [
            (ptm, &self.clauses, &self.rulings),
            (texture, &self.requirements, &self.texture_rulings),
        ];
        for (suite, clauses, rulings) in texts {
            for clause in clauses {
                put(&clause.id, suite.clause_page(&clause.id));
            }
            for ruling in rulings {
                put(&ruling.id, Some(suite.ruling_page(&ruling.id)));
            }
        }
        for case in &self.textures.cases {
            put(&case.id, texture.case_page(&case.id));
        }
        for misreading in misreadings::texture::all() {
            put(
                misreading.slug,
                Some(texture.misreading_page(misreading.slug)),
            );
        }
        places
    }

    /// Returns the page of an id, from the root of the site.
    pub(super) fn place(&self, id: &str) -> Option<&str> {
        self.places.get(id).map(String::as_str)
    }

    /// Returns every public reader that is known from a run, a profile or a sighting.
    pub(super) fn readers(&self) -> BTreeSet<&str> {
        let seen = misreadings::all().flat_map(|misreading| &misreading.seen);
        let seen = seen.map(|sighting| sighting.reader.as_str());
        seen.chain(self.runs.iter().map(|run| run.reader.as_str()))
            .chain(profiles().iter().map(|profile| profile.reader.as_str()))
            .collect()
    }

    pub(super) fn clause(&self, id: &str) -> Option<&Clause> {
        self.clauses.iter().find(|clause| clause.id == id)
    }

    /// Returns the cases that test a clause.
    pub(super) fn cases_about(&self, clause: &str) -> Vec<&Case> {
        let about = |case: &&Case| case.clauses.iter().any(|id| id == clause);
        self.suite.cases.iter().filter(about).collect()
    }
}
