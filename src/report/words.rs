//! What the catalogs say of a misreading that a report names.

use crate::misreadings::{self, texture, writing};
use crate::suite::name::SuiteName;

/// A misreading in words, whichever suite it is of.
pub(super) struct Words {
    pub clause: &'static str,
    pub effect: &'static str,
}

/// Of these slugs those that a catalog knows, with its words.
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

/// How a program is called that is to speak the protocol, line by line.
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
            "A program called by --cmd reads the file {in} and writes a picture to {out}, or prints it; see docs/check.md.".to_owned()
        }
        SuiteName::Ptm => format!(
            "A decoder is called as: DECODER VIEW FILE, for example: {command} raw x.ptm\nFor raw it prints \"PTM1 raw WIDTH HEIGHT CHANNELS u8\", a line feed and the samples; see the README.\nWhat keeps it from that, step by step: ptm-conform probe DECODER"
        ),
    }
}
