//! Cases: one file each and what is expected of it.
//!
//! A case is kept as its recipe; its bytes and values are made when they are needed, so that a large suite costs no memory.

use std::collections::{BTreeSet, HashMap};
use std::sync::{Arc, Mutex, OnceLock};

use serde::Deserialize;

use super::compare::Expected;
use super::features::Feature;
use super::values::{HandValues, Piece, Values};
use crate::generate::plan::Compression;
use crate::generate::spelling::Count;
use crate::generate::{Damage, Model, Recipe, write};
use crate::kit::digest::sha256;
use crate::protocol::frame::View;
use crate::ptm::{Field, Format};

/// What a case asks of a decoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Expect {
    /// The picture.
    Decode,
    /// Exit status 65.
    Reject,
    /// Exit status 65 or 69.
    Refuse,
    /// The picture, or exit status 65 or 69 (a lenient ruling).
    Lenient,
    /// One spelling among several of which a decoder knows at least one (ruling `lut-count`, `lut-newline`).
    Spelling,
    /// Any answer: what it is is left to the implementation, and a difference from the reference is reported.
    ImplementationDefined,
}

impl Expect {
    /// As it is written in cases, manifests and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Expect::Decode => "decode",
            Expect::Reject => "reject",
            Expect::Refuse => "refuse",
            Expect::Lenient => "lenient",
            Expect::Spelling => "spelling",
            Expect::ImplementationDefined => "implementation-defined",
        }
    }
}

/// One file and what is expected of it.
#[derive(Clone, Debug)]
pub struct Case {
    /// A permanent slug.
    pub id: String,
    /// The clauses it is about.
    pub clauses: Vec<String>,
    /// Why it is there, in a sentence.
    pub because: String,
    /// The ruling it shows, if it shows one.
    pub ruling: Option<String>,
    /// What is asked.
    pub expect: Expect,
    /// Whether every picture is right, because the damage leaves nothing that one could be held against.
    pub any_picture: bool,
    /// The views that can decide it, best first.
    pub views: Vec<View>,
    /// Whether it is asked in every view before all others.
    pub first: bool,
    /// The accepted file of which this one is an edit.
    pub twin_of: Option<String>,
    /// The open choices that show in it, where the case says so itself.
    pub(super) shows: Option<Vec<String>>,
    pub(super) source: Source,
    /// The file in the ordinary spelling, where it is precomputed.
    pub(super) prepared: Option<Arc<Built>>,
    /// The digest of that file, once it has been made.
    pub(super) digest: OnceLock<String>,
}

#[derive(Clone, Debug)]
pub(super) enum Source {
    Recipe {
        recipe: Recipe,
        damage: Option<&'static Damage>,
    },
    Hand {
        format: Format,
        pieces: Vec<Piece>,
        values: Option<HandValues>,
    },
}

/// The file of a case and what it means.
#[derive(Debug)]
pub struct Built {
    /// The bytes.
    pub file: Vec<u8>,
    /// What the bytes are, where the generator wrote them undamaged.
    pub fields: Vec<Field>,
    /// What a decoder finds in them.
    pub values: Values,
    /// Its right pictures under every reading of the choices that show in it, for each view that was asked for.
    #[cfg_attr(
        not(unix),
        allow(dead_code, reason = "pictures are compared where decoders are run")
    )]
    pub(crate) pictures: Mutex<HashMap<String, Pictures>>,
}

/// The right picture in each of some dialects; nothing where a dialect refuses the file.
pub(crate) type Pictures = Arc<Vec<Option<Expected>>>;

/// How the number of entries is spelled for a decoder that does not know every spelling.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct TableSpelling {
    /// Ruling `lut-count`.
    pub count: Count,
    /// Ruling `lut-newline`.
    pub newline: bool,
}

impl TableSpelling {
    /// All six, in the order in which a decoder is asked.
    pub fn all() -> impl Iterator<Item = TableSpelling> {
        Count::ALL
            .into_iter()
            .flat_map(|count| [false, true].map(|newline| TableSpelling { count, newline }))
    }
}

impl Case {
    /// The format of the file, or of the file it was before it was damaged.
    #[must_use]
    pub fn format(&self) -> Format {
        match &self.source {
            Source::Recipe { recipe, .. } => recipe.format,
            Source::Hand { format, .. } => *format,
        }
    }

