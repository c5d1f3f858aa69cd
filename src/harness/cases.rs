//! Reads `spec-cases/`: clauses, rulings and cases.
//!
//! The files are part of the program, so that an installed one needs no checkout. A case is kept as its recipe; its
//! bytes and values are made when they are needed, so that a large suite costs no memory.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt;
use std::sync::{Arc, Mutex};

use serde::Deserialize;

use crate::codec::jpeg_ls::Presets;
use crate::generate::plan::{Coding, Compression, Records, Residuals, Structure};
use crate::generate::recipe::Indices;
use crate::generate::spelling::{Count, Line};
use crate::generate::{Damage, Model, Recipe, write};
use crate::harness::compare::Expected;
use crate::harness::protocol::View;
use crate::ptm::{Field, Format, Size};

/// The files of `spec-cases/cases/`, in the order of the text.
const CASE_FILES: &[(&str, &str)] = &[
    (
        "first.yaml",
        include_str!("../../spec-cases/cases/first.yaml"),
    ),
    (
        "header.yaml",
        include_str!("../../spec-cases/cases/header.yaml"),
    ),
    (
        "scale-bias.yaml",
        include_str!("../../spec-cases/cases/scale-bias.yaml"),
    ),
    (
        "lookup-table.yaml",
        include_str!("../../spec-cases/cases/lookup-table.yaml"),
    ),
    (
        "color-matrix.yaml",
        include_str!("../../spec-cases/cases/color-matrix.yaml"),
    ),
    (
        "texels.yaml",
        include_str!("../../spec-cases/cases/texels.yaml"),
    ),
    (
        "compressed.yaml",
        include_str!("../../spec-cases/cases/compressed.yaml"),
    ),
    (
        "prediction.yaml",
        include_str!("../../spec-cases/cases/prediction.yaml"),
    ),
    (
        "side-information.yaml",
        include_str!("../../spec-cases/cases/side-information.yaml"),
    ),
    (
        "streams.yaml",
        include_str!("../../spec-cases/cases/streams.yaml"),
    ),
    (
        "evaluate.yaml",
        include_str!("../../spec-cases/cases/evaluate.yaml"),
    ),
    (
        "sweeps.yaml",
        include_str!("../../spec-cases/cases/sweeps.yaml"),
    ),
];

/// A rule of the text, in our words.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clause {
    /// Section and ordinal: `2.3/2`.
    pub id: String,
    /// The rule.
    pub rule: String,
    /// How it is covered.
    pub status: Status,
    /// The ruling, where the status is `ruled`.
    pub ruling: Option<String>,
    /// The reason, where the clause is not tested.
    pub why: Option<String>,
}

/// How a clause is covered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// By cases, and by a misreading that violates it and is caught.
    Tested,
    /// It asks nothing of a reader.
    Informative,
    /// No file can show it.
    Untestable,
    /// By cases, under a ruling, because the text leaves it open.
    Ruled,
}

/// How the reference reads what the text leaves open.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ruling {
    /// A slug.
    pub id: String,
    /// The clauses concerned.
    pub clauses: Vec<String>,
    /// What is left open.
    pub question: String,
    /// The reference's own reading.
    pub reading: String,
    /// Other readings, where they are right too.
    #[serde(default)]
    pub also: Vec<String>,
    /// Who reads how, or what real files show.
    pub evidence: String,
    /// What a decoder that reads otherwise is told.
    pub kind: Kind,
}

/// What a ruling means for a verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A decoder that reads otherwise fails.
    Must,
    /// Each listed reading is right, one of them throughout.
    Choice,
    /// Refusing and reading as the reference does are both right.
    Lenient,
}

/// What a case asks of a decoder, as it is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Asked {
    Decode,
    Reject,
    Refuse,
    Lenient,
    Spelling,
    /// As lenient, and every picture is right: only a crash or a hang is wrong.
    Robust,
}

impl Asked {
    fn expect(self) -> Expect {
        match self {
            Asked::Decode => Expect::Decode,
            Asked::Reject => Expect::Reject,
            Asked::Refuse => Expect::Refuse,
            Asked::Lenient | Asked::Robust => Expect::Lenient,
            Asked::Spelling => Expect::Spelling,
        }
    }
}

/// What a case asks of a decoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
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
    shows: Option<Vec<String>>,
    source: Source,
    /// The file in the ordinary spelling, where it has been made ahead.
    prepared: Option<Arc<Built>>,
}

