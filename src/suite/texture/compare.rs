//! Compares an answer with the expected one.
//!
//! Only the expected fields are compared. Numbers may differ by 1e-5 of the larger one plus 1e-6, so that single precision
//! passes; words may have the prefixes that the chapter uses. A color may be clamped to 0…1 (ruling `color-range`).

use serde_json::{Value, json};

use crate::suite::compare::is_close;
use crate::texture::Entry;

/// Absolute tolerance for numbers; `None` for 1e-5 of the larger number, plus 1e-6.
type Tolerance = Option<f64>;

/// Describes the first difference between `received` and `expected`, or returns `None` if there is none.
#[must_use]
pub fn difference(expected: &Value, received: &Value, tolerance: Tolerance) -> Option<String> {
    let fields = expected.as_object()?;
    // Any value passes if the answer is left to the implementation.
    if fields.contains_key("impl_defined") {
        let is_value = received.get("impl_defined").is_none();
        return is_value.then(|| format!("expected no value, received {received}"));
    }
    fields.iter().find_map(|(name, expected)| {
        let Some(received) = received.get(name) else {
            return Some(format!("{name}: expected {expected}, received nothing"));
        };
        // The texels of a black and white map may be luminances.
        let gray = match (expected, received) {
            (Value::Array(all), Value::Array(one))
                if name == "texel" && all.len() == 3 && one.len() == 1 =>
            {
                all.iter().all(|value| equal("", value, &one[0], tolerance))
            }
            _ => false,
        };
        (!gray && !equal(name, expected, received, tolerance))
            .then(|| format!("{name}: expected {expected}, received {received}"))
    })
}

fn equal(name: &str, expected: &Value, received: &Value, tolerance: Tolerance) -> bool {
    let is_near = |a: f64, b: f64| match tolerance {
        Some(limit) => (a - b).abs() <= limit,
        None => is_close(a, b, 0.0),
    };
    match (expected, received) {
        (Value::Number(a), Value::Number(b)) => match (a.as_f64(), b.as_f64()) {
            (Some(a), Some(b)) => is_near(a, b) || name == "color" && is_near(a.clamp(0.0, 1.0), b),
            _ => false,
        },
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| equal(name, a, b, tolerance))
        }
        (Value::String(a), Value::String(b)) => {
            a == b || without_prefix(name, b).as_ref() == Some(expected)
        }
        (a, b) => a == b,
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
