//! The messages of a probe, which are stored in `spec-cases/probe.yaml`.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::LazyLock;

use ptm_suite::kit::yaml::from_yaml;

/// An observation and a suggested fix.
pub(in crate::session) type ProbeFault = (String, String);

/// Values of the slots of a message.
pub(super) type Slots<'a> = [(&'static str, &'a dyn Display)];

static TEMPLATES: LazyLock<BTreeMap<String, BTreeMap<String, String>>> =
    LazyLock::new(|| from_yaml(ptm_spec_cases::PROBE).expect("a test reads them"));

/// Returns the message named `name` with its slots filled in.
pub(super) fn fault(name: &str, slots: &Slots) -> ProbeFault {
    let fill = |part: &str| {
        let filled = |text: String, (slot, value): &(&str, &dyn Display)| {
            text.replace(&format!("{{{slot}}}"), &value.to_string())
        };
        slots.iter().fold(TEMPLATES[name][part].clone(), filled)
    };
    (fill("says"), fill("next"))
}

/// Joins the messages of several mistakes. Their fixes are separated by `separator`.
pub(in crate::session) fn join_texts(mistakes: Vec<ProbeFault>, separator: &str) -> ProbeFault {
    let (says, next): (Vec<String>, Vec<String>) = mistakes.into_iter().unzip();
    (says.join("; and "), next.join(separator))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_message_exists_and_is_used() {
        let source = concat!(
            include_str!("arrangement.rs"),
            include_str!("body.rs"),
            include_str!("calls.rs"),
            include_str!("explain.rs"),
            include_str!("one_shot.rs"),
            include_str!("repair.rs"),
            include_str!("serve.rs"),
        );
        for name in TEMPLATES.keys() {
            assert!(source.contains(&format!("\"{name}\"")), "unused: {name}");
        }
        for used in source.split("fault(\"").skip(1) {
            let name = used.split('"').next().unwrap_or_default();
            assert!(TEMPLATES.contains_key(name), "no message: {name}");
        }
    }
}