#[derive(Clone, Debug)]
enum Source {
    Recipe {
        recipe: Recipe,
        damage: Option<&'static str>,
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

/// What a file means.
#[derive(Clone, Debug)]
pub enum Values {
    /// Painted by the generator.
    Painted(Model),
    /// Worked out by hand.
    Hand(HandValues),
    /// Whatever a decoder makes of it.
    Any,
    /// Nothing: the file is to be refused.
    None,
}

/// A part of a hand-assembled file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Piece {
    /// What it is.
    is: String,
    text: Option<String>,
    hex: Option<String>,
}

/// The values of a hand-assembled file; a line for each texel, top row first.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandValues {
    /// Width and height.
    pub size: String,
    /// Stored values.
    pub raw: Vec<String>,
    /// Final values.
    pub coef: Option<Vec<String>>,
    /// Colors under a light.
    pub rgb: Option<HandPicture>,
}

/// Colors of a hand-assembled file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandPicture {
    /// `LU,LV`
    pub light: String,
    /// Real numbers from 0 to 255.
    pub texels: Vec<String>,
}

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

/// A thing a decoder may lack.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Feature {
    /// One of the nine formats.
    Format(Format),
    /// Tables with more than 256 entries.
    LargeTables,
    /// The rgb view of LUM files.
    LumColor,
    /// Planes that are predicted from others.
    Prediction,
    /// References that are inverted.
    Inversion,
    /// References that are moved.
    Motion,
    /// Corrections behind the planes.
    SideInformation,
}

impl fmt::Display for Feature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Feature::Format(format) => f.write_str(format.short_name()),
            Feature::LargeTables => f.write_str("tables over 256 entries"),
            Feature::LumColor => f.write_str("rgb of LUM"),
            Feature::Prediction => f.write_str("prediction"),
            Feature::Inversion => f.write_str("inversion"),
            Feature::Motion => f.write_str("motion compensation"),
            Feature::SideInformation => f.write_str("side information"),
        }
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
            Source::Recipe { damage, .. } => damage.and_then(Damage::named),
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
        let bytes = |piece: &Piece| {
            piece
                .bytes(TableSpelling::default())
                .expect("checked when the suite was loaded")
        };
        pieces
            .iter()
            .map(|piece| (piece.is.as_str(), bytes(piece)))
            .collect()
    }

    /// What a decoder needs to decode it in `view`.
    #[must_use]
    pub fn features(&self, view: &View) -> BTreeSet<Feature> {
        let mut features = BTreeSet::from([Feature::Format(self.format())]);
        if self
            .recipe()
            .is_some_and(|recipe| recipe.format.has_table() && recipe.entries > 256)
        {
            features.insert(Feature::LargeTables);
        }
        if self.format() == Format::Lum && matches!(view, View::Rgb(_)) {
            features.insert(Feature::LumColor);
        }
        if let Some(plan) = self.compression() {
            let needs = [
                (Feature::Prediction, plan.predicts()),
                (Feature::Inversion, plan.inverts()),
                (Feature::Motion, plan.moves()),
                (Feature::SideInformation, !plan.records.is_empty()),
            ];
            features.extend(
                needs
                    .into_iter()
                    .filter(|&(_, needed)| needed)
                    .map(|(feature, _)| feature),
            );
        }
        features
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
            _ => Arc::new(self.make(table)),
        }
    }

    fn make(&self, table: TableSpelling) -> Built {
        match &self.source {
            Source::Recipe { recipe, damage } => {
                let mut recipe = recipe.clone();
                if self.expect != Expect::Spelling {
                    recipe.spelling.count = table.count;
                    recipe.spelling.newline_after_table = table.newline;
                }
                let model = Model::paint(&recipe);
                let written = write(&recipe, &model);
                match damage.and_then(Damage::named) {
                    None => Built {
                        file: written.bytes,
                        fields: written.fields,
                        values: if self.any_picture {
                            Values::Any
                        } else {
                            Values::Painted(model)
                        },
                        pictures: Mutex::default(),
                    },
                    Some(damage) => {
                        let file = damage
                            .apply(&written, &model)
                            .expect("checked when the suite was loaded");
                        let values = match self.expect {
                            Expect::Reject | Expect::Refuse => Values::None,
                            Expect::Lenient if self.any_picture => Values::Any,
                            _ => Values::Painted(damage.values(&model)),
                        };
                        Built {
                            file,
                            fields: Vec::new(),
                            values,
                            pictures: Mutex::default(),
                        }
                    }
                }
            }
            Source::Hand { pieces, values, .. } => {
                let file = pieces
                    .iter()
                    .flat_map(|piece| {
                        piece
                            .bytes(table)
                            .expect("checked when the suite was loaded")
                    })
                    .collect();
                Built {
                    file,
                    fields: Vec::new(),
                    values: values.clone().map_or(Values::None, Values::Hand),
                    pictures: Mutex::default(),
                }
            }
        }
    }
}

