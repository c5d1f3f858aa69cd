//! Sentences that the text and HTML reports share, and the catalogs' descriptions of misreadings.

use crate::misreadings::{self, texture, writing};
use crate::report::document::LikelyCause;
use crate::suite::name::SuiteName;

/// The clause and the effect of a misreading of any suite.
pub(super) struct Words {
    pub clause: &'static str,
    pub effect: &'static str,
}

/// Returns the slugs of `slugs` that a catalog knows, with their words.
pub(super) fn known_words(
    suite: SuiteName,
    slugs: &[String],
) -> impl Iterator<Item = (&str, Words)> {
    slugs.iter().filter_map(move |slug| {
        if suite == SuiteName::Writers {
            let of = writing::named(slug)?;
            let (clause, effect) = (of.clause, of.effect);
            return Some((slug.as_str(), Words { clause, effect }));
        }
        let ptm = misreadings::named(slug).map(|of| (of.clause, of.effect));
        let known = ptm.or_else(|| texture::named(slug).map(|of| (of.clause, of.effect)));
        known.map(|(clause, effect)| (slug.as_str(), Words { clause, effect }))
    })
}

/// Maximum number of misreadings with the same effect that are described; the others are counted.
pub(super) const MAX_ALIKE: usize = 3;

/// Counts the misreadings with the same effect beyond the first [`MAX_ALIKE`].
pub(super) fn more_alike(suite: SuiteName, or: &[String]) -> Option<String> {
    match known_words(suite, or).skip(MAX_ALIKE).count() {
        0 => None,
        1 => Some("Would look the same: 1 other misreading, see the report".to_owned()),
        more => Some(format!(
            "Would look the same: {more} other misreadings, see the report"
        )),
    }
}

/// Counts the failures that a cause explains in part.
pub(super) fn partly(cause: &LikelyCause) -> Option<String> {
    match cause.partly.len() {
        0 => None,
        1 => Some("1 other failure is explained in part".to_owned()),
        count => Some(format!("{count} other failures are explained in part")),
    }
}

/// Returns the lines that explain how a program is called.
pub(super) fn how_it_is_called(suite: SuiteName, command: &str) -> String {
    match suite {
        SuiteName::Texture => format!(
            "It is called as: DECODER texture FILE, for example: {command} texture case.json\nFILE is a question in JSON, the answer on standard output a JSON object; see spec-cases/texture/README.md."
        ),
        SuiteName::Writers => format!(
            "A writer is called as: WRITER write REQUEST OUT, for example: {command} write request.json out.ptm\nREQUEST is a JSON file, and the PTM goes to OUT; see docs/writers.md."
        ),
        SuiteName::Fitters => format!(
            "A fitter is called as: FITTER fit REQUEST OUT, for example: {command} fit request.json out.ptm\nREQUEST is a JSON file that names an .lp file, and the PTM goes to OUT; see docs/writers.md."
        ),
        SuiteName::Ptm if command.contains("{in}") => {
            "A program called by --cmd reads the file {in} and writes an image to {out}, or prints it; see docs/check.md.".to_owned()
        }
        SuiteName::Ptm => format!(
            "A decoder is called as: DECODER VIEW FILE, for example: {command} raw x.ptm\nFor raw it prints \"PTM1 raw WIDTH HEIGHT CHANNELS u8\", a line feed and the samples; see docs/protocol.md.\nTo find out what is wrong, step by step: ptm-conform probe DECODER"
        ),
    }
}
