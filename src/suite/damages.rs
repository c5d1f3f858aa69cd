//! The damages of `spec-cases/damages.yaml`.

use std::sync::LazyLock;

use crate::generate::Damage;
use crate::kit::yaml::records;

const FILE: &str = include_str!("../../spec-cases/damages.yaml");

static DAMAGES: LazyLock<Result<Vec<Damage>, String>> =
    LazyLock::new(|| read(FILE).map_err(|error| format!("damages.yaml: {error}")));

fn read(text: &str) -> Result<Vec<Damage>, String> {
    let mut damages: Vec<Damage> = Vec::new();
    for (line, damage) in records::<Damage>(text)? {
        if [&damage.name, &damage.clause, &damage.effect].contains(&&String::new()) {
            return Err(format!("line {line}: a damage has slug, clause and effect"));
        }
        if damages.iter().any(|other| other.name == damage.name) {
            return Err(format!("line {line}: {} is there twice", damage.name));
        }
        damages.push(damage);
    }
    Ok(damages)
}

/// Returns all damages, in the order of the file.
///
/// # Errors
/// A sentence that names the line at fault.
pub fn damages() -> Result<&'static [Damage], String> {
    DAMAGES.as_deref().map_err(Clone::clone)
}

/// Returns the damage of that name.
///
/// # Errors
/// If there is none.
pub fn named(name: &str) -> Result<&'static Damage, String> {
    let found = damages()?.iter().find(|damage| damage.name == name);
    found.ok_or_else(|| format!("unknown damage {name:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_error_names_its_line() {
        for (text, error) in [
            ("  replcae: { width: x }", "unknown field `replcae`"),
            ("  fit: yes", "invalid type"),
            (
                "  replace: { widht: x }",
                r#"unknown field in the place "widht""#,
            ),
            (
                "  end: \"plane[frist]\"",
                r#"unknown number in the place "plane[frist]""#,
            ),
            (
                "  flip: { \"plane[1].sof\": hex ff }",
                r#"unknown part in the place "plane[1].sof""#,
            ),
            ("  index: { second: entries }", "unknown variant `second`"),
            ("  needs: { coding: gif }", "unknown variant `gif`"),
            ("- slug: b", "a damage has slug, clause and effect"),
        ] {
            let text = format!("- slug: a\n  clause: 2.1/1\n  effect: it is wrong\n{text}\n");
            let said = read(&text).expect_err("it is no damage");
            assert!(said.starts_with(&format!("line 4: {error}")), "{said}");
        }
    }
}