impl Piece {
    fn bytes(&self, table: TableSpelling) -> Result<Vec<u8>, String> {
        let mut bytes = match (&self.text, &self.hex) {
            (Some(text), None) => text.as_bytes().to_vec(),
            (None, Some(hex)) => unhex(hex)?,
            _ => return Err(format!("piece {:?} needs either text or hex", self.is)),
        };
        if self.is == "count" {
            let text = String::from_utf8_lossy(&bytes);
            let number = text
                .split_whitespace()
                .find(|word| word.parse::<u32>().is_ok())
                .unwrap_or_default();
            bytes = format!("{}\n", table.count.name().replace("256", number)).into_bytes();
        }
        if self.is == "table" && table.newline {
            bytes.push(b'\n');
        }
        Ok(bytes)
    }
}

fn unhex(text: &str) -> Result<Vec<u8>, String> {
    let bytes = text.split_whitespace().map(|pair| {
        if pair.len() == 2 {
            u8::from_str_radix(pair, 16).ok()
        } else {
            None
        }
    });
    bytes
        .collect::<Option<_>>()
        .ok_or_else(|| format!("expected pairs of hex digits, found {text:?}"))
}

/// All cases, in the order in which they are reported.
#[derive(Clone, Debug)]
pub struct Suite {
    /// The cases.
    pub cases: Vec<Case>,
}

impl Suite {
    /// The suite that is part of the program.
    ///
    /// # Errors
    /// A sentence that names the file and the line or case at fault.
    pub fn load() -> Result<Suite, String> {
        Suite::from_files(CASE_FILES)
    }

    /// A suite from case files: name and text of each.
    ///
    /// # Errors
    /// A sentence that names the file and the line or case at fault.
    pub fn from_files(files: &[(&str, &str)]) -> Result<Suite, String> {
        let mut cases: Vec<Case> = Vec::new();
        let mut places = HashMap::new();
        for (name, text) in files {
            let records: Vec<CaseRecord> =
                serde_saphyr::from_str(text).map_err(|error| format!("{name}: {error}"))?;
            for record in records {
                for bindings in record.bindings() {
                    let id = CaseRecord::filled(&record.id, &bindings, true);
                    let case = record.case(&id, &bindings, |parent| {
                        places.get(parent).map(|&at: &usize| &cases[at])
                    });
                    let case = case.map_err(|error| format!("{name}: case {id}: {error}"))?;
                    if places.insert(id.clone(), cases.len()).is_some() {
                        return Err(format!("{name}: case {id} is there twice"));
                    }
                    cases.push(case);
                }
            }
        }
        Ok(Suite { cases })
    }

    /// The same suite with all files made ahead, for those who run it again and again.
    #[must_use]
    pub fn prepared(mut self) -> Suite {
        for case in &mut self.cases {
            case.prepared = Some(Arc::new(case.make(TableSpelling::default())));
        }
        self
    }

    /// The case of that id.
    #[must_use]
    pub fn case(&self, id: &str) -> Option<&Case> {
        self.cases.iter().find(|case| case.id == id)
    }
}

/// The clauses of the text.
///
/// # Errors
/// A sentence that names the line at fault.
pub fn clauses() -> Result<Vec<Clause>, String> {
    let files = [
        (
            "clauses.yaml",
            include_str!("../../spec-cases/clauses.yaml"),
        ),
        (
            "clauses-2.9.yaml",
            include_str!("../../spec-cases/clauses-2.9.yaml"),
        ),
    ];
    let read = |(name, text): (&str, &str)| {
        serde_saphyr::from_str::<Vec<Clause>>(text).map_err(|error| format!("{name}: {error}"))
    };
    Ok(files
        .into_iter()
        .map(read)
        .collect::<Result<Vec<_>, _>>()?
        .concat())
}

