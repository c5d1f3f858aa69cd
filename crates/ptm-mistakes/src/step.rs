//! The steps of decoding that a mistake can change, and what is known about each.

use crate::formula::Formula;
use crate::formula::Stage::{self, Coefficients, Color, Decoding, File, Planes};

/// A step of decoding that a mistake can change: the bytes of the file, the decoded map, or a decision of
/// `Reading`.
#[derive(Debug, PartialEq, Eq)]
pub struct Step {
    /// Name used in `misreadings.yaml`: `bytes`, `map`, or the field of `Reading`.
    pub name: &'static str,
    /// Stage of decoding to which the step belongs.
    pub stage: Stage,
    /// True if a mistake in this step may cause a refusal. In the other steps, it only changes values.
    pub may_refuse: bool,
}

/// All steps: the bytes, the map, and the decisions in the order of `Reading`.
static STEPS: [Step; 37] = [
    may_refuse("bytes", File),
    only_changes_values("map", Planes),
    only_changes_values("light", Color),
    only_changes_values("polynomial", Color),
    only_changes_values("final_coefficient", Coefficients),
    only_changes_values("finals", Coefficients),
    may_refuse("entry_count", Decoding),
    may_refuse("after_table", Decoding),
    only_changes_values("lum_luminance", Color),
    only_changes_values("lum_chroma", Color),
    only_changes_values("lum_values", Color),
    only_changes_values("lum_vector", Color),
    only_changes_values("lum_matrix", Color),
    only_changes_values("lum_translation", Color),
    may_refuse("blocks", Decoding),
    only_changes_values("stored_row", Decoding),
    only_changes_values("texel_color", Color),
    only_changes_values("luminance", Color),
    only_changes_values("modulate", Color),
    only_changes_values("clamp", Color),
    may_refuse("indices", Decoding),
    may_refuse("index", Decoding),
    may_refuse("entry", Decoding),
    may_refuse("plan", Decoding),
    only_changes_values("predictor", Decoding),
    only_changes_values("invert", Decoding),
    only_changes_values("motion_sign", Decoding),
    only_changes_values("motion_vertical", Decoding),
    only_changes_values("motion_half", Decoding),
    only_changes_values("motion_border", Decoding),
    only_changes_values("predict", Decoding),
    only_changes_values("predict_jpeg_ls", Decoding),
    may_refuse("stream", Decoding),
    may_refuse("reconstruct", Decoding),
    only_changes_values("side_information", Decoding),
    may_refuse("records", Decoding),
    only_changes_values("correct", Decoding),
];

const fn may_refuse(name: &'static str, stage: Stage) -> Step {
    Step {
        name,
        stage,
        may_refuse: true,
    }
}

const fn only_changes_values(name: &'static str, stage: Stage) -> Step {
    Step {
        name,
        stage,
        may_refuse: false,
    }
}

impl Step {
    /// Returns the step with this name, if any.
    #[must_use]
    pub fn find(name: &str) -> Option<&'static Step> {
        STEPS.iter().find(|step| step.name == name)
    }

    /// Returns the formulas that describe the step. Most steps have none.
    pub(super) fn formulas(&self) -> Vec<Formula> {
        Formula::ALL
            .into_iter()
            .map(|(formula, _)| formula)
            .filter(|formula| formula.stated().step == Some(self.name))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Change;
    use ptm::reading::Reading;

    #[test]
    fn steps_are_the_decisions_of_a_reading_in_their_order() {
        let names: Vec<&str> = STEPS.iter().map(|step| step.name).collect();
        let decisions = Reading::SPEC.decisions().into_iter();
        let decisions: Vec<&str> = decisions.map(|(name, _)| name).collect();
        assert_eq!(names, [&["bytes", "map"], &decisions[..]].concat());
        for (formula, name) in Formula::ALL {
            let step = formula.stated().step;
            assert!(step.is_none_or(|step| decisions.contains(&step)), "{name}");
        }
    }

    #[test]
    fn misreadings_change_exactly_the_step_that_they_name() {
        for misreading in crate::behaviors() {
            let changed = match misreading.change {
                Change::Bytes(_) => vec!["bytes"],
                Change::Map(_) => vec!["map"],
                Change::Edits(_) => vec![],
                Change::Reading(change) => {
                    let mut reading = Reading::SPEC;
                    change(&mut reading);
                    reading.differences(&Reading::SPEC)
                }
            };
            let named: Vec<&str> = misreading.step.iter().map(|step| step.name).collect();
            assert_eq!(named, changed, "{}", misreading.slug);
        }
    }
}
