//! In which files a mistake is made.

use super::traits::{QUANTITIES, TRAITS, traits};
use crate::diagnose::witness::Witness;
use crate::ptm::Format;

/// A set of files, by what holds of them.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::diagnose) enum Scope {
    All,
    Formats(Vec<Format>),
    /// Files with a trait, by its place.
    Trait(usize),
    /// Files with two.
    Both(usize, usize),
    /// Files of which a quantity, by its place, is at least, or at most, so much; others reach so far.
    Beyond {
        quantity: usize,
        nearest: f64,
        more: bool,
        edge: f64,
    },
}

impl Scope {
    pub fn holds(&self, witness: &Witness) -> bool {
        match self {
            Scope::All => true,
            Scope::Formats(formats) => formats.contains(&witness.case.format()),
            Scope::Trait(one) => traits(witness).has[*one],
            Scope::Both(a, b) => traits(witness).has[*a] && traits(witness).has[*b],
            Scope::Beyond {
                quantity,
                nearest,
                more,
                ..
            } => traits(witness).quantities[*quantity].is_some_and(|value| match more {
                true => value >= *nearest,
                false => value <= *nearest,
            }),
        }
    }

    /// Whether it is the light that was asked for: what is done before the polynomial does not depend on it.
    pub fn is_of_light(&self) -> bool {
        self.is_of(|says| says.starts_with("under a light"))
    }

    /// Whether it is bytes of the binary data: what is computed does not depend on them.
    pub fn is_of_bytes(&self) -> bool {
        self.is_of(|says| {
            says.contains("first byte after the header") || says.contains("binary data")
        })
    }

    /// Whether it is numbers of the header: what is stored does not depend on them.
    pub fn is_of_numbers(&self) -> bool {
        let words = [
            "scale",
            "bias",
            "number in the header",
            "number of the matrix",
        ];
        let is_of = |one: &usize| {
            let says = &TRAITS[*one].says;
            !says.starts_with("whose scales and biases stand")
                && words.iter().any(|word| says.contains(word))
        };
        match self {
            Scope::All | Scope::Formats(_) => false,
            Scope::Trait(one) => is_of(one),
            Scope::Both(a, b) => is_of(a) || is_of(b),
            Scope::Beyond { quantity, .. } => {
                let after = QUANTITIES[*quantity].words[1];
                words.iter().any(|word| after.contains(word))
            }
        }
    }

    /// The clause of the number that files have so much of, or that is spelled so; nothing for other things they share.
    pub fn clause(&self) -> Option<&'static str> {
        match self {
            Scope::Beyond { quantity, .. } => Some(QUANTITIES[*quantity].clause),
            Scope::Trait(one) => TRAITS[*one].clause,
            _ => None,
        }
    }

    fn is_of(&self, what: fn(&str) -> bool) -> bool {
        let is = |one: usize| what(&TRAITS[one].says);
        match self {
            Scope::All | Scope::Formats(_) => false,
            Scope::Trait(one) => is(*one),
            Scope::Both(a, b) => is(*a) || is(*b),
            Scope::Beyond { quantity, .. } => what(QUANTITIES[*quantity].words[0]),
        }
    }

    /// The same without the formats of which this is not so.
    pub fn of_formats(&self, is_so: impl Fn(Format) -> bool) -> Scope {
        match self {
            Scope::Formats(formats) => {
                Scope::Formats(formats.iter().copied().filter(|&one| is_so(one)).collect())
            }
            other => other.clone(),
        }
    }

    /// Completes "every file …".
    pub fn says(&self) -> String {
        match self {
            Scope::All => String::new(),
            Scope::Formats(formats) => {
                let names: Vec<&str> = formats.iter().map(|format| format.short_name()).collect();
                format!("of format {}", names.join(", "))
            }
            Scope::Trait(one) => TRAITS[*one].says.clone(),
            Scope::Both(a, b) => format!("{} and {}", TRAITS[*a].says, TRAITS[*b].says),
            Scope::Beyond {
                quantity,
                nearest,
                more,
                edge,
            } => {
                let [before, after] = QUANTITIES[*quantity].words;
                let side = if *more { "more" } else { "less" };
                let number = |value: &f64| {
                    let text = format!("{value:.3}");
                    text.trim_end_matches('0').trim_end_matches('.').to_owned()
                };
                format!(
                    "{before} {} or {side} {after} (it reads {})",
                    number(nearest),
                    number(edge)
                )
            }
        }
    }
}
