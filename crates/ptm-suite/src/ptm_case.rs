//! [`TestCase`] for PTM files: a request is a file and a view, and an answer is a frame.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use crate::cases::{Built, Case, Expect, Suite, TableSpelling};
use crate::choices::{CHOICES, dialect_image, relevant_axes};
use crate::compare::{Difference, Expected, FlatBlocks};
use crate::dialect::{Choices, Dialect, RightDialects};
use crate::features::Feature;
use crate::name::SuiteName;
use crate::protocol::frame::{Frame, View, ViewKind};
use crate::test_case::{Allowance, Comparison, Listed, Output, TestCase};
use crate::values::Values;
use ptm::Format;
use ptm::reading::Reading;
use ptm_generate::{Compression, Recipe};

impl Output for Frame {
    fn is_equivalent(&self, other: &Frame) -> bool {
        Frame::is_equivalent(self, other)
    }
}

impl Listed for Case {
    const SUITE: SuiteName = SuiteName::Ptm;

    /// Returns the recorded digest of all files. Generating the files would take longer than most runs of single cases.
    fn digest(_: &Suite) -> String {
        ptm_spec_cases::CORPUS_DIGEST.trim().to_owned()
    }

    fn id(&self) -> &str {
        &self.id
    }

    fn clauses(&self) -> &[String] {
        &self.clauses
    }

    fn because(&self) -> String {
        self.because.clone()
    }

    fn format_name(&self) -> Option<&'static str> {
        Some(self.format().short_name())
    }

    fn expectation_name(&self) -> &'static str {
        self.expect.name()
    }

    fn reference_readings() -> Vec<(&'static str, &'static str)> {
        CHOICES.reference_readings()
    }
}

impl TestCase for Case {
    type View = View;
    type Output = Frame;
    type Difference = Difference;
    type Built = Arc<Built>;
    type Decisions = Reading;

    const VIEWS: &'static [&'static str] = &ViewKind::NAMES;
    const CHOICES: Choices<Reading> = CHOICES;

    fn ruling(&self) -> Option<&str> {
        self.ruling.as_deref()
    }

    fn expect(&self) -> Expect {
        self.expect
    }

    fn is_first(&self) -> bool {
        self.first
    }

    fn views(&self) -> &[View] {
        &self.views
    }

    fn view_name(view: &View) -> &'static str {
        view.name()
    }

    fn kind(&self) -> Feature {
        Feature::Format(self.format())
    }

    fn features(&self, view: &View) -> BTreeSet<Feature> {
        let is_lum_color = self.format() == Format::Lum && matches!(view, View::Rgb(_));
        let large = |recipe: &Recipe| recipe.format.has_table() && recipe.entries > 256;
        let plan = |asked: fn(&Compression) -> bool| self.compression().is_some_and(asked);
        let mut features = BTreeSet::from([self.kind()]);
        for (feature, is_needed) in [
            (Feature::LargeTables, self.recipe().is_some_and(large)),
            (Feature::LumColor, is_lum_color),
            (Feature::Prediction, plan(Compression::predicts)),
            (Feature::Inversion, plan(Compression::inverts)),
            (Feature::Motion, plan(Compression::displaces)),
            (Feature::SideInformation, plan(|p| !p.records.is_empty())),
        ] {
            if is_needed {
                features.insert(feature);
            }
        }
        features
    }

    fn texels(&self) -> Option<u64> {
        self.recipe().map(|recipe| recipe.size.bytes(1))
    }

    fn twins(cases: &[Case]) -> Vec<Vec<usize>> {
        let numbered = cases.iter().enumerate();
        let indices: HashMap<&str, usize> = numbered.map(|(i, case)| (&*case.id, i)).collect();
        let twin = |case: &Case| {
            let twin = case.twin_of.as_ref();
            twin.map(|id| indices[id.as_str()]).into_iter().collect()
        };
        cases.iter().map(twin).collect()
    }

    fn has_table(&self) -> bool {
        self.format().has_table()
    }

    fn spelling(&self) -> Option<TableSpelling> {
        let spelling = &self.recipe()?.spelling;
        (self.expect == Expect::Spelling).then_some(TableSpelling {
            count: spelling.count,
            newline: spelling.newline_after_table,
        })
    }

    fn make(&self, table: TableSpelling) -> Arc<Built> {
        self.build(table)
    }

    fn file(built: &Arc<Built>) -> &[u8] {
        &built.file
    }

    fn max_output_bytes(&self, built: &Arc<Built>) -> usize {
        // The largest frame has an f32 for each of 18 channels per texel.
        let texels = match (&built.values, self.recipe()) {
            (Values::Painted(model), _) => model.size.texels(),
            (_, Some(recipe)) => recipe.size.texels().max(built.file.len()),
            _ => built.file.len(),
        };
        texels * 18 * 4
    }

    fn compare(&self, built: &Arc<Built>, view: &View, frame: &Frame) -> Comparison<Case> {
        let axes = relevant_axes(self, &built.values, view);
        let is_raw = *view == View::Raw;
        // Most answers are equal to the expected bytes, and then nothing else has to be compared.
        if is_raw && axes.is_empty() && built.values.has_equal_samples(frame) {
            return Comparison {
                right: RightDialects::Regardless(true),
                difference: None,
                allowance: Allowance::None,
            };
        }
        let expected = Expected::new(&built.values, view);
        let difference = (expected.as_ref()).and_then(|expected| expected.compare(frame));
        let is_other = |expected: &Expected| expected.values != frame.samples.to_reals();
        let is_other = is_raw && expected.as_ref().is_some_and(is_other);
        let allowance = match difference {
            _ if frame.lossy => Allowance::Lossy,
            // A different inverse DCT decoded the lossy JPEG planes.
            None if is_other => Allowance::AnotherTransform(
                (expected.as_ref())
                    .map_or_else(FlatBlocks::default, |expected| expected.flat_blocks(frame)),
            ),
            _ => Allowance::None,
        };
        let right = match expected {
            Some(_) if !axes.is_empty() => RightDialects::Depends {
                axes,
                in_reference: difference.is_none(),
            },
            expected => RightDialects::Regardless(
                matches!(built.values, Values::Any) || expected.is_some() && difference.is_none(),
            ),
        };
        Comparison {
            right,
            difference,
            allowance,
        }
    }

    fn difference_in(
        &self,
        built: &Arc<Built>,
        view: &View,
        frame: &Frame,
        dialect: &Dialect,
    ) -> Option<Difference> {
        let axes = relevant_axes(self, &built.values, view);
        if CHOICES.combination_index(dialect, &axes) == 0 {
            return Expected::new(&built.values, view)?.compare(frame);
        }
        match dialect_image(built, view, &axes, dialect) {
            Some(image) => image.compare(frame),
            None => Some(Difference::Shape {
                expected: "a refusal".to_owned(),
                received: "an image".to_owned(),
            }),
        }
    }

    fn similarity(difference: &Difference) -> f64 {
        match difference {
            Difference::Shape { .. } => 0.0,
            Difference::Samples { wrong, samples, .. } => 1.0 - *wrong as f64 / *samples as f64,
        }
    }

    fn expected_output(&self, view: &View) -> Option<Frame> {
        let built = self.build(TableSpelling::default());
        Some(Expected::new(&built.values, view)?.frame())
    }

    fn fault(&self) -> String {
        let damage = self.damage();
        damage.map_or_else(|| self.because.clone(), |damage| damage.effect.clone())
    }
}
