//! Cases: files with their expected results.
//!
//! A case is stored as a recipe. Its bytes and values are generated on demand, so a large suite needs little memory.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use serde::{Deserialize, Serialize};

use super::compare::Expected;
use super::values::{HandPiece, HandValues, Values};
use crate::protocol::frame::View;
use ptm::{Field, Format};
use ptm_generate::{Damage, Model, Recipe, plan::Compression, spelling::Count, write};

/// The expected result of a case, serialized by name in case files and manifests.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Expect {
    /// The correct image.
    Decode,
    /// Exit status 65.
    Reject,
    /// Exit status 65 or 69.
    Refuse,
    /// The correct image, or exit status 65 or 69 (a lenient ruling).
    Lenient,
    /// Like `Lenient`, but any image is correct, because the damage leaves nothing to compare.
    Robust,
    /// One of several spellings, of which a decoder must support at least one (rulings `lut-count`, `lut-newline`).
    Spelling,
    /// Any answer: the implementation decides, and a difference from the reference is reported.
    ImplementationDefined,
}

impl Expect {
    /// Returns true if both the correct image and a refusal are right.
    #[must_use]
    pub fn is_optional(self) -> bool {
        matches!(self, Expect::Lenient | Expect::Robust | Expect::Spelling)
    }

    /// Returns true if only a refusal is right.
    #[must_use]
    pub const fn is_refusal(self) -> bool {
        matches!(self, Expect::Reject | Expect::Refuse)
    }

    /// Returns the name used in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Expect::Decode => "decode",
            Expect::Reject => "reject",
            Expect::Refuse => "refuse",
            Expect::Lenient | Expect::Robust => "lenient",
            Expect::Spelling => "spelling",
            Expect::ImplementationDefined => "implementation-defined",
        }
    }
}

/// A file and its expected result.
#[derive(Clone, Debug)]
pub struct Case {
    /// A permanent slug.
    pub id: String,
    /// Clauses that the case tests.
    pub clauses: Vec<String>,
    /// The purpose of the case, in a sentence.
    pub because: String,
    /// The ruling that the case tests, if any.
    pub ruling: Option<String>,
    /// The expected result.
    pub expect: Expect,
    /// Views that can decide the case, in order of preference.
    pub views: Vec<View>,
    /// True if the case is requested in every view before all other cases.
    pub first: bool,
    /// Id of the case whose valid file was edited to create this file.
    pub twin_of: Option<String>,
    /// Open choices that affect the case, if it declares them.
    pub(super) open_choices: Option<Vec<String>>,
    pub(super) source: Source,
    /// File in the default spelling, if it is precomputed.
    pub(super) prepared_file: Option<Arc<Built>>,
}

#[derive(Clone, Debug)]
pub(super) enum Source {
    Recipe(Recipe, Option<&'static Damage>),
    Hand(Format, Vec<HandPiece>, Option<HandValues>),
}

/// The file of a case with its fields and values.
#[derive(Debug)]
pub struct Built {
    /// Bytes of the file.
    pub file: Vec<u8>,
    /// Fields of the file; empty for damaged and hand-assembled files.
    pub fields: Vec<Field>,
    /// The values that a decoder should find.
    pub values: Values,
    /// For a damaged file that may be read: a legal file with the same values.
    pub(crate) legal: Option<Vec<u8>>,
    /// Correct images in other dialects that were needed so far, by view and combination of readings; `None` if the file is
    /// refused in that dialect.
    pub(crate) images: Mutex<HashMap<(String, usize), Option<Arc<Expected>>>>,
}

/// Spelling of a lookup table in a file. A decoder need not support every spelling.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct TableSpelling {
    /// Spelling of the number of entries (ruling `lut-count`).
    pub count: Count,
    /// True if a line feed follows the table (ruling `lut-newline`).
    pub newline: bool,
}

impl TableSpelling {
    /// Returns all six spellings, in the order in which `check` tries them.
    pub fn all() -> impl Iterator<Item = TableSpelling> {
        let both = |count| [false, true].map(|newline| TableSpelling { count, newline });
        Count::ALL.into_iter().flat_map(both)
    }

    /// Returns the spellings of files of a format, the default spelling first. Files without a table have only one.
    pub fn of(format: Format) -> impl Iterator<Item = TableSpelling> {
        TableSpelling::all().take(if format.has_table() { usize::MAX } else { 1 })
    }
}

impl Case {
    /// Returns the format of the file before any damage.
    #[must_use]
    pub fn format(&self) -> Format {
        match &self.source {
            Source::Recipe(recipe, _) => recipe.format,
            Source::Hand(format, ..) => *format,
        }
    }

