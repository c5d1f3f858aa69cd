#![doc = include_str!("README.md")]
#![allow(
    clippy::doc_markdown,
    reason = "the README writes format names in plain text"
)]

/// Names and contents of files.
pub type Files = &'static [(&'static str, &'static str)];

/// Expands to the names and contents of the files in a folder.
macro_rules! files {
    ($folder:literal: $($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!($folder, "/", $name)))),*]
    };
}

/// The description of these files.
pub const README: &str = include_str!("README.md");

/// The cases of the PTM suite, in the order of the specification.
pub const CASES: Files = files![
    "cases": "first.yaml", "header.yaml", "scale-bias.yaml", "lookup-table.yaml", "color-matrix.yaml", "texels.yaml",
    "compressed.yaml", "prediction.yaml", "side-information.yaml", "streams.yaml", "evaluate.yaml", "sweeps.yaml",
];

/// Cases of the smoke subset.
pub const SMOKE: &str = include_str!("smoke.yaml");

/// Damages: ways to make a legal file malformed.
pub const DAMAGES: &str = include_str!("damages.yaml");

/// Digest of all generated files and expected images.
pub const CORPUS_DIGEST: &str = include_str!("corpus.sha256");

/// Clauses of the PTM specification, in its order.
pub const CLAUSES: Files = files![".": "clauses.yaml", "clauses-2.9.yaml"];

/// Rulings on open questions of the PTM specification.
pub const RULINGS: Files = files![".": "rulings.yaml"];

/// Formulas that describe decoding.
pub const FORMULAS: &str = include_str!("formulas.yaml");

/// Misreadings of the PTM specification.
pub const MISREADINGS: &str = include_str!("misreadings.yaml");

/// Messages of the command `probe`.
pub const PROBE: &str = include_str!("probe.yaml");

/// Codes of `lint`.
pub const LINT_CODES: &str = include_str!("lint-codes.yaml");

/// Public readers and their behavior.
pub const READERS: &str = include_str!("readers.yaml");

/// README of a directory for outputs that were produced elsewhere.
pub const OUTPUTS_README: &str = include_str!("outputs.txt");

/// README of a profile of an archive.
pub const PROFILE_README: &str = include_str!("profile.md");

/// Git attributes of a profile of an archive.
pub const PROFILE_GITATTRIBUTES: &str = include_str!("profile.gitattributes");

/// The specification, chapter by chapter, with explanations.
pub const CHAPTERS: Files = files![
    "annotated": "1.0-background.yaml", "2.0-file-format.yaml", "2.1-header-string.yaml", "2.2-format-string.yaml",
    "2.3-image-size.yaml", "2.4-scale-and-bias.yaml", "2.5-lookup-table.yaml", "2.6-color-matrix.yaml", "2.7-texel-data.yaml",
    "2.8-indices.yaml", "2.9-compressed.yaml", "2.9.8-planes.yaml",
];

/// Base files for the examples in the chapters.
pub const CHAPTER_FILES: &str = include_str!("annotated/files.yaml");

/// Texts of the website.
pub const SITE_TEXTS: &str = include_str!("site/texts.yaml");

/// The suite for stages of the texture mapping table.
pub mod texture {
    use super::Files;

    /// The description of these files.
    pub const README: &str = include_str!("texture/README.md");

    /// Cases, in the order of the chapter.
    pub const CASES: Files = files![
        "texture/cases": "table.yaml", "parameterization.yaml", "orientation.yaml", "sampling.yaml", "boundary.yaml",
        "composition.yaml", "stage.yaml", "ptm.yaml",
    ];

    /// Requirements of the chapter.
    pub const CLAUSES: Files = files!["texture": "clauses.yaml"];

    /// Rulings on open questions of the chapter.
    pub const RULINGS: Files = files!["texture": "rulings.yaml"];

    /// Texture maps to which cases refer.
    pub const MAPS: &str = include_str!("texture/maps.yaml");

    /// Misreadings of the chapter.
    pub const MISREADINGS: &str = include_str!("texture/misreadings.yaml");
}

/// The suites for programs that write files.
pub mod writers {
    /// Requests to writers.
    pub const REQUESTS: &str = include_str!("writers/requests.yaml");

    /// Mistakes of writers.
    pub const MISTAKES: &str = include_str!("writers/mistakes.yaml");

    /// Sets of photographs for fitters.
    pub const FITTING_SETS: &str = include_str!("writers/fitting-sets.yaml");

    /// Mistakes of fitters.
    pub const FITTING_MISTAKES: &str = include_str!("writers/fitting-mistakes.yaml");
}
