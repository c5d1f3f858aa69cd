//! Scores of a run: three fractions instead of one percentage.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The three scores of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Scores {
    /// Cases passed, out of those that passed or failed.
    pub correctness: Fraction,
    /// Features decoded, out of those in the selected cases.
    pub breadth: Fraction,
    /// Calls that ended in a frame or a refusal, out of all calls.
    pub robustness: Fraction,
}

impl fmt::Display for Scores {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [correctness, breadth, robustness] = [self.correctness, self.breadth, self.robustness];
        write!(
            f,
            "correctness {correctness}, breadth {breadth}, robustness {robustness}"
        )
    }
}

/// A part of a whole, written `3/4`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Fraction {
    /// Number of items in the part.
    pub part: usize,
    /// Number of items in the whole.
    pub whole: usize,
}

impl fmt::Display for Fraction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.part, self.whole)
    }
}

impl From<Fraction> for String {
    fn from(fraction: Fraction) -> String {
        fraction.to_string()
    }
}

impl TryFrom<String> for Fraction {
    type Error = String;

    fn try_from(text: String) -> Result<Fraction, String> {
        let parts = text.split_once('/').and_then(|(part, whole)| {
            let (part, whole) = (part.parse().ok()?, whole.parse().ok()?);
            Some(Fraction { part, whole })
        });
        parts.ok_or_else(|| format!("expected a fraction such as 3/4, found {text:?}"))
    }
}