/// The rulings of the reference.
///
/// # Errors
/// A sentence that names the line at fault.
pub fn rulings() -> Result<Vec<Ruling>, String> {
    serde_saphyr::from_str(include_str!("../../spec-cases/rulings.yaml"))
        .map_err(|error| format!("rulings.yaml: {error}"))
}

/// A case as it is written: one, or with `for_each` one for every combination of the listed words.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CaseRecord {
    id: String,
    clauses: Vec<String>,
    because: String,
    ruling: Option<String>,
    #[serde(default)]
    for_each: BTreeMap<String, Vec<String>>,
    make: Option<MakeRecord>,
    bytes: Option<Vec<Piece>>,
    values: Option<HandValues>,
    twin_of: Option<String>,
    damage: Option<String>,
    /// Rulings, parted by spaces; `none` for none.
    shows: Option<String>,
    expect: Asked,
    views: Option<Vec<String>>,
    #[serde(default)]
    first: bool,
}

/// A recipe as it is written: what differs from the ordinary file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MakeRecord {
    format: String,
    size: String,
    scene: Option<String>,
    seed: Option<String>,
    scale: Option<String>,
    bias: Option<String>,
    matrix: Option<String>,
    entries: Option<String>,
    indices: Option<String>,
    first_byte: Option<String>,
    #[serde(default)]
    compression: CompressionRecord,
    #[serde(default)]
    spelling: SpellingRecord,
}

/// How planes are compressed, as it is written: what differs from the ordinary way.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct CompressionRecord {
    parameter: Option<String>,
    structure: Option<String>,
    references: Option<String>,
    order: Option<String>,
    /// These three go round and round.
    transforms: Option<String>,
    motion_x: Option<String>,
    motion_y: Option<String>,
    /// Whether planes that are not predicted have transforms and vectors too.
    everywhere: Option<String>,
    records: Option<String>,
    residuals: Option<String>,
    restart_interval: Option<String>,
    optimised_tables: Option<String>,
    baseline: Option<String>,
    sampling: Option<String>,
    jfif: Option<String>,
    presets: Option<String>,
    /// Whether only the streams of every second plane are so.
    alternates: Option<String>,
}

/// A spelling as it is written: what differs from the plain one.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SpellingRecord {
    /// Names of lines, or `all`.
    space_before_newline: Option<String>,
    /// 1 or 2.
    size_lines: Option<String>,
    /// 1 or 2.
    scale_bias_lines: Option<String>,
    gap: Option<String>,
    count: Option<String>,
    newline_after_table: Option<String>,
    matrix_line: Option<String>,
    lists: Option<String>,
}

type Bindings<'a> = Vec<(&'a str, &'a str)>;

