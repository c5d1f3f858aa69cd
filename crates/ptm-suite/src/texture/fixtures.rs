//! Named maps, such as `ramp4` or `lit4x4` in a case.
//!
//! Cases refer to maps by name. A question contains the texels instead, so programs under test do not need the names.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde_json::Value;

use crate::kit::yaml::from_yaml;

static MAPS: LazyLock<BTreeMap<String, Value>> = LazyLock::new(|| {
    from_yaml(ptm_spec_cases::texture::MAPS).expect("the embedded maps are well-formed")
});

/// Replaces the names of maps in `given` with the maps, and removes the fields that select a reading.
pub(crate) fn expand_maps(given: &Value) -> Value {
    match given {
        Value::Object(fields) => {
            let is_sent = |(name, _): &(&String, _)| !READING_FIELDS.contains(&name.as_str());
            let fields = fields.iter().filter(is_sent);
            let spelled = fields.map(|(name, value)| {
                let value = match name.as_str() {
                    "map" => new_map(value),
                    _ => expand_maps(value),
                };
                (name.clone(), value)
            });
            Value::Object(spelled.collect())
        }
        Value::Array(values) => values.iter().map(expand_maps).collect(),
        other => other.clone(),
    }
}

/// Fields of `given` that name a reading.
const READING_FIELDS: [&str; 2] = ["reading", "grid"];

/// Returns the readings that `given` names.
#[must_use]
pub fn readings(given: &Value) -> Vec<&str> {
    let fields = READING_FIELDS.iter();
    fields.filter_map(|field| given[*field].as_str()).collect()
}

fn new_map(value: &Value) -> Value {
    if let Some(map) = value.as_str().and_then(|name| MAPS.get(name)) {
        return map.clone();
    }
    let file = value["ptm"].as_str().and_then(|name| MAPS.get(name));
    let mut value = value.clone();
    if let Some(map) = file {
        value["ptm"] = Value::String(hex(&map["pieces"]));
    }
    value
}

fn hex(pieces: &Value) -> String {
    let mut digits = String::new();
    for piece in pieces.as_array().into_iter().flatten() {
        let text = piece["text"].as_str().unwrap_or_default();
        digits.extend(text.bytes().map(|byte| format!("{byte:02x}")));
        let hex = piece["hex"].as_str().unwrap_or_default();
        digits.extend(hex.split_whitespace());
    }
    digits
}