    /// Returns the recipe of a generated file.
    #[must_use]
    pub fn recipe(&self) -> Option<&Recipe> {
        match &self.source {
            Source::Recipe(recipe, _) => Some(recipe),
            Source::Hand(..) => None,
        }
    }

    /// Returns the damage to the file, if there is any.
    #[must_use]
    pub fn damage(&self) -> Option<&'static Damage> {
        match &self.source {
            Source::Recipe(_, damage) => *damage,
            Source::Hand(..) => None,
        }
    }

    /// Returns the parts of a hand-assembled file, each with a description and its bytes.
    ///
    /// # Panics
    /// Panics only for a case that [`Suite::load`] did not return.
    #[must_use]
    pub fn pieces(&self) -> Vec<(&str, Vec<u8>)> {
        let Source::Hand(_, pieces, _) = &self.source else {
            return Vec::new();
        };
        let part = |piece| checked(piece, TableSpelling::default());
        (pieces.iter().map(|piece| (&*piece.name, part(piece)))).collect()
    }

    /// Returns the compression of a generated compressed file.
    #[must_use]
    pub fn compression(&self) -> Option<&Compression> {
        let recipe = self.recipe().filter(|one| one.format.coding().is_some())?;
        Some(&recipe.compression)
    }

    /// Returns the open choices of section 2.9 (rulings of kind *choice*) that affect the stored values of this file. The values
    /// do not depend on any other choice.
    #[must_use]
    pub fn axes(&self) -> Vec<&str> {
        match &self.open_choices {
            Some(choices) => choices.iter().map(String::as_str).collect(),
            None => self.compression().map_or_else(Vec::new, Compression::axes),
        }
    }

    /// Generates the file and its values.
    ///
    /// # Panics
    /// Panics only for a case that [`Suite::load`] did not return.
    #[must_use]
    pub fn build(&self, table: TableSpelling) -> Arc<Built> {
        match &self.prepared_file {
            Some(built) if table == TableSpelling::default() => Arc::clone(built),
            _ => Arc::new(self.make(table)),
        }
    }

    fn make(&self, table: TableSpelling) -> Built {
        let mut legal = None;
        let (file, fields, values) = match &self.source {
            Source::Recipe(recipe, damage) => {
                let mut recipe = recipe.clone();
                if self.expect != Expect::Spelling {
                    recipe.spelling.count = table.count;
                    recipe.spelling.newline_after_table = table.newline;
                }
                if let Some(damage) = damage.filter(|_| self.expect.is_optional()) {
                    let (recipe, model) = damage.without_damage(&recipe);
                    legal = Some(write(&recipe, &model).bytes);
                }
                self.write(&recipe, *damage)
            }
            Source::Hand(_, pieces, values) => {
                let bytes = pieces.iter().flat_map(|piece| checked(piece, table));
                let values = values.clone().map_or(Values::None, Values::Hand);
                (bytes.collect(), Vec::new(), values)
            }
        };
        Built {
            file,
            fields,
            values,
            legal,
            images: Mutex::default(),
        }
    }

    fn write(&self, recipe: &Recipe, damage: Option<&Damage>) -> (Vec<u8>, Vec<Field>, Values) {
        let model = Model::paint(recipe);
        let written = write(recipe, &model);
        let values = match (damage, self.expect) {
            (Some(_), Expect::Reject | Expect::Refuse) => Values::None,
            (_, Expect::Robust) => Values::Any,
            (Some(damage), _) => Values::Painted(damage.values(&model)),
            (None, _) => Values::Painted(model.clone()),
        };
        let Some(damage) = damage else {
            return (written.bytes, written.fields, values);
        };
        let file = damage.apply(&written, &model);
        let file = file.expect("damages were checked when the suite was loaded");
        (file, Vec::new(), values)
    }
}

fn checked(piece: &HandPiece, table: TableSpelling) -> Vec<u8> {
    let bytes = piece.bytes(table.count, table.newline);
    bytes.expect("pieces were checked when the suite was loaded")
}

/// All cases, in the order of the report.
#[derive(Clone, Debug)]
pub struct Suite<C = Case> {
    /// The cases.
    pub cases: Vec<C>,
}

impl Suite {
    /// Precomputes all files, which speeds up repeated runs.
    #[must_use]
    pub fn with_prepared_files(mut self) -> Suite {
        for case in &mut self.cases {
            case.prepared_file = Some(Arc::new(case.make(TableSpelling::default())));
        }
        self
    }
}