impl CaseRecord {
    /// Every combination of the words of `for_each`.
    fn bindings(&self) -> Vec<Bindings<'_>> {
        let mut all: Vec<Bindings> = vec![Vec::new()];
        for (key, words) in &self.for_each {
            let mut longer = Vec::new();
            for bindings in &all {
                longer.extend(
                    words
                        .iter()
                        .map(|word| [&bindings[..], &[(key.as_str(), word.as_str())]].concat()),
                );
            }
            all = longer;
        }
        all
    }

    /// `text` with each `{key}` replaced by its word; of a word `name = value` ids take the name, all else the value.
    fn filled(text: &str, bindings: &Bindings, id: bool) -> String {
        let mut text = text.to_owned();
        for (key, word) in bindings {
            let (name, value) = word.split_once(" = ").unwrap_or((word, word));
            let word = if id { slug(name) } else { value.to_owned() };
            text = text.replace(&format!("{{{key}}}"), &word);
        }
        text
    }

    fn case<'a>(
        &self,
        id: &str,
        bindings: &Bindings,
        parent: impl Fn(&str) -> Option<&'a Case>,
    ) -> Result<Case, String> {
        let fill = |text: &String| Self::filled(text, bindings, false);
        let twin_of = self
            .twin_of
            .as_ref()
            .map(|twin| Self::filled(twin, bindings, true));
        let views = self
            .views
            .iter()
            .flatten()
            .map(|view| fill(view).parse())
            .collect::<Result<Vec<View>, _>>()?;
        let source = match (&self.make, &self.bytes, &twin_of) {
            (Some(make), None, None) => Source::Recipe {
                recipe: make.recipe(&fill)?,
                damage: None,
            },
            (None, Some(pieces), None) => hand_assembled(pieces, self.values.as_ref())?,
            (None, None, Some(twin)) => {
                let recipe = parent(twin)
                    .ok_or_else(|| format!("its twin {twin} does not stand before it"))?
                    .recipe();
                let recipe = recipe
                    .ok_or_else(|| format!("its twin {twin} has no recipe"))?
                    .clone();
                if parent(twin).is_some_and(|twin| twin.twin_of.is_some()) {
                    return Err(format!("its twin {twin} is itself an edit"));
                }
                let name = fill(self.damage.as_ref().ok_or("a twin needs a damage")?);
                let damage =
                    Damage::named(&name).ok_or_else(|| format!("unknown damage {name:?}"))?;
                let model = Model::paint(&recipe);
                damage
                    .apply(&write(&recipe, &model), &model)
                    .ok_or_else(|| format!("damage {name} has no place in {twin}"))?;
                Source::Recipe {
                    recipe,
                    damage: Some(damage.name),
                }
            }
            _ => return Err("a case has one of make, bytes and twin_of".to_owned()),
        };
        if self.expect == Asked::Spelling && self.make.is_none() {
            return Err("a case that expects a spelling is made by a recipe".to_owned());
        }
        let usual_views = || match (&source, &self.values, twin_of.as_deref().and_then(&parent)) {
            (Source::Hand { .. }, Some(values), _) => values.views(),
            (_, _, Some(twin)) => Ok(twin.views.clone()),
            _ => Ok(vec![View::Raw, View::Coef, View::ORDINARY_LIGHT.parse()?]),
        };
        let views = if views.is_empty() {
            usual_views()?
        } else {
            views
        };
        if let Source::Recipe { recipe, .. } = &source {
            check_views(recipe, &views)?;
        }
        let shows = self.shows.as_ref().map(|shows| {
            fill(shows)
                .split_whitespace()
                .filter(|&axis| axis != "none")
                .map(str::to_owned)
                .collect()
        });
        let shows = shows.or_else(|| {
            twin_of
                .as_deref()
                .and_then(&parent)
                .and_then(|twin| twin.shows.clone())
        });
        Ok(Case {
            id: id.to_owned(),
            clauses: self.clauses.clone(),
            because: fill(&self.because)
                .split_whitespace()
                .collect::<Vec<_>>()
                .join(" "),
            ruling: self.ruling.clone(),
            expect: self.expect.expect(),
            any_picture: self.expect == Asked::Robust,
            views,
            first: self.first,
            twin_of,
            shows,
            source,
            prepared: None,
        })
    }
}

impl MakeRecord {
    fn recipe(&self, fill: &impl Fn(&String) -> String) -> Result<Recipe, String> {
        let size: Size = fill(&self.size).parse()?;
        let mut recipe = Recipe::ordinary(fill(&self.format).parse()?, size);
        if let Some(scene) = &self.scene {
            recipe.scene = fill(scene).parse()?;
        }
        if let Some(seed) = &self.seed {
            recipe.seed = number("seed", &fill(seed))?;
        }
        if let Some(scale) = &self.scale {
            recipe.scale = fill(scale).parse()?;
        }
        if let Some(bias) = &self.bias {
            recipe.bias = fill(bias).parse()?;
        }
        if let Some(matrix) = &self.matrix {
            recipe.matrix = fill(matrix).parse()?;
        }
        if let Some(entries) = &self.entries {
            recipe.entries = number("entries", &fill(entries))?;
        }
        if let Some(indices) = &self.indices {
            recipe.indices = parse_indices(&fill(indices))?;
        }
        self.compression.apply(&mut recipe, fill)?;
        if let Some(first) = &self.first_byte {
            recipe.first = Some(number("first_byte", &fill(first))?);
        }
        let spelling = &mut recipe.spelling;
        if let Some(lines) = &self.spelling.space_before_newline {
            let lines = fill(lines);
            let named = || {
                lines
                    .split_whitespace()
                    .map(str::parse)
                    .collect::<Result<Vec<Line>, _>>()
            };
            spelling.space_before_newline = if lines == "all" {
                Line::ALL.to_vec()
            } else {
                named()?
            };
        }
        if let Some(lines) = &self.spelling.size_lines {
            spelling.size_on_two_lines = fill(lines) == "2";
        }
        if let Some(lines) = &self.spelling.scale_bias_lines {
            spelling.scale_bias_on_two_lines = fill(lines) == "2";
        }
        if let Some(gap) = &self.spelling.gap {
            spelling.gap = number("gap", &fill(gap))?;
        }
        if let Some(count) = &self.spelling.count {
            spelling.count = fill(count).parse()?;
        }
        if let Some(newline) = &self.spelling.newline_after_table {
            spelling.newline_after_table = fill(newline) == "true";
        }
        if let Some(line) = &self.spelling.matrix_line {
            spelling.matrix_line = number("matrix_line", &fill(line))?;
        }
        if let Some(lists) = &self.spelling.lists {
            spelling.lists = fill(lists).parse()?;
        }
        recipe.check()?;
        Ok(recipe)
    }
}

