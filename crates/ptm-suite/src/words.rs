//! Templates in case records: `{key}` stands for one of the words that `for_each` lists.

use std::collections::BTreeMap;
use std::str::FromStr;

use crate::error::{Error, Result};

use serde::de::{DeserializeOwned, IntoDeserializer, value};

/// A combination of the words of `for_each`.
pub struct Words<'a>(Vec<(&'a str, &'a str)>);

impl<'a> Words<'a> {
    /// Returns every combination of words. The last key changes fastest.
    pub fn combinations(for_each: &'a BTreeMap<String, Vec<String>>) -> Vec<Words<'a>> {
        let mut all = vec![Vec::new()];
        for (key, words) in for_each {
            let longer = |taken: &Vec<(&'a str, &'a str)>| {
                let with =
                    |word: &'a String| [&taken[..], &[(key.as_str(), word.as_str())]].concat();
                words.iter().map(with).collect::<Vec<_>>()
            };
            all = all.iter().flat_map(longer).collect();
        }
        all.into_iter().map(Words).collect()
    }

    /// Replaces each `{key}` in `text` with its word, or with the value if the word has the form `name = value`.
    #[must_use]
    pub fn fill(&self, text: &str) -> String {
        self.replaced(text, |_, value| value.to_owned())
    }

    /// Replaces each `{key}` in an id template with the slug of its word, or of the name if the word is `name = value`.
    #[must_use]
    pub fn id(&self, text: &str) -> String {
        self.replaced(text, |name, _| slug(name))
    }

    /// Fills in the words in an optional text, parses the result, and stores the value in `slot`.
    ///
    /// # Errors
    /// Returns the error of `parse`.
    pub fn set<T, E>(
        &self,
        slot: &mut T,
        text: Option<&String>,
        parse: impl Fn(&str) -> Result<T, E>,
    ) -> Result<()>
    where
        Error: From<E>,
    {
        if let Some(text) = text {
            *slot = parse(&self.fill(text))?;
        }
        Ok(())
    }

    fn replaced(&self, text: &str, word: impl Fn(&str, &str) -> String) -> String {
        let fill = |text: String, (key, both): &(&str, &str)| {
            let (name, value) = both.split_once(" = ").unwrap_or((both, both));
            text.replace(&format!("{{{key}}}"), &word(name, value))
        };
        self.0.iter().fold(text.to_owned(), fill)
    }
}

pub(super) fn word<T: DeserializeOwned>(text: &str) -> Result<T> {
    let read: Result<T, value::Error> = T::deserialize(text.into_deserializer());
    read.map_err(|error| error.to_string().into())
}

/// Parses a decimal number, or a hexadecimal number with the prefix `0x`.
pub(super) fn number<T: FromStr>(name: &str, text: &str) -> Result<T> {
    let digits = text.strip_prefix("0x").map_or_else(
        || text.parse().ok(),
        |hex| u32::from_str_radix(hex, 16).ok()?.to_string().parse().ok(),
    );
    digits.ok_or_else(|| format!("expected a number for {name}, found {text:?}").into())
}

/// Parses a list of at least one number.
pub(super) fn numbers<T: FromStr>(name: &str, text: &str) -> Result<Vec<T>> {
    let words = text.split_whitespace();
    let list: Result<Vec<T>> = words.map(|word| number(name, word)).collect();
    match list {
        Ok(list) if list.is_empty() => Error::invalid(format!("expected numbers for {name}")),
        list => list,
    }
}

/// Returns true if `text` is the word `yes`, or false if it is the word `no`.
pub(super) fn yes_or_no(name: &str, text: &str, [yes, no]: [&str; 2]) -> Result<bool> {
    match text {
        _ if text == yes => Ok(true),
        _ if text == no => Ok(false),
        _ => Error::invalid(format!("expected {yes} or {no} for {name}, found {text:?}")),
    }
}

/// Parses `true` or `false`.
pub(super) fn flag(name: &str, text: &str) -> Result<bool> {
    yes_or_no(name, text, ["true", "false"])
}

/// Converts a word to the form used in ids: lowercase, with hyphens, and with the sign of a number spelled out.
fn slug(word: &str) -> String {
    let signed = word.starts_with(|c: char| c == '-' || c.is_ascii_digit());
    let minus = if signed { "minus " } else { "-" };
    let word = word.replace('-', minus).to_lowercase();
    word.replace(|c: char| !c.is_ascii_alphanumeric(), "-")
}
