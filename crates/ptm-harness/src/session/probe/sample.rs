//! The files that a probe requests.

use std::fmt::Display;

use ptm::{Format, Size};
use ptm_generate::{Model, Recipe, write};
use ptm_suite::protocol::frame::{Frame, View};
use ptm_suite::{cases::TableSpelling, compare::Expected, values::Values};

use super::checklist::Reproduction;

/// Maximum number of texels of a file.
pub(super) const MAX_TEXELS: usize = 1 << 15;

/// A file and the values that a correct decoder finds in it.
pub(super) struct Sample {
    pub(super) format: Format,
    /// Spelling of the table, if the file has one.
    pub(super) spelling: TableSpelling,
    pub(super) file: Vec<u8>,
    pub(super) size: Size,
    values: Values,
}

impl Sample {
    fn new(format: Format, size: &str, spelling: TableSpelling) -> Sample {
        let size: Size = size.parse().expect("a constant size");
        let mut made = (1..=1000).map(|seed| {
            let mut recipe = Recipe::default_for(format, size);
            recipe.seed = seed;
            recipe.spelling.count = spelling.count;
            recipe.spelling.newline_after_table = spelling.newline;
            let model = Model::paint(&recipe);
            (recipe, model)
        });
        // Text mode is detected only if there is a line feed to change.
        let reveals_text_mode = |model: &Model| {
            model.samples.contains(&b'\n') && !model.samples.windows(2).any(|pair| pair == b"\r\n")
        };
        let made = made.find(|(_, model)| size.texels() > 100 || reveals_text_mode(model));
        let (recipe, model) = made.expect("one of a thousand noise files contains a line feed");
        Sample {
            format,
            spelling,
            file: write(&recipe, &model).bytes,
            size,
            values: Values::Painted(model),
        }
    }

    /// Returns a file whose frame is larger than the buffer of a pipe, with nearly [`MAX_TEXELS`] texels.
    pub(super) fn large(format: Format, spelling: TableSpelling) -> Sample {
        Sample::new(format, "201x149", spelling)
    }

    pub(super) fn size_text(&self, view: &View) -> String {
        format!("a frame of {} texels in {view}", self.size.texels())
    }

    /// Describes how the number of table entries is spelled, because the specification leaves that open. Empty for other formats.
    pub(super) fn spelling_text(&self) -> String {
        if !self.format.has_table() {
            return String::new();
        }
        let newline = match self.spelling.newline {
            true => ", with a line feed after the table (rulings lut-count, lut-newline)",
            false => " (ruling lut-count)",
        };
        format!(
            " if the number of entries is spelled \"{}\"{newline}",
            self.spelling.count.name()
        )
    }

    /// Returns a map in every spelling of its format, the default spelling first.
    pub(super) fn samples_in_all_spellings(format: Format) -> impl Iterator<Item = Sample> {
        TableSpelling::of(format).map(move |spelling| Sample::new(format, "5x3", spelling))
    }

    pub(super) fn expected(&self, view: &View) -> Expected {
        Expected::new(&self.values, view).expect("a painted map supports every view")
    }

    pub(super) fn has_size(&self, frame: &Frame) -> bool {
        (frame.width, frame.height) == (self.size.width, self.size.height)
    }

    pub(super) fn reproduction(&self, view: &dyn Display) -> Reproduction {
        let name = self.format.short_name().to_lowercase();
        Reproduction::one_shot(view, format!("{name}-{}.ptm", self.size), &self.file)
    }
}
