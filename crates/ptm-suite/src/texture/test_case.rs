//! [`TestCase`] for texture questions: requests and answers are JSON objects.

use std::collections::BTreeSet;
use std::fmt;

use serde_json::Value;

use crate::cases::{Expect, Suite, TableSpelling};
use crate::dialect::{Choices, Dialect, RightDialects};
use crate::kit::digest::sha256;
use crate::name::SuiteName;
use crate::test_case::{Allowance, Comparison, Output, TestCase};
use crate::texture::cases::{Basis, TextureCase};
use crate::texture::choices::CHOICES;
use ptm_texture::Rules;

/// Maximum size of an answer in bytes. Answers are small JSON objects.
const MAX_ANSWER_BYTES: usize = 1 << 20;

/// The single view of texture questions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureView;

impl fmt::Display for TextureView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("texture")
    }
}

impl Output for Value {}

impl TestCase for TextureCase {
    type View = TextureView;
    type Output = Value;
    type Difference = String;
    type Feature = String;
    type Built = Vec<u8>;
    type Decisions = Rules;

    const SUITE: SuiteName = SuiteName::Texture;
    const VIEWS: &'static [&'static str] = &["texture"];
    const CHOICES: Choices<Rules> = CHOICES;

    fn digest(suite: &Suite<TextureCase>) -> String {
        let text = |case: &TextureCase| format!("{}{}{}", case.id, case.question(), case.expect);
        sha256(suite.cases.iter().map(text).collect::<String>().as_bytes())
    }

    fn id(&self) -> &str {
        &self.id
    }

    fn clauses(&self) -> &[String] {
        &self.clauses
    }

    fn because(&self) -> String {
        let text = format!("{}: {}", self.op, self.because);
        match (self.basis, &self.ruling) {
            (Basis::Inferred, Some(ruling)) => format!(
                "{text}\nThe formula of the chapter is lost; ruling {ruling} gives a replacement and the reasons for it."
            ),
            _ => text,
        }
    }

    fn ruling(&self) -> Option<&str> {
        self.ruling.as_deref()
    }

    fn expect(&self) -> Expect {
        match self.basis {
            _ if self.must_be_refused() => Expect::Reject,
            Basis::Impl => Expect::ImplementationDefined,
            _ => Expect::Decode,
        }
    }

    fn expectation_name(&self) -> &'static str {
        match self.basis {
            _ if self.must_be_refused() => "reject",
            Basis::Reading => "choice",
            Basis::Impl => "implementation-defined",
            Basis::Text | Basis::Sibling | Basis::Inferred => "value",
        }
    }

    fn is_first(&self) -> bool {
        self.first
    }

    fn views(&self) -> &[TextureView] {
        &[TextureView]
    }

    fn kind(&self) -> String {
        self.op.clone()
    }

    /// Returns the step and, if the question contains a PTM, the feature for PTM maps.
    fn features(&self, _: &TextureView) -> BTreeSet<String> {
        let mut features = BTreeSet::from([self.op.clone()]);
        if self.given.to_string().contains("\"ptm\"") {
            features.insert("PTM maps".to_owned());
        }
        features
    }

    fn make(&self, _: TableSpelling) -> Vec<u8> {
        format!("{}\n", self.question()).into_bytes()
    }

    fn file(built: &Vec<u8>) -> &[u8] {
        built
    }

    fn max_output_bytes(&self, _: &Vec<u8>) -> usize {
        MAX_ANSWER_BYTES
    }

    fn compare(&self, _: &Vec<u8>, _: &TextureView, answer: &Value) -> Comparison<TextureCase> {
        let difference = self.expected(&CHOICES.reference()).difference(answer);
        let axes = self.relevant_axes();
        let right = match axes.is_empty() {
            // Any error message is accepted.
            true if self.must_be_refused() => {
                RightDialects::Regardless(answer.get("error").is_some())
            }
            true => RightDialects::Regardless(difference.is_none()),
            false => RightDialects::Depends {
                axes: axes.to_vec(),
                in_reference: difference.is_none(),
            },
        };
        Comparison {
            right,
            difference,
            allowance: Allowance::None,
        }
    }

    fn difference_in(
        &self,
        _: &Vec<u8>,
        _: &TextureView,
        answer: &Value,
        dialect: &Dialect,
    ) -> Option<String> {
        self.expected(dialect).difference(answer)
    }

    fn expected_output(&self, _: &TextureView) -> Option<Value> {
        Some(self.expect.clone())
    }

    fn expected_text(&self) -> Option<String> {
        Some(self.expect.to_string())
    }

    fn fault(&self) -> String {
        self.expect["error"].to_string()
    }
}
