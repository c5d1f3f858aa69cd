//! The messages of a probe. Their texts are in `spec-cases/probe.yaml`.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::LazyLock;

use serde::Deserialize;

use crate::kit::yaml::from_yaml;

#[derive(Deserialize)]
struct ProbeMessage {
    says: String,
    next: String,
}

static TEMPLATES: LazyLock<BTreeMap<String, ProbeMessage>> = LazyLock::new(|| {
    from_yaml(include_str!("../../../spec-cases/probe.yaml")).expect("a test reads them")
});

/// A mistake of a wrapper.
#[derive(Clone, Debug)]
pub(in crate::session) struct WrapperMistake {
    /// The observation.
    pub(in crate::session) says: String,
    /// The suggested fix.
    pub(in crate::session) next: String,
    /// True if all samples are right and only their order is wrong.
    pub(in crate::session) is_order: bool,
}

/// Samples as numbers, and the mistakes that were undone to read them.
pub(super) type Interpretation = (Vec<f64>, Vec<WrapperMistake>);

/// The observation, and a suggested fix.
pub(super) type ProbeFault = (String, String);

/// The values of the names in braces.
pub(super) type Slots<'a> = [(&'static str, &'a dyn Display)];

/// Returns the message of this name, with its slots filled in.
pub(super) fn fault(name: &str, slots: &Slots) -> ProbeFault {
    let ProbeMessage { says, next } = &TEMPLATES[name];
    let fill = |text: &String| {
        let mut text = text.clone();
        for (slot, value) in slots {
            text = text.replace(&format!("{{{slot}}}"), &value.to_string());
        }
        text
    };
    (fill(says), fill(next))
}

/// Returns the mistake with the message of this name.
pub(super) fn mistake(name: &str, slots: &Slots) -> WrapperMistake {
    let (says, next) = fault(name, slots);
    WrapperMistake {
        says,
        next,
        is_order: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_message_is_used_and_every_used_message_exists() {
        let source = concat!(
            include_str!("arrangement.rs"),
            include_str!("body.rs"),
            include_str!("calls.rs"),
            include_str!("command.rs"),
            include_str!("dialog.rs"),
            include_str!("explain.rs"),
            include_str!("one_shot.rs"),
            include_str!("repair.rs"),
            include_str!("serve.rs"),
        );
        for name in TEMPLATES.keys() {
            assert!(source.contains(&format!("\"{name}\"")), "unused: {name}");
        }
        for call in ["fault(\"", "mistake(\"", "explained(\""] {
            for used in source.split(call).skip(1) {
                let name = used.split('"').next().unwrap_or_default();
                assert!(TEMPLATES.contains_key(name), "no message: {name}");
            }
        }
    }
}
