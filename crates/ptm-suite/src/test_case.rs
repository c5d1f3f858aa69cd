//! The interface between a run and the cases of a suite.
//!
//! Session and judge are written once, for every [`TestCase`]. A suite supplies its requests, the comparison of an answer with the
//! expected one, and its open questions. Texture questions have a loop of their own, and are only [`Listed`].

use std::collections::BTreeSet;
use std::fmt::{Debug, Display};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::cases::{Expect, Suite, TableSpelling};
use crate::compare::FlatBlocks;
use crate::dialect::{Choices, Dialect, RightDialects};
use crate::features::Feature;
use crate::name::SuiteName;

/// A case of any suite, as commands and reports list it.
pub trait Listed: Sized {
    /// Name of the suite.
    const SUITE: SuiteName;

    /// Returns the permanent id.
    fn id(&self) -> &str;
    /// Returns the tested clauses, the most relevant first.
    fn clauses(&self) -> &[String];
    /// Returns the purpose of the case, in a sentence.
    fn because(&self) -> String;
    /// Returns the name that reports use for the expected result.
    fn expectation_name(&self) -> &'static str;
    /// Returns a digest of all requests and expected results, in order.
    fn digest(suite: &Suite<Self>) -> String;
    /// Returns the short name of the format of the file, if there is one.
    fn format_name(&self) -> Option<&'static str> {
        None
    }
    /// Returns each ruling that allows several readings, with the reading of the reference.
    #[must_use]
    fn reference_readings() -> Vec<(&'static str, &'static str)> {
        Vec::new()
    }
}

/// A case of a suite of files or of requests for files.
pub trait TestCase: Listed + Clone + Debug + Send + Sync + 'static {
    /// A view in which a case is requested.
    type View: Clone + Debug + Display + PartialEq + Send + Sync;
    /// Output of the program under test: a frame, or a file.
    type Output: Output;
    /// Difference between an output and the expected one.
    type Difference: Clone + Debug + Display + Send + Sync;
    /// The file that is sent, with its values.
    type Built;
    /// Decisions that depend on how open questions are read.
    type Decisions: 'static;

    /// Names of all views, in order of preference.
    const VIEWS: &'static [&'static str];
    /// The open questions.
    const CHOICES: Choices<Self::Decisions>;
    /// Message for an answer to a case that expects a refusal.
    const ACCEPTED_MESSAGE: &'static str = "accepted a file that must be refused";
    /// Message for exit status 69 if, for each feature of the case, other cases with it were answered. The features follow it in parentheses.
    const UNSUPPORTED_MESSAGE: &'static str =
        "exited with 69 (unsupported), but decodes other files of this kind";

    /// Returns the ruling that the case tests, if any.
    fn ruling(&self) -> Option<&str> {
        None
    }
    /// Returns the expected result.
    fn expect(&self) -> Expect;
    /// Returns true if the case is requested in every view before all other cases.
    fn is_first(&self) -> bool;
    /// Returns the views that can decide the case, in order of preference.
    fn views(&self) -> &[Self::View];
    /// Returns the name of a view.
    fn view_name(_view: &Self::View) -> &'static str {
        Self::VIEWS[0]
    }
    /// Returns the kind of the case, which a decoder may declare: the format.
    fn kind(&self) -> Feature;
    /// Returns the features that a decoder needs for this case in `view`.
    fn features(&self, view: &Self::View) -> BTreeSet<Feature>;
    /// Returns the number of texels, if it is known before the file is generated.
    fn texels(&self) -> Option<u64> {
        None
    }
    /// Returns, for each case of a suite, the must-accept cases on which it depends: if none of them is decoded, a refusal proves
    /// nothing.
    fn twins(cases: &[Self]) -> Vec<Vec<usize>>;

    /// Returns true if the file has a table. Tables are sent in a spelling that the decoder supports.
    fn has_table(&self) -> bool {
        false
    }
    /// Returns the table spelling that a case of [`Expect::Spelling`] tests.
    fn spelling(&self) -> Option<TableSpelling> {
        None
    }
    /// Generates the file and its values.
    fn make(&self, table: TableSpelling) -> Self::Built;
    /// Returns the file that is sent.
    fn file(built: &Self::Built) -> &[u8];
    /// Returns the maximum size of a correct answer, in bytes.
    fn max_output_bytes(&self, built: &Self::Built) -> usize;

    /// Compares an output with the expected one.
    fn compare(
        &self,
        built: &Self::Built,
        view: &Self::View,
        output: &Self::Output,
    ) -> Comparison<Self>;
    /// Returns the difference between an output and the correct one in a dialect, or `None` if the output is right in it.
    fn difference_in(
        &self,
        _built: &Self::Built,
        _view: &Self::View,
        _output: &Self::Output,
        _dialect: &Dialect,
    ) -> Option<Self::Difference> {
        None
    }
    /// Returns the similarity of a wrong output to the correct one, from 0 to 1, or 0 if it cannot be measured.
    fn similarity(_difference: &Self::Difference) -> f64 {
        0.0
    }
    /// Returns the reference's output for the file in the default spelling, if there is one.
    fn expected_output(&self, _view: &Self::View) -> Option<Self::Output> {
        None
    }
    /// Describes the expected answer, if it is short enough.
    fn expected_text(&self) -> Option<String> {
        None
    }
    /// Describes the fault in a file that must be refused.
    fn fault(&self) -> String;
}

/// Output of a program under test.
pub trait Output: Clone + Debug + PartialEq + Send + Sync + Serialize + DeserializeOwned {
    /// Returns true if both outputs agree in everything that the program controls.
    fn is_equivalent(&self, other: &Self) -> bool {
        self == other
    }
}

/// Result of comparing an output with the expected one.
#[derive(Clone, Debug)]
pub struct Comparison<C: TestCase> {
    /// Dialects in which the output is right.
    pub right: RightDialects,
    /// Difference from the reference's output, if any.
    pub difference: Option<C::Difference>,
    /// Tolerance that was applied.
    pub allowance: Allowance,
}

/// Reason why an output may be right although it differs from the expected one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Allowance {
    /// No tolerance except for rounding.
    None,
    /// Inverse DCTs may differ (ruling `jpeg-samples`).
    AnotherTransform(FlatBlocks),
    /// The output is a lossy image.
    Lossy,
}

impl<C: TestCase> Suite<C> {
    /// Returns the features that a decoder may need for a case, in any of its views.
    #[must_use]
    pub fn features(&self, case: usize) -> BTreeSet<Feature> {
        let case = &self.cases[case];
        let views = case.views().iter();
        views.flat_map(|view| case.features(view)).collect()
    }
}

impl<C: Listed> Suite<C> {
    /// Returns the case with the given id.
    #[must_use]
    pub fn case(&self, id: &str) -> Option<&C> {
        self.cases.iter().find(|case| case.id() == id)
    }
}
