//! The files that a probe requests.

use crate::generate::{Model, Recipe, write};
use crate::protocol::frame::View;
use crate::ptm::{Format, Size};
use crate::suite::cases::TableSpelling;
use crate::suite::compare::Expected;
use crate::suite::values::Values;

use super::checklist::Reproduction;

/// A file, and the result of a correct decoder.
pub(super) struct Sample {
    pub(super) format: Format,
    /// The spelling of the count of its table, if it has one.
    pub(super) spelling: TableSpelling,
    pub(super) file: Vec<u8>,
    pub(super) size: Size,
    values: Values,
}

impl Sample {
    pub(super) fn new(format: Format, size: &str, spelling: TableSpelling) -> Sample {
        let size: Size = size.parse().expect("a constant size");
        // Text mode is noticed only if there is a line feed to change.
        let tells = |model: &Model| {
            model.samples.contains(&b'\n') && !model.samples.windows(2).any(|pair| pair == b"\r\n")
        };
        let (recipe, model) = (1..=1000)
            .map(|seed| {
                let mut recipe = Recipe {
                    seed,
                    ..Recipe::ordinary(format, size)
                };
                recipe.spelling.count = spelling.count;
                recipe.spelling.newline_after_table = spelling.newline;
                let model = Model::paint(&recipe);
                (recipe, model)
            })
            .find(|(_, model)| size.texels() > 100 || tells(model))
            .expect("one of a thousand files of noise has a line feed in it");
        Sample {
            format,
            spelling,
            file: write(&recipe, &model).bytes,
            size,
            values: Values::Painted(model),
        }
    }

    /// Returns the same map in every spelling of its format, the default one first.
    pub(super) fn in_all_spellings(format: Format, size: &str) -> impl Iterator<Item = Sample> {
        let spellings = if format.has_table() { 6 } else { 1 };
        let spellings = TableSpelling::all().take(spellings);
        spellings.map(move |spelling| Sample::new(format, size, spelling))
    }

    pub(super) fn expected(&self, view: &View) -> Expected {
        Expected::of(&self.values, view).expect("a painted map has every view")
    }

    /// Returns the name of its file.
    pub(super) fn file_name(&self) -> String {
        format!(
            "{}-{}.ptm",
            self.format.short_name().to_lowercase(),
            self.size
        )
    }

    pub(super) fn repeat(&self, view: &View) -> Reproduction {
        Reproduction::one_shot(view, self.file_name(), &self.file)
    }
}
