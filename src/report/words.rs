//! What the catalogs say of a misreading that a report names.

use crate::misreadings::{self, texture, writing};
use crate::report::document::SuiteName;

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
