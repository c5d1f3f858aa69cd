//! Data from which the site is generated, and the URLs of the pages.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use serde::Deserialize;

use super::annotated::{Annotated, CHAPTERS, Chapter, FILES};
use super::example::execute_all;
use super::objects::{Objects, ShownReader};
use super::reader_pages;
use super::readers::{ReaderRun, reader_runs};
use super::witness::{MisreadingWitness, witnesses};
use ptm_files::lint::codes;
use ptm_files::readers::profiles;
use ptm_mistakes::Misreading;
use ptm_suite::address;
use ptm_suite::cases::{Case, Suite};
use ptm_suite::clauses::{self, Clause, Ruling};
use ptm_suite::kit::yaml::from_yaml;
use ptm_suite::name::SuiteName;
use ptm_suite::texture::cases::{self as texture, TextureCase};

/// Id of the protocol between the suite and a decoder.
pub(super) const PROTOCOL: &str = "PTM-CP 1";

/// Description of the protocol in the search index.
const PROTOCOL_DESCRIPTION: &str =
    "the requests to a decoder, and the meaning of exit statuses 0, 65, 69 and others";

/// Subject of a page in the search index: id, kind, URL relative to the root of the site, and description.
type PageSubject<'a> = (&'a str, &'static str, String, &'a str);

/// Data from which pages are generated.
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
    /// For each misreading, the smallest file that reveals it.
    pub witnesses: HashMap<&'static str, MisreadingWitness>,
    /// Objects that can be relit.
    pub objects: Objects,
    /// For each id, the URL of its page, relative to the root of the site.
    page_urls: HashMap<String, String>,
}

impl Library {
    /// Loads all data. Decodes up to `jobs` files in parallel.
    pub(super) fn open(annotated: Option<Annotated>, jobs: usize) -> Result<Library, String> {
        let annotated = annotated.map_or_else(|| Annotated::read(CHAPTERS, FILES), Ok)?;
        execute_all(&annotated)?;
        let suite = Suite::load()?.with_prepared_files();
        let mut library = Library {
            witnesses: witnesses(&suite, jobs),
            suite,
            objects: Objects::render(jobs),
            textures: Suite::load_texture()?,
            clauses: clauses::clauses()?,
            rulings: clauses::rulings()?,
            requirements: texture::clauses()?,
            texture_rulings: texture::rulings()?,
            annotated,
            texts: from_yaml(TEXTS)?,
            runs: reader_runs()?,
            page_urls: HashMap::new(),
        };
        let readers: Vec<ShownReader> = library
            .readers()
            .into_iter()
            .map(reader_pages::shown_reader)
            .collect();
        library.objects.render_readers(readers, jobs);
        // If two subjects have the same id, links lead to the first.
        let subjects = library.subjects().into_iter().rev();
        library.page_urls = (subjects.map(|(id, _, url, _)| (id.to_owned(), url))).collect();
        Ok(library)
    }

    /// Returns all subjects that have a page, in the order of the search index.
    pub(super) fn subjects(&self) -> Vec<PageSubject<'_>> {
        let (ptm, texture) = (SuiteName::Ptm, SuiteName::Texture);
        let mut subjects = Vec::new();
        let mut put = |id, kind, url: Option<String>, text| {
            subjects.extend(url.map(|url| (id, kind, url, text)));
        };
        let protocol = ptm.protocol_page().to_owned();
        put(PROTOCOL, "protocol", Some(protocol), PROTOCOL_DESCRIPTION);
        for Chapter { section, title, .. } in &self.annotated.chapters {
            put(section, "section", Some(address::chapter(section)), title);
        }
        for Clause { id, rule, .. } in &self.clauses {
            put(id, "clause", ptm.clause_page(id), rule);
        }
        for Ruling { id, question, .. } in &self.rulings {
            put(id, "ruling", Some(ptm.ruling_page(id)), question.trim());
        }
        for code in codes::ALL.iter() {
            let page = address::code(code.id);
            put(code.id, "lint code", Some(page), code.message);
        }
        for reader in self.readers() {
            put(reader, "reader", Some(address::reader(reader)), "");
        }
        for Misreading { slug, effect, .. } in ptm_mistakes::all() {
            put(slug, "misreading", Some(ptm.misreading_page(slug)), effect);
        }
        for Case { id, because, .. } in &self.suite.cases {
            put(id, "case", ptm.case_page(id), because);
        }
        for Clause { id, rule, .. } in &self.requirements {
            put(id, "texture", texture.clause_page(id), rule);
        }
        for Ruling { id, question, .. } in &self.texture_rulings {
            let page = Some(texture.ruling_page(id));
            put(id, "texture ruling", page, question.trim());
        }
        for Misreading { slug, effect, .. } in ptm_mistakes::texture::all() {
            let page = Some(texture.misreading_page(slug));
            put(slug, "texture misreading", page, effect);
        }
        for TextureCase { id, because, .. } in &self.textures.cases {
            put(id, "texture case", texture.case_page(id), because);
        }
        subjects
    }

    /// Returns the URL of the page for an id, relative to the root of the site.
    pub(super) fn page_url(&self, id: &str) -> Option<&str> {
        self.page_urls.get(id).map(String::as_str)
    }

    /// Returns all public readers that are known from a run, a profile or a sighting.
    pub(super) fn readers(&self) -> BTreeSet<&str> {
        let seen = ptm_mistakes::behaviors().flat_map(|misreading| &misreading.sightings);
        let seen = seen.map(|sighting| sighting.reader.as_str());
        seen.chain(self.runs.iter().map(|run| run.reader.as_str()))
            .chain(profiles().iter().map(|profile| profile.reader.as_str()))
            .collect()
    }

    pub(super) fn clause(&self, id: &str) -> Option<&Clause> {
        self.clauses.iter().find(|clause| clause.id == id)
    }
}

/// YAML source of [`Texts`].
const TEXTS: &str = ptm_spec_cases::SITE_TEXTS;

/// Name or URL, and the associated text.
type NamedText = (String, String);

/// Descriptions by name.
pub(super) type NamedTexts = BTreeMap<String, String>;

/// Text and tables shown on the site. `spec-cases/site/texts.yaml` describes the fields.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Texts {
    pub navigation: Vec<NamedText>,
    pub glossary: NamedTexts,
    pub topics: Vec<NamedText>,
    pub steps: Vec<NamedText>,
    pub counts: Vec<NamedText>,
    pub drawings: Vec<Drawing>,
    pub flow: Vec<(String, String, String)>,
    pub expectations: NamedTexts,
    pub ruling_kinds: NamedTexts,
    pub severities: NamedTexts,
}

/// Diagram of a kind of file: its parts and the sections that describe them.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Drawing {
    pub name: String,
    pub text: Vec<NamedText>,
    pub bytes: Vec<NamedText>,
}
