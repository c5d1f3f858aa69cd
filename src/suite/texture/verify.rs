//! The reference against a file of cases: what it answers to each, beside what the file expects.

use serde_json::Value;

use crate::suite::texture::cases::TextureCase;
use crate::suite::texture::choices;
use crate::suite::texture::compare::{Tolerance, difference};
use crate::suite::texture::fixtures;
use crate::suite::texture::question::Refusal;
use crate::texture::Rules;

/// Numbers worked out by hand are exact but for the last digits.
const BY_HAND: f64 = 1e-9;

/// One expected answer, and what the reference makes of it.
#[derive(Clone, Debug)]
pub struct VerifiedAnswer {
    /// The case.
    pub id: String,
    /// The reading under which this answer is expected, if it is not the reference's own.
    pub reading: Option<String>,
    /// Whether the answers agree; nothing if the reading is not known here.
    pub holds: Option<bool>,
    /// The answer, or what differs.
    pub says: String,
}

/// Every answer that `case` expects: its own first, then those of other readings.
#[must_use]
pub fn verify(case: &TextureCase) -> Vec<VerifiedAnswer> {
    let line = |reading: Option<&String>, expect: &Value, rules: Option<Rules>| {
        let (holds, says) = match rules {
            Some(rules) => held_against(case, expect, &rules),
            None => (None, "this reading is not known here".to_owned()),
        };
        VerifiedAnswer {
            id: case.id.clone(),
            reading: reading.cloned(),
            holds,
            says,
        }
    };
    let own = with_readings(&Rules::SPEC, &fixtures::readings(&case.given));
    let mut lines = vec![line(None, &case.expect, own)];
    for also in &case.also {
        let mut readings = fixtures::readings(&also.given);
        if readings.is_empty() {
            readings.push(&also.reading);
        }
        let rules = own.and_then(|own| with_readings(&own, &readings));
        lines.push(line(Some(&also.reading), &also.expect, rules));
    }
    lines
}

fn with_readings(rules: &Rules, readings: &[&str]) -> Option<Rules> {
    let mut changed = *rules;
    for reading in readings {
        changed = choices::named(reading)?(changed);
    }
    Some(changed)
}

fn held_against(case: &TextureCase, expect: &Value, rules: &Rules) -> (Option<bool>, String) {
    let tolerance = Tolerance::Absolute(case.tol.unwrap_or(BY_HAND));
    match case.read().and_then(|question| question.answer(rules)) {
        Ok(answer) => match difference(expect, &answer, tolerance) {
            None => (Some(true), shown(expect, &answer)),
            Some(what) => (Some(false), what),
        },
        Err(Refusal::Malformed(why)) if expect.get("error").is_some() => {
            (Some(true), format!("refused: {why}"))
        }
        Err(refusal) => (
            Some(false),
            format!("expected {expect}, refused: {}", refusal.message()),
        ),
    }
}

/// Of an answer the fields that are expected.
fn shown(expect: &Value, answer: &Value) -> String {
    let fields = expect.as_object().into_iter().flatten();
    let fields: Vec<String> = fields
        .filter_map(|(name, _)| Some(format!("{name}: {}", answer.get(name)?)))
        .collect();
    fields.join(", ")
}
