//! Ways to damage a file, from `spec-cases/damages.yaml`.

use std::sync::LazyLock;

use crate::error::{Error, Result};
use crate::kit::yaml::records;
use ptm_generate::Damage;

const FILE: &str = ptm_spec_cases::DAMAGES;

static DAMAGES: LazyLock<Result<Vec<Damage>>> =
    LazyLock::new(|| read(FILE).map_err(|error| error.in_place("damages.yaml")));

fn read(text: &str) -> Result<Vec<Damage>> {
    let mut damages: Vec<Damage> = Vec::new();
    for (line, damage) in records::<Damage>(text)? {
        if [&damage.name, &damage.clause, &damage.effect].contains(&&String::new()) {
            return Error::at_line(line, "expected slug, clause and effect");
        }
        if damages.iter().any(|other| other.name == damage.name) {
            return Error::at_line(line, format!("duplicate damage {}", damage.name));
        }
        damages.push(damage);
    }
    Ok(damages)
}

/// Returns all kinds of damage, in the order of `damages.yaml`.
///
/// # Errors
/// Returns a message that names the offending line.
pub fn damage_kinds() -> Result<&'static [Damage]> {
    DAMAGES.as_deref().map_err(Clone::clone)
}

/// Returns the damage with the given name.
///
/// # Errors
/// Returns an error if no damage has that name.
pub fn find(name: &str) -> Result<&'static Damage> {
    let found = damage_kinds()?.iter().find(|damage| damage.name == name);
    found.ok_or_else(|| Error::Invalid(format!("unknown damage {name:?}").into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ERRORS: &str = r#"
  replcae: { width: x } => line 4: unknown field `replcae`
  fit: yes => line 4: invalid type
  replace: { widht: x } => line 4: unknown field in the location "widht"
  end: "plane[frist]" => line 4: unknown number in the location "plane[frist]"
  flip: { "plane[1].sof": hex ff } => line 4: unknown part in the location "plane[1].sof"
  index: { second: entries } => line 4: unknown variant `second`
  needs: { coding: gif } => line 4: unknown variant `gif`
- slug: b => line 4: expected slug, clause and effect
"#;

    #[test]
    fn every_error_names_its_line() {
        for row in ERRORS.trim_matches('\n').lines() {
            let (text, error) = row.split_once(" => ").expect("a text and its error");
            let text = format!("- slug: a\n  clause: 2.1/1\n  effect: it is wrong\n{text}\n");
            let message = read(&text).expect_err("not a damage").to_string();
            assert!(message.starts_with(error), "{message}");
        }
    }
}
