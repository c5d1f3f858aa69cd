//! Compares the reference's answers with the expected answers in a case file.

use serde_json::Value;

use crate::texture::{compare::ExpectedAnswer, fixtures, question::Refusal};
use crate::{texture::cases::TextureCase, texture::choices};
use ptm_texture::Rules;

/// Tolerance for expected numbers that were computed by hand.
const HAND_TOLERANCE: f64 = 1e-9;

/// An expected answer and the reference's answer.
#[derive(Clone, Debug)]
pub struct VerifiedAnswer {
    /// Id of the case.
    pub id: String,
    /// Reading under which this answer is expected, if it is not the reference's.
    pub reading: Option<String>,
    /// True if the answers agree; `None` if the reading is unknown.
    pub agrees: Option<bool>,
    /// The answer, or the difference.
    pub message: String,
}

/// Compares all expected answers of `case`, first under the reference's reading, then under other readings.
#[must_use]
pub fn verify(case: &TextureCase) -> Vec<VerifiedAnswer> {
    let line = |reading: Option<&String>, expect: &Value, rules: Option<Rules>| {
        let (holds, says) = match rules {
            Some(rules) => compare(case, expect, &rules),
            None => (None, "unknown reading".to_owned()),
        };
        VerifiedAnswer {
            id: case.id.clone(),
            reading: reading.cloned(),
            agrees: holds,
            message: says,
        }
    };
    let base = with_readings(&Rules::SPEC, &fixtures::readings(&case.given));
    let mut lines = vec![line(None, &case.expect, base)];
    for also in &case.alternatives {
        let mut readings = fixtures::readings(&also.given);
        if readings.is_empty() {
            readings.push(&also.reading);
        }
        let rules = base.and_then(|base| with_readings(&base, &readings));
        lines.push(line(Some(&also.reading), &also.expect, rules));
    }
    lines
}

fn with_readings(rules: &Rules, readings: &[&str]) -> Option<Rules> {
    let mut changed = *rules;
    for reading in readings {
        choices::find(reading)?(&mut changed);
    }
    Some(changed)
}

fn compare(case: &TextureCase, expect: &Value, rules: &Rules) -> (Option<bool>, String) {
    let expected = ExpectedAnswer {
        answer: expect.clone(),
        filter_tolerance: Value::Null,
        arithmetic_tolerance: Some(case.tolerance.unwrap_or(HAND_TOLERANCE)),
    };
    match case.read().and_then(|question| question.answer(rules)) {
        Ok(answer) => match expected.difference(&answer) {
            None => (Some(true), format_checked_fields(expect, &answer)),
            Some(difference) => (Some(false), difference),
        },
        Err(Refusal::Malformed(why)) if expect.get("error").is_some() => {
            (Some(true), format!("refused: {why}"))
        }
        Err(Refusal::Malformed(why) | Refusal::Unsupported(why)) => {
            (Some(false), format!("expected {expect}, refused: {why}"))
        }
    }
}

fn format_checked_fields(expect: &Value, answer: &Value) -> String {
    let field = |(name, _): (&String, _)| Some(format!("{name}: {}", answer.get(name)?));
    let fields = expect.as_object().into_iter().flatten();
    fields.filter_map(field).collect::<Vec<_>>().join(", ")
}
