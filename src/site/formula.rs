//! Formulas: conversion of a line of text to `MathML`.
//!
//! Letters are names, digits numbers; `_` and `^` make subscripts and superscripts, braces group, `√(…)` is a root. All other
//! characters are operators.

use std::iter::Peekable;
use std::str::Chars;

use maud::{Markup, PreEscaped, html};

/// Returns a display formula.
pub(super) fn formula(text: &str) -> Markup {
    let mut chars = text.chars().peekable();
    html! { (PreEscaped("<math display=\"block\">")) (row(&mut chars, None)) (PreEscaped("</math>")) }
}

/// Reads everything up to and including `end`.
fn row(chars: &mut Peekable<Chars>, end: Option<char>) -> Markup {
    let mut parts = Vec::new();
    // Two names separated only by a space keep that space.
    let mut after_name = false;
    while let Some(&next) = chars.peek() {
        if Some(next) == end {
            chars.next();
            break;
        }
        if next == ' ' {
            chars.next();
            continue;
        }
        let is_name = next.is_alphanumeric();
        if is_name && after_name {
            parts.push(PreEscaped("<mspace width=\".4em\"></mspace>".to_owned()));
        }
        after_name = is_name;
        parts.push(scripted_atom(chars));
    }
    html! { (PreEscaped("<mrow>")) @for part in parts { (part) } (PreEscaped("</mrow>")) }
}

/// Reads an atom with its subscript and superscript.
fn scripted_atom(chars: &mut Peekable<Chars>) -> Markup {
    let base = atom(chars);
    let mut script = |sign| {
        let stands = chars.next_if_eq(&sign).is_some();
        stands.then(|| match chars.next_if_eq(&'{') {
            Some(_) => row(chars, Some('}')),
            None => atom(chars),
        })
    };
    let (below, above) = (script('_'), script('^'));
    let tagged = |tag: &str, parts: &[&Markup]| {
        let inside: String = parts.iter().map(|part| part.0.as_str()).collect();
        PreEscaped(format!("<{tag}>{inside}</{tag}>"))
    };
    match (below, above) {
        (Some(below), Some(above)) => tagged("msubsup", &[&base, &below, &above]),
        (Some(below), None) => tagged("msub", &[&base, &below]),
        (None, Some(above)) => tagged("msup", &[&base, &above]),
        (None, None) => base,
    }
}

fn atom(chars: &mut Peekable<Chars>) -> Markup {
    let Some(first) = chars.next() else {
        return PreEscaped(String::new());
    };
    if first == '√' && chars.next_if_eq(&'(').is_some() {
        return PreEscaped(format!("<msqrt>{}</msqrt>", row(chars, Some(')')).0));
    }
    let (tag, belongs): (&str, fn(char) -> bool) = if first.is_ascii_digit() {
        ("mn", |c| c.is_ascii_digit() || c == '.')
    } else if first.is_alphabetic() {
        ("mi", |c| c.is_alphanumeric() || c == '′')
    } else {
        ("mo", |c| c == '>')
    };
    let mut word = first.to_string();
    while let Some(next) = chars.next_if(|&next| belongs(next)) {
        word.push(next);
    }
    let inside = html! { (word) }.0;
    PreEscaped(format!("<{tag}>{inside}</{tag}>"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn becomes(text: &str, inside: &str) {
        let whole = format!("<math display=\"block\"><mrow>{inside}</mrow></math>");
        assert_eq!(formula(text).0, whole);
    }

    #[test]
    fn names_numbers_and_scripts_are_set() {
        becomes("a_0", "<msub><mi>a</mi><mn>0</mn></msub>");
        becomes("L_u^2", "<msubsup><mi>L</mi><mi>u</mi><mn>2</mn></msubsup>");
        becomes(
            "m_{4·c}",
            "<msub><mi>m</mi><mrow><mn>4</mn><mo>·</mo><mi>c</mi></mrow></msub>",
        );
        becomes("1 >> 2", "<mn>1</mn><mo>&gt;&gt;</mo><mn>2</mn>");
        becomes("√(1)", "<msqrt><mrow><mn>1</mn></mrow></msqrt>");
        becomes(
            "x mod y",
            "<mi>x</mi><mspace width=\".4em\"></mspace><mi>mod</mi><mspace width=\".4em\"></mspace><mi>y</mi>",
        );
    }
}
