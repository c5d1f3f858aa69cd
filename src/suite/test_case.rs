//! What a run needs to know of a case, whatever it asks: a PTM file in a view, or a question about a texture stage.
//!
//! Session, judge, matrix and report are written once, for every [`TestCase`]. A suite supplies its questions, how an answer
//! compares with the expected one, and its open questions.

use std::collections::BTreeSet;
use std::fmt::{Debug, Display};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::suite::cases::{Expect, Suite, TableSpelling};
use crate::suite::dialect::{Choices, Dialect, Right};

/// A case that a decoder can be asked about.
pub trait TestCase: Clone + Debug + Send + Sync + 'static {
    /// How it is asked.
    type View: Clone + Debug + Display + PartialEq + Send + Sync;
    /// What answers it: a frame, or a JSON object.
    type Output: Clone + Debug + PartialEq + Send + Sync + Serialize + DeserializeOwned;
    /// How an output is not the expected one, in words.
    type Difference: Clone + Debug + Display + Send + Sync;
    /// What a decoder may lack.
    type Feature: Clone + Debug + Display + Ord + Send + Sync;
    /// The file that is sent, and what it means.
    type Built;
    /// The decisions that a reading of an open question changes.
    type Decisions: 'static;

    /// The names of all views, best first.
    const VIEWS: &'static [&'static str];
    /// The open questions.
    const CHOICES: Choices<Self::Decisions>;
    /// What is said of an answer where a refusal is expected.
    const ACCEPTED: &'static str = "accepted a file that must be refused";
    /// What is said of 69 where cases of the same features were answered.
    const NOT_UNSUPPORTED: &'static str =
        "exited with 69 (unsupported), but decodes other files of this kind";

    /// A permanent name.
    fn id(&self) -> &str;
    /// The clauses it is about, the nearest first.
    fn clauses(&self) -> &[String];
    /// Why it is there, in a sentence.
    fn because(&self) -> String;
    /// Returns the ruling that it shows, if any.
    fn ruling(&self) -> Option<&str> {
        None
    }
    /// What is asked of a decoder.
    fn expect(&self) -> Expect;
    /// The same as it stands in a report.
    fn expectation(&self) -> &'static str;
    /// Whether it is asked in every view before all others.
    fn is_first(&self) -> bool;
    /// The views that can decide it, best first.
    fn views(&self) -> &[Self::View];
    /// Returns the name of a view.
    fn view_name(_view: &Self::View) -> &'static str {
        Self::VIEWS[0]
    }
    /// The feature that a decoder may declare: the format, or the step that is asked for.
    fn kind(&self) -> Self::Feature;
    /// What a decoder needs to answer it in `view`.
    fn features(&self, view: &Self::View) -> BTreeSet<Self::Feature>;
    /// For each case of a suite the accepted ones that it stands on: where none of them is decoded, a refusal proves
    /// nothing.
    fn twins(cases: &[Self]) -> Vec<Vec<usize>> {
        vec![Vec::new(); cases.len()]
    }

    /// Whether its file has a table, which is written in a spelling that the decoder knows.
    fn has_table(&self) -> bool {
        false
    }
    /// The spelling that it is about, where it is one of [`Expect::Spelling`].
    fn spelling(&self) -> Option<TableSpelling> {
        None
    }
    /// Makes the file and its values.
    fn made(&self, table: TableSpelling) -> Self::Built;
    /// The file that is sent.
    fn file(built: &Self::Built) -> &[u8];
    /// The most bytes of a right answer.
    fn largest_answer(&self, built: &Self::Built) -> usize;

    /// Compares an output with the expected one.
    fn compare(
        &self,
        built: &Self::Built,
        view: &Self::View,
        output: &Self::Output,
    ) -> Comparison<Self>;
    /// How an output differs from the one that is right in a dialect; nothing where that is not known.
    fn difference_in(
        &self,
        _view: &Self::View,
        _output: &Self::Output,
        _dialect: &Dialect,
    ) -> Option<Self::Difference> {
        None
    }
    /// Returns how near a wrong output is to the right one, from 0 to 1; 0 if an output is right or wrong, never near.
    fn likeness(_difference: &Self::Difference) -> f64 {
        0.0
    }
    /// Whether two outputs are the same in all that a decoder is responsible for.
    fn is_like(one: &Self::Output, other: &Self::Output) -> bool;
    /// The output that the reference gives to the file in the ordinary spelling, where there is one.
    fn expected_output(&self, _view: &Self::View) -> Option<Self::Output> {
        None
    }
    /// The expected answer, where it is short enough for a sentence.
    fn expected_in_words(&self) -> Option<String>;
    /// What is wrong with a file that must be refused.
    fn fault(&self) -> String;
}

/// An output beside the expected one.
#[derive(Clone, Debug)]
pub struct Comparison<C: TestCase> {
    /// Where it is right: in every dialect, or in some.
    pub right: Right,
    /// How it differs from the reference's, if it does and there is one.
    pub difference: Option<C::Difference>,
    /// What room was made for it.
    pub allowance: Allowance,
}

/// Why an output may be right without being the expected one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Allowance {
    /// There is no more room than for rounding.
    None,
    /// It is right only because inverse DCTs may differ (ruling `jpeg-samples`).
    AnotherTransform,
    /// It came as a lossy picture.
    Lossy,
}

impl<C: TestCase> Suite<C> {
    /// The case of that id.
    #[must_use]
    pub fn case(&self, id: &str) -> Option<&C> {
        self.cases.iter().find(|case| case.id() == id)
    }
}