impl CompressionRecord {
    fn apply(&self, recipe: &mut Recipe, fill: &impl Fn(&String) -> String) -> Result<(), String> {
        let filled = |field: &Option<String>| field.as_ref().map(fill);
        let plan = &mut recipe.compression;
        if let Some(parameter) = filled(&self.parameter) {
            plan.parameter = number("parameter", &parameter)?;
        }
        if let Some(structure) = filled(&self.structure) {
            plan.set_structure(structure.parse::<Structure>()?);
        }
        if let Some(references) = filled(&self.references) {
            plan.references = numbers("references", &references)?;
        }
        if let Some(order) = filled(&self.order) {
            plan.order = numbers("order", &order)?;
        }
        if plan.references.len() != recipe.format.channels()
            || plan.order.len() != recipe.format.channels()
        {
            return Err(format!(
                "references and order have {} numbers in this format",
                recipe.format.channels()
            ));
        }
        let everywhere = filled(&self.everywhere).is_some_and(|everywhere| everywhere == "true");
        if let Some(transforms) = filled(&self.transforms) {
            plan.transforms = plan.cycled(&numbers("transforms", &transforms)?, everywhere);
        }
        if let Some(motion) = filled(&self.motion_x) {
            plan.motion_x = plan.cycled(&numbers("motion_x", &motion)?, everywhere);
        }
        if let Some(motion) = filled(&self.motion_y) {
            plan.motion_y = plan.cycled(&numbers("motion_y", &motion)?, everywhere);
        }
        if let Some(records) = filled(&self.records) {
            plan.records = records
                .split_whitespace()
                .map(str::parse::<Records>)
                .collect::<Result<_, _>>()?;
        }
        if let Some(residuals) = filled(&self.residuals) {
            plan.residuals = residuals.parse::<Residuals>()?;
        }
        let stream = &mut plan.stream;
        if let Some(interval) = filled(&self.restart_interval) {
            stream.restart_interval = number("restart_interval", &interval)?;
        }
        if let Some(optimised) = filled(&self.optimised_tables) {
            stream.optimised = optimised == "true";
        }
        if let Some(baseline) = filled(&self.baseline) {
            stream.baseline = baseline == "true";
        }
        if let Some(sampling) = filled(&self.sampling) {
            let (across, down) = sampling
                .split_once('x')
                .ok_or("sampling factors are written 2x1")?;
            stream.sampling = (number("sampling", across)?, number("sampling", down)?);
        }
        if let Some(jfif) = filled(&self.jfif) {
            stream.jfif = jfif == "true";
        }
        if let Some(presets) = filled(&self.presets) {
            let list: Vec<u16> = numbers("presets", &presets)?;
            let [maxval, t1, t2, t3, reset] = list
                .try_into()
                .map_err(|_| "presets are MAXVAL T1 T2 T3 RESET".to_owned())?;
            stream.presets = Some(Presets {
                maxval,
                t1,
                t2,
                t3,
                reset,
            });
        }
        if let Some(alternates) = filled(&self.alternates) {
            plan.alternates = alternates == "true";
        }
        Ok(())
    }
}

fn number<T: std::str::FromStr>(name: &str, text: &str) -> Result<T, String> {
    let digits = text.strip_prefix("0x").map_or_else(
        || text.parse().ok(),
        |hex| u32::from_str_radix(hex, 16).ok()?.to_string().parse().ok(),
    );
    digits.ok_or_else(|| format!("expected a number for {name}, found {text:?}"))
}

