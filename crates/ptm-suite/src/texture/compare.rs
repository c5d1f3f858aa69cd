//! Compares an answer with the expected one.
//!
//! Only the expected fields are compared. Numbers may differ by 1e-5 of the larger one plus 1e-6, so that single precision
//! passes, plus the tolerance of a filtered sample (ruling `filter-precision`). Words may have the prefixes that the chapter uses.
//! A color may be clamped to 0…1 (ruling `color-range`).

use serde_json::{Value, json};

use crate::compare::is_close;
use ptm_texture::Entry;

/// Expected answer to a question, with the tolerances of its numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpectedAnswer {
    /// Expected fields.
    pub answer: Value,
    /// Tolerance of each number for the precision of filters, in the shape of the answer. Missing numbers have no tolerance.
    pub filter_tolerance: Value,
    /// Absolute tolerance for arithmetic; `None` for 1e-5 of the larger number, plus 1e-6.
    pub arithmetic_tolerance: Option<f64>,
}

impl ExpectedAnswer {
    /// Describes the first difference between the expected and the received answer, or returns `None` if there is none.
    #[must_use]
    pub fn difference(&self, received: &Value) -> Option<String> {
        let fields = self.answer.as_object()?;
        // Any value passes if the answer is left to the implementation.
        if fields.contains_key("impl_defined") {
            let is_value = received.get("impl_defined").is_none();
            return is_value.then(|| format!("expected no value, received {received}"));
        }
        fields.iter().find_map(|(name, expected)| {
            let Some(received) = received.get(name) else {
                return Some(format!("{name}: expected {expected}, received nothing"));
            };
            let filter = &self.filter_tolerance[name];
            // The texels of a black and white map may be luminances.
            let gray = match (expected, received) {
                (Value::Array(all), Value::Array(one))
                    if name == "texel" && all.len() == 3 && one.len() == 1 =>
                {
                    let mut all = all.iter().enumerate();
                    all.all(|(i, value)| self.is_equal("", value, &one[0], &filter[i]))
                }
                _ => false,
            };
            (!gray && !self.is_equal(name, expected, received, filter))
                .then(|| format!("{name}: expected {expected}, received {received}"))
        })
    }

    fn is_equal(&self, name: &str, expected: &Value, received: &Value, filter: &Value) -> bool {
        match (expected, received) {
            (Value::Number(a), Value::Number(b)) => match (a.as_f64(), b.as_f64()) {
                (Some(a), Some(b)) => {
                    let slack = filter.as_f64().unwrap_or(0.0);
                    self.is_near(a, b, slack)
                        || name == "color" && self.is_near(a.clamp(0.0, 1.0), b, slack)
                }
                _ => false,
            },
            (Value::Array(a), Value::Array(b)) => {
                let mut pairs = a.iter().zip(b).enumerate();
                a.len() == b.len() && pairs.all(|(i, (a, b))| self.is_equal(name, a, b, &filter[i]))
            }
            (Value::String(a), Value::String(b)) => {
                a == b || without_prefix(name, b).as_ref() == Some(expected)
            }
            (a, b) => a == b,
        }
    }

    fn is_near(&self, a: f64, b: f64, slack: f64) -> bool {
        match self.arithmetic_tolerance {
            Some(limit) => (a - b).abs() <= limit + slack,
            None => is_close(a, b, slack),
        }
    }
}

/// Removes the chapter's prefix from an enumerant.
fn without_prefix(field: &str, word: &str) -> Option<Value> {
    let value = match field {
        "boundary" => json!([word, word, word]),
        _ => json!(word),
    };
    let entry: Entry = serde_json::from_value(json!({ field: value })).ok()?;
    let mut written = serde_json::to_value(entry).ok()?[field].take();
    Some(match field {
        "boundary" => written[0].take(),
        _ => written,
    })
}