    /// Returns the expectation as manifests name it.
    #[must_use]
    pub fn expectation_name(&self) -> &'static str {
        match self.any_picture {
            true => "robust",
            false => self.expect.name(),
        }
    }

    /// The recipe, where the generator writes the file.
    #[must_use]
    pub fn recipe(&self) -> Option<&Recipe> {
        match &self.source {
            Source::Recipe { recipe, .. } => Some(recipe),
            Source::Hand { .. } => None,
        }
    }

    /// The damage done to the file.
    #[must_use]
    pub fn damage(&self) -> Option<&'static Damage> {
        match &self.source {
            Source::Recipe { damage, .. } => *damage,
            Source::Hand { .. } => None,
        }
    }

    /// The parts of a hand-assembled file: what each is, and its bytes.
    ///
    /// # Panics
    /// Never for a case that [`Suite::load`] returned.
    #[must_use]
    pub fn pieces(&self) -> Vec<(&str, Vec<u8>)> {
        let Source::Hand { pieces, .. } = &self.source else {
            return Vec::new();
        };
        let part = |piece| -> (&str, Vec<u8>) {
            let piece: &Piece = piece;
            (&piece.is, checked(piece, TableSpelling::default()))
        };
        pieces.iter().map(part).collect()
    }

    /// What a decoder needs to decode it in `view`.
    #[must_use]
    pub fn features(&self, view: &View) -> BTreeSet<Feature> {
        let large = |recipe: &Recipe| recipe.format.has_table() && recipe.entries > 256;
        let plan = |asked: fn(&Compression) -> bool| self.compression().is_some_and(asked);
        let needs = [
            (Feature::Format(self.format()), true),
            (Feature::LargeTables, self.recipe().is_some_and(large)),
            (
                Feature::LumColor,
                self.format() == Format::Lum && matches!(view, View::Rgb(_)),
            ),
            (Feature::Prediction, plan(Compression::predicts)),
            (Feature::Inversion, plan(Compression::inverts)),
            (Feature::Motion, plan(Compression::moves)),
            (
                Feature::SideInformation,
                plan(|plan| !plan.records.is_empty()),
            ),
        ];
        let needed = needs.into_iter().filter(|&(_, needed)| needed);
        needed.map(|(feature, _)| feature).collect()
    }

    /// How the planes are compressed, where they are and the generator wrote them.
    #[must_use]
    pub fn compression(&self) -> Option<&Compression> {
        self.recipe()
            .filter(|recipe| recipe.format.is_compressed())
            .map(|recipe| &recipe.compression)
    }

    /// The open choices of 2.9 that show in the stored values of this file: rulings of kind *choice*. Under any reading
    /// of the others its values are the reference's.
    #[must_use]
    pub fn axes(&self) -> Vec<&str> {
        match (&self.shows, self.recipe()) {
            (Some(shows), _) => shows.iter().map(String::as_str).collect(),
            (None, Some(recipe)) if recipe.format.is_compressed() => {
                recipe.compression.axes(recipe.coding())
            }
            _ => Vec::new(),
        }
    }

    /// Makes the file and its values.
    ///
    /// # Panics
    /// Never for a case that [`Suite::load`] returned.
    #[must_use]
    pub fn build(&self, table: TableSpelling) -> Arc<Built> {
        match &self.prepared {
            Some(built) if table == TableSpelling::default() => Arc::clone(built),
            _ => {
                let built = self.make(table);
                if table == TableSpelling::default() {
                    self.digest.get_or_init(|| sha256(&built.file));
                }
                Arc::new(built)
            }
        }
    }

    /// The digest of the file in the ordinary spelling.
    ///
    /// # Panics
    /// Never for a case that [`Suite::load`] returned.
    #[must_use]
    pub fn digest(&self) -> String {
        // Who has asked for the file has made it, and need not make it again.
        let known = self.digest.get().cloned();
        known.unwrap_or_else(|| sha256(&self.build(TableSpelling::default()).file))
    }

    fn make(&self, table: TableSpelling) -> Built {
        match &self.source {
            Source::Recipe { recipe, damage } => self.made(recipe.clone(), *damage, table),
            Source::Hand { pieces, values, .. } => {
                let bytes = pieces.iter().flat_map(|piece| checked(piece, table));
                Built {
                    file: bytes.collect(),
                    fields: Vec::new(),
                    values: values.clone().map_or(Values::None, Values::Hand),
                    pictures: Mutex::default(),
                }
            }
        }
    }

    fn made(&self, mut recipe: Recipe, damage: Option<&Damage>, table: TableSpelling) -> Built {
        if self.expect != Expect::Spelling {
            recipe.spelling.count = table.count;
            recipe.spelling.newline_after_table = table.newline;
        }
        let model = Model::paint(&recipe);
        let written = write(&recipe, &model);
        let values = match (damage, self.expect) {
            (Some(_), Expect::Reject | Expect::Refuse) => Values::None,
            _ if self.any_picture => Values::Any,
            (Some(damage), _) => Values::Painted(damage.values(&model)),
            (None, _) => Values::Painted(model.clone()),
        };
        let (file, fields) = match damage {
            None => (written.bytes, written.fields),
            Some(damage) => {
                let file = damage.apply(&written, &model);
                (file.expect("checked when the suite was loaded"), Vec::new())
            }
        };
        Built {
            file,
            fields,
            values,
            pictures: Mutex::default(),
        }
    }
}

fn checked(piece: &Piece, table: TableSpelling) -> Vec<u8> {
    let bytes = piece.bytes(table.count, table.newline);
    bytes.expect("checked when the suite was loaded")
}

/// All cases, in the order in which they are reported.
#[derive(Clone, Debug)]
pub struct Suite<C = Case> {
    /// The cases.
    pub cases: Vec<C>,
}

impl Suite {
    /// The same suite with all files precomputed, for those who run it again and again.
    #[must_use]
    pub fn prepared(mut self) -> Suite {
        for case in &mut self.cases {
            case.prepared = Some(Arc::new(case.make(TableSpelling::default())));
        }
        self
    }
}