/// At least one number.
fn numbers<T: std::str::FromStr>(name: &str, text: &str) -> Result<Vec<T>, String> {
    match text
        .split_whitespace()
        .map(|word| number(name, word))
        .collect::<Result<Vec<T>, String>>()?
    {
        list if list.is_empty() => Err(format!("expected numbers for {name}")),
        list => Ok(list),
    }
}

/// A sample that another inverse DCT may turn from 255 to 0 is to be seen raw only, where the distance between the two
/// is one.
fn check_views(recipe: &Recipe, views: &[View]) -> Result<(), String> {
    let lossy = recipe.format.is_compressed()
        && recipe.coding() == Coding::Jpeg
        && recipe.compression.residuals == Residuals::Natural;
    if !lossy || views.iter().all(|view| *view == View::Raw) {
        return Ok(());
    }
    let model = Model::paint(recipe);
    let near_the_edge =
        |(&sample, &slack): (&u8, &u8)| slack > 0 && (sample < slack || 255 - sample < slack);
    match model.samples.iter().zip(&model.slack).any(near_the_edge) {
        true => Err("its samples come too close to 0 or 255 for any view but raw".to_owned()),
        false => Ok(()),
    }
}

/// `any`, `below-256`, `bytes-differ`, or a list of numbers.
fn parse_indices(text: &str) -> Result<Indices, String> {
    if let Some(limit) = text.strip_prefix("below-") {
        return limit
            .parse()
            .map(Indices::Below)
            .map_err(|_| format!("unknown indices {text:?}"));
    }
    match text {
        "any" => Ok(Indices::Any),
        "bytes-differ" => Ok(Indices::BytesDiffer),
        _ => {
            let list: Result<Vec<u32>, _> = text.split_whitespace().map(str::parse).collect();
            list.map(Indices::These)
                .map_err(|_| format!("unknown indices {text:?}"))
        }
    }
}

fn hand_assembled(pieces: &[Piece], values: Option<&HandValues>) -> Result<Source, String> {
    for piece in pieces {
        piece.bytes(TableSpelling::default())?;
    }
    let format = pieces
        .iter()
        .find(|piece| piece.is == "format")
        .and_then(|piece| piece.text.as_ref());
    let format = format
        .ok_or("a hand-assembled file needs a piece that is: format")?
        .trim()
        .parse()?;
    if let Some(values) = values {
        values.check(format)?;
    }
    Ok(Source::Hand {
        format,
        pieces: pieces.to_vec(),
        values: values.cloned(),
    })
}

impl HandValues {
    /// The numbers of `lines`, texel after texel.
    #[must_use]
    pub fn numbers(lines: &[String]) -> Vec<f64> {
        lines
            .iter()
            .flat_map(|line| line.split_whitespace())
            .filter_map(|number| number.parse().ok())
            .collect()
    }

    fn views(&self) -> Result<Vec<View>, String> {
        let coef = self.coef.iter().map(|_| Ok(View::Coef));
        let rgb = self
            .rgb
            .iter()
            .map(|picture| format!("rgb:{}", picture.light).parse());
        std::iter::once(Ok(View::Raw))
            .chain(coef)
            .chain(rgb)
            .collect()
    }

    fn check(&self, format: Format) -> Result<(), String> {
        let texels = self.size.parse::<Size>()?.texels();
        let check = |what: &str, lines: &[String], channels: usize| {
            let words = lines.iter().map(|line| line.split_whitespace().count());
            let numbers = HandValues::numbers(lines).len();
            if lines.len() != texels
                || words.clone().any(|count| count != channels)
                || words.sum::<usize>() != numbers
            {
                return Err(format!("{what} needs {texels} lines of {channels} numbers"));
            }
            Ok(())
        };
        check("raw", &self.raw, format.channels())?;
        check(
            "coef",
            self.coef.as_deref().unwrap_or(&self.raw),
            format.channels(),
        )?;
        self.rgb
            .as_ref()
            .map_or(Ok(()), |picture| check("rgb", &picture.texels, 3))
    }
}

/// A word as it stands in an id: lower case, with hyphens; the sign of a number in words.
fn slug(word: &str) -> String {
    let signed = word.starts_with(|c: char| c == '-' || c.is_ascii_digit());
    let word = if signed {
        word.replace('-', "minus ")
    } else {
        word.to_owned()
    };
    word.to_lowercase()
        .replace(|c: char| !c.is_ascii_alphanumeric(), "-")
}
